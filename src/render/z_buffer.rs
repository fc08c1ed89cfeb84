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
use crate::settings::{DepthMode, DrawCall, Settings};
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
    /// Whether the vertices of the geometry being drawn were projected.
    is_projected: bool,
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

    fn depth_mode(&self) -> DepthMode {
        self.settings.depth
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
        self.is_projected &= !batch.is_first;
        if batch.is_first && batch.faces.len() == 1 {
            return self.draw_one(call, (level, plan), batch, band, shading);
        }
        if !self.is_projected {
            self.mesh.project(call, level, batch.vertices);
            self.is_projected = true;
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

#[cfg(test)]
mod tests {
    use glam::vec4;

    use super::ZBufferRenderer;
    use crate::fragment::LANES;
    use crate::fragment::block::RECIPROCALS;
    use crate::render::depth::DepthTest;
    use crate::render::framebuffer::Framebuffer;
    use crate::render::geometry::Mesh;
    use crate::settings::Cull;
    use crate::test_rng::Rng;
    use crate::vertex::Vertex;

    const WIDTH: usize = 3 * LANES;
    const HEIGHT: usize = 8;

    /// The blocks that were divided, for each block that was drawn, and the calls of the shader that
    /// drawing a quad takes, with the given w on its left and its right.
    fn count(w: [f32; 2], depth_test: DepthTest) -> (f32, usize) {
        let quad = [(-1.0, -1.0, w[0]), (1.0, -1.0, w[1]), (1.0, 1.0, w[1]), (-1.0, 1.0, w[0])]
            .map(|(x, y, w)| Vertex::new(vec4(x * w, y * w, 0.5 * w, w), [x, y, 1.0]));
        let mut frame = Framebuffer::new(WIDTH as u32, HEIGHT as u32, 0u32).expect("a small frame");
        // Blocks begin at cache lines, wherever the allocator has put the rows.
        let line_offset = frame.depth().as_ptr().addr() / size_of::<f32>() % LANES;
        let blocks = HEIGHT * (line_offset + WIDTH).div_ceil(LANES);
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.depth_test = depth_test;
        let mut shaded = 0;
        RECIPROCALS.set(0);
        renderer.on_one_thread().draw(&mut frame, &quad, |_| {
            shaded += 1;
            1
        });
        (RECIPROCALS.get() as f32 / blocks as f32, shaded)
    }

    #[test]
    fn one_reciprocal_a_visible_pixel_whatever_the_number_of_parameters() {
        assert_eq!(count([1.0, 3.0], DepthTest::Nearer), (1.0, WIDTH * HEIGHT));
    }

    #[test]
    fn hidden_pixels_cost_no_reciprocal() {
        assert_eq!(count([1.0, 3.0], DepthTest::Farther), (0.0, 0));
        assert_eq!(count([1.0, 3.0], DepthTest::Never), (0.0, 0));
    }

    #[test]
    fn equal_w_costs_no_reciprocal() {
        assert_eq!(count([3.7, 3.7], DepthTest::Nearer), (0.0, WIDTH * HEIGHT));
    }

    /// Chunks, batches and parts of vertices are small in tests, so that a mesh has many of each: the order
    /// of faces across them, their numbers, and their clipped vertices must be those of faces drawn one by
    /// one.
    #[test]
    fn a_mesh_of_many_chunks_is_drawn_as_its_faces_one_by_one() {
        let mut rng = Rng(0x2545_f491_4f6c_dd1d);
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for number in 0..1500 {
            // Triangles, quads and others, some of them clipped by the near plane or the eye, some alike
            // in depth.
            let sides = [3, 3, 3, 3, 4, 5, 7][rng.below(7) as usize];
            let (x, y, depth) = (rng.float(1.2), rng.float(1.2), (number % 9) as f32 / 10.0);
            let first = vertices.len() as u32;
            let reaches_out = rng.below(10) == 0;
            for _ in 0..sides {
                let w = if reaches_out { rng.float(2.0) } else { 1.5 + rng.float(0.5) };
                let [x, y] = [x, y].map(|c| c + rng.float(0.15));
                vertices.push(Vertex::new(vec4(x * w, y * w, depth * w, w), [x, y, depth]));
            }
            faces.push((first..first + sides).collect::<Vec<u32>>());
            if rng.below(50) == 0 {
                faces.push(vec![first, first + 1]);
                faces.push(vec![first, u32::MAX, first + 1]);
            }
        }
        let frame = || Framebuffer::new(150, 140, [0u32; 4]).expect("a small frame");
        let bits = |params: &[f32; 3]| params.map(f32::to_bits);
        for cull in [Cull::None, Cull::Back] {
            let (mut at_once, mut one_by_one) = (frame(), frame());
            let mut renderer = ZBufferRenderer::new(at_once.viewport());
            renderer.settings.cull = cull;
            renderer.draw(&mut at_once, Mesh::new(&vertices, &faces), |f| {
                let [r, g, b] = bits(&f.params);
                [f.face, r, g, b]
            });
            for (face, number) in faces.iter().zip(0..) {
                renderer.draw(&mut one_by_one, Mesh::new(&vertices, [face]), |f| {
                    let [r, g, b] = bits(&f.params);
                    [number, r, g, b]
                });
            }
            assert!(at_once == one_by_one, "{cull:?}");
            let drawn = at_once.color().iter().filter(|color| **color != [0; 4]).count();
            assert!(drawn > 10_000, "only {drawn} pixels are drawn");
        }
    }
}
