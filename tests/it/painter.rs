//! The painter's renderer: pieces have the pixels of the whole, nothing is drawn before what it
//! hides, and the picture is the z-buffer's, for any eye.
//!
//! What is in front is decided by an oracle that knows nothing of trees and spans: `common/crossing`.

use std::array::from_fn;
use std::f32::consts::TAU;
use std::ops::Add;

use crate::common::crossing::{
    Depth, HEIGHT, Layer, Order, Scene, View, WIDTH, by_z_buffer, depths, direction, layer, order,
    random_scene, random_view, scan, solids,
};
use crate::common::generators::{Rng, number};
use crate::common::{LONG_SEED, dynamic, dynamic_blocks, in_threads, tally};
use fearless_simd::Level;
use glam::camera::rh::proj::directx;
use glam::camera::rh::view::look_at_mat4;
use glam::{DVec4, Mat4, Quat, Vec2, Vec3, Vec4, vec3, vec4};
use polyscan::fragment::LANES;
use polyscan::render::{Over, Paint};
use polyscan::{
    BspTree, ClipPlane, Cull, DepthMode, Fragment, Framebuffer, FrontFace, Interpolation,
    PainterRenderer, Rect, ScanConverter, Settings, Vertex, Viewport, ZBufferRenderer,
};

// ------------------------------------------------------------------------------------------ layers

/// All that was drawn at a pixel, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stack {
    len: usize,
    layers: [Layer; 40],
}

const EMPTY: Stack = Stack { len: 0, layers: [Layer { face: 0, bits: [0; 4] }; 40] };

impl Stack {
    fn layers(&self) -> &[Layer] {
        &self.layers[..self.len]
    }

    /// The layers by face.
    fn sorted(&self) -> Vec<Layer> {
        let mut layers = self.layers().to_vec();
        layers.sort();
        layers
    }
}

impl Paint<Stack> for Layer {
    fn paint(self, pixel: &mut Stack) -> bool {
        pixel.layers[pixel.len] = self;
        pixel.len += 1;
        true
    }
}

/// The faces whole, in their order, by the scan converter alone.
fn whole(scan: &mut ScanConverter<2>, scene: &Scene, vertices: &[Vertex<2>]) -> Vec<Stack> {
    let mut stacks = vec![EMPTY; (WIDTH * HEIGHT) as usize];
    for (face, indices) in (0..).zip(&scene.faces) {
        let polygon: Vec<_> = indices.iter().map(|&i| vertices[i as usize]).collect();
        for span in scan.spans(&polygon) {
            for fragment in span.fragments() {
                let pixel = fragment.y as usize * WIDTH as usize + fragment.x as usize;
                Layer { face, ..layer(&fragment) }.paint(&mut stacks[pixel]);
            }
        }
    }
    stacks
}

tally! {
    /// What was compared.
    struct Tally {
        scenes: u64,
        pieces: u64,
        faces: u64,
        /// Covered pixels.
        pixels: u64,
        /// Fragments.
        layers: u64,
        /// Pixels that show another face than the z-buffer does, where the two cross.
        differing: u64,
        /// Pairs of fragments of which the nearer was drawn first, where the two cross.
        pairs: u64,
    }
}

/// A picture of what the painter draws, by its tree or by one for this view alone.
fn painted(
    scene: &Scene,
    tree: Option<&BspTree<2>>,
    view: &View,
    set_up: impl Fn(&mut Settings<2>),
) -> Framebuffer<Stack> {
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, EMPTY).expect("a small frame");
    let mut painter = PainterRenderer::new(frame.viewport());
    set_up(&mut painter.settings);
    painter.settings.clip_space = view.clip_space;
    painter.settings.depth = view.depth_mode();
    painter.depth_write = true;
    match tree {
        Some(tree) => painter.draw(&mut frame, tree.seen_by(view.matrix), layer),
        None => painter.draw(
            &mut frame,
            polyscan::Mesh::new(&scene.in_clip_space(view), &scene.faces),
            layer,
        ),
    }
    frame
}

/// Compares a picture by the painter with the faces' fragments, their depths, and the z-buffer.
fn check(scene: &Scene, tree: Option<&BspTree<2>>, view: &View) -> Tally {
    let vertices = scene.in_clip_space(view);
    let frame = painted(scene, tree, view, |_| {});
    let reference = by_z_buffer(scene, &vertices, view);
    let depths = depths(scene, &vertices, view);
    let whole = whole(&mut scan(view), scene, &vertices);
    let behind = if view.reversed { Order::Less } else { Order::Greater };

    let mut tally = Tally { scenes: 1, faces: scene.faces.len() as u64, ..Tally::default() };
    tally.pieces = tree.map_or(0, BspTree::pieces) as u64;
    for (pixel, stack) in frame.color().iter().enumerate() {
        assert_eq!(stack.sorted(), whole[pixel].layers(), "pieces at pixel {pixel} of {view:?}");
        tally.pixels += u64::from(stack.len > 0);
        tally.layers += stack.len as u64;
        let order =
            |a: &Layer, b: &Layer| order(&depths[a.face as usize], &depths[b.face as usize], pixel);
        for (i, first) in stack.layers().iter().enumerate() {
            for later in &stack.layers()[i + 1..] {
                let order = order(later, first);
                assert_ne!(order, behind, "{later:?} over {first:?} at {pixel} in {view:?}");
                tally.pairs += u64::from(order == Order::Crossing);
            }
        }
        let (seen, expected) = (stack.layers().last().copied(), reference.color()[pixel]);
        if seen != expected {
            let pair = seen.zip(expected).map(|(a, b)| order(&a, &b));
            assert_eq!(pair, Some(Order::Crossing), "{seen:?} for {expected:?} at {pixel}");
            tally.differing += 1;
        } else if let Some(seen) = seen {
            assert_eq!(frame.depth()[pixel].to_bits(), seen.bits[0], "the depth that is seen");
        }
    }
    tally
}

fn random(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let scene = random_scene(rng);
    let tree = BspTree::new(&scene.vertices, &scene.faces);
    assert!(tree.is_exact());
    let view = random_view(rng);
    check(&scene, Some(&tree), &view) + check(&scene, None, &view)
}

fn solid(seed: u64) -> Tally {
    let rng = &mut Rng::new(seed);
    let scene = solids(rng);
    let tree = BspTree::new(&scene.vertices, &scene.faces);
    assert!(tree.is_exact());
    (0..12).map(|_| check(&scene, Some(&tree), &random_view(rng))).fold(Tally::default(), Add::add)
}

#[test]
fn polygons_through_each_other_are_drawn_as_by_the_z_buffer() {
    let tally = in_threads(0..250, random);
    println!("random polygons: {tally:?}");
    assert!(tally.pixels > 100_000, "{tally:?}");
    assert!(tally.differing * 10_000 < tally.pixels, "{tally:?}");
}

#[test]
fn solids_from_many_eyes_by_one_tree_are_drawn_as_by_the_z_buffer() {
    let tally = in_threads(0..6, solid);
    println!("solids: {tally:?}");
    assert!(tally.pixels > 50_000, "{tally:?}");
}

#[test]
#[ignore = "long: minutes in release"]
fn long_painter() {
    let tally = in_threads(LONG_SEED..LONG_SEED + 12_000, random);
    println!("random polygons: {tally:?}");
    let tally = in_threads(LONG_SEED..LONG_SEED + 300, solid);
    println!("solids: {tally:?}");
}

// -------------------------------------------------------------------------------- order and blending

/// A face's number as its colour.
fn seen(fragment: &Fragment<'_, 0>) -> Option<Option<u32>> {
    Some(Some(fragment.face))
}

/// A picture of face numbers by each of the renderers: z-buffer, painter by tree, painter by depth.
fn faces_seen(vertices: &[Vertex<0>], faces: &[Vec<u32>]) -> [Vec<Option<u32>>; 3] {
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, None).expect("a small frame");
    ZBufferRenderer::new(frame.viewport()).draw(
        &mut frame,
        polyscan::Mesh::new(vertices, faces),
        seen,
    );
    let by_z = frame.color().to_vec();
    let mut painter = PainterRenderer::new(frame.viewport());
    frame.clear(None, 1.0);
    painter.draw(&mut frame, polyscan::Mesh::new(vertices, faces), seen);
    let by_tree = frame.color().to_vec();
    frame.clear(None, 1.0);
    painter.draw(&mut frame, polyscan::Mesh::new(vertices, faces).back_to_front(), seen);
    [by_z, by_tree, frame.color().to_vec()]
}

/// Three bars in a triangle, each over the next.
fn trio() -> (Vec<Vertex<0>>, Vec<Vec<u32>>) {
    let mut vertices = Vec::new();
    for k in 0..3 {
        let turn = Vec2::from_angle(TAU * k as f32 / 3.0);
        // From the near end to the far one, along a side of the triangle.
        for (along, across, z) in
            [(-0.8, 0.15, 0.2), (-0.8, 0.35, 0.2), (0.8, 0.35, 0.8), (0.8, 0.15, 0.8)]
        {
            let place = turn.rotate(Vec2::new(along, across));
            vertices.push(Vertex::new(place.extend(z).extend(1.0), []));
        }
    }
    (vertices, (0..3).map(|k| (4 * k..4 * k + 4).collect()).collect())
}

#[test]
fn a_cyclic_trio_is_right_by_the_tree_and_wrong_by_depth() {
    let (vertices, faces) = trio();
    let tree = BspTree::new(&vertices, &faces);
    assert!(tree.pieces() > 3, "one of the bars has to be split");
    let [by_z, by_tree, by_depth] = faces_seen(&vertices, &faces);
    assert_eq!(by_tree, by_z);
    let wrong = by_depth.iter().zip(&by_z).filter(|(a, b)| a != b).count();
    assert!(wrong > 20, "{wrong} pixels");
    // Each hides a part of another.
    for (k, face) in (0..).zip(&faces) {
        let [_, alone, _] = faces_seen(&vertices, std::slice::from_ref(face));
        let own = alone.iter().filter(|face| face.is_some()).count();
        let seen = by_tree.iter().filter(|face| **face == Some(k)).count();
        assert!(seen < own, "bar {k}");
    }
}

/// With 1/w as depth the order does not hang on whether the matrix lets z grow or fall with distance.
#[test]
fn one_over_w_orders_by_distance_whatever_z_does() {
    let (bars, faces) = trio();
    let camera = look_at_mat4(vec3(0.1, 0.2, -2.0), vec3(0.0, 0.0, 0.5), Vec3::Y);
    // Panes behind each other, the nearest in the middle of the list.
    let pane = |z: f32| {
        [(-0.9, -0.9), (0.7, -0.8), (0.2 - z, 0.9)]
            .map(|(x, y)| Vertex::new(vec3(x, y, z).extend(1.0), []))
    };
    let panes: Vec<_> = [0.5, 0.9, 0.1, 0.7, 0.3].into_iter().flat_map(pane).collect();
    let pane_faces: Vec<Vec<u32>> = (0..5).map(|k| (3 * k..3 * k + 3).collect()).collect();
    for projection in [
        directx::perspective(1.0, 1.5, 0.1, 10.0),
        directx::perspective_infinite_reverse(1.0, 1.5, 0.1),
    ] {
        let matrix = projection * camera;
        let posed = |vertices: &[Vertex<0>]| -> Vec<_> {
            vertices.iter().map(|v| Vertex { position: matrix * v.position, ..*v }).collect()
        };
        let mut frame = Framebuffer::new(WIDTH, HEIGHT, None::<u32>).expect("a small frame");
        let mut z_buffer = ZBufferRenderer::new(frame.viewport());
        let mut painter = PainterRenderer::new(frame.viewport());
        z_buffer.settings.depth = DepthMode::InverseW;
        painter.settings.depth = DepthMode::InverseW;

        let mut expected = |vertices: &[Vertex<0>], faces: &[Vec<u32>]| {
            z_buffer.clear(&mut frame, None);
            z_buffer.draw(&mut frame, polyscan::Mesh::new(vertices, faces), seen);
            let numbers: std::collections::HashSet<_> = frame.color().iter().copied().collect();
            assert!(numbers.len() > 3, "all is seen: {numbers:?}");
            frame.color().to_vec()
        };
        let by_z = expected(&posed(&bars), &faces);
        let panes_by_z = expected(&posed(&panes), &pane_faces);
        painter.clear(&mut frame, None);
        painter.draw(&mut frame, BspTree::new(&bars, &faces).seen_by(matrix), seen);
        assert_eq!(frame.color(), by_z);
        painter.clear(&mut frame, None);
        let panes = posed(&panes);
        let sorted = || polyscan::Mesh::new(&panes, &pane_faces).back_to_front();
        painter.draw(&mut frame, sorted(), seen);
        assert_eq!(frame.color(), panes_by_z);
        z_buffer.depth_test = polyscan::DepthTest::Always;
        z_buffer.clear(&mut frame, None);
        z_buffer.draw(&mut frame, sorted(), seen);
        assert_eq!(frame.color(), panes_by_z);
    }
}

#[test]
fn shaders_of_blocks_give_the_same_pictures() {
    let (vertices, faces) = trio();
    let [_, by_tree, by_depth] = faces_seen(&vertices, &faces);
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, None).expect("a small frame");
    let mut painter = PainterRenderer::new(frame.viewport());
    painter.draw_blocks(
        &mut frame,
        polyscan::Mesh::new(&vertices, &faces),
        dynamic_blocks(|block, colors| {
            *colors = [Some(block.face); LANES];
        }),
    );
    assert_eq!(frame.color(), by_tree);
    frame.clear(None, 1.0);
    painter.draw_blocks(
        &mut frame,
        polyscan::Mesh::new(&vertices, &faces).back_to_front(),
        dynamic_blocks(|block, colors| {
            *colors = [Some(block.face); LANES];
        }),
    );
    assert_eq!(frame.color(), by_depth);
}

#[test]
fn a_matrix_without_an_inverse_is_drawn_by_depth() {
    let (vertices, faces) = trio();
    let tree = BspTree::new(&vertices, &faces);
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, None).expect("a small frame");
    let flat = Mat4::from_scale(vec3(1.0, 1.0, 0.0));
    let mut painter = PainterRenderer::new(frame.viewport());
    painter.draw(&mut frame, tree.seen_by(flat), seen);
    // All depths are equal, so the first is seen, as by the z-buffer.
    let flat: Vec<_> =
        vertices.iter().map(|v| Vertex { position: flat * v.position, ..*v }).collect();
    assert_eq!(frame.color(), faces_seen(&flat, &faces)[0]);
}

#[test]
fn what_does_not_overlap_in_depth_is_right_by_depth() {
    let layer =
        |z: f32| [(-0.9, -0.9), (0.7 + z, -0.8), (0.2 - z, 0.9)].map(|(x, y)| vec4(x, y, z, 1.0));
    let vertices: Vec<_> = [0.5, 0.9, 0.1, 0.7, 0.3]
        .into_iter()
        .flat_map(layer)
        .map(|position| Vertex::new(position, []))
        .collect();
    let faces: Vec<Vec<u32>> = (0..5).map(|k| (3 * k..3 * k + 3).collect()).collect();
    let [by_z, by_tree, by_depth] = faces_seen(&vertices, &faces);
    assert_eq!(by_tree, by_z);
    assert_eq!(by_depth, by_z);
}

#[test]
fn the_first_of_coplanar_polygons_is_seen() {
    for seed in 0..40 {
        let rng = &mut Rng::new(seed);
        let mut triangle = || (0..3).map(|_| [0; 2].map(|_| rng.range(-1.0, 1.0) as f32)).collect();
        let triangles: Vec<Vec<[f32; 2]>> = (0..10).map(|_| triangle()).collect();
        let on_plane = |[x, y]: [f32; 2]| Vertex::new(vec4(x, y, 0.5, 1.0), []);
        let vertices: Vec<_> = triangles.concat().into_iter().map(on_plane).collect();
        let faces: Vec<Vec<u32>> = (0..10).map(|k| (3 * k..3 * k + 3).collect()).collect();
        assert_eq!(BspTree::new(&vertices, &faces).pieces(), 10);
        let [by_z, by_tree, by_depth] = faces_seen(&vertices, &faces);
        assert_eq!((&by_tree, &by_depth), (&by_z, &by_z), "seed {seed}");
    }
}

/// The colour of a face: light premultiplied by an alpha of 0.2..0.9.
fn glass(face: u32) -> Vec4 {
    let rng = &mut Rng::new(face.into());
    let alpha = rng.range(0.2, 0.9) as f32;
    (Vec3::from_array(from_fn(|_| rng.range(0.0, 1.0) as f32)) * alpha).extend(alpha)
}

/// The glass at a pixel, by the depths of its faces, in f64; `None` where two of them cross.
fn blended(stack: &Stack, depths: &[Depth], view: &View, pixel: usize) -> Option<DVec4> {
    let order = |a: usize, b: usize| order(&depths[a], &depths[b], pixel);
    let farther = if view.reversed { Order::Less } else { Order::Greater };
    let mut faces: Vec<_> = stack.layers().iter().map(|layer| layer.face as usize).collect();
    let crosses = |&a: &usize| faces.iter().any(|&b| a != b && order(a, b) == Order::Crossing);
    if faces.iter().any(crosses) {
        return None;
    }
    let nearer = |a: usize| {
        let is_nearer = |&&b: &&usize| a != b && order(a, b) == farther;
        faces.iter().filter(is_nearer).count()
    };
    let counts: Vec<_> = (0..depths.len()).map(nearer).collect();
    faces.sort_by_key(|&face| counts[face]);
    Some(faces.iter().rev().fold(DVec4::W, |color, &face| {
        let glass = glass(face as u32).as_dvec4();
        glass + color * (1.0 - glass.w)
    }))
}

/// Glass through glass, against the faces at each pixel sorted by their depth and laid over each
/// other in f64.
#[test]
fn transparent_polygons_through_each_other_are_blended_in_their_order() {
    let (mut pixels, mut left_out) = (0, 0);
    for seed in 0..150 {
        let rng = &mut Rng::new(seed);
        let scene = random_scene(rng);
        let view = random_view(rng);
        let tree = BspTree::new(&scene.vertices, &scene.faces);
        let mut frame = Framebuffer::new(WIDTH, HEIGHT, Vec4::W).expect("a small frame");
        let mut painter = PainterRenderer::new(frame.viewport());
        painter.settings.clip_space = view.clip_space;
        painter.settings.depth = view.depth_mode();
        painter.draw(&mut frame, tree.seen_by(view.matrix), |f| Over(glass(f.face)));
        assert!(frame.depth().iter().all(|&depth| depth == 1.0), "no depth is stored");
        let mut blocks = Framebuffer::new(WIDTH, HEIGHT, Vec4::W).expect("a small frame");
        painter.draw_blocks(&mut blocks, tree.seen_by(view.matrix), |block, colors| {
            let over = glass(block.face);
            colors.iter_mut().for_each(|color| *color = over + *color * (1.0 - over.w));
        });
        assert_eq!(frame, blocks);

        let vertices = scene.in_clip_space(&view);
        let depths = depths(&scene, &vertices, &view);
        let whole = whole(&mut scan(&view), &scene, &vertices);
        for (pixel, stack) in whole.iter().enumerate() {
            let Some(expected) = blended(stack, &depths, &view, pixel) else {
                left_out += 1;
                continue;
            };
            let found = frame.color()[pixel].as_dvec4();
            assert!(found.abs_diff_eq(expected, 1e-6), "{found} for {expected}, seed {seed}");
            pixels += usize::from(stack.len > 0);
        }
    }
    println!("glass: {pixels} pixels, {left_out} left out");
    assert!(pixels > 80_000 && left_out * 500 < pixels);
}

// ------------------------------------------------------------------------------------------ settings

#[test]
fn settings_are_those_of_the_scan_converter() {
    let rng = &mut Rng::new(11);
    let mut culled = 0;
    for _ in 0..60 {
        let scene = random_scene(rng);
        let view = random_view(rng);
        let tree = BspTree::new(&scene.vertices, &scene.faces);
        let cull = [Cull::None, Cull::Back, Cull::Front][rng.below(3)];
        let plane = ClipPlane::new(direction(rng).extend(0.3));
        let scissor = Rect { x: 10, y: 5, width: 40, height: 37 };
        let front_face = [FrontFace::CounterClockwise, FrontFace::Clockwise][rng.below(2)];
        let set_up = |settings: &mut Settings<2>| {
            (settings.cull, settings.front_face) = (cull, front_face);
            settings.planes = vec![plane];
            settings.scissor = Some(scissor);
            settings.clip_space = view.clip_space;
            settings.interpolation = [Interpolation::Flat, Interpolation::Linear];
        };
        let frame = painted(&scene, Some(&tree), &view, set_up);
        let mut scan = ScanConverter::new(frame.viewport());
        set_up(&mut scan.settings);
        let whole = whole(&mut scan, &scene, &scene.in_clip_space(&view));
        for (stack, whole) in frame.color().iter().zip(&whole) {
            assert_eq!(stack.sorted(), whole.layers());
            culled += usize::from(stack.len == 0);
        }
    }
    assert!(culled > 1000);
}

#[test]
fn the_viewports_depth_may_be_reversed_too() {
    let (vertices, faces) = trio();
    let [expected, ..] = faces_seen(&vertices, &faces);
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, None).expect("a small frame");
    let mut painter = PainterRenderer::new(frame.viewport().with_depth(1.0, 0.0));
    painter.settings.depth = DepthMode::Reversed;
    painter.draw(&mut frame, polyscan::Mesh::new(&vertices, &faces), seen);
    assert_eq!(frame.color(), expected);
}

#[test]
fn the_picture_is_the_same_in_tiles_by_any_number_of_threads_and_at_any_level() {
    let rng = &mut Rng::new(3);
    for _ in 0..4 {
        let scene = solids(rng);
        let tree = BspTree::new(&scene.vertices, &scene.faces);
        let matrix = random_view(rng).matrix;
        let draw = |level, (x, y): (i32, i32), size: [u32; 2]| {
            let mut frame = Framebuffer::new(size[0], size[1], [0; 4]).expect("a small frame");
            let viewport = Viewport::new(150, 100).expect("a small viewport").with_corner(-x, -y);
            let mut painter = PainterRenderer::new(viewport);
            (painter.simd_level, painter.depth_write) = (level, true);
            painter.draw(&mut frame, tree.seen_by(matrix), dynamic(|f| layer(f).bits));
            frame
        };
        let whole = draw(Level::new(), (0, 0), [150, 100]);
        assert_eq!(whole, draw(Level::baseline(), (0, 0), [150, 100]));
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let frame = pool.expect("threads").install(|| draw(Level::new(), (0, 0), [150, 100]));
            assert_eq!(frame, whole);
        }
        for (x, y) in (0..5).flat_map(|i| (0..5).map(move |j| (i * 37 - 10, j * 23 - 7))) {
            let tile = draw(Level::new(), (x, y), [37, 23]);
            for (i, &bits) in (0..).zip(tile.color()) {
                let (column, row) = (x + i % 37, y + i / 37);
                let inside = (0..150).contains(&column) && (0..100).contains(&row);
                let expected = inside.then(|| whole.pixel(column as u32, row as u32)).flatten();
                assert_eq!(bits, expected.map_or([0; 4], |(bits, _)| bits));
            }
        }
    }
}

// ----------------------------------------------------------------------------------------- any input

/// Anything; each pixel of a face is drawn once, whatever the tree thinks of it.
fn anything(seed: u64) {
    let rng = &mut Rng::new(seed);
    let oddness = [3, 6, 20, 100][rng.below(4)];
    let has_w = rng.once_in(2);
    let vertex = |rng: &mut Rng| {
        let mut position = Vec4::from_array(from_fn(|_| number(rng, oddness)));
        if !has_w {
            position.w = 1.0;
        }
        Vertex::new(position, [0; 2].map(|_| number(rng, oddness)))
    };
    let vertices: Vec<_> = (0..3 + rng.below(30)).map(|_| vertex(rng)).collect();
    let corners = |rng: &mut Rng| {
        let sides = if rng.once_in(20) { rng.below(60) } else { rng.below(6) };
        let last = vertices.len() + usize::from(rng.once_in(20));
        (0..sides).map(|_| rng.below(last) as u32).collect()
    };
    let faces: Vec<Vec<u32>> = (0..rng.below(20)).map(|_| corners(rng)).collect();
    let scene = Scene { vertices, faces };
    let tree = BspTree::new(&scene.vertices, &scene.faces);
    let mut view = random_view(rng);
    if rng.once_in(2) {
        view.matrix = Mat4::from_cols_array(&from_fn(|_| number(rng, oddness)));
    }
    for tree in [Some(&tree), None] {
        let frame = painted(&scene, tree, &view, |_| {});
        let clip = scene.in_clip_space(&view);
        let known = Scene {
            faces: scene.faces.iter().map(|face| known(face, clip.len())).collect(),
            ..scene.clone()
        };
        let drawn = frame.color().iter().map(|stack| stack.len).collect::<Vec<_>>();
        let whole = whole(&mut scan(&view), &known, &clip);
        if tree.is_none() {
            // In object space a position that is not finite has no place in the tree.
            let expected: Vec<_> = whole.iter().map(|stack| stack.len).collect();
            assert_eq!(drawn, expected, "seed {seed}");
        }
        let at_most = |(drawn, whole): (&usize, &Stack)| *drawn <= whole.len;
        assert!(drawn.iter().zip(&whole).all(at_most), "seed {seed}");
    }
}

/// A face, or none if it has an index out of range.
fn known(face: &[u32], vertices: usize) -> Vec<u32> {
    if face.iter().all(|&i| (i as usize) < vertices) { face.to_vec() } else { Vec::new() }
}

#[test]
fn any_input_is_safe() {
    (0..1500).for_each(anything);
}

#[test]
#[ignore = "long: a minute in release"]
fn long_any_input() {
    let count = in_threads(LONG_SEED..LONG_SEED + 50_000, |seed| {
        anything(seed);
        1u64
    });
    println!("{count} scenes of any input");
}

#[test]
fn thousands_of_coincident_faces_are_one_node() {
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let vertices = square.map(|(x, y)| Vertex::new(vec4(x, y, 0.3 + 0.1 * x, 1.0), []));
    let faces = vec![[0, 1, 2, 3]; 20_000];
    let tree = BspTree::new(&vertices, &faces);
    assert_eq!((tree.faces(), tree.pieces(), tree.is_exact()), (20_000, 20_000, true));
    let mut frame = Framebuffer::new(1, 1, None).expect("a small frame");
    PainterRenderer::new(frame.viewport()).draw(&mut frame, tree.seen_by(Mat4::IDENTITY), seen);
    assert_eq!(frame.color(), [Some(0)]);
}

#[test]
fn a_tube_of_many_sides_makes_no_deep_recursion() {
    // Its faces cut none of the others.
    let sides = 30_000;
    let vertices: Vec<_> = (0..2 * sides)
        .map(|i| {
            let at = Vec2::from_angle(TAU * (i / 2) as f32 / sides as f32);
            Vertex::new(vec4(at.x, (i % 2) as f32, at.y, 1.0), [])
        })
        .collect();
    let faces = (0..sides).map(|i| [0, 1, 3, 2].map(|k| (2 * i + k) as u32 % (2 * sides) as u32));
    let tree = BspTree::new(&vertices, faces);
    assert!(tree.is_exact() && tree.pieces() < 2 * sides, "{} pieces", tree.pieces());
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, 0u8).expect("a small frame");
    let matrix = directx::perspective(0.8, 1.3, 0.1, 9.0)
        * look_at_mat4(vec3(0.0, 2.0, 4.0), Vec3::ZERO, Vec3::Y);
    PainterRenderer::new(frame.viewport()).draw(&mut frame, tree.seen_by(matrix), dynamic(|_| 1));
    assert!(frame.color().contains(&1));
}

#[test]
fn planes_that_all_cross_each_other_do_not_fill_the_memory() {
    let rng = &mut Rng::new(1);
    let mut scene = Scene::default();
    for _ in 0..250 {
        let turn = Quat::from_rotation_arc(Vec3::Z, direction(rng));
        let corner = |(x, y): (f32, f32)| turn * vec3(x, y, 0.1);
        scene.add([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner), rng);
    }
    let tree = BspTree::new(&scene.vertices, &scene.faces);
    println!("250 squares: {} pieces, exact: {}", tree.pieces(), tree.is_exact());
    assert!(tree.pieces() < 500_000);
    let mut frame = Framebuffer::new(WIDTH, HEIGHT, 0u32).expect("a small frame");
    let mut painter = PainterRenderer::new(frame.viewport());
    painter.draw(&mut frame, tree.seen_by(random_view(rng).matrix), dynamic(|_| 1));
    assert!(frame.color().contains(&1));
}
