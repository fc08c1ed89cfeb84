//! Frames as people draw them: what a draw call costs whatever it draws, small pictures, threads, and
//! meshes of millions of faces.
//!
//! ```text
//! cargo bench -p polyscan-benches --bench frames
//! cargo bench -p polyscan-benches --bench frames -- calls game buffers occlusion thumbnail faces
//! ```
//!
//! Times are those of the clock, medians, with the fastest in brackets.

use std::error::Error;
use std::hint::black_box;
use std::process::Command;
use std::time::{Duration, Instant};

use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Vec3, Vec4};
use polyscan::fragment::LANES;
use polyscan::render::OcclusionRenderer;
use polyscan::{FragmentBlock, Framebuffer, Mesh, Target, Vertex, Viewport, ZBufferRenderer};

/// What the process itself is started with to draw one picture and end.
const COLD: &str = "--cold-process";

type Part = fn() -> Result<(), Box<dyn Error>>;

const PARTS: [(&str, Part); 6] = [
    ("calls", calls),
    ("game", game),
    ("buffers", buffers),
    ("occlusion", occlusion),
    ("thumbnail", thumbnail),
    ("faces", faces),
];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    if let [COLD, faces] = *arguments.iter().map(String::as_str).collect::<Vec<_>>() {
        return cold_process(faces.parse()?);
    }
    let chosen: Vec<_> = arguments.iter().filter(|argument| !argument.starts_with('-')).collect();
    for (name, part) in PARTS {
        if chosen.is_empty() || chosen.iter().any(|chosen| *chosen == name) {
            println!("\n{name}");
            part()?;
        }
    }
    Ok(())
}

/// The median and the least time of some runs, `per` of which are one.
fn report(what: &str, mut times: Vec<Duration>, per: u32) {
    times.sort_unstable();
    let [median, least] = [times[times.len() / 2], times[0]].map(|time| time / per);
    println!("{what:>50} {median:>12.3?} ({least:.3?})");
}

/// The times of `runs` calls, after one that does not count.
fn times(runs: usize, mut run: impl FnMut()) -> Vec<Duration> {
    run();
    let timed = |_| {
        let start = Instant::now();
        run();
        start.elapsed()
    };
    (0..runs).map(timed).collect()
}

/// Calls `f` with one thread, and with all.
fn with_threads(mut f: impl FnMut(&str) + Send) -> Result<(), Box<dyn Error>> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| f("one thread"));
    let all = rayon::ThreadPoolBuilder::new().build()?;
    let name = format!("{} threads", all.current_num_threads());
    all.install(|| f(&name));
    Ok(())
}

/// A colour of two parameters.
#[inline(always)]
fn shade(block: &mut FragmentBlock<'_, 2>, colors: &mut [u32; LANES]) {
    let [u, v] = &block.params;
    for (color, (u, v)) in colors.iter_mut().zip(u.iter().zip(v)) {
        *color = u.to_bits() ^ v.to_bits();
    }
}

/// 100,000 draw calls of one quad of 8 x 8 pixels each, and the same quads as one mesh.
fn calls() -> Result<(), Box<dyn Error>> {
    const CALLS: u16 = 50_000;
    let mut frame = Framebuffer::new(640, 480, 0u32)?;
    let mut renderer = ZBufferRenderer::<2>::new(frame.viewport());
    let quad = |i: u16| {
        let (column, row) = (f32::from(i % 79), f32::from(i / 79 % 59));
        let corner = |(x, y): (f32, f32)| {
            let (x, y) = ((column + x) / 40.0 - 1.0, 1.0 - (row + y) / 30.0);
            Vertex::new(Vec4::new(x, y, 0.5, 1.0), [x, y])
        };
        [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(corner)
    };
    let quads: Vec<_> = (0..CALLS).map(quad).collect();
    let fragments = times(9, || {
        frame.clear(0, 1.0);
        for _ in 0..2 {
            for quad in &quads {
                renderer.draw(&mut frame, quad, |f| f.params[0].to_bits() ^ f.params[1].to_bits());
            }
        }
    });
    report("a quad of 8 x 8 pixels, draw", fragments, u32::from(CALLS) * 2);
    let blocks = times(9, || {
        frame.clear(0, 1.0);
        (0..2).for_each(|_| quads.iter().for_each(|q| renderer.draw_blocks(&mut frame, q, shade)));
    });
    report("the same, draw_blocks", blocks, u32::from(CALLS) * 2);
    let triangles = times(9, || {
        frame.clear(0, 1.0);
        for _ in 0..2 {
            for quad in &quads {
                renderer.draw_blocks(&mut frame, Mesh::new(quad, [[0, 1, 2], [0, 2, 3]]), shade);
            }
        }
    });
    report("the same as a mesh of two triangles", triangles, u32::from(CALLS) * 2);
    let corners: Vec<Vertex<2>> = quads.concat();
    let faces: Vec<[u32; 4]> =
        (0..u32::from(CALLS)).map(|i| [0, 1, 2, 3].map(|k| 4 * i + k)).collect();
    with_threads(|threads| {
        let mesh = times(9, || {
            frame.clear(0, 1.0);
            (0..2)
                .for_each(|_| renderer.draw_blocks(&mut frame, Mesh::new(&corners, &faces), shade));
        });
        report(&format!("a quad of a mesh of them, {threads}"), mesh, u32::from(CALLS) * 2);
    })
}

/// A sphere of `2 columns rows` triangles in clip space, seen from outside.
fn sphere(columns: u16, rows: u16) -> (Vec<Vertex<2>>, Vec<[u32; 3]>) {
    use std::f32::consts::{PI, TAU};
    let view = perspective(0.8, 1.0, 0.1, 100.0)
        * look_at_mat4(Vec3::new(1.0, 1.5, 2.5), Vec3::ZERO, Vec3::Y);
    let (across, down) = (f32::from(columns), f32::from(rows));
    let places = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
    let vertices = places.map(|(column, row)| {
        let (u, v) = (f32::from(column) / across, f32::from(row) / down);
        let (longitude, latitude) = ((u * TAU).sin_cos(), (v * PI).sin_cos());
        let point = Vec3::new(longitude.1 * latitude.0, latitude.1, longitude.0 * latitude.0);
        Vertex::new(view * point.extend(1.0), [u, v])
    });
    let line = u32::from(columns) + 1;
    let squares = (0..u32::from(rows)).flat_map(|row| (0..line - 1).map(move |x| row * line + x));
    let triangles = squares.flat_map(|a| [[a, a + line, a + line + 1], [a, a + line + 1, a + 1]]);
    (vertices.collect(), triangles.collect())
}

/// The steady state of a game that draws 500 faces on 320 x 200 pixels.
fn game() -> Result<(), Box<dyn Error>> {
    let (vertices, faces) = sphere(25, 10);
    with_threads(|threads| {
        let Ok(mut frame) = Framebuffer::new(320, 200, 0u32) else { return };
        let mut renderer = ZBufferRenderer::<2>::new(frame.viewport());
        let frames = times(2001, || {
            frame.clear(0, 1.0);
            renderer.draw_blocks(&mut frame, Mesh::new(&vertices, &faces), shade);
            black_box(frame.color());
        });
        report(&format!("{} faces, 320 x 200, {threads}", faces.len()), frames, 1);
    })
}

/// A colour, parameters and the face at each pixel, in buffers of their own: in one pass, in three, and as one
/// buffer of structs.
fn buffers() -> Result<(), Box<dyn Error>> {
    const SIDE: u32 = 1024;
    let (vertices, faces) = sphere(200, 100);
    let pixels = (SIDE * SIDE) as usize;
    let mesh = || Mesh::new(&vertices, &faces);
    with_threads(|threads| {
        let (mut colors, mut uvs) = (vec![0u32; pixels], vec![[0.0f32; 2]; pixels]);
        let (mut ids, mut depths) = (vec![0u32; pixels], vec![1.0f32; pixels]);
        let mut structs = vec![(0u32, [0.0f32; 2], 0u32); pixels];
        let Ok(viewport) = Viewport::new(SIDE, SIDE) else { return };
        let mut renderer = ZBufferRenderer::<2>::new(viewport);
        let uv = |block: &mut FragmentBlock<'_, 2>, uvs: &mut [[f32; 2]; LANES]| {
            *uvs = std::array::from_fn(|lane| [block.params[0][lane], block.params[1][lane]]);
        };
        let one = times(101, || {
            depths.fill(1.0);
            let buffers = (&mut colors, &mut uvs, &mut ids);
            let Ok(mut target) = Target::of_buffers(SIDE, buffers, &mut depths) else { return };
            renderer.draw_blocks(&mut target, mesh(), |block, (colors, uvs, ids)| {
                shade(block, colors);
                uv(block, uvs);
                *ids = [block.face; LANES];
            });
        });
        report(&format!("three buffers of 1024 x 1024 in one pass, {threads}"), one, 1);
        let three = times(101, || {
            depths.fill(1.0);
            let Ok(mut target) = Target::new(SIDE, &mut colors, &mut depths) else { return };
            renderer.draw_blocks(&mut target, mesh(), shade);
            depths.fill(1.0);
            let Ok(mut target) = Target::new(SIDE, &mut uvs, &mut depths) else { return };
            renderer.draw_blocks(&mut target, mesh(), uv);
            depths.fill(1.0);
            let Ok(mut target) = Target::new(SIDE, &mut ids, &mut depths) else { return };
            renderer.draw_blocks(&mut target, mesh(), |block, ids| *ids = [block.face; LANES]);
        });
        report("in three passes", three, 1);
        let together = times(101, || {
            depths.fill(1.0);
            let Ok(mut target) = Target::new(SIDE, &mut structs, &mut depths) else { return };
            renderer.draw_blocks(&mut target, mesh(), |block, structs| {
                let (mut colors, mut uvs) = ([0; LANES], [[0.0; 2]; LANES]);
                shade(block, &mut colors);
                uv(block, &mut uvs);
                *structs = std::array::from_fn(|lane| (colors[lane], uvs[lane], block.face));
            });
        });
        report("in one pass, as structs", together, 1);
    })
}

/// The corners of a box in the order of their bits, and its sides.
fn cuboid([from, to]: [Vec3; 2]) -> ([Vec3; 8], [[u32; 4]; 6]) {
    let corner = |i: usize| {
        let choose = |axis: usize| if i >> axis & 1 == 0 { from[axis] } else { to[axis] };
        Vec3::new(choose(0), choose(1), choose(2))
    };
    let sides =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    (std::array::from_fn(corner), sides)
}

/// Half the side of the boxes around balls.
const RADIUS: f32 = 0.5;

/// A town of 400 houses, which are the occluders, with a ball of 2,500 faces behind each.
struct Town {
    camera: Mat4,
    houses: Vec<Vertex<0>>,
    sides: Vec<[u32; 4]>,
    /// The middles of the balls.
    balls: Vec<Vec3>,
    /// The vertices of a ball from its middle, with their parameters.
    ball: Vec<(Vec3, [f32; 2])>,
    triangles: Vec<[u32; 3]>,
}

impl Town {
    fn new() -> Self {
        const SIDE: u16 = 20;
        let camera = perspective(1.0, 16.0 / 9.0, 0.1, 200.0)
            * look_at_mat4(Vec3::new(0.3, 6.0, 2.0), Vec3::new(0.0, 0.0, -20.0), Vec3::Y);
        let (mut houses, mut sides, mut balls) = (Vec::new(), Vec::new(), Vec::new());
        for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
            let (x, z) = (f32::from(column) - 9.5, f32::from(row));
            let corner = Vec3::new(3.0 * x, 0.0, -3.0 * z - 4.0);
            let height = 1.5 + f32::from((7 * row + 5 * column) % 11) * 0.2;
            let (corners, house) = cuboid([corner, corner + Vec3::new(2.4, height, 1.5)]);
            let first = houses.len() as u32;
            houses.extend(corners.map(|corner| Vertex::new(camera * corner.extend(1.0), [])));
            sides.extend(house.map(|side| side.map(|i| first + i)));
            // Every fifth is above the roof.
            let up = if (row + 2 * column) % 5 == 0 { height + 0.6 } else { 0.5 };
            balls.push(corner + Vec3::new(1.2, up, -0.8));
        }
        let (ball, triangles) = sphere(50, 25);
        let place = |v: &Vertex<2>| {
            use std::f32::consts::{PI, TAU};
            let [longitude, latitude] = [v.params[0] * TAU, v.params[1] * PI];
            let ring = latitude.sin() * RADIUS;
            let (z, x) = longitude.sin_cos();
            (Vec3::new(x * ring, latitude.cos() * RADIUS, z * ring), v.params)
        };
        Self { camera, houses, sides, balls, ball: ball.iter().map(place).collect(), triangles }
    }

    fn occluders(&self) -> Mesh<'_, &[[u32; 4]], 0> {
        Mesh::new(&self.houses, &self.sides)
    }

    fn boxes(&self) -> impl Iterator<Item = [Vec3; 2]> {
        self.balls.iter().map(|middle| [*middle - RADIUS, *middle + RADIUS])
    }

    /// What occluders and boxes take, by tiles and by pixels.
    fn time_occlusion(
        &self,
        frame: &mut Framebuffer<u32>,
        tiles: &mut OcclusionRenderer<0>,
        threads: &str,
    ) {
        let mut depth = ZBufferRenderer::<0>::new(frame.viewport());
        let drawn = times(51, || {
            frame.clear(0, 1.0);
            depth.draw_depth(frame, self.occluders());
        });
        report(&format!("2,400 occluders, depth of 1280 x 720, {threads}"), drawn, 1);
        let covered = times(51, || {
            tiles.clear();
            tiles.draw(self.occluders());
        });
        report("the same into tiles", covered, 1);
        let mut hidden = 0;
        let asked = times(51, || {
            hidden = self.boxes().filter(|within| tiles.is_hidden(self.camera, *within)).count();
        });
        report(&format!("400 boxes against tiles, {hidden} hidden; each"), asked, 400);
        let asked = times(11, || {
            let is_hidden = |within: &[Vec3; 2]| {
                let (corners, sides) = cuboid(*within);
                let corners = corners.map(|c| Vertex::new(self.camera * c.extend(1.0), []));
                !depth.is_any_visible(frame, Mesh::new(&corners, sides))
            };
            hidden = self.boxes().filter(is_hidden).count();
        });
        report(&format!("400 boxes by queries, {hidden} hidden; each"), asked, 400);
    }

    /// Draws all, or what is not hidden.
    fn draw(&self, frame: &mut Framebuffer<u32>, tiles: Option<&mut OcclusionRenderer<0>>) {
        frame.clear(0, 1.0);
        ZBufferRenderer::new(frame.viewport()).draw_depth(frame, self.occluders());
        let tiles = tiles.map(|tiles| {
            tiles.clear();
            tiles.draw(self.occluders());
            &*tiles
        });
        let mut renderer = ZBufferRenderer::<2>::new(frame.viewport());
        for (middle, within) in self.balls.iter().zip(self.boxes()) {
            if tiles.is_some_and(|tiles| tiles.is_hidden(self.camera, within)) {
                continue;
            }
            let position = |place: Vec3| self.camera * (*middle + place).extend(1.0);
            let vertex =
                |&(place, params): &(Vec3, [f32; 2])| Vertex { position: position(place), params };
            let vertices: Vec<_> = self.ball.iter().map(vertex).collect();
            renderer.draw_blocks(frame, Mesh::new(&vertices, &self.triangles), shade);
        }
    }
}

/// What it takes to find out what is hidden in a town, and what that saves.
fn occlusion() -> Result<(), Box<dyn Error>> {
    let town = Town::new();
    let mut frame = Framebuffer::new(1280, 720, 0u32)?;
    let mut tiles = OcclusionRenderer::new(frame.viewport())?;
    with_threads(|threads| {
        town.time_occlusion(&mut frame, &mut tiles, threads);
        let all = times(11, || town.draw(&mut frame, None));
        report("the town with all balls, a million faces", all, 1);
        let seen = times(11, || town.draw(&mut frame, Some(&mut tiles)));
        report("without those that the tiles hide", seen, 1);
    })
}

/// A process that draws a picture of 256 x 256 pixels into memory and ends.
fn cold_process(faces: usize) -> Result<(), Box<dyn Error>> {
    let (vertices, triangles) = sphere(50, 50);
    let mut frame = Framebuffer::new(256, 256, 0u32)?;
    let mut renderer = ZBufferRenderer::<2>::new(frame.viewport());
    renderer.draw_blocks(&mut frame, Mesh::new(&vertices, &triangles[..faces]), shade);
    black_box(frame.color());
    Ok(())
}

/// A thumbnail, from the start of a process to its end.
fn thumbnail() -> Result<(), Box<dyn Error>> {
    let program = std::env::current_exe()?;
    for (faces, what) in
        [("5000", "a process that draws 5,000 faces, 256 x 256"), ("0", "one that draws none")]
    {
        let mut failed = false;
        let processes = times(101, || {
            let status = Command::new(&program).args([COLD, faces]).status();
            failed |= !status.is_ok_and(|status| status.success());
        });
        if failed {
            return Err("the process that draws a thumbnail failed".into());
        }
        report(what, processes, 1);
    }
    Ok(())
}

/// A height field of 10 million triangles, on 1024 x 2048 pixels.
fn faces() -> Result<(), Box<dyn Error>> {
    const SIDE: u16 = 2236;
    let side = f32::from(SIDE);
    let view = perspective(1.0, 0.5, 0.1, 100.0)
        * look_at_mat4(Vec3::new(0.0, 1.3, 1.1), Vec3::ZERO, Vec3::Y);
    let places = (0..=SIDE).flat_map(|row| (0..=SIDE).map(move |column| (column, row)));
    let vertices: Vec<Vertex<2>> = places
        .map(|(column, row)| {
            let (u, v) = (f32::from(column) / side, f32::from(row) / side);
            let height = 0.1 * (9.0 * u).sin() * (11.0 * v).cos();
            Vertex::new(view * Vec4::new(u - 0.5, height, 2.0 * v - 1.0, 1.0), [u, v])
        })
        .collect();
    let line = u32::from(SIDE) + 1;
    let squares = (0..line - 1).flat_map(|row| (0..line - 1).map(move |x| row * line + x));
    let mut faces: Vec<[u32; 3]> =
        squares.flat_map(|a| [[a, a + line, a + line + 1], [a, a + line + 1, a + 1]]).collect();
    let draw = |order: &str, faces: &[[u32; 3]]| {
        with_threads(|threads| {
            let Ok(mut frame) = Framebuffer::new(1024, 2048, 0u32) else { return };
            let mut renderer = ZBufferRenderer::<2>::new(frame.viewport());
            let before = resident_mebibytes();
            let frames = times(5, || {
                frame.clear(0, 1.0);
                renderer.draw_blocks(&mut frame, Mesh::new(&vertices, faces), shade);
            });
            let covered = frame.depth().iter().filter(|&&depth| depth < 1.0).count();
            report(&format!("{} faces {order}, {threads}", faces.len()), frames, 1);
            if let Some((before, after)) = before.zip(resident_mebibytes()) {
                let more = after.saturating_sub(before);
                println!("{:>50} {more} MiB for the renderer, {covered} pixels", "");
            }
        })
    };
    draw("in order", &faces)?;
    // Fisher and Yates's shuffle, by Marsaglia's xorshift.
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    for i in (1..faces.len()).rev() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        faces.swap(i, (state % (i as u64 + 1)) as usize);
    }
    draw("in random order", &faces)
}

/// How much memory the process has, if the system tells.
fn resident_mebibytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? / 1024)
}
