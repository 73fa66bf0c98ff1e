//! Radau IIA of order 5 with steps by tolerance, written by hand for one structure ([HW96] IV.8, RADAU5): what the adaptive method of
//! `lsvi` may cost where nothing is general.

#[expect(clippy::needless_range_loop, reason = "loops over indices are what a hand would write")]
mod matrix;

use std::marker::PhantomData;

use lsvi::nalgebra::Complex;

use super::{MAX_STEPS, Solver};
use crate::problem::{Problem, System};
pub(crate) use matrix::{Dense, Matrix, Tridiagonal};

/// The method with Jacobians M.
pub(crate) struct RadauByHand<M>(PhantomData<M>);

impl<M> RadauByHand<M> {
    pub(crate) const NEW: Self = Self(PhantomData);
}

impl<const N: usize, S: System<N>, M: Matrix<N>> Solver<Problem<N, S>> for RadauByHand<M> {
    fn name(&self) -> String {
        "Radau IIA-5".into()
    }

    fn run(&self, problem: &Problem<N, S>, tolerance: f64) -> Option<Vec<f64>> {
        Some(Run::<N, S, M>::new(problem, tolerance).finish()?.to_vec())
    }
}

/// T with T⁻¹ A⁻¹ T = diag(γ, (α −β; β α)).
const T: [[f64; 3]; 3] = [
    [9.123_239_487_089_295e-2, -0.141_255_295_020_954_2, -3.002_919_410_514_742_4e-2],
    [0.241_717_932_707_107, 0.204_129_352_293_799_94, 0.382_942_112_757_261_9],
    [0.966_048_182_615_093, 1.0, 0.0],
];
const T_INVERSE: [[f64; 3]; 3] = [
    [4.325_579_890_063_155, 0.339_199_251_815_809_84, 0.541_770_539_935_874_9],
    [-4.178_718_591_551_905, -0.327_682_820_761_062_4, 0.476_623_554_500_550_44],
    [-0.502_872_634_945_786_9, 2.571_926_949_855_605, -0.596_039_204_828_224_9],
];

/// Newton iterations of a step.
const ITERATIONS: i32 = 7;
/// Rate of convergence up to which the Jacobian is kept.
const KEEP: f64 = 1e-3;
const SAFETY: f64 = 0.9;

/// γ, α + iβ, the nodes and the weights of the error estimate.
struct Constants {
    gamma: f64,
    pair: Complex<f64>,
    nodes: [f64; 3],
    estimate: [f64; 3],
}

impl Constants {
    fn new() -> Self {
        let (nine, eighty_one, six) = (9_f64.cbrt(), 81_f64.cbrt(), 6_f64.sqrt());
        let eigenvalue = Complex::new((12.0 - eighty_one + nine) / 60.0, (eighty_one + nine) * 3_f64.sqrt() / 60.0);
        Self {
            gamma: 30.0 / (6.0 + eighty_one - nine),
            // The eigenvalues of A come in pairs: 1/z̄ for the one above the axis.
            pair: eigenvalue / eigenvalue.norm_sqr(),
            nodes: [0.1 * (4.0 - six), 0.1 * (4.0 + six), 1.0],
            estimate: [-(13.0 + 7.0 * six) / 3.0, (-13.0 + 7.0 * six) / 3.0, -1.0 / 3.0],
        }
    }
}

/// A run from the start of a problem.
struct Run<'a, const N: usize, S, M: Matrix<N>> {
    problem: &'a Problem<N, S>,
    c: Constants,
    tolerance: f64,
    /// Newton's last increment in units of the tolerance.
    goal: f64,
    t: f64,
    v: [f64; N],
    f: [f64; N],
    /// What is tolerated of each component.
    scale: [f64; N],
    jacobian: M,
    /// Whether the Jacobian is that at (t, v).
    is_current: bool,
    /// The step size of the factors.
    factored: Option<f64>,
    real: M::Factors<f64>,
    complex: M::Factors<Complex<f64>>,
    z: [[f64; N]; 3],
    w: [[f64; N]; 3],
    /// Divided differences of the last step, for the first guess of the next one, and its size.
    differences: [[f64; N]; 3],
    last: Option<f64>,
    contraction: f64,
}

/// Why a step is to be shorter.
struct TooLong {
    factor: f64,
}

impl<'a, const N: usize, S: System<N>, M: Matrix<N>> Run<'a, N, S, M> {
    fn new(problem: &'a Problem<N, S>, tolerance: f64) -> Self {
        let tolerance = 0.1 * tolerance.powf(2.0 / 3.0);
        let mut run = Self {
            problem,
            c: Constants::new(),
            tolerance,
            goal: (10.0 * f64::EPSILON / tolerance).max(tolerance.sqrt().min(0.03)),
            t: 0.0,
            v: problem.start,
            f: [0.0; N],
            scale: [0.0; N],
            jacobian: M::ZERO,
            is_current: false,
            factored: None,
            real: M::no_factors(),
            complex: M::no_factors(),
            z: [[0.0; N]; 3],
            w: [[0.0; N]; 3],
            differences: [[0.0; N]; 3],
            last: None,
            contraction: 1.0,
        };
        run.start_step();
        run.differentiate();
        run
    }

    /// f and the scale at the present state.
    fn start_step(&mut self) {
        self.problem.system.rhs(self.t, &self.v, &mut self.f);
        self.scale = self.v.map(|v| self.tolerance * (1.0 + v.abs()));
    }

    fn differentiate(&mut self) {
        self.jacobian = M::ZERO;
        let jacobian = &mut self.jacobian;
        self.problem.system.jacobian(self.t, &self.v, |i, j, x| jacobian.add(i, j, x));
        (self.is_current, self.factored) = (true, None);
    }

    fn norm(&self, x: &[f64; N]) -> f64 {
        let sum: f64 = x.iter().zip(&self.scale).map(|(x, scale)| (x / scale).powi(2)).sum();
        (sum / N as f64).sqrt()
    }

    fn finish(mut self) -> Option<[f64; N]> {
        let end = self.problem.end;
        let mut h = ((0.01 * self.norm(&self.v)).max(1.0) / self.norm(&self.f)).min(end);
        let mut is_after_rejection = false;
        let mut accepted: Option<(f64, f64)> = None;
        for _ in 0..MAX_STEPS {
            let ends = self.t + 1.01 * h >= end;
            if ends {
                h = end - self.t;
            }
            if h <= 8.0 * f64::EPSILON * self.t {
                return None;
            }
            let (theta, iterations) = match self.iterate(h) {
                Ok(found) => found,
                Err(TooLong { factor }) => {
                    h *= factor;
                    is_after_rejection = true;
                    self.renew();
                    continue;
                }
            };
            let error = self.estimate(h, is_after_rejection || self.last.is_none());
            let safety = SAFETY.min(SAFETY * f64::from(1 + 2 * ITERATIONS) / f64::from(iterations + 2 * ITERATIONS));
            let shrink = |quotient: f64| quotient.clamp(0.125, 5.0);
            let mut quotient = shrink(error.sqrt().sqrt() / safety);
            if error.is_nan() || error >= 1.0 {
                h *= if self.last.is_none() { 0.1 } else { 1.0 / quotient };
                is_after_rejection = true;
                self.renew();
                continue;
            }
            if let Some((size, before)) = accepted {
                quotient = quotient.max(shrink(size / h * (error * error / before).sqrt().sqrt() / SAFETY));
            }
            accepted = Some((h, error.max(0.01)));
            self.accept(h);
            if ends {
                return Some(self.v);
            }
            let next = if is_after_rejection { (h / quotient).min(h) } else { h / quotient };
            is_after_rejection = false;
            if theta > KEEP && !S::IS_LINEAR {
                self.differentiate();
            }
            if theta > KEEP || !(1.0..=1.2).contains(&(next / h)) {
                h = next;
            }
        }
        None
    }

    /// The Jacobian of the present state for another try.
    fn renew(&mut self) {
        if !self.is_current && !S::IS_LINEAR {
            self.differentiate();
        }
    }

    /// Simplified Newton iteration for the increments z of the stages: its rate and number.
    fn iterate(&mut self, h: f64) -> Result<(f64, i32), TooLong> {
        if self.factored != Some(h) {
            let halved = TooLong { factor: 0.5 };
            let (gamma, pair) = (self.c.gamma / h, self.c.pair / h);
            let factored = self.jacobian.factor_both((gamma, &mut self.real), (pair, &mut self.complex));
            if !factored {
                return Err(halved);
            }
            self.factored = Some(h);
        }
        self.guess(h);
        let (mut theta, mut before, mut quotient_before) = (KEEP, f64::NAN, f64::NAN);
        self.contraction = self.contraction.max(f64::EPSILON).powf(0.8);
        for iteration in 1..=ITERATIONS {
            let size = self.increment(h);
            if iteration > 1 && iteration < ITERATIONS {
                let quotient = size / before;
                theta = if iteration == 2 { quotient } else { (quotient * quotient_before).sqrt() };
                quotient_before = quotient;
                if theta.is_nan() || theta >= 0.99 {
                    return Err(TooLong { factor: 0.5 });
                }
                self.contraction = theta / (1.0 - theta);
                let left = ITERATIONS - 1 - iteration;
                let expected = self.contraction * size * theta.powi(left) / self.goal;
                if expected >= 1.0 {
                    let factor = 0.8 * expected.clamp(1e-4, 20.0).powf(-1.0 / f64::from(4 + left));
                    return Err(TooLong { factor });
                }
            }
            before = size.max(f64::EPSILON);
            if self.contraction * size <= self.goal {
                return Ok((theta, iteration));
            }
        }
        Err(TooLong { factor: 0.5 })
    }

    /// The polynomial through the stages of the last step, in the next one.
    fn guess(&mut self, h: f64) {
        let Some(last) = self.last else {
            (self.z, self.w) = ([[0.0; N]; 3], [[0.0; N]; 3]);
            return;
        };
        let [c1, c2, _] = self.c.nodes;
        for (z, node) in self.z.iter_mut().zip(self.c.nodes) {
            let at = node * h / last;
            for (k, z) in z.iter_mut().enumerate() {
                let [first, second, third] = [0, 1, 2].map(|d| self.differences[d][k]);
                *z = at * (first + (at - c2 + 1.0) * (second + (at - c1 + 1.0) * third));
            }
        }
        for k in 0..N {
            let w = product(&T_INVERSE, [0, 1, 2].map(|i| self.z[i][k]));
            (0..3).for_each(|i| self.w[i][k] = w[i]);
        }
    }

    /// Adds an increment to z and tells its size.
    fn increment(&mut self, h: f64) -> f64 {
        let mut f = [[0.0; N]; 3];
        for (i, f) in f.iter_mut().enumerate() {
            let stage = std::array::from_fn(|k| self.v[k] + self.z[i][k]);
            self.problem.system.rhs(self.t + self.c.nodes[i] * h, &stage, f);
        }
        let (gamma, pair) = (self.c.gamma / h, self.c.pair / h);
        let (mut real, mut complex) = ([0.0; N], [Complex::new(0.0, 0.0); N]);
        for k in 0..N {
            let [a, b, c] = product(&T_INVERSE, [f[0][k], f[1][k], f[2][k]]);
            real[k] = a - gamma * self.w[0][k];
            complex[k] = Complex::new(b, c) - pair * Complex::new(self.w[1][k], self.w[2][k]);
        }
        M::solve_both((&self.real, &mut real), (&self.complex, &mut complex));
        let mut sum = 0.0;
        for k in 0..N {
            let weight = self.scale[k].recip();
            sum += (real[k] * weight).powi(2) + complex[k].norm_sqr() * weight * weight;
            self.w[0][k] += real[k];
            self.w[1][k] += complex[k].re;
            self.w[2][k] += complex[k].im;
            let z = product(&T, [self.w[0][k], self.w[1][k], self.w[2][k]]);
            (0..3).for_each(|i| self.z[i][k] = z[i]);
        }
        (sum / (3 * N) as f64).sqrt()
    }

    /// The embedded estimate in units of the tolerance; `is_filtered` where stiff components may spoil it.
    fn estimate(&self, h: f64, is_filtered: bool) -> f64 {
        let weights = self.c.estimate.map(|e| e / h);
        let sum: [f64; N] = std::array::from_fn(|k| (0..3).map(|i| weights[i] * self.z[i][k]).sum());
        let mut error = std::array::from_fn(|k| self.f[k] + sum[k]);
        M::solve(&self.real, &mut error);
        let size = self.norm(&error);
        if size < 1.0 || !is_filtered {
            return floored(size);
        }
        let moved = std::array::from_fn(|k| self.v[k] + error[k]);
        let mut f = [0.0; N];
        self.problem.system.rhs(self.t, &moved, &mut f);
        let mut error = std::array::from_fn(|k| f[k] + sum[k]);
        M::solve(&self.real, &mut error);
        floored(self.norm(&error))
    }

    fn accept(&mut self, h: f64) {
        let [c1, c2, _] = self.c.nodes;
        for k in 0..N {
            let [z1, z2, z3] = [0, 1, 2].map(|i| self.z[i][k]);
            let first = (z2 - z3) / (c2 - 1.0);
            let middle = (z1 - z2) / (c1 - c2);
            let second = (middle - first) / (c1 - 1.0);
            let third = second - (middle - z1 / c1) / c2;
            [self.differences[0][k], self.differences[1][k], self.differences[2][k]] = [first, second, third];
            self.v[k] += z3;
        }
        self.t += h;
        self.last = Some(h);
        self.is_current = false;
        self.start_step();
    }
}

/// An error that a step may be lengthened by; NaN stays.
fn floored(error: f64) -> f64 {
    if error < 1e-10 { 1e-10 } else { error }
}

#[inline]
fn product(a: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i][0] * x[0] + a[i][1] * x[1] + a[i][2] * x[2])
}
