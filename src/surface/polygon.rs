//! The set-up of one polygon: from its vertices to how its parameters run over the screen.

use glam::DVec4;

use crate::project::ScreenPoint;
use crate::scalar::{BATCH, Scalar};
use crate::settings::DrawCall;
use crate::surface::base::{Divide, SurfaceBase, WRange};
use crate::surface::mixed::{Component, Mixed, ScreenVertices, extent};
use crate::surface::plane::{BatchPlane, PlaneBasis, ScreenPlane};
use crate::surface::rows::SurfaceView;
use crate::surface::triangle::{TriangleSurface, fits_f32, is_divided, is_steep, project};

/// How far the values at the vertices may lie from a plane for this plane to stand for them, as a
/// part of the largest value. Vertices rounded to f32 miss it by a few units of 2^-24; from here
/// to the promised 1e-5 a factor of 5 remains.
const PLANE_TOLERANCE: f64 = 1.0 / (1 << 19) as f64;

/// The same for depth, in absolute terms: four units in the last place of a depth near 1.
const DEPTH_TOLERANCE: f64 = 1.0 / (1 << 22) as f64;

/// A polygon that is set up, with the memory that this takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct PolygonSurface {
    base: SurfaceBase,
    /// Planes in the first lane alone.
    params: Vec<BatchPlane>,
    mixed: Mixed,
    has_planes_only: bool,
}

impl PolygonSurface {
    /// How the parameters run.
    #[inline(always)]
    pub(crate) fn view(&self) -> SurfaceView<'_> {
        let mixed = if self.has_planes_only { None } else { Some(&self.mixed) };
        SurfaceView { base: &self.base, params: &self.params, lane: 0, mixed }
    }

    /// Sets up a triangle that was not clipped, if its planes suffice: whether they do. `params` are the
    /// parameters of its corners, end to end.
    pub(crate) fn set_up_triangle(
        &mut self,
        call: &DrawCall<'_>,
        (face, is_front): (u32, bool),
        positions: &[DVec4; 3],
        params: &[f64],
    ) -> bool {
        let n = call.params();
        self.params.resize(n, BatchPlane::default());
        let planes = &mut self.params;
        let (surface, is_plain) = TriangleSurface::new(
            call,
            positions.map(|p| p.to_array()),
            |i| [params[i], params[n + i], params[2 * n + i]],
            |i, plane| store(&mut planes[i], plane),
        );
        if is_plain {
            surface.set_base(&mut self.base, call, face, is_front);
            self.has_planes_only = true;
        }
        is_plain
    }

    /// Sets up a polygon that is inside of all planes, clipped or not, from its vertices. `affine` says
    /// that all values are known to be affine on the polygon.
    pub(crate) fn set_up(
        &mut self,
        call: &DrawCall<'_>,
        (face, is_front): (u32, bool),
        positions: &[DVec4],
        params: &[f64],
        affine: bool,
    ) {
        let (min, max) = extent(positions.iter().map(|p| p.w));
        let unit = min.power_of_two_below();
        let w = WRange::new([min, max], [unit / max, unit / min]);
        self.mixed.times_w.clear();
        let times_w = (0..call.params()).map(|i| w.varies() && is_divided(call, i));
        self.mixed.times_w.extend(times_w);
        self.project(call, positions, params, unit);
        let (near, far) = extent(self.mixed.vertices.points.iter().map(|p| p.z));
        self.base = SurfaceBase {
            corner: call.projection.corner,
            last_column: call.projection.last_column,
            face,
            is_front,
            z_range: (near as f32, far as f32),
            w_unit: unit,
            w,
            divide: match w.varies() {
                false => Divide::Never,
                true if call.is_all_perspective => Divide::PerPixel,
                true => Divide::Mixed,
            },
            ..SurfaceBase::default()
        };
        self.fit(affine);
        if call.coverage_rule.is_outer() {
            self.reach_out(call);
        }
        let bias = self.base.add_bias(call);
        self.mixed.vertices.points.iter_mut().for_each(|point| point.z += bias);
    }

    /// Makes ready for pixels whose centres lie outside: each run is looked at alone, and if values are
    /// extrapolated their ranges are wider.
    #[cold]
    fn reach_out(&mut self, call: &DrawCall<'_>) {
        let Self { base, mixed, has_planes_only, .. } = self;
        (mixed.any_by_edges, *has_planes_only) = (true, false);
        if !call.coverage_rule.extrapolates() || mixed.z_by_edges || mixed.inv_w_by_edges {
            return;
        }
        let (near, far) = call.projection.depth_range();
        base.z_range = (near as f32, far as f32);
        let WRange::Varying { w, inv_w } = &mut base.w else { return };
        // A centre lies half a pixel outside at most, along each axis.
        let change = 0.5 * (base.inv_w.dx.abs() + base.inv_w.dy.abs());
        if mixed.has_limits || change > 0.5 * f64::from(inv_w.0) {
            if !mixed.has_limits {
                self.find_limits();
                self.mixed.has_limits = true;
                self.base.divide = Divide::Mixed;
            }
            return;
        }
        (*w, *inv_w) = ((w.0 * 0.5, w.1 * 2.0), (inv_w.0 * 0.5, inv_w.1 * 2.0));
    }

    /// Projects the vertices.
    fn project(&mut self, call: &DrawCall<'_>, positions: &[DVec4], params: &[f64], unit: f64) {
        let Mixed { vertices: ScreenVertices { points, s, params: n }, times_w, .. } =
            &mut self.mixed;
        *n = call.params();
        points.clear();
        points.extend(positions.iter().map(|p| project(call, p.to_array(), unit)));
        s.clear();
        s.extend_from_slice(params);
        let each = s.chunks_exact_mut((*n).max(1));
        for (s, point) in each.zip(&*points) {
            for (s, times_w) in s.iter_mut().zip(&*times_w) {
                if *times_w {
                    *s *= point.inv_w;
                }
            }
        }
    }

    /// Finds the planes of the values, and the values that have none.
    fn fit(&mut self, affine: bool) {
        let has_planes = self.find_planes();
        let mixed = &mut self.mixed;
        let n = mixed.vertices.params;
        mixed.s_by_edges.clear();
        mixed.s_by_edges.resize(n, !has_planes);
        (mixed.z_by_edges, mixed.inv_w_by_edges) = (!has_planes, !has_planes);
        mixed.any_by_edges = !has_planes;
        if has_planes && !affine {
            self.find_misfits();
        }
        self.mixed.limits.clear();
        self.mixed.has_limits = false;
        let (least, _) = extent(self.mixed.vertices.points.iter().map(|p| p.inv_w));
        let is_steep = self.base.w.varies() && is_steep(&self.base.inv_w, least);
        if is_steep || !self.fits_f32() {
            self.find_limits();
            self.mixed.has_limits = true;
            self.base.divide = Divide::Mixed;
        }
        self.has_planes_only = self.base.divide != Divide::Mixed && !self.mixed.any_by_edges;
    }

    /// Lays planes through the values at three of the vertices; whether there are any.
    fn find_planes(&mut self) -> bool {
        let Self { base, params, mixed: Mixed { vertices, .. }, .. } = self;
        (base.z, base.inv_w) = Default::default();
        // Other lanes than the first may keep what they have.
        params.resize(vertices.params, BatchPlane::default());
        let triangle = widest_triangle(&vertices.points);
        if let Some([a, b, c]) = triangle {
            let [pa, pb, pc] = [&vertices.points[a], &vertices.points[b], &vertices.points[c]];
            let basis = PlaneBasis::new([[pa.x, pa.y], [pb.x, pb.y], [pc.x, pc.y]]);
            let z = basis.plane([pa.z, pb.z, pc.z]);
            let inv_w = basis.plane([pa.inv_w, pb.inv_w, pc.inv_w]);
            if basis.is_wide && (z.dx + inv_w.dx + (z.dy + inv_w.dy)).is_finite() {
                (base.origin, base.z, base.inv_w) = ([pa.x, pa.y], z, inv_w);
                let [sa, sb, sc] = [vertices.s(a), vertices.s(b), vertices.s(c)];
                for (((lanes, a), b), c) in params.iter_mut().zip(sa).zip(sb).zip(sc) {
                    store(lanes, basis.plane([*a, *b, *c]));
                }
                return true;
            }
        }
        params.iter_mut().for_each(|lanes| store(lanes, ScreenPlane::default()));
        false
    }

    #[cold]
    fn find_limits(&mut self) {
        let mixed = &mut self.mixed;
        for i in 0..mixed.vertices.params {
            let (min, max) = mixed.vertices.extent(|vertex| mixed.parameter(vertex, i));
            mixed.limits.push((min as f32, max as f32));
        }
    }

    /// Finds which values at the vertices do not lie on the planes.
    #[inline(never)]
    fn find_misfits(&mut self) {
        let Self { base, params, mixed, .. } = self;
        // Written so that NaN is a misfit, too.
        let fits = |off: f64, tolerance: f64| off <= tolerance;
        let from_origin = |p: &ScreenPoint| (p.x - base.origin[0], p.y - base.origin[1]);
        for point in &mixed.vertices.points {
            let (x, y) = from_origin(point);
            let off = |plane: &ScreenPlane, value: f64| (plane.at(x, y) - value).abs();
            mixed.z_by_edges |= !fits(off(&base.z, point.z), DEPTH_TOLERANCE);
            let tolerance = PLANE_TOLERANCE * point.inv_w;
            mixed.inv_w_by_edges |= !fits(off(&base.inv_w, point.inv_w), tolerance);
        }
        for (i, plane) in params.iter().enumerate() {
            let plane = plane.of(0);
            let count = mixed.vertices.points.len();
            let largest =
                (0..count).fold(0.0f64, |largest, v| largest.max(mixed.parameter(v, i).abs()));
            for (v, point) in mixed.vertices.points.iter().enumerate() {
                let (x, y) = from_origin(point);
                let per_w = if mixed.times_w[i] { point.inv_w } else { 1.0 };
                let off = (plane.at(x, y) - mixed.vertices.get(v, Component::S(i))).abs();
                mixed.s_by_edges[i] |= !fits(off, PLANE_TOLERANCE * largest * per_w);
            }
            // r = s / (1/w) stays between the vertices' values only if both go the same way.
            mixed.s_by_edges[i] |= mixed.inv_w_by_edges && mixed.times_w[i];
            mixed.any_by_edges |= mixed.s_by_edges[i];
        }
        mixed.any_by_edges |= mixed.z_by_edges || mixed.inv_w_by_edges;
    }

    fn fits_f32(&self) -> bool {
        let Self { params, mixed: Mixed { vertices, .. }, .. } = self;
        let mut sum = 0.0;
        for (i, plane) in params.iter().enumerate() {
            for s in vertices.s.iter().skip(i).step_by(vertices.params) {
                sum += s.abs();
            }
            let plane = plane.of(0);
            sum = sum + plane.dx.abs() + plane.dy.abs();
        }
        fits_f32(sum)
    }
}

/// Stores the plane of a polygon that is alone in the first lane of a batch.
fn store(BatchPlane(lanes): &mut BatchPlane, plane: ScreenPlane) {
    const { assert!(BATCH > 0) };
    (lanes.value[0], lanes.dx[0], lanes.dy[0]) = (plane.value, plane.dx, plane.dy);
}

/// A triangle of vertices that spans the polygon well: the first vertex, the one farthest from it,
/// and the one farthest from the line through both. Everything on the polygon is near to it, so
/// that its plane is not extrapolated far.
pub(crate) fn widest_triangle(points: &[ScreenPoint]) -> Option<[usize; 3]> {
    if points.len() == 3 {
        return Some([0, 1, 2]);
    }
    let a = points.first()?;
    let from_a = |v: usize| (points[v].x - a.x, points[v].y - a.y);
    let farthest = |distance: &dyn Fn(usize) -> f64| {
        (0..points.len()).max_by(|&v, &w| distance(v).total_cmp(&distance(w)))
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
    Some([0, b, c])
}
