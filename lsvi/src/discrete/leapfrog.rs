//! Explicit steps of a separable Lagrangian.

use super::Interval;
use super::separable::{ConstantMass, Sum};
use crate::error::SolveError;
use crate::lagrangian::Lagrangian;
use crate::linalg::{by_size, size, vectors};

/// The position–momentum step of a broken line for L = ½ vᵀMv − V(t, q), kicks and drifts in turn: with x₀ = q₀, M v₀ = p₀ and
/// c_i = a₁ + … + a_i, v_i = v_{i−1} + h b_{i−1} M⁻¹L_q(t + c_{i−1} h, x_{i−1}) and x_i = x_{i−1} + h a_i v_i for i = 1, …, s;
/// then q₁ = x_s and p₁ = M v_s + h b_s L_q(t + h, q₁). A trajectory evaluates s forces a step.
#[derive(Debug)]
pub(super) struct Leapfrog {
    drifts: Vec<Drift>,
    /// b_s.
    last_kick: f64,
    mass: ConstantMass,
    sum: Sum,
    /// L_q at the last knot, v_i, x_i − q₀ and M v_i − p₀, and work space.
    scratch: Vec<f64>,
}

/// A piece of the line, with the kick before it.
#[derive(Debug, Clone, Copy)]
struct Drift {
    /// b_{i−1}.
    kick: f64,
    /// a_i.
    duration: f64,
    /// c_i.
    end: f64,
}

/// c₀, …, c_s. The last knot is the end of the step, whatever the durations sum to.
pub(super) fn knots(durations: &[f64]) -> Vec<f64> {
    let before = |i: usize| if i == durations.len() { 1.0 } else { durations[..i].iter().sum() };
    (0..=durations.len()).map(before).collect()
}

impl Leapfrog {
    /// By the durations a₁, …, a_s and the kicks b₀, …, b_s.
    pub(super) fn new(l: &dyn Lagrangian, durations: &[f64], kicks: &[f64]) -> Self {
        let drift = |((&duration, &kick), &end): ((&f64, &f64), &f64)| Drift { kick, duration, end };
        Self {
            drifts: durations.iter().zip(kicks).zip(&knots(durations)[1..]).map(drift).collect(),
            last_kick: kicks[durations.len()],
            mass: ConstantMass::new(l),
            sum: Sum::new(l.dim()),
            scratch: vec![0.0; 5 * l.dim()],
        }
    }

    /// Replaces (q₀, p₀) by (q₁, p₁), writes the knots x₁, …, x_s, and returns how often the forces were evaluated.
    #[inline(always)]
    pub(super) fn step<L: Lagrangian>(
        &mut self,
        l: &L,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<u64, SolveError> {
        // Where the dimension of a Lagrangian is a constant, the other sizes are not compiled.
        by_size!(l.dim(), N => match self.drifts.len() {
            1 => self.step_sized::<L, N, 1>(l, at, q, p, x),
            _ => self.step_sized::<L, N, 0>(l, at, q, p, x),
        }, else self.step_of_many(&l, at, q, p, x))
    }

    /// [`Self::step`] of many unknowns, compiled once for all Lagrangians.
    fn step_of_many(
        &mut self,
        l: &dyn Lagrangian,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<u64, SolveError> {
        self.step_sized::<_, 0, 0>(&l, at, q, p, x)
    }

    #[inline(always)]
    fn step_sized<L: Lagrangian, const N: usize, const S: usize>(
        &mut self,
        l: &L,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<u64, SolveError> {
        let (n, s) = (size::<N>(q.len()), size::<S>(self.drifts.len()));
        let (q, p, x, h) = (&mut q[..n], &mut p[..n], &mut x[..s * n], at.h);
        let Self { drifts, last_kick, mass, sum, scratch } = self;
        let [force, velocity, way, impulse, work] = vectors(scratch, n);
        if !sum.continues(at.start, q, p) {
            // That of a step that failed need not be finite.
            velocity.fill(0.0);
            l.gradient_q(at.start, q, velocity, force, work);
        }
        let inverse = mass.inverse(l, (at.start, h), q, p)?;
        velocity.copy_from_slice(p);
        inverse.solve(velocity);
        way.fill(0.0);
        impulse.fill(0.0);
        let mut before: &[f64] = &q[..];
        for (drift, knot) in drifts[..s].iter().zip(x.chunks_exact_mut(n)) {
            let (kick, duration) = (h * drift.kick, h * drift.duration);
            let acceleration = inverse.of(force, work);
            for i in 0..n {
                // Where the velocity before leads to does not wait for the force.
                let coast = before[i] + duration * velocity[i];
                knot[i] = coast + duration * kick * acceleration[i];
                velocity[i] += kick * acceleration[i];
                way[i] += duration * velocity[i];
                impulse[i] += kick * force[i];
            }
            l.gradient_q(at.start + drift.end * h, knot, velocity, force, work);
            before = knot;
        }
        let (kick, mut finite) = (h * *last_kick, 0.0);
        for i in 0..n {
            impulse[i] += kick * force[i];
            finite += way[i] + impulse[i];
        }
        if !finite.is_finite() {
            sum.forget();
            return Err(SolveError::NonFinite);
        }
        sum.add(at.start + h, (q, way), (p, impulse));
        x[(s - 1) * n..].iter_mut().zip(&*q).for_each(|(x, q)| *x = *q);
        Ok(drifts.len() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten tenths add up to 1 − ε/2.
    #[test]
    fn the_last_knot_is_the_end_of_the_step() {
        assert_eq!([0.1; 10].iter().sum::<f64>(), 1.0 - 0.5 * f64::EPSILON);
        assert_eq!(knots(&[0.1; 10])[10], 1.0);
        assert_eq!(knots(&[0.25, 0.75]), [0.0, 0.25, 1.0]);
    }
}
