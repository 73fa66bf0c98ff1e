//! Variational integrators on the harmonic oscillator: maps of one step, intervals of stability, and two-step runs.

use lsvi::TwoStep;

use super::step_map::{Map, discretise, map, tangent};
use super::{Context, Experiment, StudyError};
use crate::measure::search::try_root;
use crate::method;
use crate::problem;

const OSCILLATOR: &str = "harmonic-oscillator";

/// The derivative of one step of τ: the step itself, as the oscillator is linear.
#[derive(Debug)]
pub struct StepMap {
    /// The method.
    pub method: String,
    /// τ = ωh.
    pub tau: f64,
}

/// What is found of it.
#[derive(Debug)]
pub struct Invariants {
    /// Its trace, the R of the recurrence.
    pub trace: f64,
    /// Its determinant.
    pub determinant: f64,
    /// What rounding does to either: two products of entries that are known to a few ε of the largest, which differentiation
    /// has magnified.
    pub rounding: f64,
}

impl Experiment for StepMap {
    const ID: &'static str = "oscillator-step";
    type Found = Invariants;

    fn measure(&self, _: &Context) -> Result<Invariants, StudyError> {
        let (oscillator, method) = (problem::build_setting(OSCILLATOR)?, method::parse(&self.method)?);
        let tangent = tangent(&mut map(&*method, &*oscillator)?, self.tau, &[1.0, 0.0])?;
        let slopes = method.momentum_roundoff(1.0);
        let rounding = 16.0 * f64::EPSILON * (1.0 + slopes * slopes) * (1.0 + tangent.norm_squared());
        Ok(Invariants { trace: tangent.trace(), determinant: tangent.determinant(), rounding })
    }
}

/// The intervals of τ in (0, [`Stable::LARGEST`]] in which a method is stable, |R(τ)| ≤ 2.
///
/// The maps are symmetric, so that R² − 4 = 4 (∂q₁/∂p₀)(∂p₁/∂q₀): stability changes where one of the two derivatives
/// changes its sign.
#[derive(Debug)]
pub struct Stable {
    /// The method.
    pub method: String,
}

impl Stable {
    /// Largest step that is looked at.
    pub const LARGEST: f64 = 12.0;
    /// Step of the scan for changes of stability: DΦ turns by about that angle, far less than the π between two of them.
    const SCAN: f64 = 0.03;
    /// An instability narrower than this is a point where |R| = 2 is only touched: a root is found to ten digits.
    const NARROWEST: f64 = 1e-8;
}

impl Experiment for Stable {
    const ID: &'static str = "oscillator-stability";
    /// Beginnings and ends.
    type Found = Vec<(f64, f64)>;

    fn measure(&self, context: &Context) -> Result<Vec<(f64, f64)>, StudyError> {
        context.announce(1);
        let oscillator = problem::build_setting(OSCILLATOR)?;
        let intervals = between(changes(&mut map(&*method::parse(&self.method)?, &*oscillator)?)?);
        context.tick();
        Ok(intervals)
    }
}

/// Where one of the two derivatives changes its sign, in ascending order.
fn changes(map: &mut Map) -> Result<Vec<f64>, StudyError> {
    let mut entries = |tau: f64| -> Result<[f64; 2], StudyError> {
        let tangent = tangent(map, tau, &[1.0, 0.0])?;
        Ok([tangent[(0, 1)], tangent[(1, 0)]])
    };
    let mut changes = Vec::new();
    let mut left = (Stable::SCAN, entries(Stable::SCAN)?);
    while left.0 < Stable::LARGEST {
        let tau = left.0 + Stable::SCAN;
        let right = (tau, entries(tau)?);
        for which in 0..2 {
            if left.1[which] * right.1[which] < 0.0 {
                let root = try_root([left.0, right.0], |tau| Ok::<_, StudyError>(entries(tau)?[which]))?;
                let root = root.ok_or("the derivative is not a number")?;
                // A pole changes the sign of both derivatives, and not of their product.
                if entries(root)?[which].abs() < 1.0 {
                    changes.push(root);
                }
            }
        }
        left = right;
    }
    changes.sort_by(f64::total_cmp);
    Ok(changes)
}

/// The intervals of stability that begin at 0 and change at `changes`.
fn between(changes: Vec<f64>) -> Vec<(f64, f64)> {
    let mut intervals: Vec<(f64, f64)> = Vec::new();
    let mut from = Some(0.0);
    for change in changes {
        match from.take() {
            Some(start) => intervals.push((start, change)),
            None => {
                from = match intervals.last() {
                    Some(last) if change - last.1 < Stable::NARROWEST => intervals.pop().map(|last| last.0),
                    _ => Some(change),
                }
            }
        }
    }
    intervals.extend(from.map(|start| (start, Stable::LARGEST)));
    intervals
}

/// A run of the two-step form from x₀ = 1 and a given x₁.
#[derive(Debug, Clone, Copy)]
pub struct TwoStepRun {
    /// The method.
    pub method: &'static str,
    /// τ = ωh.
    pub tau: f64,
    /// x₁.
    pub first: f64,
    /// Steps to take.
    pub steps: u32,
}

/// Positions and momenta of a run.
#[derive(Debug)]
pub struct Sequence {
    /// x₀, x₁, ….
    pub x: Vec<f64>,
    /// The momenta p₁, p₂, … that end each step, from index 1 on.
    pub p: Vec<f64>,
}

impl TwoStepRun {
    /// The rounding of a step of the recurrence: values of the size of x, rounded, pass through two differentiations, to p at
    /// one end of a step and back to x.
    ///
    /// # Errors
    /// If there is no such method.
    pub fn rounding(&self, largest: f64) -> Result<f64, StudyError> {
        let slopes = method::parse(self.method)?.momentum_roundoff(1.0);
        Ok(16.0 * f64::EPSILON * (1.0 + slopes * slopes) * largest)
    }
}

impl Experiment for TwoStepRun {
    const ID: &'static str = "two-step-run";
    type Found = Sequence;

    fn measure(&self, _: &Context) -> Result<Sequence, StudyError> {
        let Self { method, tau, first, steps } = *self;
        let oscillator = problem::build_setting(OSCILLATOR)?;
        let mut live = TwoStep::new(discretise(&*method::parse(method)?, &*oscillator)?);
        let (mut x, mut p) = (vec![1.0, first], vec![f64::NAN]);
        let (mut before, mut now, mut momentum) = ([1.0], [first], [0.0]);
        for k in 1..=steps {
            let t = tau * f64::from(k);
            live.momentum(t - tau, tau, &before, &now, &mut momentum)?;
            p.push(momentum[0]);
            live.step(t, tau, &mut before, &mut now)?;
            x.push(now[0]);
        }
        Ok(Sequence { x, p })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instability_that_is_only_touched_ends_no_interval() {
        assert_eq!(between(vec![1.0, 1.0 + 1e-12, 2.0, 3.0]), [(0.0, 2.0), (3.0, Stable::LARGEST)]);
    }

    #[test]
    fn stormer_verlet_is_stable_up_to_2() {
        let found = Context::silent().get(Stable { method: "stormer-verlet".into() }).expect("linear");
        // The derivative that vanishes has slope 2 there.
        assert!(found.len() == 1 && (found[0].1 - 2.0).abs() < 1e-12, "{found:?}");
    }

    /// Störmer–Verlet has R = 2 − τ², of numbers of order 1 and derivatives with slopes of 1 at τ = 1.
    #[test]
    fn a_trace_that_is_off_by_a_thousand_roundings_is_found() {
        let found = StepMap { method: "stormer-verlet".into(), tau: 1.0 }.measure(&Context::silent()).expect("linear");
        let off = |roundings: f64| (found.trace - 1.0 - roundings * f64::EPSILON).abs();
        assert!(off(0.0) <= found.rounding && (found.determinant - 1.0).abs() <= found.rounding, "{found:?}");
        assert!(off(1000.0) > found.rounding && off(-1000.0) > found.rounding, "{found:?}");
    }
}
