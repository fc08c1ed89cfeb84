//! The window of a draw call: the columns and rows that are visited, relative to the viewport.

use std::ops::Range;

use crate::subpixel::{SubpixelPoint, first_centre};
use crate::viewport::{Rect, Viewport};

/// Columns and rows to visit, relative to the viewport's top left corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) columns: Range<i32>,
    pub(crate) rows: Range<i32>,
    /// The viewport's corner on the framebuffer.
    corner: (i32, i32),
    /// How far from a pixel's centre, in subpixels, along each axis, is what may count for it: 0 if only the
    /// centre does.
    pub(crate) reach: i32,
}

impl Window {
    /// The pixels of a viewport within a scissor, if there is one, and within `bounds`.
    pub(crate) fn new(viewport: &Viewport, scissor: Option<Rect>, bounds: Rect) -> Self {
        let Rect { x, y, .. } = viewport.rect();
        let all = viewport.rect().ranges();
        let bounds = bounds.ranges();
        let scissor = scissor.map_or(all, Rect::ranges);
        let [columns, rows] = [0, 1].map(|axis| {
            let (first, end) = all[axis];
            let inside = |pixel: i64| (pixel.clamp(first, end) - first) as i32;
            inside(bounds[axis].0.max(scissor[axis].0))..inside(bounds[axis].1.min(scissor[axis].1))
        });
        Self { columns, rows, corner: (x, y), reach: 0 }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.columns.is_empty() || self.rows.is_empty()
    }

    /// Those of the rows that lie in the given rows of the framebuffer.
    pub(crate) fn rows_within(&self, rows: &Range<i32>) -> Range<i32> {
        let (_, corner) = self.corner;
        self.rows.start.max(rows.start - corner)..self.rows.end.min(rows.end - corner)
    }

    /// A column's place on the framebuffer, where it has one.
    pub(crate) fn column_on_frame(&self, column: i32) -> usize {
        (column + self.corner.0) as usize
    }

    /// A row's place on the framebuffer, where it has one.
    #[inline(always)]
    pub(crate) fn row_on_frame(&self, row: i32) -> usize {
        (row + self.corner.1) as usize
    }

    /// The columns and rows of the window whose centres lie between the points, or within reach, if there
    /// are any.
    #[inline(always)]
    pub(crate) fn extent(
        &self,
        points: impl Iterator<Item = SubpixelPoint>,
    ) -> Option<(Range<i32>, Range<i32>)> {
        let (mut left, mut right, mut top, mut bottom) = (i32::MAX, i32::MIN, i32::MAX, i32::MIN);
        for SubpixelPoint { x, y } in points {
            (left, right) = (left.min(x), right.max(x));
            (top, bottom) = (top.min(y), bottom.max(y));
        }
        let centres = |first: i32, last: i32, within: &Range<i32>| {
            let first = first_centre(first.saturating_sub(self.reach));
            let end = first_centre(last.saturating_add(self.reach));
            first.max(within.start)..end.min(within.end)
        };
        let columns = centres(left, right, &self.columns);
        let rows = centres(top, bottom, &self.rows);
        (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
    }
}
