//! Steps on random problems against the branch that starts at the present state, followed by other means.

mod follow;

use crate::fields::As;
use crate::systems::{field_of, lagrangian_of};
use follow::{Followed, follow};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::closure::{Closure, Linear};
use lsvi::discrete::{Galerkin, Midpoint, Trapezoidal};
use lsvi::quadrature::Quadrature;
use lsvi::solver::Iterative;
use lsvi::{
    AutoField, Factored, FieldFn, Integrator, Jacobian, LagrangianFn, LeastSquares, LeastSquaresStep, OneStep, Scalar,
    SolveError, State, StepError, Structure, Trajectory, Variational, VectorField, least_squares, method_i, method_ii,
    position_momentum,
};
use nalgebra::DMatrix;

/// v̇ = f(v) with f a polynomial of degree three.
#[derive(Clone, Copy, Debug)]
struct Polynomial([f64; 4]);

const QUADRATIC_DRAG: Polynomial = Polynomial([0.0, 0.0, -1.0, 0.0]);
const LOGISTIC: Polynomial = Polynomial([0.0, 1.0, -1.0, 0.0]);
const CUBIC: Polynomial = Polynomial([0.0, 1.0, 0.0, -1.0]);

impl Polynomial {
    fn value(&self, v: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * v + c)
    }
    fn slope(&self, v: f64) -> f64 {
        self.0[1] + v * (2.0 * self.0[2] + v * 3.0 * self.0[3])
    }
}

impl FieldFn for Polynomial {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = self.0.iter().rev().fold(T::from(0.0), |sum, c| sum * v[0] + *c);
    }
}

#[derive(Clone, Copy, Debug)]
enum Method {
    /// α p₀ + β p₁ = 0.
    Linear(f64, f64),
    /// The closure fitted to a rate, whose α + β vanishes with h.
    Fitted(f64),
    /// Method II by another program.
    GalerkinTwo,
    /// x = v + h [(1 − θ) f(v) + θ f(x)].
    Theta(f64),
    /// x = v + h f((v + x)/2), solved for the midpoint.
    Midpoint,
}

const METHODS: [Method; 14] = [
    Method::Linear(0.0, 1.0),
    Method::Linear(-1.0, 1.0),
    Method::Linear(-0.9, 1.0),
    Method::Linear(-0.5, 1.0),
    Method::Linear(-0.2, 1.0),
    Method::Linear(0.5, 1.0),
    Method::Linear(1.0, 1.0),
    Method::Linear(1.0, 0.2),
    Method::Fitted(4.0),
    Method::Fitted(0.5),
    Method::GalerkinTwo,
    Method::Theta(1.0),
    Method::Theta(0.5),
    Method::Midpoint,
];

impl Method {
    fn build<F: FieldFn + 'static>(self, field: F) -> Box<dyn OneStep> {
        let field = field_of(field);
        match self {
            Self::Linear(0.0, 1.0) => Box::new(method_i(field).expect("valid")),
            Self::Linear(-1.0, 1.0) => Box::new(method_ii(field).expect("valid")),
            Self::Linear(a, b) => Box::new(least_squares(field, Linear::new(a, b).expect("a closure")).expect("valid")),
            Self::Fitted(rate) => {
                let closure = Linear::fitted_pade(rate).expect("positive");
                Box::new(least_squares(field, closure).expect("valid"))
            }
            Self::GalerkinTwo => {
                let nodes = Quadrature::lobatto(2).expect("a rule");
                let discrete = Galerkin::new(LeastSquares::new(field).expect("valid"), 1, &nodes).expect("a path");
                Box::new(Variational::new(discrete, Linear::METHOD_II))
            }
            Self::Theta(1.0) => Box::new(RungeKutta::new(field, Tableau::implicit_euler()).expect("valid")),
            Self::Theta(_) => Box::new(RungeKutta::new(field, Tableau::trapezoidal()).expect("valid")),
            Self::Midpoint => Box::new(RungeKutta::new(field, Tableau::implicit_midpoint()).expect("valid")),
        }
    }

    /// The equation of a step from `v`, of its size `s` and the value `x` at its end.
    fn equation(self, f: Polynomial, v: f64) -> impl Fn(f64, f64) -> f64 {
        let (at_v, slope) = (f.value(v), f.slope(v));
        let method = if let Self::GalerkinTwo = self { Self::Linear(-1.0, 1.0) } else { self };
        move |s, x| {
            let d = x - v;
            let residuals = || (d - s * at_v, d - s * f.value(x));
            match method {
                Self::Theta(theta) => d - s * ((1.0 - theta) * at_v + theta * f.value(x)),
                Self::Midpoint => d - s * f.value(0.5 * (v + x)),
                Self::Fitted(rate) => {
                    let ((r0, r1), z) = (residuals(), 0.5 * s * rate);
                    // (α + β)(r₀ + r₁) + s (α J₀ r₀ − β J₁ r₁), α = −1/(1 + z) and β = 1, over s.
                    0.5 * rate / (1.0 + z) * (r0 + r1) - (slope * r0 / (1.0 + z) + f.slope(x) * r1)
                }
                Self::GalerkinTwo => unreachable!("it is Method II"),
                // α p₀ + β p₁ over s, divided by s once more where α + β = 0.
                Self::Linear(alpha, beta) if alpha + beta == 0.0 => {
                    let (r0, r1) = residuals();
                    slope * r0 + f.slope(x) * r1
                }
                Self::Linear(alpha, beta) => {
                    let (r0, r1) = residuals();
                    alpha * ((1.0 + s * slope) * r0 + r1) + beta * (r0 + (1.0 - s * f.slope(x)) * r1)
                }
            }
        }
    }
}

/// Two copies of a scalar equation in turned coordinates, in which every method does what it does on each copy.
#[derive(Clone, Copy, Debug)]
struct Turned(Polynomial);

const C: f64 = 0.8;
const S: f64 = 0.6;

impl FieldFn for Turned {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        let mut f = [T::from(0.0); 2];
        self.0.rhs(t, &[v[0] * C + v[1] * S], &mut f[..1]);
        self.0.rhs(t, &[v[1] * C - v[0] * S], &mut f[1..]);
        dv[0] = f[0] * C - f[1] * S;
        dv[1] = f[0] * S + f[1] * C;
    }
}

/// Uniform numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        // Knuth's MMIX generator; the upper bits are the good ones.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// A random start and step size.
fn start(random: &mut Random) -> (f64, f64) {
    (random.within(-2.0, 2.0), 10.0_f64.powf(random.within(-2.0, 2.0)))
}

fn agrees(found: f64, root: f64, v: f64) -> bool {
    (found - root).abs() <= 1e-6 * (root.abs() + v.abs())
}

#[test]
fn no_step_returns_a_root_of_another_branch() {
    let mut random = Random(1);
    let (mut wrong, mut refused, mut steps, mut lost, mut undecided) = (Vec::new(), Vec::new(), 0, 0, 0);
    let known = [QUADRATIC_DRAG, LOGISTIC, CUBIC].map(|field| (field, 400));
    // Of any four coefficients: steady states of every kind, growth, blow-up, folds of two signs.
    let others = [(); 600].map(|()| (Polynomial([(); 4].map(|()| random.within(-2.0, 2.0))), 1));
    for (field, starts) in known.into_iter().chain(others) {
        for method in METHODS {
            let mut integrator = method.build(field);
            for _ in 0..starts {
                let (v, h) = start(&mut random);
                let mut x = [v];
                let step = integrator.step(0.0, h, &mut x, &mut [0.0]);
                let truth = follow(method.equation(field, v), v, h);
                let what = || format!("{field:?} {method:?} v = {v} h = {h}: {step:?} {x:?}, {truth:?}");
                match truth {
                    Followed::To(root) if step.is_ok() && agrees(x[0], root, v) => steps += 1,
                    Followed::To(_) if step.is_err() => refused.push(what()),
                    Followed::To(_) => wrong.push(what()),
                    Followed::Lost if step.is_ok() => wrong.push(what()),
                    Followed::Lost => lost += 1,
                    Followed::Undecided => undecided += 1,
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert!(
        100 * undecided < steps.min(lost),
        "{steps} lead to a root, {lost} to none, and of {undecided} nothing is known"
    );
    // Branches that pass each other closer than a continuation dares to go between them.
    assert!(refused.len() <= steps / 1000, "{} refused:\n{}", refused.len(), refused.join("\n"));
}

/// Where hJ = 2(α + β)/(β − α), the start is a root of its step, which the branch leaves for h → 0 and may not come back to. So near
/// to it the first increment is too small to tell the equation from an affine one.
#[test]
fn no_step_stands_still_beside_a_root_that_its_branch_does_not_come_back_to() {
    let mut random = Random(4);
    let (mut wrong, mut refused, mut stays, mut leaves) = (Vec::new(), Vec::new(), 0, 0);
    for field in [QUADRATIC_DRAG, LOGISTIC, CUBIC] {
        for method in METHODS {
            let Method::Linear(alpha, beta) = method else { continue };
            for _ in 0..200 {
                let (v, _) = start(&mut random);
                let h = 2.0 * (alpha + beta) / ((beta - alpha) * field.slope(v));
                if !(h > 0.0 && h < 1e3) {
                    continue;
                }
                let v = v + 10.0_f64.powf(random.within(-14.0, -4.0)) * random.within(-1.0, 1.0).signum();
                let mut x = [v];
                let step = method.build(field).step(0.0, h, &mut x, &mut [0.0]);
                let truth = follow(method.equation(field, v), v, h);
                let what = || format!("{field:?} {method:?} v = {v} h = {h}: {step:?} {x:?}, {truth:?}");
                match truth {
                    Followed::To(_) if step.is_err() => refused.push(what()),
                    // Beside a crossing the step is ill-conditioned; a root of another branch is further away, by a part of v.
                    Followed::To(root) if (x[0] - root).abs() > 1e-3 * v.abs() => wrong.push(what()),
                    Followed::To(root) if agrees(root, v, v) => stays += 1,
                    Followed::To(_) => leaves += 1,
                    Followed::Lost if step.is_ok() => wrong.push(what()),
                    Followed::Lost | Followed::Undecided => {}
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong of {}:\n{}", wrong.len(), stays + leaves, wrong.join("\n"));
    assert!(stays > 100 && leaves > 100, "{stays} come back and {leaves} do not");
    assert!(refused.len() <= (stays + leaves) / 100, "{} refused:\n{}", refused.len(), refused.join("\n"));
}

/// The same where the start is a root of a part of the step, at which a branch is looked at: increments there are roundings, and in proportion
/// to anything.
#[test]
fn a_start_that_is_a_root_of_a_part_of_the_step_tells_nothing_of_its_branch() {
    const PARTS: [f64; 8] = [0.75, 0.5, 0.375, 1.0 / 3.0, 0.25, 0.125, 0.0625, 0.03125];
    let mut random = Random(6);
    let (mut wrong, mut refused, mut looked_at) = (Vec::new(), Vec::new(), 0);
    for field in [QUADRATIC_DRAG, LOGISTIC, CUBIC] {
        for method in METHODS {
            let Method::Linear(alpha, beta) = method else { continue };
            for _ in 0..50 {
                let (v, _) = start(&mut random);
                let root_at = 2.0 * (alpha + beta) / ((beta - alpha) * field.slope(v));
                if !(root_at > 0.0 && root_at < 1e3) {
                    continue;
                }
                for part in PARTS {
                    let (h, v) = (root_at / part, v * (1.0 + f64::EPSILON * random.within(-8.0, 8.0).round()));
                    let mut x = [v];
                    let step = method.build(field).step(0.0, h, &mut x, &mut [0.0]);
                    let truth = follow(method.equation(field, v), v, h);
                    let what = || format!("{field:?} {method:?} v = {v} h = {h}: {step:?} {x:?}, {truth:?}");
                    looked_at += u32::from(matches!(truth, Followed::To(_)));
                    match truth {
                        Followed::To(_) if step.is_err() => refused.push(what()),
                        Followed::To(root) if !agrees(x[0], root, v) => wrong.push(what()),
                        Followed::Lost if step.is_ok() => wrong.push(what()),
                        _ => {}
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong of {looked_at}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(looked_at > 500, "{looked_at}");
    assert!(refused.len() <= looked_at as usize / 100, "{} refused:\n{}", refused.len(), refused.join("\n"));
}

/// An integrator that has stood beside rest, where equations are next to affine, is put to another start beside such a root.
#[test]
fn what_was_found_at_one_start_is_not_believed_at_another() {
    let mut random = Random(5);
    let (mut wrong, mut looked_at) = (Vec::new(), 0);
    for (field, rests) in [(QUADRATIC_DRAG, &[0.0][..]), (LOGISTIC, &[0.0, 1.0]), (CUBIC, &[0.0])] {
        for method in METHODS {
            let Method::Linear(alpha, beta) = method else { continue };
            for _ in 0..20 {
                let (v, _) = start(&mut random);
                let h = 2.0 * (alpha + beta) / ((beta - alpha) * field.slope(v));
                if !(h > 0.0 && h < 1e3) {
                    continue;
                }
                let v = v + 10.0_f64.powf(random.within(-14.0, -4.0)) * random.within(-1.0, 1.0).signum();
                let truth = follow(method.equation(field, v), v, h);
                for (rest, k) in rests.iter().flat_map(|rest| (-100..=-8).map(move |k| (rest, k))) {
                    let mut integrator = method.build(field);
                    let beside = rest + 2_f64.powf(0.5 * f64::from(k));
                    let first = integrator.step(0.0, h, &mut [beside], &mut [0.0]);
                    let mut x = [v];
                    let step = integrator.step(0.0, h, &mut x, &mut [0.0]);
                    let is_right = match truth {
                        Followed::To(root) => step.is_err() || (x[0] - root).abs() <= 1e-3 * v.abs(),
                        Followed::Lost => step.is_err(),
                        Followed::Undecided => true,
                    };
                    looked_at += u32::from(first.is_ok());
                    if !is_right {
                        wrong.push(format!("{field:?} {method:?} {beside:e}, v = {v} h = {h}: {x:?}, {truth:?}"));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong of {looked_at}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(looked_at > 10_000, "{looked_at}");
}

/// Far beyond accuracy, where the derivative at the start is like that at the root, and half-way there is no root.
#[test]
fn a_root_beyond_the_end_of_a_branch_is_refused() {
    let cases = [
        ([0.0, -1.5, -1.5, 0.5], Method::Linear(-1.0, 1.0), 1.5, 0.9),
        ([1.5, 0.0, -1.0, -0.5], Method::Linear(-0.5, 1.0), -1.0, 1.4),
        ([0.0, 0.0, 1.0, 0.0], Method::Linear(-1.0, 1.0), 1.0, 1.0),
        ([0.0, -1.0, 2.0, 1.0], Method::Linear(-1.0, 1.0), -1.5, 1.5),
        ([-2.0, -1.5, 0.0, 1.5], Method::Linear(0.0, 1.0), 0.5, 0.7),
        ([-1.0, 1.5, -1.5, -1.5], Method::Linear(0.0, 1.0), -0.167, 1.07),
        ([0.5, -0.5, 1.0, 1.0], Method::Linear(1.0, 0.2), -0.347, 3.42),
        ([-1.0, 0.0, 1.0, 0.0], Method::Linear(0.0, 1.0), 0.5, 2.0),
    ];
    for (coefficients, method, v, h) in cases {
        let field = Polynomial(coefficients);
        let truth = follow(method.equation(field, v), v, h);
        for structure in [Structure::Dense, Structure::Banded { lower: 0, upper: 0 }] {
            let mut x = [v];
            let step = method.build(As(structure.clone(), field)).step(0.0, h, &mut x, &mut [0.0]);
            let what = format!("{field:?} {method:?} v = {v} h = {h}, {structure:?}: {step:?} {x:?}, {truth:?}");
            match truth {
                Followed::To(root) => assert!(step.is_err() || agrees(x[0], root, v), "{what}"),
                Followed::Lost => assert!(step.is_err(), "{what}"),
                Followed::Undecided => panic!("{what}"),
            }
        }
    }
}

/// Ṡ = −10⁻³ S/(S + 10⁻⁶), and beside it an unknown that rests.
#[derive(Clone, Copy)]
struct Enzyme {
    is_beside: bool,
}

impl FieldFn for Enzyme {
    fn dim(&self) -> usize {
        1 + usize::from(self.is_beside)
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = -v[0] / (v[0] + 1e-6) * 1e-3;
        if let [_, v] = v {
            dv[1] = *v * 0.0;
        }
    }
}

/// A motion of less than √ε of the largest unknown is solved as it is alone, to roundings of that one: its increments are no roundings.
#[test]
fn an_unknown_may_be_small_beside_another() {
    type Make = fn(Enzyme) -> Box<dyn OneStep>;
    let steps: [(&str, Make); 9] = [
        ("I", |f| Box::new(method_i(AutoField::new(f)).expect("usable"))),
        ("(-1/2, 1)", |f| {
            Box::new(least_squares(AutoField::new(f), Linear::new(-0.5, 1.0).expect("weights")).expect("usable"))
        }),
        ("trapezoidal", |f| Box::new(RungeKutta::new(AutoField::new(f), Tableau::trapezoidal()).expect("usable"))),
        ("midpoint", |f| Box::new(RungeKutta::new(AutoField::new(f), Tableau::implicit_midpoint()).expect("usable"))),
        ("sdirk2", |f| Box::new(RungeKutta::new(AutoField::new(f), Tableau::sdirk2()).expect("usable"))),
        ("tr-bdf2", |f| Box::new(RungeKutta::new(AutoField::new(f), Tableau::tr_bdf2()).expect("usable"))),
        ("galerkin", |f| {
            let l = LeastSquares::new(AutoField::new(f)).expect("usable");
            let galerkin = Galerkin::new(l, 2, &Quadrature::radau(2).expect("nodes")).expect("fits");
            Box::new(Variational::new(galerkin, Linear::METHOD_I))
        }),
        ("I by products", |f| {
            let solver = Iterative::new(Factored::default()).with_tolerance(1e-14).expect("in (0, 1)");
            Box::new(LeastSquaresStep::with_solver(AutoField::new(f), Linear::METHOD_I, solver).expect("usable"))
        }),
        ("sdirk2 by products", |f| {
            let solver = Iterative::new(Factored::default()).with_tolerance(1e-14).expect("in (0, 1)");
            Box::new(RungeKutta::with_solver(AutoField::new(f), Tableau::sdirk2(), solver).expect("usable"))
        }),
    ];
    for (name, make) in steps {
        for (start, h) in [1e-5, 1e-6].into_iter().flat_map(|start| [1e-3, 1e-2].map(|h| (start, h))) {
            let mut alone = [start];
            let is_found = make(Enzyme { is_beside: false }).step(0.0, h, &mut alone, &mut [0.0]).is_ok();
            for large in [1.0, 1e2, 300.0, 1e4, 1e6] {
                let mut v = [start, large];
                let step = make(Enzyme { is_beside: true }).step(0.0, h, &mut v, &mut [0.0; 2]);
                let said = format!("{name} from {start:e}, h = {h}, beside {large:e}: {step:?} {v:?}, alone {alone:?}");
                assert_eq!(step.is_ok(), is_found, "{said}");
                // 64 times what four roundings of the largest are, and a hundred tolerances of an iterative solver.
                let part = if name.ends_with("products") { 1e-12 } else { 256.0 * f64::EPSILON };
                assert!((v[0] - alone[0]).abs() <= part * large, "{said}");
            }
        }
    }
}

/// x + c x³ = 0 for x = α p₀ + β p₁, which is the linear closure in a form that does not say so.
struct Cubic {
    alpha: f64,
    beta: f64,
    c: f64,
}

impl Closure for Cubic {
    fn residual(&self, _h: f64, _p: &[f64], p0: &[f64], p1: &[f64], out: &mut [f64]) {
        let x = self.alpha * p0[0] + self.beta * p1[0];
        out[0] = x + self.c * x.powi(3);
    }
    fn derivative(
        &self,
        _h: f64,
        _p: &[f64],
        p0: &[f64],
        p1: &[f64],
        in_p0: &mut DMatrix<f64>,
        in_p1: &mut DMatrix<f64>,
    ) {
        let x = self.alpha * p0[0] + self.beta * p1[0];
        let slope = 1.0 + 3.0 * self.c * x * x;
        in_p0[(0, 0)] += self.alpha * slope;
        in_p1[(0, 0)] += self.beta * slope;
    }
}

/// v̇ = −v² from 1 with h from 0.03 to 300, more than half of them beyond the folds between 1 and 2.2.
#[test]
fn no_step_of_a_closure_that_is_not_linear_leads_to_a_root_of_another_branch() {
    let mut random = Random(7);
    for (alpha, beta) in [(-1.0, 1.0), (-0.5, 1.0), (0.0, 1.0)] {
        for c in [0.0, 0.1, 1.0] {
            let (mut found, mut refused, mut lost) = (0, 0, 0);
            for _ in 0..100 {
                let h = 10.0_f64.powf(random.within(-1.5, 2.5));
                let discrete = || {
                    let drag = AutoField::new(Polynomial([0.0, 0.0, -1.0, 0.0]));
                    Trapezoidal::new(LeastSquares::new(drag).expect("usable"))
                };
                let [mut v, mut exact] = [[1.0]; 2];
                let linear = Linear::new(alpha, beta).expect("weights");
                let truth = Variational::new(discrete(), linear).step(0.0, h, &mut exact, &mut [0.0]);
                let step = Variational::new(discrete(), Cubic { alpha, beta, c }).step(0.0, h, &mut v, &mut [0.0]);
                let what = format!("({alpha}, {beta}), c = {c}, h = {h}: {step:?} {v:?}, {truth:?} {exact:?}");
                match (truth.is_ok(), step.is_ok()) {
                    // Beside a fold a root is known to half of the digits.
                    (true, true) => assert!((v[0] - exact[0]).abs() <= f64::EPSILON.sqrt(), "{what}"),
                    (false, true) => panic!("{what}"),
                    (true, false) => refused += 1,
                    (false, false) => lost += 1,
                }
                found += usize::from(step.is_ok());
            }
            assert!(found >= 20 && lost >= 20 && refused <= 3, "{found} found, {refused} refused, {lost} lost");
        }
    }
}

/// A known limit: in the augmented equations of a band the same derivatives change less, and a fold between the looks may not show.
#[test]
fn a_root_beyond_the_end_of_a_branch_may_be_returned_with_a_band() {
    let (field, method, v, h) = (Polynomial([1.5, -1.0, 0.5, 0.0]), Method::Linear(-1.0, 1.0), 0.5988, 2.524);
    let field_in_a_band = As(Structure::Banded { lower: 0, upper: 0 }, field);
    let mut x = [v];
    method.build(field_in_a_band).step(0.0, h, &mut x, &mut [0.0]).expect("a root");
    assert!(matches!(follow(method.equation(field, v), v, h), Followed::Lost), "{x:?}");
    method.build(field).step(0.0, h, &mut [v], &mut [0.0]).expect_err("no root on the branch");
}

impl LagrangianFn for Polynomial {
    fn dim(&self) -> usize {
        1
    }
    /// q̇²/2 + ∫f.
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        let [a, b, c, d] = self.0;
        v[0] * v[0] * 0.5 + q[0] * (q[0] * (q[0] * (q[0] * (d / 4.0) + c / 3.0) + b / 2.0) + a)
    }
}

/// q̈ = f(q) by the midpoint rule, x − q − h p − h²/2 f((q + x)/2) = 0.
#[test]
fn no_step_of_a_motion_returns_a_root_of_another_branch() {
    let mut random = Random(6);
    let (mut wrong, mut refused, mut steps, mut lost) = (Vec::new(), Vec::new(), 0, 0);
    for _ in 0..3000 {
        let force = Polynomial([(); 4].map(|()| random.within(-2.0, 2.0)));
        let (q, p, h) = (random.within(-2.0, 2.0), random.within(-2.0, 2.0), 10.0_f64.powf(random.within(-1.0, 1.0)));
        let lagrangian = lagrangian_of(force);
        let mut x = [q];
        let step = position_momentum(Midpoint::new(&lagrangian)).step(0.0, h, &mut x, &mut [p]);
        let truth = follow(|s, x| x - q - s * p - 0.5 * s * s * force.value(0.5 * (q + x)), q, h);
        let what = || format!("{force:?} q = {q} p = {p} h = {h}: {step:?} {x:?}, {truth:?}");
        match truth {
            Followed::To(root) if step.is_ok() && agrees(x[0], root, q) => steps += 1,
            Followed::To(_) if step.is_err() => refused.push(what()),
            Followed::To(_) => wrong.push(what()),
            Followed::Lost if step.is_ok() => wrong.push(what()),
            Followed::Lost => lost += 1,
            Followed::Undecided => {}
        }
    }
    assert!(wrong.is_empty(), "{} wrong of {steps}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(steps > 1000 && lost > 500, "{steps} found and {lost} lost");
    assert!(refused.len() <= steps / 500, "{} refused:\n{}", refused.len(), refused.join("\n"));
}

/// Steps of one size with factors kept from earlier ones, towards blow-up, folds, crossings and rest.
#[test]
fn no_step_of_a_trajectory_returns_a_root_of_another_branch() {
    let mut random = Random(3);
    let (mut wrong, mut steps, mut with_kept_factors) = (Vec::new(), 0, 0);
    for method in METHODS.into_iter().filter(|method| matches!(method, Method::Linear(..))) {
        for field in [QUADRATIC_DRAG, LOGISTIC, CUBIC] {
            for _ in 0..20 {
                let mut integrator = method.build(field);
                let (mut v, h) = (random.within(-2.0, 2.0), 10.0_f64.powf(random.within(-2.5, 0.5)));
                for _ in 0..30 {
                    let (mut x, before) = ([v], integrator.work().factorizations);
                    let step = integrator.step(0.0, h, &mut x, &mut [0.0]);
                    let truth = follow(method.equation(field, v), v, h);
                    let is_right = match truth {
                        Followed::To(root) => step.is_err() || agrees(x[0], root, v),
                        Followed::Lost => step.is_err(),
                        Followed::Undecided => true,
                    };
                    if !is_right {
                        wrong.push(format!("{field:?} {method:?} v = {v} h = {h}: {x:?}, {truth:?}"));
                    }
                    if step.is_err() || !is_right || !matches!(truth, Followed::To(_)) {
                        break;
                    }
                    v = x[0];
                    steps += 1;
                    with_kept_factors += u64::from(integrator.work().factorizations == before);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong of {steps}:\n{}", wrong.len(), wrong.join("\n"));
    // Enough of them to say something of steps with kept factors.
    assert!(10 * with_kept_factors > steps, "{with_kept_factors} of {steps} steps with kept factors");
}

#[test]
fn a_determinant_that_two_modes_turn_twice_does_not_hide_another_branch() {
    let mut random = Random(2);
    let mut wrong = Vec::new();
    for field in [LOGISTIC, CUBIC] {
        for method in METHODS {
            let mut integrator = method.build(Turned(field));
            for _ in 0..40 {
                let ((a, h), (b, _)) = (start(&mut random), start(&mut random));
                // Equal copies turn the determinant at the same step size.
                let b = if random.next() < 0.5 { a } else { b };
                let mut x = [C * a - S * b, S * a + C * b];
                let Ok(()) = integrator.step(0.0, h, &mut x, &mut [0.0; 2]) else { continue };
                for (v, x) in [(a, C * x[0] + S * x[1]), (b, C * x[1] - S * x[0])] {
                    let truth = follow(method.equation(field, v), v, h);
                    let is_right = match truth {
                        Followed::To(root) => agrees(x, root, a.abs().max(b.abs())),
                        Followed::Lost => false,
                        Followed::Undecided => true,
                    };
                    if !is_right {
                        wrong.push(format!("{field:?} {method:?} v = {v} of ({a}, {b}), h = {h}: {x}, {truth:?}"));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// A damped circuit in units that are `unit` times one another, and its charge at rest.
struct Circuit {
    unit: f64,
}

impl FieldFn for Circuit {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1] / self.unit;
        dv[1] = (v[0] - 5.0 + v[1] * (0.05 / self.unit)) * (-1000.0 * self.unit);
    }
}

/// Implicit Euler, TR-BDF2, Radau IIA with two stages and BDF2.
fn implicit(field: impl FieldFn + 'static, k: usize) -> Box<dyn Integrator> {
    let field = field_of(field);
    let third = 3.0_f64.recip();
    let radau = [vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]];
    match k {
        0 => Box::new(RungeKutta::new(field, Tableau::implicit_euler()).expect("usable")),
        1 => Box::new(RungeKutta::new(field, Tableau::tr_bdf2()).expect("usable")),
        2 => Box::new(CoupledRungeKutta::new(field, &radau, &[0.75, 0.25], &[third, 1.0]).expect("usable")),
        _ => Box::new(Bdf2::new(field).expect("usable")),
    }
}

/// A circuit of nanoseconds, ohms and picofarads: the rate is what rounding leaves of volts, 10¹² times the charge.
struct Fast {
    volts: f64,
}

impl FieldFn for Fast {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = (v[0] / 1e-12 - self.volts + v[1] * 50.0) / -1e-9;
    }
}

#[test]
fn a_fast_circuit_comes_to_rest() {
    // In the last steps of a nanosecond the current is less than what the volts of a microvolt round to.
    for (volts, h) in [(5.0, 1e-12), (5.0, 1.333e-11), (5.0, 1e-10), (1e-6, 1e-9)] {
        for k in 0..4 {
            let method = implicit(Fast { volts }, k);
            let run = Trajectory::new(method, State::new(0.0, vec![0.0, 0.0]), h, 2e-8).expect("valid");
            let end = run.observe(|_| {});
            let charge = end.as_ref().map(|end| end.q[0] / (1e-12 * volts));
            assert!(charge.is_ok_and(|q| (q - 1.0).abs() < 2e-9), "{k}, {h}: {end:?}");
        }
    }
}

/// At rest the rate is what rounding leaves of the charge, times a thousand of either unit: increments contract by no ratio.
#[test]
fn a_circuit_comes_to_rest_in_any_units() {
    for exponent in -8..=8 {
        for h in [0.01, 0.033, 0.2] {
            for k in 0..4 {
                let method = implicit(Circuit { unit: 10_f64.powi(exponent) }, k);
                let run = Trajectory::new(method, State::new(0.0, vec![0.0, 0.0]), h, 60.0).expect("valid");
                let end = run.observe(|_| {});
                let charge = end.as_ref().map(|end| end.q[0]);
                assert!(charge.is_ok_and(|q| (q - 5.0).abs() < 1e-9), "{k}, 1e{exponent}, {h}: {end:?}");
            }
        }
    }
}

/// v̇ = −v³ with a noise of this size, which is a function of v.
struct Noisy(f64);

impl FieldFn for Noisy {
    fn dim(&self) -> usize {
        1
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        // The upper digits of a product with an odd number, as in hashing.
        let scattered = v[0].re().to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11;
        dv[0] = -v[0].powi(3) + self.0 * (2.0 * (scattered as f64 / (1_u64 << 53) as f64) - 1.0);
    }
}

/// Roundings of f that are large are borne up to 10⁻⁵ of the state, among them four times what is seen. Of more than that a root would be said
/// to be found that is known to a few digits.
#[test]
fn no_more_of_the_digits_of_a_step_are_given_up_for_noise_than_may_be() {
    let step = |noise: f64| {
        let method = RungeKutta::new(field_of(Noisy(noise)), Tableau::implicit_euler()).expect("usable");
        let run = Trajectory::new(method, State::new(0.0, vec![1.0]), 1.0, 1.0).expect("valid");
        run.observe(|_| {}).map(|end| end.q[0])
    };
    // v + v³ = 1.
    let root = 0.682_327_803_828_019_3;
    for noise in [1e-8, 1e-7, 1e-6] {
        let end = step(noise);
        assert!(end.is_ok_and(|v| (v - root).abs() <= 1e-5), "{noise}");
    }
    for noise in [1e-4, 1e-3] {
        let end = step(noise);
        assert!(matches!(end, Err(StepError::Solve { .. })), "{noise}: {end:?}");
    }
}

/// A bead that falls on a spring: f has a kink where they meet, and the equation of an implicit stage one root, as k max(−x, 0) falls in x.
#[derive(Clone, Copy)]
struct Contact(f64);

impl VectorField for Contact {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = v[1];
        dv[1] = self.0 * (-v[0]).max(0.0) - 1.0;
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 1, scale);
        out.add(1, 0, if v[0] < 0.0 { -self.0 * scale } else { 0.0 });
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

const SOFT: Contact = Contact(400.0);

#[test]
fn the_branch_goes_on_behind_a_kink() {
    let solver = |k: u32| -> Box<dyn Integrator> {
        match k {
            0 => Box::new(RungeKutta::new(SOFT, Tableau::implicit_euler()).expect("fits")),
            1 => Box::new(RungeKutta::new(SOFT, Tableau::trapezoidal()).expect("fits")),
            2 => Box::new(RungeKutta::new(SOFT, Tableau::implicit_midpoint()).expect("fits")),
            3 => Box::new(RungeKutta::new(SOFT, Tableau::sdirk2()).expect("fits")),
            4 => Box::new(RungeKutta::new(SOFT, Tableau::tr_bdf2()).expect("fits")),
            _ => Box::new(Bdf2::new(SOFT).expect("fits")),
        }
    };
    for k in 0..6 {
        for h in [0.1, 0.05, 0.02, 0.01, 0.004] {
            let mut run = Trajectory::new(solver(k), State::new(0.0, vec![1.0, 0.0]), h, 6.0).expect("valid");
            let mut last = [1.0, 0.0];
            while let Some(state) = run.step().unwrap_or_else(|error| panic!("{k}, h = {h}: {error}")) {
                let (v, mut f) = ([state.q[0], state.q[1]], [0.0; 2]);
                SOFT.rhs(0.0, &v, &mut f);
                let left = (0..2).map(|i| (v[i] - last[i] - h * f[i]).abs()).sum::<f64>();
                assert!(k > 0 || left < 1e-14, "h = {h}: {left:e}");
                last = v;
            }
        }
    }
}

/// The stages of Radau IIA, found together from its equations and from those of its action, whose derivative is BᵀB: of position and velocity, which are in unlike
/// units, it is far from itself at a step size that is hardly another.
#[test]
fn stages_found_together_go_on_behind_a_kink() {
    let a = [vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]];
    for exponent in 4..=8 {
        let field = Contact(10f64.powi(exponent));
        for part in [0.1, 0.3, 1.0, 3.0] {
            let h = part / field.0.sqrt();
            // Beyond, the roundings of the increments, (h k)² ε, are a hundredth of what tells a kink: a thousandth of a way of 6e-5.
            if h * field.0 > 2e3 {
                continue;
            }
            let action = LeastSquares::new(field).expect("M = I");
            let rule = Quadrature::radau(2).expect("two nodes");
            let galerkin = Galerkin::new(action, 2, &rule).expect("it fits");
            let mut least = Variational::new(galerkin, Linear::new(0.0, 1.0).expect("weights"));
            let mut coupled = CoupledRungeKutta::new(field, &a, &a[1], &[1.0 / 3.0, 1.0]).expect("usable");
            // From just above the stop, at unit speed, until it is left.
            let (mut v, mut p) = ([0.4 * h, -1.0], [0.0; 2]);
            while v[1] < 0.0 || v[0] < 0.0 {
                let mut other = v;
                least.step(0.0, h, &mut v, &mut p).unwrap_or_else(|error| panic!("1e{exponent}, {part}: {error}"));
                coupled
                    .step(0.0, h, &mut other, &mut [])
                    .unwrap_or_else(|error| panic!("1e{exponent}, {part}: {error}"));
                // κ(BᵀB) is at most (1 + h k)².
                let bound = 16.0 * f64::EPSILON * (1.0 + h * field.0).powi(2);
                assert!(
                    (v[0] - other[0]).abs().max((v[1] - other[1]).abs()) <= bound,
                    "1e{exponent}, {part}: {v:?} {other:?}"
                );
            }
        }
    }
}

/// From where all is slow to where it is free, and across a kink beside 0, of which the roundings of the terms are more than its own. Such f falls in v, and the step of
/// implicit Euler is the one zero of a function that grows.
#[test]
fn a_kink_is_crossed_however_unlike_its_sides() {
    struct Springs {
        constant: f64,
        amplitude: f64,
        /// Stiffness and place of a stop from above, and from below.
        stops: [[f64; 2]; 2],
    }
    impl VectorField for Springs {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            let [[k, c], [l, d]] = self.stops;
            let drive = self.constant + self.amplitude * (3.0 * t).sin();
            dv[0] = drive - k * (v[0] - c).max(0.0) + l * (d - v[0]).max(0.0);
        }
        fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
            let [[k, c], [l, d]] = self.stops;
            out.add(0, 0, scale * if v[0] > c { -k } else { 0.0 });
            out.add(0, 0, scale * if v[0] < d { -l } else { 0.0 });
        }
    }
    let slow = Springs {
        constant: 1.220185617649427,
        amplitude: 9.502921876211671,
        stops: [[9131.808804859902, -0.5426037077367734], [0.0, 0.0]],
    };
    let small = Springs {
        constant: -0.11101902569553346,
        amplitude: 0.5744211824541963,
        stops: [[70.14865914171361, 0.604530122336367], [1.8851465981286186, -0.009129825816118098]],
    };
    for (field, t, start) in [(slow, 7.0, -0.5422473160815886), (small, 9.0, 0.28686699768052326)] {
        let mut v = [start];
        let mut euler = RungeKutta::new(&field, Tableau::implicit_euler()).expect("fits");
        euler.step(t, 1.0, &mut v, &mut []).unwrap_or_else(|error| panic!("t = {t}: {error}"));
        let mut f = [0.0];
        field.rhs(t + 1.0, &v, &mut f);
        assert!((v[0] - start - f[0]).abs() < 1e-12, "{v:?} {f:?}");
    }
}

/// v = s (1 + 3 max(v − ½, 0)) has the root s as far as s = ½, where the branch turns back.
#[test]
fn a_branch_that_turns_back_at_a_kink_ends_there() {
    struct Runaway;
    impl VectorField for Runaway {
        fn dim(&self) -> usize {
            1
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            dv[0] = 1.0 + 3.0 * (v[0] - 0.5).max(0.0);
        }
        fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(0, 0, if v[0] > 0.5 { 3.0 * scale } else { 0.0 });
        }
    }
    let mut euler = RungeKutta::new(Runaway, Tableau::implicit_euler()).expect("fits");
    for h in [0.51, 0.7, 1.0, 4.0] {
        let error = euler.step(0.0, h, &mut [0.0], &mut []).expect_err("there is no root on the branch");
        let StepError::Solve { source: SolveError::BranchLost { reached }, .. } = error else {
            panic!("{h}: {error:?}")
        };
        assert!((reached - 0.5).abs() < 1e-8, "{h}: {reached}");
    }
    let mut v = [0.0];
    euler.step(0.0, 0.3, &mut v, &mut []).expect("there is");
    assert!((v[0] - 0.3).abs() < 1e-15);
}

/// v̇ = v(1 − v) in a step of Method I: about v₀ = 1.9183 the branch comes by another near h = 4.82, and beyond that v₀ it ends there. However near,
/// it is followed to its own end or given up.
#[test]
fn a_branch_that_comes_by_another_is_no_kink() {
    let step = |v0: f64, h: f64| {
        let mut v = [v0];
        method_i(field_of(LOGISTIC)).expect("fits").step(0.0, h, &mut v, &mut [0.0]).map(|()| v[0])
    };
    let (mut below, mut above) = (1.0, 3.0);
    for _ in 0..60 {
        let middle = 0.5 * (below + above);
        match step(middle, 5.015625) {
            Ok(_) => below = middle,
            Err(StepError::Solve { source: SolveError::BranchLost { reached }, .. }) => {
                assert!(reached < 5.0, "{middle}: {reached}");
                above = middle;
            }
            Err(error) => panic!("{middle}: {error}"),
        }
    }
    // The branch at the last start that has a step is that of starts before it.
    let [last, before] = [step(below, 5.015625), step(below - 1e-3, 5.015625)].map(|v| v.expect("on the branch"));
    assert!((last - before).abs() < 0.1, "{last} {before}");
}
