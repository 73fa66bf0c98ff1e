//! Method I on a banded system of one's own: viscous Burgers' flow on 2000 cells, steepening from a sine.

use lsvi::{AutoField, FieldFn, Scalar, State, Structure, Trajectory, method_i};

struct Burgers {
    viscosity: f64,
    cells: usize,
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
            let right = v.get(i + 1).copied().unwrap_or(T::from(0.0));
            let diffusion = (left - v[i] * 2.0 + right) * (self.viscosity * width * width);
            dv[i] = diffusion - (right * right - left * left) * (0.25 * width);
        }
    }
}

fn main() -> Result<(), lsvi::StepError> {
    let field = AutoField::new(Burgers { viscosity: 0.005, cells: 2000 });
    let sine = (1..=2000).map(|i| (std::f64::consts::PI * f64::from(i) / 2001.0).sin()).collect();
    let mut trajectory = Trajectory::new(method_i(&field)?, State::new(0.0, sine), 0.01, 1.0)?;
    while let Some(state) = trajectory.step()? {
        println!("{:.2}  max v = {:.6}", state.t, state.q.iter().fold(0.0, |m: f64, v| m.max(*v)));
    }
    Ok(())
}
