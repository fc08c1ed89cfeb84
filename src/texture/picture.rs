//! Texels from the pictures of the `image` crate.

use image::{ColorType as C, DynamicImage, GenericImageView as _, Rgba};

use crate::texture::error::TextureError;
use crate::texture::format::Samples;
use crate::texture::light::premultiplied;
use crate::texture::texels::{Texels, check_size, copied};

/// The texels of a picture for the eye. Integers are sRGB and are kept as they are; `f32` is linear
/// light already.
pub(super) fn colours(image: &DynamicImage) -> Result<Texels, TextureError> {
    samples(image, |integers| match integers {
        Integers::Bytes(bytes) => Samples::Srgb8(bytes),
        Integers::Words(words) => Samples::Srgb16(words),
    })
    .unwrap_or_else(|| {
        let light = |pixel: &Rgba<f32>| {
            let [r, g, b, alpha] = pixel.0;
            premultiplied([r, g, b], alpha)
        };
        let picture = image.to_rgba32f();
        Texels::collect(image.width(), image.height(), picture.pixels().map(light))
    })
}

/// The texels of a picture that holds numbers: as they stand, integers scaled to 0 to 1.
pub(super) fn numbers(image: &DynamicImage) -> Result<Texels, TextureError> {
    samples(image, |integers| match integers {
        Integers::Bytes(bytes) => Samples::Unorm8(bytes),
        Integers::Words(words) => Samples::Unorm16(words),
    })
    .unwrap_or_else(|| {
        let (width, height) = image.dimensions();
        check_size(width, height)?;
        let samples = image.to_rgba32f().into_raw();
        Texels::new(width, height, 4, Samples::F32(samples))
    })
}

enum Integers {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
}

/// The texels of a picture of integers; `None` if it has floats.
fn samples(
    image: &DynamicImage,
    meaning: impl Fn(Integers) -> Samples,
) -> Option<Result<Texels, TextureError>> {
    let (width, height) = image.dimensions();
    let made = |channels: usize, integers: Result<Integers, TextureError>| {
        Texels::new(width, height, channels, meaning(integers?))
    };
    let bytes = |bytes: &[u8], channels| {
        copied((width, height), bytes, channels, u8::MAX).map(Integers::Bytes)
    };
    let words = |words: &[u16], channels| {
        copied((width, height), words, channels, u16::MAX).map(Integers::Words)
    };
    Some(match (image.color(), image) {
        (_, DynamicImage::ImageLuma8(picture)) => made(1, bytes(picture, 1)),
        (_, DynamicImage::ImageLumaA8(picture)) => made(2, bytes(picture, 2)),
        (_, DynamicImage::ImageRgb8(picture)) => made(4, bytes(picture, 3)),
        (_, DynamicImage::ImageRgba8(picture)) => made(4, bytes(picture, 4)),
        (_, DynamicImage::ImageLuma16(picture)) => made(1, words(picture, 1)),
        (_, DynamicImage::ImageLumaA16(picture)) => made(2, words(picture, 2)),
        (_, DynamicImage::ImageRgb16(picture)) => made(4, words(picture, 3)),
        (_, DynamicImage::ImageRgba16(picture)) => made(4, words(picture, 4)),
        // Kinds that this crate does not know yet.
        (C::L8 | C::La8 | C::Rgb8 | C::Rgba8, _) => made(4, bytes(&image.to_rgba8(), 4)),
        (C::L16 | C::La16 | C::Rgb16 | C::Rgba16, _) => made(4, words(&image.to_rgba16(), 4)),
        _ => return None,
    })
}
