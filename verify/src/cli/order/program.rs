//! `order --program`: the order of a solver in any language.

use rayon::prelude::*;
use verify::measure::refinement::{Grid, Quantity};
use verify::order::{Ladder, measure_program};
use verify::program::{Answer, Program, ProgramError, Request, Shown, are_one_run, share_digits};

use super::{Args, Measurement, doubt};
use crate::cli::Status;
use crate::cli::args::{assignment, positive, program};
use crate::cli::error::Failure;
use crate::cli::output::Output;

/// Seconds that a run may take by default.
const TIME_LIMIT: u64 = 60;

/// A command instead of a method.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "A program of your own")]
pub(super) struct ProgramArgs {
    /// Judge a command instead of a method; see below
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["method", "data"])]
    pub(super) program: Option<String>,

    /// End a run of the program after so many seconds [default: 60]
    #[arg(long, value_name = "SECONDS", requires = "program")]
    time_limit: Option<u64>,

    /// Without a reference: steps to compare with each other
    #[arg(long, value_name = "H,H,…", requires = "program", value_delimiter = ',', value_parser = positive)]
    h: Vec<f64>,

    /// Refine a parameter instead, at the step --h: whole numbers count cells,
    /// cells=32,64,128, and others are spacings, dx=0.1,0.05,0.025
    #[arg(long, value_name = "NAME=N,N,…", requires = "program", value_parser = assignment)]
    refine: Option<(String, String)>,
}

/// A run on one of the grids that are compared with each other.
struct GridRun {
    /// Its spacing.
    spacing: f64,
    /// The option that makes it, as it was written.
    label: String,
    request: Request,
}

impl ProgramArgs {
    /// Judges `command` on a built-in problem or a model, by its errors.
    pub(super) fn against_reference(
        &self,
        command: &str,
        request: Request,
        ladder: &Ladder,
        args: &Args,
        out: &mut Output,
    ) -> Result<Status, Failure> {
        let (name, known) = args.problem.build(request.t_end)?;
        let program = self.program(command)?;
        let end = request.t_end.unwrap_or(known.facts().window.horizon);
        let request = Request { problem: Some(name.clone()), ..request };
        let (truth, mut found) = measure_program(&*known, &program, &request, args.reference, ladder)?;
        doubt(&*known, (truth, end), &mut found.fit, &mut found.notes);
        let result = Measurement::new(
            &name,
            command.to_owned(),
            (truth, end),
            (&found.fit, args.expect.is_some()),
            &found.notes,
        );
        result.of("a component that it shows").write(args, &found.fit, out)?;
        Ok(found.fit.verdict.into())
    }

    /// The values of `columns` at the end of runs that refine h or a parameter, and what these show beside.
    pub(super) fn refined(
        &self,
        command: &str,
        request: &Request,
        columns: &[String],
    ) -> Result<(Vec<Quantity>, Shown), Failure> {
        let program = self.program(command)?;
        let runs = self.grids(request)?;
        let mut answers: Vec<_> = runs.par_iter().map(|run| program.run(&run.request, columns)).collect();
        if let Some((run, Err(source))) = runs.iter().zip(&answers).find(|(_, answer)| {
            answer.as_ref().is_err_and(|error| error.is_of_every_run() || answers.iter().all(Result::is_err))
        }) {
            return Err(Failure::Program { at: run.label.clone(), source: source.clone() });
        }
        share_digits(answers.iter_mut().filter_map(|answer| answer.as_mut().ok()));
        let mut quantities: Vec<Quantity> =
            columns.iter().map(|name| Quantity { name: name.clone(), grids: Vec::new(), resolution: 0.0 }).collect();
        for (run, answer) in runs.iter().zip(&answers) {
            let values = answer.as_ref().map(|answer| (answer.end().1, answer.printed)).ok();
            for (i, quantity) in quantities.iter_mut().enumerate() {
                let value = values.map(|(values, printed)| (values[i], printed));
                let resolution = value.map_or(0.0, |(value, printed)| printed.resolution(value));
                quantity.resolution = quantity.resolution.max(resolution);
                quantity.grids.push(Grid { h: run.spacing, value: value.map(|(value, _)| value) });
            }
        }
        Ok((quantities, self.shown(&runs, answers)))
    }

    /// The runs that are asked for.
    fn grids(&self, request: &Request) -> Result<Vec<GridRun>, Failure> {
        let Some((parameter, values)) = &self.refine else {
            let run = |h: &f64| GridRun {
                spacing: *h,
                label: format!("--h {h}"),
                request: Request { h: Some(*h), ..request.clone() },
            };
            return Ok(self.h.iter().map(run).collect());
        };
        let texts: Vec<&str> = values.split(',').map(str::trim).collect();
        let number = |text: &&str| {
            let refused =
                || Failure::Value { option: "--refine", value: (*text).to_owned(), wanted: "positive numbers" };
            text.parse::<f64>().ok().filter(|n| *n > 0.0 && n.is_finite()).ok_or_else(refused)
        };
        let numbers: Vec<f64> = texts.iter().map(number).collect::<Result<_, _>>()?;
        let are_counts = numbers.iter().all(|n| n.fract() == 0.0);
        let run = |(n, text): (f64, &str)| {
            let mut set = request.set.clone();
            set.push((parameter.clone(), text.to_owned()));
            GridRun {
                spacing: if are_counts { n.recip() } else { n },
                label: format!("{parameter}={text}"),
                request: Request { h: self.h.first().copied(), set, ..request.clone() },
            }
        };
        Ok(numbers.into_iter().zip(texts).map(run).collect())
    }

    /// What the runs show beside the values at their ends.
    fn shown(&self, runs: &[GridRun], answers: Vec<Result<Answer, ProgramError>>) -> Shown {
        let (mut ran, mut failed) = (Vec::new(), Vec::new());
        for (run, answer) in runs.iter().zip(answers) {
            match answer {
                // Of grids, the step is the same in all.
                Ok(answer) => ran.push((run.request.h.filter(|_| self.refine.is_none()), answer)),
                Err(error) => failed.push(format!("the run with {}: {error}", run.label)),
            }
        }
        let mut shown = Shown::by(&ran);
        shown.notes.extend(failed);
        if let Some((parameter, _)) = &self.refine
            && are_one_run(ran.iter().map(|(_, answer)| answer))
        {
            shown.incomparable = Some(format!(
                "every run gives the same values at the same times: the program does not use {parameter}, or has no error"
            ));
        }
        shown
    }

    /// Whether runs are compared with each other and not with a reference.
    pub(super) fn refines(&self) -> bool {
        !self.h.is_empty() || self.refine.is_some()
    }

    /// The options that are given and are of programs alone.
    pub(super) fn given(&self) -> impl Iterator<Item = &'static str> {
        let given = [
            ("--h", !self.h.is_empty()),
            ("--refine", self.refine.is_some()),
            ("--time-limit", self.time_limit.is_some()),
        ];
        given.into_iter().filter_map(|(option, is_given)| is_given.then_some(option))
    }

    fn program(&self, command: &str) -> Result<Program, Failure> {
        program(command, self.time_limit.unwrap_or(TIME_LIMIT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts of cells and spacings alike, and what is set beside them reaches every run.
    #[test]
    fn a_grid_is_asked_for_beside_what_is_set() {
        let set = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        let request = Request { t_end: Some(2.0), set: vec![set("re", "100")], ..Request::default() };
        for (name, values, spacings) in
            [("cells", ["32", "64"], [1.0 / 32.0, 1.0 / 64.0]), ("dx", ["0.5", "0.25"], [0.5, 0.25])]
        {
            let refine = Some(set(name, &values.join(",")));
            let asked = ProgramArgs { program: None, time_limit: None, h: vec![0.125], refine };
            let grids = asked.grids(&request).expect("positive numbers");
            let runs: Vec<_> = grids.iter().map(|grid| (grid.spacing, &grid.request)).collect();
            let of = |value: &str| Request {
                h: Some(0.125),
                set: vec![set("re", "100"), set(name, value)],
                ..request.clone()
            };
            let wanted = values.map(of);
            assert_eq!(runs, spacings.into_iter().zip(&wanted).collect::<Vec<_>>());
        }
    }
}
