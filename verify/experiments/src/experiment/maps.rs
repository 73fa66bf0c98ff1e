//! Maps v_n → v_{n+1} of the methods in closed form, written without the library.

use super::floors::{AVERAGED_RATE, GALERKIN_RATE};
use crate::measure::amplification::Amplification;
use crate::measure::search;

/// A closure whose factor on v̇ = −v the paper prints.
#[derive(Clone, Copy)]
pub struct Printed {
    /// Its name.
    pub name: &'static str,
    /// Its equation in \[S24\].
    pub equation: &'static str,
    /// Its weights.
    pub(crate) closure: Amplification,
    /// The printed factor as a function of h.
    pub factor: fn(f64) -> f64,
}

impl Printed {
    /// The closure of a name.
    pub(crate) fn of(name: &str) -> Option<Self> {
        PRINTED.into_iter().find(|printed| printed.name == name)
    }
}

/// Eqs. (21), (22), (25).
pub const PRINTED: [Printed; 3] = [
    Printed {
        name: "explicit-momentum",
        equation: "(21)",
        closure: Amplification { alpha: 1.0, beta: 0.0 },
        factor: |h| 1.0 - h + 0.5 * h * h,
    },
    Printed {
        name: "method-i",
        equation: "(22)",
        closure: Amplification { alpha: 0.0, beta: 1.0 },
        factor: |h| 1.0 / (1.0 + h + 0.5 * h * h),
    },
    Printed {
        name: "method-ii",
        equation: "(25)",
        closure: Amplification { alpha: -1.0, beta: 1.0 },
        factor: |h| (1.0 - 0.5 * h) / (1.0 + 0.5 * h),
    },
];

/// v_{n+1} of a method from v_n on a problem with default parameters.
pub(super) type Map = fn(method: &str, h: f64, v: f64) -> Option<f64>;

/// The map of a problem, where it is known.
pub(super) fn of(problem: &str) -> Option<Map> {
    Some(match problem {
        "linear-drag" => linear_drag,
        "quadratic-drag" => quadratic_drag,
        "poiseuille-ansatz" => averaged,
        "poiseuille-galerkin" => galerkin,
        _ => return None,
    })
}

/// The factor of one step on v̇ = −λ(v − v_∞), z = hλ, for the methods that integrate the equation.
fn stability_function(method: &str, z: f64) -> Option<f64> {
    Some(match method {
        "implicit-euler" => 1.0 / (1.0 + z),
        "rk4" => 1.0 - z * (1.0 - z / 2.0 * (1.0 - z / 3.0 * (1.0 - z / 4.0))),
        "trapezoidal" | "implicit-midpoint" => (1.0 - 0.5 * z) / (1.0 + 0.5 * z),
        _ => return None,
    })
}

/// One step on v̇ = −v.
pub fn linear_drag(method: &str, h: f64, v: f64) -> Option<f64> {
    let closure = PRINTED.iter().find(|printed| printed.name == method).map(|printed| (printed.factor)(h));
    Some(v * closure.or_else(|| stability_function(method, h))?)
}

/// One step on v̇ = −v². In W = h v_n and X = h v_{n+1} the closures' equations have integer coefficients.
fn quadratic_drag(method: &str, h: f64, v: f64) -> Option<f64> {
    let w = h * v;
    // The positive root of a X² + X = b without cancellation.
    let root = |a: f64, b: f64| 2.0 * b / (1.0 + (1.0 + 4.0 * a * b).sqrt());
    let x = match method {
        "implicit-euler" => root(1.0, w),
        "trapezoidal" => root(0.5, w - 0.5 * w * w),
        "implicit-midpoint" => 2.0 * root(0.5, w) - w,
        "rk4" => {
            let (half, f) = (0.5, |x: f64| -x * x);
            let k1 = f(w);
            let k2 = f(w + half * k1);
            let k3 = f(w + half * k2);
            w + (k1 + 2.0 * k2 + 2.0 * k3 + f(w + k3)) / 6.0
        }
        // X² + 2(1 − W)X = 2W − 3W² + 2W³, the root that continues X = W.
        "explicit-momentum" => {
            let b = w * (2.0 - w * (3.0 - 2.0 * w));
            let discriminant = (1.0 - w).powi(2) + b;
            b / (1.0 - w + discriminant.sqrt())
        }
        // For W ≤ 1 each has one positive root, and its left side increases there.
        "method-i" if w <= 1.0 => {
            search::root([0.0, w], |x| 2.0 * x.powi(3) + 3.0 * x * x + 2.0 * (1.0 - w) * x + w * w - 2.0 * w)?
        }
        "method-ii" if w <= 1.0 => search::root([0.0, w], |x| x * x * (1.0 + x) - w * w * (1.0 - w))?,
        _ => return None,
    };
    Some(x / h)
}

fn averaged(method: &str, h: f64, v: f64) -> Option<f64> {
    poiseuille(AVERAGED_RATE, method, h, v)
}

fn galerkin(method: &str, h: f64, v: f64) -> Option<f64> {
    poiseuille(GALERKIN_RATE, method, h, v)
}

/// One step on the Poiseuille ansatz with γ = 2: the closures by (38), (40) and p_n = 0 on the Lagrangian (37), all written for
/// the distance from the steady state ½γ = 1; the others on the reduced equation of this rate.
fn poiseuille(rate: f64, method: &str, h: f64, v: f64) -> Option<f64> {
    let factor = match method {
        "method-i" => 1.0 / (1.0 + 2.5 * h + 3.75 * h * h),
        "method-ii" => (1.0 - 1.5 * h) / (1.0 + 1.5 * h),
        "explicit-momentum" => 1.0 - 2.5 * h + 3.75 * h * h,
        _ => stability_function(method, h * rate)?,
    };
    Some(1.0 + (v - 1.0) * factor)
}
