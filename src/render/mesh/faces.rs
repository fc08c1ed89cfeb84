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

#[cfg(test)]
mod tests {
    use super::{Faces, TRIANGLES};

    /// Faces of so many corners each, no two with the same indices.
    fn faces(corners: &[u32]) -> Vec<Vec<u32>> {
        let mut next = 0;
        let mut face = |corners: &u32| {
            next += corners;
            (next - corners..next).collect()
        };
        corners.iter().map(&mut face).collect()
    }

    #[test]
    fn eight_faces_are_triangles_only_if_each_is() {
        // As many corners as eight triangles have, but not in each; and others later and earlier.
        let lists: [&[u32]; 7] = [
            &[3; 16],
            &[3, 3, 3, 4, 2, 3, 3, 3],
            &[2, 4, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3],
            &[3, 3, 3, 3, 3, 3, 3, 3, 3, 5, 3],
            &[0, 3, 3, 3, 3, 3, 3, 3, 3, 1],
            &[6, 0, 3, 3, 3, 3, 3, 3],
            &[4; 9],
        ];
        let mut collected = Faces::default();
        for corners in lists {
            let faces = faces(corners);
            collected.restart();
            assert!(collected.collect(&mut faces.iter()));
            assert_eq!(collected.len, faces.len());
            for (number, face) in faces.iter().enumerate() {
                assert_eq!(collected.get(number), face);
            }
            for first in 0..=faces.len().saturating_sub(TRIANGLES) {
                let eight = &faces[first..first + TRIANGLES];
                let are_triangles = eight.iter().all(|face| face.len() == 3);
                let triangles = collected.triangles(first..first + TRIANGLES);
                assert_eq!(triangles.is_some(), are_triangles, "{corners:?} from {first}");
                if let Some(triangles) = triangles {
                    assert!(
                        triangles.iter().zip(eight).all(|(triangle, face)| triangle == &face[..])
                    );
                }
            }
        }
    }
}
