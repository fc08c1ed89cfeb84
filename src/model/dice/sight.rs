//! How large things are on the screen, and what is outside of it.

use std::f32::consts::SQRT_2;

use glam::{Mat4, Vec3, Vec4};

use crate::viewport::Viewport;

/// How a model is seen.
pub(super) struct Sight {
    /// The last row of the matrix: w of a place.
    w: Vec4,
    /// The pixels of a length of 1 that lies across the view, where w is 1.
    scale: f32,
    /// The least w in the view volume.
    nearest: f32,
    /// What is at 0 or less of one of them is outside of the view volume, wherever it is moved to.
    planes: [Vec4; 6],
    /// How long edges are to be, in pixels.
    pub(super) edge: f32,
}

impl Sight {
    /// The view by a matrix of a model whose surface is moved by so much at the most.
    pub(super) fn new(matrix: Mat4, viewport: Viewport, most: f32) -> Self {
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
        let nearness = |corner: Vec4| (matrix.inverse() * corner).w;
        let sign = |i: u32, bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corners = (0..8).map(|i| Vec4::new(sign(i, 0), sign(i, 1), sign(i, 2), 1.0));
        let nearest = 1.0 / corners.map(nearness).fold(0.0, f32::max);
        // A step along which w stays the same moves x and y alone.
        let forward = w.truncate().normalize_or_zero();
        let across = |row: Vec4| row.truncate().reject_from_normalized(forward).length();
        let (width, height) = (viewport.rect().width as f32, viewport.rect().height as f32);
        let scale = 0.5 * (across(x) * width).max(across(y) * height);
        // Both clip spaces' near planes are inside of these.
        let planes = [w - x, w + x, w - y, w + y, w - z, w + z];
        let planes = planes.map(|plane| plane + Vec4::W * (most * plane.truncate().length()));
        let nearest = if nearest.is_finite() { nearest } else { 0.0 };
        Self { w, scale, nearest, planes, edge: 1.0 }
    }

    /// Whether lengths on the screen are numbers at all.
    pub(super) fn is_usable(&self) -> bool {
        self.scale.is_finite() && self.w.is_finite() && self.planes.iter().all(|p| p.is_finite())
    }

    /// The pixels of a length of 1 across the view at a place, or at the nearest place that is seen.
    pub(super) fn scale_at(&self, place: Vec3) -> f32 {
        self.scale / self.w.dot(place.extend(1.0)).max(self.nearest).max(f32::MIN_POSITIVE)
    }

    /// Whether an edge is to be cut in two: between places before and after they were moved.
    pub(super) fn is_long(&self, before: [Vec3; 2], after: [Vec3; 2]) -> bool {
        let scale = self.scale_at(after[0]).max(self.scale_at(after[1]));
        let [before, after] = [before, after].map(|[a, b]| a.distance(b) * scale);
        // Halves of the longest that are left are as much shorter than `edge` as those are longer.
        let longest = SQRT_2 * self.edge;
        before > longest || after > longest && before > 0.25 * longest
    }

    /// A bit for each plane that a place is outside of, before it is moved.
    pub(super) fn outcode(&self, place: Vec3) -> u32 {
        let place = place.extend(1.0);
        let outside = |(i, plane): (usize, &Vec4)| u32::from(plane.dot(place) < 0.0) << i;
        self.planes.iter().enumerate().map(outside).sum()
    }
}
