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
        let points = [
            gathered.points(simd, 0),
            gathered.points(simd, 1),
            gathered.points(simd, 2),
        ];
        let (edges, traits) = TriangleEdges::new(points, rows);
        let positions = [
            gathered.position(simd, 0),
            gathered.position(simd, 1),
            gathered.position(simd, 2),
        ];
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
fn wide<S: Simd, T, U: Into<f64>>(simd: S, lanes: &PerTriangle<T>, f: impl Fn(&T) -> U) -> f64x8<S> {
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
