//! What was found out about a method, as labelled lines of text.

use super::Judgement;
use super::diagnosis::Diagnosis;
use super::linear::Reach;
use super::repair::Repair;
use super::tableau::Shape;
use super::theory::WeightsTheory;
use super::tree::MAX_ORDER;

impl Judgement {
    /// Stages, shape and digits in a line.
    pub fn headline(&self) -> String {
        let shape = match self.theory.shape {
            Shape::Explicit => "explicit",
            Shape::DiagonallyImplicit => "diagonally implicit",
            Shape::FullyImplicit => "fully implicit",
        };
        let s = self.theory.numbers.stages();
        let stages = if s == 1 { "1 stage".into() } else { format!("{s} stages") };
        let digits = match self.file.rounding.places() {
            Some(places) => format!("decimals printed to {places} places"),
            None => "coefficients taken as exact".into(),
        };
        format!("Runge–Kutta, {shape}, {stages}, {digits}")
    }

    /// What the theory says, each with its label.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        let theory = &self.theory;
        let mut facts = vec![("order", order(&theory.main))];
        if let Some(embedded) = &theory.embedded {
            facts.push(("embedded", order(embedded)));
        }
        if theory.order_in_time < theory.main.order {
            let text = format!("{} on v̇ = f(t, v), with c as given", theory.order_in_time);
            facts.push(("in time", text));
        }
        let simplifying = theory.simplifying;
        facts.push((
            "stage order",
            format!("{}: B({}), C({}), D({})", simplifying.stage_order(), simplifying.b, simplifying.c, simplifying.d),
        ));
        facts.push(("stability", self.stability()));
        facts.push((
            "axes",
            format!("{}; {}", reach(theory.negative, "negative"), reach(theory.imaginary, "imaginary")),
        ));
        facts.push(("oscillations", self.oscillations()));
        facts.push(("structure", self.structure()));
        facts
    }

    fn stability(&self) -> String {
        let theory = &self.theory;
        let infinity = theory.stability.at_infinity();
        let at_infinity =
            if infinity.is_finite() { format!("R(∞) = {}", short(infinity)) } else { "R(∞) = ∞".into() };
        let class = match theory.alpha {
            Some(_) if theory.is_a_stable() && infinity == 0.0 => "L-stable".into(),
            Some(_) if theory.is_a_stable() => "A-stable".into(),
            Some(alpha) => format!("A(α)-stable with α = {alpha:.2}°"),
            None => "conditionally stable".to_owned(),
        };
        let algebraic = if theory.algebraic.is_ok() { ", algebraically stable" } else { "" };
        format!("{class}{algebraic}; {at_infinity}")
    }

    fn oscillations(&self) -> String {
        let linear = self.theory.linear;
        let one = |what: &str, found: Option<(u32, f64)>| match found {
            Some((order, constant)) => format!("{what} of order {order} (constant {constant:.2e})"),
            None => format!("no {what} at all"),
        };
        format!("{}, {}", one("dispersion", linear.dispersion), one("dissipation", linear.dissipation))
    }

    fn structure(&self) -> String {
        let theory = &self.theory;
        let not = |holds: bool, what: &str| if holds { what.to_owned() } else { format!("not {what}") };
        let mut parts = vec![
            not(theory.symplectic_defect.is_none(), "symplectic"),
            not(theory.symmetric, "symmetric"),
            not(theory.stiffly_accurate, "stiffly accurate"),
        ];
        if let Some(Ok(defects)) = &self.defects {
            parts.push(format!("measured defects {:.1e} and {:.1e}", defects.symplectic, defects.symmetric));
        }
        parts.join(", ")
    }

    /// Whether a label or a coefficient is wrong, in sentences; nothing where neither is.
    pub fn diagnosis_text(&self) -> Option<String> {
        match &self.diagnosis {
            Diagnosis::Sound => None,
            Diagnosis::LabelTooLow { order } => {
                let claimed = self.file.order().unwrap_or(0);
                Some(format!(
                    "The label is too low: order {claimed} is claimed, and the coefficients have order {order}."
                ))
            }
            Diagnosis::LabelTooHigh { order } => {
                let claimed = self.file.order().unwrap_or(0);
                let weights = if self.theory.main.order < claimed { "b" } else { "b_hat" };
                Some(format!(
                    "The label is too high, or more than one coefficient is wrong: the row sums hold, the conditions on \
                     {weights} fail, and no change of a single coefficient mends them. As they stand they have order {order}."
                ))
            }
            Diagnosis::Coefficient { target, repairs } => {
                let embedded = target.embedded.map_or_else(String::new, |q| format!(", of the embedded method {q}"));
                let start = format!(
                    "With one coefficient changed the order is {}{embedded}, and all row sums hold",
                    target.order
                );
                let doubt = match repairs.first() {
                    Some(repair) if repair.mends == 1 => {
                        " One number that satisfies one condition may be a coincidence: it may be the label that is wrong."
                    }
                    _ => "",
                };
                Some(format!("A coefficient is wrong. {start}.{doubt}"))
            }
            Diagnosis::Several { rows } => {
                let rows: Vec<String> = rows.iter().map(|i| (i + 1).to_string()).collect();
                let rows = rows.join(", ");
                Some(format!(
                    "More than one coefficient is wrong: no change of a single one mends the row sums of stages {rows}, and the order."
                ))
            }
        }
    }

    /// The changes that mend everything, each in a line.
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
        let with_c = match (self.with_c, self.place) {
            (true, super::tableau::Place::A(i, _)) => format!(", and c[{}] with it", i + 1),
            _ => String::new(),
        };
        let failing = if self.mends == 1 {
            "the failing condition".into()
        } else {
            format!("all {} failing conditions", self.mends)
        };
        format!("{}: {} → {}{with_c}, mends {failing}", self.place, self.was, self.text)
    }
}

fn order(weights: &WeightsTheory) -> String {
    let failing = weights.conditions.iter().find(|c| !c.holds());
    match (failing, weights.error_norm) {
        (Some(first), Some(norm)) => format!(
            "{}; first failing tree {}, principal error {norm:.3e}",
            weights.order,
            weights.forest.brackets(first.tree)
        ),
        _ => format!("{MAX_ORDER} or more: every condition looked at holds"),
    }
}

fn reach(reach: Reach, axis: &str) -> String {
    match reach {
        Reach::Everything => format!("all of the {axis} axis"),
        Reach::UpTo { end: 0.0, .. } => format!("nothing of the {axis} axis"),
        Reach::UpTo { end, .. } => format!("{axis} axis to {end:.4}"),
    }
}

fn short(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}
