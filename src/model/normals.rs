//! Normals for the corners that have none: flat across creases, smooth elsewhere.
//!
//! Each face has a direction by Newell's method, which suits polygons of any number of sides, even
//! bent ones. A corner's normal is the mean of the directions of those faces around its point that
//! are within the crease angle of the corner's own face, each weighted by the angle that it fills
//! at the point, so that cutting a face into triangles changes nothing (Thürmer and Wüthrich,
//! "Computing Vertex Normals from Polygonal Facets", 1998). Where the file gives smoothing groups, the
//! faces of the corner's group take the place of those within the angle. Faces that are turned over
//! against their neighbours, of which some files are full, count as if they were not: the edges around
//! the point say so, for two faces run along a common edge in opposite directions. Sums are in `f64`,
//! in the order of the file. Of the platform's functions only the square root is used, which is rounded
//! alike everywhere.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use crate::model::corners::{BY_ANGLE, Corners, FLAT};
use crate::model::faces::range_before;

/// Up to this many corners around a point are compared pair by pair. Beyond that, their faces are
/// first gathered in cells of directions, so that a point of 100,000 faces costs at most 384 steps a
/// face. Points of real meshes rarely have more than 16 corners.
const MAX_PAIRED: usize = 64;

/// Cells of directions: six sides of a cube, each 8 x 8. A cell is some 14 degrees wide or less.
const GRID: usize = 8;
const CELL_COUNT: usize = 6 * GRID * GRID;

/// So many smoothing groups are told apart at a point of very many faces.
const MAX_GROUPS: usize = 8;

/// How far the cosine may be below that of the crease angle. Angles that differ from the crease angle
/// by rounding only are thus within it: a cylinder of six sides is smooth at 60 degrees.
const TOLERANCE: f64 = 1e-6;

/// Normalises the normals that corners have, and computes those that are zero.
pub(super) fn complete(corners: &mut Corners, crease_angle: f32) {
    if corners.normal.iter().all(|&normal| normal != Vec3::ZERO) {
        for normal in &mut corners.normal {
            *normal = unit(*normal).unwrap_or(Vec3::Z);
        }
        return;
    }
    let least_cosine = cosine(f64::from(crease_angle)) - TOLERANCE;
    let fans = Fans::new(corners);
    let shape = Shape::new(corners);

    let mut around = Vec::new();
    let mut turns = Turns::default();
    for fan in fans.iter() {
        if fan.iter().any(|&corner| corners.normal[corner as usize] == Vec3::ZERO) {
            let faces = fan.iter().map(|&corner| {
                let face = fans.face[corner as usize] as usize;
                let direction = shape.directions[face];
                let vector = direction * f64::from(shape.angles[corner as usize]);
                Contribution { direction, vector, smoothing: corners.smoothing[face] }
            });
            gather(faces, &mut around);
            turns.find(corners, &fans, fan);
        }
        for (place, &corner) in fan.iter().enumerate() {
            let face = fans.face[corner as usize] as usize;
            let own = (shape.directions[face], corners.smoothing[face]);
            let normal = &mut corners.normal[corner as usize];
            *normal = unit(*normal).unwrap_or_else(|| {
                let mean = smooth(own, &around, turns.seen_from(place), least_cosine);
                mean.as_vec3()
            });
        }
    }
}

/// The vector brought to length 1, in `f64`; `None` for zero.
fn unit(vector: Vec3) -> Option<Vec3> {
    vector.as_dvec3().try_normalize().map(DVec3::as_vec3)
}

/// What a face, or a cell of faces, adds to normals at a point.
#[derive(Clone, Copy)]
struct Contribution {
    /// It is compared with a corner's own direction; of length 1, or zero.
    direction: DVec3,
    /// It is added to the sum.
    vector: DVec3,
    /// The smoothing group.
    smoothing: u32,
}

/// The mean, with length 1, of the contributions that are smooth with the face of direction `own`:
/// those of its group, or those within the crease angle.
///
/// A face without an area has no direction and takes the mean of all. Where that is zero too, any
/// normal is as good. `turned` says of each contribution whether it is turned over against the face.
fn smooth(
    (own, smoothing): (DVec3, u32),
    around: &[Contribution],
    turned: &[bool],
    least_cosine: f64,
) -> DVec3 {
    let is_turned = |place| own != DVec3::ZERO && turned.get(place) == Some(&true);
    let sign = |place: usize| if is_turned(place) { -1.0 } else { 1.0 };
    let sum: DVec3 = around
        .iter()
        .enumerate()
        .filter(|&(place, face)| match smoothing {
            _ if own == DVec3::ZERO => true,
            FLAT => false,
            BY_ANGLE => {
                face.smoothing == BY_ANGLE && sign(place) * own.dot(face.direction) >= least_cosine
            }
            group => face.smoothing == group,
        })
        .map(|(place, face)| face.vector * sign(place))
        .sum();
    sum.try_normalize().unwrap_or(if own == DVec3::ZERO { DVec3::Z } else { own })
}

/// Which of the faces around a point are turned over against each other.
#[derive(Default)]
struct Turns {
    /// For each corner of a fan whether its face is turned over, seen from each: rows of a square, or
    /// nothing if none is.
    turned: Vec<bool>,
    size: usize,
    /// For each corner the points after and before it on its face.
    sides: Vec<[u32; 2]>,
}

impl Turns {
    /// Looks at the faces of the corners around a point, unless they are very many.
    fn find(&mut self, corners: &Corners, fans: &Fans, fan: &[u32]) {
        self.turned.clear();
        self.size = fan.len();
        if fan.len() > MAX_PAIRED {
            return;
        }
        self.sides.clear();
        self.sides.extend(fan.iter().map(|&corner| {
            let range = range_before(&corners.ends, fans.face[corner as usize] as usize);
            let corner = corner as usize;
            let after = if corner + 1 == range.end { range.start } else { corner + 1 };
            let before = if corner == range.start { range.end - 1 } else { corner - 1 };
            [corners.point[after], corners.point[before]]
        }));
        let sides = &self.sides;
        let is_twice = |way: usize| {
            (1..sides.len()).any(|i| sides[..i].iter().any(|side| side[way] == sides[i][way]))
        };
        if !is_twice(0) && !is_twice(1) {
            return;
        }
        self.turned.resize(fan.len() * fan.len(), false);
        for from in 0..fan.len() {
            self.walk(from);
        }
    }

    /// Goes around the point from a corner, from face to face over common edges.
    fn walk(&mut self, from: usize) {
        let sides = &self.sides;
        let mut turn_of = [None; MAX_PAIRED];
        let mut queue = vec![from];
        turn_of[from] = Some(false);
        while let Some(at) = queue.pop() {
            for other in 0..sides.len() {
                if turn_of[other].is_some() {
                    continue;
                }
                let [after, before] = sides[at];
                let is_alike = sides[other][1] == after || sides[other][0] == before;
                let is_turned = sides[other][0] == after || sides[other][1] == before;
                if is_alike != is_turned {
                    turn_of[other] = turn_of[at].map(|turn: bool| turn != is_turned);
                    queue.push(other);
                }
            }
        }
        let row = &mut self.turned[from * self.size..][..self.size];
        for (turned, turn) in row.iter_mut().zip(turn_of) {
            *turned = turn.unwrap_or(false);
        }
    }

    /// Whether each face is turned over against that of one corner; empty if none is.
    fn seen_from(&self, place: usize) -> &[bool] {
        self.turned.get(place * self.size..(place + 1) * self.size).unwrap_or(&[])
    }
}

/// Fills `around` with the contributions of the faces around a point or, if there are many faces, with
/// their sums over each cell of directions.
fn gather(faces: impl ExactSizeIterator<Item = Contribution>, around: &mut Vec<Contribution>) {
    around.clear();
    if faces.len() <= MAX_PAIRED {
        around.extend(faces);
        return;
    }
    // Apart by smoothing group, of which a point has few.
    let mut cells = HashMap::<u32, _, foldhash::fast::RandomState>::default();
    let mut order = Vec::new();
    for face in faces {
        // Faces of further groups than these keep their own directions.
        if order.len() == MAX_GROUPS && !cells.contains_key(&face.smoothing) {
            continue;
        }
        let sums = cells.entry(face.smoothing).or_insert_with(|| {
            order.push(face.smoothing);
            Box::new([DVec3::ZERO; CELL_COUNT])
        });
        sums[cell_of(face.direction)] += face.vector;
    }
    for smoothing in order {
        let sums = cells[&smoothing].iter().filter_map(|&vector| {
            let direction = vector.try_normalize()?;
            Some(Contribution { direction, vector, smoothing })
        });
        around.extend(sums);
    }
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
