//! Pictures that shaders sample.
//!
//! What flows in is a picture (a file, an `image` picture, or a function of the pixel); what flows
//! out is a colour for any texture coordinate, or for the [`Footprint`] of a pixel.
//!
//! - `texture::limits` says how large textures may be, `texture::error` what can go wrong;
//! - `texture::format` says how samples are stored, `texture::light` decodes them, and
//!   `texture::texels` holds them in memory;
//! - `texture::picture`s of the `image` crate and picture `texture::file`s become texels;
//! - `texture::wrap` finds the texels at a coordinate, `texture::sample` their colour, by
//!   `texture::cubic`s as well;
//! - `texture::chain` makes the levels of a mip chain, `texture::level` tells which of them a pixel needs,
//!   and `texture::minify` filters what it sees, by an `texture::ewa` if it is to; `texture::block` does
//!   it for 16 pixels at once.
//!
//! Texture coordinates have u to the right and v DOWN, as in wgpu, Direct3D and glTF: (0, 0) is the
//! top left corner of the picture, (1, 1) the bottom right one, whatever its size. The centre of
//! texel (i, j), counted from the top left, is at ((i + 0.5) / width, (j + 0.5) / height).
//!
//! Texels are filtered as linear light, premultiplied by alpha. Only in linear light is the mean of two
//! colours the colour that the eye sees from afar, and only with premultiplied alpha does a clear
//! texel lend nothing to its neighbours. In memory they are what they were in the picture: a PNG file's
//! sRGB pixel takes four bytes, and is decoded, exactly and by a table, when it is sampled. [`Format`]
//! lists what there is.
//!
//! # Which filter
//!
//! ![A checkered plane by all filters](https://raw.githubusercontent.com/polyscan/polyscan/main/examples/assets/pictures/textures.png)
//!
//! Where a pixel sees more than a texel, a texture aliases unless it has [mipmaps](Texture::with_mipmaps)
//! and is told what the pixel sees. This is the peak signal-to-noise ratio of each filter's picture in
//! decibels against the mean of 512 bilinear samples a pixel, for a plane with a picture of 500 x 375 texels,
//! tilted, and rolled about the line of sight; `cargo run --release --example textures -- --table` prints it:
//!
//! | tilt, roll | bilinear | nearest level | trilinear | 2 probes | 4 | 8 | 16 | EWA 16 | EWA 32 |
//! |---|---|---|---|---|---|---|---|---|---|
//! | 30°, 0° | 46.5 | 45.5 | 47.6 | 52.4 | 52.4 | 52.4 | 52.4 | 47.7 | 47.7 |
//! | 60°, 0° | 34.5 | 33.3 | 33.4 | 40.4 | 47.9 | 52.3 | 52.8 | 44.2 | 44.2 |
//! | 80°, 0° | 29.3 | 31.3 | 31.7 | 36.0 | 40.3 | 43.2 | 44.7 | 41.7 | 42.1 |
//! | 85°, 0° | 30.3 | 33.3 | 33.3 | 38.0 | 42.7 | 47.4 | 50.6 | 44.2 | 44.8 |
//! | 60°, 30° | 31.5 | 33.3 | 33.8 | 37.6 | 42.7 | 46.5 | 47.7 | 43.3 | 43.5 |
//! | 80°, 30° | 29.2 | 32.1 | 32.3 | 35.8 | 40.3 | 43.2 | 44.5 | 42.1 | 42.5 |
//! | 85°, 30° | 30.1 | 33.4 | 33.5 | 36.8 | 40.9 | 43.4 | 44.4 | 42.6 | 43.0 |
//!
//! With a checkerboard of 500 x 380 texels in its place:
//!
//! | tilt, roll | bilinear | nearest level | trilinear | 2 probes | 4 | 8 | 16 | EWA 16 | EWA 32 |
//! |---|---|---|---|---|---|---|---|---|---|
//! | 60°, 0° | 19.6 | 21.8 | 22.1 | 27.9 | 34.3 | 38.3 | 38.6 | 31.6 | 31.6 |
//! | 80°, 0° | 19.4 | 24.0 | 24.2 | 29.4 | 35.5 | 41.3 | 44.1 | 33.9 | 34.0 |
//! | 85°, 0° | 21.1 | 25.1 | 25.3 | 29.8 | 35.9 | 42.0 | 46.5 | 35.2 | 35.3 |
//! | 60°, 30° | 19.9 | 24.3 | 24.7 | 29.7 | 35.9 | 38.2 | 38.3 | 32.2 | 32.2 |
//! | 80°, 30° | 19.2 | 24.7 | 24.8 | 28.9 | 34.8 | 39.3 | 40.5 | 34.9 | 35.1 |
//! | 85°, 30° | 20.5 | 25.7 | 26.0 | 30.0 | 35.6 | 40.1 | 41.8 | 36.6 | 36.9 |
//!
//! So [`MipFilter::Anisotropic`] is the one to take, with 16 probes for planes to the horizon: it takes no
//! more probes than a footprint is long. In blocks it costs four times what trilinear costs on a plane tilted
//! by 80°, and little more on one that is seen face on. [`MipFilter::Ewa`] is some 40 times as slow as
//! trilinear there.
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

use std::fmt;
#[cfg(feature = "png")]
use std::path::Path;

use fearless_simd::Level;
use glam::{Vec2, Vec4};

use crate::fragment::{Footprint, FootprintBlock, LANES, Lanes};
use crate::simd::for_level;

mod limits;
mod error;
mod format;
mod light;
mod texels;
#[cfg(feature = "image")]
mod picture;
#[cfg(feature = "png")]
mod file;
mod wrap;
mod cubic;
mod sample;
mod chain;
mod level;
mod ewa;
mod minify;
mod block;

pub use self::cubic::Cubic;
pub use self::error::TextureError;
pub use self::format::{Format, Samples};
pub use self::level::MipFilter;
pub use self::limits::MAX_SIDE;
#[cfg(feature = "png")]
pub use self::limits::{MAX_DECODE_BYTES, MAX_FILE_TEXELS};
pub use self::sample::Filter;
pub use self::wrap::Wrap;

#[cfg(feature = "png")]
use self::file::Meaning;
use self::minify::{Chain, Filtering};
use self::sample::Surroundings;
use self::texels::{Texels, with_texels};

/// A picture to sample: texels in linear light, premultiplied by alpha, row 0 at the top.
#[derive(Clone)]
pub struct Texture {
    texels: Texels,
    how: Filtering,
    /// The SIMD instructions that blocks are sampled with.
    simd_level: Level,
}

impl Texture {
    /// A texture of `width` x `height` texels, given row by row from the top, in linear light and
    /// premultiplied by alpha.
    ///
    /// # Errors
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`], [`TextureError::Length`] if the
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
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`], [`TextureError::Channels`] if there
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
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`], [`TextureError::Memory`] if the
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
        Self { texels, how: Filtering::default(), simd_level: Level::new() }
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
        let Self { texels, how, simd_level } = self;
        let texels = chain::with_chain(texels)?;
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

    /// Number of texels in a row, from 1 to [`MAX_SIDE`].
    #[must_use]
    pub fn width(&self) -> u32 {
        self.texels.base().width
    }

    /// Number of rows, from 1 to [`MAX_SIDE`].
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

    /// The colour at `uv` by the texture's own filter: linear light, premultiplied by alpha.
    ///
    /// Any coordinate is safe, and is wrapped without a rounding error of its own. NaN counts as 0, and
    /// so does an infinity, unless the axis has [`Wrap::Clamp`], where it means that edge, or
    /// [`Wrap::Border`], where it is outside.
    #[must_use]
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), texels => {
            sample::by_filter(self.how.filter, &texels, &self.how.around, uv)
        })
    }

    /// The colour of what a pixel sees: linear light, premultiplied by alpha. The picture is filtered by
    /// [`mip_filter`](Self::mip_filter) where it is made smaller, and by [`filter`](Self::filter) where it
    /// is magnified.
    ///
    /// Where `W` and `H` are the picture's width and height, the level of detail is
    /// log2 max(|(W du/dx, H dv/dx)|, |(W du/dy, H dv/dy)|); at 0 or less the picture is magnified.
    ///
    /// ```
    /// use glam::{Vec4, vec4};
    /// use polyscan::texture::Texture;
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// // A checkerboard of 64 x 64 fields on 4 x 4 pixels is grey, and does not shimmer.
    /// let board = |x: u32, y: u32| if (x + y) % 2 == 0 { Vec4::ONE } else { Vec4::W };
    /// let texture = Texture::from_fn(64, 64, board)?.with_mipmaps()?;
    /// let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]));
    /// let mut frame = Framebuffer::new(4, 4, Vec4::ZERO)?;
    /// ZBufferRenderer::new(frame.viewport()).draw(&mut frame, &quad, |fragment| {
    ///     texture.sample_footprint(&fragment.footprint(0, 1))
    /// });
    /// assert_eq!(frame.color(), [vec4(0.5, 0.5, 0.5, 1.0); 16]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn sample_footprint(&self, footprint: &Footprint) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), base => {
            Chain::new(&self.texels, base, &self.how).sample(footprint)
        })
    }

    /// The colours at the points (u, v) of a block's lanes, as [`sample`](Self::sample), of lanes that
    /// have a bit in `mask`; 0 in others. Faster than one by one, and the same to the bit.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::color::Color;
    /// use polyscan::texture::Texture;
    /// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
    ///
    /// let texture = Texture::from_fn(2, 1, |x, _| vec4(x as f32, 0.5, 0.0, 1.0))?;
    /// let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y]));
    /// let mut frame = Framebuffer::new(40, 30, [0u8; 4])?;
    /// let mut renderer = ZBufferRenderer::new(frame.viewport());
    /// renderer.draw_blocks(&mut frame, &quad, |block, colors| {
    ///     let texels = texture.sample_block(&block.params, block.visible);
    ///     for (color, texel) in colors.iter_mut().zip(texels) {
    ///         *color = texel.to_srgb8();
    ///     }
    /// });
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn sample_block(&self, uv: &[Lanes; 2], mask: u32) -> [Vec4; LANES] {
        let mut colors = [Vec4::ZERO; LANES];
        for_level!(self.simd_level, _simd => {
            with_texels!(&self.texels, self.texels.base(), base => {
                Chain::new(&self.texels, base, &self.how).magnified_block(uv, mask, &mut colors);
            });
        });
        colors
    }

    /// The colours of the footprints of a block's lanes, as
    /// [`sample_footprint`](Self::sample_footprint), of lanes that have a bit in `mask`; 0 in others.
    /// Faster than one by one, and the same to the bit.
    #[must_use]
    pub fn sample_footprint_block(&self, of: &FootprintBlock, mask: u32) -> [Vec4; LANES] {
        let mut colors = [Vec4::ZERO; LANES];
        for_level!(self.simd_level, _simd => {
            with_texels!(&self.texels, self.texels.base(), base => {
                Chain::new(&self.texels, base, &self.how).sample_block(of, mask, &mut colors);
            });
        });
        colors
    }

    /// The texel that `uv` lies in. On the line between two texels it is the right or lower one.
    #[must_use]
    pub fn nearest(&self, uv: Vec2) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), texels => {
            sample::nearest(&texels, &self.how.around, uv)
        })
    }

    /// The mean of the four texels around `uv`, weighted by nearness along each axis.
    #[must_use]
    pub fn bilinear(&self, uv: Vec2) -> Vec4 {
        with_texels!(&self.texels, self.texels.base(), texels => {
            sample::bilinear(&texels, &self.how.around, uv)
        })
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
    /// At most [`MAX_SIDE`] texels a side, [`MAX_FILE_TEXELS`] in all and [`MAX_DECODE_BYTES`] for
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
        file::read(path.as_ref(), MAX_FILE_TEXELS, Meaning::Numbers).map(Self::of)
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
