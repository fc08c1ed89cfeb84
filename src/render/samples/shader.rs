//! Shaders of pixels that have several samples: each is called once for a pixel, and its result goes to the samples
//! that are visible.

use std::marker::PhantomData;

use fearless_simd::Simd;

use crate::fragment::FragmentBlock;
use crate::fragment::block::{ALL, HALF_BLOCK, LANES};
use crate::render::paint::Paint;
use crate::render::samples::frame::offset;
use crate::render::shader::{
    Aligned, BlockFunction, FragmentFunction, MOST_SAMPLES, PerBlock, PerFragment, Shader, choose,
};

/// The samples of a block's pixels: their colours, and which of them are to be drawn.
pub(crate) struct SampleColors<'a, C> {
    pub(super) colors: &'a mut [C],
    /// Where the first samples of both halves are.
    pub(super) at: [usize; 2],
    /// What [`offset`] is to know.
    pub(super) plane: usize,
    /// The pixels of which each sample is visible, a bit a lane; after shading, those that were drawn.
    pub(crate) visible: &'a mut [u32],
}

impl<C> SampleColors<'_, C> {
    /// The colours of a sample, in half of the pixels.
    #[inline(always)]
    fn half(&mut self, sample: usize, half: usize) -> Option<&mut [C; HALF_BLOCK]> {
        let at = self.at[half].wrapping_add(offset(sample, self.plane));
        self.colors.get_mut(at..)?.first_chunk_mut()
    }
}

/// A shader of pixels with several samples.
pub(crate) trait SampleShader<C, const N: usize> {
    /// Whether samples of one colour get one colour.
    const IS_BY_PIXEL: bool;
    /// Whether the colours that were there make no difference.
    const REPLACES: bool;

    /// Colours a tile of pixels whose samples all have the same colour, and returns those that were not
    /// discarded.
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32;

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
    F: BlockFunction<[C; LANES], N>,
{
    const IS_BY_PIXEL: bool = true;
    const REPLACES: bool = true;

    #[inline(always)]
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32 {
        Shader::whole(self, block, colors)
    }

    #[inline(always)]
    fn shade<S: Simd>(
        &mut self,
        simd: S,
        block: &mut FragmentBlock<'_, N>,
        mut samples: SampleColors<'_, C>,
    ) {
        let Some(mut shaded) = samples.first() else { return samples.visible.fill(0) };
        self.0.call(block, &mut shaded.0);
        // Stored as a whole, so that the shader's loop over the lanes can be SIMD.
        let shaded = std::hint::black_box(&shaded).0;
        samples.replace(simd, block.visible, &shaded);
    }
}

impl<const N: usize, C, R, F> SampleShader<C, N> for PerFragment<F, R>
where
    C: Copy,
    R: Paint<C> + Copy,
    F: FragmentFunction<R, N>,
{
    const IS_BY_PIXEL: bool = true;
    const REPLACES: bool = R::IN_BLOCKS;

    #[inline(always)]
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32 {
        Shader::whole(self, block, colors)
    }

    #[inline(always)]
    fn shade<S: Simd>(
        &mut self,
        simd: S,
        block: &mut FragmentBlock<'_, N>,
        mut samples: SampleColors<'_, C>,
    ) {
        let mut left = block.visible & ALL;
        if R::IN_BLOCKS {
            let Some(mut shaded) = samples.first() else { return samples.visible.fill(0) };
            let paints = std::array::from_fn(
                #[inline(always)]
                |lane| (left >> lane & 1 != 0).then(|| self.0.call(&block.fragment(lane))),
            );
            let drawn = R::paint_block(paints, &mut shaded.0);
            return samples.replace(simd, drawn, &shaded.0);
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let result = self.0.call(&block.fragment(lane));
            samples.paint_pixel(lane, MOST_SAMPLES, result);
        }
    }
}

impl<C: Copy> SampleColors<'_, C> {
    /// The colours of the first samples; in a half that lies outside of the memory, those of the other.
    #[inline(always)]
    fn first(&mut self) -> Option<Aligned<[C; LANES]>> {
        let [lower, upper] = [0, 1].map(|half| self.half(0, half).copied());
        let (lower, upper) = (lower.or(upper)?, upper.or(lower)?);
        Some(Aligned(std::array::from_fn(
            #[inline(always)]
            |lane| if lane < HALF_BLOCK { lower[lane] } else { upper[lane - HALF_BLOCK] },
        )))
    }

    /// Replaces the colours of visible samples of the pixels that have a bit in a mask; the others are not
    /// drawn.
    #[inline(always)]
    fn replace<S: Simd>(&mut self, simd: S, pixels: u32, new: &[C; LANES]) {
        for sample in 0..self.visible.len() {
            let drawn = self.visible[sample] & pixels;
            self.visible[sample] = drawn;
            for half in 0..2 {
                let new = &new[half * HALF_BLOCK..][..HALF_BLOCK];
                let drawn = drawn >> (half * HALF_BLOCK) & (ALL >> HALF_BLOCK);
                // Small colours are chosen at once: which are drawn, no branch could predict.
                if size_of::<C>() > size_of::<f32>() && drawn == 0 {
                    continue;
                }
                if let Some(colors) = self.half(sample, half) {
                    choose(simd, drawn, new, colors);
                }
            }
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
    const IS_BY_PIXEL: bool = false;
    const REPLACES: bool = false;

    #[inline(always)]
    fn whole(&mut self, _: &mut FragmentBlock<'_, N>, _: &mut [C; LANES]) -> u32 {
        0
    }

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
    const IS_BY_PIXEL: bool = true;
    const REPLACES: bool = false;

    #[inline(always)]
    fn whole(&mut self, _: &mut FragmentBlock<'_, 0>, _: &mut [C; LANES]) -> u32 {
        ALL
    }

    #[inline(always)]
    fn shade<S: Simd>(&mut self, _: S, _: &mut FragmentBlock<'_, 0>, _: SampleColors<'_, C>) {}
}
