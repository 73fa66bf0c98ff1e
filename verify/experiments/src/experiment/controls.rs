//! Something right and something wrong, given to the rules that judge orders and closed forms.

use std::f64::consts::SQRT_2;

use nalgebra::Complex;

use super::one_step::OneStep;
use super::{Context, Experiment, StudyError};
use crate::measure::amplification::Amplification;
use crate::measure::norm::distance;
use crate::measure::order::{Expectation, Sample, fit, ladder};
use crate::method::{self, roundoff};
use crate::problem;
use crate::run::run;

/// All controls.
#[derive(Debug)]
pub struct Controls;

/// What was given, and what the rule said.
#[derive(Debug)]
pub struct Control {
    /// What was given.
    pub input: &'static str,
    /// The verdict.
    pub verdict: String,
    /// What it ought to be.
    pub wanted: &'static str,
}

impl Control {
    /// Whether the rule is right.
    pub fn holds(&self) -> bool {
        match self.wanted {
            "not pass" => self.verdict != "pass",
            wanted => self.verdict == wanted,
        }
    }
}

impl Experiment for Controls {
    const ID: &'static str = "controls";
    type Found = [Control; 4];

    fn measure(&self, context: &Context) -> Result<[Control; 4], StudyError> {
        let control = |input, verdict, wanted| Control { input, verdict, wanted };
        // Method I whose α is wrong in the ninth digit, beside its closed form.
        let (closed, z) = (Amplification { alpha: 0.0, beta: 1.0 }, Complex::from(-1.0));
        let live = OneStep::growth("linear(1e-9,1.0)", 1.0).measure(context)??;
        let difference = (closed.factor(z) - live).norm();
        let verdict = if difference <= closed.live_tolerance(&[z]) { "pass" } else { "fail" }.to_owned();
        Ok([
            control("order of the trapezoidal rule, said to be 2", second_order("trapezoidal", 1.0)?, "pass"),
            control("order of implicit Euler, said to be 2", second_order("implicit-euler", 1.0)?, "fail"),
            control(
                "order of the trapezoidal rule against a truth wrong by 1e-4",
                second_order("trapezoidal", 1.0 + 1e-4)?,
                "not pass",
            ),
            control("one step of Method I with α = 1e-9 in place of 0", verdict, "fail"),
        ])
    }
}

/// The verdict on a method said to be of second order, on logistic growth with the solution times `scale`.
fn second_order(method: &str, scale: f64) -> Result<String, StudyError> {
    let (problem, method) = (problem::build_setting("logistic")?, method::parse(method)?);
    let exact = problem.exact(2.0).ok_or("logistic growth has an exact solution")?;
    let mut samples = Vec::new();
    for h in ladder(2.0, 0.2, SQRT_2, 13) {
        let end = run(&*problem, &*method, h, 2.0, |_| {})?.end;
        samples.push(Sample::new(h, distance(&end.q, &[exact[0] * scale]), roundoff(&*method, 1.0, 2.0 / h)));
    }
    Ok(format!("{:?}", fit(&samples, &Expectation::new(2.0, 0.1)).verdict).to_lowercase())
}
