//! What a step costs, beside a hand-written loop for the same equations.
//!
//! Both are run in turn, so that whatever else the machine does meets both, and timed by the CPU time of the process. A case
//! counts its time per step, that of a band per step and cell, as the median over the rounds.

mod hand_written;
mod instructions;
mod kernel;
mod peers;

use std::path::PathBuf;
use std::time::Duration;

use cpu_time::ProcessTime;
use lsvi::{InputError, StepError};

pub use instructions::{Count, instructions, run_counted};
pub use kernel::all;
pub use peers::{AtEqualError, Other, beside_peers};

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
    prepare: Box<dyn Fn() -> Result<Kernel, InputError>>,
}

/// The two of a [`Case`], ready to be run.
struct Kernel {
    ours: Box<dyn FnMut() -> Result<Vec<f64>, StepError>>,
    by_hand: Box<dyn FnMut() -> Vec<f64>>,
}

/// One of the two of a [`Case`]: the library, or the loop written by hand.
#[derive(Debug, Clone, Copy)]
enum Side {
    Ours,
    ByHand,
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
    Input(#[from] InputError),
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
    /// There is no valgrind to count with.
    #[error("instructions are counted by valgrind, which cannot be run; on Debian: apt-get install valgrind")]
    Valgrind(#[source] std::io::Error),
    /// There is no place for what it counts.
    #[error("no temporary directory for what valgrind counts")]
    Counts(#[source] std::io::Error),
    /// Cargo, which builds and runs the program that compares with other solvers, cannot be started.
    #[error("cargo cannot be started, which builds {}: {source}", manifest.display())]
    Cargo {
        /// The manifest of the program.
        manifest: PathBuf,
        /// Why it was not started.
        source: std::io::Error,
    },
    /// There is no such program in this workspace.
    #[error("there is no {}: run it in a clone of lsvi", .0.display())]
    NoPeers(PathBuf),
    /// The program did not run to its end; it has said why.
    #[error("{} did not run to its end", .0.display())]
    Peers(PathBuf),
    /// Its table is not what it is to be.
    #[error("the table of {} cannot be read: {said}", manifest.display())]
    PeersTable {
        /// Its manifest.
        manifest: PathBuf,
        /// What is wrong with it.
        said: String,
    },
    /// It counted nothing.
    #[error("valgrind counted no instructions of {case}; it says: {said}")]
    Uncounted {
        /// Name of the case.
        case: String,
        /// The end of its output.
        said: String,
    },
}

/// Time that one run of a round is to take at least, so that the clock's resolution does not matter.
const LONG_ENOUGH: Duration = Duration::from_millis(2);

impl Case {
    /// Median times over so many rounds, each of which runs both.
    ///
    /// # Errors
    /// [`BenchError`] if a step fails or the results differ.
    pub fn measure(&self, rounds: usize) -> Result<Cost, BenchError> {
        let mut kernel = (self.prepare)()?;
        self.compare(&mut kernel)?;
        let repeats = kernel.repeats()?;
        let (mut ours, mut limit) = (Vec::new(), Vec::new());
        for _ in 0..rounds {
            for (side, times) in [(Side::Ours, &mut ours), (Side::ByHand, &mut limit)] {
                let start = ProcessTime::now();
                kernel.run(side, repeats)?;
                times.push(start.elapsed());
            }
        }
        Ok(Cost { ours: self.per_item(ours, repeats), limit: self.per_item(limit, repeats) })
    }

    /// Nanoseconds of an item, from the times of rounds of so many runs.
    fn per_item(&self, times: Vec<Duration>, repeats: u32) -> f64 {
        median(times).as_secs_f64() * 1e9 / (f64::from(repeats) * self.items)
    }

    /// Refuses figures of two different computations.
    fn compare(&self, kernel: &mut Kernel) -> Result<(), BenchError> {
        let (ours, by_hand) = ((kernel.ours)()?, (kernel.by_hand)());
        let difference = ours.iter().zip(&by_hand).fold(0.0_f64, |most, (a, b)| {
            let difference = (a - b).abs();
            if difference > most || difference.is_nan() { difference } else { most }
        });
        if difference <= self.rounding && ours.len() == by_hand.len() {
            return Ok(());
        }
        Err(BenchError::Different { case: self.name.clone(), difference, rounding: self.rounding })
    }
}

impl Kernel {
    fn run(&mut self, side: Side, times: u32) -> Result<(), StepError> {
        for _ in 0..times {
            match side {
                Side::Ours => drop(std::hint::black_box((self.ours)()?)),
                Side::ByHand => drop(std::hint::black_box((self.by_hand)())),
            }
        }
        Ok(())
    }

    /// Runs that take [`LONG_ENOUGH`] by hand.
    fn repeats(&mut self) -> Result<u32, BenchError> {
        let mut repeats = 1;
        loop {
            let start = ProcessTime::now();
            self.run(Side::ByHand, repeats)?;
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
            prepare: Box::new(move || {
                Ok(Kernel {
                    ours: Box::new(move || Ok(vec![1.0, ours])),
                    by_hand: Box::new(move || vec![1.0, by_hand]),
                })
            }),
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

    #[test]
    fn a_cost_is_the_median_of_the_rounds_over_their_runs_and_the_items_of_a_run() {
        let times = [9, 1, 2].map(Duration::from_millis).to_vec();
        let cost = |items: f64| Case { items, ..case(2.0, 2.0) }.per_item(times.clone(), 4);
        approx::assert_relative_eq!(cost(1.0), 5e5, max_relative = 1e-12);
        approx::assert_relative_eq!(cost(1000.0), 500.0, max_relative = 1e-12);
    }
}
