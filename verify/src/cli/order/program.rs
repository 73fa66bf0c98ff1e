//! `order --program`: the order of a solver in any language.

use clap::Args;
use rayon::prelude::*;
use verify::measure::refinement::{Grid, Quantity};
use verify::order::{Ladder, Source, measure_program};
use verify::program::{Program, Request};

use super::{Format, Measurement};
use crate::cli::Status;
use crate::cli::args::{self, ProblemArgs, assignment, positive};
use crate::cli::error::Failure;
use crate::cli::output::Output;

/// A command instead of a method.
#[derive(Debug, Args)]
#[command(next_help_heading = "A program of your own")]
pub(super) struct ProgramArgs {
    /// Judge a command instead of a method; see below
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["method", "data"])]
    pub(super) program: Option<String>,

    /// End a run of the program after so many seconds
    #[arg(long, value_name = "SECONDS", requires = "program", default_value_t = 60)]
    time_limit: u64,

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
        problem: &ProblemArgs,
        request: Request,
        reference: Option<Source>,
        ladder: &Ladder,
        (format, out): (Format, &mut Output),
    ) -> Result<Status, Failure> {
        let (name, known) = problem.build(request.t_end)?;
        let program = self.program(command)?;
        let request = Request { problem: Some(name.clone()), ..request };
        let (truth, found) = measure_program(&*known, &program, &request, reference, ladder)?;
        Measurement::new(&name, command.to_owned(), truth, &found.fit, &found.notes)
            .write(format, out)
            .map_err(Failure::Output)?;
        Ok(found.fit.verdict.into())
    }

    /// The values of `columns` at the end of runs that refine h or a parameter, and what is odd about their times.
    pub(super) fn refined(
        &self,
        command: &str,
        request: &Request,
        columns: &[String],
    ) -> Result<(Vec<Quantity>, Vec<String>), Failure> {
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
        let (mut ends, mut cut) = (Vec::new(), None);
        for (h, step, answer) in answers {
            let answer = answer.map_err(|source| Failure::Program { at: h, source })?;
            ends.push(answer.end().0);
            cut = cut.or_else(|| step.and_then(|step| Some((step, answer.clipped(step)?))));
            for (quantity, value) in quantities.iter_mut().zip(answer.end().1) {
                quantity.grids.push(Grid { h, value: Some(*value) });
            }
        }
        let mut notes = Vec::new();
        let (first, last) = ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
        // A sum of steps may be off by rounding.
        if last - first > 1e-9 * last.abs() {
            notes.push(format!(
                "the runs end at times from t = {first} to {last}: their values belong to different times, which alone \
                 makes a difference of order 1"
            ));
        }
        if let Some((h, part)) = cut {
            notes.push(format!("with h = {h} the last step was cut to {part:.3} h"));
        }
        Ok((quantities, notes))
    }

    /// Whether runs are compared with each other and not with a reference.
    pub(super) fn refines(&self) -> bool {
        !self.h.is_empty() || self.refine.is_some()
    }

    fn program(&self, command: &str) -> Result<Program, Failure> {
        args::program(command, self.time_limit)
    }
}
