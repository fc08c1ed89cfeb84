//! Shaders that paint several buffers at once. To the loops around a shader they are shaders of pixels
//! that have no colour, which know where their pixels are.

use fearless_simd::Simd;

use crate::fragment::FragmentBlock;
use crate::fragment::block::{ALL, HALF_BLOCK, LANES};
use crate::render::paint::Paint;
use crate::render::pixel::{BufferSet, Buffers};
use crate::render::shader::blocks::ShadeOnThreads;
use crate::render::shader::draw::Painter;
use crate::render::shader::form::{
    Aligned, BlockFunction, FragmentFunction, Halves, PerBlock, PerFragment, Shader,
};

/// A shader with the buffers that it paints: those of a target, or of some rows of it.
pub(crate) struct OnBuffers<'a, S, B: BufferSet + 'a, K> {
    pub(crate) simd: S,
    pub(crate) slices: B::Slices<'a>,
    /// Pixels in a row of the target.
    pub(crate) width: usize,
    /// How many pixels of the target come before these.
    pub(crate) pixels_before: usize,
    pub(crate) shader: K,
}

/// A shader, whichever form it has.
pub(crate) trait BufferShader<B: BufferSet, const N: usize> {
    /// Paints the visible lanes of a block, all of them if `WHOLE`, and returns those that were not discarded.
    fn shade<const WHOLE: bool>(
        &mut self,
        block: &mut FragmentBlock<'_, N>,
        values: &mut B::Block,
    ) -> u32;
}

impl<B: BufferSet, R, F, const N: usize> BufferShader<B, N> for PerFragment<F, R>
where
    R: Paint<Buffers<B>>,
    F: FragmentFunction<R, N>,
{
    #[inline(always)]
    fn shade<const WHOLE: bool>(
        &mut self,
        block: &mut FragmentBlock<'_, N>,
        values: &mut B::Block,
    ) -> u32 {
        let mut left = if WHOLE { ALL } else { block.visible & ALL };
        if R::IN_BLOCKS {
            let paints = std::array::from_fn(
                #[inline(always)]
                |lane| (left >> lane & 1 != 0).then(|| self.0.call(&block.fragment(lane))),
            );
            let mut pixels = std::array::from_fn(|lane| Buffers(B::get(values, lane)));
            let drawn = R::paint_block(paints, &mut pixels);
            for (lane, Buffers(pixel)) in pixels.into_iter().enumerate() {
                B::set(values, lane, pixel);
            }
            return drawn;
        }
        let mut drawn = left;
        if WHOLE {
            // A plain loop, which the compiler may turn into SIMD.
            for lane in 0..LANES {
                drawn &= !(u32::from(!paint_lane(&mut self.0, block, lane, values)) << lane);
            }
        } else {
            while left != 0 {
                let lane = left.trailing_zeros() as usize % LANES;
                left &= left - 1;
                drawn &= !(u32::from(!paint_lane(&mut self.0, block, lane, values)) << lane);
            }
        }
        drawn
    }
}

/// Paints one lane; whether it was not discarded.
#[inline(always)]
fn paint_lane<B: BufferSet, R: Paint<Buffers<B>>, const N: usize>(
    shader: &mut impl FragmentFunction<R, N>,
    block: &FragmentBlock<'_, N>,
    lane: usize,
    values: &mut B::Block,
) -> bool {
    let mut pixel = Buffers(B::get(values, lane));
    let is_painted = shader.call(&block.fragment(lane)).paint(&mut pixel);
    B::set(values, lane, pixel.0);
    is_painted
}

impl<B: BufferSet, F: BlockFunction<B::Block, N>, const N: usize> BufferShader<B, N>
    for PerBlock<F>
{
    #[inline(always)]
    fn shade<const WHOLE: bool>(
        &mut self,
        block: &mut FragmentBlock<'_, N>,
        values: &mut B::Block,
    ) -> u32 {
        let visible = block.visible & ALL;
        self.0.call(block, values);
        block.visible & visible
    }
}

impl<L, B, K, const N: usize> Shader<(), N> for OnBuffers<'_, L, B, K>
where
    L: Simd,
    B: BufferSet,
    K: BufferShader<B, N>,
{
    #[inline(always)]
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, _: &mut [(); LANES]) -> u32 {
        self.shade::<true, N>(block)
    }

    #[inline(always)]
    fn part<S: Simd>(&mut self, _: S, block: &mut FragmentBlock<'_, N>, _: Halves<'_, ()>) -> u32 {
        self.shade::<false, N>(block)
    }
}

impl<S: Simd, B: BufferSet, K> OnBuffers<'_, S, B, K> {
    #[inline(always)]
    fn shade<const WHOLE: bool, const N: usize>(&mut self, block: &mut FragmentBlock<'_, N>) -> u32
    where
        K: BufferShader<B, N>,
    {
        // Of a half that has no visible lane this may be anywhere.
        let at = [0, HALF_BLOCK].map(|lane| {
            let (x, y) = block.position(lane);
            let row = (y as usize).wrapping_mul(self.width);
            row.wrapping_add(x as usize).wrapping_sub(self.pixels_before)
        });
        let mut values = Aligned(B::load(&self.slices, at));
        let drawn = self.shader.shade::<WHOLE>(block, &mut values.0);
        if WHOLE {
            B::store(self.simd, &mut self.slices, at, &values.0, drawn);
        } else {
            // Stored as a whole, so that the shader's loop over the lanes can be SIMD.
            let values = std::hint::black_box(&values);
            B::store(self.simd, &mut self.slices, at, &values.0, drawn);
        }
        drawn
    }
}

impl<S, B, K, const N: usize> ShadeOnThreads for Painter<'_, S, (), OnBuffers<'_, S, B, K>, N>
where
    S: Simd + Send,
    B: BufferSet,
    K: BufferShader<B, N> + Copy + Send,
{
    fn split(
        &mut self,
        pixel: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    ) {
        let &mut Self { simd, pixels_before, ref mut shader, .. } = self;
        let OnBuffers { slices, width, shader, .. } = shader;
        let middle = pixel.saturating_sub(pixels_before).min(self.colors.len());
        let (first, second) = self.colors.split_at_mut(middle);
        let (slices_before, slices) = B::split(slices, middle);
        let on = |slices, pixels_before| OnBuffers::<S, B, K> {
            simd,
            slices,
            width: *width,
            pixels_before,
            shader: *shader,
        };
        let before = on(slices_before, pixels_before);
        f(
            &mut Painter::<_, _, _, N> { simd, colors: first, pixels_before, shader: before },
            &mut Painter::<_, _, _, N> {
                simd,
                colors: second,
                pixels_before: pixel,
                shader: on(slices, pixel),
            },
        );
    }
}
