//! `compare`: every solver of a problem against every other.

use std::io::{self, Write};

use verify::chapter::cross_check;
use verify::compare::{Guest, compare};
use verify::evidence::{Cell, Evidence, Outcome, Table};
use verify::judge::FileMethod;
use verify::method::{self, Method};
use verify::order::OrderError;
use verify::program::Request;

use super::Status;
use super::args::{self, ProblemArgs};
use super::error::Failure;
use super::layout::{columns, left, paragraph, right, significant, width};
use super::output::Output;

const HEADING: &str = "A program of your own";
/// Columns that are too few for a sentence, and where one stands then.
const NARROW: usize = 24;
const INDENT: usize = 4;
/// Columns that the name of a solver may take: as many as the longest of a method has.
const NAME: usize = 33;

/// Solve a problem by every method and reference and compare the answers.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Each solver gives a bound on its own error: the references from two tolerances,
the methods from two step sizes. Its answer must be no further from the truth,
the exact solution or the best reference, than the bounds of both allow. A
program is run with two step sizes, and must write a row at each quarter of the
time, under the header that `verify list problems` shows; its bound is that of a
method of order --expect, which is no claim here.

Examples:
  verify compare --problem logistic
  verify compare --problem logistic --method mine.toml
  verify compare --problem logistic --program 'python3 mine.py' --expect 4
  verify compare --problem poiseuille-galerkin --set gamma=1
  verify compare --model predator-prey.ds --t-end 10

A run that fails disagrees with nothing, and one that chooses its steps fails
once it has taken a million; it is inconclusive, like an answer with a bound too
wide to tell, or one whose runs do not differ as errors of its order do in the
shortest steps that are tried, as where f jumps, unless they tend to another
solution. Where the equation magnifies every difference, so that the references
part before the end time, that is said after the table, and so it is where f
changes by itself within a step, or where the methods of fixed steps agree with
each other against the references of a model. If solvers disagree there, the
references decide nothing. A model that has come to rest by the first quarter of
the time is compared up to there.

Exit status: 0 none disagrees, 1 some do, 2 bad usage, 3 none could be held
against another, or one of your own could not.")]
pub(super) struct Args {
    #[command(flatten)]
    problem: ProblemArgs,

    /// Compare this method too, a name or a file; repeatable
    #[arg(long, value_name = "M")]
    method: Vec<String>,

    /// Compare this program too; repeatable
    #[arg(long, help_heading = HEADING, value_name = "COMMAND")]
    program: Vec<String>,

    /// Their order, for the bounds
    #[arg(long, help_heading = HEADING, value_name = "P", requires = "program", default_value_t = 1.0, value_parser = args::positive)]
    expect: f64,

    /// End a run after so many seconds
    #[arg(long, help_heading = HEADING, value_name = "SECONDS", requires = "program", default_value_t = 60)]
    time_limit: u64,

    /// End time, for a model
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    t_end: Option<f64>,
}

pub(super) fn run(options: &Args, out: &mut Output) -> Result<Status, Failure> {
    if options.t_end.is_some() && !options.problem.is_model() {
        return Err(Failure::Incomplete("--t-end", "--model: a problem by name is compared at its own time"));
    }
    let (name, problem) = options.problem.build(options.t_end)?;
    let own = own(&options.method)?;
    own.iter().try_for_each(|method| method.build(&*problem).map(|_| ()))?;
    let guest = |command: &String| {
        let program = args::program(command, options.time_limit)?;
        let request =
            Request { problem: Some(name.clone()), set: options.problem.set().to_vec(), ..Request::default() };
        Ok::<_, Failure>(Guest { name: command.clone(), program, request, order: options.expect })
    };
    let checked = |command: &String| {
        let guest = guest(command)?;
        let wrong = |source| OrderError::Program { problem: Some(name.clone()), source };
        guest.check(&*problem).map_err(wrong)?;
        Ok(guest)
    };
    let guests = options.program.iter().map(checked).collect::<Result<Vec<_>, Failure>>()?;
    let asked: Vec<String> = own
        .iter()
        .map(|method| format!("/{}", method.name()))
        .chain(options.program.iter().map(|it| format!("/{it}")))
        .collect();
    let evidence = cross_check::evidence(&compare(&name, &*problem, own, &guests));
    show(&evidence, out).and_then(|()| options.problem.write_caveat(out)).map_err(Failure::Output)?;
    let any = |outcome| evidence.checks.iter().any(|check| check.outcome == outcome);
    let is_told = |id: &String| {
        let mut of_it = evidence.checks.iter().filter(|check| check.id.ends_with(id));
        of_it.any(|check| matches!(check.outcome, Outcome::Pass | Outcome::Fail))
    };
    Ok(match any(Outcome::Fail) {
        true => Status::Failed,
        false if any(Outcome::Pass) && asked.iter().all(is_told) => Status::Ok,
        false => Status::Inconclusive,
    })
}

/// The methods that `texts` name. A file has its path beside its name where another method has the same.
fn own(texts: &[String]) -> Result<Vec<Box<dyn Method>>, Failure> {
    let mut own: Vec<Box<dyn Method>> = Vec::new();
    for text in texts {
        own.push(match args::method_file(text)? {
            None => args::method(text)?,
            Some(mut file) => {
                if let Some(warning) = args::overclaim(text, &file) {
                    // Nobody can be told where standard error is closed.
                    let _ = paragraph(&mut io::stderr(), "warning: ", 9, &warning);
                }
                if method::parse(&file.name).is_ok() || own.iter().any(|other| other.name() == file.name) {
                    file.name = format!("{} of {text}", file.name);
                }
                Box::new(FileMethod::of(&file))
            }
        });
    }
    Ok(own)
}

fn show(evidence: &Evidence, out: &mut impl Write) -> io::Result<()> {
    for table in &evidence.tables {
        paragraph(out, "", 0, &table.caption)?;
        writeln!(out)?;
        let (table, legend) = with_short_names(&without_the_only_equation(table));
        show_table(&table, out)?;
        if !legend.is_empty() {
            writeln!(out)?;
        }
        for (short, name) in legend {
            paragraph(out, &format!("{short}  "), INDENT, &name)?;
        }
    }
    let count = |outcome| evidence.checks.iter().filter(|check| check.outcome == outcome).count();
    let [pass, fail, open, not_run] = [Outcome::Pass, Outcome::Fail, Outcome::Inconclusive, Outcome::NotRun].map(count);
    for note in &evidence.notes {
        writeln!(out)?;
        paragraph(out, "", 0, note)?;
    }
    writeln!(out, "\n{pass} agree, {fail} do not, {open} inconclusive, {not_run} not run")
}

/// The table without its column of equations where all solvers solve one.
fn without_the_only_equation(table: &Table) -> Table {
    let mut table = table.clone();
    let Some(column) = table.column("equation") else { return table };
    if table.rows.windows(2).all(|pair| pair[0][column] == pair[1][column]) {
        table.columns.remove(column);
        table.rows.iter_mut().for_each(|row| drop(row.remove(column)));
    }
    table
}

/// The table with its long names cut, each with a number, and what they stand for.
fn with_short_names(table: &Table) -> (Table, Vec<(String, String)>) {
    let mut table = table.clone();
    let mut legend: Vec<(String, String)> = Vec::new();
    let names = table.columns.iter().position(|column| column == "solver");
    for cell in table.rows.iter_mut().filter_map(|row| row.get_mut(names?)) {
        let Cell::Text(name) = cell else { continue };
        if width(name) > NAME {
            let number = format!("[{}]", legend.len() + 1);
            let kept = NAME - 2 - number.len();
            legend.push((number.clone(), name.clone()));
            *name = format!("{}… {number}", name.chars().take(kept).collect::<String>());
        }
    }
    (table, legend)
}

/// Columns as wide as their cells, numbers to the right; the last is text and takes what is left of the line.
fn show_table(table: &Table, out: &mut impl Write) -> io::Result<()> {
    let rows: Vec<Vec<String>> = table.rows.iter().map(|row| row.iter().map(text).collect()).collect();
    let is_number = |j: usize| table.rows.iter().any(|row| matches!(row[j], Cell::Number(_) | Cell::Integer(_)));
    let last = table.columns.len() - 1;
    let widths: Vec<usize> = (0..last)
        .map(|j| rows.iter().map(|row| &row[j]).chain([&table.columns[j]]).map(|s| width(s)).max().unwrap_or(0))
        .collect();
    for row in [&table.columns].into_iter().chain(&rows) {
        let cells = (0..last).map(|j| if is_number(j) { right(&row[j], widths[j]) } else { left(&row[j], widths[j]) });
        let label: String = cells.map(|cell| cell + "  ").collect();
        // A word a line is no way to tell a reason.
        if width(&label) + width(&row[last]) > columns() && width(&label) + NARROW > columns() {
            writeln!(out, "{}", label.trim_end())?;
            paragraph(out, "", INDENT, &row[last])?;
        } else {
            paragraph(out, &label, width(&label), &row[last])?;
        }
    }
    Ok(())
}

fn text(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Number(x) => significant(*x, 2),
        Cell::Integer(n) => n.to_string(),
        Cell::Empty => "—".into(),
    }
}

#[cfg(test)]
mod tests {
    use verify::evidence::Check;

    use super::*;

    #[test]
    fn the_last_line_counts_each_outcome() {
        let counts = [(Outcome::Pass, 4), (Outcome::Fail, 1), (Outcome::Inconclusive, 3), (Outcome::NotRun, 2)];
        let checks =
            counts.into_iter().flat_map(|(outcome, n)| (0..n).map(move |_| Check::undecided("", "", outcome, "")));
        let mut out = Vec::new();
        show(&Evidence { checks: checks.collect(), ..Evidence::default() }, &mut out).expect("memory");
        assert_eq!(String::from_utf8_lossy(&out), "\n4 agree, 1 do not, 3 inconclusive, 2 not run\n");
    }

    /// As wide as the column may be, and told in full below.
    #[test]
    fn a_long_name_is_cut_to_the_width_of_its_column() {
        let names = ["rk4".to_owned(), "x".repeat(NAME), "y".repeat(NAME + 1), "z".repeat(90)];
        let rows = names.iter().map(|name| vec![Cell::Text(name.clone())]).collect();
        let (table, legend) = with_short_names(&Table::new("id", "", ["solver"], rows));
        let short: Vec<String> = table.rows.iter().map(|row| text(&row[0])).collect();
        assert_eq!(short[..2], names[..2]);
        assert!(short[2..].iter().all(|name| width(name) == NAME), "{short:?}");
        assert_eq!(legend, [("[1]".to_owned(), names[2].clone()), ("[2]".to_owned(), names[3].clone())]);
    }

    #[test]
    fn a_file_that_is_given_twice_has_two_names() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/gauss6.toml").to_owned();
        let names: Vec<_> = own(&[file.clone(), file]).expect("a method").iter().map(|it| it.name()).collect();
        assert!(names.len() == 2 && names[0] != names[1], "{names:?}");
    }

    /// One that fits on the line of its label stands there; a longer one below it, unless there is room for a few words a line.
    #[test]
    fn a_reason_stands_behind_its_label_where_there_is_room() {
        let lines = |label: usize, reason: &str| {
            let rows = vec![vec![Cell::Text("x".repeat(label - 2)), Cell::Text(reason.into())]];
            let mut out = Vec::new();
            show_table(&Table::new("id", "", ["a", "b"], rows), &mut out).expect("written");
            let text = String::from_utf8(out).expect("UTF-8");
            text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
        };
        let wide = columns() - NARROW + 1;
        let label = |width: usize| "x".repeat(width - 2);
        let fits = "y".repeat(NARROW - 1);
        assert_eq!(lines(wide, &fits), [format!("{}  {fits}", label(wide))]);
        let longer = format!("{fits}y");
        assert_eq!(lines(wide, &longer), [label(wide), format!("    {longer}")]);
        let words = format!("{fits} y");
        assert_eq!(
            lines(wide - 1, &words),
            [format!("{}  {fits}", label(wide - 1)), format!("{}y", " ".repeat(wide - 1))]
        );
    }

    #[test]
    fn a_legend_stands_below_a_table_with_long_names_alone() {
        let shown = |name: &str| {
            let rows = vec![vec![Cell::Text(name.into()), Cell::Text("agrees".into())]];
            let table = Table::new("id", "A table.", ["solver", "verdict"], rows);
            let mut out = Vec::new();
            show(&Evidence { tables: vec![table], ..Evidence::default() }, &mut out).expect("memory");
            String::from_utf8(out).expect("UTF-8")
        };
        let last = "\n0 agree, 0 do not, 0 inconclusive, 0 not run\n";
        assert_eq!(shown("rk4"), format!("A table.\n\nsolver  verdict\nrk4     agrees\n{last}"));
        let long = "x".repeat(NAME + 1);
        assert!(shown(&long).ends_with(&format!("[1]  agrees\n\n[1]  {long}\n{last}")), "{}", shown(&long));
    }
}
