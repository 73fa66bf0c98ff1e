//! The lid-driven cavity, and a flow in it that is known.

use std::f64::consts::PI;

use super::confined::Given;
use super::problem::InRectangle;
use super::staggered::{Closed, Rectangle};
use crate::names::Parameter;
use crate::problem::Spec;

pub(in crate::problem) const CAVITY: Spec = Spec {
    name: "cavity",
    summary: "lid-driven cavity on the unit square, started impulsively; divergence-free velocities on a staggered grid",
    parameters: &[
        Parameter { name: "cells", default: "32", meaning: "number of cells N along a side" },
        Parameter { name: "re", default: "100", meaning: "Reynolds number Re > 0 of the lid's speed 1 and the side 1" },
    ],
    build: |p| Ok(Box::new(InRectangle::new(square(p.count("cells", CELLS)?), 1.0 / p.positive("re")?, Lid))),
};

pub(in crate::problem) const MANUFACTURED: Spec = Spec {
    name: "cavity-manufactured",
    summary: "cavity with a lid of speed a(t) sin² πx and the force for which ψ = a(t) sin² πx (y³ − y²)",
    parameters: &[
        Parameter { name: "cells", default: "16", meaning: "number of cells N along a side" },
        Parameter { name: "re", default: "10", meaning: "Reynolds number Re > 0" },
    ],
    build: |p| {
        let nu = 1.0 / p.positive("re")?;
        Ok(Box::new(InRectangle::new(square(p.count("cells", CELLS)?), nu, Manufactured { nu })))
    },
};

/// What the lid-driven cavity is given.
pub(crate) fn lid() -> impl Given {
    Lid
}

/// What the manufactured flow is given.
pub(crate) fn manufactured(nu: f64) -> impl Given {
    Manufactured { nu }
}

/// Fewer cells have no interior corner; more would need gigabytes for factors.
pub(super) const CELLS: std::ops::RangeInclusive<usize> = 2..=512;

pub(super) fn square(cells: usize) -> Rectangle {
    Rectangle { origin: [0.0; 2], size: [1.0; 2], cells: [cells; 2], closed: Closed::Sides }
}

/// The lid y = 1 moves with velocity 1 from t = 0 on.
#[derive(Debug)]
pub(super) struct Lid;

impl Given for Lid {
    fn velocity(&self, [_, y]: [f64; 2], _t: f64) -> [f64; 2] {
        [if y == 1.0 { 1.0 } else { 0.0 }, 0.0]
    }
}

/// ψ = a(t) X(x) Y(y) with X = sin² πx, Y = y³ − y² and a = 1 + ½ sin 2t, without a pressure.
#[derive(Debug)]
struct Manufactured {
    nu: f64,
}

fn amplitude(t: f64) -> [f64; 2] {
    [1.0 + 0.5 * (2.0 * t).sin(), (2.0 * t).cos()]
}

/// X and its first three derivatives.
fn along(x: f64) -> [f64; 4] {
    let (s, c) = (2.0 * PI * x).sin_cos();
    [(PI * x).sin().powi(2), PI * s, 2.0 * PI * PI * c, -4.0 * PI.powi(3) * s]
}

/// Y and its first three derivatives.
fn across(y: f64) -> [f64; 4] {
    [y * y * (y - 1.0), y * (3.0 * y - 2.0), 6.0 * y - 2.0, 6.0]
}

impl Given for Manufactured {
    fn stream(&self, [x, y]: [f64; 2], t: f64) -> f64 {
        amplitude(t)[0] * along(x)[0] * across(y)[0]
    }

    fn stream_rate(&self, [x, y]: [f64; 2], t: f64) -> f64 {
        amplitude(t)[1] * along(x)[0] * across(y)[0]
    }

    fn velocity(&self, [x, y]: [f64; 2], t: f64) -> [f64; 2] {
        let ([a, _], p, q) = (amplitude(t), along(x), across(y));
        [a * p[0] * q[1], -a * p[1] * q[0]]
    }

    /// u_t + (u·∇)u − ν Δu.
    fn force(&self, [x, y]: [f64; 2], t: f64) -> Option<[f64; 2]> {
        let ([a, rate], p, q) = (amplitude(t), along(x), across(y));
        let [u, v] = [a * p[0] * q[1], -a * p[1] * q[0]];
        let (u_x, u_y) = (a * p[1] * q[1], a * p[0] * q[2]);
        let (v_x, v_y) = (-a * p[2] * q[0], -a * p[1] * q[1]);
        let laplacians = [a * (p[2] * q[1] + p[0] * q[3]), -a * (p[3] * q[0] + p[1] * q[2])];
        Some([
            rate * p[0] * q[1] + u * u_x + v * u_y - self.nu * laplacians[0],
            -rate * p[1] * q[0] + u * v_x + v * v_y - self.nu * laplacians[1],
        ])
    }

    fn exact(&self, at: [f64; 2], t: f64) -> Option<[f64; 2]> {
        Some(self.velocity(at, t))
    }
}
