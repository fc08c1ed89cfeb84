//! sRGB codes to linear light and back, the same bits on every machine.
//!
//! Pictures store colours as sRGB codes (IEC 61966-2-1), whose steps look even to the eye; light
//! adds up in linear light, so everything that blends, filters or averages works there. What flows
//! in and out is one channel at a time: [`decode`] takes a code to light, [`encode`] takes light to
//! the nearest code. [`Color`] is what a framebuffer can show: anything that has an 8-bit sRGB RGBA
//! form.
//!
//! The curve's power 2.4 would come from the platform's `powf`, whose last bits differ from one
//! machine to the next. Here the compiler works the curve out once, in `f64` arithmetic, into
//! tables; what runs is a lookup and a comparison.
//!
//! ```
//! use polyscan::color::{decode, encode};
//!
//! // Half the light of white is code 188, not 128.
//! assert_eq!(encode(0.5 * (decode(0) + decode(255))), 188);
//! ```

use glam::{Vec3, Vec4};

/// Linear light of the sRGB code `code`: 0 gives 0.0, 255 gives 1.0.
#[inline]
#[must_use]
pub fn decode(code: u8) -> f32 {
    DECODED[usize::from(code)]
}

/// The sRGB code nearest to the linear light `light`, on the scale of codes.
///
/// Light below 0 and NaN give 0, light above 1 gives 255. The rounding is exact: the result is the
/// one that real arithmetic would give, for every `f32`.
#[inline]
#[must_use]
pub fn encode(light: f32) -> u8 {
    let place = place(light);
    ((cell(place) + (place & REST)) >> REST_BITS) as u8
}

/// Where a light lies: in its highest bits the number of its cell, in the others where in the cell it is.
#[inline(always)]
fn place(light: f32) -> u32 {
    // Written as comparisons so that NaN fails the first and becomes black.
    let light = if light > DARKEST { light } else { DARKEST };
    let light = if light < BRIGHTEST { light } else { BRIGHTEST };
    (light.to_bits() - DARKEST.to_bits()) << (REST_BITS - CELL_BITS)
}

/// What is in the cell of a light.
#[inline(always)]
fn cell(place: u32) -> u32 {
    CELLS[(place >> REST_BITS) as usize]
}

/// The number of colours that [`to_srgb8_block`] takes.
const BLOCK: usize = 16;

/// [`Color::to_srgb8`] of the colours of a block: faster than one by one, if it is inlined into code that is
/// compiled for SIMD.
#[inline(always)]
pub(crate) fn to_srgb8_block(
    colors: &[Vec4; BLOCK],
    are_opaque: bool,
    pixels: &mut [[u8; 4]; BLOCK],
) {
    if !are_opaque {
        for (pixel, color) in pixels.iter_mut().zip(colors) {
            *pixel = color.to_srgb8();
        }
        return;
    }
    // Loops over flat lists, the first and the last of which become SIMD; look-ups between them would keep the
    // compiler from it.
    let mut lights = [0.0; 4 * BLOCK];
    for (lights, color) in lights.as_chunks_mut().0.iter_mut().zip(colors) {
        *lights = color.to_array();
    }
    let places = lights.map(place);
    let mut found = [0; 4 * BLOCK];
    for (found, places) in found.as_chunks_mut::<4>().0.iter_mut().zip(places.as_chunks::<4>().0) {
        for channel in 0..3 {
            found[channel] = cell(places[channel]);
        }
    }
    let mut codes = [0; 4 * BLOCK];
    for i in 0..4 * BLOCK {
        codes[i] = ((found[i] + (places[i] & REST)) >> REST_BITS) as u8;
    }
    for (pixel, codes) in pixels.iter_mut().zip(codes.as_chunks::<4>().0) {
        *pixel = (u32::from_le_bytes(*codes) | 255 << 24).to_le_bytes();
    }
}

/// A colour that a framebuffer can show as 8-bit sRGB with alpha.
///
/// | type | channels |
/// |---|---|
/// | `[u8; 4]` | sRGB codes and alpha, shown as they are |
/// | `[u8; 3]` | sRGB codes, opaque |
/// | [`Vec3`] | linear light, opaque |
/// | [`Vec4`] | linear light premultiplied by the alpha in `w` |
pub trait Color: Copy {
    /// Red, green and blue as sRGB codes (not premultiplied), then alpha from 0, clear, to 255.
    #[must_use]
    fn to_srgb8(self) -> [u8; 4];
}

impl Color for [u8; 4] {
    #[inline]
    fn to_srgb8(self) -> [u8; 4] {
        self
    }
}

impl Color for [u8; 3] {
    #[inline]
    fn to_srgb8(self) -> [u8; 4] {
        let [r, g, b] = self;
        [r, g, b, 255]
    }
}

impl Color for Vec3 {
    #[inline]
    fn to_srgb8(self) -> [u8; 4] {
        [encode(self.x), encode(self.y), encode(self.z), 255]
    }
}

impl Color for Vec4 {
    /// Alpha is clamped to 1; where it is 0, negative or NaN the colour is clear black.
    #[inline]
    fn to_srgb8(self) -> [u8; 4] {
        if self.w >= 1.0 { self.truncate().to_srgb8() } else { straight_srgb8(self) }
    }
}

/// The code of a colour that is not opaque.
fn straight_srgb8(color: Vec4) -> [u8; 4] {
    let alpha = color.w;
    if alpha > 0.0 {
        let [r, g, b, _] = (color.truncate() / alpha).to_srgb8();
        [r, g, b, (alpha * 255.0 + 0.5) as u8]
    } else {
        [0; 4]
    }
}

/// The sRGB curve: linear light, 0 to 1, of an encoded value, 0 to 1.
///
/// x^2.4 is the fifth root of x^12, so that multiplication and division suffice. The error is a few
/// units in the last place of `f64`.
pub(crate) const fn linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        return encoded / 12.92;
    }
    let x = (encoded + 0.055) / 1.055;
    let x4 = (x * x) * (x * x);
    fifth_root(x4 * x4 * x4)
}

/// Newton's method on t^5 = y, for y in (0, 1].
///
/// From t = 1, which is not below the root, each step goes down and none goes below the root, as
/// t^5 is convex; the first step that does not go down has reached the limit of `f64`.
const fn fifth_root(y: f64) -> f64 {
    let mut root = 1.0;
    loop {
        let next = (4.0 * root + y / (root * root * root * root)) / 5.0;
        if next >= root {
            return root;
        }
        root = next;
    }
}

/// The light of each code.
static DECODED: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut code = 0;
    while code < 256 {
        table[code] = linear(code as f64 / 255.0) as f32;
        code += 1;
    }
    table
};

/// For each code the least `f32` that rounds to a higher one: the light half way, on the scale of
/// codes, to the next code. Nothing is above 255.
const THRESHOLDS: [f32; 256] = {
    let mut table = [f32::INFINITY; 256];
    let mut code = 0;
    while code < 255 {
        let midpoint = linear((code as f64 + 0.5) / 255.0);
        let rounded = midpoint as f32;
        table[code] = if (rounded as f64) < midpoint { rounded.next_up() } else { rounded };
        code += 1;
    }
    table
};

/// [`encode`] cuts the lights from 2^-13 to 1 into cells: the bits of a float above the lowest 16
/// tell its octave and the 1/128 of the octave in which it lies. Cells are so narrow that at most
/// one threshold falls into each, so one comparison finishes what the table begins. [`CELLS`]
/// checks that when it is built.
const CELL_BITS: u32 = 16;
/// 2^-13, less than the lowest threshold, which is 0.5 / 255 / 12.92 = 1.24 * 2^-13.
const DARKEST: f32 = 1.0 / 8192.0;
/// The largest `f32` below 1, which lies in the last cell and is code 255 as 1 is.
const BRIGHTEST: f32 = 1.0_f32.next_down();
/// 13 octaves of 128 cells.
const CELL_COUNT: u32 = 13 << 7;
/// The power of two above is the number of cells that a [`place`] can name. It has this many bits below.
const REST_BITS: u32 = 21;
const REST: u32 = (1 << REST_BITS) - 1;
const CELL_ROOM: usize = 1 << (32 - REST_BITS);

/// For each cell the code of its least light, above the bits of [`REST`], and in those the distance from
/// the threshold in the cell to the cell's end: a sum with a place's own bits there carries into the code
/// where the light has reached the threshold.
static CELLS: [u32; CELL_ROOM] = {
    let mut table = [0; CELL_ROOM];
    let mut code = 0;
    let mut cell = 0;
    while cell < CELL_COUNT {
        let first = DARKEST.to_bits() + (cell << CELL_BITS);
        let end = first + (1 << CELL_BITS);
        while f32::from_bits(first) >= THRESHOLDS[code as usize] {
            code += 1;
        }
        let threshold = THRESHOLDS[code as usize].to_bits();
        table[cell as usize] = code << REST_BITS;
        if threshold < end {
            table[cell as usize] += (end - threshold) << (REST_BITS - CELL_BITS);
            let next = THRESHOLDS[code as usize + 1].to_bits();
            assert!(end <= next, "two thresholds in one cell");
        }
        cell += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use super::*;

    fn linear_by_powf(encoded: f64) -> f64 {
        if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    }

    #[test]
    fn every_code_survives_the_round_trip() {
        for code in 0..=255 {
            assert_eq!(encode(decode(code)), code);
        }
    }

    #[test]
    fn decode_is_the_curve_rounded_to_f32() {
        for code in 0..=255 {
            let exact = linear_by_powf(f64::from(code) / 255.0);
            let error = (f64::from(decode(code)) - exact).abs();
            // Half a unit in the last place, plus what `powf` itself may be off.
            assert!(error <= exact * f64::from(f32::EPSILON) * 0.501, "code {code}: {error:e}");
        }
    }

    /// The code by counting midpoints, or `None` within 1e-9 of one.
    fn code_by_powf(light: f64) -> Option<u8> {
        let midpoints = (0..255).map(|code| linear_by_powf((f64::from(code) + 0.5) / 255.0));
        let mut below = 0;
        for midpoint in midpoints {
            if (light - midpoint).abs() < 1e-9 {
                return None;
            }
            below += u8::from(midpoint < light);
        }
        Some(below)
    }

    #[test]
    fn encode_rounds_to_the_nearest_code() {
        // A step that divides nothing evenly, over a little more than 0 to 1.
        let mut light = -0.01_f32;
        while light < 1.01 {
            if let Some(code) = code_by_powf(f64::from(light)) {
                assert_eq!(encode(light), code, "light {light:e}");
            }
            light += 1.234_567e-5;
        }
        // The dark end again, evenly on the scale of floats.
        for bits in (1.0e-5_f32.to_bits()..0.01_f32.to_bits()).step_by(4099) {
            let light = f32::from_bits(bits);
            if let Some(code) = code_by_powf(f64::from(light)) {
                assert_eq!(encode(light), code, "light {light:e}");
            }
        }
    }

    #[test]
    fn each_threshold_is_a_step_of_one() {
        for code in 0..255_u8 {
            let threshold = THRESHOLDS[usize::from(code)];
            assert_eq!(encode(threshold), code + 1);
            assert_eq!(encode(threshold.next_down()), code);
        }
    }

    #[test]
    fn encode_never_goes_down() {
        let mut last = 0;
        for bits in (0..=1.5_f32.to_bits()).step_by(997) {
            let code = encode(f32::from_bits(bits));
            assert!(code >= last);
            last = code;
        }
        assert_eq!(last, 255);
    }

    #[test]
    fn encode_clamps_what_is_not_a_light() {
        for dark in [0.0, -0.0, -1.0, f32::MIN, f32::NEG_INFINITY, f32::NAN, -f32::NAN, 1e-40] {
            assert_eq!(encode(dark), 0, "{dark}");
        }
        for bright in [1.0, 1.0_f32.next_up(), 2.0, f32::MAX, f32::INFINITY] {
            assert_eq!(encode(bright), 255, "{bright}");
        }
    }

    #[test]
    fn colors_are_shown_as_srgb() {
        assert_eq!([1, 2, 3].to_srgb8(), [1, 2, 3, 255]);
        assert_eq!([1, 2, 3, 4].to_srgb8(), [1, 2, 3, 4]);
        assert_eq!(Vec3::new(0.0, 0.5, 2.0).to_srgb8(), [0, 188, 255, 255]);
        // Half covered by half-grey light: the premultiplied 0.25 is shown as 0.5.
        assert_eq!(Vec4::new(0.25, 0.0, 0.5, 0.5).to_srgb8(), [188, 0, 255, 128]);
        assert_eq!(Vec4::new(0.5, 0.5, 0.5, 2.0).to_srgb8(), [188, 188, 188, 255]);
        for alpha in [0.0, -1.0, f32::NAN] {
            assert_eq!(Vec4::new(1.0, 1.0, 1.0, alpha).to_srgb8(), [0; 4]);
        }
        assert_eq!(Vec4::new(f32::NAN, 0.0, 0.0, f32::INFINITY).to_srgb8(), [0, 0, 0, 255]);
    }
}
