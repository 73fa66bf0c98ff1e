//! Galerkin's method on least-squares Lagrangians.

use crate::systems::field_of;
use lsvi::closure::Linear;
use lsvi::discrete::Galerkin;
use lsvi::quadrature::Quadrature;
use lsvi::{FieldFn, InputError, LeastSquares, Scalar, State, Trajectory, Variational};

struct VanDerPol;
impl FieldFn for VanDerPol {
    fn dim(&self) -> usize {
        2
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv[0] = v[1];
        dv[1] = (-v[0] * v[0] + 1.0) * v[1] - v[0];
    }
}

type Rule = fn(usize) -> Result<Quadrature, InputError>;

fn end(s: usize, rule: &Quadrature, closure: Linear, h: f64) -> Vec<f64> {
    let discrete =
        Galerkin::new(LeastSquares::new(field_of(VanDerPol)).expect("usable"), s, rule).expect("enough nodes");
    let method = Variational::new(discrete, closure);
    let initial = State::new(0.0, vec![1.0, 0.5]);
    Trajectory::new(method, initial, h, 1.0).expect("valid").observe(|_| {}).expect("solvable").q
}

#[test]
fn orders_of_collocation_and_of_true_least_squares() {
    let truth = end(8, &Quadrature::gauss(8).expect("nodes"), Linear::METHOD_I, 0.1);
    // (rule, nodes beyond the degree s, order − 2s)
    let cases: [(&str, Rule, usize, i32); 4] = [
        ("gauss, r = s", Quadrature::gauss, 0, 0),
        ("radau, r = s", Quadrature::radau, 0, -1),
        ("gauss, r = s + 1", Quadrature::gauss, 1, 0),
        ("lobatto, r = s + 1", Quadrature::lobatto, 1, 0),
    ];
    let mut wrong = Vec::new();
    for (name, rule, more, lost) in cases {
        for s in 1..=3 {
            let rule = rule(s + more).expect("enough nodes");
            let error = |h: f64| {
                let end = end(s, &rule, Linear::METHOD_I, h);
                end.iter().zip(&truth).map(|(a, b)| (a - b).abs()).max_by(f64::total_cmp).expect("entries")
            };
            let h = if s < 3 { 0.05 } else { 0.1 };
            let order = (error(h) / error(0.5 * h)).log2();
            if !(0.0..=0.3).contains(&(order - f64::from(2 * s as i32 + lost)).abs()) {
                wrong.push(format!("{name}, s = {s}: {order:.2}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// With as many nodes as degrees the residual vanishes at the nodes whatever the closure: one collocation method.
#[test]
fn every_closure_collocates_where_nodes_are_as_many_as_degrees() {
    let explicit = || Linear::new(1.0, 0.3).expect("a condition");
    for s in 1..=3 {
        for rule in [Quadrature::gauss(s), Quadrature::radau(s)] {
            let rule = rule.expect("nodes");
            let (a, b) = (end(s, &rule, Linear::METHOD_I, 0.1), end(s, &rule, explicit(), 0.1));
            for (a, b) in a.iter().zip(&b) {
                // The least-squares equations have the square of the condition of collocation, about s⁴ here.
                approx::assert_abs_diff_eq!(a, b, epsilon = 1e3 * f64::EPSILON);
            }
        }
    }
}
