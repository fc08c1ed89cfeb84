//! How the samples of a texture are stored, and what they stand for.

use std::collections::TryReserveError;

/// How each channel of a texel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// 8 bits: sRGB codes, alpha linear. For pictures.
    Srgb8,
    /// 16 bits: sRGB codes in finer steps, alpha linear.
    Srgb16,
    /// 8 bits: numbers from 0 to 1 as they stand. For normals, roughness, masks.
    Unorm8,
    /// 16 bits: numbers from 0 to 1 as they stand. For heights.
    Unorm16,
    /// 16 bits: IEEE 754 binary16, numbers as they stand.
    F16,
    /// 32 bits: `f32`, numbers as they stand.
    F32,
}

/// The samples of a texture: texel by texel, row by row from the top, 1 to 4 channels a texel.
///
/// One channel is grey, two are grey and alpha, three are red, green and blue, four have alpha as well.
/// Grey stands for three equal channels, and what has no alpha is opaque.
///
/// In the sRGB formats colours are straight, as in picture files: they are decoded, and multiplied by
/// alpha, whenever they are sampled. All others are taken as they stand, so colours among them are to be
/// linear light that is multiplied by alpha already.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Samples {
    /// As [`Format::Srgb8`].
    Srgb8(Vec<u8>),
    /// As [`Format::Srgb16`].
    Srgb16(Vec<u16>),
    /// As [`Format::Unorm8`].
    Unorm8(Vec<u8>),
    /// As [`Format::Unorm16`].
    Unorm16(Vec<u16>),
    /// As [`Format::F16`], by the bits of each number.
    F16(Vec<u16>),
    /// As [`Format::F32`].
    F32(Vec<f32>),
}

impl Samples {
    /// What the samples are.
    #[must_use]
    pub fn format(&self) -> Format {
        match self {
            Self::Srgb8(_) => Format::Srgb8,
            Self::Srgb16(_) => Format::Srgb16,
            Self::Unorm8(_) => Format::Unorm8,
            Self::Unorm16(_) => Format::Unorm16,
            Self::F16(_) => Format::F16,
            Self::F32(_) => Format::F32,
        }
    }

    /// How many samples there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Srgb8(bytes) | Self::Unorm8(bytes) => bytes.len(),
            Self::Srgb16(words) | Self::Unorm16(words) | Self::F16(words) => words.len(),
            Self::F32(floats) => floats.len(),
        }
    }

    /// Leaves so many of the samples.
    pub(super) fn truncate(&mut self, len: usize) {
        match self {
            Self::Srgb8(bytes) | Self::Unorm8(bytes) => bytes.truncate(len),
            Self::Srgb16(words) | Self::Unorm16(words) | Self::F16(words) => words.truncate(len),
            Self::F32(floats) => floats.truncate(len),
        }
    }

    /// Makes room for so many samples more.
    pub(super) fn try_reserve(&mut self, more: usize) -> Result<(), TryReserveError> {
        match self {
            Self::Srgb8(bytes) | Self::Unorm8(bytes) => bytes.try_reserve_exact(more),
            Self::Srgb16(words) | Self::Unorm16(words) | Self::F16(words) => {
                words.try_reserve_exact(more)
            }
            Self::F32(floats) => floats.try_reserve_exact(more),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Format {
    /// The bytes of a sample.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::Srgb8 | Self::Unorm8 => 1,
            Self::Srgb16 | Self::Unorm16 | Self::F16 => 2,
            Self::F32 => 4,
        }
    }
}
