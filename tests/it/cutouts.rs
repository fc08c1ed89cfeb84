//! Mip chains of cut-outs: as much is left of them at each level as in the picture.

use glam::{Vec4, vec3, vec4};
use polyscan::texture::{Filter, MipFilter, Samples, Texture};
use polyscan::{Framebuffer, Vertex, ZBufferRenderer};

use crate::common::generators::Rng;

/// Leaves: small discs of alpha 1, with rims, that cover a part of the picture.
fn leaves(rng: &mut Rng, (width, height): (u32, u32), count: usize, radius: f32) -> Texture {
    let discs: Vec<_> = (0..count)
        .map(|_| {
            (rng.range(0.0, 1.0) as f32 * width as f32, rng.range(0.0, 1.0) as f32 * height as f32)
        })
        .collect();
    let texel = |x: u32, y: u32| {
        let at = (x as f32 + 0.5, y as f32 + 0.5);
        let reach = |&(cx, cy): &(f32, f32)| radius - (at.0 - cx).hypot(at.1 - cy);
        let alpha = discs.iter().map(reach).fold(f32::MIN, f32::max).clamp(-0.5, 0.5) + 0.5;
        (vec3(0.2, 0.5, 0.1) * alpha).extend(alpha)
    };
    Texture::from_fn(width, height, texel).expect("leaves")
}

/// The part of a level where alpha, bilinear between texels, is at the threshold or above: by 9 x 9 points a
/// texel in f64.
fn coverage(texture: &Texture, level: u32, threshold: f64) -> f64 {
    let (width, height) = texture.level_size(level);
    let alpha = |x: u32, y: u32| f64::from(texture.level_texel(level, x % width, y % height).w);
    let mut covered = 0_u64;
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| alpha(x + i, y + j));
        for (i, j) in (0..9).flat_map(|i| (0..9).map(move |j| (i, j))) {
            let [s, t] = [i, j].map(|n| (f64::from(n) + 0.5) / 9.0);
            let value = (a * (1.0 - s) + b * s) * (1.0 - t) + (c * (1.0 - s) + d * s) * t;
            covered += u64::from(value >= threshold);
        }
    }
    covered as f64 / (81.0 * f64::from(width) * f64::from(height))
}

#[test]
fn levels_of_cut_outs_cover_as_much_as_the_picture() {
    let rng = &mut Rng::new(2010);
    let mut worst_without = 0.0_f64;
    for (size, threshold) in
        [((256, 256), 0.5_f32), ((200, 150), 0.5), ((129, 255), 0.25), ((256, 128), 0.8)]
    {
        let picture = leaves(rng, size, 220, 3.5);
        let exact = f64::from(threshold);
        let wanted = coverage(&picture, 0, exact);
        assert!((0.1..0.8).contains(&wanted), "{wanted}");
        let made = picture.clone().with_cutout_mipmaps(threshold).expect("a chain");
        let plain = picture.with_mipmaps().expect("a chain");
        for level in 1..made.level_count() {
            let (width, height) = made.level_size(level);
            if width.min(height) < 8 {
                break;
            }
            let found = coverage(&made, level, exact);
            assert!((found - wanted).abs() < 0.02, "{size:?} {level}: {found} {wanted}");
            worst_without = worst_without.max((coverage(&plain, level, exact) - wanted).abs());
            // What is seen of the leaves has their colour.
            for texel in (0..width).map(|x| made.level_texel(level, x, height / 2)) {
                assert!(texel.w <= 1.0 + 1e-6, "{texel}");
                let color = texel.truncate() - vec3(0.2, 0.5, 0.1) * texel.w;
                assert!(color.length() < 1e-5, "{texel}");
            }
        }
    }
    // Without, they vanish, or all is leaf.
    assert!(worst_without > 0.15, "{worst_without}");
}

/// In bytes as well, and by the alpha that is stored with colours.
#[test]
fn chains_of_cut_outs_in_bytes_cover_as_much() {
    let picture = leaves(&mut Rng::new(5), (128, 128), 60, 3.0);
    let bytes = picture.texels().flat_map(|texel| [40, 120, 20, (texel.w * 255.0).round() as u8]);
    let picture = Texture::from_samples(128, 128, 4, Samples::Srgb8(bytes.collect()));
    let picture = picture.expect("bytes");
    let wanted = coverage(&picture, 0, 0.5);
    let made = picture.with_cutout_mipmaps(0.5).expect("a chain");
    for level in 1..=4 {
        let found = coverage(&made, level, 0.5);
        assert!((found - wanted).abs() < 0.03, "{level}: {found} {wanted}");
    }
}

#[test]
fn pictures_without_holes_or_of_nothing_stay_so() {
    for alpha in [0.0, 1.0] {
        let picture = Texture::from_fn(12, 7, |x, _| vec4(0.1 * x as f32, 0.5, 0.0, 1.0) * alpha);
        let picture = picture.expect("a picture");
        let made = picture.clone().with_cutout_mipmaps(0.5).expect("a chain");
        let plain = picture.with_mipmaps().expect("a chain");
        for level in 0..plain.level_count() {
            assert_eq!(made.level_texel(level, 0, 0), plain.level_texel(level, 0, 0));
        }
    }
}

/// A tree that goes away: the part of its pixels that are leaves stays.
#[test]
fn leaves_are_seen_from_afar() {
    let picture = leaves(&mut Rng::new(11), (256, 256), 700, 3.5);
    let part = |texture: &Texture, size: u32| {
        let mut frame = Framebuffer::new(size, size, Vec4::ZERO).expect("pixels");
        let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [0.5 * x, 0.5 * y]));
        ZBufferRenderer::new(frame.viewport()).draw(&mut frame, &quad, |fragment| {
            let color = texture.sample_footprint(&fragment.footprint(0, 1));
            (color.w >= 0.5).then_some(Vec4::ONE)
        });
        frame.color().iter().map(|color| color.w).sum::<f32>() / (size * size) as f32
    };
    let near = part(&picture.clone().with_filter(Filter::Bilinear), 512);
    let made = picture.clone().with_cutout_mipmaps(0.5).expect("a chain");
    let plain = picture.with_mipmaps().expect("a chain");
    for size in [64, 45, 32, 23] {
        for filter in [MipFilter::Nearest, MipFilter::Linear] {
            let far = part(&made.clone().with_mip_filter(filter), size);
            assert!((far - near).abs() < 0.05, "{size} {filter:?}: {far} {near}");
        }
    }
    let without = part(&plain, 23);
    assert!((without - near).abs() > 0.5 * near, "{without} {near}");
}
