//! The visibility buffer: faces, depths, barycentrics and their derivatives, layers.
//!
//! What is seen is compared with every face at every pixel: covered or not by the oracle's exact
//! coverage, and its depth, its weights and its w by the oracle's meeting of ray and plane.

use crate::common::generators::{self, Rng, Shape};
use crate::common::oracle::{self, Depth, FillRule, Position, Sample, Window};
use crate::common::{LONG_SEED, dynamic, in_threads, tally, vertices, viewport};
use glam::vec4;
use polyscan::render::{
    MultisampleFramebuffer, MultisampleRenderer, Product, Samples, Visibility, VisibilityRenderer,
};
use polyscan::{DepthMode, Framebuffer, Level, Mesh, Vertex, ZBufferRenderer};

const WINDOW: Window = Window { width: 24, height: 17 };
const GUARD: f64 = 65536.0;
const ALL: [Product; 4] =
    [Product::W, Product::Barycentrics, Product::Corners, Product::Derivatives];

/// Depths nearer to each other than this have either order: f32 and rounding of edges.
const TIE: f64 = 2e-6;

/// Faces of a scene, whose vertices lie end to end.
struct Scene {
    shapes: Vec<Shape<1>>,
    vertices: Vec<Vertex<1>>,
    faces: Vec<Vec<u32>>,
}

impl Scene {
    fn new(shapes: Vec<Shape<1>>) -> Self {
        let mut scene = Self { shapes: Vec::new(), vertices: Vec::new(), faces: Vec::new() };
        for shape in shapes {
            let first = scene.vertices.len() as u32;
            scene.vertices.extend(vertices(&shape));
            scene.faces.push((first..scene.vertices.len() as u32).collect());
            scene.shapes.push(shape);
        }
        scene
    }

    fn random(seed: u64) -> Self {
        let rng = &mut Rng::new(seed);
        let count = 1 + rng.below(5);
        let shape = |rng: &mut Rng| match rng.below(4) {
            0 => generators::through_eye(rng, 3),
            1 => generators::random_convex(rng, 5, 20.0),
            _ => {
                let ratio = rng.octaves(1.0, 1000.0);
                generators::random_triangle(rng, ratio, 1.5)
            }
        };
        Self::new((0..count).map(|_| shape(rng)).collect())
    }

    fn mesh(&self) -> Mesh<'_, &[Vec<u32>], 1> {
        Mesh::new(&self.vertices, &self.faces)
    }

    /// Every face that covers a pixel, with its sample there, the nearest first.
    fn at(&self, masks: &[oracle::Mask], x: u32, y: u32) -> Vec<(u32, Sample<1>)> {
        let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let mut there = Vec::new();
        for ((shape, mask), face) in self.shapes.iter().zip(masks).zip(0..) {
            if mask.contains(x, y) {
                let found = sample(&shape.positions, &shape.parameters, centre);
                there.extend(found.map(|sample| (face, sample)));
            }
        }
        there.sort_by(|(_, a), (_, b)| a.z_over_w.total_cmp(&b.z_over_w));
        there
    }

    fn masks(&self) -> Vec<oracle::Mask> {
        let mask = |shape: &Shape<1>| {
            let rule = FillRule::NonZero;
            oracle::coverage(&shape.positions, WINDOW, Depth::ZeroToOne, GUARD, rule)
        };
        self.shapes.iter().map(mask).collect()
    }
}

fn sample(polygon: &[Position], values: &[[f32; 1]], centre: [f64; 2]) -> Option<Sample<1>> {
    let triple = oracle::best_triple(polygon)?;
    oracle::sample(polygon, values, triple, WINDOW, centre)
}

tally! {
    struct Seen {
        pixels: u64,
        /// Where several faces were.
        hidden: u64,
        layers: u64,
    }
}

/// Whether the depth at a pixel is that of a sample: within f32's rounding, and what the plane changes
/// over the subpixel by which the centre may lie outside, where the range of the vertices ends it.
fn is_depth_of(depth: f32, sample: &Sample<1>) -> bool {
    (f64::from(depth) - sample.z_over_w.clamp(0.0, 1.0)).abs() < 1e-4
}

/// Checks the faces of one scene: which is seen, that its depth is its own, and that a z-buffer has the
/// same to the bit.
fn check_faces(seed: u64) -> Seen {
    let scene = Scene::random(seed);
    let masks = scene.masks();
    let mut seen = Visibility::new(WINDOW.width, WINDOW.height, &[]).expect("a small buffer");
    VisibilityRenderer::new(seen.viewport()).draw(&mut seen, scene.mesh());
    let mut frame = Framebuffer::new(WINDOW.width, WINDOW.height, u32::MAX).expect("small");
    ZBufferRenderer::new(frame.viewport()).draw(&mut frame, scene.mesh(), dynamic(|f| f.face));
    assert_eq!(seen.face, frame.color(), "seed {seed}");
    assert_eq!(seen.depth, frame.depth(), "seed {seed}");
    let mut tally = Seen::default();
    for (pixel, (&face, &depth)) in seen.face.iter().zip(&seen.depth).enumerate() {
        let (x, y) = (pixel as u32 % WINDOW.width, pixel as u32 / WINDOW.width);
        let there = scene.at(&masks, x, y);
        let place = format!("seed {seed}, pixel {x}, {y}: face {face} of {there:?}");
        let Some((_, nearest)) = there.first() else {
            assert!(face == Visibility::NO_FACE && depth == 1.0, "{place}");
            continue;
        };
        let own = there.iter().find(|(number, _)| *number == face);
        let (_, own) = own.unwrap_or_else(|| panic!("{place}"));
        assert!(is_depth_of(depth, own), "{place}: {depth}");
        // A face of which the centre lies outside, by rounding, has the depth of its nearest vertex.
        let slack = if nearest.is_inside() && own.is_inside() { TIE } else { 1e-3 };
        assert!(own.z_over_w <= nearest.z_over_w + slack, "{place}");
        tally.pixels += 1;
        tally.hidden += u64::from(there.len() > 1);
    }
    tally
}

#[test]
fn the_face_is_the_nearest_of_all_and_the_depth_is_its_own() {
    let seen = in_threads(0..2500, check_faces);
    assert!(seen.pixels > 200_000 && seen.hidden > 50_000, "{seen:?}");
}

#[test]
#[ignore = "takes a minute"]
fn the_face_is_the_nearest_of_all_in_many_scenes() {
    println!("{:?}", in_threads(LONG_SEED..LONG_SEED + 100_000, check_faces));
}

/// Weights in f64 with what is negative taken as 0.
fn limited(weights: [f64; 3]) -> [f64; 3] {
    let inside = weights.map(|b| b.max(0.0));
    inside.map(|b| b / inside.iter().sum::<f64>())
}

/// The oracle's sample at a point of the triangle of three vertices; its value is that of the first
/// parameter.
fn on_corners(scene: &Scene, corners: [u32; 3], point: [f64; 2]) -> Option<Sample<3>> {
    let positions = corners.map(|i| scene.vertices[i as usize].position.to_array());
    let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    oracle::sample_exact(&positions, &units, [0, 1, 2], WINDOW, point)
}

/// Checks weights, w and derivatives of one scene at pixels' centres.
fn check_weights(seed: u64) -> Seen {
    let scene = Scene::random(seed);
    let mut seen = Visibility::new(WINDOW.width, WINDOW.height, &ALL).expect("a small buffer");
    VisibilityRenderer::new(seen.viewport()).draw(&mut seen, scene.mesh());
    check_weights_at(seed, &scene, &seen, &[[0, 0]])
}

/// Checks them at places in 1/256 pixel from each pixel's centre.
fn check_weights_at(seed: u64, scene: &Scene, seen: &Visibility, places: &[[i32; 2]]) -> Seen {
    let mut tally = Seen::default();
    for (pixel, &face) in seen.face.iter().enumerate() {
        let (place, at) = (places[pixel % places.len()], (pixel / places.len()) as u32);
        let (x, y) = (at % WINDOW.width, at / WINDOW.width);
        let [right, below] = place.map(|distance| f64::from(distance) / 256.0);
        let point = [f64::from(x) + 0.5 + right, f64::from(y) + 0.5 + below];
        let (corners, weights) = (seen.corners[pixel], seen.barycentrics[pixel]);
        if face == Visibility::NO_FACE {
            assert!(weights == [0.0; 3] && seen.w[pixel] == 0.0 && corners == [0; 3]);
            assert!(seen.derivatives[pixel] == [[0.0; 2]; 3]);
            continue;
        }
        assert!(corners.iter().all(|i| scene.faces[face as usize].contains(i)), "{corners:?}");
        let Some(exact) = on_corners(scene, corners, point) else { continue };
        let place = format!("seed {seed}, {point:?}: {weights:?} and {exact:?}");
        // Of the triangles that a face of more sides fans into it is one that the centre is in, if any is.
        let face = &scene.faces[face as usize];
        let fan = face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]);
        let is_in = |triangle| on_corners(scene, triangle, point).is_some_and(|s| s.is_inside());
        if fan.into_iter().any(is_in) {
            assert!(exact.barycentric.iter().all(|b| *b > -1e-9), "{place}");
        }
        let right = limited(exact.barycentric);
        for (weight, right) in weights.iter().zip(right) {
            assert!((f64::from(*weight) - right).abs() <= 1e-5, "{place}");
        }
        let w: f64 = corners
            .iter()
            .zip(right)
            .map(|(&i, b)| b * f64::from(scene.vertices[i as usize].position.w))
            .sum();
        assert!(
            (f64::from(seen.w[pixel]) - w).abs() <= 1e-6 * w.abs(),
            "{place}: w {}",
            seen.w[pixel]
        );
        for i in 0..3 {
            let [dx, dy] = seen.derivatives[pixel][i].map(f64::from);
            let scale = exact.dx[i].abs().max(exact.dy[i].abs()).max(1e-3);
            assert!((dx - exact.dx[i]).abs() <= 1e-5 * scale, "{place}: {dx}");
            assert!((dy - exact.dy[i]).abs() <= 1e-5 * scale, "{place}: {dy}");
        }
        tally.pixels += 1;
    }
    tally
}

#[test]
fn weights_w_and_derivatives_are_those_of_rational_arithmetic() {
    let seen = in_threads(0..150, check_weights);
    assert!(seen.pixels > 15_000, "{seen:?}");
}

/// Checks what is seen at the samples of one scene: faces and depths, which are tested elsewhere, are the
/// renderer of samples' own.
fn check_samples(seed: u64) -> Seen {
    let scene = Scene::random(seed);
    let samples = [Samples::Four, Samples::Eight, Samples::Sixteen][seed as usize % 3];
    let (width, height) = (WINDOW.width, WINDOW.height);
    let mut seen = Visibility::with_samples(width, height, samples, &ALL).expect("a small buffer");
    VisibilityRenderer::new(seen.viewport()).draw(&mut seen, scene.mesh());
    assert_eq!((seen.samples(), seen.layers()), (Some(samples), 1));
    let mut frame = MultisampleFramebuffer::new(width, height, samples, Visibility::NO_FACE)
        .expect("a small frame");
    MultisampleRenderer::new(frame.viewport()).draw(&mut frame, scene.mesh(), dynamic(|f| f.face));
    for (i, (&face, &depth)) in seen.face.iter().zip(&seen.depth).enumerate() {
        let (sample, pixel) = (i % samples.count(), (i / samples.count()) as u32);
        let found = frame.sample(pixel % width, pixel / width, sample);
        let (own, own_depth) = found.expect("a sample");
        assert_eq!((face, depth.to_bits()), (own, own_depth.to_bits()), "seed {seed}, {i}");
    }
    check_weights_at(seed, &scene, &seen, samples.places())
}

#[test]
fn at_samples_are_their_faces_depths_weights_w_and_derivatives() {
    let seen = in_threads(0..24, check_samples);
    assert!(seen.pixels > 10_000, "{seen:?}");
}

/// Checks that of the layers of one scene each is there, in order, with its own depth.
fn check_layers(seed: u64) -> Seen {
    let scene = Scene::random(seed);
    let masks = scene.masks();
    let layers = 1 + seed as u32 % 4;
    let (width, height) = (WINDOW.width, WINDOW.height);
    let mut seen = Visibility::with_layers(width, height, layers, &ALL).expect("a small buffer");
    VisibilityRenderer::new(seen.viewport()).draw(&mut seen, scene.mesh());
    let mut nearest = Visibility::new(width, height, &ALL).expect("a small buffer");
    VisibilityRenderer::new(nearest.viewport()).draw(&mut nearest, scene.mesh());
    let layers = layers as usize;
    let mut tally = Seen::default();
    let faces = seen.face.chunks(layers).zip(seen.depth.chunks(layers));
    for (pixel, (faces, depths)) in faces.enumerate() {
        let (x, y) = (pixel as u32 % width, pixel as u32 / width);
        let there = scene.at(&masks, x, y);
        let place = format!("seed {seed}, pixel {x}, {y}: {faces:?} {depths:?} of {there:?}");
        let count = there.len().min(layers);
        assert!(faces[count..].iter().all(|face| *face == Visibility::NO_FACE), "{place}");
        assert!(depths.is_sorted(), "{place}");
        for (place_in_order, (face, depth)) in faces[..count].iter().zip(depths).enumerate() {
            let own = there.iter().find(|(number, _)| number == face);
            let (_, own) = own.unwrap_or_else(|| panic!("{place}"));
            assert!(is_depth_of(*depth, own), "{place}");
            // In its place among all that are there.
            let (_, in_place) = there[place_in_order];
            let slack = if there.iter().all(|(_, s)| s.is_inside()) { TIE } else { 1e-3 };
            assert!((own.z_over_w - in_place.z_over_w).abs() <= slack, "{place}");
            assert!(!faces[..place_in_order].contains(face), "{place}");
            tally.layers += 1;
        }
        // The first layer is what the z-buffer has.
        let first = pixel * layers;
        assert_eq!(faces[0], nearest.face[pixel], "{place}");
        assert_eq!(depths[0].to_bits(), nearest.depth[pixel].to_bits(), "{place}");
        assert_eq!(seen.barycentrics[first], nearest.barycentrics[pixel], "{place}");
        assert_eq!(seen.w[first].to_bits(), nearest.w[pixel].to_bits(), "{place}");
        tally.hidden += u64::from(there.len() > 1);
    }
    tally
}

#[test]
fn layers_are_complete_and_in_order() {
    let seen = in_threads(0..600, check_layers);
    assert!(seen.layers > 50_000 && seen.hidden > 10_000, "{seen:?}");
}

/// Everything that a buffer holds, as bits.
fn bits(seen: &Visibility, pixel: usize) -> Vec<u32> {
    let layers = seen.layers() as usize * seen.samples().map_or(1, Samples::count);
    let mut bits = Vec::new();
    for i in pixel * layers..(pixel + 1) * layers {
        bits.extend([seen.face[i], seen.depth[i].to_bits(), seen.w[i].to_bits()]);
        bits.extend(seen.barycentrics[i].map(f32::to_bits));
        bits.extend(seen.corners[i]);
        bits.extend(seen.derivatives[i].as_flattened().iter().map(|d| d.to_bits()));
    }
    bits
}

#[test]
fn a_tile_and_any_level_have_the_same_bits() {
    let rng = &mut Rng::new(3);
    let shapes = (0..60).map(|i| match i % 3 {
        0 => generators::through_eye(rng, 4),
        1 => generators::random_convex(rng, 6, 50.0),
        _ => generators::random_triangle(rng, 300.0, 1.5),
    });
    let scene = Scene::new(shapes.collect());
    let (width, height) = (111, 83);
    for layers in [Some(1), Some(3), None] {
        let buffer = |width, height| match layers {
            Some(layers) => Visibility::with_layers(width, height, layers, &ALL),
            None => Visibility::with_samples(width, height, Samples::Eight, &ALL),
        };
        let buffer = |width, height| buffer(width, height).expect("a small buffer");
        let mut whole = buffer(width, height);
        let mut renderer = VisibilityRenderer::new(whole.viewport());
        renderer.draw(&mut whole, scene.mesh());
        let mut other = buffer(width, height);
        renderer.simd_level = Level::baseline();
        renderer.draw(&mut other, scene.mesh());
        for pixel in 0..(width * height) as usize {
            assert_eq!(bits(&whole, pixel), bits(&other, pixel), "pixel {pixel}");
        }
        let (left, top) = (37, 19);
        let mut tile = buffer(40, 50);
        let mut renderer = VisibilityRenderer::new(whole.viewport().with_corner(-left, -top));
        renderer.draw(&mut tile, scene.mesh());
        for y in 0..50 {
            for x in 0..40 {
                let in_whole = (y + top as usize) * width as usize + x + left as usize;
                assert_eq!(bits(&tile, y * 40 + x), bits(&whole, in_whole), "{x}, {y}");
            }
        }
    }
}

/// Faces of a mesh with other meshes' parts in one batch and of several batches are numbered alike; what
/// is not asked for is not there; a second drawing replaces the first.
#[test]
fn a_buffer_holds_what_was_asked_for_and_is_drawn_anew() {
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(2.0 * x, 2.0 * y, 1.0, 2.0), [7.0]));
    let mut seen = Visibility::new(8, 4, &[Product::W]).expect("a small buffer");
    let mut renderer = VisibilityRenderer::new(seen.viewport());
    renderer.draw(&mut seen, Mesh::new(&square, [[0, 1, 2, 3]]));
    assert_eq!((&seen.face[..], &seen.w[..]), (&[0; 32][..], &[2.0; 32][..]));
    assert!(seen.barycentrics.is_empty() && seen.corners.is_empty() && seen.derivatives.is_empty());
    assert_eq!(seen.distances(1000.0), [2000; 32]);
    assert_eq!(seen.distances(40_000.0), [65_535; 32]);
    let faces = std::mem::take(&mut seen.face);
    assert_eq!(faces.len(), 32);
    renderer.settings.depth = DepthMode::Reversed;
    renderer.draw(&mut seen, Mesh::new(&square, [[0, 1, 9], [0, 1, 2]]));
    assert_eq!(seen.face[31], 1);
    assert_eq!((seen.face[0], seen.depth[0], seen.w[0]), (Visibility::NO_FACE, 0.0, 0.0));
    assert_eq!((viewport(WINDOW).rect().width, seen.distances(1.0)[0]), (24, 0));
}
