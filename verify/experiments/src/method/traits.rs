//! What is known of a method, as data.

use crate::kinds::{Principle, Stability, Symplecticity};

/// The attributes of a method, from which [`theory`](crate::theory) derives what it does on a problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Traits {
    /// Nominal order of accuracy on smooth nonlinear problems.
    pub order: u32,
    /// The order on v̇ = A v + b with a symmetric A, if it is another one there.
    pub symmetric_order: Option<u32>,
    /// The order on v̇ = −cv², where it is another.
    pub square_order: Option<u32>,
    /// A rate λ, and the order on v̇ = −λv, of a method that is fitted to it.
    pub fitted: Option<(f64, u32)>,
    /// Order on v̇ = −λ(v − φ(t)) + φ̇ for hλ ≫ 1 (\[HW96\] IV.15); `None` where the error is no power of h at the stiffness of
    /// practical problems.
    pub stiff_order: Option<u32>,
    /// The stiffness λ from which that order shows at steps that resolve φ.
    pub stiff_from: f64,
    /// Whether the errors of that order are divided by λ: where the end of a step solves an equation of its own, as that of a stiffly
    /// accurate method does.
    pub divides_by_rate: bool,
    /// What it steps; decides the limit on a reduced Lagrangian.
    pub principle: Principle,
    /// What limits its step size on stiff problems.
    pub stability: Stability,
    /// On which mechanical systems it preserves the symplectic form.
    pub symplectic: Symplecticity,
    /// Whether a step of −h undoes one of h, so that a motion retraces its path when its momentum is reversed.
    pub is_reversible: bool,
    /// Whether the leading defect of its path is along an even derivative of q.
    pub has_even_defect: bool,
    /// Whether the error terms of order p + 1 in hλ are as large as the leading one down to hλ ≪ 1.
    pub settles_late: bool,
    /// Evaluations of f, or of the force, in what counts as a residual; a product Jᵀr counts as one.
    pub stages: u32,
    /// Rows that one solution of its equations yields: more than one where several steps are found together.
    pub rows_per_solve: usize,
    /// The order that it may rise to, where it chooses that itself.
    pub highest_order: Option<u32>,
    /// Whether it chooses its steps itself, and takes a given h as the longest.
    pub is_adaptive: bool,
    /// The method whose steps it takes with other unknowns, where it does.
    pub restates: Option<String>,
}

impl Traits {
    /// A method of order `order`, at hλ ≫ 1 too, that steps `principle`, one row at a time; neither symplectic nor reversible.
    pub fn new(order: u32, principle: Principle, stability: Stability) -> Self {
        Self {
            order,
            symmetric_order: None,
            square_order: None,
            fitted: None,
            highest_order: None,
            stiff_order: Some(order),
            stiff_from: 0.0,
            divides_by_rate: true,
            principle,
            stability,
            symplectic: Symplecticity::Never,
            is_reversible: false,
            has_even_defect: false,
            settles_late: false,
            stages: 1,
            rows_per_solve: 1,
            is_adaptive: false,
            restates: None,
        }
    }
}
