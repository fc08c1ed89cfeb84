//! Convex outlines. A row of one has one run, so it needs no table: two active edges walk down its
//! left and its right side. And of a triangle, whose edges are few, the runs of several rows are
//! found at once.

use std::ops::Range;

use super::{Edge, HALF, Run, first_centre, signed_area};
use crate::project::{FixedPoint, SUBPIXELS};

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

impl ConvexOutline<'_> {
    /// Calls `f` for groups of runs, from top to bottom; `edges` says whether the edges of each run
    /// are asked for.
    #[inline(always)]
    pub(crate) fn for_each_group(&self, edges: bool, mut f: impl FnMut(&RunGroup)) {
        let mut group = RunGroup::EMPTY;
        let mut triangle = match self.points {
            &[a, b, c] if !edges && Triangle::is_exact([a, b, c]) => {
                Some(Triangle::new([a, b, c], &self.rows))
            }
            _ => None,
        };
        // Not in one enum with the triangle, which is to stay in registers.
        let mut pair = None;
        loop {
            let is_last = match &mut triangle {
                Some(triangle) => triangle.next_group(&mut group),
                None => ActivePair::next_group(&mut pair, self, &mut group),
            };
            f(&group);
            if is_last {
                return;
            }
        }
    }
}

/// A triangle as three lines. What is between them in a row is the row's run: a row belongs to two
/// edges, and the third's line, drawn out, lies outside of them.
#[derive(Debug)]
struct Triangle {
    sides: [Line; 3],
    /// The columns and the rows that it extends over; in the columns, [`ROUND`] is added.
    columns: (f64, f64),
    rows: (i32, i32),
}

/// The line through an edge of a triangle.
///
/// In a row it stands before column p / u rounded up, as an [`Edge`] does, where u = 256 dy and
/// p = u (x - 128) / 256 are whole numbers, with x in subpixels and dy > 0. That is
/// (p + (u - 1) / 2) / u rounded to nearest, which is nowhere nearer than 1 / 2u to where rounding
/// would change. With |p| < 2^49 the sum is exact in f64, and the product with the reciprocal is off
/// by less than 2^49 / u * 2^-52: the column is exact.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// p + (u - 1) / 2 in the next row.
    at: f64,
    /// The change of p from row to row.
    step: f64,
    /// 1 / u.
    per_unit: f64,
    /// What to add for the start of a run: [`ROUND`] if the line is on the left, less [`ASIDE`] if
    /// not. The same for its end.
    start: f64,
    end: f64,
}

/// Added to a number below 2^51, this leaves the nearest integer in the lowest bits.
const ROUND: f64 = 1.5 * (1u64 << 52) as f64;

/// Out of the way of every column.
const ASIDE: f64 = (1u64 << 48) as f64;

impl Triangle {
    /// Whether its size is such that the lines are exact: with at most 2^22 subpixels, less than 2^26
    /// from the origin.
    #[inline(always)]
    fn is_exact(triangle: [FixedPoint; 3]) -> bool {
        let [a, b, c] = triangle;
        let extent = |a: i32, b: i32, c: i32| a.max(b).max(c).saturating_sub(a.min(b).min(c));
        extent(a.x, b.x, c.x).max(extent(a.y, b.y, c.y)) <= 1 << 22
    }

    #[inline(always)]
    fn new(triangle: [FixedPoint; 3], rows: &Range<i32>) -> Self {
        let area = signed_area(&triangle, |point| *point);
        let [a, b, c] = triangle;
        let extent = |a: i32, b: i32, c: i32| [a.min(b).min(c), a.max(b).max(c)].map(first_centre);
        let ([left, right], [top, bottom]) = (extent(a.x, b.x, c.x), extent(a.y, b.y, c.y));
        let y = top.max(rows.start);
        let end = if area == 0 { y } else { bottom.min(rows.end) };
        let line = |a: FixedPoint, b: FixedPoint| Line::new(a, b, y, area > 0);
        Self {
            sides: [line(a, b), line(b, c), line(c, a)],
            columns: (f64::from(left) + ROUND, f64::from(right) + ROUND),
            rows: (y, end),
        }
    }

    /// Finds the next rows, if any; whether they are the last.
    #[inline(always)]
    fn next_group(&mut self, group: &mut RunGroup) -> bool {
        let (y, bottom) = self.rows;
        let (left, right) = self.columns;
        let (mut start, mut end) = ([left; ROWS], [right; ROWS]);
        for side in &mut self.sides {
            for row in 0..ROWS {
                let column = (side.at + row as f64 * side.step) * side.per_unit;
                start[row] = greater(start[row], column + side.start);
                end[row] = less(end[row], column + side.end);
            }
            side.at += ROWS as f64 * side.step;
        }
        let column = |value: f64| less(greater(value, left), right).to_bits() as i32;
        (group.start, group.end) = (start.map(column), end.map(column));
        group.y = y;
        group.len = (bottom - y).clamp(0, ROWS as i32) as usize;
        self.rows.0 = y + ROWS as i32;
        self.rows.0 >= bottom
    }
}

impl Line {
    /// The line through `a` and `b` from row `y` on. In a triangle that runs clockwise, an edge that
    /// runs down is on the right.
    #[inline(always)]
    fn new(a: FixedPoint, b: FixedPoint, y: i32, clockwise: bool) -> Self {
        let [dx, dy] = [b.x - a.x, b.y - a.y].map(f64::from);
        let (is_right, is_left) =
            if clockwise { (dy > 0.0, dy < 0.0) } else { (dy < 0.0, dy > 0.0) };
        let (dx, dy) = if dy < 0.0 { (-dx, -dy) } else { (dx, dy) };
        let (subpixels, half) = (f64::from(SUBPIXELS), HALF as f64);
        let unit = if dy == 0.0 { 1.0 } else { dy * subpixels };
        let below = f64::from(y) * subpixels + half - f64::from(a.y);
        let position = (f64::from(a.x) - half) * dy + below * dx;
        Self {
            at: position + (unit - 1.0) * 0.5,
            step: dx * subpixels,
            per_unit: 1.0 / unit,
            start: if is_left { ROUND } else { ROUND - ASIDE },
            end: if is_right { ROUND } else { ROUND + ASIDE },
        }
    }
}

/// Of two numbers, neither of which is NaN: `f64::max` would cost three instructions.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
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
    fn next_group(
        pair: &mut Option<Self>,
        outline: &ConvexOutline<'a>,
        group: &mut RunGroup,
    ) -> bool {
        let pair = pair.get_or_insert_with(|| Self::new(outline));
        *group = RunGroup::EMPTY;
        while group.len < ROWS {
            let Some(Run { y, x, edges }) = pair.next_row() else { break };
            if group.len == 0 {
                group.y = y;
            }
            (group.start[group.len], group.end[group.len]) = (x.start, x.end);
            group.edges[group.len] = edges;
            group.len += 1;
        }
        pair.active.is_none()
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

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use super::{ActivePair, ConvexOutline, FixedPoint};

    /// Marsaglia's xorshift.
    struct Rng(u64);

    impl Rng {
        fn within(&mut self, range: Range<i32>) -> i32 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            let len = i64::from(range.end) - i64::from(range.start);
            (i64::from(range.start) + (self.0 >> 16) as i64 % len) as i32
        }
    }

    /// The runs of a triangle, found by its lines, and by its active edges as every other outline's.
    fn both_ways(points: &[FixedPoint], rows: Range<i32>) -> [Vec<(i32, Range<i32>)>; 2] {
        let outline = ConvexOutline { points, rows };
        let mut at_once = Vec::new();
        outline.for_each_group(false, |group| {
            let runs = (0..group.len).map(|row| group.run(row)).filter(|run| !run.x.is_empty());
            at_once.extend(runs.map(|run| (run.y, run.x)));
        });
        [at_once, ActivePair::new(&outline).map(|run| (run.y, run.x)).collect()]
    }

    fn check(triangles: u64) {
        let mut rng = Rng(0x9e37_79b9_7f4a_7c15);
        let mut pixels = 0;
        for number in 0..triangles {
            // From a pixel to the largest that is exact, anywhere within the guard band, some of it on
            // pixel centres or with sides on rows.
            let size = 1 << rng.within(8..23);
            let corner = [0; 2].map(|_| rng.within(-(1 << 26) + size..(1 << 26) - size));
            let unit = [1, 1, 16, 128][rng.within(0..4) as usize].min(size / 2);
            let mut place = |corner: i32| {
                let offset = rng.within(0..size / unit) * unit;
                // The largest size is wanted, too.
                if offset + unit >= size { corner + size } else { corner + offset }
            };
            let points = [0; 3].map(|_| FixedPoint { x: place(corner[0]), y: place(corner[1]) });
            let middle = (corner[1] + rng.within(0..size)) / 256;
            let rows = middle - rng.within(0..400)..middle + rng.within(0..400);
            let [at_once, one_by_one] = both_ways(&points, rows.clone());
            assert_eq!(at_once, one_by_one, "triangle {number}: {points:?}, rows {rows:?}");
            pixels += at_once.iter().map(|(_, x)| x.len() as u64).sum::<u64>();
        }
        println!("{triangles} triangles, {pixels} pixels, the same in both ways");
    }

    #[test]
    fn a_triangle_has_the_same_runs_by_its_lines_and_by_its_active_edges() {
        check(100_000);
    }

    #[test]
    #[ignore = "takes minutes"]
    fn long_triangles() {
        check(30_000_000);
    }
}
