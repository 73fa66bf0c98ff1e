//! The exact solution of a semi-discrete flow by the eigenvectors of its matrices.

use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

use super::Channel;
use crate::problem::Problem;

/// K x = λ M x with xᵀ M x = 1, and what the initial state and the loads are in these coordinates.
#[derive(Debug)]
pub(super) struct Modes {
    vectors: DMatrix<f64>,
    /// ν λ.
    rates: Vec<f64>,
    initial: DVector<f64>,
    /// Complex amplitude of the load e^{iωt}.
    load: Vec<Complex<f64>>,
    omega: f64,
}

impl Modes {
    pub(super) fn new(channel: &Channel) -> Self {
        let (space, flow) = (&channel.space, &channel.flow);
        let n = space.mass.dim();
        // L⁻¹ K L⁻ᵀ for M = L Lᵀ.
        let mut reduced = DMatrix::zeros(n, n);
        space.stiffness.for_each(|i, j, k| reduced[(i, j)] = k);
        for _ in 0..2 {
            reduced.column_iter_mut().for_each(|mut column| channel.mass.solve_lower(column.as_mut_slice()));
            reduced.transpose_mut();
        }
        let SymmetricEigen { eigenvectors: mut vectors, eigenvalues } = SymmetricEigen::new(reduced);
        vectors.column_iter_mut().for_each(|mut column| channel.mass.solve_upper(column.as_mut_slice()));
        let mut momentum = DVector::zeros(n);
        space.mass.mul_add(1.0, &channel.initial(), momentum.as_mut_slice());
        let coordinates = |x: &[f64]| vectors.tr_mul(&DVector::from_column_slice(x));
        let (in_phase, inertia) = (coordinates(&channel.load), coordinates(&space.wall_mass));
        // Re(i ω e^{iωt}) = −ω sin ωt, the rate of cos ωt.
        let load = in_phase.iter().zip(&inertia).map(|(f, m)| Complex::new(*f, -flow.omega * flow.wall * m)).collect();
        let rates = eigenvalues.iter().map(|k| flow.nu * k).collect();
        Self { initial: vectors.tr_mul(&momentum), vectors, rates, load, omega: flow.omega }
    }

    /// The largest rate of decay.
    pub(super) fn fastest(&self) -> f64 {
        self.rates.iter().fold(0.0, |m: f64, rate| m.max(*rate))
    }

    /// The state at time t.
    pub(super) fn solution(&self, t: f64) -> Vec<f64> {
        let amplitude = |k: usize| {
            let (rate, load) = (self.rates[k], self.load[k]);
            if self.omega == 0.0 {
                let answer = if rate == 0.0 { t } else { -(-rate * t).exp_m1() / rate };
                return self.initial[k] * (-rate * t).exp() + load.re * answer;
            }
            let periodic = load / Complex::new(rate, self.omega);
            let turned = periodic * Complex::new(0.0, self.omega * t).exp();
            (self.initial[k] - periodic.re) * (-rate * t).exp() + turned.re
        };
        (&self.vectors * DVector::from_fn(self.rates.len(), |k, _| amplitude(k))).as_slice().to_vec()
    }
}
