//! A contact sheet of checkered quads, turned every way and seen in perspective.
//!
//! The upper half of the sheet interpolates (u, v) linearly on the screen: the checkers bend like
//! rubber. The lower half shows the same quads with rational linear interpolation: straight lines
//! stay straight. These are the pictures of Heckbert and Moreton's paper.
//!
//! ```text
//! cargo run --release --example quads
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::glam::camera::rh::proj::directx::perspective;
use polyscan::glam::{EulerRot, Mat4, Vec2, Vec3, vec2, vec3};
use polyscan::{Framebuffer, Interpolation, Vertex, Viewport, ZBufferRenderer};

mod cli;

const HELP: &str = "\
Draw checkered quads in perspective: linear interpolation above, rational linear below.

Usage: quads [OPTIONS]

Options:
      --output <FILE>            The PNG file to write [default: target/quads.png]
      --size <PIXELS>            Width and height of one quad's tile, from 8 to 4096 [default: 160]
      --angles <YAW,PITCH,ROLL>  One quad's rotation in degrees; give it several times for several
                                 quads [default: eighteen ways to turn a quad]
      --one                      Draw the first quad alone, four times as large
  -h, --help                     Show this help
";

/// The camera stands this far from the quad's centre; the quad reaches from -1 to 1.
const DISTANCE: f32 = 2.6;
/// The field of view in radians, a little more than the sphere of radius √2 around the quad takes:
/// 2 asin(√2 / 2.6) = 1.15.
const FIELD_OF_VIEW: f32 = 1.2;
/// Each pixel is the mean of this many samples in x and in y.
const SAMPLES: u32 = 4;
const PAPER: Vec3 = vec3(0.9, 0.89, 0.86);

fn main() -> ExitCode {
    cli::run(draw_sheet)
}

fn draw_sheet() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let columns = options.angles.len().min(6) as u32;
    let rows = options.angles.len().div_ceil(6) as u32;
    let tile = options.size * SAMPLES;
    let mut frame = Framebuffer::new(columns * tile, 2 * rows * tile, PAPER)?;
    for (half, interpolation) in
        [Interpolation::Linear, Interpolation::Perspective].iter().enumerate()
    {
        for (i, &angles) in (0..).zip(&options.angles) {
            let x = i % 6 * tile;
            let y = (half as u32 * rows + i / 6) * tile;
            let viewport = Viewport::new(tile, tile)?.with_corner(x as i32, y as i32);
            draw_quad(&mut frame, viewport, angles, *interpolation);
        }
    }

    cli::make_folder_of(&options.output)?;
    frame.downsampled(SAMPLES)?.save_png(&options.output)?;
    let quads = match options.angles.len() {
        1 => "1 quad".to_owned(),
        count => format!("{count} quads"),
    };
    let output = options.output.display();
    println!("{quads}, linear interpolation above, rational linear below: {output}");
    Ok(())
}

fn draw_quad(
    frame: &mut Framebuffer<Vec3>,
    viewport: Viewport,
    angles: Vec3,
    interpolation: Interpolation,
) {
    let [yaw, pitch, roll] = angles.to_array().map(f32::to_radians);
    let camera = perspective(FIELD_OF_VIEW, 1.0, 0.1, 10.0)
        * Mat4::from_translation(vec3(0.0, 0.0, -DISTANCE))
        * Mat4::from_euler(EulerRot::YXZ, yaw, pitch, roll);
    let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
        Vertex::new(camera * vec3(x, y, 0.0).extend(1.0), vec2(x + 1.0, 1.0 - y) / 2.0)
    });

    let mut renderer = ZBufferRenderer::new(viewport);
    renderer.settings.scissor = Some(viewport.rect());
    renderer.settings.interpolation = [interpolation; 2];
    renderer.draw(frame, &quad, |fragment| checker(fragment.params.into()));
}

/// Eight by eight squares, with a mark in the corner where u and v are 0.
fn checker(uv: Vec2) -> Vec3 {
    let square = (uv * 8.0).floor().clamp(Vec2::ZERO, Vec2::splat(7.0));
    if square.max_element() < 1.0 {
        vec3(0.8, 0.1, 0.05)
    } else if (square.x + square.y) % 2.0 == 0.0 {
        vec3(0.02, 0.05, 0.15)
    } else {
        vec3(0.95, 0.75, 0.35)
    }
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    output: PathBuf,
    /// Width and height of one quad's tile, in pixels.
    size: u32,
    /// Yaw, pitch and roll of each quad, in degrees.
    angles: Vec<Vec3>,
    one: bool,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let output = PathBuf::from("target/quads.png");
        let mut options = Self { output, size: 160, angles: Vec::new(), one: false };
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Long("output") => options.output = cli::png(parser.value()?)?,
                Arg::Long("size") => {
                    options.size =
                        parser.value()?.parse_with(|text| cli::number(text, 8..=4096))?;
                }
                Arg::Long("angles") => {
                    options.angles.push(parser.value()?.parse_with(parse_angles)?);
                }
                Arg::Long("one") => options.one = true,
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                _ => return Err(arg.unexpected().into()),
            }
        }
        if options.angles.is_empty() {
            options.angles = if options.one { vec![vec3(55.0, 25.0, 15.0)] } else { all_around() };
        }
        if options.one {
            options.angles.truncate(1);
            options.size = (options.size * 4).min(4096);
        }
        Ok(options)
    }
}

fn parse_angles(text: &str) -> Result<Vec3, &'static str> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[yaw, pitch, roll]) => Ok(vec3(yaw, pitch, roll)),
        _ => Err("give three numbers of degrees, such as 40,-20,10"),
    }
}

/// Yaw to the right, pitch and roll downwards: six by three ways to turn a quad.
fn all_around() -> Vec<Vec3> {
    let rows = [(0.0, 0.0), (50.0, 20.0), (-35.0, 70.0)];
    let yaws = [-75.0, -50.0, -25.0, 25.0, 50.0, 75.0];
    rows.iter().flat_map(|&(pitch, roll)| yaws.map(|yaw| vec3(yaw, pitch, roll))).collect()
}
