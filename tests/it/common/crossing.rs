//! Scenes of polygons through each other, how they are seen, and which polygon is nearer where.
//!
//! The order comes from the plane of each polygon, found in object space in f64 and brought to clip
//! space. It knows nothing of the renderers.

use std::array::from_fn;
use std::f32::consts::TAU;

use glam::camera::rh::proj::{directx, opengl};
use glam::camera::rh::view::look_at_mat4;
use glam::{DVec3, DVec4, Mat4, Quat, Vec2, Vec3, Vec4, vec3};
use polyscan::{
    ClipSpace, DepthMode, Fragment, Framebuffer, ScanConverter, Vertex, Viewport, ZBufferRenderer,
};

use super::generators::Rng;
use crate::common::dynamic;

pub(crate) const WIDTH: u32 = 64;
pub(crate) const HEIGHT: u32 = 48;

// ------------------------------------------------------------------------------------------ scenes

/// Faces in object space, with w = 1.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scene {
    pub(crate) vertices: Vec<Vertex<2>>,
    pub(crate) faces: Vec<Vec<u32>>,
}

impl Scene {
    pub(crate) fn add(&mut self, corners: impl IntoIterator<Item = Vec3>, rng: &mut Rng) {
        let first = self.vertices.len() as u32;
        let vertex =
            |p: Vec3| Vertex::new(p.extend(1.0), [0; 2].map(|_| rng.range(-1.0, 1.0) as f32));
        self.vertices.extend(corners.into_iter().map(vertex));
        self.faces.push((first..self.vertices.len() as u32).collect());
    }

    /// A surface over u and v of 0..1, as a grid of quads, flat or nearly so.
    pub(crate) fn add_surface(
        &mut self,
        [columns, rows]: [u32; 2],
        place: impl Fn(f32, f32) -> Vec3,
    ) {
        let first = self.vertices.len() as u32;
        for (i, j) in (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j))) {
            let uv = Vec2::new(i as f32 / columns as f32, j as f32 / rows as f32);
            self.vertices.push(Vertex::new(place(uv.x, uv.y).extend(1.0), uv));
        }
        for (i, j) in (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))) {
            let corner = |i, j| first + j * (columns + 1) + i;
            let quad = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            self.faces.push(quad.to_vec());
        }
    }

    pub(crate) fn in_clip_space(&self, view: &View) -> Vec<Vertex<2>> {
        let vertex = |v: &Vertex<2>| Vertex { position: view.matrix * v.position, ..*v };
        self.vertices.iter().map(vertex).collect()
    }

    pub(crate) fn plane(&self, face: &[u32]) -> DVec4 {
        newell(face.iter().map(|&i| self.vertices[i as usize].position.as_dvec4()))
    }
}

/// The plane of a polygon with w = 1: the sum of the cross products of its sides' ends, through the
/// centroid.
pub(crate) fn newell(polygon: impl Iterator<Item = DVec4>) -> DVec4 {
    let polygon: Vec<DVec3> = polygon.map(DVec4::truncate).collect();
    let centre = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let side = |i: usize| {
        let [a, b] = [i, (i + 1) % polygon.len()].map(|i| polygon[i] - centre);
        a.cross(b)
    };
    let normal = (0..polygon.len()).map(side).sum::<DVec3>().normalize_or_zero();
    normal.extend(-normal.dot(centre))
}

pub(crate) fn direction(rng: &mut Rng) -> Vec3 {
    loop {
        let v = Vec3::from_array(from_fn(|_| rng.range(-1.0, 1.0) as f32));
        if (0.01..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

/// Triangles and flat polygons of up to eight sides, of any size, through each other.
pub(crate) fn random_scene(rng: &mut Rng) -> Scene {
    let mut scene = Scene::default();
    for _ in 0..2 + rng.below(11) {
        let point = |rng: &mut Rng| Vec3::from_array(from_fn(|_| rng.range(-1.0, 1.0) as f32));
        if rng.once_in(2) {
            let corners: [Vec3; 3] = from_fn(|_| point(rng));
            scene.add(corners, rng);
        } else {
            let sides = 3 + rng.below(6);
            let turn = Quat::from_rotation_arc(Vec3::Z, direction(rng));
            let (centre, size) = (point(rng) * 0.5, rng.octaves(0.2, 1.5) as f32);
            let angle = |i: usize| TAU * i as f32 / sides as f32;
            let corner = |i| centre + turn * Vec3::from((Vec2::from_angle(angle(i)) * size, 0.0));
            scene.add((0..sides).map(corner).collect::<Vec<_>>(), rng);
        }
    }
    scene
}

/// Balls, rings and boxes through each other.
pub(crate) fn solids(rng: &mut Rng) -> Scene {
    let mut scene = Scene::default();
    for kind in [0, 1, 2, rng.below(3)] {
        let turn = Quat::from_rotation_arc(Vec3::Z, direction(rng));
        let (centre, size) = (direction(rng) * 0.5, rng.range(0.3, 0.9) as f32);
        let place = |p: Vec3| centre + turn * p * size;
        let circle = |t: f32| Vec2::from_angle(TAU * t);
        match kind {
            0 => scene.add_surface([16, 8], |u, v| {
                let (level, around) = (Vec2::from_angle((v - 0.5) * TAU / 2.0), circle(u));
                place((around * level.x).extend(level.y))
            }),
            1 => scene.add_surface([16, 8], |u, v| {
                place((circle(u) * (1.0 + 0.4 * circle(v).x)).extend(0.4 * circle(v).y))
            }),
            _ => {
                let square =
                    [vec3(-1.0, -1.0, 1.0), vec3(1.0, -1.0, 1.0), Vec3::ONE, vec3(-1.0, 1.0, 1.0)];
                for axis in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z] {
                    let side = Quat::from_rotation_arc(Vec3::Z, axis);
                    scene.add(square.map(|p| place(side * p * 0.7)), rng);
                }
            }
        }
    }
    scene
}

/// How a scene is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) matrix: Mat4,
    pub(crate) clip_space: ClipSpace,
    pub(crate) reversed: bool,
}

impl View {
    /// A frame without anything in it.
    pub(crate) fn frame<C: Copy>(&self) -> Framebuffer<Option<C>> {
        let mut frame = Framebuffer::new(WIDTH, HEIGHT, None).expect("a small frame");
        frame.clear(None, if self.reversed { 0.0 } else { 1.0 });
        frame
    }

    pub(crate) fn depth_mode(&self) -> DepthMode {
        if self.reversed { DepthMode::Reversed } else { DepthMode::Standard }
    }
}

/// An eye anywhere around or in the scene, and each kind of projection in turn.
pub(crate) fn random_view(rng: &mut Rng) -> View {
    let eye = direction(rng) * rng.range(0.3, 5.0) as f32;
    let camera = look_at_mat4(eye, direction(rng) * 0.2, direction(rng));
    let aspect = WIDTH as f32 / HEIGHT as f32;
    let [gl, dx] = [ClipSpace::MinusOneToOne, ClipSpace::ZeroToOne];
    let (projection, clip_space, reversed) = match rng.below(6) {
        0 => (directx::perspective(0.8, aspect, 0.3, 9.0), dx, false),
        1 => (directx::perspective_infinite(0.8, aspect, 0.3), dx, false),
        2 => (directx::perspective_infinite_reverse(0.8, aspect, 0.1), dx, true),
        3 => (opengl::perspective(0.8, aspect, 0.3, 9.0), gl, false),
        4 => (directx::orthographic(-2.0, 2.0, -1.5, 1.5, -4.0, 9.0), dx, false),
        // The far plane first: depth runs the other way.
        _ => (directx::orthographic(-2.0, 2.0, -1.5, 1.5, 9.0, -4.0), dx, true),
    };
    View { matrix: projection * camera, clip_space, reversed }
}

// --------------------------------------------------------------------------------------- pictures

/// A fragment: its face and the bits of its depth, w and parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Layer {
    pub(crate) face: u32,
    pub(crate) bits: [u32; 4],
}

pub(crate) fn layer(fragment: &Fragment<'_, 2>) -> Layer {
    let [u, v] = fragment.params;
    Layer { face: fragment.face, bits: [fragment.depth, fragment.w, u, v].map(f32::to_bits) }
}

/// What the z-buffer shows.
pub(crate) fn by_z_buffer(
    scene: &Scene,
    vertices: &[Vertex<2>],
    view: &View,
) -> Framebuffer<Option<Layer>> {
    let mut frame = view.frame();
    let mut renderer = ZBufferRenderer::new(frame.viewport());
    renderer.settings.clip_space = view.clip_space;
    renderer.settings.depth = view.depth_mode();
    renderer.draw(
        &mut frame,
        polyscan::Mesh::new(vertices, &scene.faces),
        dynamic(|f| Some(Some(layer(f)))),
    );
    frame
}

/// A scan converter that sees what the view does.
pub(crate) fn scan(view: &View) -> ScanConverter<2> {
    let mut scan = ScanConverter::new(Viewport::new(WIDTH, HEIGHT).expect("small"));
    scan.settings.clip_space = view.clip_space;
    scan
}

// ------------------------------------------------------------------------------------------ oracle

/// z/w of a face as a function of the place on the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Depth {
    /// (a, b, c): z/w = a X + b Y + c in normalised device coordinates.
    plane: [f64; 3],
    /// How far the face as it is drawn may be from there.
    off: f64,
}

impl Depth {
    /// The depth of a plane in object space, and how far off a face's vertices are in clip space.
    /// To this comes the f32 in which a renderer evaluates depth: 2^-24 * 6 by `Line`'s derivation,
    /// for depths of at most 1.
    pub(crate) fn new(plane: DVec4, view: &View, face: impl Iterator<Item = Vec4>) -> Self {
        let form = view.matrix.as_dmat4().inverse().transpose() * plane;
        let unit = f64::from(f32::EPSILON) / 2.0;
        let off = face.filter(|p| p.w > 0.0).map(|p| {
            let p = p.as_dvec4();
            // Its own rounding, and the tree's tolerance, of which it does not know more.
            (form.dot(p).abs() + unit * form.abs().dot(p.abs())) / (form.z.abs() * p.w)
        });
        let range = if view.clip_space == ClipSpace::ZeroToOne { 1.0 } else { 2.0 };
        let off = off.fold(0.0, f64::max) + 6.0 * unit * range;
        Self { plane: [form.x, form.y, form.w].map(|c| -c / form.z), off }
    }
}

/// How the depths of two faces compare at the centre of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Order {
    Less,
    Greater,
    /// They are equal within half a subpixel (by which a vertex is rounded) of the centre, or as near
    /// to each other as their roundings.
    Crossing,
}

pub(crate) fn order(a: &Depth, b: &Depth, pixel: usize) -> Order {
    let (x, y) = (pixel % WIDTH as usize, pixel / WIDTH as usize);
    let (mut less, mut greater) = (true, true);
    for (dx, dy) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let ndc_x = 2.0 * (x as f64 + 0.5 + dx / 512.0) / f64::from(WIDTH) - 1.0;
        let ndc_y = 1.0 - 2.0 * (y as f64 + 0.5 + dy / 512.0) / f64::from(HEIGHT);
        let [da, db] = [a, b].map(|d| d.plane[0] * ndc_x + d.plane[1] * ndc_y + d.plane[2]);
        less &= da - db < -(a.off + b.off);
        greater &= da - db > a.off + b.off;
    }
    match (less, greater) {
        (true, _) => Order::Less,
        (_, true) => Order::Greater,
        _ => Order::Crossing,
    }
}

/// The depths of all faces.
pub(crate) fn depths(scene: &Scene, vertices: &[Vertex<2>], view: &View) -> Vec<Depth> {
    let depth = |face: &Vec<u32>| {
        let clip = face.iter().map(|&i| vertices[i as usize].position);
        Depth::new(scene.plane(face), view, clip)
    };
    scene.faces.iter().map(depth).collect()
}
