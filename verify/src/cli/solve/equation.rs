//! What is asked of an equation while a run is followed: its derivative, a bound of its growth, and solutions of it.

use nalgebra::DMatrix;
use verify::measure::norm::Extremes;
use verify::problem::Problem;
use verify::reference::{self, Ode};

/// Largest system whose derivatives are looked at as a dense matrix.
pub(super) const DENSE: usize = 64;

/// The tolerance of a reference that tells how far a step should have gone, which has to be well beyond it.
pub(super) const COURSE: f64 = 1e-10;

/// The solution from a state at a time, as a reference has it at these times; none where it fails.
pub(super) fn solution(
    ode: &dyn Ode,
    (start, from): (f64, &[f64]),
    times: &[f64],
    tolerance: f64,
) -> Option<Vec<Vec<f64>>> {
    Some(reference::by_name("diffsol-bdf")?.run(ode, start, from, times, tolerance).ok()?.states)
}

/// Gershgorin's bound of the real parts of the eigenvalues, which costs less than these.
pub(super) fn abscissa_bound(a: &DMatrix<f64>) -> f64 {
    let off_diagonal = |i: usize| a.row(i).iter().map(|x| x.abs()).sum::<f64>() - a[(i, i)].abs();
    (0..a.nrows()).map(|i| a[(i, i)] + off_diagonal(i)).largest()
}

/// ∂f/∂v as a dense matrix.
pub(super) fn jacobian(problem: &dyn Problem, t: f64, v: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(v.len(), v.len());
    problem.ode().jacobian(t, v, &mut |i, j, x| matrix[(i, j)] += x);
    matrix
}

/// A model of this text.
#[cfg(test)]
pub(super) fn model(text: &str) -> verify::problem::model::Model {
    verify::problem::model::Model::of_text(text, &[], None).expect("a model")
}

/// v̇ = rate v.
#[cfg(test)]
pub(super) fn growing(rate: f64) -> Box<dyn Problem> {
    verify::problem::build("linear-drag", &[("lambda".into(), (-rate).to_string())]).expect("registered")
}

/// The method of this name.
#[cfg(test)]
pub(super) fn by(name: &str) -> Box<dyn verify::method::Method> {
    verify::method::parse(name).expect("registered")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Discs about −3 and −4 with radii 1 and 2, and about 5 with none.
    #[test]
    fn growth_is_bounded_by_the_rightmost_of_gershgorins_discs() {
        let discs = |a: &[f64], n: usize| abscissa_bound(&DMatrix::from_row_slice(n, n, a));
        assert_eq!(discs(&[-3.0, -1.0, 2.0, -4.0], 2), -2.0);
        assert_eq!(discs(&[-3.0, 1.0, 0.0, 2.0, -4.0, 0.0, 0.0, 0.0, 5.0], 3), 5.0);
    }
}
