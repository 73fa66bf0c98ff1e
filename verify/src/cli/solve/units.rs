//! Whether a step goes wrong for the units of the components: least squares weigh those of f alike, in whatever units they are.

use nalgebra::DVector;
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use verify::experiment::{SCALED, exponential, propagator};
use verify::measure::norm::Extremes;
use verify::method::Method;
use verify::problem::{Problem, component_names};

use super::equation::{DENSE, jacobian};

/// A step is wrong for its units if in others its error is this part of what it is.
const PART: f64 = 0.1;

/// The units in which the entries of the Jacobian are alike, and in which a step of `h` from `v` is not off in component `k` as it is in those of
/// the model, as far as the linearised equation tells. A Runge–Kutta method does the same in all.
pub(super) fn unlike(
    problem: &dyn Problem,
    method: &dyn Method,
    (t, v): (f64, &[f64]),
    h: f64,
    k: usize,
) -> Option<String> {
    let (ode, n) = (problem.ode(), v.len());
    if ode.dim() != n || !(2..=DENSE).contains(&n) {
        return None;
    }
    let a = h * jacobian(problem, t, v);
    let mut f = DVector::zeros(n);
    ode.rhs(t, v, f.as_mut_slice());
    let f = h * f;
    // Of a run that blew up nothing is told, nor do its powers and singular values come to an end.
    if !a.iter().chain(&f).all(|x| x.abs() < SCALED) {
        return None;
    }
    // D⁻¹AD with the diagonal D of the units.
    let mut balanced = a.clone();
    let units = balance_parlett_reinsch(&mut balanced);
    // Of the solution, d with A d = f is carried on by e^A, and by the matrix of a step; all in those units, in which no digits are lost.
    let svd = balanced.clone().svd(true, true);
    let least = f64::EPSILON * n as f64 * svd.singular_values.max();
    let distance = svd.solve(&f.component_div(&units), least).ok()?;
    let solution = exponential(&balanced)? * &distance;
    let there = (propagator(method, &balanced).ok()? * &distance - &solution).component_mul(&units);
    let here = propagator(method, &a).ok()? * distance.component_mul(&units) - solution.component_mul(&units);
    let is_mended = there[k].abs() < PART * here[k].abs();
    let (largest, smallest) = (units.iter().copied().largest(), units.iter().copied().smallest());
    let named = |unit: f64| Some(&component_names(problem)[units.iter().position(|other| *other == unit)?]).cloned();
    let names = [named(smallest)?, named(largest)?];
    is_mended.then(|| {
        format!(
            "least squares weigh the components of f alike, whose units are not: with {} in units of {:.0e} of those of {} the step is another; \
             scale the variables so, or take a Runge–Kutta method",
            names[0],
            smallest / largest,
            names[1]
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use verify::method;
    use verify::problem::model::Model;

    /// x turns with v at a rate of 1, in units that are 10⁹ and 10⁻⁹ of one another, or alike.
    #[test]
    fn units_are_named_where_a_step_goes_right_in_others() {
        let from = |state: &[f64], h: f64, k: usize, rates: &str, name: &str| {
            let (starts, rests) =
                ((2..state.len()).map(|k| format!(", w{k} = 0")), (2..state.len()).map(|k| format!(", -w{k}")));
            let text = format!(
                "u_i {{ x = 1, v = 0{} }} F_i {{ {rates}{} }}",
                starts.collect::<String>(),
                rests.collect::<String>()
            );
            let problem = Model::of_text(&text, &[], None).expect("a model");
            let method = method::parse(name).expect("registered");
            unlike(&problem, &*method, (0.0, state), h, k)
        };
        let found = |rates: &str, name: &str| from(&[1.0, 0.0], 0.1, 0, rates, name);
        let (unlike, alike) = ("1e9*v, -1e-9*x", "v, -x");
        let told = found(unlike, "method-i").expect("it hardly moves");
        assert!(told.contains("with v in units of 9e-10 of those of x"), "{told}");
        // By any step, however small, of v; not of what rests, nor beside many others.
        assert!(from(&[1.0, 0.0], 1e-9, 1, unlike, "method-i").is_some());
        assert_eq!(from(&[0.0, 0.0], 0.1, 0, unlike, "method-i"), None);
        let many = |n: usize| from(&[&[1.0][..], &vec![0.0; n - 1]].concat(), 0.1, 0, unlike, "method-i").is_some();
        assert_eq!([3, DENSE + 1].map(many), [true, false]);
        assert_eq!(found("1e200*v, -1e200*x", "rk4"), None);
        for (rates, name) in [
            (alike, "method-i"),
            // In units that are alike 0.4 of its error are left.
            ("2*v, -0.5*x", "method-i"),
            (unlike, "implicit-euler"),
            (unlike, "ls-galerkin(3,gauss,3)"),
        ] {
            assert_eq!(found(rates, name), None, "{rates} by {name}");
        }
    }
}
