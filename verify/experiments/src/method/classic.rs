//! The baseline methods.

use lsvi::Integrator;
use lsvi::classic::{Bdf2, RungeKutta, Tableau};
use lsvi::solver::Augmented;

use super::{Build, BuildError, Method, Spec, Traits};
use crate::kinds::{Principle, Stability, Symplecticity};
use crate::problem::Problem;

pub(super) const IMPLICIT_EULER: Spec = Spec {
    form: "implicit-euler",
    summary: "order 1, L-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "implicit-euler",
            tableau: Tableau::implicit_euler,
            traits: equation(1, Stability::Damping),
        })
    }),
    examples: &["implicit-euler"],
};

pub(super) const RK4: Spec = Spec {
    form: "rk4",
    summary: "the classical explicit Runge–Kutta method, order 4",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "rk4",
            tableau: Tableau::rk4,
            traits: Traits { stiff_order: None, ..equation(4, Stability::Conditional) },
        })
    }),
    examples: &["rk4"],
};

pub(super) const TRAPEZOIDAL: Spec = Spec {
    form: "trapezoidal",
    summary: "the trapezoidal rule, order 2, A-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "trapezoidal",
            tableau: Tableau::trapezoidal,
            traits: Traits { is_reversible: true, ..equation(2, Stability::Neutral) },
        })
    }),
    examples: &["trapezoidal"],
};

pub(super) const IMPLICIT_MIDPOINT: Spec = Spec {
    form: "implicit-midpoint",
    summary: "the implicit midpoint rule, order 2, A-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "implicit-midpoint",
            tableau: Tableau::implicit_midpoint,
            traits: Traits {
                symplectic: Symplecticity::Always,
                is_reversible: true,
                ..equation(2, Stability::Neutral)
            },
        })
    }),
    examples: &["implicit-midpoint"],
};

/// With stages of order 1, the last of them the result, its error at hλ ≫ 1 is ∝ h/λ ([HW96] IV.15); terms ∝ h² are as large
/// up to λ = 10⁴.
pub(super) const SDIRK2: Spec = Spec {
    form: "sdirk2",
    summary: "two-stage SDIRK with γ = 1 − √2/2, order 2, L-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "sdirk2",
            tableau: Tableau::sdirk2,
            traits: Traits { stiff_order: Some(1), stiff_from: 1e5, ..equation(2, Stability::Damping) },
        })
    }),
    examples: &["sdirk2"],
};

pub(super) const TR_BDF2: Spec = Spec {
    form: "tr-bdf2",
    summary: "trapezoidal rule, then backward differentiation in one step: order 2, L-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod { name: "tr-bdf2", tableau: Tableau::tr_bdf2, traits: equation(2, Stability::Damping) })
    }),
    examples: &["tr-bdf2"],
};

pub(super) const BDF2: Spec = Spec {
    form: "bdf2",
    summary: "second-order backward differentiation, started by SDIRK2, L-stable",
    build: Build::Plain(|| Box::new(Bdf2Method)),
    examples: &["bdf2"],
};

/// Of a method of order `order` for the equation itself.
fn equation(order: u32, stability: Stability) -> Traits {
    Traits::new(order, Principle::Equation, stability)
}

#[derive(Debug)]
struct OneStepMethod {
    name: &'static str,
    tableau: fn() -> Tableau,
    traits: Traits,
}

impl Method for OneStepMethod {
    fn name(&self) -> String {
        self.name.into()
    }

    fn traits(&self) -> Traits {
        self.traits.clone()
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        let (field, tableau) = (problem.field(), (self.tableau)());
        let method = match problem.solver() {
            Some(solver) => RungeKutta::with_solver(field, tableau, solver),
            None => RungeKutta::new(field, tableau),
        };
        Ok(Box::new(method.map_err(BuildError::of(self))?))
    }
}

#[derive(Debug)]
struct Bdf2Method;

impl Method for Bdf2Method {
    fn name(&self) -> String {
        "bdf2".into()
    }

    fn traits(&self) -> Traits {
        equation(2, Stability::Damping)
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        let field = problem.field();
        let method = match problem.solver() {
            // What a problem gives once it gives again.
            Some(_) => Bdf2::with_solver(field, || problem.solver().unwrap_or_else(|| Box::new(Augmented::new()))),
            None => Bdf2::new(field),
        };
        Ok(Box::new(method.map_err(BuildError::of(self))?))
    }
}
