//! Filters, mip chains and stored formats against arithmetic in `f64` that is written from the
//! definitions: areas by overlap, cubics by their formula, levels by logarithms.

use crate::common::dynamic;
use glam::{DVec2, DVec4, Vec2, Vec3, Vec4, vec2};
use polyscan::color::{Color, decode};
use polyscan::texture::{Cubic, Filter, Format, MipFilter, Samples, Texture, Wrap};
use polyscan::{
    Footprint, FootprintBlock, Fragment, Framebuffer, Level, Mesh, ParameterMatrix, ScanConverter,
    Vertex, Viewport, ZBufferRenderer,
};

const WRAPS: [Wrap; 4] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror, Wrap::Border];

/// Numbers from 0 to 1 that look random.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        // A linear congruential generator (Numerical Recipes, 1992); the upper bits are good.
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    fn vec2(&mut self, size: f32) -> Vec2 {
        vec2(self.next() - 0.5, self.next() - 0.5) * 2.0 * size
    }
}

fn noise(width: u32, height: u32) -> Texture {
    let mut random = Random(width * 31 + height);
    Texture::from_fn(width, height, |_, _| Vec4::from([0; 4].map(|_| random.next())))
        .expect("a size within the limits")
}

/// The texel at an integer place, `None` for the border.
fn wrapped(i: i64, size: u32, wrap: Wrap) -> Option<u32> {
    let n = i64::from(size);
    let index = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror if i.rem_euclid(2 * n) < n => i.rem_euclid(2 * n),
        Wrap::Mirror => 2 * n - 1 - i.rem_euclid(2 * n),
        _ => return (0..n).contains(&i).then_some(i as u32),
    };
    Some(index as u32)
}

/// The sum of all texels in reach, weighted along each axis by distance from the point.
fn weighted(texture: &Texture, uv: Vec2, weight: impl Fn(f64) -> f64) -> [f64; 4] {
    let (size, wraps) = ((texture.width(), texture.height()), texture.wraps());
    let x = f64::from(uv.x) * f64::from(size.0) - 0.5;
    let y = f64::from(uv.y) * f64::from(size.1) - 0.5;
    let mut sum = [0.0; 4];
    for j in y.floor() as i64 - 3..y.floor() as i64 + 5 {
        for i in x.floor() as i64 - 3..x.floor() as i64 + 5 {
            let texel = match (wrapped(i, size.0, wraps.0), wrapped(j, size.1, wraps.1)) {
                (Some(i), Some(j)) => texture.texel(i, j),
                _ => texture.border(),
            };
            let weight = weight((x - i as f64).abs()) * weight((y - j as f64).abs());
            for (sum, channel) in sum.iter_mut().zip(texel.to_array()) {
                *sum += f64::from(channel) * weight;
            }
        }
    }
    sum
}

fn assert_near(ours: Vec4, exact: [f64; 4], tolerance: f64, what: &str) {
    for (ours, exact) in ours.to_array().into_iter().zip(exact) {
        assert!((f64::from(ours) - exact).abs() <= tolerance, "{what}: {ours} for {exact}");
    }
}

// ------------------------------------------------------------------------------- magnification

#[test]
fn bilinear_and_bicubic_follow_their_formulas_with_every_wrap() {
    let mut random = Random(7);
    for (width, height) in [(1, 1), (2, 3), (7, 5), (16, 9)] {
        for (u, v) in WRAPS.into_iter().flat_map(|u| WRAPS.map(|v| (u, v))) {
            let texture =
                noise(width, height).with_wraps(u, v).with_border(Vec4::new(0.2, 0.9, 0.4, 0.8));
            for _ in 0..50 {
                let uv = random.vec2(2.5);
                let exact = weighted(&texture, uv, |d| (1.0 - d).max(0.0));
                assert_near(texture.bilinear(uv), exact, 4e-6, &format!("{texture:?} at {uv}"));
                for (b, c) in [(1.0, 0.0), (0.0, 0.5), (1.0 / 3.0, 1.0 / 3.0), (0.2, 0.7)] {
                    // Mitchell and Netravali 1988, equation (8).
                    let cubic = |d: f64| {
                        let (b, c) = (f64::from(b), f64::from(c));
                        let sum = if d < 1.0 {
                            (12.0 - 9.0 * b - 6.0 * c) * d.powi(3)
                                + (-18.0 + 12.0 * b + 6.0 * c) * d.powi(2)
                                + (6.0 - 2.0 * b)
                        } else if d < 2.0 {
                            (-b - 6.0 * c) * d.powi(3)
                                + (6.0 * b + 30.0 * c) * d.powi(2)
                                + (-12.0 * b - 48.0 * c) * d
                                + (8.0 * b + 24.0 * c)
                        } else {
                            0.0
                        };
                        sum / 6.0
                    };
                    let filter = Filter::Bicubic(Cubic { b, c });
                    let ours = texture.clone().with_filter(filter).sample(uv);
                    let exact = weighted(&texture, uv, cubic);
                    assert_near(ours, exact, 8e-6, &format!("{filter:?} {texture:?} at {uv}"));
                }
            }
        }
    }
}

#[test]
fn far_out_and_what_is_no_number_have_a_texel() {
    let border = Vec4::new(0.25, 0.5, 0.75, 1.0);
    let texture = noise(5, 3).with_border(border);
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::Bicubic(Cubic::B_SPLINE)] {
        let texture = texture.clone().with_filter(filter);
        let near = |a: Vec4, b: Vec4| assert!((a - b).abs().max_element() < 1e-6, "{a} {b}");
        for far in [1e9, -1e9, f32::INFINITY, f32::NEG_INFINITY] {
            let clear = texture.clone().with_wrap(Wrap::Border).sample(vec2(far, 0.5));
            near(clear, border);
            let edge = vec2(if far > 0.0 { 1.0 } else { 0.0 }, 0.5);
            let clamped = texture.clone().with_wrap(Wrap::Clamp);
            if far.is_finite() || filter == Filter::Nearest {
                near(clamped.sample(vec2(far, 0.5)), clamped.sample(edge + (edge - 0.5) * 2.0));
            }
        }
        for wrap in WRAPS {
            let texture = texture.clone().with_wrap(wrap);
            near(texture.sample(vec2(f32::NAN, 0.5)), texture.sample(vec2(0.0, 0.5)));
        }
        // 10^9 is a whole even number, and a float.
        for wrap in [Wrap::Repeat, Wrap::Mirror] {
            let texture = texture.clone().with_wrap(wrap);
            near(texture.sample(vec2(1e9, 0.3)), texture.sample(vec2(0.0, 0.3)));
        }
    }
}

// ------------------------------------------------------------------------------------- storage

/// IEC 61966-2-1.
fn light(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[test]
fn every_format_of_every_number_of_channels_is_decoded_exactly() {
    let bytes: Vec<u8> = (0..48).map(|i| (i * 37 + 11) as u8).collect();
    let words: Vec<u16> = (0..48).map(|i| (i * 7919 + 3) as u16).collect();
    // All finite: exponents below 31.
    let halves: Vec<u16> = words.iter().map(|word| word & 0xbbff).collect();
    let floats: Vec<f32> = words.iter().map(|&word| f32::from(word) / 777.0).collect();
    let half = |bits: u16| {
        let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 0x3ff));
        let size = if exponent == 0 {
            fraction / 1024.0 * 2.0_f64.powi(-14)
        } else {
            (1.0 + fraction / 1024.0) * 2.0_f64.powi(exponent - 15)
        };
        if bits >> 15 == 1 { -size } else { size }
    };
    for channels in 1..=4 {
        let (width, height) = (6, (48 / channels / 6) as u32);
        let count = (width * height) as usize * channels;
        let numbers = |list: Samples| -> Vec<f64> {
            match list {
                Samples::Srgb8(s) | Samples::Unorm8(s) => {
                    s.iter().map(|&s| f64::from(s) / 255.0).collect()
                }
                Samples::Srgb16(s) | Samples::Unorm16(s) => {
                    s.iter().map(|&s| f64::from(s) / 65_535.0).collect()
                }
                Samples::F16(s) => s.iter().map(|&s| half(s)).collect(),
                Samples::F32(s) => s.iter().map(|&s| f64::from(s)).collect(),
                _ => unreachable!("no other format"),
            }
        };
        for samples in [
            Samples::Srgb8(bytes[..count].to_vec()),
            Samples::Srgb16(words[..count].to_vec()),
            Samples::Unorm8(bytes[..count].to_vec()),
            Samples::Unorm16(words[..count].to_vec()),
            Samples::F16(halves[..count].to_vec()),
            Samples::F32(floats[..count].to_vec()),
        ] {
            let format = samples.format();
            let is_srgb = matches!(format, Format::Srgb8 | Format::Srgb16);
            let texture = Texture::from_samples(width, height, channels, samples.clone())
                .expect("as many samples as it takes");
            assert_eq!(texture.byte_len(), count * format.bytes());
            let numbers = numbers(samples);
            let exact = |x: u32, y: u32| {
                let n = &numbers[(y * width + x) as usize * channels..][..channels];
                let (rgb, alpha) = match *n {
                    [x] => ([x; 3], 1.0),
                    [x, alpha] => ([x; 3], alpha),
                    [r, g, b] => ([r, g, b], 1.0),
                    _ => ([n[0], n[1], n[2]], n[3]),
                };
                let [r, g, b] = if is_srgb { rgb.map(|c| light(c) * alpha) } else { rgb };
                [r, g, b, alpha]
            };
            for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                let (ours, exact) = (texture.texel(x, y), exact(x, y));
                for (ours, exact) in ours.to_array().into_iter().zip(exact) {
                    let error = (f64::from(ours) - exact).abs();
                    assert!(error <= exact.abs() * 1.3e-7, "{format:?}: {ours} for {exact}");
                }
            }
            // What is filtered is the same as of the decoded texels in f32.
            let plain = Texture::new(width, height, texture.texels().collect()).expect("texels");
            let mut random = Random(3);
            for filter in [Filter::Nearest, Filter::Bilinear, Filter::Bicubic(Cubic::MITCHELL)] {
                let uv = random.vec2(2.0);
                let ours = texture.clone().with_filter(filter).sample(uv);
                assert_eq!(ours, plain.clone().with_filter(filter).sample(uv), "{format:?}");
            }
        }
    }
}

#[test]
fn all_codes_of_srgb_are_exact_and_take_four_bytes() {
    let codes: Vec<u8> = (0..=255).flat_map(|code| [code, 255 - code, code, 255]).collect();
    let texture = Texture::from_samples(256, 1, 4, Samples::Srgb8(codes)).expect("256 texels");
    assert_eq!(texture.byte_len(), 4 * 256);
    for code in 0..=255_u8 {
        let light = Vec4::new(decode(code), decode(255 - code), decode(code), 1.0);
        assert_eq!(texture.texel(code.into(), 0), light);
        assert_eq!(texture.nearest(vec2((f32::from(code) + 0.5) / 256.0, 0.5)), light);
    }
    let chained = texture.with_mipmaps().expect("memory");
    assert_eq!(chained.byte_len(), 4 * 511);
}

// -------------------------------------------------------------------------------------- chains

/// The mean over [i n/m, (i+1) n/m) by [j l/k, (j+1) l/k) of a level, by the overlap with each texel.
fn area_mean(texture: &Texture, level: u32, (i, j): (u32, u32)) -> [f64; 4] {
    let ((n, l), (m, k)) = (texture.level_size(level), texture.level_size(level + 1));
    let overlap = |texel: u32, i: u32, n: u32, m: u32| {
        let (n, m) = (f64::from(n), f64::from(m));
        let (start, end) = (f64::from(i) * n / m, f64::from(i + 1) * n / m);
        ((f64::from(texel) + 1.0).min(end) - f64::from(texel).max(start)).max(0.0) * m / n
    };
    let mut sum = [0.0; 4];
    for (x, y) in (0..n).flat_map(|x| (0..l).map(move |y| (x, y))) {
        let weight = overlap(x, i, n, m) * overlap(y, j, l, k);
        for (sum, c) in sum.iter_mut().zip(texture.level_texel(level, x, y).to_array()) {
            *sum += f64::from(c) * weight;
        }
    }
    sum
}

#[test]
fn each_level_has_the_area_means_of_the_one_before() {
    for size in [(1, 1), (2, 2), (3, 3), (8, 8), (7, 5), (13, 1), (1, 6), (9, 4), (12, 11)] {
        let texture = noise(size.0, size.1).with_mipmaps().expect("memory");
        let mean = |level| {
            let (w, h) = texture.level_size(level);
            let texels = (0..w).flat_map(|x| (0..h).map(move |y| (x, y)));
            let sum: f64 = texels.map(|(x, y)| f64::from(texture.level_texel(level, x, y).y)).sum();
            sum / f64::from(w * h)
        };
        let mut expected = size;
        for level in 0..texture.level_count() {
            assert_eq!(texture.level_size(level), expected);
            expected = ((expected.0 / 2).max(1), (expected.1 / 2).max(1));
            assert!((mean(level) - mean(0)).abs() < 1e-6, "{size:?} {level}");
            if level > 0 {
                let (w, h) = texture.level_size(level);
                for (i, j) in (0..w).flat_map(|i| (0..h).map(move |j| (i, j))) {
                    let exact = area_mean(&texture, level - 1, (i, j));
                    let ours = texture.level_texel(level, i, j);
                    assert_near(ours, exact, 1e-6, &format!("{size:?}, level {level}"));
                }
            }
        }
        assert_eq!(texture.level_size(texture.level_count() - 1), (1, 1));
    }
}

#[test]
fn chains_of_srgb_are_means_of_light_and_alpha_weighs() {
    let grey = |codes: Vec<u8>, channels| {
        Texture::from_samples(2, 1, channels, Samples::Srgb8(codes))
            .and_then(Texture::with_mipmaps)
            .expect("two texels")
            .level_texel(1, 0, 0)
    };
    // Half the light of white is code 188, not 128.
    assert_eq!(grey(vec![0, 255], 1), Vec4::new(decode(188), decode(188), decode(188), 1.0));
    // A clear texel lends nothing of its green.
    let half = 128.0 / 255.0;
    let red = grey(vec![255, 0, 0, 255, 0, 255, 0, 0], 4);
    assert_eq!(red, Vec4::new(half, 0.0, 0.0, half));
    // Data are no colours.
    let data = Texture::from_samples(2, 1, 1, Samples::Unorm8(vec![0, 254])).expect("two texels");
    let mean = data.with_mipmaps().expect("memory").level_texel(1, 0, 0).x;
    assert_eq!(mean, 127.0 / 255.0);
}

// -------------------------------------------------------------------------------- minification

/// Stripes of 2^k texels, light and dark: levels up to k show them, the next is grey all over. So the
/// colour in the middle of a light texel of level k tells the level of detail between k and k + 1.
fn stripes(k: u32, size: u32) -> Texture {
    Texture::from_fn(size, size, |x, _| if x >> k & 1 == 0 { Vec4::ONE } else { Vec4::ZERO })
        .and_then(Texture::with_mipmaps)
        .expect("a small picture")
}

#[test]
fn the_level_of_detail_is_that_of_the_longer_side() {
    let mut random = Random(5);
    let mut checked = 0;
    let textures = [0, 1, 2, 3, 4].map(|k| {
        let texture = stripes(k, 256);
        (texture.clone(), texture.with_mip_filter(MipFilter::Nearest))
    });
    for _ in 0..4000 {
        let k = (random.next() * 5.0) as u32;
        let (texture, nearest) = &textures[k as usize];
        let (dx, dy) = (random.vec2(0.1), random.vec2(0.1));
        let length = |d: Vec2| (d.as_dvec2() * 256.0).length();
        let exact = length(dx).max(length(dy)).log2() - f64::from(k);
        if !(0.0..=1.0).contains(&exact) {
            continue;
        }
        checked += 1;
        let uv = vec2((1 << k) as f32 * 2.5 / 256.0, 0.5);
        let uv = vec2(uv.x - uv.x % ((2 << k) as f32 / 256.0) + (1 << k) as f32 * 0.5 / 256.0, 0.5);
        let ours = texture.sample_footprint(&Footprint { uv, dx, dy }).x;
        let found = 2.0 * (1.0 - f64::from(ours));
        assert!((found - exact).abs() < 4e-6, "{found} for {exact}: {dx} {dy}");
        // Half goes down.
        let ours = nearest.sample_footprint(&Footprint { uv, dx, dy }).x;
        if (exact - 0.5).abs() > 1e-5 {
            assert_eq!(ours, if exact < 0.5 { 1.0 } else { 0.5 }, "{exact}");
        }
    }
    assert!(checked > 300, "{checked}");
    let half = 2.0_f32.sqrt() / 256.0;
    for (dx, level_0) in [(half.next_down().next_down(), true), (half * 1.000_01, false)] {
        let texture = stripes(0, 256).with_mip_filter(MipFilter::Nearest);
        let footprint = Footprint { uv: vec2(0.5 / 256.0, 0.5), dx: vec2(dx, 0.0), dy: Vec2::ZERO };
        assert_eq!(texture.sample_footprint(&footprint).x == 1.0, level_0);
    }
}

#[test]
fn bias_and_range_move_the_level() {
    let uv = vec2(0.5 / 64.0, 0.5);
    let footprint = |texels: f32| Footprint { uv, dx: vec2(texels / 64.0, 0.0), dy: Vec2::ZERO };
    let texture = stripes(0, 64);
    assert_eq!(texture.sample_footprint(&footprint(1.0)).x, 1.0);
    assert_eq!(texture.clone().with_level_bias(0.5).sample_footprint(&footprint(1.0)).x, 0.75);
    assert_eq!(texture.clone().with_level_bias(-1.0).sample_footprint(&footprint(2.0)).x, 1.0);
    let within = texture.with_level_range(0.25, 0.75);
    assert_eq!(within.sample_footprint(&footprint(0.01)).x, 0.875);
    assert_eq!(within.sample_footprint(&footprint(64.0)).x, 0.625);
}

#[test]
fn trilinear_has_no_steps_between_levels() {
    let texture = noise(48, 20).with_mipmaps().expect("memory");
    let at = |scale: f32| {
        let (dx, dy) = (vec2(scale / 48.0, 0.0), vec2(0.0, scale / 20.0));
        texture.sample_footprint(&Footprint { uv: vec2(0.37, 0.61), dx, dy })
    };
    for level in 0..6 {
        let scale = 2.0_f32.powi(level);
        let jump = (at(scale * 1.000_01) - at(scale * 0.999_99)).abs().max_element();
        assert!(jump < 1e-4, "level {level}: {jump}");
    }
}

const FILTERS: [MipFilter; 8] = [
    MipFilter::Off,
    MipFilter::Nearest,
    MipFilter::Linear,
    MipFilter::Anisotropic { probes: 2 },
    MipFilter::Anisotropic { probes: 5 },
    MipFilter::Anisotropic { probes: 16 },
    MipFilter::Ewa { eccentricity: 8 },
    MipFilter::Ewa { eccentricity: 32 },
];

/// Footprints of all sizes and shapes.
fn footprints(count: usize) -> impl Iterator<Item = Footprint> {
    let mut random = Random(11);
    (0..count).map(move |_| {
        let size = 2.0_f32.powf(random.next() * 16.0 - 14.0);
        let long = 2.0_f32.powf(random.next() * 5.0);
        let uv = random.vec2(2.0);
        Footprint { uv, dx: random.vec2(size), dy: random.vec2(size * long) }
    })
}

#[test]
fn a_plain_picture_stays_plain_by_every_filter() {
    let plain = Vec4::new(0.1, 0.7, 0.333, 0.9);
    let texture = Texture::from_fn(37, 20, |_, _| plain).and_then(Texture::with_mipmaps);
    let texture = texture.expect("a small picture");
    for filter in FILTERS {
        let texture = texture.clone().with_mip_filter(filter);
        for footprint in footprints(300) {
            let ours = texture.sample_footprint(&footprint);
            assert!((ours - plain).abs().max_element() < 1e-6, "{filter:?} {footprint:?}: {ours}");
        }
    }
}

#[test]
fn a_ramp_stays_the_ramp() {
    let ramp = Texture::from_fn(256, 256, |x, y| Vec4::new(x as f32, y as f32, 0.0, 1.0) + 0.5)
        .and_then(Texture::with_mipmaps)
        .expect("a small picture")
        .with_wrap(Wrap::Clamp);
    let mut random = Random(23);
    for _ in 0..400 {
        // Far enough from the edges for all that is in the footprint, up to 16 texels long.
        let uv = vec2(0.5, 0.5) + random.vec2(0.2);
        let (dx, dy) = (random.vec2(0.004), random.vec2(0.02));
        // A Gaussian of few texels is no exact mean of a ramp.
        for filter in FILTERS.into_iter().filter(|f| !matches!(f, MipFilter::Ewa { .. })) {
            let texture = ramp.clone().with_mip_filter(filter);
            let ours = texture.sample_footprint(&Footprint { uv, dx, dy });
            let error = (vec2(ours.x, ours.y) / 256.0 - uv).abs().max_element() * 256.0;
            assert!(error < 3e-4, "{filter:?} {uv} {dx} {dy}: {error} texels");
        }
    }
}

/// The mean of the texels of a level in an ellipse, as Heckbert 1989 (section 3.5.9) defines it, in f64.
fn elliptical_mean(texture: &Texture, level: u32, footprint: &Footprint) -> DVec4 {
    let (width, height) = texture.level_size(level);
    let size = DVec2::new(width.into(), height.into());
    let [centre, dx, dy] = [footprint.uv, footprint.dx, footprint.dy].map(|v| v.as_dvec2() * size);
    let a = dx.y * dx.y + dy.y * dy.y + 1.0;
    let b = -2.0 * (dx.x * dx.y + dy.x * dy.y);
    let c = dx.x * dx.x + dy.x * dy.x + 1.0;
    let f = a * c - b * b / 4.0;
    let (mut sum, mut weights) = (DVec4::ZERO, 0.0);
    let near = |centre: f64, reach: f64| {
        (centre - reach).floor() as i32 - 1..=(centre + reach).ceil() as i32 + 1
    };
    for j in near(centre.y, a.sqrt()) {
        for i in near(centre.x, c.sqrt()) {
            let from = DVec2::new(i.into(), j.into()) + 0.5 - centre;
            let q = (a * from.x * from.x + b * from.x * from.y + c * from.y * from.y) / f;
            if q < 1.0 {
                let weight = (-2.0 * q).exp() - (-2.0_f64).exp();
                let [x, y] =
                    [(i, width), (j, height)].map(|(i, size)| i.rem_euclid(size as i32) as u32);
                sum += texture.level_texel(level, x, y).as_dvec4() * weight;
                weights += weight;
            }
        }
    }
    sum / weights
}

#[test]
fn ewa_is_the_weighted_mean_of_an_ellipse() {
    let texture = noise(64, 40).with_mipmaps().expect("memory");
    let texture = texture.with_mip_filter(MipFilter::Ewa { eccentricity: 64 });
    let mut random = Random(31);
    for level in [1, 2] {
        let texture = texture.clone().with_level_range(level as f32, level as f32);
        for _ in 0..300 {
            let (uv, dx) = (random.vec2(1.0), random.vec2(0.15));
            // Of an eccentricity below the limit.
            let dy = dx.perp() * (0.1 + 0.8 * random.next()) + dx * (random.next() - 0.5);
            let footprint = Footprint { uv, dx, dy };
            let ours = texture.sample_footprint(&footprint).as_dvec4();
            let error = (ours - elliptical_mean(&texture, level, &footprint)).abs().max_element();
            // A table of 1,024 steps gives weights to 2 / 1,024 of the largest; texels are at most 1.
            assert!(error < 2e-3, "{footprint:?}: {error}");
        }
    }
}

#[test]
fn of_a_round_footprint_probes_make_nothing_else() {
    let texture = noise(64, 64).with_mipmaps().expect("memory");
    let probes = texture.clone().with_mip_filter(MipFilter::Anisotropic { probes: 16 });
    let mut random = Random(2);
    for _ in 0..500 {
        let (uv, dx) = (random.vec2(2.0), random.vec2(0.2));
        let footprint = Footprint { uv, dx, dy: dx.perp() };
        let (ours, plain) =
            (probes.sample_footprint(&footprint), texture.sample_footprint(&footprint));
        assert_eq!(ours, plain, "{footprint:?}");
        // One side is longer by less than a thousandth; by more, it is two probes beside each other.
        let near = Footprint { dy: dx.perp() * 1.0008, ..footprint };
        assert_eq!(probes.sample_footprint(&near), texture.sample_footprint(&near), "{near:?}");
    }
}

#[test]
fn probes_lie_along_the_major_axis() {
    // Stripes along a slanted footprint keep their contrast; stripes across it lose it.
    let along = Texture::from_fn(256, 256, |x, y| Vec4::splat(((x + y) >> 3 & 1) as f32));
    let texture = along.and_then(Texture::with_mipmaps).expect("a small picture");
    let texture = texture.with_mip_filter(MipFilter::Anisotropic { probes: 16 });
    // The middle of a stripe of x + y.
    let uv = vec2(2.25, 2.25) / 256.0;
    let (long, short) = (vec2(12.0, -12.0) / 256.0, vec2(1.0, 1.0) / 256.0);
    // The same ellipse, by sides that are rolled by 30 degrees.
    for turn in [0.0_f32, 0.5, 1.0] {
        let dx = long * turn.cos() + short * turn.sin();
        let dy = short * turn.cos() - long * turn.sin();
        let kept = texture.sample_footprint(&Footprint { uv, dx, dy }).x;
        assert!(!(0.1..=0.9).contains(&kept), "{kept}");
        let flip = vec2(1.0, -1.0);
        let lost = texture.sample_footprint(&Footprint { uv, dx: dx * flip, dy: dy * flip }).x;
        assert!((0.3..=0.7).contains(&lost), "{lost}");
    }
}

#[test]
fn odd_footprints_have_a_colour() {
    let texture = noise(20, 9).with_mipmaps().expect("memory");
    let odd = [0.0, 1e-30, 1e9, 1e30, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    for filter in FILTERS {
        let texture = texture.clone().with_mip_filter(filter);
        for dx in odd {
            for dy in odd {
                for uv in [vec2(0.3, 0.4), vec2(f32::NAN, 1e9), vec2(f32::INFINITY, -7.0)] {
                    let footprint = Footprint { uv, dx: vec2(dx, 0.1), dy: vec2(-dy, dy) };
                    let ours = texture.sample_footprint(&footprint);
                    let inside =
                        ours.cmpge(Vec4::splat(-1e-6)) & ours.cmple(Vec4::splat(1.000_001));
                    assert!(inside.all(), "{filter:?} {footprint:?}: {ours}");
                }
            }
        }
    }
}

// -------------------------------------------------------------------------------------- blocks

/// Sixteen footprints side by side.
fn block_of(footprints: &[Footprint]) -> FootprintBlock {
    let mut block = FootprintBlock::default();
    for (lane, footprint) in footprints.iter().enumerate() {
        for axis in 0..2 {
            block.uv[axis][lane] = footprint.uv[axis];
            block.dx[axis][lane] = footprint.dx[axis];
            block.dy[axis][lane] = footprint.dy[axis];
        }
    }
    block
}

#[test]
fn blocks_have_the_bits_of_one_by_one() {
    let odd = [0.0, 1e-30, 1e9, f32::MAX, f32::INFINITY, f32::NAN];
    let odd = odd.into_iter().flat_map(|x| odd.map(|y| (x, y))).map(|(x, y)| Footprint {
        uv: vec2(y, 0.2),
        dx: vec2(x, 0.01),
        dy: vec2(0.02, -y),
    });
    let all: Vec<_> = footprints(460).chain(odd).collect();
    let bits = |color: Vec4| color.to_array().map(f32::to_bits);
    let mut random = Random(41);
    let codes: Vec<u8> = (0..4 * 33 * 17).map(|_| (random.next() * 255.9) as u8).collect();
    let opaque = codes.iter().enumerate().map(|(i, &c)| if i % 4 == 3 { 255 } else { c }).collect();
    for samples in [Samples::Srgb8(codes.clone()), Samples::Srgb8(opaque), Samples::Unorm8(codes)] {
        let texture = Texture::from_samples(33, 17, 4, samples).and_then(Texture::with_mipmaps);
        let texture = texture.expect("a small picture").with_border(Vec4::new(0.1, 0.2, 0.3, 0.5));
        let plain = Texture::new(33, 17, texture.texels().collect()).expect("a small picture");
        for texture in [texture, plain.with_mipmaps().expect("memory")] {
            for (wrap, filter) in WRAPS.into_iter().flat_map(|wrap| FILTERS.map(|f| (wrap, f))) {
                for magnifier in
                    [Filter::Bilinear, Filter::Nearest, Filter::Bicubic(Cubic::CATMULL_ROM)]
                {
                    let texture = texture.clone().with_wraps(wrap, Wrap::Repeat);
                    let texture = texture.with_mip_filter(filter).with_filter(magnifier);
                    check_blocks(&texture, &all, bits);
                }
            }
        }
    }
}

fn check_blocks(texture: &Texture, all: &[Footprint], bits: impl Fn(Vec4) -> [u32; 4]) {
    for level in [Level::baseline(), Level::new()] {
        let texture = texture.clone().with_simd_level(level);
        for (i, footprints) in all.chunks_exact(16).enumerate() {
            let (block, mask) = (block_of(footprints), [0xffff, 0x5a3c, 0x8001][i % 3]);
            let ours = texture.sample_footprint_block(&block, mask);
            let points = texture.sample_block(&block.uv, mask);
            let pixels = texture.srgb8_block(&block, mask);
            for (lane, footprint) in footprints.iter().enumerate() {
                let is_visible = mask >> lane & 1 != 0;
                let color = |color: Vec4| if is_visible { color } else { Vec4::ZERO };
                let alone = color(texture.sample_footprint(footprint));
                assert_eq!(bits(ours[lane]), bits(alone), "{texture:?} {footprint:?}");
                if is_visible {
                    assert_eq!(pixels[lane], alone.to_srgb8(), "{texture:?} {footprint:?}");
                }
                let alone = color(texture.sample(footprint.uv));
                assert_eq!(bits(points[lane]), bits(alone), "{texture:?} {footprint:?}");
            }
        }
    }
}

#[test]
fn paints_are_what_samples_are() {
    let smooth = noise(33, 17).with_mipmaps().expect("memory");
    let board = |x: u32, y: u32| if (x + y).is_multiple_of(2) { Vec4::ONE } else { Vec4::W };
    let sharp = Texture::from_fn(8, 8, board).expect("a small picture");
    let textures = [smooth, sharp.with_filter(Filter::Nearest)];
    let mut random = Random(7);
    // A quad that fills the picture, and many triangles of some pixels before it.
    let mut vertex = |size: f32, at: Vec2, z: f32| {
        let (at, w) = (at + random.vec2(size), 1.0 + random.next());
        Vertex::new(Vec4::new(at.x * w, at.y * w, z * w, w), random.vec2(3.0))
    };
    let corners = [vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0)];
    let mut vertices: Vec<_> = corners.map(|at| vertex(0.0, at, 0.9)).into();
    let mut faces = vec![vec![0, 1, 2, 3]];
    for i in 0..400_u32 {
        let at = vec2(i as f32 / 200.0 - 1.0, (i * 7 % 400) as f32 / 200.0 - 1.0);
        vertices.extend([(); 3].map(|()| vertex(0.15, at, 0.5)));
        faces.push((vertices.len() as u32 - 3..vertices.len() as u32).collect());
    }
    let mesh = Mesh::new(&vertices, &faces);
    let texture = |fragment: &Fragment<'_, 2>| &textures[fragment.face as usize % 2];

    macro_rules! compare {
        ($clear:expr, $color:expr) => {
            let mut by_paints = Framebuffer::new(150, 90, $clear).expect("a small size");
            let mut by_samples = by_paints.clone();
            let mut renderer = ZBufferRenderer::new(by_paints.viewport());
            renderer.draw(&mut by_paints, mesh, dynamic(|f| texture(f).paint(f.footprint(0, 1))));
            renderer.draw(
                &mut by_samples,
                mesh,
                dynamic(|f| $color(texture(f).sample_footprint(&f.footprint(0, 1)))),
            );
            assert!(by_paints.color().iter().any(|color| *color != by_paints.color()[0]));
            assert_eq!(by_paints.color(), by_samples.color());
            assert_eq!(by_paints.depth(), by_samples.depth());
        };
    }
    compare!([0; 4], Vec4::to_srgb8);
    compare!(Vec4::ZERO, |color: Vec4| color);
    compare!(Vec3::ZERO, Vec4::truncate);
}

// --------------------------------------------------------------------------------- derivatives

#[test]
fn derivatives_are_exact_and_alike_in_blocks_and_alone() {
    let mut random = Random(99);
    let viewport = Viewport::new(3000, 64).expect("a size within the limits");
    let mut compared = 0;
    for round in 0..60 {
        let ratio = [1.0, 2.0, 30.0, 1000.0][round % 4];
        let triangle = [(-1.5, -1.4), (1.3, -1.2), (0.1, 1.7)].map(|(x, y)| {
            let w = 1.0 + (ratio - 1.0) * random.next();
            let at = vec2(x, y) + random.vec2(0.3);
            let position = Vec4::new(at.x * w, at.y * w, 0.5 * w, w);
            Vertex::new(position, [random.next(), random.next() * 10.0])
        });
        let exact = ParameterMatrix::new(&triangle, &viewport).expect("it is not edge-on");
        let mut scan = ScanConverter::new(viewport);
        for span in scan.spans(&triangle) {
            for level in [Level::baseline(), Level::new()] {
                span.for_each_block(level, |block| {
                    let footprint = block.footprint(0, 1);
                    for lane in (0..16).filter(|lane| block.visible >> lane & 1 != 0) {
                        let fragment = block.fragment(lane);
                        assert_eq!(footprint.get(lane), fragment.footprint(0, 1));
                        let (dx, dy) = fragment.derivatives();
                        let (x, y) = (f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5);
                        let (exact_dx, exact_dy) = exact.derivatives_at(x, y);
                        for i in 0..2 {
                            let larger = DVec2::new(exact_dx[i], exact_dy[i]).abs().max_element();
                            let ours = DVec2::new(dx[i].into(), dy[i].into());
                            let error = ours - DVec2::new(exact_dx[i], exact_dy[i]);
                            let error = error.abs().max_element() / larger;
                            assert!(error < 1e-5, "{error:e} at {x}, {y} of {triangle:?}");
                            compared += 1;
                        }
                    }
                });
            }
        }
    }
    assert!(compared > 100_000, "{compared}");
}
