//! The loops around a shader: from visible blocks to the colours and depths of a target.

use fearless_simd::{
    Select, Simd, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::coverage::run::ROWS;
use crate::fragment::FragmentBlock;
use crate::fragment::block::{ALL, Block, HALF_BLOCK, LANES, OneRow, SpanLine, TwoRows};
use crate::render::depth::Comparison;
use crate::render::shader::blocks::{
    BandDepths, PartBlock, PartBlocks, Patch, ShadeBlocks, ShadeOnThreads, WholeBlocks,
};
use crate::render::shader::form::{Halves, Shader};
use crate::surface::base::Divide;
use crate::viewport::MAX_SIZE;

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
