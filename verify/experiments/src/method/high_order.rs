//! Galerkin least-squares variational integrators: polynomial paths of any degree under any quadrature.

use lsvi::closure::Linear;
use lsvi::discrete::Galerkin;
use lsvi::quadrature::Quadrature;
use lsvi::{InputError, Integrator, Variational};

use super::{Build, BuildError, Method, Spec, Traits, check_filled};
use crate::kinds::{Principle, Stability, Symplecticity};
use crate::names::{Call, NameError};
use crate::problem::Problem;

pub(super) const LS_GALERKIN: Spec = Spec {
    form: "ls-galerkin(S,gauss|lobatto|radau,R)",
    summary: "paths of degree S, R = S or S + 1 nodes, Method I; a fourth argument `ii` or `A:B` closes otherwise",
    build: Build::Arguments(|call| Ok(Box::new(LsGalerkin::of(call)?))),
    examples: &[
        "ls-galerkin(2,radau,2)",
        "ls-galerkin(2,lobatto,2)",
        "ls-galerkin(2,lobatto,3)",
        "ls-galerkin(1,lobatto,2,ii)",
        "ls-galerkin(2,lobatto,3,-0.5:1)",
    ],
};

/// Highest degree that has a name: orders beyond twelve leave no step size between the error and roundoff.
const HIGHEST: usize = 6;

/// A family of quadrature nodes on the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Gauss–Legendre nodes.
    Gauss,
    /// Nodes with both ends.
    Lobatto,
    /// Nodes with the right end.
    Radau,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gauss, Self::Lobatto, Self::Radau];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gauss => "gauss",
            Self::Lobatto => "lobatto",
            Self::Radau => "radau",
        }
    }

    /// The quadrature rule with so many nodes.
    ///
    /// # Errors
    /// [`InputError`] for fewer nodes than the family needs.
    pub fn rule(self, nodes: usize) -> Result<Quadrature, InputError> {
        match self {
            Self::Gauss => Quadrature::gauss(nodes),
            Self::Lobatto => Quadrature::lobatto(nodes),
            Self::Radau => Quadrature::radau(nodes),
        }
    }
}

/// `ls-galerkin` with its arguments.
#[derive(Debug, Clone, Copy)]
pub struct LsGalerkin {
    /// Degree s of the path.
    pub degree: usize,
    /// Family of the nodes.
    pub family: Family,
    /// Number r of nodes.
    pub nodes: usize,
    /// Weight of p₀ in the closure.
    pub alpha: f64,
    /// Weight of p₁ in the closure.
    pub beta: f64,
}

impl LsGalerkin {
    fn of(call: &Call) -> Result<Self, NameError> {
        let form = format!("{} or ls-galerkin(S,…,R,ii|A:B)", LS_GALERKIN.form);
        let refuse = |reason: String| NameError::Form { call: call.to_string(), form: form.clone(), reason };
        let (degree, family, nodes, closure) = match call.arguments.as_slice() {
            [degree, family, nodes] => (degree, family, nodes, None),
            [degree, family, nodes, closure] => (degree, family, nodes, Some(closure)),
            other => return Err(refuse(format!("it has {} arguments, not 3 or 4", other.len()))),
        };
        let family = Family::ALL
            .into_iter()
            .find(|known| known.name() == family)
            .ok_or_else(|| NameError::unknown("family of nodes", family, Family::ALL.map(Family::name)))?;
        let count = |text: &str| text.parse::<usize>().map_err(|_| refuse(format!("`{text}` is not a whole number")));
        let (degree, nodes) = (count(degree)?, count(nodes)?);
        if !(1..=HIGHEST).contains(&degree) {
            return Err(refuse(format!("S = {degree} is not from 1 to {HIGHEST}")));
        }
        if nodes != degree && nodes != degree + 1 {
            return Err(refuse(format!("R = {nodes} is neither S nor S + 1")));
        }
        let (alpha, beta) = match closure.map(|text| (text.as_str(), text.split_once(':'))) {
            None => (0.0, 1.0),
            Some(("ii", _)) => (-1.0, 1.0),
            Some((_, Some((a, b)))) => {
                let number = |text: &str| {
                    text.trim().parse::<f64>().map_err(|_| refuse(format!("`{text}` is not a finite number")))
                };
                (number(a)?, number(b)?)
            }
            Some((text, None)) => return Err(refuse(format!("the closure `{text}` is neither `ii` nor `A:B`"))),
        };
        let method = Self { degree, family, nodes, alpha, beta };
        Linear::new(alpha, beta).and(family.rule(nodes)).map_err(|error| refuse(error.to_string()))?;
        Ok(method)
    }

    /// Whether the residual vanishes at every node, so that all closures are one collocation method.
    pub fn is_collocation(self) -> bool {
        self.nodes == self.degree
    }

    fn conserves(self) -> bool {
        self.alpha + self.beta == 0.0
    }

    /// Collocation has the order of its quadrature, true least squares 2s.
    fn nominal_order(self) -> u32 {
        let twice = 2 * self.degree as u32;
        match (self.is_collocation(), self.family) {
            (true, Family::Radau) => twice - 1,
            (true, Family::Lobatto) => twice - 2,
            _ => twice,
        }
    }

    /// The order where J is symmetric, so that λ is real: the least squares of v̇ − λv, which Gauss's and Radau's rules with s + 1
    /// nodes integrate without error, gain an order or two.
    pub fn symmetric_order(self) -> u32 {
        let order = self.nominal_order();
        if self.is_collocation() || self.family == Family::Lobatto {
            return order;
        }
        match (self.degree.is_multiple_of(2), self.conserves()) {
            (true, true) => order + 2,
            (false, false) if self.alpha == self.beta => order + 2,
            (false, false) => order + 1,
            _ => order,
        }
    }

    /// Known for s ≤ 2; above, terms of relative size s²/(hλ) blur it at any λ that leaves the error above roundoff.
    fn stiff_order(self) -> Option<u32> {
        let collocation = self.is_collocation();
        match (self.degree, self.family) {
            (1, Family::Gauss) => Some(2),
            (1, Family::Radau) if collocation => Some(1),
            (1, Family::Radau) => Some(2),
            (1, Family::Lobatto) => Some(if self.conserves() { 2 } else { 1 }),
            (2, Family::Lobatto) => Some(2),
            (2, Family::Radau) if collocation => Some(2),
            _ => None,
        }
    }

    fn stability_class(self) -> Stability {
        let (a, b) = (self.alpha.abs(), self.beta.abs());
        match self.family {
            Family::Radau if self.is_collocation() => Stability::Damping,
            Family::Lobatto if !self.is_collocation() && a == 0.0 => Stability::Damping,
            _ if self.is_collocation() || a <= b => Stability::Neutral,
            _ => Stability::Conditional,
        }
    }
}

impl Method for LsGalerkin {
    fn name(&self) -> String {
        let Self { degree, family, nodes, alpha, beta } = *self;
        let closure = match (alpha, beta) {
            (0.0, 1.0) => String::new(),
            (-1.0, 1.0) => ",ii".into(),
            _ => format!(",{alpha:?}:{beta:?}"),
        };
        format!("ls-galerkin({degree},{},{nodes}{closure})", family.name())
    }

    fn traits(&self) -> Traits {
        let principle = Principle::of_linear_closure(self.alpha, self.beta);
        let is_gauss = self.is_collocation() && self.family == Family::Gauss;
        let symmetric_nodes = self.family != Family::Radau;
        Traits {
            stiff_order: self.stiff_order(),
            symplectic: if is_gauss { Symplecticity::Always } else { Symplecticity::Never },
            is_reversible: symmetric_nodes && (self.is_collocation() || self.alpha.abs() == self.beta.abs()),
            stages: self.nodes as u32 * if self.is_collocation() { 1 } else { 2 },
            symmetric_order: Some(self.symmetric_order()),
            // Two orders more, found by runs; the midpoint rule gains none.
            square_order: (is_gauss && self.nodes > 1).then(|| self.nominal_order() + 2),
            settles_late: !self.is_collocation() && self.alpha != 0.0,
            ..Traits::new(self.nominal_order(), principle, self.stability_class())
        }
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        self.degree.saturating_mul(problem.ode().dim())
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        check_filled(self, problem)?;
        let unfit = |error: InputError| BuildError { method: self.name(), reason: error.to_string() };
        let closure = Linear::new(self.alpha, self.beta).map_err(unfit)?;
        let rule = self.family.rule(self.nodes).map_err(unfit)?;
        let discrete = Galerkin::new(problem.lagrangian().map_err(unfit)?, self.degree, &rule).map_err(unfit)?;
        Ok(Box::new(Variational::new(discrete, closure)))
    }
}
