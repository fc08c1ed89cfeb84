//! The vertex records that clipping works on: positions and parameters in f64, in two lists.

use glam::{DVec4, Vec4};
use prefetch_index::prefetch_index;

use crate::vertex::Interpolation;
use crate::view_volume::{ClipPlane, MIN_W};

/// Bytes in a line of the cache of most processors.
const CACHE_LINE: usize = 64;

/// Vertex records of one polygon. All have the same number of parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Records {
    /// The number of parameters.
    width: usize,
    positions: Vec<DVec4>,
    /// The parameters of all vertices, end to end.
    params: Vec<f64>,
}

impl Records {
    /// Forgets all vertices; those to come have `width` parameters.
    pub(crate) fn clear(&mut self, width: usize) {
        self.width = width;
        self.positions.clear();
        self.params.clear();
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn len(&self) -> usize {
        self.positions.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    pub(crate) fn positions(&self) -> &[DVec4] {
        &self.positions
    }

    /// The parameters of a vertex.
    pub(crate) fn params(&self, vertex: usize) -> &[f64] {
        &self.params[vertex * self.width..(vertex + 1) * self.width]
    }

    /// The parameters of all vertices, end to end.
    pub(crate) fn all_params(&self) -> &[f64] {
        &self.params
    }

    /// Adds a vertex that was given. A flat parameter has the value of the first vertex.
    #[inline(always)]
    pub(crate) fn push(&mut self, position: Vec4, params: &[f32], interpolation: &[Interpolation]) {
        self.positions.push(position.as_dvec4());
        let before = self.params.len();
        self.params.extend(params.iter().map(|param| f64::from(*param)));
        let (first, own) = self.params.split_at_mut(before);
        for ((first, own), interpolation) in first.iter().zip(own).zip(interpolation) {
            if *interpolation == Interpolation::Flat {
                *own = *first;
            }
        }
    }

    /// Adds a vertex that has only a position.
    pub(crate) fn push_position(&mut self, position: DVec4) {
        self.positions.push(position);
    }

    /// Adds a vertex of other records.
    #[inline(always)]
    pub(crate) fn push_from(&mut self, other: &Self, vertex: usize) {
        self.positions.push(other.positions[vertex]);
        self.params.extend_from_slice(other.params(vertex));
    }

    /// Adds vertices of other records.
    pub(crate) fn extend_from(&mut self, other: &Self) {
        self.positions.extend_from_slice(&other.positions);
        self.params.extend_from_slice(&other.params);
    }

    /// The positions of some vertices, and their parameters, end to end.
    pub(crate) fn some(&self, vertices: std::ops::Range<usize>) -> (&[DVec4], &[f64]) {
        let params = vertices.start * self.width..vertices.end * self.width;
        (&self.positions[vertices], &self.params[params])
    }

    /// Asks for some of the vertices, so that they are in the cache when they are used.
    #[inline(always)]
    pub(crate) fn prefetch(&self, vertices: std::ops::Range<usize>) {
        let lines = |size: usize| (CACHE_LINE / size).max(1);
        let params = vertices.start * self.width..vertices.end * self.width;
        let positions = vertices.step_by(lines(size_of::<DVec4>()));
        positions.for_each(|vertex| prefetch_index(&self.positions, vertex));
        let params = params.step_by(lines(size_of::<f64>()));
        params.for_each(|param| prefetch_index(&self.params, param));
    }

    /// Adds a copy of one of the vertices.
    pub(crate) fn repeat(&mut self, vertex: usize) {
        let params = vertex * self.width..(vertex + 1) * self.width;
        self.positions.push(self.positions[vertex]);
        self.params.extend_from_within(params);
    }

    /// Adds the vertex in which the edge between two vertices of `other` crosses a plane, where
    /// `distances` are theirs from the plane; they have different signs.
    ///
    /// The result does not depend on the order of the two: it is computed from the inner end, or where
    /// the plane's other side may be wanted, too, from an end that does not depend on the side. So all
    /// polygons along an edge find the same vertex.
    #[inline(always)]
    pub(crate) fn push_crossing(
        &mut self,
        other: &Self,
        [a, b]: [usize; 2],
        [da, db]: [f64; 2],
        plane: &impl Cutter,
        interpolation: &[Interpolation],
    ) {
        let a_is_inner = da > 0.0;
        let (inner, outer) = if a_is_inner { (a, b) } else { (b, a) };
        let from_outside = plane.cuts_from_outside(other.positions[inner], other.positions[outer]);
        let (near, far, t) = if a_is_inner != from_outside {
            (a, b, da / (da - db))
        } else {
            (b, a, db / (db - da))
        };
        let (p, q) = (other.positions[near], other.positions[far]);
        let mut position = p + (q - p) * t;
        // Between ends of very different size rounding is large; it must not leave the edge's box, and
        // must not bring a vertex to the eye.
        position = position.max(p.min(q)).min(p.max(q));
        position.w = position.w.max(MIN_W);
        // The ratio as it is seen on the screen. An end behind the eye is not on the screen: there the
        // limit for an end just before the eye holds, where the edge is infinitely long.
        let on_screen = if p.w > 0.0 { t * q.w.max(0.0) / position.w } else { 1.0 };
        plane.snap(&mut position);
        self.positions.push(position);
        let ends = other.params(near).iter().zip(other.params(far));
        self.params.extend(ends.zip(interpolation).map(|((p, q), interpolation)| {
            let t = if *interpolation == Interpolation::Linear { on_screen } else { t };
            p + (q - p) * t
        }));
    }
}

/// What cuts a polygon: a plane, or what stands for one.
pub(crate) trait Cutter {
    /// The signed distance of a position, up to a positive factor.
    fn distance(&self, position: DVec4) -> f64;

    /// Moves a new vertex exactly to where the distance is 0.
    fn snap(&self, position: &mut DVec4);

    /// Whether a crossing is computed from the outer of two ends.
    fn cuts_from_outside(&self, inner: DVec4, outer: DVec4) -> bool;

    /// Whether what is on the other side may be wanted, too.
    fn has_two_sides(&self) -> bool {
        false
    }
}

impl Cutter for ClipPlane {
    fn distance(&self, position: DVec4) -> f64 {
        Self::distance(self, position)
    }

    fn snap(&self, position: &mut DVec4) {
        Self::snap(self, position);
    }

    fn cuts_from_outside(&self, inner: DVec4, outer: DVec4) -> bool {
        Self::cuts_from_outside(self, inner, outer)
    }

    fn has_two_sides(&self) -> bool {
        Self::has_two_sides(self)
    }
}

/// The plane w = [`MIN_W`], before the eye.
pub(crate) struct EyePlane;

impl Cutter for EyePlane {
    fn distance(&self, position: DVec4) -> f64 {
        position.w - MIN_W
    }

    fn snap(&self, position: &mut DVec4) {
        position.w = MIN_W;
    }

    fn cuts_from_outside(&self, _: DVec4, _: DVec4) -> bool {
        false
    }
}

/// Any function of the position, for parts of which nobody sees the border.
pub(crate) struct AnyCutter<F>(pub(crate) F);

impl<F: Fn(DVec4) -> f64> Cutter for AnyCutter<F> {
    fn distance(&self, position: DVec4) -> f64 {
        self.0(position)
    }

    fn snap(&self, _: &mut DVec4) {}

    fn cuts_from_outside(&self, _: DVec4, _: DVec4) -> bool {
        false
    }
}
