//! Closures beyond (α, β): fitted to a decay rate, best over a range of steps, and windows of several steps.

use lsvi::closure::{Linear, LinearClosure};
use lsvi::discrete::{MomentumWeights, Trapezoidal};
use lsvi::{InputError, Integrator, Window};

use super::least_squares::stepped;
use super::{Build, BuildError, Method, Spec, Traits, check_filled, check_limit};
use crate::kinds::{Principle, Stability};
use crate::names::{Call, NameError};
use crate::problem::Problem;

pub(super) const FITTED: Spec = Spec {
    form: "fitted(LAMBDA)",
    summary: "p_{n+1} = θ(h LAMBDA) p_n, exact on v̇ = −LAMBDA v: order 2 where growth is below LAMBDA/2, A-stable",
    build: Build::Arguments(|call| Fitted::build(call, ("fitted", None), Linear::fitted)),
    examples: &["fitted(4)"],
};

pub(super) const FITTED_PADE: Spec = Spec {
    form: "fitted-pade(LAMBDA)",
    summary: "θ = 1/(1 + h LAMBDA/2): order 2 where growth is below LAMBDA/2, order 3 on v̇ = −LAMBDA v, A-stable",
    build: Build::Arguments(|call| Fitted::build(call, ("fitted-pade", Some(3)), Linear::fitted_pade)),
    examples: &["fitted-pade(4)"],
};

pub(super) const MINIMAX: Spec = Spec {
    form: "minimax(H1,H2)",
    summary: "the constant θ with the least error on v̇ = −v for h in [H1, H2]: order 2, A-stable",
    build: Build::Arguments(|call| {
        let [from, to] = call.numbers(MINIMAX.form)?;
        let closure = Linear::minimax(from, to).map_err(|error| refused(call, MINIMAX.form, &error))?;
        Ok(Box::new(Minimax { from, to, weights: closure.weights(1.0) }))
    }),
    examples: &["minimax(0,2)"],
};

pub(super) const WINDOW: Spec = Spec {
    form: "window(K)",
    summary: "K steps of least action found together, p = 0 at their end: order 2, Method I for K = 1",
    build: Build::Arguments(|call| {
        let [length] = call.numbers(WINDOW.form)?;
        let refuse =
            |reason: &str| NameError::Form { call: call.to_string(), form: WINDOW.form.into(), reason: reason.into() };
        if length.fract() != 0.0 || !(1.0..=LONGEST).contains(&length) {
            return Err(refuse(&format!("K must be a whole number from 1 to {LONGEST}")));
        }
        Ok(Box::new(WindowMethod { length: length as usize }))
    }),
    examples: &["window(4)"],
};

/// Longest window that can be asked for: its equations are solved at once.
const LONGEST: f64 = 1e4;

fn refused(call: &Call, form: &str, error: &InputError) -> NameError {
    NameError::Form { call: call.to_string(), form: form.into(), reason: error.to_string() }
}

#[derive(Debug)]
struct Fitted {
    name: &'static str,
    rate: f64,
    /// The order on v̇ = −λv; none where a step is exact.
    order_at_rate: Option<u32>,
    closure: fn(f64) -> Result<Linear, InputError>,
}

impl Fitted {
    fn build(
        call: &Call,
        (name, order_at_rate): (&'static str, Option<u32>),
        closure: fn(f64) -> Result<Linear, InputError>,
    ) -> Result<Box<dyn Method>, NameError> {
        let form = format!("{name}(LAMBDA)");
        let [rate] = call.numbers(&form)?;
        closure(rate).map_err(|error| refused(call, &form, &error))?;
        Ok(Box::new(Self { name, rate, order_at_rate, closure }))
    }
}

impl Method for Fitted {
    fn name(&self) -> String {
        format!("{}({:?})", self.name, self.rate)
    }

    fn traits(&self) -> Traits {
        let fitted = self.order_at_rate.map(|order| (self.rate, order));
        Traits { stages: 2, fitted, ..Traits::new(2, Principle::MomentumDecaying, Stability::Neutral) }
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        problem.ode().dim()
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        check_filled(self, problem)?;
        check_limit(problem).map_err(|reason| BuildError { method: self.name(), reason })?;
        let closure = (self.closure)(self.rate).map_err(BuildError::of(self))?;
        stepped(self, problem, closure)
    }
}

#[derive(Debug)]
struct Minimax {
    from: f64,
    to: f64,
    /// Of steps of any size.
    weights: MomentumWeights,
}

impl Method for Minimax {
    fn name(&self) -> String {
        format!("minimax({:?},{:?})", self.from, self.to)
    }

    fn traits(&self) -> Traits {
        Traits { stiff_order: Some(1), stages: 2, ..Traits::new(2, Principle::MomentumZero, Stability::Neutral) }
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        problem.ode().dim()
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        check_filled(self, problem)?;
        let closure = Linear::new(self.weights.alpha, self.weights.beta).map_err(BuildError::of(self))?;
        stepped(self, problem, closure)
    }
}

#[derive(Debug)]
struct WindowMethod {
    length: usize,
}

impl Method for WindowMethod {
    fn name(&self) -> String {
        format!("window({})", self.length)
    }

    fn traits(&self) -> Traits {
        let traits = Traits::new(2, Principle::MomentumZero, Stability::Damping);
        Traits { stiff_order: Some(1), stages: 2, rows_per_solve: self.length, ..traits }
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        self.length.saturating_mul(problem.ode().dim())
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        check_filled(self, problem)?;
        let lagrangian = problem.lagrangian().map_err(BuildError::of(self))?;
        let window = Window::new(Trapezoidal::new(lagrangian), self.length).map_err(BuildError::of(self))?;
        Ok(Box::new(window))
    }
}
