//! Blocks against stored depths, and what follows for those that pass: shading, and storing.

use std::ops::Range;

use fearless_simd::{
    Select, Simd, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::coverage::run::RunGroup;
use crate::fragment::block::{Block, BlockRows, HALF_BLOCK, LANES, Lanes};
use crate::render::band::Band;
use crate::render::counters::PixelCounts;
use crate::render::raster::plan::{Plan, PlanFor};
use crate::render::shader::{
    BandDepths, PARTS, PartBlock, PartBlocks, Patch, ShadeBlocks, ShortRuns, WholeBlocks, halves_at,
};
use crate::render::stencil::put_back;
use crate::surface::rows::{RowValues, SurfaceView, VisibleColumns};

/// Parts of blocks that are not yet shaded. With the [common](Plan::COMMON) plan they are not yet
/// tested either: the shader's loop does that. With others they are visible, and their depths are
/// stored already; kept are those from before, for the lanes that the shader will discard.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    parts: [PartBlock; PARTS],
    depths: [Lanes; PARTS],
    /// The bytes of the stencil from before, if there is one.
    stencils: [[u8; LANES]; PARTS],
    count: usize,
    /// The pixels since they were [counted](RowsRaster::count) last.
    pixels: PixelCounts,
}

impl Default for Parts {
    fn default() -> Self {
        Self {
            parts: [PartBlock::default(); PARTS],
            depths: [[0.0; LANES]; PARTS],
            stencils: [[0; LANES]; PARTS],
            count: 0,
            pixels: PixelCounts::default(),
        }
    }
}

impl Parts {
    /// Forgets all.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }
}

/// The rows of a polygon being drawn into a band: all that the loops share.
pub(crate) struct RowsRaster<'r, 'b, S> {
    pub(crate) simd: S,
    pub(crate) plan: Plan,
    pub(crate) surface: &'r SurfaceView<'r>,
    pub(crate) runs: &'r RunGroup,
    pub(crate) band: &'r mut Band<'b>,
    pub(crate) shader: &'r mut dyn ShadeBlocks,
    pub(crate) values: &'r mut RowValues,
    pub(crate) columns: &'r VisibleColumns,
    pub(crate) parts: &'r mut Parts,
}

impl<S: Simd> RowsRaster<'_, '_, S> {
    /// Draws pairs of short runs, a bit a pair.
    #[inline(always)]
    pub(crate) fn draw_short_runs<P: PlanFor>(&mut self, runs: &ShortRuns<'_>, pairs: u32) {
        let mut left = pairs;
        if P::of(self.plan) == Plan::COMMON {
            left = self.draw_parts(|_| PartBlocks::Runs(runs), pairs);
            if left != 0 {
                return self.draw_at_ends::<P>(left, |pair| runs.part(pair));
            }
        }
        while left != 0 {
            self.test_part::<P>(runs.part(left.trailing_zeros() as usize));
            left &= left - 1;
        }
    }

    /// Draws a part of a block, at the latest when the parts are [finished](Self::finish_parts).
    #[inline(always)]
    pub(crate) fn draw_part<P: PlanFor>(&mut self, part: PartBlock) {
        if P::of(self.plan) != Plan::COMMON {
            return self.test_part::<P>(part);
        }
        let kept = &mut self.parts.parts[self.parts.count % PARTS];
        let PartBlock { visible, rows, steps, at } = part;
        // One by one: a copy of what was just stored in parts would have to wait for them.
        (kept.visible, kept.rows, kept.steps, kept.at) = (visible, rows, steps, at);
        self.parts.count += 1;
        if self.parts.count == PARTS {
            self.finish_parts::<P>();
        }
    }

    /// Draws the parts that are left.
    #[inline(always)]
    pub(crate) fn finish_parts<P: PlanFor>(&mut self) {
        if self.parts.count == 0 {
            return;
        }
        if P::of(self.plan) != Plan::COMMON {
            return self.shade_parts::<P>();
        }
        let count = std::mem::take(&mut self.parts.count).min(PARTS);
        let left = self.draw_parts(PartBlocks::Untested, (1 << count) - 1);
        if left != 0 {
            let parts = self.parts.parts;
            self.draw_at_ends::<P>(left, |number| parts[number % PARTS]);
        }
    }

    /// Tests, shades and stores parts of blocks; those that are left have to be drawn otherwise.
    #[inline(always)]
    fn draw_parts<'p>(
        &'p mut self,
        parts: impl FnOnce(&'p [PartBlock; PARTS]) -> PartBlocks<'p>,
        numbers: u32,
    ) -> u32 {
        self.surface.find_params(self.values);
        let patch = Patch { surface: self.surface, runs: self.runs, values: self.values };
        let Band { depth, pixels_before, .. } = &mut *self.band;
        let band = BandDepths { depths: depth, pixels_before: *pixels_before };
        self.shader.draw_parts(&patch, parts(&self.parts.parts), numbers, band)
    }

    /// Draws parts that reach over the ends of the band, or over themselves.
    #[cold]
    #[inline(never)]
    fn draw_at_ends<P: PlanFor>(&mut self, numbers: u32, part: impl Fn(usize) -> PartBlock) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                for number in (0..PARTS).filter(|number| numbers >> number & 1 != 0) {
                    self.test_part::<P>(part(number));
                    self.shade_parts::<P>();
                }
            },
        );
    }

    /// Tests a part of a block, and keeps it if a lane of those given as visible is.
    #[inline(always)]
    fn test_part<P: PlanFor>(&mut self, part: PartBlock) {
        let block = Block::in_two_rows(self.simd, part.rows, part.steps);
        let depth = depth_of::<P, S>(self.plan, &block, self.surface, self.values);
        // Not by `array::map`, which would go through memory.
        let lower = f32x8::simd_from(self.simd, self.band.half(part.at[0]));
        let upper = f32x8::simd_from(self.simd, self.band.half(part.at[1]));
        let stored = lower.combine(upper);
        let passes = P::of(self.plan).comparison.passes(depth, stored);
        let mut visible = passes & part.visible;
        let mut stencils = [0; LANES];
        if P::of(self.plan).has_extras {
            visible = self.test_extras(&part, passes, &mut stencils);
        }
        if visible == 0 {
            return;
        }
        if self.parts.count == PARTS {
            self.shade_parts::<P>();
        }
        let number = self.parts.count % PARTS;
        self.parts.parts[number] = PartBlock { visible, ..part };
        self.parts.count = number + 1;
        if P::of(self.plan).has_extras {
            self.parts.stencils[number] = stencils;
        }
        if P::of(self.plan).writes {
            self.parts.depths[number] = stored.into();
            store_part(visible, depth, stored, self.band, part.at);
        }
    }

    /// Tests a part by the stencil as well, and counts its pixels. `passes` are the lanes that pass by depth.
    #[inline(never)]
    fn test_extras(&mut self, part: &PartBlock, passes: u32, before: &mut [u8; LANES]) -> u32 {
        let mut visible = passes & part.visible;
        if let Some((stencil, bytes)) = &mut self.band.extras.stencil {
            let face = stencil.face(self.surface.base.is_front);
            visible = stencil.update(face, bytes, (part.at, part.visible, passes), before);
        }
        self.parts.pixels.tested += u64::from(part.visible.count_ones());
        self.parts.pixels.drawn += u64::from(visible.count_ones());
        visible
    }

    /// Hands the pixels over that were counted.
    pub(crate) fn count(&mut self) {
        let pixels = std::mem::take(&mut self.parts.pixels);
        if let Some(counters) = self.band.extras.counters {
            counters.add(self.surface.base.face, pixels);
        }
    }

    /// Counts parts that were shaded, and takes the stencil of those lanes back that were discarded.
    #[cold]
    fn finish_extras(&mut self, count: usize, visible: &[u32; PARTS]) {
        let Parts { parts, stencils, pixels, .. } = &mut *self.parts;
        for ((part, visible), before) in parts[..count].iter().zip(visible).zip(stencils) {
            let discarded = visible & !part.visible;
            pixels.shaded += u64::from(visible.count_ones());
            pixels.drawn -= u64::from(discarded.count_ones());
            if let Some((_, bytes)) = &mut self.band.extras.stencil
                && discarded != 0
            {
                put_back(bytes, part.at, discarded, before);
            }
        }
    }

    /// Shades the parts of blocks that are visible, and takes back the depths of what is discarded.
    #[inline(always)]
    fn shade_parts<P: PlanFor>(&mut self) {
        // Taken before the shader is called: if it panics, nothing must be left for the next polygon.
        let count = std::mem::take(&mut self.parts.count).min(PARTS);
        if count == 0 || self.shader.is_depth_only() {
            return;
        }
        let mut visible = [0; PARTS];
        for (visible, part) in visible.iter_mut().zip(&self.parts.parts) {
            *visible = part.visible;
        }
        self.surface.find_params(self.values);
        let patch = Patch { surface: self.surface, runs: self.runs, values: self.values };
        let Band { depth, pixels_before, .. } = &mut *self.band;
        let band = BandDepths { depths: depth, pixels_before: *pixels_before };
        let parts = PartBlocks::Visible(&mut self.parts.parts);
        self.shader.draw_parts(&patch, parts, (1 << count) - 1, band);
        if P::of(self.plan).has_extras {
            self.finish_extras(count, &visible);
        }
        if P::of(self.plan).writes {
            let Parts { parts, depths, .. } = &*self.parts;
            for ((part, visible), depth) in parts[..count].iter().zip(visible).zip(depths) {
                if part.visible != visible {
                    take_back_part(part, visible & !part.visible, depth, self.band);
                }
            }
        }
    }

    /// Draws whole blocks of a row, if the plan is common, as long as all of their lanes are visible or
    /// none. `steps` is how far the first pixel is from where the row's values are given. Returns how many
    /// pixels are done.
    #[inline(always)]
    pub(crate) fn draw_whole<P: PlanFor>(
        &mut self,
        row: usize,
        steps: f32,
        pixels: Range<usize>,
    ) -> usize {
        if P::of(self.plan) != Plan::COMMON {
            return 0;
        }
        let pixel = pixels.start.wrapping_add(self.band.pixels_before);
        let Some(depths) = self.band.depth.get_mut(pixels) else { return 0 };
        self.surface.find_params(self.values);
        let patch = Patch { surface: self.surface, runs: self.runs, values: self.values };
        self.shader.draw_whole(&patch, WholeBlocks { row, steps, pixel }, depths)
    }
}

/// What is compared and stored.
#[inline(always)]
fn depth_of<P: PlanFor, S: Simd>(
    plan: Plan,
    block: &Block<S, impl BlockRows>,
    surface: &SurfaceView<'_>,
    values: &RowValues,
) -> f32x16<S> {
    if P::of(plan).is_inverse_w {
        block.depth_by_inv_w(surface, values)
    } else {
        block.depth(surface, values)
    }
}

/// Stores the depths of the lanes that are visible.
#[inline(always)]
fn store_part<S: Simd>(
    visible: u32,
    depth: f32x16<S>,
    old: f32x16<S>,
    band: &mut Band<'_>,
    at: [usize; 2],
) {
    let Some([lower, upper]) = halves_at(band.depth, at) else {
        return store_lanes(visible, &depth.into(), band, at);
    };
    let visible = mask32x16::from_bitmask(depth.simd, visible.into());
    let (new_lower, new_upper) = visible.select(depth, old).split();
    *lower = new_lower.into();
    *upper = new_upper.into();
}

/// Puts the depths back that lanes had which were discarded.
#[cold]
fn take_back_part(part: &PartBlock, discarded: u32, before: &Lanes, band: &mut Band<'_>) {
    store_lanes(discarded, before, band, part.at);
}

/// Stores the depths of some lanes, one by one: for blocks that reach over the ends of the band, or over
/// themselves, as in narrow pictures.
#[cold]
fn store_lanes(lanes: u32, depths: &Lanes, band: &mut Band<'_>, at: [usize; 2]) {
    for (lane, depth) in depths.iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 != 0) {
        let pixel = at[lane / HALF_BLOCK].wrapping_add(lane % HALF_BLOCK);
        if let Some(stored) = band.depth.get_mut(pixel) {
            *stored = *depth;
        }
    }
}
