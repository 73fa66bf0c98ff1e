//! The explicit step of a separable Lagrangian.

use super::Interval;
use super::separable::{ConstantMass, Sum};
use crate::error::SolveError;
use crate::lagrangian::Lagrangian;
use crate::linalg::{by_size, size};

/// The position–momentum step of the trapezoidal rule for L = ½ vᵀMv − V(t, q): Störmer and Verlet's,
/// M v = p₀ + ½h L_q|₀, q₁ = q₀ + h v, p₁ = M v + ½h L_q|₁, with one evaluation of L_q on a trajectory.
#[derive(Debug)]
pub(super) struct Leapfrog {
    mass: ConstantMass,
    sum: Sum,
    velocity: Vec<f64>,
    next: Vec<f64>,
    /// L_q at the end of the last step, and of this one.
    force: Vec<f64>,
    end: Vec<f64>,
    work: Vec<f64>,
}

impl Leapfrog {
    pub(super) fn new(l: &dyn Lagrangian) -> Self {
        let zeros = vec![0.0; l.dim()];
        Self {
            mass: ConstantMass::new(l),
            sum: Sum::new(l.dim()),
            velocity: zeros.clone(),
            next: zeros.clone(),
            force: zeros.clone(),
            end: zeros.clone(),
            work: zeros,
        }
    }

    /// Replaces (q₀, p₀) by (q₁, p₁).
    pub(super) fn step(
        &mut self,
        l: &dyn Lagrangian,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
    ) -> Result<(), SolveError> {
        by_size!(q.len(), N => self.step_sized::<N>(l, at, q, p))
    }

    #[inline]
    fn step_sized<const N: usize>(
        &mut self,
        l: &dyn Lagrangian,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
    ) -> Result<(), SolveError> {
        let n = size::<N>(q.len());
        let (q, p, h, t) = (&mut q[..n], &mut p[..n], at.h, at.start + at.h);
        let Self { mass, sum, velocity, next, force, end, work } = self;
        let (velocity, next, force, end) = (&mut velocity[..n], &mut next[..n], &mut force[..n], &mut end[..n]);
        if !sum.continues(at.start, q, p) {
            l.gradient_q(at.start, q, velocity, force, work);
        }
        for i in 0..n {
            velocity[i] = p[i] + 0.5 * h * force[i];
        }
        mass.inverse(l, (at.start, h), q, p)?.solve(velocity);
        for i in 0..n {
            next[i] = q[i] + h * velocity[i];
        }
        l.gradient_q(t, next, velocity, end, work);
        let mut finite = 0.0;
        for i in 0..n {
            finite += end[i] + next[i];
        }
        if !finite.is_finite() {
            sum.forget();
            return Err(SolveError::NonFinite);
        }
        for i in 0..n {
            let impulse = 0.5 * h * (force[i] + end[i]);
            sum.add(i, (&mut q[i], h * velocity[i]), (&mut p[i], impulse));
            force[i] = end[i];
        }
        sum.end(t);
        Ok(())
    }
}
