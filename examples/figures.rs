//! The figures of the papers that polyscan follows, remade: what is naive beside what is correct.
//!
//! - Heckbert and Moreton, "Interpolation for Polygon Texture Mapping and Shading" (1991), by the subjects of its five
//!   figures: a checkered square that is turned (1), cut into triangles (2), subdivided (3), a plot of a texture
//!   coordinate along a row (4), and texture coordinates that are not affine on the square (5).
//! - Any values at the corners of a pentagon, of which their section 3.4 warns.
//! - Low, "Perspective-Correct Interpolation" (2002), figure 1: the middle of a line's picture is not the picture of its
//!   middle.
//! - Scratchapixel's triangle with its numbers, at 512 x 512.
//! - Catmull, "A Hidden-Surface Algorithm with Anti-Aliasing" (1978): pixels covered in part, by their centres, by 4 and 16
//!   samples, and by exact area, which the samples come near to.
//!
//! Each becomes a PNG file and an SVG file, and all of them a sheet.
//!
//! ```text
//! cargo run --release --example figures
//! ```

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::color::Color;
use polyscan::glam::camera::rh::proj::directx::perspective;
use polyscan::glam::{Mat4, Vec2, Vec3, Vec4, vec2, vec3, vec4};
use polyscan::parameters::{self, PolygonValues, Subdivision};
use polyscan::render::{AreaRenderer, MultisampleFramebuffer, MultisampleRenderer, Samples};
use polyscan::{Framebuffer, Interpolation, ScanConverter, Vertex, Viewport, ZBufferRenderer};

mod cli;

const HELP: &str = "\
Remake the figures of Heckbert and Moreton, of Low, Scratchapixel's triangle, and show pixels covered in part.

Usage: figures [OPTIONS]

Options:
      --output <FILE>   The PNG file of all figures [default: target/figures.png]; each has a PNG
                        file and an SVG file of its own in a folder of the same name
      --tile <PIXELS>   Width and height of a square's picture, from 32 to 1024 [default: 200]
  -h, --help            Show this help
";

/// Each pixel is the mean of this many samples in x and in y.
const SAMPLES: u32 = 4;
const PAPER: Vec3 = vec3(0.9, 0.89, 0.86);
const INK: Vec3 = vec3(0.03, 0.03, 0.05);
const RED: Vec3 = vec3(0.6, 0.05, 0.03);
const BLUE: Vec3 = vec3(0.05, 0.12, 0.5);
const GREEN: Vec3 = vec3(0.05, 0.3, 0.08);

type Picture = Framebuffer<Vec3>;

fn main() -> ExitCode {
    cli::run(draw)
}

fn draw() -> Result<(), Box<dyn Error>> {
    let mut output = PathBuf::from("target/figures.png");
    let mut tile = 200;
    let mut parser = Parser::from_env();
    while let Some(arg) = parser.next()? {
        match arg {
            Arg::Long("output") => output = cli::png(parser.value()?)?,
            Arg::Long("tile") => {
                tile = parser.value()?.parse_with(|text| cli::number(text, 32..=1024))?;
            }
            Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
            _ => return Err(arg.unexpected().into()),
        }
    }
    let figures = [
        ("heckbert-moreton-1", turned(tile)?),
        ("heckbert-moreton-2", triangulated(tile)?),
        ("heckbert-moreton-3", subdivided(tile)?),
        ("heckbert-moreton-4", plotted()?),
        ("heckbert-moreton-5", not_affine(tile)?),
        ("polygon-values", any_values(tile)?),
        ("scratchapixel", scratchapixel()?),
        ("low-1", low()?),
        ("coverage", covered_in_part(tile)?),
    ];
    let folder = output.with_extension("");
    cli::make_folder_of(&folder.join("figure"))?;
    let mut pictures = Vec::new();
    for (name, figure) in figures {
        let picture = figure.picture()?;
        picture.save_png(folder.join(name).with_extension("png"))?;
        figure.save_svg(&folder.join(name).with_extension("svg"))?;
        println!("wrote {}.png and .svg", folder.join(name).display());
        pictures.push(picture);
    }
    sheet(&pictures)?.save_png(&output)?;
    println!("wrote {}", output.display());
    Ok(())
}

/// All figures in two columns, half as large.
fn sheet(pictures: &[Picture]) -> Result<Picture, Box<dyn Error>> {
    let mut columns = [(0, Vec::new()), (0, Vec::new())];
    for picture in pictures {
        let column = usize::from(columns[1].0 < columns[0].0);
        columns[column].1.push((columns[column].0, picture));
        columns[column].0 += picture.height().next_multiple_of(2);
    }
    let width = pictures.iter().map(Picture::width).max().unwrap_or(1).next_multiple_of(2);
    let height = columns.iter().map(|column| column.0).max().unwrap_or(1);
    let mut sheet = Framebuffer::new(2 * width, height, PAPER)?;
    for (column, (_, pictures)) in (0..).zip(columns) {
        for (top, picture) in pictures {
            copy(&mut sheet, [column * width, top], picture, 1);
        }
    }
    Ok(sheet.downsampled(2)?)
}

// ------------------------------------------------------------------------- Heckbert and Moreton

/// A square in perspective, rolled about the line of sight.
fn square(roll: f32) -> [(Vec3, Vec2); 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
        let matrix = Mat4::from_rotation_z(roll.to_radians()) * Mat4::from_rotation_x(-1.05);
        (matrix.transform_point3(vec3(x, y, 0.0)), vec2(x + 1.0, 1.0 - y) / 2.0)
    })
}

fn camera() -> Mat4 {
    perspective(1.15, 1.0, 0.1, 10.0) * Mat4::from_translation(vec3(0.0, 0.0, -3.0))
}

fn in_clip_space(square: [(Vec3, Vec2); 4]) -> [Vertex<2>; 4] {
    square.map(|(place, uv)| Vertex::new(camera() * place.extend(1.0), uv))
}

/// Eight by eight fields, with a mark in the corner where u and v are 0.
fn checker(uv: Vec2) -> Vec3 {
    let field = (uv * 8.0).floor().clamp(Vec2::ZERO, Vec2::splat(7.0));
    if field.max_element() < 1.0 {
        vec3(0.8, 0.1, 0.05)
    } else if (field.x + field.y) % 2.0 == 0.0 {
        vec3(0.02, 0.05, 0.15)
    } else {
        vec3(0.95, 0.75, 0.35)
    }
}

/// A picture of polygons whose two parameters are interpolated in one way.
fn tile(
    size: u32,
    interpolation: Interpolation,
    polygons: &[&[Vertex<2>]],
) -> Result<Picture, Box<dyn Error>> {
    let mut frame = Framebuffer::new(size * SAMPLES, size * SAMPLES, PAPER)?;
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.settings.interpolation = [interpolation; 2];
    for &polygon in polygons {
        renderer.draw(&mut frame, polygon, |fragment| checker(fragment.params.into()));
    }
    Ok(frame.downsampled(SAMPLES)?)
}

const ROLLS: [f32; 5] = [0.0, 20.0, 45.0, 70.0, 90.0];

/// Figure 1: along the edges and across the rows, linearly; below it rational linear.
fn turned(size: u32) -> Result<Figure, Box<dyn Error>> {
    let mut figure = Figure::of_tiles(size, 5, 2);
    for (column, roll) in (0..).zip(ROLLS) {
        let square = in_clip_space(square(roll));
        figure.put(column, 0, tile(size, Interpolation::Linear, &[&square])?);
        figure.put(column, 1, tile(size, Interpolation::Perspective, &[&square])?);
    }
    figure.caption(0, "linear along edges and rows: a rubber sheet");
    figure.caption(1, "rational linear");
    Ok(figure)
}

/// Figure 2: the same square as two triangles.
fn triangulated(size: u32) -> Result<Figure, Box<dyn Error>> {
    let mut figure = Figure::of_tiles(size, 5, 2);
    for (column, roll) in (0..).zip(ROLLS) {
        let [a, b, c, d] = in_clip_space(square(roll));
        let triangles: [&[_]; 2] = [&[a, b, c], &[a, c, d]];
        figure.put(column, 0, tile(size, Interpolation::Linear, &triangles)?);
        figure.put(column, 1, tile(size, Interpolation::Perspective, &triangles)?);
    }
    figure.caption(0, "linear on two triangles: a seam along the diagonal");
    figure.caption(1, "rational linear on two triangles");
    Ok(figure)
}

/// Figure 3: subdivided evenly, then by a bound on the error, of which the last square needs none.
fn subdivided(size: u32) -> Result<Figure, Box<dyn Error>> {
    let mut figure = Figure::of_tiles(size, 5, 2);
    let square = in_clip_space(square(20.0));
    let settings = polyscan::Settings::new(Viewport::new(size, size)?);
    let texels = Vec2::splat(64.0);
    let within = |error| Subdivision::Within { error, params: [0, 1], size: texels };
    let mut counts = [String::from("evenly:"), String::from("by a bound in texels:")];
    for i in 0..4 {
        let error = [8.0, 4.0, 2.0, 0.5][i as usize];
        for (row, how) in [Subdivision::Times(i), within(error)].into_iter().enumerate() {
            let triangles = how.triangles(&square, &settings)?;
            let polygons: Vec<&[_]> = triangles.iter().map(<[_; 3]>::as_slice).collect();
            let mut picture = tile(size, Interpolation::Linear, &polygons)?;
            outline(&mut picture, &polygons)?;
            figure.put(i, row as u32, picture);
            let bound = if row == 0 { String::new() } else { format!(" within {error}") };
            let _ = write!(counts[row], " {}{bound},", triangles.len());
        }
    }
    for row in 0..2 {
        figure.put(4, row, tile(size, Interpolation::Perspective, &[&square])?);
        let said = &mut counts[row as usize];
        *said += " triangles; and rational linear";
        figure.caption(row, said);
    }
    Ok(figure)
}

/// Draws the edges of polygons over their picture.
fn outline(picture: &mut Picture, polygons: &[&[Vertex<2>]]) -> Result<(), Box<dyn Error>> {
    let mut lines = Figure::new(picture.width(), picture.height());
    let size = vec2(picture.width() as f32, picture.height() as f32);
    let place = |v: &Vertex<2>| {
        let ndc = v.position.truncate().truncate() / v.position.w;
        (ndc * vec2(0.5, -0.5) + 0.5) * size
    };
    for polygon in polygons {
        let next = polygon.iter().cycle().skip(1);
        for (a, b) in polygon.iter().zip(next) {
            lines.line(place(a), place(b), 0.7, vec3(0.2, 0.5, 0.25));
        }
    }
    lines.items.insert(0, Item::Picture(Vec2::ZERO, picture.clone()));
    *picture = lines.picture()?;
    Ok(())
}

/// Figure 4: u along the row through the middle of the square, by the scan converter.
fn plotted() -> Result<Figure, Box<dyn Error>> {
    let mut figure = Figure::new(640, 420);
    let (corner, size) = (vec2(60.0, 350.0), vec2(540.0, 310.0));
    let at = |x: f32, u: f32| corner + vec2(x, -u) * size;
    figure.line(at(0.0, 0.0), at(1.02, 0.0), 1.2, INK);
    figure.line(at(0.0, 0.0), at(0.0, 1.04), 1.2, INK);
    for i in 0..=4 {
        let part = i as f32 / 4.0;
        figure.line(at(part, 0.0), at(part, 0.0) + vec2(0.0, 5.0), 1.0, INK);
        figure.line(at(0.0, part), at(0.0, part) - vec2(5.0, 0.0), 1.0, INK);
        figure.text(at(part, 0.0) + vec2(-6.0, 22.0), &part.to_string(), INK);
        figure.text(at(0.0, part) + vec2(-44.0, 4.0), &part.to_string(), INK);
    }
    figure.text(at(0.96, 0.0) + vec2(0.0, 44.0), "x", INK);
    figure.text(at(0.0, 1.09) - vec2(4.0, 0.0), "u", INK);
    // An edge-on strip from left to right, nine times as far away at its right end.
    let strip = [(-1.0, -0.5, 1.0), (1.0, -0.5, 9.0), (1.0, 0.5, 9.0), (-1.0, 0.5, 1.0)].map(
        |(x, y, w): (f32, f32, f32)| {
            Vertex::new(vec4(x * w, y * w, 0.5 * w, w), [(x + 1.0) / 2.0, 0.0])
        },
    );
    let settings = polyscan::Settings::new(Viewport::new(512, 8)?);
    for (i, (how, name, color)) in [
        (None, "rational linear", INK),
        (Some(Subdivision::Times(0)), "linear", RED),
        (Some(Subdivision::Times(1)), "linear on halves", BLUE),
        (Some(Subdivision::Times(2)), "linear on quarters", GREEN),
    ]
    .into_iter()
    .enumerate()
    {
        let values = match how {
            None => along_row(&[&strip], Interpolation::Perspective)?,
            Some(how) => {
                let triangles = how.triangles(&strip, &settings)?;
                let polygons: Vec<&[_]> = triangles.iter().map(<[_; 3]>::as_slice).collect();
                along_row(&polygons, Interpolation::Linear)?
            }
        };
        let places: Vec<_> = values.iter().map(|&(x, u)| at((x as f32 + 0.5) / 512.0, u)).collect();
        for pair in places.windows(2) {
            figure.line(pair[0], pair[1], 1.8, color);
        }
        let row = at(0.06, 0.97) + vec2(0.0, i as f32 * 22.0);
        figure.line(row - vec2(0.0, 4.0), row + vec2(24.0, -4.0), 1.8, color);
        figure.text(row + vec2(34.0, 0.0), name, color);
    }
    figure.text(vec2(60.0, 408.0), "u along a row; w from 1 to 9", INK);
    Ok(figure)
}

/// The first parameter along a row of 512 pixels.
fn along_row(
    polygons: &[&[Vertex<2>]],
    interpolation: Interpolation,
) -> Result<Vec<(i32, f32)>, Box<dyn Error>> {
    let mut scan = ScanConverter::new(Viewport::new(512, 8)?);
    scan.settings.interpolation = [interpolation; 2];
    let mut values = Vec::new();
    for &polygon in polygons {
        for span in scan.spans(polygon).filter(|span| span.row() == 4) {
            values.extend(span.fragments().map(|fragment| (fragment.x, fragment.params[0])));
        }
    }
    values.sort_by_key(|&(x, _)| x);
    Ok(values)
}

/// Figure 5: texture coordinates that are no square: interpolated along the edges, on two triangles, and by a cluster.
fn not_affine(size: u32) -> Result<Figure, Box<dyn Error>> {
    let mut figure = Figure::of_tiles(size, 5, 3);
    let values = [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(0.75, 0.0), vec2(0.25, 0.25)];
    for (column, roll) in (0..).zip(ROLLS) {
        let mut square = square(roll);
        square.iter_mut().zip(values).for_each(|(corner, uv)| corner.1 = uv);
        let corners = in_clip_space(square);
        let [a, b, c, d] = corners;
        figure.put(column, 0, tile(size, Interpolation::Perspective, &[&corners])?);
        figure.put(column, 1, tile(size, Interpolation::Perspective, &[&[a, b, c], &[a, c, d]])?);
        let homogeneous = parameters::quad(square.map(|corner| corner.0), values)?;
        let quad: [_; 4] =
            std::array::from_fn(|i| Vertex::new(corners[i].position, homogeneous[i]));
        let mut frame = Framebuffer::new(size * SAMPLES, size * SAMPLES, PAPER)?;
        ZBufferRenderer::new(frame.viewport()).draw(&mut frame, &quad, |fragment| {
            checker(fragment.divided([0, 1], 2).unwrap_or_default().into())
        });
        figure.put(column, 2, frame.downsampled(SAMPLES)?);
    }
    figure.caption(0, "not affine, along edges and rows: it depends on the turn");
    figure.caption(1, "on two triangles: a seam");
    figure.caption(2, "a cluster with its own w: one projective mapping");
    Ok(figure)
}

/// What section 3.4 of the paper warns of: colours at the corners of a pentagon, along its edges and rows, and by mean
/// value coordinates.
fn any_values(size: u32) -> Result<Figure, Box<dyn Error>> {
    let mut figure = Figure::of_tiles(size, 5, 2);
    let colors =
        [[0.9, 0.05, 0.02], [0.9, 0.7, 0.05], [0.02, 0.5, 0.1], [0.05, 0.1, 0.8], [0.9, 0.9, 0.9]];
    for (column, roll) in (0..).zip(ROLLS) {
        let corners: [(Vec3, [f32; 3]); 5] = std::array::from_fn(|i| {
            let angle = i as f32 * std::f32::consts::TAU / 5.0;
            let matrix = Mat4::from_rotation_z(roll.to_radians()) * Mat4::from_rotation_x(-0.6);
            (matrix.transform_point3(Vec2::from_angle(angle).extend(0.0)), colors[i])
        });
        let values = PolygonValues::new(&corners)?;
        let position = |i: usize| camera() * corners[i].0.extend(1.0);
        let plain: [_; 5] = std::array::from_fn(|i| Vertex::new(position(i), corners[i].1));
        let placed: [_; 5] = std::array::from_fn(|i| Vertex::new(position(i), values.places()[i]));
        let blank = || Framebuffer::new(size * SAMPLES, size * SAMPLES, PAPER);
        let (mut by_edges, mut by_place) = (blank()?, blank()?);
        ZBufferRenderer::new(by_edges.viewport())
            .draw(&mut by_edges, &plain, |fragment| Vec3::from(fragment.params));
        ZBufferRenderer::new(by_place.viewport())
            .draw(&mut by_place, &placed, |fragment| Vec3::from(values.at(fragment.params.into())));
        figure.put(column, 0, by_edges.downsampled(SAMPLES)?);
        figure.put(column, 1, by_place.downsampled(SAMPLES)?);
    }
    figure.caption(0, "any values, along edges and rows: they depend on the turn");
    figure.caption(1, "by mean value coordinates");
    Ok(figure)
}

// ------------------------------------------------------------------------------------------- Catmull

/// A fan of thin blades: what is between them is thinner still.
fn blades() -> Vec<[Vertex<0>; 3]> {
    let tip = |angle: f32, length: f32| {
        let [x, y] = (Vec2::from_angle(angle.to_radians()) * length).into();
        Vertex::new(vec4(x - 0.9, y - 0.9, 0.5, 1.0), [])
    };
    let blade = |i: u8| {
        let angle = 5.0 + 8.0 * f32::from(i);
        [tip(angle, 0.02), tip(angle, 1.8), tip(angle + 4.0, 1.8)]
    };
    (0..11).map(blade).collect()
}

/// A fan, a few pixels of which become a tile: by centres, by samples, by area; and how far the samples are off.
fn covered_in_part(size: u32) -> Result<Figure, Box<dyn Error>> {
    const PIXELS: u32 = 25;
    let blades = blades();
    let mut frame = Framebuffer::new(PIXELS, PIXELS, Vec4::ZERO)?;
    let mut renderer = AreaRenderer::new(frame.viewport());
    for blade in &blades {
        renderer.draw(&mut frame, blade, |_| Vec4::ONE);
    }
    let areas: Vec<f32> = frame.color().iter().map(|color| color.w).collect();
    let mut centres = Framebuffer::new(PIXELS, PIXELS, 0.0f32)?;
    let mut renderer = ZBufferRenderer::new(centres.viewport());
    blades.iter().for_each(|blade| renderer.draw(&mut centres, blade, |_| 1.0f32));
    let sampled = |samples| -> Result<Vec<f32>, Box<dyn Error>> {
        let mut frame = MultisampleFramebuffer::new(PIXELS, PIXELS, samples, 0.0f32)?;
        let mut renderer = MultisampleRenderer::new(frame.viewport());
        blades.iter().for_each(|blade| renderer.draw(&mut frame, blade, |_| 1.0f32));
        Ok(frame.resolve()?.color().to_vec())
    };
    let (four, sixteen) = (sampled(Samples::Four)?, sampled(Samples::Sixteen)?);
    let mut figure = Figure::of_tiles(size, 4, 2);
    let all = [centres.color(), &four, &sixteen, &areas];
    for (column, covered) in (0..).zip(all) {
        let mut picture = Framebuffer::new(size, size, PAPER)?;
        let mut off = picture.clone();
        for y in 0..size {
            for x in 0..size {
                let [column, row] = [x, y].map(|place| place * PIXELS / size);
                let pixel = (row * PIXELS + column) as usize;
                let difference = covered[pixel] - areas[pixel];
                let tint = if difference > 0.0 { RED } else { BLUE };
                let at = (y * size + x) as usize;
                picture.color_mut()[at] = PAPER.lerp(INK, covered[pixel]);
                off.color_mut()[at] = PAPER.lerp(tint, (difference.abs() * 4.0).min(1.0));
            }
        }
        figure.put(column, 0, picture);
        figure.put(column, 1, off);
    }
    figure.caption(0, "pixels covered in part: by centres, by 4 and 16 samples, by area");
    figure.caption(1, "four times what they are off the area: red too much, blue too little");
    Ok(figure)
}

// --------------------------------------------------------------------------------------------- Low

/// Figure 1: a line, its picture, and intensities along both.
fn low() -> Result<Figure, Box<dyn Error>> {
    let mut figure = Figure::new(640, 420);
    // The eye is at the left, and looks to the right; the image plane is at distance 1.
    let place = |p: Vec2| vec2(70.0, 210.0) + vec2(p.x, -p.y) * vec2(120.0, 120.0);
    let (a, b) = (vec2(1.3, 1.1), vec2(3.4, -0.5));
    let seen = |p: Vec2| p / p.x;
    let middle = (seen(a) + seen(b)) / 2.0;
    // Where the ray through the middle meets the line: equally far from both in a cross product.
    let t = middle.perp_dot(a) / (middle.perp_dot(a) - middle.perp_dot(b));
    let c = a.lerp(b, t);
    let (plane, ray) = (vec3(0.35, 0.35, 0.4), vec3(0.6, 0.6, 0.62));
    figure.line(place(vec2(1.0, -1.35)), place(vec2(1.0, 1.5)), 1.5, plane);
    for point in [a, b, c] {
        figure.line(place(Vec2::ZERO), place(point), 1.0, ray);
    }
    figure.line(place(a), place(b), 2.5, INK);
    figure.disc(place(Vec2::ZERO), 6.0, INK);
    for (point, name, color) in [(a, "A", INK), (b, "B", INK), (c, "C", RED)] {
        figure.disc(place(point), 4.0, color);
        let small = name.to_lowercase();
        figure.disc(place(seen(point)), 4.0, color);
        figure.text(
            place(point) + vec2(10.0, -8.0),
            &format!("{name}, intensity {:.2}", intensity(point, a, b)),
            color,
        );
        figure.text(place(seen(point)) + vec2(-22.0, -6.0), &small, color);
    }
    figure.text(vec2(20.0, 245.0), "camera", INK);
    figure.text(vec2(130.0, 395.0), "image plane: c is half way from a to b", INK);
    // The picture of the line, from a to b, by either way.
    for (i, (interpolation, name)) in
        [(Interpolation::Linear, "linear: 0.5 at c"), (Interpolation::Perspective, "correct")]
            .into_iter()
            .enumerate()
    {
        let top = 318.0 + i as f32 * 32.0;
        let mut frame = Framebuffer::new(200, 22, PAPER)?;
        let ends =
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y): (f32, f32)| {
                let (w, r) = if x < 0.0 { (a.x, 0.0) } else { (b.x, 1.0) };
                Vertex::new(vec4(x * w, y * w, 0.5 * w, w), [r])
            });
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.settings.interpolation = [interpolation];
        renderer.draw(&mut frame, &ends, |fragment| Vec3::splat(fragment.params[0]));
        figure.items.push(Item::Picture(vec2(230.0, top), frame));
        figure.text(vec2(445.0, top + 15.0), name, INK);
    }
    figure.line(vec2(330.0, 312.0), vec2(330.0, 376.0), 1.5, RED);
    Ok(figure)
}

/// How far along the line from a to b a point is.
fn intensity(point: Vec2, a: Vec2, b: Vec2) -> f32 {
    (point - a).length() / (b - a).length()
}

// ----------------------------------------------------------------------------------- Scratchapixel

/// The triangle of Scratchapixel's lesson on rasterization, in its camera's space: z is the distance. Its picture is
/// 512 x 512 pixels from -1 to 1; v0 is blue, v1 green and v2 red, and has a checkerboard as well.
fn scratchapixel() -> Result<Figure, Box<dyn Error>> {
    let corners = [
        (vec3(13.0, 34.0, 114.0), Vec3::Z, vec2(0.0, 1.0)),
        (vec3(29.0, -15.0, 44.0), Vec3::Y, vec2(1.0, 0.0)),
        (vec3(-48.0, -10.0, 82.0), Vec3::X, vec2(0.0, 0.0)),
    ];
    let triangle = corners.map(|(place, color, uv)| {
        let [r, g, b] = color.to_array();
        Vertex::new(vec4(place.x, place.y, 0.5 * place.z, place.z), [r, g, b, uv.x, uv.y])
    });
    let mut figure = Figure::of_tiles(512, 2, 2);
    for (column, interpolation) in
        [Interpolation::Linear, Interpolation::Perspective].into_iter().enumerate()
    {
        for row in 0..2 {
            let mut frame = Framebuffer::new(512, 512, Vec3::ZERO)?;
            let mut renderer = ZBufferRenderer::new(frame.viewport());
            renderer.settings.interpolation = [interpolation; 5];
            renderer.draw(&mut frame, &triangle, |fragment| {
                let [r, g, b, u, v] = fragment.params;
                // The colours of the lesson are codes, not light.
                let light = [r, g, b]
                    .map(|code| polyscan::color::decode((code.clamp(0.0, 1.0) * 255.0) as u8));
                let is_light = ((u * 10.0).fract() > 0.5) != ((v * 10.0).fract() < 0.5);
                if row == 0 || is_light { Vec3::from(light) } else { Vec3::from(light) * 0.1 }
            });
            figure.put(column as u32, row, frame);
        }
    }
    figure.caption(0, "(13, 34, 114), (29, -15, 44), (-48, -10, 82): linear, correct");
    figure.caption(1, "the same with a checkerboard");
    Ok(figure)
}

// ----------------------------------------------------------------------------------------- figures

/// What a figure is made of; places are pixels from its top left corner.
enum Item {
    Picture(Vec2, Picture),
    Line([Vec2; 2], f32, Vec3),
    Disc(Vec2, f32, Vec3),
    /// The left end of the base line.
    Text(Vec2, String, Vec3),
}

/// A drawing that becomes a PNG file or an SVG file.
struct Figure {
    size: [u32; 2],
    tile: f32,
    items: Vec<Item>,
}

const GAP: f32 = 8.0;
const CAPTION: f32 = 26.0;

impl Figure {
    fn new(width: u32, height: u32) -> Self {
        Self { size: [width, height], tile: 0.0, items: Vec::new() }
    }

    /// Rows of tiles, each row with a caption below it.
    fn of_tiles(tile: u32, columns: u32, rows: u32) -> Self {
        let width = columns * (tile + GAP as u32) + GAP as u32;
        let height = rows * (tile + (GAP + CAPTION) as u32) + GAP as u32;
        Self { tile: tile as f32, ..Self::new(width, height) }
    }

    fn put(&mut self, column: u32, row: u32, picture: Picture) {
        let step = vec2(self.tile + GAP, self.tile + GAP + CAPTION);
        let place = step * vec2(column as f32, row as f32) + GAP;
        self.items.push(Item::Picture(place, picture));
    }

    fn caption(&mut self, row: u32, text: &str) {
        let bottom = (self.tile + GAP + CAPTION) * (row + 1) as f32;
        self.text(vec2(GAP + 2.0, bottom - 4.0), text, INK);
    }

    fn line(&mut self, from: Vec2, to: Vec2, width: f32, color: Vec3) {
        self.items.push(Item::Line([from, to], width, color));
    }

    fn disc(&mut self, centre: Vec2, radius: f32, color: Vec3) {
        self.items.push(Item::Disc(centre, radius, color));
    }

    fn text(&mut self, place: Vec2, text: &str, color: Vec3) {
        self.items.push(Item::Text(place, text.into(), color));
    }

    /// The figure as pixels: all but its pictures are polygons, drawn with several samples a pixel.
    fn picture(&self) -> Result<Picture, Box<dyn Error>> {
        let [width, height] = self.size;
        let mut frame = Framebuffer::new(width * SAMPLES, height * SAMPLES, PAPER)?;
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.depth_test = polyscan::DepthTest::Always;
        let scale = 2.0 / vec2(width as f32, height as f32);
        for item in &self.items {
            let (polygons, color) = match item {
                Item::Picture(place, picture) => {
                    let corner = [place.x, place.y].map(|c| c as u32 * SAMPLES);
                    copy(&mut frame, corner, picture, SAMPLES);
                    continue;
                }
                Item::Line([a, b], width, color) => {
                    let side = (*b - *a).perp().normalize_or_zero() * *width / 2.0;
                    let along = (*b - *a).normalize_or_zero() * *width / 2.0;
                    (
                        vec![vec![
                            *a - along + side,
                            *b + along + side,
                            *b + along - side,
                            *a - along - side,
                        ]],
                        color,
                    )
                }
                Item::Disc(centre, radius, color) => {
                    let at = |i| {
                        *centre
                            + Vec2::from_angle(i as f32 * std::f32::consts::TAU / 24.0) * *radius
                    };
                    (vec![(0..24).map(at).collect()], color)
                }
                Item::Text(place, text, color) => (letters(*place, text), color),
            };
            for polygon in polygons {
                let vertices: Vec<_> = polygon
                    .into_iter()
                    .map(|p| {
                        let p = p * scale - 1.0;
                        Vertex::new(vec4(p.x, -p.y, 0.5, 1.0), [])
                    })
                    .collect();
                renderer.draw(&mut frame, &vertices, |_| *color);
            }
        }
        Ok(frame.downsampled(SAMPLES)?)
    }

    fn save_svg(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let [width, height] = self.size;
        let code = |color: &Vec3| {
            let [r, g, b, _] = color.to_srgb8();
            format!("#{r:02x}{g:02x}{b:02x}")
        };
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"sans-serif\" font-size=\"14\">\n<rect width=\"100%\" height=\"100%\" fill=\"{}\"/>\n",
            code(&PAPER)
        );
        for item in &self.items {
            match item {
                Item::Picture(Vec2 { x, y }, picture) => {
                    let data = base64(&png_of(picture)?);
                    let (width, height) = (picture.width(), picture.height());
                    write!(
                        svg,
                        "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                         href=\"data:image/png;base64,{data}\"/>"
                    )?;
                }
                Item::Line([a, b], width, color) => write!(
                    svg,
                    "<line x1=\"{:.2}\" y1=\"{:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" stroke=\"{}\" \
                     stroke-width=\"{width}\" stroke-linecap=\"square\"/>",
                    a.x,
                    a.y,
                    b.x,
                    b.y,
                    code(color)
                )?,
                Item::Disc(Vec2 { x, y }, radius, color) => {
                    let fill = code(color);
                    write!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{fill}\"/>")?;
                }
                Item::Text(Vec2 { x, y }, text, color) => {
                    write!(
                        svg,
                        "<text x=\"{x}\" y=\"{y}\" fill=\"{}\">{text}</text>",
                        code(color)
                    )?;
                }
            }
            svg.push('\n');
        }
        svg += "</svg>\n";
        std::fs::write(path, svg)
            .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
    }
}

/// Copies a picture, each of whose pixels becomes several samples in x and in y.
fn copy(frame: &mut Picture, [left, top]: [u32; 2], picture: &Picture, samples: u32) {
    let (w, h) = (picture.width() * samples, picture.height() * samples);
    let width = frame.width();
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        let pixel = picture.color()[(y / samples * picture.width() + x / samples) as usize];
        if let Some(sample) = frame.color_mut().get_mut(((top + y) * width + left + x) as usize) {
            *sample = pixel;
        }
    }
}

fn png_of(picture: &Picture) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width(), picture.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    let data: Vec<u8> = picture.color().iter().flat_map(|color| color.to_srgb8()).collect();
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | u32::from(*three.get(i).unwrap_or(&0)));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize % 64];
            text.push(if i <= three.len() { digit.into() } else { '=' });
        }
    }
    text
}

// ----------------------------------------------------------------------------------------- letters

/// The letters of a text, as squares: five columns and nine rows each, the last two below the base line.
fn letters(place: Vec2, text: &str) -> Vec<Vec<Vec2>> {
    const DOT: f32 = 1.5;
    let mut squares = Vec::new();
    for (i, letter) in text.chars().enumerate() {
        let (_, rows) = LETTERS.iter().find(|(of, _)| *of == letter).unwrap_or(&LETTERS[0]);
        for (row, bits) in rows.iter().enumerate() {
            for column in (0..5).filter(|column| bits >> (4 - column) & 1 != 0) {
                let corner = place + vec2(i as f32 * 6.0 + column as f32, row as f32 - 7.0) * DOT;
                let side = |x: f32, y: f32| corner + vec2(x, y) * DOT;
                squares.push(vec![side(0., 0.), side(0., 1.), side(1., 1.), side(1., 0.)]);
            }
        }
    }
    squares
}

/// The letters that the figures have, each row from the top as five bits.
#[rustfmt::skip]
const LETTERS: [(char, [u8; 9]); 48] = [
    (' ', [0; 9]),
    ('a', [0, 0, 14, 1, 15, 17, 15, 0, 0]), ('b', [16, 16, 30, 17, 17, 17, 30, 0, 0]),
    ('c', [0, 0, 14, 17, 16, 17, 14, 0, 0]), ('d', [1, 1, 15, 17, 17, 17, 15, 0, 0]),
    ('e', [0, 0, 14, 17, 31, 16, 14, 0, 0]), ('f', [6, 9, 8, 28, 8, 8, 8, 0, 0]),
    ('g', [0, 0, 15, 17, 17, 17, 15, 1, 14]), ('h', [16, 16, 30, 17, 17, 17, 17, 0, 0]),
    ('i', [4, 0, 12, 4, 4, 4, 14, 0, 0]), ('j', [2, 0, 6, 2, 2, 2, 2, 18, 12]),
    ('k', [16, 16, 18, 20, 24, 20, 18, 0, 0]), ('l', [12, 4, 4, 4, 4, 4, 14, 0, 0]),
    ('m', [0, 0, 26, 21, 21, 21, 21, 0, 0]), ('n', [0, 0, 30, 17, 17, 17, 17, 0, 0]),
    ('o', [0, 0, 14, 17, 17, 17, 14, 0, 0]), ('p', [0, 0, 30, 17, 17, 17, 30, 16, 16]),
    ('q', [0, 0, 15, 17, 17, 17, 15, 1, 1]), ('r', [0, 0, 22, 25, 16, 16, 16, 0, 0]),
    ('s', [0, 0, 15, 16, 14, 1, 30, 0, 0]), ('t', [8, 8, 28, 8, 8, 9, 6, 0, 0]),
    ('u', [0, 0, 17, 17, 17, 17, 15, 0, 0]), ('v', [0, 0, 17, 17, 17, 10, 4, 0, 0]),
    ('w', [0, 0, 17, 17, 21, 21, 10, 0, 0]), ('x', [0, 0, 17, 10, 4, 10, 17, 0, 0]),
    ('y', [0, 0, 17, 17, 17, 17, 15, 1, 14]), ('z', [0, 0, 31, 2, 4, 8, 31, 0, 0]),
    ('A', [14, 17, 17, 31, 17, 17, 17, 0, 0]), ('B', [30, 17, 17, 30, 17, 17, 30, 0, 0]),
    ('C', [14, 17, 16, 16, 16, 17, 14, 0, 0]),
    ('0', [14, 17, 19, 21, 25, 17, 14, 0, 0]), ('1', [4, 12, 4, 4, 4, 4, 14, 0, 0]),
    ('2', [14, 17, 1, 2, 4, 8, 31, 0, 0]), ('3', [30, 1, 1, 14, 1, 1, 30, 0, 0]),
    ('4', [2, 6, 10, 18, 31, 2, 2, 0, 0]), ('5', [31, 16, 30, 1, 1, 17, 14, 0, 0]),
    ('6', [6, 8, 16, 30, 17, 17, 14, 0, 0]), ('7', [31, 1, 2, 4, 8, 8, 8, 0, 0]),
    ('8', [14, 17, 17, 14, 17, 17, 14, 0, 0]), ('9', [14, 17, 17, 15, 1, 2, 12, 0, 0]),
    ('.', [0, 0, 0, 0, 0, 12, 12, 0, 0]), (',', [0, 0, 0, 0, 0, 12, 4, 8, 0]),
    (':', [0, 12, 12, 0, 12, 12, 0, 0, 0]), (';', [0, 12, 12, 0, 12, 4, 8, 0, 0]),
    ('(', [2, 4, 8, 8, 8, 4, 2, 0, 0]), (')', [8, 4, 2, 2, 2, 4, 8, 0, 0]),
    ('-', [0, 0, 0, 14, 0, 0, 0, 0, 0]), ('=', [0, 0, 31, 0, 31, 0, 0, 0, 0]),
];
