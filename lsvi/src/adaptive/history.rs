//! The collocation polynomial of the last accepted step.

use super::coefficients::Coefficients;
use crate::error::{InputError, TimeError};

/// v(t + c h) = v + Σ ℓⱼ(c) Zⱼ on the last step: between its ends the dense output, beyond them the next step's first guess.
#[derive(Debug)]
pub(super) struct History {
    pub(super) last: Option<Last>,
    /// Zᵢ, component by component.
    pub(super) z: Vec<f64>,
    /// v at both ends.
    pub(super) from: Vec<f64>,
    pub(super) to: Vec<f64>,
}

/// Which step it was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Last {
    /// Start.
    pub(super) t: f64,
    pub(super) h: f64,
    /// The end, as the state was given it.
    pub(super) end: f64,
    /// Number of stages.
    pub(super) s: usize,
}

impl History {
    pub(super) fn new(n: usize, most: usize) -> Self {
        Self { last: None, z: vec![0.0; n * most], from: vec![0.0; n], to: vec![0.0; n] }
    }

    /// The last step, if it contains `t`.
    pub(super) fn at(&self, t: f64) -> Result<Last, InputError> {
        match self.last {
            None => Err(InputError::Time(TimeError::NoStep { t })),
            Some(last) if t >= last.t && t <= last.end => Ok(last),
            Some(Last { t: from, end: to, .. }) => Err(InputError::Time(TimeError::Outside { t, from, to })),
        }
    }

    /// Writes v at the part c of the last step, of S stages.
    pub(super) fn value<const S: usize>(&self, coefficients: &Coefficients<S>, c: f64, out: &mut [f64]) {
        let weights = coefficients.weights(c);
        for ((o, v), z) in out.iter_mut().zip(&self.from).zip(self.z.as_chunks::<S>().0) {
            *o = v + super::coefficients::dot(&weights, z);
        }
    }

    /// Writes the values of the polynomial at the parts `c` of a next step, `ratio` times as long, less that at its start.
    pub(super) fn extrapolate<const S: usize, const N: usize>(
        &self,
        coefficients: &Coefficients<S>,
        c: &[f64; N],
        ratio: f64,
        out: &mut [f64],
    ) {
        let mut weights = c.map(|c| coefficients.weights(1.0 + c * ratio));
        // The last node is the end of the step.
        weights.iter_mut().for_each(|w| w[S - 1] -= 1.0);
        for (out, z) in out.as_chunks_mut::<N>().0.iter_mut().zip(self.z.as_chunks::<S>().0) {
            for (o, w) in out.iter_mut().zip(&weights) {
                *o = super::coefficients::dot(w, z);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptive::coefficients::three;

    #[test]
    fn the_polynomial_of_a_step_goes_on_through_the_next_one_of_another_size() {
        let c = three().expect("known");
        let mut history = History::new(1, 3);
        // t² on a step from 0 to 1.
        history.z.copy_from_slice(&c.nodes.map(|c| c * c));
        for ratio in [0.1, 1.0, 2.0] {
            let mut z = [0.0; 3];
            history.extrapolate(c, &c.nodes, ratio, &mut z);
            for (z, c) in z.iter().zip(&c.nodes) {
                // A few roundings of ℓⱼ(3), which are below 50.
                approx::assert_abs_diff_eq!(*z, (1.0 + ratio * c).powi(2) - 1.0, epsilon = 1e-13);
            }
        }
    }
}
