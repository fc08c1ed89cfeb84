//! The nodes of a tree, the pieces of faces that they hold, and the order of these for any eye.

use std::ops::Range;

use glam::DVec4;

/// No node, no cut.
pub(crate) const NONE: u32 = u32::MAX;

/// A face, or what some cuts leave of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Piece {
    pub(crate) face: u32,
    /// The last cut, or [`NONE`].
    pub(crate) cut: u32,
}

/// One side of a plane that cut a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    /// The node whose plane it is.
    pub(crate) node: u32,
    /// Whether the side is the front, where the product with the plane is positive.
    pub(crate) front: bool,
    /// The cut before, or [`NONE`].
    pub(crate) before: u32,
}

#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// The plane, a linear form on homogeneous positions; zero where nothing is divided.
    pub(crate) plane: DVec4,
    /// The pieces on the plane, in the order of their faces. Without a plane: all that are here.
    pub(crate) pieces: Range<u32>,
    pub(crate) front: u32,
    pub(crate) back: u32,
}

/// Pieces that no plane divides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group<'a> {
    /// All on one plane.
    Coplanar(&'a [Piece]),
    /// Of unknown order.
    Unordered(&'a [Piece]),
}

/// Faces divided by planes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Partition {
    pub(crate) nodes: Vec<Node>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) cuts: Vec<Cut>,
    /// Whether everything is divided.
    pub(crate) is_exact: bool,
}

impl Partition {
    /// The pieces from back to front, where `is_front_far` says of a plane whether what is on its
    /// front is hidden by what is on its back.
    pub(crate) fn back_to_front<'a>(
        &'a self,
        is_front_far: impl Fn(DVec4) -> bool,
        mut visit: impl FnMut(Group<'a>),
    ) {
        // Nodes yet to be visited, and whether what is behind them has been.
        let mut stack = vec![(0, false)];
        while let Some((number, behind_is_done)) = stack.pop() {
            let Some(node) = self.nodes.get(number as usize) else { continue };
            let pieces = &self.pieces[node.pieces.start as usize..node.pieces.end as usize];
            if node.plane == DVec4::ZERO {
                visit(Group::Unordered(pieces));
            } else if behind_is_done {
                visit(Group::Coplanar(pieces));
            } else {
                let (far, near) = if is_front_far(node.plane) {
                    (node.front, node.back)
                } else {
                    (node.back, node.front)
                };
                stack.extend([(near, false), (number, true), (far, false)]);
            }
        }
    }

    /// The cuts of a piece, the last first: the plane, and whether the piece is on its front.
    pub(crate) fn cuts(&self, piece: Piece) -> impl Iterator<Item = (DVec4, bool)> {
        let cut = |number: u32| self.cuts.get(number as usize);
        std::iter::successors(cut(piece.cut), move |last| cut(last.before))
            .filter_map(|cut| Some((self.nodes.get(cut.node as usize)?.plane, cut.front)))
    }
}
