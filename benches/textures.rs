//! What sampling costs: the README's shader, and others, on a quad that fills most of 1920 x 1080
//! pixels, beside a raw table of 512 x 512 texels that is looked up without a `Texture`.
//!
//! ```text
//! cargo bench -p polyscan-benches --bench textures -- raw bilinear
//! ```
//!
//! Prints the fastest and the median frame of each way, in milliseconds, drawn in turns for `PB_ROUNDS`
//! rounds (15 if not set). Arguments choose the ways whose names contain them.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Vec2, Vec3, Vec4, vec2, vec3};
use polyscan::color::Color;
use polyscan::fragment::LANES;
use polyscan::texture::{Filter, MipFilter, Samples, Texture};
use polyscan::{
    Footprint, FootprintBlock, Fragment, FragmentBlock, Framebuffer, Vertex, ZBufferRenderer,
};

type Frame = Framebuffer<[u8; 4]>;

fn quad() -> [Vertex<2>; 4] {
    let camera = perspective(0.7, 16.0 / 9.0, 0.1, 100.0)
        * look_at_mat4(vec3(0.6, 0.9, 2.4), Vec3::ZERO, Vec3::Y);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
        let position = camera * vec3(1.9 * x, 1.1 * y, 0.0).extend(1.0);
        Vertex::new(position, vec2(x + 1.0, 1.0 - y) * 4.0)
    })
}

/// Where in a table of 512 x 512, repeated, a texel is.
fn texel([u, v]: [f32; 2]) -> usize {
    let texel = |c: f32| (c * 512.0 - 0.499_97 + 12_582_912.0).to_bits() & 511;
    (texel(v) << 9 | texel(u)) as usize
}

fn noise(x: u32, y: u32) -> [u8; 4] {
    let bits =
        (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(2_246_822_519)).wrapping_mul(3_266_489_917);
    let [r, g, b, _] = bits.to_be_bytes();
    [r, g, b, 255]
}

struct Way<'a> {
    name: &'static str,
    draw: Box<dyn FnMut(&mut Frame) + 'a>,
    times: Vec<f64>,
}

fn per_fragment<'a>(
    name: &'static str,
    shader: impl Fn(&Fragment<'_, 2>) -> [u8; 4] + Sync + 'a,
) -> Way<'a> {
    let (mut renderer, quad) = (None, quad());
    let draw = move |frame: &mut Frame| {
        let renderer = renderer.get_or_insert_with(|| ZBufferRenderer::new(frame.viewport()));
        renderer.draw(frame, &quad, &shader);
    };
    Way { name, draw: Box::new(draw), times: Vec::new() }
}

/// By a texture's paint.
fn paint<'a>(
    name: &'static str,
    texture: &'a Texture,
    footprint: impl Fn(&Fragment<'_, 2>) -> Footprint + Sync + 'a,
) -> Way<'a> {
    let (mut renderer, quad) = (None, quad());
    let draw = move |frame: &mut Frame| {
        let renderer = renderer.get_or_insert_with(|| ZBufferRenderer::new(frame.viewport()));
        renderer.draw(frame, &quad, |fragment| texture.paint(footprint(fragment)));
    };
    Way { name, draw: Box::new(draw), times: Vec::new() }
}

fn in_blocks<'a>(
    name: &'static str,
    quad: [Vertex<2>; 4],
    shader: impl Fn(&FragmentBlock<'_, 2>, &mut [[u8; 4]; LANES]) + Sync + 'a,
) -> Way<'a> {
    let mut renderer = None;
    let draw = move |frame: &mut Frame| {
        let renderer = renderer.get_or_insert_with(|| ZBufferRenderer::new(frame.viewport()));
        renderer.draw_blocks(frame, &quad, |block, colors| shader(block, colors));
    };
    Way { name, draw: Box::new(draw), times: Vec::new() }
}

/// By a texture's block of footprints.
fn footprints<'a>(name: &'static str, quad: [Vertex<2>; 4], texture: &'a Texture) -> Way<'a> {
    in_blocks(name, quad, |block, colors| {
        *colors = texture.srgb8_block(&block.footprint(0, 1), block.visible);
    })
}

/// By a texture's block of points.
fn points<'a>(name: &'static str, texture: &'a Texture) -> Way<'a> {
    in_blocks(name, quad(), |block, colors| {
        let of = FootprintBlock { uv: block.params, ..FootprintBlock::default() };
        *colors = texture.srgb8_block(&of, block.visible);
    })
}

/// A plane that fills the picture, seen face on or tilted, about a texel a pixel in its middle.
fn plane(tilt: f32) -> [Vertex<2>; 4] {
    let camera = perspective(0.7, 16.0 / 9.0, 0.1, 100.0)
        * Mat4::from_translation(vec3(0.0, 0.0, -2.0))
        * Mat4::from_rotation_x(-tilt.to_radians());
    [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)]
        .map(|(x, y)| Vertex::new(camera * vec3(x, y, 0.0).extend(1.0), vec2(x, -y) * 1.4))
}

fn main() -> Result<(), Box<dyn Error>> {
    let table: Vec<[u8; 4]> = (0..1 << 18).map(|i| noise(i & 511, i >> 9)).collect();
    let table: &[[u8; 4]; 1 << 18] = table.first_chunk().ok_or("the table is too small")?;
    let bytes = Samples::Srgb8(table.as_flattened().to_vec());
    let texture = Texture::from_samples(512, 512, 4, bytes)?;
    let nearest = texture.clone().with_filter(Filter::Nearest);
    let mipped = texture.clone().with_mipmaps()?;
    let probes = mipped.clone().with_mip_filter(MipFilter::Anisotropic { probes: 16 });
    let ewa = mipped.clone().with_mip_filter(MipFilter::Ewa { eccentricity: 16 });
    let sizes = [64, 256, 1024, 4096].map(|size| {
        let texel = |x, y| {
            let [r, g, b, _] = noise(x, y).map(f32::from);
            Vec4::new(r, g, b, 255.0) / 255.0
        };
        Texture::from_fn(size, size, texel).and_then(Texture::with_mipmaps)
    });
    let [small, medium, large, huge] = sizes;
    let (small, medium, large, huge) = (small?, medium?, large?, huge?);
    let mut ways = vec![
        per_fragment("raw table", |f| table[texel(f.params) & 0x3_ffff]),
        per_fragment("to_srgb8 alone", |f| {
            let [u, v] = f.params;
            Vec4::new(u.fract(), v.fract(), 0.5, 1.0).to_srgb8()
        }),
        per_fragment("nearest.sample.to_srgb8", |f| {
            nearest.sample(Vec2::from(f.params)).to_srgb8()
        }),
        per_fragment("sample.to_srgb8 (README)", |f| {
            texture.sample(Vec2::from(f.params)).to_srgb8()
        }),
        paint("paint, nearest", &nearest, |f| f.params.into()),
        paint("paint, bilinear (README)", &texture, |f| f.params.into()),
        paint("paint, trilinear", &mipped, |f| f.footprint(0, 1)),
        per_fragment("trilinear", |f| mipped.sample_footprint(&f.footprint(0, 1)).to_srgb8()),
        in_blocks("raw table, blocks", quad(), |block, colors| {
            let [u, v] = &block.params;
            let mut texels = [0; LANES];
            for (i, at) in texels.iter_mut().enumerate() {
                *at = texel([u[i], v[i]]);
            }
            for (color, at) in colors.iter_mut().zip(texels) {
                *color = table[at & 0x3_ffff];
            }
        }),
        points("nearest, blocks", &nearest),
        points("bilinear, blocks", &texture),
        footprints("trilinear, blocks", quad(), &mipped),
        footprints("plane face on: trilinear", plane(0.0), &mipped),
        footprints("plane face on: 16 probes", plane(0.0), &probes),
        footprints("plane at 80 degrees: trilinear", plane(80.0), &mipped),
        footprints("plane at 80 degrees: 16 probes", plane(80.0), &probes),
        footprints("plane at 80 degrees: EWA", plane(80.0), &ewa),
        footprints("size 64: trilinear", plane(60.0), &small),
        footprints("size 256: trilinear", plane(60.0), &medium),
        footprints("size 1024: trilinear", plane(60.0), &large),
        footprints("size 4096: trilinear", plane(60.0), &huge),
    ];
    let wanted: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    ways.retain(|way| wanted.is_empty() || wanted.iter().any(|w| way.name.contains(w.as_str())));
    let rounds = std::env::var("PB_ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(15);
    let mut frame = Framebuffer::new(1920, 1080, [0u8; 4])?;
    for _ in 0..rounds {
        for way in &mut ways {
            frame.clear([0; 4], 1.0);
            let start = Instant::now();
            (way.draw)(&mut frame);
            way.times.push(start.elapsed().as_secs_f64() * 1e3);
            black_box(&frame);
        }
    }
    for Way { name, times, .. } in &mut ways {
        times.sort_by(f64::total_cmp);
        println!("{name:32} fastest {:6.2}  median {:6.2}", times[0], times[times.len() / 2]);
    }
    if wanted.is_empty() || wanted.iter().any(|w| w == "chain") { time_chain() } else { Ok(()) }
}

/// The chain of a picture of 4096 x 4096 against a copy of its texels.
fn time_chain() -> Result<(), Box<dyn Error>> {
    let bytes: Vec<u8> = (0..1 << 24).flat_map(|i| noise(i & 4095, i >> 12)).collect();
    let mut fastest = [f64::INFINITY; 2];
    for _ in 0..3 {
        let start = Instant::now();
        let copy = black_box(&bytes).clone();
        fastest[0] = fastest[0].min(start.elapsed().as_secs_f64() * 1e3);
        let texture = Texture::from_samples(4096, 4096, 4, Samples::Srgb8(copy))?;
        let start = Instant::now();
        black_box(texture.with_mipmaps()?);
        fastest[1] = fastest[1].min(start.elapsed().as_secs_f64() * 1e3);
    }
    println!("4096 x 4096: copy {:.1}, chain {:.1}", fastest[0], fastest[1]);
    Ok(())
}
