//! Flows on the periodic square.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use lsvi::VectorField;
use lsvi::solver::{Iterative, StepSolver};

use super::periodic::{Helmholtz, Metric, Periodic};
use crate::kinds::Principle;
use crate::names::{NameError, Parameter, Parameters};
use crate::problem::{Facts, Invariant, Limit, Problem, Spec};
use crate::reference::Ode;

const CELLS: Parameter =
    Parameter { name: "cells", default: "32", meaning: "number of grid points N along a side, even" };
const METRIC: Parameter =
    Parameter { name: "metric", default: "velocity", meaning: "what measures the residual: velocity or vorticity" };

pub(in crate::problem) const TAYLOR_GREEN: Spec = Spec {
    name: "taylor-green",
    summary: "Taylor and Green's vortices on the periodic square, carried by a mean flow: exact",
    parameters: &[
        CELLS,
        Parameter { name: "re", default: "10", meaning: "Reynolds number Re > 0: ν = 1/Re" },
        Parameter { name: "mean", default: "1", meaning: "mean velocity, (U, U/2)" },
        METRIC,
    ],
    build: |p| {
        let nu = 1.0 / p.positive("re")?;
        let mean = p.number("mean")?;
        build(p, nu, [mean, 0.5 * mean], Start::TaylorGreen)
    },
};

pub(in crate::problem) const SHEAR_LAYER: Spec = Spec {
    name: "shear-layer",
    summary: "two shear layers on the periodic square that roll up: u = tanh, v = 0.05 sin x",
    parameters: &[
        CELLS,
        Parameter { name: "re", default: "200", meaning: "Reynolds number Re > 0: ν = 1/Re" },
        Parameter { name: "thickness", default: "0.5", meaning: "thickness δ > 0 of the layers" },
        METRIC,
    ],
    build: |p| {
        let nu = 1.0 / p.positive("re")?;
        let thickness = p.positive("thickness")?;
        build(p, nu, [0.0; 2], Start::ShearLayer { thickness })
    },
};

pub(in crate::problem) const TURBULENCE: Spec = Spec {
    name: "turbulence-2d",
    summary: "decaying two-dimensional turbulence on the periodic square, from random phases around a wave number",
    parameters: &[
        CELLS,
        Parameter { name: "re", default: "200", meaning: "Reynolds number Re > 0: ν = 1/Re" },
        Parameter { name: "peak", default: "4", meaning: "wave number > 0 of the largest eddies at t = 0" },
        METRIC,
    ],
    build: |p| {
        let nu = 1.0 / p.positive("re")?;
        let peak = p.positive("peak")?;
        build(p, nu, [0.0; 2], Start::Random { peak })
    },
};

/// Fewer points have no two modes that interact.
const POINTS: RangeInclusive<usize> = 6..=1024;

fn build(p: &Parameters, nu: f64, mean: [f64; 2], start: Start) -> Result<Box<dyn Problem>, NameError> {
    let cells = p.count("cells", POINTS)?;
    if cells % 2 != 0 {
        return Err(NameError::Value {
            parameter: "cells".into(),
            value: cells.to_string(),
            reason: "the Fourier method needs an even number".into(),
        });
    }
    let metric = p.choice("metric", &[("velocity", Metric::Velocity), ("vorticity", Metric::Vorticity)])?;
    Ok(Box::new(OnTorus { flow: Periodic::new(cells, nu, mean, metric), start }))
}

/// The vorticity at t = 0.
#[derive(Debug, Clone, Copy)]
enum Start {
    /// 2 cos x cos y: ψ is an eigenfunction of the Laplacian, so that only the mean flow moves it.
    TaylorGreen,
    /// Of u = tanh((y − π/2)/δ) and its mirror image, v = 0.05 sin x.
    ShearLayer { thickness: f64 },
    /// |ω_k| ∝ κ³ e^{−κ²}, κ = |k|/k₀, with phases without pattern, scaled to an energy of ½.
    Random { peak: f64 },
}

/// A flow on the periodic square.
#[derive(Debug)]
struct OnTorus {
    flow: Periodic,
    start: Start,
}

impl OnTorus {
    /// The fastest rate of viscous decay.
    fn fastest(&self) -> f64 {
        let largest = self.flow.modes.waves.iter().map(|[k, l]| k * k + l * l).max();
        self.flow.nu * f64::from(largest.unwrap_or(0))
    }

    /// The coefficients of [`Start::Random`], the same on every grid.
    fn random(&self, peak: f64) -> Vec<f64> {
        let waves = &self.flow.modes.waves;
        let mut v = Vec::with_capacity(2 * waves.len());
        for [k, l] in waves {
            let ratio = f64::from(k * k + l * l) / (peak * peak);
            let size = ratio.powf(1.5) * (-ratio).exp();
            // A phase that depends on the wave number alone.
            let mixed = (f64::from(*k) * 12.9898 + f64::from(*l) * 78.233).sin() * 43_758.545_3;
            let (s, c) = (2.0 * PI * mixed.fract()).sin_cos();
            v.extend([size * c, size * s]);
        }
        let [energy, _] = self.flow.energy_and_enstrophy(&v);
        let scale = (0.5 / energy).sqrt();
        v.iter_mut().for_each(|x| *x *= scale);
        v
    }
}

impl Ode for OnTorus {
    fn dim(&self) -> usize {
        self.flow.modes.dim()
    }

    /// The convolution sum over all pairs of modes: no grid and no transform.
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        super::convolution::rhs(self.flow.nu, self.flow.mean, self.flow.modes.points, v, dv);
    }

    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        super::convolution::jacobian(self.flow.nu, self.flow.mean, self.flow.modes.points, v, add);
    }
}

impl Problem for OnTorus {
    fn components(&self) -> &'static [&'static str] {
        &["vorticity"]
    }
    /// The vorticity on the grid, row by row in y.
    fn observe(&self, _t: f64, state: &[f64]) -> Vec<f64> {
        self.flow.vorticity(state)
    }
    fn initial(&self) -> Vec<f64> {
        match self.start {
            Start::TaylorGreen => self.flow.project(|x, y| 2.0 * x.cos() * y.cos()),
            Start::ShearLayer { thickness } => self.flow.project(|x, y| {
                let sech2 = |z: f64| 1.0 / (z / thickness).cosh().powi(2) / thickness;
                let layers = if y < PI { -sech2(y - 0.5 * PI) } else { sech2(1.5 * PI - y) };
                layers + 0.05 * x.cos()
            }),
            Start::Random { peak } => self.random(peak),
        }
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(self.flow.field())
    }
    fn solver(&self) -> Option<Box<dyn StepSolver>> {
        Some(Box::new(Iterative::new(Helmholtz::new(&self.flow))))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let Start::TaylorGreen = self.start else { return None };
        let decay = (-2.0 * self.flow.nu * t).exp();
        let [u, v] = self.flow.mean;
        let rows: Vec<f64> = self.flow.modes.coordinates().collect();
        let values = rows.iter().flat_map(|y| rows.iter().map(move |x| 2.0 * (x - u * t).cos() * (y - v * t).cos()));
        Some(values.map(|w| decay * w).collect())
    }
    /// Conserved without viscosity.
    fn quantities(&self) -> Vec<Invariant<'_>> {
        let moment = |place: usize| move |v: &[f64]| self.flow.energy_and_enstrophy(v)[place];
        vec![Invariant::new("energy", moment(0)), Invariant::new("enstrophy", moment(1))]
    }
    fn limit(&self, _principle: Principle) -> Limit<'_> {
        Limit::semi_discrete(self, |t| {
            let Start::TaylorGreen = self.start else { return None };
            let decay = (-2.0 * self.flow.nu * t).exp();
            let [u, v] = self.flow.mean;
            Some(self.flow.project(|x, y| 2.0 * decay * (x - u * t).cos() * (y - v * t).cos()))
        })
    }
    fn facts(&self) -> Facts {
        Facts::semi_discrete(self.fastest())
    }
}
