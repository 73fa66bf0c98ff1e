//! What a run shows that its numbers do not say: where they cannot be right although every step was solved.

use nalgebra::DMatrix;
use verify::measure::norm::{Extremes, distance, larger, max_norm};
use verify::problem::{Problem, component_names};
use verify::reference::Ode;

use crate::cli::layout::{number, plain};

/// Largest system whose derivatives are looked at as a dense matrix.
const DENSE: usize = 64;

/// A change below this part of what f moves, or of the solution, is none.
const REST: f64 = 1e-6;

/// Growth beyond all values so far in a single step that no step resolves.
const LEAP: f64 = 10.0;

/// Rows over which a solution may find its scale, from the first on that is not zero.
const START: usize = 3;

/// Singular values below this part of the largest are zero but for rounding, of f and in the decomposition.
const NULL: f64 = 1e-13;

/// Follows a run.
#[derive(Debug, Default)]
pub(super) struct Watch {
    first: Vec<f64>,
    /// The last state and the one before, each with its time.
    last: (f64, Vec<f64>),
    before: (f64, Vec<f64>),
    /// Largest component of all states, and the largest value of each.
    largest: f64,
    sizes: Vec<f64>,
    /// The first time at which there is no exact solution any more.
    ended: Option<f64>,
    /// Rows since the first that is not zero.
    rows: usize,
    rates: Rates,
    /// The first step across which the solution leaves its scale behind, by its end and the size before and after.
    leap: Option<(f64, [f64; 2])>,
}

/// The values of f at all rows of a small system, as columns of a matrix.
#[derive(Debug, Default)]
struct Rates {
    unknowns: usize,
    /// Not the columns A themselves but, from a number of them on, n others with the same A Aᵀ.
    columns: Vec<f64>,
}

impl Rates {
    fn add(&mut self, ode: &dyn Ode, t: f64, state: &[f64]) {
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

    fn matrix(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(self.unknowns, self.columns.len() / self.unknowns.max(1), &self.columns)
    }
}

impl Watch {
    /// A row of a run on `problem`.
    pub(super) fn add(&mut self, problem: &dyn Problem, t: f64, state: &[f64], has_ended: bool) {
        if self.first.is_empty() {
            self.first = state.to_vec();
            self.sizes = vec![0.0; state.len()];
        }
        self.sizes.iter_mut().zip(state).for_each(|(size, x)| *size = larger(*size, x.abs()));
        if (2..=DENSE).contains(&state.len()) && problem.ode().dim() == state.len() {
            self.rates.add(problem.ode(), t, state);
        }
        std::mem::swap(&mut self.last, &mut self.before);
        self.last.0 = t;
        self.last.1.clear();
        self.last.1.extend_from_slice(state);
        let size = max_norm(state);
        self.rows += usize::from(self.largest > 0.0 || size > 0.0);
        if self.rows > START && size > LEAP * self.largest && self.leap.is_none() {
            self.leap = Some((t, [self.largest, size]));
        }
        self.largest = larger(self.largest, size);
        if has_ended && self.ended.is_none() {
            self.ended = Some(t);
        }
    }

    /// The first state and the last.
    pub(super) fn ends(&self) -> (&[f64], &[f64]) {
        (&self.first, &self.last.1)
    }

    /// A step in which the solution leaves all that was before behind, as beside a pole.
    pub(super) fn leap(&self) -> Option<String> {
        let (t, [before, after]) = self.leap?;
        Some(format!(
            "in the step to t = {} the solution grows from {} to {}: such a step resolves nothing, and the solution may end \
             before; a smaller `--h` tells",
            plain(t),
            number(before),
            number(after)
        ))
    }

    /// A solution no component of which comes to the absolute tolerance that it is held to, one for all or one for each.
    pub(super) fn below(&self, atol: &[f64]) -> Option<String> {
        let largest = |k: usize| atol.get(k).or(atol.first()).copied().unwrap_or(0.0);
        let is_below = self.sizes.iter().enumerate().all(|(k, size)| *size < largest(k));
        (self.largest > 0.0 && is_below).then(|| {
            format!(
                "no component comes to the absolute tolerance, {}, and the largest is {}: no digit of the solution is held to anything; a \
                 smaller `--atol`, or other units, tell",
                number(atol.iter().copied().largest()),
                number(self.largest)
            )
        })
    }

    /// What is to be said of the run on `problem`.
    pub(super) fn warnings(&self, problem: &dyn Problem) -> Vec<String> {
        let ended = self.ended.map(|t| {
            format!("the exact solution ends before t = {}; the rows from there on approximate nothing", plain(t))
        });
        let ode = problem.ode();
        let is_state = ode.dim() == self.last.1.len() && ode.dim() == self.first.len();
        if !is_state || self.before.1.is_empty() {
            return ended.into_iter().collect();
        }
        ended.into_iter().chain(self.at_rest(problem)).chain(self.broken_invariants(problem)).collect()
    }

    /// A state of rest that is none of the equation, or one that the equation leaves.
    fn at_rest(&self, problem: &dyn Problem) -> Option<String> {
        let (ode, (t, v), (t_before, before)) = (problem.ode(), &self.last, &self.before);
        let (h, moved) = (t - t_before, distance(v, before));
        // The references' f, which may be dear, is asked where the run rests alone.
        if moved > REST * self.largest {
            return None;
        }
        let mut f = vec![0.0; v.len()];
        ode.rhs(*t, v, &mut f);
        let (size, drift) = (max_norm(v), h * max_norm(&f));
        if drift > REST * size && moved <= REST * drift {
            return Some(format!(
                "the run rests where f is not zero: it moved by {} in the last step of h = {}, |f| = {}; that is a steady \
                 state of the method, not of the equation",
                number(moved),
                plain(h),
                number(max_norm(&f))
            ));
        }
        let came = self.first.iter().zip(v).any(|(a, b)| (a - b).abs() > REST * self.largest);
        if !came || drift > REST * self.largest || v.len() > DENSE {
            return None;
        }
        let rates = jacobian(problem, *t, v).complex_eigenvalues();
        let rate = rates.iter().map(|rate| rate.re).largest();
        (h * rate > REST).then(|| {
            format!(
                "the run came to rest where the equation is unstable: perturbations grow like e^({} t) there, and the method \
                 with h = {} damps them; a step well below {} shows the growth",
                number(rate),
                plain(h),
                number(rate.recip())
            )
        })
    }

    /// Linear combinations of the components that the equation conserves and the run does not.
    fn broken_invariants(&self, problem: &dyn Problem) -> Option<String> {
        let n = self.first.len();
        if !(2..=DENSE).contains(&n) {
            return None;
        }
        // wᵀ f vanishes for all v where wᵀ ∂f/∂v does, here at states of the run and a point beside it, and wᵀ f does at each row, as f may
        // act between the ends alone. In units of the solution f is as large as ∂f/∂v, and so are its roundings.
        let beside: Vec<f64> = (0..n).map(|i| self.largest * (1.0 + 0.5 * ((i + 1) as f64).sin())).collect();
        let rates = self.rates.matrix() / self.largest;
        let mut all = DMatrix::zeros(n, 3 * n + rates.ncols());
        for (k, (t, v)) in
            [(0.0, &self.first), (self.last.0, &self.last.1), (self.last.0, &beside)].into_iter().enumerate()
        {
            all.columns_mut(k * n, n).copy_from(&jacobian(problem, t, v));
        }
        all.columns_mut(3 * n, rates.ncols()).copy_from(&rates);
        if all.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let svd = all.svd(true, false);
        let (vectors, values) = (svd.u?, svd.singular_values);
        let names = component_names(problem);
        (0..values.len()).filter(|k| values[*k] <= NULL * values.max()).find_map(|k| {
            let w = vectors.column(k);
            let change: f64 = w.iter().zip(self.last.1.iter().zip(&self.first)).map(|(w, (b, a))| w * (b - a)).sum();
            let scale = w.amax();
            (change.abs() > REST * self.largest).then(|| {
                let terms = w.iter().zip(&names).filter(|(w, _)| w.abs() > REST * scale);
                let pivot = w[w.iamax()];
                let sum = terms.map(|(w, name)| format!("{:+.4} {name}", w / pivot)).collect::<Vec<_>>().join(" ");
                format!(
                    "the equation conserves {sum}, and the run changed it by {}; a smaller h, or a Runge–Kutta method, which \
                     conserves it, helps",
                    number(change / pivot)
                )
            })
        })
    }
}

/// ∂f/∂v as a dense matrix.
fn jacobian(problem: &dyn Problem, t: f64, v: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(v.len(), v.len());
    problem.ode().jacobian(t, v, &mut |i, j, x| matrix[(i, j)] += x);
    matrix
}
