//! A contact sheet of checkered quads, turned every way and seen in perspective.
//!
//! The upper half of the sheet interpolates (u, v) linearly on the screen: the checkers bend like
//! rubber. The lower half shows the same quads with rational linear interpolation: straight lines
//! stay straight. These are the pictures of Heckbert and Moreton's paper.

use std::path::PathBuf;

use clap::Parser;
use glam::camera::rh::proj::directx::perspective;
use glam::{EulerRot, Mat4, Vec2, Vec3, vec2, vec3};
use polyscan::{Framebuffer, Interpolation, Vertex, Viewport, ZBuffer};

/// Draw checkered quads in perspective: linear interpolation above, rational linear below.
#[derive(Parser)]
struct Options {
    /// The picture to write; its name's ending chooses the format.
    #[arg(long, default_value = "target/quads.png")]
    output: PathBuf,
    /// Width and height of one quad's tile, in pixels.
    #[arg(long, default_value_t = 160, value_parser = clap::value_parser!(u32).range(8..=4096))]
    size: u32,
    /// One quad's rotation in degrees; give it several times for several quads.
    #[arg(long, value_name = "YAW,PITCH,ROLL", value_parser = parse_angles, allow_hyphen_values = true)]
    angles: Vec<Vec3>,
    /// Draw the first quad alone, four times as large.
    #[arg(long)]
    one: bool,
}

fn parse_angles(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[yaw, pitch, roll]) => Ok(vec3(yaw, pitch, roll)),
        _ => Err("give three numbers of degrees, such as 40,-20,10".into()),
    }
}

/// Yaw to the right, pitch and roll downwards: six by three ways to turn a quad.
fn all_around() -> Vec<Vec3> {
    let rows = [(0.0, 0.0), (50.0, 20.0), (-35.0, 70.0)];
    let yaws = [-75.0, -50.0, -25.0, 25.0, 50.0, 75.0];
    rows.iter().flat_map(|&(pitch, roll)| yaws.map(|yaw| vec3(yaw, pitch, roll))).collect()
}

/// The camera stands this far from the quad's centre; the quad reaches from -1 to 1.
const DISTANCE: f32 = 2.6;
/// The field of view in radians, a little more than the sphere of radius √2 around the quad takes:
/// 2 asin(√2 / 2.6) = 1.15.
const FIELD_OF_VIEW: f32 = 1.2;
/// Each pixel is the mean of this many samples in x and in y.
const SAMPLES: u32 = 4;
const PAPER: Vec3 = vec3(0.9, 0.89, 0.86);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut options = Options::parse();
    if options.angles.is_empty() {
        options.angles = if options.one { vec![vec3(55.0, 25.0, 15.0)] } else { all_around() };
    }
    if options.one {
        options.angles.truncate(1);
        options.size = (options.size * 4).min(4096);
    }

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
            let viewport = Viewport::new(tile, tile)?.at(x as i32, y as i32);
            draw_quad(&mut frame, viewport, angles, *interpolation);
        }
    }

    let picture = frame.reduced(SAMPLES)?;
    if let Some(folder) = options.output.parent() {
        std::fs::create_dir_all(folder)?;
    }
    picture.to_image().save(&options.output)?;
    println!(
        "{} quads, linear interpolation above, rational linear below: {}",
        options.angles.len(),
        options.output.display()
    );
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

    let mut renderer = ZBuffer::new(viewport);
    renderer.scan.scissor = Some(viewport.rect());
    renderer.scan.interpolation = [interpolation; 2];
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
