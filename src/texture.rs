//! Pictures that shaders sample.
//!
//! What flows in is a picture (a file, an `image` picture, or a function of the pixel); what flows
//! out is a colour for any texture coordinate. A texture is sampled for magnification: its colour is
//! the nearest texel, or the bilinear mean of the four around the point. There are no mipmaps.
//!
//! - `texture::limits` says how large textures may be, `texture::error` what can go wrong;
//! - `texture::texels` holds the picture in memory;
//! - `texture::light` decodes pixels of 8 and 16 bits, for `texture::picture`s of the `image` crate
//!   and for picture `texture::file`s;
//! - `texture::wrap` finds the texels at a coordinate, `texture::sample` their colour.
//!
//! Texture coordinates have u to the right and v DOWN, as in wgpu, Direct3D and glTF: (0, 0) is the
//! top left corner of the picture, (1, 1) the bottom right one, whatever its size. The centre of
//! texel (i, j), counted from the top left, is at ((i + 0.5) / width, (j + 0.5) / height).
//!
//! Texels are kept as linear light, premultiplied by alpha. Only in linear light is the mean of two
//! colours the colour that the eye sees from afar, and only with premultiplied alpha does a clear
//! texel lend nothing to its neighbours.
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

use glam::{Vec2, Vec4};

mod limits;
mod error;
mod texels;
#[cfg(feature = "png")]
mod light;
#[cfg(feature = "image")]
mod picture;
#[cfg(feature = "png")]
mod file;
mod wrap;
mod sample;

pub use self::error::TextureError;
pub use self::limits::MAX_SIDE;
#[cfg(feature = "png")]
pub use self::limits::{MAX_DECODE_BYTES, MAX_FILE_TEXELS};
pub use self::sample::Filter;
pub use self::wrap::Wrap;

#[cfg(feature = "png")]
use self::file::Meaning;
use self::texels::Texels;

/// A picture to sample: texels in linear light, premultiplied by alpha, row 0 at the top.
#[derive(Clone)]
pub struct Texture {
    texels: Texels,
    filter: Filter,
    wrap_u: Wrap,
    wrap_v: Wrap,
}

impl Texture {
    /// A texture of `width` x `height` texels, given row by row from the top, in linear light and
    /// premultiplied by alpha.
    ///
    /// # Errors
    /// [`TextureError::Size`] if a side is 0 or above [`MAX_SIDE`], [`TextureError::Length`] if the
    /// texels are not `width * height`.
    pub fn new(width: u32, height: u32, texels: Vec<Vec4>) -> Result<Self, TextureError> {
        Texels::new(width, height, texels).map(Self::of)
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
        let (filter, wrap) = (Filter::default(), Wrap::default());
        Self { texels, filter, wrap_u: wrap, wrap_v: wrap }
    }

    /// Sets the filter. A new texture has [`Filter::Bilinear`].
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// Sets how the picture is wrapped, alike along u and v. A new texture has [`Wrap::Repeat`].
    #[must_use]
    pub fn with_wrap(self, wrap: Wrap) -> Self {
        self.with_wraps(wrap, wrap)
    }

    /// Sets how the picture is wrapped: by `u` along its rows, by `v` along its columns.
    #[must_use]
    pub fn with_wraps(self, u: Wrap, v: Wrap) -> Self {
        Self { wrap_u: u, wrap_v: v, ..self }
    }

    /// Number of texels in a row, from 1 to [`MAX_SIDE`].
    #[must_use]
    pub fn width(&self) -> u32 {
        self.texels.width()
    }

    /// Number of rows, from 1 to [`MAX_SIDE`].
    #[must_use]
    pub fn height(&self) -> u32 {
        self.texels.height()
    }

    /// How [`sample`](Self::sample) filters.
    #[must_use]
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// How coordinates outside 0 to 1 are understood, along u and along v.
    #[inline]
    #[must_use]
    pub fn wraps(&self) -> (Wrap, Wrap) {
        (self.wrap_u, self.wrap_v)
    }

    /// All texels, row by row from the top: linear light, premultiplied by alpha.
    #[must_use]
    pub fn texels(&self) -> &[Vec4] {
        self.texels.as_slice()
    }

    /// The texel in column `x`, row `y`, both from 0. Beyond the last column or row it is the last one.
    #[inline]
    #[must_use]
    pub fn texel(&self, x: u32, y: u32) -> Vec4 {
        self.texels.get(x, y)
    }

    /// The colour at `uv` by the texture's own filter: linear light, premultiplied by alpha.
    ///
    /// Any coordinate is safe, and is wrapped without a rounding error of its own. NaN counts as 0, and
    /// so does an infinity, unless the axis has [`Wrap::Clamp`], where it means that edge.
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
        sample::nearest(&self.texels, self.wraps(), uv)
    }

    /// The mean of the four texels around `uv`, weighted by nearness along each axis.
    #[inline]
    #[must_use]
    pub fn bilinear(&self, uv: Vec2) -> Vec4 {
        sample::bilinear(&self.texels, self.wraps(), uv)
    }
}

impl fmt::Debug for Texture {
    /// Everything but the texels.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Texture")
            .field("width", &self.width())
            .field("height", &self.height())
            .field("filter", &self.filter)
            .field("wrap_u", &self.wrap_u)
            .field("wrap_v", &self.wrap_v)
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
    /// are opaque. Colour profiles are not applied.
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
