//! The values of a polygon at a point of the screen.

use std::array::from_fn;
use std::ops::Neg;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Num, One};

use super::clipping::rational;
use super::projection::nearest;
use super::{Depth, Position, Window};

/// What the plane of a polygon holds where the ray through one point of the screen meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample<const N: usize> {
    /// The weights of the three vertices. They sum to 1; outside the triangle one is negative.
    pub(crate) barycentric: [f64; 3],
    /// w, interpolated as the parameters are. Not positive where the ray meets the plane behind the
    /// eye.
    pub(crate) w: f64,
    /// z/w, before the viewport's depth range: see [`window_depth`].
    pub(crate) z_over_w: f64,
    /// The parameters.
    pub(crate) values: [f64; N],
    /// Their derivatives per pixel to the right.
    pub(crate) dx: [f64; N],
    /// Their derivatives per pixel down.
    pub(crate) dy: [f64; N],
}

impl<const N: usize> Sample<N> {
    /// Whether the point lies in the triangle of the three vertices, in front of the eye, borders
    /// included.
    pub(crate) fn is_inside(&self) -> bool {
        self.w > 0.0 && self.barycentric.iter().all(|&weight| weight >= 0.0)
    }
}

/// Three vertices that span the polygon's plane well: of nearly the largest triangle in (x, y, w).
/// All triangles of a plane have the same normal, so the largest suffers least from rounding.
/// `None` when the vertices lie on one line.
pub(crate) fn best_triple(polygon: &[Position]) -> Option<[usize; 3]> {
    let from =
        |i: usize, j: usize| [0, 1, 3].map(|k| f64::from(polygon[j][k]) - f64::from(polygon[i][k]));
    let length = |v: [f64; 3]| v[0].hypot(v[1]).hypot(v[2]);
    let farthest = |measure: &dyn Fn(usize) -> f64| {
        let most = (0..polygon.len()).max_by(|&i, &j| measure(i).total_cmp(&measure(j)));
        most.filter(|&i| measure(i) > 0.0)
    };
    let a = farthest(&|i| length(from(0, i)))?;
    let b = farthest(&|i| length(from(a, i)))?;
    let c = farthest(&|i| length(cross(&from(a, b), &from(a, i))))?;
    Some([a, b, c])
}

/// The polygon's plane, through the vertices `triple`, at a point of the screen in pixels (x right,
/// y down), in f64.
///
/// `None` when the plane runs through the eye, or when the ray runs along it or meets it at w = 0.
pub(crate) fn sample<const N: usize>(
    polygon: &[Position],
    parameters: &[[f32; N]],
    triple: [usize; 3],
    window: Window,
    point: [f64; 2],
) -> Option<Sample<N>> {
    let met = meet(
        triple.map(|i| polygon[i].map(f64::from)),
        triple.map(|i| parameters[i].map(f64::from)),
        [point, [window.width, window.height].map(f64::from)],
        1.0,
    )?;
    let total = met.total;
    Some(Sample {
        barycentric: met.weights.map(|weight| weight / total),
        w: met.w / total,
        z_over_w: met.z / met.w,
        values: met.values.map(|value| value / total),
        dx: met.dx.map(|change| change / (total * total)),
        dy: met.dy.map(|change| change / (total * total)),
    })
}

/// The same in rational numbers, rounded to f64 at the very end: the last word.
pub(crate) fn sample_exact<const N: usize>(
    polygon: &[Position],
    parameters: &[[f32; N]],
    triple: [usize; 3],
    window: Window,
    point: [f64; 2],
) -> Option<Sample<N>> {
    let (vertices, unit) = whole(triple.map(|i| polygon[i]).map(|p| p.map(f64::from)));
    let (parameters, unit_of_values) = whole(triple.map(|i| parameters[i].map(f64::from)));
    let (screen, pixel) = whole([point, [window.width, window.height].map(f64::from)]);
    let met = meet(vertices, parameters, screen, pixel)?;
    // Not reduced, which would take longer than all the rest.
    let ratio = |a: &BigInt, b: &BigInt| nearest(&BigRational::new_raw(a.clone(), b.clone()));
    let of_values = &met.total * unit_of_values;
    let of_changes = &met.total * &of_values;
    Some(Sample {
        barycentric: met.weights.map(|weight| ratio(&weight, &met.total)),
        w: ratio(&met.w, &(&met.total * unit)),
        z_over_w: ratio(&met.z, &met.w),
        values: met.values.map(|value| ratio(&value, &of_values)),
        dx: met.dx.map(|change| ratio(&change, &of_changes)),
        dy: met.dy.map(|change| ratio(&change, &of_changes)),
    })
}

/// Whole numbers in the proportions of some values, and the one that stands for 1.
fn whole<const A: usize, const B: usize>(values: [[f64; A]; B]) -> ([[BigInt; A]; B], BigInt) {
    let exact = values.map(|values| values.map(rational));
    // All denominators are powers of two, and divide the largest.
    let largest = exact.as_flattened().iter().map(BigRational::denom).max();
    let unit = largest.cloned().unwrap_or_else(BigInt::one);
    (exact.map(|values| values.map(|value| (value * &unit).to_integer())), unit)
}

/// What the plane of three vertices holds on a ray, as numerators, so that whole numbers remain whole.
struct Met<const N: usize, T> {
    /// Over `total`: the barycentric coordinates.
    weights: [T; 3],
    total: T,
    /// Over `total`.
    w: T,
    /// Over `w`.
    z: T,
    /// Over `total`.
    values: [T; N],
    /// Over the square of `total`.
    dx: [T; N],
    dy: [T; N],
}

/// Meets the ray of a point of the screen with the plane of three vertices. `screen` is the point and the
/// screen's size, and `pixel` a pixel's length, in any one unit.
///
/// The ray is where x = X w and y = Y w, (X, Y) being the point in normalized device coordinates:
/// X = 2 px / width - 1 and Y = 1 - 2 py / height.
/// For every vertex u = (x - X w) width and v = (y - Y w) height say how far it is off the ray. The
/// weights that bring both to 0 at once are orthogonal to (u) and (v), so they are their cross product, up
/// to the scale that makes them sum to 1. Whatever is affine on the plane is the mean under these
/// weights. One pixel to the right u shrinks by 2 w, one pixel down v grows by 2 w: the
/// derivatives follow by the product rule in the weights and the quotient rule in the mean.
fn meet<T: Num + Clone + Neg<Output = T>, const N: usize>(
    vertices: [[T; 4]; 3],
    parameters: [[T; N]; 3],
    [point, size]: [[T; 2]; 2],
    pixel: T,
) -> Option<Met<N, T>> {
    let [x, y, z, w]: [[T; 3]; 4] = from_fn(|k| from_fn(|i| vertices[i][k].clone()));
    let twice = |value: T| value.clone() + value;
    let [point_x, point_y] = point.map(twice);
    let [width, height] = size;
    let (ray_x, ray_y) = (point_x - width.clone(), height.clone() - point_y);
    let u = from_fn(|i| x[i].clone() * width.clone() - ray_x.clone() * w[i].clone());
    let v = from_fn(|i| y[i].clone() * height.clone() - ray_y.clone() * w[i].clone());
    let weights = cross(&u, &v);
    let change = w.clone().map(|w| twice(pixel.clone() * w));
    let weights_dx = cross(&change.clone().map(|change| -change), &v);
    let weights_dy = cross(&u, &change);

    let total = sum(&weights);
    let w = mix(&weights, &w);
    if total.is_zero() || w.is_zero() {
        return None;
    }
    let per_parameter: [[T; 3]; N] = from_fn(|n| from_fn(|i| parameters[i][n].clone()));
    let values: [T; N] = from_fn(|n| mix(&weights, &per_parameter[n]));
    let derivative = |change: &[T; 3]| {
        from_fn(|n| {
            mix(change, &per_parameter[n]) * total.clone() - values[n].clone() * sum(change)
        })
    };
    let (dx, dy) = (derivative(&weights_dx), derivative(&weights_dy));
    Some(Met { w, z: mix(&weights, &z), weights, total, values, dx, dy })
}

pub(super) fn cross<T: Num + Clone>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j].clone() * b[k].clone() - a[k].clone() * b[j].clone()
    })
}

fn mix<T: Num + Clone>(weights: &[T; 3], values: &[T; 3]) -> T {
    sum(&from_fn(|i| weights[i].clone() * values[i].clone()))
}

fn sum<T: Num + Clone>(terms: &[T; 3]) -> T {
    terms[0].clone() + terms[1].clone() + terms[2].clone()
}

/// Depth in the framebuffer: z/w brought to 0..1 by the depth convention, then to the viewport's
/// depth range.
pub(crate) fn window_depth(z_over_w: f64, depth: Depth, range: [f32; 2]) -> f64 {
    let [near, far] = range.map(f64::from);
    let unit = match depth {
        Depth::ZeroToOne => z_over_w,
        Depth::MinusOneToOne => (z_over_w + 1.0) / 2.0,
    };
    near + unit * (far - near)
}
