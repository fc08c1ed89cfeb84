//! A polygon on the screen: how its parameters run over it.
//!
//! Clipped vertices come in; for every run of pixels that the edge table finds, the polygon gives
//! the values of (z, s_1 .. s_n, s_{n+1}) at the first pixel and the change per pixel.
//!
//! What is affine on the polygon (always so on triangles) is one plane over the screen. What is
//! not, such as arbitrary colours at the corners of a quad, is interpolated along the two edges
//! that bound the run and then across it, as in Heckbert's original; it depends on how the polygon
//! is rotated on the screen (Heckbert and Moreton 1991, section 3.4), but stays between the
//! vertices' values.

mod triangles;

use std::ops::Range;

pub(crate) use self::triangles::{PlacedTriangles, Triangles};
use crate::clip::{ClipSpace, ClipVertex};
use crate::edge_table::{ROWS, Run, RunGroup};
use crate::gradient::Gradient;
use crate::number::Number;
use crate::project::{Projection, SUBPIXELS, ScreenParams, ScreenVertex, Viewport};
use crate::span::Line;
use crate::vertex::{Interpolation, Vertex};

/// How far the values at the vertices may lie from a plane for this plane to stand for them, as a
/// part of the largest value. Vertices rounded to f32 miss it by a few units of 2^-24; from here
/// to the promised 1e-5 a factor of 5 remains.
const PLANE_TOLERANCE: f64 = 1.0 / (1 << 19) as f64;

/// The same for depth, in absolute terms: four units in the last place of a depth near 1.
const DEPTH_TOLERANCE: f64 = 1.0 / (1 << 22) as f64;

/// The least 1/w, where the greatest is 1 or little less, that is still exact to f32 when it comes
/// out of sums in f64: rounded in units of 2^-53, it is off by 2^-27 of itself.
const LEAST_EXACT: f64 = 1.0 / (1 << 26) as f64;

/// How the polygons of a draw call are brought to the screen.
#[derive(Clone, Debug)]
pub(crate) struct Setup<const N: usize> {
    projection: Projection,
    interpolation: [Interpolation; N],
    /// Which parameters are interpolated in perspective, and divided where w varies.
    divided: [bool; N],
    /// The method where it does.
    method: Method,
}

impl<const N: usize> Setup<N> {
    pub(crate) fn new(
        viewport: &Viewport,
        clip_space: ClipSpace,
        interpolation: [Interpolation; N],
    ) -> Self {
        let divided = interpolation.map(|i| i == Interpolation::Perspective);
        let method = if divided == [true; N] { Method::Perspective } else { Method::Other };
        let projection = Projection::new(viewport, clip_space);
        Self { projection, interpolation, divided, method }
    }

    /// A vertex in the clipper's precision, with the first vertex's value where a parameter is flat.
    #[inline(always)]
    pub(crate) fn vertex(&self, vertex: &Vertex<N>, provoking: &Vertex<N>) -> ClipVertex<N> {
        let vertex = ClipVertex::from(vertex);
        if self.method == Method::Perspective {
            vertex
        } else {
            vertex.flattened(provoking, &self.interpolation)
        }
    }

    /// A vertex on the screen. `divides` tells whether what is interpolated in perspective is divided
    /// by w.
    #[inline(always)]
    fn project<T: Number>(
        &self,
        position: [T; 4],
        params: &[T; N],
        w_unit: T,
        divides: T::Mask,
    ) -> ScreenVertex<N, T> {
        let mut vertex = self.projection.vertex(
            position,
            w_unit,
            #[inline(always)]
            |i, inv_w| {
                let r = params[i];
                if self.method == Method::Perspective || self.divided[i] {
                    T::select(divides, r * inv_w, r)
                } else {
                    r
                }
            },
        );
        // Clipping has brought it here but for rounding.
        let z = vertex.values.z;
        let (least, greatest) = self.projection.depth_range();
        vertex.values.z = z.greater(z.all(least)).lesser(z.all(greatest));
        vertex
    }
}

/// How the parameters of a polygon are found from its planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// All are multiplied by w.
    Perspective,
    /// None is: all w are equal.
    Constant,
    /// Any other case.
    Other,
}

/// The polygon being scan-converted, with the memory that it needs.
#[derive(Clone, Debug)]
pub(crate) struct ScreenPolygon<const N: usize> {
    /// The corner of the viewport on the framebuffer.
    pub(crate) corner: (i32, i32),
    /// The number of the polygon in its mesh.
    pub(crate) face: u32,
    /// The vertices; of a polygon whose values all have planes they may be missing.
    vertices: Vec<ScreenVertex<N>>,
    gradient: Gradient<N>,
    /// The gradient's change per pixel to the right.
    pub(crate) delta: ScreenParams<N, f32>,
    by_edges: ByEdges<N>,
    /// The unit in which w is measured: the power of two at or below the polygon's smallest w. So
    /// 1/w is at most 1 in it, and neither that nor any s overflows f32, however near the eye.
    pub(crate) w_unit: f64,
    pub(crate) w: WRange,
    /// Which parameters are multiplied by w at each pixel.
    pub(crate) times_w: [bool; N],
    pub(crate) method: Method,
    /// The smallest and the largest depth of the vertices.
    pub(crate) z: (f32, f32),
    /// The smallest and the largest value of each parameter, if 1/w changes so much, per pixel or in
    /// all, that s / (1/w) cannot be trusted at every pixel centre, or if s is too large for f32.
    pub(crate) limits: Option<[(f32, f32); N]>,
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
    /// The smallest and the largest w.
    #[inline(always)]
    pub(crate) fn range(self) -> (f32, f32) {
        match self {
            Self::Constant { w, .. } => (w, w),
            Self::Varying { w, .. } => w,
        }
    }

    /// For w and 1/w from the first to the second value, the latter in the polygon's unit.
    #[inline(always)]
    fn new(w: (f64, f64), inv_w: (f64, f64)) -> Self {
        let w = (w.0 as f32, w.1 as f32);
        // Clipping in f64 may leave less than f32 can tell apart.
        if w.0 == w.1 {
            return Self::Constant { w: w.0, inv_w: 1.0 / w.0 };
        }
        // Below the smallest normal number the reciprocal would not be finite: w ratios over 2^126.
        let least = (inv_w.0 as f32).max(f32::MIN_POSITIVE);
        Self::Varying { w, inv_w: (least, inv_w.1 as f32) }
    }

    /// Whether w varies, so that pixels need a division.
    fn divides(self) -> bool {
        matches!(self, Self::Varying { .. })
    }
}

/// Which values are interpolated along edges instead of by a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct ByEdges<const N: usize> {
    any: bool,
    z: bool,
    inv_w: bool,
    s: Flags<N>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Flags<const N: usize>([bool; N]);

impl<const N: usize> Default for Flags<N> {
    fn default() -> Self {
        Self([false; N])
    }
}

/// The values along the runs of a group of rows, where they have planes: each [`Line`], number by
/// number.
pub(crate) struct Lines<const N: usize> {
    pub(crate) x: [i32; ROWS],
    pub(crate) at: ScreenParams<N, [f32; ROWS]>,
}

impl<const N: usize> Default for ScreenPolygon<N> {
    fn default() -> Self {
        Self {
            corner: (0, 0),
            face: 0,
            vertices: Vec::new(),
            gradient: Gradient::default(),
            delta: ScreenParams::default().rounded(),
            by_edges: ByEdges::default(),
            w_unit: 1.0,
            w: WRange::Constant { w: 1.0, inv_w: 1.0 },
            times_w: [false; N],
            method: Method::Other,
            z: (0.0, 1.0),
            limits: None,
        }
    }
}

impl<const N: usize> ScreenPolygon<N> {
    /// Sets up a polygon that is inside of all planes, clipped or not, from its vertices. `affine` says
    /// that all values are known to be affine on the polygon.
    pub(crate) fn set_up(
        &mut self,
        setup: &Setup<N>,
        polygon: impl Iterator<Item = ClipVertex<N>> + Clone,
        affine: bool,
    ) {
        let (min, max) = extent(polygon.clone().map(|v| v.position.w));
        let unit = min.power_of_two_below();
        let range = WRange::new((min, max), (unit / max, unit / min));
        self.set_w(setup, unit, range);
        let mut vertices = std::mem::take(&mut self.vertices);
        vertices.clear();
        let project = |v: ClipVertex<N>| {
            setup.project(v.position.to_array(), &v.params, unit, range.divides())
        };
        vertices.extend(polygon.map(project));
        self.fit(&vertices, affine);
        self.vertices = vertices;
    }

    /// Sets what follows from the unit and the range of w.
    #[inline(always)]
    fn set_w(&mut self, setup: &Setup<N>, unit: f64, range: WRange) {
        let divides = range.divides();
        self.corner = setup.projection.corner();
        self.w_unit = unit;
        self.w = range;
        (self.times_w, self.method) =
            if divides { (setup.divided, setup.method) } else { ([false; N], Method::Constant) };
    }

    /// Finds the planes of the values, and the values that have none.
    fn fit(&mut self, vertices: &[ScreenVertex<N>], affine: bool) {
        let (near, far) = extent(vertices.iter().map(|v| v.values.z));
        self.z = (near as f32, far as f32);
        let gradient = widest_triangle(vertices).and_then(Gradient::through);
        self.gradient = gradient.unwrap_or_default();
        self.delta = self.gradient.dx.rounded();
        self.by_edges = match gradient {
            None => ByEdges { any: true, z: true, inv_w: true, s: Flags([true; N]) },
            Some(_) if affine => ByEdges::default(),
            Some(gradient) => self.misfits(&gradient, vertices),
        };
        self.limits = None;
        let (least, _) = extent(vertices.iter().map(|v| v.values.inv_w));
        let is_steep = self.w.divides() && is_steep(&self.gradient, least);
        if is_steep || !fits_f32(&self.gradient, vertices) {
            self.limits = Some(self.limits(vertices));
            self.method = Method::Other;
        }
    }

    #[cold]
    fn limits(&self, vertices: &[ScreenVertex<N>]) -> [(f32, f32); N] {
        std::array::from_fn(|i| {
            let (min, max) = extent(vertices.iter().map(|v| self.parameter(v, i)));
            (min as f32, max as f32)
        })
    }

    /// Which values at the vertices do not lie on the planes.
    #[inline(never)]
    fn misfits(&self, gradient: &Gradient<N>, vertices: &[ScreenVertex<N>]) -> ByEdges<N> {
        let mut largest = [0.0f64; N];
        for v in vertices {
            for (i, largest) in largest.iter_mut().enumerate() {
                *largest = largest.max(self.parameter(v, i).abs());
            }
        }
        let mut by_edges = ByEdges::<N>::default();
        for v in vertices {
            let plane = gradient.at(v.x, v.y);
            let off = plane.zip(&v.values, |plane, value| (plane - value).abs());
            // Written so that NaN is a misfit, too.
            let fits = |off: f64, tolerance: f64| off <= tolerance;
            by_edges.z |= !fits(off.z, DEPTH_TOLERANCE);
            by_edges.inv_w |= !fits(off.inv_w, PLANE_TOLERANCE * v.values.inv_w);
            for (i, largest) in largest.iter().enumerate() {
                let per_w = if self.times_w[i] { v.values.inv_w } else { 1.0 };
                by_edges.s.0[i] |= !fits(off.s[i], PLANE_TOLERANCE * largest * per_w);
            }
        }
        for i in 0..N {
            // r = s / (1/w) stays between the vertices' values only if both go the same way.
            by_edges.s.0[i] |= by_edges.inv_w && self.times_w[i];
            by_edges.any |= by_edges.s.0[i];
        }
        by_edges.any |= by_edges.z || by_edges.inv_w;
        by_edges
    }

    /// Parameter `i` itself at a vertex.
    fn parameter(&self, v: &ScreenVertex<N>, i: usize) -> f64 {
        if self.times_w[i] { v.values.s[i] / v.values.inv_w } else { v.values.s[i] }
    }

    /// The values along a run, as the span evaluates them.
    #[inline(always)]
    pub(crate) fn line(&self, run: &Run) -> Line<N> {
        if self.by_edges.any {
            // Field by field, so that the other path need not write its own to memory.
            let Line { x, at, delta } = self.line_by_edges(run.clone());
            let fields = |p: &ScreenParams<N, f32>| ScreenParams {
                z: p.z,
                inv_w: p.inv_w,
                s: std::array::from_fn(|i| p.s[i]),
            };
            return Line { x, at: fields(&at), delta: fields(&delta) };
        }
        let delta = self.delta;
        let x = if delta.inv_w < 0.0 { run.x.end - 1 } else { run.x.start };
        let at = self.gradient.at(f64::from(x) + 0.5, f64::from(run.y) + 0.5).rounded();
        Line { x, at, delta }
    }

    /// The values along the runs of a group of rows, where they have planes.
    #[inline(always)]
    pub(crate) fn lines(&self, group: &RunGroup) -> Lines<N> {
        let is_falling = self.delta.inv_w < 0.0;
        let mut x = group.start;
        let (mut xs, mut ys) = ([0.0; ROWS], [0.0; ROWS]);
        for row in 0..ROWS {
            if is_falling {
                x[row] = group.end[row] - 1;
            }
            xs[row] = f64::from(x[row]) + 0.5;
            ys[row] = f64::from(group.y) + row as f64 + 0.5;
        }
        Lines { x, at: self.gradient.at_each(xs, ys) }
    }

    /// The values along one of the runs.
    #[inline(always)]
    pub(crate) fn line_of(&self, lines: &Lines<N>, row: usize) -> Line<N> {
        let mut s = [0.0; N];
        for (s, rows) in s.iter_mut().zip(&lines.at.s) {
            *s = rows[row];
        }
        let at = ScreenParams { z: lines.at.z[row], inv_w: lines.at.inv_w[row], s };
        Line { x: lines.x[row], at, delta: self.delta }
    }

    /// Whether some values have no plane, so that the edges of each run are needed.
    #[inline(always)]
    pub(crate) fn needs_edges(&self) -> bool {
        self.by_edges.any
    }

    #[cold]
    fn line_by_edges(&self, run: Run) -> Line<N> {
        let (start, delta) = self.along(&run);
        let x = if delta.inv_w < 0.0 { run.x.end - 1 } else { run.x.start };
        let at = start.step(&delta, f64::from(x - run.x.start)).rounded();
        Line { x, at, delta: delta.rounded() }
    }

    /// The values at the centre of the first pixel of a run, and their change per pixel.
    pub(crate) fn along(&self, run: &Run) -> (ScreenParams<N>, ScreenParams<N>) {
        let mut start = self.gradient.at(f64::from(run.x.start) + 0.5, f64::from(run.y) + 0.5);
        let mut delta = self.gradient.dx;
        if self.by_edges.any {
            let across = Across::new(self, run);
            self.by_edges.assign(&mut start, &across.start(&run.x));
            self.by_edges.assign(&mut delta, &across.delta(&run.x));
        }
        (start, delta)
    }

    /// The values at the centre of a column of a run.
    pub(crate) fn at(&self, x: i32, run: &Run) -> ScreenParams<N> {
        let (start, delta) = self.along(run);
        start.step(&delta, f64::from(x - run.x.start))
    }

    /// The change of the values per pixel downwards, at a column of a run.
    pub(crate) fn downwards(&self, x: i32, run: &Run) -> ScreenParams<N> {
        let mut dy = self.gradient.dy;
        if self.by_edges.any {
            self.by_edges.assign(&mut dy, &Across::new(self, run).downwards(x));
        }
        dy
    }
}

impl<const N: usize> ByEdges<N> {
    /// Replaces the values that are interpolated along edges.
    fn assign(&self, values: &mut ScreenParams<N>, by_edges: &ScreenParams<N>) {
        if self.z {
            values.z = by_edges.z;
        }
        if self.inv_w {
            values.inv_w = by_edges.inv_w;
        }
        for i in 0..N {
            if self.s.0[i] {
                values.s[i] = by_edges.s[i];
            }
        }
    }
}

/// Where an edge is at a row's centre line, and the values there.
struct Along<'v, const N: usize> {
    x: f64,
    values: ScreenParams<N>,
    ends: [&'v ScreenVertex<N>; 2],
}

impl<'v, const N: usize> Along<'v, N> {
    #[inline(always)]
    fn new(vertices: &'v [ScreenVertex<N>], edge: u32, y: i32) -> Self {
        let next = edge as usize + 1;
        let a = &vertices[edge as usize];
        let b = &vertices[if next == vertices.len() { 0 } else { next }];
        // An edge that is not rounded to a horizontal one is not horizontal.
        let t = ((f64::from(y) + 0.5 - a.y) / (b.y - a.y)).clamp(0.0, 1.0);
        let values = a.values.zip(&b.values, |a, b| a + (b - a) * t);
        Self { x: a.x + (b.x - a.x) * t, values, ends: [a, b] }
    }

    /// The change per row, of x and of the values.
    fn change(&self) -> (f64, ScreenParams<N>) {
        let [a, b] = self.ends;
        let height = b.y - a.y;
        ((b.x - a.x) / height, a.values.zip(&b.values, |a, b| (b - a) / height))
    }
}

/// Interpolation between the two edges of a run, in Heckbert's way.
struct Across<'v, const N: usize> {
    left: Along<'v, N>,
    right: Along<'v, N>,
    width: f64,
}

impl<'v, const N: usize> Across<'v, N> {
    #[inline(always)]
    fn new(polygon: &'v ScreenPolygon<N>, run: &Run) -> Self {
        let [left, right] = run.edges.map(|edge| Along::new(&polygon.vertices, edge, run.y));
        let width = right.x - left.x;
        Self { left, right, width }
    }

    /// Where the centre of column `x` lies: 0 at the left edge, 1 at the right one. Rounding of the
    /// outline may put it just outside.
    fn ratio(&self, x: i32) -> f64 {
        let t = (f64::from(x) + 0.5 - self.left.x) / self.width;
        if self.width > 0.0 { t.clamp(0.0, 1.0) } else { 0.5 }
    }

    fn start(&self, x: &Range<i32>) -> ScreenParams<N> {
        let t = self.ratio(x.start);
        self.left.values.zip(&self.right.values, |l, r| l + (r - l) * t)
    }

    /// The change per pixel that leads from the first pixel's values exactly to the last one's.
    fn delta(&self, x: &Range<i32>) -> ScreenParams<N> {
        let steps = x.end - 1 - x.start;
        let per_pixel = if steps > 0 {
            (self.ratio(x.end - 1) - self.ratio(x.start)) / f64::from(steps)
        } else {
            1.0 / self.width.max(1.0)
        };
        self.left.values.zip(&self.right.values, |l, r| (r - l) * per_pixel)
    }

    /// d/dy of l(y) + (r(y) - l(y)) t(x, y), where t is the ratio of x between the edges.
    fn downwards(&self, x: i32) -> ScreenParams<N> {
        let t = self.ratio(x);
        let ((left_x, left), (right_x, right)) = (self.left.change(), self.right.change());
        let change = left.zip(&right, |l, r| l + (r - l) * t);
        if self.width <= 0.0 {
            return change;
        }
        let dt = -(left_x + (right_x - left_x) * t) / self.width;
        let across = self.left.values.zip(&self.right.values, |l, r| (r - l) * dt);
        change.zip(&across, |a, b| a + b)
    }
}

/// A triangle of vertices that spans the polygon well: the first vertex, the one farthest from it,
/// and the one farthest from the line through both. Everything on the polygon is near to it, so
/// that its plane is not extrapolated far.
pub(crate) fn widest_triangle<const N: usize>(
    vertices: &[ScreenVertex<N>],
) -> Option<[&ScreenVertex<N>; 3]> {
    if let [a, b, c] = vertices {
        return Some([a, b, c]);
    }
    let a = vertices.first()?;
    let from_a = |v: &ScreenVertex<N>| (v.x - a.x, v.y - a.y);
    let farthest = |distance: &dyn Fn(&ScreenVertex<N>) -> f64| {
        vertices.iter().max_by(|v, w| distance(v).total_cmp(&distance(w)))
    };
    let b = farthest(&|v| {
        let (x, y) = from_a(v);
        x * x + y * y
    })?;
    let (bx, by) = from_a(b);
    let c = farthest(&|v| {
        let (x, y) = from_a(v);
        (bx * y - x * by).abs()
    })?;
    Some([a, b, c])
}

/// Whether 1/w, as it is found at a pixel centre, may leave the range of the vertices by more than a
/// quarter of its least value: by its slope, since the centre may lie outside the unrounded polygon
/// by half a subpixel along each axis, or by rounding.
#[inline(always)]
fn is_steep<const N: usize, T: Number>(gradient: &Gradient<N, T>, least_inv_w: T) -> T::Mask {
    let change = gradient.dx.inv_w.abs() + gradient.dy.inv_w.abs();
    let is_large = (least_inv_w * 0.25).is_less(change * (0.5 / f64::from(SUBPIXELS)));
    least_inv_w.is_less(change.all(LEAST_EXACT)) | is_large
}

/// Whether every s is within f32, as it is at the vertices and at pixel centres, which are less than
/// a pixel away from the polygon.
#[inline(always)]
fn fits_f32<const N: usize, T: Number>(
    gradient: &Gradient<N, T>,
    vertices: &[ScreenVertex<N, T>],
) -> T::Mask {
    let mut sum = gradient.dx.z.all(0.0);
    for i in 0..N {
        for v in vertices {
            sum = sum + v.values.s[i].abs();
        }
        sum = sum + gradient.dx.s[i].abs() + gradient.dy.s[i].abs();
    }
    // Written so that NaN does not fit.
    sum.is_less(sum.all(f64::from(f32::MAX)))
}

/// The smallest and the largest value; NaN is passed over.
#[inline(always)]
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| {
        (if v < min { v } else { min }, if v > max { v } else { max })
    })
}
