//! Triangles, whose edges are so few that the runs of several rows are found at once, and the lines
//! of several triangles.

use std::ops::Range;

use crate::coverage::convex::ConvexOutline;
use crate::coverage::run::{ROWS, RunGroup};
use crate::round::{ROUND, integer};
use crate::scalar::{BATCH, PerTriangle, Scalar};
use crate::subpixel::{HALF_PIXEL, SUBPIXELS};

/// A triangle as three lines, or a batch of such triangles. What is between the lines in a row is the row's
/// run: a row belongs to two edges, and the third's line, drawn out, lies outside of them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TriangleEdges<T> {
    sides: [EdgeLine<T>; 3],
    /// The columns that it extends over, and the rows of those to visit, [`ROUND`] added: the first
    /// and the one after the last.
    columns: [T; 2],
    rows: [T; 2],
}

/// What is to be known of a triangle before its lines are used.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleTraits<T: Scalar> {
    /// Whether the lines are exact: they must not be used if not.
    pub(crate) is_exact: T::Mask,
    /// Whether it runs clockwise as seen on the screen.
    pub(crate) is_clockwise: T::Mask,
}

/// The line through an edge of a triangle.
///
/// In a row it stands before column p / u rounded up, as an [`Edge`](super::Edge) does, where
/// u = 256 dy and p = u (x - 128) / 256 are whole numbers, with x in subpixels and dy > 0. That is
/// (p + (u - 1) / 2) / u rounded to nearest, which is nowhere nearer than 1 / 2u to where rounding
/// would change. With |p| < 2^49 the sum is exact in f64, and the product with the reciprocal is off
/// by less than 2^49 / u * 2^-52: the column is exact.
#[derive(Clone, Copy, Debug, Default)]
struct EdgeLine<T> {
    /// p + (u - 1) / 2 in the first row to visit.
    at: T,
    /// The change of p from row to row.
    step: T,
    /// 1 / u.
    per_unit: T,
    /// What to add for the start of a run: [`ROUND`], less [`ASIDE`] if the line is not on the left.
    start: T,
    /// The same for its end: [`ROUND`], and [`ASIDE`] if the line is not on the right.
    end: T,
}

/// Out of the way of every column.
const ASIDE: f64 = (1u64 << 48) as f64;

/// The largest size of a triangle, in subpixels, for which the lines are exact, when it is less than
/// 2^26 subpixels from the origin.
const EXACT: f64 = (1u64 << 22) as f64;

impl<T: Copy> TriangleEdges<T> {
    /// The triangle of three points, in subpixels, as far as it is in the given rows, and what is to be
    /// known of it.
    #[inline(always)]
    pub(crate) fn new(points: [[T; 2]; 3], within: &Range<i32>) -> (Self, TriangleTraits<T>)
    where
        T: Scalar,
    {
        let [[ax, ay], [bx, by], [cx, cy]] = points;
        let zero = ax.splat(0.0);
        let area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
        let ([left, right], [top, bottom]) = (T::range([ax, bx, cx]), T::range([ay, by, cy]));
        let is_too_large = zero.splat(EXACT).is_less((right - left).greater(bottom - top));
        let [start, end] = [within.start, within.end].map(|y| f64::from(y) + ROUND);
        let start = rounded_centre(top).greater(zero.splat(start));
        let end = rounded_centre(bottom).lesser(zero.splat(end));
        let has_area = zero.is_less(area.abs());
        let rows = [start, T::select(has_area, end, start)];
        let columns = [rounded_centre(left), rounded_centre(right)];
        let (y, is_clockwise) = (start - ROUND, zero.is_less(area));
        let [a, b, c] = points;
        let ab = EdgeLine::new(a, b, y, is_clockwise);
        let bc = EdgeLine::new(b, c, y, is_clockwise);
        let ca = EdgeLine::new(c, a, y, is_clockwise);
        let triangle = Self { sides: [ab, bc, ca], columns, rows };
        (triangle, TriangleTraits { is_exact: !is_too_large, is_clockwise })
    }

    /// `f` of each number.
    #[inline(always)]
    pub(crate) fn map<U>(&self, f: impl Fn(&T) -> U + Copy) -> TriangleEdges<U> {
        let Self { sides: [a, b, c], columns: [left, right], rows: [first, last] } = self;
        TriangleEdges {
            sides: [a.map(f), b.map(f), c.map(f)],
            columns: [f(left), f(right)],
            rows: [f(first), f(last)],
        }
    }
}

impl<T> EdgeLine<T> {
    /// `f` of each number.
    #[inline(always)]
    fn map<U>(&self, f: impl Fn(&T) -> U) -> EdgeLine<U> {
        let Self { at, step, per_unit, start, end } = self;
        EdgeLine { at: f(at), step: f(step), per_unit: f(per_unit), start: f(start), end: f(end) }
    }
}

impl TriangleEdges<PerTriangle> {
    /// The triangle of an outline, if it is one and the lines are exact. All lanes are the same: a row
    /// of one triangle is found by the code that finds a row of one of eight.
    #[inline(always)]
    pub(crate) fn of(outline: &ConvexOutline<'_>) -> Option<Self> {
        let &[a, b, c] = outline.points else { return None };
        let points = [a, b, c].map(|point| [point.x, point.y].map(f64::from));
        let (triangle, traits) = TriangleEdges::new(points, &outline.rows());
        traits.is_exact.then_some(triangle.map(|value| [*value; BATCH]))
    }
}

/// One triangle of a batch. Its numbers stay where they are: a row needs each of them only once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BatchLane<'a> {
    pub(crate) edges: &'a TriangleEdges<PerTriangle>,
    pub(crate) lane: usize,
}

impl BatchLane<'_> {
    #[inline(always)]
    fn one(self, each: &PerTriangle) -> f64 {
        each[self.lane % BATCH]
    }

    #[inline(always)]
    fn integers(self, [first, end]: &[PerTriangle; 2]) -> Range<i32> {
        integer(self.one(first))..integer(self.one(end))
    }

    /// The columns, of those given, and the rows that it extends over, if any.
    #[inline(always)]
    pub(crate) fn extent(self, columns: &Range<i32>) -> Option<(Range<i32>, Range<i32>)> {
        let Range { start, end } = self.integers(&self.edges.columns);
        let columns = start.max(columns.start)..end.min(columns.end);
        let rows = self.integers(&self.edges.rows);
        (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
    }
}

impl<T: Scalar> EdgeLine<T> {
    /// The line through `a` and `b` from row `y` on. In a triangle that runs clockwise, an edge that
    /// runs down is on the right.
    #[inline(always)]
    fn new(a: [T; 2], b: [T; 2], y: T, is_clockwise: T::Mask) -> Self {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let (zero, one) = (dy.splat(0.0), dy.splat(1.0));
        let (is_up, is_down) = (dy.is_less(zero), zero.is_less(dy));
        let is_right = is_clockwise & is_down | !is_clockwise & is_up;
        let is_left = is_clockwise & is_up | !is_clockwise & is_down;
        let downwards = T::select(is_up, dy.splat(-1.0), one);
        let (dx, dy) = (dx * downwards, dy * downwards);
        let (subpixels, half) = (f64::from(SUBPIXELS), HALF_PIXEL as f64);
        let unit = T::select(is_up | is_down, dy * subpixels, one);
        let below = y * subpixels + half - a[1];
        let position = (a[0] - half) * dy + below * dx;
        Self {
            at: position + (unit - 1.0) * 0.5,
            step: dx * subpixels,
            per_unit: one / unit,
            start: T::select(is_left, dy.splat(ROUND), dy.splat(ROUND - ASIDE)),
            end: T::select(is_right, dy.splat(ROUND), dy.splat(ROUND + ASIDE)),
        }
    }
}

/// The rows of a triangle, to be visited from top to bottom.
pub(crate) struct TriangleRows<'a> {
    triangle: BatchLane<'a>,
    first: i32,
    y: i32,
    end: i32,
}

impl<'a> TriangleRows<'a> {
    #[inline(always)]
    pub(crate) fn new(triangle: BatchLane<'a>) -> Self {
        let Range { start, end } = triangle.integers(&triangle.edges.rows);
        Self { triangle, first: start, y: start, end }
    }

    /// Finds the next rows, if any; whether they are the last.
    #[inline(always)]
    pub(crate) fn next_group(&mut self, group: &mut RunGroup) -> bool {
        self.triangle.find_rows(f64::from(self.y - self.first), group);
        group.y = self.y;
        group.len = (self.end - self.y).clamp(0, ROWS as i32) as usize;
        self.y += ROWS as i32;
        self.y >= self.end
    }
}

impl BatchLane<'_> {
    /// The rows that it extends over.
    #[inline(always)]
    pub(crate) fn rows(self) -> Range<i32> {
        self.integers(&self.edges.rows)
    }

    /// Finds the runs of the rows from `y` on, one row before its first at the earliest; those of rows
    /// that it does not extend over are empty.
    #[inline(always)]
    pub(crate) fn group_at(self, y: i32, group: &mut RunGroup) {
        let Range { start: first, end } = self.rows();
        self.find_rows(f64::from(y - first), group);
        (group.y, group.len) = (y, ROWS);
        for row in 0..ROWS {
            let is_in = (first..end).contains(&(y + row as i32));
            group.end[row] = if is_in { group.end[row] } else { group.start[row] };
        }
    }

    /// Finds the runs of the rows that are `done` below its first and farther.
    #[inline(always)]
    fn find_rows(self, done: f64, group: &mut RunGroup) {
        let TriangleEdges { sides, columns: [left, right], .. } = self.edges;
        let (left, right) = (self.one(left), self.one(right));
        let (mut start, mut end) = ([left; ROWS], [right; ROWS]);
        for side in sides {
            let side = side.map(|each| self.one(each));
            for row in 0..ROWS {
                let p = side.at + (done + row as f64) * side.step;
                let column = p * side.per_unit;
                start[row] = start[row].greater(column + side.start);
                end[row] = end[row].lesser(column + side.end);
            }
        }
        let column = |value: f64| integer(value.greater(left).lesser(right));
        (group.start, group.end) = (start.map(column), end.map(column));
    }
}

/// The first column or row whose centre is at or behind `p` subpixels, [`ROUND`] added. Half a
/// subpixel before a centre is half-way between two.
#[inline(always)]
fn rounded_centre<T: Scalar>(p: T) -> T {
    (p - 0.5) * (1.0 / f64::from(SUBPIXELS)) + ROUND
}

#[cfg(test)]
mod tests {
    use std::ops::Range;

    use crate::coverage::convex::{ActivePair, ConvexOutline};
    use crate::coverage::shape::Coverage;
    use crate::subpixel::SubpixelPoint;
    use crate::test_rng::Rng;

    /// The runs of a triangle, found by its lines, and by its active edges as every other outline's.
    fn both_ways(points: &[SubpixelPoint], rows: Range<i32>) -> [Vec<(i32, Range<i32>)>; 2] {
        let outline = ConvexOutline { points, first_row: rows.start, end_row: rows.end };
        let mut at_once = Vec::new();
        Coverage::Convex(outline).for_each_group(false, |group| {
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
            let points = [0; 3].map(|_| SubpixelPoint { x: place(corner[0]), y: place(corner[1]) });
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
