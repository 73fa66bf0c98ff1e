//! MacKay's discrete Lagrangian: straight path, trapezoidal rule, Eqs. (9), (18).

use super::leapfrog::Leapfrog;
use super::velocity::Velocity;
use super::{Constrainable, DiscreteLagrangian, DiscreteLegendre, Interval, MomentumWeights, secant, straight};
use crate::error::SolveError;
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Jacobian, Structure};

/// L_d = (h/2) [L(t₀, q₀, d) + L(t₁, q₁, d)] with d = (q₁ − q₀)/h, Eq. (9).
///
/// The momenta are p₀ = ½ (L_v|₀ + L_v|₁) − (h/2) L_q|₀ and p₁ = ½ (L_v|₀ + L_v|₁) + (h/2) L_q|₁.
#[derive(Debug)]
pub struct Trapezoidal<L> {
    lagrangian: L,
    velocity: Vec<f64>,
    dl_dq: Vec<f64>,
    dl_dv: Vec<f64>,
    velocity_of: Velocity,
    leapfrog: Option<Box<Leapfrog>>,
}

impl<L: Lagrangian> Trapezoidal<L> {
    /// Discretises `lagrangian`.
    pub fn new(lagrangian: L) -> Self {
        let zeros = vec![0.0; lagrangian.dim()];
        Self {
            velocity_of: Velocity::new(zeros.len(), &lagrangian.structure()),
            leapfrog: lagrangian.is_separable().then(|| Box::new(Leapfrog::new(&lagrangian, &[1.0], &[0.5; 2]))),
            lagrangian,
            velocity: zeros.clone(),
            dl_dq: zeros.clone(),
            dl_dv: zeros,
        }
    }

    /// The Lagrangian.
    pub fn lagrangian(&self) -> &L {
        &self.lagrangian
    }
}

impl<L: Lagrangian> DiscreteLegendre for Trapezoidal<L> {
    fn dim(&self) -> usize {
        self.lagrangian.dim()
    }

    fn structure(&self) -> Structure {
        self.lagrangian.structure()
    }

    fn predict(&mut self, at: Interval, q0: &[f64], p0: &[f64], x: &mut [f64]) -> Result<(), SolveError> {
        let v = self.velocity_of.of(&self.lagrangian, at.start, q0, p0)?;
        straight(at.h, q0, v, x);
        Ok(())
    }

    fn separable_step(
        &mut self,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<Option<u64>, SolveError> {
        let Some(leapfrog) = &mut self.leapfrog else { return Ok(None) };
        leapfrog.step(&self.lagrangian, at, q, p, x).map(Some)
    }

    fn impulse(&mut self, at: Interval, q0: &[f64], q1: &[f64], out: &mut [f64]) -> bool {
        self.momentum(at, q0, q1, MomentumWeights::CHANGE, out);
        true
    }

    fn momentum(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut [f64]) {
        secant(at.h, q0, q1, &mut self.velocity);
        out.fill(0.0);
        let common = 0.5 * (w.alpha + w.beta);
        let ends = [(at.start, q0, -0.5 * at.h * w.alpha), (at.start + at.h, q1, 0.5 * at.h * w.beta)];
        for (t, q, own) in ends {
            self.lagrangian.gradient(t, q, &self.velocity, &mut self.dl_dq, &mut self.dl_dv);
            for ((o, lv), lq) in out.iter_mut().zip(&self.dl_dv).zip(&self.dl_dq) {
                *o += common * lv + own * lq;
            }
        }
    }

    fn add_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        secant(at.h, q0, q1, &mut self.velocity);
        let common = 0.5 * (w.alpha + w.beta);
        let start = HessianWeights { vv: common / at.h, qv: -0.5 * w.alpha, ..Default::default() };
        let end = HessianWeights { qq: 0.5 * at.h * w.beta, qv: 0.5 * w.beta, vq: common, vv: common / at.h };
        self.lagrangian.add_hessian(at.start, q0, &self.velocity, start, out);
        self.lagrangian.add_hessian(at.start + at.h, q1, &self.velocity, end, out);
    }

    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        secant(at.h, q0, q1, &mut self.velocity);
        let common = 0.5 * (w.alpha + w.beta);
        let start = HessianWeights { qq: -0.5 * at.h * w.alpha, qv: 0.5 * w.alpha, vq: common, vv: -common / at.h };
        let end = HessianWeights { qv: -0.5 * w.beta, vv: -common / at.h, ..Default::default() };
        self.lagrangian.add_hessian(at.start, q0, &self.velocity, start, out);
        self.lagrangian.add_hessian(at.start + at.h, q1, &self.velocity, end, out);
    }
}

impl<L: Lagrangian> DiscreteLagrangian for Trapezoidal<L> {
    fn action(&mut self, at: Interval, q0: &[f64], q1: &[f64]) -> f64 {
        secant(at.h, q0, q1, &mut self.velocity);
        let ends = [(at.start, q0), (at.start + at.h, q1)];
        0.5 * at.h * ends.map(|(t, q)| self.lagrangian.value(t, q, &self.velocity)).iter().sum::<f64>()
    }
}

impl<L: Lagrangian> Constrainable for Trapezoidal<L> {
    fn mechanics(&self) -> &dyn Lagrangian {
        &self.lagrangian
    }
}
