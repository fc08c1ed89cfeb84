//! The renderers against each other: layers over the whole view, from 1 to 64, that lie in any order
//! and cross; and a ring of 69,696 triangles. Each with a cheap shader, a costly one, and as glass.
//!
//! ```text
//! RAYON_NUM_THREADS=1 cargo bench -p polyscan-benches --bench renderers
//! RAYON_NUM_THREADS=1 cargo bench -p polyscan-benches --bench renderers -- glass ring
//! ```
//!
//! Prints Markdown tables of milliseconds a frame, clearing included: medians of interleaved rounds,
//! of which there are seven, or as many as fit into some seconds, and at least five. The painter's
//! tree is built beforehand; that time has a column of its own. Without `RAYON_NUM_THREADS` all
//! processors take part.

use std::f32::consts::TAU;
use std::time::Instant;

use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Vec2, Vec3, Vec4, vec3, vec4};
use polyscan::render::{Over, Paint};
use polyscan::{
    BspTree, Fragment, Framebuffer, Mesh, PainterRenderer, ScanlineRenderer, SizeError, Vertex,
    ZBufferRenderer,
};

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
const ROUNDS: usize = 7;
const LEAST_ROUNDS: usize = 5;
/// Rounds beyond the least begin only before this.
const SECONDS: f64 = 5.0;

/// Faces in clip space.
struct Scene {
    name: String,
    vertices: Vec<Vertex<3>>,
    faces: Vec<Vec<u32>>,
    tree: BspTree<3>,
    build_milliseconds: f64,
}

impl Scene {
    fn new(name: String, vertices: Vec<Vertex<3>>, faces: Vec<Vec<u32>>) -> Self {
        let start = Instant::now();
        let tree = BspTree::new(&vertices, &faces);
        let build_milliseconds = milliseconds(start);
        Self { name, vertices, faces, tree, build_milliseconds }
    }

    /// Quads over the whole view, seen in perspective, at random depths and of random tilts.
    fn layers(count: u32) -> Self {
        let mut seed = 1u64;
        // Knuth's MMIX generator (The Art of Computer Programming 2, 3.3.4), its 24 highest bits.
        let mut random = |low: f32, high: f32| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (seed >> 40) as f32 / (1 << 24) as f32
        };
        let mut vertices = Vec::new();
        for _ in 0..count {
            let [across, down] = [0; 2].map(|_| random(-0.1, 0.1));
            let depth = random(0.3, 0.7);
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let z = depth + across * x + down * y;
                // z/w = 1.1 - 1/w is a perspective projection.
                let w = 1.0 / (1.1 - z);
                vertices.push(Vertex::new(vec4(x, y, z, 1.0) * w, vec3(x, y, depth)));
            }
        }
        let faces = (0..count).map(|i| (4 * i..4 * i + 4).collect()).collect();
        Self::new(count.to_string(), vertices, faces)
    }

    /// A ring of triangles, most of it in view.
    fn ring() -> Self {
        const AROUND: u32 = 264;
        const ACROSS: u32 = 132;
        let camera = perspective(0.7, WIDTH as f32 / HEIGHT as f32, 1.0, 8.0)
            * look_at_mat4(vec3(0.0, 2.2, 3.2), Vec3::ZERO, Vec3::Y);
        let vertex = |i: u32| {
            let turn = |i: u32, n: u32| Vec2::from_angle(TAU * (i % n) as f32 / n as f32);
            let (around, across) = (turn(i / ACROSS, AROUND), turn(i, ACROSS));
            let normal = vec3(around.x * across.x, across.y, around.y * across.x);
            let middle = vec3(around.x, 0.0, around.y);
            Vertex::new(camera * (middle + 0.4 * normal).extend(1.0), normal)
        };
        let triangles = |i: u32| {
            let index =
                |j: u32, k: u32| (i / ACROSS + j) % AROUND * ACROSS + (i % ACROSS + k) % ACROSS;
            let [a, b, c, d] = [index(0, 0), index(0, 1), index(1, 1), index(1, 0)];
            [vec![a, b, c], vec![a, c, d]]
        };
        let vertices = (0..AROUND * ACROSS).map(vertex).collect();
        Self::new("ring".into(), vertices, (0..AROUND * ACROSS).flat_map(triangles).collect())
    }
}

// ----------------------------------------------------------------------------------------- shaders

/// Eight bits a channel of values from -1 to 1.
fn packed(color: [f32; 3]) -> u32 {
    let [r, g, b] = color.map(|c| (127.5 + 127.5 * c) as u32 & 255);
    r | g << 8 | b << 16
}

fn cheap(f: &Fragment<'_, 3>) -> u32 {
    packed(f.params)
}

/// Veins from sums of sines, as in solid textures (Perlin, "An Image Synthesizer", 1985).
fn costly(f: &Fragment<'_, 3>) -> u32 {
    let p = Vec3::from(f.params);
    let mut sum = 0.0;
    for octave in 0..4 {
        let frequency = (3 << octave) as f32;
        let wave = (p * frequency + sum).dot(vec3(0.7, 1.1, 1.3));
        sum += wave.sin() / frequency;
    }
    let vein = (6.0 * p.x + 9.0 * sum).sin();
    packed([vein, vein * vein, vein.abs().sqrt()])
}

fn glass(f: &Fragment<'_, 3>) -> Over {
    let [r, g, b] = f.params.map(|c| 0.15 + 0.15 * c);
    Over(vec4(r, g, b, 0.3))
}

// ------------------------------------------------------------------------------------------ timing

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// The median of each column.
fn medians<const K: usize>(rounds: &[[f64; K]]) -> [f64; K] {
    std::array::from_fn(|column| {
        let mut times: Vec<f64> = rounds.iter().map(|round| round[column]).collect();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    })
}

/// Times z-buffer, scanline, painter by tree, painter by depth. As glass, the z-buffer draws the
/// faces as they come, without storing depth: that is the same work as in the right order.
fn time<C, R>(
    scene: &Scene,
    background: C,
    is_glass: bool,
    shader: impl Fn(&Fragment<'_, 3>) -> R + Sync,
) -> Result<[f64; 4], SizeError>
where
    C: Copy + Send + Sync,
    R: Paint<C>,
{
    let Scene { vertices, faces, tree, .. } = scene;
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, background)?;
    let mut z_buffer = ZBufferRenderer::new(frame.viewport());
    z_buffer.depth_write = !is_glass;
    let mut scanline = ScanlineRenderer::new(frame.viewport());
    let mut painter = PainterRenderer::new(frame.viewport());
    let mut rounds = Vec::new();
    let begin = Instant::now();
    // The first round allocates, and is left out.
    while rounds.len() <= LEAST_ROUNDS
        || rounds.len() <= ROUNDS && begin.elapsed().as_secs_f64() < SECONDS
    {
        let mut round = [0; 4].map(|_| 0.0);
        for (renderer, time) in round.iter_mut().enumerate() {
            let start = Instant::now();
            frame.clear(background, 1.0);
            match renderer {
                0 => z_buffer.draw(&mut frame, Mesh::new(vertices, faces), &shader),
                1 => {
                    let all = |_| is_glass;
                    let mesh = Mesh::new(vertices, faces).with_transparent(&all);
                    scanline.draw(&mut frame, mesh, &shader);
                }
                2 => painter.draw(&mut frame, tree.seen_by(Mat4::IDENTITY), &shader),
                _ => painter.draw(&mut frame, Mesh::new(vertices, faces).back_to_front(), &shader),
            }
            *time = milliseconds(start);
        }
        rounds.push(round);
    }
    Ok(medians(&rounds[1..]))
}

/// A table of scenes by renderers.
fn table(scenes: &[Scene], kind: &str) -> Result<(), SizeError> {
    println!("\n| {kind} | z-buffer | scanline | painter | by depth | pieces | tree built |");
    println!("|---|---|---|---|---|---|---|");
    for scene in scenes {
        let times = match kind {
            "cheap" => time(scene, 0, false, cheap),
            "costly" => time(scene, 0, false, costly),
            _ => time(scene, Vec4::W, true, glass),
        }?;
        let [z_buffer, scanline, painter, by_depth] = times.map(|time| match time {
            0.0..100.0 => format!("{time:.1}"),
            _ => format!("{time:.0}"),
        });
        let Scene { name, tree, build_milliseconds, .. } = scene;
        let pieces = tree.pieces();
        println!(
            "| {name} | {z_buffer} | {scanline} | {painter} | {by_depth} | {pieces} | {build_milliseconds:.1} |"
        );
    }
    Ok(())
}

fn main() -> Result<(), SizeError> {
    let words: Vec<_> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let wants = |names: &[&str], name: &str| {
        let chosen = |word: &String| names.contains(&word.as_str());
        !words.iter().any(chosen) || words.iter().any(|word| word == name)
    };
    let mut scenes = Vec::new();
    if wants(&["layers", "ring"], "layers") {
        scenes.extend((0..7).map(|i| Scene::layers(1 << i)));
    }
    if wants(&["layers", "ring"], "ring") {
        scenes.push(Scene::ring());
    }
    println!("{WIDTH} x {HEIGHT}, {} threads, milliseconds", rayon::current_num_threads());
    let kinds = ["cheap", "costly", "glass"];
    kinds.iter().filter(|kind| wants(&kinds, kind)).try_for_each(|kind| table(&scenes, kind))
}
