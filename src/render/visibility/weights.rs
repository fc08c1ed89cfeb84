//! From the faces that are seen to what else is known of them: barycentrics, their derivatives, w.
//!
//! The weights of a triangle's corners at a pixel come from the corners in clip space, with nothing
//! clipped or divided before (M. Olano and T. Greer, "Triangle Scan Conversion using 2D Homogeneous
//! Coordinates", Graphics Hardware 1997). With the pixel's centre at (X, Y) in normalized device
//! coordinates, u_i = x_i - X w_i and v_i = y_i - Y w_i say how far corner i is off the ray through the
//! centre. The weights are orthogonal to both, so they are their cross product, made to sum to 1:
//!
//! ```text
//! e_i = u_j v_k - u_k v_j        b_i = e_i / (e_1 + e_2 + e_3)        w = b_1 w_1 + b_2 w_2 + b_3 w_3
//! ```
//!
//! All is in f64 and of the pixel and the face alone, so it is the same in all tiles and on all machines.

use std::ops::Range;

use crate::render::faces::FaceList;
use crate::settings::DrawCall;
use crate::vertices::Vertices;

/// Pixels of a face that are found at a time.
const AT_ONCE: usize = 8;

/// The faces and the mapping by which weights are found.
#[derive(Clone, Copy)]
pub(crate) struct Weights<'a> {
    pub(crate) call: &'a DrawCall<'a>,
    pub(crate) vertices: &'a dyn Vertices,
    pub(crate) faces: &'a FaceList,
    pub(crate) width: usize,
    /// How many elements a pixel has.
    pub(crate) per_pixel: usize,
    /// Where in the pixel each of them is, in pixels from its centre; those that have none are there.
    pub(crate) places: &'static [[f32; 2]],
}

/// Some rows of a visibility buffer. What is not asked for is empty.
pub(crate) struct SeenRows<'a> {
    /// The first on the framebuffer.
    pub(crate) first: usize,
    pub(crate) face: &'a [u32],
    pub(crate) w: &'a mut [f32],
    pub(crate) barycentrics: &'a mut [[f32; 3]],
    pub(crate) corners: &'a mut [[u32; 3]],
    pub(crate) derivatives: &'a mut [[[f32; 2]; 3]],
}

/// Three corners in clip space, as seen from a row of pixels.
struct Corners {
    x: [f64; 3],
    w: [f64; 3],
    /// v of the row.
    v: [f64; 3],
}

/// The weights at some pixels: each its value, and that it had before it was brought into 0 ..= 1.
#[derive(Clone, Copy, Default)]
struct Found {
    b: [[f64; AT_ONCE]; 3],
    unlimited: [[f64; AT_ONCE]; 3],
    w: [f64; AT_ONCE],
}

impl Weights<'_> {
    /// Finds what is known of the faces that are seen in some rows, of those that are in the list.
    #[inline(always)]
    pub(crate) fn find(&self, rows: &mut SeenRows<'_>) {
        let in_row = self.width * self.per_pixel;
        for (row, start) in (0..rows.face.len()).step_by(in_row.max(1)).enumerate() {
            for element in 0..self.per_pixel {
                let place = self.places.get(element).copied().unwrap_or_default().map(f64::from);
                self.find_in_row(rows, (row + rows.first) as i32, start + element, place);
            }
        }
    }

    /// The same of one element of each pixel of a row; that of the first is at `start`.
    #[inline(always)]
    fn find_in_row(&self, rows: &mut SeenRows<'_>, row: i32, start: usize, place: [f64; 2]) {
        let y = self.call.projection.ndc_y(row, place[1]);
        let mut x = 0;
        while x < self.width {
            let face_at = |x: usize| rows.face[start + x * self.per_pixel];
            let (first, number) = (x, face_at(x));
            while x < self.width && face_at(x) == number {
                x += 1;
            }
            if let Some(face) = self.faces.with_number(number) {
                self.find_along(rows, (face, [place[0], y]), start, first..x);
            }
        }
    }

    /// The same at neighbouring pixels where one face is seen, so far right of their centres, at a Y in
    /// normalized device coordinates.
    #[inline(always)]
    fn find_along(
        &self,
        rows: &mut SeenRows<'_>,
        (face, [right, y]): (&[u32], [f64; 2]),
        start: usize,
        columns: Range<usize>,
    ) {
        if let &[a, b, c] = face {
            let Some(corners) = self.corners([a, b, c], y) else { return };
            for first in columns.clone().step_by(AT_ONCE) {
                let some = first..columns.end.min(first + AT_ONCE);
                let found = corners.weights(&self.places_from(first, right));
                self.store(rows, ([a, b, c], &corners), (start, right), some, &found);
            }
            return;
        }
        for x in columns {
            let mut best: Option<(f64, [u32; 3], Corners, Found)> = None;
            for pair in face.get(1..).unwrap_or_default().windows(2) {
                let indices = [face[0], pair[0], pair[1]];
                let Some(corners) = self.corners(indices, y) else { continue };
                let found = corners.weights(&self.places_from(x, right));
                let least = found.unlimited.iter().map(|b| b[0]).fold(f64::INFINITY, f64::min);
                if best.as_ref().is_none_or(|(most, ..)| least > *most) {
                    best = Some((least, indices, corners, found));
                }
            }
            if let Some((_, indices, corners, found)) = best {
                self.store(rows, (indices, &corners), (start, right), x..x + 1, &found);
            }
        }
    }

    /// X of places right of the centres of pixels, from a column of the framebuffer on.
    #[inline(always)]
    fn places_from(&self, first: usize, right: f64) -> [f64; AT_ONCE] {
        std::array::from_fn(
            #[inline(always)]
            |lane| self.call.projection.ndc_x((first + lane) as i32, right),
        )
    }

    #[inline(always)]
    fn corners(&self, indices: [u32; 3], y: f64) -> Option<Corners> {
        let mut corners = Corners { x: [0.0; 3], w: [0.0; 3], v: [0.0; 3] };
        for (corner, index) in indices.into_iter().enumerate() {
            let position = self.vertices.get(index)?.0.as_dvec4();
            corners.x[corner] = position.x;
            corners.w[corner] = position.w;
            corners.v[corner] = position.y - y * position.w;
        }
        Some(corners)
    }

    #[inline(always)]
    fn store(
        &self,
        rows: &mut SeenRows<'_>,
        (indices, corners): ([u32; 3], &Corners),
        (start, right): (usize, f64),
        columns: Range<usize>,
        found: &Found,
    ) {
        let size = self.call.projection.pixels();
        for (lane, x) in columns.enumerate() {
            let (at, lane) = (start + x * self.per_pixel, lane % AT_ONCE);
            if let Some(w) = rows.w.get_mut(at) {
                *w = found.w[lane] as f32;
            }
            if let Some(weights) = rows.barycentrics.get_mut(at) {
                *weights = found.b.map(|b| b[lane] as f32);
            }
            if let Some(seen) = rows.corners.get_mut(at) {
                *seen = indices;
            }
            if let Some(derivatives) = rows.derivatives.get_mut(at) {
                let b = found.unlimited.map(|b| b[lane]);
                let x = self.call.projection.ndc_x(x as i32, right);
                *derivatives = corners.derivatives(x, b, size);
            }
        }
    }
}

/// The other two of three corners.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

impl Corners {
    /// The weights where X is as given.
    #[inline(always)]
    fn weights(&self, x: &[f64; AT_ONCE]) -> Found {
        let (v, mut found) = (self.v, Found::default());
        for (lane, x) in x.iter().enumerate() {
            let u = [0, 1, 2].map(|i| self.x[i] - x * self.w[i]);
            let e = OTHERS.map(|[j, k]| u[j] * v[k] - u[k] * v[j]);
            let sum = e[0] + e[1] + e[2];
            let (per_sum, sign) = (1.0 / sum, if sum < 0.0 { -1.0 } else { 1.0 });
            let inside = e.map(|e| if e * sign > 0.0 { e * sign } else { 0.0 });
            let per_inside = 1.0 / (inside[0] + inside[1] + inside[2]);
            // An edge-on triangle has no weights: then it is seen at its first corner.
            let has_weights = per_inside < f64::INFINITY && per_inside > 0.0;
            for i in 0..3 {
                let b = inside[i] * per_inside;
                let first = if i == 0 { 1.0 } else { 0.0 };
                found.b[i][lane] = if has_weights { b } else { first };
                found.unlimited[i][lane] = e[i] * per_sum;
                found.w[lane] += found.b[i][lane] * self.w[i];
            }
        }
        found
    }

    /// The changes of the weights `b` per pixel to the right and per pixel downwards, where X is as given
    /// and the picture has so many columns and rows.
    fn derivatives(&self, x: f64, b: [f64; 3], size: [f64; 2]) -> [[f32; 2]; 3] {
        let (v, w) = (self.v, self.w);
        let u = [0, 1, 2].map(|i| self.x[i] - x * w[i]);
        let sum = |e: [f64; 3]| e[0] + e[1] + e[2];
        let total = sum(OTHERS.map(|[j, k]| u[j] * v[k] - u[k] * v[j]));
        let along_x = OTHERS.map(|[j, k]| w[k] * v[j] - w[j] * v[k]);
        let along_y = OTHERS.map(|[j, k]| w[j] * u[k] - w[k] * u[j]);
        // A pixel is 2 / width of X to the right and 2 / height of Y downwards, where Y points upwards.
        let per_pixel = [2.0 / size[0] / total, -2.0 / size[1] / total];
        [0, 1, 2].map(|i| {
            let changes = [along_x, along_y].map(|e| e[i] - b[i] * sum(e));
            let [dx, dy] = [changes[0] * per_pixel[0], changes[1] * per_pixel[1]];
            [dx, dy].map(|slope| if slope.is_finite() { slope as f32 } else { 0.0 })
        })
    }
}
