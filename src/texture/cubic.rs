//! Cubic filters of two parameters (Mitchell and Netravali, "Reconstruction Filters in Computer
//! Graphics", SIGGRAPH 1988).

/// A filter of pieces of cubics over 4 texels along each axis, by its two parameters.
///
/// 2 C + B = 1 are those that follow a ramp and are neither too blurred nor too sharp. Where C is not 0
/// a colour may be a little beyond those of the texels, even below 0 or above 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    /// How much of the B-spline is in it.
    pub b: f32,
    /// How much of the cardinal spline.
    pub c: f32,
}

impl Cubic {
    /// The cubic B-spline: smooth, never beyond the texels' colours, and blurred.
    pub const B_SPLINE: Self = Self { b: 1.0, c: 0.0 };
    /// The Catmull-Rom spline: it goes through the texels, and is sharp.
    pub const CATMULL_ROM: Self = Self { b: 0.0, c: 0.5 };
    /// Mitchell and Netravali's own choice, between the two.
    pub const MITCHELL: Self = Self { b: 1.0 / 3.0, c: 1.0 / 3.0 };

    /// The weights of four texels in a line, for a point between the second and the third, at `t` from
    /// the second, 0 to 1.
    #[inline(always)]
    pub(super) fn weights(self, t: f32) -> [f32; 4] {
        [self.outer(1.0 + t), self.inner(t), self.inner(1.0 - t), self.outer(2.0 - t)]
    }

    /// For distances from 0 to 1.
    #[inline(always)]
    fn inner(self, x: f32) -> f32 {
        let Self { b, c } = self;
        let (p, q, s) = (12.0 - 9.0 * b - 6.0 * c, -18.0 + 12.0 * b + 6.0 * c, 6.0 - 2.0 * b);
        ((p * x + q) * x * x + s) * (1.0 / 6.0)
    }

    /// For distances from 1 to 2.
    #[inline(always)]
    fn outer(self, x: f32) -> f32 {
        let Self { b, c } = self;
        let (p, q) = (-b - 6.0 * c, 6.0 * b + 30.0 * c);
        let (r, s) = (-12.0 * b - 48.0 * c, 8.0 * b + 24.0 * c);
        (((p * x + q) * x + r) * x + s) * (1.0 / 6.0)
    }
}
