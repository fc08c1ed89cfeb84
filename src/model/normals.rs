//! Normals for the corners that have none: flat across creases, smooth elsewhere.
//!
//! Each face has a direction by Newell's method, which suits polygons of any number of sides, even
//! bent ones. A corner's normal is the mean of the directions of those faces around its point that
//! are within the crease angle of the corner's own face, each weighted by the angle that it fills
//! at the point, so that cutting a face into triangles changes nothing (Thürmer and Wüthrich,
//! "Computing Vertex Normals from Polygonal Facets", 1998). Sums are in `f64`, in the order of the
//! file. Of the platform's functions only the square root is used, which is rounded alike everywhere.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use crate::model::corners::Corners;
use crate::model::faces::range_before;

/// Up to this many corners around a point are compared pair by pair. Beyond that, their faces are
/// first gathered in cells of directions, so that a point of 100,000 faces costs at most 384 steps a
/// face. Points of real meshes rarely have more than 16 corners.
const MAX_PAIRED: usize = 64;

/// Cells of directions: six sides of a cube, each 8 x 8. A cell is some 14 degrees wide or less.
const GRID: usize = 8;
const CELL_COUNT: usize = 6 * GRID * GRID;

/// How far the cosine may be below that of the crease angle. Angles that differ from the crease angle
/// by rounding only are thus within it: a cylinder of six sides is smooth at 60 degrees.
const TOLERANCE: f64 = 1e-6;

/// Normalises the normals that corners have, and computes those that are zero.
pub(super) fn complete(corners: &mut Corners, crease_angle: f32) {
    let least_cosine = cosine(f64::from(crease_angle)) - TOLERANCE;
    let fans = Fans::new(corners);
    let shape = Shape::new(corners);
    let direction = |corner: u32| shape.directions[fans.face[corner as usize] as usize];

    let mut around = Vec::new();
    for fan in fans.iter() {
        if fan.iter().any(|&corner| corners.normal[corner as usize] == Vec3::ZERO) {
            let faces = fan.iter().map(|&corner| Contribution {
                direction: direction(corner),
                vector: direction(corner) * f64::from(shape.angles[corner as usize]),
            });
            gather(faces, &mut around);
        }
        for &corner in fan {
            let normal = &mut corners.normal[corner as usize];
            *normal = normal
                .as_dvec3()
                .try_normalize()
                .unwrap_or_else(|| smooth(direction(corner), &around, least_cosine))
                .as_vec3();
        }
    }
}

/// What a face, or a cell of faces, adds to normals at a point.
#[derive(Clone, Copy)]
struct Contribution {
    /// It is compared with a corner's own direction; of length 1, or zero.
    direction: DVec3,
    /// It is added to the sum.
    vector: DVec3,
}

/// The mean, with length 1, of the contributions that are within the crease angle of `own`.
///
/// A face without an area has no direction and takes the mean of all. Where that is zero too, any
/// normal is as good.
fn smooth(own: DVec3, around: &[Contribution], least_cosine: f64) -> DVec3 {
    let sum: DVec3 = around
        .iter()
        .filter(|face| own == DVec3::ZERO || own.dot(face.direction) >= least_cosine)
        .map(|face| face.vector)
        .sum();
    sum.try_normalize().unwrap_or(if own == DVec3::ZERO { DVec3::Z } else { own })
}

/// Fills `around` with the contributions of the faces around a point or, if there are many faces, with
/// their sums over each cell of directions.
fn gather(faces: impl ExactSizeIterator<Item = Contribution>, around: &mut Vec<Contribution>) {
    around.clear();
    if faces.len() <= MAX_PAIRED {
        around.extend(faces);
        return;
    }
    let mut cells = [DVec3::ZERO; CELL_COUNT];
    for face in faces {
        cells[cell_of(face.direction)] += face.vector;
    }
    let sums = cells.into_iter().filter_map(|vector| {
        vector.try_normalize().map(|direction| Contribution { direction, vector })
    });
    around.extend(sums);
}

/// The cell that a vector points into: the side of a cube around it, and a square on that side.
fn cell_of(vector: DVec3) -> usize {
    let axis = vector.abs().max_position();
    let major = vector[axis];
    // From -1 to 1 across the side. The cast takes the NaN of a zero vector to 0.
    let square = |minor: f64| (((minor / major + 1.0) * 0.5 * GRID as f64) as usize).min(GRID - 1);
    let side = 2 * axis + usize::from(major < 0.0);
    (side * GRID + square(vector[(axis + 1) % 3])) * GRID + square(vector[(axis + 2) % 3])
}

/// The directions of faces, and the angles at their corners.
struct Shape {
    /// For each face, of length 1 or zero.
    directions: Vec<DVec3>,
    /// For each corner, in radians from 0 to 2 pi.
    angles: Vec<f32>,
}

impl Shape {
    fn new(corners: &Corners) -> Self {
        let mut shape = Self { directions: Vec::new(), angles: Vec::new() };
        let mut positions = Vec::new();
        for face in 0..corners.ends.len() {
            let points = &corners.point[range_before(&corners.ends, face)];
            positions.clear();
            positions.extend(points.iter().map(|&point| corners.points[point as usize].as_dvec3()));
            shape.add(&positions);
        }
        shape
    }

    fn add(&mut self, polygon: &[DVec3]) {
        let direction = newell(polygon);
        self.directions.push(direction);
        let before = polygon.iter().cycle().skip(polygon.len().saturating_sub(1));
        let after = polygon.iter().cycle().skip(1);
        let sides = polygon.iter().zip(before).zip(after);
        self.angles.extend(
            sides.map(|((&at, &before), &after)| angle(after - at, before - at, direction) as f32),
        );
    }
}

/// Newell's sum over the edges, which is along the polygon's normal, brought to length 1; zero for a
/// polygon without area. Positions are relative to the first corner, so that a face far from the
/// origin loses nothing.
fn newell(polygon: &[DVec3]) -> DVec3 {
    let first = polygon.first().copied().unwrap_or_default();
    let spokes = polygon.iter().map(|&position| position - first);
    let sum: DVec3 = spokes.clone().zip(spokes.skip(1)).map(|(a, b)| a.cross(b)).sum();
    sum.normalize_or_zero()
}

/// The angle inside a polygon from the side `a` to the side `b`, counter-clockwise about `normal`;
/// zero if a side has no length.
fn angle(a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let (Some(a), Some(b)) = (a.try_normalize(), b.try_normalize()) else { return 0.0 };
    let least = arc_cosine(a.dot(b));
    if a.cross(b).dot(normal) < 0.0 { TAU - least } else { least }
}

/// The angle of a cosine, to 7e-5, which is plenty for a weight (Abramowitz and Stegun, 4.4.45).
fn arc_cosine(cosine: f64) -> f64 {
    let x = cosine.abs().min(1.0);
    let series = 1.570_728_8 + x * (-0.212_114_4 + x * (0.074_261 + x * -0.018_729_3));
    let angle = (1.0 - x).sqrt() * series;
    if cosine < 0.0 { PI - angle } else { angle }
}

/// The cosine of an angle from 0 to pi, by its power series. The first term left out is pi^32 / 32!,
/// or 3e-20.
fn cosine(angle: f64) -> f64 {
    let terms = (1..=15).scan(1.0, |term, k| {
        let even = 2.0 * f64::from(k);
        *term *= -angle * angle / ((even - 1.0) * even);
        Some(*term)
    });
    1.0 + terms.sum::<f64>()
}

/// For each point the corners that meet there, in one list.
struct Fans {
    corners: Vec<u32>,
    /// Where each point's corners end.
    ends: Vec<u32>,
    /// For each corner, its face.
    face: Vec<u32>,
}

impl Fans {
    /// Counting sort of the corners by point, which keeps the order of the file.
    fn new(corners: &Corners) -> Self {
        let mut starts = vec![0; corners.points.len()];
        for &point in &corners.point {
            starts[point as usize] += 1;
        }
        let mut total = 0;
        for start in &mut starts {
            (*start, total) = (total, total + *start);
        }
        // Each start moves on to its end as corners are put in.
        let mut ends = starts;
        let mut sorted = vec![0; corners.point.len()];
        for (corner, &point) in (0..).zip(&corners.point) {
            sorted[ends[point as usize] as usize] = corner;
            ends[point as usize] += 1;
        }
        let face = (0..corners.ends.len())
            .flat_map(|face| range_before(&corners.ends, face).map(move |_| face as u32))
            .collect();
        Self { corners: sorted, ends, face }
    }

    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.ends.len()).map(|point| &self.corners[range_before(&self.ends, point)])
    }
}
