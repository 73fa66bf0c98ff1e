//! Whether steps see how f depends on time.

use verify::measure::norm::larger;
use verify::problem::Problem;

use crate::cli::layout::number;

/// Steps that are looked at, the first ones.
const STEPS: usize = 1000;

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
        if self.steps > STEPS || ode.dim() != state.len() {
            return;
        }
        if let Some((before, v)) = &self.last {
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
