//! The pixels of a line of width 1, by the diamond-exit rule.
//!
//! A line from a to b draws each pixel whose diamond it leaves: the points nearer than half a pixel to
//! the pixel's centre, as |dx| + |dy|. So the pixel in whose diamond b lies is not drawn; the line
//! that begins at b draws it, and a polyline has each of its joints' pixels once.
//!
//! ```text
//!     +-------+-------+-------+
//!     |  / \  |  / \  |  / \  |     from a to b: the first two pixels, whose diamonds
//!     | / a-+-+-+---+-+-+b  \ |     the line leaves, not the third
//!     | \   / | \   / | \   / |
//!     |  \ /  |  \ /  |  \ /  |
//!     +-------+-------+-------+
//! ```
//!
//! What lies exactly on a border is decided as OpenGL does (4.6, section 14.5.1): both ends are taken to
//! lie nearer to the top left by (e, e^2), where e is smaller than any number. That is the top-left
//! rule as well.
//!
//! A line that is wider than high is in one pixel of each column between its ends, that in which it
//! crosses the column's centre line. For its slope is no steeper than a diamond's side, so it cannot
//! come into a diamond of the column without crossing the centre line inside of it. The ends add or take
//! away one pixel. Others are in one pixel of each row. All of it is exact, on integers.

use std::ops::Range;

use crate::coverage::run::{ROWS, RunGroup};
use crate::subpixel::{HALF_PIXEL, SUBPIXELS, SubpixelPoint, first_centre};

/// A line that draws some pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinePixels {
    a: SubpixelPoint,
    b: SubpixelPoint,
    /// Whether it is wider than high, or both alike.
    is_wide: bool,
    /// The columns that it has a pixel in each of, if it is wide, the rows if not: the first and the one
    /// after the last. There is at least one, so the two ends are not the same point.
    steps: (i32, i32),
}

/// An end of the visible part of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LineEnd {
    /// The line's own.
    Own,
    /// The point in which a plane cuts it.
    Cut(SubpixelPoint),
}

impl LinePixels {
    /// The line from `a` to `b`, as far as it lies between two ends. A cut moves no pixel: those on one
    /// side of it and those on the other are the pixels of the whole line, each once. `None` if no pixel
    /// is drawn.
    pub(crate) fn new(
        a: SubpixelPoint,
        b: SubpixelPoint,
        [start, end]: [LineEnd; 2],
    ) -> Option<Self> {
        let (dx, dy) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
        let is_wide = dx.abs() >= dy.abs();
        let along = |p: SubpixelPoint| if is_wide { p.x } else { p.y };
        let is_forward = along(a) <= along(b);
        // The steps whose centre lies between the ends, those at the top left included.
        let (least, greatest) = if is_forward { (a, b) } else { (b, a) };
        let mut steps = first_centre(along(least))..first_centre(along(greatest));
        let step_of = |p: SubpixelPoint| own_pixel(p).map(|[x, y]| if is_wide { x } else { y });
        // The whole line is settled first, so that each cut parts the same pixels.
        if let Some(first) = step_of(a) {
            steps = steps.start.min(first)..steps.end.max(first + 1);
        }
        match step_of(b) {
            Some(last) if is_forward => steps.end = steps.end.min(last),
            Some(last) => steps.start = steps.start.max(last + 1),
            None => {}
        }
        // A pixel whose centre lies before the line's own beginning lies where that does.
        for (cut, is_start) in [(start, true), (end, false)] {
            let LineEnd::Cut(p) = cut else { continue };
            let step = first_centre(along(p));
            if is_start == is_forward {
                steps.start = steps.start.max(step);
            } else {
                steps.end = steps.end.min(step);
            }
        }
        (steps.start < steps.end).then_some(Self { a, b, is_wide, steps: (steps.start, steps.end) })
    }

    /// The pixels before, between and beyond two places along the line, in pixels: of the columns, or of
    /// the rows, by their centres.
    pub(crate) fn parts(&self, places: [f64; 2]) -> [Option<Self>; 3] {
        let (start, end) = self.steps;
        // The first column whose centre is at or beyond a place.
        let [first, last] = places.map(|place| (place - 0.5).ceil());
        let first = (first.clamp(start.into(), end.into())) as i32;
        let last = (last.clamp(first.into(), end.into())) as i32;
        [(start, first), (first, last), (last, end)]
            .map(|steps| (steps.0 < steps.1).then_some(Self { steps, ..*self }))
    }

    /// The rows that it has pixels in, of those given.
    pub(crate) fn rows(&self, within: &Range<i32>) -> Range<i32> {
        let (first, last) = (self.steps.0, self.steps.1 - 1);
        let rows = match self.is_wide {
            false => first..last + 1,
            true => {
                let (first, last) = (self.row(first), self.row(last));
                first.min(last)..first.max(last) + 1
            }
        };
        rows.start.max(within.start)..rows.end.min(within.end)
    }

    /// The columns between which its pixels lie.
    pub(crate) fn columns(&self) -> Range<i32> {
        if self.is_wide {
            return self.steps.0..self.steps.1;
        }
        let (first, last) = (self.column(self.steps.0), self.column(self.steps.1 - 1));
        first.min(last)..first.max(last) + 1
    }

    /// Whether it has a pixel in each column, so that what it carries changes from column to column.
    pub(crate) fn is_wide(&self) -> bool {
        self.is_wide
    }

    /// The runs of up to [`ROWS`] rows, from one on and before another; all must be among its
    /// [rows](Self::rows).
    pub(crate) fn group(&self, rows: &Range<i32>) -> RunGroup {
        let mut group = RunGroup { y: rows.start, ..RunGroup::EMPTY };
        group.len = rows.len().min(ROWS);
        for (k, y) in rows.clone().take(ROWS).enumerate() {
            let run = self.run(y);
            (group.start[k], group.end[k]) = (run.start, run.end);
        }
        group
    }

    /// The columns of its pixels in a row.
    fn run(&self, y: i32) -> Range<i32> {
        if !self.is_wide {
            let column = self.column(y);
            return column..column + 1;
        }
        let (first, end) = self.steps;
        let (dx, dy) = self.forward();
        if dy == 0 {
            return first..end;
        }
        // Where the line enters the row, and where it leaves it.
        let (upper, lower) = (self.column_at(y), self.column_at(y + 1));
        let (enter, leave) = if (dx > 0) == (dy > 0) { (upper, lower) } else { (lower, upper) };
        enter.max(first)..leave.min(end)
    }

    /// From the end at the left to that at the right, or from the upper to the lower one.
    fn forward(&self) -> (i64, i64) {
        let (dx, dy) =
            (i64::from(self.b.x) - i64::from(self.a.x), i64::from(self.b.y) - i64::from(self.a.y));
        let is_backward = if self.is_wide { dx < 0 } else { dy < 0 };
        if is_backward { (-dx, -dy) } else { (dx, dy) }
    }

    /// The first column whose centre is at or to the right of where the line crosses the upper border of
    /// a row. The line must not be horizontal.
    fn column_at(&self, y: i32) -> i32 {
        let (dx, dy) = self.forward();
        let (dx, dy) = if dy < 0 { (-dx, -dy) } else { (dx, dy) };
        let below = i64::from(y) * i64::from(SUBPIXELS) - i64::from(self.a.y);
        let position = (i64::from(self.a.x) - HALF_PIXEL) * dy + below * dx;
        ceil(position, dy * i64::from(SUBPIXELS))
    }

    /// The row of its pixel in a column. On the border of two rows, the line is in the one that it comes
    /// from above into, and else in the upper one.
    fn row(&self, x: i32) -> i32 {
        let (dx, dy) = self.forward();
        let centre = i64::from(x) * i64::from(SUBPIXELS) + HALF_PIXEL;
        let position = i64::from(self.a.y) * dx + (centre - i64::from(self.a.x)) * dy;
        let unit = dx * i64::from(SUBPIXELS);
        if dy > 0 { position.div_euclid(unit) as i32 } else { ceil(position, unit) - 1 }
    }

    /// The column of its pixel in a row; on the border of two, the left one.
    fn column(&self, y: i32) -> i32 {
        let (dx, dy) = self.forward();
        let centre = i64::from(y) * i64::from(SUBPIXELS) + HALF_PIXEL;
        let position = i64::from(self.a.x) * dy + (centre - i64::from(self.a.y)) * dx;
        ceil(position, dy * i64::from(SUBPIXELS)) - 1
    }
}

/// The pixel in whose diamond a point lies, if it lies in one.
fn own_pixel(p: SubpixelPoint) -> Option<[i32; 2]> {
    let pixel = [p.x, p.y].map(|c| ceil(c.into(), SUBPIXELS.into()) - 1);
    let centre = pixel.map(|c| i64::from(c) * i64::from(SUBPIXELS) + HALF_PIXEL);
    let (dx, dy) = (i64::from(p.x) - centre[0], i64::from(p.y) - centre[1]);
    let distance = dx.abs() + dy.abs();
    // A point on the border on the right lies inside, since it is taken to lie a little farther left.
    let is_inside = distance < HALF_PIXEL || distance == HALF_PIXEL && dx > 0;
    is_inside.then_some(pixel)
}

/// The quotient rounded up, of a positive divisor.
fn ceil(dividend: i64, divisor: i64) -> i32 {
    -(-dividend).div_euclid(divisor) as i32
}
