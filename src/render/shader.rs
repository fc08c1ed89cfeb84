//! Shaders: functions from a fragment to its colour, or from a block of fragments to theirs.

use fearless_simd::{Simd, f32x16};

use crate::fragment::{Block, Fragment, FragmentBlock, LANES};

/// What a shader may return: a colour of type `C`, or an `Option` of one, where `None` discards the
/// fragment, so that neither its colour nor its depth is written.
pub trait IntoColor<C> {
    /// The colour, or `None` to discard the fragment.
    fn into_color(self) -> Option<C>;
}

impl<C> IntoColor<C> for C {
    #[inline(always)]
    fn into_color(self) -> Option<C> {
        Some(self)
    }
}

impl<C> IntoColor<C> for Option<C> {
    #[inline(always)]
    fn into_color(self) -> Self {
        self
    }
}

/// All lanes of a block.
const ALL: u32 = (1 << LANES) - 1;

/// What a renderer calls for the visible pixels of a block.
pub(crate) trait Shader<const N: usize, C> {
    /// Colours the visible lanes, and says which of them were not discarded. `steps` are those of
    /// [`Block::steps`].
    fn shade<S: Simd>(
        &self,
        block: &Block<'_, N>,
        steps: f32x16<S>,
        depth: f32x16<S>,
        visible: u32,
        colors: &mut [C; LANES],
    ) -> u32;
}

/// A shader that is called for one fragment at a time.
#[derive(Debug)]
pub(crate) struct PerFragment<F>(pub(crate) F);

impl<const N: usize, C, R, F> Shader<N, C> for PerFragment<F>
where
    R: IntoColor<C>,
    F: Fn(&Fragment<'_, N>) -> R,
{
    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        block: &Block<'_, N>,
        steps: f32x16<S>,
        depth: f32x16<S>,
        visible: u32,
        colors: &mut [C; LANES],
    ) -> u32 {
        let fragments = block.fragments(depth, visible, block.params(steps));
        let mut drawn = visible;
        let mut shade = |lane: usize| match (self.0)(&fragments.fragment(lane)).into_color() {
            Some(color) => colors[lane] = color,
            None => drawn &= !(1 << lane),
        };
        if visible == ALL {
            // A plain loop, which the compiler may turn into SIMD.
            (0..LANES).for_each(shade);
        } else {
            let mut left = visible;
            while left != 0 {
                shade(left.trailing_zeros() as usize % LANES);
                left &= left - 1;
            }
        }
        drawn
    }
}

/// A shader that is called for a block of fragments.
#[derive(Debug)]
pub(crate) struct PerBlock<F>(pub(crate) F);

impl<const N: usize, C, F> Shader<N, C> for PerBlock<F>
where
    C: Copy,
    F: Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]),
{
    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        block: &Block<'_, N>,
        steps: f32x16<S>,
        depth: f32x16<S>,
        visible: u32,
        colors: &mut [C; LANES],
    ) -> u32 {
        let mut fragments = block.fragments(depth, visible, block.params(steps));
        let mut shaded = *colors;
        (self.0)(&mut fragments, &mut shaded);
        // What the shader made is stored here as a whole: only then does the compiler see that its
        // loop over the lanes can be SIMD, whatever becomes of each lane.
        let shaded = *std::hint::black_box(&shaded);
        let drawn = fragments.visible & visible;
        if drawn == ALL {
            *colors = shaded;
        } else {
            for lane in 0..LANES {
                if drawn >> lane & 1 != 0 {
                    colors[lane] = shaded[lane];
                }
            }
        }
        drawn
    }
}

/// No shader: depth alone is drawn.
#[derive(Debug)]
pub(crate) struct DepthOnly;

impl<const N: usize, C> Shader<N, C> for DepthOnly {
    #[inline(always)]
    fn shade<S: Simd>(
        &self,
        _: &Block<'_, N>,
        _: f32x16<S>,
        _: f32x16<S>,
        visible: u32,
        _: &mut [C; LANES],
    ) -> u32 {
        visible
    }
}
