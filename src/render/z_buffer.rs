//! The z-buffer renderer (Catmull 1974): each fragment is compared with the depth that its pixel
//! has so far, and drawn if it is nearer.
//!
//! The comparison comes before the reciprocal and the shader, so hidden pixels cost neither.

use fearless_simd::Level;

use crate::primitive::Primitive;
use crate::render::band::Band;
use crate::render::by_depth::sort_by_depth;
use crate::render::depth::DepthTest;
use crate::render::faces::{FaceList, MOST_AT_ONCE};
use crate::render::front::{Renderer, drawing_methods};
use crate::render::geometry::{Batch, GeometryMemory, Order};
use crate::render::mesh::MeshMemory;
use crate::render::parallel::Shading;
use crate::render::raster::plan::Plan;
use crate::render::raster::{self, RasterMemory};
use crate::settings::{DrawCall, Settings};
use crate::simd::for_level;
use crate::view_volume::ClipPlane;
use crate::viewport::{Rect, Viewport};

/// Draws polygons into a framebuffer, hidden surfaces removed.
///
/// ```
/// use glam::vec4;
/// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
///
/// let mut frame = Framebuffer::new(4, 2, '.')?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// let quad = [(-1.0, -1.0), (0.0, -1.0), (0.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// renderer.draw(&mut frame, &quad, |_| '#');
/// assert_eq!(frame.color(), ['#', '#', '.', '.', '#', '#', '.', '.']);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// A polygon may have several contours, and so holes:
///
/// ```
/// use glam::vec4;
/// use polyscan::{FillRule, Framebuffer, Vertex, ZBufferRenderer};
///
/// let square = |size: f32| {
///     [(-size, -size), (size, -size), (size, size), (-size, size)]
///         .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []))
/// };
/// let (wall, window) = (square(1.0), square(0.5));
/// let mut frame = Framebuffer::new(4, 4, '.')?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// // Both run in the same direction, which is no hole by the non-zero rule.
/// renderer.settings.fill_rule = FillRule::EvenOdd;
/// renderer.draw(&mut frame, &[&wall[..], &window[..]], |_| '#');
/// let rows: Vec<String> = frame.color().chunks(4).map(|row| row.iter().collect()).collect();
/// assert_eq!(rows, ["####", "#..#", "#..#", "####"]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ZBufferRenderer<const N: usize> {
    /// Where and how polygons are brought to the screen.
    pub settings: Settings<N>,
    /// When a fragment is drawn.
    pub depth_test: DepthTest,
    /// Whether the depth of a fragment that is drawn is stored.
    pub depth_write: bool,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The picture is
    /// the same with any.
    pub simd_level: Level,
    geometry: GeometryMemory<N>,
    memory: Memory,
}

/// Memory that is kept.
#[derive(Clone, Debug, Default)]
struct Memory {
    planes: Vec<ClipPlane>,
    sorted: FaceList,
    mesh: MeshMemory,
    primitive: Primitive,
    raster: RasterMemory,
}

impl<const N: usize> ZBufferRenderer<N> {
    /// A renderer to a viewport, with the settings of [`Settings::new`], that draws what is nearer and
    /// stores its depth.
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            settings: Settings::new(viewport),
            depth_test: DepthTest::default(),
            depth_write: true,
            simd_level: Level::new(),
            geometry: GeometryMemory::default(),
            memory: Memory::default(),
        }
    }
}

drawing_methods!(ZBufferRenderer);

impl<const N: usize> Renderer<N> for ZBufferRenderer<N> {
    fn geometry(&mut self) -> &mut GeometryMemory<N> {
        &mut self.geometry
    }

    fn level(&self) -> Level {
        self.simd_level
    }

    fn most_faces(&self) -> usize {
        MOST_AT_ONCE
    }

    fn render(&mut self, batch: &Batch<'_>, width: u32, depth: &mut [f32], shading: Shading<'_>) {
        let mut planes = std::mem::take(&mut self.memory.planes);
        self.settings.collect_planes(&mut planes);
        let height = depth.len().checked_div(width as usize).unwrap_or(0) as u32;
        let call = self.settings.call(Rect { x: 0, y: 0, width, height }, &planes);
        if !call.window.is_empty() {
            let plan = Plan::new(self.depth_test, self.depth_write, call.depth);
            let mut band = Band::new((0, 0), width as usize, depth);
            self.memory.draw(&call, (self.simd_level, plan), batch, &mut band, shading);
        }
        self.memory.planes = planes;
    }
}

impl Memory {
    fn draw(
        &mut self,
        call: &DrawCall<'_>,
        (level, plan): (Level, Plan),
        batch: &Batch<'_>,
        band: &mut Band<'_>,
        shading: Shading<'_>,
    ) {
        if batch.is_first && batch.faces.len() == 1 {
            return self.draw_one(call, (level, plan), batch, band, shading);
        }
        if batch.is_first {
            self.mesh.project(call, level, batch.vertices);
        }
        let faces = match batch.order {
            Order::BackToFront => {
                sort_by_depth(call, batch.vertices, batch.faces, &mut self.sorted);
                &self.sorted
            }
            Order::AsGiven | Order::Tree(..) => batch.faces,
        };
        self.mesh.draw(call, (level, plan), (batch.vertices, faces), band, shading);
    }

    /// Draws a single face, without the ado that many are worth.
    fn draw_one(
        &mut self,
        call: &DrawCall<'_>,
        (level, plan): (Level, Plan),
        batch: &Batch<'_>,
        band: &mut Band<'_>,
        mut shading: Shading<'_>,
    ) {
        let (vertices, faces) = (batch.vertices, batch.faces);
        if faces.get(0).iter().any(|&i| i as usize >= vertices.len()) {
            return;
        }
        let Self { primitive, raster, .. } = self;
        let contours = faces.contours(0).map(|c| c.iter().filter_map(|&i| vertices.get(i)));
        if !primitive.prepare(call, faces.number(0), contours, &call.window.rows) {
            return;
        }
        let (surface, coverage) = primitive.parts();
        let columns = &call.window.columns;
        let shader = shading.on_one_thread();
        for_level!(level, simd => {
            raster::draw(simd, plan, (&surface, coverage), columns, band, raster, shader);
        });
    }
}
