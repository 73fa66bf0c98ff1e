//! What was found out about a method, in sentences.

use super::Judgement;
use super::diagnosis::Diagnosis;
use super::exchange::{Exchange, LONGEST};
use super::file::Body;
use super::linear::Reach;
use super::measured::MeasuredOrder;
use super::real::Real;
use super::repair::{Repair, Target};
use super::tableau::Place;
use super::theory::WeightsTheory;
use evidence::number::digits;
use experiments::measure::decimal::{significant, trimmed};

/// Labelled lines of text.
pub type Facts = Vec<(&'static str, String)>;

impl Judgement {
    /// Kind, shape and digits in a line.
    pub fn headline(&self) -> String {
        let digits = self.file.rounding.told();
        format!("{}, {digits}", self.theory.headline())
    }

    /// What the theory says, and defects that were measured, each with its label.
    pub fn facts(&self) -> Facts {
        let mut facts = self.theory.facts();
        facts.extend(self.measured.iter().filter_map(MeasuredOrder::fact));
        if let Some(Ok(defects)) = &self.defects {
            let text = format!("symplecticity {:.1e}, symmetry {:.1e}", defects.symplectic, defects.symmetric);
            facts.push(("defects", text));
        }
        match &self.work {
            Some(Ok((problem, points))) => {
                let dearer =
                    self.theory.dearer().map_or_else(String::new, |why| format!("; {}: {why}", self.file.name));
                facts.push(("work", super::work::summary(problem, points) + &dearer));
            }
            Some(Err(reason)) => facts.push(("work", format!("not run: {reason}"))),
            None => {}
        }
        facts
    }

    /// Whether a label or a coefficient is wrong, in sentences; nothing where neither is.
    pub fn diagnosis_text(&self) -> Option<String> {
        let found = self.found_wrong()?;
        let is_too_low = matches!(self.diagnosis, Diagnosis::LabelTooLow { .. });
        let doubt = self.file.rounding.doubt().filter(|_| !is_too_low);
        Some(doubt.map_or_else(|| found.clone(), |doubt| format!("{found} {doubt}")))
    }

    fn found_wrong(&self) -> Option<String> {
        match &self.diagnosis {
            Diagnosis::Sound | Diagnosis::OwnTimes => None,
            Diagnosis::Truncated { order } => Some(format!(
                "The decimals look as if they were cut off, not rounded: up to a unit larger in their last place they have order {order}, \
                 and all row sums hold. Rounded, or as fractions, they would do.{}",
                self.sum_of_weights()
            )),
            Diagnosis::Doubles { order } => Some(format!(
                "The decimals are doubles, printed to more digits than a double has: to its rounding they have order {order}, and all row sums \
                 hold. `digits = 15` in the file reads them so, and fractions would do."
            )),
            Diagnosis::LabelTooLow { order } => {
                let claimed = self.file.order().unwrap_or(0);
                Some(format!(
                    "The label is too low: order {claimed} is claimed, and the coefficients have order {order}."
                ))
            }
            Diagnosis::LabelTooHigh { order } => {
                let claimed = self.file.order().unwrap_or(0);
                match self.file.body {
                    Body::RungeKutta(_) => {}
                    Body::Closure(_) => {
                        return Some(format!(
                            "The label is too high: a closure has order {order} for any α and β, so that no condition singles out \
                             a coefficient."
                        ));
                    }
                    _ => {
                        return Some(format!(
                            "{}: no change of a single coefficient makes the conditions of order {claimed} hold. As they stand they \
                             have order {order}.",
                            too_high(*order)
                        ));
                    }
                }
                let embedded = self.runge_kutta().and_then(|theory| theory.embedded.as_ref());
                let (weights, order) = match embedded.filter(|_| self.theory.order() >= claimed) {
                    Some(embedded) => ("b_hat", embedded.order),
                    None => ("b", *order),
                };
                Some(format!(
                    "{}: the row sums hold, the conditions on {weights} fail, and no change of a single coefficient mends them. As \
                     they stand they have order {order}.{}{}",
                    too_high(order),
                    self.sum_of_weights(),
                    not_looked_for(&self.file.body)
                ))
            }
            Diagnosis::Coefficient { target, repairs } => {
                let (what, change) = match repairs.first() {
                    Some(repair) if !repair.also.is_empty() => {
                        ("A number is wrong that stands at several places", "it changed at each of them")
                    }
                    _ => ("A coefficient is wrong", "one coefficient changed"),
                };
                // No label is wrong about a row sum.
                let rows = !self.theory.wrong_rows().is_empty();
                let doubt = match repairs.first() {
                    // What has no order at all has no label that is right.
                    Some(repair) if repair.mends == 1 && !rows && self.theory.order() > 0 => {
                        " One number that satisfies one condition may be a coincidence: it may be the label that is wrong."
                    }
                    _ => "",
                };
                Some(format!("{what}. With {change} {}.{doubt}{}", self.holds_then(*target), self.sum_of_weights()))
            }
            Diagnosis::Exchanged { target, exchanges } => {
                let (what, change) = match exchanges.as_slice() {
                    [_] => ("Two entries look exchanged", "them exchanged back"),
                    _ => ("Two entries look exchanged, and which of these is open", "either two exchanged back"),
                };
                let doubt = match exchanges.first() {
                    Some(exchange) if exchange.mends == 1 => {
                        " One condition may hold by coincidence: it may be the label that is wrong."
                    }
                    _ => "",
                };
                Some(format!("{what}. With {change} {}.{doubt}{}", self.holds_then(*target), self.sum_of_weights()))
            }
            Diagnosis::Interchanged { order, embedded } => Some(format!(
                "b and b_hat, or the orders claimed of them, look interchanged: b has order {embedded}, and b_hat has order {order}."
            )),
            Diagnosis::Reversed { order } => Some(format!(
                "The coefficients look listed with the newest step first: as they stand the formula is inconsistent, and in reverse it \
                 has order {order} and converges. A file lists the oldest step first."
            )),
            Diagnosis::Differences { order } => Some(format!(
                "b_hat adds up to 0, as the weights of an error estimate do, b - b_hat or b_hat - b: the embedded method has order \
                 {order} then. A file lists the weights of that method itself."
            )),
            Diagnosis::Separable { order } => Some(format!(
                "The claim holds on separable systems alone. On q̇ = f(p), ṗ = g(q) the order is {order}; on systems in general it is \
                 {}. If the method is meant for separable systems, the file has to say so: systems = \"separable\".",
                self.theory.order()
            )),
            Diagnosis::Linear { order } => Some(format!(
                "The claim holds where q̇ is linear in p alone. On q̇ = M⁻¹p, ṗ = g(q) the order is {order}; otherwise it is {}. A method that \
                 is meant for q̈ = g(q) is stated as one of Nyström's, kind = \"nystrom\", with the matrix a â, the weights b â of q \
                 and b̂ of p, and as c the sums of the rows of a.",
                self.theory.order()
            )),
            Diagnosis::Several { rows } => {
                let of = match rows.as_slice() {
                    [row] => format!("the row sum of stage {}", row + 1),
                    rows => {
                        let rows: Vec<String> = rows.iter().map(|i| (i + 1).to_string()).collect();
                        format!("the row sums of stages {}", rows.join(", "))
                    }
                };
                if let Some(order) = self.order_beside_own_times() {
                    return Some(format!(
                        "More than one coefficient is wrong, or c is meant so: no change of a single one mends {of}, and with c as given \
                         the order on v̇ = f(t, v) is {order} still. The file of a method that is meant so claims its order."
                    ));
                }
                let holds = self.file.order().is_some_and(|claimed| claimed <= self.theory.order());
                Some(format!(
                    "More than one coefficient is wrong: no change of a single one mends {of}{}.{}{}",
                    if holds { ", and the order on v̇ = f(t, v)" } else { ", and the order" },
                    self.sum_of_weights(),
                    not_looked_for(&self.file.body)
                ))
            }
        }
    }

    /// The order that no c lowers which is not the sums of the rows, where the file claims none.
    fn order_beside_own_times(&self) -> Option<u32> {
        let order = self.theory.order();
        let is_meant = self.file.order().is_none() && order > 0 && self.theory.keeps_in_time(order, None);
        is_meant.then_some(order)
    }

    /// What a change reaches.
    fn holds_then(&self, target: Target) -> String {
        let embedded = target.embedded.map_or_else(String::new, |q| format!(", of the embedded method {q}"));
        let has_rows = matches!(self.file.body, Body::RungeKutta(_)) || !self.theory.wrong_rows().is_empty();
        let sums = if has_rows { ", and all row sums hold" } else { "" };
        format!("the order is {}{embedded}{sums}", target.order)
    }

    /// What the weights add up to, where that is not 1, or may be so for digits that were cut off.
    fn sum_of_weights(&self) -> String {
        let is_cut = matches!(self.diagnosis, Diagnosis::Truncated { .. });
        let sums = self.runge_kutta().filter(|theory| is_cut || theory.main.order == 0).map(|theory| {
            let sum: Real = theory.numbers.b.iter().sum();
            let excess = (&sum - &Real::one()).to_f64();
            match trimmed(sum.to_f64(), 12) {
                rounded if rounded == "1" && excess != 0.0 => format!(" The weights add up to 1 {excess:+.2e}."),
                sum => format!(" The weights add up to {sum}."),
            }
        });
        sums.unwrap_or_default()
    }

    /// The changes that mend everything, each in a sentence.
    pub fn changes(&self) -> Vec<String> {
        let repairs = self.repairs().iter().map(Repair::sentence);
        repairs.chain(self.exchanges().iter().map(Exchange::sentence)).collect()
    }

    /// The exchanges that mend everything.
    pub fn exchanges(&self) -> &[Exchange] {
        match &self.diagnosis {
            Diagnosis::Exchanged { exchanges, .. } => exchanges,
            _ => &[],
        }
    }

    /// The numbers whose change mends everything, the one nearest to the text first.
    pub fn repairs(&self) -> &[Repair] {
        match &self.diagnosis {
            Diagnosis::Coefficient { repairs, .. } => repairs,
            _ => &[],
        }
    }
}

impl Repair {
    /// `a[4,3]: 1/2 → 1`, with what it mends.
    pub fn sentence(&self) -> String {
        let places = listed(std::iter::once(&self.place).chain(&self.also));
        let follows = match self.follows.as_slice() {
            [] => String::new(),
            c => format!(", and {} with it", listed(c)),
        };
        let implicit = if self.makes_implicit { ", and couples stages that are not coupled" } else { "" };
        format!("{places}: {} → {}{follows}, mends {}{implicit}", self.was, self.text, mended(self.mends))
    }
}

/// What an order below the one claimed shows: no label is right of a method that has none.
fn too_high(order: u32) -> &'static str {
    match order {
        0 => "More than one coefficient is wrong",
        _ => "The label is too high, or more than one coefficient is wrong",
    }
}

/// `a[4,1], a[5,1] and b[1]`.
fn listed<'a>(places: impl IntoIterator<Item = &'a Place>) -> String {
    let mut names: Vec<String> = places.into_iter().map(Place::to_string).collect();
    let last = names.pop().unwrap_or_default();
    if names.is_empty() { last } else { format!("{} and {last}", names.join(", ")) }
}

/// What a change mends, by the number of conditions that fail without it.
pub(super) fn mended(failing: usize) -> String {
    if failing == 1 { "the failing condition".into() } else { format!("all {failing} failing conditions") }
}

pub(super) fn order(weights: &WeightsTheory) -> String {
    match (weights.beyond(), weights.error_norm) {
        (Some(first), Some(norm)) => format!(
            "{}; first failing tree {}, principal error {}",
            weights.order,
            weights.forest.brackets(first.tree),
            told(&Real::double(norm).widened(first.residual.radius()), 3)
        ),
        _ if weights.order < weights.forest.order() => {
            format!("{}, the most that so many stages have; the digits tell no error", weights.order)
        }
        _ => format!("{} or more: every condition looked at holds", weights.order),
    }
}

pub(super) fn reach(reach: Reach, axis: &str) -> String {
    match reach {
        Reach::Everything => format!("all of the {axis} axis"),
        Reach::UpTo { end: 0.0, open, .. } if open < VISIBLE => format!("nothing of the {axis} axis"),
        Reach::UpTo { end: 0.0, open, .. } => {
            format!("{axis} axis to less than {}, which few digits leave open", significant(open, 2))
        }
        Reach::UpTo { end, open, .. } => format!("{axis} axis to {}", length(end, open)),
        Reach::Open { to: 0.0 } => format!("what is stable of the {axis} axis is open for the digits given"),
        Reach::Open { to } => {
            format!("{axis} axis to {} at least, which few digits leave open", significant(to, 2))
        }
    }
}

/// What is not zero in four decimals.
const VISIBLE: f64 = 5e-5;

/// A length to four decimals, or as many digits as are not uncertain, with what they are uncertain by.
pub(super) fn length(x: f64, open: f64) -> String {
    let least = if x < 0.1 { 4 - x.log10().ceil() as i32 } else { 4 };
    if open <= 0.5 * 10_f64.powi(-least) {
        return format!("{x:.*}", least as usize);
    }
    if open >= 0.5 * x {
        return format!("some {}", digits(x, 1));
    }
    // The uncertainty to one digit, and no digit of the length beyond it.
    let places = (-open.log10().floor()).max(0.0) as usize;
    format!("{x:.places$} ± {open:.places$}")
}

/// What has not been looked for, where nothing was found.
fn not_looked_for(body: &Body) -> String {
    match body {
        Body::RungeKutta(tableau) if tableau.stages() > LONGEST => {
            format!(" Exchanged entries are looked for up to {LONGEST} stages only.")
        }
        _ => String::new(),
    }
}

/// A number in so many decimals of its power of ten, or as many as its uncertainty leaves.
pub(super) fn told(x: &Real, decimals: usize) -> String {
    let supported = (x.to_f64().abs() / x.radius()).log10().floor();
    let decimals = if supported < decimals as f64 { supported.max(0.0) as usize } else { decimals };
    format!("{:.decimals$e}", x.to_f64())
}

/// A number to two digits where four decimals show fewer of it.
pub(super) fn visible(x: f64) -> String {
    if (ROUNDOFF..1e-3).contains(&x.abs()) { format!("{x:.1e}") } else { short(x) }
}

pub(super) fn short(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}

/// What quotients of two doubles may be off by, with digits to spare.
const ROUNDOFF: f64 = 1e-13;

/// The same, or as many decimals as tell its modulus from 1.
pub(super) fn beside_one(x: f64) -> String {
    let off = (x.abs() - 1.0).abs();
    if !(ROUNDOFF..5e-5).contains(&off) {
        return short(x);
    }
    let places = -off.log10().floor() as usize;
    format!("{x:.places$}")
}

/// What is greater than 1: to eight decimals, to as many as show it, or by how much less than a double tells.
pub(super) fn beyond_one(x: f64) -> String {
    match x - 1.0 {
        off if off < ROUNDOFF => format!("> 1, by less than {ROUNDOFF:e},"),
        off if off < 5e-8 => format!("= {}", beside_one(x)),
        _ => format!("= {x:.8}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_modulus_beside_one_has_the_decimals_that_tell_it_from_one() {
        let cases = [
            (1.0, "1"),
            (-1.0, "-1"),
            (0.5, "0.5"),
            (-1.000_000_4, "-1.0000004"),
            (0.999_999_6, "0.9999996"),
            (1.000_1, "1.0001"),
            (1.0 + 1e-15, "1"),
            (f64::NAN, "NaN"),
        ];
        for (x, text) in cases {
            assert_eq!(beside_one(x), text);
        }
    }

    #[test]
    fn stages_are_counted_from_one() {
        let told = |c: &str| {
            let text = format!(
                "kind = 'runge-kutta'\na = [[0, 0, 0], ['1/3', 0, 0], [0, '1/2', 0]]\nb = ['1/4', 0, '3/4']\nc = {c}\nclaims = ['order 3']\n"
            );
            let file = crate::file::MethodFile::parse("m.toml", "m", &text).expect("well-formed");
            Judgement::new(file, crate::Effort::Theory).diagnosis_text().expect("it is wrong")
        };
        assert!(told("[0, '1/5', '1/7']").contains("the row sums of stages 2, 3"), "{}", told("[0, '1/5', '1/7']"));
    }

    #[test]
    fn what_four_decimals_do_not_show_is_told_by_its_power_of_ten() {
        let cases = [
            (0.0, "0"),
            (-1e-16, "0"),
            (1e-7, "1.0e-7"),
            (-3.26e-5, "-3.3e-5"),
            (0.000_99, "9.9e-4"),
            (0.001, "0.001"),
        ];
        for (x, text) in cases {
            assert_eq!(visible(x), text);
        }
    }

    #[test]
    fn what_is_beyond_one_is_shown_to_be() {
        let cases = [
            (1.250_000_004, "= 1.25000000"),
            (1.000_000_2, "= 1.00000020"),
            (1.0 + 2e-9, "= 1.000000002"),
            (1.0, "> 1, by less than 1e-13,"),
            (1.0 + 5e-14, "> 1, by less than 1e-13,"),
        ];
        for (x, text) in cases {
            assert_eq!(beyond_one(x), text);
        }
    }

    /// Four decimals, more below a tenth, and none beyond what is uncertain.
    #[test]
    fn lengths_have_four_decimals_or_as_many_as_are_certain() {
        let cases = [
            ((2.785_29, 0.0), "2.7853"),
            ((0.1, 0.0), "0.1000"),
            ((0.05, 0.0), "0.05000"),
            ((0.005, 0.0), "0.005000"),
            ((2.785_29, 5e-5), "2.7853"),
            ((2.785_29, 2e-3), "2.785 ± 0.002"),
            ((27.8, 3.0), "28 ± 3"),
            ((1.02e7, 6e6), "some 10⁷"),
        ];
        for ((x, open), text) in cases {
            assert_eq!(length(x, open), text);
        }
    }

    /// An end at 0 is none, but for what few digits leave open.
    #[test]
    fn nothing_is_stable_of_an_axis_or_as_little_as_the_digits_leave_open() {
        for (open, text) in [
            (1e-6, "nothing of the imaginary axis"),
            (0.03, "imaginary axis to less than 0.030, which few digits leave open"),
        ] {
            assert_eq!(reach(Reach::UpTo { end: 0.0, open, witness: 0.1 }, "imaginary"), text);
        }
    }

    /// RK4 has order 4 of 5 that are looked at, or of 4.
    #[test]
    fn an_order_is_the_most_of_its_stages_or_more_where_no_condition_fails() {
        let file = crate::file::Shipped::by_name("rk4").expect("there").read().expect("well-formed");
        let Body::RungeKutta(tableau) = &file.body else { panic!("a tableau") };
        let theory = crate::theory::Theory::new(tableau, Some(4), None);
        let weights = WeightsTheory { error_norm: None, ..theory.main };
        assert_eq!((weights.order, weights.forest.order()), (4, 5));
        assert_eq!(order(&weights), "4, the most that so many stages have; the digits tell no error");
        let forest = crate::tree::Forest::new(crate::tree::Rule::Autonomous, 4);
        assert_eq!(order(&WeightsTheory { forest, ..weights }), "4 or more: every condition looked at holds");
    }

    /// Kutta's third order with 1/6 and 2/3 cut off after 13 places: 2/3, 2/3 and 2/3 of a unit are missing from their sum.
    #[test]
    fn weights_that_are_cut_off_add_up_to_one_but_for_that() {
        let sixth = "'0.1666666666666'";
        let text = format!(
            "order = 3\nc = [0, '1/2', 1]\na = [[], ['1/2'], [-1, 2]]\nb = [{sixth}, '0.6666666666666', {sixth}]\n"
        );
        let file = crate::file::MethodFile::parse("m.toml", "m", &text).expect("a method");
        let judgement = Judgement::new(file, crate::Effort::Theory);
        assert!(matches!(judgement.diagnosis, Diagnosis::Truncated { .. }), "{:?}", judgement.diagnosis);
        let told = judgement.diagnosis_text().expect("it is cut off");
        assert!(told.contains("The weights add up to 1 -2.00e-13."), "{told}");
    }

    /// Kutta's third order with 1/6 and 2/3 as `%.20f` prints them, and with another digit at the end.
    #[test]
    fn doubles_that_are_printed_to_twenty_places_are_told_from_wrong_coefficients() {
        let diagnosis = |third: &str| {
            let sixth = "'0.16666666666666665741'";
            let text = format!(
                "order = 3\nc = [0, '1/2', 1]\na = [[], ['1/2'], [-1, 2]]\nb = [{sixth}, '{third}', {sixth}]\n"
            );
            let file = crate::file::MethodFile::parse("m.toml", "m", &text).expect("a method");
            let judgement = Judgement::new(file, crate::Effort::Theory);
            (matches!(judgement.diagnosis, Diagnosis::Doubles { order: 3 }), judgement.diagnosis_text())
        };
        let (is_of_doubles, told) = diagnosis("0.66666666666666662966");
        assert!(is_of_doubles && told.is_some_and(|text| text.contains("`digits = 15` in the file")));
        assert!(!diagnosis("0.66666666666666663966").0);
    }

    /// The implicit midpoint rule with a diagnosis of another method.
    fn said_of(diagnosis: Diagnosis, order: u32) -> String {
        let text = format!("a = [['1/2']]\nb = [1]\norder = {order}\n");
        let file = crate::file::MethodFile::parse("m.toml", "m", &text).expect("a method");
        let judgement = Judgement { diagnosis, ..Judgement::new(file, crate::Effort::Theory) };
        judgement.diagnosis_text().expect("something is wrong")
    }

    #[test]
    fn a_number_at_several_places_and_one_of_several_exchanges_are_told_as_such() {
        let target = Target { order: 2, embedded: None };
        for (also, text) in [
            (Vec::new(), "A coefficient is wrong. With one coefficient changed the order is 2"),
            (
                vec![Place::A(1, 0)],
                "A number is wrong that stands at several places. With it changed at each of them the order is 2",
            ),
        ] {
            let (was, text_of, value, follows) = ("1".into(), "2".into(), Real::one(), Vec::new());
            let repair = Repair {
                place: Place::B(0),
                also,
                follows,
                makes_implicit: false,
                was,
                text: text_of,
                value,
                mends: 2,
            };
            let said = said_of(Diagnosis::Coefficient { target, repairs: vec![repair] }, 2);
            assert!(said.starts_with(text), "{said}");
        }
        let exchange = Exchange { names: ["b[1]".into(), "b[2]".into()], with_c: false, mends: 2 };
        for (count, text) in [
            (1, "Two entries look exchanged. With them exchanged back the order is 2"),
            (
                2,
                "Two entries look exchanged, and which of these is open. With either two exchanged back the order is 2",
            ),
        ] {
            let said = said_of(Diagnosis::Exchanged { target, exchanges: vec![exchange.clone(); count] }, 2);
            assert!(said.starts_with(text), "{said}");
        }
    }

    /// Of order 2, which a row sum does not change where f does not depend on time.
    #[test]
    fn a_wrong_row_sum_spoils_the_order_in_time_of_a_method_that_has_its_order() {
        for (order, text) in [(1, true), (2, true), (3, false)] {
            let said = said_of(Diagnosis::Several { rows: vec![0] }, order);
            assert_eq!(said.contains("of stage 1, and the order on v̇ = f(t, v)."), text, "{order}: {said}");
        }
    }

    #[test]
    fn exchanges_that_were_not_looked_for_are_said_of_more_stages_than_are_tried() {
        for (stages, is_said) in [(LONGEST, false), (LONGEST + 1, true)] {
            let zeros = vec!["0"; stages].join(", ");
            let text = format!("a = [{}]\nb = [1{}]\n", vec![format!("[{zeros}]"); stages].join(", "), &zeros[1..]);
            let file = crate::file::MethodFile::parse("m.toml", "m", &text).expect("a method");
            assert_eq!(!not_looked_for(&file.body).is_empty(), is_said, "{stages}");
        }
    }

    /// c = (0, 1) beside the rows of the implicit midpoint rule keeps its order 2: no order 3 is meant by that, nor one of weights of no order.
    #[test]
    fn only_an_order_that_no_label_claims_makes_own_times_meant_so() {
        let said = |text: &str| {
            let text = format!("c = [0, 1]\na = [['1/2', 0], ['1/2', 0]]\n{text}");
            let file = crate::file::MethodFile::parse("m.toml", "m", &text).expect("a method");
            let judgement = Judgement::new(file, crate::Effort::Theory);
            assert!(matches!(judgement.diagnosis, Diagnosis::Several { .. }), "{:?}", judgement.diagnosis);
            judgement.diagnosis_text().expect("c is not the sums")
        };
        for (text, is_meant) in
            [("b = ['1/2', '1/2']", true), ("b = ['1/2', '1/2']\norder = 3", false), ("b = ['1/2', '1/3']", false)]
        {
            assert_eq!(said(text).contains("or c is meant so"), is_meant, "{text}: {}", said(text));
        }
    }

    #[test]
    fn a_number_is_told_to_the_decimals_that_its_uncertainty_leaves() {
        let told = |radius: f64, decimals: usize| told(&Real::double(12.3456).widened(radius), decimals);
        assert_eq!([told(0.0, 3), told(0.1, 4), told(1e-6, 2), told(20.0, 3)], ["1.235e1", "1.23e1", "1.23e1", "1e1"]);
    }
}
