//! Steps of separable Lagrangians as Runge–Kutta–Nyström methods.
//!
//! For L = ½ vᵀMv − V(t, q) the conditions of a discretisation are linear in the path and the forces at its r nodes. Solved for
//! the control values x_k of the path, with u = M⁻¹p₀ and the accelerations a_i = M⁻¹L_q(t + c_i h, q_i),
//!
//! x_k = q₀ + h γ_k u + h² Σ_j Γ_kj a_j,  q_i = q₀ + h c_i u + h² Σ_j A_ij a_j,  p₁ = p₀ + h Σ_j b_j M a_j.
//!
//! Evaluated in turn this is a simplified Newton iteration whose matrix is the limit of the derivative for h → 0 itself. Where the
//! derivatives of the accelerations are K at most, the derivative differs from its limit by a matrix of spectral radius h² ρ(|A|) K.
//! What proves the root to be on the branch of q₀ is the same as with kept factors (`newton/kept.rs`):
//!
//! - where the first step of a trajectory starts, h² ρ(|A|) ‖M⁻¹L_qq(q₀)‖ is [`CLOSE`] at most;
//! - the mean derivatives between q₀ and the nodes, in turn, bear it out: h² ρ(|A|) times a difference of accelerations is
//!   [`SURE_CONTRACTION`] of that of positions at most; and so do those out to its middle where the branch turns and comes back;
//! - the iteration contracts by [`CLOSE`], by as much as the derivative at the root differs from its limit.
//!
//! Every other step is left to Newton's method, and so are the next few.

use nalgebra::{DMatrix, DVector};

use super::Interval;
use super::path::{Path, Point};
use super::separable::{ConstantMass, Sum};
use crate::error::SolveError;
use crate::lagrangian::Lagrangian;
use crate::linalg::{by_size, larger, size};
use crate::newton::{CLOSE, SURE_CONTRACTION};

/// Iterations; with a contraction by a quarter more of them are rounding.
const ITERATIONS: u64 = 27;
/// Increments of a few roundings may do as they like.
const ROUNDINGS: f64 = 16.0;
/// A branch whose nodes are nearer to q₀ than this part of what the velocity alone leads to has turned.
const TURNED: f64 = 0.5;
/// Nodes nearer to each other than this, in steps, are one.
const APART: f64 = 1e-3;
/// Room for past steps, in as many as are known.
const ROOM: usize = 2;
/// Steps to leave to Newton's method, at most, after one that had to be.
const LONGEST_PAUSE: u32 = 8;
/// Rounding of the conditions of a path, relative to their largest coefficient.
const STRAIGHT: f64 = 1e-10;

/// The coefficients c, A, Γ, γ and b, matrices by rows.
#[derive(Debug, Clone)]
pub(super) struct Coefficients {
    c: Vec<f64>,
    a: Vec<f64>,
    control: Vec<f64>,
    gamma: Vec<f64>,
    b: Vec<f64>,
}

impl Coefficients {
    pub(super) fn midpoint() -> Self {
        Self { c: vec![0.5], a: vec![0.25], control: vec![0.5], gamma: vec![1.0], b: vec![1.0] }
    }

    /// For a path whose control values d_k = x_k − q₀ satisfy Σ_k K_jk M d_k = δ_j h p₀ − h² Σ_i V_ji L_q(t + c_i h, q_i), δ_j 1
    /// for the last condition and 0 for the others, at the given nodes; `end` makes b of Γ. `None` if these conditions do not
    /// make the path of free motion straight.
    pub(super) fn new<'a>(
        path: &Path,
        nodes: impl Iterator<Item = &'a Point>,
        (k, v): (DMatrix<f64>, DMatrix<f64>),
        end: impl FnOnce(&DMatrix<f64>) -> Vec<f64>,
    ) -> Option<Self> {
        let m = path.degree();
        let gamma = &path.abscissae[1..];
        let free = &k * DVector::from_column_slice(gamma);
        let expected = |j: usize| if j + 1 == m { 1.0 } else { 0.0 };
        let is_straight = free.iter().enumerate().all(|(j, x)| (x - expected(j)).abs() <= STRAIGHT * k.amax());
        if !is_straight {
            return None;
        }
        let control = -k.lu().solve(&v)?;
        let nodes: Vec<_> = nodes.collect();
        let values = DMatrix::from_fn(nodes.len(), m, |i, k| nodes[i].value[k + 1]);
        let by_rows = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
        Some(Self {
            c: nodes.iter().map(|node| node.c).collect(),
            a: by_rows(&(&values * &control)),
            b: end(&control),
            control: by_rows(&control),
            gamma: gamma.to_vec(),
        })
    }

    /// Writes h c, h² A, h² Γ, h γ and h b: with these fewer products of a step wait for each other.
    fn scale(&self, h: f64, out: &mut Self) {
        let parts = [
            (h, &self.c, &mut out.c),
            (h * h, &self.a, &mut out.a),
            (h * h, &self.control, &mut out.control),
            (h, &self.gamma, &mut out.gamma),
            (h, &self.b, &mut out.b),
        ];
        for (factor, from, to) in parts {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = factor * from);
        }
    }
}

/// The method, and what its steps keep for the next.
#[derive(Debug)]
pub(super) struct Nystrom {
    coefficients: Coefficients,
    /// Those of steps of size h.
    scaled: Coefficients,
    h: f64,
    /// Largest sum of absolute values in a row of Γ.
    reach: f64,
    /// Spectral radius of |A|.
    radius: f64,
    mass: ConstantMass,
    sum: Sum,
    past: Past,
    pause: u32,
    waited: u32,
    /// u, and work space.
    velocity: Vec<f64>,
    work: Vec<f64>,
    midway: Vec<f64>,
    /// By nodes: the accelerations at q₀, those of the iteration, the forces, and the positions.
    start: Vec<f64>,
    acceleration: Vec<f64>,
    force: Vec<f64>,
    positions: Vec<f64>,
}

/// Accelerations of the last steps, and the polynomials through them.
#[derive(Debug)]
struct Past {
    /// For so many known steps, from 0 on: the weights of their accelerations, newest step first, by the node of the next step unless they
    /// are the same for each.
    weights: Vec<Vec<f64>>,
    /// Accelerations from `first` on, newest step first, with room for more before them.
    steps: Vec<f64>,
    first: usize,
    known: usize,
}

impl Past {
    fn new(c: &[f64], dim: usize) -> Self {
        let (weights, len) = (extrapolations(c), c.len() * dim);
        let steps = vec![0.0; ROOM * weights.len() * len];
        Self { first: steps.len(), weights, steps, known: 0 }
    }

    fn forget(&mut self) {
        self.known = 0;
        self.first = self.steps.len();
    }

    /// Writes what is expected at the nodes of the next step; false if nothing is known.
    #[inline]
    fn expect<const N: usize, const R: usize>(&self, dim: usize, out: &mut [f64]) -> bool {
        let n = size::<N>(dim);
        let r = size::<R>(out.len() / n);
        if self.known == 0 {
            return false;
        }
        let together = if is_each_alone(r) { r * n } else { n };
        let steps = &self.steps[self.first..][..self.known * r * n];
        let rows = self.weights[self.known].chunks_exact(steps.len() / together);
        for (out, weights) in out[..r * n].chunks_exact_mut(together).zip(rows) {
            combine(weights, steps, out);
        }
        true
    }

    #[inline]
    fn push(&mut self, accelerations: &[f64]) {
        let len = accelerations.len();
        self.known = (self.known + 1).min(self.weights.len() - 1);
        if self.first == 0 {
            let kept = (self.known - 1) * len;
            self.first = self.steps.len() - kept;
            self.steps.copy_within(..kept, self.first);
        }
        self.first -= len;
        self.steps[self.first..][..len].copy_from_slice(accelerations);
    }
}

/// Whether a node is extrapolated from its own past alone. Nodes lie off the motion by a power of h that grows with their number, and each by
/// another multiple: a polynomial through few of them of a step would be as rough as that.
#[inline(always)]
fn is_each_alone(nodes: usize) -> bool {
    nodes <= 2
}

/// Accelerations that a first guess of a step with so many nodes is extrapolated from.
fn known(nodes: usize) -> usize {
    if is_each_alone(nodes) { 8 } else { (nodes + 2).max(6) }
}

/// For the nodes `c`, the weights of accelerations of so many known steps, from 0 to as many as are kept.
fn extrapolations(c: &[f64]) -> Vec<Vec<f64>> {
    if is_each_alone(c.len()) {
        (0..=known(c.len())).map(|steps| weights(&[0.0], steps, 1)).collect()
    } else {
        (0..=known(c.len()).div_ceil(c.len())).map(|steps| extrapolation(c, steps)).collect()
    }
}

/// The values at the nodes `c` of the next step of the polynomial through those at nodes of so many steps before, by weights. Of many nodes
/// every second, or third, … is used, so that half of the digits survive the weights.
fn extrapolation(c: &[f64], steps: usize) -> Vec<f64> {
    let most = |weights: &[f64]| {
        weights.chunks((steps * c.len()).max(1)).map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, larger)
    };
    let mut all = (1..=c.len().max(1)).map(|stride| weights(c, steps, stride));
    all.find(|weights| most(weights) * f64::EPSILON.sqrt() <= 1.0).unwrap_or_else(|| weights(c, steps, c.len()))
}

/// The same with every node of so many.
fn weights(c: &[f64], steps: usize, stride: usize) -> Vec<f64> {
    let nodes: Vec<f64> = (1..=steps).flat_map(|back| c.iter().map(move |c| c - back as f64)).collect();
    let is_new = |i: usize| nodes[..i].iter().all(|node| (node - nodes[i]).abs() > APART);
    // Of nodes that coincide the newer one counts, which comes first.
    let used: Vec<usize> =
        (0..nodes.len()).step_by(stride.max(1)).filter(|&i| is_new(i)).take(known(c.len())).collect();
    let weight = |at: f64, i: usize| {
        let others = used.iter().filter(|&&j| j != i);
        let product = others.map(|&j| (at - nodes[j]) / (nodes[i] - nodes[j])).product::<f64>();
        if used.contains(&i) { product } else { 0.0 }
    };
    c.iter().flat_map(|&at| (0..nodes.len()).map(|i| weight(at, i)).collect::<Vec<_>>()).collect()
}

/// Writes the combination of vectors, a few components together so that their sums stay in registers.
#[inline(always)]
fn combine(weights: &[f64], vectors: &[f64], out: &mut [f64]) {
    const TOGETHER: usize = 4;
    let n = out.len();
    for (block, out) in out.chunks_mut(TOGETHER).enumerate() {
        let (first, width) = (block * TOGETHER, out.len());
        let mut sums = [-0.0; TOGETHER];
        for (weight, vector) in weights.iter().zip(vectors.chunks_exact(n)) {
            for i in 0..width {
                sums[i] += weight * vector[first + i];
            }
        }
        out.copy_from_slice(&sums[..width]);
    }
}

/// Component i of the combination of vectors of n components.
#[inline(always)]
fn component(weights: &[f64], vectors: &[f64], n: usize, i: usize) -> f64 {
    // The zero that leaves every number as it is costs no addition.
    let mut sum = -0.0;
    for (weight, vector) in weights.iter().zip(vectors.chunks_exact(n)) {
        sum += weight * vector[i];
    }
    sum
}

/// The spectral radius of |A|, from above: the 2ᵏ-th root of the norm of its 2ᵏ-th power.
fn radius(a: &[f64], r: usize) -> f64 {
    const SQUARINGS: i32 = 6;
    let mut power = DMatrix::from_row_slice(r, r, a).abs();
    for _ in 0..SQUARINGS {
        power = &power * &power;
    }
    let norm = power.row_iter().map(|row| row.sum()).fold(0.0, larger);
    norm.powf(0.5_f64.powi(SQUARINGS))
}

impl Nystrom {
    pub(super) fn new(l: &dyn Lagrangian, coefficients: Coefficients) -> Self {
        let (n, r) = (l.dim(), coefficients.c.len());
        let (zeros, all) = (vec![0.0; n], vec![0.0; r * n]);
        let rows = coefficients.control.chunks_exact(r);
        Self {
            reach: rows.map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, larger),
            radius: radius(&coefficients.a, r),
            mass: ConstantMass::new(l),
            sum: Sum::new(n),
            h: f64::NAN,
            past: Past::new(&coefficients.c, n),
            pause: 0,
            waited: 0,
            velocity: zeros.clone(),
            work: zeros.clone(),
            midway: zeros,
            start: all.clone(),
            acceleration: all.clone(),
            force: all.clone(),
            positions: all,
            scaled: coefficients.clone(),
            coefficients,
        }
    }

    /// Replaces (q₀, p₀) by (q₁, p₁), writes the control values, and returns how often the forces were evaluated; `None`, with
    /// nothing changed, where the iteration does not prove its root.
    pub(super) fn step<L: Lagrangian>(
        &mut self,
        l: &L,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<Option<u64>, SolveError> {
        // Where the dimension of a Lagrangian is a constant, the other sizes are not compiled.
        by_size!(l.dim(), N => match self.coefficients.c.len() {
            1 => self.step_sized::<L, N, 1>(l, at, q, p, x),
            2 => self.step_sized::<L, N, 2>(l, at, q, p, x),
            _ => self.step_of_many(&l, at, q, p, x),
        }, else self.step_of_many(&l, at, q, p, x))
    }

    /// [`Self::step`] of many unknowns or more than two nodes, compiled once for all Lagrangians.
    fn step_of_many(
        &mut self,
        l: &dyn Lagrangian,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<Option<u64>, SolveError> {
        by_size!(q.len(), N => self.step_sized::<_, N, 0>(&l, at, q, p, x))
    }

    #[inline]
    fn step_sized<L: Lagrangian, const N: usize, const R: usize>(
        &mut self,
        l: &L,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<Option<u64>, SolveError> {
        let n = size::<N>(q.len());
        let (q, p) = (&mut q[..n], &mut p[..n]);
        let continues = self.sum.continues(at.start, q, p);
        if !continues || self.h != at.h {
            self.start_anew(at.h);
        }
        let velocity = &mut self.velocity[..n];
        velocity.iter_mut().zip(&*p).for_each(|(velocity, p)| *velocity = *p);
        self.mass.inverse(l, (at.start, at.h), q, p)?.solve(velocity);
        if self.waited < self.pause {
            self.waited += 1;
            return Ok(None);
        }
        if self.past.known == 0 {
            let stiffness = self.mass.stiffness(l, at.start, q, &mut self.work);
            let is_close = at.h * at.h * self.radius * stiffness <= CLOSE;
            if !is_close {
                return Ok(self.give_up());
            }
        }
        let Some(evaluations) = self.iterate::<L, N, R>(l, at, q) else { return Ok(self.give_up()) };
        let Some(more) = self.bear_out::<N, R>(&l, at, q) else { return Ok(self.give_up()) };
        self.finish::<N, R>(at, q, p, x);
        Ok(Some(evaluations + more))
    }

    #[cold]
    fn start_anew(&mut self, h: f64) {
        self.past.forget();
        self.coefficients.scale(h, &mut self.scaled);
        self.h = h;
    }

    #[cold]
    fn give_up(&mut self) -> Option<u64> {
        self.past.forget();
        self.pause = (2 * self.pause).clamp(1, LONGEST_PAUSE);
        self.waited = 0;
        None
    }

    /// Sets the forces and accelerations of the step; returns how often they were evaluated for it.
    #[inline]
    fn iterate<L: Lagrangian, const N: usize, const R: usize>(
        &mut self,
        l: &L,
        at: Interval,
        q: &[f64],
    ) -> Option<u64> {
        let (n, r) = (size::<N>(q.len()), size::<R>(self.coefficients.c.len()));
        let (h, square, all) = (at.h, at.h * at.h, r * n);
        let Self { scaled, velocity, acceleration, force, positions, start, work, .. } = self;
        let (c, a) = (&scaled.c[..r], &scaled.a[..r * r]);
        let (q, velocity, work) = (&q[..n], &velocity[..n], &mut work[..n]);
        let (acceleration, force) = (&mut acceleration[..all], &mut force[..all]);
        let (positions, start) = (&mut positions[..all], &mut start[..all]);
        let inverse = self.mass.known_inverse()?;
        let mut evaluate = |j: usize, start: &mut [f64]| {
            let at_start = &mut start[j * n..(j + 1) * n];
            l.gradient_q(at.start + c[j], q, velocity, at_start, work);
            inverse.solve(at_start);
        };
        for j in (0..r).step_by((r - 1).max(1)) {
            evaluate(j, start);
        }
        // Forces that are equal to the last bit at the first and the last node do not depend on time.
        let is_autonomous = start[..n] == start[all - n..];
        for j in 1..r - 1 {
            if is_autonomous { start.copy_within(..n, j * n) } else { evaluate(j, start) }
        }
        if !self.past.expect::<N, R>(n, acceleration) {
            acceleration.copy_from_slice(start);
        }
        let (mut size_of_q, mut fastest) = (0.0, 0.0);
        for i in 0..n {
            size_of_q = larger(size_of_q, q[i]);
            fastest = larger(fastest, velocity[i]);
        }
        let roundoff = f64::EPSILON * size_of_q;
        let mut last = f64::NAN;
        for iterations in 1..ITERATIONS + 1 {
            for ((position, row), c) in positions.chunks_exact_mut(n).zip(a.chunks_exact(r)).zip(c) {
                for i in 0..n {
                    position[i] = (q[i] + c * velocity[i]) + component(row, acceleration, n, i);
                }
            }
            let (mut change, mut strongest, mut sum) = (0.0, 0.0, 0.0);
            for ((position, force), c) in positions.chunks_exact(n).zip(force.chunks_exact_mut(n)).zip(c) {
                l.gradient_q(at.start + c, position, velocity, force, work);
            }
            for (force, acceleration) in force.chunks_exact(n).zip(acceleration.chunks_exact_mut(n)) {
                let found = inverse.of(force, work);
                for i in 0..n {
                    change = larger(change, found[i] - acceleration[i]);
                    strongest = larger(strongest, found[i]);
                    sum += found[i];
                    acceleration[i] = found[i];
                }
            }
            if !sum.is_finite() {
                return None;
            }
            // An increment of x, and one of M⁻¹p: a momentum needs its own digits, which are 1/h of those of q.
            let (delta, theta) = (square * self.reach * change, change / last);
            let speed = f64::EPSILON * larger(fastest, h * strongest);
            let is_noise = square * self.reach * last <= ROUNDINGS * roundoff;
            // Beside a change that is larger than all accelerations the next one is small, and tells nothing of those to come.
            let is_told = last <= strongest;
            let is_enough = is_told && theta * h * change <= (1.0 - theta) * speed;
            if delta <= 4.0 * roundoff || is_enough || is_noise {
                return Some(iterations + 1);
            }
            if theta > CLOSE {
                return None;
            }
            last = change;
        }
        None
    }

    /// Holds the differences of accelerations, less those of time, against those of positions; `None` where they are too large,
    /// and otherwise how often the forces were evaluated for it.
    #[inline]
    fn bear_out<const N: usize, const R: usize>(&mut self, l: &dyn Lagrangian, at: Interval, q: &[f64]) -> Option<u64> {
        let (n, r) = (size::<N>(q.len()), size::<R>(self.coefficients.c.len()));
        let (h, all) = (at.h, r * n);
        let Self { scaled, velocity, acceleration, positions, start, work, midway, radius, .. } = self;
        let (c, q, velocity) = (&scaled.c[..r], &q[..n], &velocity[..n]);
        let (acceleration, start) = (&acceleration[..all], &start[..all]);
        let (positions, midway) = (&mut positions[..all], &mut midway[..n]);
        let (mut size_of_q, mut speed) = (0.0, 0.0);
        for i in 0..n {
            size_of_q = larger(size_of_q, q[i]);
            speed = larger(speed, velocity[i]);
        }
        let noise = ROUNDINGS * f64::EPSILON * size_of_q;
        let is_flat = |change: f64, way: f64| h * h * *radius * change <= SURE_CONTRACTION * way + noise;
        let mut has_turned = false;
        for (k, c) in c.iter().enumerate() {
            let (mut change, mut step, mut way) = (0.0, 0.0, 0.0);
            for (i, q) in q.iter().enumerate() {
                let j = k * n + i;
                let (mut bend, mut x) = (acceleration[j] - start[j], positions[j] - q);
                way = larger(way, x);
                if k > 0 {
                    bend -= acceleration[j - n] - start[j - n];
                    x -= positions[j - n] - q;
                }
                (change, step) = (larger(change, bend), larger(step, x));
            }
            if !is_flat(change, step) {
                return None;
            }
            has_turned |= way < TURNED * c.abs() * speed;
        }
        if !has_turned {
            return Some(0);
        }
        // The nodes of a step half as long, on the branch but for the change of its accelerations.
        let inverse = self.mass.known_inverse()?;
        for ((position, start), c) in positions.chunks_exact_mut(n).zip(start.chunks_exact(n)).zip(c) {
            for i in 0..n {
                position[i] = q[i] + 0.25 * (position[i] - q[i] + c * velocity[i]);
            }
            l.gradient_q(at.start + c, position, velocity, midway, work);
            inverse.solve(midway);
            let (mut change, mut way) = (0.0, 0.0);
            for i in 0..n {
                (change, way) = (larger(change, midway[i] - start[i]), larger(way, position[i] - q[i]));
            }
            if !is_flat(change, way) {
                return None;
            }
        }
        Some(1)
    }

    /// Adds the changes to q₀ and p₀ and writes the control values.
    #[inline]
    fn finish<const N: usize, const R: usize>(&mut self, at: Interval, q: &mut [f64], p: &mut [f64], x: &mut [f64]) {
        let (n, r) = (size::<N>(q.len()), size::<R>(self.coefficients.c.len()));
        let all = r * n;
        let Self { scaled, velocity, acceleration, force, sum, work, .. } = self;
        let (q, p, velocity, work) = (&mut q[..n], &mut p[..n], &velocity[..n], &mut work[..n]);
        let (acceleration, force) = (&acceleration[..all], &force[..all]);
        for ((x, row), gamma) in x.chunks_exact_mut(n).zip(scaled.control.chunks_exact(r)).zip(&scaled.gamma) {
            for i in 0..n {
                x[i] = gamma * velocity[i] + component(row, acceleration, n, i);
            }
        }
        let last = x.len() - n;
        let (interior, end) = x.split_at_mut(last);
        for values in interior.chunks_exact_mut(n) {
            for i in 0..n {
                values[i] += q[i];
            }
        }
        let b = &scaled.b[..r];
        for (i, impulse) in work.iter_mut().enumerate() {
            *impulse = component(b, force, n, i);
        }
        sum.add(at.start + at.h, (q, end), (p, work));
        end.iter_mut().zip(&*q).for_each(|(end, q)| *end = *q);
        self.pause = 0;
        self.past.push(&self.acceleration[..all]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a line with its node in the middle, where free motion is x₁ − q₀ = h u with K = 1, and half of it with K = 2.
    #[test]
    fn a_path_on_which_free_motion_is_not_straight_has_no_coefficients() {
        let matrix = |x: f64| DMatrix::from_element(1, 1, x);
        let middle = Point { c: 0.5, value: vec![0.5; 2], first: vec![-1.0, 1.0], second: vec![0.0; 2] };
        let path = Path { abscissae: vec![0.0, 1.0], points: vec![middle] };
        let found = |k: f64| {
            Coefficients::new(&path, path.points.iter(), (matrix(k), matrix(-0.5)), |_| vec![1.0]).map(|it| it.a)
        };
        assert_eq!([found(1.0), found(2.0)], [Some(vec![0.25]), None]);
    }

    /// Of a parabola through the nodes of all steps nothing is lost but roundings, however many nodes a step has, and those are half of the digits
    /// at most; so along a run, where the past is moved again and again.
    #[test]
    fn what_is_expected_of_a_parabola_is_its_next_value() {
        let parabola = |t: f64| 1.0 + t * (t - 0.5) / 1e3;
        for nodes in [1, 2, 3, 5, 8, 12, 20, 44, 100] {
            let c: Vec<f64> = (0..nodes)
                .map(|i| 0.5 - 0.5 * (std::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(nodes)).cos())
                .collect();
            let at = |step: i32| c.iter().map(|c| parabola(c + f64::from(step))).collect::<Vec<_>>();
            let mut past = Past::new(&c, 1);
            let mut found = vec![0.0; c.len()];
            assert!(!past.expect::<0, 0>(1, &mut found), "nothing is known");
            for step in 0..40 {
                past.push(&at(step));
                assert!(past.expect::<0, 0>(1, &mut found));
                let is_enough = past.known * c.len() >= 3 && (past.known >= 3 || !is_each_alone(c.len()));
                for (found, expected) in found.iter().zip(at(step + 1)).filter(|_| is_enough) {
                    assert!((found - expected).abs() <= 1e-7, "{nodes} nodes, step {step}: {found} for {expected}");
                }
            }
        }
    }

    /// Three unknowns at two nodes, which lie off a parabola by different constants: each goes on as it did.
    #[test]
    fn each_of_two_nodes_goes_on_by_itself() {
        let at = |step: i32| [0.1, -0.1, 0.3, -0.2, 0.4, 0.2].map(|off| off + f64::from(step * step));
        let mut past = Past::new(&[0.2, 0.8], 3);
        (0..12).for_each(|step| past.push(&at(step)));
        let mut found = [0.0; 6];
        past.expect::<3, 2>(3, &mut found);
        approx::assert_abs_diff_eq!(found[..], at(12)[..], epsilon = 1e-11);
    }

    /// The last node of a step is the first one of the next.
    #[test]
    fn of_nodes_that_coincide_one_is_used() {
        let weights = weights(&[0.0, 0.5, 1.0], 2, 1);
        assert!(weights.iter().all(|weight| weight.is_finite()), "{weights:?}");
    }

    /// The eigenvalues of [[0, −1/2], [1/8, 0]] are ±i/4, and so large are those of its absolute values; the bound is their
    /// 64th powers' sum, at most.
    #[test]
    fn the_radius_is_that_of_the_absolute_values_or_little_more() {
        let found = radius(&[0.0, -0.5, 0.125, 0.0], 2);
        assert!((0.25..0.25 * 4.0_f64.powf(1.0 / 64.0)).contains(&found), "{found}");
        assert_eq!(radius(&[0.25], 1), 0.25);
    }
}
