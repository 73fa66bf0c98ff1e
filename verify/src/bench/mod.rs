//! What a step costs, beside a hand-written loop for the same equations.
//!
//! Both are run in turn, so that whatever else the machine does meets both, and timed by the CPU time of the process. A case
//! counts its time per step, that of a band per step and cell, as the median over the rounds.

mod hand_written;
mod kernel;

use std::time::Duration;

use cpu_time::ProcessTime;
use lsvi::StepError;

pub use kernel::all;

/// A kernel of the library and a loop written by hand that computes the same.
pub struct Case {
    /// Name, for people and for `--only`.
    pub name: String,
    /// The time, in terms of that of the loop by hand, that is aimed at.
    pub wanted: f64,
    /// Steps of one run, times cells.
    items: f64,
    /// Largest difference of the two results, from rounding.
    rounding: f64,
    ours: Box<dyn FnMut() -> Result<Vec<f64>, StepError>>,
    by_hand: Box<dyn FnMut() -> Vec<f64>>,
}

/// What was measured of a [`Case`], in nanoseconds per step (and cell).
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// By the library.
    pub ours: f64,
    /// By the loop written by hand.
    pub limit: f64,
}

impl Cost {
    /// The library's time in terms of that of the loop by hand.
    pub fn ratio(self) -> f64 {
        self.ours / self.limit
    }
}

/// Why there is no figure.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// A kernel refuses its problem.
    #[error(transparent)]
    Input(#[from] lsvi::InputError),
    /// A step failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The two do not compute the same.
    #[error(
        "{case}: the library and the loop by hand differ by {difference:.1e}, more than their rounding of {rounding:.1e}"
    )]
    Different {
        /// Name of the case.
        case: String,
        /// Largest difference of a component.
        difference: f64,
        /// What rounding explains.
        rounding: f64,
    },
}

/// Time that one run of a round is to take at least, so that the clock's resolution does not matter.
const LONG_ENOUGH: Duration = Duration::from_millis(2);

impl Case {
    /// Median times over so many rounds, each of which runs both.
    ///
    /// # Errors
    /// [`BenchError`] if a step fails or the results differ.
    pub fn measure(&mut self, rounds: usize) -> Result<Cost, BenchError> {
        self.compare()?;
        let repeats = self.repeats()?;
        let (mut ours, mut limit) = (Vec::new(), Vec::new());
        for _ in 0..rounds {
            let start = ProcessTime::now();
            for _ in 0..repeats {
                std::hint::black_box((self.ours)()?);
            }
            ours.push(start.elapsed());
            let start = ProcessTime::now();
            for _ in 0..repeats {
                std::hint::black_box((self.by_hand)());
            }
            limit.push(start.elapsed());
        }
        let per_item = |times: Vec<Duration>| median(times).as_secs_f64() * 1e9 / (f64::from(repeats) * self.items);
        Ok(Cost { ours: per_item(ours), limit: per_item(limit) })
    }

    /// Refuses figures of two different computations.
    fn compare(&mut self) -> Result<(), BenchError> {
        let (ours, by_hand) = ((self.ours)()?, (self.by_hand)());
        let difference = ours.iter().zip(&by_hand).fold(0.0_f64, |most, (a, b)| {
            let difference = (a - b).abs();
            if difference > most || difference.is_nan() { difference } else { most }
        });
        if difference <= self.rounding && ours.len() == by_hand.len() {
            return Ok(());
        }
        Err(BenchError::Different { case: self.name.clone(), difference, rounding: self.rounding })
    }

    /// Runs that take [`LONG_ENOUGH`] by hand.
    fn repeats(&mut self) -> Result<u32, BenchError> {
        let mut repeats = 1;
        loop {
            let start = ProcessTime::now();
            for _ in 0..repeats {
                std::hint::black_box((self.by_hand)());
            }
            if start.elapsed() >= LONG_ENOUGH || repeats >= 1 << 16 {
                return Ok(repeats);
            }
            repeats *= 2;
        }
    }
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(ours: f64, by_hand: f64) -> Case {
        Case {
            name: "numbers".into(),
            wanted: 1.0,
            items: 1.0,
            rounding: 1e-12,
            ours: Box::new(move || Ok(vec![1.0, ours])),
            by_hand: Box::new(move || vec![1.0, by_hand]),
        }
    }

    #[test]
    fn two_different_computations_have_no_figures() {
        assert!(case(2.0, 2.0).measure(1).is_ok());
        for (ours, by_hand) in [(2.0, 2.0 + 1e-11), (f64::NAN, 2.0), (2.0, f64::NAN)] {
            let measured = case(ours, by_hand).measure(1);
            assert!(matches!(measured, Err(BenchError::Different { .. })), "{ours} and {by_hand}: {measured:?}");
        }
    }
}
