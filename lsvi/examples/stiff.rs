//! A stiff system of one's own by adaptive Radau IIA: the flame of a match, which creeps for half the time and then jumps.
//!
//! `cargo run -p lsvi --example stiff`

use lsvi::adaptive::{Radau, Tolerances};
use lsvi::{AutoField, FieldFn, Scalar, State, Trajectory};

struct Flame;

impl FieldFn for Flame {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[0] * v[0] - v[0] * v[0] * v[0];
    }
}

fn main() -> Result<(), lsvi::StepError> {
    let mut method = Radau::new(AutoField::new(Flame), Tolerances::new(1e-6, 1e-9)?)?;
    method.stop_at(&[1e4])?;
    let longest = 2e4;
    let mut trajectory = Trajectory::new(&mut method, State::new(0.0, vec![1e-4]), longest, 2e4)?;
    while let Some(state) = trajectory.step()? {
        println!("t = {:12.3}   radius = {:.8}", state.t, state.q[0]);
    }
    println!("{:?}, {} rejected", trajectory.work(), method.rejected());
    Ok(())
}
