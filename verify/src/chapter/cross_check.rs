//! Methods, exact solutions, CVODE and diffsol against each other on every problem.

use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::compare::cross_check;
use crate::evidence::Evidence;
use crate::problem;

pub(super) const STUDY: Study = Study {
    id: "cross-check",
    title: "Cross-checks against CVODE and diffsol",
    question: "Do the methods, the exact solutions and two independent libraries agree on every problem?",
    source: "all problems",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let specs: Vec<_> = problem::paired().collect();
    (context.announce)(specs.len() as u64);
    let parts: Vec<Evidence> = specs
        .par_iter()
        .map(|spec| {
            let problem = problem::small(spec.name)?;
            let evidence = cross_check(spec.name, &*problem);
            (context.tick)();
            Ok(evidence)
        })
        .collect::<Result<_, StudyError>>()?;
    let mut all = Evidence::default();
    for part in parts {
        all.checks.extend(part.checks);
        all.tables.extend(part.tables);
    }
    all.notes.push(
        "The equations that CVODE and diffsol solve are written by hand in each problem, apart from the ones that the \
         methods differentiate; a test holds the two against each other. Each reference is solved at two tolerances, and \
         twice the difference is its bound. On the Poiseuille ansatz the closures converge to different equations, so \
         each is compared with solutions of its own."
            .into(),
    );
    Ok(all)
}
