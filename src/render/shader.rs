//! From visible blocks to colours: the loops around a shader.
//!
//! This is all of a renderer that knows the shader's type, the colours' type and the number of
//! parameters, so it is all that is compiled with a user's program, once for each SIMD level. Everything
//! before it is compiled once, in the library. The two meet at [`ShadeBlocks`], behind `dyn`: a call for
//! the blocks of some rows, not for each, so that its cost is small beside the pixels'.

use std::marker::PhantomData;

use fearless_simd::{
    Select, Simd, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x8, mask32x16,
};

use crate::coverage::run::{ROWS, RunGroup};
use crate::fragment::block::{ALL, Block, HALF_BLOCK, LANES, OneRow, SpanLine, TwoRows};
use crate::fragment::{Fragment, FragmentBlock};
use crate::render::depth::Comparison;
use crate::render::paint::Paint;
use crate::surface::base::Divide;
use crate::surface::rows::{RowValues, SurfaceView, VisibleColumns};
use crate::viewport::MAX_SIZE;

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
    fn set_drawn(&mut self, number: usize, drawn: u32) {
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
    /// Goes on to the next tile, if this is one.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        for half in 0..2 {
            self.steps[half] += LANES as f32;
            self.at[half] = self.at[half].wrapping_add(LANES);
            self.tiles[half].0 += 1;
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
    /// How many elements are between two samples of a pixel.
    pub(crate) stride: usize,
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
    fn prefetch(&self, pixels: std::ops::Range<usize>);

    /// Whether there is nothing to shade: depth alone is drawn.
    fn is_depth_only(&self) -> bool {
        false
    }

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

/// A shader, whichever form it has.
pub(crate) trait Shader<C, const N: usize> {
    /// Colours the lanes of a block that are all visible, and returns those that were not discarded.
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32;

    /// Colours the visible lanes of a block and returns those that were not discarded.
    fn part<S: Simd>(
        &mut self,
        simd: S,
        block: &mut FragmentBlock<'_, N>,
        colors: Halves<'_, C>,
    ) -> u32;
}

/// The colours of a block, which may lie in two rows.
pub(crate) type Halves<'a, C> = [&'a mut [C; HALF_BLOCK]; 2];

/// A function that threads share.
#[derive(Debug)]
pub(crate) struct Shared<'f, F>(pub(crate) &'f F);

impl<F> Clone for Shared<'_, F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F> Copy for Shared<'_, F> {}

/// A function that is called on one thread alone.
#[derive(Debug)]
pub(crate) struct Alone<F>(pub(crate) F);

/// A function from a fragment, called as itself: through a reference to it, it would not be inlined.
pub(crate) trait FragmentFunction<R, const N: usize> {
    fn call(&mut self, fragment: &Fragment<'_, N>) -> R;
}

impl<R, F: Fn(&Fragment<'_, N>) -> R, const N: usize> FragmentFunction<R, N> for Shared<'_, F> {
    #[inline(always)]
    fn call(&mut self, fragment: &Fragment<'_, N>) -> R {
        (*self.0)(fragment)
    }
}

impl<R, F: FnMut(&Fragment<'_, N>) -> R, const N: usize> FragmentFunction<R, N> for Alone<F> {
    #[inline(always)]
    fn call(&mut self, fragment: &Fragment<'_, N>) -> R {
        (self.0)(fragment)
    }
}

/// A function from a block of fragments.
pub(crate) trait BlockFunction<C, const N: usize> {
    fn call(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]);
}

impl<C, F, const N: usize> BlockFunction<C, N> for Shared<'_, F>
where
    F: Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]),
{
    #[inline(always)]
    fn call(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) {
        (*self.0)(block, colors);
    }
}

impl<C, F, const N: usize> BlockFunction<C, N> for Alone<F>
where
    F: FnMut(&mut FragmentBlock<'_, N>, &mut [C; LANES]),
{
    #[inline(always)]
    fn call(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) {
        (self.0)(block, colors);
    }
}

/// A shader that is called for one fragment at a time, and returns an `R`.
#[derive(Debug)]
pub(crate) struct PerFragment<F, R>(pub(crate) F, PhantomData<fn() -> R>);

impl<F, R> PerFragment<F, R> {
    pub(crate) fn new(function: F) -> Self {
        Self(function, PhantomData)
    }
}

impl<F: Clone, R> Clone for PerFragment<F, R> {
    fn clone(&self) -> Self {
        Self(self.0.clone(), PhantomData)
    }
}

impl<F: Copy, R> Copy for PerFragment<F, R> {}

impl<const N: usize, C, R, F> Shader<C, N> for PerFragment<F, R>
where
    C: Copy,
    R: Paint<C>,
    F: FragmentFunction<R, N>,
{
    #[inline(always)]
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32 {
        if R::IN_BLOCKS {
            let paints = std::array::from_fn(
                #[inline(always)]
                |lane| Some(self.0.call(&block.fragment(lane))),
            );
            return R::paint_block(paints, colors);
        }
        let mut drawn = ALL;
        // A plain loop, which the compiler may turn into SIMD.
        for (lane, color) in colors.iter_mut().enumerate() {
            let painted = self.0.call(&block.fragment(lane)).paint(color);
            drawn &= !(u32::from(!painted) << lane);
        }
        drawn
    }

    #[inline(always)]
    fn part<S: Simd>(
        &mut self,
        _: S,
        block: &mut FragmentBlock<'_, N>,
        colors: Halves<'_, C>,
    ) -> u32 {
        let (mut drawn, mut left) = (block.visible, block.visible);
        if R::IN_BLOCKS {
            let paints = std::array::from_fn(
                #[inline(always)]
                |lane| (left >> lane & 1 != 0).then(|| self.0.call(&block.fragment(lane))),
            );
            let [lower, upper] = colors;
            let mut pixels = std::array::from_fn(
                #[inline(always)]
                |lane| if lane < HALF_BLOCK { lower[lane] } else { upper[lane - HALF_BLOCK] },
            );
            drawn = R::paint_block(paints, &mut pixels);
            lower.copy_from_slice(&pixels[..HALF_BLOCK]);
            upper.copy_from_slice(&pixels[HALF_BLOCK..]);
            return drawn;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let color = &mut colors[lane / HALF_BLOCK][lane % HALF_BLOCK];
            let painted = self.0.call(&block.fragment(lane)).paint(color);
            drawn &= !(u32::from(!painted) << lane);
        }
        drawn
    }
}

/// Within one cache line, if it fits: what is stored there can be loaded at once.
#[repr(align(64))]
pub(crate) struct Aligned<T>(pub(crate) T);

/// A shader that is called for a block of fragments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PerBlock<F>(pub(crate) F);

impl<const N: usize, C, F> Shader<C, N> for PerBlock<F>
where
    C: Copy,
    F: BlockFunction<C, N>,
{
    #[inline(always)]
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32 {
        let before = *colors;
        self.0.call(block, colors);
        let drawn = block.visible & ALL;
        if drawn != ALL {
            for lane in (0..LANES).filter(|lane| drawn >> lane & 1 == 0) {
                colors[lane] = before[lane];
            }
        }
        drawn
    }

    #[inline(always)]
    fn part<S: Simd>(
        &mut self,
        simd: S,
        block: &mut FragmentBlock<'_, N>,
        [lower, upper]: Halves<'_, C>,
    ) -> u32 {
        let visible = block.visible;
        let mut shaded = Aligned(std::array::from_fn(
            #[inline(always)]
            |lane| if lane < HALF_BLOCK { lower[lane] } else { upper[lane - HALF_BLOCK] },
        ));
        self.0.call(block, &mut shaded.0);
        // What the shader made is stored here as a whole: only then does the compiler see that its
        // loop over the lanes can be SIMD, whatever becomes of each lane.
        let shaded = std::hint::black_box(&shaded).0;
        let drawn = block.visible & visible;
        choose(simd, drawn, &shaded[..HALF_BLOCK], lower);
        choose(simd, drawn >> HALF_BLOCK, &shaded[HALF_BLOCK..], upper);
        drawn
    }
}

/// Replaces the colours of the lanes that were drawn, in half a block.
#[inline(always)]
pub(crate) fn choose<S: Simd, C: Copy>(
    simd: S,
    drawn: u32,
    new: &[C],
    colors: &mut [C; HALF_BLOCK],
) {
    // A loop over three arrays becomes one vector instruction that chooses.
    let mask = mask32x8::from_bitmask(simd, (drawn & (ALL >> HALF_BLOCK)).into());
    let mask = <[i32; HALF_BLOCK]>::from(mask);
    let old = *colors;
    for lane in 0..HALF_BLOCK {
        colors[lane] = if mask[lane] != 0 { new[lane] } else { old[lane] };
    }
}

/// A shader with the colours that it paints: those of a target, or of some rows of it.
#[derive(Debug)]
pub(crate) struct Painter<'a, S, C, K, const N: usize> {
    pub(crate) simd: S,
    pub(crate) colors: &'a mut [C],
    /// How many pixels of the target come before these.
    pub(crate) pixels_before: usize,
    pub(crate) shader: K,
}

impl<S: Simd, C: Copy, K: Shader<C, N>, const N: usize> ShadeBlocks for Painter<'_, S, C, K, N> {
    fn draw_whole(&mut self, patch: &Patch<'_>, blocks: WholeBlocks, depths: &mut [f32]) -> usize {
        let simd = self.simd;
        match patch.surface.base.divide {
            Divide::PerPixel => simd.vectorize(
                #[inline(always)]
                || self.whole::<true>(patch, blocks, depths),
            ),
            Divide::Never => simd.vectorize(
                #[inline(always)]
                || self.whole::<false>(patch, blocks, depths),
            ),
            // Drawn as parts: no third copy of the shader for what is rare.
            Divide::Mixed => 0,
        }
    }

    fn draw_parts(
        &mut self,
        patch: &Patch<'_>,
        parts: PartBlocks<'_>,
        numbers: u32,
        band: BandDepths<'_>,
    ) -> u32 {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || self.parts(patch, parts, numbers, band),
        )
    }

    fn prefetch(&self, pixels: std::ops::Range<usize>) {
        let start = pixels.start.wrapping_sub(self.pixels_before);
        let colors = self.colors.get(start..start.wrapping_add(pixels.len()));
        let in_cache_line = (64 / size_of::<C>().max(1)).max(1);
        for color in colors.unwrap_or_default().iter().step_by(in_cache_line) {
            std::hint::black_box(*color);
        }
    }
}

impl<S: Simd, C: Copy, K: Shader<C, N>, const N: usize> Painter<'_, S, C, K, N> {
    /// Draws whole blocks of a polygon all of whose parameters are divided, or none.
    #[inline(always)]
    fn whole<const DIVIDES: bool>(
        &mut self,
        patch: &Patch<'_>,
        blocks: WholeBlocks,
        depths: &mut [f32],
    ) -> usize {
        let Patch { surface, runs, values } = *patch;
        let Some(s) = values.s.first_chunk::<N>() else {
            rarely();
            return 0;
        };
        // Copies: what is read through references would be read again after each colour is stored.
        let row = blocks.row % ROWS;
        let mut lines = [SpanLine::default(); N];
        for (line, value) in lines.iter_mut().zip(s) {
            *line = SpanLine::of(value, row);
        }
        let inv_w = SpanLine::of(&values.inv_w, row);
        let first_column = values.x[row] + blocks.steps as i32;
        let start = blocks.pixel.wrapping_sub(self.pixels_before);
        let Some(colors) = self.colors.get_mut(start..start.wrapping_add(depths.len())) else {
            rarely();
            return 0;
        };
        draw_whole_blocks(
            self.simd,
            patch,
            blocks,
            (colors, depths),
            #[inline(always)]
            |block, depth, pixel, colors| {
                let x = first_column + pixel as i32;
                let halves = [(x, row), (x + HALF_BLOCK as i32, row)];
                let mut fragments = FragmentBlock::new(surface, runs, halves, ALL);
                fragments.depth = depth.into();
                if DIVIDES {
                    block.divided(surface, &inv_w, &lines, fragments.found());
                } else {
                    block.undivided(&lines, &mut fragments.params);
                }
                self.shader.whole(&mut fragments, colors)
            },
        )
    }

    #[inline(always)]
    fn parts(
        &mut self,
        patch: &Patch<'_>,
        parts: PartBlocks<'_>,
        numbers: u32,
        BandDepths { depths, pixels_before }: BandDepths<'_>,
    ) -> u32 {
        let Patch { surface, runs, values } = *patch;
        let Some(s) = values.s.first_chunk::<N>() else {
            rarely();
            return 0;
        };
        let Self { simd, shader, .. } = self;
        // As many as there are depths, so that what is in range there need not be checked again.
        let start = pixels_before.wrapping_sub(self.pixels_before);
        let colors = self.colors.get_mut(start..start.wrapping_add(depths.len()));
        let Some(colors) = colors else {
            rarely();
            return 0;
        };
        draw_part_blocks(
            *simd,
            patch,
            parts,
            numbers,
            depths,
            #[inline(always)]
            |block, depth, part| {
                let column = |half: usize| {
                    (values.x[part.rows[half] % ROWS] + part.steps[half] as i32, part.rows[half])
                };
                let halves = [column(0), column(1)];
                let mut fragments = FragmentBlock::new(surface, runs, halves, part.visible);
                fragments.depth = depth.into();
                let found = fragments.found();
                if surface.base.divide == Divide::PerPixel {
                    block.divided(surface, &values.inv_w, s, found);
                } else {
                    block.any(surface, &values.inv_w, s, found);
                }
                let mut copy = None;
                let halves = match halves_at(colors, part.at) {
                    Some(halves) => halves,
                    None => {
                        rarely();
                        let Some(any) = colors.first() else { return 0 };
                        let [lower, upper] =
                            copy.insert(part.at.map(|at| half_at_end(colors, at, *any)));
                        [lower, upper]
                    }
                };
                let drawn = shader.part(*simd, &mut fragments, halves);
                if let Some(halves) = &copy {
                    put_back(colors, part.at, halves, drawn);
                }
                drawn
            },
        )
    }
}

/// Draws the parts of blocks that have a bit in `numbers`; calls `shade` for those of which a lane
/// is visible, and stores the depths of the lanes that it returns. Returns the numbers of those that
/// are not drawn, since their halves are not whole or not apart.
#[inline(always)]
fn draw_part_blocks<S: Simd>(
    simd: S,
    patch: &Patch<'_>,
    mut parts: PartBlocks<'_>,
    numbers: u32,
    depths: &mut [f32],
    mut shade: impl FnMut(&Block<S, TwoRows>, f32x16<S>, &PartBlock) -> u32,
) -> u32 {
    let is_tested = matches!(parts, PartBlocks::Visible(_));
    let (mut left, mut not_drawn) = (numbers, 0);
    while left != 0 {
        for _ in 0..NEST {
            if left == 0 {
                break;
            }
            let number = left.trailing_zeros() as usize;
            left &= left - 1;
            let mut part = parts.get(number);
            let block = Block::in_two_rows(simd, part.rows, part.steps);
            let depth = block.depth(patch.surface, patch.values);
            let mut stored = None;
            if !is_tested {
                let Some(halves) = halves_at(depths, part.at) else {
                    rarely();
                    not_drawn |= 1 << number;
                    continue;
                };
                let lower = f32x8::simd_from(simd, *halves[0]);
                let upper = f32x8::simd_from(simd, *halves[1]);
                let old = lower.combine(upper);
                part.visible &= Comparison::Less.passes(depth, old);
                if part.visible == 0 {
                    continue;
                }
                stored = Some((halves, old));
            }
            let drawn = shade(&block, depth, &part);
            if let Some(([lower, upper], old)) = stored {
                let drawn = mask32x16::from_bitmask(simd, drawn.into());
                let (new_lower, new_upper) = drawn.select(depth, old).split();
                *lower = new_lower.into();
                *upper = new_upper.into();
            } else {
                parts.set_drawn(number, drawn);
            }
        }
    }
    not_drawn
}

/// Tests whole blocks of a row, the first pixel of which is that of the colours and of the depths; calls
/// `shade` for those that are visible, and stores the depths of the lanes that it returns. Ends at a block
/// that is visible in part. Returns how many pixels are done.
#[inline(always)]
fn draw_whole_blocks<S: Simd, C>(
    simd: S,
    patch: &Patch<'_>,
    blocks: WholeBlocks,
    (colors, depths): (&mut [C], &mut [f32]),
    mut shade: impl FnMut(&Block<S, OneRow>, f32x16<S>, usize, &mut [C; LANES]) -> u32,
) -> usize {
    let row = blocks.row % ROWS;
    let (z, z_range) = (SpanLine::of(&patch.values.z, row), patch.surface.base.z_range);
    let mut block = Block::in_row(simd, row, blocks.steps);
    let (colors, depths) = (colors.as_chunks_mut().0, depths.as_chunks_mut().0);
    let mut done = 0;
    for (colors, depths) in colors.chunks_mut(NEST).zip(depths.chunks_mut(NEST)) {
        for (colors, stored) in colors.iter_mut().zip(depths) {
            let depth = block.depth_along(&z, z_range);
            let old = f32x16::simd_from(simd, *stored);
            let visible = Comparison::Less.passes(depth, old) & ALL;
            if visible == ALL {
                let drawn = shade(&block, depth, done, colors);
                let drawn_mask = mask32x16::from_bitmask(simd, drawn.into());
                let new = if drawn == ALL { depth } else { drawn_mask.select(depth, old) };
                *stored = new.into();
            } else {
                rarely();
                if visible != 0 {
                    return done;
                }
            }
            done += LANES;
            block.advance();
        }
    }
    done
}

/// Blocks in the inner of two loops. A call within two loops the compiler takes to be hot, and inlines
/// larger shaders there than within one (LLVM's `locally-hot-callsite-threshold`), if it knows the ways
/// out of the loops to be [rare](rarely).
pub(crate) const NEST: usize = 64;

/// Tells the compiler that the branch that calls this is rarely taken.
#[cold]
pub(crate) fn rarely() {}

/// The colours of half a block that reaches over the ends of a list; where there are none, `any`.
#[cold]
fn half_at_end<C: Copy>(colors: &[C], first: usize, any: C) -> [C; HALF_BLOCK] {
    let color = |lane: usize| colors.get(first.wrapping_add(lane)).copied().unwrap_or(any);
    std::array::from_fn(color)
}

/// Puts the colours that were drawn where they belong, as far as they do.
#[cold]
fn put_back<C: Copy>(
    colors: &mut [C],
    pixels: [usize; 2],
    halves: &[[C; HALF_BLOCK]; 2],
    drawn: u32,
) {
    for (half, shaded) in halves.iter().enumerate() {
        for (lane, color) in shaded.iter().enumerate() {
            if drawn >> (half * HALF_BLOCK + lane) & 1 != 0
                && let Some(pixel) = colors.get_mut(pixels[half].wrapping_add(lane))
            {
                *pixel = *color;
            }
        }
    }
}

impl<S, C, K, const N: usize> ShadeOnThreads for Painter<'_, S, C, K, N>
where
    S: Simd + Send,
    C: Copy + Send,
    K: Shader<C, N> + Copy + Send,
{
    fn split(
        &mut self,
        pixel: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    ) {
        let &mut Self { simd, pixels_before, shader, .. } = self;
        let middle = pixel.saturating_sub(pixels_before).min(self.colors.len());
        let (first, second) = self.colors.split_at_mut(middle);
        f(
            &mut Painter { simd, colors: first, pixels_before, shader },
            &mut Painter { simd, colors: second, pixels_before: pixel, shader },
        );
    }
}

/// The halves of a block that begin at `at`, if they are whole and apart.
#[inline(always)]
pub(crate) fn halves_at<T>(pixels: &mut [T], at: [usize; 2]) -> Option<Halves<'_, T>> {
    let (first, second) = pixels.split_at_mut_checked(at[1])?;
    Some([first.get_mut(at[0]..)?.first_chunk_mut()?, second.first_chunk_mut()?])
}

/// No shader: depth alone is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthOnly<S>(pub(crate) S);

impl<S: Simd> ShadeBlocks for DepthOnly<S> {
    fn draw_whole(&mut self, patch: &Patch<'_>, blocks: WholeBlocks, depths: &mut [f32]) -> usize {
        let simd = self.0;
        simd.vectorize(
            #[inline(always)]
            || {
                let mut colors = [(); WIDEST];
                let count = depths.len().min(WIDEST);
                let both = (&mut colors[..count], &mut depths[..count]);
                draw_whole_blocks(simd, patch, blocks, both, |_, _, _, _| ALL)
            },
        )
    }

    fn draw_parts(
        &mut self,
        patch: &Patch<'_>,
        parts: PartBlocks<'_>,
        numbers: u32,
        band: BandDepths<'_>,
    ) -> u32 {
        let simd = self.0;
        simd.vectorize(
            #[inline(always)]
            || {
                draw_part_blocks(
                    simd,
                    patch,
                    parts,
                    numbers,
                    band.depths,
                    #[inline(always)]
                    |_, _, part| part.visible,
                )
            },
        )
    }

    fn prefetch(&self, _: std::ops::Range<usize>) {}

    fn is_depth_only(&self) -> bool {
        true
    }
}

/// As many colours without a size as a row may have pixels.
const WIDEST: usize = MAX_SIZE as usize;

impl<S: Simd + Send> ShadeOnThreads for DepthOnly<S> {
    fn split(
        &mut self,
        _: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    ) {
        f(&mut self.clone(), &mut self.clone());
    }
}
