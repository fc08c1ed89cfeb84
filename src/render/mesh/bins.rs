//! Faces sorted into bins, by the bands of the framebuffer that they touch.

use std::ops::Range;

use super::faces::Faces;
use super::{BAND, Corners, Job, first};
use crate::clip::{ClipVertex, Clipper, Outcode, Outcome};
use crate::edge_table::{first_centre, signed_area, signed_area_of};
use crate::number::{Each, TRIANGLES};
use crate::outline::Chain;
use crate::project::FixedPoint;
use crate::scan::Cull;
use crate::vertex::Vertex;

/// Some neighbouring faces, sorted into bins.
#[derive(Clone, Debug, Default)]
pub(super) struct Chunk<const N: usize> {
    /// For each band the faces that touch it.
    pub(super) bins: Vec<Bin>,
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
pub(super) struct Bin {
    pub(super) faces: Vec<Binned>,
    /// The columns that they extend over: the first, and the one after the last.
    pub(super) columns: (i32, i32),
}

/// A face in a bin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binned {
    /// Its number in the batch.
    pub(super) face: u32,
    pub(super) kind: Kind,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
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

impl<const N: usize> Job<'_, N> {
    /// Sorts a chunk of the faces into bins.
    #[inline(always)]
    pub(super) fn bin(
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
        let kind = match *indices {
            [a, b, c] => Kind::Triangle([a, b, c]),
            _ => Kind::Whole,
        };
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

impl Bin {
    #[inline(always)]
    fn push(&mut self, face: u32, kind: Kind, columns: &Range<i32>) {
        self.faces.push(Binned { face, kind });
        let (start, end) = self.columns;
        self.columns = (start.min(columns.start), end.max(columns.end));
    }
}

impl<const N: usize> Chunk<N> {
    fn clear(&mut self, bands: usize) {
        for bin in first(&mut self.bins, bands) {
            bin.faces.clear();
            bin.columns = (i32::MAX, i32::MIN);
        }
        self.clipped.clear();
        self.chains.clear();
        self.clipped_faces.clear();
    }

    /// The vertices of a clipped face, its chains, and whether all its values are affine.
    pub(super) fn clipped(&self, number: usize) -> (&[ClipVertex<N>], &[Chain], bool) {
        let before = number.checked_sub(1).map(|before| self.clipped_faces[before]);
        let (start, chains_start) = before.map_or((0, 0), |face| (face.end, face.chains_end));
        let ClippedFace { end, chains_end, affine } = self.clipped_faces[number];
        let vertices = &self.clipped[start as usize..end as usize];
        (vertices, &self.chains[chains_start as usize..chains_end as usize], affine)
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
