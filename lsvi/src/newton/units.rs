//! Steps in units of the equation's own.
//!
//! Increments of Newton's iteration do not depend on the units of the unknowns, but the norms do by which they are compared: in metres and
//! metres per second, of an oscillator that turns a thousand times a second, all is what the velocity does. With A(s) = ∂F/∂x(s, x₀), a step
//! that is refused is tried again in units in which the rows and columns of A(0)⁻¹A(h) are balanced ([PR69]); powers of two, so that
//! nothing is rounded.
//!
//! [PR69] B. N. Parlett and C. Reinsch, Numer. Math. 13 (1969) 293.

use nalgebra::linalg::balancing::balance_parlett_reinsch;

use super::{LimitAtZero, Newton, System, Work};
use crate::error::SolveError;
use crate::linalg::Jacobian;

/// Unknowns up to which a matrix is balanced: it takes as many divisions as their cube.
const MOST: usize = 64;
/// Entries beyond are not balanced: their squares overflow.
const LARGEST: f64 = 1e100;

/// Units of unknowns that differ by this factor are unlike.
const UNLIKE: f64 = 4.0;

/// Whether the rows and columns of a matrix J of order n ≤ [`MOST`], as of v̇ = J v, are balanced by units that are unlike.
pub(crate) fn are_unlike(j: &Jacobian) -> bool {
    let Some(mut j) = j.dense().filter(|j| j.nrows() <= MOST).cloned() else { return false };
    if !j.iter().all(|x| x.abs() <= LARGEST) {
        return false;
    }
    let units = balance_parlett_reinsch(&mut j);
    units.max() >= UNLIKE * units.min()
}

/// The iteration in its own units: x_i = `units`_i y_i.
#[derive(Debug)]
pub(super) struct Balanced {
    newton: Newton,
    units: Vec<f64>,
    /// x, and y.
    x: Vec<f64>,
    y: Vec<f64>,
    /// Whether the last step was found so.
    is_in_use: bool,
}

/// F(h, D y).
struct InUnits<'a> {
    system: &'a mut dyn System,
    units: &'a [f64],
    x: &'a mut [f64],
}

fn scale(y: &[f64], units: &[f64], x: &mut [f64]) {
    x.iter_mut().zip(y.iter().zip(units)).for_each(|(x, (y, unit))| *x = unit * y);
}

impl System for InUnits<'_> {
    fn dim(&self) -> usize {
        self.units.len()
    }

    fn residual(&mut self, h: f64, y: &[f64], out: &mut [f64]) {
        scale(y, self.units, self.x);
        self.system.residual(h, self.x, out);
    }

    fn derivative(&mut self, h: f64, y: &[f64], out: &mut Jacobian) {
        scale(y, self.units, self.x);
        self.system.derivative(h, self.x, out);
        if let Some(entries) = out.dense_mut() {
            let columns = entries.chunks_exact_mut(self.units.len()).zip(self.units);
            columns.for_each(|(column, unit)| column.iter_mut().for_each(|x| *x *= unit));
        }
    }

    fn origin(&self, y: &mut [f64]) {
        y.iter_mut().zip(self.units).for_each(|(y, unit)| *y *= unit);
        self.system.origin(y);
        y.iter_mut().zip(self.units).for_each(|(y, unit)| *y /= unit);
    }

    fn limit(&self) -> LimitAtZero {
        self.system.limit()
    }

    fn guesses_along_tangent(&self) -> bool {
        self.system.guesses_along_tangent()
    }

    fn algebraic(&self) -> &[usize] {
        self.system.algebraic()
    }

    fn is_affine(&self) -> bool {
        self.system.is_affine()
    }

    fn scale(&self, h: f64) -> f64 {
        self.system.scale(h)
    }
}

impl Newton {
    /// Whether steps are found in units of their own for the time being.
    pub(super) fn is_balanced(&self) -> bool {
        self.balanced.as_ref().is_some_and(|balanced| balanced.is_in_use)
    }

    /// Replaces `x`, a first guess, as [`solve`](Newton::solve) does, in the units of the last step that was solved so, or in new ones.
    pub(super) fn solve_balanced(
        &mut self,
        system: &mut dyn System,
        h: f64,
        x: &mut [f64],
        is_new: bool,
    ) -> Option<Result<(), SolveError>> {
        if is_new && !self.balance(system, h, x) {
            return None;
        }
        let mut balanced = self.balanced.take()?;
        let Balanced { newton, units, x: scratch, y, is_in_use } = &mut *balanced;
        y.iter_mut().zip(x.iter().zip(&*units)).for_each(|(y, (x, unit))| *y = x / unit);
        newton.work = Work::default();
        let found = newton.solve_in_these_units(&mut InUnits { system, units, x: scratch }, h, y);
        if found.is_ok() {
            scale(y, units, x);
        }
        *is_in_use = found.is_ok();
        self.work = self.work + newton.work;
        self.balanced = Some(balanced);
        Some(found)
    }

    /// Sets new units; false where they are those that the unknowns have, or none are found.
    fn balance(&mut self, system: &mut dyn System, h: f64, x: &[f64]) -> bool {
        let n = x.len();
        if n > MOST || system.limit() != LimitAtZero::Kept || !self.limit.is_regular {
            return false;
        }
        self.point.copy_from_slice(x);
        system.origin(&mut self.point);
        let origin = std::mem::take(&mut self.point);
        system.residual(h, &origin, &mut self.part);
        self.jacobian.clear();
        system.derivative(h, &origin, &mut self.jacobian);
        self.point = origin;
        self.work.residuals += 1;
        let Some(mut a) = self.jacobian.dense().cloned() else { return false };
        a.column_iter_mut().for_each(|mut column| self.limit.solve(system, h, column.as_mut_slice()));
        if !a.iter().all(|x| x.abs() <= LARGEST) {
            return false;
        }
        let units = balance_parlett_reinsch(&mut a);
        if units.iter().all(|unit| *unit == units[0]) {
            return false;
        }
        let balanced = self.balanced.get_or_insert_with(|| {
            let zeros = vec![0.0; n];
            let newton = Newton::new(n);
            Box::new(Balanced { newton, units: zeros.clone(), x: zeros.clone(), y: zeros, is_in_use: false })
        });
        if balanced.units != units.as_slice() {
            balanced.units.copy_from_slice(units.as_slice());
            balanced.newton.forget_limit();
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The zero matrix of order n but for two entries.
    fn coupled(n: usize, [above, below]: [f64; 2]) -> Jacobian {
        let mut j = Jacobian::zeros(n);
        j.add(0, 1, above);
        j.add(1, 0, below);
        j
    }

    /// The units that balance (0 a; b 0) are in the ratio √(a/b), as a power of two.
    #[test]
    fn units_are_unlike_from_a_factor_of_four_on() {
        let cases = [
            (2, [1.0, 7.0], false),
            (2, [7.0, 1.0], false),
            (2, [1.0, 16.0], true),
            (2, [16.0, 1.0], true),
            (MOST, [1.0, 16.0], true),
            (MOST + 1, [1.0, 16.0], false),
            (2, [1.0, LARGEST], true),
            (2, [1.0, 10.0 * LARGEST], false),
            (2, [1.0, f64::NAN], false),
        ];
        for (n, entries, expected) in cases {
            assert_eq!(are_unlike(&coupled(n, entries)), expected, "{n}, {entries:?}");
        }
    }

    /// (x₀², x₀x₁) = 0 from (x₀, 2x₀), of which all is said or nothing.
    struct Told(bool);

    impl System for Told {
        fn dim(&self) -> usize {
            2
        }
        fn residual(&mut self, _: f64, x: &[f64], out: &mut [f64]) {
            out.copy_from_slice(&[x[0] * x[0], x[0] * x[1]]);
        }
        fn derivative(&mut self, _: f64, x: &[f64], out: &mut Jacobian) {
            [(0, 0, 2.0 * x[0]), (1, 0, x[1]), (1, 1, x[0])].into_iter().for_each(|(i, j, x)| out.add(i, j, x));
        }
        fn origin(&self, x: &mut [f64]) {
            x[1] = 2.0 * x[0];
        }
        fn limit(&self) -> LimitAtZero {
            if self.0 { LimitAtZero::Kept } else { LimitAtZero::Unknown }
        }
        fn guesses_along_tangent(&self) -> bool {
            self.0
        }
        fn algebraic(&self) -> &[usize] {
            if self.0 { &[0, 1] } else { &[] }
        }
        fn is_affine(&self) -> bool {
            self.0
        }
        fn scale(&self, h: f64) -> f64 {
            3.0 * h
        }
    }

    #[test]
    fn an_equation_is_the_same_in_other_units() {
        for all in [true, false] {
            let (mut told, mut x) = (Told(all), [0.0; 2]);
            let mut system = InUnits { system: &mut told, units: &[2.0, 0.5], x: &mut x };
            // x = (6, 3.5).
            let (mut y, mut f, mut derivative) = ([3.0, 7.0], [0.0; 2], Jacobian::zeros(2));
            system.residual(0.1, &y, &mut f);
            system.derivative(0.1, &y, &mut derivative);
            system.origin(&mut y);
            assert_eq!((f, y), ([36.0, 21.0], [3.0, 24.0]));
            assert_eq!([(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| derivative.get(i, j)), [24.0, 0.0, 7.0, 3.0]);
            let said = (system.dim(), system.limit(), system.guesses_along_tangent(), system.is_affine());
            let same = (2, Told(all).limit(), all, all);
            assert_eq!(
                (said, system.algebraic(), system.scale(0.1)),
                (same, Told(all).algebraic(), Told(all).scale(0.1))
            );
        }
    }

    /// x₀ − s x₁ = 1, x₁ + s k x₀ = 0 and x_i = 0 for s = h⁸, which notes where it is asked for its residual.
    struct Spring {
        n: usize,
        stiffness: f64,
        limit: LimitAtZero,
        notes: Vec<Vec<f64>>,
    }

    impl Spring {
        fn new(n: usize, stiffness: f64) -> Self {
            Self { n, stiffness, limit: LimitAtZero::Kept, notes: Vec::new() }
        }

        fn balances(mut self) -> bool {
            let (mut newton, x) = (Newton::new(self.n), vec![0.0; self.n]);
            newton.set_limit(&mut self, 1.0);
            newton.balance(&mut self, 1.0, &x)
        }
    }

    impl System for Spring {
        fn dim(&self) -> usize {
            self.n
        }
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            self.notes.push(x.to_vec());
            out.copy_from_slice(x);
            out[0] -= h.powi(8) * x[1] + 1.0;
            out[1] += h.powi(8) * self.stiffness * x[0];
        }
        fn derivative(&mut self, h: f64, _: &[f64], out: &mut Jacobian) {
            (0..self.n).for_each(|i| out.add(i, i, 1.0));
            out.add(0, 1, -h.powi(8));
            out.add(1, 0, h.powi(8) * self.stiffness);
        }
        fn limit(&self) -> LimitAtZero {
            self.limit
        }
    }

    #[test]
    fn units_are_found_where_some_are_unlike_and_the_limit_is_known() {
        const STIFF: f64 = 1e6;
        for n in [2, MOST] {
            assert!(Spring::new(n, STIFF).balances() && !Spring::new(n, 1.0).balances(), "{n}");
        }
        assert!(!Spring::new(MOST + 1, STIFF).balances());
        assert!(Spring::new(2, 0.1 * LARGEST).balances() && !Spring::new(2, 10.0 * LARGEST).balances());
        assert!(!Spring { limit: LimitAtZero::OfEachStep, ..Spring::new(2, STIFF) }.balances());
        let (mut spring, mut singular) = (Spring::new(2, STIFF), Newton::new(2));
        singular.set_limit(&mut spring, 1.0);
        singular.limit.is_regular = false;
        assert!(!singular.balance(&mut spring, 1.0, &[0.0; 2]));
    }

    /// Takes a step from the guess (2, 3), to (1 + k) x₀ = 1, and tells the ratio of the units that it was found in.
    fn step(newton: &mut Newton, stiffness: f64, is_new: bool) -> f64 {
        let (mut spring, mut x, before) = (Spring::new(2, stiffness), [2.0, 3.0], newton.work);
        let found = newton.solve_balanced(&mut spring, 1.0, &mut x, is_new);
        assert!(matches!(found, Some(Ok(()))) && newton.is_balanced(), "{found:?}");
        approx::assert_relative_eq!(x[0], 1.0 / (1.0 + stiffness), max_relative = 1e-12);
        assert!(
            spring.notes.contains(&vec![2.0, 3.0]),
            "the iteration does not start from the guess: {:?}",
            spring.notes
        );
        let after = newton.work;
        assert!(after.residuals > before.residuals && after.factorizations > before.factorizations, "{after:?}");
        let units = &newton.balanced.as_ref().expect("in use").units;
        units[1] / units[0]
    }

    /// √k, as a power of two.
    #[test]
    fn units_are_those_of_the_last_step_unless_new_ones_are_asked_for() {
        let (stiff, soft, mut newton) = (f64::from(1 << 20), 256.0, Newton::new(2));
        newton.set_limit(&mut Spring::new(2, stiff), 1.0);
        assert!(
            !newton.is_balanced()
                && newton.solve_balanced(&mut Spring::new(2, stiff), 1.0, &mut [0.0; 2], false).is_none()
        );
        let steps = [(stiff, true), (soft, false), (soft, true), (stiff, true)];
        assert_eq!(
            steps.map(|(stiffness, is_new)| step(&mut newton, stiffness, is_new)),
            [1024.0, 1024.0, 16.0, 1024.0]
        );
        // What no iteration solves is not found in these units any more.
        let found = newton.solve_balanced(&mut Spring::new(2, f64::NAN), 1.0, &mut [2.0, 3.0], false);
        assert!(matches!(found, Some(Err(SolveError::NonFinite))) && !newton.is_balanced(), "{found:?}");
    }

    /// x₀ = 1/(1 + k).
    #[test]
    fn a_step_in_the_units_of_the_last_one_is_solved() {
        let (stiffness, mut newton, mut x) = (256.0, Newton::new(2), [2.0, 3.0]);
        newton.set_limit(&mut Spring::new(2, stiffness), 1.0);
        step(&mut newton, stiffness, true);
        newton.solve(&mut Spring::new(2, stiffness), 1.0, &mut x).expect("affine");
        approx::assert_relative_eq!(x[0], 1.0 / (1.0 + stiffness), max_relative = 1e-12);
    }

    #[test]
    fn a_limit_in_other_units_is_not_known() {
        let mut newton = Newton::new(2);
        newton.set_limit(&mut Spring::new(2, 256.0), 1.0);
        step(&mut newton, 256.0, true);
        let mut orientation = |stiffness: f64| {
            let before = newton.work.residuals;
            assert!(newton.balance(&mut Spring::new(2, stiffness), 1.0, &[0.0; 2]));
            assert_eq!(newton.work.residuals, before + 1);
            newton.balanced.as_ref().expect("balanced").newton.limit.orientation
        };
        assert_eq!([256.0, 1e6].map(&mut orientation), [Some(1.0), None]);
    }
}
