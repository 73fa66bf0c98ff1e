//! Least-squares variational integrators: time integration of v̇ = f(t, v) and of mechanics from one idea.
//!
//! *A Lagrangian, a discretisation of its action, and a closure that makes one step a solvable system.*
//!
//! ```
//! use lsvi::{State, Trajectory, field, method_i};
//!
//! // v̇ = −v² by Method I; derivatives are automatic.
//! let drag = field!(1, |_t, v, dv| dv[0] = -v[0] * v[0]);
//! let mut run = Trajectory::new(method_i(drag)?, State::new(0.0, vec![1.0]), 0.1, 10.0)?;
//! while let Some(state) = run.step()? {
//!     println!("{:.1} {:.6}", state.t, state.q[0]);
//! }
//! # Ok::<(), lsvi::StepError>(())
//! ```
//!
//! # Which integrator do I want?
//!
//! | problem | integrator | order |
//! |---|---|---|
//! | stiff, tolerance given | [`adaptive::Radau`] | 5, 9, 13, by tolerance |
//! | stiff and dissipative, fixed steps | least squares on [`Galerkin`](discrete::Galerkin) paths, closed by [`closure::Linear::METHOD_I`] | 2s, with s Radau nodes 2s − 1, with s Lobatto nodes 2s − 2 |
//! | stiff and linear with constant coefficients, equal steps, one factorization | [`RungeKutta`](classic::RungeKutta) by [`Tableau::sdirk2`](classic::Tableau::sdirk2) | 2 |
//! | a single step across a jump | [`method_i`] | 2 |
//! | mechanics L(q, q̇), long runs | [`position_momentum`] of [`Galerkin::gauss`](discrete::Galerkin::gauss) | 2s, symplectic |
//! | the same, L = ½ vᵀMv − V(t, q), forces that are cheap | [`position_momentum`] of [`BrokenLine::blanes_moan`](discrete::BrokenLine::blanes_moan), explicit | 6, symplectic |
//! | L(q, q̇) with forces, or constraints f(q) = 0 | [`Forced`], [`Constrained`] | as without |
//! | two configurations instead of a momentum | [`TwoStep`] | as without |
//! | large and sparse | the first two, with the [`Structure`] of the field declared | |
//! | known by products only | [`method_i`]'s [`LeastSquaresStep`], [`RungeKutta`](classic::RungeKutta) or [`Bdf2`](classic::Bdf2), `with_solver` | 2, or the tableau's |
//! | something to compare with | the baseline methods in [`classic`] | 1, 2, 4, or the tableau's |
//!
//! [`method_ii`] is for comparison: where f_v is singular it has no equation, and growth that saturates passes such places.
//!
//! A mechanical system L = ½ vᵀMv − V(t, q) with a constant M should [say so](Lagrangian::is_separable): its steps then take
//! forces alone, without Hessians, and are several times cheaper.
//!
//! # Without a matrix
//!
//! A field of structure [`Structure::MatrixFree`] gives products with its Jacobian, and its steps are solved iteratively with a
//! [`Preconditioner`] P ≈ M − s f_v:
//!
//! ```
//! use lsvi::{Jacobian, LeastSquaresStep, Preconditioner, SolveError, State, StepOperator, Structure, Trajectory};
//! use lsvi::{VectorField, add_columns, closure::Linear, solver::Iterative};
//!
//! /// v̇_i = −(1 + i) v_i + (the mean of v): its Jacobian is full, and a product with it costs 2n.
//! struct Mixed(usize);
//!
//! impl VectorField for Mixed {
//!     fn dim(&self) -> usize {
//!         self.0
//!     }
//!     fn structure(&self) -> Structure {
//!         Structure::MatrixFree
//!     }
//!     fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
//!         self.apply_jacobian(t, v, v, dv);
//!     }
//!     fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
//!         add_columns(self, t, v, scale, out);
//!     }
//!     fn apply_jacobian(&self, _t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
//!         let mean = x.iter().sum::<f64>() / x.len() as f64;
//!         out.iter_mut().zip(x).enumerate().for_each(|(i, (out, x))| *out = mean - (1 + i) as f64 * x);
//!     }
//!     fn apply_transpose(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
//!         self.apply_jacobian(t, v, x, out);
//!     }
//! }
//!
//! /// The diagonal of M − s f_v without the mean.
//! struct Diagonal(Vec<f64>);
//!
//! impl Preconditioner for Diagonal {
//!     fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
//!         self.0 = (0..b.dim()).map(|i| 1.0 + b.s() * (1 + i) as f64).collect();
//!         Ok(())
//!     }
//!     fn solve(&mut self, x: &mut [f64]) {
//!         x.iter_mut().zip(&self.0).for_each(|(x, d)| *x /= d);
//!     }
//!     fn solve_transpose(&mut self, x: &mut [f64]) {
//!         self.solve(x);
//!     }
//! }
//!
//! let n = 1000;
//! let method = LeastSquaresStep::with_solver(Mixed(n), Linear::METHOD_I, Iterative::new(Diagonal(Vec::new())))?;
//! let mut run = Trajectory::new(method, State::new(0.0, vec![1.0; n]), 0.1, 1.0)?;
//! while run.step()?.is_some() {}
//! assert!(run.state().q[0] > run.state().q[n - 1]);
//! # Ok::<(), lsvi::StepError>(())
//! ```
//!
//! # The parts
//!
//! - A [`Lagrangian`] L(t, q, v): of mechanics, or [`LeastSquares`] of any first-order system v̇ = f(t, v), a [`VectorField`].
//! - A [`DiscreteLegendre`](discrete::DiscreteLegendre) transform: the momenta at the two ends of a step, from a discrete
//!   Lagrangian such as [`Trapezoidal`](discrete::Trapezoidal), [`Midpoint`](discrete::Midpoint),
//!   [`BrokenLine`](discrete::BrokenLine) or [`Galerkin`](discrete::Galerkin), or from a fitted path, [`PathFitted`](discrete::PathFitted).
//! - A [`Closure`](closure::Closure) of the momenta: position–momentum, or the (α, β) family with [`method_i`] and [`method_ii`].
//! - In mechanics also [`Forced`] motions, and [`Constrained`] ones on f(q) = 0.
//! - A [`Variational`] integrator of the two, or a [`Window`] of steps found together, stepped along a [`Trajectory`] like
//!   the baseline methods in [`classic`].
//!
//! Matrices are stored as the [`Structure`] of the field asks, dense, banded or sparse, and steps are solved with their factors.
//! [`LeastSquaresStep`], [`RungeKutta`](classic::RungeKutta) and [`Bdf2`](classic::Bdf2) also take a [`solver`] and a
//! [`Preconditioner`] of your own, and run matrix-free. Galerkin methods, windows and the adaptive method need matrices;
//! constrained motions, and a least-squares metric other than the inverse of a diagonal M, need dense ones.
//!
//! # Units
//!
//! Choose units in which the unknowns are of like size. A step equation is solved to a few roundings of its *largest* unknown:
//! beside one of 10¹², an unknown of 1 may be off by 10⁻³ a step. A dense step in which unlike units hide the branch of the solution is found
//! in units of its own. A least-squares method minimises ½|v̇ − f|² in the Euclidean norm,
//! so that its steps depend on the units where these differ; a metric, [`LeastSquares::with_metric`], weighs the unknowns.
//!
//! # Errors
//!
//! Whatever takes states, settings, coefficients or solvers checks them and returns an [`InputError`]; a step that fails is a
//! [`StepError`] that says where and why, and leaves the state as it was. The functions of a problem itself, those of
//! [`VectorField`], [`Lagrangian`], [`Force`] and [`Constraint`], are called with slices of the lengths that are stated there.
//! Derivatives that a field states by hand are taken for right: a wrong one makes wrong steps of the least-squares methods.
//! [`check_derivatives`] holds them to differences of f, and names the entry that is wrong; [`check_lagrangian`], [`check_motion`],
//! [`check_force`] and [`check_constraint`] do so for mechanics.
//!
//! # Notation
//!
//! | symbol | meaning | in code |
//! |---|---|---|
//! | h | step size | `h` |
//! | q, v = q̇ | configuration and velocity in mechanics | `q`, `v` |
//! | v, v̇ | unknown and its rate in v̇ = f(t, v); the configuration and velocity of its least-squares Lagrangian | `v`, `rate` |
//! | p | momentum conjugate to the configuration | `p` |
//! | L_d(q₀, q₁) | discrete Lagrangian, the action of one step | [`discrete`] |
//! | p₀ = −D₁L_d, p₁ = D₂L_d | discrete Legendre transforms F∓L_d | [`discrete`] |
//! | α p₀ + β p₁ = 0 | linear closure | [`closure::Linear`] |
//!
//! # References
//!
//! Numbers of equations without a key are those of \[S24\].
//!
//! - \[S24\] S. Sungkeetanon et al., *Unconditionally stable symplectic integrators for the Navier–Stokes equations and other
//!   dissipative systems*, 2024.
//! - \[KY21\] X. Kong and X. Yang, *Variational integrators for mechanical systems based on Lagrange interpolation polynomial
//!   fitting*, 2021, doi 10.6052/1672-6553-2020-077.
//! - \[MW01\] J. Marsden and M. West, *Discrete mechanics and variational integrators*, Acta Numerica 10, 2001.
//! - \[HLW06\] E. Hairer, C. Lubich and G. Wanner, *Geometric Numerical Integration*, 2nd ed., Springer, 2006.
//! - \[HNW93\] E. Hairer, S. Nørsett and G. Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., Springer, 1993.
//! - \[HW96\] E. Hairer and G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer, 1996.
//! - \[HW99\] E. Hairer and G. Wanner, *Stiff differential equations solved by Radau methods*, J. Comput. Appl. Math. 111, 1999.
#![forbid(unsafe_code)]

pub mod adaptive;
pub mod classic;
pub mod closure;
pub mod discrete;
pub mod quadrature;
pub mod solver;
pub mod steady;

mod autodiff;
mod coloring;
mod constrained;
mod constraint;
mod derivatives;
mod error;
mod inexact;
mod integrator;
mod lagrangian;
mod least_squares;
mod linalg;
mod mass;
mod newton;
mod operator;
mod pool;
mod trajectory;
mod two_step;
mod variational;
mod vector_field;
mod window;

pub use autodiff::{
    AutoConstraint, AutoField, AutoForce, AutoLagrangian, ConstraintFn, FieldFn, ForceFn, LagrangianFn, Scalar,
};
pub use coloring::Coloring;
pub use constrained::Constrained;
pub use constraint::Constraint;
pub use derivatives::{
    Derivative, DerivativeError, Place, Variable, check_constraint, check_derivatives, check_force, check_lagrangian,
    check_motion,
};
pub use error::{
    ClosureError, ConstraintError, InputError, NodeError, SettingError, SolveError, StepError, SystemError, TimeError,
};
pub use integrator::{Grid, GridStep, Integrator, OneStep, State, Work};
pub use lagrangian::{
    EulerLagrange, Force, Forced, HessianWeights, Lagrangian, LeastSquares, MotionWeights, ResidualForm,
};
pub use least_squares::{LeastSquaresStep, least_squares, method_i, method_ii};
pub use linalg::{Jacobian, Pattern, Structure};
pub use mass::{Mass, MassOperator, SharedMass};
pub use operator::{Factored, Preconditioner, StepOperator};
pub use trajectory::{Crossing, Trajectory};
pub use two_step::TwoStep;
pub use variational::{Variational, position_momentum};
pub use vector_field::{Differences, VectorField, add_columns};
pub use window::Window;

/// The versions of these crates whose types appear in this one's interface.
pub use {nalgebra, num_dual};

/// The program in the README runs.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
