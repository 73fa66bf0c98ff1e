//! `list`: what there is, by name.

use std::io::{self, Write};
use std::sync::Arc;

use clap::ValueEnum;
use verify::experiment::Context;
use verify::judge::file::SHIPPED;
use verify::problem::component_names;
use verify::{chapter, golden, method, problem, reference};

use super::Status;
use super::error::Failure;
use super::layout::{left, paragraph, width};
use super::output::Output;

/// Columns of a header that is shown as a whole.
const MOST: usize = 66;

/// Show the problems, methods, references, studies and goldens by name.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  verify list                everything
  verify list problems       names, equations, headers, parameters with defaults
  verify list methods        names as `--method` takes them
  verify list method-files   names as `judge` takes them")]
pub(super) struct Args {
    /// problems, methods, method-files, references, studies or goldens; all, if none
    /// is named
    #[arg(hide_possible_values = true)]
    kind: Option<Kind>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Problems,
    Methods,
    MethodFiles,
    References,
    Studies,
    Goldens,
}

pub(super) fn run(args: &Args, out: &mut Output) -> Result<Status, Failure> {
    let one = |kind, out: &mut Output| match kind {
        Kind::Problems => list_problems(out),
        Kind::Methods => list_methods(out),
        Kind::MethodFiles => list_method_files(out),
        Kind::References => list_references(out),
        Kind::Studies => list_studies(out),
        Kind::Goldens => {
            golden::all(&Arc::new(Context::quick())).iter().try_for_each(|golden| writeln!(out, "{}", golden.name))
        }
    };
    let all = |out: &mut Output| -> io::Result<()> {
        for (i, kind) in Kind::value_variants().iter().enumerate() {
            let heading = kind.to_possible_value().map_or_else(String::new, |value| value.get_name().to_uppercase());
            writeln!(out, "{}{heading}\n", if i == 0 { "" } else { "\n" })?;
            one(*kind, out)?;
        }
        Ok(())
    };
    match args.kind {
        Some(kind) => one(kind, out),
        None => all(out),
    }
    .map_err(Failure::Output)?;
    Ok(Status::Ok)
}

fn list_problems(out: &mut impl Write) -> io::Result<()> {
    for spec in problem::ALL {
        writeln!(out, "{}", spec.name)?;
        paragraph(out, "", 4, spec.summary)?;
        if let Ok(problem) = problem::build(spec.name, &[]) {
            paragraph(out, "    header ", 11, &header(&component_names(&*problem)))?;
        }
        for parameter in spec.parameters {
            let label = format!("    {}", left(&format!("{}={}", parameter.name, parameter.default), 20));
            paragraph(out, &label, 26, parameter.meaning)?;
        }
        for alias in problem::ALIASES.iter().filter(|alias| alias.problem == spec.name) {
            let (parameter, value) = alias.set;
            writeln!(out, "    also called {} with {parameter}={value}", alias.name)?;
        }
    }
    Ok(())
}

/// What a program writes above its numbers; of many components the first and the last.
fn header(names: &[String]) -> String {
    let all = format!("t,{}", names.join(","));
    match names {
        [first, second, .., last] if width(&all) > MOST => format!("t,{first},{second},…,{last}"),
        _ => all,
    }
}

fn list_methods(out: &mut Output) -> io::Result<()> {
    let longest = method::ALL.iter().map(|spec| width(spec.form)).max().unwrap_or(0);
    method::ALL.iter().try_for_each(|spec| paragraph(out, spec.form, longest + 2, spec.summary))
}

fn list_method_files(out: &mut Output) -> io::Result<()> {
    for shipped in SHIPPED {
        // A test reads every one of them.
        let Ok(file) = shipped.read() else { continue };
        let order = file.order().map_or_else(String::new, |order| format!(", order {order} claimed"));
        let source = file.source.unwrap_or_default();
        writeln!(out, "{}", shipped.name)?;
        paragraph(out, "", 4, &format!("{}{order}; {source}", file.name))?;
    }
    Ok(())
}

fn list_references(out: &mut Output) -> io::Result<()> {
    paragraph(out, "exact", 20, "the solution in closed form or tabulated, where the problem has one")?;
    for reference in reference::all() {
        let library = reference.library().unwrap_or_else(|| "not compiled in: needs the feature `cvode`".into());
        let use_for = if reference.stiff_ok() { "stiff and non-stiff problems" } else { "non-stiff problems" };
        paragraph(out, reference.name(), 20, &format!("{library}; {use_for}"))?;
    }
    Ok(())
}

fn list_studies(out: &mut Output) -> io::Result<()> {
    for study in chapter::ALL {
        paragraph(out, study.id, 20, &format!("{}. {}", study.title, study.source))?;
        paragraph(out, "", 20, study.question)?;
    }
    for (place, study) in chapter::LONG {
        paragraph(out, study.id, 20, &format!("{}. With `report --full` in place of `{place}`.", study.title))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_shown_as_a_whole_where_it_fits_on_a_line() {
        let of = |last: usize| header(&[20, 10, 10, last].map(|letters| "x".repeat(letters)));
        assert_eq!([width(&of(5)), width(&of(21))], [50, MOST]);
        assert_eq!(of(22), format!("t,{},{},…,{}", "x".repeat(20), "x".repeat(10), "x".repeat(22)));
    }

    #[test]
    fn other_names_stand_with_the_problem_that_they_set() {
        let mut out = Vec::new();
        list_problems(&mut out).expect("written");
        let text = String::from_utf8(out).expect("UTF-8");
        for alias in problem::ALIASES {
            let (parameter, value) = alias.set;
            let line = format!("    also called {} with {parameter}={value}", alias.name);
            let (before, _) = text.split_once(&line).expect("it is listed");
            assert_eq!(before.lines().rfind(|line| !line.starts_with(' ')), Some(alias.problem), "{line}");
        }
    }
}
