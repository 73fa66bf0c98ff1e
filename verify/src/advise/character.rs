//! What a system is like along its solution.

use lsvi::{Jacobian, Mass, Structure, VectorField};
use nalgebra::{Complex, DMatrix, DVector};

use super::worst;
use crate::measure::norm::{Extremes, common_distance, distance, max_norm};
use crate::measure::stability::{Spectrum, numerical_abscissa, reach_of_rk4};
use crate::method::Method;
use crate::problem::Problem;
use crate::problem::changes::changes;
use crate::run::{RunError, run, run_through, run_through_from};

/// Unknowns of the largest system that is looked at.
const LARGEST: usize = 200;
/// States at which f is looked at for whether it depends on time.
const PLACES: usize = 4;
/// Instants at which it is looked at, and values of the Jacobians of which the largest is one more.
const INSTANTS: usize = 32;
const VALUES: usize = 1 << 24;
/// Times at which two solutions are compared.
const SIXTEEN: u32 = 16;
/// Sizes of the disturbances by which growth is told: a tenth of one that the accurate runs resolve to more than four digits.
const DISTURBANCES: [f64; 2] = [1e-6, 1e-7];
/// Factors that differ by no more are one: half a unit of the second digit, to which they are told.
const DIGITS: f64 = 0.05;
/// Part of the time within which two times are one.
const RESOLVED: f64 = 1e-9;
/// Growth by which a solution that cannot be followed further has blown up.
const BLOWN: f64 = 1e6;
/// Halvings that leave of the way between two states less than what a smooth f changes on, and the part of the largest f that a jump comes to:
/// it is left of rates a thousand million times those of the solution alone, whose roundings are smaller.
const HALVINGS: usize = 40;
const JUMP: f64 = 1e-3;
/// Part of a product below which it is zero, to the seven digits to which an invariant is found.
const DIGITS_KEPT: f64 = 1e-6;
/// Relative size below which an entry is roundoff of derivatives.
const ROUNDOFF: f64 = 1e-9;

/// What a system is like along its solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Character {
    /// Its unknowns.
    pub unknowns: usize,
    /// The rest, if its matrices were looked at.
    pub matrices: Option<Matrices>,
    /// What becomes of a small disturbance of the start.
    pub growth: Growth,
    /// The largest component at the start, and on the way.
    pub sizes: (f64, f64),
    /// The largest size of each component on the way.
    pub largest: Vec<f64>,
    /// How far the solution goes from its start.
    pub moved: f64,
    /// The time up to which the solution was followed.
    pub reached: f64,
}

/// What becomes of small disturbances of the start along a solution.
#[derive(Debug, Clone, PartialEq)]
pub enum Growth {
    /// They change by this factor, whatever their size, largest at sixteen times and where f changes by itself; where that is below 1, by
    /// less than it.
    By(f64),
    /// Two sizes change by these factors, so that what they tell is not the equation's.
    Untold([f64; 2]),
    /// A run failed.
    Lost(RunError),
    /// The solution was not followed.
    Unseen,
}

impl Growth {
    /// What the factors of two sizes of disturbance say.
    fn by([a, b]: [f64; 2]) -> Self {
        // Where nothing grows roundings may be all that is left.
        if a.max(b) <= 1.0 || (a - b).abs() <= DIGITS * a.max(b) { Self::By(a) } else { Self::Untold([a, b]) }
    }
}

/// What the Jacobians A = M⁻¹ ∂f/∂v along the solution say, in coordinates where M = I.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrices {
    /// The instants.
    pub instants: usize,
    /// Largest |λ|.
    pub fastest: f64,
    /// Largest Re λ.
    pub spectral: f64,
    /// Largest eigenvalue of (A + Aᵀ)/2.
    pub numerical: f64,
    /// Largest ‖A − Aᵀ‖ over ‖A‖, 0 for a symmetric system.
    pub asymmetry: f64,
    /// The least number of steps of RK4 in a unit of time with which it is stable on the linearised equation, but for what grows.
    pub steps_of_rk4: f64,
    /// Linear invariants: w with wᵀM v constant.
    pub invariants: usize,
    /// Whether A w = 0 for each of them, for which Method I keeps them.
    pub keeps_invariants: bool,
    /// A with the largest |λ| of the instants at which no perturbation grows.
    pub calm: Option<DMatrix<f64>>,
    /// Whether ΩA is symmetric at all instants, with momenta after coordinates, or each after its own.
    pub is_hamiltonian: bool,
    /// Whether f does not depend on t.
    pub is_autonomous: bool,
    /// Whether f jumps between two states, in which case its derivatives do not tell all that it does.
    pub jumps: bool,
}

impl Matrices {
    /// Whether the distance between solutions does not grow, in the norm of M.
    pub fn is_contractive(&self) -> bool {
        self.numerical <= ROUNDOFF * self.fastest
    }

    /// Whether solutions may grow although no eigenvalue says so.
    pub fn is_non_normal(&self) -> bool {
        self.numerical > ROUNDOFF * self.fastest && self.spectral <= ROUNDOFF * self.fastest
    }

    /// Whether A is symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.asymmetry <= ROUNDOFF
    }
}

impl Character {
    /// Of a problem whose solution is not followed.
    pub(super) fn unseen(problem: &dyn Problem) -> Self {
        let unknowns = problem.field().dim();
        let (growth, sizes, largest) = (Growth::Unseen, (f64::NAN, f64::NAN), Vec::new());
        Self { unknowns, matrices: None, growth, sizes, largest, moved: 0.0, reached: 0.0 }
    }

    /// Along the solution of `problem` by an adaptive method with errors far below the disturbances by which growth is told, as far as it
    /// goes, and where f changes by itself between its steps. The disturbances are parts of the start, or of `unit` where it is smaller.
    pub(super) fn of(problem: &dyn Problem, method: &dyn Method, horizon: f64, unit: f64) -> Self {
        let unknowns = problem.ode().dim();
        let mut states = Vec::new();
        // What was seen until a failure is what there is to look at.
        let h = problem.ode().longest_step(horizon).min(horizon / INSTANTS as f64);
        let _ = run(problem, method, h, horizon, |state| states.push((state.t, state.q.clone())));
        let reached = states.last().map_or(0.0, |(t, _)| *t);
        let between = changes(problem, horizon, &states.iter().map(|(t, _)| *t).collect::<Vec<_>>());
        let passed = run_through(problem, method, &between).unwrap_or_default();
        states.extend(between.into_iter().zip(passed));
        let size = |(_, state): &(f64, Vec<f64>)| max_norm(state);
        let sizes = (states.first().map_or(0.0, size), worst(states.iter().map(size)));
        let largest = (0..unknowns).map(|k| worst(states.iter().map(|(_, state)| state[k].abs()))).collect();
        let start = problem.initial();
        let moved = worst(states.iter().map(|(_, state)| common_distance(state, &start)));
        let growth = growth(problem, method, horizon, unit);
        Self { unknowns, matrices: matrices(problem, &states), growth, sizes, largest, moved, reached }
    }

    /// The components that are not zero throughout, and no larger than `error`.
    pub fn within(&self, error: f64) -> impl Iterator<Item = usize> {
        let sizes = self.largest.iter().enumerate();
        sizes.filter(move |(_, size)| **size > 0.0 && **size <= error).map(|(k, _)| k)
    }

    /// Whether it has too many unknowns for its matrices to be looked at.
    pub fn is_large(&self) -> bool {
        self.unknowns > LARGEST
    }

    /// Whether the solution has grown beyond all measure where it was lost.
    pub fn blows_up(&self) -> bool {
        self.sizes.1 > BLOWN * self.sizes.0.max(1.0)
    }
}

/// The Jacobians of a small system at few of the states, and where the largest is.
fn matrices(problem: &dyn Problem, states: &[(f64, Vec<f64>)]) -> Option<Matrices> {
    let field = problem.field();
    let n = field.dim();
    let structure = field.structure();
    if n > LARGEST || matches!(structure, Structure::MatrixFree) || states.iter().any(|(_, v)| v.len() != n) {
        return None;
    }
    let mass = match field.mass() {
        Mass::Identity => DMatrix::identity(n, n),
        Mass::Diagonal(entries) => DMatrix::from_diagonal(&DVector::from_vec(entries)),
        Mass::Matrix(matrix) => matrix.to_dense(),
        _ => return None,
    };
    let factor = mass.cholesky()?.l();
    let inverse = factor.clone().try_inverse()?;
    let mut found: Vec<DMatrix<f64>> = Vec::new();
    let mut columns = Vec::new();
    let jacobian = |t: f64, v: &[f64]| {
        let mut jacobian = Jacobian::with_structure(n, &structure);
        field.add_jacobian(t, v, 1.0, &mut jacobian);
        jacobian.to_dense()
    };
    let by_size =
        few(states, (VALUES / (n * n).max(1)).max(INSTANTS)).map(|state| (jacobian(state.0, &state.1).norm(), state));
    let largest = by_size.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, state)| state);
    for (t, v) in few(states, INSTANTS).chain(largest) {
        let mut rate = vec![0.0; n];
        field.rhs(*t, v, &mut rate);
        let a = &inverse * jacobian(*t, v) * inverse.transpose();
        let scale = a.norm();
        if !scale.is_finite() {
            return None;
        }
        // An invariant is orthogonal to every column of A, and to the rate, by their own sizes.
        columns.extend(a.column_iter().map(|column| column / scale.max(f64::MIN_POSITIVE)));
        let rate = &inverse * DVector::from_vec(rate);
        // The square of what a pulse is long before its time would be 0.
        columns.push(&rate / rate.amax().max(f64::MIN_POSITIVE));
        found.push(a);
    }
    let instants = found.len();
    // Of a linear system they are all the same.
    found.dedup();
    let spectra: Vec<Spectrum> = found.iter().map(Spectrum::of).collect();
    if spectra.iter().any(|spectrum| spectrum.radius().is_nan()) {
        return None;
    }
    let (t, _) = states.first()?;
    // A solution at rest sees the linear part of f alone: a state aside, where f is defined there.
    let size = Some(worst(states.iter().map(|(_, v)| max_norm(v)))).filter(|size| *size > 0.0).unwrap_or(1.0);
    let aside: Vec<f64> = (0..n).map(|i| size * (1.0 + 0.5 * ((i + 1) as f64).sin())).collect();
    let a = &inverse * jacobian(*t, &aside) * inverse.transpose();
    let scale = a.norm();
    if scale.is_finite() {
        columns.extend(a.column_iter().map(|column| column / scale.max(f64::MIN_POSITIVE)));
    }
    let mut all = DMatrix::from_columns(&columns);
    // What has a small unit has small rates, and is not conserved for that; a row that is no more than the roundings of two products of the
    // largest is none, and stays.
    let largest = all.row_iter().map(|row| row.norm()).largest();
    let mut units = DVector::from_element(n, 1.0);
    for (mut row, unit) in all.row_iter_mut().zip(units.iter_mut()) {
        let norm = row.norm();
        if norm > 4.0 * f64::EPSILON * largest {
            row /= norm;
            *unit = norm;
        }
    }
    // Squares of singular values: what is orthogonal to seven digits counts.
    let of_rows = (&all * all.transpose()).symmetric_eigen();
    let least = 16.0 * all.ncols() as f64 * f64::EPSILON * of_rows.eigenvalues.max();
    let orthogonal = of_rows.eigenvalues.iter().zip(of_rows.eigenvectors.column_iter());
    // Rates that are alike make the largest of them large, and what is slow beside the stiffest part passes for nothing beside that.
    let is_orthogonal = |w: &DVector<f64>| all.column_iter().all(|c| c.dot(w).abs() <= DIGITS_KEPT * c.norm());
    let candidates = orthogonal.filter(|(size, _)| **size <= least).map(|(_, w)| w.into_owned());
    let invariants: Vec<_> = candidates.filter(is_orthogonal).map(|w| w.component_div(&units)).collect();
    let is_kept = |w: &DVector<f64>| found.iter().all(|a| (a * w).norm() <= DIGITS_KEPT * a.norm() * w.norm());
    let relative = |difference: DMatrix<f64>, a: &DMatrix<f64>| difference.norm() / a.norm().max(f64::MIN_POSITIVE);
    let hamiltonian = |partner: fn(usize, usize) -> (usize, f64)| {
        found.iter().zip(&spectra).all(|(a, spectrum)| {
            let b = DMatrix::from_fn(n, n, |i, j| {
                let (partner, sign) = partner(n, i);
                sign * a[(partner, j)]
            });
            // A rate of damping, in the units of time alone, may be next to nothing beside the entries of a coupling.
            let least = ROUNDOFF * spectrum.radius();
            let is_damped = |i: usize| (a[(i, i)] + a[(partner(n, i).0, partner(n, i).0)]).abs() > least;
            relative(&b - b.transpose(), a) <= ROUNDOFF && !(0..n).any(is_damped)
        })
    };
    let calm = found.iter().zip(&spectra).filter(|(_, of)| of.abscissa() <= ROUNDOFF * of.radius());
    Some(Matrices {
        calm: calm.max_by(|(_, a), (_, b)| a.radius().total_cmp(&b.radius())).map(|(a, _)| a.clone()),
        instants,
        fastest: spectra.iter().map(Spectrum::radius).largest(),
        spectral: spectra.iter().map(Spectrum::abscissa).largest(),
        numerical: found.iter().map(numerical_abscissa).largest(),
        asymmetry: worst(found.iter().map(|a| relative(a - a.transpose(), a))),
        steps_of_rk4: spectra.iter().flat_map(Spectrum::values).map(|rate| steps_of_rk4(*rate)).largest(),
        keeps_invariants: invariants.iter().all(is_kept),
        invariants: invariants.len(),
        is_autonomous: is_autonomous(&*field, states),
        jumps: jumps(&*field, states),
        is_hamiltonian: n.is_multiple_of(2) && (hamiltonian(halves) || hamiltonian(pairs)),
    })
}

/// The least number of steps of RK4 in a unit of time with which it is stable on ẋ = λx; none where that grows.
fn steps_of_rk4(rate: Complex<f64>) -> f64 {
    let size = rate.norm();
    if size == 0.0 || rate.re > ROUNDOFF * size {
        return 0.0;
    }
    size / reach_of_rk4(Complex::new(rate.re.min(0.0), rate.im) / size)
}

/// Whether f at each of a few states is the same at the times of others.
fn is_autonomous(field: &dyn VectorField, states: &[(f64, Vec<f64>)]) -> bool {
    let rate = |t: f64, v: &[f64]| {
        let mut rate = vec![0.0; field.dim()];
        field.rhs(t, v, &mut rate);
        rate
    };
    few(states, PLACES).all(|(_, v)| {
        let first = rate(0.0, v);
        few(states, INSTANTS).all(|(t, _)| rate(*t, v) == first)
    })
}

/// Whether f jumps on the way from one state to the next: its values differ at the ends of what is left after [`HALVINGS`], of two halves the one
/// at whose ends they differ more.
fn jumps(field: &dyn VectorField, states: &[(f64, Vec<f64>)]) -> bool {
    let rate = |t: f64, state: &[f64]| {
        let mut f = vec![0.0; field.dim()];
        field.rhs(t, state, &mut f);
        f
    };
    let mut in_order: Vec<_> = states.iter().collect();
    in_order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let rates: Vec<_> = in_order.iter().map(|(t, state)| rate(*t, state)).collect();
    // Beside the largest, as those of what is at rest are roundings.
    let far = JUMP * worst(rates.iter().map(|f| max_norm(f)));
    in_order.array_windows().zip(rates.array_windows()).any(|([from, to], [first, last])| {
        let at = |part: f64| {
            let state: Vec<f64> = from.1.iter().zip(&to.1).map(|(a, b)| a + part * (b - a)).collect();
            rate(from.0 + part * (to.0 - from.0), &state)
        };
        let mut ends = [(0.0, first.clone()), (1.0, last.clone())];
        for _ in 0..HALVINGS {
            // NaN is no jump.
            if distance(&ends[0].1, &ends[1].1).is_nan() || distance(&ends[0].1, &ends[1].1) <= far {
                return false;
            }
            let part = 0.5 * (ends[0].0 + ends[1].0);
            let middle = (part, at(part));
            let is_before = distance(&ends[0].1, &middle.1) >= distance(&middle.1, &ends[1].1);
            ends[usize::from(is_before)] = middle;
        }
        distance(&ends[0].1, &ends[1].1) > far
    })
}

/// At most so many of all, equally far from each other.
fn few<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(most).max(1))
}

/// The row of ΩA that is ± a row of A, for (q₁, q₂, …, p₁, p₂, …).
fn halves(n: usize, i: usize) -> (usize, f64) {
    if i < n / 2 { (i + n / 2, 1.0) } else { (i - n / 2, -1.0) }
}

/// The same for (q₁, p₁, q₂, p₂, …).
fn pairs(_: usize, i: usize) -> (usize, f64) {
    if i.is_multiple_of(2) { (i + 1, 1.0) } else { (i - 1, -1.0) }
}

/// What becomes of disturbances of the start of two sizes, at sixteen times, so that one that grows and falls again is seen.
///
/// What the equation does to a small one is proportional to it. What runs do that meet a jump in different steps is not, nor what has grown
/// to the size of the solution.
fn growth(problem: &dyn Problem, method: &dyn Method, horizon: f64, unit: f64) -> Growth {
    let start = problem.initial();
    let even: Vec<f64> = (1..=SIXTEEN).map(|k| horizon * f64::from(k) / f64::from(SIXTEEN)).collect();
    let mut times = [&even[..], &changes(problem, horizon, &even)].concat();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|next, time| *next - *time <= RESOLVED * horizon);
    let follow = |start: Vec<f64>| run_through_from(problem, start, method, &times);
    let factors = || -> Result<[f64; 2], RunError> {
        let one = follow(start.clone())?;
        let factor = |size: f64| {
            let size = size * max_norm(&start).max(unit);
            // All directions have a part in it, smooth ones too.
            let moved: Vec<f64> =
                start.iter().enumerate().map(|(i, x)| x + size * (1.0 + 0.5 * (i as f64).sin())).collect();
            let apart = distance(&start, &moved);
            let other = follow(moved)?;
            Ok::<_, RunError>(worst(one.iter().zip(&other).map(|(one, other)| distance(one, other) / apart)))
        };
        Ok([factor(DISTURBANCES[0])?, factor(DISTURBANCES[1])?])
    };
    match factors() {
        Err(error) => Growth::Lost(error),
        Ok(factors) => Growth::by(factors),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::model::Model;

    /// A dose of 100 so short that steps of a hundredth of the run pass over it.
    #[test]
    fn a_solution_is_as_large_as_what_its_first_run_passes_over_makes_it() {
        let dose = "56418.96 * exp(-1e6 * (t - 5.0371) * (t - 5.0371))";
        let problem = Model::of_text(&format!("u_i {{ c = 1 }} F_i {{ {dose} - 0.4 * c }}"), &[], Some(10.0));
        let method = crate::method::parse("radau-adaptive").expect("registered");
        let character = Character::of(&problem.expect("a model"), &*method, 10.0, 1.0);
        let size = character.sizes.1;
        assert!((90.0..110.0).contains(&size) && (character.moved - size).abs() < 2.0, "{character:?}");
    }

    /// To a twentieth, where either grows.
    #[test]
    fn two_factors_tell_one_growth_where_they_agree() {
        let is_told = |a: f64, b: f64| match Growth::by([a, b]) {
            Growth::By(factor) => factor == a,
            told => {
                assert_eq!(told, Growth::Untold([a, b]));
                false
            }
        };
        let pairs = [(9.6, 10.0), (9.4, 10.0), (10.0, 9.6), (10.0, 9.4), (0.9, 0.1), (1.1, 0.1)];
        assert_eq!(pairs.map(|(a, b)| is_told(a, b)), [true, false, true, false, true, false]);
    }
}
