//! Renders an OBJ model as large as one likes: row by row into a PNG file, never the whole picture
//! in memory.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use clap::Parser;
use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Vec2, Vec3, vec3};
use indicatif::{ProgressBar, ProgressStyle};
use polyscan::color::Color;
use polyscan::obj::{Face, Model};
use polyscan::render::PngFile;
use polyscan::{Fragment, Scanline, Vertex, Viewport, record};

/// Draw a very large picture of an OBJ model.
#[derive(Parser)]
struct Options {
    /// The model.
    #[arg(default_value = "examples/assets/cottage.obj")]
    model: PathBuf,
    /// The PNG file to write.
    #[arg(long, default_value = "target/poster.png")]
    output: PathBuf,
    /// Width and height in pixels, up to 65536 each.
    #[arg(long, default_value = "12000x9000", value_parser = parse_size)]
    size: (u32, u32),
    /// Turn of the camera around the model, in degrees, to the right.
    #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
    yaw: f32,
    /// Height of the camera over the model's level, in degrees, from -90 to 90.
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    pitch: f32,
}

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once('x').ok_or("write it as 12000x9000")?;
    let side = |side: &str| match side.parse() {
        Ok(pixels @ 1..=65536) => Ok(pixels),
        _ => Err(format!("`{side}` is not a number of pixels from 1 to 65536")),
    };
    Ok((side(width)?, side(height)?))
}

record! {
    /// What goes from the vertices to the pixels.
    struct Surface {
        uv: Vec2,
        normal: Vec3,
    }
}

const FIELD_OF_VIEW: f32 = 0.6;

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let loaded = Model::load(&options.model)?;
    for warning in &loaded.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(folder) = options.output.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let (width, height) = options.size;
    println!("{}: {} faces", options.model.display(), loaded.model.face_count());
    let start = Instant::now();
    render(&loaded.model, &options)?;
    let (seconds, pixels) = (start.elapsed().as_secs_f64(), f64::from(width) * f64::from(height));
    println!("wrote {}: {width} x {height} pixels", options.output.display());
    println!("{seconds:.1} s, {:.1} million pixels a second", pixels / seconds / 1e6);
    if let Some(peak) = peak_memory() {
        let whole = pixels * size_of::<[u8; 3]>() as f64 / f64::from(1 << 20);
        println!("peak memory: {} MiB; the whole picture has {whole:.0} MiB", peak / 1024);
    }
    Ok(())
}

/// Draws the model, each row going to the file when it is finished.
fn render(model: &Model, options: &Options) -> Result<(), Box<dyn Error>> {
    let (width, height) = options.size;
    let camera = Camera::new(model, width as f32 / height as f32, options);
    let vertex = |vertex: &polyscan::obj::ModelVertex| {
        let surface = Surface { uv: vertex.uv, normal: vertex.normal };
        Vertex::new(camera.clip_from_object * vertex.position.extend(1.0), surface)
    };
    let vertices: Vec<_> = model.vertices.iter().map(vertex).collect();
    // Fragments know the number of their face, the list knows its material.
    let faces: Vec<Face<'_>> = model.faces().collect();
    let shader = |fragment: &Fragment<'_, 5>| {
        let material = faces.get(fragment.face as usize).map_or(0, |face| face.material);
        shade(model, material, fragment.params.into(), camera.light)
    };

    let bar = ProgressBar::new(height.into())
        .with_style(ProgressStyle::with_template("{bar:40} {percent}% of the rows, {eta} left")?);
    let mut file = PngFile::opaque(&options.output, width, height)?;
    let mut renderer = Scanline::new(Viewport::new(width, height)?);
    let background = [216, 226, 234];
    renderer.draw(&vertices, &faces, background, shader, |row, colors| {
        bar.set_position(u64::from(row) + 1);
        file.write_row(colors)
    })?;
    bar.finish_and_clear();
    file.finish()?;
    Ok(())
}

/// Diffuse light from one side, and a little from everywhere, in sRGB.
fn shade(model: &Model, material: usize, surface: Surface, light: Vec3) -> [u8; 3] {
    let material = model.materials.get(material);
    let texture = material.and_then(|m| m.texture).and_then(|i| model.textures.get(i));
    let picture = texture.map_or(Vec3::ONE, |texture| texture.sample(surface.uv).truncate());
    let diffuse = material.map_or(Vec3::ONE, |material| material.diffuse);
    // A face seen from behind is lit from behind.
    let facing = surface.normal.normalize_or_zero().dot(light);
    let lit = if facing < 0.0 { -0.4 * facing } else { facing };
    let [r, g, b, _] = (diffuse * picture * (0.15 + 0.85 * lit)).to_srgb8();
    [r, g, b]
}

struct Camera {
    clip_from_object: Mat4,
    /// Direction to the light: beside the camera, above its right shoulder.
    light: Vec3,
}

impl Camera {
    /// A camera that sees the whole of a sphere around the model.
    fn new(model: &Model, aspect: f32, options: &Options) -> Self {
        let (low, high) = model.bounds().unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
        let centre = (low + high) / 2.0;
        let distances = model.vertices.iter().map(|vertex| vertex.position.distance(centre));
        // A model that is a point is no reason to divide by zero.
        let radius = distances.fold(f32::MIN_POSITIVE.sqrt(), f32::max);
        let narrow = ((FIELD_OF_VIEW / 2.0).tan() * aspect.min(1.0)).atan();
        let distance = radius / narrow.sin();
        let (sin_yaw, cos_yaw) = options.yaw.to_radians().sin_cos();
        let (sin_pitch, cos_pitch) = options.pitch.clamp(-89.9, 89.9).to_radians().sin_cos();
        let direction = vec3(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let right = Vec3::Y.cross(direction).normalize();
        let light = (direction + 0.6 * right + 0.7 * direction.cross(right)).normalize();
        let view = look_at_mat4(centre + direction * distance, centre, Vec3::Y);
        let projection =
            perspective(FIELD_OF_VIEW, aspect, distance - radius * 1.01, distance + radius * 1.01);
        Self { clip_from_object: projection * view, light }
    }
}

/// The most memory that the program has had, in KiB, where the system says so (Linux).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}
