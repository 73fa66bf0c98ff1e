//! The methods under test, by name.

pub mod adaptive;
mod classic;
pub(crate) mod high_order;
mod least_squares;
mod mechanics;
mod open_closures;

use std::f64::consts::SQRT_2;
use std::fmt;

use lsvi::adaptive::Tolerances;
use lsvi::discrete::Constrainable;
use lsvi::{EulerLagrange, InputError, Integrator};

use crate::measure::order::{Expectation, ladder};
use crate::names::{Call, NameError};
use crate::problem::{Principle, Problem};

/// A method, named and with its arguments.
pub trait Method: fmt::Debug + Send + Sync {
    /// The canonical name, arguments included.
    fn name(&self) -> String;

    /// Nominal order of accuracy on smooth nonlinear problems.
    fn order(&self) -> u32;

    /// Order on v̇ = −λ(v − φ(t)) + φ̇ for hλ ≫ 1 (\[HW96\] IV.15); `None` where the error is no power of h at the stiffness
    /// of practical problems.
    fn stiff_order(&self) -> Option<u32> {
        Some(self.order())
    }

    /// Rows that one solution of its equations yields: more than one where several steps are found together.
    fn rows_per_solve(&self) -> usize {
        1
    }

    /// Order on uniform motion round a circle that is held by a constraint, where radial defects vanish in the multiplier.
    fn circular_order(&self) -> u32 {
        self.order()
    }

    /// What the momentum that the state carries adds to the roundoff of N steps, in units of ε |q|; nothing where it carries
    /// none.
    fn momentum_roundoff(&self, _steps: f64) -> f64 {
        0.0
    }

    /// The discrete Legendre transform that it steps in mechanics, where it is one of those, for what its trajectories do not
    /// show.
    ///
    /// # Errors
    /// [`InputError`] for a degree without nodes.
    fn discretise<'a>(
        &self,
        _lagrangian: Box<dyn EulerLagrange + 'a>,
    ) -> Option<Result<Box<dyn Constrainable + 'a>, InputError>> {
        None
    }

    /// What it steps; decides the limit on a reduced Lagrangian.
    fn principle(&self) -> Principle;

    /// What limits its step size on stiff problems.
    fn stability(&self) -> Stability;

    /// Whether it chooses its steps itself, and takes a given h as the longest.
    fn is_adaptive(&self) -> bool {
        false
    }

    /// The same method with other tolerances, if it is adaptive.
    fn with_tolerances(&self, _tolerances: Tolerances) -> Option<Box<dyn Method>> {
        None
    }

    /// Order of the largest matrix that a step on `problem` fills although it is banded or sparse; 0 for methods that follow
    /// the structure of the Jacobian.
    fn filled(&self, _problem: &dyn Problem) -> usize {
        0
    }

    /// The integrator for `problem`.
    ///
    /// # Errors
    /// [`BuildError`] if the method does not apply, or would fill more memory than can be asked for.
    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError>;
}

/// Half-width of the band around an expected order up to 4: a tenth of an order tells neighbouring orders apart by far.
/// Above, steps lie closer together, so that the same deviations of errors from a power law make slopes p/4 times as wrong.
const ORDER_BAND: f64 = 0.1;

/// Step sizes in an order study.
const LADDER: usize = 13;

/// What limits the step size on a stiff decaying problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stability {
    /// Nothing, and stiff components are damped: R(∞) = 0.
    Damping,
    /// Nothing, but stiff components are not damped: |R(∞)| = 1.
    Neutral,
    /// h|λ| must stay of order 1.
    Conditional,
    /// No step size: solutions grow where those of the problem decay.
    Unstable,
}

/// How the order of a method on a problem is measured, and what it should be.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderPlan {
    /// The order and its band.
    pub expectation: Expectation,
    /// End of the integration.
    pub horizon: f64,
    /// The step sizes, coarse to fine.
    pub steps: Vec<f64>,
    /// Why nothing is measured, where that is so.
    pub unmeasured: Option<&'static str>,
}

impl OrderPlan {
    /// The nominal order at t = 2, from h = 0.2 down; from 0.1 for orders above 2, whose error terms settle later.
    pub fn nominal(method: &dyn Method) -> Self {
        Self::at(method, 2.0, if method.order() > 2 { 0.1 } else { 0.2 })
    }

    /// The nominal order p at t = `horizon` from h = `coarsest` down, by factors √2; for p > 4 by 4^{1/p}, a quarter of the
    /// error at a time, because a high order is soon at roundoff.
    pub fn at(method: &dyn Method, horizon: f64, coarsest: f64) -> Self {
        let order = f64::from(method.order());
        let steps = ladder(horizon, coarsest, SQRT_2.min(4_f64.powf(order.recip())), LADDER);
        let band = ORDER_BAND.max(order / 40.0);
        Self { expectation: Expectation::new(order, band), horizon, steps, unmeasured: None }
    }

    /// The nominal order on a problem with rates up to `fastest`: at t = `horizon` from h = `coarsest` down, but within the
    /// limit of stability for methods that have one.
    pub fn stiff(method: &dyn Method, horizon: f64, coarsest: f64, fastest: f64) -> Self {
        match method.stability() {
            Stability::Unstable => Self::at(method, horizon.min(6.0 / fastest), coarsest.min(1.0 / fastest)),
            Stability::Conditional => Self::at(method, horizon.min(6.0 / fastest), coarsest.min(1.5 / fastest)),
            _ => Self::at(method, horizon, coarsest),
        }
    }

    /// As [`stiff`](Self::stiff), on a problem whose solution is smooth: orders above 2 settle where h resolves the fastest
    /// rates, and errors are near roundoff there.
    pub fn smooth(method: &dyn Method, horizon: f64, coarsest: f64, fastest: f64) -> Self {
        if method.order() > 2 {
            return Self::unmeasured(
                method,
                "where h is small enough for the order to show, the error is near roundoff",
            );
        }
        Self::stiff(method, horizon, coarsest, fastest)
    }

    /// No order is measured, for a reason.
    pub fn unmeasured(method: &dyn Method, reason: &'static str) -> Self {
        Self { unmeasured: Some(reason), ..Self::nominal(method) }
    }

    /// Expects `order` instead, for a reason.
    #[must_use]
    pub fn declared(self, order: f64, reason: &str) -> Self {
        Self { expectation: self.expectation.declared(order, reason), ..self }
    }
}

/// A method that does not apply to a problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{method} does not apply to this problem: {reason}")]
pub struct BuildError {
    /// The method.
    pub method: String,
    /// Why it does not apply.
    pub reason: String,
}

/// Largest order of a dense matrix: it takes 128 MB, and a step needs a few of them.
const MAX_FILLED: usize = 4096;

/// Refuses `problem` where `method` would fill larger matrices than [`MAX_FILLED`].
fn check_filled(method: &dyn Method, problem: &dyn Problem) -> Result<(), BuildError> {
    let order = method.filled(problem);
    if order <= MAX_FILLED {
        return Ok(());
    }
    let reason = format!(
        "it fills matrices of order {order}, more than {MAX_FILLED}; method-i, radau-adaptive and the classical methods \
         follow the structure of the Jacobian"
    );
    Err(BuildError { method: method.name(), reason })
}

/// An entry of the registry.
#[derive(Debug, Clone, Copy)]
pub struct Spec {
    /// How it is called: `linear(ALPHA,BETA)`.
    pub form: &'static str,
    /// What it is and where it comes from, in one line.
    pub summary: &'static str,
    /// Makes the method.
    pub build: Build,
    /// Calls of it that the studies run, one for each kind of argument; none for a failure that has a study of its own.
    pub examples: &'static [&'static str],
}

/// How a method is made of the call that names it.
#[derive(Debug, Clone, Copy)]
pub enum Build {
    /// It takes no arguments.
    Plain(fn() -> Box<dyn Method>),
    /// From its arguments.
    Arguments(fn(&Call) -> Result<Box<dyn Method>, NameError>),
}

impl Spec {
    /// The name without arguments.
    pub fn name(&self) -> &'static str {
        self.form.split('(').next().unwrap_or(self.form)
    }
}

/// All methods.
pub const ALL: &[Spec] = &[
    least_squares::METHOD_I,
    least_squares::METHOD_II,
    least_squares::EXPLICIT_MOMENTUM,
    least_squares::CONVENTIONAL,
    least_squares::LINEAR,
    open_closures::FITTED,
    open_closures::FITTED_PADE,
    open_closures::MINIMAX,
    open_closures::WINDOW,
    high_order::LS_GALERKIN,
    adaptive::RADAU,
    classic::IMPLICIT_EULER,
    classic::RK4,
    classic::TRAPEZOIDAL,
    classic::IMPLICIT_MIDPOINT,
    classic::SDIRK2,
    classic::TR_BDF2,
    classic::BDF2,
    mechanics::PATH_FITTED,
    mechanics::PATH_FITTED_BERNSTEIN,
    mechanics::KONG_YANG_CIRCLE,
    mechanics::MIDPOINT,
    mechanics::STORMER_VERLET,
    mechanics::GALERKIN_GAUSS,
    mechanics::GALERKIN_LOBATTO,
];

/// The method that `text` names.
///
/// # Errors
/// [`NameError`] for an unknown name or unusable arguments.
pub fn parse(text: &str) -> Result<Box<dyn Method>, NameError> {
    let call = Call::parse(text)?;
    let Some(spec) = ALL.iter().find(|spec| spec.name() == call.name) else {
        return Err(NameError::unknown("method", &call.name, ALL.iter().map(Spec::name)));
    };
    match spec.build {
        Build::Plain(build) => call.numbers::<0>(spec.form).map(|_| build()),
        Build::Arguments(build) => build(&call),
    }
}

/// One or more methods of every entry, for studies that run them all with steps of their choice: none of the adaptive ones.
pub fn examples() -> Vec<Box<dyn Method>> {
    // Examples are part of the registry, and a test parses every one of them.
    let methods = ALL.iter().flat_map(|spec| spec.examples).filter_map(|call| parse(call).ok());
    methods.filter(|method| !method.is_adaptive()).collect()
}

/// Largest order of a matrix that is filled in the studies of every pair of method and problem, for the sake of time.
const CHEAP: usize = 24;

/// The examples that say something about `problem`: those that can be built, fill no large matrices, and are least-squares closures only where the motion has no invariant, since those are made for systems that
/// dissipate.
pub fn examples_for(problem: &dyn Problem) -> Vec<Box<dyn Method>> {
    let conservative = !problem.invariants().is_empty();
    let suits =
        |method: &dyn Method| !conservative || matches!(method.principle(), Principle::Equation | Principle::Hamilton);
    let cheap = |method: &dyn Method| method.filled(problem) <= CHEAP;
    examples().into_iter().filter(|m| suits(&**m) && cheap(&**m) && m.build(problem).is_ok()).collect()
}

/// Refuses a problem without second derivatives, for closures with α + β = 0: their derivative is of the size of
/// J = ∂f/∂v, and where J is singular the curvature of f decides where the branch of roots goes, and that it ends.
/// Without it an iteration runs on, to a root of another branch.
fn require_curvature(method: &dyn Method, problem: &dyn Problem) -> Result<(), BuildError> {
    if problem.has_curvature() {
        return Ok(());
    }
    let reason = "where ∂f/∂v is singular, second derivatives of f tell which root is the right one, and they are not known here";
    Err(BuildError { method: method.name(), reason: reason.into() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem;

    #[test]
    fn every_method_is_found_by_its_canonical_name() {
        for spec in ALL {
            for call in spec.examples {
                let method = parse(call).expect("registered");
                assert_eq!(parse(&method.name()).expect("canonical").name(), method.name());
            }
        }
        assert!(matches!(parse("methodi"), Err(NameError::Unknown { suggestion: Some(s), .. }) if s == "method-i"));
        assert!(matches!(parse("linear(0,0)"), Err(NameError::Form { .. })));
        for bad in
            ["fitted(0)", "fitted(1,2)", "fitted-pade(-1)", "minimax(2,1)", "window(0)", "window(2.5)", "window(1e9)"]
        {
            assert!(matches!(parse(bad), Err(NameError::Form { .. })), "{bad}");
        }
        for bad in ["path-fitted", "path-fitted(1)", "path-fitted(2.5)", "path-fitted(3,radau)", "galerkin-gauss(0)"] {
            assert!(matches!(parse(bad), Err(NameError::Form { .. })), "{bad}");
        }
        for good in ["path-fitted(4,gauss)", "path-fitted(5,lobatto)", "path-fitted( 6 , chebyshev )"] {
            assert_eq!(parse(good).expect("registered").name(), good.replace(' ', ""));
        }
        for bad in [
            "ls-galerkin(0,gauss,1)",
            "ls-galerkin(7,gauss,7)",
            "ls-galerkin(2,gauss,4)",
            "ls-galerkin(2,gauss,1)",
            "ls-galerkin(1,lobatto,1)",
            "ls-galerkin(2.5,gauss,3)",
            "ls-galerkin(2,gauss)",
            "ls-galerkin(2,gauss,3,iii)",
            "ls-galerkin(2,gauss,3,0:0)",
            "ls-galerkin(2,gauss,3,NaN:1)",
        ] {
            assert!(matches!(parse(bad), Err(NameError::Form { .. })), "{bad}");
        }
        assert!(
            matches!(parse("ls-galerkin(2,gaus,2)"), Err(NameError::Unknown { suggestion: Some(s), .. }) if s == "gauss")
        );
        assert!(matches!(parse("rk4(3)"), Err(NameError::Form { .. })));
        assert!(parse(" linear( -1e-3 , +2.5E1 ) ").is_ok());
    }

    /// What would not fit into memory is refused before it is allocated; structure makes room.
    #[test]
    fn large_systems_are_refused_where_matrices_are_filled() {
        let problem = problem::build_setting("channel-couette cells=20000").expect("banded");
        for name in ["method-ii", "conventional", "minimax(0.1,1)", "fitted(1)", "window(2)", "ls-galerkin(2,radau,2)"]
        {
            let error = parse(name).expect("registered").build(&*problem).map(|_| ()).expect_err("too large");
            assert!(error.reason.contains("more than 4096"), "{error}");
        }
        for name in ["method-i", "linear(0,2)", "radau-adaptive", "bdf2", "tr-bdf2"] {
            let method = parse(name).expect("registered");
            assert!(method.build(&*problem).is_ok(), "{name}");
        }
        let end = crate::run::run(&*problem, &*parse("method-i").expect("registered"), 0.1, 0.2, |_| {});
        assert!(end.is_ok_and(|state| state.q.iter().all(|u| (0.0..1.0).contains(u))));
    }
}
