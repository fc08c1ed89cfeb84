//! The face corners of a file, and how equal ones become one vertex.
//!
//! A loader adds points, corners, faces and materials in the order of its file. Corners that agree in
//! point, texture coordinate, normal and colour then share a vertex.

use std::collections::HashMap;
use std::hash::BuildHasher as _;

use foldhash::fast::RandomState;
use glam::{DVec3, Vec2, Vec3, Vec4};
use hashbrown::HashTable;

use crate::model::faces::{FacesByMaterial, range_before};
use crate::model::vertex::ModelVertex;

/// The smoothing of a face whose computed normals are smooth where it meets others at less than the
/// crease angle.
pub(crate) const BY_ANGLE: u32 = u32::MAX;

/// The smoothing of a face whose computed normals are its own.
pub(crate) const FLAT: u32 = 0;

/// All face corners of a model, one after the other, before equal ones are joined.
#[derive(Default)]
pub(crate) struct Corners {
    /// What has been taken off all positions.
    pub(super) origin: DVec3,
    /// Positions, each once even if the file repeats it: faces that have one in common meet there.
    pub(super) points: Vec<Vec3>,
    /// The points, found by the bits of their positions.
    point_of: HashTable<u32>,
    hasher: RandomState,
    /// For each corner, its point.
    pub(super) point: Vec<u32>,
    /// For each corner, its texture coordinate with v up; NaN, or beyond the end, where the file gives none.
    uv: Vec<Vec2>,
    /// For each corner, its normal of any length; zero where the file gives none.
    pub(super) normal: Vec<Vec3>,
    /// For each corner its colour, or nothing at all if the file has no colours.
    color: Vec<Vec4>,
    /// Where the corners of each face end.
    pub(super) ends: Vec<u32>,
    /// For each face its smoothing group, from 1 on; [`FLAT`]; or [`BY_ANGLE`].
    pub(super) smoothing: Vec<u32>,
    /// Where the faces of each material end in `ends`.
    material_ends: Vec<u32>,
}

impl Corners {
    /// Corners whose positions are relative to `origin`.
    pub(crate) fn around(origin: DVec3) -> Self {
        Self { origin, ..Self::default() }
    }

    /// The point at a position of the file. It is added unless there is one.
    pub(crate) fn point_at(&mut self, position: DVec3) -> u32 {
        // Adding 0 makes the two zeros one.
        let position = (position - self.origin).as_vec3() + 0.0;
        let Self { points, point_of, hasher, .. } = self;
        let hash = |position: Vec3| {
            let [x, y, z] = position.to_array().map(f32::to_bits);
            hasher.hash_one((u64::from(x) << 32 | u64::from(y), z))
        };
        let next = points.len() as u32;
        let is_same = |&index: &u32| points[index as usize] == position;
        let entry = point_of.entry(hash(position), is_same, |&index| hash(points[index as usize]));
        let index = *entry.or_insert(next).get();
        if index == next {
            points.push(position);
        }
        index
    }

    /// Makes room for so many more corners and faces.
    pub(crate) fn reserve(&mut self, corners: usize, faces: usize) {
        self.point.reserve(corners);
        self.normal.reserve(corners);
        self.ends.reserve(faces);
        self.smoothing.reserve(faces);
    }

    /// Adds a corner to the face that is being read.
    ///
    /// Texture coordinates have v up here; NaN stands for none. Normals may have any length; zero
    /// stands for none.
    pub(crate) fn push(&mut self, point: u32, uv: Vec2, normal: Vec3) {
        if !uv.is_nan() {
            self.uv.resize(self.point.len(), Vec2::NAN);
            self.uv.push(uv);
        }
        self.point.push(point);
        self.normal.push(normal);
    }

    /// Gives the corner added last a colour: linear light, not multiplied by the alpha in `w`. In a model
    /// with colours every corner has one.
    pub(crate) fn color(&mut self, color: Vec4) {
        self.color.push(color);
    }

    /// Makes a face of the corners added since the last one.
    pub(crate) fn end_face(&mut self, smoothing: u32) {
        self.ends.push(self.point.len() as u32);
        self.smoothing.push(smoothing);
    }

    /// Gives the faces added since the last call the next material.
    pub(crate) fn end_material(&mut self) {
        self.material_ends.push(self.ends.len() as u32);
    }

    /// Joins all corners that are alike into one vertex each.
    pub(super) fn into_shared(self) -> (Vec<ModelVertex>, FacesByMaterial) {
        let uv_of = |corner: usize| self.uv.get(corner).copied().unwrap_or(Vec2::NAN);
        let has_uv = (0..self.ends.len())
            .map(|face| !range_before(&self.ends, face).any(|corner| uv_of(corner).is_nan()))
            .collect();
        let mut joiner = Joiner::new(self.points.len());
        let indices = (self.point.iter().zip(&self.normal).enumerate())
            .map(|(corner, (&point, &normal))| {
                let uv = uv_of(corner);
                let uv = if uv.is_nan() { Vec2::ZERO } else { Vec2::new(uv.x, 1.0 - uv.y) };
                let color = self.color.get(corner).copied().unwrap_or(Vec4::ONE);
                let position = self.points[point as usize];
                joiner.index_of(point, ModelVertex { position, normal, uv, color })
            })
            .collect();
        let Self { ends, material_ends, .. } = self;
        (joiner.vertices, FacesByMaterial { indices, ends, has_uv, material_ends })
    }
}

/// Positions farther from the origin than this many times their extent are brought near. At that
/// distance, `f32` still tells 2^20 places across the model apart.
const FAR: f64 = 16.0;

/// What is taken off positions: zero, or for a model far away a place in it, rounded so that the
/// difference needs no more bits than the position has.
pub(crate) fn origin(mut positions: impl Iterator<Item = DVec3>) -> DVec3 {
    let Some(first) = positions.next() else { return DVec3::ZERO };
    let (low, high) = positions.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    let extent = (high - low).max_element();
    let farthest = low.abs().max(high.abs()).max_element();
    if farthest <= FAR * extent || extent <= 0.0 {
        return DVec3::ZERO;
    }
    // The power of two at or below the extent.
    let unit = f64::from_bits(extent.to_bits() & 0x7ff0_0000_0000_0000);
    let middle = low + (high - low) / 2.0;
    (middle / unit).round() * unit
}

/// No vertex.
const NONE: u32 = u32::MAX;

/// Up to this many vertices of a point are compared one by one; points of real meshes have one to six.
const MAX_COMPARED: usize = 16;

/// Finds the vertices that are alike: those of a point one by one, and those of a point that has very
/// many by a table.
struct Joiner {
    vertices: Vec<ModelVertex>,
    /// For each point its first vertex.
    first: Vec<u32>,
    /// For each vertex the next one of its point.
    next: Vec<u32>,
    /// The vertices that come after the first ones of their points.
    others: HashMap<(u32, [u32; 9]), u32, RandomState>,
}

impl Joiner {
    fn new(points: usize) -> Self {
        let first = vec![NONE; points];
        let (vertices, next) = (Vec::with_capacity(points), Vec::with_capacity(points));
        Self { vertices, first, next, others: HashMap::default() }
    }

    /// The index of a vertex of a point, which is added unless it is there.
    fn index_of(&mut self, point: u32, vertex: ModelVertex) -> u32 {
        let mut before = NONE;
        let mut index = self.first[point as usize];
        for _ in 0..MAX_COMPARED {
            if index == NONE {
                let added = self.add(vertex);
                match before {
                    NONE => self.first[point as usize] = added,
                    before => self.next[before as usize] = added,
                }
                return added;
            }
            // As numbers, which makes the two zeros equal; none of them is NaN.
            let other = &self.vertices[index as usize];
            if (other.normal, other.uv, other.color) == (vertex.normal, vertex.uv, vertex.color) {
                return index;
            }
            before = index;
            index = self.next[index as usize];
        }
        let ModelVertex { normal, uv, color, .. } = vertex;
        let [nx, ny, nz] = bits(normal);
        let [u, v, _] = bits(uv.extend(0.0));
        let [r, g, b, a] = color.to_array().map(|channel| (channel + 0.0).to_bits());
        let key = (point, [nx, ny, nz, u, v, r, g, b, a]);
        if let Some(&index) = self.others.get(&key) {
            return index;
        }
        let index = self.add(vertex);
        self.others.insert(key, index);
        index
    }

    fn add(&mut self, vertex: ModelVertex) -> u32 {
        let index = self.vertices.len() as u32;
        self.vertices.push(vertex);
        self.next.push(NONE);
        index
    }
}

/// A key that is equal for equal vectors: adding 0 makes the two zeros one.
fn bits(v: Vec3) -> [u32; 3] {
    (v + 0.0).to_array().map(f32::to_bits)
}
