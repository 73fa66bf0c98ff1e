//! Order and uncertainty from four grids or more, by least squares.
//!
//! L. Eça and M. Hoekstra, A procedure for the estimation of the numerical uncertainty of CFD calculations based on grid
//! refinement studies, J. Comput. Phys. 262 (2014) 104–130.

use nalgebra::{DMatrix, DVector};

use crate::measure::search::minimum;

/// Orders between which a power law is trusted as it is, for a scheme of nominal order 2.
const TRUSTED: (f64, f64) = (0.5, 2.1);
/// Orders among which the power law is looked for.
const ORDERS: (f64, f64) = (0.05, 12.0);
/// Pieces of that range; the sum of squares is smooth in p on a scale of 1/ln(h_max/h_min).
const PIECES: u32 = 240;

/// What is fitted to the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// φ₀ + α h^p.
    Power,
    /// φ₀ + α h.
    First,
    /// φ₀ + α h².
    Second,
    /// φ₀ + α₁ h + α₂ h².
    Both,
}

/// A power law φ₀ + α h^p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power {
    /// p.
    pub order: f64,
    /// Standard error of p from the scatter about the fit.
    pub stderr: f64,
    /// Σ |∂p/∂φ_i|: by how much values that each move by one unit can move p, to first order.
    pub sensitivity: f64,
    /// φ₀.
    pub limit: f64,
}

/// The fit that the procedure chooses, and its uncertainty on the finest grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquares {
    /// The power law, where there is one inside the range that is searched, whether trusted or not.
    pub power: Option<Power>,
    /// What is chosen.
    pub form: Form,
    /// Whether fine grids weigh more, by 1/h.
    pub weighted: bool,
    /// φ₀ of the chosen fit.
    pub limit: f64,
    /// Standard deviation σ of the values from the chosen fit.
    pub deviation: f64,
    /// Mean change Δφ = (max φ − min φ)/(n − 1) from grid to grid.
    pub change: f64,
    /// U on the finest grid: with ε = |fit₁ − φ₀| and d = |φ₁ − fit₁| it is F ε + σ + d where σ < Δφ, and 3 (σ/Δφ)(ε + σ + d)
    /// otherwise; F = 1.25 for a trusted power law, else 3.
    pub uncertainty: f64,
}

/// Data that have no such fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// There must be more grids than parameters.
    #[error("a fit needs three grids or more, got {0}")]
    TooFew(usize),
    /// The values are not finite, or all the same.
    #[error("the values are all the same, or not finite")]
    Degenerate,
}

/// One candidate: its values on the grids, its limit and its deviation.
struct Candidate {
    form: Form,
    weighted: bool,
    order: f64,
    coefficients: DVector<f64>,
    /// Σ w r², the weights adding up to n.
    squares: f64,
    deviation: f64,
}

impl LeastSquares {
    /// Fits (h, φ) on grids in the sequence fine to coarse.
    ///
    /// # Errors
    /// [`FitError`] for fewer than three grids, or values without a difference.
    pub fn fit(points: &[(f64, f64)]) -> Result<Self, FitError> {
        let n = points.len();
        if n < 3 {
            return Err(FitError::TooFew(n));
        }
        let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.1), h.max(p.1)));
        let change = (high - low) / (n - 1) as f64;
        if !(change > 0.0 && change.is_finite()) || points.iter().any(|p| !p.1.is_finite()) {
            return Err(FitError::Degenerate);
        }
        // Spacings in units of the finest keep the equations well scaled.
        let scaled: Vec<(f64, f64)> = points.iter().map(|p| (p.0 / points[0].0, p.1)).collect();
        let best = |forms: &[Form]| {
            let all =
                forms.iter().flat_map(|form| [false, true].map(|weighted| Candidate::fit(&scaled, *form, weighted)));
            all.flatten().min_by(|a, b| a.deviation.total_cmp(&b.deviation))
        };
        let power = best(&[Form::Power]);
        let (chosen, trusted) = match &power {
            Some(fit) if (TRUSTED.0..TRUSTED.1).contains(&fit.order) => (None, true),
            Some(fit) if fit.order >= TRUSTED.1 => (best(&[Form::First, Form::Second]), false),
            _ => (best(&[Form::First, Form::Second, Form::Both]), false),
        };
        let fit = chosen.as_ref().or(power.as_ref()).ok_or(FitError::Degenerate)?;
        let (limit, deviation) = (fit.coefficients[0], fit.deviation);
        let on_finest = fit.value(scaled[0].0);
        let (error, distance) = ((on_finest - limit).abs(), (scaled[0].1 - on_finest).abs());
        let uncertainty = if deviation < change {
            let safety = if trusted { 1.25 } else { 3.0 };
            safety * error + deviation + distance
        } else {
            3.0 * deviation / change * (error + deviation + distance)
        };
        let power = power.as_ref().map(|fit| fit.power(&scaled));
        Ok(Self { power, form: fit.form, weighted: fit.weighted, limit, deviation, change, uncertainty })
    }
}

impl Candidate {
    fn fit(points: &[(f64, f64)], form: Form, weighted: bool) -> Option<Self> {
        match form {
            Form::First => Self::linear(points, form, 1.0, weighted),
            Form::Second => Self::linear(points, form, 2.0, weighted),
            Form::Both => Self::linear(points, form, 1.0, weighted),
            Form::Power => {
                // The best φ₀ and α for each p leave a function of p alone; its least value inside the range.
                let squares = |p: f64| Self::linear(points, form, p, weighted).map_or(f64::INFINITY, |c| c.squares);
                let at = |k: u32| ORDERS.0 + (ORDERS.1 - ORDERS.0) * f64::from(k) / f64::from(PIECES);
                let least = (0..=PIECES).min_by(|a, b| squares(at(*a)).total_cmp(&squares(at(*b))))?;
                if least == 0 || least == PIECES {
                    return None;
                }
                let order = minimum([at(least - 1), at(least + 1)], 1e-10, squares);
                Self::linear(points, form, order, weighted)
            }
        }
    }

    /// The linear least-squares problem for a given exponent.
    fn linear(points: &[(f64, f64)], form: Form, order: f64, weighted: bool) -> Option<Self> {
        let n = points.len();
        let parameters = if form == Form::Both { 3 } else { 2 };
        // p is a third parameter of the power law.
        let used = if form == Form::Power { 3 } else { parameters };
        let total: f64 = points.iter().map(|p| 1.0 / p.0).sum();
        let weight = |h: f64| if weighted { n as f64 / h / total } else { 1.0 };
        let mut design = DMatrix::from_fn(n, parameters, |i, j| match j {
            0 => 1.0,
            1 => points[i].0.powf(order),
            _ => points[i].0.powi(2),
        });
        let mut values = DVector::from_fn(n, |i, _| points[i].1);
        let (plain, data) = (design.clone(), values.clone());
        for (i, point) in points.iter().enumerate() {
            let root = weight(point.0).sqrt();
            design.row_mut(i).scale_mut(root);
            values[i] *= root;
        }
        // Powers of spacings that are too far apart are none.
        if !design.iter().chain(&values).all(|x| x.is_finite()) {
            return None;
        }
        let coefficients = design.svd(true, true).solve(&values, f64::EPSILON).ok()?;
        let residuals = data - plain * &coefficients;
        let squares: f64 = residuals.iter().zip(points).map(|(r, p)| weight(p.0) * r * r).sum();
        // As many grids as parameters leave no scatter to measure.
        let deviation = if n > used { (squares / (n - used) as f64).sqrt() } else { 0.0 };
        Some(Self { form, weighted, order, coefficients, squares, deviation })
    }

    fn value(&self, h: f64) -> f64 {
        let second = self.coefficients.get(2).map_or(0.0, |a| a * h * h);
        self.coefficients[0] + self.coefficients[1] * h.powf(self.order) + second
    }

    /// The power law with what moves its order: δp is the last row of (JᵀJ)⁻¹Jᵀ times δφ, J = (1, h^p, α h^p ln h).
    fn power(&self, points: &[(f64, f64)]) -> Power {
        let slope = |h: f64| h.powf(self.order);
        let jacobian = DMatrix::from_fn(points.len(), 3, |i, j| match j {
            0 => 1.0,
            1 => slope(points[i].0),
            _ => self.coefficients[1] * slope(points[i].0) * points[i].0.ln(),
        });
        let (mut stderr, mut sensitivity) = (f64::INFINITY, f64::INFINITY);
        if let Some(inverse) = (jacobian.transpose() * &jacobian).try_inverse() {
            stderr = self.deviation * inverse[(2, 2)].max(0.0).sqrt();
            sensitivity = (inverse * jacobian.transpose()).row(2).iter().map(|x| x.abs()).sum();
        }
        Power { order: self.order, stderr, sensitivity, limit: self.coefficients[0] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_candidate_has_the_value_of_its_law() {
        let value = |form: Form, order: f64, coefficients: &[f64]| {
            let coefficients = DVector::from_column_slice(coefficients);
            Candidate { form, weighted: false, order, coefficients, squares: 0.0, deviation: 0.0 }.value(3.0)
        };
        // 5 + 2 · 3³, 5 + 2 · 3 and 5 + 2 · 3 + 7 · 3².
        assert_eq!(value(Form::Power, 3.0, &[5.0, 2.0]), 59.0);
        assert_eq!(value(Form::First, 1.0, &[5.0, 2.0]), 11.0);
        assert_eq!(value(Form::Both, 1.0, &[5.0, 2.0, 7.0]), 74.0);
    }

    /// Wherever it is between two of those that are tried, and whatever the unit of length.
    #[test]
    fn the_order_of_a_power_law_is_found() {
        for unit in [1e-60, 1.0, 1e60] {
            for order in [1.3, 1.31, 1.32, 1.33, 1.34] {
                let points = [1.0, 2.0, 4.0, 8.0].map(|h: f64| (unit * h, 1.0 + h.powf(order)));
                let found = LeastSquares::fit(&points).expect("a fit").power.expect("a power law").order;
                assert!((found - order).abs() < 1e-6, "{unit:e}: {found} for {order}");
            }
        }
        let three = LeastSquares::fit(&[1.0, 2.0, 4.0].map(|h| (h, 1.0 + h * h))).expect("a fit");
        assert_eq!((three.form, three.deviation), (Form::Power, 0.0), "three values are on a power law");
    }

    #[test]
    fn values_without_a_finite_difference_have_no_fit() {
        let fit = |values: [f64; 3]| LeastSquares::fit(&[(1.0, values[0]), (2.0, values[1]), (4.0, values[2])]);
        assert!(fit([1.0, 2.0, 5.0]).is_ok());
        for values in [[2.0; 3], [1.0, 2.0, f64::NAN], [1.0, f64::INFINITY, 2.0], [f64::NEG_INFINITY, 1.0, 2.0]] {
            assert_eq!(fit(values), Err(FitError::Degenerate), "{values:?}");
        }
    }

    /// (1, 0), (2, 0), (4, 1) with weights ∝ 1, ½, ¼ that add up to 3: 3a + 36/7 b = 3/7 and 36/7 a + 12 b = 12/7, the line
    /// (−5 + 4h)/13 with Σ w r² = 6/91, one degree of freedom left. Without weights the line is (−1/2 + 5/14 h) with Σ r² = 1/14.
    #[test]
    fn a_weighted_fit_weighs_by_the_inverse_of_the_spacing() {
        let points = [(1.0, 0.0), (2.0, 0.0), (4.0, 1.0)];
        for (weighted, limit, slope, squares) in
            [(true, -5.0 / 13.0, 4.0 / 13.0, 6.0_f64 / 91.0), (false, -0.5, 5.0 / 14.0, 1.0 / 14.0)]
        {
            let fit = Candidate::linear(&points, Form::First, 1.0, weighted).expect("a line");
            let found = [fit.coefficients[0], fit.coefficients[1], fit.squares, fit.deviation];
            for (x, y) in found.into_iter().zip([limit, slope, squares, squares.sqrt()]) {
                assert!((x - y).abs() < 1e-14, "{weighted}: {found:?}");
            }
        }
    }
}
