//! Derivatives from central differences, and what is stated beside them.

use super::{Derivative, DerivativeError, Place};
use crate::linalg::{larger, max_norm};

/// Unknowns up to which every entry is looked at; of more, products along a few directions.
const FEW: usize = 32;
/// Directions that stand for all of them.
const DIRECTIONS: u64 = 8;
/// Central differences, each with half the distance of the one before.
const LEVELS: usize = 16;
/// First distance, relative to the state: the differences of a smooth f settle from there on.
const FIRST: f64 = 0.1;
/// The same for an f that turns within a small part of the state, as a switch at 300 K does, relative to the distance above.
const NARROW: f64 = 1e-4;
/// What stated and found may differ by, relative to the larger: far above rounding, and below what a wrong term makes.
const RELATIVE: f64 = 1e-6;
/// What a difference may be wrong by, in terms of the change in its extrapolation.
const SAFETY: f64 = 10.0;
/// Uncertainty, relative to the size, beyond which a difference tells nothing.
const TELLS: f64 = 1e-3;

/// A direction, and which axis it is.
pub(super) struct Direction {
    pub(super) x: Vec<f64>,
    pub(super) axis: Option<usize>,
    /// First distances of differences, the widest first.
    first: Vec<f64>,
}

/// The axes of a small space, or a few directions in a large one, in which each component moves by its own size.
pub(super) fn directions(v: &[f64]) -> Vec<Direction> {
    let n = v.len();
    let largest = max_norm(v);
    let size = if largest > 0.0 { largest } else { 1.0 };
    // A component that is zero tells no size of its own.
    let own = |v: f64, otherwise: f64| if v == 0.0 { otherwise * size } else { v.abs() };
    if n > FEW {
        let direction = |seed| {
            let x = pseudo_random(n, seed).iter().zip(v).map(|(x, v)| x * own(*v, 1e-3)).collect();
            Direction { x, axis: None, first: vec![FIRST] }
        };
        return (1..=DIRECTIONS).map(direction).collect();
    }
    let axis = |j: usize| {
        let mut x = vec![0.0; n];
        x[j] = 1.0;
        // Components may have units of their own, in which f changes within much less than the largest of them.
        let (wide, near) = (FIRST * 1e-3 * size, FIRST * own(v[j], 1e-7));
        let first = if near < wide { vec![wide, near] } else { vec![near] };
        Direction { x, axis: Some(j), first }
    };
    (0..n).map(axis).collect()
}

impl Direction {
    /// Of a function of one variable, that changes within `length`.
    pub(super) fn along(length: f64) -> Self {
        Self { x: vec![1.0], axis: None, first: vec![FIRST * length] }
    }
}

/// Numbers between ½ and 1 with either sign, the same for the same seed.
pub(super) fn pseudo_random(n: usize, seed: u64) -> Vec<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15 ^ seed.wrapping_mul(0xd134_2543_de82_ef95);
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let size = 0.5 + 0.5 * ((state >> 12) as f64 / (1_u64 << 52) as f64);
        if state >> 11 & 1 == 0 { size } else { -size }
    };
    (0..n).map(|_| next()).collect()
}

/// The derivative of a function of `rows` components along x, from `point`, in each of them.
pub(super) fn slopes(
    point: &[f64],
    x: &Direction,
    rows: usize,
    mut function: impl FnMut(&[f64], &mut [f64]),
) -> Result<Vec<Slope>, DerivativeError> {
    let mut at = |distance: f64| {
        let moved: Vec<f64> = point.iter().zip(&x.x).map(|(v, x)| v + distance * x).collect();
        let mut value = vec![0.0; rows];
        function(&moved, &mut value);
        value
    };
    finite("what is differentiated", &at(0.0))?;
    let mut from = |first: f64| -> Vec<Slope> {
        let level = |k| {
            let distance = first * 0.5_f64.powi(k);
            let values = [at(distance), at(-distance)];
            // Rows may be sums over all unknowns, as transforms are, of which each term rounds by the size of the largest.
            let size = larger(max_norm(&values[0]), max_norm(&values[1]));
            (distance, values, size)
        };
        let levels: Vec<_> = (0..LEVELS as i32).map(level).collect();
        let row = |i: usize| levels.iter().map(move |(d, [above, below], size)| (*d, [above[i], below[i]], *size));
        (0..rows).map(|i| Slope::extrapolated(row(i))).collect()
    };
    let mut found = from(x.first[0]);
    for first in x.first[1..].iter().copied().chain(x.first.last().map(|first| NARROW * first)) {
        found = found.into_iter().zip(from(first)).map(|(wide, near)| wide.or_near(near)).collect();
    }
    Ok(found)
}

/// A derivative from differences.
pub(super) struct Slope {
    value: f64,
    uncertainty: f64,
    /// What rounding leaves of the difference over the largest distance.
    rounding: f64,
}

impl Slope {
    /// The sharper of two that agree; where they do not, larger distances reach beyond where the function is like its tangent.
    fn or_near(self, near: Self) -> Self {
        let agree = (self.value - near.value).abs() <= SAFETY * (self.uncertainty + near.uncertainty);
        if agree && self.uncertainty <= near.uncertainty || near.value.is_nan() { self } else { near }
    }

    /// The same where what is stated may round by so much.
    pub(super) fn beside(self, rounding: f64) -> Self {
        Self { uncertainty: self.uncertainty + rounding, rounding: self.rounding + rounding, ..self }
    }

    /// What is left of a number that rounds by so much without the derivative.
    pub(super) fn taken_from(self, x: f64, rounding: f64) -> Self {
        Self { value: x - self.value, uncertainty: self.uncertainty + rounding, rounding: self.rounding + rounding }
    }

    /// From values of a function above and below, over distances that halve, with the size by which they round: of all differences
    /// extrapolated in δ² the one that changed least. The largest distances may reach beyond a pole.
    fn extrapolated(levels: impl Iterator<Item = (f64, [f64; 2], f64)>) -> Self {
        // Where the function ends, as a root does, larger distances say nothing.
        let levels = levels.skip_while(|(_, [above, below], _)| !(above - below).is_finite());
        let mut best = Self { value: f64::NAN, uncertainty: f64::INFINITY, rounding: 0.0 };
        let mut row: Vec<f64> = Vec::new();
        for (k, (distance, [above, below], size)) in levels.enumerate() {
            let rounding = 4.0 * f64::EPSILON * size / distance;
            let mut next = vec![(above - below) / (2.0 * distance)];
            for (m, before) in row.iter().enumerate() {
                let (factor, last) = (4_f64.powi(m as i32 + 1), next[m]);
                let value = last + (last - before) / (factor - 1.0);
                let change = (value - before).abs();
                // What is infinite tells nothing.
                if change + rounding < best.uncertainty {
                    best = Self { value, uncertainty: change + rounding, ..best };
                }
                next.push(value);
            }
            if k == 0 {
                best.rounding = rounding;
            }
            row = next;
        }
        best
    }
}

/// What `write` writes over zeros, and over ones as well.
pub(super) fn written(
    what: &'static str,
    n: usize,
    mut write: impl FnMut(&mut [f64]),
) -> Result<Vec<f64>, DerivativeError> {
    let (mut over_zeros, mut over_ones) = (vec![0.0; n], vec![1.0; n]);
    write(&mut over_zeros);
    write(&mut over_ones);
    // Two evaluations may differ by rounding, as sums of several threads do.
    let is_kept = |(a, b): (&f64, &f64)| (b - a).abs() > 1e-6 * (1.0 + a.abs());
    match over_zeros.iter().zip(&over_ones).position(is_kept) {
        Some(row) => Err(DerivativeError::NotWritten { what, row }),
        None => Ok(over_zeros),
    }
}

pub(super) fn finite(what: &'static str, values: &[f64]) -> Result<(), DerivativeError> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(row) => Err(DerivativeError::NonFinite { what, row }),
        None => Ok(()),
    }
}

/// Two vectors that differ by no more than `within`.
pub(super) fn agree(
    of: Derivative,
    column: Option<usize>,
    (stated, found): (&[f64], &[f64]),
    within: f64,
) -> Result<(), DerivativeError> {
    for (row, (stated, found)) in stated.iter().zip(found).enumerate() {
        if (stated - found).abs() > within {
            let place = Place { row: Some(row), column };
            return Err(DerivativeError::Differs { of, place, stated: *stated, found: *found, within });
        }
    }
    Ok(())
}

/// What is stated beside what was found by differences.
pub(super) fn compare(
    of: Derivative,
    place: impl Fn(usize) -> Place,
    stated: &[f64],
    found: &[Slope],
) -> Result<(), DerivativeError> {
    let largest = found.iter().fold(max_norm(stated), |largest, slope| larger(largest, slope.value));
    for (row, (stated, slope)) in stated.iter().zip(found).enumerate() {
        let (place, size) = (place(row), stated.abs().max(slope.value.abs()));
        let (found, within) = (slope.value, SAFETY * slope.uncertainty + RELATIVE * size);
        // A small entry beside large ones has what their sums round by.
        if slope.uncertainty > TELLS * size + SAFETY * slope.rounding + 1e-10 * largest {
            return Err(DerivativeError::Unresolved { of, place, found, within });
        }
        if (stated - found).abs() > within {
            return Err(DerivativeError::Differs { of, place, stated: *stated, found, within });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slope(value: f64, uncertainty: f64) -> Slope {
        Slope { value, uncertainty, rounding: 0.25 }
    }

    #[test]
    fn of_two_differences_that_agree_the_sharper_is_taken_and_else_that_of_less_distance() {
        for (wide, near, taken) in [
            // Ten times the sum of both uncertainties apart, and a little more.
            (slope(1.0, 0.25), slope(8.5, 0.5), 1.0),
            (slope(1.0, 0.25), slope(8.75, 0.5), 8.75),
            (slope(1.0, 0.5), slope(1.5, 0.25), 1.5),
            (slope(1.0, 0.5), slope(1.5, 0.5), 1.0),
            (slope(1.0, 0.5), slope(f64::NAN, f64::INFINITY), 1.0),
        ] {
            assert_eq!(wide.or_near(near).value, taken);
        }
    }

    /// Of a straight line, from distances the first of which reach where it overflows.
    #[test]
    fn a_slope_rounds_by_what_the_widest_distance_that_tells_something_leaves() {
        for lost in 0..3 {
            let values = |k: i32| if k < lost { [f64::MAX, -f64::MAX] } else { [2_f64.powi(-k), -2_f64.powi(-k)] };
            let levels = (0..LEVELS as i32).map(|k| (0.5_f64.powi(k), values(k), 3.0));
            let found = Slope::extrapolated(levels);
            let rounding = 4.0 * f64::EPSILON * 3.0 * 2_f64.powi(lost);
            assert_eq!((found.value, found.rounding), (1.0, rounding), "{lost} that overflow");
        }
    }

    /// What is found, by values at distances 1, ½, … of an odd function that rounds by ε `size`.
    fn slope_of(levels: &[[f64; 2]], size: f64) -> [f64; 3] {
        let levels = levels.iter().enumerate().map(|(k, values)| (0.5_f64.powi(k as i32), *values, size));
        let found = Slope::extrapolated(levels);
        [found.value, found.uncertainty, found.rounding]
    }

    /// Of x + x³ + x⁵ the differences 3, 21/16 and 273/256 are extrapolated to 3/4 and 63/64, and these to 1; of x + x³ 2, 5/4 and 17/16 to 1
    /// at once.
    #[test]
    fn the_difference_is_taken_that_changed_least_with_what_rounding_leaves_of_it() {
        let odd = |f: fn(f64) -> f64| [1.0, 0.5, 0.25].map(|x| [f(x), -f(x)]);
        let (cubic, quintic) = (odd(|x| x + x.powi(3)), odd(|x| x + x.powi(3) + x.powi(5)));
        // 4 ε size/δ for δ = 1 and ¼.
        let size = 2_f64.powi(40);
        let [wide, near] = [1.0, 4.0].map(|distances| 4.0 * f64::EPSILON * size * distances);
        assert_eq!(slope_of(&quintic, size), [1.0, 0.25 + near, wide]);
        assert_eq!(slope_of(&cubic, size), [1.0, near, wide]);
        // Nearer by, roundings are more than what the first one changed by.
        let size = 0.5 / f64::EPSILON;
        assert_eq!(slope_of(&cubic, size), [1.0, 1.0 + 4.0, 2.0]);
    }

    #[test]
    fn zero_is_a_value_and_a_function_that_ends_on_one_side_has_none_there() {
        assert_eq!(slope_of(&[[0.0, -0.0]; 3], 0.0), [0.0; 3]);
        let ending = [[1.0, f64::INFINITY], [0.5, -0.5], [0.25, -0.25]];
        let size = 0.125 / f64::EPSILON;
        assert_eq!(slope_of(&ending, size), [1.0, 2.0, 1.0]);
    }

    #[test]
    fn of_a_function_that_ends_nearer_by_nothing_is_told() {
        for last in [0.25, f64::INFINITY] {
            let [value, uncertainty, _] = slope_of(&[1.0, f64::INFINITY, last].map(|x| [x, -x]), 1.0);
            assert!(value.is_nan() && uncertainty == f64::INFINITY, "{last}: {value} to {uncertainty}");
        }
    }

    #[test]
    fn a_number_less_a_slope_has_the_uncertainty_of_both() {
        let found = slope(1.0, 0.5).taken_from(8.0, 0.125);
        assert_eq!([found.value, found.uncertainty, found.rounding], [7.0, 0.625, 0.375]);
    }

    #[test]
    fn directions_are_axes_with_distances_in_the_size_of_a_component_and_of_the_largest() {
        let found = directions(&[4.0, 0.0, 1e-4, -2.0]);
        let first = |j: usize| found[j].first.clone();
        let close = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            found.iter().zip(expected).for_each(|(a, b)| approx::assert_relative_eq!(a, b, max_relative = 1e-14));
        };
        close(first(0), &[0.4]);
        close(first(1), &[4e-4, 4e-8]);
        close(first(2), &[4e-4, 1e-5]);
        close(first(3), &[0.2]);
        assert!((0..4).all(|j| found[j].axis == Some(j) && found[j].x[j] == 1.0));
        close(directions(&[0.0])[0].first.clone(), &[1e-4, 1e-8]);
        // A component of a thousandth of the largest needs no second distance.
        close(directions(&[1.0, 1e-3])[1].first.clone(), &[1e-4]);
    }

    #[test]
    fn directions_in_many_unknowns_move_each_by_its_own_size() {
        let v: Vec<f64> = (0..40).map(|k| if k == 7 { 0.0 } else { f64::from(k - 20) }).collect();
        let found = directions(&v);
        assert_eq!(found.len(), 8);
        for direction in &found {
            assert!(direction.axis.is_none() && direction.first == [FIRST]);
            for (k, (x, v)) in direction.x.iter().zip(&v).enumerate() {
                let own = if *v == 0.0 { 0.02 } else { v.abs() };
                assert!((0.5 * own..=own).contains(&x.abs()), "component {k}: {x} for {v}");
            }
        }
        let signs = |j: usize| found[j].x.iter().map(|x| x.is_sign_negative()).collect::<Vec<_>>();
        assert!((1..8).all(|j| signs(j) != signs(0)), "directions are alike");
        let negative = signs(0).iter().filter(|sign| **sign).count();
        assert!((8..32).contains(&negative), "{negative} of 40 are negative");
    }

    #[test]
    fn what_is_written_may_differ_by_the_rounding_of_two_evaluations() {
        let over = |added: f64, size: f64| {
            let mut calls = 0;
            let found = written("it", 2, |out| {
                out[0] = 1.0;
                out[1] = size + f64::from(calls) * added;
                calls += 1;
            });
            found.map(|values| values[1]).map_err(|error| error.to_string())
        };
        assert_eq!(over(0.9e-6, 0.0), Ok(0.0));
        assert!(over(1.1e-6, 0.0).is_err() && over(-1.1e-6, 0.0).is_err());
        assert_eq!(over(3.9e-6, 3.0), Ok(3.0));
        assert!(over(4.1e-6, -3.0).is_err());
    }

    #[test]
    fn stated_and_found_may_differ_by_ten_uncertainties_and_a_millionth() {
        let differs = |stated: f64, found: Slope| {
            compare(Derivative::Jacobian, |_| Place { row: None, column: None }, &[stated], &[found])
        };
        let sharp = |value: f64| Slope { value, uncertainty: 0.0, rounding: 0.0 };
        assert!(differs(2.0 + 1.9e-6, sharp(2.0)).is_ok());
        assert!(matches!(differs(2.0 + 2.1e-6, sharp(2.0)), Err(DerivativeError::Differs { .. })));
        let vague = |value: f64| Slope { value, uncertainty: 1e-3, rounding: 0.0 };
        assert!(differs(2.0 + 9.9e-3, vague(2.0)).is_ok());
        assert!(matches!(differs(2.0 + 1.1e-2, vague(2.0)), Err(DerivativeError::Differs { .. })));
        // Uncertain by more than a thousandth of itself.
        assert!(matches!(differs(0.9, vague(0.9)), Err(DerivativeError::Unresolved { .. })));
        let noisy = Slope { value: 0.9, uncertainty: 1e-3, rounding: 1.1e-5 };
        assert!(differs(0.9, noisy).is_ok());
        // Beside an entry of which it is less than ten digits away.
        let beside = |large: f64| {
            let place = |_| Place { row: None, column: None };
            compare(Derivative::Jacobian, place, &[large, 0.9], &[sharp(large), vague(0.9)])
        };
        assert!(beside(1.1e7).is_ok());
        assert!(matches!(beside(1e5), Err(DerivativeError::Unresolved { .. })));
    }
}
