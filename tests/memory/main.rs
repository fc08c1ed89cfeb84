//! How much memory is used, by a counting allocator, which has to be that of the whole process.

mod allocation;
mod planes;
mod streaming;

use std::alloc::System;
use std::sync::{Mutex, MutexGuard, PoisonError};

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};

#[global_allocator]
static COUNTING: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Waits until no other test allocates, and keeps the others waiting for as long as it lives.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    // A test that failed leaves nothing behind that would matter to the next.
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}
