//! A polygon's runs, row by row: short ones two rows at a time, long ones in whole blocks.
//!
//! All of a loop must be inlined into a function for the instructions that `simd` stands for, or it is
//! not compiled for them.

use std::ops::Range;

use fearless_simd::Simd;

use crate::coverage::run::{ROWS, RunGroup};
use crate::coverage::shape::Coverage;
use crate::fragment::block::{ALL, HALF_BLOCK, LANES, SpanLine};
use crate::render::band::Band;
use crate::render::coarse_depth::{FEW_TILES, HiddenTiles, TILE_WIDTH};
use crate::render::counters::Counters;
use crate::render::raster::plan::{ForAny, ForCommon, Plan, PlanFor};
use crate::render::raster::test::{Parts, RowsRaster};
use crate::render::shader::{PartBlock, ShadeBlocks, ShortRuns};
use crate::surface::rows::{RowValues, SurfaceView, VisibleColumns};

/// The memory for drawing polygons.
#[derive(Clone, Debug, Default)]
pub(crate) struct RasterMemory {
    values: RowValues,
    parts: Parts,
}

/// Draws what a polygon covers, in some columns, into a band that holds all of its rows.
#[inline(always)]
pub(crate) fn draw<S: Simd>(
    simd: S,
    plan: Plan,
    (surface, coverage): (&SurfaceView<'_>, Coverage<'_>),
    columns: &Range<i32>,
    band: &mut Band<'_>,
    memory: &mut RasterMemory,
    shader: &mut dyn ShadeBlocks,
) {
    let needs_edges = surface.needs_edges();
    // One closure, called at one place: only then is it inlined into the function for the level.
    coverage.for_each_group(
        needs_edges,
        #[inline(always)]
        |runs| {
            if needs_edges {
                // Each run has changes per pixel of its own.
                for row in 0..runs.len {
                    let run = RunGroup::of(&runs.run(row));
                    draw_runs(simd, plan, (surface, &run), columns, band, memory, shader);
                }
            } else if plan == Plan::COMMON {
                let polygon = (surface, runs);
                draw_group::<ForCommon, S>(simd, plan, polygon, columns, band, memory, shader);
            } else {
                draw_runs(simd, plan, (surface, runs), columns, band, memory, shader);
            }
        },
    );
}

/// Draws a group of runs, in some columns, with any plan; one run alone where some values have no
/// plane.
#[inline(never)]
pub(crate) fn draw_runs<S: Simd>(
    simd: S,
    plan: Plan,
    polygon: (&SurfaceView<'_>, &RunGroup),
    columns: &Range<i32>,
    band: &mut Band<'_>,
    memory: &mut RasterMemory,
    shader: &mut dyn ShadeBlocks,
) {
    simd.vectorize(
        #[inline(always)]
        || draw_group::<ForAny, S>(simd, plan, polygon, columns, band, memory, shader),
    );
}

#[inline(always)]
fn draw_group<P: PlanFor, S: Simd>(
    simd: S,
    plan: Plan,
    (surface, runs): (&SurfaceView<'_>, &RunGroup),
    columns: &Range<i32>,
    band: &mut Band<'_>,
    memory: &mut RasterMemory,
    shader: &mut dyn ShadeBlocks,
) {
    let RasterMemory { values, parts } = memory;
    let columns = surface.start_rows(runs, columns, values);
    if P::of(plan).is_inverse_w {
        surface.find_inv_w(values);
    }
    let columns = &columns;
    // Those that were left when a shader panicked.
    parts.clear();
    let mut raster = RowsRaster { simd, plan, surface, runs, band, shader, values, columns, parts };
    if P::of(plan).has_extras && raster.band.extras.counters.is_some_and(Counters::is_done) {
        return;
    }
    raster.draw_rows::<P>();
    raster.finish_parts::<P>();
    if P::of(plan).has_extras {
        raster.count();
    }
}

impl<S: Simd> RowsRaster<'_, '_, S> {
    /// Draws the rows of a group. Short runs are drawn by blocks that have a half in each of two rows: a
    /// small triangle has few pixels in a row.
    #[inline(always)]
    fn draw_rows<P: PlanFor>(&mut self) {
        let (mut short, mut long) = (0, 0);
        for (pair, [upper, lower]) in self.columns.width.as_chunks().0.iter().enumerate() {
            let widest = *upper.max(lower);
            short |= u32::from(0 < widest && widest <= HALF_BLOCK as i32) << pair;
            long |= u32::from(widest > HALF_BLOCK as i32) << pair;
        }
        if short != 0 {
            let (x, y) = self.surface.base.corner;
            let first = self.band.index(x, y + self.runs.y);
            let runs = ShortRuns { columns: self.columns, first, row_len: self.band.width };
            self.draw_short_runs::<P>(&runs, short);
        }
        if long == 0 {
            return;
        }
        let hidden = self.hidden_tiles::<P>();
        while long != 0 {
            let row = long.trailing_zeros() as usize * 2;
            long &= long - 1;
            self.draw_long_row::<P>(row, hidden);
            self.draw_long_row::<P>(row + 1, hidden);
        }
    }

    /// Which tiles of the coarse depth are hidden in all of the rows, if one of the runs is so long that it
    /// pays to know.
    #[inline(always)]
    fn hidden_tiles<P: PlanFor>(&mut self) -> Option<HiddenTiles> {
        let widest = self.columns.width.iter().fold(0, |widest, width| widest.max(*width));
        let is_wide = widest as usize > FEW_TILES * TILE_WIDTH;
        if !is_wide || self.band.coarse.is_none() {
            return None;
        }
        self.finish_for_bounds::<P>();
        self.find_hidden_tiles()
    }

    /// Draws what is left before bounds are found from depths: no bound must be found from those that are
    /// stored and that a shader may yet discard.
    #[inline(always)]
    fn finish_for_bounds<P: PlanFor>(&mut self) {
        if P::of(self.plan) != Plan::COMMON {
            self.finish_parts::<P>();
        }
    }

    #[inline(never)]
    fn find_hidden_tiles(&mut self) -> Option<HiddenTiles> {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let VisibleColumns { start, width, steps } = *self.columns;
                let (corner_x, corner_y) = self.surface.base.corner;
                let first = start.map(|start| self.band.column(corner_x + start) as i32);
                let row = (corner_y + self.runs.y - self.band.first) as usize;
                let (mut left, mut right, mut bottom) = (usize::MAX, 0, 0);
                for i in (0..ROWS).filter(|i| width[*i] > 0) {
                    left = left.min(first[i] as usize);
                    right = right.max((first[i] + width[i]) as usize);
                    bottom = row + i + 1;
                }
                let (z, (min, max)) = (self.values.z, self.surface.base.z_range);
                let depths = |columns: [usize; LANES]| {
                    let (mut least, mut most) = ([max; LANES], [min; LANES]);
                    for row in (0..ROWS).filter(|row| width[*row] > 0) {
                        let (delta, at) = (z.delta, z.at[row]);
                        for (lane, column) in columns.iter().enumerate() {
                            // The same bits as in a block.
                            let steps = steps[row] + (*column as i32 - first[row]) as f32;
                            let depth = steps * delta + at;
                            least[lane] = if depth < least[lane] { depth } else { least[lane] };
                            most[lane] = if depth > most[lane] { depth } else { most[lane] };
                        }
                    }
                    // Kept within the range as in a block, which keeps their order.
                    (least.map(|depth| depth.max(min)), most.map(|depth| depth.min(max)))
                };
                let coarse = self.band.coarse.as_mut()?;
                coarse.hidden_tiles(self.band.depth, &(left..right), &(row..bottom), depths)
            },
        )
    }

    /// Draws a long run, if it is very long without the columns that the coarse depth hides.
    #[inline(never)]
    fn draw_long_row<P: PlanFor>(&mut self, row: usize, hidden: Option<HiddenTiles>) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || self.draw_visible_columns::<P>(row % ROWS, hidden),
        );
    }

    #[inline(always)]
    fn draw_visible_columns<P: PlanFor>(&mut self, row: usize, hidden: Option<HiddenTiles>) {
        let width = self.columns.width[row] as usize;
        if width == 0 {
            return;
        }
        let (corner_x, corner_y) = self.surface.base.corner;
        let first = self.band.column(corner_x + self.columns.start[row]);
        let band_row = (corner_y + self.runs.y + row as i32 - self.band.first) as usize;
        let end = first + width;
        let mut visible = first..end;
        let (line, steps) = (SpanLine::of(&self.values.z, row), self.columns.steps[row]);
        let (min, max) = self.surface.base.z_range;
        // The same bits as in a block. They grow or fall along the run, since rounding keeps the order of
        // products and of sums. All that it needs is in it, so that it need not be read again each time.
        let depth = move |column: usize| {
            let steps = steps + (column as i32 - first as i32) as f32;
            (steps * line.delta + line.at).max(min).min(max)
        };
        self.finish_for_bounds::<P>();
        loop {
            let rest = visible.start..end;
            if let Some(hidden) = hidden {
                visible = hidden.next_visible(rest);
            } else if end - first > TILE_WIDTH
                && let Some(coarse) = &mut self.band.coarse
            {
                visible = coarse.next_visible(self.band.depth, band_row, rest, depth);
            }
            if !visible.is_empty() {
                self.draw_columns::<P>(row, band_row * self.band.width, first, &visible);
            }
            if visible.end == end {
                return;
            }
            visible = visible.end..end;
        }
    }

    /// Draws some columns of a run, counted from the left of the band as its `first` is: a first block
    /// that may have lanes before them, then whole ones, then what is left. `row_start` is where the row
    /// begins in the band.
    #[inline(always)]
    fn draw_columns<P: PlanFor>(
        &mut self,
        row: usize,
        row_start: usize,
        first: usize,
        columns: &Range<usize>,
    ) {
        let (start, end) = (row_start + columns.start, row_start + columns.end);
        let before = (start + self.band.line_offset) % LANES;
        let mut at = start.wrapping_sub(before);
        let mut steps =
            self.columns.steps[row] + ((columns.start - first) as i32 - before as i32) as f32;
        let mut lanes = ALL << before & ALL;
        loop {
            let left = end.wrapping_sub(at);
            if left < LANES {
                lanes &= ALL >> (LANES - left);
            }
            let part = PartBlock {
                visible: lanes,
                rows: [row; 2],
                steps: [steps, steps + HALF_BLOCK as f32],
                at: [at, at.wrapping_add(HALF_BLOCK)],
            };
            self.draw_part::<P>(part);
            if left <= LANES {
                return;
            }
            at = at.wrapping_add(LANES);
            steps += LANES as f32;
            let done = self.draw_whole::<P>(row, steps, at..end);
            (at, steps) = (at + done, steps + done as f32);
            if at == end {
                return;
            }
            // What is left is the end, or a block that is seen in part.
            lanes = ALL;
        }
    }
}
