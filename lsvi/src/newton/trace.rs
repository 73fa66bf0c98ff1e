//! A root followed back to where a step begins, of equations that determine no branch for h → 0.

use super::{Newton, SURE_CONTRACTION, System, difference};
use crate::error::SolveError;

/// The next step size beside the last one.
const SHORTER: f64 = 0.5;
/// How far a root may be from where the line through the last two leads, in terms of how far it is from the origin: another branch is further away.
const BESIDE: f64 = 0.1;
/// How near to the origin the line leads, in the same terms.
const NEAR: f64 = 0.02;
/// The least that the next one may be shorter by.
const LEAST: f64 = 1e-6;
/// Roots that are looked for on the way back, those that are too far off included: a branch of rate λ begins after log₂(hλ) of them.
const ROOTS: u32 = 200;

impl Newton {
    /// Replaces `x`, a first guess, by a root at `h` on a branch that begins at the origin: the one that Newton's iteration finds, or else the one that
    /// pieces of h lead to.
    pub(crate) fn solve_traced(&mut self, system: &mut dyn System, h: f64, x: &mut [f64]) -> Result<(), SolveError> {
        self.solve(system, h, x)?;
        if self.comes_from_origin(system, h, x) {
            return Ok(());
        }
        // The first guess.
        x.copy_from_slice(&self.start);
        self.guess.copy_from_slice(&self.start);
        self.origin.copy_from_slice(&self.start);
        system.origin(&mut self.origin);
        self.follow_branch(system, h, x, SolveError::OtherBranch)?;
        if self.comes_from_origin(system, h, x) { Ok(()) } else { Err(SolveError::OtherBranch) }
    }

    /// Whether the branch on which `x`, a root at step size `h`, lies begins at the origin: whether x goes there in proportion to h, as far as two
    /// lines through neighbours tell. The determinant keeps its sign on a branch without a fold.
    fn comes_from_origin(&mut self, system: &mut dyn System, h: f64, x: &[f64]) -> bool {
        self.origin.copy_from_slice(x);
        system.origin(&mut self.origin);
        if self.set_increment(system, h, x).is_err() {
            return false;
        }
        let sign = self.lu.sign();
        let [mut later, mut now, mut next] = std::mem::take(&mut self.traced);
        for point in [&mut later, &mut now, &mut next] {
            point.clear();
            point.extend_from_slice(x);
        }
        let comes = self.follow_back(system, h, sign, [&mut later, &mut now, &mut next]);
        self.traced = [later, now, next];
        comes
    }

    /// The same for three copies of the root, and the sign of the determinant there.
    fn follow_back(
        &mut self,
        system: &mut dyn System,
        h: f64,
        sign: f64,
        [mut later, mut now, mut next]: [&mut Vec<f64>; 3],
    ) -> bool {
        // Step sizes of `later` and `now`.
        let (mut after, mut at, mut part) = (f64::INFINITY, h, SHORTER);
        let mut leads = 0;
        for _ in 0..ROOTS {
            if difference(now, 1.0, &self.origin) <= self.roundoff() {
                return true;
            }
            let target = part * at;
            // The line through the last two.
            let slope = if after.is_finite() { (at - target) / (after - at) } else { 0.0 };
            next.iter_mut()
                .zip(now.iter().zip(&*later))
                .for_each(|(next, (now, later))| *next = now + slope * (now - later));
            self.reference.copy_from_slice(next);
            let found = self.iterate(system, target, next, SURE_CONTRACTION);
            let way = difference(next, 1.0, &self.origin);
            let is_beside = difference(next, 1.0, &self.reference) <= BESIDE * way + self.roundoff();
            let keeps = found.is_ok()
                && is_beside
                && self.set_increment(system, target, next).is_ok()
                && self.lu.sign() == sign;
            if !keeps {
                part = part.sqrt();
                if 1.0 - part < LEAST {
                    return false;
                }
                continue;
            }
            (after, at, part) = (at, target, part.powi(2).max(SHORTER));
            std::mem::swap(&mut later, &mut now);
            std::mem::swap(&mut now, &mut next);
            // Where the line leads for h = 0.
            let slope = at / (after - at);
            let ends = now.iter().zip(&*later).map(|(now, later)| now + slope * (now - later));
            next.iter_mut().zip(ends).for_each(|(next, end)| *next = end);
            leads = if difference(next, 1.0, &self.origin) <= NEAR * way { leads + 1 } else { 0 };
            if leads == 2 {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Jacobian;

    /// x = b(h), with notes of where F is asked for.
    struct Branch<B> {
        origin: f64,
        b: B,
        notes: Vec<(f64, f64)>,
    }

    impl<B: Fn(f64) -> f64> System for Branch<B> {
        fn dim(&self) -> usize {
            1
        }
        fn residual(&mut self, h: f64, x: &[f64], out: &mut [f64]) {
            self.notes.push((h, x[0]));
            out[0] = x[0] - (self.b)(h);
        }
        fn derivative(&mut self, _: f64, _: &[f64], out: &mut Jacobian) {
            out.add(0, 0, 1.0);
        }
        fn origin(&self, x: &mut [f64]) {
            x[0] = self.origin;
        }
    }

    /// Whether b is found to begin at `origin`, and the step sizes that roots are looked for at on the way back from `h`, with the first guesses.
    fn followed(origin: f64, h: f64, b: impl Fn(f64) -> f64) -> (bool, Vec<(f64, f64)>) {
        let mut branch = Branch { origin, b, notes: Vec::new() };
        let x = [(branch.b)(h)];
        let comes = Newton::new(1).comes_from_origin(&mut branch, h, &x);
        let mut looks = branch.notes;
        looks.dedup_by_key(|(h, _)| *h);
        assert_eq!(looks.remove(0), (h, x[0]));
        (comes, looks)
    }

    /// Of x = 10 + 5h no root but that at h/⁸√2 is within a tenth of its way of the one at h, for 1 − 1/⁸√2 = 0.083. It is a second one on a line
    /// through the origin that tells, which is looked for at 1/∜2 of that, the square.
    #[test]
    fn roots_are_looked_for_where_the_line_through_the_last_two_leads() {
        let (h, line) = (3.0, |h: f64| 10.0 + 5.0 * h);
        let (comes, looks) = followed(10.0, h, line);
        let first = [0.5_f64, 0.25, 0.125].map(|exponent| (h * (-exponent).exp2(), line(h)));
        let second = h * (-0.375_f64).exp2();
        let expected: Vec<_> = [(0.5 * h, line(h))].into_iter().chain(first).chain([(second, line(second))]).collect();
        assert!(comes && looks.len() == expected.len(), "{looks:?}");
        for ((at, guess), (size, x)) in looks.into_iter().zip(expected) {
            approx::assert_relative_eq!(at, size, max_relative = 1e-15);
            // Roundings of the roots are extrapolated by less than twice what they are apart.
            approx::assert_relative_eq!(guess, x, max_relative = 1e-14);
        }
    }

    /// x = h + h²: a bend that only becomes straight on the way.
    #[test]
    fn a_branch_is_followed_in_the_same_steps_in_any_unit() {
        let sizes = |unit: f64| {
            let (comes, looks) = followed(0.0, 1.0, |h| unit * (h + h * h));
            assert!(comes, "{unit:e}");
            looks.into_iter().map(|(h, _)| h).collect::<Vec<_>>()
        };
        for exponent in [-30, 30] {
            assert_eq!(sizes(f64::from(exponent).exp2()), sizes(1.0), "{exponent}");
        }
    }

    /// Twelve roundings of the origin are no rest, and at h/2 six are.
    #[test]
    fn a_root_is_beside_the_line_to_a_few_roundings() {
        assert_eq!(
            followed(1.0, 1.0, |h| 1.0 + 12.0 * h * f64::EPSILON),
            (true, vec![(0.5, 1.0 + 12.0 * f64::EPSILON)])
        );
    }

    /// 1 − 2^(−1/2^k) is less than a millionth from 2^k = 2^20 > 10⁶ ln 2 on.
    #[test]
    fn a_branch_that_begins_at_the_root_is_given_up_within_a_millionth_of_the_step() {
        let (comes, looks) = followed(0.0, 1.0, |h| if h < 1.0 { 100.0 } else { 1.0 });
        assert!(!comes && looks.len() == 20, "{}", looks.len());
        assert!(looks.iter().all(|(h, guess)| (0.5..1.0).contains(h) && *guess == 1.0), "{looks:?}");
    }
}
