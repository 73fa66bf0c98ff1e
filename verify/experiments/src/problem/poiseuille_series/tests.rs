use super::*;
use crate::measure::order::{self, Expectation, Sample, Verdict};
use approx::assert_relative_eq;
use proptest::prelude::*;

/// u ≤ 1 for γ = 2, and either expansion adds up terms no larger than 1, a dozen of them above roundoff: 12 ulps.
const ROUNDOFF: f64 = 12.0 * f64::EPSILON;

fn u(y: f64, t: f64) -> f64 {
    velocity(2.0, y, t).unwrap()
}

#[test]
fn sixty_digit_values_are_reproduced_absolutely_and_relatively() {
    let table = tabulated().unwrap();
    assert_eq!(table.len(), 55);
    for row in table {
        let error = (u(row.y, row.t) - row.u).abs();
        // The modes lose a factor of 1/t < 36/2 to the steady part just above the crossover: 1e-14 relative.
        assert!(error <= ROUNDOFF && error <= 1e-14 * row.u, "{row:?}: {error:e}");
    }
}

#[test]
fn the_walls_are_at_rest_and_the_flow_starts_from_rest() {
    for t in [0.0, 1e-300, 1e-8, 1e-3, 0.0277, 0.0278, 0.3, 10.0, f64::INFINITY] {
        assert_eq!((u(1.0, t), u(-1.0, t)), (0.0, 0.0), "t = {t}");
    }
    for y in [-0.9, 0.0, 0.5] {
        assert_eq!(u(y, 0.0), 0.0);
        assert_eq!(u(y, 1e-300), 2e-300);
    }
}

#[test]
fn the_flow_decays_to_the_steady_profile_at_the_slowest_rate() {
    for y in [-1.0, -0.4, 0.0, 0.7] {
        assert_relative_eq!(steady(3.0, y).unwrap(), 1.5 * (1.0 - y * y), max_relative = 4.0 * f64::EPSILON);
    }
    // What is left at t = 2 is the first mode, 4/μ₀³ e^{−2μ₀²} = 0.007; the second is e^{−39} of it.
    let rate = ((1.0 - u(0.0, 2.0)) / (1.0 - u(0.0, 3.0))).ln();
    assert_relative_eq!(rate, SLOWEST_DECAY_RATE, epsilon = 4.0 * f64::EPSILON / (1.0 - u(0.0, 3.0)));
}

#[test]
fn points_outside_of_the_channel_are_refused() {
    let nan = f64::NAN;
    for (gamma, y, t) in
        [(2.0, 1.1, 1.0), (2.0, -1.1, 1.0), (2.0, 0.0, -1e-9), (nan, 0.0, 1.0), (2.0, nan, 1.0), (2.0, 0.0, nan)]
    {
        assert!(velocity(gamma, y, t).is_err(), "{gamma} {y} {t}");
    }
    let error = velocity(f64::INFINITY, 0.5, 1.0).unwrap_err();
    assert_eq!(error, DomainError { gamma: f64::INFINITY, y: 0.5, t: 1.0 });
}

#[test]
fn the_equation_is_satisfied_to_second_order_in_the_difference_step() {
    for (y, t) in [(0.3, 0.1), (-0.6, 1.0 / 36.0), (0.8, 0.5)] {
        let samples: Vec<_> = order::ladder(1.0, 0.01, std::f64::consts::SQRT_2, 10)
            .into_iter()
            .map(|h| {
                let u_t = (u(y, t + h) - u(y, t - h)) / (2.0 * h);
                let u_yy = (u(y + h, t) - 2.0 * u(y, t) + u(y - h, t)) / (h * h);
                Sample::new(h, (u_t - 2.0 - u_yy).abs(), 4.0 * f64::EPSILON / (h * h))
            })
            .collect();
        let fit = order::fit(&samples, &Expectation::new(2.0, 0.1));
        assert_eq!(fit.verdict, Verdict::Pass, "y = {y}, t = {t}: {}", fit.reason);
    }
}

proptest! {
    #[test]
    fn the_two_expansions_agree(y in -1.0_f64..=1.0, log_t in -2.5_f64..=1.0) {
        let (d, t) = (1.0 - y.abs(), 10_f64.powf(log_t));
        // At t = 10 the images cancel from 10 down to ½; there they, not the modes, set the difference.
        let tolerance = ROUNDOFF * t.max(1.0);
        prop_assert!((2.0 * modes(d, t) - 2.0 * images(d, t)).abs() <= tolerance);
    }

    #[test]
    fn the_flow_is_even_and_speeds_up(y in -1.0_f64..=1.0, log_t in -8.0_f64..=1.0, factor in 1.0_f64..=2.0) {
        let t = 10_f64.powf(log_t);
        prop_assert_eq!(u(y, t), u(-y, t));
        prop_assert!(u(y, factor * t) >= u(y, t) * (1.0 - 1e-14));
        prop_assert!(u(y, t) <= (2.0 * t).min(steady(2.0, y).unwrap()) * (1.0 + 1e-14));
    }
}
