//! How long a run has to be to show what a solution does.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use super::adaptive;
use crate::names::NameError;
use crate::problem::Problem;
use crate::run::run_while;

/// The direction of the motion turns by 2π or more on any closed curve (Fenchel), and by twice that on two of them.
const TURNING: f64 = 2.0 * TAU;
/// How many times longer than the problem's own a run may be.
const LONGER: f64 = 32.0;
/// Longest run that is followed to see it, in steps, and unknowns of the largest system.
const STEPS: usize = 4096;
const LARGEST: usize = 200;
/// A motion this much slower than at its fastest has come to rest: its direction is rounding.
const REST: f64 = 1e-3;

/// The time by which the solution of `problem` has turned twice, to two digits; the problem's own horizon where that is later, or
/// where it comes to rest, cannot be followed, or does not turn within 32 of these.
///
/// # Errors
/// [`NameError`] if the method that follows it is not registered, which is a mistake of this program.
pub fn duration(problem: &dyn Problem) -> Result<f64, NameError> {
    let (own, field) = (problem.horizon(), problem.field());
    if field.dim() > LARGEST {
        return Ok(own);
    }
    let (mut turning, mut fastest, mut steps) = (0.0, 0.0_f64, 0);
    let (mut rate, mut before) = (vec![0.0; field.dim()], None);
    let mut turned = None;
    // A solution that cannot be followed has not turned.
    let _ = run_while(problem, &*adaptive(1e-4)?, own / 4.0, LONGER * own, |state| {
        if state.q.len() != rate.len() {
            return ControlFlow::Break(());
        }
        field.rhs(state.t, &state.q, &mut rate);
        let size = rate.iter().map(|x| x * x).sum::<f64>().sqrt();
        fastest = fastest.max(size);
        steps += 1;
        // NaN is no motion.
        if size.is_nan() || size <= REST * fastest || steps > STEPS {
            return ControlFlow::Break(());
        }
        let direction: Vec<f64> = rate.iter().map(|x| x / size).collect();
        turning += before.replace(direction.clone()).map_or(0.0, |before: Vec<f64>| {
            let cosine: f64 = before.iter().zip(&direction).map(|(a, b)| a * b).sum();
            cosine.clamp(-1.0, 1.0).acos().min(PI)
        });
        if turning < TURNING {
            return ControlFlow::Continue(());
        }
        turned = Some(state.t);
        ControlFlow::Break(())
    });
    let unit = |t: f64| 10_f64.powf(t.log10().floor() - 1.0);
    Ok(match turned {
        Some(t) if t > own => (t / unit(t)).ceil() * unit(t),
        _ => own,
    })
}
