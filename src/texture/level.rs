//! Which levels of a mip chain a footprint asks for, and along which axes it is long.

use glam::{Vec2, vec2};

/// How a picture is filtered where a pixel sees more than a texel of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MipFilter {
    /// As where it is magnified, by the texture's [`Filter`](crate::texture::Filter) on the picture
    /// itself. It aliases.
    #[default]
    Off,
    /// By the texture's filter on the level whose texels are nearest to a pixel's size.
    Nearest,
    /// Trilinear: bilinear on the two levels beside that size, which are mixed (Williams 1983). A
    /// slanted footprint is blurred.
    Linear,
    /// As many trilinear samples along the longer axis of the footprint's ellipse as it is longer than
    /// the shorter one, at most `probes`, which counts from 1 to 64: sharp where a plane is seen at a
    /// slant. They weigh as the sections of the pixel across the axis.
    Anisotropic {
        /// The most samples.
        probes: u32,
    },
    /// The mean of all texels in the footprint's ellipse, weighted by a Gaussian (Heckbert,
    /// "Fundamentals of Texture Mapping and Image Warping", 1989, section 3.5.9), on the two levels
    /// beside the size of its shorter axis. An ellipse that is more than `eccentricity` times as long
    /// as it is wide is widened; this counts from 1 to 64.
    Ewa {
        /// The longer axis by the shorter one, at most.
        eccentricity: u32,
    },
}

/// The most probes, and the greatest eccentricity.
pub(super) const MOST_PROBES: u32 = 64;

/// By how much of the shorter axis the longer one of a circle may be longer.
const ROUND: f32 = 1.0 / 1024.0;

/// What a pixel sees of a picture, in texels: the sides of its parallelogram.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sides {
    pub(super) dx: Vec2,
    pub(super) dy: Vec2,
}

/// The ellipse that a circle of a pixel's size becomes on a picture of so many texels: the image of the
/// unit circle under the Jacobian, whose axes are that matrix's singular vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// Along the longer axis, of length 1.
    pub(super) direction: Vec2,
    /// The length of the longer half axis, in texels.
    pub(super) major: f32,
    /// That of the shorter one.
    pub(super) minor: f32,
    /// Across what becomes the longer axis, the sections of the pixel are those of a trapezoid, the convolution of two
    /// boxes: the wider one and the narrower one, in sides of the pixel.
    boxes: [f32; 2],
}

/// How probes along an axis weigh: as the sections of the pixel there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    middle: f32,
    slope: f32,
}

impl Weights {
    /// Those of a single probe.
    pub(super) const ALIKE: Self = Self { middle: 1.0, slope: 0.0 };

    pub(super) fn to_array(self) -> [f32; 2] {
        [self.middle, self.slope]
    }

    /// The weight at a part of the axis, from -1/2 to 1/2.
    #[inline(always)]
    pub(super) fn at(self, t: f32) -> f32 {
        let weight = self.middle - self.slope * t.abs();
        // What is not a number weighs as all else.
        if weight < 1.0 { weight } else { 1.0 }
    }
}

impl From<[f32; 2]> for Weights {
    #[inline(always)]
    fn from([middle, slope]: [f32; 2]) -> Self {
        Self { middle, slope }
    }
}

/// The part of the trapezoid that has probes: the wider box, and so much of the narrower one. What is beyond weighs
/// little, and would take the probes apart.
const ENDS: f32 = 0.8;

impl Sides {
    /// The level of detail: the logarithm to base 2 of the longer side. Of what is not a number, that of
    /// a point.
    #[inline(always)]
    pub(super) fn lambda(&self) -> f32 {
        let (x, y) = (self.dx.length_squared(), self.dy.length_squared());
        0.5 * log2(if x > y { x } else { y })
    }

    /// The symmetric matrix J J^T = (a b; b c), as the mean of a and c, half their difference, and b.
    #[inline(always)]
    fn squares(&self) -> (f32, f32, f32) {
        let Self { dx, dy } = *self;
        let (a, b, c) =
            (dx.x * dx.x + dy.x * dy.x, dx.x * dx.y + dy.x * dy.y, { dx.y * dx.y + dy.y * dy.y });
        (0.5 * (a + c), 0.5 * (a - c), b)
    }

    /// Whether the ellipse is a circle but for rounding: one axis is longer than the other by no more than a
    /// thousandth. So much is known without a root.
    #[inline(always)]
    pub(super) fn are_round(&self) -> bool {
        let (mean, half, b) = self.squares();
        let root = mean * ROUND;
        half * half + b * b <= root * root
    }

    /// The ellipse.
    #[inline(always)]
    pub(super) fn ellipse(&self) -> Ellipse {
        let Self { dx, dy } = *self;
        // It has the axes as eigenvectors, and the squares of their lengths as eigenvalues.
        let (mean, half, b) = self.squares();
        let root = (half * half + b * b).sqrt();
        let major = (mean + root).sqrt();
        // The sum that has no difference in it.
        let axis = if half >= 0.0 { vec2(half + root, b) } else { vec2(b, root - half) };
        let length = axis.length();
        let direction = if length > 0.0 { axis / length } else { Vec2::X };
        let minor = if major > 0.0 { dx.perp_dot(dy).abs() / major } else { 0.0 };
        let (x, y) = (dx.dot(direction).abs() / major, dy.dot(direction).abs() / major);
        let [wide, narrow] = if x > y { [x, y] } else { [y, x] };
        // Of a circle, any direction is an axis: from there on the trapezoid begins as the box of the pixel's own size.
        let part = major / minor - 1.0;
        let part = if part > 0.0 { part } else { 0.0 };
        let part = if part < 1.0 { part } else { 1.0 };
        let boxes = [1.0 + (wide - 1.0) * part, narrow * part];
        Ellipse { direction, major, minor, boxes }
    }
}

impl Ellipse {
    /// The axis that probes lie along, from end to end, and how they weigh.
    #[inline(always)]
    pub(super) fn axis(&self) -> (Vec2, Weights) {
        let [wide, narrow] = self.boxes;
        let scale = 1.0 / if narrow > 1e-6 { narrow } else { 1e-6 };
        let weights =
            Weights { middle: 0.5 * (wide + narrow) * scale, slope: self.length() * scale };
        (self.direction * (self.major * self.length()), weights)
    }

    /// The length of the axis that probes lie along, by that of the longer half axis.
    #[inline(always)]
    fn length(&self) -> f32 {
        let [wide, narrow] = self.boxes;
        wide + ENDS * narrow
    }

    /// How many probes there are along the longer axis, at most `most`, and at which level of detail
    /// each of them.
    #[inline(always)]
    pub(super) fn probes(&self, most: u32) -> (u32, f32) {
        let most = most.clamp(1, MOST_PROBES) as f32;
        // NaN, of nothing by nothing, is a circle as well.
        let ratio = self.major / self.minor - ROUND;
        let ratio = if ratio > 1.0 { ratio } else { 1.0 };
        let count = if ratio < most { ratio.ceil() } else { most };
        (count as u32, log2(self.major / count))
    }
}

/// The logarithm to base 2, to 2^-22, by the same arithmetic on every machine. What is not positive
/// counts as the smallest number there is, and an infinity as the largest.
#[inline(always)]
pub(super) fn log2(x: f32) -> f32 {
    let x = if x > f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE };
    let x = if x < f32::MAX { x } else { f32::MAX };
    // x = 2^e m, with m from the root of 1/2 to the root of 2.
    let bits = x.to_bits();
    let e = (bits.wrapping_sub(0x3f35_04f3) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((e << 23) as u32));
    // log m = 2 artanh t, with t up to 0.172: the series' next term is below 2^-30.
    let t = (m - 1.0) / (m + 1.0);
    let s = t * t;
    const SCALE: f32 = std::f32::consts::LOG2_E * 2.0;
    let series = 1.0 / 9.0;
    let series = series * s + 1.0 / 7.0;
    let series = series * s + 1.0 / 5.0;
    let series = series * s + 1.0 / 3.0;
    let series = series * s + 1.0;
    series * t * SCALE + e as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_right() {
        for bits in (1.0e-37_f32.to_bits()..1e38_f32.to_bits()).step_by(9973) {
            let x = f32::from_bits(bits);
            let exact = f64::from(x).log2();
            let error = (f64::from(log2(x)) - exact).abs();
            assert!(error < 2.4e-7 * exact.abs().max(1.0), "{x:e}: {error:e}");
        }
        for power in -126..=127 {
            assert_eq!(log2(2.0_f32.powi(power)), power as f32);
        }
        assert_eq!([0.0, -1.0, f32::NAN].map(log2), [-126.0; 3]);
        assert_eq!(log2(f32::INFINITY), log2(f32::MAX));
    }

    /// Points of a pixel, counted between parallel lines across the axis that probes lie along.
    #[test]
    fn weights_are_the_sections_of_the_pixel() {
        for (turn, across) in [(0.0_f32, 0.5), (0.2, 0.3), (0.5, 1.0), (0.785, 0.1), (1.4, 0.0)] {
            let (x, y) = (vec2(turn.cos(), turn.sin()), vec2(-turn.sin(), turn.cos()));
            // The pixel is turned, then made eight times as long along one direction.
            let long = |v: Vec2| vec2(v.x * 8.0, v.y + across * v.x);
            let sides = Sides { dx: long(x), dy: long(y) };
            let ellipse = sides.ellipse();
            let (axis, weights) = ellipse.axis();
            const BINS: usize = 16;
            let mut counts = [0.0; BINS];
            for i in 0..1000 * 1000 {
                let place = vec2((i % 1000) as f32 + 0.5, (i / 1000) as f32 + 0.5) / 1000.0 - 0.5;
                let seen = sides.dx * place.x + sides.dy * place.y;
                let t = seen.dot(axis) / axis.length_squared() + 0.5;
                if (0.0..1.0).contains(&t) {
                    counts[(t * BINS as f32) as usize] += 1.0;
                }
            }
            let wanted: Vec<f32> = (0..BINS)
                .map(|bin| {
                    let parts = (0..64).map(|i| (i as f32 + 0.5) / 64.0);
                    let t = |part: f32| (bin as f32 + part) / BINS as f32 - 0.5;
                    parts.map(|part| weights.at(t(part))).sum::<f32>() / 64.0
                })
                .collect();
            let (all, whole) = (counts.iter().sum::<f32>(), wanted.iter().sum::<f32>());
            for (count, weight) in counts.iter().zip(&wanted) {
                let error = (count / all - weight / whole).abs() * BINS as f32;
                assert!(error < 0.02, "{turn}: {counts:?} {wanted:?}");
            }
        }
    }

    #[test]
    fn the_axes_are_the_singular_vectors() {
        let mut bits = 1_u32;
        let mut number = || {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (bits >> 8) as f32 / 8_388_608.0 - 1.0
        };
        for _ in 0..10_000 {
            let sides = Sides { dx: vec2(number(), number()), dy: vec2(number(), number()) * 8.0 };
            let Ellipse { direction, major, minor, .. } = sides.ellipse();
            // By definition: the farthest point of the image of the unit circle.
            let far = (0..720).map(|i| (f64::from(i) * 0.25).to_radians()).map(|angle| {
                let point = sides.dx.as_dvec2() * angle.cos() + sides.dy.as_dvec2() * angle.sin();
                (point.length(), point)
            });
            let (length, point) = far.max_by(|a, b| a.0.total_cmp(&b.0)).expect("points");
            assert!((f64::from(major) / length - 1.0).abs() < 2e-5, "{sides:?}");
            let area = f64::from(sides.dx.perp_dot(sides.dy)).abs();
            assert!((f64::from(major * minor) - area).abs() < 1e-5 * (1.0 + area));
            if major > 1.5 * minor {
                let across = point.perp_dot(direction.as_dvec2()).abs() / length;
                assert!(across < 0.02, "{sides:?}: {direction}");
            }
        }
    }
}
