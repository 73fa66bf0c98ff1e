//! The explicit step of a separable Lagrangian.

use super::Interval;
use crate::error::SolveError;
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Jacobian, Lu};

/// Largest relative difference of two mass matrices that passes for rounding.
const CONSTANT: f64 = 1e-10;

/// The position–momentum step of the trapezoidal rule for L = ½ vᵀMv − V(t, q): Störmer and Verlet's,
/// M v = p₀ + ½h L_q|₀, q₁ = q₀ + h v, p₁ = M v + ½h L_q|₁, with one evaluation of L_q on a trajectory.
#[derive(Debug)]
pub(super) struct Leapfrog {
    mass: Jacobian,
    other: Jacobian,
    /// The factors of M, once it is known.
    lu: Option<Lu>,
    velocity: Vec<f64>,
    next: Vec<f64>,
    /// L_q at the end of the last step, at the time t and the position q, and of this one.
    force: Vec<f64>,
    t: f64,
    q: Vec<f64>,
    end: Vec<f64>,
    scratch: Vec<f64>,
}

impl Leapfrog {
    pub(super) fn new(l: &impl Lagrangian) -> Self {
        let (zeros, mass) = (vec![0.0; l.dim()], Jacobian::with_structure(l.dim(), &l.structure()));
        Self {
            other: mass.clone(),
            mass,
            lu: None,
            velocity: zeros.clone(),
            next: zeros.clone(),
            force: zeros.clone(),
            t: f64::NAN,
            q: zeros.clone(),
            end: zeros.clone(),
            scratch: zeros,
        }
    }

    /// Replaces (q₀, p₀) by (q₁, p₁).
    pub(super) fn step(
        &mut self,
        l: &impl Lagrangian,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
    ) -> Result<(), SolveError> {
        let (half, end) = (0.5 * at.h, at.start + at.h);
        if self.t != at.start || self.q != q {
            self.t = f64::NAN;
            l.gradient_q(at.start, q, &self.velocity, &mut self.force, &mut self.scratch);
        }
        let is_first = self.lu.is_none();
        if is_first {
            self.set_mass(l, at.start, q)?;
        }
        let Some(lu) = &mut self.lu else { return Err(SolveError::SingularMass) };
        for ((v, p), force) in self.velocity.iter_mut().zip(&*p).zip(&self.force) {
            *v = p + half * force;
        }
        lu.solve(&mut self.velocity);
        for ((next, q), v) in self.next.iter_mut().zip(&*q).zip(&self.velocity) {
            *next = q + at.h * v;
        }
        if is_first && let Err(error) = self.check_separable(l, [at.start, end], q) {
            self.lu = None;
            return Err(error);
        }
        l.gradient_q(end, &self.next, &self.velocity, &mut self.end, &mut self.scratch);
        let sum: f64 = self.end.iter().zip(&self.next).map(|(force, q)| force + q).sum();
        if !sum.is_finite() {
            return Err(SolveError::NonFinite);
        }
        for ((p, start), end) in p.iter_mut().zip(&self.force).zip(&self.end) {
            *p = (*p + half * start) + half * end;
        }
        q.copy_from_slice(&self.next);
        std::mem::swap(&mut self.force, &mut self.end);
        std::mem::swap(&mut self.q, &mut self.next);
        self.t = end;
        Ok(())
    }

    fn set_mass(&mut self, l: &impl Lagrangian, t: f64, q: &[f64]) -> Result<(), SolveError> {
        self.mass.clear();
        self.velocity.fill(0.0);
        l.add_hessian(t, q, &self.velocity, HessianWeights { vv: 1.0, ..Default::default() }, &mut self.mass);
        let mut lu = Lu::of(&self.mass);
        lu.factor(&self.mass).map_err(|_| SolveError::SingularMass)?;
        self.lu = Some(lu);
        Ok(())
    }

    /// Refuses a Lagrangian with other second derivatives in v at either end of the first step, or mixed ones.
    fn check_separable(&mut self, l: &impl Lagrangian, times: [f64; 2], q: &[f64]) -> Result<(), SolveError> {
        let mut largest = 0.0_f64;
        self.mass.for_each(|_, _, m| largest = largest.max(m.abs()));
        for (t, q) in times.into_iter().zip([q, &self.next]) {
            for c in
                [HessianWeights { vv: 1.0, ..Default::default() }, HessianWeights { qv: 1.0, ..Default::default() }]
            {
                self.other.clear();
                l.add_hessian(t, q, &self.velocity, c, &mut self.other);
                let (mass, mut different) = (&self.mass, None);
                self.other.for_each(|i, j, x| {
                    let is_same = if c.vv == 1.0 { (x - mass.get(i, j)).abs() <= CONSTANT * largest } else { x == 0.0 };
                    if !is_same {
                        different = Some((i, j));
                    }
                });
                if let Some((row, column)) = different {
                    return Err(SolveError::NotSeparable { row, column });
                }
            }
        }
        Ok(())
    }
}
