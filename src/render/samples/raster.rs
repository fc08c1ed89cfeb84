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
use crate::render::samples::small::SmallTriangles;
use crate::render::shader::{
    BandDepths, MOST_SAMPLES, Patch, SampleBlock, SampleBlocks, ShadeBlocks,
};
use crate::scalar::PerTriangle;
use crate::settings::DrawCall;
use crate::subpixel::SubpixelPoint;
use crate::surface::batch::GatheredTriangles;
use crate::surface::mixed::Component;
use crate::surface::rows::{RowValues, SurfaceView, VisibleColumns};

/// Blocks that are handed over at a time.
const AT_ONCE: usize = 8;

/// Draws faces into pixels of several samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleRaster {
    pub(crate) samples: Samples,
    /// How many elements a row has for each sample.
    pub(crate) stride: usize,
    pub(crate) at_centroid: bool,
}

/// The memory that this takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleMemory {
    /// The edges of a batch of triangles, moved for each sample.
    edges: Vec<TriangleEdges<PerTriangle>>,
    small: SmallTriangles,
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
    blocks: Vec<SampleBlock>,
    /// Those of a small triangle, two rows in each.
    small: [SampleBlock; ROWS / 2],
    /// The first pixels of each row that a sample covers, a bit a pixel.
    bits: Vec<[u16; ROWS]>,
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
        memory.small.set_up(&gathered.points, self.samples.places());
        if memory.small.are_all_small() {
            return;
        }
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
        simd: S,
        (call, plan): (&DrawCall<'_>, Plan),
        (surface, coverage): (&SurfaceView<'_>, Coverage<'_>),
        band: &mut Band<'_>,
        memory: &mut SampleMemory,
        shader: &mut dyn ShadeBlocks,
    ) {
        let mut drawing = Drawing { raster: self, call, plan, surface, band, shader };
        match coverage {
            Coverage::Triangle(BatchLane { lane, .. }) => {
                let SampleMemory { small, edges, pieces, .. } = memory;
                match small.extent(lane) {
                    Some(extent) => drawing.draw_small(simd, (small, lane), extent, pieces),
                    None => drawing.draw_triangle(lane, edges, pieces),
                }
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
    /// Draws a small triangle of a batch, which has no more than half a block in any row.
    #[inline(always)]
    fn draw_small<S: Simd>(
        &mut self,
        simd: S,
        (triangles, lane): (&SmallTriangles, usize),
        (left, rows): (i32, Range<i32>),
        pieces: &mut Pieces,
    ) {
        let (window, half) = (&self.call.window, HALF_BLOCK as i32);
        let within = window.rows_within(&self.band.rows());
        let (first, end) = (rows.start.max(within.start), rows.end.min(within.end));
        // The lanes of both rows that are in the window, and how many are left of it.
        let before = (window.columns.start - left).clamp(0, half);
        let in_window = (window.columns.end - left - before).clamp(0, half - before);
        let in_window = ((1 << in_window) - 1) * (1 | 1 << HALF_BLOCK);
        if first >= end || in_window == 0 {
            return;
        }
        let mut found = triangles.rows_from(simd, lane, first);
        let samples = self.raster.samples.count();
        let mut y = first;
        while y < end {
            let mut all = RunGroup { y, ..RunGroup::EMPTY };
            all.len = (end - y).min(ROWS as i32) as usize;
            let mut count = 0;
            for row in (0..all.len).step_by(2) {
                let block = &mut pieces.small[count];
                let covered = found.next_pair(&mut block.covered[..samples]);
                // The last row may be without a second one.
                let rows = if row + 1 < all.len { ALL } else { ALL >> HALF_BLOCK };
                let mut any = covered & rows;
                for (row, bits) in [(row, any & 0xff), (row + 1, any >> HALF_BLOCK)] {
                    if bits != 0 {
                        all.start[row] = left + bits.trailing_zeros() as i32;
                        all.end[row] = left + 32 - bits.leading_zeros() as i32;
                    }
                }
                if before > 0 || covered & !(in_window & rows) != 0 {
                    any = cut(&mut block.covered[..samples], before, in_window & rows);
                }
                block.any = any;
                block.rows = [row, row + 1];
                count += usize::from(any != 0);
            }
            if count > 0 {
                self.draw_pairs(&all, left + before, count, pieces);
            }
            y += ROWS as i32;
        }
    }

    /// Draws the pairs of rows of a small triangle that were found, from a column on.
    #[inline(always)]
    fn draw_pairs(&mut self, all: &RunGroup, first: i32, count: usize, pieces: &mut Pieces) {
        let _ = self.start(all, pieces);
        let (at, (tile, place)) = self.at(all, 0, first);
        let (stride, tiles) = (self.raster.stride, self.raster.stride / LANES);
        let samples = self.raster.samples.count();
        for block in &mut pieces.small[..count] {
            for half in 0..2 {
                let row = block.rows[half];
                block.steps[half] = (first - pieces.values.x[row % ROWS]) as f32;
                block.at[half] = at.wrapping_add(row.wrapping_mul(stride));
                block.tiles[half] = (tile.wrapping_add(row.wrapping_mul(tiles)), place);
            }
            block.put_empty_half_beside();
            block.all = u32::MAX;
            for covered in &block.covered[..samples] {
                block.all &= u32::from(*covered);
            }
        }
        let Pieces { small, values, .. } = pieces;
        self.surface.find_params(values);
        self.draw_blocks(all, values, &small[..count]);
    }

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
        let Pieces { bits, groups, .. } = pieces;
        bits.resize(groups.len(), [0; ROWS]);
        // Plain loops without branches, which become SIMD.
        for (bits, group) in bits.iter_mut().zip(groups) {
            for (row, bits) in bits.iter_mut().enumerate() {
                let half = HALF_BLOCK as i32;
                let width = columns.width[row].min(half);
                let start = (group.start[row] - columns.start[row]).max(0).min(half);
                let end = (group.end[row] - columns.start[row]).max(0).min(width);
                let below = |lane: i32| (1i32 << lane) - 1;
                *bits = (below(end) & !below(start)) as u16;
            }
        }
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
        let columns = self.surface.start_rows(all, &self.call.window.columns, &mut pieces.values);
        if self.plan.is_inverse_w {
            self.surface.find_inv_w(&mut pieces.values);
        }
        columns
    }

    /// Where the first sample of a pixel is in the band, and the pixel's tile and place in this.
    #[inline(always)]
    fn at(&self, all: &RunGroup, row: usize, column: i32) -> (usize, (usize, usize)) {
        let (x, y) = self.surface.base.corner;
        let (column, row) = (self.band.column(x + column), y + all.y + row as i32);
        let row = (row - self.band.first) as usize;
        let tile = row.wrapping_mul(self.raster.stride / LANES).wrapping_add(column / LANES);
        (row.wrapping_mul(self.raster.stride).wrapping_add(column), (tile, column % LANES))
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
        let (upper, upper_tile) = self.at(all, row, columns.start[row]);
        let (lower, lower_tile) = self.at(all, row + 1, columns.start[row + 1]);
        let mut block = SampleBlock {
            rows,
            steps: [columns.steps[row], columns.steps[row + 1]],
            at: [upper, lower],
            tiles: [upper_tile, lower_tile],
            ..SampleBlock::default()
        };
        block.all = u32::MAX;
        for (covered, bits) in block.covered.iter_mut().zip(&pieces.bits) {
            *covered = bits[row] | bits[row + 1] << HALF_BLOCK;
            block.all &= u32::from(*covered);
            block.any |= u32::from(*covered);
        }
        block.put_empty_half_beside();
        self.push(all, block, pieces);
    }

    /// Draws a row by blocks that begin at whole tiles.
    #[inline(always)]
    fn draw_row(
        &mut self,
        all: &RunGroup,
        columns: &VisibleColumns,
        row: usize,
        pieces: &mut Pieces,
    ) {
        let (start, end) = (columns.start[row], columns.start[row] + columns.width[row]);
        // Where all samples are covered.
        let (mut inner, mut inner_end) = (start, end);
        for group in &pieces.groups {
            inner = inner.max(group.start[row]);
            inner_end = inner_end.min(group.end[row]);
        }
        let mut first = start - self.before(start);
        while first < end {
            let mut block = self.block(all, columns, row, first);
            let whole = if inner <= first { (inner_end - first) / LANES as i32 } else { 0 };
            if whole > 0 {
                (block.whole_tiles, block.all, block.any) = (whole as usize, ALL, ALL);
                block.covered = [u16::MAX; MOST_SAMPLES];
                self.push(all, block, pieces);
                first += whole * LANES as i32;
                continue;
            }
            block.all = ALL;
            for (covered, group) in block.covered.iter_mut().zip(&pieces.groups) {
                let run = group.start[row].max(start) - first..group.end[row].min(end) - first;
                *covered = bits(run.start, run.end);
                block.all &= u32::from(*covered);
                block.any |= u32::from(*covered);
            }
            self.push(all, block, pieces);
            first += LANES as i32;
        }
    }

    /// How many pixels a column is behind the first of its tile.
    #[inline(always)]
    fn before(&self, column: i32) -> i32 {
        let (x, _) = self.surface.base.corner;
        (self.band.column(x + column) % LANES) as i32
    }

    /// A block in one row from a column on, with nothing covered.
    #[inline(always)]
    fn block(
        &self,
        all: &RunGroup,
        columns: &VisibleColumns,
        row: usize,
        first: i32,
    ) -> SampleBlock {
        let (at, (tile, place)) = self.at(all, row, first);
        let steps = columns.steps[row] + (first - columns.start[row]) as f32;
        SampleBlock {
            rows: [row; 2],
            steps: [steps, steps + HALF_BLOCK as f32],
            at: [at, at.wrapping_add(HALF_BLOCK)],
            tiles: [(tile, place), (tile, place + HALF_BLOCK)],
            ..SampleBlock::default()
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
        self.draw_blocks(all, &pieces.values, &pieces.blocks);
        pieces.blocks.clear();
    }

    #[inline(always)]
    fn draw_blocks(&mut self, all: &RunGroup, values: &RowValues, blocks: &[SampleBlock]) {
        let patch = Patch { surface: self.surface, runs: all, values };
        let component = if self.plan.is_inverse_w { Component::InvW } else { Component::Z };
        let set = SampleBlocks {
            blocks,
            places: self.raster.samples.in_pixels(),
            change: self.surface.change(component),
            plane: self.band.rows().len() * self.raster.stride,
            comparison: self.plan.comparison,
            writes: self.plan.writes,
            is_inverse_w: self.plan.is_inverse_w,
            at_centroid: self.raster.at_centroid,
        };
        let Band { depth, pixels_before, .. } = &mut *self.band;
        let band = BandDepths { depths: depth, pixels_before: *pixels_before };
        self.shader.draw_samples(&patch, set, band);
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
        let (start, end) = (columns.start[0], columns.start[0] + columns.width[0]);
        let mut first = start - self.before(start);
        while first < end {
            let mut block = self.block(all, &columns, 0, first);
            for SampleRun { sample, run: Run { x, .. } } in runs {
                let run = x.start.max(start) - first..x.end.min(end) - first;
                block.covered[*sample % MOST_SAMPLES] |= bits(run.start, run.end);
            }
            block.all = ALL;
            for covered in &block.covered[..self.raster.samples.count()] {
                block.all &= u32::from(*covered);
                block.any |= u32::from(*covered);
            }
            block.whole_tiles = usize::from(block.all == ALL);
            self.push(all, block, pieces);
            first += LANES as i32;
        }
        self.finish(all, pieces);
    }
}

/// Leaves the lanes before some of each half out, so that others take their places, and keeps those of a mask
/// alone. Returns those that are left at any sample.
#[cold]
fn cut(samples: &mut [u16], before: i32, kept: u32) -> u32 {
    let mut any = 0;
    for covered in samples {
        let [lower, upper] = covered.to_le_bytes().map(|half| u32::from(half) >> before);
        *covered = ((lower | upper << HALF_BLOCK) & kept) as u16;
        any |= u32::from(*covered);
    }
    any
}

/// The lanes from one to before another, of those that there are.
#[inline(always)]
fn bits(start: i32, end: i32) -> u16 {
    let below = |lane: i32| (1u32 << lane.clamp(0, LANES as i32)) - 1;
    (below(end) & !below(start)) as u16
}
