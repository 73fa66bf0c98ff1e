//! Richardson extrapolation from three grids, with the observed order and the grid convergence index.
//!
//! P. J. Roache, Perspective: a method for uniform reporting of grid refinement studies, J. Fluids Eng. 116 (1994) 405.

/// Safety factor of the grid convergence index for three grids (Roache).
const SAFETY: f64 = 1.25;

/// What three solutions on grids refined by a constant ratio say about the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Richardson {
    /// Observed order p = ln((f₃ − f₂)/(f₂ − f₁)) / ln r.
    pub order: f64,
    /// Extrapolated limit f₁ + (f₁ − f₂)/(r^p − 1).
    pub limit: f64,
    /// Grid convergence index of the fine grid, absolute: 1.25 |f₁ − f₂|/(r^p − 1).
    pub gci: f64,
}

/// Why three values do not extrapolate.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RichardsonError {
    /// A value or the ratio is not usable.
    #[error("Richardson extrapolation needs finite values and a ratio above 1, got {values:?} with ratio {ratio}")]
    Input {
        /// Fine, medium, coarse.
        values: [f64; 3],
        /// Refinement ratio.
        ratio: f64,
    },
    /// The two finer grids agree exactly: there is no difference left to measure.
    #[error("the two finer grids give the same value {0}: nothing is left to extrapolate")]
    Converged(f64),
    /// Successive differences change sign.
    #[error("the differences {coarse:e} and {fine:e} alternate in sign: the grids are not in the asymptotic range")]
    Oscillating {
        /// f₂ − f₁.
        fine: f64,
        /// f₃ − f₂.
        coarse: f64,
    },
    /// Successive differences do not shrink.
    #[error("the differences grow from {coarse:e} to {fine:e} under refinement")]
    Diverging {
        /// f₂ − f₁.
        fine: f64,
        /// f₃ − f₂.
        coarse: f64,
    },
}

impl Richardson {
    /// Extrapolates from `values` = [fine, medium, coarse], refined by `ratio` > 1 each.
    ///
    /// # Errors
    /// [`RichardsonError`] where the values are not finite, agree exactly, oscillate or diverge.
    pub fn new(values: [f64; 3], ratio: f64) -> Result<Self, RichardsonError> {
        if !(values.iter().all(|f| f.is_finite()) && ratio.is_finite() && ratio > 1.0) {
            return Err(RichardsonError::Input { values, ratio });
        }
        let [f1, f2, f3] = values;
        let (fine, coarse) = (f2 - f1, f3 - f2);
        if fine == 0.0 {
            return Err(RichardsonError::Converged(f1));
        }
        let quotient = coarse / fine; // r^p
        if quotient < 0.0 {
            return Err(RichardsonError::Oscillating { fine, coarse });
        }
        if quotient <= 1.0 {
            return Err(RichardsonError::Diverging { fine, coarse });
        }
        let correction = fine / (quotient - 1.0);
        Ok(Self { order: quotient.ln() / ratio.ln(), limit: f1 - correction, gci: SAFETY * correction.abs() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_power_law_extrapolates_to_its_limit() {
        let f = |h: f64| 3.0 - 0.5 * h.powf(2.5);
        let r = Richardson::new([f(0.1), f(0.2), f(0.4)], 2.0).unwrap();
        // f₂ − f₁ = 7e-3 carries 4.4e-16 of roundoff, 6e-14 relative, and divides by ln 2.
        assert_relative_eq!(r.order, 2.5, epsilon = 2e-13);
        assert_relative_eq!(r.limit, 3.0, epsilon = 2e-15);
        assert_relative_eq!(r.gci, 1.25 * 0.5 * 0.1_f64.powf(2.5), max_relative = 1e-12);
    }

    #[test]
    fn sequences_without_an_order_are_refused() {
        let error = |values, ratio| Richardson::new(values, ratio).unwrap_err();
        assert!(matches!(error([1.0, 1.1, 1.05], 2.0), RichardsonError::Oscillating { .. }));
        assert!(matches!(error([1.0, 1.2, 1.3], 2.0), RichardsonError::Diverging { .. }));
        assert!(matches!(error([1.0, 2.0, 2.0], 2.0), RichardsonError::Diverging { .. }));
        assert!(matches!(error([1.0, 1.0, 1.3], 2.0), RichardsonError::Converged(1.0)));
        assert!(matches!(error([f64::NAN, 1.0, 1.3], 2.0), RichardsonError::Input { .. }));
        assert!(matches!(error([1.0, 1.1, 1.3], 1.0), RichardsonError::Input { .. }));
    }
}
