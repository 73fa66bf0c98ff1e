//! Lines on which nonlinear homogeneous conditions F(pₙ, pₙ₊₁) = 0 hold.

use std::f64::consts::PI;

use lsvi::closure::{Linear, LinearClosure};

use super::{Context, Experiment, StudyError};
use crate::measure::norm::Extremes;

/// Several F of degrees 2 to 4.
#[derive(Debug)]
pub struct Lines;

/// The line of one of them that is nearest to α/β = 0.9.
#[derive(Debug)]
pub struct Line {
    /// F.
    pub name: &'static str,
    /// Its degree, from its values.
    pub degree: f64,
    /// α/β.
    pub ratio: f64,
    /// |F| at a point of the line over its largest value at the same distance from the origin, by scale.
    pub sizes: Vec<(f64, f64)>,
}

type Condition = fn(f64, f64) -> f64;

const CONDITIONS: [(&str, Condition); 4] = [
    ("pₙ pₙ₊₁ + pₙ₊₁²", |a, b| a * b + b * b),
    ("pₙ³ + pₙ₊₁³", |a, b| a.powi(3) + b.powi(3)),
    ("pₙ₊₁³ − ½ pₙ² pₙ₊₁ + pₙ³", |a, b| b.powi(3) - 0.5 * a * a * b + a.powi(3)),
    ("pₙ₊₁⁴ − 2 pₙ pₙ₊₁³", |a, b| b.powi(4) - 2.0 * a * b.powi(3)),
];

impl Experiment for Lines {
    const ID: &'static str = "homogeneous";
    type Found = Vec<Line>;

    fn measure(&self, _: &Context) -> Result<Vec<Line>, StudyError> {
        let mut found = Vec::new();
        for (name, f) in CONDITIONS {
            let line = Linear::from_homogeneous(f, (0.9, 1.0))?.weights(1.0);
            let size = |scale: f64| {
                let (a, b) = (scale * line.beta, -scale * line.alpha);
                let around = (0..16).map(|i| (0.125 * PI * f64::from(i)).sin_cos());
                let largest = around.map(|(x, y)| f(a.hypot(b) * x, a.hypot(b) * y).abs()).largest();
                (scale, f(a, b).abs() / largest)
            };
            found.push(Line {
                name,
                degree: (f(2.0, 0.6) / f(1.0, 0.3)).log2(),
                ratio: line.alpha / line.beta,
                sizes: [1e-3, 1.0, 1e3].map(size).into(),
            });
        }
        Ok(found)
    }
}
