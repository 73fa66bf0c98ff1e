//! The kernels that are timed.

use lsvi::discrete::{BrokenLine, DiscreteLegendre, Galerkin, Midpoint, Trapezoidal};
use lsvi::{
    AutoField, AutoLagrangian, FieldFn, InputError, Jacobian, LagrangianFn, LeastSquaresStep, OneStep, Scalar,
    StepError, Structure, VectorField, method_i, position_momentum,
};

use super::{Case, Kernel, hand_written};

/// Step size of the small systems.
const H: f64 = 0.01;
/// Steps of one run of them, to t = 10.
const STEPS: usize = 1000;

/// v̇ = −v².
struct Drag;

impl FieldFn for Drag {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0] * v[0];
    }
}

/// Damping of the pendulum.
const DAMPING: f64 = 0.2;

/// θ̇ = ω, ω̇ = −sin θ − c ω.
struct DampedPendulum;

impl FieldFn for DampedPendulum {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = -v[0].sin() - v[1] * DAMPING;
    }
}

/// Kepler's problem.
struct Kepler;

impl LagrangianFn for Kepler {
    fn dim(&self) -> usize {
        2
    }
    fn is_separable(&self) -> bool {
        true
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5 + (q[0] * q[0] + q[1] * q[1]).sqrt().recip()
    }
}

/// Pericentre of an orbit of eccentricity 0.6.
const PERICENTRE: ([f64; 2], [f64; 2]) = ([0.4, 0.0], [0.0, 2.0]);

/// u_t = 2 + u_yy on |y| ≤ 1 in finite differences.
struct Channel {
    cells: usize,
}

impl Channel {
    fn weight(&self) -> f64 {
        ((self.cells + 1) as f64 / 2.0).powi(2)
    }

    /// The step size with h |λ_max| = 1000, at which LDLᵀ of the normal equations keeps ten digits.
    fn step_size(&self) -> f64 {
        250.0 / self.weight()
    }
}

impl VectorField for Channel {
    fn dim(&self) -> usize {
        self.cells
    }
    fn structure(&self) -> Structure {
        Structure::Banded { lower: 1, upper: 1 }
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn is_autonomous(&self) -> bool {
        true
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        let (last, weight) = (v.len() - 1, self.weight());
        for (i, dv) in dv.iter_mut().enumerate() {
            let left = if i > 0 { v[i - 1] } else { 0.0 };
            let right = if i < last { v[i + 1] } else { 0.0 };
            *dv = 2.0 + weight * (left - 2.0 * v[i] + right);
        }
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        let weight = scale * self.weight();
        for i in 0..v.len() {
            out.add(i, i, -2.0 * weight);
            if i > 0 {
                out.add(i, i - 1, weight);
                out.add(i - 1, i, weight);
            }
        }
    }
}

/// (q, p) after so many steps.
fn run(method: &mut impl OneStep, q0: &[f64], p0: &[f64], h: f64, steps: usize) -> Result<[Vec<f64>; 2], StepError> {
    let (mut q, mut p) = (q0.to_vec(), p0.to_vec());
    for k in 0..steps {
        method.step(k as f64 * h, h, &mut q, &mut p)?;
    }
    Ok([q, p])
}

/// Time, in terms of the loop's, that a step of a few unknowns may take.
const FEW: f64 = 2.0;
/// The same where the field is known at run time only.
const FEW_OF_A_BOX: f64 = 5.0;

fn least_squares<F: VectorField + 'static>(
    name: &str,
    wanted: f64,
    field: fn() -> F,
    start: &'static [f64],
    by_hand: fn() -> Vec<f64>,
) -> Case {
    let prepare = move || {
        let mut method = method_i(field())?;
        let rest = vec![0.0; start.len()];
        Ok(Kernel {
            ours: Box::new(move || run(&mut method, start, &rest, H, STEPS).map(|[q, _]| q)),
            by_hand: Box::new(by_hand),
        })
    };
    Case {
        name: name.into(),
        wanted,
        items: STEPS as f64,
        // A few roundings a step, of motions that do not spread.
        rounding: 8.0 * STEPS as f64 * f64::EPSILON,
        prepare: Box::new(prepare),
    }
}

fn kepler<D: DiscreteLegendre + 'static>(
    name: &str,
    discrete: fn(AutoLagrangian<Kepler>) -> Result<D, InputError>,
    by_hand: fn([f64; 2], [f64; 2], f64, usize) -> [f64; 4],
) -> Case {
    let (q0, p0) = PERICENTRE;
    let prepare = move || {
        let mut method = position_momentum(discrete(AutoLagrangian::new(Kepler))?);
        Ok(Kernel {
            ours: Box::new(move || run(&mut method, &q0, &p0, H, STEPS).map(|state| state.concat())),
            by_hand: Box::new(move || by_hand(q0, p0, H, STEPS).to_vec()),
        })
    };
    Case {
        name: name.into(),
        wanted: FEW,
        items: STEPS as f64,
        // A rounding of q is 1/h of one of p; along the orbit errors grow in proportion to time, and each pericentre of the
        // one and a half orbits, where the attraction changes within r³ᐟ² = ¼, multiplies them by ten at most.
        rounding: 100.0 * STEPS as f64 * f64::EPSILON / H,
        prepare: Box::new(prepare),
    }
}

fn channel(cells: usize, steps: usize) -> Case {
    let prepare = move || {
        let field = Channel { cells };
        let h = field.step_size();
        let mut by_hand = hand_written::Channel::new(cells, h);
        let mut method: LeastSquaresStep<Channel> = method_i(field)?;
        let rest = vec![0.0; cells];
        let start = rest.clone();
        Ok(Kernel {
            ours: Box::new(move || run(&mut method, &start, &start, h, steps).map(|[q, _]| q)),
            by_hand: Box::new(move || {
                let mut u = rest.clone();
                (0..steps).for_each(|_| by_hand.step(&mut u));
                u
            }),
        })
    };
    Case {
        name: format!("channel, N = {cells}"),
        wanted: 1.3,
        items: (cells * steps) as f64,
        // The condition number of the normal equations, of 1e6, in each step, of solutions up to 1.
        rounding: 1e6 * steps as f64 * f64::EPSILON,
        prepare: Box::new(prepare),
    }
}

fn drag() -> AutoField<Drag> {
    AutoField::new(Drag)
}

fn damped_pendulum() -> AutoField<DampedPendulum> {
    AutoField::new(DampedPendulum)
}

fn drag_by_hand() -> Vec<f64> {
    vec![hand_written::drag(1.0, H, STEPS)]
}

fn damped_pendulum_by_hand() -> Vec<f64> {
    hand_written::damped_pendulum([1.0, 0.0], DAMPING, H, STEPS).to_vec()
}

/// All cases.
#[must_use]
pub fn all() -> Vec<Case> {
    let boxed_drag = || Box::new(drag()) as Box<dyn VectorField>;
    let boxed_pendulum = || Box::new(damped_pendulum()) as Box<dyn VectorField>;
    let (one, two) = (&[1.0], &[1.0, 0.0]);
    vec![
        least_squares("Method I, quadratic drag", FEW, drag, one, drag_by_hand),
        least_squares("Method I, boxed drag", FEW_OF_A_BOX, boxed_drag, one, drag_by_hand),
        least_squares("Method I, damped pendulum", FEW, damped_pendulum, two, damped_pendulum_by_hand),
        least_squares("Method I, boxed pendulum", FEW_OF_A_BOX, boxed_pendulum, two, damped_pendulum_by_hand),
        kepler("Störmer–Verlet, Kepler", |l| Ok(Trapezoidal::new(l)), hand_written::kepler_verlet),
        kepler("Blanes–Moan, Kepler", BrokenLine::blanes_moan, hand_written::kepler_blanes_moan),
        kepler("midpoint, Kepler", |l| Ok(Midpoint::new(l)), hand_written::kepler_midpoint),
        kepler("Galerkin Gauss-2, Kepler", |l| Galerkin::gauss(l, 2), hand_written::kepler_gauss),
        channel(1000, 500),
        channel(100_000, 20),
        channel(1_000_000, 4),
    ]
}
