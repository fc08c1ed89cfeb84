//! A camera that sees the whole of an object, from whatever side.
//!
//! What flows in is a [`Sphere`] around the object, the shape of the picture, and two angles; what
//! flows out is the matrix that takes the object's vertices to clip space. It is for models whose size
//! and place are not known beforehand; where they are, `glam`'s functions do as well. The sphere is
//! found by `camera::sphere`.
//!
//! ```
//! use glam::Vec3;
//! use polyscan::camera::{Camera, Sphere};
//!
//! let corners = [Vec3::new(-3.0, 0.0, 1.0), Vec3::new(5.0, 2.0, 4.0), Vec3::new(1.0, 7.0, 0.0)];
//! let sphere = Sphere::around(corners).expect("there are points");
//!
//! // From 30 degrees to the right, 20 degrees above, for a picture of 800 x 600 pixels.
//! let camera = Camera::around(sphere, 800.0 / 600.0)
//!     .turned(30_f32.to_radians(), 20_f32.to_radians());
//! for corner in corners {
//!     let clip = camera.clip_from_object() * corner.extend(1.0);
//!     assert!(clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && (0.0..=clip.w).contains(&clip.z));
//! }
//! ```

use glam::camera::rh::proj::directx::perspective;
use glam::{Mat3, Mat4, Quat, Vec3};

mod sphere;

pub use self::sphere::Sphere;

/// A camera that looks at the middle of a sphere and sees all of it.
///
/// Unless it is [`turned`](Self::turned) it stands on the z axis and looks in the direction -z, with y
/// up. The sphere fills the shorter side of the picture, but for a hundredth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Camera {
    sphere: Sphere,
    /// The picture's width divided by its height.
    aspect: f32,
    /// All three angles are in radians.
    yaw: f32,
    pitch: f32,
    field_of_view: f32,
    /// Takes the y axis to the direction that is up.
    upright: Mat3,
}

impl Camera {
    /// The vertical angle of view unless [`with_field_of_view`](Self::with_field_of_view) sets another,
    /// in radians: 34 degrees, that of a lens for portraits.
    pub const FIELD_OF_VIEW: f32 = 0.6;

    /// How much more than the sphere is seen, so that rounding cannot cut it.
    const MARGIN: f32 = 1.01;

    /// A camera for pictures whose width is `aspect` times their height.
    ///
    /// An aspect that is not positive and finite counts as 1. A radius of 0 becomes a very small one.
    pub fn around(sphere: Sphere, aspect: f32) -> Self {
        let aspect = if aspect > 0.0 && aspect.is_finite() { aspect } else { 1.0 };
        // Nothing divides by zero. Beside a centre that is not tiny as well, no square is too small for
        // `f32` either.
        let is_tiny = sphere.centre.abs().max_element() < 1e-15;
        let least = if is_tiny { f32::MIN_POSITIVE } else { f32::MIN_POSITIVE.sqrt() };
        let radius = sphere.radius.max(least).min(f32::MAX);
        let sphere = Sphere { radius, ..sphere };
        let field_of_view = Self::FIELD_OF_VIEW;
        Self { sphere, aspect, yaw: 0.0, pitch: 0.0, field_of_view, upright: Mat3::IDENTITY }
    }

    /// Moves the camera around the sphere, by angles in radians from where a new one stands.
    ///
    /// It goes to the right by `yaw`, around the y axis, and then up by `pitch`. A pitch of half pi is
    /// straight above the sphere; the camera then looks down, and the top of the picture points away
    /// from where it stood.
    pub fn turned(self, yaw: f32, pitch: f32) -> Self {
        Self { yaw, pitch, ..self }
    }

    /// Sets the direction that is up in the object, y unless this is called.
    ///
    /// What the other methods say of the y axis then holds of this one, and the object is seen as if it
    /// had been turned by the shortest way that takes `up` to y. With z up, a camera that is not turned
    /// looks in the direction y, with x to the right. A direction that is zero or not finite counts as y.
    pub fn with_up(self, up: Vec3) -> Self {
        let up = up.try_normalize().unwrap_or(Vec3::Y);
        let upright = if up.y < -0.999_999 {
            Mat3::from_diagonal(Vec3::new(1.0, -1.0, -1.0))
        } else {
            Mat3::from_quat(Quat::from_rotation_arc(Vec3::Y, up))
        };
        Self { upright, ..self }
    }

    /// Sets the angle of view from the picture's lower to its upper side, in radians. The camera goes
    /// nearer or farther accordingly.
    ///
    /// The angle is clamped to 0.01 to 3; NaN counts as 0.01.
    pub fn with_field_of_view(self, radians: f32) -> Self {
        let field_of_view = if radians > 0.01 { radians.min(3.0) } else { 0.01 };
        Self { field_of_view, ..self }
    }

    /// The matrix from object space to clip space, in which x and y are visible from -w to w, and z
    /// from 0 to w ([`ClipSpace::ZeroToOne`](crate::ClipSpace::ZeroToOne)).
    ///
    /// For objects so large or so small that products of their coordinates leave the range of `f32`, it
    /// brings clip space to a size between theirs and 1.
    #[must_use]
    pub fn clip_from_object(&self) -> Mat4 {
        let exponent = exponent(self.sphere.radius.max(self.sphere.centre.abs().max_element()));
        if exponent.abs() < 50 {
            return self.near_clip_from_object();
        }
        // In two steps each, which stay in the range where one would leave it.
        let (half, rest) = (exponent / 2, exponent - exponent / 2);
        let (first, second) = (power_of_two(-half), power_of_two(-rest));
        let Sphere { centre, radius } = self.sphere;
        let sphere = Sphere { centre: centre * first * second, radius: radius * first * second };
        let near = Self { sphere, ..*self }.near_clip_from_object();
        // Clip space is scaled back by one of the steps: lengths are multiplied by the other alone.
        let [x, y, z] = [near.x_axis, near.y_axis, near.z_axis].map(|axis| axis * second);
        Mat4::from_cols(x, y, z, near.w_axis * power_of_two(half))
    }

    fn near_clip_from_object(&self) -> Mat4 {
        let (distance, radius) = (self.distance(), self.sphere.radius);
        let (near, far) = ((distance - radius) * 0.99, distance + radius * Self::MARGIN);
        let view = Mat4::from_translation(Vec3::new(0.0, 0.0, -distance))
            * Mat4::from_mat3(self.axes().transpose())
            * Mat4::from_translation(-self.sphere.centre);
        perspective(self.field_of_view, self.aspect, near, far) * view
    }

    /// Where the camera stands, in object space.
    #[must_use]
    pub fn position(&self) -> Vec3 {
        self.sphere.centre + self.axes().z_axis * self.distance()
    }

    /// The directions to the right, to the top of the picture, and from the object to the camera: three
    /// columns of length 1, in object space. They are of use for lights that move with the camera.
    #[must_use]
    pub fn axes(&self) -> Mat3 {
        let turned = Mat3::from_rotation_y(self.yaw) * Mat3::from_rotation_x(-self.pitch);
        if self.upright == Mat3::IDENTITY { turned } else { self.upright * turned }
    }

    /// How far from the sphere's centre its sides just touch those of the picture.
    fn distance(&self) -> f32 {
        let narrow = ((self.field_of_view / 2.0).tan() * self.aspect.min(1.0)).atan();
        Self::MARGIN * self.sphere.radius / narrow.sin()
    }
}

/// The exponent of a number's power of two, 0 for one that is not finite.
fn exponent(number: f32) -> i32 {
    if number.is_finite() { (number.to_bits() >> 23) as i32 - 127 } else { 0 }
}

/// 2 to a power from -126 to 127.
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_rng::Rng;

    fn is_visible(camera: &Camera, point: Vec3) -> bool {
        let clip = camera.clip_from_object() * point.extend(1.0);
        clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && clip.z >= 0.0 && clip.z <= clip.w
    }

    #[test]
    fn a_camera_sees_the_whole_sphere() {
        let rng = &mut Rng(2);
        for round in 0..300 {
            let scale = [1.0, 1e-6, 1e6][round % 3];
            let centre = Vec3::from_array([0; 3].map(|_| rng.float(1.0))) * scale * 3.0;
            let sphere = Sphere { centre, radius: scale * (rng.float(1.0) + 1.1) };
            let field_of_view = [Camera::FIELD_OF_VIEW, 0.1, 1.5, 2.9][round % 4];
            let camera = Camera::around(sphere, (rng.float(1.0) * 3.0).exp())
                .turned(rng.float(1.0) * 7.0, rng.float(1.0) * 7.0)
                .with_field_of_view(field_of_view);
            for _ in 0..50 {
                let direction = Vec3::from_array([0; 3].map(|_| rng.float(1.0)));
                let point = centre + direction.normalize_or(Vec3::X) * sphere.radius;
                assert!(is_visible(&camera, point), "{camera:?} {point}");
            }
        }
    }

    #[test]
    fn a_camera_goes_to_the_right_and_up() {
        let sphere = Sphere { centre: Vec3::new(1.0, 2.0, 3.0), radius: 1.0 };
        let camera = Camera::around(sphere, 1.0);
        let quarter = std::f32::consts::FRAC_PI_2;
        for ((yaw, pitch), direction) in [
            ((0.0, 0.0), Vec3::Z),
            ((quarter, 0.0), Vec3::X),
            ((0.0, quarter), Vec3::Y),
            ((quarter, -quarter), Vec3::NEG_Y),
            ((quarter, 0.5 * quarter), Vec3::new(0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0)),
        ] {
            let camera = camera.turned(yaw, pitch);
            let towards = (camera.position() - sphere.centre).normalize();
            assert!((towards - direction).length() < 1e-5, "{towards} for {direction}");
            // What is to the right of the centre is on the right, and so on.
            let axes = camera.axes();
            let right = camera.clip_from_object().project_point3(sphere.centre + axes.x_axis * 0.5);
            let above = camera.clip_from_object().project_point3(sphere.centre + axes.y_axis * 0.5);
            assert!(right.x > 0.3 && right.y.abs() < 1e-5, "{right}");
            assert!(above.y > 0.3 && above.x.abs() < 1e-5, "{above}");
        }
    }

    #[test]
    fn cameras_of_odd_numbers() {
        for aspect in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
            let sphere = Sphere { centre: Vec3::ZERO, radius: 1.0 };
            assert_eq!(Camera::around(sphere, aspect), Camera::around(sphere, 1.0));
        }
        for field_of_view in [f32::NAN, -1.0, 0.0, 9.0, f32::INFINITY] {
            let point = Sphere { centre: Vec3::ONE, radius: 0.0 };
            let camera = Camera::around(point, 1.0).with_field_of_view(field_of_view);
            assert!(camera.clip_from_object().is_finite(), "{field_of_view}");
        }
        let nowhere = Sphere { centre: Vec3::NAN, radius: f32::INFINITY };
        let _ = Camera::around(nowhere, 1.0).turned(f32::NAN, f32::INFINITY).clip_from_object();
    }
}
