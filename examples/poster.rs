//! Renders an OBJ model as large as one likes: row by row into a PNG file, never the whole picture
//! in memory.
//!
//! ```text
//! cargo run --release --example poster -- --size 20000x15000
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::color::decode;
use polyscan::glam::Vec3;
use polyscan::model::{Face, Model};
use polyscan::obj::Loader;
use polyscan::render::PngFile;
use polyscan::{Fragment, Mesh, ScanlineRenderer, Viewport};

mod cli;
mod studio;

use studio::{Lamp, Surface, View, parse_degrees, parse_size, parse_up, shade};

const HELP: &str = "\
Draw a very large picture of an OBJ model.

Usage: poster [OPTIONS] [MODEL]

Arguments:
  [MODEL]  The OBJ file [default: examples/assets/cottage.obj]

Options:
      --yaw <DEGREES>    Turn of the camera around the model, to the right [default: 30]
      --pitch <DEGREES>  Height of the camera over the model's level [default: 20]
      --up <AXIS>        The axis of the model that is up: y, z, -y and so on [default: y]
      --output <FILE>    The PNG file to write [default: target/poster.png]
      --size <SIZE>      Width and height in pixels, up to 65536 each [default: 12000x9000]
  -h, --help             Show this help
";

fn main() -> ExitCode {
    cli::run(draw_poster)
}

fn draw_poster() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let model = studio::load(&Loader::new(), &options.view.model)?;
    cli::make_folder_of(&options.output)?;
    let (width, height) = options.size;
    println!("{}: {} faces", options.view.model.display(), model.face_count());
    let start = Instant::now();
    render(&model, &options)?;
    let (seconds, pixels) = (start.elapsed().as_secs_f64(), f64::from(width) * f64::from(height));
    println!("wrote {}: {width} x {height} pixels", options.output.display());
    println!("{seconds:.2} s, {:.1} million pixels a second", pixels / seconds / 1e6);
    if let Some(peak) = peak_memory() {
        let whole = pixels * size_of::<[u8; 3]>() as f64 / f64::from(1 << 20);
        println!("peak memory: {} MiB; the whole picture has {whole:.0} MiB", peak / 1024);
    }
    Ok(())
}

/// Draws the model, each row going to the file when it is finished.
fn render(model: &Model, options: &Options) -> Result<(), Box<dyn Error>> {
    let (width, height) = options.size;
    let camera = options.view.turned(model.camera(width as f32 / height as f32));
    let lamp = Lamp::beside(&camera);
    let viewport = Viewport::new(width, height)?;
    let model = &*model.displaced(camera.clip_from_object(), viewport, 1.0);
    let vertices = studio::vertices(model, camera.clip_from_object());
    // Fragments know the number of their face, the list knows its material.
    let faces: Vec<Face<'_>> = model.faces().collect();
    let shader = |fragment: &Fragment<'_, { Surface::LEN }>| {
        let material = faces[fragment.face as usize].material;
        shade(model, material, fragment, &lamp)
    };

    let bar = ProgressBar::new(height.into())
        .with_style(ProgressStyle::with_template("{bar:40} {percent}% of the rows, {eta} left")?);
    let mut file = PngFile::opaque(&options.output, width, height)?;
    let mut renderer = ScanlineRenderer::new(viewport);
    let background = Vec3::from([216, 226, 234].map(decode));
    let is_transparent = |face| model.materials[faces[face as usize].material].is_transparent();
    let mesh = Mesh::new(&vertices, &faces).with_transparent(&is_transparent);
    renderer.stream(mesh, background, shader, |row, colors| {
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

// ----------------------------------------------------------------------------------------- options

struct Options {
    view: View,
    output: PathBuf,
    /// Width and height in pixels.
    size: (u32, u32),
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let (view, output) = (View::default(), PathBuf::from("target/poster.png"));
        let mut options = Self { view, output, size: (12_000, 9000) };
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Value(model) => options.view.model = model.into(),
                Arg::Long("yaw") => options.view.yaw = parser.value()?.parse_with(parse_degrees)?,
                Arg::Long("pitch") => {
                    options.view.pitch = parser.value()?.parse_with(parse_degrees)?;
                }
                Arg::Long("up") => options.view.up = parser.value()?.parse_with(parse_up)?,
                Arg::Long("output") => options.output = cli::png(parser.value()?)?,
                Arg::Long("size") => {
                    options.size = parser.value()?.parse_with(|text| parse_size(text, 65_536))?;
                }
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                Arg::Short(_) | Arg::Long(_) => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}
