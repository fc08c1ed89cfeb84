//! The edge table: the edges of any outline, sorted by first row.

use std::ops::Range;

use crate::coverage::active::ActiveEdges;
use crate::coverage::area::chain_edges;
use crate::coverage::conservative::{CentreRuns, TouchTable};
use crate::coverage::convex::{ActivePair, ConvexOutline, is_convex};
use crate::coverage::edge::Edge;
use crate::coverage::fill_rule::FillRule;
use crate::coverage::rule::CoverageRule;
use crate::coverage::run::Run;
use crate::coverage::shape::{AnyRuns, Coverage};
use crate::outline::Chain;
use crate::subpixel::SubpixelPoint;

/// The edges of an outline, sorted by first row, with the memory they live in: reuse it, and it
/// stops allocating.
///
/// ```
/// use polyscan::coverage::EdgeTable;
/// use polyscan::subpixel::SubpixelPoint;
///
/// let outline = [(0, 0), (1024, 0), (0, 1024)].map(|(x, y)| SubpixelPoint { x, y });
/// let mut table = EdgeTable::new();
/// table.fill(&outline, 0..100);
/// let runs: Vec<_> = table.runs().map(|run| (run.y, run.x)).collect();
/// assert_eq!(runs, [(0, 0..3), (1, 0..2), (2, 0..1)]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct EdgeTable {
    /// What is inside the outline.
    pub fill_rule: FillRule,
    content: Content,
    /// The points of a convex outline.
    points: Vec<SubpixelPoint>,
    edges: Vec<Edge>,
    active: Vec<Edge>,
    rows: Range<i32>,
    /// What to find besides, and in which columns, if not coverage by centres alone.
    conservative: Option<(CoverageRule, Range<i32>)>,
    touch: TouchTable,
}

/// What a table was filled with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Content {
    /// A convex outline, in `points`: it needs no table.
    #[default]
    Convex,
    /// Any other, in `edges`.
    Edges,
}

impl EdgeTable {
    /// A table without edges.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the edges by those of one closed contour, as far as they cross the given rows. It
    /// may be concave or cross itself: the [`fill_rule`](Self::fill_rule) says what is inside.
    /// Rows count from the viewport's top, as the points do; [`Settings::rows`](crate::Settings::rows)
    /// has those to visit. An outline that reaches farther than 2^26 subpixels from the origin covers
    /// nothing; [`SubpixelPoint::project`] gives no such points. The time does not depend on how many rows or
    /// columns lie outside.
    pub fn fill(&mut self, outline: &[SubpixelPoint], rows: Range<i32>) {
        if !self.begin(outline, rows) {
            return;
        }
        if self.conservative.is_some() {
            let ends = outline.iter().skip(1).chain(outline.first());
            let edges = outline.iter().zip(ends).zip(0..);
            edges.for_each(|((&a, &b), index)| self.touch.push(a, b, index));
            self.touch.finish();
        }
        if is_convex(outline) {
            self.content = Content::Convex;
            self.points.clear();
            self.points.extend_from_slice(outline);
            return;
        }
        let ends = outline.iter().skip(1).chain(outline.first());
        let edges = outline.iter().zip(ends).zip(0..);
        self.edges.extend(edges.filter_map(|((&a, &b), index)| Edge::new(a, b, index, &self.rows)));
        self.edges.sort_unstable_by_key(|edge| (edge.rows.0, edge.index));
    }

    /// Replaces the edges by those of an outline of any number of contours, as [`Chain`]s: edge k goes
    /// from point k to the next one, unless a chain ends at k. Without chains the points are one
    /// closed contour, as in [`fill`](Self::fill).
    ///
    /// ```
    /// use polyscan::coverage::EdgeTable;
    /// use polyscan::outline::Chain;
    /// use polyscan::subpixel::SubpixelPoint;
    ///
    /// // A square of 4 pixels, and one of 2 in its middle that takes it back.
    /// let square = |from: i32, to: i32| {
    ///     [(from, from), (to, from), (to, to), (from, to), (from, from)]
    ///         .map(|(x, y)| SubpixelPoint { x: x * 256, y: y * 256 })
    /// };
    /// let points = [square(0, 4), square(1, 3)].concat();
    /// let chains = [Chain { end: 5, winding: 1 }, Chain { end: 10, winding: -1 }];
    /// let mut table = EdgeTable::new();
    /// table.fill_chains(&points, &chains, 1..2);
    /// let runs: Vec<_> = table.runs().map(|run| run.x).collect();
    /// assert_eq!(runs, [0..1, 3..4]);
    /// ```
    pub fn fill_chains(&mut self, points: &[SubpixelPoint], chains: &[Chain], rows: Range<i32>) {
        if chains.is_empty() {
            self.fill(points, rows);
            return;
        }
        if !self.begin(points, rows) {
            return;
        }
        if self.conservative.is_some() {
            let edges = chain_edges(points, chains).filter(|edge| edge.3 != 0);
            edges.for_each(|(&a, &b, index, _)| self.touch.push(a, b, index));
            self.touch.finish();
        }
        self.edges.extend(chain_edges(points, chains).filter_map(|(&a, &b, index, winding)| {
            let mut edge = Edge::new(a, b, index, &self.rows)?;
            edge.winding = edge.winding.wrapping_mul(winding);
            Some(edge)
        }));
        self.edges.sort_unstable_by_key(|edge| (edge.rows.0, edge.index));
    }

    /// Begins with an empty table; whether the points are near enough for exact sums.
    #[inline(always)]
    fn begin(&mut self, points: &[SubpixelPoint], rows: Range<i32>) -> bool {
        const FARTHEST: u32 = 1 << 26;
        (self.content, self.rows) = (Content::Edges, rows);
        self.edges.clear();
        if let Some((rule, columns)) = &self.conservative {
            self.touch.begin(*rule, columns, &self.rows);
        }
        points.iter().all(|p| p.x.unsigned_abs().max(p.y.unsigned_abs()) <= FARTHEST)
    }

    /// Whether no row is crossed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        if self.conservative.is_some() && !self.touch.is_empty() {
            return false;
        }
        match self.content {
            Content::Convex => self.outline().extent(&(i32::MIN..i32::MAX)).is_none(),
            Content::Edges => self.edges.is_empty(),
        }
    }

    /// Has the next outlines filled by a rule, in the given columns.
    pub(crate) fn set_rule(&mut self, rule: CoverageRule, columns: &Range<i32>) {
        self.conservative = match rule {
            CoverageRule::Centre => None,
            rule => Some((rule, columns.clone())),
        };
    }

    fn outline(&self) -> ConvexOutline<'_> {
        let Range { start, end } = self.rows;
        ConvexOutline { points: &self.points, first_row: start, end_row: end }
    }

    /// What the outline covers.
    #[inline(always)]
    pub(crate) fn coverage(&mut self) -> Coverage<'_> {
        if self.conservative.is_some() {
            return self.conservative_coverage();
        }
        match self.content {
            Content::Convex => Coverage::Convex(self.outline()),
            Content::Edges => {
                self.active.clear();
                let (edges, active) = (self.edges.iter(), &mut self.active);
                Coverage::Any(AnyRuns::Active(ActiveEdges::new(edges, active, self.fill_rule)))
            }
        }
    }

    #[cold]
    fn conservative_coverage(&mut self) -> Coverage<'_> {
        let Self { fill_rule, content, points, edges, active, rows, touch, .. } = self;
        let centres = match content {
            Content::Convex => {
                let outline = ConvexOutline { points, first_row: rows.start, end_row: rows.end };
                CentreRuns::Convex(ActivePair::new(&outline))
            }
            Content::Edges => {
                active.clear();
                CentreRuns::Any(ActiveEdges::new(edges.iter(), active, *fill_rule))
            }
        };
        Coverage::Any(AnyRuns::Conservative(touch.runs(centres)))
    }

    /// The runs of covered pixels, from top to bottom and from left to right.
    pub fn runs(&mut self) -> Runs<'_> {
        Runs(match self.coverage() {
            Coverage::Any(edges) => Rows::Any(edges),
            Coverage::Convex(outline) => Rows::Convex(ActivePair::new(&outline)),
            // A table holds points, never a triangle's lines.
            Coverage::Triangle(_) => Rows::None,
        })
    }
}

/// Iterator over the [`Run`]s of an [`EdgeTable`].
#[derive(Debug)]
pub struct Runs<'a>(Rows<'a>);

#[derive(Debug)]
enum Rows<'a> {
    None,
    Convex(ActivePair<'a>),
    Any(AnyRuns<'a>),
}

impl Iterator for Runs<'_> {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        match &mut self.0 {
            Rows::None => None,
            Rows::Convex(pair) => pair.next(),
            Rows::Any(edges) => edges.next_run(),
        }
    }
}
