//! What textures are for besides colour: six pictures, each pixel the mean of nine.
//!
//! Above: a sphere with a normal map; the same heights as a displacement, the surface diced to about a pixel
//! (Cook, Carpenter and Catmull, "The Reyes Image Rendering Architecture", SIGGRAPH 1987), where the outline and
//! what lies behind a bump show that the surface itself has moved; a mirror with an environment in one
//! picture. Below: an environment in six pictures, in a mirror with a normal map; a floor with paint, a decal on
//! it, and a light map; leaves that recede, in the upper half by a chain as it is, in the lower one
//! by one for cut-outs.
//!
//! ```text
//! cargo run --release --example materials
//! ```

use std::error::Error;
use std::f32::consts::{PI, TAU};
use std::path::PathBuf;
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};
use lexopt::{Arg, Parser};
use polyscan::glam::camera::rh::proj::directx::perspective;
use polyscan::glam::camera::rh::view::look_at_mat4;
use polyscan::glam::{Mat4, Vec2, Vec3, Vec4, vec2, vec3, vec4};
use polyscan::tangent::{TangentFrame, TangentVertex, tangents};
use polyscan::texture::{DirectionFootprint, EnvironmentMap, MipFilter, Texture, Wrap};
use polyscan::{Footprint, Fragment, Framebuffer, Mesh, Vertex, Viewport, ZBufferRenderer, record};

#[expect(dead_code, reason = "other examples have options of numbers")]
mod cli;

const HELP: &str = "\
Draw six materials, each by textures that are no colours.

Usage: materials [OPTIONS]

Options:
      --output <FILE>  The PNG file to write [default: target/materials.png]
  -h, --help           Show this help
";

/// The side of each picture in pixels.
const SIDE: u32 = 320;

/// A pixel is the mean of so many samples in x and in y.
const SAMPLES: u32 = 3;

/// How far bumps stand out of a sphere of radius 1.
const RELIEF: f32 = 0.06;

/// The width of the picture of heights in texels, which goes once around the sphere.
const HEIGHTS: u32 = 1024;

record! {
    /// What goes from the vertices to the pixels.
    struct Surface {
        uv: Vec2,
        place: Vec3,
        normal: Vec3,
        tangent: Vec4,
    }
}

/// The first numbers of place and normal.
const PLACE: usize = 2;
const NORMAL: usize = 5;

const N: usize = Surface::LEN;

type Picture = Framebuffer<Vec4>;

type Scene = fn() -> Result<Picture, Box<dyn Error>>;

fn main() -> ExitCode {
    cli::run(draw)
}

fn draw() -> Result<(), Box<dyn Error>> {
    let mut output = PathBuf::from("target/materials.png");
    let mut parser = Parser::from_env();
    while let Some(arg) = parser.next()? {
        match arg {
            Arg::Long("output") => output = cli::png(parser.value()?)?,
            Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
            _ => return Err(arg.unexpected().into()),
        }
    }
    let scenes: [Scene; 6] = [bumps, displacement, mirror, bent_mirror, floor, leaves];
    let bar = ProgressBar::new(scenes.len() as u64)
        .with_style(ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left")?);
    const GAP: u32 = 6;
    let side = |count: u32| count * (SIDE + GAP) + GAP;
    let mut sheet = Framebuffer::new(side(3), side(2), vec4(0.9, 0.89, 0.86, 1.0))?;
    for (i, scene) in (0..).zip(scenes) {
        let picture = scene()?;
        let (left, top) = (GAP + i % 3 * (SIDE + GAP), GAP + i / 3 * (SIDE + GAP));
        let width = sheet.width() as usize;
        for (y, row) in (top as usize..).zip(picture.color().chunks_exact(SIDE as usize)) {
            let start = y * width + left as usize;
            sheet.color_mut()[start..start + SIDE as usize].copy_from_slice(row);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    cli::make_folder_of(&output)?;
    sheet.save_png(&output)?;
    println!("wrote {}", output.display());
    Ok(())
}

// ------------------------------------------------------------------------------------------ scenes

fn bumps() -> Result<Picture, Box<dyn Error>> {
    let normals = filtered(normals()?)?;
    sphere(48, 24, |_| 0.0).seen_by(&camera(), |fragment| {
        let Surface { normal, tangent, place, .. } = fragment.params.into();
        let texel = normals.sample_footprint(&fragment.footprint(0, 1)).truncate();
        clay(TangentFrame::new(normal, tangent).bent(texel, 1.0), place)
    })
}

fn displacement() -> Result<Picture, Box<dyn Error>> {
    let heights = heights()?;
    // As many micropolygons as there are pixels around the sphere, and from pole to pole.
    let radius = camera().y_axis.y / EYE.length() * SIDE as f32 / 2.0;
    let (around, down) = ((TAU * radius) as u32, (PI * radius) as u32);
    let mesh = sphere(around, down, |uv| RELIEF * heights.sample(uv).x);
    mesh.seen_by(&camera(), |fragment| {
        let Surface { normal, place, .. } = fragment.params.into();
        clay(normal.normalize_or_zero(), place)
    })
}

fn mirror() -> Result<Picture, Box<dyn Error>> {
    let picture = Texture::from_fn(1024, 512, |x, y| {
        let (longitude, polar) = (TAU * (x as f32 + 0.5) / 1024.0, PI * (y as f32 + 0.5) / 512.0);
        let out = polar.sin();
        // The middle of the picture is at -z.
        surroundings(vec3(-out * longitude.sin(), polar.cos(), out * longitude.cos()))
    })?;
    let around = EnvironmentMap::equirectangular(filtered(picture)?);
    sphere(96, 48, |_| 0.0).before(&around, |fragment| {
        let normal = DirectionFootprint::of(fragment, NORMAL);
        around.sample_footprint(&way(fragment).reflected(&normal))
    })
}

fn bent_mirror() -> Result<Picture, Box<dyn Error>> {
    let around = EnvironmentMap::cube(cube()?)?;
    let normals = filtered(normals()?)?;
    sphere(96, 48, |_| 0.0).before(&around, |fragment| {
        let Surface { normal, tangent, .. } = fragment.params.into();
        let texel = normals.sample_footprint(&fragment.footprint(0, 1)).truncate();
        // The bumps change the direction, and the sphere how much is seen of the surroundings.
        let bent = TangentFrame::new(normal, tangent).bent(texel, 0.35);
        let plain = DirectionFootprint::of(fragment, NORMAL);
        let normal = DirectionFootprint { direction: bent, ..plain };
        around.sample_footprint(&way(fragment).reflected(&normal)) * vec4(1.0, 0.86, 0.6, 1.0)
    })
}

/// Paint, a decal over it, and a light map that multiplies both: three textures a fragment.
fn floor() -> Result<Picture, Box<dyn Error>> {
    let boards = filtered(boards()?)?;
    let decal = filtered(decal()?.with_wrap(Wrap::Border))?;
    let light = filtered(light_map()?.with_wrap(Wrap::Clamp))?;
    let camera = view(vec3(0.0, 1.9, 2.0));
    square(|x, y| vec3(1.6 * x, 0.0, -1.6 * y), Vec3::Y).seen_by(&camera, |fragment| {
        let seen = fragment.footprint(0, 1);
        let times = |scale: f32, corner: Vec2| Footprint {
            uv: (seen.uv - corner) * scale,
            dx: seen.dx * scale,
            dy: seen.dy * scale,
        };
        let paint = boards.sample_footprint(&times(2.0, Vec2::ZERO));
        let over = decal.sample_footprint(&times(3.0, vec2(0.2, 0.5)));
        let paint = over + paint * (1.0 - over.w);
        Some((paint.truncate() * light.sample_footprint(&seen).truncate()).extend(1.0))
    })
}

/// Two hedges to the horizon.
fn leaves() -> Result<Picture, Box<dyn Error>> {
    let picture = leaf_picture()?;
    let trilinear = |texture: Texture| texture.with_mip_filter(MipFilter::Linear);
    let plain = trilinear(picture.clone().with_mipmaps()?);
    let cut_out = trilinear(picture.with_cutout_mipmaps(0.5)?);
    let camera = view(vec3(0.0, 0.0, 2.0));
    let place =
        |x: f32, y: f32| vec3(-1.2 + 14.0 * (0.5 + 0.5 * x), y, 1.2 - 22.0 * (0.5 + 0.5 * x));
    let shade = |fragment: &Fragment<'_, N>| {
        let Surface { uv, .. } = fragment.params.into();
        let Footprint { dx, dy, .. } = fragment.footprint(0, 1);
        let repeated = vec2(160.0, 13.0);
        let seen = Footprint { uv: uv * repeated, dx: dx * repeated, dy: dy * repeated };
        let texture = if uv.y < 0.5 { &plain } else { &cut_out };
        let color = texture.sample_footprint(&seen);
        (color.w >= 0.5).then(|| (color.truncate() / color.w).extend(1.0))
    };
    square(place, Vec3::Z).seen_by(&camera, shade)
}

// ----------------------------------------------------------------------------------------- shading

/// The eye of the spheres.
const EYE: Vec3 = vec3(0.0, 0.6, 3.1);

const SKY: Vec4 = vec4(0.62, 0.7, 0.76, 1.0);

fn view(eye: Vec3) -> Mat4 {
    perspective(0.75, 1.0, 0.1, 100.0) * look_at_mat4(eye, Vec3::ZERO, Vec3::Y)
}

fn camera() -> Mat4 {
    perspective(0.75, 1.0, 0.1, 100.0) * look_at_mat4(EYE, Vec3::ZERO, Vec3::Y)
}

/// Clay under a lamp, with a highlight.
fn clay(normal: Vec3, place: Vec3) -> Option<Vec4> {
    let lamp = vec3(0.65, 0.6, 0.45).normalize();
    let halfway = (lamp + (EYE - place).normalize()).normalize();
    let diffuse = 0.08 + 0.92 * normal.dot(lamp).max(0.0);
    let highlight = 0.25 * normal.dot(halfway).max(0.0).powi(40);
    Some((vec3(0.72, 0.36, 0.22) * diffuse + highlight).extend(1.0))
}

/// The way from the eye to a fragment.
fn way(fragment: &Fragment<'_, N>) -> DirectionFootprint {
    let place = DirectionFootprint::of(fragment, PLACE);
    DirectionFootprint { direction: place.direction - EYE, ..place }
}

/// A bright sky with a sun and clouds, and tiles below.
fn surroundings(direction: Vec3) -> Vec4 {
    let d = direction.normalize();
    if d.y < 0.0 {
        let at = vec2(d.x, d.z) * (1.2 / d.y.min(-0.02));
        let is_light = (at.x.floor() + at.y.floor()).rem_euclid(2.0) < 1.0;
        let tile = if is_light { vec3(0.75, 0.7, 0.6) } else { vec3(0.16, 0.13, 0.12) };
        return tile.lerp(vec3(0.62, 0.7, 0.76), (1.0 + 1.2 * d.y).max(0.0).powi(6)).extend(1.0);
    }
    let sun = d.dot(vec3(0.5, 0.55, 0.45).normalize()).max(0.0).powi(300) * 4.0;
    let cloud = ((9.0 * d.x).sin() * (7.0 * d.z + 2.0 * d.y).sin() * 0.5 + 0.5).powi(3) * d.y;
    (vec3(0.62, 0.7, 0.76).lerp(vec3(0.1, 0.25, 0.6), d.y) + 0.6 * cloud + sun).extend(1.0)
}

// ------------------------------------------------------------------------------------------ meshes

struct Shape {
    vertices: Vec<TangentVertex>,
    faces: Vec<[u32; 4]>,
}

/// A sphere of radius 1 in so many columns and rows, whose surface is moved out by a height.
fn sphere(columns: u32, rows: u32, height: impl Fn(Vec2) -> f32) -> Shape {
    let direction = |uv: Vec2| {
        let (longitude, polar) = (TAU * uv.x, PI * uv.y);
        vec3(polar.sin() * longitude.sin(), polar.cos(), polar.sin() * longitude.cos())
    };
    let place = |uv: Vec2| direction(uv) * (1.0 + height(uv));
    let cell = vec2(1.0 / columns as f32, 1.0 / rows as f32);
    let vertices = grid(columns, rows).map(|(x, y)| {
        let uv = vec2(x as f32, y as f32) * cell;
        // Across two cells: along v downwards, along u to the right.
        let along = |by: Vec2| place(uv + by) - place(uv - by);
        let normal = along(cell * Vec2::Y).cross(along(cell * Vec2::X));
        let normal = normal.normalize_or(direction(uv));
        TangentVertex { position: place(uv), normal, uv }
    });
    Shape { vertices: vertices.collect(), faces: cells(columns, rows) }
}

/// A square, at whose point (x, y), from -1 to 1, a place is.
fn square(place: impl Fn(f32, f32) -> Vec3, normal: Vec3) -> Shape {
    let vertices = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)].map(|(x, y)| {
        TangentVertex { position: place(x, y), normal, uv: vec2(0.5 + 0.5 * x, 0.5 - 0.5 * y) }
    });
    Shape { vertices: vertices.into(), faces: vec![[0, 1, 2, 3]] }
}

fn grid(columns: u32, rows: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..=rows).flat_map(move |y| (0..=columns).map(move |x| (x, y)))
}

fn cells(columns: u32, rows: u32) -> Vec<[u32; 4]> {
    let corner = |x: u32, y: u32| y * (columns + 1) + x;
    let cell = |(x, y)| [corner(x, y), corner(x, y + 1), corner(x + 1, y + 1), corner(x + 1, y)];
    (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).map(cell).collect()
}

impl Shape {
    /// The picture of the shape before the sky.
    fn seen_by(
        &self,
        camera: &Mat4,
        shader: impl Fn(&Fragment<'_, N>) -> Option<Vec4> + Sync,
    ) -> Result<Picture, Box<dyn Error>> {
        let vertices = self.projected(camera);
        Ok(Framebuffer::supersampled_by_grid((SIDE, SIDE), SAMPLES, SKY, |frame, viewport| {
            ZBufferRenderer::new(viewport).draw(frame, Mesh::new(&vertices, &self.faces), &shader);
        })?)
    }

    /// The picture of the shape before its surroundings.
    fn before(
        &self,
        around: &EnvironmentMap,
        shader: impl Fn(&Fragment<'_, N>) -> Vec4 + Sync,
    ) -> Result<Picture, Box<dyn Error>> {
        let vertices = self.projected(&camera());
        // Far away, a square that carries its places.
        let back = camera().inverse();
        let corners = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)].map(|(x, y)| {
            let place = back.project_point3(vec3(x, y, 0.99));
            Vertex::new(camera() * place.extend(1.0), place - EYE)
        });
        let draw = |frame: &mut Picture, viewport: Viewport| {
            ZBufferRenderer::new(viewport).draw(frame, &corners, |fragment| {
                around.sample_footprint(&DirectionFootprint::of(fragment, 0))
            });
            ZBufferRenderer::new(viewport).draw(frame, Mesh::new(&vertices, &self.faces), &shader);
        };
        Ok(Framebuffer::supersampled_by_grid((SIDE, SIDE), SAMPLES, SKY, draw)?)
    }

    fn projected(&self, camera: &Mat4) -> Vec<Vertex<N>> {
        let tangents = tangents(&self.vertices, &self.faces);
        let all = self.vertices.iter().zip(tangents);
        all.map(|(&TangentVertex { position, normal, uv }, tangent)| {
            let surface = Surface { uv, place: position, normal, tangent };
            Vertex::new(*camera * position.extend(1.0), surface)
        })
        .collect()
    }
}

// ---------------------------------------------------------------------------------------- textures

fn filtered(texture: Texture) -> Result<Texture, Box<dyn Error>> {
    Ok(texture.with_mipmaps()?.with_mip_filter(MipFilter::Anisotropic { probes: 8 }))
}

/// Rounded tiles, 24 around and 12 from pole to pole, each second row moved by half a tile.
fn heights() -> Result<Texture, Box<dyn Error>> {
    Ok(Texture::from_fn(HEIGHTS, HEIGHTS / 2, |x, y| {
        let at = vec2(x as f32, y as f32) / HEIGHTS as f32 * 24.0;
        let row = at.y.floor();
        let in_tile = vec2((at.x + 0.5 * (row % 2.0)).fract(), at.y.fract());
        let from_edge = (0.5 - (in_tile - 0.5).abs()).min_element();
        let t = ((from_edge - 0.04) / 0.2).clamp(0.0, 1.0);
        Vec4::splat(t * t * (3.0 - 2.0 * t))
    })?)
}

/// The normals of these heights: as high as they stand out of a sphere that the picture goes around.
fn normals() -> Result<Texture, Box<dyn Error>> {
    Ok(heights()?.normals_of_heights(RELIEF * HEIGHTS as f32 / TAU)?)
}

/// The surroundings on the six sides of a cube, by OpenGL's table.
fn cube() -> Result<[Texture; 6], Box<dyn Error>> {
    let mut faces = Vec::new();
    for face in 0..6 {
        let texel = |x: u32, y: u32| {
            let [s, t] = [x, y].map(|i| (i as f32 + 0.5) / 256.0 * 2.0 - 1.0);
            surroundings(match face {
                0 => vec3(1.0, -t, -s),
                1 => vec3(-1.0, -t, s),
                2 => vec3(s, 1.0, t),
                3 => vec3(s, -1.0, -t),
                4 => vec3(s, -t, 1.0),
                _ => vec3(-s, -t, -1.0),
            })
        };
        faces.push(filtered(Texture::from_fn(256, 256, texel)?)?);
    }
    faces.try_into().map_err(|_| "a cube has six faces".into())
}

/// Boards of wood.
fn boards() -> Result<Texture, Box<dyn Error>> {
    Ok(Texture::from_fn(256, 256, |x, y| {
        let (board, along) = (y / 32, x as f32 / 256.0 * TAU);
        let grain = (0.6 * (y as f32) + 2.0 * (along + board as f32).sin()).sin();
        let tone = 0.8 + 0.2 * (board * 5 % 8) as f32 / 8.0 + 0.08 * grain;
        let gap = if y % 32 < 2 || (x + board * 96) % 256 < 2 { 0.25 } else { 1.0 };
        (vec3(0.55, 0.33, 0.17) * tone * gap).extend(1.0)
    })?)
}

/// A disc with a star, clear around.
fn decal() -> Result<Texture, Box<dyn Error>> {
    Ok(Texture::from_fn(256, 256, |x, y| {
        let at = (vec2(x as f32, y as f32) - 127.5) / 128.0;
        let (radius, angle) = (at.length(), at.x.atan2(-at.y));
        let is_star = radius < 0.45 + 0.25 * (5.0 * angle).cos();
        let color = if is_star { vec3(0.95, 0.85, 0.3) } else { vec3(0.05, 0.15, 0.5) };
        let alpha = ((0.94 - radius) * 40.0).clamp(0.0, 1.0);
        color.extend(1.0) * alpha
    })?)
}

/// Two pools of light, and the soft shadow of something square.
fn light_map() -> Result<Texture, Box<dyn Error>> {
    Ok(Texture::from_fn(64, 64, |x, y| {
        let at = vec2(x as f32 + 0.5, y as f32 + 0.5) / 64.0;
        let pool = |centre: Vec2| 1.0 / (1.0 + 14.0 * (at - centre).length_squared());
        let from_box = ((at - vec2(0.68, 0.42)).abs() - 0.09).max_element().max(0.0);
        let shadow = (0.1 + 12.0 * from_box).min(1.0);
        let warm = vec3(1.0, 0.85, 0.6) * pool(vec2(0.2, 0.7));
        let cold = vec3(0.6, 0.75, 1.0) * pool(vec2(0.75, 0.2));
        ((warm * 1.2 + cold) * shadow + 0.06).extend(1.0)
    })?)
}

/// Twigs and leaves, with air between them.
fn leaf_picture() -> Result<Texture, Box<dyn Error>> {
    let mut bits = 1_u32;
    let mut number = || {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (bits >> 8) as f32 / 16_777_216.0
    };
    let leaves: Vec<_> = (0..60)
        .map(|_| (vec2(number(), number()) * 256.0, Vec2::from_angle(number() * TAU), number()))
        .collect();
    Ok(Texture::from_fn(256, 256, |x, y| {
        let at = vec2(x as f32 + 0.5, y as f32 + 0.5);
        let mut found = Vec4::ZERO;
        for &(centre, axis, tone) in &leaves {
            // The nearest of its repetitions.
            let from = (at - centre + 128.0).rem_euclid(Vec2::splat(256.0)) - 128.0;
            let (along, across) = (from.dot(axis) / 20.0, from.perp_dot(axis) / 5.0);
            if along * along + across.abs() < 1.0 {
                found = vec3(0.1 + 0.25 * tone, 0.4 + 0.2 * tone, 0.08).extend(1.0);
            }
        }
        found
    })?)
}
