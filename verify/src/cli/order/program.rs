//! `order --program`: the order of a solver in any language.

use rayon::prelude::*;
use verify::measure::refinement::{Grid, Quantity};
use verify::order::{Ladder, measure_program};
use verify::program::{Program, Request, Shown};

use super::{Args, Measurement};
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

    /// Refine a parameter instead, at the step --h: cells=32,64,128
    #[arg(long, value_name = "NAME=N,N,…", requires = "program", value_parser = assignment)]
    refine: Option<(String, String)>,
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
        let (truth, found) = measure_program(&*known, &program, &request, args.reference, ladder)?;
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
        let runs: Vec<(f64, Request)> = match &self.refine {
            None => self.h.iter().map(|h| (*h, Request { h: Some(*h), ..request.clone() })).collect(),
            Some((parameter, values)) => values
                .split(',')
                .map(|text| {
                    let refused =
                        || Failure::Value { option: "--refine", value: text.to_owned(), wanted: "positive numbers" };
                    let value =
                        text.trim().parse::<f64>().ok().filter(|n| *n > 0.0 && n.is_finite()).ok_or_else(refused)?;
                    let mut set = request.set.clone();
                    set.push((parameter.clone(), text.trim().to_owned()));
                    Ok((value.recip(), Request { h: self.h.first().copied(), set, ..request.clone() }))
                })
                .collect::<Result<_, Failure>>()?,
        };
        let answers: Vec<_> =
            runs.par_iter().map(|(h, request)| (*h, request.h, program.run(request, columns))).collect();
        let mut quantities: Vec<Quantity> =
            columns.iter().map(|name| Quantity { name: name.clone(), grids: Vec::new(), resolution: 0.0 }).collect();
        let mut ran = Vec::new();
        for (h, step, answer) in answers {
            let answer = answer.map_err(|source| Failure::Program { at: h, source })?;
            for (quantity, value) in quantities.iter_mut().zip(answer.end().1) {
                quantity.resolution = quantity.resolution.max(answer.printed.resolution(*value));
                quantity.grids.push(Grid { h, value: Some(*value) });
            }
            ran.push((step, answer));
        }
        Ok((quantities, Shown::by(&ran)))
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
