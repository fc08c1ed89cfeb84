//! From blocks whose covered samples are known to colours: the loops around a shader, for pixels of several
//! samples. This is all that knows the shader's type.

use std::marker::PhantomData;
use std::ops::Range;

use fearless_simd::{
    Select, Simd, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::coverage::run::ROWS;
use crate::fragment::FragmentBlock;
use crate::fragment::block::{ALL, Block, HALF_BLOCK, LANES, Lanes};
use crate::render::paint::Paint;
use crate::render::shader::{
    Aligned, BandDepths, BlockFunction, FragmentFunction, MOST_SAMPLES, PartBlocks, Patch,
    PerBlock, PerFragment, SampleBlock, SampleBlocks, ShadeBlocks, ShadeOnThreads, WholeBlocks,
    choose,
};

/// The samples of a block's pixels: their colours, and which of them are to be drawn.
pub(crate) struct SampleColors<'a, C> {
    colors: &'a mut [C],
    at: [usize; 2],
    stride: usize,
    /// The pixels of which each sample is visible, a bit a lane; after shading, those that were drawn.
    pub(crate) visible: &'a mut [u32],
}

impl<C> SampleColors<'_, C> {
    /// The colours of a sample, in half of the pixels.
    #[inline(always)]
    fn half(&mut self, sample: usize, half: usize) -> Option<&mut [C; HALF_BLOCK]> {
        let at = self.at[half].wrapping_add(sample * self.stride);
        self.colors.get_mut(at..)?.first_chunk_mut()
    }
}

/// A shader of pixels with several samples.
pub(crate) trait SampleShader<C, const N: usize> {
    /// Colours the visible samples of a block, and says which of them were not discarded.
    fn shade<S: Simd>(
        &mut self,
        simd: S,
        block: &mut FragmentBlock<'_, N>,
        samples: SampleColors<'_, C>,
    );
}

impl<const N: usize, C, F> SampleShader<C, N> for PerBlock<F>
where
    C: Copy,
    F: BlockFunction<C, N>,
{
    #[inline(always)]
    fn shade<S: Simd>(
        &mut self,
        simd: S,
        block: &mut FragmentBlock<'_, N>,
        mut samples: SampleColors<'_, C>,
    ) {
        let Some(&mut lower) = samples.half(0, 0) else { return samples.visible.fill(0) };
        let Some(&mut upper) = samples.half(0, 1) else { return samples.visible.fill(0) };
        let mut shaded = Aligned(std::array::from_fn(
            #[inline(always)]
            |lane| if lane < HALF_BLOCK { lower[lane] } else { upper[lane - HALF_BLOCK] },
        ));
        self.0.call(block, &mut shaded.0);
        // Stored as a whole, so that the shader's loop over the lanes can be SIMD.
        let shaded = std::hint::black_box(&shaded).0;
        for sample in 0..samples.visible.len() {
            let drawn = samples.visible[sample] & block.visible;
            samples.visible[sample] = drawn;
            for half in 0..2 {
                let new = &shaded[half * HALF_BLOCK..][..HALF_BLOCK];
                let drawn = drawn >> (half * HALF_BLOCK) & (ALL >> HALF_BLOCK);
                if drawn == 0 {
                    continue;
                }
                if let Some(colors) = samples.half(sample, half) {
                    if drawn == ALL >> HALF_BLOCK {
                        colors.copy_from_slice(new);
                    } else {
                        choose(simd, drawn, new, colors);
                    }
                }
            }
        }
    }
}

impl<const N: usize, C, R, F> SampleShader<C, N> for PerFragment<F, R>
where
    R: Paint<C> + Copy,
    F: FragmentFunction<R, N>,
{
    #[inline(always)]
    fn shade<S: Simd>(
        &mut self,
        _: S,
        block: &mut FragmentBlock<'_, N>,
        mut samples: SampleColors<'_, C>,
    ) {
        let mut left = block.visible & ALL;
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let result = self.0.call(&block.fragment(lane));
            samples.paint_pixel(lane, MOST_SAMPLES, result);
        }
    }
}

impl<C> SampleColors<'_, C> {
    /// Paints the visible ones of a pixel's first samples; the others are not drawn.
    #[inline(always)]
    fn paint_pixel<R: Paint<C> + Copy>(&mut self, lane: usize, first: usize, result: R) {
        for sample in 0..self.visible.len() {
            if self.visible[sample] >> lane & 1 != 0 {
                let is_drawn = sample < first
                    && self
                        .half(sample, lane / HALF_BLOCK)
                        .is_some_and(|colors| result.paint(&mut colors[lane % HALF_BLOCK]));
                self.visible[sample] &= !(u32::from(!is_drawn) << lane);
            }
        }
    }
}

/// A shader that returns a colour and how much of the pixel it covers, from 0 to 1.
#[derive(Debug)]
pub(crate) struct ToCoverage<F, R>(F, PhantomData<fn() -> R>);

impl<F, R> ToCoverage<F, R> {
    pub(crate) fn new(function: F) -> Self {
        Self(function, PhantomData)
    }
}

impl<F: Clone, R> Clone for ToCoverage<F, R> {
    fn clone(&self) -> Self {
        Self(self.0.clone(), PhantomData)
    }
}

impl<F: Copy, R> Copy for ToCoverage<F, R> {}

impl<const N: usize, C, R, F> SampleShader<C, N> for ToCoverage<F, R>
where
    R: Paint<C> + Copy,
    F: FragmentFunction<(R, f32), N>,
{
    #[inline(always)]
    fn shade<S: Simd>(
        &mut self,
        _: S,
        block: &mut FragmentBlock<'_, N>,
        mut samples: SampleColors<'_, C>,
    ) {
        let count = samples.visible.len() as f32;
        let mut left = block.visible & ALL;
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let (result, covered) = self.0.call(&block.fragment(lane));
            // The cast makes 0 of what is negative and of NaN.
            samples.paint_pixel(lane, (covered * count + 0.5) as usize, result);
        }
    }
}

/// No shader: depth alone is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoShader;

impl<C> SampleShader<C, 0> for NoShader {
    #[inline(always)]
    fn shade<S: Simd>(&mut self, _: S, _: &mut FragmentBlock<'_, 0>, _: SampleColors<'_, C>) {}
}

/// A shader with the samples that it paints: those of a target, or of some rows of it.
#[derive(Debug)]
pub(crate) struct SamplePainter<'a, S, C, K, const N: usize> {
    pub(crate) simd: S,
    pub(crate) colors: &'a mut [C],
    /// How many samples of the target come before these.
    pub(crate) samples_before: usize,
    pub(crate) shader: K,
}

impl<S: Simd, C: Copy, K: SampleShader<C, N>, const N: usize> ShadeBlocks
    for SamplePainter<'_, S, C, K, N>
{
    /// Nothing: pixels of one sample are none of its.
    fn draw_whole(&mut self, _: &Patch<'_>, _: WholeBlocks, _: &mut [f32]) -> usize {
        0
    }

    fn draw_parts(&mut self, _: &Patch<'_>, _: PartBlocks<'_>, _: u32, _: BandDepths<'_>) -> u32 {
        0
    }

    fn prefetch(&self, _: Range<usize>) {}

    fn draw_samples(&mut self, patch: &Patch<'_>, blocks: SampleBlocks<'_>, band: BandDepths<'_>) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || self.draw(patch, &blocks, band),
        );
    }
}

impl<S: Simd, C: Copy, K: SampleShader<C, N>, const N: usize> SamplePainter<'_, S, C, K, N> {
    #[inline(always)]
    fn draw(&mut self, patch: &Patch<'_>, set: &SampleBlocks<'_>, band: BandDepths<'_>) {
        let Patch { surface, runs, values } = *patch;
        let Some(s) = values.s.first_chunk::<N>() else { return };
        let (simd, stride) = (self.simd, set.stride);
        let start = band.pixels_before.wrapping_sub(self.samples_before);
        let colors = self.colors.get_mut(start..start.wrapping_add(band.depths.len()));
        let Some(colors) = colors else { return };
        let count = set.depths.len().min(MOST_SAMPLES);
        let mut found = Depths { new: [[0.0; LANES]; MOST_SAMPLES], visible: [0; MOST_SAMPLES] };
        for part in set.blocks {
            let block = Block::in_two_rows(simd, part.rows, part.steps);
            let mut visible = 0;
            for sample in 0..count {
                let line = &set.depths[sample];
                let depth = block.compared(surface, line, set.is_inverse_w);
                let old = load(simd, band.depths, part.at, sample * stride);
                let passes = set.comparison.passes(depth, old) & part.covered[sample];
                found.new[sample] = depth.into();
                found.visible[sample] = passes;
                visible |= passes;
            }
            if visible == 0 {
                continue;
            }
            let column = |half: usize| {
                (values.x[part.rows[half] % ROWS] + part.steps[half] as i32, part.rows[half])
            };
            let halves = [column(0), column(1)];
            let mut fragments = FragmentBlock::new(surface, runs, halves, visible);
            let places = places(part, set, count);
            let mut depth = [0.0; LANES];
            block.off_centre(surface, values, s, &places, (&mut depth, fragments.found()));
            fragments.depth = depth;
            let samples = SampleColors {
                colors: &mut *colors,
                at: part.at,
                stride,
                visible: &mut found.visible[..count],
            };
            self.shader.shade(simd, &mut fragments, samples);
            if set.writes {
                for sample in 0..count {
                    let (drawn, depth) = (found.visible[sample], &found.new[sample]);
                    store(simd, band.depths, part.at, sample * stride, (drawn, depth));
                }
            }
        }
    }
}

/// The depths of a block's samples, and which pixels show them.
struct Depths {
    new: [Lanes; MOST_SAMPLES],
    visible: [u32; MOST_SAMPLES],
}

/// Where the pixels of a block are shaded: at their centres where all samples are covered, elsewhere at the
/// mean of those that are, if that is asked for.
#[inline(always)]
fn places(part: &SampleBlock, set: &SampleBlocks<'_>, count: usize) -> [Lanes; 2] {
    let all = part.covered[..count].iter().fold(ALL, |all, covered| all & covered);
    if all == ALL || !set.at_centroid {
        return [[0.0; LANES]; 2];
    }
    places_at_edge(part, set, all)
}

#[inline(never)]
fn places_at_edge(part: &SampleBlock, set: &SampleBlocks<'_>, all: u32) -> [Lanes; 2] {
    let ([mut x, mut y], mut counts) = ([[0.0; LANES]; 2], [0.0; LANES]);
    for (&[place_x, place_y], covered) in set.places.iter().zip(part.covered) {
        for lane in 0..LANES {
            // Sums of 16ths: exact.
            let weight = (covered >> lane & 1) as f32;
            x[lane] += place_x * weight;
            y[lane] += place_y * weight;
            counts[lane] += weight;
        }
    }
    for lane in 0..LANES {
        let is_edge = all >> lane & 1 == 0 && counts[lane] > 0.0;
        let per_count = if is_edge { 1.0 / counts[lane] } else { 0.0 };
        (x[lane], y[lane]) = (x[lane] * per_count, y[lane] * per_count);
    }
    [x, y]
}

/// The depths of a sample; of what lies outside of the band, which is covered by nothing, 0.
#[inline(always)]
fn load<S: Simd>(simd: S, depths: &[f32], at: [usize; 2], offset: usize) -> f32x16<S> {
    let half = |at: usize| {
        let depths = depths.get(at.wrapping_add(offset)..);
        depths.and_then(<[f32]>::first_chunk).copied().unwrap_or([0.0; HALF_BLOCK])
    };
    let lower = f32x8::simd_from(simd, half(at[0]));
    lower.combine(f32x8::simd_from(simd, half(at[1])))
}

/// Stores the depths of a sample where they are drawn.
#[inline(always)]
fn store<S: Simd>(
    simd: S,
    depths: &mut [f32],
    at: [usize; 2],
    offset: usize,
    (drawn, new): (u32, &Lanes),
) {
    if drawn == 0 {
        return;
    }
    let mut kept = f32x16::simd_from(simd, *new);
    if drawn != ALL {
        let old = load(simd, depths, at, offset);
        kept = mask32x16::from_bitmask(simd, drawn.into()).select(kept, old);
    }
    let (lower, upper) = kept.split();
    for (half, new) in [lower, upper].into_iter().enumerate() {
        if drawn >> (half * HALF_BLOCK) & (ALL >> HALF_BLOCK) != 0
            && let Some(depths) = depths.get_mut(at[half].wrapping_add(offset)..)
            && let Some(depths) = depths.first_chunk_mut()
        {
            *depths = <[f32; HALF_BLOCK]>::from(new);
        }
    }
}

impl<S, C, K, const N: usize> ShadeOnThreads for SamplePainter<'_, S, C, K, N>
where
    S: Simd + Send,
    C: Copy + Send,
    K: SampleShader<C, N> + Copy + Send,
{
    fn split(
        &mut self,
        sample: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    ) {
        let &mut Self { simd, samples_before, shader, .. } = self;
        let middle = sample.saturating_sub(samples_before).min(self.colors.len());
        let (first, second) = self.colors.split_at_mut(middle);
        f(
            &mut SamplePainter { simd, colors: first, samples_before, shader },
            &mut SamplePainter { simd, colors: second, samples_before: sample, shader },
        );
    }
}
