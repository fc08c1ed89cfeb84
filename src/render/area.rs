//! Pixels covered in part, by exact area: edges without steps, and without samples.
//!
//! A polygon is clipped, projected and rounded as by all renderers. Of each pixel that it touches a
//! `coverage::pixel_area` says how much it covers, and its colour counts for so much. No depth is kept: pixels that
//! are covered in part have none. So polygons come in an order, from back to front or from front to back.

use glam::Vec4;

use crate::coverage::{AreaTable, CoverageRule, OutsidePolygon};
use crate::fragment::Fragment;
use crate::outline::Outline;
use crate::primitive::Primitive;
use crate::render::by_depth::SortedFaces;
use crate::render::faces::{FaceIndices, FaceList};
use crate::render::geometry::{Batch, Geometry, GeometryMemory, Mesh, Order};
use crate::render::target::RenderTarget;
use crate::settings::{DrawCall, Settings};
use crate::span::Span;
use crate::surface::rows::RowValues;
use crate::vertices::Vertices;
use crate::view_volume::ClipPlane;
use crate::viewport::{Rect, Viewport};

/// In which order polygons come to an [`AreaRenderer`], and how their colours are joined.
///
/// Neither knows which part of a pixel a polygon covers, only how much. The first takes what covers a pixel in
/// part to lie there by chance: of two polygons that share an edge through a pixel, the background shows through by
/// up to a quarter. The second takes it to lie beside what is there already, as long as there is room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AreaOrder {
    /// Each polygon lies over those before it: Porter and Duff's "over" ("Compositing Digital Images", 1984),
    /// with a colour that counts as much as it covers. For shapes, one over the other, of any alpha.
    #[default]
    BackToFront,
    /// Each polygon is seen where those before it have left room: alpha is summed, up to 1, as OpenGL's
    /// `GL_SRC_ALPHA_SATURATE` does for polygons (OpenGL Programming Guide, "Antialiasing Polygons"). Meshes have no
    /// seams: faces that share edges fill each pixel exactly. The target begins with
    /// [`Vec4::ZERO`](glam::Vec4::ZERO), and the background comes last. An alpha less than 1 counts as part of the
    /// area.
    FrontToBack,
}

/// Draws polygons by the exact area that they cover of each pixel, in linear light premultiplied by alpha.
///
/// It is for single shapes, text and diagrams, and the measure of what several
/// [samples](crate::render::MultisampleRenderer) a pixel come near to. Areas are those of the outlines rounded to 1/256
/// pixel, from which all coverage is found; see [`AreaTable`].
///
/// ```
/// use glam::{Vec4, vec4};
/// use polyscan::render::AreaRenderer;
/// use polyscan::{Framebuffer, Vertex};
///
/// let mut frame = Framebuffer::new(2, 2, Vec4::ZERO)?;
/// let mut renderer = AreaRenderer::new(frame.viewport());
/// // White, over half of the picture.
/// let triangle = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// renderer.draw(&mut frame, &triangle, |_| Vec4::ONE);
/// let half = Vec4::splat(0.5);
/// assert_eq!(frame.color(), [half, Vec4::ZERO, Vec4::ONE, half]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// A shader is called once for each pixel of which a polygon covers some, on this thread. It is given the values at the
/// pixel's centre or, if that lies outside, at a point of the polygon's edge in the pixel, as
/// [`OutsidePolygon::Clamp`] says, unless [`Settings::coverage_rule`] says otherwise.
#[derive(Clone, Debug)]
pub struct AreaRenderer<const N: usize> {
    /// Where and how polygons are brought to the screen. Depth is not asked for.
    pub settings: Settings<N>,
    /// In which order polygons come.
    pub order: AreaOrder,
    geometry: GeometryMemory<N>,
    planes: Vec<ClipPlane>,
    sorted: SortedFaces,
    primitive: Primitive,
    values: RowValues,
    areas: AreaTable,
}

impl<const N: usize> AreaRenderer<N> {
    /// A renderer to a viewport, with the settings of [`Settings::new`], of polygons from back to front.
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            settings: Settings::new(viewport),
            order: AreaOrder::default(),
            geometry: GeometryMemory::default(),
            planes: Vec::new(),
            sorted: SortedFaces::default(),
            primitive: Primitive::default(),
            values: RowValues::default(),
            areas: AreaTable::default(),
        }
    }

    /// Draws a polygon of one or more contours. `shader` returns linear light premultiplied by alpha, from 0 to 1.
    pub fn draw(
        &mut self,
        frame: &mut impl RenderTarget<Color = Vec4>,
        polygon: &(impl Outline<N> + ?Sized),
        shader: impl FnMut(&Fragment<'_, N>) -> Vec4,
    ) {
        self.draw_geometry(frame, polygon, shader);
    }

    /// Draws the faces of a mesh in the order in which they are given, which must be
    /// [that of the renderer](Self::order); those of a mesh sorted [`back_to_front`](Mesh::back_to_front) in that order
    /// by their depths, whichever it is.
    pub fn draw_mesh<F: IntoIterator<Item: FaceIndices>>(
        &mut self,
        frame: &mut impl RenderTarget<Color = Vec4>,
        mesh: Mesh<'_, F, N>,
        shader: impl FnMut(&Fragment<'_, N>) -> Vec4,
    ) {
        self.draw_geometry(frame, mesh, shader);
    }

    fn draw_geometry(
        &mut self,
        frame: &mut impl RenderTarget<Color = Vec4>,
        geometry: impl Geometry<N>,
        mut shader: impl FnMut(&Fragment<'_, N>) -> Vec4,
    ) {
        let target = frame.target();
        let (width, order) = (target.width() as usize, self.order);
        let pixels = target.color;
        let mut paint = |fragment: &Fragment<'_, N>, area: u32| {
            let pixel = fragment.y as usize * width + fragment.x as usize;
            if let Some(pixel) = pixels.get_mut(pixel) {
                let color = shader(fragment);
                *pixel = order.joined(color, area as f32 / AreaTable::FULL as f32, *pixel);
            }
        };
        let height = pixels_height(target.depth.len(), width);
        self.submit(geometry, (width as u32, height), &mut paint);
    }

    /// Hands geometry over: compiled once for each kind of geometry, not for each shader.
    fn submit(
        &mut self,
        geometry: impl Geometry<N>,
        (width, height): (u32, u32),
        paint: &mut dyn FnMut(&Fragment<'_, N>, u32),
    ) {
        let Self { settings, planes, sorted, primitive, values, areas, .. } = self;
        settings.collect_planes(planes);
        let mut settings = settings.clone();
        if !settings.coverage_rule.is_outer() {
            settings.coverage_rule = CoverageRule::Outer(OutsidePolygon::Clamp);
        }
        let call = settings.call(Rect { x: 0, y: 0, width, height }, planes);
        if call.window.is_empty() {
            return;
        }
        let is_reversed = self.order == AreaOrder::FrontToBack;
        geometry.submit(&mut self.geometry, usize::MAX, &mut |batch| {
            let Batch { vertices, faces, order, .. } = *batch;
            let mut drawing = Drawing { call: &call, primitive, values, areas, paint };
            if !matches!(order, Order::BackToFront) {
                (0..faces.len()).for_each(|face| drawing.draw(vertices, faces, face));
                return;
            }
            let faces = sorted.sort(&call, vertices, faces);
            for face in 0..faces.len() {
                let face = if is_reversed { faces.len() - 1 - face } else { face };
                drawing.draw(vertices, faces, face);
            }
        });
    }
}

fn pixels_height(pixels: usize, width: usize) -> u32 {
    pixels.checked_div(width).unwrap_or(0) as u32
}

impl AreaOrder {
    /// A pixel's colour with another that covers some of it.
    #[inline]
    fn joined(self, color: Vec4, covered: f32, pixel: Vec4) -> Vec4 {
        match self {
            Self::BackToFront => color * covered + pixel * (1.0 - color.w * covered),
            Self::FrontToBack => {
                let (room, alpha) = (1.0 - pixel.w, color.w * covered);
                if alpha <= room {
                    return pixel + color * covered;
                }
                // What is left is taken to the last bit.
                let part = (color * (covered * (room / alpha)) + pixel).truncate();
                part.extend(1.0)
            }
        }
    }
}

/// Faces being drawn.
struct Drawing<'d, 'p, const N: usize> {
    call: &'d DrawCall<'d>,
    primitive: &'d mut Primitive,
    values: &'d mut RowValues,
    areas: &'d mut AreaTable,
    paint: &'d mut (dyn FnMut(&Fragment<'_, N>, u32) + 'p),
}

impl<const N: usize> Drawing<'_, '_, N> {
    fn draw(&mut self, vertices: &dyn Vertices, faces: &FaceList, face: usize) {
        let Self { call, primitive, values, areas, paint } = self;
        let (columns, rows) = (&call.window.columns, &call.window.rows);
        let contours = faces.contours(face).map(|c| c.iter().filter_map(|&i| vertices.get(i)));
        if !primitive.prepare(call, faces.number(face as u32), contours, rows) {
            return;
        }
        let clipped = primitive.clipped();
        areas.fill_rule = call.fill_rule;
        areas.fill_chains(clipped.points(), clipped.chains(), columns.clone(), rows.clone());
        let (corner, first) = (call.projection.corner.0, areas.columns().start);
        let (surface, runs) = primitive.surface_and_runs();
        for run in runs {
            let areas = areas.row(run.y);
            let Some(span) = Span::new(surface, &run, columns, values) else { continue };
            for fragment in span.fragments() {
                let column = (fragment.x - corner - first) as usize;
                if let Some(area @ 1..) = areas.get(column).copied() {
                    paint(&fragment, area);
                }
            }
        }
    }
}
