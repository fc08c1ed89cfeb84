//! Convex outlines. A row of one has one run, so it needs no table: two active edges walk down its
//! left and its right side. And of a triangle, whose edges are few, the runs of several rows are
//! found at once.

use std::ops::Range;

use super::triangle::{OneTriangle, Triangle, TriangleRows};
use super::{Edge, Run, first_centre, signed_area};
use crate::project::FixedPoint;

/// Rows whose runs are found at a time.
pub(crate) const ROWS: usize = 8;

/// The runs of neighbouring rows of a convex outline; they may be empty.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunGroup {
    /// The first row.
    pub(crate) y: i32,
    /// The number of rows.
    pub(crate) len: usize,
    pub(crate) start: [i32; ROWS],
    pub(crate) end: [i32; ROWS],
    /// The edges on the left and on the right, unless they are not asked for.
    pub(crate) edges: [[u32; 2]; ROWS],
}

impl RunGroup {
    const EMPTY: Self =
        Self { y: 0, len: 0, start: [0; ROWS], end: [0; ROWS], edges: [[0; 2]; ROWS] };

    /// The run of a row.
    #[inline(always)]
    pub(crate) fn run(&self, row: usize) -> Run {
        let (y, x) = (self.y + row as i32, self.start[row]..self.end[row]);
        Run { y, x, edges: self.edges[row] }
    }
}

/// A convex outline, and the rows to visit.
#[derive(Clone, Debug)]
pub(crate) struct ConvexOutline<'a> {
    pub(super) points: &'a [FixedPoint],
    pub(super) rows: Range<i32>,
}

/// A convex outline whose runs are to be found in groups of rows.
#[derive(Clone, Debug)]
pub(crate) enum RunGroups<'a> {
    Outline(ConvexOutline<'a>),
    /// A triangle whose lines are known, and exact.
    Triangle(OneTriangle<'a>),
}

impl RunGroups<'_> {
    /// Calls `f` for groups of runs, from top to bottom; `edges` says whether the edges of each run
    /// are asked for. Of a triangle whose lines are known they are not.
    #[inline(always)]
    pub(crate) fn for_each(&self, edges: bool, mut f: impl FnMut(&RunGroup)) {
        let mut group = RunGroup::EMPTY;
        let found;
        // Two options, not one enum: the rows of a triangle are to stay in registers.
        let (mut rows, mut pair) = (None, None);
        match self {
            Self::Triangle(triangle) => rows = Some(TriangleRows::new(*triangle)),
            Self::Outline(outline) => {
                found = if edges { None } else { Triangle::of(outline) };
                match &found {
                    Some(lines) => rows = Some(TriangleRows::new(OneTriangle { lines, number: 0 })),
                    None => pair = Some(ActivePair::new(outline)),
                }
            }
        }
        loop {
            let is_last = match (&mut rows, &mut pair) {
                (Some(rows), _) => rows.next_group(&mut group),
                (None, Some(pair)) => pair.next_group(&mut group),
                (None, None) => return,
            };
            f(&group);
            if is_last {
                return;
            }
        }
    }
}

/// Whether an outline winds once around a convex region, or has no area. Going around it, a
/// convex outline never turns both left and right, and it turns downwards only once.
pub(super) fn is_convex(outline: &[FixedPoint]) -> bool {
    if outline.len() <= 3 {
        return true;
    }
    let next = outline.iter().cycle().skip(1);
    let sides = outline
        .iter()
        .zip(next)
        .filter(|(a, b)| a != b)
        .map(|(a, b)| (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y)));
    let Some(mut before) = sides.clone().last() else { return true };
    let (mut left, mut right, mut back, mut downwards) = (false, false, false, 0);
    // The direction of the last side that is not horizontal.
    let mut down = sides.clone().filter(|side| side.1 != 0).last().is_some_and(|side| side.1 > 0);
    for side in sides {
        let turn = before.0 * side.1 - before.1 * side.0;
        left |= turn < 0;
        right |= turn > 0;
        back |= turn == 0 && before.0 * side.0 + before.1 * side.1 < 0;
        if side.1 != 0 {
            downwards += u32::from(side.1 > 0 && !down);
            down = side.1 > 0;
        }
        before = side;
    }
    !(left && right || back || downwards > 1)
}

/// The two active edges of a convex outline, left and right. Each is one of the edges that lead from
/// the outline's top to its bottom on one side; when it ends, the next one takes its place.
#[derive(Debug)]
pub(super) struct ActivePair<'a> {
    left: Side<'a>,
    right: Side<'a>,
    /// `None` when the last row is done.
    active: Option<[Edge; 2]>,
    /// The row after the last.
    end: i32,
}

/// The vertices of a convex outline in the order in which one of its sides runs down.
#[derive(Debug)]
struct Side<'a> {
    outline: &'a [FixedPoint],
    rows: Range<i32>,
    /// The vertex that has been reached.
    at: usize,
    forward: bool,
}

impl Side<'_> {
    /// The next edge that crosses a row.
    #[inline(always)]
    fn next_edge(&mut self) -> Option<Edge> {
        // An edge in a convex outline that runs up lies on the other side.
        for _ in 0..self.outline.len() {
            let from = self.at;
            let last = self.outline.len() - 1;
            let (to, index) = if self.forward {
                (if from == last { 0 } else { from + 1 }, from)
            } else {
                let before = if from == 0 { last } else { from - 1 };
                (before, before)
            };
            self.at = to;
            let (a, b) = (self.outline[from], self.outline[to]);
            if let Some(edge) = Edge::new(a, b, index as u32, &self.rows) {
                return Some(edge);
            }
        }
        None
    }
}

impl<'a> ActivePair<'a> {
    #[inline(never)]
    pub(super) fn new(ConvexOutline { points: outline, rows }: &ConvexOutline<'a>) -> Self {
        let area = signed_area(outline, |point| *point);
        let side = |at, forward| Side { outline, rows: rows.clone(), at, forward };
        let mut top = 0;
        let mut bottom = i32::MIN;
        for (k, point) in outline.iter().enumerate() {
            if point.y < outline[top].y {
                top = k;
            }
            bottom = bottom.max(point.y);
        }
        // Clockwise means that the side that runs down forward is on the right.
        let (mut left, mut right) = (side(top, area < 0), side(top, area > 0));
        let active = if area == 0 { None } else { left.next_edge().zip(right.next_edge()) };
        let end = first_centre(bottom).min(rows.end);
        Self { left, right, active: active.map(|(left, right)| [left, right]), end }
    }

    /// Goes on to the next row.
    #[inline(always)]
    fn advance(&mut self, [left, right]: &mut [Edge; 2]) -> bool {
        let y = left.rows.0 + 1;
        if y >= self.end {
            return false;
        }
        for (edge, side) in [(left, &mut self.left), (right, &mut self.right)] {
            edge.rows.0 = y;
            if y < edge.rows.1 {
                edge.advance();
            } else if let Some(next) = side.next_edge() {
                *edge = next;
            } else {
                return false;
            }
        }
        true
    }
}

impl<'a> ActivePair<'a> {
    /// The run of the next row, which may be empty.
    #[inline(always)]
    fn next_row(&mut self) -> Option<Run> {
        let mut pair = self.active?;
        let [left, right] = &pair;
        let run = Run { y: left.rows.0, x: left.x..right.x, edges: [left.index, right.index] };
        self.active = if self.advance(&mut pair) { Some(pair) } else { None };
        Some(run)
    }

    /// Finds the next rows, if any; whether they are the last. Outlined: what is drawn in the rows
    /// takes longer than a call.
    #[inline(never)]
    fn next_group(&mut self, group: &mut RunGroup) -> bool {
        *group = RunGroup::EMPTY;
        while group.len < ROWS {
            let Some(Run { y, x, edges }) = self.next_row() else { break };
            if group.len == 0 {
                group.y = y;
            }
            (group.start[group.len], group.end[group.len]) = (x.start, x.end);
            group.edges[group.len] = edges;
            group.len += 1;
        }
        self.active.is_none()
    }
}

impl Iterator for ActivePair<'_> {
    type Item = Run;

    #[inline(always)]
    fn next(&mut self) -> Option<Run> {
        loop {
            let run = self.next_row()?;
            if !run.x.is_empty() {
                return Some(run);
            }
        }
    }
}
