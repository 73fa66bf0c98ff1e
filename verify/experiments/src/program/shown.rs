//! What runs of one program with several steps show of it without a reference: by the times that they reach, and by their first
//! steps.

use super::{Answer, ONE_RUN, are_one_run};
use crate::measure::decimal::{plain, trimmed};
use crate::measure::norm::{distance, max_norm};

/// Differences count above this many roundings of the values.
const ROUNDINGS: f64 = 100.0;
/// Orders of neighbouring pairs of runs that agree to this have settled.
const SETTLED: f64 = 0.25;
/// Coarse steps after which two runs may reach a time together first.
const LATEST: usize = 4;

/// What is odd about the runs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shown {
    /// In sentences.
    pub notes: Vec<String>,
    /// A start that limits the order, if the method's own is higher than what is found.
    pub start: Option<String>,
    /// Why the values at the ends of the runs cannot be compared, where they cannot.
    pub incomparable: Option<String>,
}

impl Shown {
    /// Looks at runs with the step of each, where it is the step that differs from run to run.
    #[must_use]
    pub fn by(runs: &[(Option<f64>, Answer)]) -> Self {
        let mut shown = Self::default();
        let ends = runs.iter().map(|(_, answer)| answer.end().0);
        let (first, last) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
        // A sum of steps may be off by rounding.
        if last - first > 1e-9 * last.abs() {
            shown.incomparable = Some(format!(
                "the runs end at times from t = {} to {}: their values belong to different times, which alone makes a difference \
                 of order 1",
                trimmed(first, 9),
                trimmed(last, 9)
            ));
        }
        shown.notes.extend(runs.iter().find_map(|(_, answer)| answer.few_digits()));
        let cut = runs.iter().find_map(|(h, answer)| h.and_then(|h| Some((h, answer.clipped(h)?))));
        shown.notes.extend(cut.map(|(h, part)| format!("with h = {} the last step was cut to {part:.3} h", plain(h))));
        let mut steps: Vec<(f64, &Answer)> = runs.iter().filter_map(|(h, answer)| Some(((*h)?, answer))).collect();
        steps.sort_by(|a, b| b.0.total_cmp(&a.0));
        if are_one_run(steps.iter().map(|(_, answer)| *answer)) {
            shown.incomparable = Some(ONE_RUN.into());
        } else if let Some(own) = own_steps(&steps) {
            shown.incomparable = shown.incomparable.or(Some(own));
        }
        if shown.incomparable.is_none()
            && let Some((start, end)) = start_up(&steps)
        {
            shown.start = Some(format!(
                "runs differ by order {start:.2} after their first steps, and by {end:.2} at the end, where a method gains a factor \
                 1/h on the way: a starting procedure limits the order, if the method's own is higher, or a solution that is not smooth at the \
                 start does"
            ));
        }
        shown
    }
}

/// What is to be said of runs whose steps are neither the ones asked for nor a part of them that is the same in all.
fn own_steps(runs: &[(f64, &Answer)]) -> Option<String> {
    let median = |answer: &Answer| {
        let mut steps: Vec<f64> = answer.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().filter(|_| steps.len() > 1)
    };
    let own: Vec<f64> = runs.iter().map(|(_, answer)| median(answer)).collect::<Option<_>>()?;
    let spread = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        (high > low * (1.0 + 1e-6)).then_some((low, high))
    };
    // Rows at times of their own, the same for all, tell nothing of the steps.
    spread(&mut own.iter().copied())?;
    let (low, high) = spread(&mut own.iter().zip(runs).map(|(own, (h, _))| own / h))?;
    Some(format!(
        "the rows of the runs are from {low:.3} h to {high:.3} h apart: the program takes other steps than it is asked for, and an \
         order in h is not one in its steps"
    ))
}

/// The orders of the differences of neighbouring runs, coarse to fine, where they first reach a time together and at the end; if
/// the former is not the higher one, as the error of a step is.
///
/// A step of a method of order p has an error of order p + 1, and N ∝ 1/h of them one of order p. A start of order q < p leaves
/// h^{q+1} after the first steps, and at the end no more and no less.
fn start_up(runs: &[(f64, &Answer)]) -> Option<(f64, f64)> {
    let pairs: Vec<_> = runs.windows(2).map(|pair| Pair::of(pair[0], pair[1])).collect::<Option<_>>()?;
    let alike = |a: &Pair, b: &Pair| (a.ratio - b.ratio).abs() < 1e-6 && a.steps == b.steps;
    let [.., coarse, middle, fine] = &pairs[..] else { return None };
    if pairs.array_windows().any(|[one, next]| !alike(one, next)) {
        return None;
    }
    let order = |difference: fn(&Pair) -> f64| {
        let of = |[one, next]: [&Pair; 2]| (difference(one) / difference(next)).ln() / one.ratio.ln();
        let [before, last] = [[coarse, middle], [middle, fine]].map(of);
        ((last - before).abs() <= SETTLED).then_some(last)
    };
    let (start, end) = (order(|pair| pair.start)?, order(|pair| pair.end)?);
    // An error that stands whatever the step is no start's, which leaves h at least.
    (start > 0.5 && start < end + 0.5).then_some((start, end))
}

/// Two runs beside each other.
#[derive(Debug)]
struct Pair {
    /// The coarser step over the finer one.
    ratio: f64,
    /// Coarse steps until they first reach a time together.
    steps: usize,
    /// How far they are apart there, and at the end.
    start: f64,
    end: f64,
}

impl Pair {
    /// Nothing if they reach no early time together, or differ by no more than rounding.
    fn of((coarse, one): (f64, &Answer), (fine, other): (f64, &Answer)) -> Option<Self> {
        let same = |t: f64| other.times.iter().position(|time| (time - t).abs() <= 1e-9 * t.abs());
        // The end is no start.
        let before_end = one.times.iter().enumerate().take(one.times.len() - 1);
        let after_start = before_end.filter(|(_, t)| **t > 0.0).take(LATEST);
        let (steps, at, beside) =
            after_start.enumerate().find_map(|(k, (at, t))| same(*t).map(|beside| (k + 1, at, beside)))?;
        let apart = |a: &[f64], b: &[f64]| {
            let difference = distance(a, b);
            (difference > ROUNDINGS * f64::EPSILON * max_norm(a)).then_some(difference)
        };
        let start = apart(&one.states[at], &other.states[beside])?;
        let end = apart(one.end().1, other.end().1)?;
        Some(Self { ratio: coarse / fine, steps, start, end })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Printed;
    use super::*;

    /// Runs on v' = −v to t = 1 that make an error of h^start in the first step and of h^p in each later one.
    fn runs(start: i32, p: i32, cut: bool) -> Vec<(Option<f64>, Answer)> {
        runs_of([0.1, 0.05, 0.025, 0.0125], start, p, cut)
    }

    /// The same with other steps.
    fn runs_of(steps: [f64; 4], start: i32, p: i32, cut: bool) -> Vec<(Option<f64>, Answer)> {
        let run = |h: f64| {
            let steps = (1.0 / h).ceil() as usize;
            let times: Vec<f64> = (0..=steps).map(|k| (k as f64 * h).min(if cut { 1.0 } else { f64::MAX })).collect();
            let mut v = 1.0;
            let mut states = vec![vec![v]];
            for (k, pair) in times.windows(2).enumerate() {
                v *= (pair[0] - pair[1]).exp();
                v += 0.1 * h.powi(if k == 0 { start } else { p });
                states.push(vec![v]);
            }
            (Some(h), Answer { times, states, printed: Printed::default(), clock: Printed::default() })
        };
        steps.map(run).to_vec()
    }

    fn answer(times: &[f64], values: &[f64]) -> Answer {
        let states = values.iter().map(|v| vec![*v]).collect();
        Answer { times: times.to_vec(), states, printed: Printed::default(), clock: Printed::default() }
    }

    /// To nine digits of the time.
    #[test]
    fn ends_are_at_the_same_time_but_for_roundings() {
        let incomparable = |end: f64| {
            let runs = [
                (Some(50.0), answer(&[0.0, 50.0, 100.0], &[1.0, 0.6, 0.4])),
                (Some(25.0), answer(&[0.0, end], &[1.0, 0.5])),
            ];
            Shown::by(&runs).incomparable.is_some()
        };
        assert_eq!([100.0 + 5e-8, 100.0 + 2e-7].map(incomparable), [false, true]);
    }

    /// The step of most rows, of which two are cut, as where a run stops on the way and at its end.
    #[test]
    fn the_step_of_a_run_is_the_median() {
        let cut = answer(&[0.0, 0.2, 0.4, 0.41, 0.61, 0.62], &[0.0; 6]);
        let whole = answer(&[0.0, 0.1, 0.2, 0.3, 0.4, 0.5], &[0.0; 6]);
        assert_eq!(own_steps(&[(0.2, &cut), (0.1, &whole)]), None);
    }

    #[test]
    fn runs_are_told_apart_where_they_first_meet() {
        let [coarse, fine] =
            [answer(&[0.0, 0.3, 0.6], &[1.0, 0.5, 0.2]), answer(&[0.0, 0.2, 0.4, 0.6], &[1.0, 0.6, 0.4, 0.3])];
        assert!(Pair::of((0.3, &coarse), (0.2, &fine)).is_none(), "at the end alone");
        let [coarse, fine] =
            [answer(&[0.0, 0.2, 0.4], &[1.0, 0.5, 0.2]), answer(&[0.0, 0.1, 0.2, 0.4], &[1.0, 0.9, 0.6, 0.3])];
        let pair = Pair::of((0.2, &coarse), (0.1, &fine)).expect("they meet");
        assert_eq!((pair.ratio, pair.steps), (2.0, 1));
        assert!((pair.start - 0.1).abs() < 1e-15 && (pair.end - 0.1).abs() < 1e-15);
    }

    #[test]
    fn a_start_of_low_order_is_named_and_no_other() {
        for (start, p, is_named) in
            [(2, 2, false), (3, 3, false), (5, 5, false), (2, 4, true), (3, 5, true), (2, 5, true)]
        {
            let shown = Shown::by(&runs(start, p, true));
            let named = shown.start.as_ref().is_some_and(|note| note.contains("a starting procedure limits the order"));
            assert_eq!(named, is_named, "{start}, {p}: {shown:?}");
            assert_eq!(shown.incomparable, None);
        }
        // Two steps of a ratio, runs at roundoff or their ends alone say nothing, nor does a last ratio of 3, which would be an order of 1.75 for 2.
        let ends = runs(2, 4, true).into_iter().map(|(h, run)| {
            let last = run.times.len() - 1;
            let [times, states] = [vec![0.0, run.times[last]], vec![run.states[0][0], run.states[last][0]]];
            (h, Answer { times, states: states.into_iter().map(|v| vec![v]).collect(), ..run })
        });
        // Nor do runs of which one shows its end alone, or all the start, of which nothing is to be compared.
        let ends: Vec<_> = ends.collect();
        let mut with_one_end = runs(2, 4, true);
        with_one_end[1] = ends[1].clone();
        let start = |(h, run): (Option<f64>, Answer)| (h, Answer { times: vec![0.0], states: vec![vec![1.0]], ..run });
        let starts: Vec<_> = runs(2, 4, true).into_iter().map(start).collect();
        for silent in [
            &runs(2, 4, true)[..3],
            &runs(20, 20, true),
            &ends,
            &with_one_end,
            &starts,
            &runs_of([0.004, 0.002, 0.001, 0.001 / 3.0], 2, 4, true),
        ] {
            assert_eq!(Shown::by(silent), Shown::default());
        }
    }

    #[test]
    fn a_start_of_low_order_is_named_in_whatever_units() {
        let named = Shown::by(&runs(2, 4, true));
        assert!(named.start.is_some());
        for unit in [1e-6, 1e6] {
            let in_unit = |(h, mut run): (Option<f64>, Answer)| {
                run.times.iter_mut().for_each(|t| *t *= unit);
                run.states.iter_mut().flatten().for_each(|v| *v *= unit);
                (h.map(|h| unit * h), run)
            };
            assert_eq!(Shown::by(&runs(2, 4, true).into_iter().map(in_unit).collect::<Vec<_>>()), named, "{unit}");
        }
    }

    #[test]
    fn values_with_few_digits_are_named() {
        let of = |digits: &str| {
            let mut runs = runs(2, 2, true);
            runs.iter_mut().for_each(|(_, answer)| answer.printed.see(digits));
            Shown::by(&runs).notes
        };
        assert_eq!((of("0.3333333333333333").len(), of("0.333333").len()), (0, 1));
    }

    #[test]
    fn ends_that_differ_make_values_incomparable() {
        let late = |h: f64| {
            (
                Some(h),
                Answer {
                    times: vec![0.0, h, 1.0 + h],
                    states: vec![vec![1.0]; 3],
                    printed: Printed::default(),
                    clock: Printed::default(),
                },
            )
        };
        for [one, other] in [[0.1, 0.05], [1e-6, 2e-6]] {
            let shown = Shown::by(&[late(one), late(other)]);
            assert!(shown.incomparable.is_some_and(|reason| reason.contains("different times")), "{one}, {other}");
        }
    }
}
