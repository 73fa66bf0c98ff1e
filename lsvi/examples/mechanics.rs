//! Your own mechanical system: a Lagrangian, a path with nodes of your choice, a force, a constraint.
//!
//! `cargo run -p lsvi --example mechanics`

use std::error::Error;

use lsvi::discrete::{Galerkin, PathFitted};
use lsvi::{
    AutoConstraint, AutoForce, AutoLagrangian, Constrained, ConstraintFn, ForceFn, Forced, LagrangianFn, Scalar, State,
    Trajectory, TwoStep, position_momentum,
};

/// A bead of unit mass under unit gravity.
struct Bead;

impl LagrangianFn for Bead {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5 - q[1]
    }
}

/// A parabolic wire.
struct Wire;

impl ConstraintFn for Wire {
    fn dim(&self) -> usize {
        2
    }
    fn count(&self) -> usize {
        1
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = q[1] - q[0] * q[0];
    }
}

/// Quadratic drag.
struct Drag;

impl ForceFn for Drag {
    fn dim(&self) -> usize {
        2
    }
    fn force<T: Scalar>(&self, _t: f64, _q: &[T], v: &[T], out: &mut [T]) {
        let speed = (v[0] * v[0] + v[1] * v[1] + 1e-12).sqrt();
        out[0] = -v[0] * speed * 0.1;
        out[1] = -v[1] * speed * 0.1;
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // On the wire, without drag: symplectic, and the energy stays.
    let discrete = Galerkin::gauss(AutoLagrangian::new(Bead), 2)?;
    let held = Constrained::new(discrete, AutoConstraint::new(Wire))?;
    let energy = |state: &State| 0.5 * (state.p[0].powi(2) + state.p[1].powi(2)) + state.q[1];
    let end = Trajectory::new(held, State::new(0.0, vec![1.0, 1.0]), 0.05, 20.0)?.observe(|_| {})?;
    println!(
        "on the wire: q = {:+.6?}, energy {:.6}, off the wire by {:.1e}",
        end.q,
        energy(&end),
        end.q[1] - end.q[0].powi(2)
    );

    // A throw with drag, along paths that satisfy the equations of motion at nodes of your choice.
    let forced = Forced::new(AutoLagrangian::new(Bead), AutoForce::new(Drag))?;
    let start = State::new(0.0, vec![0.0, 0.0]).with_momentum(vec![2.0, 3.0]);
    let method = position_momentum(PathFitted::new(&forced, &[0.2, 0.8])?);
    let mut positions = Vec::new();
    Trajectory::new(method, start, 0.1, 5.0)?.observe(|state| positions.push(state.q.clone()))?;
    println!("one-step form: q = {:+.6?}", positions[50]);

    // The same from the first two positions alone.
    let mut method = TwoStep::new(PathFitted::new(&forced, &[0.2, 0.8])?);
    let (mut before, mut now) = (positions[0].clone(), positions[1].clone());
    for k in 1..50 {
        method.step(0.1 * f64::from(k), 0.1, &mut before, &mut now)?;
    }
    println!("two-step form: q = {now:+.6?}");

    // Nodes that coincide have an error of their own.
    println!("{}", PathFitted::new(&forced, &[0.5, 0.5]).err().ok_or("it should be refused")?);
    Ok(())
}
