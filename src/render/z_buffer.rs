//! The z-buffer renderer (Catmull 1974): each fragment is compared with the depth that its pixel
//! has so far, and drawn if it is nearer.
//!
//! The comparison comes before the reciprocal and the shader, so hidden pixels cost neither.

use fearless_simd::Level;

use crate::primitive::Primitive;
use crate::render::band::Band;
use crate::render::by_depth::SortedFaces;
use crate::render::depth::DepthTest;
use crate::render::faces::MOST_AT_ONCE;
use crate::render::front::{Counting, DrawFaces, FrontMemory, Parts, Renderer, drawing_methods};
use crate::render::geometry::{Batch, Order};
use crate::render::mesh::MeshMemory;
use crate::render::parallel::Shading;
use crate::render::raster::plan::Plan;
use crate::render::raster::{self, RasterMemory};
use crate::render::statistics::Statistics;
use crate::render::stencil::Stencil;
use crate::render::strokes::Strokes;
use crate::settings::{DepthMode, DrawCall, Settings};
use crate::simd::for_level;
use crate::viewport::Viewport;

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
    /// What is done with the stencil of a [target that has one](crate::Target::with_stencil).
    pub stencil: Option<Stencil>,
    /// Counts what becomes of polygons and pixels, from now on, if there is something to count in: see
    /// [`Statistics`].
    pub statistics: Option<Statistics>,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The picture is
    /// the same with any.
    pub simd_level: Level,
    front: FrontMemory<N>,
    drawer: Drawer,
}

/// What draws faces, with memory that is kept.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drawer {
    sorted: SortedFaces,
    mesh: MeshMemory,
    /// Whether the vertices of the geometry being drawn were projected.
    is_projected: bool,
    primitive: Primitive,
    raster: RasterMemory,
    strokes: Strokes,
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
            stencil: None,
            statistics: None,
            simd_level: Level::new(),
            front: FrontMemory::default(),
            drawer: Drawer::default(),
        }
    }
}

drawing_methods!(ZBufferRenderer);

impl<const N: usize> Renderer<N> for ZBufferRenderer<N> {
    type Drawer = Drawer;

    fn parts(&mut self) -> Parts<'_, Drawer, N> {
        let Self { settings, stencil, statistics, simd_level: level, front, drawer, .. } = self;
        let plan = Plan::new(self.depth_test, self.depth_write, settings.depth);
        let counting = Counting::of(statistics.as_mut());
        Parts { settings, level: *level, plan, stencil: *stencil, counting, front, drawer }
    }

    fn level(&self) -> Level {
        self.simd_level
    }

    fn depth_mode(&self) -> DepthMode {
        self.settings.depth
    }
}

impl DrawFaces for Drawer {
    const MOST_FACES: usize = MOST_AT_ONCE;

    fn draw(
        &mut self,
        call: &DrawCall<'_>,
        (level, plan): (Level, Plan),
        batch: &Batch<'_>,
        band: &mut Band<'_>,
        shading: Shading<'_>,
    ) {
        self.is_projected &= !batch.is_first;
        if self.strokes.prepare(call, batch) {
            return self.strokes.draw(call, (level, plan), band, shading);
        }
        if batch.is_first && batch.faces.len() == 1 {
            return self.draw_one(call, (level, plan), batch, band, shading);
        }
        if !self.is_projected {
            self.mesh.project(call, level, batch.vertices);
            self.is_projected = true;
        }
        let faces = match batch.order {
            Order::BackToFront => self.sorted.sort(call, batch.vertices, batch.faces),
            Order::AsGiven | Order::Tree(..) => batch.faces,
        };
        self.mesh.draw(call, (level, plan), (batch.vertices, faces), band, shading);
    }
}

impl Drawer {
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
    use std::f32::consts::TAU;

    use glam::{Vec2, vec4};

    use super::{MOST_AT_ONCE, ZBufferRenderer};
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

    /// The vertices are projected though the first faces that are handed over are one alone.
    #[test]
    fn a_face_of_many_corners_before_others_is_drawn_with_them() {
        let corner = |i: u32| {
            let turn = Vec2::from_angle(TAU * i as f32 / 300.0) * 0.5;
            Vertex::new(turn.extend(0.5).extend(1.0), [])
        };
        let mut vertices: Vec<_> = (0..300).map(corner).collect();
        let triangle = [(-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0)];
        vertices.extend(triangle.map(|(x, y)| Vertex::new(vec4(x, y, 0.2, 1.0), [])));
        let faces = [(0..300).collect::<Vec<u32>>(), vec![300, 301, 302]];
        assert!(faces[0].len() >= 4 * MOST_AT_ONCE, "the first is handed over alone");
        let frame = || Framebuffer::new(64, 64, None).expect("a small frame");
        let (mut at_once, mut one_by_one) = (frame(), frame());
        let mut renderer = ZBufferRenderer::new(at_once.viewport());
        renderer.draw(&mut at_once, Mesh::new(&vertices, &faces), |f| Some(Some(f.face)));
        for (face, number) in faces.iter().zip(0..) {
            let mesh = Mesh::new(&vertices, [face]);
            renderer.draw(&mut one_by_one, mesh, |_| Some(Some(number)));
        }
        assert!(at_once == one_by_one);
        for number in 0..2 {
            assert!(at_once.color().contains(&Some(number)), "face {number} is seen");
        }
    }

    /// No bound for a tile comes from depths that a shader is yet to discard: here they are those of the last
    /// block of a row, while the next row is looked at.
    #[test]
    fn what_a_shader_discards_hides_nothing() {
        const FRAME: (u32, u32) = (300, 32);
        let square = |z: f32| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| Vertex::new(vec4(x, y, z, 1.0), []))
        };
        // A wall before all else, with a hole of one pixel; faces that are discarded; what is seen through
        // the hole.
        for discarded in 1..5 {
            let behind = discarded + 1;
            let between = (1..behind).map(|face| 0.6 - 0.05 * face as f32);
            let depths = [0.1].into_iter().chain(between).chain([0.8]);
            let vertices: Vec<_> = depths.flat_map(square).collect();
            let faces: Vec<[u32; 4]> =
                (0..=behind).map(|i| [0, 1, 2, 3].map(|k| 4 * i + k)).collect();
            for row in 0..FRAME.1 {
                let hole = (FRAME.0 as i32 - 1, row as i32);
                let mut frame = Framebuffer::new(FRAME.0, FRAME.1, None).expect("a small frame");
                let mut renderer = ZBufferRenderer::new(frame.viewport());
                renderer.depth_test = DepthTest::NearerOrEqual;
                renderer.draw(&mut frame, Mesh::new(&vertices, &faces), |f| {
                    let is_seen = f.face == behind || f.face == 0 && (f.x, f.y) != hole;
                    is_seen.then_some(Some(f.face))
                });
                let through_hole = frame.pixel(FRAME.0 - 1, row).and_then(|(face, _)| face);
                assert_eq!(through_hole, Some(behind), "{discarded} discarded, row {row}");
            }
        }
    }
}
