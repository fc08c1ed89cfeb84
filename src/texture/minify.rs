//! The colour of what a pixel sees of a picture: the filters that know a footprint.

use glam::{Vec2, Vec4, vec2};

use crate::fragment::Footprint;
use crate::texture::ewa::{self, Quadratic};
use crate::texture::level::{MOST_PROBES, MipFilter, Sides, log2};
use crate::texture::sample::{Filter, Surroundings, bilinear, by_filter, mix};
use crate::texture::texels::{Fetch, Level, LevelTexels, Texels};
use crate::texture::wrap::{floor_above_minus_one, whole};

/// How a texture is filtered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Filtering {
    pub(super) filter: Filter,
    pub(super) mip_filter: MipFilter,
    /// Added to the level of detail.
    pub(super) bias: f32,
    /// Which levels of detail there are to be, from the first to the second.
    pub(super) range: (f32, f32),
    pub(super) around: Surroundings,
}

impl Default for Filtering {
    fn default() -> Self {
        Self {
            filter: Filter::default(),
            mip_filter: MipFilter::default(),
            bias: 0.0,
            range: (f32::NEG_INFINITY, f32::INFINITY),
            around: Surroundings::default(),
        }
    }
}

impl Filtering {
    /// The level of detail after bias and range.
    #[inline(always)]
    pub(super) fn adjusted(&self, lambda: f32) -> f32 {
        let biased = lambda + self.bias;
        let raised = if biased > self.range.0 { biased } else { self.range.0 };
        if raised < self.range.1 { raised } else { self.range.1 }
    }
}

/// The levels of a texture.
#[derive(Clone, Copy)]
pub(super) struct Chain<'t, F> {
    pub(super) texels: &'t Texels,
    pub(super) base: LevelTexels<F>,
    pub(super) how: &'t Filtering,
}

impl<'t, F: Fetch> Chain<'t, F> {
    #[inline(always)]
    pub(super) fn new(texels: &'t Texels, base: LevelTexels<F>, how: &'t Filtering) -> Self {
        Self { texels, base, how }
    }

    #[inline(always)]
    pub(super) fn level(&self, number: u32) -> LevelTexels<F> {
        self.base.at(self.texels.level(number))
    }

    /// The colour of a footprint: a function of its own, for those that are sampled one by one are so in several
    /// places.
    #[inline(never)]
    pub(super) fn sample(&self, footprint: &Footprint) -> Vec4 {
        let Level { width, height, .. } = self.base.size;
        let size = vec2(width as f32, height as f32);
        let sides = Sides { dx: footprint.dx * size, dy: footprint.dy * size };
        let uv = footprint.uv;
        match self.how.mip_filter {
            MipFilter::Off => self.magnified(uv),
            MipFilter::Nearest => {
                // Half a level goes down.
                let level = self.how.adjusted(sides.lambda()) - 0.5;
                let texels = self.level(level.ceil() as u32);
                by_filter(self.how.filter, &texels, &self.how.around, uv)
            }
            MipFilter::Linear => self.trilinear(self.how.adjusted(sides.lambda()), uv),
            MipFilter::Anisotropic { probes } => self.anisotropic(&sides, size, probes, uv),
            MipFilter::Ewa { eccentricity } => self.elliptical(&sides, size, eccentricity, uv),
        }
    }

    /// The colour by the texture's own filter.
    #[inline(always)]
    pub(super) fn magnified(&self, uv: Vec2) -> Vec4 {
        by_filter(self.how.filter, &self.base, &self.how.around, uv)
    }

    /// The colour at a point between two levels; by the texture's own filter where it is magnified.
    #[inline(always)]
    fn trilinear(&self, lambda: f32, uv: Vec2) -> Vec4 {
        if lambda > 0.0 { self.between_levels(lambda, uv) } else { self.magnified(uv) }
    }

    #[inline(always)]
    fn between_levels(&self, lambda: f32, uv: Vec2) -> Vec4 {
        let (level, fraction) = self.levels(lambda);
        let finer = bilinear(&self.level(level), &self.how.around, uv);
        if fraction > 0.0 {
            mix(finer, bilinear(&self.level(level + 1), &self.how.around, uv), fraction)
        } else {
            finer
        }
    }

    /// The finer of the two levels beside a level of detail, and how far it is to the next.
    #[inline(always)]
    pub(super) fn levels(&self, lambda: f32) -> (u32, f32) {
        let last = self.texels.last_level() as f32;
        // NaN counts as 0.
        let lambda = if lambda > 0.0 { lambda } else { 0.0 };
        let lambda = if lambda < last { lambda } else { last };
        let level = floor_above_minus_one(lambda);
        (whole(level), lambda - level)
    }

    #[inline(always)]
    fn anisotropic(&self, sides: &Sides, size: Vec2, most: u32, uv: Vec2) -> Vec4 {
        if sides.are_round() {
            return self.trilinear(self.how.adjusted(sides.lambda()), uv);
        }
        let ellipse = sides.ellipse();
        let (count, lambda) = ellipse.probes(most);
        let lambda = self.how.adjusted(lambda);
        if count == 1 {
            return self.trilinear(lambda, uv);
        }
        let (axis, weights) = ellipse.axis();
        let along = axis / size;
        let (mut sum, mut whole) = (Vec4::ZERO, 0.0);
        for i in 0..count {
            let t = probe_at(i, count);
            let weight = weights.at(t);
            sum += self.between_levels(lambda, uv + along * t) * weight;
            whole += weight;
        }
        sum / whole
    }

    #[inline(never)]
    fn elliptical(&self, sides: &Sides, size: Vec2, eccentricity: u32, uv: Vec2) -> Vec4 {
        let ellipse = sides.ellipse();
        let eccentricity = eccentricity.clamp(1, MOST_PROBES) as f32;
        if !(self.how.adjusted(log2(ellipse.major)) > 0.0 && ellipse.major < f32::MAX) {
            return self.magnified(uv);
        }
        let minor = ellipse.minor.max(ellipse.major / eccentricity);
        let (level, fraction) = self.levels(self.how.adjusted(log2(minor)));
        let mean = |number: u32| {
            let texels = self.level(number);
            if number == self.texels.last_level() {
                return bilinear(&texels, &self.how.around, uv);
            }
            let scale = vec2(texels.size.width as f32, texels.size.height as f32) / size;
            let sides = Sides { dx: sides.dx * scale, dy: sides.dy * scale };
            ewa::mean(&texels, &self.how.around, uv, &Quadratic::of(&sides, eccentricity))
        };
        let finer = mean(level);
        if fraction > 0.0 { mix(finer, mean(level + 1), fraction) } else { finer }
    }
}

/// Where a probe is along the longer axis, from -1/2 to 1/2.
#[inline(always)]
pub(super) fn probe_at(i: u32, count: u32) -> f32 {
    (i as f32 + 0.5) / count as f32 - 0.5
}
