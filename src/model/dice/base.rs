//! The first net: the faces of a model that have heights, and those beside them, as triangles.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use glam::{DVec3, Vec3};

use crate::angle::arc_cosine;
use crate::model::Model;
use crate::model::dice::cut::triangles;
use crate::model::dice::heights::Heights;
use crate::model::dice::net::{Corner, Cut, Edge, NO_HEIGHTS, Net, Point, Triangle};
use crate::model::faces::Face;
use crate::model::vertex::ModelVertex;
use crate::tangent::{PictureAxes, TangentVertex};

/// The first net, and which faces are in it.
pub(super) struct Base {
    pub(super) net: Net,
    /// For each face of the model, in their order.
    pub(super) is_in_net: Vec<bool>,
}

/// What the faces have to do with the net.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// They are diced.
    Diced,
    /// They share an edge with those that are.
    Beside,
    None,
}

/// What is known of a line between two points.
#[derive(Clone, Copy, Default)]
struct Line {
    /// The edges that it has for faces of different corners.
    edges: u32,
    /// Whether a face without heights has it.
    is_fixed: bool,
}

/// Two numbers, the lower one first.
type Pair = (u32, u32);

fn pair(a: u32, b: u32) -> Pair {
    (a.min(b), a.max(b))
}

/// The net while it is made.
#[derive(Default)]
struct Builder {
    net: Net,
    /// By the bits of positions.
    points: HashMap<[u32; 3], u32, RandomState>,
    /// For each point, its normals.
    normals: Vec<PointNormals>,
    lines: HashMap<Pair, Line, RandomState>,
    /// By vertex, material, and whether the picture is mirrored.
    corners: HashMap<(u32, u32, bool), u32, RandomState>,
    /// For each corner, the integral of its axes over the faces' parts of the picture.
    axes: Vec<([DVec3; 2], f64)>,
    edges: HashMap<Pair, u32, RandomState>,
}

/// The normals of the faces at a point.
#[derive(Clone, Copy, Default)]
struct PointNormals {
    /// By the angles of the faces.
    sum: DVec3,
    first: Vec3,
    is_mixed: bool,
}

impl Base {
    /// The net of a model; `None` if no face has heights.
    pub(super) fn of(model: &Model, heights: &Heights<'_>) -> Option<Self> {
        let is_finite = |face: &Face<'_>| {
            let vertex = |index: u32| model.vertices.get(index as usize);
            face.indices.iter().all(|&index| vertex(index).is_some_and(is_finite))
        };
        let is_diced =
            |face: &Face<'_>| heights.has(face.material) && face.has_uv && is_finite(face);
        if !model.faces().any(|face| is_diced(&face)) {
            return None;
        }
        let mut builder = Builder::default();
        for face in model.faces().filter(is_diced) {
            builder.add_lines(model, &face);
        }
        let part = |face: Face<'_>| match () {
            () if is_diced(&face) => Part::Diced,
            () if is_finite(&face) && builder.fix(model, &face) => Part::Beside,
            () => Part::None,
        };
        let parts: Vec<_> = model.faces().map(part).collect();
        for (number, (face, part)) in model.faces().zip(&parts).enumerate() {
            match part {
                Part::Diced => builder.add_diced(model, &face, number as u32),
                Part::Beside => builder.add_beside(model, &face, number as u32),
                Part::None => {}
            }
        }
        let is_in_net = parts.iter().map(|&part| part != Part::None).collect();
        Some(Self { net: builder.finish(), is_in_net })
    }
}

fn is_finite(vertex: &ModelVertex) -> bool {
    vertex.position.is_finite() && vertex.normal.is_finite() && vertex.uv.is_finite()
}

/// A key that is equal for equal positions: adding 0 makes the two zeros one.
fn key(position: Vec3) -> [u32; 3] {
    (position + 0.0).to_array().map(f32::to_bits)
}

/// The sides of a face, by the points at its corners.
fn sides(points: &[u32]) -> impl Iterator<Item = Pair> {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(&a, &b)| pair(a, b))
}

impl Builder {
    /// Adds the points and the sides of a face that is diced.
    fn add_lines(&mut self, model: &Model, face: &Face<'_>) {
        let Self { net, points, normals, lines, .. } = self;
        let point_at = |&index: &u32| {
            let position = model.vertices[index as usize].position;
            *points.entry(key(position)).or_insert_with(|| {
                net.points.push(Point { base: position, moved: position, ..Point::default() });
                normals.push(PointNormals::default());
                net.points.len() as u32 - 1
            })
        };
        let points: Vec<_> = face.indices.iter().map(point_at).collect();
        for side in sides(&points) {
            lines.entry(side).or_default();
        }
    }

    /// The point of a vertex, if there is one.
    fn point_of(&self, model: &Model, index: u32) -> Option<u32> {
        self.points.get(&key(model.vertices[index as usize].position)).copied()
    }

    /// Holds the points and sides that a face without heights shares with others; whether it shares a side.
    fn fix(&mut self, model: &Model, face: &Face<'_>) -> bool {
        // No point has the last number.
        let points = face.indices.iter().map(|&index| self.point_of(model, index));
        let points: Vec<_> = points.map(|point| point.unwrap_or(u32::MAX)).collect();
        for &point in &points {
            if let Some(point) = self.net.points.get_mut(point as usize) {
                point.is_fixed = true;
            }
        }
        let mut is_beside = false;
        for side in sides(&points) {
            if let Some(line) = self.lines.get_mut(&side) {
                line.is_fixed = true;
                is_beside = true;
            }
        }
        is_beside
    }

    /// Adds the triangles of a face with heights.
    fn add_diced(&mut self, model: &Model, face: &Face<'_>, number: u32) {
        let vertices = face.indices.iter().map(|&index| model.vertices[index as usize]);
        let plain: Vec<_> = vertices
            .map(|v| TangentVertex { position: v.position, normal: v.normal, uv: v.uv })
            .collect();
        let axes = PictureAxes::of(&plain);
        let mut corners = Vec::with_capacity(plain.len());
        for (i, &index) in face.indices.iter().enumerate() {
            let normal = plain[i].normal.as_dvec3();
            let is_mirrored = axes.as_ref().is_some_and(|axes| axes.is_mirrored(normal));
            let corner = self.corner(model, (index, face.material as u32, is_mirrored));
            if let Some(PictureAxes { u, up, area }) = &axes {
                let (sums, all) = &mut self.axes[corner as usize];
                *sums = [sums[0] + *u, sums[1] - *up];
                *all += area.abs();
            }
            corners.push(corner);
            let at = |i: usize| plain[i % plain.len()].position.as_dvec3();
            let [before, after] = [i + plain.len() - 1, i + 1].map(|other| at(other) - at(i));
            let cosine = before.normalize_or_zero().dot(after.normalize_or_zero());
            let point = self.net.corners[corner as usize].point as usize;
            self.normals[point].add(plain[i].normal, arc_cosine(cosine));
        }
        self.add_triangles(&corners, number, true);
    }

    /// Adds the triangles of a face that has no heights.
    fn add_beside(&mut self, model: &Model, face: &Face<'_>, number: u32) {
        let corner = |&index: &u32| self.corner(model, (index, NO_HEIGHTS, false));
        let corners: Vec<_> = face.indices.iter().map(corner).collect();
        self.add_triangles(&corners, number, false);
    }

    /// The number of a corner, which is added unless it is there.
    fn corner(&mut self, model: &Model, key: (u32, u32, bool)) -> u32 {
        if let Some(&corner) = self.corners.get(&key) {
            return corner;
        }
        let vertex = model.vertices[key.0 as usize];
        let point = self.point_of(model, key.0).unwrap_or_else(|| {
            let (base, moved) = (vertex.position, vertex.position);
            self.points.insert(self::key(base), self.net.points.len() as u32);
            self.net.points.push(Point { base, moved, is_fixed: true, ..Point::default() });
            self.normals.push(PointNormals::default());
            self.net.points.len() as u32 - 1
        });
        self.net.corners.push(Corner { vertex, axes: [Vec3::ZERO; 2], point, material: key.1 });
        self.axes.push(Default::default());
        let corner = self.net.corners.len() as u32 - 1;
        self.corners.insert(key, corner);
        corner
    }

    fn add_triangles(&mut self, corners: &[u32], face: u32, is_seen: bool) {
        let base = |&corner: &u32| {
            self.net.points[self.net.corners[corner as usize].point as usize].base.as_dvec3()
        };
        let polygon: Vec<_> = corners.iter().map(base).collect();
        for triangle in triangles(&polygon) {
            let corners = triangle.map(|place| corners[place]);
            let [a, b, c] = corners;
            let edges = [(a, b), (b, c), (c, a)].map(|(a, b)| self.edge(a, b));
            self.net.waiting.push(Triangle { corners, edges, face, is_seen });
        }
    }

    /// The number of an edge, which is added unless it is there.
    fn edge(&mut self, a: u32, b: u32) -> u32 {
        let Self { net, edges, lines, .. } = self;
        *edges.entry(pair(a, b)).or_insert_with(|| {
            let ends = [a, b];
            let points = ends.map(|corner| net.corners[corner as usize].point);
            lines.entry(pair(points[0], points[1])).or_default().edges += 1;
            net.edges.push(Edge { ends, cut: Cut::No, is_seam: false, is_fixed: false });
            net.edges.len() as u32 - 1
        })
    }

    fn finish(self) -> Net {
        let Self { mut net, normals, lines, axes, .. } = self;
        for (corner, (sums, area)) in net.corners.iter_mut().zip(axes) {
            if area > 0.0 {
                corner.axes = sums.map(|sum| (sum / area).as_vec3());
            }
        }
        for (point, normals) in net.points.iter_mut().zip(normals) {
            point.direction = normals.mean();
        }
        for edge in &mut net.edges {
            let [a, b] = edge.ends.map(|corner| net.corners[corner as usize].point);
            let line = lines.get(&pair(a, b)).copied().unwrap_or_default();
            (edge.is_seam, edge.is_fixed) = (line.edges > 1, line.is_fixed);
        }
        net
    }
}

impl PointNormals {
    fn add(&mut self, normal: Vec3, angle: f64) {
        if self.sum == DVec3::ZERO && !self.is_mixed {
            self.first = normal;
        }
        self.is_mixed |= self.first != normal;
        self.sum += normal.as_dvec3() * angle;
    }

    /// The normal that all have, to the bit, or the direction of the mean.
    fn mean(&self) -> Vec3 {
        if self.is_mixed { self.sum.normalize_or_zero().as_vec3() } else { self.first }
    }
}
