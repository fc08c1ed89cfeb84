//! Faces sorted into bins, by the bands of the framebuffer that they touch.

use std::ops::Range;

use prefetch_index::prefetch_index;

use crate::clip::records::Records;
use crate::coverage::area::signed_area;
use crate::outline::Chain;
use crate::primitive::{ClippedPolygon, StoredPolygon};
use crate::render::corners::ProjectedVertices;
use crate::render::faces::FaceList;
use crate::render::parallel::first;
use crate::scalar::{BATCH, PerTriangle};
use crate::settings::{Culled, DrawCall};
use crate::subpixel::{SubpixelPoint, first_centre};
use crate::vertices::Vertices;
use crate::view_volume::Outcome;

/// Rows in a band: with 1920 columns of 4-byte colours it takes 480 KiB, which fits the second
/// cache of a processor, and small faces mostly lie in one band.
pub(crate) const BAND: u32 = 32;

/// A mesh being drawn: everything that is only read from here on.
#[derive(Clone, Copy)]
pub(crate) struct MeshCall<'a> {
    pub(crate) call: &'a DrawCall<'a>,
    pub(crate) vertices: &'a dyn Vertices,
    pub(crate) corners: &'a ProjectedVertices,
    pub(crate) faces: &'a FaceList,
}

/// Some neighbouring faces, sorted into bins.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chunk {
    /// For each band the faces that touch it.
    pub(crate) bins: Vec<Bin>,
    /// The vertices of the faces that were clipped, end to end.
    clipped: Records,
    /// Their places on the screen.
    points: Vec<SubpixelPoint>,
    /// Their chains, where they fell into parts.
    chains: Vec<Chain>,
    clipped_faces: Vec<ClippedFace>,
    polygon: ClippedPolygon,
}

/// The faces of a chunk that touch a band, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bin {
    pub(crate) faces: Vec<Binned>,
    /// The columns that they extend over: the first, and the one after the last.
    pub(crate) columns: (i32, i32),
}

/// A face in a bin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binned {
    /// Its number in the list of faces.
    pub(crate) face: u32,
    pub(crate) kind: FaceKind,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum FaceKind {
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
    is_front: bool,
    is_affine: bool,
}

impl Chunk {
    /// Sorts some of the faces into bins.
    #[inline(always)]
    pub(crate) fn fill(&mut self, mesh: &MeshCall<'_>, part: Range<usize>, bands: usize) {
        self.clear(bands, mesh.call.params());
        for first in part.clone().step_by(BATCH) {
            let some = first..part.end.min(first + BATCH);
            if !self.bin_triangles(mesh, some.clone()) {
                some.for_each(|face| self.bin_any(mesh, face));
            }
        }
    }

    fn clear(&mut self, bands: usize, params: usize) {
        for bin in first(&mut self.bins, bands) {
            bin.faces.clear();
            bin.columns = (i32::MAX, i32::MIN);
        }
        self.clipped.clear(params);
        self.points.clear();
        self.chains.clear();
        self.clipped_faces.clear();
    }

    /// Sorts eight triangles into bins, if that is what the faces are and all of them are inside; whether
    /// it has done so. What is found for each is found for all at once.
    #[inline(always)]
    fn bin_triangles(&mut self, mesh: &MeshCall<'_>, some: Range<usize>) -> bool {
        let MeshCall { call, corners, faces, .. } = *mesh;
        let first = some.start;
        if call.coverage_rule.is_outer() {
            return false;
        }
        let Some(triangles) = faces.triangles(some) else { return false };
        let mut points = [[SubpixelPoint::default(); BATCH]; 3];
        for (lane, indices) in triangles.iter().enumerate() {
            for (k, &i) in indices.iter().enumerate() {
                let Some(&point) = corners.points.get(i as usize) else { return false };
                points[k][lane] = point;
            }
        }
        let is_inside = |&i: &u32| corners.outcodes[i as usize].is_inside();
        if !corners.all_inside && !triangles.as_flattened().iter().all(is_inside) {
            return false;
        }
        // Plain loops without branches, which become SIMD.
        let mut left_out = [false; BATCH];
        if call.culled != Culled::None {
            for (lane, left_out) in left_out.iter_mut().enumerate() {
                let [a, b, c] = [points[0][lane], points[1][lane], points[2][lane]];
                let [bx, by, cx, cy] = [b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y].map(i64::from);
                *left_out = call.culled.leaves_out((bx * cy - cx * by).into());
            }
        }
        let columns = centres(&points, |p| p.x, &call.window.columns);
        let rows = centres(&points, |p| p.y, &call.window.rows);
        let mut left = 0;
        for (lane, left_out) in left_out.iter().enumerate() {
            let has_columns = columns[0][lane] < columns[1][lane];
            let is_seen = !left_out & has_columns & (rows[0][lane] < rows[1][lane]);
            left |= u32::from(is_seen) << lane;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize % BATCH;
            left &= left - 1;
            let columns = columns[0][lane]..columns[1][lane];
            for bin in &mut self.bins[bands_of(call, &(rows[0][lane]..rows[1][lane]))] {
                bin.push((first + lane) as u32, FaceKind::Triangle(triangles[lane]), &columns);
            }
        }
        true
    }

    /// Sorts any face into bins.
    #[inline(never)]
    fn bin_any(&mut self, mesh: &MeshCall<'_>, face: usize) {
        let MeshCall { call, corners, faces, .. } = *mesh;
        let indices = faces.get(face);
        match corners.outcome(indices) {
            Outcome::Outside => return,
            Outcome::Inside if !faces.has_contours() => {}
            _ => return self.clip(mesh, face),
        }
        let point = |&i: &u32| corners.points[i as usize];
        if call.culled != Culled::None && call.culled.leaves_out(signed_area(indices, point)) {
            return;
        }
        let extent = call.window.extent(corners.points_of(indices));
        let Some((columns, rows)) = extent else { return };
        let kind = match *indices {
            [a, b, c] => FaceKind::Triangle([a, b, c]),
            _ => FaceKind::Whole,
        };
        let bins = &mut self.bins[bands_of(call, &rows)];
        bins.iter_mut().for_each(|bin| bin.push(face as u32, kind, &columns));
    }

    /// Clips a face and notes what is left.
    #[cold]
    fn clip(&mut self, mesh: &MeshCall<'_>, face: usize) {
        let MeshCall { call, vertices, faces, .. } = *mesh;
        let Self { polygon, clipped, points, chains, clipped_faces, bins, .. } = self;
        let contours = faces.contours(face);
        if !polygon.clip(call, contours.map(|c| c.iter().filter_map(|&i| vertices.get(i)))) {
            return;
        }
        let extent = call.window.extent(polygon.points().iter().copied());
        let Some((columns, rows)) = extent else { return };
        clipped.extend_from(polygon.vertices());
        points.extend_from_slice(polygon.points());
        chains.extend_from_slice(polygon.chains());
        let [end, chains_end] = [clipped.len(), chains.len()].map(|end| end as u32);
        let kind = FaceKind::Clipped(clipped_faces.len() as u32);
        let ClippedPolygon { is_front, is_affine, .. } = *polygon;
        clipped_faces.push(ClippedFace { end, chains_end, is_front, is_affine });
        let bins = &mut bins[bands_of(call, &rows)];
        bins.iter_mut().for_each(|bin| bin.push(face as u32, kind, &columns));
    }

    /// Asks for the vertices of one of the faces that were clipped.
    #[inline(always)]
    pub(crate) fn prefetch_clipped(&self, number: usize) {
        let vertices = self.clipped_vertices(number).0;
        prefetch_index(&self.points, vertices.start);
        self.clipped.prefetch(vertices);
    }

    /// The vertices and the chains of one of the faces that were clipped, in the chunk's lists.
    #[inline(always)]
    fn clipped_vertices(&self, number: usize) -> (Range<usize>, Range<usize>) {
        let before = number.checked_sub(1).map(|before| self.clipped_faces[before]);
        let (start, chains_start) = before.map_or((0, 0), |face| (face.end, face.chains_end));
        let ClippedFace { end, chains_end, .. } = self.clipped_faces[number];
        (start as usize..end as usize, chains_start as usize..chains_end as usize)
    }

    /// One of the faces that were clipped.
    pub(crate) fn clipped(&self, number: usize) -> StoredPolygon<'_> {
        let (range, chains) = self.clipped_vertices(number);
        let ClippedFace { is_front, is_affine, .. } = self.clipped_faces[number];
        StoredPolygon {
            vertices: self.clipped.some(range.clone()),
            points: &self.points[range],
            chains: &self.chains[chains],
            is_front,
            is_affine,
        }
    }
}

/// The bands of the framebuffer that rows lie in.
#[inline(always)]
pub(crate) fn bands_of(call: &DrawCall<'_>, rows: &Range<i32>) -> Range<usize> {
    let band = |row: i32| call.window.row_on_frame(row) / BAND as usize;
    band(rows.start)..band(rows.end - 1) + 1
}

impl Bin {
    #[inline(always)]
    fn push(&mut self, face: u32, kind: FaceKind, columns: &Range<i32>) {
        self.faces.push(Binned { face, kind });
        let (start, end) = self.columns;
        self.columns = (start.min(columns.start), end.max(columns.end));
    }
}

/// The first pixels, and those after the last, within a range, whose centres lie between the vertices
/// of triangles.
#[inline(always)]
fn centres(
    [a, b, c]: &[PerTriangle<SubpixelPoint>; 3],
    coordinate: impl Fn(&SubpixelPoint) -> i32,
    within: &Range<i32>,
) -> [PerTriangle<i32>; 2] {
    let mut range = [[0; BATCH]; 2];
    for lane in 0..BATCH {
        let (a, b, c) = (coordinate(&a[lane]), coordinate(&b[lane]), coordinate(&c[lane]));
        range[0][lane] = first_centre(a.min(b).min(c)).max(within.start);
        range[1][lane] = first_centre(a.max(b).max(c)).min(within.end);
    }
    range
}
