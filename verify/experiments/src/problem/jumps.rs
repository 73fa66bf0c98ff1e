//! Where f jumps, between two states of a run.

use lsvi::VectorField;

use super::Problem;
use super::rounding::rounding;

/// Halvings of the way between two states after which a jump is still there, and what is smooth a thousandth of what it was.
const HALVINGS: u32 = 10;
/// Part of a change of f that a jump is at least, of all of the way and of the last part of it.
const MOST: f64 = 0.9;
const REST: f64 = 0.5;
/// Times the change of f in the last step that one with a jump has: a jump of four times the smooth change of a step, which is what
/// [`MOST`] tells in the half of it, changes f by three times that at least.
const GROWN: f64 = 2.0;
/// Parts of a way between states that are far apart, on each of which what is smooth changes by little beside a jump.
const PARTS: u32 = 64;
/// Part of the largest value of a component of f below which a change of it is none: rounding does not get less with the way.
const NOISE: f64 = 1e-9;
/// Times what a few roundings of the state make of f that a jump is more than.
const ROUNDINGS: f64 = 8.0;

/// A component of f that jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// Which one.
    pub component: usize,
    /// Its values before and after.
    pub sides: [f64; 2],
}

impl Jump {
    /// What it jumps by.
    #[must_use]
    pub fn size(&self) -> f64 {
        (self.sides[1] - self.sides[0]).abs()
    }

    /// Whether a value of the component is nearer to that before.
    #[must_use]
    pub fn is_before(&self, value: f64) -> bool {
        (value - self.sides[0]).abs() <= (value - self.sides[1]).abs()
    }
}

/// Looks at f along the straight ways between states.
pub struct Jumps<'a> {
    field: Box<dyn VectorField + 'a>,
    /// The largest value of each component of f so far.
    largest: Vec<f64>,
    /// f at the end of the last step of a run, and what it changed by in that.
    last: Vec<f64>,
    change: Vec<f64>,
    now: Vec<f64>,
}

impl<'a> Jumps<'a> {
    /// For runs of `problem`; none where a state has not the unknowns of f.
    #[must_use]
    pub fn new(problem: &'a dyn Problem) -> Option<Self> {
        let field = problem.field();
        let zeros = vec![0.0; field.dim()];
        let fits = problem.initial().len() == zeros.len();
        let [largest, last, change] = [(); 3].map(|()| zeros.clone());
        fits.then_some(Self { field, largest, last, change, now: zeros })
    }

    /// f at (t, v).
    pub fn f(&mut self, t: f64, v: &[f64]) -> Vec<f64> {
        let mut f = vec![0.0; self.largest.len()];
        self.field.rhs(t, v, &mut f);
        self.largest.iter_mut().zip(&f).for_each(|(largest, f)| *largest = largest.max(f.abs()));
        f
    }

    /// Begins a run, or goes on from another state.
    pub fn start(&mut self, t: f64, v: &[f64]) {
        self.last = self.f(t, v);
        self.change.fill(0.0);
    }

    /// Whether f may have jumped in a step that ends at (t, v), for one evaluation of it: it has changed by twice what it changed
    /// by in the step before, at least.
    pub fn may_be_before(&mut self, t: f64, v: &[f64]) -> bool {
        self.field.rhs(t, v, &mut self.now);
        let mut has_grown = false;
        let befores = self.last.iter().zip(&mut self.change).zip(&mut self.largest);
        for (now, ((last, change), largest)) in self.now.iter().zip(befores) {
            let before = std::mem::replace(change, (now - last).abs());
            *largest = largest.max(now.abs());
            has_grown |= *change > GROWN * before && *change > NOISE * *largest;
        }
        std::mem::swap(&mut self.last, &mut self.now);
        has_grown
    }

    /// The component that jumps most for its size between two states; none where f changes by little parts.
    pub fn between(&mut self, from: (f64, &[f64]), to: (f64, &[f64])) -> Option<Jump> {
        let (middle, v) = along(from, to, 0.5);
        let (first, half, last) = (self.f(from.0, from.1), self.f(middle, &v), self.f(to.0, to.1));
        let changes = (0..first.len()).map(|k| {
            let change = |a: &[f64], b: &[f64]| (b[k] - a[k]).abs() / self.largest[k].max(f64::MIN_POSITIVE);
            (k, change(&first, &half), change(&half, &last), change(&first, &last))
        });
        let is_jump = |(_, a, b, all): &(usize, f64, f64, f64)| a.max(*b) >= MOST * all && a.max(*b) > NOISE;
        let mut found: Vec<_> = changes.filter(is_jump).collect();
        if !found.is_empty() {
            // Beside the last jump, at a place, a rounding makes all of it.
            let [before, behind] = [from, to].map(|(t, v)| rounding(|v, f| self.field.rhs(t, v, f), v, first.len()));
            let of_rounding = |k: usize| ROUNDINGS * before[k].min(behind[k]) / self.largest[k];
            found.retain(|(k, a, b, _)| a.max(*b) > of_rounding(*k));
        }
        let (component, a, b, _) = found.into_iter().max_by(|x, y| x.1.max(x.2).total_cmp(&y.1.max(y.2)))?;
        let (mut way, mut sides) = if a >= b {
            ([0.0, 0.5], [first[component], half[component]])
        } else {
            ([0.5, 1.0], [half[component], last[component]])
        };
        let whole = sides[1] - sides[0];
        for _ in 1..HALVINGS {
            let middle = 0.5 * (way[0] + way[1]);
            let (t, v) = along(from, to, middle);
            let value = self.f(t, &v)[component];
            if (value - sides[0]).abs() >= (sides[1] - value).abs() {
                (way[1], sides[1]) = (middle, value);
            } else {
                (way[0], sides[0]) = (middle, value);
            }
        }
        let jump = Jump { component, sides };
        (jump.size() >= REST * whole.abs()).then_some(jump)
    }

    /// The sum of what f jumps by along the straight ways between states of a run, once in each of many parts of them.
    pub fn sum(&mut self, times: &[f64], states: &[Vec<f64>]) -> f64 {
        let mut sum = 0.0;
        for (t, v) in times.windows(2).zip(states.windows(2)) {
            let at = |k: u32| along((t[0], &v[0]), (t[1], &v[1]), f64::from(k) / f64::from(PARTS));
            for part in 0..PARTS {
                let [from, to] = [at(part), at(part + 1)];
                sum += self.between((from.0, &from.1), (to.0, &to.1)).map_or(0.0, |jump| jump.size());
            }
        }
        sum
    }
}

/// Time and state at a part of the straight way between two states.
fn along((t, v): (f64, &[f64]), (t_end, end): (f64, &[f64]), part: f64) -> (f64, Vec<f64>) {
    (t + part * (t_end - t), v.iter().zip(end).map(|(a, b)| a + part * (b - a)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::model::Model;

    fn jumps(text: &str, ways: &[[f64; 2]], v: [f64; 2]) -> Vec<Option<f64>> {
        let model = Model::of_text(text, &[], Some(4.0)).expect("a model");
        let mut jumps = Jumps::new(&model).expect("one unknown");
        let found = ways.iter().map(|[a, b]| jumps.between((*a, &[v[0]]), (*b, &[v[1]])).map(|jump| jump.size()));
        found.collect()
    }

    /// By its own size: 1 beside a smooth component of 10⁵ that turns on the way, by 150 in the first half and by a third of that in the second.
    #[test]
    fn a_jump_is_found_beside_a_larger_component() {
        let f = "1000000*(t - 0.5125)*(t - 0.5125), heaviside(t - 0.5133)";
        let model = Model::of_text(&format!("u_i {{ x = 0, y = 0 }} F_i {{ {f} }}"), &[], Some(4.0)).expect("a model");
        let mut jumps = Jumps::new(&model).expect("two unknowns");
        jumps.start(0.0, &[0.0; 2]);
        let jump = jumps.between((0.5, &[0.0; 2]), (0.52, &[0.0; 2])).expect("it jumps");
        assert!(jump.component == 1 && (jump.size() - 1.0).abs() < 1e-12, "{}", jump.size());
    }

    /// x² − y² vanishes where x = y, but for a rounding of y.
    #[test]
    fn roundings_of_what_cancels_are_no_jump() {
        let model = Model::of_text("u_i { x = 0.7, y = 0.7 } F_i { -x, x*x - y*y }", &[], Some(4.0)).expect("a model");
        let mut jumps = Jumps::new(&model).expect("two unknowns");
        assert_eq!(jumps.between((0.9, &[0.7; 2]), (1.0, &[0.7, 0.7_f64.next_up()])), None);
        assert!(jumps.largest[1] > 0.0, "it does not vanish");
    }

    /// What f changes by in a step is compared with what it changed by in the last one.
    #[test]
    fn a_step_may_hold_a_jump_where_f_changes_by_more_than_in_the_last() {
        let model =
            Model::of_text("u_i { x = 0 } F_i { t + heaviside(t - 0.35) + heaviside(t - 0.45) }", &[], Some(4.0))
                .expect("a model");
        let mut jumps = Jumps::new(&model).expect("one unknown");
        jumps.start(0.0, &[0.0]);
        let mut may = |k: u32| jumps.may_be_before(0.1 * f64::from(k), &[0.0]);
        // The first, of which nothing is known, the one with a jump, and not the next, whose change is no larger.
        assert_eq!([1, 2, 3, 4, 5, 6].map(&mut may), [true, false, false, true, false, false]);
        jumps.start(0.3, &[0.0]);
        assert!(jumps.may_be_before(0.4, &[0.0]));
        // Of a start nothing is known either.
        jumps.start(0.4, &[0.0]);
        assert!(jumps.may_be_before(0.5, &[0.0]));
    }

    #[test]
    fn jumps_of_a_run_add_up_however_far_apart_its_states_are() {
        let f = "-c + 0.3*heaviside(t - 0.12587) - 0.1*heaviside(t - 2.5)";
        let model = Model::of_text(&format!("u_i {{ c = 0.5 }} F_i {{ {f} }}"), &[], Some(4.0)).expect("a model");
        let found = Jumps::new(&model).expect("one unknown").sum(&[0.0, 2.0, 4.0], &[vec![0.5], vec![0.3], vec![0.2]]);
        assert!((found - 0.4).abs() < 1e-3, "{found}");
    }

    #[test]
    fn a_jump_in_time_or_at_a_place_is_told_from_what_changes_by_little_parts() {
        let in_time =
            jumps("u_i { c = 0.5 } F_i { -c + 0.3*heaviside(t - 2.8) }", &[[2.7, 2.9], [2.81, 3.0]], [0.5, 0.5]);
        assert!(in_time[0].is_some_and(|size| (size - 0.3).abs() < 1e-12) && in_time[1].is_none(), "{in_time:?}");
        let at_a_place = jumps("u_i { c = 0.5 } F_i { -c + 2*heaviside(c - 0.55) }", &[[0.0, 0.1]], [0.5, 0.6]);
        assert!(at_a_place[0].is_some_and(|size| (size - 2.0).abs() < 1e-3), "{at_a_place:?}");
        for smooth in ["-c", "sin(50*t)", "max(c - 0.55, 0.0)", "tanh(100*(t - 0.05))", "1.0"] {
            let found =
                jumps(&format!("u_i {{ c = 0.5 }} F_i {{ {smooth} }}"), &[[0.0, 0.1], [0.01, 0.03]], [0.5, 0.6]);
            assert_eq!(found, [None, None], "{smooth}");
        }
    }
}
