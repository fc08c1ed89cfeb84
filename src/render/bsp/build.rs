//! How a tree is built: which plane divides the polygons of a node, and into what.
//!
//! # Which plane divides
//!
//! For each node a few faces are tried, among them the largest, and the planes across the three axes
//! at the median. The one wins that cuts the fewest polygons, where a cut counts as much as
//! [`CUT_COST`] polygons by which one side exceeds the other. The planes across the axes win in large
//! sets: they divide a closed surface of n faces in two halves for about sqrt(n) cuts, where the
//! faces of a convex surface would make a list of n nodes in n^2 / 2 steps. The planes of faces win
//! in small sets, where they cut less. What this makes of models is said at
//! [`BspTree`](crate::BspTree).

use glam::DVec4;

use crate::clip::polygon::{Parts, PolygonClipper};
use crate::render::bsp::partition::{Cut, NONE, Node, Partition, Piece};
use crate::render::bsp::plane::{Plane, Side};
use crate::render::faces::FaceList;
use crate::vertices::Vertices;
use crate::view_volume::Outcome;

/// What a cut costs, in polygons by which one side exceeds the other.
const CUT_COST: usize = 8;

/// Faces that are tried for a node, besides the largest.
const CANDIDATES: usize = 12;

/// Polygons on which a plane is tried.
const SAMPLE: usize = 64;

/// Vertices of pieces that a tree may take to be built, for each vertex of a face, and in addition.
const POINTS: (usize, usize) = (16, 1 << 20);

/// Vertices that may be compared with planes, for each vertex of a face, and in addition. A set of
/// 500 polygons whose planes cut none of the others takes 250 for each.
const WORK: (usize, usize) = (1 << 12, 1 << 24);

impl Partition {
    /// Divides faces.
    pub(crate) fn new(vertices: &dyn Vertices, faces: &FaceList) -> Self {
        let mut builder = Builder::default();
        let parts: Vec<_> = (0..faces.len())
            .filter_map(|face| builder.take(face as u32, faces.get(face), vertices))
            .collect();
        builder.build(parts);
        let Builder { nodes, pieces, cuts, is_inexact, .. } = builder;
        Self { nodes, pieces, cuts, is_exact: !is_inexact }
    }
}

/// A piece with its vertices.
#[derive(Clone, Copy, Debug)]
struct Part {
    piece: Piece,
    start: u32,
    len: u32,
}

/// A plane to divide by.
#[derive(Clone, Copy, Debug)]
struct Divider {
    plane: Plane,
    /// Which of the parts it belongs to; that one is on it.
    own: Option<usize>,
}

/// A tree being built.
#[derive(Debug, Default)]
struct Builder {
    /// The plane of each face.
    planes: Vec<Plane>,
    /// The vertices of all parts.
    points: Vec<DVec4>,
    clipper: PolygonClipper,
    sides: Vec<Side>,
    /// How many vertices faces have.
    input: usize,
    /// How many have been compared with planes.
    work: usize,
    nodes: Vec<Node>,
    pieces: Vec<Piece>,
    cuts: Vec<Cut>,
    is_inexact: bool,
}

impl Builder {
    /// Takes in a face, unless there is nothing of it to be seen.
    fn take(&mut self, face: u32, indices: &[u32], vertices: &dyn Vertices) -> Option<Part> {
        self.planes.push(Plane::default());
        if indices.iter().any(|&i| i as usize >= vertices.len()) {
            return None;
        }
        let corner = |&i: &u32| vertices.get(i).map(|(position, _)| (position, [].as_slice()));
        self.clipper.start(0);
        self.clipper.add_contour(indices.iter().filter_map(corner), &[]);
        if self.clipper.clip(&[], &[], Parts::Joined) == Outcome::Outside {
            return None;
        }
        let start = self.points.len();
        self.points.extend_from_slice(self.clipper.vertices().positions());
        let part = self.part(Piece { face, cut: NONE }, start)?;
        self.planes[face as usize] = Plane::of(self.polygon(&part));
        self.input = self.points.len();
        Some(part)
    }

    /// The part whose vertices are those from `start` on; `None` if there are too many to count.
    fn part(&self, piece: Piece, start: usize) -> Option<Part> {
        let end = u32::try_from(self.points.len()).ok()?;
        Some(Part { piece, start: start as u32, len: end - start as u32 })
    }

    fn polygon(&self, part: &Part) -> &[DVec4] {
        let start = part.start as usize;
        &self.points[start..start + part.len as usize]
    }

    fn is_exhausted(&self) -> bool {
        let limit = |(each, all): (usize, usize)| self.input.saturating_mul(each) + all;
        self.points.len() > limit(POINTS).min(NONE as usize / 2) || self.work > limit(WORK)
    }

    /// Divides parts until none are left to divide.
    fn build(&mut self, parts: Vec<Part>) {
        // The parts of nodes to be made, and where the number of each goes.
        let mut stack = vec![(parts, None)];
        while let Some((parts, place)) = stack.pop() {
            if parts.is_empty() {
                continue;
            }
            let number = self.nodes.len() as u32;
            if let Some((above, is_front)) = place {
                let above: &mut Node = &mut self.nodes[above as usize];
                *if is_front { &mut above.front } else { &mut above.back } = number;
            }
            let divided = self.divide(&parts, number);
            let first = self.pieces.len() as u32;
            let Some((plane, [on, front, back])) = divided else {
                // What has no area has no pixels whose order would matter.
                let has_area = |part: &Part| self.planes[part.piece.face as usize].area > 0.0;
                self.is_inexact |= parts.len() > 1 && parts.iter().any(has_area);
                self.pieces.extend(parts.iter().map(|part| part.piece));
                self.push(DVec4::ZERO, first);
                continue;
            };
            self.pieces.extend(on.iter().map(|part| part.piece));
            self.push(plane, first);
            stack.push((front, Some((number, true))));
            stack.push((back, Some((number, false))));
        }
    }

    /// Adds a node that has the pieces from `first` on.
    fn push(&mut self, plane: DVec4, first: u32) {
        let pieces = first..self.pieces.len() as u32;
        self.nodes.push(Node { plane, pieces, front: NONE, back: NONE });
    }

    /// Divides parts by a plane into those on it, on its front and on its back; `None` if there is
    /// nothing to divide, or no plane to divide by.
    fn divide(&mut self, parts: &[Part], node: u32) -> Option<(DVec4, [Vec<Part>; 3])> {
        if parts.len() < 2 || self.is_exhausted() {
            return None;
        }
        for divider in self.choose(parts).into_iter().flatten() {
            let mut sides = std::mem::take(&mut self.sides);
            sides.clear();
            sides.extend((0..parts.len()).map(|i| self.side(parts, i, &divider)));
            let count = |side| sides.iter().filter(|&&s| s == side || s == Side::Both).count();
            let most = count(Side::Front).max(count(Side::Back));
            let sets = (most < parts.len()).then(|| self.distribute(parts, &sides, &divider, node));
            self.sides = sides;
            if let Some(sets) = sets {
                return Some((divider.plane.form, sets));
            }
        }
        None
    }

    /// Where a part is, as seen from a divider.
    fn side(&mut self, parts: &[Part], i: usize, divider: &Divider) -> Side {
        if divider.own == Some(i) {
            return Side::On;
        }
        self.work += parts[i].len as usize;
        divider.plane.side(self.polygon(&parts[i]))
    }

    /// Puts the parts into the sets of their sides, in their order, and splits those on both.
    fn distribute(
        &mut self,
        parts: &[Part],
        sides: &[Side],
        divider: &Divider,
        node: u32,
    ) -> [Vec<Part>; 3] {
        let mut sets = [const { Vec::new() }; 3];
        for (part, side) in parts.iter().zip(sides) {
            match side {
                Side::On => sets[0].push(*part),
                Side::Front => sets[1].push(*part),
                Side::Back => sets[2].push(*part),
                Side::Both => match self.split(part, &divider.plane, node) {
                    Some([front, back]) => {
                        sets[1].push(front);
                        sets[2].push(back);
                    }
                    None => sets[1].push(*part),
                },
            }
        }
        sets
    }

    /// Splits a part that is on both sides of a plane. `None` if there are more cuts or vertices than
    /// can be counted.
    fn split(&mut self, part: &Part, plane: &Plane, node: u32) -> Option<[Part; 2]> {
        let first = u32::try_from(self.cuts.len()).ok().filter(|&n| n < NONE - 2)?;
        let mut half = |front: bool| {
            let start = self.points.len();
            let (first_point, end) = (part.start as usize, (part.start + part.len) as usize);
            let vertices = self.points[first_point..end].iter().copied();
            let sign = if front { 1.0 } else { -1.0 };
            let kept = self.clipper.part(vertices, |p| sign * plane.distance(p));
            self.points.extend_from_slice(kept);
            let piece = Piece { face: part.piece.face, cut: first + u32::from(!front) };
            self.part(piece, start)
        };
        let halves = [half(true)?, half(false)?];
        let before = part.piece.cut;
        self.cuts.extend([true, false].map(|front| Cut { node, front, before }));
        Some(halves)
    }

    /// The best plane to divide by, and the best of the faces'.
    fn choose(&mut self, parts: &[Part]) -> [Option<Divider>; 2] {
        let faces = self.faces_to_try(parts);
        let mut best_face = None;
        for own in faces {
            self.keep_better(&mut best_face, parts, own);
        }
        let mut best = best_face;
        for axis in 0..3 {
            let across = self.median(parts, axis).map(|at| Plane::across(axis, at));
            self.keep_better(&mut best, parts, across.map(|plane| Divider { plane, own: None }));
        }
        [best, best_face].map(|best| best.map(|(_, divider)| divider))
    }

    /// The largest face and some others.
    fn faces_to_try(&self, parts: &[Part]) -> [Option<Divider>; CANDIDATES + 1] {
        let plane = |i: usize| self.planes[parts[i].piece.face as usize];
        let largest = (0..parts.len()).max_by(|&i, &j| plane(i).area.total_cmp(&plane(j).area));
        std::array::from_fn(|k| {
            let i = if k == CANDIDATES { largest? } else { spread(k, CANDIDATES, parts.len())? };
            let plane = plane(i);
            (plane.area > 0.0 && (k == CANDIDATES || Some(i) != largest))
                .then_some(Divider { plane, own: Some(i) })
        })
    }

    /// Replaces the best divider so far by one that costs less.
    fn keep_better(
        &mut self,
        best: &mut Option<(usize, Divider)>,
        parts: &[Part],
        divider: Option<Divider>,
    ) {
        let Some(divider) = divider else { return };
        let (mut front, mut back, mut both) = (0usize, 0usize, 0usize);
        for i in (0..SAMPLE).map_while(|k| spread(k, SAMPLE, parts.len())) {
            match self.side(parts, i, &divider) {
                Side::Front => front += 1,
                Side::Back => back += 1,
                Side::Both => both += 1,
                Side::On => {}
            }
        }
        let cost = CUT_COST * both + front.abs_diff(back);
        if best.is_none_or(|(least, _)| cost < least) {
            *best = Some((cost, divider));
        }
    }

    /// The median of a coordinate, over the first vertices of some parts; `None` for few parts.
    fn median(&self, parts: &[Part], axis: usize) -> Option<f64> {
        let mut values = [0.0; SAMPLE];
        for (k, value) in values.iter_mut().enumerate() {
            let p = self.polygon(&parts[spread(k, SAMPLE, parts.len())?]).first()?;
            *value = p[axis] / p.w;
        }
        values.sort_unstable_by(f64::total_cmp);
        Some(values[SAMPLE / 2]).filter(|at| at.is_finite())
    }
}

/// The place of the k-th of `count` items spread evenly over `len`; if there are no more than
/// `count`, the k-th.
fn spread(k: usize, count: usize, len: usize) -> Option<usize> {
    if len <= count { (k < len).then_some(k) } else { Some((2 * k + 1) * len / (2 * count)) }
}
