//! Where f jumps, between two states of a run.

use super::Problem;

/// Halvings of the way between two states after which a jump is still there, and what is smooth a thousandth of what it was.
const HALVINGS: u32 = 10;
/// Part of a change of f that a jump is at least, of all of the way and of the last part of it.
const MOST: f64 = 0.9;
const REST: f64 = 0.5;
/// Parts of a way between states that are far apart, on each of which what is smooth changes by little beside a jump.
const PARTS: u32 = 64;
/// Part of the largest value of a component of f below which a change of it is none: rounding does not get less with the way.
const NOISE: f64 = 1e-9;

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
    problem: &'a dyn Problem,
    /// The largest value of each component of f so far.
    largest: Vec<f64>,
}

impl<'a> Jumps<'a> {
    /// For runs of `problem`.
    #[must_use]
    pub fn new(problem: &'a dyn Problem) -> Self {
        Self { problem, largest: vec![0.0; problem.field().dim()] }
    }

    /// f at (t, v), of a state that has its unknowns.
    pub fn f(&mut self, t: f64, v: &[f64]) -> Option<Vec<f64>> {
        let mut f = vec![0.0; self.largest.len()];
        (v.len() == f.len()).then(|| self.problem.field().rhs(t, v, &mut f))?;
        self.largest.iter_mut().zip(&f).for_each(|(largest, f)| *largest = largest.max(f.abs()));
        Some(f)
    }

    /// The component that jumps most for its size between two states; none where f changes by little parts.
    pub fn between(&mut self, from: (f64, &[f64]), to: (f64, &[f64])) -> Option<Jump> {
        let at = |s: f64| -> (f64, Vec<f64>) {
            let v = from.1.iter().zip(to.1).map(|(a, b)| a + s * (b - a)).collect();
            (from.0 + s * (to.0 - from.0), v)
        };
        let (middle, v) = at(0.5);
        let (first, half, last) = (self.f(from.0, from.1)?, self.f(middle, &v)?, self.f(to.0, to.1)?);
        let changes = (0..first.len()).map(|k| {
            let change = |a: &[f64], b: &[f64]| (b[k] - a[k]).abs() / self.largest[k].max(f64::MIN_POSITIVE);
            (k, change(&first, &half), change(&half, &last), change(&first, &last))
        });
        let is_jump = |(_, a, b, all): &(usize, f64, f64, f64)| a.max(*b) >= MOST * all && a.max(*b) > NOISE;
        let (component, a, b, _) = changes.filter(is_jump).max_by(|x, y| x.1.max(x.2).total_cmp(&y.1.max(y.2)))?;
        let (mut way, mut sides) = if a >= b {
            ([0.0, 0.5], [first[component], half[component]])
        } else {
            ([0.5, 1.0], [half[component], last[component]])
        };
        let whole = sides[1] - sides[0];
        for _ in 1..HALVINGS {
            let middle = 0.5 * (way[0] + way[1]);
            let (t, v) = at(middle);
            let value = self.f(t, &v)?[component];
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
            let at = |k: u32| -> (f64, Vec<f64>) {
                let s = f64::from(k) / f64::from(PARTS);
                (t[0] + s * (t[1] - t[0]), v[0].iter().zip(&v[1]).map(|(a, b)| a + s * (b - a)).collect())
            };
            for part in 0..PARTS {
                let [from, to] = [at(part), at(part + 1)];
                sum += self.between((from.0, &from.1), (to.0, &to.1)).map_or(0.0, |jump| jump.size());
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::model::Model;

    fn jumps(text: &str, ways: &[[f64; 2]], v: [f64; 2]) -> Vec<Option<f64>> {
        let file = tempfile::NamedTempFile::with_suffix(".ds").expect("a file");
        std::fs::write(file.path(), text).expect("written");
        let model = Model::load(file.path(), &[], Some(4.0)).expect("a model");
        let mut jumps = Jumps::new(&model);
        let found = ways.iter().map(|[a, b]| jumps.between((*a, &[v[0]]), (*b, &[v[1]])).map(|jump| jump.size()));
        found.collect()
    }

    #[test]
    fn jumps_of_a_run_add_up_however_far_apart_its_states_are() {
        let file = tempfile::NamedTempFile::with_suffix(".ds").expect("a file");
        let f = "-c + 0.3*heaviside(t - 0.12587) - 0.1*heaviside(t - 2.5)";
        std::fs::write(file.path(), format!("u_i {{ c = 0.5 }} F_i {{ {f} }}")).expect("written");
        let model = Model::load(file.path(), &[], Some(4.0)).expect("a model");
        let found = Jumps::new(&model).sum(&[0.0, 2.0, 4.0], &[vec![0.5], vec![0.3], vec![0.2]]);
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
