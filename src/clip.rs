//! Clipping before the division: a polygon in clip space in, the part of it on the inner side of
//! every plane out.
//!
//! This is Sutherland and Hodgman's reentrant clipper in homogeneous coordinates, generic over the
//! parameter record (Heckbert, "Generic Convex Polygon Scan Conversion and Clipping", Graphics Gems
//! 1990). Working before the division, it needs no case for vertices at or behind the eye.
//!
//! Two properties make meshes watertight: a new vertex on an edge depends on the edge alone (it is
//! computed from the inner end point towards the outer one, so the direction in which a polygon
//! runs along the edge does not matter), and a vertex exactly on a plane is kept as it is.
//! Arithmetic is f64 throughout, so that clipping by many planes adds no visible error.

use glam::{DVec3, DVec4, Vec3Swizzles, Vec4, Vec4Swizzles};

use crate::vertex::{Interpolation, Vertex};

/// The smallest w that a clipped vertex may have: the smallest normal f32, so that w stays
/// positive when it is rounded to f32, and 1/w stays finite.
pub const W_MIN: f64 = f32::MIN_POSITIVE as f64;

/// The depth convention of clip space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ClipSpace {
    /// 0 <= z <= w: wgpu, Direct3D, Metal, `glam::camera::rh::proj::directx`.
    #[default]
    ZeroToOne,
    /// -w <= z <= w: OpenGL, `glam::camera::rh::proj::opengl`.
    MinusOneToOne,
}

impl ClipSpace {
    /// The planes of the view volume: near, far, left, right, bottom, top.
    pub fn frustum(self) -> [ClipPlane; 6] {
        let [near, far] = self.near_far();
        let [left, right, bottom, top] = ClipPlane::sides(1.0, 1.0);
        [near, far, left, right, bottom, top]
    }

    /// The near and the far plane.
    pub(crate) fn near_far(self) -> [ClipPlane; 2] {
        let near = match self {
            Self::ZeroToOne => DVec4::new(0.0, 0.0, 1.0, 0.0),
            Self::MinusOneToOne => DVec4::new(0.0, 0.0, 1.0, 1.0),
        };
        [ClipPlane(near), ClipPlane(DVec4::new(0.0, 0.0, -1.0, 1.0))]
    }
}

/// A plane through the origin of homogeneous space; the inner side is where its product with the
/// position is not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane(DVec4);

impl ClipPlane {
    /// The plane a x + b y + c z + d w >= 0 in clip space.
    ///
    /// A plane given in object space is brought to clip space by the inverse transpose of the
    /// matrix that brings points there. Coefficients that are not all finite make no plane: nothing
    /// is cut.
    pub fn new(coefficients: Vec4) -> Self {
        Self(if coefficients.is_finite() { coefficients.as_dvec4() } else { DVec4::ZERO })
    }

    /// The planes -gx w <= x <= gx w and -gy w <= y <= gy w: left, right, bottom, top.
    pub(crate) fn sides(gx: f64, gy: f64) -> [Self; 4] {
        [
            Self(DVec4::new(1.0, 0.0, 0.0, gx)),
            Self(DVec4::new(-1.0, 0.0, 0.0, gx)),
            Self(DVec4::new(0.0, 1.0, 0.0, gy)),
            Self(DVec4::new(0.0, -1.0, 0.0, gy)),
        ]
    }

    /// The signed distance to the plane, up to a positive factor. For the planes of the view volume
    /// its sign is exact: it is one subtraction of two f32 values.
    fn distance(&self, position: DVec4) -> f64 {
        self.0.dot(position)
    }

    /// Removes the rounding error of a vertex that should lie on the plane, where the plane is one
    /// of those that bound x, y or z alone. Far outside, at 10^20 say, that error is all there is.
    fn settle(&self, position: &mut DVec4) {
        let [x, y, z, w] = self.0.to_array();
        match [x != 0.0, y != 0.0, z != 0.0] {
            [true, false, false] => position.x = (0.0 - w * position.w) / x,
            [false, true, false] => position.y = (0.0 - w * position.w) / y,
            [false, false, true] => position.z = (0.0 - w * position.w) / z,
            _ => {}
        }
    }
}

/// What clipping made of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clipped<'a, const N: usize> {
    /// Nothing of it is left. A polygon that merely touches a plane from outside is outside.
    Outside,
    /// All of it is inside: go on with the polygon that was given.
    Inside,
    /// What is left of it: at least three vertices, all with w >= [`W_MIN`].
    Polygon(&'a [Vertex<N>]),
}

/// Which planes a vertex lies outside of: bit 0 for w >= [`W_MIN`], then a bit a plane. Planes from
/// the 31st on share the last bit, which says nothing when all vertices have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Outcode(u32);

impl Outcode {
    const SHARED: u32 = 1 << 31;

    #[inline(always)]
    pub(crate) fn new(position: DVec4, planes: &[ClipPlane]) -> Self {
        let mut code = u32::from(position.w < W_MIN);
        for (i, plane) in planes.iter().enumerate() {
            code |= u32::from(plane.distance(position) < 0.0) << (i + 1).min(31);
        }
        Self(code)
    }

    /// What clipping makes of the polygon whose vertices have these codes, as far as they tell.
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

    fn has(self, plane: usize) -> bool {
        self.0 & 1 << (plane + 1).min(31) != 0
    }
}

/// A vertex in the precision in which clipping works.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClipVertex<const N: usize> {
    pub(crate) position: DVec4,
    pub(crate) params: [f64; N],
}

impl<const N: usize> From<&Vertex<N>> for ClipVertex<N> {
    #[inline(always)]
    fn from(vertex: &Vertex<N>) -> Self {
        Self { position: vertex.position.as_dvec4(), params: vertex.params.map(f64::from) }
    }
}

impl<const N: usize> ClipVertex<N> {
    /// The vertex with the first vertex's value where a parameter is flat.
    #[inline(always)]
    pub(crate) fn flattened(
        mut self,
        provoking: &Vertex<N>,
        interpolation: &[Interpolation; N],
    ) -> Self {
        for (i, interpolation) in interpolation.iter().enumerate() {
            if *interpolation == Interpolation::Flat {
                self.params[i] = f64::from(provoking.params[i]);
            }
        }
        self
    }
}

/// What clipping made of the vertices in [`Clipper::vertices`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Outside,
    Inside,
    Clipped,
}

/// The clipper, with the memory it works in: reuse it, and it stops allocating.
///
/// ```
/// use glam::vec4;
/// use polyscan::{ClipSpace, Vertex, clip::{Clipped, Clipper}};
///
/// let triangle = [
///     Vertex::new(vec4(0.0, 0.0, 0.5, 1.0), [0.0]),
///     Vertex::new(vec4(2.0, 0.0, 0.5, 1.0), [1.0]),
///     Vertex::new(vec4(0.0, 0.5, 0.5, 1.0), [0.0]),
/// ];
/// let mut clipper = Clipper::new();
/// let Clipped::Polygon(quad) = clipper.clip(&triangle, &ClipSpace::ZeroToOne.frustum()) else {
///     panic!("the right plane cuts the triangle");
/// };
/// assert_eq!(quad[1], Vertex::new(vec4(1.0, 0.0, 0.5, 1.0), [0.5]));
/// ```
#[derive(Clone, Debug)]
pub struct Clipper<const N: usize> {
    vertices: Vec<ClipVertex<N>>,
    next: Vec<ClipVertex<N>>,
    rounded: Vec<Vertex<N>>,
}

impl<const N: usize> Default for Clipper<N> {
    fn default() -> Self {
        Self { vertices: Vec::new(), next: Vec::new(), rounded: Vec::new() }
    }
}

impl<const N: usize> Clipper<N> {
    /// A clipper without memory yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Clips a polygon by any number of planes, in their order, and by w >= [`W_MIN`] before them.
    ///
    /// The polygon has any number of vertices. A convex one that is cut by k planes keeps at most
    /// k + 1 sides more than it had; one that is not convex may fall apart into pieces joined by
    /// edges that run to and fro along a plane. A polygon with a position that is not finite, or
    /// with fewer than three vertices, is outside. Parameters are interpolated in perspective; for
    /// other ways see [`clip_with`](Self::clip_with).
    pub fn clip(&mut self, polygon: &[Vertex<N>], planes: &[ClipPlane]) -> Clipped<'_, N> {
        self.clip_with(polygon, planes, &[Interpolation::Perspective; N])
    }

    /// Like [`clip`](Self::clip), with the way in which each parameter is interpolated: the ratio
    /// of a new vertex is measured on the screen for [`Interpolation::Linear`], and
    /// [`Interpolation::Flat`] parameters have the first vertex's value everywhere.
    pub fn clip_with(
        &mut self,
        polygon: &[Vertex<N>],
        planes: &[ClipPlane],
        interpolation: &[Interpolation; N],
    ) -> Clipped<'_, N> {
        self.load(polygon, interpolation);
        match self.clip_vertices(planes, interpolation) {
            Outcome::Outside => Clipped::Outside,
            Outcome::Inside => Clipped::Inside,
            Outcome::Clipped => {
                self.rounded.clear();
                self.rounded.extend(self.vertices.iter().map(|v| Vertex {
                    position: v.position.as_vec4(),
                    params: v.params.map(|r| r as f32),
                }));
                Clipped::Polygon(&self.rounded)
            }
        }
    }

    /// Takes a polygon in; one that cannot be drawn (see [`clip`](Self::clip)) leaves none.
    pub(crate) fn load(&mut self, polygon: &[Vertex<N>], interpolation: &[Interpolation; N]) {
        self.vertices.clear();
        if polygon.len() < 3 || !polygon.iter().all(|v| v.position.is_finite()) {
            return;
        }
        let provoking = &polygon[0];
        let vertices =
            polygon.iter().map(|v| ClipVertex::from(v).flattened(provoking, interpolation));
        self.vertices.extend(vertices);
    }

    /// The part of a polygon in working precision where `distance` is not negative. All of it must
    /// have w >= [`W_MIN`].
    pub(crate) fn part(
        &mut self,
        polygon: impl Iterator<Item = ClipVertex<N>>,
        distance: impl Fn(DVec4) -> f64,
    ) -> &[ClipVertex<N>] {
        self.vertices.clear();
        self.vertices.extend(polygon);
        self.clip_by(distance, |_| {}, &[Interpolation::Perspective; N]);
        &self.vertices
    }

    /// The polygon in working precision, after [`load`](Self::load) and
    /// [`clip_vertices`](Self::clip_vertices).
    pub(crate) fn vertices(&self) -> &[ClipVertex<N>] {
        &self.vertices
    }

    /// Clips the loaded polygon in place.
    pub(crate) fn clip_vertices(
        &mut self,
        planes: &[ClipPlane],
        interpolation: &[Interpolation; N],
    ) -> Outcome {
        let codes = self.vertices.iter().map(|v| Outcode::new(v.position, planes));
        let (outcome, any) = Outcode::outcome(codes);
        if outcome != Outcome::Clipped || self.vertices.is_empty() {
            return if self.vertices.is_empty() { Outcome::Outside } else { outcome };
        }
        if any.0 & 1 != 0 {
            let settle = |position: &mut DVec4| position.w = W_MIN;
            self.clip_by(|position| position.w - W_MIN, settle, interpolation);
        }
        for (_, plane) in planes.iter().enumerate().filter(|&(i, _)| any.has(i)) {
            let distance = |position| plane.distance(position);
            self.clip_by(distance, |position| plane.settle(position), interpolation);
        }
        if self.vertices.len() < 3 { Outcome::Outside } else { Outcome::Clipped }
    }

    /// Clips the loaded polygon in place, as far as it can be seen: see
    /// [`is_edge_on_at_eye`](Self::is_edge_on_at_eye).
    pub(crate) fn clip_to_view(
        &mut self,
        planes: &[ClipPlane],
        interpolation: &[Interpolation; N],
    ) -> Outcome {
        if self.is_edge_on_at_eye() {
            return Outcome::Outside;
        }
        self.clip_vertices(planes, interpolation)
    }

    /// Whether the loaded polygon reaches the eye, or behind it, in a plane that runs through the
    /// eye: no area of it is seen, but clipping would make up places on the screen from rounding
    /// errors.
    fn is_edge_on_at_eye(&self) -> bool {
        if self.vertices.iter().all(|v| v.position.w >= W_MIN) {
            return false;
        }
        let rays = || self.vertices.iter().map(|v| v.position.xyw());
        let longest = |a: &DVec3, b: &DVec3| a.length_squared().total_cmp(&b.length_squared());
        let a = rays().max_by(longest).unwrap_or_default();
        let b = rays().max_by(|b, c| longest(&a.cross(*b), &a.cross(*c))).unwrap_or_default();
        // A plane has no vertex off that of the rays to two of them. The products and their sums
        // are off by less than half of this, at 2^-53 each.
        const ROUNDING: f64 = 16.0 * f64::EPSILON;
        let (normal, size_a, size_b) = (a.cross(b), a.abs(), b.abs());
        let size = size_a.yzx() * size_b.zxy() + size_a.zxy() * size_b.yzx();
        rays().all(|c| c.dot(normal).abs() <= ROUNDING * c.abs().dot(size))
    }

    /// Sutherland and Hodgman's step: keeps the part of the polygon where `distance` is not
    /// negative. `settle` moves a new vertex exactly to where the distance is 0.
    fn clip_by(
        &mut self,
        distance: impl Fn(DVec4) -> f64,
        settle: impl Fn(&mut DVec4),
        interpolation: &[Interpolation; N],
    ) {
        self.next.clear();
        let cut = |inner: &ClipVertex<N>, outer: &ClipVertex<N>, t| {
            let mut vertex = between(inner, outer, t, interpolation);
            settle(&mut vertex.position);
            vertex
        };
        let Some(first) = self.vertices.first() else { return };
        let mut da = distance(first.position);
        let ends = self.vertices.iter().skip(1).chain([first]);
        for (a, b) in self.vertices.iter().zip(ends) {
            let db = distance(b.position);
            if da >= 0.0 {
                self.next.push(*a);
            }
            if da > 0.0 && db < 0.0 {
                self.next.push(cut(a, b, da / (da - db)));
            } else if da < 0.0 && db > 0.0 {
                self.next.push(cut(b, a, db / (db - da)));
            }
            da = db;
        }
        std::mem::swap(&mut self.vertices, &mut self.next);
    }
}

/// The vertex at `t` of the way from the inner end of an edge to the outer one.
fn between<const N: usize>(
    inner: &ClipVertex<N>,
    outer: &ClipVertex<N>,
    t: f64,
    interpolation: &[Interpolation; N],
) -> ClipVertex<N> {
    let mut position = inner.position + (outer.position - inner.position) * t;
    // Between ends of very different size rounding is large; it must not leave the edge's box, and
    // must not bring a vertex to the eye.
    position =
        position.max(inner.position.min(outer.position)).min(inner.position.max(outer.position));
    position.w = position.w.max(W_MIN);
    // The ratio as it is seen on the screen. An end behind the eye is not on the screen: there the
    // limit for an end just before the eye holds, where the edge is infinitely long.
    let on_screen = t * outer.position.w.max(0.0) / position.w;
    let params = std::array::from_fn(|i| {
        let t = if interpolation[i] == Interpolation::Linear { on_screen } else { t };
        inner.params[i] + (outer.params[i] - inner.params[i]) * t
    });
    ClipVertex { position, params }
}
