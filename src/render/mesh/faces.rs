//! The faces of a mesh as they are drawn: as many at a time as are shared out.

use std::ops::Range;

use crate::number::TRIANGLES;

/// Faces drawn at a time: enough to share among processors, and a bound for the memory.
const BATCH: usize = 1 << 20;

/// Lists of indices, end to end.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    /// The number of the first in the mesh.
    pub(super) first: u32,
    pub(super) len: usize,
    indices: Vec<u32>,
    /// Where each ends; empty if all are triangles.
    ends: Vec<u32>,
}

impl Faces {
    /// Begins with the first face of a mesh.
    pub(super) fn restart(&mut self) {
        (self.first, self.len) = (0, 0);
    }

    /// Takes the next faces, as many as are drawn at a time; whether there were any.
    pub(super) fn collect<F: AsRef<[u32]>>(&mut self, faces: &mut impl Iterator<Item = F>) -> bool {
        self.first = self.first.wrapping_add(self.len as u32);
        self.indices.clear();
        self.ends.clear();
        let mut len = 0;
        while len < BATCH && self.indices.len() < 4 * BATCH {
            let Some(face) = faces.next() else { break };
            match face.as_ref() {
                triangle @ [_, _, _] if self.ends.is_empty() => self.indices.extend(triangle),
                face => self.push(len, face),
            }
            len += 1;
        }
        self.len = len;
        len > 0
    }

    /// Takes a face where not all are triangles, after `len` others.
    fn push(&mut self, len: usize, face: &[u32]) {
        if self.ends.is_empty() {
            self.ends.extend((1..=len).map(|len| 3 * len as u32));
        }
        // A face of 2^32 corners and more is none that could be drawn.
        if u32::try_from(self.indices.len().saturating_add(face.len())).is_ok() {
            self.indices.extend_from_slice(face);
        }
        self.ends.push(self.indices.len() as u32);
    }

    /// Eight faces, if all are triangles.
    #[inline(always)]
    pub(super) fn triangles(&self, faces: Range<usize>) -> Option<&[[u32; 3]; TRIANGLES]> {
        if faces.len() != TRIANGLES {
            return None;
        }
        let mut first = 3 * faces.start;
        if !self.ends.is_empty() {
            first = self.start(faces.start);
            let are_triangles = |(end, len): (&u32, usize)| *end as usize == first + 3 * len;
            if !self.ends[faces].iter().zip(1..).all(are_triangles) {
                return None;
            }
        }
        self.indices.get(first..)?.as_chunks().0.first_chunk()
    }

    pub(super) fn get(&self, face: usize) -> &[u32] {
        if self.ends.is_empty() {
            return &self.indices[3 * face..3 * face + 3];
        }
        &self.indices[self.start(face)..self.ends[face] as usize]
    }

    /// Where a face begins, where not all are triangles.
    fn start(&self, face: usize) -> usize {
        face.checked_sub(1).map_or(0, |before| self.ends[before] as usize)
    }
}
