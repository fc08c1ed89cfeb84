//! What a polygon covers of each sample, in blocks.
//!
//! A triangle's edges are found once for each sample, eight triangles at a time, and its runs eight rows at
//! a time. Any other outline is moved and filled for each sample; its runs are joined where they overlap.
//! In either case values are given along the run that all samples have together, so that they depend on
//! the polygon and the row alone.

use std::ops::Range;

use fearless_simd::Simd;

use crate::coverage::EdgeTable;
use crate::coverage::run::{ROWS, Run, RunGroup};
use crate::coverage::shape::Coverage;
use crate::coverage::triangle::{BatchLane, TriangleEdges};
use crate::fragment::block::{ALL, HALF_BLOCK, LANES};
use crate::outline::Chain;
use crate::render::band::Band;
use crate::render::mesh::FaceRaster;
use crate::render::raster::plan::Plan;
use crate::render::samples::pattern::Samples;
use crate::render::shader::{
    BandDepths, MOST_SAMPLES, Patch, SampleBlock, SampleBlocks, ShadeBlocks,
};
use crate::scalar::PerTriangle;
use crate::settings::DrawCall;
use crate::subpixel::{SUBPIXELS, SubpixelPoint};
use crate::surface::batch::GatheredTriangles;
use crate::surface::mixed::Component;
use crate::surface::rows::{RowLine, RowValues, SurfaceView, VisibleColumns};

/// Blocks that are handed over at a time.
const AT_ONCE: usize = 8;

/// Draws faces into pixels of several samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleRaster {
    pub(crate) samples: Samples,
    /// How many elements are between two samples of a pixel.
    pub(crate) stride: usize,
    pub(crate) at_centroid: bool,
}

/// The memory that this takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleMemory {
    /// The edges of a batch of triangles, moved for each sample.
    edges: Vec<TriangleEdges<PerTriangle>>,
    /// The outline of a face that is not of a batch.
    points: Vec<SubpixelPoint>,
    chains: Vec<Chain>,
    moved: Vec<SubpixelPoint>,
    table: EdgeTable,
    runs: Vec<SampleRun>,
    pieces: Pieces,
}

/// A run of one sample.
#[derive(Clone, Debug)]
struct SampleRun {
    sample: usize,
    run: Run,
}

/// Blocks that are to be drawn, with the values along their rows.
#[derive(Clone, Debug, Default)]
struct Pieces {
    groups: Vec<RunGroup>,
    values: RowValues,
    depths: Vec<RowLine>,
    places: Vec<[f32; 2]>,
    blocks: Vec<SampleBlock>,
}

impl FaceRaster for SampleRaster {
    type Memory = SampleMemory;
    const HAS_COARSE_DEPTH: bool = false;

    #[inline(always)]
    fn take_batch<S: Simd>(
        &self,
        simd: S,
        gathered: &GatheredTriangles,
        rows: &Range<i32>,
        memory: &mut SampleMemory,
    ) {
        memory.edges.resize(self.samples.count(), TriangleEdges::default());
        for (edges, place) in memory.edges.iter_mut().zip(self.samples.places()) {
            *edges = gathered.edges_at(simd, rows, place.map(f64::from));
        }
    }

    fn take_outline(&self, points: &[SubpixelPoint], chains: &[Chain], memory: &mut SampleMemory) {
        memory.points.clear();
        memory.points.extend_from_slice(points);
        memory.chains.clear();
        memory.chains.extend_from_slice(chains);
    }

    #[inline(always)]
    fn draw<S: Simd>(
        &self,
        _: S,
        (call, plan): (&DrawCall<'_>, Plan),
        (surface, coverage): (&SurfaceView<'_>, Coverage<'_>),
        band: &mut Band<'_>,
        memory: &mut SampleMemory,
        shader: &mut dyn ShadeBlocks,
    ) {
        let mut drawing = Drawing { raster: self, call, plan, surface, band, shader };
        match coverage {
            Coverage::Triangle(BatchLane { lane, .. }) => {
                drawing.draw_triangle(lane, &memory.edges, &mut memory.pieces);
            }
            _ => drawing.draw_outline(memory),
        }
    }
}

/// A polygon being drawn.
struct Drawing<'d, 'b> {
    raster: &'d SampleRaster,
    call: &'d DrawCall<'d>,
    plan: Plan,
    surface: &'d SurfaceView<'d>,
    band: &'d mut Band<'b>,
    shader: &'d mut dyn ShadeBlocks,
}

impl Drawing<'_, '_> {
    /// Draws one triangle of a batch.
    #[inline(always)]
    fn draw_triangle(
        &mut self,
        lane: usize,
        edges: &[TriangleEdges<PerTriangle>],
        pieces: &mut Pieces,
    ) {
        pieces.groups.resize(edges.len(), RunGroup::EMPTY);
        let (mut first, mut end) = (i32::MAX, i32::MIN);
        for edges in edges {
            let rows = BatchLane { edges, lane }.rows();
            if !rows.is_empty() {
                (first, end) = (first.min(rows.start), end.max(rows.end));
            }
        }
        let mut y = first;
        while y < end {
            let mut all = RunGroup::EMPTY;
            (all.start, all.end) = ([i32::MAX; ROWS], [i32::MIN; ROWS]);
            (all.y, all.len) = (y, (end - y).min(ROWS as i32) as usize);
            for (edges, group) in edges.iter().zip(&mut pieces.groups) {
                BatchLane { edges, lane }.group_at(y, group);
                for row in 0..ROWS {
                    let is_empty = group.start[row] >= group.end[row];
                    let (start, end) = (group.start[row], group.end[row]);
                    let wide = if is_empty { (i32::MAX, i32::MIN) } else { (start, end) };
                    all.start[row] = all.start[row].min(wide.0);
                    all.end[row] = all.end[row].max(wide.1);
                }
            }
            for (start, end) in all.start.iter_mut().zip(&mut all.end) {
                if *start > *end {
                    (*start, *end) = (0, 0);
                }
            }
            self.draw_group(&all, pieces);
            y += ROWS as i32;
        }
    }

    /// Draws a group of rows, in each of which each sample has one run.
    #[inline(always)]
    fn draw_group(&mut self, all: &RunGroup, pieces: &mut Pieces) {
        let columns = self.start(all, pieces);
        let mut row = 0;
        while row < all.len {
            let widths = [columns.width[row], columns.width[row + 1]];
            if widths[0].max(widths[1]) <= HALF_BLOCK as i32 {
                if widths != [0, 0] {
                    self.draw_pair(all, &columns, row, pieces);
                }
            } else {
                for row in [row, row + 1] {
                    self.draw_row(all, &columns, row, pieces);
                }
            }
            row += 2;
        }
        self.finish(all, pieces);
    }

    /// Begins with the rows of a group.
    #[inline(always)]
    fn start(&self, all: &RunGroup, pieces: &mut Pieces) -> VisibleColumns {
        let Pieces { values, depths, places, .. } = pieces;
        let columns = self.surface.start_rows(all, &self.call.window.columns, values);
        let is_inverse_w = self.plan.is_inverse_w;
        if is_inverse_w {
            self.surface.find_inv_w(values);
        }
        let component = if is_inverse_w { Component::InvW } else { Component::Z };
        depths.clear();
        places.clear();
        for place in self.raster.samples.places() {
            let [x, y] = place.map(|c| f64::from(c) / f64::from(SUBPIXELS));
            depths.push(self.surface.line_at(values, component, [x, y]));
            places.push([x as f32, y as f32]);
        }
        columns
    }

    /// Where the first sample of a pixel is in the band.
    #[inline(always)]
    fn at(&self, all: &RunGroup, row: usize, column: i32) -> usize {
        let (x, y) = self.surface.base.corner;
        self.band.index(x + column, y + all.y + row as i32)
    }

    /// Draws two short rows, each by half a block.
    #[inline(always)]
    fn draw_pair(
        &mut self,
        all: &RunGroup,
        columns: &VisibleColumns,
        row: usize,
        pieces: &mut Pieces,
    ) {
        let rows = [row, row + 1];
        let mut block = SampleBlock {
            rows,
            steps: rows.map(|row| columns.steps[row]),
            at: rows.map(|row| self.at(all, row, columns.start[row])),
            covered: [0; MOST_SAMPLES],
        };
        for (half, row) in rows.into_iter().enumerate() {
            let (start, width) = (columns.start[row], columns.width[row]);
            // A half without pixels may lie anywhere: beside the other it is in the cache.
            if width == 0 {
                block.at[half] = block.at[1 - half].wrapping_add(HALF_BLOCK);
            }
            for (covered, group) in block.covered.iter_mut().zip(&pieces.groups) {
                let bits = bits(group.start[row] - start, (group.end[row] - start).min(width));
                *covered |= (bits & (ALL >> HALF_BLOCK)) << (half * HALF_BLOCK);
            }
        }
        self.push(all, block, pieces);
    }

    /// Draws a row by whole blocks.
    #[inline(always)]
    fn draw_row(
        &mut self,
        all: &RunGroup,
        columns: &VisibleColumns,
        row: usize,
        pieces: &mut Pieces,
    ) {
        let (start, width) = (columns.start[row], columns.width[row]);
        for done in (0..width).step_by(LANES) {
            let mut block = self.block(all, columns, row, done);
            let left = width - done;
            for (covered, group) in block.covered.iter_mut().zip(&pieces.groups) {
                let first = start + done;
                *covered = bits(group.start[row] - first, (group.end[row] - first).min(left));
            }
            self.push(all, block, pieces);
        }
    }

    /// A block in one row that begins some columns behind the first, with nothing covered.
    #[inline(always)]
    fn block(
        &self,
        all: &RunGroup,
        columns: &VisibleColumns,
        row: usize,
        done: i32,
    ) -> SampleBlock {
        let at = self.at(all, row, columns.start[row] + done);
        let steps = columns.steps[row] + done as f32;
        SampleBlock {
            rows: [row; 2],
            steps: [steps, steps + HALF_BLOCK as f32],
            at: [at, at.wrapping_add(HALF_BLOCK)],
            covered: [0; MOST_SAMPLES],
        }
    }

    #[inline(always)]
    fn push(&mut self, all: &RunGroup, block: SampleBlock, pieces: &mut Pieces) {
        pieces.blocks.push(block);
        if pieces.blocks.len() == AT_ONCE {
            self.finish(all, pieces);
        }
    }

    /// Hands the blocks over that are left.
    #[inline(always)]
    fn finish(&mut self, all: &RunGroup, pieces: &mut Pieces) {
        if pieces.blocks.is_empty() {
            return;
        }
        self.surface.find_params(&mut pieces.values);
        let patch = Patch { surface: self.surface, runs: all, values: &pieces.values };
        let set = SampleBlocks {
            blocks: &pieces.blocks,
            depths: &pieces.depths,
            places: &pieces.places,
            stride: self.raster.stride,
            comparison: self.plan.comparison,
            writes: self.plan.writes,
            is_inverse_w: self.plan.is_inverse_w,
            at_centroid: self.raster.at_centroid,
        };
        let Band { depth, pixels_before, .. } = &mut *self.band;
        let band = BandDepths { depths: depth, pixels_before: *pixels_before };
        self.shader.draw_samples(&patch, set, band);
        pieces.blocks.clear();
    }

    /// Draws a face by its outline.
    #[inline(never)]
    fn draw_outline(&mut self, memory: &mut SampleMemory) {
        let SampleMemory { points, chains, moved, table, runs, pieces, .. } = memory;
        let rows = self.call.window.rows_within(&self.band.rows());
        table.fill_rule = self.call.fill_rule;
        runs.clear();
        for (sample, [x, y]) in self.raster.samples.places().iter().enumerate() {
            moved.clear();
            moved.extend(points.iter().map(|p| SubpixelPoint { x: p.x - x, y: p.y - y }));
            table.fill_chains(moved, chains, rows.clone());
            runs.extend(table.runs().map(|run| SampleRun { sample, run }));
        }
        runs.sort_unstable_by_key(|SampleRun { run, sample }| (run.y, run.x.start, *sample));
        let mut rest = &runs[..];
        while let Some(first) = rest.first() {
            // Those that overlap.
            let (mut end, mut count) = (first.run.x.end, 0);
            while let Some(next) = rest.get(count).map(|next| &next.run)
                && next.y == first.run.y
                && (next.x.start < end || count == 0)
            {
                end = end.max(next.x.end);
                count += 1;
            }
            let (together, others) = rest.split_at(count);
            rest = others;
            let run = Run { x: first.run.x.start..end, ..first.run.clone() };
            self.draw_together(&RunGroup::of(&run), together, pieces);
        }
    }

    /// Draws runs that overlap in a row.
    fn draw_together(&mut self, all: &RunGroup, runs: &[SampleRun], pieces: &mut Pieces) {
        let columns = self.start(all, pieces);
        let (start, width) = (columns.start[0], columns.width[0]);
        for done in (0..width).step_by(LANES) {
            let mut block = self.block(all, &columns, 0, done);
            for SampleRun { sample, run: Run { x, .. } } in runs {
                let first = start + done;
                let end = (x.end - first).min(width - done);
                block.covered[*sample % MOST_SAMPLES] |= bits(x.start - first, end);
            }
            self.push(all, block, pieces);
        }
        self.finish(all, pieces);
    }
}

/// The lanes from one to before another, of those that there are.
#[inline(always)]
fn bits(start: i32, end: i32) -> u32 {
    let below = |lane: i32| (1u32 << lane.clamp(0, LANES as i32)) - 1;
    below(end) & !below(start)
}
