//! High order: Galerkin least-squares variational integrators of every family, degree and closure.

use std::sync::Arc;

use super::parts::order_check;
use super::{Context, Study, StudyError, prose};
use crate::evidence::{Check, Evidence, Requirement, Table, number};
use crate::experiment::high_order::{Collocates, FAR, Linearised, OnLinear, OnVanDerPol, ROUNDOFF};
use crate::measure::order::OrderFit;
use crate::method::Method;
use crate::method::high_order::{Family, LsGalerkin};
use crate::row;

pub(super) const STUDY: Study = Study {
    id: "high-order",
    title: "More sophisticated integrators",
    question: "What do paths of higher degree and better quadrature make of the closures?",
    source: "[S24] Section 6, future work; [HW96] IV.3, IV.5",
    run,
};

/// Highest degree in the tables.
const DEGREES: usize = 4;

/// (α, β) of Methods I and II.
const CLOSURES: [(f64, f64); 2] = [(0.0, 1.0), (-1.0, 1.0)];

fn run(context: &Context) -> Result<Evidence, StudyError> {
    let methods = methods();
    let linear = context.get_each(methods.iter().map(|method| OnLinear(*method)).collect())?;
    let nonlinear = context.get_each(methods.iter().map(|method| OnVanDerPol(*method)).collect())?;
    let mut checks: Vec<Check> = linear.iter().flat_map(|linear| checks(linear)).collect();
    let measured = methods.iter().zip(&nonlinear);
    checks.extend(measured.filter_map(|(method, fit)| Some(order(*method, fit.as_ref().as_ref()?))));
    for method in methods.into_iter().filter(|method| method.is_collocation()) {
        checks.push(collocates(context, method)?);
    }
    Ok(Evidence {
        checks,
        tables: vec![table(&linear, &nonlinear)],
        notes: prose::fill(include_str!("high_order.md"), &[])?,
        ..Evidence::default()
    })
}

/// Method I throughout, and Method II where it differs.
fn methods() -> Vec<LsGalerkin> {
    let mut methods = Vec::new();
    for family in Family::ALL {
        for degree in 1..=DEGREES {
            for nodes in [degree, degree + 1] {
                for (alpha, beta) in CLOSURES {
                    let repeated = nodes == degree && alpha != 0.0;
                    if family.rule(nodes).is_ok() && !repeated {
                        methods.push(LsGalerkin { degree, family, nodes, alpha, beta });
                    }
                }
            }
        }
    }
    methods
}

fn is_a_stable(linear: &Linearised) -> bool {
    linear.largest <= 1.0 + ROUNDOFF
}

fn is_l_stable(linear: &Linearised) -> bool {
    is_a_stable(linear) && linear.infinity.abs() <= far_tolerance(linear.method)
}

/// FAR · |R(−FAR) − R(∞)| is largest for the diagonal Padé approximation of degree k: 2k(k + 1), and k ≤ s + 1.
fn far_tolerance(method: LsGalerkin) -> f64 {
    let s = method.degree as f64;
    2.0 * (s + 1.0) * (s + 2.0) / FAR
}

fn expected_infinity(method: LsGalerkin) -> f64 {
    let s = method.degree as i32;
    let alternating = |k: i32| if k % 2 == 0 { 1.0 } else { -1.0 };
    match (method.family, method.is_collocation(), method.alpha == 0.0) {
        (Family::Radau, true, _) | (Family::Lobatto, false, true) => 0.0,
        (Family::Gauss, true, _) => alternating(s),
        (Family::Lobatto, true, _) => alternating(s - 1),
        (_, false, true) => alternating(s) / f64::from(s + 1),
        (_, false, false) => -1.0,
    }
}

/// The error constant of the (j, k) Padé approximation, −(−1)ᵏ j! k!/((j + k)! (j + k + 1)!), of collocation, and that of the diagonal one of Method I
/// with even s.
///
/// Its residual is orthogonal to φ′ − λφ for all paths φ with φ(0) = 0, so that it is in proportion to P_s + λ a₁ P_{s−1} + … + λˢ a_s P₀, and
/// in the error ∫ e^{λ(1−t)} r dt each term is as large as the one before, with the other sign: of their sum for even s the first is left, which
/// is collocation's, and nothing for odd s. So it is found by Lobatto's rule too, which is not exact for P_s².
fn pade_constant(method: LsGalerkin) -> Option<f64> {
    let s = method.degree as u32;
    let (j, k) = match method.family {
        _ if !method.is_collocation() && method.alpha == 0.0 && s.is_multiple_of(2) => (s, s),
        _ if !method.is_collocation() => return None,
        Family::Gauss => (s, s),
        Family::Radau => (s - 1, s),
        Family::Lobatto => (s - 1, s - 1),
    };
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
    Some(-sign * factorial(j) * factorial(k) / (factorial(j + k) * factorial(j + k + 1)))
}

fn checks(linear: &Linearised) -> Vec<Check> {
    let name = linear.method.name();
    let check = |what: &str, statement: String, measured: f64, required| {
        Check::new(format!("{what}/{name}"), statement, measured, required, "one step of the integrator on v̇ = λv")
    };
    let (order, infinity) = (linear.method.symmetric_order(), expected_infinity(linear.method));
    let mut checks = vec![
        check(
            "linear-order",
            format!("{name} has order {order} on v̇ = λv"),
            linear.slope,
            Requirement::Near(f64::from(order), 0.5),
        ),
        check(
            "infinity",
            format!("R(∞) of {name} is {infinity:.4}"),
            linear.infinity,
            Requirement::Near(infinity, far_tolerance(linear.method)),
        ),
        check(
            "a-stability",
            format!("|R| ≤ 1 at all samples of the left half-plane for {name}"),
            linear.largest,
            Requirement::AtMost(1.0 + ROUNDOFF),
        ),
    ];
    // Two digits at least, so that another constant is told from it.
    checks.push(check(
        "constant-known",
        format!("the error constant of {name} is known to a hundredth: bound on its error over it"),
        linear.constant.bound / linear.constant.value.abs(),
        Requirement::AtMost(0.01),
    ));
    if let Some(pade) = pade_constant(linear.method) {
        checks.push(check(
            "error-constant",
            format!("the error constant of {name} is that of its Padé approximation"),
            linear.constant.value,
            Requirement::Near(pade, linear.constant.bound),
        ));
    }
    checks
}

/// The order on van der Pol's oscillator.
fn order(method: LsGalerkin, fit: &OrderFit) -> Check {
    let (name, order) = (method.name(), method.order());
    let statement = format!("{name} has order {order} on van-der-pol");
    order_check(format!("order/{name}"), statement, fit)
}

fn table(linear: &[Arc<Linearised>], nonlinear: &[Arc<Option<OrderFit>>]) -> Table {
    let verdict = |yes: bool| if yes { "yes" } else { "no" };
    let rows = linear.iter().zip(nonlinear).map(|(linear, nonlinear)| {
        let measured = (**nonlinear).as_ref().and_then(|fit| fit.line).map(|line| line.slope);
        row![
            linear.method.name(),
            linear.method.order(),
            measured,
            linear.order,
            number::resolved(linear.constant.value, linear.constant.bound),
            linear.infinity,
            linear.largest - 1.0,
            verdict(is_a_stable(linear)),
            verdict(is_l_stable(linear)),
        ]
    });
    let caption = "Galerkin least-squares integrators of degree s = 1 … 4: order by theory and on van der Pol's oscillator, \
                   and on v̇ = λv the order p, the constant of R(z) − eᶻ = C z^(p+1) in the digits that its bound leaves, R(−10⁵), and the excess of the \
                   largest |R| sampled in the left half-plane over 1. On van der Pol's oscillator nothing is measured above order 6, where errors sink to \
                   rounding before they settle, and nothing of Method II, whose Jacobian is singular on the way.";
    let columns = [
        "method",
        "order",
        "measured",
        "linear_order",
        "error_constant",
        "r_infinity",
        "excess",
        "a_stable",
        "l_stable",
    ];
    Table::new("high-order", caption, columns, rows.collect())
}

/// One step of a method with r = s against the Runge–Kutta method of its nodes.
fn collocates(context: &Context, method: LsGalerkin) -> Result<Check, StudyError> {
    // The least-squares equations have the square of the condition of collocation, s⁴, and a few roundings per node.
    let tolerance = 32.0 * (method.degree as f64).powi(4) * f64::EPSILON;
    Ok(Check::at_most(
        format!("collocation/{}", method.name()),
        format!("{} is the collocation method of its nodes", method.name()),
        *context.get(Collocates(method))?,
        tolerance,
        "a step on van der Pol's oscillator against the Runge–Kutta method with a_ij = ∫₀^{c_i} l_j",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::Outcome;
    use crate::measure::extrapolation::Bounded;

    /// With R(∞) = 0, as Radau, with 1, as Gauss, and with 0 where a step amplifies.
    #[test]
    fn what_is_a_stable_is_l_stable_where_it_damps_at_infinity() {
        for (infinity, largest, expected) in
            [(0.0, 1.0, ["yes", "yes"]), (1.0, 1.0, ["yes", "no"]), (0.0, 1.1, ["no", "no"])]
        {
            let constant = Bounded { value: 1.0, bound: 1e-9 };
            let linear = Linearised { method: methods()[0], slope: 1.0, order: 1, constant, infinity, largest };
            let table = table(&[Arc::new(linear)], &[Arc::new(None)]);
            let told =
                ["a_stable", "l_stable"].map(|name| table.rows[0][table.column(name).expect("there")].to_string());
            assert_eq!(told, expected, "R(∞) = {infinity}, |R| ≤ {largest}");
        }
    }

    /// R(z) − eᶻ by hand: z²/2 of implicit Euler, z³/12 of the midpoint and the trapezoidal rule, −z⁴/72 of Radau IIA with two stages.
    #[test]
    fn the_error_constant_of_every_collocation_method_is_checked() {
        let by_hand =
            [("radau", 1, 0.5), ("gauss", 1, 1.0 / 12.0), ("lobatto", 2, 1.0 / 12.0), ("radau", 2, -1.0 / 72.0)];
        let mut found = 0;
        for method in methods().into_iter().filter(|method| method.is_collocation()) {
            let (name, bound) = (method.name(), 1e-9);
            let of = |value: f64| {
                let constant = Bounded { value, bound };
                let linear = Linearised { method, slope: 1.0, order: 1, constant, infinity: 0.0, largest: 1.0 };
                let check = checks(&linear).into_iter().find(|check| check.id == format!("error-constant/{name}"));
                check.unwrap_or_else(|| panic!("{name}"))
            };
            let Some(Requirement::Near(pade, _)) = of(0.0).required else { panic!("{name}") };
            assert_eq!(
                [0.9, -0.9, 1.1].map(|part| of(pade + part * bound).outcome == Outcome::Pass),
                [true, true, false]
            );
            for (family, degree, constant) in by_hand {
                if name.starts_with(&format!("ls-galerkin({degree},{family},")) {
                    assert!((pade / constant - 1.0).abs() < 1e-14, "{name}: {pade}");
                    found += 1;
                }
            }
        }
        assert_eq!(found, by_hand.len());
    }
}
