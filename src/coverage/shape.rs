//! What a polygon covers, as a value: a triangle's lines, a convex outline, or the edges of any other.

use std::ops::Range;

use crate::coverage::active::ActiveEdges;
use crate::coverage::conservative::ConservativeRuns;
use crate::coverage::convex::{ActivePair, ConvexOutline};
use crate::coverage::run::{Run, RunGroup};
use crate::coverage::triangle::{BatchLane, TriangleEdges, TriangleRows};

/// The pixels that a polygon covers.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "it is made where it is used, and never kept")]
pub(crate) enum Coverage<'a> {
    /// A triangle whose lines are known, and exact.
    Triangle(BatchLane<'a>),
    /// An outline with one run in each row.
    Convex(ConvexOutline<'a>),
    /// Any other, or by another rule than that of centres.
    Any(AnyRuns<'a>),
}

/// Runs that are found one by one.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "it is made where it is used, and never kept")]
pub(crate) enum AnyRuns<'a> {
    Active(ActiveEdges<'a>),
    Conservative(ConservativeRuns<'a>),
}

impl AnyRuns<'_> {
    #[inline(never)]
    pub(crate) fn next_run(&mut self) -> Option<Run> {
        match self {
            Self::Active(edges) => edges.next_run(),
            Self::Conservative(runs) => runs.next_run(),
        }
    }
}

impl Coverage<'_> {
    /// The columns, of those given, and the rows that it extends over. `None` if there are none, and for
    /// an outline that is not convex, of which nobody asks.
    #[inline(always)]
    pub(crate) fn extent(&self, columns: &Range<i32>) -> Option<(Range<i32>, Range<i32>)> {
        match self {
            Self::Triangle(triangle) => triangle.extent(columns),
            Self::Convex(outline) => outline.extent(columns),
            Self::Any(_) => None,
        }
    }

    /// Calls `f` for groups of runs, from top to bottom. If `edges` is true, [`RunGroup::edges`] is
    /// filled in; a triangle whose lines are known never fills it: its callers need no edges.
    #[inline(always)]
    pub(crate) fn for_each_group(self, edges: bool, mut f: impl FnMut(&RunGroup)) {
        let found;
        // Options, not one enum: the rows of a triangle are to stay in registers.
        let (mut rows, mut pair, mut any) = (None, None, None);
        match self {
            Self::Triangle(triangle) => rows = Some(TriangleRows::new(triangle)),
            Self::Convex(outline) => {
                found = if edges { None } else { TriangleEdges::of(&outline) };
                match &found {
                    Some(edges) => rows = Some(TriangleRows::new(BatchLane { edges, lane: 0 })),
                    None => pair = Some(ActivePair::new(&outline)),
                }
            }
            Self::Any(active) => any = Some(active),
        }
        let mut group = RunGroup::EMPTY;
        loop {
            let is_last = match (&mut rows, &mut pair, &mut any) {
                (Some(rows), ..) => rows.next_group(&mut group),
                (None, Some(pair), _) => pair.next_group(&mut group),
                (None, None, Some(active)) => {
                    let Some(run) = active.next_run() else { return };
                    group = RunGroup::of(&run);
                    false
                }
                (None, None, None) => return,
            };
            f(&group);
            if is_last {
                return;
            }
        }
    }
}
