//! Clipping before the division: a polygon in clip space in, the part of it on the inner side of
//! every plane out.
//!
//! This is Sutherland and Hodgman's reentrant clipper in homogeneous coordinates, generic over the
//! parameter record (Heckbert, "Generic Convex Polygon Scan Conversion and Clipping", Graphics Gems
//! 1990). Working before the division, it needs no case for vertices at or behind the eye.
//!
//! Three properties make meshes watertight: a new vertex on an edge depends on the edge and the plane
//! alone, not on the direction in which a polygon runs along the edge, nor on the side that is kept;
//! a vertex exactly on a plane is kept as it is; and arithmetic is f64 throughout, so that clipping by
//! many planes adds no visible error.
//!
//! To go on to the [edge table](crate::coverage::EdgeTable) and a [`Surface`](crate::Surface) use
//! [`Clipper::clip_outline`]; [`Clipper::clip`] is for a polygon by itself.
//!
//! The step itself is in `clip::polygon`, over the `clip::records` of a polygon. Outlines that fall
//! apart are closed anew along the plane by `clip::chains`.

pub(crate) mod records;
mod chains;
pub(crate) mod polygon;

use glam::DVec4;

use crate::clip::polygon::{Parts, PolygonClipper};
use crate::outline::{Chain, Outline};
use crate::vertex::{Interpolation, Vertex};
use crate::view_volume::{ClipPlane, Outcome};

/// A vertex in the precision in which clipping works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipVertex<const N: usize> {
    /// Clip-space position (xw, yw, zw, w).
    pub position: DVec4,
    /// The parameters r_1 .. r_N.
    pub params: [f64; N],
}

impl<const N: usize> ClipVertex<N> {
    /// The vertex rounded to f32.
    #[must_use]
    pub fn rounded(&self) -> Vertex<N> {
        Vertex { position: self.position.as_vec4(), params: self.params.map(|r| r as f32) }
    }
}

impl<const N: usize> From<&Vertex<N>> for ClipVertex<N> {
    fn from(vertex: &Vertex<N>) -> Self {
        Self { position: vertex.position.as_dvec4(), params: vertex.params.map(f64::from) }
    }
}

/// What clipping made of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clipped<'a, const N: usize> {
    /// Nothing of it is left. A polygon that merely touches a plane from outside is outside.
    Outside,
    /// All of it is inside: go on with the polygon that was given.
    Inside,
    /// What is left of it: at least three vertices, all with w >= [`MIN_W`].
    ///
    /// [`MIN_W`]: crate::view_volume::MIN_W
    Polygon(&'a [ClipVertex<N>]),
}

/// What clipping made of an outline of any number of contours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClippedOutline<'a, const N: usize> {
    /// Nothing of it is left.
    Outside,
    /// What is left of it, or all if nothing was cut: vertices, all with w >= [`MIN_W`], joined to
    /// [`Chain`]s.
    ///
    /// [`MIN_W`]: crate::view_volume::MIN_W
    Chains {
        /// The vertices of all chains, end to end.
        vertices: &'a [ClipVertex<N>],
        /// The chains; together they are closed.
        chains: &'a [Chain],
    },
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
/// assert_eq!(quad[1].rounded(), Vertex::new(vec4(1.0, 0.0, 0.5, 1.0), [0.5]));
/// ```
#[derive(Clone, Debug)]
pub struct Clipper<const N: usize> {
    work: PolygonClipper,
    vertices: Vec<ClipVertex<N>>,
}

impl<const N: usize> Default for Clipper<N> {
    fn default() -> Self {
        Self { work: PolygonClipper::default(), vertices: Vec::new() }
    }
}

impl<const N: usize> Clipper<N> {
    /// A clipper without memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Clips a polygon by any number of planes, in their order, and by w >= [`MIN_W`] before them.
    ///
    /// The polygon has any number of vertices. A convex one that is cut by k planes keeps at most
    /// k + 1 sides more than it had; one that is not convex may fall apart into pieces joined by
    /// edges that run to and fro along a plane, which [`clip_outline`](Self::clip_outline) avoids.
    /// A polygon with a position that is not finite, or with fewer than three vertices, is outside.
    /// Parameters are interpolated in perspective; for other ways see
    /// [`clip_with`](Self::clip_with).
    ///
    /// [`MIN_W`]: crate::view_volume::MIN_W
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
        match self.work.clip(planes, interpolation, Parts::Joined) {
            Outcome::Outside => Clipped::Outside,
            Outcome::Inside => Clipped::Inside,
            Outcome::Clipped => {
                self.collect();
                Clipped::Polygon(&self.vertices)
            }
        }
    }

    /// The part of an outline on the inner side of all `planes`, with w >= [`MIN_W`]. Unlike
    /// [`clip`](Self::clip) it takes several contours, and the pieces into which the outline may
    /// fall are not joined: they are [`Chain`]s, ready for [`EdgeTable::fill_chains`] once their
    /// vertices are [projected].
    ///
    /// The sides of a planar outline, and the lines along which it was cut before, cross each plane
    /// once. So with n sides and k planes there are at most (k + 1) (n + k) edges in the end.
    ///
    /// [`MIN_W`]: crate::view_volume::MIN_W
    /// [`EdgeTable::fill_chains`]: crate::coverage::EdgeTable::fill_chains
    /// [projected]: crate::subpixel::SubpixelPoint::project
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
    /// let clipped = clipper.clip_outline(&[square(1.0), hole], &[right_half], &[]);
    /// let ClippedOutline::Chains { chains, .. } = clipped else {
    ///     panic!("the right half of the square is inside");
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
        if self.work.clip_to_view(planes, interpolation) == Outcome::Outside {
            return ClippedOutline::Outside;
        }
        self.work.close_contour();
        self.collect();
        ClippedOutline::Chains { vertices: &self.vertices, chains: self.work.chains() }
    }

    fn load(&mut self, outline: &(impl Outline<N> + ?Sized), interpolation: &[Interpolation; N]) {
        self.work.start(N);
        for contour in outline.contours() {
            let contour = contour.iter().map(|v| (v.position, v.params.as_slice()));
            self.work.add_contour(contour, interpolation);
        }
    }

    /// Takes over what clipping has left.
    fn collect(&mut self) {
        let records = self.work.vertices();
        self.vertices.clear();
        self.vertices.extend(records.positions().iter().enumerate().map(|(i, &position)| {
            let mut params = [0.0; N];
            params.copy_from_slice(records.params(i));
            ClipVertex { position, params }
        }));
    }
}
