//! Start-up of plane Poiseuille flow, u_t = γ + u_yy on |y| ≤ 1, u(±1, t) = 0, u(y, 0) = 0: the exact solution Eq. (34).
//!
//! The eigenfunction series converges slowly near t = 0 and the series of images slowly for large t; each is used where it
//! takes a dozen terms. Both are written in the distance d = 1 − |y| from the wall, in which no term cancels as d → 0, so
//! that u is accurate relative to its own size, near the wall and for small t too.

use std::f64::consts::{FRAC_2_SQRT_PI, PI};

/// The slowest rate of decay towards the steady profile, π²/4.
pub const SLOWEST_DECAY_RATE: f64 = PI * PI / 4.0;

/// Time at which the expansions are exchanged. Below it the images' terms are so small (e^{−36} at the wall) that what
/// they cancel does not show in u; above it the modes lose at most a factor of 20 to the steady part.
const CROSSOVER: f64 = 1.0 / 36.0;

/// A point outside of |y| ≤ 1, t ≥ 0, or a pressure gradient that is not finite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("start-up Poiseuille flow is defined for finite γ, |y| ≤ 1 and t ≥ 0, not for γ = {gamma}, y = {y}, t = {t}")]
pub struct DomainError {
    /// Pressure gradient.
    pub gamma: f64,
    /// Position across the channel.
    pub y: f64,
    /// Time.
    pub t: f64,
}

/// The velocity u(y, t) under the pressure gradient `gamma`, to a few units of roundoff relative to its size.
///
/// # Errors
/// [`DomainError`] for |y| > 1, t < 0, a non-finite γ or a NaN.
pub fn velocity(gamma: f64, y: f64, t: f64) -> Result<f64, DomainError> {
    let d = distance(gamma, y, t)?;
    Ok(gamma * if t < CROSSOVER { images(d, t) } else { modes(d, t) })
}

/// The velocity by modes and by images, each at any time, for the study that holds the two against each other.
pub fn by_modes_and_by_images(gamma: f64, y: f64, t: f64) -> Result<[f64; 2], DomainError> {
    let d = distance(gamma, y, t)?;
    Ok([gamma * modes(d, t), gamma * images(d, t)])
}

/// Distance from the nearer wall.
fn distance(gamma: f64, y: f64, t: f64) -> Result<f64, DomainError> {
    if gamma.is_finite() && y.abs() <= 1.0 && t >= 0.0 { Ok(1.0 - y.abs()) } else { Err(DomainError { gamma, y, t }) }
}

/// The steady profile ½γ(1 − y²).
///
/// # Errors
/// [`DomainError`] for |y| > 1, a non-finite γ or a NaN.
pub fn steady(gamma: f64, y: f64) -> Result<f64, DomainError> {
    velocity(gamma, y, f64::INFINITY)
}

/// A value of the solution known to more digits than a double has.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub struct Tabulated {
    /// Position.
    pub y: f64,
    /// Time.
    pub t: f64,
    /// u(y, t) for γ = 2, rounded to a double.
    pub u: f64,
}

const TABLE: &str = include_str!("../../../data/poiseuille-series.csv");

/// Values for γ = 2 computed by two methods in arithmetic of [`digits`]; `verify/data/poiseuille-series.py` wrote them.
///
/// # Errors
/// [`csv::Error`] if the table is malformed.
pub fn tabulated() -> Result<Vec<Tabulated>, csv::Error> {
    csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(TABLE.as_bytes()).deserialize().collect()
}

/// The digits of the arithmetic that the table was computed in, as it says itself.
pub fn digits() -> u32 {
    super::tabulated::digits(TABLE).unwrap_or(0)
}

/// u/γ = ½d(2 − d) − Σ_k 2 sin(μ_k d) e^{−μ_k² t}/μ_k³ with μ_k = (k + ½)π. In y, sin(μ_k d) is (−1)^k cos(μ_k y).
fn modes(d: f64, t: f64) -> f64 {
    let mut transient = 0.0;
    for k in 0.. {
        let mu = (f64::from(k) + 0.5) * PI;
        // Relative to the first term, since |sin(μ_k d)|/μ_k³ ≤ d/μ_k² decreases: e^{−45} is 2e-4 roundoffs.
        let decay = mu * mu * t;
        if k > 0 && decay > 45.0 {
            break;
        }
        transient += 2.0 * (mu * d).sin() * (-decay).exp() / mu.powi(3);
    }
    0.5 * d * (2.0 - d) - transient
}

/// u/γ = t [1 − Σ_n (−1)ⁿ (E(2n + d) + E(2n + 2 − d))], E(x) = 4 i²erfc(x/2√t): the diffusion of −t from both walls and
/// its images. The first wave is taken together with the 1, the others in pairs that vanish at the wall.
fn images(d: f64, t: f64) -> f64 {
    if t == 0.0 {
        return 0.0;
    }
    let z = |x: f64| x / (2.0 * t.sqrt());
    let (mut reflected, mut sign) = (0.0, 1.0);
    for n in 1.. {
        let wall = 2.0 * f64::from(n);
        reflected += sign * (four_i2erfc(z(wall - d)) - four_i2erfc(z(wall + d)));
        sign = -sign;
        if z(wall + 1.0) > ERFC_UNDERFLOWS {
            break; // the next wave starts at wall + 2 − d
        }
    }
    t * (one_minus_four_i2erfc(z(d)) - reflected)
}

/// erfc(z) and exp(−z²) are zero in double precision beyond this z.
const ERFC_UNDERFLOWS: f64 = 28.0;

/// 4 i²erfc(z) = (1 + 2z²) erfc z − (2/√π) z e^{−z²}, z ≥ 0, accurate absolutely.
fn four_i2erfc(z: f64) -> f64 {
    if z > ERFC_UNDERFLOWS {
        return 0.0;
    }
    (1.0 + 2.0 * z * z) * libm::erfc(z) - FRAC_2_SQRT_PI * z * (-z * z).exp()
}

/// 1 − 4 i²erfc(z), accurate relatively also for z → 0, where it is (4/√π) z.
fn one_minus_four_i2erfc(z: f64) -> f64 {
    if z > ERFC_UNDERFLOWS {
        return 1.0;
    }
    libm::erf(z) - 2.0 * z * z * libm::erfc(z) + FRAC_2_SQRT_PI * z * (-z * z).exp()
}

#[cfg(test)]
mod tests;
