//! Whether steps see how f depends on time.

use verify::measure::norm::larger;
use verify::problem::Problem;

use crate::cli::layout::number;

/// Steps that are looked at, the first ones, and of large systems the values of f in them.
const STEPS: usize = 1000;
const VALUES: usize = 1_000_000;

/// Times in a step, and the weights of Simpson's rule and of Gauss' with three nodes, which is at no equal parts of it.
const NODES: [f64; 5] = [0.0, 0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7, 1.0];
const SIMPSON: [f64; 5] = [1.0 / 6.0, 0.0, 2.0 / 3.0, 0.0, 1.0 / 6.0];
const GAUSS: [f64; 5] = [0.0, 5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0, 0.0];

/// Times the estimate of the error, and part of the solution, that the difference of the two comes to where f is not resolved.
const BEYOND: f64 = 10.0;
const PART: f64 = 1e-3;

/// What two quadratures of f(t, v) in t make of it along a run, v as it is at the start of each step.
///
/// The one has its nodes at the ends and the middles of the steps, where two runs with h and h/2 look: both may see one phase alone of
/// what is periodic, and agree.
#[derive(Debug, Default)]
pub(super) struct Forcing {
    last: Option<(f64, Vec<f64>)>,
    steps: usize,
    /// Sum over the steps of the difference of the two, of the component for which it is largest in each.
    difference: f64,
}

impl Forcing {
    /// The next row of a run.
    pub(super) fn add(&mut self, problem: &dyn Problem, t: f64, state: &[f64]) {
        let ode = problem.ode();
        if self.steps > STEPS.min(VALUES / state.len().max(1)) || ode.dim() != state.len() {
            return;
        }
        // The references' f may be dear, as a convolution of all modes is.
        if let Some((before, v)) = &self.last
            && depends_on_time(problem, *before, t - before, v)
        {
            let (h, n) = (t - before, v.len());
            let mut difference = vec![0.0; n];
            let mut f = vec![0.0; n];
            for ((node, a), b) in NODES.iter().zip(SIMPSON).zip(GAUSS) {
                ode.rhs(before + node * h, v, &mut f);
                difference.iter_mut().zip(&f).for_each(|(sum, f)| *sum += h * (a - b) * f);
            }
            // What is not finite is said elsewhere.
            self.difference += difference.into_iter().map(f64::abs).filter(|x| x.is_finite()).fold(0.0, larger);
        }
        self.steps += 1;
        self.last = Some((t, state.to_vec()));
    }

    /// That the run does not see f, where its largest error is estimated to be `estimate` and its largest component is `size`.
    pub(super) fn unresolved(&self, estimate: f64, size: f64) -> Option<String> {
        (self.difference > BEYOND * estimate && self.difference > PART * size).then(|| {
            format!(
                "f changes in time faster than the steps: between their ends and middles it integrates to something else, by {} in all, and the \
                 estimate, {}, does not know; a step that is no multiple of its period, or a smaller one, tells",
                number(self.difference),
                number(estimate)
            )
        })
    }
}

/// Whether the method's own f differs anywhere in a step, `v` as it is.
fn depends_on_time(problem: &dyn Problem, t: f64, h: f64, v: &[f64]) -> bool {
    let field = problem.field();
    if field.dim() != v.len() {
        return true;
    }
    let values = NODES.map(|node| {
        let mut f = vec![0.0; v.len()];
        field.rhs(t + node * h, v, &mut f);
        f
    });
    let [first, others @ ..] = &values;
    others.iter().any(|f| f != first)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use lsvi::{VectorField, field};
    use verify::reference::Ode;

    use super::*;

    /// v̇ = cos(ω t) for the method and for references, whose evaluations are counted.
    #[derive(Debug, Default)]
    struct Forced {
        frequency: f64,
        evaluations: AtomicU32,
    }

    impl Ode for Forced {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, t: f64, _v: &[f64], dv: &mut [f64]) {
            self.evaluations.fetch_add(1, Ordering::Relaxed);
            dv[0] = (self.frequency * t).cos();
        }
        fn jacobian(&self, _t: f64, _v: &[f64], _add: &mut dyn FnMut(usize, usize, f64)) {}
    }

    impl Problem for Forced {
        fn components(&self) -> &'static [&'static str] {
            &["v"]
        }
        fn initial(&self) -> Vec<f64> {
            vec![0.0]
        }
        fn field(&self) -> Box<dyn VectorField + '_> {
            Box::new(field!(1, frequency = self.frequency; |t, v, dv| dv[0] = v[0] * 0.0 + (t * frequency).cos()))
        }
        fn ode(&self) -> &dyn Ode {
            self
        }
    }

    #[test]
    fn the_references_are_asked_where_f_depends_on_time_alone() {
        for (frequency, evaluations) in [(0.0, 0), (std::f64::consts::TAU, 10)] {
            let problem = Forced { frequency, ..Forced::default() };
            let mut forcing = Forcing::default();
            [0.0, 1.0, 2.0].into_iter().for_each(|t| forcing.add(&problem, t, &[0.0]));
            assert_eq!(problem.evaluations.load(Ordering::Relaxed), evaluations, "{frequency}");
            // With steps of a period both ends and the middle of one make −1/3 of ∫ cos, which is 0.
            assert_eq!(forcing.unresolved(1e-6, 1.0).is_some(), evaluations > 0);
        }
    }
}
