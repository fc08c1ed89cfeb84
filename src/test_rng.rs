//! Random numbers for unit tests, the same in every run.

use std::ops::Range;

/// Marsaglia's xorshift.
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    /// A whole number below `end`.
    pub(crate) fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) % end
    }

    /// A whole number of a range.
    pub(crate) fn within(&mut self, range: Range<i32>) -> i32 {
        let len = i64::from(range.end) - i64::from(range.start);
        (i64::from(range.start) + self.below(len as u64) as i64) as i32
    }

    /// A number between -`size` and `size`.
    pub(crate) fn float(&mut self, size: f32) -> f32 {
        (self.below(1 << 24) as f32 / (1 << 23) as f32 - 1.0) * size
    }
}
