//! What there is to shade: the rows of a polygon, whole blocks in them and parts of others, and the trait by
//! which they are shaded, whatever the shader.

use std::ops::Range;

use crate::coverage::run::{ROWS, RunGroup};
use crate::fragment::block::{ALL, HALF_BLOCK, LANES};
use crate::render::depth::Comparison;
use crate::surface::rows::{RowValues, SurfaceView, VisibleColumns};

/// The rows of a polygon that are being drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch<'a> {
    pub(crate) surface: &'a SurfaceView<'a>,
    pub(crate) runs: &'a RunGroup,
    pub(crate) values: &'a RowValues,
}

/// Two halves of a block, some lanes of which may be visible.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PartBlock {
    /// The lanes that are visible, or to be tested; after shading, those that were drawn.
    pub(crate) visible: u32,
    /// The row of each half in its group.
    pub(crate) rows: [usize; 2],
    /// How far the first pixel of each half is from the one where the row's values are given.
    pub(crate) steps: [f32; 2],
    /// Where each half begins in the band.
    pub(crate) at: [usize; 2],
}

/// Parts in a list.
pub(crate) const PARTS: usize = 8;

/// Parts of blocks, by their numbers.
#[derive(Debug)]
pub(crate) enum PartBlocks<'p> {
    /// Those whose visible lanes are known.
    Visible(&'p mut [PartBlock; PARTS]),
    /// Those that are to be tested by [`Comparison::Less`], and their depths to be stored.
    Untested(&'p [PartBlock; PARTS]),
    /// The same for pairs of short runs.
    Runs(&'p ShortRuns<'p>),
}

/// The runs of a group of rows, of which some pairs fit into a block, each run into one half.
#[derive(Debug)]
pub(crate) struct ShortRuns<'c> {
    pub(crate) columns: &'c VisibleColumns,
    /// Where the viewport's first column is in the group's first row, in the band: modulo 2^64, since
    /// the viewport may begin left of the band.
    pub(crate) first: usize,
    pub(crate) row_len: usize,
}

impl ShortRuns<'_> {
    /// The block of a pair of rows.
    #[inline(always)]
    pub(crate) fn part(&self, pair: usize) -> PartBlock {
        let VisibleColumns { start, width, steps } = self.columns;
        let row = pair % (ROWS / 2) * 2;
        let rows = [row, row + 1];
        let lower = 1u32.wrapping_shl(width[row] as u32) - 1;
        let upper = 1u32.wrapping_shl(width[row + 1] as u32) - 1;
        let begin = self.first.wrapping_add(row.wrapping_mul(self.row_len));
        let mut at = [
            begin.wrapping_add(start[row] as usize),
            begin.wrapping_add(self.row_len).wrapping_add(start[row + 1] as usize),
        ];
        // A half without pixels lies beside the other.
        if lower == 0 {
            at[0] = at[1].wrapping_sub(HALF_BLOCK);
        }
        if upper == 0 {
            at[1] = at[0].wrapping_add(HALF_BLOCK);
        }
        let visible = lower | upper << HALF_BLOCK;
        PartBlock { visible, rows, steps: [steps[row], steps[row + 1]], at }
    }
}

impl PartBlocks<'_> {
    #[inline(always)]
    pub(crate) fn get(&self, number: usize) -> PartBlock {
        match self {
            Self::Visible(parts) => parts[number % PARTS],
            Self::Untested(parts) => parts[number % PARTS],
            Self::Runs(runs) => runs.part(number),
        }
    }

    #[inline(always)]
    pub(super) fn set_drawn(&mut self, number: usize, drawn: u32) {
        if let Self::Visible(parts) = self {
            parts[number % PARTS].visible = drawn;
        }
    }
}

/// Neighbouring whole blocks in a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WholeBlocks {
    pub(crate) row: usize,
    /// How far the first pixel is from the one where the row's values are given.
    pub(crate) steps: f32,
    /// The first pixel in the target.
    pub(crate) pixel: usize,
}

/// The most samples that a pixel has.
pub(crate) const MOST_SAMPLES: usize = 16;

/// A block of pixels that have several samples each. Its halves may be in two rows, and lie apart.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SampleBlock {
    /// The row of each half in its group.
    pub(crate) rows: [usize; 2],
    /// How far the first pixel of each half is from the one where the row's values are given.
    pub(crate) steps: [f32; 2],
    /// Where the first sample of each half's first pixel is in the band.
    pub(crate) at: [usize; 2],
    /// The tile that each half's first pixel is in, in the band, and the pixel's place in it.
    pub(crate) tiles: [(usize, usize); 2],
    /// The pixels of which each sample is covered, a bit a lane.
    pub(crate) covered: [u16; MOST_SAMPLES],
    /// Those of which all are, and of which any is.
    pub(crate) all: u32,
    pub(crate) any: u32,
    /// How many tiles, one after the other from this one on, are covered at all samples.
    pub(crate) whole_tiles: usize,
}

impl SampleBlock {
    /// Puts a half without covered pixels beside the other, where it is in the cache.
    #[inline(always)]
    pub(crate) fn put_empty_half_beside(&mut self) {
        if self.any & (ALL >> HALF_BLOCK) == 0 {
            self.at[0] = self.at[1].wrapping_add(HALF_BLOCK);
        }
        if self.any >> HALF_BLOCK & (ALL >> HALF_BLOCK) == 0 {
            self.at[1] = self.at[0].wrapping_add(HALF_BLOCK);
        }
    }

    /// Goes on to the next tile, if this is one.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.advance_by(1);
    }

    /// Goes on by some tiles, if this is one.
    #[inline(always)]
    pub(crate) fn advance_by(&mut self, tiles: usize) {
        for half in 0..2 {
            self.steps[half] += (tiles * LANES) as f32;
            self.at[half] = self.at[half].wrapping_add(tiles * LANES);
            self.tiles[half].0 += tiles;
        }
    }
}

/// Blocks to be tested, shaded and stored.
#[derive(Debug)]
pub(crate) struct SampleBlocks<'p> {
    pub(crate) blocks: &'p [SampleBlock],
    /// Where the samples are, in pixels to the right of a pixel's centre and below it.
    pub(crate) places: &'p [[f32; 2]],
    /// The changes per pixel, to the right and downwards, of what is compared.
    pub(crate) change: [f32; 2],
    /// How many elements each sample has in the band.
    pub(crate) plane: usize,
    pub(crate) comparison: Comparison,
    /// Whether depth is stored.
    pub(crate) writes: bool,
    /// Whether what is compared is 1/w.
    pub(crate) is_inverse_w: bool,
    /// Whether pixels are shaded at the centroid of the samples that are covered.
    pub(crate) at_centroid: bool,
}

/// The depths of a band.
#[derive(Debug)]
pub(crate) struct BandDepths<'d> {
    pub(crate) depths: &'d mut [f32],
    /// How many pixels of the target come before these.
    pub(crate) pixels_before: usize,
}

/// What shades the blocks that a raster finds visible.
pub(crate) trait ShadeBlocks {
    /// Draws whole blocks by [`Plan::COMMON`](crate::render::raster::plan::Plan::COMMON), on the given
    /// depths, as long as all lanes of each are visible or none. Returns how many pixels that are.
    ///
    /// Test, shader and store are in one loop: only so do the waits for depths overlap with the work
    /// of the shader. Apart they made a quad of two parameters take half as long again.
    fn draw_whole(&mut self, patch: &Patch<'_>, blocks: WholeBlocks, depths: &mut [f32]) -> usize;

    /// Draws the parts of blocks whose numbers have a bit in `numbers`. Returns those of parts that
    /// were to be tested and are not drawn, since they reach over the ends of the band, or over
    /// themselves.
    fn draw_parts(
        &mut self,
        patch: &Patch<'_>,
        parts: PartBlocks<'_>,
        numbers: u32,
        band: BandDepths<'_>,
    ) -> u32;

    /// Brings the colours of pixels into the cache.
    fn prefetch(&self, pixels: Range<usize>);

    /// Whether there is nothing to shade: depth alone is drawn.
    fn is_depth_only(&self) -> bool {
        false
    }

    /// Covers the pixels of some runs, as far as they are in some columns of the viewport, if it is tiles that
    /// it covers.
    fn cover(&mut self, _: &SurfaceView<'_>, _: &RunGroup, _: &Range<i32>) {}

    /// Draws blocks of pixels that have several samples each, if that is what it shades.
    fn draw_samples(&mut self, _: &Patch<'_>, _: SampleBlocks<'_>, _: BandDepths<'_>) {}
}

/// What shades on several threads.
pub(crate) trait ShadeOnThreads: ShadeBlocks + Send {
    /// Calls `f` with what shades the pixels before one, and what shades those from it on.
    fn split(
        &mut self,
        pixel: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    );
}
