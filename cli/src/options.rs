//! The options, and what is wrong with them.

use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand};
use polyscan::formats::Loader;
use polyscan::glam::{DMat4, Vec3, Vec4};

/// The largest side of a picture in memory, samples included; larger ones are streamed.
pub(crate) const MAX_SIDE: u32 = 65_536;

/// Draws pictures of 3D models (glTF, GLB, OBJ, PLY, STL) on the processor alone.
///
/// No GPU, no display and no system library is needed. The model is framed, lit from both sides and
/// antialiased. The picture is the same to the bit on every machine.
#[derive(Debug, Parser)]
#[command(
    name = "polyscan",
    version,
    about,
    arg_required_else_help = true,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_subcommand = true,
    after_help = EXAMPLES
)]
pub(crate) struct Options {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    /// Models, or folders of models; `-` is the standard input
    #[arg(required_unless_present_any = ["completions", "man"])]
    pub(crate) models: Vec<PathBuf>,
    /// The PNG file to write, `-` for the standard output; for several models a folder
    #[arg(short, long, value_name = "PATH")]
    pub(crate) output: Option<PathBuf>,
    /// Width and height in pixels, or one number for both; up to 65536
    #[arg(short, long, value_name = "SIZE", default_value = "800x600", value_parser = size)]
    pub(crate) size: (u32, u32),
    /// Antialiasing: samples a pixel in x and in y, from 1 to 8
    #[arg(long, value_name = "NUMBER", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub(crate) samples: u32,
    /// Background: `transparent`, or a colour as hexadecimal sRGB such as ffffff
    #[arg(short, long, value_name = "COLOUR", default_value = "transparent", value_parser = background)]
    pub(crate) background: Background,

    #[command(flatten)]
    pub(crate) eye: Eye,
    /// Matrix from the file's coordinates to clip space, 0 <= z <= w: 16 numbers, row by row
    #[arg(long, value_name = "NUMBERS", value_parser = matrix, allow_hyphen_values = true, conflicts_with_all = ["yaw", "pitch", "fov", "orthographic", "up", "intrinsics", "pose", "views", "turntable"], help_heading = "Camera")]
    pub(crate) matrix: Option<DMat4>,
    /// OpenCV's camera matrix as fx,fy,cx,cy in pixels; needs --pose
    #[arg(long, value_name = "NUMBERS", value_parser = intrinsics, requires = "pose", help_heading = "Camera")]
    pub(crate) intrinsics: Option<[f64; 4]>,
    /// OpenCV's pose, from the file's coordinates to the camera (x right, y down, z ahead): 12 or 16 numbers,
    /// row by row; needs --intrinsics
    #[arg(long, value_name = "NUMBERS", value_parser = pose, allow_hyphen_values = true, requires = "intrinsics", conflicts_with_all = ["yaw", "pitch", "fov", "orthographic", "up", "views", "turntable"], help_heading = "Camera")]
    pub(crate) pose: Option<DMat4>,

    /// A sheet of this many views; six are front, right, back, left, top and bottom
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..=64), conflicts_with = "turntable", help_heading = "What to draw")]
    pub(crate) views: Option<u32>,
    /// An animated PNG, or GIF, of a full turn in this many pictures
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=999), conflicts_with_all = ["ids", "depth", "normals"], help_heading = "What to draw")]
    pub(crate) turntable: Option<u16>,
    /// Draw the edges of all faces
    #[arg(long, help_heading = "What to draw")]
    pub(crate) wireframe: bool,
    /// Draw edges where the surface bends by more than 30 degrees, or ends, or turns away from the eye
    #[arg(long, help_heading = "What to draw")]
    pub(crate) edges: bool,
    /// Numbers of faces, from 1 on, as red + 256 green + 65536 blue; 0 is nothing
    #[arg(long, group = "data", conflicts_with_all = ["wireframe", "edges"], help_heading = "What to draw")]
    pub(crate) ids: bool,
    /// Distances along the view as 16-bit grey, from 1 (near) to 65535 (far); 0 is nothing. --json has the range
    #[arg(long, group = "data", conflicts_with_all = ["wireframe", "edges", "views"], help_heading = "What to draw")]
    pub(crate) depth: bool,
    /// Normals in the camera's axes, each as 255 (n + 1) / 2
    #[arg(long, group = "data", conflicts_with_all = ["wireframe", "edges"], help_heading = "What to draw")]
    pub(crate) normals: bool,

    #[command(flatten)]
    pub(crate) files: Files,
    /// Do one part of the work, for jobs on many machines: the k-th of n parts. Of several models it is every
    /// n-th, of one the rows of its picture, which, one below the other, are the whole picture to the bit
    #[arg(long, value_name = "K/N", value_parser = shard, conflicts_with_all = ["turntable", "views"], help_heading = "What to draw")]
    pub(crate) shard: Option<Shard>,
    /// Say what was done as one line of JSON a model
    #[arg(long, help_heading = "Messages")]
    pub(crate) json: bool,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages")]
    pub(crate) quiet: bool,
    /// Print the completions of a shell, and nothing else
    #[arg(long, value_name = "SHELL", help_heading = "Messages")]
    pub(crate) completions: Option<clap_complete::Shell>,
    /// Print the man page, and nothing else
    #[arg(long, help_heading = "Messages")]
    pub(crate) man: bool,
}

/// From where a model is seen.
#[derive(Clone, Debug, Args)]
pub(crate) struct Eye {
    /// The axis that is up: x, y, z, -x, -y or -z [default: z for STL, else y]
    #[arg(long, value_name = "AXIS", value_parser = axis, allow_hyphen_values = true, help_heading = "Camera")]
    pub(crate) up: Option<Vec3>,
    /// Turn of the camera around the model, in degrees to the right
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0, value_parser = degrees, allow_hyphen_values = true, help_heading = "Camera")]
    pub(crate) yaw: f32,
    /// Height of the camera over the model's level, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 20.0, value_parser = degrees, allow_hyphen_values = true, help_heading = "Camera")]
    pub(crate) pitch: f32,
    /// Vertical angle of view
    #[arg(long, value_name = "DEGREES", default_value_t = 34.0, value_parser = angle_of_view, help_heading = "Camera")]
    pub(crate) fov: f32,
    /// Parallel projection instead of perspective
    #[arg(long, help_heading = "Camera")]
    pub(crate) orthographic: bool,
}

/// How files are read.
#[derive(Clone, Debug, Args)]
pub(crate) struct Files {
    /// Computed normals are smooth where faces meet at less than this
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0, value_parser = degrees, help_heading = "Files")]
    pub(crate) crease: f32,
    /// A folder below which materials and textures of OBJ files may lie, besides the model's own
    #[arg(long, value_name = "FOLDER", help_heading = "Files")]
    pub(crate) root: Option<PathBuf>,
}

/// What is done besides drawing to files.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    View(ViewOptions),
}

/// Show a model in a window
///
/// Drag to turn it (with the right button to move it), scroll to come nearer. Keys: R next renderer, F next
/// filter of textures, A more samples a pixel, W wireframe, E edges, T turn by itself, P save a picture,
/// arrows turn, + and - come nearer and go away, 0 as at first, Q quit.
#[derive(Debug, Args)]
pub(crate) struct ViewOptions {
    /// The model
    pub(crate) model: PathBuf,
    /// Width and height of the window in pixels
    #[arg(short, long, value_name = "SIZE", default_value = "1280x720", value_parser = size)]
    pub(crate) size: (u32, u32),
    /// Antialiasing: samples a pixel in x and in y, from 1 to 4
    #[arg(long, value_name = "NUMBER", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4))]
    pub(crate) samples: u32,
    /// Background, as hexadecimal sRGB
    #[arg(short, long, value_name = "COLOUR", default_value = "d8e2ea", value_parser = background)]
    pub(crate) background: Background,
    #[command(flatten)]
    pub(crate) eye: Eye,
    #[command(flatten)]
    pub(crate) files: Files,
    /// Draw a full turn in so many pictures, say how long they took, and quit
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = "Messages")]
    pub(crate) frames: Option<u32>,
}

impl Files {
    /// What reads files so.
    pub(crate) fn loader(&self) -> Loader {
        let loader = Loader::new().with_crease_angle(self.crease.to_radians());
        match &self.root {
            Some(root) => loader.with_root(root),
            None => loader,
        }
    }
}

const EXAMPLES: &str = "\
Examples:
  polyscan model.glb -o picture.png
  polyscan part.stl -o part.png --size 256 --up z
  polyscan model.obj -o sheet.png --views 6 --size 300
  polyscan model.ply -o turn.png --turntable 36 --background ffffff
  cat model.stl | polyscan - -o - > picture.png
  polyscan models/ -o pictures/ --json
  polyscan view model.obj

The exit code is 0 if all pictures are written, 1 if one is not, and 2 if the options are wrong.";

/// A part of the work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shard {
    /// From 1 to `of`.
    number: u32,
    of: u32,
}

impl Shard {
    /// Whether it has an item of a list, counted from 0.
    pub(crate) fn has(self, item: usize) -> bool {
        item % self.of as usize == self.number as usize - 1
    }

    /// Its rows of so many.
    fn rows(self, height: u32) -> Range<u32> {
        let at = |part: u32| (u64::from(height) * u64::from(part) / u64::from(self.of)) as u32;
        at(self.number - 1)..at(self.number)
    }
}

/// What is behind the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Background(pub(crate) Vec4);

impl Options {
    /// What is wrong with options that are right one by one.
    pub(crate) fn check(&self) -> Result<(), String> {
        if self.output.is_none() {
            return Err("say where the picture goes, as in `-o picture.png`".into());
        }
        let (width, height) = self.size;
        if width.max(height) * self.samples > MAX_SIDE {
            return Err(format!(
                "{width} x {height} pixels of {0} x {0} samples are more than {MAX_SIDE} samples a side: \
                 choose fewer --samples",
                self.samples
            ));
        }
        let samples = u64::from(width) * u64::from(height) * u64::from(self.samples).pow(2);
        let needs_memory = self.views.is_some()
            || self.turntable.is_some()
            || self.ids
            || self.depth
            || self.normals;
        if needs_memory && samples > MAX_SAMPLES {
            return Err(format!(
                "the picture has {samples} samples, and at most {MAX_SAMPLES} fit with these options: \
                 choose a smaller --size or fewer --samples"
            ));
        }
        Ok(())
    }

    /// What is wrong with drawing a part of one picture.
    pub(crate) fn check_rows(&self) -> Result<(), String> {
        let (height, rows) = (self.size.1, self.rows());
        if self.shard.is_some() && self.depth {
            return Err(
                "the grey of --depth depends on the whole picture: draw it without --shard".into(),
            );
        }
        if rows.is_empty() {
            return Err(format!("a picture of {height} rows has at most so many shards"));
        }
        Ok(())
    }

    /// The rows of the picture that are drawn.
    pub(crate) fn rows(&self) -> Range<u32> {
        self.shard.map_or(0..self.size.1, |shard| shard.rows(self.size.1))
    }

    /// Whether the picture is too large to be drawn at once, so that it is streamed row by row.
    pub(crate) fn is_streamed(&self) -> bool {
        let (width, height) = self.size;
        u64::from(width) * u64::from(height) * u64::from(self.samples).pow(2) > MAX_SAMPLES
    }
}

/// The most samples that are in memory at once: 2^26, of 20 bytes each.
const MAX_SAMPLES: u64 = 1 << 26;

/// Refuses what is no name of a file that can be written.
pub(crate) fn check_output(
    path: &Path,
    is_animated: bool,
    (width, height): (u32, u32),
) -> Result<(), String> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("png" | "apng") => {}
        Some("gif") if is_animated && width.max(height) > u32::from(u16::MAX) => {
            let path = path.display();
            return Err(format!(
                "cannot write {path}: GIF files have at most {} pixels a side; choose a smaller --size, or a \
                 name that ends in .png",
                u16::MAX
            ));
        }
        Some("gif") if is_animated => {}
        Some("gif") => {
            let path = path.display();
            return Err(format!(
                "cannot write {path}: GIF files are for --turntable; choose a name that ends in .png"
            ));
        }
        _ => {
            let path = path.display();
            return Err(format!("cannot write {path}: choose a name that ends in .png"));
        }
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if path.is_dir() {
        return Err(format!("cannot write {}: it is a folder", path.display()));
    }
    if folder.is_dir() {
        return Ok(());
    }
    Err(format!("cannot write {}: there is no folder {}", path.display(), folder.display()))
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| {
        let number = text.parse().ok().filter(|number| (1..=MAX_SIDE).contains(number));
        number.ok_or_else(|| format!("write it as 800x600 or 256, with sides from 1 to {MAX_SIDE}"))
    };
    match text.split_once(['x', 'X']) {
        Some((width, height)) => Ok((side(width)?, side(height)?)),
        None => side(text).map(|side| (side, side)),
    }
}

fn background(text: &str) -> Result<Background, String> {
    if text == "transparent" || text == "none" {
        return Ok(Background(Vec4::ZERO));
    }
    let digits = text.strip_prefix('#').unwrap_or(text);
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
    let number = number.ok_or("write `transparent`, or six digits such as ffcc00")?;
    let [_, r, g, b] = number.to_be_bytes().map(polyscan::color::decode);
    Ok(Background(Vec4::new(r, g, b, 1.0)))
}

fn axis(text: &str) -> Result<Vec3, String> {
    let (sign, axis) = match text.strip_prefix('-') {
        Some(axis) => (-1.0, axis),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    match axis.to_ascii_lowercase().as_str() {
        "x" => Ok(Vec3::X * sign),
        "y" => Ok(Vec3::Y * sign),
        "z" => Ok(Vec3::Z * sign),
        _ => Err("name an axis: x, y, z, -x, -y or -z".into()),
    }
}

fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(number, of)| {
        Some(Shard { number: number.parse().ok()?, of: of.parse().ok()? })
    });
    let right = numbers.filter(|shard| (1..=shard.of).contains(&shard.number));
    right.ok_or_else(|| "write it as 1/8, up to 8/8".into())
}

fn degrees(text: &str) -> Result<f32, String> {
    let degrees = text.parse().ok().filter(|degrees: &f32| degrees.is_finite());
    degrees.ok_or_else(|| "give a number of degrees, such as 30 or -12.5".into())
}

fn angle_of_view(text: &str) -> Result<f32, String> {
    degrees(text)
        .ok()
        .filter(|degrees| (1.0..=170.0).contains(degrees))
        .ok_or_else(|| "give a number of degrees from 1 to 170".into())
}

/// So many numbers, with commas or blanks between them.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let words = text.split(|c: char| c == ',' || c == ';' || c.is_whitespace());
    let words = words.filter(|word| !word.is_empty());
    let number = |word: &str| word.parse().ok().filter(|number: &f64| number.is_finite());
    words.map(|word| number(word).ok_or_else(|| format!("`{word}` is not a number"))).collect()
}

fn matrix(text: &str) -> Result<DMat4, String> {
    let numbers: [f64; 16] = numbers(text)?.try_into().map_err(|numbers: Vec<f64>| {
        format!("it needs 16 numbers, and here are {}", numbers.len())
    })?;
    let matrix = DMat4::from_cols_array(&numbers).transpose();
    if matrix.determinant() == 0.0 {
        return Err("the matrix has no inverse: it sees nothing".into());
    }
    Ok(matrix)
}

fn intrinsics(text: &str) -> Result<[f64; 4], String> {
    let numbers: [f64; 4] = numbers(text)?.try_into().map_err(|numbers: Vec<f64>| {
        format!("it needs fx,fy,cx,cy, and here are {} numbers", numbers.len())
    })?;
    if numbers[0] <= 0.0 || numbers[1] <= 0.0 {
        return Err("fx and fy must be above 0".into());
    }
    Ok(numbers)
}

fn pose(text: &str) -> Result<DMat4, String> {
    let mut numbers = numbers(text)?;
    if numbers.len() == 12 {
        numbers.extend([0.0, 0.0, 0.0, 1.0]);
    }
    let count = numbers.len();
    let numbers: [f64; 16] = numbers
        .try_into()
        .map_err(|_| format!("it needs 12 or 16 numbers, and here are {count}"))?;
    Ok(DMat4::from_cols_array(&numbers).transpose())
}
