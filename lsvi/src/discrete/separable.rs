//! What steps of a separable Lagrangian, L = ½ vᵀMv − V(t, q), share.

use crate::error::SolveError;
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Jacobian, vectors};
use crate::mass::{Mass, MassInverse};

/// Largest relative difference of two mass matrices that passes for rounding.
const CONSTANT: f64 = 1e-10;
/// Roundings by which two times that are one may differ.
const ROUNDINGS: f64 = 4.0;
/// Steps between two looks at what is declared, at most.
const RARELY: u32 = 256;

const VV: HessianWeights = HessianWeights { qq: 0.0, qv: 0.0, vq: 0.0, vv: 1.0 };
const QV: HessianWeights = HessianWeights { qq: 0.0, qv: 1.0, vq: 0.0, vv: 0.0 };

/// The inverse of M, once it is known, and what the Lagrangian declares: checked in the first step, and looked at again after 2, 4, 8, … more and
/// then after every 256.
#[derive(Debug)]
pub(super) struct ConstantMass {
    mass: Jacobian,
    other: Jacobian,
    inverse: Option<MassInverse>,
    /// Steps until the next look, and how many there were before the last one.
    left: u32,
    interval: u32,
    /// A velocity, another one or a position, and the derivatives of L in q and v.
    scratch: Vec<f64>,
}

impl ConstantMass {
    pub(super) fn new(l: &dyn Lagrangian) -> Self {
        let mass = Jacobian::with_structure(l.dim(), &l.structure());
        Self { other: mass.clone(), mass, inverse: None, left: 0, interval: 1, scratch: vec![0.0; 6 * l.dim()] }
    }

    /// M⁻¹; what is found at the first call, with the state of a first step of length `h` from `t`, serves for all. To be called once a step.
    #[inline]
    pub(super) fn inverse(
        &mut self,
        l: &dyn Lagrangian,
        (t, h): (f64, f64),
        q: &[f64],
        p: &[f64],
    ) -> Result<&mut MassInverse, SolveError> {
        if self.left == 0 {
            self.look(l, (t, h), q, p)?;
        }
        self.left -= 1;
        self.known_inverse().ok_or(SolveError::SingularMass)
    }

    /// Finds M⁻¹ where it is not known yet, and refuses a Lagrangian that is not what it declares.
    #[cold]
    #[inline(never)]
    fn look(&mut self, l: &dyn Lagrangian, (t, h): (f64, f64), q: &[f64], p: &[f64]) -> Result<(), SolveError> {
        if self.inverse.is_none() {
            self.inverse = Some(self.found_inverse(l, t, q)?);
            self.check(l, (t, h), q, p).inspect_err(|_| self.inverse = None)?;
        } else if !self.seems_separable(l, t, q, p) {
            self.check(l, (t, h), q, p)?;
        }
        self.interval = (2 * self.interval).min(RARELY);
        self.left = self.interval;
        Ok(())
    }

    /// M⁻¹ as found by [`inverse`](Self::inverse).
    #[inline]
    pub(super) fn known_inverse(&mut self) -> Option<&mut MassInverse> {
        self.inverse.as_mut()
    }

    /// The norm of column sums of M⁻¹L_qq at q, NaN where M is not known yet.
    pub(super) fn stiffness(&mut self, l: &dyn Lagrangian, t: f64, q: &[f64], column: &mut [f64]) -> f64 {
        let Some(inverse) = &mut self.inverse else { return f64::NAN };
        self.other.clear();
        l.add_hessian(t, q, column, HessianWeights { qq: 1.0, ..Default::default() }, &mut self.other);
        let mut norm = 0.0_f64;
        for j in 0..q.len() {
            column.iter_mut().enumerate().for_each(|(i, x)| *x = self.other.get(i, j));
            inverse.solve(column);
            let sum: f64 = column.iter().map(|x| x.abs()).sum();
            norm = if sum <= norm { norm } else { sum };
        }
        norm
    }

    fn found_inverse(&mut self, l: &dyn Lagrangian, t: f64, q: &[f64]) -> Result<MassInverse, SolveError> {
        let [at_rest, ..]: [&mut [f64]; 6] = vectors(&mut self.scratch, q.len());
        at_rest.fill(0.0);
        self.mass.clear();
        l.add_hessian(t, q, at_rest, VV, &mut self.mass);
        check_finite(&self.mass)?;
        MassInverse::new(&mass(&self.mass)).map_err(|_| SolveError::SingularMass)
    }

    /// Writes v = M⁻¹p, and another velocity: at rest terms of higher order in v do not show.
    fn velocities(&self, p: &[f64], v: &mut [f64], beside: &mut [f64]) {
        v.copy_from_slice(p);
        self.inverse.iter().for_each(|inverse| inverse.solve(v));
        for (i, (beside, v)) in beside.iter_mut().zip(&*v).enumerate() {
            *beside = v + (1.0 + v.abs()) * (1.0 + i as f64).cos();
        }
    }

    /// Whether ∂L/∂v is M v at two velocities and ∂L/∂q the same at both. This costs two gradients, where second derivatives may cost many times a
    /// step; where it does not seem so, these decide.
    fn seems_separable(&mut self, l: &dyn Lagrangian, t: f64, q: &[f64], p: &[f64]) -> bool {
        let mut scratch = std::mem::take(&mut self.scratch);
        let [v, beside, in_q, again_in_q, in_v, terms] = vectors(&mut scratch, q.len());
        self.velocities(p, v, beside);
        let mut is_momentum = |v: &[f64], in_q: &mut [f64]| self.beyond_mass(l, (t, q, v), in_q, in_v, terms).is_none();
        let seems_so = is_momentum(v, in_q) && is_momentum(beside, again_in_q) && in_q == again_in_q;
        self.scratch = scratch;
        seems_so
    }

    /// The first component of ∂L/∂v that is not that of M v, with the difference of the two. Leaves ∂L/∂q in `in_q`.
    fn beyond_mass(
        &self,
        l: &dyn Lagrangian,
        (t, q, v): (f64, &[f64], &[f64]),
        in_q: &mut [f64],
        in_v: &mut [f64],
        terms: &mut [f64],
    ) -> Option<(usize, f64)> {
        l.gradient(t, q, v, in_q, in_v);
        // What is left of ∂L/∂v without M v, beside the terms of both.
        terms.iter_mut().zip(&*in_v).for_each(|(terms, x)| *terms = CONSTANT * x.abs());
        self.mass.for_each(|i, j, m| {
            in_v[i] -= m * v[j];
            terms[i] += CONSTANT * (m * v[j]).abs();
        });
        // A NaN is off.
        let is_held = |(left, terms): (&f64, &f64)| left.abs() <= *terms;
        let row = in_v.iter().zip(&*terms).position(|row| !is_held(row))?;
        Some((row, in_v[row]))
    }

    /// Refuses a Lagrangian with other second derivatives in v at either end of the straight step or at another velocity, with
    /// mixed ones, or with a term that is linear in v, of which they know nothing.
    fn check(&mut self, l: &dyn Lagrangian, (t, h): (f64, f64), q: &[f64], p: &[f64]) -> Result<(), SolveError> {
        let mut scratch = std::mem::take(&mut self.scratch);
        let [v, beside, end, in_q, in_v, terms] = vectors(&mut scratch, q.len());
        self.velocities(p, v, beside);
        end.iter_mut().zip(q).zip(&*v).for_each(|((end, q), v)| *end = q + h * v);
        let mut largest = 0.0_f64;
        self.mass.for_each(|_, _, m| largest = largest.max(m.abs()));
        let places = [(t, q, &*v), (t + h, &*end, &*v), (t, q, &*beside)];
        let mut checked = places
            .into_iter()
            .try_for_each(|place| [VV, QV].into_iter().try_for_each(|which| self.check_at(l, place, which, largest)));
        for v in [v, beside] {
            checked = checked.and_then(|()| match self.beyond_mass(l, (t, q, v), in_q, in_v, terms) {
                Some((row, difference)) => Err(SolveError::LinearInVelocity { row, difference }),
                None => Ok(()),
            });
        }
        self.scratch = scratch;
        checked
    }

    /// Compares second derivatives at a place with M, whose largest entry is given, or with none.
    fn check_at(
        &mut self,
        l: &dyn Lagrangian,
        (t, q, v): (f64, &[f64], &[f64]),
        which: HessianWeights,
        largest: f64,
    ) -> Result<(), SolveError> {
        self.other.clear();
        l.add_hessian(t, q, v, which, &mut self.other);
        check_finite(&self.other)?;
        let (mass, mut different) = (&self.mass, None);
        self.other.for_each(|i, j, x| {
            let expected = if which == VV { mass.get(i, j) } else { 0.0 };
            let allowed = if which == VV { CONSTANT * largest } else { 0.0 };
            let is_same = (x - expected).abs() <= allowed;
            if !is_same {
                different = Some((i, j));
            }
        });
        different.map_or(Ok(()), |(row, column)| Err(SolveError::NotSeparable { row, column }))
    }
}

fn check_finite(hessian: &Jacobian) -> Result<(), SolveError> {
    hessian.non_finite().map_or(Ok(()), |(row, column)| Err(SolveError::NonFiniteDerivative { row, column }))
}

/// The mass in its simplest form.
fn mass(m: &Jacobian) -> Mass {
    let (mut is_diagonal, mut is_identity) = (true, true);
    m.for_each(|i, j, x| {
        is_diagonal &= i == j || x == 0.0;
        is_identity &= x == if i == j { 1.0 } else { 0.0 };
    });
    match (is_identity, is_diagonal) {
        (true, _) => Mass::Identity,
        (_, true) => Mass::Diagonal((0..m.dim()).map(|i| m.get(i, i)).collect()),
        _ => Mass::Matrix(m.clone()),
    }
}

/// The end of the last step, and what the additions that led to it have lost, so that small changes add up without it
/// ([HLW06] VIII.5, compensated summation).
#[derive(Debug)]
pub(super) struct Sum {
    t: f64,
    /// q and p there, and what they have lost.
    state: Vec<f64>,
}

impl Sum {
    pub(super) fn new(dim: usize) -> Self {
        Self { t: f64::NAN, state: vec![0.0; 4 * dim] }
    }

    /// Whether a step goes on from the end of the last one; otherwise nothing is lost yet.
    #[inline(always)]
    pub(super) fn continues(&mut self, t: f64, q: &[f64], p: &[f64]) -> bool {
        let [last_q, last_p] = vectors(&mut self.state, q.len());
        // A caller's k h and the sum t + h differ by their rounding.
        let is_now = (self.t - t).abs() <= ROUNDINGS * f64::EPSILON * t.abs();
        let is_same = is_now && last_q == q && last_p == p;
        if !is_same {
            self.forget();
        }
        is_same
    }

    #[cold]
    pub(super) fn forget(&mut self) {
        self.t = f64::NAN;
        self.state.fill(0.0);
    }

    /// Adds the changes of a step that ends at `t` to the position and to the momentum.
    #[inline(always)]
    pub(super) fn add(&mut self, t: f64, (q, in_q): (&mut [f64], &[f64]), (p, in_p): (&mut [f64], &[f64])) {
        self.t = t;
        let [last_q, last_p, lost_q, lost_p] = vectors(&mut self.state, q.len());
        add(q, in_q, lost_q, last_q);
        add(p, in_p, lost_p, last_p);
    }
}

/// Adds `change` and what was lost before to `x`, and keeps the sum and what this addition loses.
#[inline(always)]
fn add(x: &mut [f64], change: &[f64], lost: &mut [f64], kept: &mut [f64]) {
    for (((x, change), lost), kept) in x.iter_mut().zip(change).zip(lost).zip(kept) {
        let change = change + *lost;
        let sum = *x + change;
        let added = sum - *x;
        *lost = (*x - (sum - added)) + (change - added);
        (*x, *kept) = (sum, sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AutoLagrangian, LagrangianFn, Scalar};
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    /// Springs of stiffness 1, 100 and 4 on masses 1, 1 and 2, and others that push the second against both.
    struct Springs;

    impl LagrangianFn for Springs {
        fn dim(&self) -> usize {
            3
        }
        fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
            (v[0] * v[0] + v[1] * v[1]) * 0.5 + v[2] * v[2] - q[0] * q[0] * 0.5 - q[1] * q[1] * 50.0 - q[2] * q[2] * 2.0
                + (q[0] + q[2]) * q[1] * 30.0
        }
    }

    #[test]
    fn a_sum_goes_on_from_its_own_end_alone() {
        let mut sum = Sum::new(1);
        for other in [None, Some((0.1, [1.0], [3.0])), Some((0.1, [2.0], [2.0])), Some((0.2, [1.0], [2.0]))] {
            sum.add(0.1, (&mut [0.5], &[0.5]), (&mut [1.5], &[0.5]));
            let (t, q, p) = other.unwrap_or((0.1, [1.0], [2.0]));
            assert_eq!(sum.continues(t, &q, &p), other.is_none(), "{other:?}");
        }
    }

    /// 1000 v²/2, but for what it has more of: at a look's first velocity and at its second one in ∂L/∂v, at the second in ∂L/∂q, and in its second
    /// derivatives at a place.
    #[derive(Default)]
    struct Nearly {
        in_v: [f64; 2],
        in_q: f64,
        in_vv: f64,
        looks: AtomicUsize,
        places: Mutex<Vec<[f64; 3]>>,
    }

    const HEAVY: f64 = 1000.0;

    impl Lagrangian for Nearly {
        fn dim(&self) -> usize {
            1
        }
        fn value(&self, _t: f64, _q: &[f64], v: &[f64]) -> f64 {
            0.5 * HEAVY * v[0] * v[0]
        }
        fn gradient(&self, _t: f64, _q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
            let look = self.looks.fetch_add(1, Relaxed);
            dl_dq[0] = if look == 1 { self.in_q } else { 0.0 };
            dl_dv[0] = HEAVY * v[0] + self.in_v[look] * HEAVY * v[0].abs();
        }
        fn add_hessian(&self, t: f64, q: &[f64], v: &[f64], c: HessianWeights, out: &mut Jacobian) {
            self.places.lock().expect("one thread").push([t, q[0], v[0]]);
            out.add(0, 0, c.vv * HEAVY * (1.0 + self.in_vv));
        }
    }

    /// At q = 3 and the time 0.25, with a velocity of ½.
    fn found() -> ConstantMass {
        let l = Nearly::default();
        let mut mass = ConstantMass::new(&l);
        mass.inverse(&l, (0.25, 0.125), &[3.0], &[0.5 * HEAVY]).expect("separable");
        mass
    }

    /// To ten digits of ∂L/∂v and of M v, each.
    #[test]
    fn a_lagrangian_seems_separable_where_both_velocities_say_so() {
        let cases = [
            (Nearly::default(), true),
            (Nearly { in_v: [1.9e-10, 0.0], ..Default::default() }, true),
            (Nearly { in_v: [2.1e-10, 0.0], ..Default::default() }, false),
            (Nearly { in_v: [0.0, 1.9e-10], ..Default::default() }, true),
            (Nearly { in_v: [0.0, -2.1e-10], ..Default::default() }, false),
            (Nearly { in_q: 1e-300, ..Default::default() }, false),
        ];
        for (l, expected) in cases {
            let (in_v, in_q) = (l.in_v, l.in_q);
            assert_eq!(found().seems_separable(&l, 0.25, &[3.0], &[0.5 * HEAVY]), expected, "{in_v:?} {in_q}");
        }
    }

    /// To ten digits of the largest entry of M.
    #[test]
    fn second_derivatives_are_compared_at_both_ends_of_a_step_and_at_another_velocity() {
        for (in_vv, expected) in [(0.0, true), (0.9e-10, true), (1.1e-10, false)] {
            let l = Nearly { in_vv, ..Default::default() };
            assert_eq!(found().check(&l, (0.25, 0.125), &[3.0], &[0.5 * HEAVY]).is_ok(), expected, "{in_vv}");
            let places = l.places.into_inner().expect("one thread");
            assert!(places.starts_with(&[[0.25, 3.0, 0.5]]), "{places:?}");
            if expected {
                assert_eq!(places[2..4], [[0.375, 3.0625, 0.5]; 2]);
                assert!(places[4..] == [places[4]; 2] && places[4][..2] == [0.25, 3.0], "{places:?}");
                assert!((places[4][2] - 0.5).abs() > 0.1, "{places:?}");
            }
        }
    }

    /// By at least half of one and of itself.
    #[test]
    fn another_velocity_is_one_whatever_the_velocity() {
        for velocity in [0.0, 0.5, 1.0, -1.0, -2.0, 1e6] {
            let (mut v, mut beside) = ([0.0], [0.0]);
            found().velocities(&[velocity * HEAVY], &mut v, &mut beside);
            assert_eq!(v, [velocity]);
            assert!((beside[0] - velocity).abs() >= 0.5 * (1.0 + velocity.abs()), "{velocity}: {beside:?}");
        }
    }

    #[test]
    fn the_stiffness_is_that_of_the_stiffest_column() {
        let l = AutoLagrangian::new(Springs);
        let mut mass = ConstantMass::new(&l);
        let (q, mut column) = ([0.1, 0.2, 0.3], [0.0; 3]);
        assert!(mass.stiffness(&l, 0.0, &q, &mut column).is_nan());
        mass.inverse(&l, (0.0, 0.1), &q, &[0.0; 3]).expect("separable");
        // 30/1 + 100/1 + 30/2.
        approx::assert_relative_eq!(mass.stiffness(&l, 0.0, &q, &mut column), 145.0, max_relative = 1e-14);
    }
}
