//! What each stage costs, on one thread, with the public interface alone.
//!
//! ```text
//! cargo bench -p polyscan-benches --bench stages
//! cargo bench -p polyscan-benches --bench stages -- fragments quad
//! ```
//!
//! Names are filters. Under each time is a rate, of what the stage is made for: vertices, polygons,
//! rows, pixels or faces. A rate of 250 M is 4 ns each. `RAYON_NUM_THREADS` sets another number of
//! threads, which meshes, trees and the scanline renderer use.

use std::hint::black_box;
use std::time::Duration;

use divan::counter::ItemsCount;
use divan::{Bencher, Divan};
use glam::Vec4;
use polyscan::fragment::LANES;
use polyscan::{Fragment, FragmentBlock, Framebuffer, ScanConverter, Vertex};

/// Width and height of the pictures that quads fill: 2 MiB of colour and depth.
const SIZE: u32 = 512;

fn main() {
    if std::env::var_os("RAYON_NUM_THREADS").is_none() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
        pool.build_global().expect("nothing has used the threads yet");
    }
    let times = Divan::default().min_time(Duration::from_millis(200));
    times.max_time(Duration::from_secs(1)).config_with_args().main();
}

/// Places on the screen, in units of half its size, and w.
type Places<'a> = &'a [(f32, f32, f32)];

/// A polygon at these places, z in the middle of the view volume. The parameters are affine.
fn polygon<const N: usize>(places: Places<'_>) -> Vec<Vertex<N>> {
    let vertex = |&(x, y, w): &(f32, f32, f32)| Vertex {
        position: Vec4::new(x * w, y * w, 0.5 * w, w),
        params: std::array::from_fn(|i| if i % 2 == 0 { x * w } else { w }),
    };
    places.iter().map(vertex).collect()
}

/// A square over all of the screen. With w from 1 to `ratio`, it is a floor in perspective.
fn quad<const N: usize>(ratio: f32) -> Vec<Vertex<N>> {
    polygon(&[(-1.0, -1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, ratio), (-1.0, 1.0, ratio)])
}

/// A regular polygon of this many sides. Where `inner` is less than 1, every second vertex is
/// nearer to the middle by this factor.
fn star(sides: usize, inner: f32) -> Vec<Vertex<2>> {
    let place = |k: usize| {
        let angle = std::f32::consts::TAU * (k as f32 + 0.25) / sides as f32;
        let radius = if k.is_multiple_of(2) { 0.9 } else { 0.9 * inner };
        (radius * angle.cos(), radius * angle.sin(), 1.0)
    };
    polygon(&(0..sides).map(place).collect::<Vec<_>>())
}

/// The shapes that stages before the fragments are timed with.
const SHAPES: [&str; 4] = ["triangle", "quad", "12-gon", "concave 64-gon"];

fn shape(name: &str) -> Vec<Vertex<2>> {
    match name {
        "triangle" => star(3, 1.0),
        "quad" => star(4, 1.0),
        "12-gon" => star(12, 1.0),
        _ => star(64, 0.5),
    }
}

/// From object space to clip space.
mod transform {
    use glam::{Mat4, Vec3};

    use super::*;

    #[divan::bench]
    fn vertices(bencher: Bencher<'_, '_>) {
        let camera = Mat4::from_euler(glam::EulerRot::XYZ, 0.1, 0.2, 0.3);
        let places: Vec<_> = (0..1024).map(|i| Vec3::splat(i as f32)).collect();
        let mut clip = Vec::with_capacity(places.len());
        bencher.counter(ItemsCount::new(places.len())).bench_local(|| {
            clip.clear();
            let vertex = |p: &Vec3| Vertex::new(camera * p.extend(1.0), [p.x, p.y]);
            clip.extend(black_box(&places).iter().map(vertex));
            black_box(&clip);
        });
    }
}

/// The six frustum planes, for a triangle with two parameters.
mod clip {
    use polyscan::ClipSpace;
    use polyscan::clip::Clipper;

    use super::*;

    /// With how many planes it crosses.
    #[divan::bench(args = ["inside", "outside", "1 plane", "2 planes", "3 planes"])]
    fn triangle(bencher: Bencher<'_, '_>, place: &str) {
        let places: Places<'_> = match place {
            "inside" => &[(-0.5, -0.5, 1.0), (0.5, -0.5, 1.0), (0.0, 0.5, 2.0)],
            "outside" => &[(1.5, -0.5, 1.0), (2.5, -0.5, 1.0), (2.0, 0.5, 2.0)],
            "1 plane" => &[(-0.5, -0.5, 1.0), (1.5, -0.5, 1.0), (0.0, 0.5, 2.0)],
            "2 planes" => &[(-0.5, -0.5, 1.0), (1.5, -0.5, 1.0), (0.0, 1.5, 2.0)],
            _ => &[(-1.5, -0.5, 1.0), (1.5, -0.5, 1.0), (0.0, 1.5, 2.0)],
        };
        let triangle = polygon::<2>(places);
        let planes = ClipSpace::ZeroToOne.frustum();
        let mut clipper = Clipper::new();
        bencher.counter(ItemsCount::new(1u32)).bench_local(|| {
            black_box(clipper.clip(black_box(&triangle), &planes));
        });
    }
}

/// From clip space to the screen.
mod project {
    use polyscan::{ClipSpace, Viewport};

    use super::*;

    #[divan::bench]
    fn vertices(bencher: Bencher<'_, '_>) {
        let viewport = Viewport::new(SIZE, SIZE).expect("a small viewport");
        let vertices = star(1024, 0.5);
        bencher.counter(ItemsCount::new(vertices.len())).bench_local(|| {
            for vertex in black_box(&vertices) {
                black_box(viewport.project(vertex, ClipSpace::ZeroToOne));
            }
        });
    }
}

/// From outlines to runs, 461 rows at most; the rate is of rows.
mod edge_table {
    use polyscan::coverage::EdgeTable;
    use polyscan::subpixel::SubpixelPoint;

    use super::*;

    #[divan::bench(args = SHAPES)]
    fn rows(bencher: Bencher<'_, '_>, name: &str) {
        let subpixels = |v: f32| ((v + 1.0) * (SIZE * 128) as f32) as i32;
        let point = |v: &Vertex<2>| SubpixelPoint {
            x: subpixels(v.position.x),
            y: subpixels(-v.position.y),
        };
        let outline: Vec<_> = shape(name).iter().map(point).collect();
        let mut table = EdgeTable::new();
        let mut rows = || {
            table.fill(black_box(&outline), 0..SIZE as i32);
            let runs = table.runs().map(|run| black_box(run).y);
            runs.fold((0, None), |(rows, last), y| (rows + u32::from(last != Some(y)), Some(y))).0
        };
        bencher.counter(ItemsCount::new(rows())).bench_local(rows);
    }

    /// Triangles that cover 18 pixels; the rate is of triangles.
    #[divan::bench]
    fn small_triangle(bencher: Bencher<'_, '_>) {
        let outline = [(0, 0), (1536, 100), (700, 1536)].map(|(x, y)| SubpixelPoint { x, y });
        let mut table = EdgeTable::new();
        bencher.counter(ItemsCount::new(1u32)).bench_local(|| {
            table.fill(black_box(&outline), 0..SIZE as i32);
            table.runs().fold((), |(), run| {
                black_box(run);
            });
        });
    }
}

/// All stages up to the spans, of two parameters; no fragment is evaluated. The rate is of spans.
#[divan::bench(args = SHAPES)]
fn spans(bencher: Bencher<'_, '_>, name: &str) {
    let polygon = shape(name);
    let mut scan = scan_converter();
    let mut spans = || {
        scan.spans(black_box(&polygon)).fold(0, |count, span| {
            black_box(span);
            count + 1u32
        })
    };
    bencher.counter(ItemsCount::new(spans())).bench_local(spans);
}

fn scan_converter<const N: usize>() -> ScanConverter<N> {
    ScanConverter::new(frame().viewport())
}

/// Iterators over the fragments of a square's spans; the rate is of pixels.
mod fragments {
    use super::*;

    #[divan::bench(consts = [0, 2, 8, 37])]
    fn perspective<const N: usize>(bencher: Bencher<'_, '_>) {
        iterate::<N>(bencher, 4.0);
    }

    /// Where no division is needed.
    #[divan::bench(consts = [0, 2, 8, 37])]
    fn equal_w<const N: usize>(bencher: Bencher<'_, '_>) {
        iterate::<N>(bencher, 1.0);
    }

    fn iterate<const N: usize>(bencher: Bencher<'_, '_>, ratio: f32) {
        let quad = quad::<N>(ratio);
        let mut scan = scan_converter();
        bencher.counter(ItemsCount::new(SIZE * SIZE)).bench_local(|| {
            for span in scan.spans(black_box(&quad)) {
                for fragment in span.fragments() {
                    black_box((fragment.depth, fragment.params));
                }
            }
        });
    }
}

fn frame() -> Framebuffer<u32> {
    Framebuffer::new(SIZE, SIZE, 0).expect("a small frame")
}

/// The same colour, made of all parameters, by a shader of either kind. Only what is inlined is
/// compiled for the machine's best level.
#[inline(always)]
fn shade<const N: usize>(fragment: &Fragment<'_, N>) -> u32 {
    fragment.params.iter().fold(1.0, |sum: f32, r| sum + r).to_bits()
}

/// See [`shade`].
#[inline(always)]
fn shade_block<const N: usize>(block: &mut FragmentBlock<'_, N>, colors: &mut [u32; LANES]) {
    let mut sums = [1.0f32; LANES];
    for r in &block.params {
        sums.iter_mut().zip(r).for_each(|(sum, r)| *sum += r);
    }
    *colors = sums.map(f32::to_bits);
}

/// Times `draw` on a frame that is cleared before, which does not count.
fn on_cleared_frame(
    bencher: Bencher<'_, '_>,
    items: u32,
    mut draw: impl FnMut(&mut Framebuffer<u32>),
) {
    let frame = std::cell::RefCell::new(frame());
    let bencher = bencher.with_inputs(|| frame.borrow_mut().clear(0, 1.0));
    let bencher = bencher.counter(ItemsCount::new(items));
    bencher.bench_local_values(|()| draw(&mut frame.borrow_mut()));
}

/// The z-buffer renderer with a square that covers the picture; the rate is of pixels.
mod z_buffer_quad {
    use polyscan::ZBufferRenderer;

    use super::*;

    #[divan::bench(consts = [0, 2, 8], sample_size = 1)]
    fn per_fragment<const N: usize>(bencher: Bencher<'_, '_>) {
        let (quad, mut renderer) = (quad::<N>(4.0), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, SIZE * SIZE, |frame| renderer.draw(frame, &quad, shade));
    }

    #[divan::bench(consts = [0, 2, 8], sample_size = 1)]
    fn per_block<const N: usize>(bencher: Bencher<'_, '_>) {
        let (quad, mut renderer) = (quad::<N>(4.0), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, SIZE * SIZE, |frame| {
            renderer.draw_blocks(frame, &quad, shade_block);
        });
    }

    /// As `per_block`, where no division is needed.
    #[divan::bench(consts = [2], sample_size = 1)]
    fn per_block_equal_w<const N: usize>(bencher: Bencher<'_, '_>) {
        let (quad, mut renderer) = (quad::<N>(1.0), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, SIZE * SIZE, |frame| {
            renderer.draw_blocks(frame, &quad, shade_block);
        });
    }

    #[divan::bench(sample_size = 1)]
    fn depth_only(bencher: Bencher<'_, '_>) {
        let (quad, mut renderer) = (quad::<0>(4.0), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, SIZE * SIZE, |frame| renderer.draw_depth(frame, &quad));
    }

    /// Behind what is there already.
    #[divan::bench]
    fn hidden(bencher: Bencher<'_, '_>) {
        let (quad, mut renderer) = (quad::<2>(4.0), ZBufferRenderer::new(frame().viewport()));
        let mut frame = frame();
        frame.clear(0, 0.0);
        bencher.counter(ItemsCount::new(SIZE * SIZE)).bench_local(|| {
            renderer.draw_blocks(&mut frame, black_box(&quad), shade_block);
        });
    }
}

/// A texture of 512 x 512; the rate is of samples.
mod texture {
    use glam::Vec2;
    use polyscan::Texture;

    use super::*;

    #[divan::bench]
    fn nearest(bencher: Bencher<'_, '_>) {
        sample(bencher, Texture::nearest);
    }

    #[divan::bench]
    fn bilinear(bencher: Bencher<'_, '_>) {
        sample(bencher, Texture::bilinear);
    }

    fn sample(bencher: Bencher<'_, '_>, sample: impl Fn(&Texture, Vec2) -> Vec4) {
        let texture = Texture::from_fn(512, 512, |x, y| Vec4::new(x as f32, y as f32, 0.0, 1.0));
        let texture = texture.expect("a small texture");
        // A row of pixels, seen at an angle.
        let places: Vec<_> = (0..1024).map(|i| Vec2::new(0.6, 0.3) * i as f32 / 512.0).collect();
        bencher.counter(ItemsCount::new(places.len())).bench_local(|| {
            for &uv in black_box(&places) {
                black_box(sample(&texture, uv));
            }
        });
    }
}

/// Triangles of 8 pixels that cover the picture, two parameters each; the rate is of triangles.
mod mesh {
    use polyscan::{Cull, Mesh, ScanlineRenderer, ZBufferRenderer};

    use super::*;

    const SIDE: u32 = SIZE / 4;
    const TRIANGLES: u32 = 2 * SIDE * SIDE;

    /// Squares of 4 x 4 pixels, each cut into two triangles.
    fn grid() -> (Vec<Vertex<2>>, Vec<[u32; 3]>) {
        let place = |i: u32| i as f32 * 2.0 / SIDE as f32 - 1.0;
        let line = 0..=SIDE;
        let vertices = line.clone().flat_map(|y| line.clone().map(move |x| (x, y)));
        let vertices: Vec<_> =
            vertices.map(|(x, y)| (place(x), place(y), 1.0 + place(y).abs())).collect();
        let corners = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| y * (SIDE + 1) + x));
        let triangles =
            corners.flat_map(|a| [[a, a + 1, a + SIDE + 2], [a, a + SIDE + 2, a + SIDE + 1]]);
        (polygon(&vertices), triangles.collect())
    }

    #[divan::bench(sample_size = 1)]
    fn per_fragment(bencher: Bencher<'_, '_>) {
        let ((vertices, faces), mut renderer) = (grid(), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, TRIANGLES, |frame| {
            renderer.draw(frame, Mesh::new(&vertices, &faces), shade);
        });
    }

    #[divan::bench(sample_size = 1)]
    fn per_block(bencher: Bencher<'_, '_>) {
        let ((vertices, faces), mut renderer) = (grid(), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, TRIANGLES, |frame| {
            renderer.draw_blocks(frame, Mesh::new(&vertices, &faces), shade_block);
        });
    }

    #[divan::bench(sample_size = 1)]
    fn depth_only(bencher: Bencher<'_, '_>) {
        let ((vertices, faces), mut renderer) = (grid(), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, TRIANGLES, |frame| {
            renderer.draw_depth(frame, Mesh::new(&vertices, &faces));
        });
    }

    /// All turned away: what is left is to project, test and cull.
    #[divan::bench]
    fn culled(bencher: Bencher<'_, '_>) {
        let ((vertices, faces), mut renderer) = (grid(), ZBufferRenderer::new(frame().viewport()));
        renderer.settings.cull = Cull::Front;
        let mut frame = frame();
        bencher.counter(ItemsCount::new(TRIANGLES)).bench_local(|| {
            renderer.draw_blocks(&mut frame, Mesh::new(black_box(&vertices), &faces), shade_block);
        });
    }

    /// The same, one by one.
    #[divan::bench(sample_size = 1)]
    fn as_polygons(bencher: Bencher<'_, '_>) {
        let ((vertices, faces), mut renderer) = (grid(), ZBufferRenderer::new(frame().viewport()));
        on_cleared_frame(bencher, TRIANGLES, |frame| {
            for face in &faces {
                let triangle = face.map(|corner| vertices[corner as usize]);
                renderer.draw_blocks(frame, &triangle, shade_block);
            }
        });
    }

    #[divan::bench]
    fn scanline(bencher: Bencher<'_, '_>) {
        let ((vertices, faces), mut renderer) = (grid(), ScanlineRenderer::new(frame().viewport()));
        bencher.counter(ItemsCount::new(TRIANGLES)).bench_local(|| {
            let mesh = Mesh::new(black_box(&vertices), &faces);
            renderer.stream_blocks(mesh, 0, shade_block, |_, row| {
                black_box(row);
                Ok::<(), std::fmt::Error>(())
            })
        });
    }
}

/// A sphere in a tree; the rate is of faces.
mod bsp {
    use glam::{Mat4, Vec3};
    use polyscan::{BspTree, PainterRenderer};

    use super::*;

    const STACKS: u32 = 32;
    const SLICES: u32 = 64;
    const FACES: u32 = STACKS * SLICES;

    /// Quads between circles of latitude, from pole to pole.
    fn sphere() -> (Vec<Vertex<2>>, Vec<[u32; 4]>) {
        let places = (0..=STACKS).flat_map(|stack| (0..=SLICES).map(move |slice| (stack, slice)));
        let vertices = places.map(|(stack, slice)| {
            let (sin, cos) = (std::f32::consts::PI * stack as f32 / STACKS as f32).sin_cos();
            let turn = std::f32::consts::TAU * slice as f32 / SLICES as f32;
            let place = Vec3::new(sin * turn.cos(), cos, sin * turn.sin());
            Vertex::new(place.extend(1.0), [place.x, place.y])
        });
        let corners = (0..STACKS).flat_map(|y| (0..SLICES).map(move |x| y * (SLICES + 1) + x));
        let faces = corners.map(|a| [a, a + 1, a + SLICES + 2, a + SLICES + 1]);
        (vertices.collect(), faces.collect())
    }

    #[divan::bench]
    fn build(bencher: Bencher<'_, '_>) {
        let (vertices, faces) = sphere();
        bencher.counter(ItemsCount::new(FACES)).bench_local(|| {
            black_box(BspTree::new(black_box(&vertices), &faces));
        });
    }

    /// On 512 x 512 pixels, front and back.
    #[divan::bench]
    fn draw(bencher: Bencher<'_, '_>) {
        let (vertices, faces) = sphere();
        let tree = BspTree::new(&vertices, &faces);
        let mut frame = frame();
        let mut painter = PainterRenderer::new(frame.viewport());
        let clip_from_object = Mat4::from_scale_rotation_translation(
            Vec3::new(0.9, 0.9, 0.4),
            glam::Quat::from_rotation_x(0.5),
            Vec3::new(0.0, 0.0, 0.5),
        );
        bencher.counter(ItemsCount::new(FACES)).bench_local(|| {
            let tree = black_box(&tree).seen_by(clip_from_object);
            painter.draw_blocks(&mut frame, tree, shade_block);
        });
    }
}
