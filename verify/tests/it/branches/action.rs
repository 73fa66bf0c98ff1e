//! The equations of a step of a least-squares method in balls of 57 digits, from the action alone.

use lsvi::closure::{Linear, LinearClosure};
use nalgebra::DMatrix;
use verify::judge::real::Real;

/// f(v) = a v + b v².
#[derive(Debug, Clone, Copy)]
pub(crate) struct Field {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

/// ½ Σ w |v′ − s f(v)|² over the nodes of a path v = Σ x_k φ_k on [0, 1], or on [0, K] for a window: φ₀ is 1 at the start, the
/// last one at the end, and the others vanish at both.
#[derive(Debug, Clone)]
pub(crate) struct Action {
    weights: Vec<f64>,
    /// φ_k at each node.
    values: Vec<Vec<f64>>,
    /// φ_k′ at each node.
    slopes: Vec<Vec<f64>>,
    /// Steps on the path.
    pub(crate) steps: usize,
}

/// α and β of α p₀ + β p₁ = 0.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Closure {
    Constant(f64, f64),
    /// (−θ, 1), θ = 1/(1 + sλ/2).
    Pade(f64),
    /// (−θ, 1) with θ such that v̇ = −λv is solved exactly.
    Exact(f64),
}

/// The closing equation is Σ w R (`sum` φ_end′ − `scale` f′(v) φ) = 0, R = v′ − s f(v), with φ = β φ_end − α φ_start: α p₀ + β p₁, divided by s
/// where α + β vanishes with it.
struct Weights {
    alpha: Real,
    beta: Real,
    sum: Real,
    scale: Real,
}

impl Action {
    /// A polynomial of degree `s`, whose interior is spanned by τᵏ − τ.
    pub(crate) fn galerkin(s: usize, nodes: &[f64], weights: &[f64]) -> Self {
        let row = |value: fn(f64, i32) -> f64, ends: [f64; 2], linear: f64, c: f64| {
            let interior = (2..=s as i32).map(|k| value(c, k) - linear);
            std::iter::once(ends[0]).chain(interior).chain([ends[1]]).collect()
        };
        let value = |c: &f64| row(|c, k| c.powi(k), [1.0 - c, *c], *c, *c);
        let slope = |c: &f64| row(|c, k| f64::from(k) * c.powi(k - 1), [-1.0, 1.0], 1.0, *c);
        Self {
            weights: weights.to_vec(),
            values: nodes.iter().map(value).collect(),
            slopes: nodes.iter().map(slope).collect(),
            steps: 1,
        }
    }

    /// `steps` straight pieces, each under the trapezoidal rule.
    pub(crate) fn pieces(steps: usize) -> Self {
        let hat = |at: usize| (0..=steps).map(|k| if k == at { 1.0 } else { 0.0 }).collect::<Vec<_>>();
        let both = |n: usize| {
            let slope: Vec<f64> = hat(n + 1).iter().zip(hat(n)).map(|(right, left)| right - left).collect();
            [(hat(n), slope.clone()), (hat(n + 1), slope)]
        };
        let (values, slopes) = (0..steps).flat_map(both).unzip();
        Self { weights: vec![0.5; 2 * steps], values, slopes, steps }
    }

    pub(crate) fn unknowns(&self) -> usize {
        self.values[0].len() - 1
    }
}

/// What a step of size s has to solve.
#[derive(Debug, Clone)]
pub(crate) struct Equations {
    pub(crate) action: Action,
    pub(crate) closure: Closure,
    pub(crate) field: Field,
    pub(crate) start: f64,
}

impl Equations {
    /// Unknowns: coefficients of the interior, and the value at the end.
    pub(crate) fn dim(&self) -> usize {
        self.action.unknowns()
    }

    /// The path that rests at the start, which solves the equations for s = 0.
    pub(crate) fn origin(&self) -> Vec<Real> {
        let rests = |k: usize| self.action.steps > 1 || k + 1 == self.dim();
        (0..self.dim()).map(|k| if rests(k) { Real::double(self.start) } else { Real::zero() }).collect()
    }

    /// The equations and their derivatives by the unknowns `x`; with the sums of the moduli of their terms, in doubles.
    pub(crate) fn at(&self, s: &Real, x: &[Real]) -> (Vec<Real>, Vec<Vec<Real>>, Vec<f64>) {
        let (n, [a, b]) = (self.dim(), [self.field.a, self.field.b].map(Real::double));
        let closing = self.closure.weights(s);
        let mut g = vec![Real::zero(); n];
        let mut jacobian = vec![vec![Real::zero(); n]; n];
        let mut moduli = vec![0.0; n];
        for (j, weight) in self.action.weights.iter().enumerate() {
            let [values, slopes] = [&self.action.values[j], &self.action.slopes[j]]
                .map(|row| row.iter().map(|x| Real::double(*x)).collect::<Vec<_>>());
            let full = |row: &[Real]| {
                let interior = row[1..].iter().zip(x).map(|(c, x)| c * x);
                std::iter::once(&row[0] * &Real::double(self.start)).chain(interior).sum::<Real>()
            };
            let (v, rate) = (full(&values), full(&slopes));
            let bv = &b * &v;
            let f_v = &(&a + &bv) + &bv;
            let residual = &rate - &(s * &(&(&a + &bv) * &v));
            let weighted = &Real::double(*weight) * &residual;
            // ∂R/∂x_k, and the test functions of the equations as what multiplies w R, with its part that f″ acts on.
            let reaction = s * &f_v;
            let by: Vec<Real> = (1..=n).map(|k| &slopes[k] - &(&reaction * &values[k])).collect();
            let end = &(&closing.beta * &values[n]) - &(&closing.alpha * &values[0]);
            let second = |k: usize, part: &Real| &(&(&b + &b) * part) * &values[k + 1];
            for i in 0..n {
                let (test, part) = match i + 1 == n {
                    true => (&(&closing.sum * &slopes[n]) - &(&closing.scale * &(&f_v * &end)), &closing.scale * &end),
                    false => (by[i].clone(), s * &values[i + 1]),
                };
                g[i] = &g[i] + &(&weighted * &test);
                // α + β is rounded where it is small, and divided by s.
                let rounded = if i + 1 == n { self.closure.cancelled(s) } else { 0.0 };
                let terms = test.to_f64().abs() + 2.0 * (&part * &f_v).to_f64().abs() + rounded;
                moduli[i] += weight * self.modulus(s, x, j) * terms;
                for (k, entry) in jacobian[i].iter_mut().enumerate() {
                    let linear = &(&Real::double(*weight) * &by[k]) * &test;
                    *entry = &(&*entry + &linear) - &(&weighted * &second(k, &part));
                }
            }
        }
        (g, jacobian, moduli)
    }

    /// Σ |x_k φ_k′| + s (|a| |v| + |b| v²), |v| = Σ |x_k φ_k|, at node `j`.
    fn modulus(&self, s: &Real, x: &[Real], j: usize) -> f64 {
        let sum = |row: &[f64]| {
            let interior = row[1..].iter().zip(x).map(|(c, x)| (c * x.to_f64()).abs());
            (row[0] * self.start).abs() + interior.sum::<f64>()
        };
        let v = sum(&self.action.values[j]);
        sum(&self.action.slopes[j]) + s.to_f64() * (self.field.a.abs() + self.field.b.abs() * v) * v
    }
}

impl Closure {
    /// 2/s where α + β, of terms of size 1, is divided by s.
    fn cancelled(self, s: &Real) -> f64 {
        if matches!(self, Self::Constant(..)) { 0.0 } else { 2.0 / s.to_f64() }
    }

    fn weights(self, s: &Real) -> Weights {
        let one = Real::one();
        let exact = Linear::fitted(1.0).expect("positive");
        match self {
            Self::Constant(alpha, beta) if alpha + beta == 0.0 => {
                let [alpha, beta] = [alpha, beta].map(Real::double);
                Weights { alpha, beta, sum: Real::zero(), scale: one }
            }
            Self::Constant(alpha, beta) => {
                let [alpha, beta] = [alpha, beta].map(Real::double);
                Weights { sum: &alpha + &beta, alpha, beta, scale: s.clone() }
            }
            Self::Pade(rate) => {
                let half = Real::double(0.5 * rate);
                let theta = &one / &(&one + &(&half * s));
                Weights { sum: &half * &theta, alpha: -&theta, beta: one.clone(), scale: one }
            }
            Self::Exact(rate) => {
                // θ falls from 1 with the slope −½ + z/4 at most, and is given to within 32 ε.
                let z = s * &Real::double(rate);
                let (at, reach, rounding) = (z.to_f64(), z.radius(), 32.0 * f64::EPSILON);
                let theta = -exact.weights(at).alpha;
                let sum = Real::double((1.0 - theta) / at).widened(rounding / at + 0.25 * reach);
                let alpha = -&Real::double(theta).widened(rounding + 0.5 * reach);
                Weights { alpha, beta: one.clone(), sum: &Real::double(rate) * &sum, scale: one }
            }
        }
    }
}

/// The inverse of the midpoints of a matrix of balls.
pub(crate) fn inverse(matrix: &[Vec<Real>]) -> Option<DMatrix<f64>> {
    DMatrix::from_fn(matrix.len(), matrix.len(), |i, j| matrix[i][j].to_f64()).try_inverse()
}
