//! From spans to pixels: the inner loops of the renderers.
//!
//! Spans come in, of convex polygons in groups of rows. The pixels of long ones are taken in blocks
//! that begin at cache lines, those of short ones in blocks with a half in each of two rows; each
//! block is tested against the stored depths, and shaded if one of its pixels is seen.
//!
//! All of a loop must be inlined into a function for the instructions that `simd` stands for, or it
//! is not compiled for them. And a shader is compiled once for each place that calls it, so these are
//! few: one for the short spans of a group, two in a function for long spans, and two that will do
//! for all that is less usual.

use std::ops::Range;

use fearless_simd::{
    Select, Simd, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::edge_table::ROWS;
use crate::fragment::{ALL, Block, HALF, LANES, Source, SpanBlock};
use crate::polygon::Method;
use crate::render::coarse_depth::{CoarseDepth, TILE_WIDTH};
use crate::render::framebuffer::Band;
use crate::render::shader::{Halves, Shader};
use crate::render::z_buffer::{DepthSource, DepthTest};
use crate::scan::{SpanGroup, SpanGroups, SpanPair, Spans};
use crate::span::Span;

/// What to do with fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Raster {
    pub(crate) test: DepthTest,
    pub(crate) write: bool,
    pub(crate) source: DepthSource,
}

impl Raster {
    /// Prepares a coarse depth for a band; whether it helps.
    pub(crate) fn restart<C>(self, coarse: &mut CoarseDepth, band: &Band<'_, C>) -> bool {
        self.source == DepthSource::Z && coarse.restart(self.test, band.width(), band.rows().len())
    }

    /// The usual settings, for which the code is specialised.
    const USUAL: Self = Self { test: DepthTest::Less, write: true, source: DepthSource::Z };

    /// Draws spans into a band of the framebuffer that holds all of their rows.
    #[inline(always)]
    pub(crate) fn draw<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        spans: Spans<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        match self.groups(simd, &spans) {
            Some(groups) => self.draw_groups(simd, groups, band, shader),
            None => self.draw_rest(simd, spans, band, shader),
        }
    }

    /// The spans in groups of rows, if they can be drawn as such.
    #[inline(always)]
    pub(crate) fn groups<'a, S: Simd, const N: usize>(
        self,
        simd: S,
        spans: &Spans<'a, N>,
    ) -> Option<SpanGroups<'a, N>> {
        let is_usual = self.takes_groups(simd) && spans.polygon.method != Method::Other;
        if is_usual { spans.groups() } else { None }
    }

    /// Whether what is drawn with these settings can be drawn in groups of rows. Without SIMD there is
    /// nothing to gain by that.
    #[inline(always)]
    pub(crate) fn takes_groups<S: Simd>(self, simd: S) -> bool {
        self == Self::USUAL && !simd.level().is_fallback()
    }

    /// Draws spans in groups of rows, where that can be done.
    #[inline(always)]
    pub(crate) fn draw_groups<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        groups: SpanGroups<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let method = groups.polygon.method;
        groups.for_each(
            #[inline(always)]
            |group| match method {
                Method::Perspective => {
                    self.draw_group::<Perspective, _, _, N>(simd, group, band, shader);
                }
                _ => self.draw_group::<Constant, _, _, N>(simd, group, band, shader),
            },
        );
    }

    /// Draws what cannot.
    #[inline(never)]
    pub(crate) fn draw_rest<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        spans: Spans<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        if simd.level().is_fallback()
            && self == Self::USUAL
            && spans.polygon.method == Method::Perspective
        {
            spans.for_each(|span| self.draw_one::<Perspective, _, _, N>(simd, span, band, shader));
        } else {
            spans.for_each(|span| self.draw_one::<AnyCase, _, _, N>(simd, span, band, shader));
        }
    }

    /// Draws any span.
    pub(crate) fn draw_any<S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        span: Span<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        self.draw_one::<AnyCase, _, _, N>(simd, span, band, shader);
    }

    #[inline(never)]
    fn draw_one<K: Case, S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        span: Span<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.draw_span::<K, _, _, N>(simd, &span, band, shader),
        );
    }

    /// Draws the spans of a group of rows. Short ones are drawn here, by blocks that have a half in
    /// each of two rows: a small triangle has few pixels in a row.
    #[inline(always)]
    fn draw_group<K: Case, S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        group: &SpanGroup<'_, '_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        if !group.has_planes() {
            for row in 0..group.len() {
                self.draw_span_of::<K, _, _, N>(simd, (group, row), band, shader);
            }
            return;
        }
        let (x, y) = group.polygon.corner;
        let first = band.index(x, y + group.y());
        let (mut begin, mut lanes) = ([0; ROWS], [0; ROWS]);
        for (row, begin) in begin.iter_mut().enumerate() {
            // The viewport may begin left of the band.
            *begin = first.wrapping_add(row * band.width()).wrapping_add(group.start[row] as usize);
        }
        for (lanes, width) in lanes.iter_mut().zip(&group.width) {
            *lanes = 1u32.wrapping_shl(*width as u32) - 1;
        }
        for row in (0..ROWS).step_by(2) {
            if row >= group.len() {
                return;
            }
            let places = [group.place(row), group.place(row + 1)];
            let pair = SpanPair { group, row, places: &places };
            let [width, next_width] = pair.of(&group.width);
            if width.max(next_width) > HALF as i32 {
                for row in [row, row + 1] {
                    self.draw_span_of::<K, _, _, N>(simd, (group, row), band, shader);
                }
                continue;
            }
            let [lower, upper] = pair.of(&lanes);
            if lower | upper == 0 {
                continue;
            }
            let mut at = pair.of(&begin);
            // A half without pixels lies beside the other.
            if lower == 0 {
                at[0] = at[1].wrapping_sub(HALF);
            }
            if upper == 0 {
                at[1] = at[0] + HALF;
            }
            let (raster, method) = K::of(self, group.polygon.method);
            let block = Block::pair(simd, pair);
            raster.draw_part(&block, method, lower | upper << HALF, at, band, shader);
        }
    }

    /// Draws a long span of a group of rows. It is taken out of the group here: made by the caller, the
    /// compiler would gather its values for every row, long or not.
    #[inline(never)]
    fn draw_span_of<K: Case, S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        (group, row): (&SpanGroup<'_, '_, N>, usize),
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if let Some(span) = group.span(row) {
                    self.draw_span::<K, _, _, N>(simd, &span, band, shader);
                }
            },
        );
    }

    /// Draws a span, if it is very long without the parts that the coarse depth hides.
    #[inline(always)]
    fn draw_span<K: Case, S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        span: &Span<'_, N>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let first = band.column(span.column());
        let end = first + span.x.len();
        let mut visible = first..end;
        loop {
            if end - first > TILE_WIDTH
                && let Some(coarse) = &mut band.coarse
            {
                let depth = |column: usize| span.depth_at((column - first) as i32);
                let row = (span.y() - band.first) as usize;
                visible = coarse.next_visible(band.depth, row, visible.start..end, depth);
            }
            if !visible.is_empty() {
                self.draw_columns::<K, _, _, N>(simd, span, &visible, band, shader);
            }
            if visible.end == end {
                return;
            }
            visible = visible.end..end;
        }
    }

    /// Draws some columns of a span, counted from the left of the band: a first block that may have
    /// lanes before them, then whole ones, then what is left.
    #[inline(always)]
    fn draw_columns<K: Case, S: Simd, C: Copy, const N: usize>(
        self,
        simd: S,
        span: &Span<'_, N>,
        columns: &Range<usize>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let (raster, method) = K::of(self, span.place.polygon.method);
        let row = band.row(span.y());
        let (start, end) = (row + columns.start, row + columns.end);
        let before = (start + band.line_offset) % LANES;
        let offset = columns.start - band.column(span.column());
        let mut block = Block::new(simd, span, span.x.start + offset as i32 - before as i32);
        let mut at = start.wrapping_sub(before);
        let mut lanes = ALL << before & ALL;
        loop {
            let left = end.wrapping_sub(at);
            if left < LANES {
                lanes &= ALL >> (LANES - left);
            }
            raster.draw_part(&block, method, lanes, [at, at.wrapping_add(HALF)], band, shader);
            if left <= LANES {
                return;
            }
            at = at.wrapping_add(LANES);
            block.advance();
            at += raster.draw_whole_blocks(&mut block, method, at..end, band, shader);
            if at == end {
                return;
            }
            // What is left is the end, or a block that is seen in part.
            lanes = ALL;
        }
    }

    /// Draws blocks, the first of which is given, as long as all of their pixels are seen or none;
    /// how many pixels that are. Leaves the block after them.
    #[inline(always)]
    fn draw_whole_blocks<S: Simd, C: Copy, const N: usize>(
        self,
        block: &mut SpanBlock<'_, '_, S, N>,
        method: Method,
        pixels: Range<usize>,
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) -> usize {
        let colors = band.color.get_mut(pixels.clone()).unwrap_or_default();
        let depths = band.depth.get_mut(pixels).unwrap_or_default();
        let mut done = 0;
        for (colors, depths) in colors.as_chunks_mut().0.iter_mut().zip(depths.as_chunks_mut().0) {
            let depth = self.depth(block);
            let stored = f32x16::simd_from(block.simd(), *depths);
            let visible = self.test.passes(depth, stored) & ALL;
            if visible == ALL {
                let drawn = shader.shade_all(block, method, depth, colors);
                if self.write {
                    *depths = chosen(drawn, depth, stored).into();
                }
            } else if visible != 0 {
                break;
            }
            done += LANES;
            block.advance();
        }
        done
    }

    /// Draws a block that may have lanes outside the span, whose halves begin at `at`. It may reach
    /// over the sides of the framebuffer: into the next row, whose pixels are put back, or out of the
    /// band.
    #[inline(always)]
    fn draw_part<'s, S: Simd, C: Copy, const N: usize>(
        self,
        block: &Block<S, impl Source<'s, N>>,
        method: Method,
        lanes: u32,
        at: [usize; 2],
        band: &mut Band<'_, C>,
        shader: &impl Shader<N, C>,
    ) {
        let mut copy = None;
        let (colors, depths) = match (halves_at(band.color, at), halves_at(band.depth, at)) {
            (Some(colors), Some(depths)) => (colors, depths),
            _ => {
                let (Some(first), Some(second)) = (band.copy(at[0]), band.copy(at[1])) else {
                    return;
                };
                let [(colors, depths), (more_colors, more_depths)] = copy.insert([first, second]);
                ([colors, more_colors], [depths, more_depths])
            }
        };
        self.draw_block(block, method, lanes, colors, depths, shader);
        if let Some(halves) = &copy {
            // In a narrow frame the first reaches into the second, which is right then.
            for (at, (colors, depths)) in at.into_iter().zip(halves) {
                band.put_back(at, colors, depths);
            }
        }
    }

    /// The depth test, and if a lane passes, the shader.
    #[inline(always)]
    fn draw_block<'s, S: Simd, C: Copy, const N: usize>(
        self,
        block: &Block<S, impl Source<'s, N>>,
        method: Method,
        lanes: u32,
        colors: Halves<'_, C>,
        [lower, upper]: Halves<'_, f32>,
        shader: &impl Shader<N, C>,
    ) {
        let simd = block.simd();
        let depth = self.depth(block);
        let half = |depths: &[f32; HALF]| f32x8::simd_from(simd, *depths);
        let stored = half(lower).combine(half(upper));
        let visible = self.test.passes(depth, stored) & lanes;
        if visible == 0 {
            return;
        }
        let drawn = shader.shade(block, method, depth, visible, colors);
        if self.write {
            let (new_lower, new_upper) = chosen(drawn, depth, stored).split();
            *lower = new_lower.into();
            *upper = new_upper.into();
        }
    }

    /// What is compared and stored.
    #[inline(always)]
    fn depth<'s, S: Simd, const N: usize>(self, block: &Block<S, impl Source<'s, N>>) -> f32x16<S> {
        match self.source {
            DepthSource::Z => block.depth(),
            DepthSource::InverseW => block.depth_by_inv_w(),
        }
    }
}

/// A case that the code is compiled for on its own.
trait Case {
    /// The settings and the method; constants where the case has only one, or where one will do for
    /// all.
    fn of(raster: Raster, method: Method) -> (Raster, Method);
}

/// The usual settings, and all parameters in perspective.
struct Perspective;

/// The usual settings, and equal w.
struct Constant;

struct AnyCase;

impl Case for Perspective {
    #[inline(always)]
    fn of(_: Raster, _: Method) -> (Raster, Method) {
        (Raster::USUAL, Method::Perspective)
    }
}

impl Case for Constant {
    #[inline(always)]
    fn of(_: Raster, _: Method) -> (Raster, Method) {
        (Raster::USUAL, Method::Constant)
    }
}

impl Case for AnyCase {
    #[inline(always)]
    fn of(raster: Raster, _: Method) -> (Raster, Method) {
        (raster, Method::Other)
    }
}

/// The new depths of the lanes that were drawn, the old ones of the others.
#[inline(always)]
fn chosen<S: Simd>(drawn: u32, new: f32x16<S>, old: f32x16<S>) -> f32x16<S> {
    if drawn == ALL {
        return new;
    }
    mask32x16::from_bitmask(new.simd, drawn.into()).select(new, old)
}

/// The halves of a block that begin at `at`, if they are whole and apart.
#[inline(always)]
fn halves_at<T>(pixels: &mut [T], at: [usize; 2]) -> Option<Halves<'_, T>> {
    let (first, second) = pixels.split_at_mut_checked(at[1])?;
    Some([first.get_mut(at[0]..)?.first_chunk_mut()?, second.first_chunk_mut()?])
}
