//! Positions on the screen in subpixels, and the rule by which they are rounded.
//!
//! A position in clip space goes in; it is divided by w, mapped to the viewport and rounded to 1/256
//! pixel, half to even, as GPUs (and Mesa) do. From there on coverage is exact. Everything that asks
//! which pixels a polygon touches begins with these points.
//!
//! ```text
//!     256 subpixels
//!     |<--------->|
//!     +-----------+     o  a vertex, at 100.5 subpixels from the left and 61.2 from the top
//!     |   x o     |     x  the point that it is rounded to: 100, since half goes to even, and 61
//!     |     .     |     .  the pixel's centre, at 128, 128
//!     |           |
//!     +-----------+
//! ```

use glam::DVec4;

use crate::round::{ROUND, integer};
use crate::viewport::{Rect, Viewport};

/// The number of subpixels in the width or height of a pixel.
pub const SUBPIXELS: i32 = 256;

/// The distance from a pixel's corner to its centre, in subpixels.
pub(crate) const HALF_PIXEL: i64 = SUBPIXELS as i64 / 2;

/// A position on the screen in subpixels (1/256 pixel), x right, y down, relative to the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SubpixelPoint {
    /// Subpixels to the right of the viewport's left side.
    pub x: i32,
    /// Subpixels below the viewport's top side.
    pub y: i32,
}

impl SubpixelPoint {
    /// Divides a position in clip space by its w and rounds it to the grid, half to even.
    ///
    /// The result is meant for positions that were clipped: w of at least [`MIN_W`], inside the
    /// [guard band]. Others give some point within 2^26 subpixels.
    ///
    /// ```
    /// use glam::dvec4;
    /// use polyscan::{Viewport, subpixel::SubpixelPoint};
    ///
    /// let viewport = Viewport::new(100, 50)?;
    /// // The middle of the picture, and 1.5 subpixels to the right of it: rounded to the even 2.
    /// let middle = SubpixelPoint::project(dvec4(0.0, 0.0, 0.5, 1.0), &viewport);
    /// assert_eq!(middle, SubpixelPoint { x: 50 * 256, y: 25 * 256 });
    /// let beside = SubpixelPoint::project(dvec4(1.5 / (50.0 * 256.0), 0.0, 0.5, 1.0), &viewport);
    /// assert_eq!(beside.x - middle.x, 2);
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    ///
    /// [`MIN_W`]: crate::view_volume::MIN_W
    /// [guard band]: crate::viewport::GUARD_BAND
    #[inline(always)]
    #[must_use]
    pub fn project(position: DVec4, viewport: &Viewport) -> Self {
        let Rect { width, height, .. } = viewport.rect();
        let [x, y, _, w] = position.to_array();
        Self { x: subpixels(x, w, width), y: subpixels(-y, w, height) }
    }
}

/// Maps -w <= x <= w to 0 ..= size pixels, in subpixels, rounded half to even.
///
/// The rounding is that of the exact quotient: with 24-bit x and w and a `scale` of at most 2^23,
/// a quotient that is not half-way between two integers differs from half-way by more than a part
/// in 2^48, which f64 division preserves; and rounding before the offset (an even number, so that
/// even stays even) adds no second rounding.
#[inline(always)]
fn subpixels(x: f64, w: f64, size: u32) -> i32 {
    // The guard band ends within 98,304 pixels of the middle. Only vertices clipped from positions
    // beyond 2^50, where f64 runs out of bits, may be found outside of it.
    const LIMIT: f64 = (SUBPIXELS * (1 << 17)) as f64;
    let scale = f64::from(size) * f64::from(SUBPIXELS / 2);
    // Comparisons that NaN fails, and an integer without a conversion, so that loops become SIMD.
    let centred = x * scale / w;
    let centred = if centred > -LIMIT { centred } else { -LIMIT };
    let centred = if centred < LIMIT { centred } else { LIMIT };
    integer(centred + ROUND).wrapping_add(scale as i32)
}

/// The first row whose centre line is at or below `y` subpixels; the same for columns.
#[inline(always)]
pub(crate) fn first_centre(y: i32) -> i32 {
    // The row that `y` is in, or the next if `y` is below its centre.
    y.div_euclid(SUBPIXELS) + i32::from(y.rem_euclid(SUBPIXELS) > HALF_PIXEL as i32)
}
