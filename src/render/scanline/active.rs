//! The faces of a scene: sorted by first row, active while they have pixels in the rows being drawn.

use std::ops::Range;

use fearless_simd::Level;

use crate::coverage::EdgeTable;
use crate::outline::Chain;
use crate::primitive::ClippedPolygon;
use crate::render::corners::ProjectedVertices;
use crate::render::faces::FaceList;
use crate::render::geometry::Batch;
use crate::render::parallel::{first, for_each_part};
use crate::settings::DrawCall;
use crate::subpixel::SubpixelPoint;
use crate::surface::polygon::PolygonSurface;
use crate::vertices::Vertices;
use crate::view_volume::Outcome;

/// Faces set up by one thread at a time.
const PART: usize = if cfg!(test) { 4 } else { 256 };

/// The faces of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct ActiveFaces {
    /// The indices of the faces in `pending`, in their order.
    indices: FaceList,
    /// The faces that may have pixels, by first row.
    pending: Vec<PendingFace>,
    /// The first of them that has not been active yet.
    next: usize,
    active: Vec<ActiveFace>,
    /// Faces that are not active any more, for their memory.
    pool: Vec<ActiveFace>,
    clippers: Vec<ClippedPolygon>,
}

/// A face that is not active yet.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PendingFace {
    first_row: i32,
    /// Its number in the mesh.
    pub(crate) number: u32,
    /// Its number among the indices.
    face: u32,
    pub(crate) is_transparent: bool,
}

/// A face that has pixels in the rows being drawn.
#[derive(Clone, Debug, Default)]
pub(crate) struct ActiveFace {
    pub(crate) rows: Range<i32>,
    pub(crate) face: PendingFace,
    pub(crate) surface: PolygonSurface,
    points: Vec<SubpixelPoint>,
    chains: Vec<Chain>,
}

impl ActiveFaces {
    /// Begins with the faces of a scene, sorted by the first row that each may have pixels in.
    pub(crate) fn begin(
        &mut self,
        call: &DrawCall<'_>,
        level: Level,
        batch: &Batch<'_>,
        corners: &mut ProjectedVertices,
    ) {
        let Self { indices, pending, next, active, pool, clippers } = self;
        pool.append(active);
        pending.clear();
        *next = 0;
        if call.window.is_empty() {
            return;
        }
        corners.project(call, level, batch.vertices);
        let clipper = &mut first(clippers, 1)[0];
        let faces = batch.faces;
        for face in 0..faces.len() {
            let extent = match corners.outcome(faces.get(face)) {
                Outcome::Outside => None,
                Outcome::Inside if !faces.has_contours() => {
                    call.window.extent(corners.points_of(faces.get(face)))
                }
                _ => clip(clipper, call, (batch.vertices, faces), face)
                    .then(|| call.window.extent(clipper.points().iter().copied()))
                    .flatten(),
            };
            let Some((_, rows)) = extent else { continue };
            let (face, number) = (face as u32, faces.number(face as u32));
            let is_transparent = batch.transparent.is_some_and(|is| is(number));
            pending.push(PendingFace { first_row: rows.start, number, face, is_transparent });
        }
        pending.sort_unstable_by_key(|face| (face.first_row, face.number));
        // Only the faces that may be seen are kept, and of their indices a copy.
        if faces.has_contours() {
            indices.clone_from(faces);
        } else {
            indices.take_in_order(faces, pending.iter().map(|face| face.face));
            (0..).zip(pending).for_each(|(place, face)| face.face = place);
        }
    }

    /// Makes those faces active that have pixels in the given rows, and no others.
    pub(crate) fn advance(
        &mut self,
        call: &DrawCall<'_>,
        vertices: &dyn Vertices,
        rows: &Range<i32>,
    ) {
        let Self { indices, pending, next, active, pool, clippers } = self;
        let mut i = 0;
        while i < active.len() {
            if active[i].rows.end <= rows.start {
                pool.push(active.swap_remove(i));
            } else {
                i += 1;
            }
        }
        let entering = active.len();
        while let Some(&face) = pending.get(*next).filter(|face| face.first_row < rows.end) {
            *next += 1;
            active.push(ActiveFace { face, ..pool.pop().unwrap_or_default() });
        }
        let entering = &mut active[entering..];
        let parts = entering.len().div_ceil(PART);
        // One clipper for each part of the faces.
        for_each_part((entering, PART), (first(clippers, parts), 1), |_, faces, clippers| {
            let Some(clipper) = clippers.first_mut() else { return };
            for face in faces {
                face.set_up(call, clipper, (vertices, indices));
            }
        });
    }

    pub(crate) fn active(&self) -> &[ActiveFace] {
        &self.active
    }
}

/// Clips a face; whether there may be something to see.
fn clip(
    clipper: &mut ClippedPolygon,
    call: &DrawCall<'_>,
    (vertices, faces): (&dyn Vertices, &FaceList),
    face: usize,
) -> bool {
    let contours = faces.contours(face);
    clipper.clip(call, contours.map(|c| c.iter().filter_map(|&i| vertices.get(i))))
}

impl ActiveFace {
    /// Sets the face up and finds its rows; none if there is nothing to see.
    fn set_up(
        &mut self,
        call: &DrawCall<'_>,
        clipper: &mut ClippedPolygon,
        geometry: (&dyn Vertices, &FaceList),
    ) {
        self.rows = 0..0;
        if !clip(clipper, call, geometry, self.face.face as usize) {
            return;
        }
        let extent = call.window.extent(clipper.points().iter().copied());
        let Some((_, rows)) = extent else { return };
        self.rows = rows;
        self.points.clear();
        self.points.extend_from_slice(clipper.points());
        self.chains.clear();
        self.chains.extend_from_slice(clipper.chains());
        clipper.fit(call, self.face.number, &mut self.surface);
    }

    /// Fills an edge table with the face's edges in some rows.
    pub(crate) fn fill(&self, edges: &mut EdgeTable, rows: Range<i32>) {
        edges.fill_chains(&self.points, &self.chains, rows);
    }
}
