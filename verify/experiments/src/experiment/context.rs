//! What was found so far, and where progress is reported.

use std::any::Any;
use std::collections::HashMap;
use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, available_parallelism};

use super::{Experiment, ExperimentError, StudyError};

/// Where experiments are kept once they are carried out, how much they may compute, and a place to report progress.
pub struct Context<'a> {
    announce: &'a (dyn Fn(u64) + Sync),
    tick: &'a (dyn Fn() + Sync),
    max_steps: u64,
    found: Mutex<HashMap<(&'static str, String), Arc<Entry>>>,
}

type Found = Arc<dyn Any + Send + Sync>;
type Entry = OnceLock<Result<Found, ExperimentError>>;

fn failed(id: &'static str, source: StudyError) -> ExperimentError {
    ExperimentError { id, source: source.into() }
}

impl<'a> Context<'a> {
    /// Calls `announce` with a number of pieces of work that are about to be done, and `tick` after each of them. Runs of more
    /// than `max_steps` steps are left out.
    pub fn new(announce: &'a (dyn Fn(u64) + Sync), tick: &'a (dyn Fn() + Sync), max_steps: u64) -> Self {
        Self { announce, tick, max_steps, found: Mutex::default() }
    }
}

impl Context<'static> {
    /// Reports nothing.
    #[must_use]
    pub fn silent() -> Self {
        Self::new(&|_| {}, &|| {}, u64::MAX)
    }

    /// Reports nothing, and leaves out what takes long.
    #[must_use]
    pub fn quick() -> Self {
        Self::new(&|_| {}, &|| {}, 20_000)
    }
}

impl Context<'_> {
    /// What `experiment` finds, carried out unless that was done before. Whoever asks while it is running waits.
    ///
    /// Not from inside a parallel iterator: a thread of the pool that waits here may be the one that the experiment waits for.
    ///
    /// # Errors
    /// What stopped the experiment, the first time and ever after; asking from inside a parallel iterator.
    pub fn get<E: Experiment>(&self, experiment: E) -> Result<Arc<E::Found>, ExperimentError> {
        let measure = || -> Result<Found, StudyError> { Ok(Arc::new(experiment.measure(self)?)) };
        let two = |_| failed(E::ID, format!("two experiments are called `{}`", E::ID).into());
        self.kept(E::ID, format!("{experiment:?}"), &measure)?.downcast().map_err(two)
    }

    /// What is kept of an experiment by its name and setting, or else what `measure` finds. Compiled once for all of them.
    fn kept(
        &self,
        id: &'static str,
        setting: String,
        measure: &dyn Fn() -> Result<Found, StudyError>,
    ) -> Result<Found, ExperimentError> {
        if rayon::current_thread_index().is_some() {
            return Err(failed(id, "asked for from inside a parallel iterator".into()));
        }
        let key = (id, setting);
        let entry = self.found.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default().clone();
        entry.get_or_init(|| measure().map_err(|source| failed(id, source))).clone()
    }

    /// [`get`](Self::get) for several, side by side.
    ///
    /// # Errors
    /// The first of them.
    pub fn get_each<E: Experiment>(&self, experiments: Vec<E>) -> Result<Vec<Arc<E::Found>>, ExperimentError> {
        side_by_side(experiments, |experiment| self.get(experiment)).into_iter().collect()
    }

    /// Says that `count` pieces of work are about to be done.
    pub fn announce(&self, count: usize) {
        (self.announce)(count as u64);
    }

    /// Says that one of them is done.
    pub fn tick(&self) {
        (self.tick)();
    }

    /// Runs of more steps than this are left out.
    #[must_use]
    pub fn max_steps(&self) -> u64 {
        self.max_steps
    }
}

/// `f` of all `items`, in their order, by as many threads as there are processors. They are not those of rayon's pool, so that
/// one may wait for what another is computing.
pub fn side_by_side<T: Send, U: Send>(items: Vec<T>, f: impl Fn(T) -> U + Sync) -> Vec<U> {
    let items: Vec<_> = items.into_iter().map(|item| Mutex::new((Some(item), None))).collect();
    by_threads(items.len(), &|index| {
        let item = items[index].lock().unwrap_or_else(PoisonError::into_inner).0.take();
        let result = item.map(&f);
        items[index].lock().unwrap_or_else(PoisonError::into_inner).1 = result;
    });
    items.into_iter().filter_map(|item| item.into_inner().unwrap_or_else(PoisonError::into_inner).1).collect()
}

/// `work` on each of `count` numbers. Compiled once for whatever the work is.
fn by_threads(count: usize, work: &(dyn Fn(usize) + Sync)) {
    let next = AtomicUsize::new(0);
    let all = || {
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        numbers.take_while(|index| *index < count).for_each(work);
    };
    let threads = available_parallelism().map_or(1, NonZero::get);
    thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(all)).collect();
        running.into_iter().for_each(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
    });
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use rayon::prelude::*;

    use super::*;

    static RUNS: AtomicU64 = AtomicU64::new(0);

    #[derive(Debug)]
    struct Slow {
        h: f64,
        fails: bool,
    }

    impl Experiment for Slow {
        const ID: &'static str = "slow";
        type Found = Vec<f64>;
        fn measure(&self, context: &Context) -> Result<Self::Found, StudyError> {
            RUNS.fetch_add(1, Ordering::SeqCst);
            context.announce(64);
            if self.fails {
                return Err("no luck".into());
            }
            Ok((0..64).into_par_iter().map(|_| self.h).inspect(|_| context.tick()).collect())
        }
    }

    #[derive(Debug)]
    struct SameName;

    impl Experiment for SameName {
        const ID: &'static str = "same";
        type Found = u8;
        fn measure(&self, _: &Context) -> Result<u8, StudyError> {
            Ok(1)
        }
    }

    mod other {
        use super::*;
        #[derive(Debug)]
        pub(super) struct SameName;
        impl Experiment for SameName {
            const ID: &'static str = "same";
            type Found = String;
            fn measure(&self, _: &Context) -> Result<String, StudyError> {
                Ok(String::new())
            }
        }
    }

    #[test]
    fn an_experiment_is_carried_out_once_whoever_asks_and_shares_its_error() {
        let (announced, ticks) = (AtomicU64::new(0), AtomicU64::new(0));
        let announce = |n| {
            announced.fetch_add(n, Ordering::SeqCst);
        };
        let tick = || {
            ticks.fetch_add(1, Ordering::SeqCst);
        };
        let context = Context::new(&announce, &tick, 7);
        assert_eq!(context.max_steps(), 7);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for h in [0.1, 0.1 + 1e-16, 0.1 + 1e-18] {
                        assert_eq!(context.get(Slow { h, fails: false }).expect("works")[0].to_bits(), h.to_bits());
                    }
                    let error = context.get(Slow { h: 0.1, fails: true }).expect_err("fails");
                    assert_eq!(error.to_string(), "experiment `slow`: no luck");
                });
            }
        });
        // 0.1 + 1e-18 is 0.1.
        assert_eq!(RUNS.load(Ordering::SeqCst), 3);
        assert_eq!((announced.load(Ordering::SeqCst), ticks.load(Ordering::SeqCst)), (192, 128));
    }

    #[test]
    fn experiments_that_read_each_other_run_side_by_side() {
        #[derive(Debug)]
        struct Sum(usize);
        impl Experiment for Sum {
            const ID: &'static str = "sum";
            type Found = usize;
            fn measure(&self, context: &Context) -> Result<usize, StudyError> {
                let below: Vec<_> = (0..self.0).map(Sum).collect();
                Ok(1 + context.get_each(below)?.iter().map(|found| **found).sum::<usize>())
            }
        }
        assert_eq!(*Context::silent().get(Sum(10)).expect("no circle"), 1024);
    }

    #[test]
    fn what_could_wait_for_itself_is_refused() {
        let context = Context::silent();
        let asked: Vec<_> = [0; 2].par_iter().map(|_| context.get(SameName).is_err()).collect();
        assert_eq!(asked, [true, true]);
    }

    #[test]
    fn two_experiments_of_one_name_are_refused() {
        let context = Context::silent();
        assert_eq!(context.get(SameName).map_err(|error| error.to_string()).as_deref(), Ok(&1));
        let error = context.get(other::SameName).expect_err("another type");
        assert!(error.to_string().contains("two experiments"), "{error}");
    }
}
