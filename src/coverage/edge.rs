//! One edge of an outline, stepped from row to row without rounding.
//!
//! A row of pixels belongs to an edge when the row's centre line is at or below the edge's upper
//! end and above its lower end. In such a row the edge stands before pixel column x: the first one
//! whose centre is at or to the right of the edge.

use std::ops::Range;

use crate::round::{ROUND, integer};
use crate::subpixel::{HALF_PIXEL, SUBPIXELS, SubpixelPoint, first_centre};

/// An edge of an outline: the column it stands before, stepped from row to row by Bresenham's
/// method, without rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    /// The rows that the edge crosses; never empty.
    pub(crate) rows: (i32, i32),
    /// The first column whose centre is at or to the right of the edge, in the current row.
    pub(crate) x: i32,
    /// How far beyond the edge that centre is, in 1 / `unit` of a pixel: 0 <= `error` < `unit`.
    error: i64,
    /// The step to the next row: whole pixels to the right and what is left over, 0 <= .. < `unit`.
    step: (i32, i64),
    unit: i64,
    /// +1 for an edge that runs down, -1 for one that runs up; times the winding of its chain.
    pub(crate) winding: i32,
    /// Which edge of the outline this is.
    pub(crate) index: u32,
}

impl Edge {
    /// The edge from `a` to `b` within the given rows; `None` if it crosses no row there, as
    /// horizontal edges do not.
    #[inline]
    pub(crate) fn new(
        a: SubpixelPoint,
        b: SubpixelPoint,
        index: u32,
        rows: &Range<i32>,
    ) -> Option<Self> {
        let (upper, lower, winding) = if a.y <= b.y { (a, b, 1) } else { (b, a, -1) };
        let first = first_centre(upper.y).max(rows.start);
        let end = first_centre(lower.y).min(rows.end);
        if first >= end {
            return None;
        }
        let dx = i64::from(lower.x) - i64::from(upper.x);
        let dy = i64::from(lower.y) - i64::from(upper.y);
        // In row y the edge is at upper.x + (y * 256 + 128 - upper.y) * dx / dy subpixels. Less
        // the 128 to the pixel's centre, and in units of 1 / (256 dy) pixel, that is:
        let unit = dy * i64::from(SUBPIXELS);
        let below = i64::from(first) * i64::from(SUBPIXELS) + HALF_PIXEL - i64::from(upper.y);
        let position = (i64::from(upper.x) - HALF_PIXEL) * dy + below * dx;
        let per_unit = 1.0 / unit as f64;
        let (before, error) = divided(-position, unit, per_unit);
        let (step, left_over) = divided(dx, dy, per_unit * f64::from(SUBPIXELS));
        Some(Self {
            rows: (first, end),
            x: -before,
            error,
            step: (step, left_over * i64::from(SUBPIXELS)),
            unit,
            winding,
            index,
        })
    }

    /// Goes on to the next row.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.error -= self.step.1;
        // All ones where the error is negative: no branch, which could not be predicted.
        let carry = self.error >> 63;
        self.error += self.unit & carry;
        self.x += self.step.0 - carry as i32;
    }
}

/// The quotient rounded down, which must fit an i32, and the remainder, of a positive divisor whose
/// reciprocal is given.
///
/// The quotient is estimated in f64 and rounded to nearest. The estimate is off by less than
/// 2^31 * 2^-51, so what is found is the quotient rounded down or one more; the remainder tells.
#[inline(always)]
fn divided(dividend: i64, divisor: i64, per_divisor: f64) -> (i32, i64) {
    let quotient = integer(dividend as f64 * per_divisor + ROUND);
    let remainder = dividend - i64::from(quotient) * divisor;
    let carry = remainder >> 63;
    (quotient + carry as i32, remainder + (divisor & carry))
}
