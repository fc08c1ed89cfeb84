//! Writes what a data set for machine learning has: of a model on a floor, seen from many places, the colour, and
//! the distance, the face, the normal and the texture coordinates of each pixel.
//!
//! Distances, faces, normals and texture coordinates come from one `Visibility`: at each pixel they are those of
//! one face, at the pixel's centre. The colour is drawn by a `MultisampleRenderer` from the same vertices, with
//! eight samples a pixel, so at the edges it is a mixture of several faces'. The distances of the floor are held
//! against the equation of its plane, at every pixel.
//!
//! For each pose, such as 0003, there are five PNG files:
//!
//! - `0003_color.png`: sRGB of 8 bits.
//! - `0003_depth.png`: grey of 16 bits, the distance along the direction of view in millimetres; 0 is nothing.
//! - `0003_ids.png`: R + 256 G + 65536 B is 1 more than the number of the face, as in the panoptic annotations
//!   of COCO; the last face is the floor, 0 is nothing.
//! - `0003_normals.png`: RGB of 16 bits, each (n + 1) / 2 of 65535, where x is to the right, y up, z towards the
//!   camera; all 0 is nothing.
//! - `0003_uv.png`: RGB of 16 bits, u and v of 65535, and blue where the face has them.
//!
//! `cameras.json` has the lens, in pixels from the picture's top left corner, and of each pose the matrix that takes
//! camera space, with the axes of the normals, to the model's; `sheet.png` shows the first pose.
//!
//! ```text
//! cargo run --release --example datasets
//! cargo run --release --example datasets -- --poses 100 --size 320x240 --output target/hundred
//! ```

use std::error::Error;
use std::f32::consts::TAU;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::iter::Sum;
use std::ops::{Mul, RangeInclusive};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressIterator as _, ProgressStyle};
use lexopt::{Arg, Parser, ValueExt as _};
use png::{BitDepth, ColorType};
use polyscan::camera::{Camera, Sphere};
use polyscan::color::{Color, decode};
use polyscan::glam::{DVec3, Mat4, Vec2, Vec3, Vec4, vec2};
use polyscan::model::{Model, ModelVertex};
use polyscan::obj::Loader;
use polyscan::render::{
    MultisampleFramebuffer, MultisampleRenderer, Over, Product, Samples, Visibility,
    VisibilityRenderer,
};
use polyscan::texture::{MipFilter, Texture};
use polyscan::{Framebuffer, Mesh, Vertex};

#[expect(dead_code, reason = "other examples write one picture, which is given a name")]
mod cli;
#[expect(dead_code, reason = "other examples have one view, and glass")]
mod studio;

use studio::{Lamp, Surface, parse_size, parse_up, shade};

const HELP: &str = "\
Write colour, depth, ids, normals and texture coordinates of a model on a floor, seen from many places.

Usage: datasets [OPTIONS] [MODEL]

Arguments:
  [MODEL]  The OBJ file [default: examples/assets/cottage.obj]

Options:
      --poses <NUMBER>   From how many places the model is seen, from 1 to 9999 [default: 8]
      --size <SIZE>      Width and height in pixels, up to 4096 each [default: 640x480]
      --output <FOLDER>  Where the pictures go [default: target/datasets]
      --metres <LENGTH>  Length of the model's unit in metres [default: 1]
      --up <AXIS>        The axis of the model that is up: y, z, -y and so on [default: y]
  -h, --help             Show this help
";

const SAMPLES: Samples = Samples::Eight;
/// Corners of the floor.
const SIDES: u16 = 24;
/// How much larger the floor is than the sphere around the model.
const FLOOR: f32 = 1.25;
/// Squares of the floor along its diameter.
const SQUARES: u32 = 20;
/// Angles between the direction of view and the floor, in degrees.
const PITCH: RangeInclusive<f32> = 15.0..=65.0;
/// The most that the coordinates of clip space are off: some eight roundings of `f32` on the way there, each of
/// half a unit in the last place, as parts of the distance.
const ROUNDING: f64 = 8.0 / (1 << 24) as f64;
/// Corners of faces are rounded to this many parts of a pixel.
const SUBPIXELS: f64 = 256.0;

fn main() -> ExitCode {
    cli::run(write_data_set)
}

fn write_data_set() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let model = studio::load(&Loader::new(), &options.model)?;
    if model.has_transparency() {
        eprintln!("warning: what is transparent is drawn as if it were not");
    }
    let scene = Scene::new(&model, options.up)?;
    let cameras: Vec<_> = (0..options.poses).map(|i| scene.camera(i, &options)).collect();
    scene.check_distances(&options)?;
    cli::make_folder_of(&options.output.join("cameras.json"))?;

    let bar = ProgressBar::new(options.poses.into())
        .with_style(ProgressStyle::with_template("{bar:40} {pos}/{len} poses, {eta} left")?);
    let mut checked = Checked::default();
    for (i, camera) in cameras.iter().enumerate().progress_with(bar) {
        let shot = Shot::new(&scene, camera, &options)?;
        shot.check_floor(&mut checked).map_err(|error| format!("pose {i}: {error}"))?;
        shot.save(&options.output, &name(i))?;
        if i == 0 {
            shot.sheet()?.save_png(options.output.join("sheet.png"))?;
        }
    }
    save(
        &options.output.join("cameras.json"),
        cameras_json(&cameras, &model, &options)?.as_bytes(),
    )?;

    let Checked { pixels, depth, w } = checked;
    println!("{}: {} faces and a floor", options.model.display(), model.face_count());
    println!(
        "the floor's distance at {pixels} pixels against its plane: off by {depth:.3} mm at most, \
         {w:.4} mm before it is rounded to millimetres"
    );
    let poses = if options.poses == 1 { "pose" } else { "poses" };
    println!("wrote {} {poses} to {}", options.poses, options.output.display());
    Ok(())
}

fn name(pose: usize) -> String {
    format!("{pose:04}")
}

// ------------------------------------------------------------------------------------------- scene

/// A model on a floor, in object space. The last face is the floor.
struct Scene<'a> {
    model: &'a Model,
    places: Vec<Vec3>,
    surfaces: Vec<Surface>,
    faces: Vec<Vec<u32>>,
    /// The material of each face of the model.
    materials: Vec<usize>,
    /// Whether each face has texture coordinates.
    has_uv: Vec<bool>,
    /// The floor's look.
    checkers: Texture,
    /// The floor is where the product of a place and `up` is `level`.
    up: Vec3,
    level: f32,
    /// It holds all faces.
    sphere: Sphere,
    lamp: Lamp,
}

impl<'a> Scene<'a> {
    fn new(model: &'a Model, up: Vec3) -> Result<Self, Box<dyn Error>> {
        let nothing = Sphere { centre: Vec3::ZERO, radius: 1.0 };
        let Sphere { centre, radius } = model.bounding_sphere().unwrap_or(nothing);
        let places: Vec<Vec3> = model.vertices.iter().map(|v| v.position).collect();
        let least = places.iter().map(|place| place.dot(up)).fold(f32::INFINITY, f32::min);
        let level = if least.is_finite() { least } else { 0.0 };
        let below = centre.dot(up) - level;
        let sphere = Sphere { centre, radius: radius.max(below.hypot(FLOOR * radius)) };

        let surface = |v: &ModelVertex| Surface {
            uv: v.uv,
            normal: v.normal,
            color: v.color,
            tangent: v.tangent,
        };
        let mut scene = Self {
            model,
            places,
            surfaces: model.vertices.iter().map(surface).collect(),
            faces: model.faces().map(|face| face.indices.to_vec()).collect(),
            materials: model.faces().map(|face| face.material).collect(),
            has_uv: model.faces().map(|face| face.has_uv).collect(),
            checkers: checkers()?,
            up,
            level,
            sphere,
            lamp: Lamp::beside(&Camera::around(sphere, 1.0).with_up(up).turned(0.5, 0.7)),
        };
        if scene.faces.len() >= 0xFF_FFFF {
            let faces = scene.faces.len();
            return Err(
                format!("the model has {faces} faces, more than 24 bits of ids can say").into()
            );
        }
        scene.add_floor(centre - up * below, FLOOR * radius);
        Ok(scene)
    }

    fn add_floor(&mut self, middle: Vec3, radius: f32) {
        let first = self.places.len() as u32;
        let (x, y) = self.up.any_orthonormal_pair();
        for i in 0..SIDES {
            let at = Vec2::from_angle(TAU * f32::from(i) / f32::from(SIDES));
            self.places.push(middle + (x * at.x + y * at.y) * radius);
            let uv = vec2(0.5 + 0.5 * at.x, 0.5 - 0.5 * at.y);
            let (color, tangent) = (Vec4::ONE, Vec4::ZERO);
            self.surfaces.push(Surface { uv, normal: self.up, color, tangent });
        }
        self.faces.push((first..self.places.len() as u32).collect());
        self.has_uv.push(true);
    }

    /// One of many cameras that are spread evenly, along a spiral upwards.
    fn camera(&self, pose: u32, options: &Options) -> Camera {
        let [low, high] = [PITCH.start(), PITCH.end()].map(|degrees| degrees.to_radians().sin());
        let height = low + (high - low) * (pose as f32 + 0.5) / options.poses as f32;
        // By the golden angle, in radians.
        let yaw = (0.5 + 2.399_963_2 * pose as f32) % TAU;
        Camera::around(self.sphere, options.aspect()).with_up(options.up).turned(yaw, height.asin())
    }

    /// Whether 16 bits have room for all distances.
    fn check_distances(&self, options: &Options) -> Result<(), Box<dyn Error>> {
        let to_centre = self.camera(0, options).position().distance(self.sphere.centre);
        let (near, far) = (to_centre - self.sphere.radius, to_centre + self.sphere.radius);
        // Not all of what is near the sphere is in it: a hundredth for rounding.
        let [near, far] = [near * 0.99, far * 1.01].map(|distance| distance * options.metres);
        if near >= 0.001 && far <= 65.534 {
            return Ok(());
        }
        let better: f32 = format!("{:.0e}", options.metres * 20.0 / far).parse()?;
        Err(format!(
            "the scene is from {near} to {far} metres away, but 16 bits of millimetres reach from 0.001 to 65.534: \
             choose another --metres, such as {better}"
        )
        .into())
    }

    fn vertices(&self, clip_from_object: Mat4) -> Vec<Vertex<{ Surface::LEN }>> {
        let each = self.places.iter().zip(&self.surfaces);
        each.map(|(place, surface)| Vertex::new(clip_from_object * place.extend(1.0), *surface))
            .collect()
    }
}

/// Squares in two greys, in linear light.
fn checkers() -> Result<Texture, Box<dyn Error>> {
    const TEXELS: u32 = 16;
    let side = SQUARES * TEXELS;
    let texture = Texture::from_fn(side, side, |x, y| {
        let grey = if (x / TEXELS + y / TEXELS).is_multiple_of(2) { 0.42 } else { 0.55 };
        Vec3::splat(grey).extend(1.0)
    })?;
    Ok(texture.with_mipmaps()?.with_mip_filter(MipFilter::Anisotropic { probes: 16 }))
}

// ------------------------------------------------------------------------------------------- shots

/// What is seen of a scene by one camera.
struct Shot<'a> {
    scene: &'a Scene<'a>,
    camera: &'a Camera,
    metres: f32,
    size: (u32, u32),
    color: Framebuffer<Vec3>,
    seen: Visibility,
    /// In millimetres.
    distances: Vec<u16>,
}

/// The floor's distances against its plane, in millimetres: the greatest errors.
#[derive(Default)]
struct Checked {
    pixels: u64,
    depth: f64,
    w: f64,
}

impl<'a> Shot<'a> {
    fn new(
        scene: &'a Scene<'a>,
        camera: &'a Camera,
        options: &Options,
    ) -> Result<Self, Box<dyn Error>> {
        let (size, metres) = (options.size, options.metres);
        let vertices = scene.vertices(camera.clip_from_object());
        let products = [Product::W, Product::Barycentrics, Product::Corners];
        let mut seen = Visibility::new(size.0, size.1, &products)?;
        let mut renderer = VisibilityRenderer::new(seen.viewport());
        renderer.draw(&mut seen, Mesh::new(&vertices, &scene.faces));

        let background = Vec3::from([0xd8, 0xe2, 0xea].map(decode));
        let mut frame = MultisampleFramebuffer::new(size.0, size.1, SAMPLES, background)?;
        let mut renderer = MultisampleRenderer::new(frame.viewport());
        renderer.draw(&mut frame, Mesh::new(&vertices, &scene.faces), |fragment| {
            match scene.materials.get(fragment.face as usize) {
                Some(&material) => {
                    let Over(color) = shade(scene.model, material, fragment, &scene.lamp);
                    color.truncate() / color.w.max(f32::MIN_POSITIVE)
                }
                None => {
                    let texel = scene.checkers.sample_footprint(&fragment.footprint(0, 1));
                    let normal = Surface::from(fragment.params).normal.normalize_or_zero();
                    texel.truncate() * scene.lamp.lit(normal, 1.0)
                }
            }
        });
        let distances = seen.distances(1000.0 * metres);
        Ok(Self { scene, camera, metres, size, color: frame.resolve()?, seen, distances })
    }

    /// Holds the floor's distances against where the ray through each pixel's centre meets its plane.
    fn check_floor(&self, checked: &mut Checked) -> Result<(), Box<dyn Error>> {
        let (width, height) = self.size;
        let millimetres = 1000.0 * f64::from(self.metres);
        let axes = self.camera.axes();
        let [right, above, back] = [axes.x_axis, axes.y_axis, axes.z_axis].map(Vec3::as_dvec3);
        let (up, eye) = (self.scene.up.as_dvec3(), self.camera.position().as_dvec3());
        let height_of_eye = eye.dot(up) - f64::from(self.scene.level);
        let farthest =
            eye.distance(self.scene.sphere.centre.as_dvec3()) + f64::from(self.scene.sphere.radius);
        let lens = Lens::new(self.size);
        let floor = self.scene.faces.len() as u32 - 1;
        for i in (0..self.distances.len()).filter(|&i| self.seen.face[i] == floor) {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let [at_x, at_y] =
                [f64::from(x) + 0.5 - lens.middle[0], f64::from(y) + 0.5 - lens.middle[1]];
            let ray = right * (at_x / lens.focal) - above * (at_y / lens.focal) - back;
            let falls = -ray.dot(up);
            let expected = height_of_eye / falls * millimetres;

            let mut rounding = ROUNDING * farthest * millimetres * ray.length() / falls.abs();
            // Where the floor ends, its corners decide, which are rounded to subpixels.
            if self.seen.barycentrics[i].contains(&0.0) {
                let slopes = [right, above].map(|axis| (axis.dot(up) / lens.focal / falls).abs());
                rounding += expected.abs() * (slopes[0] + slopes[1]) / SUBPIXELS;
            }
            let off_by = (f64::from(self.distances[i]) - expected).abs();
            let within = off_by <= 0.5 + rounding;
            if !within {
                return Err(format!(
                    "at pixel ({x}, {y}) of {width}x{height} the floor is {} mm away, but by the equation of its \
                     plane {expected:.3} mm: that is more than half a millimetre and {rounding:.3} mm for rounding",
                    self.distances[i]
                )
                .into());
            }
            checked.pixels += 1;
            checked.depth = checked.depth.max(off_by);
            checked.w = checked.w.max((f64::from(self.seen.w[i]) * millimetres - expected).abs());
        }
        Ok(())
    }

    /// What the vertices of the face at a pixel have, under its weights; `None` where there is no face.
    fn mean<T: Sum + Mul<f32, Output = T>>(
        &self,
        pixel: usize,
        of: impl Fn(&Surface) -> T,
    ) -> Option<T> {
        let corners = self.seen.corners[pixel].iter().zip(self.seen.barycentrics[pixel]);
        let sum =
            || corners.map(|(i, weight)| of(&self.scene.surfaces[*i as usize]) * weight).sum();
        (self.seen.face[pixel] != Visibility::NO_FACE).then(sum)
    }

    fn id(&self, pixel: usize) -> u32 {
        // There is no face where the number is the greatest.
        self.seen.face[pixel].wrapping_add(1)
    }

    fn normal(&self, pixel: usize) -> [u16; 3] {
        let Some(normal) = self.mean(pixel, |surface| surface.normal) else { return [0; 3] };
        let in_camera = self.camera.axes().transpose() * normal.normalize_or_zero();
        in_camera.to_array().map(|n| ((0.5 + 0.5 * n) * 65535.0).round() as u16)
    }

    fn uv(&self, pixel: usize) -> [u16; 3] {
        let has_uv = self.scene.has_uv.get(self.seen.face[pixel] as usize);
        let uv = self.mean(pixel, |surface| surface.uv).filter(|_| has_uv == Some(&true));
        let Some(uv) = uv else { return [0; 3] };
        // Outside of 0 to 1 the picture comes again.
        let inside = |t: f32| if (0.0..=1.0).contains(&t) { t } else { t.rem_euclid(1.0) };
        let [u, v] = uv.to_array().map(|t| (inside(t) * 65535.0).round() as u16);
        [u, v, u16::MAX]
    }

    /// Writes the five pictures.
    fn save(&self, folder: &Path, name: &str) -> Result<(), Box<dyn Error>> {
        let pixels = || 0..self.distances.len();
        let rgb = |color: &Vec3| color.to_srgb8().into_iter().take(3);
        let pictures: [(&str, ColorType, BitDepth, Vec<u8>); 5] = [
            (
                "color",
                ColorType::Rgb,
                BitDepth::Eight,
                self.color.color().iter().flat_map(rgb).collect(),
            ),
            (
                "depth",
                ColorType::Grayscale,
                BitDepth::Sixteen,
                self.distances.iter().flat_map(|d| d.to_be_bytes()).collect(),
            ),
            (
                "ids",
                ColorType::Rgb,
                BitDepth::Eight,
                pixels().flat_map(|i| self.id(i).to_le_bytes().into_iter().take(3)).collect(),
            ),
            (
                "normals",
                ColorType::Rgb,
                BitDepth::Sixteen,
                big_endian(pixels().map(|i| self.normal(i))),
            ),
            ("uv", ColorType::Rgb, BitDepth::Sixteen, big_endian(pixels().map(|i| self.uv(i)))),
        ];
        for (what, color, depth, samples) in pictures {
            let file = encode(self.size, color, depth, &samples)?;
            save(&folder.join(format!("{name}_{what}.png")), &file)?;
        }
        Ok(())
    }

    /// The five pictures side by side, for people: depth from light to dark, ids in colours that differ.
    fn sheet(&self) -> Result<Framebuffer<[u8; 4]>, Box<dyn Error>> {
        let there = || self.distances.iter().filter(|&&d| d > 0).map(|&d| f32::from(d));
        let (near, far) = (there().fold(f32::INFINITY, f32::min), there().fold(0.0, f32::max));
        let color = |i: usize| self.color.color()[i].to_srgb8();
        let depth = |i: usize| {
            let part = (f32::from(self.distances[i]) - near) / (far - near).max(1.0);
            let grey = if self.distances[i] > 0 { (255.0 - 215.0 * part).round() as u8 } else { 0 };
            [grey, grey, grey, 255]
        };
        let ids = |i: usize| {
            // Neighbouring numbers look different; 0 stays black.
            let bits =
                self.id(i).wrapping_mul(0x9E37_79B9).rotate_left(15).wrapping_mul(0x85EB_CA6B);
            let [r, g, b, _] = bits.to_be_bytes();
            [r, g, b, 255]
        };
        let bytes = |[x, y, z]: [u16; 3]| [x, y, z].map(|value| (value >> 8) as u8);
        let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
        let normals = |i: usize| opaque(bytes(self.normal(i)));
        let uv = |i: usize| opaque(bytes(self.uv(i)));

        let tiles: [&dyn Fn(usize) -> [u8; 4]; 5] = [&color, &depth, &ids, &normals, &uv];
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let mut pixels = Vec::with_capacity(tiles.len() * width * height);
        for row in 0..height {
            for tile in tiles {
                pixels.extend((row * width..(row + 1) * width).map(tile));
            }
        }
        let depths = vec![1.0; pixels.len()];
        Ok(Framebuffer::from_parts(self.size.0 * tiles.len() as u32, pixels, depths)?)
    }
}

// ------------------------------------------------------------------------------------------- files

/// A camera's lens, in pixels.
struct Lens {
    /// How many pixels away from the middle a ray is seen that goes as far aside as ahead.
    focal: f64,
    /// The middle, from the top left corner.
    middle: [f64; 2],
}

impl Lens {
    fn new((width, height): (u32, u32)) -> Self {
        let middle = [width, height].map(|side| f64::from(side) / 2.0);
        let half = f64::from(Camera::FIELD_OF_VIEW) / 2.0;
        Self { focal: middle[1] / half.tan(), middle }
    }
}

fn cameras_json(
    cameras: &[Camera],
    model: &Model,
    options: &Options,
) -> Result<String, std::fmt::Error> {
    let (Lens { focal, middle: [x, y] }, (width, height)) = (Lens::new(options.size), options.size);
    let mut json = format!(
        "{{\n  \"width\": {width}, \"height\": {height},\n  \"fx\": {focal}, \"fy\": {focal}, \"cx\": {x}, \
         \"cy\": {y},\n  \"metres\": {},\n  \"poses\": [",
        options.metres
    );
    for (i, camera) in cameras.iter().enumerate() {
        let separator = if i > 0 { "," } else { "" };
        let place: DVec3 = camera.position().as_dvec3() + model.origin;
        let rows = camera.axes().transpose();
        let row = |axis: Vec3, at: f64| format!("[{}, {}, {}, {at}]", axis.x, axis.y, axis.z);
        write!(
            json,
            "{separator}\n    {{\"name\": \"{}\", \"object_from_camera\": [{}, {}, {}]}}",
            name(i),
            row(rows.x_axis, place.x),
            row(rows.y_axis, place.y),
            row(rows.z_axis, place.z)
        )?;
    }
    json += "\n  ]\n}\n";
    Ok(json)
}

/// The bytes of samples as PNG files have them.
fn big_endian(pixels: impl Iterator<Item = [u16; 3]>) -> Vec<u8> {
    pixels.flatten().flat_map(u16::to_be_bytes).collect()
}

fn encode(
    (width, height): (u32, u32),
    color: ColorType,
    depth: BitDepth,
    samples: &[u8],
) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()?;
    Ok(file)
}

/// Writes a file, which gets its name when it is whole.
fn save(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let folder = path.parent().unwrap_or(Path::new("."));
    // By `std`, so that it has the permissions of any new file.
    let create = |path: &Path| File::options().write(true).create_new(true).open(path);
    let file = tempfile::Builder::new().suffix(".part").make_in(folder, create);
    let written = file.and_then(|mut file| {
        file.write_all(bytes)?;
        file.persist(path).map_err(|error| error.error)
    });
    written.map(|_| ()).map_err(|error| format!("cannot write {}: {error}", path.display()))
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    model: PathBuf,
    output: PathBuf,
    poses: u32,
    /// Width and height in pixels.
    size: (u32, u32),
    /// Of the model's unit.
    metres: f32,
    up: Vec3,
}

impl Options {
    fn aspect(&self) -> f32 {
        self.size.0 as f32 / self.size.1 as f32
    }

    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            model: "examples/assets/cottage.obj".into(),
            output: "target/datasets".into(),
            poses: 8,
            size: (640, 480),
            metres: 1.0,
            up: Vec3::Y,
        };
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Value(model) => options.model = model.into(),
                Arg::Long("output") => options.output = parser.value()?.into(),
                Arg::Long("poses") => {
                    options.poses =
                        parser.value()?.parse_with(|text| cli::number(text, 1..=9999))?;
                }
                Arg::Long("size") => {
                    options.size = parser.value()?.parse_with(|text| parse_size(text, 4096))?;
                }
                Arg::Long("metres") => {
                    options.metres = parser.value()?.parse_with(parse_metres)?;
                }
                Arg::Long("up") => options.up = parser.value()?.parse_with(parse_up)?,
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                Arg::Short(_) | Arg::Long(_) => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}

fn parse_metres(text: &str) -> Result<f32, &'static str> {
    let metres = text.parse().ok().filter(|metres: &f32| metres.is_normal() && *metres > 0.0);
    metres.ok_or("give a length in metres, such as 1 or 0.001")
}
