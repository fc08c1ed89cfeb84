//! Threads: work that runs while the interpreter does other things.
//!
//! Each thread of the interpreter has threads of its own, which are kept for its next call. There is no pool that
//! all share: its threads would not be there after a fork, and what waits for them would wait forever.

use std::cell::RefCell;
use std::num::NonZero;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

thread_local! {
    static KEPT: RefCell<Option<Pool>> = const { RefCell::new(None) };
}

/// Threads, and the process that has them.
struct Pool {
    process: u32,
    count: usize,
    threads: Option<ThreadPool>,
}

impl Drop for Pool {
    fn drop(&mut self) {
        // In the child of a fork the threads are not there to be ended.
        if self.process != std::process::id() {
            std::mem::forget(self.threads.take());
        }
    }
}

impl Pool {
    fn new(count: usize) -> PyResult<Self> {
        let name = |i| format!("polyscan-{i}");
        let threads = ThreadPoolBuilder::new().num_threads(count).thread_name(name).build();
        let threads = threads.map_err(|error| {
            PyRuntimeError::new_err(format!("cannot start {count} threads: {error}"))
        })?;
        Ok(Self { process: std::process::id(), count, threads: Some(threads) })
    }

    /// The pool of the last call on this thread if it is such a one, or a new one.
    fn take(count: usize) -> PyResult<Self> {
        let kept = KEPT.with(|kept| kept.borrow_mut().take());
        let fits = |pool: &Self| pool.count == count && pool.process == std::process::id();
        kept.filter(fits).map_or_else(|| Self::new(count), Ok)
    }

    fn keep(self) {
        KEPT.with(|kept| *kept.borrow_mut() = Some(self));
    }
}

/// Does work on so many threads, as many as there are processors for `None`, without holding the interpreter's
/// lock.
pub(crate) fn work<R: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    f: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    let processors = || std::thread::available_parallelism().map_or(1, NonZero::get);
    let pool = Pool::take(threads.unwrap_or_else(processors).max(1))?;
    let result = py.detach(|| pool.threads.as_ref().map(|threads| threads.install(f)));
    pool.keep();
    result.ok_or_else(|| PyRuntimeError::new_err("the threads are gone"))
}
