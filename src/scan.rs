//! The stages joined: polygons in clip space in, spans out.
//!
//! ```text
//! Vertex<N> -> clip -> project -> edge table -> Span<N> -> Fragment<N>
//! ```
//!
//! [`ScanConverter`] is what renderers are built on; those in [`render`](crate::render) are.

use std::ops::Range;

use crate::clip::{ClipPlane, ClipSpace, ClipVertex, Clipper, Outcome};
use crate::edge_table::{EdgeTable, FillRule, ROWS, RunGroup, RunGroups, Runs, signed_area_of};
use crate::outline::{Chain, Outline};
use crate::polygon::{Lines, ScreenPolygon, Setup};
use crate::project::{FixedPoint, Rect, Viewport};
use crate::span::{Place, Span};
use crate::vertex::{Interpolation, Vertex};

/// Which polygons are left out, by the direction in which their vertices run as seen on the screen.
/// Of several contours the one of the largest area decides: areas are summed with their signs.
///
/// Where the front of a polygon is the side from which its vertices run counter-clockwise, as in
/// OBJ files, back faces are left out by [`Cull::Clockwise`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cull {
    /// None.
    #[default]
    None,
    /// Those whose vertices run clockwise.
    Clockwise,
    /// Those whose vertices run counter-clockwise.
    CounterClockwise,
}

/// Converts polygons to spans.
///
/// The fields are the settings; the memory that the work takes is kept, so that after the first few
/// polygons nothing is allocated any more.
///
/// ```
/// use glam::vec4;
/// use polyscan::{ScanConverter, Vertex, Viewport};
///
/// let triangle = [
///     Vertex::new(vec4(-1.0, 1.0, 0.0, 1.0), [0.0]),
///     Vertex::new(vec4(-1.0, -1.0, 0.0, 1.0), [1.0]),
///     Vertex::new(vec4(1.0, 1.0, 0.0, 1.0), [0.0]),
/// ];
/// let mut scan = ScanConverter::new(Viewport::new(4, 4)?);
/// for span in scan.spans(&triangle) {
///     for fragment in span.fragments() {
///         assert_eq!(fragment.params[0], (fragment.y as f32 + 0.5) / 4.0);
///     }
/// }
/// let covered: Vec<_> = scan.spans(&triangle).map(|span| (span.y(), span.x())).collect();
/// assert_eq!(covered, [(0, 0..3), (1, 0..2), (2, 0..1)]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ScanConverter<const N: usize> {
    /// Where on the framebuffer the view volume goes.
    pub viewport: Viewport,
    /// The only pixels to visit, if given.
    pub scissor: Option<Rect>,
    /// The depth convention of the vertices' positions.
    pub clip_space: ClipSpace,
    /// Planes to clip by besides those of the view volume.
    pub planes: Vec<ClipPlane>,
    /// Which polygons to leave out.
    pub cull: Cull,
    /// What is inside an outline that is not convex.
    pub fill_rule: FillRule,
    /// How each parameter is interpolated.
    pub interpolation: [Interpolation; N],
    all_planes: Vec<ClipPlane>,
    clipper: Clipper<N>,
    outline: Vec<FixedPoint>,
    polygon: ScreenPolygon<N>,
    edges: EdgeTable,
}

impl<const N: usize> ScanConverter<N> {
    /// A scan converter that visits all the pixels of a viewport: no scissor, no extra planes, no
    /// culling, the non-zero rule, depth 0 <= z <= w, all parameters in perspective.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            viewport,
            scissor: None,
            clip_space: ClipSpace::default(),
            planes: Vec::new(),
            cull: Cull::default(),
            fill_rule: FillRule::default(),
            interpolation: [Interpolation::default(); N],
            all_planes: Vec::new(),
            clipper: Clipper::new(),
            outline: Vec::new(),
            polygon: ScreenPolygon::default(),
            edges: EdgeTable::new(),
        }
    }

    /// Takes over the settings of another scan converter, and keeps the memory.
    pub(crate) fn adopt(&mut self, other: &Self) {
        self.viewport = other.viewport;
        self.scissor = other.scissor;
        self.clip_space = other.clip_space;
        self.planes.clone_from(&other.planes);
        self.cull = other.cull;
        self.fill_rule = other.fill_rule;
        self.interpolation = other.interpolation;
    }

    /// The spans of a polygon, from top to bottom and, where it is not convex, from left to right
    /// in each row.
    ///
    /// A polygon is one contour or several: see [`Outline`]. What is inside, the
    /// [`fill_rule`](Self::fill_rule) says. Any polygon is safe. Contours with fewer than three
    /// vertices bound nothing, and a polygon with a position that is not finite has no spans.
    ///
    /// Parameters that are not affine on the polygon, which takes four vertices or more, are
    /// interpolated along its edges and then across the spans; the result depends on how the polygon
    /// is rotated on the screen.
    pub fn spans(&mut self, polygon: &(impl Outline<N> + ?Sized)) -> Spans<'_, N> {
        self.spans_within(polygon, self.viewport.rect())
    }

    /// The spans within a rectangle.
    pub(crate) fn spans_within(
        &mut self,
        polygon: &(impl Outline<N> + ?Sized),
        bounds: Rect,
    ) -> Spans<'_, N> {
        let columns = self.set_up_within(polygon, bounds);
        Spans { polygon: &self.polygon, runs: self.edges.runs(), columns }
    }

    /// The spans within a rectangle of a face with a number, and its clipped vertices. Where there
    /// are no spans, the vertices mean nothing.
    pub(crate) fn face_within(
        &mut self,
        face: u32,
        polygon: &[Vertex<N>],
        bounds: Rect,
    ) -> (Spans<'_, N>, &[ClipVertex<N>]) {
        self.polygon.face = face;
        let columns = self.set_up_within(polygon, bounds);
        let spans = Spans { polygon: &self.polygon, runs: self.edges.runs(), columns };
        (spans, self.clipper.vertices())
    }

    /// Brings a polygon as far as the edge table; the visible columns.
    fn set_up_within(&mut self, polygon: &(impl Outline<N> + ?Sized), bounds: Rect) -> Range<i32> {
        let window = self.window(bounds);
        let columns = if window.iter().any(Range::is_empty) {
            None
        } else {
            self.clipper.load(polygon, &self.interpolation);
            self.set_up(window)
        };
        columns.unwrap_or_else(|| {
            self.edges.fill(&[], 0..0);
            0..0
        })
    }

    /// Brings the polygon that the clipper has loaded as far as the edge table; the visible columns,
    /// or `None` if there is nothing to see.
    fn set_up(&mut self, [columns, rows]: [Range<i32>; 2]) -> Option<Range<i32>> {
        let mut planes = std::mem::take(&mut self.all_planes);
        self.collect_planes(&mut planes);
        let sides = self.clipper.sides();
        let outcome = self.clipper.clip_to_view(&planes, &self.interpolation);
        self.all_planes = planes;
        if outcome == Outcome::Outside {
            return None;
        }
        let vertices = self.clipper.vertices().iter();
        let point = |v: &ClipVertex<N>| FixedPoint::project(v.position, &self.viewport);
        self.outline.clear();
        self.outline.extend(vertices.clone().map(point));
        let chains = self.clipper.chains();
        if self.cull.leaves_out(signed_area_of(&self.outline, chains)) {
            return None;
        }
        self.edges.fill_rule = self.fill_rule;
        self.edges.fill_outline(&self.outline, chains, rows);
        if self.edges.is_empty() {
            return None;
        }
        let setup = self.setup();
        self.polygon.set_up(&setup, vertices.copied(), self.is_affine(sides, outcome));
        Some(columns)
    }

    /// How polygons are brought to the screen.
    pub(crate) fn setup(&self) -> Setup<N> {
        Setup::new(&self.viewport, self.clip_space, self.interpolation)
    }

    /// Sets a face up for who keeps many: its values and its outline. Whether there may be something
    /// to see.
    pub(crate) fn set_up_in(
        &mut self,
        polygon: &[Vertex<N>],
        screen: &mut ScreenPolygon<N>,
        outline: &mut ScreenOutline,
    ) -> bool {
        std::mem::swap(&mut self.polygon, screen);
        let columns = self.set_up_within(polygon, self.viewport.rect());
        std::mem::swap(&mut self.polygon, screen);
        outline.points.clone_from(&self.outline);
        outline.chains.clear();
        outline.chains.extend_from_slice(self.clipper.chains());
        !columns.is_empty()
    }

    /// Replaces `planes` by all planes to clip by.
    pub(crate) fn collect_planes(&self, planes: &mut Vec<ClipPlane>) {
        planes.clear();
        planes.extend(self.clip_space.near_far());
        planes.extend(self.viewport.guard_band());
        planes.extend(&self.planes);
    }

    /// Whether all values are known to be affine on a polygon of so many sides. On a triangle they
    /// are, also after it was clipped; but what is linear on the screen has no linear continuation
    /// behind the eye.
    pub(crate) fn is_affine(&self, sides: usize, outcome: Outcome) -> bool {
        let linear = self.interpolation.contains(&Interpolation::Linear);
        sides == 3 && (outcome == Outcome::Inside || !linear)
    }

    /// The columns and rows to visit within `bounds`, relative to the viewport.
    pub(crate) fn window(&self, bounds: Rect) -> [Range<i32>; 2] {
        let viewport = self.viewport.rect().ranges();
        let bounds = bounds.ranges();
        let scissor = self.scissor.map_or(viewport, Rect::ranges);
        [0, 1].map(|axis| {
            let (first, end) = viewport[axis];
            let inside = |pixel: i64| (pixel.clamp(first, end) - first) as i32;
            inside(bounds[axis].0.max(scissor[axis].0))..inside(bounds[axis].1.min(scissor[axis].1))
        })
    }
}

impl Cull {
    /// Whether a polygon is left out, by the sign of its [`signed_area`].
    #[inline(always)]
    pub(crate) fn leaves_out(self, signed_area: i128) -> bool {
        match self {
            Self::None => false,
            Self::Clockwise => signed_area > 0,
            Self::CounterClockwise => signed_area < 0,
        }
    }
}

/// An outline on the screen: its points, and its chains if it is not one contour.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScreenOutline {
    pub(crate) points: Vec<FixedPoint>,
    pub(crate) chains: Vec<Chain>,
}

/// Iterator over the spans of a polygon.
#[derive(Debug)]
pub struct Spans<'a, const N: usize> {
    pub(crate) polygon: &'a ScreenPolygon<N>,
    pub(crate) runs: Runs<'a>,
    pub(crate) columns: Range<i32>,
}

impl<'a, const N: usize> Iterator for Spans<'a, N> {
    type Item = Span<'a, N>;

    #[inline(always)]
    fn next(&mut self) -> Option<Span<'a, N>> {
        loop {
            let run = self.runs.next()?;
            if let Some(span) = Span::new(self.polygon, &run, &self.columns) {
                return Some(span);
            }
        }
    }
}

impl<'a, const N: usize> Spans<'a, N> {
    /// The spans in groups of rows, if the polygon is convex and no span has been taken.
    #[inline(always)]
    pub(crate) fn groups(&self) -> Option<SpanGroups<'a, N>> {
        let Self { polygon, runs, columns } = self;
        let runs = runs.groups()?;
        Some(SpanGroups { polygon, runs, columns: columns.clone() })
    }
}

/// The spans of a convex polygon. What neighbouring rows have in common in their set-up is done for
/// several at once.
pub(crate) struct SpanGroups<'a, const N: usize> {
    pub(crate) polygon: &'a ScreenPolygon<N>,
    pub(crate) runs: RunGroups<'a>,
    pub(crate) columns: Range<i32>,
}

/// The spans of neighbouring rows.
pub(crate) struct SpanGroup<'a, 'g, const N: usize> {
    pub(crate) polygon: &'a ScreenPolygon<N>,
    runs: &'g RunGroup,
    /// The first visible column of each run.
    pub(crate) start: [i32; ROWS],
    /// The number of visible columns; 0 in rows from [`len`](Self::len) on.
    pub(crate) width: [i32; ROWS],
    /// The values along the runs.
    pub(crate) lines: Lines<N>,
    /// How far the first visible column is from the one where the values are given.
    pub(crate) steps: [f32; ROWS],
}

/// The spans of two rows, the first of which has an even number in its group, where all values have
/// planes.
#[derive(Clone, Copy)]
pub(crate) struct SpanPair<'s, const N: usize> {
    pub(crate) group: &'s SpanGroup<'s, 's, N>,
    pub(crate) row: usize,
    pub(crate) places: &'s [Place<'s, N>; 2],
}

impl<const N: usize> SpanPair<'_, N> {
    /// What the two rows have.
    #[inline(always)]
    pub(crate) fn of<T: Copy>(self, rows: &[T; ROWS]) -> [T; 2] {
        rows.as_chunks().0[self.row / 2 % (ROWS / 2)]
    }
}

impl<'a, const N: usize> SpanGroups<'a, N> {
    /// Calls `f` for each group, from top to bottom.
    #[inline(always)]
    pub(crate) fn for_each(self, mut f: impl FnMut(&SpanGroup<'a, '_, N>)) {
        let Self { polygon, runs, columns } = &self;
        runs.for_each(
            polygon.needs_edges(),
            #[inline(always)]
            |runs| f(&SpanGroup::new(polygon, runs, columns)),
        );
    }
}

impl<'a, 'g, const N: usize> SpanGroup<'a, 'g, N> {
    #[inline(always)]
    fn new(polygon: &'a ScreenPolygon<N>, runs: &'g RunGroup, columns: &Range<i32>) -> Self {
        let lines = polygon.lines(runs);
        let (mut start, mut width, mut steps) = (runs.start, runs.end, [0.0; ROWS]);
        let len = runs.len as i32;
        // Plain loops without branches, which become SIMD.
        for start in &mut start {
            *start = (*start).max(columns.start);
        }
        for (row, width) in width.iter_mut().enumerate() {
            // All ones in the rows that there are.
            let exists = (row as i32 - len) >> 31;
            *width = ((*width).min(columns.end) - start[row]).max(0) & exists;
        }
        for (row, steps) in steps.iter_mut().enumerate() {
            *steps = (start[row] - lines.x[row]) as f32;
        }
        Self { polygon, runs, start, width, lines, steps }
    }

    /// The number of rows.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.runs.len
    }

    /// Whether all values have planes, so that they change alike in all rows.
    #[inline(always)]
    pub(crate) fn has_planes(&self) -> bool {
        !self.polygon.needs_edges()
    }

    /// The first row, relative to the viewport.
    #[inline(always)]
    pub(crate) fn y(&self) -> i32 {
        self.runs.y
    }

    /// Where the span of a row comes from.
    #[inline(always)]
    pub(crate) fn place(&self, row: usize) -> Place<'a, N> {
        Place::new(self.polygon, &self.runs.run(row))
    }

    /// The span of a row, if it has one.
    #[inline(always)]
    pub(crate) fn span(&self, row: usize) -> Option<Span<'a, N>> {
        // Not more than there can be, so that it need not be checked.
        let row = row % ROWS;
        let x = self.start[row]..self.start[row] + self.width[row];
        if x.is_empty() {
            return None;
        }
        let line = if self.has_planes() {
            self.polygon.line_of(&self.lines, row)
        } else {
            self.polygon.line(&self.runs.run(row))
        };
        Some(Span { place: self.place(row), x, line })
    }
}
