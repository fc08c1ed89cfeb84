//! What all the parameters of a polygon have in common: depth, 1/w, and how w varies.

use crate::settings::{DepthBias, DrawCall};
use crate::surface::plane::ScreenPlane;

/// How the parameters of a polygon are found from its planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Divide {
    /// All are divided by 1/w at each pixel.
    PerPixel,
    /// None is: all w are equal.
    Never,
    /// Some are and some are not, or their range must be watched: see [`Mixed`].
    ///
    /// [`Mixed`]: crate::surface::mixed::Mixed
    Mixed,
}

/// The w of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WRange {
    /// All vertices have the same w: nothing is divided at the pixels.
    Constant { w: f32, inv_w: f32 },
    /// w is between the values of `w`; 1/w, in the polygon's unit, between those of `inv_w`.
    Varying { w: (f32, f32), inv_w: (f32, f32) },
}

impl WRange {
    /// For w and 1/w from the first to the second value, the latter in the polygon's unit.
    #[inline(always)]
    pub(crate) fn new(w: [f64; 2], inv_w: [f64; 2]) -> Self {
        let w = (w[0] as f32, w[1] as f32);
        // Clipping in f64 may leave less than f32 can tell apart.
        if w.0 == w.1 {
            return Self::Constant { w: w.0, inv_w: 1.0 / w.0 };
        }
        // Below the smallest normal number the reciprocal would not be finite: w ratios over 2^126.
        let least = (inv_w[0] as f32).max(f32::MIN_POSITIVE);
        Self::Varying { w, inv_w: (least, inv_w[1] as f32) }
    }

    /// The smallest and the largest w.
    #[inline(always)]
    pub(crate) fn range(self) -> (f32, f32) {
        match self {
            Self::Constant { w, .. } => (w, w),
            Self::Varying { w, .. } => w,
        }
    }

    /// Whether w varies, so that pixels need a division.
    pub(crate) fn varies(self) -> bool {
        matches!(self, Self::Varying { .. })
    }
}

/// Depth, 1/w, and what is known of a polygon as a whole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceBase {
    /// The corner of the viewport on the framebuffer.
    pub(crate) corner: (i32, i32),
    /// The last column of the viewport, relative to its first.
    pub(crate) last_column: i32,
    /// The number of the polygon in its mesh.
    pub(crate) face: u32,
    /// Whether its front is seen.
    pub(crate) is_front: bool,
    /// The origin of the planes on the screen, in pixels.
    pub(crate) origin: [f64; 2],
    pub(crate) z: ScreenPlane,
    /// 1/w, in the polygon's unit.
    pub(crate) inv_w: ScreenPlane,
    /// The smallest and the largest depth.
    pub(crate) z_range: (f32, f32),
    /// The unit in which w is measured: the power of two at or below the polygon's smallest w. So
    /// 1/w is at most 1 in it, and neither that nor any s overflows f32, however near the eye.
    pub(crate) w_unit: f64,
    pub(crate) w: WRange,
    pub(crate) divide: Divide,
}

impl Default for SurfaceBase {
    fn default() -> Self {
        Self {
            corner: (0, 0),
            last_column: 0,
            face: 0,
            is_front: true,
            origin: [0.0; 2],
            z: ScreenPlane::default(),
            inv_w: ScreenPlane::default(),
            z_range: (0.0, 1.0),
            w_unit: 1.0,
            w: WRange::Constant { w: 1.0, inv_w: 1.0 },
            divide: Divide::Mixed,
        }
    }
}

impl SurfaceBase {
    /// Moves the depths by the call's bias, and returns by how much.
    #[inline(always)]
    pub(crate) fn add_bias(&mut self, call: &DrawCall<'_>) -> f64 {
        if call.depth_bias == DepthBias::default() {
            return 0.0;
        }
        self.add_some_bias(call.depth_bias)
    }

    #[cold]
    fn add_some_bias(&mut self, DepthBias { constant, slope }: DepthBias) -> f64 {
        let steepest = self.z.dx.abs().max(self.z.dy.abs());
        let bias = f64::from(constant) + f64::from(slope) * steepest;
        let bias = if bias.is_finite() { bias } else { 0.0 };
        self.z.value += bias;
        let moved = |z: f32| (f64::from(z) + bias).clamp(0.0, 1.0) as f32;
        self.z_range = (moved(self.z_range.0), moved(self.z_range.1));
        bias
    }
}
