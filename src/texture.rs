//! Pictures that shaders sample.
//!
//! What flows in is a picture (a file, an `image` picture, or a function of the pixel); what flows
//! out is a colour for any texture coordinate, or for the [`Footprint`](crate::Footprint) of a pixel.
//!
//! - [`Texture`]s are made by `texture::build`, and asked for colours by `texture::look_up`;
//!   `texture::bumps` makes normal maps of heights;
//! - `texture::limits` says how large textures may be, `texture::error` what can go wrong;
//! - `texture::format` says how samples are stored, `texture::light` decodes them, and
//!   `texture::texels` holds them in memory;
//! - `texture::picture`s of the `image` crate and picture `texture::file`s become texels;
//! - `texture::wrap` finds the texels at a coordinate, `texture::sample` their colour, by
//!   `texture::cubic`s as well;
//! - `texture::chain` makes the levels of a mip chain, for cut-outs by `texture::cutout`, `texture::level` tells which of them a pixel needs,
//!   and `texture::minify` filters what it sees, by an `texture::ewa` if it is to; `texture::block` does
//!   it for 16 pixels at once, which is what becomes of the `texture::paint` that shaders return;
//! - `texture::environment` is what is seen in a direction.
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
//! | 30°, 0° | 46.4 | 45.5 | 47.6 | 52.6 | 52.6 | 52.6 | 52.6 | 47.8 | 47.8 |
//! | 60°, 0° | 34.5 | 33.3 | 33.4 | 40.2 | 47.2 | 51.2 | 51.7 | 44.3 | 44.3 |
//! | 80°, 0° | 29.3 | 31.3 | 31.7 | 36.0 | 40.2 | 43.1 | 44.6 | 41.7 | 42.1 |
//! | 85°, 0° | 30.3 | 33.3 | 33.4 | 38.0 | 42.6 | 47.3 | 50.5 | 44.3 | 44.8 |
//! | 60°, 30° | 31.4 | 33.4 | 33.9 | 37.1 | 42.7 | 46.9 | 48.5 | 43.7 | 43.9 |
//! | 80°, 30° | 29.2 | 32.2 | 32.4 | 35.4 | 40.4 | 43.7 | 45.3 | 42.5 | 42.9 |
//! | 85°, 30° | 30.1 | 33.5 | 33.6 | 36.4 | 41.0 | 43.8 | 45.0 | 42.9 | 43.3 |
//!
//! With a checkerboard of 500 x 380 texels in its place:
//!
//! | tilt, roll | bilinear | nearest level | trilinear | 2 probes | 4 | 8 | 16 | EWA 16 | EWA 32 |
//! |---|---|---|---|---|---|---|---|---|---|
//! | 60°, 0° | 19.6 | 21.8 | 22.1 | 27.8 | 34.0 | 38.1 | 38.4 | 31.6 | 31.6 |
//! | 80°, 0° | 19.4 | 24.0 | 24.2 | 29.3 | 35.1 | 40.9 | 43.6 | 33.9 | 34.0 |
//! | 85°, 0° | 21.1 | 25.1 | 25.3 | 29.8 | 35.7 | 41.6 | 45.8 | 35.2 | 35.3 |
//! | 60°, 30° | 19.8 | 24.4 | 24.9 | 28.7 | 36.1 | 39.0 | 39.3 | 32.6 | 32.6 |
//! | 80°, 30° | 19.2 | 24.8 | 25.0 | 28.2 | 35.1 | 41.2 | 44.4 | 35.6 | 35.8 |
//! | 85°, 30° | 20.5 | 25.8 | 26.2 | 29.4 | 35.8 | 41.8 | 45.8 | 37.3 | 37.6 |
//!
//! A pixel is a square, whose sections across the footprint's axis are those of a box, or of a trapezoid where it lies askew;
//! so probes weigh.
//!
//! So [`MipFilter::Anisotropic`] is the one to take, with 16 probes for planes to the horizon: it takes no
//! more probes than a footprint is long. In blocks it costs 5.6 times what trilinear costs on a plane tilted
//! by 80°, and no more on one that is seen face on. [`MipFilter::Ewa`] is some 40 times as slow as
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
mod cutout;
mod chain;
mod level;
mod ewa;
mod minify;
mod block;
mod build;
mod bumps;
mod look_up;
mod environment;
mod paint;

pub use self::build::Texture;
pub use self::cubic::Cubic;
pub use self::environment::{DirectionFootprint, EnvironmentMap};
pub use self::error::TextureError;
pub use self::format::{Format, Samples};
pub use self::level::MipFilter;
pub use self::limits::MAX_SIDE;
#[cfg(feature = "png")]
pub use self::limits::{MAX_DECODE_BYTES, MAX_FILE_TEXELS};
pub use self::paint::TexturePaint;
pub use self::sample::Filter;
pub use self::wrap::Wrap;
