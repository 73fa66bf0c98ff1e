//! The same problem in other coordinates: every method commutes with shifts of time, changes of units and rotations.

use lsvi::{
    AutoField, AutoLagrangian, FieldFn, LagrangianFn, Scalar, State, Trajectory, VectorField, position_momentum,
};
use nalgebra::Rotation3;
use proptest::prelude::*;
use verify::kinds::Principle;
use verify::measure::norm::distance;
use verify::method::{self, Method};
use verify::problem::Problem;
use verify::reference::Ode;

/// Coordinates w = s Q v and time τ = (t − t₀)/r.
#[derive(Debug, Clone, Copy)]
struct Frame {
    rotation: [[f64; 3]; 3],
    unit: f64,
    rate: f64,
    shift: f64,
    /// Unit of the action.
    action: f64,
}

impl Frame {
    const OWN: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        unit: 1.0,
        rate: 1.0,
        shift: 0.0,
        action: 1.0,
    };

    /// `factor` Qᵀ w.
    fn back<T: Scalar>(&self, factor: f64, w: &[T]) -> [T; 3] {
        [0, 1, 2]
            .map(|j| (w[0] * self.rotation[0][j] + w[1] * self.rotation[1][j] + w[2] * self.rotation[2][j]) * factor)
    }

    /// `factor` Q v.
    fn there<T: Scalar>(&self, factor: f64, v: [T; 3]) -> [T; 3] {
        self.rotation.map(|row| (v[0] * row[0] + v[1] * row[1] + v[2] * row[2]) * factor)
    }

    fn starts(&self) -> f64 {
        -self.shift / self.rate
    }
}

/// v̇ = −A v − 0.3 |v|² v + (sin t, cos 2t, 0), A not normal, in a frame.
#[derive(Debug)]
struct Field(Frame);

impl FieldFn for Field {
    fn dim(&self) -> usize {
        3
    }
    fn rhs<T: Scalar>(&self, tau: f64, w: &[T], dw: &mut [T]) {
        let (t, v) = (self.0.rate * tau + self.0.shift, self.0.back(self.0.unit.recip(), w));
        let drag = v.iter().map(|v| *v * *v).sum::<T>() * 0.3;
        let f = [
            -v[0] * (drag + 1.0) - v[1] * 2.0 + t.sin(),
            v[0] * 0.5 - v[1] * (drag + 0.7) + (2.0 * t).cos(),
            v[0] - v[2] * (drag + 3.0),
        ];
        dw.copy_from_slice(&self.0.there(self.0.rate * self.0.unit, f));
    }
}

/// [`Field`] as a problem, for methods to be built on.
#[derive(Debug)]
struct Framed(Field);

impl Problem for Framed {
    fn components(&self) -> &'static [&'static str] {
        &["x", "y", "z"]
    }
    fn initial(&self) -> Vec<f64> {
        self.0.0.there(self.0.0.unit, [1.0, -0.5, 0.25]).to_vec()
    }
    fn field(&self) -> Box<dyn VectorField + '_> {
        Box::new(AutoField::new(&self.0))
    }
    fn ode(&self) -> &dyn Ode {
        &self.0
    }
}

impl Ode for Field {
    fn dim(&self) -> usize {
        3
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        FieldFn::rhs(self, t, v, dv);
    }
    fn jacobian(&self, _: f64, _: &[f64], _: &mut dyn FnMut(usize, usize, f64)) {
        unreachable!("no reference solves it");
    }
}

/// A charge in an anisotropic well, a force that changes with time and, where it has one, a magnetic field, in a frame.
#[derive(Debug)]
struct Charge {
    frame: Frame,
    has_field: bool,
}

impl LagrangianFn for Charge {
    fn dim(&self) -> usize {
        3
    }
    fn is_separable(&self) -> bool {
        !self.has_field
    }
    fn lagrangian<T: Scalar>(&self, tau: T, q: &[T], v: &[T]) -> T {
        let Self { frame: Frame { unit, rate, shift, action, .. }, has_field } = *self;
        let back = |unit: f64, x: &[T]| self.frame.back(unit.recip(), x);
        let (t, q, v) = (tau * rate + shift, back(unit, q), back(rate * unit, v));
        let kinetic = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * 0.5;
        let well = q[0] * q[0] + q[1] * q[1] * 2.0 + q[2].powi(4);
        let field = if has_field { (q[0] * v[1] - q[1] * v[0]) * (q[0] * q[0] + 0.5) } else { T::from(0.0) };
        (kinetic + field - well - q[2] * t.sin()) * action
    }
}

const STEPS: f64 = 8.0;
const H: f64 = 0.05;

/// The state after some steps, in the coordinates of the problem itself.
fn field_end(method: &dyn Method, frame: Frame) -> Vec<f64> {
    // Its argument is a rate.
    let in_units = method.name().strip_suffix("(4.0)").map(|kind| format!("{kind}({:e})", 4.0 * frame.rate));
    let in_units = in_units.map(|name| method::parse(&name).expect("a rate"));
    let method = in_units.as_deref().unwrap_or(method);
    let problem = Framed(Field(frame));
    let (h, start) = (H / frame.rate, frame.starts());
    let integrator = method.build(&problem).expect("it applies");
    let state = State::new(start, problem.initial());
    let trajectory = Trajectory::new(integrator, state, h, start + STEPS * h).expect("a grid");
    let end = trajectory.observe(|_| {}).unwrap_or_else(|error| panic!("{}: {error}", method.name()));
    frame.back(frame.unit.recip(), &end.q).to_vec()
}

/// The same of a mechanical system, momenta after coordinates, without the magnetic field for a method that knows none; nothing
/// for a method that is not of mechanics.
fn charge_end(method: &dyn Method, frame: Frame) -> Option<Vec<f64>> {
    let discretise = |has_field| method.discretise(Box::new(AutoLagrangian::new(Charge { frame, has_field })));
    let discrete = discretise(true)?.or_else(|_| discretise(false).expect("as before")).expect("it has nodes");
    let (h, start) = (H / frame.rate, frame.starts());
    let momenta = frame.action / (frame.rate * frame.unit);
    let q = frame.there(frame.unit, [1.0, -0.5, 0.25]).to_vec();
    let p = frame.there(momenta, [0.1, 0.4, -0.3]).to_vec();
    let state = State::new(start, q).with_momentum(p);
    let trajectory = Trajectory::new(position_momentum(discrete), state, h, start + STEPS * h).expect("a grid");
    let end = trajectory.observe(|_| {}).unwrap_or_else(|error| panic!("{}: {error}", method.name()));
    let (q, p) = (frame.back(frame.unit.recip(), &end.q), frame.back(momenta.recip(), &end.p));
    Some([q, p].concat())
}

fn frame() -> impl Strategy<Value = Frame> {
    let angles = (-3.0..3.0, -1.5..1.5, -3.0..3.0).prop_map(|(roll, pitch, yaw)| {
        let q = Rotation3::from_euler_angles(roll, pitch, yaw);
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| q[(i, j)]))
    });
    let powers = || (-3.0..3.0_f64).prop_map(|x| 10_f64.powf(x));
    (angles, powers(), powers(), -3.0..3.0, powers()).prop_map(|(rotation, unit, rate, shift, action)| Frame {
        rotation,
        unit,
        rate,
        shift,
        action,
    })
}

/// Each of the steps rounds about a hundred terms of the size of the state, also where it is carried to the end by the conditions
/// of the step's equations, below a hundred; the times of the frame are rounded to parts of its shift, which is 8 steps or more.
const TERMS: f64 = 100.0;

/// In a momentum, besides, four roundings of the path at the nodes, which is what Newton's iteration leaves, over h and by its derivative: of a
/// polynomial of degree s on the step that of one node is s² at most, and there is none of a higher degree than four.
const TERMS_OF_MOTION: f64 = TERMS + 4.0 * 16.0 / H;

fn assert_same(name: &str, a: &[f64], b: &[f64], terms: f64, frame: Frame) {
    let apart = distance(a, b);
    let allowed = terms * STEPS * f64::EPSILON * (1.0 + frame.shift.abs());
    assert!(apart <= allowed, "{name}: {apart:e} more than {allowed:e} in {frame:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn methods_commute_with_changes_of_frame(frame in frame()) {
        for method in method::examples() {
            let name = method.name();
            if let Some(end) = charge_end(&*method, frame) {
                assert_same(&name, &end, &charge_end(&*method, Frame::OWN).expect("as before"), TERMS_OF_MOTION, frame);
            } else if method.principle() != Principle::Hamilton {
                assert_same(&name, &field_end(&*method, frame), &field_end(&*method, Frame::OWN), TERMS, frame);
            }
        }
    }
}
