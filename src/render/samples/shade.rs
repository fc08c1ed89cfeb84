//! From blocks whose covered samples are known to colours: the loops around a shader, for pixels of several
//! samples. This is all that knows the shader's type.

use std::marker::PhantomData;
use std::ops::Range;

use fearless_simd::{
    Select, Simd, SimdBase, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::coverage::run::ROWS;
use crate::fragment::FragmentBlock;
use crate::fragment::block::{ALL, AtCentres, Block, HALF_BLOCK, LANES, Lanes, TwoRows};
use crate::render::depth::Comparison;
use crate::render::paint::Paint;
use crate::render::samples::frame::Tile;
use crate::render::shader::{
    Aligned, BandDepths, BlockFunction, FragmentFunction, MOST_SAMPLES, NEST, PartBlocks, Patch,
    PerBlock, PerFragment, SampleBlock, SampleBlocks, ShadeBlocks, ShadeOnThreads, Shader,
    WholeBlocks, choose, rarely,
};
use crate::surface::rows::{RowValues, SurfaceView};

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
                if drawn == 0 {
                    continue;
                }
                if let Some(colors) = self.half(sample, half) {
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

/// A shader with the samples that it paints: those of a target, or of some rows of it.
#[derive(Debug)]
pub(crate) struct SamplePainter<'a, S, C, K, const N: usize> {
    pub(crate) simd: S,
    pub(crate) colors: &'a mut [C],
    pub(crate) tiles: &'a mut [Tile],
    /// How many samples a row has.
    pub(crate) row: usize,
    /// How many rows of the target come before these.
    pub(crate) rows_before: usize,
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
        let Self { simd, row, .. } = *self;
        let rows = band.pixels_before / row.max(1) - self.rows_before;
        let tiles_in_row = self.tiles.len() / (self.colors.len() / row.max(1)).max(1);
        let Some(colors) = self.colors.get_mut(rows * row..) else { return };
        let Some(tiles) = self.tiles.get_mut(rows * tiles_in_row..) else { return };
        let memory = Memory { colors, tiles, depths: band.depths, set: &blocks };
        let shader = &mut self.shader;
        simd.vectorize(
            #[inline(always)]
            || draw(simd, patch, memory, shader),
        );
    }
}

/// The samples of a band, and how they are drawn to.
struct Memory<'m, C> {
    colors: &'m mut [C],
    tiles: &'m mut [Tile],
    depths: &'m mut [f32],
    set: &'m SampleBlocks<'m>,
}

#[inline(always)]
fn draw<S: Simd, C: Copy, K: SampleShader<C, N>, const N: usize>(
    simd: S,
    patch: &Patch<'_>,
    mut memory: Memory<'_, C>,
    shader: &mut K,
) {
    let set = memory.set;
    let Patch { surface, runs, values } = *patch;
    let Some(s) = values.s.first_chunk::<N>() else { return };
    let count = set.places.len().min(MOST_SAMPLES);
    let mut visible = [0; MOST_SAMPLES];
    let (mut blocks, mut part, mut whole_tiles) = (set.blocks.iter(), SampleBlock::default(), 0);
    // A call within two loops the compiler takes to be hot, and inlines larger shaders there.
    loop {
        for _ in 0..NEST {
            if whole_tiles > 1 {
                whole_tiles -= 1;
                part.advance();
            } else {
                let Some(next) = blocks.next() else {
                    rarely();
                    return;
                };
                (part, whole_tiles) = (*next, next.whole_tiles);
            }
            if K::IS_BY_PIXEL && whole_tiles > 0 {
                whole_tiles -=
                    draw_tiles(simd, patch, &mut memory, (&mut part, whole_tiles), shader);
                if whole_tiles == 0 {
                    continue;
                }
            }
            let block = Block::in_two_rows(simd, part.rows, part.steps);
            let column = |half: usize| {
                (values.x[part.rows[half] % ROWS] + part.steps[half] as i32, part.rows[half])
            };
            memory.make_apart(&part);
            let tested = (surface, values, &mut visible[..count]);
            let any = memory.test(&block, &part, tested);
            if any == 0 {
                continue;
            }
            let mut fragments = FragmentBlock::new(surface, runs, [column(0), column(1)], any);
            let (places, mut depth) = (places(&part, set), [0.0; LANES]);
            block.off_centre(surface, values, s, &places, (&mut depth, fragments.found()));
            fragments.depth = depth;
            let (colors, stride) = (&mut *memory.colors, set.stride);
            let visible = &mut visible[..count];
            let samples = SampleColors { colors, at: part.at, stride, visible: &mut *visible };
            shader.shade(simd, &mut fragments, samples);
            if set.writes {
                memory.store(&block, &part, (surface, values, visible));
            }
        }
    }
}

/// Draws tiles whose samples are all covered, as long as all of these are visible. Returns how many it
/// has drawn, and leaves the block at the next.
#[inline(always)]
fn draw_tiles<S: Simd, C: Copy, K: SampleShader<C, N>, const N: usize>(
    simd: S,
    patch: &Patch<'_>,
    memory: &mut Memory<'_, C>,
    (part, count): (&mut SampleBlock, usize),
    shader: &mut K,
) -> usize {
    let Patch { surface, runs, values } = *patch;
    let Some(along) = AtCentres::<N>::new(surface, values, part.rows[0]) else { return 0 };
    let mut block = Block::in_row(simd, part.rows[0], part.steps[0]);
    let row = part.rows[0] % ROWS;
    let mut done = 0;
    while done < count {
        for _ in 0..NEST.min(count - done) {
            let depth = block.along(&along.z);
            let colors = memory.colors.get_mut(part.at[0]..).and_then(<[C]>::first_chunk_mut);
            let Some(colors) = colors else {
                rarely();
                return done;
            };
            let x = values.x[row] + part.steps[0] as i32;
            let halves = [(x, row), (x + HALF_BLOCK as i32, row)];
            if !is_whole_visible(
                (memory.set, memory.tiles, memory.depths),
                patch,
                part,
                (depth, K::REPLACES),
            ) {
                rarely();
                return done;
            }
            let mut fragments = FragmentBlock::new(surface, runs, halves, ALL);
            block.at_centres(surface, &along, fragments.found());
            fragments.depth = block.depth_along(&along.z, surface.base.z_range).into();
            let drawn = shader.whole(&mut fragments, colors) & ALL;
            memory.store_whole(part, depth, drawn);
            done += 1;
            part.advance();
            block.advance();
        }
    }
    done
}

impl<C: Copy> Memory<'_, C> {
    /// Stores the depths of a tile's pixels that were drawn, if all were as a whole.
    #[inline(always)]
    fn store_whole<S: Simd>(&mut self, part: &SampleBlock, depth: f32x16<S>, drawn: u32) {
        let (change, tile) = (self.set.change, part.tiles[0].0);
        if drawn == ALL {
            store(depth.simd, self.depths, part.at, (ALL, depth));
            if let Some(tile) = self.tiles.get_mut(tile) {
                *tile = Tile { is_whole: true, change };
            }
        } else if drawn != 0 {
            self.store_discarded(part, depth.into(), drawn);
        }
    }

    /// The same where the shader has discarded some pixels. The first sample has its colours already.
    #[inline(never)]
    fn store_discarded(&mut self, part: &SampleBlock, depth: Lanes, drawn: u32) {
        let SampleBlocks { places, change, stride, .. } = *self.set;
        self.make_apart(part);
        for lane in (0..LANES).filter(|lane| drawn >> lane & 1 != 0) {
            for (sample, place) in places.iter().enumerate() {
                let at = part.at[0] + lane + sample * stride;
                self.colors[at] = self.colors[part.at[0] + lane];
                self.depths[at] = depth[lane] + Tile::change_at(change, *place);
            }
        }
    }

    /// Gives each sample its own colour and depth in the tiles where a block covers some.
    #[inline(always)]
    fn make_apart(&mut self, part: &SampleBlock) {
        for (half, &(tile, place)) in part.tiles.iter().enumerate() {
            let any = part.any >> (half * HALF_BLOCK) & (ALL >> HALF_BLOCK);
            let left = LANES.saturating_sub(place);
            // Those in the tile, and those in the next.
            let parts = [any & ((1 << left) - 1), any >> left];
            for (next, any) in parts.into_iter().enumerate() {
                if any != 0 && self.tiles.get(tile + next).is_some_and(|tile| tile.is_whole) {
                    self.take_apart(tile + next, (part.at[half] + next * LANES) - place);
                }
            }
        }
    }

    #[inline(never)]
    fn take_apart(&mut self, tile: usize, start: usize) {
        let SampleBlocks { places, stride, .. } = *self.set;
        let Some(tile) = self.tiles.get_mut(tile) else { return };
        tile.is_whole = false;
        let Some(&depths) = self.depths.get(start..).and_then(<[f32]>::first_chunk::<LANES>) else {
            return;
        };
        for (sample, place) in places.iter().enumerate() {
            let change = Tile::change_at(tile.change, *place);
            let start = start + sample * stride;
            let new = self.depths.get_mut(start..).and_then(<[f32]>::first_chunk_mut::<LANES>);
            if let Some(new) = new {
                *new = depths.map(|depth| depth + change);
            }
        }
        for sample in 1..places.len() {
            self.colors.copy_within(start..start + LANES, start + sample * stride);
        }
    }

    /// Compares the depths of a block at its samples; the lanes that any of them passes.
    #[inline(always)]
    fn test<S: Simd>(
        &self,
        block: &Block<S, TwoRows>,
        part: &SampleBlock,
        (surface, values, visible): (&SurfaceView<'_>, &RowValues, &mut [u32]),
    ) -> u32 {
        let SampleBlocks { places, change, comparison, stride, is_inverse_w, .. } = *self.set;
        let mut any = 0;
        for (sample, (place, visible)) in places.iter().zip(visible).enumerate() {
            let change = Tile::change_at(change, *place);
            let new = block.compared(surface, values, change, is_inverse_w);
            let old = load(block.simd(), self.depths, part.at, sample * stride);
            *visible = comparison.passes(new, old) & u32::from(part.covered[sample % MOST_SAMPLES]);
            any |= *visible;
        }
        any
    }

    /// Stores the depths of a block's samples that were drawn.
    #[inline(always)]
    fn store<S: Simd>(
        &mut self,
        block: &Block<S, TwoRows>,
        part: &SampleBlock,
        (surface, values, drawn): (&SurfaceView<'_>, &RowValues, &[u32]),
    ) {
        let SampleBlocks { places, change, stride, is_inverse_w, .. } = *self.set;
        for (sample, (place, drawn)) in places.iter().zip(drawn).enumerate() {
            let change = Tile::change_at(change, *place);
            let new = block.compared(surface, values, change, is_inverse_w);
            let at = part.at.map(|at| at.wrapping_add(sample * stride));
            store(block.simd(), self.depths, at, (*drawn, new));
        }
    }
}

/// Whether a block that covers all samples of a tile is visible at all of them, and drawing it leaves the tile
/// whole.
#[inline(always)]
fn is_whole_visible<S: Simd>(
    (set, tiles, depths): (&SampleBlocks<'_>, &[Tile], &[f32]),
    patch: &Patch<'_>,
    part: &SampleBlock,
    (depth, replaces): (f32x16<S>, bool),
) -> bool {
    let SampleBlocks { places, change, comparison, stride, .. } = *set;
    let (simd, [(tile, place), _]) = (depth.simd, part.tiles);
    let Some(tile) = tiles.get(tile) else { return false };
    let is_tile = place == 0 && part.at[1] == part.at[0].wrapping_add(HALF_BLOCK);
    let can_be_whole = set.writes && !set.is_inverse_w && (tile.is_whole || replaces);
    if !is_tile || !can_be_whole {
        return false;
    }
    let (mut least, mut most, mut least_old) = (0.0f32, 0.0f32, 0.0f32);
    for place in places {
        let new = Tile::change_at(change, *place);
        (least, most) = (least.min(new), most.max(new));
        least_old = least_old.min(Tile::change_at(tile.change, *place));
    }
    let first = load(simd, depths, part.at, 0);
    let mut passes = ALL;
    // Most blocks are clearly nearer.
    let is_clear = comparison == Comparison::Less
        && tile.is_whole
        && comparison.passes(depth + most, first + least_old) & ALL == ALL;
    if !is_clear {
        for (sample, place) in places.iter().enumerate() {
            let old = if tile.is_whole {
                first + Tile::change_at(tile.change, *place)
            } else {
                load(simd, depths, part.at, sample * stride)
            };
            passes &= comparison.passes(depth + Tile::change_at(change, *place), old);
        }
    }
    // Within the polygon's range as they are.
    let (min, max) = patch.surface.base.z_range;
    passes &= Comparison::GreaterEqual.passes(depth + least, f32x16::splat(simd, min));
    passes &= Comparison::LessEqual.passes(depth + most, f32x16::splat(simd, max));
    passes & ALL == ALL
}

/// Where the pixels of a block are shaded: at their centres where all samples are covered, elsewhere at the
/// mean of those that are, if that is asked for.
#[inline(always)]
fn places(part: &SampleBlock, set: &SampleBlocks<'_>) -> [Lanes; 2] {
    let ([mut x, mut y], mut counts) = ([[0.0; LANES]; 2], [0.0; LANES]);
    if part.all & ALL == part.any & ALL || !set.at_centroid {
        return [x, y];
    }
    for (&[place_x, place_y], covered) in set.places.iter().zip(part.covered) {
        for lane in 0..LANES {
            // Sums of 16ths: exact.
            let weight = (i32::from(covered) >> lane & 1) as f32;
            x[lane] += place_x * weight;
            y[lane] += place_y * weight;
            counts[lane] += weight;
        }
    }
    // Of those that are covered as a whole, the sum need not be 0.
    let count = set.places.len() as f32;
    for lane in 0..LANES {
        let is_edge = counts[lane] > 0.0 && counts[lane] < count;
        let per_count = if is_edge { 1.0 / counts[lane] } else { 0.0 };
        (x[lane], y[lane]) = (x[lane] * per_count, y[lane] * per_count);
    }
    [x, y]
}

/// The depths of a sample; of what lies outside of the band, which is covered by nothing, 0.
#[inline(always)]
fn load<S: Simd>(simd: S, depths: &[f32], at: [usize; 2], offset: usize) -> f32x16<S> {
    let lower = f32x8::simd_from(simd, half_at(depths, at[0].wrapping_add(offset)));
    lower.combine(f32x8::simd_from(simd, half_at(depths, at[1].wrapping_add(offset))))
}

#[inline(always)]
fn half_at(depths: &[f32], at: usize) -> [f32; HALF_BLOCK] {
    depths.get(at..).and_then(<[f32]>::first_chunk).copied().unwrap_or([0.0; HALF_BLOCK])
}

/// Stores the depths of a sample where they are drawn.
#[inline(always)]
fn store<S: Simd>(simd: S, depths: &mut [f32], at: [usize; 2], (drawn, new): (u32, f32x16<S>)) {
    if drawn == 0 {
        return;
    }
    let mut kept = new;
    if drawn != ALL {
        let old = load(simd, depths, at, 0);
        kept = mask32x16::from_bitmask(simd, drawn.into()).select(new, old);
    }
    let (lower, upper) = kept.split();
    for (half, new) in [lower, upper].into_iter().enumerate() {
        if drawn >> (half * HALF_BLOCK) & (ALL >> HALF_BLOCK) != 0
            && let Some(depths) = depths.get_mut(at[half]..)
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
        let &mut Self { simd, row, rows_before, shader, .. } = self;
        let tiles_in_row = self.tiles.len() / (self.colors.len() / row.max(1)).max(1);
        let rows = (sample / row.max(1)).saturating_sub(rows_before);
        let middle = (rows * row).min(self.colors.len());
        let (colors, below) = self.colors.split_at_mut(middle);
        let (tiles, tiles_below) =
            self.tiles.split_at_mut((rows * tiles_in_row).min(self.tiles.len()));
        let rows = rows + rows_before;
        f(
            &mut SamplePainter { simd, colors, tiles, row, rows_before, shader },
            &mut SamplePainter {
                simd,
                colors: below,
                tiles: tiles_below,
                row,
                rows_before: rows,
                shader,
            },
        );
    }
}
