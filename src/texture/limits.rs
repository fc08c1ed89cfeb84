//! How large textures may be.

/// The longest side of a texture, in texels: the side of the largest viewport.
///
/// Sampling relies on this bound too: the index of each texel, and half a texel beside it, is exact
/// in `f32`.
pub const MAX_SIDE: u32 = 65_536;

/// The most texels in a texture that is read from a file: 16384 x 16384. In memory they take 4 GiB.
#[cfg(feature = "png")]
pub const MAX_FILE_TEXELS: u64 = 1 << 28;

/// The most bytes that decoding a file may allocate: 1 GiB, which holds [`MAX_FILE_TEXELS`] of four
/// bytes each.
#[cfg(feature = "png")]
pub const MAX_DECODE_BYTES: u64 = 1 << 30;
