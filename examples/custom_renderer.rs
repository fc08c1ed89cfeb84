//! A renderer of one's own on the scan converter's spans: a UV baker.
//!
//! The polygon is scan-converted not where it is seen but where it lies in its texture, so each
//! fragment is a texel. Here its world-space position goes from the corners to the texels and is
//! lit by a lamp: a lightmap of a room's floor. Texels come in blocks of sixteen, and the loop over
//! them becomes SIMD instructions.
//!
//! ```text
//! cargo run --release --example custom_renderer
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::fragment::LANES;
use polyscan::glam::{Vec2, Vec3, vec2, vec3};
use polyscan::{Framebuffer, Level, ScanConverter, Vertex, record};

mod cli;

const HELP: &str = "\
Bake a lightmap: a floor's texels, each lit where it lies in the room.

Usage: custom_renderer [OPTIONS]

Options:
      --output <FILE>  The PNG file to write [default: target/custom_renderer.png]
      --size <PIXELS>  Width and height of the lightmap, from 1 to 8192 [default: 512]
  -h, --help           Show this help
";

record! {
    /// What the baker needs to know of a texel.
    struct Point {
        position: Vec3,
    }
}

/// From texture coordinates (v down) to clip space: the texture fills the viewport.
fn unwrapped(uv: Vec2, position: Vec3) -> Vertex<{ Point::LEN }> {
    let clip = vec2(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
    Vertex::new(clip.extend(0.0).extend(1.0), Point { position })
}

/// Light from a small lamp on a floor that looks up, at a distance, not behind the pillar. It is
/// inlined and takes no branch, so that it becomes SIMD with the loop around it.
#[inline(always)]
fn lamp_light(position: Vec3) -> Vec3 {
    const LAMP: Vec3 = vec3(1.2, 1.5, -0.8);
    const PILLAR: (Vec2, f32) = (vec2(0.1, 0.0), 0.3);
    let to_lamp = LAMP - position;
    let along = vec2(to_lamp.x, to_lamp.z);
    let pillar = PILLAR.0 - vec2(position.x, position.z);
    let nearest = (pillar.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let is_shadow = (pillar - along * nearest).length_squared() < PILLAR.1 * PILLAR.1;
    let distance = to_lamp.length();
    let light = 1.5 * to_lamp.y / (distance * distance * distance);
    if is_shadow { Vec3::splat(0.02) } else { vec3(1.0, 0.85, 0.6) * light }
}

fn main() -> ExitCode {
    cli::run(bake)
}

fn bake() -> Result<(), Box<dyn Error>> {
    let (mut output, mut size) = (PathBuf::from("target/custom_renderer.png"), 512);
    let mut parser = Parser::from_env();
    while let Some(arg) = parser.next()? {
        match arg {
            Arg::Long("output") => output = cli::png(parser.value()?)?,
            Arg::Long("size") => {
                size = parser.value()?.parse_with(|text| cli::number(text, 1..=8192))?;
            }
            Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
            _ => return Err(arg.unexpected().into()),
        }
    }

    let floor = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .map(|(u, v)| unwrapped(vec2(u, v), vec3(4.0 * u - 2.0, 0.0, 4.0 * v - 2.0)));
    let mut lightmap = Framebuffer::new(size, size, Vec3::ZERO)?;

    let start = Instant::now();
    let mut scan = ScanConverter::new(lightmap.viewport());
    let (texels, level) = (lightmap.color_mut(), Level::new());
    for span in scan.spans(&floor) {
        // Only what is inlined is compiled for the level's instructions, so the closure must be.
        span.for_each_block(
            level,
            #[inline(always)]
            |block| {
                let [x, y, z] = &block.params;
                let mut light = [Vec3::ZERO; LANES];
                for (lane, light) in light.iter_mut().enumerate() {
                    *light = lamp_light(vec3(x[lane], y[lane], z[lane]));
                }
                // The last block of a span may reach beyond its end.
                let (column, row) = block.position(0);
                let first = row as usize * size as usize + column as usize;
                let count = block.visible.count_ones() as usize;
                texels[first..first + count].copy_from_slice(&light[..count]);
            },
        );
    }
    let seconds = start.elapsed().as_secs_f64();

    cli::make_folder_of(&output)?;
    lightmap.save_png(&output)?;
    println!("baked a lightmap of {size} x {size} texels: {}", output.display());
    let rate = f64::from(size) * f64::from(size) / seconds / 1e6;
    println!("{:.2} ms, {rate:.0} million texels a second", seconds * 1e3);
    Ok(())
}
