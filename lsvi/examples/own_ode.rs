//! Your own system by Method I: define f once, generically; derivatives are automatic.
//!
//! `cargo run -p lsvi --example own_ode`

use lsvi::{AutoField, FieldFn, Scalar, State, StepError, Trajectory, method_i};

/// A mass on a spring with cubic stiffness and quadratic drag.
struct Oscillator {
    stiffness: f64,
    drag: f64,
}

impl FieldFn for Oscillator {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let (x, u) = (v[0], v[1]);
        dv[0] = u;
        dv[1] = -x - x.powi(3) * self.stiffness - u * (u * u + 1e-6).sqrt() * self.drag;
    }
}

fn main() -> Result<(), StepError> {
    let method = method_i(AutoField::new(Oscillator { stiffness: 0.5, drag: 0.3 }))?;
    let mut trajectory = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), 0.05, 10.0)?;
    // Each step lends the next state; nothing is allocated on the way.
    while let Some(state) = trajectory.step()? {
        let [x, u] = state.q[..] else { unreachable!("two components") };
        if (state.t * 20.0).round() % 20.0 == 0.0 {
            println!("t = {:5.2}   x = {x:+.6}   u = {u:+.6}", state.t);
        }
    }
    println!("{:?}", trajectory.work());
    Ok(())
}
