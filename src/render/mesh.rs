//! Meshes: many faces drawn at once, on all processors.
//!
//! 1. Each vertex is projected once, and its outcode taken.
//! 2. The faces are taken in chunks. Those that are outside, turned away or without a pixel are
//!    dropped, those that cross a plane are clipped, and each of the rest is put into the bins of
//!    the bands of [`BAND`] rows that it touches. A small face takes its vertices along: they are in
//!    the cache now, and would have to be fetched from all over the memory later.
//! 3. The framebuffer is cut into bands. Each band's faces are set up and scan-converted by one
//!    thread, in the order in which they were given, so the picture does not depend on the number
//!    of threads. No face is looked at by a band that it does not touch.
//!
//! The memory that this takes is kept. With N parameters it is 24 bytes a vertex; 4 bytes a face and
//! a corner; for each band that a face touches 4 bytes, and if the face is small 32 + 4 N bytes a
//! corner, rounded up to 16; and 40 + 8 N bytes for a vertex of a clipped face.

use std::ops::Range;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use fearless_simd::{Level, Simd, dispatch};

use crate::clip::{ClipPlane, ClipVertex, Clipper, Outcode, Outcome};
use crate::edge_table::{EdgeTable, first_centre, signed_area, signed_area_of};
use crate::outline::Chain;
use crate::polygon::ScreenPolygon;
use crate::project::{FixedPoint, Projected};
use crate::render::framebuffer::{Band, Framebuffer};
#[cfg(not(feature = "parallel"))]
use crate::render::sequential::*;
use crate::render::shader::Shader;
use crate::render::z_buffer::Raster;
use crate::scan::{Cull, ScanConverter, Spans};
use crate::vertex::Vertex;

/// Rows in a band: with 1920 columns of 4-byte colours it takes 480 KiB, which fits the second
/// cache of a processor, and small faces mostly lie in one band.
const BAND: u32 = 32;

/// Faces in a chunk: enough that handing it to a thread costs nothing.
const CHUNK: usize = 4096;

/// Vertices projected by one thread at a time.
const VERTICES: usize = 4096;

/// Faces drawn at a time: enough to share among processors, and a bound for the memory.
const BATCH: usize = 1 << 20;

/// A face with more corners than this, or in more bands, is not copied to bins.
const SMALL: usize = 4;

/// The memory for drawing meshes.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshScratch<const N: usize> {
    planes: Vec<ClipPlane>,
    corners: Vec<Corner>,
    faces: Faces,
    chunks: Vec<Chunk<N>>,
    workers: Vec<Worker<N>>,
}

/// What is known of a vertex whatever its faces are.
#[derive(Clone, Copy, Debug)]
struct Corner {
    projected: Projected,
    /// `None` if the position is not finite.
    outcode: Option<Outcode>,
}

/// Lists of indices, end to end.
#[derive(Clone, Debug, Default)]
struct Faces {
    indices: Vec<u32>,
    ends: Vec<u32>,
}

impl Faces {
    /// Takes the next faces, as many as are drawn at a time; whether there were any.
    fn collect<F: AsRef<[u32]>>(&mut self, faces: &mut impl Iterator<Item = F>) -> bool {
        self.indices.clear();
        self.ends.clear();
        while self.ends.len() < BATCH && self.indices.len() < BATCH * SMALL {
            let Some(face) = faces.next() else { break };
            // A face of 2^32 corners and more is none that could be drawn.
            let end = self.indices.len().saturating_add(face.as_ref().len());
            let Ok(end) = u32::try_from(end) else { continue };
            self.indices.extend_from_slice(face.as_ref());
            self.ends.push(end);
        }
        !self.ends.is_empty()
    }

    #[inline(always)]
    fn get(&self, face: usize) -> &[u32] {
        let start = if face == 0 { 0 } else { self.ends[face - 1] };
        &self.indices[start as usize..self.ends[face] as usize]
    }
}

/// Some neighbouring faces, sorted into bins.
#[derive(Clone, Debug, Default)]
struct Chunk<const N: usize> {
    /// For each band the faces that touch it.
    bins: Vec<Bin<N>>,
    /// The vertices of the faces that were clipped, end to end.
    clipped: Vec<ClipVertex<N>>,
    /// Their chains, where they fell into parts.
    chains: Vec<Chain>,
    clipped_faces: Vec<ClippedFace>,
    clipper: Clipper<N>,
    polygon: Vec<Vertex<N>>,
    outline: Vec<FixedPoint>,
}

/// The faces of a chunk that touch a band, in order.
#[derive(Clone, Debug, Default)]
struct Bin<const N: usize> {
    faces: Vec<Binned>,
    /// The vertices of the small faces, end to end.
    vertices: Vec<(Vertex<N>, Projected)>,
}

/// A face in a bin: the kind, and a number of 30 bits.
#[derive(Clone, Copy, Debug)]
struct Binned(u32);

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// So many of the bin's vertices.
    Copied(usize),
    /// The mesh's face of this number.
    Whole(usize),
    /// The chunk's clipped face of this number.
    Clipped(usize),
}

impl Binned {
    const NUMBER: u32 = (1 << 30) - 1;

    fn copied(corners: usize) -> Self {
        Self(corners as u32)
    }
    fn whole(face: usize) -> Self {
        Self(1 << 30 | face as u32 & Self::NUMBER)
    }
    fn clipped(number: usize) -> Self {
        Self(2 << 30 | number as u32 & Self::NUMBER)
    }
    #[inline(always)]
    fn kind(self) -> Kind {
        let number = (self.0 & Self::NUMBER) as usize;
        match self.0 >> 30 {
            0 => Kind::Copied(number),
            1 => Kind::Whole(number),
            _ => Kind::Clipped(number),
        }
    }
}

/// A face that was clipped.
#[derive(Clone, Copy, Debug)]
struct ClippedFace {
    /// The end of its vertices in the chunk's list.
    end: u32,
    /// The end of its chains.
    chains_end: u32,
    /// Whether all its values are affine.
    flat: bool,
}

/// The memory for drawing one band.
#[derive(Clone, Debug, Default)]
struct Worker<const N: usize> {
    polygon: ScreenPolygon<N>,
    edges: EdgeTable,
}

/// A mesh being drawn: everything that is only read from here on.
struct Job<'a, const N: usize> {
    scan: &'a ScanConverter<N>,
    level: Level,
    raster: Raster,
    vertices: &'a [Vertex<N>],
    planes: &'a [ClipPlane],
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
        let job = Job { scan, level, raster, vertices, planes: &self.planes, columns, rows };

        let none = Corner { projected: Projected::default(), outcode: None };
        self.corners.resize(vertices.len(), none);
        self.corners
            .par_chunks_mut(VERTICES)
            .zip(vertices.par_chunks(VERTICES))
            .for_each(|(corners, vertices)| job.project(corners, vertices));

        let mut faces = faces.into_iter();
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
        corners: &[Corner],
        faces: &Faces,
        chunks: &mut Vec<Chunk<N>>,
        workers: &mut Vec<Worker<N>>,
        shader: &(impl Shader<N, C> + Sync),
    ) {
        let bands = frame.height().div_ceil(BAND) as usize;
        let chunks = first(chunks, faces.ends.len().div_ceil(CHUNK));
        chunks.par_iter_mut().enumerate().for_each(|(i, chunk)| {
            let part = i * CHUNK..faces.ends.len().min((i + 1) * CHUNK);
            self.bin(corners, faces, part, bands, chunk);
        });

        let chunks = &*chunks;
        let parts = frame.par_bands(BAND).zip(first(workers, bands).par_iter_mut());
        parts.enumerate().for_each(|(i, (mut band, worker))| {
            dispatch!(self.level, simd => for chunk in chunks {
                self.draw_bin(simd, (corners, faces), chunk, i, worker, &mut band, shader);
            });
        });
    }

    /// Draws a chunk's faces in a band.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "all that the threads share, and all they do not")]
    fn draw_bin<S: Simd, C: Copy>(
        &self,
        simd: S,
        (corners, faces): (&[Corner], &Faces),
        chunk: &Chunk<N>,
        band_number: usize,
        worker: &mut Worker<N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let bin = &chunk.bins[band_number];
        let rows = self.rows_within(band.rows());
        let mut copied = bin.vertices.as_slice();
        for face in &bin.faces {
            let (flat, chains) = match face.kind() {
                Kind::Copied(sides) => {
                    let (vertices, rest) = copied.split_at(sides);
                    copied = rest;
                    (worker.project_copied(self, vertices), [].as_slice())
                }
                Kind::Whole(face) => {
                    let corner =
                        |&i: &u32| (&self.vertices[i as usize], corners[i as usize].projected);
                    (worker.project(self, faces.get(face).iter().map(corner)), [].as_slice())
                }
                Kind::Clipped(number) => {
                    let (vertices, chains, flat) = chunk.clipped(number);
                    worker.project_clipped(self, vertices);
                    (flat, chains)
                }
            };
            self.raster.draw(simd, worker.spans(self, flat, chains, &rows), band, shader);
        }
    }

    /// Projects vertices.
    fn project(&self, corners: &mut [Corner], vertices: &[Vertex<N>]) {
        for (corner, vertex) in corners.iter_mut().zip(vertices) {
            let position = vertex.position.as_dvec4();
            *corner = Corner {
                projected: Projected::new(position, &self.scan.viewport),
                outcode: position.is_finite().then(|| Outcode::new(position, self.planes)),
            };
        }
    }

    /// Sorts a chunk of the faces into bins.
    fn bin(
        &self,
        all_corners: &[Corner],
        faces: &Faces,
        part: Range<usize>,
        bands: usize,
        chunk: &mut Chunk<N>,
    ) {
        chunk.clear(bands);
        for face in part {
            let indices = faces.get(face);
            // A face that has a vertex too far or a position that is not finite has no outcome.
            let known = indices.iter().all(|&i| {
                all_corners.get(i as usize).is_some_and(|corner| corner.outcode.is_some())
            });
            if !known || indices.len() < 3 {
                continue;
            }
            let corners = indices.iter().map(|&i| &all_corners[i as usize]);
            match Outcode::outcome(corners.clone().filter_map(|corner| corner.outcode)).0 {
                Outcome::Outside => {}
                Outcome::Inside => {
                    let outline = corners.map(|corner| corner.projected.point);
                    let Some(bands) = self.bands(outline.clone(), || signed_area(outline)) else {
                        continue;
                    };
                    if indices.len() > SMALL || bands.len() > SMALL {
                        chunk.bins[bands]
                            .iter_mut()
                            .for_each(|bin| bin.faces.push(Binned::whole(face)));
                        continue;
                    }
                    for bin in &mut chunk.bins[bands] {
                        bin.faces.push(Binned::copied(indices.len()));
                        bin.vertices.extend(indices.iter().map(|&i| {
                            (self.vertices[i as usize], all_corners[i as usize].projected)
                        }));
                    }
                }
                Outcome::Clipped => self.clip(indices, chunk),
            }
        }
    }

    /// Clips a face and notes what is left.
    #[cold]
    fn clip(&self, indices: &[u32], chunk: &mut Chunk<N>) {
        let Chunk { clipper, polygon, outline, clipped, chains, clipped_faces, .. } = chunk;
        polygon.clear();
        polygon.extend(indices.iter().map(|&i| self.vertices[i as usize]));
        clipper.load(&*polygon, &self.scan.interpolation);
        let outcome = clipper.clip_to_view(self.planes, &self.scan.interpolation);
        if outcome == Outcome::Outside {
            return;
        }
        let project = |v: &ClipVertex<N>| Projected::new(v.position, &self.scan.viewport).point;
        outline.clear();
        outline.extend(clipper.vertices().iter().map(project));
        let area = || signed_area_of(outline, clipper.chains());
        let Some(bands) = self.bands(outline.iter().copied(), area) else { return };
        clipped.extend_from_slice(clipper.vertices());
        let flat = self.scan.is_flat(indices.len(), outcome);
        chains.extend_from_slice(clipper.chains());
        let [end, chains_end] = [clipped.len(), chains.len()].map(|end| end as u32);
        clipped_faces.push(ClippedFace { end, chains_end, flat });
        let number = clipped_faces.len() - 1;
        chunk.bins[bands].iter_mut().for_each(|bin| bin.faces.push(Binned::clipped(number)));
    }

    /// The rows to visit of those on the framebuffer, relative to the viewport.
    fn rows_within(&self, rows: Range<i32>) -> Range<i32> {
        let corner = self.scan.viewport.rect().y;
        self.rows.start.max(rows.start - corner)..self.rows.end.min(rows.end - corner)
    }

    /// The bands that an outline touches; `None` if it has no pixel in any, or is turned away.
    #[inline(always)]
    fn bands(
        &self,
        outline: impl Iterator<Item = FixedPoint> + Clone,
        signed_area: impl FnOnce() -> i128,
    ) -> Option<Range<usize>> {
        let extent = |values: &mut dyn Iterator<Item = i32>| {
            values.fold((i32::MAX, i32::MIN), |(min, max), v| (min.min(v), max.max(v)))
        };
        let (left, right) = extent(&mut outline.clone().map(|p| p.x));
        let (top, bottom) = extent(&mut outline.map(|p| p.y));
        let columns =
            first_centre(left).max(self.columns.start)..first_centre(right).min(self.columns.end);
        let rows = first_centre(top).max(self.rows.start)..first_centre(bottom).min(self.rows.end);
        if columns.is_empty()
            || rows.is_empty()
            || self.scan.cull != Cull::None && self.scan.cull.leaves_out(signed_area())
        {
            return None;
        }
        let corner = self.scan.viewport.rect().y;
        let band = |row: i32| (row + corner) as usize / BAND as usize;
        Some(band(rows.start)..band(rows.end - 1) + 1)
    }
}

/// The first elements of a list that grows to have them and keeps what it has.
fn first<T: Default>(list: &mut Vec<T>, len: usize) -> &mut [T] {
    if list.len() < len {
        list.resize_with(len, T::default);
    }
    &mut list[..len]
}

impl<const N: usize> Chunk<N> {
    fn clear(&mut self, bands: usize) {
        for bin in first(&mut self.bins, bands) {
            bin.faces.clear();
            bin.vertices.clear();
        }
        self.clipped.clear();
        self.chains.clear();
        self.clipped_faces.clear();
    }

    /// The vertices of a clipped face, its chains, and whether all its values are affine.
    fn clipped(&self, number: usize) -> (&[ClipVertex<N>], &[Chain], bool) {
        let before = number.checked_sub(1).map(|before| self.clipped_faces[before]);
        let (start, chains_start) = before.map_or((0, 0), |face| (face.end, face.chains_end));
        let ClippedFace { end, chains_end, flat } = self.clipped_faces[number];
        let vertices = &self.clipped[start as usize..end as usize];
        (vertices, &self.chains[chains_start as usize..chains_end as usize], flat)
    }
}

impl<const N: usize> Worker<N> {
    /// Projects a face from a bin; the same as [`project`](Self::project). Loops over triangles and
    /// quads are much faster when the compiler knows that they are.
    #[inline(always)]
    fn project_copied(&mut self, job: &Job<'_, N>, vertices: &[(Vertex<N>, Projected)]) -> bool {
        match vertices {
            [a, b, c] => self.project(job, [a, b, c].into_iter().map(|(v, p)| (v, *p))),
            [a, b, c, d] => self.project(job, [a, b, c, d].into_iter().map(|(v, p)| (v, *p))),
            _ => self.project(job, vertices.iter().map(|(v, p)| (v, *p))),
        }
    }

    /// Projects a face; whether all its values are known to be affine.
    #[inline(always)]
    fn project<'v>(
        &mut self,
        job: &Job<'_, N>,
        face: impl ExactSizeIterator<Item = (&'v Vertex<N>, Projected)> + Clone,
    ) -> bool {
        let Job { scan, .. } = job;
        let sides = face.len();
        let first = face.clone().next().map(|(vertex, _)| vertex);
        let vertices = face.map(|(vertex, projected)| {
            let provoking = first.unwrap_or(vertex);
            (ClipVertex::from(vertex).flattened(provoking, &scan.interpolation), projected)
        });
        self.polygon.project(vertices, &scan.viewport, scan.clip_space, &scan.interpolation);
        scan.is_flat(sides, Outcome::Inside)
    }

    /// Projects a clipped face.
    #[cold]
    fn project_clipped(&mut self, job: &Job<'_, N>, vertices: &[ClipVertex<N>]) {
        let Job { scan, .. } = job;
        let project = |v: &ClipVertex<N>| (*v, Projected::new(v.position, &scan.viewport));
        let vertices = vertices.iter().map(project);
        self.polygon.project(vertices, &scan.viewport, scan.clip_space, &scan.interpolation);
    }

    /// The spans of the projected face in some rows.
    #[inline(always)]
    fn spans(
        &mut self,
        job: &Job<'_, N>,
        flat: bool,
        chains: &[Chain],
        rows: &Range<i32>,
    ) -> Spans<'_, N> {
        self.edges.fill_rule = job.scan.fill_rule;
        self.edges.fill_outline(self.polygon.outline(), chains, rows.clone());
        if !self.edges.is_empty() {
            self.polygon.fit_planes(flat);
        }
        Spans { polygon: &self.polygon, runs: self.edges.runs(), columns: job.columns.clone() }
    }
}
