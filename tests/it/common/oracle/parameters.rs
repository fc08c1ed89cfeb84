//! The values of a polygon at a point of the screen.

use std::array::from_fn;
use std::ops::Neg;

use num_traits::Num;

use super::clipping::rational;
use super::projection::nearest;
use super::{Depth, Position, Window};

/// What the plane of a polygon holds where the ray through one point of the screen meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample<const N: usize, T = f64> {
    /// The weights of the three vertices. They sum to 1; outside the triangle one is negative.
    pub(crate) barycentric: [T; 3],
    /// w, interpolated as the parameters are. Not positive where the ray meets the plane behind the
    /// eye.
    pub(crate) w: T,
    /// z/w, before the viewport's depth range: see [`window_depth`].
    pub(crate) z_over_w: T,
    /// The parameters.
    pub(crate) values: [T; N],
    /// Their derivatives per pixel to the right.
    pub(crate) dx: [T; N],
    /// Their derivatives per pixel down.
    pub(crate) dy: [T; N],
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
    let size = [window.width, window.height].map(f64::from);
    meet(
        triple.map(|i| polygon[i].map(f64::from)),
        triple.map(|i| parameters[i].map(f64::from)),
        point,
        size,
    )
}

/// The same in rational numbers, rounded to f64 at the very end: the last word.
pub(crate) fn sample_exact<const N: usize>(
    polygon: &[Position],
    parameters: &[[f32; N]],
    triple: [usize; 3],
    window: Window,
    point: [f64; 2],
) -> Option<Sample<N>> {
    let number = |value: f32| rational(f64::from(value));
    let (vertices, values) =
        (triple.map(|i| polygon[i].map(number)), triple.map(|i| parameters[i].map(number)));
    let size = [window.width, window.height].map(|size| rational(f64::from(size)));
    let met = meet(vertices, values, point.map(rational), size)?;
    Some(Sample {
        barycentric: met.barycentric.map(|c| nearest(&c)),
        w: nearest(&met.w),
        z_over_w: nearest(&met.z_over_w),
        values: met.values.map(|c| nearest(&c)),
        dx: met.dx.map(|c| nearest(&c)),
        dy: met.dy.map(|c| nearest(&c)),
    })
}

/// Meets the ray of the screen point with the plane of three vertices.
///
/// The ray is where x = X w and y = Y w, (X, Y) being the point in normalized device coordinates.
/// For every vertex u = x - X w and v = y - Y w say how far it is off the ray. The weights that
/// bring both to 0 at once are orthogonal to (u) and (v), so they are their cross product, up to
/// the scale that makes them sum to 1. Whatever is affine on the plane is the mean under these
/// weights. One pixel to the right X grows by 2/width, one pixel down Y shrinks by 2/height: the
/// derivatives follow by the product rule in the weights and the quotient rule in the mean.
fn meet<T: Num + Clone + Neg<Output = T>, const N: usize>(
    vertices: [[T; 4]; 3],
    parameters: [[T; N]; 3],
    point: [T; 2],
    size: [T; 2],
) -> Option<Sample<N, T>> {
    let [x, y, z, w]: [[T; 3]; 4] = from_fn(|k| from_fn(|i| vertices[i][k].clone()));
    let two = || T::one() + T::one();
    let [pixel_x, pixel_y] = size.map(|size| two() / size);
    let [point_x, point_y] = point;
    let (ray_x, ray_y) =
        (pixel_x.clone() * point_x - T::one(), T::one() - pixel_y.clone() * point_y);

    let u = from_fn(|i| x[i].clone() - ray_x.clone() * w[i].clone());
    let v = from_fn(|i| y[i].clone() - ray_y.clone() * w[i].clone());
    let weights = cross(&u, &v);
    let weights_dx = cross(&w.clone().map(|w| -(pixel_x.clone() * w)), &v);
    let weights_dy = cross(&u, &w.clone().map(|w| pixel_y.clone() * w));

    let total = sum(&weights);
    let w_total = mix(&weights, &w);
    if total.is_zero() || w_total.is_zero() {
        return None;
    }
    let per_parameter: [[T; 3]; N] = from_fn(|n| from_fn(|i| parameters[i][n].clone()));
    let values: [T; N] = from_fn(|n| mix(&weights, &per_parameter[n]) / total.clone());
    let derivative = |change: &[T; 3]| {
        from_fn(|n| {
            (mix(change, &per_parameter[n]) - values[n].clone() * sum(change)) / total.clone()
        })
    };
    Some(Sample {
        dx: derivative(&weights_dx),
        dy: derivative(&weights_dy),
        w: w_total.clone() / total.clone(),
        z_over_w: mix(&weights, &z) / w_total,
        barycentric: weights.map(|weight| weight / total.clone()),
        values,
    })
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
