//! The method of a file as one of the methods under test.

use std::sync::Arc;

use lsvi::{Integrator, VectorField};

use super::analysis::Analysis;
use super::claim::Property;
use super::file::MethodFile;
use evidence::Outcome;
use experiments::kinds::Stability;
use experiments::method::{BuildError, Method, Traits};
use experiments::problem::Problem;

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

    /// What a multistep method is that is not zero-stable, with its root: no errors of it fall with the step.
    pub fn diverges(&self) -> Option<String> {
        let finding = self.theory.find(Property::ZeroStable)?;
        let is_refuted = finding.outcome == Outcome::Fail;
        is_refuted.then(|| format!("not zero-stable, and converges in no run: {}", finding.why))
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
        experiments::method::check_filled(self, problem)?;
        self.theory.on_problem(problem).map_err(|reason| BuildError { method: self.name(), reason })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::Shipped;
    use experiments::measure::norm::distance;
    use experiments::run::step_from;

    /// Of six Gauss nodes, which follows from simplifying assumptions: conditions by trees are not counted so far.
    #[test]
    fn a_claim_is_held_against_the_order_that_is_found_by_whatever_way() {
        let text = include_str!("../../tests/it/gauss6.toml");
        let method = FileMethod::of(&MethodFile::parse("gauss6.toml", "gauss6", text).expect("a method"));
        assert_eq!(method.refutes(12), None);
        assert_eq!(method.refutes(11).as_deref(), Some("its coefficients have order 12"));
    }

    /// Of ρ = (z − 1)(z + 5), to which no stages have an answer.
    #[test]
    fn a_root_beyond_the_unit_circle_is_why_runs_do_not_converge() {
        let wrong = method("kind = 'multistep'\norder = 3\nrho = [-5, 4, 1]\nsigma = [2, 4, 0]\n").diverges();
        assert!(wrong.as_ref().is_some_and(|why| why.contains('5')), "{wrong:?}");
        assert!(shipped("bdf7").diverges().is_some());
        assert_eq!(["bdf6", "rk4", "stormer-verlet"].map(|name| shipped(name).diverges()), [None, None, None]);
    }

    fn method(text: &str) -> FileMethod {
        FileMethod::of(&MethodFile::parse("m.toml", "m", text).unwrap_or_else(|error| panic!("{text}{error}")))
    }

    /// The kinds that have no c of their own have the same order where f depends on time.
    #[test]
    fn an_order_that_no_abscissa_lowers_is_that_of_the_coefficients() {
        for text in [
            "kind = 'galerkin'\ndegree = 2\nnodes = ['1/3', 1]\nweights = ['3/4', '1/4']\n",
            "kind = 'path-fitted'\nnodes = ['1/4', '5/6']\n",
        ] {
            let method = method(text);
            assert_eq!(method.refutes(3), None);
            assert_eq!(method.refutes(2).as_deref(), Some("its coefficients have order 3"));
        }
    }

    /// With a unit more in the third place of one decimal, as a file prints it.
    #[test]
    fn a_moved_coefficient_is_that_of_a_file_with_other_digits() {
        let problem = experiments::problem::build("henon-heiles", &[]).expect("known");
        let end = |method: &FileMethod| step_from(&*problem, problem.initial(), method, 0.25).expect("it steps");
        for text in [
            "digits = 3\na = [['0.211', 0], ['0.577', '0.212']]\nb = ['0.499', '0.501']\n",
            "digits = 3\nkind = 'partitioned-runge-kutta'\na = [[0, 0], ['0.498', '0.502']]\nb = ['0.499', '0.501']\n\
             a_hat = [['0.497', 0], ['0.503', 0]]\nb_hat = ['0.496', '0.504']\n",
            "digits = 3\nkind = 'nystrom'\na = [[0, 0], ['0.123', 0]]\nb_bar = ['0.321', '0.179']\nb = ['0.499', '0.501']\nc = ['0.211', '0.789']\n",
            "digits = 3\nkind = 'galerkin'\ndegree = 2\nnodes = ['0.211', '0.789']\nweights = ['0.499', '0.501']\n",
            "digits = 3\nkind = 'path-fitted'\nnodes = ['0.211', '0.789']\n",
        ] {
            let with_other_digits = text.match_indices("'0.").map(|(at, _)| {
                let decimal = &text[at + 1..at + 6];
                let other = 0.001 + decimal.parse::<f64>().expect("three places");
                end(&method(&text.replace(decimal, &format!("{other:.3}"))))
            });
            let mut left: Vec<Vec<f64>> = with_other_digits.collect();
            let before = end(&method(text));
            for (radius, moved) in method(text).moved(1e-3) {
                let after = end(&moved);
                let at = left.iter().position(|known| distance(known, &after) < 1e-14);
                left.remove(at.unwrap_or_else(|| panic!("{text}{after:?} is not among {left:?}")));
                assert!((radius - 5e-4).abs() < 1e-12 && distance(&before, &after) > 1e-9, "{radius:e} {after:?}");
            }
            assert!(left.is_empty(), "{text}{left:?}");
        }
    }

    fn shipped(name: &str) -> FileMethod {
        FileMethod::of(&Shipped::by_name(name).expect("there").read().expect("well-formed"))
    }

    #[test]
    fn an_order_that_is_expected_takes_the_place_of_that_of_the_coefficients() {
        let method = shipped("rk4");
        assert_eq!(method.expected(3).traits().order, 3);
        let traits = method.unexpected().traits();
        assert_eq!((traits.order, traits.stiff_order), (2, Some(2)));
    }

    /// Two stages on a plane and its momenta, none of which an explicit method finds together.
    #[test]
    fn a_step_finds_every_component_of_every_stage_together() {
        let problem = experiments::problem::build("henon-heiles", &[]).expect("known");
        assert_eq!(["gauss2", "rk4"].map(|name| shipped(name).filled(&*problem)), [8, 0]);
    }

    #[test]
    fn a_momentum_that_the_state_carries_has_its_own_roundings() {
        let galerkin = method("kind = 'galerkin'\ndegree = 2\nnodes = ['1/3', 1]\nweights = ['3/4', '1/4']\n");
        let [few, many] = [1.0, 1e4].map(|steps| galerkin.momentum_roundoff(steps));
        assert!(few > 0.0 && many > few, "{few}, {many}");
        for name in ["rk4", "stormer-verlet", "bdf2"] {
            assert_eq!(shipped(name).momentum_roundoff(1e4), 0.0, "{name}");
        }
    }
}
