//! The closures of the trapezoidal discrete Lagrangian, Eqs. (8), (21)–(27).

use lsvi::closure::Linear;
use lsvi::discrete::Trapezoidal;
use lsvi::{Integrator, LeastSquaresStep, Structure, Variational, VectorField, method_i, position_momentum};

use super::{Build, BuildError, Method, Spec, Traits, check_filled};
use crate::kinds::{Principle, Stability};
use crate::names::NameError;
use crate::problem::Problem;

pub(super) const METHOD_I: Spec = Spec {
    form: "method-i",
    summary: "p_{n+1} = 0, Eq. (22): order 2, L-stable on symmetric dissipative systems",
    build: Build::Plain(|| Box::new(LinearClosure { name: Some("method-i"), alpha: 0.0, beta: 1.0 })),
    examples: &["method-i"],
};

pub(super) const METHOD_II: Spec = Spec {
    form: "method-ii",
    summary: "p_{n+1} = p_n, Eq. (25): order 2, the trapezoidal rule on linear problems whose matrix is invertible",
    build: Build::Plain(|| Box::new(LinearClosure { name: Some("method-ii"), alpha: -1.0, beta: 1.0 })),
    examples: &["method-ii"],
};

pub(super) const EXPLICIT_MOMENTUM: Spec = Spec {
    form: "explicit-momentum",
    summary: "p_n = 0, Eq. (21): order 2, explicit on scalar linear problems",
    build: Build::Plain(|| Box::new(LinearClosure { name: Some("explicit-momentum"), alpha: 1.0, beta: 0.0 })),
    examples: &["explicit-momentum"],
};

pub(super) const LINEAR: Spec = Spec {
    form: "linear(ALPHA,BETA)",
    summary: "ALPHA p_n + BETA p_{n+1} = 0, Eq. (27): order 2, A-stable for |ALPHA| ≤ |BETA|",
    build: Build::Arguments(|call| {
        let [alpha, beta] = call.numbers("linear(ALPHA,BETA)")?;
        Linear::new(alpha, beta).map_err(|error| NameError::Form {
            call: call.to_string(),
            form: "linear(ALPHA,BETA)".into(),
            reason: error.to_string(),
        })?;
        Ok(Box::new(LinearClosure { name: None, alpha, beta }))
    }),
    examples: &["linear(-0.5,1)"],
};

pub(super) const CONVENTIONAL: Spec = Spec {
    form: "conventional",
    summary: "position–momentum form from p_0 = 0, Eq. (8): unstable on dissipative systems",
    build: Build::Plain(|| Box::new(Conventional)),
    examples: &["conventional"],
};

/// Unknowns of a problem with a solver up to which a closure of conserved momentum has factors: 48² cells take seconds a step.
const FACTORED: usize = 48 * 48;

#[derive(Debug)]
struct LinearClosure {
    name: Option<&'static str>,
    alpha: f64,
    beta: f64,
}

impl LinearClosure {
    fn is_method_i(&self) -> bool {
        self.alpha == 0.0
    }
}

impl Method for LinearClosure {
    fn name(&self) -> String {
        self.name.map_or_else(|| format!("linear({:?},{:?})", self.alpha, self.beta), str::to_owned)
    }

    fn traits(&self) -> Traits {
        let conserves = self.alpha + self.beta == 0.0;
        let principle = Principle::of_linear_closure(self.alpha, self.beta);
        let (a, b) = (self.alpha.abs(), self.beta.abs());
        let stability = match a {
            0.0 => Stability::Damping,
            _ if a <= b => Stability::Neutral,
            _ => Stability::Conditional,
        };
        let stiff_order = Some(if conserves { 2 } else { 1 });
        Traits { stiff_order, is_reversible: a == b, stages: 2, ..Traits::new(2, principle, stability) }
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        if self.is_method_i() { 0 } else { problem.ode().dim() }
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        if let Some(solver) = problem.solver() {
            let closure = Linear::new(self.alpha, self.beta).map_err(BuildError::of(self))?;
            let field = problem.field();
            // With α + β = 0 the derivative of the step is −h Jᵀ(2 − hJ) but for factors: it has eigenvalues near zero on both sides of it
            // where h is small, of which a preconditioner made of B = 1 − hJ knows nothing. Factors do not mind, but are those of twice the unknowns.
            let is_small = field.dim() <= FACTORED && !matches!(field.structure(), Structure::MatrixFree);
            let takes_factors = self.alpha + self.beta == 0.0 && is_small;
            let method = match takes_factors {
                true => LeastSquaresStep::new(field, closure),
                false => LeastSquaresStep::with_solver(field, closure, solver),
            };
            return Ok(Box::new(method.map_err(BuildError::of(self))?));
        }
        check_filled(self, problem)?;
        let field = problem.field();
        if self.is_method_i() && !matches!(field.structure(), Structure::Dense) {
            return Ok(Box::new(method_i(field).map_err(BuildError::of(self))?));
        }
        let closure = Linear::new(self.alpha, self.beta).map_err(BuildError::of(self))?;
        stepped(self, problem, closure)
    }
}

#[derive(Debug)]
struct Conventional;

impl Method for Conventional {
    fn name(&self) -> String {
        "conventional".into()
    }

    fn traits(&self) -> Traits {
        Traits::new(2, Principle::EulerLagrange, Stability::Unstable)
    }

    /// An error ε |q|/h of p, a difference of q over h, acts on all later steps; as the motions of a least-squares
    /// Lagrangian part exponentially, those of the first steps outweigh the others: N².
    fn momentum_roundoff(&self, steps: f64) -> f64 {
        steps * steps
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        problem.ode().dim()
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        check_filled(self, problem)?;
        let lagrangian = problem.lagrangian().map_err(BuildError::of(self))?;
        Ok(Box::new(position_momentum(Trapezoidal::new(lagrangian))))
    }
}

/// The integrator by a closure of the trapezoidal Lagrangian of `problem`.
pub(super) fn stepped<'a>(
    method: &dyn Method,
    problem: &'a dyn Problem,
    closure: Linear,
) -> Result<Box<dyn Integrator + 'a>, BuildError> {
    let field = problem.field();
    if problem.own_lagrangian().is_none() && field.structure() == Structure::Dense {
        return Ok(Box::new(LeastSquaresStep::new(field, closure).map_err(BuildError::of(method))?));
    }
    let lagrangian = problem.lagrangian().map_err(BuildError::of(method))?;
    Ok(Box::new(Variational::new(Trapezoidal::new(lagrangian), closure)))
}
