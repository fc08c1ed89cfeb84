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
use crate::primitive::Primitive;
use crate::render::band::Band;
use crate::render::coarse_depth::CoarseDepth;
use crate::render::corners::ProjectedVertices;
use crate::render::faces::FaceList;
use crate::render::mesh::bins::{BAND, Bin, Binned, Chunk, FaceKind, MeshCall};
use crate::render::parallel::{Shading, first, for_each, for_each_band};
use crate::render::raster::plan::Plan;
use crate::render::raster::{self, RasterMemory};
use crate::render::shader::ShadeBlocks;
use crate::scalar::BATCH;
use crate::settings::DrawCall;
use crate::simd::for_level;
use crate::surface::batch::{GatheredTriangles, TriangleBatch};
use crate::surface::rows::SurfaceView;
use crate::vertices::Vertices;

/// Faces in a chunk: enough that handing it to a thread costs nothing.
const CHUNK: usize = if cfg!(test) { 16 } else { 4096 };

/// A band with at least one face for this many pixels will touch nearly all of them, in the columns
/// where it has faces, so reading them in order first pays.
const PREFETCH_DENSITY: usize = 32;

/// How many faces ahead the corners of triangles are asked for.
const AHEAD: usize = 2 * BATCH;

/// The memory for drawing meshes.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshMemory {
    corners: ProjectedVertices,
    chunks: Vec<Chunk>,
    workers: Vec<Worker>,
}

/// The memory for drawing one band.
#[derive(Clone, Debug, Default)]
struct Worker {
    gathered: GatheredTriangles,
    batch: TriangleBatch,
    primitive: Primitive,
    raster: RasterMemory,
    coarse: CoarseDepth,
}

impl MeshMemory {
    /// Projects the vertices of a mesh, before its faces are drawn.
    pub(crate) fn project(&mut self, call: &DrawCall<'_>, level: Level, vertices: &dyn Vertices) {
        self.corners.project(call, level, vertices);
    }

    /// Draws some faces of the mesh whose vertices were projected.
    pub(crate) fn draw(
        &mut self,
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
        for_each_band(frame, BAND as usize, workers, shading, &|i, band, worker, shader| {
            let columns = crowded_columns(call, chunks.iter().map(|chunk| &chunk.bins[i]), band);
            band.prefetch(&columns, |pixels| shader.prefetch(pixels));
            let mut coarse = std::mem::take(&mut worker.coarse);
            let is_coarse = plan.restart(&mut coarse, band);
            let mut band = band.with_coarse(is_coarse.then_some(&mut coarse));
            let mut drawing = BandDrawing { mesh, plan, worker, band: &mut band, shader };
            for_level!(level, simd => for chunk in chunks {
                drawing.draw_bin(simd, chunk, i);
            });
            worker.coarse = coarse;
        });
    }
}

/// The columns of a band that its faces extend over, if these are so many that reading all pixels
/// there pays.
fn crowded_columns<'b>(
    call: &DrawCall<'_>,
    bins: impl Iterator<Item = &'b Bin>,
    band: &Band<'_>,
) -> Range<usize> {
    let (mut faces, mut left, mut right) = (0, i32::MAX, i32::MIN);
    for bin in bins {
        faces += bin.faces.len();
        (left, right) = (left.min(bin.columns.0), right.max(bin.columns.1));
    }
    let rows = band.rows().len();
    if left >= right || faces.saturating_mul(PREFETCH_DENSITY) < (left..right).len() * rows {
        return 0..0;
    }
    call.window.column_on_frame(left)..call.window.column_on_frame(right)
}

/// A band of a mesh being drawn.
struct BandDrawing<'d, 'b> {
    mesh: MeshCall<'d>,
    plan: Plan,
    worker: &'d mut Worker,
    band: &'d mut Band<'b>,
    shader: &'d mut dyn ShadeBlocks,
}

impl BandDrawing<'_, '_> {
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
                }
                let lane = ready.start;
                ready.start += 1;
                let Worker { batch, raster, .. } = &mut *self.worker;
                if let Some((surface, edges)) = batch.take(lane, call, number) {
                    let primitive = (&surface, Coverage::Triangle(edges));
                    draw_primitive(
                        simd,
                        (call, self.plan),
                        primitive,
                        self.band,
                        raster,
                        self.shader,
                    );
                    continue;
                }
            }
            let Worker { primitive, raster, .. } = &mut *self.worker;
            if let FaceKind::Clipped(clipped) = kind {
                let polygon = chunk.clipped(clipped as usize);
                primitive.prepare_clipped(call, number, &polygon, &rows);
            } else {
                let corner = |&i: &u32| {
                    let (position, params) = vertices.get(i)?;
                    Some((position, params, corners.points[i as usize]))
                };
                let indices = faces.get(face as usize).iter();
                primitive.prepare_inside(call, number, indices.filter_map(corner), &rows);
            }
            let drawing = (call, self.plan);
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
fn draw_prepared<S: Simd>(
    simd: S,
    drawing: (&DrawCall<'_>, Plan),
    primitive: &mut Primitive,
    band: &mut Band<'_>,
    memory: &mut RasterMemory,
    shader: &mut dyn ShadeBlocks,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let (surface, coverage) = primitive.parts();
            draw_primitive(simd, drawing, (&surface, coverage), band, memory, shader);
        },
    );
}

/// Draws a face in a band, unless the coarse depth hides it.
#[inline(always)]
fn draw_primitive<S: Simd>(
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
