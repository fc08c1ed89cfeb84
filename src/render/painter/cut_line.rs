//! The lines in which planes cut polygons, on the screen.
//!
//! ```text
//!        \\
//!     [][]\\##      The whole polygon's pixels in a row are parted at one column: those whose centres
//!     [][][\\#      are left of the line belong to one piece, the others to the other. Neither piece
//!     [][][]\\      has a rounded vertex of its own on the line.
//! ```

use std::ops::Range;

use glam::DVec4;

use crate::project::ScreenPoint;
use crate::surface::plane::PlaneBasis;
use crate::surface::polygon::widest_triangle;

/// The line in which a plane meets a polygon, on the screen: where an affine function of the position
/// is zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CutLine {
    /// A point, in pixels from the viewport's corner.
    at: (f64, f64),
    /// The value there.
    value: f64,
    /// Its change per pixel to the right and downwards.
    slope: (f64, f64),
    /// Whether the pixels are wanted where the value is not negative; else those where it is.
    front: bool,
}

impl CutLine {
    /// The line for a plane in clip space and a clipped polygon, whose places on the screen are given;
    /// `None` if there is no polygon.
    pub(crate) fn new(
        plane: DVec4,
        front: bool,
        polygon: &[DVec4],
        outline: &[ScreenPoint],
    ) -> Option<Self> {
        let value = |vertex: usize| plane.dot(polygon[vertex]) / polygon[vertex].w;
        let triangle = widest_triangle(outline)?;
        let basis = PlaneBasis::new(triangle.map(|v| [outline[v].x, outline[v].y]));
        let fit = basis.plane(triangle.map(value));
        let slope = if basis.is_wide && (fit.dx + fit.dy).is_finite() {
            (fit.dx, fit.dy)
        } else {
            slope_along(outline, value)
        };
        let origin = outline[triangle[0]];
        Some(Self { at: (origin.x, origin.y), value: fit.value, slope, front })
    }

    /// The columns of a row on the wanted side. Whatever the numbers are, those of both sides are all
    /// columns once.
    pub(crate) fn columns(&self, y: i32) -> Range<i32> {
        const ALL: Range<i32> = i32::MIN..i32::MAX;
        let value = self.value + self.slope.1 * (f64::from(y) + 0.5 - self.at.1);
        let (slope, _) = self.slope;
        if slope == 0.0 {
            return if (value >= 0.0) == self.front { ALL } else { 0..0 };
        }
        // The first column whose centre is at the line or on its right.
        let column = (self.at.0 - value / slope - 0.5).ceil() as i32;
        if (slope > 0.0) == self.front { column..ALL.end } else { ALL.start..column }
    }
}

/// The change of a value along a polygon that is too thin to have planes: from one end to the other,
/// and none across.
#[cold]
fn slope_along(outline: &[ScreenPoint], value: impl Fn(usize) -> f64) -> (f64, f64) {
    let Some(a) = outline.first() else { return (0.0, 0.0) };
    let from_a = |v: &ScreenPoint| (v.x - a.x, v.y - a.y);
    let length = |v: &ScreenPoint| {
        let (x, y) = from_a(v);
        x * x + y * y
    };
    let farthest = (0..outline.len())
        .max_by(|&v, &w| length(&outline[v]).total_cmp(&length(&outline[w])))
        .unwrap_or(0);
    let ((x, y), square) = (from_a(&outline[farthest]), length(&outline[farthest]));
    let z = value(farthest) - value(0);
    if square > 0.0 { (x * z / square, y * z / square) } else { (0.0, 0.0) }
}
