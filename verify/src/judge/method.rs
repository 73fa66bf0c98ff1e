//! The method of a file as one of the methods under test.

use lsvi::classic::{CoupledRungeKutta, RungeKutta, Tableau as LowerTriangular};
use lsvi::{InputError, Integrator, VectorField};

use super::file::{Body, MethodFile};
use super::linear::Reach;
use super::tableau::Shape;
use super::theory::Theory;
use crate::kinds::{Principle, Stability, Symplecticity};
use crate::method::{BuildError, Method, Traits};
use crate::problem::Problem;

/// A Runge–Kutta method with the coefficients of a file.
#[derive(Debug, Clone)]
pub struct FileMethod {
    name: String,
    traits: Traits,
    is_coupled: bool,
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    c: Vec<f64>,
}

impl FileMethod {
    /// The method `name` with the coefficients of `theory`, and of the order that they have with c as given.
    pub fn new(name: &str, theory: &Theory) -> Self {
        let (a, b, c) = theory.numbers.doubles();
        let infinity = theory.stability.at_infinity().abs();
        let stability = match theory.alpha {
            Some(alpha) if alpha > 0.0 && infinity < 0.95 => Stability::Damping,
            Some(alpha) if alpha > 0.0 => Stability::Neutral,
            _ if matches!(theory.negative, Reach::UpTo { end: 0.0, .. }) => Stability::Unstable,
            _ => Stability::Conditional,
        };
        Self {
            name: name.into(),
            traits: Traits {
                stiff_order: theory.stiff_order(),
                symplectic: match theory.symplectic_defect {
                    None => Symplecticity::Always,
                    Some(_) => Symplecticity::Never,
                },
                is_reversible: theory.symmetric,
                ..Traits::new(theory.order_in_time, Principle::Equation, stability)
            },
            is_coupled: theory.shape == Shape::FullyImplicit,
            a,
            b,
            c,
        }
    }

    /// The method of `file`.
    pub fn of(file: &MethodFile) -> Self {
        let Body::RungeKutta(tableau) = &file.body;
        Self::new(&file.name, &Theory::new(tableau, None, None))
    }

    /// The same, with another order expected of it.
    #[must_use]
    pub(super) fn expected(&self, order: u32) -> Self {
        Self { traits: Traits { order, ..self.traits.clone() }, ..self.clone() }
    }

    /// Its integrator of any field.
    ///
    /// # Errors
    /// [`InputError`] for coefficients that double precision does not hold.
    pub fn integrator<'a, F: VectorField + 'a>(&self, field: F) -> Result<Box<dyn Integrator + 'a>, InputError> {
        if self.is_coupled {
            return Ok(Box::new(CoupledRungeKutta::new(field, &self.a, &self.b, &self.c)?));
        }
        let tableau = LowerTriangular::lower_triangular(&self.a, &self.b, &self.c)?;
        Ok(Box::new(RungeKutta::new(field, tableau)?))
    }
}

impl Method for FileMethod {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn traits(&self) -> Traits {
        self.traits.clone()
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        if self.is_coupled { self.b.len() * problem.ode().dim() } else { 0 }
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        crate::method::check_filled(self, problem)?;
        let refused = |error: InputError| BuildError { method: self.name(), reason: error.to_string() };
        self.integrator(problem.field()).map_err(refused)
    }
}
