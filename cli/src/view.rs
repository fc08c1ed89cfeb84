//! From where a model is seen.

use polyscan::Model;
use polyscan::camera::{Camera, Sphere};
use polyscan::formats::Format;
use polyscan::glam::{DMat4, DVec3, DVec4, Mat3, Mat4, Vec3, vec3};

use crate::options::{Eye, Options};

/// A view of a model.
#[derive(Clone, Copy)]
pub(crate) struct View {
    pub(crate) clip_from_object: Mat4,
    /// To the right, up, and towards the camera, in the model's space.
    pub(crate) axes: Mat3,
}

impl View {
    /// The view of a model, and of the sphere around it, that the options ask for, after further turns in degrees.
    pub(crate) fn of(
        (model, sphere): (&Model, Sphere),
        format: Format,
        options: &Options,
        turn: (f32, f32),
    ) -> Self {
        let origin = DMat4::from_translation(model.origin);
        if let Some(matrix) = options.matrix {
            return Self::by_matrix(matrix * origin);
        }
        if let (Some(intrinsics), Some(pose)) = (options.intrinsics, options.pose) {
            return Self::by_opencv(model, intrinsics, pose * origin, options.size);
        }
        let (width, height) = options.size;
        let aspect = width as f32 / height as f32;
        Self::around(sphere, format, &options.eye, aspect, turn)
    }

    /// The view of an eye that looks at a sphere, after further turns in degrees.
    pub(crate) fn around(
        sphere: Sphere,
        format: Format,
        eye: &Eye,
        aspect: f32,
        turn: (f32, f32),
    ) -> Self {
        let default = if format == Format::Stl { Vec3::Z } else { Vec3::Y };
        let camera = Camera::around(sphere, aspect)
            .with_up(eye.up.unwrap_or(default))
            .with_field_of_view(eye.fov.to_radians())
            .turned((eye.yaw + turn.0).to_radians(), (eye.pitch + turn.1).to_radians());
        let axes = camera.axes();
        let clip_from_object = if eye.orthographic {
            orthographic(sphere, axes, aspect)
        } else {
            camera.clip_from_object()
        };
        Self { clip_from_object, axes }
    }

    fn by_matrix(clip_from_object: DMat4) -> Self {
        let back = clip_from_object.inverse();
        let place = |x, y, z| back.project_point3(DVec3::new(x, y, z));
        let ahead = (place(0.0, 0.0, 0.9) - place(0.0, 0.0, 0.1)).normalize_or(DVec3::NEG_Z);
        let right = (place(1.0, 0.0, 0.5) - place(0.0, 0.0, 0.5)).normalize_or(DVec3::X);
        let up = right.cross(ahead).normalize_or(DVec3::Y);
        let axes = Mat3::from_cols(right.as_vec3(), up.as_vec3(), -ahead.as_vec3());
        Self { clip_from_object: clip_from_object.as_mat4(), axes }
    }

    /// OpenCV's camera: x right, y down, z ahead; whole pixel coordinates are at the centres of pixels.
    fn by_opencv(
        model: &Model,
        [fx, fy, cx, cy]: [f64; 4],
        pose: DMat4,
        (width, height): (u32, u32),
    ) -> Self {
        let (width, height) = (f64::from(width), f64::from(height));
        let (low, high) = model.bounds().unwrap_or_default();
        let corner = |i: usize| {
            let pick = |bit: usize, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
            let corner =
                vec3(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z));
            pose.transform_point3(corner.as_dvec3()).z
        };
        let far = (0..8).map(corner).fold(f64::MIN_POSITIVE, f64::max) * 1.01;
        let near = (0..8).map(corner).fold(f64::INFINITY, f64::min).max(far * 1e-4) * 0.99;
        // Rows; w is the distance ahead.
        let rows = [
            DVec4::new(2.0 * fx / width, 0.0, 2.0 * (cx + 0.5) / width - 1.0, 0.0),
            DVec4::new(0.0, -2.0 * fy / height, 1.0 - 2.0 * (cy + 0.5) / height, 0.0),
            DVec4::new(0.0, 0.0, far / (far - near), -far * near / (far - near)),
            DVec4::new(0.0, 0.0, 1.0, 0.0),
        ];
        let [x, y, z, w] = rows;
        let projection = DMat4::from_cols(x, y, z, w).transpose();
        let turn = pose.transpose();
        let axis =
            |column: DVec4, sign: f64| (column.truncate() * sign).normalize_or_zero().as_vec3();
        let axes = Mat3::from_cols(
            axis(turn.x_axis, 1.0),
            axis(turn.y_axis, -1.0),
            axis(turn.z_axis, -1.0),
        );
        Self { clip_from_object: (projection * pose).as_mat4(), axes }
    }

    /// The direction to a lamp beside the camera, above its right shoulder.
    pub(crate) fn lamp(&self) -> Vec3 {
        (self.axes * vec3(0.6, 0.7, 1.0)).normalize_or(Vec3::Z)
    }
}

/// A sphere around a model.
pub(crate) fn sphere_of(model: &Model) -> Sphere {
    model.bounding_sphere().unwrap_or(Sphere { centre: Vec3::ZERO, radius: 1.0 })
}

/// A parallel projection that sees a whole sphere.
fn orthographic(Sphere { centre, radius }: Sphere, axes: Mat3, aspect: f32) -> Mat4 {
    let radius = f64::from(radius.max(f32::MIN_POSITIVE)) * 1.01;
    let aspect = f64::from(aspect);
    let (half_width, half_height) = (radius * aspect.max(1.0), radius * (1.0 / aspect).max(1.0));
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(Vec3::as_dvec3);
    let centre = centre.as_dvec3();
    let row = |axis: DVec3, scale: f64, shift: f64| {
        (axis * scale).extend(shift - axis.dot(centre) * scale)
    };
    let rows = [
        row(x, 1.0 / half_width, 0.0),
        row(y, 1.0 / half_height, 0.0),
        row(-z, 0.5 / radius, 0.5),
        DVec4::W,
    ];
    let [x, y, z, w] = rows;
    DMat4::from_cols(x, y, z, w).transpose().as_mat4()
}

/// The turns of a sheet of views, in degrees to the right and up, instead of the options' own.
pub(crate) fn turns(count: u32) -> Vec<(f32, f32)> {
    if count == 6 {
        return vec![
            (0.0, 0.0),
            (90.0, 0.0),
            (180.0, 0.0),
            (270.0, 0.0),
            (0.0, 90.0),
            (0.0, -90.0),
        ];
    }
    (0..count).map(|i| (360.0 * i as f32 / count as f32, 20.0)).collect()
}
