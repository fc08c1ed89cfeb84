//! Fronts and backs: `front_facing` is the orientation on the screen, and culling leaves out exactly
//! the faces that show the side named.
//!
//! The oracle is a determinant: the part in front of the eye of a triangle with corners (x, y, w) is
//! seen counter-clockwise where theirs is positive, clipped or not.

use crate::common::generators::{self, Rng, Shape};
use crate::common::oracle::Window;
use crate::common::{dynamic, dynamic_blocks, vertices, viewport};
use glam::{DVec3, Mat4, Vec4Swizzles, vec4};
use polyscan::render::Geometry;
use polyscan::{
    BspTree, Cull, Fragment, Framebuffer, FrontFace, Level, Mesh, PainterRenderer, ScanConverter,
    ScanlineRenderer, Settings, Vertex, ZBufferRenderer,
};

const WINDOW: Window = Window { width: 70, height: 50 };
const FRONTS: [FrontFace; 2] = [FrontFace::CounterClockwise, FrontFace::Clockwise];

/// The determinant of the widest triangle of a flat convex polygon's corners, as a part of their
/// lengths.
fn turn(polygon: &[Vertex<1>]) -> f64 {
    let rays: Vec<DVec3> =
        polygon.iter().map(|v| v.position.xyww().truncate().as_dvec3()).collect();
    let determinant = |i: usize, j: usize, k: usize| {
        let size = rays[i].length() * rays[j].length() * rays[k].length();
        rays[i].cross(rays[j]).dot(rays[k]) / size.max(1e-300)
    };
    let mut widest = 0.0f64;
    for k in 2..rays.len() {
        for j in 1..k {
            let found = determinant(0, j, k);
            widest = if found.abs() > widest.abs() { found } else { widest };
        }
    }
    widest
}

fn is_front(polygon: &[Vertex<1>], front: FrontFace) -> bool {
    (turn(polygon) > 0.0) == (front == FrontFace::CounterClockwise)
}

/// Flat convex polygons in either direction, some through the eye; none seen nearly edge-on.
fn any_polygon(rng: &mut Rng, most_sides: usize) -> Vec<Vertex<1>> {
    loop {
        let w_ratio = rng.octaves(1.0, 50.0);
        let sides = 3 + rng.below(most_sides - 2);
        let shape: Shape<1> = match rng.below(3) {
            0 => generators::random_triangle(rng, w_ratio, 1.5),
            1 => generators::random_convex(rng, sides, w_ratio),
            _ => generators::through_eye(rng, sides),
        };
        let mut polygon = vertices(&shape);
        if rng.once_in(2) {
            polygon.reverse();
        }
        if turn(&polygon).abs() > 1e-3 {
            return polygon;
        }
    }
}

#[test]
fn fragments_and_blocks_know_which_side_is_seen() {
    let (mut fronts, mut backs) = (0, 0);
    for seed in 0..3000 {
        let rng = &mut Rng::new(seed);
        let polygon = any_polygon(rng, 8);
        let mut scan = ScanConverter::new(viewport(WINDOW));
        for front in FRONTS {
            scan.settings.front_face = front;
            let expected = is_front(&polygon, front);
            for span in scan.spans(&polygon) {
                for fragment in span.fragments() {
                    assert_eq!(fragment.front_facing, expected, "seed {seed}, {front:?}");
                    *(if expected { &mut fronts } else { &mut backs }) += 1;
                }
                span.for_each_block(Level::new(), |block| {
                    assert_eq!(block.front_facing, expected, "seed {seed}, {front:?}");
                    assert_eq!(block.fragment(0).front_facing, expected);
                });
            }
        }
    }
    assert!(fronts > 100_000 && backs > 100_000, "{fronts} and {backs} pixels");
}

#[test]
fn culling_leaves_out_the_polygons_of_one_side() {
    for seed in 0..1500 {
        let rng = &mut Rng::new(seed);
        let polygon = any_polygon(rng, 8);
        let spans = |settings: &Settings<1>| -> Vec<_> {
            let mut scan = ScanConverter::new(settings.viewport);
            scan.settings = settings.clone();
            scan.spans(&polygon).map(|span| (span.row(), span.columns())).collect()
        };
        let mut settings = Settings::new(viewport(WINDOW));
        let whole = spans(&settings);
        for front in FRONTS {
            settings.front_face = front;
            for (cull, is_culled) in [
                (Cull::None, false),
                (Cull::Front, is_front(&polygon, front)),
                (Cull::Back, !is_front(&polygon, front)),
            ] {
                settings.cull = cull;
                let expected = if is_culled { &[][..] } else { &whole };
                assert_eq!(spans(&settings), expected, "seed {seed}, {front:?}, {cull:?}");
            }
        }
    }
}

/// A contour that is larger than the others decides for all.
#[test]
fn of_several_contours_the_sum_of_areas_decides() {
    let square = |size: f32, x: f32| {
        [(-size, -size), (size, -size), (size, size), (-size, size)]
            .map(|(dx, dy)| Vertex::new(vec4(x + dx, dy, 0.5, 1.0), []))
    };
    let mut hole = square(0.4, 0.0);
    hole.reverse();
    let mut scan = ScanConverter::new(viewport(WINDOW));
    let mut seen = |outline: &[[Vertex<0>; 4]]| -> Vec<bool> {
        let mut sides: Vec<bool> = Vec::new();
        for span in scan.spans(outline) {
            sides.extend(span.fragments().map(|fragment| fragment.front_facing));
        }
        sides.dedup();
        sides
    };
    assert_eq!(seen(&[square(0.8, 0.0), hole]), [true]);
    assert_eq!(seen(&[hole, square(0.8, 0.0)]), [true], "whichever comes first");
    assert_eq!(seen(&[hole, square(0.2, 0.7)]), [false], "an island of the other direction");
    let mut around = square(0.8, 0.0);
    around.reverse();
    hole.reverse();
    assert_eq!(seen(&[around, hole]), [false]);
}

// ---------------------------------------------------------------------------------------- renderers

/// A fragment's face and whether its front is seen.
type Seen = Option<(u32, bool)>;

/// Faces as one mesh, each with its own vertices.
struct Faces {
    vertices: Vec<Vertex<1>>,
    faces: Vec<Vec<u32>>,
    fronts: Vec<bool>,
}

fn faces(rng: &mut Rng, count: usize, most_sides: usize) -> Faces {
    let mut all = Faces { vertices: Vec::new(), faces: Vec::new(), fronts: Vec::new() };
    for _ in 0..count {
        let polygon = any_polygon(rng, most_sides);
        let first = all.vertices.len() as u32;
        all.faces.push((first..first + polygon.len() as u32).collect());
        all.fronts.push(is_front(&polygon, FrontFace::CounterClockwise));
        all.vertices.extend(polygon);
    }
    all
}

/// A picture by one of the renderers, by fragments and by blocks, which have to be the same.
fn picture(
    renderer: usize,
    settings: &Settings<1>,
    geometry: impl Geometry<1> + Copy,
) -> Vec<Seen> {
    macro_rules! pictures {
        ($renderer:ident) => {{
            let mut renderer = $renderer::new(settings.viewport);
            renderer.settings = settings.clone();
            let mut frame = Framebuffer::new(WINDOW.width, WINDOW.height, None).expect("small");
            let seen = |f: &Fragment<'_, 1>| Some(Some((f.face, f.front_facing)));
            renderer.draw(&mut frame, geometry, dynamic(seen));
            let by_fragment = frame.color().to_vec();
            renderer.clear(&mut frame, None);
            renderer.draw_blocks(
                &mut frame,
                geometry,
                dynamic_blocks(|block, colors| {
                    colors.fill(Some((block.face, block.front_facing)));
                }),
            );
            assert!(frame.color() == by_fragment, "blocks");
            by_fragment
        }};
    }
    match renderer {
        0 => pictures!(ZBufferRenderer),
        1 => pictures!(ScanlineRenderer),
        _ => pictures!(PainterRenderer),
    }
}

/// Checks that with culling the picture is that of the faces that are left, and that each fragment
/// knows its side.
fn check_mesh(all: &Faces, name: &str) -> usize {
    let mut settings = Settings::new(viewport(WINDOW));
    let mut pixels = 0;
    for (front, cull, renderer) in FRONTS
        .into_iter()
        .flat_map(|front| [Cull::None, Cull::Front, Cull::Back].map(|cull| (front, cull)))
        .flat_map(|(front, cull)| [0, 1, 2].map(|renderer| (front, cull, renderer)))
    {
        let shows_front = |face: usize| all.fronts[face] == (front == FrontFace::CounterClockwise);
        let is_left = |face: &usize| match cull {
            Cull::None => true,
            Cull::Front => !shows_front(*face),
            Cull::Back => shows_front(*face),
        };
        let left: Vec<usize> = (0..all.faces.len()).filter(is_left).collect();
        settings.front_face = front;
        settings.cull = cull;
        let found = picture(renderer, &settings, Mesh::new(&all.vertices, &all.faces));
        settings.cull = Cull::None;
        let faces: Vec<_> = left.iter().map(|&face| all.faces[face].clone()).collect();
        let expected = picture(renderer, &settings, Mesh::new(&all.vertices, &faces));
        let what = format!("{name}, {front:?}, {cull:?}, renderer {renderer}");
        for (pixel, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let expected = expected.map(|(face, side)| (left[face as usize] as u32, side));
            // The painter's trees differ with the faces, and so the order where faces cross.
            if renderer < 2 {
                assert_eq!(*found, expected, "pixel {pixel}: {what}");
            }
            assert_eq!(found.is_some(), expected.is_some(), "pixel {pixel}: {what}");
            let Some((face, side)) = *found else { continue };
            assert!(is_left(&(face as usize)), "face {face} at pixel {pixel}: {what}");
            assert_eq!(side, shows_front(face as usize), "side at pixel {pixel}: {what}");
            pixels += 1;
        }
    }
    pixels
}

#[test]
fn meshes_leave_out_the_faces_of_one_side() {
    let mut pixels = 0;
    for seed in 0..40 {
        let rng = &mut Rng::new(seed);
        // Triangles alone are set up eight at a time.
        let most_sides = if seed % 2 == 0 { 3 } else { 7 };
        pixels += check_mesh(&faces(rng, 41, most_sides), &format!("seed {seed}"));
    }
    assert!(pixels > 500_000, "{pixels} pixels");
}

#[test]
fn trees_know_the_sides_of_their_faces() {
    let mut pixels = 0;
    for seed in 0..20 {
        let rng = &mut Rng::new(seed);
        let all = faces(rng, 20, 5);
        let tree = BspTree::new(&all.vertices, &all.faces);
        let mut settings = Settings::new(viewport(WINDOW));
        settings.cull = [Cull::None, Cull::Front, Cull::Back][seed as usize % 3];
        // A mirror turns all of them around.
        for (matrix, mirrored) in [(Mat4::IDENTITY, false), (MIRROR, true)] {
            for renderer in 0..3 {
                for (face, side) in
                    picture(renderer, &settings, tree.seen_by(matrix)).into_iter().flatten()
                {
                    assert_eq!(side, all.fronts[face as usize] != mirrored, "seed {seed}");
                    assert_ne!(settings.cull, if side { Cull::Front } else { Cull::Back });
                    pixels += 1;
                }
            }
        }
    }
    assert!(pixels > 50_000, "{pixels} pixels");
}

const MIRROR: Mat4 = Mat4::from_cols(
    vec4(-1.0, 0.0, 0.0, 0.0),
    vec4(0.0, 1.0, 0.0, 0.0),
    vec4(0.0, 0.0, 1.0, 0.0),
    vec4(0.0, 0.0, 0.0, 1.0),
);
