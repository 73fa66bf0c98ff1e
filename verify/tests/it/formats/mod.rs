//! One small run in every format: what each says is what the run has, and every colour, link and curve belongs to what it stands
//! beside.

mod counts;
mod curves;
mod faces;
mod links;

use std::path::Path;

use roxmltree::{Document, Node};
use verify::evidence::{
    Axis, Cell, Check, Evidence, Figure, Grid, Mark, Outcome, Panel, Requirement, Section, Series, Table,
};
use verify::report::{self, Chapter, Run};

use super::report::{fresh, read};

const OUTCOMES: [Outcome; 5] =
    [Outcome::Pass, Outcome::Fail, Outcome::Inconclusive, Outcome::NotSettled, Outcome::NotRun];
/// Sign, word, class and variable of the colour of each of them.
const FACES: [(&str, &str, &str, &str); 5] = [
    ("✓", "Pass", "pass", "--good"),
    ("✗", "Fail", "fail", "--bad"),
    ("?", "Inconclusive", "inconclusive", "--warn"),
    ("~", "Not settled", "not-settled", "--warn"),
    ("–", "Not run", "not-run", "--mute"),
];

/// Chapters with their numbers of checks by outcome, all different; whether they broke off, and the place in [`FACES`] of what
/// the contents say of them.
const CHAPTERS: [(&str, [usize; 5], bool, usize); 7] = [
    ("model", [3, 0, 0, 0, 0], false, 0),
    ("answers", [12, 0, 0, 0, 0], false, 0),
    ("claims", [7, 2, 3, 11, 5], false, 1),
    ("open", [4, 0, 6, 13, 8], false, 2),
    ("tried", [5, 0, 0, 14, 2], false, 3),
    ("idle", [9, 0, 0, 0, 10], false, 4),
    ("broken", [1, 0, 0, 0, 0], true, 1),
];

/// Verdict, class, colour, and how many claims have it.
const VERDICTS: [(&str, &str, &str, usize); 7] = [
    ("confirmed", "confirmed", "--good", 6),
    ("qualified", "qualified", "--warn", 5),
    ("refuted as stated", "refuted-as-stated", "--bad", 4),
    ("refuted in the wider reading", "refuted-in-the-wider-reading", "--warn", 3),
    ("not supported", "not-supported", "--warn", 3),
    ("answered", "answered", "--good", 2),
    ("open", "open", "--mute", 1),
];

const REASONS: [&str; 2] = ["not run: there is no CVODE", "not run: it takes minutes"];
const TRIED: [&str; 2] = ["the errors are too small", "the slopes still change"];
/// The names that have colours, in their order.
const METHODS: [&str; 3] = ["alpha", "beta", "gamma"];

fn statement(chapter: &str, outcome: Outcome, n: usize) -> String {
    format!("{outcome:?} number {n} of the chapter {chapter}")
}

fn checks(chapter: &str, counts: [usize; 5]) -> Vec<Check> {
    let of = |(outcome, count): (Outcome, usize)| {
        (0..count).map(move |n| Check {
            id: format!("{outcome:?}-{n}"),
            statement: statement(chapter, outcome, n),
            outcome,
            measured: (outcome != Outcome::NotRun).then(|| 1.0 / (n as f64 + 3.0)),
            required: None,
            reason: match outcome {
                Outcome::NotRun => REASONS[n % 2].into(),
                Outcome::NotSettled => TRIED[n % 2].into(),
                _ => String::new(),
            },
        })
    };
    OUTCOMES.into_iter().zip(counts).flat_map(of).collect()
}

fn section(id: &str, mark: &str, label: &str) -> Section {
    Section {
        id: id.into(),
        title: format!("What of {id}"),
        mark: mark.into(),
        paragraphs: vec![(label.into(), format!("The sentence of {id}."))],
        ..Section::default()
    }
}

/// Constant curves: the height tells which it is.
fn figure(id: &str, curves: &[(&str, f64, Mark)]) -> Figure {
    let series = |(label, height, mark): &(&str, f64, Mark)| {
        Series::new(*label, (0..5).map(|x| (f64::from(x), *height)).collect(), *mark)
    };
    let panel = Panel::new(Axis::linear("x"), Axis::linear("y").between(0.0, TOP), curves.iter().map(series).collect());
    Figure::new(id, format!("The picture of {id}."), format!("data-{id}"), [panel])
}

/// The end of the axis of every figure.
const TOP: f64 = 5.0;
const FIRST: [(&str, f64, Mark); 4] = [
    ("gamma", 3.0, Mark::LineMarkers),
    ("alpha", 1.0, Mark::Line),
    ("beta", 2.0, Mark::Markers),
    ("slope 2", 4.0, Mark::Guide),
];
const SECOND: [(&str, f64, Mark); 2] = [("beta", 2.0, Mark::LineMarkers), ("gamma", 3.0, Mark::LineMarkers)];
/// The first lies below the second.
const COVERED: [(&str, f64, Mark); 3] =
    [("alpha", 2.0, Mark::Line), ("beta", 2.0, Mark::Line), ("gamma", 3.0, Mark::Line)];

fn chapter((id, counts, is_broken, _): (&str, [usize; 5], bool, usize)) -> Chapter {
    let mut evidence = Evidence { checks: checks(id, counts), ..Evidence::default() };
    match id {
        "model" => evidence.sections.push(section("model-recommendation", "", "Answer")),
        "answers" => {
            evidence.sections = vec![section("first", "no", "Short"), section("second", "yes", "Short")];
            evidence.sections[1].figures.push("early".into());
            evidence.figures = vec![figure("early", &FIRST), figure("covered", &COVERED)];
        }
        "claims" => {
            let of = |(word, class, _, count): (&str, &str, &str, usize)| {
                (0..count).map(|n| section(&format!("S24-{class}-{n}"), word, "Evidence")).collect::<Vec<_>>()
            };
            evidence.sections = VERDICTS.into_iter().flat_map(of).collect();
            let row = |part: &Section| vec![Cell::from(&part.id), Cell::from(&part.mark)];
            let rows = evidence.sections.iter().map(row).collect();
            evidence.tables.push(Table::new("claims", "The verdicts.", ["id", "verdict"], rows));
        }
        "open" => {
            evidence.figures.push(figure("late", &SECOND));
            let rows = |count: i64| (0..count).map(|n| vec![Cell::Integer(n)]).collect();
            evidence.tables.push(Table::new("long", "A long table.", ["n"], rows(31)));
            evidence.tables.push(Table::new("full", "One that just fits a comment.", ["n"], rows(25)));
            let mut map = Grid::new("map", "A map.", 1);
            for (outcome, n) in [(Outcome::Pass, 2), (Outcome::Inconclusive, 1), (Outcome::Inconclusive, 4)] {
                map.push(&format!("{outcome:?}"), &format!("number {n}"), None, Some(0.0), format!("{outcome:?}-{n}"));
            }
            evidence.grids.push(map);
        }
        _ => {}
    }
    let tables = evidence.figures.iter().map(|figure| Table::data(&figure.data, "Data.", ["x"], Vec::new()));
    evidence.tables.extend(tables.collect::<Vec<_>>());
    Chapter {
        id: id.into(),
        title: format!("The {id} chapter"),
        evidence,
        error: is_broken.then(|| "out of luck".into()),
        ..Chapter::default()
    }
}

fn run() -> Run {
    // The places of the methods among all that have colours differ from those in any figure.
    let mut names: Vec<String> = (0..18).map(|n| format!("other-{n}")).collect();
    METHODS.iter().zip(PLACES).for_each(|(name, place)| names[place] = (*name).into());
    Run::new(CHAPTERS.map(chapter).into(), Vec::new()).with_palette(names)
}

/// Where they stand; eight later the colours begin again, with another dash.
const PLACES: [usize; 3] = [5, 1, 11];

/// Numbers of checks by outcome, counted here.
fn tally(chapters: &[Chapter]) -> [usize; 5] {
    let checks = || chapters.iter().flat_map(|chapter| &chapter.evidence.checks);
    OUTCOMES.map(|outcome| checks().filter(|check| check.outcome == outcome).count())
}

/// The page as a tree. Its markup is that of XML but for elements without content, and what scripts and styles hold.
fn page(directory: &Path) -> String {
    let mut page = read(directory, "index.html").replace("<!DOCTYPE html>", "").replace("<br>", " ");
    for name in ["script", "style"] {
        let (open, close) = (format!("<{name}"), format!("</{name}>"));
        while let Some(start) = page.find(&open) {
            let end = start + page[start..].find(&close).expect("it is closed") + close.len();
            page.replace_range(start..end, "");
        }
    }
    for name in ["meta", "link"] {
        let open = format!("<{name}");
        let mut parts = page.split(&open);
        let mut closed = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (attributes, rest) = part.split_once('>').expect("a tag ends");
            closed += &format!("{open}{attributes}/>{rest}");
        }
        page = closed;
    }
    page
}

fn written(name: &str, run: &Run) -> std::path::PathBuf {
    let path = fresh(name);
    report::write(run, &path).expect("the report is written");
    path
}

fn text(node: Node) -> String {
    let text: String = node.descendants().filter(Node::is_text).filter_map(|node| node.text()).collect();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn classes<'a>(node: &Node<'a, '_>) -> Vec<&'a str> {
    node.attribute("class").map(|class| class.split(' ').collect()).unwrap_or_default()
}

fn with_class<'a, 'b>(node: Node<'a, 'b>, class: &str) -> Vec<Node<'a, 'b>> {
    node.descendants().filter(|node| classes(node).contains(&class)).collect()
}

fn with_tag<'a, 'b>(node: Node<'a, 'b>, names: &[&str]) -> Vec<Node<'a, 'b>> {
    node.descendants().filter(|node| node.is_element() && names.contains(&node.tag_name().name())).collect()
}

/// The one element of this identifier.
fn element<'a, 'b>(document: &'b Document<'a>, id: &str) -> Node<'b, 'a> {
    let found: Vec<_> = document.descendants().filter(|node| node.attribute("id") == Some(id)).collect();
    assert_eq!(found.len(), 1, "elements `{id}`");
    found[0]
}

/// The only one of them.
fn only<T: Copy>(found: &[T]) -> T {
    assert_eq!(found.len(), 1);
    found[0]
}
