//! Fields with banded and sparse Jacobians.
#![allow(dead_code)] // Each test binary uses some of them.

use std::cell::Cell;

use crate::systems::AnyField;
use lsvi::closure::Linear;
use lsvi::solver::{Augmented, Iterative, StepSolver, Twisted};
use lsvi::{
    Factored, FieldFn, InputError, Jacobian, LeastSquaresStep, Mass, Preconditioner, Scalar, SolveError, StepOperator,
    Structure, VectorField, add_columns,
};

/// The linear solvers of a step, iterative ones to rounding error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum By {
    Augmented,
    Twisted,
    ConjugateGradients,
    Lsmr,
}

impl By {
    pub(crate) const ALL: [Self; 4] = [Self::Augmented, Self::Twisted, Self::ConjugateGradients, Self::Lsmr];

    pub(crate) fn solver(self) -> Box<dyn StepSolver> {
        let rounding = |solver: Iterative<Factored>| Box::new(solver.with_tolerance(1e-15).expect("in (0, 1)"));
        match self {
            Self::Augmented => Box::new(Augmented::new()),
            Self::Twisted => Box::new(Twisted::new()),
            Self::ConjugateGradients => rounding(Iterative::new(Factored::default())),
            Self::Lsmr => rounding(Iterative::lsmr(Factored::default())),
        }
    }

    /// Method I by this solver.
    pub(crate) fn method_i<F: VectorField>(self, field: F) -> Result<LeastSquaresStep<F>, InputError> {
        LeastSquaresStep::with_solver(field, Linear::METHOD_I, self.solver())
    }
}

/// A preconditioner that leaves systems as they are.
pub(crate) struct Unscaled;

impl Preconditioner for Unscaled {
    fn prepare(&mut self, _b: &StepOperator<'_>) -> Result<(), SolveError> {
        Ok(())
    }
    fn solve(&mut self, _x: &mut [f64]) {}
    fn solve_transpose(&mut self, _x: &mut [f64]) {}
}

/// A field with another declared structure.
#[derive(Debug, Clone)]
pub(crate) struct As<F>(pub Structure, pub F);

/// A system of another declared structure, behind a pointer.
pub(crate) fn with_structure<'a>(structure: Structure, field: impl VectorField + 'a) -> As<AnyField<'a>> {
    As(structure, Box::new(field))
}

impl<F: VectorField> VectorField for As<F> {
    fn dim(&self) -> usize {
        self.1.dim()
    }
    fn structure(&self) -> Structure {
        self.0.clone()
    }
    fn mass(&self) -> Mass {
        self.1.mass()
    }
    fn is_linear(&self) -> bool {
        self.1.is_linear()
    }
    fn is_autonomous(&self) -> bool {
        self.1.is_autonomous()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.1.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.1.add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.1.add_curvature(t, v, w, scale, out);
    }
}

impl<F: FieldFn> FieldFn for As<F> {
    fn dim(&self) -> usize {
        self.1.dim()
    }
    fn structure(&self) -> Structure {
        self.0.clone()
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        self.1.rhs(t, v, dv);
    }
}

/// A field that forgets its matrix and keeps the products.
pub(crate) struct Products<F> {
    pub(crate) field: F,
    /// Products with the Jacobian so far.
    pub(crate) applied: Cell<usize>,
}

impl<F> Products<F> {
    pub(crate) fn new(field: F) -> Self {
        Self { field, applied: Cell::new(0) }
    }
}

impl<F: VectorField> VectorField for Products<F> {
    fn dim(&self) -> usize {
        self.field.dim()
    }
    fn structure(&self) -> Structure {
        Structure::MatrixFree
    }
    fn mass(&self) -> Mass {
        self.field.mass()
    }
    fn is_linear(&self) -> bool {
        self.field.is_linear()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.field.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        add_columns(self, t, v, scale, out);
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.applied.set(self.applied.get() + 1);
        self.field.apply_jacobian(t, v, x, out);
    }
    fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
        self.field.apply_transpose(t, v, w, out);
    }
}

/// A field that says that it does not depend on time, and is what it is at t = 1.
pub(crate) struct Autonomous<F>(pub F);

impl<F: VectorField> VectorField for Autonomous<F> {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        self.0.structure()
    }
    fn mass(&self) -> Mass {
        self.0.mass()
    }
    fn is_linear(&self) -> bool {
        self.0.is_linear()
    }
    fn is_autonomous(&self) -> bool {
        true
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(1.0, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_jacobian(t, v, scale, out);
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_curvature(t, v, w, scale, out);
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Walls {
    Dirichlet,
    Neumann,
}

/// v_t = v_xx − peclet v_x + sin t on n cells of (0, 1): a tridiagonal matrix and a source.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    pub(crate) rows: Vec<[f64; 3]>,
    mass: Mass,
    source: Vec<f64>,
}

impl Line {
    pub(crate) fn new(n: usize, peclet: f64, walls: Walls) -> Self {
        let width = (n + 1) as f64;
        let (diffusion, advection) = (width * width, 0.5 * peclet * width);
        let row = |i: usize| {
            let open = if walls == Walls::Neumann { f64::from(i == 0) + f64::from(i + 1 == n) } else { 0.0 };
            [diffusion + advection, -(2.0 - open) * diffusion, diffusion - advection]
        };
        Self { rows: (0..n).map(row).collect(), mass: Mass::Identity, source: vec![1.0; n] }
    }

    pub(crate) fn with_mass(self, mass: Mass) -> Self {
        Self { mass, ..self }
    }

    pub(crate) fn without_source(mut self) -> Self {
        self.source.fill(0.0);
        self
    }

    /// The same with A replaced by S A S and the source by S g, S diagonal.
    pub(crate) fn scaled(&self, s: &[f64]) -> Self {
        let n = s.len();
        let row = |i: usize| {
            let [a, b, c] = self.rows[i];
            let (left, right) = (if i > 0 { s[i - 1] } else { 0.0 }, if i + 1 < n { s[i + 1] } else { 0.0 });
            [s[i] * a * left, s[i] * b * s[i], s[i] * c * right]
        };
        let source = self.source.iter().zip(s).map(|(g, s)| g * s).collect();
        Self { rows: (0..n).map(row).collect(), mass: Mass::Identity, source }
    }
}

impl VectorField for Line {
    fn dim(&self) -> usize {
        self.rows.len()
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 1, upper: 1 }
    }
    fn mass(&self) -> Mass {
        self.mass.clone()
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        let n = v.len();
        for (i, [a, b, c]) in self.rows.iter().enumerate() {
            let left = if i > 0 { v[i - 1] } else { 0.0 };
            let right = if i + 1 < n { v[i + 1] } else { 0.0 };
            dv[i] = a * left + b * v[i] + c * right + self.source[i] * t.sin();
        }
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        for (i, [a, b, c]) in self.rows.iter().enumerate() {
            if i > 0 {
                out.add(i, i - 1, scale * a);
            }
            out.add(i, i, scale * b);
            if i + 1 < v.len() {
                out.add(i, i + 1, scale * c);
            }
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

/// The five-point Laplacian on side² cells of the unit square.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    pub side: usize,
}

impl Plane {
    fn neighbours(&self, p: usize) -> impl Iterator<Item = usize> {
        let (side, x, y) = (self.side, p % self.side, p / self.side);
        [(x > 0, p.wrapping_sub(1)), (x + 1 < side, p + 1), (y > 0, p.wrapping_sub(side)), (y + 1 < side, p + side)]
            .into_iter()
            .filter_map(|(inside, q)| inside.then_some(q))
    }

    fn weight(&self) -> f64 {
        ((self.side + 1) * (self.side + 1)) as f64
    }
}

impl VectorField for Plane {
    fn dim(&self) -> usize {
        self.side * self.side
    }
    fn structure(&self) -> Structure {
        let positions = (0..self.dim()).flat_map(|p| self.neighbours(p).map(move |q| (p, q)));
        Structure::sparse(self.dim(), positions).expect("inside")
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        for (p, dv) in dv.iter_mut().enumerate() {
            *dv = self.weight() * (self.neighbours(p).map(|q| v[q]).sum::<f64>() - 4.0 * v[p]);
        }
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        for p in 0..v.len() {
            out.add(p, p, -4.0 * scale * self.weight());
            self.neighbours(p).for_each(|q| out.add(p, q, scale * self.weight()));
        }
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

/// Viscous Burgers' equation v_t = ν v_xx − v v_x on cells of (0, 1), zero at the walls.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Burgers {
    pub cells: usize,
    pub viscosity: f64,
}

impl FieldFn for Burgers {
    fn dim(&self) -> usize {
        self.cells
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 1, upper: 1 }
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let width = (self.cells + 1) as f64;
        for i in 0..v.len() {
            let left = if i > 0 { v[i - 1] } else { T::from(0.0) };
            let right = if i + 1 < v.len() { v[i + 1] } else { T::from(0.0) };
            dv[i] =
                (left - v[i] * 2.0 + right) * (self.viscosity * width * width) - v[i] * (right - left) * (0.5 * width);
        }
    }
}

/// v̇ = −v² on three unknowns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drag;

impl FieldFn for Drag {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -*v * *v);
    }
}
