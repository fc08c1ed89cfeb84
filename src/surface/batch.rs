//! A batch of eight triangles that are set up at once.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, SimdFrom, SimdMask, f64x8};

use crate::coverage::triangle::{BatchLane, TriangleEdges};
use crate::scalar::{BATCH, PerTriangle};
use crate::settings::DrawCall;
use crate::subpixel::SubpixelPoint;
use crate::surface::base::{Divide, SurfaceBase, WRange};
use crate::surface::plane::BatchPlane;
use crate::surface::rows::SurfaceView;
use crate::surface::triangle::TriangleSurface;
use crate::vertex::Interpolation;

/// The corners of triangles, side by side, and their places on the screen.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct GatheredTriangles {
    pub(crate) points: [PerTriangle<SubpixelPoint>; 3],
    pub(crate) positions: [PerTriangle<[f32; 4]>; 3],
    /// The values of each parameter at the corners.
    pub(crate) params: Vec<[PerTriangle<f32>; 3]>,
}

impl Default for GatheredTriangles {
    fn default() -> Self {
        Self {
            points: [[SubpixelPoint::default(); BATCH]; 3],
            positions: [[[0.0; 4]; BATCH]; 3],
            params: Vec::new(),
        }
    }
}

impl GatheredTriangles {
    /// Makes room for so many parameters.
    pub(crate) fn resize(&mut self, params: usize) {
        self.params.resize(params, [[0.0; BATCH]; 3]);
    }

    /// The points in subpixels.
    #[inline(always)]
    fn points<S: Simd>(&self, simd: S, corner: usize) -> [f64x8<S>; 2] {
        let points = &self.points[corner];
        [wide(simd, points, |point| point.x), wide(simd, points, |point| point.y)]
    }

    #[inline(always)]
    fn position<S: Simd>(&self, simd: S, corner: usize) -> [f64x8<S>; 4] {
        let mut position = [f64x8::splat(simd, 0.0); 4];
        for (axis, lanes) in position.iter_mut().enumerate() {
            *lanes = wide(simd, &self.positions[corner], |position| position[axis]);
        }
        position
    }

    /// The edges of the triangles, moved by so many subpixels to the left and upwards: what they cover at
    /// pixel centres, the triangles cover so far to the right of and below them.
    #[inline(always)]
    pub(crate) fn edges_at<S: Simd>(
        &self,
        simd: S,
        rows: &Range<i32>,
        [x, y]: [f64; 2],
    ) -> TriangleEdges<PerTriangle> {
        let moved = |corner: usize| {
            let [px, py] = self.points(simd, corner);
            [px - x, py - y]
        };
        TriangleEdges::new([moved(0), moved(1), moved(2)], rows).0.map(store)
    }

    /// A parameter at the corners, at the first one alone if it is flat.
    #[inline(always)]
    fn param<S: Simd>(&self, simd: S, call: &DrawCall<'_>, i: usize) -> [f64x8<S>; 3] {
        let [a, b, c] = &self.params[i];
        let is_flat = !call.is_all_perspective && call.interpolation[i] == Interpolation::Flat;
        let [b, c] = if is_flat { [a, a] } else { [b, c] };
        // Three calls, not `array::map`, which need not be inlined.
        let lanes = |corner| wide(simd, corner, |param: &f32| *param);
        [lanes(a), lanes(b), lanes(c)]
    }
}

/// Triangles that are set up, and their edges. In this order, the lanes of each number fill a cache line.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct TriangleBatch {
    surfaces: TriangleSurface<PerTriangle>,
    edges: TriangleEdges<PerTriangle>,
    params: Vec<BatchPlane>,
    /// Bit k is set if triangle k can be drawn from what is here alone. The others are set up as other
    /// polygons are.
    plain: u64,
    /// Bit k is set if triangle k runs clockwise on the screen.
    clockwise: u64,
    /// Of the triangle that was taken last.
    base: SurfaceBase,
}

impl TriangleBatch {
    /// Sets up triangles that were not clipped, as far as they are in the given rows.
    #[inline(always)]
    pub(crate) fn set_up<S: Simd>(
        &mut self,
        simd: S,
        call: &DrawCall<'_>,
        gathered: &GatheredTriangles,
        rows: &Range<i32>,
    ) {
        let points = [gathered.points(simd, 0), gathered.points(simd, 1), gathered.points(simd, 2)];
        let (edges, traits) = TriangleEdges::new(points, rows);
        let positions =
            [gathered.position(simd, 0), gathered.position(simd, 1), gathered.position(simd, 2)];
        self.params.resize(call.params(), BatchPlane::default());
        let planes = &mut self.params[..call.params()];
        let (surfaces, is_plain) = TriangleSurface::new(
            call,
            positions,
            #[inline(always)]
            |i| gathered.param(simd, call, i),
            #[inline(always)]
            |i, plane| planes[i].0 = plane.map(store),
        );
        self.edges = edges.map(store);
        self.surfaces = surfaces.map(store);
        self.plain = (is_plain & traits.is_exact).to_bitmask();
        self.clockwise = traits.is_clockwise.to_bitmask();
    }

    /// Takes one of the triangles: how its parameters run, and what it covers. `None` if it has to be set
    /// up as other polygons are.
    #[inline(always)]
    pub(crate) fn take(
        &mut self,
        lane: usize,
        call: &DrawCall<'_>,
        face: u32,
    ) -> Option<(SurfaceView<'_>, BatchLane<'_>)> {
        debug_assert!(lane < BATCH, "a batch has eight lanes");
        // The remainder saves a check of each index.
        let lane = lane % BATCH;
        if self.plain >> lane & 1 == 0 {
            return None;
        }
        let surface = self.surfaces.map(|lanes| lanes[lane]);
        let is_front = call.front_face.is_front(self.clockwise >> lane & 1 != 0);
        surface.set_base(&mut self.base, call, face, is_front);
        let surface = SurfaceView { base: &self.base, params: &self.params, lane, mixed: None };
        Some((surface, BatchLane { edges: &self.edges, lane }))
    }
}

impl TriangleSurface<f64> {
    /// Sets what all parameters have in common, of a triangle whose planes can be used. Each number is
    /// stored where it stays: a copy of what was just stored in parts would have to wait for them.
    #[inline(always)]
    pub(crate) fn set_base(
        &self,
        base: &mut SurfaceBase,
        call: &DrawCall<'_>,
        face: u32,
        is_front: bool,
    ) {
        base.corner = call.projection.corner;
        base.last_column = call.projection.last_column;
        base.face = face;
        base.is_front = is_front;
        base.origin = self.origin;
        base.z = self.z;
        base.inv_w = self.inv_w;
        base.z_range = (self.z_range[0] as f32, self.z_range[1] as f32);
        base.w_unit = self.w_unit;
        base.w = WRange::new(self.w, self.inv_w_range);
        base.divide = if base.w.varies() { Divide::PerPixel } else { Divide::Never };
        base.add_bias(call);
    }
}

/// Numbers with the precision of the set-up. A plain loop, which is inlined whole; `array::map` need
/// not be.
#[inline(always)]
fn wide<S: Simd, T, U: Into<f64>>(
    simd: S,
    lanes: &PerTriangle<T>,
    f: impl Fn(&T) -> U,
) -> f64x8<S> {
    let mut wide = [0.0; BATCH];
    for (wide, value) in wide.iter_mut().zip(lanes) {
        *wide = f(value).into();
    }
    f64x8::simd_from(simd, wide)
}

#[inline(always)]
fn store<S: Simd>(lanes: &f64x8<S>) -> PerTriangle {
    (*lanes).into()
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use glam::{Vec4, vec4};

    use super::{BATCH, GatheredTriangles, TriangleBatch};
    use crate::coverage::triangle::TriangleEdges;
    use crate::settings::Settings;
    use crate::subpixel::SubpixelPoint;
    use crate::surface::base::Divide;
    use crate::surface::polygon::PolygonSurface;
    use crate::surface::rows::SurfaceView;
    use crate::test_rng::Rng;
    use crate::vertex::{Interpolation, Vertex};
    use crate::vertices::Vertices;
    use crate::viewport::Viewport;

    fn triangle(rng: &mut Rng) -> [Vertex<3>; 3] {
        let size = [1e-4, 1e-2, 1.0, 100.0][rng.below(4) as usize];
        let [x, y] = [0; 2].map(|_| rng.float(1.0));
        let (w, ratio) = (1.0 + rng.float(0.9), [0.0, 0.1, 1e3, 1e12][rng.below(4) as usize]);
        let mut triangle = [0; 3].map(|_| {
            let w = w * (1.0 + ratio * (1.0 + rng.float(1.0)));
            let [x, y, z] = [x + rng.float(size), y + rng.float(size), rng.float(1.0)];
            let largest = [1.0, 1e4, f32::MAX][rng.below(16).saturating_sub(13) as usize];
            let params = [0; 3].map(|_| rng.float(largest));
            Vertex::new(vec4(x * w, y * w, z.abs() * w, w), params)
        });
        match rng.below(8) {
            // On a line, or nearly so; a point.
            0 => triangle[2].position = (triangle[0].position + triangle[1].position) * 0.5,
            1 => triangle[2].position = triangle[1].position,
            2 => triangle[1].params[0] = f32::NAN,
            _ => {}
        }
        triangle
    }

    /// Whether a triangle needs no more than its planes, and edges that are exact.
    fn is_plain(surface: &SurfaceView<'_>, points: &[SubpixelPoint; 3]) -> bool {
        let extent = |axis: fn(&SubpixelPoint) -> i32| {
            let values = points.each_ref().map(axis);
            values.iter().max().zip(values.iter().min()).map_or(0, |(max, min)| max - min)
        };
        let is_exact = extent(|p| p.x).max(extent(|p| p.y)) <= 1 << 22;
        is_exact && !surface.needs_edges() && surface.base.divide != Divide::Mixed
    }

    /// Everything that is set up, to the bit.
    fn bits(surface: &SurfaceView<'_>) -> String {
        let planes: Vec<_> = surface.params.iter().map(|plane| plane.of(surface.lane)).collect();
        format!("{:?} {planes:?}", surface.base)
    }

    #[test]
    fn eight_at_once_one_alone_and_any_polygon_are_set_up_alike() {
        use Interpolation::{Flat, Linear, Perspective};
        let viewport = Viewport::new(700, 300).expect("it is not too large");
        let mut rng = Rng(0x9e37_79b9_7f4a_7c15);
        let (mut plain, mut others) = (0, 0);
        for round in 0..4000 {
            let mut settings = Settings::new(viewport);
            settings.interpolation = [[Perspective; 3], [Flat, Linear, Perspective]][round % 2];
            let call = settings.call(viewport.rect(), &[]);
            let triangles = [0; BATCH].map(|_| triangle(&mut rng));
            let vertices = triangles.as_flattened();
            let indices: [[u32; 3]; BATCH] =
                std::array::from_fn(|lane| [0, 1, 2].map(|corner| 3 * lane as u32 + corner));
            let project = |v: Vec4| SubpixelPoint::project(v.as_dvec4(), &viewport);
            let mut gathered = GatheredTriangles::default();
            gathered.resize(3);
            (&vertices).gather(&indices, &mut gathered.positions, &mut gathered.params);
            for (lane, triangle) in triangles.iter().enumerate() {
                for (corner, vertex) in triangle.iter().enumerate() {
                    gathered.points[corner][lane] = project(vertex.position);
                }
            }
            for level in [Level::baseline(), Level::new()] {
                let mut batch = TriangleBatch::default();
                dispatch!(level, simd => batch.set_up(simd, &call, &gathered, &(0..300)));
                for (lane, triangle) in triangles.iter().enumerate() {
                    let positions = triangle.map(|v| v.position.as_dvec4());
                    let mut params: Vec<f64> =
                        triangle.iter().flat_map(|v| v.params).map(f64::from).collect();
                    if round % 2 == 1 {
                        (params[3], params[6]) = (params[0], params[0]);
                    }
                    let points = triangle.map(|v| project(v.position));
                    let edges = points.map(|p| [p.x, p.y].map(f64::from));
                    let (edges, traits) = TriangleEdges::new(edges, &(0..300));
                    let face = (7, call.front_face.is_front(traits.is_clockwise));
                    let (mut any, mut alone) =
                        (PolygonSurface::default(), PolygonSurface::default());
                    any.set_up(&call, face, &positions, &params, true);
                    let found = batch.take(lane, &call, 7);
                    assert_eq!(found.is_some(), is_plain(&any.view(), &points), "{triangle:?}");
                    let Some((together, lines)) = found else {
                        others += 1;
                        continue;
                    };
                    assert!(alone.set_up_triangle(&call, face, &positions, &params));
                    assert_eq!(bits(&alone.view()), bits(&any.view()), "{triangle:?}");
                    assert_eq!(bits(&together), bits(&any.view()), "{triangle:?}");
                    let taken = lines.edges.map(|lanes| lanes[lane]);
                    assert_eq!(format!("{taken:?}"), format!("{edges:?}"), "{triangle:?}");
                    plain += 1;
                }
            }
        }
        assert!(plain > 10_000 && others > 10_000, "{plain} {others}");
    }
}
