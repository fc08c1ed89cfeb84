//! Renders an OBJ model: framed by itself, with one light, through the z-buffer.

use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};

use clap::Parser;
use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Vec2, Vec3, vec3};
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, DynamicImage, Frame, RgbaImage};
use indicatif::{ProgressBar, ProgressIterator, ProgressStyle};
use polyscan::obj::{Loader, Material, Model};
use polyscan::{Cull, Framebuffer, Vertex, ZBuffer, record};

/// Draw an OBJ model to a picture, or turn it around in a series of pictures.
#[derive(Parser)]
struct Options {
    /// The model.
    #[arg(default_value = "examples/assets/cottage.obj")]
    model: PathBuf,
    /// The picture to write; its name's ending chooses the format. With --turntable: an animated
    /// .gif, or a series with numbers before the ending.
    #[arg(long, default_value = "target/obj.png")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "800x600", value_parser = parse_size)]
    size: (u32, u32),
    /// Turn of the camera around the model, in degrees, to the right.
    #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
    yaw: f32,
    /// Height of the camera over the model's level, in degrees, from -90 to 90.
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    pitch: f32,
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

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').ok_or("write it as 800x600")?;
    let side = |side: &str| match side.parse() {
        Ok(pixels @ 1..=16384) => Ok(pixels),
        _ => Err(format!("`{side}` is not a number of pixels from 1 to 16384")),
    };
    Ok((side(width)?, side(height)?))
}

fn parse_color(text: &str) -> Result<[u8; 3], String> {
    let number = u32::from_str_radix(text, 16).ok().filter(|_| text.len() == 6);
    let [_, r, g, b] = number.ok_or("write it as six digits, such as ffcc00")?.to_be_bytes();
    Ok([r, g, b])
}

record! {
    /// What goes from the vertices to the pixels.
    struct Surface {
        uv: Vec2,
        normal: Vec3,
    }
}

/// Each pixel is the mean of this many samples in x and in y.
const SAMPLES: u32 = 2;
const FIELD_OF_VIEW: f32 = 0.7;

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let loader = Loader::new().with_crease_angle(options.crease.to_radians());
    let loaded = loader.load(&options.model)?;
    for warning in &loaded.warnings {
        eprintln!("warning: {warning}");
    }
    let model = loaded.model;
    println!(
        "{}: {} faces, {} vertices, {} materials, {} textures",
        options.model.display(),
        model.faces().count(),
        model.vertices.len(),
        model.materials.len(),
        model.textures.len()
    );
    if let Some(folder) = options.output.parent() {
        std::fs::create_dir_all(folder)?;
    }

    match options.turntable {
        None => rgb(render(&model, &options, options.yaw)?).save(&options.output)?,
        Some(pictures) => turntable(&model, &options, pictures)?,
    }
    println!("wrote {}", options.output.display());
    Ok(())
}

/// Pictures all around the model.
fn turntable(model: &Model, options: &Options, pictures: u16) -> Result<(), Box<dyn Error>> {
    let bar = ProgressBar::new(pictures.into())
        .with_style(ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left")?);
    let yaws = (0..pictures).map(|i| options.yaw + 360.0 * f32::from(i) / f32::from(pictures));
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
    let camera = Camera::around(model, width as f32 / height as f32, yaw, options.pitch);

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
            shade(model, material, fragment.params.into(), camera.light)
        });
    }
    Ok(frame.reduced(SAMPLES)?.to_image())
}

/// Diffuse light from one side, and a little from everywhere.
fn shade(model: &Model, material: &Material, surface: Surface, light: Vec3) -> Vec3 {
    let texture = material.texture.and_then(|i| model.textures.get(i));
    let picture = texture.map_or(Vec3::ONE, |texture| texture.sample(surface.uv).truncate());
    // A face seen from behind is lit from behind.
    let facing = surface.normal.normalize_or_zero().dot(light);
    let diffuse = if facing < 0.0 { -0.4 * facing } else { facing };
    material.diffuse * picture * (0.15 + 0.85 * diffuse)
}

struct Camera {
    clip_from_object: Mat4,
    /// Direction to the light: beside the camera, above its right shoulder.
    light: Vec3,
}

impl Camera {
    /// A camera that sees the whole of a sphere around the model, from whatever side.
    fn around(model: &Model, aspect: f32, yaw: f32, pitch: f32) -> Self {
        let (low, high) = model.bounds().unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
        let centre = (low + high) / 2.0;
        let distances = model.vertices.iter().map(|vertex| vertex.position.distance(centre));
        // A model that is a point is no reason to divide by zero.
        let radius = distances.fold(f32::MIN_POSITIVE.sqrt(), f32::max);
        let narrow = ((FIELD_OF_VIEW / 2.0).tan() * aspect.min(1.0)).atan();
        let distance = radius / narrow.sin();
        let (sin_yaw, cos_yaw) = yaw.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = pitch.clamp(-89.9, 89.9).to_radians().sin_cos();
        let direction = vec3(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let eye = centre + direction * distance;
        let right = Vec3::Y.cross(direction).normalize();
        let light = (direction + 0.6 * right + 0.7 * direction.cross(right)).normalize();
        let projection =
            perspective(FIELD_OF_VIEW, aspect, distance - radius * 1.01, distance + radius * 1.01);
        Self { clip_from_object: projection * look_at_mat4(eye, centre, Vec3::Y), light }
    }
}

/// Without alpha, which some formats do not have.
fn rgb(picture: RgbaImage) -> image::RgbImage {
    DynamicImage::from(picture).into_rgb8()
}
