//! What can go wrong when a texture is made.

use std::path::PathBuf;

use crate::texture::limits::MAX_SIDE;

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
    /// The number of samples is not the number that the size calls for.
    #[error(
        "{given} samples were given for a texture of {width} x {height} texels of {channels}: give {} \
         of them, row by row",
        u64::from(*width) * u64::from(*height) * *channels as u64
    )]
    Length {
        /// Width asked for, in texels.
        width: u32,
        /// Height asked for, in texels.
        height: u32,
        /// Samples a texel.
        channels: usize,
        /// How many samples came.
        given: usize,
    },
    /// The number of channels is not from 1 to 4.
    #[error("a texel cannot have {channels} channels: give it 1 (grey) to 4 (with alpha)")]
    Channels {
        /// Channels asked for.
        channels: usize,
    },
    /// The faces of a cube are not alike.
    #[error(
        "face {number} of a cube, counted from 0, has {width} x {height} texels: all six must be square, have \
         {side} texels a side as the first one, and mipmaps if that has"
    )]
    Cube {
        /// Which face, from 0 to 5.
        number: usize,
        /// Its width in texels.
        width: u32,
        /// Its height in texels.
        height: u32,
        /// The width of the first.
        side: u32,
    },
    /// The machine has not enough memory for the texels.
    #[error(
        "no memory for a texture of {width} x {height} texels of {bytes_per_texel} bytes: use a smaller \
         one"
    )]
    Memory {
        /// Width asked for, in texels.
        width: u32,
        /// Height asked for, in texels.
        height: u32,
        /// What a texel takes.
        bytes_per_texel: usize,
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

/// The formats of picture files that can be read.
const FORMATS: &str = if cfg!(feature = "image") { "PNG, JPEG, TGA, BMP or PNM" } else { "PNG" };
