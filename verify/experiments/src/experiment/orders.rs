//! The order of every method on every problem.

use rayon::prelude::*;

use crate::experiment::{Context, Experiment, StudyError};
use crate::kinds::Principle;
use crate::measure::norm::max_norm;
use crate::measure::order::{OrderFit, Verdict};
use crate::method::{self, Method};
pub use crate::order::{OrderError, Truth};
use crate::order::{Source, measure};
use crate::problem::{self, Problem};
use crate::theory::methods_for;

/// Every method on every problem that it applies to, against the best truth that there is.
#[derive(Debug)]
pub struct Orders;

/// The order of one method on one problem.
#[derive(Debug)]
pub struct Measured {
    /// Name of the problem.
    pub problem: String,
    /// Name of the method.
    pub method: String,
    /// What the method steps.
    pub principle: Principle,
    /// What errors are taken to.
    pub truth: Truth,
    /// Order that is found, or why there is none.
    pub fit: Result<OrderFit, OrderError>,
    /// A run with a larger error is [`LOST`].
    pub most: f64,
}

/// A run with a larger error, over the largest component of the initial state or 1, has not followed the solution at all.
pub const LOST: f64 = 10.0;

/// Measures the order of `method` on `problem`, named `name`.
pub fn measure_one(name: &str, problem: &dyn Problem, method: &dyn Method) -> Measured {
    let truth = Source::default_for(problem, method).truth(problem, method);
    Measured {
        problem: name.into(),
        method: method.name(),
        principle: method.principle(),
        truth,
        fit: measure(problem, method, truth),
        most: LOST * max_norm(&problem.initial()).max(1.0),
    }
}

impl Experiment for Orders {
    const ID: &'static str = "orders";
    type Found = Vec<Measured>;

    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
        let mut pairs = Vec::new();
        for spec in problem::paired() {
            let problem = problem::small(spec.name)?;
            pairs.extend(methods_for(&*problem).into_iter().map(|method| (spec.name, method)));
        }
        context.announce(pairs.len());
        let one = |(name, method): (&str, Box<dyn Method>)| {
            let measured = measure_one(name, &*problem::small(name)?, &*method);
            context.tick();
            Ok(measured)
        };
        pairs.into_par_iter().map(one).collect()
    }
}

/// The fitted order of one method on one problem, one of those of [`Orders`].
#[derive(Debug)]
pub struct Order {
    /// Name of the problem.
    pub problem: &'static str,
    /// Name of the method.
    pub method: &'static str,
}

impl Experiment for Order {
    const ID: &'static str = "order";
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let measured = measure_one(self.problem, &*problem::small(self.problem)?, &*method::parse(self.method)?);
        let fit = measured.fit.map_err(|error| error.to_string())?;
        let line = fit.line.filter(|_| fit.verdict == Verdict::Pass);
        Ok(line.ok_or_else(|| format!("the order of {} on {} is not settled", self.method, self.problem))?.slope)
    }
}
