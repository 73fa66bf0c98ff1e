//! The published examples to their printed digits, and what must not pass.

use std::f64::consts::SQRT_2;

use super::*;
use crate::measure::norm::larger;
use crate::measure::order::Verdict;
use proptest::prelude::*;

fn quantity(points: &[(f64, f64)], resolution: f64) -> Quantity {
    let grids = points.iter().map(|(h, value)| Grid { h: *h, value: Some(*value) }).collect();
    Quantity { name: "φ".into(), grids, resolution }
}

fn expecting(order: f64) -> Question {
    Question { expected: Some(order), ..Question::default() }
}

/// `measured` rounds to `printed`, whose last digit has the given unit.
fn prints_as(measured: f64, printed: f64, unit: f64) {
    assert!((measured - printed).abs() <= 0.500_001 * unit, "{measured} does not round to {printed}");
}

/// J. W. Slater, Examining spatial (grid) convergence, NPARC Alliance CFD Verification and Validation Web Site: pressure
/// recovery of a diffuser on three grids.
#[test]
fn the_pressure_recovery_of_the_nparc_tutorial() {
    let points = [(1.0, 0.97050), (2.0, 0.96854), (4.0, 0.96178)];
    let triplet = Triplet::new(points, 0.5e-5).expect("monotone");
    prints_as(triplet.order, 1.786170, 1e-6);
    prints_as(triplet.limit, 0.97130, 1e-5);
    prints_as(100.0 * triplet.gci, 0.103083, 1e-6);
    prints_as(100.0 * triplet.gci_coarse, 0.356249, 1e-6);
    assert_eq!(quantity(&points, 0.5e-5).judge(&expecting(2.0)).verdict, Verdict::Pass);
    // One unit of the last digit in each difference can move the order by 0.0095 at most.
    assert!((0.005..0.01).contains(&triplet.uncertainty), "{}", triplet.uncertainty);
}

/// Celik et al., Table 1: three quantities behind a backward-facing step, 18000 cells on the finest grid.
#[test]
fn the_backward_facing_step_of_celik_et_al() {
    struct Case {
        cells: [f64; 3],
        values: [f64; 3],
        order: f64,
        limit: (f64, f64),
        percent: [Option<f64>; 3],
        oscillates: bool,
    }
    let cases = [
        Case {
            cells: [18000.0, 8000.0, 4500.0],
            values: [6.063, 5.972, 5.863],
            order: 1.53,
            limit: (6.1685, 1e-4),
            percent: [Some(1.5), Some(1.7), Some(2.2)],
            oscillates: false,
        },
        Case {
            cells: [18000.0, 4500.0, 980.0],
            values: [10.7880, 10.7250, 10.6050],
            order: 0.75,
            limit: (10.8801, 1e-4),
            percent: [Some(0.6), None, Some(1.1)],
            oscillates: false,
        },
        Case {
            cells: [18000.0, 4500.0, 980.0],
            values: [6.0042, 5.9624, 6.0909],
            order: 1.51,
            limit: (6.0269, 1e-4),
            percent: [Some(0.7), Some(0.4), Some(0.5)],
            oscillates: true,
        },
    ];
    for case in cases {
        let point = |i: usize| (case.cells[i].powf(-0.5), case.values[i]);
        let points = [0, 1, 2].map(point);
        let triplet = Triplet::new(points, 0.0).expect("an order");
        prints_as(triplet.order, case.order, 0.01);
        prints_as(triplet.limit, case.limit.0, case.limit.1);
        let errors = [triplet.approximate_error, triplet.extrapolated_error, triplet.gci];
        for (error, printed) in errors.into_iter().zip(case.percent) {
            printed.iter().for_each(|printed| prints_as(100.0 * error, *printed, 0.1));
        }
        assert_eq!(triplet.oscillates, case.oscillates);
        if case.oscillates {
            let judgement = quantity(&points, 0.0).judge(&expecting(1.5));
            assert_eq!(judgement.convergence, Convergence::Oscillatory);
            assert_eq!(judgement.verdict, Verdict::Inconclusive);
        }
    }
}

/// Examples of the procedure of Eça and Hoekstra.
#[test]
fn the_least_squares_examples() {
    let cells = [259_350.0_f64, 115_200.0, 48_600.0, 14_400.0];
    let values = [0.23507, 0.23490, 0.23459, 0.23374];
    let points: Vec<_> = cells.iter().zip(values).map(|(n, value)| (n.powf(-1.0 / 3.0), value)).collect();
    let fit = LeastSquares::fit(&points).expect("a fit");
    assert_eq!(fit.form, least_squares::Form::Power);
    prints_as(fit.power.expect("monotone").order, 1.8957, 1e-4);
    prints_as(fit.limit, 0.235325, 1e-6);
    prints_as(fit.uncertainty, 3.200e-4, 1e-7);

    let points = [(1.0 / 80.0, 1.52290), (1.0 / 60.0, 1.52382), (1.0 / 40.0, 1.52659)];
    let fit = LeastSquares::fit(&points).expect("a fit");
    assert_eq!(fit.form, least_squares::Form::Second);
    prints_as(fit.limit, 1.52165, 1e-5);
    prints_as(fit.uncertainty, 3.747e-3, 1e-6);
}

#[test]
fn the_unit_of_the_values_does_not_matter_while_they_have_squares() {
    let of = |unit: f64| {
        let law = [0.1, 0.07, 0.05, 0.03, 0.02].map(|h: f64| (h, (1.0 + h * h) * unit));
        quantity(&law, 0.0).judge(&expecting(2.0))
    };
    for unit in [1e-139, 1e-100, 1.0, 1e100, 1e139] {
        assert_eq!(of(unit).verdict, Verdict::Pass, "{unit:e}: {}", of(unit).reason);
    }
    for unit in [1e-200, 1e-160, 1e160, 1e300] {
        let judgement = of(unit);
        assert!(judgement.verdict == Verdict::Inconclusive && judgement.reason.contains("other units"), "{unit:e}");
    }
}

#[test]
fn settled_orders_pass_and_wrong_ones_fail() {
    let law = |p: f64| [0.1, 0.07, 0.05, 0.03, 0.02].map(|h: f64| (h, 2.0 - 0.7 * h.powf(p)));
    for p in [0.5, 1.0, 1.5, 2.0, 4.0] {
        let data = quantity(&law(p), 0.0);
        let judgement = data.judge(&expecting(p));
        assert_eq!(judgement.verdict, Verdict::Pass, "{}", judgement.reason);
        assert!((judgement.order.expect("an order") - p).abs() < 1e-5);
        assert!((judgement.extrapolated.expect("a limit") - 2.0).abs() < 1e-7);
        assert_eq!(data.judge(&expecting(p + 0.5)).verdict, Verdict::Fail);
        assert_eq!(data.judge(&Question::default()).verdict, Verdict::Measured);
        assert_eq!(data.judge(&Question { exact: Some(2.0), ..Question::default() }).verdict, Verdict::Measured);
        let exact = Question { exact: Some(2.0), ..expecting(p) };
        assert_eq!(data.judge(&exact).verdict, Verdict::Pass);
        assert_eq!(data.judge(&Question { expected: Some(p + 0.5), ..exact }).verdict, Verdict::Fail);
        // A bend of the order of the leading term on the coarsest grid alone leaves the finest triplets as they are.
        let mut bent = law(p);
        bent[0].1 += 0.3;
        assert_eq!(quantity(&bent, 0.0).judge(&expecting(p)).verdict, Verdict::Pass);
    }
}

#[test]
fn several_quantities_have_the_worst_verdict_of_them() {
    let judged = |verdict: Verdict| {
        let judgement = quantity(&[(1.0, 1.01), (2.0, 1.02), (4.0, 1.04)], 0.0).judge(&expecting(2.0));
        Judgement { verdict, ..judgement }
    };
    let all = [Verdict::Fail, Verdict::Inconclusive, Verdict::Measured, Verdict::Pass];
    for (i, one) in all.iter().enumerate() {
        for (k, other) in all.iter().enumerate() {
            assert_eq!(overall(&[judged(*one), judged(*other)]), all[i.min(k)]);
        }
    }
    assert_eq!(overall(&[]), Verdict::Inconclusive);
}

/// What no data may do: pass by accident.
#[test]
fn nothing_passes_that_decides_nothing() {
    let verdict = |points: &[(f64, f64)], resolution: f64, question: Question| {
        let judgement = quantity(points, resolution).judge(&question);
        assert_ne!(judgement.verdict, Verdict::Pass, "{points:?}: {}", judgement.reason);
        assert!(!judgement.reason.is_empty());
        judgement
    };
    let second = expecting(2.0);
    verdict(&[], 0.0, second);
    verdict(&[(1.0, 1.0)], 0.0, second);
    verdict(&[(1.0, 1.0), (2.0, 1.3)], 0.0, second);
    verdict(&[(1.0, 1.0), (2.0, 1.3)], 0.0, Question { exact: Some(0.9), ..second });
    verdict(&[(1.0, 1.0), (1.0, 1.1), (2.0, 1.4)], 0.0, second);
    verdict(&[(1.0, f64::NAN), (2.0, 1.1), (4.0, 1.5)], 0.0, second);
    let identical = verdict(&[(1.0, 1.0), (2.0, 1.0), (4.0, 1.0)], 0.0, second);
    assert_eq!(identical.convergence, Convergence::Unresolved);
    // The finer pair agrees to rounding, the coarser does not.
    verdict(&[(1.0, 1.0), (2.0, 1.0 + 2e-16), (4.0, 1.5)], 0.0, second);
    // Four digits hide the order.
    let hidden = verdict(&[(1.0, 1.0001), (2.0, 1.0004), (4.0, 1.0016)], 5e-5, second);
    assert_eq!(hidden.convergence, Convergence::Unresolved);
    // Three grids of a wrong order, of a diverging and of an oscillating sequence.
    verdict(&[(1.0, 1.01), (2.0, 1.02), (4.0, 1.04)], 0.0, second);
    assert_eq!(verdict(&[(1.0, 1.4), (2.0, 1.1), (4.0, 1.0)], 0.0, second).convergence, Convergence::Divergent);
    let growing = verdict(&[(1.0, 0.6), (2.0, 1.1), (4.0, 1.0)], 0.0, second);
    assert_eq!(growing.convergence, Convergence::OscillatoryDivergent);
    // Growth on every triplet of five grids is a failure.
    let grows: Vec<_> = [1.0, 2.0, 4.0, 8.0, 16.0].map(|h: f64| (h, 1.0 / h)).to_vec();
    assert_eq!(verdict(&grows, 0.0, second).verdict, Verdict::Fail);
    // No error at all is no order.
    verdict(&[(1.0, 2.0), (2.0, 2.0), (4.0, 2.0), (8.0, 2.0)], 0.0, Question { exact: Some(2.0), ..second });
    // Errors of roundoff are told from none.
    let exact = Question { exact: Some(2.0), ..second };
    let none = [1.0, 2.0, 4.0, 8.0].map(|h| (h, 2.0));
    assert!(verdict(&none, 0.0, exact).reason.contains("every value is the exact one"));
    let roundoff = [1.0, 2.0, 4.0, 8.0].map(|h| (h, 2.0 + 4e-16 * (h - 1.0)));
    assert!(verdict(&roundoff, 0.0, exact).reason.contains("which is not exactness"));
    let printed = [1.0, 2.0, 4.0, 8.0].map(|h| (h, 2.0 + 1e-5 * (h - 1.0_f64).min(1.0)));
    assert!(verdict(&printed, 5e-6, exact).reason.contains("above 5.0e-5"));
    assert_eq!(overall([]), Verdict::Inconclusive);
}

/// On grids of very unequal ratios the equation of alternating differences can have two solutions, which is said.
#[test]
fn several_formal_orders_are_named() {
    let points = [(1.0, 0.0), (1.1, 1.0), (3.3, -4.0)];
    assert!(matches!(Triplet::new(points, 0.0), Err(TripletError::SeveralOrders { low, high }) if low < high));
    assert_eq!(quantity(&points, 0.0).judge(&expecting(1.0)).verdict, Verdict::Inconclusive);
}

/// The equation of alternating differences is solved where it holds, to rounding.
#[test]
fn orders_solve_their_equation() {
    proptest!(|(p in 0.3..6.0_f64, r21 in 1.1..3.0_f64, r32 in 1.1..3.0_f64, f0 in -5.0..5.0_f64, c in 0.1..2.0_f64)| {
        let hs = [1.0, r21, r21 * r32];
        let points = hs.map(|h: f64| (h, f0 + c * h.powf(p)));
        let triplet = Triplet::new(points, 0.0).expect("a power law");
        // The differences carry rounding of the values, and the equation divides by ½ ln(r₂₁ r₃₂).
        let size = points.iter().map(|p| p.1.abs()).fold(1.0, larger);
        let fine = (points[1].1 - points[0].1).abs();
        prop_assert!((triplet.order - p).abs() <= 20.0 * f64::EPSILON * size / fine / (r21 * r32).ln() + 1e-12);
        prop_assert!((Triplet::asymptotic_ratio(points, p) - 1.0).abs() < 1e-6 * size / fine);
    });
}

/// Differences of a few units of the last bit follow a power law as well as any, and are roundoff.
#[test]
fn a_power_law_in_the_last_bits_is_not_resolved() {
    let ulps = |n: f64| 1.0 + n * f64::EPSILON;
    let judgement = quantity(&[(1.0, 1.0), (2.0, ulps(2.0)), (4.0, ulps(10.0))], 0.0).judge(&expecting(2.0));
    assert_eq!((judgement.convergence, judgement.verdict), (Convergence::Unresolved, Verdict::Inconclusive));
}

/// 0.1 + 0.2 and 0.3 are one spacing.
#[test]
fn spacings_that_differ_by_rounding_are_equal() {
    let points = [(0.3, 1.0), (0.1 + 0.2, 1.1), (0.6, 1.4), (1.2, 2.6)];
    let judgement = quantity(&points, 0.0).judge(&expecting(2.0));
    assert!(judgement.reason.contains("the same spacing"), "{}", judgement.reason);
}

/// Orders 1.3 and 2.7 of two triplets, 2 between them.
#[test]
fn orders_that_differ_by_more_than_the_band_have_not_settled() {
    let points = [(1.0, 0.0), (2.0, 1.0), (4.0, 1.0 + 2_f64.powf(1.3)), (8.0, 1.0 + 2_f64.powf(1.3) + 16.0)];
    let judgement = quantity(&points, 0.0).judge(&expecting(2.0));
    assert_eq!(judgement.verdict, Verdict::Inconclusive);
    assert!(judgement.reason.contains("have not settled"), "{}", judgement.reason);
}

/// On a power law each index is 1.25 times the true error of its own grid, whatever the ratios.
#[test]
fn indices_on_unequal_ratios_are_those_of_their_own_grids() {
    let points = [1.0, 1.5, 4.5].map(|h: f64| (h, 3.0 + 0.2 * h.powi(2)));
    let triplet = Triplet::new(points, 0.0).expect("a power law");
    for (gci, (_, value)) in [triplet.gci, triplet.gci_coarse].into_iter().zip(points) {
        prints_as(gci, 1.25 * (value - 3.0) / value, 1e-9);
    }
}

/// Digits that let the order move by more than the band decide nothing, on three grids or on four.
#[test]
fn an_order_that_the_digits_leave_open_decides_nothing() {
    let points = [1.0, 1.1, 1.21, 1.331].map(|h: f64| (h, 5.0 + 6.0 * h.powi(2)));
    for n in [3, 4] {
        let judgement = quantity(&points[..n], 0.1).judge(&expecting(2.0));
        assert_eq!(judgement.verdict, Verdict::Inconclusive, "{}", judgement.reason);
        assert!(judgement.reason.contains("more than the band"), "{}", judgement.reason);
    }
}

/// Errors of a few units of the last digit given are at their floor, though they follow a power law.
#[test]
fn errors_against_an_exact_value_count_from_ten_times_the_resolution_on() {
    let points = [1.0, 2.0, 4.0, 8.0].map(|h: f64| (h, 2.0 + 1e-3 * h.powi(2)));
    let exact = Question { exact: Some(2.0), ..expecting(2.0) };
    let coarse = quantity(&points, 5e-4).judge(&exact);
    assert_eq!(coarse.verdict, Verdict::Inconclusive, "{}", coarse.reason);
    let fine = quantity(&points, 5e-8).judge(&exact);
    assert_eq!((fine.verdict, fine.extrapolated), (Verdict::Pass, Some(2.0)), "{}", fine.reason);
}

/// Noise of a few roundings at the fine end, which is left out, named, and does not count; values that stand still are not.
#[test]
fn grids_at_the_floor_of_rounding_are_left_out_and_named() {
    let noise = |k: i32| f64::from((7 * k) % 5 - 2) * 100.0 * f64::EPSILON;
    for unit in [1e-6, 1.0, 1e6] {
        let value = |k: i32| unit * (1.0 + 0.1 * 0.0625_f64.powi(k) + noise(k));
        let points: Vec<_> = (0..13).map(|k| (0.5_f64.powi(k), value(k))).collect();
        for question in [expecting(4.0), Question { exact: Some(unit), ..expecting(4.0) }] {
            let judgement = quantity(&points, 0.0).judge(&question);
            assert_eq!(judgement.verdict, Verdict::Pass, "{unit:e}: {}", judgement.reason);
            let left_out = format!("left out {FLOORED}: h = ");
            assert!(judgement.reason.contains(&left_out) && judgement.reason.contains("2.44141e-4"), "{unit:e}");
        }
    }
    // The last run is a copy of the one before: the law of the others leaves no room for that.
    let copied = [8.0, 4.0, 2.0, 1.0, 0.5].map(|h: f64| (h, 3.0 + 0.1 * h.max(1.0).powi(2)));
    let judgement = quantity(&copied, 5e-7).judge(&expecting(2.0));
    assert_eq!(judgement.verdict, Verdict::Inconclusive, "{}", judgement.reason);
    assert!(judgement.reason.contains("exact or converged"), "{}", judgement.reason);
}

/// Two decimals hide half of the smaller difference, and not that the other one is larger.
#[test]
fn values_that_diverge_are_told_from_rounding() {
    let judgement = quantity(&[(1.0, 1.2), (2.0, 1.08), (4.0, 1.03), (8.0, 1.01)], 0.005).judge(&Question::default());
    assert_eq!((judgement.convergence, judgement.verdict), (Convergence::Divergent, Verdict::Fail));
    assert!(judgement.reason.contains("diverge"), "{}", judgement.reason);
    // A unit of the last digit may be all that makes one difference larger.
    let open = quantity(&[(1.0, 1.05), (2.0, 1.03), (4.0, 1.02), (8.0, 1.01)], 0.005).judge(&Question::default());
    assert_eq!(open.verdict, Verdict::Inconclusive, "{}", open.reason);
}

/// Where the values scatter by more than they change, U = 3 (σ/Δφ)(ε + σ + d), at least 3 (σ/Δφ)(σ + |φ₁ − φ₀|).
#[test]
fn values_that_scatter_have_the_large_uncertainty() {
    let points = [(1.0, 1.0), (2.0, 1.9), (3.0, 1.0), (4.0, 1.9), (5.0, 1.0)];
    let fit = LeastSquares::fit(&points).expect("a fit");
    assert!(fit.deviation >= fit.change, "{fit:?}");
    let least = fit.deviation + (1.0 - fit.limit).abs();
    assert!(fit.uncertainty >= 2.9 * fit.deviation / fit.change * least, "{fit:?}");
}

#[test]
fn a_column_that_tends_to_nothing_looks_like_errors_and_one_that_tends_to_a_fifth_does_not() {
    for unit in [1e-3, 1.0, 1e3] {
        let notes = |limit: f64| {
            let points = [1.0, 2.0, 4.0, 8.0].map(|h| (h, unit * (limit + (1.0 - limit) * h * h)));
            quantity(&points, 1e-12 * unit).judge(&expecting(2.0)).notes.join(" ")
        };
        assert!(notes(0.02).contains("`--exact 0`"), "{unit}: {}", notes(0.02));
        assert!(!notes(0.2).contains("`--exact 0`"), "{unit}: {}", notes(0.2));
    }
}

#[test]
fn another_limit_is_told_where_most_of_the_error_stays() {
    let reason = |exact: f64| {
        let points = [1.0, 2.0, 4.0, 8.0].map(|h| (h, 1.0 + 0.05 * h * h));
        quantity(&points, 1e-12).judge(&Question { exact: Some(exact), ..expecting(2.0) }).reason
    };
    // Two thirds of the finest error stay, and two sevenths.
    assert!(reason(0.9).contains("the values tend to 1"), "{}", reason(0.9));
    assert!(!reason(0.98).contains("the values tend to"), "{}", reason(0.98));
}

/// Orders 1.9 and 2.1: half of the band is what settled ones may differ by.
#[test]
fn orders_that_differ_by_more_than_half_of_the_band_have_not_settled() {
    let second = 1.0 + 2_f64.powf(1.9);
    let points = [(1.0, 0.0), (2.0, 1.0), (4.0, second), (8.0, second + 16.0)];
    let judgement = quantity(&points, 0.0).judge(&expecting(2.0));
    assert_eq!(judgement.verdict, Verdict::Inconclusive);
    assert!(judgement.reason.contains("have not settled"), "{}", judgement.reason);
}

/// An order outside of the band by less than its own uncertainty is another one or is not.
#[test]
fn an_order_that_its_uncertainty_brings_into_the_band_fails_nothing() {
    let points = [1.0, 2.0, 4.0, 8.0].map(|h: f64| (h, 5.0 + h.powi(2)));
    let judged = |expected: f64| quantity(&points, 0.02).judge(&expecting(expected));
    let found = judged(2.0);
    let (order, own) = (found.order.expect("an order"), found.uncertainty.expect("of digits"));
    assert!(found.verdict == Verdict::Pass && own > 1e-3, "{found:?}");
    for (beyond, verdict) in [(0.5, Verdict::Inconclusive), (2.0, Verdict::Fail)] {
        assert_eq!(judged(order + BAND + beyond * own).verdict, verdict, "{beyond}");
        assert_eq!(judged(order - BAND - beyond * own).verdict, verdict, "{beyond}");
    }
}

/// Errors of second order by numbers of cells, and of a step in seconds that they really fall with.
#[test]
fn spacings_that_may_be_numbers_of_cells_are_named() {
    let noted = |points: &[(f64, f64)]| {
        let judgement = quantity(points, 0.0).judge(&Question::default());
        judgement.notes.iter().any(|note| note.contains("--cells"))
    };
    let grids = [10.0, 20.0, 40.0, 80.0];
    assert!(noted(&grids.map(|n: f64| (n, n.powi(-2)))));
    assert!(noted(&grids.map(|n: f64| (n, 1.0 - n.powi(-2)))));
    assert!(!noted(&grids.map(|h: f64| (h, h.powi(2)))));
    assert!(!noted(&[(10.0, 1.0), (20.0, 2.0), (40.0, 3.0), (80.0, 4.0)]), "they do not settle");
    assert!(!noted(&grids.map(|n: f64| (n / 100.0, n.powi(-2)))));
    assert!(!noted(&grids.map(|n: f64| (n + 0.5, n.powi(-2)))), "no numbers of cells");
    assert!(!noted(&[1.0, 2.0, 4.0, 8.0].map(|n: f64| (n, n.powi(-2)))), "no grid of one cell");
}

#[test]
fn spacings_that_are_none_are_named_and_zero_has_a_square() {
    let reason = |points: &[(f64, f64)]| quantity(points, 0.0).judge(&Question::default()).reason;
    for h in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let reason = reason(&[(h, 1.0), (1.0, 2.0), (2.0, 4.0)]);
        assert!(reason.contains("is not positive"), "{h}: {reason}");
    }
    let reason = reason(&[1.0, 2.0, 4.0].map(|h| (h, 0.0)));
    assert!(reason.contains("the same value"), "{reason}");
}

/// The finest of them, coarse to fine, agrees with where the orders go, and all with each other.
#[test]
fn orders_have_settled_from_the_finest_grid_on() {
    let any = Triplet::new([1.0, 2.0, 4.0].map(|h: f64| (h, 1.0 + h.powi(2))), 0.0).expect("an order");
    let of = |orders: [f64; 3], towards: f64| settled(&orders.map(|order| Ok(Triplet { order, ..any })), towards, 0.1);
    assert_eq!([2.0, 2.09, 2.11, 1.89].map(|towards| of([2.0; 3], towards)), [3, 3, 0, 0]);
    assert_eq!([of([1.95, 2.0, 2.04], 2.1), of([1.9, 1.95, 2.04], 2.1), of([2.0, 1.9, 2.04], 2.1)], [3, 2, 1]);
    let judged = quantity(&[1.0, 2.0, 4.0, 8.0, 16.0].map(|h: f64| (h, 1.0 + h.powi(2))), 0.0).judge(&expecting(2.0));
    assert!(judged.reason.contains("settled on 5 grids"), "{}", judged.reason);
}

/// Linear errors with a quadratic term of the same size: orders 1.459 and 1.300 that go on falling, to 1.
#[test]
fn orders_that_still_drift_have_not_settled_and_fewer_digits_do_not_settle_them() {
    let points = [0.4, 0.2, 0.1, 0.05].map(|h: f64| (h, 1.0 + h + 2.0 * h * h));
    for resolution in [0.0, 5e-6, 5e-4] {
        for question in [expecting(1.0), expecting(2.0), Question::default()] {
            let judgement = quantity(&points, resolution).judge(&question);
            assert_eq!(judgement.verdict, Verdict::Inconclusive, "{}", judgement.reason);
            assert!(judgement.reason.contains("have not settled"), "{}", judgement.reason);
            assert_eq!((judgement.order, judgement.extrapolated), (None, None));
        }
    }
}

/// The order 1 of a h + b h² lies within what is said of it, and digits widen that.
#[test]
fn the_uncertainty_of_an_order_covers_its_drift() {
    for b in [0.02, 0.05, 0.1, 0.2] {
        for n in [4, 5, 6] {
            let points: Vec<_> =
                (0..n).map(|k| 0.4 * 0.5_f64.powi(k)).map(|h| (h, 1.0 + 0.3 * h + b * h * h)).collect();
            let judge = |resolution: f64| quantity(&points, resolution).judge(&Question::default());
            let (exact, digits) = (judge(0.0), judge(1e-5));
            let Some((order, uncertainty)) = exact.order.zip(exact.uncertainty) else { continue };
            assert!((order - 1.0).abs() <= uncertainty, "{b} {n}: {}", exact.reason);
            assert!(digits.uncertainty.is_none_or(|digits| digits >= uncertainty), "{b} {n}: {}", digits.reason);
        }
    }
    let settled = [0.4, 0.2, 0.1, 0.05, 0.025].map(|h: f64| (h, 1.0 + 0.3 * h + 0.2 * h * h));
    assert_eq!(quantity(&settled, 0.0).judge(&expecting(1.0)).verdict, Verdict::Pass);
}

/// 1 + 0.3(−1)ᵏh on halved grids, and differences that shrink by a factor of 2500.
#[test]
fn where_no_power_law_holds_there_is_neither_order_nor_limit() {
    let alternating = [(0.4, 1.12), (0.2, 0.94), (0.1, 1.03), (0.05, 0.985)];
    let absurd = [(1.0, 1.0), (2.0, 1.0001), (4.0, 1.2501)];
    for (points, convergence) in [
        (&alternating[..], Convergence::Oscillatory),
        (&alternating[1..], Convergence::Oscillatory),
        (&absurd, Convergence::Monotonic),
    ] {
        let judgement = quantity(points, 0.0).judge(&Question::default());
        assert_eq!((judgement.convergence, judgement.verdict), (convergence, Verdict::Inconclusive));
        assert_eq!((judgement.order, judgement.uncertainty), (None, None), "{}", judgement.reason);
        assert_eq!((judgement.extrapolated, judgement.gci), (None, None));
        // A fit to four grids has an uncertainty for it.
        let covers = |fit: LeastSquares| (points[3].1 - 1.0).abs() <= fit.uncertainty;
        assert!(judgement.least_squares.is_none_or(covers), "{judgement:?}");
    }
    // An order that is expected is believed.
    let eleventh = [1.0, 2.0, 4.0].map(|h: f64| (h, 1.0 + 1e-4 * h.powi(11)));
    assert_eq!(quantity(&eleventh, 0.0).judge(&expecting(11.0)).verdict, Verdict::Pass);
}

/// Differences that double: the digits decide whether that refutes convergence, and the number of grids from four on does not.
#[test]
fn one_verdict_on_values_that_diverge() {
    let points = [(0.4, 1.0), (0.2, 1.1), (0.1, 1.3), (0.05, 1.7), (0.025, 2.5)];
    for question in [expecting(1.0), Question::default()] {
        for n in [4, 5] {
            let judgement = quantity(&points[..n], 5e-4).judge(&question);
            assert_eq!((judgement.convergence, judgement.verdict), (Convergence::Divergent, Verdict::Fail));
            // Two more grids on which it seemed to converge.
            let mut more = vec![(1.6, 2.0), (0.8, 1.2)];
            more.extend(&points[..n]);
            assert_eq!(quantity(&more, 5e-4).judge(&question).verdict, Verdict::Fail);
        }
        // Rounding by 0.05 may have made 0.3 and 0.3 of the finest differences 0.2 and 0.4.
        let open = quantity(&points[..4], 0.05).judge(&question);
        assert_eq!((open.convergence, open.verdict), (Convergence::Unresolved, Verdict::Inconclusive));
        assert!(open.reason.contains("may diverge") && open.reason.contains("digits"), "{}", open.reason);
    }
}

/// Four grids whose differences grow refute convergence where they do so by a law; three grids decide nothing.
#[test]
fn growth_by_a_law_is_told_from_growth_by_none() {
    let question = expecting(1.0);
    let judged = |factors: &[f64]| {
        let (mut value, mut difference, mut h) = (10.0, 0.1, 0.4);
        let mut points = vec![(0.8, value)];
        for factor in factors {
            value += difference;
            points.push((h, value));
            (difference, h) = (difference * factor, 0.5 * h);
        }
        quantity(&points, 0.0).judge(&question)
    };
    let none = ", but by no law: ";
    for (rise, verdict) in [(0.4, Verdict::Fail), (0.6, Verdict::Inconclusive), (1.9, Verdict::Inconclusive)] {
        let judgement = judged(&[2.0, 2.0 * 2_f64.powf(rise * question.band), 1.0]);
        assert_eq!(judgement.verdict, verdict, "{rise}: {}", judgement.reason);
        assert_eq!(judgement.reason.contains(none), verdict == Verdict::Inconclusive, "{rise}: {}", judgement.reason);
    }
    let three = judged(&[2.0, 1.0]);
    assert!(three.verdict == Verdict::Inconclusive && !three.reason.contains(none), "{}", three.reason);
}

/// Numbers in ±1 without a pattern, the same in every run.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        2.0 * (state >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
    }
}

/// 1 + 2h³ on halved grids with noise far above its finest differences: a factor of 3 to 100.
#[test]
fn noise_is_not_called_divergence() {
    let mut failed = 0;
    for (n, size) in [(4, 1e-4), (6, 1e-4), (4, 1e-3)] {
        for seed in 1..=200 {
            let mut noise = noise(seed);
            let points: Vec<_> =
                (0..n).map(|k| 0.1 * 0.5_f64.powi(k)).map(|h| (h, 1.0 + 2.0 * h.powi(3) + size * noise())).collect();
            failed += u32::from(quantity(&points, 0.0).judge(&expecting(3.0)).verdict == Verdict::Fail);
        }
    }
    // 0.15 % of them are 0.9, and three standard deviations above that 3.7.
    assert!(failed <= 4, "{failed} of 600");
}

/// Clean differences of fourth order on coarse grids, and noise on fine ones: the order is that of the coarse grids.
#[test]
fn grids_that_converge_are_not_left_out_for_the_noise_of_finer_ones() {
    let mut passed = 0;
    for seed in 1..=40 {
        let mut noise = noise(seed);
        let points: Vec<_> =
            (0..10).map(|k| 0.4 * 0.5_f64.powi(k)).map(|h| (h, 1.0 + h.powi(4) + 1e-9 * noise())).collect();
        let judged = quantity(&points, 0.0).judge(&expecting(4.0));
        assert!(judged.verdict != Verdict::Fail, "{seed}: {}", judged.reason);
        // Its last differences grow within the noise, and by more than their digits.
        if seed == 7 {
            assert!(!judged.reason.contains("diverge"), "{}", judged.reason);
        }
        if judged.verdict == Verdict::Pass {
            passed += 1;
            assert!(
                judged.reason.contains("floor of noise") && !judged.reason.contains("too coarse"),
                "{}",
                judged.reason
            );
        }
    }
    // Where two or three differences are all noise, it may look like anything.
    assert!(passed > 20, "{passed} of 40");
    // Differences that settle at a lower order on fine grids are no noise.
    let mixed: Vec<_> = (0..10).map(|k| 0.4 * 0.5_f64.powi(k)).map(|h| (h, 1.0 + h.powi(4) + 1e-4 * h)).collect();
    let judged = quantity(&mixed, 0.0).judge(&expecting(4.0));
    assert!(judged.verdict != Verdict::Pass, "{}", judged.reason);
}

/// With grids halved the differences of orders shrink by 2^−½ at least, since orders come in halves: Δ + Δr + Δr² + … = Δ/(1 − r).
#[test]
fn orders_are_extrapolated_by_their_own_ratio_and_no_slower_than_half_an_order_allows() {
    let points = [1.0, 2.0, 4.0, 8.0, 16.0].map(|h: f64| (h, 1.0 + h.powi(2)));
    let [fine, medium, coarse, ..] = points;
    let any = Triplet::new([fine, medium, coarse], 0.0).expect("an order");
    let limit = |orders: [f64; 3]| towards(&orders.map(|order| Ok(Triplet { order, ..any })), &points);
    let half = 0.5_f64.sqrt();
    for (orders, expected) in [
        ([1.60, 1.80, 1.90], 1.80 + 0.10 / (1.0 - 0.5)),
        // The differences grow, or shrink too slowly.
        ([1.73, 1.81, 1.90], 1.81 + 0.09 / (1.0 - half)),
        ([1.71, 1.81, 1.90], 1.81 + 0.09 / (1.0 - half)),
        // They alternate.
        ([2.00, 1.80, 1.90], 1.90),
    ] {
        assert!((limit(orders) - expected).abs() < 1e-12, "{orders:?}: {}, not {expected}", limit(orders));
    }
}

/// Seven values of second order with noise as large as their last differences: no order, and a fit to all of them by the procedure of
/// Eça and Hoekstra whose uncertainty covers the limit.
#[test]
fn values_that_scatter_have_a_fit_with_an_uncertainty() {
    let h = [20.0, 30.0, 40.0, 60.0, 80.0, 120.0, 160.0].map(|cells: f64| 1.0 / cells);
    let (mut scattered, mut covered) = (0, 0);
    for seed in 1..=200 {
        let mut noise = noise(seed);
        let points: Vec<_> = h.iter().map(|h| (*h, 1.0 + 8.0 * h * h + 2e-3 * noise())).collect();
        let judged = quantity(&points, 5e-5).judge(&Question::default());
        let Some(fit) = judged.least_squares.filter(|_| judged.convergence != Convergence::Monotonic) else { continue };
        assert_eq!((judged.verdict, judged.used), (Verdict::Inconclusive, 7), "{seed}: {}", judged.reason);
        assert!(judged.notes.iter().any(|note| note.contains("scatter")), "{:?}", judged.notes);
        let finest = points.last().expect("seven").1;
        // U is that of the finest value, meant to cover its error in 95 % of all cases.
        scattered += 1;
        covered += i32::from((finest - 1.0).abs() <= fit.uncertainty);
    }
    assert!(scattered > 100 && f64::from(covered) >= 0.95 * f64::from(scattered), "{covered} of {scattered}");
}

/// Half the median of the differences that noise leaves, and of two kinds of noise in proportion.
#[test]
fn the_amplitude_of_noise_is_half_of_its_differences() {
    for size in [1e-9, 1e-8] {
        // Fine to coarse: four values of noise of the size, then a fourth order.
        let noise = [1.0, -1.0, 1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let h = |k: usize| 0.4 * 0.5_f64.powi(9 - k as i32);
        let points: Vec<_> = (0..10).map(|k| (h(k), 1.0 + h(k).powi(4) + size * noise[k])).collect();
        let found = noise::amplitude(&points, f64::EPSILON, 0.25).expect("noise");
        assert!((0.5 * size..=2.0 * size).contains(&found), "{size:e}: {found:e}");
    }
}

/// Differences that do not change sign, or are beyond those of the power law, are no noise.
#[test]
fn what_does_not_scatter_has_no_amplitude_of_noise() {
    let h = |k: usize| 0.4 * 0.5_f64.powi(9 - k as i32);
    let of = |noise: [f64; 4]| {
        let points: Vec<_> =
            (0..10).map(|k| (h(k), 1.0 + h(k).powi(4) + noise.get(k).map_or(0.0, |noise| 1e-8 * noise))).collect();
        noise::amplitude(&points, f64::EPSILON, 0.25)
    };
    assert!(of([1.0, -1.0, 1.0, -1.0]).is_some());
    assert_eq!([of([-4.0, -3.0, -2.0, -1.0]), of([0.0; 4])], [None; 2]);
}

/// Values on grids of ratio two, from fine to coarse, with the given differences.
fn with_differences(differences: &[f64]) -> Vec<(f64, f64)> {
    let mut points = vec![(1.0, 0.0)];
    for d in differences.iter().rev() {
        let (h, value) = points[points.len() - 1];
        points.push((0.5 * h, value + d));
    }
    points.reverse();
    points
}

/// Values of order 2 with differences 4d and d, and a finest grid that stands still where they would change by d/4: that is at the floor
/// up to twice what the digits resolve, 20 units of them.
#[test]
fn grids_are_left_out_where_the_law_of_the_others_is_at_the_floor_as_well() {
    let left_out = |d: f64| first_above_floor(&with_differences(&[0.0, d, 4.0 * d]), 1e-3);
    assert_eq!([4.0 * 19.8e-3, 4.0 * 20.2e-3].map(left_out), [1, 0]);
    // Where all differ there is nothing to leave out.
    assert_eq!(first_above_floor(&with_differences(&[0.25, 1.0, 4.0]), 1e-3), 0);
}

/// Orders of 1.55 and 1.5 have settled, and refute an order of 2, from which they go away.
#[test]
fn a_wrong_order_that_drifts_away_is_refuted_all_the_same() {
    let differences = [1.0, 2_f64.powf(1.5), 2_f64.powf(3.05)];
    let judgement = quantity(&with_differences(&differences), 0.0).judge(&expecting(2.0));
    assert_eq!(judgement.verdict, Verdict::Fail, "{}", judgement.reason);
    assert!(drifts_away(&[(1.55, 0.0), (1.5, 0.0)], &expecting(2.0)).is_some());
}

/// Differences of one sign left over at the fine end, and such as are beyond the power law.
#[test]
fn left_over_differences_are_noise_only_with_both_signs_and_below_the_law() {
    let law = [-0.01, -0.04, -0.16, -0.64];
    let of = |left: [f64; 2]| noise::amplitude(&with_differences(&[&left[..], &law].concat()), 0.0, 0.25);
    for left in [[0.003, -0.005], [-0.003, 0.005]] {
        approx::assert_relative_eq!(of(left).expect("noise"), 0.5 * 0.005, max_relative = 1e-12);
    }
    for left in [[0.003, 0.005], [-0.003, -0.005], [0.02, -0.005], [0.005, -0.02]] {
        assert_eq!(of(left), None, "{left:?}");
    }
    // Half of the band is what orders of the law may differ by.
    let with_orders = |orders: [f64; 2]| {
        let [fine, coarse] = orders.map(f64::exp2);
        noise::amplitude(&with_differences(&[0.003, -0.005, -0.01, -0.01 * fine, -0.01 * fine * coarse]), 0.0, 0.25)
    };
    assert!(with_orders([2.0, 2.1]).is_some());
    assert_eq!(with_orders([2.0, 2.2]), None);
}

#[test]
fn growing_differences_follow_a_law_by_their_rates_or_beyond_all_values() {
    let grows = |differences: &[f64], spread: f64| noise::grow_by_a_law(&with_differences(differences), spread);
    for sign in [1.0, -1.0] {
        let of = |differences: &[f64], spread| grows(&differences.iter().map(|d| sign * d).collect::<Vec<_>>(), spread);
        assert!(of(&[4.0, 2.0, 1.0], 1e-9));
        // Rates of a half and one, and not beyond all values.
        let uneven = [2.0 * SQRT_2, 2.0, 1.0];
        assert!(!of(&uneven, 0.4) && of(&uneven, 0.6));
        // Grown at three refinements, whatever the rates.
        assert!(of(&[2.9, 2.0 * SQRT_2, 2.0, 1.0], 0.0));
    }
    // Of both signs: below the values before, and beyond.
    assert!(!grows(&[0.4, -0.3, 1.0], 10.0) && grows(&[1.1, -0.3, 1.0], 10.0) && grows(&[-1.1, 0.3, -1.0], 10.0));
}

#[test]
fn orders_drift_away_beyond_their_uncertainty_and_out_of_the_band() {
    let drifts = |coarse: f64, fine: f64, uncertainty: f64| {
        drifts_away(&[(9.0, 0.0), (coarse, uncertainty), (fine, uncertainty)], &expecting(2.0)).is_some()
    };
    let band = Question::default().band;
    for sign in [1.0, -1.0] {
        let of = |coarse: f64, fine: f64, uncertainty| drifts(2.0 + sign * coarse, 2.0 + sign * fine, uncertainty);
        assert!(of(0.3 * band, 0.8 * band, 0.1 * band));
        // Towards 2, across it to the same distance, within the band at the next grid, and within the uncertainty of both.
        assert!(!of(0.8 * band, 0.3 * band, 0.1 * band) && !of(-0.8 * band, 0.7 * band, 0.1 * band));
        assert!(!of(0.3 * band, 0.6 * band, 0.1 * band) && !of(0.3 * band, 0.8 * band, 0.3 * band));
    }
    assert!(drifts_away(&[(1.7, 0.0), (1.5, 0.0)], &Question::default()).is_none());
}

/// GCI₂₃/(r₂₁^p GCI₁₂) is 1 for the order of the values, also on grids of unequal ratios, and the factor by which the differences
/// fall short of another.
#[test]
fn the_asymptotic_ratio_is_that_of_the_order_that_is_asked_for() {
    let ratio = |spacings: [f64; 3], p: f64| Triplet::asymptotic_ratio(spacings.map(|h| (h, 7.0 + 3.0 * h * h)), p);
    for spacings in [[0.1, 0.2, 0.4], [0.1, 0.15, 0.4]] {
        assert!((ratio(spacings, 2.0) - 1.0).abs() < 1e-12, "{spacings:?}");
    }
    // Differences 0.09 and 0.36, of which first order makes 1 and 2.
    assert!((ratio([0.1, 0.2, 0.4], 1.0) - 2.0).abs() < 1e-12);
    // 0.0375 and 0.4125, with r − 1 = ½ and 5/3.
    let expected = 0.4125 / (5.0 / 3.0) / (0.0375 / 0.5) / 1.5;
    assert!((ratio([0.1, 0.15, 0.4], 1.0) - expected).abs() < 1e-12);
}

/// Values 5 + 3h² leave 5 with order 2 from each pair of grids, of whatever ratio, the finest last.
#[test]
fn pairs_of_grids_have_the_order_of_their_errors() {
    let points = [0.1, 0.2, 0.5, 0.6].map(|h| (h, 5.0 + 3.0 * h * h));
    let orders = pair_orders(&points, 5.0);
    assert!(orders.len() == 3 && orders.iter().all(|order| (order - 2.0).abs() < 1e-9), "{orders:?}");
    let cubic = pair_orders(&[(0.1, 5.001), (0.3, 5.009), (0.6, 5.072)], 5.0);
    assert!((cubic[0] - 3.0).abs() < 1e-9 && (cubic[1] - 2.0).abs() < 1e-9, "{cubic:?}");
}

/// Order 4 where 2 is expected may be cells a side of a grid of two dimensions; an order that is expected is not asked after.
#[test]
fn an_order_that_is_expected_is_no_sign_of_cells_per_side() {
    let of = |order: f64, expected: f64| {
        let mut judgement = Judgement::undecided(Convergence::Unknown, String::new());
        judgement.order = Some(order);
        judgement.may_be_per_side("cells", 2, &expecting(expected)).is_some()
    };
    assert!(of(4.0, 2.0) && !of(2.0, 2.0) && !of(3.0, 2.0));
    assert!(of(6.0, 3.0) && !of(3.0, 3.0) && !of(4.0, 3.0));
    // Within the band of both.
    assert!(!of(0.3, 0.2));
}
