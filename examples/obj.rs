//! Renders an OBJ model: framed by itself, with one light, through the z-buffer.

use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};

use clap::Parser;
use glam::Vec3;
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, DynamicImage, Frame, RgbaImage};
use indicatif::{ProgressBar, ProgressIterator, ProgressStyle};
use polyscan::obj::{Loader, Model};
use polyscan::{Cull, Framebuffer, Vertex, ZBuffer};

mod studio;

use studio::{Camera, Surface, View, color_of, parse_size, sphere_around};

/// Draw an OBJ model to a picture, or turn it around in a series of pictures.
#[derive(Parser)]
struct Options {
    #[command(flatten)]
    view: View,
    /// The picture to write; its name's ending chooses the format. With --turntable: an animated
    /// .gif, or a series with numbers before the ending.
    #[arg(long, default_value = "target/obj.png")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "800x600", value_parser = parse_size::<16384>)]
    size: (u32, u32),
    /// Leave out faces that are seen from behind.
    #[arg(long)]
    cull: bool,
    /// Background colour, sRGB in hexadecimal.
    #[arg(long, default_value = "d8e2ea", value_parser = parse_color)]
    background: [u8; 3],
    /// Computed normals are smooth where faces meet at less than this many degrees.
    #[arg(long, default_value_t = 60.0)]
    crease: f32,
    /// The number of pictures of a full turn; instead of one picture.
    #[arg(long, value_name = "PICTURES", value_parser = clap::value_parser!(u16).range(1..=999))]
    turntable: Option<u16>,
}

fn parse_color(text: &str) -> Result<[u8; 3], String> {
    let number = u32::from_str_radix(text, 16).ok().filter(|_| text.len() == 6);
    let [_, r, g, b] = number.ok_or("write it as six digits, such as ffcc00")?.to_be_bytes();
    Ok([r, g, b])
}

/// Each pixel is the mean of this many samples in x and in y.
const SAMPLES: u32 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let loader = Loader::new().with_crease_angle(options.crease.to_radians());
    let model = studio::load(&loader, &options.view.model)?;
    println!(
        "{}: {} faces, {} vertices, {} materials, {} textures",
        options.view.model.display(),
        model.faces().count(),
        model.vertices.len(),
        model.materials.len(),
        model.textures.len()
    );
    studio::make_folder_of(&options.output)?;

    match options.turntable {
        None => rgb(render(&model, &options, options.view.yaw)?).save(&options.output)?,
        Some(pictures) => turntable(&model, &options, pictures)?,
    }
    println!("wrote {}", options.output.display());
    Ok(())
}

/// Pictures all around the model.
fn turntable(model: &Model, options: &Options, pictures: u16) -> Result<(), Box<dyn Error>> {
    let bar = ProgressBar::new(pictures.into())
        .with_style(ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left")?);
    let yaws = (0..pictures).map(|i| options.view.yaw + 360.0 * f32::from(i) / f32::from(pictures));
    if options.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif")) {
        let mut gif = GifEncoder::new_with_speed(File::create(&options.output)?, 10);
        gif.set_repeat(Repeat::Infinite)?;
        for yaw in yaws.progress_with(bar) {
            let delay = Delay::from_numer_denom_ms(4000, pictures.into());
            gif.encode_frame(Frame::from_parts(render(model, options, yaw)?, 0, 0, delay))?;
        }
    } else {
        for (i, yaw) in yaws.enumerate().progress_with(bar) {
            rgb(render(model, options, yaw)?).save(numbered(&options.output, i))?;
        }
    }
    Ok(())
}

/// `turn.png` as `turn_007.png`.
fn numbered(path: &Path, i: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{i:03}.{ending}"))
}

/// The model seen from one side.
fn render(model: &Model, options: &Options, yaw: f32) -> Result<RgbaImage, Box<dyn Error>> {
    let (width, height) = options.size;
    let background = options.background.map(polyscan::color::decode);
    let mut frame = Framebuffer::new(width * SAMPLES, height * SAMPLES, Vec3::from(background))?;
    let camera =
        Camera::around(sphere_around(model), width as f32 / height as f32, yaw, options.view.pitch);

    let vertices: Vec<_> = model
        .vertices
        .iter()
        .map(|vertex| {
            let surface = Surface { uv: vertex.uv, normal: vertex.normal };
            Vertex::new(camera.clip_from_object * vertex.position.extend(1.0), surface)
        })
        .collect();
    let mut renderer = ZBuffer::new(frame.viewport());
    renderer.scan.cull = if options.cull { Cull::Clockwise } else { Cull::None };
    for (i, material) in model.materials.iter().enumerate() {
        renderer.draw_mesh(&mut frame, &vertices, model.faces_of(i), |fragment| {
            let surface = Surface::from(fragment.params);
            color_of(model, Some(material), surface.uv) * camera.lit(&surface)
        });
    }
    Ok(frame.reduced(SAMPLES)?.to_image())
}

/// Without alpha, which some formats do not have.
fn rgb(picture: RgbaImage) -> image::RgbImage {
    DynamicImage::from(picture).into_rgb8()
}
