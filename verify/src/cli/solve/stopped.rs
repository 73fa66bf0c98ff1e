//! Why a step of a run has no solution, and what was found to lead on.

use lsvi::{SolveError, State, StepError};
use verify::kinds::Principle;
use verify::measure::norm::{distance, larger, max_norm};
use verify::method::{self, Method};
use verify::problem::{Problem, component_names};
use verify::run::{RunError, leads_to};

use super::equation::{COURSE, DENSE, jacobian, solution};
use crate::cli::layout::{number, plain};

/// Part of a step beside the end of a branch, well beyond the digits to which that is known, and how many times f changes there what it does
/// elsewhere if it jumps.
const BESIDE: f64 = 1e-6;
const JUMPS: f64 = 100.0;

/// How many times a step is halved in search of one that leads on.
const HALVINGS: i32 = 6;

/// A method whose steps come to a jump by halves and quarters of their own.
const ADAPTIVE: &str = "radau-adaptive";

/// The way on which a jump is looked for, in steps, as the state that an implicit step leads to is not the one to which f points; its parts,
/// and the halvings of one of them that leave of what changes steadily nothing.
const WAY: f64 = 1.5;
const PARTS: u32 = 16;
const PIECES: u32 = 30;

/// Part of the largest change of the rate in a part of the way that a jump comes to; a cube root, which is as steep as any at 0, leaves a
/// thousandth.
const LEFT: f64 = 1e-2;

/// Pieces of a part of the way that are looked at: one that rises and falls once has 2/LEFT at most that change as much in each halving.
const LOOKED_AT: u32 = PIECES * 200;

/// Part of a jump that f changes by in as much of the way beside it at most.
const CALM: f64 = 0.1;

/// Part of f below which a change is none.
const NOTHING: f64 = 1e-6;

/// What is known of a step that failed from the state `v`, in a run whose largest component so far is `largest`.
pub(super) fn told(
    problem: &dyn Problem,
    method: &dyn Method,
    error: &RunError,
    (v, largest): (&[f64], f64),
) -> Option<String> {
    let RunError::Step(StepError::Solve { t, h, source }) = error else { return None };
    let (t, h, n) = (*t, *h, v.len());
    if problem.ode().dim() != n {
        return None;
    }
    if let SolveError::BranchLost { reached } = source
        && jumps_in_time(problem, (t, v), (*reached, h))
    {
        let text = "f jumps in time there; an explicit method, or `implicit-midpoint`, steps across, and so does a much smaller `--h`";
        return Some(text.into());
    }
    let is_lost = matches!(source, SolveError::BranchLost { .. } | SolveError::OtherBranch);
    if n > DENSE || !(is_lost || matches!(source, SolveError::Diverged { .. })) {
        return None;
    }
    if method.principle() == Principle::MomentumConserved && turns(problem, (t, v), h) {
        return Some(
            "an eigenvalue of the Jacobian of f comes to 0 near there, where a condition of p₁ = p₀ says nothing of its mode: a smaller `--h` may only come \
             closer; `method-i` or `trapezoidal` steps across"
                .into(),
        );
    }
    let size = max_norm(v);
    if size < f64::EPSILON * largest {
        return Some(format!(
            "the state has come to {} there, a rounding beside the {} that it was: f may have no finite derivative where it rests, as sqrt(x) has \
             none at x = 0; an explicit method, as rk4, asks for none",
            number(size),
            number(largest)
        ));
    }
    let shortest = h / f64::from(1 << HALVINGS);
    let mut shorter = (1..=HALVINGS).map(|k| h / f64::from(1 << k));
    let found = shorter.find(|step| leads_to(problem, method, State::new(t, v.to_vec()), *step, t + h));
    match (jump(problem, (t, v), h), found) {
        (Some((place, k)), found) => {
            let tried = match found {
                Some(step) => format!("steps of {} lead across", number(step)),
                None => format!("of its halves, quarters and so on down to {}, none leads across", number(shortest)),
            };
            let adaptive = method::parse(ADAPTIVE).ok().filter(|_| !method.traits().is_adaptive);
            let leads = adaptive.is_some_and(|it| leads_to(problem, &*it, State::new(t, v.to_vec()), h, t + h));
            let other = if leads { format!("`{ADAPTIVE}` leads across by steps of its own; ") } else { String::new() };
            Some(format!(
                "the rate of {} jumps near there, at t = {} if the state goes on as it does. The solution of an implicit step, followed from a step of none, \
                 breaks off at a jump; one beyond it, if the step has one, is not looked for: {tried}; {other}an explicit method, as rk4, solves no equation; \
                 a program can stop at the jump (`Trajectory::until`) and go on with the f behind it. A change over a short distance, as that of tanh, is \
                 no jump",
                component_names(problem)[k],
                plain(place)
            ))
        }
        (None, Some(step)) => Some(format!(
            "steps of {} lead on from there, to t = {}: take a smaller `--h`, unless the solution ends soon after, as in a pole",
            number(step),
            plain(t + h)
        )),
        (None, None) if is_lost => Some(format!(
            "no steps down to {} lead from there to t = {}: the solution may end, as in a pole, or f be too steep to be followed, where an explicit \
             method, as rk4, solves no equation",
            number(shortest),
            plain(t + h)
        )),
        (None, None) => None,
    }
}

/// Whether the determinant of ∂f/∂v changes its sign along the solution from a state, within a step and a half.
fn turns(problem: &dyn Problem, (t, v): (f64, &[f64]), h: f64) -> bool {
    let end = t + WAY * h;
    let solved = solution(problem.ode(), (t, v), &[end], COURSE);
    // In units in which neither it nor what it is made of goes beyond all numbers; of a matrix of zeros there is no sign.
    let sign = |t: f64, v: &[f64]| {
        let matrix = jacobian(problem, t, v);
        let scale = matrix.amax();
        (matrix / scale).determinant().signum()
    };
    solved.and_then(|mut states| states.pop()).is_some_and(|there| sign(t, v) * sign(end, &there) == -1.0)
}

/// Whether f jumps in time at the end of the branch of a step: least-squares methods do not follow it across in long steps.
fn jumps_in_time(problem: &dyn Problem, (t, v): (f64, &[f64]), (reached, h): (f64, f64)) -> bool {
    let f = |parts: f64| {
        let mut f = vec![0.0; v.len()];
        problem.ode().rhs(t + reached + parts * BESIDE * h, v, &mut f);
        f
    };
    let [earlier, before, after] = [-3.0, -1.0, 1.0].map(f);
    let calm = larger(distance(&before, &earlier), f64::EPSILON.sqrt() * max_norm(&before));
    distance(&after, &before) > JUMPS * calm
}

/// Where the rate of a component first jumps on the way on which f leads from a state, and of which: a part of that way is halved again and
/// again, and halves in which it hardly changes are left out.
fn jump(problem: &dyn Problem, (t, v): (f64, &[f64]), h: f64) -> Option<(f64, usize)> {
    let f = |t: f64, v: &[f64]| {
        let mut f = vec![0.0; v.len()];
        problem.ode().rhs(t, v, &mut f);
        f
    };
    let slope = f(t, v);
    let on_way = |s: f64| f(t + s * h, &v.iter().zip(&slope).map(|(x, f)| x + s * h * f).collect::<Vec<f64>>());
    let places: Vec<f64> = (0..=PARTS).map(|i| f64::from(i) * WAY / f64::from(PARTS)).collect();
    let values: Vec<Vec<f64>> = places.iter().map(|s| on_way(*s)).collect();
    let jumps = |k: usize| {
        let nothing = NOTHING * values.iter().map(|f| f[k].abs()).fold(0.0, larger);
        places.array_windows().zip(values.array_windows()).find_map(|(ends, [first, last]): (&[f64; 2], _)| {
            // A pulse within the part changes by more than from end to end.
            let mut largest = 0.0;
            let mut open = vec![(*ends, [first[k], last[k]], 0)];
            for _ in 0..LOOKED_AT {
                let ([start, end], rates, halvings) = open.pop()?;
                let change = (rates[1] - rates[0]).abs();
                if !change.is_finite() || change <= nothing || change < LEFT * largest {
                    continue;
                }
                largest = change.max(largest);
                if halvings == PIECES {
                    // Beside a pole it changes as much on either side.
                    let sides = [(on_way(start - (end - start)), rates[0]), (on_way(end + (end - start)), rates[1])];
                    if sides.iter().all(|(beside, rate)| (beside[k] - rate).abs() < CALM * change) {
                        return Some(end);
                    }
                } else {
                    let middle = 0.5 * (start + end);
                    let rate = on_way(middle)[k];
                    open.push(([middle, end], [rate, rates[1]], halvings + 1));
                    open.push(([start, middle], [rates[0], rate], halvings + 1));
                }
            }
            None
        })
    };
    let found = (0..v.len()).filter_map(|k| Some((jumps(k)?, k))).min_by(|a, b| a.0.total_cmp(&b.0));
    found.map(|(s, k)| (t + s * h, k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::solve::equation::model;

    /// v' turns by 1 where x, which goes on at a rate of 1, comes to 0.3; a change over 10⁻³ is none, nor one beyond one and a half steps.
    #[test]
    fn a_jump_is_found_on_the_way_of_a_step_alone() {
        let found = |rate: &str, h: f64| {
            jump(&model(&format!("u_i {{ v = 0, x = 0 }} F_i {{ {rate}, 1 }}")), (2.0, &[0.0, 0.0]), h)
        };
        let (t, k) = found("1 - heaviside(x - 0.3)", 0.25).expect("it jumps");
        assert!((t - 2.3).abs() < 1e-8 && k == 0, "{t} of {k}");
        let (t, k) = found("heaviside(t - 2.3)", 0.25).expect("it jumps in time");
        assert!((t - 2.3).abs() < 1e-8 && k == 0, "{t} of {k}");
        // Before a change that is larger, and steady.
        let (t, _) = found("30*max(x - 0.3, 0) + heaviside(x - 0.3)", 0.25).expect("it jumps");
        assert!((t - 2.3).abs() < 1e-8, "{t}");
        // Behind a change of a thousandth of it, in each of as many parts.
        let (t, _) = found("x + heaviside(x - 0.3)", 0.25).expect("it jumps");
        assert!((t - 2.3).abs() < 1e-8, "{t}");
        // In small units.
        let (t, _) = found("1e-4*heaviside(x - 0.3)", 0.25).expect("it jumps");
        assert!((t - 2.3).abs() < 1e-8, "{t}");
        for (rate, h) in [
            ("heaviside(t - 2.4)", 0.25),
            ("1 - heaviside(x - 0.3)", 0.19),
            ("tanh((x - 0.3)/1e-3)", 0.25),
            ("sqrt(abs(x - 0.3))", 0.25),
            ("copysign(pow(abs(x - 0.3), 1/3), x - 0.3)", 0.25),
            ("exp(20*x)", 0.25),
            ("1", 0.25),
            ("1/(x - 0.25)", 0.25),
            ("1e3*exp(-1e6*(x - 0.215)*(x - 0.215))", 0.25),
            ("sin(1e9*x)", 0.25),
        ] {
            assert_eq!(found(rate, h), None, "{rate}, {h}");
        }
    }

    /// Half of the step that is said to fail, and not a quarter, which leads on too.
    #[test]
    fn the_longest_shorter_step_that_leads_on_is_named() {
        let problem = model("u_i { v = 1 } F_i { -sqrt(v) }");
        let implicit = method::parse("implicit-euler").expect("registered");
        let leads = |step: f64| leads_to(&problem, &*implicit, State::new(0.0, vec![1.0]), step, 0.5);
        assert!(leads(0.25) && leads(0.125));
        let source = SolveError::Diverged { iterations: 2, increment: 1e-9 };
        let error = RunError::Step(StepError::Solve { t: 0.0, h: 0.5, source });
        let told = |v: f64| told(&problem, &*implicit, &error, (&[v], v)).unwrap_or_default();
        assert!(told(1.0).contains("steps of 0.250000 lead on"), "{}", told(1.0));
        // What is zero from the start has come to nothing.
        assert!(!told(0.0).contains("a rounding beside"), "{}", told(0.0));
    }

    #[test]
    fn a_state_that_is_a_rounding_of_what_it_was_is_named() {
        let problem = model("u_i { v = 1 } F_i { -sqrt(v) }");
        let implicit = method::parse("implicit-euler").expect("registered");
        let source = SolveError::Diverged { iterations: 2, increment: 1e-9 };
        let error = RunError::Step(StepError::Solve { t: 0.0, h: 0.5, source });
        let told = |v: f64, largest: f64| told(&problem, &*implicit, &error, (&[v], largest)).unwrap_or_default();
        for largest in [1e-3, 1.0, 1e3] {
            let is_named = |part: f64| told(part * f64::EPSILON * largest, largest).contains("a rounding beside");
            assert_eq!([0.9, 1.1].map(is_named), [true, false], "{largest}");
        }
    }

    /// v̇ = v² has a pole at t = 1, and no step leads from there to t = 2. An iteration that did not converge may be at fault for that itself.
    #[test]
    fn where_no_step_leads_on_that_is_told_of_a_branch_alone() {
        let problem = model("u_i { v = 1 } F_i { v*v }");
        let implicit = method::parse("implicit-euler").expect("registered");
        let told = |source| {
            let error = RunError::Step(StepError::Solve { t: 0.0, h: 2.0, source });
            told(&problem, &*implicit, &error, (&[1.0], 1.0))
        };
        for source in [SolveError::BranchLost { reached: 0.5 }, SolveError::OtherBranch] {
            let text = told(source).expect("a reason");
            assert!(text.starts_with("no steps down to 0.0312500 lead from there to t = 2:"), "{text}");
        }
        assert_eq!(told(SolveError::Diverged { iterations: 2, increment: 1e-9 }), None);
    }

    /// Of a component of 64 and of 65 that comes to rest where its rate has no derivative.
    #[test]
    fn of_a_large_system_nothing_is_looked_for() {
        let implicit = method::parse("implicit-euler").expect("registered");
        let error = RunError::Step(StepError::Solve { t: 0.0, h: 0.5, source: SolveError::OtherBranch });
        let is_told = |n: usize| {
            let others: String = (1..n).map(|k| format!(", w{k} = 0")).collect();
            let problem = model(&format!("u_i {{ v = 1{others} }} F_i {{ -sqrt(v){} }}", ", 0".repeat(n - 1)));
            let state = [vec![1.0], vec![0.0; n - 1]].concat();
            told(&problem, &*implicit, &error, (&state, 1.0)).is_some()
        };
        assert_eq!([DENSE, DENSE + 1].map(is_told), [true, false]);
    }

    /// v̇ = v(1 − v) beside a mode that decays: J is singular at v = ½.
    #[test]
    fn a_jacobian_that_becomes_singular_is_named_for_the_momentum_that_it_leaves_open() {
        let problem = model("u_i { v = 0.1, w = 1 } F_i { v*(1 - v), -w }");
        let source = SolveError::Diverged { iterations: 2, increment: 1e-9 };
        let error = RunError::Step(StepError::Solve { t: 0.0, h: 0.1, source });
        let told = |method: &str, v: f64| {
            let method = method::parse(method).expect("registered");
            told(&problem, &*method, &error, (&[v, 1.0], 1.0)).unwrap_or_default()
        };
        // From 0.49 it grows by 0.025 in a step.
        assert!(told("method-ii", 0.49).contains("comes to 0 near there"), "{}", told("method-ii", 0.49));
        assert!(!told("method-i", 0.49).contains("comes to 0"));
        assert!(!told("method-ii", 0.4).contains("comes to 0") && !told("method-ii", 0.51).contains("comes to 0"));
    }

    /// The product of 32 eigenvalues of about 10⁻¹² is below all doubles, and has a sign all the same.
    #[test]
    fn a_jacobian_becomes_singular_in_units_of_any_size() {
        let others = |entry: fn(usize) -> String| (1..32).map(entry).collect::<String>();
        let (start, rates) = (others(|k| format!(", w{k} = 1")), others(|k| format!(", -1e-12*w{k}")));
        let problem = model(&format!("u_i {{ v = 0.1{start} }} F_i {{ 1e-12*v*(1 - v){rates} }}"));
        let state = |v: f64| [vec![v], vec![1.0; 31]].concat();
        assert_eq!([0.49, 0.4, 0.51].map(|v| turns(&problem, (0.0, &state(v)), 1e11)), [true, false, false]);
    }

    /// At the end of a branch at t = 1, half-way through a step.
    #[test]
    fn a_kink_is_no_jump() {
        let jumps =
            |rate: &str| jumps_in_time(&model(&format!("u_i {{ x = 0 }} F_i {{ {rate} }}")), (0.5, &[0.0]), (0.5, 1.0));
        assert!(jumps("t + heaviside(t - 1)"));
        // By a tenth, in small units; and where there is nothing.
        assert!(jumps("1e-4 + 1e-5*heaviside(t - 1)") && !jumps("0*x"));
        assert!(!jumps("t + 9*max(t - 1, 0)") && !jumps("t"));
        // What f does behind a jump is no part of it.
        assert!(jumps("heaviside(t - 1)*(1 + 1e5*(t - 1))"));
        // Of a longer step the end is known to as many digits.
        let file = model("u_i { x = 0 } F_i { heaviside(t - 1.000003) }");
        assert!(jumps_in_time(&file, (-1.0, &[0.0]), (2.0, 4.0)));
    }
}
