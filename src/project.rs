//! Projection: from clip space to the screen.
//!
//! A vertex record (x, y, z, w, r_1 .. r_n) goes in. Its position is divided by w and mapped to the
//! viewport, its parameters become s_i = r_i / w, and 1/w is kept as s_{n+1} (Heckbert and Moreton
//! 1991, section 3.5). What comes out is linear over the screen, so it can be interpolated by
//! additions alone.

use crate::scalar::Scalar;
use crate::vertex::Vertex;
use crate::view_volume::{ClipSpace, MIN_W};
use crate::viewport::{Rect, Viewport};

/// What is linear over the screen: z, s_1 .. s_n and s_{n+1} = 1/w, at a point, or per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenParams<const N: usize> {
    /// Depth: z/w after the viewport's depth range.
    pub z: f64,
    /// s_{n+1} = 1 / w.
    pub inv_w: f64,
    /// s_i = r_i / w; for a parameter that is not interpolated in perspective, r_i itself.
    pub s: [f64; N],
}

/// A vertex on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenVertex<const N: usize> {
    /// Pixels to the right of the viewport's left side, not rounded.
    pub x: f64,
    /// Pixels below the viewport's top side, not rounded.
    pub y: f64,
    /// What is interpolated linearly from here on.
    pub values: ScreenParams<N>,
}

impl Viewport {
    /// Divides a vertex by its w and maps it to the screen: the record
    /// (x, y, z, s_1 .. s_n, s_{n+1}) of the paper. `None` when w is not at least
    /// [`MIN_W`], or when a coordinate is not finite.
    #[must_use]
    pub fn project<const N: usize>(
        &self,
        vertex: &Vertex<N>,
        clip_space: ClipSpace,
    ) -> Option<ScreenVertex<N>> {
        let position = vertex.position.as_dvec4();
        (position.is_finite() && position.w >= MIN_W).then(|| {
            let ScreenPoint { x, y, z, inv_w } =
                Projection::new(self, clip_space).point(position.to_array());
            let s = vertex.params.map(|r| f64::from(r) * inv_w);
            ScreenVertex { x, y, values: ScreenParams { z, inv_w, s } }
        })
    }
}

/// The mapping from clip space to a viewport.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// The top left corner of the viewport on the framebuffer.
    pub(crate) corner: (i32, i32),
    /// The last column, relative to the first.
    pub(crate) last_column: i32,
    /// Width and height in pixels.
    size: [f64; 2],
    depth: [f64; 2],
    clip_space: ClipSpace,
}

/// A position on the screen, not rounded.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ScreenPoint<T = f64> {
    pub(crate) x: T,
    pub(crate) y: T,
    /// Depth in the viewport's range.
    pub(crate) z: T,
    pub(crate) inv_w: T,
}

impl Projection {
    pub(crate) fn new(viewport: &Viewport, clip_space: ClipSpace) -> Self {
        let Rect { x, y, width, height } = viewport.rect();
        Self {
            corner: (x, y),
            last_column: width.saturating_sub(1) as i32,
            size: [width, height].map(f64::from),
            depth: viewport.depth().map(f64::from),
            clip_space,
        }
    }

    /// The least and the greatest depth of the viewport's range.
    #[inline(always)]
    pub(crate) fn depth_range(&self) -> (f64, f64) {
        let [near, far] = self.depth;
        (near.min(far), near.max(far))
    }

    /// The columns and rows of the viewport.
    #[inline(always)]
    pub(crate) fn pixels(&self) -> [f64; 2] {
        self.size
    }

    /// Whether the near plane is at z = -w, not at 0.
    pub(crate) fn has_negative_z(&self) -> bool {
        self.clip_space == ClipSpace::MinusOneToOne
    }

    /// X in normalized device coordinates, -1 to 1 from left to right, so many pixels right of the centre of a
    /// column of the framebuffer.
    #[inline(always)]
    pub(crate) fn ndc_x(&self, column: i32, right: f64) -> f64 {
        (f64::from(column - self.corner.0) + 0.5 + right) * 2.0 / self.size[0] - 1.0
    }

    /// Y in normalized device coordinates, 1 to -1 from top to bottom, so many pixels below the centre of a row
    /// of the framebuffer.
    #[inline(always)]
    pub(crate) fn ndc_y(&self, row: i32, below: f64) -> f64 {
        1.0 - (f64::from(row - self.corner.1) + 0.5 + below) * 2.0 / self.size[1]
    }

    /// Divides a position by its w and maps it to the screen.
    #[inline(always)]
    pub(crate) fn point<T: Scalar>(&self, [x, y, z, w]: [T; 4]) -> ScreenPoint<T> {
        let inv_w = w.splat(1.0) / w;
        let (x, y, z) = (x * inv_w, y * inv_w, z * inv_w);
        let [near, far] = self.depth;
        let z = match self.clip_space {
            ClipSpace::ZeroToOne => z,
            ClipSpace::MinusOneToOne => z * 0.5 + 0.5,
        };
        ScreenPoint {
            x: (x * 0.5 + 0.5) * self.size[0],
            y: (y * -0.5 + 0.5) * self.size[1],
            z: z * (far - near) + near,
            inv_w,
        }
    }
}
