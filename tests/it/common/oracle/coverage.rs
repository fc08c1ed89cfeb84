//! Which pixels an outline covers.

use std::ops::Range;

use num_integer::Integer;

use super::parts::Edge;
use super::projection::outline;
use super::{Depth, FillRule, Position, STEPS, Snapped, Window};

/// The centre of a pixel.
pub(crate) fn centre(x: u32, y: u32) -> Snapped {
    (i64::from(x) * STEPS + STEPS / 2, i64::from(y) * STEPS + STEPS / 2)
}

/// How often the outline winds around the point, clockwise on the screen counting -1.
///
/// Counts the edges that meet the horizontal line through the point at or left of it. An edge owns
/// its upper end and not its lower one, so a point on a top edge is inside and one on a bottom edge
/// outside; a meeting exactly at the point counts, so a point on a left edge is inside and one on a
/// right edge outside: the top-left rule, for any outline.
pub(crate) fn winding(outline: &[Snapped], point: Snapped) -> i32 {
    edges(outline).map(|(a, b)| turn((a, b, 1), point)).sum()
}

/// What one edge adds to the winding number.
pub(super) fn turn((a, b, n): Edge<Snapped>, point: Snapped) -> i32 {
    let (x, y) = wide(point);
    let ((ax, ay), (bx, by)) = (wide(a), wide(b));
    let (upper, lower, turn) =
        if ay <= by { ((ax, ay), (bx, by), n) } else { ((bx, by), (ax, ay), -n) };
    let spans = upper.1 <= y && y < lower.1;
    // The edge is at x = upper.x + (y - upper.y) (lower.x - upper.x) / (lower.y - upper.y).
    let is_left = (y - upper.1) * (lower.0 - upper.0) <= (x - upper.0) * (lower.1 - upper.1);
    if spans && is_left { turn } else { 0 }
}

/// Whether the point is inside the outline by the fill rule, and by the top-left rule when it lies
/// on an edge.
pub(crate) fn covers(outline: &[Snapped], point: Snapped, rule: FillRule) -> bool {
    is_inside(winding(outline, point), rule)
}

pub(super) fn is_inside(winding: i32, rule: FillRule) -> bool {
    match rule {
        FillRule::NonZero => winding != 0,
        FillRule::EvenOdd => winding % 2 != 0,
    }
}

/// The same question for a convex outline, answered in another way: the point is on the inner side
/// of every edge, or on an edge that is a top or a left one.
///
/// The outline has to be convex on the screen, after the rounding: see [`is_convex`].
pub(crate) fn covers_convex(outline: &[Snapped], point: Snapped) -> bool {
    let area = doubled_area(outline);
    area != 0
        && edges(outline).filter(|(a, b)| a != b).all(|(a, b)| {
            // Walk every outline clockwise on the screen: the top edges then run right and the left
            // ones up.
            let (a, b) = if area > 0 { (a, b) } else { (b, a) };
            let top_or_left = b.1 < a.1 || (b.1 == a.1 && b.0 > a.0);
            let side = edge_function(a, b, point);
            side > 0 || (side == 0 && top_or_left)
        })
}

/// Whether no vertex lies on the outer side of any edge. An outline without an area is not convex.
pub(crate) fn is_convex(outline: &[Snapped]) -> bool {
    let sign = doubled_area(outline).signum();
    let keeps_side =
        |(a, b): (Snapped, Snapped)| outline.iter().all(|&p| edge_function(a, b, p) * sign >= 0);
    sign != 0 && edges(outline).all(keeps_side)
}

/// Twice the area, positive when the outline runs clockwise on the screen.
pub(crate) fn doubled_area(outline: &[Snapped]) -> i128 {
    let cross = |((ax, ay), (bx, by)): ((i128, i128), (i128, i128))| ax * by - ay * bx;
    edges(outline).map(|(a, b)| cross((wide(a), wide(b)))).sum()
}

fn edge_function(a: Snapped, b: Snapped, p: Snapped) -> i128 {
    let ((ax, ay), (bx, by), (px, py)) = (wide(a), wide(b), wide(p));
    (bx - ax) * (py - ay) - (by - ay) * (px - ax)
}

pub(super) fn edges<T: Copy>(outline: &[T]) -> impl Iterator<Item = (T, T)> {
    (0..outline.len()).map(|i| (outline[i], outline[(i + 1) % outline.len()]))
}

fn wide((x, y): Snapped) -> (i128, i128) {
    (x.into(), y.into())
}

/// The pixels that an outline covers, kept for the pixels of its bounding box inside the viewport.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mask {
    x: Range<u32>,
    y: Range<u32>,
    inside: Vec<bool>,
}

impl Mask {
    /// Whether the pixel is covered.
    pub(crate) fn contains(&self, x: u32, y: u32) -> bool {
        self.x.contains(&x) && self.y.contains(&y) && self.inside[self.index(x, y)]
    }

    /// The covered pixels as (x, y), row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (u32, u32)> {
        let all = self.y.clone().flat_map(|y| self.x.clone().map(move |x| (x, y)));
        all.filter(|&(x, y)| self.inside[self.index(x, y)])
    }

    /// How many pixels are covered.
    pub(crate) fn count(&self) -> usize {
        self.inside.iter().filter(|&&inside| inside).count()
    }

    /// The viewport drawn with `#` and `.`, one line a row.
    pub(crate) fn picture(&self, window: Window) -> String {
        let row = |y| {
            (0..window.width)
                .map(|x| if self.contains(x, y) { '#' } else { '.' })
                .collect::<String>()
                + "\n"
        };
        (0..window.height).map(row).collect()
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y - self.y.start) as usize * self.x.len() + (x - self.x.start) as usize
    }
}

/// The pixels of the viewport whose centres are inside the outline.
pub(crate) fn fill(outline: &[Snapped], window: Window, rule: FillRule) -> Mask {
    let edges: Vec<_> = edges(outline).map(|(a, b)| (a, b, 1)).collect();
    fill_border(&edges, window, rule)
}

/// The pixels of the viewport whose centres are inside a border.
pub(crate) fn fill_border(border: &[Edge<Snapped>], window: Window, rule: FillRule) -> Mask {
    let points = || border.iter().flat_map(|edge| [edge.0, edge.1]);
    let x = centres_between(points().map(|p| p.0), window.width);
    let y = centres_between(points().map(|p| p.1), window.height);
    let covers = |x, y| is_inside(border.iter().map(|&edge| turn(edge, centre(x, y))).sum(), rule);
    let pixels = y.clone().flat_map(|y| x.clone().map(move |x| (x, y)));
    Mask { inside: pixels.map(|(x, y)| covers(x, y)).collect(), x, y }
}

/// The pixels, of `size` in a row, whose centres lie between the smallest and the largest
/// coordinate, both included.
fn centres_between(coordinates: impl Iterator<Item = i64> + Clone, size: u32) -> Range<u32> {
    let bounded = |pixel: i64| {
        u32::try_from(pixel.clamp(0, size.into())).expect("a pixel of the viewport, or its end")
    };
    let Some(least) = coordinates.clone().min() else { return 0..0 };
    let most = coordinates.max().unwrap_or(least);
    let first = Integer::div_ceil(&(least - STEPS / 2), &STEPS);
    let last = Integer::div_floor(&(most - STEPS / 2), &STEPS);
    bounded(first)..bounded(last + 1).max(bounded(first))
}

/// The pixels of the viewport that the polygon covers.
///
/// `guard` is how many pixels around the viewport a polygon may leave it before it is cut.
pub(crate) fn coverage(
    polygon: &[Position],
    window: Window,
    depth: Depth,
    guard: f64,
    rule: FillRule,
) -> Mask {
    fill(&outline(polygon, window, depth, guard), window, rule)
}

/// How many of the polygons cover each pixel, row by row.
pub(crate) fn coverage_counts<'a>(
    polygons: impl IntoIterator<Item = &'a [Position]>,
    window: Window,
    depth: Depth,
    guard: f64,
) -> Vec<u32> {
    let mut counts = vec![0; window.width as usize * window.height as usize];
    for polygon in polygons {
        for (x, y) in coverage(polygon, window, depth, guard, FillRule::NonZero).pixels() {
            counts[y as usize * window.width as usize + x as usize] += 1;
        }
    }
    counts
}
