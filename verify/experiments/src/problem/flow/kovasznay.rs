//! Kovasznay's flow behind a grid, an exact solution of the full equations.

use std::f64::consts::PI;

use super::cavity::CELLS;
use super::confined::Given;
use super::problem::InRectangle;
use super::staggered::{Closed, Rectangle};
use crate::names::Parameter;
use crate::problem::Spec;

pub(in crate::problem) const SPEC: Spec = Spec {
    name: "kovasznay",
    summary: "Kovasznay's flow behind a grid on −½ < x < 1, −½ < y < 1, seen from a frame that moves along x",
    parameters: &[
        Parameter { name: "cells", default: "16", meaning: "number of cells N along a side" },
        Parameter { name: "re", default: "40", meaning: "Reynolds number Re > 0" },
        Parameter { name: "speed", default: "0.5", meaning: "speed c of the frame; 0: the flow is steady" },
    ],
    build: |p| {
        let (cells, re) = (p.count("cells", CELLS)?, p.positive("re")?);
        let rectangle = Rectangle { origin: [-0.5; 2], size: [1.5; 2], cells: [cells; 2], closed: Closed::Sides };
        Ok(Box::new(InRectangle::new(rectangle, 1.0 / re, kovasznay(re, p.number("speed")?))))
    },
};

/// u = 1 − e^{λx} cos 2πy and v = (λ/2π) e^{λx} sin 2πy, λ = Re/2 − √(Re²/4 + 4π²), in a frame in which it moves with
/// velocity c along x.
#[derive(Debug)]
struct Kovasznay {
    decay: f64,
    speed: f64,
}

/// The flow at a Reynolds number, from a frame of that speed.
pub(super) fn kovasznay(re: f64, speed: f64) -> impl Given {
    Kovasznay { decay: 0.5 * re - (0.25 * re * re + 4.0 * PI * PI).sqrt(), speed }
}

impl Kovasznay {
    fn exponential(&self, x: f64, t: f64) -> f64 {
        (self.decay * (x - self.speed * t)).exp()
    }
}

impl Given for Kovasznay {
    fn stream(&self, [x, y]: [f64; 2], t: f64) -> f64 {
        (1.0 + self.speed) * y - self.exponential(x, t) * (2.0 * PI * y).sin() / (2.0 * PI)
    }

    fn stream_rate(&self, [x, y]: [f64; 2], t: f64) -> f64 {
        self.decay * self.speed * self.exponential(x, t) * (2.0 * PI * y).sin() / (2.0 * PI)
    }

    fn velocity(&self, [x, y]: [f64; 2], t: f64) -> [f64; 2] {
        let (s, c) = (2.0 * PI * y).sin_cos();
        let e = self.exponential(x, t);
        [1.0 + self.speed - e * c, self.decay / (2.0 * PI) * e * s]
    }

    fn exact(&self, at: [f64; 2], t: f64) -> Option<[f64; 2]> {
        Some(self.velocity(at, t))
    }
}
