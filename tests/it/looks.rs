//! The colours of materials: in blocks as one by one.

use glam::{Vec2, Vec3, Vec4, vec2, vec3, vec4};
use polyscan::Texture;
use polyscan::fragment::{Footprint, FootprintBlock, LANES, Lanes};
use polyscan::model::{AlphaMode, Material};
use polyscan::tangent::TangentFrame;
use polyscan::texture::MipFilter;

use crate::common::generators::Rng;

/// A number from -most to most.
fn float(rng: &mut Rng, most: f64) -> f32 {
    rng.range(-most, most) as f32
}

/// A picture of colours and alphas of all sorts.
fn picture(rng: &mut Rng) -> Texture {
    let texel = |_, _| {
        let alpha = [0.0, 1.0, float(rng, 0.5) + 0.5][rng.below(3)];
        vec4(float(rng, 0.5) + 0.5, float(rng, 0.5) + 0.5, 0.25, 1.0) * alpha
    };
    let texture = Texture::from_fn(8, 8, texel).expect("a picture");
    let texture = texture.with_mipmaps().expect("levels");
    texture.with_mip_filter(MipFilter::Anisotropic { probes: 4 })
}

fn material(rng: &mut Rng) -> Material {
    let mut material = Material::new("a", vec3(0.5, 1.0, float(rng, 0.5) + 0.5));
    let modes = [AlphaMode::Opaque, AlphaMode::Blend, AlphaMode::Cutout { threshold: 0.5 }];
    material.alpha_mode = modes[rng.below(3)];
    material.alpha = [1.0, 0.75, 0.0][rng.below(3)];
    material.texture = [None, Some(0), Some(7)][rng.below(3)];
    material.alpha_texture = [None, Some(1)][rng.below(2)];
    for mapping in [&mut material.mapping, &mut material.alpha_mapping] {
        mapping.scale = vec2(float(rng, 3.0), float(rng, 3.0));
        mapping.turn = Vec2::from_angle(float(rng, 3.0));
        mapping.offset = vec2(float(rng, 1.0), float(rng, 1.0));
        mapping.gain = float(rng, 0.5) + 1.0;
    }
    material
}

#[test]
fn a_block_has_the_colours_of_its_pixels() {
    let rng = &mut Rng::new(1607);
    let textures = [picture(rng), picture(rng)];
    for _ in 0..300 {
        let material = material(rng);
        let mut lanes = |scale: f64| -> Lanes { std::array::from_fn(|_| float(rng, scale)) };
        let seen = FootprintBlock {
            uv: [lanes(2.0), lanes(2.0)],
            dx: [lanes(0.2), lanes(0.2)],
            dy: [lanes(0.2), lanes(0.2)],
        };
        let color = [lanes(1.0), lanes(1.0), lanes(1.0), lanes(1.0).map(f32::abs)];
        let [r, g, b, a] = &color;
        let found = material.colors_at(&textures, &seen, [r, g, b, a], 0xffff);
        for lane in 0..LANES {
            let color = vec4(r[lane], g[lane], b[lane], a[lane]);
            let expected = material.color_at(&textures, &seen.get(lane), color);
            assert_eq!(found[lane], expected, "{material:?}");
        }
    }
}

/// The picture turns around the corner that texture coordinates begin at, scaled before and moved after:
/// in f64, with v up.
#[test]
fn mappings_scale_turn_and_move() {
    let rng = &mut Rng::new(3);
    for _ in 0..200 {
        let mut material = material(rng);
        material.texture = Some(0);
        let mapping = material.mapping;
        let uv = vec2(float(rng, 2.0), float(rng, 2.0));
        let up = glam::dvec2(f64::from(uv.x), 1.0 - f64::from(uv.y));
        let turned = mapping.turn.as_dvec2().rotate(up * mapping.scale.as_dvec2());
        let moved = turned + mapping.offset.as_dvec2();
        let expected = glam::dvec2(moved.x, 1.0 - moved.y).as_vec2();
        assert!((mapping.uv(uv) - expected).length() < 1e-5, "{uv} {mapping:?}");
        // A color that varies nowhere is what it is, however the picture lies.
        let grey = [Texture::from_fn(2, 2, |_, _| Vec4::ONE).expect("a picture")];
        material.alpha_texture = None;
        (material.alpha_mode, material.mapping.gain) = (AlphaMode::Opaque, 1.0);
        let color = material.color_at(&grey, &Footprint::from(uv), Vec4::ONE);
        assert!((color.truncate() - material.diffuse).length() < 1e-6, "{color}");
    }
}

/// The normals of a block are those of its pixels, and a picture that is turned bends as its heights do.
#[test]
fn normals_lean_from_heights_however_the_picture_lies() {
    let rng = &mut Rng::new(99);
    // Waves, 64 texels long: a height of 1 is as high as a texel is wide.
    let wave = |x: u32, y: u32| {
        let angle = |n: u32| n as f32 / 64.0 * std::f32::consts::TAU;
        Vec4::splat(3.0 * angle(x).sin() + 2.0 * angle(y).cos())
    };
    let heights = Texture::from_fn(64, 64, wave).expect("heights");
    let textures = [heights.normals_of_heights(1.0).expect("normals")];
    for _ in 0..100 {
        let mut material = material(rng);
        let scale = [1.0, -1.0][rng.below(2)];
        material.normal_texture = Some(0);
        (material.normal_mapping.scale, material.normal_mapping.turn) =
            (vec2(scale, 1.0), Vec2::from_angle(float(rng, 3.0)));
        let mapping = material.normal_mapping;
        let mut lanes = |scale: f64| -> Lanes { std::array::from_fn(|_| float(rng, scale)) };
        let point = [[0.0; LANES]; 2];
        let seen = FootprintBlock { uv: [lanes(2.0), lanes(2.0)], dx: point, dy: point };
        let one = |value: f32| [value; LANES];
        let (normal, tangent) = ([0.0, 0.0, 1.0].map(one), [1.0, 0.0, 0.0, 1.0].map(one));
        let found =
            material.normals_at(&textures, &seen, normal.each_ref(), tangent.each_ref(), 0xffff);
        for lane in 0..LANES {
            let frame = TangentFrame::new(Vec3::Z, vec4(1.0, 0.0, 0.0, 1.0));
            let alone = material.normal_at(&textures, &seen.get(lane), &frame);
            assert_eq!(found.map(|axis| axis[lane]), alone.to_array());
            // The slopes of the heights as they are seen, by differences.
            let uv = seen.get(lane).uv;
            let height = |by: Vec2| {
                let at = mapping.uv(uv + by / 64.0) * 64.0 - 0.5;
                let angle = |n: f32| f64::from(n) / 64.0 * std::f64::consts::TAU;
                3.0 * angle(at.x).sin() + 2.0 * angle(at.y).cos()
            };
            let right = (height(Vec2::X * 0.5) - height(Vec2::X * -0.5)) as f32;
            let down = (height(Vec2::Y * 0.5) - height(Vec2::Y * -0.5)) as f32;
            let expected = vec3(-right, down, 1.0).normalize();
            assert!((alone - expected).length() < 0.01, "{alone} {expected} {mapping:?}");
        }
    }
}
