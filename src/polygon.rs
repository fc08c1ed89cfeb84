//! A polygon on the screen: its outline in subpixels, and how its parameters run over it.
//!
//! Clipped vertices come in; for every run of pixels that the edge table finds, the polygon gives
//! the values of (z, s_1 .. s_n, s_{n+1}) at the first pixel and the change per pixel.
//!
//! What is affine on the polygon (always so on triangles) is one plane over the screen. What is
//! not, such as arbitrary colours at the corners of a quad, is interpolated along the two edges
//! that bound the run and then across it, as in Heckbert's original; it depends on how the polygon
//! is rotated on the screen (Heckbert and Moreton 1991, section 3.4), but stays between the
//! vertices' values.

use std::ops::Range;

use crate::clip::{ClipSpace, ClipVertex};
use crate::edge_table::Run;
use crate::gradient::Gradient;
use crate::project::{
    FixedPoint, Projected, Projection, SUBPIXELS, ScreenParams, ScreenVertex, Viewport,
};
use crate::span::Line;
use crate::vertex::Interpolation;

/// How far the values at the vertices may lie from a plane for this plane to stand for them, as a
/// part of the largest value. Vertices rounded to f32 miss it by a few units of 2^-24; from here
/// to the promised 1e-5 a factor of 5 remains.
const PLANE_TOLERANCE: f64 = 1.0 / (1 << 19) as f64;

/// The same for depth, in absolute terms: four units in the last place of a depth near 1.
const DEPTH_TOLERANCE: f64 = 1.0 / (1 << 22) as f64;

/// The least 1/w, where the greatest is 1 or little less, that is still exact to f32 when it comes
/// out of sums in f64: rounded in units of 2^-53, it is off by 2^-27 of itself.
const LEAST_EXACT: f32 = 1.0 / (1 << 26) as f32;

/// The polygon being scan-converted, with the memory that it needs.
#[derive(Clone, Debug)]
pub(crate) struct ScreenPolygon<const N: usize> {
    /// The corner of the viewport on the framebuffer.
    pub(crate) corner: (i32, i32),
    /// The number of the polygon in its mesh.
    pub(crate) face: u32,
    outline: Vec<FixedPoint>,
    vertices: Vec<ScreenVertex<N>>,
    gradient: Gradient<N>,
    /// The gradient's change per pixel to the right.
    delta: ScreenParams<N, f32>,
    by_edges: ByEdges<N>,
    /// The unit in which w is measured: the power of two at or below the polygon's smallest w. So
    /// 1/w is at most 1 in it, and neither that nor any s overflows f32, however near the eye.
    pub(crate) w_unit: f64,
    pub(crate) w: WRange,
    /// Which parameters are multiplied by w at each pixel.
    pub(crate) times_w: [bool; N],
    /// Whether all are.
    pub(crate) all_times_w: bool,
    /// The smallest and the largest depth of the vertices.
    pub(crate) z: (f32, f32),
    /// The smallest and the largest value of each parameter, if 1/w changes so much, per pixel or in
    /// all, that s / (1/w) cannot be trusted at every pixel centre, or if s changes by more than an
    /// f32 holds.
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
    /// For w from `min` to `max`, measured in `unit`.
    #[inline(always)]
    fn new(unit: f64, min: f64, max: f64) -> Self {
        let w = (min as f32, max as f32);
        // Clipping in f64 may leave less than f32 can tell apart.
        if w.0 == w.1 {
            return Self::Constant { w: w.0, inv_w: 1.0 / w.0 };
        }
        // Below the smallest normal number the reciprocal would not be finite: w ratios over 2^126.
        let least = ((unit / max) as f32).max(f32::MIN_POSITIVE);
        Self::Varying { w, inv_w: (least, (unit / min) as f32) }
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

impl<const N: usize> Default for ScreenPolygon<N> {
    fn default() -> Self {
        Self {
            corner: (0, 0),
            face: 0,
            outline: Vec::new(),
            vertices: Vec::new(),
            gradient: Gradient::default(),
            delta: ScreenParams::default().rounded(),
            by_edges: ByEdges::default(),
            w_unit: 1.0,
            w: WRange::Constant { w: 1.0, inv_w: 1.0 },
            times_w: [false; N],
            all_times_w: false,
            z: (0.0, 1.0),
            limits: None,
        }
    }
}

impl<const N: usize> ScreenPolygon<N> {
    /// Brings a clipped polygon to the screen: its vertices, each with its projection.
    #[inline(always)]
    pub(crate) fn project(
        &mut self,
        polygon: impl Iterator<Item = (ClipVertex<N>, Projected)> + Clone,
        viewport: &Viewport,
        clip_space: ClipSpace,
        interpolation: &[Interpolation; N],
    ) {
        let (min, max) = extent(polygon.clone().map(|(v, _)| v.position.w));
        let w_unit = power_of_two_below(min);
        self.w_unit = w_unit;
        self.w = WRange::new(w_unit, min, max);
        let divides = matches!(self.w, WRange::Varying { .. });
        self.times_w = interpolation.map(|i| divides && i == Interpolation::Perspective);
        self.all_times_w = self.times_w == [true; N];
        let projection =
            Projection { viewport: *viewport, clip_space, w_unit, divide: self.times_w };
        self.corner = (viewport.rect().x, viewport.rect().y);
        let [near, far] = viewport.depth().map(f64::from);
        let (near, far) = (near.min(far), near.max(far));
        self.outline.clear();
        self.vertices.clear();
        for (vertex, projected) in polygon {
            let mut vertex = projection.vertex(&vertex, projected.inv_w);
            // Clipping has brought it here but for rounding.
            vertex.values.z = vertex.values.z.max(near).min(far);
            self.outline.push(projected.point);
            self.vertices.push(vertex);
        }
    }

    /// The outline in subpixels.
    pub(crate) fn outline(&self) -> &[FixedPoint] {
        &self.outline
    }

    /// Finds the planes of the values, and the values that have none. `flat` says that there is no
    /// need to look: all are known to be affine on the polygon.
    pub(crate) fn fit_planes(&mut self, flat: bool) {
        let (near, far) = extent(self.vertices.iter().map(|v| v.values.z));
        self.z = (near as f32, far as f32);
        let gradient = widest_triangle(&self.vertices).and_then(Gradient::through);
        self.gradient = gradient.unwrap_or_default();
        self.delta = self.gradient.dx.rounded();
        let finite = self.gradient.dx.s.iter().all(|d| d.abs() <= f64::from(f32::MAX));
        self.by_edges = match gradient {
            None => ByEdges { any: true, z: true, inv_w: true, s: Flags([true; N]) },
            Some(_) if flat => ByEdges::default(),
            Some(gradient) => self.misfits(&gradient),
        };
        self.limits = if self.is_steep() || !finite { Some(self.limits()) } else { None };
    }

    /// Whether 1/w, as it is found at a pixel centre, may leave the range of the vertices by more
    /// than a quarter of its least value: by its slope, since the centre may lie outside the
    /// unrounded polygon by half a subpixel along each axis, or by rounding.
    #[inline(always)]
    fn is_steep(&self) -> bool {
        let WRange::Varying { inv_w: (least, _), .. } = self.w else { return false };
        let change = self.gradient.dx.inv_w.abs() + self.gradient.dy.inv_w.abs();
        least < LEAST_EXACT || change * (0.5 / f64::from(SUBPIXELS)) > 0.25 * f64::from(least)
    }

    #[cold]
    fn limits(&self) -> [(f32, f32); N] {
        std::array::from_fn(|i| {
            let (min, max) = extent(self.vertices.iter().map(|v| self.parameter(v, i)));
            (min as f32, max as f32)
        })
    }

    /// Which values at the vertices do not lie on the planes.
    #[cold]
    fn misfits(&self, gradient: &Gradient<N>) -> ByEdges<N> {
        let mut largest = [0.0f64; N];
        for v in &self.vertices {
            for (i, largest) in largest.iter_mut().enumerate() {
                *largest = largest.max(self.parameter(v, i).abs());
            }
        }
        let mut by_edges = ByEdges::<N>::default();
        for v in &self.vertices {
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
            let Line { x, at, delta } = self.line_by_edges(run);
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

    #[cold]
    fn line_by_edges(&self, run: &Run) -> Line<N> {
        let (start, delta) = self.along(run);
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

/// A point that moves down along an edge: where it is at a row's centre line, and the change per row.
struct Along<const N: usize> {
    x: f64,
    dx: f64,
    values: ScreenParams<N>,
    change: ScreenParams<N>,
}

impl<const N: usize> Along<N> {
    fn new(vertices: &[ScreenVertex<N>], edge: u32, y: i32) -> Self {
        let a = &vertices[edge as usize];
        let b = &vertices[(edge as usize + 1) % vertices.len()];
        // An edge that is not rounded to a horizontal one is not horizontal.
        let height = b.y - a.y;
        let t = ((f64::from(y) + 0.5 - a.y) / height).clamp(0.0, 1.0);
        Self {
            x: a.x + (b.x - a.x) * t,
            dx: (b.x - a.x) / height,
            values: a.values.zip(&b.values, |a, b| a + (b - a) * t),
            change: a.values.zip(&b.values, |a, b| (b - a) / height),
        }
    }
}

/// Interpolation between the two edges of a run, in Heckbert's way.
struct Across<const N: usize> {
    left: Along<N>,
    right: Along<N>,
    width: f64,
}

impl<const N: usize> Across<N> {
    fn new(polygon: &ScreenPolygon<N>, run: &Run) -> Self {
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
        let change = self.left.change.zip(&self.right.change, |l, r| l + (r - l) * t);
        if self.width <= 0.0 {
            return change;
        }
        let dt = -(self.left.dx + (self.right.dx - self.left.dx) * t) / self.width;
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

/// The smallest and the largest value; NaN is passed over.
#[inline(always)]
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), v| {
        (if v < min { v } else { min }, if v > max { v } else { max })
    })
}

/// The power of two at or below a positive normal number.
fn power_of_two_below(value: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    f64::from_bits(value.to_bits() & EXPONENT)
}
