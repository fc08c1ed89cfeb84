//! The colours of the pixels of a block, sixteen at once: the same to the bit as of one after the other.
//!
//! What is arithmetic is done for all lanes in one loop, which becomes SIMD: levels of detail, axes, places
//! between texels. Then the texels are fetched lane by lane. Nearest texels and bilinear means come
//! so, on one level or between two, alone or along an axis; all else is sampled one by one.

use glam::{Vec2, Vec4, vec2};

use crate::fragment::{FootprintBlock, LANES, Lanes};
use crate::texture::level::{MipFilter, Sides};
use crate::texture::minify::{Chain, Filtering, probe_at};
use crate::texture::sample::{Filter, mix};
use crate::texture::texels::{Fetch, Level};
use crate::texture::wrap::{Neighbours, Wrap, nearest_index};

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
}

/// The level of each lane, and its size.
struct Levels {
    number: [u32; LANES],
    width: [u32; LANES],
    height: [u32; LANES],
}

impl Levels {
    /// Those of numbers that a picture of a size has levels for.
    #[inline(always)]
    fn of(base: Level, number: [u32; LANES]) -> Self {
        // Halves, rounded down again and again, are shifts.
        let shifted = |size: u32| {
            let mut sizes = [0; LANES];
            for lane in 0..LANES {
                sizes[lane] = (size >> (number[lane] & 31)).max(1);
            }
            sizes
        };
        Self { number, width: shifted(base.width), height: shifted(base.height) }
    }

    /// The numbers of texels within their levels, by column and row; `u64::MAX` for one outside.
    #[inline(always)]
    fn texels(&self, x: &[u32; LANES], y: &[u32; LANES]) -> [u64; LANES] {
        let mut numbers = [0; LANES];
        for lane in 0..LANES {
            let (width, height) = (self.width[lane], self.height[lane]);
            let number = u64::from(y[lane]) * u64::from(width) + u64::from(x[lane]);
            let is_inside = (x[lane] < width) & (y[lane] < height);
            numbers[lane] = if is_inside { number } else { u64::MAX };
        }
        numbers
    }
}

/// Calls `f` for the lanes that have a bit in a mask.
#[inline(always)]
fn for_lanes(mask: u32, mut f: impl FnMut(usize)) {
    let mut left = mask & ((1 << LANES) - 1);
    while left != 0 {
        f(left.trailing_zeros() as usize % LANES);
        left &= left - 1;
    }
}

impl<F: Fetch> Chain<'_, F> {
    /// The colours at points by the texture's own filter.
    #[inline(always)]
    pub(super) fn magnified_block(&self, uv: &[Lanes; 2], mask: u32, colors: &mut Colors) {
        match self.how.filter {
            Filter::Nearest => self.nearest_block(uv, mask, colors),
            Filter::Bilinear => {
                self.bilinear_block(uv, &[0; LANES], mask, colors);
            }
            Filter::Bicubic(_) => for_lanes(mask, |lane| {
                colors[lane] = self.magnified(vec2(uv[0][lane], uv[1][lane]));
            }),
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
            _ => for_lanes(mask, |lane| colors[lane] = self.sample(&of.get(lane))),
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

    /// The texels in which points lie.
    #[inline(always)]
    fn nearest_block(&self, [u, v]: &[Lanes; 2], mask: u32, colors: &mut Colors) {
        let (size, around) = (self.base.size, &self.how.around);
        let x = nearest_indices(u, size.width, around.u);
        let y = nearest_indices(v, size.height, around.v);
        let numbers = Levels::of(size, [0; LANES]).texels(&x, &y);
        for_lanes(mask, |lane| {
            colors[lane] = self.base.numbered(numbers[lane]).unwrap_or(around.border);
        });
    }

    /// The bilinear means at points, each on a level of its own.
    #[inline(always)]
    fn bilinear_block(
        &self,
        [u, v]: &[Lanes; 2],
        numbers: &[u32; LANES],
        mask: u32,
        colors: &mut Colors,
    ) {
        let levels = Levels::of(self.base.size, *numbers);
        let float = |sizes: &[u32; LANES]| {
            let mut floats = [0.0; LANES];
            for (float, size) in floats.iter_mut().zip(sizes) {
                // At most 2^16; as a signed number it takes one instruction.
                *float = *size as i32 as f32;
            }
            floats
        };
        let around = &self.how.around;
        let x = Axis::around(u, &float(&levels.width), around.u);
        let y = Axis::around(v, &float(&levels.height), around.v);
        let upper = [levels.texels(&x.low, &y.low), levels.texels(&x.high, &y.low)];
        let lower = [levels.texels(&x.low, &y.high), levels.texels(&x.high, &y.high)];
        for_lanes(mask, |lane| {
            let start = self.level(levels.number[lane]).size.start as u64;
            let texel = |numbers: &[u64; LANES]| {
                let number = start.saturating_add(numbers[lane]);
                self.base.numbered(number).unwrap_or(around.border)
            };
            let mixed =
                |[low, high]: &[[u64; LANES]; 2]| mix(texel(low), texel(high), x.fraction[lane]);
            colors[lane] = mix(mixed(&upper), mixed(&lower), y.fraction[lane]);
        });
    }

    /// The trilinear means; of what is magnified, the bilinear ones.
    #[inline(always)]
    fn trilinear_block(&self, uv: &[Lanes; 2], lambdas: &Lanes, mask: u32, colors: &mut Colors) {
        let (mut finer, mut coarser) = ([0; LANES], [0; LANES]);
        let (mut fractions, mut between) = ([0.0; LANES], 0);
        for lane in 0..LANES {
            let (level, fraction) = self.levels(lambdas[lane]);
            (finer[lane], coarser[lane], fractions[lane]) = (level, level + 1, fraction);
            between |= u32::from(fraction > 0.0) << lane;
        }
        between &= mask;
        self.bilinear_block(uv, &finer, mask, colors);
        if between != 0 {
            let mut others = [Vec4::ZERO; LANES];
            self.bilinear_block(uv, &coarser, between, &mut others);
            for_lanes(between, |lane| {
                colors[lane] = mix(colors[lane], others[lane], fractions[lane]);
            });
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
        for_lanes(mask, |lane| {
            most = counts[lane].max(most);
            single |= u32::from(counts[lane] == 1) << lane;
        });
        // A single probe is at the middle itself; several are moved, and added up.
        let several = mask & !single;
        let mut sums = [Vec4::ZERO; LANES];
        for i in 0..most {
            let (mut uv, mut left) = (of.uv, 0);
            for lane in 0..LANES {
                let t = probe_at(i, counts[lane]);
                for axis in 0..2 {
                    let moved = of.uv[axis][lane] + along[axis][lane] * t;
                    uv[axis][lane] = if counts[lane] == 1 { of.uv[axis][lane] } else { moved };
                }
                left |= u32::from(counts[lane] > i) << lane;
            }
            let mut probes = [Vec4::ZERO; LANES];
            self.trilinear_block(&uv, &lambdas, left & mask, &mut probes);
            for_lanes(left & single & mask, |lane| colors[lane] = probes[lane]);
            for_lanes(left & several, |lane| sums[lane] += probes[lane]);
        }
        for_lanes(several, |lane| colors[lane] = sums[lane] / counts[lane] as f32);
    }
}

/// The texels that coordinates lie in, along one axis.
#[inline(always)]
fn nearest_indices(coordinates: &Lanes, size: u32, wrap: Wrap) -> [u32; LANES] {
    let mut indices = [0; LANES];
    // A loop of its own for what is most usual, whose body has no branch.
    if wrap == Wrap::Repeat {
        for (index, coordinate) in indices.iter_mut().zip(coordinates) {
            *index = nearest_index(*coordinate, size, Wrap::Repeat);
        }
    } else {
        for (index, coordinate) in indices.iter_mut().zip(coordinates) {
            *index = nearest_index(*coordinate, size, wrap);
        }
    }
    indices
}
