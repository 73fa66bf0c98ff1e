//! The methods under test, by name.

pub mod adaptive;
mod classic;
pub mod high_order;
mod least_squares;
pub mod mechanics;
mod open_closures;
mod splitting;
mod traits;

use std::fmt;

use lsvi::adaptive::Tolerances;
use lsvi::closure::Linear;
use lsvi::discrete::{Constrainable, DiscreteLegendre, Trapezoidal};
use lsvi::{EulerLagrange, InputError, Integrator, Variational};

pub use traits::Traits;

use crate::kinds::{Principle, Stability};
use crate::names::{Call, NameError};
use crate::problem::Problem;

/// A method, named and with its arguments.
pub trait Method: fmt::Debug + Send + Sync {
    /// The canonical name, arguments included.
    fn name(&self) -> String;

    /// What is known of it.
    fn traits(&self) -> Traits;

    /// Its nominal [order](Traits::order).
    fn order(&self) -> u32 {
        self.traits().order
    }

    /// What it [steps](Traits::principle).
    fn principle(&self) -> Principle {
        self.traits().principle
    }

    /// What limits its [step size](Traits::stability).
    fn stability(&self) -> Stability {
        self.traits().stability
    }

    /// What the momentum that the state carries adds to the roundoff of N steps, in units of ε |q|; nothing where it carries
    /// none.
    fn momentum_roundoff(&self, _steps: f64) -> f64 {
        0.0
    }

    /// How far the digits that its coefficients are given to may move the end of a run of N `steps` along a solution of this
    /// `size` and `length`; nothing where they are exact.
    fn rounding_of_coefficients(&self, _size: f64, _length: f64, _steps: f64) -> f64 {
        0.0
    }

    /// The discrete Legendre transform that it steps in mechanics, where it is one of those, for what its trajectories do not
    /// show.
    ///
    /// # Errors
    /// [`InputError`] for a degree without nodes, or a Lagrangian that it does not step.
    fn discretise<'a>(
        &self,
        lagrangian: Box<dyn EulerLagrange + 'a>,
    ) -> Option<Result<Box<dyn DiscreteLegendre + 'a>, InputError>> {
        let discrete = self.discretise_held(lagrangian)?;
        Some(discrete.map(|discrete| discrete as Box<dyn DiscreteLegendre>))
    }

    /// The same, where it can be held to constraints.
    ///
    /// # Errors
    /// As for [`discretise`](Self::discretise).
    fn discretise_held<'a>(
        &self,
        _lagrangian: Box<dyn EulerLagrange + 'a>,
    ) -> Option<Result<Box<dyn Constrainable + 'a>, InputError>> {
        None
    }

    /// The same method with other tolerances, if it is adaptive.
    fn with_tolerances(&self, _tolerances: Tolerances) -> Option<Box<dyn Method>> {
        None
    }

    /// The same method with another number of steps that a run may try, if it is adaptive.
    fn limited(&self, _steps: u64) -> Option<Box<dyn Method>> {
        None
    }

    /// The same method with tolerances divided by `factor`, if it is adaptive.
    fn tightened(&self, _factor: f64) -> Option<Box<dyn Method>> {
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

/// A method that does not apply to a problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{method} does not apply to this problem: {reason}")]
pub struct BuildError {
    /// The method.
    pub method: String,
    /// Why it does not apply.
    pub reason: String,
}

impl BuildError {
    /// What the library refuses to make of `method`.
    fn of(method: &dyn Method) -> impl Fn(InputError) -> Self {
        move |error| Self { method: method.name(), reason: error.to_string() }
    }
}

/// Largest order of a dense matrix: it takes 128 MB, and a step needs a few of them.
const MAX_FILLED: usize = 4096;

/// Refuses `problem` where `method` would fill matrices that do not fit.
///
/// # Errors
/// [`BuildError`] where their order is more than 4096.
pub fn check_filled(method: &dyn Method, problem: &dyn Problem) -> Result<(), BuildError> {
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
    splitting::BLANES_MOAN,
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
    methods.filter(|method| !method.traits().is_adaptive).collect()
}

/// The variational integrators of mechanics among the examples.
pub fn integrators() -> Vec<Box<dyn Method>> {
    examples().into_iter().filter(|method| method.principle() == Principle::Hamilton).collect()
}

/// The roundoff that N steps of `method` leave in states no larger than `size`: N ε |q|, one rounding of the state per step,
/// and that of the momentum, where the state carries one.
pub fn roundoff(method: &dyn Method, size: f64, steps: f64) -> f64 {
    f64::EPSILON * size * (steps + method.momentum_roundoff(steps))
}

/// Refuses problems on which a closure whose α and β depend on a rate converges to what the rate says.
///
/// # Errors
/// Why, in words.
pub fn check_limit(problem: &dyn Problem) -> Result<(), String> {
    if problem.limit(Principle::MomentumZero).name == problem.limit(Principle::MomentumConserved).name {
        return Ok(());
    }
    Err("its Lagrangian keeps a remainder, and the limit would depend on the rate of the closure".into())
}

/// The trapezoidal discrete Lagrangian of `problem` with a closure αp₀ + βp₁ = 0 of one's own.
///
/// # Errors
/// In words, where the problem has no Lagrangian.
pub fn close<'a>(problem: &'a dyn Problem, closure: Linear) -> Result<Box<dyn Integrator + 'a>, String> {
    let lagrangian = problem.lagrangian().map_err(|error| error.to_string())?;
    Ok(Box::new(Variational::new(Trapezoidal::new(lagrangian), closure)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem;

    /// One evaluation at each node of a collocation, and of a residual its transpose too.
    #[test]
    fn stages_are_evaluations_of_a_step() {
        let stages = |name: &str| parse(name).expect("known").traits().stages;
        assert_eq!(["ls-galerkin(2,gauss,2)", "ls-galerkin(2,lobatto,3)"].map(stages), [2, 6]);
    }

    /// A rounding a step, and what a method that keeps momenta loses in them.
    #[test]
    fn momenta_lose_digits_beside_a_rounding_a_step() {
        let of = |name: &str| roundoff(&*parse(name).expect("a method"), 2.0, 100.0) / f64::EPSILON;
        assert_eq!(of("rk4"), 200.0);
        assert_eq!(of("conventional"), 2.0 * (100.0 + 1e4));
    }

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
        assert!(end.is_ok_and(|run| run.end.q.iter().all(|u| (0.0..1.0).contains(u))));
    }
}
