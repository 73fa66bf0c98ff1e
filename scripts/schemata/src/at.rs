//! Part of an instrumented copy: tells each place which of its mutants is active.

use std::io::Write;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

const UNREAD: u32 = u32::MAX;
const COVERING: u32 = u32::MAX - 1;
static ACTIVE: AtomicU32 = AtomicU32::new(UNREAD);
static IS_COVERED: [AtomicBool; 1 << 16] = [const { AtomicBool::new(false) }; 1 << 16];

/// Which of the mutants `first`, `first + 1`, … of a place is active, from 1 on; 0 for none.
#[inline(always)]
pub(crate) fn at(first: u32, mutants: u32) -> u32 {
    let active = ACTIVE.load(Relaxed);
    if active >= COVERING {
        return read_or_cover(first, mutants);
    }
    let k = active.wrapping_sub(first);
    if k < mutants { k + 1 } else { 0 }
}

#[cold]
#[inline(never)]
fn read_or_cover(first: u32, mutants: u32) -> u32 {
    let cover = || std::env::var_os("SCHEMATA_COVER");
    if ACTIVE.load(Relaxed) == UNREAD {
        let chosen = std::env::var("SCHEMATA").ok().and_then(|id| id.parse().ok()).unwrap_or(0);
        ACTIVE.store(if cover().is_some() { COVERING } else { chosen }, Relaxed);
    }
    // Another thread may have read it meanwhile.
    if ACTIVE.load(Relaxed) != COVERING {
        return at(first, mutants);
    }
    if !IS_COVERED[first as usize].swap(true, Relaxed) {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(cover().unwrap());
        file.unwrap().write_all(&first.to_le_bytes()).unwrap();
    }
    0
}
