//! From the face at each pixel to the barycentrics and the depth there.
//!
//! The pixel at (X, Y), both from -1 to 1, sees of a triangle with the corners (x_i, y_i, w_i) in clip space the
//! point whose barycentrics b_i bring the corners there: with x'_i = x_i - X w_i and y'_i = y_i - Y w_i the sums of
//! b_i x'_i and of b_i y'_i are zero. So b_0 is in proportion to x'_1 y'_2 - x'_2 y'_1, and so on, which is linear
//! over the screen (Olano and Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", 1997) and right in
//! perspective, whatever was clipped. All of it is computed in f64 from the positions as they were given.

use polyscan::glam::{DMat4, DVec2, dvec2};
use polyscan::render::FaceIndices;
use polyscan::{Mesh, SizeError, Target, Vertex, ZBufferRenderer};
use rayon::prelude::*;

use crate::polygons::Polygons;
use crate::positions::Positions;

/// What is seen at each pixel.
#[derive(Default)]
pub(crate) struct Visibility {
    pub(crate) face: Vec<u32>,
    pub(crate) depth: Vec<f32>,
    pub(crate) w: Vec<f32>,
    pub(crate) barycentrics: Vec<[f32; 3]>,
    pub(crate) corners: Vec<[u32; 3]>,
    pub(crate) derivatives: Vec<[[f32; 2]; 3]>,
    width: u32,
    height: u32,
}

impl Visibility {
    pub(crate) fn new(width: u32, height: u32) -> Result<Self, SizeError> {
        let (face, depth) = polyscan::Framebuffer::new(width, height, u32::MAX)?.into_parts();
        Ok(Self { face, depth, width, height, ..Self::default() })
    }

    pub(crate) fn draw<F: IntoIterator<Item: FaceIndices>>(
        &mut self,
        renderer: &mut ZBufferRenderer<0>,
        vertices: &[Vertex<0>],
        faces: F,
    ) {
        self.depth.fill(renderer.settings.depth.farthest());
        let target = Target::new(self.width, &mut self.face, &mut self.depth);
        let mut target = target.expect("the sizes agree");
        renderer.draw_blocks(&mut target, Mesh::new(vertices, faces), |block, faces| {
            faces.fill(block.face)
        });
    }

    pub(crate) fn resolve(
        &mut self,
        positions: Positions<'_>,
        faces: Polygons<'_>,
        clip_from_object: DMat4,
        window: [u32; 4],
    ) {
        let [left, top, whole, high] = window.map(f64::from);
        let (corner, step) = (dvec2(left, top), dvec2(2.0 / whole, -2.0 / high));
        let width = self.width as usize;
        let pixel = |i: usize| {
            let face = self.face[i];
            if face == u32::MAX {
                return (0.0, [0.0; 3], [0; 3], [[0.0; 2]; 3]);
            }
            let corners = faces.frame(face as usize, &positions);
            let clip = corners.map(|i| clip_from_object * positions.get(i as usize));
            let plane = Plane {
                x: clip.map(|c| c.x),
                y: clip.map(|c| c.y),
                w: clip.map(|c| c.w),
                is_triangle: faces.get(face as usize).len() == 3,
            };
            let pixel = corner + dvec2((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            let point = plane.at(step * pixel + dvec2(-1.0, 1.0));
            let b = plane.barycentrics(&point);
            let w = b.iter().zip(plane.w).map(|(b, w)| b * w).sum::<f64>();
            let d = plane.derivatives(&point).map(|d| (d * step).as_vec2().to_array());
            (w as f32, b.map(|b| b as f32), corners, d)
        };
        let found: Vec<_> = (0..self.face.len()).into_par_iter().map(pixel).collect();
        self.w = found.iter().map(|f| f.0).collect();
        self.barycentrics = found.iter().map(|f| f.1).collect();
        self.corners = found.iter().map(|f| f.2).collect();
        self.derivatives = found.iter().map(|f| f.3).collect();
    }
}

/// The plane of a face: three of its corners in clip space, and their depths.
#[derive(Clone, Copy)]
struct Plane {
    x: [f64; 3],
    y: [f64; 3],
    w: [f64; 3],
    is_triangle: bool,
}

/// What a pixel sees of a plane.
struct Point {
    /// In proportion to the barycentrics.
    areas: [f64; 3],
    /// The corners as seen from there.
    x: [f64; 3],
    y: [f64; 3],
    /// The sum of the areas.
    sum: f64,
}

impl Plane {
    #[inline]
    fn at(&self, pixel: DVec2) -> Point {
        let x: [f64; 3] = std::array::from_fn(|i| self.x[i] - pixel.x * self.w[i]);
        let y: [f64; 3] = std::array::from_fn(|i| self.y[i] - pixel.y * self.w[i]);
        let area = |j: usize, k: usize| x[j] * y[k] - x[k] * y[j];
        let areas = [area(1, 2), area(2, 0), area(0, 1)];
        Point { areas, x, y, sum: areas[0] + areas[1] + areas[2] }
    }

    /// On the plane, where the pixel sees it.
    #[inline]
    fn on_plane(point: &Point) -> [f64; 3] {
        let b = point.areas.map(|area| area / point.sum);
        // A face without an area, of which rounding has made one on the screen.
        if b.iter().all(|b| b.is_finite()) { b } else { [1.0 / 3.0; 3] }
    }

    /// The barycentrics: of a triangle within it, although a pixel's centre may lie outside by 1/256 pixel.
    #[inline]
    fn barycentrics(&self, point: &Point) -> [f64; 3] {
        let b = Self::on_plane(point);
        if !self.is_triangle || b.iter().all(|&b| b >= 0.0) {
            return b;
        }
        let b = b.map(|b| b.max(0.0));
        let sum = b[0] + b[1] + b[2];
        b.map(|b| b / sum)
    }

    /// The derivatives of the barycentrics along X and Y, by the quotient rule.
    #[inline]
    fn derivatives(&self, point: &Point) -> [DVec2; 3] {
        let Point { areas, x, y, sum } = point;
        let slope = |j: usize, k: usize| {
            dvec2(self.w[k] * y[j] - self.w[j] * y[k], self.w[j] * x[k] - self.w[k] * x[j])
        };
        let slopes = [slope(1, 2), slope(2, 0), slope(0, 1)];
        let of_sum = slopes[0] + slopes[1] + slopes[2];
        let derivative = |i: usize| (slopes[i] * *sum - of_sum * areas[i]) / (sum * sum);
        let derivatives: [DVec2; 3] = std::array::from_fn(derivative);
        if derivatives.iter().all(|d| d.is_finite()) { derivatives } else { [DVec2::ZERO; 3] }
    }
}
