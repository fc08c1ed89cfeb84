//! Concave and crossed outlines, and such of several contours.

use std::f64::consts::TAU;

use super::places::{at_pixels, middle, on_circle, size};
use super::planar::{tilted_frame, to_64ths};
use super::rng::Rng;
use crate::common::oracle::{Position, Window};

/// A star of `points` points inside the viewport: concave, its edges do not cross. Its w is of 1..4
/// at random, so it has no plane: for coverage only.
pub(crate) fn star(rng: &mut Rng, window: Window, points: usize) -> Vec<Position> {
    let radius = size(window)[0].min(size(window)[1]) * rng.range(0.3, 0.49);
    let inner = radius * rng.range(0.2, 0.6);
    let (gap, turn) = (TAU / (2 * points) as f64, rng.range(0.0, TAU));
    let corner = |i: usize| {
        on_circle(
            middle(window),
            if i.is_multiple_of(2) { radius } else { inner },
            turn + gap * i as f64,
        )
    };
    at_pixels(rng, &(0..2 * points).map(corner).collect::<Vec<_>>(), 4.0, window)
}

/// A star drawn in one stroke, joining every `step`-th of `points` places on a circle: its edges
/// cross, and it winds `step` times around its middle. For coverage only.
pub(crate) fn crossed_star(
    rng: &mut Rng,
    window: Window,
    points: usize,
    step: usize,
) -> Vec<Position> {
    let radius = size(window)[0].min(size(window)[1]) * rng.range(0.3, 0.49);
    let turn = rng.range(0.0, TAU);
    let corner = |i: usize| {
        on_circle(middle(window), radius, turn + TAU * (i * step) as f64 / points as f64)
    };
    at_pixels(rng, &(0..points).map(corner).collect::<Vec<_>>(), 4.0, window)
}

/// `vertices` places on the grid of half pixels joined in random order: crossings, overlaps, edges
/// through pixel centres. For coverage only.
pub(crate) fn tangle(rng: &mut Rng, window: Window, vertices: usize) -> Vec<Position> {
    let mut halves = |size: u32| rng.whole(0, 2 * i64::from(size)) as f64 / 2.0;
    let places: Vec<_> =
        (0..vertices).map(|_| [halves(window.width), halves(window.height)]).collect();
    at_pixels(rng, &places, 4.0, window)
}

/// The contours of one polygon that lie in one plane, exactly, with exactly affine parameters.
#[derive(Clone, Debug)]
pub(crate) struct Contours<const N: usize> {
    /// The vertices in coordinates of the plane.
    pub(crate) places: Vec<Vec<[f64; 2]>>,
    pub(crate) positions: Vec<Vec<Position>>,
    pub(crate) parameters: Vec<Vec<[f32; N]>>,
}

/// Contours given by places in the unit circle, on a plane of random tilt: see [`Frame`]. w runs
/// from about `least`, which may be negative, to about `most`.
pub(crate) fn tilted<const N: usize>(
    rng: &mut Rng,
    contours: &[Vec<[f64; 2]>],
    least: f64,
    most: f64,
) -> Contours<N> {
    let places: Vec<Vec<_>> =
        contours.iter().map(|contour| contour.iter().map(|p| p.map(to_64ths)).collect()).collect();
    let all = places.concat();
    loop {
        let frame = tilted_frame(rng, &all, least, most);
        let Some(shape) = frame.shape(rng, &all) else { continue };
        let (mut positions, mut parameters) = (&shape.positions[..], &shape.parameters[..]);
        return Contours {
            positions: places.iter().map(|contour| take(&mut positions, contour.len())).collect(),
            parameters: places.iter().map(|contour| take(&mut parameters, contour.len())).collect(),
            places,
        };
    }
}

/// Cuts the first items off a list.
fn take<T: Clone>(list: &mut &[T], count: usize) -> Vec<T> {
    let (first, rest) = list.split_at(count);
    *list = rest;
    first.to_vec()
}

/// A polygon of any shape in the unit circle: a star, a ring, a comb, a spiral, a letter, a tangle,
/// several of each.
pub(crate) fn any_contours(rng: &mut Rng) -> Vec<Vec<[f64; 2]>> {
    let mut contours = match rng.below(8) {
        0 => vec![flat_star(rng)],
        1 => {
            let (points, step) = (5 + 2 * rng.below(4), 2 + rng.below(2));
            let corner =
                |i: usize| on_circle([0.0; 2], 0.9, TAU * (i * step) as f64 / points as f64);
            vec![(0..points).map(corner).collect()]
        }
        2 => ring_contours(rng),
        3 => vec![comb(rng)],
        4 => vec![spiral(rng)],
        5 => letter(rng),
        6 => vec![loose(rng, 24)],
        _ => (0..2 + rng.below(3)).map(|_| loose(rng, 6)).collect(),
    };
    if rng.once_in(4) {
        contours.push(loose(rng, 5));
    }
    let (turn, size) = (rng.range(0.0, TAU), rng.range(0.5, 1.0));
    let (sin, cos) = turn.sin_cos();
    for [s, t] in contours.iter_mut().flatten() {
        (*s, *t) = (size * (*s * cos - *t * sin), size * (*s * sin + *t * cos));
    }
    contours
}

/// Random places joined in random order.
fn loose(rng: &mut Rng, most: usize) -> Vec<[f64; 2]> {
    let place = |rng: &mut Rng| [rng.range(-0.7, 0.7), rng.range(-0.7, 0.7)];
    (0..3 + rng.below(most - 2)).map(|_| place(rng)).collect()
}

fn flat_star(rng: &mut Rng) -> Vec<[f64; 2]> {
    let (points, inner) = (4 + rng.below(9), rng.range(0.2, 0.6));
    let corner = |i: usize| {
        let radius = if i.is_multiple_of(2) { 0.9 } else { inner };
        on_circle([0.0; 2], radius, TAU / (2 * points) as f64 * i as f64)
    };
    (0..2 * points).map(corner).collect()
}

/// A round contour with a hole and sometimes an island in it, the hole in either direction.
fn ring_contours(rng: &mut Rng) -> Vec<Vec<[f64; 2]>> {
    let circle = |rng: &mut Rng, radius: f64| {
        let sides = 3 + rng.below(10);
        let mut circle: Vec<_> = (0..sides)
            .map(|i| on_circle([0.0; 2], radius, TAU * i as f64 / sides as f64))
            .collect();
        if rng.once_in(2) {
            circle.reverse();
        }
        circle
    };
    let radii = [0.95, 0.45, 0.2];
    radii[..2 + rng.below(2)].iter().map(|&radius| circle(rng, radius)).collect()
}

/// A back with teeth: a line across them meets each twice.
pub(crate) fn comb(rng: &mut Rng) -> Vec<[f64; 2]> {
    let teeth = 3 + rng.below(12);
    let pitch = 1.2 / teeth as f64;
    let mut comb = vec![[0.6, -0.6], [-0.6, -0.6]];
    for i in 0..teeth {
        let s = -0.6 + pitch * i as f64;
        let tip = 0.6 + rng.range(-0.2, 0.1);
        comb.extend([[s, tip], [s + pitch * 0.5, tip], [s + pitch * 0.5, -0.3], [s + pitch, -0.3]]);
    }
    comb.pop();
    comb
}

/// A band wound up several times.
fn spiral(rng: &mut Rng) -> Vec<[f64; 2]> {
    let (turns, steps) = (2 + rng.below(3), 9);
    let pitch = 0.8 / turns as f64;
    let all = turns * steps;
    let at = |i: usize, inwards: f64| {
        let radius = 0.95 - pitch * i as f64 / steps as f64 - inwards;
        on_circle([0.0; 2], radius.max(0.0), TAU * i as f64 / steps as f64)
    };
    let outer = (0..=all).map(|i| at(i, 0.0));
    outer.chain((0..=all).rev().map(|i| at(i, 0.5 * pitch))).collect()
}

/// A, B and E, in units of 1/8.
fn letter(rng: &mut Rng) -> Vec<Vec<[f64; 2]>> {
    type Contour = &'static [[i8; 2]];
    const A: [Contour; 2] = [
        &[[-5, -6], [-2, -6], [-1, -3], [1, -3], [2, -6], [5, -6], [1, 6], [-1, 6]],
        &[[-1, -1], [0, 3], [1, -1]],
    ];
    const B: [Contour; 3] = [
        &[[-4, -6], [3, -6], [5, -4], [5, -2], [3, 0], [5, 2], [5, 4], [3, 6], [-4, 6]],
        &[[-2, -4], [-2, -1], [2, -1], [3, -3], [2, -4]],
        &[[-2, 1], [-2, 4], [2, 4], [3, 3], [2, 1]],
    ];
    const E: [Contour; 1] = [&[
        [-4, -6],
        [4, -6],
        [4, -4],
        [-2, -4],
        [-2, -1],
        [2, -1],
        [2, 1],
        [-2, 1],
        [-2, 4],
        [4, 4],
        [4, 6],
        [-4, 6],
    ]];
    let letter: &[Contour] = [&A[..], &B, &E][rng.below(3)];
    let place = |p: &[i8; 2]| p.map(|c| f64::from(c) / 8.0);
    letter.iter().map(|contour| contour.iter().map(place).collect()).collect()
}

/// The corners of the convex hull, by Andrew's monotone chain. Fewer than three when all points lie
/// on one line.
pub(super) fn convex_hull(points: &mut Vec<[i64; 2]>) -> Vec<[i64; 2]> {
    points.sort_unstable();
    points.dedup();
    let mut hull = half_hull(points.iter());
    hull.extend(half_hull(points.iter().rev()));
    hull
}

/// One side of the hull, without its last point, which begins the other side.
fn half_hull<'a>(points: impl Iterator<Item = &'a [i64; 2]>) -> Vec<[i64; 2]> {
    let mut chain: Vec<[i64; 2]> = Vec::new();
    for &p in points {
        let turns = |a: [i64; 2], b: [i64; 2]| {
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0
        };
        while chain.len() >= 2 && !turns(chain[chain.len() - 2], chain[chain.len() - 1]) {
            chain.pop();
        }
        chain.push(p);
    }
    chain.pop();
    chain
}
