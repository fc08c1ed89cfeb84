//! Polygons whose values need more than planes: some interpolated along edges and then across, some
//! not in perspective, some that must be kept within limits.
//!
//! What is not affine on a polygon, such as arbitrary colours at the corners of a quad, is interpolated
//! along the two edges that bound a run and then across it, as in Heckbert's original. The result
//! depends on how the polygon is rotated on the screen (Heckbert and Moreton 1991, section 3.4), but
//! stays between the vertices' values.

use crate::coverage::Run;
use crate::project::ScreenPoint;

/// The vertices of a polygon on the screen, with all that is interpolated.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScreenVertices {
    pub(crate) points: Vec<ScreenPoint>,
    /// The values s_1 .. s_n of all vertices, end to end.
    pub(crate) s: Vec<f64>,
    pub(crate) params: usize,
}

/// One of the values that are interpolated.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Component {
    Z,
    InvW,
    S(usize),
}

impl ScreenVertices {
    /// A value at a vertex.
    #[inline(always)]
    pub(crate) fn get(&self, vertex: usize, component: Component) -> f64 {
        match component {
            Component::Z => self.points[vertex].z,
            Component::InvW => self.points[vertex].inv_w,
            Component::S(i) => self.s[vertex * self.params + i],
        }
    }

    /// The values s_1 .. s_n at a vertex.
    #[inline(always)]
    pub(crate) fn s(&self, vertex: usize) -> &[f64] {
        &self.s[vertex * self.params..(vertex + 1) * self.params]
    }

    /// The smallest and the largest of some values at all vertices; NaN is passed over.
    pub(crate) fn extent(&self, value: impl Fn(usize) -> f64) -> (f64, f64) {
        extent((0..self.points.len()).map(value))
    }
}

/// The smallest and the largest value; NaN is passed over.
#[inline(always)]
pub(crate) fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| {
        (if v < min { v } else { min }, if v > max { v } else { max })
    })
}

/// What a polygon has that is [mixed](crate::surface::base::Divide::Mixed), and its vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mixed {
    pub(crate) vertices: ScreenVertices,
    /// Which parameters are multiplied by w at each pixel.
    pub(crate) times_w: Vec<bool>,
    /// Which values are interpolated along edges instead of by a plane.
    pub(crate) z_by_edges: bool,
    pub(crate) inv_w_by_edges: bool,
    pub(crate) s_by_edges: Vec<bool>,
    /// Whether any is.
    pub(crate) any_by_edges: bool,
    /// The smallest and the largest value of each parameter, if 1/w changes so much, per pixel or in
    /// all, that s / (1/w) cannot be trusted at every pixel centre, or if s is too large for f32.
    /// Empty otherwise.
    pub(crate) limits: Vec<(f32, f32)>,
    /// Whether there are limits; for no parameters there is one list of none.
    pub(crate) has_limits: bool,
}

impl Mixed {
    /// Whether a value is interpolated along edges.
    pub(crate) fn is_by_edges(&self, component: Component) -> bool {
        match component {
            Component::Z => self.z_by_edges,
            Component::InvW => self.inv_w_by_edges,
            Component::S(i) => self.s_by_edges[i],
        }
    }

    /// Parameter `i` itself at a vertex.
    pub(crate) fn parameter(&self, vertex: usize, i: usize) -> f64 {
        let s = self.vertices.get(vertex, Component::S(i));
        if self.times_w[i] { s / self.vertices.points[vertex].inv_w } else { s }
    }
}

/// Where an edge is at a row's centre line, or nearest to a pixel.
pub(crate) struct AlongEdge<'v> {
    vertices: &'v ScreenVertices,
    x: f64,
    /// How far along the edge, from 0 to 1.
    t: f64,
    ends: [usize; 2],
}

impl<'v> AlongEdge<'v> {
    fn new(vertices: &'v ScreenVertices, edge: u32, y: i32) -> Self {
        let next = edge as usize + 1;
        let ends = [edge as usize, if next == vertices.points.len() { 0 } else { next }];
        let [a, b] = ends.map(|end| vertices.points[end]);
        // An edge that is not rounded to a horizontal one is not horizontal.
        let t = ((f64::from(y) + 0.5 - a.y) / (b.y - a.y)).clamp(0.0, 1.0);
        // Of pixels that are touched an edge may be.
        let t = if t.is_nan() { 0.5 } else { t };
        Self { vertices, x: a.x + (b.x - a.x) * t, t, ends }
    }

    /// The point of an edge that is nearest to the centre of a pixel.
    pub(crate) fn nearest(vertices: &'v ScreenVertices, edge: u32, [x, y]: [i32; 2]) -> Self {
        let edge = Self::new(vertices, edge, y);
        let [a, b] = edge.ends.map(|end| vertices.points[end]);
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let off = [f64::from(x) + 0.5 - a.x, f64::from(y) + 0.5 - a.y];
        let t = (off[0] * dx + off[1] * dy) / (dx * dx + dy * dy);
        Self { t: if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }, ..edge }
    }

    pub(crate) fn value(&self, component: Component) -> f64 {
        let [a, b] = self.ends.map(|end| self.vertices.get(end, component));
        a + (b - a) * self.t
    }

    /// The change of x per row.
    fn x_change(&self) -> f64 {
        let [a, b] = self.ends.map(|end| self.vertices.points[end]);
        (b.x - a.x) / (b.y - a.y)
    }

    /// The change of a value per row.
    fn change(&self, component: Component) -> f64 {
        let [a, b] = self.ends.map(|end| self.vertices.points[end].y);
        let [u, v] = self.ends.map(|end| self.vertices.get(end, component));
        (v - u) / (b - a)
    }
}

/// Interpolation between the two edges of a run, in Heckbert's way.
pub(crate) struct AcrossRun<'v> {
    left: AlongEdge<'v>,
    right: AlongEdge<'v>,
    width: f64,
    columns: (i32, i32),
}

impl<'v> AcrossRun<'v> {
    pub(crate) fn new(vertices: &'v ScreenVertices, run: &Run) -> Self {
        let [left, right] = run.edges.map(|edge| AlongEdge::new(vertices, edge, run.y));
        let width = right.x - left.x;
        Self { left, right, width, columns: (run.x.start, run.x.end) }
    }

    /// Where the centre of column `x` lies: 0 at the left edge, 1 at the right one. Rounding of the
    /// outline may put it just outside.
    fn ratio(&self, x: i32) -> f64 {
        let t = (f64::from(x) + 0.5 - self.left.x) / self.width;
        if self.width > 0.0 { t.clamp(0.0, 1.0) } else { 0.5 }
    }

    /// The value at the run's first pixel.
    pub(crate) fn start(&self, component: Component) -> f64 {
        let t = self.ratio(self.columns.0);
        let (l, r) = (self.left.value(component), self.right.value(component));
        l + (r - l) * t
    }

    /// The change per pixel that leads from the first pixel's value exactly to the last one's.
    pub(crate) fn delta(&self, component: Component) -> f64 {
        let (start, end) = self.columns;
        let steps = f64::from(end) - 1.0 - f64::from(start);
        let per_pixel = if steps > 0.0 {
            (self.ratio(end - 1) - self.ratio(start)) / steps
        } else {
            1.0 / self.width.max(1.0)
        };
        (self.right.value(component) - self.left.value(component)) * per_pixel
    }

    /// d/dy of l(y) + (r(y) - l(y)) t(x, y), where t is the ratio of x between the edges.
    pub(crate) fn downwards(&self, component: Component, x: i32) -> f64 {
        let t = self.ratio(x);
        let (l, r) = (self.left.change(component), self.right.change(component));
        let change = l + (r - l) * t;
        if self.width <= 0.0 {
            return change;
        }
        let (left_x, right_x) = (self.left.x_change(), self.right.x_change());
        let dt = -(left_x + (right_x - left_x) * t) / self.width;
        change + (self.right.value(component) - self.left.value(component)) * dt
    }
}
