//! Shaders: functions from a fragment to its colour, or from a block of fragments to theirs.

use std::ops::Add;

use fearless_simd::{Simd, SimdMask, f32x16, mask32x8};
use glam::Vec4;

use crate::fragment::{ALL, Block, Fragment, FragmentBlock, HALF, LANES, Source, SpanBlock};
use crate::polygon::Method;

/// What a shader may return for a pixel of colour `C`: a colour, which replaces the pixel's; an
/// `Option` of one, where `None` discards the fragment; or a colour in [`Over`] or [`Plus`], which is
/// blended with the pixel's.
///
/// ```
/// use glam::{Vec4, vec4};
/// use polyscan::{Framebuffer, Vertex, ZBuffer, render::Over};
///
/// let mut frame = Framebuffer::new(1, 1, vec4(0.0, 0.0, 1.0, 1.0))?;
/// let mut renderer = ZBuffer::new(frame.viewport());
/// let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// // Red glass that lets half of the light through.
/// renderer.draw(&mut frame, &quad, |_| Over(vec4(0.5, 0.0, 0.0, 0.5)));
/// assert_eq!(frame.color(), [vec4(0.5, 0.0, 0.5, 1.0)]);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
pub trait Paint<C> {
    /// Changes the pixel's colour, or returns `false` to discard the fragment, so that neither
    /// colour nor depth is written.
    fn paint(self, pixel: &mut C) -> bool;
}

impl<C> Paint<C> for C {
    #[inline(always)]
    fn paint(self, pixel: &mut C) -> bool {
        *pixel = self;
        true
    }
}

impl<C> Paint<C> for Option<C> {
    #[inline(always)]
    fn paint(self, pixel: &mut C) -> bool {
        self.is_some_and(|color| color.paint(pixel))
    }
}

/// A colour that lies over the pixel's: Porter and Duff's "over" ("Compositing Digital Images",
/// 1984, section 4.3), in linear light premultiplied by the alpha in `w`. The pixel's colour shows
/// through by 1 - alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Over(pub Vec4);

impl Paint<Vec4> for Over {
    #[inline(always)]
    fn paint(self, pixel: &mut Vec4) -> bool {
        *pixel = self.0 + *pixel * (1.0 - self.0.w);
        true
    }
}

/// A colour that is added to the pixel's: Porter and Duff's "plus", for light that is emitted. The
/// order of drawing does not matter but for rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plus<C>(pub C);

impl<C: Copy + Add<Output = C>> Paint<C> for Plus<C> {
    #[inline(always)]
    fn paint(self, pixel: &mut C) -> bool {
        *pixel = *pixel + self.0;
        true
    }
}

/// The colours of a block, which may lie in two rows.
pub(crate) type Halves<'a, C> = [&'a mut [C; HALF]; 2];

/// What a renderer calls for the visible pixels of a block.
pub(crate) trait Shader<const N: usize, C> {
    /// Colours the lanes of a block that are all visible, and says which of them were not discarded.
    /// `method` is as in [`Block::fragments`].
    fn shade_all<S: Simd>(
        &self,
        block: &SpanBlock<'_, '_, S, N>,
        method: Method,
        depth: f32x16<S>,
        colors: &mut [C; LANES],
    ) -> u32;

    /// The same where some lanes are visible and the others have to keep their colours.
    fn shade<'s, S: Simd>(
        &self,
        block: &Block<S, impl Source<'s, N>>,
        method: Method,
        depth: f32x16<S>,
        visible: u32,
        colors: Halves<'_, C>,
    ) -> u32;
}

/// A shader that is called for one fragment at a time.
#[derive(Debug)]
pub(crate) struct PerFragment<F>(pub(crate) F);

impl<const N: usize, C, R, F> Shader<N, C> for PerFragment<F>
where
    R: Paint<C>,
    F: Fn(&Fragment<'_, N>) -> R,
{
    #[inline(always)]
    fn shade_all<S: Simd>(
        &self,
        block: &SpanBlock<'_, '_, S, N>,
        method: Method,
        depth: f32x16<S>,
        colors: &mut [C; LANES],
    ) -> u32 {
        let fragments = block.fragments(depth, ALL, method);
        let mut drawn = ALL;
        // A plain loop, which the compiler may turn into SIMD.
        for (lane, color) in colors.iter_mut().enumerate() {
            let painted = (self.0)(&fragments.fragment(lane)).paint(color);
            drawn &= !(u32::from(!painted) << lane);
        }
        drawn
    }

    #[inline(always)]
    fn shade<'s, S: Simd>(
        &self,
        block: &Block<S, impl Source<'s, N>>,
        method: Method,
        depth: f32x16<S>,
        visible: u32,
        colors: Halves<'_, C>,
    ) -> u32 {
        let fragments = block.fragments(depth, visible, method);
        let (mut drawn, mut left) = (visible, visible);
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let color = &mut colors[lane / HALF][lane % HALF];
            let painted = (self.0)(&fragments.fragment(lane)).paint(color);
            drawn &= !(u32::from(!painted) << lane);
        }
        drawn
    }
}

/// Within one cache line, if it fits: what is stored there can be loaded at once.
#[repr(align(64))]
struct Aligned<T>(T);

/// A shader that is called for a block of fragments.
#[derive(Debug)]
pub(crate) struct PerBlock<F>(pub(crate) F);

impl<const N: usize, C, F> Shader<N, C> for PerBlock<F>
where
    C: Copy,
    F: Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]),
{
    #[inline(always)]
    fn shade_all<S: Simd>(
        &self,
        block: &SpanBlock<'_, '_, S, N>,
        method: Method,
        depth: f32x16<S>,
        colors: &mut [C; LANES],
    ) -> u32 {
        let mut fragments = block.fragments(depth, ALL, method);
        let before = *colors;
        (self.0)(&mut fragments, colors);
        let drawn = fragments.visible & ALL;
        if drawn != ALL {
            for lane in (0..LANES).filter(|lane| drawn >> lane & 1 == 0) {
                colors[lane] = before[lane];
            }
        }
        drawn
    }

    #[inline(always)]
    fn shade<'s, S: Simd>(
        &self,
        block: &Block<S, impl Source<'s, N>>,
        method: Method,
        depth: f32x16<S>,
        visible: u32,
        colors: Halves<'_, C>,
    ) -> u32 {
        let mut fragments = block.fragments(depth, visible, method);
        let [lower, upper] = colors;
        let mut shaded = Aligned(std::array::from_fn(
            #[inline(always)]
            |lane| if lane < HALF { lower[lane] } else { upper[lane - HALF] },
        ));
        (self.0)(&mut fragments, &mut shaded.0);
        // What the shader made is stored here as a whole: only then does the compiler see that its
        // loop over the lanes can be SIMD, whatever becomes of each lane.
        let shaded = std::hint::black_box(&shaded).0;
        let drawn = fragments.visible & visible;
        choose(block.simd(), drawn, &shaded[..HALF], lower);
        choose(block.simd(), drawn >> HALF, &shaded[HALF..], upper);
        drawn
    }
}

/// Replaces the colours of the lanes that were drawn, in half a block.
#[inline(always)]
fn choose<S: Simd, C: Copy>(simd: S, drawn: u32, new: &[C], colors: &mut [C; HALF]) {
    // A loop over three arrays becomes one vector instruction that chooses.
    let mask = <[i32; HALF]>::from(mask32x8::from_bitmask(simd, (drawn & (ALL >> HALF)).into()));
    let old = *colors;
    for lane in 0..HALF {
        colors[lane] = if mask[lane] != 0 { new[lane] } else { old[lane] };
    }
}

/// No shader: depth alone is drawn.
#[derive(Debug)]
pub(crate) struct DepthOnly;

impl<const N: usize, C> Shader<N, C> for DepthOnly {
    #[inline(always)]
    fn shade_all<S: Simd>(
        &self,
        _: &SpanBlock<'_, '_, S, N>,
        _: Method,
        _: f32x16<S>,
        _: &mut [C; LANES],
    ) -> u32 {
        ALL
    }

    #[inline(always)]
    fn shade<'s, S: Simd>(
        &self,
        _: &Block<S, impl Source<'s, N>>,
        _: Method,
        _: f32x16<S>,
        visible: u32,
        _: Halves<'_, C>,
    ) -> u32 {
        visible
    }
}
