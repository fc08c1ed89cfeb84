//! Tangent space against f64: tangents of flat and of bent meshes, bent normals, normals of heights.

use glam::{DMat3, DVec2, DVec3, Vec2, Vec3, Vec4, dvec2, dvec3, vec2, vec3};
use polyscan::tangent::{TangentFrame, TangentVertex, tangents};
use polyscan::texture::{Format, Texture, Wrap};

use crate::common::generators::Rng;

fn double(rng: &mut Rng, most: f64) -> f64 {
    rng.range(-most, most)
}

fn direction(rng: &mut Rng) -> DVec3 {
    loop {
        let v = dvec3(double(rng, 1.0), double(rng, 1.0), double(rng, 1.0));
        if (0.1..1.0).contains(&v.length()) {
            return v.normalize();
        }
    }
}

/// A picture that lies on a plane by an affine mapping has the mapping's first column as tangent, whatever the
/// polygon, and its second as bitangent, as far as they are across.
#[test]
fn tangents_of_flat_polygons_are_those_of_the_mapping() {
    let rng = &mut Rng::new(1307);
    let mut mirrored = 0;
    for _ in 0..500 {
        let (along_u, along_v) = (direction(rng) * 3.0, direction(rng));
        let normal = along_u.cross(along_v).normalize_or_zero();
        if normal == DVec3::ZERO || along_u.cross(along_v).length() < 0.3 {
            continue;
        }
        // Either side of the plane may be the front.
        let normal = normal * [1.0, -1.0][rng.below(2)];
        let sides = 3 + rng.below(6);
        let vertices: Vec<_> = (0..sides)
            .map(|i| {
                let angle = (i as f64 + double(rng, 0.3)) / sides as f64 * std::f64::consts::TAU;
                let up = DVec2::from_angle(angle) * rng.range(0.5, 1.0);
                TangentVertex {
                    position: (along_u * up.x + along_v * up.y).as_vec3(),
                    normal: normal.as_vec3(),
                    uv: dvec2(up.x, 1.0 - up.y).as_vec2(),
                }
            })
            .collect();
        let face: Vec<u32> = (0..sides as u32).collect();
        for tangent in tangents(&vertices, [&face]) {
            let expected = along_u.normalize();
            let found = tangent.truncate().as_dvec3();
            assert!((found - expected).length() < 1e-5, "{found} {expected}");
            let frame = TangentFrame::new(normal.as_vec3(), tangent);
            assert!(frame.bitangent().as_dvec3().dot(along_v) > 0.0);
            mirrored += u32::from(tangent.w < 0.0);
        }
    }
    assert!(mirrored > 500, "{mirrored}");
}

/// A bent mesh: tangents of triangles by two linear equations, in the planes across the normals, weighted by the
/// angles there.
#[test]
fn tangents_of_meshes_are_those_of_mikkelsen() {
    let rng = &mut Rng::new(8);
    for _ in 0..100 {
        let columns = 4;
        let vertices: Vec<_> = (0..columns * columns)
            .map(|i| {
                let at = dvec2((i % columns) as f64, (i / columns) as f64);
                let uv = at * 0.3 + dvec2(double(rng, 0.1), double(rng, 0.1));
                let bend = dvec3(double(rng, 0.3), double(rng, 0.3), 1.0).normalize();
                TangentVertex {
                    position: at.extend(double(rng, 0.3)).as_vec3(),
                    normal: bend.as_vec3(),
                    uv: dvec2(uv.x, 1.0 - uv.y).as_vec2(),
                }
            })
            .collect();
        let corner = |x: usize, y: usize| (y * columns + x) as u32;
        let faces: Vec<[u32; 3]> = (0..9)
            .map(|i| (i % 3, i / 3))
            .flat_map(|(x, y)| {
                let [a, b] = [corner(x, y), corner(x + 1, y)];
                let [c, d] = [corner(x + 1, y + 1), corner(x, y + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let found = tangents(&vertices, &faces);
        for (i, tangent) in found.iter().enumerate() {
            let normal = vertices[i].normal.as_dvec3();
            let across = |v: DVec3| v - normal * v.dot(normal);
            let mut sum = DVec3::ZERO;
            for face in faces.iter().filter(|face| face.contains(&(i as u32))) {
                let place = face.iter().position(|&index| index as usize == i).expect("a corner");
                let at = |k: usize| vertices[face[(place + k) % 3] as usize];
                let side = |k: usize| (at(k).position - at(0).position).as_dvec3();
                let uv = |k: usize| (at(k).uv - at(0).uv).as_dvec2();
                let determinant = uv(1).perp_dot(uv(2));
                let along_u = (side(1) * uv(2).y - side(2) * uv(1).y) / determinant;
                let angle = across(side(1)).angle_between(across(side(2)));
                sum += across(along_u).normalize() * angle;
            }
            let error = (tangent.truncate().as_dvec3() - sum.normalize()).length();
            assert!(error < 2e-4, "{error}");
            assert_eq!(tangent.w, 1.0);
        }
    }
}

#[test]
fn what_has_no_tangent_gets_one_across_the_normal() {
    let vertex = |position, uv| TangentVertex { position, normal: Vec3::Y, uv };
    let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Z];
    for uvs in [
        [Vec2::ZERO; 3],
        [Vec2::NAN; 3],
        [Vec2::ZERO, Vec2::X, Vec2::X * 2.0],
        [Vec2::ZERO, Vec2::X * f32::INFINITY, Vec2::Y],
    ] {
        let vertices = [vertex(a, uvs[0]), vertex(b, uvs[1]), vertex(c, uvs[2])];
        for faces in [&[[0_u32, 1, 2]][..], &[[0, 1, 7]], &[]] {
            for tangent in tangents(&vertices, faces) {
                assert!((tangent.truncate().length() - 1.0).abs() < 1e-6, "{tangent}");
                assert!(tangent.y.abs() < 1e-6 && tangent.w == 1.0, "{tangent}");
            }
        }
    }
}

/// Where the picture is folded, the larger angle says how it lies.
#[test]
fn the_larger_part_says_whether_a_vertex_is_mirrored() {
    let vertex = |x: f32, y: f32| TangentVertex {
        position: vec3(x, y, 0.0),
        normal: Vec3::Z,
        uv: vec2(x.abs(), -y),
    };
    let vertices = [vertex(0.0, 0.0), vertex(2.0, 0.0), vertex(0.0, 1.0), vertex(-0.3, 0.0)];
    let found = tangents(&vertices, [[0, 1, 2], [0, 2, 3]]);
    // At its upper end the right half has the larger angle.
    for (place, sign) in [(1, 1.0), (2, 1.0), (3, -1.0)] {
        let expected = Vec4::new(sign, 0.0, 0.0, sign);
        assert!((found[place] - expected).length() < 1e-6, "{place}: {}", found[place]);
    }
}

#[test]
fn texels_are_directions_in_the_frame() {
    let rng = &mut Rng::new(77);
    for _ in 0..1000 {
        let axes = DMat3::from_cols(direction(rng), direction(rng), direction(rng));
        let [tangent, normal] = [axes.x_axis * 0.7, axes.z_axis * 1.2];
        let sign = [1.0, -1.0][rng.below(2)];
        let frame = TangentFrame::new(normal.as_vec3(), tangent.as_vec3().extend(sign as f32));
        let texel = dvec3(rng.range(0.0, 1.0), rng.range(0.0, 1.0), rng.range(0.5, 1.0));
        let strength = rng.range(-2.0, 2.0);
        let [x, y, z] = (texel * 2.0 - 1.0).to_array();
        let bitangent = normal.cross(tangent) * sign;
        let expected = tangent * (x * strength) + bitangent * (y * strength) + normal * z;
        if expected.length() > 0.1 {
            let found = frame.bent(texel.as_vec3(), strength as f32).as_dvec3();
            assert!((found - expected.normalize()).length() < 1e-5, "{found} {expected}");
        }
    }
    // Bytes are numbers as they stand: 128 is the middle, but for half a code.
    let flat = Texture::from_samples(
        1,
        1,
        4,
        polyscan::texture::Samples::Unorm8(vec![128, 128, 255, 255]),
    );
    let texel = flat.expect("a texel").sample(Vec2::ZERO).truncate();
    let bent = TangentFrame::new(Vec3::Z, Vec4::new(1.0, 0.0, 0.0, 1.0)).bent(texel, 1.0);
    assert!(bent.angle_between(Vec3::Z) < 0.006, "{bent}");
}

/// Waves, whose slopes are known, and which run on beyond the edges.
#[test]
fn normals_of_heights_lean_from_what_is_higher() {
    use std::f64::consts::TAU;
    let (width, rows, high) = (96, 80, 7.0);
    let height = |x: f64, y: f64| {
        0.5 + 0.3 * (x / f64::from(width) * TAU).sin()
            + 0.2 * (y / f64::from(rows) * 2.0 * TAU).cos()
    };
    let texture =
        Texture::from_fn(
            width,
            rows,
            |x, y| Vec4::splat(height(f64::from(x), f64::from(y)) as f32),
        );
    let normals = texture.expect("heights").normals_of_heights(high as f32).expect("normals");
    assert_eq!(normals.format(), Format::Unorm16);
    for (y, x) in (0..rows).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let (fx, fy) = (f64::from(x), f64::from(y));
        let right = (height(fx + 1.0, fy) - height(fx - 1.0, fy)) / 2.0;
        let down = (height(fx, fy + 1.0) - height(fx, fy - 1.0)) / 2.0;
        let expected = dvec3(-right * high, down * high, 1.0).normalize();
        let found = normals.texel(x, y).truncate().as_dvec3() * 2.0 - 1.0;
        assert!((found - expected).length() < 1e-4, "{x}, {y}: {found} {expected}");
    }
    // At an edge that goes on, only one side changes.
    let ramp = Texture::from_fn(4, 1, |x, _| Vec4::splat(x as f32)).expect("a ramp");
    let slope = |texture: Texture, x: u32| {
        let normal = texture.normals_of_heights(1.0).expect("normals").texel(x, 0) * 2.0 - 1.0;
        -normal.x / normal.z
    };
    for (wrap, expected) in [(Wrap::Clamp, 0.5), (Wrap::Mirror, 0.5), (Wrap::Repeat, -1.0)] {
        assert!((slope(ramp.clone().with_wrap(wrap), 0) - expected).abs() < 1e-3, "{wrap:?}");
        assert!((slope(ramp.clone().with_wrap(wrap), 1) - 1.0).abs() < 1e-3, "{wrap:?}");
    }
}
