//! Two-dimensional flows.

pub mod against_cvode;
pub mod approach;
pub mod cost;
pub mod identities;
pub mod lid;
pub mod order;
pub mod periodic;
pub mod precision;
pub mod profile;
mod projection;
pub mod propagator;
pub mod refinement;
pub mod spurious;
pub mod steady;
pub mod stops;

use cpu_time::ThreadTime;
use lsvi::Work;

use super::StudyError;
use crate::measure::norm::Extremes;
use crate::method::{self, Method};
use crate::problem::{self, Problem, flow};
use crate::run::{Run, run};
use projection::Projection;

/// The name of incremental pressure correction among those of methods.
pub const PROJECTION: &str = "pressure-correction";

/// What a run costs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// Linear systems of the size of the flow that were solved, one for each linearisation.
    pub solves: u64,
    /// Iterations inside of those: of conjugate gradients in Gauss–Newton steps, of GMRES in implicit stages and in closures between Method I's and
    /// Method II's; none where factors solve, as in pressure correction, in Galerkin integrators and in Method II between walls.
    pub inner: u64,
    /// Evaluations of the equations of a step, with one of f each.
    pub residuals: u64,
    /// CPU time of the thread that the steps ran on, measured once.
    pub seconds: f64,
}

impl Cost {
    fn of(run: &Run, seconds: f64) -> Self {
        let Work { factorizations, inner, residuals, .. } = run.work;
        Self { solves: factorizations, inner, residuals, seconds }
    }
}

/// What `work` gives, and the seconds of CPU time that it takes on its thread: no library here has threads of its own.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let clock = ThreadTime::now();
    let given = work();
    (given, clock.elapsed().as_secs_f64())
}

/// CPU seconds of the same work, done several times over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seconds {
    /// Fewest seconds of the runs.
    pub least: f64,
    /// Most seconds of the runs.
    pub most: f64,
}

impl Seconds {
    /// None were measured.
    pub const NONE: Self = Self { least: f64::NAN, most: f64::NAN };

    fn new(times: &[f64]) -> Self {
        Self { least: times.iter().copied().smallest(), most: times.iter().copied().largest() }
    }

    /// Whether no second run says how far they can be trusted.
    pub fn is_of_one_run(self) -> bool {
        self.least == self.most
    }

    /// Over others: the least and the most that the repetitions allow.
    pub fn over(self, other: Self) -> Self {
        Self { least: self.least / other.most, most: self.most / other.least }
    }
}

/// Three runs, or two or one where those take long, by their own measure of their seconds, and what the first gave.
fn repeated<T>(mut run: impl FnMut() -> Result<(T, f64), StudyError>) -> Result<(T, Seconds), StudyError> {
    const LONG: [f64; 2] = [0.25, 0.1];
    let (given, first) = run()?;
    let mut times = vec![first];
    while LONG.get(times.len() - 1).is_some_and(|long| times.iter().sum::<f64>() < *long) {
        times.push(run()?.1);
    }
    Ok((given, Seconds::new(&times)))
}

fn setting(text: &str) -> Result<Box<dyn Problem>, StudyError> {
    Ok(problem::build_setting(text)?)
}

fn named(text: &str) -> Result<Box<dyn Method>, StudyError> {
    Ok(method::parse(text)?)
}

fn cavity(re: f64, cells: usize) -> Result<Box<dyn Problem>, StudyError> {
    setting(&format!("cavity re={re} cells={cells}"))
}

/// The observed values of a run at its end.
fn observed(problem: &dyn Problem, method: &dyn Method, h: f64, end: f64) -> Result<(Vec<f64>, Cost), StudyError> {
    let (run, seconds) = timed(|| run(problem, method, h, end, |_| {}));
    let run = run?;
    Ok((problem.observe(end, &run.end.q), Cost::of(&run, seconds)))
}

/// The velocities at the end of `steps` steps of size h in a cavity: of the method of that name, or of pressure correction.
fn cavity_by(
    method: &str,
    is_manufactured: bool,
    (re, cells): (f64, usize),
    (h, steps): (f64, u32),
) -> Result<(Vec<f64>, Cost), StudyError> {
    let name = if is_manufactured { "cavity-manufactured" } else { "cavity" };
    let problem = setting(&format!("{name} re={re} cells={cells}"))?;
    if method != PROJECTION {
        return observed(&*problem, &*named(method)?, h, f64::from(steps) * h);
    }
    let given: Box<dyn flow::Given> =
        if is_manufactured { Box::new(flow::manufactured(1.0 / re)) } else { Box::new(flow::lid()) };
    let start = problem.observe(0.0, &problem.initial());
    let (scheme, seconds) = timed(|| {
        let mut scheme = Projection::new(cells, 1.0 / re, &*given, &start);
        (0..steps).for_each(|_| scheme.step(h));
        scheme
    });
    let cost = Cost { solves: scheme.solves(), seconds, ..Cost::default() };
    Ok((scheme.faces(), cost))
}

/// The value at x by lines through the logarithms of ascending points; `None` beyond them.
pub fn log_log(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let pair = points.windows(2).find(|pair| pair[0].0 <= x && x <= pair[1].0)?;
    let [(x0, y0), (x1, y1)] = [pair[0], pair[1]].map(|(x, y)| (x.ln(), y.ln()));
    Some((y0 + (x.ln() - x0) / (x1 - x0) * (y1 - y0)).exp())
}

/// Root mean square of a difference: the norm of the energy.
pub fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering};

    use lsvi::solver::{Product, StepSolver};
    use lsvi::{SolveError, StepOperator, VectorField};

    use super::*;
    use crate::kinds::Principle;
    use crate::problem::{Facts, Limit};
    use crate::reference::Ode;

    /// Systems, and iterations in them.
    type Counts = Arc<[AtomicU64; 2]>;

    /// A solver whose calls are counted.
    #[derive(Debug)]
    struct Counting(Box<dyn StepSolver>, Counts);

    impl Counting {
        fn count(&self, solved: Result<u64, SolveError>) -> Result<u64, SolveError> {
            self.1[0].fetch_add(1, Ordering::Relaxed);
            self.1[1].fetch_add(*solved.as_ref().unwrap_or(&0), Ordering::Relaxed);
            solved
        }
    }

    impl StepSolver for Counting {
        fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
            self.0.prepare(b)
        }
        fn takes_products(&self) -> bool {
            self.0.takes_products()
        }
        fn solve_stage(&mut self, b: &StepOperator<'_>, x: &mut [f64], tolerance: f64) -> Result<u64, SolveError> {
            let solved = self.0.solve_stage(b, x, tolerance);
            self.count(solved)
        }
        fn solve_normal(
            &mut self,
            b: &StepOperator<'_>,
            damping: f64,
            a: Option<&[f64]>,
            x: &mut [f64],
            tolerance: f64,
        ) -> Result<u64, SolveError> {
            let solved = self.0.solve_normal(b, damping, a, x, tolerance);
            self.count(solved)
        }
        fn solve_closure(
            &mut self,
            b: &StepOperator<'_>,
            matrix: Product<'_>,
            x: &mut [f64],
            tolerance: f64,
        ) -> Result<u64, SolveError> {
            let solved = self.0.solve_closure(b, matrix, x, tolerance);
            self.count(solved)
        }
        fn tolerance(&self) -> f64 {
            self.0.tolerance()
        }
    }

    /// A cavity that is solved by that.
    #[derive(Debug)]
    struct Counted(Box<dyn Problem>, Counts);

    impl Problem for Counted {
        fn components(&self) -> &'static [&'static str] {
            self.0.components()
        }
        fn initial(&self) -> Vec<f64> {
            self.0.initial()
        }
        fn field(&self) -> Box<dyn VectorField + '_> {
            self.0.field()
        }
        fn solver(&self) -> Option<Box<dyn StepSolver>> {
            Some(Box::new(Counting(self.0.solver()?, Arc::clone(&self.1))))
        }
        fn ode(&self) -> &dyn Ode {
            self.0.ode()
        }
        fn limit(&self, principle: Principle) -> Limit<'_> {
            self.0.limit(principle)
        }
        fn facts(&self) -> Facts {
            self.0.facts()
        }
    }

    #[test]
    fn the_cost_of_a_run_is_what_its_solver_was_asked_for() {
        for method in ["method-i", "linear(-0.5,1)", "trapezoidal", "tr-bdf2", "bdf2"] {
            let counts = Counts::default();
            let problem = Counted(cavity(100.0, 6).expect("known"), Arc::clone(&counts));
            let (_, cost) = observed(&problem, &*named(method).expect("known"), 0.1, 0.5).expect("it runs");
            let [solves, inner] = [0, 1].map(|k| counts[k].load(Ordering::Relaxed));
            assert!(solves >= 5 && inner > solves, "{method}: {solves} {inner}");
            assert_eq!((cost.solves, cost.inner), (solves, inner), "{method}");
        }
    }

    /// At a Reynolds number at which GMRES with a preconditioner made of B = M − hJ stands still.
    #[test]
    fn method_ii_steps_a_cavity_where_convection_matters_by_factors_and_with_its_order() {
        let end = |steps: u32| cavity_by("method-ii", true, (1000.0, 12), (0.25 / f64::from(steps), steps));
        let [(coarse, _), (middle, cost), (fine, _)] = [8, 16, 32].map(|steps| end(steps).expect("it runs"));
        assert!(cost.solves >= 16 && cost.inner == 0, "{cost:?}");
        approx::assert_abs_diff_eq!((rms(&coarse, &middle) / rms(&middle, &fine)).log2(), 2.0, epsilon = 0.1);
    }

    #[test]
    fn seconds_are_the_least_and_the_most_of_runs_that_are_repeated_and_so_are_their_ratios() {
        let mut times = [0.05, 0.02, 0.04, 0.0].into_iter();
        let found = repeated(|| Ok(((), times.next().expect("no more than four")))).expect("it runs").1;
        assert_eq!((found, times.next()), (Seconds { least: 0.02, most: 0.05 }, Some(0.0)));
        let mut times = [0.2, 0.3, 0.0].into_iter();
        let long = repeated(|| Ok(((), times.next().expect("no more than three")))).expect("it runs").1;
        assert_eq!((long, times.next()), (Seconds { least: 0.2, most: 0.3 }, Some(0.0)));
        let longest = repeated(|| Ok(((), 11.0))).expect("it runs").1;
        assert_eq!(longest, Seconds { least: 11.0, most: 11.0 });
        assert_eq!([found, long, longest].map(Seconds::is_of_one_run), [false, false, true]);
        let ratio = Seconds { least: 2.0, most: 6.0 }.over(Seconds { least: 3.0, most: 4.0 });
        assert_eq!(ratio, Seconds { least: 0.5, most: 2.0 });
    }

    #[test]
    fn pressure_correction_counts_two_velocities_and_the_pressure_of_each_step() {
        let (_, cost) = cavity_by(PROJECTION, false, (100.0, 6), (0.01, 7)).expect("it runs");
        assert_eq!((cost.solves, cost.inner), (3 * 7, 0));
    }
}
