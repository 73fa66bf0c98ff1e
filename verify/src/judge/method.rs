//! The method of a file as one of the methods under test.

use std::sync::Arc;

use lsvi::{Integrator, VectorField};

use super::analysis::Analysis;
use super::file::MethodFile;
use crate::kinds::Stability;
use crate::method::{BuildError, Method, Traits};
use crate::problem::Problem;

/// A method with the coefficients of a file.
#[derive(Debug, Clone)]
pub struct FileMethod {
    name: String,
    traits: Traits,
    theory: Arc<dyn Analysis>,
}

impl FileMethod {
    /// The method `name` with the coefficients of `theory`.
    pub fn new(name: &str, theory: Arc<dyn Analysis>) -> Self {
        Self { name: name.into(), traits: theory.traits(), theory }
    }

    /// The method of `file`.
    pub fn of(file: &MethodFile) -> Self {
        Self::new(&file.name, file.body.analyse(None, None))
    }

    /// What speaks against the order `claimed`, if runs have another.
    pub fn refutes(&self, claimed: u32) -> Option<String> {
        let coefficients = format!("its coefficients have order {}", self.theory.order());
        match self.theory.lowered() {
            Some(why) => (claimed != self.traits.order).then(|| format!("{coefficients}, but {why}")),
            None => (claimed != self.theory.order()).then_some(coefficients),
        }
    }

    /// The same, with another order expected of it.
    #[must_use]
    pub(super) fn expected(&self, order: u32) -> Self {
        Self { traits: Traits { order, ..self.traits.clone() }, ..self.clone() }
    }

    /// The same for a look at what its order is at hλ ≫ 1: on the step sizes of one that damps, where hλ is so large that what is not
    /// damped, by 1 − O(1/hλ) in a step, is not damped by their number either.
    pub(super) fn unexpected(&self) -> Self {
        const ANY: u32 = 2;
        let traits =
            Traits { order: ANY, stiff_order: Some(ANY), stability: Stability::Damping, ..self.traits.clone() };
        Self { traits, ..self.clone() }
    }

    /// The same with one coefficient moved by `by`, for each of those that are printed to few digits, with how far that one may be off.
    pub(super) fn moved(&self, by: f64) -> Vec<(f64, Self)> {
        let with = |(radius, theory)| (radius, Self { theory, ..self.clone() });
        self.theory.moved(by).into_iter().map(with).collect()
    }

    /// Its integrator of any field.
    ///
    /// # Errors
    /// Why it does not apply, or that double precision does not hold its coefficients.
    pub fn integrator<'a, F: VectorField + 'a>(&self, field: F) -> Result<Box<dyn Integrator + 'a>, String> {
        self.theory.on_field(Box::new(field))
    }
}

impl Method for FileMethod {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn traits(&self) -> Traits {
        self.traits.clone()
    }

    fn momentum_roundoff(&self, steps: f64) -> f64 {
        self.theory.momentum_roundoff(steps)
    }

    fn rounding_of_coefficients(&self, size: f64, length: f64, steps: f64) -> f64 {
        self.theory.rounding_of_coefficients(size, length, steps)
    }

    fn filled(&self, problem: &dyn Problem) -> usize {
        self.theory.unknowns() * problem.ode().dim()
    }

    fn build<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, BuildError> {
        crate::method::check_filled(self, problem)?;
        self.theory.on_problem(problem).map_err(|reason| BuildError { method: self.name(), reason })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of six Gauss nodes, which follows from simplifying assumptions: conditions by trees are not counted so far.
    #[test]
    fn a_claim_is_held_against_the_order_that_is_found_by_whatever_way() {
        let text = include_str!("../../tests/it/gauss6.toml");
        let method = FileMethod::of(&MethodFile::parse("gauss6.toml", "gauss6", text).expect("a method"));
        assert_eq!(method.refutes(12), None);
        assert_eq!(method.refutes(11).as_deref(), Some("its coefficients have order 12"));
    }
}
