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
//!
//! # Outlines that fall into parts
//!
//! A concave polygon, or one with holes, may cross a plane more than twice. Sutherland and Hodgman
//! leave one contour then, its parts joined by edges that run to and fro along the plane: harmless
//! on paper, but when their ends are rounded to the grid of the screen they do not lie on one line
//! any more, and slivers open between them. Here the pieces of the outline on the inner side are
//! closed anew instead. Their ends are sorted along the plane; between each and the next one runs a
//! single edge that counts as often as the outline winds around the points inside of it, which is
//! the sum of the ends so far:
//!
//! ```text
//!     inside  |  |    |  |      pieces of the outline, down +1, up -1 at their ends
//!     --------A--B----C--D---   the plane: edges from A to B and from C to D, none from B to C
//!     outside
//! ```
//!
//! No two edges run along the same stretch of the plane, so nothing is left to cancel. The result
//! is a list of [`Chain`]s; the plane's may have any winding.

use glam::{DVec2, DVec3, DVec4, Vec3Swizzles, Vec4, Vec4Swizzles};

use crate::outline::{Chain, Outline};
use crate::project::Viewport;
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

/// What clipping made of an outline of any number of contours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClippedOutline<'a, const N: usize> {
    /// Nothing of it is left.
    Outside,
    /// All of it is inside: go on with the outline that was given.
    Inside,
    /// What is left of it: vertices, all with w >= [`W_MIN`], joined to [`Chain`]s.
    Chains {
        /// The vertices of all chains, end to end.
        vertices: &'a [Vertex<N>],
        /// The chains; together they are closed.
        chains: &'a [Chain],
    },
}

/// Which planes a vertex lies outside of: bit 0 for w >= [`W_MIN`], then a bit a plane. Planes from
/// the 31st on share the last bit, which says nothing when all vertices have it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

    /// Whether the vertex is inside of all planes.
    #[inline(always)]
    pub(crate) fn is_inside(self) -> bool {
        self == Self(0)
    }

    fn has(self, plane: usize) -> bool {
        self.0 & 1 << (plane + 1).min(31) != 0
    }
}

/// The planes of a draw call, near, far, left, right, bottom, top and the user's, with a quick way to
/// see that a position is inside of all, as most are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Volume<'a> {
    planes: &'a [ClipPlane],
    near: f64,
    sides: [f64; 2],
    quick: bool,
}

impl<'a> Volume<'a> {
    pub(crate) fn new(clip_space: ClipSpace, viewport: &Viewport, planes: &'a [ClipPlane]) -> Self {
        let near = match clip_space {
            ClipSpace::ZeroToOne => 0.0,
            ClipSpace::MinusOneToOne => -1.0,
        };
        Self { planes, near, sides: viewport.guard_factors(), quick: planes.len() == 6 }
    }

    /// The outcode of a position; of one that is not finite, one that is not inside.
    #[inline(always)]
    pub(crate) fn outcode(&self, position: DVec4) -> Outcode {
        // The same signs as those of the planes' distances.
        let [x, y, z, w] = position.to_array();
        let inside = (W_MIN..f64::INFINITY).contains(&w)
            && (self.near * w..=w).contains(&z)
            && x.abs() <= self.sides[0] * w
            && y.abs() <= self.sides[1] * w;
        if inside && self.quick {
            return Outcode::default();
        }
        if position.is_finite() { Outcode::new(position, self.planes) } else { Outcode(1) }
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
    /// Without chains the vertices are one closed contour.
    chains: Vec<Chain>,
    next: Vec<ClipVertex<N>>,
    next_chains: Vec<Chain>,
    crossings: Vec<Crossing>,
    rounded: Vec<Vertex<N>>,
}

/// Where a chain of the clipped outline begins or ends on the plane.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// The index of the vertex.
    vertex: usize,
    /// Where it lies along the plane.
    place: f64,
    /// The winding of the chain if it ends here, less that if it begins.
    change: i32,
}

impl<const N: usize> Default for Clipper<N> {
    fn default() -> Self {
        Self {
            vertices: Vec::new(),
            chains: Vec::new(),
            next: Vec::new(),
            next_chains: Vec::new(),
            crossings: Vec::new(),
            rounded: Vec::new(),
        }
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
    /// edges that run to and fro along a plane, which [`clip_outline`](Self::clip_outline) avoids.
    /// A polygon with a position that is not finite, or with fewer than three vertices, is outside.
    /// Parameters are interpolated in perspective; for other ways see
    /// [`clip_with`](Self::clip_with).
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
        match self.clip_vertices(planes, interpolation, Parts::Joined) {
            Outcome::Outside => Clipped::Outside,
            Outcome::Inside => Clipped::Inside,
            Outcome::Clipped => {
                self.round();
                Clipped::Polygon(&self.rounded)
            }
        }
    }

    /// The part of an outline on the inner side of all `planes`, with w >= [`W_MIN`]. Unlike
    /// [`clip`](Self::clip) it takes several contours, and the pieces into which the outline may
    /// fall are not joined: they are [`Chain`]s, ready for
    /// [`EdgeTable::fill_chains`](crate::edge_table::EdgeTable::fill_chains) once their vertices
    /// are projected.
    ///
    /// The sides of a planar outline, and the lines along which it was cut before, cross each plane
    /// once. So with n sides and k planes there are at most (k + 1) (n + k) edges in the end.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::clip::{ClippedOutline, Clipper};
    /// use polyscan::{ClipPlane, Vertex};
    ///
    /// let square = |size: f32| {
    ///     [(-size, -size), (size, -size), (size, size), (-size, size)]
    ///         .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []))
    /// };
    /// let mut hole = square(0.5);
    /// hole.reverse();
    /// let mut clipper = Clipper::new();
    /// let right_half = ClipPlane::new(vec4(1.0, 0.0, 0.0, 0.0));
    /// let clipped =
    ///     clipper.clip_outline(&[square(1.0), hole], &[right_half], &[Default::default(); 0]);
    /// let ClippedOutline::Chains { chains, .. } = clipped else {
    ///     panic!("the plane cuts the square");
    /// };
    /// // A half of each contour, and an edge above and one below the hole.
    /// assert_eq!(chains.len(), 4);
    /// ```
    pub fn clip_outline(
        &mut self,
        outline: &(impl Outline<N> + ?Sized),
        planes: &[ClipPlane],
        interpolation: &[Interpolation; N],
    ) -> ClippedOutline<'_, N> {
        self.load(outline, interpolation);
        match self.clip_vertices(planes, interpolation, Parts::Apart) {
            Outcome::Outside => ClippedOutline::Outside,
            Outcome::Inside => ClippedOutline::Inside,
            Outcome::Clipped => {
                self.close_contour();
                self.round();
                ClippedOutline::Chains { vertices: &self.rounded, chains: &self.chains }
            }
        }
    }

    /// Takes an outline in; one that cannot be drawn (see [`clip`](Self::clip)) leaves nothing.
    #[inline]
    pub(crate) fn load(
        &mut self,
        outline: &(impl Outline<N> + ?Sized),
        interpolation: &[Interpolation; N],
    ) {
        self.vertices.clear();
        self.chains.clear();
        let mut provoking = None;
        for contour in outline.contours() {
            if !contour.iter().all(|v| v.position.is_finite()) {
                self.vertices.clear();
                self.chains.clear();
                return;
            }
            if contour.len() < 3 {
                continue;
            }
            let provoking = *provoking.get_or_insert(&contour[0]);
            let vertex = |v| ClipVertex::from(v).flattened(provoking, interpolation);
            if self.vertices.is_empty() {
                self.vertices.extend(contour.iter().map(vertex));
            } else {
                self.close_contour();
                self.vertices.extend(contour.iter().chain(&contour[..1]).map(vertex));
                self.chains.push(Chain { end: self.vertices.len(), winding: 1 });
            }
        }
    }

    /// Turns one contour into a chain.
    fn close_contour(&mut self) {
        if self.chains.is_empty() {
            self.vertices.extend_from_within(..self.vertices.len().min(1));
            self.chains.push(Chain { end: self.vertices.len(), winding: 1 });
        }
    }

    /// The number of sides of the loaded polygon if it has one contour; 0 if it has more.
    pub(crate) fn sides(&self) -> usize {
        if self.chains.is_empty() { self.vertices.len() } else { 0 }
    }

    /// Rounds what clipping has left to f32.
    fn round(&mut self) {
        self.rounded.clear();
        self.rounded.extend(self.vertices.iter().map(|v| Vertex {
            position: v.position.as_vec4(),
            params: v.params.map(|r| r as f32),
        }));
    }

    /// The part of a polygon in working precision where `distance` is not negative. All of it must
    /// have w >= [`W_MIN`].
    pub(crate) fn part(
        &mut self,
        polygon: impl Iterator<Item = ClipVertex<N>>,
        distance: impl Fn(DVec4) -> f64,
    ) -> &[ClipVertex<N>] {
        self.vertices.clear();
        self.chains.clear();
        self.vertices.extend(polygon);
        self.clip_by(distance, |_| {}, &[Interpolation::Perspective; N], Parts::Joined);
        &self.vertices
    }

    /// The polygon in working precision, after [`load`](Self::load) and
    /// [`clip_vertices`](Self::clip_vertices).
    pub(crate) fn vertices(&self) -> &[ClipVertex<N>] {
        &self.vertices
    }

    /// The chains of these vertices; none if they are one contour.
    pub(crate) fn chains(&self) -> &[Chain] {
        &self.chains
    }

    /// Clips the loaded polygon in place.
    pub(crate) fn clip_vertices(
        &mut self,
        planes: &[ClipPlane],
        interpolation: &[Interpolation; N],
        parts: Parts,
    ) -> Outcome {
        let codes = self.vertices.iter().map(|v| Outcode::new(v.position, planes));
        let (outcome, any) = Outcode::outcome(codes);
        if outcome != Outcome::Clipped || self.vertices.is_empty() {
            return if self.vertices.is_empty() { Outcome::Outside } else { outcome };
        }
        // Eight times the vertices that a planar outline may get, two for an edge: see
        // `clip_outline`. Where many planes cut an outline that is far from planar, its vertices may
        // multiply without end, and it is left out.
        let cuts = planes.len() + 2;
        let limit = (16 * cuts).saturating_mul(self.vertices.len() + cuts);
        if any.0 & 1 != 0 {
            let settle = |position: &mut DVec4| position.w = W_MIN;
            self.clip_by(|position| position.w - W_MIN, settle, interpolation, parts);
        }
        for (_, plane) in planes.iter().enumerate().filter(|&(i, _)| any.has(i)) {
            let distance = |position| plane.distance(position);
            self.clip_by(distance, |position| plane.settle(position), interpolation, parts);
            if self.vertices.len() > limit {
                return Outcome::Outside;
            }
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
        self.clip_vertices(planes, interpolation, Parts::Apart)
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

    /// Keeps the part of the polygon where `distance` is not negative. `settle` moves a new vertex
    /// exactly to where the distance is 0.
    fn clip_by(
        &mut self,
        distance: impl Fn(DVec4) -> f64,
        settle: impl Fn(&mut DVec4),
        interpolation: &[Interpolation; N],
        parts: Parts,
    ) {
        let cut = |inner: &ClipVertex<N>, outer: &ClipVertex<N>, t| {
            let mut vertex = between(inner, outer, t, interpolation);
            settle(&mut vertex.position);
            vertex
        };
        if self.chains.is_empty() {
            let in_one = self.clip_contour_by(&distance, cut);
            if in_one || parts == Parts::Joined {
                std::mem::swap(&mut self.vertices, &mut self.next);
                return;
            }
            self.close_contour();
        }
        self.clip_chains_by(distance, cut);
        std::mem::swap(&mut self.vertices, &mut self.next);
        std::mem::swap(&mut self.chains, &mut self.next_chains);
    }

    /// Sutherland and Hodgman's step; whether the contour stays in one part. Then it crosses or
    /// touches the plane in no more than two places, and a single edge along the plane closes it.
    fn clip_contour_by(
        &mut self,
        distance: impl Fn(DVec4) -> f64,
        cut: impl Fn(&ClipVertex<N>, &ClipVertex<N>, f64) -> ClipVertex<N>,
    ) -> bool {
        self.next.clear();
        let [first, .., last] = self.vertices.as_slice() else { return true };
        let (mut before, mut da) = (distance(last.position), distance(first.position));
        // How often the contour changes sides, vertices on the plane counted to the one or the other.
        let (mut closed_changes, mut open_changes) = (0, 0);
        let ends = self.vertices.iter().skip(1).chain([first]);
        for (a, b) in self.vertices.iter().zip(ends) {
            let db = distance(b.position);
            // On the plane the contour turns inwards or outwards. Where it does neither, the edge
            // along the plane takes its place.
            if da > 0.0 || da == 0.0 && (before > 0.0 || db > 0.0) {
                self.next.push(*a);
            }
            if da > 0.0 && db < 0.0 {
                self.next.push(cut(a, b, da / (da - db)));
            } else if da < 0.0 && db > 0.0 {
                self.next.push(cut(b, a, db / (db - da)));
            }
            closed_changes += usize::from((da >= 0.0) != (db >= 0.0));
            open_changes += usize::from((da > 0.0) != (db > 0.0));
            (before, da) = (da, db);
        }
        closed_changes.max(open_changes) <= 2
    }

    /// Clips the chains to `next` and `next_chains`: see the module's text.
    #[cold]
    fn clip_chains_by(
        &mut self,
        distance: impl Fn(DVec4) -> f64,
        cut: impl Fn(&ClipVertex<N>, &ClipVertex<N>, f64) -> ClipVertex<N>,
    ) {
        self.next.clear();
        self.next_chains.clear();
        self.crossings.clear();
        let mut start = 0;
        for &Chain { end, winding } in &self.chains {
            let mut pieces = Pieces {
                vertices: &mut self.next,
                chains: &mut self.next_chains,
                crossings: &mut self.crossings,
                winding,
                is_open: false,
            };
            let chain = &self.vertices[start..end];
            let mut da = chain.first().map_or(0.0, |a| distance(a.position));
            for (a, b) in chain.iter().zip(chain.iter().skip(1)) {
                let db = distance(b.position);
                // An edge in the plane is left out: the edges along the plane take its place.
                if da > 0.0 || db > 0.0 {
                    let start = if da < 0.0 { cut(b, a, db / (db - da)) } else { *a };
                    let end = if db < 0.0 { cut(a, b, da / (da - db)) } else { *b };
                    pieces.add([start, end], [da <= 0.0, db <= 0.0]);
                }
                da = db;
            }
            pieces.end();
            start = end;
        }
        self.close_along_plane();
    }

    /// Joins the ends of the pieces along the plane.
    fn close_along_plane(&mut self) {
        let Self { next: vertices, next_chains: chains, crossings, .. } = self;
        sort_along_plane(vertices, crossings);
        let mut winding = 0i32;
        for (i, crossing) in crossings.iter().enumerate() {
            winding = crossing.change.wrapping_add(winding);
            let Some(after) = crossings.get(i + 1) else { break };
            let (a, b) = (vertices[crossing.vertex], vertices[after.vertex]);
            if winding != 0 && a.position != b.position {
                vertices.extend([a, b]);
                chains.push(Chain { end: vertices.len(), winding });
            }
        }
    }
}

/// How the parts are left into which a contour falls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parts {
    /// In one contour, by edges to and fro.
    Joined,
    /// As chains.
    Apart,
}

/// The pieces of a chain on the inner side of a plane.
struct Pieces<'a, const N: usize> {
    vertices: &'a mut Vec<ClipVertex<N>>,
    chains: &'a mut Vec<Chain>,
    crossings: &'a mut Vec<Crossing>,
    winding: i32,
    is_open: bool,
}

impl<const N: usize> Pieces<'_, N> {
    /// Adds the next edge, and whether its start and its end lie on the plane: there pieces begin
    /// and end.
    fn add(&mut self, [start, end]: [ClipVertex<N>; 2], [starts, ends]: [bool; 2]) {
        if !self.is_open {
            self.vertices.push(start);
            self.is_open = true;
        }
        if starts {
            self.cross(self.winding.wrapping_neg());
        }
        self.vertices.push(end);
        if ends {
            self.cross(self.winding);
            self.end();
        }
    }

    /// Notes that the last vertex lies on the plane.
    fn cross(&mut self, change: i32) {
        self.crossings.push(Crossing { vertex: self.vertices.len() - 1, place: 0.0, change });
    }

    /// Ends the piece, if there is one.
    fn end(&mut self) {
        if std::mem::take(&mut self.is_open) {
            self.chains.push(Chain { end: self.vertices.len(), winding: self.winding });
        }
    }
}

/// Sorts crossings with a plane along the line in which it cuts the polygon's own plane, as it is
/// seen on the screen: by x/w or y/w, whichever varies more. All w are positive here.
fn sort_along_plane<const N: usize>(vertices: &[ClipVertex<N>], crossings: &mut [Crossing]) {
    let on_screen = |crossing: &Crossing| {
        let position = vertices[crossing.vertex].position;
        position.xy() / position.w
    };
    let (min, max) = crossings
        .iter()
        .map(on_screen)
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), place| {
            (min.min(place), max.max(place))
        });
    let axis = usize::from(max.y - min.y > max.x - min.x);
    for crossing in crossings.iter_mut() {
        crossing.place = on_screen(crossing)[axis];
    }
    crossings.sort_unstable_by(|a, b| a.place.total_cmp(&b.place).then(a.vertex.cmp(&b.vertex)));
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
