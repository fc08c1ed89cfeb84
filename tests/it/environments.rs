//! Environment maps against f64: what is seen in a direction, without seams, at every level.

use glam::{DVec3, Vec3, Vec4, dvec3, vec3};
use polyscan::texture::{DirectionFootprint, EnvironmentMap, MipFilter, Texture, TextureError};

use crate::common::generators::Rng;

/// A smooth environment, of three independent channels.
fn light(direction: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = direction.normalize();
    dvec3(0.5 + 0.3 * x, 0.5 + 0.2 * y + 0.2 * z * z, 0.5 - 0.3 * z + 0.15 * x * y)
}

/// By longitude and latitude: its centre is at -z, its right half at +x, its upper edge at +y.
fn sheet(height: u32) -> EnvironmentMap {
    use std::f64::consts::{PI, TAU};
    let width = 2 * height;
    let texel = |x: u32, y: u32| {
        let longitude = ((f64::from(x) + 0.5) / f64::from(width) - 0.5) * TAU;
        let polar = (f64::from(y) + 0.5) / f64::from(height) * PI;
        let out = polar.sin();
        light(dvec3(out * longitude.sin(), polar.cos(), -out * longitude.cos()))
            .as_vec3()
            .extend(1.0)
    };
    EnvironmentMap::equirectangular(chained(Texture::from_fn(width, height, texel)))
}

fn chained(texture: Result<Texture, TextureError>) -> Texture {
    let texture = texture.expect("texels").with_mipmaps().expect("levels");
    texture.with_mip_filter(MipFilter::Anisotropic { probes: 16 })
}

/// By the table of OpenGL's specification: of each face where s and t are on the axes.
fn cube(side: u32) -> EnvironmentMap {
    let faces = [0, 1, 2, 3, 4, 5].map(|face| {
        chained(Texture::from_fn(side, side, |x, y| {
            let [s, t] = [x, y].map(|i| (f64::from(i) + 0.5) / f64::from(side) * 2.0 - 1.0);
            let direction = match face {
                0 => dvec3(1.0, -t, -s),
                1 => dvec3(-1.0, -t, s),
                2 => dvec3(s, 1.0, t),
                3 => dvec3(s, -1.0, -t),
                4 => dvec3(s, -t, 1.0),
                _ => dvec3(-s, -t, -1.0),
            };
            light(direction).as_vec3().extend(1.0)
        }))
    });
    EnvironmentMap::cube(faces).expect("a cube")
}

/// A direction of any length, many of them near axes, edges and corners of a cube.
fn direction(rng: &mut Rng) -> DVec3 {
    let mut part = || match rng.below(4) {
        0 => rng.range(-1e-3, 1e-3),
        1 => [1.0, -1.0][rng.below(2)] * (1.0 + rng.range(-1e-3, 1e-3)),
        _ => rng.range(-1.0, 1.0),
    };
    let direction = dvec3(part(), part(), part());
    if direction.length() > 1e-2 { direction } else { DVec3::NEG_Z }
}

/// Differences that a seam or a mirrored axis would exceed many times.
#[test]
fn the_colour_is_that_of_the_direction_everywhere() {
    let rng = &mut Rng::new(1976);
    for (map, most) in [(sheet(64), 3e-3), (cube(48), 3e-3)] {
        let mut worst = 0.0_f64;
        for _ in 0..20_000 {
            let direction = direction(rng);
            let found = map.sample(direction.as_vec3()).truncate().as_dvec3();
            worst = worst.max((found - light(direction)).abs().max_element());
        }
        assert!(worst < most, "{worst}");
    }
}

/// What a wide footprint sees is the mean over it, also across seams.
#[test]
fn footprints_see_the_mean_of_their_directions() {
    let rng = &mut Rng::new(6);
    for map in [sheet(128), cube(96)] {
        let mut worst = 0.0_f64;
        for _ in 0..2000 {
            let centre = direction(rng).normalize();
            let across = centre.any_orthonormal_pair();
            // From a point to 10 degrees, and up to 8 times as long as wide.
            let size = rng.range(0.0, 0.17);
            let narrow = size * rng.range(0.125, 1.0);
            let (dx, dy) = (across.0 * size, across.1 * narrow);
            let mut mean = DVec3::ZERO;
            for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
                let [s, t] = [i, j].map(|n| (f64::from(n) + 0.5) / 8.0 - 0.5);
                mean += light(centre + dx * s + dy * t) / 64.0;
            }
            let seen = DirectionFootprint {
                direction: centre.as_vec3(),
                dx: dx.as_vec3(),
                dy: dy.as_vec3(),
            };
            let found = map.sample_footprint(&seen).truncate().as_dvec3();
            worst = worst.max((found - mean).abs().max_element());
        }
        assert!(worst < 0.02, "{worst}");
    }
}

/// Two pixels beside each other see nearly the same, on either side of a seam, at whatever level: of noise, whose
/// texels differ as much as they can.
#[test]
fn there_are_no_seams() {
    let rng = &mut Rng::new(13);
    let mut noise = |width: u32, height: u32| {
        chained(Texture::from_fn(width, height, |_, _| Vec4::splat(rng.below(2) as f32)))
    };
    let sheet = EnvironmentMap::equirectangular(noise(128, 64));
    let cube = EnvironmentMap::cube([0; 6].map(|_| noise(64, 64))).expect("a cube");
    let rng = &mut Rng::new(14);
    let step = 1e-3;
    for (map, from_pole) in [(sheet, 0.2), (cube, 0.0)] {
        for _ in 0..5000 {
            let from = direction(rng).normalize();
            // Nearer to a pole, all texels of a row are within a step, and differ.
            if from.x.hypot(from.z) < from_pole {
                continue;
            }
            let (x, y) = from.any_orthonormal_pair();
            let to = from + (x * rng.range(-1.0, 1.0) + y * rng.range(-1.0, 1.0)) * step;
            let size = rng.range(0.05, 0.4);
            let seen = |at: DVec3| DirectionFootprint {
                direction: at.as_vec3(),
                dx: (x * size).as_vec3(),
                dy: (y * size).as_vec3(),
            };
            let difference = map.sample_footprint(&seen(from)) - map.sample_footprint(&seen(to));
            // A texel of the finest level that is seen, of 0.05 x 41 / 2 to the power, is 20 steps wide.
            assert!(difference.abs().max_element() < 0.12, "{from} {size}: {difference}");
        }
    }
}

#[test]
fn constants_stay_what_they_are() {
    let rng = &mut Rng::new(2);
    let color = vec3(0.25, 0.5, 0.75).extend(1.0);
    let one = |w, h| chained(Texture::from_fn(w, h, |_, _| color));
    let cube = EnvironmentMap::cube([0; 6].map(|_| one(5, 5))).expect("a cube");
    for map in [EnvironmentMap::equirectangular(one(7, 3)), cube] {
        for _ in 0..500 {
            let mut any = || direction(rng).as_vec3();
            let seen = DirectionFootprint { direction: any(), dx: any(), dy: any() };
            let found = map.sample_footprint(&seen);
            assert!((found - color).abs().max_element() < 1e-6, "{found}");
        }
        // Anything is safe.
        for odd in [0.0, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN_POSITIVE] {
            for direction in [Vec3::splat(odd), vec3(odd, 1.0, -odd), vec3(0.0, odd, 0.0)] {
                let seen = DirectionFootprint { direction, dx: Vec3::splat(odd), dy: direction };
                let found = map.sample_footprint(&seen);
                assert!((found - color).abs().max_element() < 1e-6, "{odd}: {found}");
            }
        }
    }
}

/// The mirrored direction and its derivatives, by differences in f64.
#[test]
fn mirrors_show_what_is_around() {
    let rng = &mut Rng::new(4);
    for _ in 0..500 {
        let mut any = |most: f64| {
            dvec3(rng.range(-most, most), rng.range(-most, most), rng.range(-most, most))
        };
        let (way, normal) = ([any(1.0), any(0.1), any(0.1)], [any(1.0), any(0.1), any(0.1)]);
        if normal[0].length() < 0.3 {
            continue;
        }
        let mirrored = |x: f64, y: f64| {
            let at = |v: [DVec3; 3]| v[0] + v[1] * x + v[2] * y;
            at(way) - at(normal).normalize() * (2.0 * at(way).dot(at(normal).normalize()))
        };
        let step = 1e-4;
        let dx = (mirrored(step, 0.0) - mirrored(-step, 0.0)) / (2.0 * step);
        let dy = (mirrored(0.0, step) - mirrored(0.0, -step)) / (2.0 * step);
        let footprint = |[direction, dx, dy]: [DVec3; 3]| DirectionFootprint {
            direction: direction.as_vec3(),
            dx: dx.as_vec3(),
            dy: dy.as_vec3(),
        };
        let found = footprint(way).reflected(&footprint(normal));
        for (found, exact) in
            [(found.direction, mirrored(0.0, 0.0)), (found.dx, dx), (found.dy, dy)]
        {
            assert!((found.as_dvec3() - exact).length() < 1e-5, "{found} {exact}");
        }
    }
}

#[test]
fn faces_of_a_cube_are_alike() {
    let face = |side| Texture::from_fn(side, side, |_, _| Vec4::ONE).expect("texels");
    let faces = [4, 4, 4, 5, 4, 4].map(face);
    let error = EnvironmentMap::cube(faces).expect_err("one is larger").to_string();
    assert!(error.contains("face 3") && error.contains("5 x 5"), "{error}");
    let mut faces = [4; 6].map(face);
    faces[1] = faces[1].clone().with_mipmaps().expect("levels");
    assert!(EnvironmentMap::cube(faces).is_err());
}
