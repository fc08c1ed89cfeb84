//! Texels from the pictures of the `image` crate.

use glam::Vec4;
use image::{ColorType as C, DynamicImage, Rgba};

use crate::texture::error::TextureError;
use crate::texture::light::{light_of_8, light_of_16, premultiplied};
use crate::texture::texels::Texels;

/// The texels of a picture for the eye. Integers are sRGB; `f32` is linear light already.
pub(super) fn colours(image: &DynamicImage) -> Result<Texels, TextureError> {
    let (width, height) = (image.width(), image.height());
    match image.color() {
        C::L8 | C::La8 | C::Rgb8 | C::Rgba8 => {
            let picture = image.to_rgba8();
            Texels::collect(width, height, picture.pixels().map(|pixel| light_of_8(pixel.0)))
        }
        C::L16 | C::La16 | C::Rgb16 | C::Rgba16 => {
            let (picture, light) = (image.to_rgba16(), light_of_16());
            Texels::collect(width, height, picture.pixels().map(|pixel| light(pixel.0)))
        }
        _ => {
            let light = |pixel: &Rgba<f32>| {
                let [r, g, b, alpha] = pixel.0;
                premultiplied([r, g, b], alpha)
            };
            Texels::collect(width, height, image.to_rgba32f().pixels().map(light))
        }
    }
}

/// The texels of a picture that holds numbers: as they stand, integers scaled to 0 to 1.
pub(super) fn numbers(image: &DynamicImage) -> Result<Texels, TextureError> {
    let numbers = image.to_rgba32f();
    let texels = numbers.pixels().map(|pixel| Vec4::from_array(pixel.0));
    Texels::collect(image.width(), image.height(), texels)
}
