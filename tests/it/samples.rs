//! Several samples a pixel: what is covered, compared, shaded and averaged.
//!
//! A sample is to the oracle what a pixel's centre is: a point of the subpixel grid. So coverage, depth and
//! values at samples are those of its exact outline, and of its meeting of ray and plane there.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::generators::{self, Cells, Rng, Shape};
use crate::common::oracle::{self, Depth, FillRule, Position, Sample, Snapped, Window};
use crate::common::{bare, dynamic, dynamic_blocks, in_threads, tally, vertices, viewport};
use glam::{Vec3, Vec4, vec4};
use polyscan::color::Color;
use polyscan::render::{
    Additive, Average, MultisampleFramebuffer, MultisampleRenderer, Over, Samples, ShadingPlace,
};
use polyscan::{
    CoverageRule, DepthTest, FragmentBlock, Framebuffer, Level, Mesh, OutsidePolygon, Texture,
    Vertex,
};

const WINDOW: Window = Window { width: 37, height: 19 };
const GUARD: f64 = 65536.0;
const ALL: [Samples; 3] = [Samples::Four, Samples::Eight, Samples::Sixteen];

fn frame<C: Copy>(samples: Samples, color: C) -> MultisampleFramebuffer<C> {
    MultisampleFramebuffer::new(WINDOW.width, WINDOW.height, samples, color).expect("a small frame")
}

/// A sample on the subpixel grid.
fn place(x: u32, y: u32, [dx, dy]: [i32; 2]) -> Snapped {
    let (centre_x, centre_y) = oracle::centre(x, y);
    (centre_x + i64::from(dx), centre_y + i64::from(dy))
}

fn in_pixels((x, y): Snapped) -> [f64; 2] {
    [x as f64 / 256.0, y as f64 / 256.0]
}

fn pixels() -> impl Iterator<Item = (u32, u32)> {
    (0..WINDOW.height).flat_map(|y| (0..WINDOW.width).map(move |x| (x, y)))
}

fn outline(polygon: &[Position]) -> Vec<Snapped> {
    oracle::outline(polygon, WINDOW, Depth::ZeroToOne, GUARD)
}

tally! {
    struct Seen {
        samples: u64,
        /// Of pixels that are covered in part.
        at_edges: u64,
        faces: u64,
    }
}

/// Directly from the specification of Direct3D 11.3, table "standard multisample patterns".
#[test]
fn the_patterns_are_the_standard_ones() {
    let four = [[-2, -6], [6, -2], [-6, 2], [2, 6]];
    assert_eq!(Samples::Four.places(), four.map(|place| place.map(|c: i32| c * 16)));
    for samples in ALL {
        let places = samples.places();
        assert_eq!(places.len(), samples.count());
        // Each row and each column of the pixel's grid has as many samples as any other.
        for axis in 0..2 {
            let mut seen: Vec<_> = places
                .iter()
                .map(|place| (place[axis] + 128) / (256 / samples.count() as i32))
                .collect();
            seen.sort_unstable();
            assert_eq!(seen, (0..samples.count() as i32).collect::<Vec<_>>(), "{samples:?}");
        }
    }
}

/// A polygon of any kind.
fn any_polygon(rng: &mut Rng) -> Vec<Position> {
    let sides = 3 + rng.below(8);
    match rng.below(8) {
        6 => generators::random_convex::<0>(rng, sides, 20.0).positions,
        kind => generators::of_kind(rng, kind, WINDOW, sides),
    }
}

/// Checks each sample of a polygon that is drawn alone.
fn check_coverage(seed: u64) -> Seen {
    let rng = &mut Rng::new(seed);
    let polygon = any_polygon(rng);
    let samples = ALL[rng.below(3)];
    let even_odd = rng.once_in(2);
    let mut frame = frame(samples, 0u32);
    let mut renderer = MultisampleRenderer::new(frame.viewport());
    let mut rule = FillRule::NonZero;
    if even_odd {
        (renderer.settings.fill_rule, rule) = (polyscan::FillRule::EvenOdd, FillRule::EvenOdd);
    }
    renderer.draw(&mut frame, &bare(&polygon), dynamic(|_| Additive(1)));
    let outline = outline(&polygon);
    let mut seen = Seen { faces: 1, ..Seen::default() };
    for (x, y) in pixels() {
        let mut covered = 0;
        for (sample, offset) in samples.places().iter().enumerate() {
            let expected = oracle::covers(&outline, place(x, y, *offset), rule);
            let found = frame.sample(x, y, sample).map(|(color, _)| color);
            assert_eq!(found, Some(u32::from(expected)), "seed {seed}, {x}, {y}, {sample}");
            covered += u64::from(expected);
        }
        seen.samples += covered;
        if covered != samples.count() as u64 {
            seen.at_edges += covered;
        }
    }
    seen
}

#[test]
fn each_sample_is_covered_as_exact_arithmetic_says() {
    let seen = in_threads(0..1500, check_coverage);
    println!("{seen:?}");
    assert!(seen.samples > 500_000 && seen.at_edges > 50_000, "{seen:?}");
}

#[test]
#[ignore = "takes minutes"]
fn many_polygons_are_covered_as_exact_arithmetic_says() {
    println!("{:?}", in_threads(1_000_000..1_100_000, check_coverage));
}

#[test]
fn polygons_that_share_edges_cover_each_sample_once() {
    let seen = in_threads(0..200, |seed| {
        let rng = &mut Rng::new(seed);
        let cells = [Cells::Triangles, Cells::Quads, Cells::Mixed][rng.below(3)];
        let counts = [1 + rng.below(40), 1 + rng.below(20)];
        let mesh = generators::jittered_grid(rng, WINDOW, counts, cells, 5.0, 8.0);
        let samples = ALL[rng.below(3)];
        let mut frame = frame(samples, 0u32);
        let mut renderer = MultisampleRenderer::new(frame.viewport());
        renderer.depth_test = DepthTest::Always;
        let vertices = bare(&mesh.positions);
        let faces: Vec<Vec<u32>> =
            mesh.faces.iter().map(|face| face.iter().map(|i| *i as u32).collect()).collect();
        renderer.draw(&mut frame, Mesh::new(&vertices, &faces), dynamic(|_| Additive(1)));
        for (x, y) in pixels() {
            for sample in 0..samples.count() {
                let (count, _) = frame.sample(x, y, sample).expect("it is there");
                assert_eq!(count, 1, "seed {seed}, {x}, {y}, {sample}");
            }
        }
        Seen { faces: faces.len() as u64, ..Seen::default() }
    });
    assert!(seen.faces > 20_000, "{seen:?}");
}

fn sample(shape: &Shape<1>, point: [f64; 2]) -> Option<Sample<1>> {
    let triple = oracle::best_triple(&shape.positions)?;
    oracle::sample(&shape.positions, &shape.parameters, triple, WINDOW, point)
}

/// Checks which face each sample shows, its depth, and the parameter of each pixel and face.
fn check_scene(seed: u64) -> Seen {
    let rng = &mut Rng::new(seed);
    let samples = ALL[rng.below(3)];
    let count = 1 + rng.below(5);
    let shapes: Vec<Shape<1>> = (0..count)
        .map(|_| match rng.below(3) {
            0 => generators::random_convex(rng, 5, 20.0),
            1 => generators::through_eye(rng, 4),
            _ => generators::random_triangle(rng, 100.0, 1.5),
        })
        .collect();
    let (mut all, mut faces) = (Vec::new(), Vec::new());
    for shape in &shapes {
        let first = all.len() as u32;
        all.extend(vertices(shape));
        faces.push((first..all.len() as u32).collect::<Vec<_>>());
    }
    let mut frame = frame(samples, (u32::MAX, 0.0f32, 0.0f32));
    let mut renderer = MultisampleRenderer::new(frame.viewport());
    renderer.draw(&mut frame, Mesh::new(&all, &faces), |f| (f.face, f.params[0], f.w));
    let outlines: Vec<_> = shapes.iter().map(|shape| outline(&shape.positions)).collect();
    let covers = |face: usize, point| oracle::covers(&outlines[face], point, FillRule::NonZero);
    let mut seen = Seen::default();
    for (x, y) in pixels() {
        for (number, offset) in samples.places().iter().enumerate() {
            let point = place(x, y, *offset);
            let mut there: Vec<_> = (0..shapes.len())
                .filter(|face| covers(*face, point))
                .filter_map(|face| Some((face, sample(&shapes[face], in_pixels(point))?)))
                .collect();
            there.sort_by(|(_, a), (_, b)| a.z_over_w.total_cmp(&b.z_over_w));
            let ((face, param, w), depth) = frame.sample(x, y, number).expect("it is there");
            let at = format!("seed {seed}, {x}, {y}, {number}: face {face} {depth} of {there:?}");
            let Some((_, nearest)) = there.first() else {
                assert!(face == u32::MAX && depth == 1.0, "{at}");
                continue;
            };
            let own = there.iter().find(|(number, _)| *number as u32 == face);
            let (_, own) = own.unwrap_or_else(|| panic!("{at}"));
            // What rounding has put outside has the depth of the nearest vertex.
            let slack = if own.is_inside() && nearest.is_inside() { 2e-6 } else { 1e-3 };
            assert!(own.z_over_w <= nearest.z_over_w + slack, "{at}");
            assert!((f64::from(depth) - own.z_over_w.clamp(0.0, 1.0)).abs() < slack, "{at}");
            // All samples of the pixel that show the face have the value at the centroid of those that
            // it covers.
            let covered: Vec<_> = samples
                .places()
                .iter()
                .map(|offset| place(x, y, *offset))
                .filter(|point| covers(face as usize, *point))
                .collect();
            let whole = covered.len() == samples.count();
            let sum = covered.iter().fold((0, 0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
            let mean = [sum.0, sum.1].map(|c| c as f64 / 256.0 / covered.len() as f64);
            let centroid = if whole { in_pixels(oracle::centre(x, y)) } else { mean };
            let exact = sample(&shapes[face as usize], centroid).expect("it has a plane");
            if exact.is_inside() {
                let largest = shapes[face as usize].parameters.iter().map(|p| p[0].abs());
                let largest = f64::from(largest.fold(0.0, f32::max));
                let off = (f64::from(param) - exact.values[0]).abs();
                assert!(off <= 1e-5 * largest, "{at}: {param} for {exact:?}");
                assert!(
                    (f64::from(w) - exact.w).abs() <= 1e-5 * exact.w,
                    "{at}: {w} for {exact:?}"
                );
            }
            seen.samples += 1;
            seen.at_edges += u64::from(!whole);
        }
    }
    seen
}

#[test]
fn each_sample_has_the_nearest_face_its_depth_and_the_value_at_the_centroid() {
    let seen = in_threads(0..200, check_scene);
    println!("{seen:?}");
    assert!(seen.samples > 100_000 && seen.at_edges > 10_000, "{seen:?}");
}

/// Two quads that fill the picture, the second of which comes nearer along a line: within pixels, where all
/// centres of 16 pixels are on one side of it and some of their samples on the other.
#[test]
fn planes_that_cross_within_pixels_cross_at_each_sample() {
    let mut near = 0;
    for seed in 0..300 {
        let rng = &mut Rng::new(seed);
        let samples = ALL[rng.below(3)];
        let slope = [rng.range(-0.3, 0.3), rng.range(-0.3, 0.3)];
        let slope = [[0.0, slope[1]], [slope[0], 0.0], slope][rng.below(3)];
        let middle = [rng.range(-0.9, 0.9), rng.range(-0.9, 0.9)];
        // Numbers that f32 has exactly, so that the planes are those of the vertices.
        let [slope, middle] = [slope, middle].map(|pair| pair.map(|c| (c * 256.0).round() / 256.0));
        let z = |x: f64, y: f64| 0.5 + slope[0] * (x - middle[0]) + slope[1] * (y - middle[1]);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        // A frustum as deep as the plane: no near or far plane cuts it.
        let plane = |z: &dyn Fn(f64, f64) -> f64| {
            corners.map(|(x, y)| {
                let depth = z(x, y) / 4.0 + 0.375;
                Vertex::new(vec4(x as f32, y as f32, depth as f32, 1.0), [])
            })
        };
        let mut frame = frame(samples, 0u32);
        let mut renderer = MultisampleRenderer::new(frame.viewport());
        renderer.draw(&mut frame, &plane(&|_, _| 0.5), dynamic(|_| 1));
        if rng.once_in(2) {
            renderer.draw(&mut frame, &plane(&z), dynamic(|_| 2));
        } else {
            renderer.draw_blocks(
                &mut frame,
                &plane(&z),
                dynamic_blocks(|_, colors| colors.fill(2)),
            );
        }
        for (x, y) in pixels() {
            for (sample, offset) in samples.places().iter().enumerate() {
                let [px, py] = in_pixels(place(x, y, *offset));
                let at = (
                    px / f64::from(WINDOW.width) * 2.0 - 1.0,
                    1.0 - py / f64::from(WINDOW.height) * 2.0,
                );
                let ahead = 0.5 - z(at.0, at.1);
                // Of a plane without a slope, and at the line itself, rounding decides.
                if ahead.abs() > 1e-5 {
                    let expected = if ahead > 0.0 { 2 } else { 1 };
                    let found = frame.sample(x, y, sample).map(|(color, _)| color);
                    assert_eq!(found, Some(expected), "seed {seed}, {x}, {y}, {sample}");
                    near += u64::from(ahead.abs() < 0.005);
                }
            }
        }
    }
    assert!(near > 10_000, "{near}");
}

/// A texture's paint is looked up once for a pixel, and drawn at all samples that are seen.
#[test]
fn textures_paint_samples_as_colours_do() {
    let texel = |x: u32, y: u32| vec4(x as f32 / 8.0, y as f32 / 8.0, (x + y) as f32 / 16.0, 1.0);
    let texture = Texture::from_fn(8, 8, texel).expect("a small picture");
    for seed in 0..40 {
        let rng = &mut Rng::new(seed);
        let shapes: Vec<_> =
            (0..8).map(|_| generators::random_triangle::<2>(rng, 20.0, 1.5)).collect();
        let samples = ALL[rng.below(3)];
        let mut frames = [(); 2].map(|()| frame(samples, [0u8; 4]));
        let mut renderer = MultisampleRenderer::new(frames[0].viewport());
        for shape in &shapes {
            let triangle = vertices(shape);
            renderer.draw(&mut frames[0], &triangle, dynamic(|f| texture.paint(f.params)));
        }
        let mut renderer = MultisampleRenderer::new(frames[1].viewport());
        for shape in &shapes {
            let triangle = vertices(shape);
            renderer.draw(
                &mut frames[1],
                &triangle,
                dynamic(|f| texture.sample(f.params.into()).to_srgb8()),
            );
        }
        for (x, y) in pixels() {
            for sample in 0..samples.count() {
                let [paint, color] = frames.each_ref().map(|frame| frame.sample(x, y, sample));
                assert_eq!(paint, color, "seed {seed}, {x}, {y}, {sample}");
            }
        }
    }
}

/// The samples say what is covered, whatever rule the settings have for pixels.
#[test]
fn no_rule_for_pixels_changes_samples() {
    for seed in 0..40 {
        let polygon = bare(&any_polygon(&mut Rng::new(seed)));
        let draw = |rule| {
            let mut frame = frame(Samples::Four, 0u32);
            let mut renderer = MultisampleRenderer::new(frame.viewport());
            renderer.settings.coverage_rule = rule;
            renderer.draw(&mut frame, &polygon, dynamic(|_| 1));
            pixels()
                .flat_map(|(x, y)| (0..4).map(move |sample| (x, y, sample)))
                .map(|(x, y, sample)| frame.sample(x, y, sample))
                .collect::<Vec<_>>()
        };
        let centres = draw(CoverageRule::Centre);
        for rule in [CoverageRule::Outer(OutsidePolygon::Clamp), CoverageRule::Inner] {
            assert!(draw(rule) == centres, "seed {seed}: other samples by {rule:?}");
        }
    }
}

/// A quad with a value that is its distance from the left, in pixels.
fn quad_from(left: f32, right: f32) -> [Vertex<1>; 4] {
    let x = |pixels: f32| pixels * 2.0 / WINDOW.width as f32 - 1.0;
    [(left, -1.0), (right, -1.0), (right, 1.0), (left, 1.0)]
        .map(|(pixels, y)| Vertex::new(vec4(x(pixels), y, 0.5, 1.0), [pixels]))
}

#[test]
fn a_pixel_is_shaded_once_where_that_is_asked_for() {
    for samples in ALL {
        for place in [ShadingPlace::Centroid, ShadingPlace::Centre] {
            let mut frame = frame(samples, 0.0f32);
            let mut renderer = MultisampleRenderer::new(frame.viewport());
            renderer.shading = place;
            let calls = AtomicUsize::new(0);
            // Right of the middle of the sixth pixel.
            renderer.draw(
                &mut frame,
                &quad_from(5.5, 9.0),
                dynamic(|fragment| {
                    calls.fetch_add(1, Ordering::Relaxed);
                    fragment.params[0]
                }),
            );
            assert_eq!(calls.into_inner(), 4 * WINDOW.height as usize, "{samples:?}");
            let right: Vec<_> = (0..samples.count())
                .filter(|i| samples.places()[*i][0] >= 0)
                .map(|i| (i, frame.sample(5, 3, i).expect("it is there").0))
                .collect();
            let x = right.iter().map(|(i, _)| samples.places()[*i][0] as f32 / 256.0);
            let centroid = 5.5 + x.sum::<f32>() / right.len() as f32;
            let expected = if place == ShadingPlace::Centroid { centroid } else { 5.5 };
            assert!(right.iter().all(|(_, v)| (v - expected).abs() < 1e-5), "{right:?}");
            assert_eq!(frame.sample(6, 3, 0), Some((6.5, 0.5)));
        }
    }
}

#[test]
fn discarded_blended_and_alpha_to_coverage() {
    for samples in ALL {
        let count = samples.count();
        let mut frame = frame(samples, vec4(0.0, 0.0, 1.0, 1.0));
        let mut renderer = MultisampleRenderer::new(frame.viewport());
        let quad = quad_from(0.0, WINDOW.width as f32);
        renderer.draw(&mut frame, &quad, |f| (f.x == 3).then_some(Vec4::X));
        for (x, y) in pixels() {
            let expected = if x == 3 { (Vec4::X, 0.5) } else { (vec4(0.0, 0.0, 1.0, 1.0), 1.0) };
            assert!((0..count).all(|i| frame.sample(x, y, i) == Some(expected)));
        }
        renderer.draw_blocks(&mut frame, &quad, |block: &mut FragmentBlock<'_, 1>, colors| {
            let (x, _) = block.position(0);
            block.visible &= !(1 << (7 - x).clamp(0, 31));
            colors.fill(Vec4::Y);
        });
        assert_eq!(frame.sample(7, 1, 0).expect("it is there").1, 1.0);
        assert_eq!(frame.sample(6, 1, 0), Some((Vec4::Y, 0.5)));
        renderer.clear(&mut frame, Vec4::ZERO);
        renderer.draw_alpha_to_coverage(&mut frame, &quad, |f| {
            (Over(Vec4::ONE), f.params[0] / WINDOW.width as f32)
        });
        let picture = frame.resolve().expect("a small picture");
        for (x, y) in pixels() {
            let alpha = (x as f32 + 0.5) / WINDOW.width as f32;
            let drawn = (0..count).filter(|i| frame.sample(x, y, *i) == Some((Vec4::ONE, 0.5)));
            assert_eq!(drawn.count(), (alpha * count as f32).round() as usize, "{x}");
            let (color, _) = picture.pixel(x, y).expect("it is there");
            assert!((color.w - alpha).abs() <= 0.5001 / count as f32);
        }
        renderer.clear(&mut frame, Vec4::ZERO);
        renderer.draw_depth(&mut frame, &quad);
        assert_eq!(frame.sample(36, 18, count - 1), Some((Vec4::ZERO, 0.5)));
        assert_eq!(frame.sample(37, 18, 0), None);
        assert_eq!(frame.sample(36, 18, count), None);
    }
}

#[test]
fn colours_are_averaged_as_light() {
    let rng = &mut Rng::new(5);
    for count in [1, 4, 8, 16] {
        let colors: Vec<[u8; 4]> =
            (0..count).map(|_| rng.bits().to_le_bytes()[..4].try_into().expect("4")).collect();
        let light = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let code = |l: f64| {
            let c = if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
            c * 255.0
        };
        let n = f64::from(count);
        let alpha = colors.iter().map(|c| f64::from(c[3]) / 255.0).sum::<f64>() / n;
        let average = <[u8; 4]>::average(&colors);
        assert!((f64::from(average[3]) - alpha * 255.0).abs() < 0.501);
        for channel in 0..3 {
            let sum: f64 = colors.iter().map(|c| light(c[channel]) * f64::from(c[3]) / 255.0).sum();
            let expected = if alpha > 0.0 { code(sum / n / alpha) } else { 0.0 };
            assert!((f64::from(average[channel]) - expected).abs() < 0.51, "{colors:?}");
        }
        let floats: Vec<f32> = (0..count).map(|_| rng.range(0.0, 1.0) as f32).collect();
        let mean = floats.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
        assert!((f64::from(f32::average(&floats)) - mean).abs() < 1e-6);
        let same = rng.range(0.0, 9.0) as f32;
        assert_eq!(Vec3::average(&vec![Vec3::splat(same); count as usize]), Vec3::splat(same));
        assert_eq!(<[f32; 2]>::average(&vec![[same, 0.1]; count as usize]), [same, 0.1]);
        assert_eq!(<[u8; 4]>::average(&vec![[9, 8, 7, 3]; count as usize]), [9, 8, 7, 3]);
    }
}

/// The area of a polygon within a pixel, in pixels, by cutting it at the pixel's sides in f64.
fn area_in_pixel(outline: &[[f64; 2]], x: u32, y: u32) -> f64 {
    let mut polygon = outline.to_vec();
    for (axis, side) in [(0, f64::from(x)), (1, f64::from(y))] {
        for (sign, limit) in [(1.0, side), (-1.0, -side - 1.0)] {
            let inside = |p: [f64; 2]| p[axis] * sign - limit;
            let mut cut = Vec::new();
            for (i, &a) in polygon.iter().enumerate() {
                let b = polygon[(i + 1) % polygon.len()];
                let (da, db) = (inside(a), inside(b));
                if da >= 0.0 {
                    cut.push(a);
                }
                if (da >= 0.0) != (db >= 0.0) {
                    let t = da / (da - db);
                    cut.push([0, 1].map(|k| a[k] + (b[k] - a[k]) * t));
                }
            }
            polygon = cut;
        }
    }
    let cross = |(i, a): (usize, &[f64; 2])| {
        let b = polygon[(i + 1) % polygon.len()];
        a[0] * b[1] - a[1] * b[0]
    };
    polygon.iter().enumerate().map(cross).sum::<f64>().abs() / 2.0
}

/// The part of a pixel that s samples say is covered is near to its area, and nearer the more they are.
#[test]
fn more_samples_are_nearer_to_the_area() {
    let (mut errors, mut worst) = ([0.0f64; 3], [0.0f64; 3]);
    let mut edges = 0;
    for seed in 0..60 {
        let rng = &mut Rng::new(seed);
        let polygon = generators::random_convex::<0>(rng, 7, 5.0).positions;
        let outline: Vec<_> = outline(&polygon).into_iter().map(in_pixels).collect();
        let pictures = ALL.map(|samples| {
            let mut frame = frame(samples, 0.0f32);
            MultisampleRenderer::new(frame.viewport()).draw(
                &mut frame,
                &bare(&polygon),
                dynamic(|_| 1.0),
            );
            frame.resolve().expect("a small picture")
        });
        for (x, y) in pixels() {
            let area = area_in_pixel(&outline, x, y);
            edges += u32::from(area > 0.0 && area < 1.0);
            for (i, picture) in pictures.iter().enumerate() {
                let (covered, _) = picture.pixel(x, y).expect("it is there");
                let off = (f64::from(covered) - area).abs();
                errors[i] += off * off;
                worst[i] = worst[i].max(off);
            }
        }
    }
    let deviations = errors.map(|error| (error / f64::from(edges)).sqrt());
    println!("{edges} pixels, standard deviations {deviations:?}, worst {worst:?}");
    // Of s random samples it would be about 0.41 / sqrt(s); these are better.
    for (deviation, samples) in deviations.iter().zip(ALL) {
        assert!(*deviation < 0.25 / (samples.count() as f64).sqrt(), "{deviations:?}");
    }
    assert!(edges > 1000 && deviations.is_sorted_by(|a, b| a > b), "{deviations:?}");
}

/// A picture of polygons of all kinds, through blocks or fragment by fragment.
fn picture(
    (width, height): (u32, u32),
    corner: (i32, i32),
    level: Option<Level>,
    one_by_one: bool,
) -> MultisampleFramebuffer<[f32; 4]> {
    let rng = &mut Rng::new(8);
    let mut frame = MultisampleFramebuffer::new(width, height, Samples::Eight, [0.0; 4])
        .expect("a small frame");
    let whole = polyscan::Viewport::new(150, 110).expect("small");
    let mut renderer = MultisampleRenderer::new(whole.with_corner(-corner.0, -corner.1));
    renderer.simd_level = level.unwrap_or(renderer.simd_level);
    let (mut all, mut faces) = (Vec::new(), Vec::new());
    for number in 0..300 {
        let mut shape: Shape<2> = match number % 5 {
            0 => generators::through_eye(rng, 5),
            1 => generators::random_convex(rng, 6, 30.0),
            _ => generators::random_triangle(rng, 100.0, 1.0),
        };
        if number % 5 > 1 {
            // Small ones, too.
            let scale = rng.octaves(0.01, 1.0) as f32;
            let by = [rng.range(-0.9, 0.9) as f32, rng.range(-0.9, 0.9) as f32];
            for p in &mut shape.positions {
                (p[0], p[1]) = (p[0] * scale + by[0] * p[3], p[1] * scale + by[1] * p[3]);
            }
        }
        if number % 7 == 1 {
            // Not affine.
            shape.parameters[0][1] += 1.0;
        }
        let first = all.len() as u32;
        all.extend(vertices(&shape));
        faces.push((first..all.len() as u32).collect::<Vec<_>>());
    }
    let shade = |f: &polyscan::Fragment<'_, 2>| [f.params[0], f.params[1], f.w, f.depth];
    if one_by_one {
        for face in &faces {
            renderer.draw(&mut frame, Mesh::new(&all, [face]), shade);
        }
    } else {
        renderer.draw(&mut frame, Mesh::new(&all, &faces), shade);
    }
    frame
}

/// A sample, as bits.
fn bits(frame: &MultisampleFramebuffer<[f32; 4]>, x: u32, y: u32, sample: usize) -> [u32; 5] {
    let ([a, b, c, d], depth) = frame.sample(x, y, sample).expect("it is there");
    [a, b, c, d, depth].map(f32::to_bits)
}

#[test]
fn the_same_bits_in_tiles_at_all_levels_and_face_by_face() {
    let whole = picture((150, 110), (0, 0), None, false);
    let others = [
        picture((150, 110), (0, 0), Some(Level::baseline()), false),
        picture((150, 110), (0, 0), None, true),
    ];
    let tile = picture((61, 40), (45, 37), None, false);
    let mut drawn = 0;
    for y in 0..110 {
        for x in 0..150 {
            for sample in 0..8 {
                let expected = bits(&whole, x, y, sample);
                drawn += u32::from(expected[4] != 1.0f32.to_bits());
                for other in &others {
                    assert_eq!(bits(other, x, y, sample), expected, "{x}, {y}, {sample}");
                }
                if (45..106).contains(&x) && (37..77).contains(&y) {
                    assert_eq!(bits(&tile, x - 45, y - 37, sample), expected, "{x}, {y}");
                }
            }
        }
    }
    assert!(drawn > 50_000, "{drawn}");
    assert_eq!(viewport(WINDOW).rect().width, WINDOW.width);
}

/// White on a transparent background has no fringe on any background: what is saved is white of some alpha.
#[test]
fn what_is_saved_on_transparency_has_no_fringe() {
    let mut frame = frame(Samples::Sixteen, Vec4::ZERO);
    let mut renderer = MultisampleRenderer::new(frame.viewport());
    let rng = &mut Rng::new(2);
    let polygon = bare(&generators::star(rng, WINDOW, 9));
    renderer.draw(&mut frame, &polygon, |_| Vec4::ONE);
    let picture: Framebuffer<Vec4> = frame.resolve().expect("a small picture");
    let mut partly = 0;
    for (x, y) in pixels() {
        use polyscan::color::Color;
        let (color, _) = picture.pixel(x, y).expect("it is there");
        let [r, g, b, a] = color.to_srgb8();
        assert!(a == 0 || [r, g, b] == [255; 3], "{:?}", [r, g, b, a]);
        partly += u32::from(a > 0 && a < 255);
    }
    assert!(partly > 20);
}
