//! From blocks whose covered samples are known to colours: the loops around a shader, for pixels of several
//! samples. With the shaders themselves this is all that knows their type.

use std::ops::Range;

use fearless_simd::{
    Select, Simd, SimdBase, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::coverage::run::ROWS;
use crate::fragment::FragmentBlock;
use crate::fragment::block::{ALL, AtCentres, Block, HALF_BLOCK, LANES, Lanes, TwoRows};
use crate::render::depth::Comparison;
use crate::render::samples::frame::{Tile, offset};
use crate::render::samples::shader::{SampleColors, SampleShader};
use crate::render::shader::{
    BandDepths, MOST_SAMPLES, NEST, PartBlocks, Patch, SampleBlock, SampleBlocks, ShadeBlocks,
    ShadeOnThreads, WholeBlocks, rarely,
};
use crate::surface::rows::{RowLine, RowValues, SurfaceView};

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
        let memory = Memory {
            colors,
            tiles,
            depths: band.depths,
            set: &blocks,
            changes: [0.0; MOST_SAMPLES],
        };
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
    /// How much more what is compared is at each sample than at the pixel's centre.
    changes: [f32; MOST_SAMPLES],
}

#[inline(always)]
fn draw<S: Simd, C: Copy, K: SampleShader<C, N>, const N: usize>(
    simd: S,
    patch: &Patch<'_>,
    mut memory: Memory<'_, C>,
    shader: &mut K,
) {
    let set = memory.set;
    let Some(s) = patch.values.s.first_chunk::<N>() else { return };
    let by_tiles = K::IS_BY_PIXEL && set.writes && !set.is_inverse_w;
    for (change, place) in memory.changes.iter_mut().zip(set.places) {
        *change = Tile::change_at(set.change, *place);
    }
    let (mut blocks, mut tile, mut tiles_left) = (set.blocks.iter(), SampleBlock::default(), 0);
    // A call within two loops the compiler takes to be hot, and inlines larger shaders there.
    loop {
        for _ in 0..NEST {
            let mut part = &tile;
            if tiles_left == 0 {
                let Some(next) = blocks.next() else {
                    rarely();
                    return;
                };
                part = next;
                if next.whole_tiles > 0 {
                    (tile, tiles_left) = (*next, next.whole_tiles);
                }
            }
            if tiles_left > 0 {
                if by_tiles && tile.tiles[0].1 == 0 {
                    let tiles = (&mut tile, tiles_left);
                    tiles_left -= draw_tiles(simd, patch, &mut memory, tiles, shader);
                    if tiles_left == 0 {
                        continue;
                    }
                }
                part = &tile;
            }
            draw_block(simd, patch, &mut memory, (part, s), shader);
            if tiles_left > 0 {
                tiles_left -= 1;
                tile.advance();
            }
        }
    }
}

/// Draws a block sample by sample.
#[inline(always)]
fn draw_block<S: Simd, C: Copy, K: SampleShader<C, N>, const N: usize>(
    simd: S,
    patch: &Patch<'_>,
    memory: &mut Memory<'_, C>,
    (part, s): (&SampleBlock, &[RowLine; N]),
    shader: &mut K,
) {
    let Patch { surface, runs, values } = *patch;
    let set = memory.set;
    let block = Block::in_two_rows(simd, part.rows, part.steps);
    let mut visible = [0; MOST_SAMPLES];
    let visible = &mut visible[..set.places.len().min(MOST_SAMPLES)];
    memory.make_apart(part);
    let any = memory.test(&block, part, (surface, values, &mut *visible));
    if any == 0 {
        return;
    }
    let column =
        |half: usize| (values.x[part.rows[half] % ROWS] + part.steps[half] as i32, part.rows[half]);
    let mut fragments = FragmentBlock::new(surface, runs, [column(0), column(1)], any);
    let (places, mut depth) = (places(simd, part, set), [0.0; LANES]);
    block.off_centre(surface, values, s, places, (&mut depth, fragments.found()));
    fragments.depth = depth;
    let (colors, plane) = (&mut *memory.colors, set.plane);
    let samples = SampleColors { colors, at: part.at, plane, visible: &mut *visible };
    shader.shade(simd, &mut fragments, samples);
    if set.writes {
        memory.store(&block, part, (surface, values, visible));
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
    // Copies: what is read through references would be read again after each colour is stored.
    let change = memory.set.change;
    let Some(along) = AtCentres::<N>::new(surface, values, part.rows[0]) else { return 0 };
    let (row, reach, z_range) = (part.rows[0] % ROWS, Tile::reach(change), surface.base.z_range);
    let mut block = Block::in_row(simd, row, part.steps[0]);
    let x = values.x[row] + part.steps[0] as i32;
    let mut done = 0;
    while done < count {
        let (first, mut discarded) = (done, None);
        let at = part.at[0].wrapping_add(done * LANES);
        let depths = pixels_and_others(memory.depths, at, count - done);
        let Some((depths, others)) = depths else { break };
        let colors = memory.colors.get_mut(at..).unwrap_or_default().as_chunks_mut().0;
        let tiles = memory.tiles.get_mut(part.tiles[0].0 + done..).unwrap_or_default();
        for ((colors, stored), tile) in colors.iter_mut().zip(depths).zip(tiles).take(NEST) {
            let depth = block.along(&along.z);
            let set = (memory.set, &memory.changes, K::REPLACES);
            let old = (*tile, &*stored, (others, (count - done) * LANES));
            if !is_tile_visible(set, old, depth, (reach, z_range)) {
                rarely();
                part.advance_by(done);
                return done;
            }
            let x = x + (done * LANES) as i32;
            let halves = [(x, row), (x + HALF_BLOCK as i32, row)];
            let mut fragments = FragmentBlock::new(surface, runs, halves, ALL);
            block.at_centres(surface, &along, fragments.found());
            fragments.depth = block.depth_along(&along.z, z_range).into();
            let drawn = shader.whole(&mut fragments, colors) & ALL;
            done += 1;
            block.advance();
            if drawn != ALL {
                rarely();
                discarded = Some((drawn, Lanes::from(depth)));
                break;
            }
            *stored = depth.into();
            *tile = Tile { is_whole: true, change };
        }
        if let Some((drawn @ 1.., depth)) = discarded {
            rarely();
            let mut tile = *part;
            tile.advance_by(done - 1);
            memory.store_discarded(&tile, depth, drawn);
        }
        if done == first {
            break;
        }
    }
    part.advance_by(done);
    done
}

/// Whether a tile that is covered at all samples is visible at all, and stays whole if it is drawn.
#[inline(always)]
fn is_tile_visible<S: Simd>(
    (set, changes, replaces): (&SampleBlocks<'_>, &[f32; MOST_SAMPLES], bool),
    (tile, first, others): (Tile, &Lanes, (&[f32], usize)),
    depth: f32x16<S>,
    (reach, z_range): (f32, (f32, f32)),
) -> bool {
    let simd = depth.simd;
    // Most are clearly nearer.
    let old = (f32x16::simd_from(simd, *first), Tile::reach(tile.change));
    let is_clear = set.comparison == Comparison::Less
        && tile.is_whole
        && is_clearly_nearer(depth, old, (reach, z_range));
    if is_clear {
        return true;
    }
    rarely();
    let (set, depths) = ((set, changes), (depth.into(), z_range));
    (tile.is_whole || replaces) && is_whole_visible(simd, set, (tile, first, others), depths)
}

/// The first samples of whole tiles, from one on, and what comes in memory behind them.
#[inline(always)]
fn pixels_and_others(
    depths: &mut [f32],
    at: usize,
    tiles: usize,
) -> Option<(&mut [[f32; LANES]], &[f32])> {
    let (first, others) = depths.get_mut(at..)?.split_at_mut_checked(tiles * LANES)?;
    Some((first.as_chunks_mut().0, others))
}

impl<C: Copy> Memory<'_, C> {
    /// The same where the shader has discarded some pixels. The first sample has its colours already.
    #[inline(never)]
    fn store_discarded(&mut self, part: &SampleBlock, depth: Lanes, drawn: u32) {
        let SampleBlocks { places, change, plane, .. } = *self.set;
        self.make_apart(part);
        for lane in (0..LANES).filter(|lane| drawn >> lane & 1 != 0) {
            for (sample, place) in places.iter().enumerate() {
                let at = part.at[0] + lane + offset(sample, plane);
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
        let SampleBlocks { places, plane, .. } = *self.set;
        let Some(tile) = self.tiles.get_mut(tile) else { return };
        tile.is_whole = false;
        let Some(&depths) = self.depths.get(start..).and_then(<[f32]>::first_chunk::<LANES>) else {
            return;
        };
        for (sample, place) in places.iter().enumerate() {
            let change = Tile::change_at(tile.change, *place);
            let start = start + offset(sample, plane);
            let new = self.depths.get_mut(start..).and_then(<[f32]>::first_chunk_mut::<LANES>);
            if let Some(new) = new {
                *new = depths.map(|depth| depth + change);
            }
        }
        for sample in 1..places.len() {
            self.colors.copy_within(start..start + LANES, start + offset(sample, plane));
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
        let SampleBlocks { comparison, plane, is_inverse_w, .. } = *self.set;
        let mut any = 0;
        for (sample, visible) in visible.iter_mut().enumerate() {
            let change = self.changes[sample % MOST_SAMPLES];
            let new = block.compared(surface, values, change, is_inverse_w);
            let old = load(block.simd(), self.depths, part.at, offset(sample, plane));
            let passes = match comparison {
                // The usual one on its own.
                Comparison::Less => Comparison::Less.passes(new, old),
                _ => comparison.passes(new, old),
            };
            *visible = passes & u32::from(part.covered[sample % MOST_SAMPLES]);
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
        let SampleBlocks { plane, is_inverse_w, .. } = *self.set;
        for (sample, drawn) in drawn.iter().enumerate() {
            let change = self.changes[sample % MOST_SAMPLES];
            let new = block.compared(surface, values, change, is_inverse_w);
            let at = part.at.map(|at| at.wrapping_add(offset(sample, plane)));
            store(block.simd(), self.depths, at, (*drawn, new));
        }
    }
}

/// Whether a tile is nearer at all samples than what is there, since it is even if each depth is moved by
/// as much as it changes within a pixel at most. Rounding keeps the order of sums, so none that are rounded
/// differ. Then it must be within the polygon's range besides.
#[inline(always)]
fn is_clearly_nearer<S: Simd>(
    depth: f32x16<S>,
    (old, old_reach): (f32x16<S>, f32),
    (reach, (min, max)): (f32, (f32, f32)),
) -> bool {
    let (nearest, farthest) = (depth - reach, depth + reach);
    let simd = depth.simd;
    let passes = Comparison::Less.passes(farthest, old - old_reach)
        & Comparison::GreaterEqual.passes(nearest, f32x16::splat(simd, min))
        & Comparison::LessEqual.passes(farthest, f32x16::splat(simd, max));
    passes & ALL == ALL
}

/// Whether a tile that is covered at all samples is visible at all, and within the polygon's range, if the
/// depths of its first samples are the given ones; those of the other samples are in the memory that begins so
/// many elements behind them.
#[cold]
#[inline(never)]
fn is_whole_visible<S: Simd>(
    simd: S,
    (set, changes): (&SampleBlocks<'_>, &[f32; MOST_SAMPLES]),
    (tile, first, others): (Tile, &Lanes, (&[f32], usize)),
    (depth, (min, max)): (Lanes, (f32, f32)),
) -> bool {
    simd.vectorize(
        #[inline(always)]
        || {
            let (depth, first) = (f32x16::simd_from(simd, depth), f32x16::simd_from(simd, *first));
            let (min, max) = (f32x16::splat(simd, min), f32x16::splat(simd, max));
            let mut passes = ALL;
            for (sample, place) in set.places.iter().enumerate() {
                let mut old = first + Tile::change_at(tile.change, *place);
                if !tile.is_whole {
                    old = first;
                    if sample > 0 {
                        let (others, before) = others;
                        let at = offset(sample, set.plane).wrapping_sub(before);
                        let Some(other) = others.get(at..).and_then(<[f32]>::first_chunk) else {
                            return false;
                        };
                        old = f32x16::simd_from(simd, *other);
                    }
                }
                let new = depth + changes[sample % MOST_SAMPLES];
                passes &= set.comparison.passes(new, old)
                    & Comparison::GreaterEqual.passes(new, min)
                    & Comparison::LessEqual.passes(new, max);
            }
            // The pixel's centre, too, from which all are found.
            passes &= Comparison::GreaterEqual.passes(depth, min);
            passes &= Comparison::LessEqual.passes(depth, max);
            passes & ALL == ALL
        },
    )
}

/// Where the pixels of a block are shaded: at their centres where all samples are covered, elsewhere at the
/// mean of those that are, if that is asked for.
#[inline(always)]
fn places<S: Simd>(simd: S, part: &SampleBlock, set: &SampleBlocks<'_>) -> [f32x16<S>; 2] {
    let zero = f32x16::splat(simd, 0.0);
    if part.all & ALL == part.any & ALL || !set.at_centroid {
        return [zero; 2];
    }
    let [mut x, mut y, mut covered_samples] = [zero; 3];
    for (&[place_x, place_y], covered) in set.places.iter().zip(part.covered) {
        // Sums of 16ths: exact.
        let is_covered = mask32x16::from_bitmask(simd, covered.into());
        x = is_covered.select(x + place_x, x);
        y = is_covered.select(y + place_y, y);
        covered_samples = is_covered.select(covered_samples + 1.0, covered_samples);
    }
    // Of those that are covered as a whole, the sum need not be 0.
    let all = set.places.len() as f32;
    let is_edge = covered_samples.simd_gt(0.0) & covered_samples.simd_lt(all);
    let per_sample = f32x16::splat(simd, 1.0) / is_edge.select(covered_samples, zero + 1.0);
    let per_sample = is_edge.select(per_sample, zero);
    [x * per_sample, y * per_sample]
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
    let old = load(simd, depths, at, 0);
    let kept = mask32x16::from_bitmask(simd, drawn.into()).select(new, old);
    let (lower, upper) = kept.split();
    for (half, new) in [lower, upper].into_iter().enumerate() {
        if let Some(depths) = depths.get_mut(at[half]..).and_then(<[f32]>::first_chunk_mut) {
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
