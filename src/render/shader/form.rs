//! The forms that a shader has: called for each fragment or for a block of them, on any thread or on one alone.

use std::marker::PhantomData;

use fearless_simd::Simd;

use crate::fragment::block::{ALL, HALF_BLOCK, LANES};
use crate::fragment::{Fragment, FragmentBlock};
use crate::render::paint::Paint;
use crate::render::pixel::choose;

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

/// A function from a block of fragments to their colours: `[C; LANES]`, or what there is in several buffers.
pub(crate) trait BlockFunction<B, const N: usize> {
    fn call(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut B);
}

impl<B, F, const N: usize> BlockFunction<B, N> for Shared<'_, F>
where
    F: Fn(&mut FragmentBlock<'_, N>, &mut B),
{
    #[inline(always)]
    fn call(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut B) {
        (*self.0)(block, colors);
    }
}

impl<B, F, const N: usize> BlockFunction<B, N> for Alone<F>
where
    F: FnMut(&mut FragmentBlock<'_, N>, &mut B),
{
    #[inline(always)]
    fn call(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut B) {
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
            // A plain loop: sixteen calls beside one another the compiler would not inline.
            let mut paints = [const { None }; LANES];
            for (lane, paint) in paints.iter_mut().enumerate() {
                *paint = Some(self.0.call(&block.fragment(lane)));
            }
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
            let mut paints = [const { None }; LANES];
            for (lane, paint) in paints.iter_mut().enumerate() {
                if left >> lane & 1 != 0 {
                    *paint = Some(self.0.call(&block.fragment(lane)));
                }
            }
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
    F: BlockFunction<[C; LANES], N>,
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
