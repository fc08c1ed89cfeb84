//! How time grows with pixels, polygons, parameters, depth complexity, sides, and the triangles of OBJ files,
//! on one thread.
//!
//! ```text
//! cargo bench -p polyscan-benches --bench growth
//! cargo bench -p polyscan-benches --bench growth -- sides
//! ```
//!
//! Prints tables, and draws them to `target/growth/*.svg`. A series ends with its exponents: k in
//! time = c size^k, fitted to all of its points, and between the last two. What each call costs
//! whatever its size makes the first one small; a term worse than linear would bring the second
//! one above 1, by more than noise.
//!
//! Times are those of the processor, and the least of all runs in half a second: what else the
//! machine does would count more where a run is long enough to be interrupted.

use std::error::Error;
use std::f32::consts::TAU;
use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use cpu_time::ProcessTime;
use glam::Vec4;
use plotters::prelude::*;
use polyscan::fragment::LANES;
use polyscan::{
    FillRule, FragmentBlock, Framebuffer, Mesh, ScanConverter, ScanlineRenderer, SizeError, Vertex,
    Viewport, ZBufferRenderer,
};

/// Times of one way to do something, against its size.
struct Series {
    name: &'static str,
    points: Vec<(f64, Duration)>,
}

/// What is varied: the name of the axis, the unit of sizes, and the ways.
type Axis = (&'static str, &'static str, fn() -> Result<Vec<Series>, Box<dyn Error>>);

const AXES: [Axis; 6] = [
    ("pixels", "pixel", pixels),
    ("polygons", "triangle", polygons),
    ("parameters", "value", parameters),
    ("depth", "layer", depth),
    ("sides", "side", sides),
    ("loading", "triangle", loading),
];

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    // Cargo runs benchmarks in the folder of their package, but the plots belong into `target`.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("growth");
    fs::create_dir_all(&folder)?;
    let chosen: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    for (name, unit, measure) in AXES {
        if !chosen.is_empty() && !chosen.iter().any(|chosen| chosen == name) {
            continue;
        }
        let all = measure()?;
        for series in &all {
            series.print(name, unit);
        }
        let path = folder.join(format!("{name}.svg"));
        plot(&path, name, unit, &all).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

impl Series {
    fn new(name: &'static str) -> Self {
        Self { name, points: Vec::new() }
    }

    fn print(&self, axis: &str, unit: &str) {
        println!("\n{axis}: {}", self.name);
        for &(size, time) in &self.points {
            let each = time.as_secs_f64() * 1e9 / size;
            println!("{size:>12} {:>12.4} ms {each:>12.3} ns a {unit}", milliseconds(time));
        }
        let last = &self.points[self.points.len().saturating_sub(2)..];
        println!("    exponent {:.2}, at the end {:.2}", exponent(&self.points), exponent(last));
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The slope of the line of least squares through the points' logarithms.
fn exponent(points: &[(f64, Duration)]) -> f64 {
    let logarithms = || points.iter().map(|(size, time)| (size.ln(), time.as_secs_f64().ln()));
    let count = points.len() as f64;
    let (x, y) = logarithms().fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x, sum.1 + y));
    let (x, y) = (x / count, y / count);
    let above: f64 = logarithms().map(|(a, b)| (a - x) * (b - y)).sum();
    above / logarithms().map(|(a, _)| (a - x) * (a - x)).sum::<f64>()
}

/// Draws the series on logarithmic axes, with a line of linear growth to compare.
fn plot(path: &Path, axis: &str, unit: &str, all: &[Series]) -> Result<(), Box<dyn Error>> {
    let points = || all.iter().flat_map(|series| &series.points);
    let sizes = points().map(|point| point.0).fold((f64::MAX, 0f64), bounds);
    let times = points().map(|point| milliseconds(point.1)).fold((f64::MAX, 0f64), bounds);
    let area = SVGBackend::new(path, (800, 600)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(format!("Time against {axis}"), ("sans-serif", 24))
        .margin(20)
        .x_label_area_size(50)
        .y_label_area_size(80)
        .build_cartesian_2d(
            (sizes.0..sizes.1 * 1.1).log_scale(),
            (times.0 / 2.0..times.1 * 2.0).log_scale(),
        )?;
    let mesh = &mut chart.configure_mesh();
    mesh.x_desc(format!("{unit}s")).y_desc("milliseconds").label_style(("sans-serif", 15));
    mesh.x_labels(6).y_labels(6).max_light_lines(0);
    mesh.x_label_formatter(&|size| format!("{size:.0}"));
    mesh.y_label_formatter(&f64::to_string).draw()?;
    for (series, color) in all.iter().zip([RED, BLUE, GREEN].into_iter().cycle()) {
        let points = || series.points.iter().map(|&(size, time)| (size, milliseconds(time)));
        let label = format!("{}: exponent {:.2}", series.name, exponent(&series.points));
        chart
            .draw_series(LineSeries::new(points(), color))?
            .label(label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color));
        chart.draw_series(points().map(|at| Circle::new(at, 3, color.filled())))?;
    }
    // From the first series' last point downwards.
    if let Some(&(size, time)) = all.first().and_then(|series| series.points.last()) {
        let line = |at: f64| (at, milliseconds(time) / size * at);
        let least = sizes.0.max(size * times.0 / milliseconds(time) / 2.0);
        chart
            .draw_series(LineSeries::new([line(least), line(size)], BLACK.mix(0.4)))?
            .label("linear")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], BLACK.mix(0.4)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE)
        .border_style(BLACK)
        .label_font(("sans-serif", 15))
        .draw()?;
    Ok(area.present()?)
}

fn bounds((min, max): (f64, f64), value: f64) -> (f64, f64) {
    (min.min(value), max.max(value))
}

/// The least time of `run`, each after `prepare`, which does not count.
fn time<S>(state: &mut S, prepare: impl Fn(&mut S), run: impl Fn(&mut S)) -> Duration {
    const BUDGET: Duration = Duration::from_millis(500);
    prepare(state);
    // What it takes to be warm does not count either.
    run(state);
    let mut least = Duration::MAX;
    let begin = ProcessTime::now();
    while least == Duration::MAX || begin.elapsed() < BUDGET {
        prepare(state);
        let start = ProcessTime::now();
        run(state);
        least = least.min(start.elapsed());
    }
    least
}

/// A frame, and the renderer to draw on it.
type Canvas<const N: usize> = (Framebuffer<u32>, ZBufferRenderer<N>);

fn canvas<const N: usize>(size: u32) -> Result<Canvas<N>, SizeError> {
    let frame = Framebuffer::new(size, size, 0)?;
    let renderer = ZBufferRenderer::new(frame.viewport());
    Ok((frame, renderer))
}

fn clear<const N: usize>((frame, _): &mut Canvas<N>) {
    frame.clear(0, 1.0);
}

/// A square over all of the screen at a depth, in perspective.
fn quad<const N: usize>(depth: f32) -> [Vertex<N>; 4] {
    [(-1.0, -1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 4.0), (-1.0, 1.0, 4.0)].map(|(x, y, w)| {
        Vertex {
            position: Vec4::new(x * w, y * w, depth * w, w),
            params: std::array::from_fn(|i| if i % 2 == 0 { x * w } else { w }),
        }
    })
}

/// A colour made of all parameters. Only what is inlined is compiled for the machine's best level.
#[inline(always)]
fn shade<const N: usize>(block: &mut FragmentBlock<'_, N>, colors: &mut [u32; LANES]) {
    let mut sums = [1.0f32; LANES];
    for r in &block.params {
        sums.iter_mut().zip(r).for_each(|(sum, r)| *sum += r);
    }
    *colors = sums.map(f32::to_bits);
}

/// A square from 256 x 256 to 8192 x 8192 pixels.
fn pixels() -> Result<Vec<Series>, Box<dyn Error>> {
    let mut shaded = Series::new("z-buffer, 2 parameters");
    let mut depth = Series::new("z-buffer, depth alone");
    for size in [256, 512, 1024, 2048, 4096, 8192] {
        let pixels = f64::from(size) * f64::from(size);
        let draw = |(frame, renderer): &mut Canvas<2>| {
            renderer.draw_blocks(frame, &quad(0.5), shade);
        };
        shaded.points.push((pixels, time(&mut canvas(size)?, clear, draw)));
        let draw = |(frame, renderer): &mut Canvas<0>| renderer.draw_depth(frame, &quad(0.5));
        depth.points.push((pixels, time(&mut canvas(size)?, clear, draw)));
    }
    Ok(vec![shaded, depth])
}

/// Triangles of 8 pixels, two to a square of 4 x 4, row by row over 2048 x 2048 pixels; if they are
/// more than that takes, in layers from back to front.
fn polygons() -> Result<Vec<Series>, Box<dyn Error>> {
    const SIZE: u32 = 2048;
    const MOST: u32 = 10_000_000;
    let mut mesh = Series::new("z-buffer, a mesh");
    let mut single = Series::new("z-buffer, one by one");
    let mut scanline = Series::new("scanline renderer");
    for count in (2..=7).map(|power| 10u32.pow(power)) {
        let vertices = grid(SIZE / 4, count, MOST);
        let faces = || triangles(SIZE / 4).take(count as usize);
        let size = f64::from(count);
        let least = time(&mut canvas(SIZE)?, clear, |(frame, renderer)| {
            renderer.draw_blocks(frame, Mesh::new(&vertices, faces()), shade);
        });
        mesh.points.push((size, least));
        // More would take longer than all the rest.
        if count > MOST / 10 {
            continue;
        }
        let least = time(&mut canvas(SIZE)?, clear, |(frame, renderer)| {
            for face in faces() {
                let triangle = face.map(|corner| vertices[corner as usize]);
                renderer.draw_blocks(frame, &triangle, shade);
            }
        });
        single.points.push((size, least));
        let mut renderer = ScanlineRenderer::new(Viewport::new(SIZE, SIZE)?);
        let least = time(
            &mut renderer,
            |_| (),
            |renderer| {
                let sink = |_, row: &[u32]| {
                    black_box(row);
                    Ok::<(), std::convert::Infallible>(())
                };
                let mesh = Mesh::new(&vertices, faces());
                let Ok(()) = renderer.stream_blocks(mesh, 0, shade, sink);
            },
        );
        scanline.points.push((size, least));
    }
    Ok(vec![mesh, single, scanline])
}

/// The vertices of the first `count` triangles, in layers of `side` x `side` squares. There is depth
/// for `most`.
fn grid(side: u32, count: u32, most: u32) -> Vec<Vertex<2>> {
    let layers = most.div_ceil(2 * side * side);
    let place = |i: u32| i as f32 * 2.0 / side as f32 - 1.0;
    let vertex = |layer: u32, y: u32, x: u32| {
        let (x, y, z) = (place(x), -place(y), (layers - layer) as f32 / (layers + 1) as f32);
        Vertex::new(Vec4::new(x, y, z, 1.0), [x, y])
    };
    let last = triangles(side).take(count as usize).flatten().max().unwrap_or(0);
    let lines = (0..layers).flat_map(|layer| (0..=side).map(move |y| (layer, y)));
    let all = lines.flat_map(|(layer, y)| (0..=side).map(move |x| vertex(layer, y, x)));
    all.take(last as usize + 1).collect()
}

/// Their triangles, without end.
fn triangles(side: u32) -> impl Iterator<Item = [u32; 3]> {
    let lines =
        (0..).flat_map(move |layer| (0..side).map(move |y| (layer * (side + 1) + y) * (side + 1)));
    lines
        .flat_map(move |line| line..line + side)
        .flat_map(move |a| [[a, a + side + 1, a + side + 2], [a, a + side + 2, a + 1]])
}

/// From 0 to 64 parameters, for 1024 x 1024 pixels. Depth and 1/w count as values too.
fn parameters() -> Result<Vec<Series>, Box<dyn Error>> {
    let mut series = Series::new("z-buffer, 1024 x 1024 pixels");
    macro_rules! measure {
        ($($n:literal)*) => {$({
            let draw = |(frame, renderer): &mut Canvas<$n>| {
                renderer.draw_blocks(frame, &quad(0.5), shade);
            };
            let least = time(&mut canvas(1024)?, clear, draw);
            series.points.push((f64::from($n + 2), least));
        })*};
    }
    measure!(0 2 4 8 16 32 64);
    Ok(vec![series])
}

/// From 1 to 64 squares behind each other, each of 1024 x 1024 pixels.
fn depth() -> Result<Vec<Series>, Box<dyn Error>> {
    let mut back_to_front = Series::new("z-buffer, back to front");
    let mut front_to_back = Series::new("z-buffer, front to back");
    for layers in [1u8, 2, 4, 8, 16, 32, 64] {
        let mut quads: Vec<_> = (0..layers).map(|i| quad(f32::from(64 - i) / 65.0)).collect();
        for series in [&mut back_to_front, &mut front_to_back] {
            let least = time(&mut canvas(1024)?, clear, |(frame, renderer)| {
                quads.iter().for_each(|quad| renderer.draw_blocks(frame, quad, shade::<2>));
            });
            series.points.push((layers.into(), least));
            quads.reverse();
        }
    }
    Ok(vec![back_to_front, front_to_back])
}

/// From 3 to 256 sides, from clip space to the spans, on 512 rows.
fn sides() -> Result<Vec<Series>, Box<dyn Error>> {
    type Shape = fn(usize, usize) -> (f32, f32);
    let convex: Shape = |k, sides| {
        let angle = TAU * k as f32 / sides as f32;
        (angle.cos(), angle.sin())
    };
    let star: Shape = |k, sides| {
        let angle = TAU * k as f32 / sides as f32;
        let radius = if k % 2 == 0 { 1.0 } else { 0.5 };
        (radius * angle.cos(), radius * angle.sin())
    };
    // All of its sides cross all rows.
    let zigzag: Shape =
        |k, sides| (2.0 * k as f32 / (sides - 1) as f32 - 1.0, if k % 2 == 0 { -1.0 } else { 1.0 });
    let mut scan = ScanConverter::new(Viewport::new(512, 512)?);
    scan.settings.fill_rule = FillRule::EvenOdd;
    let series = [("convex", convex), ("star", star), ("zigzag, even-odd", zigzag)];
    Ok(series
        .map(|(name, shape)| {
            let mut series = Series::new(name);
            for sides in [3u16, 4, 8, 16, 32, 64, 128, 256] {
                let place = |k| shape(k, sides.into());
                let vertex = |(x, y)| Vertex::new(Vec4::new(x, y, 0.5, 1.0), [x, y]);
                let polygon: Vec<_> = (0..sides.into()).map(place).map(vertex).collect();
                let least = time(
                    &mut scan,
                    |_| (),
                    |scan| {
                        scan.spans(&polygon).for_each(|span| {
                            black_box(span);
                        });
                    },
                );
                series.points.push((sides.into(), least));
            }
            series
        })
        .into())
}

/// OBJ files of a torus with texture coordinates and normals, loaded by the library and by `tobj` alone,
/// which makes no model of what it reads.
fn loading() -> Result<Vec<Series>, Box<dyn Error>> {
    let mut ours = Series::new("polyscan");
    let mut theirs = Series::new("tobj");
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("torus.obj");
    for side in [22_u32, 71, 224, 707] {
        fs::write(&path, torus(side))?;
        let size = f64::from(2 * side * side);
        let load = |path: &mut &Path| {
            black_box(polyscan::Model::load(&**path).map(|loaded| loaded.model.face_count()).ok());
        };
        ours.points.push((size, time(&mut path.as_path(), |_| {}, load)));
        let load = |path: &mut &Path| {
            black_box(tobj::load_obj(*path, &tobj::LoadOptions::default()).ok());
        };
        theirs.points.push((size, time(&mut path.as_path(), |_| {}, load)));
    }
    fs::remove_file(&path)?;
    Ok(vec![ours, theirs])
}

/// The text of a torus of so many quads a side, each of two triangles.
fn torus(side: u32) -> String {
    let mut text = String::new();
    for i in 0..=side {
        let (su, cu) = (TAU * i as f32 / side as f32).sin_cos();
        for j in 0..=side {
            let (sv, cv) = (TAU * j as f32 / side as f32).sin_cos();
            let (x, y, z) = ((1.0 + 0.4 * cv) * cu, 0.4 * sv, (1.0 + 0.4 * cv) * su);
            let (u, v) = (i as f32 / side as f32, j as f32 / side as f32);
            text += &format!(
                "v {x:.6} {y:.6} {z:.6}\nvt {u:.5} {v:.5}\nvn {:.4} {sv:.4} {:.4}\n",
                cv * cu,
                cv * su
            );
        }
    }
    for i in 0..side {
        for j in 0..side {
            let a = 1 + i * (side + 1) + j;
            let (b, c, d) = (a + 1, a + side + 2, a + side + 1);
            text += &format!(
                "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}\nf {a}/{a}/{a} {c}/{c}/{c} {d}/{d}/{d}\n"
            );
        }
    }
    text
}
