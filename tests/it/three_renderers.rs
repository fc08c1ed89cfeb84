//! The same picture by all three renderers: the z-buffer's and the scanline renderer's to the bit;
//! the painter's as well, except where two surfaces cross within the pixel, by `common/crossing`, or
//! where one of them covers the pixel's centre by the rounding of its outline only: there it has a
//! depth but no place among the planes of the tree.
//!
//! `cargo test --profile proof --test it -- three_renderers:: --include-ignored --nocapture` runs the
//! long version and prints its figures.

use std::f32::consts::TAU;
use std::ops::Add;

use crate::common::crossing::{
    HEIGHT, Layer, Order, Scene, View, WIDTH, by_z_buffer, depths, direction, layer, order,
    random_scene, random_view, solids,
};
use crate::common::generators::{self, Rng};
use crate::common::oracle::{self, Position, Window};
use crate::common::{LONG_SEED, dynamic, in_threads, tally};
use glam::{Quat, Vec2, Vec3, Vec4};
use polyscan::{BspTree, ClipSpace, Framebuffer, PainterRenderer, ScanlineRenderer, Vertex};

const WINDOW: Window = Window { width: WIDTH, height: HEIGHT };
const GUARD: f64 = polyscan::viewport::GUARD_BAND as f64;

// ------------------------------------------------------------------------------------------ scenes

/// A simple outline in the unit circle, seldom convex.
fn concave(rng: &mut Rng) -> Vec<Vec2> {
    let turn = Vec2::from_angle(rng.range(0.0, TAU.into()) as f32);
    let outline: Vec<Vec2> = match rng.below(3) {
        0 => star(rng),
        1 => generators::comb(rng).iter().map(|p| Vec2::new(p[0] as f32, p[1] as f32)).collect(),
        _ => with_hole(&star(rng), rng.range(0.3, 0.9) as f32),
    };
    outline.into_iter().map(|p| turn.rotate(p)).collect()
}

/// A point in each of some directions, at any distance.
fn star(rng: &mut Rng) -> Vec<Vec2> {
    let corners = 4 + rng.below(12);
    let angle = |i| TAU * i as f32 / corners as f32;
    (0..corners).map(|i| Vec2::from_angle(angle(i)) * rng.range(0.2, 1.0) as f32).collect()
}

/// A face is one contour. This one goes along an edge to the hole, around it in the other direction,
/// and back along the same edge.
fn with_hole(outer: &[Vec2], size: f32) -> Vec<Vec2> {
    let hole = || outer.iter().map(|&p| p * size);
    let first = || outer.iter().take(1).copied();
    outer.iter().copied().chain(first()).chain(hole().take(1)).chain(hole().rev()).collect()
}

/// Concave faces, some with holes, and a few triangles, through each other.
fn concave_scene(rng: &mut Rng) -> Scene {
    let mut scene = Scene::default();
    for _ in 0..2 + rng.below(7) {
        let outline =
            if rng.once_in(4) { vec![Vec2::X, Vec2::Y, -Vec2::ONE] } else { concave(rng) };
        let turn = Quat::from_rotation_arc(Vec3::Z, direction(rng));
        let (centre, size) = (direction(rng) * rng.range(0.0, 0.6) as f32, rng.octaves(0.3, 1.5));
        let place = |p: Vec2| centre + turn * (p * size as f32).extend(0.0);
        scene.add(outline.into_iter().map(place), rng);
    }
    scene
}

// -------------------------------------------------------------------------------------- comparison

tally! {
    /// What was compared.
    struct Tally {
        scenes: u64,
        faces: u64,
        /// Faces and parts of faces that the painter drew.
        pieces: u64,
        /// Covered pixels.
        pixels: u64,
        /// Pixels where the painter shows another face than the others do, since the two cross there.
        crossing: u64,
        /// The same, since one of the two has an edge at the pixel's centre.
        at_edge: u64,
    }
}

impl Tally {
    fn differing(&self) -> u64 {
        self.crossing + self.at_edge
    }
}

fn by_scanline(scene: &Scene, vertices: &[Vertex<2>], view: &View) -> Framebuffer<Option<Layer>> {
    let mut frame = view.frame();
    let mut renderer = ScanlineRenderer::new(frame.viewport());
    renderer.settings.clip_space = view.clip_space;
    renderer.settings.depth = view.depth_mode();
    renderer.draw(
        &mut frame,
        polyscan::Mesh::new(vertices, &scene.faces),
        dynamic(|f| Some(Some(layer(f)))),
    );
    frame
}

fn by_painter(tree: &BspTree<2>, view: &View) -> Framebuffer<Option<Layer>> {
    let mut frame = view.frame();
    let mut painter = PainterRenderer::new(frame.viewport());
    painter.settings.clip_space = view.clip_space;
    painter.settings.depth = view.depth_mode();
    painter.depth_write = true;
    painter.draw(&mut frame, tree.seen_by(view.matrix), dynamic(|f| Some(Some(layer(f)))));
    frame
}

/// How far, in pixels, the centre of a pixel is outside a face that is not rounded. Faces that this
/// is asked of are convex.
fn outside(contour: &[Vec4], view: &View, (x, y): (usize, usize)) -> f64 {
    let depth = match view.clip_space {
        ClipSpace::ZeroToOne => oracle::Depth::ZeroToOne,
        ClipSpace::MinusOneToOne => oracle::Depth::MinusOneToOne,
    };
    let positions: Vec<Position> = contour.iter().map(|&p| p.into()).collect();
    let outline = oracle::unrounded_outline(&positions, WINDOW, depth, GUARD);
    oracle::distance_outside(&outline, [x as f64 + 0.5, y as f64 + 0.5])
}

/// Draws a scene by all three.
fn check(scene: &Scene, tree: &BspTree<2>, view: &View, seed: u64) -> Tally {
    assert!(tree.is_exact());
    let vertices = scene.in_clip_space(view);
    let expected = by_z_buffer(scene, &vertices, view);
    assert!(by_scanline(scene, &vertices, view) == expected, "scanline, seed {seed}: {view:?}");
    let painted = by_painter(tree, view);
    let depths = depths(scene, &vertices, view);
    let mut tally = Tally {
        scenes: 1,
        faces: scene.faces.len() as u64,
        pieces: tree.pieces() as u64,
        ..Tally::default()
    };
    for (pixel, (seen, expected)) in painted.color().iter().zip(expected.color()).enumerate() {
        tally.pixels += u64::from(expected.is_some());
        if seen == expected {
            continue;
        }
        let at = (pixel % WIDTH as usize, pixel / WIDTH as usize);
        let Some((a, b)) = seen.as_ref().zip(expected.as_ref()) else {
            panic!("painter, seed {seed}, {at:?}: {seen:?} for {expected:?}");
        };
        let [depth_a, depth_b] = [a, b].map(|layer| &depths[layer.face as usize]);
        if order(depth_a, depth_b, pixel) == Order::Crossing {
            tally.crossing += 1;
            continue;
        }
        let distance = [a, b]
            .map(|layer| {
                let face = &scene.faces[layer.face as usize];
                let contour: Vec<_> = face.iter().map(|&i| vertices[i as usize].position).collect();
                outside(&contour, view, at)
            })
            .into_iter()
            .fold(0.0, f64::max);
        assert!(distance > 0.0, "painter, seed {seed}, {at:?}: {a:?} for {b:?}, {view:?}");
        tally.at_edge += 1;
    }
    // Depth of what is seen, and of nothing, as the z-buffer has it.
    let depth = |frame: &Framebuffer<_>| frame.depth().iter().map(|d| d.to_bits()).collect();
    let (a, b): (Vec<u32>, Vec<u32>) = (depth(&painted), depth(&expected));
    let differing = a.iter().zip(&b).filter(|(a, b)| a != b).count() as u64;
    assert!(differing <= tally.differing(), "depths, seed {seed}: {view:?}");
    tally
}

struct Kind {
    name: &'static str,
    scene: fn(&mut Rng) -> Scene,
    /// Scenes of this kind in a hundred.
    share: u64,
}

const KINDS: [Kind; 3] = [
    Kind { name: "triangles and flat polygons", scene: random_scene, share: 50 },
    Kind { name: "concave faces", scene: concave_scene, share: 40 },
    Kind { name: "solids", scene: solids, share: 10 },
];

fn check_kinds(first_seed: u64, hundreds: u64) -> Tally {
    let tallies = KINDS.map(|Kind { name, scene, share }| {
        let tally = in_threads(first_seed..first_seed + hundreds * share, |seed| {
            let rng = &mut Rng::new(seed);
            let scene = scene(rng);
            let tree = BspTree::new(&scene.vertices, &scene.faces);
            check(&scene, &tree, &random_view(rng), seed)
        });
        println!("three renderers, {name}: {tally:?}");
        tally
    });
    tallies.into_iter().fold(Tally::default(), Add::add)
}

#[test]
fn all_three_draw_the_same_picture() {
    let tally = check_kinds(0, 4);
    assert!(tally.pixels > 200_000, "{tally:?}");
    assert!(tally.differing() * 10_000 < tally.pixels, "{tally:?}");
}

#[test]
#[ignore = "long: minutes in release"]
fn long_all_three_draw_the_same_picture() {
    let tally = check_kinds(LONG_SEED, 300);
    println!("three renderers: {tally:?}");
    assert!(tally.differing() * 10_000 < tally.pixels);
}

// --------------------------------------------------------------------------------------- OBJ files

#[cfg(feature = "obj")]
mod obj_files {
    use std::fmt::Write as _;

    use crate::common::oracle::Depth;
    use glam::camera::rh::proj::directx::perspective;
    use glam::camera::rh::view::look_at_mat4;
    use glam::{Mat4, vec3};
    use polyscan::FillRule;
    use polyscan::Model;

    use super::*;

    /// A file of concave faces, one behind the other in planes of constant z, in any order; and how
    /// many corners each has.
    fn text(rng: &mut Rng) -> (String, Vec<usize>) {
        let mut levels: Vec<i32> = (0..5).collect();
        rng.shuffle(&mut levels);
        let (mut text, mut sides) = (String::new(), Vec::new());
        for level in levels {
            let z = 0.2 * level as f32 - 0.4;
            let outline = concave(rng);
            for p in &outline {
                writeln!(text, "v {} {} {z}", 1.3 * p.x, 1.3 * p.y).expect("a string grows");
            }
            let corner = |i: usize| format!(" -{}", outline.len() - i);
            let corners: String = (0..outline.len()).map(corner).collect();
            writeln!(text, "f{corners}").expect("a string grows");
            sides.push(outline.len());
        }
        (text, sides)
    }

    fn load(text: &str) -> Model {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("faces.obj");
        std::fs::write(&path, text).expect("a file");
        let loaded = Model::load(&path).expect("a model");
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded.model
    }

    /// An eye before or behind all planes, and a near plane that is before everything or cuts.
    fn view(rng: &mut Rng) -> (View, bool) {
        let is_before = rng.once_in(2);
        let z = rng.range(0.8, 3.0) as f32 * if is_before { 1.0 } else { -1.0 };
        let eye = vec3(rng.range(-1.0, 1.0) as f32, rng.range(-1.0, 1.0) as f32, z);
        let near = if rng.once_in(2) { 0.05 } else { eye.length() * rng.range(0.4, 1.1) as f32 };
        let camera = look_at_mat4(eye, Vec3::ZERO, Vec3::Y);
        let matrix: Mat4 = perspective(0.9, WIDTH as f32 / HEIGHT as f32, near, 9.0) * camera;
        (View { matrix, clip_space: ClipSpace::ZeroToOne, reversed: false }, is_before)
    }

    /// The number of the face that is seen at each pixel, by exact coverage and the order of the
    /// planes.
    fn expected(scene: &Scene, vertices: &[Vertex<2>], is_before: bool) -> Vec<Option<u32>> {
        let mut order: Vec<usize> = (0..scene.faces.len()).collect();
        let z = |face: &usize| scene.vertices[scene.faces[*face][0] as usize].position.z;
        order.sort_by(|a, b| z(a).total_cmp(&z(b)));
        if !is_before {
            order.reverse();
        }
        let mut seen = vec![None; (WIDTH * HEIGHT) as usize];
        // From the farthest to the nearest.
        for face in order {
            let corner = |&i: &u32| Position::from(vertices[i as usize].position);
            let contour = scene.faces[face].iter().map(corner).collect();
            let border = oracle::border(&[contour], WINDOW, Depth::ZeroToOne, GUARD, &[]);
            let mask = oracle::fill_border(&border, WINDOW, oracle::FillRule::NonZero);
            for (x, y) in mask.pixels() {
                seen[(y * WIDTH + x) as usize] = Some(face as u32);
            }
        }
        seen
    }

    #[test]
    fn concave_faces_of_an_obj_file_are_exact_by_all_three() {
        assert_eq!(FillRule::default(), FillRule::NonZero);
        let (mut covered, mut cut) = (0, 0);
        for seed in 0..120 {
            let rng = &mut Rng::new(seed);
            let (text, sides) = text(rng);
            let model = load(&text);
            let vertex =
                |v: &polyscan::model::ModelVertex| Vertex::new(v.position.extend(1.0), v.uv);
            let scene = Scene {
                vertices: model.vertices.iter().map(vertex).collect(),
                faces: model.faces().map(|face| face.indices.to_vec()).collect(),
            };
            assert!(scene.faces.iter().map(Vec::len).eq(sides), "faces keep their sides");

            let (view, is_before) = view(rng);
            let vertices = scene.in_clip_space(&view);
            let expected = expected(&scene, &vertices, is_before);
            let tree = BspTree::new(&scene.vertices, &scene.faces);
            let pictures = [
                ("z-buffer", by_z_buffer(&scene, &vertices, &view)),
                ("scanline", by_scanline(&scene, &vertices, &view)),
                ("painter", by_painter(&tree, &view)),
            ];
            for (name, picture) in pictures {
                let seen = picture.color().iter().map(|layer| layer.map(|layer| layer.face));
                assert!(seen.eq(expected.iter().copied()), "{name}, seed {seed}: {view:?}\n{text}");
            }
            covered += expected.iter().flatten().count();
            cut += usize::from(vertices.iter().any(|v| v.position.z < 0.0));
        }
        assert!(covered > 60_000 && cut > 20, "{covered} pixels, {cut} scenes cut");
    }
}
