//! Projective mappings and quads, against exact and f64 arithmetic.

use std::array::from_fn;

use crate::common::dynamic;
use crate::common::generators::{Rng, number};
use glam::{DMat4, DVec2, DVec3, Mat4, Vec2, Vec3, dvec2, vec2, vec3};
use num_rational::BigRational;
use num_traits::{FromPrimitive as _, ToPrimitive as _, Zero as _};
use polyscan::parameters::{self, ParameterError, Projective};
use polyscan::texture::{Filter, MipFilter, Texture, Wrap};
use polyscan::{Footprint, Framebuffer, ScanConverter, Vertex, Viewport, ZBufferRenderer};

type Pair = (DVec2, DVec2);

/// The mapping of four pairs as eight equations for its elements, the last of which is 1, solved exactly; `None` if
/// they have no one solution.
fn solved_exactly(pairs: &[Pair; 4]) -> Option<[BigRational; 9]> {
    let number = |x: f64| BigRational::from_f64(x).expect("finite");
    let mut rows: Vec<Vec<BigRational>> = Vec::new();
    for (from, to) in pairs {
        for (axis, target) in to.to_array().into_iter().enumerate() {
            let mut row = vec![BigRational::zero(); 9];
            for (i, x) in [from.x, from.y, 1.0].into_iter().enumerate() {
                row[3 * axis + i] = number(x);
            }
            row[6] = -number(from.x) * number(target);
            row[7] = -number(from.y) * number(target);
            row[8] = number(target);
            rows.push(row);
        }
    }
    for column in 0..8 {
        let pivot = (column..8).find(|&row| !rows[row][column].is_zero())?;
        rows.swap(column, pivot);
        for row in (0..8).filter(|&row| row != column) {
            let factor = rows[row][column].clone() / rows[column][column].clone();
            let pivot = rows[column].clone();
            for (element, above) in rows[row].iter_mut().zip(pivot).skip(column) {
                *element -= factor.clone() * above;
            }
        }
    }
    let one = number(1.0);
    Some(from_fn(|i| if i == 8 { one.clone() } else { rows[i][8].clone() / rows[i][i].clone() }))
}

/// Where a mapping takes a point, exactly; and its q, of any sign.
fn mapped(elements: &[BigRational; 9], point: DVec2) -> Option<(DVec2, f64)> {
    let number = |x: f64| BigRational::from_f64(x).expect("finite");
    let row = |i: usize| {
        elements[3 * i].clone() * number(point.x)
            + elements[3 * i + 1].clone() * number(point.y)
            + elements[3 * i + 2].clone()
    };
    let q = row(2);
    let over = |i: usize| (row(i) / q.clone()).to_f64().expect("a number");
    (!q.is_zero()).then(|| (dvec2(over(0), over(1)), q.to_f64().expect("a number")))
}

fn convex_quad(rng: &mut Rng, middle: DVec2, size: f64) -> [DVec2; 4] {
    let turn = rng.range(0.0, 6.3);
    from_fn(|i| {
        let angle = turn + (i as f64 + rng.range(-0.3, 0.3)) * std::f64::consts::FRAC_PI_2;
        let point = middle + DVec2::from_angle(angle) * size * rng.range(0.75, 1.0);
        (point * 64.0).round() / 64.0
    })
}

fn random_pairs(rng: &mut Rng) -> [Pair; 4] {
    let [from, to] = [0; 2].map(|_| rng.octaves(10.0, 3000.0));
    let from = convex_quad(rng, dvec2(300.0, 200.0), from);
    let to = convex_quad(rng, dvec2(-20.0, 150.0), to);
    from_fn(|i| (from[i], to[i]))
}

#[test]
fn mappings_through_four_points_are_those_of_exact_arithmetic() {
    let mut compared = 0;
    for seed in 0..300 {
        let rng = &mut Rng::new(seed);
        let pairs = random_pairs(rng);
        let mapping = Projective::from_pairs(&pairs).expect("two convex quads");
        let exact = solved_exactly(&pairs).expect("two convex quads");
        let q_sign = mapped(&exact, pairs[0].0).expect("not on the horizon").1.signum();
        for _ in 0..10 {
            let point = dvec2(rng.range(-500.0, 900.0), rng.range(-500.0, 900.0)).round();
            let Some((place, q)) = mapped(&exact, point) else { continue };
            let found = mapping.at(point);
            assert_eq!(found.is_some(), q * q_sign > 0.0, "seed {seed}: {point}");
            let Some(found) = found else { continue };
            let size = pairs.iter().map(|p| p.1.length()).fold(place.length(), f64::max);
            // Near the horizon places are as large as they are.
            let off = (found - place).length() / (size * (1.0 + place.length() / size));
            assert!(off < 1e-11, "seed {seed}: {point} goes to {found}, not {place}");
            let back = mapping.inverse().at(found).expect("it came from there");
            assert!((back - point).length() < 1e-6, "seed {seed}: {point} comes back as {back}");
            compared += 1;
        }
    }
    assert!(compared > 1500, "only {compared} points were compared");
}

fn squares(mapping: &Projective, pairs: &[Pair]) -> f64 {
    pairs.iter().map(|(a, b)| mapping.at(*a).expect("in front").distance_squared(*b)).sum()
}

#[test]
fn more_points_are_met_with_the_least_squares() {
    for seed in 0..100 {
        let rng = &mut Rng::new(seed);
        let truth = Projective::from_pairs(&random_pairs(rng)).expect("two convex quads");
        let noise = [0.0, 1e-3, 0.5][rng.below(3)];
        let mut pairs: Vec<Pair> = Vec::new();
        let corners = convex_quad(rng, dvec2(300.0, 200.0), 8.0);
        for _ in 0..5 + rng.below(40) {
            let [s, t] = [0; 2].map(|_| rng.range(0.0, 1.0));
            let from = corners[0].lerp(corners[1], s).lerp(corners[3].lerp(corners[2], s), t);
            let Some(to) = truth.at(from) else { continue };
            let off = dvec2(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0)) * noise;
            pairs.push((from, to + off));
        }
        if pairs.len() < 5 {
            continue;
        }
        let found = match Projective::from_pairs(&pairs) {
            Ok(found) => found,
            Err(error) => panic!("seed {seed}: {error}"),
        };
        let least = squares(&found, &pairs);
        if noise == 0.0 {
            let size = pairs.iter().map(|p| p.1.length()).fold(0.0, f64::max);
            assert!(least.sqrt() < 1e-8 * size, "seed {seed}: {least}");
            continue;
        }
        // No mapping nearby is better. It is changed where the points are, and so that points move by about a
        // hundredth of the noise.
        let middle = pairs.iter().map(|p| p.0).sum::<DVec2>() / pairs.len() as f64;
        let to_middle = glam::DMat3::from_translation(middle);
        for _ in 0..200 {
            let moved = found.matrix() * to_middle;
            let size = moved.to_cols_array().map(f64::abs);
            let step = from_fn(|i| size[i] * rng.range(-1.0, 1.0) * noise * 1e-5);
            let other = (moved + glam::DMat3::from_cols_array(&step)) * to_middle.inverse();
            let Ok(other) = Projective::new(other) else { continue };
            let others = squares(&other, &pairs);
            assert!(others >= least * (1.0 - 1e-9), "seed {seed}: {others} is less than {least}");
        }
    }
}

#[test]
fn what_no_mapping_follows_from_is_said() {
    use ParameterError::{Degenerate, Folded, NotFinite, TooFewPairs};
    let square = [dvec2(0.0, 0.0), dvec2(1.0, 0.0), dvec2(1.0, 1.0), dvec2(0.0, 1.0)];
    let of = |to: [DVec2; 4]| {
        let pairs: [Pair; 4] = from_fn(|i| (square[i], to[i]));
        let back: [Pair; 4] = from_fn(|i| (to[i], square[i]));
        let (there, back) = (Projective::from_pairs(&pairs), Projective::from_pairs(&back));
        assert_eq!(there.err(), back.err());
        there
    };
    let [a, b, c, d] = square;
    assert!(of([a, b, c, d]).is_ok() && of([d, c, b, a]).is_ok());
    // Crossed, and with a corner inside the triangle of the others.
    assert_eq!(of([a, c, b, d]), Err(Folded));
    assert_eq!(of([a, b, dvec2(0.2, 0.2), d]), Err(Folded));
    // Three on a line, two in one place, all on a line.
    assert_eq!(of([a, b, (b + d) / 2.0, d]), Err(Degenerate));
    assert_eq!(of([a, b, b, d]), Err(Degenerate));
    assert_eq!(of([a, b, b * 2.0, b * 3.0]), Err(Degenerate));
    assert_eq!(of([a, a, a, a]), Err(Degenerate));
    assert_eq!(of([a, dvec2(f64::NAN, 0.0), c, d]), Err(NotFinite { index: 1 }));
    assert_eq!(Projective::from_pairs(&[(a, a); 3]), Err(TooFewPairs { count: 3 }));
    // Five and more on a line leave the mapping free; so do four that are enough with one of them twice.
    let line: Vec<Pair> = (0..7).map(|i| (a + b * f64::from(i), c * f64::from(i))).collect();
    assert_eq!(Projective::from_pairs(&line), Err(Degenerate));
    assert!(Projective::from_pairs(&[(a, a), (b, b), (c, c), (d, d), (d, d)]).is_ok());
    assert_eq!(Projective::new(glam::DMat3::ZERO), Err(Degenerate));
    assert!(Folded.to_string().contains("the mapping folds over"));
}

// ------------------------------------------------------------------------------------------- quads

/// A camera that is rolled about its line of sight, before a plane in space.
fn camera(rng: &mut Rng, roll: f32) -> Mat4 {
    let eye = vec3(rng.range(-2.0, 2.0) as f32, rng.range(-2.0, 2.0) as f32, 3.0);
    glam::camera::rh::proj::directx::perspective(0.9, 1.4, 0.1, 100.0)
        * Mat4::from_rotation_z(roll)
        * glam::camera::rh::view::look_at_mat4(eye, Vec3::ZERO, Vec3::Y)
}

/// Where the ray of a pixel's centre meets the plane of `origin`, `right` and `up`: how far along the two. In f64,
/// from the matrix as it is in f32.
fn on_plane(
    clip: &DMat4,
    [origin, right, up]: [DVec3; 3],
    (x, y): (i32, i32),
    (width, height): (u32, u32),
) -> DVec2 {
    let ndc = dvec2(
        (f64::from(x) + 0.5) / f64::from(width) * 2.0 - 1.0,
        1.0 - (f64::from(y) + 0.5) / f64::from(height) * 2.0,
    );
    let places = [
        clip.mul_vec4(right.extend(0.0)),
        clip.mul_vec4(up.extend(0.0)),
        clip.mul_vec4(origin.extend(1.0)),
    ];
    let row = |i: usize| DVec3::from_array(places.map(|place| place[i]));
    let point = (row(0) - row(3) * ndc.x).cross(row(1) - row(3) * ndc.y);
    dvec2(point.x, point.y) / point.z
}

/// Random quads in space with any texture coordinates, seen by a camera that is rolled in several ways: each pixel
/// has what the one projective mapping says, whose elements exact arithmetic has found from the four corners.
#[test]
fn quads_have_one_projective_mapping_however_they_are_turned() {
    let size = (64, 48);
    let (mut compared, mut worst) = (0, 0.0f64);
    for seed in 0..60 {
        let rng = &mut Rng::new(seed);
        // A plane, and a quad on it, both exact in f32.
        let small = |rng: &mut Rng| rng.whole(-16, 16) as f64 / 16.0;
        let right = DVec3::from_array(from_fn(|_| small(rng))) + DVec3::X * 2.0;
        let up = DVec3::from_array(from_fn(|_| small(rng))) + DVec3::Y * 2.0;
        let places = convex_quad(rng, DVec2::ZERO, 1.0);
        let corners = places.map(|p| (right * p.x + up * p.y).as_vec3());
        let values = convex_quad(rng, dvec2(0.5, 0.5), 0.7);
        let exact = solved_exactly(&from_fn(|i| (places[i], values[i]))).expect("convex");
        let homogeneous = parameters::quad(corners, values.map(DVec2::as_vec2)).expect("convex");
        let exact = exact.map(|element| element.to_f64().expect("a number"));
        for roll in [0.0, 0.5, 1.3, 2.9] {
            let camera = camera(&mut Rng::new(seed), roll);
            let quad: [Vertex<3>; 4] =
                from_fn(|i| Vertex::new(camera * corners[i].extend(1.0), homogeneous[i]));
            let mut scan = ScanConverter::new(Viewport::new(size.0, size.1).expect("small"));
            for span in scan.spans(&quad) {
                for fragment in span.fragments() {
                    let plane = [DVec3::ZERO, right, up];
                    let place = on_plane(&camera.as_dmat4(), plane, (fragment.x, fragment.y), size);
                    let row = |i: usize| {
                        exact[3 * i] * place.x + exact[3 * i + 1] * place.y + exact[3 * i + 2]
                    };
                    let wanted = dvec2(row(0), row(1)) / row(2);
                    let found = Vec2::from(fragment.divided([0, 1], 2).expect("inside")).as_dvec2();
                    worst = worst.max((found - wanted).length());
                    assert!((found - wanted).length() < 1e-5, "seed {seed}: {found} for {wanted}");
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} pixels of quads, worst error {worst:.1e}");
    assert!(compared > 50_000, "only {compared} pixels were compared");
}

#[test]
fn quads_that_fold_are_errors_and_what_folds_with_them_is_not() {
    use ParameterError::{Degenerate, Folded, NotFinite};
    let square = [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0)];
    let dart = [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(0.2, 0.2), vec2(0.0, 1.0)];
    let line = [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(0.5, 0.5), vec2(0.0, 1.0)];
    let crossed = [square[0], square[2], square[1], square[3]];
    let at = |corners: [Vec2; 4]| corners.map(|c| vec3(c.x, c.y, 2.0));
    let errors = [(square, dart, Folded), (dart, square, Folded), (square, crossed, Folded)];
    for (corners, values, error) in errors {
        assert_eq!(parameters::quad(at(corners), values), Err(error));
    }
    for (corners, values) in [(square, line), (line, square), (square, [square[0]; 4])] {
        assert_eq!(parameters::quad(at(corners), values), Err(Degenerate));
    }
    for both in [square, dart, [square[3], square[2], square[1], square[0]]] {
        let found = parameters::quad(at(both), both).expect("the identity");
        assert!(found.iter().all(|v| (v.z - 1.0).abs() < 1e-6), "{found:?}");
    }
    let odd = [square[0], vec2(0.0, f32::INFINITY), square[2], square[3]];
    assert_eq!(parameters::quad(at(square), odd), Err(NotFinite { index: 1 }));
}

#[test]
fn anything_makes_a_mapping_or_an_error() {
    let (mut mappings, mut quads) = (0, 0);
    for seed in 0..30_000 {
        let rng = &mut Rng::new(seed);
        let oddness = [3, 8, 30, 1000][rng.below(4)];
        let some = |rng: &mut Rng| f64::from(number(rng, oddness));
        let pairs: Vec<Pair> = (0..3 + rng.below(5))
            .map(|_| (dvec2(some(rng), some(rng)), dvec2(some(rng), some(rng))))
            .collect();
        if let Ok(mapping) = Projective::from_pairs(&pairs) {
            for (from, _) in &pairs {
                let place = mapping.matrix() * from.extend(1.0);
                assert!(!place.is_nan() && place.z >= 0.0, "seed {seed}: {place} of {pairs:?}");
            }
            let viewport = Viewport::new(9, 9).expect("small").with_corner(-3, 2);
            let picture = mapping.picture(&viewport);
            assert!(picture.iter().all(|v| !v.position.is_nan()), "seed {seed}: {picture:?}");
            mappings += 1;
        }
        let corners = from_fn(|_| Vec3::from_array(from_fn(|_| number(rng, oddness))));
        let values = from_fn(|_| Vec2::from_array(from_fn(|_| number(rng, oddness))));
        if let Ok(quad) = parameters::quad(corners, values) {
            assert!(quad.iter().all(|v| v.is_finite() && v.z > 0.0 && v.z <= 1.0), "{quad:?}");
            quads += 1;
        }
    }
    assert!(mappings > 1000 && quads > 1000, "{mappings} mappings, {quads} quads");
}

// ------------------------------------------------------------------------------------------- warps

/// A smooth picture, of which any place may be asked.
fn shade(u: f32, v: f32) -> glam::Vec4 {
    let wave = |a: f32| 0.5 + 0.4 * (a * std::f32::consts::TAU).sin();
    glam::vec4(wave(2.0 * u + v), wave(v * 3.0), wave(u - 2.0 * v + 0.3), 1.0)
}

/// A picture that is warped, and warped back: the same but for what sampling loses.
#[test]
fn a_picture_goes_there_and_comes_back() {
    let side = 256u32;
    let texture = |color: &dyn Fn(u32, u32) -> glam::Vec4| {
        Texture::from_fn(side, side, color).expect("a small picture").with_wrap(Wrap::Clamp)
    };
    let picture =
        texture(&|x, y| shade((x as f32 + 0.5) / side as f32, (y as f32 + 0.5) / side as f32))
            .with_mipmaps()
            .expect("a small picture")
            .with_mip_filter(MipFilter::Anisotropic { probes: 16 })
            .with_filter(Filter::Bicubic(polyscan::texture::Cubic::CATMULL_ROM));
    let places = [dvec2(40.0, 30.0), dvec2(500.0, 90.0), dvec2(460.0, 480.0), dvec2(20.0, 400.0)];
    let corners = [dvec2(0.0, 0.0), dvec2(1.0, 0.0), dvec2(1.0, 1.0), dvec2(0.0, 1.0)];
    let there =
        Projective::from_pairs(&from_fn::<_, 4, _>(|i| (corners[i], places[i]))).expect("convex");
    let warped = |texture: &Texture, mapping: &Projective, size: u32| {
        let mut frame = Framebuffer::new(size, size, glam::Vec4::W).expect("small");
        let polygon = mapping.picture(&frame.viewport());
        ZBufferRenderer::new(frame.viewport()).draw(
            &mut frame,
            &polygon,
            dynamic(|f| texture.sample_footprint(&f.footprint(0, 1))),
        );
        frame
    };
    let photo = warped(&picture, &there, 512);
    // What the scan converter has drawn is where the mapping says.
    for (u, v) in [(0.25, 0.25), (0.5, 0.5), (0.8, 0.3)] {
        let place = there.at(dvec2(u, v)).expect("in front").floor();
        let (color, _) = photo.pixel(place.x as u32, place.y as u32).expect("inside");
        let wanted = there.inverse().at(place + 0.5).expect("in front").as_vec2();
        assert!((color - shade(wanted.x, wanted.y)).abs().max_element() < 0.01);
    }
    let photo = Texture::new(512, 512, photo.color().to_vec())
        .expect("a small picture")
        .with_wrap(Wrap::Clamp)
        .with_filter(Filter::Bicubic(polyscan::texture::Cubic::CATMULL_ROM));
    let scale =
        |size: f64| Projective::new(glam::DMat3::from_scale(DVec2::splat(size))).expect("regular");
    let back = scale(512.0).then(&there.inverse()).then(&scale(f64::from(side)));
    let back = warped(&photo, &back, side);
    let (mut sum, mut count) = (0.0, 0);
    // Without the border, where the photo has what is beside the picture.
    for (x, y) in (8..side - 8).flat_map(|x| (8..side - 8).map(move |y| (x, y))) {
        let (color, _) = back.pixel(x, y).expect("inside");
        let off = color - picture.texel(x, y);
        sum += f64::from(off.truncate().length_squared());
        count += 3;
    }
    let psnr = 10.0 * (f64::from(count) / sum).log10();
    println!("there and back: {psnr:.1} dB");
    assert!(psnr > 40.0, "there and back: {psnr:.1} dB");
}

/// The polygon of a picture, on a viewport with a corner: at each pixel (u, v) is what the mapping back says, with its
/// derivatives, and what is beyond the horizon is not drawn.
#[test]
fn pictures_are_where_their_mappings_say() {
    let mut compared = 0;
    for seed in 0..100 {
        let rng = &mut Rng::new(seed);
        let corners = [dvec2(0.0, 0.0), dvec2(1.0, 0.0), dvec2(1.0, 1.0), dvec2(0.0, 1.0)];
        let mapping = if rng.once_in(2) {
            let places = convex_quad(rng, dvec2(30.0, 40.0), 40.0);
            Projective::from_pairs(&from_fn::<_, 4, _>(|i| (corners[i], places[i])))
                .expect("convex")
        } else {
            // The horizon runs through the picture.
            let cut = dvec2(rng.range(0.3, 0.7), rng.range(0.3, 0.7));
            let places = convex_quad(rng, dvec2(30.0, 40.0), 40.0);
            Projective::from_pairs(&from_fn::<_, 4, _>(|i| (corners[i] * cut * 0.9, places[i])))
                .expect("convex")
        };
        let corner = (rng.below(20) as i32, rng.below(20) as i32);
        let viewport = Viewport::new(50, 50).expect("small").with_corner(corner.0, corner.1);
        let mut scan = ScanConverter::new(viewport);
        for span in scan.spans(&mapping.picture(&viewport)) {
            for fragment in span.fragments() {
                let point = dvec2(f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5);
                let at = |point: DVec2| mapping.inverse().at(point).expect("it is drawn");
                let Footprint { uv, dx, .. } = fragment.footprint(0, 1);
                assert!(
                    (uv.as_dvec2() - at(point)).length() < 1e-5,
                    "seed {seed}: {uv} at {point}"
                );
                let change = (at(point + dvec2(1e-3, 0.0)) - at(point - dvec2(1e-3, 0.0))) / 2e-3;
                assert!((dx.as_dvec2() - change).length() < 1e-4 * (1.0 + change.length()));
                compared += 1;
            }
        }
    }
    assert!(compared > 30_000, "only {compared} pixels were compared");
}
