//! How many steps of a method it takes from rest to the steady cavity.

use std::ops::ControlFlow;

use super::{Seconds, cavity, named, repeated, timed};
use crate::experiment::{Context, Experiment, StudyError};
use crate::measure::norm::max_norm;
use crate::run::run_while;

/// Steps of one size in a cavity.
#[derive(Debug)]
pub struct Approach {
    /// Name of the method.
    pub method: &'static str,
    /// Reynolds number.
    pub re: f64,
    /// Cells along a side.
    pub cells: usize,
    /// Step size.
    pub h: f64,
}

impl Approach {
    /// |f| at which a flow counts as steady, in units of M ψ̇.
    pub const STEADY: f64 = 1e-8;
    /// Steps after which a run is given up.
    pub const MOST: u32 = 100;
}

/// The end of a run.
#[derive(Debug)]
pub struct Found {
    /// Number of steps.
    pub steps: u64,
    /// Linear systems solved.
    pub solves: u64,
    /// Max norm of f in units of M ψ̇.
    pub residual: f64,
    /// Why it ended early.
    pub error: Option<String>,
    /// CPU time of the run.
    pub seconds: Seconds,
}

impl Found {
    /// Whether the run came to rest.
    pub fn is_steady(&self) -> bool {
        self.residual <= Approach::STEADY
    }
}

impl Experiment for Approach {
    const ID: &'static str = "approach";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let problem = cavity(self.re, self.cells)?;
        let field = problem.field();
        let method = named(self.method)?;
        let mut f = vec![0.0; field.dim()];
        let ((ended, residual, seen), seconds) = repeated(|| {
            let (mut residual, mut seen) = (f64::NAN, 0_u64);
            let (ended, seconds) = timed(|| {
                run_while(&*problem, &*method, self.h, f64::from(Self::MOST) * self.h, |state| {
                    seen += 1;
                    field.rhs(state.t, &state.q, &mut f);
                    residual = max_norm(&f);
                    if residual <= Self::STEADY { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                })
            });
            Ok(((ended, residual, seen), seconds))
        })?;
        context.tick();
        let error = ended.as_ref().err().map(ToString::to_string);
        Ok(Found {
            steps: seen.saturating_sub(1),
            solves: ended.map_or(0, |run| run.work.factorizations),
            residual,
            error,
            seconds,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_ends_where_the_flow_is_steady_to_eight_digits() {
        let run = |h| Approach { method: "tr-bdf2", re: 100.0, cells: 4, h }.measure(&Context::quick()).expect("known");
        let (steady, moving) = (run(10.0), run(1e-3));
        assert!(steady.is_steady() && steady.residual <= 1e-8 && steady.steps < 100, "{steady:?}");
        assert!(!moving.is_steady() && moving.residual > 1e-6 && moving.steps == 100, "{moving:?}");
    }

    #[test]
    fn the_solves_of_a_run_are_its_linear_systems() {
        let found =
            Approach { method: "tr-bdf2", re: 100.0, cells: 4, h: 10.0 }.measure(&Context::quick()).expect("known");
        let problem = cavity(100.0, 4).expect("known");
        let end = 10.0 * found.steps as f64;
        let (_, cost) =
            super::super::observed(&*problem, &*named("tr-bdf2").expect("known"), 10.0, end).expect("it runs");
        assert_eq!(found.solves, cost.solves);
        assert_ne!(cost.solves, cost.residuals);
    }
}
