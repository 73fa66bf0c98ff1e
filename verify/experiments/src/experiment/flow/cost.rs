//! Seconds of CPU time of a step by the size of the grid, and what fills the factors of its matrix.

use std::time::Duration;

use cpu_time::ThreadTime;
use lsvi::{Mass, State, VectorField};

use super::{named, setting};
use crate::experiment::{Context, Experiment, StudyError};
use crate::run::run;

/// A few steps of Method I.
#[derive(Debug)]
pub struct StepCost {
    /// The flow with its parameters.
    pub flow: &'static str,
    /// Cells, or grid points, along a side.
    pub cells: usize,
    /// Step size.
    pub h: f64,
}

/// Measured once.
#[derive(Debug)]
pub struct Found {
    /// Number of unknowns.
    pub unknowns: usize,
    /// CPU time of the first step, with what is set up for all.
    pub first: f64,
    /// That of each of the next.
    pub next: f64,
    /// Gauss–Newton iterations of each of the next.
    pub iterations: f64,
    /// Inner iterations of each of those.
    pub inner: f64,
    /// Entries of the LU factors of B at the end; none where the metric is not a matrix, as in Fourier space.
    pub factor_entries: Option<usize>,
}

/// Steps after the first.
const NEXT: u32 = 4;

impl Experiment for StepCost {
    const ID: &'static str = "step-cost";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let problem = setting(&format!("{} cells={}", self.flow, self.cells))?;
        let method = named("method-i")?;
        let one = run(&*problem, &*method, self.h, self.h, |_| {})?;
        let mut seen = Vec::new();
        let all = run(&*problem, &*method, self.h, f64::from(1 + NEXT) * self.h, |_| {
            seen.push(ThreadTime::now().as_duration())
        })?;
        let [first, next] = seconds(&seen).ok_or("several steps")?;
        context.tick();
        let iterations = (all.work.residuals - one.work.residuals) as f64;
        Ok(Found {
            unknowns: one.end.q.len(),
            first,
            next,
            iterations: iterations / f64::from(NEXT),
            inner: (all.work.inner - one.work.inner) as f64 / iterations,
            factor_entries: factor_entries(&*problem.field(), self.h, &all.end)?,
        })
    }
}

/// Seconds of the first step, and of each of the next, by a clock that was read at the start and after every step.
fn seconds(clock: &[Duration]) -> Option<[f64; 2]> {
    let [start, first, .., end] = *clock else { return None };
    let next = (end - first).as_secs_f64() / (clock.len() - 2) as f64;
    Some([(first - start).as_secs_f64(), next])
}

/// Entries of the LU factors of B = M − h J.
fn factor_entries(field: &dyn VectorField, h: f64, at: &State) -> Result<Option<usize>, StudyError> {
    let Mass::Matrix(mut b) = field.mass() else { return Ok(None) };
    field.add_jacobian(at.t, &at.q, -h, &mut b);
    Ok(Some(b.factor_entries()?))
}

#[cfg(test)]
mod tests {
    use super::super::observed;
    use super::*;

    #[test]
    fn the_iterations_of_a_step_are_those_of_the_four_after_the_first() {
        let (flow, cells, h) = ("cavity re=1000", 6, 0.5);
        let found = StepCost { flow, cells, h }.measure(&Context::quick()).expect("it runs");
        let problem = setting("cavity re=1000 cells=6").expect("known");
        let counts = |steps: f64| {
            let (_, cost) = observed(&*problem, &*named("method-i").expect("known"), h, steps * h).expect("it runs");
            [cost.solves as f64, cost.inner as f64]
        };
        let ([before, inner_before], [after, inner_after]) = (counts(1.0), counts(5.0));
        assert!(after > before && found.unknowns == 25 && found.first > 0.0 && found.next > 0.0, "{found:?}");
        assert_eq!(found.iterations, (after - before) / 4.0);
        assert_eq!(found.inner, (inner_after - inner_before) / (after - before));
    }

    /// Two cells a side have one unknown, three have four, each a neighbour of the others, and in Fourier space M is diagonal.
    #[test]
    fn the_factors_of_the_smallest_cavities_are_full() {
        let entries = |flow, cells| {
            let cost = StepCost { flow, cells, h: 0.1 }.measure(&Context::quick()).expect("it runs");
            cost.factor_entries
        };
        assert_eq!([2, 3].map(|cells| entries("cavity re=100", cells)), [Some(1), Some(16)]);
        assert_eq!(entries("turbulence-2d re=100", 8), None);
    }

    #[test]
    fn the_time_of_a_later_step_is_the_mean_of_those_after_the_first() {
        let clock = [10, 17, 18, 20, 24, 25].map(Duration::from_secs);
        assert_eq!(seconds(&clock), Some([7.0, 2.0]));
        assert_eq!(seconds(&clock[..2]), None);
    }
}
