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

/// Triangles that are set up, and their lines.
#[derive(Clone, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Triangles<const N: usize> {
    values: Values<N, Each>,
    lines: Triangle<Each>,
    /// A bit for each triangle: whether it is like most. Others need more than is found here.
    usual: u64,
}

/// What a [`ScreenPolygon`] has of a triangle, or of each of several.
#[derive(Clone, Debug, Default)]
struct Values<const N: usize, T: Copy> {
    gradient: Gradient<N, T>,
    w_unit: T,
    /// The least and the greatest.
    w: [T; 2],
    inv_w: [T; 2],
    z: [T; 2],
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

impl<const N: usize> PlacedTriangles<N> {
    /// The vertices of a triangle.
    pub(crate) fn get(&self, number: usize) -> [Vertex<N>; 3] {
        let number = number % TRIANGLES;
        self.0.map(|PlacedVertices { position, params, .. }| Vertex {
            position: position[number].into(),
            params: params.map(|each| each[number]),
        })
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
        let positions = [a.position(simd), b.position(simd), c.position(simd)];
        let params = [a.params(simd, setup, a), b.params(simd, setup, a), c.params(simd, setup, a)];
        let (values, is_usual) = Values::new(setup, positions, &params);
        self.lines = lines.map(store);
        self.values = values.map(store);
        self.usual = (is_usual & is_exact).to_bitmask();
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
        polygon.set(setup, self.values.map(|each| each[number]));
        Some(OneTriangle { lines: &self.lines, number })
    }
}

impl<const N: usize> ScreenPolygon<N> {
    /// Sets up a triangle that was not clipped, if it is a usual one: whether it is.
    #[inline(always)]
    pub(crate) fn set_up_triangle(&mut self, setup: &Setup<N>, [a, b, c]: [&Vertex<N>; 3]) -> bool {
        let [a, b, c] = [setup.vertex(a, a), setup.vertex(b, a), setup.vertex(c, a)];
        let positions = [a.position.to_array(), b.position.to_array(), c.position.to_array()];
        let (values, is_usual) = Values::new(setup, positions, &[a.params, b.params, c.params]);
        if is_usual {
            self.set(setup, values);
        }
        is_usual
    }

    #[inline(always)]
    fn set(&mut self, setup: &Setup<N>, values: Values<N, f64>) {
        let Values { gradient, w_unit, w, inv_w, z: [near, far] } = values;
        self.set_w(setup, w_unit, WRange::new(w.into(), inv_w.into()));
        self.z = (near as f32, far as f32);
        self.gradient = gradient;
        self.delta = gradient.dx.rounded();
        self.by_edges = ByEdges::default();
        self.limits = None;
    }
}

impl<const N: usize, T: Copy> Values<N, T> {
    /// The values of a triangle of vertices that were not clipped, and whether it is a usual one: with
    /// planes that can be trusted everywhere, and with a method of its own.
    #[inline(always)]
    fn new(setup: &Setup<N>, [a, b, c]: [[T; 4]; 3], params: &[[T; N]; 3]) -> (Self, T::Mask)
    where
        T: Number,
    {
        let w = T::range([a[3], b[3], c[3]]);
        let w_unit = w[0].power_of_two_below();
        let divides = w[0].is_less(w[1]);
        let a = setup.project(a, &params[0], w_unit, divides);
        let b = setup.project(b, &params[1], w_unit, divides);
        let c = setup.project(c, &params[2], w_unit, divides);
        let inv_w = T::range([a.values.inv_w, b.values.inv_w, c.values.inv_w]);
        let z = T::range([a.values.z, b.values.z, c.values.z]);
        let (gradient, has_planes) = Gradient::fit([&a, &b, &c]);
        let is_steep = is_steep(&gradient, inv_w[0]);
        let mut is_usual = has_planes & !(divides & is_steep) & fits_f32(&gradient, &[a, b, c]);
        if setup.method == Method::Other {
            is_usual = is_usual & !divides;
        }
        (Self { gradient, w_unit, w, inv_w, z }, is_usual)
    }

    /// `f` of each number.
    #[inline(always)]
    fn map<U: Copy>(&self, f: impl Fn(&T) -> U + Copy) -> Values<N, U> {
        let Self { gradient, w_unit, w, inv_w, z } = self;
        Values {
            gradient: gradient.map(f),
            w_unit: f(w_unit),
            w: [f(&w[0]), f(&w[1])],
            inv_w: [f(&inv_w[0]), f(&inv_w[1])],
            z: [f(&z[0]), f(&z[1])],
        }
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
