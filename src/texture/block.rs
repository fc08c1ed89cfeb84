//! The colours of the pixels of a block, sixteen at once: the same to the bit as of one after the other.
//!
//! What is arithmetic is done for all lanes in one loop, which becomes SIMD: levels of detail, axes, places
//! between texels. Then the texels are fetched lane by lane. Nearest texels and bilinear means come
//! so, on one level or between two, alone or along an axis; all else is sampled one by one.

use glam::{Vec2, Vec4, vec2};

use crate::fragment::{FootprintBlock, LANES, Lanes};
use crate::texture::level::{MipFilter, Sides, Weights};
use crate::texture::minify::{Chain, Filtering, probe_at};
use crate::texture::sample::{Filter, Surroundings, mix};
use crate::texture::texels::{Fetch, Level, Srgba8, Texels};
use crate::texture::wrap::{Neighbours, Wrap, nearest_index, wrapped};

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
    /// Those of coordinates, which may be wrapped already, where there is no border.
    #[inline(always)]
    fn around<const WRAPPED: bool>(coordinates: &Lanes, sizes: &Lanes, wrap: Wrap) -> Self {
        let of_lane = |i: usize, wrap| {
            if WRAPPED {
                Neighbours::around_wrapped(coordinates[i], sizes[i], wrap)
            } else {
                Neighbours::around(coordinates[i], sizes[i], wrap)
            }
        };
        // A loop for each, whose body has no branch.
        match wrap {
            Wrap::Repeat => Self::each(|i| of_lane(i, Wrap::Repeat)),
            Wrap::Mirror if !WRAPPED => Self::each(|i| of_lane(i, Wrap::Mirror)),
            _ => Self::each(|i| of_lane(i, Wrap::Clamp)),
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

/// Coordinates brought into 0 to 1: the same on all levels.
#[inline(always)]
fn wrapped_block(uv: &[Lanes; 2], around: &Surroundings) -> [Lanes; 2] {
    let mut all = [[0.0; LANES]; 2];
    for ((all, coordinates), wrap) in all.iter_mut().zip(uv).zip([around.u, around.v]) {
        // A loop for each, whose body has no branch.
        match wrap {
            Wrap::Repeat => {
                for (to, from) in all.iter_mut().zip(coordinates) {
                    *to = wrapped(*from, Wrap::Repeat);
                }
            }
            Wrap::Mirror => {
                for (to, from) in all.iter_mut().zip(coordinates) {
                    *to = wrapped(*from, Wrap::Mirror);
                }
            }
            Wrap::Clamp | Wrap::Border => {
                for (to, from) in all.iter_mut().zip(coordinates) {
                    *to = wrapped(*from, Wrap::Clamp);
                }
            }
        }
    }
    all
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
    /// Those of coordinates, which may be wrapped already, in a picture without a border.
    #[inline(always)]
    fn of<const WRAPPED: bool>(
        [u, v]: &[Lanes; 2],
        levels: &Levels,
        around: &Surroundings,
    ) -> Self {
        let float = |sizes: &[u32; LANES]| {
            let mut floats = [0.0; LANES];
            for (float, size) in floats.iter_mut().zip(sizes) {
                // At most 2^16; as a signed number it takes one instruction.
                *float = *size as i32 as f32;
            }
            floats
        };
        let x = Axis::around::<WRAPPED>(u, &float(&levels.width), around.u);
        let y = Axis::around::<WRAPPED>(v, &float(&levels.height), around.v);
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
                self.bilinear_block::<false>(uv, &levels, mask, colors);
            }
            _ => for_lanes(mask, |lane| {
                colors[lane] = self.magnified(vec2(uv[0][lane], uv[1][lane]));
            }),
        }
    }

    /// The colours of footprints by the filter of what is made smaller.
    #[inline(always)]
    pub(super) fn minified_block(&self, of: &FootprintBlock, mask: u32, colors: &mut Colors) {
        let Filtering { mip_filter, filter, .. } = self.how;
        let is_bilinear = *filter == Filter::Bilinear && self.is_plain();
        let probes = match mip_filter {
            MipFilter::Linear if is_bilinear => self.middles(of),
            MipFilter::Anisotropic { probes } if is_bilinear => self.along_axes(of, *probes, mask),
            _ => return for_lanes(mask, |lane| colors[lane] = self.sample(&of.get(lane))),
        };
        self.means(&of.uv, &probes, mask, colors);
    }

    /// Whether the four texels around a point are in the picture, and have numbers of 32 bits.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.texels.has_short_numbers() && !self.how.around.has_border()
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

    /// Columns and rows of the texels in which points lie.
    #[inline(always)]
    fn nearest_places(&self, [u, v]: &[Lanes; 2]) -> ([u32; LANES], [u32; LANES]) {
        let (size, around) = (self.base.size, &self.how.around);
        (nearest_indices(u, size.width, around.u), nearest_indices(v, size.height, around.v))
    }

    /// The bilinear means at points, each on a level of its own, whose coordinates may be wrapped already.
    #[inline(always)]
    fn bilinear_block<const WRAPPED: bool>(
        &self,
        uv: &[Lanes; 2],
        levels: &Levels,
        mask: u32,
        colors: &mut Colors,
    ) {
        let around = &self.how.around;
        let Surrounding { texels, fraction: [x, y] } =
            &Surrounding::of::<WRAPPED>(uv, levels, around);
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
                colors[lane] = if F::OPAQUE { color.with_w(1.0) } else { color };
            },
        );
    }

    /// The trilinear means; of what is magnified, the bilinear ones.
    #[inline(always)]
    fn trilinear_block(&self, uv: &[Lanes; 2], lambdas: &Lanes, mask: u32, colors: &mut Colors) {
        let (mut levels, mut fractions, mut between) = ([0; LANES], [0.0; LANES], 0);
        for lane in 0..LANES {
            (levels[lane], fractions[lane]) = self.levels(lambdas[lane]);
            between |= u32::from(fractions[lane] > 0.0) << lane;
        }
        let uv = wrapped_block(uv, &self.how.around);
        // The finer level of all, then the coarser one of those that are between two.
        between &= mask;
        let mut coarser = [Vec4::ZERO; LANES];
        for (step, mask) in [(0, mask), (1, between)] {
            if mask != 0 {
                let mut numbers = levels;
                for number in &mut numbers {
                    *number += step;
                }
                let means = if step == 0 { &mut *colors } else { &mut coarser };
                self.bilinear_block::<true>(&uv, &Levels::of(self.texels, &numbers), mask, means);
            }
        }
        for_lanes(between, |lane| {
            colors[lane] = mix(colors[lane], coarser[lane], fractions[lane]);
        });
    }

    /// A probe at the middle of each footprint.
    #[inline(always)]
    fn middles(&self, of: &FootprintBlock) -> Probes {
        let mut probes = Probes::default();
        for (lane, lambda) in probes.lambdas.iter_mut().enumerate() {
            *lambda = self.how.adjusted(self.sides(of, lane).lambda());
        }
        probes
    }

    /// Probes along the longer axes of footprints.
    #[inline(always)]
    fn along_axes(&self, of: &FootprintBlock, most: u32, mask: u32) -> Probes {
        let (mut oblong, mut all) = ([false; LANES], 0);
        for (lane, oblong) in oblong.iter_mut().enumerate() {
            *oblong = !self.sides(of, lane).are_round();
            all |= u32::from(*oblong) << lane;
        }
        if all & mask == 0 {
            return self.middles(of);
        }
        let mut probes = Probes::default();
        if !all & mask != 0 {
            probes = self.middles(of);
        }
        for (lane, is_oblong) in oblong.into_iter().enumerate() {
            let ellipse = self.sides(of, lane).ellipse();
            let (count, lambda) = ellipse.probes(most);
            let (axis, weights) = ellipse.axis();
            let along = axis / self.size();
            [probes.along[0][lane], probes.along[1][lane]] = along.to_array();
            if is_oblong {
                (probes.counts[lane], probes.lambdas[lane]) = (count, self.how.adjusted(lambda));
                [probes.weights[0][lane], probes.weights[1][lane]] = weights.to_array();
            }
        }
        for_lanes(mask, |lane| probes.most = probes.most.max(probes.counts[lane]));
        probes
    }

    /// The means of probes, in colours that are 0 before.
    #[inline(always)]
    fn means(&self, middles: &[Lanes; 2], probes: &Probes, mask: u32, colors: &mut Colors) {
        let Probes { counts, lambdas, along, weights, most } = probes;
        let (are_single, mut sums) = (*most == 1, [0.0; LANES]);
        for i in 0..*most {
            let (mut moved, mut left, mut probe) = ([[0.0; LANES]; 2], mask, [Vec4::ZERO; LANES]);
            let mut weight = [1.0; LANES];
            // A single probe is at the middle itself; several are moved, and added up.
            let (uv, into) = if are_single {
                (middles, &mut *colors)
            } else {
                left = 0;
                for lane in 0..LANES {
                    let (count, t) = (counts[lane], probe_at(i, counts[lane]));
                    weight[lane] = Weights::from([weights[0][lane], weights[1][lane]]).at(t);
                    sums[lane] += if count > i { weight[lane] } else { 0.0 };
                    for axis in 0..2 {
                        let middle = middles[axis][lane];
                        let away = middle + along[axis][lane] * t;
                        moved[axis][lane] = if count > 1 { away } else { middle };
                    }
                    left |= u32::from(count > i) << lane;
                }
                left &= mask;
                (&moved, &mut probe)
            };
            self.trilinear_block(uv, lambdas, left, into);
            if !are_single {
                for_lanes(left, |lane| {
                    colors[lane] = match counts[lane] {
                        1 => probe[lane],
                        _ => colors[lane] + probe[lane] * weight[lane],
                    };
                });
            }
        }
        if !are_single {
            for_lanes(mask, |lane| {
                // One probe weighs 1, or whatever it weighs.
                colors[lane] /= if counts[lane] > 1 { sums[lane] } else { 1.0 };
            });
        }
    }
}

/// How many probes each lane takes, at which level of detail, and the axis that they are spread along.
struct Probes {
    counts: [u32; LANES],
    lambdas: Lanes,
    along: [Lanes; 2],
    /// How they weigh: [`Weights`], number by number.
    weights: [Lanes; 2],
    /// The greatest of the counts.
    most: u32,
}

impl Default for Probes {
    /// One at the middle of each, of level 0.
    #[inline(always)]
    fn default() -> Self {
        let (along, weights) = ([[0.0; LANES]; 2], Weights::ALIKE.to_array().map(|w| [w; LANES]));
        Self { counts: [1; LANES], lambdas: [0.0; LANES], along, weights, most: 1 }
    }
}

impl Chain<'_, Srgba8<'_, true>> {
    /// The codes of the texels in which points lie, of a picture without a border.
    #[inline(always)]
    pub(super) fn codes_block(&self, uv: &[Lanes; 2], mask: u32, codes: &mut Codes) {
        let (x, y) = self.nearest_places(uv);
        let mut numbers = [0; LANES];
        for lane in 0..LANES {
            numbers[lane] = y[lane].wrapping_mul(self.base.size.width).wrapping_add(x[lane]);
        }
        for_lanes(mask, |lane| {
            codes[lane] = self.base.code_numbered(numbers[lane] as usize).unwrap_or_default();
        });
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
