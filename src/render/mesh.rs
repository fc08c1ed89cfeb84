//! Meshes: many faces drawn at once, on all processors.
//!
//! 1. Each vertex is projected once, and its outcode taken (`render::corners`).
//! 2. The faces are taken in chunks. Those that are outside, turned away or without a pixel are
//!    dropped, those that cross a plane are clipped, and each of the rest is put into the bins of
//!    the bands of 32 rows that it touches (`render::mesh::bins`).
//! 3. The target is cut into bands. Each band's faces are set up, eight triangles at a time, and drawn
//!    by one thread, in the order in which they were given, so the picture does not depend on the
//!    number of threads. No face is looked at by a band that it does not touch.
//!
//! The memory that this takes is kept. With N parameters it is 12 bytes a vertex; 4 bytes a corner,
//! and 4 a face where not all are triangles; 20 bytes for each band that a face touches; and 40 + 8 N
//! bytes for a vertex of a clipped face.

pub(crate) mod bins;

use std::ops::Range;

use fearless_simd::{Level, Simd};
use prefetch_index::prefetch_index;

use crate::coverage::CoverageRule;
use crate::coverage::shape::Coverage;
use crate::outline::Chain;
use crate::primitive::Primitive;
use crate::render::band::Band;
use crate::render::coarse_depth::CoarseDepth;
use crate::render::corners::ProjectedVertices;
use crate::render::faces::FaceList;
use crate::render::mesh::bins::{BAND, Bin, Binned, Chunk, FaceKind, MeshCall};
use crate::render::parallel::{Bands, Shading, first, for_each, for_each_band};
use crate::render::raster::plan::Plan;
use crate::render::raster::{self, RasterMemory};
use crate::render::shader::ShadeBlocks;
use crate::scalar::BATCH;
use crate::settings::DrawCall;
use crate::simd::for_level;
use crate::subpixel::SubpixelPoint;
use crate::surface::batch::{GatheredTriangles, TriangleBatch};
use crate::surface::rows::SurfaceView;
use crate::vertices::Vertices;

/// Faces in a chunk: enough that handing it to a thread costs nothing.
const CHUNK: usize = if cfg!(test) { 16 } else { 4096 };

/// A band with at least one face for this many pixels will touch nearly all of them, in the columns
/// where it has faces, so reading them in order first pays.
const PREFETCH_DENSITY: usize = 32;

/// As many faces, on bands with as many pixels in the columns that they extend over, are drawn in about the
/// time that it takes to wake another thread.
const FEW_FACES: usize = if cfg!(test) { 2 } else { 256 };
const FEW_PIXELS: usize = 1 << 14;

/// How many faces ahead the corners of triangles are asked for.
const AHEAD: usize = 2 * BATCH;

/// How faces that are set up become pixels.
pub(crate) trait FaceRaster: Sync {
    type Memory: Clone + std::fmt::Debug + Default + Send;

    /// Whether there is one depth a pixel, of which coarse ones can be kept.
    const HAS_COARSE_DEPTH: bool;

    /// Takes what it needs of a batch of triangles, besides what is set up of all.
    fn take_batch<S: Simd>(
        &self,
        simd: S,
        gathered: &GatheredTriangles,
        rows: &Range<i32>,
        memory: &mut Self::Memory,
    );

    /// Takes what it needs of the outline of a face that is not of a batch.
    fn take_outline(&self, points: &[SubpixelPoint], chains: &[Chain], memory: &mut Self::Memory);

    /// Draws a face in a band.
    fn draw<S: Simd>(
        &self,
        simd: S,
        drawing: (&DrawCall<'_>, Plan),
        polygon: (&SurfaceView<'_>, Coverage<'_>),
        band: &mut Band<'_>,
        memory: &mut Self::Memory,
        shader: &mut dyn ShadeBlocks,
    );
}

/// Pixels of one sample, at their centres.
struct PixelRaster;

impl FaceRaster for PixelRaster {
    type Memory = RasterMemory;
    const HAS_COARSE_DEPTH: bool = true;

    #[inline(always)]
    fn take_batch<S: Simd>(
        &self,
        _: S,
        _: &GatheredTriangles,
        _: &Range<i32>,
        _: &mut RasterMemory,
    ) {
    }

    #[inline(always)]
    fn take_outline(&self, _: &[SubpixelPoint], _: &[Chain], _: &mut RasterMemory) {}

    /// Draws a face in a band, unless the coarse depth hides it.
    #[inline(always)]
    fn draw<S: Simd>(
        &self,
        simd: S,
        (call, plan): (&DrawCall<'_>, Plan),
        (surface, coverage): (&SurfaceView<'_>, Coverage<'_>),
        band: &mut Band<'_>,
        memory: &mut RasterMemory,
        shader: &mut dyn ShadeBlocks,
    ) {
        let columns = &call.window.columns;
        if !is_hidden(call, surface, &coverage, band) {
            raster::draw(simd, plan, (surface, coverage), columns, band, memory, shader);
        }
    }
}

/// The memory for drawing meshes.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshMemory<M = RasterMemory> {
    corners: ProjectedVertices,
    chunks: Vec<Chunk>,
    workers: Vec<Worker<M>>,
}

/// The memory for drawing one band.
#[derive(Clone, Debug, Default)]
struct Worker<M> {
    gathered: GatheredTriangles,
    batch: TriangleBatch,
    primitive: Primitive,
    raster: M,
    coarse: CoarseDepth,
}

impl MeshMemory {
    /// Draws some faces of the mesh whose vertices were projected.
    pub(crate) fn draw(
        &mut self,
        call: &DrawCall<'_>,
        drawing: (Level, Plan),
        faces: (&dyn Vertices, &FaceList),
        frame: &mut Band<'_>,
        shading: Shading<'_>,
    ) {
        self.draw_by(&PixelRaster, call, drawing, faces, frame, shading);
    }
}

impl<M: Default + Send> MeshMemory<M> {
    /// Projects the vertices of a mesh, before its faces are drawn.
    pub(crate) fn project(&mut self, call: &DrawCall<'_>, level: Level, vertices: &dyn Vertices) {
        self.corners.project(call, level, vertices);
    }

    /// Draws some faces of the mesh whose vertices were projected.
    pub(crate) fn draw_by(
        &mut self,
        raster: &impl FaceRaster<Memory = M>,
        call: &DrawCall<'_>,
        (level, plan): (Level, Plan),
        (vertices, faces): (&dyn Vertices, &FaceList),
        frame: &mut Band<'_>,
        shading: Shading<'_>,
    ) {
        let Self { corners, chunks, workers } = self;
        let mesh = MeshCall { call, vertices, corners, faces };
        let bands = frame.rows().len().div_ceil(BAND as usize);
        let chunks = first(chunks, faces.len().div_ceil(CHUNK));
        for_each(chunks, |i, chunk| {
            let part = i * CHUNK..faces.len().min((i + 1) * CHUNK);
            for_level!(level, _simd => chunk.fill(&mesh, part, bands));
        });
        let chunks = &*chunks;
        let workers = first(workers, bands);
        let bands = touched_bands(chunks, bands);
        let has_coarse = has_coarse(raster);
        for_each_band(frame, bands, workers, shading, &|i, band, worker, shader| {
            let mut coarse = std::mem::take(&mut worker.coarse);
            let mut is_coarse = false;
            if has_coarse {
                let bins = chunks.iter().map(|chunk| &chunk.bins[i]);
                let columns = crowded_columns(call, bins, band);
                band.prefetch(&columns, |pixels| shader.prefetch(pixels));
                is_coarse = plan.restart(&mut coarse, band);
            }
            let mut band = band.with_coarse(is_coarse.then_some(&mut coarse));
            let mut drawing = BandDrawing { mesh, plan, raster, worker, band: &mut band, shader };
            for_level!(level, simd => for chunk in chunks {
                drawing.draw_bin(simd, chunk, i);
            });
            worker.coarse = coarse;
        });
    }
}

/// The bands that faces touch.
fn touched_bands(chunks: &[Chunk], count: usize) -> Bands {
    let (mut numbers, mut faces, mut pixels) = (count..0, 0, 0);
    for number in 0..count {
        let (in_band, columns) = extent(chunks.iter().map(|chunk| &chunk.bins[number]));
        if in_band > 0 {
            numbers = numbers.start.min(number)..number + 1;
            faces += in_band;
            pixels += columns.len() * BAND as usize;
        }
    }
    let are_shared = faces > FEW_FACES || pixels > FEW_PIXELS;
    Bands { height: BAND as usize, numbers, are_shared }
}

/// The number of faces in a band, and the columns that they extend over.
fn extent<'b>(bins: impl Iterator<Item = &'b Bin>) -> (usize, Range<i32>) {
    let (mut faces, mut left, mut right) = (0, i32::MAX, i32::MIN);
    for bin in bins {
        faces += bin.faces.len();
        (left, right) = (left.min(bin.columns.0), right.max(bin.columns.1));
    }
    (faces, left..right)
}

/// The columns of a band that its faces extend over, if these are so many that reading all pixels
/// there pays.
fn crowded_columns<'b>(
    call: &DrawCall<'_>,
    bins: impl Iterator<Item = &'b Bin>,
    band: &Band<'_>,
) -> Range<usize> {
    let (faces, columns) = extent(bins);
    let rows = band.rows().len();
    if columns.is_empty() || faces.saturating_mul(PREFETCH_DENSITY) < columns.len() * rows {
        return 0..0;
    }
    call.window.column_on_frame(columns.start)..call.window.column_on_frame(columns.end)
}

/// A band of a mesh being drawn.
struct BandDrawing<'d, 'b, R: FaceRaster> {
    mesh: MeshCall<'d>,
    plan: Plan,
    raster: &'d R,
    worker: &'d mut Worker<R::Memory>,
    band: &'d mut Band<'b>,
    shader: &'d mut dyn ShadeBlocks,
}

fn has_coarse<R: FaceRaster>(_: &R) -> bool {
    R::HAS_COARSE_DEPTH
}

impl<R: FaceRaster> BandDrawing<'_, '_, R> {
    /// Draws a chunk's faces in the band.
    #[inline(always)]
    fn draw_bin<S: Simd>(&mut self, simd: S, chunk: &Chunk, band_number: usize) {
        let MeshCall { call, vertices, corners, faces } = self.mesh;
        let binned = &chunk.bins[band_number].faces;
        let rows = call.window.rows_within(&self.band.rows());
        let is_by_centres = call.coverage_rule == CoverageRule::Centre;
        // Triangles of the batch that are yet to be drawn.
        let mut ready = 0..0;
        for (i, &Binned { face, kind }) in binned.iter().enumerate() {
            let number = faces.number(face);
            if let Some(Binned { kind: FaceKind::Clipped(clipped), .. }) = binned.get(i + AHEAD) {
                chunk.prefetch_clipped(*clipped as usize);
            }
            if let FaceKind::Triangle(_) = kind
                && is_by_centres
                && !simd.level().is_fallback()
            {
                if ready.is_empty() {
                    ready = 0..self.gather(&binned[i..]);
                    self.prefetch(&binned[binned.len().min(i + AHEAD)..]);
                    let Worker { batch, gathered, .. } = &mut *self.worker;
                    set_up(simd, call, (batch, gathered), &rows);
                    let Worker { raster, gathered, .. } = &mut *self.worker;
                    self.raster.take_batch(simd, gathered, &rows, raster);
                }
                let lane = ready.start;
                ready.start += 1;
                let Worker { batch, raster, .. } = &mut *self.worker;
                if let Some((surface, edges)) = batch.take(lane, call, number) {
                    let primitive = (&surface, Coverage::Triangle(edges));
                    let drawing = (call, self.plan);
                    self.raster.draw(simd, drawing, primitive, self.band, raster, self.shader);
                    continue;
                }
            }
            let Worker { primitive, raster, .. } = &mut *self.worker;
            if let FaceKind::Clipped(clipped) = kind {
                let polygon = chunk.clipped(clipped as usize);
                primitive.prepare_clipped(call, number, &polygon, &rows);
                self.raster.take_outline(polygon.points, polygon.chains, raster);
            } else {
                let corner = |&i: &u32| {
                    let (position, params) = vertices.get(i)?;
                    Some((position, params, corners.points[i as usize]))
                };
                let indices = faces.get(face as usize).iter();
                primitive.prepare_inside(call, number, indices.filter_map(corner), &rows);
                self.raster.take_outline(primitive.points(), &[], raster);
            }
            let drawing = (self.raster, call, self.plan);
            draw_prepared(simd, drawing, primitive, self.band, raster, self.shader);
        }
    }

    /// Asks for the corners of triangles that are to be gathered later: in a mesh without order each of
    /// them would be waited for.
    #[inline(always)]
    fn prefetch(&self, binned: &[Binned]) {
        let MeshCall { vertices, corners, .. } = self.mesh;
        let mut triangles = [[0; 3]; BATCH];
        for (triangle, face) in triangles.iter_mut().zip(binned) {
            if let FaceKind::Triangle(indices) = face.kind {
                *triangle = indices;
                for i in indices {
                    prefetch_index(&corners.points, i as usize);
                }
            }
        }
        vertices.prefetch(&triangles);
    }

    /// Puts the next triangles side by side; how many there are.
    #[inline(always)]
    fn gather(&mut self, binned: &[Binned]) -> usize {
        let MeshCall { call, vertices, corners, .. } = self.mesh;
        let gathered = &mut self.worker.gathered;
        gathered.resize(call.params());
        let mut triangles = [[0; 3]; BATCH];
        let mut count = 0;
        for face in binned {
            if let FaceKind::Triangle(indices) = face.kind {
                triangles[count % BATCH] = indices;
                for (points, i) in gathered.points.iter_mut().zip(indices) {
                    points[count % BATCH] = corners.points[i as usize];
                }
                count += 1;
                if count == BATCH {
                    break;
                }
            }
        }
        vertices.gather(&triangles[..count], &mut gathered.positions, &mut gathered.params);
        count
    }
}

/// Sets up a batch of triangles. Not inlined: without SIMD and optimisation this alone would need a stack
/// of megabytes, and without SIMD it is never called.
#[inline(never)]
fn set_up<S: Simd>(
    simd: S,
    call: &DrawCall<'_>,
    (batch, gathered): (&mut TriangleBatch, &GatheredTriangles),
    rows: &Range<i32>,
) {
    simd.vectorize(
        #[inline(always)]
        || batch.set_up(simd, call, gathered, rows),
    );
}

/// Draws a face that is not one of a batch. Not inlined: the code would be there twice.
#[inline(never)]
fn draw_prepared<S: Simd, R: FaceRaster>(
    simd: S,
    (raster, call, plan): (&R, &DrawCall<'_>, Plan),
    primitive: &mut Primitive,
    band: &mut Band<'_>,
    memory: &mut R::Memory,
    shader: &mut dyn ShadeBlocks,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (surface, coverage) = primitive.parts();
            let drawing = (call, plan);
            raster.draw(simd, drawing, (&surface, coverage), band, memory, shader);
        },
    );
}

/// Whether the coarse depth hides a face, by its columns and rows and its range of depths.
#[inline(always)]
fn is_hidden(
    call: &DrawCall<'_>,
    surface: &SurfaceView<'_>,
    coverage: &Coverage<'_>,
    band: &mut Band<'_>,
) -> bool {
    let first = band.first as usize;
    let Some(coarse) = &mut band.coarse else { return false };
    if coarse.is_idle() {
        return false;
    }
    let window = &call.window;
    let Some((columns, rows)) = coverage.extent(&window.columns) else { return false };
    let columns = window.column_on_frame(columns.start)..window.column_on_frame(columns.end);
    let row = |row: i32| window.row_on_frame(row).wrapping_sub(first);
    coarse.hides_polygon(band.depth, columns, row(rows.start)..row(rows.end), surface.base.z_range)
}
