//! Runs of a method that come as a file, against what its coefficients promise.

use lsvi::{Grid, Integrator, Jacobian, Mass, State, Structure, VectorField};

use super::method::FileMethod;
use super::problem::{Autonomous, Linear, NonAutonomous, window};
use super::theory::Theory;
use super::verdict::{Kind, Verdict};
use crate::evidence::{Check, Outcome, Requirement};
use crate::measure::norm::distance;
use crate::measure::order::OrderFit;
use crate::order::{Truth, measure};
use crate::problem::{self, Problem};

/// A measured order, or why there is none.
#[derive(Debug)]
pub struct MeasuredOrder {
    /// What kind of problem it is: linear, nonlinear, non-autonomous, stiff.
    pub kind: &'static str,
    /// The problem.
    pub problem: &'static str,
    /// The order that theory gives there, and from which conditions.
    pub expected: Option<(f64, &'static str)>,
    /// The fit.
    pub result: Result<OrderFit, String>,
}

impl MeasuredOrder {
    /// Theory and measurement agree, or they do not.
    pub fn verdict(&self) -> Verdict {
        let (outcome, reason) = match (&self.result, self.expected) {
            (Ok(fit), Some((_, from))) => (fit.verdict.into(), format!("{}, from {from}", fit.reason)),
            (Ok(fit), None) => (fit.verdict.into(), fit.reason.clone()),
            (Err(reason), _) => (Outcome::NotRun, reason.clone()),
        };
        let fit = self.result.as_ref().ok();
        let check = Check {
            id: format!("measured/{}", self.kind),
            statement: format!("On {}, {}, the order measured is that of theory", self.problem, self.kind),
            outcome,
            measured: fit.and_then(|fit| fit.line).map(|line| line.slope),
            required: fit.map(|fit| Requirement::Near(fit.expected.order, fit.expected.band)),
            reason,
        };
        Verdict { kind: Kind::Run, subject: self.kind.into(), check }
    }
}

/// Orders measured on a linear, a nonlinear, a non-autonomous and a stiff problem.
pub fn orders(method: &FileMethod, theory: &Theory) -> Vec<MeasuredOrder> {
    let main = theory.main.order;
    let linear = theory.linear.solution.map_or(main, |(order, _)| order);
    let run = |kind, name, problem: &dyn Problem, order: u32, from| {
        let fit = measure(problem, &method.expected(order), Truth::Exact).map_err(|error| error.to_string());
        let expected = fit.as_ref().ok().map(|fit| (fit.expected.order, from));
        MeasuredOrder { kind, problem: name, expected, result: fit }
    };
    let rows = if theory.wrong_rows().is_empty() { "the order conditions" } else { "the conditions with c as given" };
    vec![
        run("linear", "v̇ = Av", &Linear(window(linear)), linear, "the series of R(z)"),
        run("nonlinear", "v̇ = f(v)", &Autonomous(window(main)), main, "the order conditions"),
        run("non-autonomous", "v̇ = f(t, v)", &NonAutonomous(window(theory.order_in_time)), theory.order_in_time, rows),
        stiff(method, theory),
    ]
}

/// Prothero and Robinson's problem, where theory has an order for hλ ≫ 1.
fn stiff(method: &FileMethod, theory: &Theory) -> MeasuredOrder {
    let (kind, name) = ("stiff", "prothero-robinson");
    let none = |reason: &str| MeasuredOrder { kind, problem: name, expected: None, result: Err(reason.into()) };
    if !theory.alpha.is_some_and(|alpha| alpha > 0.0) {
        return none("the negative axis is not in the region of stability: hλ must stay of order 1");
    }
    if theory.stiff_order().is_none() {
        return none("A is singular or R(∞) does not damp: the errors are no power of h there");
    }
    // So stiff that terms in 1/(hλ) are small beside the leading one at every step size.
    let set = [("lambda".to_owned(), "1e6".to_owned())];
    let problem = problem::build(name, &set).map_err(|error| error.to_string());
    let fit = problem.and_then(|p| measure(&*p, method, Truth::Exact).map_err(|error| error.to_string()));
    let expected = fit.as_ref().ok().map(|fit| (fit.expected.order, "the defects of the stages"));
    MeasuredOrder { kind, problem: name, expected, result: fit }
}

/// Step of the measured defects: large, so that what is no symmetry is far above roundoff.
const STEP: f64 = 0.5;
/// Spacing of the differences that give the derivative of a step; their error is of its fourth power.
const SPACING: f64 = 1e-3;
/// What a defect that vanishes can be measured as: roundoff over the spacing, and the fourth power of the spacing times a
/// fifth derivative of the step, each with two digits to spare.
const VANISHES: f64 = 1e-10;

/// Defects of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defects {
    /// ‖Mᵀ J M − J‖ of a step's derivative M on Hénon and Heiles' problem.
    pub symplectic: f64,
    /// |Φ_{−h}(Φ_h(y)) − y| there.
    pub symmetric: f64,
}

/// f with t and its own sign reversed: a step of it is a step of f with −h.
struct Reversed<'a>(Box<dyn VectorField + 'a>);

impl VectorField for Reversed<'_> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        self.0.structure()
    }
    fn mass(&self) -> Mass {
        self.0.mass()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(-t, v, dv);
        dv.iter_mut().for_each(|x| *x = -*x);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_jacobian(-t, v, -scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_curvature(-t, v, w, -scale, out);
    }
}

fn step(integrator: &mut dyn Integrator, y: &[f64]) -> Result<Vec<f64>, String> {
    let mut state = State::new(0.0, y.to_vec());
    let grid = Grid::new(0.0, STEP, STEP).map_err(|error| error.to_string())?;
    integrator.advance(&mut state, &grid).map_err(|error| error.to_string())?;
    Ok(state.q)
}

/// The defects of one step of `method`.
///
/// # Errors
/// What made a step fail.
pub fn defects(method: &FileMethod) -> Result<Defects, String> {
    let problem = problem::build("henon-heiles", &[]).map_err(|error| error.to_string())?;
    let y = problem.initial();
    let refused = |error: lsvi::InputError| error.to_string();
    let forward = |y: &[f64]| step(&mut *method.integrator(problem.field()).map_err(refused)?, y);
    let there = forward(&y)?;
    let reversed: Box<dyn VectorField + '_> = Box::new(Reversed(problem.field()));
    let mut back = method.integrator(reversed).map_err(refused)?;
    let symmetric = distance(&step(&mut *back, &there)?, &y);
    let n = y.len();
    let mut columns = Vec::new();
    for j in 0..n {
        let at = |k: f64| {
            let mut shifted = y.clone();
            shifted[j] += k * SPACING;
            forward(&shifted)
        };
        let [far_left, left, right, far_right] = [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
        let entry = |i: usize| (8.0 * (right[i] - left[i]) - (far_right[i] - far_left[i])) / (12.0 * SPACING);
        columns.push((0..n).map(entry).collect::<Vec<f64>>());
    }
    // ω(x, y) = Σ x_k y_{k+m} − x_{k+m} y_k, coordinates before momenta.
    let m = n / 2;
    let omega = |x: &[f64], y: &[f64]| (0..m).map(|k| x[k] * y[k + m] - x[k + m] * y[k]).sum::<f64>();
    let mut symplectic = 0.0_f64;
    for i in 0..n {
        for j in 0..n {
            let required = if j == i + m {
                1.0
            } else if i == j + m {
                -1.0
            } else {
                0.0
            };
            symplectic = symplectic.max((omega(&columns[i], &columns[j]) - required).abs());
        }
    }
    Ok(Defects { symplectic, symmetric })
}

impl Defects {
    /// What the conditions on the coefficients say, held to the measured defects.
    pub fn verdicts(&self, theory: &Theory) -> [Verdict; 2] {
        let verdict = |name: &str, what: &str, by_condition: bool, defect: f64| {
            let vanishes = defect <= VANISHES;
            let (says, required) = match by_condition {
                true => ("vanishes, as the coefficients say", Requirement::AtMost(VANISHES)),
                false => ("does not vanish, as the coefficients say", Requirement::Above(VANISHES)),
            };
            // A defect of high order can be small without vanishing; one that should vanish cannot be large.
            let outcome = match (by_condition, vanishes) {
                (true, true) => Outcome::Pass,
                (false, false) if defect > VANISHES => Outcome::Pass,
                (false, true) => Outcome::Inconclusive,
                _ => Outcome::Fail,
            };
            let check = Check {
                id: format!("measured/{name}"),
                statement: format!("The defect of {what} of a step {says}"),
                outcome,
                measured: Some(defect),
                required: Some(required),
                reason: format!("a step of h = {STEP} on `henon-heiles` has the defect {defect:.1e}, {required}"),
            };
            Verdict { kind: Kind::Run, subject: name.into(), check }
        };
        [
            verdict("symplectic", "symplecticity", theory.symplectic_defect.is_none(), self.symplectic),
            verdict("symmetric", "symmetry", theory.symmetric, self.symmetric),
        ]
    }
}
