//! The error of a run in time, estimated by a finer run beside it.

mod settling;

use lsvi::{Integrator, State, StepError, Trajectory};

use crate::method::Method;
use crate::problem::Problem;
use crate::problem::jumps::Jumps;
use crate::run::RunError;
use crate::theory::order_plan;

pub use settling::Settling;

/// A tightening of tolerances divides the error by about this.
const TIGHTENED: f64 = 10.0;

/// Jumps that are looked for, at most: a solution may slide along one.
const JUMPS: u32 = 1000;
/// Part of the longest step that one which ends at a jump takes at least.
const LEAST: f64 = 1e-6;

/// Parts of the finer run's steps between a jump and the next row: of a transient that a jump starts neither run would see more than the other, so
/// long as it is as fast as their steps.
const PARTS: f64 = 16.0;

/// So many roundings are no difference.
const ROUNDINGS: f64 = 8.0;

/// A finer run beside another one: with half the step or, of an adaptive method, a tenth of the tolerances.
///
/// Of the error of a method of order p the difference of the two is the part 1 − 2^−p, and 1 − 1/10 where the error is in
/// proportion to the tolerance; less is left of it where the finer run may not step as far. The estimate is the difference over that
/// part. It knows nothing of an error in space or in the model.
///
/// Across a jump of f both runs may err by the same, where it falls between the same nodes of either. The finer run of a one-step method
/// ends a step at the jump and goes on behind it, in short steps to the next row, so that the difference is all of the error.
pub struct Estimator<'a> {
    /// There is one between calls, until it fails.
    fine: Option<Trajectory<Box<dyn Integrator + 'a>>>,
    /// The finer run's longest step and end.
    grid: [f64; 2],
    /// None of an adaptive method, or where f has other unknowns than a state.
    jumps: Option<Jumps<'a>>,
    /// Jumps that are still looked for.
    left: u32,
    before: State,
    part: f64,
    /// The order by which errors are taken to fall with the step; none of a method that chooses its steps, which may then be those of the other.
    order: Option<f64>,
    at: Vec<f64>,
    failure: Option<StepError>,
}

impl<'a> Estimator<'a> {
    /// Beside a run of `method` with steps of `h` to `t_end`.
    ///
    /// # Errors
    /// [`RunError`] if the method does not apply, or half the step is too short for double precision.
    pub fn new(problem: &'a dyn Problem, method: &dyn Method, h: f64, t_end: f64) -> Result<Self, RunError> {
        let is_adaptive = method.traits().is_adaptive;
        // A longer step is cut to the interval, which is then what is halved; an empty interval has no steps.
        let h = if t_end > 0.0 { h.min(t_end) } else { h };
        let longest = if t_end > 0.0 { problem.ode().longest_step(t_end) } else { h };
        let (integrator, h, part, order) = match method.tightened(TIGHTENED) {
            // Two runs that both step over what f does for a moment differ by nothing.
            Some(tightened) => (tightened.build(problem)?, h.min(longest), 1.0 - TIGHTENED.recip(), None),
            None => {
                let limit = problem.limit(method.principle()).order.unwrap_or(f64::INFINITY);
                let order = order_plan(problem, method).expectation.order.min(limit);
                (method.build(problem)?, 0.5 * h, 1.0 - (-order).exp2(), Some(order))
            }
        };
        let initial = problem.initial();
        let (at, before) = (initial.clone(), State::new(0.0, initial));
        let fine = Some(Trajectory::new(integrator, before.clone(), h, t_end)?);
        let mut jumps = if is_adaptive { None } else { Jumps::new(problem) };
        jumps.iter_mut().for_each(|jumps| jumps.start(before.t, &before.q));
        Ok(Self { fine, grid: [h, t_end], jumps, left: JUMPS, before, part, order, at, failure: None })
    }

    /// The finer run's state at t, later than the last one asked for; `None` from where it failed.
    pub fn at(&mut self, t: f64) -> Option<&[f64]> {
        if self.failure.is_none() {
            self.failure = self.reach(t).err();
        }
        self.failure.is_none().then_some(&self.at)
    }

    fn reach(&mut self, t: f64) -> Result<(), StepError> {
        let (Some(mut fine), [h, t_end]) = (self.fine.take(), self.grid) else { return Ok(()) };
        // The sum of other steps may end a rounding short of the row.
        let rounding = ROUNDINGS * f64::EPSILON * t;
        while t - fine.state().t > rounding {
            let State { t: start, q, p } = fine.state();
            self.before.t = *start;
            self.before.q.copy_from_slice(q);
            self.before.p.copy_from_slice(p);
            if fine.step()?.is_none() {
                // Behind a jump the grid ends at the row that follows.
                fine.resume(h, t_end)?;
            } else if let Some(behind) = self.jumped(&mut fine) {
                self.jumps.iter_mut().for_each(|jumps| jumps.start(behind.t, &behind.q));
                // A jump may be a rounding beyond the row.
                let end = t.max(behind.t);
                fine = Trajectory::new(fine.into_parts().0, behind, h / PARTS, end)?;
            }
        }
        if (fine.state().t - t).abs() <= rounding {
            self.at.copy_from_slice(&fine.state().q);
        } else {
            fine.interpolate(t, &mut self.at)?;
        }
        self.fine = Some(fine);
        Ok(())
    }

    /// The state behind the jump of f within the last step, where there is one and steps of the method start anywhere.
    fn jumped(&mut self, fine: &mut Trajectory<Box<dyn Integrator + 'a>>) -> Option<State> {
        let Self { jumps: Some(jumps), left: 1.., .. } = self else { return None };
        let end = fine.state();
        if !jumps.may_be_before(end.t, &end.q) {
            return None;
        }
        let end = end.clone();
        self.behind_a_time(fine, &end).or_else(|| self.behind_a_place(fine, end))
    }

    /// The state behind the time within the last step at which f jumps: as the states of a step across show little of it where f is stiff, the one
    /// before the step is held.
    fn behind_a_time(&mut self, fine: &mut Trajectory<Box<dyn Integrator + 'a>>, end: &State) -> Option<State> {
        let Self { before, jumps: Some(jumps), .. } = self else { return None };
        let jump = jumps.between((before.t, &before.q), (end.t, &before.q))?;
        let is_before =
            |jumps: &mut Jumps<'_>, state: &State, t: f64| jump.is_before(jumps.f(t, &state.q)[jump.component]);
        let mut way = [before.t, end.t];
        loop {
            let middle = 0.5 * (way[0] + way[1]);
            if middle <= way[0] || middle >= way[1] {
                break;
            }
            way[usize::from(!is_before(jumps, before, middle))] = middle;
        }
        let mut last = end.clone();
        if way[0] - before.t > ROUNDINGS * f64::EPSILON * way[0] {
            fine.integrator_mut().shorter_step(before, way[0], &mut last)?.ok()?;
        } else {
            // A step to the jump would have no length; that steps of the method start anywhere is what one to the end tells.
            fine.integrator_mut().shorter_step(before, end.t, &mut last)?.ok()?;
            last.clone_from(before);
        }
        // At the state there it may be elsewhere, if it is at a place as well.
        let there = jumps.between((way[0], &last.q), (way[1], &last.q))?;
        (there.component == jump.component).then_some(())?;
        self.left -= 1;
        Some(State { t: way[1], ..last })
    }

    /// The state behind the place within the last step at which f jumps.
    fn behind_a_place(&mut self, fine: &mut Trajectory<Box<dyn Integrator + 'a>>, end: State) -> Option<State> {
        let Self { before, jumps: Some(jumps), .. } = self else { return None };
        let jump = jumps.between((before.t, &before.q), (end.t, &end.q))?;
        self.left -= 1;
        let mut way = [before.t, end.t];
        let (mut last, mut trial) = (before.clone(), end);
        while way[1] - way[0] > 2.0 * f64::EPSILON * way[1] {
            let middle = 0.5 * (way[0] + way[1]);
            // A state that stays at the jump would be left there for ever.
            if way[1] - before.t <= LEAST * self.grid[0] {
                return None;
            }
            fine.integrator_mut().shorter_step(before, middle, &mut trial)?.ok()?;
            if jump.is_before(jumps.f(trial.t, &trial.q)[jump.component]) {
                way[0] = middle;
                last.clone_from(&trial);
            } else {
                way[1] = middle;
            }
        }
        Some(State { t: way[1], ..last })
    }

    /// The error that a difference from [`at`](Self::at) stands for, of values of this size; `None` where an adaptive method has taken the same
    /// steps for both tolerances, and the two runs are one, to roundings.
    #[must_use]
    pub fn error(&self, difference: f64, size: f64) -> Option<f64> {
        let is_none = self.order.is_none() && difference <= ROUNDINGS * f64::EPSILON * size;
        // Of a method without order runs say nothing of the error, but where they are the same.
        (!is_none).then(|| if difference == 0.0 { 0.0 } else { difference / self.part })
    }

    /// Whether the order of the estimate shows at the end of the run, where the finer run is too: a third run, with twice the step, tells. `None`
    /// before the end and of an adaptive method, where the finer run met jumps or failed, and where the difference is of roundings.
    #[must_use]
    pub fn settling(&self, problem: &dyn Problem, method: &dyn Method, end: &State) -> Option<Settling> {
        let [half, t_end] = self.grid;
        let is_end = (t_end - end.t).abs() <= ROUNDINGS * f64::EPSILON * t_end;
        let order = self.order.filter(|_| is_end && self.failure.is_none() && self.left == JUMPS)?;
        Settling::of(problem, method, [2.0 * half, t_end], [&end.q, &self.at], order)
    }

    /// Why the finer run ended early, if it did.
    #[must_use]
    pub fn failure(&self) -> Option<&StepError> {
        self.failure.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::norm::distance;
    use crate::run::run;
    use crate::{method, problem};

    /// The largest and the least ratio of the estimate to the error.
    fn ratios(problem: &str, method: &str, h: f64, t_end: f64) -> [f64; 2] {
        let (problem, method) = (problem::build(problem, &[]).expect("known"), method::parse(method).expect("known"));
        let mut estimator = Estimator::new(&*problem, &*method, h, t_end).expect("applies");
        let mut found = [f64::INFINITY, 0.0];
        run(&*problem, &*method, h, t_end, |state| {
            let exact = (problem.limit(method.principle()).exact)(state.t).expect("known");
            let error = distance(&state.q, &exact);
            let finer = distance(&state.q, estimator.at(state.t).expect("it goes on"));
            if state.t > 0.0 {
                let ratio = estimator.error(finer, 1.0).expect("the steps are fixed") / error;
                found = [found[0].min(ratio), found[1].max(ratio)];
            }
        })
        .expect("smooth");
        found
    }

    #[test]
    fn an_estimate_is_the_error_but_for_terms_of_the_next_order_the_last_short_step_included() {
        for method in ["implicit-euler", "method-i", "rk4", "ls-galerkin(2,radau,2)"] {
            let [least, most] = ratios("linear-drag", method, 0.03, 1.0);
            // The next term is at most h times the first.
            assert!((least - 1.0).abs() < 0.04 && (most - 1.0).abs() < 0.04, "{method}: {least} to {most}");
        }
    }

    /// Method I has order 1 on a Lagrangian whose residual no path makes vanish: half of the error goes with half the step, and
    /// not three quarters.
    #[test]
    fn an_order_that_the_problem_lowers_is_the_one_of_the_estimate() {
        let [least, most] = ratios("poiseuille-ansatz", "method-i", 0.003, 0.3);
        assert!((least - 1.0).abs() < 0.05 && (most - 1.0).abs() < 0.05, "{least} to {most}");
    }

    #[test]
    fn a_step_longer_than_the_interval_is_halved_where_it_was_cut() {
        for h in [1.0, 1.5, 2.0, 5.0] {
            assert_eq!(ratios("linear-drag", "method-i", h, 1.0), ratios("linear-drag", "method-i", 1.0, 1.0));
        }
    }

    #[test]
    fn two_runs_with_the_same_steps_estimate_nothing() {
        let problem = problem::build("linear-drag", &[]).expect("known");
        let estimator = |method: &str| {
            let method = method::parse(method).expect("known");
            Estimator::new(&*problem, &*method, 0.1, 1.0).expect("applies")
        };
        assert_eq!(estimator("radau-adaptive").error(0.0, 1.0), None);
        assert_eq!(estimator("radau-adaptive").error(4.0 * f64::EPSILON, 1.0), None);
        assert_eq!(estimator("radau-adaptive").error(0.9, 1.0), Some(1.0));
        assert!(estimator("radau-adaptive").error(9e-17, 1e-10).is_some());
        assert!(estimator("radau-adaptive").error(f64::NAN, 1.0).is_some_and(f64::is_nan));
        assert_eq!(estimator("method-i").error(0.0, 1.0), Some(0.0));
    }

    /// Of a run on a model the largest estimate, the end of its first component, and the jumps that are looked for yet.
    fn beside_run(text: &str, name: &str, [h, t_end]: [f64; 2]) -> (f64, f64, u32) {
        let model = crate::problem::model::Model::of_text(text, &[], Some(t_end)).expect("a model");
        let method = method::parse(name).expect("known");
        let mut estimator = Estimator::new(&model, &*method, h, t_end).expect("applies");
        let (mut largest, mut end) = (0.0_f64, 0.0);
        run(&model, &*method, h, t_end, |state| {
            let difference = distance(&state.q, estimator.at(state.t).expect("it goes on"));
            largest = largest.max(difference);
            end = state.q[0];
        })
        .expect("it runs");
        (estimator.error(largest, 1.0).expect("the steps are fixed"), end, estimator.left)
    }

    /// At any time of a step, of which a run with half of it may miss as much; and at a place.
    #[test]
    fn a_jump_of_f_is_in_the_estimate_wherever_in_a_step_it_falls() {
        let estimate = |text: &str, method: &str, exact: f64| {
            let (estimate, end, left) = beside_run(text, method, [0.02, 3.0]);
            // A state beside a place may be a rounding before it, and look for it once more.
            assert!((JUMPS - 2..JUMPS).contains(&left), "{text}: {left}");
            [estimate, (end - exact).abs()]
        };
        for method in
            ["implicit-midpoint", "tr-bdf2", "sdirk2", "trapezoidal", "rk4", "method-i", "ls-galerkin(2,radau,2)"]
        {
            for k in 0..10 {
                let at = 1.5 + 0.02 * (f64::from(k) + 0.37) / 10.0;
                let exact = 0.5 * (-3.0_f64).exp() + 0.3 * (1.0 - (at - 3.0).exp());
                let text = format!("u_i {{ c = 0.5 }} F_i {{ -c + 0.3*heaviside(t - {at}) }}");
                let [estimate, error] = estimate(&text, method, exact);
                assert!(estimate >= 0.99 * error, "{method}, {at}: {estimate} for {error}");
            }
        }
        // x = t and from t = a on x = a + 3 (t − a), whatever the way on which the jump lies; at the second place a step of half the length across it
        // errs with the same sign. What the estimate is more is a sixteenth.
        for at in [1.0061, 1.0098] {
            for [rate, rest] in [[0.0, at], [0.5, 1.5 * at], [9.0, 10.0 * at], [-0.5, 0.5 * at]] {
                let text = format!("u_i {{ x = 0 }} F_i {{ 1 + 2*heaviside(x + {rate}*t - {rest}) }}");
                let [estimate, error] = estimate(&text, "rk4", at + 3.0 * (3.0 - at));
                assert!(estimate >= 0.99 * error && estimate < 1.2 * error, "{at}, {rate}: {estimate} for {error}");
                assert!(error > 1e-4);
            }
        }
    }

    /// Between the ends of a step, where x comes by 0.004 further; that something is there a small change of y tells.
    #[test]
    fn a_pulse_within_a_step_is_in_the_estimate() {
        let f = "1 + 2*heaviside(x - 1.0026)*heaviside(1.0086 - x), 10 + 1e-5*heaviside(x - 1.0026)";
        let (estimate, end, _) = beside_run(&format!("u_i {{ x = 0, y = 0 }} F_i {{ {f} }}"), "rk4", [0.02, 3.0]);
        let error = (end - 3.004).abs();
        assert!(estimate >= 0.99 * error && estimate < 1.2 * error && error > 1e-3, "{estimate} for {error}");
    }

    /// Where a step of the finer run ends, of which the next one begins with the f before the jump.
    #[test]
    fn a_jump_of_f_behind_a_node_is_in_the_estimate() {
        let text = "u_i { c = 0.5 } F_i { -c + 0.3*(1 - heaviside(1.5 - t)) }";
        for method in ["rk4", "trapezoidal", "implicit-midpoint", "tr-bdf2", "method-i", "ls-galerkin(2,radau,2)"] {
            let (estimate, end, left) = beside_run(text, method, [0.25, 3.0]);
            let error = (end - 0.5 * (-3.0_f64).exp() - 0.3 * (1.0 - (-1.5_f64).exp())).abs();
            assert!(estimate >= 0.9 * error && left == JUMPS - 1, "{method}: {estimate} for {error}, {left}");
        }
        // And where little of it is left at the end of a step.
        let text = "u_i { c = 0 } F_i { -50*(c - 0.3*(1 - heaviside(1.5 - t))) }";
        for method in ["implicit-euler", "method-i", "trapezoidal", "tr-bdf2", "sdirk2", "ls-galerkin(2,radau,2)"] {
            let (estimate, _, left) = beside_run(text, method, [0.25, 3.0]);
            assert!(estimate > 0.0 && left == JUMPS - 1, "{method}: {estimate}, {left}");
        }
    }

    /// Its place is found to a millionth of a step, of whatever length.
    #[test]
    fn a_jump_in_short_or_long_steps_is_in_the_estimate() {
        for unit in [1e-9, 1e-2, 1e6] {
            let [h, at, t_end] = [0.01, 0.5149, 1.0].map(|part| part * unit);
            let text = format!("u_i {{ x = 0 }} F_i {{ 1 + 2*heaviside(x - {at}) }}");
            let (estimate, end, _) = beside_run(&text, "rk4", [h, t_end]);
            let error = (end - at - 3.0 * (t_end - at)).abs();
            assert!(estimate >= 0.99 * error && estimate < 1.2 * error && error > 0.1 * h, "{estimate} for {error}");
        }
    }

    /// Across a jump of a stiff f implicit steps lead to where f is small again, with little of the jump left in it.
    #[test]
    fn a_jump_of_a_stiff_f_is_in_the_estimate_wherever_in_a_step_it_falls() {
        for (name, rate, k) in
            ["implicit-euler", "method-i", "trapezoidal", "tr-bdf2", "sdirk2", "ls-galerkin(2,radau,2)"]
                .into_iter()
                .flat_map(|name| [20.0, 50.0].map(|rate| (name, rate)))
                .flat_map(|(name, rate)| (0..10).map(move |k| (name, rate, k)))
        {
            let at = 1.5 + 0.1 * (f64::from(k) + 0.37) / 10.0;
            let model = crate::problem::model::Model::of_text(
                &format!("u_i {{ x = 0 }} F_i {{ -{rate}*(x - heaviside(t - {at})) }}"),
                &[],
                Some(3.0),
            )
            .expect("a model");
            let method = method::parse(name).expect("known");
            let mut estimator = Estimator::new(&model, &*method, 0.1, 3.0).expect("applies");
            let (mut most, mut error) = (0.0_f64, 0.0_f64);
            run(&model, &*method, 0.1, 3.0, |state| {
                let exact = if state.t < at { 0.0 } else { 1.0 - (-rate * (state.t - at)).exp() };
                error = error.max((state.q[0] - exact).abs());
                let difference = distance(&state.q, estimator.at(state.t).expect("it goes on"));
                most = most.max(estimator.error(difference, 1.0).expect("the steps are fixed"));
            })
            .expect("it runs");
            // Where the steps do not resolve what follows, half of them do not make less than half of the error for certain.
            assert!(most >= 0.5 * error, "{name}, {rate}, {at}: {most} for {error}");
        }
    }

    /// Rows and jumps of a square wave meet in all ways; the finer run goes on. A step across a jump of 2 errs by twice its length at most, in
    /// each of the two runs by 3h together, of which e^{−π/3} is left at the next jump: 3h/(1 − e^{−π/3}) < 5h in all.
    #[test]
    fn an_estimate_goes_on_beyond_every_jump() {
        let model = crate::problem::model::Model::of_text(
            "u_i { x = 1 } F_i { -x + 2*heaviside(sin(3*t)) - 1 }",
            &[],
            Some(12.0),
        )
        .expect("a model");
        for (name, k) in
            ["rk4", "method-i", "radau-adaptive"].into_iter().flat_map(|name| (6..66).map(move |k| (name, k)))
        {
            let (method, h) = (method::parse(name).expect("known"), 0.004 * f64::from(k));
            let mut estimator = Estimator::new(&model, &*method, h, 12.0).expect("applies");
            let mut last = 0.0;
            run(&model, &*method, h, 12.0, |state| {
                let at = estimator.at(state.t).unwrap_or_else(|| panic!("{name}, h = {h}: it ends at t = {}", state.t));
                assert!(distance(&state.q, at) < 5.0 * h, "{name}, h = {h}: {} at t = {}", at[0], state.t);
                last = state.t;
            })
            .expect("it runs");
            assert_eq!(last, 12.0);
        }
    }

    /// Nothing tells the tolerances of a dose at a twentieth of the time that lasts for a two-hundredth of it.
    #[test]
    fn what_acts_for_a_moment_is_in_the_estimate_of_an_adaptive_method() {
        let model = crate::problem::model::Model::of_text(
            "u_i { x = 1 } F_i { (1 - x) + 2*heaviside(t - 20)*heaviside(20.2 - t) }",
            &[],
            Some(40.0),
        )
        .expect("a model");
        let method = method::parse("radau-adaptive").expect("known");
        let mut estimator = Estimator::new(&model, &*method, 40.0, 40.0).expect("applies");
        let after = 1.0 + 2.0 * (1.0 - (-0.2_f64).exp());
        let found = estimator.at(20.2).expect("it goes on")[0];
        assert!((found - after).abs() < 1e-5, "{found} for {after}");
        assert!(estimator.error(found - 1.0, found).expect("it differs") > 0.36);
    }

    #[test]
    fn a_finer_run_that_fails_gives_no_estimate_from_there_on() {
        let (problem, method) =
            (problem::build("quadratic-drag", &[]).expect("known"), method::parse("method-i").expect("known"));
        let mut estimator = Estimator::new(&*problem, &*method, 20.0, 40.0).expect("applies");
        assert!(estimator.at(0.0).is_some() && estimator.failure().is_none());
        assert!(estimator.at(20.0).is_none() && estimator.failure().is_some(), "W = 10 is beyond the fold");
        assert!(estimator.at(40.0).is_none());
    }
}
