//! Whether a model passes a state at which the condition of a closure leaves a step open.

use nalgebra::{Complex, DMatrix};

use super::answer::DENSE;
use crate::kinds::Principle;
use crate::measure::stability::eigenvalues;
use crate::method::{self, Method};
use crate::problem::Problem;
use crate::run::run;
use crate::theory::Breakdown;

/// Parts of the run in each of which it is looked at once at least.
const PARTS: f64 = 1000.0;

/// Part of the size of a matrix at which an eigenvalue of it is zero.
const ZERO: f64 = 1e-9;

/// As h → 0 a closure with p₁ = (1 − ½hλ) p₀, λ = 0 for p₁ = p₀, is (½λ − Jᵀ)(r₀ + r₁) = 0 with J = ∂f/∂v: open where ½λ is an eigenvalue of J. That is
/// so between states of which one has more real eigenvalues to the right of ½λ than the other.
pub(super) fn passed(problem: &dyn Problem, method: &dyn Method, horizon: f64) -> Option<Breakdown> {
    let rate = match method.principle() {
        Principle::MomentumConserved => 0.0,
        Principle::MomentumDecaying => method.traits().fitted?.0,
        _ => return None,
    };
    let ode = problem.ode();
    if problem.facts().model.is_none() || ode.dim() > DENSE {
        return None;
    }
    let mut counts = Vec::new();
    let accurate = method::parse("radau-adaptive").ok()?;
    // What it comes to before it fails is what there is to look at.
    let _ = run(problem, &*accurate, horizon / PARTS, horizon, |state| {
        let mut matrix = DMatrix::zeros(ode.dim(), ode.dim());
        ode.jacobian(state.t, &state.q, &mut |i, j, x| matrix[(i, j)] += x);
        counts.push(real_to_the_right(&eigenvalues(&matrix), 0.5 * rate, ZERO * matrix.amax()));
    });
    let is_passed = counts.iter().any(Option::is_none) || counts.windows(2).any(|pair| pair[0] != pair[1]);
    let reason = "the solution passes states at which the condition of the closure leaves a step open";
    is_passed.then_some(Breakdown { reason, is_certain: false })
}

/// How many real eigenvalues are larger than `rate`; `None` if one is that to `zero`.
fn real_to_the_right(eigenvalues: &[Complex<f64>], rate: f64, zero: f64) -> Option<usize> {
    let is_at = |z: &&Complex<f64>| (*z - rate).norm() <= zero;
    let is_right = |z: &&Complex<f64>| z.im.abs() <= zero && z.re > rate;
    eigenvalues.iter().find(is_at).is_none().then(|| eigenvalues.iter().filter(is_right).count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::model::Model;

    fn is_passed(text: &str, name: &str) -> bool {
        let model = Model::of_text(text, &[], Some(20.0)).expect("a model");
        passed(&model, &*method::parse(name).expect("registered"), 20.0).is_some()
    }

    /// The relaxation of the Brusselator grows by 5.1 for moments, where ½ · 4 is half of the fitted rate, and not ½ · 40.
    #[test]
    fn a_closure_is_open_where_growth_passes_half_of_its_rate() {
        let brusselator = "u_i { x = 1.5, y = 3 } F_i { 1 + x*x*y - 4*x, 3*x - x*x*y }";
        let found = ["fitted-pade(4)", "fitted-pade(40)", "method-i"].map(|name| is_passed(brusselator, name));
        assert_eq!(found, [true, false, false]);
    }

    /// An invariant is an eigenvalue of zero.
    #[test]
    fn method_ii_is_open_where_a_sum_is_conserved_and_where_growth_saturates() {
        let [closed, saturating, decaying] = ["-x + y, x - y", "x - x*x, -y", "-x, -2*y"]
            .map(|f| is_passed(&format!("u_i {{ x = 0.1, y = 0.5 }} F_i {{ {f} }}"), "method-ii"));
        assert!(closed && saturating && !decaying, "{closed} {saturating} {decaying}");
    }
}
