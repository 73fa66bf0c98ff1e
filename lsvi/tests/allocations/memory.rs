//! Memory of a run with a band.

use crate::fields::{Burgers, Line, Walls};
use crate::most_bytes;
use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::classic::{RungeKutta, Tableau};
use lsvi::{AutoField, Integrator, State, Trajectory, VectorField, method_i, method_ii};

/// The most bytes for each of so many cells, with the system, from nothing to the end of two steps.
fn per_cell<F: VectorField, M: Integrator>(cells: usize, field: fn(usize) -> F, method: impl FnOnce(F) -> M) -> f64 {
    let bytes = most_bytes(|| {
        let start = State::new(0.0, vec![0.0; cells]);
        let mut run = Trajectory::new(method(field(cells)), start, 1e-12, 1.0).expect("usable");
        (0..2).for_each(|_| assert!(run.step().expect("solvable").is_some()));
    });
    bytes as f64 / cells as f64
}

fn line(cells: usize) -> Line {
    Line::new(cells, 1.0, Walls::Dirichlet)
}

fn burgers(cells: usize) -> AutoField<Burgers> {
    AutoField::new(Burgers { cells, viscosity: 0.1 })
}

fn radau<F: VectorField>(field: F) -> Radau<F> {
    Radau::new(field, Options::new(Tolerances::new(1e-6, 1e-6).expect("positive"))).expect("valid")
}

/// Method I of a linear field: half a gigabyte at most for a million cells, 500 bytes each. Stages one after the other take little more. What may rise to
/// seven stages has factors for each, and any other least-squares step those of the branch that it compares with.
#[test]
fn what_a_run_holds_is_so_many_bytes_a_cell() {
    fn of(cells: usize) -> [(f64, f64); 7] {
        let sdirk = || Tableau::sdirk2();
        [
            (500.0, per_cell(cells, line, |field| method_i(field).expect("usable"))),
            (550.0, per_cell(cells, line, |field| RungeKutta::new(field, sdirk()).expect("usable"))),
            (550.0, per_cell(cells, burgers, |field| RungeKutta::new(field, sdirk()).expect("usable"))),
            (900.0, per_cell(cells, line, radau)),
            (900.0, per_cell(cells, burgers, radau)),
            (1500.0, per_cell(cells, line, |field| method_ii(field).expect("usable"))),
            (1500.0, per_cell(cells, burgers, |field| method_i(field).expect("usable"))),
        ]
    }
    for ((most, short), (_, long)) in of(10_000).into_iter().zip(of(20_000)) {
        // What does not grow with the cells is a few kilobytes.
        assert!(long <= most && long <= 1.01 * short, "{short} and {long} bytes a cell, {most} at most");
    }
}
