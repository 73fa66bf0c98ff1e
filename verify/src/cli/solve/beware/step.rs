//! Steps that go astray, by the linearised equation or by a reference.

use nalgebra::{DMatrix, DVector};
use verify::experiment::{growth, step_error};
use verify::measure::stability::{eigenvalues, spectral_abscissa};
use verify::method::Method;
use verify::problem::{Problem, component_names};
use verify::reference::Ode;

use super::past::{Past, Place};
use super::{BEYOND, LEAVES, LOST, OFF, REST};
use crate::cli::layout::{number, plain};
use crate::cli::solve::equation::{COURSE, jacobian, solution};
use crate::cli::solve::units::unlike;

/// A step that moves a component by less than this part of what solutions do lags behind them.
const LAGS: f64 = 0.01;

/// The smallest tolerance of a reference that rounding leaves room for.
const FINEST: f64 = 1e-13;

/// A perturbation of which no more than this part is left after a step is damped, if not as fast as it might be.
const DAMPED: f64 = 0.9;

impl Past {
    /// Two steps, the last ones, that hardly move a component where solutions do, as near a state of rest of the method alone.
    pub(super) fn lags(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let (ode, n) = (problem.ode(), self.first.len());
        let rows = [&self.earlier, &self.before, &self.last];
        if rows.iter().any(|(_, v)| v.len() != n) {
            return None;
        }
        let moves = rows.array_windows().map(|[(start, from), (end, to)]: &[&Place; 2]| {
            let states = solution(ode, (*start, from), &[*end], COURSE)?;
            let difference = |to: &[f64]| to.iter().zip(from).map(|(b, a)| b - a).collect::<Vec<_>>();
            Some([difference(to), difference(states.first()?)])
        });
        let [first, last]: [[Vec<f64>; 2]; 2] = moves.collect::<Option<Vec<_>>>()?.try_into().ok()?;
        let is_behind = |[run, exact]: &[Vec<f64>; 2], k: usize| {
            exact[k].abs() > (LOST * self.sizes[k]).max(COURSE / LOST) && run[k].abs() < LAGS * exact[k].abs()
        };
        let k = (0..n).find(|k| is_behind(&first, *k) && is_behind(&last, *k))?;
        let (t, v) = &self.before;
        let remedy = unlike(problem, method, (*t, v), self.last.0 - t, k);
        Some(format!(
            "the last step, from t = {}, moves {} by {}, and the solution from there by {}: the method hardly moves it, and the equation does; {}",
            plain(self.before.0),
            component_names(problem)[k],
            number(last[0][k]),
            number(last[1][k]),
            remedy.unwrap_or_else(|| "a smaller `--h`, or another method, tells".into())
        ))
    }

    /// A method that amplifies what the equation damps, as it does at the end of the run.
    pub(in crate::cli::solve) fn amplified(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        if !self.has_steps_of(problem.ode()) || !self.is_small() {
            return None;
        }
        let [(start, _), (t, v)] = self.last_step();
        let h = t - start;
        let a = jacobian(problem, *t, v);
        let is_stable = spectral_abscissa(&a) < -REST * a.amax();
        let factor = is_stable.then(|| growth(method, &(h * &a))).flatten()?;
        // The same with perturbations that do not feed one another.
        let apart = growth(method, &(h * normal_with_eigenvalues_of(&a)))?;
        // What is damped fast in any case is no news.
        let hardly_damps = factor > DAMPED && factor.ln() > 0.5 * apart.ln();
        let grows = factor > 1.0 + REST;
        (grows || hardly_damps).then(|| {
            format!(
                "at the end every mode of the equation decays, and steps of h = {} multiply a perturbation by {} each in the long run, where its \
                 eigenvalues alone would make that {}: errors {} in the long run, and the estimate may not know; another method, or a smaller h, \
                 tells",
                plain(h),
                number(factor),
                number(apart),
                if grows { "grow" } else { "decay no faster" }
            )
        })
    }

    /// A first or a last step of which the linearised equation tells that it is off by far more than the estimate: runs with h and h/2
    /// keep what the equation damps, or damp what it keeps, alike.
    pub(in crate::cli::solve) fn off(
        &self,
        problem: &dyn Problem,
        method: &dyn Method,
        h: f64,
        estimate: f64,
    ) -> Option<String> {
        let (ode, n) = (problem.ode(), self.first.len());
        if !self.has_steps_of(ode) || !self.is_small() {
            return None;
        }
        let start = (0.0, self.first.clone());
        let steps = [[&start, self.second.as_ref()?], [&self.before, &self.last]];
        [(0.0, &self.first, steps[0]), (self.last.0, &self.last.1, steps[1])].into_iter().find_map(|(t, v, step)| {
            let a = h * jacobian(problem, t, v);
            let mut f = DVector::zeros(n);
            ode.rhs(t, v, f.as_mut_slice());
            // How far growth goes is not for the linearised equation to say.
            let is_usable = a.iter().chain(&f).all(|x| x.is_finite()) && spectral_abscissa(&a) <= LEAVES;
            let error = is_usable.then(|| step_error(method, &a, &(h * f))).flatten()?;
            let far = |k: usize| (OFF * self.sizes[k]).max(BEYOND * estimate);
            let is_off = |k: &usize| error[*k].abs() > far(*k) && is_step_off(ode, step, (*k, far(*k)));
            let k = (0..n).filter(is_off).max_by(|i, j| error[*i].abs().total_cmp(&error[*j].abs()))?;
            Some(format!(
                "of the equation linearised at t = {} a step of h = {} is off by {} in {}, of which the largest value is {}: it \
                 damps what the equation keeps, or keeps what it damps, with half of h as well, and the estimate does not know; \
                 another method, or a step below {}, tells",
                plain(t),
                plain(h),
                number(error[k].abs()),
                component_names(problem)[k],
                number(self.sizes[k]),
                number(h / a.norm())
            ))
        })
    }
}

/// A normal matrix with the eigenvalues of `a`: blocks of order 1 and 2 on the diagonal.
fn normal_with_eigenvalues_of(a: &DMatrix<f64>) -> DMatrix<f64> {
    let mut normal = DMatrix::zeros(a.nrows(), a.nrows());
    let mut places = 0..a.nrows();
    for value in eigenvalues(a).into_iter().filter(|value| value.im >= 0.0) {
        let Some(i) = places.next() else { break };
        normal[(i, i)] = value.re;
        let Some(j) = (value.im > 0.0).then(|| places.next()).flatten() else { continue };
        normal[(j, j)] = value.re;
        (normal[(i, j)], normal[(j, i)]) = (-value.im, value.im);
    }
    normal
}

/// Whether a step of a run leads to a component `k` that is off by more than `far`, as a reference tells that gets so far.
fn is_step_off(ode: &dyn Ode, [start, end]: [&Place; 2], (k, far): (usize, f64)) -> bool {
    let tolerance = (0.01 * far).clamp(FINEST, COURSE);
    let states = solution(ode, (start.0, &start.1), &[end.0], tolerance);
    states.is_none_or(|states| states.iter().any(|state| (state[k] - end.1[k]).abs() > far))
}

#[cfg(test)]
mod tests {
    use super::super::Row;
    use super::*;
    use crate::cli::solve::equation::{by, growing, model};
    use verify::measure::norm::distance;
    use verify::problem;

    fn scalar(rows: &[(f64, f64)]) -> Past {
        let rows: Vec<_> = rows.iter().map(|(t, x)| (*t, [*x])).collect();
        Past::of(&rows, None)
    }

    /// A solution of 10⁻¹⁰ is followed by a reference that resolves it.
    #[test]
    fn a_step_in_small_units_is_off_by_what_is_large_there() {
        let oscillator = problem::build("harmonic-oscillator", &[]).expect("registered");
        let is_off = |off: f64| {
            let end = (6.0, vec![1e-10 * (6.0_f64.cos() + off), -1e-10 * 6.0_f64.sin()]);
            is_step_off(oscillator.ode(), [&(0.0, vec![1e-10, 0.0]), &end], (0, 1e-11))
        };
        assert_eq!([0.0, 0.2].map(is_off), [false, true]);
    }

    /// Of v̇ = −v a step of 1 takes 0.63.
    #[test]
    fn a_run_lags_that_moves_a_hundredth_of_the_way_or_less() {
        let lags = |part: f64, size: f64| {
            let after = |v: f64| v * (1.0 - part * (1.0 - (-1.0_f64).exp()));
            let rows = [size, after(size), after(after(size))];
            let past = scalar(&[(0.0, rows[0]), (1.0, rows[1]), (2.0, rows[2])]);
            past.lags(&*growing(-1.0), &*by("implicit-euler")).is_some()
        };
        assert_eq!([0.9, 1.1].map(|part| lags(part * LAGS, 1.0)), [true, false]);
        // One step alone may be the last of a way.
        let past = scalar(&[(0.0, 1.0), (1.0, 0.4), (2.0, 0.4)]);
        assert_eq!(past.lags(&*growing(-1.0), &*by("implicit-euler")), None);
        // What is as small as the errors of a reference moves nothing.
        assert_eq!([2e-7, 1e-7].map(|size| lags(0.5 * LAGS, size)), [true, false]);
    }

    /// The classical method beyond its limit of 2.79, and within; midpoint, which keeps of a fast mode all but 4·10⁻⁸; a mode that is slow beside one of 10⁶ is told of by none.
    #[test]
    fn what_a_method_amplifies_is_told_and_what_it_keeps_is_not() {
        let told = |rate: f64, name: &str| scalar(&[(5.0, 1.0), (6.0, 1.0)]).amplified(&*growing(-rate), &*by(name));
        let text = told(2.9, "rk4").expect("it is amplified");
        assert!(
            text.contains("steps of h = 1 multiply a perturbation by 1.18") && text.contains("errors grow"),
            "{text}"
        );
        assert_eq!([told(2.75, "rk4"), told(1e8, "implicit-midpoint")], [None, None]);
        // By the rate at the end of the last step.
        let scalar_past = || scalar(&[(0.0, 1.0), (1.0, 1.0)]);
        let changing = |rate: &str| {
            scalar_past().amplified(&model(&format!("u_i {{ x = 1 }} F_i {{ -({rate})*x }}")), &*by("rk4"))
        };
        assert!(changing("2.7 + 0.2*t").is_some() && changing("2.9 - 0.2*t").is_none());
        let slow = model("u_i { x = 1, y = 1 } F_i { -1e6*x, -0.5*y }");
        let past = Past::of(&[(0.0, [1.0; 2]), (1.0, [1.0; 2])], None);
        assert_eq!(past.amplified(&slow, &*by("rk4")), None);
    }

    /// Method I of a chain damps it by 3 and by 1 in a hundred, its eigenvalues alone by 10 and by 60.
    #[test]
    fn what_is_damped_far_less_than_its_modes_is_told() {
        let told = |coupling: f64, h: f64| {
            let chain = model(&format!("u_i {{ x = 1, y = 1 }} F_i {{ -x + {coupling}*y, -y }}"));
            let rows = [(0.0, [1.0; 2]), (h, [1.0; 2])];
            Past::of(&rows, None).amplified(&chain, &*by("method-i"))
        };
        for h in [0.1, 1.0] {
            let text = told(30.0, h).expect("it is hardly damped");
            assert!(text.contains("errors decay no faster"), "{text}");
            assert_eq!(told(0.0, h), None);
        }
    }

    /// Of 64 components, not of 65: it would take the eigenvalues of a dense matrix.
    #[test]
    fn large_systems_are_not_linearised() {
        let method = by("rk4");
        let told = |cells: usize| {
            let settings = [("cells".into(), cells.to_string())];
            let channel = problem::build("channel-poiseuille", &settings).expect("registered");
            let n = channel.ode().dim();
            let rows: Vec<_> = [0.0, 1.0].iter().map(|x| (*x, vec![*x; n])).collect();
            let mut past = Past::default();
            rows.iter().for_each(|(t, state)| past.add(&Row { t: *t, state, estimate: None, has_ended: false }));
            [past.amplified(&*channel, &*method), past.off(&*channel, &*method, 1.0, 0.0)].map(|told| told.is_some())
        };
        assert_eq!([told(65), told(66)], [[true; 2], [false; 2]]);
    }

    /// x turns with v, of which it has a unit of 10⁹: least squares hardly move it in steps of 1/10.
    #[test]
    fn a_lag_for_the_units_says_so() {
        let unlike = model("u_i { x = 1, v = 0 } F_i { 1e9*v, -1e-9*x }");
        let rows = [2.0, 2.1, 2.2].map(|t| (t, [1.0, 1e-9]));
        let told = Past::of(&rows, None).lags(&unlike, &*by("method-i")).expect("it lags");
        assert!(told.contains("with v in units of 9e-10 of those of x"), "{told}");
    }

    /// Implicit Euler of v̇ = −v comes to 1/2 where the solution comes to 1/e, by 0.132 of what it was.
    #[test]
    fn a_step_is_off_beyond_a_tenth_of_the_solution_and_thrice_the_estimate() {
        let off = |sizes: f64, estimate: f64, name: &str| {
            let past = Past { sizes: vec![sizes], ..scalar(&[(0.0, 1.0), (1.0, 0.5), (2.0, 0.25)]) };
            past.off(&*growing(-1.0), &*by(name), 1.0, estimate)
        };
        let text = off(1.0, 0.0, "implicit-euler").expect("it is off");
        assert!(text.starts_with("of the equation linearised at t = 0 a step of h = 1 is off by 0.132121"), "{text}");
        assert_eq!([1.2, 1.4].map(|size| off(size, 0.0, "implicit-euler").is_some()), [true, false]);
        assert_eq!([0.043, 0.045].map(|estimate| off(1.0, estimate, "implicit-euler").is_some()), [true, false]);
        // At half the rate; what tells is a step below 1 over the rate, whatever h is.
        let past = scalar(&[(0.0, 1.0), (4.0, 1.0 / 3.0), (8.0, 1.0 / 9.0)]);
        let text = past.off(&*growing(-0.5), &*by("implicit-euler"), 4.0, 0.0).expect("it is off");
        assert!(
            text.contains(" a step of h = 4 is off by 0.197998 ") && text.contains(" a step below 2.00000, tells"),
            "{text}"
        );
        // By the linearised equation rk4 is off by 0.007 alone, whatever the rows of the run are.
        assert_eq!(off(1.0, 0.0, "rk4"), None);
    }

    /// How far growth goes is not for the linearised equation to say.
    #[test]
    fn a_step_in_which_solutions_grow_beyond_e_is_not_off() {
        let off = |rate: f64| {
            let past = scalar(&[(0.0, 1.0), (1.0, 10.0), (2.0, 100.0)]);
            Past { sizes: vec![1.0], ..past }.off(&*growing(rate), &*by("implicit-euler"), 1.0, 0.0).is_some()
        };
        assert_eq!([0.9, 1.1].map(off), [true, false]);
    }

    /// −2 and 1 ± 3i, of a matrix that is far from normal.
    #[test]
    fn a_normal_matrix_has_the_eigenvalues_of_another() {
        let a = DMatrix::from_row_slice(3, 3, &[-2.0, 100.0, 50.0, 0.0, 1.0, -9.0, 0.0, 1.0, 1.0]);
        let normal = normal_with_eigenvalues_of(&a);
        assert!((&normal * normal.transpose() - normal.transpose() * &normal).amax() < 1e-12);
        let of = |a: &DMatrix<f64>| {
            let mut values: Vec<_> = eigenvalues(a).iter().flat_map(|value| [value.re, value.im.abs()]).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        assert!(distance(&of(&normal), &of(&a)) < 1e-12, "{:?}", of(&normal));
    }
}
