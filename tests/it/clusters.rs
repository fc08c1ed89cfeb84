//! Clusters: parameters with a denominator of their own, against planes in f64, by all renderers and by both kinds
//! of shaders.

use std::array::from_fn;

use crate::common::generators::{self, Rng, Shape};
use crate::common::oracle::{self, Depth, Window};
use crate::common::{LONG_SEED, dynamic, dynamic_blocks, in_threads, vertices, viewport};
use glam::{DMat4, DVec3, DVec4, Mat4, Vec3, Vec4, vec3, vec4};
use polyscan::fragment::LANES;
use polyscan::{
    BspTree, ClipPlane, Footprint, Fragment, FragmentBlock, Framebuffer, Interpolation, Mesh,
    PainterRenderer, ScanConverter, ScanlineRenderer, Settings, Vertex, Viewport, ZBufferRenderer,
};

const WINDOW: Window = Window { width: 97, height: 61 };

/// The promise: a part of the largest |r_i|.
const PROMISED: f64 = 1e-5;

/// Two numerators and their denominator, of any size, among parameters of the polygon's own cluster.
const U: usize = 1;
const V: usize = 3;
const Q: usize = 2;

/// Gives a triangle's vertices a cluster, whose w_r have the given ratio.
fn with_cluster(rng: &mut Rng, shape: &mut Shape<4>, ratio: f64) {
    let unit = rng.octaves(1e-6, 1e6);
    let mut q = [1.0, ratio, rng.octaves(1.0, ratio.max(1.0 + 1e-9))].map(|q| q * unit);
    rng.shuffle(&mut q);
    for (params, q) in shape.parameters.iter_mut().zip(q) {
        (params[U], params[V]) =
            ((rng.range(-1.0, 1.0) * q) as f32, (rng.range(-1.0, 1.0) * q) as f32);
        params[Q] = q as f32;
    }
}

/// The worst error of a cluster, and of its derivatives, over the pixels of a polygon whose centres lie inside of
/// it, as a part of `largest`; and how many pixels that were.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    pixels: u64,
    value: f64,
    derivative: f64,
}

impl std::ops::Add for Errors {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            value: self.value.max(other.value),
            derivative: self.derivative.max(other.derivative),
        }
    }
}

/// What the plane of the polygon says: r and its derivatives, by the quotient rule in f64.
fn exact(sample: &oracle::Sample<4>, i: usize) -> (f64, [f64; 2]) {
    let (s, q) = (sample.values[i], sample.values[Q]);
    let slope = |s_: f64, q_: f64| (s_ * q - s * q_) / (q * q);
    (s / q, [slope(sample.dx[i], sample.dx[Q]), slope(sample.dy[i], sample.dy[Q])])
}

fn errors(shape: &Shape<4>, window: Window, planes: &[ClipPlane]) -> Errors {
    let polygon = vertices(shape);
    let mut errors = Errors::default();
    let Some(triple) = oracle::best_triple(&shape.positions) else { return errors };
    let outline = oracle::unrounded_outline(&shape.positions, window, Depth::ZeroToOne, 65536.0);
    let of = |i: usize| shape.parameters.iter().map(move |p| f64::from(p[i] / p[Q]).abs());
    let is_positive = shape.parameters.iter().all(|p| p[Q] > 0.0);
    let mut scan = ScanConverter::new(viewport(window));
    scan.settings.planes = planes.to_vec();
    for span in scan.spans(&polygon) {
        for fragment in span.fragments() {
            let point = [f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5];
            if oracle::distance_outside(&outline, point) > 0.0 {
                continue;
            }
            let Some(exact_at) =
                oracle::sample(&shape.positions, &shape.parameters, triple, window, point)
            else {
                continue;
            };
            let largest_q = shape.parameters.iter().map(|p| p[Q].abs()).fold(0.0, f32::max);
            if exact_at.values[Q].abs() < 1e-6 * f64::from(largest_q) {
                continue;
            }
            let found = fragment.divided([U, V], Q);
            assert_eq!(found.is_some(), exact_at.values[Q] > 0.0, "{fragment:?} of {shape:?}");
            // The promise is for ratios of w_r to 1000.
            let is_far = exact_at.values[Q] >= 1e-3 * f64::from(largest_q);
            let Some(found) = found.filter(|_| is_far) else { continue };
            let slopes = fragment.divided_derivatives([U, V], Q).expect("it is in front");
            for (i, (r, slopes)) in [U, V].into_iter().zip(found.into_iter().zip(slopes)) {
                let (exact_r, exact_slopes) = exact(&exact_at, i);
                // Where w_r changes its sign on the polygon, quotients have no largest, and the eye may cut it so that
                // ratios of w have no end. There numerator and denominator are each within the promise.
                let largest = if is_positive {
                    of(i).fold(0.0, f64::max)
                } else {
                    let most = |i: usize| {
                        shape.parameters.iter().map(|p| f64::from(p[i].abs())).fold(0.0, f64::max)
                    };
                    (most(i) + exact_r.abs() * most(Q)) / exact_at.values[Q]
                };
                let scale = largest + exact_slopes.map(f64::abs).iter().sum::<f64>();
                let off = |a: f32, b: f64| (f64::from(a) - b).abs();
                errors.value = errors.value.max(off(r, exact_r) / largest);
                for (a, b) in slopes.into_iter().zip(exact_slopes) {
                    errors.derivative = errors.derivative.max(off(a, b) / scale);
                }
            }
            errors.pixels += 1;
        }
    }
    errors
}

fn triangles(seed: u64) -> Errors {
    let rng = &mut Rng::new(seed);
    let ratio = |rng: &mut Rng| [1.0, 1.5, 30.0, 1000.0][rng.below(4)];
    let (w_ratio, q_ratio) = (ratio(rng), ratio(rng));
    let mut shape = generators::random_triangle::<4>(rng, w_ratio, 1.5);
    with_cluster(rng, &mut shape, q_ratio);
    let planes: Vec<_> = (0..rng.below(3))
        .map(|_| {
            let [x, y, z] = from_fn(|_| rng.range(-1.0, 1.0) as f32);
            ClipPlane::new(vec4(x, y, z, 0.5))
        })
        .collect();
    let errors = errors(&shape, WINDOW, &planes);
    let worst = errors.value.max(errors.derivative);
    assert!(worst <= PROMISED, "seed {seed}: {errors:?} in {shape:?}");
    errors
}

/// Ratios of w and of w_r to 1000, each independent of the other, clipped by planes or not.
#[test]
fn clusters_keep_the_promise_at_any_ratio_and_cut() {
    let errors = in_threads(0..400, triangles);
    assert!(errors.pixels > 100_000, "only {} pixels were compared", errors.pixels);
}

fn cut_by_the_eye(seed: u64) -> Errors {
    let rng = &mut Rng::new(seed);
    let sides = 3 + rng.below(8);
    let shape = if rng.once_in(2) {
        generators::through_eye(rng, sides)
    } else {
        generators::random_convex(rng, sides, 100.0)
    };
    let errors = errors(&shape, WINDOW, &[]);
    let worst = errors.value.max(errors.derivative);
    assert!(worst <= PROMISED, "seed {seed}: {errors:?} in {shape:?}");
    errors
}

/// Polygons that reach behind the eye, whose w_r changes its sign on them as often as not: where it is not
/// positive there is nothing.
#[test]
fn nothing_is_found_behind_the_centre_of_a_cluster() {
    let errors = in_threads(0..300, cut_by_the_eye);
    assert!(errors.pixels > 50_000, "only {} pixels were compared", errors.pixels);
}

#[test]
#[ignore = "long: a minute in release"]
fn long_clusters() {
    let errors = in_threads(LONG_SEED..LONG_SEED + 20_000, triangles);
    println!("triangles: {errors:?}");
    let errors = in_threads(LONG_SEED..LONG_SEED + 20_000, cut_by_the_eye);
    println!("polygons of either sign: {errors:?}");
}

#[test]
fn the_last_pixel_of_16384_is_as_exact_as_the_first() {
    let window = Window { width: 16384, height: 4 };
    for (w, q) in
        [([1.0, 1000.0, 30.0], [1000.0, 1.0, 7.0]), ([1000.0, 1.0, 5.0], [1.0, 1000.0, 5.0])]
    {
        let places = [[-1.0, -3.0], [1.0, -3.0], [0.3, 5.0]];
        let corners = places.into_iter().zip(w);
        let shape: Shape<4> = Shape {
            positions: corners.map(|([x, y], w)| [x * w, y * w, 0.5 * w, w]).collect(),
            parameters: q.iter().map(|q| [0.0, 0.3 * q, *q, -0.7]).collect(),
        };
        let errors = errors(&shape, window, &[]);
        assert!(errors.pixels > 30_000 && errors.value < PROMISED, "{errors:?}");
        assert!(errors.derivative < PROMISED, "{errors:?}");
    }
}

// ------------------------------------------------------------------------- shaders and renderers

/// What is seen of a cluster at a pixel, as bits.
type Seen = [u32; 7];

fn seen(footprint: Option<Footprint>) -> Seen {
    footprint.map_or([7; 7], |Footprint { uv, dx, dy }| {
        [uv.x, uv.y, dx.x, dx.y, dy.x, dy.y, 1.0].map(f32::to_bits)
    })
}

fn by_fragment<const N: usize>(fragment: &Fragment<'_, N>) -> Seen {
    let footprint = fragment.divided_footprint([U, V], Q);
    let found = fragment.divided([U, V], Q);
    assert_eq!(footprint.map(|f| f.uv.to_array()), found);
    let slopes = footprint.map(|Footprint { dx, dy, .. }| [[dx.x, dy.x], [dx.y, dy.y]]);
    assert_eq!(slopes, fragment.divided_derivatives([U, V], Q));
    seen(footprint)
}

fn by_block<const N: usize>(block: &FragmentBlock<'_, N>) -> [Seen; LANES] {
    let (footprints, lit) = block.divided_footprint([U, V], Q);
    let ([u, v], same) = block.divided([U, V], Q);
    assert_eq!((lit, lit & !block.visible), (same, 0));
    from_fn(|lane| {
        let is_lit = lit >> lane & 1 != 0;
        assert!(!is_lit || footprints.get(lane).uv.to_array() == [u[lane], v[lane]]);
        seen(is_lit.then(|| footprints.get(lane)))
    })
}

/// Quads with any values at their corners, triangles, polygons whose w are equal, some through the eye.
fn scene(rng: &mut Rng) -> (Vec<Vertex<4>>, Vec<Vec<u32>>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for _ in 0..12 {
        let sides = 3 + rng.below(3);
        let first = vertices.len() as u32;
        faces.push((first..first + sides as u32).collect());
        let plane = vec3(rng.range(-1.0, 1.0) as f32, rng.range(-1.0, 1.0) as f32, 2.0);
        let one_w = rng.once_in(3);
        let q: [f32; 4] = from_fn(|_| rng.range(-1.0, 2.0) as f32);
        let is_affine = rng.once_in(2);
        for k in 0..sides {
            let angle = k as f32 / sides as f32 * std::f32::consts::TAU + plane.x;
            let place = vec3(0.9 * angle.cos(), 0.9 * angle.sin(), 1.0);
            let w = if one_w { 2.0 } else { place.dot(plane) };
            let params = from_fn(|i| {
                if is_affine {
                    place.dot(vec3(q[i], q[(i + 1) % 4], 1.0))
                } else {
                    rng.range(-0.5, 2.0) as f32
                }
            });
            vertices.push(Vertex::new(vec4(place.x * 1.5, place.y * 1.5, w * 0.5, w), params));
        }
    }
    (vertices, faces)
}

fn settings(rng: &mut Rng, viewport: Viewport) -> Settings<4> {
    let mut settings = Settings::new(viewport);
    if rng.once_in(3) {
        use Interpolation::{Flat, Linear, Perspective};
        settings.interpolation = from_fn(|_| [Perspective, Linear, Flat][rng.below(3)]);
    }
    settings
}

/// The z-buffer renderer by both kinds of shaders, as a mesh and face by face, and the scanline renderer, whole
/// and in tiles: the same bits. The painter's renderer draws one face at a time, for the same pixels.
#[test]
fn all_renderers_and_shaders_see_the_same() {
    let (width, height) = (70, 50);
    let mut lit = 0;
    for seed in 0..60 {
        let rng = &mut Rng::new(seed);
        let (vertices, faces) = scene(rng);
        let blank = || Framebuffer::new(width, height, [0; 7]).expect("a small frame");
        let mut renderer = ZBufferRenderer::new(blank().viewport());
        renderer.settings = settings(rng, blank().viewport());
        let mut first = blank();
        renderer.draw(&mut first, Mesh::new(&vertices, &faces), dynamic(by_fragment));
        lit += first.color().iter().filter(|seen| !matches!(seen[6], 0 | 7)).count();

        let mut blocks = blank();
        renderer.draw_blocks(
            &mut blocks,
            Mesh::new(&vertices, &faces),
            dynamic_blocks(|block, colors| {
                *colors = by_block(block);
            }),
        );
        assert_eq!(first.color(), blocks.color(), "seed {seed}: blocks");

        let mut one_by_one = blank();
        for face in &faces {
            let polygon: Vec<_> = face.iter().map(|&i| vertices[i as usize]).collect();
            renderer.draw(&mut one_by_one, &polygon, dynamic(by_fragment));
        }
        assert_eq!(first.color(), one_by_one.color(), "seed {seed}: one by one");

        let mut by_rows = blank();
        let mut scanline = ScanlineRenderer::new(blank().viewport());
        scanline.settings = renderer.settings.clone();
        scanline.draw(
            &mut by_rows,
            Mesh::new(&vertices, &faces),
            dynamic(|f: &Fragment<'_, 4>| Some(by_fragment(f))),
        );
        assert_eq!(first.color(), by_rows.color(), "seed {seed}: scanline");

        let tree = BspTree::new(&vertices, &faces[..1]);
        let (mut painted, mut alone) = (blank(), blank());
        let mut painter = PainterRenderer::new(blank().viewport());
        painter.settings = renderer.settings.clone();
        painter.draw(
            &mut painted,
            tree.seen_by(Mat4::IDENTITY),
            dynamic(|f: &Fragment<'_, 4>| Some(by_fragment(f))),
        );
        renderer.draw(&mut alone, Mesh::new(&vertices, &faces[..1]), dynamic(by_fragment));
        if tree.pieces() == 1 {
            assert_eq!(alone.color(), painted.color(), "seed {seed}: painter's");
        }

        let (x, y) = (rng.below(60) as i32, rng.below(40) as i32);
        let mut tile = Framebuffer::new(10, 10, [0; 7]).expect("a small frame");
        renderer.settings.viewport = blank().viewport().with_corner(-x, -y);
        renderer.draw_blocks(
            &mut tile,
            Mesh::new(&vertices, &faces),
            dynamic_blocks(|block, colors| {
                *colors = by_block(block);
            }),
        );
        for (i, seen) in tile.color().iter().enumerate() {
            let place = (x + i as i32 % 10, y + i as i32 / 10);
            let whole = first.color()[(place.1 * width as i32 + place.0) as usize];
            assert_eq!(*seen, whole, "seed {seed}: tile at {place:?}");
        }
    }
    assert!(lit > 20_000, "only {lit} pixels have a cluster");
}

/// Where values are not affine on the polygon, and where numerators and denominator are interpolated in different
/// ways, a cluster is the quotient of what fragments have.
#[test]
fn mixed_clusters_are_quotients_of_the_parameters() {
    let mut compared = 0;
    for seed in 0..60 {
        let rng = &mut Rng::new(seed);
        let (vertices, faces) = scene(rng);
        let mut scan = ScanConverter::new(Viewport::new(70, 50).expect("small"));
        scan.settings = settings(rng, scan.settings.viewport);
        for face in &faces {
            let polygon: Vec<_> = face.iter().map(|&i| vertices[i as usize]).collect();
            for span in scan.spans(&polygon) {
                for fragment in span.fragments() {
                    let q = fragment.params[Q];
                    if q.abs() < 0.05 {
                        continue;
                    }
                    let found = fragment.divided([U, V], Q);
                    assert_eq!(found.is_some(), q > 0.0);
                    for (i, r) in [U, V].into_iter().zip(found.into_iter().flatten()) {
                        let wanted = fragment.params[i] / q;
                        assert!(
                            (r - wanted).abs() < 1e-4 * (1.0 + wanted.abs()),
                            "{r} for {wanted}"
                        );
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 50_000, "only {compared} values were compared");
}

#[test]
fn parameters_that_are_not_there_are_in_no_cluster() {
    let triangle = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]
        .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, 1.0]));
    let mut scan = ScanConverter::new(Viewport::new(8, 8).expect("small"));
    for span in scan.spans(&triangle) {
        let fragment = span.fragments().next().expect("spans are not empty");
        assert!(fragment.divided([0], 1).is_some());
        assert!(fragment.divided([2], 1).is_none() && fragment.divided([0], 2).is_none());
        assert!(fragment.divided_footprint([0, 2], 1).is_none());
        assert!(fragment.divided_derivatives([0], usize::MAX).is_none());
        span.for_each_block(polyscan::Level::new(), |block| {
            assert_eq!(block.divided([2], 1).1 | block.divided([0], 9).1, 0);
            assert_eq!(block.divided_footprint([0, 2], 1).1, 0);
        });
    }
}

// -------------------------------------------------------------------------------------- what for

/// A projective transformation of the object itself: texture coordinates are affine before it, positions in the
/// world after it. Both against the ray of the pixel, in f64.
#[test]
fn perspective_transformations_may_model() {
    let model = Mat4::from_cols(
        vec4(1.0, 0.0, 0.0, 0.4),
        vec4(0.2, 1.0, 0.0, -0.2),
        vec4(0.0, 0.1, 1.0, 0.3),
        vec4(0.0, 0.0, 0.0, 1.0),
    );
    let camera = glam::camera::rh::proj::directx::perspective(0.8, 1.5, 0.1, 100.0)
        * Mat4::from_translation(vec3(0.1, 0.0, -4.0))
        * Mat4::from_rotation_y(0.5);
    let size = (90, 60);
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let polygon = square.map(|(x, y): (f32, f32)| {
        let world = model * vec4(x, y, 0.0, 1.0);
        let [a, b, c, d] = world.to_array();
        Vertex::new(camera * world, [x, y, a, b, c, d])
    });
    let whole = camera.as_dmat4() * model.as_dmat4();
    let mut compared = 0;
    let mut scan = ScanConverter::new(Viewport::new(size.0, size.1).expect("small"));
    for span in scan.spans(&polygon) {
        for fragment in span.fragments() {
            let ndc = [
                (f64::from(fragment.x) + 0.5) / f64::from(size.0) * 2.0 - 1.0,
                1.0 - (f64::from(fragment.y) + 0.5) / f64::from(size.1) * 2.0,
            ];
            let [x, y] = on_the_plane_z(&whole, ndc);
            let world = model.as_dmat4() * DVec4::new(x, y, 0.0, 1.0);
            let exact = world.truncate() / world.w;
            let found = Vec3::from(fragment.divided([2, 3, 4], 5).expect("in front")).as_dvec3();
            assert!((found - exact).length() < 2e-6, "{found} for {exact}");
            let uv = [x - f64::from(fragment.params[0]), y - f64::from(fragment.params[1])];
            assert!(uv.iter().all(|off| off.abs() < 1e-5), "{uv:?}");
            compared += 1;
        }
    }
    assert!(compared > 500, "only {compared} pixels");
}

/// The point (x, y, 0) that a matrix brings to a point of the screen: where x X + y Y + O is on its ray.
fn on_the_plane_z(clip: &DMat4, [sx, sy]: [f64; 2]) -> [f64; 2] {
    let row = |i: usize| DVec3::new(clip.col(0)[i], clip.col(1)[i], clip.col(3)[i]);
    let point = (row(0) - row(3) * sx).cross(row(1) - row(3) * sy);
    [point.x / point.z, point.y / point.z]
}

/// A corner of a square floor of twice this size, in order around it.
fn floor_corner(k: usize, size: f32) -> Vec3 {
    let (x, z) = [(-size, -size), (size, -size), (size, size), (-size, size)][k % 4];
    vec3(x, 0.0, z)
}

/// Where the ray of a pixel meets the plane y = 0, in f64.
fn on_the_floor(inverse: &DMat4, (x, y): (i32, i32), size: (u32, u32)) -> DVec3 {
    let x = (f64::from(x) + 0.5) / f64::from(size.0) * 2.0 - 1.0;
    let y = 1.0 - (f64::from(y) + 0.5) / f64::from(size.1) * 2.0;
    let [near, far] = [0.0, 1.0].map(|z| inverse.project_point3(DVec3::new(x, y, z)));
    near + (far - near) * (near.y / (near.y - far.y))
}

/// A slide that is projected on a floor, each of whose corners in turn is behind the projector, and behind the camera:
/// each pixel has the place in the slide that a ray through it has, and nothing behind the projector has one.
#[test]
fn a_slide_is_projected_in_front_of_the_projector_alone() {
    use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
    let (size, mut all_dark) = ((150, 100), 0);
    for (k, of_camera) in (0..4).flat_map(|k| (0..4).map(move |of_camera| (k, of_camera))) {
        let above = |k: usize, y: f32| floor_corner(k, 5.0) + Vec3::Y * y;
        let projector = perspective(1.2, 1.0, 0.1, 100.0)
            * look_at_mat4(above(k, 2.0), floor_corner(k + 2, 2.0), Vec3::Y);
        let camera = perspective(1.6, 1.5, 0.1, 100.0)
            * look_at_mat4(above(of_camera, 4.0), floor_corner(of_camera + 2, 1.0), Vec3::Y);
        let floor = [0, 1, 2, 3].map(|i| floor_corner(i, 9.0).extend(1.0));
        assert!((projector * floor[k]).w < 0.0 && (camera * floor[of_camera]).w < 0.0);
        let floor = floor.map(|p: Vec4| Vertex::new(camera * p, projector * p));
        let inverse = camera.as_dmat4().inverse();
        let (mut lit, mut dark) = (0, 0);
        let mut scan = ScanConverter::new(Viewport::new(size.0, size.1).expect("small"));
        for span in scan.spans(&floor) {
            for fragment in span.fragments() {
                let world = on_the_floor(&inverse, (fragment.x, fragment.y), size);
                let slide = projector.as_dmat4() * world.extend(1.0);
                let found = fragment.divided([0, 1], 3);
                if slide.w.abs() > 1e-3 {
                    assert_eq!(found.is_some(), slide.w > 0.0, "at {world}");
                }
                if let Some([u, v]) = found.filter(|uv| uv.iter().all(|c| c.abs() <= 1.0)) {
                    let (u_off, v_off) =
                        (f64::from(u) - slide.x / slide.w, f64::from(v) - slide.y / slide.w);
                    assert!(u_off.hypot(v_off) < 1e-5, "{u_off} {v_off} at {world}");
                    lit += 1;
                }
                dark += i32::from(found.is_none());
            }
        }
        assert!(lit > 500, "{lit} lit");
        all_dark += dark;
    }
    assert!(all_dark > 2_000, "{all_dark} behind the projector");
}

/// A map of shadows, by depth alone as the light sees them, finds what rays to the light find in f64, but within two
/// texels of a shadow's edge. Each corner of the floor in turn is behind the light.
#[test]
fn maps_of_shadows_find_what_rays_find() {
    use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
    const HEIGHT: f64 = 1.0;
    let (size, texels) = ((120, 80), 512);
    for k in 0..4 {
        let light_at = floor_corner(k, 3.0) + Vec3::Y * 4.0;
        let light = perspective(1.0, 1.0, 0.5, 60.0) * look_at_mat4(light_at, Vec3::ZERO, Vec3::Y);
        let camera = perspective(1.2, 1.5, 0.1, 100.0)
            * look_at_mat4(floor_corner(k + 1, 4.0) + Vec3::Y * 5.0, Vec3::ZERO, Vec3::Y);
        let floor = [0, 1, 2, 3].map(|i| floor_corner(i, 9.0));
        let roof = [0, 1, 2, 3].map(|i| floor_corner(i, 1.0) + Vec3::Y * HEIGHT as f32);
        assert!((light * floor[k].extend(1.0)).w < 0.0);

        let mut map = Framebuffer::new(texels, texels, ()).expect("small");
        let mut renderer = ZBufferRenderer::new(map.viewport());
        renderer.settings.depth_bias = polyscan::DepthBias { constant: 1e-5, slope: 1.0 };
        for face in [floor, roof] {
            renderer.draw_depth(&mut map, &face.map(|p| Vertex::new(light * p.extend(1.0), [])));
        }

        let inverse = camera.as_dmat4().inverse();
        let seen = floor.map(|p| Vertex::new(camera * p.extend(1.0), light * p.extend(1.0)));
        let (mut lit, mut shadowed) = (0, 0);
        let mut scan = ScanConverter::new(Viewport::new(size.0, size.1).expect("small"));
        for span in scan.spans(&seen) {
            for fragment in span.fragments() {
                let world = on_the_floor(&inverse, (fragment.x, fragment.y), size);
                let Some([x, y, z]) = fragment.divided([0, 1, 2], 3) else {
                    assert!((light.as_dmat4() * world.extend(1.0)).w < 1e-3);
                    continue;
                };
                let (u, v) = ((x + 1.0) / 2.0 * texels as f32, (1.0 - y) / 2.0 * texels as f32);
                if x.abs() > 0.99 || y.abs() > 0.99 {
                    continue;
                }
                let (_, depth) = map.pixel(u as u32, v as u32).expect("within the map");
                let to_light = light_at.as_dvec3() - world;
                let through = world + to_light * (HEIGHT / to_light.y);
                // How far inside of the roof, if it is: on the map it is some 300 texels a unit.
                let inside = 1.0 - through.x.abs().max(through.z.abs());
                if inside.abs() < 0.02 {
                    continue;
                }
                assert_eq!(z <= depth, inside < 0.0, "at {world}: {z} and {depth}");
                lit += i32::from(inside < 0.0);
                shadowed += i32::from(inside > 0.0);
            }
        }
        assert!(lit > 500 && shadowed > 100, "{lit} lit, {shadowed} in the shadow");
    }
}

/// Scratchapixel's triangle, with its numbers, against barycentric coordinates of the screen and 1/z in f64, as the
/// lesson has them.
#[test]
fn scratchapixels_triangle_has_the_lessons_colours() {
    let corners: [[f64; 3]; 3] = [[13.0, 34.0, 114.0], [29.0, -15.0, 44.0], [-48.0, -10.0, 82.0]];
    let colors = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let places = corners.map(|[x, y, z]| [(1.0 + x / z) * 256.0, (1.0 - y / z) * 256.0]);
    let edge = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        (p[0] - a[0]) * (b[1] - a[1]) - (p[1] - a[1]) * (b[0] - a[0])
    };
    let triangle: [Vertex<4>; 3] = from_fn(|i| {
        let [x, y, z] = corners[i].map(|c| c as f32);
        let [r, g, b] = colors[i];
        // Its colours once more, as a cluster with another w at each corner.
        Vertex::new(vec4(x, y, z / 2.0, z), [r as f32, g as f32, b as f32, 1.0 + i as f32])
    });
    let mut scan = ScanConverter::new(Viewport::new(512, 512).expect("small"));
    let mut pixels = 0;
    for span in scan.spans(&triangle) {
        for fragment in span.fragments() {
            let p = [f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5];
            let weights: [f64; 3] =
                from_fn(|i| edge(places[(i + 1) % 3], places[(i + 2) % 3], p) / corners[i][2]);
            let total: f64 = weights.iter().sum();
            for (channel, found) in fragment.params.into_iter().take(3).enumerate() {
                let parts =
                    weights.iter().zip(&colors).map(|(w, color)| w / total * color[channel]);
                assert!((f64::from(found) - parts.sum::<f64>()).abs() < 1e-6);
            }
            let q = (0..3).map(|i| weights[i] / total * (1.0 + i as f64)).sum::<f64>();
            let [r, g, b] = fragment.divided([0, 1, 2], 3).expect("positive");
            let wanted = weights.map(|weight| weight / total / q);
            for (found, wanted) in [b, g, r].into_iter().zip(wanted) {
                assert!((f64::from(found) - wanted).abs() < 1e-6);
            }
            pixels += 1;
        }
    }
    let area = edge(places[0], places[1], places[2]).abs() / 2.0;
    assert!((f64::from(pixels) - area).abs() < 300.0, "{pixels} pixels, of an area of {area}");
}
