//! What cubic Hermite elements miss of a flow at the grid points, to leading order.
//!
//! Galerkin's solution is nearer to the Ritz projection of the flow than that is to the flow. The slope of the projection is that of u_y onto
//! continuous quadratics in the mean square, and far from the walls it misses u at a grid point by Δ⁴ u_yyyy/720. At a wall it misses nothing; what is
//! taken from the term there fades by q = 3 − 2√2 from one grid point to the next, the root of q² − 6q + 1 below 1: the mass matrix of continuous
//! quadratics, rid of their bubbles, is (−1, 6, −1) but for a factor. Derivatives in y are those in t of u_t = γ cos ωt + ν u_yy.

use crate::measure::norm::{distance, max_norm};
use crate::names::{NameError, Parameters};
use crate::problem::{Problem, Spec};

use super::flow::Flow;
use super::space::Scheme;
use super::{COUETTE, Channel, POISEUILLE, STOKES2, WOMERSLEY};

/// What is left of the errors at the grid points, and of what it may be.
#[derive(Debug, Clone, Copy)]
pub struct Remainder {
    /// The largest error less its leading term.
    pub left: f64,
    /// The next term, Δ⁶ u_yyyyyy/720, where that is largest.
    pub next: f64,
    /// The rounding of the solution: eigenvalues of the size of N² carry N² roundings into the slow modes.
    pub rounding: f64,
}

impl Remainder {
    /// What is left over what may be: up to 1 where the leading term is all but the next one.
    pub fn ratio(self) -> f64 {
        self.left / (self.next + self.rounding)
    }
}

/// The remainder of a flow with its defaults, in so many elements.
pub(crate) fn remainder(name: &str, cells: usize, t: f64) -> Result<Remainder, NameError> {
    let specs = [POISEUILLE, COUETTE, WOMERSLEY, STOKES2];
    let spec: &Spec = specs
        .iter()
        .find(|spec| spec.name == name)
        .ok_or_else(|| NameError::unknown("flow", name, specs.iter().map(|spec| spec.name)))?;
    let p = Parameters::new(spec.parameters, &[])?;
    let given = |name: &str| if p.text(name).is_ok() { p.number(name) } else { Ok(0.0) };
    let flow = Flow { nu: given("nu")?, gamma: given("gamma")?, wall: given("wall")?, omega: given("omega")? };
    Ok(of_flow(flow, cells, t))
}

pub(super) fn of_flow(flow: Flow, cells: usize, t: f64) -> Remainder {
    let channel = Channel::with(Scheme::Hermite, cells, flow);
    // Nothing to compare, and so NaN, where the system is too large for its modes.
    let solved = channel.modes().map(|modes| channel.observe(t, &modes.solution(t))).unwrap_or_default();
    let expected = flow_and_leading_term(flow, cells, t);
    let length = 2.0 / cells as f64;
    let sixth: Vec<f64> = (0..=cells).map(|j| sixth(flow, place(j, cells), t)).collect();
    Remainder {
        left: distance(&solved, &expected),
        next: length.powi(6) / 720.0 * max_norm(&sixth),
        rounding: f64::EPSILON * (cells * cells) as f64,
    }
}

fn place(j: usize, cells: usize) -> f64 {
    2.0 * j as f64 / cells as f64 - 1.0
}

/// The flow and the leading term of the error at the interior grid points.
fn flow_and_leading_term(flow: Flow, cells: usize, t: f64) -> Vec<f64> {
    let (length, q) = (2.0 / cells as f64, 3.0 - 2.0 * std::f64::consts::SQRT_2);
    let [left, right] = [-1.0, 1.0].map(|wall| fourth(flow, wall, t));
    let at = |j: usize| {
        let layers = left * q.powi(j as i32) + right * q.powi((cells - j) as i32);
        flow.velocity(place(j, cells), t) + length.powi(4) / 720.0 * (fourth(flow, place(j, cells), t) - layers)
    };
    (1..cells).map(at).collect()
}

/// Between the times of a difference: short for waves that are left after a quarter of a unit of time, long for rounding.
const STEP: f64 = 5e-3;

/// ν² u_yyyy = u_tt + γω sin ωt, by the difference of fourth order.
fn fourth(flow: Flow, y: f64, t: f64) -> f64 {
    let u = |k: f64| flow.velocity(y, t + k * STEP);
    let second = (-u(-2.0) + 16.0 * u(-1.0) - 30.0 * u(0.0) + 16.0 * u(1.0) - u(2.0)) / (12.0 * STEP * STEP);
    (second + flow.gamma * flow.omega * (flow.omega * t).sin()) / flow.nu.powi(2)
}

/// ν³ u_yyyyyy = u_ttt + γω² cos ωt, of which the size is enough.
fn sixth(flow: Flow, y: f64, t: f64) -> f64 {
    let u = |k: f64| flow.velocity(y, t + k * STEP);
    let third = (u(2.0) - 2.0 * u(1.0) + 2.0 * u(-1.0) - u(-2.0)) / (2.0 * STEP.powi(3));
    (third + flow.gamma * flow.omega.powi(2) * flow.phase(t)) / flow.nu.powi(3)
}
