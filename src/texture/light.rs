//! From the sRGB pixels of pictures to texels in linear light.

use glam::{Vec3, Vec4};

use crate::color::{decode, linear};

/// The texel of red, green, blue and alpha in 8 bits each.
pub(super) fn light_of_8([r, g, b, alpha]: [u8; 4]) -> Vec4 {
    premultiplied([r, g, b].map(decode), f32::from(alpha) / 255.0)
}

/// A function that gives the texel of red, green, blue and alpha in 16 bits each.
pub(super) fn light_of_16() -> impl Fn([u16; 4]) -> Vec4 {
    // These are 65536 powers; most pictures have more channels than that to decode.
    let lights: Vec<f32> =
        (0..=u16::MAX).map(|code| linear(f64::from(code) / 65_535.0) as f32).collect();
    move |[r, g, b, alpha]| {
        let light = [r, g, b].map(|code| lights[usize::from(code)]);
        premultiplied(light, f32::from(alpha) / 65_535.0)
    }
}

/// The texel of a colour in linear light and an alpha.
pub(super) fn premultiplied(light: [f32; 3], alpha: f32) -> Vec4 {
    (Vec3::from_array(light) * alpha).extend(alpha)
}
