//! From a texture coordinate along one axis to the texels there, wrapped at the picture's edges.

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
}

/// The indices of two neighbouring texels along one axis, and how far the point has come from the
/// centre of the first to that of the second: 0 at the first, and always below 1.
pub(super) struct Neighbours {
    pub(super) low: u32,
    pub(super) high: u32,
    pub(super) fraction: f32,
}

impl Neighbours {
    /// Those on both sides of a coordinate, along an axis of `size` texels.
    #[inline]
    pub(super) fn around(coordinate: f32, size: u32, wrap: Wrap) -> Self {
        let last = (size - 1) as f32;
        // In this unit the centre of texel i is at i, and all lie from -0.5 to last + 0.5.
        let position = wrapped(coordinate, wrap) * size as f32 - 0.5;
        let low = position.floor();
        let high = low + 1.0;
        let fraction = position - low;
        let (low, high) = match wrap {
            // Left of the first centre the neighbour is the last texel, and the other way round.
            Wrap::Repeat => {
                (if low < 0.0 { last } else { low }, if high > last { 0.0 } else { high })
            }
            // A mirror shows the edge texel beside itself, which is what clamping does.
            Wrap::Clamp | Wrap::Mirror => (low.max(0.0), high.min(last)),
        };
        Self { low: index(low), high: index(high), fraction }
    }
}

/// The index of the texel that a coordinate lies in: the whole part of coordinate times size, wrapped.
///
/// In `f32` that product may round up to the line between two texels. Here it is an `f64`, which has
/// room for the 24 bits of any `f32` beside the 17 of a size, so that nothing is rounded.
#[inline]
pub(super) fn nearest_index(coordinate: f32, size: u32, wrap: Wrap) -> u32 {
    let (last, size) = (size - 1, f64::from(size));
    match wrap {
        Wrap::Repeat => {
            let texels = f64::from(coordinate) * size;
            // Where the repetition begins that the coordinate lies in. This is exact as well.
            let start = f64::from(coordinate.floor()) * size;
            // 2^52 plus a number has the nearest integer in its lowest mantissa bits. That is the
            // texel or the one after it, and an exact comparison tells which. NaN, which an infinity
            // leads to as well, has zeros in those bits, and every comparison with it is false.
            let shifted = texels - start + 4_503_599_627_370_496.0;
            let nearest = shifted - 4_503_599_627_370_496.0;
            let index = shifted.to_bits() as u32 & 0x1_FFFF;
            index - u32::from(start + nearest > texels)
        }
        // The wrapped coordinate is exact; 1 belongs to the last texel.
        Wrap::Clamp | Wrap::Mirror => {
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
#[inline]
fn wrapped(coordinate: f32, wrap: Wrap) -> f32 {
    let wrapped = match wrap {
        Wrap::Repeat => coordinate - coordinate.floor(),
        Wrap::Clamp => coordinate,
        Wrap::Mirror => {
            // Even, with period 2: up from 0 to 1, down from 1 to 2.
            let half = 0.5 * coordinate.abs();
            let phase = 2.0 * (half - half.floor());
            phase.min(2.0 - phase)
        }
    };
    // Infinity minus infinity is NaN, which fails the comparison and becomes 0.
    if wrapped > 0.0 { wrapped.min(1.0) } else { 0.0 }
}

/// A whole number from 0 to 65535 as an integer.
///
/// 2^23 plus the number has it in its lowest mantissa bits. An `as` cast would spend several
/// instructions on NaN and on numbers out of range, which do not occur here.
#[inline]
fn index(whole: f32) -> u32 {
    (whole + 8_388_608.0).to_bits() & 0xFFFF
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::limits::MAX_SIDE;

    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];

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
            return if wrap == Wrap::Clamp && u > 0.0 { size - 1 } else { 0 };
        }
        let (n, (mantissa, shift)) = (i128::from(size), rational(u));
        // Shifting to the right rounds down.
        let index = match wrap {
            Wrap::Repeat => ((mantissa * n) >> shift).rem_euclid(n),
            Wrap::Clamp => ((mantissa * n) >> shift).clamp(0, n - 1),
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
