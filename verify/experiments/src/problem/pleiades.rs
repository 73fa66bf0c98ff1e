//! Seven stars in a plane that attract each other and pass close by ([HNW93] II.10).

use lsvi::{FieldFn, Jacobian, Scalar, VectorField};
use nalgebra::{Matrix2, Vector2};

use super::{Facts, Problem, Singular, Spec, Window, tabulated};
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "pleiades",
    summary: "seven stars of masses 1…7 in a plane, 28 unknowns, not stiff; published end value at t = 3",
    parameters: &[],
    build: |_| Ok(Box::new(Pleiades)),
};

#[derive(Debug)]
struct Pleiades;

const STARS: usize = 7;

/// The mass of star i.
fn mass(i: usize) -> f64 {
    (i + 1) as f64
}

impl Pleiades {
    /// All pairs, with the vector from the first star to the second.
    fn pairs(&self, v: &[f64]) -> impl Iterator<Item = (usize, usize, Vector2<f64>)> {
        let between = |i: usize, j: usize| Vector2::new(v[j] - v[i], v[STARS + j] - v[STARS + i]);
        (0..STARS).flat_map(move |i| (0..i).map(move |j| (i, j, between(i, j))))
    }
}

/// The first derivative of d/|d|³.
fn gradient(d: Vector2<f64>) -> Matrix2<f64> {
    let r2 = d.norm_squared();
    (Matrix2::identity() - d * d.transpose() * (3.0 / r2)) / (r2 * r2.sqrt())
}

/// The second derivative of a·d/|d|³.
fn hessian(a: Vector2<f64>, d: Vector2<f64>) -> Matrix2<f64> {
    let (r2, along) = (d.norm_squared(), a.dot(&d));
    let outer = a * d.transpose() + d * a.transpose() + Matrix2::identity() * along;
    (d * d.transpose() * (5.0 * along / r2) - outer) * (3.0 / (r2 * r2 * r2.sqrt()))
}

impl Ode for Pleiades {
    fn dim(&self) -> usize {
        4 * STARS
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        let (rate, acceleration) = dv.split_at_mut(2 * STARS);
        rate.copy_from_slice(&v[2 * STARS..]);
        acceleration.fill(0.0);
        for (i, j, d) in self.pairs(v) {
            let pull = d / d.norm().powi(3);
            for c in 0..2 {
                acceleration[c * STARS + i] += mass(j) * pull[c];
                acceleration[c * STARS + j] -= mass(i) * pull[c];
            }
        }
    }
    fn jacobian(&self, _t: f64, v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        for k in 0..2 * STARS {
            add(k, 2 * STARS + k, 1.0);
        }
        for (i, j, d) in self.pairs(v) {
            let slope = gradient(d);
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let x = slope[(a, b)];
                for (star, pull) in [(i, mass(j)), (j, -mass(i))] {
                    add((2 + a) * STARS + star, b * STARS + j, pull * x);
                    add((2 + a) * STARS + star, b * STARS + i, -pull * x);
                }
            }
        }
    }
}

/// Each star's attraction by every other.
impl FieldFn for Pleiades {
    fn dim(&self) -> usize {
        4 * STARS
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        for i in 0..STARS {
            let (mut ax, mut ay) = (T::from(0.0), T::from(0.0));
            for j in (0..STARS).filter(|j| *j != i) {
                let (dx, dy) = (v[j] - v[i], v[STARS + j] - v[STARS + i]);
                let pull = (dx * dx + dy * dy).sqrt().powi(-3) * mass(j);
                ax += dx * pull;
                ay += dy * pull;
            }
            dv[i] = v[2 * STARS + i];
            dv[STARS + i] = v[3 * STARS + i];
            dv[2 * STARS + i] = ax;
            dv[3 * STARS + i] = ay;
        }
    }
}

/// The generic statement with the derivatives by hand: automatic differentiation takes 28 sweeps for the Jacobian and 406
/// for the curvature.
struct ByHand;

impl VectorField for ByHand {
    fn dim(&self) -> usize {
        4 * STARS
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        FieldFn::rhs(&Pleiades, t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        Pleiades.jacobian(t, v, &mut |i, j, x| out.add(i, j, scale * x));
    }
    fn add_curvature(&self, _t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        Pleiades.curvature(v, w, |j, k, x| out.add(j, k, scale * x));
    }
}

impl Pleiades {
    /// Calls `add(j, k, x)` with contributions x to Σ_i w_i ∂²f_i/∂v_j∂v_k.
    fn curvature(&self, v: &[f64], w: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        for (i, j, d) in self.pairs(v) {
            let weight = |c: usize| mass(j) * w[(2 + c) * STARS + i] - mass(i) * w[(2 + c) * STARS + j];
            let bend = hessian(Vector2::new(weight(0), weight(1)), d);
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let x = bend[(a, b)];
                let (ai, aj, bi, bj) = (a * STARS + i, a * STARS + j, b * STARS + i, b * STARS + j);
                add(ai, bi, x);
                add(aj, bj, x);
                add(ai, bj, -x);
                add(aj, bi, -x);
            }
        }
    }
}

impl Problem for Pleiades {
    fn components(&self) -> &'static [&'static str] {
        &[
            "x1", "x2", "x3", "x4", "x5", "x6", "x7", "y1", "y2", "y3", "y4", "y5", "y6", "y7", "vx1", "vx2", "vx3",
            "vx4", "vx5", "vx6", "vx7", "vy1", "vy2", "vy3", "vy4", "vy5", "vy6", "vy7",
        ]
    }
    fn initial(&self) -> Vec<f64> {
        let [x, y] = [[3.0, 3.0, -1.0, -3.0, 2.0, -2.0, 2.0], [3.0, -3.0, 2.0, 0.0, 0.0, -4.0, 4.0]];
        let [vx, vy] = [[0.0, 0.0, 0.0, 0.0, 0.0, 1.75, -1.5], [0.0, 0.0, 0.0, -1.25, 1.0, 0.0, 0.0]];
        [x, y, vx, vy].concat()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(ByHand)
    }
    fn ode(&self) -> &dyn Ode {
        self
    }
    fn tabulated(&self, t: f64) -> Option<Vec<f64>> {
        tabulated::lookup("pleiades", t)
    }
    /// Up to t = 1, before the first close encounter.
    fn facts(&self) -> Facts {
        let reason =
            "forces depend on differences of places alone: J is singular, and Jᵀr₀ + Jᵀr₁ = 0 leaves the residual free";
        Facts {
            window: Window { horizon: 1.0, coarsest: 0.1 },
            singular: Some(Singular { reason, from: 0.0, before: None }),
            ..Facts::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::stability::Uniform;
    use lsvi::AutoField;

    /// Derivatives by hand are those of the generic statement, to the roundings of terms up to 1/d³ and 1/d⁴ of the least
    /// distance d, a few hundred of them.
    #[test]
    fn derivatives_by_hand_are_those_of_the_generic_statement() {
        let n = 4 * STARS;
        let generic = AutoField::new(Pleiades);
        let mut random = Uniform::new(7);
        for _ in 0..16 {
            let mut near = |size: f64| (0..n).map(|_| size * random.next().unwrap_or_default()).collect::<Vec<_>>();
            let (shift, w) = (near(0.3), near(1.0));
            let v: Vec<f64> = Pleiades.initial().iter().zip(shift).map(|(v, x)| v + x).collect();
            let fields: [&dyn VectorField; 2] = [&generic, &ByHand];
            let [jacobians, curvatures] = [false, true].map(|second| {
                fields.map(|field| {
                    let mut out = Jacobian::zeros(n);
                    if second {
                        field.add_curvature(0.0, &v, &w, 1.0, &mut out);
                    } else {
                        field.add_jacobian(0.0, &v, 1.0, &mut out);
                    }
                    out.to_dense()
                })
            });
            for [a, b] in [jacobians, curvatures] {
                assert!((&a - &b).amax() <= 1e3 * f64::EPSILON * (1.0 + a.amax()), "{}", (&a - &b).amax());
            }
        }
    }
}
