//! Bakes how much of the sky each place on a model sees, ambient occlusion, into a texture of its own, and
//! draws the model with it.
//!
//! Each face of the model gets a place in the texture: that is its second, (u, v) plane. The mesh is
//! scan-converted there, so that each texel knows where on the model it is. Then the model is drawn, depth
//! alone, from many directions all around: what a direction does not see lies in its shadow.
//!
//! ```text
//! cargo run --release --example bake -- examples/assets/cottage.obj
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressIterator as _, ProgressStyle};
use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::bake::{self, Baker};
use polyscan::glam::{Mat4, Vec2, Vec3, Vec4, vec2, vec3};
use polyscan::model::Model;
use polyscan::obj::Loader;
use polyscan::texture::{Filter, Samples, Texture};
use polyscan::{DepthBias, Framebuffer, Mesh, Vertex, ZBufferRenderer, record};

mod cli;
#[expect(dead_code, reason = "other examples have lamps and materials")]
mod studio;

use studio::{View, parse_degrees, parse_size, parse_up};

const HELP: &str = "\
Bake the ambient occlusion of a model into a texture, and draw the model with it.

Usage: bake [OPTIONS] [MODEL]

Arguments:
  [MODEL]  The OBJ file [default: examples/assets/cottage.obj]

Options:
      --yaw <DEGREES>        Turn of the camera around the model, to the right [default: 30]
      --pitch <DEGREES>      Height of the camera over the model's level [default: 20]
      --up <AXIS>            The axis of the model that is up: y, z, -y and so on [default: y]
      --output <FILE>        The PNG file to write [default: target/bake.png]; the texture goes
                             beside it, as target/bake_texture.png
      --size <SIZE>          Width and height of the picture, up to 8192 each [default: 800x600]
      --texture <PIXELS>     Width and height of the texture, from 64 to 16384 [default: 1024]
      --directions <NUMBER>  From how many the model is seen, from 1 to 4096 [default: 256]
  -h, --help                 Show this help
";

/// Each pixel is the mean of this many samples in x and in y.
const SAMPLES: u32 = 3;
/// The size of a picture from one of the directions.
const SHADOW_MAP: u32 = 1024;
/// By how many texels the border of each face is continued.
const MARGIN: u32 = 2;

record! {
    /// A place on the model's surface.
    struct Surfel {
        place: Vec3,
        normal: Vec3,
    }
}

fn main() -> ExitCode {
    cli::run(bake_model)
}

fn bake_model() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let model = studio::load(&Loader::new(), &options.view.model)?;
    let atlas = Atlas::of(&model, options.texture)?;
    println!(
        "{} faces, at {:.1} texels for a hundredth of the model",
        atlas.faces.len(),
        atlas.scale * radius(&model) / 50.0
    );

    let start = Instant::now();
    let mut baker = Baker::<{ Surfel::LEN }>::new(options.texture, options.texture)?;
    baker.margin = MARGIN;
    let vertices = atlas.vertices();
    let baked = baker
        .bake(Mesh::new(&vertices, &atlas.faces), None, |texel| Some(Surfel::from(texel.params)))?;
    println!(
        "{} texels scan-converted in {:.0?}, {} pairs of faces overlap",
        baked.covered(),
        start.elapsed(),
        baked.overlaps.len()
    );
    let light = sky_light(&model, baked.texels.color(), options.directions, options.view.up)?;
    let texture = Texture::from_samples(options.texture, options.texture, 1, Samples::F32(light))?
        .with_filter(Filter::Bilinear);

    cli::make_folder_of(&options.output)?;
    let picture = draw(&model, &atlas, &texture, &options)?;
    picture.save_png(&options.output)?;
    let name = options.output.file_stem().unwrap_or_default().to_string_lossy();
    let beside = options.output.with_file_name(format!("{name}_texture.png"));
    let colors = texture.texels().map(Vec4::truncate).collect();
    let depths = vec![1.0; (options.texture * options.texture) as usize];
    Framebuffer::from_parts(options.texture, colors, depths)?.save_png(&beside)?;
    println!("wrote {} and {}", options.output.display(), beside.display());
    Ok(())
}

fn radius(model: &Model) -> f32 {
    model.bounding_sphere().map_or(1.0, |sphere| sphere.radius)
}

// ------------------------------------------------------------------------------------------- atlas

/// The faces of a model, each at a place of its own in a texture.
struct Atlas {
    /// For each corner of each face: its place in the texture, from 0 to 1.
    uv: Vec<Vec2>,
    surfels: Vec<(Vec3, Vec3)>,
    faces: Vec<Vec<u32>>,
    /// Texels per unit of the model.
    scale: f32,
}

/// A face in its own plane.
struct Chart {
    corners: Vec<Vec2>,
    size: Vec2,
}

impl Atlas {
    /// Puts the faces into rows, the highest first, at the largest scale at which there is room for all.
    fn of(model: &Model, size: u32) -> Result<Self, Box<dyn Error>> {
        let (mut charts, mut surfels, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        for face in model.faces() {
            let places: Vec<_> =
                face.indices.iter().map(|&i| model.vertices[i as usize].position).collect();
            let next = places.iter().cycle().skip(1);
            let area = |(a, b): (&Vec3, &Vec3)| (*a - places[0]).cross(*b - places[0]);
            let normal = places.iter().zip(next).map(area).sum::<Vec3>().normalize_or_zero();
            if normal == Vec3::ZERO {
                continue;
            }
            let first = surfels.len() as u32;
            faces.push((first..first + places.len() as u32).collect());
            surfels.extend(places.iter().map(|place| (*place, normal)));
            charts.push(Chart::of(&places, normal));
        }
        let mut order: Vec<usize> = (0..charts.len()).collect();
        order.sort_by(|&a, &b| charts[b].size.y.total_cmp(&charts[a].size.y));
        let area: f32 = charts.iter().map(|chart| chart.size.x * chart.size.y).sum();
        let mut scale = size as f32 / area.sqrt().max(f32::MIN_POSITIVE);
        for _ in 0..200 {
            if let Some(uv) = packed(&charts, &order, scale, size) {
                return Ok(Self { uv, surfels, faces, scale });
            }
            scale *= 0.97;
        }
        Err("the texture is too small for so many faces: give --texture a larger number".into())
    }

    /// The mesh in the plane of the texture.
    fn vertices(&self) -> Vec<Vertex<{ Surfel::LEN }>> {
        let each = self.uv.iter().zip(&self.surfels);
        each.map(|(&uv, &(place, normal))| bake::vertex(uv, Surfel { place, normal })).collect()
    }
}

impl Chart {
    fn of(places: &[Vec3], normal: Vec3) -> Self {
        // Along the longest side, so that it takes little room.
        let sides = places.iter().zip(places.iter().cycle().skip(1)).map(|(a, b)| *b - *a);
        let longest = sides.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let x = longest.unwrap_or(Vec3::X).normalize_or(Vec3::X);
        let y = normal.cross(x);
        let corners: Vec<_> = places.iter().map(|p| vec2(p.dot(x), p.dot(y))).collect();
        let least = corners.iter().copied().fold(Vec2::INFINITY, Vec2::min);
        let greatest = corners.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
        let corners = corners.iter().map(|corner| corner - least).collect();
        Self { corners, size: greatest - least }
    }
}

/// The places of all corners in the texture, if there is room at a scale.
fn packed(charts: &[Chart], order: &[usize], scale: f32, size: u32) -> Option<Vec<Vec2>> {
    let ends: Vec<usize> = charts
        .iter()
        .scan(0, |end, chart| {
            *end += chart.corners.len();
            Some(*end)
        })
        .collect();
    let mut uv = vec![Vec2::ZERO; *ends.last()?];
    // A texel that one face touches is no other's.
    let (mut at, mut row, gap) = (Vec2::splat(1.0), 0.0f32, 1.0 + MARGIN as f32);
    for &i in order {
        let chart = &charts[i];
        let room = (chart.size * scale).ceil() + gap;
        if at.x + room.x > size as f32 {
            at = vec2(1.0, at.y + row);
            row = 0.0;
        }
        if at.x + room.x > size as f32 || at.y + room.y > size as f32 {
            return None;
        }
        let first = ends[i] - chart.corners.len();
        for (uv, corner) in uv[first..].iter_mut().zip(&chart.corners) {
            *uv = (at + *corner * scale) / size as f32;
        }
        at.x += room.x;
        row = row.max(room.y);
    }
    Some(uv)
}

// ------------------------------------------------------------------------------------------- light

/// How much of the sky each texel sees, weighted by the cosine; 1 where all of it.
fn sky_light(
    model: &Model,
    texels: &[Option<Surfel>],
    directions: u32,
    up: Vec3,
) -> Result<Vec<f32>, Box<dyn Error>> {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} directions, {eta} left")?;
    let bar = ProgressBar::new(directions.into()).with_style(style);
    // Texels where there is a surface: their numbers, with how much of the sky there is to see, and is seen.
    let lit = texels.iter().enumerate().filter_map(|(i, texel)| Some((i, (*texel)?)));
    let mut lit: Vec<_> = lit.map(|(i, surfel)| (i, surfel, 0.0, 0.0)).collect();
    let mut map = Framebuffer::new(SHADOW_MAP, SHADOW_MAP, ())?;
    // Lifted off the surface by as much as a texel of the map may be wide.
    let lift = radius(model) * 4.0 / SHADOW_MAP as f32;
    for i in (0..directions).progress_with(bar) {
        let direction = spread(i, directions);
        // The sky is brighter above than what the ground sends back from below.
        let sky = 0.6 + 0.4 * direction.dot(up);
        let seen_from = view_from(model, direction);
        draw_depths(&mut map, model, seen_from);
        for (_, Surfel { place, normal }, whole, seen) in &mut lit {
            let cosine = normal.dot(direction);
            if cosine > 0.0 {
                *whole += cosine * sky;
                let at = seen_from.transform_point3(*place + *normal * lift);
                let [x, y] = [at.x, -at.y].map(|c| (0.5 + 0.5 * c) * SHADOW_MAP as f32);
                let is_seen = map.pixel(x as u32, y as u32).is_none_or(|(_, depth)| at.z <= depth);
                *seen += if is_seen { cosine * sky } else { 0.0 };
            }
        }
    }
    let mut light = vec![0.0; texels.len()];
    for (i, _, whole, seen) in lit {
        light[i] = if whole > 0.0 { seen / whole } else { 0.0 };
    }
    Ok(light)
}

/// One of many directions that are spread evenly: along a spiral from pole to pole.
fn spread(i: u32, count: u32) -> Vec3 {
    let y = 1.0 - (2.0 * i as f32 + 1.0) / count as f32;
    // By the golden angle, in radians.
    let turn = Vec2::from_angle(2.399_963_2 * i as f32) * (1.0 - y * y).sqrt();
    vec3(turn.x, y, turn.y)
}

/// All of the model as it is seen from far away.
fn view_from(model: &Model, direction: Vec3) -> Mat4 {
    let (side, above) = direction.any_orthonormal_pair();
    let centre = model.bounding_sphere().map_or(Vec3::ZERO, |sphere| sphere.centre);
    let view = Mat4::from_cols(
        side.extend(0.0),
        above.extend(0.0),
        (-direction).extend(0.0),
        Vec3::ZERO.extend(1.0),
    )
    .transpose();
    // The sphere around the model, its depths from 0 to 1.
    let scale = 1.0 / (1.01 * radius(model));
    Mat4::from_translation(vec3(0.0, 0.0, 0.5))
        * Mat4::from_scale(vec3(scale, scale, 0.5 * scale))
        * view
        * Mat4::from_translation(-centre)
}

fn draw_depths(map: &mut Framebuffer<()>, model: &Model, clip_from_object: Mat4) {
    let vertices: Vec<Vertex<0>> = model.vertices_with(clip_from_object, |_| []);
    let mut renderer = ZBufferRenderer::new(map.viewport());
    renderer.settings.depth_bias = DepthBias { constant: 1e-4, slope: 1.0 };
    renderer.clear(map, ());
    renderer.draw_depth(map, Mesh::new(&vertices, model.faces()));
}

// ----------------------------------------------------------------------------------------- picture

/// The model in the light that was baked, white.
fn draw(
    model: &Model,
    atlas: &Atlas,
    texture: &Texture,
    options: &Options,
) -> Result<Framebuffer<Vec3>, Box<dyn Error>> {
    let (width, height) = options.size;
    let paper = vec3(0.68, 0.76, 0.82);
    let mut frame = Framebuffer::new(width * SAMPLES, height * SAMPLES, paper)?;
    let camera = options.view.turned(model.camera(width as f32 / height as f32));
    let matrix = camera.clip_from_object();
    let each = atlas.uv.iter().zip(&atlas.surfels);
    let vertices: Vec<_> =
        each.map(|(&uv, (place, _))| Vertex::new(matrix * place.extend(1.0), uv)).collect();
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.draw(&mut frame, Mesh::new(&vertices, &atlas.faces), |fragment| {
        let light = texture.sample(Vec2::from(fragment.params)).x;
        vec3(0.95, 0.93, 0.89) * light
    });
    Ok(frame.downsampled(SAMPLES)?)
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    view: View,
    output: PathBuf,
    size: (u32, u32),
    texture: u32,
    directions: u32,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            view: View::default(),
            output: "target/bake.png".into(),
            size: (800, 600),
            texture: 1024,
            directions: 256,
        };
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            let view = &mut options.view;
            match arg {
                Arg::Value(model) => view.model = model.into(),
                Arg::Long("yaw") => view.yaw = parser.value()?.parse_with(parse_degrees)?,
                Arg::Long("pitch") => view.pitch = parser.value()?.parse_with(parse_degrees)?,
                Arg::Long("up") => view.up = parser.value()?.parse_with(parse_up)?,
                Arg::Long("output") => options.output = cli::png(parser.value()?)?,
                Arg::Long("size") => {
                    options.size = parser.value()?.parse_with(|text| parse_size(text, 8192))?;
                }
                Arg::Long("texture") => {
                    options.texture =
                        parser.value()?.parse_with(|text| cli::number(text, 64..=16384))?;
                }
                Arg::Long("directions") => {
                    options.directions =
                        parser.value()?.parse_with(|text| cli::number(text, 1..=4096))?;
                }
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                Arg::Short(_) | Arg::Long(_) => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}
