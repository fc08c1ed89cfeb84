//! The workloads w1 .. w6 that other renderers are timed on, read from the folder that the
//! environment variable `PEERS_SCENES` names, from the root of the workspace if the name is a
//! relative one. Prints one line a scene, in the peers' format:
//!
//! ```text
//! PEERS_SCENES=folder cargo bench -p polyscan-benches --bench peers -- w1 w3
//! ```
//!
//! Times are the medians of all frames drawn in 0.9 seconds (`PB_MS` milliseconds if set), in
//! milliseconds a frame. `RAYON_NUM_THREADS` sets the number of threads. With `PER_FRAGMENT` set, the
//! shaders are called for one fragment at a time instead of for blocks. `LEVEL` names the SIMD
//! instructions to use: sse2, sse4.2, avx2 or avx512, and with the feature `fallback` also fallback,
//! which is none. With `DUMP` set, each picture is written to the folder as a PPM file.
//!
//! `FILTER` has the textured scenes drawn through a `Texture` of 8-bit sRGB instead of a table: nearest,
//! bilinear, trilinear or anisotropic, by 16 probes.
//!
//! `SAMPLES` is 4, 8 or 16: so many samples a pixel, without resolving them, where no `FILTER` is named.
//!
//! `w1_equal` is the quad of w1 with its vertices divided by w: the same pixels, without a division.
//!
//! # Against rivals
//!
//! An argument `name=command` names a rival: a command that, with a scene's name behind it, prints a
//! line like those here. Then each scene is drawn by this program and by each rival in turns, since a
//! machine's speed may change from minute to minute, in nine rounds (`ROUNDS` if set). A table has the
//! medians, the fastest frames in brackets, and the ratios: how many times as long the rival takes.
//!
//! ```text
//! PEERS_SCENES=folder LEVEL=avx2 RAYON_NUM_THREADS=1 cargo bench -p polyscan-benches --bench peers -- \
//!     'limit=ISA=avx2 ../speed_of_light' 'two threads=RAYON_NUM_THREADS=2 $PEERS'
//! ```
//!
//! `$PEERS` is this program, and commands are run in the folder of the package `benches`.

use std::error::Error;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use fearless_simd::Level;
use glam::{Mat4, Vec3, Vec4};
use polyscan::color::Color;
use polyscan::render::{MultisampleFramebuffer, MultisampleRenderer, Samples};
use polyscan::texture::{self, Filter, MipFilter, Texture};
use polyscan::{ClipSpace, Cull, FootprintBlock, Framebuffer, Mesh, Vertex, ZBufferRenderer};

const SCENES: [&str; 11] =
    ["w1", "w1_equal", "w2b", "w2f", "w3", "w4", "w5_2", "w5_4", "w5_8", "w5_16", "w6"];

/// A scene file: triangles with `parameters` floats at each vertex besides the position.
struct Scene {
    width: u32,
    height: u32,
    parameters: usize,
    kind: Kind,
    cull: bool,
    clip_from_object: Mat4,
    /// Position and parameters of each vertex.
    vertices: Vec<f32>,
    triangles: Vec<[u32; 3]>,
}

/// What the parameters are, by the number in the file.
#[derive(Clone, Copy)]
enum Kind {
    Texture,
    Normal,
    Color,
    Sum,
}

impl Scene {
    fn load(folder: &Path, name: &str) -> Result<Self, Box<dyn Error>> {
        match name.strip_suffix("_equal") {
            Some(name) => Ok(Self::read(folder, name)?.with_equal_w()),
            None => Self::read(folder, name),
        }
    }

    fn read(folder: &Path, name: &str) -> Result<Self, Box<dyn Error>> {
        let words = words(&folder.join(format!("{name}.bin")))?;
        let [_, width, height, vertices, triangles, parameters, kind, cull] =
            words.first_chunk().copied().ok_or("the header is incomplete")?;
        let float = |word: &u32| f32::from_bits(*word);
        let matrix: Vec<f32> = words[8..24].iter().map(float).collect();
        let parameters = parameters as usize;
        let end = 24 + vertices as usize * (3 + parameters);
        Ok(Self {
            width,
            height,
            parameters,
            kind: [Kind::Texture, Kind::Normal, Kind::Color, Kind::Sum][kind as usize & 3],
            cull: cull != 0,
            // The file has it row by row.
            clip_from_object: Mat4::from_cols_slice(&matrix).transpose(),
            vertices: words[24..end].iter().map(float).collect(),
            triangles: words[end..end + 3 * triangles as usize].as_chunks().0.to_vec(),
        })
    }

    /// The same on the screen, for vertices in front of the eye, with w = 1 all over.
    fn with_equal_w(mut self) -> Self {
        for vertex in self.vertices.chunks_exact_mut(3 + self.parameters) {
            let position = self.clip_from_object.project_point3(Vec3::from_slice(vertex));
            position.write_to_slice(vertex);
        }
        self.clip_from_object = Mat4::IDENTITY;
        self
    }

    /// The vertices in clip space, into memory that is used again.
    fn transform<const N: usize>(&self, clip: &mut Vec<Vertex<N>>) {
        clip.clear();
        clip.extend(self.vertices.chunks_exact(3 + N).map(|v| Vertex {
            position: self.clip_from_object * Vec3::new(v[0], v[1], v[2]).extend(1.0),
            params: std::array::from_fn(|i| v[3 + i]),
        }));
    }
}

fn words(path: &Path) -> Result<Vec<u32>, Box<dyn Error>> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect())
}

/// A float that is not negative as an integer, without the checks of `as`: they cost more than the
/// rest of a simple shader.
#[inline(always)]
fn truncate(value: f32) -> u32 {
    // From 2^23 on floats are whole numbers: adding rounds to nearest, so take half off before.
    (value - 0.499_999_97 + 8_388_608.0).to_bits() & 0x007f_ffff
}

#[inline(always)]
fn grey(level: f32) -> u32 {
    0xff00_0000 | (truncate(level) * 0x0001_0101)
}

#[inline(always)]
fn lit(normal: [f32; 3]) -> u32 {
    const LIGHT: [f32; 3] = [0.398_015, 0.597_022, 0.696_526];
    let dot = normal[0] * LIGHT[0] + normal[1] * LIGHT[1] + normal[2] * LIGHT[2];
    grey(30.0 + 225.0 * dot.clamp(0.0, 1.0))
}

#[inline(always)]
fn colored(rgb: [f32; 3]) -> u32 {
    let [r, g, b] = rgb.map(|c| truncate(c.clamp(0.0, 1.0) * 255.0));
    0xff00_0000 | r | g << 8 | b << 16
}

/// Where in a texture of 512 x 512, repeated, a texel is.
#[inline(always)]
fn texel([u, v]: [f32; 2]) -> u32 {
    // Adding 1.5 * 2^23 leaves the nearest integer in the lowest bits, of negative numbers too: half a
    // texel less, and a bit less than that for those that lie between two, rounds down.
    let texel = |c: f32| (c * 512.0 - 0.499_97 + 12_582_912.0).to_bits() & 511;
    let [column, row] = [u, v].map(texel);
    row << 9 | column
}

#[inline(always)]
fn summed<const N: usize>(params: &[f32; N]) -> u32 {
    let sum = params.iter().fold(0.0, |sum, r| sum + r);
    grey(sum * (1.0 / N as f32) * 255.0)
}

/// The level that `LEVEL` names, else the best.
fn level() -> Result<Level, Box<dyn Error>> {
    let best = Level::new();
    let Ok(name) = std::env::var("LEVEL") else { return Ok(best) };
    let level = match name.as_str() {
        #[cfg(feature = "fallback")]
        "fallback" => Some(Level::fallback()),
        #[cfg(target_arch = "x86_64")]
        "sse2" => best.as_sse2().map(fearless_simd::Simd::level),
        #[cfg(target_arch = "x86_64")]
        "sse4.2" => best.as_sse4_2().map(fearless_simd::Simd::level),
        #[cfg(target_arch = "x86_64")]
        "avx2" => best.as_avx2().map(fearless_simd::Simd::level),
        #[cfg(target_arch = "x86_64")]
        "avx512" => best.as_avx512().map(fearless_simd::Simd::level),
        _ => None,
    };
    level.ok_or_else(|| format!("this machine has no level {name}").into())
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Draws the triangles of a scene, given their vertices in clip space.
type Draw<'d, const N: usize> =
    &'d mut dyn FnMut(&mut ZBufferRenderer<N>, &mut Framebuffer<u32>, &[Vertex<N>]);

/// Times frames: clearing and drawing apart.
fn time_frames<const N: usize>(
    folder: &Path,
    name: &str,
    scene: &Scene,
    draw: Draw<'_, N>,
) -> Result<(), Box<dyn Error>> {
    let mut frame = Framebuffer::new(scene.width, scene.height, 0u32)?;
    let mut renderer = ZBufferRenderer::<N>::new(frame.viewport());
    renderer.simd_level = level()?;
    renderer.settings.clip_space = ClipSpace::MinusOneToOne;
    renderer.settings.cull = if scene.cull { Cull::Back } else { Cull::None };
    let mut vertices = Vec::new();
    let budget = std::env::var("PB_MS").ok().and_then(|ms| ms.parse().ok()).unwrap_or(900.0);
    let (mut clears, mut renders, mut totals) = (Vec::new(), Vec::new(), Vec::new());
    let start = Instant::now();
    let milliseconds = |since: Instant| since.elapsed().as_secs_f64() * 1e3;
    while renders.len() < 5 || milliseconds(start) < budget {
        let begin = Instant::now();
        frame.clear(0, 1.0);
        let cleared = Instant::now();
        scene.transform(&mut vertices);
        draw(&mut renderer, &mut frame, &vertices);
        renders.push(milliseconds(cleared));
        totals.push(milliseconds(begin));
        clears.push(totals[totals.len() - 1] - renders[renders.len() - 1]);
    }
    let covered = frame.depth().iter().filter(|&&depth| depth < 1.0).count();
    if std::env::var_os("DUMP").is_some() {
        dump(&folder.join(format!("{name}_polyscan.ppm")), &frame)?;
    }
    let render = median(&mut renders);
    println!(
        "RESULT polyscan {name} render={render:.4} total={:.4} clear={:.4} min_render={:.4} frames={} covered={covered}",
        median(&mut totals),
        median(&mut clears),
        renders[0],
        renders.len(),
    );
    Ok(())
}

fn run<const N: usize>(
    folder: &Path,
    name: &str,
    scene: &Scene,
    shade: impl Fn(&[f32; N]) -> u32 + Sync,
    look_up: impl Fn(u32) -> u32 + Sync,
) -> Result<(), Box<dyn Error>> {
    let per_fragment = std::env::var_os("PER_FRAGMENT").is_some();
    if let Some(samples) = samples()? {
        return run_multisampled(name, scene, samples, shade, look_up);
    }
    time_frames(folder, name, scene, &mut |renderer, frame, vertices| {
        if per_fragment {
            renderer
                .draw(frame, Mesh::new(vertices, &scene.triangles), |f| look_up(shade(&f.params)));
        } else {
            renderer.draw_blocks(frame, Mesh::new(vertices, &scene.triangles), |block, colors| {
                for (lane, color) in colors.iter_mut().enumerate() {
                    *color = shade(&std::array::from_fn(|i| block.params[i][lane]));
                }
                // Looked up in a loop of its own: the first can be SIMD where this one can not.
                for color in colors {
                    *color = look_up(*color);
                }
            });
        }
    })
}

/// How many samples a pixel has, if `SAMPLES` says so.
fn samples() -> Result<Option<Samples>, Box<dyn Error>> {
    Ok(match std::env::var("SAMPLES").as_deref() {
        Err(_) => None,
        Ok("4") => Some(Samples::Four),
        Ok("8") => Some(Samples::Eight),
        Ok("16") => Some(Samples::Sixteen),
        Ok(_) => return Err("SAMPLES is 4, 8 or 16".into()),
    })
}

/// The same as `run` with several samples a pixel.
fn run_multisampled<const N: usize>(
    name: &str,
    scene: &Scene,
    samples: Samples,
    shade: impl Fn(&[f32; N]) -> u32 + Sync,
    look_up: impl Fn(u32) -> u32 + Sync,
) -> Result<(), Box<dyn Error>> {
    let mut frame = MultisampleFramebuffer::new(scene.width, scene.height, samples, 0u32)?;
    let mut renderer = MultisampleRenderer::<N>::new(frame.viewport());
    renderer.simd_level = level()?;
    renderer.settings.clip_space = ClipSpace::MinusOneToOne;
    renderer.settings.cull = if scene.cull { Cull::Back } else { Cull::None };
    let budget = std::env::var("PB_MS").ok().and_then(|ms| ms.parse().ok()).unwrap_or(900.0);
    let (mut vertices, mut times) = (Vec::new(), Vec::new());
    let start = Instant::now();
    while times.len() < 5 || start.elapsed().as_secs_f64() * 1e3 < budget {
        frame.clear(0, 1.0);
        let cleared = Instant::now();
        scene.transform(&mut vertices);
        renderer.draw_blocks(
            &mut frame,
            Mesh::new(&vertices, &scene.triangles),
            |block, colors| {
                for (lane, color) in colors.iter_mut().enumerate() {
                    *color = shade(&std::array::from_fn(|i| block.params[i][lane]));
                }
                for color in colors {
                    *color = look_up(*color);
                }
            },
        );
        times.push(cleared.elapsed().as_secs_f64() * 1e3);
    }
    let render = median(&mut times);
    let frames = times.len();
    println!(
        "RESULT polyscan {name} render={render:.4} min_render={:.4} frames={frames}",
        times[0]
    );
    Ok(())
}

/// A textured scene by a filter of the library's own.
fn run_filtered(
    folder: &Path,
    name: &str,
    scene: &Scene,
    texture: &Texture,
) -> Result<(), Box<dyn Error>> {
    let code = |color: Vec4| u32::from_le_bytes(color.to_srgb8());
    let is_level_0 = texture.level_count() == 1;
    let per_fragment = std::env::var_os("PER_FRAGMENT").is_some();
    time_frames::<2>(folder, name, scene, &mut |renderer, frame, vertices| {
        let mesh = Mesh::new(vertices, &scene.triangles);
        match (per_fragment, is_level_0) {
            (true, true) => renderer.draw(frame, mesh, |f| code(texture.sample(f.params.into()))),
            (true, false) => {
                renderer.draw(frame, mesh, |f| code(texture.sample_footprint(&f.footprint(0, 1))));
            }
            (false, true) => renderer.draw_blocks(
                frame,
                mesh,
                #[inline(always)]
                |block, colors| {
                    let of = FootprintBlock { uv: block.params, ..FootprintBlock::default() };
                    *colors = texture.srgb8_block(&of, block.visible).map(u32::from_le_bytes);
                },
            ),
            (false, false) => renderer.draw_blocks(
                frame,
                mesh,
                #[inline(always)]
                |block, colors| {
                    let of = block.footprint(0, 1);
                    *colors = texture.srgb8_block(&of, block.visible).map(u32::from_le_bytes);
                },
            ),
        }
    })
}

/// The scenes' texture by the filter that `FILTER` names.
fn filtered(texels: &[u32], filter: &str) -> Result<Texture, Box<dyn Error>> {
    let bytes = texels.iter().flat_map(|texel| texel.to_le_bytes()).collect();
    let texture = Texture::from_samples(512, 512, 4, texture::Samples::Srgb8(bytes))?;
    Ok(match filter {
        "nearest" => texture.with_filter(Filter::Nearest),
        "bilinear" => texture,
        "trilinear" => texture.with_mipmaps()?,
        "anisotropic" => {
            texture.with_mipmaps()?.with_mip_filter(MipFilter::Anisotropic { probes: 16 })
        }
        _ => return Err("FILTER is nearest, bilinear, trilinear or anisotropic".into()),
    }
    .with_simd_level(level()?))
}

fn dump(path: &Path, frame: &Framebuffer<u32>) -> Result<(), Box<dyn Error>> {
    let mut bytes = format!("P6\n{} {}\n255\n", frame.width(), frame.height()).into_bytes();
    bytes.extend(frame.color().iter().flat_map(|c| c.to_le_bytes().into_iter().take(3)));
    Ok(std::fs::write(path, bytes)?)
}

/// What draws the scenes: a name, and a command that ends with a scene's name.
type Contestant = (String, String);

/// What one contestant took for one scene in all rounds, in milliseconds a frame.
#[derive(Clone, Default)]
struct Times {
    medians: Vec<f64>,
    fastest: f64,
}

impl Times {
    /// Takes the times of a round from what a contestant printed.
    fn add(&mut self, printed: &str) -> Option<()> {
        let line = printed.lines().find(|line| line.starts_with("RESULT"))?;
        let value = |name: &str| {
            let fields = &mut line.split_whitespace();
            fields.find_map(|field| field.strip_prefix(name))?.parse::<f64>().ok()
        };
        let (median, fastest) = (value("render=")?, value("min_render=")?);
        self.fastest = if self.medians.is_empty() { fastest } else { self.fastest.min(fastest) };
        self.medians.push(median);
        Some(())
    }
}

/// Lets this program and its rivals draw scenes in turns, and prints a table.
fn compare(names: &[String], rivals: &[String]) -> Result<(), Box<dyn Error>> {
    let rounds = std::env::var("ROUNDS").ok().and_then(|n| n.parse().ok()).unwrap_or(9);
    let own = std::env::current_exe()?;
    let rivals = rivals.iter().filter_map(|rival| rival.split_once('='));
    let rivals = rivals.map(|(name, command)| (name.to_owned(), command.to_owned()));
    let contestants: Vec<Contestant> =
        std::iter::once(("polyscan".into(), "$PEERS".into())).chain(rivals).collect();
    print!("{:>8}", "");
    contestants.iter().for_each(|(name, _)| print!(" {name:>24}"));
    println!();
    for scene in names {
        let mut times = vec![Times::default(); contestants.len()];
        for _ in 0..rounds {
            for ((name, command), times) in contestants.iter().zip(&mut times) {
                let command = format!("{command} {scene}");
                let output =
                    Command::new("sh").args(["-c", &command]).env("PEERS", &own).output()?;
                let printed = String::from_utf8_lossy(&output.stdout);
                times.add(&printed).ok_or_else(|| {
                    let said = String::from_utf8_lossy(&output.stderr);
                    format!("{name} printed no times for {scene}: `{command}` said {printed}{said}")
                })?;
            }
        }
        print!("{scene:>8}");
        let own = median(&mut times[0].medians);
        for (number, times) in times.iter_mut().enumerate() {
            let time = median(&mut times.medians);
            let ratio = if number == 0 { String::new() } else { format!("{:.2} x", time / own) };
            print!(" {:>24}", format!("{ratio} {time:.2} ({:.2})", times.fastest));
        }
        println!();
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = std::env::var_os("PEERS_SCENES") else {
        println!("skipped: PEERS_SCENES does not name the folder of the scenes");
        return Ok(());
    };
    // Cargo runs benchmarks in the folder of their package.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let arguments = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let (rivals, mut names): (Vec<_>, Vec<_>) = arguments.partition(|a| a.contains('='));
    if names.is_empty() {
        names = SCENES.map(String::from).to_vec();
    }
    if !rivals.is_empty() {
        return compare(&names, &rivals);
    }
    for name in &names {
        let scene = Scene::load(&folder, name)?;
        match (scene.kind, scene.parameters) {
            (Kind::Texture, _) => {
                let texels = words(&folder.join("tex.bin"))?;
                let texture: &[u32; 512 * 512] =
                    texels.first_chunk().ok_or("tex.bin is not 512 x 512")?;
                if let Ok(filter) = std::env::var("FILTER") {
                    run_filtered(&folder, name, &scene, &filtered(texture, &filter)?)?;
                    continue;
                }
                run(
                    &folder,
                    name,
                    &scene,
                    |&uv| texel(uv),
                    |texel| texture[texel as usize & 0x3_ffff],
                )?;
            }
            (Kind::Normal, _) => run(&folder, name, &scene, |&normal| lit(normal), |color| color)?,
            (Kind::Color, _) => run(&folder, name, &scene, |&rgb| colored(rgb), |color| color)?,
            (Kind::Sum, 2) => run(&folder, name, &scene, summed::<2>, |color| color)?,
            (Kind::Sum, 4) => run(&folder, name, &scene, summed::<4>, |color| color)?,
            (Kind::Sum, 8) => run(&folder, name, &scene, summed::<8>, |color| color)?,
            (Kind::Sum, 16) => run(&folder, name, &scene, summed::<16>, |color| color)?,
            (Kind::Sum, n) => return Err(format!("{name} has {n} parameters").into()),
        }
    }
    Ok(())
}
