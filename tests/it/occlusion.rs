//! Occlusion without pixels: what is said to be hidden is hidden at every pixel of the picture that the
//! z-buffer draws.

use std::array::from_fn;

use crate::common::generators::Rng;
use crate::common::{in_threads, tally};
use glam::camera::rh::{proj::directx, proj::opengl, view::look_at_mat4};
use glam::{Mat4, Vec3, vec3};
use polyscan::render::OcclusionRenderer;
use polyscan::{ClipSpace, DepthMode, DepthTest, Framebuffer, Mesh, Vertex, ZBufferRenderer};

const FACES: [[u32; 4]; 6] =
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];

tally! {
    struct Seen {
        boxes: u64,
        /// Of which a pixel would pass if there were no occluders.
        on_picture: u64,
        /// Of these, those of which none passes, and of those, the ones that the tiles hide.
        hidden: u64,
        found: u64,
        /// Of the others, those that are said to be hidden.
        found_beside: u64,
    }
}

fn vector(rng: &mut Rng, reach: f64) -> Vec3 {
    Vec3::from_array(from_fn(|_| rng.range(-reach, reach) as f32))
}

fn corners([from, to]: [Vec3; 2]) -> [Vec3; 8] {
    from_fn(|i| {
        let choose = |axis: usize| if i >> axis & 1 != 0 { to[axis] } else { from[axis] };
        vec3(choose(0), choose(1), choose(2))
    })
}

/// A camera, of any kind and with any mode of depth that it goes with.
fn camera(rng: &mut Rng, (width, height): (u32, u32)) -> (Mat4, ClipSpace, DepthMode) {
    let eye = vector(rng, 1.0).normalize_or(Vec3::X) * rng.range(2.0, 6.0) as f32;
    let view = look_at_mat4(eye, vector(rng, 0.5), vector(rng, 1.0).normalize_or(Vec3::Y));
    let aspect = width as f32 / height as f32;
    let (angle, near, far) = (rng.range(0.4, 1.4) as f32, rng.octaves(0.01, 1.0) as f32, 20.0);
    match rng.below(4) {
        0 => (
            opengl::perspective(angle, aspect, near, far) * view,
            ClipSpace::MinusOneToOne,
            DepthMode::Standard,
        ),
        1 => (
            directx::perspective(angle, aspect, far, near) * view,
            ClipSpace::ZeroToOne,
            DepthMode::Reversed,
        ),
        2 => (
            directx::orthographic(-3.0, 3.0, -2.0, 2.0, 0.0, far) * view,
            ClipSpace::ZeroToOne,
            DepthMode::Standard,
        ),
        _ => (
            directx::perspective(angle, aspect, near, far) * view,
            ClipSpace::ZeroToOne,
            DepthMode::Standard,
        ),
    }
}

/// Walls, boxes and small triangles.
fn occluders(rng: &mut Rng, places: &mut Vec<Vec3>, faces: &mut Vec<Vec<u32>>) {
    for _ in 0..1 + rng.below(14) {
        let first = places.len() as u32;
        if rng.once_in(2) {
            let (middle, half) = (vector(rng, 1.5), vector(rng, 1.0));
            places.extend(corners([middle - half, middle + half]));
            faces.extend(FACES.map(|face| face.map(|i| first + i).to_vec()));
            continue;
        }
        // A flat polygon, of a size.
        let (middle, size) = (vector(rng, 1.5), rng.octaves(0.1, 3.0) as f32);
        let (x, y) = vector(rng, 1.0).normalize_or(Vec3::X).any_orthonormal_pair();
        let thin = if rng.once_in(4) { rng.octaves(1e-6, 0.1) as f32 } else { 1.0 };
        let sides = 3 + rng.below(4);
        for side in 0..sides {
            let angle = std::f32::consts::TAU * side as f32 / sides as f32;
            places.push(middle + (x * angle.cos() + y * (angle.sin() * thin)) * size);
        }
        faces.push((first..places.len() as u32).collect());
    }
}

/// What is drawn of a box: its sides, and triangles in it.
fn contents(rng: &mut Rng, within: [Vec3; 2], matrix: Mat4) -> (Vec<Vertex<0>>, Vec<Vec<u32>>) {
    let mut places = corners(within).to_vec();
    let mut faces: Vec<Vec<u32>> = FACES.iter().map(|face| face.to_vec()).collect();
    for _ in 0..12 {
        let first = places.len() as u32;
        for _ in 0..3 {
            places.push(Vec3::from_array(from_fn(|axis| {
                let t = rng.range(0.0, 1.0) as f32;
                let (a, b) = (within[0][axis], within[1][axis]);
                (a + (b - a) * t).clamp(a.min(b), a.max(b))
            })));
        }
        faces.push(vec![first, first + 1, first + 2]);
    }
    (places.iter().map(|p| Vertex::new(matrix * p.extend(1.0), [])).collect(), faces)
}

/// One scene: occluders, and boxes of all sizes in front of them, through them and behind them.
fn check_scene(rng: &mut Rng) -> Seen {
    let size = (1 + rng.below(150) as u32, 1 + rng.below(110) as u32);
    let (matrix, clip_space, depth) = camera(rng, size);
    let (mut places, mut faces) = (Vec::new(), Vec::new());
    occluders(rng, &mut places, &mut faces);
    let vertices: Vec<_> = places.iter().map(|p| Vertex::new(matrix * p.extend(1.0), [])).collect();
    let mut frame = Framebuffer::new(size.0, size.1, ()).expect("a small frame");
    let mut renderer = ZBufferRenderer::<0>::new(frame.viewport());
    (renderer.settings.clip_space, renderer.settings.depth) = (clip_space, depth);
    renderer.clear(&mut frame, ());
    renderer.draw_depth(&mut frame, Mesh::new(&vertices, &faces));
    renderer.depth_test = DepthTest::NearerOrEqual;

    let mut occlusion = OcclusionRenderer::new(frame.viewport()).expect("a small one");
    (occlusion.settings.clip_space, occlusion.settings.depth) = (clip_space, depth);
    occlusion.draw(Mesh::new(&vertices, &faces));

    let mut empty = Framebuffer::new(size.0, size.1, ()).expect("a small frame");
    renderer.clear(&mut empty, ());
    let mut seen = Seen::default();
    for _ in 0..4 {
        let (middle, half) = (vector(rng, 3.0), vector(rng, 1.0) * rng.octaves(0.01, 1.0) as f32);
        let within = [middle - half, middle + half];
        let is_hidden = occlusion.is_hidden(matrix, within);
        let (vertices, faces) = contents(rng, within, matrix);
        let pixels = renderer.count_visible(&mut frame, Mesh::new(&vertices, &faces));
        assert!(
            !is_hidden || pixels == 0,
            "{pixels} pixels are seen of {within:?} through {matrix:?}, {size:?}"
        );
        let without = renderer.count_visible(&mut empty, Mesh::new(&vertices, &faces));
        seen.boxes += 1;
        seen.on_picture += u64::from(without > 0);
        seen.hidden += u64::from(without > 0 && pixels == 0);
        seen.found += u64::from(without > 0 && is_hidden);
        seen.found_beside += u64::from(without == 0 && is_hidden);
    }
    seen
}

fn check(scenes: u64) {
    let seen = in_threads(0..scenes, |seed| check_scene(&mut Rng::new(0x0CC1_0000 + seed)));
    println!("{seen:?}");
    // Bounds for tiles are worth something.
    assert!(seen.found * 2 > seen.hidden && seen.found * 40 > seen.boxes, "{seen:?}");
    assert!(seen.found_beside * 2 > seen.boxes - seen.on_picture, "{seen:?}");
}

#[test]
fn what_is_said_to_be_hidden_is_hidden_at_every_pixel() {
    check(2_000);
}

#[test]
#[ignore = "long: a minute in release"]
fn what_is_said_to_be_hidden_is_hidden_at_every_pixel_of_many_scenes() {
    check(100_000);
}

/// The tiles do not depend on what draws them, so neither do the answers.
#[test]
fn the_same_answers_at_every_level_and_by_any_number_of_threads() {
    let mut rng = Rng::new(0x0CC2);
    let (mut places, mut faces) = (Vec::new(), Vec::new());
    for _ in 0..20 {
        occluders(&mut rng, &mut places, &mut faces);
    }
    let size = (317, 203);
    let (matrix, clip_space, depth) = camera(&mut rng, size);
    let vertices: Vec<_> = places.iter().map(|p| Vertex::new(matrix * p.extend(1.0), [])).collect();
    let boxes: Vec<_> = (0..400)
        .map(|_| {
            let (middle, half) = (vector(&mut rng, 3.0), vector(&mut rng, 0.3));
            [middle - half, middle + half]
        })
        .collect();
    let answers = |threads: usize, level| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let viewport = polyscan::Viewport::new(size.0, size.1).expect("a small one");
            let mut occlusion = OcclusionRenderer::new(viewport).expect("a small one");
            (occlusion.settings.clip_space, occlusion.settings.depth) = (clip_space, depth);
            occlusion.simd_level = level;
            occlusion.draw(Mesh::new(&vertices, &faces));
            boxes.iter().map(|&within| occlusion.is_hidden(matrix, within)).collect::<Vec<_>>()
        })
    };
    let expected = answers(1, polyscan::Level::new());
    assert!(expected.contains(&true) && expected.contains(&false));
    for threads in [2, 3, 7] {
        assert!(answers(threads, polyscan::Level::new()) == expected);
    }
    assert!(answers(1, polyscan::Level::baseline()) == expected);
}

#[test]
fn what_cannot_be_said_to_be_hidden_is_not() {
    let viewport = polyscan::Viewport::new(64, 64).expect("a small one");
    let mut occlusion = OcclusionRenderer::<0>::new(viewport).expect("a small one");
    let camera = directx::perspective(1.0, 1.0, 0.1, 100.0);
    let wall = |z: f32| {
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)]
            .map(|(x, y)| Vertex::new(camera * vec3(x, y, z).extend(1.0), []))
    };
    let at = |z: f32| [vec3(-0.1, -0.1, z - 0.1), vec3(0.1, 0.1, z + 0.1)];
    assert!(!occlusion.is_hidden(camera, at(-5.0)), "before there are occluders");
    occlusion.draw(&wall(-3.0));
    assert!(occlusion.is_hidden(camera, at(-5.0)));
    assert!(!occlusion.is_hidden(camera, at(-3.0)), "through the wall");
    assert!(!occlusion.is_hidden(camera, at(-2.0)));
    assert!(!occlusion.is_hidden(camera, at(0.0)), "around the eye");
    assert!(!occlusion.is_hidden(camera, [Vec3::splat(f32::NAN); 2]));
    assert!(!occlusion.is_hidden(Mat4::ZERO, at(-5.0)));
    assert!(!occlusion.is_hidden(camera, [Vec3::splat(f32::MIN), Vec3::splat(f32::MAX)]));
    // Beside the picture nothing is seen.
    assert!(occlusion.is_hidden(camera, at(-5.0).map(|corner| corner + Vec3::X * 50.0)));
    occlusion.clear();
    assert!(!occlusion.is_hidden(camera, at(-5.0)));
}
