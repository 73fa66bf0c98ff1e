//! No step allocates, and what a run holds in memory.

#[path = "../it/fields.rs"]
mod fields;
mod mechanics;
mod memory;
mod structured;
#[path = "../it/systems.rs"]
mod systems;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    /// Bytes that are allocated, and the most since they were counted anew; what another thread frees counts there.
    static BYTES: Cell<isize> = const { Cell::new(0) };
    static MOST: Cell<isize> = const { Cell::new(0) };
}

fn count_bytes(more: isize) {
    BYTES.set(BYTES.get() + more);
    MOST.set(MOST.get().max(BYTES.get()));
}

struct Counting;

// SAFETY: every call is passed on to the system's allocator unchanged; counting touches no memory that it manages.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        count_bytes(layout.size().cast_signed());
        // SAFETY: the caller upholds the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count_bytes(-layout.size().cast_signed());
        // SAFETY: `pointer` came from `System.alloc` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Allocations of ten calls, after one call that may set things up.
fn allocations(mut step: impl FnMut()) -> u64 {
    step();
    let before = ALLOCATIONS.get();
    (0..10).for_each(|_| step());
    ALLOCATIONS.get() - before
}

/// The most bytes that `run` holds at a time.
fn most_bytes(run: impl FnOnce()) -> isize {
    let before = BYTES.get();
    MOST.set(before);
    run();
    MOST.get() - before
}

#[test]
fn the_counters_count() {
    assert_eq!(most_bytes(|| drop((std::hint::black_box(vec![1.0; 3]), std::hint::black_box(vec![1.0; 5])))), 64);
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1.0]))), 10);
}
