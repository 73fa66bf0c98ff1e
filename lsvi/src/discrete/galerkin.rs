//! Galerkin variational integrators: polynomial path, any quadrature ([MW01]).

use std::ops::RangeInclusive;

use nalgebra::DMatrix;

use super::nystrom::{Coefficients, Nystrom};
use super::path::{Path, Point};
use super::residuals::Residuals;
use super::velocity::Velocity;
use super::{Constrainable, DiscreteLagrangian, DiscreteLegendre, Interval, MomentumWeights};
use crate::error::{InputError, NodeError, SolveError};
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Jacobian, Structure, add_block, by_size, size};
use crate::quadrature::{LagrangeBasis, Quadrature};

/// L_d = h Σ b_i L(t₀ + c_i h, u(c_i), u̇(c_i)) at a path u of degree s that makes it stationary.
///
/// The unknowns are the values of u at the Lobatto nodes of the step, and p is tested against linear functions: with
/// ψ(c) = β c − α (1 − c), α p₀ + β p₁ = Σ b_i [h ψ(c_i) L_q + (α + β) L_v]. On a stationary path that is −α D₁L_d + β D₂L_d,
/// and what the two momenta have in common never appears.
///
/// Symplectic for every Lagrangian. On mechanics, order 2s with the s Gauss or the s + 1 Lobatto nodes.
/// s = 1 is [`Midpoint`](super::Midpoint) with the Gauss node and [`Trapezoidal`](super::Trapezoidal) with the Lobatto nodes.
#[derive(Debug)]
pub struct Galerkin<L> {
    lagrangian: L,
    path: Path,
    weights: Vec<f64>,
    velocity_of: Velocity,
    q: Vec<f64>,
    v: Vec<f64>,
    dl_dq: Vec<f64>,
    dl_dv: Vec<f64>,
    /// L_qq, L_qv, L_vq and L_vv at a point, and their sum for a test and a trial function.
    blocks: [Jacobian; 4],
    sum: Jacobian,
    nystrom: Option<Box<Nystrom>>,
    /// Of a dense least-squares Lagrangian with as many nodes as the degree: the residuals vanish there.
    residuals: Option<Box<Residuals>>,
}

impl<L: Lagrangian> Galerkin<L> {
    /// Discretises `lagrangian` by paths of degree s with the given quadrature.
    ///
    /// # Errors
    /// [`NodeError::TooFew`] if s = 0 or the rule has fewer than s nodes, which cannot determine a path of degree s.
    pub fn new(lagrangian: L, degree: usize, quadrature: &Quadrature) -> Result<Self, InputError> {
        let found = quadrature.nodes().len();
        if found < degree {
            return Err(InputError::Nodes(NodeError::TooFew { what: "quadrature nodes", least: degree, found }));
        }
        if degree == 0 {
            return Err(InputError::Nodes(NodeError::TooFew { what: "degree of the path", least: 1, found: degree }));
        }
        let basis = LagrangeBasis::new(Quadrature::lobatto(degree + 1)?.nodes())?;
        let zeros = vec![0.0; lagrangian.dim()];
        let path = Path::new(&basis, quadrature.nodes());
        let is_square = found == degree && lagrangian.structure() == Structure::Dense;
        let has_residuals = is_square && lagrangian.residual_form().is_some();
        Ok(Self {
            nystrom: lagrangian.is_separable().then(|| nystrom(&lagrangian, &path, quadrature.weights())).flatten(),
            path,
            weights: quadrature.weights().to_vec(),
            velocity_of: Velocity::new(zeros.len(), &lagrangian.structure()),
            blocks: std::array::from_fn(|_| Jacobian::with_structure(zeros.len(), &lagrangian.structure())),
            sum: Jacobian::with_structure(zeros.len(), &lagrangian.structure()),
            residuals: has_residuals.then(|| Box::new(Residuals::new(zeros.len()))),
            lagrangian,
            q: zeros.clone(),
            v: zeros.clone(),
            dl_dq: zeros.clone(),
            dl_dv: zeros,
        })
    }

    /// Degree s with the s Gauss nodes: order 2s.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn gauss(lagrangian: L, degree: usize) -> Result<Self, InputError> {
        Self::new(lagrangian, degree, &Quadrature::gauss(degree)?)
    }

    /// Degree s with the s + 1 Lobatto nodes: order 2s.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn lobatto(lagrangian: L, degree: usize) -> Result<Self, InputError> {
        Self::new(lagrangian, degree, &Quadrature::lobatto(degree + 1)?)
    }

    /// The Lagrangian.
    pub fn lagrangian(&self) -> &L {
        &self.lagrangian
    }

    /// Writes the conditions that belong to the given control values, the last one being α p₀ + β p₁.
    fn conditions(
        &mut self,
        at: Interval,
        q0: &[f64],
        x: &[f64],
        w: MomentumWeights,
        rows: RangeInclusive<usize>,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        for (point, b) in self.path.points.iter().zip(&self.weights) {
            point.place(at.h, q0, x, &mut self.q, &mut self.v);
            self.lagrangian.gradient(point.time(at), &self.q, &self.v, &mut self.dl_dq, &mut self.dl_dv);
            let tests = rows.clone().map(|row| test_function(point, row, w));
            by_size!(q0.len(), N => add_tested::<N>(at.h, *b, tests, (&self.dl_dq, &self.dl_dv), out));
        }
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
        let n = q0.len();
        for (point, b) in self.path.points.iter().zip(&self.weights) {
            point.place(at.h, q0, x, &mut self.q, &mut self.v);
            let last = self.path.degree();
            let weights = |row: usize, column: usize| {
                let (value, slope) = test_function(point, row, w);
                let (trial, trial_slope) = (point.value[column], point.first[column] / at.h);
                let (test, test_slope) = (b * at.h * value, b * slope);
                let c = [test * trial, test * trial_slope, test_slope * trial, test_slope * trial_slope];
                HessianWeights { qq: c[0], qv: c[1], vq: c[2], vv: c[3] }
            };
            if last == 1 {
                let c = weights(1, *columns.start());
                self.lagrangian.add_hessian(point.time(at), &self.q, &self.v, c, out);
                continue;
            }
            self.blocks.iter_mut().for_each(Jacobian::clear);
            self.lagrangian.add_blocks(point.time(at), &self.q, &self.v, self.blocks.each_mut());
            for row in 1..=last {
                for (place, column) in columns.clone().enumerate() {
                    let c = weights(row, column);
                    self.sum.set_sum([c.qq, c.qv, c.vq, c.vv], &self.blocks);
                    add_block(out, ((row - 1) * n, place * n), 1.0, &self.sum);
                }
            }
        }
    }
}

/// With the path's derivative for v, the conditions are Σ_i b_i [h ψ_j(c_i) L_q + ψ_j′(c_i) M Σ_k φ_k′(c_i) d_k / h] = δ_j p₀.
fn nystrom(l: &dyn Lagrangian, path: &Path, weights: &[f64]) -> Option<Box<Nystrom>> {
    let (m, r) = (path.degree(), path.points.len());
    let test = |i: usize, j: usize| test_function(&path.points[i], j + 1, MomentumWeights::START);
    let slopes = |i: usize, k: usize| path.points[i].first[k + 1];
    let k = DMatrix::from_fn(m, m, |j, k| (0..r).map(|i| weights[i] * test(i, j).1 * slopes(i, k)).sum());
    let v = DMatrix::from_fn(m, r, |j, i| weights[i] * test(i, j).0);
    let coefficients = Coefficients::new(path, path.points.iter(), (k, v), |_| weights.to_vec())?;
    Some(Box::new(Nystrom::new(l, coefficients)))
}

/// Adds the gradient at a point, tested against functions of the given values and derivatives, to their rows.
#[inline]
fn add_tested<const N: usize>(
    h: f64,
    weight: f64,
    tests: impl Iterator<Item = (f64, f64)>,
    (dl_dq, dl_dv): (&[f64], &[f64]),
    out: &mut [f64],
) {
    let n = size::<N>(dl_dq.len());
    let (dl_dq, dl_dv) = (&dl_dq[..n], &dl_dv[..n]);
    for ((value, slope), out) in tests.zip(out.chunks_exact_mut(n)) {
        for i in 0..n {
            out[i] += weight * (h * value * dl_dq[i] + slope * dl_dv[i]);
        }
    }
}

/// Value and derivative of the test function of a row: φ_j inside, and ψ = β c − α (1 − c) for the momenta.
pub(super) fn test_function(point: &Point, row: usize, w: MomentumWeights) -> (f64, f64) {
    if row + 1 == point.value.len() {
        (w.beta * point.c - w.alpha * (1.0 - point.c), w.alpha + w.beta)
    } else {
        (point.value[row], point.first[row])
    }
}

impl<L: Lagrangian> DiscreteLegendre for Galerkin<L> {
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

    /// The sum of all conditions: the φ_j add up to one.
    fn impulse(&mut self, at: Interval, q0: &[f64], x: &[f64], out: &mut [f64]) -> bool {
        out.fill(0.0);
        for (point, b) in self.path.points.iter().zip(&self.weights) {
            point.place(at.h, q0, x, &mut self.q, &mut self.v);
            self.lagrangian.gradient_q(point.time(at), &self.q, &self.v, &mut self.dl_dq, &mut self.dl_dv);
            out.iter_mut().zip(&self.dl_dq).for_each(|(o, force)| *o += at.h * b * force);
        }
        true
    }

    fn momentum(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        let last = self.path.degree();
        self.conditions(at, q0, x, w, last..=last, out);
    }

    fn equations(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        self.conditions(at, q0, x, w, 1..=self.path.degree(), out);
    }

    fn add_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.assemble(at, q0, x, w, 1..=self.path.degree(), out);
    }

    fn residuals(&self) -> usize {
        if self.residuals.is_some() { self.path.points.len() * self.dim() } else { 0 }
    }

    fn has_unlike_units(&mut self, at: Interval, q0: &[f64]) -> bool {
        let Self { lagrangian, residuals, .. } = self;
        let (Some(residuals), Some(form)) = (residuals, lagrangian.residual_form()) else { return false };
        residuals.has_unlike_units(form, at, q0)
    }

    fn residual_equations(&mut self, at: Interval, q0: &[f64], xz: &[f64], w: MomentumWeights, out: &mut [f64]) {
        let Self { lagrangian, path, weights, residuals, .. } = self;
        if let (Some(residuals), Some(form)) = (residuals, lagrangian.residual_form()) {
            residuals.equations(form, (path, weights), at, (q0, xz), w, out);
        }
    }

    fn add_residual_derivative(
        &mut self,
        at: Interval,
        q0: &[f64],
        xz: &[f64],
        w: MomentumWeights,
        out: &mut Jacobian,
    ) {
        let Self { lagrangian, path, weights, residuals, .. } = self;
        if let (Some(residuals), Some(form)) = (residuals, lagrangian.residual_form()) {
            residuals.add_derivative(form, (path, weights), at, (q0, xz), w, out);
        }
    }

    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.assemble(at, q0, x, w, 0..=0, out);
    }
}

/// Constraints hold at the Lobatto nodes of the path, where its unknowns are.
impl<L: Lagrangian> Constrainable for Galerkin<L> {
    fn mechanics(&self) -> &dyn Lagrangian {
        &self.lagrangian
    }

    fn reaction_weight(&self, node: usize, w: MomentumWeights) -> f64 {
        let c = self.path.abscissae[node];
        w.beta * c - w.alpha * (1.0 - c)
    }
}

impl<L: Lagrangian> DiscreteLagrangian for Galerkin<L> {
    fn action(&mut self, at: Interval, q0: &[f64], x: &[f64]) -> f64 {
        let mut action = 0.0;
        for (point, b) in self.path.points.iter().zip(&self.weights) {
            point.place(at.h, q0, x, &mut self.q, &mut self.v);
            action += at.h * b * self.lagrangian.value(point.time(at), &self.q, &self.v);
        }
        action
    }
}
