//! diffsol: BDF and Runge–Kutta methods in Rust, with dense linear algebra, or sparse where the Jacobian is banded.
//!
//! It shares nothing with the methods under test but the package `nalgebra`.

use std::cell::{Cell, RefCell};

use diffsol::{
    DefaultDenseMatrix, DiffsolError, FaerSparseLU, FaerSparseMat, LinearSolver, NalgebraLU, NalgebraMat, OdeBuilder,
    OdeEquations, OdeSolverMethod, OdeSolverStopReason, Op, Vector, VectorRef,
};

use diffsol::matrix::MatrixRef;

use super::{MAX_STEPS, Run, bound, check_size};
use super::{Ode, Reference, ReferenceError, Work};
use crate::panics::caught;

/// Newton iterations allowed to fail in a solve; diffsol's own limit of 50 also counts over the whole solve.
const MAX_FAILURES: usize = 10_000;

/// Part of the solve that a step may be as short as: diffsol's own limit of 10⁻¹³ units of time is that of no unit in particular.
const SHORTEST: f64 = 1e-30;

#[derive(Debug, Clone, Copy)]
enum Method {
    Bdf,
    TrBdf2,
    Esdirk34,
    Tsit45,
}

/// diffsol with one of its methods.
pub(super) struct Diffsol {
    name: &'static str,
    method: Method,
    stiff_ok: bool,
}

/// Backward differentiation formulas of orders 1 to 5.
pub(super) static BDF: Diffsol = Diffsol { name: "diffsol-bdf", method: Method::Bdf, stiff_ok: true };

/// TR-BDF2, of order 2.
pub(super) static TR_BDF2: Diffsol = Diffsol { name: "diffsol-tr-bdf2", method: Method::TrBdf2, stiff_ok: true };

/// ESDIRK34, of order 3.
pub(super) static ESDIRK34: Diffsol = Diffsol { name: "diffsol-esdirk34", method: Method::Esdirk34, stiff_ok: true };

/// Tsitouras' explicit method, of order 5.
pub(super) static TSIT45: Diffsol = Diffsol { name: "diffsol-tsit45", method: Method::Tsit45, stiff_ok: false };

impl Reference for Diffsol {
    fn name(&self) -> &'static str {
        self.name
    }

    fn stiff_ok(&self) -> bool {
        self.stiff_ok
    }

    fn library(&self) -> Option<String> {
        Some(format!("diffsol {}", locked_version("diffsol").unwrap_or("of unknown version")))
    }

    /// One solve. Panics inside diffsol or the system become errors.
    fn run(&self, ode: &dyn Ode, t0: f64, v0: &[f64], times: &[f64], tolerance: f64) -> Result<Run, ReferenceError> {
        bound::check(ode, t0, v0, times)?;
        check_size(self.name, ode.dim(), !ode.is_sparse())?;
        let reached = Cell::new(t0);
        let integrate = || match ode.is_sparse() {
            true => self.integrate::<FaerSparseMat<f64>, FaerSparseLU<f64>>(ode, v0, times, tolerance, &reached),
            false => self.integrate::<NalgebraMat<f64>, NalgebraLU<f64>>(ode, v0, times, tolerance, &reached),
        };
        let solved = caught(integrate).unwrap_or_else(|message| Err(format!("panicked: {message}")));
        solved.map_err(|reason| ReferenceError::Solver { solver: self.name, t: reached.get(), reason })
    }
}

/// The version in the lock file, from which the build took it.
fn locked_version(package: &str) -> Option<&'static str> {
    let lock = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.lock"));
    let (_, entry) = lock.split_once(&format!("name = \"{package}\"\nversion = \""))?;
    entry.split('"').next()
}

/// What the closures handed to diffsol saw.
#[derive(Default)]
struct Seen {
    rhs: Cell<u64>,
    not_finite: RefCell<Option<String>>,
}

impl Seen {
    /// Fails if a value of f was not finite.
    fn check(&self) -> Result<(), String> {
        self.not_finite.take().map_or(Ok(()), Err)
    }

    /// Why a step failed: a value of f that was not finite, where there was one.
    fn explain(&self, error: &DiffsolError) -> String {
        match self.check() {
            Err(reason) => format!("{reason} ({error})"),
            Ok(()) => error.to_string(),
        }
    }
}

/// The last Jacobian: diffsol asks for products of each with as many vectors as it has columns, or colours.
#[derive(Default)]
struct Jacobian {
    at: Option<(f64, Vec<f64>)>,
    entries: Vec<(usize, usize, f64)>,
}

impl Jacobian {
    fn entries(&mut self, ode: &dyn Ode, t: f64, v: &[f64]) -> &[(usize, usize, f64)] {
        if !self.at.as_ref().is_some_and(|(at, of)| *at == t && of == v) {
            self.entries.clear();
            ode.jacobian(t, v, &mut |i, j, entry| self.entries.push((i, j, entry)));
            self.at = Some((t, v.to_vec()));
        }
        &self.entries
    }
}

impl Diffsol {
    /// Builds the problem and starts the method; `reached` holds the initial time and follows the solve.
    fn integrate<M, L>(
        &self,
        ode: &dyn Ode,
        v0: &[f64],
        times: &[f64],
        tolerance: f64,
        reached: &Cell<f64>,
    ) -> Result<Run, String>
    where
        M: diffsol::Matrix<T = f64>,
        M::V: DefaultDenseMatrix<T = f64, C = M::C>,
        for<'b> &'b M::V: VectorRef<M::V>,
        for<'b> &'b M: MatrixRef<M>,
        L: LinearSolver<M>,
    {
        let seen = Seen::default();
        let rhs = |v: &[f64], _: &[f64], t: f64, dv: &mut [f64]| {
            seen.rhs.set(seen.rhs.get() + 1);
            ode.rhs(t, v, dv);
            if let Some((i, x)) = dv.iter().enumerate().find(|(_, x)| !x.is_finite()) {
                seen.not_finite.replace(Some(format!("component {i} of f is {x} at t = {t}")));
            }
        };
        let last = RefCell::new(Jacobian::default());
        let jacobian_times = |v: &[f64], _: &[f64], t: f64, x: &[f64], y: &mut [f64]| {
            y.fill(0.0);
            last.borrow_mut().entries(ode, t, v).iter().for_each(|(i, j, entry)| y[*i] += entry * x[*j]);
        };
        // diffsol would choose a first step of NaN and never leave the initial time.
        rhs(v0, &[], reached.get(), &mut vec![0.0; v0.len()]);
        seen.check()?;
        let mut problem = OdeBuilder::<M>::new()
            .t0(reached.get())
            .rtol(tolerance)
            .atol([tolerance])
            .rhs_implicit(rhs, jacobian_times)
            .init(|_, _, v| v.copy_from_slice(v0), v0.len())
            .build()
            .map_err(|e| e.to_string())?;
        problem.ode_options.max_nonlinear_solver_failures = MAX_FAILURES;
        let end = times.last().copied().unwrap_or(reached.get());
        problem.ode_options.min_timestep = SHORTEST * (end - reached.get());
        let start = |e: DiffsolError| e.to_string();
        let stops = Stops::new(ode, reached.get(), times);
        match self.method {
            Method::Bdf => sample(problem.bdf::<L>().map_err(start)?, times, stops, &seen, reached),
            Method::TrBdf2 => sample(problem.tr_bdf2::<L>().map_err(start)?, times, stops, &seen, reached),
            Method::Esdirk34 => sample(problem.esdirk34::<L>().map_err(start)?, times, stops, &seen, reached),
            Method::Tsit45 => sample(problem.tsit45().map_err(start)?, times, stops, &seen, reached),
        }
    }
}

/// Times that steps end at, as near to each other as the longest step: diffsol itself knows no longest one. Without a limit there is
/// one, the end.
#[derive(Debug, Clone, Copy)]
struct Stops {
    start: f64,
    end: f64,
    count: f64,
    passed: f64,
}

impl Stops {
    fn new(ode: &dyn Ode, start: f64, times: &[f64]) -> Self {
        let end = times.last().copied().unwrap_or(start);
        let count = ((end - start) / ode.longest_step(end - start)).ceil().max(1.0);
        Self { start, end, count, passed: 0.0 }
    }

    /// The next one, which is the end for ever after it.
    fn next(&mut self) -> f64 {
        self.passed += 1.0;
        if self.passed < self.count {
            self.start + (self.end - self.start) * (self.passed / self.count)
        } else {
            self.end
        }
    }
}

/// Steps to the last of `times` and interpolates the others from the step that passes them.
fn sample<'a, E, S>(
    mut solver: S,
    times: &[f64],
    mut stops: Stops,
    seen: &Seen,
    reached: &Cell<f64>,
) -> Result<Run, String>
where
    E: OdeEquations<T = f64> + 'a,
    E::V: DefaultDenseMatrix<T = f64, C = E::C>,
    S: OdeSolverMethod<'a, E>,
{
    let mut run = Run::with_capacity(times.len());
    let (mut stop, mut last) = (reached.get(), 0.0);
    for &t in times {
        while reached.get() < t {
            if reached.get() >= stop {
                stop = stops.next();
                // Where a step ends beyond a stop by just what diffsol takes for roundings, it turns back.
                if solver.state().h < 0.0 {
                    *solver.state_mut().h = last;
                }
                solver.set_stop_time(stop).map_err(|e| e.to_string())?;
            }
            let before = solver.state().t;
            let why = solver.step().map_err(|e| seen.explain(&e))?;
            last = solver.state().t - before;
            // diffsol takes a NaN estimate of the error for zero and accepts the step.
            seen.check()?;
            if solver.get_statistics().number_of_steps > MAX_STEPS as usize {
                return Err(format!("took more than {MAX_STEPS} steps"));
            }
            // A stop time is reached up to a roundoff.
            let is_stop = matches!(why, OdeSolverStopReason::TstopReached);
            reached.set(if is_stop { stop.max(solver.state().t) } else { solver.state().t });
        }
        let state = solver.state();
        let v = if t < state.t {
            solver.interpolate(t).map_err(|e| e.to_string())?.clone_as_vec()
        } else {
            state.y.clone_as_vec()
        };
        run.push(v, solver.get_statistics().number_of_steps as u64);
    }
    let statistics = solver.get_statistics();
    run.work = Work {
        steps: statistics.number_of_steps as u64,
        rhs: seen.rhs.get(),
        jacobians: solver.problem().eqn().rhs().statistics().number_of_matrix_evals as u64,
        factorizations: statistics.number_of_linear_solver_setups as u64,
        products: 0,
    };
    Ok(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::norm::larger;
    use crate::reference::MAX_DENSE;
    use crate::reference::tests::Still;

    /// By what f was, where that is the cause, and else by the solver.
    #[test]
    fn a_step_that_fails_is_explained() {
        let (seen, error) = (Seen::default(), DiffsolError::Other("no step".into()));
        assert_eq!(seen.explain(&error), error.to_string());
        seen.not_finite.replace(Some("f is NaN".into()));
        assert_eq!(seen.explain(&error), format!("f is NaN ({error})"));
    }

    /// v̇ = −v.
    struct Decay;

    impl Ode for Decay {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            dv[0] = -v[0];
        }
        fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
            add(0, 0, -1.0);
        }
    }

    /// The last step ends at a time to roundings, before it or beyond it.
    #[test]
    fn the_state_at_the_end_is_that_of_the_last_step_wherever_the_end_is() {
        for solver in [&BDF, &TR_BDF2, &ESDIRK34, &TSIT45] {
            for end in (1..=40).map(|k| 0.0837 * f64::from(k)) {
                let run = solver.run(&Decay, 0.0, &[1.0], &[0.4 * end, end], 1e-4).expect("it runs");
                assert!((run.states[1][0] - (-end).exp()).abs() < 1e-2, "{} to {end}", solver.name);
            }
        }
    }

    /// v̇_i = v_{i+1} − v_i around a ring, with sparse factors or dense ones.
    struct Ring {
        cells: usize,
        is_sparse: bool,
    }

    impl Ode for Ring {
        fn dim(&self) -> usize {
            self.cells
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            (0..self.cells).for_each(|i| dv[i] = v[(i + 1) % self.cells] - v[i]);
        }
        fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
            (0..self.cells)
                .for_each(|i| [(i, -1.0), ((i + 1) % self.cells, 1.0)].into_iter().for_each(|(j, x)| add(i, j, x)));
        }
        fn is_sparse(&self) -> bool {
            self.is_sparse
        }
    }

    /// To roundings, which errors of 10⁻⁸ are far above; and where a dense matrix would be too large.
    #[test]
    fn sparse_factors_solve_as_dense_ones() {
        let run = |cells: usize, is_sparse: bool, end: f64| {
            let start: Vec<f64> = (0..cells).map(|i| (i as f64).sin()).collect();
            BDF.run(&Ring { cells, is_sparse }, 0.0, &start, &[end], 1e-8)
        };
        let [sparse, dense] = [true, false].map(|is_sparse| run(20, is_sparse, 2.0).expect("it runs"));
        assert_eq!(sparse.work.steps, dense.work.steps);
        let apart = sparse.states[0].iter().zip(&dense.states[0]).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
        assert!(apart < 1e-13, "{apart:e}");
        assert!(run(MAX_DENSE + 1, true, 1e-3).is_ok());
        assert!(matches!(run(MAX_DENSE + 1, false, 1e-3), Err(ReferenceError::Input(_))));
    }

    #[test]
    fn stops_are_equally_spaced_from_where_a_run_goes_on_to_its_end() {
        let mut stops = Stops::new(&Still(0.4), 2.0, &[2.5, 3.0]);
        let found = [(); 5].map(|()| stops.next());
        for (found, stop) in found.into_iter().zip([2.0 + 1.0 / 3.0, 2.0 + 2.0 / 3.0, 3.0, 3.0, 3.0]) {
            assert!((found - stop).abs() < 1e-15, "{found} for {stop}");
        }
    }
}
