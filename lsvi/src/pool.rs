//! Work space behind a shared reference.

use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Work space that is lent for one evaluation at a time, so that what evaluates with it can be shared between threads.
///
/// As much is kept as was in use at once; after the first evaluation nothing is allocated. It is boxed, as it may be some hundred
/// bytes, which would be moved twice for each evaluation.
pub(crate) struct Pool<T> {
    free: Mutex<Vec<Box<T>>>,
    make: Box<dyn Fn() -> T + Send + Sync>,
}

impl<T> Pool<T> {
    pub(crate) fn new(make: impl Fn() -> T + Send + Sync + 'static) -> Self {
        Self { free: Mutex::new(vec![Box::new(make())]), make: Box::new(make) }
    }

    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let mut lent = self.lend();
        let result = work(&mut lent);
        self.take_back(lent);
        result
    }

    // Not inlined: what evaluates with a pool is compiled for every field.
    #[inline(never)]
    fn lend(&self) -> Box<T> {
        let lent = self.free().pop();
        lent.unwrap_or_else(|| Box::new((self.make)()))
    }

    #[inline(never)]
    fn take_back(&self, lent: Box<T>) {
        self.free().push(lent);
    }

    fn free(&self) -> MutexGuard<'_, Vec<Box<T>>> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> fmt::Debug for Pool<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Pool")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn as_much_is_kept_as_was_in_use_at_once() {
        let made = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&made);
        let pool = Pool::new(move || counted.fetch_add(1, Ordering::Relaxed));
        for _ in 0..3 {
            pool.with(|one| pool.with(|other| assert_ne!(one, other)));
            assert_eq!(made.load(Ordering::Relaxed), 2);
        }
    }
}
