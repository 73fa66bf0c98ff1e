//! Flows in a rectangle as systems M ψ̇ = Cᵀ F(C ψ).

use std::cell::RefCell;
use std::fmt;

use lsvi::{Jacobian, Mass, Structure, VectorField};

use super::momentum::{acceleration, derivatives};
use super::staggered::{Component, Rectangle, Space};

/// What a flow in a rectangle is given: values on the boundary, and a force.
pub(crate) trait Given: fmt::Debug + Send + Sync {
    /// The stream function: on the boundary, and everywhere at t = 0.
    fn stream(&self, _at: [f64; 2], _t: f64) -> f64 {
        0.0
    }

    /// Its derivative in time.
    fn stream_rate(&self, _at: [f64; 2], _t: f64) -> f64 {
        0.0
    }

    /// The velocity on the boundary, of which the tangential component is used.
    fn velocity(&self, _at: [f64; 2], _t: f64) -> [f64; 2] {
        [0.0; 2]
    }

    /// The force, where there is one.
    fn force(&self, _at: [f64; 2], _t: f64) -> Option<[f64; 2]> {
        None
    }

    /// The velocity, where it is known.
    fn exact(&self, _at: [f64; 2], _t: f64) -> Option<[f64; 2]> {
        None
    }
}

/// Velocities in the space of discretely divergence-free ones, moved by the momentum equation tested in that space.
///
/// The unknowns are values ψ of the stream function, w = E (ψ; d(t)) the velocities, and M ψ̇ = Cᵀ (F(w) − ẇ_d): without a
/// pressure, which no test function sees. M = CᵀC makes the natural metric of the residual that of the kinetic energy.
#[derive(Debug)]
pub(super) struct Confined {
    pub(super) space: Space,
    pub(super) nu: f64,
    pub(super) given: Box<dyn Given>,
    mass: Jacobian,
}

impl Confined {
    pub(super) fn new(rectangle: Rectangle, nu: f64, given: Box<dyn Given>) -> Self {
        let space = Space::new(rectangle);
        let mass = space.mass();
        Self { space, nu, given, mass }
    }

    /// Writes the boundary's data at time t: ψ, then the tangential velocities.
    pub(super) fn data(&self, t: f64, data: &mut [f64]) {
        let (stream, tangential) = data.split_at_mut(self.space.boundary.len());
        for (d, at) in stream.iter_mut().zip(&self.space.boundary) {
            *d = self.given.stream(*at, t);
        }
        for (d, wall) in tangential.iter_mut().zip(&self.space.walls) {
            *d = self.given.velocity(wall.point, t)[usize::from(wall.component == Component::V)];
        }
    }

    /// Their rates, of which those of the tangential velocities are not needed.
    fn data_rate(&self, t: f64, rate: &mut [f64]) {
        for (d, at) in rate.iter_mut().zip(&self.space.boundary) {
            *d = self.given.stream_rate(*at, t);
        }
    }

    /// The padded velocities of a state.
    pub(super) fn velocities(&self, t: f64, psi: &[f64]) -> Vec<f64> {
        let mut data = vec![0.0; self.space.data()];
        self.data(t, &mut data);
        let mut w = vec![0.0; 2 * self.space.padded];
        self.space.velocities(psi, Some(&data), &mut w);
        w
    }

    pub(super) fn field(&self) -> Field<'_> {
        let space = &self.space;
        let scratch = Scratch {
            t: f64::NAN,
            force: vec![0.0; space.faces.len()],
            data: vec![0.0; space.data()],
            rate: vec![0.0; space.data()],
            velocities: vec![0.0; 2 * space.padded],
            direction: vec![0.0; 2 * space.padded],
            image: vec![0.0; 2 * space.padded],
            row: Vec::new(),
        };
        Field { flow: self, scratch: RefCell::new(scratch) }
    }
}

/// The system of a [`Confined`] flow with its work space.
pub(super) struct Field<'a> {
    flow: &'a Confined,
    scratch: RefCell<Scratch>,
}

struct Scratch {
    /// When the force, the data and their rates are those: iterations of a step ask for them at one time.
    t: f64,
    force: Vec<f64>,
    data: Vec<f64>,
    rate: Vec<f64>,
    velocities: Vec<f64>,
    /// C x, or C y in the transpose.
    direction: Vec<f64>,
    image: Vec<f64>,
    /// The derivatives of an acceleration.
    row: Vec<f64>,
}

impl Scratch {
    fn set_velocities(&mut self, flow: &Confined, t: f64, psi: &[f64]) {
        if self.t != t {
            flow.data(t, &mut self.data);
            flow.data_rate(t, &mut self.rate);
            for (f, face) in self.force.iter_mut().zip(&flow.space.faces) {
                let given = flow.given.force(face.point, t);
                *f = given.map_or(0.0, |f| f[usize::from(face.component == Component::V)]);
            }
            self.t = t;
        }
        flow.space.velocities(psi, Some(&self.data), &mut self.velocities);
    }
}

impl VectorField for Field<'_> {
    fn dim(&self) -> usize {
        self.flow.space.dim
    }

    fn structure(&self) -> Structure {
        self.flow.space.structure.clone()
    }

    fn mass(&self) -> Mass {
        Mass::Matrix(self.flow.mass.clone())
    }

    fn rhs(&self, t: f64, psi: &[f64], out: &mut [f64]) {
        let (flow, space) = (self.flow, &self.flow.space);
        let s = &mut *self.scratch.borrow_mut();
        s.set_velocities(flow, t, psi);
        out.fill(0.0);
        let accelerations = space.faces.iter().zip(&s.force).map(|(face, force)| {
            let around = space.neighbours(face).map(|q| s.velocities[q]);
            acceleration(space.step(face.component), flow.nu, around) + force - space.lifted(face, &s.rate)
        });
        space.test(accelerations, out);
    }

    fn add_jacobian(&self, t: f64, psi: &[f64], scale: f64, out: &mut Jacobian) {
        let (flow, space) = (self.flow, &self.flow.space);
        let s = &mut *self.scratch.borrow_mut();
        s.set_velocities(flow, t, psi);
        let area = scale * space.area();
        for (face, unknowns, terms) in space.with_stencils() {
            let around = space.neighbours(face).map(|q| s.velocities[q]);
            let a = derivatives(space.step(face.component), flow.nu, around);
            s.row.clear();
            s.row.resize(unknowns.len(), 0.0);
            terms.iter().for_each(|term| s.row[term.unknown] += a[term.neighbour] * term.entry);
            for (k, test) in space.unknowns(face.at) {
                unknowns.iter().zip(&s.row).for_each(|(&l, a)| out.add(k, l, area * test * a));
            }
        }
    }

    /// Products of velocities that lie round a face are of values at corners no further apart than on a cell.
    fn curvature_structure(&self) -> Structure {
        self.flow.space.structure.clone()
    }

    fn add_curvature(&self, _t: f64, _psi: &[f64], y: &[f64], scale: f64, out: &mut Jacobian) {
        let space = &self.flow.space;
        let second: [[[f64; 9]; 9]; 2] = [Component::U, Component::V].map(|component| {
            std::array::from_fn(|b| {
                let unit = std::array::from_fn(|a| f64::from(u8::from(a == b)));
                derivatives(space.step(component), 0.0, unit)
            })
        });
        for face in &space.faces {
            let tested: f64 = scale * space.area() * space.unknowns(face.at).map(|(k, e)| e * y[k]).sum::<f64>();
            let at = space.neighbours(face);
            for (q, row) in at.iter().zip(&second[usize::from(face.component == Component::V)]) {
                for (r, a) in at.iter().zip(row).filter(|(_, a)| **a != 0.0) {
                    for (k, e) in space.unknowns(*q) {
                        space.unknowns(*r).for_each(|(l, g)| out.add(k, l, tested * a * e * g));
                    }
                }
            }
        }
    }

    fn apply_jacobian(&self, t: f64, psi: &[f64], x: &[f64], out: &mut [f64]) {
        let (flow, space) = (self.flow, &self.flow.space);
        let s = &mut *self.scratch.borrow_mut();
        s.set_velocities(flow, t, psi);
        space.velocities(x, None, &mut s.direction);
        out.fill(0.0);
        let image = space.faces.iter().map(|face| {
            let at = space.neighbours(face);
            let a = derivatives(space.step(face.component), flow.nu, at.map(|q| s.velocities[q]));
            at.iter().zip(a).map(|(&q, a)| a * s.direction[q]).sum()
        });
        space.test(image, out);
    }

    fn apply_transpose(&self, t: f64, psi: &[f64], y: &[f64], out: &mut [f64]) {
        let (flow, space) = (self.flow, &self.flow.space);
        let s = &mut *self.scratch.borrow_mut();
        s.set_velocities(flow, t, psi);
        s.image.fill(0.0);
        let area = space.area();
        for face in &space.faces {
            let tested: f64 = area * space.unknowns(face.at).map(|(k, e)| e * y[k]).sum::<f64>();
            let at = space.neighbours(face);
            let a = derivatives(space.step(face.component), flow.nu, at.map(|q| s.velocities[q]));
            for (q, a) in at.into_iter().zip(a) {
                s.image[q] += a * tested;
            }
        }
        out.fill(0.0);
        space.add_transpose(&s.image, out);
    }
}
