//! The scanline renderer: rows from top to bottom, each finished before the next ones begin, so that
//! the picture need not be in memory (Wylie, Romney, Evans and Erdahl, "Half-tone perspective
//! drawings by computer", 1967).
//!
//! 1. The faces are sorted by the first row that each may have pixels in.
//! 2. Rows are taken some at a time. Faces that begin there become active: they are clipped,
//!    projected, set up once. Those that have ended are dropped.
//! 3. The active faces' edges give the runs of each row. Faces may cross: which of them is visible
//!    where is found for the row as a whole (Watkins, "A real time visible surface algorithm",
//!    University of Utah 1970; Bouknight, "A procedure for generation of three-dimensional half-toned
//!    computer graphics presentations", Communications of the ACM 13(9), 1970), and each pixel is
//!    shaded once. Transparent faces follow, from back to front at each pixel.
//! 4. The rows go to a sink in their order, while the next ones are being drawn.
//!
//! Rows are drawn in parallel. They depend on nothing but the faces, so the picture is the same for
//! any number of threads; and depths are compared as the z-buffer compares them, so it is the
//! z-buffer's to the bit.
//!
//! `scanline::active` keeps the faces, `scanline::draw` finds and draws the runs of rows,
//! `scanline::visible` says which of them are seen where.
//!
//! The memory that this takes, with N parameters: 24 bytes a face that is in view and 4 a corner of
//! it; 12 bytes a vertex, while faces are sorted; some 450 + 192 N bytes an active face and 40 + 8 N
//! a corner of it; 24 bytes for each run in the rows being drawn. Of the picture there are four parts
//! a thread in memory, of at most 2^18 pixels each. Nothing grows with the height.

mod visible;
mod active;
mod draw;

use fearless_simd::Level;

use crate::fragment::{Fragment, FragmentBlock, LANES};
use crate::render::band::Band;
use crate::render::corners::ProjectedVertices;
use crate::render::depth::DepthTest;
use crate::render::faces::FaceList;
use crate::render::front::{Counting, DrawFaces, FrontMemory, Parts, Renderer, drawing_methods};
use crate::render::geometry::{Batch, Geometry};
use crate::render::paint::Paint;
use crate::render::parallel::{Shading, beside, threads};
use crate::render::raster::plan::Plan;
use crate::render::scanline::active::ActiveFaces;
use crate::render::scanline::draw::{RowsMemory, draw_rows, rows_at_once};
use crate::render::shader::{Painter, PerBlock, PerFragment, Shader};
use crate::render::statistics::Statistics;
use crate::render::strokes::Strokes;
use crate::settings::{DepthMode, DrawCall, Settings};
use crate::simd::for_level;
use crate::vertices::Vertices;
use crate::viewport::{Rect, Viewport};

/// Draws meshes row by row, each visible pixel shaded once; for pictures too large to be in memory,
/// for costly shaders, and for transparent faces that cross.
///
/// Of the faces that cover a pixel the nearest opaque one is seen there, of equals the first, as it
/// is with a [`ZBufferRenderer`](crate::ZBufferRenderer) and its settings from the beginning. Its
/// shader is called once; if it discards the fragment, what lies behind is *not* seen, so declare
/// faces that have holes [transparent](crate::Mesh::with_transparent).
///
/// Transparent faces are drawn where they are nearer than that, from back to front at each pixel
/// even where they cross, of equals the last one first. Each is drawn by the same shader on what
/// lies behind it: [`Over`](crate::render::Over) or [`Additive`](crate::render::Additive) blend,
/// `None` leaves a hole, a plain colour covers.
///
/// ```
/// use glam::{Vec4, vec4};
/// use polyscan::{Framebuffer, Mesh, ScanlineRenderer, Vertex, render::Over};
///
/// let square = |z: f32| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, z, 1.0), []));
/// let vertices = [square(0.2), square(0.8)].concat();
/// let mut frame = Framebuffer::new(1, 1, Vec4::W)?;
/// let mut renderer = ScanlineRenderer::new(frame.viewport());
/// // Red glass, given first, before a green wall.
/// let mesh = Mesh::new(&vertices, [[0, 1, 2, 3], [4, 5, 6, 7]]);
/// renderer.draw(&mut frame, mesh.with_transparent(&|face| face == 0), |fragment| {
///     Over(if fragment.face == 0 { vec4(0.5, 0.0, 0.0, 0.5) } else { vec4(0.0, 1.0, 0.0, 1.0) })
/// });
/// assert_eq!(frame.color(), [vec4(0.5, 0.5, 0.0, 1.0)]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// Drawn on a target, a scene lies over what is farther there; the depths of opaque faces are stored.
#[derive(Clone, Debug)]
pub struct ScanlineRenderer<const N: usize> {
    /// Where and how polygons are brought to the screen.
    ///
    /// [`DepthMode::InverseW`](crate::DepthMode::InverseW) counts as
    /// [`DepthMode::Standard`](crate::DepthMode::Standard) here: rows are ordered by z.
    pub settings: Settings<N>,
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
    corners: ProjectedVertices,
    faces: ActiveFaces,
    rows: RowsMemory,
    strokes: Strokes,
}

impl<const N: usize> ScanlineRenderer<N> {
    /// A renderer to a viewport, with the settings of [`Settings::new`].
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            settings: Settings::new(viewport),
            statistics: None,
            simd_level: Level::new(),
            front: FrontMemory::default(),
            drawer: Drawer::default(),
        }
    }

    /// Draws geometry on a background and hands the rows of the viewport over, as soon as they are
    /// finished: `sink` is called once for each row, in their order, with its number from 0 at the
    /// viewport's top, and the colours of the viewport's columns. It runs on this thread, while
    /// others draw the next rows. The viewport's corner only shifts the coordinates that fragments
    /// report.
    ///
    /// The rows are those of a framebuffer [cleared](Self::clear) to the background.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::{Mesh, ScanlineRenderer, Vertex, Viewport};
    ///
    /// let vertices = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
    /// let mut renderer = ScanlineRenderer::new(Viewport::new(4, 3)?);
    /// let mut picture = Vec::new();
    /// renderer.stream(Mesh::new(&vertices, [[0, 1, 2]]), '.', |_| '#', |_, row| {
    ///     picture.push(row.iter().collect::<String>());
    ///     Ok::<(), std::fmt::Error>(())
    /// })?;
    /// assert_eq!(picture, ["#...", "##..", "###."]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The first that the sink returns. It is not called again; some rows may have been drawn that
    /// nobody gets.
    pub fn stream<C, R, E>(
        &mut self,
        geometry: impl Geometry<N>,
        background: C,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
        sink: impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E>
    where
        C: Copy + Send + Sync,
        R: Paint<C>,
    {
        self.stream_with(geometry, background, PerFragment::new(Shared(&shader)), sink)
    }

    /// Streams rows by a shader of [`LANES`] pixels at a time, as [`stream`](Self::stream) does by one
    /// for each fragment.
    ///
    /// # Errors
    /// As [`stream`](Self::stream).
    pub fn stream_blocks<C: Copy + Send + Sync, E>(
        &mut self,
        geometry: impl Geometry<N>,
        background: C,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
        sink: impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.stream_with(geometry, background, PerBlock(Shared(&shader)), sink)
    }

    fn stream_with<C, K, E>(
        &mut self,
        geometry: impl Geometry<N>,
        background: C,
        shader: K,
        mut sink: impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E>
    where
        C: Copy + Send + Sync,
        K: Shader<C, N> + Copy + Send + Sync,
    {
        let mut result = Ok(());
        let Parts { settings, level, plan, front, drawer, .. } = self.parts();
        let Drawer { corners, faces, rows, strokes } = drawer;
        settings.collect_planes(&mut front.planes);
        let call = settings.call(settings.viewport.rect(), &front.planes).by_centres();
        geometry.submit(&mut front.geometry, usize::MAX, &mut |batch| {
            let batch = match strokes.prepare(&call, batch) {
                true => &Batch { faces: &FaceList::default(), ..*batch },
                false => batch,
            };
            faces.begin(&call, level, batch, corners);
            let mut stream = Stream {
                call: &call,
                level,
                plan,
                faces,
                rows,
                strokes,
                vertices: batch.vertices,
                background,
                shader,
            };
            result = stream.run(&mut sink);
        });
        result
    }
}

drawing_methods!(ScanlineRenderer);

/// The mode of depth by which rows are ordered: that of z.
fn order_of_rows(mode: DepthMode) -> DepthMode {
    if mode.is_reversed() { DepthMode::Reversed } else { DepthMode::Standard }
}

impl<const N: usize> Renderer<N> for ScanlineRenderer<N> {
    type Drawer = Drawer;

    fn parts(&mut self) -> Parts<'_, Drawer, N> {
        let Self { settings, statistics, simd_level: level, front, drawer } = self;
        let plan = Plan::new(DepthTest::Nearer, true, order_of_rows(settings.depth));
        let counting = Counting::of(statistics.as_mut());
        Parts { settings, level: *level, plan, stencil: None, counting, front, drawer }
    }

    fn level(&self) -> Level {
        self.simd_level
    }

    fn depth_mode(&self) -> DepthMode {
        order_of_rows(self.settings.depth)
    }
}

impl DrawFaces for Drawer {
    /// All must be there before the first can be drawn.
    const MOST_FACES: usize = usize::MAX;

    fn draw(
        &mut self,
        call: &DrawCall<'_>,
        (level, plan): (Level, Plan),
        batch: &Batch<'_>,
        band: &mut Band<'_>,
        mut shading: Shading<'_>,
    ) {
        let call = &call.clone().by_centres();
        let Self { corners, faces, rows, strokes } = self;
        if strokes.prepare(call, batch) {
            return strokes.draw(call, (level, plan), band, shading);
        }
        faces.begin(call, level, batch, corners);
        let height = band.rows().len();
        let at_once = rows_at_once(band.width as u32) as usize * 2 * threads();
        for first in (0..height).step_by(at_once) {
            let (_, mut rest) = band.split(first);
            let count = rest.rows().len().min(at_once);
            let (mut part, _) = rest.split(count);
            faces.advance(call, batch.vertices, &call.window.rows_within(&part.rows()));
            draw_rows(call, (level, plan), faces, &mut part, rows, shading.reborrow());
        }
    }
}

/// A scene whose rows are handed over as they are finished.
struct Stream<'a, C, K> {
    call: &'a DrawCall<'a>,
    level: Level,
    plan: Plan,
    faces: &'a mut ActiveFaces,
    rows: &'a mut RowsMemory,
    strokes: &'a mut Strokes,
    vertices: &'a dyn Vertices,
    background: C,
    shader: K,
}

/// Some rows of the viewport, with memory that is used again.
#[derive(Debug)]
struct Rows<C> {
    numbers: std::ops::Range<u32>,
    color: Vec<C>,
    depth: Vec<f32>,
}

impl<C> Default for Rows<C> {
    fn default() -> Self {
        Self { numbers: 0..0, color: Vec::new(), depth: Vec::new() }
    }
}

impl<C: Copy + Send + Sync, K: Copy + Send + Sync> Stream<'_, C, K> {
    fn run<E, const N: usize>(
        &mut self,
        sink: &mut impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E>
    where
        K: Shader<C, N>,
    {
        let Rect { width, height, .. } = self.call.viewport.rect();
        let at_once = rows_at_once(width) * 2 * threads() as u32;
        let (mut next, mut finished) = (Rows::default(), Rows::default());
        self.draw(&mut next, 0..height.min(at_once));
        while !next.numbers.is_empty() {
            std::mem::swap(&mut next, &mut finished);
            let first = finished.numbers.end;
            let rows = first..height.min(first + at_once);
            beside(|| self.draw(&mut next, rows), || finished.deliver(width, sink))?;
        }
        Ok(())
    }

    /// Draws rows instead of those that are there.
    fn draw<const N: usize>(&mut self, rows: &mut Rows<C>, numbers: std::ops::Range<u32>)
    where
        K: Shader<C, N>,
    {
        let Rect { x, y, width, .. } = self.call.viewport.rect();
        let pixels = numbers.len() * width as usize;
        rows.color.clear();
        rows.color.resize(pixels, self.background);
        rows.depth.clear();
        rows.depth.resize(pixels, order_of_rows(self.call.depth).farthest());
        let corner = (x, y + numbers.start as i32);
        rows.numbers = numbers;
        if pixels == 0 {
            return;
        }
        let &mut Self { call, level, plan, vertices, shader, .. } = self;
        let mut band = Band::new(corner, width as usize, &mut rows.depth);
        let visited = call.window.rows_within(&band.rows());
        self.faces.advance(call, vertices, &visited);
        let (faces, memory, colors) = (&*self.faces, &mut *self.rows, &mut rows.color[..]);
        let strokes = &mut *self.strokes;
        for_level!(level, simd => {
            let mut painter = Painter::<_, _, _, N> { simd, colors, pixels_before: 0, shader };
            let shading = Shading::OnThreads(&mut painter);
            draw_rows(call, (level, plan), faces, &mut band, memory, shading);
            strokes.draw(call, (level, plan), &mut band, Shading::OnThreads(&mut painter));
        });
    }
}

impl<C> Rows<C> {
    /// Hands the rows over.
    fn deliver<E>(
        &self,
        width: u32,
        sink: &mut impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E> {
        let width = width as usize;
        self.numbers.clone().enumerate().try_for_each(|(i, number)| {
            let pixels = i * width..(i + 1) * width;
            sink(number, &self.color[pixels])
        })
    }
}
