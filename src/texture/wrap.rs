//! From a texture coordinate along one axis to the texels there, wrapped at the picture's edges.

use glam::{Vec2, Vec4};

/// Which part of the picture a coordinate outside 0 to 1 shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Wrap {
    /// The picture is repeated without end, and without a seam under
    /// [`Filter::Bilinear`](crate::texture::Filter::Bilinear).
    #[default]
    Repeat,
    /// The picture's edge continues for ever.
    Clamp,
    /// The picture is repeated, each time as the mirror image of its neighbour.
    Mirror,
    /// Outside there is the texture's [border colour](crate::Texture::with_border).
    Border,
}

/// The index of a texel outside the picture, where the border colour is.
pub(super) const OUTSIDE: u32 = u32::MAX;

/// The indices of two neighbouring texels along one axis, and how far the point has come from the
/// centre of the first to that of the second: 0 at the first, and always below 1.
pub(super) struct Neighbours {
    pub(super) low: u32,
    pub(super) high: u32,
    pub(super) fraction: f32,
}

impl Neighbours {
    /// Those on both sides of a point, along u and along v of a picture of `width` x `height` texels.
    #[inline(always)]
    pub(super) fn of_point(uv: Vec2, size: (u32, u32), wraps: (Wrap, Wrap)) -> (Self, Self) {
        if wraps == (Wrap::Repeat, Wrap::Repeat) {
            Self::of_repeated(uv, size)
        } else {
            let (width, height) = size;
            let along = |c, size: u32, wrap| Self::around(c, size as f32, wrap);
            (along(uv.x, width, wraps.0), along(uv.y, height, wraps.1))
        }
    }

    /// The same as [`around`](Self::around) for [`Wrap::Repeat`] along both axes, which are worked on
    /// at once: it is half the work of the most usual case.
    #[inline(always)]
    fn of_repeated(uv: Vec2, (width, height): (u32, u32)) -> (Self, Self) {
        let one = Vec4::ONE;
        let below = |rounded: Vec4, x: Vec4| Vec4::select(rounded.cmpgt(x), rounded - one, rounded);
        let uv = Vec4::new(uv.x, uv.y, 0.0, 0.0);
        let size = Vec4::new(width as f32, height as f32, 1.0, 1.0);
        let large = Vec4::splat(WHOLE).copysign(uv);
        let whole = below((uv + large) - large, uv);
        let whole = Vec4::select(uv.abs().cmplt(Vec4::splat(WHOLE)), whole, uv);
        let wrapped = uv - whole;
        let wrapped = Vec4::select(wrapped.cmpgt(Vec4::ZERO), wrapped, Vec4::ZERO);
        let wrapped = Vec4::select(wrapped.cmplt(one), wrapped, one);

        let position = wrapped * size - Vec4::splat(0.5);
        let large = Vec4::splat(HALF_MORE);
        let low = below((position + large) - large, position);
        let fraction = position - low;
        let (high, last) = (low + one, size - one);
        let high = Vec4::select(high.cmpgt(last), Vec4::ZERO, high);
        let low = Vec4::select(low.cmplt(Vec4::ZERO), last, low);
        let (low, high) = (low + Vec4::splat(WHOLE), high + Vec4::splat(WHOLE));
        let axis = |low: f32, high: f32, fraction| Self {
            low: low.to_bits() & 0xFFFF,
            high: high.to_bits() & 0xFFFF,
            fraction,
        };
        (axis(low.x, high.x, fraction.x), axis(low.y, high.y, fraction.y))
    }

    /// Those on both sides of a coordinate, along an axis of `size` texels.
    #[inline(always)]
    pub(super) fn around(coordinate: f32, size: f32, wrap: Wrap) -> Self {
        if wrap == Wrap::Border {
            return Self::within_border(coordinate, size);
        }
        Self::around_wrapped(wrapped(coordinate, wrap), size, wrap)
    }

    /// Those on both sides of a [wrapped] coordinate, from 0 to 1, where there is no border.
    #[inline(always)]
    pub(super) fn around_wrapped(wrapped: f32, size: f32, wrap: Wrap) -> Self {
        let last = size - 1.0;
        // In this unit the centre of texel i is at i, and all lie from -0.5 to last + 0.5.
        let position = wrapped * size - 0.5;
        let low = floor_above_minus_one(position);
        let high = low + 1.0;
        let fraction = position - low;
        let (low, high) = match wrap {
            // Left of the first centre the neighbour is the last texel, and the other way round.
            Wrap::Repeat => {
                (if low < 0.0 { last } else { low }, if high > last { 0.0 } else { high })
            }
            // A mirror shows the edge texel beside itself, which is what clamping does.
            _ => (if low < 0.0 { 0.0 } else { low }, if high > last { last } else { high }),
        };
        Self { low: whole(low), high: whole(high), fraction }
    }

    /// Those on both sides of a coordinate, which may be outside the picture.
    fn within_border(coordinate: f32, size: f32) -> Self {
        // Farther out there is nothing but the border. NaN counts as 0.
        let near = coordinate.clamp(-1.0, 2.0);
        let position = if near.is_nan() { 0.0 } else { near } * size - 0.5;
        let low = floor(position);
        // A saturating cast takes what is below 0 for 0, so it is told apart before.
        let inside = |i: f32| if i >= 0.0 && i < size { i as u32 } else { OUTSIDE };
        Self { low: inside(low), high: inside(low + 1.0), fraction: position - low }
    }
}

/// 2^23. From here on all floats are whole: adding this to a smaller number rounds it to a whole one, and
/// taking it away again is exact.
const WHOLE: f32 = 8_388_608.0;

/// 1.5 * 2^23, which does the same for numbers below 2^22 of either sign.
const HALF_MORE: f32 = 12_582_912.0;

/// Where a point is along one axis, for filters that take more than two texels.
pub(super) struct Place {
    /// The number of the texel whose centre is at the point or before it, perhaps outside the picture.
    pub(super) texel: i32,
    /// How far the point has come from there to the next centre, from 0 and below 1.
    pub(super) fraction: f32,
}

impl Place {
    /// Where a coordinate is along an axis of `size` texels.
    #[inline]
    pub(super) fn of(coordinate: f32, size: u32, wrap: Wrap) -> Self {
        /// Beyond, nothing is near but the edge or the border, for filters of any sensible size.
        const FAR: f32 = 64.0;
        let near = match wrap {
            Wrap::Repeat => coordinate - floor(coordinate),
            // A mirrored picture and the picture repeat together. As above this is exact.
            Wrap::Mirror => coordinate - 2.0 * floor(0.5 * coordinate),
            Wrap::Clamp | Wrap::Border => coordinate.clamp(-FAR, FAR),
        };
        let near = if near.is_nan() { 0.0 } else { near };
        let position = near * size as f32 - 0.5;
        let low = floor(position);
        Self { texel: low as i32, fraction: position - low }
    }
}

/// The index of a texel by its number, which may be outside the picture.
#[inline]
pub(super) fn wrapped_index(texel: i32, size: u32, wrap: Wrap) -> u32 {
    let n = size as i32;
    let index = match wrap {
        _ if (0..n).contains(&texel) => texel,
        Wrap::Repeat => texel.rem_euclid(n),
        Wrap::Clamp => texel.clamp(0, n - 1),
        Wrap::Mirror => {
            let phase = texel.rem_euclid(2 * n);
            phase.min(2 * n - 1 - phase)
        }
        Wrap::Border => return OUTSIDE,
    };
    index as u32
}

/// The greatest whole number that is not above a number; of what is not finite, and of numbers so large
/// that all are whole, themselves.
///
/// Without SSE4.1 `f32::floor` is a call to a function of the system. This is the same number, for -0 as
/// well but for the sign.
#[inline(always)]
pub(super) fn floor(x: f32) -> f32 {
    let large = WHOLE.copysign(x);
    let rounded = (x + large) - large;
    let floor = if rounded > x { rounded - 1.0 } else { rounded };
    if x.abs() < WHOLE { floor } else { x }
}

/// [`floor`] of a number from -1 to 2^16, for which that is less work.
#[inline(always)]
pub(super) fn floor_above_minus_one(x: f32) -> f32 {
    let rounded = (x + HALF_MORE) - HALF_MORE;
    if rounded > x { rounded - 1.0 } else { rounded }
}

/// The index of the texel that a coordinate lies in: the whole part of coordinate times size, wrapped.
///
/// In `f32` that product may round up to the line between two texels. Here it is an `f64`, which has
/// room for the 24 bits of any `f32` beside the 17 of a size, so that nothing is rounded.
#[inline(always)]
pub(super) fn nearest_index(coordinate: f32, size: u32, wrap: Wrap) -> u32 {
    let (last, size) = (size - 1, f64::from(size));
    match wrap {
        Wrap::Repeat => {
            let texels = f64::from(coordinate) * size;
            // Where the repetition begins that the coordinate lies in. This is exact as well.
            let start = f64::from(floor(coordinate)) * size;
            // 2^52 plus a number has the nearest integer in its lowest mantissa bits. That is the
            // texel or the one after it, and an exact comparison tells which. NaN, which an infinity
            // leads to as well, has zeros in those bits, and every comparison with it is false.
            let shifted = texels - start + 4_503_599_627_370_496.0;
            let nearest = shifted - 4_503_599_627_370_496.0;
            let index = shifted.to_bits() as u32 & 0x1_FFFF;
            index - u32::from(start + nearest > texels)
        }
        Wrap::Border if coordinate < 0.0 => OUTSIDE,
        Wrap::Border if coordinate >= 1.0 => OUTSIDE,
        // The wrapped coordinate is exact; 1 belongs to the last texel.
        Wrap::Clamp | Wrap::Mirror | Wrap::Border => {
            ((f64::from(wrapped(coordinate, wrap)) * size) as u32).min(last)
        }
    }
}

/// The coordinate brought into 0 to 1.
///
/// `x - x.floor()` is a multiple of the unit in the last place of x, and no greater than 1, so it is
/// a float and nothing is lost. Only for x from -0.5 to 0, which may be finer than the result can be,
/// it is rounded to the nearest float. For the tiniest x this is 1, which is the right end of the
/// picture to every caller.
#[inline(always)]
pub(super) fn wrapped(coordinate: f32, wrap: Wrap) -> f32 {
    let wrapped = match wrap {
        Wrap::Repeat => coordinate - floor(coordinate),
        Wrap::Clamp | Wrap::Border => coordinate,
        Wrap::Mirror => {
            // Even, with period 2: up from 0 to 1, down from 1 to 2.
            let half = 0.5 * coordinate.abs();
            let phase = 2.0 * (half - floor(half));
            phase.min(2.0 - phase)
        }
    };
    // Infinity minus infinity is NaN, which fails the comparison and becomes 0.
    let wrapped = if wrapped > 0.0 { wrapped } else { 0.0 };
    if wrapped < 1.0 { wrapped } else { 1.0 }
}

/// A whole number from 0 to 65535 as an integer.
///
/// 2^23 plus the number has it in its lowest mantissa bits. An `as` cast would spend several
/// instructions on NaN and on numbers out of range, which do not occur here.
#[inline]
pub(super) fn whole(number: f32) -> u32 {
    (number + WHOLE).to_bits() & 0xFFFF
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::limits::MAX_SIDE;

    const WRAPS: [Wrap; 4] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror, Wrap::Border];

    /// Sizes: all small ones, those beside powers of two, and some others.
    fn sizes() -> impl Iterator<Item = u32> {
        let powers = (6..=16).flat_map(|power| [(1 << power) - 1, 1 << power, (1 << power) + 1]);
        (1..=40)
            .chain(powers)
            .chain([100, 641, 1000, 1366, 10_007, 54_321, 65_535])
            .filter(|&size| size <= MAX_SIDE)
    }

    /// The floats on both sides of a number, and those beside them.
    fn around(x: f32) -> [f32; 5] {
        [x.next_down().next_down(), x.next_down(), x, x.next_up(), x.next_up().next_up()]
    }

    /// A float as `mantissa / 2^shift`; it must not be finer than 2^-100.
    fn rational(x: f32) -> (i128, u32) {
        let bits = x.to_bits();
        let exponent = ((bits >> 23) & 0xFF) as i32;
        let (mantissa, exponent) = match exponent {
            0 => (bits & 0x7F_FFFF, -149),
            _ => (bits & 0x7F_FFFF | 0x80_0000, exponent - 150),
        };
        let mantissa = if bits >> 31 == 1 { -i128::from(mantissa) } else { mantissa.into() };
        if exponent >= 0 {
            // Beyond 2^60 it is a whole and even number, to whatever power; 2^60 is one too.
            (mantissa << exponent.min(60), 0)
        } else {
            // Finer than 2^-100 nothing comes but what is next to 0.
            if exponent < -100 { (mantissa.signum(), 100) } else { (mantissa, -exponent as u32) }
        }
    }

    /// The texel by integer arithmetic alone.
    fn exact_index(u: f32, size: u32, wrap: Wrap) -> u32 {
        if u.is_nan() {
            return 0;
        }
        if u.is_infinite() {
            return match wrap {
                Wrap::Clamp if u > 0.0 => size - 1,
                Wrap::Border => OUTSIDE,
                _ => 0,
            };
        }
        let (n, (mantissa, shift)) = (i128::from(size), rational(u));
        // Shifting to the right rounds down.
        let index = match wrap {
            Wrap::Repeat => ((mantissa * n) >> shift).rem_euclid(n),
            Wrap::Clamp => ((mantissa * n) >> shift).clamp(0, n - 1),
            Wrap::Border => match (mantissa * n) >> shift {
                i if i < 0 || i >= n => return OUTSIDE,
                i => i,
            },
            Wrap::Mirror => {
                let one = 1_i128 << shift;
                let phase = mantissa.rem_euclid(2 * one);
                ((phase.min(2 * one - phase) * n) >> shift).min(n - 1)
            }
        };
        index as u32
    }

    fn check(u: f32, size: u32) {
        for wrap in WRAPS {
            let (ours, exact) = (nearest_index(u, size, wrap), exact_index(u, size, wrap));
            assert_eq!(ours, exact, "u = {u:e}, {size} texels, {wrap:?}");
        }
    }

    #[test]
    fn our_floor_is_the_floor() {
        let mut bits = 1_u32;
        for _ in 0..1_000_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let spread = (bits as i32 >> 8) as f32;
            for x in [f32::from_bits(bits), spread, spread / 16.0, spread / 1024.0] {
                assert!(floor(x) == x.floor() || x.is_nan(), "{x:e}");
            }
            let near = (bits >> 8) as f32 / 256.0 - 1.0;
            assert_eq!(floor_above_minus_one(near), near.floor(), "{near}");
        }
        for x in [0.0, -0.0, 4_194_304.5, 8_388_607.5, -8_388_607.5, f32::INFINITY, f32::MIN] {
            assert!(floor(x) == x.floor(), "{x:e}");
        }
        assert!(floor(f32::NAN).is_nan());
    }

    #[test]
    fn both_axes_at_once_are_each_alone() {
        let mut bits = 1_u32;
        let mut number = || {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let fraction = (bits >> 8) as f32 / 16_777_216.0;
            if bits & 64 == 0 { f32::from_bits(bits.rotate_left(9)) } else { fraction * 9.0 - 4.0 }
        };
        let both = (Wrap::Repeat, Wrap::Repeat);
        for size in sizes() {
            for _ in 0..1000 {
                let (u, v) = (number(), number());
                let (x, y) = Neighbours::of_point(Vec2::new(u, v), (size, 7), both);
                for (ours, alone) in [
                    (x, Neighbours::around(u, size as f32, Wrap::Repeat)),
                    (y, Neighbours::around(v, 7.0, Wrap::Repeat)),
                ] {
                    assert_eq!((ours.low, ours.high), (alone.low, alone.high), "{u:e} {v:e}");
                    assert_eq!(ours.fraction.to_bits(), alone.fraction.to_bits(), "{u:e} {v:e}");
                }
            }
        }
    }

    #[test]
    fn nearest_is_not_rounded_up_to_a_line() {
        for (u, size, texel) in [(0.833_333_3, 6, 4), (0.7, 10, 6), (0.01, 100, 0)] {
            for wrap in WRAPS {
                assert_eq!(nearest_index(u, size, wrap), texel, "u = {u}, {size} texels");
            }
        }
    }

    #[test]
    fn nearest_is_exact_beside_every_line() {
        for size in sizes() {
            let step = size.div_ceil(200) as usize;
            for line in (-(2 * size as i32)..=2 * size as i32).step_by(step) {
                for u in around((f64::from(line) / f64::from(size)) as f32) {
                    check(u, size);
                }
            }
        }
    }

    #[test]
    fn nearest_is_exact_just_below_zero() {
        // One minus such a number has too many bits, even for `f64`.
        for size in sizes() {
            for line in 1..=size.min(60) {
                for u in around((-f64::from(line) / f64::from(size)) as f32) {
                    check(u, size);
                    check(u / 65_536.0, size);
                }
            }
            for power in 1..=149 {
                check(-(0.5_f32.powi(power)), size);
                check(-(0.5_f32.powi(power) * 1.999_999_9), size);
            }
        }
    }

    #[test]
    fn nearest_is_exact_far_out_and_for_what_is_no_number() {
        let mut odd =
            vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 0.0, -0.0];
        for far in [1e3, 1e5, 1e6, 4_194_304.3, 8_388_607.5, 16_777_216.0, 1e9, 1e15, 1e30] {
            odd.extend(around(far).into_iter().chain(around(-far)));
        }
        for size in sizes() {
            for &u in &odd {
                check(u, size);
            }
        }
    }

    #[test]
    fn nearest_is_exact_for_floats_of_any_bits() {
        let mut bits = 12_345_u32;
        for size in sizes() {
            for _ in 0..2000 {
                // A linear congruential generator (Numerical Recipes, 1992); the upper bits are good.
                bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                check(f32::from_bits(bits), size);
                let fraction = (bits >> 8) as f32 / 16_777_216.0;
                check(fraction, size);
                check(-fraction, size);
                check(fraction * 37.0 - 18.0, size);
            }
        }
    }
}
