//! A mesh of more faces and vertices than are handed to a thread at a time (4,096 of each): by any
//! number of threads it is drawn as its faces are one by one, in their order and with their numbers.

use crate::common::generators::Rng;
use glam::{Vec4, vec4};
use polyscan::{ClipPlane, DepthTest, Fragment, Framebuffer, Vertex, Viewport, ZBufferRenderer};

const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;
const FACES: usize = 10_000;
/// Faces that are handed to a thread at a time.
const CHUNK: usize = 4096;

/// Which faces a mesh has.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// All of three corners.
    Triangles,
    /// Quads, concave polygons, and faces that cannot be drawn, too.
    Mixed,
}

struct Mesh {
    vertices: Vec<Vertex<2>>,
    faces: Vec<Vec<u32>>,
    concave: usize,
    /// Faces with a part behind the near plane, behind the eye, or behind the plane of the user.
    clipped: usize,
}

/// What cuts all meshes here, besides the view volume.
const PLANE: Vec4 = vec4(-0.8, 0.3, 0.0, 0.7);

/// Small faces all over the view and a little beyond, at any depth. Some of the first are large; later
/// they would hide too much.
fn mesh(kind: Kind) -> Mesh {
    let rng = &mut Rng::new(10_000);
    let mut mesh = Mesh { vertices: Vec::new(), faces: Vec::new(), concave: 0, clipped: 0 };
    for number in 0..FACES {
        let first = mesh.vertices.len() as u32;
        let is_large = number < 500 && rng.once_in(10);
        if rng.once_in(40) && number > 0 {
            // One that was there before, whether nearer or not: the order tells which is seen.
            mesh.faces.push(mesh.faces[rng.below(number)].clone());
            continue;
        }
        if is_large && first > 0 && rng.once_in(2) {
            // Corners of other faces, from anywhere in the list.
            mesh.faces.push((0..3).map(|_| rng.below(first as usize) as u32).collect());
            continue;
        }
        let (corners, dent) = match (kind, rng.below(20)) {
            (Kind::Triangles, _) | (Kind::Mixed, 0..9) => (3, 1.0),
            (Kind::Mixed, 9..16) => (4, 1.0),
            (Kind::Mixed, 16..18) => (5 + rng.below(6), 1.0),
            (Kind::Mixed, _) => (6 + 2 * rng.below(4), 0.4),
        };
        mesh.concave += usize::from(dent < 1.0);
        let centre = [0; 2].map(|_| rng.range(-1.2, 1.2));
        let (size, start) = (rng.octaves(0.004, 0.06), rng.range(0.0, 6.3));
        let (w, z) = (rng.octaves(1.0, 8.0), rng.range(-0.05, 1.0));
        let [dz, dw] = [0; 2].map(|_| rng.range(-0.3, 0.3));
        // The large ones reach behind the eye.
        let dw = if is_large { 2.0 * w } else { dw };
        for corner in 0..corners {
            let angle = start + corner as f64 * std::f64::consts::TAU / corners as f64;
            let radius = if corner % 2 == 0 { size } else { size * dent };
            let [x, y] = [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()];
            let (z, w) = (z * w + dz * angle.cos(), w + dw * angle.sin());
            let position = [x * w, y * w, z, w].map(|coordinate| coordinate as f32);
            mesh.vertices.push(Vertex::new(position.into(), [x as f32, number as f32]));
        }
        let mut face: Vec<u32> = (first..mesh.vertices.len() as u32).collect();
        if rng.once_in(2) {
            face.reverse();
        }
        match rng.below(100) {
            0 if kind == Kind::Mixed => face.truncate(2),
            1 => face[0] = u32::MAX,
            _ => {}
        }
        mesh.faces.push(face);
    }
    let is_cut = |face: &Vec<u32>| {
        let outside = |&i: &u32| {
            let position = mesh.vertices.get(i as usize).map(|v| v.position);
            position.is_some_and(|p| p.z < 0.0 || p.w < 0.0 || PLANE.dot(p) < 0.0)
        };
        face.iter().any(outside) && !face.iter().all(outside)
    };
    mesh.clipped = mesh.faces.iter().filter(|&face| is_cut(face)).count();
    mesh
}

/// What is known of a pixel: the face, and the bits of w and the parameters.
type Told = (u32, u32, [u32; 2]);
const NOTHING: Told = (u32::MAX, 0, [0; 2]);

fn told(face: u32, f: &Fragment<'_, 2>) -> Told {
    (face, f.w.to_bits(), f.params.map(f32::to_bits))
}

fn renderer(depth_test: DepthTest) -> ZBufferRenderer<2> {
    let mut renderer = ZBufferRenderer::new(Viewport::new(WIDTH, HEIGHT).expect("small"));
    renderer.settings.planes = vec![ClipPlane::new(PLANE)];
    renderer.depth_test = depth_test;
    renderer
}

fn frame() -> Framebuffer<Told> {
    Framebuffer::new(WIDTH, HEIGHT, NOTHING).expect("a small frame")
}

/// The picture, each face drawn as a polygon of its own.
fn one_by_one(mesh: &Mesh, depth_test: DepthTest) -> Framebuffer<Told> {
    let (mut frame, mut renderer) = (frame(), renderer(depth_test));
    for (number, face) in (0..).zip(&mesh.faces) {
        let corner = |&i: &u32| mesh.vertices.get(i as usize).copied();
        // A face with a corner that does not exist is not drawn.
        let polygon: Option<Vec<_>> = face.iter().map(corner).collect();
        if let Some(polygon) = polygon {
            renderer.draw(&mut frame, &polygon, |f| told(number, f));
        }
    }
    frame
}

/// Holds a picture against the one that is expected, to the bit.
fn check(found: &Framebuffer<Told>, expected: &Framebuffer<Told>, name: &str) {
    let depths = |frame: &Framebuffer<Told>| -> Vec<u32> {
        frame.depth().iter().map(|depth| depth.to_bits()).collect()
    };
    let mut pixels = found.color().iter().zip(expected.color()).enumerate();
    let different = pixels.find(|(_, (found, expected))| found != expected);
    assert_eq!(different, None, "{name}: the first pixel that differs");
    assert!(depths(found) == depths(expected), "{name}: depths");
}

fn draw_by_threads(kind: Kind) {
    let mesh = mesh(kind);
    assert!(mesh.faces.len() == FACES && mesh.vertices.len() > 7 * CHUNK, "several parts of each");
    assert!(mesh.clipped > 800, "{} faces are clipped", mesh.clipped);
    assert!(kind == Kind::Triangles || mesh.concave > 500, "{} are concave", mesh.concave);
    // By the first test the order decides between equal depths, by the second between all.
    for depth_test in [DepthTest::Nearer, DepthTest::Always] {
        let expected = one_by_one(&mesh, depth_test);
        let mut seen: Vec<u32> = expected.color().iter().map(|told| told.0).collect();
        seen.sort_unstable();
        seen.dedup();
        for chunk in 0..FACES.div_ceil(CHUNK) {
            let seen = seen.iter().filter(|&&face| face as usize / CHUNK == chunk).count();
            assert!(seen > 100, "{kind:?}, {depth_test:?}: {seen} faces of chunk {chunk} are seen");
        }
        for threads in [1, 2, 3, 7] {
            let name = format!("{kind:?}, {depth_test:?}, {threads} threads");
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a few threads").install(|| {
                let (mut frame, mut renderer) = (frame(), renderer(depth_test));
                let Mesh { vertices, faces, .. } = &mesh;
                renderer
                    .draw(&mut frame, polyscan::Mesh::new(vertices, faces), |f| told(f.face, f));
                check(&frame, &expected, &name);
                // Again by the same renderer, whose memory has been used, and by blocks.
                frame.clear(NOTHING, 1.0);
                renderer.draw_blocks(
                    &mut frame,
                    polyscan::Mesh::new(vertices, faces),
                    |block, colors| {
                        for lane in (0..colors.len()).filter(|lane| block.visible >> lane & 1 != 0)
                        {
                            colors[lane] = told(block.face, &block.fragment(lane));
                        }
                    },
                );
                check(&frame, &expected, &format!("{name}, by blocks"));
            });
        }
    }
}

/// Large faces all over a wide view, each on a plane of its own, so that most cross: what a mesh leaves out
/// since something nearer is known to be there is nowhere seen.
#[test]
fn wide_layers_that_cross_hide_each_other_as_when_they_are_drawn_one_by_one() {
    let rng = &mut Rng::new(64);
    for (width, height) in [(900, 70), (4500, 64), (270, 33)] {
        let viewport = Viewport::new(width, height).expect("small");
        for depth_test in [DepthTest::Nearer, DepthTest::NearerOrEqual] {
            let (mut vertices, mut faces) = (Vec::new(), Vec::new());
            for number in 0..400 {
                // Later ones lie farther, but for some.
                let middle = 0.2 * rng.range(0.0, 1.0) + f64::from(number) / 600.0;
                let slopes = [0; 2].map(|_| rng.octaves(0.001, 0.3) * rng.range(-1.0, 1.0));
                let corners = 3 + rng.below(3);
                let start = rng.range(0.0, 6.3);
                let (height, moved) = (rng.octaves(0.1, 2.0), rng.range(-0.8, 0.8));
                let first = vertices.len() as u32;
                for corner in 0..corners {
                    let turn = start + std::f64::consts::TAU / corners as f64 * corner as f64;
                    let [x, y] = [1.6 * turn.cos(), height * turn.sin() + moved];
                    let z = (middle + slopes[0] * x + slopes[1] * y).clamp(0.0, 1.0);
                    let w = rng.range(1.0, 1.5);
                    let position = vec4((x * w) as f32, (y * w) as f32, (z * w) as f32, w as f32);
                    vertices.push(Vertex::new(position, [x as f32, y as f32]));
                }
                faces.push((first..first + corners as u32).collect::<Vec<u32>>());
            }
            let new = || {
                let frame = Framebuffer::new(width, height, NOTHING).expect("a small frame");
                let mut renderer = ZBufferRenderer::new(viewport);
                renderer.depth_test = depth_test;
                (frame, renderer)
            };
            let (mut expected, mut renderer) = new();
            for (number, face) in (0..).zip(&faces) {
                let polygon: Vec<_> = face.iter().map(|&i| vertices[i as usize]).collect();
                renderer.draw(&mut expected, &polygon, |f| told(number, f));
            }
            let (mut found, mut renderer) = new();
            renderer.draw(&mut found, polyscan::Mesh::new(&vertices, &faces), |f| told(f.face, f));
            check(&found, &expected, &format!("{width} x {height}, {depth_test:?}"));
        }
    }
}

#[test]
fn a_mesh_of_10_000_triangles_is_drawn_as_its_faces_one_by_one() {
    draw_by_threads(Kind::Triangles);
}

#[test]
fn a_mesh_of_10_000_faces_of_all_kinds_is_drawn_as_its_faces_one_by_one() {
    draw_by_threads(Kind::Mixed);
}
