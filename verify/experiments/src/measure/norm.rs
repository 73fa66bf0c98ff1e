//! Sizes, none of which loses a NaN: `f64::max` and `f64::min` drop it, so that a failed measurement would pass for a small
//! one.

/// The larger of two numbers; NaN if either is.
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// The largest and the smallest of some measured values.
pub trait Extremes: Iterator<Item = f64> + Sized {
    /// The largest; NaN if any of them is NaN, or if there is none.
    fn largest(self) -> f64 {
        self.reduce(larger).unwrap_or(f64::NAN)
    }

    /// The smallest; NaN if any of them is NaN, or if there is none.
    fn smallest(self) -> f64 {
        -self.map(|x| -x).largest()
    }
}

impl<I: Iterator<Item = f64>> Extremes for I {}

/// Largest absolute component; NaN if any component is NaN, or if there is none.
pub fn max_norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x.abs()).largest()
}

/// Largest absolute difference of two states; NaN if any component is NaN, if there is none, or if one has more than the other: what the longer
/// one has beyond was not compared.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::NAN;
    }
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).largest()
}

/// The same over the components that both have, where one has momenta beside the other's unknowns.
pub fn common_distance(a: &[f64], b: &[f64]) -> f64 {
    let common = a.len().min(b.len());
    distance(&a[..common], &b[..common])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_is_never_lost() {
        for place in 0..3 {
            let mut values = [1.0, -2.0, 0.5];
            assert_eq!(
                (values.into_iter().largest(), values.into_iter().smallest(), max_norm(&values)),
                (1.0, -2.0, 2.0)
            );
            assert_eq!(distance(&values, &[0.0; 3]), 2.0);
            values[place] = f64::NAN;
            assert!(values.into_iter().largest().is_nan() && values.into_iter().smallest().is_nan());
            assert!(max_norm(&values).is_nan() && distance(&values, &[0.0; 3]).is_nan());
            assert!(distance(&[0.0; 3], &values).is_nan());
        }
        assert!(larger(1.0, f64::NAN).is_nan() && larger(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn nothing_measured_has_no_extreme_value() {
        assert!([].into_iter().largest().is_nan() && [].into_iter().smallest().is_nan());
        assert!(max_norm(&[]).is_nan() && distance(&[], &[]).is_nan());
    }

    #[test]
    fn what_is_not_compared_has_no_distance() {
        assert!(distance(&[1.0, 2.0], &[1.0]).is_nan() && distance(&[], &[1.0]).is_nan());
        assert_eq!(common_distance(&[1.0, 2.0], &[1.5]), 0.5);
        assert!(common_distance(&[], &[1.0]).is_nan());
    }

    /// No measured value goes through a maximum that drops NaN.
    #[test]
    fn no_source_folds_with_a_maximum_that_loses_nan() {
        // As a value that a fold or a function is given; `x.max(y)` is read by the eye.
        let banned = ["(f64::max", ", f64::max", "(f64::min", ", f64::min"];
        let own = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let verify = ["src", "../src", "../evidence/src", "../judge/src", "../tests"];
        let all = [&verify[..], &["../../lsvi/src", "../../lsvi/tests"]].concat();
        let mut folders: Vec<_> = all.iter().map(|folder| own.join(folder)).collect();
        let mut seen = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("readable").path();
                // The report measures lengths on the page.
                if path.is_dir() && !path.ends_with("src/report") {
                    folders.push(path);
                } else if path.extension().is_some_and(|x| x == "rs") && !path.ends_with("measure/norm.rs") {
                    let text = std::fs::read_to_string(&path).expect("readable");
                    assert!(!banned.iter().any(|fold| text.contains(fold)), "{}", path.display());
                    seen += 1;
                }
            }
        }
        assert!(seen > 100);
    }
}
