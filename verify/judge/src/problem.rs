//! Problems on which the order of a method from a file is measured, all with exact solutions: a linear one, and nonlinear ones
//! on which every tree shows, with and without time in it.

use lsvi::{AutoField, FieldFn, Scalar, VectorField};

use experiments::problem::{Facts, Problem, Window};
use experiments::reference::Ode;

/// Where an order is measured: up to t = 2, high ones from large steps down, because they are soon at roundoff.
pub(super) fn window(order: u32) -> Window {
    let coarsest = match order {
        0..=2 => 0.1,
        3..=4 => 0.4,
        5..=6 => 0.8,
        _ => 2.0,
    };
    Window { horizon: 2.0, coarsest }
}

/// u̇ = −δu − 3w, ẇ = 3u − δw from (1, 0): e^{−δt}(cos 3t, sin 3t).
#[derive(Debug)]
pub(super) struct Linear {
    window: Window,
    /// δ.
    damping: f64,
}

impl Linear {
    /// δ = 1.
    pub(super) fn damped(window: Window) -> Self {
        Self { window, damping: 1.0 }
    }

    /// δ = 0: what grows on solutions that decay stays bounded.
    pub(super) fn undamped(window: Window) -> Self {
        Self { window, damping: 0.0 }
    }
}

impl FieldFn for Linear {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0] * self.damping - v[1] * 3.0;
        dv[1] = v[0] * 3.0 - v[1] * self.damping;
    }
}

impl Ode for Linear {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -self.damping * v[0] - 3.0 * v[1];
        dv[1] = 3.0 * v[0] - self.damping * v[1];
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, -self.damping);
        add(0, 1, -3.0);
        add(1, 0, 3.0);
        add(1, 1, -self.damping);
    }
}

impl Problem for Linear {
    fn components(&self) -> &'static [&'static str] {
        &["u", "w"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 0.0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let decay = (-self.damping * t).exp();
        Some(vec![decay * (3.0 * t).cos(), decay * (3.0 * t).sin()])
    }
    fn facts(&self) -> Facts {
        Facts { window: self.window, ..Facts::default() }
    }
}

/// u̇ = u² w (1 + t) cos t e^{−sin t}, ẇ = −w² + ln u − sin t, from (1, 1): u = e^{sin t}, w = 1/(1 + t).
///
/// Nonlinear, coupled, and with t in it other than as a factor: wrong stage times show nowhere else.
#[derive(Debug)]
pub(super) struct NonAutonomous(pub Window);

/// The same with a third unknown s = t/T, T the time of a run, so that it does not count for more than the others where that is long:
/// every tree shows, and time is stepped with the sums of the rows.
#[derive(Debug)]
pub(super) struct Autonomous(pub Window);

/// q̇ = p³, ṗ = −(q/Q)³/(1 + t)² with Q = 3/2 − 1/(2(1 + t)²), from (1, 1): q = Q, p = 1/(1 + t). It is separable, with t in its forces.
#[derive(Debug)]
pub(super) struct Forced(pub Window);

impl Forced {
    /// What kind of problem it is, and what of.
    pub(super) const NAME: (&'static str, &'static str) = ("non-autonomous", "q̇ = f(p), ṗ = g(t, q)");

    /// Q and (1 + t)².
    fn scale(t: f64) -> [f64; 2] {
        let square = (1.0 + t).powi(2);
        [1.5 - 0.5 / square, square]
    }
}

impl FieldFn for Forced {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        let [scale, square] = Self::scale(t);
        let q = v[0] / scale;
        dv[0] = v[1] * v[1] * v[1];
        dv[1] = -(q * q * q) / square;
    }
}

impl Ode for Forced {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        let [scale, square] = Self::scale(t);
        dv[0] = v[1].powi(3);
        dv[1] = -(v[0] / scale).powi(3) / square;
    }
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let [scale, square] = Self::scale(t);
        add(0, 1, 3.0 * v[1].powi(2));
        add(1, 0, -3.0 * v[0].powi(2) / (scale.powi(3) * square));
    }
}

impl Problem for Forced {
    fn components(&self) -> &'static [&'static str] {
        &["q", "p"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 1.0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(vec![Self::scale(t)[0], (1.0 + t).recip()])
    }
    fn facts(&self) -> Facts {
        Facts { window: self.0, ..Facts::default() }
    }
}

/// (u̇, ẇ) at (t, u, w).
fn rates<T: Scalar>(t: T, u: T, w: T) -> [T; 2] {
    [u * u * w * (t + 1.0) * t.cos() * (-t.sin()).exp(), u.ln() - w * w - t.sin()]
}

/// The derivatives of (u̇, ẇ) with respect to u, w and t, by hand.
fn gradients(t: f64, u: f64, w: f64) -> [[f64; 3]; 2] {
    let (sin, cos) = t.sin_cos();
    let g = (1.0 + t) * cos * (-sin).exp();
    let in_time = (cos - (1.0 + t) * (sin + cos * cos)) * (-sin).exp();
    [[2.0 * u * w * g, u * u * g, u * u * w * in_time], [u.recip(), -2.0 * w, -cos]]
}

impl FieldFn for NonAutonomous {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        dv.copy_from_slice(&rates(T::from(t), v[0], v[1]));
    }
}

impl Ode for NonAutonomous {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = v[0].powi(2) * v[1] * (1.0 + t) * t.cos() / t.sin().exp();
        dv[1] = -v[1].powi(2) + v[0].ln() - t.sin();
    }
    fn jacobian(&self, t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        for (i, row) in gradients(t, v[0], v[1]).iter().enumerate() {
            (0..2).for_each(|j| add(i, j, row[j]));
        }
    }
}

impl FieldFn for Autonomous {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[..2].copy_from_slice(&rates(v[2] * self.0.horizon, v[0], v[1]));
        dv[2] = T::from(self.0.horizon.recip());
    }
}

impl Ode for Autonomous {
    fn dim(&self) -> usize {
        3
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        Ode::rhs(&NonAutonomous(self.0), self.0.horizon * v[2], v, &mut dv[..2]);
        dv[2] = 1.0 / self.0.horizon;
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let horizon = self.0.horizon;
        for (i, [u, w, t]) in gradients(horizon * v[2], v[0], v[1]).into_iter().enumerate() {
            [u, w, horizon * t].into_iter().enumerate().for_each(|(j, x)| add(i, j, x));
        }
    }
}

impl Problem for Autonomous {
    fn components(&self) -> &'static [&'static str] {
        &["u", "w", "s"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 1.0, 0.0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(vec![t.sin().exp(), (1.0 + t).recip(), t / self.0.horizon])
    }
    fn facts(&self) -> Facts {
        Facts { window: self.0, ..Facts::default() }
    }
}

impl Problem for NonAutonomous {
    fn components(&self) -> &'static [&'static str] {
        &["u", "w"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![1.0, 1.0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self))
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        Some(vec![t.sin().exp(), (1.0 + t).recip()])
    }
    fn facts(&self) -> Facts {
        Facts { window: self.0, ..Facts::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_statements_of_each_agree_and_the_solution_is_one() {
        let problems: [&dyn Problem; 5] = [
            &Linear::damped(window(2)),
            &Linear::undamped(window(2)),
            &Autonomous(window(2)),
            &NonAutonomous(window(2)),
            &Forced(window(2)),
        ];
        for problem in problems {
            let n = problem.initial().len();
            assert_eq!(problem.components().len(), n, "{problem:?}");
            assert_eq!((problem.field().dim(), problem.ode().dim()), (n, n), "{problem:?}");
            assert_eq!(problem.facts().window, window(2), "{problem:?}");
            assert_eq!(problem.exact(0.0), Some(problem.initial()));
            for t in [0.2, 0.7, 1.7] {
                let v = problem.exact(t).expect("known");
                let (mut field, mut ode) = (vec![0.0; n], vec![0.0; n]);
                problem.field().rhs(t, &v, &mut field);
                problem.ode().rhs(t, &v, &mut ode);
                let difference = |f: &dyn Fn(f64) -> f64| (f(1e-5) - f(-1e-5)) / 2e-5;
                for k in 0..n {
                    let rate = difference(&|d| problem.exact(t + d).expect("known")[k]);
                    // The error of the difference is 1e-10/6 times a third derivative, and roundoff over 1e-5.
                    assert!((field[k] - rate).abs() < 1e-8 && (field[k] - ode[k]).abs() < 1e-13, "{problem:?} {t}");
                }
                // Off the solution too, where factors that are 1 on it are not.
                let off: Vec<f64> = v.iter().map(|x| 1.25 * x).collect();
                let (mut field, mut ode) = (vec![0.0; n], vec![0.0; n]);
                problem.field().rhs(t, &off, &mut field);
                problem.ode().rhs(t, &off, &mut ode);
                assert!((0..n).all(|k| (field[k] - ode[k]).abs() < 1e-12), "{problem:?} {t}: {field:?} {ode:?}");
                let mut jacobian = vec![vec![0.0; n]; n];
                problem.ode().jacobian(t, &v, &mut |i, j, x| jacobian[i][j] += x);
                for i in 0..n {
                    for j in 0..n {
                        let entry = difference(&|d| {
                            let (mut at, mut dv) = (v.clone(), vec![0.0; n]);
                            at[j] += d;
                            problem.ode().rhs(t, &at, &mut dv);
                            dv[i]
                        });
                        assert!((jacobian[i][j] - entry).abs() < 1e-8, "{problem:?} {t} {i} {j}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_higher_an_order_the_larger_are_the_steps_at_which_it_is_measured() {
        for pair in [1, 3, 5, 7].map(window).windows(2) {
            assert!(pair[0].coarsest < pair[1].coarsest && pair[1].coarsest <= pair[0].horizon, "{pair:?}");
        }
        assert_eq!([2, 4, 6, 9].map(window), [1, 3, 5, 7].map(window));
    }
}
