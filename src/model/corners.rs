//! The face corners of a file, and how equal ones become one vertex.
//!
//! A loader adds points, corners, faces and materials in the order of its file. Corners that agree in
//! point, texture coordinate and normal then share a vertex.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::model::faces::{FacesByMaterial, range_before};
use crate::model::vertex::ModelVertex;

/// All face corners of a model, one after the other, before equal ones are joined.
#[derive(Default)]
pub(crate) struct Corners {
    /// Positions, each once even if the file repeats it: faces that have one in common meet there.
    pub(super) points: Vec<Vec3>,
    /// Which point has a position of these bits.
    point_of: HashMap<[u32; 3], u32>,
    /// For each corner, its point.
    pub(super) point: Vec<u32>,
    /// For each corner, its texture coordinate with v up; NaN where the file gives none.
    uv: Vec<Vec2>,
    /// For each corner, its normal of any length; zero where the file gives none.
    pub(super) normal: Vec<Vec3>,
    /// Where the corners of each face end.
    pub(super) ends: Vec<u32>,
    /// Where the faces of each material end in `ends`.
    material_ends: Vec<u32>,
}

impl Corners {
    /// The point at a position. It is added unless there is one.
    pub(crate) fn point_at(&mut self, position: Vec3) -> u32 {
        let next = self.points.len() as u32;
        let index = *self.point_of.entry(bits(position)).or_insert(next);
        if index == next {
            self.points.push(position);
        }
        index
    }

    /// Makes room for so many more corners and faces.
    pub(crate) fn reserve(&mut self, corners: usize, faces: usize) {
        self.point.reserve(corners);
        self.uv.reserve(corners);
        self.normal.reserve(corners);
        self.ends.reserve(faces);
    }

    /// Adds a corner to the face that is being read.
    ///
    /// Texture coordinates have v up here; NaN stands for none. Normals may have any length; zero
    /// stands for none.
    pub(crate) fn push(&mut self, point: u32, uv: Vec2, normal: Vec3) {
        self.point.push(point);
        self.uv.push(uv);
        self.normal.push(normal);
    }

    /// Makes a face of the corners added since the last one.
    pub(crate) fn end_face(&mut self) {
        self.ends.push(self.point.len() as u32);
    }

    /// Gives the faces added since the last call the next material.
    pub(crate) fn end_material(&mut self) {
        self.material_ends.push(self.ends.len() as u32);
    }

    /// Joins all corners that are alike into one vertex each.
    pub(super) fn into_shared(self) -> (Vec<ModelVertex>, FacesByMaterial) {
        let mut vertices = Vec::new();
        let mut vertex_of = HashMap::new();
        let has_uv = (0..self.ends.len())
            .map(|face| !self.uv[range_before(&self.ends, face)].iter().any(|uv| uv.is_nan()))
            .collect();
        let indices = (self.point.iter().zip(&self.uv).zip(&self.normal))
            .map(|((&point, &uv), &normal)| {
                let uv = if uv.is_nan() { Vec2::ZERO } else { Vec2::new(uv.x, 1.0 - uv.y) };
                let next = vertices.len() as u32;
                *vertex_of.entry((point, bits(uv.extend(0.0)), bits(normal))).or_insert_with(|| {
                    let position = self.points[point as usize];
                    vertices.push(ModelVertex { position, normal, uv });
                    next
                })
            })
            .collect();
        let Self { ends, material_ends, .. } = self;
        (vertices, FacesByMaterial { indices, ends, has_uv, material_ends })
    }
}

/// A key that is equal for equal vectors: adding 0 makes the two zeros one.
fn bits(v: Vec3) -> [u32; 3] {
    (v + 0.0).to_array().map(f32::to_bits)
}
