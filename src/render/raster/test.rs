//! Blocks against stored depths, and what follows for those that pass: shading, and storing.

use std::ops::Range;

use fearless_simd::{
    Select, Simd, SimdCombine, SimdFrom, SimdMask, SimdSplit, f32x8, f32x16, mask32x16,
};

use crate::coverage::run::RunGroup;
use crate::fragment::block::{ALL, Block, BlockRows, LANES, Lanes, OneRow};
use crate::render::band::Band;
use crate::render::raster::plan::{Plan, PlanFor};
use crate::render::shader::{PartBlock, Patch, ShadeBlocks, WholeBlocks, halves_at};
use crate::surface::rows::{RowValues, SurfaceView};

/// Whole blocks that are shaded at a time: enough that the call costs little, few enough that their
/// depths stay in the first cache.
const WHOLE: usize = 16;

/// Parts of blocks that are shaded at a time.
const PARTS: usize = 8;

/// Visible blocks that are not yet shaded, with their depths.
#[derive(Clone, Debug)]
pub(crate) struct Visible {
    parts: [PartBlock; PARTS],
    part_depths: [Lanes; PARTS],
    part_count: usize,
    whole_depths: [Lanes; WHOLE],
    drawn: [u32; WHOLE],
}

impl Default for Visible {
    fn default() -> Self {
        Self {
            parts: [PartBlock::default(); PARTS],
            part_depths: [[0.0; LANES]; PARTS],
            part_count: 0,
            whole_depths: [[0.0; LANES]; WHOLE],
            drawn: [0; WHOLE],
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
    pub(crate) visible: &'r mut Visible,
}

impl<S: Simd> RowsRaster<'_, '_, S> {
    /// What is compared and stored.
    #[inline(always)]
    fn depth<P: PlanFor>(&self, block: &Block<S, impl BlockRows>) -> f32x16<S> {
        if P::of(self.plan).is_inverse_w {
            block.depth_by_inv_w(self.surface, self.values)
        } else {
            block.depth(self.surface, self.values)
        }
    }

    /// Tests a part of a block, whose halves begin at `at` in the band, and keeps it if a lane of
    /// those given as visible is.
    #[inline(always)]
    pub(crate) fn test_part<P: PlanFor>(&mut self, part: PartBlock, at: [usize; 2]) {
        let block = Block::in_two_rows(self.simd, part.rows, part.steps);
        let depth = self.depth::<P>(&block);
        let [lower, upper] = at.map(|at| f32x8::simd_from(self.simd, self.band.half(at)));
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
        self.visible.part_depths[number] = depth.into();
        self.visible.part_count = number + 1;
    }

    /// Shades the parts of blocks that were kept, and stores their depths.
    #[inline(always)]
    pub(crate) fn shade_parts<P: PlanFor>(&mut self) {
        let count = std::mem::take(&mut self.visible.part_count).min(PARTS);
        if count == 0 {
            return;
        }
        let parts = &mut self.visible.parts[..count];
        if !self.shader.is_depth_only() {
            self.surface.find_params(self.values);
            let patch = Patch { surface: self.surface, runs: self.runs, values: self.values };
            self.shader.shade_parts(&patch, parts);
        }
        if P::of(self.plan).writes {
            for (part, depth) in parts.iter().zip(&self.visible.part_depths) {
                store_part(self.simd, part, depth, self.band);
            }
        }
    }

    /// Draws whole blocks of a row, the first of which is given and begins `steps` from where the row's
    /// values are, as long as all of their lanes are visible or none. Returns how many pixels that are,
    /// and leaves the block after them.
    #[inline(always)]
    pub(crate) fn draw_whole<P: PlanFor>(
        &mut self,
        row: usize,
        block: &mut Block<S, OneRow>,
        steps: f32,
        pixels: Range<usize>,
    ) -> usize {
        let (mut done, mut waiting) = (0, 0);
        while let Some(stored) = self.band.depth.get(pixels.start + done..pixels.end)
            && let Some(stored) = stored.first_chunk()
        {
            let depth = self.depth::<P>(block);
            let stored = f32x16::simd_from(self.simd, *stored);
            let visible = P::of(self.plan).comparison.passes(depth, stored) & ALL;
            if visible == ALL {
                self.visible.whole_depths[waiting % WHOLE] = depth.into();
                waiting += 1;
            }
            if waiting == WHOLE || visible != ALL && waiting > 0 {
                let first = done + LANES - if visible == ALL { WHOLE } else { waiting + 1 } * LANES;
                self.shade_whole::<P>(row, steps + first as f32, pixels.start + first, waiting);
                waiting = 0;
            }
            if visible != ALL && visible != 0 {
                return done;
            }
            done += LANES;
            block.advance();
        }
        if waiting > 0 {
            let first = done - waiting * LANES;
            self.shade_whole::<P>(row, steps + first as f32, pixels.start + first, waiting);
        }
        done
    }

    /// Shades whole blocks that are visible, and stores their depths.
    #[inline(always)]
    fn shade_whole<P: PlanFor>(&mut self, row: usize, steps: f32, at: usize, count: usize) {
        let Visible { whole_depths, drawn, .. } = self.visible;
        let drawn = &mut drawn[..count.min(WHOLE)];
        if self.shader.is_depth_only() {
            drawn.fill(ALL);
        } else {
            self.surface.find_params(self.values);
            let patch = Patch { surface: self.surface, runs: self.runs, values: self.values };
            let pixel = at.wrapping_add(self.band.pixels_before);
            self.shader.shade_whole(&patch, WholeBlocks { row, steps, pixel }, drawn);
        }
        if P::of(self.plan).writes {
            let stored = self.band.depth.get_mut(at..).unwrap_or_default().as_chunks_mut().0;
            for ((stored, depth), drawn) in stored.iter_mut().zip(whole_depths).zip(drawn) {
                *stored = if *drawn == ALL {
                    *depth
                } else {
                    chosen(self.simd, *drawn, depth, *stored)
                };
            }
        }
    }
}

/// Stores the depths of the lanes that were drawn.
#[inline(always)]
fn store_part<S: Simd>(simd: S, part: &PartBlock, depth: &Lanes, band: &mut Band<'_>) {
    let at = part.pixels.map(|pixel| pixel.wrapping_sub(band.pixels_before));
    let Some([lower, upper]) = halves_at(band.depth, at) else {
        return store_part_at_end(part, depth, band, at);
    };
    let old = f32x8::simd_from(simd, *lower).combine(f32x8::simd_from(simd, *upper));
    let new = f32x16::simd_from(simd, *depth);
    let drawn = mask32x16::from_bitmask(simd, part.visible.into());
    let (new_lower, new_upper) = drawn.select(new, old).split();
    *lower = new_lower.into();
    *upper = new_upper.into();
}

/// The same for a block that reaches over the ends of the band, or over itself, as in narrow pictures.
#[cold]
fn store_part_at_end(part: &PartBlock, depth: &Lanes, band: &mut Band<'_>, at: [usize; 2]) {
    for (lane, depth) in depth.iter().enumerate().filter(|(lane, _)| part.visible >> lane & 1 != 0) {
        let pixel = at[lane / (LANES / 2)].wrapping_add(lane % (LANES / 2));
        if let Some(stored) = band.depth.get_mut(pixel) {
            *stored = *depth;
        }
    }
}

/// The new depths of the lanes that were drawn, the old ones of the others.
#[inline(always)]
fn chosen<S: Simd>(simd: S, drawn: u32, new: &Lanes, old: Lanes) -> Lanes {
    let (new, old) = (f32x16::simd_from(simd, *new), f32x16::simd_from(simd, old));
    mask32x16::from_bitmask(simd, drawn.into()).select(new, old).into()
}
