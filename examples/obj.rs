//! Renders an OBJ model with one lamp, by the z-buffer unless something is transparent; the camera stands where it sees all of it.
//!
//! ```text
//! cargo run --release --example obj -- --yaw -40 examples/assets/cottage.obj
//! cargo run --release --example obj -- --turntable 60 --size 400x300
//! cargo run --release --example obj -- --wireframe visible
//! cargo run --release --example obj -- --samples 16 --background none --output target/cut_out.png
//! ```

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressIterator as _, ProgressStyle};
use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::color::{Color, decode};
use polyscan::glam::{Vec3, Vec4};
use polyscan::model::{Face, Model};
use polyscan::obj::Loader;
use polyscan::render::{Cap, Join, MultisampleFramebuffer, MultisampleRenderer, Samples};
use polyscan::{
    Camera, Cull, DepthBias, Fragment, Framebuffer, Lines, Mesh, ScanlineRenderer, Vertex,
    Viewport, ZBufferRenderer,
};

mod cli;
mod studio;

use studio::{Lamp, Surface, View, parse_degrees, parse_size, parse_up, shade};

const HELP: &str = "\
Draw an OBJ model to a picture, or turn it around in an animated one.

Usage: obj [OPTIONS] [MODEL]

Arguments:
  [MODEL]  The OBJ file [default: examples/assets/cottage.obj]

Options:
      --yaw <DEGREES>         Turn of the camera around the model, to the right [default: 30]
      --pitch <DEGREES>       Height of the camera over the model's level [default: 20]
      --up <AXIS>             The axis of the model that is up: y, z, -y and so on [default: y]
      --output <FILE>         The PNG file to write [default: target/obj.png, or
                              target/turntable.png with --turntable]
      --size <SIZE>           Width and height in pixels, up to 16384 each [default: 800x600]
      --turntable <PICTURES>  Write an animated PNG file: a full turn in this many pictures, from 1
                              to 999, that takes four seconds
      --wireframe <LINES>     Draw the edges of the faces instead, each once: all, or the visible ones
      --cull                  Leave out faces that are seen from behind
      --background <COLOUR>   Background colour, sRGB in hexadecimal, or none for a transparent one
                              [default: d8e2ea]
      --samples <COUNT>       Samples a pixel: 1, 4, 8 or 16; glass, cut-outs and lines have 4 of their
                              own [default: 8]
      --crease <DEGREES>      Computed normals are smooth where faces meet at less than this
                              [default: 60]
  -h, --help                  Show this help
";

/// Where something is transparent, and of lines, each pixel is the mean of this many others in x and in y.
const SUPERSAMPLES: u32 = 2;

/// The colour of lines.
const INK: Vec3 = Vec3::new(0.02, 0.03, 0.06);

fn main() -> ExitCode {
    cli::run(draw_model)
}

fn draw_model() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let loader = Loader::new().with_crease_angle(options.crease.to_radians());
    let model = studio::load(&loader, &options.view.model)?;
    println!(
        "{}: {} faces, {} vertices, {} materials, {} textures",
        options.view.model.display(),
        model.face_count(),
        model.vertices.len(),
        model.materials.len(),
        model.textures.len()
    );
    let name = if options.turntable.is_some() { "target/turntable.png" } else { "target/obj.png" };
    let output = options.output.clone().unwrap_or_else(|| name.into());
    cli::make_folder_of(&output)?;
    match options.turntable {
        None => render(&model, &options, 0.0)?.save_png(&output)?,
        Some(pictures) => save_turntable(&model, &options, pictures, &output)?,
    }
    println!("wrote {}", output.display());
    Ok(())
}

/// The model, after a turn to the right by some degrees.
fn render(
    model: &Model,
    options: &Options,
    turn: f32,
) -> Result<Framebuffer<Vec4>, Box<dyn Error>> {
    let (width, height) = options.size;
    let background =
        options.background.map_or(Vec4::ZERO, |rgb| Vec3::from(rgb.map(decode)).extend(1.0));
    let view = View { yaw: options.view.yaw + turn, ..options.view.clone() };
    let camera = view.turned(model.camera(width as f32 / height as f32));
    let lamp = Lamp::beside(&camera);

    let large = || Framebuffer::new(width * SUPERSAMPLES, height * SUPERSAMPLES, background);
    if let Some(wireframe) = options.wireframe {
        let mut frame = large()?;
        draw_wireframe(&mut frame, model, &camera, wireframe);
        return Ok(frame.downsampled(SUPERSAMPLES)?);
    }
    // Displacement maps become geometry, as fine as the pixels.
    let viewport = Viewport::new(width, height)?;
    let model = &*model.displaced(camera.clip_from_object(), viewport, 1.0);
    let vertices = studio::vertices(model, camera.clip_from_object());
    // Fragments know the number of their face, the list knows its material.
    let faces: Vec<Face<'_>> = model.faces().collect();
    let shader = |fragment: &Fragment<'_, { Surface::LEN }>| {
        let material = faces[fragment.face as usize].material;
        shade(model, material, fragment, &lamp)
    };
    let cull = if options.cull { Cull::Back } else { Cull::None };
    if model.has_transparency() {
        // Glass and cut-outs in their true order, which a z-buffer does not know.
        let is_transparent = |face| model.materials[faces[face as usize].material].is_transparent();
        let mesh = Mesh::new(&vertices, &faces).with_transparent(&is_transparent);
        let mut frame = large()?;
        let mut renderer = ScanlineRenderer::new(frame.viewport());
        renderer.settings.cull = cull;
        renderer.draw(&mut frame, mesh, shader);
        return Ok(frame.downsampled(SUPERSAMPLES)?);
    }
    let mesh = Mesh::new(&vertices, &faces);
    let Some(samples) = options.samples else {
        let mut frame = Framebuffer::new(width, height, background)?;
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.settings.cull = cull;
        renderer.draw(&mut frame, mesh, shader);
        return Ok(frame);
    };
    let mut frame = MultisampleFramebuffer::new(width, height, samples, background)?;
    let mut renderer = MultisampleRenderer::new(frame.viewport());
    renderer.settings.cull = cull;
    renderer.draw(&mut frame, mesh, shader);
    Ok(frame.resolve()?)
}

/// Draws the edges of the model, those that its faces hide left out on demand.
fn draw_wireframe(
    frame: &mut Framebuffer<Vec4>,
    model: &Model,
    camera: &Camera,
    wireframe: Wireframe,
) {
    let vertices: Vec<Vertex<0>> = model.vertices_with(camera.clip_from_object(), |_| []);
    let mesh = Mesh::new(&vertices, model.faces());
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    if wireframe == Wireframe::Visible {
        // Lines lie on the faces, which are moved back by as much as they change within a pixel.
        renderer.settings.depth_bias = DepthBias { constant: 1e-6, slope: 1.5 };
        renderer.draw_depth(frame, mesh.clone());
        renderer.settings.depth_bias = DepthBias::default();
    }
    let lines =
        Lines::edges_of(&mesh).with_width(1.25 * SUPERSAMPLES as f32).with_join(Join::Bevel);
    renderer.draw(frame, lines.with_cap(Cap::Round), |_| INK.extend(1.0));
}

/// Writes an animated PNG file of pictures all around the model.
fn save_turntable(
    model: &Model,
    options: &Options,
    pictures: u16,
    path: &Path,
) -> Result<(), Box<dyn Error>> {
    let bar = ProgressBar::new(pictures.into())
        .with_style(ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left")?);
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, options.size.0, options.size.1);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    // Again and again; the whole turn in four seconds.
    encoder.set_animated(pictures.into(), 0)?;
    encoder.set_frame_delay(4, pictures)?;
    let mut writer = encoder.write_header()?;
    for i in (0..pictures).progress_with(bar) {
        let picture = render(model, options, 360.0 * f32::from(i) / f32::from(pictures))?;
        let rgba = |color: &Vec4| color.to_srgb8();
        writer.write_image_data(&picture.color().iter().flat_map(rgba).collect::<Vec<_>>())?;
    }
    writer.finish()?;

    // The file gets its name when it is whole.
    let part = path.with_extension("png.part");
    let written = fs::write(&part, file).and_then(|()| fs::rename(&part, path));
    written.map_err(|error| {
        // What cannot be removed was perhaps never there; the first error is the one to tell.
        let _ = fs::remove_file(&part);
        format!("cannot write {}: {error}", path.display()).into()
    })
}

// ----------------------------------------------------------------------------------------- options

/// Which edges are drawn.
#[derive(Clone, Copy, PartialEq)]
enum Wireframe {
    All,
    Visible,
}

struct Options {
    view: View,
    /// Edges instead of faces.
    wireframe: Option<Wireframe>,
    output: Option<PathBuf>,
    /// Width and height in pixels.
    size: (u32, u32),
    /// The number of pictures of a full turn; instead of one picture.
    turntable: Option<u16>,
    cull: bool,
    /// `None` is transparent.
    background: Option<[u8; 3]>,
    /// `None` is one, at each pixel's centre.
    samples: Option<Samples>,
    /// In degrees.
    crease: f32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            view: View::default(),
            wireframe: None,
            output: None,
            size: (800, 600),
            turntable: None,
            cull: false,
            background: Some([0xd8, 0xe2, 0xea]),
            samples: Some(Samples::Eight),
            crease: 60.0,
        }
    }
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self::default();
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Value(model) => options.view.model = model.into(),
                Arg::Long("yaw") => options.view.yaw = parser.value()?.parse_with(parse_degrees)?,
                Arg::Long("pitch") => {
                    options.view.pitch = parser.value()?.parse_with(parse_degrees)?;
                }
                Arg::Long("up") => options.view.up = parser.value()?.parse_with(parse_up)?,
                Arg::Long("output") => options.output = Some(cli::png(parser.value()?)?),
                Arg::Long("size") => {
                    options.size = parser.value()?.parse_with(|text| parse_size(text, 16_384))?;
                }
                Arg::Long("turntable") => {
                    let pictures = parser.value()?.parse_with(|text| cli::number(text, 1..=999))?;
                    options.turntable = Some(pictures as u16);
                }
                Arg::Long("wireframe") => {
                    options.wireframe = Some(parser.value()?.parse_with(parse_wireframe)?);
                }
                Arg::Long("cull") => options.cull = true,
                Arg::Long("background") => {
                    options.background = parser.value()?.parse_with(parse_color)?;
                }
                Arg::Long("samples") => {
                    options.samples = parser.value()?.parse_with(parse_samples)?;
                }
                Arg::Long("crease") => {
                    options.crease = parser.value()?.parse_with(parse_degrees)?;
                }
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                Arg::Short(_) | Arg::Long(_) => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}

fn parse_wireframe(text: &str) -> Result<Wireframe, &'static str> {
    match text {
        "all" => Ok(Wireframe::All),
        "visible" => Ok(Wireframe::Visible),
        _ => Err("write all or visible"),
    }
}

fn parse_samples(text: &str) -> Result<Option<Samples>, &'static str> {
    match text {
        "1" => Ok(None),
        "4" => Ok(Some(Samples::Four)),
        "8" => Ok(Some(Samples::Eight)),
        "16" => Ok(Some(Samples::Sixteen)),
        _ => Err("there may be 1, 4, 8 or 16"),
    }
}

fn parse_color(text: &str) -> Result<Option<[u8; 3]>, &'static str> {
    if text == "none" {
        return Ok(None);
    }
    let number = u32::from_str_radix(text, 16).ok().filter(|_| text.len() == 6);
    let [_, r, g, b] =
        number.ok_or("write it as six digits, such as ffcc00, or as none")?.to_be_bytes();
    Ok(Some([r, g, b]))
}
