//! Growth of single steps on v̇ = λv in the complex plane.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Complex;

use super::propagator::amplitudes;
use super::{Context, Experiment, StudyError};
use crate::measure::norm::Extremes;
use crate::measure::search::root;
use crate::measure::stability::growth;
use crate::method::{self, Method};

/// Growth beyond 1 by less than this is roundoff: a recurrence with two roots loses up to half of the digits.
pub const ROUNDOFF: f64 = 1e-7;
/// Where behaviour at infinity is read off.
pub const FAR: f64 = 1e6;

/// |R| over one solution of the equations; infinite where the step has no solution, which is no stable step.
fn factor(method: &dyn Method, z: Complex<f64>) -> f64 {
    let found = amplitudes(method, z).map_or(f64::NAN, growth);
    if found.is_nan() { f64::INFINITY } else { found }
}

/// |R| for each row.
fn factor_per_row(method: &dyn Method, z: Complex<f64>) -> f64 {
    factor(method, z).powf((method.traits().rows_per_solve as f64).recip())
}

/// The methods that make steps of the given size on v̇ = Av.
#[derive(Debug)]
pub struct Subjects;

impl Experiment for Subjects {
    const ID: &'static str = "stability-subjects";
    type Found = Vec<String>;

    fn measure(&self, _: &Context) -> Result<Vec<String>, StudyError> {
        let applies = |method: &dyn Method| amplitudes(method, Complex::new(-0.1, 0.0)).is_ok();
        let all = method::examples().into_iter().filter(|method| applies(&**method));
        Ok(all.map(|method| method.name()).collect())
    }
}

/// A search over the left half-plane.
#[derive(Debug)]
pub struct Profile {
    /// The method.
    pub method: String,
    /// Radii from 0.01 to 10⁴.
    pub radii: u32,
    /// Directions of the upper left quarter-plane; the lower one mirrors it, because the methods are real.
    pub directions: u32,
}

/// What it found.
#[derive(Debug)]
pub struct Found {
    /// Largest growth of a row for Re z ≤ 0.
    pub largest: f64,
    /// Where it is.
    pub at: Complex<f64>,
    /// |R| at z = −[`FAR`].
    pub on_axis: f64,
    /// Largest |R| for |z| = [`FAR`] and Re z ≤ 0.
    pub far: f64,
}

impl Found {
    /// Whether no point is unstable.
    pub fn is_a_stable(&self) -> bool {
        self.largest <= 1.0 + ROUNDOFF
    }
}

impl Experiment for Profile {
    const ID: &'static str = "stability-profile";
    type Found = Found;

    fn measure(&self, context: &Context) -> Result<Found, StudyError> {
        context.announce(1);
        let method = method::parse(&self.method)?;
        let part = |k: u32, of: u32| f64::from(k) / f64::from(of - 1);
        let (mut largest, mut at) = (0.0, Complex::new(0.0, 0.0));
        for (i, k) in (0..self.radii).flat_map(|i| (0..self.directions).map(move |k| (i, k))) {
            let radius = 10_f64.powf(6.0 * part(i, self.radii) - 2.0);
            let z = Complex::from_polar(radius, FRAC_PI_2 * (1.0 + part(k, self.directions)));
            let growth = factor_per_row(&*method, z);
            if growth > largest {
                (largest, at) = (growth, z);
            }
        }
        let far = [0.5, 0.51, 0.75, 1.0].map(|turn| factor(&*method, Complex::from_polar(FAR, turn * PI)));
        let on_axis = factor(&*method, Complex::new(-FAR, 0.0));
        context.tick();
        Ok(Found { largest, at, on_axis, far: far.into_iter().largest() })
    }
}

/// The length of the stable part of a ray from 0.
#[derive(Debug)]
pub struct StableInterval {
    /// The method.
    pub method: String,
    /// Its angle in units of π: 1 for the negative real axis, ½ for the imaginary one.
    pub turn: f64,
}

impl Experiment for StableInterval {
    const ID: &'static str = "stable-interval";
    /// The largest r such that |R| is at most 1 from 0 to r; 0 if it is not at 0.1, infinite if it is up to 100.
    type Found = f64;

    fn measure(&self, _: &Context) -> Result<f64, StudyError> {
        let method = method::parse(&self.method)?;
        let is_stable = |r: f64| factor(&*method, Complex::from_polar(r, self.turn * PI)) <= 1.0 + ROUNDOFF;
        let mut reached = 0.1;
        if !is_stable(reached) {
            return Ok(0.0);
        }
        let mut ahead = 1.05 * reached;
        while is_stable(ahead) {
            if ahead > 100.0 {
                return Ok(f64::INFINITY);
            }
            (reached, ahead) = (ahead, 1.05 * ahead);
        }
        Ok(root([reached, ahead], |r| if is_stable(r) { 1.0 } else { -1.0 }).unwrap_or(f64::NAN))
    }
}

/// Growth of a row at points of the plane.
#[derive(Debug)]
pub struct Growth {
    /// The method.
    pub method: String,
    /// The points.
    pub points: Points,
}

/// Points of the complex plane.
#[derive(Debug, Clone, Copy)]
pub enum Points {
    /// A grid over −8 ≤ Re z ≤ 4 and 0 ≤ Im z ≤ 6, row by row.
    Grid,
    /// Radii from 0.1 to 1000 along a ray, with its angle in units of π.
    Ray(f64),
}

impl Points {
    /// The abscissae of the grid.
    pub fn re() -> Vec<f64> {
        (0..61).map(|i| -8.0 + 0.2 * f64::from(i)).collect()
    }

    /// Its ordinates.
    pub fn im() -> Vec<f64> {
        (0..31).map(|j| 0.2 * f64::from(j)).collect()
    }

    /// The radii of a ray.
    pub fn radii() -> Vec<f64> {
        (0..=60).map(|i| 10_f64.powf(f64::from(i) / 15.0 - 1.0)).collect()
    }

    fn all(self) -> Vec<Complex<f64>> {
        match self {
            Self::Grid => Self::im().iter().flat_map(|y| Self::re().into_iter().map(|x| Complex::new(x, *y))).collect(),
            Self::Ray(turn) => Self::radii().into_iter().map(|r| Complex::from_polar(r, turn * PI)).collect(),
        }
    }
}

impl Experiment for Growth {
    const ID: &'static str = "growth";
    type Found = Vec<f64>;

    fn measure(&self, context: &Context) -> Result<Vec<f64>, StudyError> {
        context.announce(1);
        let method = method::parse(&self.method)?;
        let found = self.points.all().into_iter().map(|z| factor_per_row(&*method, z)).collect();
        context.tick();
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each row of a window of four steps is about e^z from the one before, for short steps.
    #[test]
    fn growth_is_that_of_a_row() {
        let points = Points::Ray(1.0);
        let found =
            Context::new(&|_| {}, &|| {}, 1).get(Growth { method: "window(4)".into(), points }).expect("it runs");
        let (z, factor) = (-Points::radii()[0], found[0]);
        assert!((factor - z.exp()).abs() < 1e-3, "{factor} at {z}");
    }
}
