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
        }
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
        SHORTER.into_iter().all(|part| self.is_deficient(discrete, weights, Interval { h: part * at.h, ..at }, q0))
    }

    fn is_deficient(
        &mut self,
        discrete: &mut dyn DiscreteLegendre,
        weights: MomentumWeights,
        at: Interval,
        q0: &[f64],
    ) -> bool {
        let Self { matrix, sizes, part, still, rank } = self;
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
        rank.is_deficient(matrix, sizes)
    }
}
