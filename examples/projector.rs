//! A slide projector in a room with pillars, whose shadows fall into the picture that it throws.
//!
//! The slide is a texture whose coordinates are affine on no surface of the room: they are a cluster of parameters
//! with a denominator of its own, the w of the projector's clip space. Behind the projector there is no light. What
//! is in the shadow is found from a depth pass as seen from the projector, with a bias and a filter over several of
//! its texels.
//!
//! ```text
//! cargo run --release --example projector
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use polyscan::glam::{Mat4, Vec2, Vec3, Vec4, vec2, vec3, vec4};
use polyscan::texture::{MipFilter, Texture, Wrap};
use polyscan::{DepthBias, Fragment, Framebuffer, Mesh, Vertex, ZBufferRenderer, record};

mod cli;

const HELP: &str = "\
Draw a room with a slide projector, whose picture has shadows in it.

Usage: projector [OPTIONS]

Options:
      --output <FILE>     The PNG file to write [default: target/projector.png]
      --width <PIXELS>    Width of the picture, from 16 to 4096 [default: 960]
      --shadow <TEXELS>   Width and height of the map of shadows, from 16 to 4096 [default: 1024]
      --filter <TEXELS>   Width of the shadows' filter in texels of the map, from 1 to 15 [default: 5]
  -h, --help              Show this help
";

/// Each pixel is the mean of this many samples in x and in y.
const SAMPLES: u32 = 3;
/// Where the projector stands, and to where it throws its picture.
const PROJECTOR: (Vec3, Vec3) = (vec3(-2.6, 1.9, 3.4), vec3(0.9, 1.6, -4.0));

record! {
    /// What goes from the room's corners to the pixels.
    struct Surface {
        /// Parameters 0 to 3: the place in the projector's clip space.
        slide: Vec4,
        place: Vec3,
        normal: Vec3,
        color: Vec3,
    }
}

/// The numbers of the slide's coordinates x, y and z among the parameters, and of what they are divided by.
const SLIDE: ([usize; 3], usize) = ([0, 1, 2], 3);

fn main() -> ExitCode {
    cli::run(draw)
}

fn draw() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let (eye, target) = PROJECTOR;
    let projector = perspective(0.62, 4.0 / 3.0, 0.6, 30.0) * look_at_mat4(eye, target, Vec3::Y);
    let camera = perspective(0.8, 1.5, 0.1, 50.0)
        * look_at_mat4(vec3(4.6, 3.6, 8.6), vec3(-0.5, 1.35, -1.2), Vec3::Y);
    let room = Room::new();

    // What the projector sees, as depth alone.
    let mut shadows = Framebuffer::new(options.shadow, options.shadow, ())?;
    let mut renderer = ZBufferRenderer::new(shadows.viewport());
    // As much as a surface's depth may change from the middle of the filter to its farthest texel.
    renderer.settings.depth_bias =
        DepthBias { constant: 2e-5, slope: options.filter as f32 / 2.0 + 1.0 };
    let seen: Vec<Vertex<0>> =
        room.corners.iter().map(|c| Vertex::new(projector * c.place.extend(1.0), [])).collect();
    renderer.draw_depth(&mut shadows, Mesh::new(&seen, &room.faces));

    let slide = slide()?;
    let vertices: Vec<_> = room
        .corners
        .iter()
        .map(|corner| {
            let Corner { place, normal, color } = *corner;
            let surface = Surface { slide: projector * place.extend(1.0), place, normal, color };
            Vertex::new(camera * place.extend(1.0), surface)
        })
        .collect();
    let (width, height) = (options.width, options.width * 2 / 3);
    let mut frame = Framebuffer::new(width * SAMPLES, height * SAMPLES, Vec3::splat(0.01))?;
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.draw(&mut frame, Mesh::new(&vertices, &room.faces), |fragment| {
        shade(fragment, &slide, &shadows, options.filter)
    });
    cli::make_folder_of(&options.output)?;
    frame.downsampled(SAMPLES)?.save_png(&options.output)?;
    println!("wrote {}", options.output.display());
    Ok(())
}

// ------------------------------------------------------------------------------------------- light

/// The colour at a pixel: a little light from everywhere, and the slide's.
fn shade(
    fragment: &Fragment<'_, { Surface::LEN }>,
    slide: &Texture,
    shadows: &Framebuffer<()>,
    filter: u32,
) -> Vec3 {
    let Surface { place, normal, color, .. } = fragment.params.into();
    let ambient = 0.06 + 0.03 * normal.y + 0.01 * normal.x;
    // Nothing is lit behind the projector.
    let Some(mut footprint) = fragment.divided_footprint([0, 1], 3) else { return color * ambient };
    let Some([x, y, z]) = fragment.divided(SLIDE.0, SLIDE.1) else { return color * ambient };
    let half = vec2(0.5, -0.5);
    footprint.uv = footprint.uv * half + 0.5;
    (footprint.dx, footprint.dy) = (footprint.dx * half, footprint.dy * half);
    let towards = PROJECTOR.0 - place;
    let cosine = normal.dot(towards.normalize()).max(0.0);
    let strength = cosine * 70.0 / towards.length_squared() * lit(shadows, vec3(x, y, z), filter);
    let light = slide.sample_footprint(&footprint).truncate() * strength;
    color * (light + ambient)
}

/// The part of a neighbourhood that light falls on, by a map of depths as the light sees them: each texel is compared,
/// and what comes out is averaged (Reeves, Salesin and Cook, "Rendering Antialiased Shadows with Depth Maps", 1987).
/// The neighbourhood is a square of `filter` texels around the place, whose border texels count by the part of them
/// that is in it.
fn lit(shadows: &Framebuffer<()>, slide: Vec3, filter: u32) -> f32 {
    let size = vec2(shadows.width() as f32, shadows.height() as f32);
    let centre = (vec2(slide.x, -slide.y) * 0.5 + 0.5) * size;
    let inside = |texel: f32, size: f32| texel >= 0.0 && texel < size;
    if !inside(centre.x, size.x) || !inside(centre.y, size.y) {
        return 0.0;
    }
    let first = centre - filter as f32 / 2.0;
    let (corner, part) = (first.floor(), first - first.floor());
    let weight = |i: u32, part: f32| match i {
        0 => 1.0 - part,
        i if i == filter => part,
        _ => 1.0,
    };
    let mut sum = 0.0;
    for (i, j) in (0..=filter).flat_map(|j| (0..=filter).map(move |i| (i, j))) {
        let texel = corner + vec2(i as f32, j as f32);
        let texel = texel.clamp(Vec2::ZERO, size - 1.0);
        let depth = shadows.pixel(texel.x as u32, texel.y as u32).map_or(1.0, |(_, depth)| depth);
        if slide.z <= depth {
            sum += weight(i, part.x) * weight(j, part.y);
        }
    }
    sum / (filter * filter) as f32
}

/// A slide: hills before a sky in the evening, in a white frame.
fn slide() -> Result<Texture, Box<dyn Error>> {
    let (width, height) = (640, 480);
    let texture = Texture::from_fn(width, height, |x, y| {
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        if !(0.02..0.98).contains(&u) || !(0.027..0.973).contains(&v) {
            return Vec4::splat(0.9).with_w(1.0);
        }
        let hill = |k: f32, at: f32, high: f32| {
            at - high * ((u * k + at * 7.0).sin() + 0.4 * (u * k * 2.7 + 1.0).sin())
        };
        let sun = (vec2(u, v * 0.75) - vec2(0.68, 0.27)).length();
        if v > hill(7.0, 0.85, 0.06) {
            vec4(0.02, 0.10, 0.05, 1.0)
        } else if v > hill(5.0, 0.72, 0.08) {
            vec4(0.05, 0.22, 0.12, 1.0)
        } else if v > hill(4.0, 0.58, 0.07) {
            vec4(0.14, 0.28, 0.35, 1.0)
        } else if sun < 0.07 {
            vec4(1.0, 0.85, 0.35, 1.0)
        } else {
            let glow = (1.0 - sun * 1.4).max(0.0).powi(2);
            vec3(0.12, 0.25, 0.6).lerp(vec3(1.0, 0.45, 0.15), (v * 0.8 + glow).min(1.0)).extend(1.0)
        }
    })?;
    let texture = texture.with_wrap(Wrap::Border).with_border(Vec4::ZERO).with_mipmaps()?;
    Ok(texture.with_mip_filter(MipFilter::Anisotropic { probes: 16 }))
}

// -------------------------------------------------------------------------------------------- room

#[derive(Clone, Copy)]
struct Corner {
    place: Vec3,
    normal: Vec3,
    color: Vec3,
}

#[derive(Default)]
struct Room {
    corners: Vec<Corner>,
    faces: Vec<[u32; 4]>,
}

impl Room {
    fn new() -> Self {
        let mut room = Self::default();
        let (floor, wall) = (vec3(0.55, 0.5, 0.42), vec3(0.75, 0.74, 0.7));
        let square = |a: Vec3, b: Vec3, c: Vec3| [a, b, c, a + c - b];
        room.add(square(vec3(-5.0, 0.0, 9.0), vec3(5.0, 0.0, 9.0), vec3(5.0, 0.0, -4.0)), floor);
        room.add(square(vec3(-5.0, 0.0, -4.0), vec3(5.0, 0.0, -4.0), vec3(5.0, 5.0, -4.0)), wall);
        room.add(square(vec3(-5.0, 0.0, 9.0), vec3(-5.0, 0.0, -4.0), vec3(-5.0, 5.0, -4.0)), wall);
        room.add(square(vec3(5.0, 0.0, -4.0), vec3(5.0, 0.0, 9.0), vec3(5.0, 5.0, 9.0)), wall);
        let stone = vec3(0.7, 0.6, 0.5);
        room.add_box(vec3(-0.7, 0.0, -1.6), vec3(0.35, 2.4, 0.35), 0.4, stone);
        room.add_box(vec3(2.0, 0.0, -2.4), vec3(0.35, 3.6, 0.35), 0.1, stone);
        room.add_box(vec3(0.6, 0.0, 0.0), vec3(0.8, 0.8, 0.8), 0.7, vec3(0.7, 0.3, 0.2));
        room.add_box(vec3(0.6, 0.8, 0.0), vec3(0.45, 0.45, 0.45), 1.1, vec3(0.25, 0.4, 0.65));
        // The projector, around its lens, on a table.
        let (eye, _) = PROJECTOR;
        room.add_box(eye - vec3(0.0, 0.2, 0.0), vec3(0.5, 0.4, 0.5), 0.44, vec3(0.15, 0.15, 0.17));
        room.add_box(eye.with_y(0.0), vec3(0.9, eye.y - 0.25, 0.9), 0.44, vec3(0.4, 0.25, 0.12));
        room
    }

    /// A box that stands on the middle of its base, turned about the vertical.
    fn add_box(&mut self, base: Vec3, size: Vec3, turn: f32, color: Vec3) {
        let matrix =
            Mat4::from_translation(base) * Mat4::from_rotation_y(turn) * Mat4::from_scale(size);
        let at = |x: f32, y: f32, z: f32| matrix.transform_point3(vec3(x - 0.5, y, z - 0.5));
        let (a, b, c, d) = (at(0., 0., 0.), at(1., 0., 0.), at(1., 0., 1.), at(0., 0., 1.));
        let (e, f, g, h) = (at(0., 1., 0.), at(1., 1., 0.), at(1., 1., 1.), at(0., 1., 1.));
        for face in [[d, c, g, h], [c, b, f, g], [b, a, e, f], [a, d, h, e], [h, g, f, e]] {
            self.add(face, color);
        }
    }

    /// A face, counter-clockwise as seen from its front.
    fn add(&mut self, places: [Vec3; 4], color: Vec3) {
        let normal = (places[1] - places[0]).cross(places[2] - places[0]).normalize();
        let first = self.corners.len() as u32;
        self.corners.extend(places.map(|place| Corner { place, normal, color }));
        self.faces.push([0, 1, 2, 3].map(|i| first + i));
    }
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    output: PathBuf,
    width: u32,
    shadow: u32,
    filter: u32,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options =
            Self { output: "target/projector.png".into(), width: 960, shadow: 1024, filter: 5 };
        let mut parser = Parser::from_env();
        let number = |parser: &mut Parser, range| {
            parser.value()?.parse_with(|text| cli::number(text, range))
        };
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Long("width") => options.width = number(&mut parser, 16..=4096)?,
                Arg::Long("shadow") => options.shadow = number(&mut parser, 16..=4096)?,
                Arg::Long("filter") => options.filter = number(&mut parser, 1..=15)?,
                Arg::Long("output") => options.output = cli::png(parser.value()?)?,
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                _ => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}
