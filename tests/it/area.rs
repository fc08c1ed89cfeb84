//! Areas of pixels: against polygons that are cut in rational numbers, sums over meshes, and what samples come near to.

use glam::{Vec4, vec4};
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use polyscan::coverage::AreaTable;
use polyscan::outline::Chain;
use polyscan::render::{
    AreaOrder, AreaRenderer, MultisampleFramebuffer, MultisampleRenderer, Samples,
};
use polyscan::subpixel::SubpixelPoint;
use polyscan::{Cull, FillRule, Framebuffer, Mesh, Vertex, Viewport};

use crate::common::generators::{self, Cells, Rng};
use crate::common::oracle::{self, Depth, Position, Snapped, Window};
use crate::common::{at_pixels, bare, dynamic, in_threads, tally, viewport};

const WINDOW: Window = Window { width: 37, height: 19 };
const FULL: u32 = AreaTable::FULL;

fn outline(polygon: &[Position]) -> Vec<Snapped> {
    oracle::outline(polygon, WINDOW, Depth::ZeroToOne, 65536.0)
}

fn points(outline: &[Snapped]) -> Vec<SubpixelPoint> {
    outline.iter().map(|&(x, y)| SubpixelPoint { x: x as i32, y: y as i32 }).collect()
}

fn pixels() -> impl Iterator<Item = (u32, u32)> {
    (0..WINDOW.height).flat_map(|y| (0..WINDOW.width).map(move |x| (x, y)))
}

type Point = [BigRational; 2];

fn rational(value: i64) -> BigRational {
    BigRational::from_integer(value.into())
}

/// What lies in a strip of one pixel's width along an axis, in subpixels; where it is cut, its sides run along the
/// strip's, there and back, which is no area.
fn strip(polygon: &[Point], axis: usize, pixel: i64) -> Vec<Point> {
    let mut polygon = polygon.to_vec();
    for (sign, limit) in [(1, pixel * 256), (-1, pixel * 256 + 256)] {
        let inside = |p: &Point| (p[axis].clone() - rational(limit)) * rational(sign);
        let mut cut = Vec::new();
        for (i, a) in polygon.iter().enumerate() {
            let b = &polygon[(i + 1) % polygon.len()];
            let (da, db) = (inside(a), inside(b));
            if !da.is_negative() {
                cut.push(a.clone());
            }
            if da.is_negative() != db.is_negative() {
                let t = da.clone() / (da - db);
                cut.push([0, 1].map(|k| a[k].clone() + (b[k].clone() - a[k].clone()) * t.clone()));
            }
        }
        polygon = cut;
    }
    polygon
}

/// The area in pixels, times how often the polygon winds around it.
fn signed_area(polygon: &[Point]) -> BigRational {
    let mut sum = BigRational::zero();
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        sum += a[0].clone() * b[1].clone() - a[1].clone() * b[0].clone();
    }
    sum / rational(2 * 256 * 256)
}

/// The area of contours in each pixel, by the rule of a table.
fn areas(contours: &[Vec<Snapped>], rule: FillRule) -> Vec<BigRational> {
    let exact = |contour: &Vec<Snapped>| -> Vec<Point> {
        contour.iter().map(|&(x, y)| [rational(x), rational(y)]).collect()
    };
    let contours: Vec<_> = contours.iter().map(exact).collect();
    let mut areas = Vec::new();
    for y in 0..WINDOW.height {
        let rows: Vec<_> = contours.iter().map(|c| strip(c, 1, y.into())).collect();
        for x in 0..WINDOW.width {
            let area = rows.iter().map(|row| signed_area(&strip(row, 0, x.into())));
            let sum = area.sum::<BigRational>().abs();
            let (one, two) = (rational(1), rational(2));
            areas.push(match rule {
                FillRule::EvenOdd => {
                    let rest = sum.clone() - (sum / two.clone()).floor() * two.clone();
                    rest.clone().min(two - rest)
                }
                _ => sum.min(one),
            });
        }
    }
    areas
}

/// What a table has for each pixel of the window.
fn found(table: &mut AreaTable) -> Vec<u32> {
    let mut areas = vec![0; (WINDOW.width * WINDOW.height) as usize];
    let columns = table.columns();
    for y in table.rows() {
        let start = y as usize * WINDOW.width as usize;
        let row = &mut areas[start + columns.start as usize..start + columns.end as usize];
        row.copy_from_slice(table.row(y));
    }
    areas
}

tally! {
    struct Seen {
        polygons: u64,
        pixels: u64,
        in_part: u64,
    }
}

/// Contours of one kind or another, as they are rounded.
fn any_contours(rng: &mut Rng) -> Vec<Vec<Snapped>> {
    let sides = 3 + rng.below(6);
    let polygon = match rng.below(8) {
        6 => {
            // A star in a star, turned around or not.
            let mut inner = generators::star(rng, WINDOW, sides);
            let outer = generators::star(rng, WINDOW, sides + 2);
            if rng.once_in(2) {
                inner.reverse();
            }
            return vec![outline(&outer), outline(&inner)];
        }
        kind => generators::of_kind(rng, kind, WINDOW, sides),
    };
    vec![outline(&polygon)]
}

/// Fills a table with contours.
fn fill(table: &mut AreaTable, contours: &[Vec<Snapped>]) {
    let (columns, rows) = (0..WINDOW.width as i32, 0..WINDOW.height as i32);
    if let [contour] = contours {
        return table.fill(&points(contour), columns, rows);
    }
    let (mut all, mut chains) = (Vec::new(), Vec::new());
    for contour in contours {
        all.extend(points(contour));
        all.extend(points(&contour[..1.min(contour.len())]));
        chains.push(Chain { end: all.len(), winding: 1 });
    }
    table.fill_chains(&all, &chains, columns, rows);
}

fn check_areas(seed: u64) -> Seen {
    let rng = &mut Rng::new(seed);
    let contours = any_contours(rng);
    let mut table = AreaTable::new();
    table.fill_rule = [FillRule::NonZero, FillRule::EvenOdd][rng.below(2)];
    fill(&mut table, &contours);
    let edges: usize = contours.iter().map(Vec::len).sum();
    let mut seen = Seen { polygons: 1, ..Seen::default() };
    let expected = areas(&contours, table.fill_rule);
    for (pixel, (found, exact)) in found(&mut table).into_iter().zip(expected).enumerate() {
        let units = (exact * rational(FULL.into())).to_f64().expect("a number");
        let off = (f64::from(found) - units).abs();
        // One unit for each edge that passes through, and none where it is 0 or full.
        let is_whole = units == 0.0 || units == f64::from(FULL);
        let most = if is_whole && edges == 3 { 0.0 } else { edges as f64 * 1.001 };
        assert!(off <= most, "seed {seed}, pixel {pixel}: {found}, but {units}; {contours:?}");
        seen.pixels += u64::from(found > 0);
        seen.in_part += u64::from(found > 0 && found < FULL);
    }
    seen
}

#[test]
fn areas_are_those_of_polygons_cut_in_rational_numbers() {
    let seen = in_threads(0..64, check_areas);
    println!("{seen:?}");
    assert!(seen.pixels > 3000 && seen.in_part > 1000, "{seen:?}");
}

#[test]
#[ignore = "takes minutes"]
fn many_areas_are_those_of_polygons_cut_in_rational_numbers() {
    println!("{:?}", in_threads(1_000_000..1_005_000, check_areas));
}

/// A mesh over the whole window.
fn mesh(rng: &mut Rng) -> (Vec<Position>, Vec<Vec<u32>>) {
    let cells = [Cells::Triangles, Cells::Quads, Cells::Mixed][rng.below(3)];
    let counts = [1 + rng.below(60), 1 + rng.below(30)];
    let mesh = generators::jittered_grid(rng, WINDOW, counts, cells, 5.0, 8.0);
    let faces = mesh.faces.iter().map(|face| face.iter().map(|i| *i as u32).collect()).collect();
    (mesh.positions, faces)
}

#[test]
fn areas_over_a_mesh_are_full_to_the_last_unit() {
    let seen = in_threads(0..50, |seed| {
        let (positions, faces) = mesh(&mut Rng::new(seed));
        let mut table = AreaTable::new();
        let mut sums = vec![0; (WINDOW.width * WINDOW.height) as usize];
        let mut seen = Seen { polygons: faces.len() as u64, ..Seen::default() };
        for face in &faces {
            let polygon: Vec<_> = face.iter().map(|i| positions[*i as usize]).collect();
            fill(&mut table, &[outline(&polygon)]);
            for (sum, area) in sums.iter_mut().zip(found(&mut table)) {
                seen.in_part += u64::from(area > 0 && area < FULL);
                *sum += area;
            }
        }
        for sum in sums {
            assert_eq!(sum, FULL, "seed {seed}");
            seen.pixels += 1;
        }
        seen
    });
    println!("{seen:?}");
    assert!(seen.polygons > 20_000 && seen.in_part > 80_000, "{seen:?}");
}

#[test]
fn a_mesh_from_front_to_back_has_no_seams() {
    for seed in 0..20 {
        let (positions, faces) = mesh(&mut Rng::new(seed));
        let vertices = bare(&positions);
        let mut frame = Framebuffer::new(WINDOW.width, WINDOW.height, Vec4::ZERO).expect("small");
        let mut renderer = AreaRenderer::new(frame.viewport());
        renderer.order = AreaOrder::FrontToBack;
        renderer.draw_mesh(&mut frame, Mesh::new(&vertices, &faces), |_| Vec4::ONE);
        // What comes last finds no room.
        let behind = bare(&positions);
        let red = vec4(1.0, 0.0, 0.0, 1.0);
        renderer.draw_mesh(&mut frame, Mesh::new(&behind, &faces).back_to_front(), |_| red);
        assert!(frame.color().iter().all(|color| *color == Vec4::ONE), "seed {seed}");
    }
}

/// A convex polygon, and the picture of its areas.
fn convex(seed: u64) -> (Vec<Vertex<0>>, Vec<[f64; 2]>, Framebuffer<Vec4>) {
    let polygon = generators::random_convex::<0>(&mut Rng::new(seed), 7, 5.0).positions;
    let in_pixels = |(x, y): Snapped| [x as f64 / 256.0, y as f64 / 256.0];
    let outline = outline(&polygon).into_iter().map(in_pixels).collect();
    let mut frame = Framebuffer::new(WINDOW.width, WINDOW.height, Vec4::ZERO).expect("small");
    let vertices = bare(&polygon);
    AreaRenderer::new(frame.viewport()).draw(&mut frame, &vertices, |_| Vec4::ONE);
    (vertices, outline, frame)
}

/// How much of a pixel whose centre is the origin lies where x cos + y sin <= d, in pixels.
fn half_plane_area(angle: f64, d: f64) -> f64 {
    let square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let side = |p: [f64; 2]| d - p[0] * angle.cos() - p[1] * angle.sin();
    let mut cut: Vec<[f64; 2]> = Vec::new();
    for (i, a) in square.into_iter().enumerate() {
        let b = square[(i + 1) % 4];
        let (da, db) = (side(a), side(b));
        if da >= 0.0 {
            cut.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            let t = da / (da - db);
            cut.push([0, 1].map(|k| a[k] + (b[k] - a[k]) * t));
        }
    }
    let cross = |(i, a): (usize, &[f64; 2])| {
        let b = cut[(i + 1) % cut.len()];
        a[0] * b[1] - a[1] * b[0]
    };
    cut.iter().enumerate().map(cross).sum::<f64>() / 2.0
}

/// The most by which the part of the samples that lie on one side of a line is off the area there: its
/// discrepancy for half-planes, from lines through samples in many directions.
fn discrepancy(samples: Samples) -> f64 {
    let places: Vec<_> = samples.places().iter().map(|p| p.map(|c| f64::from(c) / 256.0)).collect();
    let mut worst = 0.0f64;
    for step in 0..1440 {
        let angle = f64::from(step) * std::f64::consts::TAU / 1440.0;
        let along = |p: &[f64; 2]| p[0] * angle.cos() + p[1] * angle.sin();
        for place in &places {
            let d = along(place);
            let area = half_plane_area(angle, d);
            let share = |is_in: &dyn Fn(f64) -> bool| {
                places.iter().filter(|p| is_in(along(p))).count() as f64 / places.len() as f64
            };
            let [without, with] = [share(&|v| v < d - 1e-9), share(&|v| v <= d + 1e-9)];
            worst = worst.max((without - area).abs()).max((with - area).abs());
        }
    }
    worst
}

/// How many sides of an outline pass through a pixel.
fn sides_through(outline: &[[f64; 2]], x: u32, y: u32) -> usize {
    let ends = outline.iter().cycle().skip(1);
    let passes = |(a, b): (&[f64; 2], &[f64; 2])| {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for (axis, low) in [(0, f64::from(x)), (1, f64::from(y))] {
            let (at, change) = (a[axis], b[axis] - a[axis]);
            if change == 0.0 {
                if at < low || at > low + 1.0 {
                    return false;
                }
                continue;
            }
            let [s, t] = [(low - at) / change, (low + 1.0 - at) / change];
            (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
        }
        from <= to
    };
    outline.iter().zip(ends).filter(|side| passes(*side)).count()
}

/// More samples come nearer to the areas: on the average as fast as samples of a good pattern should, and at a
/// single side never farther off than the pattern is for any line.
#[test]
fn samples_come_near_to_the_area() {
    const ALL: [Samples; 3] = [Samples::Four, Samples::Eight, Samples::Sixteen];
    let limits = ALL.map(discrepancy);
    let (mut squares, mut sums, mut worst) = ([0.0; 3], [0.0; 3], [0.0f64; 3]);
    let (mut edges, mut alone) = (0, 0);
    for seed in 0..80 {
        let (polygon, outline, areas) = convex(seed);
        let pictures = ALL.map(|samples| {
            let frame = MultisampleFramebuffer::new(WINDOW.width, WINDOW.height, samples, 0.0f32);
            let mut frame = frame.expect("a small frame");
            MultisampleRenderer::new(frame.viewport()).draw(&mut frame, &polygon, dynamic(|_| 1.0));
            frame.resolve().expect("a small picture")
        });
        for (x, y) in pixels() {
            let area = f64::from(areas.pixel(x, y).expect("it is there").0.w);
            let is_alone = sides_through(&outline, x, y) == 1;
            edges += u32::from(area > 0.0 && area < 1.0);
            alone += u32::from(is_alone && area > 0.0 && area < 1.0);
            for (i, picture) in pictures.iter().enumerate() {
                let off = f64::from(picture.pixel(x, y).expect("it is there").0) - area;
                (squares[i], sums[i]) = (squares[i] + off * off, sums[i] + off);
                if is_alone {
                    worst[i] = worst[i].max(off.abs());
                }
            }
        }
    }
    let deviations = squares.map(|sum: f64| (sum / f64::from(edges)).sqrt());
    let means = sums.map(|sum: f64| sum / f64::from(edges));
    println!("{edges} pixels, {alone} with one side: deviations {deviations:?}, means {means:?},");
    println!("worst {worst:?}, discrepancies {limits:?}");
    assert!(edges > 1500 && alone > 1000);
    for i in 0..3 {
        // Of s random samples it would be sqrt(1 / 6 s), and the mean's error that over the root of the pixels.
        let random = (1.0 / (6.0 * ALL[i].count() as f64)).sqrt();
        assert!(
            deviations[i] < 0.6 * random && means[i].abs() < 0.005,
            "{deviations:?}, {means:?}"
        );
        // Directions between those of the discrepancy are 1/2880 of a turn off at most.
        assert!(worst[i] <= limits[i] + 0.002, "{worst:?}, {limits:?}");
    }
    assert!(deviations.is_sorted_by(|a, b| a > b), "{deviations:?}");
}

/// Two quads that share a vertical side through the middle of pixel 1, over blue.
fn two_quads(order: AreaOrder) -> Vec<Vec4> {
    let window = Window { width: 3, height: 1 };
    let blue = vec4(0.0, 0.0, 1.0, 1.0);
    let start = if order == AreaOrder::BackToFront { blue } else { Vec4::ZERO };
    let mut frame = Framebuffer::new(3, 1, start).expect("small");
    let mut renderer = AreaRenderer::new(viewport(window));
    renderer.order = order;
    let quad = |left: f32, right: f32| {
        at_pixels(&[[left, 0.0], [right, 0.0], [right, 1.0], [left, 1.0]], window)
    };
    renderer.draw(&mut frame, &quad(0.0, 1.5), |_| vec4(1.0, 0.0, 0.0, 1.0));
    renderer.draw(&mut frame, &quad(1.5, 2.25), |_| vec4(0.0, 1.0, 0.0, 1.0));
    if order == AreaOrder::FrontToBack {
        renderer.draw(&mut frame, &quad(0.0, 3.0), |_| blue);
    }
    frame.color().to_vec()
}

#[test]
fn each_order_joins_colours_as_it_says() {
    let [red, green, blue] = [0, 1, 2].map(|axis| {
        let mut color = Vec4::W;
        color[axis] = 1.0;
        color
    });
    // Over: half red over blue, then half green over that.
    let over = two_quads(AreaOrder::BackToFront);
    assert_eq!(over, [red, green * 0.5 + red * 0.25 + blue * 0.25, green * 0.25 + blue * 0.75]);
    let beside = two_quads(AreaOrder::FrontToBack);
    assert_eq!(beside, [red, red * 0.5 + green * 0.5, green * 0.25 + blue * 0.75]);
}

/// A picture of polygons of all kinds with a parameter, from a corner of a larger one.
fn scene(size: [u32; 2], [x, y]: [i32; 2]) -> Framebuffer<Vec4> {
    let mut frame = Framebuffer::new(size[0], size[1], Vec4::ZERO).expect("small");
    let whole = Viewport::new(150, 110).expect("small").with_corner(-x, -y);
    let mut renderer = AreaRenderer::<1>::new(whole);
    let rng = &mut Rng::new(5);
    for number in 0..60 {
        let mut shape = match number % 3 {
            0 => generators::random_convex::<1>(rng, 6, 20.0),
            1 => generators::through_eye::<1>(rng, 5),
            _ => generators::random_triangle::<1>(rng, 20.0, 1.5),
        };
        let [least, most] = shape
            .parameters
            .iter()
            .fold([f32::MAX, f32::MIN], |[a, b], [v]| [a.min(*v), b.max(*v)]);
        let slack = (most - least) * 1e-5;
        shape.positions.rotate_left(number % 2);
        shape.parameters.rotate_left(number % 2);
        renderer.settings.cull = [Cull::None, Cull::Back][number % 2];
        renderer.draw(&mut frame, &crate::common::vertices(&shape), |fragment| {
            let [value] = fragment.params;
            assert!((least - slack..=most + slack).contains(&value), "{value}, {least} to {most}");
            vec4(value.abs().min(1.0), fragment.depth, 0.5, 1.0) * 0.75
        });
    }
    frame
}

#[test]
fn a_tile_is_the_crop_of_the_whole_and_values_are_those_of_the_polygon() {
    let (whole, tile) = (scene([150, 110], [0, 0]), scene([61, 40], [45, 37]));
    let mut drawn = 0;
    for y in 0..40 {
        for x in 0..61 {
            let expected = whole.pixel(x + 45, y + 37).map(|(color, _)| color);
            assert_eq!(tile.pixel(x, y).map(|(color, _)| color), expected, "{x}, {y}");
            drawn += u32::from(expected != Some(Vec4::ZERO));
        }
    }
    assert!(drawn > 1000, "{drawn}");
}
