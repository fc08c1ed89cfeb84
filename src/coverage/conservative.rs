//! Conservative coverage: the pixels that an outline touches, or those that it covers wholly.
//!
//! In each row every edge passes through some pixels next to each other. Through the others no part of
//! the outline passes, so each lies inside with its centre or outside with it. Hence the pixels that a
//! polygon touches are those whose centres it covers and those that its edges pass through; those that
//! it covers wholly are the former without the latter.
//!
//! ```text
//!     . . . o .      an edge from o to o passes through the pixels / in these rows. Where it crosses
//!     . . / / .      the border of two rows is found without rounding: floor and ceiling are those of
//!     . / / . .      a quotient of whole numbers.
//!     . o . . .
//! ```

use std::iter::Peekable;
use std::ops::Range;

use crate::coverage::active::ActiveEdges;
use crate::coverage::convex::ActivePair;
use crate::coverage::rule::{CoverageRule, OutsidePolygon};
use crate::coverage::run::{AT_EDGE, Run};
use crate::subpixel::{HALF_PIXEL, SUBPIXELS, SubpixelPoint};

/// The edges of an outline by the rows that they pass through, with the memory that the work takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct TouchTable {
    rule: CoverageRule,
    columns: Range<i32>,
    rows: Range<i32>,
    edges: Vec<TouchEdge>,
    active: Vec<TouchEdge>,
    /// The pixels of each active edge in a row: the first column, the one after the last, the edge.
    touched: Vec<(i32, i32, usize)>,
    /// Pixels to be clamped: the column, how far the active edge is from its centre, the edge.
    clamped: Vec<(i32, f64, usize)>,
    /// The runs of the row by the rule of centres.
    centres: Vec<Run>,
    runs: Vec<Run>,
}

/// An edge that passes through pixels.
#[derive(Clone, Copy, Debug)]
struct TouchEdge {
    upper: SubpixelPoint,
    lower: SubpixelPoint,
    /// The first row and the one after the last.
    rows: (i32, i32),
    index: u32,
}

impl TouchEdge {
    fn new(a: SubpixelPoint, b: SubpixelPoint, index: u32) -> Option<Self> {
        let (upper, lower) = if a.y <= b.y { (a, b) } else { (b, a) };
        // Along the border of two rows it passes through none of their pixels.
        let rows =
            (floor(upper.y.into(), SUBPIXELS.into()), ceil(lower.y.into(), SUBPIXELS.into()));
        (rows.0 < rows.1).then_some(Self { upper, lower, rows, index })
    }

    /// The columns of the pixels in a row that it passes through.
    fn columns(&self, row: i32) -> Range<i32> {
        let (a, b) = (self.upper, self.lower);
        let (dx, dy) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
        let unit = i64::from(SUBPIXELS);
        if dy == 0 {
            let (left, right) = (a.x.min(b.x), a.x.max(b.x));
            return floor(left.into(), unit)..ceil(right.into(), unit);
        }
        let top = i64::from(row) * unit;
        let from = top.max(a.y.into()) - i64::from(a.y);
        let to = (top + unit).min(b.y.into()) - i64::from(a.y);
        // Places in 1 / (256 dy) pixel.
        let at = |below: i64| i64::from(a.x) * dy + below * dx;
        let (left, right) = if dx < 0 { (at(to), at(from)) } else { (at(from), at(to)) };
        floor(left, dy * unit)..ceil(right, dy * unit)
    }

    /// The square of the distance, in subpixels, of a pixel's centre.
    fn distance(&self, x: i32, y: i32) -> f64 {
        let centre = |c: i32| (i64::from(c) * i64::from(SUBPIXELS) + HALF_PIXEL) as f64;
        let from = |p: SubpixelPoint| [centre(x) - f64::from(p.x), centre(y) - f64::from(p.y)];
        let (p, dx, dy) = (
            from(self.upper),
            f64::from(self.lower.x) - f64::from(self.upper.x),
            f64::from(self.lower.y) - f64::from(self.upper.y),
        );
        let square = dx * dx + dy * dy;
        let along = if square > 0.0 { (p[0] * dx + p[1] * dy) / square } else { 0.0 };
        let along = along.clamp(0.0, 1.0);
        let off = [p[0] - along * dx, p[1] - along * dy];
        off[0] * off[0] + off[1] * off[1]
    }
}

fn floor(dividend: i64, divisor: i64) -> i32 {
    dividend.div_euclid(divisor) as i32
}

fn ceil(dividend: i64, divisor: i64) -> i32 {
    -(-dividend).div_euclid(divisor) as i32
}

impl TouchTable {
    /// Begins with no edges, for a rule, and the columns to visit.
    pub(crate) fn begin(&mut self, rule: CoverageRule, columns: &Range<i32>, rows: &Range<i32>) {
        (self.rule, self.columns, self.rows) = (rule, columns.clone(), rows.clone());
        self.edges.clear();
    }

    /// Adds an edge.
    pub(crate) fn push(&mut self, a: SubpixelPoint, b: SubpixelPoint, index: u32) {
        let edge = TouchEdge::new(a, b, index);
        let is_in_rows =
            |edge: &TouchEdge| edge.rows.0 < self.rows.end && self.rows.start < edge.rows.1;
        self.edges.extend(edge.filter(is_in_rows));
    }

    /// Sorts the edges, after the last.
    pub(crate) fn finish(&mut self) {
        self.edges.sort_unstable_by_key(|edge| (edge.rows.0, edge.index));
    }

    /// Whether no row may have a pixel that the edges pass through.
    pub(crate) fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// The runs by the rule, from those by the rule of centres.
    pub(crate) fn runs<'a>(&'a mut self, centres: CentreRuns<'a>) -> ConservativeRuns<'a> {
        self.active.clear();
        self.runs.clear();
        let y = self.rows.start;
        ConservativeRuns { table: self, centres: centres.peekable(), next_edge: 0, y, next_run: 0 }
    }
}

/// The runs of an outline by the rule of centres.
#[derive(Debug)]
pub(crate) enum CentreRuns<'a> {
    Convex(ActivePair<'a>),
    Any(ActiveEdges<'a>),
}

impl Iterator for CentreRuns<'_> {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        match self {
            Self::Convex(pair) => pair.next(),
            Self::Any(edges) => edges.next_run(),
        }
    }
}

/// The runs of an outline, row by row, by a rule of conservative coverage.
#[derive(Debug)]
pub(crate) struct ConservativeRuns<'a> {
    table: &'a mut TouchTable,
    centres: Peekable<CentreRuns<'a>>,
    next_edge: usize,
    /// The row after the one whose runs were found last.
    y: i32,
    /// The first of its runs that was not taken yet.
    next_run: usize,
}

impl ConservativeRuns<'_> {
    pub(crate) fn next_run(&mut self) -> Option<Run> {
        loop {
            if let Some(run) = self.table.runs.get(self.next_run) {
                self.next_run += 1;
                return Some(run.clone());
            }
            if !self.find_row() {
                return None;
            }
        }
    }

    /// Finds the runs of the next row that may have any; whether there is one.
    fn find_row(&mut self) -> bool {
        let Self { table, centres, next_edge, y, next_run } = self;
        *next_run = 0;
        table.runs.clear();
        table.active.retain(|edge| edge.rows.1 > *y);
        if table.active.is_empty() {
            let next = table.edges.get(*next_edge).map(|edge| edge.rows.0);
            let centre = centres.peek().map(|run| run.y);
            let Some(first) = next.into_iter().chain(centre).min() else { return false };
            *y = first.max(*y);
        }
        if *y >= table.rows.end {
            return false;
        }
        while let Some(edge) = table.edges.get(*next_edge).filter(|edge| edge.rows.0 <= *y) {
            if edge.rows.1 > *y {
                table.active.push(*edge);
            }
            *next_edge += 1;
        }
        table.centres.clear();
        while let Some(run) = centres.next_if(|run| run.y <= *y) {
            table.centres.push(run);
        }
        table.find_runs(*y);
        *y += 1;
        true
    }
}

impl TouchTable {
    /// Finds the runs of a row.
    fn find_runs(&mut self, y: i32) {
        let Self { columns, active, touched, .. } = self;
        touched.clear();
        touched.extend(active.iter().enumerate().filter_map(|(i, edge)| {
            let Range { start, end } = edge.columns(y);
            let (start, end) = (start.max(columns.start), end.min(columns.end));
            (start < end).then_some((start, end, i))
        }));
        touched.sort_unstable();
        match self.rule {
            CoverageRule::Centre => std::mem::swap(&mut self.runs, &mut self.centres),
            CoverageRule::Inner => self.take_away(),
            CoverageRule::Outer(OutsidePolygon::Extrapolate) => self.join(y),
            CoverageRule::Outer(OutsidePolygon::Clamp) => self.add_clamped(y),
        }
    }

    /// The runs by centres without the pixels that edges pass through.
    fn take_away(&mut self) {
        let Self { touched, centres, runs, .. } = self;
        let mut passed = 0;
        for Run { y, x, edges } in centres.drain(..) {
            let mut start = x.start;
            // Those that end before this run end before all later ones.
            while touched.get(passed).is_some_and(|(_, end, _)| *end <= start) {
                passed += 1;
            }
            for &(first, end, _) in touched[passed..].iter().take_while(|edge| edge.0 < x.end) {
                if start < first {
                    runs.push(Run { y, x: start..first, edges });
                }
                start = start.max(end);
            }
            if start < x.end {
                runs.push(Run { y, x: start..x.end, edges });
            }
        }
    }

    /// The runs by centres and the pixels that edges pass through, joined.
    fn join(&mut self, y: i32) {
        let Self { active, touched, centres, runs, .. } = self;
        let edge = |&(start, end, i): &(i32, i32, usize)| Run {
            y,
            x: start..end,
            edges: [active[i].index; 2],
        };
        centres.extend(touched.iter().map(edge));
        centres.sort_unstable_by_key(|run| (run.x.start, run.x.end, run.edges));
        for run in centres.drain(..) {
            match runs.last_mut() {
                Some(last) if run.x.start <= last.x.end => {
                    if last.x.end < run.x.end {
                        (last.x.end, last.edges[1]) = (run.x.end, run.edges[1]);
                    }
                }
                _ => runs.push(run),
            }
        }
    }

    /// The runs by centres, and each other pixel that edges pass through with the nearest of them.
    fn add_clamped(&mut self, y: i32) {
        let Self { active, touched, clamped, centres, runs, .. } = self;
        clamped.clear();
        let mut passed = 0;
        for &(start, end, i) in &*touched {
            while centres.get(passed).is_some_and(|run| run.x.end <= start) {
                passed += 1;
            }
            let (mut covering, mut x) = (passed, start);
            while x < end {
                match centres.get(covering) {
                    Some(run) if run.x.end <= x => covering += 1,
                    Some(run) if run.x.contains(&x) => x = run.x.end,
                    _ => {
                        clamped.push((x, active[i].distance(x, y), i));
                        x += 1;
                    }
                }
            }
        }
        clamped
            .sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        clamped.dedup_by_key(|(x, ..)| *x);
        let mut centres = centres.drain(..).peekable();
        for &(x, _, i) in &*clamped {
            while let Some(run) = centres.next_if(|run| run.x.start < x) {
                runs.push(run);
            }
            runs.push(Run { y, x: x..x + 1, edges: [active[i].index, AT_EDGE] });
        }
        runs.extend(centres);
    }
}
