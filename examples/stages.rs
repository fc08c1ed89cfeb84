//! The stages of scan conversion, joined by hand: no renderer, and no framebuffer until the file is
//! written.
//!
//! A cube of bricks with a round window in each face, and one corner cut off by a plane, goes through
//! the stages face by face, to an array of colours and one of depths that belong to the example. For
//! one of the faces a table shows what each stage was given and what it made of that.
//!
//! ```text
//! cargo run --release --example stages
//! cargo run --release --example stages -- --face 6
//! ```

use std::error::Error;
use std::f32::consts::TAU;
use std::path::PathBuf;
use std::process::ExitCode;

use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::camera::{Camera, Sphere};
use polyscan::clip::{ClippedOutline, Clipper};
use polyscan::coverage::EdgeTable;
use polyscan::fragment::LANES;
use polyscan::glam::{Mat4, Vec2, Vec3, Vec4, vec2, vec3, vec4};
use polyscan::subpixel::{SUBPIXELS, SubpixelPoint};
use polyscan::texture::Filter;
use polyscan::{ClipPlane, Framebuffer, Level, Settings, Surface, Texture, Vertex, Viewport};

mod cli;

const HELP: &str = "\
Draw a cube by the stages of scan conversion, and show what they make of one of its faces.

Usage: stages [OPTIONS]

Options:
      --face <NUMBER>  The face that the table is about, from 1 to 6: front, right, top, back, left,
                       bottom [default: 1]
      --output <FILE>  The PNG file to write [default: target/stages.png]
      --size <PIXELS>  Width and height of the picture, from 16 to 8192 [default: 480]
  -h, --help           Show this help
";

/// The face of a cube: where its middle is, and where a texture on it goes right and up.
const FACES: [[Vec3; 3]; 6] = [
    [Vec3::Z, Vec3::X, Vec3::Y],
    [Vec3::X, Vec3::NEG_Z, Vec3::Y],
    [Vec3::Y, Vec3::X, Vec3::NEG_Z],
    [Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y],
    [Vec3::NEG_X, Vec3::Z, Vec3::Y],
    [Vec3::NEG_Y, Vec3::X, Vec3::Z],
];

/// The colour behind the cube, in linear light.
const BACKGROUND: Vec3 = vec3(0.68, 0.76, 0.82);

fn main() -> ExitCode {
    cli::run(draw_cube)
}

fn draw_cube() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let size = options.size;
    let bricks = Texture::from_fn(64, 64, brick)?.with_filter(Filter::Nearest);

    let sphere = Sphere { centre: Vec3::ZERO, radius: 3_f32.sqrt() };
    let camera = Camera::around(sphere, 1.0).turned(0.6, 0.5);
    let clip_from_object = camera.clip_from_object();
    let lamp = (camera.axes() * vec3(-0.5, 0.7, 1.0)).normalize();

    let mut settings = Settings::new(Viewport::new(size, size)?);
    // What is kept of the cube: x + y + z <= 1.6. The inverse transpose takes planes to clip space.
    let object_plane = vec4(-1.0, -1.0, -1.0, 1.6);
    let plane = clip_from_object.inverse().transpose() * object_plane;
    settings.planes.push(ClipPlane::new(plane));

    let mut stages = Stages::default();
    let mut picture = Picture::new(size);
    for (number, [middle, right, up]) in (1..).zip(FACES) {
        let polygon = face_with_window([middle, right, up], clip_from_object);
        let light = 0.25 + 0.75 * middle.dot(lamp).max(0.0);
        let report = stages.draw(&settings, &polygon, &mut picture, |uv, is_front| {
            // Inside the cube there is little light.
            bricks.sample(uv).truncate() * if is_front { light } else { 0.12 }
        });
        if number == options.face {
            println!("Face {number}, stage by stage:\n");
            report.print();
        }
    }

    cli::make_folder_of(&options.output)?;
    Framebuffer::from_parts(size, picture.colors, picture.depths)?.save_png(&options.output)?;
    println!("\nwrote the cube to {}", options.output.display());
    Ok(())
}

// -------------------------------------------------------------------------------------- the stages

/// The pixels that are drawn to: a colour and a depth each, row by row from the top.
struct Picture {
    width: usize,
    colors: Vec<Vec3>,
    depths: Vec<f32>,
}

impl Picture {
    fn new(size: u32) -> Self {
        let width = size as usize;
        let (colors, depths) = (vec![BACKGROUND; width * width], vec![1.0; width * width]);
        Self { width, colors, depths }
    }
}

/// The stages, each with the memory that it works in.
#[derive(Default)]
struct Stages {
    clipper: Clipper<2>,
    points: Vec<SubpixelPoint>,
    edges: EdgeTable,
    surface: Surface<2>,
}

impl Stages {
    /// Draws a polygon of one or more contours with texture coordinates as its parameters. `shade`
    /// is given these, and whether the polygon is seen from the front.
    fn draw(
        &mut self,
        settings: &Settings<2>,
        polygon: &[Vec<Vertex<2>>],
        picture: &mut Picture,
        shade: impl Fn(Vec2, bool) -> Vec3,
    ) -> Report {
        let mut report = Report::of(polygon);
        let Self { clipper, points, edges, surface } = self;

        // Clip: the part of the polygon in front of all planes, in homogeneous space.
        let planes = settings.all_planes();
        let clipped = clipper.clip_outline(polygon, &planes, &settings.interpolation);
        let ClippedOutline::Chains { vertices, chains } = clipped else { return report };
        (report.clipped, report.chains) = (vertices.len(), chains.len());

        // Project: divide by w, and round to the grid of subpixels. From here on coverage is exact.
        points.clear();
        points.extend(
            vertices.iter().map(|v| SubpixelPoint::project(v.position, &settings.viewport)),
        );
        report.points.clone_from(points);

        // Cover: which pixels are inside the outline, as runs in each row.
        edges.fill_rule = settings.fill_rule;
        edges.fill_chains(points, chains, 0..settings.viewport.rect().height as i32);

        // Fit: planes over the screen, through depth, 1/w and the parameters.
        if !surface.fit(settings, vertices, chains) {
            return report;
        }

        let level = Level::new();
        for run in edges.runs() {
            report.runs += 1;
            // Span: the values at the run's first pixel, and their change per pixel.
            let Some(span) = surface.span(&run) else { continue };
            report.add_span(span.row(), span.columns());
            // Fragments: sixteen at a time; one reciprocal each brings the parameters back.
            span.for_each_block(level, |block| {
                let (x, y) = block.position(0);
                let first = y as usize * picture.width + x as usize;
                let colors = &mut picture.colors[first..];
                let depths = &mut picture.depths[first..];
                report.blocks += 1;
                report.fragments += block.visible.count_ones() as usize;
                for (lane, (color, depth)) in colors.iter_mut().zip(depths).take(LANES).enumerate()
                {
                    // The last block of a span may reach beyond its end.
                    let is_visible = block.visible >> lane & 1 == 1;
                    // Test: only what is nearer than all before is drawn.
                    if is_visible && block.depth[lane] < *depth {
                        let uv = vec2(block.params[0][lane], block.params[1][lane]);
                        *color = shade(uv, block.front_facing);
                        *depth = block.depth[lane];
                        report.drawn += 1;
                    }
                }
            });
        }
        report
    }
}

// --------------------------------------------------------------------------------------- the table

/// What each stage has made of a polygon.
struct Report {
    contours: usize,
    vertices: usize,
    /// The least and the greatest w of the vertices.
    w: (f32, f32),
    /// Vertices after clipping, and the chains that they make.
    clipped: usize,
    chains: usize,
    points: Vec<SubpixelPoint>,
    runs: usize,
    spans: usize,
    /// The row and the columns of the longest span.
    longest: (i32, std::ops::Range<i32>),
    blocks: usize,
    fragments: usize,
    drawn: usize,
}

impl Report {
    fn of(polygon: &[Vec<Vertex<2>>]) -> Self {
        let w = || polygon.iter().flatten().map(|v| v.position.w);
        Self {
            contours: polygon.len(),
            vertices: w().count(),
            w: (w().fold(f32::MAX, f32::min), w().fold(f32::MIN, f32::max)),
            clipped: 0,
            chains: 0,
            points: Vec::new(),
            runs: 0,
            spans: 0,
            longest: (0, 0..0),
            blocks: 0,
            fragments: 0,
            drawn: 0,
        }
    }

    fn add_span(&mut self, row: i32, columns: std::ops::Range<i32>) {
        self.spans += 1;
        if columns.len() > self.longest.1.len() {
            self.longest = (row, columns);
        }
    }

    fn print(&self) {
        let line = |stage: &str, made: usize, of: &str, remark: String| {
            println!("{stage:8} {made:7} {of:15} {remark}");
        };
        let (near, far) = self.w;
        let contours = format!("{} contours, w from {near:.3} to {far:.3}", self.contours);
        line("polygon", self.vertices, "vertices", contours);
        let chains = format!("{} chains, which are closed together", self.chains);
        line("clip", self.clipped, "vertices", chains);
        let pixel = |p: &SubpixelPoint| [p.x, p.y].map(|v| f64::from(v) / f64::from(SUBPIXELS));
        let place = |p| {
            let [x, y] = pixel(p);
            format!("the first at x = {x:.3}, y = {y:.3} pixels")
        };
        let first = self.points.first().map(place).unwrap_or_default();
        line("project", self.points.len(), "subpixel points", first);
        line("cover", self.runs, "runs", "of pixels between two edges in a row".to_owned());
        let (row, columns) = &self.longest;
        let longest = format!("the longest in row {row}, columns {columns:?}");
        line("span", self.spans, "spans", longest);
        let lanes = 100 * self.fragments / (self.blocks * LANES).max(1);
        let blocks = format!("in {} blocks; {lanes}% of the lanes are in use", self.blocks);
        line("evaluate", self.fragments, "fragments", blocks);
        line("test", self.drawn, "pixels", "nearer than what was drawn before".to_owned());
    }
}

// ---------------------------------------------------------------------------------------- the cube

/// A square face with a round window: two contours in clip space.
fn face_with_window([middle, right, up]: [Vec3; 3], clip_from_object: Mat4) -> [Vec<Vertex<2>>; 2] {
    let vertex = |p: Vec2| {
        let position = middle + p.x * right + p.y * up;
        // From -1 to 1 upwards to from 0 to 1 downwards.
        let uv = vec2(1.0 + p.x, 1.0 - p.y) / 2.0;
        Vertex::new(clip_from_object * position.extend(1.0), uv)
    };
    let square = [vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0)];
    // It runs against the square's direction, and so takes the square's inside back.
    let circle = (0..24).map(|i| Vec2::from_angle(-TAU * i as f32 / 24.0) * 0.6);
    [square.map(vertex).to_vec(), circle.map(vertex).collect()]
}

/// A texel of a wall of bricks, each 16 texels wide and 8 high, in linear light.
fn brick(x: u32, y: u32) -> Vec4 {
    let row = y / 8;
    let along = x + row % 2 * 8;
    if y.is_multiple_of(8) || along.is_multiple_of(16) {
        return vec4(0.6, 0.57, 0.5, 1.0);
    }
    // Not two beside each other are alike.
    let shade = 0.8 + 0.1 * ((along / 16 % 4 * 3 + row * 5) % 4) as f32;
    vec4(0.55 * shade, 0.15 * shade, 0.07 * shade, 1.0)
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    /// The number of the face that the table is about, from 1.
    face: u32,
    output: PathBuf,
    /// Width and height of the picture, in pixels.
    size: u32,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self { face: 1, output: PathBuf::from("target/stages.png"), size: 480 };
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Long("face") => {
                    options.face = parser.value()?.parse_with(|text| cli::number(text, 1..=6))?;
                }
                Arg::Long("output") => options.output = cli::png(parser.value()?)?,
                Arg::Long("size") => {
                    options.size =
                        parser.value()?.parse_with(|text| cli::number(text, 16..=8192))?;
                }
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                _ => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}
