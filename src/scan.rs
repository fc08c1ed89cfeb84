//! The stages joined: a polygon in, spans out.
//!
//! Clip, project, find the coverage, lay planes through the parameters: [`ScanConverter`] does it all.
//! [`Surface`] is the last of these steps for who joins the stages by hand.

use std::ops::Range;

use glam::DVec4;

use crate::clip::ClipVertex;
use crate::coverage::area::signed_area_of;
use crate::coverage::{Run, Runs};
use crate::outline::{Chain, Outline};
use crate::primitive::Primitive;
use crate::settings::Settings;
use crate::span::Span;
use crate::subpixel::SubpixelPoint;
use crate::surface::polygon::PolygonSurface;
use crate::surface::rows::{RowValues, SurfaceView};
use crate::view_volume::ClipPlane;
use crate::viewport::Viewport;

/// Converts polygons to spans.
///
/// The memory that the work takes is kept, so that after the first few polygons nothing is allocated
/// any more.
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
/// let covered: Vec<_> = scan.spans(&triangle).map(|span| (span.row(), span.columns())).collect();
/// assert_eq!(covered, [(0, 0..3), (1, 0..2), (2, 0..1)]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ScanConverter<const N: usize> {
    /// How polygons are brought to the screen.
    pub settings: Settings<N>,
    planes: Vec<ClipPlane>,
    primitive: Primitive,
    values: RowValues,
}

impl<const N: usize> ScanConverter<N> {
    /// A scan converter that visits all the pixels of a viewport, with the settings of
    /// [`Settings::new`]. Rows and columns of its spans are those of the framebuffer: where the viewport
    /// has a [corner](Viewport::with_corner), they may be negative or beyond the framebuffer.
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            settings: Settings::new(viewport),
            planes: Vec::new(),
            primitive: Primitive::default(),
            values: RowValues::default(),
        }
    }

    /// The spans of a polygon, from top to bottom and, where it is not convex, from left to right
    /// in each row.
    ///
    /// A polygon is one contour or several: see [`Outline`]. What is inside, the
    /// [`fill_rule`](Settings::fill_rule) says. Any polygon is safe. Contours with fewer than three
    /// vertices bound nothing, and a polygon with a position that is not finite has no spans.
    ///
    /// Parameters that are not affine on the polygon, which takes four vertices or more, are
    /// interpolated along its edges and then across the spans; the result depends on how the polygon
    /// is rotated on the screen.
    pub fn spans(&mut self, polygon: &(impl Outline<N> + ?Sized)) -> Spans<'_, N> {
        let Self { settings, planes, primitive, values } = self;
        settings.collect_planes(planes);
        let call = settings.call(settings.viewport.rect(), planes);
        let contours = polygon.contours();
        let contours = contours.map(|c| c.iter().map(|v| (v.position, v.params.as_slice())));
        let window = &call.window;
        if window.is_empty() || !primitive.prepare(&call, 0, contours, &window.rows) {
            return Spans(None);
        }
        let columns = window.columns.clone();
        let (surface, runs) = primitive.surface_and_runs();
        Spans(Some(SpansOf { surface, runs, columns, values }))
    }
}

/// Iterator over the spans of a polygon.
#[derive(Debug)]
pub struct Spans<'a, const N: usize>(Option<SpansOf<'a>>);

#[derive(Debug)]
struct SpansOf<'a> {
    surface: SurfaceView<'a>,
    runs: Runs<'a>,
    columns: Range<i32>,
    values: &'a mut RowValues,
}

impl<'a, const N: usize> Iterator for Spans<'a, N> {
    type Item = Span<'a, N>;

    fn next(&mut self) -> Option<Span<'a, N>> {
        let SpansOf { surface, runs, columns, values } = self.0.as_mut()?;
        runs.find_map(|run| Span::new(*surface, &run, columns, values))
    }
}

/// How the parameters of a polygon run over the screen: the last stage before spans, for who joins the
/// stages by hand.
///
/// ```
/// use glam::vec4;
/// use polyscan::clip::{ClippedOutline, Clipper};
/// use polyscan::coverage::EdgeTable;
/// use polyscan::subpixel::SubpixelPoint;
/// use polyscan::{Settings, Surface, Vertex, Viewport};
///
/// let triangle = [(-1.0, 1.0), (-1.0, -1.0), (3.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.0, 1.0), [x]));
/// let settings = Settings::new(Viewport::new(4, 4)?);
/// // Clip, ...
/// let (mut clipper, planes) = (Clipper::new(), settings.all_planes());
/// let clipped = clipper.clip_outline(&triangle, &planes, &settings.interpolation);
/// let ClippedOutline::Chains { vertices, chains } = clipped else { return Ok(()) };
/// // ... project, ...
/// let project = |v| SubpixelPoint::project(v, &settings.viewport);
/// let points: Vec<_> = vertices.iter().map(|v| project(v.position)).collect();
/// // ... find the coverage, lay the planes, ...
/// let mut edges = EdgeTable::new();
/// edges.fill_rule = settings.fill_rule;
/// edges.fill_chains(&points, chains, settings.rows());
/// let mut surface = Surface::new();
/// if !surface.fit(&settings, vertices, chains) {
///     return Ok(());
/// }
/// // ... and go on with spans, and fragments, to depths and colours of one's own.
/// let (mut depths, mut colors) = ([settings.depth.farthest(); 16], [0.0; 16]);
/// for run in edges.runs() {
///     let Some(span) = surface.span(&run) else { continue };
///     for fragment in span.fragments() {
///         let pixel = fragment.y as usize * 4 + fragment.x as usize;
///         if fragment.depth < depths[pixel] {
///             (depths[pixel], colors[pixel]) = (fragment.depth, fragment.params[0]);
///         }
///     }
/// }
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Surface<const N: usize> {
    surface: PolygonSurface,
    values: RowValues,
    points: Vec<SubpixelPoint>,
    positions: Vec<DVec4>,
    params: Vec<f64>,
    columns: Range<i32>,
    rows: Range<i32>,
    sides: usize,
}

impl<const N: usize> Surface<N> {
    /// A surface without planes yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Lays planes through the parameters of a polygon as the [clipper](crate::clip::Clipper) has left
    /// it; returns whether it is to be drawn, which a polygon is not that [`Settings::cull`] leaves out:
    /// it has no spans. Without chains the vertices are one closed contour.
    ///
    /// A span knows no number of a face: [`Fragment::face`](crate::Fragment::face) is 0.
    #[must_use = "a polygon that is culled has no spans"]
    pub fn fit(
        &mut self,
        settings: &Settings<N>,
        vertices: &[ClipVertex<N>],
        chains: &[Chain],
    ) -> bool {
        let call = settings.call(settings.viewport.rect(), &[]);
        (self.columns, self.rows) = (call.window.columns.clone(), call.window.rows.clone());
        self.points.clear();
        let project = |v: &ClipVertex<N>| SubpixelPoint::project(v.position, &settings.viewport);
        self.points.extend(vertices.iter().map(project));
        let area = signed_area_of(&self.points, chains);
        let face = (0, call.front_face.is_front(area > 0));
        // A contour that is alone needs no closing vertex: so the planes are those of the whole.
        let is_closed = chains.len() == 1 && vertices.first() == vertices.last();
        let vertices = &vertices[..vertices.len().saturating_sub(usize::from(is_closed))];
        self.sides = vertices.len();
        if vertices.is_empty() || call.culled.leaves_out(area) {
            self.rows = 0..0;
            return false;
        }
        let Self { surface, positions, params, .. } = self;
        positions.clear();
        positions.extend(vertices.iter().map(|v| v.position));
        params.clear();
        params.extend(vertices.iter().flat_map(|v| v.params));
        surface.set_up(&call, face, positions, params, false);
        true
    }

    /// The span of a run that the [edge table](crate::coverage::EdgeTable) has found for the same
    /// vertices; `None` if none of its pixels is to be visited, or if it has edges that the polygon has
    /// not.
    pub fn span(&mut self, run: &Run) -> Option<Span<'_, N>> {
        let has_edges = run.edges.iter().all(|&edge| (edge as usize) < self.sides);
        if !has_edges || !self.rows.contains(&run.y) {
            return None;
        }
        Span::new(self.surface.view(), run, &self.columns, &mut self.values)
    }
}
