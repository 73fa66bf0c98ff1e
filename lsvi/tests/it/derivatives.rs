//! Wrong derivatives are named, and right ones pass.

use crate::fields::Products;
use lsvi::{
    AutoField, Derivative, DerivativeError, FieldFn, InputError, Jacobian, Place, Scalar, Structure, SystemError,
    Variable, VectorField, add_columns, check_derivatives, field,
};

/// Products, sines, roots and a large constant, in n unknowns on a ring.
struct Ring(usize);

impl FieldFn for Ring {
    fn dim(&self) -> usize {
        self.0
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        for i in 0..self.0 {
            let (left, right) = (v[(i + self.0 - 1) % self.0], v[(i + 1) % self.0]);
            dv[i] = left * right - v[i].sin() * t + (v[i] * v[i] + 2.0).sqrt() + 1e3;
        }
    }
}

/// What is wrong with [`Flawed`].
#[derive(Debug, Clone, Copy, PartialEq)]
enum Flaw {
    None,
    Entry,
    /// A term of 1e-4 of the entry.
    Term,
    Assembled,
    Linearize,
    Transpose,
    Curvature,
    NaN,
    Outside,
}

/// The ring's derivatives, with a flaw in row 2, column 1.
struct Flawed(AutoField<Ring>, Flaw, Structure);

impl Flawed {
    fn add(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_jacobian(t, v, scale, out);
        let wrong = match self.1 {
            Flaw::Entry => 0.5,
            Flaw::Term => 1e-4 * v[3],
            Flaw::NaN => f64::NAN,
            _ => return,
        };
        out.add(2, 1, scale * wrong);
    }
}

impl VectorField for Flawed {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn structure(&self) -> Structure {
        self.2.clone()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.add(t, v, scale, out);
        match self.1 {
            Flaw::Assembled => out.add(2, 1, scale * 0.5),
            Flaw::Outside => out.add(2, self.dim(), 1.0),
            _ => {}
        }
    }
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        self.rhs(t, v, dv);
        self.add_jacobian(t, v, scale, out);
        if self.1 == Flaw::Linearize {
            out.add(2, 1, scale * 0.5);
        }
    }
    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        let mut jacobian = Jacobian::zeros(self.dim());
        self.add(t, v, 1.0, &mut jacobian);
        out.copy_from_slice((jacobian.to_dense() * lsvi::nalgebra::DVector::from_column_slice(x)).as_slice());
    }
    fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
        self.0.apply_transpose(t, v, w, out);
        match self.1 {
            // That of the flawed J, which is no flaw of its own.
            Flaw::Transpose | Flaw::Entry => out[1] += 0.5 * w[2],
            Flaw::Term => out[1] += 1e-4 * v[3] * w[2],
            _ => {}
        }
    }
    fn apply_curvature(&self, t: f64, v: &[f64], w: &[f64], x: &[f64], out: &mut [f64]) {
        self.0.apply_curvature(t, v, w, x, out);
        if self.1 == Flaw::Curvature {
            out[2] += 0.5 * x[1];
        }
    }
}

fn state(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.3 + (i as f64).sin()).collect()
}

#[test]
fn derivatives_that_are_right_pass_on_every_way_to_state_them() {
    for n in [3, 7, 32, 33, 100] {
        check_derivatives(&AutoField::new(Ring(n)), 0.7, &state(n)).expect("automatic");
        for structure in [Structure::Dense, Structure::MatrixFree] {
            check_derivatives(&Flawed(AutoField::new(Ring(n)), Flaw::None, structure), 0.7, &state(n))
                .expect("by hand");
        }
    }
}

/// v̇ = −v², whose derivatives forget a scale.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scaleless {
    Jacobian,
    Linearize,
    Curvature,
}

impl VectorField for Scaleless {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = -v[0] * v[0];
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        let scale = if *self == Self::Jacobian { 1.0 } else { scale };
        out.add(0, 0, -2.0 * v[0] * scale);
    }
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        self.rhs(t, v, dv);
        self.add_jacobian(t, v, if *self == Self::Linearize { 1.0 } else { scale }, out);
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, -2.0 * w[0] * if *self == Self::Curvature { 1.0 } else { scale });
    }
}

#[test]
fn a_scale_that_is_not_heeded_is_found() {
    for (field, expected) in [
        (Scaleless::Jacobian, Derivative::Assembled),
        (Scaleless::Linearize, Derivative::Assembled),
        (Scaleless::Curvature, Derivative::Curvature),
    ] {
        let found = check_derivatives(&field, 0.0, &[0.7]);
        assert!(matches!(found, Err(DerivativeError::Differs { of, .. }) if of == expected), "{field:?} {found:?}");
    }
}

/// v̇ = −v, by functions that add to what they are given, or give another f together with the Jacobian.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Careless {
    Rate,
    Product,
    Transpose,
    AtOnce,
    OtherRate,
}

impl Careless {
    /// Writes −v, or adds it.
    fn put(self, adds: Self, v: &[f64], out: &mut [f64]) {
        out[0] = if self == adds { out[0] } else { 0.0 } - v[0];
    }
}

impl VectorField for Careless {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        self.put(Self::Rate, v, dv);
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, -scale);
    }
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        let factor = if *self == Self::OtherRate { 0.9 } else { 1.0 };
        self.put(Self::AtOnce, &[factor * v[0]], dv);
        self.add_jacobian(t, v, scale, out);
    }
    fn apply_jacobian(&self, _t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
        self.put(Self::Product, x, out);
    }
    fn apply_transpose(&self, _t: f64, _v: &[f64], w: &[f64], out: &mut [f64]) {
        self.put(Self::Transpose, w, out);
    }
}

#[test]
fn functions_that_add_to_what_they_should_write_are_found() {
    for (field, name) in [
        (Careless::Rate, "f"),
        (Careless::Product, "J x"),
        (Careless::Transpose, "the transposed product"),
        (Careless::AtOnce, "f of linearize"),
    ] {
        let found = check_derivatives(&field, 0.0, &[0.7]);
        assert!(
            matches!(found, Err(DerivativeError::NotWritten { what, row: 0 }) if what == name),
            "{field:?} {found:?}"
        );
    }
    let found = check_derivatives(&Careless::OtherRate, 0.0, &[0.7]);
    assert!(matches!(found, Err(DerivativeError::Differs { of: Derivative::Rate, .. })), "{found:?}");
}

#[test]
fn a_zero_beside_large_entries_is_known_to_what_their_sums_round_by() {
    let sums = field!(2, |_t, v, dv| {
        dv[0] = v[0] * 1e4;
        dv[1] = (v[0] * 1e4 + v[1]) - v[0] * 1e4;
    });
    for k in 0..20 {
        check_derivatives(&sums, 0.0, &[0.3 + 0.01 * f64::from(k), 0.7]).expect("right");
    }
}

/// One right field in two ways of adding up, or one whose f together with the Jacobian is no number.
struct Resting(f64);

impl VectorField for Resting {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = (0.1 * v[0] + 0.2 * v[1]) - 0.3;
        dv[1] = -v[1];
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, 0.1 * scale);
        out.add(0, 1, 0.2 * scale);
        out.add(1, 1, -scale);
    }
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        dv[0] = 0.1 * v[0] + (0.2 * v[1] - 0.3) + self.0;
        dv[1] = -v[1];
        self.add_jacobian(t, v, scale, out);
    }
}

#[test]
fn near_rest_f_is_known_to_the_rounding_of_its_terms() {
    check_derivatives(&Resting(0.0), 0.0, &[1.0, 1.0]).expect("right");
    check_derivatives(&Resting(0.0), 0.0, &[0.999_999_9, 1.0]).expect("right");
    let found = check_derivatives(&Resting(1e-9), 0.0, &[1.0, 1.0]);
    assert!(matches!(found, Err(DerivativeError::Differs { of: Derivative::Rate, .. })), "{found:?}");
    let found = check_derivatives(&Resting(f64::NAN), 0.0, &[1.0, 1.0]);
    assert!(matches!(found, Err(DerivativeError::NonFinite { what: "f of linearize", row: 0 })), "{found:?}");
}

/// sin 30v, with an exact product and the default entries of its curvature.
struct Wave;

impl VectorField for Wave {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = (30.0 * v[0]).sin();
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, 30.0 * (30.0 * v[0]).cos() * scale);
    }
    fn apply_curvature(&self, _t: f64, v: &[f64], w: &[f64], x: &[f64], out: &mut [f64]) {
        out[0] = -900.0 * (30.0 * v[0]).sin() * w[0] * x[0];
    }
}

#[test]
fn entries_by_differences_beside_an_exact_product_are_right() {
    check_derivatives(&Wave, 0.0, &[100.0]).expect("right");
}

#[test]
fn every_flaw_is_named_with_its_place() {
    use Derivative::{Assembled, Curvature, Transpose};
    let at = |row, column| Place { row: Some(row), column: Some(column) };
    for structure in [Structure::Dense, Structure::MatrixFree] {
        let check =
            |n, flaw| check_derivatives(&Flawed(AutoField::new(Ring(n)), flaw, structure.clone()), 0.7, &state(n));
        for flaw in [Flaw::Entry, Flaw::Term] {
            for (n, column) in [(7, Some(1)), (40, None)] {
                let Err(DerivativeError::Differs { of: Derivative::Jacobian, place, stated, found, within }) =
                    check(n, flaw)
                else {
                    panic!("{flaw:?} {n}")
                };
                assert_eq!(place, Place { row: Some(2), column });
                assert!((stated - found).abs() > 10.0 * within, "{stated} {found} {within}");
            }
        }
        for (flaw, of) in [(Flaw::Assembled, Assembled), (Flaw::Linearize, Assembled)] {
            let found = check(7, flaw);
            if structure == Structure::MatrixFree {
                found.expect("no entries are used");
            } else {
                assert!(
                    matches!(found, Err(DerivativeError::Differs { of: o, place, .. }) if o == of && place == at(2, 1)),
                    "{flaw:?}"
                );
            }
        }
        assert!(matches!(
            check(7, Flaw::Transpose),
            Err(DerivativeError::Differs { of: Transpose, place, .. }) if place == at(2, 1)
        ));
        for n in [7, 40] {
            assert!(
                matches!(check(n, Flaw::Curvature), Err(DerivativeError::Differs { of: Curvature, place, .. }) if place.row == Some(2))
            );
            assert!(matches!(check(n, Flaw::Transpose), Err(DerivativeError::Differs { of: Transpose, .. })));
            assert!(matches!(check(n, Flaw::NaN), Err(DerivativeError::NonFinite { row: 2, .. })));
        }
        let outside = check(7, Flaw::Outside);
        assert!(structure == Structure::MatrixFree || outside == Err(DerivativeError::Outside { row: 2, column: 7 }));
    }
}

/// The ring's field, of which one statement is off by 1e-7: differences are blind to that, and products that belong together are not.
struct Slightly(AutoField<Ring>, Derivative);

impl Slightly {
    fn factor(&self, of: Derivative) -> f64 {
        if self.1 == of { 1.0 + 1e-7 } else { 1.0 }
    }
}

impl VectorField for Slightly {
    fn dim(&self) -> usize {
        self.0.dim()
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        self.0.rhs(t, v, dv);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_jacobian(t, v, scale * self.factor(Derivative::Assembled), out);
    }
    fn apply_jacobian(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.0.apply_jacobian(t, v, x, out);
    }
    fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
        self.0.apply_transpose(t, v, w, out);
        out.iter_mut().for_each(|o| *o *= self.factor(Derivative::Transpose));
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        self.0.add_curvature(t, v, w, scale, out);
    }
}

#[test]
fn statements_that_belong_together_agree_to_rounding() {
    for wrong in [Derivative::Assembled, Derivative::Transpose] {
        let found = check_derivatives(&Slightly(AutoField::new(Ring(7)), wrong), 0.7, &state(7));
        assert!(matches!(found, Err(DerivativeError::Differs { of, .. }) if of == wrong), "{wrong:?}: {found:?}");
    }
    check_derivatives(&Slightly(AutoField::new(Ring(7)), Derivative::Curvature), 0.7, &state(7)).expect("right");
}

/// Differences in v₀ = 1e-3 that were taken at the distance of v₁ = 1e3 would cross the pole.
#[test]
fn every_unknown_has_a_scale_of_its_own() {
    let field = lsvi::field!(2, |_t, v, dv| {
        dv[0] = v[0].recip();
        dv[1] = -v[1];
    });
    check_derivatives(&field, 0.0, &[1e-3, 1e3]).expect("right");
}

/// f = max(v₀, 0), |v₀|^¼ at v₀ = 1e-30 and a root that ends at 0, with J as in the closed forms.
struct Rough(u8);

impl VectorField for Rough {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = match self.0 {
            0 => v[0].max(0.0),
            1 => (v[0] * 1e6).sin().signum(),
            _ => v[0].sqrt(),
        };
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        let slope = match self.0 {
            0 => f64::from(u8::from(v[0] > 0.0)),
            1 => 0.0,
            _ => 0.5 / v[0].sqrt(),
        };
        out.add(0, 0, scale * slope);
    }
    fn add_curvature(&self, _t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        if self.0 > 1 {
            out.add(0, 0, -0.25 * scale * w[0] / (v[0] * v[0].sqrt()));
        }
    }
}

#[test]
fn what_is_not_smooth_does_not_pass() {
    // Differences across the kink give one half.
    assert!(matches!(check_derivatives(&Rough(0), 0.0, &[0.0]), Err(DerivativeError::Differs { .. })));
    assert!(check_derivatives(&Rough(1), 0.0, &[0.3]).is_err());
    check_derivatives(&Rough(2), 0.0, &[1e-3]).expect("smooth where it is");
    assert!(matches!(check_derivatives(&Rough(2), 0.0, &[-1.0]), Err(DerivativeError::NonFinite { row: 0, .. })));
}

#[test]
fn what_is_no_state_is_refused() {
    let field = AutoField::new(Ring(3));
    for (t, v) in [(0.0, vec![1.0; 2]), (0.0, vec![1.0, f64::NAN, 0.0]), (f64::INFINITY, vec![1.0; 3])] {
        assert!(matches!(check_derivatives(&field, t, &v), Err(DerivativeError::Input(_))), "{t} {v:?}");
    }
    assert_eq!(
        check_derivatives(&AutoField::new(Ring(0)), 0.0, &[]),
        Err(DerivativeError::Input(InputError::System(SystemError::Empty)))
    );
}

/// Products by columns, for a matrix-free field on methods with matrices.
#[test]
fn columns_from_products_are_the_matrix() {
    let field = Flawed(AutoField::new(Ring(5)), Flaw::None, Structure::MatrixFree);
    let (mut by_columns, mut entries) = (Jacobian::zeros(5), Jacobian::zeros(5));
    add_columns(&field, 0.7, &state(5), 1.0, &mut by_columns);
    field.0.add_jacobian(0.7, &state(5), 1.0, &mut entries);
    assert!((by_columns.to_dense() - entries.to_dense()).amax() <= 1e-14);
}

#[test]
fn derivatives_say_what_they_are() {
    use lsvi::Derivative::{Assembled, Curvature, Jacobian, Transpose};
    let names = [Jacobian, Assembled, Transpose, Curvature].map(|of| of.to_string());
    assert_eq!(names, ["the Jacobian", "the assembled Jacobian", "the transposed product", "the curvature"]);
    assert_eq!(Derivative::Hessian(Variable::Q, Variable::V).to_string(), "∂²L/∂q∂v");
    assert_eq!(Derivative::MotionIn(Variable::A).to_string(), "∂E/∂a");
    assert_eq!(Place { row: Some(1), column: Some(2) }.to_string(), ", row 1, column 2");
    assert_eq!(Place { row: None, column: Some(2) }.to_string(), ", column 2");
}

/// v̇₀ = size · v₁, v̇₁ = size · v₀, with a statement that is wrong by a part of itself.
struct Slanted {
    size: f64,
    wrong: Derivative,
    part: f64,
}

impl Slanted {
    fn stated(&self, of: Derivative) -> f64 {
        self.size * if of == self.wrong { 1.0 + self.part } else { 1.0 }
    }
}

impl VectorField for Slanted {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.copy_from_slice(&[self.size * v[1], self.size * v[0]]);
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        let stated = scale * self.stated(Derivative::Assembled);
        out.add(0, 1, stated);
        out.add(1, 0, stated);
    }
    fn apply_jacobian(&self, t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
        self.rhs(t, x, out);
    }
    fn apply_transpose(&self, _t: f64, _v: &[f64], w: &[f64], out: &mut [f64]) {
        let stated = self.stated(Derivative::Transpose);
        out.copy_from_slice(&[stated * w[1], stated * w[0]]);
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], _w: &[f64], _scale: f64, _out: &mut Jacobian) {}
}

#[test]
fn statements_agree_in_nine_digits_whatever_their_size() {
    for wrong in [Derivative::Assembled, Derivative::Transpose] {
        for size in [1e-8, 1.0, 1e8] {
            let check = |part| check_derivatives(&Slanted { size, wrong, part }, 0.0, &[1.0, 0.5]);
            let error = check(1e-9).expect_err("wrong in the ninth digit");
            assert!(
                matches!(error, DerivativeError::Differs { of, .. } if of == wrong),
                "{wrong} of size {size:e}: {error}"
            );
            check(1e-11).expect("within rounding of long sums");
        }
    }
}

/// v̇ = A v with a transposed product that is wrong in one entry of A.
struct Slipped {
    row: usize,
    column: usize,
}

impl Slipped {
    const A: [[f64; 3]; 3] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 10.0]];
}

impl VectorField for Slipped {
    fn dim(&self) -> usize {
        3
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(Self::A).for_each(|(dv, row)| *dv = (0..3).map(|j| row[j] * v[j]).sum());
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        (0..9).for_each(|k| out.add(k / 3, k % 3, scale * Self::A[k / 3][k % 3]));
    }
    fn apply_transpose(&self, _t: f64, _v: &[f64], w: &[f64], out: &mut [f64]) {
        (0..3).for_each(|j| out[j] = (0..3).map(|i| Self::A[i][j] * w[i]).sum());
        out[self.column] += 0.5 * w[self.row];
    }
}

#[test]
fn every_entry_of_a_transposed_product_is_looked_at() {
    for (row, column) in (0..9).map(|k| (k / 3, k % 3)) {
        let error = check_derivatives(&Slipped { row, column }, 0.0, &[1.0, 0.5, -0.7]).expect_err("wrong");
        let DerivativeError::Differs { of: Derivative::Transpose, place, .. } = error else { panic!("{error}") };
        assert_eq!(place, Place { row: Some(row), column: Some(column) });
    }
}

#[test]
fn a_field_that_does_not_change_has_the_derivative_zero() {
    let field = Slanted { size: 0.0, wrong: Derivative::Transpose, part: 0.0 };
    check_derivatives(&field, 0.0, &[1.0, 0.5]).expect("nothing to disagree about");
}

/// v̇₀ = rate (v₀ − v₁), at rest where the two are equal, and off by so much together with the Jacobian.
struct Balanced {
    rate: f64,
    off: f64,
}

impl VectorField for Balanced {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.copy_from_slice(&[self.rate * (v[0] - v[1]), 0.0]);
    }
    fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, scale * self.rate);
        out.add(0, 1, -scale * self.rate);
    }
    fn linearize(&self, t: f64, v: &[f64], dv: &mut [f64], scale: f64, out: &mut Jacobian) {
        self.rhs(t, v, dv);
        dv[0] += self.off;
        self.add_jacobian(t, v, scale, out);
    }
}

#[test]
fn at_rest_f_is_known_to_a_part_of_its_terms() {
    for (rate, v) in [(1.0, 1.0), (1e4, 1e-4), (1e-4, 1e4), (1e4, 1e4)] {
        let terms = 2.0 * rate * v;
        let check = |part: f64| check_derivatives(&Balanced { rate, off: part * terms }, 0.0, &[v, v]);
        check(0.9e-10).unwrap_or_else(|error| panic!("{rate:e}, {v:e}: {error}"));
        let error = check(1.1e-10).expect_err("more than rounding");
        assert!(matches!(error, DerivativeError::Differs { of: Derivative::Rate, .. }), "{rate:e}, {v:e}: {error}");
    }
}

/// v̇ = size · v²/2 with entries of its curvature that are wrong by a part of themselves, beside a right product.
struct Bent {
    size: f64,
    part: f64,
}

impl VectorField for Bent {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = self.size * v[0] * v[0] / 2.0;
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, scale * self.size * v[0]);
    }
    fn apply_curvature(&self, _t: f64, _v: &[f64], w: &[f64], x: &[f64], out: &mut [f64]) {
        out[0] = self.size * w[0] * x[0];
    }
    fn add_curvature(&self, _t: f64, _v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, scale * self.size * w[0] * (1.0 + self.part));
    }
}

#[test]
fn entries_of_a_curvature_agree_with_its_products_in_one_digit_whatever_their_size() {
    for size in [1e-8, 1.0, 1e8] {
        let check = |part| check_derivatives(&Bent { size, part }, 0.0, &[0.7]);
        check(0.05).unwrap_or_else(|error| panic!("{size:e}: {error}"));
        let error = check(0.2).expect_err("another curvature");
        assert!(matches!(error, DerivativeError::Differs { of: Derivative::Curvature, .. }), "{size:e}: {error}");
    }
}

#[test]
fn up_to_thirty_two_unknowns_every_column_is_looked_at() {
    for (n, column) in [(32, Some(1)), (33, None)] {
        let error = check_derivatives(&Flawed(AutoField::new(Ring(n)), Flaw::Entry, Structure::Dense), 0.7, &state(n));
        let Err(DerivativeError::Differs { place, .. }) = error else { panic!("{n}: {error:?}") };
        assert_eq!(place.column, column, "{n} unknowns");
    }
}

/// The curvature of `field` for the weights w in the direction x, by [`lsvi::Differences`] of its Jacobian and, matrix-free, of
/// its transposed products.
fn by_differences(field: &impl VectorField, v: &[f64], w: &[f64], x: &[f64]) -> [Vec<f64>; 2] {
    let n = v.len();
    let mut curvature = Jacobian::zeros(n);
    lsvi::Differences::new(n, &Structure::Dense).add_curvature(field, 0.0, v, w, 1.0, &mut curvature);
    let assembled = (0..n).map(|i| (0..n).map(|j| curvature.get(i, j) * x[j]).sum()).collect();
    let mut products = vec![0.0; n];
    Products::new(field).apply_curvature(0.0, v, w, x, &mut products);
    [assembled, products]
}

#[test]
fn curvature_by_differences_is_right_at_every_scale_and_at_zero() {
    // ∂²/∂v² of (v₀², sin v₁ + 1000 v₁), for w = (3, 5), along x = (0.5, 2).
    let field = lsvi::field!(2, |_t, v, dv| {
        dv[0] = v[0] * v[0];
        dv[1] = v[1].sin() + v[1] * 1e3;
    });
    for v in [[0.0, 0.0], [1e3, 0.5], [0.3, 1e-6], [1e-6, 0.7]] {
        for scale in [1e-5, 1.0, 1e6] {
            let exact = [3.0 * scale, -10.0 * scale * f64::sin(v[1])];
            for found in by_differences(&field, &v, &[3.0, 5.0], &[0.5 * scale, 2.0 * scale]) {
                for (found, exact) in found.iter().zip(exact) {
                    // Rounding of 5000 over a distance of √ε times 1e-3 of the largest component, or of ε^⅓ of it, at 1.
                    assert!((found - exact).abs() < 1e-2 * scale, "{v:?}, {scale}: {found} {exact}");
                }
            }
        }
    }
    for found in by_differences(&field, &[0.3, 0.2], &[3.0, 5.0], &[0.0; 2]) {
        assert_eq!(found, [0.0; 2]);
    }
}

/// Monod's growth, v̇₀ = −v₁ v₀/(K + v₀), v̇₁ = −v̇₀, of a substrate that is scarce beside what grows on it; with a slip, one
/// derivative has K for 2K.
struct Monod {
    k: f64,
    is_right: bool,
}

impl VectorField for Monod {
    fn dim(&self) -> usize {
        2
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        let rate = v[1] * v[0] / (self.k + v[0]);
        dv.copy_from_slice(&[-rate, rate]);
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        let k = if self.is_right { self.k } else { 2.0 * self.k };
        let (substrate, biomass) = (v[1] * k / (self.k + v[0]).powi(2), v[0] / (self.k + v[0]));
        for (row, sign) in [(0, -scale), (1, scale)] {
            out.add(row, 0, sign * substrate);
            out.add(row, 1, sign * biomass);
        }
    }
    fn add_curvature(&self, _t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        let (sum, c) = (self.k + v[0], scale * (w[1] - w[0]));
        out.add(0, 0, c * -2.0 * v[1] * self.k / sum.powi(3));
        out.add(0, 1, c * self.k / sum.powi(2));
        out.add(1, 0, c * self.k / sum.powi(2));
    }
}

#[test]
fn components_may_have_units_of_their_own() {
    for k in [1e-8, 1e-6, 1e-4, 1e-2, 1.0, 1e3] {
        for part in [0.5, 2.0] {
            let v = [part * k, 10.0];
            check_derivatives(&Monod { k, is_right: true }, 0.0, &v)
                .unwrap_or_else(|error| panic!("K = {k:e}: {error}"));
            let error = check_derivatives(&Monod { k, is_right: false }, 0.0, &v).expect_err("a slip");
            let DerivativeError::Differs { of: Derivative::Jacobian, place, stated, found, .. } = error else {
                panic!("K = {k:e}: {error}")
            };
            assert_eq!(place, Place { row: Some(0), column: Some(0) });
            assert!((stated / found - 2.0).abs() < 1e-5, "K = {k:e}: {stated:e} for {found:e}");
        }
    }
    // A wave of a length far below the size of another component.
    for a in [1e-12, 1e-7, 1e-3, 1.0] {
        let field = field!(2, a = a; |t, v, dv| { dv[0] = v[1] * a; dv[1] = -(v[0] * (1.0 / a)).sin() * a + t.cos(); });
        check_derivatives(&field, 0.3, &[0.7 * a, 0.2]).unwrap_or_else(|error| panic!("a = {a:e}: {error}"));
    }
}

/// At rest and beside it a curvature by differences of J has few digits, or none.
#[test]
fn a_curvature_that_nobody_states_is_no_mistake() {
    struct Pendulum;
    impl VectorField for Pendulum {
        fn dim(&self) -> usize {
            2
        }
        fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
            dv.copy_from_slice(&[v[1], -v[0].sin()]);
        }
        fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(0, 1, scale);
            out.add(1, 0, -scale * v[0].cos());
        }
    }
    for v in [[0.0, 0.0], [1e-8, 0.0], [1e-4, 0.0], [1e-2, 0.0], [0.5, 1e-9], [1.0, 0.5], [3.0, 1e3]] {
        check_derivatives(&Pendulum, 0.0, &v).unwrap_or_else(|error| panic!("{v:?}: {error}"));
    }
}

/// v̇_i = 100 size v_i + v_i²/2 with a factor of its second derivatives, or with differences in their place: where v_i is zero J rounds by
/// a part of 10⁻³ of what it changes by over √ε of a thousandth of `size`.
struct Steep {
    n: usize,
    size: f64,
    factor: Option<f64>,
}

impl VectorField for Steep {
    fn dim(&self) -> usize {
        self.n
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = (100.0 * self.size + 0.5 * v) * v);
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        v.iter().enumerate().for_each(|(i, v)| out.add(i, i, scale * (100.0 * self.size + v)));
    }
    fn add_curvature(&self, t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        match self.factor {
            Some(factor) => w.iter().enumerate().for_each(|(i, w)| out.add(i, i, scale * factor * w)),
            None => lsvi::Differences::new(self.n, &Structure::Dense).add_curvature(self, t, v, w, scale, out),
        }
    }
}

#[test]
fn what_a_curvature_may_differ_by_is_the_rounding_of_differences_in_every_unit() {
    for (n, size, is_at_rest) in [2, 40].into_iter().flat_map(|n| {
        [(n, 1e-6, false), (n, 1e-3, false), (n, 1.0, false), (n, 1e3, false), (n, 1e6, false), (n, 1.0, true)]
    }) {
        let v: Vec<f64> = (0..n).map(|i| if is_at_rest || i % 2 == 1 { 0.0 } else { size }).collect();
        let check = |factor| check_derivatives(&Steep { n, size, factor }, 0.0, &v);
        let case = format!("{n} unknowns of {size:e}, at rest: {is_at_rest}");
        for factor in [None, Some(1.0)] {
            check(factor).unwrap_or_else(|error| panic!("{case}, {factor:?}: {error}"));
        }
        let error = check(Some(1.1)).expect_err(&case);
        assert!(matches!(error, DerivativeError::Differs { of: Derivative::Curvature, .. }), "{case}: {error}");
    }
}

/// v̇_i = v_i³ with a wrong second derivative of one component.
struct Cubes(usize);

impl VectorField for Cubes {
    fn dim(&self) -> usize {
        3
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = v.powi(3));
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        v.iter().enumerate().for_each(|(i, v)| out.add(i, i, scale * 3.0 * v * v));
    }
    fn add_curvature(&self, _t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        for (i, (v, w)) in v.iter().zip(w).enumerate() {
            let factor = if i == self.0 { 6.6 } else { 6.0 };
            out.add(i, i, scale * w * factor * v);
        }
    }
}

#[test]
fn a_curvature_is_held_to_differences_in_every_direction() {
    for i in 0..3 {
        let error = check_derivatives(&Cubes(i), 0.0, &[0.5, 0.7, 0.9]).expect_err("a wrong factor");
        let DerivativeError::Differs { of: Derivative::Curvature, place, .. } = error else { panic!("{error}") };
        assert_eq!(place, Place { row: Some(i), column: Some(i) });
    }
}

/// Few unknowns have a way of their own into a dense matrix; into another one their entries go by one.
#[test]
fn a_linearisation_goes_into_a_matrix_of_any_structure() {
    let field = lsvi::field!(2, |t, v, dv| {
        dv[0] = v[0] * v[1] * 3.0;
        dv[1] = v[1] * v[1];
    });
    for structure in [Structure::Dense, Structure::Banded { lower: 1, upper: 1 }] {
        let (mut f, mut matrix) = ([0.0; 2], Jacobian::with_structure(2, &structure));
        field.linearize(0.0, &[5.0, 7.0], &mut f, -2.0, &mut matrix);
        assert_eq!(f, [105.0, 49.0]);
        assert_eq!(matrix.to_dense().as_slice(), [-42.0, 0.0, -30.0, -28.0], "{structure:?}");
    }
}

/// Switches at 300 K, over millikelvins and tenths, and a wave of 6e-6 of the state: right and, by a tenth, wrong.
#[test]
fn what_turns_within_a_small_part_of_the_state_is_judged_there() {
    let near = |f: fn(f64) -> f64, slope: fn(f64) -> f64, curve: fn(f64) -> f64, v: f64| {
        let check = |part: f64| check_derivatives(&Turning { f, slope, curve, part }, 0.0, &[v]);
        assert_eq!(check(1.0), Ok(()), "at {v}");
        let wrong = check(1.1);
        assert!(matches!(wrong, Err(DerivativeError::Differs { of: Derivative::Jacobian, .. })), "at {v}: {wrong:?}");
    };
    near(
        |v| ((v - 300.0) * 1e3).tanh(),
        |v| 1e3 / ((v - 300.0) * 1e3).cosh().powi(2),
        |v| -2e6 * ((v - 300.0) * 1e3).tanh() / ((v - 300.0) * 1e3).cosh().powi(2),
        300.0,
    );
    near(
        |v| ((v - 300.0) * 10.0).tanh(),
        |v| 10.0 / ((v - 300.0) * 10.0).cosh().powi(2),
        |v| -200.0 * ((v - 300.0) * 10.0).tanh() / ((v - 300.0) * 10.0).cosh().powi(2),
        300.1,
    );
    near(|v| (1e6 * v).sin(), |v| 1e6 * (1e6 * v).cos(), |v| -1e12 * (1e6 * v).sin(), 1.0);
}

struct Turning {
    f: fn(f64) -> f64,
    slope: fn(f64) -> f64,
    curve: fn(f64) -> f64,
    part: f64,
}
impl VectorField for Turning {
    fn dim(&self) -> usize {
        1
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv[0] = (self.f)(v[0]);
    }
    fn add_jacobian(&self, _t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, scale * self.part * (self.slope)(v[0]));
    }
    fn add_curvature(&self, _t: f64, v: &[f64], w: &[f64], scale: f64, out: &mut Jacobian) {
        out.add(0, 0, scale * w[0] * self.part * (self.curve)(v[0]));
    }
}
