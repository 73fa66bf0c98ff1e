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
    use crate::linalg::ROUNDINGS;
    use crate::{LeastSquares, field};

    /// Whether a step of ½ is open by Method II where a fast component follows one with a rate of its own, and how many matrices told.
    fn open(fast: f64, own: f64) -> (bool, u64) {
        let rates = field!(2, fast = fast, own = own; |_t, v, dv| {
            dv[0] = v[0] * -own;
            dv[1] = (v[1] - v[0]) * -fast;
        });
        let mut discrete = Trapezoidal::new(LeastSquares::new(rates).expect("dense"));
        let mut condition = Condition::new(&discrete, 2);
        let at = Interval { start: 0.0, h: 0.5 };
        let is_open = condition.is_open(&mut discrete, Linear::METHOD_II.weights(at.h), at, &[1.0, 0.0]);
        (is_open, condition.factorizations())
    }

    /// B is −2J, of the size of the rates; beside the slow one stand 1/h and what hJᵀJ has of the fast one.
    #[test]
    fn shorter_steps_tell_a_slow_component_from_roundings_of_a_fast_one() {
        for (fast, own, expected) in [
            (1.0, 1.0, (false, 1)),
            (1.0, 0.0, (true, 5)),
            (1.0, 1e-10, (false, 1)),
            // own/(h fast²) is 5·10⁻¹⁵, 1.6·10⁻¹³ beside 256 ε = 5.7·10⁻¹⁴; below, 10⁻¹⁵, 3·10⁻¹⁴, 10⁻¹².
            (2e4, 1e-6, (false, 2)),
            (2e4, 2e-7, (false, 3)),
            (2e4, 0.0, (true, 5)),
        ] {
            assert_eq!(open(fast, own), expected, "{fast}, {own}");
        }
    }

    /// K = −J + hJ²/2 comes of terms 1/h in p₀, and 1/h and little besides in p₁: one counts beside both.
    #[test]
    fn what_is_left_of_momenta_counts_beside_either() {
        for (part, is_open) in [(0.9, true), (1.1, false)] {
            let h = 0.5;
            let own = part * ROUNDINGS * f64::EPSILON * 2.0 / h;
            let decay = field!(1, own = own; |_t, v, dv| dv[0] = v[0] * -own);
            let mut discrete = Trapezoidal::new(LeastSquares::new(decay).expect("dense"));
            let mut condition = Condition::new(&discrete, 1);
            let found =
                condition.is_open(&mut discrete, Linear::METHOD_II.weights(h), Interval { start: 0.0, h }, &[1.0]);
            assert_eq!(found, is_open, "{own}");
        }
    }
}
