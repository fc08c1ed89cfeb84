//! Renders an OBJ model as large as one likes: row by row into a PNG file, never the whole picture
//! in memory.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use polyscan::color::Color;
use polyscan::obj::{Face, Loader, Model};
use polyscan::render::PngFile;
use polyscan::{Fragment, Scanline, Vertex, Viewport};

mod studio;

use studio::{Camera, Surface, View, color_of, parse_size, sphere_around};

/// Draw a very large picture of an OBJ model.
#[derive(Parser)]
struct Options {
    #[command(flatten)]
    view: View,
    /// The PNG file to write.
    #[arg(long, default_value = "target/poster.png")]
    output: PathBuf,
    /// Width and height in pixels, up to 65536 each.
    #[arg(long, default_value = "12000x9000", value_parser = parse_size::<65536>)]
    size: (u32, u32),
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let model = studio::load(&Loader::new(), &options.view.model)?;
    studio::make_folder_of(&options.output)?;
    let (width, height) = options.size;
    println!("{}: {} faces", options.view.model.display(), model.face_count());
    let start = Instant::now();
    render(&model, &options)?;
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
    let View { yaw, pitch, .. } = options.view;
    let camera = Camera::around(sphere_around(model), width as f32 / height as f32, yaw, pitch);
    let vertex = |vertex: &polyscan::obj::ModelVertex| {
        let surface = Surface { uv: vertex.uv, normal: vertex.normal };
        Vertex::new(camera.clip_from_object * vertex.position.extend(1.0), surface)
    };
    let vertices: Vec<_> = model.vertices.iter().map(vertex).collect();
    // Fragments know the number of their face, the list knows its material.
    let faces: Vec<Face<'_>> = model.faces().collect();
    let shader = |fragment: &Fragment<'_, 5>| {
        let face = faces.get(fragment.face as usize);
        let material = face.and_then(|face| model.materials.get(face.material));
        let surface = Surface::from(fragment.params);
        let [r, g, b, _] =
            (color_of(model, material, surface.uv) * camera.lit(&surface)).to_srgb8();
        [r, g, b]
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

/// The most memory that the program has had, in KiB, where the system says so (Linux).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}
