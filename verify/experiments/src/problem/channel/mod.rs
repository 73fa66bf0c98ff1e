//! Flow between two plates, discretised in space: u_t = γ cos ωt + ν u_yy on |y| ≤ 1, the wall y = 1 moving with W cos ωt.

mod band;
mod flow;
mod hermite;
mod modes;
mod space;
#[cfg(test)]
mod tests;

use std::sync::OnceLock;

use lsvi::{Jacobian, Mass, Structure, VectorField};

use self::band::Cholesky;
use self::flow::Flow;
pub use self::hermite::Remainder;
pub(crate) use self::hermite::remainder;
use self::modes::Modes;
use self::space::{Scheme, Shapes, Space};
use super::{Facts, Limit, Problem, Spec};
use crate::kinds::Principle;
use crate::names::{NameError, Parameter, Parameters};
use crate::reference::Ode;

const CELLS: Parameter =
    Parameter { name: "cells", default: "32", meaning: "number of cells N; of modes for legendre" };
const SCHEME: Parameter =
    Parameter { name: "scheme", default: "fd", meaning: "fd, fv, hermite, legendre, or strong-linear, which fails" };
const VISCOSITY: Parameter = Parameter { name: "nu", default: "1", meaning: "viscosity ν > 0" };

pub(super) const POISEUILLE: Spec = Spec {
    name: "channel-poiseuille",
    summary: "u_t = γ + ν u_yy from rest between walls at rest, N cells; exact flow (34)",
    parameters: &[CELLS, SCHEME, VISCOSITY, Parameter { name: "gamma", default: "2", meaning: "pressure gradient γ" }],
    build: |p| Channel::of(p, |nu| Ok(Flow { nu, gamma: p.number("gamma")?, wall: 0.0, omega: 0.0 })),
};

pub(super) const COUETTE: Spec = Spec {
    name: "channel-couette",
    summary: "u_t = ν u_yy from rest, the wall y = 1 set in motion at t = 0, N cells; exact flow by images and modes",
    parameters: &[
        CELLS,
        SCHEME,
        VISCOSITY,
        Parameter { name: "wall", default: "1", meaning: "velocity W of the wall" },
    ],
    build: |p| Channel::of(p, |nu| Ok(Flow { nu, gamma: 0.0, wall: p.number("wall")?, omega: 0.0 })),
};

pub(super) const WOMERSLEY: Spec = Spec {
    name: "channel-womersley",
    summary: "u_t = γ cos ωt + ν u_yy between walls at rest, periodic, N cells; exact flow by hyperbolic functions",
    parameters: &[
        CELLS,
        SCHEME,
        VISCOSITY,
        Parameter { name: "gamma", default: "2", meaning: "amplitude γ of the pressure gradient" },
        Parameter { name: "omega", default: "4", meaning: "angular frequency ω > 0" },
    ],
    build: |p| Channel::of(p, |nu| Ok(Flow { nu, gamma: p.number("gamma")?, wall: 0.0, omega: p.positive("omega")? })),
};

pub(super) const STOKES2: Spec = Spec {
    name: "channel-stokes2",
    summary: "u_t = ν u_yy, the wall y = 1 moving with W cos ωt, periodic, N cells; Stokes' second problem in a gap",
    parameters: &[
        CELLS,
        SCHEME,
        VISCOSITY,
        Parameter { name: "wall", default: "1", meaning: "amplitude W of the wall's velocity" },
        Parameter { name: "omega", default: "4", meaning: "angular frequency ω > 0" },
    ],
    build: |p| Channel::of(p, |nu| Ok(Flow { nu, gamma: 0.0, wall: p.number("wall")?, omega: p.positive("omega")? })),
};

/// Cells of the banded schemes for which states, matrices and their factors fit into a few hundred megabytes.
const MAX_CELLS: usize = 1 << 19;

/// Modes of the spectral scheme; every one is evaluated at every point.
const MAX_MODES: usize = 1 << 11;

/// Unknowns up to which the semi-discrete system is solved exactly by its modes.
const MAX_EXACT: usize = 256;

/// A flow in N cells.
#[derive(Debug)]
struct Channel {
    flow: Flow,
    space: Space,
    points: Vec<f64>,
    shapes: Vec<Shapes>,
    /// γ b − W ν k, the load in phase with cos ωt.
    load: Vec<f64>,
    mass: Cholesky,
    modes: OnceLock<Option<Modes>>,
}

impl Channel {
    fn of(
        parameters: &Parameters,
        flow: impl FnOnce(f64) -> Result<Flow, NameError>,
    ) -> Result<Box<dyn Problem>, NameError> {
        let schemes = [
            ("fd", Scheme::Differences),
            ("fv", Scheme::Volumes),
            ("hermite", Scheme::Hermite),
            ("legendre", Scheme::Legendre),
            ("strong-linear", Scheme::StrongLinear),
        ];
        let scheme = parameters.choice("scheme", &schemes)?;
        let most = if scheme == Scheme::Legendre { MAX_MODES } else { MAX_CELLS };
        let cells = parameters.count("cells", 2..=most)?;
        Ok(Box::new(Self::with(scheme, cells, flow(parameters.positive("nu")?)?)))
    }

    fn with(scheme: Scheme, cells: usize, flow: Flow) -> Self {
        let space = Space::new(scheme, cells);
        let points = space.points();
        let shapes = points.iter().map(|y| space.shapes(*y)).collect();
        let sources = space.source.iter().zip(&space.wall_stiffness);
        let load = sources.map(|(b, k)| flow.gamma * b - flow.wall * flow.nu * k).collect();
        let mass = space.mass.cholesky();
        Self { flow, space, points, shapes, load, mass, modes: OnceLock::new() }
    }

    /// Writes −ν K c + γ b cos ωt − W ν k cos ωt + W m ω sin ωt, the right-hand side M ċ.
    fn forces(&self, t: f64, c: &[f64], out: &mut [f64]) {
        let phase = self.flow.phase(t);
        let acceleration = self.flow.wall * self.flow.omega * (self.flow.omega * t).sin();
        for (out, (load, mass)) in out.iter_mut().zip(self.load.iter().zip(&self.space.wall_mass)) {
            *out = load * phase + mass * acceleration;
        }
        self.space.stiffness.mul_add(-self.flow.nu, c, out);
    }

    /// The exact solution of the semi-discrete system, unless it is large.
    fn modes(&self) -> Option<&Modes> {
        let small = self.space.mass.dim() <= MAX_EXACT;
        self.modes.get_or_init(|| small.then(|| Modes::new(self))).as_ref()
    }

    /// The fastest rate of decay; that of differences where the system is large, the least of all schemes but one.
    fn fastest(&self) -> f64 {
        self.modes().map_or(self.flow.nu * (self.space.cells as f64).powi(2), Modes::fastest)
    }
}

impl Ode for Channel {
    fn dim(&self) -> usize {
        self.space.mass.dim()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.forces(t, v, dv);
        self.mass.solve(dv);
    }
    /// −ν M⁻¹ K.
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let (n, nu) = (self.space.mass.dim(), self.flow.nu);
        if self.space.mass.width() == 0 {
            let mut inverse = vec![1.0; n];
            self.mass.solve(&mut inverse);
            self.space.stiffness.for_each(|i, j, k| add(i, j, -nu * k * inverse[i]));
            return;
        }
        let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
        for j in 0..n {
            unit[j] = 1.0;
            column.fill(0.0);
            self.space.stiffness.mul_add(-nu, &unit, &mut column);
            self.mass.solve(&mut column);
            column.iter().enumerate().for_each(|(i, x)| add(i, j, *x));
            unit[j] = 0.0;
        }
    }
    fn bandwidths(&self) -> Option<(usize, usize)> {
        (self.space.mass.width() == 0).then(|| (self.space.stiffness.width(), self.space.stiffness.width()))
    }
}

impl Problem for Channel {
    fn components(&self) -> &'static [&'static str] {
        &["u"]
    }
    /// The flow at t = 0 in the basis, without what the wall function carries.
    fn initial(&self) -> Vec<f64> {
        let wall = self.flow.wall;
        self.space.project(|y| if self.flow.omega == 0.0 { 0.0 } else { self.flow.velocity(y, 0.0) }, wall)
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(SemiDiscrete(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    /// The velocity at the grid points.
    fn observe(&self, t: f64, state: &[f64]) -> Vec<f64> {
        let wall = self.flow.wall * self.flow.phase(t);
        let at =
            |shapes: &Shapes| shapes.basis.iter().map(|(i, value)| value * state[*i]).sum::<f64>() + wall * shapes.wall;
        self.shapes.iter().map(at).collect()
    }
    /// The flow itself, from which the semi-discrete solution differs by the error in space.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(self.points.iter().map(|y| self.flow.velocity(*y, t)).collect())
    }
    fn limit(&self, _principle: Principle) -> Limit<'_> {
        Limit::semi_discrete(self, |t| self.modes().map(|modes| modes.solution(t)))
    }
    fn facts(&self) -> Facts {
        Facts::semi_discrete(self.fastest())
    }
}

/// The system M ċ = −ν K c + … as the methods under test see it.
struct SemiDiscrete<'a>(&'a Channel);

impl VectorField for SemiDiscrete<'_> {
    fn dim(&self) -> usize {
        self.0.space.mass.dim()
    }
    fn structure(&self) -> Structure {
        let width = self.0.space.mass.width().max(self.0.space.stiffness.width());
        Structure::Banded { lower: width, upper: width }
    }
    fn mass(&self) -> Mass {
        match self.0.space.scheme {
            Scheme::Differences => Mass::Identity,
            Scheme::Volumes => {
                let mut diagonal = Vec::with_capacity(self.dim());
                self.0.space.mass.for_each(|_, _, m| diagonal.push(m));
                Mass::Diagonal(diagonal)
            }
            Scheme::Hermite | Scheme::Legendre | Scheme::StrongLinear => {
                let mut matrix = Jacobian::with_structure(self.dim(), &self.structure());
                self.0.space.mass.for_each(|i, j, m| matrix.add(i, j, m));
                Mass::Matrix(matrix)
            }
        }
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.forces(t, v, dv);
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.space.stiffness.for_each(|i, j, k| out.add(i, j, -scale * self.0.flow.nu * k));
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}
