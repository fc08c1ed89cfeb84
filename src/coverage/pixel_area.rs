//! How much of each pixel an outline covers: its exact area there, by signed areas.
//!
//! Along a row, what lies right of an edge that runs down counts with one sign, what lies right of one that
//! runs up with the other. All edges together leave the area inside, times how often the outline winds
//! around it. So each edge is worth the same whatever it belongs to, and only pixels that it passes through
//! need more than a carry (R. Levien, LibArt and font-rs; D. Turner, FreeType's smooth rasterizer; the use of
//! areas as coverage is from E. Catmull, "A Hidden-Surface Algorithm with Anti-Aliasing", SIGGRAPH 1978).
//!
//! ```text
//!      x_l   X      G(X) is the area right of the piece of an edge that lies in a row, and left of the
//!     --+----|--    column X: 0 left of the piece, then (X - x_l)^2 h / 2 (x_r - x_l), and right of
//!       \####|      it h (X - (x_l + x_r) / 2). What pixel c has of it is G(X_(c+1)) - G(X_c).
//!        \###|
//!     ----\##|--
//!         x_r
//! ```
//!
//! G is rounded to whole numbers of [`AreaTable::FULL`] to a pixel, and all else is sums of them: two polygons add
//! the same numbers for an edge that they share, with opposite signs. Where an edge enters and leaves a row is
//! found in f64, within 2^-25 subpixel, from its upper end.

use std::ops::Range;

use crate::coverage::area::chain_edges;
use crate::coverage::fill_rule::FillRule;
use crate::outline::Chain;
use crate::subpixel::{SUBPIXELS, SubpixelPoint};

/// The area that an outline covers of each pixel, row by row, with the memory that this takes.
///
/// It is exact to one unit for each edge that passes through the pixel, and where none does to the bit: 0 or
/// [`FULL`](Self::FULL). The areas of polygons that part a pixel without overlap, by edges of the same two points,
/// add up to exactly that.
///
/// Where a contour crosses itself or overlaps another within one pixel, the winding numbers there are averaged
/// before the [`fill_rule`](Self::fill_rule) is applied, as font rasterizers do: a pixel half of which is covered twice
/// counts as full. With numbers of 0 and 1, or 0 and -1, in a pixel this makes no difference.
///
/// ```
/// use polyscan::coverage::AreaTable;
/// use polyscan::subpixel::SubpixelPoint;
///
/// // Half of a square of two pixels: an eighth, seven eighths and half of a pixel.
/// let triangle = [(0, 0), (512, 0), (0, 512)].map(|(x, y)| SubpixelPoint { x, y });
/// let mut table = AreaTable::new();
/// table.fill(&triangle, 0..10, 0..10);
/// assert_eq!(table.columns(), 0..2);
/// assert_eq!(table.row(0), [AreaTable::FULL, AreaTable::FULL / 2]);
/// assert_eq!(table.row(1), [AreaTable::FULL / 2, 0]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct AreaTable {
    /// What is inside the outline.
    pub fill_rule: FillRule,
    edges: Vec<AreaEdge>,
    columns: Range<i32>,
    rows: Range<i32>,
    /// The first of the rows that are known; the sums are of that row and the next ones.
    first: Option<i32>,
    /// The change of the signed area from pixel to pixel, row by row, one more than there are columns.
    changes: Vec<i64>,
    areas: Vec<u32>,
}

/// An edge that runs down.
#[derive(Clone, Copy, Debug)]
struct AreaEdge {
    upper: SubpixelPoint,
    lower: SubpixelPoint,
    /// +1 if it ran down, -1 if it ran up; times the winding of its chain.
    winding: i64,
}

/// Rows whose areas are found at a time.
const CHUNK: i32 = 16;

/// Units in a square subpixel.
const PER_SUBPIXEL: i64 = AreaTable::FULL as i64 / (SUBPIXELS as i64 * SUBPIXELS as i64);

impl AreaTable {
    /// The area of a pixel: all areas up to this are exact as `f32`.
    pub const FULL: u32 = 1 << 24;

    /// A table without edges.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the edges by those of one closed contour, in some columns and rows. An outline that reaches
    /// farther than 2^26 subpixels from the origin covers nothing;
    /// [`SubpixelPoint::project`] gives no such points.
    pub fn fill(&mut self, outline: &[SubpixelPoint], columns: Range<i32>, rows: Range<i32>) {
        let ends = outline.iter().skip(1).chain(outline.first());
        self.fill_edges(outline.iter().zip(ends).map(|(&a, &b)| (a, b, 1)), columns, rows);
    }

    /// Replaces the edges by those of an outline of any number of contours, as
    /// [`EdgeTable::fill_chains`](crate::coverage::EdgeTable::fill_chains).
    pub fn fill_chains(
        &mut self,
        points: &[SubpixelPoint],
        chains: &[Chain],
        columns: Range<i32>,
        rows: Range<i32>,
    ) {
        if chains.is_empty() {
            return self.fill(points, columns, rows);
        }
        let edges = chain_edges(points, chains).map(|(&a, &b, _, winding)| (a, b, winding));
        self.fill_edges(edges, columns, rows);
    }

    fn fill_edges(
        &mut self,
        edges: impl Iterator<Item = (SubpixelPoint, SubpixelPoint, i32)>,
        columns: Range<i32>,
        rows: Range<i32>,
    ) {
        const FARTHEST: u32 = 1 << 26;
        self.edges.clear();
        self.first = None;
        let (mut left, mut right, mut top, mut bottom) = (i32::MAX, i32::MIN, i32::MAX, i32::MIN);
        let mut is_near = true;
        for (a, b, winding) in edges {
            is_near &= [a.x, a.y, b.x, b.y].iter().all(|c| c.unsigned_abs() <= FARTHEST);
            let (upper, lower, sign) = if a.y <= b.y { (a, b, 1) } else { (b, a, -1) };
            (left, right) = (left.min(a.x.min(b.x)), right.max(a.x.max(b.x)));
            (top, bottom) = (top.min(upper.y), bottom.max(lower.y));
            if upper.y != lower.y && winding != 0 {
                let winding = i64::from(winding) * sign;
                self.edges.push(AreaEdge { upper, lower, winding });
            }
        }
        if !is_near || self.edges.is_empty() {
            self.edges.clear();
            (self.columns, self.rows) = (0..0, 0..0);
            return;
        }
        let touched = |first: i32, last: i32, within: Range<i32>| {
            let inside = |pixel: i32| pixel.min(within.end).max(within.start);
            let first = inside(first.div_euclid(SUBPIXELS));
            first..inside((last - 1).div_euclid(SUBPIXELS) + 1).max(first)
        };
        (self.columns, self.rows) = (touched(left, right, columns), touched(top, bottom, rows));
    }

    /// The columns, of those given, that the outline extends over: those of [`row`](Self::row).
    #[must_use]
    pub fn columns(&self) -> Range<i32> {
        self.columns.clone()
    }

    /// The rows, of those given, that the outline extends over.
    #[must_use]
    pub fn rows(&self) -> Range<i32> {
        self.rows.clone()
    }

    /// What is covered of the pixels in a row, in units of 1 / [`FULL`](Self::FULL) pixel; nothing of those in
    /// a row that the outline does not extend over. It is fastest to ask for rows from top to bottom.
    pub fn row(&mut self, y: i32) -> &[u32] {
        if !self.rows.contains(&y) {
            return &[];
        }
        let first = match self.first {
            Some(first) if (first..first + CHUNK).contains(&y) => first,
            _ => {
                self.find_rows(y);
                y
            }
        };
        let width = self.columns.len();
        let start = (y - first) as usize * (width + 1);
        let mut sum = 0i64;
        self.areas.clear();
        let (changes, rule) = (self.changes.get(start..).unwrap_or_default(), self.fill_rule);
        self.areas.extend(changes.iter().take(width).map(|change| {
            sum = sum.wrapping_add(*change);
            area_inside(sum, rule)
        }));
        &self.areas
    }

    /// Finds the changes in the rows from one on.
    fn find_rows(&mut self, first: i32) {
        let Self { edges, columns, rows, changes, .. } = self;
        self.first = Some(first);
        let end = (first + CHUNK).min(rows.end);
        let len = columns.len() + 1;
        changes.clear();
        changes.resize((end - first) as usize * len, 0);
        for edge in edges {
            let from = first.max(edge.upper.y.div_euclid(SUBPIXELS));
            let to = end.min((edge.lower.y - 1).div_euclid(SUBPIXELS) + 1);
            for y in from..to {
                let changes = &mut changes[(y - first) as usize * len..][..len];
                edge.piece_in(y).add_to(changes, columns, edge.winding);
            }
        }
    }
}

/// The area inside, of a pixel with a sum of areas times winding numbers.
fn area_inside(sum: i64, rule: FillRule) -> u32 {
    let (sum, full) = (sum.unsigned_abs(), u64::from(AreaTable::FULL));
    let inside = match rule {
        FillRule::NonZero => sum.min(full),
        FillRule::EvenOdd => {
            let rest = sum % (2 * full);
            rest.min(2 * full - rest)
        }
    };
    inside as u32
}

/// The piece of an edge that lies in a row.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// From where to where it extends, in subpixels.
    left: f64,
    right: f64,
    /// How high it is, in subpixels.
    height: i32,
}

impl AreaEdge {
    fn piece_in(&self, y: i32) -> Piece {
        let top = self.upper.y.max(y * SUBPIXELS);
        let bottom = self.lower.y.min((y + 1) * SUBPIXELS);
        let (a, b) = (self.x_at(top), self.x_at(bottom));
        Piece { left: a.min(b), right: a.max(b), height: bottom - top }
    }

    /// Where the edge is at a height.
    fn x_at(&self, y: i32) -> f64 {
        let Self { upper, lower, .. } = *self;
        if y == lower.y {
            return lower.x.into();
        }
        let [dx, dy, below] = [lower.x - upper.x, lower.y - upper.y, y - upper.y].map(f64::from);
        f64::from(upper.x) + below * dx / dy
    }
}

impl Piece {
    /// The area left of a column, in units.
    fn area_before(&self, column: i32) -> i64 {
        let Self { left, right, height } = *self;
        let (x, height) = (f64::from(column) * f64::from(SUBPIXELS), f64::from(height));
        let area = if x >= right {
            (x - (left + right) * 0.5) * height
        } else if x > left {
            (x - left) * (x - left) * height / (2.0 * (right - left))
        } else {
            0.0
        };
        // Rounded half up: nothing is negative.
        (area * PER_SUBPIXEL as f64 + 0.5) as i64
    }

    /// Adds what is right of the piece to a row of changes.
    fn add_to(&self, changes: &mut [i64], columns: &Range<i32>, winding: i64) {
        let pixel = |x: f64| (x / f64::from(SUBPIXELS)).floor() as i32;
        let all = i64::from(self.height) * i64::from(SUBPIXELS) * PER_SUBPIXEL;
        let (first, last) = (pixel(self.left), pixel(self.right));
        if first >= columns.end {
            return;
        }
        let mut add = |column: i32, change: i64| {
            let change = change.wrapping_mul(winding);
            if let Some(sum) = changes.get_mut((column - columns.start) as usize) {
                *sum = sum.wrapping_add(change);
            }
        };
        if last < columns.start {
            return add(columns.start, all);
        }
        let first = first.max(columns.start);
        let (mut before, mut in_pixel) = (self.area_before(first), 0);
        for column in first..=last.min(columns.end - 1) {
            let next = self.area_before(column + 1);
            add(column, next - before - in_pixel);
            (before, in_pixel) = (next, next - before);
        }
        if last < columns.end {
            add(last + 1, all - in_pixel);
        }
    }
}
