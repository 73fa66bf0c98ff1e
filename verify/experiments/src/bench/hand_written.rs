//! The same equations as plain loops: what a step costs where nothing is general.

/// Roundings at which an increment counts as nothing, as in the library.
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;

/// Method I on v̇ = −v²: Newton's method from v₀ on 2h p₁ = h r₀ + (1 − hJ) h r₁.
pub(crate) fn drag(mut v: f64, h: f64, steps: usize) -> f64 {
    for _ in 0..steps {
        let (mut x, mut last) = (v, f64::NAN);
        loop {
            let (d, slope) = (x - v, 1.0 + 2.0 * h * x);
            let end = d + h * x * x;
            let equation = d + h * v * v + slope * end;
            let increment = equation / (1.0 + slope * slope + 2.0 * h * end);
            x -= increment;
            let size = increment.abs();
            let theta = size / last;
            if size <= ROUNDINGS * x.abs() || theta * size <= (1.0 - theta) * f64::EPSILON * x.abs() {
                break;
            }
            last = size;
        }
        v = x;
    }
    v
}

/// Method I on θ̇ = ω, ω̇ = −sin θ − c ω by Newton's method from (θ₀, ω₀).
pub(crate) fn damped_pendulum([mut a, mut w]: [f64; 2], damping: f64, h: f64, steps: usize) -> [f64; 2] {
    for _ in 0..steps {
        let (f0, g0) = (w, -a.sin() - damping * w);
        let (mut x, mut y, mut last) = (a, w, f64::NAN);
        loop {
            let (sin, cos) = x.sin_cos();
            let (dx, dy) = (x - a, y - w);
            let (r, s) = (dx - h * y, dy + h * (sin + damping * y));
            // B = 1 − hJ, and the equations h r₀ + Bᵀ h r₁.
            let (b01, b10, b11) = (-h, h * cos, 1.0 + h * damping);
            let e = dx - h * f0 + r + b10 * s;
            let f = dy - h * g0 + b01 * r + b11 * s;
            let m00 = 2.0 + b10 * b10 - h * sin * s;
            let m01 = b01 + b10 * b11;
            let m11 = 1.0 + b01 * b01 + b11 * b11;
            let inverse = 1.0 / (m00 * m11 - m01 * m01);
            let (i, j) = ((m11 * e - m01 * f) * inverse, (m00 * f - m01 * e) * inverse);
            x -= i;
            y -= j;
            let (size, largest) = (i.abs().max(j.abs()), x.abs().max(y.abs()));
            let theta = size / last;
            if size <= ROUNDINGS * largest || theta * size <= (1.0 - theta) * f64::EPSILON * largest {
                break;
            }
            last = size;
        }
        (a, w) = (x, y);
    }
    [a, w]
}

/// The force of Kepler's problem.
fn attraction([x, y]: [f64; 2]) -> [f64; 2] {
    let square = x * x + y * y;
    let factor = -1.0 / (square * square.sqrt());
    [factor * x, factor * y]
}

/// Störmer–Verlet on Kepler's problem, one force a step.
pub(crate) fn kepler_verlet(mut q: [f64; 2], mut p: [f64; 2], h: f64, steps: usize) -> [f64; 4] {
    let mut force = attraction(q);
    for _ in 0..steps {
        for i in 0..2 {
            p[i] += 0.5 * h * force[i];
            q[i] += h * p[i];
        }
        force = attraction(q);
        for i in 0..2 {
            p[i] += 0.5 * h * force[i];
        }
    }
    [q[0], q[1], p[0], p[1]]
}

/// Blanes and Moan's SRKN₁₁ᵇ on Kepler's problem, eleven forces a step.
pub(crate) fn kepler_blanes_moan(mut q: [f64; 2], mut p: [f64; 2], h: f64, steps: usize) -> [f64; 4] {
    const DRIFTS: [f64; 11] = {
        let [a, b, c, d, e] =
            [0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075, 0.357208872795928];
        [a, b, c, d, e, 1.0 - 2.0 * (a + b + c + d + e), e, d, c, b, a]
    };
    const KICKS: [f64; 11] = {
        let [a, b, c, d, e] =
            [0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807, -0.0115113874206879];
        let f = 0.5 - (a + b + c + d + e);
        [a, b, c, d, e, f, f, e, d, c, b]
    };
    let mut force = attraction(q);
    for _ in 0..steps {
        for (drift, kick) in DRIFTS.iter().zip(KICKS) {
            for i in 0..2 {
                p[i] += kick * h * force[i];
                q[i] += drift * h * p[i];
            }
            force = attraction(q);
        }
        for i in 0..2 {
            p[i] += KICKS[0] * h * force[i];
        }
    }
    [q[0], q[1], p[0], p[1]]
}

/// The midpoint rule on Kepler's problem by fixed-point iteration from the explicit step.
pub(crate) fn kepler_midpoint(mut q: [f64; 2], mut p: [f64; 2], h: f64, steps: usize) -> [f64; 4] {
    let mut force = attraction(q);
    for _ in 0..steps {
        // The force at the middle, from that of the step before.
        let mut last = f64::NAN;
        loop {
            let middle = [0, 1].map(|i| q[i] + 0.5 * h * (p[i] + 0.5 * h * force[i]));
            let next = attraction(middle);
            let size = 0.5 * h * h * (next[0] - force[0]).abs().max((next[1] - force[1]).abs());
            let largest = middle[0].abs().max(middle[1].abs());
            force = next;
            let theta = size / last;
            if size <= ROUNDINGS * largest || theta * size <= (1.0 - theta) * f64::EPSILON * largest {
                break;
            }
            last = size;
        }
        for i in 0..2 {
            q[i] += h * (p[i] + 0.5 * h * force[i]);
            p[i] += h * force[i];
        }
    }
    [q[0], q[1], p[0], p[1]]
}

/// Gauss collocation of two stages on Kepler's problem, Galerkin's method of degree 2, by fixed-point iteration from the
/// line through the forces of the step before.
pub(crate) fn kepler_gauss(mut q: [f64; 2], mut p: [f64; 2], h: f64, steps: usize) -> [f64; 4] {
    let root = 3.0_f64.sqrt();
    let c = [0.5 - root / 6.0, 0.5 + root / 6.0];
    let a = [[0.25, 0.25 - root / 6.0], [0.25 + root / 6.0, 0.25]];
    // A² and bᵀA of positions that follow from forces.
    let square = [0, 1].map(|i| [0, 1].map(|j| a[i][0] * a[0][j] + a[i][1] * a[1][j]));
    let ends = [0.5 * (a[0][0] + a[1][0]), 0.5 * (a[0][1] + a[1][1])];
    let start = attraction(q);
    let mut forces = [start, start];
    for _ in 0..steps {
        let mut last = f64::NAN;
        loop {
            let mut size = 0.0_f64;
            let mut next = forces;
            for (i, next) in next.iter_mut().enumerate() {
                let stage = [0, 1].map(|k| {
                    q[k] + h * c[i] * p[k] + h * h * (square[i][0] * forces[0][k] + square[i][1] * forces[1][k])
                });
                *next = attraction(stage);
                for k in 0..2 {
                    size = size.max((next[k] - forces[i][k]).abs());
                }
            }
            forces = next;
            size *= 0.25 * h * h;
            let (largest, theta) = (q[0].abs().max(q[1].abs()), size / last);
            if size <= ROUNDINGS * largest || theta * size <= (1.0 - theta) * f64::EPSILON * largest {
                break;
            }
            last = size;
        }
        for k in 0..2 {
            q[k] += h * p[k] + h * h * (ends[0] * forces[0][k] + ends[1] * forces[1][k]);
            p[k] += 0.5 * h * (forces[0][k] + forces[1][k]);
            let slope = (forces[1][k] - forces[0][k]) / (c[1] - c[0]);
            let middle = 0.5 * (forces[0][k] + forces[1][k]) + slope;
            let half = 0.5 * (c[1] - c[0]) * slope;
            forces[0][k] = middle - half;
            forces[1][k] = middle + half;
        }
    }
    [q[0], q[1], p[0], p[1]]
}

/// Values at the same distance from the two ends.
type Lanes = [f64; 2];

/// Method I on u_t = 2 + u_yy in finite differences, (I + B²) u₁ = 2 u₀ + h g + B h g with B = I − hA, by LDLᵀ of a band of two
/// diagonals from both ends at once. A step streams the factors twice and u, the forcing and an intermediate vector once.
pub(crate) struct Channel {
    /// Reciprocal pivot and the two multipliers of a column.
    factors: Vec<[Lanes; 3]>,
    /// The inverse of the block of the two unknowns in the middle.
    middle: [[f64; 2]; 2],
    forcing: Vec<f64>,
    lanes: Vec<Lanes>,
}

impl Channel {
    /// `cells` is even.
    pub(crate) fn new(cells: usize, h: f64) -> Self {
        let weight = h * ((cells + 1) as f64 / 2.0).powi(2);
        let (b, o) = (1.0 + 2.0 * weight, -weight);
        let half = cells / 2 - 1;
        let diagonal = |i: usize| 1.0 + b * b + o * o * if i == 0 { 1.0 } else { 2.0 };
        let mut columns: Vec<[f64; 3]> = (0..half + 2).map(|i| [diagonal(i), 2.0 * b * o, o * o]).collect();
        let before = [columns[half], columns[half + 1]];
        for k in 0..half {
            let [pivot, first, second] = columns[k];
            let inverse = pivot.recip();
            columns[k + 1][0] -= first * first * inverse;
            columns[k + 1][1] -= first * second * inverse;
            columns[k + 2][0] -= second * second * inverse;
            columns[k] = [inverse, first * inverse, second * inverse];
        }
        // The two eliminations meet in a block that is its own mirror image.
        let own = columns[half][0] + columns[half + 1][0] - before[1][0];
        let across = 2.0 * columns[half][1] - before[0][1];
        let determinant = own * own - across * across;
        let middle = [[own / determinant, -across / determinant], [-across / determinant, own / determinant]];
        let outer = |i: usize| i == 0 || i + 1 == cells;
        let forcing = (0..cells).map(|i| 2.0 * h * (1.0 + b + if outer(i) { o } else { 2.0 * o })).collect();
        let factors = columns[..half].iter().map(|column| column.map(|x| [x, x])).collect();
        Self { factors, middle, forcing, lanes: vec![[0.0; 2]; half + 2] }
    }

    pub(crate) fn step(&mut self, u: &mut [f64]) {
        let (half, last) = (self.factors.len(), u.len() - 1);
        let right = |i: usize| 2.0 * u[i] + self.forcing[i];
        let (mut first, mut second) = ([0.0; 2], [0.0; 2]);
        for (k, (column, lanes)) in self.factors.iter().zip(&mut self.lanes).enumerate() {
            let x = [right(k) - first[0], right(last - k) - first[1]];
            first = [second[0] + column[1][0] * x[0], second[1] + column[1][1] * x[1]];
            second = [column[2][0] * x[0], column[2][1] * x[1]];
            *lanes = x;
        }
        let a = right(half) - first[0] - second[1];
        let b = right(half + 1) - first[1] - second[0];
        let [[m00, m01], [m10, m11]] = self.middle;
        let (a, b) = (m00 * a + m01 * b, m10 * a + m11 * b);
        (u[half], u[half + 1]) = (a, b);
        let (mut near, mut far) = ([a, b], [b, a]);
        for (k, (column, lanes)) in self.factors.iter().zip(&self.lanes).enumerate().rev() {
            let x = [0, 1].map(|i| lanes[i] * column[0][i] - column[1][i] * near[i] - column[2][i] * far[i]);
            (far, near) = (near, x);
            (u[k], u[last - k]) = (x[0], x[1]);
        }
    }
}
