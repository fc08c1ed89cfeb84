//! Mean value coordinates, against their definition by angles, and on the screen.

use std::array::from_fn;
use std::f64::consts::TAU;

use crate::common::generators::{Rng, number};
use glam::{DVec2, DVec3, Mat4, Vec2, Vec3, dvec2, vec2, vec3};
use polyscan::parameters::{ParameterError, PolygonValues};
use polyscan::{ScanConverter, Vertex, Viewport};

/// The definition: weights (tan(α / 2) + tan(β / 2)) / r by the angles at which edges are seen, in f64.
fn by_angles<const K: usize>(corners: &[(DVec2, [f32; K])], place: DVec2) -> [f64; K] {
    let n = corners.len();
    let angle = |i: usize| {
        let [a, b] = [i % n, (i + 1) % n].map(|i| corners[i].0 - place);
        a.perp_dot(b).atan2(a.dot(b))
    };
    let weights: Vec<f64> = (0..n)
        .map(|i| {
            ((angle(i + n - 1) / 2.0).tan() + (angle(i) / 2.0).tan())
                / (corners[i].0 - place).length()
        })
        .collect();
    let total: f64 = weights.iter().sum();
    from_fn(|k| {
        let each = weights.iter().zip(corners);
        each.map(|(weight, (_, values))| weight * f64::from(values[k])).sum::<f64>() / total
    })
}

/// A star-shaped polygon around the origin, convex or not, with random values.
fn polygon<const K: usize>(rng: &mut Rng) -> Vec<(DVec2, [f32; K])> {
    let sides = 3 + rng.below(9);
    let least = [0.3, 1.0][rng.below(2)];
    let turn = rng.range(0.0, TAU);
    let reversed = rng.once_in(2);
    let mut corners: Vec<_> = (0..sides)
        .map(|i| {
            let angle = turn + (i as f64 + rng.range(0.0, 0.5)) * TAU / sides as f64;
            let place = DVec2::from_angle(angle) * rng.range(least, 1.0);
            ((place * 256.0).round() / 256.0, from_fn(|_| rng.range(-1.0, 1.0) as f32))
        })
        .collect();
    if reversed {
        corners.reverse();
    }
    corners
}

/// The polygon in space, on a plane, exact in f32; and its plane.
fn in_space<const K: usize>(
    rng: &mut Rng,
    corners: &[(DVec2, [f32; K])],
) -> (Vec<(Vec3, [f32; K])>, [DVec3; 3]) {
    let small = |rng: &mut Rng| DVec3::from_array(from_fn(|_| rng.whole(-16, 16) as f64 / 16.0));
    let (origin, right, up) =
        (small(rng), small(rng) + DVec3::X * 2.0, small(rng) + DVec3::Y * 2.0);
    let place = |p: DVec2| (origin + right * p.x + up * p.y).as_vec3();
    (corners.iter().map(|&(p, values)| (place(p), values)).collect(), [origin, right, up])
}

/// The plane's axes made square: distances and angles on the plane as they are in space.
fn squared([_, right, up]: [DVec3; 3]) -> glam::DMat2 {
    let x = right.normalize();
    let y = (up - x * up.dot(x)).normalize();
    glam::DMat2::from_cols(dvec2(right.dot(x), right.dot(y)), dvec2(up.dot(x), up.dot(y)))
}

/// Any polygon, at any pixel, with the camera rolled in several ways: what the definition says of the place where the
/// pixel's ray meets the plane.
#[test]
fn values_do_not_move_when_the_camera_rolls() {
    let (width, height) = (56, 40);
    let (mut compared, mut worst) = (0, 0.0f64);
    for seed in 0..80 {
        let rng = &mut Rng::new(seed);
        let flat = polygon::<3>(rng);
        let (corners, plane) = in_space(rng, &flat);
        let values = PolygonValues::new(&corners).expect("a polygon with an area");
        let eye = vec3(rng.range(-2.0, 2.0) as f32, rng.range(-2.0, 2.0) as f32, 4.0);
        let square = squared(plane);
        let flat: Vec<_> = flat.iter().map(|&(p, values)| (square * p, values)).collect();
        for roll in [0.0, 0.4, 1.5, 3.3] {
            let camera = glam::camera::rh::proj::directx::perspective(0.9, 1.4, 0.1, 100.0)
                * Mat4::from_rotation_z(roll)
                * glam::camera::rh::view::look_at_mat4(eye, Vec3::ZERO, Vec3::Y);
            let vertices: Vec<_> = corners
                .iter()
                .zip(values.places())
                .map(|((corner, _), &place)| Vertex::new(camera * corner.extend(1.0), place))
                .collect();
            let mut scan = ScanConverter::new(Viewport::new(width, height).expect("small"));
            for span in scan.spans(&vertices) {
                for fragment in span.fragments() {
                    let place = met(&camera, plane, (fragment.x, fragment.y), (width, height));
                    let place = square * place;
                    // At a corner outside of which the rounded outline reaches, the definition has a pole.
                    if flat.iter().any(|(corner, _)| corner.distance(place) < 0.05) {
                        continue;
                    }
                    let wanted = by_angles(&flat, place);
                    let found = values.at(fragment.params.into());
                    for (found, wanted) in found.into_iter().zip(wanted) {
                        let off = (f64::from(found) - wanted).abs();
                        worst = worst.max(off);
                        assert!(off < 1e-5, "seed {seed}, roll {roll}: {found} for {wanted}");
                    }
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} pixels, worst error {worst:.1e}");
    assert!(compared > 50_000, "only {compared} pixels were compared");
}

/// Where a pixel's ray meets a plane.
fn met(camera: &Mat4, plane: [DVec3; 3], (x, y): (i32, i32), (width, height): (u32, u32)) -> DVec2 {
    let (clip, [origin, right, up]) = (camera.as_dmat4(), plane);
    let x = (f64::from(x) + 0.5) / f64::from(width) * 2.0 - 1.0;
    let y = 1.0 - (f64::from(y) + 0.5) / f64::from(height) * 2.0;
    let places = [right.extend(0.0), up.extend(0.0), origin.extend(1.0)].map(|p| clip * p);
    let row = |i: usize| DVec3::from_array(places.map(|place| place[i]));
    let point = (row(0) - row(3) * x).cross(row(1) - row(3) * y);
    dvec2(point.x, point.y) / point.z
}

#[test]
fn affine_values_stay_affine_and_triangles_have_barycentric_ones() {
    for seed in 0..200 {
        let rng = &mut Rng::new(seed);
        let mut flat = polygon::<4>(rng);
        let [a, b, c] = [0; 3].map(|_| rng.range(-1.0, 1.0));
        let affine = |p: DVec2| a * p.x + b * p.y + c;
        flat.iter_mut().for_each(|(place, values)| values[0] = affine(*place) as f32);
        let count = flat.len();
        let corners: Vec<_> =
            flat.iter().map(|(p, values)| (p.as_vec2().extend(0.0), *values)).collect();
        let values = PolygonValues::new(&corners).expect("a polygon with an area");
        // Places are the corners but for a turn, a scale, and their middle as origin.
        let places = values.places();
        let middle = flat.iter().map(|f| f.0).sum::<DVec2>() / count as f64;
        for _ in 0..20 {
            let weights: Vec<f64> = (0..count).map(|_| rng.range(0.0, 1.0)).collect();
            let total: f64 = weights.iter().sum();
            let mix = |of: &dyn Fn(usize) -> DVec2| -> DVec2 {
                (0..count).map(|i| of(i) * weights[i]).sum::<DVec2>() / total
            };
            let place = mix(&|i| places[i].as_dvec2()) * 0.3;
            let point = middle + (mix(&|i| flat[i].0) - middle) * 0.3;
            let found = values.at(place.as_vec2());
            assert!((f64::from(found[0]) - affine(point)).abs() < 2e-6, "seed {seed}");
            if count == 3 {
                let area = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
                let [a, b, c] = [flat[0].0, flat[1].0, flat[2].0];
                let weights = [area(point, b, c), area(a, point, c), area(a, b, point)];
                for (k, found) in found.into_iter().enumerate() {
                    let sum: f64 = (0..3).map(|i| weights[i] * f64::from(flat[i].1[k])).sum();
                    let wanted = sum / area(a, b, c);
                    assert!((f64::from(found) - wanted).abs() < 2e-6, "seed {seed}");
                }
            }
        }
    }
}

#[test]
fn corners_have_their_values_and_edges_are_linear() {
    for seed in 0..200 {
        let rng = &mut Rng::new(seed);
        let flat = polygon::<2>(rng);
        let (corners, _) = in_space(rng, &flat);
        let values = PolygonValues::new(&corners).expect("a polygon with an area");
        for i in 0..corners.len() {
            let next = (i + 1) % corners.len();
            assert_eq!(values.at(values.places()[i]), corners[i].1);
            for t in [0.25f32, 0.5, 0.9] {
                let found = values.at(values.places()[i].lerp(values.places()[next], t));
                for (k, found) in found.into_iter().enumerate() {
                    let wanted = corners[i].1[k] * (1.0 - t) + corners[next].1[k] * t;
                    let error = (found - wanted).abs();
                    assert!(error < 1e-5, "seed {seed}: {found} for {wanted}");
                }
            }
        }
        // Convex: no value leaves the range of the corners'.
        let turns = |i: usize| {
            let n = flat.len();
            let [a, b, c] = [i, (i + 1) % n, (i + 2) % n].map(|i| flat[i].0);
            (b - a).perp_dot(c - b)
        };
        let is_convex =
            (0..flat.len()).all(|i| turns(i) > 0.0) || (0..flat.len()).all(|i| turns(i) < 0.0);
        if is_convex {
            let of = |k: usize| corners.iter().map(move |c| c.1[k]);
            let weights: Vec<f32> = corners.iter().map(|_| rng.range(0.0, 1.0) as f32).collect();
            let total: f32 = weights.iter().sum();
            let places = values.places().iter().zip(&weights);
            let found = values.at(places.map(|(p, w)| *p * *w).sum::<Vec2>() / total);
            for (k, found) in found.into_iter().enumerate() {
                let (least, most) = (of(k).fold(2.0, f32::min), of(k).fold(-2.0, f32::max));
                assert!(found >= least - 1e-6 && found <= most + 1e-6, "seed {seed}");
            }
        }
    }
}

#[test]
fn anything_has_finite_values_or_is_an_error() {
    use ParameterError::{Degenerate, NotFinite, TooFewCorners};
    let corner = |x: f32, y: f32| (vec3(x, y, 0.0), [1.0]);
    assert_eq!(
        PolygonValues::new(&[corner(0.0, 0.0), corner(1.0, 0.0)]).err(),
        Some(TooFewCorners { count: 2 })
    );
    let line = [corner(0.0, 0.0), corner(1.0, 0.0), corner(2.0, 0.0), corner(3.0, 0.0)];
    assert_eq!(PolygonValues::new(&line).err(), Some(Degenerate));
    assert_eq!(PolygonValues::new(&[corner(1.0, 1.0); 5]).err(), Some(Degenerate));
    let odd = [corner(0.0, 0.0), corner(1.0, 0.0), (Vec3::Y, [f32::NAN])];
    assert_eq!(PolygonValues::new(&odd).err(), Some(NotFinite { index: 2 }));
    let mut made = 0;
    for seed in 0..20_000 {
        let rng = &mut Rng::new(seed);
        let oddness = [4, 10, 1000][rng.below(3)];
        let corners: Vec<_> = (0..rng.below(8))
            .map(|_| {
                (
                    Vec3::from_array(from_fn(|_| number(rng, oddness))),
                    from_fn(|_| number(rng, oddness)),
                )
            })
            .collect();
        let Ok(values) = PolygonValues::<2>::new(&corners) else { continue };
        assert!(values.places().iter().all(|p| p.is_finite() && p.length() < 1.001));
        let some = |rng: &mut Rng| match rng.below(3) {
            0 => vec2(number(rng, 3), number(rng, 3)),
            1 => values.places()[rng.below(corners.len())],
            _ => (values.places()[0] + values.places()[1]) / 2.0,
        };
        for _ in 0..10 {
            let place = some(rng);
            let found = values.at(place);
            assert!(found.iter().all(|r| r.is_finite()), "seed {seed}: {found:?} at {place}");
        }
        made += 1;
    }
    assert!(made > 5000, "only {made} polygons");
}
