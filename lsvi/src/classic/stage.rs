//! Implicit stages, solved with factors or by a solver of the user's.

use super::linear::LinearStage;
use crate::error::{InputError, SolveError};
use crate::inexact::{InexactNewton, InexactSystem};
use crate::linalg::{Jacobian, Structure};
use crate::mass::Mass;
use crate::newton::{Newton, System, Work};
use crate::operator::{Operator, StepOperator};
use crate::solver::{StepSolver, assembled_structure};
use crate::vector_field::VectorField;

/// How the equations of stages are solved.
#[derive(Debug)]
pub(super) enum Stages {
    Factored(Box<FactoredStage>),
    Solved(Box<StageSolver>),
}

impl Stages {
    /// For a field with the entries of its derivative.
    pub(super) fn factored(field: &dyn VectorField) -> Self {
        let newton = Newton::with_structure(field.dim(), &field.structure());
        Self::Factored(Box::new(FactoredStage { newton, linear: LinearStage::new(field) }))
    }

    pub(super) fn work(&self) -> Work {
        match self {
            Self::Factored(stages) => stages.newton.work,
            Self::Solved(stages) => stages.newton.work,
        }
    }

    pub(super) fn work_mut(&mut self) -> &mut Work {
        match self {
            Self::Factored(stages) => &mut stages.newton.work,
            Self::Solved(stages) => &mut stages.newton.work,
        }
    }

    pub(super) fn solve(&mut self, stage: &mut dyn InexactStage, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        match self {
            Self::Factored(stages) => stages.solve(stage, h, x),
            Self::Solved(stages) => {
                let StageSolver { newton, solver, b, work } = &mut **stages;
                newton.solve(&mut Solved { stage, solver: &mut **solver, b, work }, h, x)
            }
        }
    }
}

/// An equation M x − s f(t, x) = known, whose derivative is a [`StepOperator`].
pub(super) trait InexactStage: System {
    /// The field, M, t and s of a step of size `h`.
    fn at(&self, h: f64) -> (&dyn VectorField, &Mass, f64, f64);
}

#[derive(Debug)]
pub(super) struct FactoredStage {
    newton: Newton,
    linear: Option<LinearStage>,
}

impl FactoredStage {
    fn solve(&mut self, stage: &mut dyn InexactStage, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        let Self { newton, linear } = self;
        // Newton's method says what is wrong where the matrix has no factors.
        let is_solved = linear.as_mut().is_some_and(|linear| linear.solve(stage, h, x, &mut newton.work));
        if is_solved { Ok(()) } else { newton.solve(stage, h, x) }
    }
}

#[derive(Debug)]
pub(super) struct StageSolver {
    newton: InexactNewton,
    solver: Box<dyn StepSolver>,
    /// B, unless the field is matrix-free.
    b: Option<Jacobian>,
    work: [Vec<f64>; 2],
}

impl StageSolver {
    pub(super) fn new(field: &dyn VectorField, solver: impl StepSolver + 'static) -> Result<Self, InputError> {
        let (n, structure) = (field.dim(), assembled_structure(field));
        solver.check(&structure, &field.mass())?;
        Ok(Self {
            newton: InexactNewton::new(n),
            solver: Box::new(solver),
            b: (structure != Structure::MatrixFree).then(|| Jacobian::with_structure(n, &structure)),
            work: [vec![0.0; n], vec![0.0; n]],
        })
    }
}

struct Solved<'a> {
    stage: &'a mut dyn InexactStage,
    solver: &'a mut dyn StepSolver,
    b: &'a mut Option<Jacobian>,
    work: &'a mut [Vec<f64>; 2],
}

impl InexactSystem for Solved<'_> {
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        self.stage.residual(h, x, out);
    }

    fn solve(&mut self, h: f64, x: &[f64], residual: &mut [f64], tolerance: f64) -> Result<u64, SolveError> {
        if let Some(b) = self.b {
            b.clear();
            self.stage.derivative(h, x, b);
            b.check_structure()?;
        }
        let (field, mass, t, s) = self.stage.at(h);
        let b = StepOperator::new(field, mass, (t, x), s, self.b.as_ref());
        self.solver.prepare(&b)?;
        self.solver.solve_stage(&b, residual, tolerance)
    }

    /// By the largest entry of each row: no unknown need have an equation of its own where M is singular.
    fn is_solved_to(&mut self, error: f64, _at: (f64, &[f64]), y: &[f64], residual: &[f64]) -> bool {
        let Some(b) = self.b else { return true };
        let [image, largest] = self.work;
        b.multiply(y, image);
        largest.fill(0.0);
        b.for_each(|i, _, x| largest[i] = largest[i].max(x.abs()));
        let left = image.iter().zip(residual).map(|(by, f)| (by - f).abs());
        left.zip(&*largest).all(|(left, largest)| left <= largest * error)
    }

    fn tolerance(&self) -> f64 {
        self.solver.tolerance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Factored;
    use crate::solver::Iterative;

    /// A stage that nothing is asked of.
    struct Stage;

    impl System for Stage {
        fn dim(&self) -> usize {
            2
        }
        fn residual(&mut self, _h: f64, _x: &[f64], _out: &mut [f64]) {
            unreachable!()
        }
        fn derivative(&mut self, _h: f64, _x: &[f64], _out: &mut Jacobian) {
            unreachable!()
        }
    }

    impl InexactStage for Stage {
        fn at(&self, _h: f64) -> (&dyn VectorField, &Mass, f64, f64) {
            unreachable!()
        }
    }

    /// B y = (−4.5, 2) for y = (1, 1), and the largest entries of the rows are 8 and 3.
    #[test]
    fn each_equation_is_held_to_the_largest_entry_of_its_row() {
        let mut b = Jacobian::zeros(2);
        [(0, 0, 3.5), (0, 1, -8.0), (1, 0, -1.0), (1, 1, 3.0)].into_iter().for_each(|(i, j, x)| b.add(i, j, x));
        let (mut b, mut work, mut solver) =
            (Some(b), [vec![0.0; 2], vec![0.0; 2]], Iterative::new(Factored::default()));
        let mut solved = Solved { stage: &mut Stage, solver: &mut solver, b: &mut b, work: &mut work };
        let error = 1.0 / 1024.0;
        let mut is_solved = |off: [f64; 2]| {
            solved.is_solved_to(error, (0.1, &[0.0; 2]), &[1.0; 2], &[-4.5 + off[0] * error, 2.0 + off[1] * error])
        };
        assert!(is_solved([0.0, 0.0]) && is_solved([8.0, -3.0]) && is_solved([-8.0, 3.0]));
        assert!([[8.001, 0.0], [-8.001, 3.0], [0.0, 3.001], [8.0, -3.001]].into_iter().all(|off| !is_solved(off)));
    }
}
