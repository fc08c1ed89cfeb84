//! The colours of the pixels of a block, sixteen at once: the same to the bit as of one after the other.
//!
//! What is arithmetic is done for all lanes in one loop, which becomes SIMD: levels of detail, axes, places
//! between texels. Then the texels are fetched lane by lane. Nearest texels and bilinear means come
//! so, on one level or between two, alone or along an axis; all else is sampled one by one.

use glam::{Vec2, Vec4, vec2};

use crate::fragment::{FootprintBlock, LANES, Lanes};
use crate::texture::level::{MipFilter, Sides};
use crate::texture::minify::{Chain, Filtering, probe_at};
use crate::texture::sample::{Filter, Surroundings, mix};
use crate::texture::texels::{Fetch, Level, Texels};
use crate::texture::wrap::{Neighbours, Wrap, nearest_index};

/// The colour of each lane.
pub(super) type Colors = [Vec4; LANES];

/// The same in 8-bit sRGB.
pub(super) type Codes = [[u8; 4]; LANES];

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

/// The level of each lane: its size, and the number of its first texel.
struct Levels {
    width: [u32; LANES],
    height: [u32; LANES],
    start: [u32; LANES],
}

impl Levels {
    /// The same level for all lanes.
    #[inline(always)]
    fn all(level: Level) -> Self {
        let Level { width, height, start } = level;
        Self { width: [width; LANES], height: [height; LANES], start: [start as u32; LANES] }
    }

    /// Those with given numbers.
    #[inline(always)]
    fn of(texels: &Texels, numbers: &[u32; LANES]) -> Self {
        let Level { width, height, .. } = texels.base();
        let mut levels = Self { width: [0; LANES], height: [0; LANES], start: [0; LANES] };
        // Halves, rounded down again and again, are shifts.
        for (lane, number) in numbers.iter().enumerate() {
            levels.width[lane] = (width >> (number & 31)).max(1);
            levels.height[lane] = (height >> (number & 31)).max(1);
        }
        let starts = texels.starts();
        for (lane, number) in numbers.iter().enumerate() {
            levels.start[lane] = starts[(number & 31) as usize];
        }
        levels
    }
}

/// The four texels around each lane's point, by their numbers, and where between them it is.
struct Surrounding {
    /// The upper two, then the lower two.
    texels: [[u32; LANES]; 4],
    fraction: [Lanes; 2],
}

impl Surrounding {
    #[inline(always)]
    fn of([u, v]: &[Lanes; 2], levels: &Levels, around: &Surroundings) -> Self {
        // Without a border all are in the picture.
        let float = |sizes: &[u32; LANES]| {
            let mut floats = [0.0; LANES];
            for (float, size) in floats.iter_mut().zip(sizes) {
                // At most 2^16; as a signed number it takes one instruction.
                *float = *size as i32 as f32;
            }
            floats
        };
        let x = Axis::around(u, &float(&levels.width), around.u);
        let y = Axis::around(v, &float(&levels.height), around.v);
        let mut texels = [[0; LANES]; 4];
        let [upper_left, upper_right, lower_left, lower_right] = &mut texels;
        for lane in 0..LANES {
            let (start, width) = (levels.start[lane], levels.width[lane]);
            let row = |y: u32| y.wrapping_mul(width).wrapping_add(start);
            let (upper, lower) = (row(y.low[lane]), row(y.high[lane]));
            upper_left[lane] = upper.wrapping_add(x.low[lane]);
            upper_right[lane] = upper.wrapping_add(x.high[lane]);
            lower_left[lane] = lower.wrapping_add(x.low[lane]);
            lower_right[lane] = lower.wrapping_add(x.high[lane]);
        }
        Self { texels, fraction: [x.fraction, y.fraction] }
    }
}

/// Calls `f` for the lanes that have a bit in a mask.
#[inline(always)]
fn for_lanes(mask: u32, mut f: impl FnMut(usize)) {
    const ALL: u32 = (1 << LANES) - 1;
    if mask & ALL == ALL {
        for lane in 0..LANES {
            f(lane);
        }
        return;
    }
    let mut left = mask & ALL;
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
            Filter::Bilinear if self.is_plain() => {
                let levels = Levels::all(self.base.size);
                self.bilinear_block(uv, &levels, mask, |lane, color| colors[lane] = color);
            }
            _ => for_lanes(mask, |lane| {
                colors[lane] = self.magnified(vec2(uv[0][lane], uv[1][lane]));
            }),
        }
    }

    /// The colours of footprints.
    #[inline(always)]
    pub(super) fn sample_block(&self, of: &FootprintBlock, mask: u32, colors: &mut Colors) {
        let Filtering { mip_filter, filter, .. } = self.how;
        let is_bilinear = *filter == Filter::Bilinear && self.is_plain();
        match mip_filter {
            MipFilter::Off => self.magnified_block(&of.uv, mask, colors),
            MipFilter::Linear if is_bilinear => {
                let mut lambdas = [0.0; LANES];
                for (lane, lambda) in lambdas.iter_mut().enumerate() {
                    *lambda = self.how.adjusted(self.sides(of, lane).lambda());
                }
                self.trilinear_block(&of.uv, &lambdas, mask, colors);
            }
            MipFilter::Anisotropic { probes } if is_bilinear => {
                self.anisotropic_block(of, *probes, mask, colors);
            }
            _ => for_lanes(mask, |lane| colors[lane] = self.sample(&of.get(lane))),
        }
    }

    /// Whether the four texels around a point are in the picture, and have numbers of 32 bits.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.texels.has_short_numbers() && !self.how.around.has_border()
    }

    /// Whether all colours are opaque.
    #[inline(always)]
    pub(super) fn is_opaque(&self) -> bool {
        F::OPAQUE && !self.how.around.has_border()
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
    fn nearest_block(&self, uv: &[Lanes; 2], mask: u32, colors: &mut Colors) {
        let (x, y) = self.nearest_places(uv);
        for_lanes(mask, |lane| {
            let texel = self.base.get(x[lane], y[lane]);
            colors[lane] = texel.unwrap_or(self.how.around.border);
        });
    }

    /// The codes of the texels in which points lie, if they are what is asked for, and are opaque.
    #[inline(always)]
    pub(super) fn codes_block(&self, uv: &[Lanes; 2], mask: u32, codes: &mut Codes) -> bool {
        let Filtering { filter, mip_filter, .. } = self.how;
        let is_nearest = *filter == Filter::Nearest && *mip_filter == MipFilter::Off;
        if !is_nearest || !F::OPAQUE || !self.is_plain() {
            return false;
        }
        let (x, y) = self.nearest_places(uv);
        let mut numbers = [0; LANES];
        for lane in 0..LANES {
            numbers[lane] = y[lane].wrapping_mul(self.base.size.width).wrapping_add(x[lane]);
        }
        for_lanes(mask, |lane| {
            codes[lane] = self.base.code_numbered(numbers[lane] as usize).unwrap_or_default();
        });
        true
    }

    /// Columns and rows of the texels in which points lie.
    #[inline(always)]
    fn nearest_places(&self, [u, v]: &[Lanes; 2]) -> ([u32; LANES], [u32; LANES]) {
        let (size, around) = (self.base.size, &self.how.around);
        (nearest_indices(u, size.width, around.u), nearest_indices(v, size.height, around.v))
    }

    /// The bilinear means at points, each on a level of its own.
    #[inline(always)]
    fn bilinear_block(
        &self,
        uv: &[Lanes; 2],
        levels: &Levels,
        mask: u32,
        mut take: impl FnMut(usize, Vec4),
    ) {
        let around = &self.how.around;
        let Surrounding { texels, fraction: [x, y] } = &Surrounding::of(uv, levels, around);
        for_lanes(
            mask,
            #[inline(always)]
            |lane| {
                let texel = |corner: usize| {
                    let number = texels[corner][lane] as usize;
                    self.base.light_numbered(number).unwrap_or_default()
                };
                let upper = mix(texel(0), texel(1), x[lane]);
                let color = mix(upper, mix(texel(2), texel(3), x[lane]), y[lane]);
                // The mean of opaque texels is opaque.
                take(lane, if F::OPAQUE { color.with_w(1.0) } else { color });
            },
        );
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
        let finer = Levels::of(self.texels, &finer);
        self.bilinear_block(uv, &finer, mask, |lane, color| colors[lane] = color);
        if between != 0 {
            let coarser = Levels::of(self.texels, &coarser);
            self.bilinear_block(uv, &coarser, between, |lane, color| {
                colors[lane] = mix(colors[lane], color, fractions[lane]);
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
