//! From stored samples to texels in linear light, and back.

use std::sync::LazyLock;

use glam::{Vec3, Vec4};

use crate::color::{Color, decode, linear};

/// The texel of red, green, blue and alpha in 8 bits each, sRGB.
#[inline(always)]
pub(super) fn light_of_8([r, g, b, alpha]: [u8; 4]) -> Vec4 {
    // As the colour times alpha, with alpha beside it: 1 times alpha is alpha.
    opaque_of_8([r, g, b]) * PARTS_OF_255[usize::from(alpha)]
}

/// The opaque texel of red, green and blue in 8 bits each, sRGB.
#[inline(always)]
pub(super) fn opaque_of_8([r, g, b]: [u8; 3]) -> Vec4 {
    Vec4::new(decode(r), decode(g), decode(b), 1.0)
}

/// The texel of red, green, blue and alpha in 16 bits each, sRGB.
pub(super) fn light_of_16([r, g, b, alpha]: [u16; 4]) -> Vec4 {
    let light = [r, g, b].map(|code| DECODED_16[usize::from(code)]);
    premultiplied(light, part_of_65535(alpha))
}

/// The texel of a colour in linear light and an alpha.
#[inline]
pub(super) fn premultiplied(light: [f32; 3], alpha: f32) -> Vec4 {
    (Vec3::from_array(light) * alpha).extend(alpha)
}

/// A byte as a number from 0 to 1.
#[inline(always)]
pub(super) fn part_of_255(byte: u8) -> f32 {
    PARTS_OF_255[usize::from(byte)]
}

/// 16 bits as a number from 0 to 1.
#[inline(always)]
pub(super) fn part_of_65535(word: u16) -> f32 {
    f32::from(word) / 65_535.0
}

/// The number whose IEEE 754 binary16 form has these bits.
#[inline]
pub(super) fn of_f16(bits: u16) -> f32 {
    const INFINITY: u32 = 0x7c00 << 13;
    // The exponent of an f32 is greater by 112 for the same number; the product is exact.
    let (sign, rest) = (u32::from(bits & 0x8000) << 16, u32::from(bits & 0x7fff) << 13);
    let scale = f32::from_bits((127 + 112) << 23);
    let size =
        if rest < INFINITY { (f32::from_bits(rest) * scale).to_bits() } else { rest | 0x7f80_0000 };
    f32::from_bits(sign | size)
}

/// The bits of the binary16 number nearest to a number, half to even; an infinity beyond the largest.
pub(super) fn to_f16(number: f32) -> u16 {
    let sign = (number.to_bits() >> 16 & 0x8000) as u16;
    let size = number.abs();
    if size.is_nan() {
        return sign | 0x7e00;
    }
    // From half of the last step beyond the largest number on.
    if size >= 65_520.0 {
        return sign | 0x7c00;
    }
    if size < 1.0 / 16_384.0 {
        // Below the normal numbers the step is 2^-24: adding 0.5 rounds to it.
        return sign | ((size + 0.5).to_bits() - 0.5_f32.to_bits()) as u16;
    }
    let bits = size.to_bits();
    let rounded = bits + 0xfff + (bits >> 13 & 1);
    sign | ((rounded >> 13) - (112 << 10)) as u16
}

/// The sRGB pixel of 8 bits nearest to a texel.
pub(super) fn to_srgb8(texel: Vec4) -> [u8; 4] {
    texel.to_srgb8()
}

/// The sRGB pixel of 16 bits nearest to a texel.
pub(super) fn to_srgb16(texel: Vec4) -> [u16; 4] {
    let alpha = if texel.w > 0.0 { texel.w.min(1.0) } else { return [0; 4] };
    let [r, g, b] = (texel.truncate() / alpha).to_array().map(|light| {
        let above = DECODED_16.partition_point(|&decoded| decoded < light).min(65_535);
        let below = above.saturating_sub(1);
        let is_below = light - DECODED_16[below] < DECODED_16[above] - light;
        if is_below { below as u16 } else { above as u16 }
    });
    [r, g, b, to_word(alpha)]
}

/// A number from 0 to 1 as a byte; beyond them and NaN as the nearest, 0 for NaN.
pub(super) fn to_byte(number: f32) -> u8 {
    (number * 255.0 + 0.5) as u8
}

/// A number from 0 to 1 in 16 bits; beyond them and NaN as the nearest, 0 for NaN.
pub(super) fn to_word(number: f32) -> u16 {
    (number * 65_535.0 + 0.5) as u16
}

static PARTS_OF_255: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut byte = 0;
    while byte < 256 {
        table[byte] = byte as f32 / 255.0;
        byte += 1;
    }
    table
};

/// The light of each code of 16 bits, which is worked out when a texture needs it for the first time.
static DECODED_16: LazyLock<Box<[f32]>> = LazyLock::new(|| {
    (0..=u16::MAX).map(|code| linear(f64::from(code) / 65_535.0) as f32).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_what_ieee_754_says() {
        for bits in 0..=u16::MAX {
            let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 0x3ff));
            let size = match exponent {
                0 => fraction * 2.0_f64.powi(-24),
                31 if fraction == 0.0 => f64::INFINITY,
                31 => f64::NAN,
                _ => (1024.0 + fraction) * 2.0_f64.powi(exponent - 25),
            };
            let exact = if bits >> 15 == 1 { -size } else { size };
            let ours = of_f16(bits);
            assert!(f64::from(ours) == exact || exact.is_nan() && ours.is_nan(), "{bits:x}");
            if !ours.is_nan() {
                assert_eq!(to_f16(ours), bits);
            }
        }
    }

    #[test]
    fn numbers_become_the_nearest_halves() {
        for bits in 0..0x7bff_u16 {
            let (low, high) = (of_f16(bits), of_f16(bits + 1));
            let middle = (low + high) / 2.0;
            let even = bits + (bits & 1);
            assert_eq!(to_f16(middle), even, "{bits:x}");
            assert_eq!(to_f16(middle.next_down()), bits);
            assert_eq!(to_f16(-middle.next_up()), (bits + 1) | 0x8000);
        }
        assert_eq!([65_519.99, 65_520.0, f32::INFINITY].map(to_f16), [0x7bff, 0x7c00, 0x7c00]);
    }

    #[test]
    fn every_code_of_16_bits_survives_the_round_trip() {
        for code in 0..=u16::MAX {
            let pixel = [code, code, u16::MAX - code, u16::MAX];
            assert_eq!(to_srgb16(light_of_16(pixel)), pixel);
        }
    }
}
