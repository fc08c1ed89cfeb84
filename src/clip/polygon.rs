//! The clipper for any number of parameters: Sutherland and Hodgman's step over a list of records.

use glam::{DVec3, DVec4, Vec3Swizzles, Vec4, Vec4Swizzles};

use crate::clip::chains::ChainCutter;
use crate::clip::records::{AnyCutter, Cutter, EyePlane, Records};
use crate::outline::Chain;
use crate::vertex::Interpolation;
use crate::view_volume::{ClipPlane, MIN_W, Outcode, Outcome};

/// How the parts are left into which a contour falls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parts {
    /// In one contour, by edges to and fro.
    Joined,
    /// As chains.
    Apart,
}

/// A polygon being clipped, and the memory that it takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct PolygonClipper {
    vertices: Records,
    /// Without chains the vertices are one closed contour.
    chains: Vec<Chain>,
    /// Whether a position is not finite, so that the polygon cannot be drawn.
    is_void: bool,
    next: Records,
    next_chains: Vec<Chain>,
    cutter: ChainCutter,
}

impl PolygonClipper {
    /// Begins with a polygon whose vertices have `params` parameters each.
    pub(crate) fn start(&mut self, params: usize) {
        self.vertices.clear(params);
        self.chains.clear();
        self.is_void = false;
    }

    /// Adds a contour. One of fewer than three vertices bounds nothing; if any contour has a position
    /// that is not finite, nothing is left of the polygon.
    #[inline(always)]
    pub(crate) fn add_contour<'v>(
        &mut self,
        contour: impl Iterator<Item = (Vec4, &'v [f32])> + Clone,
        interpolation: &[Interpolation],
    ) {
        let mut count = 0;
        for (position, _) in contour.clone() {
            self.is_void |= !position.is_finite();
            count += 1;
        }
        if self.is_void {
            self.vertices.clear(self.vertices.width());
            self.chains.clear();
        }
        if self.is_void || count < 3 {
            return;
        }
        let first = self.vertices.len();
        if first > 0 {
            self.close_contour();
        }
        let start = self.vertices.len();
        for (position, params) in contour {
            self.vertices.push(position, params, interpolation);
        }
        if first > 0 {
            self.vertices.repeat(start);
            self.chains.push(Chain { end: self.vertices.len(), winding: 1 });
        }
    }

    /// Turns one contour into a chain.
    pub(crate) fn close_contour(&mut self) {
        if self.chains.is_empty() {
            if !self.vertices.is_empty() {
                self.vertices.repeat(0);
            }
            self.chains.push(Chain { end: self.vertices.len(), winding: 1 });
        }
    }

    /// The number of sides of the polygon if it has one contour; 0 if it has more.
    pub(crate) fn sides(&self) -> usize {
        if self.chains.is_empty() { self.vertices.len() } else { 0 }
    }

    pub(crate) fn vertices(&self) -> &Records {
        &self.vertices
    }

    /// The chains of these vertices; none if they are one contour.
    pub(crate) fn chains(&self) -> &[Chain] {
        &self.chains
    }

    /// The part of a polygon without parameters where `distance` is not negative, in one contour. All
    /// of it must have w >= [`MIN_W`].
    pub(crate) fn part(
        &mut self,
        polygon: impl Iterator<Item = DVec4>,
        distance: impl Fn(DVec4) -> f64,
    ) -> &[DVec4] {
        self.start(0);
        polygon.for_each(|position| self.vertices.push_position(position));
        self.clip_by(&AnyCutter(distance), &[], Parts::Joined);
        self.vertices.positions()
    }

    /// Clips the polygon, as far as it can be seen: see [`is_edge_on_at_eye`](Self::is_edge_on_at_eye).
    pub(crate) fn clip_to_view(
        &mut self,
        planes: &[ClipPlane],
        interpolation: &[Interpolation],
    ) -> Outcome {
        if self.is_edge_on_at_eye() {
            return Outcome::Outside;
        }
        self.clip(planes, interpolation, Parts::Apart)
    }

    /// Clips the polygon by w >= [`MIN_W`] and by planes.
    pub(crate) fn clip(
        &mut self,
        planes: &[ClipPlane],
        interpolation: &[Interpolation],
        parts: Parts,
    ) -> Outcome {
        let positions = self.vertices.positions();
        let codes = positions.iter().map(|&position| Outcode::new(position, planes));
        let (outcome, any) = Outcode::outcome(codes);
        if outcome != Outcome::Clipped || positions.is_empty() {
            return if positions.is_empty() { Outcome::Outside } else { outcome };
        }
        // Eight times the vertices that a planar outline may get, two for an edge: see
        // `Clipper::clip_outline`. Where many planes cut an outline that is far from planar, its
        // vertices may multiply without end, and it is left out.
        let cuts = planes.len() + 2;
        let limit = (16 * cuts).saturating_mul(positions.len() + cuts);
        if any.is_behind_eye() {
            self.clip_by(&EyePlane, interpolation, parts);
        }
        for (_, plane) in planes.iter().enumerate().filter(|&(i, _)| any.has(i)) {
            self.clip_by(plane, interpolation, parts);
            if self.vertices.len() > limit {
                return Outcome::Outside;
            }
        }
        if self.vertices.len() < 3 { Outcome::Outside } else { Outcome::Clipped }
    }

    /// Whether the polygon reaches the eye, or behind it, in a plane that runs through the eye: no
    /// area of it is seen, but clipping would make up places on the screen from rounding errors.
    fn is_edge_on_at_eye(&self) -> bool {
        let positions = self.vertices.positions();
        if positions.iter().all(|p| p.w >= MIN_W) {
            return false;
        }
        let rays = || positions.iter().map(|p| p.xyw());
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

    /// Keeps the part of the polygon on the inner side of a plane.
    fn clip_by(&mut self, plane: &impl Cutter, interpolation: &[Interpolation], parts: Parts) {
        if self.chains.is_empty() {
            let in_one = self.clip_contour_by(plane, interpolation);
            if in_one || parts == Parts::Joined {
                std::mem::swap(&mut self.vertices, &mut self.next);
                return;
            }
            self.close_contour();
        }
        let vertices = &self.vertices;
        self.cutter.cut(
            (vertices, &self.chains),
            (&mut self.next, &mut self.next_chains),
            plane.has_two_sides(),
            |vertex| plane.distance(vertices.positions()[vertex]),
            |next, ends, distances| {
                next.push_crossing(vertices, ends, distances, plane, interpolation);
            },
        );
        std::mem::swap(&mut self.vertices, &mut self.next);
        std::mem::swap(&mut self.chains, &mut self.next_chains);
    }

    /// Sutherland and Hodgman's step; whether the contour stays in one part. Then it crosses or
    /// touches the plane in no more than two places, and a single edge along the plane closes it. Only
    /// where an edge lies in a plane with two sides, it takes more, since each side has one of its ends.
    fn clip_contour_by(&mut self, plane: &impl Cutter, interpolation: &[Interpolation]) -> bool {
        let Self { vertices, next, .. } = self;
        next.clear(vertices.width());
        let positions = vertices.positions();
        let [first, .., last] = positions else { return true };
        let (mut before, mut da) = (plane.distance(*last), plane.distance(*first));
        // How often the contour changes sides, vertices on the plane counted to the one or the other.
        let (mut closed_changes, mut open_changes) = (0, 0);
        let mut has_edge_in_plane = false;
        for a in 0..positions.len() {
            let b = if a + 1 == positions.len() { 0 } else { a + 1 };
            let db = plane.distance(positions[b]);
            // On the plane the contour turns inwards or outwards. Where it does neither, the edge
            // along the plane takes its place.
            if da > 0.0 || da == 0.0 && (before > 0.0 || db > 0.0) {
                next.push_from(vertices, a);
            }
            if da > 0.0 && db < 0.0 || da < 0.0 && db > 0.0 {
                next.push_crossing(vertices, [a, b], [da, db], plane, interpolation);
            }
            closed_changes += usize::from((da >= 0.0) != (db >= 0.0));
            open_changes += usize::from((da > 0.0) != (db > 0.0));
            has_edge_in_plane |= da == 0.0 && db == 0.0;
            (before, da) = (da, db);
        }
        let is_on_both_sides = closed_changes > 0 && open_changes > 0;
        let is_parted_there = has_edge_in_plane && is_on_both_sides && plane.has_two_sides();
        closed_changes.max(open_changes) <= 2 && !is_parted_there
    }
}
