//! Polygons that are hard to draw right.

use std::array::from_fn;
use std::f64::consts::TAU;

use super::outlines::convex_hull;
use super::places::{at_pixel, at_pixels, half_diagonal, middle, on_circle, somewhere};
use super::rng::Rng;
use crate::common::oracle::{Position, Window};

/// A triangle along a random line of the viewport, `thickness` pixels wide, with w of 1..`w_ratio`.
pub(crate) fn sliver(rng: &mut Rng, window: Window, thickness: f64, w_ratio: f64) -> Vec<Position> {
    let (a, b) = (somewhere(rng, window), somewhere(rng, window));
    let t = rng.range(0.0, 1.0);
    let length = (b[0] - a[0]).hypot(b[1] - a[1]).max(1.0);
    let off = [-(b[1] - a[1]), b[0] - a[0]].map(|c| c * thickness / length);
    let c = from_fn(|k| a[k] + t * (b[k] - a[k]) + off[k]);
    at_pixels(rng, &[a, b, c], w_ratio, window)
}

/// A convex polygon of 3 to `most` vertices, each exactly on a pixel centre once rounded to 1/256
/// pixel, with w a power of two.
pub(crate) fn on_pixel_centres(rng: &mut Rng, window: Window, most: usize) -> Vec<Position> {
    loop {
        let mut pixel = |size: u32| rng.whole(0, i64::from(size) - 1);
        let mut points: Vec<_> =
            (0..most).map(|_| [pixel(window.width), pixel(window.height)]).collect();
        let mut hull = convex_hull(&mut points);
        if hull.len() < 3 {
            continue;
        }
        if rng.once_in(2) {
            hull.reverse();
        }
        let vertex = |p: [i64; 2]| {
            at_pixel(p.map(|c| c as f64 + 0.5), (rng.whole(0, 8) as f64).exp2(), window)
        };
        return hull.into_iter().map(vertex).collect();
    }
}

/// A triangle with vertices a quarter of `pixels` to `pixels` away and one edge through the viewport.
pub(crate) fn far_outside(
    rng: &mut Rng,
    window: Window,
    pixels: f64,
    w_ratio: f64,
) -> Vec<Position> {
    let (through, angle) = (somewhere(rng, window), rng.range(0.0, TAU));
    let mut leg = |turn: f64| on_circle(through, rng.range(pixels / 4.0, pixels), angle + turn);
    let places = [leg(0.0), leg(TAU / 2.0), leg(TAU / 4.0)];
    at_pixels(rng, &places, w_ratio, window)
}

/// A convex polygon around the whole viewport, `pixels` further out than it needs to be, with w of
/// 1..`w_ratio`: each vertex has its own, so from four sides on it has no plane and serves coverage
/// only.
pub(crate) fn surrounding(
    rng: &mut Rng,
    window: Window,
    sides: usize,
    pixels: f64,
    w_ratio: f64,
) -> Vec<Position> {
    let places = ring(rng, window, sides, pixels);
    at_pixels(rng, &places, w_ratio, window)
}

/// A regular polygon around the viewport, in screen places.
pub(super) fn ring(rng: &mut Rng, window: Window, sides: usize, pixels: f64) -> Vec<[f64; 2]> {
    let gap = TAU / sides as f64;
    let turn = rng.range(0.0, gap);
    // The middles of the sides are cos(gap / 2) times as far out as the corners.
    let radius = half_diagonal(window) / (gap / 2.0).cos() + pixels + 1.0;
    (0..sides).map(|i| on_circle(middle(window), radius, turn + gap * i as f64)).collect()
}

/// A triangle with all coordinates whole and of -3..=3: equal vertices, edges through the eye,
/// planes touched exactly.
pub(crate) fn integer_triangle(rng: &mut Rng) -> Vec<Position> {
    (0..3).map(|_| from_fn(|_| rng.whole(-3, 3) as f32)).collect()
}
