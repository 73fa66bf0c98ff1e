//! Whether the rules that judge orders and closed forms can say no: they are given something wrong.

use super::{Answer, prose};
use crate::chapter::{Context, StudyError};
use crate::evidence::{Check, Requirement, Table};
use crate::experiment::controls::Controls;
use crate::experiment::cross_check::references;
use crate::{method, problem, row};

pub(super) fn answer(context: &Context) -> Result<Answer, StudyError> {
    let controls = context.get(Controls)?;
    let wrong = controls.iter().filter(|control| !control.holds());
    let planted = controls.iter().filter(|control| control.wanted != "pass").count();
    let checks = vec![Check::new(
        "trust/controls",
        "The rules that judge orders and closed forms reject what is wrong: number of wrong answers",
        wrong.count() as f64,
        Requirement::AtMost(0.0),
        "negative controls, run each time",
    )];
    let rows = controls.iter().map(|control| row![control.input, control.verdict.as_str(), control.wanted]);
    let caption = "Right and wrong inputs given to the rules that judge orders and closed forms.";
    let values = [
        ("controls", controls.len().to_string()),
        ("planted", planted.to_string()),
        ("problems", problem::ALL.len().to_string()),
        ("methods", method::ALL.len().to_string()),
        ("references", references().to_string()),
    ];
    Ok(Answer {
        id: "answer-trust",
        question: "Can I trust these numbers?",
        short: "as far as the checks go that are told here".into(),
        text: prose::fill(include_str!("trust.md"), &values)?,
        checks,
        figure: None,
        table: Table::data("answer-trust-controls", caption, ["input", "verdict", "wanted"], rows.collect()),
    })
}
