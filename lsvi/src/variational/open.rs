//! Whether a closure whose α + β vanishes as h → 0 leaves a step open.
//!
//! On a path that stays at q₀ the derivative of its equations in the unknowns is A/h + B + hC, and A cancels in the momenta up to α + β. Along a left
//! null vector of A/h + B the equations say nothing: a step is what the curvature of f, in C, and roundings make of it.

use crate::discrete::{DiscreteLegendre, Interval, MomentumWeights};
use crate::linalg::{Jacobian, NumericalRank};

use super::repeat;

/// Weights of the derivative for steps of so many h: together they leave A/h + B as it is, and nothing of hC.
const STEPS: [(f64, f64); 3] = [(0.5, -2.0 / 3.0), (1.0, 3.0), (2.0, -4.0 / 3.0)];

/// Parts of a step that are looked at.
const SHORTER: [f64; 5] = [1.0, 1.0 / 32.0, 1.0 / 1024.0, 1.0 / 32768.0, 1.0 / 1048576.0];

/// A/h + B, the sizes of what cancels in it, and their work space.
#[derive(Debug)]
pub(super) struct Condition {
    matrix: Jacobian,
    sizes: Jacobian,
    part: Jacobian,
    still: Vec<f64>,
    rank: NumericalRank,
    factorizations: u64,
}

impl Condition {
    pub(super) fn new(discrete: &dyn DiscreteLegendre, unknowns: usize) -> Self {
        let structure = discrete.structure();
        let matrix = Jacobian::with_structure(unknowns, &structure);
        let still = vec![0.0; unknowns];
        Self {
            sizes: matrix.clone(),
            part: matrix.clone(),
            matrix,
            still,
            rank: NumericalRank::new(unknowns, &structure),
            factorizations: 0,
        }
    }

    /// Matrices built and factored so far.
    pub(super) fn factorizations(&self) -> u64 {
        self.factorizations
    }

    /// Whether it leaves open a step from q₀.
    ///
    /// What cancels is of the size of M/h, J and hJᵀJ together: of shorter steps, or longer ones, another part hides the slow components, so
    /// that a step is open where none of them tells otherwise.
    pub(super) fn is_open(
        &mut self,
        discrete: &mut dyn DiscreteLegendre,
        weights: MomentumWeights,
        at: Interval,
        q0: &[f64],
    ) -> bool {
        repeat(q0, &mut self.still);
        SHORTER.into_iter().all(|part| self.is_deficient(discrete, weights, Interval { h: part * at.h, ..at }))
    }

    /// Whether A/h + B of the path that stays is singular to its roundings.
    fn is_deficient(&mut self, discrete: &mut dyn DiscreteLegendre, weights: MomentumWeights, at: Interval) -> bool {
        let Self { matrix, sizes, part, still, rank, factorizations } = self;
        let q0 = &still[..discrete.dim()];
        matrix.clear();
        for (steps, weight) in STEPS {
            part.clear();
            discrete.add_derivative(Interval { h: steps * at.h, ..at }, q0, still, weights, part);
            part.for_each(|i, j, x| matrix.add(i, j, weight * x));
        }
        sizes.clear();
        for momentum in [MomentumWeights { beta: 0.0, ..weights }, MomentumWeights { alpha: 0.0, ..weights }] {
            part.clear();
            discrete.add_derivative(at, q0, still, momentum, part);
            part.for_each(|i, j, x| sizes.add(i, j, x.abs()));
        }
        *factorizations += 1;
        rank.is_deficient(matrix, sizes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closure::{Linear, LinearClosure};
    use crate::discrete::Trapezoidal;
    use crate::{AutoField, FieldFn, LeastSquares, Scalar};

    /// A component at a rate of its own, which a fast one follows.
    struct Rates {
        fast: f64,
        own: f64,
    }

    impl FieldFn for Rates {
        fn dim(&self) -> usize {
            2
        }

        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = v[0] * -self.own;
            dv[1] = (v[1] - v[0]) * -self.fast;
        }
    }

    /// Whether a step of 1 is open by Method II, and how many matrices told.
    fn open(fast: f64, own: f64) -> (bool, u64) {
        let mut discrete = Trapezoidal::new(LeastSquares::new(AutoField::new(Rates { fast, own })).expect("dense"));
        let mut condition = Condition::new(&discrete, 2);
        let at = Interval { start: 0.0, h: 1.0 };
        let is_open = condition.is_open(&mut discrete, Linear::METHOD_II.weights(1.0), at, &[1.0, 0.0]);
        (is_open, condition.factorizations())
    }

    /// B is −2J, of the size of the rates; beside the slow one stand 1/h and what hJᵀJ has of the fast one.
    #[test]
    fn shorter_steps_tell_a_slow_component_from_roundings_of_a_fast_one() {
        for (fast, own, expected) in [
            (1.0, 1.0, (false, 1)),
            (1.0, 0.0, (true, 5)),
            (1.0, 1e-10, (false, 1)),
            // own/(h fast²) is 10⁻¹⁴, 3·10⁻¹³ beside 256 ε = 6·10⁻¹⁴; below, 10⁻¹⁵, 3·10⁻¹⁴, 10⁻¹².
            (1e4, 1e-6, (false, 2)),
            (1e4, 1e-7, (false, 3)),
            (1e4, 0.0, (true, 5)),
        ] {
            assert_eq!(open(fast, own), expected, "{fast}, {own}");
        }
    }
}
