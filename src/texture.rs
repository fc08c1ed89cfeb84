//! Pictures that shaders sample.
//!
//! What flows in is a picture (a file, an `image` picture, or a function of the pixel); what flows
//! out is a colour for any texture coordinate. Sampling here is magnification: the nearest texel,
//! or the bilinear mean of the four around the point.
//!
//! Texture coordinates have u to the right and v DOWN, as in wgpu, Direct3D and glTF: (0, 0) is the
//! top left corner of the picture, (1, 1) the bottom right one, whatever its size. The centre of
//! texel (i, j), counted from the top left, is at ((i + 0.5) / width, (j + 0.5) / height).
//!
//! Texels are kept as linear light, premultiplied by alpha, since only there is the mean of two
//! colours the colour that the eye sees from afar, and only there does a clear texel lend nothing
//! to its neighbours.
//!
//! ```
//! use glam::{Vec2, Vec4, vec2};
//! use polyscan::texture::{Filter, Texture, Wrap};
//!
//! // Two texels: black and white.
//! let texture = Texture::new(2, 1, vec![Vec4::W, Vec4::ONE])?.with_wrap(Wrap::Clamp);
//! assert_eq!(texture.sample(vec2(0.25, 0.5)), Vec4::W);
//! assert_eq!(texture.sample(vec2(0.5, 0.5)), Vec4::new(0.5, 0.5, 0.5, 1.0));
//! assert_eq!(texture.with_filter(Filter::Nearest).sample(vec2(0.5, 0.5)), Vec4::ONE);
//! # Ok::<(), polyscan::texture::TextureError>(())
//! ```

use std::path::PathBuf;

use glam::{Vec2, Vec4};

#[cfg(feature = "png")]
mod file;

/// The longest side of a texture, in texels: the side of the largest viewport.
///
/// Sampling relies on it too: each texel's index, and half a texel beside it, is exact in `f32`.
pub const MAX_SIDE: u32 = 65_536;

/// The most texels in a texture read from a file: 16384 x 16384, which takes 4 GiB here.
#[cfg(feature = "png")]
pub const MAX_FILE_TEXELS: u64 = 1 << 28;

/// The most bytes that decoding a file may allocate: 1 GiB, which is [`MAX_FILE_TEXELS`] of four
/// bytes.
#[cfg(feature = "png")]
pub const MAX_DECODE_BYTES: u64 = 1 << 30;

/// How the texels around a point become its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Filter {
    /// The texel that the point lies in.
    Nearest,
    /// The four texels whose centres surround the point, weighted by nearness along each axis.
    #[default]
    Bilinear,
}

/// What a coordinate outside 0 to 1 means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Wrap {
    /// The picture is repeated without end, and without a seam under [`Filter::Bilinear`].
    #[default]
    Repeat,
    /// The picture's edge goes on for ever.
    Clamp,
    /// The picture is repeated, each time as the mirror image of its neighbour.
    Mirror,
}

/// A picture to sample: texels in linear light, premultiplied by alpha, row 0 at the top.
#[derive(Clone)]
pub struct Texture {
    width: u32,
    height: u32,
    /// Row by row; `width * height` of them, both from 1 to [`MAX_SIDE`].
    texels: Vec<Vec4>,
    filter: Filter,
    wrap_u: Wrap,
    wrap_v: Wrap,
}

/// Why there is no texture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// A side is 0 or longer than [`MAX_SIDE`].
    #[error(
        "a texture cannot be {width} x {height} texels: each side must be from 1 to {MAX_SIDE}"
    )]
    Size {
        /// Width asked for, in texels.
        width: u32,
        /// Height asked for, in texels.
        height: u32,
    },
    /// The number of texels is not the number that the size calls for.
    #[error(
        "{given} texels were given for a texture of {width} x {height}: give {} of them, row by row",
        u64::from(*width) * u64::from(*height)
    )]
    Length {
        /// Width asked for, in texels.
        width: u32,
        /// Height asked for, in texels.
        height: u32,
        /// How many texels came.
        given: usize,
    },
    /// The machine has not enough memory for the texels.
    #[error("no memory for a texture of {width} x {height} texels of 16 bytes: use a smaller one")]
    Memory {
        /// Width asked for, in texels.
        width: u32,
        /// Height asked for, in texels.
        height: u32,
    },
    /// The file cannot be read.
    #[error("cannot read the picture {}: {source}; check its name and permissions", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is read, but is no picture of a known format, or a broken one.
    #[error("cannot decode the picture {}: {source}; save it again as {FORMATS}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What the decoder said.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The file's format is one that only the feature `image` brings a decoder for.
    #[error(
        "the picture {} is a {format} file: enable polyscan's feature `image` to read it, or save it \
         again as PNG",
        path.display()
    )]
    FeatureNeeded {
        /// The file.
        path: PathBuf,
        /// The format's name, such as JPEG.
        format: &'static str,
    },
    /// The file's picture is over the limits.
    #[error(
        "the picture {} is {width} x {height}: at most {MAX_SIDE} a side and {limit} texels in all \
         are read; scale it down",
        path.display()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its width in texels.
        width: u32,
        /// Its height in texels.
        height: u32,
        /// How many texels it might have had.
        limit: u64,
    },
}

/// The formats of files that [`Texture::open`] reads.
const FORMATS: &str = if cfg!(feature = "image") { "PNG, JPEG, TGA, BMP or PNM" } else { "PNG" };

impl Texture {
    /// A texture of `width` x `height` texels, given row by row from the top, in linear light and
    /// premultiplied by alpha.
    ///
    /// # Errors
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`], [`TextureError::Length`] if the
    /// texels are not `width * height`.
    pub fn new(width: u32, height: u32, texels: Vec<Vec4>) -> Result<Self, TextureError> {
        check_size(width, height)?;
        if texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(TextureError::Length { width, height, given: texels.len() });
        }
        let (filter, wrap) = (Filter::default(), Wrap::default());
        Ok(Self { width, height, texels, filter, wrap_u: wrap, wrap_v: wrap })
    }

    /// A texture whose texel (x, y), counted from the top left, is `texel(x, y)`: linear light,
    /// premultiplied by alpha.
    ///
    /// # Errors
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`], [`TextureError::Memory`] if the
    /// texels find no room.
    pub fn from_fn(
        width: u32,
        height: u32,
        mut texel: impl FnMut(u32, u32) -> Vec4,
    ) -> Result<Self, TextureError> {
        check_size(width, height)?;
        let mut texels = room(width, height)?;
        texels.extend(
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)),
        );
        Self::new(width, height, texels)
    }

    /// The same picture with another filter. A new texture has [`Filter::Bilinear`].
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// The same picture, wrapped alike along u and v. A new texture has [`Wrap::Repeat`].
    #[must_use]
    pub fn with_wrap(self, wrap: Wrap) -> Self {
        self.with_wraps(wrap, wrap)
    }

    /// The same picture, wrapped by `u` along the rows and by `v` along the columns.
    #[must_use]
    pub fn with_wraps(self, u: Wrap, v: Wrap) -> Self {
        Self { wrap_u: u, wrap_v: v, ..self }
    }

    /// Texels in a row, from 1 to [`MAX_SIDE`].
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows, from 1 to [`MAX_SIDE`].
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How [`sample`](Self::sample) filters.
    #[must_use]
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// How coordinates outside 0 to 1 are understood, along u and along v.
    #[must_use]
    pub fn wraps(&self) -> (Wrap, Wrap) {
        (self.wrap_u, self.wrap_v)
    }

    /// All texels, row by row from the top: linear light, premultiplied by alpha.
    #[must_use]
    pub fn texels(&self) -> &[Vec4] {
        &self.texels
    }

    /// The texel in column `x`, row `y`; beyond the last column or row, the last one.
    #[inline]
    #[must_use]
    pub fn texel(&self, x: u32, y: u32) -> Vec4 {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// The colour at `uv` by the texture's own filter: linear light, premultiplied by alpha.
    ///
    /// Any coordinate is safe and wrapped exactly as far as `f32` tells it. NaN counts as 0, and so
    /// does an infinity, unless the axis has [`Wrap::Clamp`], where it means that edge.
    #[inline]
    #[must_use]
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        match self.filter {
            Filter::Nearest => self.nearest(uv),
            Filter::Bilinear => self.bilinear(uv),
        }
    }

    /// The texel that `uv` lies in. On the line between two texels it is the right or lower one.
    #[inline]
    #[must_use]
    pub fn nearest(&self, uv: Vec2) -> Vec4 {
        let x = nearest_index(uv.x, self.width, self.wrap_u);
        let y = nearest_index(uv.y, self.height, self.wrap_v);
        self.texel(x, y)
    }

    /// The mean of the four texels around `uv`, weighted by nearness along each axis.
    #[inline]
    #[must_use]
    pub fn bilinear(&self, uv: Vec2) -> Vec4 {
        let x = Pair::around(uv.x, self.width, self.wrap_u);
        let y = Pair::around(uv.y, self.height, self.wrap_v);
        let upper = mix(self.texel(x.low, y.low), self.texel(x.high, y.low), x.fraction);
        let lower = mix(self.texel(x.low, y.high), self.texel(x.high, y.high), x.fraction);
        mix(upper, lower, y.fraction)
    }
}

impl std::fmt::Debug for Texture {
    /// Everything but the texels.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Texture")
            .field("width", &self.width)
            .field("height", &self.height)
            .field("filter", &self.filter)
            .field("wrap_u", &self.wrap_u)
            .field("wrap_v", &self.wrap_v)
            .finish_non_exhaustive()
    }
}

/// Two neighbouring texels along one axis, and how far the point is from the first's centre to the
/// second's: 0 at the first, below 1 always.
struct Pair {
    low: u32,
    high: u32,
    fraction: f32,
}

impl Pair {
    #[inline]
    fn around(coordinate: f32, size: u32, wrap: Wrap) -> Self {
        let last = (size - 1) as f32;
        // The centre of texel i is at i here, so that this lies from -0.5 to last + 0.5.
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

/// The place of the texel that a coordinate lies in: the whole part of coordinate times size, wrapped.
///
/// In `f32` that product may round up to the line between two texels. Here it is an `f64`, which has
/// room for the 24 bits of any `f32` beside the 17 of a size, so that nothing is rounded.
#[inline]
fn nearest_index(coordinate: f32, size: u32, wrap: Wrap) -> u32 {
    let (last, size) = (size - 1, f64::from(size));
    match wrap {
        Wrap::Repeat => {
            let texels = f64::from(coordinate) * size;
            // Where the pictures begin that the coordinate is in: exact as well.
            let start = f64::from(coordinate.floor()) * size;
            // 2^52 plus a number has the integer nearest to it in its lowest mantissa bits: the
            // texel, or the one after it. The comparison, which is exact, tells. NaN, which an infinity
            // leads to as well, has zeros there, and compares as false.
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
/// a float and nothing is lost. Only from -0.5 to 0, where x is finer than the result can be, it is
/// rounded to the nearest float, which is 1 for the tiniest x: the right end to every caller.
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
/// 2^23 plus the number has it in its lowest mantissa bits. An `as` cast would also check for what
/// cannot come, NaN and numbers out of range, and costs several instructions for it.
#[inline]
fn index(whole: f32) -> u32 {
    (whole + 8_388_608.0).to_bits() & 0xFFFF
}

/// From `a` at 0 to `b` at 1; two equal texels give exactly their colour.
#[inline]
fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}

fn check_size(width: u32, height: u32) -> Result<(), TextureError> {
    let sides = 1..=MAX_SIDE;
    if sides.contains(&width) && sides.contains(&height) {
        Ok(())
    } else {
        Err(TextureError::Size { width, height })
    }
}

/// An empty list with room for all texels.
fn room(width: u32, height: u32) -> Result<Vec<Vec4>, TextureError> {
    let mut texels = Vec::new();
    usize::try_from(u64::from(width) * u64::from(height))
        .ok()
        .and_then(|count| texels.try_reserve_exact(count).ok())
        .map(|()| texels)
        .ok_or(TextureError::Memory { width, height })
}

/// From the `image` crate's pictures.
#[cfg(feature = "image")]
impl Texture {
    /// The texture of a picture for the eye.
    ///
    /// Colours of 8 and 16 bits are sRGB, and are decoded before anything is averaged; colours in
    /// `f32` are linear light already. Alpha is linear in all, and the colours are multiplied by it.
    /// Grey pictures get three equal channels, pictures without alpha are opaque.
    ///
    /// # Errors
    /// As [`Texture::from_fn`]: an empty or too large picture, or no memory.
    pub fn from_image(image: &image::DynamicImage) -> Result<Self, TextureError> {
        use image::ColorType as C;
        let (width, height) = (image.width(), image.height());
        match image.color() {
            C::L8 | C::La8 | C::Rgb8 | C::Rgba8 => {
                let picture = image.to_rgba8();
                from_pixels(width, height, picture.pixels().map(|pixel| light_of_8(pixel.0)))
            }
            C::L16 | C::La16 | C::Rgb16 | C::Rgba16 => {
                let (picture, light) = (image.to_rgba16(), light_of_16());
                from_pixels(width, height, picture.pixels().map(|pixel| light(pixel.0)))
            }
            _ => {
                let light = |pixel: &image::Rgba<f32>| {
                    let [r, g, b, alpha] = pixel.0;
                    premultiplied([r, g, b], alpha)
                };
                from_pixels(width, height, image.to_rgba32f().pixels().map(light))
            }
        }
    }

    /// The texture of a picture that holds numbers, not colours: a normal map, roughness, height.
    ///
    /// The numbers are taken as they stand, integers scaled to 0 to 1; nothing is decoded, nothing
    /// multiplied by alpha.
    ///
    /// # Errors
    /// As [`Texture::from_image`].
    pub fn from_data(image: &image::DynamicImage) -> Result<Self, TextureError> {
        let numbers = image.to_rgba32f();
        let texels = numbers.pixels().map(|pixel| Vec4::from_array(pixel.0));
        from_pixels(image.width(), image.height(), texels)
    }
}

/// A texture of texels that come row by row.
#[cfg(feature = "png")]
fn from_pixels(
    width: u32,
    height: u32,
    pixels: impl Iterator<Item = Vec4>,
) -> Result<Texture, TextureError> {
    check_size(width, height)?;
    let mut texels = room(width, height)?;
    texels.extend(pixels);
    Texture::new(width, height, texels)
}

/// The texel of red, green, blue and alpha in 8 bits each.
#[cfg(feature = "png")]
fn light_of_8([r, g, b, alpha]: [u8; 4]) -> Vec4 {
    premultiplied([r, g, b].map(crate::color::decode), f32::from(alpha) / 255.0)
}

/// A function that gives the texel of red, green, blue and alpha in 16 bits each.
#[cfg(feature = "png")]
fn light_of_16() -> impl Fn([u16; 4]) -> Vec4 {
    // 65536 powers, where most pictures have more channels than that to decode.
    let lights: Vec<f32> = (0..=u16::MAX)
        .map(|code| crate::color::linear(f64::from(code) / 65_535.0) as f32)
        .collect();
    move |[r, g, b, alpha]| {
        let light = [r, g, b].map(|code| lights[usize::from(code)]);
        premultiplied(light, f32::from(alpha) / 65_535.0)
    }
}

#[cfg(feature = "png")]
fn premultiplied(light: [f32; 3], alpha: f32) -> Vec4 {
    (glam::Vec3::from_array(light) * alpha).extend(alpha)
}

#[cfg(test)]
mod tests {
    use super::*;

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
