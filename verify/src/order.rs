//! The order of a method on a problem, measured against a reference.

use std::fmt;

use rayon::prelude::*;

use crate::measure::norm::{distance, max_norm};
use crate::measure::order::{OrderFit, Sample, Verdict, fit};
use crate::method::Method;
use crate::problem::Problem;
use crate::reference::{Reference, ReferenceError, by_name};
use crate::run::run;
use crate::theory::{OrderPlan, order_plan};

/// What the errors are measured against.
#[derive(Debug, Clone, Copy)]
pub enum Truth {
    /// The exact solution.
    Exact,
    /// The solution tabulated to double precision.
    Tabulated,
    /// A numerical reference with its own error bound.
    Numerical(&'static dyn Reference),
}

/// A kind of truth, by the name that the command line gives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Source {
    /// The solution in closed form, or tabulated to double precision.
    Exact,
    /// SUNDIALS CVODE at tight tolerances.
    Cvode,
    /// diffsol at tight tolerances.
    Diffsol,
}

impl Source {
    /// The exact solution where one is known, else the first library that is compiled in.
    pub fn default_for(problem: &dyn Problem, method: &dyn Method) -> Self {
        let horizon = order_plan(problem, method).horizon;
        if (problem.limit(method.principle()).exact)(horizon).is_some() || problem.tabulated(horizon).is_some() {
            Self::Exact
        } else if cfg!(feature = "cvode") {
            Self::Cvode
        } else {
            Self::Diffsol
        }
    }

    /// What this kind is for `method` on `problem`: the exact solution in its better form, or the most accurate solver.
    pub fn truth(self, problem: &dyn Problem, method: &dyn Method) -> Truth {
        let is_tabulated = || problem.tabulated(order_plan(problem, method).horizon).is_some();
        let name = match (self, problem.is_stiff()) {
            (Self::Exact, _) if is_tabulated() => return Truth::Tabulated,
            (Self::Exact, _) => return Truth::Exact,
            (Self::Cvode, true) => "cvode-bdf",
            (Self::Cvode, false) => "cvode-adams",
            (Self::Diffsol, true) => "diffsol-bdf",
            (Self::Diffsol, false) => "diffsol-tsit45",
        };
        by_name(name).map_or(Truth::Exact, Truth::Numerical)
    }
}

impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact => f.write_str("exact"),
            Self::Tabulated => f.write_str("tabulated"),
            Self::Numerical(reference) => f.write_str(reference.name()),
        }
    }
}

/// Why an order could not be measured at all.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum OrderError {
    /// The problem has no exact solution.
    #[error("no exact solution is known; choose a numerical reference")]
    NoExact,
    /// The method chooses its steps itself.
    #[error("{0} chooses its steps itself: its errors follow the tolerance, not h")]
    Adaptive(String),
    /// No order can be told here, as theory has it and a trial confirms.
    #[error("the order is not told: {because}; tried, it is not: {found}")]
    Untold {
        /// Why not.
        because: &'static str,
        /// What the trial gave instead.
        found: String,
    },
    /// The reference failed.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
}

/// Measures the order at the end of the plan's horizon.
///
/// The floor of each error is the bound of the reference plus the [`roundoff`] of the steps. Where theory says that no order
/// can be told, the steps are taken all the same: a pass is then a failure.
///
/// # Errors
/// [`OrderError`] if there is no truth to measure against, or no order as theory has it.
pub fn measure(problem: &dyn Problem, method: &dyn Method, truth: Truth) -> Result<OrderFit, OrderError> {
    if method.traits().is_adaptive {
        return Err(OrderError::Adaptive(method.name()));
    }
    let mut plan = order_plan(problem, method);
    let limit = problem.limit(method.principle());
    if let Some(order) = limit.order.filter(|order| *order < plan.expectation.order) {
        plan = plan.declared(order, limit.reason);
    }
    let OrderPlan { expectation, horizon, steps, untold, unsettled } = plan;
    let (end, bound) = match truth {
        Truth::Exact => {
            let end = (limit.exact)(horizon).ok_or(OrderError::NoExact)?;
            let bound = 8.0 * f64::EPSILON * max_norm(&end); // a handful of elementary functions, each to an ulp or two
            (end, bound)
        }
        Truth::Tabulated => {
            let end = problem.tabulated(horizon).ok_or(OrderError::NoExact)?;
            let bound = f64::EPSILON * max_norm(&end); // rounded from more digits
            (end, bound)
        }
        Truth::Numerical(reference) => {
            let mut sampled = reference.solve(limit.ode, 0.0, &limit.initial, &[horizon])?;
            (sampled.states.swap_remove(0), sampled.bound[0])
        }
    };
    let size = max_norm(&end).max(max_norm(&limit.initial));
    let samples: Vec<Sample> = steps
        .into_par_iter()
        .map(|h| match run(problem, method, h, horizon, |_| {}) {
            Ok(run) => Sample::new(h, distance(&run.end.q, &end), bound + roundoff(method, size, horizon / h)),
            Err(error) => Sample::failed(h, error.to_string()),
        })
        .collect();
    let fit = fit(&samples, &expectation);
    match untold {
        _ if fit.verdict != Verdict::Pass
            && let Some(because) = untold.or(unsettled) =>
        {
            Err(OrderError::Untold { because, found: fit.reason })
        }
        None => Ok(fit),
        // What must not be told is told: the theory is wrong here.
        Some(because) => {
            let reason = format!("{}, where no order should be told: {because}", fit.reason);
            Ok(OrderFit { verdict: Verdict::Fail, reason, ..fit })
        }
    }
}

/// The roundoff that N steps of `method` leave in states no larger than `size`: N ε |q|, one rounding of the state per step,
/// and that of the momentum, where the state carries one.
pub fn roundoff(method: &dyn Method, size: f64, steps: f64) -> f64 {
    f64::EPSILON * size * (steps + method.momentum_roundoff(steps))
}
