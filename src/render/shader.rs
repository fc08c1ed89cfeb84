//! From visible blocks to colours: the loops around a shader.
//!
//! This is all of a renderer that knows the shader's type, the colours' type and the number of
//! parameters, so it is all that is compiled with a user's program, once for each SIMD level. Everything
//! before it is compiled once, in the library. The two meet at [`ShadeBlocks`], behind `dyn`: a call for
//! the blocks of some rows, not for each, so that its cost is small beside the pixels'.

use fearless_simd::{Simd, SimdMask, mask32x8};

use crate::coverage::run::{ROWS, RunGroup};
use crate::fragment::block::{ALL, Block, HALF_BLOCK, LANES};
use crate::fragment::{Fragment, FragmentBlock};
use crate::render::paint::Paint;
use crate::surface::base::Divide;
use crate::surface::rows::{RowLine, RowValues, SurfaceView};

/// The rows of a polygon that are being drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch<'a> {
    pub(crate) surface: &'a SurfaceView<'a>,
    pub(crate) runs: &'a RunGroup,
    pub(crate) values: &'a RowValues,
}

/// Two halves of a block, some lanes of which are visible.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PartBlock {
    /// The lanes that are visible; after shading, those that were drawn.
    pub(crate) visible: u32,
    /// The row of each half in its group.
    pub(crate) rows: [usize; 2],
    /// How far the first pixel of each half is from the one where the row's values are given.
    pub(crate) steps: [f32; 2],
    /// The first pixel of each half in the target.
    pub(crate) pixels: [usize; 2],
}

/// Neighbouring blocks in a row, all lanes of which are visible.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WholeBlocks {
    pub(crate) row: usize,
    /// How far the first pixel is from the one where the row's values are given.
    pub(crate) steps: f32,
    /// The first pixel in the target.
    pub(crate) pixel: usize,
}

/// What shades the blocks that a raster finds visible.
pub(crate) trait ShadeBlocks {
    /// Shades blocks of which all lanes are visible: one for each element of `drawn`, which is set to
    /// the lanes that were not discarded.
    fn shade_whole(&mut self, patch: &Patch<'_>, blocks: WholeBlocks, drawn: &mut [u32]);

    /// Shades blocks of which some lanes are visible, and leaves in each those that were not discarded.
    fn shade_parts(&mut self, patch: &Patch<'_>, blocks: &mut [PartBlock]);

    /// Brings the colours of pixels into the cache.
    fn prefetch(&self, pixels: std::ops::Range<usize>);

    /// Whether there is nothing to shade: depth alone is drawn.
    fn is_depth_only(&self) -> bool {
        false
    }
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

/// A shader that is called for one fragment at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PerFragment<F>(pub(crate) F);

impl<const N: usize, C, R, F> Shader<C, N> for PerFragment<F>
where
    R: Paint<C>,
    F: FnMut(&Fragment<'_, N>) -> R,
{
    #[inline(always)]
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32 {
        let mut drawn = ALL;
        // A plain loop, which the compiler may turn into SIMD.
        for (lane, color) in colors.iter_mut().enumerate() {
            let painted = (self.0)(&block.fragment(lane)).paint(color);
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
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let color = &mut colors[lane / HALF_BLOCK][lane % HALF_BLOCK];
            let painted = (self.0)(&block.fragment(lane)).paint(color);
            drawn &= !(u32::from(!painted) << lane);
        }
        drawn
    }
}

/// Within one cache line, if it fits: what is stored there can be loaded at once.
#[repr(align(64))]
struct Aligned<T>(T);

/// A shader that is called for a block of fragments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PerBlock<F>(pub(crate) F);

impl<const N: usize, C, F> Shader<C, N> for PerBlock<F>
where
    C: Copy,
    F: FnMut(&mut FragmentBlock<'_, N>, &mut [C; LANES]),
{
    #[inline(always)]
    fn whole(&mut self, block: &mut FragmentBlock<'_, N>, colors: &mut [C; LANES]) -> u32 {
        let before = *colors;
        (self.0)(block, colors);
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
        (self.0)(block, &mut shaded.0);
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
fn choose<S: Simd, C: Copy>(simd: S, drawn: u32, new: &[C], colors: &mut [C; HALF_BLOCK]) {
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
    fn shade_whole(&mut self, patch: &Patch<'_>, blocks: WholeBlocks, drawn: &mut [u32]) {
        let simd = self.simd;
        match patch.surface.base.divide {
            Divide::PerPixel => simd.vectorize(
                #[inline(always)]
                || self.whole::<true>(patch, blocks, drawn),
            ),
            Divide::Never => simd.vectorize(
                #[inline(always)]
                || self.whole::<false>(patch, blocks, drawn),
            ),
            Divide::Mixed => self.whole_in_parts(patch, blocks, drawn),
        }
    }

    fn shade_parts(&mut self, patch: &Patch<'_>, blocks: &mut [PartBlock]) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || self.parts(patch, blocks),
        );
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
    /// Shades whole blocks of a polygon all of whose parameters are divided, or none.
    #[inline(always)]
    fn whole<const DIVIDES: bool>(
        &mut self,
        patch: &Patch<'_>,
        blocks: WholeBlocks,
        drawn: &mut [u32],
    ) {
        let Patch { surface, runs, values } = *patch;
        let Some(s) = values.s.first_chunk::<N>() else { return };
        // In registers or at fixed places, whatever is stored in between.
        let row = blocks.row % ROWS;
        let one = |line: &RowLine| RowLine { at: [line.at[row]; ROWS], delta: line.delta };
        let mut lines = [RowLine::default(); N];
        for (line, value) in lines.iter_mut().zip(s) {
            *line = one(value);
        }
        let inv_w = one(&values.inv_w);
        let mut block = Block::in_row(self.simd, 0, blocks.steps);
        let mut x = values.x[row] + blocks.steps as i32;
        let start = blocks.pixel.wrapping_sub(self.pixels_before);
        let colors = self.colors.get_mut(start..).unwrap_or_default().as_chunks_mut().0;
        for (colors, drawn) in colors.iter_mut().zip(drawn) {
            let halves = [(x, row), (x + HALF_BLOCK as i32, row)];
            let mut fragments = FragmentBlock::new(surface, runs, halves, ALL);
            fragments.depth = block.depth(surface, values).into();
            let FragmentBlock { w, params, .. } = &mut fragments;
            if DIVIDES {
                block.divided(surface, &inv_w, &lines, w, params);
            } else {
                block.undivided(&lines, params);
            }
            *drawn = self.shader.whole(&mut fragments, colors);
            block.advance();
            x += LANES as i32;
        }
    }

    /// Shades whole blocks as if only parts of them were visible: no third copy of the shader for what
    /// is rare.
    #[cold]
    fn whole_in_parts(&mut self, patch: &Patch<'_>, blocks: WholeBlocks, drawn: &mut [u32]) {
        let WholeBlocks { row, mut steps, mut pixel } = blocks;
        let half = HALF_BLOCK as f32;
        for drawn in drawn {
            let mut part = [PartBlock {
                visible: ALL,
                rows: [row; 2],
                steps: [steps, steps + half],
                pixels: [pixel, pixel + HALF_BLOCK],
            }];
            self.shade_parts(patch, &mut part);
            *drawn = part[0].visible;
            steps += LANES as f32;
            pixel += LANES;
        }
    }

    #[inline(always)]
    fn parts(&mut self, patch: &Patch<'_>, blocks: &mut [PartBlock]) {
        let Patch { surface, runs, values } = *patch;
        let Some(s) = values.s.first_chunk::<N>() else { return };
        for part in blocks {
            let block = Block::in_two_rows(self.simd, part.rows, part.steps);
            let column = |half: usize| {
                (values.x[part.rows[half] % ROWS] + part.steps[half] as i32, part.rows[half])
            };
            let halves = [column(0), column(1)];
            let mut fragments = FragmentBlock::new(surface, runs, halves, part.visible);
            fragments.depth = block.depth(surface, values).into();
            let FragmentBlock { w, params, .. } = &mut fragments;
            if surface.base.divide == Divide::PerPixel {
                block.divided(surface, &values.inv_w, s, w, params);
            } else {
                block.any(surface, &values.inv_w, s, w, params);
            }
            let pixels = part.pixels.map(|pixel| pixel.wrapping_sub(self.pixels_before));
            part.visible = match halves_at(self.colors, pixels) {
                Some(colors) => self.shader.part(self.simd, &mut fragments, colors),
                None => self.part_at_end(&mut fragments, pixels),
            };
        }
    }

    /// Shades a block that reaches over the ends of the colours, or over itself, as in narrow pictures.
    #[cold]
    fn part_at_end(&mut self, block: &mut FragmentBlock<'_, N>, pixels: [usize; 2]) -> u32 {
        let Some(&any) = self.colors.first() else { return 0 };
        let color = |pixel: usize| self.colors.get(pixel).copied().unwrap_or(any);
        let [mut lower, mut upper] =
            pixels.map(|first| std::array::from_fn(|lane| color(first.wrapping_add(lane))));
        let drawn = self.shader.part(self.simd, block, [&mut lower, &mut upper]);
        for (half, colors) in [lower, upper].iter().enumerate() {
            for (lane, color) in colors.iter().enumerate() {
                if drawn >> (half * HALF_BLOCK + lane) & 1 != 0
                    && let Some(pixel) = self.colors.get_mut(pixels[half].wrapping_add(lane))
                {
                    *pixel = *color;
                }
            }
        }
        drawn
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
pub(crate) struct DepthOnly;

impl ShadeBlocks for DepthOnly {
    fn shade_whole(&mut self, _: &Patch<'_>, _: WholeBlocks, drawn: &mut [u32]) {
        drawn.fill(ALL);
    }

    fn shade_parts(&mut self, _: &Patch<'_>, _: &mut [PartBlock]) {}

    fn prefetch(&self, _: std::ops::Range<usize>) {}

    fn is_depth_only(&self) -> bool {
        true
    }
}

impl ShadeOnThreads for DepthOnly {
    fn split(
        &mut self,
        _: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    ) {
        f(&mut Self, &mut Self);
    }
}
