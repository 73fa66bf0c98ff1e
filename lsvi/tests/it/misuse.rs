//! What is refused: input that fits nothing, declarations that are false, numbers that are none. Nothing panics.

use crate::fields::Unscaled;
use crate::systems::{field_of, lagrangian_of};
use lsvi::adaptive::{Options, Radau, Tolerances};
use lsvi::classic::{Bdf2, CoupledRungeKutta, RungeKutta, Tableau};
use lsvi::closure::Linear;
use lsvi::discrete::{Galerkin, Midpoint, Trapezoidal};
use lsvi::quadrature::Quadrature;
use lsvi::solver::{Augmented, Iterative, StepSolver, Twisted};
use lsvi::{
    AutoConstraint, AutoField, Coloring, Constrained, ConstraintFn, Differences, Factored, FieldFn, Grid, InputError,
    Integrator, Jacobian, LagrangianFn, LeastSquares, LeastSquaresStep, Mass, NodeError, OneStep, Preconditioner,
    Scalar, SettingError, SolveError, State, StepError, StepOperator, Structure, SystemError, TimeError, Trajectory,
    TwoStep, VectorField, Window, add_columns, least_squares, method_i, method_ii, nalgebra, position_momentum, steady,
};

/// v̇ = −v in two unknowns, with a structure and declarations as they may be wrong.
#[derive(Debug, Clone)]
struct Decay {
    structure: Structure,
    linear: bool,
    autonomous: bool,
    /// A term −v³, and one of t.
    cubic: f64,
    forced: f64,
}

impl Default for Decay {
    fn default() -> Self {
        Self { structure: Structure::Dense, linear: false, autonomous: false, cubic: 0.0, forced: 0.0 }
    }
}

impl FieldFn for Decay {
    fn dim(&self) -> usize {
        2
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn is_linear(&self) -> bool {
        self.linear
    }
    fn is_autonomous(&self) -> bool {
        self.autonomous
    }
    fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
        for (dv, &v) in dv.iter_mut().zip(v) {
            *dv = -v - v * v * v * self.cubic + self.forced * t;
        }
    }
}

/// v̇ = −v by products alone.
#[derive(Debug)]
struct MatrixFree;

impl VectorField for MatrixFree {
    fn dim(&self) -> usize {
        2
    }
    fn structure(&self) -> Structure {
        Structure::MatrixFree
    }
    fn rhs(&self, _t: f64, v: &[f64], dv: &mut [f64]) {
        dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -v);
    }
    fn add_jacobian(&self, t: f64, v: &[f64], scale: f64, out: &mut Jacobian) {
        add_columns(self, t, v, scale, out);
    }
    fn apply_jacobian(&self, _t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
        out.iter_mut().zip(x).for_each(|(out, x)| *out = -x);
    }
    fn apply_transpose(&self, t: f64, v: &[f64], x: &[f64], out: &mut [f64]) {
        self.apply_jacobian(t, v, x, out);
    }
}

fn band() -> Structure {
    Structure::Banded { lower: 0, upper: 0 }
}

fn is_dimension(error: &InputError) -> bool {
    matches!(error, InputError::System(SystemError::Dimension { .. }))
}

#[test]
fn products_with_vectors_of_another_length_are_refused() {
    let matrix = Jacobian::zeros(2);
    let masses = [Mass::Diagonal(vec![1.0; 2]), Mass::Matrix(matrix.clone())];
    for (x, out) in [(1, 2), (3, 2), (2, 1), (2, 3), (0, 0)] {
        let x = vec![1.0; x];
        let refused = |error: Result<(), InputError>| assert!(error.is_err_and(|e| is_dimension(&e)), "{x:?} {out}");
        refused(matrix.apply(&x, &mut vec![0.0; out]));
        refused(matrix.apply_transpose(&x, &mut vec![0.0; out]));
        masses.iter().for_each(|mass| refused(mass.apply(&x, &mut vec![0.0; out])));
    }
    assert!(Mass::Identity.apply(&[1.0], &mut []).is_err_and(|e| is_dimension(&e)));
    let mut out = [0.0; 2];
    masses[0].apply(&[1.0, 2.0], &mut out).expect("two of two");
    assert_eq!(out, [1.0, 2.0]);
    assert!(Jacobian::try_from(nalgebra::DMatrix::zeros(2, 3)).is_err_and(|e| is_dimension(&e)));
}

#[test]
fn products_of_a_step_with_vectors_of_another_length_fail_the_step() {
    /// Multiplies with a vector that is too long.
    struct Clumsy;
    impl Preconditioner for Clumsy {
        fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
            Ok(b.apply(&[1.0; 3], &mut [0.0; 3])?)
        }
        fn solve(&mut self, _x: &mut [f64]) {}
        fn solve_transpose(&mut self, _x: &mut [f64]) {}
    }
    let mut method = LeastSquaresStep::with_solver(MatrixFree, Linear::METHOD_I, Iterative::new(Clumsy)).expect("fits");
    let error = method.step(0.0, 0.1, &mut [1.0; 2], &mut [0.0; 2]).expect_err("3 is not 2");
    let StepError::Solve { source: SolveError::Input(source), .. } = &error else { panic!("{error}") };
    assert!(is_dimension(source), "{error}");
}

#[test]
fn derivatives_at_points_of_another_length_are_not_finite() {
    let field = field_of(Decay::default());
    for n in [0, 1, 3] {
        let v = vec![1.0; n];
        let mut out = vec![0.0; 2];
        field.apply_transpose(0.0, &v, &[1.0; 2], &mut out);
        assert!(out[0].is_nan());
        field.apply_curvature(0.0, &[1.0; 2], &v, &[1.0; 2], &mut out);
        assert!(out[0].is_nan());
        let mut matrix = Jacobian::zeros(2);
        Differences::new(2, &Structure::Dense).add_curvature(&field, 0.0, &v, &[1.0; 2], 1.0, &mut matrix);
        assert!(matrix.get(0, 0).is_nan());
        let mut matrix = Jacobian::zeros(2);
        Differences::new(2, &Structure::Dense).add_curvature(&field, 0.0, &[1.0; 2], &v, 1.0, &mut matrix);
        assert!(matrix.get(0, 0).is_nan());
    }
}

#[test]
fn a_mass_without_positive_entries_is_no_metric() {
    struct Massive(f64);
    impl FieldFn for Massive {
        fn dim(&self) -> usize {
            2
        }
        fn mass(&self) -> Mass {
            Mass::Diagonal(vec![1.0, self.0])
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv.iter_mut().zip(v).for_each(|(dv, &v)| *dv = -v);
        }
    }
    for mass in [0.0, -1.0] {
        let error = method_i(field_of(Massive(mass))).err();
        let what = format!("entry (1, 1) is {mass}");
        assert_eq!(error, Some(InputError::System(SystemError::Metric(what))));
    }
}

#[test]
fn tolerances_are_not_tightened_below_what_arithmetic_resolves() {
    let tolerances = Tolerances::new(1e-3, 1e-6).expect("usable");
    assert_eq!(tolerances.tightened(10.0), Tolerances::new(1e-3 / 10.0, 1e-6 / 10.0).expect("usable"));
    let of_each =
        |atol: [f64; 2]| Tolerances::new(1e-3, 0.0).and_then(|it| it.with_atol(atol.to_vec())).expect("usable");
    assert_eq!(of_each([1e-3, 1e-6]).tightened(10.0).atol(), [1e-3 / 10.0, 1e-6 / 10.0]);
    let tight = tolerances.tightened(1e18);
    assert_eq!((tight.rtol(), tight.atol()), (Tolerances::LEAST_RTOL, &[1e-6 / 1e18][..]));
    for nothing in [0.5, 0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        assert_eq!(tolerances.tightened(nothing), tolerances, "{nothing}");
    }
}

#[test]
fn groups_that_do_not_exist_are_empty() {
    for structure in [Structure::Dense, band(), Structure::MatrixFree] {
        let coloring = Coloring::new(2, &structure);
        for c in [coloring.groups(), usize::MAX] {
            assert_eq!((coloring.columns(c).count(), coloring.entries(c).count(), coloring.column(c, 0)), (0, 0, None));
        }
        assert!([2, usize::MAX].iter().all(|&i| coloring.column(0, i).is_none()));
    }
    assert_eq!(Coloring::new(0, &Structure::Dense).groups(), 0);
}

#[test]
fn rates_are_not_written_into_a_slice_of_another_length() {
    let state = State::new(0.0, vec![1.0, 2.0]);
    let mut first = method_i(field_of(Decay::default())).expect("usable");
    let oscillator = lagrangian_of(Oscillator);
    let mut mechanics = position_momentum(Trapezoidal::new(&oscillator));
    let one = State::new(0.0, vec![1.0]);
    for mut out in [vec![], vec![0.0; 3]] {
        let refused = |error| matches!(error, Err(StepError::Input(input)) if is_dimension(&input));
        assert!(refused(first.rate(&state, &mut out)) && refused(mechanics.rate(&one, &mut out)));
    }
}

#[test]
fn a_sparsity_pattern_of_another_order_is_refused() {
    let field = || field_of(Decay { structure: Structure::sparse(3, [(0, 1)]).expect("inside"), ..Decay::default() });
    let expected = InputError::System(SystemError::Pattern { expected: 2, found: 3 });
    let tableau = Tableau::implicit_euler;
    let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
    let iterative = || Iterative::new(Factored::default());
    let refused = [
        method_i(field()).err(),
        method_ii(field()).err(),
        LeastSquaresStep::with_solver(field(), Linear::METHOD_I, Augmented::new()).err(),
        LeastSquares::new(field()).err(),
        RungeKutta::new(field(), tableau()).err(),
        RungeKutta::with_solver(field(), tableau(), iterative()).err(),
        Bdf2::new(field()).err(),
        Bdf2::with_solver(field(), iterative).err(),
        CoupledRungeKutta::new(field(), &[vec![1.0]], &[1.0], &[1.0]).err(),
        Radau::new(field(), tolerances).err(),
    ];
    for (i, error) in refused.into_iter().enumerate() {
        assert_eq!(error, Some(expected.clone()), "{i}");
    }
    let error = steady::check(&field(), 0.0, &[1.0; 2], 1.0).expect_err("another order");
    assert_eq!(error, steady::SteadyError::Input(expected.clone()));
    assert!(expected.to_string().contains("order 3") && expected.to_string().contains("2 unknowns"), "{expected}");
}

#[test]
fn a_shortest_step_above_the_longest_is_refused() {
    let options = || Options::new(Tolerances::new(1e-6, 1e-6).expect("positive"));
    let expected = Some(InputError::Setting(SettingError::StepBounds { h_min: 0.2, h_max: 0.1 }));
    assert_eq!(options().h_max(0.1).and_then(|o| o.h_min(0.2)).err(), expected);
    assert_eq!(options().h_min(0.2).and_then(|o| o.h_max(0.1)).err(), expected);
    assert!(options().h_min(0.1).and_then(|o| o.h_max(0.1)).is_ok());
}

#[test]
fn settings_that_are_none_are_told_as_settings() {
    let tolerances = || Tolerances::new(1e-6, 1e-6).expect("positive");
    let steps = Options::new(tolerances()).max_steps(0).expect_err("none");
    assert!(matches!(steps, InputError::Setting(SettingError::Setting { what: "max_steps", .. })), "{steps}");
    let atol = tolerances().with_atol(vec![]).expect_err("none");
    assert!(matches!(atol, InputError::System(SystemError::Dimension { what: "atol", found: 0, .. })), "{atol}");
    let field = field_of(Decay::default());
    let window =
        Window::new(Trapezoidal::new(LeastSquares::new(field).expect("usable")), 0).map(|_| ()).expect_err("none");
    assert!(matches!(window, InputError::Setting(SettingError::Setting { value: 0.0, .. })), "{window}");
}

#[test]
fn quadratures_that_integrate_no_constant_or_have_a_node_twice_are_refused() {
    let rule = |nodes: &[f64], weights: &[f64]| Quadrature::new(nodes.to_vec(), weights.to_vec());
    let twice = rule(&[0.5, 0.2, 0.5], &[0.25, 0.5, 0.25]).expect_err("twice");
    assert!(matches!(twice, InputError::Nodes(NodeError::CoincidentNodes { first: 0, second: 2, .. })), "{twice}");
    for sum in [0.0, 0.5, 2.0, 1.0 + 1e-6] {
        let error = rule(&[0.0, 1.0], &[0.5 * sum, 0.5 * sum]).expect_err("another sum");
        assert!(matches!(error, InputError::Nodes(NodeError::WeightSum { .. })), "{error}");
    }
    // Gauss's weights with three nodes, 5/18, 8/18 and 5/18, to seven digits; their signs may differ.
    assert!(rule(&[0.1, 0.5, 0.9], &[0.2777778, 0.4444444, 0.2777778]).is_ok());
    assert!(rule(&[0.1, 0.5, 0.9], &[1e3, -1999.0, 1e3]).is_ok());
    assert!(Quadrature::inconsistent(vec![0.5, 0.5], vec![1.0, 1.0]).is_ok());
}

#[test]
fn tableaux_whose_weights_do_not_sum_to_one_are_refused() {
    let refused = |error: InputError| matches!(error, InputError::Nodes(NodeError::WeightSum { sum: 0.0 }));
    assert!(refused(Tableau::lower_triangular(&[vec![0.0]], &[0.0], &[0.0]).expect_err("no step")));
    let field = field_of(Decay::default());
    assert!(refused(CoupledRungeKutta::new(&field, &[vec![1.0]], &[0.0], &[1.0]).map(|_| ()).expect_err("no step")));
    assert!(Tableau::inconsistent(&[vec![0.0]], &[0.0], &[0.0]).is_ok());
    assert!(CoupledRungeKutta::inconsistent(&field, &[vec![1.0]], &[0.0], &[1.0]).is_ok());
}

/// What a step with these declarations of (v, h) = (1, 0.1) says.
fn first_step(field: Decay, closure: Linear) -> Result<(), SolveError> {
    let mut method = least_squares(field_of(field), closure).expect("usable");
    match method.step(0.0, 0.1, &mut [1.0; 2], &mut [0.0; 2]) {
        Err(StepError::Solve { source, .. }) => Err(source),
        Err(other) => panic!("{other}"),
        Ok(()) => Ok(()),
    }
}

#[test]
fn false_declarations_are_found_in_fields_of_every_structure() {
    let sparse = Structure::sparse(2, []).expect("inside");
    for structure in [Structure::Dense, band(), sparse] {
        for closure in [Linear::METHOD_I, Linear::METHOD_II] {
            let field = Decay { structure: structure.clone(), linear: true, ..Decay::default() };
            assert_eq!(first_step(field.clone(), closure), Ok(()));
        }
        for closure in [Linear::METHOD_I, Linear::METHOD_II] {
            let field = Decay { structure: structure.clone(), linear: true, cubic: 1.0, ..Decay::default() };
            let error = first_step(field, closure);
            // f is −2 where −v is −1.
            assert_eq!(error, Err(SolveError::NotLinear { row: 0, difference: -1.0 }), "{structure:?}");
        }
        for (linear, cubic) in [(true, 0.0), (false, 1.0)] {
            let structure = structure.clone();
            let field = Decay { structure, linear, cubic, autonomous: true, forced: 1.0 };
            let error = first_step(field.clone(), Linear::METHOD_I);
            let Err(SolveError::NotAutonomous { row: 0, difference }) = error else { panic!("{field:?}: {error:?}") };
            assert!((difference - 0.1).abs() < 1e-15, "{difference}");
            assert_eq!(first_step(Decay { forced: 0.0, ..field }, Linear::METHOD_I), Ok(()));
        }
    }
}

#[test]
fn a_false_declaration_is_found_again_with_another_step_size() {
    /// v̇ = −v for v ≤ 1 and −v² beyond, declared linear.
    struct Half;
    impl FieldFn for Half {
        fn dim(&self) -> usize {
            1
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = if v[0].re() <= 1.0 { -v[0] } else { -v[0] * v[0] };
        }
    }
    let mut method = method_i(field_of(Half)).expect("usable");
    method.step(0.0, 0.1, &mut [0.5], &mut [0.0]).expect("linear there");
    let error = method.step(0.0, 0.2, &mut [2.0], &mut [0.0]).expect_err("not linear there");
    assert!(matches!(error, StepError::Solve { source: SolveError::NotLinear { .. }, .. }), "{error}");
}

/// Between two looks at the whole declaration, which are in the first and the third step, sums of all rows are compared to ten digits.
#[test]
fn a_term_that_is_not_linear_and_begins_between_two_looks_is_found_at_the_end_of_its_step() {
    struct Late;
    impl FieldFn for Late {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            Structure::Banded { lower: 0, upper: 0 }
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
            let part = if t > 0.15 { 1e-8 } else { 0.0 };
            dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -*v - *v * *v * part);
        }
    }
    let mut method = method_i(field_of(Late)).expect("usable");
    let (mut v, mut p) = ([1.0, 0.5], [0.0; 2]);
    method.step(0.0, 0.1, &mut v, &mut p).expect("linear until then");
    let error = method.step(0.1, 0.1, &mut v, &mut p).expect_err("not linear any more");
    assert!(matches!(error, StepError::Solve { source: SolveError::NotLinear { .. }, .. }), "{error}");
}

/// M v̇ = F(v) with M = (1 1; 1 m) and F = (−x − y, −x − 2y), solved for v̇; e^(−t) (1, 0) is a solution.
struct Solved {
    m: f64,
}
impl FieldFn for Solved {
    fn dim(&self) -> usize {
        2
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        let (first, second) = (-v[0] - v[1], -v[0] - v[1] * 2.0);
        dv[1] = (second - first) / (self.m - 1.0);
        dv[0] = first - dv[1];
    }
}

/// On the solution ẏ = −y/(m − 1) is the difference of two rates that are far larger, and their roundings are more than itself.
#[test]
fn a_linear_field_whose_terms_cancel_is_what_it_declares() {
    fn end(method: impl Integrator, h: f64) -> Vec<f64> {
        let run = Trajectory::new(method, State::new(0.0, vec![1.0, 0.0]), h, 2.0).expect("valid");
        run.observe(|_| {}).expect("linear").q
    }
    for m in [1.1, 1.0001] {
        for h in [0.1, 1e-3] {
            let field = || field_of(Solved { m });
            for end in [end(method_i(field()).expect("usable"), h), end(method_ii(field()).expect("usable"), h)] {
                // In steps that are long beside m − 1, the time scale of y, Method I is of first order in x, which y couples to.
                assert!((end[0] - (-2_f64).exp()).abs() < 0.2 * h, "m = {m}, h = {h}: {end:?}");
            }
        }
    }
}

/// What is small beside another component may be all that there is of its own.
#[test]
fn a_false_declaration_is_found_in_a_component_far_smaller_than_another() {
    /// ẋ = −x, ẏ = −y − 10²⁰ y² or, for y < 0, −2y, declared linear.
    struct Small {
        is_kinked: bool,
    }
    impl FieldFn for Small {
        fn dim(&self) -> usize {
            2
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = -v[0];
            dv[1] = match self.is_kinked {
                true => v[1] * if v[1].re() < 0.0 { -2.0 } else { -1.0 },
                false => -v[1] - v[1] * v[1] * 1e20,
            };
        }
    }
    for (is_kinked, y) in [(false, 1e-20), (false, -1e-20), (true, -1e-20)] {
        let mut method = method_i(field_of(Small { is_kinked })).expect("usable");
        let error = method.step(0.0, 0.1, &mut [1.0, y], &mut [0.0; 2]).expect_err("not linear");
        assert!(
            matches!(error, StepError::Solve { source: SolveError::NotLinear { row: 1, .. }, .. }),
            "{is_kinked}, {y}: {error}"
        );
    }
}

/// v̇ = −50 ((v + 1) − 1) decays to the roundings of the 1, which are no terms of higher order and no end of a branch: ε a stage, of which
/// less than twice as much stays.
#[test]
fn terms_of_a_linear_field_that_cancel_leave_roundings_and_no_failure() {
    struct Cancels;
    impl FieldFn for Cancels {
        fn dim(&self) -> usize {
            1
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = ((v[0] + 1.0) - 1.0) * -50.0;
        }
    }
    let implicit = |tableau| RungeKutta::new(field_of(Cancels), tableau).expect("usable");
    let methods: [Box<dyn OneStep>; 4] = [
        Box::new(method_i(field_of(Cancels)).expect("usable")),
        Box::new(implicit(Tableau::implicit_euler())),
        Box::new(implicit(Tableau::tr_bdf2())),
        Box::new(implicit(Tableau::sdirk2())),
    ];
    for mut method in methods {
        let (mut v, mut p) = ([1.0], [0.0]);
        for k in 0..100 {
            let stepped = method.step(0.1 * f64::from(k), 0.1, &mut v, &mut p);
            assert!(stepped.is_ok(), "step {k}: {stepped:?}");
        }
        assert!(v[0].abs() <= 2.0 * f64::EPSILON, "{v:?}");
    }
}

/// v̇ = −k v + cos t with k = 1 and from `switch` on 2, declared linear; where it is declared autonomous too, v̇ = v, and 2v − 2
/// beyond v = 2.
struct Later {
    structure: Structure,
    switch: f64,
    autonomous: bool,
}

impl Later {
    fn rate(&self, t: f64) -> f64 {
        if self.autonomous {
            1.0
        } else if t < self.switch {
            -1.0
        } else {
            -2.0
        }
    }
}

impl VectorField for Later {
    fn dim(&self) -> usize {
        3
    }
    fn structure(&self) -> Structure {
        self.structure.clone()
    }
    fn is_linear(&self) -> bool {
        true
    }
    fn is_autonomous(&self) -> bool {
        self.autonomous
    }
    fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
        let source = if self.autonomous { 0.0 } else { t.cos() };
        for (dv, v) in dv.iter_mut().zip(v) {
            let beyond = if self.autonomous { (v - 2.0).max(0.0) } else { 0.0 };
            *dv = self.rate(t) * v + source + beyond;
        }
    }
    fn add_jacobian(&self, t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
        (0..3).for_each(|i| out.add(i, i, scale * self.rate(t)));
    }
    fn apply_jacobian(&self, t: f64, _v: &[f64], x: &[f64], out: &mut [f64]) {
        out.iter_mut().zip(x).for_each(|(out, x)| *out = self.rate(t) * x);
    }
    fn apply_transpose(&self, t: f64, v: &[f64], w: &[f64], out: &mut [f64]) {
        self.apply_jacobian(t, v, w, out);
    }
}

/// Steps keep the factors of the first A; a later A, or none, is refused in the step that ends with it, and again when that step
/// is repeated.
#[test]
fn a_field_that_is_no_longer_what_it_declared_is_refused() {
    let sparse = Structure::sparse(3, []).expect("inside");
    for structure in [band(), sparse, Structure::MatrixFree] {
        let field = |switch, autonomous| Later { structure: structure.clone(), switch, autonomous };
        let method = |field| match structure {
            Structure::MatrixFree => {
                LeastSquaresStep::with_solver(field, Linear::METHOD_I, Iterative::new(Unscaled)).expect("usable")
            }
            _ => method_i(field).expect("usable"),
        };
        // Between the ends of steps, and at one.
        for switch in [5.03, 5.0] {
            let (mut method, mut v, mut p) = (method(field(switch, false)), [1.0; 3], [0.0; 3]);
            let refused = (0..60).filter(|&k| match method.step(f64::from(k) / 10.0, 0.1, &mut v, &mut p) {
                Ok(()) => false,
                Err(StepError::Solve { source: SolveError::NotLinear { .. }, .. }) => true,
                Err(other) => panic!("{structure:?}: {other}"),
            });
            let later = (0..60).filter(|&k| f64::from(k + 1) / 10.0 >= switch);
            // A field without a matrix has no factors that its later steps would use.
            let steps = if structure == Structure::MatrixFree { 1 } else { 60 };
            assert_eq!(refused.collect::<Vec<_>>(), later.take(steps).collect::<Vec<_>>(), "{structure:?}, {switch}");
        }
        // 0.01 e^t passes 2 in the step that begins at t = 5.29; in a band one step in 256 is looked at.
        let (mut method, mut v, mut p) = (method(field(0.0, true)), [0.01; 3], [0.0; 3]);
        let failed = (0..1000).find(|&k| method.step(0.01 * f64::from(k), 0.01, &mut v, &mut p).is_err());
        assert!(failed.is_some_and(|step| (529..529 + 256).contains(&step)), "{structure:?}: {failed:?}");
    }
}

/// The first steps of a size are looked at often, whatever steps of another size there were before.
#[test]
fn a_field_is_compared_soon_after_the_step_size_has_changed() {
    let mut method = method_i(Later { structure: band(), switch: 0.0, autonomous: true }).expect("usable");
    let (mut v, mut p) = ([1e-6; 3], [0.0; 3]);
    (0..600).for_each(|k| method.step(0.01 * f64::from(k), 0.01, &mut v, &mut p).expect("linear there"));
    // It passes 2 in the third step.
    v = [1.9; 3];
    let failed = (0..1000).find(|&k| method.step(6.0 + 0.02 * f64::from(k), 0.02, &mut v, &mut p).is_err());
    assert!(failed.is_some_and(|step| step <= 7), "{failed:?}");
}

/// A value that is not finite at the end of a step alone.
#[test]
fn a_linear_field_that_ends_within_a_step_is_refused() {
    struct Ends(Structure);
    impl VectorField for Ends {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            self.0.clone()
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv.iter_mut()
                .zip(v)
                .for_each(|(dv, v)| *dv = if t > 0.0 && *v != 0.0 && *v != 1.0 { f64::NAN } else { -v });
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            (0..2).for_each(|i| out.add(i, i, -scale));
        }
    }
    for structure in [band(), Structure::sparse(2, []).expect("inside")] {
        let end = method_i(Ends(structure)).expect("usable").step(0.0, 0.1, &mut [1.0; 2], &mut [0.0; 2]);
        let error = end.expect_err("it ends");
        assert!(matches!(error, StepError::Solve { source: SolveError::NonFinite, .. }), "{error}");
    }
}

/// However slowly it goes.
#[test]
fn a_slow_drift_is_no_autonomous_field() {
    struct Drifts;
    impl VectorField for Drifts {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            Structure::Banded { lower: 1, upper: 1 }
        }
        fn is_linear(&self) -> bool {
            true
        }
        fn is_autonomous(&self) -> bool {
            true
        }
        fn rhs(&self, t: f64, v: &[f64], dv: &mut [f64]) {
            dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = 1.0 - v + 1e-12 * t);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            (0..2).for_each(|i| out.add(i, i, -scale));
        }
    }
    let error = method_i(Drifts).expect("usable").step(0.0, 0.1, &mut [0.5; 2], &mut [0.0; 2]).expect_err("it drifts");
    assert!(matches!(error, StepError::Solve { source: SolveError::NotAutonomous { .. }, .. }), "{error}");
}

/// What is added to every step was evaluated in the first one: a load that is switched on between two looks is found by the next.
#[test]
fn a_load_that_is_switched_on_between_two_looks_is_no_autonomous_field() {
    struct Switched {
        linear: bool,
    }
    impl FieldFn for Switched {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            Structure::Banded { lower: 0, upper: 0 }
        }
        fn is_linear(&self) -> bool {
            self.linear
        }
        fn is_autonomous(&self) -> bool {
            true
        }
        fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
            let load = if t > 0.705 { 1.0 } else { 0.0 };
            dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -*v + load);
        }
    }
    for linear in [true, false] {
        let method = method_i(field_of(Switched { linear })).expect("usable");
        let run = Trajectory::new(method, State::new(0.0, vec![1.0; 2]), 0.01, 4.0).expect("valid");
        let error = run.observe(|_| {}).expect_err("a false declaration");
        assert!(
            matches!(error, StepError::Solve { source: SolveError::NotAutonomous { .. }, .. }),
            "{linear}: {error}"
        );
    }
}

/// In a field that depends on time a declaration is compared at both ends of the step, and at the state itself: at v = 0, or
/// at the start alone, neither is seen.
#[test]
fn a_dependence_on_time_is_no_linear_and_no_autonomous_field() {
    struct Growing {
        linear: bool,
    }
    impl FieldFn for Growing {
        fn dim(&self) -> usize {
            1
        }
        fn is_linear(&self) -> bool {
            self.linear
        }
        fn is_autonomous(&self) -> bool {
            !self.linear
        }
        fn rhs<T: Scalar>(&self, t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = -v[0] * (1.0 + t);
        }
    }
    let first = |linear| {
        let mut method = method_i(field_of(Growing { linear })).expect("usable");
        method.step(0.0, 0.1, &mut [1.0], &mut [0.0]).expect_err("a false declaration")
    };
    let [linear, autonomous] = [true, false].map(first);
    assert!(matches!(linear, StepError::Solve { source: SolveError::NotLinear { .. }, .. }), "{linear}");
    assert!(matches!(autonomous, StepError::Solve { source: SolveError::NotAutonomous { .. }, .. }), "{autonomous}");
}

#[test]
fn messages_put_each_number_in_its_place() {
    let bounds = SettingError::StepBounds { h_min: 0.2, h_max: 0.1 }.to_string();
    assert!(bounds.contains("h_min = 0.2") && bounds.contains("h_max = 0.1"), "{bounds}");
    let few = NodeError::TooFew { what: "stages", least: 2, found: 1 }.to_string();
    assert_eq!(few, "stages: 1 is fewer than 2");
    let mass = Mass::Diagonal(vec![1.0, 2.0]);
    let apply = |x: &[f64], out: &mut [f64]| match mass.apply(x, out) {
        Err(InputError::System(SystemError::Dimension { what, found, .. })) => (what, found),
        other => panic!("{other:?}"),
    };
    assert_eq!(apply(&[1.0], &mut [0.0; 2]), ("x", 1));
    assert_eq!(apply(&[1.0; 2], &mut [0.0; 3]), ("out", 3));
}

#[test]
fn no_steps_are_no_march() {
    let field = || field_of(Decay::default());
    let (method, start) = (method_i(field()).expect("usable"), State::new(0.0, vec![1.0; 2]));
    let error = steady::march(method, &field(), start, 0.1, 1e-6, 0).expect_err("none");
    assert!(error.to_string().contains("at least 1"), "{error}");
}

#[test]
fn solvers_that_lack_something_are_refused_when_they_are_given() {
    let banded = || field_of(Decay { structure: band(), ..Decay::default() });
    let why = |error: Option<InputError>| match error {
        Some(InputError::System(SystemError::Solver(why))) => why,
        other => panic!("{other:?}"),
    };
    let twisted = LeastSquaresStep::with_solver(banded(), Linear::METHOD_II, Twisted::new());
    assert!(why(twisted.err()).contains("products"));
    let augmented = LeastSquaresStep::with_solver(banded(), Linear::METHOD_II, Augmented::new());
    assert!(why(augmented.err()).contains("products"));
    let iterative = || Iterative::new(Factored::default());
    assert!(LeastSquaresStep::with_solver(banded(), Linear::METHOD_II, iterative()).is_ok());
    let boxed: Box<dyn lsvi::solver::StepSolver> = Box::new(iterative());
    assert!(LeastSquaresStep::with_solver(banded(), Linear::METHOD_II, boxed).is_ok());
    let matrix_free = [
        LeastSquaresStep::with_solver(MatrixFree, Linear::METHOD_I, iterative()).err(),
        RungeKutta::with_solver(MatrixFree, Tableau::implicit_euler(), iterative()).err(),
        Bdf2::with_solver(MatrixFree, iterative).err(),
    ];
    for error in matrix_free {
        assert!(why(error).contains("preconditioner of your own"));
    }
}

/// L = ½ v² − ½ q², and what may be wrong with it.
struct Oscillator;

impl LagrangianFn for Oscillator {
    fn dim(&self) -> usize {
        1
    }
    fn lagrangian<T: Scalar>(&self, _t: T, q: &[T], v: &[T]) -> T {
        (v[0] * v[0] - q[0] * q[0]) * 0.5
    }
}

/// L = ½ m(q) v² with m = NaN.
struct NoMass {
    separable: bool,
}

impl LagrangianFn for NoMass {
    fn dim(&self) -> usize {
        1
    }
    fn is_separable(&self) -> bool {
        self.separable
    }
    fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
        v[0] * v[0] * f64::NAN
    }
}

/// The derivative of the square root of |q| − 1 is infinite on the circle, and NaN inside.
struct Root;

impl ConstraintFn for Root {
    fn dim(&self) -> usize {
        2
    }
    fn count(&self) -> usize {
        1
    }
    fn constraint<T: Scalar>(&self, q: &[T], out: &mut [T]) {
        out[0] = (q[0] * q[0] + q[1] * q[1] - 1.0).sqrt();
    }
}

struct Free;

impl LagrangianFn for Free {
    fn dim(&self) -> usize {
        2
    }
    fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], v: &[T]) -> T {
        (v[0] * v[0] + v[1] * v[1]) * 0.5
    }
}

#[test]
fn what_is_not_finite_is_not_told_as_singular() {
    let is_non_finite = |error: &StepError| {
        let solve =
            |source: &SolveError| matches!(source, SolveError::NonFinite | SolveError::NonFiniteDerivative { .. });
        let told = matches!(error, StepError::Solve { source, .. } if solve(source))
            || matches!(error, StepError::Input(InputError::System(SystemError::NonFinite { .. })));
        told && error.to_string().contains("not finite")
    };
    for separable in [false, true] {
        let l = lagrangian_of(NoMass { separable });
        let methods: [Box<dyn OneStep>; 2] = [
            Box::new(position_momentum(Trapezoidal::new(&l))),
            Box::new(position_momentum(Galerkin::gauss(&l, 2).expect("degree 2"))),
        ];
        for mut method in methods {
            let error = method.step(0.0, 0.1, &mut [1.0], &mut [1.0]).expect_err("no mass");
            assert!(is_non_finite(&error), "{error}");
        }
        let error = TwoStep::new(Trapezoidal::new(&l)).step(0.0, 0.1, &mut [1.0], &mut [1.0]).expect_err("no mass");
        assert!(is_non_finite(&error), "{error}");
    }
    let free = lagrangian_of(Free);
    for q in [[1.0, 0.0], [0.5, 0.0]] {
        let mut method = Constrained::new(Trapezoidal::new(&free), AutoConstraint::new(Root)).expect("fits");
        let error = method.step(0.0, 0.1, &mut q.clone(), &mut [0.0, 1.0]).expect_err("no gradient");
        assert!(is_non_finite(&error), "{error}");
        let error = method.project(0.0, &q, &mut [0.0, 1.0]).expect_err("no gradient");
        assert!(is_non_finite(&error), "{error}");
    }
    /// f = 0 with a Jacobian of NaN.
    struct NoJacobian(Structure);
    impl VectorField for NoJacobian {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            self.0.clone()
        }
        fn rhs(&self, _t: f64, _v: &[f64], dv: &mut [f64]) {
            dv.fill(-1.0);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], scale: f64, out: &mut Jacobian) {
            out.add(1, 1, scale * f64::NAN);
        }
    }
    for structure in [Structure::Dense, band(), Structure::sparse(2, []).expect("inside")] {
        let field = || NoJacobian(structure.clone());
        let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
        let runs = [
            Trajectory::new(method_i(field()).expect("usable"), State::new(0.0, vec![1.0; 2]), 0.1, 1.0)
                .expect("usable")
                .observe(|_| {}),
            Trajectory::new(Radau::new(field(), tolerances).expect("usable"), State::new(0.0, vec![1.0; 2]), 0.1, 1.0)
                .expect("usable")
                .observe(|_| {}),
            Trajectory::new(
                RungeKutta::new(field(), Tableau::implicit_euler()).expect("usable"),
                State::new(0.0, vec![1.0; 2]),
                0.1,
                1.0,
            )
            .expect("usable")
            .observe(|_| {}),
        ];
        for run in runs {
            let error = run.expect_err("no Jacobian");
            assert!(is_non_finite(&error), "{structure:?}: {error}");
        }
    }
    let mut nan = Jacobian::zeros(2);
    nan.add(1, 0, f64::NAN);
    #[derive(Debug)]
    struct Massive(Jacobian);
    impl VectorField for Massive {
        fn dim(&self) -> usize {
            2
        }
        fn mass(&self) -> Mass {
            Mass::Matrix(self.0.clone())
        }
        fn rhs(&self, _t: f64, _v: &[f64], dv: &mut [f64]) {
            dv.fill(0.0);
        }
        fn add_jacobian(&self, _t: f64, _v: &[f64], _scale: f64, _out: &mut Jacobian) {}
    }
    let error = method_i(Massive(nan.clone())).expect_err("no mass");
    assert_eq!(error, InputError::System(SystemError::NonFiniteEntry { what: "mass matrix", row: 1, column: 0 }));
}

#[test]
fn a_step_from_a_time_that_is_none_is_refused() {
    let field = field_of(Decay::default());
    let declared = field_of(Decay { structure: band(), linear: true, autonomous: true, ..Decay::default() });
    let mut steps: Vec<Box<dyn OneStep>> = vec![
        Box::new(method_i(&field).expect("usable")),
        Box::new(method_i(&declared).expect("usable")),
        Box::new(RungeKutta::new(&field, Tableau::rk4()).expect("usable")),
        Box::new(CoupledRungeKutta::new(&field, &[vec![0.5]], &[1.0], &[0.5]).expect("usable")),
        Box::new(position_momentum(Trapezoidal::new(lagrangian_of(Free)))),
        Box::new(position_momentum(Galerkin::gauss(lagrangian_of(Free), 2).expect("degree 2"))),
    ];
    for (i, method) in steps.iter_mut().enumerate() {
        // A step before, so that what is known of it cannot answer.
        method.step(0.0, 0.1, &mut [1.0; 2], &mut [0.0; 2]).expect("a step");
        for t in [f64::NAN, f64::INFINITY] {
            let error = method.step(t, 0.1, &mut [1.0; 2], &mut [0.0; 2]).expect_err("no time");
            assert!(matches!(error, StepError::Input(InputError::Time(TimeError::Time(_)))), "{i}: {error}");
        }
    }
    let mut adaptive = Radau::new(&field, Tolerances::new(1e-6, 1e-6).expect("positive")).expect("usable");
    let grid = Grid::new(0.0, 0.1, 1.0).expect("usable");
    let error = adaptive.advance(&mut State::new(f64::NAN, vec![1.0; 2]), &grid).expect_err("no time");
    assert!(matches!(error, StepError::Input(InputError::Time(TimeError::Time(_)))), "{error}");
    let free = lagrangian_of(Free);
    let mut held = Constrained::new(Trapezoidal::new(&free), AutoConstraint::new(Root)).expect("fits");
    assert!(held.project(f64::NAN, &[2.0, 0.0], &mut [0.0, 1.0]).is_err());
    let error = steady::check(&field, f64::NAN, &[0.0; 2], 1.0).expect_err("no time");
    assert!(matches!(error, steady::SteadyError::Input(InputError::Time(TimeError::Time(_)))), "{error}");
    let state = State::new(f64::NAN, vec![1.0; 2]);
    let error = Trajectory::new(method_i(&field).expect("usable"), state, 0.1, 1.0).map(|_| ()).expect_err("no time");
    assert!(matches!(error, InputError::Time(TimeError::Time(_))), "{error}");
    assert_eq!(error.to_string(), "time t = NaN must be finite");
}

#[test]
fn systems_of_no_unknowns_are_refused() {
    let nothing = || field_of!(0, |_t, _v, _dv| {});
    struct Nothing;
    impl LagrangianFn for Nothing {
        fn dim(&self) -> usize {
            0
        }
        fn is_separable(&self) -> bool {
            true
        }
        fn lagrangian<T: Scalar>(&self, _t: T, _q: &[T], _v: &[T]) -> T {
            T::from(0.0)
        }
    }
    let l = lagrangian_of(Nothing);
    let tolerances = Tolerances::new(1e-6, 1e-6).expect("positive");
    let refused = [
        method_i(nothing()).err(),
        method_ii(nothing()).err(),
        RungeKutta::new(nothing(), Tableau::sdirk2()).err(),
        CoupledRungeKutta::new(nothing(), &[vec![0.5]], &[1.0], &[0.5]).err(),
        Bdf2::new(nothing()).err(),
        Radau::new(nothing(), tolerances).err(),
        Window::new(Trapezoidal::new(&l), 3).err(),
    ];
    assert!(refused.into_iter().all(|error| error == Some(InputError::System(SystemError::Empty))));
    let mut methods: [Box<dyn OneStep>; 3] = [
        Box::new(position_momentum(Trapezoidal::new(&l))),
        Box::new(position_momentum(Midpoint::new(&l))),
        Box::new(position_momentum(Galerkin::gauss(&l, 2).expect("degree 2"))),
    ];
    for method in &mut methods {
        let error = method.step(0.0, 0.1, &mut [], &mut []).expect_err("nothing");
        assert_eq!(error, StepError::Input(InputError::System(SystemError::Empty)));
    }
    let mut two_step = TwoStep::new(Galerkin::gauss(&l, 2).expect("degree 2"));
    assert!(two_step.step(0.0, 0.1, &mut [], &mut []).is_err());
}

#[test]
fn a_window_names_the_entry_outside_its_structure() {
    /// v̇ = (−v₀ + v₁, −v₁) as if it had no coupling.
    struct Coupled;
    impl FieldFn for Coupled {
        fn dim(&self) -> usize {
            2
        }
        fn structure(&self) -> Structure {
            band()
        }
        fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
            dv[0] = -v[0] + v[1];
            dv[1] = -v[1];
        }
    }
    let lagrangian = LeastSquares::new(field_of(Coupled)).expect("usable");
    let window = Window::new(Trapezoidal::new(lagrangian), 3).expect("three steps");
    let run = Trajectory::new(window, State::new(0.0, vec![1.0; 2]), 0.1, 1.0).expect("usable").observe(|_| {});
    let error = run.expect_err("outside");
    let StepError::Solve { source: SolveError::OutsideStructure { row: 0, column: 1 }, .. } = error else {
        panic!("{error}");
    };
}

#[test]
fn messages_show_the_size_of_a_number() {
    let error = Trajectory::new(
        method_i(field_of(Decay::default())).expect("usable"),
        State::new(0.0, vec![1.0; 2]),
        1e-300,
        1.0,
    )
    .map(|_| ())
    .expect_err("unresolvable");
    assert_eq!(error.to_string(), "step size h = 1e-300 cannot resolve the interval [0, 1] in double precision");
}

#[test]
fn a_field_that_ends_is_told_with_its_time() {
    let field = || field_of!(1, |t, v, dv| dv[0] = if t > 0.5 { v[0] * f64::NAN } else { -v[0] });
    let methods: Vec<(&str, Box<dyn Integrator>)> = vec![
        ("Method I", Box::new(method_i(field()).expect("usable"))),
        ("Method II", Box::new(method_ii(field()).expect("usable"))),
        ("Radau", Box::new(Radau::new(field(), Tolerances::new(1e-6, 1e-6).expect("positive")).expect("usable"))),
        ("implicit Euler", Box::new(RungeKutta::new(field(), Tableau::implicit_euler()).expect("usable"))),
        ("BDF2", Box::new(Bdf2::new(field()).expect("usable"))),
    ];
    for (name, method) in methods {
        let mut run = Trajectory::new(method, State::new(0.0, vec![1.0]), 0.3, 1.0).expect("fits");
        let error = loop {
            if let Err(error) = run.step() {
                break error;
            }
        };
        let StepError::Solve { t, source, .. } = &error else { panic!("{name}: {error}") };
        let reached = match source {
            SolveError::NonFinite => 0.0,
            SolveError::NonFiniteBeyond { reached } => *reached,
            _ => panic!("{name}: {error}"),
        };
        // Where a piece of the step ends next to t = 0.5, or at its beginning.
        assert!(t + reached <= 0.5 + 1e-12 && error.to_string().contains("not finite"), "{name}: {error}");
    }
}

/// Solves nothing: what it returns is always the same.
#[derive(Debug)]
struct Constant(f64);

impl StepSolver for Constant {
    fn prepare(&mut self, _b: &StepOperator<'_>) -> Result<(), SolveError> {
        Ok(())
    }
    fn solve_stage(&mut self, _b: &StepOperator<'_>, x: &mut [f64], _tolerance: f64) -> Result<u64, SolveError> {
        x.fill(self.0);
        Ok(1)
    }
    fn solve_normal(
        &mut self,
        _b: &StepOperator<'_>,
        _damping: f64,
        _upper: Option<&[f64]>,
        x: &mut [f64],
        _tolerance: f64,
    ) -> Result<u64, SolveError> {
        x.fill(self.0);
        Ok(1)
    }
}

#[test]
fn what_a_solver_does_not_solve_is_told() {
    let step = |value: f64| {
        let field = field_of!(1, |_t, v, dv| dv[0] = -v[0] * v[0]);
        let mut method = LeastSquaresStep::with_solver(field, Linear::METHOD_I, Constant(value)).expect("usable");
        let (mut v, mut p) = ([1.0], [0.0]);
        let result = method.step(0.0, 0.1, &mut v, &mut p);
        assert_eq!(v, [1.0]);
        result
    };
    let nothing = step(0.0);
    assert!(matches!(nothing, Err(StepError::Solve { source: SolveError::Linear { .. }, .. })), "{nothing:?}");
    let nan = step(f64::NAN);
    assert!(matches!(nan, Err(StepError::Solve { source: SolveError::NonFinite, .. })), "{nan:?}");
}

#[test]
fn twisted_elimination_says_what_it_needs() {
    let check = |structure: Structure, mass: Mass| match Twisted::new().check(&structure, &mass) {
        Err(InputError::System(SystemError::Solver(what))) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(check(band(), Mass::Matrix(Jacobian::zeros(2))), "twisted elimination needs a diagonal mass matrix");
    assert_eq!(check(Structure::Dense, Mass::Identity), "twisted elimination needs a banded structure");
}

#[test]
fn messages_have_their_numbers_in_their_places() {
    let inconsistent = InputError::System(SystemError::InconsistentStart { row: 2, value: 0.5, allowed: 0.25 });
    let text = inconsistent.to_string();
    assert!(text.contains("f[2] = 0.5") && text.contains("where 0.25 is allowed"), "{text}");
    let fading = field_of!(1, |_t, v, dv| dv[0] = -v[0]);
    let mut run =
        Trajectory::new(method_i(fading).expect("usable"), State::new(0.0, vec![1.0]), 0.1, 1.0).expect("valid");
    let order = run.sample(&[0.2, 0.5, 0.3], |_, _| {}).expect_err("out of order");
    let expected = StepError::Input(InputError::Time(TimeError::SaveTime { index: 2, t: 0.3, from: 0.5, to: 1.0 }));
    assert_eq!(order, expected);
}

/// A preconditioner is set up for B = M − s f_v at (t, v), and is told these; a solver without products has no closure.
#[test]
fn a_preconditioner_is_told_where_its_matrix_is_taken() {
    struct Curious;
    impl Preconditioner for Curious {
        fn prepare(&mut self, b: &StepOperator<'_>) -> Result<(), SolveError> {
            // The branch is followed by parts of the step.
            assert_eq!(b.t(), 3.125 + b.s());
            // Between the start and what an explicit step makes of it.
            assert!(matches!(*b.v(), [x, y] if (0.875..=1.0).contains(&x) && y == 2.0 * x), "{:?}", b.v());
            let product = &mut |_: &[f64], _: &mut [f64]| ();
            assert_eq!(Twisted::new().solve_closure(b, product, &mut [1.0; 2], 0.0), Err(SolveError::NotAssembled));
            Err(SolveError::Singular)
        }
        fn solve(&mut self, _x: &mut [f64]) {}
        fn solve_transpose(&mut self, _x: &mut [f64]) {}
    }
    let tableau = Tableau::implicit_midpoint();
    let mut method = RungeKutta::with_solver(MatrixFree, tableau, Iterative::new(Curious)).expect("fits");
    let error = method.step(3.125, 0.25, &mut [1.0, 2.0], &mut [0.0; 2]).expect_err("no preconditioner");
    assert!(matches!(error, StepError::Solve { source: SolveError::Singular, .. }), "{error}");
}

/// A decay of three unknowns with the structure and the mass given.
struct Massed(Structure, Mass);

impl FieldFn for Massed {
    fn dim(&self) -> usize {
        3
    }
    fn structure(&self) -> Structure {
        self.0.clone()
    }
    fn mass(&self) -> Mass {
        self.1.clone()
    }
    fn rhs<T: Scalar>(&self, _t: f64, v: &[T], dv: &mut [T]) {
        dv.iter_mut().zip(v).for_each(|(dv, v)| *dv = -*v);
    }
}

#[test]
fn a_mass_of_another_size_is_refused_in_every_structure() {
    let sparse = Structure::sparse(3, (0..3).map(|i| (i, i))).expect("inside");
    for structure in [Structure::Dense, Structure::Banded { lower: 0, upper: 0 }, sparse] {
        let of = |mass: Mass| {
            let field = || AutoField::new(Massed(structure.clone(), mass.clone()));
            [
                RungeKutta::new(field(), Tableau::implicit_euler()).is_ok(),
                Bdf2::new(field()).is_ok(),
                method_i(field()).is_ok(),
            ]
        };
        assert_eq!(of(Mass::Diagonal(vec![1.0, 2.0, 3.0])), [true; 3], "{structure:?}");
        assert_eq!(of(Mass::Diagonal(vec![1.0, 2.0])), [false; 3], "{structure:?}");
        assert_eq!(of(Mass::Diagonal(vec![1.0, f64::NAN, 3.0])), [false; 3], "{structure:?}");
        assert_eq!(of(Mass::Matrix(Jacobian::with_structure(2, &Structure::Dense))), [false; 3], "{structure:?}");
    }
}
