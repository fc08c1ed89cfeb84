//! Triangles that share edges, cut level by level.
//!
//! At each level the triangles that may be seen mark those of their edges that are long. A marked edge is cut in two,
//! and every triangle with marked edges into as many parts as that needs: so triangles meet without gaps.
//! Edges that are not marked at their first level never are: whether they are long is theirs alone, and what
//! is cut of a triangle out of sight is out of sight.

use std::collections::{HashMap, HashSet};

use foldhash::fast::RandomState;
use glam::{Vec2, Vec3, Vec4};

use crate::model::dice::sight::Sight;
use crate::model::vertex::ModelVertex;

/// The most times that an edge is cut in two: `f32` tells no more places apart along it.
const MOST_LEVELS: u32 = 24;

/// A place of the surface, which several corners may share.
#[derive(Clone, Default)]
pub(super) struct Point {
    /// Before it is moved.
    pub(super) base: Vec3,
    /// Where it is moved to, of any length: linear between the points of the first net.
    pub(super) direction: Vec3,
    /// After it is moved.
    pub(super) moved: Vec3,
    /// The sum of its corners' heights, and how many they are.
    pub(super) heights: (f32, u32),
    /// Whether it stays at its place.
    pub(super) is_fixed: bool,
}

/// What a face has at a point.
#[derive(Clone)]
pub(super) struct Corner {
    /// All its numbers are linear between those of the first net, and not normalised.
    pub(super) vertex: ModelVertex,
    /// The change of place with u and with v.
    pub(super) axes: [Vec3; 2],
    pub(super) point: u32,
    /// The material that has the heights; [`NO_HEIGHTS`] for none.
    pub(super) material: u32,
}

/// The material of corners that have no heights.
pub(super) const NO_HEIGHTS: u32 = u32::MAX;

/// A line between two corners.
#[derive(Clone, Copy)]
pub(super) struct Edge {
    pub(super) ends: [u32; 2],
    pub(super) cut: Cut,
    /// Whether there are others between the same points.
    pub(super) is_seam: bool,
    /// Whether its points stay at their places.
    pub(super) is_fixed: bool,
}

/// What becomes of an edge.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Cut {
    No,
    Marked,
    /// Into this edge and the one after it.
    Halves(u32),
}

/// A triangle whose edges may still be cut: the edge of each corner leads to the next one.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    pub(super) corners: [u32; 3],
    pub(super) edges: [u32; 3],
    /// The number of the face that it is part of.
    pub(super) face: u32,
    /// Whether it may be seen, and has heights.
    pub(super) is_seen: bool,
}

/// A triangle that stays.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    pub(super) corners: [u32; 3],
    pub(super) face: u32,
}

/// A pair of points, the lower number first.
type Pair = (u32, u32);

/// The triangles of the faces that are diced.
#[derive(Clone, Default)]
pub(super) struct Net {
    pub(super) points: Vec<Point>,
    pub(super) corners: Vec<Corner>,
    pub(super) edges: Vec<Edge>,
    pub(super) waiting: Vec<Triangle>,
    pub(super) done: Vec<Piece>,
    /// The edges of the level begin here.
    level: usize,
    /// How many levels there were.
    levels: u32,
    /// Of seams, those that are marked.
    marked: HashSet<Pair, RandomState>,
    /// Of the edges of seams, the points that they are cut at.
    middles: HashMap<Pair, u32, RandomState>,
}

impl Net {
    fn pair(&self, edge: usize) -> Pair {
        let [a, b] = self.edges[edge].ends.map(|corner| self.corners[corner as usize].point);
        (a.min(b), a.max(b))
    }

    fn point(&self, corner: u32) -> &Point {
        &self.points[self.corners[corner as usize].point as usize]
    }

    /// Marks the edges that are to be cut.
    pub(super) fn mark(&mut self, sight: &Sight) {
        let mut waiting = std::mem::take(&mut self.waiting);
        let is_last = self.levels == MOST_LEVELS;
        for triangle in waiting.iter_mut().filter(|triangle| triangle.is_seen) {
            let outcodes = triangle.corners.map(|corner| sight.outcode(self.point(corner).base));
            triangle.is_seen = outcodes.into_iter().fold(u32::MAX, |all, one| all & one) == 0;
            if !triangle.is_seen || is_last {
                continue;
            }
            for edge in triangle.edges.map(|edge| edge as usize) {
                if edge < self.level || self.edges[edge].cut != Cut::No {
                    continue;
                }
                let [a, b] = self.edges[edge].ends.map(|corner| self.point(corner));
                if sight.is_long([a.base, b.base], [a.moved, b.moved]) {
                    self.edges[edge].cut = Cut::Marked;
                    if self.edges[edge].is_seam {
                        self.marked.insert(self.pair(edge));
                    }
                }
            }
        }
        self.waiting = waiting;
        self.levels += 1;
    }

    /// Cuts the marked edges, and those of seams that are marked from another side.
    pub(super) fn halve_edges(&mut self) {
        let level = self.level..self.edges.len();
        self.level = self.edges.len();
        for edge in level {
            let Edge { ends, cut, is_seam, is_fixed } = self.edges[edge];
            if cut == Cut::No && !(is_seam && self.marked.contains(&self.pair(edge))) {
                continue;
            }
            let point = if is_seam {
                let pair = self.pair(edge);
                if let Some(&point) = self.middles.get(&pair) {
                    point
                } else {
                    let point = self.add_middle_point(ends, is_fixed);
                    self.middles.insert(pair, point);
                    point
                }
            } else {
                self.add_middle_point(ends, is_fixed)
            };
            let middle = self.add_middle_corner(ends, point);
            self.edges[edge].cut = Cut::Halves(self.edges.len() as u32);
            for ends in [[ends[0], middle], [middle, ends[1]]] {
                self.edges.push(Edge { ends, cut: Cut::No, is_seam, is_fixed });
            }
        }
        self.marked.clear();
        self.middles.clear();
    }

    fn add_middle_point(&mut self, ends: [u32; 2], is_fixed: bool) -> u32 {
        let [a, b] = ends.map(|corner| self.point(corner));
        let base = middle(a.base, b.base);
        let direction = middle(a.direction, b.direction);
        self.points.push(Point { base, direction, moved: base, is_fixed, ..Point::default() });
        self.points.len() as u32 - 1
    }

    fn add_middle_corner(&mut self, ends: [u32; 2], point: u32) -> u32 {
        let [a, b] = ends.map(|corner| &self.corners[corner as usize]);
        let vertex = ModelVertex {
            position: middle(a.vertex.position, b.vertex.position),
            normal: middle(a.vertex.normal, b.vertex.normal),
            uv: middle::<Vec2>(a.vertex.uv, b.vertex.uv),
            color: middle::<Vec4>(a.vertex.color, b.vertex.color),
            tangent: middle::<Vec4>(a.vertex.tangent, b.vertex.tangent),
        };
        let axes = [0, 1].map(|axis| middle(a.axes[axis], b.axes[axis]));
        let corner = Corner { vertex, axes, point, material: a.material };
        self.corners.push(corner);
        self.corners.len() as u32 - 1
    }

    /// How many triangles there will be when those that wait are cut.
    pub(super) fn count_of_next(&self) -> usize {
        let is_cut = |&edge: &u32| self.edges[edge as usize].cut != Cut::No;
        let parts = |triangle: &Triangle| 1 + triangle.edges.iter().filter(|e| is_cut(e)).count();
        self.done.len() + self.waiting.iter().map(parts).sum::<usize>()
    }

    /// Cuts the triangles whose edges are cut. Others are done.
    pub(super) fn cut_triangles(&mut self) {
        for triangle in std::mem::take(&mut self.waiting) {
            let Triangle { corners, edges, face, .. } = triangle;
            let is_cut = edges.map(|edge| self.edges[edge as usize].cut != Cut::No);
            match is_cut {
                [false, false, false] => self.done.push(Piece { corners, face }),
                [true, true, true] => self.cut_three(&triangle),
                [true, true, false] => self.cut_two(&triangle),
                [false, true, true] => self.cut_two(&triangle.turned(1)),
                [true, false, true] => self.cut_two(&triangle.turned(2)),
                [true, false, false] => self.cut_one(&triangle),
                [false, true, false] => self.cut_one(&triangle.turned(1)),
                [false, false, true] => self.cut_one(&triangle.turned(2)),
            }
        }
    }

    /// The halves of an edge, the one at `corner` first, and the corner in its middle.
    fn halves(&self, edge: u32, corner: u32) -> ([u32; 2], u32) {
        let Edge { ends, cut, .. } = &self.edges[edge as usize];
        // An edge that is not cut is never asked for.
        let Cut::Halves(first) = *cut else { return ([edge; 2], corner) };
        let halves = if ends[0] == corner { [first, first + 1] } else { [first + 1, first] };
        (halves, self.edges[first as usize].ends[1])
    }

    /// An edge inside of a triangle.
    fn inner(&mut self, a: u32, b: u32) -> u32 {
        self.edges.push(Edge { ends: [a, b], cut: Cut::No, is_seam: false, is_fixed: false });
        self.edges.len() as u32 - 1
    }

    fn wait(&mut self, whole: &Triangle, corners: [u32; 3], edges: [u32; 3]) {
        self.waiting.push(Triangle { corners, edges, ..*whole });
    }

    /// Cuts a triangle at the middle of its first edge.
    fn cut_one(&mut self, whole: &Triangle) {
        let ([a, b, c], [ab, bc, ca]) = (whole.corners, whole.edges);
        let ([first, second], middle) = self.halves(ab, a);
        let inner = self.inner(middle, c);
        self.wait(whole, [a, middle, c], [first, inner, ca]);
        self.wait(whole, [middle, b, c], [second, bc, inner]);
    }

    /// Cuts a triangle at the middles of its first two edges, and the rest at the shorter diagonal.
    fn cut_two(&mut self, whole: &Triangle) {
        let ([a, b, c], [ab, bc, ca]) = (whole.corners, whole.edges);
        let ([a_m, m_b], m) = self.halves(ab, a);
        let ([b_n, n_c], n) = self.halves(bc, b);
        let m_n = self.inner(m, n);
        self.wait(whole, [m, b, n], [m_b, b_n, m_n]);
        let length = |a: u32, b: u32| self.point(a).base.distance_squared(self.point(b).base);
        if length(a, n) < length(m, c) {
            let a_n = self.inner(a, n);
            self.wait(whole, [a, m, n], [a_m, m_n, a_n]);
            self.wait(whole, [a, n, c], [a_n, n_c, ca]);
        } else {
            let m_c = self.inner(m, c);
            self.wait(whole, [a, m, c], [a_m, m_c, ca]);
            self.wait(whole, [m, n, c], [m_n, n_c, m_c]);
        }
    }

    /// Cuts a triangle at the middles of its edges, into four.
    fn cut_three(&mut self, whole: &Triangle) {
        let ([a, b, c], [ab, bc, ca]) = (whole.corners, whole.edges);
        let ([a_l, l_b], l) = self.halves(ab, a);
        let ([b_m, m_c], m) = self.halves(bc, b);
        let ([c_n, n_a], n) = self.halves(ca, c);
        let [l_m, m_n, n_l] = [(l, m), (m, n), (n, l)].map(|(a, b)| self.inner(a, b));
        self.wait(whole, [a, l, n], [a_l, n_l, n_a]);
        self.wait(whole, [l, b, m], [l_b, b_m, l_m]);
        self.wait(whole, [m, c, n], [m_c, c_n, m_n]);
        self.wait(whole, [l, m, n], [l_m, m_n, n_l]);
    }
}

impl Triangle {
    /// The same triangle from another corner on.
    fn turned(&self, by: usize) -> Self {
        let (mut corners, mut edges) = (self.corners, self.edges);
        corners.rotate_left(by);
        edges.rotate_left(by);
        Self { corners, edges, ..*self }
    }
}

/// Halfway between two, without an overflow between.
fn middle<T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(a: T, b: T) -> T {
    a * 0.5 + b * 0.5
}
