//! Incremental pressure correction, the usual way to step incompressible flow, on the same staggered grid.
//!
//! With second-order backward differences, convection extrapolated and the pressure in rotational form (Guermond, Minev and
//! Shen, Comput. Methods Appl. Mech. Eng. 195 (2006) 6011–6045, Section 3.4):
//!
//! - (3u* − 4uⁿ + uⁿ⁻¹)/2h − ν Δu* + ∇pⁿ = f − N(2uⁿ − uⁿ⁻¹), with the walls' tangential velocities,
//! - Δφ = (3/2h) ∇·u*, uⁿ⁺¹ = u* − (2h/3) ∇φ, pⁿ⁺¹ = pⁿ + φ − ν ∇·u*.
//!
//! The first step takes backward Euler's coefficients. As h → 0 its velocities are those of the divergence-free formulation. Its
//! linear systems are separable, and are solved by the eigenvectors of second differences in one dimension.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::problem::flow::{Given, acceleration};

/// What continues a grid function beyond its last value.
#[derive(Debug, Clone, Copy)]
enum End {
    /// A zero there: velocities on the wall.
    Zero,
    /// Its negative: tangential velocities, half a cell off the wall.
    Reflected,
    /// Itself: the pressure.
    Level,
}

/// Second differences of n values a distance `spacing` apart.
fn second_differences(n: usize, spacing: f64, end: End) -> SymmetricEigen<f64, nalgebra::Dyn> {
    let mut matrix = DMatrix::zeros(n, n);
    matrix.fill_diagonal(-2.0);
    for i in 1..n {
        (matrix[(i, i - 1)], matrix[(i - 1, i)]) = (1.0, 1.0);
    }
    let beyond = match end {
        End::Zero => 0.0,
        End::Reflected => -1.0,
        End::Level => 1.0,
    };
    matrix[(0, 0)] += beyond;
    matrix[(n - 1, n - 1)] += beyond;
    SymmetricEigen::new(matrix / (spacing * spacing))
}

/// The solver of a φ − ν Δφ = r, with values φ(i, j) at x_i, y_j.
#[derive(Debug)]
struct Helmholtz {
    along: SymmetricEigen<f64, nalgebra::Dyn>,
    across: SymmetricEigen<f64, nalgebra::Dyn>,
    /// Systems solved.
    solves: u64,
}

impl Helmholtz {
    fn new(along: SymmetricEigen<f64, nalgebra::Dyn>, across: SymmetricEigen<f64, nalgebra::Dyn>) -> Self {
        Self { along, across, solves: 0 }
    }

    /// A zero eigenvalue of the operator, that of a constant pressure, has a zero solution.
    fn solve(&mut self, a: f64, nu: f64, right: &DMatrix<f64>) -> DMatrix<f64> {
        self.solves += 1;
        let (p, q) = (&self.along.eigenvectors, &self.across.eigenvectors);
        let mut modes = p.tr_mul(right) * q;
        let fastest = self.along.eigenvalues.amax() + self.across.eigenvalues.amax();
        for (j, mut column) in modes.column_iter_mut().enumerate() {
            for (i, mode) in column.iter_mut().enumerate() {
                let value = a - nu * (self.along.eigenvalues[i] + self.across.eigenvalues[j]);
                *mode = if value.abs() > 1e-12 * (a + nu.abs() * fastest) { *mode / value } else { 0.0 };
            }
        }
        p * modes * q.transpose()
    }
}

/// Velocities on the faces inside a unit square of N × N cells: u(i, j) at ((i + 1)/N, (j + ½)/N), v(i, j) at
/// ((i + ½)/N, (j + 1)/N).
#[derive(Debug, Clone)]
struct Velocities {
    u: DMatrix<f64>,
    v: DMatrix<f64>,
}

impl Velocities {
    fn combined(&self, a: f64, other: &Self, b: f64) -> Self {
        Self { u: a * &self.u + b * &other.u, v: a * &self.v + b * &other.v }
    }
}

/// The scheme with its state.
pub(super) struct Projection<'a> {
    n: usize,
    nu: f64,
    given: &'a dyn Given,
    for_u: Helmholtz,
    for_v: Helmholtz,
    for_pressure: Helmholtz,
    t: f64,
    now: Velocities,
    before: Option<Velocities>,
    pressure: DMatrix<f64>,
}

impl<'a> Projection<'a> {
    /// From the velocities of the faces at t = 0, u row by row and then v, and no pressure.
    pub(super) fn new(n: usize, nu: f64, given: &'a dyn Given, faces: &[f64]) -> Self {
        let dx = 1.0 / n as f64;
        let (u, v) = faces.split_at(n * (n - 1));
        let of = |n, end| second_differences(n, dx, end);
        Self {
            n,
            nu,
            given,
            for_u: Helmholtz::new(of(n - 1, End::Zero), of(n, End::Reflected)),
            for_v: Helmholtz::new(of(n, End::Reflected), of(n - 1, End::Zero)),
            for_pressure: Helmholtz::new(of(n, End::Level), of(n, End::Level)),
            t: 0.0,
            now: Velocities { u: DMatrix::from_column_slice(n - 1, n, u), v: DMatrix::from_column_slice(n, n - 1, v) },
            before: None,
            pressure: DMatrix::zeros(n, n),
        }
    }

    /// The velocities as they were given.
    pub(super) fn faces(&self) -> Vec<f64> {
        [self.now.u.as_slice(), self.now.v.as_slice()].concat()
    }

    /// Linear systems solved.
    pub(super) fn solves(&self) -> u64 {
        self.for_u.solves + self.for_v.solves + self.for_pressure.solves
    }

    /// Twice the tangential velocity of the wall next to a face where it lies beyond that face.
    fn wall(&self, at: [f64; 2], component: usize, t: f64) -> f64 {
        2.0 * self.given.velocity(at, t)[component]
    }

    /// u at (i/N, (j + ½)/N), the walls' values included and continued by half a cell.
    fn u(&self, w: &Velocities, i: usize, j: isize, t: f64) -> f64 {
        let (n, x) = (self.n, i as f64 / self.n as f64);
        match j {
            _ if i == 0 || i == n => 0.0,
            -1 => self.wall([x, 0.0], 0, t) - w.u[(i - 1, 0)],
            j if j as usize == n => self.wall([x, 1.0], 0, t) - w.u[(i - 1, n - 1)],
            j => w.u[(i - 1, j as usize)],
        }
    }

    /// v at ((i + ½)/N, j/N), likewise.
    fn v(&self, w: &Velocities, i: isize, j: usize, t: f64) -> f64 {
        let (n, y) = (self.n, j as f64 / self.n as f64);
        match i {
            _ if j == 0 || j == n => 0.0,
            -1 => self.wall([0.0, y], 1, t) - w.v[(0, j - 1)],
            i if i as usize == n => self.wall([1.0, y], 1, t) - w.v[(n - 1, j - 1)],
            i => w.v[(i as usize, j - 1)],
        }
    }

    /// f − N(w) on all faces at time t.
    fn explicit(&self, w: &Velocities, t: f64) -> Velocities {
        let (n, dx) = (self.n, 1.0 / self.n as f64);
        let (u, v) = (|i, j| self.u(w, i, j, t), |i, j| self.v(w, i, j, t));
        let force = |x: f64, y: f64, component: usize| {
            self.given.force([x * dx, y * dx], t).map_or(0.0, |force| force[component])
        };
        let of_u = |i: usize, j: usize| {
            let (k, j) = (i as isize + 1, j as isize);
            let i = i + 1;
            let (up, here) = (j as usize + 1, j as usize);
            let crossing = [v(k - 1, up), v(k, up), v(k - 1, here), v(k, here)];
            let [ne, nw, se, sw] = crossing;
            let around = [u(i, j), u(i + 1, j), u(i - 1, j), u(i, j + 1), u(i, j - 1), ne, nw, se, sw];
            acceleration([dx; 2], 0.0, around) + force(i as f64, j as f64 + 0.5, 0)
        };
        let of_v = |i: usize, j: usize| {
            let (i, k) = (i as isize, j as isize + 1);
            let j = j + 1;
            let (right, here) = (i as usize + 1, i as usize);
            let crossing = [u(right, k - 1), u(right, k), u(here, k - 1), u(here, k)];
            let [ne, nw, se, sw] = crossing;
            let around = [v(i, j), v(i, j + 1), v(i, j - 1), v(i + 1, j), v(i - 1, j), ne, nw, se, sw];
            acceleration([dx; 2], 0.0, around) + force(i as f64 + 0.5, j as f64, 1)
        };
        Velocities { u: DMatrix::from_fn(n - 1, n, of_u), v: DMatrix::from_fn(n, n - 1, of_v) }
    }

    /// Differences of values in the cells across the faces.
    fn gradient(&self, p: &DMatrix<f64>) -> Velocities {
        let n = self.n as f64;
        let u = DMatrix::from_fn(self.n - 1, self.n, |i, j| n * (p[(i + 1, j)] - p[(i, j)]));
        let v = DMatrix::from_fn(self.n, self.n - 1, |i, j| n * (p[(i, j + 1)] - p[(i, j)]));
        Velocities { u, v }
    }

    fn divergence(&self, w: &Velocities) -> DMatrix<f64> {
        let n = self.n as f64;
        let (u, v) = (|i, j| self.u(w, i, j, 0.0), |i, j| self.v(w, i, j, 0.0));
        DMatrix::from_fn(self.n, self.n, |i, j| {
            let (k, l) = (i as isize, j as isize);
            n * (u(i + 1, l) - u(i, l) + v(k, j + 1) - v(k, j))
        })
    }

    /// One step of size h, the same in all steps.
    pub(super) fn step(&mut self, h: f64) {
        let (end, dx) = (self.t + h, 1.0 / self.n as f64);
        // a u* = past/h + …, from a uⁿ⁺¹ = past.
        let (a, past, known) = match &self.before {
            Some(before) => (1.5 / h, self.now.combined(2.0, before, -0.5), self.now.combined(2.0, before, -1.0)),
            None => (1.0 / h, self.now.clone(), self.now.clone()),
        };
        let mut right = past.combined(1.0 / h, &self.explicit(&known, end), 1.0);
        right = right.combined(1.0, &self.gradient(&self.pressure), -1.0);
        // The walls' part of −ν Δu*.
        let viscosity = self.nu / (dx * dx);
        for i in 0..self.n - 1 {
            let x = (i + 1) as f64 * dx;
            right.u[(i, 0)] += viscosity * self.wall([x, 0.0], 0, end);
            right.u[(i, self.n - 1)] += viscosity * self.wall([x, 1.0], 0, end);
            right.v[(0, i)] += viscosity * self.wall([0.0, x], 1, end);
            right.v[(self.n - 1, i)] += viscosity * self.wall([1.0, x], 1, end);
        }
        let u = self.for_u.solve(a, self.nu, &right.u);
        let v = self.for_v.solve(a, self.nu, &right.v);
        let between = Velocities { u, v };
        let divergence = self.divergence(&between);
        let phi = self.for_pressure.solve(0.0, -1.0, &(a * &divergence));
        self.pressure += &phi - self.nu * divergence;
        let next = between.combined(1.0, &self.gradient(&phi), -1.0 / a);
        self.before = Some(std::mem::replace(&mut self.now, next));
        self.t = end;
    }

    /// The largest divergence.
    #[cfg(test)]
    fn largest_divergence(&self) -> f64 {
        self.divergence(&self.now).amax()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::flow;

    #[test]
    fn a_projected_velocity_has_no_divergence() {
        let lid = flow::lid();
        let mut scheme = Projection::new(8, 0.01, &lid, &[0.0; 112]);
        for _ in 0..5 {
            scheme.step(0.02);
            assert!(scheme.now.u.amax() > 1e-3 && scheme.largest_divergence() <= 1e-12);
        }
        // Two components and the pressure.
        assert_eq!(scheme.solves(), 5 * 3);
    }

    /// A force that is the gradient of q = sin 3t (x + xy²), which the pressure takes up.
    #[derive(Debug)]
    struct Pushed;

    impl Given for Pushed {
        fn force(&self, [x, y]: [f64; 2], t: f64) -> Option<[f64; 2]> {
            Some([1.0 + y * y, 2.0 * x * y].map(|part| (3.0 * t).sin() * part))
        }
    }

    /// Without −ν ∇·u* the normal derivative of the pressure stays on the walls what it is at first, and the pressure is of first
    /// order there; in rotational form it is of order 3/2 (Guermond, Minev and Shen, Sections 3.2 and 3.4). Between the two lies 5/4.
    #[test]
    fn the_pressure_has_the_order_of_the_rotational_form() {
        const N: usize = 32;
        let error = |steps: u32| {
            let mut scheme = Projection::new(N, 1.0, &Pushed, &vec![0.0; 2 * N * (N - 1)]);
            (0..steps).for_each(|_| scheme.step(1.0 / f64::from(steps)));
            let place = |k: usize| (k as f64 + 0.5) / N as f64;
            let q = DMatrix::from_fn(N, N, |i, j| 3.0_f64.sin() * place(i) * (1.0 + place(j).powi(2)));
            let off = scheme.pressure - q;
            off.add_scalar(-off.mean()).amax()
        };
        let (coarse, fine) = (error(32), error(64));
        let order = (coarse / fine).log2();
        assert!(order >= 1.25, "{coarse} and {fine}: order {order}");
    }

    #[test]
    fn separable_systems_are_solved() {
        let mut solver =
            Helmholtz::new(second_differences(5, 0.2, End::Zero), second_differences(4, 0.2, End::Reflected));
        let right = DMatrix::from_fn(5, 4, |i, j| (i as f64 - 1.3 * j as f64).sin());
        let x = solver.solve(3.0, 0.7, &right);
        let matrix = |e: &SymmetricEigen<f64, nalgebra::Dyn>| {
            &e.eigenvectors * DMatrix::from_diagonal(&e.eigenvalues) * e.eigenvectors.transpose()
        };
        let image = 3.0 * &x - 0.7 * (matrix(&solver.along) * &x + &x * matrix(&solver.across));
        assert!((image - right).amax() <= 1e-12);
    }
}
