//! Texture sampling against independent arithmetic: wrap modes by integers, bilinear weights in
//! `f64`, colours decoded before they are averaged, and odd coordinates.

use glam::{Vec2, Vec4, vec2};
use polyscan::texture::{Filter, MAX_SIDE, Texture, TextureError, Wrap};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];
const SIZES: [(u32, u32); 6] = [(1, 1), (2, 1), (1, 3), (4, 4), (7, 5), (16, 3)];

/// Texels that all differ, from 0 to 1 in each channel.
fn numbered(width: u32, height: u32) -> Texture {
    let shade = |x: u32, y: u32, step: u32| (((x * 7 + y * 13) * step) % 101) as f32 / 100.0;
    Texture::from_fn(width, height, |x, y| {
        Vec4::new(shade(x, y, 1), shade(x, y, 3), shade(x, y, 9), shade(x, y, 27))
    })
    .expect("a size within the limits")
}

/// The texel shown at the integer place `i`, by integer arithmetic.
fn wrapped_index(i: i64, size: u32, wrap: Wrap) -> u32 {
    let n = i64::from(size);
    let index = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let phase = i.rem_euclid(2 * n);
            if phase < n { phase } else { 2 * n - 1 - phase }
        }
        _ => unreachable!("no other way to wrap"),
    };
    u32::try_from(index).expect("inside the picture")
}

/// The bilinear mean by its definition, in `f64`.
fn bilinear_f64(texture: &Texture, uv: Vec2, (wrap_u, wrap_v): (Wrap, Wrap)) -> [f64; 4] {
    let (width, height) = (texture.width(), texture.height());
    let x = f64::from(uv.x) * f64::from(width) - 0.5;
    let y = f64::from(uv.y) * f64::from(height) - 0.5;
    let mut sum = [0.0; 4];
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let weight = |place: f64, d: i64| {
            let fraction = place - place.floor();
            if d == 0 { 1.0 - fraction } else { fraction }
        };
        let texel = texture.texel(
            wrapped_index(x.floor() as i64 + dx, width, wrap_u),
            wrapped_index(y.floor() as i64 + dy, height, wrap_v),
        );
        for (channel, value) in sum.iter_mut().zip(texel.to_array()) {
            *channel += f64::from(value) * weight(x, dx) * weight(y, dy);
        }
    }
    sum
}

/// Coordinates in steps that meet no texel boundary twice alike, from -3 to 3.
fn coordinates() -> impl Iterator<Item = f32> {
    (-300..300).map(|i| i as f32 * 0.010_009_766)
}

#[test]
fn nearest_shows_the_texel_that_integers_tell() {
    for (width, height) in SIZES {
        for wrap in WRAPS {
            let texture = numbered(width, height).with_filter(Filter::Nearest).with_wrap(wrap);
            for i in -3 * i64::from(width)..3 * i64::from(width) {
                for j in -3 * i64::from(height)..3 * i64::from(height) {
                    let uv = vec2(
                        ((i as f64 + 0.5) / f64::from(width)) as f32,
                        ((j as f64 + 0.5) / f64::from(height)) as f32,
                    );
                    let (x, y) = (wrapped_index(i, width, wrap), wrapped_index(j, height, wrap));
                    assert_eq!(texture.sample(uv), texture.texel(x, y), "{texture:?} at {uv}");
                }
            }
        }
    }
}

#[test]
fn bilinear_is_the_weighted_mean_of_four() {
    for (width, height) in SIZES {
        for wraps in WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| (u, v))) {
            let texture = numbered(width, height).with_wraps(wraps.0, wraps.1);
            for (u, v) in coordinates().zip(coordinates().skip(211).chain(coordinates())) {
                let uv = vec2(u, v);
                let expected = bilinear_f64(&texture, uv, wraps);
                for (ours, exact) in texture.sample(uv).to_array().into_iter().zip(expected) {
                    // Positions up to 16 are known to half of 2^-20, and so are the weights.
                    assert!((f64::from(ours) - exact).abs() < 4e-6, "{texture:?} at {uv}");
                }
            }
        }
    }
}

#[test]
fn at_texel_centres_bilinear_gives_the_texels() {
    let texture = numbered(8, 4);
    for (x, y) in (0..8).flat_map(|x| (0..4).map(move |y| (x, y))) {
        let uv = vec2((x as f32 + 0.5) / 8.0, (y as f32 + 0.5) / 4.0);
        assert_eq!(texture.bilinear(uv), texture.texel(x, y));
    }
}

#[test]
fn v_goes_down() {
    let texture = numbered(2, 2).with_filter(Filter::Nearest);
    assert_eq!(texture.sample(vec2(0.1, 0.1)), texture.texel(0, 0));
    assert_eq!(texture.sample(vec2(0.9, 0.1)), texture.texel(1, 0));
    assert_eq!(texture.sample(vec2(0.1, 0.9)), texture.texel(0, 1));
}

#[test]
fn a_repeated_picture_has_no_seam() {
    let texture = numbered(5, 3);
    for v in coordinates() {
        let seam = texture.sample(vec2(0.0, v));
        assert_eq!(texture.sample(vec2(1.0, v)), seam);
        let left = texture.sample(vec2(-1e-7, v));
        assert!((left - seam).abs().max_element() < 1e-5, "{left} beside {seam}");
        // It is half way between the centres of the last column and the first.
        let mean = (texture.sample(vec2(0.9, v)) + texture.sample(vec2(0.1, v))) * 0.5;
        assert!((mean - seam).abs().max_element() < 1e-5, "{mean} for {seam}");
    }
}

#[test]
fn wrapping_is_exact_far_out() {
    // 2^20 + 1/8 and the like are floats: nothing is lost on the way back.
    for wrap in [Wrap::Repeat, Wrap::Mirror] {
        let texture = numbered(7, 5).with_wrap(wrap);
        for eighth in 0..16 {
            let near = eighth as f32 * 0.125;
            for far in [1_048_576.0, -1_048_576.0] {
                let (here, there) = (vec2(near, 0.4), vec2(near + far, 0.4));
                assert_eq!(texture.sample(here), texture.sample(there), "{wrap:?} {near}");
            }
        }
    }
}

#[test]
fn a_mirrored_picture_is_symmetrical() {
    let texture = numbered(7, 5).with_wrap(Wrap::Mirror);
    for filter in [Filter::Nearest, Filter::Bilinear] {
        let texture = texture.clone().with_filter(filter);
        for u in coordinates() {
            assert_eq!(texture.sample(vec2(u, 0.3)), texture.sample(vec2(-u, 0.3)));
        }
        for step in 0..64 {
            let d = step as f32 / 64.0;
            assert_eq!(texture.sample(vec2(1.0 + d, 0.3)), texture.sample(vec2(1.0 - d, 0.3)));
        }
    }
}

#[test]
fn any_coordinate_is_safe() {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        -f32::MIN_POSITIVE,
        1e-45,
        -1e-45,
        -1e-8,
        -0.0,
        1.0,
        1.0_f32.next_down(),
        1.0_f32.next_up(),
        8_388_607.5,
        -8_388_607.5,
        1e10,
    ];
    for (width, height) in SIZES {
        for wraps in WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| (u, v))) {
            let texture = numbered(width, height).with_wraps(wraps.0, wraps.1);
            for uv in odd.into_iter().flat_map(|u| odd.map(|v| vec2(u, v))) {
                for color in [texture.nearest(uv), texture.bilinear(uv)] {
                    let inside = color.cmpge(Vec4::ZERO) & color.cmple(Vec4::ONE);
                    assert!(inside.all(), "{texture:?} at {uv}: {color}");
                }
            }
        }
    }
}

#[test]
fn what_is_no_number_counts_as_zero_or_the_edge() {
    let texture = numbered(4, 1);
    for wrap in WRAPS {
        let texture = texture.clone().with_wrap(wrap);
        assert_eq!(texture.sample(vec2(f32::NAN, 0.5)), texture.sample(vec2(0.0, 0.5)));
    }
    let clamped = texture.clone().with_wrap(Wrap::Clamp);
    assert_eq!(clamped.sample(vec2(f32::INFINITY, 0.5)), texture.texel(3, 0));
    assert_eq!(clamped.sample(vec2(f32::NEG_INFINITY, 0.5)), texture.texel(0, 0));
    let repeated = texture.with_wrap(Wrap::Repeat);
    assert_eq!(repeated.sample(vec2(f32::INFINITY, 0.5)), repeated.sample(vec2(0.0, 0.5)));
}

#[test]
fn the_longest_side_is_addressed_to_its_end() {
    let texture = Texture::from_fn(MAX_SIDE, 1, |x, _| Vec4::splat(x as f32)).expect("allowed");
    for x in [0, 1, 255, 256, 32_767, 32_768, 65_534, 65_535] {
        let uv = vec2((x as f32 + 0.5) / 65_536.0, 0.5);
        assert_eq!(texture.nearest(uv).x, x as f32);
        assert_eq!(texture.bilinear(uv).x, x as f32);
    }
    assert_eq!(texture.bilinear(vec2(1.0, 0.5)).x, 65_535.0 / 2.0);
}

#[test]
fn a_plain_picture_stays_plain() {
    let plain = Vec4::new(0.1, 0.7, 0.333, 0.9);
    let texture = Texture::from_fn(3, 3, |_, _| plain).expect("allowed");
    for uv in coordinates().map(|u| vec2(u, 1.7 * u)) {
        assert_eq!(texture.sample(uv), plain);
    }
}

#[test]
fn sizes_are_checked() {
    for (width, height) in [(0, 1), (1, 0), (0, 0), (MAX_SIDE + 1, 1), (1, u32::MAX)] {
        let error = Texture::new(width, height, Vec::new()).expect_err("no such texture");
        assert!(matches!(error, TextureError::Size { .. }), "{error}");
        assert!(error.to_string().contains(&format!("{width} x {height}")), "{error}");
        let called = Texture::from_fn(width, height, |_, _| unreachable!("no texel to ask for"));
        assert!(called.is_err());
    }
    let error = Texture::new(3, 2, vec![Vec4::ZERO; 5]).expect_err("a texel too few");
    assert_eq!(
        error.to_string(),
        "20 samples were given for a texture of 3 x 2 texels of 4: give 24 of them, row by row"
    );
}

#[test]
fn texels_past_the_edge_are_the_edge() {
    let texture = numbered(4, 3);
    assert_eq!(texture.texel(9, u32::MAX), texture.texel(3, 2));
}

#[cfg(feature = "image")]
mod pictures {
    use glam::Vec3;
    use image::{
        DynamicImage, GrayAlphaImage, GrayImage, ImageFormat, Rgb32FImage, RgbImage, Rgba32FImage,
        RgbaImage,
    };
    use polyscan::color::{decode, encode};

    use super::*;

    fn texture(image: impl Into<DynamicImage>) -> Texture {
        Texture::from_image(&image.into()).expect("a small picture")
    }

    fn only_texel(image: impl Into<DynamicImage>) -> Vec4 {
        texture(image).texel(0, 0)
    }

    #[test]
    fn colours_are_decoded_before_they_are_averaged() {
        let picture = GrayImage::from_raw(2, 1, vec![0, 255]).expect("two pixels");
        let grey = texture(picture).with_wrap(Wrap::Clamp).sample(vec2(0.5, 0.5));
        assert_eq!(grey, Vec4::new(0.5, 0.5, 0.5, 1.0));
        assert_eq!(encode(grey.x), 188);
    }

    #[test]
    fn eight_bits_are_srgb() {
        let light = Vec4::new(decode(10), decode(100), decode(200), 1.0);
        assert_eq!(only_texel(RgbImage::from_pixel(1, 1, image::Rgb([10, 100, 200]))), light);
        let half = 128.0 / 255.0;
        let clear = RgbaImage::from_pixel(1, 1, image::Rgba([10, 100, 200, 128]));
        assert_eq!(only_texel(clear), (light.truncate() * half).extend(half));
        let grey = GrayAlphaImage::from_pixel(1, 1, image::LumaA([100, 128]));
        assert_eq!(only_texel(grey), (Vec3::splat(light.y) * half).extend(half));
    }

    #[test]
    fn sixteen_bits_are_srgb_too() {
        // 257 times an 8-bit code is the same colour.
        for code in [0_u8, 1, 10, 11, 100, 200, 255] {
            let pixel = image::Luma([u16::from(code) * 257]);
            let texel =
                only_texel(DynamicImage::ImageLuma16(image::ImageBuffer::from_pixel(1, 1, pixel)));
            assert_eq!(texel, Vec4::new(decode(code), decode(code), decode(code), 1.0));
        }
        let pixel = image::Rgba([65_535_u16, 0, 30_000, 32_768]);
        let texel =
            only_texel(DynamicImage::ImageRgba16(image::ImageBuffer::from_pixel(1, 1, pixel)));
        let alpha = 32_768.0 / 65_535.0;
        let blue = ((30_000.0 / 65_535.0 + 0.055) / 1.055_f64).powf(2.4) * alpha;
        let expected = [alpha, 0.0, blue, alpha];
        for (ours, exact) in texel.to_array().into_iter().zip(expected) {
            assert!((f64::from(ours) - exact).abs() < 1e-7, "{ours} for {exact}");
        }
    }

    #[test]
    fn floats_are_light_already() {
        let picture = Rgb32FImage::from_pixel(1, 1, image::Rgb([0.25, 3.0, 0.5]));
        assert_eq!(only_texel(picture), Vec4::new(0.25, 3.0, 0.5, 1.0));
        let picture = Rgba32FImage::from_pixel(1, 1, image::Rgba([0.25, 3.0, 0.5, 0.5]));
        assert_eq!(only_texel(picture), Vec4::new(0.125, 1.5, 0.25, 0.5));
    }

    #[test]
    fn numbers_are_taken_as_they_stand() {
        let picture = RgbaImage::from_pixel(1, 1, image::Rgba([0, 51, 255, 102]));
        let texture = Texture::from_data(&picture.into()).expect("a small picture");
        assert_eq!(texture.texel(0, 0), Vec4::new(0.0, 0.2, 1.0, 0.4));
    }

    #[test]
    fn an_empty_picture_is_an_error() {
        let error = Texture::from_image(&RgbImage::new(0, 3).into()).expect_err("nothing to show");
        assert!(matches!(error, TextureError::Size { width: 0, height: 3 }), "{error}");
    }

    #[test]
    fn files_of_every_format_open() {
        let folder = tempfile::tempdir().expect("a folder");
        let picture = RgbImage::from_fn(3, 2, |x, y| image::Rgb([80 * x as u8, 90 * y as u8, 7]));
        let expected = texture(picture.clone());
        for (name, format) in [
            ("a.png", ImageFormat::Png),
            ("a.tga", ImageFormat::Tga),
            ("a.bmp", ImageFormat::Bmp),
            ("a.ppm", ImageFormat::Pnm),
            // The content tells more than the name.
            ("png.tga", ImageFormat::Png),
            ("none", ImageFormat::Bmp),
        ] {
            let path = folder.path().join(name);
            picture.save_with_format(&path, format).expect("a file");
            let texture = Texture::open(&path).expect(name);
            assert!(texture.texels().eq(expected.texels()), "{name}");
        }
    }

    #[test]
    fn errors_name_the_file_and_the_cause() {
        let folder = tempfile::tempdir().expect("a folder");
        let missing = folder.path().join("missing.png");
        let error = Texture::open(&missing).expect_err("no file");
        assert!(matches!(error, TextureError::Read { .. }), "{error:?}");
        assert!(error.to_string().contains("missing.png"), "{error}");

        let broken = folder.path().join("broken.png");
        for content in [&b"not a picture"[..], b"\x89PNG\r\n\x1a\n", b""] {
            std::fs::write(&broken, content).expect("a file");
            let error = Texture::open(&broken).expect_err("no picture");
            assert!(matches!(error, TextureError::Decode { .. }), "{error:?}");
            assert!(error.to_string().contains("broken.png"), "{error}");
        }
        assert!(Texture::open(folder.path()).is_err());
    }

    #[test]
    fn a_small_file_cannot_ask_for_much_memory() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("huge.pgm");
        for (header, cause) in [
            ("P5 70000 1 255\n", "70000 x 1"),
            ("P5 16385 16384 255\n", "16385 x 16384"),
            ("P6 16384 16384 65535\n", "memory"),
        ] {
            std::fs::write(&path, header).expect("a file");
            let error = Texture::open(&path).expect_err("over the limits");
            assert!(error.to_string().to_lowercase().contains(cause), "{error}");
            assert!(error.to_string().contains("huge.pgm"), "{error}");
        }
    }
}
