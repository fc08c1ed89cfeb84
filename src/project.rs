//! Projection: from clip space to the screen.
//!
//! A vertex record (x, y, z, w, r_1 .. r_n) goes in. Its position is divided by w and mapped to the
//! viewport, its parameters become s_i = r_i / w, and 1/w is kept as s_{n+1} (Heckbert and Moreton
//! 1991, section 3.5). What comes out is linear over the screen, so it can be interpolated by
//! additions alone.
//!
//! The screen has x to the right and y down, in pixels, relative to the viewport's top left corner.
//! Pixel (i, j) has its centre at (i + 0.5, j + 0.5).

use glam::DVec4;
use thiserror::Error;

use crate::clip::{ClipPlane, ClipSpace, ClipVertex, W_MIN};
use crate::number::Number;
use crate::vertex::Vertex;

/// Positions on the screen are rounded to 1 / `SUBPIXELS` of a pixel, as GPUs (and Mesa) do; from
/// there on coverage is exact.
pub const SUBPIXELS: i32 = 256;

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
    pub(crate) reason: &'static str,
}

impl SizeError {
    pub(crate) fn check(width: u32, height: u32) -> Result<(), Self> {
        if width.max(height) > MAX_SIZE {
            let reason = "width and height may be at most 65536; draw in tiles with `Viewport::at`";
            return Err(Self { width, height, reason });
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
    pub fn at(mut self, x: i32, y: i32) -> Self {
        // Sums of corner and pixel must fit an i32.
        const FAR: i32 = 1 << 24;
        self.rect.x = x.clamp(-FAR, FAR);
        self.rect.y = y.clamp(-FAR, FAR);
        self
    }

    /// The same viewport with the near plane at depth `near` and the far plane at depth `far`, both
    /// in 0 ..= 1 (values outside are clamped, NaN counts as 0); near may be greater than far.
    pub fn with_depth(mut self, near: f32, far: f32) -> Self {
        self.depth = [near, far].map(|d| if d > 0.0 { d.min(1.0) } else { 0.0 });
        self
    }

    /// The pixels of the framebuffer that the viewport occupies.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// The depths of the near and the far plane.
    pub fn depth(&self) -> [f32; 2] {
        self.depth
    }

    /// Divides a vertex by its w and maps it to the screen: the record
    /// (x, y, z, s_1 .. s_n, s_{n+1}) of the paper. `None` when w is not at least
    /// [`W_MIN`], or when a coordinate is not finite.
    pub fn project<const N: usize>(
        &self,
        vertex: &Vertex<N>,
        clip_space: ClipSpace,
    ) -> Option<ScreenVertex<N>> {
        let vertex = ClipVertex::from(vertex);
        let projection = Projection::new(self, clip_space);
        (vertex.position.is_finite() && vertex.position.w >= W_MIN).then(|| {
            projection.vertex(vertex.position.to_array(), 1.0, |i, inv_w| vertex.params[i] * inv_w)
        })
    }

    /// The sides of the guard band.
    pub(crate) fn guard_band(&self) -> [ClipPlane; 4] {
        let [x, y] = self.guard_factors();
        ClipPlane::sides(x, y)
    }

    /// How many times wider and higher than the viewport the guard band is.
    pub(crate) fn guard_factors(&self) -> [f64; 2] {
        [self.rect.width, self.rect.height]
            .map(|size| 1.0 + 2.0 * f64::from(GUARD_BAND) / f64::from(size.max(1)))
    }
}

/// What is linear over the screen: z, s_1 .. s_n and s_{n+1} = 1/w, at a point, or per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenParams<const N: usize, T = f64> {
    /// Depth: z/w after the viewport's depth range.
    pub z: T,
    /// s_{n+1} = 1 / w.
    pub inv_w: T,
    /// s_i = r_i / w; for a parameter that is not interpolated in perspective, r_i itself.
    pub s: [T; N],
}

/// One of the [`ScreenParams`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Component {
    Z,
    InvW,
    S(usize),
}

impl<const N: usize, T: Copy> ScreenParams<N, T> {
    #[inline(always)]
    pub(crate) fn get(&self, component: Component) -> &T {
        match component {
            Component::Z => &self.z,
            Component::InvW => &self.inv_w,
            Component::S(i) => &self.s[i],
        }
    }

    /// `f` of each component. Plain loops, which are inlined whole; `array::map` need not be.
    #[inline(always)]
    pub(crate) fn map<U: Copy>(&self, f: impl Fn(&T) -> U) -> ScreenParams<N, U> {
        let (z, inv_w) = (f(&self.z), f(&self.inv_w));
        let mut s = [z; N];
        for (s, value) in s.iter_mut().zip(&self.s) {
            *s = f(value);
        }
        ScreenParams { z, inv_w, s }
    }

    /// `f` of the corresponding components of `self` and `other`.
    #[inline(always)]
    pub(crate) fn zip(&self, other: &Self, f: impl Fn(T, T) -> T) -> Self {
        let (z, inv_w) = (f(self.z, other.z), f(self.inv_w, other.inv_w));
        let mut s = self.s;
        for (s, other) in s.iter_mut().zip(&other.s) {
            *s = f(*s, *other);
        }
        Self { z, inv_w, s }
    }
}

impl<const N: usize> ScreenParams<N> {
    /// `self + delta * steps`.
    #[inline(always)]
    pub(crate) fn step(&self, delta: &Self, steps: f64) -> Self {
        self.zip(delta, |a, d| a + d * steps)
    }

    /// Rounded to f32.
    #[inline(always)]
    pub(crate) fn rounded(&self) -> ScreenParams<N, f32> {
        self.map(|value| *value as f32)
    }
}

impl<const N: usize, T: Copy + Default> Default for ScreenParams<N, T> {
    fn default() -> Self {
        Self { z: T::default(), inv_w: T::default(), s: [T::default(); N] }
    }
}

/// A vertex on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenVertex<const N: usize, T = f64> {
    /// Pixels to the right of the viewport's left side, not rounded.
    pub x: T,
    /// Pixels below the viewport's top side, not rounded.
    pub y: T,
    /// What is interpolated linearly from here on.
    pub values: ScreenParams<N, T>,
}

impl<const N: usize, T: Copy + Default> Default for ScreenVertex<N, T> {
    fn default() -> Self {
        Self { x: T::default(), y: T::default(), values: ScreenParams::default() }
    }
}

/// A position on the screen in subpixels (1/256 pixel), x right, y down, relative to the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FixedPoint {
    /// Subpixels to the right of the viewport's left side.
    pub x: i32,
    /// Subpixels below the viewport's top side.
    pub y: i32,
}

impl FixedPoint {
    /// Divides a position by its w. The result is meant for w of at least [`W_MIN`] and positions
    /// inside the guard band; others give some point.
    #[inline(always)]
    pub(crate) fn project(position: DVec4, viewport: &Viewport) -> Self {
        let Rect { width, height, .. } = viewport.rect;
        let [x, y, _, w] = position.to_array();
        Self { x: subpixels(x, w, width), y: subpixels(-y, w, height) }
    }
}

/// The mapping from clip space to a viewport.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    corner: (i32, i32),
    /// Width and height in pixels.
    size: [f64; 2],
    depth: [f64; 2],
    clip_space: ClipSpace,
}

impl Projection {
    pub(crate) fn new(viewport: &Viewport, clip_space: ClipSpace) -> Self {
        let Rect { x, y, width, height } = viewport.rect;
        Self {
            corner: (x, y),
            size: [width, height].map(f64::from),
            depth: viewport.depth.map(f64::from),
            clip_space,
        }
    }

    /// The top left corner of the viewport on the framebuffer.
    pub(crate) fn corner(&self) -> (i32, i32) {
        self.corner
    }

    /// The least and the greatest depth of the viewport's range.
    #[inline(always)]
    pub(crate) fn depth_range(&self) -> (f64, f64) {
        let [near, far] = self.depth;
        (near.min(far), near.max(far))
    }

    /// A vertex on the screen, not rounded. `w_unit` is the unit in which w is measured, a power of
    /// two, and `value` gives s_i for i and 1/w in this unit.
    #[inline(always)]
    pub(crate) fn vertex<const N: usize, T: Number>(
        &self,
        [x, y, z, w]: [T; 4],
        w_unit: T,
        value: impl Fn(usize, T) -> T,
    ) -> ScreenVertex<N, T> {
        let inv_w = w.all(1.0) / w;
        let (x, y, z) = (x * inv_w, y * inv_w, z * inv_w);
        let [near, far] = self.depth;
        let z = match self.clip_space {
            ClipSpace::ZeroToOne => z,
            ClipSpace::MinusOneToOne => z * 0.5 + 0.5,
        };
        let inv_w = inv_w * w_unit;
        let mut s = [inv_w; N];
        for (i, s) in s.iter_mut().enumerate() {
            *s = value(i, inv_w);
        }
        ScreenVertex {
            x: (x * 0.5 + 0.5) * self.size[0],
            y: (y * -0.5 + 0.5) * self.size[1],
            values: ScreenParams { z: z * (far - near) + near, inv_w, s },
        }
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
    // Adding and subtracting 1.5 * 2^52 leaves no fraction bits: round half to even.
    const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
    // The guard band ends within 98,304 pixels of the middle. Only vertices clipped from positions
    // beyond 2^50, where f64 runs out of bits, may be found outside of it.
    const LIMIT: f64 = (SUBPIXELS * (1 << 17)) as f64;
    let scale = f64::from(size) * f64::from(SUBPIXELS / 2);
    let centred = (x * scale / w).clamp(-LIMIT, LIMIT);
    ((centred + ROUND) - ROUND + scale) as i32
}
