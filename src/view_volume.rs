//! The view volume: the planes of clip space, and on which side of them a position is.
//!
//! Outcodes say this in bits, one for each plane (Sutherland, in Newman and Sproull, "Principles of
//! Interactive Computer Graphics", 1973). From the codes of its vertices a polygon is known to be
//! inside of all planes, outside of one, or in need of [clipping](crate::clip).

use glam::{DVec4, Vec4};

use crate::viewport::{GUARD_BAND, Viewport};

/// The smallest w that a clipped vertex may have: the smallest normal f32, so that w stays
/// positive when it is rounded to f32, and 1/w stays finite.
pub const MIN_W: f64 = f32::MIN_POSITIVE as f64;

/// The depth convention of clip space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ClipSpace {
    /// 0 <= z <= w: wgpu, Direct3D, Metal, Vulkan, `glam::camera::rh::proj::directx`.
    #[default]
    ZeroToOne,
    /// -w <= z <= w: OpenGL, `glam::camera::rh::proj::opengl`.
    MinusOneToOne,
}

impl ClipSpace {
    /// The planes of the view volume: near, far, left, right, bottom, top.
    #[must_use]
    pub fn frustum(self) -> [ClipPlane; 6] {
        let [near, far] = self.near_far();
        let [left, right, bottom, top] = ClipPlane::sides(1.0, 1.0);
        [near, far, left, right, bottom, top]
    }

    /// The planes that polygons are clipped by to be drawn in a viewport: near, far, and the sides of
    /// the [guard band](GUARD_BAND).
    pub(crate) fn drawable(self, viewport: &Viewport) -> [ClipPlane; 6] {
        let [near, far] = self.near_far();
        let [x, y] = guard_factors(viewport);
        let [left, right, bottom, top] = ClipPlane::sides(x, y);
        [near, far, left, right, bottom, top]
    }

    fn near_far(self) -> [ClipPlane; 2] {
        let near = match self {
            Self::ZeroToOne => DVec4::new(0.0, 0.0, 1.0, 0.0),
            Self::MinusOneToOne => DVec4::new(0.0, 0.0, 1.0, 1.0),
        };
        [ClipPlane::bound(near), ClipPlane::bound(DVec4::new(0.0, 0.0, -1.0, 1.0))]
    }
}

/// How many times wider and higher than the viewport the guard band is.
fn guard_factors(viewport: &Viewport) -> [f64; 2] {
    let rect = viewport.rect();
    [rect.width, rect.height].map(|size| 1.0 + 2.0 * f64::from(GUARD_BAND) / f64::from(size.max(1)))
}

/// A plane through the origin of homogeneous space; the inner side is where its product with the
/// position is not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    form: DVec4,
    /// Whether it bounds the view volume: then nobody asks for what is on its other side.
    is_bound: bool,
}

impl ClipPlane {
    /// The plane a x + b y + c z + d w >= 0 in clip space.
    ///
    /// A plane given in object space is brought to clip space by the inverse transpose of the
    /// matrix that brings points there. Coefficients that are not all finite make no plane: nothing
    /// is cut.
    ///
    /// A plane and its opposite, with all signs changed, part a polygon: what one of them leaves and what
    /// the other leaves cover each of its pixels once.
    #[must_use]
    pub fn new(coefficients: Vec4) -> Self {
        let is_finite = coefficients.is_finite();
        let form = if is_finite { coefficients.as_dvec4() } else { DVec4::ZERO };
        Self { form, is_bound: false }
    }

    fn bound(form: DVec4) -> Self {
        Self { form, is_bound: true }
    }

    /// The planes -gx w <= x <= gx w and -gy w <= y <= gy w: left, right, bottom, top.
    fn sides(gx: f64, gy: f64) -> [Self; 4] {
        [
            Self::bound(DVec4::new(1.0, 0.0, 0.0, gx)),
            Self::bound(DVec4::new(-1.0, 0.0, 0.0, gx)),
            Self::bound(DVec4::new(0.0, 1.0, 0.0, gy)),
            Self::bound(DVec4::new(0.0, -1.0, 0.0, gy)),
        ]
    }

    /// The signed distance to the plane, up to a positive factor. For the planes of the view volume
    /// its sign is exact: it is one subtraction of two f32 values.
    pub(crate) fn distance(&self, position: DVec4) -> f64 {
        self.form.dot(position)
    }

    /// Whether a crossing is computed from the outer of two ends: on a plane whose other side may be
    /// wanted, too, from the smaller end, so that rounding is least, or of two alike from the one whose
    /// coordinates first are less. So both sides find the same.
    pub(crate) fn cuts_from_outside(&self, inner: DVec4, outer: DVec4) -> bool {
        if !self.has_two_sides() {
            return false;
        }
        let (inner_size, outer_size) = (inner.abs().max_element(), outer.abs().max_element());
        if inner_size != outer_size {
            return outer_size < inner_size;
        }
        let (inner, outer) = (inner.to_array(), outer.to_array());
        inner.iter().zip(&outer).find(|(i, o)| i != o).is_some_and(|(i, o)| o < i)
    }

    /// Whether what is on the plane's other side may be wanted, too.
    pub(crate) fn has_two_sides(&self) -> bool {
        !self.is_bound
    }

    /// Removes the rounding error of a vertex that should lie on the plane, where the plane is one
    /// of those that bound x, y or z alone. Far outside, at 10^20 say, that error is all there is.
    pub(crate) fn snap(&self, position: &mut DVec4) {
        let [x, y, z, w] = self.form.to_array();
        match [x != 0.0, y != 0.0, z != 0.0] {
            [true, false, false] => position.x = (0.0 - w * position.w) / x,
            [false, true, false] => position.y = (0.0 - w * position.w) / y,
            [false, false, true] => position.z = (0.0 - w * position.w) / z,
            _ => {}
        }
    }
}

/// Which planes a vertex lies outside of: bit 0 for w >= [`MIN_W`], then a bit a plane. Planes from
/// the 31st on share the last bit, which says nothing when all vertices have it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Outcode(u32);

impl Outcode {
    const SHARED: u32 = 1 << 31;

    #[inline(always)]
    pub(crate) fn new(position: DVec4, planes: &[ClipPlane]) -> Self {
        let mut code = u32::from(position.w < MIN_W);
        for (i, plane) in planes.iter().enumerate() {
            code |= u32::from(plane.distance(position) < 0.0) << (i + 1).min(31);
        }
        Self(code)
    }

    /// What clipping makes of the polygon whose vertices have these codes, as far as they tell, and the
    /// planes that any vertex is outside of.
    #[inline(always)]
    pub(crate) fn outcome(codes: impl Iterator<Item = Self>) -> (Outcome, Self) {
        let (any, all) =
            codes.fold((0, !Self::SHARED), |(any, all), Self(code)| (any | code, all & code));
        let outcome = match (any, all) {
            (_, 1..) => Outcome::Outside,
            (0, _) => Outcome::Inside,
            _ => Outcome::Clipped,
        };
        (outcome, Self(any))
    }

    /// Whether the vertex is inside of all planes.
    #[inline(always)]
    pub(crate) fn is_inside(self) -> bool {
        self == Self(0)
    }

    /// Whether w is less than [`MIN_W`].
    pub(crate) fn is_behind_eye(self) -> bool {
        self.0 & 1 != 0
    }

    pub(crate) fn has(self, plane: usize) -> bool {
        self.0 & 1 << (plane + 1).min(31) != 0
    }
}

/// What clipping makes of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Outside,
    Inside,
    Clipped,
}

/// The planes of a draw call, near, far, left, right, bottom, top and the user's, with a quick way to
/// see that a position is inside of all, as most are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewVolume<'a> {
    planes: &'a [ClipPlane],
    near: f64,
    sides: [f64; 2],
    has_frustum_planes_only: bool,
}

impl<'a> ViewVolume<'a> {
    pub(crate) fn new(clip_space: ClipSpace, viewport: &Viewport, planes: &'a [ClipPlane]) -> Self {
        let near = match clip_space {
            ClipSpace::ZeroToOne => 0.0,
            ClipSpace::MinusOneToOne => -1.0,
        };
        let has_frustum_planes_only = planes.len() == 6;
        Self { planes, near, sides: guard_factors(viewport), has_frustum_planes_only }
    }

    /// Whether a position is inside of all planes, as far as these are those of the view volume alone.
    #[inline(always)]
    pub(crate) fn holds(&self, position: DVec4) -> bool {
        // The same signs as those of the planes' distances, without branches: loops become SIMD.
        let [x, y, z, w] = position.to_array();
        (MIN_W..f64::INFINITY).contains(&w)
            & (self.near * w..=w).contains(&z)
            & (x.abs() <= self.sides[0] * w)
            & (y.abs() <= self.sides[1] * w)
            & self.has_frustum_planes_only
    }

    /// The outcode of a position; of one that is not finite, one that is not inside.
    #[inline(always)]
    pub(crate) fn outcode(&self, position: DVec4) -> Outcode {
        if self.holds(position) {
            return Outcode::default();
        }
        if position.is_finite() { Outcode::new(position, self.planes) } else { Outcode(1) }
    }
}
