//! Textures: made of texels, and told how to be filtered.

use std::fmt;
#[cfg(feature = "png")]
use std::path::Path;
use std::sync::Arc;

use fearless_simd::Level;
use glam::Vec4;

use crate::texture::chain;
use crate::texture::cutout::Cutout;
use crate::texture::error::TextureError;
#[cfg(feature = "png")]
use crate::texture::file::{self, Meaning};
use crate::texture::format::{Format, Samples};
use crate::texture::level::MipFilter;
#[cfg(feature = "png")]
use crate::texture::limits::MAX_FILE_TEXELS;
use crate::texture::minify::Filtering;
#[cfg(feature = "image")]
use crate::texture::picture;
use crate::texture::sample::{Filter, Surroundings};
use crate::texture::texels::{Texels, with_texels};
use crate::texture::wrap::Wrap;

/// A picture to sample: texels in linear light, premultiplied by alpha, row 0 at the top. Clones share the texels.
#[derive(Clone)]
pub struct Texture {
    pub(super) texels: Arc<Texels>,
    pub(super) how: Filtering,
    /// The SIMD instructions that blocks are sampled with.
    pub(super) simd_level: Level,
}

impl Texture {
    /// A texture of `width` x `height` texels, given row by row from the top, in linear light and
    /// premultiplied by alpha.
    ///
    /// # Errors
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`](crate::texture::MAX_SIDE), [`TextureError::Length`] if the
    /// texels are not `width * height`.
    pub fn new(width: u32, height: u32, texels: Vec<Vec4>) -> Result<Self, TextureError> {
        let floats = texels.iter().flat_map(Vec4::to_array).collect();
        Self::from_samples(width, height, 4, Samples::F32(floats))
    }

    /// A texture of `width` x `height` texels of 1 to 4 channels each, which are kept as they are given.
    ///
    /// ```
    /// use glam::{Vec4, vec2};
    /// use polyscan::texture::{Samples, Texture};
    ///
    /// // Two pixels of grey, as codes of sRGB: a byte each.
    /// let texture = Texture::from_samples(2, 1, 1, Samples::Srgb8(vec![0, 255]))?;
    /// assert_eq!(texture.sample(vec2(0.5, 0.5)), Vec4::new(0.5, 0.5, 0.5, 1.0));
    /// # Ok::<(), polyscan::texture::TextureError>(())
    /// ```
    ///
    /// # Errors
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`](crate::texture::MAX_SIDE), [`TextureError::Channels`] if there
    /// are none or more than 4, [`TextureError::Length`] if the samples are not
    /// `width * height * channels`.
    pub fn from_samples(
        width: u32,
        height: u32,
        channels: usize,
        samples: Samples,
    ) -> Result<Self, TextureError> {
        Texels::new(width, height, channels, samples).map(Self::of)
    }

    /// A texture whose texel (x, y), counted from the top left, is `texel(x, y)`: linear light,
    /// premultiplied by alpha.
    ///
    /// # Errors
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`](crate::texture::MAX_SIDE), [`TextureError::Memory`] if the
    /// machine has no room for the texels, of 16 bytes each.
    pub fn from_fn(
        width: u32,
        height: u32,
        mut texel: impl FnMut(u32, u32) -> Vec4,
    ) -> Result<Self, TextureError> {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Texels::collect(width, height, places.map(|(x, y)| texel(x, y))).map(Self::of)
    }

    /// The texture of a picture, with the usual filter and wrap.
    fn of(texels: Texels) -> Self {
        Self { texels: Arc::new(texels), how: Filtering::default(), simd_level: Level::new() }
    }

    /// Sets the filter. A new texture has [`Filter::Bilinear`].
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { how: Filtering { filter, ..self.how }, ..self }
    }

    /// Sets how the picture is wrapped, alike along u and v. A new texture has [`Wrap::Repeat`].
    #[must_use]
    pub fn with_wrap(self, wrap: Wrap) -> Self {
        self.with_wraps(wrap, wrap)
    }

    /// Sets how the picture is wrapped: by `u` along its rows, by `v` along its columns.
    #[must_use]
    pub fn with_wraps(self, u: Wrap, v: Wrap) -> Self {
        self.with_surroundings(|around| Surroundings { u, v, ..around })
    }

    /// Sets the colour outside of the picture along axes that have [`Wrap::Border`]: linear light,
    /// premultiplied by alpha. A new texture has clear black.
    #[must_use]
    pub fn with_border(self, border: Vec4) -> Self {
        self.with_surroundings(|around| Surroundings { border, ..around })
    }

    fn with_surroundings(self, change: impl FnOnce(Surroundings) -> Surroundings) -> Self {
        Self { how: Filtering { around: change(self.how.around), ..self.how }, ..self }
    }

    /// The texture with a mip chain: smaller versions of the picture, each of half the width and half the
    /// height of the one before, rounded down, down to a single texel. From then on
    /// [`sample_footprint`](Self::sample_footprint) filters by [`MipFilter::Linear`]. The chain takes a
    /// third of the picture's memory.
    ///
    /// Each texel is the mean of the area that it covers on the level before, in linear light and
    /// premultiplied by alpha, rounded to the texture's format; so the mean of the picture is kept,
    /// whatever its size.
    ///
    /// # Errors
    /// [`TextureError::Memory`] if the machine has no room for it.
    pub fn with_mipmaps(self) -> Result<Self, TextureError> {
        self.with_chain(None)
    }

    /// The texture with a mip chain for cut-outs, such as leaves and fences: shaders that take alpha below
    /// `threshold` for a hole see as much of it from afar as from near.
    ///
    /// The levels are those of [`with_mipmaps`](Self::with_mipmaps), with the alpha of each multiplied by a number
    /// of its own, up to 1, so that the part of the level that is no hole is that of the picture (Castano,
    /// "Computing Alpha Mipmaps", 2010). Parts are those of alpha as bilinear filters see it. Colours before
    /// alpha stay as they are, and so does all of a picture without holes.
    ///
    /// ```
    /// use polyscan::glam::Vec4;
    /// use polyscan::texture::Texture;
    ///
    /// // Posts of 2 texels, and 14 of air: the third level has a quarter of alpha, and a texel of air.
    /// let fence = Texture::from_fn(64, 64, |x, _| if x % 16 < 2 { Vec4::ONE } else { Vec4::ZERO })?;
    /// assert_eq!(fence.clone().with_mipmaps()?.level_texel(3, 0, 0).w, 0.25);
    /// // There are posts all the same.
    /// assert!(fence.with_cutout_mipmaps(0.5)?.level_texel(3, 0, 0).w > 0.5);
    /// # Ok::<(), polyscan::texture::TextureError>(())
    /// ```
    ///
    /// # Errors
    /// [`TextureError::Memory`] if the machine has no room for it.
    pub fn with_cutout_mipmaps(self, threshold: f32) -> Result<Self, TextureError> {
        self.with_chain(Some(Cutout { threshold, in_red: false }))
    }

    /// [`with_cutout_mipmaps`](Self::with_cutout_mipmaps) of a picture whose red channel is alpha.
    #[cfg(feature = "model")]
    pub(crate) fn with_red_cutout_mipmaps(self, threshold: f32) -> Result<Self, TextureError> {
        self.with_chain(Some(Cutout { threshold, in_red: true }))
    }

    fn with_chain(self, cutout: Option<Cutout>) -> Result<Self, TextureError> {
        let Self { texels, how, simd_level } = self;
        let texels = Arc::new(chain::with_chain(Arc::unwrap_or_clone(texels), cutout)?);
        let how = Filtering { mip_filter: MipFilter::Linear, ..how };
        Ok(Self { texels, how, simd_level })
    }

    /// Sets how the picture is filtered where a pixel sees more than a texel of it. Without
    /// [mipmaps](Self::with_mipmaps) there is nothing but level 0 to be filtered.
    #[must_use]
    pub fn with_mip_filter(self, mip_filter: MipFilter) -> Self {
        Self { how: Filtering { mip_filter, ..self.how }, ..self }
    }

    /// Sets what is added to the level of detail: above 0 for a blurred picture, below for a sharp one
    /// that aliases. A new texture has 0. What is not finite counts as 0.
    #[must_use]
    pub fn with_level_bias(self, bias: f32) -> Self {
        let bias = if bias.is_finite() { bias } else { 0.0 };
        Self { how: Filtering { bias, ..self.how }, ..self }
    }

    /// Sets between which two levels of detail all are brought, after the bias. A new texture allows any.
    #[must_use]
    pub fn with_level_range(self, least: f32, most: f32) -> Self {
        Self { how: Filtering { range: (least, most), ..self.how }, ..self }
    }

    /// Sets the SIMD instructions that blocks are sampled with; the colours are the same to the bit. A new
    /// texture uses the best that the machine has.
    #[must_use]
    pub fn with_simd_level(self, simd_level: Level) -> Self {
        Self { simd_level, ..self }
    }

    /// Number of texels in a row, from 1 to [`MAX_SIDE`](crate::texture::MAX_SIDE).
    #[must_use]
    pub fn width(&self) -> u32 {
        self.texels.base().width
    }

    /// Number of rows, from 1 to [`MAX_SIDE`](crate::texture::MAX_SIDE).
    #[must_use]
    pub fn height(&self) -> u32 {
        self.texels.base().height
    }

    /// How [`sample`](Self::sample) filters.
    #[must_use]
    pub fn filter(&self) -> Filter {
        self.how.filter
    }

    /// How [`sample_footprint`](Self::sample_footprint) filters where the picture is made smaller.
    #[must_use]
    pub fn mip_filter(&self) -> MipFilter {
        self.how.mip_filter
    }

    /// How many levels there are, the picture itself among them: 1 without mipmaps.
    #[must_use]
    pub fn level_count(&self) -> u32 {
        self.texels.last_level() + 1
    }

    /// Width and height of a level, in texels; of the last one beyond it.
    #[must_use]
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        let level = self.texels.level(level);
        (level.width, level.height)
    }

    /// The texel in column `x`, row `y` of a level, as [`texel`](Self::texel) of the picture itself.
    #[must_use]
    pub fn level_texel(&self, level: u32, x: u32, y: u32) -> Vec4 {
        let level = self.texels.level(level);
        let (x, y) = (x.min(level.width - 1), y.min(level.height - 1));
        with_texels!(&self.texels, level, texels => texels.get(x, y)).unwrap_or_default()
    }

    /// How coordinates outside 0 to 1 are understood, along u and along v.
    #[inline]
    #[must_use]
    pub fn wraps(&self) -> (Wrap, Wrap) {
        (self.how.around.u, self.how.around.v)
    }

    /// The colour outside of the picture along axes that have [`Wrap::Border`].
    #[must_use]
    pub fn border(&self) -> Vec4 {
        self.how.around.border
    }

    /// How samples are stored.
    #[must_use]
    pub fn format(&self) -> Format {
        self.texels.samples().format()
    }

    /// Samples a texel, from 1 to 4.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.texels.channels()
    }

    /// The bytes that the texels take in memory.
    #[must_use]
    pub fn byte_len(&self) -> usize {
        self.texels.samples().len() * self.format().bytes()
    }

    /// All texels, row by row from the top: linear light, premultiplied by alpha.
    pub fn texels(&self) -> impl Iterator<Item = Vec4> {
        let places = (0..self.height()).flat_map(|y| (0..self.width()).map(move |x| (x, y)));
        places.map(|(x, y)| self.texel(x, y))
    }

    /// The texel in column `x`, row `y`, both from 0: linear light, premultiplied by alpha. Beyond the
    /// last column or row it is the last one.
    #[must_use]
    pub fn texel(&self, x: u32, y: u32) -> Vec4 {
        self.level_texel(0, x, y)
    }
}

impl fmt::Debug for Texture {
    /// Everything but the texels.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Texture")
            .field("width", &self.width())
            .field("height", &self.height())
            .field("format", &self.format())
            .field("channels", &self.channels())
            .field("filter", &self.how.filter)
            .field("mip_filter", &self.how.mip_filter)
            .field("levels", &self.level_count())
            .field("wraps", &self.wraps())
            .finish_non_exhaustive()
    }
}

/// From files.
#[cfg(feature = "png")]
impl Texture {
    /// The texture of a picture file that is for the eye.
    ///
    /// The file is a PNG file. With the feature `image` it may also be a JPEG, BMP or PNM file, which
    /// are recognised by their content like PNG files, or a TGA file, which is recognised by its
    /// extension.
    ///
    /// Colours are sRGB, and are decoded before anything is averaged; alpha is linear, and the
    /// colours are multiplied by it. Grey pictures get three equal channels, pictures without alpha
    /// are opaque. Colour profiles are not applied. A grey pixel takes a byte in memory, one with alpha
    /// two, one in colour four, and twice as many at 16 bits.
    ///
    /// At most [`MAX_SIDE`](crate::texture::MAX_SIDE) texels a side, [`MAX_FILE_TEXELS`](crate::texture::MAX_FILE_TEXELS) in all and [`MAX_DECODE_BYTES`](crate::texture::MAX_DECODE_BYTES) for
    /// the decoder are allowed, so that a small file cannot ask for a machine's whole memory.
    ///
    /// # Errors
    /// [`TextureError::Read`], [`TextureError::Decode`], [`TextureError::FeatureNeeded`] and
    /// [`TextureError::TooLarge`] name the file and the cause; [`TextureError::Memory`] if there is
    /// less than the limits allow.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, TextureError> {
        Self::open_within(path.as_ref(), MAX_FILE_TEXELS)
    }

    /// The texture of a file that holds numbers, not colours: a normal map, roughness, height.
    ///
    /// The numbers are taken as they stand, scaled to 0 to 1; nothing is decoded, nothing multiplied
    /// by alpha. Formats and limits are those of [`Texture::open`].
    ///
    /// # Errors
    /// As [`Texture::open`].
    pub fn open_data(path: impl AsRef<Path>) -> Result<Self, TextureError> {
        Self::open_data_within(path.as_ref(), MAX_FILE_TEXELS)
    }

    /// [`Texture::open_data`] with another limit on the number of texels.
    pub(crate) fn open_data_within(path: &Path, limit: u64) -> Result<Self, TextureError> {
        file::read(path, limit, Meaning::Numbers).map(Self::of)
    }

    /// [`Texture::open`] with another limit on the number of texels.
    pub(crate) fn open_within(path: &Path, limit: u64) -> Result<Self, TextureError> {
        file::read(path, limit, Meaning::Colours).map(Self::of)
    }
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
        picture::colours(image).map(Self::of)
    }

    /// The texture of a picture that holds numbers, not colours: a normal map, roughness, height.
    ///
    /// The numbers are taken as they stand, integers scaled to 0 to 1; nothing is decoded, nothing
    /// multiplied by alpha.
    ///
    /// # Errors
    /// As [`Texture::from_image`].
    pub fn from_data(image: &image::DynamicImage) -> Result<Self, TextureError> {
        picture::numbers(image).map(Self::of)
    }
}
