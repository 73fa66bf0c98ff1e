//! The order of a program of one's own on a problem.
//!
//! The first ladder of steps divides the time. Where the order is found there, a second one leaves half a step over, so that
//! the last step of a run is cut short: what is wrong with that step shows nowhere else.

use std::f64::consts::SQRT_2;

use rayon::prelude::*;

use super::{Ladder, OrderError, Source, Truth};
use crate::kinds::Principle;
use crate::measure::decimal::{decimals, plain, significant, trimmed};
use crate::measure::norm::{distance, max_norm};
use crate::measure::order::{self, Expectation, OrderFit, Sample, Verdict, fit};
use crate::measure::refinement::BAND;
use crate::problem::{Limit, Problem, Window, component_names};
use crate::program::{Answer, ONE_RUN, Program, ProgramError, Request, are_one_run, share_digits};
use crate::reference::bound::FINER;

/// Step sizes in a study of a program.
const PROGRAM_LADDER: usize = 9;
/// Half-width of the band around the order expected of a program.
const PROGRAM_BAND: f64 = 0.1;
/// Steps beyond the finest of the ladder where the slopes have not settled: an eighth of it.
const PROGRAM_FINER: usize = 6;
/// Numbers that the longest of these runs writes at most.
const MOST_WRITTEN: f64 = 1e5;
/// Times that the coarsest step is halved where runs are unstable.
const FINER_STARTS: i32 = 10;

/// Times that agree to this much, relative to the end, are one.
const ROUNDED_END: f64 = 1e-9;

/// The order of a program of one's own, and what its times, its first and its last steps show.
#[derive(Debug)]
pub struct Programs {
    /// The fit.
    pub fit: OrderFit,
    /// What was noticed: steps cut short, ends missed, a first or last step of a lower order.
    pub notes: Vec<String>,
}

/// A run with its step.
type Ran = (f64, Result<Answer, ProgramError>);
/// Times with the solution there and its bound.
type Solution = Vec<(f64, Vec<f64>, f64)>;

/// Measures the order of `program` on `problem`, which it knows by `request`, at the times that it really reaches.
///
/// # Errors
/// [`OrderError`] if there is no truth to measure against, or the program does not start or has another header. Runs that fail
/// are points that the fit drops, with the reason.
pub fn measure_program(
    problem: &dyn Problem,
    program: &Program,
    request: &Request,
    source: Option<Source>,
    ladder: &Ladder,
) -> Result<(Truth, Programs), OrderError> {
    let Window { horizon, coarsest } = problem.facts().window;
    let horizon = request.t_end.unwrap_or(horizon);
    ladder.check(horizon)?;
    let limit = problem.limit(Principle::Equation);
    let truth = source.unwrap_or_else(|| Source::at_hand(problem, &limit, horizon)).of(problem, horizon);
    let study = Study { problem, limit, horizon, program, request, source, ladder, names: component_names(problem) };
    let steps = |coarsest: f64| order::ladder(horizon, coarsest, SQRT_2, ladder.points.unwrap_or(PROGRAM_LADDER));

    let asked = ladder.coarsest.unwrap_or(coarsest);
    let divisors = steps(asked);
    // What the first run does wrong whatever the step, the others would repeat.
    let first = divisors.first().map(|h| (*h, study.run(*h)));
    if let Some((_, Err(error))) = &first
        && error.is_of_every_run()
    {
        return Err(OrderError::Program { problem: request.problem.clone(), source: error.clone() });
    }
    // Runs in smaller steps take longer.
    let timed_out =
        first.as_ref().and_then(|(_, ran)| ran.as_ref().err()).filter(|e| matches!(e, ProgramError::TimedOut(_)));
    let others: Vec<Ran> = match timed_out.cloned() {
        Some(error) => divisors[1..].iter().map(|h| (*h, Err(error.clone()))).collect(),
        None => divisors.par_iter().skip(1).map(|h| (*h, study.run(*h))).collect(),
    };
    let mut answers: Vec<Ran> = first.into_iter().chain(others).collect();
    share(&mut answers);
    let (mut truth, mut fit) = study.fit(truth, &answers, ladder.expected)?;
    let mut notes = Vec::new();
    if study.is_unstable(truth, &fit) {
        let stable = (1..=FINER_STARTS).map(|k| asked * 0.5_f64.powi(k)).find(|h| {
            let probe = study.fit(truth, &[(*h, study.run(*h))], ladder.expected);
            probe.is_ok_and(|(_, fit)| !study.is_unstable(truth, &fit))
        });
        if let Some(start) = stable.filter(|_| ladder.coarsest.is_none()) {
            answers = study.runs(&steps(start));
            (truth, fit) = study.fit(truth, &answers, ladder.expected)?;
            notes.push(format!(
                "coarse runs are unstable: the steps start at h = {} instead of {}",
                plain(start),
                plain(asked)
            ));
        } else if problem.is_stiff() || stable.is_some() {
            fit.verdict = Verdict::Inconclusive;
            fit.reason = format!(
                "coarse runs are unstable, with errors above the solution itself: smaller steps would tell{}",
                stable.map_or_else(String::new, |h| format!(", from `--coarsest {}` on", plain(h)))
            );
        }
    }
    let coarsest = answers.first().map_or(asked, |(h, _)| *h);
    let finer = order::ladder(horizon, coarsest, SQRT_2, PROGRAM_LADDER + PROGRAM_FINER);
    let written = finer.last().map_or(f64::INFINITY, |h| written(horizon, *h, study.names.len()));
    let is_own = ladder.coarsest.is_none() && ladder.points.is_none();
    if is_own && fit.wants_finer() && written <= MOST_WRITTEN {
        answers.extend(study.runs(&finer[answers.len()..]));
        share(&mut answers);
        (truth, fit) = study.fit(truth, &answers, ladder.expected)?;
    }
    if answers.iter().all(|(_, answer)| answer.is_ok())
        && are_one_run(answers.iter().filter_map(|(_, answer)| answer.as_ref().ok()))
    {
        fit.verdict = Verdict::Inconclusive;
        fit.reason = ONE_RUN.into();
        return Ok((truth, Programs { fit, notes }));
    }
    let mut cut = Vec::new();
    if matches!(fit.verdict, Verdict::Pass | Verdict::Measured) {
        cut = study.runs(&answers.iter().map(|(h, _)| leaving_half(horizon, *h)).collect::<Vec<_>>());
        notes.extend(study.judge_cut(truth, &cut, &mut fit)?);
    }
    let ok = || answers.iter().chain(&cut).filter_map(|(h, answer)| Some((*h, answer.as_ref().ok()?)));
    notes.extend(ok().find_map(|(_, answer)| answer.few_digits()));
    let ends = ok().map(|(h, answer)| (h, answer.end().0, (answer.end().0 - horizon).abs()));
    let farthest = ends.max_by(|(h, _, off), (other, _, of_other)| (off / h).total_cmp(&(of_other / other)));
    if let Some((h, t, off)) = farthest.filter(|(_, _, off)| *off > ROUNDED_END * horizon) {
        // Ends within a step of the time come nearer to it as steps do.
        let within_a_step = ok().all(|(h, answer)| (answer.end().0 - horizon).abs() <= h * (1.0 + ROUNDED_END));
        let missed = format!(
            "with h = {} it ended at t = {}, {} too {}: the order is that of the errors at the times it reached; taken for \
             values at t = {} they {}",
            plain(h),
            trimmed(t, 9),
            significant(off, 3),
            if t > horizon { "late" } else { "early" },
            plain(horizon),
            if within_a_step { "are of order 1" } else { "are those of another time" }
        );
        // Whole steps alone lead to within one of the end. Farther off is not the run that was asked for.
        if off > (1.0 - ROUNDED_END) * h && matches!(fit.verdict, Verdict::Pass | Verdict::Measured) {
            fit.verdict = Verdict::Inconclusive;
            fit.reason = format!("{}, but the end is missed: {missed}", fit.reason);
        } else {
            notes.push(missed);
        }
    }
    if let Some(start) = study.start(&answers) {
        notes.push(start);
        return Ok((truth, Programs { fit, notes }));
    }
    notes.extend(study.first_step(truth, &answers, &fit));
    // Where the solution is slaved to something, the error of a step depends on its own length.
    if !problem.is_stiff() {
        notes.extend([&answers, &cut].into_iter().find_map(|ran| study.last_step(truth, ran)));
    }
    Ok((truth, Programs { fit, notes }))
}

/// What all runs of a study share.
struct Study<'a> {
    problem: &'a dyn Problem,
    limit: Limit<'a>,
    horizon: f64,
    program: &'a Program,
    request: &'a Request,
    source: Option<Source>,
    ladder: &'a Ladder,
    names: Vec<String>,
}

impl Study<'_> {
    fn run(&self, h: f64) -> Result<Answer, ProgramError> {
        let request = Request { h: Some(h), t_end: Some(self.horizon), ..self.request.clone() };
        self.program.run(&request, &self.names)
    }

    fn runs(&self, steps: &[f64]) -> Vec<Ran> {
        let mut ran = steps.par_iter().map(|h| (*h, self.run(*h))).collect::<Vec<_>>();
        share(&mut ran);
        ran
    }

    fn band(&self) -> f64 {
        self.ladder.band.unwrap_or(PROGRAM_BAND)
    }

    /// What the program shows of the solution at `times`, with its bound.
    fn solution(&self, truth: Truth, times: &[f64], tolerance: Option<f64>) -> Result<Solution, OrderError> {
        let states = truth.solution(self.problem, &self.limit, times, tolerance)?;
        let seen = |(t, (state, bound)): (&f64, (Vec<f64>, f64))| (*t, self.problem.observe(*t, &state), bound);
        Ok(times.iter().zip(states).map(seen).collect())
    }

    /// The order of the errors at the ends of runs; with another truth where a table does not know their times.
    fn fit(&self, truth: Truth, answers: &[Ran], expected: Option<f64>) -> Result<(Truth, OrderFit), OrderError> {
        let end = |answer: &Answer| reached(answer.end().0, self.horizon);
        let ends = increasing(answers.iter().filter_map(|(_, answer)| Some(end(answer.as_ref().ok()?))));
        let solve = |truth: Truth| Ok((truth, self.solution(truth, &ends, self.ladder.tolerance)?));
        let (truth, states) = match solve(truth) {
            Err(OrderError::NoExact) if self.source.is_none() => {
                solve(Source::library().of(self.problem, self.horizon))?
            }
            solved => solved?,
        };
        let fitted = |states: &Solution| {
            let sample = |(h, answer): &Ran| match answer {
                Err(reason) => Sample::failed(*h, reason.to_string()),
                Ok(answer) => match states.iter().find(|(t, ..)| *t == end(answer)) {
                    Some((_, exact, bound)) => {
                        let size = max_norm(exact);
                        let rounding = answer.printed.epsilon() * size * (self.horizon / h);
                        let floor = bound + rounding + answer.printed.resolution(size);
                        Sample::new(*h, distance(answer.end().1, exact), floor)
                    }
                    None => Sample::failed(*h, "it took no step"),
                },
            };
            let samples: Vec<Sample> = answers.iter().map(sample).collect();
            match expected {
                Some(order) => fit(&samples, &Expectation::new(order, self.band())),
                None => order::fit_freely(&samples, self.band()),
            }
        };
        let found = fitted(&states);
        if truth.may_be_finer(&found, self.ladder)
            && let Ok(finer) = self.solution(truth, &ends, Some(FINER))
        {
            return Ok((truth, fitted(&finer)));
        }
        Ok((truth, found))
    }

    /// Whether the errors are larger than the solution, or overflow, from the coarsest step to the finest: what fails in fine steps alone
    /// fails for another reason.
    fn is_unstable(&self, truth: Truth, fit: &OrderFit) -> bool {
        if fit.verdict == Verdict::Pass {
            return false;
        }
        let end = self.solution(truth, &[self.horizon], self.ladder.tolerance).unwrap_or_default();
        let start = self.problem.observe(0.0, &self.limit.initial);
        let size = end.first().map_or(0.0, |(_, state, _)| max_norm(state)).max(max_norm(&start));
        // NaN is within nothing.
        let holds = |sample: &Sample| sample.result.as_ref().is_ok_and(|measured| measured.error <= 10.0 * size);
        let points = fit.points();
        points.iter().any(|(sample, _)| sample.result.is_ok())
            && [points.first(), points.last()].into_iter().flatten().all(|(sample, _)| !holds(sample))
    }

    /// Judges runs whose last step is half a step long, into `fit`, which holds for those of whole steps.
    fn judge_cut(&self, truth: Truth, cut: &[Ran], fit: &mut OrderFit) -> Result<Option<String>, OrderError> {
        if let Some((_, Err(error))) = cut.first()
            && cut.iter().all(|(_, answer)| answer.is_err())
        {
            return Ok(Some(format!("with steps that do not divide the time no run succeeds: {error}")));
        }
        let whole = fit.line.map(|line| line.slope);
        let (_, mut found) = self.fit(truth, cut, self.ladder.expected.or(whole))?;
        let clipped = cut.iter().find_map(|(h, answer)| Some((*h, answer.as_ref().ok()?.clipped(*h)?)));
        if found.verdict == Verdict::Pass {
            return Ok(clipped.map(|(h, part)| {
                let order = found.line.map_or_else(String::new, |line| decimals(line.slope, 3));
                let at = format!("with h = {} to {part:.3} h", plain(h));
                format!("where h does not divide the time the last step is cut, {at}; the order is {order} there")
            }));
        }
        let expects = self.ladder.expected.is_some();
        let because = match (whole, &found.reason) {
            (Some(whole), reason) if expects => format!("{reason}; where it does the order is {}", decimals(whole, 3)),
            (Some(whole), _) => {
                let order = found.line.map_or_else(|| "not told".into(), |line| decimals(line.slope, 3));
                format!("the order is {order}, and where it does {}", decimals(whole, 3))
            }
            (None, reason) => reason.clone(),
        };
        let cut = if clipped.is_some() { ", and the last step is cut" } else { "" };
        found.reason = format!("where h does not divide the time{cut}: {because}");
        found.verdict = if expects { found.verdict } else { Verdict::Inconclusive };
        *fit = found;
        Ok(None)
    }

    /// What to measure steps at other times than the end by.
    fn between(&self, truth: Truth) -> Truth {
        match truth {
            // A table knows the horizon alone.
            Truth::Tabulated => Source::library().of(self.problem, self.horizon),
            truth => truth,
        }
    }

    /// A note where the program starts from another state than the problem.
    fn start(&self, answers: &[Ran]) -> Option<String> {
        let exact = self.problem.observe(0.0, &self.limit.initial);
        let (_, answer) = answers.iter().find(|(_, answer)| answer.is_ok())?;
        let answer = answer.as_ref().ok().filter(|answer| answer.times[0] == 0.0)?;
        let found = &answer.states[0];
        let close = |x: f64| answer.printed.resolution(x) + answer.printed.epsilon() * x.abs();
        let i = (0..exact.len()).find(|i| (found[*i] - exact[*i]).abs() > 2.0 * close(exact[*i]))?;
        let (name, told) = (&self.names[i], |digits| [found[i], exact[i]].map(|x| trimmed(x, digits)));
        let [found, exact] = [9, 17].map(told).into_iter().find(|[found, exact]| found != exact)?;
        Some(format!("its row at t = 0 has {name} = {found}, where the problem starts from {name} = {exact}"))
    }

    /// A note where the first step limits the order that was found.
    fn first_step(&self, truth: Truth, answers: &[Ran], fit: &OrderFit) -> Option<String> {
        let ok = || answers.iter().filter_map(|(h, answer)| Some((*h, answer.as_ref().ok()?)));
        let first =
            |answer: &Answer| answer.times.iter().position(|t| *t > 0.0).filter(|at| *at + 1 < answer.times.len());
        let firsts = increasing(ok().filter_map(|(_, answer)| Some(answer.times[first(answer)?])));
        // Without a solution there the first steps are not judged.
        let near = self.solution(self.between(truth), &firsts, self.ladder.tolerance).ok()?;
        let start = |(h, answer): (f64, &Answer)| {
            let at = first(answer)?;
            let (_, exact, bound) = near.iter().find(|(t, ..)| *t == answer.times[at])?;
            let size = max_norm(exact);
            let floor = bound + answer.printed.epsilon() * size + answer.printed.resolution(size);
            Some(Sample::new(h, distance(&answer.states[at], exact), floor))
        };
        let starts: Vec<Sample> = ok().filter_map(start).collect();
        let local = order::fit_freely(&starts, self.band());
        let (start, line) = (local.line.filter(|_| local.verdict == Verdict::Measured)?, fit.line?);
        // A step of order p has a local error of order p + 1; one of order p starts a method of order p.
        let lowers = self.ladder.expected.is_none_or(|order| line.slope < order - self.band());
        // An error that stands whatever the step is no start's, which leaves h at least.
        (lowers && start.slope > 0.5 && start.slope < line.slope + 0.5).then(|| {
            let condition = if self.ladder.expected.is_some() { "" } else { ", if the method's own is higher" };
            format!(
                "the first step has an error of order {:.2}, and what follows {:.2}: a starting procedure limits the \
                 order{condition}, or stiffness lowers that of every step",
                start.slope, line.slope
            )
        })
    }

    /// A note where the error grows by a lower order in the last step than in the one before it.
    fn last_step(&self, truth: Truth, answers: &[Ran]) -> Option<String> {
        let ok = || answers.iter().filter_map(|(h, answer)| Some((*h, answer.as_ref().ok()?)));
        let ok = || ok().filter(|(_, answer)| answer.times.len() > 3);
        let time = |t: f64| reached(t, self.horizon);
        let last = |answer: &Answer| answer.times[answer.times.len() - 3..].to_vec();
        let times = increasing(ok().flat_map(|(_, answer)| last(answer)).map(time));
        let exact = self.solution(self.between(truth), &times, self.ladder.tolerance).ok()?;
        // The order of what a step adds to the error, and how much it is in the finest run.
        let gain = |back: usize| {
            let gained = |(h, answer): (f64, &Answer)| {
                let error = |back: usize| {
                    let at = answer.times.len() - 1 - back;
                    let (_, exact, bound) = exact.iter().find(|(t, ..)| *t == time(answer.times[at]))?;
                    let size = max_norm(exact);
                    let floor = bound + answer.printed.epsilon() * size + answer.printed.resolution(size);
                    Some((answer.states[at].iter().zip(exact).map(|(a, b)| a - b).collect::<Vec<f64>>(), floor))
                };
                let ((after, one), (before, other)) = (error(back)?, error(back + 1)?);
                Some(Sample::new(h, distance(&after, &before), one + other))
            };
            let found = order::fit_freely(&ok().filter_map(gained).collect::<Vec<_>>(), 2.0 * BAND);
            let line = found.line.filter(|_| found.verdict == Verdict::Measured)?;
            Some((line.slope, found.kept.last()?.result.as_ref().ok()?.error))
        };
        let ((last, error), (before, other)) = (gain(0)?, gain(1)?);
        // A step of order p has a local error of order p + 1: it lowers no order up to p.
        let lowers = self.ladder.expected.is_none_or(|order| last < order + 1.0 - self.band());
        // Orders of steps of one method differ too, where the motion changes; their errors do not by much.
        (lowers && last < before - 0.5 && error > 2.0 * other).then(|| {
            // Of a consistent method the error of a step is of second order at least.
            let why = if last < 1.5 {
                "it is longer or shorter than the time that it ends at says, or not consistent"
            } else {
                "it is taken by a method of lower order"
            };
            format!("the last step has an error of order {last:.2}, and the one before it {before:.2}: {why}")
        })
    }
}

/// The step a little shorter than `h` half of which is left over at the end.
fn leaving_half(horizon: f64, h: f64) -> f64 {
    horizon / ((horizon / h).round() + 0.5)
}

/// The numbers that a run in steps of `h` writes, so many in each row.
fn written(horizon: f64, h: f64, columns: usize) -> f64 {
    horizon / h * columns as f64
}

/// Digits that one run shows, all have.
fn share(ran: &mut [Ran]) {
    share_digits(ran.iter_mut().filter_map(|(_, answer)| answer.as_mut().ok()));
}

/// The time `t` that a run ended at, without the rounding of a sum of steps that should be `horizon`.
fn reached(t: f64, horizon: f64) -> f64 {
    if (t - horizon).abs() <= 1e-12 * horizon { horizon } else { t }
}

/// Positive times in order, each once.
fn increasing(times: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut times: Vec<f64> = times.filter(|t| *t > 0.0).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::program::Printed;

    /// A table knows the time that runs are to end at; where one ends elsewhere a library stands in, unless the table was asked for.
    #[test]
    fn a_library_stands_in_where_a_table_does_not_know_the_end_of_a_run() {
        let problem = crate::problem::small("robertson").expect("a problem");
        let horizon = problem.facts().window.horizon;
        let program = Program::new("none", Duration::from_secs(1)).expect("a command");
        let (request, ladder, problem) = (Request::default(), Ladder::default(), &*problem);
        let of = |source: Option<Source>, end: f64| {
            let (limit, names) = (problem.limit(Principle::Equation), component_names(problem));
            let study =
                Study { problem, limit, horizon, program: &program, request: &request, source, ladder: &ladder, names };
            let (printed, clock) = (Printed::default(), Printed::default());
            let answer = Answer { times: vec![0.0, end], states: vec![problem.initial(); 2], printed, clock };
            study.fit(Truth::Tabulated, &[(0.1 * horizon, Ok(answer))], None).map(|(truth, _)| truth)
        };
        for source in [None, Some(Source::Exact)] {
            assert!(matches!(of(source, horizon), Ok(Truth::Tabulated)), "{source:?}");
        }
        assert!(matches!(of(None, 0.9 * horizon), Ok(Truth::Numerical(_))));
        assert!(matches!(of(Some(Source::Exact), 0.9 * horizon), Err(OrderError::NoExact)));
    }

    /// What a study to t = 1 makes of v̇ = −v.
    fn on_drag<T>(v0: f64, ladder: &Ladder, ask: impl FnOnce(&Study<'_>) -> T) -> T {
        let problem = crate::problem::build("linear-drag", &[("v0".into(), v0.to_string())]).expect("known");
        let program = Program::new("none", Duration::from_secs(1)).expect("a command");
        let (request, problem) = (Request::default(), &*problem);
        let (limit, names) = (problem.limit(Principle::Equation), component_names(problem));
        let (program, request) = (&program, &request);
        ask(&Study { problem, limit, horizon: 1.0, program, request, source: None, ladder, names })
    }

    /// Runs in steps of h = 1/n with errors e(k, n) of v₀ after k of them.
    fn with_errors(v0: f64, printed: Printed, error: impl Fn(usize, usize) -> f64) -> Vec<Ran> {
        let run = |n: usize| {
            let times: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
            let off = |k: usize| if k == 0 { 0.0 } else { error(k, n) };
            let states = times.iter().enumerate().map(|(k, t)| vec![v0 * ((-t).exp() + off(k))]).collect();
            (1.0 / n as f64, Ok(Answer { times, states, printed, clock: Printed::default() }))
        };
        [8, 16, 32, 64, 128].map(run).to_vec()
    }

    /// How a program prints that writes such numbers.
    fn printed(number: &str) -> Printed {
        let program = Program::new(&format!("printf 't,v\\n0,{number}\\n'"), Duration::from_secs(60));
        program.and_then(|program| program.run(&Request::default(), &["v".into()])).expect("a table").printed
    }

    #[test]
    fn a_first_step_limits_the_order_where_its_error_is_less_than_an_order_smaller() {
        let full = Printed::default();
        let told = |v0: f64, printed: Printed, expected: Option<f64>, first: &dyn Fn(f64) -> f64| {
            let ladder = Ladder { expected, ..Ladder::default() };
            let answers = with_errors(v0, printed, |k, n| {
                let h = 1.0 / n as f64;
                if k == 1 { first(h) } else { 10.0 * h * h }
            });
            on_drag(v0, &ladder, |study| {
                let (truth, fit) = study.fit(Truth::Exact, &answers, expected).expect("a fit");
                study.first_step(truth, &answers, &fit)
            })
        };
        let of_order = |q: f64| move |h: f64| 10.0 * h.powf(q);
        for (q, is_told) in [(2.0, true), (2.4, true), (2.6, false), (3.0, false)] {
            for v0 in [1.0, 1e-6] {
                assert_eq!(told(v0, full, None, &of_order(q)).is_some(), is_told, "{q}, {v0}");
            }
        }
        let note = told(1.0, full, None, &of_order(2.0)).expect("it limits the order");
        assert!(
            note.contains("an error of order 2.00, and what follows 2.00")
                && note.contains("own is higher, or stiffness"),
            "{note}"
        );
        // What has the order that is expected is not limited.
        let by = [2.0, 2.05, 2.2, 4.0].map(|expected| told(1.0, full, Some(expected), &of_order(2.0)));
        assert_eq!([true, true, false, false], by.each_ref().map(Option::is_none));
        assert!(by.iter().flatten().all(|note| note.contains("limits the order, or stiffness")), "{by:?}");
        // Of what digits or roundings hide nothing is told.
        let digits = printed("0.123456");
        assert!(told(1.0, digits, None, &of_order(2.0)).is_some());
        assert_eq!([told(1.0, digits, None, &|_| 2e-6), told(1.0, full, None, &|_| 1e-15)], [None, None]);
        // Nor of an end.
        let ends = |(h, run): Ran| {
            let mut run = run.expect("it ran");
            let inner = 1..run.times.len() - 1;
            run.times.drain(inner.clone());
            run.states.drain(inner);
            (h, Ok(run))
        };
        let answers: Vec<Ran> = with_errors(1.0, full, |_, n| 10.0 / (n * n) as f64).into_iter().map(ends).collect();
        on_drag(1.0, &Ladder::default(), |study| {
            let (truth, fit) = study.fit(Truth::Exact, &answers, None).expect("a fit");
            assert!(fit.line.is_some() && study.first_step(truth, &answers, &fit).is_none());
        });
    }

    #[test]
    fn a_last_step_is_told_whose_error_is_of_a_lower_order_and_larger_than_that_of_the_one_before() {
        // Steps of a method of order 2, with errors of c h³ each, up to the last.
        let told_of = |v0: f64, printed: Printed, c: f64, last: &dyn Fn(f64) -> f64| {
            let answers = with_errors(v0, printed, |k, n| {
                let h = 1.0 / n as f64;
                let before = |k: usize| c * h.powi(3) * k as f64;
                if k == n { before(n - 1) + last(h) } else { before(k) }
            });
            on_drag(v0, &Ladder::default(), |study| study.last_step(Truth::Exact, &answers))
        };
        let (full, digits) = (Printed::default(), printed("0.123456"));
        let told = |v0: f64, last: &dyn Fn(f64) -> f64| told_of(v0, full, 0.1, last);
        let of_order = |q: f64| move |h: f64| h.powf(q);
        for v0 in [1.0, 1e-6] {
            for (q, why) in
                [(1.0, "not consistent"), (1.4, "not consistent"), (1.6, "of lower order"), (2.4, "of lower order")]
            {
                let note = told(v0, &of_order(q));
                assert!(note.as_ref().is_some_and(|note| note.ends_with(why)), "{q}, {v0}: {note:?}");
            }
            assert_eq!([2.6, 3.0, 4.0].map(|q| told(v0, &of_order(q))), [None, None, None], "{v0}");
        }
        let note = told(1.0, &of_order(2.0)).expect("it is of lower order");
        assert!(note.contains("an error of order 2.00, and the one before it 3.00"), "{note}");
        // Beside the finest step before, of 128 in all, its error is three times or one and a half times as large.
        for (times, is_told) in [(3.0, true), (1.5, false)] {
            assert_eq!(told(1.0, &|h| 0.1 * times / 128.0 * h * h).is_some(), is_told, "{times}");
        }
        // A higher order is no lower one, however large the error.
        assert_eq!(told(1.0, &|h| 1e4 * h.powi(4)), None);
        // What digits hide tells nothing, nor does what has no order.
        assert_eq!(told_of(1.0, digits, 0.1, &|_| 3e-6), None);
        assert!(told_of(1.0, digits, 1e4, &|h| 1e5 * h * h).is_some());
        // Nor what roundings hide: 9 ε of each of two values of e⁻¹, of which ten times is 1.5e-14.
        assert_eq!(told_of(1.0, full, 8.4e-9, &|h| 1e-14 * (128.0 * h).powf(0.4)), None);
        let up_and_down = |h: f64| h * h * if (1.0 / h).log2().round() % 2.0 == 0.0 { 1.15 } else { 0.85 };
        assert_eq!(told(1.0, &up_and_down), None);
    }

    /// To within two roundings of each component, whatever its size.
    #[test]
    fn a_start_elsewhere_is_told() {
        let model =
            crate::problem::model::Model::of_text("u_i { z = 0, x = 1000, y = 0.001 } F_i { z, x, y }", &[], Some(1.0))
                .expect("a model");
        let program = Program::new("none", Duration::from_secs(1)).expect("a command");
        let (request, ladder) = (Request::default(), Ladder::default());
        let (limit, names) = (model.limit(Principle::Equation), component_names(&model));
        let study = Study {
            problem: &model,
            limit,
            horizon: 1.0,
            program: &program,
            request: &request,
            source: None,
            ladder: &ladder,
            names,
        };
        let told = |off: [f64; 2], printed: Printed| {
            let (times, clock) = (vec![0.0], Printed::default());
            let states = vec![vec![0.0, 1000.0 * (1.0 + off[0]), 0.001 * (1.0 + off[1])]];
            study.start(&[(0.1, Ok(Answer { times, states, printed, clock }))])
        };
        let full = Printed::default();
        for roundings in [0.0, 1.0, -1.0].map(|k| k * f64::EPSILON) {
            assert_eq!([told([roundings, 0.0], full), told([0.0, roundings], full)], [None, None], "{roundings:e}");
        }
        for off in [8.0 * f64::EPSILON, -1e-6] {
            let [x, y] = [told([off, 0.0], full), told([0.0, off], full)];
            assert!(x.is_some_and(|note| note.contains(" x = ")) && y.is_some_and(|note| note.contains(" y = ")));
        }
        // Three decimals hide half a thousandth.
        assert_eq!(told([4e-7, 0.4], printed("1000.123")), None);
        assert!(told([2e-6, 0.0], printed("1000.123")).is_some());
    }

    #[test]
    fn runs_are_unstable_whose_errors_are_above_ten_times_the_solution() {
        for v0 in [100.0, 1e-3] {
            for (part, expected) in [(9.0, false), (11.0, true)] {
                let answers = with_errors(v0, Printed::default(), |_, _| part);
                let found = on_drag(v0, &Ladder::default(), |study| {
                    let (truth, fit) = study.fit(Truth::Exact, &answers, None).expect("a fit");
                    study.is_unstable(truth, &fit)
                });
                assert_eq!(found, expected, "{v0}, {part}");
            }
        }
    }

    #[test]
    fn times_are_those_of_the_end_but_for_roundings_and_positive() {
        for horizon in [1e-3, 1.0, 1e3] {
            for off in [0.0, 1e-13, -1e-13] {
                assert_eq!(reached(horizon * (1.0 + off), horizon), horizon);
            }
            for off in [1e-9, -1e-9] {
                let t = horizon * (1.0 + off);
                assert_eq!(reached(t, horizon), t);
            }
        }
        assert_eq!(increasing([0.5, 0.0, 1.0, 0.25, 0.5].into_iter()), [0.25, 0.5, 1.0]);
    }

    #[test]
    fn half_a_step_is_left_over_by_shorter_steps() {
        assert_eq!([1.0, 0.5, 0.125].map(|h| 2.0 / leaving_half(2.0, h)), [2.5, 4.5, 16.5]);
    }

    /// Euler's method on v̇ = −v/T to a part of the time T asked for, with a last step that is cut, and times that are off by a part.
    #[cfg(unix)]
    fn measured_to(time: f64, part: f64, off: f64) -> Programs {
        let script = format!(
            "BEGIN {{ for (i = 1; i < ARGC; i++) {{ if (ARGV[i] == \"--h\") h = ARGV[i + 1]; if (ARGV[i] == \"--t-end\") T = ARGV[i + 1] }} \
             print \"t,v\\n0,1\"; t = 0; v = 1; T *= {part}; \
             while (t < T) {{ s = t + h < T * (1 - 1e-9) ? h : T - t; v -= v * s / {time}; t = s < h ? T : t + s; if (t > T * (1 - 1e-9)) t = T; \
             printf \"%.17g,%.17g\\n\", t * (1 + {off}), v }} }}"
        );
        let program = Program::new(&format!("awk '{script}'"), Duration::from_secs(60)).expect("a command");
        let rate = (1.0 / time).to_string();
        let problem = crate::problem::build("linear-drag", &[("lambda".into(), rate)]).expect("known");
        let request = Request { t_end: Some(time), ..Request::default() };
        let ladder = Ladder { coarsest: Some(0.03125 * time), points: Some(5), ..Ladder::default() };
        measure_program(&*problem, &program, &request, None, &ladder).expect("it runs").1
    }

    #[test]
    #[cfg(unix)]
    fn an_end_that_is_missed_is_told_with_the_steps_that_miss_it_by_most_of_them() {
        // A rounding of the end is none, in whatever units.
        for time in [1.0, 1000.0] {
            let Programs { fit, notes } = measured_to(time, 1.0, 1e-11);
            assert_eq!(fit.verdict, Verdict::Measured, "{}", fit.reason);
            assert!(notes.iter().all(|note| !note.contains("it ended at")), "{notes:?}");
            let Programs { fit, .. } = measured_to(time, 0.9, 0.0);
            assert!(
                fit.verdict == Verdict::Inconclusive && fit.reason.contains("but the end is missed"),
                "{}",
                fit.reason
            );
            let finest = fit.points().last().expect("five runs").0.h;
            let named = fit.reason.split_once("with h = ").and_then(|(_, rest)| rest.split_once(' '));
            let named: f64 = named.and_then(|(h, _)| h.parse().ok()).expect("a step");
            assert!(named <= finest && named > 0.9 * finest, "{}", fit.reason);
        }
    }

    #[test]
    fn a_run_writes_a_row_for_each_step() {
        assert_eq!(written(2.0, 0.25, 3), 24.0);
    }

    #[test]
    fn all_runs_have_the_digits_of_one() {
        let mut runs = with_errors(1.0, Printed::default(), |_, _| 0.0);
        let digits = printed("0.123456");
        runs[2].1.as_mut().expect("it ran").printed = digits;
        share(&mut runs);
        assert!(runs.iter().all(|(_, run)| run.as_ref().is_ok_and(|run| run.printed == digits)));
    }
}
