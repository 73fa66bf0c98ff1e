//! Panics of code that is not ours, as errors.

use std::any::Any;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is caught, and told by who caught it.
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// What `run` gives, or the message of the panic that it ended in, which nothing prints.
///
/// # Errors
/// The message.
pub(crate) fn caught<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    // One hook for good, of which each thread has its own switch: to take it back would race with other threads.
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !IS_CAUGHT.get() {
                before(info);
            }
        }));
    });
    let outer = IS_CAUGHT.replace(true);
    let result = catch_unwind(AssertUnwindSafe(run));
    IS_CAUGHT.set(outer);
    result.map_err(|payload| message(&*payload).to_owned())
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or(payload.downcast_ref::<&str>().copied()).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_its_message_and_the_switch_is_back_afterwards() {
        assert_eq!(caught(|| 1), Ok(1));
        assert_eq!(caught(|| panic!("no {}", 2)), Err::<(), _>("no 2".into()));
        assert!(!IS_CAUGHT.get());
        // One inside of another leaves the outer one what it was.
        let inside = caught(|| (caught(|| panic!("inner")), IS_CAUGHT.get()));
        assert_eq!(inside, Ok((Err::<(), _>("inner".into()), true)));
        let other = std::thread::scope(|scope| caught(|| scope.spawn(|| IS_CAUGHT.get()).join().ok()));
        assert_eq!(other, Ok(Some(false)), "the switch of another thread");
    }
}
