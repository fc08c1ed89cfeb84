//! The edge table and the active edges: which pixels a polygon covers.
//!
//! An outline in subpixels goes in, runs of covered pixels come out, scanline by scanline. All
//! arithmetic is exact, on integers and for triangles on f64 that hold them without loss, so coverage
//! is: a pixel is covered when its centre lies inside the outline, and a centre exactly on an edge
//! belongs to the polygon on its right or, for a horizontal edge, below (the top-left rule):
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

mod active;
mod convex;
mod triangle;

use std::ops::Range;

use self::active::ActiveEdges;
use self::convex::{ActivePair, ConvexOutline, is_convex};
pub(crate) use self::convex::{ROWS, RunGroup, RunGroups};
pub(crate) use self::triangle::{OneTriangle, Triangle};
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
        let per_unit = 1.0 / unit as f64;
        let (before, error) = divided(-position, unit, per_unit);
        let (step, left_over) = divided(dx, dy, per_unit * f64::from(SUBPIXELS));
        Some(Self {
            rows: (first, end),
            x: -before,
            error,
            step: (step, left_over * i64::from(SUBPIXELS)),
            unit,
            winding,
            index,
        })
    }

    /// Goes on to the next row.
    #[inline(always)]
    fn advance(&mut self) {
        self.error -= self.step.1;
        // All ones where the error is negative: no branch, which could not be predicted.
        let carry = self.error >> 63;
        self.error += self.unit & carry;
        self.x += self.step.0 - carry as i32;
    }
}

/// The quotient rounded down, which must fit an i32, and the remainder, of a positive divisor whose
/// reciprocal is given.
///
/// The quotient is estimated in f64 and rounded to nearest. The estimate is off by less than
/// 2^31 * 2^-51, so what is found is the quotient rounded down or one more; the remainder tells.
#[inline(always)]
fn divided(dividend: i64, divisor: i64, per_divisor: f64) -> (i32, i64) {
    // Adding 1.5 * 2^52 leaves the integer in the lowest bits.
    const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
    let quotient = (dividend as f64 * per_divisor + ROUND).to_bits() as i32;
    let remainder = dividend - i64::from(quotient) * divisor;
    let carry = remainder >> 63;
    (quotient + carry as i32, remainder + (divisor & carry))
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
pub(crate) fn signed_area<V>(outline: &[V], point: impl Fn(&V) -> FixedPoint) -> i128 {
    let [o, rest @ ..] = outline else { return 0 };
    let o = point(o);
    // Within the guard band each product has at most 54 bits.
    let from_o = |v: &V| {
        let p = point(v);
        (i64::from(p.x - o.x), i64::from(p.y - o.y))
    };
    let twice = |a: (i64, i64), b: (i64, i64)| a.0 * b.1 - b.0 * a.1;
    match rest {
        [a, b] => twice(from_o(a), from_o(b)).into(),
        _ => rest
            .iter()
            .zip(rest.iter().skip(1))
            .fold(0, |sum, (a, b)| sum + i128::from(twice(from_o(a), from_o(b)))),
    }
}

/// The same for the chains of an outline; without any it is one contour.
pub(crate) fn signed_area_of(outline: &[FixedPoint], chains: &[Chain]) -> i128 {
    if chains.is_empty() {
        return signed_area(outline, |point| *point);
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
    /// The outline, if it is convex: it needs no table.
    convex: Vec<FixedPoint>,
    rows: Range<i32>,
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
        self.edges.clear();
        if is_convex(outline) {
            self.fill_convex(outline, &rows);
            return;
        }
        self.convex.clear();
        self.rows = rows;
        let ends = outline.iter().skip(1).chain(outline.first());
        let edges = outline.iter().zip(ends).zip(0..);
        self.edges.extend(edges.filter_map(|((&a, &b), index)| Edge::new(a, b, index, &self.rows)));
        self.edges.sort_unstable_by_key(|edge| (edge.rows.0, edge.index));
    }

    /// The same for an outline that is known to be convex, as triangles are.
    #[inline(always)]
    pub(crate) fn fill_convex(&mut self, outline: &[FixedPoint], rows: &Range<i32>) {
        self.edges.clear();
        self.convex.clear();
        self.convex.extend_from_slice(outline);
        self.rows = rows.clone();
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
        self.convex.clear();
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
        self.edges.is_empty() && self.extent(&(i32::MIN..i32::MAX), &self.rows).is_none()
    }

    /// The columns and rows, of those given, that a convex outline extends over, if any.
    #[inline(always)]
    pub(crate) fn extent(
        &self,
        columns: &Range<i32>,
        rows: &Range<i32>,
    ) -> Option<(Range<i32>, Range<i32>)> {
        let extent = |within: &Range<i32>, coordinate: fn(&FixedPoint) -> i32| {
            let values = self.convex.iter().map(coordinate);
            let (min, max) = values.fold((i32::MAX, i32::MIN), |(a, b), v| (a.min(v), b.max(v)));
            first_centre(min).max(within.start)..first_centre(max).min(within.end)
        };
        let (columns, rows) = (extent(columns, |p| p.x), extent(rows, |p| p.y));
        (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
    }

    /// The runs of covered pixels, from top to bottom and from left to right.
    #[inline(always)]
    pub fn runs(&mut self) -> Runs<'_> {
        if !self.edges.is_empty() {
            self.active.clear();
            return Runs(Kind::Any(ActiveEdges::new(
                self.edges.iter(),
                &mut self.active,
                self.fill_rule,
            )));
        }
        let rows = self.rows.clone();
        let outline = ConvexOutline { points: &self.convex, rows };
        Runs(Kind::Convex(outline, None))
    }
}

/// Iterator over the [`Run`]s of an [`EdgeTable`].
#[derive(Debug)]
pub struct Runs<'a>(Kind<'a>);

#[derive(Debug)]
enum Kind<'a> {
    /// A convex outline; its active edges, once a run has been taken.
    Convex(ConvexOutline<'a>, Option<ActivePair<'a>>),
    Any(ActiveEdges<'a>),
}

impl Iterator for Runs<'_> {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        match &mut self.0 {
            Kind::Convex(outline, pair) => {
                pair.get_or_insert_with(|| ActivePair::new(outline)).next()
            }
            Kind::Any(edges) => edges.next_run(),
        }
    }
}

impl<'a> Runs<'a> {
    /// The runs in groups of rows, if the outline is convex and no run has been taken.
    #[inline(always)]
    pub(crate) fn groups(&self) -> Option<RunGroups<'a>> {
        match &self.0 {
            Kind::Convex(outline, None) => Some(RunGroups::Outline(outline.clone())),
            _ => None,
        }
    }
}
