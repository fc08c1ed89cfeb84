//! Runs: the pixels of one row between two edges of an outline, alone or in groups of rows.

use std::ops::Range;

/// A run of pixels in one row, between two edges of the outline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The row, from the viewport's top; [`Span::row`](crate::Span::row) adds the viewport's corner.
    pub y: i32,
    /// The columns, from the viewport's left side; never empty.
    pub x: Range<i32>,
    /// The outline's edges on the left and on the right; edge k goes from vertex k to the next.
    pub edges: [u32; 2],
}

/// In place of a run's edge on the right: the values of its pixels are those of the nearest points of the
/// other edge.
pub(crate) const AT_EDGE: u32 = u32::MAX;

/// Rows whose runs are found at a time.
pub(crate) const ROWS: usize = 8;

/// The runs of neighbouring rows of a convex outline; they may be empty. All starts and ends are in one
/// cache line: they are stored together.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct RunGroup {
    pub(crate) start: [i32; ROWS],
    pub(crate) end: [i32; ROWS],
    /// The first row.
    pub(crate) y: i32,
    /// The number of rows.
    pub(crate) len: usize,
    /// The edges on the left and on the right, unless they are not asked for.
    pub(crate) edges: [[u32; 2]; ROWS],
}

impl RunGroup {
    pub(crate) const EMPTY: Self =
        Self { y: 0, len: 0, start: [0; ROWS], end: [0; ROWS], edges: [[0; 2]; ROWS] };

    /// A group of one row.
    #[inline(always)]
    pub(crate) fn of(run: &Run) -> Self {
        let mut group = Self { y: run.y, len: 1, ..Self::EMPTY };
        (group.start[0], group.end[0], group.edges[0]) = (run.x.start, run.x.end, run.edges);
        group
    }

    /// The run of a row.
    #[inline(always)]
    pub(crate) fn run(&self, row: usize) -> Run {
        let (y, x) = (self.y + row as i32, self.start[row]..self.end[row]);
        Run { y, x, edges: self.edges[row] }
    }
}
