//! Counters that the threads of a draw call share, where pixels are counted.

use std::sync::atomic::{AtomicU64, Ordering};

/// Pixels of a polygon.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PixelCounts {
    /// Compared with what is stored.
    pub(crate) tested: u64,
    /// For which a shader was called.
    pub(crate) shaded: u64,
    /// Drawn: those that passed all tests and were not discarded.
    pub(crate) drawn: u64,
}

/// What is counted while faces are drawn.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    tested: AtomicU64,
    shaded: AtomicU64,
    drawn: AtomicU64,
    /// A bit for each face, from the number of the first on: whether a pixel of it was drawn.
    seen: Vec<AtomicU64>,
    first: u32,
    /// Whether nothing more is to be drawn once a pixel is.
    until_first: bool,
}

impl Counters {
    pub(crate) fn new(until_first: bool) -> Self {
        Self { until_first, ..Self::default() }
    }

    /// Begins with some faces, of which those are marked that are seen.
    pub(crate) fn begin(&mut self, first: u32, faces: usize) {
        self.first = first;
        self.seen.clear();
        self.seen.resize_with(faces.div_ceil(64), AtomicU64::default);
    }

    /// Whether no more need be drawn.
    pub(crate) fn is_done(&self) -> bool {
        self.until_first && self.drawn.load(Ordering::Relaxed) > 0
    }

    pub(crate) fn add(&self, face: u32, counts: PixelCounts) {
        let PixelCounts { tested, shaded, drawn } = counts;
        self.tested.fetch_add(tested, Ordering::Relaxed);
        self.shaded.fetch_add(shaded, Ordering::Relaxed);
        if drawn > 0 {
            self.drawn.fetch_add(drawn, Ordering::Relaxed);
            let number = face.wrapping_sub(self.first) as usize;
            if let Some(seen) = self.seen.get(number / 64) {
                seen.fetch_or(1 << (number % 64), Ordering::Relaxed);
            }
        }
    }

    /// The pixels counted so far.
    pub(crate) fn pixels(&self) -> PixelCounts {
        let [tested, shaded, drawn] =
            [&self.tested, &self.shaded, &self.drawn].map(|count| count.load(Ordering::Relaxed));
        PixelCounts { tested, shaded, drawn }
    }

    /// How many of the faces are seen.
    pub(crate) fn seen(&self) -> u64 {
        let ones = |seen: &AtomicU64| u64::from(seen.load(Ordering::Relaxed).count_ones());
        self.seen.iter().map(ones).sum()
    }
}
