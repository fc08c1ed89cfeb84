//! The edge table and the active edges: which pixels a polygon covers.
//!
//! An outline in subpixels goes in, runs of covered pixels come out, scanline by scanline. All
//! arithmetic is on integers, so coverage is exact: a pixel is covered when its centre lies inside
//! the outline, and a centre exactly on an edge belongs to the polygon on its right or, for a
//! horizontal edge, below (the top-left rule):
//!
//! ```text
//!      0   1   2   3
//!    0 .   .   .   .      A rectangle with corners in the centres of pixels (1, 1) and (3, 3)
//!    1 .   #   #   .      covers its top and left sides, not its bottom and right ones.
//!    2 .   #   #   .
//!    3 .   .   .   .
//! ```
//!
//! A row of pixels belongs to an edge when the row's centre line is at or below the edge's upper
//! end and above its lower end. In such a row the edge stands before pixel column x: the first one
//! whose centre is at or to the right of the edge. Edges are kept sorted by first row; those that
//! cross the current row are active. A convex outline has at most two of them, so it takes a short
//! path; any other outline may have more, and more than one run a row. What is inside there, a
//! [`FillRule`] says.

use std::ops::Range;

use crate::outline::Chain;
use crate::project::{FixedPoint, SUBPIXELS};

/// The distance from a pixel's corner to its centre, in subpixels.
const HALF: i64 = SUBPIXELS as i64 / 2;

/// What is inside an outline, by its winding number: how often it runs around a point, one
/// direction counted up and the other down.
///
/// ```
/// use glam::vec4;
/// use polyscan::{FillRule, ScanConverter, Vertex, Viewport};
///
/// // A square around another, both in the same direction.
/// let square = |size: f32| {
///     [(-size, -size), (size, -size), (size, size), (-size, size)]
///         .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []))
/// };
/// let squares = [square(1.0), square(0.5)];
/// let mut scan = ScanConverter::new(Viewport::new(4, 4)?);
/// for (rule, pixels) in [(FillRule::NonZero, 16), (FillRule::EvenOdd, 12)] {
///     scan.fill_rule = rule;
///     assert_eq!(scan.spans(&squares).map(|span| span.x().len()).sum::<usize>(), pixels);
/// }
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FillRule {
    /// Where the number is not 0. A contour makes a hole if it runs in the other direction than the
    /// one around it.
    #[default]
    NonZero,
    /// Where the number is odd. A contour makes a hole whatever its direction.
    EvenOdd,
}

impl FillRule {
    #[inline(always)]
    fn is_inside(self, winding: i32) -> bool {
        match self {
            Self::NonZero => winding != 0,
            Self::EvenOdd => winding & 1 != 0,
        }
    }
}

/// An edge of an outline: the column it stands before, stepped from row to row by Bresenham's
/// method, without rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Edge {
    /// The rows that the edge crosses; never empty.
    rows: (i32, i32),
    /// The first column whose centre is at or to the right of the edge, in the current row.
    x: i32,
    /// How far beyond the edge that centre is, in 1 / `unit` of a pixel: 0 <= `error` < `unit`.
    error: i64,
    /// The step to the next row: whole pixels to the right and what is left over, 0 <= .. < `unit`.
    step: (i32, i64),
    unit: i64,
    /// +1 for an edge that runs down, -1 for one that runs up; times the winding of its chain.
    winding: i32,
    /// Which edge of the outline this is.
    index: u32,
}

impl Edge {
    /// The edge from `a` to `b` within the given rows; `None` if it crosses no row there, as
    /// horizontal edges do not.
    #[inline]
    fn new(a: FixedPoint, b: FixedPoint, index: u32, rows: &Range<i32>) -> Option<Self> {
        let (upper, lower, winding) = if a.y <= b.y { (a, b, 1) } else { (b, a, -1) };
        let first = first_centre(upper.y).max(rows.start);
        let end = first_centre(lower.y).min(rows.end);
        if first >= end {
            return None;
        }
        let dx = i64::from(lower.x) - i64::from(upper.x);
        let dy = i64::from(lower.y) - i64::from(upper.y);
        // In row y the edge is at upper.x + (y * 256 + 128 - upper.y) * dx / dy subpixels. Less
        // the 128 to the pixel's centre, and in units of 1 / (256 dy) pixel, that is:
        let unit = dy * i64::from(SUBPIXELS);
        let below = i64::from(first) * i64::from(SUBPIXELS) + HALF - i64::from(upper.y);
        let position = (i64::from(upper.x) - HALF) * dy + below * dx;
        let x = -(-position).div_euclid(unit);
        let step = dx.div_euclid(dy);
        Some(Self {
            rows: (first, end),
            x: x as i32,
            error: x * unit - position,
            step: (step as i32, (dx - step * dy) * i64::from(SUBPIXELS)),
            unit,
            winding,
            index,
        })
    }

    /// Goes on to the next row.
    #[inline(always)]
    fn advance(&mut self) {
        self.x += self.step.0;
        self.error -= self.step.1;
        if self.error < 0 {
            self.error += self.unit;
            self.x += 1;
        }
    }
}

/// The first row whose centre line is at or below `y` subpixels; the same for columns.
#[inline(always)]
pub(crate) fn first_centre(y: i32) -> i32 {
    // -(-(y - 128) / 256) rounded down, without leaving the i32 range.
    let above = i64::from(y) - HALF;
    (above + i64::from(SUBPIXELS) - 1).div_euclid(i64::from(SUBPIXELS)) as i32
}

/// Twice the signed area of an outline in square subpixels; positive when it runs clockwise as seen
/// on the screen.
#[inline(always)]
pub(crate) fn signed_area(outline: impl Iterator<Item = FixedPoint> + Clone) -> i128 {
    let Some(o) = outline.clone().next() else { return 0 };
    // Within the guard band each product has at most 54 bits.
    let from_o = |p: FixedPoint| (i64::from(p.x - o.x), i64::from(p.y - o.y));
    let next = outline.clone().skip(1);
    next.clone()
        .zip(next.skip(1))
        .map(|(a, b)| (from_o(a), from_o(b)))
        .fold(0, |sum, (a, b)| sum + i128::from(a.0 * b.1 - b.0 * a.1))
}

/// The same for the chains of an outline; without any it is one contour.
pub(crate) fn signed_area_of(outline: &[FixedPoint], chains: &[Chain]) -> i128 {
    if chains.is_empty() {
        return signed_area(outline.iter().copied());
    }
    let Some(&o) = outline.first() else { return 0 };
    // All chains together are closed, so any point will do as the origin.
    let from_o = |p: &FixedPoint| (i64::from(p.x - o.x), i64::from(p.y - o.y));
    let cross = |(a, b): ((i64, i64), (i64, i64))| i128::from(a.0 * b.1 - b.0 * a.1);
    chain_edges(outline, chains)
        .map(|(a, b, _, winding)| i128::from(winding) * cross((from_o(a), from_o(b))))
        .sum()
}

/// The edges of chains: both ends, the index of the first one, and the winding.
fn chain_edges<'a>(
    points: &'a [FixedPoint],
    chains: &'a [Chain],
) -> impl Iterator<Item = (&'a FixedPoint, &'a FixedPoint, u32, i32)> {
    let mut start = 0;
    chains.iter().flat_map(move |&Chain { end, winding }| {
        let first = std::mem::replace(&mut start, end);
        let points = points.get(first..end).unwrap_or_default();
        let edges = points.iter().zip(points.iter().skip(1)).zip(first as u32..);
        edges.map(move |((a, b), index)| (a, b, index, winding))
    })
}

/// A run of pixels in one row, between two edges of the outline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The row.
    pub y: i32,
    /// The columns; never empty.
    pub x: Range<i32>,
    /// The outline's edges on the left and on the right; edge k goes from vertex k to the next.
    pub edges: [u32; 2],
}

/// The edges of an outline, sorted by first row, with the memory they live in: reuse it, and it
/// stops allocating.
///
/// ```
/// use polyscan::edge_table::EdgeTable;
/// use polyscan::project::FixedPoint;
///
/// let outline = [(0, 0), (1024, 0), (0, 1024)].map(|(x, y)| FixedPoint { x, y });
/// let mut table = EdgeTable::new();
/// table.fill(&outline, 0..100);
/// let runs: Vec<_> = table.runs().map(|run| (run.y, run.x)).collect();
/// assert_eq!(runs, [(0, 0..3), (1, 0..2), (2, 0..1)]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct EdgeTable {
    /// What is inside the outline.
    pub fill_rule: FillRule,
    edges: Vec<Edge>,
    active: Vec<Edge>,
    convex: bool,
}

impl EdgeTable {
    /// A table without edges.
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the edges by those of one closed contour, as far as they cross the given rows. It
    /// may be concave or cross itself: the [`fill_rule`](Self::fill_rule) says what is inside.
    /// Positions must lie within 2^26 subpixels of the origin, which is what the guard band
    /// grants; the time does not depend on how many rows or columns lie outside.
    pub fn fill(&mut self, outline: &[FixedPoint], rows: Range<i32>) {
        self.convex = is_convex(outline);
        self.edges.clear();
        let ends = outline.iter().skip(1).chain(outline.first());
        let edges = outline.iter().zip(ends).zip(0..);
        self.edges.extend(edges.filter_map(|((&a, &b), index)| Edge::new(a, b, index, &rows)));
        self.edges.sort_unstable_by_key(|edge| (edge.rows.0, edge.index));
    }

    /// The same with an outline of any number of contours, as [`Chain`]s: edge k goes from point k
    /// to the next one, unless a chain ends at k.
    ///
    /// ```
    /// use polyscan::edge_table::EdgeTable;
    /// use polyscan::outline::Chain;
    /// use polyscan::project::FixedPoint;
    ///
    /// // A square of 4 pixels, and one of 2 in its middle that takes it back.
    /// let square = |from: i32, to: i32| {
    ///     [(from, from), (to, from), (to, to), (from, to), (from, from)]
    ///         .map(|(x, y)| FixedPoint { x: x * 256, y: y * 256 })
    /// };
    /// let points = [square(0, 4), square(1, 3)].concat();
    /// let chains = [Chain { end: 5, winding: 1 }, Chain { end: 10, winding: -1 }];
    /// let mut table = EdgeTable::new();
    /// table.fill_chains(&points, &chains, 1..2);
    /// let runs: Vec<_> = table.runs().map(|run| run.x).collect();
    /// assert_eq!(runs, [0..1, 3..4]);
    /// ```
    pub fn fill_chains(&mut self, points: &[FixedPoint], chains: &[Chain], rows: Range<i32>) {
        self.convex = false;
        self.edges.clear();
        self.edges.extend(chain_edges(points, chains).filter_map(|(&a, &b, index, winding)| {
            let mut edge = Edge::new(a, b, index, &rows)?;
            edge.winding = edge.winding.wrapping_mul(winding);
            Some(edge)
        }));
        self.edges.sort_unstable_by_key(|edge| (edge.rows.0, edge.index));
    }

    /// The one or the other: without chains the outline is one contour.
    #[inline(always)]
    pub(crate) fn fill_outline(
        &mut self,
        outline: &[FixedPoint],
        chains: &[Chain],
        rows: Range<i32>,
    ) {
        if chains.is_empty() {
            self.fill(outline, rows);
        } else {
            self.fill_chains(outline, chains, rows);
        }
    }

    /// Whether no row is crossed.
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// The runs of covered pixels, from top to bottom and from left to right.
    pub fn runs(&mut self) -> Runs<'_> {
        let mut rest = self.edges.iter();
        if !self.convex {
            self.active.clear();
            return Runs(Kind::Any(ActiveEdges::new(rest, &mut self.active, self.fill_rule)));
        }
        let pair = match (rest.next(), rest.next()) {
            (Some(&a), Some(&b)) => Some([a, b]),
            _ => None,
        };
        Runs(Kind::Convex(ActivePair { pair, rest }))
    }
}

/// Whether an outline winds once around a convex region, or around nothing. Going around it, a
/// convex outline never turns both left and right, and it turns downwards only once.
fn is_convex(outline: &[FixedPoint]) -> bool {
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

/// Iterator over the [`Run`]s of an [`EdgeTable`].
#[derive(Debug)]
pub struct Runs<'a>(Kind<'a>);

#[derive(Debug)]
enum Kind<'a> {
    Convex(ActivePair<'a>),
    Any(ActiveEdges<'a>),
}

impl Iterator for Runs<'_> {
    type Item = Run;

    #[inline(always)]
    fn next(&mut self) -> Option<Run> {
        match &mut self.0 {
            Kind::Convex(pair) => pair.next_run(),
            Kind::Any(edges) => {
                // Field by field, so that the short path need not write its own to memory.
                let Run { y, x, edges: [left, right] } = edges.next_run()?;
                Some(Run { y, x: x.start..x.end, edges: [left, right] })
            }
        }
    }
}

/// The two active edges of a convex outline. Both chains of its edges, left and right, are without
/// gaps, so when one edge ends the next in the table takes its place.
#[derive(Debug)]
struct ActivePair<'a> {
    pair: Option<[Edge; 2]>,
    rest: std::slice::Iter<'a, Edge>,
}

impl ActivePair<'_> {
    #[inline(always)]
    fn next_run(&mut self) -> Option<Run> {
        loop {
            let [a, b] = self.pair.as_mut()?;
            let y = a.rows.0;
            let [left, right] = if a.x <= b.x { [&*a, &*b] } else { [&*b, &*a] };
            let run = Run { y, x: left.x..right.x, edges: [left.index, right.index] };
            let mut done = false;
            for edge in [a, b] {
                edge.rows.0 = y + 1;
                edge.advance();
                if edge.rows.0 == edge.rows.1 {
                    match self.rest.next() {
                        Some(next) => *edge = *next,
                        None => done = true,
                    }
                }
            }
            if done {
                self.pair = None;
            }
            if !run.x.is_empty() {
                return Some(run);
            }
        }
    }
}

/// The active edges of any outline, sorted by column.
#[derive(Debug)]
struct ActiveEdges<'a> {
    rule: FillRule,
    y: i32,
    active: &'a mut Vec<Edge>,
    /// The first active edge in this row that no run has passed yet.
    next: usize,
    rest: std::iter::Peekable<std::slice::Iter<'a, Edge>>,
}

impl<'a> ActiveEdges<'a> {
    fn new(rest: std::slice::Iter<'a, Edge>, active: &'a mut Vec<Edge>, rule: FillRule) -> Self {
        let mut edges = Self { rule, y: 0, active, next: 0, rest: rest.peekable() };
        edges.enter_row();
        edges
    }

    /// Takes in the edges that begin in this row, or in the next row that has any, and sorts.
    fn enter_row(&mut self) {
        if self.active.is_empty() {
            self.y = self.rest.peek().map_or(self.y, |edge| edge.rows.0);
        }
        while let Some(edge) = self.rest.next_if(|edge| edge.rows.0 == self.y) {
            self.active.push(*edge);
        }
        // Mostly sorted already, where this is fast; the index makes the order unique. A stable sort
        // would allocate.
        self.active.sort_unstable_by_key(|edge| (edge.x, edge.index));
        self.next = 0;
    }

    #[inline(never)]
    fn next_run(&mut self) -> Option<Run> {
        loop {
            if let Some(run) = self.run_in_row() {
                return Some(run);
            }
            self.y += 1;
            self.active.retain_mut(|edge| {
                edge.advance();
                edge.rows.1 > self.y
            });
            self.enter_row();
            if self.active.is_empty() {
                return None;
            }
        }
    }

    /// The next run in this row: from where the outline is entered to where it is left.
    fn run_in_row(&mut self) -> Option<Run> {
        let mut left: Option<Edge> = None;
        let mut winding = 0i32;
        while let Some(edge) = self.active.get(self.next) {
            self.next += 1;
            winding = edge.winding.wrapping_add(winding);
            let start = *left.get_or_insert(*edge);
            if !self.rule.is_inside(winding) {
                if start.x < edge.x {
                    let edges = [start.index, edge.index];
                    return Some(Run { y: self.y, x: start.x..edge.x, edges });
                }
                left = None;
            }
        }
        None
    }
}
