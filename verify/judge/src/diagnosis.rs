//! A wrong label told from a wrong coefficient.

use super::analysis::Analysis;
use super::claim::Property;
use super::exchange::{Exchange, exchanges};
use super::file::Body;
use super::mend::{self, System};
use super::real::Real;
use super::repair::{Repair, Target, repairs};
use super::tableau::{Shape, Tableau};
use super::tableau_system::TableauSystem;
use super::theory::{Theory, WeightsTheory};
use super::tree::MAX_ORDER;
use super::twice;
use evidence::Outcome;

/// Orders beyond the one found that are tried where none is claimed.
const TRIED: u32 = 5;

/// What is wrong with a tableau as a whole, if anything.
#[derive(Debug, Clone)]
pub enum Diagnosis {
    /// The coefficients agree with each other, and with the order claimed where there is one.
    Sound,
    /// The coefficients are consistent, and the order is higher than claimed.
    LabelTooLow {
        /// The order that they have.
        order: u32,
    },
    /// The coefficients are consistent, no change of one of them gives the order claimed, and fewer conditions hold.
    LabelTooHigh {
        /// The order that they have.
        order: u32,
    },
    /// One number, changed wherever it stands, makes everything hold.
    Coefficient {
        /// What would hold then.
        target: Target,
        /// The changes that do, the one nearest to the text first.
        repairs: Vec<Repair>,
    },
    /// Two entries or rows, exchanged, make everything hold.
    Exchanged {
        /// What would hold then.
        target: Target,
        /// The exchanges that do.
        exchanges: Vec<Exchange>,
    },
    /// b̂ has the order claimed of b, and b that of b̂.
    Interchanged {
        /// The order of b̂.
        order: u32,
        /// That of b.
        embedded: u32,
    },
    /// The order claimed is that on separable systems, and the file is silent about them.
    Separable {
        /// The order there.
        order: u32,
    },
    /// The order claimed is that where q̇ is linear in p, which no file of its kind can say.
    Linear {
        /// The order there.
        order: u32,
    },
    /// A multistep formula that is listed with its newest step first.
    Reversed {
        /// The order that it has in reverse.
        order: u32,
    },
    /// b̂ adds up to zero: what is listed are weights of the error estimate, b − b̂ or b̂ − b.
    Differences {
        /// The order of the embedded method that they stand for, the higher one of those with either sign.
        order: u32,
    },
    /// Decimals that were cut off in place of rounded make everything hold.
    Truncated {
        /// The order that the coefficients have then.
        order: u32,
    },
    /// Decimals that are the expansions of doubles make everything hold to the rounding of these.
    Doubles {
        /// The order that the coefficients have then.
        order: u32,
    },
    /// c is not the sums of the rows, no change of one coefficient makes it so, and the orders claimed hold with it on v̇ = f(t, v): a
    /// method that is meant so.
    OwnTimes,
    /// Something is wrong that no change of one coefficient mends.
    Several {
        /// The stages whose c is not the sum of its row.
        rows: Vec<usize>,
    },
}

impl Diagnosis {
    /// Where no change of a coefficient is looked for.
    fn of_label(theory: &dyn Analysis, claimed: Option<u32>) -> Self {
        let order = theory.order();
        match claimed {
            Some(p) if order > p && is_refuted(theory, p) => Self::LabelTooLow { order },
            _ => Self::Sound,
        }
    }

    /// Leaves out repairs that make an explicit method implicit, where there are others.
    pub(super) fn keep_explicit(&mut self) {
        if let Self::Coefficient { repairs, .. } = self
            && repairs.iter().any(|repair| !repair.makes_implicit)
        {
            repairs.retain(|repair| !repair.makes_implicit);
        }
    }

    /// The same for kinds whose conditions are a system in their coefficients.
    fn of_system(body: &Body, theory: &dyn Analysis, claimed: Option<u32>) -> Self {
        let found = theory.order();
        let is_consistent = theory.consistency().iter().all(|verdict| verdict.check.outcome != Outcome::Fail);
        let meets = |order: Option<u32>| {
            order.filter(|order| is_consistent && claimed.is_some_and(|p| found < p && p <= *order))
        };
        if let Some(order) = meets(theory.order_where_separable()) {
            return Self::Separable { order };
        }
        if let Some(order) = meets(theory.order_where_linear()) {
            return Self::Linear { order };
        }
        if let Body::Multistep(method) = body
            && found == 0
            && let Some(order) = method.order_reversed().filter(|order| claimed.is_none_or(|p| p <= *order))
        {
            return Self::Reversed { order };
        }
        let orders: Vec<u32> = match claimed {
            Some(p) => vec![p],
            // One order more is within reach of a free parameter; two at once are not.
            None => (found + 2..=found + TRIED).rev().chain([found]).collect(),
        };
        let mut systems: Vec<(Target, Box<dyn System + '_>)> = Vec::new();
        for order in orders {
            let Some(system) = body.system(order) else { continue };
            let target = Target { order, embedded: None };
            if mend::holds(&*system) {
                return Self::of_label(theory, claimed);
            }
            let mut repairs = mend::repairs(&*system);
            repairs.retain(|repair| repair.mends >= 2 || claimed.is_some() || order == found);
            if !repairs.is_empty() {
                return Self::Coefficient { target, repairs };
            }
            systems.push((target, system));
        }
        if let Some(found) = Self::beyond_one_entry(&systems).or_else(|| Self::of_rows(theory, claimed, None)) {
            return found;
        }
        match claimed {
            Some(p) if p > found => Self::LabelTooHigh { order: found },
            _ => Self::of_label(theory, claimed),
        }
    }

    /// A number that is wrong wherever it stands, or two entries that have been exchanged, where no change of one entry does: the
    /// former first, which leaves every other entry where it is printed.
    fn beyond_one_entry(systems: &[(Target, Box<dyn System + '_>)]) -> Option<Self> {
        let twice = systems.iter().map(|(target, system)| (*target, twice::repairs(&**system)));
        if let Some((target, repairs)) = twice.into_iter().find(|(_, repairs)| !repairs.is_empty()) {
            return Some(Self::Coefficient { target, repairs });
        }
        let all: Vec<&dyn System> = systems.iter().map(|(_, system)| &**system).collect();
        let (k, exchanges) = exchanges(&all)?;
        Some(Self::Exchanged { target: systems[k].0, exchanges })
    }

    /// What is left to say of abscissae that are not the sums of the rows, where no change makes them so.
    fn of_rows(theory: &dyn Analysis, claimed: Option<u32>, claimed_embedded: Option<u32>) -> Option<Self> {
        match (theory.wrong_rows(), claimed) {
            (rows, _) if rows.is_empty() => None,
            (_, Some(p)) if theory.keeps_in_time(p, claimed_embedded) => Some(Self::OwnTimes),
            (rows, _) => Some(Self::Several { rows }),
        }
    }

    /// Compares the theory of `tableau` with the orders claimed of b and b̂.
    pub fn new(body: &Body, theory: &dyn Analysis, claimed: Option<u32>, claimed_embedded: Option<u32>) -> Self {
        let (Body::RungeKutta(tableau), Some(theory)) = (body, theory.as_runge_kutta()) else {
            return Self::of_system(body, theory, claimed);
        };
        let rows = theory.wrong_rows();
        let (main, embedded) = (theory.order_found(), theory.embedded.as_ref().map(|e| e.order));
        let falls_short = claimed.is_some_and(|p| main < p) || claimed_embedded.is_some_and(|p| embedded < Some(p));
        match claimed {
            Some(p) if rows.is_empty() && !falls_short && main > p && is_refuted(theory, p) => {
                return Self::LabelTooLow { order: main };
            }
            Some(_) if rows.is_empty() && !falls_short => return Self::Sound,
            _ => {}
        }
        if let Some(order) = order_of(&tableau.of_truncated(), theory, claimed, claimed_embedded) {
            return Self::Truncated { order };
        }
        let of_doubles = tableau.of_doubles();
        if let Some(order) = of_doubles.and_then(|doubles| order_of(&doubles, theory, claimed, claimed_embedded)) {
            return Self::Doubles { order };
        }
        if let (Some(p), Some(e)) = (claimed, embedded)
            && rows.is_empty()
            && (falls_short && p <= e && main >= claimed_embedded.unwrap_or(p.saturating_sub(1)))
        {
            return Self::Interchanged { order: e, embedded: main };
        }
        if let Some(found) = differences(theory, claimed_embedded) {
            return found;
        }
        let targets = targets(tableau, theory, claimed, claimed_embedded);
        if let Some((target, repairs)) = mend(tableau, theory, claimed, &targets) {
            return Self::Coefficient { target, repairs };
        }
        let system = |&target: &Target| (target, Box::new(TableauSystem::new(tableau, target)) as Box<dyn System>);
        let of_rows = || Self::of_rows(theory, claimed, claimed_embedded);
        if let Some(found) = Self::beyond_one_entry(&targets.iter().map(system).collect::<Vec<_>>()).or_else(of_rows) {
            return found;
        }
        match claimed {
            None if !falls_short => Self::Sound,
            _ => Self::LabelTooHigh { order: main },
        }
    }
}

/// Whether the order is certainly not `p`: few digits leave open whether it is a higher one.
fn is_refuted(theory: &dyn Analysis, p: u32) -> bool {
    theory.find(Property::Order(p)).is_some_and(|finding| finding.outcome == Outcome::Fail)
}

/// The order of a tableau whose decimals are read in another way, where it is the one claimed, and all row sums hold; without a claim, where
/// that mends more than one free parameter would.
fn order_of(tableau: &Tableau, theory: &Theory, claimed: Option<u32>, claimed_embedded: Option<u32>) -> Option<u32> {
    let numbers = tableau.numbers();
    if tableau.c.is_some() && !numbers.row_defects().iter().all(Real::may_be_zero) {
        return None;
    }
    let order = |b: &[Real], claimed: Option<u32>| WeightsTheory::new(&numbers, b, claimed.unwrap_or(0)).order;
    let embedded = claimed_embedded.is_none_or(|q| numbers.b_hat.as_deref().is_some_and(|b| order(b, Some(q)) >= q));
    let found = order(&numbers.b, claimed);
    let least = claimed.unwrap_or(theory.main.order + 2);
    (embedded && found >= least).then_some(found)
}

/// The embedded method whose difference from b the file lists as b̂, if that is what it does: of order 1 at least, and of that claimed.
fn differences(theory: &Theory, claimed: Option<u32>) -> Option<Diagnosis> {
    let (numbers, b) = (&theory.numbers, &theory.numbers.b);
    let difference = numbers.b_hat.as_deref().filter(|list| list.iter().sum::<Real>().may_be_zero())?;
    if difference.iter().all(Real::may_be_zero) {
        return None;
    }
    // Conditions are affine in the weights: those that b and b − d satisfy hold for b + d, so that the signs differ beyond the order of b alone.
    let order = |b_hat: Vec<Real>| WeightsTheory::new(numbers, &b_hat, claimed.unwrap_or(0)).order;
    let with_sign = |sign: i64| b.iter().zip(difference).map(|(b, d)| b + &(d * &Real::from(sign))).collect();
    let order = order(with_sign(-1)).max(order(with_sign(1)));
    (order >= claimed.unwrap_or(1).max(1)).then_some(Diagnosis::Differences { order })
}

/// The orders that a change has to reach: those claimed, or where none is claimed each that may have been meant, the highest first.
fn targets(tableau: &Tableau, theory: &Theory, claimed: Option<u32>, claimed_embedded: Option<u32>) -> Vec<Target> {
    let main = theory.main.order;
    let embedded = theory.embedded.as_ref().map(|e| e.order);
    let orders: Vec<u32> = match claimed {
        Some(p) => vec![p.min(MAX_ORDER)],
        // Where the row sums hold, one order more is within reach of a free parameter; two at once are not.
        None => {
            let least = if theory.wrong_rows().is_empty() { main + 2 } else { main };
            (least..=(main + TRIED).min(highest(tableau)).min(MAX_ORDER)).rev().collect()
        }
    };
    let targets = orders.into_iter().flat_map(|order| {
        // An embedded method is mostly one order below, and no worse than it is.
        let guesses = match (claimed_embedded, embedded) {
            (_, None) => vec![None],
            (Some(p), _) => vec![Some(p)],
            (None, Some(found)) => vec![Some(found.max(order.saturating_sub(1))), Some(found)],
        };
        guesses.into_iter().map(move |embedded| Target { order, embedded })
    });
    targets.collect()
}

/// The first of `targets` that changes of one entry reach, and those changes.
fn mend(tableau: &Tableau, theory: &Theory, claimed: Option<u32>, targets: &[Target]) -> Option<(Target, Vec<Repair>)> {
    targets.iter().find_map(|&target| {
        // One number that satisfies one condition is no discovery, where no order is claimed or c has to follow.
        let mut found = repairs(tableau, target);
        let is_claimed = claimed.is_some() || !theory.wrong_rows().is_empty();
        found.retain(|repair| repair.mends >= 2 || (is_claimed && repair.follows.is_empty()));
        (!found.is_empty()).then_some((target, found))
    })
}

/// A bound on the order of a tableau of its shape with one entry changed: 2s, for explicit ones Butcher's barriers (\[HNW93\] II.5).
fn highest(tableau: &Tableau) -> u32 {
    let s = tableau.stages() as u32;
    match (tableau.shape(), s) {
        (Shape::Explicit, 2..=4) => s,
        (Shape::Explicit, 5..=7) => s - 1,
        (Shape::Explicit, 8..=9) => s - 2,
        (Shape::Explicit, 10..) => s - 3,
        // A lost entry above the diagonal makes coupled stages look diagonally implicit, and that of the midpoint rule makes it explicit.
        _ => 2 * s,
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::{Body, MethodFile, Shipped};
    use super::super::tableau::Place;
    use super::*;

    #[test]
    fn repairs_are_looked_for_up_to_butchers_barriers() {
        for (name, highest) in
            [("heun2", 2), ("rk4", 4), ("cash-karp", 5), ("dormand-prince", 6), ("implicit-euler", 2), ("gauss3", 6)]
        {
            let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
            let Body::RungeKutta(tableau) = &file.body else { panic!("{name}") };
            assert_eq!(super::highest(tableau), highest, "{name}");
        }
        // Of s explicit stages, but for one, whose entry on the diagonal may have been lost (\[HNW93\] II.5).
        for (s, highest) in [2, 2, 3, 4, 4, 5, 6, 6, 7, 7, 8].into_iter().enumerate() {
            let s = s + 1;
            let zeros = vec!["0"; s].join(", ");
            let text = format!("a = [{}]\nb = [{zeros}]\n", vec![format!("[{zeros}]"); s].join(", "));
            assert_eq!(super::highest(&tableau(&text)), highest, "{s}");
        }
    }

    fn file(text: &str) -> MethodFile {
        MethodFile::parse("m.toml", "m", text).unwrap_or_else(|error| panic!("{text}{error}"))
    }

    fn tableau(text: &str) -> Tableau {
        let Body::RungeKutta(tableau) = file(text).body else { panic!("{text}") };
        tableau
    }

    fn diagnosed(text: &str) -> Diagnosis {
        let body = file(text).body;
        Diagnosis::new(&body, &*body.analyse(None, None), None, None)
    }

    /// Radau's nodes, of which the last is 9/10 for 1, have an order of 3 and not of 5. Butcher's method of order 6 has 4 with ¼ for its first ⅓,
    /// the row of a stage without a weight.
    #[test]
    fn an_order_that_is_higher_by_two_is_looked_for_without_a_claim() {
        let radau = "kind = 'path-fitted'\nnodes = ['2/5 - sqrt(6)/10', '2/5 + sqrt(6)/10', '9/10']\n";
        let butcher = "a = [[], ['1/4'], [0, '2/3'], ['1/12', '1/3', '-1/12'], ['-1/16', '9/8', '-3/16', '-3/8'], \
                       [0, '9/8', '-3/8', '-3/4', '1/2'], ['9/44', '-9/11', '63/44', '18/11', 0, '-16/11']]\n\
                       b = ['11/120', 0, '27/40', '27/40', '-4/15', '-4/15', '11/120']\n";
        for (text, order, place, value) in [(radau, 5, "nodes[3]", 1.0), (butcher, 6, "a[2,1]", 1.0 / 3.0)] {
            let Diagnosis::Coefficient { target, repairs } = diagnosed(text) else { panic!("{:?}", diagnosed(text)) };
            assert_eq!((target.order, repairs[0].place.to_string().as_str()), (order, place));
            assert!((repairs[0].value.to_f64() - value).abs() < 1e-12, "{}", repairs[0].text);
        }
    }

    /// The midpoint rule with a third for its half.
    #[test]
    fn a_wrong_abscissa_is_found_without_a_claim() {
        let text = "c = [0, '1/3']\na = [[], ['1/2']]\nb = [0, 1]\n";
        let Diagnosis::Coefficient { repairs, .. } = diagnosed(text) else { panic!("{:?}", diagnosed(text)) };
        assert_eq!((repairs[0].place, repairs[0].text.as_str()), (Place::C(1), "1/2"));
    }

    /// Of b = (1, 0), of order 1, and Heun's weights, of order 2, the difference is (½, −½): Heun's are b less that, and what is b and that, (3/2, −½),
    /// has order 1.
    #[test]
    fn what_is_listed_as_a_difference_is_what_the_embedded_weights_lack() {
        let of = |hat: &str, claimed: Option<u32>| {
            let text = format!("a = [[], [1]]\nb = [1, 0]\nb_hat = [{hat}]\n");
            let body = file(&text).body;
            Diagnosis::new(&body, &*body.analyse(None, claimed), None, claimed)
        };
        for hat in ["'1/2', '-1/2'", "'-1/2', '1/2'"] {
            assert!(matches!(of(hat, Some(2)), Diagnosis::Differences { order: 2 }), "{hat}: {:?}", of(hat, Some(2)));
            assert!(!matches!(of(hat, Some(3)), Diagnosis::Differences { .. }), "{hat}");
        }
    }

    #[test]
    fn repairs_that_couple_stages_are_left_out_where_others_do_not() {
        let repair = |makes_implicit: bool| {
            let (was, text, value) = ("0".into(), "1".into(), Real::one());
            let (also, follows) = (Vec::new(), Vec::new());
            Repair { place: Place::B(0), also, follows, makes_implicit, was, text, value, mends: 1 }
        };
        let target = Target { order: 1, embedded: None };
        for (all, kept) in [(vec![true, true], 2), (vec![true, false], 1), (vec![false, false], 2)] {
            let repairs = all.iter().map(|implicit| repair(*implicit)).collect();
            let mut diagnosis = Diagnosis::Coefficient { target, repairs };
            diagnosis.keep_explicit();
            let Diagnosis::Coefficient { repairs, .. } = diagnosis else { panic!("it is one") };
            assert_eq!(repairs.len(), kept, "{all:?}");
        }
    }

    /// Its order is 2, and 1 with the times of c: a label of 1 is too low without them alone.
    #[test]
    fn a_label_that_is_right_in_time_is_not_too_low() {
        let found = |c: &str, claimed: u32| {
            let text = format!(
                "kind = 'partitioned-runge-kutta'\n{c}a = [[0, 0], ['1/2', '1/2']]\nb = ['1/2', '1/2']\n\
                 a_hat = [['1/2', 0], ['1/2', 0]]\nb_hat = ['1/2', '1/2']\n"
            );
            Diagnosis::of_label(&*file(&text).body.analyse(Some(claimed), None), Some(claimed))
        };
        let times = "c = ['1/4', '2/3']\n";
        for sound in [found(times, 1), found(times, 2), found("", 2)] {
            assert!(matches!(sound, Diagnosis::Sound), "{sound:?}");
        }
        assert!(matches!(found("", 1), Diagnosis::LabelTooLow { order: 2 }));
    }

    /// Ruth's three steps in turn, with c the sums of the rows of a.
    #[test]
    fn an_order_on_separable_systems_is_told_beside_times_that_are_right() {
        for c in ["", "c = [1, '1/3', 1]\n"] {
            let text = format!(
                "kind = 'partitioned-runge-kutta'\n{c}a = [[1, 0, 0], [1, '-2/3', 0], [1, '-2/3', '2/3']]\nb = [1, '-2/3', '2/3']\n\
                 a_hat = [[0, 0, 0], ['-1/24', 0, 0], ['-1/24', '3/4', 0]]\nb_hat = ['-1/24', '3/4', '7/24']\n"
            );
            let file = file(&text);
            let theory = file.body.analyse(Some(3), None);
            let found = Diagnosis::of_system(&file.body, &*theory, Some(3));
            assert!(theory.order() < 3 && matches!(found, Diagnosis::Separable { order: 3 }), "{c}{found:?}");
        }
    }

    /// McLachlan and Atela's four steps (1992) have order 4 for T = p²/2, and no more than 3 for other T(p); a digit of them has order 4 nowhere.
    #[test]
    fn an_order_where_momenta_are_linear_is_told() {
        let a = ["0.5153528374311229364", "-0.085782019412973646", "0.4415830236164665242", "0.1288461583653841854"];
        let found = |first: &str, claimed: u32| {
            let b = [first, "-0.2248198030794208058", "0.7563200005156682911", "0.3340036032863214255"];
            let quoted =
                |row: &[&str]| format!("[{}]", row.iter().map(|x| format!("'{x}'")).collect::<Vec<_>>().join(", "));
            let rows = |list: &[&str; 4], extra: usize| {
                (0..4).map(|i| quoted(&list[..i + extra])).collect::<Vec<_>>().join(", ")
            };
            let text = format!(
                "kind = 'partitioned-runge-kutta'\nsystems = 'separable'\na = [{}]\nb = {}\na_hat = [{}]\nb_hat = {}\n",
                rows(&a, 0),
                quoted(&a),
                rows(&b, 1),
                quoted(&b)
            );
            let file = file(&text);
            let theory = file.body.analyse(Some(claimed), None);
            (theory.order(), theory.order_where_linear(), Diagnosis::of_system(&file.body, &*theory, Some(claimed)))
        };
        let right = "0.1344961992774310892";
        let (order, linear, told) = found(right, 4);
        assert!(
            order == 3 && linear == Some(4) && matches!(told, Diagnosis::Linear { order: 4 }),
            "{order} {linear:?} {told:?}"
        );
        assert!(
            matches!(found(right, 3).2, Diagnosis::Sound) && !matches!(found(right, 5).2, Diagnosis::Linear { .. })
        );
        assert!(!matches!(found("0.1344961992774319892", 4).2, Diagnosis::Linear { .. }));
    }
}
