//! Runs that rest, stay or leave a component where it is, and the equation does not.

use verify::experiment::growth;
use verify::measure::norm::{Extremes, distance, larger, max_norm};
use verify::measure::stability::spectral_abscissa;
use verify::method::Method;
use verify::problem::{Problem, component_names};
use verify::reference::Ode;
use verify::run::step_from;

use super::past::Past;
use super::{LEAVES, REST};
use crate::cli::layout::{number, plain};
use crate::cli::solve::equation::jacobian;
use crate::cli::solve::held::step_that_shows;

/// Part of the way from a rest at which an error tells that it is no rest of the method's.
const FOLLOWED: f64 = 1e-3;

impl Past {
    /// Whether the last step moves nothing, nor what comes after it.
    fn rests(&self) -> bool {
        let [(_, before), (_, v)] = self.last_step();
        // What leaves in a last step that is cut does not rest.
        larger(distance(v, before), distance(v, &self.last.1)) <= REST * self.largest
    }

    /// A state of rest that is none of the equation.
    pub(super) fn rests_by_method_alone(&self, problem: &dyn Problem) -> Option<String> {
        // The references' f, which may be dear, is asked where the run rests alone.
        if !self.rests() {
            return None;
        }
        let [(t_before, before), (t, v)] = self.last_step();
        let (h, moved) = (t - t_before, distance(v, before));
        let least = max_norm(&self.constant_rates(problem.ode()));
        // What is no normal number moves nothing that is one.
        let is_moved = h * least > (REST * max_norm(v)).max(f64::MIN_POSITIVE);
        (is_moved && moved <= REST * h * least).then(|| {
            format!(
                "the run rests where f is not zero: it moved by {} in the last step of h = {}, |f| = {}; that is a steady \
                 state of the method, not of the equation",
                number(moved),
                plain(h),
                number(least)
            )
        })
    }

    /// A state of rest that the equation leaves.
    pub(super) fn rests_where_unstable(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        if !self.rests() {
            return None;
        }
        let [(t_before, before), (t, v)] = self.last_step();
        let (h, moved) = (t - t_before, distance(v, before));
        let mut f = vec![0.0; v.len()];
        problem.ode().rhs(*t, v, &mut f);
        let (rate_of_f, least) = (max_norm(&f), REST * self.largest);
        if h * rate_of_f > least {
            return None;
        }
        let a = jacobian(problem, *t, v);
        let rate = spectral_abscissa(&a);
        if distance(&self.first, v) <= least {
            // A distance from the rest of |f|/rate or of a rounding, by the end; in logarithms, as it may be beyond all numbers.
            let distance = (rate_of_f / rate).max(f64::EPSILON * max_norm(v));
            let leaves = rate_of_f > 0.0 && rate * t + distance.ln() > least.ln();
            return (rate > 0.0 && leaves).then(|| {
                format!(
                    "the run stays where it starts, beside a state of rest that is unstable: perturbations grow like e^({} t) there, and what \
                     f is there, {}, or a rounding is enough to leave it before the end; tolerances below it, and steps below {}, tell",
                    number(rate),
                    number(rate_of_f),
                    number(rate.recip())
                )
            });
        }
        // A solution that comes down to where it grows again is followed there.
        let away = rate_of_f / rate;
        if away > 0.0 && self.estimate.is_some_and(|estimate| estimate <= FOLLOWED * away) {
            return None;
        }
        // A method that lets perturbations grow rests only where there are none, as the solution does.
        let damps = || {
            growth(method, &(h * &a)).map_or(rate_of_f == 0.0 || moved < 0.5 * h * rate_of_f, |factor| factor <= 1.0)
        };
        (h * rate > REST && damps()).then(|| {
            format!(
                "the run came to rest where the equation is unstable: perturbations grow like e^({} t) there, and the method \
                 with h = {} damps them; {}",
                number(rate),
                plain(h),
                step_that_shows(method, &(h * &a), h)
            )
        })
    }

    /// A component that stays at its start, where f moves it: a least-squares method holds one by which f does not change, and one with
    /// |R(∞)| = 1 what is fast beside its steps.
    pub(super) fn stuck(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let [(t_before, _), (t, v)] = self.last_step();
        let (h, rates) = (t - t_before, self.constant_rates(problem.ode()));
        let jacobian = jacobian(problem, *t, v);
        (0..v.len()).find_map(|k| {
            let rate = rates[k].abs();
            // A fast component is at rest nearby, and f is large there all the same.
            let way = (h * rate).min(rate / jacobian[(k, k)].abs());
            // What has gone further than the start is large does not stay, however far f would move it from there.
            let stays = self.moved[k] <= (REST * way).min(max_norm(&self.first));
            (way.is_finite() && way > REST * self.largest && stays).then(|| {
                let short = jacobian.norm().recip().min(0.5 * h);
                let remedy = match moves(problem, method, (v, k), short) {
                    true => format!("a step below {} moves it", number(short)),
                    false => "no smaller step helps".into(),
                };
                format!(
                    "{} stays at {} all the way, where f moves it at a rate of {}: the method holds it, not the equation, and {remedy}",
                    component_names(problem)[k],
                    number(v[k]),
                    number(rates[k])
                )
            })
        })
    }

    /// States that solutions of the equation leave within a step, and the run does not.
    pub(super) fn stays(&self, problem: &dyn Problem, method: &dyn Method) -> Option<String> {
        let [(t_before, before), (t, v)] = self.last_step();
        let h = t - t_before;
        let a = jacobian(problem, *t, v);
        let exponent = h * spectral_abscissa(&a);
        // What goes beyond all that was before leaves, if not as fast.
        let stays = max_norm(&self.last.1) <= 2.0 * max_norm(before);
        let factor = (stays && exponent > LEAVES).then(|| growth(method, &(h * &a))).flatten()?;
        (factor.ln() < 0.5 * exponent).then(|| {
            format!(
                "at the end perturbations grow like e^({} t), and a step of h = {} multiplies them by {} alone: it stays where solutions of the \
                 equation do not; {}",
                number(exponent / h),
                plain(h),
                number(factor),
                step_that_shows(method, &(h * &a), h)
            )
        })
    }

    /// What each component of f is at least all through the last step, with its sign, and 0 where that changes: what turns within a step, or is
    /// back where it was at the end of each, is moved by no constant rate.
    fn constant_rates(&self, ode: &dyn Ode) -> Vec<f64> {
        let [(start, _), (end, v)] = self.last_step();
        let rates = [0.0, 0.382, 1.0].map(|part| {
            let mut f = vec![0.0; v.len()];
            ode.rhs(start + part * (end - start), v, &mut f);
            f
        });
        let of = |k: usize| rates.each_ref().map(|f| f[k]);
        let least = |of: [f64; 3]| match of.iter().all(|f| f.signum() == of[0].signum()) {
            true => of.iter().map(|f| f.abs()).smallest().copysign(of[0]),
            false => 0.0,
        };
        (0..v.len()).map(|k| least(of(k))).collect()
    }
}

/// Whether a step of `h` from `v` moves component `k` half as far as f does, or more.
fn moves(problem: &dyn Problem, method: &dyn Method, (v, k): (&[f64], usize), h: f64) -> bool {
    let mut f = vec![0.0; v.len()];
    problem.ode().rhs(0.0, v, &mut f);
    step_from(problem, v.to_vec(), method, h).is_ok_and(|end| (end[k] - v[k]).abs() >= 0.5 * h * f[k].abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::solve::equation::{by, growing, model};

    fn scalar(rows: &[(f64, f64)], estimate: Option<f64>) -> Past {
        let rows: Vec<_> = rows.iter().map(|(t, x)| (*t, [*x])).collect();
        Past::of(&rows, estimate)
    }

    #[test]
    fn a_run_rests_that_moves_by_a_millionth_of_its_size_at_most() {
        let rests = |by: f64| scalar(&[(0.0, 10.0), (1.0, 10.0 + by)], None).rests();
        assert_eq!([0.0, 9e-6, 1.1e-5].map(rests), [true, true, false]);
        assert!(!scalar(&[(0.0, 10.0), (1.0, 10.0), (1.5, 11.0)], None).rests(), "it leaves in a step that is cut");
    }

    /// In a step of 1/2 from 5, by a rate of f that moves it by a millionth of that, and by a millionth of what f does.
    #[test]
    fn a_rest_of_the_method_alone_is_one_where_f_moves_the_run() {
        let told = |f: f64, moved: f64| {
            let constant = model(&format!("u_i {{ y = 5 }} F_i {{ {f:e} + 0*y }}"));
            scalar(&[(10.0, 5.0), (10.5, 5.0 + moved)], None).rests_by_method_alone(&constant)
        };
        assert_eq!([9e-6, 1.1e-5].map(|f| told(f, 0.0).is_some()), [false, true]);
        assert_eq!([9e-7, 1.1e-6].map(|moved| told(2.0, moved).is_some()), [true, false]);
        assert!(told(2.0, 0.0).is_some_and(|text| text.contains("in the last step of h = 0.5, |f| = 2.00000")));
    }

    /// (t − 3.146)² + 1 from 2 to 5, which is least within, and what changes its sign.
    #[test]
    fn a_constant_rate_is_the_least_in_a_step() {
        let rising = model("u_i { x = 1, y = 1 } F_i { 1 + (t - 3.146)*(t - 3.146) + 0*x, t - 3 + 0*y }");
        let rates = Past::of(&[(2.0, [1.0; 2]), (5.0, [1.0; 2])], None).constant_rates(rising.ode());
        assert!((rates[0] - 1.0).abs() < 1e-12 && rates[1] == 0.0, "{rates:?}");
        let falling = model("u_i { x = 1 } F_i { -t + 0*x }");
        assert_eq!(scalar(&[(2.0, 1.0), (5.0, 1.0)], None).constant_rates(falling.ode()), [-2.0]);
    }

    /// Implicit Euler moves v̇ = −v by h/(1 + h).
    #[test]
    fn a_step_moves_a_component_half_as_far_as_f_does() {
        let moves = |v: f64, h: f64| moves(&*growing(-1.0), &*by("implicit-euler"), (&[v], 0), h);
        assert_eq!(
            [(1.0, 0.9), (10.0, 0.5), (1.0, 1.5), (10.0, 1.5)].map(|(v, h)| moves(v, h)),
            [true, true, false, false]
        );
    }

    /// However little that is in the units of the equation.
    #[test]
    fn what_moves_with_its_rate_is_not_held() {
        for size in [1e-7, 1.0, 1e7] {
            let stuck = |values: [f64; 3]| {
                let rows: Vec<_> = [7.0, 7.1, 7.2].into_iter().zip(values.map(|x| size * x)).collect();
                scalar(&rows, None).stuck(&*growing(-1.0), &*by("implicit-euler"))
            };
            assert_eq!([stuck([1.0, 0.9, 0.8]), stuck([1.0, 1.0 - 1e-6, 1.0 - 2e-6])], [None, None], "{size}");
            let told = stuck([1.0; 3]).expect("it is held");
            assert!(told.contains("at a rate of ") && told.ends_with("a step below 0.0500000 moves it"), "{told}");
        }
    }

    /// Of ẋ = −1000 (x − 1) at 2, one away from its rest, beside a component of 1 or of ten millions.
    #[test]
    fn a_fast_component_is_held_by_its_way_to_rest() {
        let fast = model("u_i { x = 2, y = 1 } F_i { -1000*(x - 1), 0*y }");
        let stuck = |y: f64| {
            let rows = [0.0, 1.0, 2.0].map(|t| (t, [2.0, y]));
            Past::of(&rows, None).stuck(&fast, &*by("implicit-euler")).is_some()
        };
        assert_eq!([1.0, 1e7].map(stuck), [true, false]);
        // Where f is zero nothing is moved.
        let still = scalar(&[(0.0, 0.0), (1.0, 0.0)], None);
        assert_eq!(still.stuck(&*growing(-1.0), &*by("implicit-euler")), None);
        // Where no step is taken from there none helps.
        let held = model("u_i { x = 1, y = 0 } F_i { -x, x - y*y }");
        let rows = [0.0, 0.01].map(|t| (t, [1.0 - t, 0.0]));
        let told = Past::of(&rows, None).stuck(&held, &*by("method-ii")).expect("it is held");
        assert!(
            told.starts_with("y stays at 0 all the way, where f moves it") && told.ends_with("no smaller step helps"),
            "{told}"
        );
        // A run that blows up goes on faster than it has come, and has not stayed, nor has what another component is far ahead of.
        let explosive = model("u_i { x = 1 } F_i { 1e40 + 0*x }");
        let stuck = |x: f64| scalar(&[(0.0, 1.0), (1.0, x)], None).stuck(&explosive, &*by("implicit-euler")).is_some();
        assert_eq!([1.0, 1e30].map(stuck), [true, false]);
        let explosive = model("u_i { x = 1, y = 1 } F_i { 1e90 + 0*x, 1e99 + 0*y }");
        let beside = |x: f64| {
            Past::of(&[(0.0, [1.0, 1.0]), (1.0, [x, 1e80])], None).stuck(&explosive, &*by("implicit-euler")).is_some()
        };
        assert_eq!([1.0, 1e30].map(beside), [true, false]);
        // In 10⁻⁸ nothing goes far.
        let rows = [0.0, 1e-8, 2e-8].map(|t| (t, 1.0));
        assert_eq!(scalar(&rows, None).stuck(&*growing(-1.0), &*by("implicit-euler")), None);
    }

    /// In a step of 1/2 solutions of ẋ = 3x grow by e^{3/2}; rk4 has that, and implicit Euler a factor of 2, by half of this exponent it may lack.
    #[test]
    fn a_method_that_shows_half_of_the_growth_does_not_hold_a_run() {
        let stays = |name: &str| scalar(&[(3.0, 1.0), (3.5, 1.0)], None).stays(&*growing(3.0), &*by(name));
        assert_eq!(stays("rk4"), None);
        let told = stays("implicit-euler").expect("it stays");
        assert!(told.contains("like e^(3.00000 t), and a step of h = 0.5 multiplies them by 2.00000 alone"), "{told}");
        // Beyond twice what it was it leaves.
        let stays = |to: f64| scalar(&[(3.0, 10.0), (4.0, to)], None).stays(&*growing(1.5), &*by("implicit-euler"));
        assert_eq!([19.0, 21.0].map(|to| stays(to).is_some()), [true, false]);
    }

    /// At 10⁻⁹ from where ẋ = 100x rests, by an error that is known to far less than that, or not; and there.
    #[test]
    fn a_run_that_comes_to_an_unstable_rest_is_told_unless_its_error_is_far_less_than_the_way_from_it() {
        let told = |rows: &[(f64, f64)], estimate: Option<f64>, name: &str, rate: f64| {
            scalar(rows, estimate).rests_where_unstable(&*growing(rate), &*by(name))
        };
        let by_euler =
            |rows: &[(f64, f64)], estimate: f64| told(rows, Some(estimate), "implicit-euler", 100.0).is_some();
        let rows = [(0.8, 1.0), (0.9, 1.1e-9), (1.0, 1e-9)];
        assert_eq!([5e-13, 5e-12].map(|estimate| by_euler(&rows, estimate)), [false, true]);
        assert!(by_euler(&[(0.8, 1.0), (0.9, 0.0), (1.0, 0.0)], 0.0));
        // That it still moves is more than a rest of the method's alone.
        assert!(by_euler(&[(0.8, 1.0), (0.9, 1e-9 + 1e-13), (1.0, 1e-9)], f64::NAN));
        // Where f moves it it does not rest.
        assert!(!by_euler(&[(0.8, 1.0), (0.9, 1e-3), (1.0, 1e-3)], f64::NAN));
        // Where it starts it stays as the solution does.
        assert!(!by_euler(&[(0.8, 0.0), (0.9, 0.0), (1.0, 0.0)], 0.0));
        // A rate that is fast beside the steps.
        let fast = told(&[(0.8, 1.0), (0.9, 0.0), (1.0, 0.0)], None, "implicit-euler", 1e7);
        assert!(
            fast.is_some_and(|text| text.contains("grow like e^(1.00000e7 t) there, and the method with h = 0.1 damps"))
        );
        // Next to no time, in which nothing grows.
        assert_eq!(told(&[(0.0, 1.0), (1e-17, 0.0), (2e-17, 0.0)], None, "implicit-euler", 1.0), None);
        // Of a method with steps of its own it is the step that tells, which moves it by less than half of h f.
        let rests = |before: f64, end: f64| {
            told(&[(0.8, 1.0), (0.9, before), (1.0, end)], None, "radau-adaptive", 100.0).is_some()
        };
        assert_eq!([rests(5e-9, 1e-9), rests(7e-9, 1e-9), rests(0.0, 0.0)], [true, false, true]);
    }

    /// Beside y = 1: where f is zero, where it moves x by next to nothing, and where it moves it.
    #[test]
    fn a_run_that_stays_where_f_is_nothing_is_none_of_the_method_alone() {
        let told = |f: &str, y: f64| {
            let past = Past::of(&[(99.9, [0.0, y]), (100.0, [0.0, y])], None);
            let model = model(&format!("u_i {{ x = 0, y = 1 }} F_i {{ {f}, 0*y }}"));
            past.rests_by_method_alone(&model).is_some()
                || past.rests_where_unstable(&model, &*by("implicit-euler")).is_some()
        };
        assert_eq!([told("x", 1.0), told("1e-9 + 0*x", 1.0), told("1 + 0*x", 0.0)], [false, false, true]);
    }

    /// ẋ = x from 10⁻¹², beside y = 10⁶: a rounding of that grows to a millionth of it in a time of 22. ẋ = 100x from 10⁻⁹ beside y = 1 does in one of
    /// 0.069.
    #[test]
    fn a_run_that_stays_where_it_starts_is_told_where_it_has_the_time_to_leave() {
        let told = |rate: f64, state: [f64; 2], h: f64, t: f64| {
            let model = model(&format!("u_i {{ x = 0, y = 1 }} F_i {{ {rate:e}*x, 0*y }}"));
            let past = Past::of(&[(t - h, state), (t, state)], None);
            past.rests_where_unstable(&model, &*by("implicit-euler")).is_some()
        };
        assert_eq!([20.0, 25.0].map(|t| told(1.0, [1e-12, 1e6], 0.1, t)), [false, true]);
        assert_eq!([0.06, 0.08].map(|t| told(100.0, [1e-9, 1.0], 0.01, t)), [false, true]);
    }
}
