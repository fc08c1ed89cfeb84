//! Faces that share vertices.

use std::array::from_fn;
use std::f64::consts::TAU;

use super::difficult::ring;
use super::places::{at_pixel, half_diagonal, middle, on_circle, size, somewhere};
use super::rng::Rng;
use super::{Cells, Mesh};
use crate::common::oracle::{Position, Window};

/// A grid of cells over the viewport and `margin` pixels around, so that each pixel is covered
/// once. Inner vertices are moved by up to a fifth of a cell, which leaves all cells convex; in
/// cells of more than 16 pixels one in four sits on a pixel centre. w is of 1..`w_ratio`, for each
/// vertex its own: quads have no plane and serve coverage only.
pub(crate) fn jittered_grid(
    rng: &mut Rng,
    window: Window,
    [columns, rows]: [usize; 2],
    cells: Cells,
    w_ratio: f64,
    margin: f64,
) -> Mesh {
    let [width, height] = size(window).map(|size| size + 2.0 * margin);
    let cell = [width / columns as f64, height / rows as f64];
    let mut positions = Vec::new();
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let mut place = [column as f64 * cell[0] - margin, row as f64 * cell[1] - margin];
        let mut w = rng.octaves(1.0, w_ratio);
        if (1..columns).contains(&column) && (1..rows).contains(&row) {
            place = from_fn(|k| place[k] + cell[k] * rng.range(-0.2, 0.2));
            if cell[0].min(cell[1]) > 16.0 && rng.once_in(4) {
                place = place.map(|c| c.floor() + 0.5);
                w = w.log2().floor().exp2();
            }
        }
        positions.push(at_pixel(place, w, window));
    }
    Mesh { positions, faces: grid_faces(rng, columns, rows, cells) }
}

/// The same, but z of each vertex is of -0.3 w..1.3 w: the near and the far plane cut many cells,
/// and a pixel is covered at most once.
pub(crate) fn cut_grid(
    rng: &mut Rng,
    window: Window,
    counts: [usize; 2],
    cells: Cells,
    w_ratio: f64,
) -> Mesh {
    let mut mesh = jittered_grid(rng, window, counts, cells, w_ratio, 8.0);
    for p in &mut mesh.positions {
        p[2] = p[3] * rng.range(-0.3, 1.3) as f32;
    }
    mesh
}

/// A level floor seen in perspective, from behind the eye (w = -2) to far away (w = `far`), 4 wide
/// to either side and 1 below the eye. z = w - 1/4, so that the near plane is at w = 1/4 when depth
/// begins at 0. A pixel is covered at most once.
pub(crate) fn floor(rng: &mut Rng, [columns, rows]: [usize; 2], cells: Cells, far: f64) -> Mesh {
    let cell = [8.0 / columns as f64, (far + 2.0) / rows as f64];
    let mut positions = Vec::new();
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let jitter = if rng.once_in(2) { 0.0 } else { 0.2 };
        let [x, w] = [(column, -4.0, cell[0]), (row, -2.0, cell[1])]
            .map(|(i, start, cell)| start + cell * (i as f64 + rng.range(-jitter, jitter)));
        let w = w as f32;
        positions.push([x as f32, -1.0, w - 0.25, w]);
    }
    Mesh { positions, faces: grid_faces(rng, columns, rows, cells) }
}

/// A planar grid: the vertex of row j and column i is origin + i along + j across, all in clip space
/// and whole. It may pass the eye, be seen edge-on, or be no more than a line.
pub(crate) fn whole_grid(
    rng: &mut Rng,
    [origin, along, across]: [[i64; 4]; 3],
    [columns, rows]: [usize; 2],
    cells: Cells,
) -> Mesh {
    let places = (0..=rows as i64).flat_map(|j| (0..=columns as i64).map(move |i| (i, j)));
    let position = |(i, j)| from_fn(|k| (origin[k] + i * along[k] + j * across[k]) as f32);
    let positions = places.map(position).collect();
    Mesh { positions, faces: grid_faces(rng, columns, rows, cells) }
}

/// A convex quad of any size up to the window's, somewhere around it, with a w of its own at each
/// vertex, up to 30 or all 1. In one of three each z is of -0.3 w..1.3 w, so that the near or the far
/// plane may cut the quad.
pub(crate) fn split_quad(rng: &mut Rng, window: Window) -> [Position; 4] {
    let w_ratio = if rng.once_in(3) { 1.0 } else { 30.0 };
    let (centre, turn) = (somewhere(rng, window), rng.range(0.0, TAU));
    let radius = rng.octaves(0.5, half_diagonal(window));
    let is_cut = rng.once_in(3);
    // Corners a quarter turn apart, an eighth off at most: of the same radius, they are convex.
    from_fn(|i| {
        let angle = turn + TAU / 4.0 * (i as f64 + rng.range(-0.5, 0.5));
        let place = on_circle(centre, radius, angle);
        let mut p = at_pixel(place, rng.octaves(1.0, w_ratio), window);
        if is_cut {
            p[2] = p[3] * rng.range(-0.3, 1.3) as f32;
        }
        p
    })
}

/// Triangles around a vertex on the pixel centre in the middle, to a ring outside the viewport.
/// Each pixel is covered once. Ring vertices are on pixel centres too, so that spokes meet many.
pub(crate) fn fan(rng: &mut Rng, window: Window, spokes: usize, w_ratio: f64) -> Mesh {
    let mut places = ring(rng, window, spokes, 2.0);
    places.push(middle(window));
    // Powers of two keep the places exact where the window's sides are powers of two.
    let w = |rng: &mut Rng| rng.octaves(1.0, w_ratio).log2().floor().exp2();
    let positions = places
        .iter()
        .map(|place| at_pixel(place.map(|c| c.floor() + 0.5), w(rng), window))
        .collect();
    let mut faces: Vec<_> = (0..spokes).map(|i| vec![spokes, i, (i + 1) % spokes]).collect();
    disguise(rng, &mut faces);
    Mesh { positions, faces }
}

/// The faces of a grid of (columns + 1) (rows + 1) vertices, row by row.
fn grid_faces(rng: &mut Rng, columns: usize, rows: usize, cells: Cells) -> Vec<Vec<usize>> {
    let mut faces = Vec::new();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let a = row * (columns + 1) + column;
        let quad = [a, a + 1, a + columns + 2, a + columns + 1];
        let whole = cells == Cells::Quads || (cells == Cells::Mixed && rng.once_in(2));
        let first = rng.below(2);
        if whole {
            faces.push(quad.to_vec());
        } else {
            faces.extend([0, 2].map(|k| [0, 1, 2].map(|i| quad[(first + k + i) % 4]).to_vec()));
        }
    }
    disguise(rng, &mut faces);
    faces
}

/// Puts the faces in random order, each in a random direction, beginning anywhere.
fn disguise(rng: &mut Rng, faces: &mut [Vec<usize>]) {
    for face in faces.iter_mut() {
        let start = rng.below(face.len());
        face.rotate_left(start);
        if rng.once_in(2) {
            face.reverse();
        }
    }
    rng.shuffle(faces);
}
