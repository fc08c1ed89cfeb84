//! The active edges of any outline: those that cross the current row, sorted by column.

use crate::coverage::edge::Edge;
use crate::coverage::fill_rule::FillRule;
use crate::coverage::run::Run;

/// The active edges of any outline, sorted by column.
#[derive(Debug)]
pub(crate) struct ActiveEdges<'a> {
    rule: FillRule,
    y: i32,
    active: &'a mut Vec<Edge>,
    /// The first active edge in this row that no run has passed yet.
    next: usize,
    rest: std::iter::Peekable<std::slice::Iter<'a, Edge>>,
}

impl<'a> ActiveEdges<'a> {
    pub(crate) fn new(
        rest: std::slice::Iter<'a, Edge>,
        active: &'a mut Vec<Edge>,
        rule: FillRule,
    ) -> Self {
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
        self.sort();
        self.next = 0;
    }

    /// Sorts by column; the index makes the order unique. From row to row few edges pass others, so
    /// inserting each among those before it takes a step or two. Where it takes more, a sort for any
    /// order goes on: one that does not allocate, as a stable sort would.
    fn sort(&mut self) {
        let key = |edge: &Edge| (edge.x, edge.index);
        let mut steps = 4 * self.active.len();
        for end in 1..self.active.len() {
            let edge = self.active[end];
            let mut place = end;
            while place > 0 && key(&edge) < key(&self.active[place - 1]) {
                self.active[place] = self.active[place - 1];
                place -= 1;
            }
            self.active[place] = edge;
            let Some(left) = steps.checked_sub(end - place) else {
                self.active.sort_unstable_by_key(key);
                return;
            };
            steps = left;
        }
    }

    pub(crate) fn next_run(&mut self) -> Option<Run> {
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
