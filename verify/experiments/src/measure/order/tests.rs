use std::f64::consts::SQRT_2;

use super::*;
use proptest::prelude::*;

/// Errors `error(h)` on h = 2^{−k/2}, k < 12, from h = 0.1, with a common floor.
fn samples(floor: f64, error: impl Fn(f64) -> f64) -> Vec<Sample> {
    ladder(1.0, 0.1, SQRT_2, 12).into_iter().map(|h| Sample::new(h, error(h), floor)).collect()
}

fn verdict(samples: &[Sample], order: f64) -> Verdict {
    fit(samples, &Expectation::new(order, 0.1)).verdict
}

fn reasons(fit: &OrderFit) -> Vec<Reason> {
    fit.dropped.iter().map(|(_, reason)| reason.clone()).collect()
}

#[test]
fn a_pure_power_law_is_recovered_to_rounding() {
    let f = fit(&samples(0.0, |h| 0.3 * h.powi(2)), &Expectation::new(2.0, 0.1));
    let line = f.line.unwrap();
    assert_eq!((f.verdict, f.kept.len(), f.dropped.len(), f.local_slopes.len()), (Verdict::Pass, 12, 0, 11));
    assert!((line.slope - 2.0).abs() <= line.rounding && line.rounding < 1e-14, "{line:?}");
    assert!(line.stderr < 1e-14 && line.r_squared > 1.0 - 1e-14, "{line:?}");
}

/// Order 4 of equations in general: a slope nearer to it than to 3 may have errors of both in it.
#[test]
fn a_slope_within_half_an_order_of_the_one_in_general_refutes_nothing() {
    let in_general = |slope: f64| {
        let fit = fit(&samples(0.0, |h| h.powf(slope)), &Expectation::new(4.0, 0.1));
        fit.of_equations_in_general().verdict
    };
    let found = [3.95, 3.8, 3.55, 3.45, 3.0, 2.8].map(in_general);
    use Verdict::{Fail, Inconclusive, Pass};
    assert_eq!(found, [Pass, Inconclusive, Inconclusive, Fail, Fail, Fail]);
    assert_eq!([4.2, 5.0].map(in_general), [Inconclusive; 2]);
    // Where rounding ends the window, less than half an order too much may be of higher order.
    let why = |slope: f64, floor: f64| {
        let fit = fit(&samples(floor, |h| h.powf(slope)), &Expectation::new(4.0, 0.1));
        fit.of_equations_in_general().reason
    };
    let (window, faster) = ("rounding ends the window", "on this equation the errors fall faster");
    for (slope, floor, told) in
        [(4.3, 1e-11, window), (4.3, 0.0, faster), (4.8, 1e-12, faster), (3.7, 1e-11, "next below")]
    {
        assert!(why(slope, floor).contains(told), "{slope}: {}", why(slope, floor));
    }
}

#[test]
fn the_sequence_of_the_samples_does_not_matter() {
    let mut s = samples(0.0, |h| h.powi(3) * (1.0 + h));
    let sorted = fit(&s, &Expectation::new(3.0, 0.1));
    s.reverse();
    s.swap(2, 9);
    assert_eq!(fit(&s, &Expectation::new(3.0, 0.1)), sorted);
}

#[test]
fn divergence_fails_also_where_its_mean_rate_has_the_expected_size() {
    for p in 1..=8 {
        assert_eq!(verdict(&samples(0.0, |h| h.powi(-p)), f64::from(p)), Verdict::Fail);
    }
    // Convergent to h = 0.02, then blowing up at no settled rate.
    let f = fit(&samples(0.0, |h| h.powi(2) + 1e-30 * (0.2 / h).exp2()), &Expectation::new(2.0, 0.1));
    assert!(f.verdict != Verdict::Pass, "{f:?}");
    let f = fit(&samples(0.0, |h| (0.1 / h).powi(2).exp()), &Expectation::new(2.0, 0.1));
    assert!(f.verdict == Verdict::Fail && f.reason.contains("overflows at h = 0.003125"), "{f:?}");
    // Overflow at coarse steps is a stability limit, not divergence.
    let limit = samples(0.0, |h| if h > 0.04 { f64::INFINITY } else { h.powi(2) });
    assert_eq!(verdict(&limit, 2.0), Verdict::Pass);
}

/// Kutta's method of third order in single precision, with the floors of double precision: rounding grows with the number of
/// steps.
#[test]
fn errors_that_grow_from_what_they_fell_to_are_not_called_diverging() {
    let errors = [5.4877e-5, 2.0336e-5, 7.1036e-6, 2.365e-6, 8.1529e-7, 7.0229e-8, 1.3839e-7, 2.7885e-7, 3.3845e-7];
    let s: Vec<_> =
        ladder(2.0, 0.2, SQRT_2, 9).into_iter().zip(errors).map(|(h, e)| Sample::new(h, e, 1e-15)).collect();
    let f = fit(&s, &Expectation::new(3.0, 0.1));
    assert!(f.verdict == Verdict::Inconclusive && f.reason.contains("falls to 7.0e-8"), "{}", f.reason);
    // So does rounding of one size per step, at a settled rate of −1.
    let f = fit(&samples(0.0, |h| h.powi(4) + 1e-9 / h), &Expectation::new(4.0, 0.1));
    assert_eq!(f.verdict, Verdict::Inconclusive, "{}", f.reason);
    // What ends above all that was before diverges.
    assert_eq!(verdict(&samples(0.0, |h| h.powi(2) + 1e-7 / h.powi(4)), 2.0), Verdict::Fail);
}

#[test]
fn three_growing_errors_are_enough_to_fail() {
    let s: Vec<_> = [(0.4, 1.0), (0.2, 4.0), (0.1, 90.0)].map(|(h, e)| Sample::new(h, e, 1e-9)).into();
    assert_eq!(verdict(&s, 2.0), Verdict::Fail);
    // Growth within the floors is not divergence.
    let s: Vec<_> = [(0.4, 1.0), (0.2, 1.01), (0.1, 1.02)].map(|(h, e)| Sample::new(h, e, 0.02)).into();
    assert_eq!(verdict(&s, 2.0), Verdict::Inconclusive);
}

#[test]
fn divergence_that_the_floors_hide_locally_fails_too() {
    // With a floor of e/11 every local slope is −1 ± 1.9, but their fit is −1 ± 0.24.
    let s: Vec<_> = (0..12).map(|k| 1.1_f64.powi(-k)).map(|h| Sample::new(h, 1.0 / h, 1.0 / h / 11.0)).collect();
    let f = fit(&s, &Expectation::new(1.0, 0.6));
    assert!(f.verdict == Verdict::Fail && !f.reason.starts_with("diverges"), "{f:?}");
}

#[test]
fn errors_that_stay_what_they_are_fail_and_are_not_called_growing() {
    let f = fit(&samples(0.0, |h| 3.353e-4 * (1.0 - 0.01 * h)), &Expectation::new(4.0, 0.1));
    assert!(f.verdict == Verdict::Fail && f.reason.contains("stays what it is"), "{f:?}");
}

#[test]
fn a_sixth_order_method_at_four_and_a_half_fails() {
    let s = samples(1e-16, |h| h.powf(4.5));
    assert_eq!(verdict(&s, 6.0), Verdict::Fail);
    // One lucky interval of slope 6.5 does not help it.
    let mut lucky = s;
    for sample in &mut lucky[6..] {
        let m = sample.result.as_mut().unwrap();
        m.error /= 2.0;
    }
    assert_eq!(verdict(&lucky, 6.0), Verdict::Fail);
}

#[test]
fn too_high_an_order_fails_unless_it_is_declared() {
    let s = samples(0.0, |h| h.powi(3));
    assert_eq!(verdict(&s, 2.0), Verdict::Fail);
    let declared = Expectation::new(2.0, 0.1).declared(3.0, "linear problem, Padé(1,2)");
    let f = fit(&s, &declared);
    assert_eq!(f.verdict, Verdict::Pass);
    assert!(f.reason.contains("super-convergence from 2: linear problem"), "{}", f.reason);
    let declared = Expectation::new(2.0, 0.1).declared(1.0, "residual cannot vanish");
    assert_eq!(fit(&s, &declared).verdict, Verdict::Fail);
    assert!(fit(&samples(0.0, |h| h), &declared).reason.contains("reduction from 2"));
}

#[test]
fn points_at_the_floor_are_dropped_and_named() {
    // The floor adds a constant of its own size: the plateau that bends a naive fit.
    let floor = 1e-9;
    let f = fit(&samples(floor, |h| h.powi(4) + floor), &Expectation::new(4.0, 0.1));
    assert_eq!(f.verdict, Verdict::Pass, "{}", f.reason);
    assert!(f.dropped.len() >= 3 && reasons(&f).iter().all(|r| *r == Reason::AtFloor), "{f:?}");
    // The same data with the floor kept silent must not pass.
    assert_eq!(verdict(&samples(0.0, |h| h.powi(4) + floor), 4.0), Verdict::Inconclusive);
}

#[test]
fn a_window_cut_short_by_the_floor_is_inconclusive() {
    let f = fit(&samples(1e-5, |h| h.powi(4)), &Expectation::new(4.0, 0.1));
    assert_eq!((f.verdict, f.line), (Verdict::Inconclusive, None));
    assert!(f.reason.contains("at the floor"), "{}", f.reason);
}

#[test]
fn a_pre_asymptotic_bump_is_dropped() {
    let f = fit(
        &samples(0.0, |h| h.powi(2) * (1.0 + 3.0 * (-((h / 0.08).ln() / 0.3).powi(2)).exp())),
        &Expectation::new(2.0, 0.1),
    );
    assert_eq!(f.verdict, Verdict::Pass, "{}", f.reason);
    assert!(f.dropped.len() >= 3 && reasons(&f).iter().all(|r| *r == Reason::PreAsymptotic), "{f:?}");
    assert!(f.kept.iter().all(|s| s.h < 0.06), "{f:?}");
}

#[test]
fn a_failed_run_closes_the_window_towards_coarse_steps() {
    let mut s = samples(0.0, |h| h.powi(2));
    s[3] = Sample::failed(s[3].h, "Newton diverged");
    let f = fit(&s, &Expectation::new(2.0, 0.1));
    assert_eq!((f.verdict, f.kept.len()), (Verdict::Pass, 8));
    let failed = Reason::StepFailed("Newton diverged".into());
    assert_eq!(reasons(&f), [Reason::BeforeFailure, Reason::BeforeFailure, Reason::BeforeFailure, failed]);
    // A finest run that failed leaves nothing to pass on.
    s[11] = Sample::failed(s[11].h, "branch lost");
    let f = fit(&s, &Expectation::new(2.0, 0.1));
    assert_eq!(f.verdict, Verdict::Inconclusive);
    assert!(f.reason.contains("2 failed, the finest because: branch lost"), "{}", f.reason);
}

#[test]
fn numbers_that_are_no_errors_never_pass() {
    for bad in [f64::NAN, f64::NEG_INFINITY, -1e-9] {
        let mut s = samples(0.0, |h| h.powi(2));
        s[11] = Sample::new(s[11].h, bad, 0.0);
        assert_eq!(verdict(&s, 2.0), Verdict::Inconclusive, "error {bad}");
        s[11] = Sample::new(s[11].h, 1e-6, bad);
        assert_eq!(verdict(&s, 2.0), Verdict::Inconclusive, "floor {bad}");
    }
    for bad in [f64::NAN, 0.0, -0.1, f64::INFINITY] {
        let s = vec![Sample::new(bad, 1e-3, 0.0); 6];
        assert_eq!(verdict(&s, 2.0), Verdict::Inconclusive, "step size {bad}");
    }
    assert_eq!(verdict(&samples(0.0, |_| f64::NAN), 2.0), Verdict::Inconclusive);
    assert_eq!(verdict(&[], 2.0), Verdict::Inconclusive);
    assert_eq!(verdict(&vec![Sample::new(0.1, 1e-3, 0.0); 8], 2.0), Verdict::Inconclusive);
    for bad in [f64::NAN, -1.0, 0.0] {
        let f = fit(&samples(0.0, |h| h.powi(2)), &Expectation::new(2.0, bad));
        assert_eq!(f.verdict, Verdict::Inconclusive, "band {bad}");
    }
    assert_eq!(verdict(&samples(0.0, |h| h.powi(2)), f64::NAN), Verdict::Inconclusive);
}

#[test]
fn an_exact_method_is_inconclusive_and_said_to_be_exact() {
    for error in [0.0, 1e-16] {
        let f = fit(&samples(2e-16, |_| error), &Expectation::new(2.0, 0.1));
        assert_eq!((f.verdict, f.line), (Verdict::Inconclusive, None));
        assert!(f.reason.contains("exact"), "{}", f.reason);
    }
    assert_eq!(verdict(&samples(0.0, |_| 0.0), 2.0), Verdict::Inconclusive);
}

#[test]
fn alternating_noise_is_inconclusive_until_it_is_small() {
    let noisy = |amplitude: f64| {
        let mut s = samples(0.0, |h| h.powi(2));
        for (k, sample) in s.iter_mut().enumerate() {
            let m = sample.result.as_mut().unwrap();
            m.error *= 1.0 + if k % 2 == 0 { amplitude } else { -amplitude };
        }
        s
    };
    assert_eq!(verdict(&noisy(0.3), 2.0), Verdict::Inconclusive);
    assert_eq!(verdict(&noisy(1e-3), 2.0), Verdict::Pass);
    assert_eq!(verdict(&noisy(1e-3), 2.2), Verdict::Fail);
}

#[test]
fn a_noisy_but_settled_fit_must_resolve_the_band() {
    // Local slopes agree only because the floors, a twelfth of each error, excuse their scatter.
    let s: Vec<_> = (0..4).map(|k| 0.1 / f64::from(1 << k)).map(|h| Sample::new(h, h * h, h * h / 12.0)).collect();
    let f = fit(&s, &Expectation::new(2.0, 0.05));
    assert_eq!(f.verdict, Verdict::Inconclusive);
    assert!(f.reason.contains("exceeds the band"), "{}", f.reason);
}

#[test]
fn the_edge_of_the_band_is_inside_it_and_the_band_has_two_sides() {
    for (slope, expected) in
        [(2.1, Verdict::Pass), (1.9, Verdict::Pass), (2.101, Verdict::Fail), (1.899, Verdict::Fail)]
    {
        for c in [1e-10, 1.0, 1e7] {
            assert_eq!(verdict(&samples(0.0, |h| c * h.powf(slope)), 2.0), expected, "slope {slope}, C = {c}");
        }
    }
}

#[test]
fn a_mixture_of_orders_is_judged_by_its_fine_end() {
    // First order takes over at h ≈ 1e-3: second on the whole, but not where it counts.
    let mixed = |c: f64| samples(0.0, move |h| h.powi(2) + c * h);
    assert_eq!(verdict(&mixed(10.0), 2.0), Verdict::Fail);
    assert_eq!(verdict(&mixed(10.0), 1.0), Verdict::Pass);
    assert_eq!(verdict(&mixed(0.01), 2.0), Verdict::Inconclusive);
    assert_eq!(verdict(&mixed(1e-5), 2.0), Verdict::Pass);
}

#[test]
fn drifting_slopes_are_inconclusive_not_failed() {
    // Still on its way to 6 from 4: no window, hence no statement.
    let f = fit(&samples(0.0, |h| h.powi(6) / (1.0 + (h / 0.01).powi(2))), &Expectation::new(6.0, 0.1));
    assert_eq!(f.verdict, Verdict::Inconclusive);
    let [.., one, two, three] = f.local_slopes[..] else { panic!("{f:?}") };
    let told = [one, two, three].map(|local| decimals(local.slope, 2)).join(", ");
    assert!(f.reason.contains(&format!("have not settled to within 0.05: {told} at the fine end")), "{}", f.reason);
    assert!(!f.still_approaches() && f.wants_finer());
    assert_eq!(f.kept.len(), MIN_POINTS);
}

#[test]
fn slopes_that_the_floor_cuts_off_on_their_way_to_the_order_do_not_refute_it() {
    // Local slopes 4.20, 4.15, 4.11, the last as uncertain as the floor makes it.
    let s = ladder(2.0, 0.1, SQRT_2, 8);
    let s: Vec<_> = s.into_iter().map(|h| Sample::new(h, h.powi(4) * (1.0 + 6.0 * h), 4e-9)).collect();
    let f = fit(&s, &Expectation::new(4.0, 0.1));
    assert!(f.line.is_some_and(|line| line.slope > 4.1), "{f:?}");
    assert!(f.verdict == Verdict::Inconclusive && f.reason.contains("still approach 4"), "{f:?}");
    assert!(f.still_approaches());
    // Neither do they confirm another, and slopes that leave the order refute it.
    assert_eq!(verdict(&s, 4.4), Verdict::Fail);
    let away: Vec<_> =
        ladder(2.0, 0.1, SQRT_2, 8).into_iter().map(|h| Sample::new(h, h.powf(3.85) / (1.0 + h), 4e-9)).collect();
    assert_eq!(verdict(&away, 4.0), Verdict::Fail);
}

/// Errors of Dormand and Prince's method on the logistic equation: of all steps whose slopes agree to within their floors the mean slope is
/// 5.11, of the finest four 5.08.
#[test]
fn slopes_that_come_into_the_band_before_the_floor_confirm_the_order() {
    let errors = [
        (0.2, 8.5464e-9, 1.8e-15),
        (1.0 / 7.0, 1.4653e-9, 2.2e-15),
        (0.1, 2.3009e-10, 2.8e-15),
        (1.0 / 14.0, 4.0719e-11, 3.6e-15),
        (0.05, 6.5787e-12, 4.8e-15),
        (2.0 / 57.0, 1.0876e-12, 6.5e-15),
        (0.025, 1.9579e-13, 8.8e-15),
    ];
    let s: Vec<_> = errors.iter().map(|&(h, error, floor)| Sample::new(h, error, floor)).collect();
    let f = fit(&s, &Expectation::new(5.0, 0.1));
    assert_eq!((f.verdict, f.kept.len()), (Verdict::Pass, MIN_POINTS), "{f:?}");
    assert!(f.line.is_some_and(|line| (5.05..5.1).contains(&line.slope)), "{f:?}");
    // A floor that may hide where the finest slopes lead leaves it open.
    let less = |&(h, error, floor): &(f64, f64, f64)| Sample::new(h, error, 4.0 * floor);
    assert_eq!(verdict(&errors.iter().map(less).collect::<Vec<_>>(), 5.0), Verdict::Inconclusive);
}

#[test]
fn slopes_that_are_outside_the_band_where_the_floor_cuts_them_off_do_not_refute_the_order_they_tend_to() {
    // The local slopes end at 3.90, 4.14 and 4.21, those of a method of order 4 with a large next term.
    for (c, a, floor) in [(10.0, -0.9, 2.8e-5), (10.0, 1.5, 6e-5), (10.0, 2.5, 4e-5)] {
        let s: Vec<_> = ladder(2.0, 0.5, SQRT_2, 12)
            .into_iter()
            .map(|h| Sample::new(h, c * h.powi(4) * (1.0 + a * h), floor))
            .collect();
        let f = fit(&s, &Expectation::new(4.0, 0.1));
        let finest = f.local_slopes.last().unwrap().slope;
        assert!((finest - 4.0).abs() > 0.1, "{f:?}");
        assert_eq!(f.verdict, Verdict::Inconclusive, "{f:?}");
        assert!(f.reason.contains("still approach 4 where errors reach their floor"), "{f:?}");
    }
    // Slopes that come nearer and settle away from the order refute it, above it and below.
    for (settles, a) in [(2.0, 1.0), (3.0, -0.5), (3.8, -0.3), (5.0, 0.5), (4.25, 0.3)] {
        let s = samples(1e-13, |h| h.powf(settles) * (1.0 + a * h));
        let f = fit(&s, &Expectation::new(4.0, 0.1));
        assert_eq!(f.verdict, Verdict::Fail, "{settles}: {f:?}");
    }
}

/// Errors of Kutta's method on van der Pol's equation, of second order there, and of one of fifth on the logistic one, as six
/// and ten decimals leave them: the slopes stand still on their way.
#[test]
fn slopes_that_stand_still_where_printed_digits_end_the_ladder_do_not_refute_the_order() {
    type Errors = [(f64, f64)];
    let fourth: &Errors = &[(0.2, 4.6557e-4), (1.0 / 7.0, 1.0857e-4), (0.1, 2.3568e-5), (1.0 / 14.0, 5.568e-6)];
    let second: &Errors =
        &[(0.05, 1.506e-4), (2.0 / 57.0, 6.9597e-5), (0.025, 3.4597e-5), (2.0 / 113.0, 1.6597e-5), (0.0125, 8.5967e-6)];
    for (errors, order) in [(fourth, 4.0), (second, 2.0)] {
        let s: Vec<_> = errors.iter().map(|&(h, error)| Sample::new(h, error, 5e-7)).collect();
        let f = fit(&s, &Expectation::new(order, 0.1));
        assert!(f.verdict == Verdict::Inconclusive && f.reason.contains("no worse"), "{}", f.reason);
        // Orders far from the slopes are another matter.
        for wrong in [order + 2.0, order - 1.0] {
            assert_eq!(verdict(&s, wrong), Verdict::Fail, "{wrong}");
        }
    }
}

#[test]
fn the_ladder_divides_the_horizon_and_decreases() {
    let h = ladder(10.0, 0.25, SQRT_2, 9);
    assert_eq!((h[0], h[2], h[8]), (0.25, 0.125, 0.25 / 16.0));
    for (horizon, coarsest) in [(10.0, 0.3), (1.0, 3.0), (2.0, 2.0)] {
        let h = ladder(horizon, coarsest, 1.2, 9);
        assert!(h.windows(2).all(|w| w[1] < w[0]), "{h:?}");
        assert!(h.iter().all(|h| ((horizon / h).round() - horizon / h).abs() <= 1e-13), "{h:?}");
    }
    for (horizon, coarsest) in [
        (0.0, 0.1),
        (1.0, 0.0),
        (f64::NAN, 0.1),
        (1.0, f64::NAN),
        (1.0, -0.1),
        (f64::INFINITY, 1.0),
        (1.0, f64::INFINITY),
    ] {
        assert!(ladder(horizon, coarsest, 2.0, 3).is_empty(), "{horizon}, {coarsest}");
    }
    assert!(ladder(1.0, 1e-320, 2.0, 3).is_empty(), "more steps than there are numbers");
}

proptest! {
    /// C hᵖ(1 + a h), each error off by up to its floor: p is recovered, and p ± 0.5 is refused.
    #[test]
    fn synthetic_orders_are_recovered(
        p in 1_i32..=8,
        log_c in -2.0_f64..2.0,
        a in -0.5_f64..0.5,
        noise in proptest::collection::vec(-1.0_f64..1.0, 12),
    ) {
        let c = 10_f64.powf(log_c);
        let floor = c * 1e-16;
        let mut s = samples(floor, |h| c * h.powi(p) * (1.0 + a * h));
        for (sample, noise) in s.iter_mut().zip(&noise) {
            let m = sample.result.as_mut().unwrap();
            m.error = (m.error + noise * floor).max(0.0);
        }
        let order = f64::from(p);
        let f = fit(&s, &Expectation::new(order, 0.1));
        prop_assert_eq!(f.verdict, Verdict::Pass, "{:?}", f);
        prop_assert_eq!(verdict(&s, order + 0.5), Verdict::Fail);
        prop_assert_eq!(verdict(&s, order - 0.5), Verdict::Fail);
    }

    /// Whatever the numbers: no panic, no point lost, and never a pass with NaN in it or outside the band.
    #[test]
    fn any_input_gets_an_honest_verdict(
        values in proptest::collection::vec((any::<f64>(), any::<f64>(), any::<f64>()), 0..12),
        order in any::<f64>(),
        band in any::<f64>(),
    ) {
        let s: Vec<_> = values.iter().map(|&(h, e, floor)| Sample::new(h, e, floor)).collect();
        let f = fit(&s, &Expectation::new(order, band));
        prop_assert_eq!(f.kept.len() + f.dropped.len(), s.len());
        prop_assert!(!f.reason.is_empty());
        if f.verdict == Verdict::Pass {
            let line = f.line.unwrap();
            prop_assert!((line.slope - order).abs() <= band + line.rounding && 2.0 * line.stderr <= band);
        }
    }
}

#[test]
fn slopes_are_written_with_a_minus_sign_where_they_have_one() {
    for (slope, text) in
        [(-0.0004, "0.000"), (-0.0, "0.000"), (-0.0006, "−0.001"), (3.9996, "4.000"), (-12.5, "−12.500")]
    {
        assert_eq!(decimals(slope, 3), text);
    }
    assert_eq!(decimals(f64::NEG_INFINITY, 3), "−inf");
    assert_eq!(decimals(f64::NAN, 3), "NaN");
}

#[test]
fn an_order_that_nothing_is_expected_of_is_said_to_stand_still_where_it_does() {
    let f = fit_freely(&samples(0.0, |h| 3.353e-4 * (1.0 - 0.01 * h)), 0.1);
    assert!(f.verdict == Verdict::Measured && f.reason.ends_with(STANDSTILL), "{f:?}");
    let f = fit_freely(&samples(0.0, |h| h * h), 0.1);
    assert!(f.verdict == Verdict::Measured && !f.reason.contains("stays what it is"), "{f:?}");
}

/// Slopes of tanh(3√h) rise to a half and have not come there: what is left is in the error, or too much.
#[test]
fn a_drift_of_the_slopes_is_in_the_error_of_a_measured_order() {
    let halves = |from: f64, count: i32, error: &dyn Fn(f64) -> f64| -> Vec<Sample> {
        (0..count).map(|k| from * 0.5_f64.powi(k)).map(|h| Sample::new(h, error(h), 0.0)).collect()
    };
    let slow = |h: f64| (3.0 * h.sqrt()).tanh();
    let f = fit_freely(&samples(0.0, |h| slow(6.0 * h)), 0.1);
    assert!(f.verdict == Verdict::Inconclusive && f.reason.contains("the local slopes drift, "), "{f:?}");
    assert!(f.line.is_some_and(|line| 2.0 * line.stderr > 0.1), "{f:?}");
    assert!(f.wants_finer(), "finer steps have less of it");
    assert!(!f.left_open("a reason".into()).wants_finer());
    for (from, count, band) in [(1.19, 8, 0.25), (0.1, 6, 0.25), (0.1, 6, 0.125), (0.02, 5, 0.125)] {
        let f = fit_freely(&halves(from, count, &slow), band);
        let line = f.line.expect("a fit");
        // As far as terms of second order in h let it: these slopes have a quarter of the first there at most.
        assert!(f.verdict == Verdict::Measured && (line.slope - 0.5).abs() <= 1.25 * line.stderr, "{f:?}");
    }
    // Slopes that go up and down drift nowhere.
    let f = fit_freely(&halves(1.0, 7, &|h| h * h * (1.0 + 0.01 * (40.0 * h.ln()).sin())), 0.125);
    assert!(f.verdict == Verdict::Measured && f.line.expect("a fit").stderr < 0.01, "{f:?}");
}

/// Slopes that come nearer to 5 and into its band, in the finest four points and in no larger number of them.
#[test]
fn slopes_arrive_in_the_band_at_the_fine_end_whatever_the_coarser_ones_outside_of_the_window() {
    let coarser = [6.0, 5.0];
    let arrives = |slopes: [f64; 7]| {
        let all: Vec<f64> = coarser.into_iter().chain(slopes).collect();
        let mut points = vec![LogPoint { x: 0.0, y: 0.0, u: 0.0 }];
        for slope in &all {
            let LogPoint { x, y, .. } = points[points.len() - 1];
            points.push(LogPoint { x: x - 1.0, y: y - slope, u: 0.0 });
        }
        let local = |(pair, slope): (&[LogPoint], &f64)| {
            let [coarse, fine] = [pair[0].x.exp(), pair[1].x.exp()];
            LocalSlope { coarse, fine, slope: *slope, uncertainty: 0.0 }
        };
        let local: Vec<_> = points.windows(2).zip(&all).map(local).collect();
        arrives(&points[coarser.len()..], &local, &Expectation::new(5.0, 0.1))
    };
    assert!(arrives([5.3, 5.28, 5.26, 5.24, 5.1, 5.06, 5.03]));
    assert!(!arrives([5.3, 5.28, 5.26, 5.24, 5.22, 5.2, 5.18]), "they are outside");
    assert!(!arrives([5.09, 5.08, 5.07, 5.06, 5.05, 5.04, 5.03]), "all are inside");
    assert!(!arrives([5.3, 5.28, 5.26, 5.24, 5.1, 5.06, 5.07]), "they come no nearer");
}

/// Of slopes 2 + a h what is lacking halves with the step: from 1.95 to 2, and half as much again.
#[test]
fn slopes_drift_to_where_they_go_if_all_do_by_more_than_their_uncertainty() {
    let drift = |slopes: [f64; 3], uncertainties: [f64; 3]| {
        let local = |(k, (slope, uncertainty)): (i32, (f64, f64))| {
            let coarse = 0.5_f64.powi(k);
            LocalSlope { coarse, fine: 0.5 * coarse, slope, uncertainty }
        };
        drifted(&(0..).zip(slopes.into_iter().zip(uncertainties)).map(local).collect::<Vec<_>>(), slopes[1])
    };
    let (rising, falling) = ([1.8, 1.9, 1.95], [2.2, 2.1, 2.05]);
    for slopes in [rising, falling] {
        for (uncertainties, expected) in [
            ([0.0; 3], 0.125),
            ([0.02; 3], 0.125),
            ([0.0, 0.03, 0.01], 0.125),
            ([0.03; 3], 0.0),
            ([0.0, 0.0, 0.06], 0.0),
        ] {
            let found = drift(slopes, uncertainties);
            assert!((found - expected).abs() < 1e-12, "{slopes:?}, {uncertainties:?}: {found}");
        }
    }
    assert_eq!([drift([1.8, 1.9, 1.85], [0.0; 3]), drift([2.2, 2.1, 2.15], [0.0; 3])], [0.0; 2]);
}

/// Whatever the floors, a verdict needs twice the standard error within the band, and gets it there.
#[test]
fn a_fit_is_resolved_where_twice_its_standard_error_is_in_the_band() {
    let mut between = 0;
    for k in 1..200 {
        let part = f64::from(k) / 400.0;
        let s: Vec<_> = (0..4).map(|k| 0.1 / f64::from(1 << k)).map(|h| Sample::new(h, h * h, part * h * h)).collect();
        let f = fit(&s, &Expectation::new(2.0, 0.1));
        let Some(line) = f.line.filter(|_| f.kept.len() == 4) else { continue };
        assert_eq!(f.verdict == Verdict::Pass, 2.0 * line.stderr <= 0.1, "{part}: {}", f.reason);
        between += usize::from(line.stderr > 0.05 && line.stderr < 0.1);
    }
    assert!(between > 3, "{between}");
}
