//! `order --data`: an order from a table of values on several grids.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use verify::measure::order::Verdict;
use verify::measure::refinement::data::{Spacing, read};
use verify::measure::refinement::least_squares::Form;
use verify::measure::refinement::three_grids::Triplet;
use verify::measure::refinement::{BAND, Judgement, Quantity, Question, overall};
use verify::program::Shown;

use super::{Args, Format, picture, word};
use crate::cli::Status;
use crate::cli::args::finite;
use crate::cli::error::Failure;
use crate::cli::layout::{counted, number, paragraph, right, significant, trimmed};

/// A table of values instead of a method and a problem.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Data of your own")]
pub(super) struct DataArgs {
    /// Judge a CSV table of values on several grids, one a row; - reads it from
    /// standard input
    #[arg(long, value_name = "FILE", conflicts_with_all = ["name", "model", "method", "reference", "t_end"])]
    pub(super) data: Option<PathBuf>,

    /// Column with the spacing of the grid, or the time step
    #[arg(long, value_name = "COLUMN", requires = "data", conflicts_with = "cells")]
    step: Option<String>,

    /// Column with the number of cells instead, with --dimension: h = N^(-1/D)
    #[arg(long, value_name = "COLUMN", requires = "data")]
    cells: Option<String>,

    /// Dimension D of the grid
    #[arg(long, value_name = "D", requires = "cells", value_parser = clap::value_parser!(u32).range(1..=3))]
    dimension: Option<u32>,

    /// Column to judge, repeatable; all but the spacing by default
    #[arg(long, value_name = "COLUMN")]
    quantity: Vec<String>,

    /// Exact value of the quantity
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true, value_parser = finite)]
    exact: Option<f64>,
}

impl DataArgs {
    fn spacing(&self) -> Result<Option<Spacing>, Failure> {
        match (&self.step, &self.cells, self.dimension) {
            (Some(column), _, _) => Ok(Some(Spacing::Step(column.clone()))),
            (_, Some(column), Some(dimension)) => Ok(Some(Spacing::Cells { column: column.clone(), dimension })),
            (_, Some(_), None) => Err(Failure::Incomplete("--cells", "--dimension 1, 2 or 3")),
            _ => Ok(None),
        }
    }

    /// The options that are given and are of tables alone.
    pub(super) fn given(&self) -> impl Iterator<Item = &'static str> {
        let given = [
            ("--step", self.step.is_some()),
            ("--cells", self.cells.is_some()),
            ("--dimension", self.dimension.is_some()),
        ];
        given.into_iter().filter_map(|(option, is_given)| is_given.then_some(option))
    }

    /// The options that are given and are of quantities, from a table or from runs that are compared with each other.
    pub(super) fn given_of_quantities(&self) -> impl Iterator<Item = &'static str> {
        let given = [("--quantity", !self.quantity.is_empty()), ("--exact", self.exact.is_some())];
        given.into_iter().filter_map(|(option, is_given)| is_given.then_some(option))
    }

    /// Reads the table in `path`.
    pub(super) fn read(&self, path: &Path) -> Result<Vec<Quantity>, Failure> {
        let file: Box<dyn Read> = match path.to_str() {
            Some("-") => Box::new(io::stdin()),
            _ => Box::new(File::open(path).map_err(|source| Failure::Read { path: path.into(), source })?),
        };
        let quantities = read(file, self.spacing()?.as_ref(), &self.quantity);
        quantities.map_err(|source| Failure::Data { path: path.into(), source: Box::new(source) })
    }

    /// The columns asked for, if any is.
    pub(super) fn columns(&self) -> Option<&[String]> {
        (!self.quantity.is_empty()).then_some(&*self.quantity)
    }

    /// Judges quantities, from a table or from runs.
    pub(super) fn judge(
        &self,
        (quantities, shown): (&[Quantity], &Shown),
        args: &Args,
        out: &mut impl Write,
    ) -> Result<Status, Failure> {
        if self.exact.is_some() && quantities.len() > 1 {
            return Err(Failure::Incomplete("--exact", "--quantity COLUMN, the one whose value it is"));
        }
        let question = Question { expected: args.expect, band: args.band.unwrap_or(BAND), exact: self.exact };
        let mut judgements: Vec<Judgement> = quantities.iter().map(|quantity| quantity.judge(&question)).collect();
        if let Some(reason) = &shown.incomparable {
            judgements.iter_mut().for_each(|judgement| judgement.leave_open(reason));
        }
        if let Some((column, dimension)) = self.cells.as_ref().zip(self.dimension) {
            let hint = |judgement: &mut Judgement| {
                judgement.notes.extend(judgement.may_be_per_side(column, dimension, &question));
            };
            judgements.iter_mut().for_each(hint);
        }
        let verdict = overall(&judgements);
        // An order that is the one expected is limited by nothing.
        let start = shown.start.iter().filter(|_| verdict != Verdict::Pass);
        let notes: &[String] = &shown.notes.iter().chain(start).cloned().collect::<Vec<_>>();
        let all_notes = || notes.iter().chain(judgements.iter().flat_map(|judgement| &judgement.notes));
        let results: Vec<Summary<'_>> =
            quantities.iter().zip(&judgements).map(|(q, j)| Summary::new(q, j, notes)).collect();
        match args.format {
            Format::Json => match &results[..] {
                [result] => serde_json::to_writer_pretty(&mut *out, result).map_err(io::Error::from),
                results => {
                    let all = serde_json::json!({ "verdict": verdict, "quantities": results });
                    serde_json::to_writer_pretty(&mut *out, &all).map_err(io::Error::from)
                }
            }
            .and_then(|()| writeln!(out)),
            Format::Table => quantities
                .iter()
                .zip(&judgements)
                .enumerate()
                .try_for_each(|(i, (q, j))| {
                    if i > 0 {
                        writeln!(out)?;
                    }
                    write_table(q, j, out)
                })
                .and_then(|()| all_notes().try_for_each(|note| paragraph(out, "\nNote: ", 6, note))),
            Format::Markdown => write_markdown(&results, out)
                .and_then(|()| all_notes().try_for_each(|note| writeln!(out, "\n- {note}"))),
        }
        .map_err(Failure::Output)?;
        if let Some(path) = &args.picture {
            picture::write(&picture::of_values(quantities, &judgements, args.expect), path)?;
        }
        Ok(verdict.into())
    }
}

/// A value as it was given, cut to nine digits where it has more.
fn given(x: f64) -> String {
    trimmed(x, 9)
}

/// One quantity as JSON has it; the help states the schema.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    quantity: &'a str,
    grids: usize,
    order: Option<f64>,
    order_uncertainty: Option<f64>,
    extrapolated: Option<f64>,
    gci_fine: Option<f64>,
    celik: Option<Celik>,
    convergence: String,
    triplet_orders: Vec<Option<f64>>,
    pair_orders: &'a [f64],
    least_squares: Option<Fitted>,
    verdict: Verdict,
    reason: &'a str,
    notes: Vec<&'a str>,
}

/// The procedure of Celik et al. (2008) on the three finest grids. It takes the sizes of differences, so that those that alternate in
/// sign have an order as well: a formal one.
#[derive(Debug, Serialize)]
struct Celik {
    order: f64,
    formal: bool,
    limit: f64,
    approximate_error: f64,
    extrapolated_error: f64,
    gci_fine: f64,
    gci_medium: f64,
}

impl From<&Triplet> for Celik {
    fn from(triplet: &Triplet) -> Self {
        Self {
            order: triplet.order,
            formal: triplet.oscillates,
            limit: triplet.limit,
            approximate_error: triplet.approximate_error,
            extrapolated_error: triplet.extrapolated_error,
            gci_fine: triplet.gci,
            gci_medium: triplet.gci_coarse,
        }
    }
}

#[derive(Debug, Serialize)]
struct Fitted {
    form: &'static str,
    weighted: bool,
    grids: usize,
    limit: f64,
    deviation: f64,
    uncertainty: f64,
}

impl<'a> Summary<'a> {
    fn new(quantity: &'a Quantity, judgement: &'a Judgement, notes: &'a [String]) -> Self {
        let fitted = judgement.least_squares.map(|fit| Fitted {
            form: form_text(fit.form),
            weighted: fit.weighted,
            grids: judgement.used,
            limit: fit.limit,
            deviation: fit.deviation,
            uncertainty: fit.uncertainty,
        });
        Self {
            quantity: &quantity.name,
            grids: quantity.grids.len(),
            order: judgement.order,
            order_uncertainty: judgement.uncertainty,
            extrapolated: judgement.extrapolated,
            gci_fine: judgement.gci,
            celik: judgement.triplets.last().and_then(|triplet| triplet.as_ref().ok()).map(Celik::from),
            convergence: judgement.convergence.to_string(),
            triplet_orders: judgement.triplets.iter().map(|t| t.ok()?.power_order()).collect(),
            pair_orders: &judgement.pairs,
            least_squares: fitted,
            verdict: judgement.verdict,
            reason: &judgement.reason,
            notes: notes.iter().chain(&judgement.notes).map(String::as_str).collect(),
        }
    }
}

fn form_text(form: Form) -> &'static str {
    match form {
        Form::Power => "a + b h^p",
        Form::First => "a + b h",
        Form::Second => "a + b h^2",
        Form::Both => "a + b h + c h^2",
    }
}

fn write_table(quantity: &Quantity, judgement: &Judgement, out: &mut impl Write) -> io::Result<()> {
    let mut grids = quantity.grids.clone();
    grids.sort_by(|a, b| b.h.total_cmp(&a.h));
    writeln!(out, "{}, {}\n", quantity.name, counted(grids.len(), "grid"))?;
    writeln!(out, "{:>12} {:>15} {:>12} {:>9}", "h", "value", "difference", "order")?;
    for (i, grid) in grids.iter().enumerate() {
        let before = i.checked_sub(1).and_then(|i| Some(grid.value? - grids[i].value?));
        // With an exact value an order belongs to two grids, else to three.
        let order = match judgement.pairs.is_empty() {
            false => i.checked_sub(1).and_then(|i| judgement.pairs.get(i).copied()),
            true => i.checked_sub(2).and_then(|i| judgement.triplets.get(i)?.ok()?.power_order()),
        };
        let cell = |x: Option<f64>, digits: usize| {
            // Errors of zero have no order.
            x.filter(|x| x.is_finite()).map_or_else(|| "—".into(), |x| significant(x, digits))
        };
        writeln!(
            out,
            "{} {} {} {}",
            right(&number(grid.h), 12),
            right(&grid.value.map_or_else(|| "—".into(), given), 15),
            right(&cell(before, 4), 12),
            right(&cell(order, 4), 9)
        )?;
    }
    writeln!(out)?;
    let mut line = |name: &str, text: String| paragraph(out, &format!("{name}  "), 15, &text);
    let finest = judgement.triplets.last().and_then(|triplet| triplet.ok());
    let only = if judgement.triplets.len() > 1 { ", on the finest three grids" } else { "" };
    line("convergence", format!("{}{only}", judgement.convergence))?;
    // Where order and limit are from, and what the uncertainty covers.
    let (from, covers) = match (judgement.pairs.is_empty(), judgement.triplets.len()) {
        (false, _) => ("errors against the exact value".to_owned(), "scatter and digits"),
        (true, 1) => ("three grids".to_owned(), "the digits alone"),
        (true, _) => (format!("power law on {} grids", judgement.used), "scatter, drift and digits"),
    };
    if let Some(order) = judgement.order {
        let uncertainty = judgement.uncertainty.map(|u| (format!(" ± {}", significant(u, 2)), format!("; ± {covers}")));
        let (value, covers) = uncertainty.unwrap_or_default();
        line("order", format!("{}{value} ({from}{covers})", significant(order, 5)))?;
    }
    if let Some(limit) = judgement.extrapolated {
        let with = if judgement.pairs.is_empty() { "with that order" } else { "as given" };
        line("extrapolated", format!("{} ({with})", significant(limit, 8)))?;
    }
    if let (Some(gci), Some(triplet)) = (judgement.gci, finest) {
        let (percent, order) = (significant(100.0 * gci, 6), significant(triplet.order, 4));
        // Without the finest grids of all, where these are at a floor.
        let of = if judgement.triplets.len() + 2 < grids.len() { ", without those left out" } else { "" };
        let text = format!("{percent} % of the value (Celik et al. 2008), p = {order} of the finest three{of}");
        let medium = format!("; of the medium one {} %", significant(100.0 * triplet.gci_coarse, 6));
        line(
            "GCI, fine",
            if gci.is_finite() { text + &medium } else { "none, being a part of the value, which is 0".into() },
        )?;
    }
    if let Some(triplet) = finest.filter(|triplet| triplet.oscillates) {
        let [order, limit] = [(triplet.order, 4), (triplet.limit, 8)].map(|(x, digits)| significant(x, digits));
        let [fine, medium] = [triplet.gci, triplet.gci_coarse].map(|gci| significant(100.0 * gci, 3));
        let text = format!(
            "p = {order}, limit {limit}, GCI {fine} % and on the medium grid {medium} %, by the procedure of Celik et al. (2008), which \
             takes the sizes of differences: those that alternate in sign follow no power law"
        );
        line("formal", text)?;
    }
    if let Some(fit) = judgement.least_squares {
        let weights = if fit.weighted { ", weighted" } else { "" };
        let order =
            fit.power.filter(|_| fit.form == Form::Power).map(|power| format!(", p = {}", significant(power.order, 4)));
        let text = format!(
            "{}{weights}{} on {} grids: limit {}, uncertainty {} (Eça and Hoekstra 2014)",
            form_text(fit.form),
            order.unwrap_or_default(),
            judgement.used,
            significant(fit.limit, 8),
            significant(fit.uncertainty, 4)
        );
        line("least squares", text)?;
    }
    writeln!(out)?;
    let verdict = word(judgement.verdict);
    paragraph(out, &format!("{verdict}: "), verdict.len() + 2, &judgement.reason)
}

fn write_markdown(results: &[Summary<'_>], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "| quantity | grids | order | extrapolated | GCI, fine | convergence | verdict |")?;
    writeln!(out, "|---|---|---|---|---|---|---|")?;
    for result in results {
        let cell = |x: Option<f64>, digits: usize| x.map_or_else(|| "—".into(), |x| significant(x, digits));
        let verdict = serde_json::to_value(result.verdict)?;
        writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {}: {} |",
            result.quantity.replace('|', "\\|"),
            result.grids,
            cell(result.order, 4),
            cell(result.extrapolated, 7),
            result
                .gci_fine
                .filter(|gci| gci.is_finite())
                .map_or_else(|| "—".into(), |gci| format!("{} %", significant(100.0 * gci, 3))),
            result.convergence,
            verdict.as_str().unwrap_or_default(),
            result.reason.replace('|', "\\|")
        )?;
    }
    Ok(())
}

impl From<Verdict> for Status {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Pass | Verdict::Measured => Self::Ok,
            Verdict::Fail => Self::Failed,
            Verdict::Inconclusive => Self::Inconclusive,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As many grids as asked for, with errors of second order.
    fn quantity(name: &str, grids: u32) -> Quantity {
        let grid = |k: u32| {
            let h = 0.5_f64.powi(k as i32);
            verify::measure::refinement::Grid { h, value: Some(1.0 + h * h) }
        };
        Quantity { name: name.into(), grids: (0..grids).map(grid).collect(), resolution: 0.0 }
    }

    fn table(quantity: &Quantity, judgement: &Judgement) -> String {
        let mut out = Vec::new();
        write_table(quantity, judgement, &mut out).expect("written");
        String::from_utf8(out).expect("UTF-8")
    }

    #[test]
    fn of_three_grids_none_is_left_out_and_none_is_coarser() {
        for (grids, is_finest) in [(3, false), (4, true)] {
            let quantity = quantity("u", grids);
            let text = table(&quantity, &quantity.judge(&Question::default()));
            let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
            assert_eq!(text.contains("on the finest three grids"), is_finest, "{text}");
            assert!(text.contains("GCI, fine") && !text.contains("without those left out"), "{text}");
        }
    }

    #[test]
    fn a_long_reason_stands_right_of_the_verdict() {
        let quantity = quantity("u", 3);
        let judgement = Judgement {
            reason: "word ".repeat(crate::cli::layout::columns() / 4),
            ..quantity.judge(&Question::default())
        };
        let text = table(&quantity, &judgement);
        let (first, more) = text.trim_end().rsplit_once('\n').expect("two lines");
        let first = first.lines().last().expect("a line");
        assert!(first.contains(": word") && first.find("word") == more.find("word"), "{text}");
    }

    /// What is written of quantities with these options.
    fn judged(options: &[&str], quantities: &[Quantity]) -> Result<String, Failure> {
        #[derive(clap::Parser)]
        struct Asked {
            #[command(flatten)]
            args: Args,
        }
        let words = ["order", "--data", "x.csv"].iter().chain(options);
        let args = <Asked as clap::Parser>::try_parse_from(words).expect("it makes sense").args;
        let mut out = Vec::new();
        let judged = args.data.judge((quantities, &Shown::default()), &args, &mut out);
        judged.map(|_| String::from_utf8(out).expect("UTF-8"))
    }

    /// Of four grids, of which the coarsest three have another order; the ratio is 2.
    #[test]
    fn the_procedure_of_celik_is_told_of_the_finest_three_grids() {
        let mut f = quantity("f", 4);
        f.grids.iter_mut().zip([0.50, 0.30, 0.245, 0.2305]).for_each(|(grid, value)| grid.value = Some(value));
        let json = judged(&["--format", "json"], &[f]).expect("judged");
        let celik = &serde_json::from_str::<serde_json::Value>(&json).expect("JSON")["celik"];
        let (fine, medium) = (0.245 - 0.2305, 0.30 - 0.245);
        // What extrapolation takes from the finest value, by 2^p = medium / fine.
        let taken: f64 = fine / (medium / fine - 1.0);
        for (name, value) in [
            ("order", (medium / fine).log2()),
            ("limit", 0.2305 - taken),
            ("gci_fine", 1.25 * taken / 0.2305),
            ("gci_medium", 1.25 * taken * medium / fine / 0.245),
        ] {
            let told = celik[name].as_f64().expect("a number");
            assert!((told - value).abs() < 1e-12, "{name}: {told}, and it is {value}");
        }
    }

    #[test]
    fn a_blank_line_stands_between_quantities() {
        let quantities = ["u", "v"].map(|name| quantity(name, 3));
        let exact = |quantities: &[Quantity]| judged(&["--exact", "1"], quantities).is_ok();
        assert!(exact(&quantities[..1]) && !exact(&quantities), "an exact value is that of one quantity");
        let text = judged(&[], &quantities).expect("judged");
        assert!(text.starts_with("u, 3 grids\n") && text.contains("\n\nv, 3 grids\n"), "{text}");
    }
}
