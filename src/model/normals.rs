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
use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use crate::angle::{arc_cosine, cosine};
use crate::model::corners::{BY_ANGLE, Corners, FLAT};
use crate::model::faces::range_before;
use crate::model::fans::Fans;
use crate::render::parallel::for_each;

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

/// So many faces are one thread's at a time.
const PART: usize = 2048;

/// What the normals at the corners of points are made from.
pub(super) struct Normals<'a> {
    corners: &'a Corners,
    fans: &'a Fans,
    /// For each corner, its face; nothing if all faces are triangles, or the file gives all normals.
    face: Vec<u32>,
    /// For each face, of length 1 or zero; nothing if the file gives all normals.
    directions: Vec<DVec3>,
    /// The cosine of the crease angle, or a little less.
    least_cosine: f64,
    /// The cosine of half of the crease angle, or a little more.
    half_cosine: f64,
}

/// The normals at a point, and the memory that they are made in.
#[derive(Default)]
pub(super) struct Memory {
    /// Of all corners at the point, in the order of the fans, of length 1.
    pub(super) normals: Vec<Vec3>,
    spokes: Vec<Spoke>,
    around: Vec<Contribution>,
    turns: Turns,
}

impl<'a> Normals<'a> {
    /// What normals are made from that are smooth where faces meet at less than the crease angle.
    pub(super) fn new(corners: &'a Corners, fans: &'a Fans, crease_angle: f32) -> Self {
        let angle = f64::from(crease_angle);
        let least_cosine = cosine(angle) - TOLERANCE;
        let half_cosine = cosine(angle / 2.0) + TOLERANCE;
        let mut normals = Self {
            corners,
            fans,
            face: Vec::new(),
            directions: Vec::new(),
            least_cosine,
            half_cosine,
        };
        let is_given = |&normal: &Vec3| normal != Vec3::ZERO;
        if corners.normal.len() < corners.point.len() || !corners.normal.iter().all(is_given) {
            normals.directions = directions(corners);
        }
        // Faces have three corners and more.
        if !normals.directions.is_empty() && corners.point.len() > 3 * corners.ends.len() {
            normals.face.reserve(corners.point.len());
            for (number, &end) in (0..).zip(&corners.ends) {
                normals.face.resize(end as usize, number);
            }
        }
        normals
    }

    /// Finds the normals at a point: those that the file gives, brought to length 1, and the others.
    pub(super) fn fill(&self, point: usize, memory: &mut Memory) {
        let Memory { normals, spokes, around, turns } = memory;
        let fan = self.fans.of(point);
        let given =
            |corner: u32| self.corners.normal.get(corner as usize).copied().unwrap_or(Vec3::ZERO);
        normals.clear();
        let is_given = |&corner: &u32| given(corner) != Vec3::ZERO;
        if self.directions.is_empty() || fan.iter().all(is_given) {
            normals.extend(fan.iter().map(|&corner| unit(given(corner)).unwrap_or(Vec3::Z)));
            return;
        }
        spokes.clear();
        spokes.extend(fan.iter().map(|&corner| self.spoke(corner as usize)));
        gather(spokes.iter().map(|spoke| self.contribution(point, spoke)), around);
        turns.find(spokes);
        let is_plain = turns.turned.is_empty() && spokes.len() <= MAX_PAIRED;
        let common = if is_plain { self.common(around) } else { None };
        let mut means = Means { around, least_cosine: self.least_cosine, last: None };
        for (place, &corner) in fan.iter().enumerate() {
            let given = given(corner);
            let given = if given == Vec3::ZERO { None } else { unit(given) };
            normals.push(given.or(common).unwrap_or_else(|| {
                let face = spokes[place].face;
                let own = (self.directions[face], self.corners.smoothing[face]);
                means.smooth(own, turns.seen_from(place)).as_vec3()
            }));
        }
    }

    /// The normal that all corners have at a point where any two faces meet at less than the crease angle: no face
    /// is farther than half of it from the middle of all directions.
    fn common(&self, around: &[Contribution]) -> Option<Vec3> {
        let middle = around.iter().map(|face| face.direction).sum::<DVec3>().try_normalize()?;
        let is_near = |face: &Contribution| {
            face.smoothing == BY_ANGLE && face.direction.dot(middle) >= self.half_cosine
        };
        if !around.iter().all(is_near) {
            return None;
        }
        let sum: DVec3 = around.iter().map(|face| face.vector).sum();
        sum.try_normalize().map(DVec3::as_vec3)
    }

    fn spoke(&self, corner: usize) -> Spoke {
        let face = self.face.get(corner).map_or(corner / 3, |&face| face as usize);
        let corners = self.corners;
        let range = range_before(&corners.ends, face);
        let after = if corner + 1 == range.end { range.start } else { corner + 1 };
        let before = if corner == range.start { range.end - 1 } else { corner - 1 };
        Spoke { face, sides: [corners.point[after], corners.point[before]] }
    }

    /// What a face adds to normals at a point: its direction by its angle there.
    fn contribution(&self, point: usize, spoke: &Spoke) -> Contribution {
        let position = |point: u32| self.corners.points[point as usize].as_dvec3();
        let (at, direction) = (position(point as u32), self.directions[spoke.face]);
        let [after, before] = spoke.sides.map(position);
        // In the precision that is plenty for a weight.
        let angle = f64::from(angle(after - at, before - at, direction) as f32);
        let smoothing = self.corners.smoothing[spoke.face];
        Contribution { direction, vector: direction * angle, smoothing }
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

/// The normals at a point.
struct Means<'a> {
    around: &'a [Contribution],
    least_cosine: f64,
    /// The faces of the last mean, a bit each, and the mean. Corners of a smooth surface have the same.
    last: Option<(u64, DVec3)>,
}

impl Means<'_> {
    /// The mean, with length 1, of the contributions that are smooth with the face of direction `own`:
    /// those of its group, or those within the crease angle.
    ///
    /// A face without an area has no direction and takes the mean of all. Where that is zero too, any
    /// normal is as good. `turned` says of each contribution whether it is turned over against the face.
    fn smooth(&mut self, (own, smoothing): (DVec3, u32), turned: &[bool]) -> DVec3 {
        let Self { around, least_cosine, .. } = *self;
        let is_turned = |place| own != DVec3::ZERO && turned.get(place) == Some(&true);
        let sign = |place: usize| if is_turned(place) { -1.0 } else { 1.0 };
        let is_smooth = |place: usize, face: &Contribution| match smoothing {
            _ if own == DVec3::ZERO => true,
            FLAT => false,
            BY_ANGLE => {
                face.smoothing == BY_ANGLE && sign(place) * own.dot(face.direction) >= least_cosine
            }
            group => face.smoothing == group,
        };
        let mean = |is_smooth: &dyn Fn(usize, &Contribution) -> bool| {
            let faces = around.iter().enumerate().filter(|&(place, face)| is_smooth(place, face));
            let sum: DVec3 = faces.map(|(place, face)| face.vector * sign(place)).sum();
            sum.try_normalize()
        };
        let without = if own == DVec3::ZERO { DVec3::Z } else { own };
        if !turned.is_empty() || around.len() > u64::BITS as usize {
            return mean(&is_smooth).unwrap_or(without);
        }
        let faces = around.iter().enumerate();
        let bits =
            faces.fold(0, |bits, (place, face)| bits | u64::from(is_smooth(place, face)) << place);
        if self.last.is_none_or(|(last, _)| last != bits) {
            self.last = mean(&|place, _| bits >> place & 1 != 0).map(|mean| (bits, mean));
        }
        self.last.map_or(without, |(_, mean)| mean)
    }
}

/// Which of the faces around a point are turned over against each other.
#[derive(Default)]
struct Turns {
    /// For each corner of a fan whether its face is turned over, seen from each: rows of a square, or
    /// nothing if none is.
    turned: Vec<bool>,
    size: usize,
}

impl Turns {
    /// Looks at the faces around a point, unless they are very many.
    fn find(&mut self, spokes: &[Spoke]) {
        self.turned.clear();
        self.size = spokes.len();
        if spokes.len() > MAX_PAIRED {
            return;
        }
        let is_twice = |way: usize| {
            let side = |spoke: &Spoke| spoke.sides[way];
            (1..spokes.len()).any(|i| spokes[..i].iter().any(|it| side(it) == side(&spokes[i])))
        };
        if !is_twice(0) && !is_twice(1) {
            return;
        }
        self.turned.resize(spokes.len() * spokes.len(), false);
        for from in 0..spokes.len() {
            self.walk(from, spokes);
        }
    }

    /// Goes around the point from a corner, from face to face over common edges.
    fn walk(&mut self, from: usize, spokes: &[Spoke]) {
        let sides = |place: usize| spokes[place].sides;
        let mut turn_of = [None; MAX_PAIRED];
        let mut queue = vec![from];
        turn_of[from] = Some(false);
        while let Some(at) = queue.pop() {
            for other in 0..spokes.len() {
                if turn_of[other].is_some() {
                    continue;
                }
                let ([after, before], others) = (sides(at), sides(other));
                let is_alike = others[1] == after || others[0] == before;
                let is_turned = others[0] == after || others[1] == before;
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

/// A corner of a face at a point.
struct Spoke {
    face: usize,
    /// The points after and before it on its face.
    sides: [u32; 2],
}

/// For each face the direction of its front, of length 1 or zero.
fn directions(corners: &Corners) -> Vec<DVec3> {
    let mut directions = vec![DVec3::ZERO; corners.ends.len()];
    let mut parts: Vec<_> = directions.chunks_mut(PART).collect();
    for_each(&mut parts, |part, directions| {
        let mut positions = Vec::new();
        for (face, direction) in (part * PART..).zip(directions.iter_mut()) {
            let points = &corners.point[range_before(&corners.ends, face)];
            positions.clear();
            positions.extend(points.iter().map(|&point| corners.points[point as usize].as_dvec3()));
            *direction = newell(&positions);
        }
    });
    directions
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
    // Sides of `f32` numbers neither overflow nor vanish so.
    let lengths = (a.length_squared() * b.length_squared()).sqrt();
    if lengths == 0.0 {
        return 0.0;
    }
    let least = arc_cosine(a.dot(b) / lengths);
    if a.cross(b).dot(normal) < 0.0 { TAU - least } else { least }
}
