//! The viewport: which pixels the view volume is mapped to, and which range of depth.
//!
//! The screen has x to the right and y down, in pixels, relative to the viewport's top left corner.
//! Pixel (i, j) is sampled at its centre (i + 0.5, j + 0.5):
//!
//! ```text
//!     (0,0)    1      2      3
//!       +------+------+------+--> x
//!       |  .   |  .   |  .   |       each dot is a pixel's centre,
//!     1 +------+------+------+       the first at (0.5, 0.5)
//!       |  .   |  .   |  .   |
//!     2 +------+------+------+
//!       v
//!       y
//! ```

use thiserror::Error;

/// The largest width and height of a viewport or framebuffer, in pixels.
pub const MAX_SIZE: u32 = 65536;

/// How far a polygon may leave the viewport before it is clipped at its sides, in pixels. With
/// [`MAX_SIZE`] positions stay below 2^18 pixels, that is 2^26 subpixels, so that a product of two
/// differences (2^54) fits an i64 with room for their sums.
pub const GUARD_BAND: u32 = 65536;

/// A rectangle of pixels; it covers columns `x .. x + width` and rows `y .. y + height`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Rect {
    /// The first column.
    pub x: i32,
    /// The first row.
    pub y: i32,
    /// The number of columns.
    pub width: u32,
    /// The number of rows.
    pub height: u32,
}

impl Rect {
    /// Columns and rows as half-open ranges; i64 since the far end may exceed an i32.
    pub(crate) fn ranges(self) -> [(i64, i64); 2] {
        let range = |start: i32, len: u32| (i64::from(start), i64::from(start) + i64::from(len));
        [range(self.x, self.width), range(self.y, self.height)]
    }
}

/// A picture size that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a size of {width} x {height} pixels is not possible: {reason}")]
pub struct SizeError {
    /// The width asked for, in pixels.
    pub width: u32,
    /// The height asked for, in pixels.
    pub height: u32,
    reason: &'static str,
}

impl SizeError {
    pub(crate) const fn new(width: u32, height: u32, reason: &'static str) -> Self {
        Self { width, height, reason }
    }

    pub(crate) fn check(width: u32, height: u32) -> Result<(), Self> {
        if width.max(height) > MAX_SIZE {
            let reason =
                "width and height may be at most 65536; draw in tiles with `Viewport::with_corner`";
            return Err(Self::new(width, height, reason));
        }
        Ok(())
    }
}

/// The rectangle of the framebuffer that the view volume is mapped to, and the range of depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    rect: Rect,
    depth: [f32; 2],
}

impl Viewport {
    /// A viewport with its top left corner at pixel (0, 0) and depth from 0 to 1.
    ///
    /// # Errors
    /// When a side is longer than [`MAX_SIZE`]. A side of 0 pixels is allowed: nothing is drawn.
    pub fn new(width: u32, height: u32) -> Result<Self, SizeError> {
        SizeError::check(width, height)?;
        Ok(Self::whole(Rect { x: 0, y: 0, width, height }))
    }

    /// The viewport that covers all of a rectangle whose size was checked.
    pub(crate) fn whole(rect: Rect) -> Self {
        Self { rect, depth: [0.0, 1.0] }
    }

    /// The same viewport with its top left corner at pixel (x, y) of the framebuffer. With a
    /// negative corner the framebuffer shows a tile of a larger picture, bit for bit as the larger
    /// picture has it. Corners beyond 2^24 are moved to 2^24, where no framebuffer reaches.
    #[must_use]
    pub fn with_corner(mut self, x: i32, y: i32) -> Self {
        // Sums of corner and pixel must fit an i32.
        const FAR: i32 = 1 << 24;
        self.rect.x = x.clamp(-FAR, FAR);
        self.rect.y = y.clamp(-FAR, FAR);
        self
    }

    /// The same viewport with the near plane at depth `near` and the far plane at depth `far`, both
    /// in 0 ..= 1 (values outside are clamped, NaN counts as 0); near may be greater than far.
    #[must_use]
    pub fn with_depth(mut self, near: f32, far: f32) -> Self {
        self.depth = [near, far].map(|d| if d > 0.0 { d.min(1.0) } else { 0.0 });
        self
    }

    /// The pixels of the framebuffer that the viewport occupies.
    #[must_use]
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// The depths of the near and the far plane.
    #[must_use]
    pub fn depth(&self) -> [f32; 2] {
        self.depth
    }
}
