//! Start-up Poiseuille flow with one shape function, Eqs. (35)–(41).

use lsvi::{AutoField, FieldFn, HessianWeights, Jacobian, Lagrangian, Scalar, VectorField};

use super::{Limit, Problem, Spec, poiseuille_series};
use crate::kinds::Principle;
use crate::names::Parameter;
use crate::reference::Ode;

pub(super) const SPEC: Spec = Spec {
    name: "poiseuille-ansatz",
    summary: "û = v(t)(1 − y²), v(0) = 0, in u_t = γ + u_yy: Lagrangian (37), reduced ODE by average (41) or Galerkin",
    parameters: &[
        Parameter { name: "gamma", default: "2", meaning: "pressure gradient γ" },
        Parameter { name: "v0", default: "0", meaning: "initial centre velocity; the exact flow starts at rest" },
        Parameter {
            name: "reduction",
            default: "averaged",
            meaning: "averaged or galerkin: the ODE that the methods without a Lagrangian integrate",
        },
    ],
    build: |p| {
        let reduction =
            p.choice("reduction", &[("averaged", Reduction::Averaged), ("galerkin", Reduction::Galerkin)])?;
        Ok(Box::new(PoiseuilleAnsatz::new(p.number("gamma")?, p.number("v0")?, reduction)))
    },
};

/// How the residual γ-equation is projected onto the one unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reduction {
    /// ∫ R̂ dy = 0: v̇ = (3/2)(γ − 2v), Eq. (41).
    Averaged,
    /// ∫ R̂ (1 − y²) dy = 0: v̇ = (5/4)(γ − 2v).
    Galerkin,
}

/// v̇ = rate (γ − 2v), the form of both reduced equations.
#[derive(Debug, Clone, Copy)]
struct Relaxation {
    rate: f64,
    gamma: f64,
}

/// The one-parameter flow û = v(t)(1 − y²).
#[derive(Debug)]
pub struct PoiseuilleAnsatz {
    gamma: f64,
    v0: f64,
    reduction: Reduction,
    averaged: Relaxation,
    galerkin: Relaxation,
    euler_lagrange: EulerLagrange,
}

impl PoiseuilleAnsatz {
    fn new(gamma: f64, v0: f64, reduction: Reduction) -> Self {
        Self {
            gamma,
            v0,
            reduction,
            averaged: Relaxation { rate: 1.5, gamma },
            galerkin: Relaxation { rate: 1.25, gamma },
            euler_lagrange: EulerLagrange { gamma },
        }
    }

    /// The flow from rest under the pressure gradient γ.
    pub fn from_rest(gamma: f64) -> Self {
        Self::new(gamma, 0.0, Reduction::Averaged)
    }

    fn reduced(&self) -> &Relaxation {
        match self.reduction {
            Reduction::Averaged => &self.averaged,
            Reduction::Galerkin => &self.galerkin,
        }
    }

    /// ½ ∫ R̂² dy over the channel by three-point Gauss quadrature, exact for the quartic R̂²; Eqs. (36), (37).
    pub fn action_density_by_quadrature(&self, v: f64, rate: f64) -> f64 {
        let node = 0.6_f64.sqrt();
        let rule = [(-node, 5.0 / 9.0), (0.0, 8.0 / 9.0), (node, 5.0 / 9.0)];
        rule.iter().map(|(y, w)| 0.5 * w * (-self.gamma + 2.0 * v + rate * (1.0 - y * y)).powi(2)).sum()
    }
}

impl FieldFn for Relaxation {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = (v[0] * -2.0 + self.gamma) * self.rate;
    }
}

impl Ode for Relaxation {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = self.rate * self.gamma - 2.0 * self.rate * v[0];
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 0, -2.0 * self.rate);
    }
}

/// (16/15) v̈ = 8v − 4γ as a first-order system in (v, v̇): the Euler–Lagrange equation of (37).
#[derive(Debug)]
struct EulerLagrange {
    gamma: f64,
}

impl Ode for EulerLagrange {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = v[1];
        dv[1] = 7.5 * v[0] - 3.75 * self.gamma;
    }
    fn jacobian(&self, _t: f64, _v: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        add(0, 1, 1.0);
        add(1, 0, 7.5);
    }
}

/// L(v, v̇) = γ² − 4γv + 4v² + (4/3)(−γ + 2v) v̇ + (8/15) v̇², Eq. (37): it keeps a remainder where v̇ = f.
#[derive(Debug, Clone, Copy)]
struct Reduced {
    gamma: f64,
}

impl Lagrangian for Reduced {
    fn dim(&self) -> usize {
        1
    }
    fn value(&self, _t: f64, v: &[f64], rate: &[f64]) -> f64 {
        let (g, v, d) = (self.gamma, v[0], rate[0]);
        g * g - 4.0 * g * v + 4.0 * v * v + 4.0 / 3.0 * (-g + 2.0 * v) * d + 8.0 / 15.0 * d * d
    }
    fn gradient(&self, _t: f64, v: &[f64], rate: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        let excess = 2.0 * v[0] - self.gamma;
        dl_dq[0] = 4.0 * excess + 8.0 / 3.0 * rate[0];
        dl_dv[0] = 4.0 / 3.0 * excess + 16.0 / 15.0 * rate[0];
    }
    fn add_hessian(&self, _t: f64, _v: &[f64], _rate: &[f64], c: HessianWeights, out: &mut Jacobian) {
        out.add(0, 0, 8.0 * c.qq + 8.0 / 3.0 * (c.qv + c.vq) + 16.0 / 15.0 * c.vv);
    }
}

impl Problem for PoiseuilleAnsatz {
    fn components(&self) -> &'static [&'static str] {
        &["v"]
    }
    fn initial(&self) -> Vec<f64> {
        vec![self.v0]
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(self.reduced()))
    }
    fn own_lagrangian(&self) -> Option<Box<dyn Lagrangian + '_>> {
        Some(Box::new(Reduced { gamma: self.gamma }))
    }
    fn ode(&self) -> &dyn Ode {
        self.reduced()
    }

    /// The centre velocity u(0, t) of the flow from rest, Eq. (42): not the solution of any reduced equation.
    fn exact(&self, t: f64) -> Option<Vec<f64>> {
        let from_rest = self.v0 == 0.0;
        from_rest.then(|| poiseuille_series::velocity(self.gamma, 0.0, t).ok().map(|u| vec![u])).flatten()
    }

    fn limit(&self, principle: Principle) -> Limit<'_> {
        let relaxation = |ode: &'static str, of: &Relaxation| {
            let (of, v0) = (*of, self.v0);
            (ode, move |t: f64| Some(vec![0.5 * of.gamma + (v0 - 0.5 * of.gamma) * (-2.0 * of.rate * t).exp()]))
        };
        let initial = vec![self.v0];
        match principle {
            Principle::Equation | Principle::Hamilton => {
                let (reason, exact) = relaxation("the reduced equation of the parameter `reduction`", self.reduced());
                let name = match self.reduction {
                    Reduction::Averaged => "averaged",
                    Reduction::Galerkin => "galerkin",
                };
                Limit { name, ode: self.reduced(), initial, exact: Box::new(exact), order: None, reason }
            }
            Principle::MomentumZero | Principle::MomentumMeanZero => {
                let is_mean = principle == Principle::MomentumMeanZero;
                let reason = if is_mean {
                    "p = ∂L/∂v̇ → 0 is the Galerkin equation: ∂L/∂v, which does not vanish on its solutions, because the \
                     Lagrangian (37) keeps a remainder, moves both momenta of a step by halves that cancel in their mean, \
                     and bends a path inside the step by O(h²)"
                } else {
                    "p = ∂L/∂v̇ → 0 is the Galerkin equation, and ∂L/∂v does not vanish on its solutions, because \
                     the Lagrangian (37) keeps a remainder that no v(t) from rest removes"
                };
                let (reason, exact) = relaxation(reason, &self.galerkin);
                Limit {
                    name: "galerkin",
                    ode: &self.galerkin,
                    initial,
                    exact: Box::new(exact),
                    order: Some(if is_mean { 2.0 } else { 1.0 }),
                    reason,
                }
            }
            // Closures with a rate of their own do not apply: each would have an equation of its own.
            Principle::MomentumConserved | Principle::MomentumDecaying => {
                let reason = "∂L/∂v = 0 is the domain-averaged equation (41); ∂L/∂v̇ does not vanish on its solutions, \
                              because the Lagrangian (37) keeps a remainder, and bends a path inside the step by O(h²)";
                let (reason, exact) = relaxation(reason, &self.averaged);
                Limit {
                    name: "averaged",
                    ode: &self.averaged,
                    initial,
                    exact: Box::new(exact),
                    order: Some(2.0),
                    reason,
                }
            }
            Principle::EulerLagrange => {
                let (k, steady) = (7.5_f64.sqrt(), 0.5 * self.gamma);
                let (w, rate) = (self.v0 - steady, -2.5 * (self.v0 - steady));
                Limit {
                    name: "euler-lagrange",
                    ode: &self.euler_lagrange,
                    initial: vec![self.v0, rate],
                    exact: Box::new(move |t| Some(vec![steady + w * (k * t).cosh() + rate / k * (k * t).sinh()])),
                    order: None,
                    reason: "the Euler–Lagrange equation of (37) with p(0) = 0",
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The series is that of the flow from rest.
    #[test]
    fn no_exact_solution_is_told_of_another_start() {
        let of = |v0: f64| PoiseuilleAnsatz::new(2.0, v0, Reduction::Averaged).exact(1.0);
        assert!(of(0.0).is_some() && of(0.5).is_none());
    }

    proptest! {
        /// Eq. (37) in closed form and by quadrature of ½ R̂²: a dozen roundings of terms up to 4 (1 + |v| + |v̇|)² each.
        #[test]
        fn the_lagrangian_is_half_the_squared_residual(v in -3.0..3.0, rate in -3.0..3.0, gamma in -3.0..3.0) {
            let problem = PoiseuilleAnsatz::new(gamma, 0.0, Reduction::Averaged);
            let closed = problem.lagrangian().expect("its own").value(0.0, &[v], &[rate]);
            let quadrature = problem.action_density_by_quadrature(v, rate);
            prop_assert!((closed - quadrature).abs() <= 16.0 * f64::EPSILON * 4.0 * 49.0, "{closed} and {quadrature}");
        }

        /// The derivatives are those of the quadratic: central differences are exact but for roundoff ε L/e.
        #[test]
        fn the_gradient_is_the_derivative(v in -3.0..3.0, rate in -3.0..3.0, gamma in -3.0..3.0) {
            let l = Reduced { gamma };
            let (mut dq, mut dv) = ([0.0], [0.0]);
            l.gradient(0.0, &[v], &[rate], &mut dq, &mut dv);
            let e = 1e-3;
            let by_v = (l.value(0.0, &[v + e], &[rate]) - l.value(0.0, &[v - e], &[rate])) / (2.0 * e);
            let by_rate = (l.value(0.0, &[v], &[rate + e]) - l.value(0.0, &[v], &[rate - e])) / (2.0 * e);
            prop_assert!((dq[0] - by_v).abs() < 1e-10 && (dv[0] - by_rate).abs() < 1e-10);
        }
    }

    /// On the Galerkin solution ∂L/∂v̇ = 0, on the averaged one ∂L/∂v = 0.
    #[test]
    fn the_two_reductions_are_the_two_derivatives() {
        let gamma = 2.0;
        let (mut dq, mut dv) = ([0.0], [0.0]);
        for v in [0.0, 0.4, 1.0] {
            Reduced { gamma }.gradient(0.0, &[v], &[1.25 * (gamma - 2.0 * v)], &mut dq, &mut dv);
            assert!(dv[0].abs() < 1e-14);
            Reduced { gamma }.gradient(0.0, &[v], &[1.5 * (gamma - 2.0 * v)], &mut dq, &mut dv);
            assert!(dq[0].abs() < 1e-14);
        }
    }
}
