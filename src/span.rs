//! Spans: the pixels of one row that a polygon covers between two of its edges.
//!
//! A span carries the values of (z, s_1 .. s_n, s_{n+1}) at its start and their change per pixel.
//! A renderer may step them itself, or go on to [fragments](crate::fragment).

use std::ops::Range;

use crate::edge_table::Run;
use crate::fragment::{Blocks, Fragments};
use crate::polygon::ScreenPolygon;
use crate::project::ScreenParams;

/// A run of covered pixels with what is interpolated along it.
#[derive(Clone, Debug)]
pub struct Span<'a, const N: usize> {
    pub(crate) polygon: &'a ScreenPolygon<N>,
    pub(crate) y: i32,
    /// The columns that are visible, relative to the viewport.
    pub(crate) x: Range<i32>,
    /// The polygon's first column in this row, visible or not. Values are evaluated from here, so
    /// that what is visible does not influence them.
    pub(crate) first: i32,
    /// At the centre of column `first`; s and inv_w in units of the polygon's w unit.
    pub(crate) start: ScreenParams<N>,
    pub(crate) delta: ScreenParams<N>,
    edges: [u32; 2],
}

impl<'a, const N: usize> Span<'a, N> {
    /// The part of a run within the given columns, if any.
    #[inline(always)]
    pub(crate) fn new(
        polygon: &'a ScreenPolygon<N>,
        run: &Run,
        columns: &Range<i32>,
    ) -> Option<Self> {
        let x = run.x.start.max(columns.start)..run.x.end.min(columns.end);
        if x.is_empty() {
            return None;
        }
        let (start, delta) = polygon.along(run);
        Some(Self { polygon, y: run.y, x, first: run.x.start, start, delta, edges: run.edges })
    }

    /// The row on the framebuffer.
    pub fn y(&self) -> i32 {
        self.polygon.corner.1 + self.y
    }

    /// The columns on the framebuffer; never empty.
    pub fn x(&self) -> Range<i32> {
        self.polygon.corner.0 + self.x.start..self.polygon.corner.0 + self.x.end
    }

    /// z, s_1 .. s_n and s_{n+1} = 1/w at the centre of the first pixel.
    pub fn start(&self) -> ScreenParams<N> {
        self.per_w(self.at(self.x.start))
    }

    /// The change of [`start`](Self::start) from one pixel to the next.
    pub fn delta(&self) -> ScreenParams<N> {
        self.per_w(self.delta)
    }

    /// The fragments, from left to right: depth, w and parameters of each pixel.
    pub fn fragments(&self) -> Fragments<'_, N> {
        Fragments::new(self)
    }

    /// The pixels in the blocks in which they are evaluated.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> Blocks<'_, N> {
        Blocks::new(self)
    }

    /// The values at the centre of a column.
    pub(crate) fn at(&self, x: i32) -> ScreenParams<N> {
        self.start.step(&self.delta, f64::from(x - self.first))
    }

    /// The derivatives of the parameters with respect to screen x and y at a column: the quotient
    /// rule for r = s / (1/w).
    pub(crate) fn derivatives(&self, x: i32) -> ([f32; N], [f32; N]) {
        let at = self.at(x);
        let dy = self.polygon.downwards(x, self.y, self.edges);
        let quotient = |d: &ScreenParams<N>| {
            std::array::from_fn(|i| {
                let r = if self.polygon.times_w[i] {
                    (d.s[i] - at.s[i] / at.inv_w * d.inv_w) / at.inv_w
                } else {
                    d.s[i]
                };
                r as f32
            })
        };
        (quotient(&self.delta), quotient(&dy))
    }

    /// From the polygon's unit of w to w itself; the unit is a power of two, so this is exact.
    fn per_w(&self, mut values: ScreenParams<N>) -> ScreenParams<N> {
        values.inv_w /= self.polygon.w_unit;
        for i in (0..N).filter(|&i| self.polygon.times_w[i]) {
            values.s[i] /= self.polygon.w_unit;
        }
        values
    }
}
