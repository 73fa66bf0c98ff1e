//! Wendlandt and Marsden's discrete Lagrangian: straight path, midpoint rule.

use super::nystrom::{Coefficients, Nystrom};
use super::velocity::Velocity;
use super::{Constrainable, DiscreteLagrangian, DiscreteLegendre, Interval, MomentumWeights, secant, straight};
use crate::error::SolveError;
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Jacobian, Structure};

/// L_d = h L(t₀ + h/2, (q₀ + q₁)/2, (q₁ − q₀)/h) (\[MW01\]).
///
/// The momenta are p₀ = L_v − (h/2) L_q and p₁ = L_v + (h/2) L_q. For a least-squares Lagrangian p₁ = 0 is the implicit
/// midpoint rule.
#[derive(Debug)]
pub struct Midpoint<L> {
    lagrangian: L,
    middle: Vec<f64>,
    velocity: Vec<f64>,
    dl_dq: Vec<f64>,
    dl_dv: Vec<f64>,
    velocity_of: Velocity,
    nystrom: Option<Box<Nystrom>>,
}

impl<L: Lagrangian> Midpoint<L> {
    /// Discretises `lagrangian`.
    pub fn new(lagrangian: L) -> Self {
        let zeros = vec![0.0; lagrangian.dim()];
        Self {
            nystrom: lagrangian.is_separable().then(|| Box::new(Nystrom::new(&lagrangian, Coefficients::midpoint()))),
            velocity_of: Velocity::new(zeros.len(), &lagrangian.structure()),
            lagrangian,
            middle: zeros.clone(),
            velocity: zeros.clone(),
            dl_dq: zeros.clone(),
            dl_dv: zeros,
        }
    }

    /// The Lagrangian.
    pub fn lagrangian(&self) -> &L {
        &self.lagrangian
    }

    fn place(&mut self, at: Interval, q0: &[f64], q1: &[f64]) -> f64 {
        secant(at.h, q0, q1, &mut self.velocity);
        for ((m, a), b) in self.middle.iter_mut().zip(q0).zip(q1) {
            *m = 0.5 * (a + b);
        }
        at.start + 0.5 * at.h
    }
}

impl<L: Lagrangian> DiscreteLegendre for Midpoint<L> {
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
        let Some(nystrom) = &mut self.nystrom else { return Ok(None) };
        nystrom.step(&self.lagrangian, at, q, p, x)
    }

    fn impulse(&mut self, at: Interval, q0: &[f64], q1: &[f64], out: &mut [f64]) -> bool {
        self.momentum(at, q0, q1, MomentumWeights::CHANGE, out);
        true
    }

    fn momentum(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut [f64]) {
        let t = self.place(at, q0, q1);
        self.lagrangian.gradient(t, &self.middle, &self.velocity, &mut self.dl_dq, &mut self.dl_dv);
        let (sum, difference) = (w.alpha + w.beta, 0.5 * at.h * (w.beta - w.alpha));
        for ((o, lv), lq) in out.iter_mut().zip(&self.dl_dv).zip(&self.dl_dq) {
            *o = sum * lv + difference * lq;
        }
    }

    fn add_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        let t = self.place(at, q0, q1);
        let (sum, difference) = (w.alpha + w.beta, w.beta - w.alpha);
        let c = HessianWeights { qq: 0.25 * at.h * difference, qv: 0.5 * difference, vq: 0.5 * sum, vv: sum / at.h };
        self.lagrangian.add_hessian(t, &self.middle, &self.velocity, c, out);
    }

    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], q1: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        let t = self.place(at, q0, q1);
        let (sum, difference) = (w.alpha + w.beta, w.beta - w.alpha);
        let c = HessianWeights { qq: 0.25 * at.h * difference, qv: -0.5 * difference, vq: 0.5 * sum, vv: -sum / at.h };
        self.lagrangian.add_hessian(t, &self.middle, &self.velocity, c, out);
    }
}

impl<L: Lagrangian> DiscreteLagrangian for Midpoint<L> {
    fn action(&mut self, at: Interval, q0: &[f64], q1: &[f64]) -> f64 {
        let t = self.place(at, q0, q1);
        at.h * self.lagrangian.value(t, &self.middle, &self.velocity)
    }
}

impl<L: Lagrangian> Constrainable for Midpoint<L> {
    fn mechanics(&self) -> &dyn Lagrangian {
        &self.lagrangian
    }
}
