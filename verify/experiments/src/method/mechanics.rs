//! The integrators of mechanics: path fitting \[KY21\] and the classical and Galerkin variational integrators \[MW01\].

use lsvi::discrete::{Constrainable, Galerkin, KongYangCircle, Midpoint, PathFitted, Trapezoidal};
use lsvi::quadrature::{LagrangeBasis, NodeFamily, Quadrature};
use lsvi::{Constrained, EulerLagrange, Grid, InputError, Integrator, State, StepError, Work, position_momentum};

use super::{Build, BuildError, Method, Spec, Traits};
use crate::kinds::{Principle, Stability, Symplecticity};
use crate::names::{Call, NameError};
use crate::problem::{Mechanics, Problem};

pub(super) const PATH_FITTED: Spec = Spec {
    form: "path-fitted(M)",
    summary: "degree M on nodes i/M, [KY21]: order 2⌊M/2⌋; or on (M,gauss|lobatto|chebyshev)",
    build: Build::Arguments(|call| {
        let family = match call.arguments.get(1).map(String::as_str) {
            None => NodeFamily::Equispaced,
            Some("gauss") => NodeFamily::Gauss,
            Some("lobatto") => NodeFamily::Lobatto,
            Some("chebyshev") => NodeFamily::Chebyshev,
            Some(_) => return Err(refuse(call, PATH_FITTED_FORM, "the nodes are gauss, lobatto or chebyshev")),
        };
        let degree = degree(call, PATH_FITTED_FORM, 2, 2)?;
        Ok(Box::new(Mechanical(Discretisation::PathFitted { degree, family })))
    }),
    examples: &[
        "path-fitted(2)",
        "path-fitted(3)",
        "path-fitted(4)",
        "path-fitted(3,gauss)",
        "path-fitted(4,gauss)",
        "path-fitted(4,lobatto)",
        "path-fitted(4,chebyshev)",
    ],
};

const PATH_FITTED_FORM: &str = "path-fitted(M) or path-fitted(M,gauss|lobatto|chebyshev)";

pub(super) const PATH_FITTED_BERNSTEIN: Spec = Spec {
    form: "path-fitted-bernstein(M)",
    summary: "path-fitted(M) with Bernstein coefficients as unknowns, [KY21] (13)",
    build: Build::Arguments(|call| {
        let degree = degree(call, "path-fitted-bernstein(M)", 2, 1)?;
        Ok(Box::new(Mechanical(Discretisation::Bernstein { degree })))
    }),
    examples: &["path-fitted-bernstein(4)"],
};

pub(super) const KONG_YANG_CIRCLE: Spec = Spec {
    form: "kong-yang-circle",
    summary: "motion on a circle by [KY21] (23), its square roots supplied: the radius is unstable",
    build: Build::Plain(|| Box::new(CircleScheme)),
    examples: &[],
};

pub(super) const MIDPOINT: Spec = Spec {
    form: "midpoint-vi",
    summary: "straight path, midpoint rule, [KY21] (17): order 2, symplectic",
    build: Build::Plain(|| Box::new(Mechanical(Discretisation::Midpoint))),
    examples: &["midpoint-vi"],
};

pub(super) const STORMER_VERLET: Spec = Spec {
    form: "stormer-verlet",
    summary: "straight path, trapezoidal rule; RATTLE with constraints: order 2, symplectic",
    build: Build::Plain(|| Box::new(Mechanical(Discretisation::StormerVerlet))),
    examples: &["stormer-verlet"],
};

pub(super) const GALERKIN_GAUSS: Spec = Spec {
    form: "galerkin-gauss(D)",
    summary: "path of degree D, D Gauss nodes, [MW01]: order 2D, symplectic",
    build: Build::Arguments(|call| {
        let degree = degree(call, "galerkin-gauss(D)", 1, 1)?;
        Ok(Box::new(Mechanical(Discretisation::GalerkinGauss { degree })))
    }),
    examples: &["galerkin-gauss(2)", "galerkin-gauss(3)", "galerkin-gauss(4)"],
};

pub(super) const GALERKIN_LOBATTO: Spec = Spec {
    form: "galerkin-lobatto(D)",
    summary: "path of degree D, D + 1 Lobatto nodes, [MW01]: order 2D, symplectic",
    build: Build::Arguments(|call| {
        let degree = degree(call, "galerkin-lobatto(D)", 1, 1)?;
        Ok(Box::new(Mechanical(Discretisation::GalerkinLobatto { degree })))
    }),
    examples: &["galerkin-lobatto(2)", "galerkin-lobatto(3)"],
};

/// Largest degree that a name may ask for: far beyond it roundoff leaves nothing of the order.
const HIGHEST: usize = 24;

/// The first of at most `arguments` arguments, a degree of at least `least`.
fn degree(call: &Call, form: &str, least: usize, arguments: usize) -> Result<usize, NameError> {
    if call.arguments.is_empty() || call.arguments.len() > arguments {
        return Err(refuse(call, form, &format!("it has {} arguments", call.arguments.len())));
    }
    match call.arguments[0].parse::<usize>() {
        Ok(degree) if (least..=HIGHEST).contains(&degree) => Ok(degree),
        _ => Err(refuse(call, form, &format!("the degree is a whole number from {least} to {HIGHEST}"))),
    }
}

fn refuse(call: &Call, form: &str, reason: &str) -> NameError {
    NameError::Form { call: call.to_string(), form: form.into(), reason: reason.into() }
}

/// A discretisation of a mechanical Lagrangian with the position–momentum closure.
#[derive(Debug)]
struct Mechanical(Discretisation);

#[derive(Debug, Clone)]
enum Discretisation {
    PathFitted {
        degree: usize,
        family: NodeFamily,
    },
    Bernstein {
        degree: usize,
    },
    Midpoint,
    StormerVerlet,
    GalerkinGauss {
        degree: usize,
    },
    GalerkinLobatto {
        degree: usize,
    },
    /// A path through its values at any interior nodes.
    PathFittedOn {
        interior: Vec<f64>,
    },
    /// Any quadrature.
    GalerkinOn {
        degree: usize,
        quadrature: Quadrature,
    },
}

/// Path fitting on interior nodes of one's own.
///
/// # Errors
/// [`InputError`] for nodes that are not distinct points inside the step.
pub fn path_fitted_on(interior: &[f64]) -> Result<Box<dyn Method>, InputError> {
    LagrangeBasis::new(&[&[0.0], interior, &[1.0]].concat())?;
    Ok(Box::new(Mechanical(Discretisation::PathFittedOn { interior: interior.to_vec() })))
}

/// The Galerkin integrator of this degree with a quadrature of one's own, which may be inconsistent.
///
/// # Errors
/// [`InputError`] for a quadrature that is none.
pub fn galerkin_on(degree: usize, nodes: &[f64], weights: &[f64]) -> Result<Box<dyn Method>, InputError> {
    let quadrature = Quadrature::inconsistent(nodes.to_vec(), weights.to_vec())?;
    Ok(Box::new(Mechanical(Discretisation::GalerkinOn { degree, quadrature })))
}

impl Method for Mechanical {
    fn name(&self) -> String {
        use Discretisation as D;
        match &self.0 {
            D::PathFitted { degree, family } => match family {
                NodeFamily::Equispaced => format!("path-fitted({degree})"),
                NodeFamily::Gauss => format!("path-fitted({degree},gauss)"),
                NodeFamily::Lobatto => format!("path-fitted({degree},lobatto)"),
                NodeFamily::Chebyshev => format!("path-fitted({degree},chebyshev)"),
            },
            D::Bernstein { degree } => format!("path-fitted-bernstein({degree})"),
            D::Midpoint => "midpoint-vi".into(),
            D::StormerVerlet => "stormer-verlet".into(),
            D::GalerkinGauss { degree } => format!("galerkin-gauss({degree})"),
            D::GalerkinLobatto { degree } => format!("galerkin-lobatto({degree})"),
            D::PathFittedOn { interior } => format!("path-fitted on {interior:?}"),
            D::GalerkinOn { degree, quadrature } => format!("galerkin({degree}) on {:?}", quadrature.nodes()),
        }
    }

    /// Every node family is symmetric. A path has a discrete Lagrangian where its defect vanishes at Gauss nodes, of which the
    /// midpoint of degree 2 is one; an even number m − 1 of other symmetric nodes leaves a defect along an even derivative of q.
    fn traits(&self) -> Traits {
        use Discretisation as D;
        let fitted = |degree: usize, family: NodeFamily| {
            let is_gauss = family == NodeFamily::Gauss || degree == 2;
            let order = if family == NodeFamily::Gauss { 2 * (degree - 1) } else { 2 * (degree / 2) };
            let symplectic = if is_gauss { Symplecticity::ConstantMass } else { Symplecticity::Never };
            (order, symplectic, !is_gauss && degree % 2 == 1, None)
        };
        // Of nodes of one's own their order is known to whoever has them.
        let (order, symplectic, has_even_defect, restates) = match self.0 {
            D::PathFittedOn { ref interior } => (interior.len(), Symplecticity::Never, false, None),
            D::GalerkinOn { degree, .. } => (2 * degree, Symplecticity::Always, false, None),
            D::PathFitted { degree, family } => fitted(degree, family),
            D::Bernstein { degree } => {
                let lagrange = Mechanical(D::PathFitted { degree, family: NodeFamily::Equispaced });
                let (order, symplectic, has_even_defect, _) = fitted(degree, NodeFamily::Equispaced);
                (order, symplectic, has_even_defect, Some(lagrange.name()))
            }
            D::Midpoint | D::StormerVerlet => (2, Symplecticity::Always, false, None),
            D::GalerkinGauss { degree } | D::GalerkinLobatto { degree } => {
                (2 * degree, Symplecticity::Always, false, None)
            }
        };
        // Gauss collocation is A-stable; the others are implicit to be accurate, not stable.
        let stability = match self.0 {
            D::Midpoint | D::GalerkinGauss { .. } => Stability::Neutral,
            _ => Stability::Conditional,
        };
        let stages = match self.0 {
            D::Midpoint | D::StormerVerlet => 1,
            D::PathFittedOn { ref interior } => interior.len(),
            D::PathFitted { degree, .. } | D::Bernstein { degree } => degree - 1,
            D::GalerkinGauss { degree } => degree,
            D::GalerkinLobatto { degree } => degree + 1,
            D::GalerkinOn { ref quadrature, .. } => quadrature.nodes().len(),
        };
        let traits = Traits::new(order as u32, Principle::Hamilton, stability);
        Traits { symplectic, is_reversible: true, has_even_defect, restates, stages: stages as u32, ..traits }
    }

    /// Λ N^{3/2} with Λ² = Σ_j l_j′(1)², the squares of the coefficients of the unknowns in h ∂L/∂v at the end of a fitted path;
    /// Λ = 1 where p comes from the mean velocity (q₁ − q₀)/h.
    ///
    /// Only the last two Bernstein coefficients enter p₁, with ± m, but their equations are as ill-conditioned.
    fn momentum_roundoff(&self, steps: f64) -> f64 {
        let slopes_on = |interior: &[f64]| {
            let nodes = [&[0.0], interior, &[1.0]].concat();
            Ok(LagrangeBasis::new(&nodes)?.derivatives(1.0)[1..].iter().map(|slope| slope * slope).sum::<f64>().sqrt())
        };
        let slopes = |family: NodeFamily, degree| slopes_on(&family.interior(degree)?);
        let coefficients: Result<f64, InputError> = match self.0 {
            Discretisation::PathFittedOn { ref interior } => slopes_on(interior),
            Discretisation::PathFitted { degree, family } => slopes(family, degree),
            Discretisation::Bernstein { degree } => slopes(NodeFamily::Equispaced, degree),
            _ => Ok(1.0),
        };
        random_walk(coefficients.unwrap_or(f64::INFINITY), steps)
    }

    fn discretise_held<'a>(
        &self,
        lagrangian: Box<dyn EulerLagrange + 'a>,
    ) -> Option<Result<Box<dyn Constrainable + 'a>, InputError>> {
        Some(self.0.discretise(lagrangian))
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        let Mechanics { lagrangian, constraint, .. } = mechanics_of(problem, self)?;
        let refuse = |error: InputError| BuildError { method: self.name(), reason: error.to_string() };
        let discrete = self.0.discretise(lagrangian).map_err(refuse)?;
        Ok(match constraint {
            None => Box::new(PhaseSpace::new(position_momentum(discrete))),
            Some(constraint) => {
                let held = Constrained::new(discrete, constraint).map_err(refuse)?;
                Box::new(PhaseSpace::new(held))
            }
        })
    }
}

/// The error in q, in units of ε |q|, of N steps that each leave roundings times Λ/h in the momentum: Λ N^{3/2}.
///
/// Roundings of q are uniform in ± ½ ε |q| and independent; at either end of a step they change the momentum, and the
/// motion carries each change on to the end. The sum has a standard deviation of (√2/6) Λ N^{3/2} ε |q| ([HLW06] VIII.5); the
/// bound is four of it.
pub(super) fn random_walk(coefficient: f64, steps: f64) -> f64 {
    coefficient * steps * steps.sqrt()
}

pub(super) fn mechanics_of<'a>(problem: &'a dyn Problem, method: &dyn Method) -> Result<Mechanics<'a>, BuildError> {
    let reason = "it is stated as a first-order system, without a Lagrangian of mechanics";
    problem.mechanics().ok_or_else(|| BuildError { method: method.name(), reason: reason.into() })
}

/// \[KY21\] (23).
#[derive(Debug)]
struct CircleScheme;

impl Method for CircleScheme {
    fn name(&self) -> String {
        "kong-yang-circle".into()
    }

    /// The order is that of its truncation error: it does not converge. Its momenta are derivatives of one function of both
    /// ends, symmetric in them.
    fn traits(&self) -> Traits {
        let traits = Traits::new(2, Principle::Hamilton, Stability::Unstable);
        Traits { symplectic: Symplecticity::Always, is_reversible: true, ..traits }
    }

    /// p₁ = (3q₁ + q₀ − 4η)/h.
    fn momentum_roundoff(&self, steps: f64) -> f64 {
        random_walk(5.0, steps)
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        let system = mechanics_of(problem, self)?;
        if system.constraint.is_none() || system.lagrangian.dim() != 2 {
            return Err(BuildError { method: self.name(), reason: "it is no motion on a circle".into() });
        }
        Ok(Box::new(PhaseSpace::new(position_momentum(KongYangCircle::new(2)))))
    }
}

impl Discretisation {
    fn discretise<'a>(&self, l: Box<dyn EulerLagrange + 'a>) -> Result<Box<dyn Constrainable + 'a>, InputError> {
        Ok(match *self {
            Self::PathFittedOn { ref interior } => Box::new(PathFitted::new(l, interior)?),
            Self::GalerkinOn { degree, ref quadrature } => Box::new(Galerkin::new(l, degree, quadrature)?),
            Self::PathFitted { degree, family } => Box::new(PathFitted::on(l, family, degree)?),
            Self::Bernstein { degree } => {
                Box::new(PathFitted::bernstein(l, &NodeFamily::Equispaced.interior(degree)?)?)
            }
            Self::Midpoint => Box::new(Midpoint::new(l)),
            Self::StormerVerlet => Box::new(Trapezoidal::new(l)),
            Self::GalerkinGauss { degree } => Box::new(Galerkin::gauss(l, degree)?),
            Self::GalerkinLobatto { degree } => Box::new(Galerkin::lobatto(l, degree)?),
        })
    }
}

/// An integrator of (q, p) as one of the vector that holds q and then p, like the methods for first-order systems.
#[derive(Debug)]
pub(super) struct PhaseSpace<I> {
    integrator: I,
    state: State,
}

impl<I: Integrator> PhaseSpace<I> {
    pub(super) fn new(integrator: I) -> Self {
        let state = State::new(0.0, vec![0.0; integrator.dim()]);
        Self { integrator, state }
    }
}

impl<I: Integrator> Integrator for PhaseSpace<I> {
    fn dim(&self) -> usize {
        2 * self.integrator.dim()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        let (q, p) = state.q.split_at_mut(self.integrator.dim());
        self.state.t = state.t;
        self.state.q.copy_from_slice(q);
        self.state.p.copy_from_slice(p);
        self.integrator.advance(&mut self.state, grid)?;
        state.t = self.state.t;
        q.copy_from_slice(&self.state.q);
        p.copy_from_slice(&self.state.p);
        Ok(())
    }

    fn work(&self) -> Work {
        self.integrator.work()
    }
}

#[cfg(test)]
mod tests {
    use crate::method::parse;
    use crate::problem;

    #[test]
    fn methods_say_what_a_problem_lacks() {
        let reason = |problem: &str, method: &str| {
            let problem = problem::build(problem, &[]).expect("defaults are valid");
            let error = parse(method).expect("registered").build(&*problem).err();
            error.map(|error| error.to_string())
        };
        for method in ["midpoint-vi", "path-fitted(3)", "kong-yang-circle"] {
            let message = reason("logistic", method).expect("no mechanics");
            assert!(message.contains(method) && message.contains("without a Lagrangian of mechanics"), "{message}");
        }
        for problem in ["kepler", "spherical-pendulum"] {
            assert!(reason(problem, "kong-yang-circle").is_some_and(|message| message.contains("circle")));
        }
        assert_eq!(reason("circle", "kong-yang-circle"), None);
        assert_eq!(reason("damped-pendulum", "galerkin-lobatto(3)"), None);
    }
}
