//! Whether the derivatives that a Lagrangian, a force or a constraint states are those of its values.

use nalgebra::DMatrix;

use super::difference::{Direction, Slope, agree, compare, directions, finite, pseudo_random, slopes, written};
use super::{Derivative, DerivativeError, Place, SCALE, Variable};
use crate::constraint::Constraint;
use crate::error::{check_time, check_unknowns, check_vector};
use crate::lagrangian::{EulerLagrange, Force, HessianWeights, Lagrangian, MotionWeights};
use crate::linalg::{Jacobian, Structure, add_block, larger, max_norm};

/// Checks the derivatives that `l` states at (`t`, `q`, `v`): the gradients ∂L/∂q and ∂L/∂v beside differences of L, and each
/// block of second derivatives beside differences of the gradients, with its weight and added to others, and in a matrix of its own.
///
/// It is done as by [`check_derivatives`](crate::check_derivatives). One state does not show all mistakes: check several.
///
/// ```
/// use lsvi::{Derivative, DerivativeError, HessianWeights, Jacobian, Lagrangian, Variable, check_lagrangian};
///
/// /// L = ½ v² + cos q, with the sign of its second derivative forgotten.
/// struct Pendulum;
///
/// impl Lagrangian for Pendulum {
///     fn dim(&self) -> usize {
///         1
///     }
///     fn value(&self, _t: f64, q: &[f64], v: &[f64]) -> f64 {
///         0.5 * v[0] * v[0] + q[0].cos()
///     }
///     fn gradient(&self, _t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
///         (dl_dq[0], dl_dv[0]) = (-q[0].sin(), v[0]);
///     }
///     fn add_hessian(&self, _t: f64, q: &[f64], _v: &[f64], c: HessianWeights, out: &mut Jacobian) {
///         out.add(0, 0, c.qq * q[0].cos() + c.vv);
///     }
/// }
///
/// let error = check_lagrangian(&Pendulum, 0.0, &[1.0], &[0.5]).expect_err("a wrong sign");
/// let expected = Derivative::Hessian(Variable::Q, Variable::Q);
/// assert!(matches!(error, DerivativeError::Differs { of, .. } if of == expected));
/// assert!(error.to_string().starts_with("∂²L/∂q∂q, row 0, column 0: stated is 0.54"));
/// ```
///
/// # Errors
/// [`DerivativeError`] with the first disagreement, or with what leaves the question open.
pub fn check_lagrangian<L: Lagrangian + ?Sized>(l: &L, t: f64, q: &[f64], v: &[f64]) -> Result<(), DerivativeError> {
    of_lagrangian(&l, t, q, v)
}

fn of_lagrangian(l: &dyn Lagrangian, t: f64, q: &[f64], v: &[f64]) -> Result<(), DerivativeError> {
    let n = l.dim();
    check_state(n, t, &[("q", q), ("v", v)])?;
    finite("L", &[l.value(t, q, v)])?;
    let gradient = |t: f64, q: &[f64], v: &[f64], out: &mut [f64]| {
        let (dl_dq, dl_dv) = out.split_at_mut(n);
        l.gradient(t, q, v, dl_dq, dl_dv);
    };
    let stated = written("the gradient of L", 2 * n, |out| gradient(t, q, v, out))?;
    finite("the gradient of L", &stated)?;
    let (dl_dq, dl_dv) = stated.split_at(n);
    for x in &directions(q) {
        let found = slopes(q, x, 1, |q, out| out[0] = l.value(t, q, v))?;
        compare_sum(Derivative::Gradient(Variable::Q), x, dl_dq, &found)?;
    }
    for x in &directions(v) {
        let found = slopes(v, x, 1, |v, out| out[0] = l.value(t, q, v))?;
        compare_sum(Derivative::Gradient(Variable::V), x, dl_dv, &found)?;
    }
    let alone = written("∂L/∂q", n, |out| l.gradient_q(t, q, v, out, &mut vec![0.0; n]))?;
    finite("∂L/∂q", &alone)?;
    let size = larger(larger(max_norm(&alone), max_norm(dl_dq)), l.value(t, q, v).abs());
    agree(Derivative::Gradient(Variable::Q), None, (&alone, dl_dq), 1e-10 * size)?;

    let half = |from: usize, in_q: bool| {
        move |x: &Direction| {
            let mut both = vec![0.0; 2 * n];
            slopes(if in_q { q } else { v }, x, n, |moved, out| {
                if in_q {
                    gradient(t, moved, v, &mut both)
                } else {
                    gradient(t, q, moved, &mut both)
                }
                out.copy_from_slice(&both[from..from + n]);
            })
        }
    };
    let [qq, qv, vq, vv] = [half(0, true), half(0, false), half(n, true), half(n, false)];
    let blocks: [Block<'_>; 4] = [
        (Derivative::Hessian(Variable::Q, Variable::Q), q, &qq),
        (Derivative::Hessian(Variable::Q, Variable::V), q, &qv),
        (Derivative::Hessian(Variable::V, Variable::Q), v, &vq),
        (Derivative::Hessian(Variable::V, Variable::V), v, &vv),
    ];
    check_blocks(n, &l.structure(), blocks, |[qq, qv, vq, vv], out| {
        l.add_hessian(t, q, v, HessianWeights { qq, qv, vq, vv }, out);
    })?;
    check_blocks(n, &l.structure(), blocks, |weights, out| {
        let mut each: [Jacobian; 4] = std::array::from_fn(|_| Jacobian::with_structure(n, &l.structure()));
        l.add_blocks(t, q, v, each.each_mut());
        weights.iter().zip(&each).for_each(|(weight, block)| add_block(out, (0, 0), *weight, block));
    })
}

/// Checks the Euler–Lagrange expression E that `l` states at (`t`, `q`, `v`) beside its gradients, E = ∂L/∂q − d/dt ∂L/∂v along a
/// curve with an acceleration of the checker's, and the derivatives of E beside differences of E, after
/// [`check_lagrangian`].
///
/// # Errors
/// [`DerivativeError`] with the first disagreement, or with what leaves the question open.
pub fn check_motion<L: EulerLagrange + ?Sized>(l: &L, t: f64, q: &[f64], v: &[f64]) -> Result<(), DerivativeError> {
    of_motion(&l, t, q, v)
}

fn of_motion(l: &dyn EulerLagrange, t: f64, q: &[f64], v: &[f64]) -> Result<(), DerivativeError> {
    check_lagrangian(l, t, q, v)?;
    let n = l.dim();
    let size = larger(max_norm(q), max_norm(v));
    // Off the motion, where E is not zero.
    let a: Vec<f64> = pseudo_random(n, 1).iter().map(|x| x * if size > 0.0 { size } else { 1.0 }).collect();
    let stated = written("E", n, |out| l.residual(t, q, v, &a, out))?;
    finite("E", &stated)?;
    let (mut dl_dq, mut dl_dv) = (vec![0.0; n], vec![0.0; n]);
    l.gradient(t, q, v, &mut dl_dq, &mut dl_dv);
    let along = |values: &[f64], rates: &[f64], time: f64| -> Vec<f64> {
        values.iter().zip(rates).map(|(x, rate)| x + time * rate).collect()
    };
    // L may depend on time: through the period of the motion, if it has one, or about that.
    let period = max_norm(q) / max_norm(v);
    let curve = Direction::along(if period.is_normal() { period } else { 1.0 });
    let mut work = vec![0.0; n];
    let rates = slopes(&[0.0], &curve, n, |time, out| {
        l.gradient(t + time[0], &along(q, v, time[0]), &along(v, &a, time[0]), &mut work, out);
    })?;
    let rounding = 1e-12 * max_norm(&dl_dq);
    let found: Vec<Slope> =
        rates.into_iter().zip(&dl_dq).map(|(rate, force)| rate.taken_from(*force, rounding)).collect();
    compare(Derivative::Motion, |row| Place { row: Some(row), column: None }, &stated, &found)?;

    let e = |q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]| l.residual(t, q, v, a, out);
    let in_q = |x: &Direction| slopes(q, x, n, |q, out| e(q, v, &a, out));
    let in_v = |x: &Direction| slopes(v, x, n, |v, out| e(q, v, &a, out));
    let in_a = |x: &Direction| slopes(&a, x, n, |a, out| e(q, v, a, out));
    let blocks: [Block<'_>; 3] = [
        (Derivative::MotionIn(Variable::Q), q, &in_q),
        (Derivative::MotionIn(Variable::V), v, &in_v),
        (Derivative::MotionIn(Variable::A), &a, &in_a),
    ];
    check_blocks(n, &l.structure(), blocks, |[q_weight, v_weight, a_weight], out| {
        let weights = MotionWeights { q: q_weight, v: v_weight, a: a_weight };
        l.add_residual_derivative(t, q, v, &a, weights, out);
    })
}

/// Checks the derivatives ∂F/∂q and ∂F/∂v that `force` states at (`t`, `q`, `v`) beside differences of F, as by [`check_lagrangian`].
///
/// # Errors
/// [`DerivativeError`] with the first disagreement, or with what leaves the question open.
pub fn check_force<F: Force + ?Sized>(force: &F, t: f64, q: &[f64], v: &[f64]) -> Result<(), DerivativeError> {
    let n = force.dim();
    check_state(n, t, &[("q", q), ("v", v)])?;
    finite("F", &written("F", n, |out| force.force(t, q, v, out))?)?;
    let in_q = |x: &Direction| slopes(q, x, n, |q, out| force.force(t, q, v, out));
    let in_v = |x: &Direction| slopes(v, x, n, |v, out| force.force(t, q, v, out));
    let blocks: [Block<'_>; 2] =
        [(Derivative::Force(Variable::Q), q, &in_q), (Derivative::Force(Variable::V), v, &in_v)];
    check_blocks(n, &force.structure(), blocks, |[in_q, in_v], out| force.add_derivative(t, q, v, in_q, in_v, out))
}

/// Checks the derivatives that `constraint` states at `q`: ∂f/∂q beside differences of f, and Σ_k λ_k ∂²f_k/∂q² beside those of
/// Σ_k λ_k ∂f_k/∂q with multipliers of the checker's, as by [`check_lagrangian`].
///
/// # Errors
/// [`DerivativeError`] with the first disagreement, or with what leaves the question open.
pub fn check_constraint<K: Constraint + ?Sized>(constraint: &K, q: &[f64]) -> Result<(), DerivativeError> {
    let (n, m) = (constraint.dim(), constraint.count());
    check_state(n, 0.0, &[("q", q)])?;
    finite("f", &written("f", m, |out| constraint.value(q, out))?)?;
    // Columns of the Jacobian in the order of its storage.
    let jacobian = |q: &[f64], out: &mut [f64]| {
        let mut matrix = DMatrix::from_column_slice(m, n, out);
        constraint.jacobian(q, &mut matrix);
        out.copy_from_slice(matrix.as_slice());
    };
    let stated = written("∂f/∂q", m * n, |out| jacobian(q, out))?;
    finite("∂f/∂q", &stated)?;
    let matrix = DMatrix::from_column_slice(m, n, &stated);
    for x in &directions(q) {
        let product = x.x.iter().zip(matrix.column_iter()).fold(vec![0.0; m], |mut sum, (x, column)| {
            sum.iter_mut().zip(&column).for_each(|(sum, a)| *sum += x * a);
            sum
        });
        let found = slopes(q, x, m, |q, out| constraint.value(q, out))?;
        compare(Derivative::Constraint, |row| Place { row: Some(row), column: x.axis }, &product, &found)?;
    }
    let multipliers = pseudo_random(m, 2);
    let reaction = |x: &Direction| {
        slopes(q, x, n, |q, out| {
            let mut matrix = vec![0.0; m * n];
            jacobian(q, &mut matrix);
            out.iter_mut().zip(matrix.chunks(m.max(1))).for_each(|(out, column)| {
                *out = column.iter().zip(&multipliers).map(|(a, lambda)| a * lambda).sum();
            });
        })
    };
    let blocks: [Block<'_>; 1] = [(Derivative::Reaction, q, &reaction)];
    check_blocks(n, &Structure::Dense, blocks, |[scale], out| constraint.add_curvature(q, &multipliers, scale, out))
}

fn check_state(n: usize, t: f64, vectors: &[(&'static str, &[f64])]) -> Result<(), DerivativeError> {
    check_unknowns(n)?;
    check_time(t)?;
    vectors.iter().try_for_each(|(name, values)| check_vector(name, values, n))?;
    Ok(())
}

/// A sum over all components of a gradient beside the derivative of the function.
fn compare_sum(of: Derivative, x: &Direction, gradient: &[f64], found: &[Slope]) -> Result<(), DerivativeError> {
    let sum: f64 = gradient.iter().zip(&x.x).map(|(g, x)| g * x).sum();
    compare(of, |_| Place { row: x.axis, column: None }, &[sum], found)
}

/// A matrix of derivatives: by what name, of which values, and what differences make of its product with a direction.
type Block<'a> = (Derivative, &'a [f64], &'a dyn Fn(&Direction) -> Result<Vec<Slope>, DerivativeError>);

/// Holds blocks that are added with weights to what differences give, each alone and all of them together.
fn check_blocks<const K: usize>(
    n: usize,
    structure: &Structure,
    blocks: [Block<'_>; K],
    add: impl Fn([f64; K], &mut Jacobian),
) -> Result<(), DerivativeError> {
    let alone = |k: usize, weight: f64| std::array::from_fn(|i| if i == k { weight } else { 0.0 });
    for (k, (of, _, difference)) in blocks.iter().enumerate() {
        let mut matrix = Jacobian::with_structure(n, structure);
        add(alone(k, SCALE), &mut matrix);
        if let Some((row, column)) = matrix.outside() {
            return Err(DerivativeError::Outside { row, column });
        }
        for x in &directions(blocks[k].1) {
            let mut product = vec![0.0; n];
            matrix.mul_add(SCALE.recip(), &x.x, &mut product);
            finite("a derivative", &product)?;
            compare(*of, |row| Place { row: Some(row), column: x.axis }, &product, &difference(x)?)?;
        }
    }
    // Each block has its own weight, and the blocks add up.
    let weight = |k: usize| SCALE * (1.0 + k as f64);
    let (mut together, mut in_turn) = (Jacobian::with_structure(n, structure), Jacobian::with_structure(n, structure));
    add(std::array::from_fn(weight), &mut together);
    (0..K).for_each(|k| add(alone(k, weight(k)), &mut in_turn));
    let x = pseudo_random(n, 3);
    let product = |matrix: &Jacobian| {
        let mut product = vec![0.0; n];
        matrix.mul_add(1.0, &x, &mut product);
        product
    };
    let (together, in_turn) = (product(&together), product(&in_turn));
    finite("a derivative", &together)?;
    let size = larger(max_norm(&together), max_norm(&in_turn));
    agree(Derivative::Blocks, None, (&together, &in_turn), 1e-10 * size)
}
