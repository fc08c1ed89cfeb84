//! The nearest layers of each pixel, from fragments that come from back to front.

use std::ops::Range;

use fearless_simd::Simd;

use crate::fragment::block::{Block, HALF_BLOCK, LANES, Lanes};
use crate::render::shader::{
    BandDepths, PartBlocks, Patch, ShadeBlocks, ShadeOnThreads, WholeBlocks,
};

/// Keeps faces and depths. Each fragment is before all that its pixel had so far: these move one place
/// back, and the last is forgotten.
#[derive(Debug)]
pub(crate) struct LayerKeeper<'a, S> {
    pub(crate) simd: S,
    pub(crate) layers: usize,
    /// For each pixel as many as there are layers, the nearest first.
    pub(crate) faces: &'a mut [u32],
    pub(crate) depths: &'a mut [f32],
    /// How many pixels of the target come before these.
    pub(crate) pixels_before: usize,
}

impl<S: Simd> ShadeBlocks for LayerKeeper<'_, S> {
    /// Nothing: the depths of layers are not stored for others to be tested against, and then no block is
    /// drawn as a whole.
    fn draw_whole(&mut self, _: &Patch<'_>, _: WholeBlocks, _: &mut [f32]) -> usize {
        0
    }

    fn draw_parts(
        &mut self,
        patch: &Patch<'_>,
        parts: PartBlocks<'_>,
        numbers: u32,
        band: BandDepths<'_>,
    ) -> u32 {
        let before = band.pixels_before.wrapping_sub(self.pixels_before);
        let (simd, face) = (self.simd, patch.surface.base.face);
        let mut left = numbers;
        while left != 0 {
            let part = parts.get(left.trailing_zeros() as usize);
            left &= left - 1;
            let block = Block::in_two_rows(simd, part.rows, part.steps);
            let depths: Lanes = block.depth(patch.surface, patch.values).into();
            let mut visible = part.visible;
            while visible != 0 {
                let lane = visible.trailing_zeros() as usize % LANES;
                visible &= visible - 1;
                let at = part.at[lane / HALF_BLOCK].wrapping_add(lane % HALF_BLOCK);
                self.push(at.wrapping_add(before), face, depths[lane]);
            }
        }
        0
    }

    fn prefetch(&self, _: Range<usize>) {}
}

impl<S> LayerKeeper<'_, S> {
    /// Puts a fragment before those that a pixel has.
    #[inline(always)]
    fn push(&mut self, pixel: usize, face: u32, depth: f32) {
        let layers =
            pixel.wrapping_mul(self.layers)..pixel.wrapping_add(1).wrapping_mul(self.layers);
        push(self.faces.get_mut(layers.clone()), face);
        push(self.depths.get_mut(layers), depth);
    }
}

#[inline(always)]
fn push<T: Copy>(layers: Option<&mut [T]>, value: T) {
    if let Some(layers) = layers
        && let Some(last) = layers.len().checked_sub(1)
    {
        layers.copy_within(..last, 1);
        layers[0] = value;
    }
}

impl<S: Simd + Send> ShadeOnThreads for LayerKeeper<'_, S> {
    fn split(
        &mut self,
        pixel: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    ) {
        let &mut Self { simd, layers, pixels_before, .. } = self;
        let middle =
            pixel.saturating_sub(pixels_before).saturating_mul(layers).min(self.faces.len());
        let (first_faces, faces) = self.faces.split_at_mut(middle);
        let (first_depths, depths) = self.depths.split_at_mut(middle);
        f(
            &mut LayerKeeper {
                simd,
                layers,
                faces: first_faces,
                depths: first_depths,
                pixels_before,
            },
            &mut LayerKeeper { simd, layers, faces, depths, pixels_before: pixel },
        );
    }
}
