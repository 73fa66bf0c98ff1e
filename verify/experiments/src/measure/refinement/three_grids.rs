//! Order, extrapolation and grid convergence index from three grids of any ratios.
//!
//! I. B. Celik et al., Procedure for estimation and reporting of uncertainty due to discretization in CFD applications,
//! J. Fluids Eng. 130 (2008) 078001; P. J. Roache, J. Fluids Eng. 116 (1994) 405.

use super::{FLOOR_MARGIN, least_difference};
use crate::measure::decimal::significant;
use crate::measure::search::root;

/// Safety factor of the grid convergence index on three grids.
pub const SAFETY: f64 = 1.25;

/// Orders that are looked for: beyond 20, h^p of a ratio 1.1 changes by a factor of 7 from grid to grid.
const ORDERS: (f64, f64) = (1e-3, 20.0);
/// Pieces of that range, in each of which a change of sign is looked for. With alternating differences
/// q(p) = ln((r₂₁^p + 1)/(r₃₂^p + 1)) is smooth on a scale of 1/ln r ≥ 0.1.
const PIECES: u32 = 2000;

/// Three grids in the asymptotic range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triplet {
    /// p of ε₃₂/ε₂₁ = s r₂₁^p (r₃₂^p − s)/(r₂₁^p − s), s = sign(ε₃₂/ε₂₁), where r₂₁ = h₂/h₁, ε₂₁ = φ₂ − φ₁, 1 the finest.
    pub order: f64,
    /// How far the digits of the values can move the order, to first order.
    pub uncertainty: f64,
    /// (r₂₁^p φ₁ − φ₂)/(r₂₁^p − 1), the limit for h → 0.
    pub limit: f64,
    /// Approximate relative error |φ₁ − φ₂|/|φ₁| of the fine grid.
    pub approximate_error: f64,
    /// Extrapolated relative error |φ₁ − limit|/|limit|.
    pub extrapolated_error: f64,
    /// Grid convergence index of the fine grid, 1.25 |φ₁ − φ₂|/|φ₁|/(r₂₁^p − 1).
    pub gci: f64,
    /// The same of the medium grid, 1.25 |φ₂ − φ₃|/|φ₂|/(r₃₂^p − 1).
    pub gci_coarse: f64,
    /// Whether the differences alternate in sign; then they follow no power law, and the order is a formal one.
    pub oscillates: bool,
}

/// Why three grids give no order.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TripletError {
    /// A difference is no larger than what the values resolve.
    #[error(
        "{}", if *.difference == 0.0 {
            "two neighbouring grids have the same value: exact or converged to all digits, they do not tell which".to_owned()
        } else {
            format!(
                "the difference {} between neighbouring grids is below {}, ten times what the digits of the values resolve: it is \
                 rounding, or nearly so", significant(-.difference, 4), significant(*.least, 2)
            )
        }
    )]
    Unresolved {
        /// The difference.
        difference: f64,
        /// Least difference that counts.
        least: f64,
    },
    /// The differences do not shrink as those of a positive order do.
    #[error(
        "{}: their differences go from {} to {} under refinement{}{}",
        if *.certain { "the values diverge" } else { "the values may diverge" },
        significant(-.coarse, 4), significant(-.fine, 4), if *.oscillates { " and alternate in sign" } else { "" },
        if *.certain { "" } else { ", which their digits leave open: more digits, or grids further apart, would tell" }
    )]
    Diverging {
        /// φ₂ − φ₁.
        fine: f64,
        /// φ₃ − φ₂.
        coarse: f64,
        /// Whether they alternate in sign.
        oscillates: bool,
        /// Whether they grow whatever the digits of the values hide.
        certain: bool,
    },
    /// No order up to 20 solves the equation.
    #[error("no order up to 20 explains differences of {} and {}", significant(-.coarse, 4), significant(-.fine, 4))]
    NoOrder {
        /// φ₂ − φ₁.
        fine: f64,
        /// φ₃ − φ₂.
        coarse: f64,
        /// Whether they alternate in sign.
        oscillates: bool,
    },
    /// Several orders solve the equation of alternating differences.
    #[error("several orders explain the alternating differences, {low:.3} and {high:.3} among them")]
    SeveralOrders {
        /// The least.
        low: f64,
        /// The largest.
        high: f64,
    },
}

impl Triplet {
    /// From (h, φ) on three grids, fine to coarse, 0 < h₁ < h₂ < h₃, with values known to ± `resolution`.
    ///
    /// # Errors
    /// [`TripletError`] where the values have no order, or more than one.
    pub fn new(points: [(f64, f64); 3], resolution: f64) -> Result<Self, TripletError> {
        let [(h1, f1), (h2, f2), (h3, f3)] = points;
        let (fine, coarse, r21, r32) = (f2 - f1, f3 - f2, h2 / h1, h3 / h2);
        let least = least_difference(resolution, f1.abs().max(f2.abs()).max(f3.abs()));
        // As p → 0 the quotient of monotone differences tends to ln r₃₂/ln r₂₁, and it grows with p; alternating ones must shrink.
        let standstill = |oscillates: bool| if oscillates { 1.0 } else { r32.ln() / r21.ln() };
        let moved = 2.0 * least / FLOOR_MARGIN;
        // Growth beyond what the digits can do is told whatever they hide of the smaller difference.
        let may_oscillate = coarse * fine < 0.0 && coarse.abs() > moved;
        let (oscillates, unresolved) = (coarse * fine < 0.0, fine.abs().min(coarse.abs()) <= least);
        if coarse.abs() + moved < standstill(may_oscillate).min(standstill(true)) * (fine.abs() - moved) {
            return Err(TripletError::Diverging { fine, coarse, oscillates: may_oscillate, certain: true });
        }
        if fine.is_nan() || coarse.is_nan() {
            return Err(TripletError::Unresolved { difference: f64::NAN, least });
        }
        if coarse.abs() <= standstill(oscillates) * fine.abs() && fine.abs() > moved {
            return Err(TripletError::Diverging { fine, coarse, oscillates, certain: false });
        }
        if unresolved {
            let difference = if fine.abs() > least { coarse } else { fine };
            return Err(TripletError::Unresolved { difference, least });
        }
        let order = match orders(coarse / fine, r21, r32)[..] {
            [order] => order,
            [] => return Err(TripletError::NoOrder { fine, coarse, oscillates }),
            [low, .., high] => return Err(TripletError::SeveralOrders { low, high }),
        };
        let growth = r21.powf(order) - 1.0;
        // Each value moves by the resolution; the derivative of the equation in p is at least ½ ln(r₂₁ r₃₂).
        let moved = moved * (1.0 / fine.abs() + 1.0 / coarse.abs());
        let limit = f1 - fine / growth;
        Ok(Self {
            order,
            uncertainty: moved / (0.5 * (r21 * r32).ln()),
            limit,
            approximate_error: (fine / f1).abs(),
            extrapolated_error: ((f1 - limit) / limit).abs(),
            gci: SAFETY * (fine / f1).abs() / growth,
            gci_coarse: SAFETY * (coarse / f2).abs() / (r32.powf(order) - 1.0),
            oscillates,
        })
    }

    /// The order as that of a power law, which differences of alternating signs do not follow.
    #[must_use]
    pub fn power_order(&self) -> Option<f64> {
        (!self.oscillates).then_some(self.order)
    }

    /// GCI₂₃/(r₂₁^p GCI₁₂), near 1 where the three grids are in the asymptotic range of order `p`: by construction for their
    /// own order on grids of equal ratios, a test for the expected one.
    #[must_use]
    pub fn asymptotic_ratio(points: [(f64, f64); 3], p: f64) -> f64 {
        let [(h1, f1), (h2, f2), (h3, f3)] = points;
        let (r21, r32) = (h2 / h1, h3 / h2);
        ((f3 - f2) / (r32.powf(p) - 1.0) / ((f2 - f1) / (r21.powf(p) - 1.0)) / r21.powf(p)).abs()
    }
}

/// All p in the range of orders with p ln r₂₁ = |ln |quotient| + q(p)|, q(p) = ln((r₂₁^p − s)/(r₃₂^p − s)); monotone differences
/// must shrink, so that their sign of the right-hand side is fixed and at most one order is left.
fn orders(quotient: f64, r21: f64, r32: f64) -> Vec<f64> {
    let s = quotient.signum();
    let inner = |p: f64| quotient.abs().ln() + ((r21.powf(p) - s) / (r32.powf(p) - s)).ln();
    let outer = |p: f64| if s < 0.0 { inner(p).abs() } else { inner(p) };
    let equation = |p: f64| p * r21.ln() - outer(p);
    let at = |k: u32| ORDERS.0 + (ORDERS.1 - ORDERS.0) * f64::from(k) / f64::from(PIECES);
    let bracketed = (0..PIECES).map(|k| (at(k), at(k + 1))).filter(|(a, b)| equation(*a) * equation(*b) <= 0.0);
    let mut roots: Vec<f64> = bracketed.filter_map(|(a, b)| root([a, b], equation)).collect();
    roots.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    roots
}
