//! Step equations of one and two unknowns, with the roots and folds that they have.

use super::continuation::PIECES;
use super::*;

#[test]
fn work_adds_up_count_by_count() {
    let work = |by: u64| Work { steps: by, residuals: 2 * by, factorizations: 3 * by, inner: 4 * by };
    assert_eq!(work(10) + work(3), work(13));
}

/// x² − 2x + h = 0: the branch x = 1 − √(1 − h) starts at 0 and folds at h = 1.
struct Fold;

impl System for Fold {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        out[0] = x[0] * x[0] - 2.0 * x[0] + h;
    }
    fn derivative(&mut self, _: f64, x: &[f64], out: &mut Jacobian) {
        out.add(0, 0, 2.0 * x[0] - 2.0);
    }
}

#[test]
fn stays_on_the_branch_up_to_the_fold() {
    for h in [1e-3, 0.5, 0.9, 0.999, 0.999_999] {
        let mut x = [0.0];
        Newton::new(1).solve(&mut Fold, h, &mut x).expect("on the branch");
        // The root's condition number is 1/(2√(1 − h)) ≤ 500.
        approx::assert_abs_diff_eq!(x[0], 1.0 - (1.0 - h).sqrt(), epsilon = 500.0 * 4.0 * f64::EPSILON);
    }
}

/// At h = 0.1 the second increment is a fortieth of the first. At h = 0.9 the ratios are 0.41, 0.25 and 0.07.
#[test]
fn factors_are_kept_once_increments_contract_by_an_eighth() {
    for (h, factorizations) in [(0.1, 2), (0.9, 4)] {
        let mut newton = Newton::new(1);
        newton.solve(&mut Fold, h, &mut [0.0]).expect("on the branch");
        assert_eq!(newton.work.factorizations, factorizations, "h = {h}: {:?}", newton.work);
        assert!(newton.work.residuals > factorizations, "h = {h}: {:?}", newton.work);
    }
}

/// Each step is held to its own roundings: one in which none were measured is next to its origin to half of the digits only.
#[test]
fn roundings_are_those_of_one_step() {
    let mut newton = Newton::new(1);
    newton.noise = 1e-6;
    newton.solve(&mut Fold, 0.5, &mut [0.0]).expect("on the branch");
    assert_eq!(newton.noise, 0.0);
    (newton.origin[0], newton.limit.is_regular) = (1e3, true);
    let mut near = |noise: f64, way: f64| {
        newton.noise = noise;
        newton.is_next_to_origin(&Fold, way)
    };
    assert_eq!([near(0.0, 1e-5), near(0.0, 1e-4), near(1e-6, 9e-3), near(1e-6, 2e-2)], [true, false, true, false]);
}

/// x₀ − 1 − s = 0 and, algebraic, s (x₁ − x₀²) = 0.
struct OnParabola;

impl System for OnParabola {
    fn dim(&self) -> usize {
        2
    }
    fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
        out.copy_from_slice(&[x[0] - 1.0 - s, s * (x[1] - x[0] * x[0])]);
    }
    fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
        [(0, 0, 1.0), (1, 0, -2.0 * s * x[0]), (1, 1, s)].into_iter().for_each(|(i, j, x)| out.add(i, j, x));
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
    fn algebraic(&self) -> &[usize] {
        &[1]
    }
}

/// From (1, 1.5) the increments are h and 1 + 2h − 1.5 for every h, and to the limit as well.
#[test]
fn the_limit_makes_the_increments_of_algebraic_equations_that_a_step_makes() {
    let (mut newton, h, start) = (Newton::new(2), 0.125, [1.0, 1.5]);
    newton.origin.copy_from_slice(&start);
    newton.set_limit(&mut OnParabola, h);
    let mut residual = [0.0; 2];
    OnParabola.residual(h, &start, &mut residual);
    newton.limit.solve(&OnParabola, h, &mut residual);
    approx::assert_relative_eq!(residual[..], [-h, 0.5 - 2.0 * h][..], max_relative = 1e-12);
}

/// Where the limit is singular no tangent is known, and none where residuals at the origin are roundings.
#[test]
fn nothing_is_asked_of_a_tangent_that_is_not_known() {
    fn answers(system: &mut dyn System, start: &[f64], is_regular: bool) -> [bool; 3] {
        let (mut newton, mut x, h) = (Newton::new(start.len()), start.to_vec(), 0.125);
        newton.origin.copy_from_slice(start);
        newton.point.copy_from_slice(start);
        newton.set_limit(system, h);
        newton.iterate(system, h, &mut x, CONTRACTION).map(drop).expect("a root");
        newton.limit.is_regular = is_regular;
        let is_next = newton.is_next_to_origin(system, 0.0);
        [newton.is_affine(system, h), newton.has_short_tangent(system, h), is_next]
    }
    assert_eq!(answers(&mut OnParabola, &[1.0, 1.5], true), [true, true, false]);
    assert_eq!(answers(&mut Fold, &[0.0], false), [true, true, false]);
    assert_eq!(answers(&mut Fold, &[0.0], true), [false, false, true]);
}

/// A step of implicit Euler of a damped circuit, q̇ = i/u and i̇ = −1000 (u (q − 5) + i/20), from the charge and the current that it holds.
struct Circuit {
    unit: f64,
    from: [f64; 2],
}

impl System for Circuit {
    fn dim(&self) -> usize {
        2
    }
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        out[0] = x[0] - self.from[0] - h * x[1] / self.unit;
        out[1] = x[1] - self.from[1] + h * 1000.0 * self.unit * (x[0] - 5.0 + x[1] * (0.05 / self.unit));
    }
    fn derivative(&mut self, h: f64, _: &[f64], out: &mut Jacobian) {
        let (charge, current) = (h * 1000.0 * self.unit, 1.0 + h * 50.0);
        [(0, 0, 1.0), (0, 1, -h / self.unit), (1, 0, charge), (1, 1, current)]
            .into_iter()
            .for_each(|(i, j, x)| out.add(i, j, x));
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

/// Increments are roundings there, in no proportion to each other: no piece of the step is sure, and hundreds of factorizations tell nothing.
#[test]
fn steps_beside_a_rest_are_not_continued_in_pieces() {
    let mut dear = Vec::new();
    for exponent in -8..=8 {
        for h in [0.01, 0.033, 0.2] {
            let unit = 10_f64.powi(exponent);
            let (mut newton, mut circuit) = (Newton::new(2), Circuit { unit, from: [5.0 + 1e-9, 0.0] });
            let mut most = 0;
            for _ in 0..300 {
                let (before, mut x) = (newton.work.factorizations, circuit.from);
                newton.solve(&mut circuit, h, &mut x).expect("affine");
                circuit.from = x;
                most = most.max(newton.work.factorizations - before);
            }
            if most > 4 {
                dear.push((exponent, h, most));
            }
        }
    }
    assert!(dear.is_empty(), "{dear:?}");
}

/// x − (1 − h) size = 0, of which what increments are off by is `off` on every other call.
struct Noisy {
    size: f64,
    off: f64,
    is_next: bool,
}

impl Noisy {
    /// Off by 1e-9 of 1 on the second call.
    const LITTLE: Self = Self { size: 1.0, off: 1e-9, is_next: false };
}

impl System for Noisy {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        out[0] = x[0] - (1.0 - h) * self.size + if self.is_next { self.off } else { 0.0 };
        self.is_next ^= true;
    }
    fn derivative(&mut self, _: f64, _: &[f64], out: &mut Jacobian) {
        out.add(0, 0, 1.0);
    }
    fn is_affine(&self) -> bool {
        true
    }
}

/// The second increment takes back what the first was off by, 2⁻³⁰ of the state. In a piece of a continuation that may be another branch.
#[test]
fn increments_below_half_of_the_digits_stagnate_on_roundings_but_in_a_continuation() {
    for size in [1.0, 1048576.0] {
        let stagnates = [CONTRACTION, SURE_CONTRACTION].map(|first| {
            let mut noisy = Noisy { size, off: size / f64::from(1 << 30), is_next: true };
            Newton::new(1).iterate(&mut noisy, 0.5, &mut [0.5 * size], first).is_ok()
        });
        assert_eq!(stagnates, [true, false], "{size}");
    }
}

/// They are 2⁻²³ of the state, so that no iteration contracts below half of the digits.
#[test]
fn roundings_of_a_few_digits_are_allowed_for_whatever_the_size_of_the_state() {
    for size in [1.0, 1048576.0] {
        let off = size / f64::from(1 << 23);
        let (mut newton, mut x) = (Newton::new(1), [0.5 * size]);
        let found = newton.solve(&mut Noisy { size, off, is_next: true }, 0.5, &mut x);
        assert!(found.is_ok() && newton.noise > 0.0, "{size}: {found:?}");
        approx::assert_abs_diff_eq!(x[0], 0.5 * size, epsilon = off);
    }
}

#[test]
fn a_step_that_failed_says_nothing_of_the_size_of_states() {
    let mut newton = Newton::new(1);
    newton.largest = 0.25;
    let found = newton.solve(&mut Noisy { size: 1.0, off: 1e6, is_next: true }, 0.5, &mut [0.5]);
    assert!(found.is_err() && newton.largest == 0.25, "{found:?}: {}", newton.largest);
    newton.solve(&mut Noisy { size: 1.0, off: 0.0, is_next: true }, 0.5, &mut [0.75]).expect("affine");
    assert_eq!(newton.largest, 0.75);
}

/// Four of them add up where an increment has some of each.
#[test]
fn roundings_are_measured_with_room_for_several() {
    let noise = Newton::new(1).measured_noise(&mut { Noisy::LITTLE }, 0.5, &[1.0]);
    approx::assert_relative_eq!(noise, 4e-9, max_relative = 1e-6);
}

/// Beside 1, and not where x² − h has another slope.
#[test]
fn roundings_are_measured_a_few_roundings_away() {
    let mut square = Noted { f: |h: f64, x: f64| (x * x - h, 2.0 * x), notes: Vec::new() };
    let noise = Newton::new(1).measured_noise(&mut square, 0.5, &[1.0]);
    assert!(noise <= f64::from(ROUNDS) * 4.0 * f64::EPSILON, "{noise:e}");
}

/// F and its slope, with notes of where F is asked for.
struct Noted<F> {
    f: F,
    notes: Vec<(f64, f64)>,
}

impl<F: Fn(f64, f64) -> (f64, f64)> System for Noted<F> {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        self.notes.push((h, x[0]));
        out[0] = (self.f)(h, x[0]).0;
    }
    fn derivative(&mut self, h: f64, x: &[f64], out: &mut Jacobian) {
        out.add(0, 0, (self.f)(h, x[0]).1);
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

/// Whether increments contract on the way from `origin` to `guess`, a guess for h = 2, where F was asked for, and how often.
fn on_way(f: impl Fn(f64, f64) -> (f64, f64), (origin, guess): (f64, f64)) -> (bool, Vec<(f64, f64)>, u64) {
    let (mut newton, mut system) = (Newton::new(1), Noted { f, notes: Vec::new() });
    (newton.origin[0], newton.guess[0]) = (origin, guess);
    let contracts = newton.contracts_on_way_to_guess(&mut system, 2.0);
    (contracts, system.notes, newton.work.residuals)
}

#[test]
fn the_way_to_a_guess_is_looked_at_as_far_as_it_leaves_the_origin_behind() {
    // x = 3 + 5h is 8 half-way, where the guess 15 leads to 9, and 5.5 at a quarter, where it leads to 6.
    let line = |h: f64, x: f64| (x - 3.0 - 5.0 * h, 1.0);
    let places = vec![(1.0, 9.0), (1.0, 8.0), (0.5, 6.0), (0.5, 5.5)];
    assert_eq!(on_way(line, (3.0, 15.0)), (true, places, 4));
    assert_eq!(on_way(line, (3.0, 6.0)), (true, vec![], 0));
    // On the branch increments are none.
    assert!(on_way(line, (3.0, 13.0)).0);
}

/// From u the increments of u + u² by one derivative are in the ratio u (1 + u²/(1 + 2u))/((1 + 2u)(1 + u)): 0.1224 at u = 0.2, 0.1260 at 0.21.
#[test]
fn increments_on_the_way_to_a_guess_contract_by_an_eighth() {
    let square = |_: f64, x: f64| (x + x * x, 1.0 + 2.0 * x);
    assert_eq!([0.4, 0.42].map(|guess| on_way(square, (0.0, guess)).0), [true, false]);
    // The first increment leads to where there is no logarithm.
    assert!(!on_way(|_, x| ((x / 3.0).ln(), x.recip()), (3.0, 15.0)).0);
    // A derivative that vanishes gives none.
    assert!(!on_way(|_, x| (x, 0.0), (3.0, 15.0)).0);
}

/// x = 100 + h to eight digits of the way, not of x.
#[test]
fn a_guess_is_the_increment_to_half_of_its_own_digits() {
    let near = |off: f64| {
        let (mut newton, h) = (Newton::new(1), 1.0);
        let mut line = Noted { f: |h: f64, x: f64| (x - 100.0 - h, 1.0), notes: Vec::new() };
        (newton.origin[0], newton.guess[0]) = (100.0, 100.0 + h + off);
        newton.set_limit(&mut line, h);
        newton.guess_is_increment(&mut line, h)
    };
    assert_eq!([0.0, 1e-9, -1e-9, 1e-6, -1e-6].map(near), [true, true, true, false, false]);
}

/// Whether F is found to be affine at h = 1, from `origin`, where the first guess is the origin.
fn is_affine_from(origin: f64, f: impl Fn(f64, f64) -> (f64, f64)) -> bool {
    let (mut newton, mut system, mut x) = (Newton::new(1), Noted { f, notes: Vec::new() }, [origin]);
    (newton.origin[0], newton.point[0]) = (origin, origin);
    newton.set_limit(&mut system, 1.0);
    newton.iterate(&mut system, 1.0, &mut x, CONTRACTION).map(drop).expect("a root");
    newton.is_affine(&mut system, 1.0)
}

/// y − h + max(y − k h, 0) = 0 for y = x − 10. Beyond the root at y = h nobody comes.
#[test]
fn an_equation_is_asked_whether_it_is_affine_on_the_way_to_its_root() {
    let kinked = |k: f64| {
        is_affine_from(10.0, |h, x| {
            let over = x - 10.0 - k * h;
            (x - 10.0 - h + over.max(0.0), if over > 0.0 { 2.0 } else { 1.0 })
        })
    };
    assert_eq!([1.3, 0.3].map(kinked), [true, false]);
}

/// y − h + c y² = 0 for y = x − 1000. By the derivative at the root, 1 + 2c, the increment to 0.618 is off by c (2 · 0.618 − 0.618²) = 0.854 c;
/// √ε of that way is 9.2e-9, and a motion may be as small beside the largest unknown as it likes.
#[test]
fn an_equation_is_affine_to_half_of_the_digits_of_the_way() {
    let bent = |c: f64| {
        is_affine_from(1e3, |h, x| {
            let y = x - 1e3;
            (y - h + c * y * y, 1.0 + 2.0 * c * y)
        })
    };
    assert_eq!([1e-8, 1.2e-8].map(bent), [true, false]);
}

/// A(s) (x − 1) = b s with A = 1 − 3.2 s (1 − s) (3 − 4s), which is 1 at s = 0 and at s = 1, but 0.2 half-way and −0.2 at 0.3. What of the
/// increments is lost in roundings of x tells nothing.
#[test]
fn a_derivative_that_changes_half_way_is_not_regular_for_being_small() {
    let is_regular = |b: f64| {
        let a = |s: f64| 1.0 - 3.2 * s * (1.0 - s) * (3.0 - 4.0 * s);
        let mut system = Noted { f: |s: f64, x: f64| (a(s) * (x - 1.0) - b * s, a(s)), notes: Vec::new() };
        let (mut newton, mut x) = (Newton::new(1), [1.0]);
        (newton.origin[0], newton.point[0], newton.guess[0]) = (1.0, 1.0, 1.0);
        newton.set_limit(&mut system, 1.0);
        newton.iterate(&mut system, 1.0, &mut x, CONTRACTION).map(drop).expect("affine");
        newton.is_regular(&mut system, 1.0, 2.0 * SURE_CONTRACTION)
    };
    assert_eq!([0.05, f64::EPSILON].map(is_regular), [false, true]);
}

/// (1 + 4s) (x − s) = 0 from s = ¼ on, and before x − b s = 0.
fn from_a_quarter_on(b: f64) -> Noted<impl Fn(f64, f64) -> (f64, f64)> {
    let f = move |s: f64, x: f64| if s < 0.25 { (x - b * s, 1.0) } else { ((1.0 + 4.0 * s) * (x - s), 1.0 + 4.0 * s) };
    Noted { f, notes: Vec::new() }
}

#[test]
fn increments_in_proportion_to_the_way_tell_where_the_branch_starts_along_them() {
    let is_told = [1.2, -1.0].map(|b| {
        let (mut newton, mut system) = (Newton::new(1), from_a_quarter_on(b));
        newton.set_limit(&mut system, 1.0);
        newton.advance(&mut system, (0.0, 1.0), true, &mut [0.0]).is_ok()
    });
    assert_eq!(is_told, [true, false]);
}

#[test]
fn every_evaluation_of_a_look_is_counted() {
    let (mut newton, mut system, mut x) = (Newton::new(1), from_a_quarter_on(1.0), [0.0]);
    newton.iterate(&mut system, 1.0, &mut x, SURE_CONTRACTION).map(drop).expect("affine");
    let before = (newton.work.residuals, system.notes.len());
    assert!(newton.is_borne_out(&mut system, (0.0, 1.0), LOOKS[0], true, &x));
    assert_eq!(newton.work.residuals - before.0, (system.notes.len() - before.1) as u64);
}

#[test]
fn an_increment_is_one_where_the_derivative_is_regular_and_has_kept_its_sign() {
    let is_one = |slope: f64| {
        let mut newton = Newton::new(1);
        newton.limit.orientation = Some(1.0);
        newton.set_increment_at_point(&mut Noted { f: |_, x| (x, slope), notes: Vec::new() }, 1.0)
    };
    assert_eq!([2.0, 0.0, -2.0].map(is_one), [true, false, false]);
}

/// Whether the branch x = s − ½ from s = 0 is found to go on behind a kink at s = ½, where kx + cx² = s − ½; the root, and the one by the formula.
fn behind_kink(k: f64, c: f64) -> (bool, f64, f64) {
    behind_kink_at(0.0, k, c)
}

/// The same of x − `offset`.
fn behind_kink_at(offset: f64, k: f64, c: f64) -> (bool, f64, f64) {
    let f = |s: f64, x: f64| {
        let x = x - offset;
        if x < 0.0 { (x - (s - 0.5), 1.0) } else { ((k + c * x) * x - (s - 0.5), k + 2.0 * c * x) }
    };
    let (mut newton, mut x) = (Newton::new(1), [f64::NAN]);
    let (reached, target) = (0.5 * (1.0 - 1e-9), 0.5 * (1.0 + 5e-9));
    (newton.start[0], newton.origin[0]) = (offset - 0.5, offset + reached - 0.5);
    let crosses = newton.crosses_kink(&mut Noted { f, notes: Vec::new() }, (reached, target), &mut x);
    let beyond = target - 0.5;
    (crosses, x[0] - offset, 2.0 * beyond / (k + (k * k + 4.0 * c * beyond).sqrt()))
}

/// Behind the kink the branch has 1/k times the slope; for k < 0 it turns back. A way of 6e-3 of the branch is too far for what is 6e-9 of the step.
#[test]
fn a_kink_is_crossed_to_the_root_behind_it_where_the_branch_is_straight() {
    // What the branch bends by on that way is c (s − ½)/k² of it: 1e-3 of it do where 1e-2 do not.
    for (k, c, expected) in [
        (8.0, 0.0, true),
        (0.125, 0.0, true),
        (0.125, 3e3, true),
        (0.125, 3e4, false),
        (2e-6, 0.0, true),
        (4e-7, 0.0, false),
        (-2.0, 0.0, false),
    ] {
        let (crosses, found, root) = behind_kink(k, c);
        assert_eq!(crosses, expected, "{k}, {c}: {found:e} for {root:e}");
        assert!(!crosses || (found - root).abs() <= 1e-12 * root, "{k}, {c}: {found:e} for {root:e}");
    }
}

/// A rounding of 2¹⁷ is a hundredth of the way across.
#[test]
fn a_kink_is_crossed_where_the_branch_is_straight_but_for_roundings() {
    let (offset, k) = (131072.0, 0.125);
    let (crosses, found, root) = behind_kink_at(offset, k, 0.0);
    assert!(crosses && (found - root).abs() <= 2.0 * f64::EPSILON * offset, "{found:e} for {root:e}");
}

/// The second increments of a noisy equation are 1e-9, eight roundings of 6e5.
#[test]
fn an_affine_equation_is_solved_to_the_roundings_of_the_largest_state() {
    for (largest, expected) in [(1.0, false), (5e5, false), (6e5, true)] {
        let (mut newton, mut x) = (Newton::new(1), [0.25]);
        (newton.start[0], newton.largest) = (0.25, largest);
        assert_eq!(newton.solve_affine(&mut { Noisy::LITTLE }, 0.5, &mut x), expected, "{largest}");
        approx::assert_abs_diff_eq!(x[0], if expected { 0.5 } else { 0.25 }, epsilon = 2e-9);
    }
}

/// x² − 2x + h = 0 with a derivative that says nothing.
struct Wrong;

impl System for Wrong {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
        Fold.residual(h, x, out);
    }
    fn derivative(&mut self, _: f64, _: &[f64], out: &mut Jacobian) {
        out.add(0, 0, 0.9);
    }
}

#[test]
fn gives_up_on_a_wrong_derivative() {
    let mut newton = Newton::new(1);
    assert!(newton.solve(&mut Wrong, 0.5, &mut [0.0]).is_err());
    assert!(newton.work.residuals <= u64::from(PIECES * (ITERATIONS + 2)));
}

#[test]
fn names_the_fold() {
    for h in [1.1, 3.0, 1e6] {
        let mut x = [0.0];
        match Newton::new(1).solve(&mut Fold, h, &mut x) {
            Err(SolveError::BranchLost { reached }) => {
                approx::assert_abs_diff_eq!(reached, 1.0, epsilon = 1e-6);
            }
            other => panic!("h = {h}: {other:?} at x = {x:?}"),
        }
    }
}

/// A(s) x − s (1 − 2s) − x²/10 = 0, A = 1 − 8 s (1 − s): singular at s = 0.146, and at s = 1 what it is at 0. The branch, which
/// starts in the direction of growing x, folds on the way; Newton's iteration at s = 1 finds a root at x < 0.
struct Turning;

impl System for Turning {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
        out[0] = (1.0 - 8.0 * s * (1.0 - s)) * x[0] - s * (1.0 - 2.0 * s) - 0.1 * x[0] * x[0];
    }
    fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
        out.add(0, 0, 1.0 - 8.0 * s * (1.0 - s) - 0.2 * x[0]);
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

#[test]
fn a_root_away_from_the_tangent_is_not_on_the_branch_although_the_derivative_is_near_its_limit() {
    let mut x = [0.0];
    let found = Newton::new(1).solve(&mut Turning, 1.0, &mut x);
    let is_refused = matches!(found, Err(SolveError::OtherBranch | SolveError::BranchLost { .. }));
    assert!(is_refused, "{found:?} at {x:?}");
}

/// x − s² + 20 s x² (x − 1) = 0: the branch leaves x = 0 without a slope and folds at s = 0.2423743. At s = 1 the first increment leads
/// to the root x = 1, and the second is zero, as those of an affine equation are.
struct Coincidence;

impl System for Coincidence {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
        out[0] = x[0] - s * s + 20.0 * s * x[0] * x[0] * (x[0] - 1.0);
    }
    fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
        out.add(0, 0, 1.0 + 20.0 * s * x[0] * (3.0 * x[0] - 2.0));
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

#[test]
fn an_equation_is_not_affine_for_a_second_increment_that_vanishes() {
    let mut x = [0.0];
    let found = Newton::new(1).solve(&mut Coincidence, 1.0, &mut x);
    let is_lost = matches!(found, Err(SolveError::BranchLost { reached }) if (reached - 0.242_374_3).abs() < 1e-6);
    assert!(is_lost, "{found:?} at {x:?}");
}

/// y − s (3 − s)/2 + 100 s y² (y − 1) = 0 for y = x − 10: the branch folds at s = 0.0442686, and the root y = 1 at s = 1, to which the
/// first increment leads, lies within a tenth of the state and a third of the tangent.
struct NearCoincidence;

impl System for NearCoincidence {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
        let y = x[0] - 10.0;
        out[0] = y - 0.5 * s * (3.0 - s) + 100.0 * s * y * y * (y - 1.0);
    }
    fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
        let y = x[0] - 10.0;
        out.add(0, 0, 1.0 + 100.0 * s * y * (3.0 * y - 2.0));
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

#[test]
fn a_root_close_to_the_state_is_not_taken_for_a_second_increment_that_vanishes() {
    let mut x = [10.0];
    let found = Newton::new(1).solve(&mut NearCoincidence, 1.0, &mut x);
    let is_lost = matches!(found, Err(SolveError::BranchLost { reached }) if (reached - 0.044_268_6).abs() < 1e-6);
    assert!(is_lost, "{found:?} at {x:?}");
}

/// y − s (1 + 100 y² (y − 1)²) = 0, as implicit Euler steps on v̇ = 1 + 100 v² (v − 1)² from 0: the tangent of the branch leads to the root
/// y = 1 at s = 1 as well, where the derivative is the same, and the branch folds at s = 0.0571571.
struct TangentCoincidence;

impl System for TangentCoincidence {
    fn dim(&self) -> usize {
        1
    }
    fn residual(&mut self, s: f64, y: &[f64], out: &mut [f64]) {
        out[0] = y[0] - s * (1.0 + 100.0 * (y[0] * (y[0] - 1.0)).powi(2));
    }
    fn derivative(&mut self, s: f64, y: &[f64], out: &mut Jacobian) {
        out.add(0, 0, 1.0 - 200.0 * s * y[0] * (y[0] - 1.0) * (2.0 * y[0] - 1.0));
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

#[test]
fn a_root_to_which_the_tangent_leads_is_not_on_the_branch_for_that() {
    let mut y = [0.0];
    let found = Newton::new(1).solve(&mut TangentCoincidence, 1.0, &mut y);
    assert!(
        matches!(found, Err(SolveError::BranchLost { reached }) if (reached - 0.057_157_1).abs() < 1e-6),
        "{found:?} at {y:?}"
    );
}

/// x − s − x²/100 = 0 and (1 − 8 s (1 − s)) y = 0: at s = 1 the derivative is nearly what it is at 0, along x on the whole way, but round
/// s = ½ its determinant is negative; where that vanishes every y is a root.
struct Crossed;

impl System for Crossed {
    fn dim(&self) -> usize {
        2
    }
    fn residual(&mut self, s: f64, x: &[f64], out: &mut [f64]) {
        out[0] = x[0] - s - 0.01 * x[0] * x[0];
        out[1] = (1.0 - 8.0 * s * (1.0 - s)) * x[1];
    }
    fn derivative(&mut self, s: f64, x: &[f64], out: &mut Jacobian) {
        out.add(0, 0, 1.0 - 0.02 * x[0]);
        out.add(1, 1, 1.0 - 8.0 * s * (1.0 - s));
    }
    fn limit(&self) -> LimitAtZero {
        LimitAtZero::Kept
    }
}

#[test]
fn a_determinant_that_is_negative_half_way_across_the_tangent_is_not_passed_over() {
    let mut x = [0.0; 2];
    let found = Newton::new(2).solve(&mut Crossed, 1.0, &mut x);
    assert!(matches!(found, Err(SolveError::BranchLost { .. } | SolveError::OtherBranch)), "{found:?} at {x:?}");
}
