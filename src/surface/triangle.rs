//! The planes and ranges of a triangle that was not clipped: for one, or for a batch of eight at once.
//!
//! A small triangle's set-up takes as long as its pixels: one step after another, with divisions
//! among them. Here each step may be done for eight triangles at once, whose vertices lie side by side.

use crate::project::ScreenPoint;
use crate::scalar::Scalar;
use crate::settings::DrawCall;
use crate::subpixel::SUBPIXELS;
use crate::surface::plane::{PlaneBasis, ScreenPlane};
use crate::vertex::Interpolation;

/// The least 1/w, where the greatest is 1 or little less, that is still exact to f32 when it comes
/// out of sums in f64: rounded in units of 2^-53, it is off by 2^-27 of itself.
const LEAST_EXACT: f64 = 1.0 / (1 << 26) as f64;

/// What is found of a triangle, or of each of a batch, besides the planes of its parameters.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TriangleSurface<T> {
    pub(crate) origin: [T; 2],
    pub(crate) z: ScreenPlane<T>,
    pub(crate) inv_w: ScreenPlane<T>,
    pub(crate) w_unit: T,
    /// The least and the greatest w.
    pub(crate) w: [T; 2],
    /// The least and the greatest 1/w, in the unit.
    pub(crate) inv_w_range: [T; 2],
    pub(crate) z_range: [T; 2],
}

impl<T: Copy> TriangleSurface<T> {
    /// Finds the planes of a triangle from its positions in clip space, and calls `store` with the
    /// plane of each parameter, whose values at the vertices `params` gives. Also returns whether the
    /// planes hold at every pixel centre, and either all parameters are divided by 1/w or none is;
    /// a triangle that fails this is set up as other polygons are.
    #[inline(always)]
    pub(crate) fn new(
        call: &DrawCall<'_>,
        [a, b, c]: [[T; 4]; 3],
        params: impl Fn(usize) -> [T; 3],
        mut store: impl FnMut(usize, ScreenPlane<T>),
    ) -> (Self, T::Mask)
    where
        T: Scalar,
    {
        let w = T::range([a[3], b[3], c[3]]);
        let w_unit = w[0].power_of_two_below();
        let varies = w[0].is_less(w[1]);
        let [a, b, c] =
            [project(call, a, w_unit), project(call, b, w_unit), project(call, c, w_unit)];
        let inv_w_range = T::range([a.inv_w, b.inv_w, c.inv_w]);
        let z_range = T::range([a.z, b.z, c.z]);
        let basis = PlaneBasis::new([[a.x, a.y], [b.x, b.y], [c.x, c.y]]);
        let z = basis.plane([a.z, b.z, c.z]);
        let inv_w = basis.plane([a.inv_w, b.inv_w, c.inv_w]);
        let slopes = z.dx + inv_w.dx + (z.dy + inv_w.dy);

        let mut sum = w_unit.splat(0.0);
        for i in 0..call.params() {
            let [ra, rb, rc] = params(i);
            let s = if is_divided(call, i) {
                [
                    T::select(varies, ra * a.inv_w, ra),
                    T::select(varies, rb * b.inv_w, rb),
                    T::select(varies, rc * c.inv_w, rc),
                ]
            } else {
                [ra, rb, rc]
            };
            let plane = basis.plane(s);
            sum = sum + s[0].abs() + s[1].abs() + s[2].abs() + plane.dx.abs() + plane.dy.abs();
            store(i, plane);
        }
        let mut is_plain = basis.is_wide
            & slopes.is_finite()
            & !(varies & is_steep(&inv_w, inv_w_range[0]))
            & fits_f32(sum);
        if !call.is_all_perspective {
            is_plain = is_plain & !varies;
        }
        let origin = [a.x, a.y];
        (Self { origin, z, inv_w, w_unit, w, inv_w_range, z_range }, is_plain)
    }

    /// `f` of each number.
    #[inline(always)]
    pub(crate) fn map<U>(&self, f: impl Fn(&T) -> U + Copy) -> TriangleSurface<U> {
        let two = |[a, b]: &[T; 2]| [f(a), f(b)];
        TriangleSurface {
            origin: two(&self.origin),
            z: self.z.map(f),
            inv_w: self.inv_w.map(f),
            w_unit: f(&self.w_unit),
            w: two(&self.w),
            inv_w_range: two(&self.inv_w_range),
            z_range: two(&self.z_range),
        }
    }
}

/// Whether a parameter is divided by 1/w where w varies.
#[inline(always)]
pub(crate) fn is_divided(call: &DrawCall<'_>, param: usize) -> bool {
    call.is_all_perspective || call.interpolation[param] == Interpolation::Perspective
}

/// A vertex on the screen; 1/w in a unit.
#[inline(always)]
pub(crate) fn project<T: Scalar>(
    call: &DrawCall<'_>,
    position: [T; 4],
    w_unit: T,
) -> ScreenPoint<T> {
    let mut point = call.projection.point(position);
    point.inv_w = point.inv_w * w_unit;
    // Clipping has brought it here but for rounding.
    let (least, greatest) = call.projection.depth_range();
    point.z = point.z.greater(point.z.splat(least)).lesser(point.z.splat(greatest));
    point
}

/// Whether 1/w, as it is found at a pixel centre, may leave the range of the vertices by more than a
/// quarter of its least value: by its slope, since the centre may lie outside the unrounded polygon
/// by half a subpixel along each axis, or by rounding.
#[inline(always)]
pub(crate) fn is_steep<T: Scalar>(inv_w: &ScreenPlane<T>, least: T) -> T::Mask {
    let change = inv_w.dx.abs() + inv_w.dy.abs();
    let is_large = (least * 0.25).is_less(change * (0.5 / f64::from(SUBPIXELS)));
    least.is_less(change.splat(LEAST_EXACT)) | is_large
}

/// Whether every s is within f32, as it is at the vertices and at pixel centres, which are less than
/// a pixel away from the polygon. `sum` is the sum of all their sizes and slopes.
#[inline(always)]
pub(crate) fn fits_f32<T: Scalar>(sum: T) -> T::Mask {
    // Written so that NaN does not fit.
    sum.is_less(sum.splat(f64::from(f32::MAX)))
}
