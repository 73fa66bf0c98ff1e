//! A run that stays, for some time on the way, where solutions of the equation do not.

use nalgebra::DMatrix;
use verify::experiment::growth;
use verify::measure::norm::{larger, max_norm};
use verify::measure::stability::spectral_abscissa;
use verify::method::Method;
use verify::problem::Problem;

use super::beware::{BEYOND, OFF, Row};
use super::equation::{abscissa_bound, jacobian};
use crate::cli::layout::{number, plain};

/// Largest system that is looked at in every step.
const SMALL: usize = 16;

/// Growth in a step, as the logarithm of a factor, below which methods show it.
const SHOWN: f64 = 0.5;

/// Growth that steps do not show, as the logarithm of a factor, beyond which half of the step does not show it either: of order two it
/// lacks a quarter, a factor of two.
const LACKING: f64 = 3.0;

/// Steps in which it grows; a single one may be the step in which the solution leaves.
const STAY: u32 = 2;

/// Halvings of a step in which its growth may show.
const HALVINGS: i32 = 40;

/// Follows the latest stay: consecutive steps in which perturbations grow and the method does not show it.
#[derive(Debug, Default)]
pub(super) struct Held {
    latest: Stay,
    /// The one after which the largest errors are to be expected.
    worst: Option<Stay>,
    /// The largest estimate of all rows, and that of the last.
    estimate: f64,
    last_estimate: f64,
}

#[derive(Debug, Clone)]
struct Stay {
    steps: u32,
    /// The times of its start and its end.
    times: [f64; 2],
    /// The estimate at its start, of which there may be none.
    error: f64,
    /// Logarithms of the factors by which the equation and the method multiply perturbations.
    growth: [f64; 2],
    /// h ∂f/∂v in the step of the largest growth, and that.
    matrix: DMatrix<f64>,
    fastest: f64,
    h: f64,
}

impl Default for Stay {
    fn default() -> Self {
        let matrix = DMatrix::zeros(0, 0);
        Self { steps: 0, times: [0.0; 2], error: 0.0, growth: [0.0; 2], matrix, fastest: 0.0, h: 0.0 }
    }
}

impl Stay {
    /// What becomes of the error at its start, or of rounding, in solutions of the size of `largest`.
    fn error(&self, largest: f64) -> f64 {
        larger(self.error, f64::EPSILON * largest) * self.growth[0].exp()
    }

    fn is_hidden(&self) -> bool {
        self.steps >= STAY && self.growth[0] - self.growth[1] > LACKING
    }
}

impl Held {
    /// A step of `method` from `start` to a row of a run that has come to `largest`.
    pub(super) fn add(&mut self, problem: &dyn Problem, method: &dyn Method, start: f64, row: &Row, largest: f64) {
        let h = row.t - start;
        // What goes beyond all that was before leaves.
        let stays = max_norm(row.state) <= 2.0 * largest;
        match stays.then(|| growth_in_a_step(problem, method, (row.t, row.state), h)).flatten() {
            None => self.latest = Stay::default(),
            Some((growth, matrix)) => {
                let stay = &mut self.latest;
                if stay.steps == 0 {
                    *stay = Stay { times: [start; 2], error: self.last_estimate, h, ..Stay::default() };
                }
                stay.steps += 1;
                stay.times[1] = row.t;
                (0..2).for_each(|i| stay.growth[i] += growth[i]);
                if growth[0] > stay.fastest {
                    (stay.fastest, stay.matrix) = (growth[0], matrix);
                }
                let is_worst = self.worst.as_ref().is_none_or(|worst| stay.error(largest) > worst.error(largest));
                if stay.is_hidden() && is_worst {
                    self.worst = Some(stay.clone());
                }
            }
        }
        self.last_estimate = row.estimate.unwrap_or(0.0);
        self.estimate = larger(self.estimate, self.last_estimate);
    }

    /// What is to be said of it after a run of `method`, in solutions of the size of `largest`.
    pub(super) fn told(&self, method: &dyn Method, largest: f64) -> Option<String> {
        let stay = self.worst.as_ref()?;
        let error = stay.error(largest);
        // Estimates of the size of the solution say so themselves.
        let is_news = error > BEYOND * self.estimate && BEYOND * self.estimate < largest;
        (is_news && error > OFF * largest).then(|| {
            format!(
                "from t = {} to {} perturbations grow by a factor of e^{}, and the steps of h = {} multiply them by {} alone: the run stays \
                 where solutions of the equation do not, and half of h does not tell; {}",
                plain(stay.times[0]),
                plain(stay.times[1]),
                number(stay.growth[0]),
                plain(stay.h),
                number(stay.growth[1].exp()),
                step_that_shows(method, &stay.matrix, stay.h)
            )
        })
    }
}

/// The logarithms of the factors by which the equation and the method multiply perturbations in a step, and h ∂f/∂v there; none where perturbations hardly
/// grow.
fn growth_in_a_step(
    problem: &dyn Problem,
    method: &dyn Method,
    (t, v): (f64, &[f64]),
    h: f64,
) -> Option<([f64; 2], DMatrix<f64>)> {
    if v.len() > SMALL || method.traits().is_adaptive {
        return None;
    }
    let a = h * jacobian(problem, t, v);
    let grows = abscissa_bound(&a) > SHOWN;
    // NaN, of what is not finite, is no growth.
    let exponent = grows.then(|| spectral_abscissa(&a)).filter(|exponent| *exponent > SHOWN)?;
    let shown = growth(method, &a)?.ln();
    // A method that lets them grow faster hides nothing.
    Some(([exponent, shown.min(exponent)], a))
}

/// The first half of h, of that, and so on with which `method` shows half of the growth of perturbations at least, A standing for hA: beside a
/// fast rotation that may be far below the time in which they grow.
pub(super) fn step_that_shows(method: &dyn Method, a: &DMatrix<f64>, h: f64) -> String {
    let exponent = spectral_abscissa(a);
    let shows = |part: &f64| growth(method, &(*part * a)).is_some_and(|factor| factor.ln() >= 0.5 * part * exponent);
    match (1..=HALVINGS).map(|k| 0.5_f64.powi(k)).find(shows) {
        Some(part) => format!("steps of h = {} show the growth", number(part * h)),
        None => "a smaller step may show the growth".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::solve::equation::model;

    /// ẋ = x in steps of 4, of which implicit Euler has none of the growth: the stay begins with the error of the row before.
    #[test]
    fn a_stay_begins_with_the_error_where_it_begins() {
        let problem = verify::problem::build("linear-drag", &[("lambda".into(), "-1".into())]).expect("known");
        let method = verify::method::parse("implicit-euler").expect("known");
        let mut held = Held::default();
        // The largest one before it has gone by then.
        for (t, x, estimate) in [(4.0, 9.0, 9e-3), (8.0, 3.0, 1e-3), (12.0, 1.0, 7e-3), (16.0, 1.0, 2e-3)] {
            // The first leave what was before, by their sizes.
            let row = Row { t, state: &[x], estimate: Some(estimate), has_ended: false };
            held.add(&*problem, &*method, t - 4.0, &row, 1.0);
        }
        assert_eq!((held.latest.steps, held.latest.times, held.latest.error), (2, [8.0, 16.0], 1e-3));
        assert_eq!((held.worst.expect("it is hidden").error, held.estimate), (1e-3, 9e-3));
    }

    /// In steps of 4, 6 and 4: what shows the growth is looked for in the longest.
    #[test]
    fn a_stay_keeps_the_step_of_the_largest_growth() {
        let problem = verify::problem::build("linear-drag", &[("lambda".into(), "-1".into())]).expect("known");
        let method = verify::method::parse("implicit-euler").expect("known");
        let mut held = Held::default();
        for (start, t) in [(0.0, 4.0), (4.0, 10.0), (10.0, 14.0)] {
            let row = Row { t, state: &[1.0], estimate: None, has_ended: false };
            held.add(&*problem, &*method, start, &row, 1.0);
        }
        assert_eq!((held.latest.fastest, held.latest.matrix[(0, 0)]), (6.0, 6.0));
    }

    /// Two steps of 4, in which e⁸ is hidden, and after the solution has left two of 2 that hide e⁴; one step may be that in which it leaves.
    #[test]
    fn the_stay_that_hides_the_largest_growth_is_kept() {
        let problem = verify::problem::build("linear-drag", &[("lambda".into(), "-1".into())]).expect("known");
        let method = verify::method::parse("implicit-euler").expect("known");
        let mut held = Held::default();
        for (start, t, x, kept) in [
            (0.0, 4.0, 1.0, None),
            (4.0, 8.0, 1.0, Some([0.0, 8.0])),
            (8.0, 10.0, 3.0, Some([0.0, 8.0])),
            (10.0, 12.0, 1.0, Some([0.0, 8.0])),
            (12.0, 14.0, 1.0, Some([0.0, 8.0])),
        ] {
            held.add(&*problem, &*method, start, &Row { t, state: &[x], estimate: None, has_ended: false }, 1.0);
            assert_eq!(held.worst.as_ref().map(|stay| stay.times), kept, "t = {t}");
        }
        assert!(held.latest.is_hidden());
    }

    /// Where no error is known, perturbations begin as the rounding of a solution of any size.
    #[test]
    fn an_error_begins_as_a_rounding_of_the_solution() {
        let stay = Stay { growth: [2.0, 0.0], ..Stay::default() };
        assert_eq!(stay.error(1e6), 1e6 * f64::EPSILON * 2.0_f64.exp());
    }

    /// An estimate of a third of the solution says so itself, and one above a third of the error covers it.
    #[test]
    fn what_the_estimate_says_is_not_said_again() {
        let fast = Stay { matrix: DMatrix::from_element(1, 1, 5.0), fastest: 5.0, h: 1.0, ..Stay::default() };
        let stay = Stay { steps: STAY, error: 1e-3, growth: [10.0, 0.0], times: [0.0, 2.0], ..fast };
        assert!(stay.is_hidden());
        let shown = [Stay { steps: STAY - 1, ..stay.clone() }, Stay { growth: [10.0, 8.0], ..stay.clone() }];
        assert!(!shown.iter().any(Stay::is_hidden), "too short a stay, and one whose growth the steps show");
        let told = |estimate: f64, error: f64| {
            let worst = Some(Stay { error, ..stay.clone() });
            let method = verify::method::parse("implicit-euler").expect("known");
            Held { worst, estimate, ..Held::default() }.told(&*method, 1.0).is_some()
        };
        // e¹⁰ is 22 026.
        assert_eq!([0.99, 1.01].map(|part| told(part / BEYOND, 1e-3)), [true, false]);
        assert_eq!([1.1, 0.9].map(|part| told(0.3 / BEYOND, part * 0.3 / 22_026.0)), [true, false]);
    }

    /// Implicit Euler damps 0.1 ± 10i where |1 − hλ| > 1, and has half of the growth where h < 0.001.
    #[test]
    fn the_step_that_shows_growth_beside_a_fast_rotation_is_short() {
        let a = DMatrix::from_row_slice(2, 2, &[0.1, -10.0, 10.0, 0.1]);
        let told = |name: &str, h: f64| step_that_shows(&*verify::method::parse(name).expect("known"), &(h * &a), h);
        assert_eq!(told("implicit-euler", 0.05), format!("steps of h = {} show the growth", number(0.05 / 64.0)));
    }

    /// By e⁴ in a step of 4; beyond a factor of √e, where f has a derivative.
    #[test]
    fn growth_is_looked_at_in_fixed_steps_of_small_systems() {
        let grows = |n: usize, rate: &str, h: f64, method: &str| {
            let starts = (1..n).map(|k| format!(", y{k} = 0")).collect::<String>();
            let problem = model(&format!("u_i {{ x = 0{starts} }} F_i {{ {rate}{} }}", ", 0".repeat(n - 1)));
            let method = verify::method::parse(method).expect("known");
            growth_in_a_step(&problem, &*method, (0.0, &vec![0.0; n]), h).is_some()
        };
        assert_eq!([SMALL, SMALL + 1].map(|n| grows(n, "x", 4.0, "implicit-euler")), [true, false]);
        assert!(!grows(2, "x", 4.0, "radau-adaptive") && !grows(2, "sqrt(x)", 4.0, "implicit-euler"));
        assert_eq!([0.49, 0.51].map(|h| grows(2, "x", h, "implicit-euler")), [false, true]);
    }
}
