//! Maps of checks: a cell for each, with a key to its colours.

use maud::{Markup, html};

use super::super::text::{anchor, clean};
use super::{check_anchor, class, inline, permalink};
use crate::evidence::{Grid, Outcome};
use crate::report::run::Chapter;

/// Shades of a passed check, from far below its bound to at it.
const SHADES: usize = 4;
/// The class of a cell where theory predicts that the two differ, and they do.
const PREDICTED: &str = "predicted";

/// A map; each cell leads to its check.
pub(super) fn map(grid: &Grid, chapter: &Chapter) -> Markup {
    let id = anchor(&format!("grid:{}", grid.id));
    let cell_at = |row, column| {
        let cell = grid.cells.iter().find(|cell| (cell.row, cell.column) == (row, column))?;
        let check = chapter.check(&cell.check)?;
        Some((shade(check.outcome, cell.strain), show(cell.value, grid.decimals, cell.strain.is_none()), check))
    };
    let found = grid.cells.iter().filter_map(|cell| Some(shade(chapter.check(&cell.check)?.outcome, cell.strain)));
    let found: Vec<String> = found.collect();
    html! {
        div.table.map id=(id) {
            p.caption id=(format!("{id}-caption")) { (inline(&grid.caption)) " " (permalink(&id, "map")) }
            (key(&found))
            div.scroll tabindex="0" role="region" aria-labelledby=(format!("{id}-caption")) {
                table.grid aria-labelledby=(format!("{id}-caption")) {
                    thead { tr { td {} @for name in &grid.columns { th scope="col" { span { (clean(name)) } } } } }
                    tbody {
                        @for (row, name) in grid.rows.iter().enumerate() {
                            tr {
                                th scope="row" { (clean(name)) }
                                @for column in 0..grid.columns.len() {
                                    @match cell_at(row, column) {
                                        Some((class, text, check)) => {
                                            td.(class) { a href=(format!("#{}", check_anchor(chapter, &check.id))) { (text) } }
                                        }
                                        None => { td {} }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Through a fixed number of digits, so that a column can be read down; no sign before a zero.
fn show(value: Option<f64>, decimals: usize, is_predicted: bool) -> String {
    match value {
        Some(value) if value.is_finite() => {
            let text = format!("{value:+.decimals$}");
            if text.trim_start_matches(['+', '-', '0', '.']).is_empty() {
                text[1..].to_owned()
            } else {
                text.replace('-', "−")
            }
        }
        Some(_) => "∞".into(),
        None if is_predicted => "≠".into(),
        None => "–".into(),
    }
}

/// The class of a cell: what came out, and in shades how near a passed check came to its bound.
fn shade(outcome: Outcome, strain: Option<f64>) -> String {
    match (outcome, strain) {
        (Outcome::Pass, Some(strain)) => format!("p{}", (strain.clamp(0.0, 1.0) * (SHADES - 1) as f64).round()),
        (Outcome::Pass, None) => PREDICTED.into(),
        (other, _) => class(other).into(),
    }
}

/// What the colours of the cells mean, those that there are.
fn key(found: &[String]) -> Markup {
    let has = |class: &str| found.iter().any(|known| known == class);
    let single = [
        (PREDICTED, "differs or breaks down, as predicted (≠ without a number)"),
        (class(Outcome::Fail), "fails"),
        (class(Outcome::Inconclusive), "not decided"),
        (class(Outcome::NotSettled), "tried, not settled"),
        (class(Outcome::NotRun), "– not run"),
    ];
    html! {
        ul.key {
            @if (0..SHADES).any(|shade| has(&format!("p{shade}"))) {
                li { @for shade in 0..SHADES { span.swatch.(format!("p{shade}")) {} } " holds, far below its bound to near it" }
            }
            @for (class, text) in single {
                @if has(class) { li { span.swatch.(class) {} " " (text) } }
            }
            li.keys { "The arrow keys go from cell to cell." }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_has_its_shades_from_far_below_a_bound_to_near_it() {
        let markup = key(&["p2".into()]).into_string();
        let shades: Vec<&str> = markup.split("swatch ").skip(1).map(|rest| &rest[..2]).collect();
        let near = [0.0, 0.4, 0.7, 1.0].map(|strain| shade(Outcome::Pass, Some(strain)));
        assert_eq!(shades, near, "{markup}");
    }

    #[test]
    fn a_predicted_difference_does_not_look_like_an_agreement() {
        assert_eq!(shade(Outcome::Pass, None), PREDICTED);
        assert_eq!(shade(Outcome::Pass, Some(0.9)), "p3");
        assert_eq!(shade(Outcome::Fail, None), "fail");
        assert_eq!([show(None, 1, true), show(None, 1, false), show(Some(8.03), 1, true)], ["≠", "–", "+8.0"]);
        let markup = key(&[PREDICTED.into(), "p0".into()]).into_string();
        assert!(markup.contains("as predicted") && markup.contains("holds") && !markup.contains("fails"), "{markup}");
    }
}
