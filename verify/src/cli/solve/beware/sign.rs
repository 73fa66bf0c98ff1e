//! Components that change their sign where the equation lets none.

use verify::problem::rounding::rounding;
use verify::problem::{Problem, component_names};
use verify::reference::{InUnits, Ode};

use super::LOST;
use super::past::{Past, Place};
use crate::cli::layout::{number, plain};
use crate::cli::solve::equation::solution;

/// Times within a step at which a reference is asked for its state.
const LOOKS: u32 = 16;

/// The tolerance of a reference that tells of the sign of what is lost, in units of its largest value.
const SIGNS: f64 = 1e-8;

/// Times what a step makes of a few roundings of the state below which a component has no sign.
const ROUNDINGS: f64 = 8.0;

/// Zeros that references cross as well, after which no more are doubted: the steps of such a run are long and right.
const REFUTED: u32 = 16;

/// Follows the signs of all components.
#[derive(Debug, Default)]
pub(super) struct Signs {
    /// Components that are where the equation seems to let none get, since they crossed zero.
    aside: Vec<Option<Crossing>>,
    /// Zeros that a reference crosses as the run does.
    refuted: u32,
    /// The first that has come far there, when it crossed, and where it is.
    crossed: Option<(usize, f64, f64)>,
}

/// The step in which a component crosses zero.
#[derive(Debug, Clone)]
struct Crossing {
    start: f64,
    end: f64,
    /// The state at its start.
    from: Vec<f64>,
}

impl Crossing {
    /// Whether the solution from the start of the step comes to the other side of zero as well, by more than `far`.
    fn is_of_solution(&self, ode: &dyn Ode, k: usize, far: f64, sizes: &[f64]) -> bool {
        let units: Vec<f64> = sizes.iter().map(|size| if size.is_normal() { *size } else { 1.0 }).collect();
        let ode = InUnits::new(ode, &units);
        let times: Vec<f64> =
            (1..=LOOKS).map(|i| self.start + f64::from(i) / f64::from(LOOKS) * (self.end - self.start)).collect();
        let states = solution(&ode, (self.start, &ode.in_units(&self.from)), &times, SIGNS);
        states.is_some_and(|states| states.iter().any(|state| -ode.states(state)[k] * self.from[k].signum() > far))
    }
}

impl Signs {
    /// Follows the components that cross zero in the last step, all the way of which f, where they are zero, points back. The way is taken for
    /// straight, as that of a long step of high order is not: a reference tells whether the solution crosses zero there.
    pub(super) fn add(&mut self, ode: &dyn Ode, past: &Past) {
        let (start, before) = &past.before;
        let (t, state) = &past.last;
        self.aside.resize(state.len(), None);
        for (k, since) in self.aside.iter_mut().enumerate() {
            let crosses = before[k] * state[k] < 0.0;
            if crosses || since.is_some() {
                let side = if crosses { before[k].signum() } else { -state[k].signum() };
                let lets_none = lets_none(ode, [&past.before, &past.last], k, side);
                // A second crossing brings it back, and a moment later the equation may let it pass.
                let crossing = || Crossing { start: *start, end: *t, from: before.clone() };
                *since = match (crosses, since.take()) {
                    (true, None) => lets_none.then(crossing),
                    (true, Some(_)) => None,
                    (false, since) => since.filter(|_| lets_none),
                };
            }
            let far = LOST * past.sizes[k];
            if self.crossed.is_some() || self.refuted >= REFUTED || state[k].abs() <= far {
                continue;
            }
            let Some(crossing) = since else { continue };
            // All that there is of it may be roundings, as of what vanishes by symmetry.
            let rounded = rounding(|v, f| ode.rhs(*t, v, f), state, state.len())[k];
            if state[k].abs() <= ROUNDINGS * (t - start) * rounded {
                continue;
            }
            if crossing.is_of_solution(ode, k, far, &past.sizes) {
                self.refuted += 1;
                *since = None;
            } else {
                self.crossed = Some((k, crossing.end, state[k]));
            }
        }
    }

    /// That a component crosses zero where the equation lets none.
    pub(super) fn told(&self, problem: &dyn Problem) -> Option<String> {
        let (k, t, value) = self.crossed?;
        let name = &component_names(problem)[k];
        Some(format!(
            "in the step to t = {} {name} changes its sign, to {}, and the solution does not there: where {name} is 0 on the way, f is 0 or points back; \
             smaller steps, or tolerances below its size, tell",
            plain(t),
            number(value)
        ))
    }
}

/// Whether f, where component `k` is zero, points to this side or nowhere all along a step that it follows.
fn lets_none(ode: &dyn Ode, [(start, before), (end, state)]: [&Place; 2], k: usize, side: f64) -> bool {
    // f_k in a part of the step, where the component is zero and where it is what it is.
    let rates = |part: f64| {
        let mut v: Vec<f64> = before.iter().zip(state).map(|(a, b)| a + part * (b - a)).collect();
        let mut f = [vec![0.0; v.len()], vec![0.0; v.len()]];
        let t = start + part * (end - start);
        ode.rhs(t, &v, &mut f[1]);
        v[k] = 0.0;
        ode.rhs(t, &v, &mut f[0]);
        f.map(|f| f[k])
    };
    let rates = [0.0, 0.25, 0.5, 0.75, 1.0].map(rates);
    // A step that f follows nowhere has turned on the way.
    let is_followed = rates.iter().any(|[_, f]| f * (state[k] - before[k]) > 0.0);
    is_followed && rates.iter().all(|[f, _]| side * f >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::solve::equation::model;
    use verify::problem;

    /// Of cos t in a step of a period, and in one that ends before it comes to zero.
    #[test]
    fn a_solution_that_crosses_zero_within_a_step_crosses_it() {
        let oscillator = problem::build("harmonic-oscillator", &[]).expect("registered");
        let crosses = |end: f64| {
            let crossing = Crossing { start: 2.0, end: 2.0 + end, from: vec![1.0, 0.0] };
            crossing.is_of_solution(oscillator.ode(), 0, 1e-3, &[1.0; 2])
        };
        assert_eq!([std::f64::consts::TAU, 1.5].map(crosses), [true, false]);
    }

    /// By 50 in units of 100, in half a period.
    #[test]
    fn a_solution_is_followed_beyond_zero_in_its_own_units() {
        let oscillator = problem::build("harmonic-oscillator", &[]).expect("registered");
        let crossing = Crossing { start: 0.0, end: std::f64::consts::PI, from: vec![50.0, 0.0] };
        let crosses = |far: f64| crossing.is_of_solution(oscillator.ode(), 0, far, &[100.0; 2]);
        assert_eq!([0.1, 49.0, 51.0].map(crosses), [true, true, false]);
    }

    fn followed<const N: usize>(model: &dyn Problem, rows: &[(f64, [f64; N])]) -> Signs {
        let mut signs = Signs::default();
        (2..=rows.len()).for_each(|n| signs.add(model.ode(), &Past::of(&rows[..n], None)));
        signs
    }

    /// From 10⁻¹³ to −10⁻¹³, where y decays to 10⁻¹⁴ in no time: f is roundings of 1 and of 10, which move it by less than that in a short step, and by more in
    /// a long one.
    #[test]
    fn a_component_has_a_sign_beyond_the_roundings_of_a_step() {
        let decaying = model("u_i { x = 1, y = 0 } F_i { 0*x, x - 1e14*y }");
        let is_crossed = |h: f64| {
            let rows = [(100.0, [1.0, 1e-13]), (100.0 + h, [1.0, -1e-13])];
            followed(&decaying, &rows).crossed.is_some()
        };
        assert_eq!([0.01, 10.0].map(is_crossed), [true, false]);
    }

    /// It crosses by next to nothing first, where f pushes back, and goes on from there as f beyond has it.
    #[test]
    fn a_component_that_goes_on_beyond_zero_is_followed_from_where_it_crossed() {
        let leaving = model("u_i { x = 1, y = 0 } F_i { 0*x, 1e-12*x + y }");
        let rows = [(0.0, [1.0, 1e-3]), (0.1, [1.0, -1e-7]), (0.2, [1.0, -1e-4])];
        let crossed = followed(&leaving, &rows).crossed;
        assert!(matches!(crossed, Some((1, 0.1, -1e-4))), "{crossed:?}");
    }

    /// y is let through where x is below 1 or above 3/2, and x goes from one to the other.
    #[test]
    fn f_is_asked_all_along_the_straight_way_of_a_step() {
        let gate = model("u_i { x = 1, y = 0 } F_i { 0*x, (x - 1)*(1.5 - x) + 1e6*y }");
        let lets_none =
            |from: [f64; 2], to: [f64; 2]| lets_none(gate.ode(), [&(1.0, from.to_vec()), &(2.0, to.to_vec())], 1, 1.0);
        assert!(lets_none([1.0, 1e-3], [1.5, -1e-4]));
        assert!(!lets_none([0.9, 1e-3], [1.5, -1e-4]), "as it begins");
        assert!(!lets_none([1.0, 1e-3], [1.6, -1e-4]), "as it ends");
    }

    /// In a step from t = 1 to 3, which is longer than 1, y is let through nowhere, or at the first, the last or the middle time alone.
    #[test]
    fn f_is_asked_all_along_the_time_of_a_step() {
        let lets_none = |f: &str| {
            let model = model(&format!("u_i {{ y = 0 }} F_i {{ {f} + y }}"));
            lets_none(model.ode(), [&(1.0, vec![1e-3]), &(3.0, vec![-1.0])], 0, 1.0)
        };
        assert!(lets_none("(t - 0.99)*(3.01 - t)"));
        assert!(!lets_none("(t - 1.01)*(3.01 - t)"));
        assert!(!lets_none("(t - 0.99)*(2.99 - t)"));
        assert!(!lets_none("(t - 2)*(t - 2) - 1e-3"));
    }

    /// Along which f is zero, or points away from where it goes.
    #[test]
    fn a_step_that_f_follows_nowhere_is_not_asked_for_a_sign() {
        let lets_none = |f: &str| {
            let model = model(&format!("u_i {{ y = 0 }} F_i {{ {f} }}"));
            lets_none(model.ode(), [&(0.0, vec![1e-3]), &(1.0, vec![-1e-4])], 0, 1.0)
        };
        assert_eq!(["0*y", "1 + 0*y", "1e-4 + y"].map(lets_none), [false, false, true]);
        // f is −0 where y is, and it points to neither side.
        assert!(lets_none("-y"));
        let decaying = model("u_i { y = 0 } F_i { -y }");
        assert!(!super::lets_none(decaying.ode(), [&(0.0, vec![-1.0]), &(1.0, vec![-1.0])], 0, 1.0), "it stands still");
    }

    /// ẏ = 2y − 1/2 + cos 8πt pushes it back in each quarter of the step, and takes it beyond zero all the same.
    #[test]
    fn what_a_reference_crosses_too_is_no_wrong_sign() {
        let pushed = model("u_i { y = 0.1 } F_i { 2*y - 0.5 + cos(25.132741228718345*t) }");
        let rows = [(0.0, [0.1]), (1.0, [-0.86])];
        let signs = followed(&pushed, &rows);
        assert_eq!((signs.refuted, signs.crossed, signs.aside.iter().flatten().count()), (1, None, 0));
    }

    /// Of ẏ = y, which never changes its sign.
    #[test]
    fn after_sixteen_crossings_that_were_right_none_is_doubted() {
        let growing = model("u_i { y = 1 } F_i { y }");
        let crossed = |refuted: u32| {
            let mut signs = Signs { refuted, ..Signs::default() };
            signs.add(growing.ode(), &Past::of(&[(0.0, [1.0]), (1.0, [-1.0])], None));
            signs.crossed
        };
        assert_eq!([15, 16].map(crossed), [Some((0, 1.0, -1.0)), None]);
        let told = followed(&growing, &[(0.0, [1.0]), (1.0, [-1.0])]).told(&growing).expect("it is wrong");
        assert!(told.starts_with("in the step to t = 1 y changes its sign, to -1.00000"), "{told}");
        // What leaves zero changes none, nor what comes to it.
        let falling = model("u_i { y = 1 } F_i { -y }");
        assert!(followed(&falling, &[(0.0, [-1.0]), (1.0, [0.0])]).aside.iter().all(Option::is_none));
        // A part of the largest value.
        let far = |to: f64| followed(&growing, &[(0.0, [10.0]), (1.0, [to])]).crossed.is_some();
        assert_eq!([-9e-3, -1.1e-2].map(far), [false, true]);
        assert_eq!(followed(&growing, &[(0.0, [0.0]), (1.0, [-1.0])]).crossed, None);
    }
}
