//! The stages of one step: simplified Newton iteration in the decoupled basis, and the embedded estimate.

use nalgebra::Complex;

use super::coefficients::{Coefficients, dot, product};
use super::tolerances::{Tolerances, root_mean, squared};
use crate::linalg::{FactorError, Jacobian, Lu, Structure, by_size, size};
use crate::mass::Mass;
use crate::newton::Work;
use crate::vector_field::VectorField;

/// Part by which two step sizes may differ that share factors, as by roundings of the times that they lead to: by as much do
/// Newton's iteration and the error estimate change.
const SAME: f64 = 1e-6;

/// Newton's last increment in units of the tolerance, in a step as long as that allows: a digit and a half below the error of the solution.
const GOAL: f64 = 0.03;

/// How Newton's iteration ended.
pub(super) enum Iteration {
    /// With this rate, 0 after a single iteration.
    Converged { rate: f64, iterations: u32 },
    /// It would not reach its goal; a step shorter by this factor might.
    Slow { factor: f64 },
    /// f was not finite at the stages.
    NonFinite,
}

/// M v̇ = f(t, v), and how well it is to be solved.
pub(super) struct Equations<'a, F> {
    pub(super) field: &'a F,
    pub(super) mass: &'a Mass,
    pub(super) tolerances: &'a Tolerances,
    /// The last time at which f is evaluated.
    pub(super) latest: f64,
    /// The part of the step that the tolerances alone would allow, at most 1: errors of the iteration add up from step to step.
    pub(super) part: f64,
}

/// Newton iterations of a step with s stages.
pub(super) fn iterations(s: usize) -> u32 {
    // As many again as the stages are more, for the larger h|f_v| that they are used with ([HW96] IV.8, RADAU).
    7 + 5 * (s as u32 - 3) / 2
}

/// A field, its Jacobian, and the factors of γ M/h − J and (α − iβ) M/h − J for each pair.
///
/// The solution x + iy of the complex system is that of [[α M/h − J, β M/h], [−β M/h, α M/h − J]] (x; y).
#[derive(Debug)]
pub(super) struct StageSystem {
    jacobian: Jacobian,
    real: Lu,
    complex: Vec<Lu<Complex<f64>>>,
    rhs: Vec<Complex<f64>>,
    /// Whether the Jacobian is that of the present state.
    pub(super) is_current: bool,
    /// Step size and number of stages that the factors belong to, unless they serve no more.
    factored: Option<(f64, usize)>,
    /// Whether the next factors are the first ones of sparse matrices, which allocate.
    is_fresh: bool,
}

impl StageSystem {
    pub(super) fn new(jacobian: Jacobian, most: usize) -> Self {
        Self {
            real: Lu::of(&jacobian),
            complex: (0..most / 2).map(|_| Lu::of(&jacobian)).collect(),
            rhs: vec![Complex::from(0.0); jacobian.dim()],
            is_fresh: matches!(jacobian.structure(), Structure::Sparse(_)),
            jacobian,
            is_current: false,
            factored: None,
        }
    }

    /// Leaves the state that the Jacobian is of; its factors go on to serve if they are kept.
    pub(super) fn leave(&mut self, keeps: bool) {
        self.is_current = false;
        self.factored.take_if(|_| !keeps);
    }

    /// Sets the Jacobian to that at (t, v), which becomes the present state.
    fn set_jacobian(&mut self, field: &dyn VectorField, t: f64, v: &[f64]) {
        self.jacobian.clear();
        field.add_jacobian(t, v, 1.0, &mut self.jacobian);
        (self.is_current, self.factored) = (true, None);
    }

    /// Subtracts h J x at (t, v).
    pub(super) fn subtract_change(
        &mut self,
        field: &dyn VectorField,
        (t, v): (f64, &[f64]),
        (h, x): (f64, &[f64]),
        out: &mut [f64],
    ) {
        if !self.is_current {
            self.set_jacobian(field, t, v);
        }
        self.jacobian.mul_add(-h, x, out);
    }

    /// Writes Σ_j |J_ij| τ_j at (t, v), what changes of v within the tolerances make of each component of f.
    pub(super) fn tolerated_change(
        &mut self,
        (field, tolerances): (&dyn VectorField, &Tolerances),
        (t, v): (f64, &[f64]),
        out: &mut [f64],
    ) -> Result<(), FactorError> {
        self.set_jacobian(field, t, v);
        self.jacobian.check_structure()?;
        out.fill(0.0);
        self.jacobian.for_each(|i, j, x| out[i] += x.abs() * tolerances.of(j, v[j].abs()));
        Ok(())
    }

    /// Builds the factors for steps of size `h` with the Jacobian at (t, v), unless there are some that serve: an old
    /// Jacobian slows the iteration, and a new one is seldom dear beside its factors.
    pub(super) fn prepare<const S: usize>(
        &mut self,
        c: &Coefficients<S>,
        (field, mass): (&dyn VectorField, &Mass),
        (t, h, v): (f64, f64, &[f64]),
        work: &mut Work,
    ) -> Result<(), FactorError> {
        if self.factored.is_some_and(|(factored, s)| s == S && (factored - h).abs() <= SAME * h) {
            return Ok(());
        }
        if !self.is_current {
            self.set_jacobian(field, t, v);
        }
        work.factorizations += 1;
        self.factored = None;
        let gamma = c.gamma / h;
        self.real.assign(&self.jacobian, |x| -x)?;
        mass.shift(v.len(), gamma, &mut self.real);
        // The first sparse ones for every pair there may be: they allocate, and a rise of the order must not.
        let pairs = if self.is_fresh { self.complex.len() } else { S / 2 };
        self.is_fresh = false;
        let mut real = Some(&mut self.real);
        for (lu, pair) in self.complex.iter_mut().zip(c.pairs.iter().cycle()).take(pairs) {
            lu.assign(&self.jacobian, |x| Complex::from(-x))?;
            mass.shift(v.len(), pair / h, lu);
            let factored = match real.take() {
                Some(real) => real.decompose_both(lu),
                None => lu.decompose(),
            };
            factored.map_err(|error| self.jacobian.blame(error))?;
        }
        self.factored = Some((h, S));
        Ok(())
    }

    /// Overwrites the right-hand sides in the decoupled basis by their solutions.
    fn solve<const S: usize, const N: usize>(&mut self, w: &mut [[f64; S]], single: &mut [f64]) {
        let n = size::<N>(single.len());
        let (w, single, rhs) = (&mut w[..n], &mut single[..n], &mut self.rhs[..n]);
        single.iter_mut().zip(&*w).for_each(|(x, w)| *x = w[0]);
        for (p, lu) in self.complex.iter_mut().take(S / 2).enumerate() {
            let (re, im) = (2 * p + 1, 2 * p + 2);
            rhs.iter_mut().zip(&*w).for_each(|(x, w)| *x = Complex::new(w[re], w[im]));
            if p == 0 {
                self.real.solve_both(single, lu, rhs);
            } else {
                lu.solve(rhs);
            }
            w.iter_mut().zip(&*rhs).for_each(|(w, x)| (w[re], w[im]) = (x.re, x.im));
        }
        w.iter_mut().zip(&*single).for_each(|(w, x)| w[0] = *x);
    }
}

/// Increments of an iteration in units of what is tolerated.
struct Increments {
    /// The sum of the squares of all.
    sum: f64,
    /// That of the sizes of the components, of which roundings are a part.
    rounding: f64,
    /// Whether there is a component that has no units yet.
    has_new: bool,
}

/// Work space of a step.
#[derive(Debug)]
pub(super) struct Stages {
    /// Zᵢ = Yᵢ − v, component by component.
    pub(super) z: Vec<f64>,
    /// f(Yᵢ), then the increments.
    f: Vec<f64>,
    /// f(t, v).
    pub(super) f0: Vec<f64>,
    pub(super) stage: Vec<f64>,
    pub(super) slope: Vec<f64>,
    pub(super) single: Vec<f64>,
}

impl Stages {
    pub(super) fn new(n: usize, most: usize) -> Self {
        let zeros = || vec![0.0; n];
        let (z, f) = (vec![0.0; n * most], vec![0.0; n * most]);
        Self { z, f, f0: zeros(), stage: zeros(), slope: zeros(), single: zeros() }
    }

    /// Simplified Newton iteration for Z from the guess that it holds: increments solve
    /// (A⁻¹/h ⊗ M − I ⊗ J) ΔZ = F(Z) − (A⁻¹/h ⊗ M) Z.
    pub(super) fn iterate<const S: usize>(
        &mut self,
        c: &Coefficients<S>,
        equations: &Equations<'_, impl VectorField>,
        system: &mut StageSystem,
        (t, h, v): (f64, f64, &[f64]),
        work: &mut Work,
    ) -> Iteration {
        let Equations { field, mass, tolerances, latest, part } = *equations;
        // Where the dimension of the field is a constant, so are the lengths.
        let (n, limit) = (field.dim(), iterations(S));
        let v = &v[..n];
        // θ/(1 − θ) as soon as there are two increments. That of the last step tells nothing here: the Jacobian is older by a step.
        // One increment solves a linear f, but for what the step sizes of the factors and of the step may differ by. The check of it sees the end
        // of a step alone, where an A(t) that goes round in a step is that of its start.
        let mut contraction = if field.is_linear() && field.is_autonomous() { SAME } else { 1.0 };
        let (mut last, mut rate) = (f64::INFINITY, 0.0_f64);
        for iteration in 1..=limit {
            work.residuals += 1;
            let Self { z, f, stage, slope, .. } = self;
            let (z, f) = (&z.as_chunks::<S>().0[..n], &mut f.as_chunks_mut::<S>().0[..n]);
            let (stage, slope) = (&mut stage[..n], &mut slope[..n]);
            for i in 0..S {
                stage.iter_mut().zip(v).zip(z).for_each(|((y, v), z)| *y = v + z[i]);
                field.rhs((t + c.nodes[i] * h).min(latest), stage, slope);
                stage.iter_mut().zip(z).for_each(|(x, z)| *x = dot(&c.inverse[i], z));
                mass.mul_add(-h.recip(), stage, slope);
                f.iter_mut().zip(&*slope).for_each(|(f, slope)| f[i] = *slope);
            }
            let Increments { sum, rounding, has_new } =
                by_size!(n, N => self.add_increments::<S, N>(c, tolerances, system, v));
            let size = root_mean(sum, n * S);
            if !size.is_finite() && !self.z[..n * S].iter().all(|z| z.is_finite()) {
                return Iteration::NonFinite;
            }
            // Squares in units of a tolerance that is next to nothing may overflow.
            let size = size.min(f64::MAX);
            // Increments of a few roundings do not shrink any more.
            let goal = (GOAL * part).max(10.0 * f64::EPSILON * root_mean(rounding, n));
            let is_measured = last.is_finite();
            if is_measured {
                let ratio = size / last;
                rate = if rate == 0.0 { ratio } else { (ratio * rate).sqrt() };
                if rate >= 0.99 {
                    return Iteration::Slow { factor: 0.5 };
                }
                contraction = rate / (1.0 - rate);
                let foreseen = contraction * size * rate.powi((limit - iteration) as i32 - 1) / goal;
                if iteration < limit && foreseen >= 1.0 {
                    let exponent = f64::from(4 + limit - 1 - iteration).recip();
                    return Iteration::Slow { factor: 0.8 * foreseen.clamp(1e-4, 20.0).powf(-exponent) };
                }
            }
            // The measure of the next increments is another one where components have left zero.
            last = if has_new { f64::INFINITY } else { size.max(f64::MIN_POSITIVE) };
            if contraction * size <= goal && !has_new {
                // What is said to be linear is looked at, and iterated on where it is not, or not to these roundings.
                let is_told = is_measured || size <= goal;
                if is_told || self.left(c, equations, system, (t, h, v), work) <= goal {
                    return Iteration::Converged { rate, iterations: iteration };
                }
                contraction = 1.0;
            }
        }
        Iteration::Slow { factor: 0.5 }
    }

    /// Solves for the increments of Z with the right-hand sides in the place of F(Z), and adds them.
    fn add_increments<const S: usize, const N: usize>(
        &mut self,
        c: &Coefficients<S>,
        tolerances: &Tolerances,
        system: &mut StageSystem,
        v: &[f64],
    ) -> Increments {
        let n = size::<N>(v.len());
        let (z, f) = (&mut self.z.as_chunks_mut::<S>().0[..n], &mut self.f.as_chunks_mut::<S>().0[..n]);
        f.iter_mut().for_each(|f| *f = product(&c.t_inverse, f));
        system.solve::<S, N>(f, &mut self.single[..n]);
        let mut all = Increments { sum: 0.0, rounding: 0.0, has_new: false };
        for (k, ((z, w), v)) in z.iter_mut().zip(&*f).zip(&v[..n]).enumerate() {
            let (increment, mut size) = (product(&c.t, w), v.abs());
            let was_zero = tolerances.knows_no_size(k, size) && z[S - 1] == 0.0;
            for (z, d) in z.iter_mut().zip(&increment) {
                *z += d;
                size = size.max((v + *z).abs());
            }
            let tolerated = tolerances.of(k, size);
            if was_zero && size > 0.0 {
                // The first value of a component that starts at zero, with no atol, is all error by its own measure.
                all.has_new = true;
                continue;
            }
            let over_tolerated = tolerated.recip();
            all.sum += increment.iter().map(|d| squared(*d, over_tolerated)).sum::<f64>();
            all.rounding += squared(size, over_tolerated);
        }
        all
    }

    /// The increment that the equation of the last stage, at the end of the step, asks for by itself, in units of what is tolerated.
    fn left<const S: usize>(
        &mut self,
        c: &Coefficients<S>,
        Equations { field, mass, tolerances, latest, .. }: &Equations<'_, impl VectorField>,
        system: &mut StageSystem,
        (t, h, v): (f64, f64, &[f64]),
        work: &mut Work,
    ) -> f64 {
        work.residuals += 1;
        let Self { z, stage, slope, single, .. } = self;
        let z = z.as_chunks::<S>().0;
        stage.iter_mut().zip(v).zip(z).for_each(|((y, v), z)| *y = v + z[S - 1]);
        field.rhs((t + h).min(*latest), stage, single);
        slope.iter_mut().zip(z).for_each(|(x, z)| *x = dot(&c.inverse[S - 1], z));
        mass.mul_add(-h.recip(), slope, single);
        system.real.solve(single);
        let terms = single
            .iter()
            .zip(v)
            .zip(&*stage)
            .enumerate()
            .map(|(k, ((x, v), end))| squared(*x, tolerances.of(k, v.abs().max(end.abs())).recip()));
        root_mean(terms.sum(), v.len())
    }

    /// The embedded estimate in units of what it is held to; `is_cautious` filters it a second time where it is large.
    pub(super) fn estimate<const S: usize>(
        &mut self,
        c: &Coefficients<S>,
        Equations { field, mass, tolerances, .. }: &Equations<'_, impl VectorField>,
        system: &mut StageSystem,
        (t, h, v): (f64, f64, &[f64]),
        is_cautious: bool,
        work: &mut Work,
    ) -> f64 {
        let Self { z, f0, stage, slope, single, .. } = self;
        let z = z.as_chunks::<S>().0;
        slope.iter_mut().zip(z).for_each(|(x, z)| *x = dot(&c.estimate, z));
        single.copy_from_slice(f0);
        mass.mul_add(h.recip(), slope, single);
        system.real.solve(single);
        let norm = |x: &[f64]| {
            let terms = x.iter().zip(v).zip(z).enumerate().map(|(k, ((x, v), z))| {
                let size = v.abs().max((v + z[S - 1]).abs());
                squared(*x, tolerances.of_estimate(k, size, S).recip())
            });
            let size = root_mean(terms.sum(), v.len());
            // A NaN stays one.
            if size < 1e-10 { 1e-10 } else { size }
        };
        let first = norm(single);
        if first < 1.0 || !is_cautious {
            return first;
        }
        // The filtered estimate is right for hλ ≫ 1 too, where the first is far too large.
        stage.iter_mut().zip(v).zip(&*single).for_each(|((y, v), e)| *y = v + e);
        field.rhs(t, stage, single);
        work.residuals += 1;
        mass.mul_add(h.recip(), slope, single);
        system.real.solve(single);
        // Where f has no value there, the first stands.
        let second = norm(single);
        if second.is_nan() { first } else { second }
    }
}
