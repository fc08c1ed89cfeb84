//! Spans: the pixels of one row that a polygon covers between two of its edges.
//!
//! A span carries the values of (z, s_1 .. s_n, s_{n+1}) at its start and their change per pixel.
//! A renderer may step them itself, or go on to [fragments](crate::fragment).

use std::ops::Range;

use crate::edge_table::Run;
use crate::fragment::Fragments;
use crate::polygon::ScreenPolygon;
use crate::project::ScreenParams;

/// A run of covered pixels with what is interpolated along it.
#[derive(Clone, Debug)]
pub struct Span<'a, const N: usize> {
    pub(crate) place: Place<'a, N>,
    /// The columns that are visible, relative to the viewport.
    pub(crate) x: Range<i32>,
    pub(crate) line: Line<N>,
}

/// Where a fragment comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<'a, const N: usize> {
    pub(crate) polygon: &'a ScreenPolygon<N>,
    /// The run, relative to the viewport, visible or not: its row, columns and edges.
    y: i32,
    x: [i32; 2],
    edges: [u32; 2],
}

/// z, s_1 .. s_n and s_{n+1} along a span, in f32: a value at one pixel, and the change per pixel.
///
/// The pixel is the one at that end of the run where s_{n+1} = 1/w is smallest, the farthest from
/// the eye. Then f32 is enough, however long the span and whatever the ratio of w. For a value
/// v = a + d l at l pixels from there is off by no more than
///
/// ```text
/// 2^-24 (|a| + 2 |d l| + |v|)  <=  2^-24 * 3 (|a| + |v|)
/// ```
///
/// by the rounding of a, of d, of the product and of the sum. Since |s| <= R / w for the largest
/// parameter R, and 1/w at the pixel is no less than at the end, this is at most 2^-24 * 6 R / w for
/// s; for 1/w, which is positive and grows from a, it is 2^-24 * 3 / w. With their quotient's own
/// rounding r = s / (1/w) is off by less than 2^-24 * 11 R, or 7e-7 R. Starting from the near end
/// instead, the error would grow with the ratio of w: by this choice there is nothing to restart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<const N: usize> {
    /// The pixel's column, relative to the viewport.
    pub(crate) x: i32,
    pub(crate) at: ScreenParams<N, f32>,
    pub(crate) delta: ScreenParams<N, f32>,
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
        Some(Self { place: Place::new(polygon, run), x, line: polygon.line(run) })
    }

    /// The row on the framebuffer.
    #[inline(always)]
    pub fn y(&self) -> i32 {
        self.place.y()
    }

    /// The first visible column on the framebuffer.
    #[inline(always)]
    pub(crate) fn column(&self) -> i32 {
        self.place.polygon.corner.0 + self.x.start
    }

    /// The columns on the framebuffer; never empty.
    pub fn x(&self) -> Range<i32> {
        let corner = self.place.polygon.corner.0;
        corner + self.x.start..corner + self.x.end
    }

    /// The depth of the pixel `offset` columns after the first, the same bits as in its fragment. It
    /// grows or falls along the span, since rounding keeps the order of products and of sums.
    #[inline(always)]
    pub(crate) fn depth_at(&self, offset: i32) -> f32 {
        let Line { x, at, delta } = &self.line;
        let (min, max) = self.place.polygon.z;
        ((self.x.start + offset - x) as f32 * delta.z + at.z).max(min).min(max)
    }

    /// z, s_1 .. s_n and s_{n+1} = 1/w at the centre of the first pixel.
    pub fn start(&self) -> ScreenParams<N> {
        self.place.per_w(self.place.polygon.at(self.x.start, &self.place.run()))
    }

    /// The change of [`start`](Self::start) from one pixel to the next.
    pub fn delta(&self) -> ScreenParams<N> {
        self.place.per_w(self.place.polygon.along(&self.place.run()).1)
    }

    /// The fragments, from left to right: depth, w and parameters of each pixel.
    pub fn fragments(&self) -> Fragments<'_, N> {
        Fragments::new(self)
    }
}

impl<'a, const N: usize> Place<'a, N> {
    #[inline(always)]
    pub(crate) fn new(polygon: &'a ScreenPolygon<N>, run: &Run) -> Self {
        Self { polygon, y: run.y, x: [run.x.start, run.x.end], edges: run.edges }
    }

    /// The row on the framebuffer.
    #[inline(always)]
    pub(crate) fn y(&self) -> i32 {
        self.polygon.corner.1 + self.y
    }

    fn run(&self) -> Run {
        Run { y: self.y, x: self.x[0]..self.x[1], edges: self.edges }
    }

    /// The derivatives of the parameters with respect to screen x and y at a column: the quotient
    /// rule for r = s / (1/w).
    pub(crate) fn derivatives(&self, x: i32) -> ([f32; N], [f32; N]) {
        let run = self.run();
        let at = self.polygon.at(x, &run);
        let dx = self.polygon.along(&run).1;
        let dy = self.polygon.downwards(x, &run);
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
        (quotient(&dx), quotient(&dy))
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
