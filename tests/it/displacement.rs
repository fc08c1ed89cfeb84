//! Displacement mapping: where diced faces are moved to, against f64; that they meet; how large they are; any input.

use std::collections::HashMap;

use glam::camera::rh::proj::directx::perspective;
use glam::camera::rh::view::look_at_mat4;
use glam::{DVec2, DVec3, Mat4, Vec2, Vec3, Vec4, dvec2, vec2, vec3};
use polyscan::model::{Face, Material, Model};
use polyscan::texture::{Texture, Wrap};
use polyscan::{Camera, Viewport};

use crate::common::generators::Rng;

/// The model of an OBJ text, whose material `a`, if it has one, has a picture of heights.
fn model(text: &str, heights: Texture) -> Model {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.obj");
    std::fs::write(&path, format!("mtllib m.mtl\n{text}")).expect("a file");
    std::fs::write(folder.path().join("m.mtl"), "newmtl plain\nnewmtl a\n").expect("a file");
    let mut model = Model::load(&path).expect("a model").model;
    model.textures.push(heights);
    let index = Some(model.textures.len() - 1);
    for material in model.materials.iter_mut().filter(|material| material.name == "a") {
        material.displacement_texture = index;
    }
    model
}

fn constant(height: f32) -> Texture {
    Texture::from_fn(1, 1, |_, _| Vec4::splat(height)).expect("a texel")
}

fn noise(side: u32, seed: u64) -> Texture {
    let mut rng = Rng::new(seed);
    let texels: Vec<_> = (0..side * side).map(|_| rng.range(-0.1, 0.2) as f32).collect();
    Texture::from_fn(side, side, |x, y| Vec4::splat(texels[(y * side + x) as usize]))
        .expect("texels")
}

fn viewport(width: u32, height: u32) -> Viewport {
    Viewport::new(width, height).expect("a size")
}

/// The whole model in a square picture of so many pixels a side.
fn seen_whole(model: &Model, side: u32) -> (Mat4, Viewport) {
    let camera: Camera = model.camera(1.0).turned(0.5, 0.3);
    (camera.clip_from_object(), viewport(side, side))
}

/// Triangles in a square of `side` x `side` cells that is bent, with normals that are not those of the surface, and texture
/// coordinates from 0 to 1.
fn sheet(side: usize) -> String {
    let mut text = String::new();
    for y in 0..=side {
        for x in 0..=side {
            let (u, v) = (x as f32 / side as f32, y as f32 / side as f32);
            let (sine, wave) = ((5.0 * u).sin(), (4.0 * v).cos());
            text += &format!("v {} {} {}\nvt {u} {v}\n", 2.0 * u, 2.0 * v, 0.2 * sine * wave);
            text += &format!("vn {} {} {}\n", 0.4 * sine, 0.3 * wave, 1.0 + 0.1 * u);
        }
    }
    text += "usemtl a\n";
    for y in 0..side {
        for x in 0..side {
            let at = |x: usize, y: usize| {
                let i = 1 + y * (side + 1) + x;
                format!("{i}/{i}/{i}")
            };
            let (a, b, c, d) = (at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    text
}

/// The mean of four texels in f64, of a picture that repeats.
fn bilinear(texture: &Texture, uv: DVec2) -> f64 {
    let (width, height) = (i64::from(texture.width()), i64::from(texture.height()));
    let at = uv * dvec2(width as f64, height as f64) - 0.5;
    let (corner, part) = (at.floor(), at - at.floor());
    let texel = |x: i64, y: i64| {
        let (x, y) = (corner.x as i64 + x, corner.y as i64 + y);
        f64::from(texture.texel(x.rem_euclid(width) as u32, y.rem_euclid(height) as u32).x)
    };
    let row = |y: i64| texel(0, y) * (1.0 - part.x) + texel(1, y) * part.x;
    row(0) * (1.0 - part.y) + row(1) * part.y
}

/// The weights of a triangle's corners at a texture coordinate.
fn weights(uv: [DVec2; 3], at: DVec2) -> [f64; 3] {
    let [a, b, c] = uv;
    let area = (b - a).perp_dot(c - a);
    let weight = |from: DVec2, to: DVec2| (to - from).perp_dot(at - from) / area;
    [weight(b, c), weight(c, a), weight(a, b)]
}

#[test]
fn points_are_moved_along_interpolated_normals_by_the_heights() {
    let heights = noise(12, 5);
    let mut model = model(&sheet(3), heights);
    for material in &mut model.materials {
        (material.displacement_mapping.gain, material.displacement_mapping.base) = (1.5, -0.04);
        material.displacement_mapping.scale = vec2(2.0, 1.0);
        material.displacement_mapping.offset = vec2(0.25, 0.0);
    }
    let (matrix, viewport) = seen_whole(&model, 300);
    let diced = model.displaced(matrix, viewport, 1.0);
    assert!(diced.face_count() > 50_000, "{}", diced.face_count());
    let faces: Vec<Face<'_>> = model.faces().collect();
    let (mut worst, mut moved) = (0.0_f64, 0.0_f64);
    for piece in diced.faces() {
        let corners: Vec<_> =
            faces[piece.source].indices.iter().map(|&i| model.vertices[i as usize]).collect();
        let uv = [0, 1, 2].map(|i| corners[i].uv.as_dvec2());
        for &index in piece.indices {
            let vertex = &diced.vertices[index as usize];
            let weights = weights(uv, vertex.uv.as_dvec2());
            assert!(weights.iter().all(|&weight| weight > -1e-5), "{weights:?}");
            let sum = |of: fn(&polyscan::model::ModelVertex) -> Vec3| -> DVec3 {
                corners.iter().zip(weights).map(|(v, weight)| of(v).as_dvec3() * weight).sum()
            };
            let (place, normal) = (sum(|v| v.position), sum(|v| v.normal).normalize());
            // The offset and the scale of the mapping, whose v is up: v down is scaled by 1.
            let at = vertex.uv.as_dvec2() * dvec2(2.0, 1.0) + dvec2(0.25, 0.0);
            let height = 1.5 * bilinear(&model.textures[0], at) - 0.04;
            worst = worst.max((place + normal * height - vertex.position.as_dvec3()).length());
            moved = moved.max(height.abs());
        }
    }
    assert!(moved > 0.2, "{moved}");
    assert!(worst < 4e-6, "{worst}");
}

/// An octahedron of radius 1 with normals that point away from the middle: what is moved by c is c farther from the
/// middle than the octahedron is there, and its normals still point away from it.
const OCTAHEDRON: &str = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n\
    vn 1 0 0\nvn -1 0 0\nvn 0 1 0\nvn 0 -1 0\nvn 0 0 1\nvn 0 0 -1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\n\
    f 1/1/1 3/2/3 5/3/5\nf 3/1/3 2/2/2 5/3/5\nf 2/1/2 4/2/4 5/3/5\nf 4/1/4 1/2/1 5/3/5\n\
    f 3/1/3 1/2/1 6/3/6\nf 2/1/2 3/2/3 6/3/6\nf 4/1/4 2/2/2 6/3/6\nf 1/1/1 4/2/4 6/3/6\n";

#[test]
fn a_constant_height_moves_the_surface_by_itself() {
    for height in [0.0, 0.25, -0.125] {
        let model = model(OCTAHEDRON, constant(height));
        let (matrix, viewport) = seen_whole(&model, 100);
        let diced = model.displaced(matrix, viewport, 1.0);
        assert!(diced.face_count() > 10_000);
        for vertex in &diced.vertices {
            let place = vertex.position.as_dvec3();
            let base = place * (1.0 - f64::from(height) / place.length());
            let from_middle = base.abs().element_sum();
            assert!((from_middle - 1.0).abs() < 1e-6, "{place} {from_middle}");
            assert!((vertex.normal.as_dvec3() - place.normalize()).length() < 1e-5, "{vertex:?}");
        }
    }
}

type Bits = [u32; 3];

/// The edges that not two faces have, once in each direction, of faces with an area in their list of corners.
fn open_edges(model: &Model) -> usize {
    let bits = |index: u32| -> Bits {
        (model.vertices[index as usize].position + 0.0).to_array().map(f32::to_bits)
    };
    let mut edges: HashMap<(Bits, Bits), i32> = HashMap::new();
    let mut count: HashMap<(Bits, Bits), u32> = HashMap::new();
    for face in model.faces() {
        for i in 0..face.indices.len() {
            let (a, b) = (face.indices[i], face.indices[(i + 1) % face.indices.len()]);
            let (a, b) = (bits(a), bits(b));
            assert_ne!(a, b);
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            *count.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    edges.iter().filter(|&(edge, &sum)| sum != 0 || count[edge] != 2).count()
}

/// A cube that has normals and texture coordinates of its own on each face, and a prism of six sides.
fn solids() -> [String; 2] {
    let mut cube = String::from("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\n");
    for i in 0..8 {
        let sign = |bit: i32| if i >> bit & 1 == 0 { -1 } else { 1 };
        cube += &format!("v {} {} {}\n", sign(0), sign(1), sign(2));
    }
    for [a, b, c, d] in
        [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]]
    {
        cube += &format!("s off\nf {a}/1 {b}/2 {c}/3 {d}/4\n");
    }
    let mut prism = String::from("usemtl a\n");
    let point = |i: i32| (std::f32::consts::TAU * i as f32 / 6.0).sin_cos();
    for i in 0..6 {
        let (y, x) = point(i);
        prism += &format!("v {x} {y} -1\nv {x} {y} 1\nvt {} {}\n", 0.5 + 0.5 * x, 0.5 + 0.5 * y);
    }
    prism += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let caps = [0, 1].map(|top| {
        let corner = |i: i32| format!(" {}/{}", 2 * i + 1 + top, i + 1);
        let corners: Vec<_> = (0..6).map(corner).collect();
        if top == 1 { corners.concat() } else { corners.into_iter().rev().collect() }
    });
    prism += &format!("f{}\nf{}\n", caps[0], caps[1]);
    for i in 0..6 {
        let next = (i + 1) % 6;
        let (a, b) = (2 * i + 1, 2 * next + 1);
        prism += &format!("f {a}/7 {b}/8 {}/9 {}/10\n", b + 1, a + 1);
    }
    [cube, prism]
}

#[test]
fn closed_surfaces_stay_closed() {
    let [cube, prism] = solids();
    for (name, text, heights) in [
        ("octahedron", OCTAHEDRON, noise(7, 1)),
        ("cube, of one height", &cube, constant(0.1)),
        // The faces' heights along their common edges differ.
        ("cube", &cube, noise(9, 2)),
        ("prism", &prism, noise(9, 3)),
    ] {
        let model = model(text, heights);
        assert_eq!(open_edges(&model), 0, "{name}");
        let (matrix, viewport) = seen_whole(&model, 200);
        // From the inside as well, where most is behind the eye or outside.
        let inside = perspective(1.0, 1.0, 0.01, 10.0)
            * look_at_mat4(vec3(0.1, 0.2, 0.0), vec3(1.0, 0.3, 0.2), Vec3::Y);
        for matrix in [matrix, inside] {
            let diced = model.displaced(matrix, viewport, 1.5);
            assert!(diced.face_count() > 5_000, "{name}: {}", diced.face_count());
            assert_eq!(open_edges(&diced), 0, "{name}");
        }
    }
}

/// Corners of one place that had one normal have one afterwards, whatever their texture coordinates.
#[test]
fn seams_of_smooth_surfaces_have_one_normal() {
    let model = model(OCTAHEDRON, noise(7, 1));
    let (matrix, viewport) = seen_whole(&model, 100);
    let diced = model.displaced(matrix, viewport, 2.0);
    let mut normals: HashMap<Bits, Vec3> = HashMap::new();
    let mut shared = 0;
    for vertex in &diced.vertices {
        let normal =
            *normals.entry(vertex.position.to_array().map(f32::to_bits)).or_insert(vertex.normal);
        assert_eq!(normal, vertex.normal);
        assert!((normal.length() - 1.0).abs() < 1e-5);
    }
    shared += diced.vertices.len() - normals.len();
    assert!(shared > 100, "{shared}");
}

/// A floor far larger than the view, below an eye that looks along it: no edge that is seen is longer than a pixel, and
/// what is out of sight is left alone.
#[test]
fn dicing_is_as_fine_as_the_view_and_no_finer() {
    let text = "v -500 0 500\nv 500 0 500\nv 500 0 -500\nv -500 0 -500\nvn 0 1 0\n\
                vt 0 0\nvt 500 0\nvt 500 500\nvt 0 500\nusemtl a\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
    let model = model(text, noise(4, 4));
    let (width, height, angle) = (160, 120, 0.9_f32);
    let eye = vec3(1.0, 1.5, 2.0);
    let camera = perspective(angle, 4.0 / 3.0, 0.05, 2000.0)
        * look_at_mat4(eye, vec3(0.0, 1.0, -4.0), Vec3::Y);
    let diced = model.displaced(camera, viewport(width, height), 1.0);
    let scale = 0.5 * f64::from(height) / f64::from(0.5 * angle).tan();
    let (mut seen, mut outside, mut longest) = (0_u32, 0_u32, 0.0_f64);
    for face in diced.faces() {
        let places = [0, 1, 2].map(|i| diced.vertices[face.indices[i] as usize].position);
        let clip = places.map(|place| (camera * place.extend(1.0)).as_dvec4());
        let is_inside = clip.iter().all(|p| p.x.abs() <= p.w && p.y.abs() <= p.w && p.z >= 0.0);
        let beyond = |value: fn(&glam::DVec4) -> f64| clip.iter().all(|p| value(p) > 1.1 * p.w);
        outside += u32::from(
            beyond(|p| p.x)
                || beyond(|p| -p.x)
                || beyond(|p| -p.y)
                || clip.iter().all(|p| p.w < 0.0),
        );
        if !is_inside {
            continue;
        }
        seen += 1;
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let length = f64::from(places[a].distance(places[b]));
            longest = longest.max(length * scale / clip[a].w.min(clip[b].w));
        }
    }
    // From 2.65 to 502 ahead, a strip of 1.29 w across is seen, with (scale / w)^2 pixels an area of 1. A triangle with edges of a
    // pixel has 0.43 of one; one whose edges were cut too often, by one level, would have 0.03.
    let pixels = scale * scale * 1.29 * (502.0_f64 / 2.65).ln();
    let area = pixels / f64::from(seen);
    assert!((0.06..0.43).contains(&area), "{area}");
    // The bumps are as high as pixels are wide only near the eye.
    assert!((0.8..1.9).contains(&longest), "{longest}");
    assert!(outside < seen / 10, "{outside} of {seen}");
}

/// A face without heights beside one that has some, and one farther away: the first is cut where they meet, and none of both
/// moves.
#[test]
fn neighbours_without_heights_stay_and_meet() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 3 0 0\nv 3.5 .5 0\nv 3 1 0\n\
                vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
                usemtl plain\nf 2//1 5//1 6//1 3//1\nf 5//1 7//1 8//1 9//1 6//1\n\
                usemtl a\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
    let model = model(text, constant(0.25));
    let (matrix, viewport) = seen_whole(&model, 100);
    let diced = model.displaced(matrix, viewport, 1.0);
    let at = |index: u32| diced.vertices[index as usize].position;
    let faces: Vec<Face<'_>> = diced.faces().collect();
    let of = |source: usize| faces.iter().filter(move |face| face.source == source);
    // Materials are in the order of the file that defines them.
    assert_eq!(of(1).count(), 1);
    assert_eq!(of(1).next().map(|face| face.indices.len()), Some(5));
    assert!(of(0).count() > 10 && of(2).count() > 1000);
    for face in of(0) {
        assert!(face.indices.iter().all(|&index| at(index).z == 0.0));
    }
    for face in of(2) {
        for &index in face.indices {
            // The line where they meet stays at its place; all else is moved.
            let place = at(index);
            assert_eq!(place.z, if place.x == 1.0 { 0.0 } else { 0.25 }, "{place}");
        }
    }
    let on_line = |place: Vec3| place.x == 1.0;
    let mut sides: HashMap<Bits, i32> = HashMap::new();
    for face in of(0).chain(of(2)) {
        for i in 0..3 {
            let (a, b) = (at(face.indices[i]), at(face.indices[(i + 1) % 3]));
            if on_line(a) && on_line(b) {
                let middle = (a + b) * 0.5;
                *sides.entry(middle.to_array().map(f32::to_bits)).or_default() +=
                    if a.y < b.y { 1 } else { -1 };
            }
        }
    }
    assert!(sides.len() > 8 && sides.values().all(|&sum| sum == 0));
    assert!(diced.materials.iter().all(|material| material.displacement_texture.is_none()));
}

/// A ramp has one normal.
#[test]
fn normals_lean_by_the_slope() {
    let text = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\n\
                f 1/1 2/2 3/3 4/4\n";
    let ramp = Texture::from_fn(16, 8, |x, y| Vec4::splat((3 * x + y) as f32 / 64.0));
    let mut model = model(text, ramp.expect("texels").with_wrap(Wrap::Clamp));
    let (matrix, viewport) = seen_whole(&model, 150);
    // A texel is 1/8 wide and 1/8 high, and v runs down.
    let expected = vec3(-24.0 / 64.0, 8.0 / 64.0, 1.0).normalize();
    for with_normal_map in [false, true] {
        if with_normal_map {
            for material in &mut model.materials {
                material.normal_texture = material.displacement_texture;
            }
        }
        let diced = model.displaced(matrix, viewport, 1.0);
        for vertex in &diced.vertices {
            // Up to one texel and a half from the edge, beyond which the picture does not rise.
            let is_inside = |t: f32, texels: f32| (2.0 / texels..1.0 - 2.0 / texels).contains(&t);
            if is_inside(vertex.uv.x, 16.0) && is_inside(vertex.uv.y, 8.0) {
                let expected = if with_normal_map { Vec3::Z } else { expected };
                assert!((vertex.normal - expected).length() < 1e-4, "{vertex:?}");
            }
        }
    }
}

#[test]
fn models_without_heights_are_borrowed() {
    let (matrix, viewport) = (Mat4::IDENTITY, viewport(10, 10));
    for text in [
        "usemtl plain\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "usemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    ] {
        let model = model(text, constant(0.5));
        let same = model.displaced(matrix, viewport, 1.0);
        assert!(matches!(same, std::borrow::Cow::Borrowed(_)), "{text}");
    }
}

#[test]
fn any_input_is_safe() {
    let bad = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-45, 3e38, -3e38];
    let [cube, _] = solids();
    let (plain, viewports) =
        (model(&cube, noise(3, 6)), [viewport(0, 0), viewport(64, 64), viewport(65536, 65536)]);
    let (matrix, _) = seen_whole(&plain, 64);
    let check = |model: &Model, matrix: Mat4, viewport: Viewport, edge: f32| {
        let diced = model.displaced(matrix, viewport, edge);
        for face in diced.faces() {
            assert!(face.indices.iter().all(|&i| (i as usize) < diced.vertices.len()));
            assert!(face.source < model.face_count());
        }
    };
    for number in bad {
        check(&plain, matrix, viewports[1], number.max(0.5));
        check(&plain, matrix * number, viewports[1], 4.0);
        let mut one = matrix;
        one.w_axis.w = number;
        one.x_axis.x = number;
        check(&plain, one, viewports[1], 4.0);
        for at in 0..4 {
            let mut changed = plain.clone();
            let vertex = &mut changed.vertices[5];
            match at {
                0 => vertex.position.y = number,
                1 => vertex.normal = Vec3::splat(number),
                2 => vertex.uv = Vec2::splat(number),
                _ => changed.textures[0] = constant(number),
            }
            check(&changed, matrix, viewports[1], 4.0);
        }
        let mut changed = plain.clone();
        changed.materials.iter_mut().for_each(|material: &mut Material| {
            material.displacement_mapping.gain = number;
            material.displacement_mapping.scale.x = number;
        });
        check(&changed, matrix, viewports[0], 4.0);
        changed.vertices.iter_mut().for_each(|vertex| vertex.normal = Vec3::ZERO);
        check(&changed, matrix, viewports[1], 4.0);
        changed.vertices.iter_mut().for_each(|vertex| vertex.position = Vec3::ONE);
        check(&changed, matrix, viewports[1], 4.0);
    }
    check(&plain, matrix, viewports[1], f32::NAN);
    // Faces that have lost vertices stay, and have none.
    let mut changed = plain.clone();
    changed.vertices.truncate(10);
    let diced = changed.displaced(matrix, viewports[1], 4.0);
    assert!(diced.face_count() > 100);
    let there = |face: Face<'_>| face.indices.iter().all(|&i| (i as usize) < diced.vertices.len());
    assert!(diced.faces().filter(|face| !there(*face)).count() < 6);
}
