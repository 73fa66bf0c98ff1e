//! What is known of a problem beyond its equations, in terms that name no method.

/// Where a quantity is measured: the end of the integration, which starts at t = 0, and the coarsest step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// End of the integration.
    pub horizon: f64,
    /// The coarsest step size.
    pub coarsest: f64,
}

/// How neighbouring solutions approach each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stiffness {
    /// No faster than the solution itself changes.
    None,
    /// At rates up to this one, in a solution that starts with such transients or may.
    Transient(f64),
    /// At this rate, to a smooth solution that does not depend on it.
    Forced(f64),
}

impl Stiffness {
    /// Whether a rate is far beyond those of a solution on a time scale of order 1.
    pub(super) fn is_fast(self) -> bool {
        matches!(self, Self::Transient(rate) | Self::Forced(rate) if rate > 100.0)
    }
}

/// Where J = ∂f/∂v, or J less a positive multiple of the identity, is singular on the solution or beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Singular {
    /// What follows from that, where, and why.
    pub reason: &'static str,
    /// The time from which on it is so; runs that end before are not expected to fail.
    pub from: f64,
    /// Where to measure before that, or in steps short enough for Newton's iteration; nowhere if it is so from the start.
    pub before: Option<Window>,
}

/// The facts of a problem from which [`theory`](crate::theory) derives what a method does on it. The default is a problem
/// whose solution changes on a time scale of order 1, is not stiff, and has a regular Jacobian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// Where an error of second order settles.
    pub window: Window,
    /// The horizon at which an order above 4 is measured in mechanics.
    pub high_order_horizon: f64,
    /// Where an error of a closure of the least-squares Lagrangian settles, if later than others.
    pub least_squares: Option<Window>,
    /// How neighbouring solutions approach each other.
    pub stiffness: Stiffness,
    /// Where J is singular, if it is.
    pub singular: Option<Singular>,
    /// Where J has eigenvalues that are positive and of the size of its rates, if it has.
    pub growing: Option<Singular>,
    /// A norm of J at the start, of a model: nothing else is known of it.
    pub model: Option<f64>,
}

impl Facts {
    /// Those of a partial differential equation discretised in space whose fastest rate of decay is `rate`.
    pub(super) fn semi_discrete(rate: f64) -> Self {
        let window = Window { horizon: 1.0, coarsest: 0.1 };
        Self { window, stiffness: Stiffness::Transient(rate), ..Self::default() }
    }
}

impl Default for Facts {
    fn default() -> Self {
        Self {
            window: Window { horizon: 2.0, coarsest: 0.2 },
            high_order_horizon: 2.0,
            least_squares: None,
            stiffness: Stiffness::None,
            singular: None,
            growing: None,
            model: None,
        }
    }
}
