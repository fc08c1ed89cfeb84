//! Some rows of a scene: the runs of the active faces, which of them are visible, and their pixels.

use std::ops::Range;

use fearless_simd::{Level, Simd};

use crate::coverage::run::RunGroup;
use crate::coverage::{EdgeTable, Run};
use crate::render::band::Band;
use crate::render::parallel::{Bands, Shading, first, for_each_band};
use crate::render::raster::plan::Plan;
use crate::render::raster::{self, RasterMemory};
use crate::render::scanline::active::{ActiveFace, ActiveFaces};
use crate::render::scanline::visible::{DepthLine, Row};
use crate::render::shader::ShadeBlocks;
use crate::settings::DrawCall;
use crate::simd::for_level;
use crate::surface::rows::RowValues;

/// The most pixels that a thread draws at a time, four rows of the widest viewport: enough that
/// handing them to a thread and finding the faces' edges there costs little, and a few megabytes of
/// colours.
const PIECE: u32 = 1 << 18;

/// The most rows, so that there is something for all threads.
const PIECE_ROWS: u32 = 32;

/// How many rows one thread draws at a time.
pub(crate) fn rows_at_once(width: u32) -> u32 {
    (PIECE / width.max(1)).clamp(1, PIECE_ROWS)
}

/// The memory for drawing rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowsMemory {
    workers: Vec<Worker>,
}

#[derive(Clone, Debug, Default)]
struct Worker {
    edges: EdgeTable,
    /// Runs with the numbers of their faces among the active ones.
    runs: Vec<(u32, Run)>,
    row: Row,
    values: RowValues,
    raster: RasterMemory,
}

/// Draws the active faces in a band, whose rows are theirs.
pub(crate) fn draw_rows(
    call: &DrawCall<'_>,
    (level, plan): (Level, Plan),
    faces: &ActiveFaces,
    band: &mut Band<'_>,
    memory: &mut RowsMemory,
    shading: Shading<'_>,
) {
    let height = rows_at_once(band.width as u32) as usize;
    let workers = first(&mut memory.workers, band.rows().len().div_ceil(height));
    let scene = Scene { call, plan, active: faces.active() };
    let bands = Bands::of(band, height);
    for_each_band(band, bands, workers, shading, &|_, band, worker, shader| {
        let rows = call.window.rows_within(&band.rows());
        scene.find_runs(worker, &rows);
        for_level!(level, simd => scene.draw(simd, worker, band, shader));
    });
}

/// Faces being drawn.
#[derive(Clone, Copy)]
struct Scene<'a> {
    call: &'a DrawCall<'a>,
    /// What is done with the fragments of opaque faces.
    plan: Plan,
    active: &'a [ActiveFace],
}

impl Scene<'_> {
    /// Finds the runs of all active faces in some rows, from top to bottom and in each row from left
    /// to right.
    fn find_runs(&self, worker: &mut Worker, rows: &Range<i32>) {
        let Worker { edges, runs, .. } = worker;
        runs.clear();
        edges.fill_rule = self.call.fill_rule;
        for (face, i) in self.active.iter().zip(0..) {
            let rows = face.rows.start.max(rows.start)..face.rows.end.min(rows.end);
            if !rows.is_empty() {
                face.fill(edges, rows);
                let visible = edges.runs().filter(|run| !self.columns(run).is_empty());
                runs.extend(visible.map(|run| (i, run)));
            }
        }
        runs.sort_unstable_by_key(|(_, run)| (run.y, run.x.start));
    }

    /// Draws the runs into a band that holds them.
    #[inline(always)]
    fn draw<S: Simd>(
        &self,
        simd: S,
        worker: &mut Worker,
        band: &mut Band<'_>,
        shader: &mut dyn ShadeBlocks,
    ) {
        let Worker { runs, row, values, raster, .. } = worker;
        for runs in runs.chunk_by(|(_, a), (_, b)| a.y == b.y) {
            self.fill_row(runs, row, values);
            for visible in row.visible_runs() {
                let (face, run) = &runs[visible.run as usize];
                let surface = self.active[*face as usize].surface.view();
                let plan = Plan { writes: !visible.transparent, ..self.plan };
                let (runs, columns) = (RunGroup::of(run), &visible.columns);
                raster::draw_runs(simd, plan, (&surface, &runs), columns, band, raster, shader);
            }
        }
    }

    /// Replaces the runs of `row` by those of one row, with the depths that their fragments have.
    #[inline(never)]
    fn fill_row(&self, runs: &[(u32, Run)], row: &mut Row, values: &mut RowValues) {
        row.clear();
        for ((face, run), i) in runs.iter().zip(0..) {
            let ActiveFace { surface, face, .. } = &self.active[*face as usize];
            let (columns, surface) = (self.columns(run), surface.view());
            surface.start_rows(&RunGroup::of(run), &columns, values);
            let (x, at, delta) = (values.x[0], values.z.at[0], values.z.delta);
            let mut depth = DepthLine { x, at, delta };
            let mut limits = surface.base.z_range;
            if self.is_reversed() {
                (depth.at, depth.delta) = (-depth.at, -depth.delta);
                limits = (-limits.1, -limits.0);
            }
            row.add((i, face.number, face.is_transparent), columns, depth, limits);
        }
    }

    /// The columns of a run that are drawn.
    fn columns(&self, run: &Run) -> Range<i32> {
        let columns = &self.call.window.columns;
        run.x.start.max(columns.start)..run.x.end.min(columns.end)
    }

    fn is_reversed(&self) -> bool {
        self.call.depth.is_reversed()
    }
}
