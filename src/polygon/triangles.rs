//! Triangles set up eight at a time.
//!
//! A small triangle's set-up takes as long as its pixels: one step after another, with divisions
//! among them. Here each step is done for eight triangles at once, whose vertices lie side by side.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, SimdFrom, SimdMask, f64x8};

use super::{ByEdges, Method, ScreenPolygon, Setup, WRange, fits_f32, is_steep};
use crate::edge_table::{OneTriangle, Triangle};
use crate::gradient::Gradient;
use crate::number::{Each, Number, TRIANGLES};
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
    /// A bit for each triangle: whether it is a usual one, of which the lines are exact, too. Others need
    /// more than is found here.
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

    /// Takes one of the triangles out: its values, and its lines; `None` if it is not a usual one with
    /// exact lines, and has to be set up as other polygons are.
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

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use glam::vec4;

    use super::{PlacedTriangles, TRIANGLES, Triangle, Triangles};
    use crate::clip::ClipSpace;
    use crate::polygon::{Method, ScreenPolygon, Setup};
    use crate::project::{FixedPoint, Viewport};
    use crate::vertex::{Interpolation, Vertex};

    /// Marsaglia's xorshift.
    struct Rng(u64);

    impl Rng {
        fn below(&mut self, end: u64) -> u64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 16) % end
        }

        fn within(&mut self, range: f32) -> f32 {
            (self.below(1 << 24) as f32 / (1 << 23) as f32 - 1.0) * range
        }

        fn triangle(&mut self) -> [Vertex<3>; 3] {
            let size = [1e-4, 1e-2, 1.0, 100.0][self.below(4) as usize];
            let [x, y] = [0; 2].map(|_| self.within(1.0));
            let (w, ratio) =
                (1.0 + self.within(0.9), [0.0, 0.1, 1e3, 1e12][self.below(4) as usize]);
            let mut triangle = [0; 3].map(|_| {
                let w = w * (1.0 + ratio * (1.0 + self.within(1.0)));
                let [x, y, z] = [x + self.within(size), y + self.within(size), self.within(1.0)];
                let largest = [1.0, 1e4, f32::MAX][self.below(16).saturating_sub(13) as usize];
                let params = [0; 3].map(|_| self.within(largest));
                Vertex::new(vec4(x * w, y * w, z.abs() * w, w), params)
            });
            match self.below(8) {
                // On a line, or nearly so; a point.
                0 => triangle[2].position = (triangle[0].position + triangle[1].position) * 0.5,
                1 => triangle[2].position = triangle[1].position,
                2 => triangle[1].params[0] = f32::NAN,
                _ => {}
            }
            triangle
        }
    }

    /// Whether a triangle is one that needs no more than its planes, and lines that are exact.
    fn is_usual(polygon: &ScreenPolygon<3>, points: &[FixedPoint; 3]) -> bool {
        let extent = |axis: fn(&FixedPoint) -> i32| {
            let values = points.each_ref().map(axis);
            values.iter().max().zip(values.iter().min()).map_or(0, |(max, min)| max - min)
        };
        let is_exact = extent(|p| p.x).max(extent(|p| p.y)) <= 1 << 22;
        is_exact && !polygon.needs_edges() && polygon.method != Method::Other
    }

    /// Everything that is set up, to the bit.
    fn bits(polygon: &ScreenPolygon<3>) -> String {
        let ScreenPolygon {
            corner, gradient, delta, w_unit, w, times_w, method, z, limits, ..
        } = polygon;
        format!(
            "{corner:?} {gradient:?} {delta:?} {w_unit:?} {w:?} {times_w:?} {method:?} {z:?} {limits:?}"
        )
    }

    #[test]
    fn eight_at_once_one_alone_and_any_polygon_are_set_up_alike() {
        use Interpolation::{Flat, Linear, Perspective};
        let viewport = Viewport::new(700, 300).expect("it is not too large");
        let mut rng = Rng(0x9e37_79b9_7f4a_7c15);
        let (mut usual, mut unusual) = (0, 0);
        for round in 0..4000 {
            let interpolation = [[Perspective; 3], [Flat, Linear, Perspective]][round % 2];
            let setup = Setup::new(&viewport, ClipSpace::default(), interpolation);
            let mut placed = PlacedTriangles::default();
            let some = [0; TRIANGLES].map(|_| rng.triangle());
            let project = |v: &Vertex<3>| FixedPoint::project(v.position.as_dvec4(), &viewport);
            for (number, [a, b, c]) in some.iter().enumerate() {
                placed.set(number, [(a, project(a)), (b, project(b)), (c, project(c))]);
            }
            for level in [Level::baseline(), Level::new()] {
                let mut triangles = Triangles::default();
                dispatch!(level, simd => triangles.set_up(simd, &setup, &placed, &(0..300)));
                for (number, triangle) in some.iter().enumerate() {
                    let vertices = triangle.iter().map(|v| setup.vertex(v, &triangle[0]));
                    let [mut any, mut alone, mut together] =
                        [0; 3].map(|_| ScreenPolygon::default());
                    any.set_up(&setup, vertices, true);
                    let points = triangle.each_ref().map(project);
                    let is_taken = triangles.take(number, &setup, &mut together).is_some();
                    assert_eq!(is_taken, is_usual(&any, &points), "{triangle:?}");
                    if is_taken {
                        assert!(alone.set_up_triangle(&setup, triangle.each_ref()));
                        assert_eq!(bits(&alone), bits(&any), "{triangle:?}");
                        assert_eq!(bits(&together), bits(&any), "{triangle:?}");
                        let points = points.map(|p| [p.x, p.y].map(f64::from));
                        let (lines, _) = Triangle::new(points, &(0..300));
                        let taken = triangles.lines.map(|each| each[number]);
                        assert_eq!(format!("{taken:?}"), format!("{lines:?}"), "{triangle:?}");
                        usual += 1;
                    } else {
                        unusual += 1;
                    }
                }
            }
        }
        assert!(usual > 10_000 && unusual > 10_000, "{usual} {unusual}");
    }
}
