//! Clipping a polygon by planes, in rational numbers.

use std::array::from_fn;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::{Depth, Exact, Plane, Position, Window};

/// The value as a rational number, exactly.
///
/// # Panics
/// When the value is infinite or not a number.
pub(crate) fn rational(value: f64) -> BigRational {
    BigRational::from_float(value).expect("the oracle takes finite numbers")
}

/// The vertices as rational numbers, exactly.
pub(crate) fn exact(polygon: &[Position]) -> Vec<Exact> {
    polygon.iter().map(|p| p.map(|c| rational(f64::from(c)))).collect()
}

/// A half space from small whole coefficients.
pub(crate) fn plane(coefficients: [i32; 4]) -> Plane {
    coefficients.map(|c| BigRational::from_integer(c.into()))
}

/// The near plane, the far plane, and w >= 0, which only a depth convention with more room would
/// need.
pub(crate) fn depth_planes(depth: Depth) -> [Plane; 3] {
    let near = match depth {
        Depth::ZeroToOne => [0, 0, 1, 0],
        Depth::MinusOneToOne => [0, 0, 1, 1],
    };
    [near, [0, 0, -1, 1], [0, 0, 0, 1]].map(plane)
}

/// The four sides of the viewport, moved outwards by `guard` pixels: screen x from -guard to
/// width + guard, and so for y.
pub(crate) fn guard_planes(window: Window, guard: f64) -> [Plane; 4] {
    // (x/w + 1) width/2 >= -guard  <=>  x + (1 + 2 guard/width) w >= 0; the other side mirrors it.
    let reach = |size: u32| BigRational::one() + rational(2.0 * guard) / rational(f64::from(size));
    let (x, y) = (reach(window.width), reach(window.height));
    let mut planes = [[1, 0, 0, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, -1, 0, 0]].map(plane);
    planes.iter_mut().zip([&x, &x, &y, &y]).for_each(|(plane, reach)| plane[3] = reach.clone());
    planes
}

/// The part of the polygon inside every plane, by Sutherland and Hodgman.
///
/// An outline that is not convex may fall into parts; they stay joined by edges that run to and fro
/// along the plane, which no winding number sees. Rounded to the screen such a pair may part by
/// 1/256 pixel, unless the plane is a side of the guard band: see [`border`].
pub(crate) fn clip(polygon: &[Exact], planes: &[Plane]) -> Vec<Exact> {
    planes.iter().fold(polygon.to_vec(), |polygon, plane| clip_by(&polygon, plane))
}

fn clip_by(polygon: &[Exact], plane: &Plane) -> Vec<Exact> {
    let side: Vec<BigRational> = polygon.iter().map(|p| dot(plane, p)).collect();
    let mut clipped = Vec::new();
    for i in 0..polygon.len() {
        let j = (i + 1) % polygon.len();
        if side[i] >= BigRational::zero() {
            clipped.push(polygon[i].clone());
        }
        if (side[i] >= BigRational::zero()) != (side[j] >= BigRational::zero()) {
            let t = &side[i] / (&side[i] - &side[j]);
            clipped.push(from_fn(|k| &polygon[i][k] + (&polygon[j][k] - &polygon[i][k]) * &t));
        }
    }
    clipped
}

pub(super) fn dot(plane: &Plane, p: &Exact) -> BigRational {
    let terms = plane.iter().zip(p).filter(|(coefficient, _)| !coefficient.is_zero());
    terms.fold(BigRational::zero(), |sum, (coefficient, c)| sum + coefficient * c)
}

/// What is left of the polygon between near and far plane and inside the guard band, with w > 0
/// everywhere.
///
/// The sides of the viewport itself cut nothing. A vertex that survives with w = 0 is the eye
/// itself (the guard band drops all others); its two edges project to points, so it leaves without
/// a trace.
pub(crate) fn clip_to_view(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<Exact> {
    clip_exact_to_view(&exact(polygon), window, depth, guard)
}

fn clip_exact_to_view(polygon: &[Exact], window: Window, depth: Depth, guard: f64) -> Vec<Exact> {
    let clipped = clip(&clip(polygon, &depth_planes(depth)), &guard_planes(window, guard));
    clipped.into_iter().filter(|p| !p[3].is_zero()).collect()
}
