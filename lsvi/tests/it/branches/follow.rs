//! The root of a scalar equation that is continuous in the step size, found without any derivative.

/// Where a branch of roots leads.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Followed {
    /// To this root at the full step.
    To(f64),
    /// It ends in a fold, or at infinity, before.
    Lost,
    /// It passes closer to another branch than double precision tells apart.
    Undecided,
}

/// Follows the root x of `g`(s, x) = 0 from (0, `start`) to s = `h`, in pieces so short that on each of them `g` is monotone
/// in x around the root.
pub(crate) fn follow(g: impl Fn(f64, f64) -> f64, start: f64, h: f64) -> Followed {
    const LOST: f64 = 1e-9;
    let (mut s, mut x) = (0.0, start);
    let (mut ds, mut width) = (1e-4 * h, 1e-2 * start.abs());
    for _ in 0..100_000 {
        if s >= h {
            return Followed::To(x);
        }
        let next = (s + ds).min(h);
        if !monotone(&g, [s, 0.5 * (s + next), next], x, width) {
            // On the way to a fold the branch has the distance √ds from the other one.
            width *= 0.5_f64.sqrt();
            ds *= 0.5;
        } else if let Some(root) = root_near(&g, next, x, width).filter(|root| (root - x).abs() <= 0.25 * width) {
            (s, x) = (next, root);
            ds = (1.5 * ds).min(0.01 * h.max(s));
            width = (1.5_f64.sqrt() * width).min(0.05 * x.abs().max(1e-3 * start.abs()));
        } else {
            ds *= 0.5;
        }
        if x.abs() > 1e9 * start.abs() {
            return Followed::Lost;
        }
        if ds < LOST * s.max(1e-6 * h) {
            return if s < (1.0 - 1e-6) * h { Followed::Lost } else { Followed::Undecided };
        }
    }
    Followed::Undecided
}

/// Whether `g` rises, or falls, on all samples of [x − width, x + width] at each of the step sizes.
fn monotone(g: &impl Fn(f64, f64) -> f64, steps: [f64; 3], x: f64, width: f64) -> bool {
    const SAMPLES: i32 = 4;
    let direction = |s: f64| {
        let mut before = g(s, x - width);
        let slopes = (1 - SAMPLES..=SAMPLES).map(|k| {
            let value = g(s, x + width * f64::from(k) / f64::from(SAMPLES));
            (value - std::mem::replace(&mut before, value)).signum()
        });
        slopes.reduce(|a, b| if a == b { a } else { f64::NAN }).unwrap_or(f64::NAN)
    };
    let first = direction(steps[0]);
    first == direction(steps[1]) && first == direction(steps[2])
}

/// The only root between x − width and x + width, by the rule of false position; an end that stays counts half (Dowell and Jarratt's
/// Illinois algorithm).
fn root_near(g: &impl Fn(f64, f64) -> f64, s: f64, x: f64, width: f64) -> Option<f64> {
    // Of the width, far below what a piece of the branch is told from its neighbours by; a dozen evaluations come to that.
    const TOLERANCE: f64 = 1e-10;
    const MOST: u32 = 100;
    let (mut a, mut b) = (x - width, x + width);
    let (mut at_a, mut at_b) = (g(s, a), g(s, b));
    if at_a.signum() == at_b.signum() {
        return None;
    }
    for _ in 0..MOST {
        let next = b - at_b * (b - a) / (at_b - at_a);
        let at_next = g(s, next);
        let moved = (next - b).abs();
        if at_next.signum() == at_b.signum() {
            at_a *= 0.5
        } else {
            (a, at_a) = (b, at_b)
        }
        (b, at_b) = (next, at_next);
        if at_b == 0.0 || moved <= TOLERANCE * width {
            return Some(b);
        }
    }
    None
}
