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
//! polygon that lie on the right sides of the cuts: see [`Painter`](crate::Painter).
//!
//! # Which plane divides
//!
//! For each node a few faces are tried, among them the largest, and the planes across the three axes
//! at the median. The one wins that cuts the fewest polygons, where a cut counts as much as
//! [`CUT_COST`] polygons by which one side exceeds the other. The planes across the axes win in large
//! sets: they divide a closed surface of n faces in two halves for about sqrt(n) cuts, where the
//! faces of a convex surface would make a list of n nodes in n^2 / 2 steps. The planes of faces win
//! in small sets, where they cut less. What this makes of models is said at [`BspTree`].
//!
//! # Tolerance
//!
//! Positions are f32, so the product of a plane q and a position p is not known better than to
//! 2^-24 (|q_1 p_1| + .. + |q_4 p_4|), the unit roundoff of f32 in each coordinate. A vertex nearer
//! to the plane than that is on it: no polygon is split for the rounding of its vertices, and those
//! that share an edge with the plane's polygon lie on one side. The price is that what reaches
//! through a plane by less than that is not split; the sum, in f64, adds 2^-51 of the same.
//!
//! A polygon of four or more sides need not be flat. Its plane is Newell's, the best fit by area
//! (formula in Sutherland, Sproull and Schumacker, "A Characterization of Ten Hidden-Surface
//! Algorithms", 1974, who have it from M. Newell), and is as thick as the polygon is bent: vertices
//! that are no farther off than the polygon's own are on it, so that its neighbours are not split.
//! The quads of a model then make less than 2 pieces each instead of 5, and the picture is nearer to
//! the z-buffer's. Where other polygons come as near to a bent one as it is bent, their order is a
//! matter of definition.

use std::ops::Range;

use glam::{DVec3, DVec4, Vec4Swizzles};

use crate::clip::{ClipVertex, Clipper, Outcome, Parts};
use crate::vertex::Vertex;

/// What a cut costs, in polygons by which one side exceeds the other.
const CUT_COST: usize = 8;

/// Faces that are tried for a node, besides the largest.
const CANDIDATES: usize = 12;

/// Polygons on which a plane is tried.
const SAMPLE: usize = 64;

/// The relative error of a coordinate that was rounded to f32.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// Vertices of pieces that a tree may take to be built, for each vertex of a face, and in addition.
const POINTS: (usize, usize) = (16, 1 << 20);

/// Vertices that may be compared with planes, for each vertex of a face, and in addition. A set of
/// 500 polygons whose planes cut none of the others takes 250 for each.
const WORK: (usize, usize) = (1 << 12, 1 << 24);

/// No node, no cut.
pub(crate) const NONE: u32 = u32::MAX;

/// Polygons in an order for every eye: a binary space partition (Fuchs, Kedem and Naylor, "On
/// Visible Surface Generation by A Priori Tree Structures", SIGGRAPH 1980).
///
/// It is built once, in object space, and drawn from anywhere by
/// [`Painter::draw`](crate::Painter::draw).
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
    pub(crate) vertices: Vec<Vertex<N>>,
    pub(crate) face_list: FaceList,
    nodes: Vec<Node>,
    pieces: Vec<Piece>,
    cuts: Vec<Cut>,
    is_exact: bool,
}

/// Index lists, end to end.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaceList {
    indices: Vec<u32>,
    ends: Vec<u32>,
}

impl FaceList {
    /// Replaces the faces. Numbers are u32: what exceeds them is left out.
    pub(crate) fn collect<F: AsRef<[u32]>>(&mut self, faces: impl IntoIterator<Item = F>) {
        self.indices.clear();
        self.ends.clear();
        for face in faces.into_iter().take(NONE as usize) {
            let end = self.indices.len().saturating_add(face.as_ref().len());
            if u32::try_from(end).is_ok() {
                self.indices.extend_from_slice(face.as_ref());
            }
            self.ends.push(self.indices.len() as u32);
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The indices of a face; those of a face that is none are empty.
    pub(crate) fn get(&self, face: u32) -> &[u32] {
        let face = face as usize;
        let start = face.checked_sub(1).and_then(|before| self.ends.get(before)).unwrap_or(&0);
        let range = self.ends.get(face).map(|end| *start as usize..*end as usize);
        range.and_then(|range| self.indices.get(range)).unwrap_or(&[])
    }
}

/// A face, or what some cuts leave of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    pub(crate) face: u32,
    /// The last cut, or [`NONE`].
    pub(crate) cut: u32,
}

/// One side of a plane that cut a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    /// The node whose plane it is.
    node: u32,
    /// Whether the side is the front, where the product with the plane is positive.
    front: bool,
    /// The cut before, or [`NONE`].
    before: u32,
}

#[derive(Clone, Debug)]
struct Node {
    /// The plane, a linear form on homogeneous positions; zero where nothing is divided.
    plane: DVec4,
    /// The pieces on the plane, in the order of their faces. Without a plane: all that are here.
    pieces: Range<u32>,
    front: u32,
    back: u32,
}

/// Pieces that no plane divides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group<'a> {
    /// All on one plane.
    Coplanar(&'a [Piece]),
    /// Of unknown order.
    Unordered(&'a [Piece]),
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
    pub fn new<F: AsRef<[u32]>>(
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
    ) -> Self {
        let mut face_list = FaceList::default();
        face_list.collect(faces);
        let mut builder = Builder::default();
        let parts: Vec<_> = (0..face_list.len() as u32)
            .filter_map(|face| builder.take(face, face_list.get(face), vertices))
            .collect();
        builder.build(parts);
        let Builder { nodes, pieces, cuts, is_inexact, .. } = builder;
        Self { vertices: vertices.to_vec(), face_list, nodes, pieces, cuts, is_exact: !is_inexact }
    }

    /// The number of faces that it was given.
    pub fn faces(&self) -> usize {
        self.face_list.len()
    }

    /// The number of pieces in which faces are drawn.
    pub fn pieces(&self) -> usize {
        self.pieces.len()
    }

    /// Whether everything is divided by planes. If not, because the bounds of [`new`](Self::new)
    /// were reached, the rest is drawn in the order of its depths.
    pub fn is_exact(&self) -> bool {
        self.is_exact
    }

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

/// The plane of a face, or one to divide by.
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    /// The linear form, with a normal of length 1.
    form: DVec4,
    /// How far from it vertices count as on it, where w = 1, besides the rounding.
    thickness: f64,
    /// Twice the face's area; 0 if it has no plane.
    area: f64,
}

impl Plane {
    /// Newell's plane of a polygon, all of it at w > 0.
    ///
    /// Seen from the centroid c, each vertex a is a.xyz - c a.w; the sum of the cross products of
    /// neighbours is the normal, twice as long as the polygon's area is large, and c is on the
    /// plane.
    fn of(polygon: &[DVec4]) -> Self {
        let sum: DVec4 = polygon.iter().sum();
        let centre = sum.xyz() / sum.w;
        let from_centre = |p: &DVec4| p.xyz() - centre * p.w;
        let next = polygon.iter().cycle().skip(1);
        let normal: DVec3 =
            polygon.iter().zip(next).map(|(a, b)| from_centre(a).cross(from_centre(b))).sum();
        let area = normal.length();
        let normal = normal / area;
        let form = normal.extend(-normal.dot(centre));
        if !form.is_finite() || !area.is_finite() {
            return Self::default();
        }
        let mut plane = Self { form, thickness: 0.0, area };
        // Vertices at the eye are infinitely far away, where every bend is infinite.
        let least = polygon.iter().fold(0.0, |w, p| p.w.max(w)) / f64::from(1 << 20);
        let off = polygon.iter().filter(|p| p.w >= least).map(|&p| plane.distance(p).abs() / p.w);
        plane.thickness = off.fold(0.0, f64::max);
        plane
    }

    /// The plane across an axis where the coordinate is `at`.
    fn across(axis: usize, at: f64) -> Self {
        let mut form = DVec4::ZERO;
        form[axis] = 1.0;
        form.w = -at;
        Self { form, thickness: 0.0, area: 0.0 }
    }

    /// w times the distance from the plane, positive on the front; 0 if the position is on it.
    fn distance(&self, p: DVec4) -> f64 {
        let (distance, rounding) = (self.form.dot(p), self.rounding(p));
        if distance.abs() <= self.thickness * p.w + rounding { 0.0 } else { distance }
    }

    fn rounding(&self, p: DVec4) -> f64 {
        ROUNDING * self.form.abs().dot(p.abs())
    }

    /// Where a polygon is.
    fn side(&self, polygon: &[DVec4]) -> Side {
        let (mut front, mut back) = (false, false);
        for &p in polygon {
            let distance = self.distance(p);
            front |= distance > 0.0;
            back |= distance < 0.0;
        }
        match (front, back) {
            (true, true) => Side::Both,
            (true, false) => Side::Front,
            (false, true) => Side::Back,
            (false, false) => self.side_within(polygon),
        }
    }

    /// Where a polygon is whose vertices are all within the thickness.
    fn side_within(&self, polygon: &[DVec4]) -> Side {
        let sum: f64 = polygon.iter().map(|&p| self.form.dot(p)).sum();
        let rounding: f64 = polygon.iter().map(|&p| self.rounding(p)).sum();
        match sum {
            _ if sum > rounding => Side::Front,
            _ if sum < -rounding => Side::Back,
            _ => Side::On,
        }
    }
}

/// Where a polygon is, as seen from a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    On,
    Front,
    Back,
    Both,
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
    clipper: Clipper<0>,
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
    fn take<const N: usize>(
        &mut self,
        face: u32,
        indices: &[u32],
        vertices: &[Vertex<N>],
    ) -> Option<Part> {
        self.planes.push(Plane::default());
        let corner = |&i: &u32| vertices.get(i as usize).map(|v| Vertex::new(v.position, []));
        let polygon: Option<Vec<Vertex<0>>> = indices.iter().map(corner).collect();
        self.clipper.load(&polygon?, &[]);
        if self.clipper.clip_vertices(&[], &[], Parts::Joined) == Outcome::Outside {
            return None;
        }
        let start = self.points.len();
        self.points.extend(self.clipper.vertices().iter().map(|v| v.position));
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
            let vertices = self.points[first_point..end].iter();
            let vertices = vertices.map(|&position| ClipVertex { position, params: [] });
            let sign = if front { 1.0 } else { -1.0 };
            let kept = self.clipper.part(vertices, |p| sign * plane.distance(p));
            self.points.extend(kept.iter().map(|v| v.position));
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
