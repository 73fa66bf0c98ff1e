use super::*;
use crate::claim::Printed;
use crate::file::{Body, MethodFile, Shipped};

/// (ζ − 1)(ζ² − 0.6 ζ + 1) has e^{±iφ} with cos φ = 0.3 as its other roots. Its coefficients to eight places leave open on which
/// side of the rim these are.
#[test]
fn roots_on_the_rim_are_stable_where_coefficients_are_exact_and_undecided_where_they_are_rounded() {
    let tenths = |n: i64| &Real::from(n) / &Real::from(10);
    let roots = |radius: f64| {
        let inner = [-16, 16].map(|n| if radius > 0.0 { tenths(n).widened(radius) } else { tenths(n) });
        let [second, first] = inner;
        Roots::of(&Polynomial::new(vec![Real::from(-1), first, second, Real::one()]))
    };
    assert_eq!(roots(0.0), Roots::Stable);
    let Roots::Undecided(z) = roots(0.5e-8) else { panic!("{:?}", roots(0.5e-8)) };
    assert!((z.re - 0.3).abs() < 1e-6 && (z.norm() - 1.0).abs() < 1e-6, "{z}");
}

/// The angles of the backward differentiation formulas are algebraic numbers, known to all digits.
#[test]
fn angles_of_stability_are_those_of_the_closed_forms() {
    for (name, exact) in [
        ("bdf3", 86.032_366_860_211_65),
        ("bdf4", 73.351_670_474_578_48),
        ("bdf5", 51.839_755_836_049_91),
        ("bdf6", 17.839_777_792_245_7),
    ] {
        let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
        let Body::Multistep(method) = &file.body else { panic!("{name}") };
        let found = MultistepTheory::new(method).alpha.expect("an angle");
        // Golden section comes within √ε of a minimum, and an angle to the roundings of its locus.
        approx::assert_abs_diff_eq!(found, exact, epsilon = 1e-10);
    }
}

/// With ρ(1) ≠ 0 the root ζ = 1 is not at hλ = 0.
#[test]
fn the_negative_axis_of_an_inconsistent_formula_begins_where_one_is_a_root() {
    let file = Shipped::by_name("bdf4").expect("there").read().expect("well-formed");
    let Body::Multistep(mut method) = file.body else { panic!("bdf4") };
    // 35/25 for 25/12: ρ(1) = 35/25 − 25/12 = −0.6833….
    method.rho[4].real = &Real::from(7) / &Real::from(5);
    let [[from, to]] = MultistepTheory::new(&method).negative[..] else { panic!("one interval") };
    approx::assert_abs_diff_eq!(from, 25.0 / 12.0 - 1.4, epsilon = 1e-14);
    assert_eq!(to, f64::INFINITY);
}

/// (1 − x) ζ² + x/4 = 0 at hλ = −x: |ζ| = 1 for ζ = ±i at x = 4/5, and for both of ζ = ±1 at 4/3, between which a root is infinite at 1.
#[test]
fn the_negative_axis_has_a_gap_where_the_weight_of_the_new_value_vanishes() {
    let theory = theory("0 0 1", "1/4 0 -1");
    let [[from, to], [again, end]] = theory.negative[..] else { panic!("{:?}", theory.negative) };
    assert_eq!((from, end), (0.0, f64::INFINITY));
    approx::assert_abs_diff_eq!(to, 0.8, epsilon = 1e-12);
    approx::assert_abs_diff_eq!(again, 4.0 / 3.0, epsilon = 1e-12);
    // ρ(1) = 1 over σ(1) = −3/4.
    let (_, order) = theory.facts().swap_remove(0);
    assert_eq!(order, "0, C_0 = -1.3333e0 does not vanish");
}

/// C_0 = ρ(1)/σ(1) = 0 whatever σ is, and its weights to two places leave C_1 = 1 − σ(1) over σ(1) open by a hundredth.
#[test]
fn a_lower_order_is_left_open_by_the_constant_that_comes_after_it() {
    let list = "rho = ['-1', '1']\nsigma = ['0.50', '0.50']";
    let text = format!("kind = 'multistep'\ndigits = 2\n{list}\n");
    let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
    let Body::Multistep(method) = &file.body else { panic!("{text}") };
    let finding = MultistepTheory::new(method).find(Property::Order(0)).expect("looked at");
    assert_eq!(finding.outcome, Outcome::Inconclusive);
    assert_eq!(finding.why, "C_0 to C_0 vanish, and the digits given leave C_1 open by 1e-2");
}

fn method(rho: &str, sigma: &str) -> Multistep {
    let list = |text: &str| text.split(' ').map(|x| format!("'{x}'")).collect::<Vec<_>>().join(", ");
    let text = format!("kind = 'multistep'\nrho = [{}]\nsigma = [{}]\n", list(rho), list(sigma));
    let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
    let Body::Multistep(method) = file.body else { panic!("{text}") };
    method
}

fn theory(rho: &str, sigma: &str) -> MultistepTheory {
    MultistepTheory::new(&method(rho, sigma))
}

fn shipped(name: &str) -> Multistep {
    let file = Shipped::by_name(name).expect("there").read().expect("well-formed");
    let Body::Multistep(method) = file.body else { panic!("{name}") };
    method
}

/// v_{n+2} − v_n = 2h f_{n+1}.
const LEAPFROG: [&str; 2] = ["-1 0 1", "0 2 0"];

/// (ζ − 1)² = hλ ζ², 1/ζ = 1 ± √(hλ): inside for all hλ < 0, and with a double root for hλ = 0.
const DOUBLE: [&str; 2] = ["1 -2 1", "0 0 1"];

/// ζ − 1 = −hλ ζ, of order 0: ζ = 1/(1 + hλ) is inside for hλ < −2.
const BACKWARD: [&str; 2] = ["-1 1", "0 -1"];

/// A root within 10⁻⁷ of the rim is told from it only where it is ±1 or, of exact coefficients, has 1/z beside it.
#[test]
fn roots_are_sorted_by_their_distance_from_the_rim_and_how_often_they_are_there() {
    let product = |factors: &[&[f64]]| {
        let one = Polynomial::new(vec![Real::one()]);
        let factor = |c: &&[f64]| Polynomial::new(c.iter().map(|x| Real::double(*x)).collect());
        Roots::of(&factors.iter().map(factor).fold(one, |product, factor| product.times(&factor)))
    };
    let (less, more, imaginary): (&[f64], &[f64], &[f64]) = (&[-1.0, 1.0], &[1.0, 1.0], &[1.0, 0.0, 1.0]);
    for stable in
        [&[less][..], &[less, more], &[imaginary], &[less, more, imaginary], &[less, &[-0.5, 1.0], &[0.0, 1.0]]]
    {
        assert_eq!(product(stable), Roots::Stable, "{stable:?}");
    }
    let real = |x: f64| Complex::new(x, 0.0);
    assert_eq!(product(&[less, less]), Roots::Double(real(1.0)));
    assert_eq!(product(&[more, less, more]), Roots::Double(real(-1.0)));
    let Roots::Double(z) = product(&[less, imaginary, imaginary]) else { panic!() };
    assert!(z.re.abs() < 1e-7 && (z.im.abs() - 1.0).abs() < 1e-7, "{z}");
    // The last of these is where the sum 1 + 10⁻⁷ is rounded to.
    for outside in [2.0, -3.0, 1.0 + 2e-7, 1.0 + 1e-7] {
        assert_eq!(product(&[less, &[-outside, 1.0]]), Roots::Outside(real(outside)), "{outside}");
    }
    for near in [1.0 + 5e-8, 1.0 - 5e-8] {
        let Roots::Undecided(z) = product(&[&[-near, 1.0]]) else { panic!("{near}") };
        assert!((z - real(near)).norm() < 1e-15, "{z}");
    }
    assert_eq!(product(&[&[2e-7 - 1.0, 1.0]]), Roots::Stable);
    // 1 is divided out also where digits leave open whether it is a root.
    let rounded = [0.5, -1.5, 1.0].map(|x| Real::double(x).widened(1e-9));
    assert_eq!(Roots::of(&Polynomial::new(rounded.to_vec())), Roots::Stable);
}

/// ρ = ζ^z (ζ − 1) times factors of decimals, whose division by ζ − 1 leaves roundings in place of zeros.
#[test]
fn roots_zero_hide_no_other() {
    let rho = |zeros: usize, others: &[i64]| {
        let zero = || Polynomial::new(vec![Real::zero(), Real::one()]);
        let tenths = |tenth: &i64| Polynomial::new(vec![-&(&Real::from(*tenth) / &Real::from(10)), Real::one()]);
        let factors = std::iter::repeat_with(zero).take(zeros).chain([10].iter().chain(others).map(tenths));
        Roots::of(&factors.fold(Polynomial::new(vec![Real::one()]), |product, factor| product.times(&factor)))
    };
    let all = &[3, 8, -6, 7, 4, 9];
    for zeros in 0..4 {
        for others in (0..all.len()).flat_map(|from| (from..all.len()).map(move |to| &all[from..=to])) {
            assert_eq!(rho(zeros, others), Roots::Stable, "{zeros} {others:?}");
            let Roots::Outside(z) = rho(zeros, &[others, &[12]].concat()) else { panic!("{zeros} {others:?}") };
            assert!((z - Complex::new(1.2, 0.0)).norm() < RIM, "{z}");
        }
    }
}

/// What is open of zero-stability is open of A-stability, too.
#[test]
fn a_formula_whose_root_may_be_on_the_rim_is_not_refuted() {
    let outcome = |rho: &str| theory(rho, "0 0 1").a_stable_finding().outcome;
    assert_eq!(outcome("0.99999995 -1.99999995 1"), Outcome::Inconclusive);
    assert_eq!(outcome("1.2 -2.2 1"), Outcome::Fail);
}

/// BDF2 and Adams and Bashforth's formula of two steps; v_{n+2} + 4 v_{n+1} − 5 v_n = h (4 f_{n+1} + 2 f_n), which has order 3 and the root −5.
#[test]
fn a_formula_has_an_order_in_reverse_where_it_is_consistent_and_converges_so() {
    for (rho, sigma, order) in [
        ("3/2 -2 1/2", "1 0 0", Some(2)),
        ("0 -1 1", "-1/2 3/2 0", None),
        ("1 4 -5", "0 4 2", None),
        ("-5 4 1", "2 4 0", None),
    ] {
        assert_eq!(method(rho, sigma).order_reversed(), order, "{rho}");
    }
}

/// Of Adams, Moulton, Milne and of backward differentiation, −1/(k + 1) (\[HNW93\] III.2); where σ(1) = 0 they are not divided by it:
/// (ζ − 1)², σ = ζ − 1 has (−2 + 2³ − 3)/3!.
#[test]
fn constants_are_those_of_the_literature_and_vanish_up_to_the_order() {
    for (rho, sigma, order, constant) in [
        ("-1 1", "1 0", 1, 1.0 / 2.0),
        ("0 0 -1 1", "5/12 -16/12 23/12 0", 3, 3.0 / 8.0),
        ("0 0 0 -1 1", "-9/24 37/24 -59/24 55/24 0", 4, 251.0 / 720.0),
        ("-1 1", "1/2 1/2", 2, -1.0 / 12.0),
        ("0 -1 1", "-1/12 8/12 5/12", 3, -1.0 / 24.0),
        ("0 0 -1 1", "1/24 -5/24 19/24 9/24", 4, -19.0 / 720.0),
        ("-1 0 1", "1/3 4/3 1/3", 4, -1.0 / 180.0),
        ("-1/3 3/2 -3 11/6", "0 0 0 1", 3, -1.0 / 4.0),
        ("1 -2 1", "-1 1 0", 2, 1.0 / 2.0),
    ] {
        let theory = theory(rho, sigma);
        assert_eq!((theory.order(), theory.constants.len()), (order, 21), "{rho}, {sigma}");
        approx::assert_abs_diff_eq!(theory.constants[order as usize + 1].to_f64(), constant, epsilon = 1e-15);
        let table = theory.tables().swap_remove(0);
        let row = |q: u32, text: &str| [Cell::Integer(i64::from(q)), Cell::Text(text.into())];
        let told: Vec<_> = table.rows.iter().map(|row| [row[0].clone(), row[3].clone()]).collect();
        assert_eq!(told.len(), order as usize + 3, "{rho}");
        assert_eq!(told[order as usize], row(order, "vanishes"), "{rho}");
        assert_eq!(told[order as usize + 1], row(order + 1, "does not vanish"), "{rho}");
    }
}

/// Forward Euler with ρ = (−1 ± 1/1000, 1 ± 1/500): C_0 is off by their sum, C_1 by the second.
#[test]
fn rounded_coefficients_move_values_in_every_step_and_slopes_along_the_path() {
    let mut method = method("-1 1", "1 0");
    method.rho[0].real = method.rho[0].real.widened(1e-3);
    method.rho[1].real = method.rho[1].real.widened(2e-3);
    let theory = MultistepTheory::new(&method);
    assert_eq!(theory.order(), 1);
    approx::assert_relative_eq!(
        theory.rounding_of_coefficients(2.0, 5.0, 10.0),
        3e-3 * 2.0 * 10.0 + 2e-3 * 5.0,
        max_relative = 1e-6
    );
    // Where all might vanish none is left to say what the order is.
    method.sigma[1].real = method.sigma[1].real.widened(1e6);
    let theory = MultistepTheory::new(&method);
    assert_eq!(theory.order(), 1);
    let finding = theory.find(Property::Order(1)).expect("looked at");
    let why = "the digits given leave C_0 to C_2 open, and no order of 1 step is above 1";
    assert_eq!((finding.outcome, finding.why.as_str()), (Outcome::Inconclusive, why));
    assert_eq!(theory.facts()[0].1, "open for the digits given, 1 at most");
}

/// σ(1) is 10⁻⁹, of which nine places leave half open, or twice that: ρ'(1) is 1, 0 and 2. Of a step with such weights that all is open
/// no order is told.
#[test]
fn slopes_that_nearly_cancel_make_no_constant_vanish() {
    for (rho, sigma, order) in [
        ("-1 1", "-0.999999999 1", 0),
        ("-1 1", "0.500000000 -0.499999999", 0),
        ("1 -2 1", "-1 1.000000001 0", 0),
        ("-1 0 1", "1 0.000000001 -1", 0),
        // To the digits, (1, 1) for (0.999999999, 1.000000001) too: the trapezoidal rule.
        ("-1 1", "0.499999999 0.500000001", 1),
    ] {
        let theory = theory(rho, sigma);
        assert_eq!(theory.order(), order, "{rho}, {sigma}");
        let table = theory.tables().swap_remove(0);
        let told: Vec<_> = table.rows.iter().map(|row| row[3].clone()).collect();
        assert_eq!(told[order as usize + 1], Cell::Text("does not vanish".into()), "{rho}, {sigma}");
    }
    let open = theory("-0.000000001 0.000000001", "0 0.000000001");
    assert_eq!(open.order(), 2, "no more than any formula of one step has");
    let outcome = |p: u32| open.find(Property::Order(p)).expect("looked at").outcome;
    assert_eq!([1, 2, 3].map(outcome), [Outcome::Inconclusive, Outcome::Inconclusive, Outcome::Fail]);
    assert!(open.facts()[0].1.contains("open for the digits given"), "{:?}", open.facts()[0]);
}

/// The trapezoidal rule to eight places, and backward differentiation, whose locus touches the axis at 0: as far as digits tell.
#[test]
fn a_stability_is_confirmed_to_the_digits_that_are_given() {
    for (rho, sigma, open) in [
        ("-1 1", "1/2 1/2", false),
        ("-1 1", "0.50000000 0.50000000", true),
        ("1/2 -2 3/2", "0 0 1", false),
        ("0.33333333 -1.33333333 1", "0 0 0.66666667", true),
    ] {
        let theory = theory(rho, sigma);
        let finding = theory.find(Property::AStable).expect("looked at");
        assert_eq!((finding.outcome, finding.why.contains("the digits given leave")), (Outcome::Pass, open), "{rho}");
        assert_eq!(theory.facts()[2].1.starts_with("A-stable to the digits given; "), open, "{rho}");
    }
    // θ = 1/2 ∓ 10⁻⁷, meant exactly, and σ with a root at −1 − 4·10⁻⁸.
    for (sigma, outcome) in [
        ("5000001/10000000 4999999/10000000", Outcome::Fail),
        ("4999999/10000000 5000001/10000000", Outcome::Pass),
        ("50000001/100000000 49999999/100000000", Outcome::Fail),
    ] {
        assert_eq!(theory("-1 1", sigma).find(Property::AStable).expect("looked at").outcome, outcome, "{sigma}");
    }
}

#[test]
fn the_reason_for_an_order_names_the_constants_that_vanish_and_the_first_that_does_not() {
    for (rho, sigma, order, parts) in [
        ("-1 2", "1 0", 0, ["C_0 = 1.0000e0 does not vanish", "and C_1 is 1.0000e0"]),
        ("-1 1", "2 0", 0, ["C_0 vanishes to within", "C_1 = -5.0000e-1"]),
        ("-1 1", "1 0", 1, ["C_0 and C_1 vanish to within", "C_2 = 5.0000e-1"]),
        ("0 -1 1", "-1/2 3/2 0", 2, ["C_0 to C_2 vanish to within", "C_3 = 4.1667e-1"]),
    ] {
        let theory = theory(rho, sigma);
        for (claimed, outcome) in [(order, Outcome::Pass), (order + 1, Outcome::Fail)] {
            let finding = theory.find(Property::Order(claimed)).expect("looked at");
            assert_eq!((finding.outcome, finding.measured), (outcome, Some(f64::from(order))), "{rho}, {sigma}");
            assert!(parts.iter().all(|part| finding.why.contains(part)), "{}", finding.why);
        }
    }
}

/// At hλ = −1 BDF2 has 5ζ² − 4ζ + 1 = 0, ζ = (2 ± i)/5, and Adams and Bashforth's formula (ζ + 1)(2ζ − 1) = 0.
#[test]
fn growth_is_the_largest_root_and_unbounded_where_the_new_value_has_no_weight() {
    let real = |x: f64| Complex::new(x, 0.0);
    for (rho, sigma, z, growth) in [
        ("1/2 -2 3/2", "0 0 1", real(-1.0), 0.2_f64.sqrt()),
        ("0 -1 1", "-1/2 3/2 0", real(-1.0), 1.0),
        // (ζ − 1)(ζ − 2)(ζ + 3).
        ("6 -7 0 1", "0 0 0 1", real(0.0), 3.0),
        ("-1 1", "0 1", Complex::new(0.0, 1.0), 0.5_f64.sqrt()),
        ("-1 1", "0 1", real(1.0), f64::INFINITY),
        // Whether it has none is told to 10⁻¹⁴ of the largest weight.
        ("-1024 1024", "0 1024", real(1.0 + 0.5_f64.powi(48)), f64::INFINITY),
        ("-1024 1024", "0 1024", real(1.0 + 0.5_f64.powi(40)), 2_f64.powi(40)),
    ] {
        let found = theory(rho, sigma).growth(z);
        assert!(found == growth || (found / growth - 1.0).abs() < 1e-12, "{rho}, {z}: {found}");
    }
}

#[test]
fn a_sector_of_stability_needs_zero_stability_damping_and_the_whole_axis() {
    for ([rho, sigma], negative, alpha, text, stability) in [
        (["-1 1", "1 0"], vec![[0.0, 2.0]], None, "negative axis to 2.0000", Stability::Conditional),
        (["-1 1", "0 1"], vec![[0.0, f64::INFINITY]], Some(90.0), "all of the negative axis", Stability::Damping),
        (["-1 1", "1/2 1/2"], vec![[0.0, f64::INFINITY]], Some(90.0), "all of the negative axis", Stability::Neutral),
        (LEAPFROG, vec![], None, "nothing of the negative axis", Stability::Conditional),
        (DOUBLE, vec![[0.0, f64::INFINITY]], None, "all of the negative axis", Stability::Unstable),
        (BACKWARD, vec![[2.0, f64::INFINITY]], None, "negative axis beyond 2.0000", Stability::Conditional),
    ] {
        let theory = theory(rho, sigma);
        assert_eq!((&theory.negative, theory.alpha), (&negative, alpha), "{rho}, {sigma}");
        assert_eq!((theory.negative_axis().as_str(), theory.traits().stability), (text, stability), "{rho}, {sigma}");
    }
    let mut edge = theory("-1 1", "0 1");
    edge.infinity = 0.95;
    assert_eq!(edge.traits().stability, Stability::Neutral);
    let mut parts = theory("-1 1", "1 0");
    parts.negative = vec![[0.0, 1.0], [2.0, 3.0], [4.0, f64::INFINITY]];
    let text = "negative axis to 1.0000 and negative axis from 2.0000 to 3.0000 and negative axis beyond 4.0000";
    assert_eq!(parts.negative_axis(), text);
}

/// σ = 3ζ + 9 times 1/12 has the root −3.
#[test]
fn a_formula_is_refused_a_stability_for_its_slopes_or_for_its_locus() {
    for (rho, sigma, why) in [
        ("0 -1 1", "-1/2 3/2 0", "it is explicit"),
        ("-1 1", "3/4 1/4", "σ has a root of modulus 3.000000"),
        ("-1/3 3/2 -3 11/6", "0 0 0 1", "the root locus enters the left half-plane"),
        ("1 -2 1", "0 0 1", "it is not even zero-stable"),
    ] {
        let finding = theory(rho, sigma).find(Property::AStable).expect("looked at");
        assert_eq!(finding.outcome, Outcome::Fail, "{rho}");
        assert!(finding.why.contains(why), "{}", finding.why);
    }
    // |ζ| for hλ → ∞ is 0 of backward differentiation alone.
    for (rho, sigma, l_stable, why) in [
        ("1/2 -2 3/2", "0 0 1", Outcome::Pass, "σ has no root but 0"),
        ("-1 1", "1/2 1/2", Outcome::Fail, "σ has a root of modulus 1"),
        ("-1 1", "1/10^7 1-1/10^7", Outcome::Fail, "σ has a root of modulus 1.0e-7"),
    ] {
        let theory = theory(rho, sigma);
        assert_eq!(theory.find(Property::AStable).expect("looked at").outcome, Outcome::Pass);
        let finding = theory.find(Property::LStable).expect("looked at");
        assert!(finding.outcome == l_stable && finding.why.contains(why), "{finding:?}");
    }
    let stability = &theory("-1 1", "1/10^7 1-1/10^7").facts()[2].1;
    assert!(stability.ends_with("|ζ| = 1.0e-7 for hλ → ∞"), "{stability}");
}

/// The trapezoidal rule to two digits: its locus is the imaginary axis, to the digits.
#[test]
fn stability_that_digits_leave_open_is_neither_claimed_nor_denied() {
    let mut method = method("-1 1", "1/2 1/2");
    method.rho.iter_mut().chain(&mut method.sigma).for_each(|x| x.real = x.real.widened(5e-3));
    let theory = MultistepTheory::new(&method);
    let stability = &theory.facts()[2].1;
    assert!(stability.starts_with("whether it is A-stable is open for the digits given; "), "{stability}");
    approx::assert_abs_diff_eq!(theory.alpha.expect("an angle"), 90.0, epsilon = 1e-12);
    let right = Property::AlphaStable(Printed { value: 90.0, places: 0 });
    for property in [Property::AStable, Property::LStable, right] {
        assert_eq!(theory.find(property).expect("looked at").outcome, Outcome::Inconclusive, "{property:?}");
    }
}

#[test]
fn a_formula_that_is_not_symmetric_is_told_by_the_first_weights_that_differ() {
    for (rho, sigma, why) in [
        ("-1 0 1", "1/3 4/3 1/3", "ρ_j = −ρ_{k−j} and σ_j = σ_{k−j} for all j"),
        ("1/2 -2 3/2", "0 0 1", "ρ_0 is not −ρ_2"),
        ("-1 1 1", "0 1 0", "ρ_1 is not −ρ_1"),
        ("-1 0 1", "1 1 0", "σ_0 is not σ_2"),
        ("-1 1 -1 1", "0 1 2 0", "σ_1 is not σ_2"),
    ] {
        let finding = theory(rho, sigma).find(Property::Symmetric).expect("looked at");
        assert_eq!((finding.outcome == Outcome::Pass, finding.why.as_str()), (why.contains("all j"), why));
    }
}

/// Dahlquist: zero-stable and consistent.
#[test]
fn convergence_fails_by_roots_outside_or_double_ones_or_an_order_of_zero() {
    for ([rho, sigma], outcome, modulus, why) in [
        (LEAPFROG, Outcome::Pass, None, "the roots of ρ are in the unit disc, those on its rim simple"),
        (["2 -3 1", "-1 0 0"], Outcome::Fail, Some(2.0), "ρ has the root 2.000000 +0.000000i of modulus 2.000000"),
        (["1 -2 1", "-1 1 0"], Outcome::Fail, Some(1.0), "ρ has 1 as a double root"),
        (DOUBLE, Outcome::Fail, None, "ρ has 1 as a double root, and it is not consistent: its order is 0"),
        (BACKWARD, Outcome::Fail, None, "those on its rim simple, but it is not consistent: its order is 0"),
    ] {
        let theory = theory(rho, sigma);
        let verdict = theory.consistency().swap_remove(0);
        assert_eq!((verdict.check.id.as_str(), verdict.check.outcome), ("convergence", outcome), "{rho}");
        assert!(verdict.check.reason.ends_with(why), "{}", verdict.check.reason);
        if theory.order() > 0 {
            let measured = verdict.check.measured;
            assert!(measured.zip(modulus).map_or(measured == modulus, |(x, y)| (x - y).abs() < 1e-12), "{measured:?}");
        }
    }
    assert_eq!([complex(Complex::new(-1.0, 0.0)), complex(Complex::new(0.0, 1.0))], ["-1", "0 +1.00000i"]);
}

/// Values to start from may have an order less than the formula.
#[test]
fn a_start_keeps_the_order_if_its_own_is_one_less() {
    for (name, start, order, lowered) in [
        ("bdf1", "implicit-euler", 1, None),
        ("bdf2", "implicit-euler", 2, None),
        (
            "bdf3",
            "implicit-euler",
            2,
            Some("its start implicit-euler has order 1, where 2 is needed, so that order 2 is left"),
        ),
        ("bdf6", "radau-iia3", 6, None),
    ] {
        let mut method = shipped(name);
        let file = Shipped::by_name(start).expect("there").read().expect("well-formed");
        let Body::RungeKutta(tableau) = file.body else { panic!("{start}") };
        (method.start, method.start_name) = (tableau, start.to_owned());
        let theory = MultistepTheory::new(&method);
        assert_eq!((theory.started_order(), theory.lowered().as_deref()), (order, lowered), "{name}");
        let traits = theory.traits();
        assert_eq!((traits.order, traits.stiff_order), (order, Some(order)), "{name}");
        let start = theory.consistency().swap_remove(1).check;
        assert_eq!((start.id.as_str(), start.outcome == Outcome::Pass), ("start", lowered.is_none()), "{name}");
    }
    let bdf2 = theory("1/2 -2 3/2", "0 0 1");
    assert_eq!(bdf2.what_starts(), "radau-iia3 has order 5, and 1 is enough");
    assert_eq!(bdf2.headline(), "linear multistep, implicit, 2 steps, started by radau-iia3");
    assert_eq!((bdf2.kind(), bdf2.unknowns(), bdf2.has_structure()), ("multistep", 3, false));
}

/// Steps of at most 1/4, and of 2/5 for all of a formula together; errors of the leapfrog method grow on what decays.
#[test]
fn orders_are_measured_where_the_formula_damps_and_its_errors_can_be_seen() {
    let divided = "the errors, divided by λ";
    for ([rho, sigma], order, coarsest, stiff) in [
        (["-1 1", "0 1"], 1, 0.25, Ok(Some(1))),
        (["1/2 -2 3/2", "0 0 1"], 2, 0.2, Ok(Some(2))),
        (["-1/3 3/2 -3 11/6", "0 0 0 1"], 3, 0.4 / 3.0, Err(divided)),
        (["1/4 -4/3 3 -4 25/12", "0 0 0 0 1"], 4, 0.1, Err(divided)),
        (["-1/5 5/4 -10/3 5 -5 137/60", "0 0 0 0 0 1"], 5, 0.08, Err(divided)),
        (["-1 1", "1/2 1/2"], 2, 0.25, Ok(None)),
        (LEAPFROG, 2, 0.2, Err("not the whole negative axis")),
    ] {
        let [linear, nonlinear, in_time, prothero] = &theory(rho, sigma).trials()[..] else { panic!("{rho}") };
        let plan = linear.plan.as_ref().expect("always");
        approx::assert_relative_eq!(plan.problem.facts().window.coarsest, coarsest, max_relative = 1e-15);
        let decay = plan.problem.exact(1.0).map(|v| v[0].hypot(v[1])).expect("known");
        approx::assert_relative_eq!(
            decay,
            if [rho, sigma] == LEAPFROG { 1.0 } else { (-1.0_f64).exp() },
            epsilon = 1e-15
        );
        // The solution that depends on time has a pole a time of 1 away.
        let (is_weak, is_high) = ([rho, sigma] == LEAPFROG, order > 4);
        assert_eq!((nonlinear.name == "pendulum", in_time.plan.is_err()), (is_weak || is_high, is_high), "{rho}");
        assert_eq!(in_time.name == super::Forced::NAME.1, is_weak, "{rho}");
        for plan in [linear, nonlinear, in_time].into_iter().filter_map(|trial| trial.plan.as_ref().ok()) {
            assert_eq!(plan.order, Some(order), "{rho}");
        }
        match (&prothero.plan, stiff) {
            (Ok(plan), Ok(order)) => assert_eq!(plan.order, order, "{rho}"),
            (Err(why), Err(expected)) => assert!(why.starts_with(expected), "{rho}: {why}"),
            (found, _) => panic!("{rho}: {found:?}"),
        }
    }
    for (rho, sigma) in [("-1 1", "0 1"), ("-1/3 3/2 -3 11/6", "0 0 0 1")] {
        let mut edge = theory(rho, sigma);
        edge.infinity = 0.95;
        assert_eq!(edge.trials()[3].plan.as_ref().expect("it is run").order, None);
    }
    let [only] = &theory(DOUBLE[0], DOUBLE[1]).trials()[..] else { panic!("one") };
    assert_eq!(
        only.plan.as_ref().err().map(String::as_str),
        Some("it is not zero-stable: there is no order to measure")
    );
}

/// ±i are on the rim beside one, and of the last twice.
#[test]
fn errors_that_do_not_die_out_are_those_of_simple_roots_on_the_rim_beside_one() {
    for ([rho, sigma], weakly) in [
        (LEAPFROG, true),
        (["-1 1 -1 1", "5/12 7/12 7/12 5/12"], true),
        (["0 -1 1", "-1/2 3/2 0"], false),
        (["1/2 -2 3/2", "0 0 1"], false),
        (["-1 1 -2 2 -1 1", "0 0 0 0 0 4"], false),
    ] {
        assert_eq!(theory(rho, sigma).is_weakly_stable(), weakly, "{rho}");
    }
}

/// On these Re ρ(ζ)/σ(ζ) = 0 on the unit circle but for poles there, whose residues decide: at hλ = −2 roots are outside.
/// With ζ² for ζ it is the trapezoidal rule, whose σ has its root on the rim too: those of ζ² + 1 are ±i, to which roots come from inside.
#[test]
fn a_root_comes_to_the_rim_from_inside_at_any_angle() {
    let theory = theory("-1 0 1", "1 0 1");
    assert!(theory.a_stable.is_ok(), "{:?}", theory.a_stable);
}

/// ρ = ζᵏ⁺¹ − ζ has the roots of unity, of which eigenvalues of companion matrices are not found for k = 6 and 8, and 0.
#[test]
fn growth_is_found_where_eigenvalues_are_not() {
    for k in [6, 7, 8] {
        let padded = |[second, last]: [&str; 2]| format!("0 {second}{} {last}", " 0".repeat(k - 1));
        let found = theory(&padded(["-1", "1"]), &padded(["0", "1"])).growth(Complex::new(0.0, 0.0));
        assert!((found - 1.0).abs() < 1e-12, "{k}: {found}");
    }
}

#[test]
fn roots_of_sigma_on_the_rim_decide_stability_for_large_steps() {
    let outcome = |rho: &str, sigma: &str| {
        let theory = theory(rho, sigma);
        let is_stable = theory.growth(Complex::new(-2.0, 0.0)) <= 1.0 + BOUNDED;
        (theory.find(Property::AStable).expect("looked at").outcome, is_stable, theory.alpha.is_some())
    };
    for (rho, sigma) in [
        ("-1 1 -1 1", "5/12 7/12 7/12 5/12"),
        ("-1 11/5 -11/5 1", "2/13 16/65 16/65 2/13"),
        // Milne and Simpson's, with roots −2 ± √3 of σ, one of them outside.
        ("-1 0 1", "1/3 4/3 1/3"),
    ] {
        assert_eq!(outcome(rho, sigma), (Outcome::Fail, false, false), "{rho} {sigma}");
    }
    // The trapezoidal rule, and the same times ζ + 1 and ζ² + 1.
    // Then that of two steps, and of steps of twice hλ: with ρ/(ζσ') = 1 and ½ at ζ = ±i.
    for (rho, sigma) in [
        ("-1 1", "1/2 1/2"),
        ("-1/100000000 1/100000000", "1/200000000 1/200000000"),
        ("-1 0 1", "1/2 1 1/2"),
        ("-1 1 -1 1", "1/2 1/2 1/2 1/2"),
        ("-1 0 1", "1 0 1"),
        ("-1 0 1", "2 0 2"),
    ] {
        assert_eq!(outcome(rho, sigma), (Outcome::Pass, true, true), "{rho} {sigma}");
    }
    // Whatever the factor of all coefficients.
    let leaves = |parts: i64| {
        let of = |list: [i64; 4]| list.map(|x| format!("{x}/{}", 12 * parts)).join(" ");
        theory(&of([-12, 12, -12, 12]), &of([5, 7, 7, 5])).leaves_at_infinity().is_some()
    };
    assert_eq!([1, 100_000_000].map(leaves), [true; 2]);
    // (ζ² + 1)²/4.
    let double = theory("-1/2 -1/2 0 0 1", "1/4 0 1/2 0 1/4").leaves_at_infinity();
    assert!(double.is_some_and(|zeta| zeta.re.abs() < 1e-6 && (zeta.im.abs() - 1.0).abs() < 1e-6), "{double:?}");
}

/// The trapezoidal rule times ζ² − 0.6 ζ + 1, of which eight places leave open on which side of the rim its roots are.
#[test]
fn roots_of_sigma_that_may_lie_outside_leave_a_stability_open() {
    let theory = theory("-1 1.60000000 -1.60000000 1", "0.5 0.20000000 0.20000000 0.5");
    assert_eq!(theory.a_stable, Err(NotAStable::Open));
}

/// At hλ = −x it is ζ² + (x − 5/4) ζ + 1/4 + 2x, with two roots of modulus 1 at x = 3/8, 7/16 ± 0.9i.
#[test]
fn the_negative_axis_ends_where_two_roots_leave_the_disc_together() {
    let theory = theory("1/4 -5/4 1", "2 1 0");
    let [[from, to]] = theory.negative[..] else { panic!("{:?}", theory.negative) };
    assert_eq!(from, 0.0);
    approx::assert_abs_diff_eq!(to, 0.375, epsilon = 1e-12);
}

/// C_2 = ½ − 7/10 to a hundredth.
#[test]
fn an_order_is_confirmed_where_the_next_constant_is_there_however_few_its_digits() {
    let text = "kind = 'multistep'\ndigits = 2\nrho = ['-1', '1']\nsigma = ['0.30', '0.70']\n";
    let file = MethodFile::parse("m.toml", "m", text).expect("well-formed");
    let Body::Multistep(method) = &file.body else { panic!("{text}") };
    let finding = MultistepTheory::new(method).find(Property::Order(1)).expect("looked at");
    assert_eq!(finding.outcome, Outcome::Pass, "{}", finding.why);
}

#[test]
fn a_sector_of_a_right_angle_is_the_half_plane() {
    let theory = theory("-1 1", "0 1");
    let right = theory.find(Property::AlphaStable(Printed { value: 90.0, places: 0 })).expect("looked at");
    let half_plane = theory.find(Property::AStable).expect("looked at");
    assert_eq!((right.outcome, right.why), (Outcome::Pass, half_plane.why));
}

/// Backward Euler and the trapezoidal rule.
#[test]
fn a_formula_has_its_order_on_stiff_problems_where_it_damps() {
    let stiff = |sigma: &str| theory("-1 1", sigma).traits().stiff_order;
    assert_eq!(["0 1", "1/2 1/2"].map(stiff), [Some(1), None]);
}

/// Formulas of two bays each, the deeper one first or last.
#[test]
fn the_sector_ends_at_the_deepest_bay_of_the_locus() {
    for (rho, sigma) in
        [("5 -8 -8 -5 16", "8 -8 16 -16 16"), ("0 -8 -7 -1 16", "8 4 -4 12 16"), ("6 -8 -8 -6 16", "12 0 -12 0 16")]
    {
        let theory = theory(rho, sigma);
        let angles = (1..20_000).map(|k| theory.locus(PI * f64::from(k) / 20_000.0)).filter(|z| z.re < 0.0);
        let least = angles.map(|z| z.im.abs().atan2(-z.re).to_degrees()).smallest();
        approx::assert_abs_diff_eq!(theory.alpha.expect("an angle"), least, epsilon = 1e-4);
    }
}

/// σ = ζ² − ζ + 1 has its roots e^{±iπ/3} on the rim. For ρ = (ζ − 1)(ζ − r) the real part of ρ/(ζσ') there is (1 − r)/2.
#[test]
fn roots_leave_the_rim_at_infinity_by_the_real_part_of_a_quotient() {
    let leaves = |r: &str, sum: &str| {
        let text = format!("kind = 'multistep'\nrho = ['{r}', '-{sum}', 1]\nsigma = [1, -1, 1]\n");
        let file = MethodFile::parse("m.toml", "m", &text).expect("well-formed");
        let Body::Multistep(method) = &file.body else { panic!("{text}") };
        MultistepTheory::new(method).leaves_at_infinity().is_some()
    };
    assert!(!leaves("1/2", "3/2") && leaves("3/2", "5/2"));
}
