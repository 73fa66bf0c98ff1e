//! Linear combinations of components that an equation conserves and a run does not.

use nalgebra::DMatrix;
use verify::problem::{Problem, component_names};
use verify::reference::Ode;

use super::REST;
use super::past::Past;
use crate::cli::layout::number;
use crate::cli::solve::equation::jacobian;

/// Times of a run at which f is asked, where it depends on time.
pub(super) const LOOKS: u32 = 1024;

/// Singular values below this part of the largest are zero but for rounding, of f and in the decomposition.
const NULL: f64 = 1e-13;

/// The values of f at all rows of a small system, as columns of a matrix.
#[derive(Debug, Default)]
pub(super) struct Rates {
    unknowns: usize,
    /// Not the columns A themselves but, from a number of them on, n others with the same A Aᵀ.
    columns: Vec<f64>,
}

impl Rates {
    pub(super) fn add(&mut self, ode: &dyn Ode, t: f64, state: &[f64]) {
        self.unknowns = state.len();
        let (n, kept) = (state.len(), self.columns.len());
        self.columns.resize(kept + n, 0.0);
        ode.rhs(t, state, &mut self.columns[kept..]);
        if self.columns[kept..].iter().any(|x| !x.is_finite()) {
            self.columns.truncate(kept);
        }
        // Aᵀ = QR, A Aᵀ = Rᵀ R.
        if self.columns.len() >= 4 * n * n {
            let r = self.matrix().transpose().qr().r();
            self.columns = r.transpose().as_slice().to_vec();
        }
    }

    pub(super) fn matrix(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(self.unknowns, self.columns.len() / self.unknowns.max(1), &self.columns)
    }

    /// Linear combinations of the components that the equation conserves and the run does not.
    pub(super) fn broken(&self, past: &Past, problem: &dyn Problem, is_stuck: bool) -> Option<String> {
        let Past { first, last: (end, last), largest, .. } = past;
        let n = first.len();
        if n < 2 {
            return None;
        }
        // wᵀ f vanishes for all v where wᵀ ∂f/∂v does, here at states of the run and a point beside it, and wᵀ f does at each row, as f may
        // act between the ends alone. In units of the solution f is as large as ∂f/∂v, and so are its roundings.
        let beside = point_beside(*largest, n);
        let rates = self.matrix() / *largest;
        let [at_start, at_last, at_beside] =
            [(0.0, first), (*end, last), (*end, &beside)].map(|(t, v)| jacobian(problem, t, v));
        let parts = [&at_start, &at_last, &at_beside, &rates];
        let all = DMatrix::from_columns(&parts.iter().flat_map(|part| part.column_iter()).collect::<Vec<_>>());
        if all.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let svd = all.svd(true, false);
        let (vectors, values) = (svd.u?, svd.singular_values);
        let names = component_names(problem);
        let is_autonomous = problem.ode().is_autonomous() || problem.field().is_autonomous();
        let looks = if is_autonomous { 1 } else { LOOKS };
        (0..values.len()).filter(|k| values[*k] <= NULL * values.max()).find_map(|k| {
            let w = vectors.column(k);
            let change: f64 = w.iter().zip(last.iter().zip(first)).map(|(w, (b, a))| w * (b - a)).sum();
            let scale = w.amax();
            // Beside rates of another size altogether a small one looks like none.
            let kept = w.map(|w| if is_part(w, scale) { w } else { 0.0 });
            let terms = kept.iter().zip(rates.row_iter()).map(|(w, f)| (w * f.norm()).powi(2)).sum::<f64>().sqrt();
            let cancels = rates.tr_mul(&kept).norm() <= REST * terms;
            // Beside entries of ∂f/∂v of another size altogether, of which f makes nothing, a small one looks like none, too.
            let vanishes = |k: u32| {
                let mut f = vec![0.0; n];
                problem.ode().rhs(end * f64::from(k) / f64::from(looks), last, &mut f);
                let terms = kept.iter().zip(&f).map(|(w, f)| w * f);
                terms.clone().sum::<f64>().abs() <= 0.5 * terms.map(f64::abs).sum::<f64>()
            };
            let cancels = cancels && (1..=looks).all(vanishes);
            (cancels && change.abs() > REST * largest).then(|| {
                let terms = w.iter().zip(&names).filter(|(w, _)| is_part(**w, scale));
                let pivot = w[w.iamax()];
                let sum = terms.map(|(w, name)| format!("{:+.4} {name}", w / pivot)).collect::<Vec<_>>().join(" ");
                format!(
                    "the equation conserves {sum}, and the run changed it by {}; {}a Runge–Kutta method, which conserves it, helps",
                    number(change / pivot),
                    if is_stuck { "" } else { "a smaller h, or " }
                )
            })
        })
    }
}

/// Whether an entry of a vector is more than what roundings make of it.
fn is_part(w: f64, scale: f64) -> bool {
    w.abs() > REST * scale
}

/// A state of this size that is none in particular.
pub(super) fn point_beside(size: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| size * (1.0 + 0.5 * ((i + 1) as f64).sin())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::solve::equation::model;

    /// Rows of a small system stay as they are until there are as many as four matrices hold.
    #[test]
    fn rates_are_kept_in_a_bounded_space() {
        let turning = model("u_i { x = 1, y = 0 } F_i { y, -x }");
        let (mut rates, mut sum) = (Rates::default(), DMatrix::zeros(2, 2));
        for k in 1..=8 {
            let state = [f64::from(k), 1.0];
            rates.add(turning.ode(), 0.0, &state);
            let f = DMatrix::from_column_slice(2, 1, &[1.0, -f64::from(k)]);
            sum += &f * f.transpose();
            let kept = rates.matrix();
            assert_eq!(kept.ncols(), if k < 8 { k as usize } else { 2 });
            approx::assert_relative_eq!(&kept * kept.transpose(), sum, max_relative = 1e-14);
        }
    }

    /// What is said of a run between these states.
    fn told(f: &str, from: [f64; 2], to: [f64; 2]) -> Option<String> {
        let problem = model(&format!("u_i {{ x = 1, y = 0 }} F_i {{ {f} }}"));
        let past = Past::of(&[(0.0, from), (1.0, to)], None);
        let mut rates = Rates::default();
        [(0.0, from), (1.0, to)].iter().for_each(|(t, state)| rates.add(problem.ode(), *t, state));
        rates.broken(&past, &problem, true)
    }

    /// Twice x and y, a millionth of the largest component, 8, and by how much.
    #[test]
    fn a_sum_that_the_equation_conserves_and_the_run_does_not_is_told() {
        let f = "-0.01*x*y, 0.02*x*y";
        let changed = |by: f64| told(f, [8.0, 1.0], [7.0, 3.0 + 2.0 * by]);
        assert_eq!([changed(0.0), changed(7e-6)], [None, None]);
        let text = changed(0.1).expect("it is broken");
        assert!(
            text.starts_with("the equation conserves +1.0000 x +0.5000 y, and the run changed it by 0.100000"),
            "{text}"
        );
        assert!(changed(1e-5).is_some());
        // Of rates of any size.
        assert!(told("-1e4*x*y, 2e4*x*y", [8.0, 1.0], [7.0, 3.2]).is_some());
    }

    /// ẏ = y (y − 10⁸)/10⁸, which is at rest in both rows and conserves nothing, in units in which its rates are much larger than their derivatives.
    #[test]
    fn what_rests_in_all_rows_is_not_conserved_for_all_that() {
        assert_eq!(told("x, y*(y - 1e8)*1e-8", [1e8, 0.0], [1e8, 1e8]), None);
    }

    /// A pulse between the rows, and a rate that vanishes at both ends; what depends on time and is conserved all the same.
    #[test]
    fn what_f_moves_between_the_rows_is_not_conserved() {
        for f in ["10*heaviside(t - 0.1)*heaviside(0.2 - t)", "6*t*(1 - t)"] {
            assert_eq!(told(&format!("{f} + 0*x, 0*y"), [0.0, 1.0], [1.0, 1.0]), None, "{f}");
        }
        assert!(told("-(1 + t)*x*y, (1 + t)*x*y", [8.0, 1.0], [7.0, 3.0]).is_some());
    }

    #[test]
    fn a_point_beside_a_state_is_one_in_its_units() {
        let [small, large] = [1.0, 1e8].map(|size| point_beside(size, 3));
        assert!(large.iter().zip(&small).all(|(large, small)| (large / small / 1e8 - 1.0).abs() < 1e-15));
        assert!(small.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 0.01), "no two of its components are alike");
    }

    /// By which y decays, or what is made of x: next to 10¹⁵ or 10⁸ it looks like nothing.
    #[test]
    fn a_rate_beside_a_much_larger_one_is_not_nothing() {
        assert_eq!(told("-1e15*x, -1e-4*y", [1.0, 1.0], [0.0, 0.0]), None);
        assert_eq!(told("-1e8*x, 1e8*x - 1e-8*y", [1.0, 0.0], [0.0, 0.9]), None);
        assert!(told("-1e8*x, 1e8*x - 0*y", [1.0, 0.0], [0.0, 0.9]).is_some());
    }
}
