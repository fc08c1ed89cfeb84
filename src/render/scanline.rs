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
//! The memory that this takes, with N parameters: 24 bytes a face that is in view and 4 a corner of
//! it; 12 bytes a vertex, while faces are sorted; some 250 + 40 N bytes an active face and 40 + 8 N a
//! corner of it; 24 bytes for each run in the rows being drawn. Of the picture there are four parts
//! a thread in memory, of at most 2^18 pixels each. Nothing grows with the height.

use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
#[cfg(feature = "parallel")]
use rayon::prelude::*;

use crate::clip::{ClipPlane, Outcode, Outcome};
use crate::edge_table::{EdgeTable, FillRule, Run, first_centre};
use crate::fragment::{Fragment, FragmentBlock, LANES};
use crate::polygon::ScreenPolygon;
use crate::project::{FixedPoint, Rect, Viewport};
use crate::render::framebuffer::{Band, Framebuffer};
use crate::render::raster::Raster;
#[cfg(not(feature = "parallel"))]
use crate::render::sequential::*;
use crate::render::shader::{Paint, PerBlock, PerFragment, Shader};
use crate::render::visible::{DepthLine, Row};
use crate::render::z_buffer::{DepthSource, DepthTest};
use crate::scan::{ScanConverter, ScreenOutline};
use crate::span::Span;
use crate::vertex::Vertex;

/// The most pixels that a thread draws at a time, four rows of the widest viewport: enough that
/// handing them to a thread and finding the faces' edges there costs little, and a few megabytes of
/// colours.
const PIECE: u32 = 1 << 18;

/// The most rows, so that there is something for all threads.
const PIECE_ROWS: u32 = 32;

/// Faces set up by one thread at a time.
const FACES: usize = 256;

/// Vertices projected by one thread at a time.
const VERTICES: usize = 4096;

/// Draws meshes row by row, each visible pixel shaded once; for pictures too large to be in memory,
/// for costly shaders, and for transparent faces that cross.
///
/// ```
/// use glam::vec4;
/// use polyscan::{Scanline, Vertex, Viewport};
///
/// let vertices = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// let mut renderer = Scanline::new(Viewport::new(4, 3)?);
/// let mut picture = Vec::new();
/// renderer.draw(&vertices, [[0, 1, 2]], '.', |_| '#', |_, row| {
///     picture.push(row.iter().collect::<String>());
///     Ok::<(), std::fmt::Error>(())
/// })?;
/// assert_eq!(picture, ["#...", "##..", "###."]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scanline<const N: usize> {
    /// Where and how polygons are scan-converted: viewport, scissor, culling, interpolation.
    pub scan: ScanConverter<N>,
    /// Whether what has greater depth is nearer, as it is for
    /// [`DepthTest::Greater`](crate::DepthTest::Greater).
    pub reversed: bool,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The picture is
    /// the same with any.
    pub level: Level,
    memory: Memory<N>,
}

/// Memory that is kept.
#[derive(Clone, Debug, Default)]
struct Memory<const N: usize> {
    planes: Vec<ClipPlane>,
    /// The corners of the faces in `waiting`, end to end.
    indices: Vec<u32>,
    /// The faces that may have pixels, by first row.
    waiting: Vec<Waiting>,
    active: Vec<Active<N>>,
    /// Faces that are not active any more, for their memory.
    spare: Vec<Active<N>>,
    setups: Vec<Setup<N>>,
    workers: Vec<Worker>,
}

/// A face that is not active yet.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    first_row: i32,
    face: u32,
    /// Where its corners begin.
    indices: usize,
    sides: u32,
    transparent: bool,
}

/// A face that has pixels in the rows being drawn.
#[derive(Clone, Debug)]
struct Active<const N: usize> {
    rows: Range<i32>,
    face: Waiting,
    polygon: ScreenPolygon<N>,
    outline: ScreenOutline,
}

/// What it takes to set faces up.
#[derive(Clone, Debug)]
struct Setup<const N: usize> {
    scan: ScanConverter<N>,
    face: Vec<Vertex<N>>,
}

/// The memory for drawing some rows.
#[derive(Clone, Debug, Default)]
struct Worker {
    edges: EdgeTable,
    runs: Vec<(u32, Run)>,
    row: Row,
}

impl<const N: usize> Scanline<N> {
    /// A renderer to a viewport, with the settings of [`ScanConverter::new`], for depths that are
    /// nearer when smaller.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            scan: ScanConverter::new(viewport),
            reversed: false,
            level: Level::new(),
            memory: Memory::default(),
        }
    }

    /// Draws opaque faces and hands over the rows: [`scene`](Self::scene) and [`Scene::draw`] in
    /// one.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn draw<C, R, F, E>(
        &mut self,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        background: C,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
        sink: impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E>
    where
        C: Copy + Send + Sync,
        R: Paint<C>,
        F: AsRef<[u32]>,
    {
        self.scene(vertices, faces).draw(background, shader, sink)
    }

    /// Draws opaque faces on a framebuffer: [`scene`](Self::scene) and [`Scene::draw_on`] in one.
    pub fn draw_mesh<C, R, F>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
    ) where
        C: Copy + Send + Sync,
        R: Paint<C>,
        F: AsRef<[u32]>,
    {
        self.scene(vertices, faces).draw_on(frame, shader);
    }

    /// Sorts the faces of a scene, each a list of indices into `vertices`, by their first rows. A
    /// face with an index out of range is left out. All are opaque, unless
    /// [declared otherwise](Scene::transparent).
    ///
    /// Settings are changed before this, not after.
    pub fn scene<'a, F: AsRef<[u32]>>(
        &'a mut self,
        vertices: &'a [Vertex<N>],
        faces: impl IntoIterator<Item = F>,
    ) -> Scene<'a, N> {
        let memory = &mut self.memory;
        memory.indices.clear();
        memory.waiting.clear();
        memory.setups.clear();
        memory.spare.append(&mut memory.active);
        let [columns, rows] = self.scan.window(self.scan.viewport.rect());
        if !columns.is_empty() && !rows.is_empty() {
            self.sort(vertices, faces, &rows);
        }
        Scene { renderer: self, vertices, next: 0 }
    }

    /// Puts the faces in order.
    fn sort<F: AsRef<[u32]>>(
        &mut self,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        rows: &Range<i32>,
    ) {
        let mut planes = std::mem::take(&mut self.memory.planes);
        self.scan.collect_planes(&mut planes);
        let corners = project(&self.scan.viewport, &planes, vertices);
        self.memory.planes = planes;

        let mut setup = Setup { scan: self.scan.clone(), face: Vec::new() };
        let (mut polygon, mut outline) = (ScreenPolygon::default(), ScreenOutline::default());
        let mut number = 0u32;
        for face in faces {
            let (indices, face) = (face.as_ref(), number);
            number = number.wrapping_add(1);
            let first = match outcome(&corners, indices) {
                Outcome::Outside => None,
                Outcome::Inside => rows_of(indices.iter().map(|&i| corners[i as usize].y), rows),
                Outcome::Clipped => setup
                    .set_up(vertices, indices, &mut polygon, &mut outline)
                    .then(|| rows_of(heights(&outline.points), rows))
                    .flatten(),
            };
            let (Some(first), Ok(sides)) = (first, u32::try_from(indices.len())) else { continue };
            let Memory { indices: all, waiting, .. } = &mut self.memory;
            let (first_row, transparent) = (first.start, false);
            waiting.push(Waiting { first_row, face, indices: all.len(), sides, transparent });
            all.extend_from_slice(indices);
        }
        self.memory.waiting.sort_unstable_by_key(|face| (face.first_row, face.face));
    }
}

/// What is known of a vertex whatever its faces are.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// Subpixels below the viewport's top side.
    y: i32,
    /// `None` if the position is not finite.
    outcode: Option<Outcode>,
}

fn project<const N: usize>(
    viewport: &Viewport,
    planes: &[ClipPlane],
    vertices: &[Vertex<N>],
) -> Vec<Corner> {
    let mut corners = vec![Corner { y: 0, outcode: None }; vertices.len()];
    let parts = corners.par_chunks_mut(VERTICES).zip(vertices.par_chunks(VERTICES));
    parts.for_each(|(corners, vertices)| {
        for (corner, vertex) in corners.iter_mut().zip(vertices) {
            let position = vertex.position.as_dvec4();
            *corner = Corner {
                y: FixedPoint::project(position, viewport).y,
                outcode: position.is_finite().then(|| Outcode::new(position, planes)),
            };
        }
    });
    corners
}

/// What clipping makes of a face; outside if it is none.
fn outcome(corners: &[Corner], indices: &[u32]) -> Outcome {
    let outcode = |&i: &u32| corners.get(i as usize).and_then(|corner| corner.outcode);
    if indices.len() < 3 || !indices.iter().all(|i| outcode(i).is_some()) {
        return Outcome::Outside;
    }
    Outcode::outcome(indices.iter().filter_map(outcode)).0
}

/// The vertical positions of an outline.
fn heights(outline: &[FixedPoint]) -> impl Iterator<Item = i32> {
    outline.iter().map(|point| point.y)
}

/// The rows of `rows` that an outline of such vertical positions crosses, if any.
fn rows_of(heights: impl Iterator<Item = i32>, rows: &Range<i32>) -> Option<Range<i32>> {
    let (top, bottom) =
        heights.fold((i32::MAX, i32::MIN), |(top, bottom), y| (top.min(y), bottom.max(y)));
    let rows = first_centre(top).max(rows.start)..first_centre(bottom).min(rows.end);
    (!rows.is_empty()).then_some(rows)
}

impl<const N: usize> Setup<N> {
    /// Sets a face up in `polygon` and `outline`; whether there may be something to see.
    fn set_up(
        &mut self,
        vertices: &[Vertex<N>],
        indices: &[u32],
        polygon: &mut ScreenPolygon<N>,
        outline: &mut ScreenOutline,
    ) -> bool {
        self.face.clear();
        self.face.extend(indices.iter().filter_map(|&i| vertices.get(i as usize)));
        self.scan.set_up_in(&self.face, polygon, outline)
    }
}

/// A scene that is ready to be drawn, from [`Scanline::scene`].
///
/// Of the faces that cover a pixel the nearest opaque one is seen there, of equals the first, as it
/// is with [`ZBuffer`](crate::ZBuffer) and its settings from the beginning. Its shader is called
/// once; if it discards the fragment, what lies behind is *not* seen, so declare faces that have
/// holes transparent.
///
/// Transparent faces are drawn where they are nearer than that, from back to front at each pixel
/// even where they cross, of equals the last one first. Each is drawn by the same shader on what
/// lies behind it: [`Over`](crate::render::Over) or [`Plus`](crate::render::Plus) blend, `None`
/// leaves a hole, a plain colour covers.
#[derive(Debug)]
pub struct Scene<'a, const N: usize> {
    renderer: &'a mut Scanline<N>,
    vertices: &'a [Vertex<N>],
    /// The first face that has not been active yet.
    next: usize,
}

impl<const N: usize> Scene<'_, N> {
    /// Declares which faces are transparent, or may have holes, by their numbers: 0 for the first
    /// that was given.
    ///
    /// ```
    /// use glam::{Vec4, vec4};
    /// use polyscan::{Framebuffer, Scanline, Vertex, render::Over};
    ///
    /// let square = |z: f32| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, z, 1.0), []));
    /// let vertices = [square(0.2), square(0.8)].concat();
    /// let mut frame = Framebuffer::new(1, 1, Vec4::W)?;
    /// let mut renderer = Scanline::new(frame.viewport());
    /// // Red glass, given first, before a green wall.
    /// let scene = renderer.scene(&vertices, [[0, 1, 2, 3], [4, 5, 6, 7]]);
    /// scene.transparent(|face| face == 0).draw_on(&mut frame, |fragment| {
    ///     Over(if fragment.face == 0 { vec4(0.5, 0.0, 0.0, 0.5) } else { vec4(0.0, 1.0, 0.0, 1.0) })
    /// });
    /// assert_eq!(frame.color(), [vec4(0.5, 0.5, 0.0, 1.0)]);
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    pub fn transparent(self, is_transparent: impl Fn(u32) -> bool) -> Self {
        for face in &mut self.renderer.memory.waiting {
            face.transparent = is_transparent(face.face);
        }
        self
    }

    /// Draws the scene on a background and hands the rows of the viewport over, as soon as they are
    /// finished: `sink` is called once for each row, in their order, with its number from 0 at the
    /// viewport's top, and the colours of the viewport's columns. It runs on this thread, while
    /// others draw the next rows. Where the viewport's corner is, is of no account but for the
    /// positions that fragments have.
    ///
    /// The rows are those of a framebuffer cleared to the background and the depth 1.0, or 0.0 if
    /// depth is reversed.
    ///
    /// # Errors
    /// The first that the sink returns. It is not called again; some rows may have been drawn that
    /// nobody gets.
    pub fn draw<C, R, E>(
        self,
        background: C,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
        sink: impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E>
    where
        C: Copy + Send + Sync,
        R: Paint<C>,
    {
        self.stream(background, &PerFragment(shader), sink)
    }

    /// The same with a shader of blocks, as in [`ZBuffer::draw_blocks`](crate::ZBuffer::draw_blocks).
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    pub fn draw_blocks<C: Copy + Send + Sync, E>(
        self,
        background: C,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
        sink: impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.stream(background, &PerBlock(shader), sink)
    }

    /// Draws the scene on a framebuffer, over what is farther there, as
    /// [`ZBuffer::draw_mesh`](crate::ZBuffer::draw_mesh) would. The depths of opaque faces are
    /// stored.
    pub fn draw_on<C, R>(
        self,
        frame: &mut Framebuffer<C>,
        shader: impl Fn(&Fragment<'_, N>) -> R + Sync,
    ) where
        C: Copy + Send + Sync,
        R: Paint<C>,
    {
        self.fill(frame, &PerFragment(shader));
    }

    /// The same with a shader of blocks.
    pub fn draw_blocks_on<C: Copy + Send + Sync>(
        self,
        frame: &mut Framebuffer<C>,
        shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync,
    ) {
        self.fill(frame, &PerBlock(shader));
    }

    fn fill<C: Copy + Send + Sync>(
        mut self,
        frame: &mut Framebuffer<C>,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let (height, rows) = (frame.height(), batch_rows(frame.width()));
        let window = self.renderer.scan.window(frame.rect());
        if window.iter().any(Range::is_empty) {
            return;
        }
        for first in (0..height).step_by(rows as usize) {
            let band = frame.band_of(first..height.min(first + rows));
            self.draw_band(band, &window, None, shader);
        }
    }

    fn stream<C: Copy + Send + Sync, E>(
        mut self,
        background: C,
        shader: &(impl Shader<N, C> + Sync),
        mut sink: impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E> {
        let Rect { width, height, .. } = self.renderer.scan.viewport.rect();
        let rows = batch_rows(width);
        let (mut next, mut finished) = (Batch::default(), Batch::default());
        next.draw(&mut self, 0..height.min(rows), background, shader);
        while !next.rows.is_empty() {
            std::mem::swap(&mut next, &mut finished);
            let first = finished.rows.end;
            let rows = first..height.min(first + rows);
            together(
                || next.draw(&mut self, rows, background, shader),
                || finished.deliver(width, &mut sink),
            )?;
        }
        Ok(())
    }

    /// Draws the scene's part in a band of the framebuffer; bands come from top to bottom.
    /// `background` is what the band is filled with before.
    fn draw_band<C: Copy + Send + Sync>(
        &mut self,
        mut band: Band<'_, C>,
        window: &[Range<i32>; 2],
        background: Option<C>,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let corner = self.renderer.scan.viewport.rect().y;
        let rows_of = |band: &Band<'_, C>| {
            let Range { start, end } = band.rows();
            window[1].start.max(start - corner)..window[1].end.min(end - corner)
        };
        self.advance(&rows_of(&band));
        let Scanline { scan, reversed, level, memory, .. } = &mut *self.renderer;
        let Memory { active, workers, .. } = memory;
        let job = Job {
            active,
            columns: window[0].clone(),
            fill_rule: scan.fill_rule,
            reversed: *reversed,
        };
        let height = piece_rows(band.width() as u32);
        let pieces = band.rows().len().div_ceil(height as usize);
        workers.resize_with(pieces.max(workers.len()), Worker::default);
        band.par_bands(height).zip(workers.par_iter_mut()).for_each(|(mut band, worker)| {
            if let Some(color) = background {
                band.color.fill(color);
                band.depth.fill(job.farthest());
            }
            let rows = rows_of(&band);
            dispatch!(*level, simd => job.draw(simd, worker, &rows, &mut band, shader));
        });
    }

    /// Makes those faces active that have pixels in the given rows, and no others.
    fn advance(&mut self, rows: &Range<i32>) {
        let Scanline { scan, memory, .. } = &mut *self.renderer;
        let Memory { indices, waiting, active, spare, setups, .. } = memory;
        let mut i = 0;
        while i < active.len() {
            if active[i].rows.end <= rows.start {
                spare.push(active.swap_remove(i));
            } else {
                i += 1;
            }
        }
        let first = active.len();
        while let Some(&face) = waiting.get(self.next).filter(|face| face.first_row < rows.end) {
            self.next += 1;
            let (polygon, outline) =
                spare.pop().map(|face| (face.polygon, face.outline)).unwrap_or_default();
            active.push(Active { rows: 0..0, face, polygon, outline });
        }
        let entering = &mut active[first..];
        while setups.len() < entering.len().div_ceil(FACES) {
            setups.push(Setup { scan: scan.clone(), face: Vec::new() });
        }
        let [_, all_rows] = scan.window(scan.viewport.rect());
        let (vertices, indices) = (self.vertices, &*indices);
        let parts = entering.par_chunks_mut(FACES).zip(setups.par_iter_mut());
        parts.for_each(|(faces, setup)| {
            faces.iter_mut().for_each(|face| face.set_up(setup, vertices, indices, &all_rows));
        });
    }
}

/// How many rows one thread draws at a time.
fn piece_rows(width: u32) -> u32 {
    (PIECE / width.max(1)).clamp(1, PIECE_ROWS)
}

/// How many rows all threads draw at a time: two pieces each, since some take longer.
fn batch_rows(width: u32) -> u32 {
    #[cfg(feature = "parallel")]
    let threads = rayon::current_num_threads() as u32;
    #[cfg(not(feature = "parallel"))]
    let threads = 1;
    piece_rows(width) * 2 * threads
}

/// Does both: `deliver` on this thread, and `draw` where there is time for it.
fn together<R>(draw: impl FnOnce() + Send, deliver: impl FnOnce() -> R) -> R {
    #[cfg(feature = "parallel")]
    return rayon::in_place_scope(|scope| {
        scope.spawn(|_| draw());
        deliver()
    });
    #[cfg(not(feature = "parallel"))]
    {
        let result = deliver();
        draw();
        result
    }
}

/// Some rows of the viewport, with memory that is used again.
#[derive(Debug)]
struct Batch<C> {
    rows: Range<u32>,
    color: Vec<C>,
    depth: Vec<f32>,
}

impl<C> Default for Batch<C> {
    fn default() -> Self {
        Self { rows: 0..0, color: Vec::new(), depth: Vec::new() }
    }
}

impl<C: Copy + Send + Sync> Batch<C> {
    /// Draws rows instead of those that it has.
    fn draw<const N: usize>(
        &mut self,
        scene: &mut Scene<'_, N>,
        rows: Range<u32>,
        background: C,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let scan = &scene.renderer.scan;
        let rect @ Rect { x, y, width, .. } = scan.viewport.rect();
        let pixels = rows.len() * width as usize;
        self.color.resize(pixels, background);
        self.depth.resize(pixels, 0.0);
        let corner = (x, y + rows.start as i32);
        self.rows = rows;
        if pixels > 0 {
            let (width, window) = (width as usize, scan.window(rect));
            let band = Band::new(corner, width, &mut self.color, &mut self.depth);
            scene.draw_band(band, &window, Some(background), shader);
        }
    }

    /// Hands the rows over.
    fn deliver<E>(
        &self,
        width: u32,
        sink: &mut impl FnMut(u32, &[C]) -> Result<(), E>,
    ) -> Result<(), E> {
        let width = width as usize;
        self.rows.clone().enumerate().try_for_each(|(i, row)| {
            let pixels = i * width..(i + 1) * width;
            sink(row, &self.color[pixels])
        })
    }
}

/// Faces being drawn.
struct Job<'a, const N: usize> {
    active: &'a [Active<N>],
    columns: Range<i32>,
    fill_rule: FillRule,
    reversed: bool,
}

impl<const N: usize> Job<'_, N> {
    /// The depth behind which nothing is seen.
    fn farthest(&self) -> f32 {
        if self.reversed { 0.0 } else { 1.0 }
    }

    /// Draws rows into a band that holds them.
    #[inline(always)]
    fn draw<S: Simd, C: Copy>(
        &self,
        simd: S,
        worker: &mut Worker,
        rows: &Range<i32>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let test = if self.reversed { DepthTest::Greater } else { DepthTest::Less };
        worker.find_runs(self, rows);
        let Worker { runs, row, .. } = worker;
        for runs in runs.chunk_by(|(_, a), (_, b)| a.y == b.y) {
            self.fill_row(runs, row);
            for stroke in row.strokes() {
                let (face, run) = &runs[stroke.run as usize];
                let polygon = &self.active[*face as usize].polygon;
                let Some(span) = Span::new(polygon, run, &stroke.columns) else { continue };
                let raster = Raster { test, write: !stroke.transparent, source: DepthSource::Z };
                raster.draw_any(simd, span, band, shader);
            }
        }
    }

    /// Replaces the runs of `row` by those of one row, with the depths that their fragments have.
    #[inline(never)]
    fn fill_row(&self, runs: &[(u32, Run)], row: &mut Row) {
        row.clear();
        for ((face, run), i) in runs.iter().zip(0..) {
            let Active { polygon, face, .. } = &self.active[*face as usize];
            let line = polygon.line(run);
            let mut depth = DepthLine { x: line.x, at: line.at.z, delta: line.delta.z };
            let mut limits = polygon.z;
            if self.reversed {
                (depth.at, depth.delta) = (-depth.at, -depth.delta);
                limits = (-limits.1, -limits.0);
            }
            row.add((i, face.face, face.transparent), self.visible(run), depth, limits);
        }
    }

    /// The columns of a run that are drawn.
    fn visible(&self, run: &Run) -> Range<i32> {
        run.x.start.max(self.columns.start)..run.x.end.min(self.columns.end)
    }
}

impl<const N: usize> Active<N> {
    /// Sets the face up and finds its rows; none if there is nothing to see.
    fn set_up(
        &mut self,
        setup: &mut Setup<N>,
        vertices: &[Vertex<N>],
        indices: &[u32],
        all_rows: &Range<i32>,
    ) {
        let Waiting { indices: first, sides, face, .. } = self.face;
        let indices = &indices[first..first + sides as usize];
        let Self { polygon, outline, .. } = self;
        let is_visible = setup.set_up(vertices, indices, polygon, outline);
        self.polygon.face = face;
        self.rows = is_visible
            .then(|| rows_of(heights(&self.outline.points), all_rows))
            .flatten()
            .unwrap_or(0..0);
    }
}

impl Worker {
    /// Finds the runs of all active faces in some rows, from top to bottom and in each row from left
    /// to right.
    fn find_runs<const N: usize>(&mut self, job: &Job<'_, N>, rows: &Range<i32>) {
        let Self { edges, runs, .. } = self;
        runs.clear();
        for (face, i) in job.active.iter().zip(0..) {
            let rows = face.rows.start.max(rows.start)..face.rows.end.min(rows.end);
            if !rows.is_empty() {
                edges.fill_rule = job.fill_rule;
                edges.fill_outline(&face.outline.points, &face.outline.chains, rows);
                let visible = edges.runs().filter(|run| !job.visible(run).is_empty());
                runs.extend(visible.map(|run| (i, run)));
            }
        }
        runs.sort_unstable_by_key(|(_, run)| (run.y, run.x.start));
    }
}
