//! The scanline renderer: the z-buffer's picture to the bit, each pixel shaded once, rows delivered
//! once and in order, transparent faces in the order of a sort at each pixel.
//!
//! `cargo test --profile proof --test it -- scanline:: --include-ignored --nocapture` runs the long
//! version and prints its figures.

use std::collections::HashSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::common::generators::{self, Cells, Mesh, Rng, Shape};
use crate::common::oracle::{Position, Window};
use crate::common::{
    LONG_SEED, bare, dynamic, dynamic_blocks, in_threads, tally, vertices, viewport,
};
use glam::{Vec4, vec4};
use polyscan::fragment::LANES;
use polyscan::render::{Over, Paint};
use polyscan::{
    ClipPlane, ClipSpace, Cull, DepthMode, Fragment, FragmentBlock, Framebuffer, Interpolation,
    Rect, ScanConverter, ScanlineRenderer, Settings, Vertex, ZBufferRenderer,
};

/// Faces with N parameters, and how they are drawn.
#[derive(Clone, Debug)]
struct Scene<const N: usize> {
    vertices: Vec<Vertex<N>>,
    faces: Vec<Vec<u32>>,
    settings: Settings<N>,
}

impl<const N: usize> Scene<N> {
    fn new(window: Window) -> Self {
        let settings = Settings::new(viewport(window));
        Self { vertices: Vec::new(), faces: Vec::new(), settings }
    }

    fn add(&mut self, polygon: &[Vertex<N>]) {
        let first = self.vertices.len() as u32;
        self.faces.push((first..first + polygon.len() as u32).collect());
        self.vertices.extend_from_slice(polygon);
    }

    fn mesh(&self) -> polyscan::Mesh<'_, &[Vec<u32>], N> {
        polyscan::Mesh::new(&self.vertices, self.faces.as_slice())
    }

    fn polygon(&self, face: usize) -> Vec<Vertex<N>> {
        let corner = |&i: &u32| self.vertices.get(i as usize).copied();
        self.faces[face].iter().filter_map(corner).collect()
    }

    fn rect(&self) -> Rect {
        self.settings.viewport.rect()
    }

    /// A frame from the origin to the viewport's far corner, cleared.
    fn frame<C: Copy>(&self, color: C) -> Framebuffer<C> {
        let Rect { x, y, width, height } = self.rect();
        let side = |corner: i32, size: u32| (corner + size as i32).max(0) as u32;
        let mut frame =
            Framebuffer::new(side(x, width), side(y, height), color).expect("a small frame");
        frame.clear(color, self.settings.depth.farthest());
        frame
    }

    fn scanline(&self) -> ScanlineRenderer<N> {
        let mut renderer = ScanlineRenderer::new(self.settings.viewport);
        renderer.settings = self.settings.clone();
        renderer
    }

    fn z_buffer(&self) -> ZBufferRenderer<N> {
        let mut renderer = ZBufferRenderer::new(self.settings.viewport);
        renderer.settings = self.settings.clone();
        renderer
    }
}

/// All that a fragment has, as bits; no fragment at first.
type Bits<const N: usize> = (u32, u32, u32, [u32; N]);

fn bits<const N: usize>(f: &Fragment<'_, N>) -> Bits<N> {
    (f.face + 1, f.depth.to_bits(), f.w.to_bits(), f.params.map(f32::to_bits))
}

tally! {
    /// What was compared.
    struct Tally {
        scenes: u64,
        faces: u64,
        pixels: u64,
        covered: u64,
    }
}

/// Draws a scene by both renderers: the pictures have to be the same, and the rows complete; every
/// covered pixel has to be shaded once, and no other.
fn check<const N: usize>(scene: &Scene<N>, name: &str) -> Tally {
    let nothing = (0, 0, 0, [0; N]);
    let mut expected = scene.frame(nothing);
    scene.z_buffer().draw(&mut expected, scene.mesh(), dynamic(bits));

    let Rect { x, y, width, height } = scene.rect();
    let shaded: Vec<_> = (0..width * height).map(|_| AtomicU32::new(0)).collect();
    let mut rows = Vec::new();
    let mut renderer = scene.scanline();
    let shader = |f: &Fragment<'_, N>| {
        let at = (f.y - y) as usize * width as usize + (f.x - x) as usize;
        shaded[at].fetch_add(1, Ordering::Relaxed);
        bits(f)
    };
    let sink = |row: u32, colors: &[Bits<N>]| {
        assert_eq!((row as usize, colors.len()), (rows.len(), width as usize), "{name}: rows");
        rows.push(colors.to_vec());
        Ok::<(), ()>(())
    };
    renderer.stream(scene.mesh(), nothing, dynamic(shader), sink).expect("no error");
    assert_eq!(rows.len(), height as usize, "{name}: rows");

    let mut covered = 0;
    for ((row, colors), counts) in (0..).zip(&rows).zip(shaded.chunks(width.max(1) as usize)) {
        for ((column, color), count) in (0..).zip(colors).zip(counts) {
            let drawn = u32::from(*color != nothing);
            let at = (x + column, y + row);
            assert_eq!(count.load(Ordering::Relaxed), drawn, "{name}: times shaded at {at:?}");
            covered += u64::from(drawn);
            let (Ok(i), Ok(j)) = (at.0.try_into(), at.1.try_into()) else { continue };
            assert_eq!(Some(*color), expected.pixel(i, j).map(|p| p.0), "{name}: colour at {at:?}");
        }
    }

    let mut frame = scene.frame(nothing);
    renderer.draw(&mut frame, scene.mesh(), dynamic(bits));
    assert!(frame == expected, "{name}: on a framebuffer");
    let pixels = u64::from(width) * u64::from(height);
    Tally { scenes: 1, faces: scene.faces.len() as u64, pixels, covered }
}

// ----------------------------------------------------------------------------------------- scenes

/// Depths for the vertices of a face, in place of the generators'.
fn tilt(rng: &mut Rng, positions: &mut [Position]) {
    let kind = rng.below(6);
    let [a, b, c] = [0.3, 0.3, 0.9].map(|range| rng.range(-range, range));
    let level = [0.0, 0.25, 0.5, 0.5, 0.75, 1.0][rng.below(6)];
    for p in positions {
        let [x, y, _, w] = p.map(f64::from);
        p[2] = match kind {
            0 => return,
            // A plane.
            1 | 2 => a * x + b * y + (0.5 + 0.4 * c) * w,
            // A plane that differs from that of others by rounding only.
            3 => (0.5 + a * 1e-7) * w + b * 1e-7 * x,
            4 => level * w,
            // Near and far planes cut it; more than three vertices have no plane.
            _ => rng.range(-0.2, 1.2) * w,
        } as f32;
    }
}

/// A polygon of any kind.
fn any_polygon<const N: usize>(rng: &mut Rng, window: Window) -> Vec<Vertex<N>> {
    let w_ratio = if rng.once_in(3) { 1.0 } else { rng.octaves(1.0, 100.0) };
    let sides = 3 + rng.below(8);
    let mut shape: Shape<N> = match rng.below(10) {
        0..4 => generators::random_triangle(rng, w_ratio, 1.5),
        4..6 => generators::random_convex(rng, sides, w_ratio),
        6 => generators::through_eye(rng, sides),
        kind => {
            let positions = match kind {
                7 => generators::sliver(rng, window, 1.5, w_ratio),
                8 => generators::star(rng, window, 2 + sides),
                _ => generators::integer_triangle(rng),
            };
            let parameters = positions
                .iter()
                .map(|_| std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32))
                .collect();
            Shape { positions, parameters }
        }
    };
    tilt(rng, &mut shape.positions);
    vertices(&shape)
}

/// Settings of all kinds.
fn configure<const N: usize>(rng: &mut Rng, scene: &mut Scene<N>) {
    let settings = &mut scene.settings;
    let Rect { width, height, .. } = settings.viewport.rect();
    if rng.once_in(4) {
        settings.viewport =
            settings.viewport.with_corner(rng.whole(-9, 9) as i32, rng.whole(-9, 9) as i32);
    }
    if rng.once_in(4) {
        let corner = [width, height].map(|size| rng.whole(-3, i64::from(size)) as i32);
        let [w, h] = [width, height].map(|size| 1 + rng.below(size as usize) as u32);
        settings.scissor = Some(Rect { x: corner[0], y: corner[1], width: w, height: h });
    }
    if rng.once_in(4) {
        settings.clip_space = ClipSpace::MinusOneToOne;
    }
    for _ in 0..[0, 0, 0, 1, 2][rng.below(5)] {
        let plane = std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
        settings.planes.push(ClipPlane::new(Vec4::from_array(plane)));
    }
    settings.cull = [Cull::None, Cull::None, Cull::Back, Cull::Front][rng.below(4)];
    for interpolation in &mut settings.interpolation {
        *interpolation = [
            Interpolation::Perspective,
            Interpolation::Perspective,
            Interpolation::Linear,
            Interpolation::Flat,
        ][rng.below(4)];
    }
    if rng.once_in(4) {
        settings.depth = DepthMode::Reversed;
    }
    if rng.once_in(4) {
        settings.viewport = settings.viewport.with_depth(0.8, 0.1);
    }
}

fn any_window(rng: &mut Rng) -> Window {
    let [width, height] = match rng.below(4) {
        // Long spans.
        0 => [1500, 6],
        // More rows than one thread takes.
        1 => [24, 150],
        _ => [70, 50],
    }
    .map(|size| 1 + rng.below(size) as u32);
    Window { width, height }
}

/// Polygons of any kind that go through each other, some of them twice.
fn any_scene<const N: usize>(rng: &mut Rng) -> Scene<N> {
    let window = any_window(rng);
    let mut scene = Scene::new(window);
    for _ in 0..1 + rng.below(24) {
        let polygon = any_polygon(rng, window);
        scene.add(&polygon);
        if rng.once_in(5) {
            // Again, beginning elsewhere, in either direction, moved by little or nothing.
            let mut again = polygon;
            let start = rng.below(again.len());
            again.rotate_left(start);
            if rng.once_in(2) {
                again.reverse();
            }
            if rng.once_in(2) {
                for vertex in &mut again {
                    vertex.position.z = vertex.position.z.next_up();
                }
            }
            scene.add(&again);
        }
    }
    if rng.once_in(2) {
        configure(rng, &mut scene);
    }
    scene
}

/// Two or three meshes over the window, each covering each pixel about once, through each other.
fn meshes(rng: &mut Rng) -> Scene<0> {
    let window = any_window(rng);
    let mut scene = Scene::new(window);
    for _ in 0..2 + rng.below(2) {
        let cells = [Cells::Triangles, Cells::Quads, Cells::Mixed][rng.below(3)];
        let counts = [2 + rng.below(12), 2 + rng.below(9)];
        let Mesh { mut positions, faces } = match rng.below(4) {
            0 => generators::floor(rng, counts, cells, 20.0),
            1 => generators::cut_grid(rng, window, counts, cells, 5.0),
            _ => generators::jittered_grid(rng, window, counts, cells, 5.0, 8.0),
        };
        if rng.once_in(2) {
            tilt(rng, &mut positions);
        }
        let first = scene.vertices.len() as u32;
        scene.vertices.extend(bare(&positions));
        let corners = |face: &Vec<usize>| face.iter().map(|&i| first + i as u32).collect();
        scene.faces.extend(faces.iter().map(corners));
    }
    if rng.once_in(3) {
        configure(rng, &mut scene);
    }
    scene
}

fn check_seed(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let name = format!("seed {seed}");
    match seed % 4 {
        0 => check(&any_scene::<0>(rng), &name),
        1 => check(&any_scene::<3>(rng), &name),
        2 => check(&any_scene::<9>(rng), &name),
        _ => check(&meshes(rng), &name),
    }
}

#[test]
fn the_picture_is_the_z_buffers() {
    in_threads(0..400, check_seed);
}

#[test]
#[ignore = "long: some minutes"]
fn long_the_picture_is_the_z_buffers() {
    let tally = in_threads(LONG_SEED..LONG_SEED + 40_000, check_seed);
    println!("scanline and z-buffer: {tally:?}, 0 pixels differ");
}

#[cfg(feature = "obj")]
#[test]
fn a_model_is_the_z_buffers_from_all_sides() {
    use glam::Vec3;
    use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
    let model = polyscan::Model::load(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../examples/assets/cottage.obj"
    ))
    .expect("it is there")
    .model;
    let (low, high) = model.bounds().expect("it has vertices");
    let (centre, radius) = ((low + high) / 2.0, low.distance(high) / 2.0);
    for (i, distance) in [2.2, 2.2, 2.2, 0.9, 0.4].into_iter().enumerate() {
        let eye = centre + Vec3::new(i as f32 - 2.0, 0.7, 1.5).normalize() * radius * distance;
        let camera =
            perspective(0.9, 1.5, 0.02 * radius, 4.0 * radius) * look_at_mat4(eye, centre, Vec3::Y);
        let mut scene = Scene::<2>::new(Window { width: 300, height: 200 });
        scene.vertices.extend(
            model.vertices.iter().map(|vertex| {
                Vertex::new(camera * vertex.position.extend(1.0), vertex.uv.to_array())
            }),
        );
        scene.faces.extend(model.faces().map(|face| face.indices.to_vec()));
        assert!(check(&scene, "cottage").covered > 2000);
    }
}

/// A square over the view.
fn square(z: f32) -> Vec<Vertex<0>> {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, z, 1.0), []))
        .to_vec()
}

#[test]
fn faces_that_cross_are_split_where_they_cross() {
    let mut scene = Scene::new(Window { width: 10, height: 1 });
    // Depth 0.5 in the middle of both; one comes nearer to the left, the other to the right.
    for slope in [0.4, -0.4] {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let tilted = corners.map(|(x, y)| Vertex::new(vec4(x, y, 0.5 + slope * x, 1.0), []));
        scene.add(&tilted);
    }
    let mut picture = Vec::new();
    let sink = |_, row: &[u32]| {
        picture.extend_from_slice(row);
        Ok::<(), ()>(())
    };
    let shader = |f: &Fragment<'_, 0>| f.face + 1;
    scene.scanline().stream(scene.mesh(), 0, dynamic(shader), sink).expect("no error");
    assert_eq!(picture, [1, 1, 1, 1, 1, 2, 2, 2, 2, 2]);
}

#[test]
fn what_is_on_the_far_plane_is_not_seen() {
    for mode in [DepthMode::Standard, DepthMode::Reversed] {
        let mut scene = Scene::new(Window { width: 3, height: 3 });
        scene.settings.depth = mode;
        scene.add(&square(mode.farthest()));
        assert_eq!(check(&scene, "far plane").covered, 0);
    }
}

#[test]
fn a_frame_that_has_depth_hides_what_is_behind() {
    let mut scene = Scene::<0>::new(Window { width: 70, height: 50 });
    let rng = &mut Rng::new(5);
    (0..20).for_each(|_| scene.add(&any_polygon(rng, Window { width: 70, height: 50 })));
    let (behind, before) = scene.faces.split_at(10);
    let draw = |scanline: bool| {
        let mut frame = scene.frame((0, 0, 0, []));
        scene.z_buffer().draw(
            &mut frame,
            polyscan::Mesh::new(&scene.vertices, behind),
            dynamic(bits),
        );
        if scanline {
            scene.scanline().draw(
                &mut frame,
                polyscan::Mesh::new(&scene.vertices, before),
                dynamic(bits),
            );
        } else {
            scene.z_buffer().draw(
                &mut frame,
                polyscan::Mesh::new(&scene.vertices, before),
                dynamic(bits),
            );
        }
        frame
    };
    assert!(draw(true) == draw(false));
}

#[test]
fn shaders_of_blocks_give_the_same_picture() {
    for seed in 0..20 {
        let scene = any_scene::<3>(&mut Rng::new(seed));
        let mut expected = scene.frame(0.0);
        let shade = |params: [f32; 3]| params[0] + 2.0 * params[1] + 4.0 * params[2];
        let mut renderer = scene.scanline();
        renderer.draw(&mut expected, scene.mesh(), dynamic(|f| shade(f.params)));
        let mut frame = scene.frame(0.0);
        let by_block = |block: &mut FragmentBlock<'_, 3>, colors: &mut [f32; LANES]| {
            for (lane, color) in colors.iter_mut().enumerate() {
                *color = shade(block.params.map(|lanes| lanes[lane]));
            }
        };
        renderer.draw_blocks(&mut frame, scene.mesh(), dynamic_blocks(by_block));
        assert!(frame == expected, "seed {seed}");

        let Rect { x, y, width, .. } = scene.rect();
        let sink = |row: u32, colors: &[f32]| {
            for (column, color) in (x..x + width as i32).zip(colors) {
                let (Ok(i), Ok(j)) = (column.try_into(), (y + row as i32).try_into()) else {
                    continue;
                };
                let expected = expected.pixel(i, j).map(|pixel| pixel.0);
                assert_eq!(Some(*color), expected, "seed {seed}, streamed");
            }
            Ok::<(), ()>(())
        };
        renderer.stream_blocks(scene.mesh(), 0.0, by_block, sink).expect("no error");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let draw = |scene: &Scene<3>, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut picture = Vec::new();
        let sink = |_, row: &[Bits<3>]| {
            picture.extend_from_slice(row);
            Ok::<(), ()>(())
        };
        let glass = |face| face % 3 == 0;
        // The scene is made on the thread that draws: what tells glass need not be shared.
        let drawn = pool.install(|| {
            let mesh = scene.mesh().with_transparent(&glass);
            scene.scanline().stream(mesh, (0, 0, 0, [0; 3]), dynamic(bits), sink)
        });
        drawn.map(|()| picture)
    };
    for seed in 0..12 {
        let rng = &mut Rng::new(seed);
        let window = Window { width: 40, height: 300 };
        let mut scene = Scene::new(window);
        (0..30).for_each(|_| scene.add(&any_polygon(rng, window)));
        let one = draw(&scene, 1);
        for threads in [2, 3, 7] {
            assert!(draw(&scene, threads) == one, "seed {seed}, {threads} threads");
        }
    }
}

// ----------------------------------------------------------------------------------- transparency

/// Nothing, or a colour over what is behind.
struct Glass(Option<Vec4>);

impl Paint<Vec4> for Glass {
    fn paint(self, pixel: &mut Vec4) -> bool {
        self.0.is_some_and(|color| Over(color).paint(pixel))
    }
}

/// A colour of the face and the pixel: opaque, clear in part, or a hole.
fn glass(face: u32, x: i32, y: i32, is_transparent: bool) -> Glass {
    let alpha = if is_transparent { 0.25 + 0.5 * (face % 3) as f32 / 2.0 } else { 1.0 };
    let light = vec4(face as f32 / 64.0, (face * 7 % 11) as f32 / 11.0, 0.5, 1.0);
    Glass((!is_transparent || (x + y + face as i32) % 5 != 0).then_some(light * alpha))
}

/// The picture by a sort of all fragments of each pixel.
fn sorted_at_each_pixel<const N: usize>(
    scene: &Scene<N>,
    is_transparent: impl Fn(u32) -> bool,
) -> Vec<Vec4> {
    let Rect { x, y, width, height } = scene.rect();
    let is_greater_nearer = scene.settings.depth.is_greater_nearer();
    let mut fragments = vec![Vec::new(); (width * height) as usize];
    let mut scan = ScanConverter::new(scene.settings.viewport);
    scan.settings = scene.settings.clone();
    for face in 0..scene.faces.len() {
        for span in scan.spans(&scene.polygon(face)) {
            for f in span.fragments() {
                let at = (f.y - y) as usize * width as usize + (f.x - x) as usize;
                let depth = if is_greater_nearer { -f.depth } else { f.depth };
                fragments[at].push((depth, face as u32));
            }
        }
    }
    let farthest = scene.settings.depth.farthest();
    let resolve = |(i, mut fragments): (usize, Vec<(f32, u32)>)| {
        let at = (x + i as i32 % width as i32, y + i as i32 / width as i32);
        let opaque = fragments.iter().filter(|f| !is_transparent(f.1) && f.0 < farthest).copied();
        let nearer = |a: &(f32, u32), b: &(f32, u32)| {
            a.0.partial_cmp(&b.0).expect("a number").then(a.1.cmp(&b.1))
        };
        let nearest = opaque.min_by(nearer);
        let limit = nearest.map_or(farthest, |f| f.0);
        fragments.retain(|f| is_transparent(f.1) && f.0 < limit);
        fragments.sort_by(|a, b| nearer(b, a));
        let mut color = Vec4::W;
        for (_, face) in nearest.into_iter().chain(fragments) {
            glass(face, at.0, at.1, is_transparent(face)).paint(&mut color);
        }
        color
    };
    fragments.into_iter().enumerate().map(resolve).collect()
}

fn check_transparency(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let scene = if rng.once_in(2) { meshes(rng) } else { any_scene::<0>(rng) };
    let share = 1 + rng.below(4) as u32;
    let is_transparent = |face: u32| share == 1 || !face.is_multiple_of(share);
    let mut picture = Vec::new();
    let sink = |_, row: &[Vec4]| {
        picture.extend_from_slice(row);
        Ok::<(), ()>(())
    };
    let mesh = scene.mesh().with_transparent(&is_transparent);
    let shader = |f: &Fragment<'_, 0>| glass(f.face, f.x, f.y, is_transparent(f.face));
    scene.scanline().stream(mesh, Vec4::W, dynamic(shader), sink).expect("no error");
    let expected = sorted_at_each_pixel(&scene, is_transparent);
    for (i, (color, expected)) in picture.iter().zip(&expected).enumerate() {
        let width = scene.rect().width as usize;
        let bits = |color: &Vec4| color.to_array().map(f32::to_bits);
        let at = (i % width, i / width);
        assert_eq!(bits(color), bits(expected), "seed {seed}: colour at {at:?}");
    }
    let (faces, pixels) = (scene.faces.len() as u64, picture.len() as u64);
    Tally { scenes: 1, faces, pixels, covered: 0 }
}

#[test]
fn transparent_faces_are_in_the_order_of_a_sort_at_each_pixel() {
    in_threads(0..300, check_transparency);
}

#[test]
#[ignore = "long: some minutes"]
fn long_transparent_faces_are_in_the_order_of_a_sort_at_each_pixel() {
    let tally = in_threads(LONG_SEED..LONG_SEED + 20_000, check_transparency);
    println!("transparent faces and a sort at each pixel: {tally:?}, 0 pixels differ");
}

// ------------------------------------------------------------------------------------------- sinks

#[test]
fn a_sink_that_fails_ends_the_drawing_with_its_error() {
    let mut scene = Scene::new(Window { width: 30, height: 400 });
    scene.add(&square(0.5));
    for fails_at in [0, 1, 31, 32, 200, 399] {
        let mut rows = Vec::new();
        let sink = |row, _: &[u8]| {
            rows.push(row);
            if row == fails_at { Err(format!("row {row}")) } else { Ok(()) }
        };
        let result = scene.scanline().stream(scene.mesh(), 0u8, dynamic(|_| 1), sink);
        assert_eq!(result, Err(format!("row {fails_at}")));
        assert!(rows.iter().copied().eq(0..=fails_at));
    }
}

#[test]
fn an_empty_viewport_has_rows_without_pixels_or_none() {
    for (width, height) in [(0, 0), (0, 5), (5, 0)] {
        let mut scene = Scene::new(Window { width, height });
        scene.add(&square(0.5));
        check(&scene, "empty viewport");
    }
}

#[test]
fn rows_come_on_the_calling_thread_and_pixels_from_several() {
    let mut scene = Scene::new(Window { width: 64, height: 2000 });
    scene.add(&square(0.5));
    let (caller, drawn_by) = (std::thread::current().id(), Mutex::new(HashSet::new()));
    let sink = |_, _: &[u8]| {
        assert_eq!(std::thread::current().id(), caller);
        Ok::<(), ()>(())
    };
    let shader = |_: &Fragment<'_, 0>| {
        drawn_by.lock().expect("no panic").insert(std::thread::current().id());
        1
    };
    scene.scanline().stream(scene.mesh(), 0, dynamic(shader), sink).expect("no error");
    assert!(!drawn_by.into_inner().expect("no panic").is_empty());
}

// --------------------------------------------------------------------------------------- any input

/// A coordinate of any kind.
fn coordinate(rng: &mut Rng) -> f32 {
    match rng.below(8) {
        0 => f32::from_bits(rng.bits() as u32),
        1 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0][rng.below(5)],
        2 => [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, 1e30][rng.below(5)],
        3 => rng.whole(-2, 2) as f32,
        _ => rng.range(-1.5, 1.5) as f32,
    }
}

fn check_any_input(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let mut scene = Scene::<2>::new(any_window(rng));
    let count = rng.below(40);
    for _ in 0..count {
        let position = std::array::from_fn(|_| coordinate(rng));
        let params = std::array::from_fn(|_| coordinate(rng));
        let mut vertex = Vertex { position: Vec4::from_array(position), params };
        if rng.once_in(2) {
            vertex.position.w = 1.0;
        }
        scene.vertices.push(vertex);
    }
    for _ in 0..rng.below(40) {
        let index = |rng: &mut Rng| match rng.below(60) {
            0 => u32::MAX,
            1 => count as u32,
            _ => rng.below(count.max(1)) as u32,
        };
        let sides = rng.below(9);
        let face = (0..sides).map(|_| index(rng)).collect();
        scene.faces.push(face);
    }
    if rng.once_in(2) {
        configure(rng, &mut scene);
    }
    let tally = check(&scene, &format!("seed {seed}"));
    let glass = scene.mesh().with_transparent(&|face| face % 2 == 0);
    let drawn = scene.scanline().stream(glass, 0.0, dynamic(|f| f.depth), |_, _| Ok::<(), ()>(()));
    drawn.expect("no error");
    tally
}

#[test]
fn any_input_is_safe() {
    in_threads(0..600, check_any_input);
}

#[test]
#[ignore = "long: some minutes"]
fn long_any_input_is_safe() {
    let tally = in_threads(LONG_SEED..LONG_SEED + 100_000, check_any_input);
    println!("any input: {tally:?}, 0 pixels differ");
}

// --------------------------------------------------------------------------------------- PNG files

#[cfg(feature = "image")]
mod png_files {
    use std::fs;

    use glam::Vec3;
    use polyscan::color::Color;
    use polyscan::render::{PngError, PngFile};

    use super::*;

    fn names(folder: &tempfile::TempDir) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("a file"));
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    }

    fn picture(seed: u64) -> (Scene<3>, impl Fn(&Fragment<'_, 3>) -> Vec4) {
        let window = Window { width: 300, height: 200 };
        let mut scene = Scene::new(window);
        let rng = &mut Rng::new(seed);
        (0..20).for_each(|_| scene.add(&any_polygon(rng, window)));
        (scene, |f: &Fragment<'_, 3>| Vec3::from(f.params).abs().extend(0.5).min(Vec4::ONE))
    }

    #[test]
    fn what_is_streamed_is_what_a_framebuffer_shows() {
        let folder = tempfile::tempdir().expect("a folder");
        let (scene, shader) = picture(3);
        let mut frame = scene.frame(Vec4::ONE);
        scene.scanline().draw(&mut frame, scene.mesh(), dynamic(&shader));
        for opaque in [false, true] {
            let path = folder.path().join(format!("{opaque}.png"));
            let make = if opaque { PngFile::opaque } else { PngFile::new };
            let mut file = make(&path, 300, 200).expect("a file");
            let sink = |_, row: &[Vec4]| {
                assert!(!path.exists(), "not before all is done");
                file.write_row(row)
            };
            scene.scanline().stream(scene.mesh(), Vec4::ONE, dynamic(&shader), sink).expect("rows");
            assert!(!path.exists());
            file.finish().expect("a file");
            let read = image::open(&path).expect("a picture");
            assert_eq!(read.color().has_alpha(), !opaque);
            let mut expected = frame.to_image();
            if opaque {
                expected.pixels_mut().for_each(|pixel| pixel.0[3] = 255);
            }
            assert!(read.into_rgba8() == expected);
        }
        assert_eq!(names(&folder).len(), 2, "nothing else is left");
    }

    #[test]
    fn a_drawing_that_fails_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("picture.png");
        let (scene, shader) = picture(4);
        for before in [None, Some("an older file")] {
            if let Some(text) = before {
                fs::write(&path, text).expect("written");
            }
            let mut file = PngFile::new(&path, 300, 200).expect("a file");
            let sink = |row, colors: &[Vec4]| -> Result<(), String> {
                file.write_row(colors).map_err(|error| error.to_string())?;
                if row < 150 { Ok(()) } else { Err("enough".into()) }
            };
            let drawn = scene.scanline().stream(scene.mesh(), Vec4::ONE, dynamic(&shader), sink);
            assert_eq!(drawn, Err("enough".into()));
            let error = file.finish().expect_err("rows are missing").to_string();
            let path_text = path.display().to_string();
            assert!(error.contains(&path_text) && error.contains("151 rows instead of 200"));
            assert_eq!(fs::read_to_string(&path).ok().as_deref(), before);
            assert_eq!(names(&folder).len(), usize::from(before.is_some()));
        }
    }

    #[test]
    fn rows_that_do_not_fit_are_errors() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("picture.png");
        let row = [[1u8, 2, 3]; 4];

        let mut file = PngFile::new(&path, 4, 2).expect("a file");
        file.write_row(&row).expect("a row");
        let error = file.write_row(&row[..3]).expect_err("too short");
        assert!(matches!(error, PngError::RowLength { row: 1, expected: 4, found: 3, .. }));
        assert!(file.write_row(&row).is_err(), "after an error there is no more");
        assert!(file.finish().is_err());

        let mut file = PngFile::new(&path, 4, 1).expect("a file");
        file.write_row(&row).expect("a row");
        let error = file.write_row(&row).expect_err("one too many");
        assert!(matches!(error, PngError::RowCount { expected: 1, found: 2, .. }));
        assert!(file.finish().is_err());

        assert!(matches!(PngFile::new(&path, 0, 1), Err(PngError::Format { .. })));
        let nowhere = folder.path().join("nowhere").join("picture.png");
        let error = PngFile::new(&nowhere, 1, 1).expect_err("no folder").to_string();
        assert!(error.contains(&nowhere.display().to_string()));
        assert!(PngFile::new(folder.path(), 1, 1).is_err(), "a folder is no file");
        assert!(names(&folder).is_empty());
        assert_eq!([9, 8, 7].to_srgb8(), [9, 8, 7, 255]);
    }
}
