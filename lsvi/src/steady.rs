//! Steady states by marching in time.
//!
//! A method can rest where the system does not: the fixed points of Method I satisfy (2 M − h f_vᵀ) M⁻¹ f = 0, which holds at
//! every steady state, and at others where h M⁻¹ f_v has an eigenvalue 2. A resting state is therefore judged by f.

use thiserror::Error;

use crate::error::{InputError, SettingError, StepError, check_time, check_vector};
use crate::integrator::{OneStep, State};
use crate::linalg::{Jacobian, Structure, max_norm};
use crate::mass::Mass;
use crate::vector_field::{VectorField, check_system};

/// A state with f(t, v) = 0 up to `residual`.
#[derive(Debug, Clone, PartialEq)]
pub struct Steady {
    /// The state.
    pub state: State,
    /// Max norm of f there, in its units.
    pub residual: f64,
    /// Steps taken.
    pub steps: u64,
}

/// Why no steady state was found.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SteadyError {
    /// The arguments are unusable.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A step could not be taken.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The method rests where the system does not.
    #[error("spurious steady state: the method rests at t = {t}, where |f| = {residual:e} exceeds {allowed:e}")]
    Spurious {
        /// Time at which it rests.
        t: f64,
        /// Where it rests.
        v: Vec<f64>,
        /// |f| of a component there.
        residual: f64,
        /// What was allowed for it.
        allowed: f64,
    },
    /// The state still moves after the last step.
    #[error("no steady state after {steps} steps: |f| = {residual:e}")]
    NotReached {
        /// Steps taken.
        steps: u64,
        /// Max norm of f at the last state.
        residual: f64,
    },
}

/// Refuses what cannot be a state of `field`, and what is no tolerance.
fn admit(field: &dyn VectorField, t: f64, v: &[f64], tolerance: f64) -> Result<(), InputError> {
    check_time(t)?;
    check_system(field)?;
    check_vector("v", v, field.dim())?;
    if tolerance > 0.0 && tolerance.is_finite() {
        Ok(())
    } else {
        Err(InputError::Setting(SettingError::Tolerance(tolerance)))
    }
}

/// |f(t, v)| in the max norm.
///
/// # Errors
/// [`SteadyError::Spurious`] if it exceeds `tolerance`, in the units of f, and what the rounding of v and of the terms of f
/// explains, [`SteadyError::Input`] if `t` and `v` are no state of `field`, or `tolerance` not a number above 0.
pub fn check(field: &impl VectorField, t: f64, v: &[f64], tolerance: f64) -> Result<f64, SteadyError> {
    admit(field, t, v, tolerance)?;
    Probe::new(field).check(field, t, v, tolerance)
}

/// Steps `method`, an integrator of `field`, with steps of size `h` until |f| ≤ `tolerance`, now and at later times, or the state rests: no
/// component changes by more than four roundings of the largest, nor by what f says of it.
///
/// Whether the steady state is stable is not asked: a method that damps what grows, as Method I does in long steps, may come to one that the
/// solution leaves.
///
/// # Errors
/// [`SteadyError::Spurious`] if the state rests with a larger |f|, [`SteadyError::NotReached`] after `most` steps,
/// [`SteadyError::Step`] if a step fails, and [`SteadyError::Input`] if `tolerance` is not a number above 0, or `most` 0.
pub fn march(
    mut method: impl OneStep,
    field: &impl VectorField,
    mut state: State,
    h: f64,
    tolerance: f64,
    most: u64,
) -> Result<Steady, SteadyError> {
    admit(field, state.t, &state.q, tolerance)?;
    if most == 0 {
        let (what, range) = ("the largest number of steps", "at least 1");
        return Err(InputError::Setting(SettingError::Setting { what, value: 0.0, range }).into());
    }
    let mut probe = Probe::new(field);
    let mass = field.mass();
    let mut before = state.q.clone();
    let (start, mut residual) = (state.t, f64::INFINITY);
    for steps in 1..=most {
        before.copy_from_slice(&state.q);
        method.step(state.t, h, &mut state.q, &mut state.p)?;
        state.t = start + steps as f64 * h;
        residual = probe.residual(field, state.t, &state.q);
        let change = before.iter().zip(&state.q).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        let rest = REST * f64::EPSILON * max_norm(&state.q);
        let is_small = residual <= tolerance;
        let is_steady =
            is_small && LATER.iter().all(|steps| probe.residual(field, state.t + steps * h, &state.q) <= tolerance);
        let rests = change <= rest && !is_small && !probe.moves_as_f_says(&mass, h, &before, &state.q);
        if is_steady || rests {
            // A component that moves by no more than that in a step may have an |f| of as much per h.
            probe.set_moving(&mass, REST * f64::EPSILON / h, &state.q);
            let residual = probe.check(field, state.t, &state.q, tolerance)?;
            return Ok(Steady { state, residual, steps });
        }
    }
    Err(SteadyError::NotReached { steps: most, residual })
}

/// Steps after which f is asked again: where it depends on time it may be zero for a moment.
const LATER: [f64; 3] = [0.382, 1.618, 7.236];

/// Roundings by which a state that rests may change in a step.
const REST: f64 = 4.0;

/// A component that changes by this part of h f at least is on its way, be it by less than a rounding of the largest one.
const ON_ITS_WAY: f64 = 0.125;

/// Work space for f and its rounding errors.
struct Probe {
    f: Vec<f64>,
    terms: Vec<f64>,
    /// `None` if the field is matrix-free.
    jacobian: Option<Jacobian>,
    /// What M v̇ is known to, by the changes of a state that rests.
    moving: Vec<f64>,
}

impl Probe {
    fn new(field: &dyn VectorField) -> Self {
        let (n, structure) = (field.dim(), field.structure());
        let is_assembled = structure != Structure::MatrixFree;
        let jacobian = is_assembled.then(|| Jacobian::with_structure(n, &structure));
        Self { f: vec![0.0; n], terms: vec![0.0; n], jacobian, moving: vec![0.0; n] }
    }

    /// Sets `moving` to |M| `part` |v|.
    fn set_moving(&mut self, mass: &Mass, part: f64, v: &[f64]) {
        self.moving.fill(0.0);
        mass.for_each(v.len(), |i, j, m| self.moving[i] += m.abs() * part * v[j].abs());
    }

    /// Whether the step from `before` to `v` changed M v by what the largest component of the last f says of it.
    fn moves_as_f_says(&mut self, mass: &Mass, h: f64, before: &[f64], v: &[f64]) -> bool {
        self.terms.fill(0.0);
        mass.for_each(v.len(), |i, j, m| self.terms[i] += m * (v[j] - before[j]));
        let largest = max_norm(&self.f);
        self.f.iter().zip(&self.terms).any(|(f, moved)| f.abs() == largest && moved / (h * f) >= ON_ITS_WAY)
    }

    /// Sets `terms` to Σ_j |J_ij| `size`, or to no more than that.
    fn set_terms(&mut self, field: &dyn VectorField, t: f64, v: &[f64], size: f64) {
        self.terms.fill(0.0);
        if let Some(jacobian) = &mut self.jacobian {
            jacobian.clear();
            field.add_jacobian(t, v, 1.0, jacobian);
            jacobian.for_each(|i, _, x| self.terms[i] += x.abs() * size);
            return;
        }
        // The mean square of a product with random signs is Σ_j J_ij² `size`².
        let (mut signed, mut product) = (vec![0.0; v.len()], vec![0.0; v.len()]);
        for bit in 60..64 {
            for (j, x) in signed.iter_mut().enumerate() {
                let random = (j as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                *x = if random >> bit & 1 == 0 { size } else { -size };
            }
            field.apply_jacobian(t, v, &signed, &mut product);
            self.terms.iter_mut().zip(&product).for_each(|(term, x)| *term = x.abs().max(*term));
        }
    }

    fn residual(&mut self, field: &dyn VectorField, t: f64, v: &[f64]) -> f64 {
        field.rhs(t, v, &mut self.f);
        max_norm(&self.f)
    }

    fn check(&mut self, field: &dyn VectorField, t: f64, v: &[f64], tolerance: f64) -> Result<f64, SteadyError> {
        let residual = self.residual(field, t, v);
        // A resting v is known to a few ε |v|, which f amplifies to Σ_j |J_ij| ε |v_j|, as its own terms do.
        self.set_terms(field, t, v, max_norm(v));
        let roundings = 16.0 * f64::EPSILON * max_norm(&self.terms);
        for (f, moving) in self.f.iter().zip(&self.moving) {
            let (residual, allowed) = (f.abs(), tolerance.max(roundings + moving));
            // NaN is no rest.
            if residual.is_nan() || residual > allowed {
                return Err(SteadyError::Spurious { t, v: v.to_vec(), residual, allowed });
            }
        }
        Ok(residual)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::{RungeKutta, Tableau};
    use crate::{AutoField, FieldFn, Scalar, method_i};

    /// v̇ = γ − v²: steady at √γ; Method I also rests where 2 + 2 h v = 0.
    struct QuadraticDrag {
        drive: f64,
    }

    impl FieldFn for QuadraticDrag {
        fn dim(&self) -> usize {
            1
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = -v[0] * v[0] + self.drive;
        }
    }

    #[test]
    fn what_is_no_state_or_no_tolerance_is_refused() {
        let field = crate::field!(1, |_t, v, dv| dv[0] = -v[0]);
        for (v, tolerance) in [(vec![], 1.0), (vec![1.0, 2.0], 1.0), (vec![f64::NAN], 1.0), (vec![1.0], -1.0)] {
            assert!(matches!(check(&field, 0.0, &v, tolerance), Err(SteadyError::Input(_))), "{v:?} {tolerance}");
        }
    }

    #[test]
    fn marches_to_the_steady_state() {
        let field = AutoField::new(QuadraticDrag { drive: 2.0 });
        let steady = march(method_i(&field).expect("usable"), &field, State::new(5.0, vec![1.0]), 0.3, 1e-12, 1000)
            .expect("steady");
        assert!(steady.residual <= 1e-12);
        assert_eq!(steady.state.t, 5.0 + steady.steps as f64 * 0.3);
        // |v − √2| ≈ |f|/(2√2).
        approx::assert_abs_diff_eq!(steady.state.q[0], 2.0_f64.sqrt(), epsilon = 1e-12);
        let few = march(method_i(&field).expect("usable"), &field, State::new(0.0, vec![1.0]), 0.3, 1e-12, 3);
        assert!(matches!(few, Err(SteadyError::NotReached { steps: 3, .. })), "{few:?}");
        // What decays below 10⁻⁶ rests by its own size.
        let decay = crate::field!(1, |_t, v, dv| dv[0] = -v[0]);
        let small = march(method_i(&decay).expect("usable"), &decay, State::new(0.0, vec![1e-6]), 0.5, 1e-20, 1000);
        assert!(small.as_ref().is_ok_and(|steady| steady.residual <= 1e-20), "{small:?}");
        // RK4 comes to a moment at which cos t is zero.
        let turning = crate::field!(1, |t, _v, dv| dv[0] = t.cos().into());
        let rk4 = RungeKutta::new(&turning, Tableau::rk4()).expect("usable");
        let quarter = std::f64::consts::FRAC_PI_2;
        let moment = march(rk4, &turning, State::new(0.0, vec![1.0]), quarter, 1e-9, 5);
        assert!(matches!(moment, Err(SteadyError::NotReached { steps: 5, .. })), "{moment:?}");
        let zero = march(method_i(&field).expect("usable"), &field, State::new(0.0, vec![1.0]), 0.3, 0.0, 3);
        assert!(matches!(zero, Err(SteadyError::Input(InputError::Setting(SettingError::Tolerance(_))))), "{zero:?}");
    }

    /// A state of rest that f drives from a time on, which is before and behind 0.25 + 7.236 · 0.25 = 2.06.
    #[test]
    fn a_state_is_steady_if_f_is_small_for_some_steps_to_come() {
        let steps = |from: f64| {
            let field = crate::field!(1, from = from; |t, _v, dv| dv[0] = (t - from).max(0.0).into());
            let rk4 = RungeKutta::new(&field, Tableau::rk4()).expect("usable");
            march(rk4, &field, State::new(0.0, vec![1.0]), 0.25, 1e-9, 40).map(|steady| steady.steps).ok()
        };
        assert_eq!([2.05, 2.07].map(steps), [None, Some(1)]);
    }

    #[test]
    fn a_march_that_leads_away_tells_the_rate_where_it_ended() {
        let field = crate::field!(1, |_t, v, dv| dv[0] = v[0]);
        let method = || method_i(&field).expect("usable");
        let mut state = State::new(0.0, vec![1.0]);
        (0..3).for_each(|k| method().step(0.1 * f64::from(k), 0.1, &mut state.q, &mut state.p).expect("solvable"));
        let away = march(method(), &field, State::new(0.0, vec![1.0]), 0.1, 1e-12, 3);
        let Err(SteadyError::NotReached { steps: 3, residual }) = away else { panic!("{away:?}") };
        approx::assert_relative_eq!(residual, state.q[0], max_relative = 1e-12);
    }

    /// M v̇ is known to no more than the entries of M times what the rate is.
    #[test]
    fn what_a_moving_state_leaves_open_goes_by_the_mass() {
        let field = crate::field!(2, |_t, v, dv| (dv[0], dv[1]) = (-v[0], -v[1]));
        let mut probe = Probe::new(&field);
        for (mass, known) in [(Mass::Identity, [0.1, 0.2]), (Mass::Diagonal(vec![3.0, -20.0]), [0.3, 4.0])] {
            probe.set_moving(&mass, 0.1, &[1.0, -2.0]);
            approx::assert_relative_eq!(probe.moving[..], known[..], max_relative = 1e-15);
        }
        let mut exchanged = Jacobian::with_structure(2, &Structure::Dense);
        exchanged.add(0, 1, 2.0);
        exchanged.add(1, 0, -1.0);
        probe.set_moving(&Mass::Matrix(exchanged), 0.1, &[1.0, -2.0]);
        approx::assert_relative_eq!(probe.moving[..], [0.4, 0.1], max_relative = 1e-15);
    }

    /// v₁ → 1 beside a component of 10⁵, of which 4 roundings are more than a step of v₁ from |f| = 9·10⁻⁸ on.
    #[test]
    fn a_small_component_rests_by_its_own_size() {
        let field = crate::field!(2, |_t, v, dv| (dv[0], dv[1]) = (v[0] * 0.0, -v[1] + 1.0));
        let start = || State::new(0.0, vec![1.013_25e5, 0.0]);
        let by_rk4 = RungeKutta::new(&field, Tableau::rk4()).expect("usable");
        let by_rk4 = march(by_rk4, &field, start(), 1e-3, 1e-12, 100_000);
        let by_method_i = march(method_i(&field).expect("usable"), &field, start(), 1e-3, 1e-12, 100_000);
        for steady in [by_rk4, by_method_i] {
            let steady = steady.expect("steady");
            // What the terms of f round to with the largest component: 16 ε 10⁵.
            assert!(steady.residual <= 16.0 * f64::EPSILON * 1.013_25e5, "{steady:?}");
        }
    }

    #[test]
    fn accepts_what_the_rounding_of_a_state_leaves_of_its_rate() {
        // The Brusselator: the terms 3 and 5/2 of f cancel in f_v. With h = 1e-4 changes by less than a rounding of v are lost.
        let field = crate::field!(2, |_t, v, dv| {
            dv[0] = v[0] * v[0] * v[1] + 1.0 - v[0] * 2.5;
            dv[1] = v[0] * 1.5 - v[0] * v[0] * v[1];
        });
        for (h, start) in [(0.1, [0.5, 2.0]), (1e-4, [1.0 + 1e-12, 1.5])] {
            for tolerance in [1e-14, 1e-15] {
                let method = method_i(&field).expect("usable");
                let steady =
                    march(method, &field, State::new(0.0, start.to_vec()), h, tolerance, 5000).expect("steady");
                // |f| ≤ 4 ε |v|/h, and f_v⁻¹ has a norm of 4.
                let away = (steady.state.q[0] - 1.0).abs().max((steady.state.q[1] - 1.5).abs());
                assert!(away <= 4.0 * (4.0 + 1.0) * f64::EPSILON * 1.5 / h, "{h} {tolerance}: {away:e}");
            }
        }
    }

    #[test]
    fn accepts_what_rounding_leaves_of_f() {
        let field = AutoField::new(QuadraticDrag { drive: 2.0 });
        march(method_i(&field).expect("usable"), &field, State::new(0.0, vec![1.0]), 0.3, 1e-300, 1000)
            .expect("steady to rounding");
    }

    /// v̇ = A v − A e with a stiff A whose entries off the diagonal are the large ones, by products alone.
    struct Coupled;

    impl VectorField for Coupled {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            Structure::MatrixFree
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            let x: Vec<f64> = v.iter().map(|v| v - 1.0 / 3.0).collect();
            self.apply_jacobian(t, v, &x, dv);
        }
        fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
            crate::add_columns(self, t, v, scale, out);
        }
        fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
        fn apply_jacobian(&self, _t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
            (out[0], out[1]) = (-x[0] + 1e8 * x[1], -1e8 * x[0] - x[1]);
        }
    }

    #[test]
    fn rounding_is_known_of_a_field_without_a_matrix() {
        // One rounding of v off the steady state makes f 1e8 ε/4, where the diagonal of J would allow 16 ε/3.
        let v = [1.0 / 3.0 + f64::EPSILON / 4.0, 1.0 / 3.0];
        let residual = check(&Coupled, 0.0, &v, 1e-14).expect("steady to rounding");
        assert!(residual > 1e-9, "{residual}");
        let off = check(&Coupled, 0.0, &[1.0 / 3.0 + 1e-12, 1.0 / 3.0], 1e-14);
        assert!(matches!(off, Err(SteadyError::Spurious { .. })), "{off:?}");
    }

    #[test]
    fn refuses_the_spurious_steady_state() {
        let field = AutoField::new(QuadraticDrag { drive: 0.0 });
        let h = 0.5;
        let result = march(method_i(&field).expect("usable"), &field, State::new(0.0, vec![-1.9]), h, 1e-10, 1000);
        let Err(SteadyError::Spurious { v, residual, .. }) = result else { panic!("{result:?}") };
        approx::assert_abs_diff_eq!(v[0], -1.0 / h, epsilon = 1e-14);
        approx::assert_abs_diff_eq!(residual, 1.0 / (h * h), epsilon = 1e-13);
    }

    /// v̇ = e^(−t) − v, v = (1 + t) e^(−t): f is −t e^(−t), and goes to zero with t alone.
    #[test]
    fn time_goes_on_while_a_state_comes_to_rest() {
        let field = crate::field!(1, |t, v, dv| dv[0] = -v[0] + (-t).exp());
        let h = 0.25;
        let steady = march(method_i(&field).expect("usable"), &field, State::new(0.0, vec![1.0]), h, 1e-6, 1000)
            .expect("steady");
        // t e^(−t) = 1e-6 at t = 16.6.
        assert!((60..=75).contains(&steady.steps), "{} steps", steady.steps);
        assert_eq!(steady.state.t, steady.steps as f64 * h);
    }

    #[test]
    fn no_more_than_rounding_is_allowed_of_f() {
        let field = crate::field!(1, |_t, v, dv| dv[0] = -v[0] + 1.0);
        // f = −k ε at v = 1 + k ε, where 16 ε |J| |v| is rounding.
        for (k, is_steady) in [(12.0, true), (40.0, false)] {
            let found = check(&field, 0.0, &[1.0 + k * f64::EPSILON], 1e-300);
            assert_eq!(found.is_ok(), is_steady, "{k}: {found:?}");
        }
    }
}
