//! `Over` and `Additive` on each type of pixel, against the same sums in f64 and the sRGB curve by
//! `powf`.

use crate::common::generators::Rng;
use glam::{Vec3, Vec4, vec4};
use polyscan::render::{Additive, Over, Paint};
use polyscan::{
    DepthTest, Framebuffer, Mesh, PainterRenderer, ScanlineRenderer, Vertex, ZBufferRenderer,
};

/// The light of a code.
fn to_light(code: u8) -> f64 {
    let encoded = f64::from(code) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The code of a light, before it is rounded.
fn to_code(light: f64) -> f64 {
    let light = light.clamp(0.0, 1.0);
    let encoded =
        if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    255.0 * encoded
}

/// Premultiplied light of a colour with straight alpha.
fn light_of([r, g, b, a]: [u8; 4]) -> [f64; 4] {
    let alpha = f64::from(a) / 255.0;
    [to_light(r) * alpha, to_light(g) * alpha, to_light(b) * alpha, alpha]
}

/// The codes of premultiplied light, before they are rounded.
fn codes_of([r, g, b, a]: [f64; 4]) -> [f64; 4] {
    if a <= 0.0 {
        return [0.0; 4];
    }
    let alpha = a.min(1.0);
    [to_code(r / alpha), to_code(g / alpha), to_code(b / alpha), 255.0 * alpha]
}

/// How far a code may be from the exact value: half a code, and what f32 makes of the light, 2^-20 of
/// it at most after a handful of roundings, times the curve's slope of 112 codes for a factor of e.
const CODE: f64 = 0.5 + 112.0 / (1 << 20) as f64;

fn assert_codes(found: [u8; 4], exact: [f64; 4], what: &str) {
    for (found, exact) in found.into_iter().zip(codes_of(exact)) {
        assert!((f64::from(found) - exact).abs() <= CODE, "{what}: {found} for {exact}");
    }
}

fn over(top: Vec4, below: [f64; 4]) -> [f64; 4] {
    let top = top.to_array().map(f64::from);
    std::array::from_fn(|i| top[i] + below[i] * (1.0 - top[3]))
}

fn plus(top: Vec4, below: [f64; 4]) -> [f64; 4] {
    let top = top.to_array().map(f64::from);
    std::array::from_fn(|i| top[i] + below[i])
}

/// Premultiplied light, seldom brighter than its alpha.
fn any_light(rng: &mut Rng) -> Vec4 {
    let alpha = [0.0, 1.0, 0.5, rng.range(0.0, 1.0), rng.octaves(1e-3, 1.0)][rng.below(5)];
    let most = if rng.once_in(5) { 1.5 } else { alpha };
    vec4(
        rng.range(0.0, most.max(1e-9)) as f32,
        (most * rng.below(2) as f64) as f32,
        rng.range(0.0, most.max(1e-9)) as f32,
        alpha as f32,
    )
}

fn any_codes(rng: &mut Rng) -> [u8; 4] {
    let alpha = [0, 1, 128, 255, rng.below(256)][rng.below(5)] as u8;
    [rng.below(256) as u8, rng.below(256) as u8, rng.below(256) as u8, alpha]
}

#[test]
fn codes_are_blended_in_linear_light() {
    let rng = &mut Rng::new(3);
    for _ in 0..200_000 {
        let (below, light) = (any_codes(rng), any_light(rng));
        let mut pixel = below;
        assert!(Over(light).paint(&mut pixel));
        assert_codes(pixel, over(light, light_of(below)), &format!("{light} over {below:?}"));
        let mut pixel = below;
        assert!(Additive(light).paint(&mut pixel));
        assert_codes(pixel, plus(light, light_of(below)), &format!("{light} and {below:?}"));
    }
}

#[test]
fn what_is_clear_changes_no_code() {
    for code in 0..=255 {
        // Through each alpha but 0, which has no colour.
        for alpha in 1..=255 {
            let below = [code, 255 - code, code / 2, alpha];
            let mut pixel = below;
            assert!(Over(Vec4::ZERO).paint(&mut pixel) && Additive(Vec4::ZERO).paint(&mut pixel));
            assert_eq!(pixel, below);
        }
    }
}

#[test]
fn light_is_blended_as_it_is() {
    let rng = &mut Rng::new(4);
    for _ in 0..100_000 {
        let light = any_light(rng);
        let below = Vec3::from_array([0; 3].map(|_| rng.range(0.0, 2.0) as f32));
        let exact_below = below.extend(1.0).to_array().map(f64::from);
        let check = |pixel: Vec3, exact: [f64; 4], what: &str| {
            for (found, exact) in pixel.to_array().into_iter().zip(exact) {
                // Three roundings of numbers of at most 4.
                let off = (f64::from(found) - exact).abs();
                assert!(off <= 3.0 * 4.0 / f64::from(1 << 24), "{what}: {found} for {exact}");
            }
        };
        let mut pixel = below;
        assert!(Over(light).paint(&mut pixel));
        check(pixel, over(light, exact_below), "over");
        let mut pixel = below;
        assert!(Additive(light.truncate()).paint(&mut pixel));
        check(pixel, plus(light, exact_below), "additive");
        let mut pixel = below.extend(1.0);
        assert!(Over(light).paint(&mut pixel));
        check(pixel.truncate(), over(light, exact_below), "over with alpha");
    }
}

/// Layers of glass and light through each renderer's own loops: the codes of each step are those of one
/// blending alone, in their order from back to front.
#[test]
fn renderers_blend_codes_layer_by_layer() {
    const WIDTH: u32 = 37;
    let rng = &mut Rng::new(5);
    let layers: Vec<Vec4> = (0..8).map(|_| any_light(rng)).collect();
    let light = |face: u32, x: i32| layers[face as usize] * (0.5 + 0.5 * (x as f32 / 64.0));
    // The first is the farthest.
    let vertices: Vec<_> = (0..8)
        .flat_map(|i| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| Vertex::new(vec4(x, y, 0.9 - 0.1 * i as f32, 1.0), []))
        })
        .collect();
    let faces: Vec<[u32; 4]> = (0..8).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]).collect();
    let mut frame = Framebuffer::new(WIDTH, 3, [0; 4]).expect("a small frame");
    frame.color_mut().iter_mut().for_each(|color| *color = any_codes(rng));
    let before = frame.clone();
    let glass = |face: u32| !face.is_multiple_of(3);
    let mut expected = frame.color().to_vec();
    for (i, pixel) in expected.iter_mut().enumerate() {
        for face in 0..8 {
            let light = light(face, i as i32 % WIDTH as i32);
            assert!(if glass(face) {
                Over(light).paint(pixel)
            } else {
                Additive(light).paint(pixel)
            });
        }
    }
    let mesh = || Mesh::new(&vertices, &faces);
    let shader = |f: &polyscan::Fragment<'_, 0>| {
        let light = light(f.face, f.x);
        if glass(f.face) { Blend::Over(Over(light)) } else { Blend::Additive(Additive(light)) }
    };
    let mut z_buffer = ZBufferRenderer::new(frame.viewport());
    z_buffer.draw(&mut frame, mesh(), shader);
    assert_eq!(frame.color(), expected, "z-buffer");
    let mut frame = before.clone();
    z_buffer.depth_test = DepthTest::Always;
    z_buffer.on_one_thread().draw(&mut frame, mesh(), shader);
    assert_eq!(frame.color(), expected, "z-buffer on one thread");
    let mut frame = before.clone();
    PainterRenderer::new(frame.viewport()).draw(&mut frame, mesh(), shader);
    assert_eq!(frame.color(), expected, "painter");
    let mut frame = before;
    let all_glass = mesh().with_transparent(&|_| true);
    ScanlineRenderer::new(frame.viewport()).draw(&mut frame, all_glass, shader);
    assert_eq!(frame.color(), expected, "scanline");
}

/// Either kind of blending.
enum Blend {
    Over(Over),
    Additive(Additive<Vec4>),
}

impl Paint<[u8; 4]> for Blend {
    fn paint(self, pixel: &mut [u8; 4]) -> bool {
        match self {
            Self::Over(color) => color.paint(pixel),
            Self::Additive(color) => color.paint(pixel),
        }
    }
}
