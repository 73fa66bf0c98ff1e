//! The problems, one file each.
//!
//! A problem states its equations twice: generically for `lsvi`, which differentiates them, and by hand as an
//! [`Ode`] for the references. A test holds the two against each other.

mod asymmetric_pendulum;
mod burgers;
pub mod changes;
pub(crate) mod channel;
mod charged_particle;
mod circle;
mod damped_pendulum;
mod double_pendulum;
mod elliptic;
mod facts;
pub(crate) mod flow;
mod harmonic_oscillator;
mod heat_2d;
mod henon_heiles;
mod hires;
pub mod jumps;
mod kepler;
mod linear_drag;
mod logistic;
mod mechanics;
pub mod model;
mod non_normal;
mod oregonator;
mod pendulum;
mod pleiades;
mod poiseuille_ansatz;
pub mod poiseuille_series;
mod prothero_robinson;
mod published;
mod quadratic_drag;
mod robertson;
pub mod rounding;
mod spherical_pendulum;
mod tabulated;
mod unit_sphere;
mod van_der_pol;

use std::fmt;

use lsvi::solver::StepSolver;
use lsvi::{InputError, Lagrangian, LeastSquares, VectorField};

pub use facts::{Facts, Singular, Stiffness, Window};
pub use mechanics::{Invariant, Mechanics};
pub use poiseuille_ansatz::PoiseuilleAnsatz;
pub use published::{Published, published};
pub use tabulated::tabulated_digits;

use crate::kinds::Principle;
use crate::names::{NameError, Parameter, Parameters};
use crate::reference::Ode;

/// An initial value problem with its parameters set.
pub trait Problem: fmt::Debug + Send + Sync {
    /// Names of the [observed](Self::observe) components, in order; one name for all the values of a grid function.
    fn components(&self) -> &'static [&'static str];

    /// What is shown of a state at time t, an affine function of it: the state itself, unless it holds coefficients of a function.
    fn observe(&self, _t: f64, state: &[f64]) -> Vec<f64> {
        state.to_vec()
    }

    /// The state at t = 0.
    fn initial(&self) -> Vec<f64>;

    /// The right-hand side that the methods under test integrate.
    fn field(&self) -> Box<dyn VectorField + '_>;

    /// The solver of the linear systems of a step, where the structure of the field alone does not suggest the best: the
    /// methods that take one solve with it, to its own tolerance.
    fn solver(&self) -> Option<Box<dyn StepSolver>> {
        None
    }

    /// The Lagrangian that the variational methods discretise, if it is not the least-squares one of the field.
    fn own_lagrangian(&self) -> Option<Box<dyn Lagrangian + '_>> {
        None
    }

    /// The Lagrangian that the variational methods discretise.
    ///
    /// # Errors
    /// [`InputError`] if the mass matrix of the field is no metric.
    fn lagrangian(&self) -> Result<Box<dyn Lagrangian + '_>, InputError> {
        let of_field = || LeastSquares::new(self.field()).map(|lagrangian| Box::new(lagrangian) as _);
        self.own_lagrangian().map_or_else(of_field, Ok)
    }

    /// The mechanical system behind the equations, where there is one: the state is then (q, p), momenta after coordinates.
    fn mechanics(&self) -> Option<Mechanics<'_>> {
        None
    }

    /// The functions of the state that are known to be conserved.
    fn invariants(&self) -> Vec<Invariant<'_>> {
        Vec::new()
    }

    /// The functions of the state whose course is of interest: what is conserved, unless there is more.
    fn quantities(&self) -> Vec<Invariant<'_>> {
        self.invariants()
    }

    /// The same system by hand, for the references.
    fn ode(&self) -> &dyn Ode;

    /// The observed components at time t that the error of a run is measured against, where they are known.
    fn exact(&self, _t: f64) -> Option<Vec<f64>> {
        None
    }

    /// The solution at a few times, rounded from one with [more digits](tabulated_digits) than a double has.
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

    /// What is known of the solution: the default is a problem that is not stiff, on a time scale of order 1.
    fn facts(&self) -> Facts {
        Facts::default()
    }

    /// Whether explicit references would need steps far below the solution's own scale.
    fn is_stiff(&self) -> bool {
        self.facts().stiffness.is_fast()
    }

    /// End of the time interval for cross-checks.
    fn horizon(&self) -> f64 {
        self.facts().window.horizon
    }

    /// End of the cross-checks of what can be resolved up to a later time.
    fn far_horizon(&self) -> f64 {
        self.horizon()
    }
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

impl<'a> Limit<'a> {
    /// That of a partial differential equation discretised in space.
    fn semi_discrete(problem: &'a dyn Problem, exact: impl Fn(f64) -> Option<Vec<f64>> + Sync + 'a) -> Self {
        Self {
            name: "semi-discrete",
            ode: problem.ode(),
            initial: problem.initial(),
            exact: Box::new(exact),
            order: None,
            reason: "the equation discretised in space",
        }
    }
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
    non_normal::SPEC,
    robertson::SPEC,
    hires::SPEC,
    oregonator::SPEC,
    pleiades::SPEC,
    channel::POISEUILLE,
    channel::COUETTE,
    channel::WOMERSLEY,
    channel::STOKES2,
    burgers::SPEC,
    heat_2d::SPEC,
    flow::CAVITY,
    flow::MANUFACTURED,
    flow::CHANNEL,
    flow::KOVASZNAY,
    flow::TAYLOR_GREEN,
    flow::SHEAR_LAYER,
    flow::TURBULENCE,
];

/// The problems that every method is run on: all but the flows, which have studies of their own.
pub fn paired() -> impl Iterator<Item = &'static Spec> {
    ALL.iter().filter(|spec| !flow::NAMES.contains(&spec.name))
}

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

/// The problem that `text` names, `name parameter=value …`.
///
/// # Errors
/// [`NameError`] for an unknown name or parameter, or an unusable value.
pub fn build_setting(text: &str) -> Result<Box<dyn Problem>, NameError> {
    let mut words = text.split_whitespace();
    let name = words.next().unwrap_or_default();
    let set = words.map(|word| word.split_once('=').unwrap_or((word, "")));
    build(name, &set.map(|(parameter, value)| (parameter.into(), value.into())).collect::<Vec<_>>())
}

/// Smaller versions for the studies that run every pair of problem and method.
const SMALL: &[(&str, &str, &str)] = &[
    ("channel-poiseuille", "cells", "8"),
    ("channel-couette", "cells", "8"),
    ("channel-womersley", "cells", "8"),
    ("channel-stokes2", "cells", "8"),
    ("burgers", "cells", "8"),
    ("heat-2d", "cells", "5"),
    ("cavity", "cells", "6"),
    ("cavity-manufactured", "cells", "6"),
    ("channel-2d", "cells", "4"),
    ("kovasznay", "cells", "6"),
    ("taylor-green", "cells", "8"),
    ("shear-layer", "cells", "8"),
    ("turbulence-2d", "cells", "8"),
];

/// The parameters that make the problem `name` small, where it is large.
pub fn small_settings(name: &str) -> Vec<(String, String)> {
    let set = SMALL.iter().filter(|(problem, ..)| *problem == name);
    set.map(|(_, parameter, value)| ((*parameter).into(), (*value).into())).collect()
}

/// The default problem `name`, or a smaller version of it where it is large.
///
/// # Errors
/// [`NameError`] for an unknown name.
pub fn small(name: &str) -> Result<Box<dyn Problem>, NameError> {
    build(name, &small_settings(name))
}

/// The names of `problem`'s observed components, those of a grid function numbered from 1.
pub fn component_names(problem: &dyn Problem) -> Vec<String> {
    match (problem.components(), problem.observe(0.0, &problem.initial()).len()) {
        ([name], count) if count > 1 => (1..=count).map(|i| format!("{name}{i}")).collect(),
        (names, _) => names.iter().map(|name| (*name).to_owned()).collect(),
    }
}

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
    use crate::measure::norm::Extremes;
    use lsvi::{Jacobian, Mass, Structure, check_derivatives};
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    /// Unknowns of the largest problem.
    fn most_unknowns() -> usize {
        let sizes = ALL.iter().map(|spec| small(spec.name).expect("defaults are valid").ode().dim());
        sizes.max().unwrap_or(0)
    }

    /// Room for the Jacobian of `field`: dense if the field keeps none.
    fn matrix(field: &dyn VectorField) -> Jacobian {
        match field.structure() {
            Structure::MatrixFree => Jacobian::zeros(field.dim()),
            structure => Jacobian::with_structure(field.dim(), &structure),
        }
    }

    /// The mass matrix of `field`.
    fn mass(field: &dyn VectorField) -> DMatrix<f64> {
        let n = field.dim();
        match field.mass() {
            Mass::Identity => DMatrix::identity(n, n),
            Mass::Diagonal(m) => DMatrix::from_diagonal(&m.into()),
            Mass::Matrix(m) => m.to_dense(),
            _ => panic!("the mass matrix of a small problem has entries"),
        }
    }

    /// The two statements of each problem agree, values and Jacobians, and the Jacobian is the derivative.
    #[test]
    fn hand_written_equations_are_the_generic_ones() {
        proptest!(ProptestConfig::with_cases(64), |(t in 0.0..10.0, seed in prop::collection::vec(-2.0..2.0, most_unknowns()))| {
            for spec in ALL {
                let problem = small(spec.name).expect("defaults are valid");
                let (field, ode) = (problem.field(), problem.ode());
                let n = ode.dim();
                prop_assert_eq!(field.dim(), n);
                let v = &seed[..n];
                let (mut a, mut b) = (vec![0.0; n], vec![0.0; n]);
                field.rhs(t, v, &mut a);
                ode.rhs(t, v, &mut b);
                let mut automatic = matrix(&*field);
                field.add_jacobian(t, v, 1.0, &mut automatic);
                let mut by_hand = DMatrix::zeros(n, n);
                ode.jacobian(t, v, &mut |i, j, x| by_hand[(i, j)] += x);
                let (x, mut product) = (seed[most_unknowns() - n..].to_vec(), vec![0.0; n]);
                ode.product(t, v, &x, &mut product);
                let of_entries: DVector<f64> = &by_hand * DVector::from(x);
                let largest = by_hand.amax() * n as f64;
                for (a, b) in product.iter().zip(of_entries.iter()) {
                    prop_assert!((a - b).abs() <= 64.0 * f64::EPSILON * (4e3 + largest), "{} J x: {a} and {b}", spec.name);
                }
                // M v̇ = f of the methods is v̇ = f of the references.
                let mass = mass(&*field);
                let (automatic, by_hand) = (automatic.to_dense(), &mass * by_hand);
                b = (&mass * DVector::from(b)).as_slice().to_vec();
                for i in 0..n {
                    // A dozen operations on numbers no larger than the largest of the result, the parameters and the terms.
                    let terms: f64 = (0..n).map(|j| by_hand[(i, j)].abs() * (1.0 + v[j].abs())).sum();
                    let scale = |x: f64| 16.0 * f64::EPSILON * (x.abs() + 4e3 + terms);
                    prop_assert!((a[i] - b[i]).abs() <= scale(a[i]), "{} f[{i}]: {} and {}", spec.name, a[i], b[i]);
                    for j in 0..n {
                        let (x, y) = (automatic[(i, j)], by_hand[(i, j)]);
                        prop_assert!((x - y).abs() <= scale(x), "{} J[{i},{j}]: {x} and {y}", spec.name);
                    }
                }
            }
        });
    }

    /// Jacobian, transposed product and curvature are those of f, near the initial state.
    #[test]
    fn derivatives_are_derivatives() {
        proptest!(ProptestConfig::with_cases(16), |(shift in prop::collection::vec(-0.1..0.1, most_unknowns()))| {
            for spec in ALL {
                let problem = small(spec.name).expect("defaults are valid");
                let v: Vec<f64> = problem.initial().iter().zip(&shift).map(|(v, x)| v + x).collect();
                let checked = check_derivatives(&*problem.field(), 0.3, &v);
                prop_assert!(checked.is_ok(), "{}: {checked:?}", spec.name);
            }
        });
    }

    /// Exact solutions start at the initial state and satisfy the equations.
    #[test]
    fn exact_solutions_are_solutions() {
        for spec in ALL {
            let problem = small(spec.name).expect("defaults are valid");
            let limit = problem.limit(Principle::Equation);
            let Some(start) = (limit.exact)(0.0) else { continue };
            let initial = problem.initial();
            let n = start.len();
            // To the few roundings of its own that a solution by eigenvectors makes for each unknown.
            let off = start.iter().zip(&initial).map(|(a, b)| (a - b).abs()).largest();
            assert!(off <= 8.0 * n as f64 * f64::EPSILON, "{}: {off:e}", spec.name);
            for t in [0.3, 1.0, 2.5] {
                let e = 1e-4;
                let at = |t: f64| (limit.exact)(t).expect("known for all times");
                let mut f = vec![0.0; n];
                let v = at(t);
                limit.ode.rhs(t, &v, &mut f);
                let mut terms = vec![0.0; n];
                limit.ode.jacobian(t, &v, &mut |i, j, x| terms[i] += (x * v[j]).abs());
                let ends = [at(t - 2.0 * e), at(t - e), at(t + e), at(t + 2.0 * e)];
                for i in 0..n {
                    let rate = (ends[0][i] - 8.0 * ends[1][i] + 8.0 * ends[2][i] - ends[3][i]) / (12.0 * e);
                    // Fourth-order difference: ε/e for values of order 1, or the roundoff of the terms of f where they are larger.
                    let bound = 1e-10 * (1.0 + terms[i]);
                    assert!((rate - f[i]).abs() < bound, "{} at t = {t}: {rate} and {}", spec.name, f[i]);
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
        // Refused before anything is allocated.
        for cells in ["1", "-4", "8.5", "1000000000000", "99999999999999999999999"] {
            for problem in ["channel-couette", "burgers", "heat-2d"] {
                assert!(
                    matches!(build(problem, &set("cells", cells)), Err(NameError::Value { .. })),
                    "{problem} {cells}"
                );
            }
        }
        for (name, value) in [("scheme", "spectral"), ("nu", "0"), ("omega", "-1")] {
            assert!(matches!(build("channel-stokes2", &set(name, value)), Err(NameError::Value { .. })), "{name}");
        }
        assert!(matches!(build_setting("channel-couette cells"), Err(NameError::Value { .. })));
    }

    #[test]
    fn absurd_numbers_of_cells_are_refused() {
        for spec in ALL.iter().filter(|spec| spec.parameters.iter().any(|p| p.name == "cells")) {
            for cells in ["0", "1", "-3", "2.5", "many", "1000000000", "99999999999999999999999"] {
                let error = build(spec.name, &[("cells".into(), cells.into())]).map(|_| ());
                assert!(
                    matches!(error, Err(NameError::Value { value, .. }) if value == cells),
                    "{} {cells}",
                    spec.name
                );
            }
        }
    }
}
