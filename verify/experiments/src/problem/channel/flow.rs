//! Exact flows between two plates, u_t = γ cos ωt + ν u_yy on |y| ≤ 1, u(−1, t) = 0, u(1, t) = W cos ωt.

use std::f64::consts::PI;

use nalgebra::Complex;

use crate::problem::poiseuille_series;

/// What drives a flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Flow {
    /// Viscosity ν > 0.
    pub(super) nu: f64,
    /// Amplitude γ of the pressure gradient.
    pub(super) gamma: f64,
    /// Amplitude W of the velocity of the wall y = 1.
    pub(super) wall: f64,
    /// Angular frequency ω. For ω = 0 the flow starts from rest, for ω > 0 it is periodic.
    pub(super) omega: f64,
}

impl Flow {
    /// cos ωt, by which both drives vary.
    pub(super) fn phase(&self, t: f64) -> f64 {
        (self.omega * t).cos()
    }

    /// The velocity at |y| ≤ 1 and t ≥ 0.
    pub(super) fn velocity(&self, y: f64, t: f64) -> f64 {
        if self.omega == 0.0 {
            let tau = self.nu * t;
            // The arguments are in the domain of the series.
            let pressure = poiseuille_series::velocity(self.gamma / self.nu, y, tau).unwrap_or(f64::NAN);
            return pressure + if self.wall == 0.0 { 0.0 } else { self.wall * started_wall(1.0 - y, tau) };
        }
        let frequency = Complex::new(0.0, self.omega);
        let kappa = (frequency / self.nu).sqrt();
        let amplitude = pressure_profile(kappa, y) / frequency * self.gamma + wall_profile(kappa, y) * self.wall;
        (amplitude * (frequency * t).exp()).re
    }
}

/// 1 − cosh κy/cosh κ = (1 − e^{−κ(1+y)})(1 − e^{−κ(1−y)})/(1 + e^{−2κ}), Re κ > 0: no cancellation and no overflow.
fn pressure_profile(kappa: Complex<f64>, y: f64) -> Complex<f64> {
    one_minus_exp(kappa * (1.0 + y)) * one_minus_exp(kappa * (1.0 - y)) / ((kappa * -2.0).exp() + 1.0)
}

/// sinh κ(1+y)/sinh 2κ = e^{−κ(1−y)} (1 − e^{−2κ(1+y)})/(1 − e^{−4κ}), Re κ > 0.
fn wall_profile(kappa: Complex<f64>, y: f64) -> Complex<f64> {
    (kappa * (y - 1.0)).exp() * one_minus_exp(kappa * (2.0 * (1.0 + y))) / one_minus_exp(kappa * 4.0)
}

/// 1 − e^{−z} for Re z ≥ 0, accurate for small z.
fn one_minus_exp(z: Complex<f64>) -> Complex<f64> {
    let half = (0.5 * z.im).sin();
    Complex::new(-(-z.re).exp_m1() * z.im.cos() + 2.0 * half * half, (-z.re).exp() * z.im.sin())
}

/// Time at which the expansions of [`started_wall`] are exchanged; each takes a few terms on its side.
const CROSSOVER: f64 = 0.5;

/// The flow of a wall that is set in motion with velocity 1 at τ = 0, at the distance d from it, the other wall at d = 2.
fn started_wall(d: f64, tau: f64) -> f64 {
    if tau < CROSSOVER { images(d, tau) } else { modes(d, tau) }
}

/// 1 − d/2 − Σ_k (2/kπ) sin(kπd/2) e^{−(kπ/2)² τ}.
fn modes(d: f64, tau: f64) -> f64 {
    let mut transient = 0.0;
    for k in 1.. {
        let mu = 0.5 * PI * f64::from(k);
        let decay = mu * mu * tau;
        if decay > 45.0 {
            break; // e^{−45} is 2e-4 roundoffs
        }
        transient += (mu * d).sin() * (-decay).exp() / mu;
    }
    1.0 - 0.5 * d - transient
}

/// Σ_n erfc((4n + d)/2√τ) − erfc((4n + 4 − d)/2√τ): the wall and its images.
fn images(d: f64, tau: f64) -> f64 {
    let erfc = |x: f64| if tau == 0.0 { f64::from(x == 0.0) } else { libm::erfc(x / (2.0 * tau.sqrt())) };
    let mut sum = 0.0;
    for n in 0.. {
        let wave = erfc(4.0 * f64::from(n) + d) - erfc(4.0 * f64::from(n + 1) - d);
        sum += wave;
        if wave <= 1e-3 * f64::EPSILON * sum {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOWS: [Flow; 6] = [
        Flow { nu: 1.0, gamma: 2.0, wall: 0.0, omega: 0.0 },
        Flow { nu: 0.3, gamma: 0.0, wall: 1.5, omega: 0.0 },
        Flow { nu: 1.0, gamma: 2.0, wall: 0.0, omega: 4.0 },
        Flow { nu: 0.2, gamma: 0.0, wall: 1.0, omega: 3.0 },
        Flow { nu: 1e-3, gamma: 1.0, wall: 1.0, omega: 50.0 },
        Flow { nu: 1.0, gamma: 1.0, wall: 1.0, omega: 1e-3 },
    ];

    /// u_t = γ cos ωt + ν u_yy, with both derivatives by central differences of fourth order.
    #[test]
    fn the_flows_satisfy_the_equation_and_the_walls() {
        for flow in FLOWS {
            let thickness = if flow.omega > 0.0 { (flow.nu / flow.omega).sqrt().min(1.0) } else { 1.0 };
            for t in [0.2, 0.7, 3.0] {
                let wall = flow.wall * flow.phase(t);
                assert!(flow.velocity(-1.0, t).abs() <= f64::EPSILON * (1.0 + wall.abs()));
                assert!((flow.velocity(1.0, t) - wall).abs() <= 8.0 * f64::EPSILON * (1.0 + flow.omega * t));
                for y in [-0.9, -0.3, 0.0, 0.55, 0.97] {
                    let (dy, dt) = (2e-3 * thickness, 5e-4 / (1.0 + flow.omega));
                    let u = |i: f64, j: f64| flow.velocity(y + i * dy, t + j * dt);
                    let rate = (u(0.0, -2.0) - 8.0 * u(0.0, -1.0) + 8.0 * u(0.0, 1.0) - u(0.0, 2.0)) / (12.0 * dt);
                    let bend = (-u(-2.0, 0.0) + 16.0 * u(-1.0, 0.0) - 30.0 * u(0.0, 0.0) + 16.0 * u(1.0, 0.0)
                        - u(2.0, 0.0))
                        / (12.0 * dy * dy);
                    let residual = rate - flow.gamma * flow.phase(t) - flow.nu * bend;
                    // Roundoff 5 ε u/dy² and 1.5 ε u/dt of values up to 2, and (δ/scale)⁴ of the terms, a few of order 1 + ω.
                    let bound = 10.0 * f64::EPSILON * (flow.nu / (dy * dy) + 1.0 / dt) + 2e-10 * (1.0 + flow.omega);
                    assert!(residual.abs() < bound, "{flow:?} at ({y}, {t}): {residual:e} > {bound:e}");
                }
            }
        }
    }

    /// Where both expansions converge they agree to roundoff, so that neither has lost a term.
    #[test]
    fn the_expansions_of_the_started_wall_agree() {
        for tau in [0.05, 0.2, CROSSOVER, 1.0, 2.0] {
            for d in [0.0, 0.1, 0.8, 1.5, 2.0] {
                let (a, b) = (images(d, tau), modes(d, tau));
                assert!((a - b).abs() <= 8.0 * f64::EPSILON, "d = {d}, τ = {tau}: {a} and {b}");
            }
        }
        assert_eq!((started_wall(0.0, 0.0), started_wall(0.5, 0.0)), (1.0, 0.0));
    }

    /// Slow oscillation passes through the steady profiles: quadratic of γ, linear of the wall.
    #[test]
    fn slow_flows_are_nearly_steady() {
        let flow = Flow { nu: 2.0, gamma: 3.0, wall: 0.7, omega: 1e-9 };
        for y in [-1.0_f64, -0.4, 0.0, 0.8, 1.0] {
            let steady = 0.5 * 3.0 / 2.0 * (1.0 - y * y) + 0.7 * 0.5 * (1.0 + y);
            assert!((flow.velocity(y, 0.0) - steady).abs() < 1e-8, "{y}"); // first order in ω
        }
    }
}
