//! The problems, one file each.
//!
//! A problem states its equations twice: generically for `lsvi`, which differentiates them, and by hand as an
//! [`Ode`] for the references. A test holds the two against each other.

mod asymmetric_pendulum;
mod charged_particle;
mod circle;
mod damped_pendulum;
mod double_pendulum;
mod elliptic;
mod harmonic_oscillator;
mod henon_heiles;
mod kepler;
mod linear_drag;
mod logistic;
mod mechanics;
mod pendulum;
mod poiseuille_ansatz;
pub mod poiseuille_series;
mod prothero_robinson;
mod quadratic_drag;
mod spherical_pendulum;
mod tabulated;
mod unit_sphere;
mod van_der_pol;

use std::fmt;

use lsvi::{Lagrangian, LeastSquares, VectorField};

pub use mechanics::{Invariant, Mechanics};
pub use poiseuille_ansatz::PoiseuilleAnsatz;

use crate::methods::{Method, OrderPlan};
use crate::names::{NameError, Parameter, Parameters};
use crate::references::Ode;

/// An initial value problem with its parameters set.
pub trait Problem: fmt::Debug + Send + Sync {
    /// Names of the state's components, in order.
    fn components(&self) -> &'static [&'static str];

    /// The state at t = 0.
    fn initial(&self) -> Vec<f64>;

    /// The right-hand side that the methods under test integrate.
    fn field(&self) -> Box<dyn VectorField + '_>;

    /// The Lagrangian that the variational methods discretise; the least-squares one unless the problem has its own.
    fn lagrangian(&self) -> Box<dyn Lagrangian + '_> {
        Box::new(LeastSquares::new(self.field()))
    }

    /// The mechanical system behind the equations, where there is one: the state is then (q, p), momenta after coordinates.
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        None
    }

    /// The functions of the state that are known to be conserved.
    fn invariants(&self) -> Vec<Invariant<'_>> {
        Vec::new()
    }

    /// The same system by hand, for the references.
    fn ode(&self) -> &dyn Ode;

    /// The solution at time t that the error of a run is measured against, where one is known.
    fn exact(&self, _t: f64) -> Option<Vec<f64>> {
        None
    }

    /// The solution at a few times, known to double precision from a computation in 60 digits.
    fn tabulated(&self, _t: f64) -> Option<Vec<f64>> {
        None
    }

    /// What a method's solutions tend to as h → 0: the solution of [`ode`](Self::ode), unless no path makes the
    /// residual of the Lagrangian vanish.
    fn limit(&self, _principle: Principle) -> Limit<'_> {
        let exact = Box::new(|t| self.exact(t));
        let reason = "the equation itself";
        Limit { name: "equation", ode: self.ode(), initial: self.initial(), exact, order: None, reason }
    }

    /// How the order of `method` is to be measured here: nominal unless the problem declares otherwise.
    fn order_plan(&self, method: &dyn Method) -> OrderPlan {
        self.nominal_plan(method)
    }

    /// The nominal order, at a horizon that suits its size.
    fn nominal_plan(&self, method: &dyn Method) -> OrderPlan {
        if method.principle() == Principle::Hamilton && method.order() > 4 {
            OrderPlan::at(method, self.high_order_horizon(), 0.5)
        } else {
            OrderPlan::nominal(method)
        }
    }

    /// The horizon at which orders above 4 are measured in mechanics, with steps from ½ down, since smaller ones are soon at
    /// roundoff. It decides whether an order can be told; slopes that have not settled are no order.
    fn high_order_horizon(&self) -> f64 {
        2.0
    }

    /// Why `method` cannot reach the horizon here, however small its steps, where that is known: a failure that is asserted.
    fn breakdown(&self, _method: &dyn Method) -> Option<&'static str> {
        None
    }

    /// Whether explicit references would need steps far below the solution's own scale.
    fn is_stiff(&self) -> bool {
        false
    }

    /// End of the time interval for cross-checks.
    fn horizon(&self) -> f64 {
        2.0
    }
}

/// Which principle a method steps: it decides what the method converges to where the residual cannot vanish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Principle {
    /// The differential equation itself.
    Equation,
    /// The Lagrangian with a momentum set to zero: p → 0.
    MomentumZero,
    /// The Lagrangian with a momentum that is conserved: ṗ → 0.
    MomentumConserved,
    /// The Lagrangian with a momentum that decays at a rate of the method's own.
    MomentumDecaying,
    /// The Lagrangian with p = 0 at the start only.
    EulerLagrange,
    /// The Lagrangian of mechanics from a given (q, p): Hamilton's principle, or Lagrange and d'Alembert's.
    Hamilton,
}

/// The limit of a method as h → 0: an ODE, whose first components are those of the problem.
pub struct Limit<'a> {
    /// Its name, one for each different equation of a problem.
    pub name: &'static str,
    /// The equation, for the references.
    pub ode: &'a dyn Ode,
    /// Its state at t = 0.
    pub initial: Vec<f64>,
    /// Its solution, where it is known.
    pub exact: Box<dyn Fn(f64) -> Option<Vec<f64>> + Sync + 'a>,
    /// The order to which methods of higher nominal order are reduced, where they are.
    pub order: Option<f64>,
    /// Why this equation and this order.
    pub reason: &'static str,
}

/// An entry of the registry.
#[derive(Debug, Clone, Copy)]
pub struct Spec {
    /// Name on the command line.
    pub name: &'static str,
    /// The equations and where they come from, in one line.
    pub summary: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Makes the problem.
    pub build: fn(&Parameters) -> Result<Box<dyn Problem>, NameError>,
}

/// All problems.
pub const ALL: &[Spec] = &[
    linear_drag::SPEC,
    quadratic_drag::SPEC,
    poiseuille_ansatz::SPEC,
    logistic::SPEC,
    damped_pendulum::SPEC,
    van_der_pol::SPEC,
    prothero_robinson::SPEC,
    harmonic_oscillator::SPEC,
    pendulum::SPEC,
    asymmetric_pendulum::SPEC,
    double_pendulum::SPEC,
    circle::SPEC,
    spherical_pendulum::SPEC,
    kepler::SPEC,
    henon_heiles::SPEC,
    charged_particle::SPEC,
];

/// Another name for a problem with one parameter set.
#[derive(Debug, Clone, Copy)]
pub struct Alias {
    /// The other name.
    pub name: &'static str,
    /// The problem's own name.
    pub problem: &'static str,
    /// The parameter and its value.
    pub set: (&'static str, &'static str),
}

/// All other names.
pub const ALIASES: &[Alias] =
    &[Alias { name: "poiseuille-galerkin", problem: "poiseuille-ansatz", set: ("reduction", "galerkin") }];

/// The problem `name` with the parameters `set`.
///
/// # Errors
/// [`NameError`] for an unknown name or parameter, or an unusable value.
pub fn build(name: &str, set: &[(String, String)]) -> Result<Box<dyn Problem>, NameError> {
    let mut set = set.to_vec();
    let mut target = name;
    if let Some(alias) = ALIASES.iter().find(|alias| alias.name == name) {
        target = alias.problem;
        set.insert(0, (alias.set.0.into(), alias.set.1.into()));
    }
    let spec = ALL.iter().find(|spec| spec.name == target).ok_or_else(|| {
        let known = ALL.iter().map(|spec| spec.name).chain(ALIASES.iter().map(|alias| alias.name));
        NameError::unknown("problem", name, known)
    })?;
    (spec.build)(&Parameters::new(spec.parameters, &set)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lsvi::Jacobian;
    use proptest::prelude::*;

    /// The two statements of each problem agree, values and Jacobians, and the Jacobian is the derivative.
    #[test]
    fn hand_written_equations_are_the_generic_ones() {
        proptest!(ProptestConfig::with_cases(64), |(t in 0.0..10.0, seed in prop::collection::vec(-2.0..2.0, 6))| {
            for spec in ALL {
                let problem = build(spec.name, &[]).expect("defaults are valid");
                let (field, ode) = (problem.field(), problem.ode());
                let n = ode.dim();
                prop_assert_eq!(field.dim(), n);
                let v = &seed[..n];
                let (mut a, mut b) = (vec![0.0; n], vec![0.0; n]);
                field.rhs(t, v, &mut a);
                ode.rhs(t, v, &mut b);
                let mut automatic = Jacobian::zeros(n);
                field.add_jacobian(t, v, 1.0, &mut automatic);
                let mut by_hand = Jacobian::zeros(n);
                ode.jacobian(t, v, &mut |i, j, x| by_hand.add(i, j, x));
                // A dozen operations on numbers no larger than the largest of the result, the parameters and the state.
                let scale = |x: f64| 16.0 * f64::EPSILON * (x.abs() + 4e3);
                for i in 0..n {
                    prop_assert!((a[i] - b[i]).abs() <= scale(a[i]), "{} f[{i}]: {} and {}", spec.name, a[i], b[i]);
                    for j in 0..n {
                        let (x, y) = (automatic.get(i, j), by_hand.get(i, j));
                        prop_assert!((x - y).abs() <= scale(x), "{} J[{i},{j}]: {x} and {y}", spec.name);
                    }
                }
            }
        });
    }

    /// Exact solutions start at the initial state and satisfy the equations.
    #[test]
    fn exact_solutions_are_solutions() {
        for spec in ALL.iter().filter(|spec| spec.name != "poiseuille-ansatz") {
            let problem = build(spec.name, &[]).expect("defaults are valid");
            let Some(start) = problem.exact(0.0) else { continue };
            let n = start.len();
            // The formulas at t = 0 take a dozen roundings of numbers of order 1.
            let distance = start.iter().zip(problem.initial()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(distance <= 8.0 * f64::EPSILON, "{} starts {distance:e} away", spec.name);
            for t in [0.3, 1.0, 2.5] {
                let e = 1e-4;
                let at = |t: f64| problem.exact(t).expect("known for all times");
                let mut f = vec![0.0; n];
                problem.ode().rhs(t, &at(t), &mut f);
                let ends = [at(t - 2.0 * e), at(t - e), at(t + e), at(t + 2.0 * e)];
                for i in 0..n {
                    let rate = (ends[0][i] - 8.0 * ends[1][i] + 8.0 * ends[2][i] - ends[3][i]) / (12.0 * e);
                    // Fourth-order difference: ε/e for values of order 1, times the stiffness that f has of roundoff.
                    assert!((rate - f[i]).abs() < 1e-10, "{} at t = {t}: {rate} and {}", spec.name, f[i]);
                }
            }
        }
    }

    #[test]
    fn bad_parameters_are_refused_by_name() {
        let set = |name: &str, value: &str| vec![(name.to_owned(), value.to_owned())];
        assert!(
            matches!(build("logistik", &[]), Err(NameError::Unknown { suggestion: Some(s), .. }) if s == "logistic")
        );
        assert!(matches!(build("logistic", &set("lamda", "1")), Err(NameError::Unknown { .. })));
        assert!(matches!(build("linear-drag", &set("lambda", "fast")), Err(NameError::Value { .. })));
        assert!(matches!(build("linear-drag", &set("lambda", "NaN")), Err(NameError::Value { .. })));
        assert!(matches!(build("poiseuille-ansatz", &set("reduction", "both")), Err(NameError::Value { .. })));
        for (name, value) in [("eccentricity", "1"), ("eccentricity", "-0.1"), ("omega", "0")] {
            let problem = if name == "omega" { "harmonic-oscillator" } else { "kepler" };
            assert!(matches!(build(problem, &set(name, value)), Err(NameError::Value { .. })), "{name} = {value}");
        }
        assert!(build("poiseuille-galerkin", &set("gamma", "1e-3")).is_ok());
    }
}
