//! What the coefficients of a method say, whatever its kind.

use std::fmt;
use std::sync::Arc;

use lsvi::{Integrator, VectorField};

use super::claim::Property;
use super::facts::Facts;
use super::theory::Theory;
use super::verdict::{Finding, Verdict};
use evidence::{Figure, Table};
use experiments::method::Traits;
use experiments::problem::{self, Problem, Window};

/// The theory of a method, and the method itself.
pub trait Analysis: fmt::Debug + Send + Sync {
    /// The kind of its file.
    fn kind(&self) -> &'static str;

    /// Kind and shape in a line.
    fn headline(&self) -> String;

    /// The order that the coefficients have.
    fn order(&self) -> u32;

    /// The order on separable systems q̇ = f(p), ṗ = g(q), where the method is for all and that is another question.
    fn order_where_separable(&self) -> Option<u32> {
        None
    }

    /// The order on q̇ = M⁻¹p, ṗ = g(q), where the method is for more and that is another question.
    fn order_where_linear(&self) -> Option<u32> {
        None
    }

    /// The order where f depends on time, with c as given.
    fn order_in_time(&self) -> u32 {
        self.order()
    }

    /// Why runs have a lower order than the coefficients, where they have.
    fn lowered(&self) -> Option<String> {
        let in_time = self.order_in_time();
        (in_time < self.order()).then(|| format!("with its c the order on v̇ = f(t, v) is {in_time}"))
    }

    /// The stages whose row sum is not c_i.
    fn wrong_rows(&self) -> Vec<usize> {
        Vec::new()
    }

    /// Whether the orders claimed, of the method and of an embedded one, hold where f depends on time, with c as given.
    fn keeps_in_time(&self, claimed: u32, _claimed_embedded: Option<u32>) -> bool {
        self.order_in_time() >= claimed
    }

    /// What abscissae cost that are not the sums of the rows and lower no order that is claimed.
    fn own_times(&self) -> Option<Verdict> {
        None
    }

    /// What they say, each with its label.
    fn facts(&self) -> Facts;

    /// Whether it has a property; nothing if its kind is not judged by that.
    fn find(&self, property: Property) -> Option<Finding>;

    /// The coefficients among themselves.
    fn consistency(&self) -> Vec<Verdict> {
        Vec::new()
    }

    /// What is known of the method.
    fn traits(&self) -> Traits;

    /// What the momentum that the state carries, or slopes that are found from values, add to the roundoff of N steps, in units of ε |q|.
    fn momentum_roundoff(&self, _steps: f64) -> f64 {
        0.0
    }

    /// How far coefficients that a file prints to few digits may move the end of a run of N `steps` along a solution of this
    /// `size` and `length`: what the conditions are off by, times |h v̇| in every step.
    fn rounding_of_coefficients(&self, _size: f64, _length: f64, _steps: f64) -> f64 {
        0.0
    }

    /// The method with one coefficient moved by `by`, for each of those that a file prints to few digits, with how far that one may be off:
    /// what steps without time in them make of it.
    fn moved(&self, _by: f64) -> Vec<(f64, Arc<dyn Analysis>)> {
        Vec::new()
    }

    /// Unknowns that a step finds together, for each component of the problem.
    fn unknowns(&self) -> usize {
        0
    }

    /// The method on a vector field.
    ///
    /// # Errors
    /// Why it does not apply.
    fn on_field<'a>(&self, _field: Box<dyn VectorField + 'a>) -> Result<Box<dyn Integrator + 'a>, String> {
        Err("it steps a Lagrangian of mechanics, and not a vector field".into())
    }

    /// The method on a problem.
    ///
    /// # Errors
    /// Why it does not apply.
    fn on_problem<'a>(&self, problem: &'a dyn Problem) -> Result<Box<dyn Integrator + 'a>, String> {
        self.on_field(problem.field())
    }

    /// Where its order is measured.
    fn trials(&self) -> Vec<Trial>;

    /// Why it has no runs, or none that converge however small their errors in a step.
    fn obstacle(&self) -> Option<String> {
        None
    }

    /// Whether its runs converge to the solution at all.
    ///
    /// # Errors
    /// Why not.
    fn converges(&self) -> Result<(), String> {
        let inconsistent = || "its order is 0, so that its runs do not converge to the solution".to_owned();
        let obstacle = self.obstacle().or_else(|| (self.order() == 0).then(inconsistent));
        obstacle.map_or(Ok(()), Err)
    }

    /// Why its runs cost more here than steps of it have to, where they do.
    fn dearer(&self) -> Option<&'static str> {
        None
    }

    /// Whether symplecticity and symmetry of a step are to be measured.
    fn has_structure(&self) -> bool;

    /// Whether its energy on a long motion is to be looked at.
    ///
    /// # Errors
    /// Why not.
    fn steps_mechanics(&self) -> Result<(), String> {
        self.converges()
    }

    /// Its conditions.
    fn tables(&self) -> Vec<Table>;

    /// Where it is stable.
    fn figures(&self) -> Vec<Figure> {
        Vec::new()
    }

    /// The theory of a Runge–Kutta method, if it is one.
    fn as_runge_kutta(&self) -> Option<&Theory> {
        None
    }
}

/// Times over which an order is looked at that does not settle, in those of the first window.
const LONGER: [f64; 2] = [2.0, 4.0];

/// An order to be measured.
#[derive(Debug)]
pub struct Trial {
    /// What kind of problem it is: linear, nonlinear, non-autonomous, stiff.
    pub kind: &'static str,
    /// The problem.
    pub name: &'static str,
    /// What to run, or why there is nothing to run.
    pub plan: Result<Plan, String>,
}

/// A problem and the order that theory has there, if it has.
#[derive(Debug)]
pub struct Plan {
    /// The problem.
    pub problem: Box<dyn Problem>,
    /// The same over longer times, where terms of its error do not cancel that cancel at the end of a shorter one.
    pub longer: Vec<Box<dyn Problem>>,
    /// The order, where theory has one.
    pub order: Option<u32>,
    /// Where that comes from, or why there is none.
    pub from: &'static str,
}

impl Trial {
    /// The order on a problem that only the judge has, in this window.
    pub(super) fn of<P: Problem + 'static>(
        (kind, name): (&'static str, &'static str),
        problem: fn(Window) -> P,
        window: Window,
        order: u32,
        from: &'static str,
    ) -> Self {
        let over =
            |times: f64| Box::new(problem(Window { horizon: times * window.horizon, ..window })) as Box<dyn Problem>;
        let longer = LONGER.map(over).into();
        Self { kind, name, plan: Ok(Plan { problem: over(1.0), longer, order: Some(order), from }) }
    }

    /// The order on a problem of the registry.
    pub(super) fn on(
        kind: &'static str,
        name: &'static str,
        set: &[(String, String)],
        order: u32,
        from: &'static str,
    ) -> Self {
        Self { kind, name, plan: Plan::on(name, set, Some(order), from) }
    }

    /// Prothero and Robinson's problem, so stiff that terms in 1/(hλ) are small beside the leading one at every step size.
    pub(super) fn stiff(order: Option<u32>, from: &'static str) -> Self {
        // Where nothing damps, 1/hλ adds up over the steps of a run; where errors are divided by λ, more is soon at roundoff.
        let lambda = if order.is_some() { "1e6" } else { "1e7" };
        let (name, set) = ("prothero-robinson", [("lambda".to_owned(), lambda.to_owned())]);
        Self { kind: "stiff", name, plan: Plan::on(name, &set, order, from) }
    }
}

impl Plan {
    fn on(name: &str, set: &[(String, String)], order: Option<u32>, from: &'static str) -> Result<Self, String> {
        let problem = problem::build(name, set).map_err(|error| error.to_string())?;
        Ok(Self { problem, longer: Vec::new(), order, from })
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::MethodFile;

    #[test]
    fn a_method_of_order_zero_steps_no_mechanics() {
        for (weight, steps) in [(1, true), (2, false)] {
            let text = format!("a = [[0]]\nb = [{weight}]\n");
            let theory = MethodFile::parse("m.toml", "m", &text).expect("well-formed").body.analyse(None, None);
            assert_eq!(theory.steps_mechanics().is_ok(), steps);
            // That is another question for methods of two parts alone.
            assert_eq!((theory.order_where_separable(), theory.order_where_linear()), (None, None));
        }
    }
}
