//! Work space behind a shared reference.

use std::fmt;
use std::sync::{Mutex, PoisonError};

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
        let free = || self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let lent = free().pop();
        let mut lent = lent.unwrap_or_else(|| Box::new((self.make)()));
        let result = work(&mut lent);
        free().push(lent);
        result
    }
}

impl<T> fmt::Debug for Pool<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Pool")
    }
}
