//! The yardsticks.

use lsvi::Integrator;
use lsvi::classic::{Bdf2, RungeKutta, Tableau};

use super::{Build, BuildError, Method, Spec, Stability};
use crate::problem::{Principle, Problem};

pub(super) const IMPLICIT_EULER: Spec = Spec {
    form: "implicit-euler",
    summary: "order 1, L-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "implicit-euler",
            order: 1,
            stability: Stability::Damping,
            stiff_order: Some(1),
            tableau: Tableau::implicit_euler,
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
            order: 4,
            stability: Stability::Conditional,
            stiff_order: None,
            tableau: Tableau::rk4,
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
            order: 2,
            stability: Stability::Neutral,
            stiff_order: Some(2),
            tableau: Tableau::trapezoidal,
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
            order: 2,
            stability: Stability::Neutral,
            stiff_order: Some(2),
            tableau: Tableau::implicit_midpoint,
        })
    }),
    examples: &["implicit-midpoint"],
};

pub(super) const SDIRK2: Spec = Spec {
    form: "sdirk2",
    summary: "two-stage SDIRK with γ = 1 − √2/2, order 2, L-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "sdirk2",
            order: 2,
            stability: Stability::Damping,
            stiff_order: None,
            tableau: Tableau::sdirk2,
        })
    }),
    examples: &["sdirk2"],
};

pub(super) const TR_BDF2: Spec = Spec {
    form: "tr-bdf2",
    summary: "trapezoidal rule, then backward differentiation in one step: order 2, L-stable",
    build: Build::Plain(|| {
        Box::new(OneStepMethod {
            name: "tr-bdf2",
            order: 2,
            stability: Stability::Damping,
            stiff_order: Some(2),
            tableau: Tableau::tr_bdf2,
        })
    }),
    examples: &["tr-bdf2"],
};

pub(super) const BDF2: Spec = Spec {
    form: "bdf2",
    summary: "second-order backward differentiation, started by SDIRK2, L-stable",
    build: Build::Plain(|| Box::new(Bdf2Method)),
    examples: &["bdf2"],
};

#[derive(Debug)]
struct OneStepMethod {
    name: &'static str,
    order: u32,
    stability: Stability,
    stiff_order: Option<u32>,
    tableau: fn() -> Tableau,
}

impl Method for OneStepMethod {
    fn name(&self) -> String {
        self.name.into()
    }

    fn order(&self) -> u32 {
        self.order
    }

    fn stiff_order(&self) -> Option<u32> {
        self.stiff_order
    }

    fn principle(&self) -> Principle {
        Principle::Equation
    }

    fn stability(&self) -> Stability {
        self.stability
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        Ok(Box::new(RungeKutta::new(problem.field(), (self.tableau)())))
    }
}

#[derive(Debug)]
struct Bdf2Method;

impl Method for Bdf2Method {
    fn name(&self) -> String {
        "bdf2".into()
    }

    fn order(&self) -> u32 {
        2
    }

    fn principle(&self) -> Principle {
        Principle::Equation
    }

    fn stability(&self) -> Stability {
        Stability::Damping
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        Ok(Box::new(Bdf2::new(problem.field())))
    }
}
