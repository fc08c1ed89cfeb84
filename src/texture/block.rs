//! The colours of the pixels of a block, sixteen at once: the same to the bit as of one after the other.
//!
//! What is arithmetic is done for all lanes in one loop, which becomes SIMD: levels of detail, axes, places
//! between texels. Then the texels are fetched lane by lane. Only bilinear samples come so, on one level or
//! between two, alone or along an axis; all else is sampled one by one.

use glam::{Vec2, Vec4, vec2};

use crate::fragment::{FootprintBlock, LANES, Lanes};
use crate::texture::level::{MipFilter, Sides};
use crate::texture::minify::{Chain, Filtering, probe_at};
use crate::texture::sample::{Filter, bilinear_between, mix};
use crate::texture::texels::{Fetch, Level};
use crate::texture::wrap::{Neighbours, Wrap};

/// The colour of each lane.
pub(super) type Colors = [Vec4; LANES];

/// The neighbours of each lane's point along one axis.
struct Axis {
    low: [u32; LANES],
    high: [u32; LANES],
    fraction: Lanes,
}

impl Axis {
    #[inline(always)]
    fn around(coordinates: &Lanes, sizes: &Lanes, wrap: Wrap) -> Self {
        // A loop for each, whose body has no branch.
        match wrap {
            Wrap::Repeat => {
                Self::each(|i| Neighbours::around(coordinates[i], sizes[i], Wrap::Repeat))
            }
            Wrap::Clamp => {
                Self::each(|i| Neighbours::around(coordinates[i], sizes[i], Wrap::Clamp))
            }
            Wrap::Mirror => {
                Self::each(|i| Neighbours::around(coordinates[i], sizes[i], Wrap::Mirror))
            }
            Wrap::Border => {
                Self::each(|i| Neighbours::around(coordinates[i], sizes[i], Wrap::Border))
            }
        }
    }

    #[inline(always)]
    fn each(of_lane: impl Fn(usize) -> Neighbours) -> Self {
        let mut axis = Self { low: [0; LANES], high: [0; LANES], fraction: [0.0; LANES] };
        for i in 0..LANES {
            let Neighbours { low, high, fraction } = of_lane(i);
            (axis.low[i], axis.high[i], axis.fraction[i]) = (low, high, fraction);
        }
        axis
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Neighbours {
        let lane = lane % LANES;
        Neighbours { low: self.low[lane], high: self.high[lane], fraction: self.fraction[lane] }
    }
}

/// The lanes that have a bit in a mask.
#[inline(always)]
fn lanes_in(mask: u32) -> impl Iterator<Item = usize> {
    let mut left = mask & ((1 << LANES) - 1);
    std::iter::from_fn(move || {
        let lane = left.trailing_zeros() as usize;
        left &= left.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

impl<F: Fetch> Chain<'_, F> {
    /// The colours at points by the texture's own filter.
    #[inline(always)]
    pub(super) fn magnified_block(&self, uv: &[Lanes; 2], mask: u32, colors: &mut Colors) {
        if self.how.filter == Filter::Bilinear {
            self.bilinear_block(uv, &[self.base.size; LANES], mask, colors);
        } else {
            self.one_by_one(mask, colors, |lane| self.magnified(vec2(uv[0][lane], uv[1][lane])));
        }
    }

    /// The colours of footprints.
    #[inline(always)]
    pub(super) fn sample_block(&self, of: &FootprintBlock, mask: u32, colors: &mut Colors) {
        let Filtering { mip_filter, filter, .. } = self.how;
        match mip_filter {
            MipFilter::Off => self.magnified_block(&of.uv, mask, colors),
            MipFilter::Linear if *filter == Filter::Bilinear => {
                let mut lambdas = [0.0; LANES];
                for (lane, lambda) in lambdas.iter_mut().enumerate() {
                    *lambda = self.how.adjusted(self.sides(of, lane).lambda());
                }
                self.trilinear_block(&of.uv, &lambdas, mask, colors);
            }
            MipFilter::Anisotropic { probes } if *filter == Filter::Bilinear => {
                self.anisotropic_block(of, *probes, mask, colors);
            }
            _ => self.one_by_one(mask, colors, |lane| self.sample(&of.get(lane))),
        }
    }

    #[inline(always)]
    fn one_by_one(&self, mask: u32, colors: &mut Colors, color: impl Fn(usize) -> Vec4) {
        for lane in lanes_in(mask) {
            colors[lane % LANES] = color(lane);
        }
    }

    #[inline(always)]
    fn size(&self) -> Vec2 {
        vec2(self.base.size.width as f32, self.base.size.height as f32)
    }

    #[inline(always)]
    fn sides(&self, of: &FootprintBlock, lane: usize) -> Sides {
        let side = |[u, v]: &[Lanes; 2]| vec2(u[lane], v[lane]) * self.size();
        Sides { dx: side(&of.dx), dy: side(&of.dy) }
    }

    /// The bilinear means at points, each on a level of its own.
    #[inline(always)]
    fn bilinear_block(
        &self,
        [u, v]: &[Lanes; 2],
        levels: &[Level; LANES],
        mask: u32,
        colors: &mut Colors,
    ) {
        let (mut widths, mut heights) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let Level { width, height, .. } = levels[lane];
            (widths[lane], heights[lane]) = (width as f32, height as f32);
        }
        let around = &self.how.around;
        let x = Axis::around(u, &widths, around.u);
        let y = Axis::around(v, &heights, around.v);
        for lane in lanes_in(mask) {
            let texels = self.base.at(levels[lane % LANES]);
            colors[lane % LANES] = bilinear_between(&texels, around, &x.get(lane), &y.get(lane));
        }
    }

    /// The trilinear means; of what is magnified, the bilinear ones.
    #[inline(always)]
    fn trilinear_block(&self, uv: &[Lanes; 2], lambdas: &Lanes, mask: u32, colors: &mut Colors) {
        let mut finer = [self.base.size; LANES];
        let mut coarser = finer;
        let mut fractions = [0.0; LANES];
        let mut between = 0;
        for lane in lanes_in(mask) {
            let (level, fraction) = self.levels(lambdas[lane % LANES]);
            finer[lane % LANES] = self.level(level).size;
            if fraction > 0.0 {
                coarser[lane % LANES] = self.level(level + 1).size;
                fractions[lane % LANES] = fraction;
                between |= 1 << lane;
            }
        }
        self.bilinear_block(uv, &finer, mask, colors);
        if between != 0 {
            let mut others = [Vec4::ZERO; LANES];
            self.bilinear_block(uv, &coarser, between, &mut others);
            for lane in lanes_in(between) {
                let lane = lane % LANES;
                colors[lane] = mix(colors[lane], others[lane], fractions[lane]);
            }
        }
    }

    /// The means of probes along the longer axes.
    #[inline(always)]
    fn anisotropic_block(&self, of: &FootprintBlock, most: u32, mask: u32, colors: &mut Colors) {
        let (mut counts, mut lambdas) = ([1; LANES], [0.0; LANES]);
        let mut along = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let ellipse = self.sides(of, lane).ellipse();
            let (count, lambda) = ellipse.probes(most);
            let axis = ellipse.direction * ellipse.major / self.size();
            (counts[lane], lambdas[lane]) = (count, self.how.adjusted(lambda));
            [along[0][lane], along[1][lane]] = axis.to_array();
        }
        let (mut single, mut most) = (0, 0);
        for lane in lanes_in(mask) {
            most = counts[lane].max(most);
            single |= u32::from(counts[lane] == 1) << lane;
        }
        if single != 0 {
            self.trilinear_block(&of.uv, &lambdas, single, colors);
        }
        let several = mask & !single;
        if several == 0 {
            return;
        }
        let (mut sums, mut probes) = ([Vec4::ZERO; LANES], [Vec4::ZERO; LANES]);
        for i in 0..most {
            let (mut uv, mut left) = ([[0.0; LANES]; 2], 0);
            for lane in 0..LANES {
                let t = probe_at(i, counts[lane]);
                for axis in 0..2 {
                    uv[axis][lane] = of.uv[axis][lane] + along[axis][lane] * t;
                }
                left |= u32::from(counts[lane] > i) << lane;
            }
            self.trilinear_block(&uv, &lambdas, left & several, &mut probes);
            for lane in lanes_in(left & several) {
                sums[lane] += probes[lane];
            }
        }
        for lane in lanes_in(several) {
            colors[lane] = sums[lane] / counts[lane] as f32;
        }
    }
}
