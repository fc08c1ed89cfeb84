//! Meshes: many faces drawn at once, on all processors.
//!
//! 1. Each vertex is projected once, and its outcode taken.
//! 2. The faces are taken in chunks. Those that are outside, turned away or without a pixel are
//!    dropped, those that cross a plane are clipped, and each of the rest is put into the bins of
//!    the bands of [`BAND`] rows that it touches.
//! 3. The framebuffer is cut into bands. Each band's faces are set up, eight triangles at a time,
//!    and scan-converted by one thread, in the order in which they were given, so the picture does
//!    not depend on the number of threads. No face is looked at by a band that it does not touch.
//!
//! The memory that this takes is kept. With N parameters it is 12 bytes a vertex; 4 bytes a corner,
//! and 4 a face where not all are triangles; 20 bytes for each band that a face touches; and 32 + 8 N
//! bytes for a vertex of a clipped face.

mod bins;
mod faces;

use std::ops::Range;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use fearless_simd::{Level, Simd, dispatch};

use self::bins::{Bin, Binned, Chunk, Kind};
use self::faces::Faces;
use crate::clip::{ClipPlane, ClipVertex, Outcode, Outcome, Volume};
use crate::edge_table::{EdgeTable, RunGroups};
use crate::number::TRIANGLES;
use crate::outline::Chain;
use crate::polygon::{PlacedTriangles, ScreenPolygon, Setup, Triangles};
use crate::project::{FixedPoint, Rect};
use crate::render::coarse_depth::CoarseDepth;
use crate::render::framebuffer::{Band, Framebuffer};
use crate::render::raster::Raster;
#[cfg(not(feature = "parallel"))]
use crate::render::sequential::*;
use crate::render::shader::Shader;
use crate::scan::{ScanConverter, SpanGroups, Spans};
use crate::vertex::Vertex;

/// Rows in a band: with 1920 columns of 4-byte colours it takes 480 KiB, which fits the second
/// cache of a processor, and small faces mostly lie in one band.
const BAND: u32 = 32;

/// Faces in a chunk: enough that handing it to a thread costs nothing.
const CHUNK: usize = 4096;

/// Vertices projected by one thread at a time.
const VERTICES: usize = 4096;

/// With a face for so many pixels or fewer, a band is likely to be drawn all over in the columns where
/// it has faces.
const CROWDED: usize = 32;

/// The memory for drawing meshes.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshScratch<const N: usize> {
    planes: Vec<ClipPlane>,
    corners: Corners,
    faces: Faces,
    chunks: Vec<Chunk<N>>,
    workers: Vec<Worker<N>>,
}

/// What is known of the vertices whatever their faces are.
#[derive(Clone, Debug, Default)]
struct Corners {
    points: Vec<FixedPoint>,
    /// If a position is not finite, one that is not inside, so that the clipper sees it.
    outcodes: Vec<Outcode>,
    /// Whether all are inside.
    inside: bool,
}

/// The memory for drawing one band.
#[derive(Clone, Debug, Default)]
struct Worker<const N: usize> {
    placed: PlacedTriangles<N>,
    triangles: Triangles<N>,
    single: Single<N>,
    coarse: CoarseDepth,
}

/// The face being drawn. The edges are those of one that is not drawn by a triangle's lines.
#[derive(Clone, Debug, Default)]
struct Single<const N: usize> {
    outline: Vec<FixedPoint>,
    edges: EdgeTable,
    polygon: ScreenPolygon<N>,
}

/// A mesh being drawn: everything that is only read from here on.
struct Job<'a, const N: usize> {
    scan: &'a ScanConverter<N>,
    setup: Setup<N>,
    level: Level,
    raster: Raster,
    vertices: &'a [Vertex<N>],
    planes: &'a [ClipPlane],
    volume: Volume<'a>,
    columns: Range<i32>,
    rows: Range<i32>,
}

impl<const N: usize> MeshScratch<N> {
    /// Draws faces into the framebuffer.
    pub(crate) fn draw<C: Copy + Send, F: AsRef<[u32]>>(
        &mut self,
        scan: &ScanConverter<N>,
        (level, raster): (Level, Raster),
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: impl IntoIterator<Item = F>,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let [columns, rows] = scan.window(frame.rect());
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        scan.collect_planes(&mut self.planes);
        let (setup, planes) = (scan.setup(), &self.planes);
        let volume = Volume::new(scan.clip_space, &scan.viewport, planes);
        let job = Job { scan, setup, level, raster, vertices, planes, volume, columns, rows };

        job.project(&mut self.corners);

        let mut faces = faces.into_iter();
        self.faces.restart();
        while self.faces.collect(&mut faces) {
            let (corners, faces) = (&self.corners, &self.faces);
            job.draw(frame, corners, faces, &mut self.chunks, &mut self.workers, shader);
        }
    }
}

impl<const N: usize> Job<'_, N> {
    /// Draws a batch of faces.
    fn draw<C: Copy + Send>(
        &self,
        frame: &mut Framebuffer<C>,
        corners: &Corners,
        faces: &Faces,
        chunks: &mut Vec<Chunk<N>>,
        workers: &mut Vec<Worker<N>>,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let bands = frame.height().div_ceil(BAND) as usize;
        let chunks = first(chunks, faces.len.div_ceil(CHUNK));
        chunks.par_iter_mut().enumerate().for_each(|(i, chunk)| {
            let part = i * CHUNK..faces.len.min((i + 1) * CHUNK);
            dispatch!(self.level, _simd => self.bin(corners, faces, part, bands, chunk));
        });

        let chunks = &*chunks;
        let parts = frame.par_bands(BAND).zip(first(workers, bands).par_iter_mut());
        parts.enumerate().for_each(|(i, (mut band, worker))| {
            let mut coarse = std::mem::take(&mut worker.coarse);
            if self.raster.restart(&mut coarse, &band) {
                band.coarse = Some(&mut coarse);
            }
            let columns =
                self.crowded(chunks.iter().map(|chunk| &chunk.bins[i]), band.rows().len());
            band.read_through(&columns);
            dispatch!(self.level, simd => for chunk in chunks {
                self.draw_bin(simd, (corners, faces), chunk, i, worker, &mut band, shader);
            });
            worker.coarse = coarse;
        });
    }

    /// The columns of a band that its faces extend over, if these are so many that reading all pixels
    /// there pays.
    fn crowded<'b>(&self, bins: impl Iterator<Item = &'b Bin>, rows: usize) -> Range<usize> {
        let (mut faces, mut left, mut right) = (0, i32::MAX, i32::MIN);
        for bin in bins {
            faces += bin.faces.len();
            (left, right) = (left.min(bin.columns.0), right.max(bin.columns.1));
        }
        if left >= right || faces.saturating_mul(CROWDED) < (left..right).len() * rows {
            return 0..0;
        }
        let corner = self.scan.viewport.rect().x;
        (left + corner) as usize..(right + corner) as usize
    }

    /// Draws a chunk's faces in a band.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "all that the threads share, and all they do not")]
    fn draw_bin<S: Simd, C: Copy>(
        &self,
        simd: S,
        (corners, faces): (&Corners, &Faces),
        chunk: &Chunk<N>,
        band_number: usize,
        worker: &mut Worker<N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let bin = &chunk.bins[band_number];
        let rows = self.rows_within(band.rows());
        // Without SIMD it would only be more code.
        let at_once = !simd.level().is_fallback();
        let in_groups = self.raster.takes_groups(simd);
        let Worker { placed, triangles, single, .. } = worker;
        let vertex = |&i: &u32| (&self.vertices[i as usize], corners.points[i as usize]);
        let mut ready = 0..0;
        for (i, &Binned { face, kind }) in bin.faces.iter().enumerate() {
            single.polygon.face = faces.first.wrapping_add(face);
            let mut triangle = None;
            match kind {
                Kind::Triangle(indices) => {
                    if ready.is_empty() {
                        ready = 0..self.place(&bin.faces[i..], corners, placed);
                        if at_once {
                            triangles.set_up(simd, &self.setup, placed, &rows);
                        }
                    }
                    let Some(number) = ready.next() else { return };
                    let is_usual = if at_once {
                        triangle = triangles.take(number, &self.setup, &mut single.polygon);
                        triangle.is_some()
                    } else {
                        single.polygon.set_up_triangle(&self.setup, placed.get(number).each_ref())
                    };
                    if !is_usual {
                        single.set_up(self, indices.iter().map(vertex), &rows);
                    } else if !in_groups {
                        let points = indices.map(|i| corners.points[i as usize]);
                        single.edges.fill_convex(&points, &rows);
                        triangle = None;
                    }
                }
                Kind::Whole => {
                    single.set_up(self, faces.get(face as usize).iter().map(vertex), &rows);
                }
                Kind::Clipped(number) => {
                    single.set_up_clipped(self, chunk.clipped(number as usize), &rows);
                }
            }
            let extent = || match triangle {
                Some(triangle) => triangle.extent(&self.columns),
                None => single.edges.extent(&self.columns, &rows),
            };
            if self.is_hidden(extent, single.polygon.z, band) {
                continue;
            }
            let (polygon, columns) = (&single.polygon, self.columns.clone());
            let groups = match triangle {
                Some(triangle) => {
                    Some(SpanGroups { polygon, runs: RunGroups::Triangle(triangle), columns })
                }
                None => {
                    let spans = Spans { polygon, runs: single.edges.runs(), columns };
                    let groups = self.raster.groups(simd, &spans);
                    if groups.is_none() {
                        self.raster.draw_rest(simd, spans, band, shader);
                    }
                    groups
                }
            };
            if let Some(groups) = groups {
                self.raster.draw_groups(simd, groups, band, shader);
            }
        }
    }

    /// Puts the next triangles side by side; how many there are.
    #[inline(always)]
    fn place(&self, faces: &[Binned], corners: &Corners, placed: &mut PlacedTriangles<N>) -> usize {
        let vertex = |i: u32| (&self.vertices[i as usize], corners.points[i as usize]);
        let mut count = 0;
        for face in faces {
            if let Kind::Triangle([a, b, c]) = face.kind {
                placed.set(count, [vertex(a), vertex(b), vertex(c)]);
                count += 1;
                if count == TRIANGLES {
                    break;
                }
            }
        }
        count
    }

    /// Whether the coarse depth hides a face of a range of depths, by its columns and rows.
    #[inline(always)]
    fn is_hidden<C>(
        &self,
        extent: impl FnOnce() -> Option<(Range<i32>, Range<i32>)>,
        z: (f32, f32),
        band: &mut Band<'_, C>,
    ) -> bool {
        let first = band.first;
        let Some(coarse) = &mut band.coarse else { return false };
        if coarse.is_idle() {
            return false;
        }
        let Some((columns, rows)) = extent() else { return false };
        let Rect { x, y, .. } = self.scan.viewport.rect();
        let place = |range: Range<i32>, corner: i32| {
            (range.start + corner) as usize..(range.end + corner) as usize
        };
        coarse.hides_polygon(band.depth, place(columns, x), place(rows, y - first), z)
    }

    /// Projects the vertices.
    fn project(&self, corners: &mut Corners) {
        let Corners { points, outcodes, inside } = corners;
        points.resize(self.vertices.len(), FixedPoint::default());
        outcodes.resize(self.vertices.len(), Outcode::default());
        let places = points.par_chunks_mut(VERTICES).zip(outcodes.par_chunks_mut(VERTICES));
        *inside = places
            .zip(self.vertices.par_chunks(VERTICES))
            .map(|((points, outcodes), vertices)| {
                dispatch!(self.level, _simd => self.project_some(points, outcodes, vertices))
            })
            .min()
            .unwrap_or(true);
    }

    /// Projects some of the vertices; whether all are inside.
    #[inline(always)]
    fn project_some(
        &self,
        points: &mut [FixedPoint],
        outcodes: &mut [Outcode],
        vertices: &[Vertex<N>],
    ) -> bool {
        let mut inside = true;
        for ((point, outcode), vertex) in points.iter_mut().zip(outcodes).zip(vertices) {
            let position = vertex.position.as_dvec4();
            *point = FixedPoint::project(position, &self.scan.viewport);
            *outcode = self.volume.outcode(position);
            inside &= outcode.is_inside();
        }
        inside
    }

    /// The rows to visit of those on the framebuffer, relative to the viewport.
    fn rows_within(&self, rows: Range<i32>) -> Range<i32> {
        let corner = self.scan.viewport.rect().y;
        self.rows.start.max(rows.start - corner)..self.rows.end.min(rows.end - corner)
    }
}

/// The first elements of a list that grows to have them and keeps what it has.
fn first<T: Default>(list: &mut Vec<T>, len: usize) -> &mut [T] {
    if list.len() < len {
        list.resize_with(len, T::default);
    }
    &mut list[..len]
}

impl<const N: usize> Single<N> {
    /// Takes any face as far as its edges and planes.
    #[inline(never)]
    fn set_up<'v>(
        &mut self,
        job: &Job<'_, N>,
        face: impl ExactSizeIterator<Item = (&'v Vertex<N>, FixedPoint)> + Clone,
        rows: &Range<i32>,
    ) {
        let affine = job.scan.is_affine(face.len(), Outcome::Inside);
        let Some((provoking, _)) = face.clone().next() else { return };
        self.outline.clear();
        self.outline.extend(face.clone().map(|(_, point)| point));
        self.edges.fill_rule = job.scan.fill_rule;
        self.edges.fill(&self.outline, rows.clone());
        let vertices = face.map(|(vertex, _)| job.setup.vertex(vertex, provoking));
        self.polygon.set_up(&job.setup, vertices, affine);
    }

    /// The same for a clipped face.
    #[inline(never)]
    fn set_up_clipped(
        &mut self,
        job: &Job<'_, N>,
        (vertices, chains, affine): (&[ClipVertex<N>], &[Chain], bool),
        rows: &Range<i32>,
    ) {
        let project = |v: &ClipVertex<N>| FixedPoint::project(v.position, &job.scan.viewport);
        self.outline.clear();
        self.outline.extend(vertices.iter().map(project));
        self.edges.fill_rule = job.scan.fill_rule;
        self.edges.fill_outline(&self.outline, chains, rows.clone());
        self.polygon.set_up(&job.setup, vertices.iter().copied(), affine);
    }
}
