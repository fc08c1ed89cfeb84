//! Contracts 1, 2 and 4 against pictures that another renderer drew: 46 scenes by Mesa's llvmpipe.
//! `tests/data/mesa/README.md` says what they show and how they came here.
//!
//! - Coverage and the visible polygon are the same at every pixel but the four of [`DIFFERENCES`].
//!   There exact rational arithmetic gives our answer if polygons are cut at the guard band, and
//!   Mesa's if they are cut at the sides of the viewport. No pixel is let off by a tolerance.
//! - Parameters and depth of every fragment, visible or not, are as exact as promised. Mesa's are
//!   held against the same planes: they may be off by what Mesa was measured to be off, which each
//!   test states, and differ from ours by that and what is promised of ours.
//!
//! `cargo test --test it mesa:: -- --nocapture` prints what was measured, a line a family of scenes.

use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::common::generators::Shape;
use crate::common::oracle::{self, Depth, FillRule, Position, Window};
use crate::common::{counts, vertices, viewport};
use polyscan::viewport::GUARD_BAND;
use polyscan::{
    ClipSpace, DepthTest, Fragment, Framebuffer, ScanConverter, Vertex, ZBufferRenderer,
};

/// The scenes' depth convention is OpenGL's.
const DEPTH: Depth = Depth::MinusOneToOne;

/// Every pixel where Mesa's picture is not ours.
///
/// All four have one cause. Mesa cuts polygons at the sides of the viewport and rounds what is left
/// to 1/256 pixel, so the cut moves an edge by up to half of that; here an edge keeps its far ends
/// (contract 2). The centres of these pixels lie within 1/256 pixel of an edge.
const DIFFERENCES: [Difference; 4] = [
    Difference { scene: "e02_inter1", pixel: (63, 1), polygon: 34, by: Drawn::ByMesa },
    Difference { scene: "e05_inter4", pixel: (42, 14), polygon: 10, by: Drawn::ByUs },
    Difference { scene: "e05_inter4", pixel: (8, 70), polygon: 66, by: Drawn::ByMesa },
    Difference { scene: "e05_inter4", pixel: (86, 82), polygon: 42, by: Drawn::ByUs },
];

/// A pixel that one renderer finds inside a polygon and the other does not.
struct Difference {
    scene: &'static str,
    pixel: (u32, u32),
    polygon: usize,
    by: Drawn,
}

/// Which of the two renderers draws the polygon at the pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Drawn {
    ByUs,
    ByMesa,
}

// ------------------------------------------------------------------------------------------ scenes

/// Polygons, and what Mesa made of them.
struct Scene<const N: usize> {
    name: String,
    window: Window,
    /// Whether hidden surfaces are removed; otherwise polygons are drawn over each other in order.
    z_buffer: bool,
    /// Whether the polygons cover each pixel exactly once.
    every_pixel_once: bool,
    /// Whether they cover no pixel more than once.
    no_pixel_twice: bool,
    polygons: Vec<Shape<N>>,
    mesa: Picture<N>,
}

/// What a renderer made of a scene.
struct Picture<const N: usize> {
    /// How many polygons cover each pixel, hidden or not.
    coverage: Vec<u32>,
    frame: Framebuffer<Pixel<N>>,
}

/// What is visible at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pixel<const N: usize> {
    polygon: Option<usize>,
    params: [f32; N],
}

impl<const N: usize> Pixel<N> {
    const EMPTY: Self = Self { polygon: None, params: [0.0; N] };
}

/// What can be told exactly of a pixel: how many polygons cover it, and which is visible.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    coverage: u32,
    polygon: Option<usize>,
}

impl<const N: usize> Picture<N> {
    fn seen(&self, index: usize) -> Seen {
        Seen { coverage: self.coverage[index], polygon: self.frame.color()[index].polygon }
    }
}

// ------------------------------------------------------------------------------------------- files

/// The first words of a file.
struct Header {
    window: Window,
    z_buffer: bool,
    every_pixel_once: bool,
    no_pixel_twice: bool,
    /// Whether the last parameter is the polygon's index and not stored with the vertices.
    index_is_last: bool,
    parameters: usize,
    vertices: u32,
    polygons: u32,
    corners: u32,
}

/// What has not been read yet of an unpacked file.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn bytes(&mut self, len: usize) -> &'a [u8] {
        let (bytes, rest) = self.0.split_at_checked(len).expect("the file is complete");
        self.0 = rest;
        bytes
    }

    fn short(&mut self) -> usize {
        let bytes = self.bytes(2).try_into().expect("two bytes");
        usize::from(u16::from_le_bytes(bytes))
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.bytes(4).try_into().expect("four bytes"))
    }

    fn header(&mut self) -> Header {
        let window = Window { width: self.word(), height: self.word() };
        let (mode, flags) = (self.word(), self.word());
        Header {
            window,
            z_buffer: mode == 2,
            every_pixel_once: flags & 1 != 0,
            no_pixel_twice: flags & 2 != 0,
            index_is_last: flags & 4 != 0,
            parameters: self.word() as usize,
            vertices: self.word(),
            polygons: self.word(),
            corners: self.word(),
        }
    }

    /// A position and the parameters that are stored, the others 0.
    fn vertex<const N: usize>(&mut self, stored: usize) -> (Position, [f32; N]) {
        let position = std::array::from_fn(|_| f32::from_bits(self.word()));
        let mut params = [0.0; N];
        params[..stored].fill_with(|| f32::from_bits(self.word()));
        (position, params)
    }

    fn polygons<const N: usize>(&mut self, header: &Header) -> Vec<Shape<N>> {
        let stored = N - usize::from(header.index_is_last);
        let vertices: Vec<_> = (0..header.vertices).map(|_| self.vertex::<N>(stored)).collect();
        let corners: Vec<_> = (0..header.polygons).map(|_| self.short()).collect();
        assert_eq!(corners.iter().sum::<usize>(), header.corners as usize);
        let polygon = |(index, &corners): (usize, &usize)| {
            let corner = |_| {
                let (position, mut params) = vertices[self.short()];
                params[stored..].fill(index as f32);
                (position, params)
            };
            let (positions, parameters) = (0..corners).map(corner).unzip();
            Shape { positions, parameters }
        };
        corners.iter().enumerate().map(polygon).collect()
    }

    /// f32 values, each stored as the difference of its bits to those of the value before, the
    /// differences' lowest bytes first, then their second bytes, and so on.
    fn column(&mut self, len: usize) -> Vec<f32> {
        let planes: [&[u8]; 4] = std::array::from_fn(|_| self.bytes(len));
        let mut bits = 0u32;
        let value = |i: usize| {
            bits = bits.wrapping_add(u32::from_le_bytes(planes.map(|plane| plane[i])));
            f32::from_bits(bits)
        };
        (0..len).map(value).collect()
    }

    fn picture<const N: usize>(&mut self, window: Window) -> Picture<N> {
        let mut frame = empty_frame(window);
        let pixels = frame.color().len();
        let coverage = self.bytes(pixels).iter().map(|&n| u32::from(n)).collect();
        for pixel in frame.color_mut() {
            pixel.polygon = self.short().checked_sub(1);
        }
        let drawn: Vec<usize> =
            (0..pixels).filter(|&i| frame.color()[i].polygon.is_some()).collect();
        for (&i, depth) in drawn.iter().zip(self.column(drawn.len())) {
            frame.depth_mut()[i] = depth;
        }
        for n in 0..N {
            for (&i, r) in drawn.iter().zip(self.column(drawn.len())) {
                frame.color_mut()[i].params[n] = r;
            }
        }
        Picture { coverage, frame }
    }
}

/// The files of a family, in the order of their names.
fn files(family: char) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/mesa");
    let entries = fs::read_dir(folder).expect("the folder of the scenes");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "z"));
    files.retain(|path| scene_name(path).starts_with(family));
    files.sort();
    files
}

fn scene_name(path: &Path) -> String {
    path.file_stem().expect("a file").to_string_lossy().into_owned()
}

fn unpacked(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    let file = File::open(path).expect("a scene");
    flate2::read::ZlibDecoder::new(file).read_to_end(&mut bytes).expect("a zlib stream");
    bytes
}

// ----------------------------------------------------------------------------------------- drawing

fn empty_frame<const N: usize>(window: Window) -> Framebuffer<Pixel<N>> {
    Framebuffer::new(window.width, window.height, Pixel::EMPTY).expect("scenes are small")
}

fn renderer<const N: usize>(scene: &Scene<N>) -> ZBufferRenderer<N> {
    let mut renderer = ZBufferRenderer::new(viewport(scene.window));
    renderer.settings.clip_space = ClipSpace::MinusOneToOne;
    renderer.depth_test = if scene.z_buffer { DepthTest::Nearer } else { DepthTest::Always };
    renderer
}

fn scan<const N: usize>(scene: &Scene<N>) -> ScanConverter<N> {
    let mut scan = ScanConverter::new(viewport(scene.window));
    scan.settings = renderer(scene).settings;
    scan
}

/// The scene as we draw it.
fn draw<const N: usize>(scene: &Scene<N>, polygons: &[Vec<Vertex<N>>]) -> Picture<N> {
    let mut renderer = renderer(scene);
    let mut frame = empty_frame(scene.window);
    for (i, polygon) in polygons.iter().enumerate() {
        let shader = |f: &Fragment<'_, N>| Pixel { polygon: Some(i), params: f.params };
        renderer.draw(&mut frame, polygon, shader);
    }
    Picture { coverage: counts(&mut scan(scene), polygons, scene.window), frame }
}

// ---------------------------------------------------------------------------------------- coverage

/// The centre of a pixel, in pixels.
fn middle(x: u32, y: u32) -> [f64; 2] {
    [x, y].map(|c| f64::from(c) + 0.5)
}

/// The polygons that cover a pixel by exact arithmetic, when a polygon may leave the viewport by
/// `guard` pixels before it is cut.
fn covering<const N: usize>(scene: &Scene<N>, (x, y): (u32, u32), guard: f64) -> Vec<usize> {
    let covers = |shape: &Shape<N>| {
        let outline = oracle::outline(&shape.positions, scene.window, DEPTH, guard);
        oracle::covers(&outline, oracle::centre(x, y), FillRule::NonZero)
    };
    (0..scene.polygons.len()).filter(|&i| covers(&scene.polygons[i])).collect()
}

/// The polygon that is visible among those that cover a pixel, by exact arithmetic.
fn visible<const N: usize>(
    scene: &Scene<N>,
    (x, y): (u32, u32),
    covering: &[usize],
) -> Option<usize> {
    if !scene.z_buffer {
        return covering.last().copied();
    }
    let depth = |&i: &usize| {
        let Shape { positions, parameters } = &scene.polygons[i];
        let triple = oracle::best_triple(positions).expect("it covers a pixel");
        let sample =
            oracle::sample_exact(positions, parameters, triple, scene.window, middle(x, y));
        sample.expect("the ray meets the plane").z_over_w
    };
    covering.iter().copied().min_by(|i, j| depth(i).total_cmp(&depth(j)))
}

/// Proves that a pixel differs for the reason given, and for no other.
fn check_difference<const N: usize>(
    scene: &Scene<N>,
    difference: &Difference,
    ours: Seen,
    mesa: Seen,
) {
    let Difference { pixel, polygon, by, .. } = *difference;
    let at = format!("{}: pixel {pixel:?}", scene.name);
    let sets = [f64::from(GUARD_BAND), 0.0].map(|guard| covering(scene, pixel, guard));
    let exact = sets
        .each_ref()
        .map(|set| Seen { coverage: set.len() as u32, polygon: visible(scene, pixel, set) });
    assert_eq!(ours, exact[0], "{at}: ours is not the exact answer with our guard band");
    assert_eq!(mesa, exact[1], "{at}: Mesa's is not the exact answer cut at the viewport");
    let [ours, mesa] = sets;
    let (mut more, fewer) = match by {
        Drawn::ByUs => (ours, mesa),
        Drawn::ByMesa => (mesa, ours),
    };
    more.retain(|i| !fewer.contains(i));
    assert_eq!(more, [polygon], "{at}: polygons drawn {by:?} alone");
}

fn check_coverage<const N: usize>(scene: &Scene<N>, ours: &Picture<N>) {
    let name = &scene.name;
    let width = scene.window.width as usize;
    let listed: Vec<_> = DIFFERENCES.iter().filter(|d| d.scene == name).collect();
    let mut differing = 0;
    for i in 0..ours.coverage.len() {
        let (ours, mesa) = (ours.seen(i), scene.mesa.seen(i));
        let pixel = ((i % width) as u32, (i / width) as u32);
        let once = !scene.every_pixel_once || ours.coverage == 1;
        assert!(once, "{name}: pixel {pixel:?} is not covered exactly once: {ours:?}");
        let not_twice = !scene.no_pixel_twice || ours.coverage <= 1;
        assert!(not_twice, "{name}: pixel {pixel:?} is covered twice: {ours:?}");
        if ours != mesa {
            let difference = listed.iter().find(|difference| difference.pixel == pixel);
            let difference = difference.unwrap_or_else(|| {
                panic!("{name}: pixel {pixel:?}: ours is {ours:?}, Mesa's {mesa:?}")
            });
            check_difference(scene, difference, ours, mesa);
            differing += 1;
        }
    }
    assert_eq!(differing, listed.len(), "{name}: a difference that is listed is no more");
}

// ---------------------------------------------------------------------------- parameters and depth

/// How far parameters and depth are off: the former as a part of the polygon's largest |r_i|, the
/// latter as a part of the depth range.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    params: f64,
    depth: f64,
}

impl Errors {
    /// What contract 4 allows for parameters; the same for depth.
    const PROMISED: Self = Self { params: 1e-5, depth: 1e-5 };

    /// The difference of the worst parameter, and that of depth.
    fn between<const N: usize>(a: &Values<N>, b: &Values<N>, largest: &[f64; N]) -> Self {
        let error = |i: usize| (a.params[i] - b.params[i]).abs() / largest[i];
        // Unlike `f64::max`, this keeps what is not a number.
        let worst = |most: f64, error: f64| if error <= most { most } else { error };
        Self { params: (0..N).map(error).fold(0.0, worst), depth: (a.depth - b.depth).abs() }
    }

    fn plus(self, other: Self) -> Self {
        Self { params: self.params + other.params, depth: self.depth + other.depth }
    }

    fn worst(self, other: Self) -> Self {
        Self { params: self.params.max(other.params), depth: self.depth.max(other.depth) }
    }

    /// Whether both are within the bounds; what is not a number is not.
    fn within(self, bounds: Self) -> bool {
        self.params <= bounds.params && self.depth <= bounds.depth
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.1e} (depth {:.1e})", self.params, self.depth)
    }
}

/// The worst that was measured.
#[derive(Clone, Copy, Debug, Default)]
struct Measured {
    fragments: usize,
    /// Between ours and exact values.
    ours: Errors,
    /// Between Mesa's and exact values, where Mesa shows the polygon.
    mesa: Errors,
    /// Between ours and Mesa's.
    apart: Errors,
}

impl Measured {
    fn worst(self, other: Self) -> Self {
        Self {
            fragments: self.fragments + other.fragments,
            ours: self.ours.worst(other.ours),
            mesa: self.mesa.worst(other.mesa),
            apart: self.apart.worst(other.apart),
        }
    }
}

/// Parameters and depth at a pixel, from wherever.
#[derive(Debug)]
struct Values<const N: usize> {
    params: [f64; N],
    depth: f64,
}

impl<const N: usize> Values<N> {
    fn new(params: [f32; N], depth: f32) -> Self {
        Self { params: params.map(f64::from), depth: f64::from(depth) }
    }

    /// What the plane of a shape holds at the centre of a pixel. The centre of a covered pixel may
    /// lie outside of the unrounded polygon; its depth is kept in the view volume.
    ///
    /// Corners rounded to f32 are not quite in one plane: the planes through three corners each of
    /// `a38` differ by 2.7e-6 in depth, where our depth is off most.
    fn exact(shape: &Shape<N>, triple: [usize; 3], window: Window, (x, y): (u32, u32)) -> Self {
        let Shape { positions, parameters } = shape;
        let sample = oracle::sample(positions, parameters, triple, window, middle(x, y));
        let sample = sample.expect("the ray of a covered pixel meets the plane");
        let depth = oracle::window_depth(sample.z_over_w, DEPTH, [0.0, 1.0]).clamp(0.0, 1.0);
        Self { params: sample.values, depth }
    }
}

/// The largest |r_i| of each parameter of a shape, or the least that can be divided by.
fn largest<const N: usize>(shape: &Shape<N>) -> [f64; N] {
    let values = |i: usize| shape.parameters.iter().map(move |r| f64::from(r[i].abs()));
    std::array::from_fn(|i| values(i).fold(f64::MIN_POSITIVE, f64::max))
}

/// A polygon of a scene, and what its fragments are held against.
struct Check<'a, const N: usize> {
    scene: &'a Scene<N>,
    /// The scene as we draw it.
    picture: &'a Picture<N>,
    index: usize,
    /// Three vertices that span its plane.
    triple: [usize; 3],
    largest: [f64; N],
    /// How far Mesa may be off.
    bounds: Errors,
}

impl<const N: usize> Check<'_, N> {
    /// Holds a fragment against the polygon's plane, and where the polygon is visible in Mesa's
    /// picture, all three against each other. Where it is visible in our picture, the fragment is
    /// what the picture shows, to the bit.
    fn fragment(&self, fragment: &Fragment<'_, N>) -> Measured {
        let &Self { scene, index, triple, bounds, .. } = self;
        let pixel = (fragment.x as u32, fragment.y as u32);
        let exact = Values::exact(&scene.polygons[index], triple, scene.window, pixel);
        let ours = Values::new(fragment.params, fragment.depth);
        let mut measured = Measured { fragments: 1, ..Measured::default() };
        measured.ours = self.distance("ours and exact", pixel, [&ours, &exact], Errors::PROMISED);

        let at = |picture: &Picture<N>| picture.frame.pixel(pixel.0, pixel.1).expect("inside");
        let (visible, depth) = at(self.picture);
        if visible.polygon == Some(index) {
            assert_eq!((visible.params, depth), (fragment.params, fragment.depth), "{pixel:?}");
        }
        let (visible, depth) = at(&scene.mesa);
        if visible.polygon == Some(index) {
            let mesa = Values::new(visible.params, depth);
            let both = Errors::PROMISED.plus(bounds);
            measured.mesa = self.distance("Mesa's and exact", pixel, [&mesa, &exact], bounds);
            measured.apart = self.distance("ours and Mesa's", pixel, [&ours, &mesa], both);
        }
        measured
    }

    /// How far two sets of values lie apart: within the bounds.
    fn distance(
        &self,
        which: &str,
        pixel: (u32, u32),
        [a, b]: [&Values<N>; 2],
        bounds: Errors,
    ) -> Errors {
        let errors = Errors::between(a, b, &self.largest);
        let (name, index) = (&self.scene.name, self.index);
        assert!(
            errors.within(bounds),
            "{name}: pixel {pixel:?} of polygon {index}: {which} are {a:?} and {b:?}, {errors:?}"
        );
        errors
    }
}

/// Checks all fragments of a scene, those that are hidden too.
fn check_values<const N: usize>(
    scene: &Scene<N>,
    polygons: &[Vec<Vertex<N>>],
    picture: &Picture<N>,
    bounds: Errors,
) -> Measured {
    let mut scan = scan(scene);
    let mut measured = Measured::default();
    for (index, shape) in scene.polygons.iter().enumerate() {
        let Some(triple) = oracle::best_triple(&shape.positions) else { continue };
        let check = Check { scene, picture, index, triple, largest: largest(shape), bounds };
        for span in scan.spans(&polygons[index]) {
            for fragment in span.fragments() {
                measured = measured.worst(check.fragment(&fragment));
            }
        }
    }
    let covered: u32 = picture.coverage.iter().sum();
    assert_eq!(measured.fragments, covered as usize, "{}: fragments checked", scene.name);
    measured
}

// ------------------------------------------------------------------------------------------- tests

/// Checks one scene.
fn check_scene<const N: usize>(
    name: String,
    header: &Header,
    mut rest: Reader<'_>,
    bounds: Errors,
) -> Measured {
    let &Header { window, z_buffer, every_pixel_once, no_pixel_twice, .. } = header;
    let (polygons, mesa) = (rest.polygons(header), rest.picture(window));
    assert!(rest.0.is_empty(), "{name}: {} bytes too many", rest.0.len());
    let scene =
        Scene::<N> { name, window, z_buffer, every_pixel_once, no_pixel_twice, polygons, mesa };
    let polygons: Vec<_> = scene.polygons.iter().map(vertices).collect();
    let picture = draw(&scene, &polygons);
    check_coverage(&scene, &picture);
    check_values(&scene, &polygons, &picture, bounds)
}

/// Checks the scenes of a family, of which there are `scenes`, and prints what was measured.
///
/// `bounds` is how far Mesa's values lie from the exact ones, as this test measures it, rounded up.
/// It evaluates an f32 plane for each triangle of a polygon, which is worst on slivers: `a35` is a
/// quad seen nearly edge-on, `b11` a fan of thin triangles.
fn check_family(family: char, scenes: usize, bounds: Errors) {
    let files = files(family);
    assert_eq!(files.len(), scenes, "scenes of family {family}");
    let mut measured = Measured::default();
    for path in &files {
        let (name, bytes) = (scene_name(path), unpacked(path));
        let mut reader = Reader(&bytes);
        let header = reader.header();
        let check = match header.parameters {
            0 => check_scene::<0>,
            2 => check_scene::<2>,
            3 => check_scene::<3>,
            4 => check_scene::<4>,
            6 => check_scene::<6>,
            n => panic!("{name} has {n} parameters"),
        };
        measured = measured.worst(check(name, &header, reader, bounds));
    }
    let Measured { fragments, ours, mesa, apart } = measured;
    println!(
        "{family}: {scenes:2} scenes, {fragments:6} fragments; ours {ours}; Mesa {mesa}; apart {apart}"
    );
}

#[test]
fn quads_in_perspective_seen_edge_on_and_from_behind() {
    check_family('a', 16, Errors { params: 7e-5, depth: 2.5e-6 });
}

#[test]
fn polygons_with_six_parameters_against_the_clip_planes() {
    check_family('b', 14, Errors { params: 8e-5, depth: 1.6e-5 });
}

#[test]
fn meshes_with_shared_edges() {
    check_family('c', 9, Errors { params: 0.0, depth: 2e-7 });
}

#[test]
fn affine_polygons() {
    check_family('d', 4, Errors { params: 8e-7, depth: 1e-7 });
}

#[test]
fn polygons_through_each_other_in_a_z_buffer() {
    check_family('e', 2, Errors { params: 2e-6, depth: 7e-7 });
}

#[test]
fn a_model_in_a_z_buffer() {
    check_family('f', 1, Errors { params: 5e-5, depth: 2.5e-7 });
}
