//! Broken lines: the explicit integrators of a separable Lagrangian, by kicks and drifts.

use super::leapfrog::{Leapfrog, knots};
use super::velocity::Velocity;
use super::{DiscreteLagrangian, DiscreteLegendre, Interval, MomentumWeights, secant, straight};
use crate::error::{InputError, NodeError, SolveError, SystemError, check_vector};
use crate::lagrangian::{HessianWeights, Lagrangian};
use crate::linalg::{Jacobian, Structure, add_block};
use crate::quadrature::check_sum;

/// The durations a₁, …, a₅ of Blanes and Moan's SRKN₁₁ᵇ; a₆ makes the sum 1, and a₇, …, a₁₁ are the same in reverse.
const DURATIONS: [f64; 5] =
    [0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075, 0.357208872795928];
/// Its kicks b₀, …, b₄; b₅ makes the sum ½, and b₆, …, b₁₁ are the same in reverse.
const KICKS: [f64; 5] =
    [0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807, -0.0115113874206879];

/// L_d = h Σ_{i=1}^s a_i T(d_i) − h Σ_{i=0}^s b_i V(t₀ + c_i h, x_i) for a [separable](Lagrangian::is_separable)
/// Lagrangian L = T(v) − V(t, q), on a broken line with the knots x₀ = q₀, x₁, …, x_s = q₁ at c_i = a₁ + … + a_i, with
/// d_i = (x_i − x_{i−1})/(a_i h).
///
/// The momenta are p₀ = M d₁ − h b₀ L_q(x₀) and p₁ = M d_s + h b_s L_q(x_s). Where L_d is stationary in the knots between, the
/// position–momentum step is a splitting method (\[HLW06\] II.5): kicks b_i and drifts a_i in turn, explicit, with s
/// evaluations of the force. It is symplectic whatever a and b are; its order is theirs. Pieces of negative duration are no
/// mistake: beyond order 2 there are some. With s = 1 and b = (½, ½) it is [`Trapezoidal`](super::Trapezoidal).
///
/// ```
/// use lsvi::discrete::BrokenLine;
/// use lsvi::{AutoLagrangian, LagrangianFn, Scalar, State, Trajectory, position_momentum};
///
/// struct Pendulum;
/// impl LagrangianFn for Pendulum {
///     fn dim(&self) -> usize { 1 }
///     fn is_separable(&self) -> bool { true }
///     fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T { v[0] * v[0] * 0.5 + q[0].cos() }
/// }
///
/// let method = position_momentum(BrokenLine::blanes_moan(AutoLagrangian::new(Pendulum))?);
/// let start = State::new(0.0, vec![1.0]).with_momentum(vec![0.0]);
/// let end = Trajectory::new(method, start, 0.5, 100.0)?.observe(|_| {})?;
/// let energy = 0.5 * end.p[0] * end.p[0] - end.q[0].cos();
/// assert!((energy + 1.0_f64.cos()).abs() < 1e-8);
/// # Ok::<(), lsvi::StepError>(())
/// ```
#[derive(Debug)]
pub struct BrokenLine<L> {
    lagrangian: L,
    durations: Vec<f64>,
    /// c₀, …, c_s.
    times: Vec<f64>,
    kicks: Vec<f64>,
    velocity_of: Velocity,
    leapfrog: Box<Leapfrog>,
    velocity: Vec<f64>,
    dl_dq: Vec<f64>,
    dl_dv: Vec<f64>,
    block: Jacobian,
}

impl<L: Lagrangian> BrokenLine<L> {
    /// Discretises `lagrangian` by the durations a₁, …, a_s of the pieces and the kicks b₀, …, b_s, as parts of the step.
    ///
    /// # Errors
    /// [`SystemError::NotSeparable`] for a Lagrangian that does not say that it is; [`NodeError::TooFew`] without a piece,
    /// [`NodeError::CoincidentNodes`] for a piece of no duration, [`NodeError::WeightSum`] if either sum is not 1 to seven digits;
    /// [`SystemError`] for weights that are not finite, or not as many.
    pub fn new(lagrangian: L, durations: &[f64], kicks: &[f64]) -> Result<Self, InputError> {
        if !lagrangian.is_separable() {
            return Err(InputError::System(SystemError::NotSeparable));
        }
        let pieces = durations.len();
        if pieces == 0 {
            return Err(InputError::Nodes(NodeError::TooFew { what: "pieces of the line", least: 1, found: 0 }));
        }
        check_vector("durations", durations, pieces)?;
        check_vector("kicks", kicks, pieces + 1)?;
        let times = knots(durations);
        if let Some(i) = durations.iter().position(|a| *a == 0.0) {
            return Err(InputError::Nodes(NodeError::CoincidentNodes { first: i, second: i + 1, value: times[i] }));
        }
        check_sum(durations)?;
        check_sum(kicks)?;
        let zeros = vec![0.0; lagrangian.dim()];
        Ok(Self {
            durations: durations.to_vec(),
            times,
            kicks: kicks.to_vec(),
            velocity_of: Velocity::new(zeros.len(), &lagrangian.structure()),
            leapfrog: Box::new(Leapfrog::new(&lagrangian, durations, kicks)),
            block: Jacobian::with_structure(zeros.len(), &lagrangian.structure()),
            lagrangian,
            velocity: zeros.clone(),
            dl_dq: zeros.clone(),
            dl_dv: zeros,
        })
    }

    /// Blanes and Moan's method with eleven pieces (S. Blanes and P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 3,
    /// SRKN₁₁ᵇ): order 6 for V(q), and for V(t, q) too. Its coefficients are printed to fifteen digits.
    ///
    /// # Errors
    /// [`SystemError::NotSeparable`] for a Lagrangian that does not say that it is.
    pub fn blanes_moan(lagrangian: L) -> Result<Self, InputError> {
        let middle = 1.0 - 2.0 * DURATIONS.iter().sum::<f64>();
        let durations: Vec<f64> = DURATIONS.into_iter().chain([middle]).chain(DURATIONS.into_iter().rev()).collect();
        let half: Vec<f64> = KICKS.into_iter().chain([0.5 - KICKS.iter().sum::<f64>()]).collect();
        let kicks: Vec<f64> = half.iter().chain(half.iter().rev()).copied().collect();
        Self::new(lagrangian, &durations, &kicks)
    }

    /// The Lagrangian.
    pub fn lagrangian(&self) -> &L {
        &self.lagrangian
    }

    /// The number s of pieces.
    fn pieces(&self) -> usize {
        self.durations.len()
    }

    /// Time of knot i.
    fn time(&self, at: Interval, i: usize) -> f64 {
        at.start + self.times[i] * at.h
    }

    /// The rows of the equations with M d_i, and its weights there: stationarity in the knots 1, …, s − 1, then α p₀ + β p₁.
    fn rows_of_piece(&self, i: usize, w: MomentumWeights) -> [(usize, f64); 2] {
        let s = self.pieces();
        [if i == 1 { (s, w.alpha) } else { (i - 1, -1.0) }, if i == s { (s, w.beta) } else { (i, 1.0) }]
    }

    /// The row of the equations with h b_i L_q(x_i), and its weight there.
    fn row_of_kick(&self, i: usize, w: MomentumWeights) -> (usize, f64) {
        let s = self.pieces();
        match i {
            0 => (s, -w.alpha),
            _ if i == s => (s, w.beta),
            _ => (i, 1.0),
        }
    }

    /// Writes the equations from row `first` on, of rows 1 to s.
    fn conditions(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, first: usize, out: &mut [f64]) {
        out.fill(0.0);
        let mut add = |(row, weight): (usize, f64), of: &[f64]| {
            if row >= first {
                let out = &mut out[(row - first) * of.len()..];
                out.iter_mut().zip(of).for_each(|(out, x)| *out += weight * x);
            }
        };
        for i in 0..=self.pieces() {
            let here = knot(i, q0, x);
            if i > 0 {
                secant(at.h * self.durations[i - 1], knot(i - 1, q0, x), here, &mut self.velocity);
            }
            self.lagrangian.gradient(self.time(at, i), here, &self.velocity, &mut self.dl_dq, &mut self.dl_dv);
            if i > 0 {
                self.rows_of_piece(i, w).into_iter().for_each(|row| add(row, &self.dl_dv));
            }
            let (row, weight) = self.row_of_kick(i, w);
            add((row, weight * at.h * self.kicks[i]), &self.dl_dq);
        }
    }

    /// Adds the derivatives of all equations in the knots of some columns, knot `first` being that of the first column.
    fn assemble(
        &mut self,
        at: Interval,
        (q0, x): (&[f64], &[f64]),
        w: MomentumWeights,
        (first, last): (usize, usize),
        out: &mut Jacobian,
    ) {
        const QQ: HessianWeights = HessianWeights { qq: 1.0, qv: 0.0, vq: 0.0, vv: 0.0 };
        const VV: HessianWeights = HessianWeights { qq: 0.0, qv: 0.0, vq: 0.0, vv: 1.0 };
        let n = q0.len();
        self.velocity.fill(0.0);
        for i in first..=last {
            self.block.clear();
            self.lagrangian.add_hessian(self.time(at, i), knot(i, q0, x), &self.velocity, QQ, &mut self.block);
            let (row, weight) = self.row_of_kick(i, w);
            add_block(out, ((row - 1) * n, (i - first) * n), weight * at.h * self.kicks[i], &self.block);
        }
        self.block.clear();
        self.lagrangian.add_hessian(at.start, q0, &self.velocity, VV, &mut self.block);
        for i in 1..=self.pieces() {
            let rate = (at.h * self.durations[i - 1]).recip();
            for (row, weight) in self.rows_of_piece(i, w) {
                for (column, slope) in [(i - 1, -rate), (i, rate)] {
                    if (first..=last).contains(&column) {
                        add_block(out, ((row - 1) * n, (column - first) * n), weight * slope, &self.block);
                    }
                }
            }
        }
    }
}

/// Knot i of the path.
fn knot<'a>(i: usize, q0: &'a [f64], x: &'a [f64]) -> &'a [f64] {
    if i == 0 { q0 } else { &x[(i - 1) * q0.len()..i * q0.len()] }
}

impl<L: Lagrangian> DiscreteLegendre for BrokenLine<L> {
    fn dim(&self) -> usize {
        self.lagrangian.dim()
    }

    fn interior(&self) -> usize {
        (self.pieces() - 1) * self.dim()
    }

    fn structure(&self) -> Structure {
        self.lagrangian.structure().blocks(self.dim(), self.pieces())
    }

    fn predict(&mut self, at: Interval, q0: &[f64], p0: &[f64], x: &mut [f64]) -> Result<(), SolveError> {
        let v = self.velocity_of.of(&self.lagrangian, at.start, q0, p0)?;
        for (knot, c) in x.chunks_exact_mut(q0.len()).zip(&self.times[1..]) {
            straight(c * at.h, q0, v, knot);
        }
        Ok(())
    }

    fn separable_step(
        &mut self,
        at: Interval,
        q: &mut [f64],
        p: &mut [f64],
        x: &mut [f64],
    ) -> Result<Option<u64>, SolveError> {
        self.leapfrog.step(&self.lagrangian, at, q, p, x).map(Some)
    }

    fn momentum(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        self.conditions(at, q0, x, w, self.pieces(), out);
    }

    fn equations(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut [f64]) {
        self.conditions(at, q0, x, w, 1, out);
    }

    fn add_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.assemble(at, (q0, x), w, (1, self.pieces()), out);
    }

    fn add_start_derivative(&mut self, at: Interval, q0: &[f64], x: &[f64], w: MomentumWeights, out: &mut Jacobian) {
        self.assemble(at, (q0, x), w, (0, 0), out);
    }
}

impl<L: Lagrangian> DiscreteLagrangian for BrokenLine<L> {
    fn action(&mut self, at: Interval, q0: &[f64], x: &[f64]) -> f64 {
        let mut action = 0.0;
        for i in 0..=self.pieces() {
            let (t, here) = (self.time(at, i), knot(i, q0, x));
            self.velocity.fill(0.0);
            let potential = -self.lagrangian.value(t, here, &self.velocity);
            action -= at.h * self.kicks[i] * potential;
            if i > 0 {
                let duration = at.h * self.durations[i - 1];
                secant(duration, knot(i - 1, q0, x), here, &mut self.velocity);
                action += duration * (self.lagrangian.value(t, here, &self.velocity) + potential);
            }
        }
        action
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AutoLagrangian, LagrangianFn, Scalar};

    struct Free;

    impl LagrangianFn for Free {
        fn dim(&self) -> usize {
            1
        }

        fn is_separable(&self) -> bool {
            true
        }

        fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
            v[0] * v[0] * 0.5
        }
    }

    /// Kicks at the knots integrate t⁰, …, t⁵, as order 6 needs, to within the rounding of fifteen printed digits.
    #[test]
    fn the_kicks_of_blanes_and_moan_integrate_degree_five() {
        let method = BrokenLine::blanes_moan(AutoLagrangian::new(Free)).expect("separable");
        assert_eq!(method.pieces(), 11);
        for k in 0..=5 {
            let sum: f64 = method.kicks.iter().zip(&method.times).map(|(b, c)| b * c.powi(k)).sum();
            let exact = 1.0 / f64::from(k + 1);
            // Twelve kicks and eleven durations of half a unit in the fifteenth digit each, times |b|, |k cᵏ⁻¹| ≤ 5.
            assert!((sum - exact).abs() <= 5e-16 * (12.0 + 11.0 * 5.0), "degree {k}: {sum} for {exact}");
        }
    }
}
