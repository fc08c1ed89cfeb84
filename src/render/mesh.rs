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
//! The memory that this takes is kept. With N parameters it is 12 bytes a vertex; 4 bytes a face and
//! a corner; for each band that a face touches 12 bytes, and if it takes its vertices along 24 + 4 N
//! bytes a corner; and 32 + 8 N bytes for a vertex of a clipped face.

use std::ops::Range;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use fearless_simd::{Level, Simd, dispatch};

use crate::clip::{ClipPlane, ClipVertex, Clipper, Outcode, Outcome, Volume};
use crate::edge_table::{
    Each, EdgeTable, RunGroups, TRIANGLES, first_centre, signed_area, signed_area_of,
};
use crate::outline::Chain;
use crate::polygon::{PlacedTriangles, ScreenPolygon, Setup, Triangles};
use crate::project::{FixedPoint, Rect};
use crate::render::coarse_depth::CoarseDepth;
use crate::render::framebuffer::{Band, Framebuffer};
use crate::render::raster::Raster;
#[cfg(not(feature = "parallel"))]
use crate::render::sequential::*;
use crate::render::shader::Shader;
use crate::scan::{Cull, ScanConverter, SpanGroups, Spans};
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

/// With a face for so many pixels or fewer, a band is likely to be drawn all over.
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

/// Lists of indices, end to end.
#[derive(Clone, Debug, Default)]
struct Faces {
    /// The number of the first in the mesh.
    first: u32,
    len: usize,
    indices: Vec<u32>,
    /// Where each ends; empty if all are triangles.
    ends: Vec<u32>,
}

impl Faces {
    /// Begins with the first face of a mesh.
    fn restart(&mut self) {
        (self.first, self.len) = (0, 0);
    }

    /// Takes the next faces, as many as are drawn at a time; whether there were any.
    fn collect<F: AsRef<[u32]>>(&mut self, faces: &mut impl Iterator<Item = F>) -> bool {
        self.first = self.first.wrapping_add(self.len as u32);
        self.indices.clear();
        self.ends.clear();
        let mut len = 0;
        while len < BATCH && self.indices.len() < 4 * BATCH {
            let Some(face) = faces.next() else { break };
            match face.as_ref().as_array::<3>() {
                Some(triangle) if self.ends.is_empty() => self.indices.extend(triangle),
                _ => self.push(len, face.as_ref()),
            }
            len += 1;
        }
        self.len = len;
        len > 0
    }

    /// Takes a face where not all are triangles, after `len` others.
    fn push(&mut self, len: usize, face: &[u32]) {
        if self.ends.is_empty() {
            self.ends.extend((1..=len).map(|len| 3 * len as u32));
        }
        // A face of 2^32 corners and more is none that could be drawn.
        if u32::try_from(self.indices.len().saturating_add(face.len())).is_ok() {
            self.indices.extend_from_slice(face);
        }
        self.ends.push(self.indices.len() as u32);
    }

    /// Eight faces, if all are triangles.
    #[inline(always)]
    fn triangles(&self, faces: Range<usize>) -> Option<&[[u32; 3]; TRIANGLES]> {
        if faces.len() != TRIANGLES {
            return None;
        }
        let mut first = 3 * faces.start;
        if !self.ends.is_empty() {
            first = self.start(faces.start);
            let are_triangles = |(end, len): (&u32, usize)| *end as usize == first + 3 * len;
            if !self.ends[faces].iter().zip(1..).all(are_triangles) {
                return None;
            }
        }
        self.indices.get(first..)?.as_chunks().0.first_chunk()
    }

    fn get(&self, face: usize) -> &[u32] {
        if self.ends.is_empty() {
            return &self.indices[3 * face..3 * face + 3];
        }
        &self.indices[self.start(face)..self.ends[face] as usize]
    }

    /// Where a face begins, where not all are triangles.
    fn start(&self, face: usize) -> usize {
        face.checked_sub(1).map_or(0, |before| self.ends[before] as usize)
    }
}

/// Some neighbouring faces, sorted into bins.
#[derive(Clone, Debug, Default)]
struct Chunk<const N: usize> {
    /// For each band the faces that touch it.
    bins: Vec<Bin>,
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
struct Bin {
    faces: Vec<Binned>,
    /// The columns that they extend over.
    columns: Range<i32>,
}

/// A face in a bin.
#[derive(Clone, Copy, Debug)]
struct Binned {
    /// Its number in the batch.
    face: u32,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// A triangle of three of the mesh's vertices.
    Triangle([u32; 3]),
    /// Another face that is whole.
    Whole,
    /// The chunk's clipped face of this number.
    Clipped(u32),
}

/// A face that was clipped.
#[derive(Clone, Copy, Debug)]
struct ClippedFace {
    /// The end of its vertices in the chunk's list.
    end: u32,
    /// The end of its chains.
    chains_end: u32,
    /// Whether all its values are known to be affine on it.
    affine: bool,
}

/// The memory for drawing one band.
#[derive(Clone, Debug, Default)]
struct Worker<const N: usize> {
    placed: PlacedTriangles<N>,
    triangles: Triangles<N>,
    single: Single<N>,
    coarse: CoarseDepth,
}

/// The face being drawn; the edges are those of one that is set up alone.
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
        let (mut faces, mut columns) = (0, i32::MAX..i32::MIN);
        for bin in bins {
            faces += bin.faces.len();
            columns = columns.start.min(bin.columns.start)..columns.end.max(bin.columns.end);
        }
        if columns.is_empty() || faces.saturating_mul(CROWDED) < columns.len() * rows {
            return 0..0;
        }
        let corner = self.scan.viewport.rect().x;
        (columns.start + corner) as usize..(columns.end + corner) as usize
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

    /// Sorts a chunk of the faces into bins.
    #[inline(always)]
    fn bin(
        &self,
        corners: &Corners,
        faces: &Faces,
        part: Range<usize>,
        bands: usize,
        chunk: &mut Chunk<N>,
    ) {
        chunk.clear(bands);
        for first in part.clone().step_by(TRIANGLES) {
            let some = first..part.end.min(first + TRIANGLES);
            if !self.bin_triangles(corners, faces, some.clone(), chunk) {
                some.for_each(|face| self.bin_any(corners, faces, face, chunk));
            }
        }
    }

    /// Sorts eight triangles into bins, if that is what the faces are and all of them are inside; whether
    /// it has done so. What is found for each is found for all at once.
    #[inline(always)]
    fn bin_triangles(
        &self,
        corners: &Corners,
        faces: &Faces,
        some: Range<usize>,
        chunk: &mut Chunk<N>,
    ) -> bool {
        let first = some.start;
        let Some(triangles) = faces.triangles(some) else { return false };
        let mut points = [[FixedPoint::default(); TRIANGLES]; 3];
        for (lane, indices) in triangles.iter().enumerate() {
            for (k, &i) in indices.iter().enumerate() {
                let Some(&point) = corners.points.get(i as usize) else { return false };
                points[k][lane] = point;
            }
        }
        let is_inside = |&i: &u32| corners.outcodes[i as usize].is_inside();
        if !corners.inside && !triangles.as_flattened().iter().all(is_inside) {
            return false;
        }
        // Plain loops without branches, which become SIMD.
        let mut left_out = [false; TRIANGLES];
        if self.scan.cull != Cull::None {
            for (lane, left_out) in left_out.iter_mut().enumerate() {
                let [a, b, c] = [points[0][lane], points[1][lane], points[2][lane]];
                let [bx, by, cx, cy] = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y].map(i64::from);
                *left_out = self.scan.cull.leaves_out((bx * cy - cx * by).into());
            }
        }
        let columns = centres(&points, |p| p.x, &self.columns);
        let rows = centres(&points, |p| p.y, &self.rows);
        let mut left = 0;
        for (lane, left_out) in left_out.iter().enumerate() {
            let has_columns = columns[0][lane] < columns[1][lane];
            let is_seen = !left_out & has_columns & (rows[0][lane] < rows[1][lane]);
            left |= u32::from(is_seen) << lane;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize % TRIANGLES;
            left &= left - 1;
            let columns = columns[0][lane]..columns[1][lane];
            for bin in &mut chunk.bins[self.bands_of(rows[0][lane]..rows[1][lane])] {
                bin.push((first + lane) as u32, Kind::Triangle(triangles[lane]), &columns);
            }
        }
        true
    }

    /// Sorts any face into bins.
    #[inline(never)]
    fn bin_any(&self, corners: &Corners, faces: &Faces, face: usize, chunk: &mut Chunk<N>) {
        let indices = faces.get(face);
        // A face that has an index too far is left out.
        if indices.len() < 3 || indices.iter().any(|&i| i as usize >= corners.points.len()) {
            return;
        }
        match Outcode::outcome(indices.iter().map(|&i| corners.outcodes[i as usize])).0 {
            Outcome::Outside => return,
            Outcome::Inside => {}
            Outcome::Clipped => return self.clip(face as u32, indices, chunk),
        }
        let point = |&i: &u32| corners.points[i as usize];
        let area = || signed_area(indices, point);
        let Some((bands, columns)) = self.bands(indices, point, area) else { return };
        let kind = indices.as_array().map_or(Kind::Whole, |&triangle| Kind::Triangle(triangle));
        chunk.bins[bands].iter_mut().for_each(|bin| bin.push(face as u32, kind, &columns));
    }

    /// Clips a face and notes what is left.
    #[cold]
    fn clip(&self, face: u32, indices: &[u32], chunk: &mut Chunk<N>) {
        let Chunk { clipper, polygon, outline, clipped, chains, clipped_faces, .. } = chunk;
        polygon.clear();
        polygon.extend(indices.iter().map(|&i| self.vertices[i as usize]));
        clipper.load(&*polygon, &self.scan.interpolation);
        let outcome = clipper.clip_to_view(self.planes, &self.scan.interpolation);
        if outcome == Outcome::Outside {
            return;
        }
        let project = |v: &ClipVertex<N>| FixedPoint::project(v.position, &self.scan.viewport);
        outline.clear();
        outline.extend(clipper.vertices().iter().map(project));
        let area = || signed_area_of(outline, clipper.chains());
        let Some((bands, columns)) = self.bands(outline, |point| *point, area) else { return };
        clipped.extend_from_slice(clipper.vertices());
        chains.extend_from_slice(clipper.chains());
        let [end, chains_end] = [clipped.len(), chains.len()].map(|end| end as u32);
        let affine = self.scan.is_affine(indices.len(), outcome);
        let kind = Kind::Clipped(clipped_faces.len() as u32);
        clipped_faces.push(ClippedFace { end, chains_end, affine });
        chunk.bins[bands].iter_mut().for_each(|bin| bin.push(face, kind, &columns));
    }

    /// The rows to visit of those on the framebuffer, relative to the viewport.
    fn rows_within(&self, rows: Range<i32>) -> Range<i32> {
        let corner = self.scan.viewport.rect().y;
        self.rows.start.max(rows.start - corner)..self.rows.end.min(rows.end - corner)
    }

    /// The bands that an outline touches, and the columns that it extends over; `None` if it has no
    /// pixel, or is turned away.
    #[inline(always)]
    fn bands<V>(
        &self,
        outline: &[V],
        point: impl Fn(&V) -> FixedPoint,
        signed_area: impl FnOnce() -> i128,
    ) -> Option<(Range<usize>, Range<i32>)> {
        let cull = self.scan.cull;
        if cull != Cull::None && cull.leaves_out(signed_area()) {
            return None;
        }
        let extent = |coordinate: fn(FixedPoint) -> i32| {
            let values = outline.iter().map(|v| coordinate(point(v)));
            values.fold((i32::MAX, i32::MIN), |(min, max), v| (min.min(v), max.max(v)))
        };
        let (left, right) = extent(|p| p.x);
        let (top, bottom) = extent(|p| p.y);
        let columns =
            first_centre(left).max(self.columns.start)..first_centre(right).min(self.columns.end);
        let rows = first_centre(top).max(self.rows.start)..first_centre(bottom).min(self.rows.end);
        if columns.is_empty() || rows.is_empty() {
            return None;
        }
        Some((self.bands_of(rows), columns))
    }

    /// The bands that rows lie in.
    #[inline(always)]
    fn bands_of(&self, rows: Range<i32>) -> Range<usize> {
        let corner = self.scan.viewport.rect().y;
        let band = |row: i32| (row + corner) as usize / BAND as usize;
        band(rows.start)..band(rows.end - 1) + 1
    }
}

/// The first pixels, and those after the last, within a range, whose centres lie between the vertices
/// of triangles.
#[inline(always)]
fn centres(
    [a, b, c]: &[Each<FixedPoint>; 3],
    coordinate: impl Fn(&FixedPoint) -> i32,
    within: &Range<i32>,
) -> [Each<i32>; 2] {
    let mut range = [[0; TRIANGLES]; 2];
    for lane in 0..TRIANGLES {
        let (a, b, c) = (coordinate(&a[lane]), coordinate(&b[lane]), coordinate(&c[lane]));
        range[0][lane] = first_centre(a.min(b).min(c)).max(within.start);
        range[1][lane] = first_centre(a.max(b).max(c)).min(within.end);
    }
    range
}

/// The first elements of a list that grows to have them and keeps what it has.
fn first<T: Default>(list: &mut Vec<T>, len: usize) -> &mut [T] {
    if list.len() < len {
        list.resize_with(len, T::default);
    }
    &mut list[..len]
}

impl Bin {
    #[inline(always)]
    fn push(&mut self, face: u32, kind: Kind, columns: &Range<i32>) {
        self.faces.push(Binned { face, kind });
        let Range { start, end } = &mut self.columns;
        (*start, *end) = ((*start).min(columns.start), (*end).max(columns.end));
    }
}

impl<const N: usize> Chunk<N> {
    fn clear(&mut self, bands: usize) {
        for bin in first(&mut self.bins, bands) {
            bin.faces.clear();
            bin.columns = i32::MAX..i32::MIN;
        }
        self.clipped.clear();
        self.chains.clear();
        self.clipped_faces.clear();
    }

    /// The vertices of a clipped face, its chains, and whether all its values are affine.
    fn clipped(&self, number: usize) -> (&[ClipVertex<N>], &[Chain], bool) {
        let before = number.checked_sub(1).map(|before| self.clipped_faces[before]);
        let (start, chains_start) = before.map_or((0, 0), |face| (face.end, face.chains_end));
        let ClippedFace { end, chains_end, affine } = self.clipped_faces[number];
        let vertices = &self.clipped[start as usize..end as usize];
        (vertices, &self.chains[chains_start as usize..chains_end as usize], affine)
    }
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
