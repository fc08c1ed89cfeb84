//! Pictures that are warped without any 3-D: a photographed page is straightened, and a picture put on a billboard.
//!
//! The example makes the photograph itself, so that it knows what the page looked like. The mapping follows from the
//! page's four corners in the photograph, or from marks on it, more than there need be and each found only to a
//! quarter of a pixel. What it prints is how near the straightened page comes to the page.
//!
//! The sheet shows the photograph, the page straightened by its corners, and the billboard.
//!
//! ```text
//! cargo run --release --example warp
//! cargo run --release --example warp -- --picture target/wall.png
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use lexopt::{Arg, Parser, ValueExt as _};
use polyscan::color::Color;
use polyscan::glam::{DMat3, DVec2, Vec4, dvec2, vec3, vec4};
use polyscan::parameters::Projective;
use polyscan::texture::{Cubic, Filter, MipFilter, Texture, Wrap};
use polyscan::{Framebuffer, ZBufferRenderer};

mod cli;

const HELP: &str = "\
Straighten a photographed page, and put a picture on a billboard.

Usage: warp [OPTIONS]

Options:
      --output <FILE>    The PNG file to write [default: target/warp.png]
      --photo <PIXELS>   Width of the photograph, from 64 to 4096 [default: 1920]
      --picture <FILE>   The picture on the billboard, a PNG file
                         [default: examples/assets/pictures/cottage.png]
  -h, --help             Show this help
";

/// The sizes of the page and of the street.
const PAGE: (u32, u32) = (480, 640);
const STREET: (u32, u32) = (1280, 960);
/// The page's corners in the photograph, from the top left one on clockwise, as parts of its width.
const CORNERS: [DVec2; 4] =
    [dvec2(0.291, 0.056), dvec2(0.741, 0.086), dvec2(0.865, 0.705), dvec2(0.077, 0.641)];
/// The billboard's corners.
const BILLBOARD: [DVec2; 4] =
    [dvec2(310.0, 150.0), dvec2(1105.0, 262.0), dvec2(1088.0, 622.0), dvec2(322.0, 676.0)];

type Picture = Framebuffer<Vec4>;

fn main() -> ExitCode {
    cli::run(warp)
}

fn warp() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let page = filtered(Texture::from_fn(PAGE.0, PAGE.1, page)?)?;
    let photo_size = (options.photo, options.photo * 3 / 4);
    let corners = CORNERS.map(|corner| (corner * f64::from(options.photo)).round());
    let mut photo =
        picture(photo_size, |x, y| desk(x * 1920 / photo_size.0, y * 1440 / photo_size.1))?;
    let photograph = Projective::from_pairs(&unit_square_to(corners))?;
    put(&mut photo, &page, &photograph);

    // Photographs know texels; the mapping is from texture coordinates of the photograph to pixels of the page.
    let taken = filtered(Texture::new(photo_size.0, photo_size.1, photo.color().to_vec())?)?;
    let from_photo = |p: DVec2| p / dvec2(photo_size.0.into(), photo_size.1.into());
    let page_size = dvec2(PAGE.0.into(), PAGE.1.into());
    let by_corners = UNIT_SQUARE.map(|uv| uv * page_size);
    let pairs: [_; 4] = std::array::from_fn(|i| (from_photo(corners[i]), by_corners[i]));
    let mut straight = picture(PAGE, |_, _| Vec4::W)?;
    put(&mut straight, &taken, &Projective::from_pairs(&pairs)?);
    println!("straightened by its corners: {:.1} dB", psnr(&straight, &page));

    let mut by_marks = picture(PAGE, |_, _| Vec4::W)?;
    let marks = marks(&photograph, page_size).map(|(found, mark)| (from_photo(found), mark));
    put(&mut by_marks, &taken, &Projective::from_pairs(&marks)?);
    println!("by {} marks, each found to 1/4 pixel: {:.1} dB", marks.len(), psnr(&by_marks, &page));

    let mut street = picture(STREET, street)?;
    let poster = filtered(Texture::open(&options.picture)?)?;
    put(&mut street, &poster, &Projective::from_pairs(&unit_square_to(BILLBOARD))?);

    cli::make_folder_of(&options.output)?;
    side_by_side(&[&photo, &straight, &street])?.save_png(&options.output)?;
    println!("wrote {}", options.output.display());
    Ok(())
}

// ------------------------------------------------------------------------------------------- warps

/// A picture's corners as texture coordinates, from the top left one on clockwise.
const UNIT_SQUARE: [DVec2; 4] =
    [dvec2(0.0, 0.0), dvec2(1.0, 0.0), dvec2(1.0, 1.0), dvec2(0.0, 1.0)];

fn unit_square_to(corners: [DVec2; 4]) -> [(DVec2, DVec2); 4] {
    std::array::from_fn(|i| (UNIT_SQUARE[i], corners[i]))
}

/// The filter of all warps: bicubic where a picture is magnified, 16 probes where it is minified.
fn filtered(texture: Texture) -> Result<Texture, Box<dyn Error>> {
    let texture = texture.with_wrap(Wrap::Clamp).with_mipmaps()?;
    let texture = texture.with_mip_filter(MipFilter::Anisotropic { probes: 16 });
    Ok(texture.with_filter(Filter::Bicubic(Cubic::CATMULL_ROM)))
}

/// Draws a picture where a mapping takes its texture coordinates to pixels.
fn put(frame: &mut Picture, texture: &Texture, mapping: &Projective) {
    let viewport = frame.viewport();
    let mut renderer = ZBufferRenderer::new(viewport);
    renderer.draw_blocks(frame, &mapping.picture(&viewport), |block, colors| {
        *colors = texture.sample_footprint_block(&block.footprint(0, 1), block.visible);
    });
}

/// Twelve marks on the page: where each was found in the photograph, to a quarter of a pixel, and its pixel on the page.
fn marks(photograph: &Projective, page: DVec2) -> [(DVec2, DVec2); 12] {
    std::array::from_fn(|i| {
        let mark = dvec2((i % 3) as f64 * 0.4 + 0.1, (i / 3) as f64 * 0.28 + 0.08);
        // No mark is on the horizon.
        let place = photograph.at(mark).unwrap_or_default();
        ((place * 4.0).round() / 4.0, mark * page)
    })
}

/// The peak signal-to-noise ratio in decibels, of the colours as they are shown, without a border of 4 pixels, where
/// the photograph has what is beside the page.
fn psnr(picture: &Picture, truth: &Texture) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (x, y) in (4..PAGE.1 - 4).flat_map(|y| (4..PAGE.0 - 4).map(move |x| (x, y))) {
        let ours = picture.color()[(y * PAGE.0 + x) as usize];
        for (a, b) in ours.to_srgb8().into_iter().zip(truth.texel(x, y).to_srgb8()).take(3) {
            sum += (f64::from(a) - f64::from(b)).powi(2);
            count += 1.0;
        }
    }
    10.0 * (255.0_f64.powi(2) * count / sum).log10()
}

// ---------------------------------------------------------------------------------------- pictures

fn picture(
    (width, height): (u32, u32),
    color: impl Fn(u32, u32) -> Vec4,
) -> Result<Picture, Box<dyn Error>> {
    let mut frame = Framebuffer::new(width, height, Vec4::W)?;
    for (i, pixel) in (0..).zip(frame.color_mut()) {
        *pixel = color(i % width, i / width);
    }
    Ok(frame)
}

/// From 0 to 1 over the four pixels around an edge.
fn soft(distance: f32) -> f32 {
    let t = (distance / 4.0 + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// How much of a rectangle is at a point.
fn within([x, y]: [f32; 2], [left, top, right, bottom]: [f32; 4]) -> f32 {
    soft(x - left) * soft(right - x) * soft(y - top) * soft(bottom - y)
}

/// A number that looks random, from 0 to 1.
fn noise(a: u32, b: u32) -> f32 {
    let bits =
        (a.wrapping_mul(0x9E37_79B9) ^ b.wrapping_mul(0x85EB_CA6B)).wrapping_mul(0xC2B2_AE35);
    ((bits ^ bits >> 15).wrapping_mul(0x27D4_EB2F) >> 8) as f32 / 16_777_216.0
}

/// A page with a title, lines of words, and a figure.
fn page(x: u32, y: u32) -> Vec4 {
    let at = [x as f32 + 0.5, y as f32 + 0.5];
    let paper = vec3(0.86, 0.85, 0.80);
    let ink = within(at, [60.0, 48.0, 330.0, 72.0])
        .max(within(at, [60.0, 82.0, 220.0, 90.0]))
        .max(words(at));
    let [u, v] = [at[0] - 240.0, at[1] - 290.0];
    let disc = soft(62.0 - (u * u + v * v).sqrt());
    let checker = soft(4.0 * (u / 10.0).sin() * (v / 10.0).sin());
    let figure = within(at, [120.0, 215.0, 360.0, 365.0]);
    let figure_color = vec3(0.75, 0.62, 0.35)
        .lerp(vec3(0.10, 0.22, 0.45).lerp(vec3(0.70, 0.18, 0.10), checker), disc);
    paper.lerp(vec3(0.06, 0.06, 0.08), ink).lerp(figure_color, figure).extend(1.0)
}

/// Lines of words.
fn words(at: [f32; 2]) -> f32 {
    const LINE: f32 = 17.0;
    let [x, y] = at;
    let line = ((y - 110.0) / LINE).floor();
    if !(110.0..585.0).contains(&y) || (195.0..385.0).contains(&y) {
        return 0.0;
    }
    let top = 110.0 + line * LINE + 4.0;
    let (mut left, mut ink, mut word) = (60.0, 0.0f32, 0);
    while left < 400.0 {
        let width = 12.0 + 44.0 * noise(line as u32, word);
        ink = ink.max(within([x, y], [left, top, left + width, top + 7.0]));
        left += width + 9.0;
        word += 1;
    }
    ink
}

/// A desk of boards.
fn desk(x: u32, y: u32) -> Vec4 {
    let (board, along) = (y / 240, x + y / 240 * 517);
    let grain =
        (0..4).map(|i| noise(along >> (4 + i), (y >> i) + board * 31 + i * 7)).sum::<f32>() / 4.0;
    let gap = if y % 240 < 4 { 0.35 } else { 1.0 };
    (vec3(0.25, 0.13, 0.06) * (0.7 + 0.5 * grain) * gap).extend(1.0)
}

/// A billboard without a picture, before the sky in the evening.
fn street(x: u32, y: u32) -> Vec4 {
    let (u, v) = (x as f32, y as f32);
    let sky = vec3(0.10, 0.18, 0.40).lerp(vec3(0.85, 0.45, 0.25), (v / 760.0).min(1.0).powi(2));
    let roof = |left: f32, width: f32, top: f32| v > top && (left..left + width).contains(&u);
    let city = [
        (0, 0.0),
        (1, 150.0),
        (2, 290.0),
        (3, 480.0),
        (4, 650.0),
        (5, 800.0),
        (6, 1000.0),
        (7, 1150.0),
    ]
    .iter()
    .any(|&(i, left)| roof(left, 190.0, 560.0 + 160.0 * noise(i, 3)));
    let window = city && x % 26 < 9 && y % 34 < 14 && noise(x / 26, y / 34) > 0.7;
    let post = (430.0..455.0).contains(&u) || (985.0..1008.0).contains(&u);
    let frame = |distance: f32| {
        BILLBOARD.iter().zip(BILLBOARD.iter().cycle().skip(1)).all(|(a, b)| {
            let side = (*b - *a).normalize().perp_dot(dvec2(u.into(), v.into()) - *a);
            side as f32 > -distance
        })
    };
    let color = if v > 870.0 {
        vec3(0.05, 0.05, 0.06)
    } else if frame(14.0) {
        vec3(0.10, 0.10, 0.11)
    } else if post && v > 500.0 {
        vec3(0.07, 0.07, 0.08)
    } else if window {
        vec3(0.9, 0.7, 0.3)
    } else if city {
        vec3(0.04, 0.05, 0.09)
    } else {
        sky
    };
    color.extend(1.0)
}

/// Pictures on one sheet, all of the same height.
fn side_by_side(pictures: &[&Picture]) -> Result<Picture, Box<dyn Error>> {
    const GAP: u32 = 12;
    let height = 640;
    let scaled = |p: &Picture| f64::from(height) / f64::from(p.height());
    let width = |p: &Picture| (f64::from(p.width()) * scaled(p)).round() as u32;
    let total = pictures.iter().map(|p| width(p) + GAP).sum::<u32>() + GAP;
    let mut sheet = picture((total, height + 2 * GAP), |_, _| vec4(0.9, 0.89, 0.86, 1.0))?;
    let mut left = GAP;
    for &picture in pictures {
        let texture =
            filtered(Texture::new(picture.width(), picture.height(), picture.color().to_vec())?)?;
        let size = DVec2::new(width(picture).into(), height.into());
        let place =
            DMat3::from_translation(dvec2(left.into(), GAP.into())) * DMat3::from_scale(size);
        put(&mut sheet, &texture, &Projective::new(place)?);
        left += width(picture) + GAP;
    }
    Ok(sheet.downsampled(2)?)
}

// ----------------------------------------------------------------------------------------- options

struct Options {
    output: PathBuf,
    photo: u32,
    picture: PathBuf,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            output: "target/warp.png".into(),
            photo: 1920,
            picture: "examples/assets/pictures/cottage.png".into(),
        };
        let mut parser = Parser::from_env();
        while let Some(arg) = parser.next()? {
            match arg {
                Arg::Long("output") => options.output = cli::png(parser.value()?)?,
                Arg::Long("photo") => {
                    options.photo =
                        parser.value()?.parse_with(|text| cli::number(text, 64..=4096))?;
                }
                Arg::Long("picture") => options.picture = parser.value()?.into(),
                Arg::Short('h') | Arg::Long("help") => cli::show(HELP),
                _ => return Err(arg.unexpected().into()),
            }
        }
        Ok(options)
    }
}
