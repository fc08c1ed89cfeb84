//! A renderer of one's own on the scan converter's fragments: a UV baker.
//!
//! The polygon is scan-converted not where it is seen but where it lies in its texture, so each
//! fragment is a texel. Here its world-space position goes from the corners to the texels and is
//! lit by a lamp: a lightmap of a room's floor.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use glam::{Vec2, Vec3, vec2, vec3};
use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::{Framebuffer, ScanConverter, Vertex, Viewport, record};

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
fn unwrapped(uv: Vec2, position: Vec3) -> Vertex<3> {
    let clip = vec2(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
    Vertex::new(clip.extend(0.0).extend(1.0), Point { position })
}

/// Light from a small lamp on a floor that looks up, at a distance, not behind the pillar.
fn lamp_light(position: Vec3) -> Vec3 {
    const LAMP: Vec3 = vec3(1.2, 1.5, -0.8);
    const PILLAR: (Vec2, f32) = (vec2(0.1, 0.0), 0.3);
    let to_lamp = LAMP - position;
    let along = vec2(to_lamp.x, to_lamp.z);
    let pillar = PILLAR.0 - vec2(position.x, position.z);
    let nearest = (pillar.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    if (pillar - along * nearest).length() < PILLAR.1 {
        return Vec3::splat(0.02);
    }
    vec3(1.0, 0.85, 0.6) * (to_lamp.y / to_lamp.length().powi(3)) * 1.5
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
    let mut scan = ScanConverter::new(Viewport::new(size, size)?);
    for span in scan.spans(&floor) {
        let row = span.y() as usize * size as usize;
        for fragment in span.fragments() {
            let Point { position } = fragment.params.into();
            lightmap.color_mut()[row + fragment.x as usize] = lamp_light(position);
        }
    }

    cli::make_folder_of(&output)?;
    lightmap.save_png(&output)?;
    println!("baked a lightmap: {}", output.display());
    Ok(())
}
