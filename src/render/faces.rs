//! Lists of faces: the indices of their vertices, end to end.

use std::ops::Range;

use crate::scalar::BATCH;

/// Faces drawn at a time: enough to share among processors, and a bound for the memory.
pub(crate) const MOST_AT_ONCE: usize = if cfg!(test) { 64 } else { 1 << 20 };

/// A face of a mesh: a list of three or more indices into its vertices. Arrays, vectors and slices of
/// `u32` are faces, as are the faces of a model, and references to all of them.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a face: a face is a list of `u32` indices such as `[u32; 3]`",
    label = "this is not a list of indices",
    note = "for a flat list of indices, three for each triangle, use `Mesh::triangles(&vertices, &indices)`"
)]
pub trait FaceIndices {
    /// The indices, in the order in which the face's sides run.
    fn indices(&self) -> &[u32];
}

impl FaceIndices for [u32] {
    fn indices(&self) -> &[u32] {
        self
    }
}

impl<const K: usize> FaceIndices for [u32; K] {
    fn indices(&self) -> &[u32] {
        self
    }
}

impl FaceIndices for Vec<u32> {
    fn indices(&self) -> &[u32] {
        self
    }
}

impl<F: FaceIndices + ?Sized> FaceIndices for &F {
    fn indices(&self) -> &[u32] {
        (**self).indices()
    }
}

/// Some faces of a mesh, in their order, as index lists end to end.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaceList {
    /// The number of the first in the mesh.
    first: u32,
    len: usize,
    indices: Vec<u32>,
    /// Where each ends; empty if all are triangles.
    ends: Vec<u32>,
    /// The number of each in its mesh, where they are not in the order of the mesh; empty otherwise.
    numbers: Vec<u32>,
    /// Where the contours end of a polygon that is the only face and has several. Empty otherwise.
    contour_ends: Vec<u32>,
}

impl FaceList {
    /// Begins with the first face of a mesh.
    pub(crate) fn restart(&mut self) {
        (self.first, self.len) = (0, 0);
        self.contour_ends.clear();
        self.numbers.clear();
    }

    /// Takes the next faces, `most` of them if there are as many; whether there were any.
    pub(crate) fn collect<F: FaceIndices>(
        &mut self,
        faces: &mut impl Iterator<Item = F>,
        most: usize,
    ) -> bool {
        self.first = self.first.wrapping_add(self.len as u32);
        self.indices.clear();
        self.ends.clear();
        let mut len = 0;
        while len < most && self.indices.len() < most.saturating_mul(4) {
            let Some(face) = faces.next() else { break };
            match face.indices() {
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
            self.ends.extend((1..=len).map(|len| end(len.saturating_mul(3))));
        }
        // A face of 2^32 corners and more is none that could be drawn.
        if u32::try_from(self.indices.len().saturating_add(face.len())).is_ok() {
            self.indices.extend_from_slice(face);
        }
        self.ends.push(end(self.indices.len()));
    }

    /// Takes one polygon, whose contours have so many vertices each, the first of them first.
    pub(crate) fn take_polygon(&mut self, contours: impl Iterator<Item = usize>) {
        self.restart();
        self.ends.clear();
        let mut last = 0u32;
        for len in contours {
            last = last.saturating_add(end(len));
            self.contour_ends.push(last);
        }
        self.indices.clear();
        self.indices.extend(0..last);
        self.ends.push(last);
        self.len = 1;
        if self.contour_ends.len() < 2 {
            self.contour_ends.clear();
        }
    }

    /// Takes lists of so many vertices each, the first of them first.
    pub(crate) fn take_lists(&mut self, lens: impl Iterator<Item = usize>) {
        self.restart();
        self.indices.clear();
        self.ends.clear();
        let mut last = 0u32;
        for len in lens {
            last = last.saturating_add(end(len));
            self.ends.push(last);
            self.len += 1;
        }
        self.indices.extend(0..last);
    }

    /// Takes the faces of another list in another order.
    pub(crate) fn take_in_order(&mut self, faces: &Self, order: impl Iterator<Item = u32>) {
        self.restart();
        self.indices.clear();
        self.ends.clear();
        for face in order {
            self.push(self.len, faces.get(face as usize));
            self.numbers.push(faces.number(face));
            self.len += 1;
        }
    }

    /// How many faces there are.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The number that a face has in its mesh.
    #[inline(always)]
    pub(crate) fn number(&self, face: u32) -> u32 {
        if self.numbers.is_empty() {
            return self.first.wrapping_add(face);
        }
        self.numbers.get(face as usize).copied().unwrap_or(0)
    }

    /// The face with a number, if it is one of these, which are in the order of their mesh.
    #[inline(always)]
    pub(crate) fn with_number(&self, number: u32) -> Option<&[u32]> {
        let face = number.wrapping_sub(self.first) as usize;
        (face < self.len).then(|| self.get(face))
    }

    /// Whether the only face has several contours.
    pub(crate) fn has_contours(&self) -> bool {
        !self.contour_ends.is_empty()
    }

    /// Eight faces, if all are triangles.
    #[inline(always)]
    pub(crate) fn triangles(&self, faces: Range<usize>) -> Option<&[[u32; 3]; BATCH]> {
        if faces.len() != BATCH {
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

    /// The indices of a face; empty if there is no such face.
    pub(crate) fn get(&self, face: usize) -> &[u32] {
        let range = if self.ends.is_empty() {
            3 * face..3 * face + 3
        } else {
            self.start(face)..self.ends.get(face).map_or(0, |end| *end as usize)
        };
        self.indices.get(range).unwrap_or_default()
    }

    /// The indices of a face's contours.
    pub(crate) fn contours(&self, face: usize) -> impl Iterator<Item = &[u32]> {
        let mut start = 0;
        let several = self.contour_ends.iter().map(move |&end| {
            let contour = std::mem::replace(&mut start, end as usize)..end as usize;
            self.indices.get(contour).unwrap_or_default()
        });
        let one = (!self.has_contours()).then(|| self.get(face));
        several.chain(one)
    }

    /// Where a face begins, where not all are triangles.
    fn start(&self, face: usize) -> usize {
        let before = face.checked_sub(1).and_then(|before| self.ends.get(before));
        before.map_or(0, |end| *end as usize)
    }
}

/// Where a face ends; beyond 2^32 indices there are no faces.
fn end(indices: usize) -> u32 {
    u32::try_from(indices).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::{BATCH, FaceList};

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
        let mut collected = FaceList::default();
        for corners in lists {
            let faces = faces(corners);
            collected.restart();
            assert!(collected.collect(&mut faces.iter(), 1000));
            assert_eq!(collected.len(), faces.len());
            for (number, face) in faces.iter().enumerate() {
                assert_eq!(collected.get(number), face);
                assert!(collected.contours(number).eq([face.as_slice()]));
            }
            for first in 0..=faces.len().saturating_sub(BATCH) {
                let eight = &faces[first..first + BATCH];
                let are_triangles = eight.iter().all(|face| face.len() == 3);
                let triangles = collected.triangles(first..first + BATCH);
                assert_eq!(triangles.is_some(), are_triangles, "{corners:?} from {first}");
                if let Some(triangles) = triangles {
                    assert!(
                        triangles.iter().zip(eight).all(|(triangle, face)| triangle == &face[..])
                    );
                }
            }
        }
    }

    #[test]
    fn a_polygon_has_its_contours() {
        let mut list = FaceList::default();
        list.take_polygon([3, 4].into_iter());
        assert!(list.has_contours() && list.len() == 1);
        assert!(list.contours(0).eq([&[0, 1, 2][..], &[3, 4, 5, 6][..]]));
        list.take_polygon([5].into_iter());
        assert!(!list.has_contours());
        assert!(list.contours(0).eq([&[0, 1, 2, 3, 4][..]]));
    }
}
