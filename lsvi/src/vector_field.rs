//! First-order systems M v̇ = f(t, v).

use auto_impl::auto_impl;

use crate::coloring::Coloring;
use crate::error::{InputError, SystemError, check_unknowns};
use crate::linalg::{Jacobian, Structure, max_norm};
use crate::mass::Mass;

/// A first-order system M v̇ = f(t, v) in n unknowns, with the derivatives that implicit steps need.
///
/// Implement it by hand, or implement [`FieldFn`](crate::FieldFn) once and let [`AutoField`](crate::AutoField) differentiate.
/// Arguments have length n; times and states carry whatever units the problem has.
///
/// # Assembled or matrix-free
/// A field with a dense, banded or sparse [`structure`](Self::structure) assembles its derivatives,
/// [`add_jacobian`](Self::add_jacobian) and [`add_curvature`](Self::add_curvature); the products
/// [`apply_jacobian`](Self::apply_jacobian), [`apply_transpose`](Self::apply_transpose) and
/// [`apply_curvature`](Self::apply_curvature) follow from them. A field of structure [`Structure::MatrixFree`] gives the
/// products instead, and its steps are solved by an iterative solver with a
/// [`Preconditioner`](crate::Preconditioner); its `add_jacobian` may
/// be [`add_columns`], which lets it run on every method while n is small.
#[auto_impl(&, Box, Rc, Arc)]
pub trait VectorField {
    /// Number of unknowns n.
    fn dim(&self) -> usize;

    /// Where the Jacobian, and M, may have entries; or that the field has no assembled Jacobian.
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// The constant matrix M.
    fn mass(&self) -> Mass {
        Mass::Identity
    }

    /// Whether f(t, v) = A v + g(t) with a constant matrix A: not one that depends on time, as with a valve that opens later.
    /// Methods may then factor once, and solve for the new value itself instead of for increments, which keeps digits that
    /// f(t, v) has lost. What it says is checked by [`LeastSquaresStep`](crate::LeastSquaresStep), whatever the structure, at the
    /// state: in the first step of a size, after 2, 4, 8, … more and then after every 256, and where factors are kept and f is
    /// not [autonomous](Self::is_autonomous) at the end of every step: [`SolveError::NotLinear`](crate::SolveError::NotLinear).
    /// Implicit stages one after the other, as of [`RungeKutta`](crate::classic::RungeKutta), see by themselves where it is not so, and are solved as those of
    /// any field. So are the stages of [`Radau`](crate::adaptive::Radau), which takes one increment for the solution where f is
    /// autonomous too and the equation at the end of the step agrees.
    fn is_linear(&self) -> bool {
        false
    }

    /// Whether f does not depend on t, so that what a linear f adds to every step is known beforehand. It is checked as
    /// [`is_linear`](Self::is_linear) is: [`SolveError::NotAutonomous`](crate::SolveError::NotAutonomous).
    fn is_autonomous(&self) -> bool {
        false
    }

    /// Writes f(t, v) into `dv`.
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]);

    /// Adds `scale` · ∂f_i/∂v_j to `out` (i, j).
    ///
    /// J is part of the equation of a least-squares step, as in M z = h r₁, h r₀ + Bᵀz = 0. A wrong entry keeps their order and moves their
    /// results, which no study of their order shows; other implicit methods only converge more slowly.
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian);

    /// Writes f(t, v) into `dv` and adds `scale` · ∂f_i/∂v_j to `out` (i, j): both at once, where that is cheaper.
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        self.rhs(t, v, dv);
        self.add_jacobian(t, v, scale, out);
    }

    /// Adds `scale` · Σ_i w_i ∂²f_i/∂v_j∂v_k to `out` (j, k); nothing where f is linear in v.
    ///
    /// Unless it is overridden, from differences of Jacobians over √ε max(|v_k|, ‖v‖/1000): accurate to √ε, which Newton's iteration hardly
    /// notices, where J is smooth on that scale, and wrong where a component far below the others is in units of its own. They cost n + 1
    /// Jacobians and some allocation. To add nothing where f is not linear makes the iteration that of Gauss
    /// and Newton, which converges slowly or not at all.
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        if !self.is_linear() {
            Differences::new(self.dim(), &self.structure()).add_curvature(self, t, v, w, scale, out);
        }
    }

    /// Where what [`add_curvature`](Self::add_curvature) adds may have entries, in a structure of the kind that the
    /// [`structure`](Self::structure) is.
    ///
    /// By default wherever two entries of a row of J meet, which is many more than where f has a product of two unknowns. Closures other than Method I
    /// factor a matrix with these entries.
    fn curvature_structure(&self) -> Structure {
        self.structure().gram(self.dim())
    }

    /// Writes J x, J = ∂f/∂v at (t, v).
    ///
    /// The default assembles J, which allocates; integrators use it of matrix-free fields only, where it has to be given.
    /// A matrix-free field without it has products of NaN, and its steps fail as not finite; so has one of vectors that have not
    /// the length n.
    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        let lengths = [v.len(), x.len(), out.len()];
        let jacobian = assembled(self.dim(), &self.structure(), &lengths, &mut |j| self.add_jacobian(t, v, 1.0, j));
        write_product(jacobian, Jacobian::mul_add, x, out);
    }

    /// Writes Jᵀ w, otherwise as [`apply_jacobian`](Self::apply_jacobian). Least-squares methods need it.
    ///
    /// Where ⟨Jᵀw, x⟩ is not ⟨w, J x⟩, steps come to rest away from a minimum, [`SolveError::Stalled`](crate::SolveError::Stalled), or their linear
    /// solver stops.
    fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
        let lengths = [v.len(), w.len(), out.len()];
        let jacobian = assembled(self.dim(), &self.structure(), &lengths, &mut |j| self.add_jacobian(t, v, 1.0, j));
        write_product(jacobian, Jacobian::mul_transpose_add, w, out);
    }

    /// Writes Σ_i w_i (∂²f_i/∂v²) x, the derivative of Jᵀw in the direction x.
    ///
    /// The default of a matrix-free field is the central difference of [`apply_transpose`](Self::apply_transpose): exact to
    /// about ε^⅔ where f is quadratic, as in the Navier–Stokes equations, and with a truncation error of that size elsewhere.
    /// It allocates.
    fn apply_curvature(&self, t: f64, v: &[f64], w: &[f64], x: &[f64], out: &mut [f64]) {
        if max_norm(x) == 0.0 || self.is_linear() {
            return out.fill(0.0);
        }
        if self.structure() == Structure::MatrixFree {
            return write_difference(&mut |v, out| self.apply_transpose(t, v, w, out), v, x, out);
        }
        let lengths = [v.len(), w.len(), x.len(), out.len()];
        let add = &mut |matrix: &mut Jacobian| self.add_curvature(t, v, w, 1.0, matrix);
        let curvature = assembled(self.dim(), &self.curvature_structure(), &lengths, add);
        write_product(curvature, Jacobian::mul_add, x, out);
    }
}

/// Refuses a structure or a mass that is not that of as many unknowns as `field` has, and a field of none.
pub(crate) fn check_system(field: &dyn VectorField) -> Result<(), InputError> {
    let n = field.dim();
    check_unknowns(n)?;
    match field.structure() {
        Structure::Sparse(pattern) if pattern.dim() != n => {
            Err(InputError::System(SystemError::Pattern { expected: n, found: pattern.dim() }))
        }
        _ => field.mass().check(n),
    }
}

/// Second derivatives from differences of Jacobians, with work space to be kept by a field that has no exact ones.
#[derive(Debug)]
pub struct Differences {
    coloring: Coloring,
    here: Jacobian,
    there: Jacobian,
    v: Vec<f64>,
}

impl Differences {
    /// For a field in `dim` unknowns with a Jacobian of the given structure.
    pub fn new(dim: usize, structure: &Structure) -> Self {
        let here = Jacobian::with_structure(dim, structure);
        Self { coloring: Coloring::new(dim, structure), there: here.clone(), here, v: vec![0.0; dim] }
    }

    /// Adds `scale` · Σ_i w_i ∂²f_i/∂v_j∂v_k of `field` to `out` (j, k), as [`VectorField::add_curvature`]: one Jacobian at v and
    /// one for each group of columns that share no row, at distance √ε max(|v_k|, ‖v‖/1000). NaN if v or w has not the length
    /// that this was made for.
    pub fn add_curvature<F: VectorField + ?Sized>(
        &mut self,
        field: &F,
        t: f64,
        v: &[f64],
        w: &[f64],
        scale: f64,
        out: &mut Jacobian,
    ) {
        self.add(&|v, jacobian| field.add_jacobian(t, v, 1.0, jacobian), v, w, scale, out);
    }

    fn add(
        &mut self,
        add_jacobian: &dyn Fn(&[f64], &mut Jacobian),
        v: &[f64],
        w: &[f64],
        scale: f64,
        out: &mut Jacobian,
    ) {
        if [v.len(), w.len()] != [self.v.len(); 2] {
            return out.add(0, 0, f64::NAN);
        }
        self.here.clear();
        add_jacobian(v, &mut self.here);
        let largest = max_norm(v);
        let least = if largest > 0.0 { 1e-3 * largest } else { 1.0 };
        for c in 0..self.coloring.groups() {
            self.v.copy_from_slice(v);
            for k in self.coloring.columns(c) {
                self.v[k] += f64::EPSILON.sqrt() * v[k].abs().max(least);
            }
            self.there.clear();
            add_jacobian(&self.v, &mut self.there);
            let (coloring, here, moved) = (&self.coloring, &self.here, &self.v);
            self.there.for_each(|i, j, x| {
                let Some(k) = coloring.column(c, i) else { return };
                let difference = x - here.get(i, j);
                if difference != 0.0 && w[i] != 0.0 {
                    out.add(j, k, scale * w[i] * difference / (moved[k] - v[k]));
                }
            });
        }
    }
}

// What follows is not generic: the defaults above are compiled for every field.

/// The matrix of a structure that `add` makes of zeros; none without a structure, or where a vector has not the length n.
fn assembled(
    n: usize,
    structure: &Structure,
    lengths: &[usize],
    add: &mut dyn FnMut(&mut Jacobian),
) -> Option<Jacobian> {
    if *structure == Structure::MatrixFree || lengths.iter().any(|length| *length != n) {
        return None;
    }
    let mut matrix = Jacobian::with_structure(n, structure);
    add(&mut matrix);
    Some(matrix)
}

/// Writes the product of `matrix`, or of its transpose, and x; NaN without a matrix.
fn write_product(matrix: Option<Jacobian>, add: fn(&Jacobian, f64, &[f64], &mut [f64]), x: &[f64], out: &mut [f64]) {
    match matrix {
        Some(matrix) => {
            out.fill(0.0);
            add(&matrix, 1.0, x, out);
        }
        None => out.fill(f64::NAN),
    }
}

/// Writes the central difference of `product` at v in the direction x.
fn write_difference(product: &mut dyn FnMut(&[f64], &mut [f64]), v: &[f64], x: &[f64], out: &mut [f64]) {
    let largest = max_norm(v);
    let delta = f64::EPSILON.cbrt() * if largest > 0.0 { largest } else { 1.0 } / max_norm(x);
    let shifted = |sign: f64| v.iter().zip(x).map(|(v, x)| v + sign * delta * x).collect::<Vec<_>>();
    let mut minus = vec![0.0; out.len()];
    product(&shifted(1.0), out);
    product(&shifted(-1.0), &mut minus);
    out.iter_mut().zip(&minus).for_each(|(o, m)| *o = (*o - m) / (2.0 * delta));
}

/// Adds `scale` · J to `out` from the n products J e_j: [`VectorField::add_jacobian`] of a matrix-free field that is to run on
/// methods with dense matrices too.
pub fn add_columns<F: VectorField + ?Sized>(field: &F, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
    let n = field.dim();
    let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
    for j in 0..n {
        unit[j] = 1.0;
        field.apply_jacobian(t, v, &unit, &mut column);
        unit[j] = 0.0;
        column.iter().enumerate().for_each(|(i, x)| out.add(i, j, scale * x));
    }
}
