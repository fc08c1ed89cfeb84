//! Convex outlines. A row of one has one run, so it needs no table: two active edges walk down its
//! left and its right side.

use std::ops::Range;

use crate::coverage::area::signed_area;
use crate::coverage::edge::Edge;
use crate::coverage::run::{ROWS, Run, RunGroup};
use crate::subpixel::{SubpixelPoint, first_centre};

/// A convex outline, and the rows to visit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConvexOutline<'a> {
    pub(crate) points: &'a [SubpixelPoint],
    pub(crate) first_row: i32,
    pub(crate) end_row: i32,
}

impl ConvexOutline<'_> {
    pub(crate) fn rows(&self) -> Range<i32> {
        self.first_row..self.end_row
    }

    /// The columns and rows, of those given, that the outline extends over, if any.
    #[inline(always)]
    pub(crate) fn extent(&self, columns: &Range<i32>) -> Option<(Range<i32>, Range<i32>)> {
        let extent = |within: &Range<i32>, coordinate: fn(&SubpixelPoint) -> i32| {
            let values = self.points.iter().map(coordinate);
            let (min, max) = values.fold((i32::MAX, i32::MIN), |(a, b), v| (a.min(v), b.max(v)));
            first_centre(min).max(within.start)..first_centre(max).min(within.end)
        };
        let (columns, rows) = (extent(columns, |p| p.x), extent(&self.rows(), |p| p.y));
        (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
    }
}

/// Whether an outline winds once around a convex region, or has no area. Going around it, a
/// convex outline never turns both left and right, and it turns downwards only once.
pub(crate) fn is_convex(outline: &[SubpixelPoint]) -> bool {
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
pub(crate) struct ActivePair<'a> {
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
    outline: &'a [SubpixelPoint],
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
    pub(crate) fn new(convex: &ConvexOutline<'a>) -> Self {
        let (outline, rows) = (convex.points, convex.rows());
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

    /// Goes on to the next row, if there is one. The edges stay where they are: a copy of what was just
    /// stored in parts would have to wait for them.
    #[inline(always)]
    fn advance(&mut self) {
        let Some([left, right]) = &mut self.active else { return };
        let y = left.rows.0 + 1;
        let mut goes_on = y < self.end;
        if goes_on {
            for (edge, side) in [(left, &mut self.left), (right, &mut self.right)] {
                edge.rows.0 = y;
                if y < edge.rows.1 {
                    edge.advance();
                } else if let Some(next) = side.next_edge() {
                    *edge = next;
                } else {
                    goes_on = false;
                    break;
                }
            }
        }
        if !goes_on {
            self.active = None;
        }
    }
}

impl<'a> ActivePair<'a> {
    /// The run of the next row, which may be empty.
    #[inline(always)]
    fn next_row(&mut self) -> Option<Run> {
        let [left, right] = self.active.as_ref()?;
        let run = Run { y: left.rows.0, x: left.x..right.x, edges: [left.index, right.index] };
        self.advance();
        Some(run)
    }

    /// Finds the next rows, if any; whether they are the last. Not inlined: one call a group is cheap
    /// beside drawing its rows.
    #[inline(never)]
    pub(crate) fn next_group(&mut self, group: &mut RunGroup) -> bool {
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
