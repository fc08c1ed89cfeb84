//! Polygons and meshes to test with, from a seeded generator: a seed names the same shapes in every
//! run. (Between platforms the last bits of a place may differ, as their sines and logarithms do.)
//!
//! Vertices are given in clip space. Where a shape is meant for a place on the screen, its places
//! are pixels of a window, y down, as in the oracle. Unless said otherwise w is at least about 1
//! and z = w/2 - 1/4, so that nothing is cut by the near or the far plane of either depth
//! convention.

mod rng;
mod places;
mod planar;
mod difficult;
mod outlines;
mod meshes;

use super::oracle::{Position, Window};

pub(crate) use difficult::{far_outside, integer_triangle, on_pixel_centres, sliver, surrounding};
pub(crate) use meshes::{cut_grid, fan, floor, jittered_grid, split_quad, whole_grid};
pub(crate) use outlines::{Contours, any_contours, comb, crossed_star, star, tangle, tilted};
pub(crate) use places::at_pixel;
pub(crate) use planar::{edge_on, random_convex, random_triangle, through_eye};
pub(crate) use rng::Rng;

/// A polygon with N parameters at each vertex.
#[derive(Clone, Debug)]
pub(crate) struct Shape<const N: usize> {
    pub(crate) positions: Vec<Position>,
    pub(crate) parameters: Vec<[f32; N]>,
}

/// Faces that share vertices.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Position>,
    /// For each face its vertices, in either direction, beginning anywhere.
    pub(crate) faces: Vec<Vec<usize>>,
}

impl Mesh {
    /// The faces as polygons.
    pub(crate) fn polygons(&self) -> Vec<Vec<Position>> {
        self.faces.iter().map(|face| face.iter().map(|&i| self.positions[i]).collect()).collect()
    }
}

/// A polygon of one of seven kinds: stars, tangles, slivers, centres of pixels, through the eye, and by any other
/// number triangles.
pub(crate) fn of_kind(rng: &mut Rng, kind: usize, window: Window, sides: usize) -> Vec<Position> {
    match kind {
        0 => star(rng, window, sides),
        1 => crossed_star(rng, window, 2 * sides + 1, 2),
        2 => tangle(rng, window, sides),
        3 => sliver(rng, window, 0.3, 10.0),
        4 => on_pixel_centres(rng, window, sides),
        5 => through_eye::<0>(rng, sides).positions,
        _ => random_triangle::<0>(rng, 20.0, 1.5).positions,
    }
}

/// What the cells of a grid become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cells {
    /// Two triangles, along either diagonal.
    Triangles,
    /// One quad.
    Quads,
    /// Now one, now the other.
    Mixed,
}

/// Numbers that break things.
const ODD: [f32; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-45,
    -1e-45,
    1e-20,
    1e10,
    -1e10,
    1e20,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    0.5,
    65536.0,
    f32::EPSILON,
];

/// A number: odd or of any bits, each once in `oddness` times, or usual.
pub(crate) fn number(rng: &mut Rng, oddness: usize) -> f32 {
    match rng.below(oddness) {
        0 => ODD[rng.below(ODD.len())],
        1 => f32::from_bits(rng.bits() as u32),
        _ => rng.range(-2.0, 2.0) as f32,
    }
}
