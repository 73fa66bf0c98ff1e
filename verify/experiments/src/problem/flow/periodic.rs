//! Flows on the periodic square by Fourier's pseudo-spectral method.

use std::cell::RefCell;

use lsvi::{Jacobian, Mass, Preconditioner, SolveError, StepOperator, Structure, VectorField, add_columns};
use nalgebra::Complex;

use super::fourier::{Buffers, Modes, Wave, add, complex};

/// The norm in which the residual of the equation is small.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Metric {
    /// That of the velocity: kinetic energy. M = 1/|k|² on the vorticity.
    Velocity,
    /// That of the vorticity: enstrophy. M = 1.
    Vorticity,
}

/// ω_t + (U + u)·∇ω = ν Δω on [0, 2π)² with a constant mean velocity U, u = (ψ_y, −ψ_x), −Δψ = ω.
///
/// The unknowns are the coefficients of ω in an orthonormal basis; products are dealiased, so that convection conserves
/// both energy and enstrophy up to rounding. f = M ω̇ in the chosen metric.
#[derive(Debug)]
pub(super) struct Periodic {
    pub(super) modes: Modes,
    pub(super) nu: f64,
    pub(super) mean: [f64; 2],
    /// M by modes, two equal entries for each.
    pub(super) mass: Vec<f64>,
}

fn square([k, l]: Wave) -> f64 {
    f64::from(k * k + l * l)
}

/// The velocities of the vorticity `z` at k.
fn velocity(wave: Wave, z: Complex<f64>) -> [Complex<f64>; 2] {
    let psi = z / square(wave);
    let [x, y] = gradient(wave, psi);
    [y, -x]
}

fn gradient(wave: Wave, z: Complex<f64>) -> [Complex<f64>; 2] {
    let turned = Complex::new(-z.im, z.re);
    wave.map(|k| turned * f64::from(k))
}

impl Periodic {
    pub(super) fn new(points: usize, nu: f64, mean: [f64; 2], metric: Metric) -> Self {
        let modes = Modes::new(points);
        let weight = |wave: &Wave| if metric == Metric::Velocity { 1.0 / square(*wave) } else { 1.0 };
        let mass = modes.waves.iter().flat_map(|wave| [weight(wave); 2]).collect();
        Self { modes, nu, mean, mass }
    }

    /// The rate of mode k under viscosity and the mean velocity.
    fn rate(&self, wave: Wave) -> Complex<f64> {
        let [k, l] = wave.map(f64::from);
        Complex::new(-self.nu * square(wave), -self.mean[0] * k - self.mean[1] * l)
    }

    /// The coefficients of a vorticity given by its values.
    pub(super) fn project(&self, vorticity: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut v = vec![0.0; self.modes.dim()];
        let rows: Vec<f64> = self.modes.coordinates().collect();
        let values = rows.iter().flat_map(|&y| self.modes.coordinates().map(move |x| (x, y)));
        self.modes.coefficients(
            values.map(|(x, y)| [vorticity(x, y), 0.0]),
            &mut self.modes.buffers(),
            |m, _, [z, _]| {
                add(&mut v, m, z);
            },
        );
        v
    }

    /// Kinetic energy ½ mean |u|² and enstrophy ½ mean ω², without the mean velocity's.
    pub(super) fn energy_and_enstrophy(&self, v: &[f64]) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (m, wave) in self.modes.waves.iter().enumerate() {
            let z = 0.5 * (v[2 * m] * v[2 * m] + v[2 * m + 1] * v[2 * m + 1]);
            sums[0] += z / square(*wave);
            sums[1] += z;
        }
        sums
    }

    /// The vorticity on the grid, row by row in y.
    pub(super) fn vorticity(&self, v: &[f64]) -> Vec<f64> {
        let mut out = [vec![0.0; self.modes.points.pow(2)], vec![0.0; self.modes.points.pow(2)]];
        let [first, second] = &mut out;
        let zero = Complex::new(0.0, 0.0);
        self.modes.values(|m, _| [complex(v, m), zero], &mut self.modes.buffers(), [first, second]);
        let [values, _] = out;
        values
    }

    pub(super) fn field(&self) -> Field<'_> {
        let pair = || [(); 2].map(|()| vec![0.0; self.modes.points.pow(2)]);
        let scratch = Scratch { buffers: self.modes.buffers(), at: Vec::new(), velocity: pair(), other: pair() };
        Field { flow: self, scratch: RefCell::new(scratch) }
    }
}

/// The system of a [`Periodic`] flow with its work space.
///
/// Convection is u·∇ω = (∂_xx − ∂_yy)(uv) + ∂_xy(v² − u²) (C. Basdevant, J. Comput. Phys. 50, 1983, 209–214): two velocities in, two
/// products out, so that f and each product with a derivative takes one complex transform each way.
pub(super) struct Field<'a> {
    flow: &'a Periodic,
    scratch: RefCell<Scratch>,
}

struct Scratch {
    buffers: Buffers,
    /// The state whose velocities these are: products with one Jacobian come in dozens.
    at: Vec<f64>,
    /// u and v on the grid.
    velocity: [Vec<f64>; 2],
    other: [Vec<f64>; 2],
}

fn pair([a, b]: &mut [Vec<f64>; 2]) -> [&mut [f64]; 2] {
    [a, b]
}

fn zip<'a>([a, b]: &'a [Vec<f64>; 2]) -> impl Iterator<Item = [f64; 2]> + 'a {
    a.iter().zip(b).map(|(a, b)| [*a, *b])
}

/// The symbols of ∂_yy − ∂_xx and −∂_xy.
fn second_derivatives(wave: Wave) -> [f64; 2] {
    let [k, l] = wave.map(f64::from);
    [k * k - l * l, k * l]
}

impl Scratch {
    fn linearise(&mut self, modes: &Modes, v: &[f64]) {
        if self.at != v {
            modes.values(|m, k| velocity(k, complex(v, m)), &mut self.buffers, pair(&mut self.velocity));
            self.at.clear();
            self.at.extend_from_slice(v);
        }
    }
}

impl Field<'_> {
    /// Writes M times the linear part applied to v, less the convection that belongs to the `products`.
    fn assemble(&self, v: &[f64], products: impl Iterator<Item = [f64; 2]>, buffers: &mut Buffers, out: &mut [f64]) {
        let flow = self.flow;
        out.fill(0.0);
        flow.modes.coefficients(products, buffers, |m, wave, [p, q]| {
            let [a, b] = second_derivatives(wave);
            add(out, m, (flow.rate(wave) * complex(v, m) + p * a + q * b) * flow.mass[2 * m]);
        });
    }
}

impl VectorField for Field<'_> {
    fn dim(&self) -> usize {
        self.flow.modes.dim()
    }

    fn mass(&self) -> Mass {
        Mass::Diagonal(self.flow.mass.clone())
    }

    fn rhs(&self, _t: f64, v: &[f64], out: &mut [f64]) {
        let s = &mut *self.scratch.borrow_mut();
        s.linearise(&self.flow.modes, v);
        let products = zip(&s.velocity).map(|[u, v]| [u * v, (v - u) * (v + u)]);
        self.assemble(v, products, &mut s.buffers, out);
    }

    fn structure(&self) -> Structure {
        Structure::MatrixFree
    }

    /// By products, which takes as many of them as there are unknowns.
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        add_columns(self, t, v, scale, out);
    }

    /// By products likewise.
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        let n = self.dim();
        let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
        for k in 0..n {
            unit[k] = 1.0;
            self.apply_curvature(t, v, w, &unit, &mut column);
            column.iter().enumerate().for_each(|(j, x)| out.add(j, k, scale * x));
            unit[k] = 0.0;
        }
    }

    /// With (a, b) the velocities of x: the products are ub + va and 2 (vb − ua).
    fn apply_jacobian(&self, _t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        let modes = &self.flow.modes;
        let s = &mut *self.scratch.borrow_mut();
        s.linearise(modes, v);
        modes.values(|m, k| velocity(k, complex(x, m)), &mut s.buffers, pair(&mut s.other));
        let products = zip(&s.velocity).zip(zip(&s.other));
        let products = products.map(|([u, v], [a, b])| [u * b + v * a, 2.0 * (v * b - u * a)]);
        self.assemble(x, products, &mut s.buffers, out);
    }

    /// With (p, q) the second derivatives of M y, the transpose of the velocity applied to (pv − 2qu, pu + 2qv).
    fn apply_transpose(&self, _t: f64, v: &[f64], y: &[f64], out: &mut [f64]) {
        let flow = self.flow;
        let s = &mut *self.scratch.borrow_mut();
        s.linearise(&flow.modes, v);
        let tested = |m: usize| complex(y, m) * flow.mass[2 * m];
        let derivatives = |m, wave| second_derivatives(wave).map(|symbol| tested(m) * symbol);
        flow.modes.values(derivatives, &mut s.buffers, pair(&mut s.other));
        let products = zip(&s.velocity).zip(zip(&s.other));
        let products = products.map(|([u, v], [p, q])| [p * v - 2.0 * q * u, p * u + 2.0 * q * v]);
        out.fill(0.0);
        flow.modes.coefficients(products, &mut s.buffers, |m, wave, [a, b]| {
            // The transpose of a derivative is minus the derivative.
            let ([_, y], [x, _]) = (gradient(wave, a), gradient(wave, b));
            add(out, m, flow.rate(wave).conj() * tested(m) + (x - y) / square(wave));
        });
    }

    /// Jᵀw is affine in v: the value at x less that at 0.
    fn apply_curvature(&self, t: f64, _v: &[f64], w: &[f64], x: &[f64], out: &mut [f64]) {
        self.apply_transpose(t, x, w, out);
        for (m, wave) in self.flow.modes.waves.iter().enumerate() {
            add(out, m, -self.flow.rate(*wave).conj() * complex(w, m) * self.flow.mass[2 * m]);
        }
    }
}

/// M (1 − s (−ν|k|² − iU·k)), the part of B = M − s f_v that is diagonal in Fourier space: Helmholtz's operator, moved with the
/// mean velocity.
#[derive(Debug)]
pub(super) struct Helmholtz {
    /// The rates by modes, and M.
    rates: Vec<Complex<f64>>,
    mass: Vec<f64>,
    /// By modes.
    inverse: Vec<Complex<f64>>,
}

impl Helmholtz {
    pub(super) fn new(flow: &Periodic) -> Self {
        let rates: Vec<_> = flow.modes.waves.iter().map(|wave| flow.rate(*wave)).collect();
        Self { inverse: rates.clone(), rates, mass: flow.mass.clone() }
    }

    fn multiply(&self, x: &mut [f64], factor: impl Fn(Complex<f64>) -> Complex<f64>) {
        for (m, inverse) in self.inverse.iter().enumerate() {
            let z = complex(x, m) * factor(*inverse);
            x[2 * m..2 * m + 2].fill(0.0);
            add(x, m, z);
        }
    }
}

impl Preconditioner for Helmholtz {
    fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
        for ((inverse, rate), mass) in self.inverse.iter_mut().zip(&self.rates).zip(self.mass.iter().step_by(2)) {
            *inverse = (mass * (Complex::new(1.0, 0.0) - b.s() * rate)).inv();
        }
        Ok(())
    }

    fn solve(&mut self, x: &mut [f64]) {
        self.multiply(x, |inverse| inverse);
    }

    fn solve_transpose(&mut self, x: &mut [f64]) {
        self.multiply(x, |inverse| inverse.conj());
    }
}
