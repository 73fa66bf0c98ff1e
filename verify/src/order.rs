//! The order of a method on a problem, measured against a reference.

use rayon::prelude::*;

use crate::measure::order::{OrderFit, Sample, fit};
use crate::methods::{Method, OrderPlan};
use crate::problems::{Principle, Problem};
use crate::references::{Reference, ReferenceError};
use crate::run::{distance, run};

/// What the errors are measured against.
#[derive(Debug, Clone, Copy)]
pub enum Truth {
    /// The exact solution.
    Exact,
    /// A numerical reference with its own error bound.
    Numerical(&'static dyn Reference),
}

/// Why an order could not be measured at all.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum OrderError {
    /// The problem has no exact solution.
    #[error("no exact solution is known; choose a numerical reference")]
    NoExact,
    /// The reference failed.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
}

/// Measures the order at the end of the plan's horizon.
///
/// The floor of each error is the bound of the reference plus the roundoff of N steps: N ε |v|, one rounding of the state
/// per step; N² ε |q| where the state carries a momentum, whose error ε |q|/h in each step acts on all later ones.
///
/// # Errors
/// [`OrderError`] if there is no truth to measure against.
pub fn measure(problem: &dyn Problem, method: &dyn Method, truth: Truth) -> Result<OrderFit, OrderError> {
    let mut plan = problem.order_plan(method);
    let limit = problem.limit(method.principle());
    if let Some(order) = limit.order.filter(|order| *order < plan.expectation.order) {
        plan = plan.declared(order, limit.reason);
    }
    let OrderPlan { expectation, horizon, steps } = plan;
    let (end, bound) = match truth {
        Truth::Exact => {
            let end = (limit.exact)(horizon).ok_or(OrderError::NoExact)?;
            // A handful of elementary functions, each to an ulp or two.
            let bound = 8.0 * f64::EPSILON * distance(&end, &vec![0.0; end.len()]);
            (end, bound)
        }
        Truth::Numerical(reference) => {
            let mut sampled = reference.solve(limit.ode, 0.0, &limit.initial, &[horizon])?;
            (sampled.states.swap_remove(0), sampled.bound[0])
        }
    };
    let size = distance(&end, &vec![0.0; end.len()]).max(distance(&limit.initial, &vec![0.0; limit.initial.len()]));
    let samples: Vec<Sample> = steps
        .into_par_iter()
        .map(|h| match run(problem, method, h, horizon, |_| {}) {
            Ok(state) => {
                let steps = horizon / h;
                let carried = if method.principle() == Principle::EulerLagrange { steps } else { 1.0 };
                let roundoff = f64::EPSILON * size * steps * carried;
                Sample::new(h, distance(&state.q, &end), bound + roundoff)
            }
            Err(error) => Sample::failed(h, error.to_string()),
        })
        .collect();
    Ok(fit(&samples, &expectation))
}
