//! The face corners of a file.
//!
//! A loader adds points, corners, faces and materials in the order of its file.

use std::hash::BuildHasher as _;

use foldhash::fast::RandomState;
use glam::{DVec3, Vec2, Vec3, Vec4};
use hashbrown::HashTable;

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
    pub(super) uv: Vec<Vec2>,
    /// For each corner, its normal of any length; zero, or beyond the end, where the file gives none.
    pub(super) normal: Vec<Vec3>,
    /// For each corner its colour, or nothing at all if the file has no colours.
    pub(super) color: Vec<Vec4>,
    /// For each corner its tangent, as a vertex has it; zero, or beyond the end, where the file gives none.
    pub(super) tangent: Vec<Vec4>,
    /// Where the corners of each face end.
    pub(super) ends: Vec<u32>,
    /// For each face its smoothing group, from 1 on; [`FLAT`]; or [`BY_ANGLE`].
    pub(super) smoothing: Vec<u32>,
    /// Where the faces of each material end in `ends`.
    pub(super) material_ends: Vec<u32>,
}

impl Corners {
    /// Corners whose positions are relative to `origin`.
    pub(crate) fn around(origin: DVec3) -> Self {
        Self { origin, ..Self::default() }
    }

    /// The point at a position of the file. It is added unless there is one.
    #[cfg(any(feature = "obj", feature = "ply", feature = "gltf"))]
    pub(crate) fn point_at(&mut self, position: DVec3) -> u32 {
        self.point_near((position - self.origin).as_vec3())
    }

    /// The point at a position relative to the origin. It is added unless there is one.
    pub(crate) fn point_near(&mut self, position: Vec3) -> u32 {
        // Adding 0 makes the two zeros one.
        let position = position + 0.0;
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

    /// Takes the origin of all points off them, where they are far from that of the file. No more points may be
    /// added after it.
    #[cfg(feature = "stl")]
    pub(crate) fn recentre(&mut self) {
        let middle = origin(self.points.iter().map(|point| point.as_dvec3()));
        if middle != DVec3::ZERO {
            for point in &mut self.points {
                *point = (point.as_dvec3() - middle).as_vec3();
            }
            self.origin += middle;
        }
    }

    /// Whether there are no faces.
    #[cfg(feature = "stl")]
    pub(crate) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Makes room for so many more corners and faces.
    pub(crate) fn reserve(&mut self, corners: usize, faces: usize) {
        self.point.reserve(corners);
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
        if normal != Vec3::ZERO {
            self.normal.resize(self.point.len(), Vec3::ZERO);
            self.normal.push(normal);
        }
        self.point.push(point);
    }

    /// Gives the corner added last a colour: linear light, not multiplied by the alpha in `w`. In a model
    /// with colours every corner has one.
    #[cfg(any(feature = "obj", feature = "ply", feature = "gltf"))]
    pub(crate) fn color(&mut self, color: Vec4) {
        self.color.push(color);
    }

    /// Gives the corner added last a tangent, of length 1 across its normal, with the sign of the bitangent in `w`; zero
    /// stands for none.
    #[cfg(feature = "gltf")]
    pub(crate) fn tangent(&mut self, tangent: Vec4) {
        self.tangent.resize(self.point.len() - 1, Vec4::ZERO);
        self.tangent.push(tangent);
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
