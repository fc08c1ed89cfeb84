//! One scene through all renderers: what each of them takes, and where their pictures differ.
//!
//! Around a model there are squares through each other, a ring (a polygon with a hole), and three
//! panes of glass that cross. The opaque part is the same by all but the depth sort. With the glass it
//! is the same by the painter's tree and the scanline renderer; a z-buffer needs the panes in their
//! order, and they have none. What is left are a few pixels in whose middle two faces meet: there the
//! painter's tree decides by planes, the others by depth.
//!
//! All four are compared at the samples of a larger picture, of which each pixel is the mean. A z-buffer needs no larger
//! one for that: it is drawn once more with as many samples a pixel, each face shaded once a pixel. Areas would be no
//! way to join faces here: they have seams where faces meet, from back to front, and know no glass from front to back.
//!
//! ```text
//! cargo run --release --example renderers
//! ```

use std::error::Error;
use std::f32::consts::TAU;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::Model;
use polyscan::camera::{Camera, Sphere};
use polyscan::glam::{EulerRot, Mat4, Quat, Vec2, Vec3, Vec4, vec2, vec3, vec4};
use polyscan::obj::Loader;
use polyscan::render::{Additive, MultisampleFramebuffer, MultisampleRenderer, Over, Samples};
use polyscan::{
    BspTree, Fragment, Framebuffer, Mesh, PainterRenderer, ScanlineRenderer, Vertex,
    ZBufferRenderer,
};

mod cli;
mod studio;

use studio::{Lamp, Surface, View, parse_degrees, parse_size, parse_up, shade};

const HELP: &str = "\
Draw one scene by the z-buffer, the painter's and the scanline renderer, and compare them.

Usage: renderers [OPTIONS] [MODEL]

Arguments:
  [MODEL]  The OBJ file in the middle [default: examples/assets/cottage.obj]

Options:
      --yaw <DEGREES>    Turn of the camera around the model, to the right [default: 30]
      --pitch <DEGREES>  Height of the camera over the model's level [default: 20]
      --up <AXIS>        The axis of the model that is up: y, z, -y and so on [default: y]
      --output <FILE>    The PNG file to write: the scene by the scanline renderer, and beside it the
                         z-buffer's in grey, in red where that is another [default: target/renderers.png]
      --size <SIZE>      Width and height of the scene in pixels, up to 8192 each
                         [default: 480x360]
      --samples <COUNT>  Samples a pixel: 1, 4, 8 (3 x 3 where all renderers are compared) or 16
                         [default: 4]
      --frames <NUMBER>  How often each renderer is timed, from 1 to 1000; the median is shown
                         [default: 7]
  -h, --help             Show this help
";

/// Floats that go from the vertices to the pixels.
const N: usize = Surface::LEN;
/// The colour behind everything, in linear light.
const BACKGROUND: Vec4 = vec4(0.68, 0.76, 0.82, 1.0);

fn main() -> ExitCode {
    cli::run(draw_and_compare)
}

fn draw_and_compare() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let model = studio::load(&Loader::new(), &options.view.model)?;
    cli::make_folder_of(&options.output)?;
    let scene = Scene::around(&model);
    let (width, height) = options.size;
    let camera = options.view.turned(Camera::around(scene.sphere, width as f32 / height as f32));
    let side = options.samples_in_a_row();
    let size = (width * side, height * side);

    let pictures = 2 * RENDERERS.len() as u64 + u64::from(options.samples.is_some());
    let timings = pictures * u64::from(options.frames);
    let bar = ProgressBar::new(timings)
        .with_style(ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left")?);
    let opaque = compare(&scene, scene.glass, &camera, size, options.frames, &bar)?;
    let all = compare(&scene, scene.faces.len(), &camera, size, options.frames, &bar)?;
    let multisampled = Multisampled::draw(&scene, &camera, &options, &bar)?;
    bar.finish_and_clear();
    println!("{}, {} x {} samples", options.view.model.display(), size.0, size.1);
    opaque.print("opaque faces");
    all.print("with three panes of glass that cross");
    if let Some(Multisampled { milliseconds, .. }) = &multisampled {
        println!(
            "\nz-buffer, as many samples, each face shaded once a pixel: {milliseconds:.1} ms"
        );
    }

    let z_buffer = multisampled.map(|multisampled| multisampled.frame);
    picture(&all, z_buffer, side)?.save_png(&options.output)?;
    println!("\nwrote {}", options.output.display());
    Ok(())
}

// ------------------------------------------------------------------------------------- comparison

#[derive(Clone, Copy, Debug, PartialEq)]
enum Renderer {
    ZBuffer,
    DepthSort,
    Painter,
    Scanline,
}

/// The last is what the others are compared with.
const RENDERERS: [(Renderer, &str); 4] = [
    (Renderer::ZBuffer, "z-buffer"),
    (Renderer::DepthSort, "painter, by depth"),
    (Renderer::Painter, "painter, by tree"),
    (Renderer::Scanline, "scanline"),
];

struct Comparison {
    faces: usize,
    pieces: usize,
    build_milliseconds: f64,
    /// Pixels that any face covers.
    covered: u64,
    /// Faces at those, summed up.
    layers: u64,
    results: Vec<Measured>,
}

struct Measured {
    name: &'static str,
    milliseconds: f64,
    shaded: u64,
    frame: Framebuffer<Vec4>,
}

/// Draws the first faces of a scene by each renderer, so many times.
fn compare(
    scene: &Scene<'_>,
    faces: usize,
    camera: &Camera,
    (width, height): (u32, u32),
    times: u32,
    bar: &ProgressBar,
) -> Result<Comparison, Box<dyn Error>> {
    let start = Instant::now();
    let tree = BspTree::new(&scene.vertices, &scene.faces[..faces]);
    let build_milliseconds = milliseconds(start);
    let (clip_from_object, lamp) = (camera.clip_from_object(), Lamp::beside(camera));
    let part = Part { scene, faces, tree: &tree, clip_from_object };
    let mut counts = Framebuffer::new(width, height, 0u32)?;
    let mut painter = PainterRenderer::new(counts.viewport());
    painter.draw(&mut counts, tree.seen_by(clip_from_object), |_| Additive(1));

    let mut results = Vec::new();
    for (renderer, name) in RENDERERS {
        let mut frame = Framebuffer::new(width, height, BACKGROUND)?;
        let shaded = AtomicU64::new(0);
        part.draw(renderer, &mut frame, |face, fragment| {
            shaded.fetch_add(1, Ordering::Relaxed);
            scene.shade(face, fragment, &lamp)
        });
        let mut runs: Vec<f64> = Vec::new();
        for _ in 0..times {
            let start = Instant::now();
            frame.clear(BACKGROUND, 1.0);
            part.draw(renderer, &mut frame, |face, fragment| scene.shade(face, fragment, &lamp));
            runs.push(milliseconds(start));
            bar.inc(1);
        }
        runs.sort_by(f64::total_cmp);
        let (milliseconds, shaded) = (runs[runs.len() / 2], shaded.into_inner());
        results.push(Measured { name, milliseconds, shaded, frame });
    }
    Ok(Comparison {
        faces,
        pieces: tree.pieces(),
        build_milliseconds,
        covered: counts.color().iter().filter(|&&layers| layers > 0).count() as u64,
        layers: counts.color().iter().map(|&layers| u64::from(layers)).sum(),
        results,
    })
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

impl Comparison {
    fn print(&self, title: &str) {
        let Self { faces, pieces, covered, layers, build_milliseconds, .. } = self;
        let depth = *layers as f64 / (*covered).max(1) as f64;
        println!("\n{title}: {faces} faces, {depth:.2} at each of the {covered} pixels covered;");
        println!("the painter's tree has {pieces} pieces, built in {build_milliseconds:.1} ms");
        println!("                        ms  fragments shaded  overdraw  pixels that differ");
        for Measured { name, milliseconds, shaded, frame } in &self.results {
            let overdraw = *shaded as f64 / (*covered).max(1) as f64;
            let differ = self.differing(frame).filter(|&differs| differs).count();
            println!("{name:18} {milliseconds:7.1}  {shaded:16}  {overdraw:8.2}  {differ:18}");
        }
    }

    /// For each pixel, whether a picture differs from that of the last renderer, in any bit.
    fn differing<'a>(&'a self, frame: &'a Framebuffer<Vec4>) -> impl Iterator<Item = bool> + 'a {
        let bits = |color: &Vec4| color.to_array().map(f32::to_bits);
        let expected = self.results.last().map_or(frame, |last| &last.frame).color();
        frame.color().iter().zip(expected).map(move |(a, b)| bits(a) != bits(b))
    }
}

/// The z-buffer's picture with several samples a pixel.
struct Multisampled {
    milliseconds: f64,
    frame: Framebuffer<Vec4>,
}

impl Multisampled {
    /// Draws the whole scene; `None` if one sample a pixel is asked for.
    fn draw(
        scene: &Scene<'_>,
        camera: &Camera,
        options: &Options,
        bar: &ProgressBar,
    ) -> Result<Option<Self>, Box<dyn Error>> {
        let Some(samples) = options.samples else { return Ok(None) };
        let (matrix, lamp) = (camera.clip_from_object(), Lamp::beside(camera));
        let (width, height) = options.size;
        let mut large = MultisampleFramebuffer::new(width, height, samples, BACKGROUND)?;
        let mut frame = large.resolve()?;
        let mut runs: Vec<f64> = Vec::new();
        for _ in 0..options.frames {
            let start = Instant::now();
            large.clear(BACKGROUND, 1.0);
            let vertices = scene.seen_by(matrix);
            let panes = scene.panes(scene.faces.len(), &vertices);
            let mut z_buffer = MultisampleRenderer::new(large.viewport());
            let opaque = Mesh::new(&vertices, &scene.faces[..scene.glass]);
            z_buffer.draw(&mut large, opaque, |f| scene.shade(f.face as usize, f, &lamp));
            z_buffer.depth_write = false;
            let sorted = panes.iter().map(|&face| &scene.faces[face]);
            z_buffer.draw(&mut large, Mesh::new(&vertices, sorted), |f| {
                scene.shade(panes[f.face as usize], f, &lamp)
            });
            frame = large.resolve()?;
            runs.push(milliseconds(start));
            bar.inc(1);
        }
        runs.sort_by(f64::total_cmp);
        Ok(Some(Self { milliseconds: runs[runs.len() / 2], frame }))
    }
}

/// The scene by the scanline renderer, and beside it the z-buffer's in grey, in red as far as it is
/// another. `side` is how many samples a pixel of the comparison has in each direction.
fn picture(
    comparison: &Comparison,
    z_buffer: Option<Framebuffer<Vec4>>,
    side: u32,
) -> Result<Framebuffer<Vec4>, Box<dyn Error>> {
    let [compared, .., scanline] = comparison.results.as_slice() else {
        return Err("there is nothing to compare".into());
    };
    let mut differs = Framebuffer::new(compared.frame.width(), compared.frame.height(), 0.0f32)?;
    let differing = comparison.differing(&compared.frame);
    for (amount, differs) in differs.color_mut().iter_mut().zip(differing) {
        *amount = f32::from(u8::from(differs));
    }
    let (left, differs) = (scanline.frame.downsampled(side)?, differs.downsampled(side)?);
    let mut right = match z_buffer {
        Some(picture) => picture,
        None => compared.frame.clone(),
    };
    for (color, differs) in right.color_mut().iter_mut().zip(differs.color()) {
        // Luminance of sRGB's primaries (ITU-R BT.709), with less contrast than the scene.
        let grey = 0.45 + 0.45 * color.dot(vec4(0.2126, 0.7152, 0.0722, 0.0));
        *color = Vec4::splat(grey).lerp(vec4(0.8, 0.05, 0.02, 1.0), *differs).with_w(1.0);
    }
    let width = left.width();
    let mut both = Framebuffer::new(2 * width, left.height(), BACKGROUND)?;
    let width = width as usize;
    let rows = left.color().chunks(width).zip(right.color().chunks(width));
    for (row, (left, right)) in both.color_mut().chunks_mut(2 * width).zip(rows) {
        row[..width].copy_from_slice(left);
        row[width..].copy_from_slice(right);
    }
    Ok(both)
}

// ----------------------------------------------------------------------------------------- drawing

/// Some faces of a scene, seen from somewhere.
struct Part<'a> {
    scene: &'a Scene<'a>,
    /// How many faces, from the first.
    faces: usize,
    tree: &'a BspTree<N>,
    clip_from_object: Mat4,
}

impl Part<'_> {
    /// Draws the faces on a frame that shows the background. `shader` is given the number of a face.
    fn draw(
        &self,
        renderer: Renderer,
        frame: &mut Framebuffer<Vec4>,
        shader: impl Fn(usize, &Fragment<'_, N>) -> Over + Sync,
    ) {
        let (scene, matrix) = (self.scene, self.clip_from_object);
        let faces = &scene.faces[..self.faces];
        let shade = |f: &Fragment<'_, N>| shader(f.face as usize, f);
        if renderer == Renderer::Painter {
            PainterRenderer::new(frame.viewport()).draw(frame, self.tree.seen_by(matrix), shade);
            return;
        }
        let vertices = scene.seen_by(matrix);
        match renderer {
            Renderer::DepthSort => {
                let sorted = Mesh::new(&vertices, faces).back_to_front();
                PainterRenderer::new(frame.viewport()).draw(frame, sorted, shade);
            }
            Renderer::ZBuffer => {
                let mut z_buffer = ZBufferRenderer::new(frame.viewport());
                z_buffer.draw(frame, Mesh::new(&vertices, &faces[..scene.glass]), shade);
                let panes = scene.panes(faces.len(), &vertices);
                z_buffer.depth_write = false;
                let sorted = panes.iter().map(|&face| &faces[face]);
                z_buffer.draw(frame, Mesh::new(&vertices, sorted), |f| {
                    shader(panes[f.face as usize], f)
                });
            }
            Renderer::Painter | Renderer::Scanline => {
                let is_glass = |face| face as usize >= scene.glass;
                let mesh = Mesh::new(&vertices, faces).with_transparent(&is_glass);
                ScanlineRenderer::new(frame.viewport()).draw(frame, mesh, shade);
            }
        }
    }
}

// ------------------------------------------------------------------------------------------- scene

/// How a face looks.
#[derive(Clone, Copy)]
enum Look {
    /// A material of the model, by its number.
    Model(usize),
    Paint(Vec3),
    /// The colour of the light that comes from the glass.
    Glass(Vec3),
}

/// Faces in object space: opaque ones first.
struct Scene<'a> {
    model: &'a Model,
    vertices: Vec<Vertex<N>>,
    faces: Vec<Vec<u32>>,
    looks: Vec<Look>,
    /// The number of the first face that is glass.
    glass: usize,
    /// It holds all faces.
    sphere: Sphere,
}

impl<'a> Scene<'a> {
    fn around(model: &'a Model) -> Self {
        let nothing = Sphere { centre: Vec3::ZERO, radius: 1.0 };
        let sphere = model.bounding_sphere().unwrap_or(nothing);
        let (centre, size) = (sphere.centre, sphere.radius);
        let mut scene = Self {
            model,
            vertices: studio::vertices(model, Mat4::IDENTITY),
            faces: Vec::new(),
            looks: Vec::new(),
            glass: 0,
            sphere: Sphere { centre, radius: 1.4 * size },
        };
        scene.add_model(false);
        let place = |turn: Quat, x: f32, y: f32, z: f32| {
            Mat4::from_scale_rotation_translation(
                Vec3::splat(size),
                turn,
                centre + size * vec3(x, y, z),
            )
        };
        let turned = |y, x, z| Quat::from_euler(EulerRot::YXZ, y, x, z);

        let ring = place(turned(0.0, 0.2 - TAU / 4.0, 0.25), 0.0, -0.1, 0.0);
        scene.add(ring, &with_hole(&circle(96, 1.36), 0.86), Look::Paint(vec3(0.8, 0.3, 0.06)));
        let colors = [vec3(0.75, 0.55, 0.08), vec3(0.1, 0.35, 0.6), vec3(0.75, 0.16, 0.1)];
        for (axis, color) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(colors) {
            let turn = turned(0.5, 0.5, 0.3) * Quat::from_rotation_arc(Vec3::Z, axis);
            let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let square = square.map(|(x, y)| vec2(x, y) * 0.24);
            scene.add(place(turn, -0.62, 0.72, 0.2), &square, Look::Paint(color));
        }

        scene.glass = scene.faces.len();
        scene.add_model(true);
        let tints = [vec3(0.02, 0.5, 0.6), vec3(0.65, 0.05, 0.3), vec3(0.7, 0.55, 0.02)];
        for (i, tint) in (0..).zip(tints) {
            let turn = turned(0.3 + TAU / 6.0 * i as f32, 0.0, 0.0);
            let pane = [(-1.0, -0.9), (1.0, -0.9), (1.0, 0.9), (-1.0, 0.9)];
            let pane = pane.map(|(x, y)| vec2(x, y) * 0.6);
            scene.add(place(turn, 0.80, -0.02, 0.56), &pane, Look::Glass(tint));
        }
        scene
    }

    /// The vertices in clip space.
    fn seen_by(&self, clip_from_object: Mat4) -> Vec<Vertex<N>> {
        let in_clip_space =
            |v: &Vertex<N>| Vertex { position: clip_from_object * v.position, ..*v };
        self.vertices.iter().map(in_clip_space).collect()
    }

    /// The faces that are glass, of the first so many, in the best order that a z-buffer has: from the farthest
    /// middle to the nearest.
    fn panes(&self, faces: usize, vertices: &[Vertex<N>]) -> Vec<usize> {
        let middle = |&face: &usize| -> f32 {
            let face = &self.faces[face];
            let ws = face.iter().map(|&i| vertices[i as usize].position.w);
            ws.sum::<f32>() / face.len() as f32
        };
        let mut panes: Vec<_> = (self.glass..faces).collect();
        panes.sort_by(|a, b| middle(b).total_cmp(&middle(a)));
        panes
    }

    /// Adds the faces of the model that are transparent, or those that are not.
    fn add_model(&mut self, transparent: bool) {
        for face in self.model.faces() {
            if self.model.materials[face.material].is_transparent() == transparent {
                self.faces.push(face.indices.to_vec());
                self.looks.push(Look::Model(face.material));
            }
        }
    }

    /// Adds a flat face; its texture coordinates go from 0 to 1 between its sides.
    fn add(&mut self, object_from_face: Mat4, outline: &[Vec2], look: Look) {
        let first = self.vertices.len() as u32;
        let normal = object_from_face.transform_vector3(Vec3::Z).normalize_or_zero();
        let (low, high) = outline
            .iter()
            .fold((Vec2::MAX, Vec2::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
        self.vertices.extend(outline.iter().map(|&p| {
            let (color, tangent) = (Vec4::ONE, Vec4::ZERO);
            let surface = Surface { uv: (p - low) / (high - low), normal, color, tangent };
            Vertex::new(object_from_face.transform_point3(p.extend(0.0)).extend(1.0), surface)
        }));
        self.faces.push((first..self.vertices.len() as u32).collect());
        self.looks.push(look);
    }

    /// The colour of a face. What is opaque has the alpha 1, and covers.
    fn shade(&self, face: usize, fragment: &Fragment<'_, N>, lamp: &Lamp) -> Over {
        let surface = Surface::from(fragment.params);
        let color = match self.looks[face] {
            Look::Paint(color) => color,
            Look::Glass(tint) => return glass(tint, surface.uv),
            Look::Model(material) => return shade(self.model, material, fragment, lamp),
        };
        Over((color * lamp.lit(surface.normal.normalize_or_zero(), 1.0)).extend(1.0))
    }
}

/// A pane with a border that is less clear.
fn glass(tint: Vec3, uv: Vec2) -> Over {
    let from_border = uv.min(1.0 - uv).min_element();
    let alpha = if from_border < 0.025 { 0.85 } else { 0.45 };
    Over((tint * alpha).extend(alpha))
}

fn circle(sides: u32, radius: f32) -> Vec<Vec2> {
    let angle = |i| TAU * i as f32 / sides as f32;
    (0..sides).map(|i| Vec2::from_angle(angle(i)) * radius).collect()
}

/// An outline and a smaller one in it, as the one contour that a mesh's faces have: along an edge
/// to the hole, around it in the other direction, and back along the same edge. On the two edges no
/// pixel is lost, since coverage is exact.
fn with_hole(outer: &[Vec2], size: f32) -> Vec<Vec2> {
    let hole = || outer.iter().map(|&p| p * size);
    let first = || outer.iter().take(1).copied();
    outer.iter().copied().chain(first()).chain(hole().take(1)).chain(hole().rev()).collect()
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    view: View,
    output: PathBuf,
    /// Width and height of the scene in pixels.
    size: (u32, u32),
    /// Samples a pixel; `None` is one, at its centre.
    samples: Option<Samples>,
    /// How often each renderer is timed.
    frames: u32,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let (view, output) = (View::default(), PathBuf::from("target/renderers.png"));
        let samples = Some(Samples::Four);
        let mut options = Self { view, output, size: (480, 360), samples, frames: 7 };
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
                    options.size = parser.value()?.parse_with(|text| parse_size(text, 8192))?;
                }
                Arg::Long("samples") => {
                    options.samples = parser.value()?.parse_with(parse_samples)?;
                }
                Arg::Long("frames") => {
                    options.frames =
                        parser.value()?.parse_with(|text| cli::number(text, 1..=1000))?;
                }
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                Arg::Short(_) | Arg::Long(_) => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }

    /// How many samples a pixel has in each direction where all renderers are compared.
    fn samples_in_a_row(&self) -> u32 {
        match self.samples {
            None => 1,
            Some(samples) => (samples.count() as f32).sqrt().ceil() as u32,
        }
    }
}

fn parse_samples(text: &str) -> Result<Option<Samples>, &'static str> {
    Ok(match text {
        "1" => None,
        "4" => Some(Samples::Four),
        "8" => Some(Samples::Eight),
        "16" => Some(Samples::Sixteen),
        _ => return Err("there may be 1, 4, 8 or 16"),
    })
}
