//! Triangles set up eight at a time.
//!
//! A small triangle's set-up takes as long as its pixels: one step after another, with divisions
//! among them. Here each step is done for eight triangles at once, whose vertices lie side by side.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, SimdFrom, SimdMask, f64x8};

use super::{ByEdges, Method, ScreenPolygon, Setup, WRange, fits_f32, is_steep};
use crate::edge_table::{Each, OneTriangle, TRIANGLES, Triangle};
use crate::gradient::Gradient;
use crate::number::Number;
use crate::project::FixedPoint;
use crate::vertex::{Interpolation, Vertex};

/// The vertices of triangles, and their places on the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedTriangles<const N: usize>([PlacedVertices<N>; 3]);

/// A vertex of each triangle.
#[derive(Clone, Copy, Debug)]
struct PlacedVertices<const N: usize> {
    point: Each<FixedPoint>,
    position: Each<[f32; 4]>,
    params: [Each<f32>; N],
}

/// Triangles that are set up: what [`ScreenPolygon`] has of each, and its lines.
#[derive(Clone, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Triangles<const N: usize> {
    gradient: Gradient<N, Each>,
    lines: Triangle<Each>,
    w_unit: Each,
    w: [Each; 2],
    inv_w: [Each; 2],
    z: [Each; 2],
    /// A bit for each triangle: whether it is like most. Others need more than is found here.
    usual: u64,
}

impl<const N: usize> Default for PlacedTriangles<N> {
    fn default() -> Self {
        let none = PlacedVertices {
            point: [FixedPoint::default(); TRIANGLES],
            position: [[0.0; 4]; TRIANGLES],
            params: [[0.0; TRIANGLES]; N],
        };
        Self([none; 3])
    }
}

impl<const N: usize> PlacedTriangles<N> {
    /// Puts a triangle in its place among the others.
    #[inline(always)]
    pub(crate) fn set(&mut self, number: usize, triangle: [(&Vertex<N>, FixedPoint); 3]) {
        let number = number % TRIANGLES;
        for (vertices, (vertex, point)) in self.0.iter_mut().zip(triangle) {
            vertices.point[number] = point;
            vertices.position[number] = vertex.position.to_array();
            for (each, value) in vertices.params.iter_mut().zip(vertex.params) {
                each[number] = value;
            }
        }
    }
}

impl<const N: usize> PlacedVertices<N> {
    /// The points in subpixels.
    #[inline(always)]
    fn points<S: Simd>(&self, simd: S) -> [f64x8<S>; 2] {
        [wide(simd, &self.point, |point| point.x), wide(simd, &self.point, |point| point.y)]
    }

    #[inline(always)]
    fn position<S: Simd>(&self, simd: S) -> [f64x8<S>; 4] {
        let mut position = [f64x8::splat(simd, 0.0); 4];
        for (axis, each) in position.iter_mut().enumerate() {
            *each = wide(simd, &self.position, |position| position[axis]);
        }
        position
    }

    /// The parameters, of the first vertices where they are flat.
    #[inline(always)]
    fn params<S: Simd>(&self, simd: S, setup: &Setup<N>, provoking: &Self) -> [f64x8<S>; N] {
        let mut params = [f64x8::splat(simd, 0.0); N];
        for (i, param) in params.iter_mut().enumerate() {
            let is_flat = setup.interpolation[i] == Interpolation::Flat;
            let vertices = if is_flat { provoking } else { self };
            *param = wide(simd, &vertices.params[i], |param| *param);
        }
        params
    }
}

impl<const N: usize> Triangles<N> {
    /// Sets up triangles that were not clipped, as far as they are in the given rows.
    #[inline(always)]
    pub(crate) fn set_up<S: Simd>(
        &mut self,
        simd: S,
        setup: &Setup<N>,
        PlacedTriangles([a, b, c]): &PlacedTriangles<N>,
        rows: &Range<i32>,
    ) {
        let points = [a.points(simd), b.points(simd), c.points(simd)];
        let (lines, is_exact) = Triangle::new(points, rows);

        let params = [a.params(simd, setup, a), b.params(simd, setup, a), c.params(simd, setup, a)];
        let [a, b, c] = [a.position(simd), b.position(simd), c.position(simd)];
        let w = Number::range([a[3], b[3], c[3]]);
        let w_unit = w[0].power_of_two_below();
        let divides = w[0].is_less(w[1]);
        let a = setup.project(a, &params[0], w_unit, divides);
        let b = setup.project(b, &params[1], w_unit, divides);
        let c = setup.project(c, &params[2], w_unit, divides);
        let inv_w = Number::range([a.values.inv_w, b.values.inv_w, c.values.inv_w]);
        let z = Number::range([a.values.z, b.values.z, c.values.z]);
        let (gradient, has_planes) = Gradient::fit([&a, &b, &c]);
        let is_steep = divides & is_steep(&gradient, inv_w[0]);
        let usual = is_exact & has_planes & !is_steep & fits_f32(&gradient, &[a, b, c]);

        self.gradient = gradient.map(store);
        self.lines = lines.map(store);
        self.w_unit = store(&w_unit);
        self.w = [store(&w[0]), store(&w[1])];
        self.inv_w = [store(&inv_w[0]), store(&inv_w[1])];
        self.z = [store(&z[0]), store(&z[1])];
        self.usual = usual.to_bitmask();
    }

    /// Takes one of the triangles out: its values, and its lines; `None` if it is not a usual one and
    /// has to be set up as other polygons are.
    #[inline(always)]
    pub(crate) fn take(
        &self,
        number: usize,
        setup: &Setup<N>,
        polygon: &mut ScreenPolygon<N>,
    ) -> Option<OneTriangle<'_>> {
        let number = number % TRIANGLES;
        if self.usual >> number & 1 == 0 {
            return None;
        }
        let one = |each: &Each| each[number];
        let range = |[least, greatest]: &[Each; 2]| (one(least), one(greatest));
        polygon.set_w(setup, one(&self.w_unit), WRange::new(range(&self.w), range(&self.inv_w)));
        if polygon.method == Method::Other {
            return None;
        }
        let (near, far) = range(&self.z);
        polygon.z = (near as f32, far as f32);
        polygon.gradient = self.gradient.map(one);
        polygon.delta = polygon.gradient.dx.rounded();
        polygon.by_edges = ByEdges::default();
        polygon.limits = None;
        Some(OneTriangle { lines: &self.lines, number })
    }
}

/// Numbers with the precision of the set-up. A plain loop, which is inlined whole; `array::map` need
/// not be.
#[inline(always)]
fn wide<S: Simd, T, U: Into<f64>>(simd: S, each: &Each<T>, f: impl Fn(&T) -> U) -> f64x8<S> {
    let mut wide = [0.0; TRIANGLES];
    for (wide, value) in wide.iter_mut().zip(each) {
        *wide = f(value).into();
    }
    f64x8::simd_from(simd, wide)
}

#[inline(always)]
fn store<S: Simd>(lanes: &f64x8<S>) -> Each {
    (*lanes).into()
}
