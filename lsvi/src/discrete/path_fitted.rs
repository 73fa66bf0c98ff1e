//! Path-fitted integrators of [KY21].

use std::ops::RangeInclusive;

use nalgebra::DMatrix;

use super::nystrom::{Coefficients, Nystrom};
use super::path::Path;
use super::velocity::Velocity;
use super::{Constrainable, DiscreteLegendre, Interval, MomentumWeights};
use crate::error::{InputError, NodeError, SolveError};
use crate::lagrangian::{EulerLagrange, HessianWeights, Lagrangian, MotionWeights};
use crate::linalg::{Jacobian, Structure, add_block};
use crate::quadrature::{Basis, BernsteinBasis, LagrangeBasis, NodeFamily};

/// The path is the polynomial of degree m that satisfies the Euler–Lagrange equations at m − 1 interior nodes;
/// p₀ and p₁ are ∂L/∂v at its ends, \[KY21\] (9)–(12).
///
/// The nodes decide what it is worth: on L = ½ vᵀMv − V(q) it is direct collocation, of order 2(m − 1) and symplectic with
/// Gauss nodes, of order 2⌊m/2⌋ and for m ≥ 3 in general not symplectic with equispaced ones. Where the mass depends on the
/// configuration, or L on the velocity linearly, no choice of nodes is symplectic in general (a uniform magnetic field without a potential is an
/// exception); [`Galerkin`](super::Galerkin) is.
///
/// The velocities at the ends are differences of positions over h. Unless L is [separable](Lagrangian::is_separable), their roundings, of
/// about ε|q|/h, are in the momenta of every step: the shorter the steps are, the more they make of a run.
#[derive(Debug)]
pub struct PathFitted<L> {
    lagrangian: L,
    /// At both ends and, between them, at the interior nodes.
    path: Path,
    velocity_of: Velocity,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    dl_dq: Vec<f64>,
    dl_dv: Vec<f64>,
    block: Jacobian,
    nystrom: Option<Box<Nystrom>>,
}

/// The derivatives of the Euler–Lagrange expression, in the position, velocity and acceleration.
const BLOCKS: [MotionWeights; 3] = {
    let none = MotionWeights { q: 0.0, v: 0.0, a: 0.0 };
    [MotionWeights { q: 1.0, ..none }, MotionWeights { v: 1.0, ..none }, MotionWeights { a: 1.0, ..none }]
};

impl<L: EulerLagrange> PathFitted<L> {
    /// The path through its values at given interior nodes, \[KY21\] (8); m − 1 nodes make its degree m.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] without interior nodes, [`NodeError::NodeRange`] or [`NodeError::CoincidentNodes`] if they
    /// are not distinct points strictly inside the step.
    pub fn new(lagrangian: L, interior: &[f64]) -> Result<Self, InputError> {
        let nodes = with_ends(interior)?;
        let basis = LagrangeBasis::new(&nodes)?;
        Ok(Self::with_basis(lagrangian, &basis, &nodes))
    }

    /// Degree m on the nodes of a family.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] if m < 2.
    pub fn on(lagrangian: L, family: NodeFamily, degree: usize) -> Result<Self, InputError> {
        Self::new(lagrangian, &family.interior(degree)?)
    }

    /// The same with the Bernstein coefficients of the path as unknowns, \[KY21\] (13).
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn bernstein(lagrangian: L, interior: &[f64]) -> Result<Self, InputError> {
        let nodes = with_ends(interior)?;
        // The Bernstein basis itself needs no nodes; two equations at one node are as bad as ever.
        LagrangeBasis::new(&nodes)?;
        Ok(Self::with_basis(lagrangian, &BernsteinBasis::new(nodes.len() - 1), &nodes))
    }

    fn with_basis(lagrangian: L, basis: &impl Basis, nodes: &[f64]) -> Self {
        let zeros = vec![0.0; lagrangian.dim()];
        let path = Path::new(basis, nodes);
        Self {
            nystrom: lagrangian.is_separable().then(|| nystrom(&lagrangian, &path)).flatten(),
            path,
            velocity_of: Velocity::new(zeros.len(), &lagrangian.structure()),
            block: Jacobian::with_structure(zeros.len(), &lagrangian.structure()),
            lagrangian,
            q: zeros.clone(),
            v: zeros.clone(),
            a: zeros.clone(),
            dl_dq: zeros.clone(),
            dl_dv: zeros,
        }
    }

    /// The Lagrangian.
    pub fn lagrangian(&self) -> &L {
        &self.lagrangian
    }

    /// Adds the derivatives of all conditions in the given control values.
    fn assemble(
        &mut self,
        at: Interval,
        q0: &[f64],
        x: &[f64],
        w: MomentumWeights,
        columns: RangeInclusive<usize>,
        out: &mut Jacobian,
    ) {
        let (n, m) = (q0.len(), self.path.degree());
        for (i, point) in self.path.points.iter().enumerate() {
            let t = point.time(at);
            point.place(at.h, q0, x, &mut self.q, &mut self.v);
            if i == 0 || i == m {
                let weight = if i == 0 { w.alpha } else { w.beta };
                if weight == 0.0 {
                    continue;
                }
                for (which, trial, scale) in [
                    (HessianWeights { vq: weight, ..Default::default() }, &point.value, 1.0),
                    (HessianWeights { vv: weight, ..Default::default() }, &point.first, at.h.recip()),
                ] {
                    self.block.clear();
                    self.lagrangian.add_hessian(t, &self.q, &self.v, which, &mut self.block);
                    for (column, j) in columns.clone().enumerate() {
                        add_block(out, ((m - 1) * n, column * n), scale * trial[j], &self.block);
                    }
                }
                continue;
            }
            point.accelerate(at.h, q0, x, &mut self.a);
            let trials = [(&point.value, at.h), (&point.first, 1.0), (&point.second, at.h.recip())];
            for (which, (trial, scale)) in BLOCKS.into_iter().zip(trials) {
                self.block.clear();
                self.lagrangian.add_residual_derivative(t, &self.q, &self.v, &self.a, which, &mut self.block);
                for (column, j) in columns.clone().enumerate() {
                    add_block(out, ((i - 1) * n, column * n), scale * trial[j], &self.block);
                }
            }
        }
    }
}

/// The conditions are M Σ_k φ_k″(c_i) d_k / h² = L_q at the interior nodes and M Σ_k φ_k′(0) d_k / h = p₀; p₁ is M Σ_k φ_k′(1) d_k / h.
fn nystrom(l: &dyn Lagrangian, path: &Path) -> Option<Box<Nystrom>> {
    let m = path.degree();
    let (start, interior, end) = (&path.points[0], &path.points[1..m], &path.points[m]);
    let row = |j: usize| interior.get(j).map_or(&start.first, |point| &point.second);
    let k = DMatrix::from_fn(m, m, |j, k| row(j)[k + 1]);
    let v = -DMatrix::<f64>::identity(m, m - 1);
    let weights = |control: &DMatrix<f64>| {
        let column = |i: usize| control.column(i).iter().zip(&end.first[1..]).map(|(x, slope)| x * slope).sum();
        (0..m - 1).map(column).collect()
    };
    let coefficients = Coefficients::new(path, interior.iter(), (k, v), weights)?;
    Some(Box::new(Nystrom::new(l, coefficients)))
}

/// The interior nodes between the ends 0 and 1.
fn with_ends(interior: &[f64]) -> Result<Vec<f64>, InputError> {
    if interior.is_empty() {
        return Err(InputError::Nodes(NodeError::TooFew { what: "interior nodes", least: 1, found: 0 }));
    }
    if let Some(index) = interior.iter().position(|c| !(0.0..=1.0).contains(c)) {
        return Err(InputError::Nodes(NodeError::NodeRange { index, value: interior[index] }));
    }
    Ok([&[0.0], interior, &[1.0]].concat())
}

impl<L: EulerLagrange> DiscreteLegendre for PathFitted<L> {
    fn dim(&self) -> usize {
        self.lagrangian.dim()
    }

    fn interior(&self) -> usize {
        (self.path.degree() - 1) * self.dim()
    }

    fn structure(&self) -> Structure {
        self.lagrangian.structure().blocks(self.dim(), self.path.degree())
    }

    fn predict(&mut self, at: Interval, q0: &[f64], p0: &[f64], x: &mut [f64]) -> Result<(), SolveError> {
        let v = self.velocity_of.of(&self.lagrangian, at.start, q0, p0)?;
        self.path.straight(at.h, q0, v, x);
        Ok(())
    }

    fn separable_step(
        &mut self,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<Option<u64>, SolveError> {
        let Some(nystrom) = &mut self.nystrom else { return Ok(None) };
        nystrom.step(&self.lagrangian, at, q, p, x)
    }

    fn momentum(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        out.fill(0.0);
        let ends = [(&self.path.points[0], w.alpha), (&self.path.points[self.path.degree()], w.beta)];
        for (point, weight) in ends.into_iter().filter(|(_, weight)| *weight != 0.0) {
            point.place(at.h, q0, x, &mut self.q, &mut self.v);
            self.lagrangian.gradient(point.time(at), &self.q, &self.v, &mut self.dl_dq, &mut self.dl_dv);
            out.iter_mut().zip(&self.dl_dv).for_each(|(o, lv)| *o += weight * lv);
        }
    }

    /// h E = 0 at the interior nodes, an impulse like the momenta.
    fn equations(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        let (interior, end) = out.split_at_mut(self.interior());
        for (point, out) in self.path.points[1..].iter().zip(interior.chunks_exact_mut(q0.len())) {
            point.place(at.h, q0, x, &mut self.q, &mut self.v);
            point.accelerate(at.h, q0, x, &mut self.a);
            self.lagrangian.residual(point.time(at), &self.q, &self.v, &self.a, out);
            out.iter_mut().for_each(|o| *o *= at.h);
        }
        self.momentum(at, q0, x, w, end);
    }

    fn add_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.assemble(at, q0, x, w, 1..=self.path.degree(), out);
    }

    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.assemble(at, q0, x, w, 0..=0, out);
    }
}

/// Constraints hold at the interior nodes, where their reactions act; the momenta are those of the path itself.
impl<L: EulerLagrange> Constrainable for PathFitted<L> {
    fn mechanics(&self) -> &dyn Lagrangian {
        &self.lagrangian
    }

    fn position_weight(&self, node: usize, j: usize) -> f64 {
        self.path.points[node].value[j]
    }
}
