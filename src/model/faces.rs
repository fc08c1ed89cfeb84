//! Faces of any number of sides, sorted by material.

use crate::render::FaceIndices;
use std::ops::Range;

/// A polygon of a [`Model`](crate::Model).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Face<'a> {
    /// At least three indices into [`Model::vertices`](crate::Model::vertices), counter-clockwise seen
    /// from outside.
    pub indices: &'a [u32],
    /// Index into [`Model::materials`](crate::Model::materials).
    pub material: usize,
    /// Whether the file gives a texture coordinate at every corner.
    pub has_uv: bool,
    /// The number of the face among [`Model::faces`](crate::Model::faces), or of that of which it is a part in a
    /// model that [`displaced`](crate::Model::displaced) has made.
    pub source: usize,
}

/// The indices, so that functions which draw lists of indices accept faces as they are.
impl FaceIndices for Face<'_> {
    fn indices(&self) -> &[u32] {
        self.indices
    }
}

/// All faces of a model, with their indices end to end in one list.
#[derive(Clone, Debug, Default)]
pub(super) struct FacesByMaterial {
    pub(super) indices: Vec<u32>,
    /// Where the indices of each face end; they begin where those of the face before end.
    pub(super) ends: Vec<u32>,
    /// For each face, [`Face::has_uv`].
    pub(super) has_uv: Vec<bool>,
    /// For each face, [`Face::source`]; nothing if that is its own number.
    pub(super) sources: Vec<u32>,
    /// Where the faces of each material end in `ends`.
    pub(super) material_ends: Vec<u32>,
}

impl FacesByMaterial {
    /// Number of faces.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// All faces, material by material.
    pub(super) fn iter(&self) -> impl Iterator<Item = Face<'_>> + Clone {
        (0..self.material_ends.len()).flat_map(|material| self.of_material(material))
    }

    /// The faces of one material; none for a material that does not exist.
    pub(super) fn of_material(&self, material: usize) -> impl Iterator<Item = Face<'_>> + Clone {
        let faces = if material < self.material_ends.len() {
            range_before(&self.material_ends, material)
        } else {
            0..0
        };
        faces.map(move |face| Face {
            indices: &self.indices[range_before(&self.ends, face)],
            material,
            has_uv: self.has_uv[face],
            source: self.sources.get(face).map_or(face, |&source| source as usize),
        })
    }
}

/// The range of part `i` of a list that is cut into parts at `ends`.
pub(super) fn range_before(ends: &[u32], i: usize) -> Range<usize> {
    let start = if i == 0 { 0 } else { ends[i - 1] };
    start as usize..ends[i] as usize
}
