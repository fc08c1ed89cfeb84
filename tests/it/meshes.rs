//! Contract 1 on meshes: polygons that share an edge touch each pixel along it exactly once, at any
//! view, however many planes cut them.
//!
//! Meshes here have no T-junctions: faces that share an edge share both of its vertices. A picture
//! is a set of bits, a word for 64 pixels of a row; a span that finds a bit set has hit a pixel
//! twice, and a bit that is missing at the end is a gap. So what a mesh covers is known from the
//! spans alone, for some 10^9 pixels in a quarter of a minute.
//!
//! Where planes cut a mesh, the pieces on both sides of them are drawn, each as a mesh of its own:
//! together they have to touch each pixel exactly once, which finds the gaps that clipping leaves,
//! as well as the double hits.
//!
//! `cargo test --profile proof --test it -- meshes:: --include-ignored --nocapture` runs the long
//! versions and prints their figures.

use crate::common::generators::{self, Cells, Mesh, Rng};
use crate::common::oracle::{self, FillRule, Position, Window};
use crate::common::{LONG_SEED, Tally, bare, in_threads, viewport};
use glam::{Vec4, vec4};
use polyscan::{ClipPlane, ScanConverter, Vertex};

const CELLS: [Cells; 3] = [Cells::Triangles, Cells::Quads, Cells::Mixed];

/// Which pixels of a window were touched, a bit each, and how often one was touched again.
struct Bits {
    window: Window,
    /// Words in a row.
    stride: usize,
    words: Vec<u64>,
    touched: u64,
    doubles: u64,
}

impl Bits {
    fn new(window: Window) -> Self {
        let stride = window.width.div_ceil(64) as usize;
        let words = vec![0; stride * window.height as usize];
        Self { window, stride, words, touched: 0, doubles: 0 }
    }

    /// Touches columns `x` of row `y`.
    fn touch(&mut self, y: i32, x: std::ops::Range<i32>) {
        let (start, end) = (x.start as usize, x.end as usize);
        let row = &mut self.words[y as usize * self.stride..][..self.stride];
        for (word, bits) in row.iter_mut().enumerate().take(end.div_ceil(64)).skip(start / 64) {
            let below = |end: usize| {
                let bits = end.saturating_sub(word * 64);
                if bits < 64 { (1u64 << bits) - 1 } else { u64::MAX }
            };
            let mask = below(end) & !below(start);
            self.doubles += u64::from((*bits & mask).count_ones());
            *bits |= mask;
        }
        self.touched += (end - start) as u64;
    }

    /// Draws all faces of a mesh.
    fn draw(&mut self, scan: &mut ScanConverter<0>, mesh: &Mesh) {
        let mut polygon: Vec<Vertex<0>> = Vec::new();
        for face in &mesh.faces {
            polygon.clear();
            polygon.extend(face.iter().map(|&i| Vertex::new(Vec4::from(mesh.positions[i]), [])));
            for span in scan.spans(&polygon) {
                self.touch(span.row(), span.columns());
            }
        }
    }

    fn contains(&self, x: u32, y: u32) -> bool {
        let word = self.words[y as usize * self.stride + x as usize / 64];
        word >> (x % 64) & 1 != 0
    }

    /// The touched pixels whose neighbours are touched as well.
    fn interior(&self) -> impl Iterator<Item = (u32, u32)> {
        let Window { width, height } = self.window;
        let inner = (1..height - 1).flat_map(move |y| (1..width - 1).map(move |x| (x, y)));
        inner.filter(|&(x, y)| {
            let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
            around.into_iter().all(|(x, y)| self.contains(x, y))
        })
    }

    /// How many pixels were not touched.
    fn untouched(&self) -> u64 {
        let set: u64 = self.words.iter().map(|word| u64::from(word.count_ones())).sum();
        u64::from(self.window.width) * u64::from(self.window.height) - set
    }

    /// The figures, every pixel without a touch being a gap.
    fn complete(&self, polygons: usize) -> Tally {
        Tally { gaps: self.untouched(), ..self.partial(polygons) }
    }

    /// The figures of a mesh that need not cover all pixels.
    fn partial(&self, polygons: usize) -> Tally {
        Tally {
            polygons: polygons as u64,
            pixels: self.touched,
            doubles: self.doubles,
            ..Tally::default()
        }
    }
}

// ----------------------------------------------------------------------------------------- meshes

/// A size of cells, from less than a pixel to a good part of the window.
fn counts(rng: &mut Rng, window: Window) -> [usize; 2] {
    [window.width, window.height].map(|size| rng.octaves(2.0, f64::from(size) / 3.0) as usize)
}

/// A whole jittered grid or fan, of random w, that covers the window.
fn whole(rng: &mut Rng, window: Window) -> Tally {
    let w_ratio = rng.octaves(1.0, 1000.0);
    let mesh = if rng.once_in(8) {
        let spokes = 3 + rng.below(400);
        generators::fan(rng, window, spokes, w_ratio)
    } else {
        let (cells, counts) = (CELLS[rng.below(3)], counts(rng, window));
        // Beyond 65,536 pixels outside, the guard band cuts the cells at the border as well.
        let margin = if rng.once_in(8) { 200_000.0 } else { rng.octaves(1.0, 20_000.0) };
        generators::jittered_grid(rng, window, counts, cells, w_ratio, margin)
    };
    let mut bits = Bits::new(window);
    bits.draw(&mut ScanConverter::new(viewport(window)), &mesh);
    bits.complete(mesh.faces.len())
}

/// A grid cut by one to three user planes: the pieces on all their sides, 2 to 8 meshes. Its cells
/// are triangles: a plane may cut a quad whose corners have no plane four times.
fn cut_by_planes(rng: &mut Rng, window: Window) -> Tally {
    let (cells, counts) = (Cells::Triangles, counts(rng, window).map(|n| n.min(60)));
    let mesh = generators::jittered_grid(rng, window, counts, cells, 30.0, 8.0);
    // Through a random point near the middle, in any direction, tilted in depth.
    let planes: Vec<Vec4> = (0..1 + rng.below(3))
        .map(|_| {
            let [a, b, c, d] = std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
            vec4(a, b, c, 0.4 * d - 0.45 * c)
        })
        .collect();
    let mut bits = Bits::new(window);
    let mut scan = ScanConverter::new(viewport(window));
    for sides in 0..1usize << planes.len() {
        let side = |(i, &plane): (usize, &Vec4)| {
            ClipPlane::new(if sides >> i & 1 == 0 { plane } else { -plane })
        };
        scan.settings.planes = planes.iter().enumerate().map(side).collect();
        bits.draw(&mut scan, &mesh);
    }
    bits.complete(mesh.faces.len() << planes.len())
}

/// A grid through the near and the far plane: what lies between them, what lies before the near
/// plane and what lies behind the far plane. The latter two are drawn with depths brought between
/// the planes, z' = (z + 3/2 w) / 4, and cut by user planes where z' = 3/8 w and z' = 5/8 w. All
/// numbers are multiples of 2^-13, so that nothing is rounded. Cells are triangles, for the same
/// reason.
fn cut_by_near_and_far(rng: &mut Rng, window: Window) -> Tally {
    let (cells, counts) = (Cells::Triangles, counts(rng, window).map(|n| n.min(100)));
    let mut mesh = generators::jittered_grid(rng, window, counts, cells, 30.0, 8.0);
    let even = |c: f64| (c * 1024.0).round() / 1024.0;
    for p in &mut mesh.positions {
        let [x, y, _, old] = p.map(f64::from);
        let w = even(old);
        let z = even(w * rng.range(-0.4, 1.4));
        *p = [x / old * w, y / old * w, z, w].map(|c| c as f32);
    }
    let mut bits = Bits::new(window);
    let mut scan = ScanConverter::new(viewport(window));
    bits.draw(&mut scan, &mesh);
    for p in &mut mesh.positions {
        p[2] = (p[2] + 1.5 * p[3]) / 4.0;
    }
    for plane in [vec4(0.0, 0.0, -1.0, 0.375), vec4(0.0, 0.0, 1.0, -0.625)] {
        scan.settings.planes = vec![ClipPlane::new(plane)];
        bits.draw(&mut scan, &mesh);
    }
    bits.complete(3 * mesh.faces.len())
}

/// A level floor from behind the eye to far away. Its pixels are known: the ray through (X, Y) in
/// normalized device coordinates meets y = -1 at w = -1/Y and x = X w. All of them well inside the
/// floor, by the border cells' jitter, have to be touched.
fn floor(rng: &mut Rng, window: Window) -> Tally {
    let (cells, far) = (CELLS[rng.below(3)], rng.octaves(4.0, 60.0));
    let counts = [2 + rng.below(24), 2 + rng.below(40)];
    let mesh = generators::floor(rng, counts, cells, far);
    let mut bits = Bits::new(window);
    bits.draw(&mut ScanConverter::new(viewport(window)), &mesh);
    let cell = [8.0 / counts[0] as f64, (far + 2.0) / counts[1] as f64];
    let [width, height] = [window.width, window.height].map(f64::from);
    let is_floor = |x: u32, y: u32| {
        // A row of pixels below the horizon is a wide strip of the floor: a tenth of it counts as
        // border, which covers the rounding to 1/256 pixel.
        let below = (2.0 * (f64::from(y) + 0.5) / height - 1.0).max(1e-9);
        let w = 1.0 / below;
        let blur = w * w * 0.2 / height;
        let side = w * (2.0 * (f64::from(x) + 0.5) / width - 1.0).abs();
        side + 0.2 * cell[0] + blur * side / w + w * 0.2 / width < 4.0
            && w - blur > (0.2 * cell[1] - 2.0).max(0.25)
            && w + blur < far - 0.2 * cell[1]
    };
    let missing =
        |y: u32| (0..window.width).filter(|&x| is_floor(x, y) && !bits.contains(x, y)).count();
    let gaps: usize = (window.height / 2..window.height).map(missing).sum();
    Tally { gaps: gaps as u64, ..bits.partial(mesh.faces.len()) }
}

/// A planar grid of whole coordinates, of -4..=4 at its corner and along its sides, cut by a plane
/// of whole coefficients: vertices on planes, edges through the eye, cut points that many edges
/// share. Nothing random keeps equal things apart here. A pixel is touched once at most. The pieces
/// on the two sides of the plane together touch what the grid touches without it, but for pixels
/// along its outline, where the cut puts a vertex that the whole grid has not.
fn lattice(rng: &mut Rng, window: Window) -> Tally {
    let [origin, along, across]: [[i64; 4]; 3] =
        std::array::from_fn(|_| std::array::from_fn(|_| rng.whole(-4, 4)));
    if is_edge_on([origin, along, across]) {
        // No area: what rounding makes of it may fold over, and touches next to nothing.
        return Tally::default();
    }
    let cells = CELLS[rng.below(3)];
    let mesh = generators::whole_grid(rng, [origin, along, across], [4, 3], cells);
    let plane = Vec4::from_array(std::array::from_fn(|_| rng.whole(-2, 2) as f32));
    let mut scan = ScanConverter::new(viewport(window));
    let mut all = Bits::new(window);
    all.draw(&mut scan, &mesh);
    if mesh.positions.iter().all(|&p| plane.dot(Vec4::from(p)) == 0.0) {
        // All of it is on both sides.
        return all.partial(mesh.faces.len());
    }
    let mut parts = Bits::new(window);
    for plane in [plane, -plane] {
        scan.settings.planes = vec![ClipPlane::new(plane)];
        parts.draw(&mut scan, &mesh);
    }
    Tally {
        gaps: all.interior().filter(|&(x, y)| !parts.contains(x, y)).count() as u64,
        doubles: all.doubles + parts.doubles,
        pixels: all.touched + parts.touched,
        ..all.partial(3 * mesh.faces.len())
    }
}

/// Whether the plane of three vectors in clip space runs through the eye.
fn is_edge_on(vectors: [[i64; 4]; 3]) -> bool {
    let [a, b, c] = vectors.map(|[x, y, _, w]| [x, y, w].map(|c| c as f64));
    let [a, b, c] = [a, b, c].map(glam::DVec3::from);
    a.dot(b.cross(c)) == 0.0
}

/// A convex quad anywhere, split along either diagonal, in perspective or not, in one of three cut
/// by the near or the far plane. A double hit is a pixel that both triangles touch. A gap pixel is
/// one that neither touches, although its centre is inside the outline of the unsplit quad, clipped
/// in exact arithmetic and rounded to 1/256 pixel, or on the side of it that the top-left rule
/// counts; and an extra pixel, counted as a gap as well, is one outside.
fn split_quad(rng: &mut Rng, window: Window) -> Tally {
    let quad = generators::split_quad(rng, window);
    let halves = if rng.once_in(2) { [[0, 1, 2], [0, 2, 3]] } else { [[1, 2, 3], [1, 3, 0]] };
    let mut bits = Bits::new(window);
    let mut scan = ScanConverter::new(viewport(window));
    for half in halves {
        let half = half.map(|i| quad[i]);
        scan.spans(&bare(&half)).for_each(|span| bits.touch(span.row(), span.columns()));
    }
    let exact = |polygon: &[Position]| {
        oracle::coverage(polygon, window, oracle::Depth::ZeroToOne, 65_536.0, FillRule::NonZero)
    };
    let masks = if is_inside(&quad) {
        vec![exact(&quad)]
    } else {
        // A cut diagonal has an end on the cut, which rounding moves off the quad's side there.
        halves.map(|half| exact(&half.map(|i| quad[i]))).to_vec()
    };
    let expected = |x, y| masks.iter().any(|mask| mask.contains(x, y));
    let pixels = (0..window.height).flat_map(|y| (0..window.width).map(move |x| (x, y)));
    let gaps = pixels.filter(|&(x, y)| expected(x, y) != bits.contains(x, y)).count();
    Tally { gaps: gaps as u64, ..bits.partial(2) }
}

/// Whether neither the near nor the far plane cuts a polygon.
fn is_inside(polygon: &[Position]) -> bool {
    polygon.iter().all(|p| p[2] >= 0.0 && p[2] <= p[3])
}

// ------------------------------------------------------------------------------------------ tests

type Kind = fn(&mut Rng, Window) -> Tally;

const SMALL: Window = Window { width: 160, height: 120 };
/// Where the split quads of the long test are drawn.
const QUADS: Window = Window { width: 128, height: 128 };
const LARGE: Window = Window { width: 1024, height: 768 };

/// The figures of the meshes that the seeds name; none may have a finding.
fn check(kind: Kind, window: Window, seeds: std::ops::Range<u64>) -> Tally {
    let one = |seed| {
        let tally = kind(&mut Rng::new(seed), window);
        assert_eq!((tally.gaps, tally.doubles), (0, 0), "gaps and double hits of seed {seed}");
        tally
    };
    in_threads(seeds, one)
}

#[test]
fn meshes_cover_the_window_once() {
    check(whole, SMALL, 0..60);
}

#[test]
fn meshes_cut_by_planes_cover_the_window_once() {
    check(cut_by_planes, SMALL, 0..30);
}

#[test]
fn meshes_cut_by_near_and_far_cover_the_window_once() {
    check(cut_by_near_and_far, SMALL, 0..30);
}

#[test]
fn floors_through_the_eye_have_no_gap() {
    check(floor, SMALL, 0..60);
}

#[test]
fn grids_of_whole_numbers_cut_by_whole_planes_are_covered_once() {
    check(lattice, SMALL, 0..300);
}

#[test]
fn quads_split_along_a_diagonal_leave_no_gap_and_no_double_hit() {
    check(split_quad, Window { width: 64, height: 64 }, 0..100);
}

#[test]
#[ignore = "long: 10^9 pixels and more, a minute in release"]
fn long_meshes() {
    let kinds: [(&str, Kind, Window, u64); 7] = [
        ("jittered grids and fans", whole, LARGE, 1500),
        ("grids cut by 1 to 3 user planes", cut_by_planes, LARGE, 600),
        ("grids cut by near and far", cut_by_near_and_far, LARGE, 600),
        ("floors through the eye", floor, LARGE, 2000),
        ("grids of whole numbers", lattice, SMALL, 200_000),
        ("900 quads split along a diagonal", split_quad, QUADS, 900),
        ("30,000 quads split along a diagonal", split_quad, QUADS, 30_000),
    ];
    let mut all = Tally::default();
    for (name, kind, window, seeds) in kinds {
        let tally = check(kind, window, LONG_SEED..LONG_SEED + seeds);
        println!("{name}: {tally}");
        all = all + tally;
    }
    println!("all meshes: {all}");
    assert!(all.pixels >= 1_000_000_000, "too few pixels: {all}");
}
