//! Every problem solved by every solver that applies.

use rayon::prelude::*;

pub use crate::compare::{Compared, Comparison, SAMPLES, Standing, compare};
use crate::experiment::{Context, Experiment, StudyError};
use crate::{problem, reference};

/// All problems on which methods and references are paired.
#[derive(Debug)]
pub struct CrossChecks;

impl Experiment for CrossChecks {
    const ID: &'static str = "cross-checks";
    type Found = Vec<Comparison>;

    fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
        let specs: Vec<_> = problem::paired().collect();
        context.announce(specs.len());
        let one = |spec: &&problem::Spec| {
            let compared = compare(spec.name, &*problem::small(spec.name)?, Vec::new(), &[]);
            context.tick();
            Ok(compared)
        };
        specs.par_iter().map(one).collect()
    }
}

/// The number of solvers of other libraries that answers are held against.
pub fn references() -> usize {
    reference::all().len()
}
