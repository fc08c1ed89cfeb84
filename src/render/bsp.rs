//! Binary space partition: polygons in a tree that gives their back-to-front order for any eye.
//!
//! Polygons in object space go in. The plane of one of them divides the others into those on its
//! front and those on its back; those on both sides are split; each side is divided in turn (Fuchs,
//! Kedem and Naylor, "On Visible Surface Generation by A Priori Tree Structures", SIGGRAPH 1980).
//! For an eye on a plane's front nothing on its back can hide what is on its front, so the order is
//! back, plane, front, and the reverse for an eye on its back. Cycles of polygons that hide each
//! other, and polygons that run through each other, are resolved by the splits.
//!
//! A polygon is split by the [clipper](crate::clip) for the tree's purposes only, to know which side
//! its parts are on. What is drawn of a part is not its rounded vertices but the pixels of the whole
//! polygon that lie on the right sides of the cuts: see [`PainterRenderer`](crate::PainterRenderer).
//!
//! `bsp::plane` has the planes, with their tolerance; `bsp::build` chooses which of them divide;
//! `bsp::partition` is what comes of it.

mod plane;
mod partition;
mod build;

use crate::render::faces::{FaceIndices, FaceList};
use crate::vertex::Vertex;

pub(crate) use self::partition::{Group, NONE, Partition, Piece};

/// Polygons in an order for every eye: a binary space partition (Fuchs, Kedem and Naylor, "On
/// Visible Surface Generation by A Priori Tree Structures", SIGGRAPH 1980).
///
/// It is built once, in object space, and drawn from anywhere by
/// a [`PainterRenderer`](crate::PainterRenderer) or any other.
///
/// Polygons that cross the plane of another are split where needed. For surfaces of n faces building
/// takes time like n log n, and there are about twice as many pieces as faces. With the release build
/// on one core of a shared server:
///
/// | model | faces | pieces | a face | milliseconds |
/// |---|---|---|---|---|
/// | bunny, triangles | 69,451 | 133,112 | 1.92 | 900 |
/// | beetle, triangles | 38,656 | 66,720 | 1.73 | 460 |
/// | teapot, triangles | 6,320 | 8,772 | 1.39 | 66 |
/// | cow, triangles | 5,804 | 11,653 | 2.01 | 66 |
/// | spot, quads, bent | 2,928 | 5,412 | 1.85 | 39 |
/// | head, triangles | 2,492 | 4,962 | 1.99 | 33 |
/// | monkey, quads, bent | 500 | 972 | 1.94 | 7 |
///
/// The worst is n polygons that all cross each other: their pieces grow like n^3. So the work is
/// bounded; see [`new`](Self::new).
///
/// Sides of a plane are told apart to 2^-24 of the coordinates' products with it, the rounding of f32.
/// A polygon of four or more sides that is not flat counts as its plane of best fit (Newell's), as
/// thick as it is bent: its neighbours are not split, and what crosses it within that thickness may
/// come out on either side.
///
/// ```
/// use glam::vec4;
/// use polyscan::{BspTree, Vertex};
///
/// // Two squares through each other: whichever is first in the tree splits the other.
/// let vertices = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| [vec4(x, y, 0.0, 1.0), vec4(x, 0.0, y, 1.0)])
///     .as_flattened()
///     .iter()
///     .map(|&position| Vertex::new(position, []))
///     .collect::<Vec<_>>();
/// let tree = BspTree::new(&vertices, [[0, 2, 4, 6], [1, 3, 5, 7]]);
/// assert_eq!((tree.faces(), tree.pieces()), (2, 3));
/// assert!(tree.is_exact());
/// ```
#[derive(Clone, Debug, Default)]
pub struct BspTree<const N: usize> {
    vertices: Vec<Vertex<N>>,
    faces: FaceList,
    partition: Partition,
}

impl<const N: usize> BspTree<N> {
    /// A tree of faces, each a list of indices into `vertices`, of any number of sides. Positions
    /// are homogeneous, with w = 1 as a rule; the order is that of what has w > 0.
    ///
    /// A face with an index out of range or a position that is not finite is left out, as is one
    /// without a part that has w > 0. The memory is
    /// 16 + 4 N bytes a vertex, and some 80 bytes a piece. For n vertices of faces, building takes at
    /// most 16 n + 2^20 vertices of pieces, 32 bytes each, and 2^12 n + 2^24 comparisons of a vertex
    /// with a plane; what is not divided by then is left as it is, and the tree is not
    /// [exact](Self::is_exact).
    pub fn new<F: FaceIndices>(vertices: &[Vertex<N>], faces: impl IntoIterator<Item = F>) -> Self {
        let mut list = FaceList::default();
        // Numbers are u32: faces beyond them are left out.
        list.collect(&mut faces.into_iter(), NONE as usize);
        let partition = Partition::new(&vertices, &list);
        Self { vertices: vertices.to_vec(), faces: list, partition }
    }

    /// The number of faces that it was given.
    #[must_use]
    pub fn faces(&self) -> usize {
        self.faces.len()
    }

    /// The number of pieces in which faces are drawn.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.partition.pieces.len()
    }

    /// Whether everything is divided by planes. If not, because the bounds of [`new`](Self::new)
    /// were reached, the rest is drawn in the order of its depths.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.partition.is_exact
    }

    pub(crate) fn vertices(&self) -> &[Vertex<N>] {
        &self.vertices
    }

    pub(crate) fn face_list(&self) -> &FaceList {
        &self.faces
    }

    pub(crate) fn partition(&self) -> &Partition {
        &self.partition
    }
}
