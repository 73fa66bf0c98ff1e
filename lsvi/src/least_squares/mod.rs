//! Linear closures of the trapezoidal least-squares Lagrangian: Methods I and II and the (α, β) family.
//!
//! In the natural metric M⁻¹ the action of one step is ¼h (r₀ᵀM⁻¹r₀ + r₁ᵀM⁻¹r₁), r = M (v₁ − v₀)/h − f, and with B = M − h f_v
//!
//! - 2h p₀ = h r₀ + h r₁ + h J₀ᵀM⁻¹ h r₀,
//! - 2h p₁ = h r₀ + h r₁ − h J₁ᵀM⁻¹ h r₁ = h r₀ + B₁ᵀM⁻¹ h r₁.
//!
//! | f_v | closure | equation | solved by |
//! |---|---|---|---|
//! | dense | any | α p₀ + β p₁ = 0, and where that leads nowhere augmented | Newton's method |
//! | banded, sparse | any | augmented by y = −M⁻¹(M v₁ − h f₁), as well conditioned as B | Newton's method |
//! | any, f linear, more than a few unknowns | Method I | M y + B v₁, Bᵀy − M v₁ given | a [`StepSolver`], factored once |
//! | any, with a solver | Method I | minimum of the action | Gauss–Newton and a [`StepSolver`] |
//! | any, with a solver | any other | α p₀ + β p₁ = 0 | inexact Newton and a [`StepSolver`] |

mod closed;
mod declared;
mod dense;
mod gauss_newton;
mod linear;
mod newton;
mod rank;

use closed::ClosedStep;
use declared::Declared;
use dense::DenseStep;
use gauss_newton::GaussNewton;
use linear::LinearStep;
use newton::FullNewton;
use rank::Rank;

use crate::closure::{Linear, LinearClosure};
use crate::discrete::Interval;
use crate::error::{InputError, SolveError, StepError, SystemError, check_step_from, check_vector};
use crate::integrator::{Grid, Integrator, OneStep, State, advance_one_step, shorter_step};
use crate::linalg::{Jacobian, Structure, is_zero};
use crate::mass::{Mass, MassInverse, rate};
use crate::newton::Work;
use crate::operator::StepOperator;
use crate::solver::{StepSolver, assembled_structure};
use crate::vector_field::{VectorField, check_system};

/// Unknowns of a dense field up to which steps are compiled for it whatever it declares: an iteration costs less than a solver's work space.
const COMPILED: usize = 4;

/// Method I, p₁ = 0: Eq. (22) on v̇ = −v, second order, L-stable on symmetric dissipative systems.
///
/// Least squares weigh the residuals of all components alike. Where f_v is far from symmetric, as in chemistry with heat, the error constant can
/// be a thousand times that of other methods of second order, in components of like units too; least squares on paths of
/// [`Galerkin`](crate::discrete::Galerkin) with Radau nodes are Radau IIA and have its error. In long steps growth is damped like decay: a run may
/// come to rest at a steady state that repels. Large sparse nonlinear systems may be solved faster by [`with_solver`](LeastSquaresStep::with_solver).
///
/// # Errors
/// As for [`LeastSquaresStep::new`].
pub fn method_i<F: VectorField>(field: F) -> Result<LeastSquaresStep<F>, InputError> {
    LeastSquaresStep::new(field, Linear::METHOD_I)
}

/// Method II, p₁ = p₀: Eq. (25) on v̇ = −v, the trapezoidal rule for linear f.
///
/// Its condition J₀ᵀr₀ + J₁ᵀr₁ = 0 has no content where J = f_v is singular, as it is everywhere where a linear combination of the components is
/// conserved, as in a closed chemical reaction. A step from there is [`SolveError::Singular`], or where roundings of J hide that mostly
/// [`SolveError::BranchLost`], unless it starts at rest or J is not assembled. A step
/// across, in which an eigenvalue of J changes its sign, ends where the branch of the solution crosses that of a state that
/// stands still, [`SolveError::BranchLost`]; in a system the two can pass into each other, and the mode of that eigenvalue then
/// stands still for the step, an error of order h. Growth that saturates crosses such a place, as v̇ = v(1 − v) does at ½.
///
/// # Errors
/// As for [`LeastSquaresStep::new`].
pub fn method_ii<F: VectorField>(field: F) -> Result<LeastSquaresStep<F>, InputError> {
    LeastSquaresStep::new(field, Linear::METHOD_II)
}

/// A linear closure of the trapezoidal least-squares Lagrangian of `field`, Eqs. (26), (27).
///
/// # Errors
/// As for [`LeastSquaresStep::new`].
pub fn least_squares<F: VectorField>(field: F, closure: Linear) -> Result<LeastSquaresStep<F>, InputError> {
    LeastSquaresStep::new(field, closure)
}

/// The integrator of M v̇ = f(t, v) by a linear closure of the trapezoidal least-squares Lagrangian in the natural metric M⁻¹.
///
/// A step costs in proportion to the entries of a banded or sparse [`structure`](VectorField::structure), and in proportion to
/// the products of a matrix-free field. Another metric, or the derivative of a step, is for
/// [`Variational`](crate::Variational) with [`LeastSquares`](crate::LeastSquares), which is dense.
///
/// # Solutions that end
/// The action has a minimum for steps of any size, and the branch of Method I that starts at the present state can go on where
/// the solution does not. Nothing in one step tells: there is a root, it is the right one, and a stiff solution leaves as large
/// a residual. So a pole within a step is not seen; two step sizes that disagree show it, and implicit stages lose their branch.
///
/// ```
/// use lsvi::classic::{RungeKutta, Tableau};
/// use lsvi::{OneStep, SolveError, StepError, field, method_i};
///
/// // v̇ = v² from 1 ends at t = 1.
/// let growth = || field!(1, |_t, v, dv| dv[0] = v[0] * v[0]);
/// let (mut one, mut two) = ([1.0], [1.0]);
/// method_i(growth())?.step(0.0, 2.0, &mut one, &mut [0.0])?;
/// let mut halves = method_i(growth())?;
/// for t in [0.0, 1.0] {
///     halves.step(t, 1.0, &mut two, &mut [0.0])?;
/// }
/// assert!((one[0] - two[0]).abs() > 0.2);
///
/// let mut midpoint = RungeKutta::new(growth(), Tableau::implicit_midpoint())?;
/// let error = midpoint.step(0.0, 2.0, &mut [1.0], &mut [0.0]);
/// assert!(matches!(error, Err(StepError::Solve { source: SolveError::BranchLost { .. }, .. })));
/// # Ok::<(), StepError>(())
/// ```
#[derive(Debug)]
pub struct LeastSquaresStep<F> {
    field: F,
    mass: Mass,
    mass_inverse: MassInverse,
    closure: Linear,
    declared: Option<Declared>,
    /// Of a closure without a limit of its own on a field that assembles its Jacobian.
    rank: Option<Rank>,
    equations: Equations,
    next: Vec<f64>,
    rate: Vec<f64>,
    work: Work,
}

impl<F: VectorField> LeastSquaresStep<F> {
    /// Solves by Newton's method with factors, on the branch that is continuous in h.
    ///
    /// # Errors
    /// [`SystemError::Metric`] if M is not symmetric positive definite, [`SystemError::NotAssembled`] if the field is matrix-free
    /// or M an operator: then give a solver.
    pub fn new(field: F, closure: Linear) -> Result<Self, InputError> {
        let (structure, mass) = (field.structure(), field.mass());
        if structure == Structure::MatrixFree || matches!(mass, Mass::Operator(_)) {
            return Err(InputError::System(SystemError::NotAssembled));
        }
        Self::of(field, closure, None)
    }

    /// Solves the linear systems of a step with `solver`, whatever the structure of the field.
    ///
    /// Method I on a nonlinear f is then the Gauss–Newton iteration with Levenberg–Marquardt damping, which descends from v₀ to
    /// a minimum of the action. It converges where Newton's method meets the end of its branch; for steps that long it may find
    /// another minimum than the one continuous in h. Other closures are solved by an inexact Newton method, held to the branch
    /// by its contraction alone. Where f_v is singular a closure with α + β = 0, as Method II, has many solutions: factors find
    /// that out and fail, an iterative solver can return one of them.
    ///
    /// # Errors
    /// [`SystemError::Metric`] if M is not symmetric positive definite; [`SystemError::NotAssembled`] or [`SystemError::Solver`] if
    /// the solver does not fit: a closure with α ≠ 0 needs one that [takes products](StepSolver::takes_products).
    pub fn with_solver(field: F, closure: Linear, solver: impl StepSolver + 'static) -> Result<Self, InputError> {
        solver.check(&field.structure(), &field.mass())?;
        if !closure.is_end_alone() && !solver.takes_products() {
            let what = "closures other than Method I need a solver that works with products, such as Iterative";
            return Err(InputError::System(SystemError::Solver(what)));
        }
        Self::of(field, closure, Some(Box::new(solver)))
    }

    fn of(field: F, closure: Linear, solver: Option<Box<dyn StepSolver>>) -> Result<Self, InputError> {
        let (n, structure, mass) = (field.dim(), assembled_structure(&field), field.mass());
        check_system(&field)?;
        let mass_inverse = mass.metric(n)?;
        let declared = Declared::of(&field, &structure);
        let is_method_i = closure.is_end_alone();
        let is_assembled = structure != Structure::MatrixFree;
        let rank = (!closure.has_limit() && is_assembled).then(|| Rank::new(n, &structure));
        // Few unknowns are stepped by what is compiled for f; of more, factors that serve all steps save what a step costs.
        let is_affine = is_method_i && field.is_linear();
        let equations = match solver {
            None if structure == Structure::Dense && !(is_affine && n > COMPILED) => {
                Equations::Dense(Box::new(DenseStep::new(n)))
            }
            solver if is_affine => Equations::Linear(Box::new(LinearStep::new(n, &structure, &mass, solver))),
            Some(solver) if is_method_i => Equations::GaussNewton(Box::new(GaussNewton::new(n, &structure, solver))),
            Some(solver) => {
                Equations::Closed(Box::new(ClosedStep::new(n, [&structure, &field.curvature_structure()], solver)))
            }
            None => Equations::Newton(Box::new(FullNewton::new(n, [&structure, &field.curvature_structure()], &mass))),
        };
        Ok(Self {
            field,
            mass,
            mass_inverse,
            closure,
            declared,
            rank,
            equations,
            next: vec![0.0; n],
            rate: vec![0.0; n],
            work: Work::default(),
        })
    }
}

/// M v̇ = f(t, v). What the steps of few unknowns are compiled for is f itself.
struct System<'a, F: ?Sized = dyn VectorField + 'a> {
    field: &'a F,
    mass: &'a Mass,
    mass_inverse: &'a MassInverse,
}

impl<F: ?Sized> Clone for System<'_, F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F: ?Sized> Copy for System<'_, F> {}

impl System<'_> {
    /// B at (t, v), and as a matrix if it was assembled.
    fn operator<'b>(&'b self, (t, v): (f64, &'b [f64]), h: f64, b: Option<&'b Jacobian>) -> StepOperator<'b> {
        StepOperator::new(self.field, self.mass, (t, v), h, b).with_mass_inverse(self.mass_inverse)
    }

    /// Sets `b` to M − h f_v(t, v).
    fn set_b(&self, t: f64, h: f64, v: &[f64], b: &mut Jacobian) {
        b.clear();
        self.mass.add_to(1.0, b);
        self.field.add_jacobian(t, v, -h, b);
    }

    /// Writes the diagonals of M and of the matrix M + BᵀM⁻¹B of the normal equations, with 1/M_ii, which (M⁻¹)_ii is no less than, for M⁻¹.
    fn diagonals(&self, b: &Jacobian, inertia: &mut [f64], normal: &mut [f64]) {
        self.mass.for_each(inertia.len(), |i, j, m| {
            if i == j {
                inertia[i] = m
            }
        });
        normal.copy_from_slice(inertia);
        b.for_each(|i, j, x| normal[j] += x * x / inertia[i]);
    }
}

/// The step equations with their work space.
#[derive(Debug)]
enum Equations {
    Linear(Box<LinearStep>),
    Dense(Box<DenseStep>),
    Newton(Box<FullNewton>),
    GaussNewton(Box<GaussNewton>),
    Closed(Box<ClosedStep>),
}

impl Equations {
    /// f at the start of the step, and the Jacobian there if it is assembled.
    fn start(&self) -> Option<(&[f64], &Jacobian)> {
        let (f0, start) = match self {
            Self::Dense(step) => step.start(),
            Self::Newton(step) => step.start(),
            Self::Closed(step) => step.start(),
            Self::Linear(_) | Self::GaussNewton(_) => return None,
        };
        Some((f0, start?))
    }
}

/// Whether the condition of the closure leaves a step from `v` open, which is no rest.
#[cold]
fn is_undetermined(
    rank: &mut Option<Rank>,
    equations: &Equations,
    (mass, closure): (&Mass, &Linear),
    at: Interval,
    v: &[f64],
    terms: &mut [f64],
) -> bool {
    let (Some(rank), Some((f0, start))) = (rank, equations.start()) else { return false };
    rank.is_deficient(mass, closure.weights(at.h), at.h, start) && !rank::is_at_rest(f0, start, v, terms)
}

impl<F: VectorField> LeastSquaresStep<F> {
    /// Takes a step of a linear field in one pass over what is known of steps of this size; false, and nothing changed, where there is none.
    fn march(&mut self, h: f64, v: &mut [f64], p: &[f64]) -> bool {
        let n = self.field.dim();
        let Equations::Linear(step) = &mut self.equations else { return false };
        // Momenta other than zero are replaced, or refused, by the other steps.
        let fits = v.len() == n && p.len() == n && is_zero(p);
        let has_marched = fits && step.march(&self.mass, h, v);
        if has_marched {
            self.work.residuals += 1;
            self.work.steps += 1;
        }
        has_marched
    }

    /// Refuses a field that is not what it declares.
    #[cold]
    fn check_declared(&mut self, at: Interval, v: &[f64]) -> Result<(), SolveError> {
        let Self { field, mass, mass_inverse, declared, .. } = self;
        declared.as_mut().map_or(Ok(()), |declared| declared.check(&System { field, mass, mass_inverse }, at, v))
    }
}

impl<F: VectorField> Integrator for LeastSquaresStep<F> {
    fn dim(&self) -> usize {
        self.next.len()
    }

    fn advance(&mut self, state: &mut State, grid: &Grid) -> Result<(), StepError> {
        advance_one_step(self, state, grid)
    }

    fn rate(&mut self, state: &State, out: &mut [f64]) -> Result<(), StepError> {
        Ok(rate(&self.field, &self.mass, state, out)?)
    }

    fn shorter_step(&mut self, from: &State, t: f64, to: &mut State) -> Option<Result<(), StepError>> {
        shorter_step(self, from, t, to)
    }

    fn work(&self) -> Work {
        self.work
    }
}

impl<F: VectorField> OneStep for LeastSquaresStep<F> {
    fn step(&mut self, t: f64, h: f64, v: &mut [f64], p: &mut [f64]) -> Result<(), StepError> {
        check_step_from(t, h)?;
        let n = self.field.dim();
        let is_due = self.declared.as_mut().is_some_and(|declared| declared.is_due(h));
        if !is_due && self.march(h, v, p) {
            return Ok(());
        }
        check_vector("q", v, n)?;
        check_vector("p", p, n)?;
        let failed = |source| StepError::Solve { t, h, source };
        if is_due {
            self.check_declared(Interval { start: t, h }, v).map_err(failed)?;
            if self.march(h, v, p) {
                return Ok(());
            }
        }
        // Where the dimension is a constant, so are the lengths of what is copied.
        let (v, p) = (&mut v[..n], &mut p[..n]);
        let Self { field, mass, mass_inverse, .. } = self;
        let (field, any, at): (_, &dyn VectorField, _) = (&*field, &*field, Interval { start: t, h });
        let (of_few, system) = (|| System { field, mass, mass_inverse }, || System { field: any, mass, mass_inverse });
        let (closure, next, work) = (&self.closure, &mut self.next, &mut self.work);
        let solved = match &mut self.equations {
            Equations::Linear(step) => step.solve(system(), at, v, next, work),
            Equations::GaussNewton(step) => step.solve(system(), at, v, next, work),
            Equations::Dense(step) => step.solve((of_few(), closure), at, v, next, work),
            Equations::Newton(step) => step.solve((system(), closure), at, v, next, work),
            Equations::Closed(step) => step.solve((system(), closure), at, v, next, work),
        };
        if let Err(source) = solved {
            let is_free = source.is_lost()
                && is_undetermined(&mut self.rank, &self.equations, (mass, closure), at, v, &mut self.rate);
            return Err(failed(if is_free { SolveError::Singular } else { source }));
        }
        if let (Equations::Linear(step), Some(declared)) = (&self.equations, &mut self.declared) {
            declared.check_end(&system(), at, next, step.end_forcing()).map_err(failed)?;
        }
        if !closure.has_limit()
            && is_undetermined(&mut self.rank, &self.equations, (mass, closure), at, v, &mut self.rate)
        {
            return Err(failed(SolveError::Singular));
        }
        match &mut self.equations {
            _ if self.closure.is_end_alone() => p.fill(0.0),
            Equations::Dense(step) => step.momentum(of_few(), at, v, &self.next, p),
            Equations::Newton(step) => step.momentum(system(), at, v, p),
            Equations::Closed(step) => step.momentum(system(), at, v, &self.next, p),
            _ => p.fill(0.0),
        }
        v.copy_from_slice(&self.next[..n]);
        self.work.steps += 1;
        Ok(())
    }
}
