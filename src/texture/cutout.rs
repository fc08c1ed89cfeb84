//! Levels whose cut-outs cover as much as the picture's (Castano, "Computing Alpha Mipmaps", 2010).
//!
//! The mean of a leaf and the air around it is half a leaf. Where all below a threshold is a hole, leaves so vanish
//! with the distance, or swell. So the alpha of each level is multiplied by a number, the same for all
//! texels, by which the part of the level that is at the threshold or above becomes that of the picture.

use glam::Vec4;

use crate::texture::sample::mix;

/// What a chain is to keep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cutout {
    /// From here on alpha is no hole.
    pub(super) threshold: f32,
    /// Whether alpha is the red channel, of numbers, and not the fourth, of colours.
    pub(super) in_red: bool,
}

/// Points of a texel along each axis at which it is asked whether there is a hole.
const POINTS: u32 = 4;

/// The most texels that are looked at; of larger levels these are in rows at even distances.
const LOOKS: u64 = 1 << 17;

/// The most that alpha is multiplied by.
const MOST: f32 = 64.0;

impl Cutout {
    /// The part of a level that is no hole, if alpha is bilinear between texels that it is multiplied by
    /// `scale` in.
    pub(super) fn coverage(
        &self,
        (width, height): (u32, u32),
        scale: f32,
        texel: impl Fn(u32, u32) -> Vec4,
    ) -> f64 {
        let step = (u64::from(width) * u64::from(height)).div_ceil(LOOKS).max(1) as usize;
        let alpha = |x: u32, y: u32| self.alpha(texel(x % width, y % height) * scale).min(1.0);
        let (mut covered, mut all) = (0_u64, 0_u64);
        for y in (0..height).step_by(step) {
            let mut left = [alpha(0, y), alpha(0, y + 1)];
            for x in 1..=width {
                let right = [alpha(x, y), alpha(x, y + 1)];
                covered += u64::from(self.points_between(left, right));
                all += u64::from(POINTS * POINTS);
                left = right;
            }
        }
        covered as f64 / all.max(1) as f64
    }

    /// How many of the points between four texels' centres are no holes.
    fn points_between(&self, left: [f32; 2], right: [f32; 2]) -> u32 {
        let at = |i: u32| (i as f32 + 0.5) / POINTS as f32;
        let blend = |a: f32, b: f32, t: f32| mix(Vec4::splat(a), Vec4::splat(b), t).x;
        let ends = [left[0], left[1], right[0], right[1]];
        if ends.iter().all(|&alpha| alpha >= self.threshold) {
            return POINTS * POINTS;
        }
        if ends.iter().all(|&alpha| alpha < self.threshold) {
            return 0;
        }
        let along = |i: u32| [blend(left[0], right[0], at(i)), blend(left[1], right[1], at(i))];
        let is_covered = |i: u32, j: u32| {
            let [upper, lower] = along(i);
            blend(upper, lower, at(j)) >= self.threshold
        };
        (0..POINTS)
            .flat_map(|i| (0..POINTS).map(move |j| (i, j)))
            .filter(|&(i, j)| is_covered(i, j))
            .count() as u32
    }

    /// By what the alpha of a level is to be multiplied for it to cover as much as it should.
    fn scale(&self, size: (u32, u32), wanted: f64, texels: &[Vec4]) -> f32 {
        let texel = |x: u32, y: u32| texels[y as usize * size.0 as usize + x as usize];
        let coverage = |scale: f32| self.coverage(size, scale, texel);
        // A picture without holes, and one of nothing else, stay so.
        if wanted <= 0.0 || wanted >= 1.0 {
            return 1.0;
        }
        // Coverage grows with the scale.
        let (mut low, mut high) = (0.0, MOST);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            *(if coverage(middle) < wanted { &mut low } else { &mut high }) = middle;
        }
        // Of the two sides of a step, that which is nearer.
        let is_lower_nearer = wanted - coverage(low) < coverage(high) - wanted;
        if is_lower_nearer { low } else { high }
    }

    /// The texels of a level, row by row, with the alpha by which so much of it is no hole. Colours before
    /// alpha stay as they are.
    pub(super) fn scaled(&self, size: (u32, u32), wanted: f64, texels: &[Vec4]) -> Vec<Vec4> {
        let scale = self.scale(size, wanted, texels);
        let changed = |texel: &Vec4| {
            let alpha = self.alpha(*texel);
            // Opaque is the most.
            let most = if alpha > 0.0 { alpha.recip() } else { scale };
            *texel * scale.min(most)
        };
        let scaled = texels.iter().map(changed);
        if self.in_red {
            // The fourth channel of numbers is none of theirs.
            return scaled.zip(texels).map(|(s, texel)| s.truncate().extend(texel.w)).collect();
        }
        scaled.collect()
    }

    fn alpha(&self, texel: Vec4) -> f32 {
        if self.in_red { texel.x } else { texel.w }
    }
}
