//! Blocks against stored depths, and what follows for those that pass: shading, and storing.

use std::ops::Range;

use fearless_simd::{
    Select, Simd, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::coverage::run::RunGroup;
use crate::fragment::block::{Block, BlockRows, HALF_BLOCK, LANES, Lanes};
use crate::render::band::Band;
use crate::render::raster::plan::{Plan, PlanFor};
use crate::render::shader::{PartBlock, Patch, ShadeBlocks, WholeBlocks, halves_at};
use crate::surface::rows::{RowValues, SurfaceView, VisibleColumns};

/// Parts of blocks that are shaded at a time.
const PARTS: usize = 8;

/// Visible blocks that are not yet shaded. The depths of parts are stored already; kept are those from
/// before, for the lanes that the shader will discard.
#[derive(Clone, Debug)]
pub(crate) struct Visible {
    parts: [PartBlock; PARTS],
    part_depths: [Lanes; PARTS],
    part_count: usize,
}

impl Default for Visible {
    fn default() -> Self {
        Self {
            parts: [PartBlock::default(); PARTS],
            part_depths: [[0.0; LANES]; PARTS],
            part_count: 0,
        }
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
    pub(crate) columns: VisibleColumns,
    pub(crate) visible: &'r mut Visible,
}

impl<S: Simd> RowsRaster<'_, '_, S> {
    /// Tests a part of a block, whose halves begin at `at` in the band, and keeps it if a lane of
    /// those given as visible is.
    #[inline(always)]
    pub(crate) fn test_part<P: PlanFor>(&mut self, part: PartBlock, at: [usize; 2]) {
        let block = Block::in_two_rows(self.simd, part.rows, part.steps);
        let depth = depth_of::<P, S>(self.plan, &block, self.surface, self.values);
        // Not by `array::map`, which would go through memory.
        let lower = f32x8::simd_from(self.simd, self.band.half(at[0]));
        let upper = f32x8::simd_from(self.simd, self.band.half(at[1]));
        let stored = lower.combine(upper);
        let visible = P::of(self.plan).comparison.passes(depth, stored) & part.visible;
        if visible == 0 {
            return;
        }
        if self.visible.part_count == PARTS {
            self.shade_parts::<P>();
        }
        let pixels = at.map(|at| at.wrapping_add(self.band.pixels_before));
        let number = self.visible.part_count % PARTS;
        self.visible.parts[number] = PartBlock { visible, pixels, ..part };
        self.visible.part_count = number + 1;
        if P::of(self.plan).writes {
            self.visible.part_depths[number] = stored.into();
            store_part(visible, depth, stored, self.band, at);
        }
    }

    /// Shades the parts of blocks that were kept, and takes back the depths of what is discarded.
    #[inline(always)]
    pub(crate) fn shade_parts<P: PlanFor>(&mut self) {
        let count = std::mem::take(&mut self.visible.part_count).min(PARTS);
        if count == 0 || self.shader.is_depth_only() {
            return;
        }
        let visible = self.visible.parts.map(|part| part.visible);
        let parts = &mut self.visible.parts[..count];
        self.surface.find_params(self.values);
        let patch = Patch { surface: self.surface, runs: self.runs, values: self.values };
        self.shader.shade_parts(&patch, parts);
        if P::of(self.plan).writes {
            let depths = &self.visible.part_depths;
            for ((part, visible), depth) in parts.iter().zip(visible).zip(depths) {
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
    let at = part.pixels.map(|pixel| pixel.wrapping_sub(band.pixels_before));
    store_lanes(discarded, before, band, at);
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
