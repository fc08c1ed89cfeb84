//! Polygons that are exactly planar, with exactly affine parameters.

use std::array::from_fn;
use std::f64::consts::TAU;

use num_integer::Integer;

use super::Shape;
use super::places::{at_ndc, on_circle};
use super::rng::Rng;
use crate::common::oracle::Position;

/// A triangle with w from exactly 1 to exactly `w_ratio` and vertices within `reach` of the middle
/// of the screen, in normalized device coordinates (1 is the viewport's border). Parameters are of
/// -1..1.
pub(crate) fn random_triangle<const N: usize>(rng: &mut Rng, w_ratio: f64, reach: f64) -> Shape<N> {
    let mut w = [1.0, w_ratio, rng.octaves(1.0, w_ratio)];
    rng.shuffle(&mut w);
    let positions = w.map(|w| at_ndc(from_fn(|_| rng.range(-reach, reach)), w)).to_vec();
    let parameters = (0..3).map(|_| from_fn(|_| rng.range(-1.0, 1.0) as f32)).collect();
    Shape { positions, parameters }
}

/// A convex polygon of 3 to 64 sides (above 12 an even number) in a plane of random tilt, with w from about 1 to about
/// `w_ratio` (at most 1000) and vertices within 4 of the middle of the screen, in normalized device
/// coordinates.
///
/// Exactly planar, with exactly affine parameters, in f32: see [`Frame`].
pub(crate) fn random_convex<const N: usize>(rng: &mut Rng, sides: usize, w_ratio: f64) -> Shape<N> {
    loop {
        let disc = round_polygon(rng, sides);
        let frame = tilted_frame(rng, &disc, 1.0, w_ratio);
        let on_screen = |p: &Position| p[0].abs() <= 4.0 * p[3] && p[1].abs() <= 4.0 * p[3];
        let shape = frame.shape(rng, &disc).filter(|shape| shape.positions.iter().all(on_screen));
        if let Some(shape) = shape {
            return shape;
        }
    }
}

/// A convex polygon through the plane w = 0: some vertices have w > 0, the others w < 0 or
/// sometimes w = 0. Exactly planar with affine parameters. In one of two z = w/2, so that the near
/// plane is w = 0 itself.
pub(crate) fn through_eye<const N: usize>(rng: &mut Rng, sides: usize) -> Shape<N> {
    loop {
        let disc = round_polygon(rng, sides);
        let behind = if rng.once_in(3) { 0.0 } else { -rng.octaves(0.1, 8.0) };
        let ahead = rng.octaves(0.5, 8.0);
        let mut frame = tilted_frame(rng, &disc, behind, ahead);
        if rng.once_in(2) {
            frame.near = 0.0;
        }
        let both_sides = |shape: &Shape<N>| {
            let is_ahead = |p: &Position| p[3] > 0.0;
            shape.positions.iter().any(is_ahead) && !shape.positions.iter().all(is_ahead)
        };
        if let Some(shape) = frame.shape(rng, &disc).filter(both_sides) {
            return shape;
        }
    }
}

/// A convex polygon seen nearly from the side: its plane passes by the eye, and it is about twice
/// `tilt` thick on the screen, in normalized device coordinates. Exactly planar with affine
/// parameters, so a tilt below 1/16384 becomes 0, and the plane then runs through the eye.
pub(crate) fn edge_on<const N: usize>(rng: &mut Rng, sides: usize, tilt: f64) -> Shape<N> {
    let disc = round_polygon(rng, sides);
    let scale = 256.0;
    let angle = rng.range(0.0, TAU);
    let even = |c: f64| (c * 32.0).round() / 32.0;
    // Half of the origin has to be as exact as the origin, or the rounding would tilt the plane.
    let origin = [even(scale * rng.range(-0.6, 0.6)), even(scale * rng.range(-0.6, 0.6)), scale];
    let along =
        [scale * 0.4 * angle.cos(), scale * 0.4 * angle.sin(), scale * rng.range(-0.3, 0.3)];
    let aside = [-angle.sin(), angle.cos(), 0.0].map(|c| c * tilt * scale);
    let frame =
        Frame { origin, along, across: from_fn(|k| origin[k] / 2.0 + aside[k]), scale, near: 0.5 };
    frame.shape(rng, &disc).expect("coordinates of at most 512")
}

/// A plane in clip space: the point (s, t) of the unit disc lies at (x, y, w) = origin + s along +
/// t across.
///
/// s, t, `along` and `across` are rounded to multiples of 1/64 and `origin` to multiples of 1/4096,
/// so positions are multiples of 2^-12. Below 2^12 these fit the 24 bits of an f32 exactly, and the
/// polygon is planar to the bit. Dividing by `scale`, a power of two, costs no bits. z = (w - near
/// scale) / 2 has its last bit one place further down, but w is at most 2^10.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    origin: [f64; 3],
    along: [f64; 3],
    across: [f64; 3],
    scale: f64,
    near: f64,
}

impl Frame {
    /// The polygon over the disc's, with random parameters affine in s and t. `None` when it
    /// exceeds the bits.
    pub(super) fn shape<const N: usize>(
        &self,
        rng: &mut Rng,
        disc: &[[f64; 2]],
    ) -> Option<Shape<N>> {
        let origin = self.origin.map(to_4096ths);
        let [along, across] = [self.along, self.across].map(|v| v.map(to_64ths));
        // Eight bits each, times the seven of s and t: exact as well.
        let planes: [[f64; 3]; N] = from_fn(|_| from_fn(|_| rng.whole(-128, 127) as f64 / 256.0));
        let position = |[s, t]: [f64; 2]| {
            let [x, y, w] = from_fn(|k| origin[k] + s * along[k] + t * across[k]);
            [x, y, (w - self.near * self.scale) / 2.0, w].map(|c| c / self.scale)
        };
        let fits = |c: f64| f64::from(c as f32) == c;
        let positions: Vec<[f64; 4]> = disc.iter().map(|&p| position(p)).collect();
        positions.iter().flatten().all(|&c| fits(c)).then(|| Shape {
            positions: positions.iter().map(|p| p.map(|c| c as f32)).collect(),
            parameters: disc
                .iter()
                .map(|[s, t]| planes.map(|[r, ds, dt]| (r + s * ds + t * dt) as f32))
                .collect(),
        })
    }
}

/// A frame in which w runs over the disc's polygon from `least` to `most`, times a power of two
/// that fills the bits, and three of the vertices appear at random places of the screen when their
/// w is positive.
pub(super) fn tilted_frame(rng: &mut Rng, disc: &[[f64; 2]], least: f64, most: f64) -> Frame {
    let scale = (1024.0 / most.max(-least)).log2().floor().exp2();
    let direction = on_circle([0.0; 2], 1.0, rng.range(0.0, TAU));
    let height = |p: [f64; 2]| p[0] * direction[0] + p[1] * direction[1];
    let by_height = |i: &usize, j: &usize| height(disc[*i]).total_cmp(&height(disc[*j]));
    let low = (0..disc.len()).min_by(by_height).unwrap_or(0);
    let high = (0..disc.len()).max_by(by_height).unwrap_or(0);
    let area = |i: usize| doubled_area(disc[low], disc[high], disc[i]);
    let aside =
        (0..disc.len()).max_by(|&i, &j| area(i).abs().total_cmp(&area(j).abs())).unwrap_or(0);

    let slope = scale * (most - least) / (height(disc[high]) - height(disc[low]));
    let w_at = |i: usize| scale * least + slope * (height(disc[i]) - height(disc[low]));
    let triple = [low, high, aside];
    // Without a screen place to go by (w <= 0) the place is measured at w = 1.
    let reach = triple.map(|i| if w_at(i) > 0.0 { w_at(i) } else { scale });
    let places = [disc[low], disc[high], disc[aside]];
    let x = affine(places, reach.map(|w| w * rng.range(-1.0, 1.0)));
    let y = affine(places, reach.map(|w| w * rng.range(-1.0, 1.0)));
    let w = affine(places, triple.map(w_at));
    let [origin, along, across] = from_fn(|k| [x[k], y[k], w[k]]);
    Frame { origin, along, across, scale, near: 0.5 }
}

/// The coefficients [c, ds, dt] of the function c + s ds + t dt with the given values at three
/// points, rounded as [`Frame`] wants them: exactly the first value, if that is a multiple of
/// 1/4096, and nearly the others.
fn affine(points: [[f64; 2]; 3], values: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = points;
    let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let (to_b, to_c) = (values[1] - values[0], values[2] - values[0]);
    let area = doubled_area(a, b, c);
    let ds = to_64ths((to_b * ac[1] - to_c * ab[1]) / area);
    let dt = to_64ths((to_c * ab[0] - to_b * ac[0]) / area);
    [to_4096ths(values[0] - a[0] * ds - a[1] * dt), ds, dt]
}

fn doubled_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// A strictly convex polygon of 3 to 12 vertices near the unit circle, or of an even number up to
/// 64 inside it, at multiples of 1/64, in either direction.
fn round_polygon(rng: &mut Rng, sides: usize) -> Vec<[f64; 2]> {
    if sides > 12 {
        return zonogon(rng, sides);
    }
    // Angles are off by a quarter of the regular gap at most, so two sides differ by half a gap: 15
    // degrees of 12 sides stand 0.03 above the chord, twice what rounding can take.
    assert!((3..=12).contains(&sides), "with more sides rounding to 1/64 would dent the polygon");
    let gap = TAU / sides as f64;
    let turn = rng.range(0.0, gap);
    let angle = |rng: &mut Rng, i: usize| turn + gap * (i as f64 + rng.range(-0.25, 0.25));
    let mut disc: Vec<[f64; 2]> =
        (0..sides).map(|i| on_circle([0.0; 2], 1.0, angle(rng, i)).map(to_64ths)).collect();
    if rng.once_in(2) {
        disc.reverse();
    }
    disc
}

/// A strictly convex polygon of an even number of sides up to 64, with vertices at multiples of
/// 1/64 inside the unit circle: the sum of half as many segments, no two of which are parallel.
fn zonogon(rng: &mut Rng, sides: usize) -> Vec<[f64; 2]> {
    // One of each pair of opposite directions: 40 of them.
    let directions = (-5..=5).flat_map(|x: i64| (0..=5).map(move |y: i64| (x, y)));
    let is_primitive = |&(x, y): &(i64, i64)| x.gcd(&y) == 1 && (y > 0 || x > 0);
    let mut segments: Vec<_> = directions.filter(is_primitive).collect();
    assert!(sides.is_multiple_of(2) && sides <= 2 * segments.len(), "{sides} sides");
    rng.shuffle(&mut segments);
    segments.truncate(sides / 2);
    segments.sort_by(|a, b| (b.0 * a.1).cmp(&(a.0 * b.1)));
    let opposite: Vec<_> = segments.iter().map(|&(x, y)| (-x, -y)).collect();
    // Begin so that the middle is at the origin, up to half a unit.
    let sum = segments.iter().fold((0, 0), |sum, s| (sum.0 + s.0, sum.1 + s.1));
    let mut at = (-sum.0 / 2, -sum.1 / 2);
    let mut polygon = Vec::new();
    for (x, y) in segments.into_iter().chain(opposite) {
        polygon.push([at.0 as f64 / 64.0, at.1 as f64 / 64.0]);
        at = (at.0 + x, at.1 + y);
    }
    if rng.once_in(2) {
        polygon.reverse();
    }
    polygon
}

fn to_4096ths(value: f64) -> f64 {
    (value * 4096.0).round() / 4096.0
}

pub(super) fn to_64ths(value: f64) -> f64 {
    (value * 64.0).round() / 64.0
}
