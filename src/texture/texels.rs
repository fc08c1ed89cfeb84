//! The texels of a picture, in memory: its samples, level by level, and how they are decoded.

use glam::Vec4;

use crate::color::decode;
use crate::texture::error::TextureError;
use crate::texture::format::Samples;
use crate::texture::light::{
    light_of_8, light_of_16, of_f16, opaque_of_8, part_of_255, part_of_65535,
};
use crate::texture::limits::MAX_SIDE;

/// A rectangle of texels, and smaller ones made of it.
#[derive(Clone)]
pub(super) struct Texels {
    /// Those of all levels, one level after the other.
    samples: Samples,
    /// From 1 to 4.
    channels: usize,
    /// Whether the texels are sRGB in four bytes, the last of which is 255 in all.
    is_opaque_srgba8: bool,
    /// The picture itself.
    base: Level,
    /// Its smaller versions, if it has them.
    smaller: Vec<Level>,
    /// The numbers of the levels' first texels, those of the last one beyond it.
    starts: [u32; 32],
}

/// The size of a picture in memory, both sides from 1 to [`MAX_SIDE`], and where its texels begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) start: usize,
}

/// Texels that can be decoded by their number.
pub(super) trait Fetch: Copy + Send + Sync {
    /// The texel with a number: linear light, premultiplied by alpha; `None` beyond the last.
    fn fetch(self, number: usize) -> Option<Vec4>;

    /// Whether all texels are known to be opaque.
    const OPAQUE: bool = false;

    /// [`fetch`](Self::fetch), but for the alpha of texels that are known to be opaque.
    #[inline(always)]
    fn fetch_light(self, number: usize) -> Option<Vec4> {
        self.fetch(number)
    }
}

/// A level with its texels.
#[derive(Clone, Copy)]
pub(super) struct LevelTexels<F> {
    pub(super) size: Level,
    texels: F,
}

impl<F: Fetch> LevelTexels<F> {
    /// Another level of the same texture.
    #[inline(always)]
    pub(super) fn at(&self, size: Level) -> Self {
        Self { size, ..*self }
    }

    /// The texel in column `x`, row `y`; `None` beyond the last column or row.
    #[inline(always)]
    pub(super) fn get(&self, x: u32, y: u32) -> Option<Vec4> {
        let Level { width, height, start } = self.size;
        if x >= width || y >= height {
            return None;
        }
        self.texels.fetch(start + y as usize * width as usize + x as usize)
    }

    /// The texel with a number among those of all levels.
    #[inline(always)]
    pub(super) fn numbered(&self, number: usize) -> Option<Vec4> {
        self.texels.fetch(number)
    }

    /// The same, but for the alpha of texels that are known to be opaque.
    #[inline(always)]
    pub(super) fn light_numbered(&self, number: usize) -> Option<Vec4> {
        self.texels.fetch_light(number)
    }
}

/// Texels in four bytes of sRGB and alpha; whether all are opaque.
#[derive(Clone, Copy)]
pub(super) struct Srgba8<'a, const OPAQUE: bool>(&'a [[u8; 4]]);

impl<const OPAQUE: bool> Fetch for Srgba8<'_, OPAQUE> {
    #[inline(always)]
    fn fetch(self, number: usize) -> Option<Vec4> {
        let [r, g, b, alpha] = *self.0.get(number)?;
        Some(if OPAQUE { opaque_of_8([r, g, b]) } else { light_of_8([r, g, b, alpha]) })
    }

    const OPAQUE: bool = OPAQUE;

    #[inline(always)]
    fn fetch_light(self, number: usize) -> Option<Vec4> {
        let [r, g, b, alpha] = *self.0.get(number)?;
        // Three numbers and a zero take fewer instructions than three and a one.
        let light = Vec4::new(decode(r), decode(g), decode(b), 0.0);
        Some(if OPAQUE { light } else { light_of_8([r, g, b, alpha]) })
    }
}

impl LevelTexels<Srgba8<'_, true>> {
    /// A texel as it is stored.
    #[inline(always)]
    pub(super) fn code_numbered(&self, number: usize) -> Option<[u8; 4]> {
        self.texels.0.get(number).copied()
    }
}

/// Texels in four floats.
#[derive(Clone, Copy)]
pub(super) struct Rgba32<'a>(&'a [[f32; 4]]);

impl Fetch for Rgba32<'_> {
    #[inline(always)]
    fn fetch(self, number: usize) -> Option<Vec4> {
        self.0.get(number).map(|texel| Vec4::from_array(*texel))
    }
}

/// Texels of any format.
#[derive(Clone, Copy)]
pub(super) struct AnyFormat<'a> {
    samples: &'a Samples,
    channels: usize,
}

impl Fetch for AnyFormat<'_> {
    fn fetch(self, number: usize) -> Option<Vec4> {
        let Self { samples, channels } = self;
        match samples {
            Samples::Srgb8(s) => texel(s, channels, number, u8::MAX).map(light_of_8),
            Samples::Srgb16(s) => texel(s, channels, number, u16::MAX).map(light_of_16),
            Samples::Unorm8(s) => numbers(s, channels, number, u8::MAX, part_of_255),
            Samples::Unorm16(s) => numbers(s, channels, number, u16::MAX, part_of_65535),
            Samples::F16(s) => numbers(s, channels, number, F16_ONE, of_f16),
            Samples::F32(s) => numbers(s, channels, number, 1.0, |x| x),
        }
    }
}

/// The bits of 1 in binary16.
const F16_ONE: u16 = 0x3c00;

/// A texel of numbers as they stand.
#[inline(always)]
fn numbers<T: Copy>(
    samples: &[T],
    channels: usize,
    number: usize,
    one: T,
    decode: impl Fn(T) -> f32,
) -> Option<Vec4> {
    texel(samples, channels, number, one).map(|texel| Vec4::from(texel.map(decode)))
}

/// Red, green, blue and alpha of a texel that has 1 (grey), 2 (grey, alpha), 3 or 4 channels.
#[inline(always)]
fn texel<T: Copy>(samples: &[T], channels: usize, number: usize, opaque: T) -> Option<[T; 4]> {
    let samples = samples.get(number.checked_mul(channels)?..)?;
    Some(match *samples.get(..channels)? {
        [x] => [x, x, x, opaque],
        [x, alpha] => [x, x, x, alpha],
        [r, g, b] => [r, g, b, opaque],
        [r, g, b, alpha] => [r, g, b, alpha],
        _ => return None,
    })
}

/// Calls a generic function with the texels of a level, compiled for the most usual formats and once
/// for all others.
macro_rules! with_texels {
    ($texels:expr, $level:expr, $view:ident => $code:expr) => {{
        let (texels, level): (&$crate::texture::texels::Texels, $crate::texture::texels::Level) =
            ($texels, $level);
        if let Some($view) = texels.opaque_srgba8(level) {
            $code
        } else if let Some($view) = texels.srgba8(level) {
            $code
        } else if let Some($view) = texels.rgba32(level) {
            $code
        } else {
            let $view = texels.any(level);
            $code
        }
    }};
}

pub(super) use with_texels;

impl Texels {
    /// Takes `width * height` texels of `channels` samples each, row by row from the top.
    pub(super) fn new(
        width: u32,
        height: u32,
        channels: usize,
        samples: Samples,
    ) -> Result<Self, TextureError> {
        check_size(width, height)?;
        if !(1..=4).contains(&channels) {
            return Err(TextureError::Channels { channels });
        }
        if samples.len() as u64 != u64::from(width) * u64::from(height) * channels as u64 {
            let given = samples.len();
            return Err(TextureError::Length { width, height, channels, given });
        }
        let base = Level { width, height, start: 0 };
        let is_opaque_srgba8 = match &samples {
            Samples::Srgb8(bytes) if channels == 4 => {
                // A fold without a way out, which becomes SIMD.
                bytes.as_chunks().0.iter().fold(u8::MAX, |all, &[_, _, _, alpha]| all & alpha)
                    == u8::MAX
            }
            _ => false,
        };
        let (smaller, starts) = (Vec::new(), [0; 32]);
        Ok(Self { samples, channels, is_opaque_srgba8, base, smaller, starts })
    }

    /// Collects texels in linear light that come row by row from the top.
    pub(super) fn collect(
        width: u32,
        height: u32,
        row_by_row: impl Iterator<Item = Vec4>,
    ) -> Result<Self, TextureError> {
        let mut samples = room(width, height, 4)?;
        row_by_row.for_each(|texel| samples.extend_from_slice(&texel.to_array()));
        Self::new(width, height, 4, Samples::F32(samples))
    }

    /// The picture itself.
    #[inline(always)]
    pub(super) fn base(&self) -> Level {
        self.base
    }

    /// The number of the last level; the picture itself is level 0.
    #[inline(always)]
    pub(super) fn last_level(&self) -> u32 {
        self.smaller.len() as u32
    }

    /// A level by its number; the last one beyond it.
    #[inline(always)]
    pub(super) fn level(&self, number: u32) -> Level {
        match (number.min(self.last_level()) as usize).checked_sub(1) {
            Some(i) => self.smaller.get(i).copied().unwrap_or(self.base),
            None => self.base,
        }
    }

    /// Whether the numbers of all texels, of all levels, are below `u32::MAX`.
    #[inline(always)]
    pub(super) fn has_short_numbers(&self) -> bool {
        self.samples.len() < u32::MAX as usize
    }

    /// The numbers of the levels' first texels, if they are [short](Self::has_short_numbers).
    #[inline(always)]
    pub(super) fn starts(&self) -> &[u32; 32] {
        &self.starts
    }

    /// Forgets all levels but the picture itself.
    pub(super) fn drop_smaller(&mut self) {
        self.smaller.clear();
        self.starts = [0; 32];
        let count = self.base.width as usize * self.base.height as usize * self.channels;
        self.samples.truncate(count);
    }

    /// Makes room for all levels of a chain at once.
    pub(super) fn reserve_chain(&mut self) -> Result<(), TextureError> {
        let (mut size, mut count) = ((self.base.width, self.base.height), 0);
        while size != (1, 1) {
            size = ((size.0 / 2).max(1), (size.1 / 2).max(1));
            count += size.0 as usize * size.1 as usize * self.channels;
        }
        let Level { width, height, .. } = self.base;
        let bytes_per_texel = self.channels * self.samples.format().bytes();
        let out_of_memory = |_| TextureError::Memory { width, height, bytes_per_texel };
        self.samples.try_reserve(count).map_err(out_of_memory)
    }

    /// Adds a level, whose samples `push` adds to those that there are.
    pub(super) fn push_level(
        &mut self,
        (width, height): (u32, u32),
        push: impl FnOnce(&mut Samples),
    ) {
        let start = self.samples.len() / self.channels;
        push(&mut self.samples);
        self.smaller.push(Level { width, height, start });
        self.starts[self.smaller.len().min(31)..].fill(start as u32);
    }

    /// The samples of all levels.
    pub(super) fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Samples a texel, from 1 to 4.
    pub(super) fn channels(&self) -> usize {
        self.channels
    }

    /// The texels of a level, if they are bytes of red, green and blue in sRGB beside an alpha of 255.
    #[inline(always)]
    pub(super) fn opaque_srgba8(&self, size: Level) -> Option<LevelTexels<Srgba8<'_, true>>> {
        match &self.samples {
            Samples::Srgb8(bytes) if self.is_opaque_srgba8 => {
                Some(LevelTexels { size, texels: Srgba8(bytes.as_chunks().0) })
            }
            _ => None,
        }
    }

    /// The texels of a level, if they are bytes of red, green, blue and alpha in sRGB.
    #[inline(always)]
    pub(super) fn srgba8(&self, size: Level) -> Option<LevelTexels<Srgba8<'_, false>>> {
        match &self.samples {
            Samples::Srgb8(bytes) if self.channels == 4 => {
                Some(LevelTexels { size, texels: Srgba8(bytes.as_chunks().0) })
            }
            _ => None,
        }
    }

    /// The texels of a level, if they are four floats each.
    #[inline(always)]
    pub(super) fn rgba32(&self, size: Level) -> Option<LevelTexels<Rgba32<'_>>> {
        match &self.samples {
            Samples::F32(floats) if self.channels == 4 => {
                Some(LevelTexels { size, texels: Rgba32(floats.as_chunks().0) })
            }
            _ => None,
        }
    }

    /// The texels of a level, whatever they are.
    #[inline(always)]
    pub(super) fn any(&self, size: Level) -> LevelTexels<AnyFormat<'_>> {
        let texels = AnyFormat { samples: &self.samples, channels: self.channels };
        LevelTexels { size, texels }
    }
}

pub(super) fn check_size(width: u32, height: u32) -> Result<(), TextureError> {
    let sides = 1..=MAX_SIDE;
    if sides.contains(&width) && sides.contains(&height) {
        Ok(())
    } else {
        Err(TextureError::Size { width, height })
    }
}

/// An empty list with room for the samples of all texels.
pub(super) fn room<T>(width: u32, height: u32, channels: usize) -> Result<Vec<T>, TextureError> {
    check_size(width, height)?;
    let bytes_per_texel = channels * size_of::<T>();
    let mut samples = Vec::new();
    usize::try_from(u64::from(width) * u64::from(height) * channels as u64)
        .ok()
        .and_then(|count| samples.try_reserve_exact(count).ok())
        .map(|()| samples)
        .ok_or(TextureError::Memory { width, height, bytes_per_texel })
}

/// A copy of samples, of which each three get a fourth, so that a texel is loaded at once.
#[cfg(feature = "png")]
pub(super) fn copied<T: Copy>(
    (width, height): (u32, u32),
    samples: &[T],
    channels: usize,
    opaque: T,
) -> Result<Vec<T>, TextureError> {
    let mut copy = room(width, height, if channels == 3 { 4 } else { channels })?;
    if channels == 3 {
        copy.extend(samples.as_chunks().0.iter().flat_map(|&[r, g, b]| [r, g, b, opaque]));
    } else {
        copy.extend_from_slice(samples);
    }
    Ok(copy)
}
