//! Meshes: many faces drawn at once, on all processors.
//!
//! 1. Each vertex is projected once, and its outcode taken.
//! 2. The faces are taken in chunks. Those that are outside, turned away or without a pixel are
//!    dropped, those that cross a plane are clipped, and each of the rest is noted in the bins of
//!    the bands of [`BAND`] rows that it touches.
//! 3. The framebuffer is cut into bands. Each band's faces are set up and scan-converted by one
//!    thread, in the order in which they were given, so the picture does not depend on the number
//!    of threads. No face is looked at by a band that it does not touch.
//!
//! The memory that this takes is kept: 24 bytes a vertex, 4 bytes a corner and 4 bytes a face, 4
//! bytes for each band that a face touches, and the vertices of faces that were clipped.

use std::ops::Range;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use fearless_simd::{Level, dispatch};

use crate::clip::{ClipPlane, ClipVertex, Clipper, Outcode, Outcome};
use crate::edge_table::{EdgeTable, first_centre, signed_area};
use crate::polygon::ScreenPolygon;
use crate::project::{FixedPoint, Projected};
use crate::render::framebuffer::Framebuffer;
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

/// Set in a bin for a clipped face, whose number is then that among the chunk's clipped faces.
const CLIPPED: u32 = 1 << 31;

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
    fn collect<F: AsRef<[u32]>>(&mut self, faces: impl IntoIterator<Item = F>) {
        self.indices.clear();
        self.ends.clear();
        for face in faces {
            self.indices.extend_from_slice(face.as_ref());
            self.ends.push(self.indices.len() as u32);
        }
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
    /// For each band the faces that touch it, in order.
    bins: Vec<Vec<u32>>,
    /// The vertices of the faces that were clipped, end to end.
    clipped: Vec<ClipVertex<N>>,
    clipped_faces: Vec<ClippedFace>,
    clipper: Clipper<N>,
    polygon: Vec<Vertex<N>>,
    outline: Vec<FixedPoint>,
}

/// A face that was clipped.
#[derive(Clone, Copy, Debug)]
struct ClippedFace {
    /// The end of its vertices in the chunk's list.
    end: u32,
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
        self.faces.collect(faces);
        scan.collect_planes(&mut self.planes);
        let job = Job { scan, level, raster, vertices, planes: &self.planes, columns, rows };

        let none = Corner { projected: Projected::default(), outcode: None };
        self.corners.resize(vertices.len(), none);
        self.corners
            .par_chunks_mut(VERTICES)
            .zip(vertices.par_chunks(VERTICES))
            .for_each(|(corners, vertices)| job.project(corners, vertices));

        let bands = frame.height().div_ceil(BAND) as usize;
        let faces = self.faces.ends.len();
        self.chunks.resize_with(faces.div_ceil(CHUNK), Chunk::default);
        let (corners, faces) = (&self.corners, &self.faces);
        self.chunks.par_iter_mut().enumerate().for_each(|(i, chunk)| {
            let part = i * CHUNK..faces.ends.len().min((i + 1) * CHUNK);
            job.bin(corners, faces, part, bands, chunk);
        });

        self.workers.resize_with(bands, Worker::default);
        let chunks = &self.chunks;
        let parts = frame.par_bands(BAND).zip(self.workers.par_iter_mut());
        parts.enumerate().for_each(|(i, (mut band, worker))| {
            dispatch!(job.level, simd => for chunk in chunks {
                for &face in &chunk.bins[i] {
                    let spans = worker.spans(&job, corners, faces, chunk, face, band.rows());
                    job.raster.draw(simd, spans, &mut band, shader);
                }
            });
        });
    }
}

impl<const N: usize> Job<'_, N> {
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
        corners: &[Corner],
        faces: &Faces,
        part: Range<usize>,
        bands: usize,
        chunk: &mut Chunk<N>,
    ) {
        chunk.clear(bands);
        for face in part {
            let indices = faces.get(face);
            // A face that has a vertex too far or a position that is not finite has no outcome.
            let known = indices
                .iter()
                .all(|&i| corners.get(i as usize).is_some_and(|corner| corner.outcode.is_some()));
            if !known || indices.len() < 3 {
                continue;
            }
            let corners = indices.iter().map(|&i| &corners[i as usize]);
            match Outcode::outcome(corners.clone().filter_map(|corner| corner.outcode)).0 {
                Outcome::Outside => {}
                Outcome::Inside => {
                    let outline = corners.map(|corner| corner.projected.point);
                    if let Some(bands) = self.bands(outline) {
                        chunk.note(face as u32, bands);
                    }
                }
                Outcome::Clipped => self.clip(indices, chunk),
            }
        }
    }

    /// Clips a face and notes what is left.
    #[cold]
    fn clip(&self, indices: &[u32], chunk: &mut Chunk<N>) {
        let Chunk { clipper, polygon, outline, clipped, clipped_faces, .. } = chunk;
        polygon.clear();
        polygon.extend(indices.iter().map(|&i| self.vertices[i as usize]));
        clipper.load(polygon, &self.scan.interpolation);
        let outcome = clipper.clip_vertices(self.planes, &self.scan.interpolation);
        if outcome == Outcome::Outside {
            return;
        }
        let project = |v: &ClipVertex<N>| Projected::new(v.position, &self.scan.viewport).point;
        outline.clear();
        outline.extend(clipper.vertices().iter().map(project));
        let Some(bands) = self.bands(outline.iter().copied()) else { return };
        clipped.extend_from_slice(clipper.vertices());
        let flat = self.scan.is_flat(indices.len(), outcome);
        clipped_faces.push(ClippedFace { end: clipped.len() as u32, flat });
        let number = clipped_faces.len() as u32 - 1;
        chunk.note(number | CLIPPED, bands);
    }

    /// The bands that an outline touches; `None` if it has no pixel in any.
    #[inline(always)]
    fn bands(&self, outline: impl Iterator<Item = FixedPoint> + Clone) -> Option<Range<usize>> {
        let extent = |values: &mut dyn Iterator<Item = i32>| {
            values.fold((i32::MAX, i32::MIN), |(min, max), v| (min.min(v), max.max(v)))
        };
        let (left, right) = extent(&mut outline.clone().map(|p| p.x));
        let (top, bottom) = extent(&mut outline.clone().map(|p| p.y));
        let columns =
            first_centre(left).max(self.columns.start)..first_centre(right).min(self.columns.end);
        let rows = first_centre(top).max(self.rows.start)..first_centre(bottom).min(self.rows.end);
        if columns.is_empty()
            || rows.is_empty()
            || self.scan.cull != Cull::None && self.scan.cull.leaves_out(signed_area(outline))
        {
            return None;
        }
        let corner = self.scan.viewport.rect().y;
        let band = |row: i32| (row + corner) as usize / BAND as usize;
        Some(band(rows.start)..band(rows.end - 1) + 1)
    }
}

impl<const N: usize> Chunk<N> {
    fn clear(&mut self, bands: usize) {
        self.bins.resize_with(bands, Vec::new);
        self.bins.iter_mut().for_each(Vec::clear);
        self.clipped.clear();
        self.clipped_faces.clear();
    }

    fn note(&mut self, face: u32, bands: Range<usize>) {
        for bin in &mut self.bins[bands] {
            bin.push(face);
        }
    }

    /// The vertices of a clipped face, and whether all its values are affine.
    fn clipped(&self, number: usize) -> (&[ClipVertex<N>], bool) {
        let start = if number == 0 { 0 } else { self.clipped_faces[number - 1].end };
        let ClippedFace { end, flat } = self.clipped_faces[number];
        (&self.clipped[start as usize..end as usize], flat)
    }
}

impl<const N: usize> Worker<N> {
    /// The spans of a face in some rows of the framebuffer.
    #[inline(always)]
    fn spans(
        &mut self,
        job: &Job<'_, N>,
        corners: &[Corner],
        faces: &Faces,
        chunk: &Chunk<N>,
        face: u32,
        rows: Range<i32>,
    ) -> Spans<'_, N> {
        let scan = job.scan;
        let (viewport, interpolation) = (&scan.viewport, &scan.interpolation);
        let flat = if face & CLIPPED != 0 {
            let (vertices, flat) = chunk.clipped((face & !CLIPPED) as usize);
            let project = |v: &ClipVertex<N>| (*v, Projected::new(v.position, viewport));
            let vertices = vertices.iter().map(project);
            self.polygon.project(vertices, viewport, scan.clip_space, interpolation);
            flat
        } else {
            let indices = faces.get(face as usize);
            let provoking = &job.vertices[indices[0] as usize];
            let vertices = indices.iter().map(|&i| {
                let vertex = ClipVertex::from(&job.vertices[i as usize]);
                (vertex.flattened(provoking, interpolation), corners[i as usize].projected)
            });
            self.polygon.project(vertices, viewport, scan.clip_space, interpolation);
            scan.is_flat(indices.len(), Outcome::Inside)
        };
        let corner = viewport.rect().y;
        let rows = job.rows.start.max(rows.start - corner)..job.rows.end.min(rows.end - corner);
        self.edges.fill(self.polygon.outline(), rows);
        if !self.edges.is_empty() {
            self.polygon.fit_planes(flat);
        }
        Spans { polygon: &self.polygon, runs: self.edges.runs(), columns: job.columns.clone() }
    }
}
