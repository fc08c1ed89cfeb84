//! All filters of a texture on a tilted plane, side by side, and how far each is from the truth.
//!
//! The sheet's upper part shows a checkered plane to the horizon, a picture for each filter with a
//! crop of its middle distance three times as large. In this order, row by row: bilinear without a
//! chain, nearest level, trilinear; 2, 4 and 16 probes; EWA, the reference, and the mip levels as
//! colours. Below are the levels without steps, (u, v) as red and green, and a small picture, magnified:
//! nearest, bilinear, B-spline, Mitchell and Netravali, Catmull and Rom. The last two are the texture itself,
//! with what some pixels of the plane see of it, eight times as large, in the colours of their levels: of the plane
//! as it is, and of it rolled by 30 degrees, where footprints are long and lie across.
//!
//! The reference is the mean of many bilinear samples of each pixel. The table that is printed has the
//! peak signal-to-noise ratio of each filter's picture against it, of the colours as they are shown.
//!
//! ```text
//! cargo run --release --example textures
//! cargo run --release --example textures -- --table
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};
use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::color::Color;
use polyscan::glam::camera::rh::proj::directx::perspective;
use polyscan::glam::{Mat4, Vec2, Vec4, vec2, vec3, vec4};
use polyscan::texture::{Cubic, Filter, MipFilter, Texture};
use polyscan::{DepthTest, Footprint, FragmentBlock, Framebuffer, Lines, Vertex, ZBufferRenderer};

mod cli;

const HELP: &str = "\
Draw a sheet of all texture filters, and print how far each is from the truth.

Usage: textures [OPTIONS]

Options:
      --output <FILE>    The PNG file to write [default: target/textures.png]
      --samples <COUNT>  Samples a pixel of the reference, from 1 to 512 [default: 256]
      --tilt <DEGREES>   Tilt of the sheet's plane, from 0 to 89 [default: 80]
      --roll <DEGREES>   Its roll, from 0 to 359 [default: 0]
      --table            Print the table for many tilts instead, which takes a minute
  -h, --help             Show this help
";

/// What is seen beyond the plane.
const SKY: Vec4 = vec4(0.35, 0.45, 0.6, 1.0);

/// The size of a picture.
const SIZE: (u32, u32) = (320, 240);

const FILTERS: [(&str, MipFilter); 9] = [
    ("bilinear", MipFilter::Off),
    ("nearest", MipFilter::Nearest),
    ("trilinear", MipFilter::Linear),
    ("2 probes", MipFilter::Anisotropic { probes: 2 }),
    ("4 probes", MipFilter::Anisotropic { probes: 4 }),
    ("8 probes", MipFilter::Anisotropic { probes: 8 }),
    ("16 probes", MipFilter::Anisotropic { probes: 16 }),
    ("EWA 16", MipFilter::Ewa { eccentricity: 16 }),
    ("EWA 32", MipFilter::Ewa { eccentricity: 32 }),
];

type Picture = Framebuffer<Vec4>;

fn main() -> ExitCode {
    cli::run(draw)
}

fn draw() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let (checker, photo) = (checker(500, 380)?.with_mipmaps()?, photo(500, 375)?.with_mipmaps()?);
    if options.table {
        return print_table(&[("checker", &checker), ("picture", &photo)], options.samples);
    }
    let plane = Plane { tilt: options.tilt, roll: options.roll };
    let truth = plane.reference(&checker, options.samples)?;
    let mut sheet = Sheet::new(3, 6)?;
    for (i, (name, filter)) in FILTERS.into_iter().enumerate() {
        let picture = plane.picture(&checker.clone().with_mip_filter(filter))?;
        println!("{name:>10}: {:5.2} dB", psnr(&picture, &truth));
        // 8 probes and the wider EWA are in the table alone.
        let place = [Some(0), Some(1), Some(2), Some(3), Some(4), None, Some(5), Some(6), None][i];
        if let Some(place) = place {
            sheet.put_with_crop(place, &picture);
        }
    }
    sheet.put_with_crop(7, &truth);
    sheet.put(8, &plane.shaded(|footprint| level_color(level_of(&checker, footprint).round()))?);
    sheet.put(9, &plane.shaded(|footprint| level_color(level_of(&checker, footprint)))?);
    sheet.put(
        10,
        &plane.shaded(|Footprint { uv, .. }| {
            let [u, v] = uv.to_array().map(|c| c.rem_euclid(1.0));
            vec4(u, v, 0.0, 1.0)
        })?,
    );
    let small = checker_of_colors()?;
    let cubic = |cubic| Filter::Bicubic(cubic);
    for (place, filter) in (11..).zip([
        Filter::Nearest,
        Filter::Bilinear,
        cubic(Cubic::B_SPLINE),
        cubic(Cubic::MITCHELL),
        cubic(Cubic::CATMULL_ROM),
    ]) {
        sheet.put(place, &magnified(&small.clone().with_filter(filter))?);
    }
    sheet.put(16, &plane.footprints(&checker)?);
    sheet.put(17, &Plane { roll: plane.roll + 30.0, ..plane }.footprints(&checker)?);
    cli::make_folder_of(&options.output)?;
    sheet.0.save_png(&options.output)?;
    println!("wrote {}", options.output.display());
    Ok(())
}

/// Prints the signal-to-noise ratios of all filters for many planes.
fn print_table(textures: &[(&str, &Texture)], samples: u32) -> Result<(), Box<dyn Error>> {
    const PLANES: [(f32, f32); 8] = [
        (30.0, 0.0),
        (45.0, 0.0),
        (60.0, 0.0),
        (80.0, 0.0),
        (85.0, 0.0),
        (60.0, 30.0),
        (80.0, 30.0),
        (85.0, 30.0),
    ];
    let bar = ProgressBar::new((textures.len() * PLANES.len()) as u64)
        .with_style(ProgressStyle::with_template("{bar:40} {pos}/{len} planes, {eta} left")?);
    let mut lines = String::from("| texture | tilt | roll |");
    FILTERS.iter().for_each(|(name, _)| lines += &format!(" {name} |"));
    lines += &format!("\n|{}", "---|".repeat(3 + FILTERS.len()));
    for (name, texture) in textures {
        for (tilt, roll) in PLANES {
            let plane = Plane { tilt, roll };
            let truth = plane.reference(texture, samples)?;
            lines += &format!("\n| {name} | {tilt} | {roll} |");
            for (_, filter) in FILTERS {
                let picture = plane.picture(&(*texture).clone().with_mip_filter(filter))?;
                lines += &format!(" {:.1} |", psnr(&picture, &truth));
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    println!("{lines}");
    Ok(())
}

// ------------------------------------------------------------------------------------------ planes

/// A plane in front of the camera, tilted away from it, and rolled about the line of sight.
#[derive(Clone, Copy)]
struct Plane {
    /// In degrees: 0 is seen face on.
    tilt: f32,
    roll: f32,
}

impl Plane {
    /// The plane's vertices, after a matrix that moves the picture by a part of a pixel.
    fn vertices(&self, moved: Mat4) -> [Vertex<2>; 4] {
        let (width, height) = (SIZE.0 as f32, SIZE.1 as f32);
        let camera = moved
            * perspective(0.9, width / height, 0.05, 100.0)
            * Mat4::from_rotation_z(self.roll.to_radians())
            * Mat4::from_translation(vec3(0.0, 0.0, -1.0))
            * Mat4::from_rotation_x(-self.tilt.to_radians());
        [(-30.0, -30.0), (30.0, -30.0), (30.0, 30.0), (-30.0, 30.0)]
            .map(|(x, y)| Vertex::new(camera * vec4(x, y, 0.0, 1.0), vec2(x, -y) * 0.7))
    }

    fn drawn(
        &self,
        shader: impl Fn(&FragmentBlock<'_, 2>) -> [Vec4; 16] + Sync,
    ) -> Result<Picture, Box<dyn Error>> {
        let mut frame = Framebuffer::new(SIZE.0, SIZE.1, SKY)?;
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.draw_blocks(&mut frame, &self.vertices(Mat4::IDENTITY), |block, colors| {
            *colors = shader(block);
        });
        Ok(frame)
    }

    /// The picture by the texture's own filters.
    fn picture(&self, texture: &Texture) -> Result<Picture, Box<dyn Error>> {
        self.drawn(|block| texture.sample_footprint_block(&block.footprint(0, 1), block.visible))
    }

    /// The picture by a colour for each footprint.
    fn shaded(&self, color: impl Fn(&Footprint) -> Vec4 + Sync) -> Result<Picture, Box<dyn Error>> {
        self.drawn(|block| {
            let footprints = block.footprint(0, 1);
            std::array::from_fn(|lane| color(&footprints.get(lane)))
        })
    }

    /// The mean of many samples of each pixel.
    fn reference(&self, texture: &Texture, samples: u32) -> Result<Picture, Box<dyn Error>> {
        Ok(Framebuffer::supersampled_by_points(SIZE, samples, SKY, |frame, moved| {
            let mut renderer = ZBufferRenderer::new(frame.viewport());
            renderer.draw_blocks(frame, &self.vertices(moved), |block, colors| {
                *colors = texture.sample_block(&block.params, block.visible);
            });
        })?)
    }

    /// The texture, pale, with what every sixteenth pixel in x and y sees of it, made larger.
    fn footprints(&self, texture: &Texture) -> Result<Picture, Box<dyn Error>> {
        const STEP: usize = 16;
        const LARGER: f32 = 8.0;
        /// The part of the plane that is shown: from its middle on to the left, right and into the distance.
        const SHOWN: (Vec2, Vec2) = (vec2(-0.8, -1.0), vec2(0.8, 0.2));
        let mut seen = Framebuffer::new(SIZE.0, SIZE.1, None)?;
        let vertices = self.vertices(Mat4::IDENTITY);
        ZBufferRenderer::new(seen.viewport())
            .draw(&mut seen, &vertices, |fragment| Some(fragment.footprint(0, 1)));

        let place = |uv: Vec2| {
            let at = (uv - SHOWN.0) / (SHOWN.1 - SHOWN.0) * 2.0 - 1.0;
            vec4(at.x, -at.y, 0.5, 1.0)
        };
        let (low, high) = SHOWN;
        let sheet = [low, vec2(high.x, low.y), high, vec2(low.x, high.y)]
            .map(|uv| Vertex::new(place(uv), uv));
        let mut frame = Framebuffer::new(SIZE.0, SIZE.1, Vec4::ONE)?;
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.depth_test = DepthTest::Always;
        renderer.draw(&mut frame, &sheet, |fragment| {
            texture.sample_footprint(&fragment.footprint(0, 1)).lerp(Vec4::ONE, 0.6)
        });
        let mut renderer = ZBufferRenderer::new(frame.viewport());
        renderer.depth_test = DepthTest::Always;
        for (i, footprint) in seen.color().iter().enumerate() {
            let (x, y) = (i % SIZE.0 as usize, i / SIZE.0 as usize);
            let Some(footprint) =
                footprint.filter(|_| x % STEP == STEP / 2 && y % STEP == STEP / 2)
            else {
                continue;
            };
            let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| {
                let uv = footprint.uv + (footprint.dx * x + footprint.dy * y) * LARGER;
                Vertex::new(place(uv), [])
            });
            let color = level_color(level_of(texture, &footprint));
            renderer
                .draw(&mut frame, Lines::polyline(&corners).closed().with_width(1.5), |_| color);
        }
        Ok(frame)
    }
}

/// The peak signal-to-noise ratio in decibels, of the colours as they are shown.
fn psnr(picture: &Picture, truth: &Picture) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (ours, exact) in picture.color().iter().zip(truth.color()) {
        for (a, b) in ours.to_srgb8().into_iter().zip(exact.to_srgb8()).take(3) {
            sum += (f64::from(a) - f64::from(b)).powi(2);
            count += 1.0;
        }
    }
    10.0 * (255.0_f64.powi(2) * count / sum).log10()
}

fn level_of(texture: &Texture, footprint: &Footprint) -> f32 {
    let size = vec2(texture.width() as f32, texture.height() as f32);
    let longer = (footprint.dx * size).length().max((footprint.dy * size).length());
    longer.log2().clamp(0.0, (texture.level_count() - 1) as f32)
}

/// Red, yellow, green, blue, and so on, with what is between them.
fn level_color(level: f32) -> Vec4 {
    const COLORS: [Vec4; 6] = [
        vec4(0.8, 0.1, 0.1, 1.0),
        vec4(0.8, 0.7, 0.1, 1.0),
        vec4(0.1, 0.6, 0.1, 1.0),
        vec4(0.1, 0.6, 0.7, 1.0),
        vec4(0.1, 0.1, 0.8, 1.0),
        vec4(0.6, 0.1, 0.6, 1.0),
    ];
    let at = level as usize;
    COLORS[at % 6].lerp(COLORS[(at + 1) % 6], level.fract())
}

/// A small picture that fills all of a large one.
fn magnified(texture: &Texture) -> Result<Picture, Box<dyn Error>> {
    let mut frame = Framebuffer::new(SIZE.0, SIZE.1, Vec4::W)?;
    let quad = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), vec2(x + 1.0, 1.0 - y) / 2.0));
    ZBufferRenderer::new(frame.viewport())
        .draw(&mut frame, &quad, |fragment| texture.sample(Vec2::from(fragment.params)));
    Ok(frame)
}

// ---------------------------------------------------------------------------------------- textures

/// A board of 10 x 10 fields.
fn checker(width: u32, height: u32) -> Result<Texture, Box<dyn Error>> {
    let (light, dark) = (vec4(0.85, 0.8, 0.7, 1.0), vec4(0.05, 0.03, 0.02, 1.0));
    Ok(Texture::from_fn(width, height, |x, y| {
        if (x * 10 / width + y * 10 / height).is_multiple_of(2) { light } else { dark }
    })?)
}

/// A picture with detail of every size, as photographs have it: octaves of noise, each of half the size
/// and half the strength of the one before, and edges.
fn photo(width: u32, height: u32) -> Result<Texture, Box<dyn Error>> {
    let noise = |x: u32, y: u32, seed: u32| {
        let bits = (x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B) ^ seed)
            .wrapping_mul(0xC2B2_AE35);
        ((bits ^ bits >> 15).wrapping_mul(0x27D4_EB2F) >> 8) as f32 / 16_777_216.0
    };
    let octaves = |x: u32, y: u32, seed: u32| -> f32 {
        let octave = |power: u32| {
            let (i, j, cells) = (x << power, y << power, 1 << power);
            let (fx, fy) = ((i % width) as f32 / width as f32, (j % height) as f32 / height as f32);
            let (i, j) = (i / width, j / height);
            let at = |a: u32, b: u32| noise((i + a) % cells, (j + b) % cells, seed + power);
            let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
            let (fx, fy) = (smooth(fx), smooth(fy));
            let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
            mix(mix(at(0, 0), at(1, 0), fx), mix(at(0, 1), at(1, 1), fx), fy) - 0.5
        };
        (2..8).map(|power| octave(power) * 0.5_f32.powi(power as i32 - 2)).sum()
    };
    Ok(Texture::from_fn(width, height, |x, y| {
        let [a, b, c] = [1, 77, 154].map(|seed| octaves(x, y, seed * 1000));
        let edge = if a + 0.3 * b > 0.1 { 0.25 } else { 0.0 };
        let shade = |c: f32| (0.3 + 0.35 * c + edge).clamp(0.02, 1.0).powi(2);
        vec4(shade(a), shade(0.6 * a + 0.4 * b), shade(0.5 * a + 0.5 * c), 1.0)
    })?)
}

/// A picture of 8 x 6 texels.
fn checker_of_colors() -> Result<Texture, Box<dyn Error>> {
    Ok(Texture::from_fn(8, 6, |x, y| match (x * 5 + y * 3) % 7 {
        0 => vec4(0.9, 0.2, 0.1, 1.0),
        1 | 4 => vec4(0.9, 0.85, 0.7, 1.0),
        2 => vec4(0.1, 0.3, 0.7, 1.0),
        _ => vec4(0.05, 0.05, 0.08, 1.0),
    })?)
}

// ------------------------------------------------------------------------------------------- sheet

/// Pictures side by side.
struct Sheet(Framebuffer<Vec4>);

impl Sheet {
    const COLUMNS: u32 = 3;
    const GAP: u32 = 6;

    fn new(columns: u32, rows: u32) -> Result<Self, Box<dyn Error>> {
        let paper = vec4(0.9, 0.89, 0.86, 1.0);
        let side = |count: u32, size: u32| count * (size + Self::GAP) + Self::GAP;
        Ok(Self(Framebuffer::new(side(columns, SIZE.0), side(rows, SIZE.1), paper)?))
    }

    fn put(&mut self, place: u32, picture: &Picture) {
        let (column, row) = (place % Self::COLUMNS, place / Self::COLUMNS);
        let left = (Self::GAP + column * (SIZE.0 + Self::GAP)) as usize;
        let top = (Self::GAP + row * (SIZE.1 + Self::GAP)) as usize;
        let (width, len) = (self.0.width() as usize, SIZE.0 as usize);
        for (y, pixels) in picture.color().chunks_exact(len).enumerate() {
            let start = (top + y) * width + left;
            self.0.color_mut()[start..start + len].copy_from_slice(pixels);
        }
    }

    /// Puts a picture with a part of it in its lower right corner, three times as large.
    fn put_with_crop(&mut self, place: u32, picture: &Picture) {
        const CROP: (u32, u32) = (48, 32);
        let mut with_crop = picture.clone();
        let (left, top) = (SIZE.0 - 3 * CROP.0, SIZE.1 - 3 * CROP.1);
        let corner = (SIZE.0 / 2 - CROP.0 / 2, SIZE.1 * 3 / 10);
        for (x, y) in (0..3 * CROP.0).flat_map(|x| (0..3 * CROP.1).map(move |y| (x, y))) {
            let from = (corner.1 + y / 3) * SIZE.0 + corner.0 + x / 3;
            let to = (top + y) * SIZE.0 + left + x;
            let frame = x < 2 || y < 2;
            let color = if frame { Vec4::ONE } else { picture.color()[from as usize] };
            with_crop.color_mut()[to as usize] = color;
        }
        self.put(place, &with_crop);
    }
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    output: PathBuf,
    samples: u32,
    tilt: f32,
    roll: f32,
    table: bool,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            output: "target/textures.png".into(),
            samples: 256,
            tilt: 80.0,
            roll: 0.0,
            table: false,
        };
        let mut parser = Parser::from_env();
        let degrees = |parser: &mut Parser, most| -> Result<f32, Box<dyn Error>> {
            Ok(parser.value()?.parse_with(|text| cli::number(text, 0..=most))? as f32)
        };
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Long("output") => options.output = cli::png(parser.value()?)?,
                Arg::Long("samples") => {
                    options.samples =
                        parser.value()?.parse_with(|text| cli::number(text, 1..=512))?;
                }
                Arg::Long("tilt") => options.tilt = degrees(&mut parser, 89)?,
                Arg::Long("roll") => options.roll = degrees(&mut parser, 359)?,
                Arg::Long("table") => options.table = true,
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                _ => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}
