//! What the coefficients of a Runge–Kutta method say without a run.

use nalgebra::{DMatrix, DVector};

use super::conditions::{Condition, conditions, error_norm, order_of};
use super::linear::{LinearOrders, Reach, StabilityFunction, Unstable};
use super::polynomial::VANISHES;
use super::real::Real;
use super::reduce::Reduced;
use super::structure::{
    Indefinite, Simplifying, is_algebraically_stable, is_symmetric, stiffly_accurate, symplectic_defect,
};
use super::tableau::{Numbers, Shape, Tableau, row_sums};
use super::tree::{Colour, Forest, MAX_ORDER, Rule};
use experiments::measure::norm::larger;

/// Largest order for which the trees with a vertex of time are made.
const MAX_TIME_ORDER: u32 = 8;

/// The order of one set of weights.
#[derive(Debug, Clone)]
pub struct WeightsTheory {
    /// The largest order up to which every condition holds; [`MAX_ORDER`] if all do.
    pub order: u32,
    /// The trees.
    pub forest: Forest,
    /// Every condition up to one order more than holds, and at least up to the order claimed.
    pub conditions: Vec<Condition>,
    /// √Σ (residual/σ)² of the first order that does not hold.
    pub error_norm: Option<f64>,
    /// The colours whose rows do not add up to the c of the file: conditions that have the sums are not written with c.
    pub(super) spelled: [bool; 2],
}

impl WeightsTheory {
    pub(super) fn new(numbers: &Numbers, b: &[Real], at_least: u32) -> Self {
        let spelled = [!numbers.row_defects().iter().all(Real::may_be_zero), false];
        let of_forest = |forest: &Forest| conditions(forest, numbers, b);
        Self { spelled, ..Self::search(Rule::Autonomous, (at_least, barrier(numbers)), of_forest) }
    }

    /// The conditions of the trees of `rule`, up to one order more than holds and at least up to `at_least`; the order is `barrier`
    /// at most, whatever few digits leave of the conditions beyond it.
    pub(super) fn search(
        rule: Rule,
        (at_least, barrier): (u32, u32),
        conditions: impl Fn(&Forest) -> Vec<Condition>,
    ) -> Self {
        let mut depth = at_least.clamp(3, rule.most());
        loop {
            let forest = Forest::new(rule, depth);
            let conditions = conditions(&forest);
            let order = order_of(&conditions).min(barrier);
            if order < depth || depth == rule.most() {
                let fails = conditions.iter().any(|c| c.order == order + 1 && !c.holds());
                let error_norm = fails.then(|| error_norm(&forest, &conditions, order + 1));
                return Self { order, forest, conditions, error_norm, spelled: [false; 2] };
            }
            depth += 1;
        }
    }

    /// The condition of a tree, for weights of this name where the trees have one colour: `Σ b_i c_i = 1/2`.
    pub fn formula(&self, tree: usize, name: &str) -> String {
        let name = match (self.forest.rule(), self.forest.trees()[tree].colour) {
            (Rule::SecondOrder, Colour::First) => "b̄",
            (Rule::SecondOrder, _) | (Rule::Partitioned | Rule::Separable, Colour::First) => "b",
            (Rule::Partitioned | Rule::Separable, _) => "b̂",
            _ => name,
        };
        let right = match self.forest.trees()[tree].density {
            1 => "1".to_owned(),
            density => format!("1/{density}"),
        };
        format!("{} = {right}", self.forest.formula(tree, name, self.spelled))
    }

    /// The conditions up to order `p` that do not hold, the first first.
    pub fn failing(&self, p: u32) -> impl Iterator<Item = &Condition> {
        self.conditions.iter().filter(move |c| c.order <= p && !c.holds())
    }

    /// The first condition of the order after the one found, where one fails.
    pub(super) fn beyond(&self) -> Option<&Condition> {
        self.conditions.iter().find(|c| c.order == self.order + 1 && !c.holds())
    }

    /// How far few digits leave the conditions of order `p` open, where they do not tell to [`VANISHES`] of it what makes Φ(τ) equal 1/γ.
    pub(super) fn left_open(&self, p: u32) -> Option<f64> {
        let conditions = || self.conditions.iter().filter(|c| c.order == p);
        let is_open = |c: &Condition| c.residual.radius() * self.forest.trees()[c.tree].density as f64 > VANISHES;
        conditions().any(is_open).then(|| conditions().map(|c| c.residual.radius()).fold(0.0, larger))
    }

    /// The least residual that the digits given could not have told from zero: the largest radius up to the order found.
    pub fn resolution(&self) -> f64 {
        let shown = self.conditions.iter().filter(|c| c.order <= self.order);
        shown.map(|c| c.residual.radius()).fold(0.0, larger)
    }
}

/// All that follows from a tableau.
#[derive(Debug, Clone)]
pub struct Theory {
    /// Its numbers.
    pub numbers: Numbers,
    /// The shape of A.
    pub shape: Shape,
    /// Conditions of b, with Σ_j a_ij for c_i.
    pub main: WeightsTheory,
    /// Conditions of b̂.
    pub embedded: Option<WeightsTheory>,
    /// c_i − Σ_j a_ij, where the file gives c.
    pub row_defects: Option<Vec<Real>>,
    /// Order on v̇ = f(t, v), with c as given; the same as that of b where the row sums hold.
    pub order_in_time: u32,
    /// Butcher's simplifying assumptions.
    pub simplifying: Simplifying,
    /// R(z).
    pub stability: StabilityFunction,
    /// How far |R(iy)| ≤ 1.
    pub imaginary: Reach,
    /// How far |R(−x)| ≤ 1.
    pub negative: Reach,
    /// Largest angle of a stable sector, in degrees.
    pub alpha: Option<f64>,
    /// Orders on v̇ = λ v.
    pub linear: LinearOrders,
    /// The entry of B A + Aᵀ B − b bᵀ that is farthest from zero, on v̇ = f(v).
    pub symplectic_defect: Option<(usize, usize, f64)>,
    /// Whether the method is its own adjoint, on v̇ = f(v).
    pub symmetric: bool,
    /// Why it is not algebraically stable.
    pub algebraic: Result<(), Indefinite>,
    /// The row of A that is b.
    pub stiffly_accurate: Option<usize>,
    /// The method without stages that it does not need.
    pub reduced: Reduced,
    /// The same on v̇ = f(v), which knows of no c beside the sums of the rows: of it the structure is told.
    pub autonomous: Reduced,
}

impl Theory {
    /// The theory of `tableau`, with conditions up to the orders claimed and one more at least.
    pub fn new(tableau: &Tableau, claimed: Option<u32>, claimed_embedded: Option<u32>) -> Self {
        let numbers = tableau.numbers();
        let main = WeightsTheory::new(&numbers, &numbers.b, claimed.unwrap_or(0) + 1);
        let embedded =
            numbers.b_hat.as_ref().map(|b| WeightsTheory::new(&numbers, b, claimed_embedded.unwrap_or(0) + 1));
        let row_defects = tableau.c.is_some().then(|| numbers.row_defects());
        let rows_hold = row_defects.iter().flatten().all(Real::may_be_zero);
        let order_in_time = if rows_hold { main.order } else { order_in_time(&numbers, &numbers.b, main.order) };
        let stability = StabilityFunction::new(&numbers, &numbers.b);
        let reduced = Reduced::of(&numbers);
        let autonomous = match rows_hold {
            true => reduced.clone(),
            false => Reduced::of(&Numbers { c: row_sums(&numbers.a), ..numbers.clone() }),
        };
        Self {
            shape: tableau.shape(),
            order_in_time,
            simplifying: Simplifying::of(&numbers),
            imaginary: stability.imaginary_reach(),
            negative: stability.real_reach(),
            alpha: stability.alpha(),
            linear: stability.linear_orders(&numbers, &numbers.b),
            symplectic_defect: symplectic_defect(&autonomous.numbers),
            symmetric: is_symmetric(&autonomous.numbers),
            algebraic: is_algebraically_stable(&reduced.numbers),
            stiffly_accurate: stiffly_accurate(&numbers),
            reduced,
            autonomous,
            stability,
            main,
            embedded,
            row_defects,
            numbers,
        }
    }

    /// The order of b: from its conditions, and where all that are made up hold from the simplifying assumptions.
    pub fn order_found(&self) -> u32 {
        if self.all_hold() { self.main.order.max(self.simplifying.order()) } else { self.main.order }
    }

    /// Whether all conditions hold that are made up.
    pub(super) fn all_hold(&self) -> bool {
        self.main.order == self.main.forest.rule().most()
    }

    /// The order that no method of so many stages exceeds: that of Gauss' quadrature.
    pub(super) fn most(&self) -> u32 {
        2 * self.numbers.stages() as u32
    }

    /// Whether b̂, where there is one, has the order claimed of it on v̇ = f(t, v) with c as given, or the one that it has without time.
    pub(super) fn embedded_keeps_in_time(&self, claimed: Option<u32>) -> bool {
        self.embedded
            .iter()
            .zip(&self.numbers.b_hat)
            .all(|(found, b)| order_in_time(&self.numbers, b, found.order) >= claimed.unwrap_or(found.order))
    }

    /// Whether |R| ≤ 1 in the left half-plane.
    pub fn is_a_stable(&self) -> bool {
        self.stability.is_a_stable().is_ok()
    }

    /// Whether the digits leave that open, or already whether the negative axis is in the region of stability.
    pub(super) fn is_a_stability_open(&self) -> bool {
        self.stability.is_a_stable() == Err(Unstable::Open) || matches!(self.negative, Reach::Open { .. })
    }

    /// The order on v̇ = −λ(v − φ(t)) + φ̇ for hλ ≫ 1 (\[HW96\] IV.15), and whether the errors there are divided by λ. Where A is
    /// regular and R(∞) damps, it is the first k with δ_k − bᵀA⁻¹Δ_k ≠ 0, Δ_k the defect of the stages on tᵏ and δ_k that of b; where
    /// these vanish, as for stiffly accurate methods, one less than the first k with bᵀA⁻²Δ_k ≠ 0, divided by λ. Elsewhere it is
    /// known if the stages are all of the order of the method.
    pub fn stiff_order(&self) -> Option<(u32, bool)> {
        let damps = self.stability.at_infinity().abs() <= 0.95;
        let whole = Some((self.order_in_time, false)).filter(|(order, _)| self.simplifying.stage_order() >= *order);
        if damps { self.damped_order().or(whole) } else { whole }
    }

    fn damped_order(&self) -> Option<(u32, bool)> {
        let (a, b, c) = self.numbers.doubles();
        let s = b.len();
        let a = DMatrix::from_fn(s, s, |i, j| a[i][j]);
        let inverse = a.clone().try_inverse()?;
        let b = DVector::from_vec(b);
        let defects = |k: u32| {
            let power = |n: u32| DVector::from_iterator(s, c.iter().map(|c| c.powi(n as i32)));
            (&a * power(k - 1) - power(k) / f64::from(k), b.dot(&power(k - 1)) - 1.0 / f64::from(k))
        };
        // Far above the roundoff of a few products of numbers of order 1, far below any defect.
        let tolerance = 1e-9 * (1.0 + inverse.norm());
        let mut orders = 1..=MAX_ORDER;
        let first = orders.clone().find(|k| {
            let (stage, weight) = defects(*k);
            (weight - (&inverse * stage).dot(&b)).abs() > tolerance
        });
        let damped = orders.find(|k| (&inverse * (&inverse * defects(*k).0)).dot(&b).abs() > tolerance);
        // hᵏ against hᵈ/(hλ): where hλ ≫ 1 the former dominates unless it is of higher order.
        match (first, damped) {
            (Some(first), damped) if damped.is_none_or(|damped| first <= damped) => Some((first, false)),
            (None, Some(damped)) => Some((damped - 1, true)),
            _ => None,
        }
    }
}

/// The order that s stages have at most: 2s by their quadrature, s + 1 if each is solved for on its own. Of explicit ones the tall
/// tree fails, however few the digits.
fn barrier(numbers: &Numbers) -> u32 {
    let stages = numbers.a.len() as u32;
    let is_triangular = numbers.a.iter().enumerate().all(|(i, row)| row.iter().skip(i + 1).all(Real::is_zero));
    if is_triangular { stages + 1 } else { 2 * stages }
}

/// The order of the weights `b` with c as given, from the trees with a vertex of time.
fn order_in_time(numbers: &Numbers, b: &[Real], most: u32) -> u32 {
    let forest = Forest::with_time(Rule::Autonomous, most.clamp(1, MAX_TIME_ORDER));
    order_of(&conditions(&forest, numbers, b)).min(most)
}

#[cfg(test)]
mod tests {
    use super::super::file::{Body, MethodFile, Shipped};
    use super::*;

    /// All conditions hold up to the order of a method, and one of the next order does not.
    #[test]
    fn conditions_hold_up_to_the_order_and_no_further() {
        for (name, order) in [
            ("heun2", 2),
            ("ssp-rk3", 3),
            ("rk4", 4),
            ("dormand-prince", 5),
            ("radau-iia3", 5),
            ("gauss3", 6),
            ("gauss4", 8),
        ] {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{name}") };
            let numbers = tableau.numbers();
            for at_least in [0, order, order + 1] {
                let weights = WeightsTheory::new(&numbers, &numbers.b, at_least);
                let failing = |p: u32| weights.failing(p).count();
                assert_eq!((weights.order, failing(order)), (order, 0), "{name}");
                assert!(failing(order + 1) > 0 && weights.beyond().is_some(), "{name}");
            }
        }
    }

    /// Their c are the sums of the rows of A, with which a time is one more component.
    #[test]
    fn the_order_in_time_of_right_stages_is_the_order_however_high() {
        for (name, order) in [("rk4", 4), ("dormand-prince", 5), ("gauss3", 6), ("gauss4", 8)] {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{name}") };
            let numbers = tableau.numbers();
            assert_eq!(order_in_time(&numbers, &numbers.b, order), order, "{name}");
        }
    }

    fn tableau(text: &str) -> Tableau {
        let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
        let Body::RungeKutta(tableau) = file.body else { panic!("{text}") };
        tableau
    }

    /// Nørsett's method to one place: its order is 3 at most, and no condition of the next one is certain to fail.
    #[test]
    fn an_error_that_digits_hide_is_not_told() {
        let text = "digits = 1\na = [['0.8', '0.0'], ['-0.6', '0.8']]\nb = ['0.5', '0.5']\n";
        let numbers = tableau(text).numbers();
        let weights = WeightsTheory::new(&numbers, &numbers.b, 0);
        assert_eq!((weights.order, weights.failing(4).count()), (3, 0));
        assert!(weights.error_norm.is_none() && weights.beyond().is_none());
    }

    /// With w = bᵀA⁻¹ = (−2, 8/3) and c = (1/2, 3/4), w·cᵏ is 1 for k = 1 and 2, so that errors are of order 3 but for those divided by λ, which
    /// are of order 2: neither are all.
    #[test]
    fn no_order_is_told_of_errors_that_lose_against_others_divided_by_lambda() {
        let theory = Theory::new(&tableau("a = [['1/2', 0], ['1/4', '1/2']]\nb = ['-1/3', '4/3']\n"), None, None);
        assert_eq!(theory.damped_order(), None);
    }
}
