//! Lagrangians from one generic definition.

use num_dual::{Dual64, HyperDual64, HyperHyperDual64};

use super::{Scalar, sweep};
use crate::lagrangian::{EulerLagrange, HessianWeights, Lagrangian, MotionWeights};
use crate::linalg::{Jacobian, by_size};
use crate::pool::Pool;

/// A Lagrangian L(t, q, v), written once for every [`Scalar`].
///
/// Time is a [`Scalar`] too: d/dt ∂L/∂v has a term ∂²L/∂v∂t.
///
/// ```
/// use lsvi::{LagrangianFn, Scalar};
/// struct Pendulum;
/// impl LagrangianFn for Pendulum {
///     fn dim(&self) -> usize { 1 }
///     fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
///         v[0] * v[0] * 0.5 + q[0].cos()
///     }
/// }
/// ```
pub trait LagrangianFn {
    /// Degrees of freedom n.
    fn dim(&self) -> usize;

    /// Whether L = ½ vᵀMv − V(t, q) with a constant M, as [`Lagrangian::is_separable`].
    fn is_separable(&self) -> bool {
        false
    }

    /// L(t, q, v); q and v have length [`dim`](Self::dim).
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T;
}

impl<F: LagrangianFn> LagrangianFn for &F {
    fn dim(&self) -> usize {
        (**self).dim()
    }
    fn is_separable(&self) -> bool {
        (**self).is_separable()
    }
    fn lagrangian<T: Scalar>(&self, t: T, q: &[T], v: &[T]) -> T {
        (**self).lagrangian(t, q, v)
    }
}

/// Makes a [`Lagrangian`] with its [`EulerLagrange`] equations of a [`LagrangianFn`].
///
/// A gradient takes 2n evaluations, a Hessian n(2n + 1), the derivative of the Euler–Lagrange expression n(2n + 1) or fewer, all dense: of many
/// unknowns a [`Lagrangian`] written by hand, with its gradient and its [structure](Lagrangian::structure), is faster, the more the larger n is.
#[derive(Debug)]
pub struct AutoLagrangian<F> {
    function: F,
    first: Pool<Point<Dual64>>,
    second: Pool<Point<HyperDual64>>,
    third: Pool<Point<HyperHyperDual64>>,
}

/// The arguments of L with their infinitesimal parts.
#[derive(Debug)]
struct Point<T> {
    q: Vec<T>,
    v: Vec<T>,
}

impl<T: Scalar> Point<T> {
    fn new(dim: usize) -> Pool<Self> {
        Pool::new(move || Self { q: vec![T::from(0.0); dim], v: vec![T::from(0.0); dim] })
    }

    fn seed(&mut self, q: &[f64], v: &[f64]) {
        self.q.iter_mut().zip(q).for_each(|(dual, &x)| *dual = T::from(x));
        self.v.iter_mut().zip(v).for_each(|(dual, &x)| *dual = T::from(x));
    }
}

impl<F: LagrangianFn> AutoLagrangian<F> {
    /// Wraps `function`.
    pub fn new(function: F) -> Self {
        let dim = function.dim();
        Self { first: Point::new(dim), second: Point::new(dim), third: Point::new(dim), function }
    }

    /// The definition that is differentiated.
    pub fn inner(&self) -> &F {
        &self.function
    }
}

/// L at dual numbers. Behind a pointer, so that the loops around it are compiled once and not for every L.
type Function<'a, T> = &'a dyn Fn(T, &[T], &[T]) -> T;

impl<F: LagrangianFn> AutoLagrangian<F> {
    /// [`Lagrangian::gradient`] of N degrees of freedom.
    #[inline]
    fn gradient_small<const N: usize>(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        let q_dual = sweep::constants::<Dual64, N>(q);
        self.gradient_q_small::<N>(t, q, v, dl_dq);
        let dl_dv = &mut dl_dv[..N];
        sweep::each::<N>(v, |j, v| dl_dv[j] = self.function.lagrangian(t.into(), &q_dual, v).eps);
    }

    /// [`Lagrangian::gradient_q`] of N degrees of freedom.
    #[inline(always)]
    fn gradient_q_small<const N: usize>(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64]) {
        let v = sweep::constants::<Dual64, N>(v);
        let dl_dq = &mut dl_dq[..N];
        sweep::each::<N>(q, |j, q| dl_dq[j] = self.function.lagrangian(t.into(), q, &v).eps);
    }
}

impl<F: LagrangianFn> Lagrangian for AutoLagrangian<F> {
    fn dim(&self) -> usize {
        self.function.dim()
    }

    fn is_separable(&self) -> bool {
        self.function.is_separable()
    }

    #[inline(always)]
    fn gradient_q(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], work: &mut [f64]) {
        match q.len() {
            1 => self.gradient_q_small::<1>(t, q, v, dl_dq),
            2 => self.gradient_q_small::<2>(t, q, v, dl_dq),
            3 => self.gradient_q_small::<3>(t, q, v, dl_dq),
            4 => self.gradient_q_small::<4>(t, q, v, dl_dq),
            _ => self.gradient(t, q, v, dl_dq, work),
        }
    }

    fn value(&self, t: f64, q: &[f64], v: &[f64]) -> f64 {
        self.function.lagrangian(t, q, v)
    }

    #[inline]
    fn gradient(&self, t: f64, q: &[f64], v: &[f64], dl_dq: &mut [f64], dl_dv: &mut [f64]) {
        match q.len() {
            1 => self.gradient_small::<1>(t, q, v, dl_dq, dl_dv),
            2 => self.gradient_small::<2>(t, q, v, dl_dq, dl_dv),
            3 => self.gradient_small::<3>(t, q, v, dl_dq, dl_dv),
            4 => self.gradient_small::<4>(t, q, v, dl_dq, dl_dv),
            _ => self.first.with(|x| {
                x.seed(q, v);
                gradient(&|t, q, v| self.function.lagrangian(t, q, v), t, x, dl_dq, dl_dv);
            }),
        }
    }

    fn add_hessian(&self, t: f64, q: &[f64], v: &[f64], c: HessianWeights, out: &mut Jacobian) {
        let function: Function<HyperDual64> = &|t, q, v| self.function.lagrangian(t, q, v);
        add_hessian_of(function, &self.second, t, (q, v), c, out);
    }
}

impl<F: LagrangianFn> EulerLagrange for AutoLagrangian<F> {
    fn residual(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]) {
        self.first.with(|x| {
            x.seed(q, v);
            write_dl_dq(&|t, q, v| self.function.lagrangian(t, q, v), t, x, out);
        });
        self.second.with(|x| {
            x.seed(q, v);
            subtract_rate(&|t, q, v| self.function.lagrangian(t, q, v), t, (v, a), x, out);
        });
    }

    fn add_residual_derivative(&self, t: f64, q: &[f64], v: &[f64], a: &[f64], c: MotionWeights, out: &mut Jacobian) {
        if c.q != 0.0 {
            self.add_hessian(t, q, v, HessianWeights { qq: c.q, ..Default::default() }, out);
        }
        self.third.with(|x| {
            x.seed(q, v);
            add_rate_derivative(&|t, q, v| self.function.lagrangian(t, q, v), t, (v, a), x, c, out);
        });
    }
}

fn gradient(l: Function<Dual64>, t: f64, x: &mut Point<Dual64>, dl_dq: &mut [f64], dl_dv: &mut [f64]) {
    let t = Dual64::from(t);
    for i in 0..x.q.len() {
        x.q[i].eps = 1.0;
        dl_dq[i] = l(t, &x.q, &x.v).eps;
        x.q[i].eps = 0.0;
        x.v[i].eps = 1.0;
        dl_dv[i] = l(t, &x.q, &x.v).eps;
        x.v[i].eps = 0.0;
    }
}

/// [`Lagrangian::add_hessian`], of few degrees of freedom with all numbers on the stack.
fn add_hessian_of(
    l: Function<HyperDual64>,
    points: &Pool<Point<HyperDual64>>,
    t: f64,
    (q, v): (&[f64], &[f64]),
    c: HessianWeights,
    out: &mut Jacobian,
) {
    by_size!(q.len(), N => if v.len() == N {
        let (mut q, mut v) = (sweep::constants::<_, N>(q), sweep::constants::<_, N>(v));
        return add_hessian(l, t, (&mut q, &mut v), c, out);
    }, else {});
    points.with(|x| {
        x.seed(q, v);
        add_hessian(l, t, (&mut x.q, &mut x.v), c, out);
    });
}

/// The same at `q` and `v`.
fn add_hessian(
    l: Function<HyperDual64>,
    t: f64,
    (q, v): (&mut [HyperDual64], &mut [HyperDual64]),
    c: HessianWeights,
    out: &mut Jacobian,
) {
    let t = HyperDual64::from(t);
    for i in 0..q.len() {
        if c.qq != 0.0 {
            q[i].eps1 = 1.0;
            for j in 0..=i {
                q[j].eps2 = 1.0;
                add_symmetric(out, (i, j), c.qq * l(t, q, v).eps1eps2);
                q[j].eps2 = 0.0;
            }
            q[i].eps1 = 0.0;
        }
        v[i].eps1 = 1.0;
        if c.qv != 0.0 || c.vq != 0.0 {
            for j in 0..q.len() {
                q[j].eps2 = 1.0;
                let mixed = l(t, q, v).eps1eps2;
                q[j].eps2 = 0.0;
                out.add(i, j, c.vq * mixed);
                out.add(j, i, c.qv * mixed);
            }
        }
        if c.vv != 0.0 {
            for j in 0..=i {
                v[j].eps2 = 1.0;
                add_symmetric(out, (i, j), c.vv * l(t, q, v).eps1eps2);
                v[j].eps2 = 0.0;
            }
        }
        v[i].eps1 = 0.0;
    }
}

/// Writes ∂L/∂q.
fn write_dl_dq(l: Function<Dual64>, t: f64, x: &mut Point<Dual64>, out: &mut [f64]) {
    for (i, out) in out.iter_mut().enumerate() {
        x.q[i].eps = 1.0;
        *out = l(Dual64::from(t), &x.q, &x.v).eps;
        x.q[i].eps = 0.0;
    }
}

/// Subtracts d/dt ∂L/∂v, the derivative of ∂L/∂v in the direction (1, v, a) of the motion.
fn subtract_rate(
    l: Function<HyperDual64>,
    t: f64,
    (v, a): (&[f64], &[f64]),
    x: &mut Point<HyperDual64>,
    out: &mut [f64],
) {
    let mut t = HyperDual64::from(t);
    t.eps2 = 1.0;
    for i in 0..v.len() {
        x.q[i].eps2 = v[i];
        x.v[i].eps2 = a[i];
    }
    for (i, out) in out.iter_mut().enumerate() {
        x.v[i].eps1 = 1.0;
        *out -= l(t, &x.q, &x.v).eps1eps2;
        x.v[i].eps1 = 0.0;
    }
}

/// With D = d/dt along the motion: E_q = L_qq − D L_vq, E_v = L_qv − L_vq − D L_vv, E_a = −L_vv. All but the term L_qq.
fn add_rate_derivative(
    l: Function<HyperHyperDual64>,
    t: f64,
    (v, a): (&[f64], &[f64]),
    x: &mut Point<HyperHyperDual64>,
    c: MotionWeights,
    out: &mut Jacobian,
) {
    let mut t = HyperHyperDual64::from(t);
    t.eps3 = 1.0;
    for i in 0..v.len() {
        x.q[i].eps3 = v[i];
        x.v[i].eps3 = a[i];
    }
    for i in 0..v.len() {
        x.v[i].eps1 = 1.0;
        if c.q != 0.0 || c.v != 0.0 {
            for j in 0..v.len() {
                x.q[j].eps2 = 1.0;
                let mixed = l(t, &x.q, &x.v);
                x.q[j].eps2 = 0.0;
                out.add(i, j, -c.q * mixed.eps1eps2eps3 - c.v * mixed.eps1eps2);
                out.add(j, i, c.v * mixed.eps1eps2);
            }
        }
        if c.v != 0.0 || c.a != 0.0 {
            for j in 0..=i {
                x.v[j].eps2 = 1.0;
                let mass = l(t, &x.q, &x.v);
                x.v[j].eps2 = 0.0;
                add_symmetric(out, (i, j), -c.v * mass.eps1eps2eps3 - c.a * mass.eps1eps2);
            }
        }
        x.v[i].eps1 = 0.0;
    }
}

fn add_symmetric(out: &mut Jacobian, (i, j): (usize, usize), x: f64) {
    out.add(i, j, x);
    if i != j {
        out.add(j, i, x);
    }
}
