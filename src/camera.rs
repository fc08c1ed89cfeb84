//! A camera that sees the whole of an object, from whatever side.
//!
//! What flows in is a [`Sphere`] around the object, the shape of the picture, and two angles; what
//! flows out is the matrix that takes the object's vertices to clip space. It is for models whose size
//! and place nobody knows beforehand; with a camera of one's own, `glam`'s functions do as well.
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
use glam::{DVec3, Mat3, Mat4, Vec3};

/// A sphere that holds an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its middle, in the object's units.
    pub centre: Vec3,
    /// Its radius, in the object's units.
    pub radius: f32,
}

/// How often a sphere's centre is moved to make it smaller.
const MOVES: u32 = 16;

impl Sphere {
    /// A small sphere that holds all points; `None` if there are none.
    ///
    /// It is not the smallest, but no larger than the one around the middle of the points' bounds, and
    /// seldom more than a few hundredths larger than the smallest. Coordinates that are NaN or infinite
    /// are not held.
    ///
    /// The points are passed over some twenty times.
    #[must_use]
    pub fn around<I>(points: I) -> Option<Self>
    where
        I: IntoIterator<Item = Vec3, IntoIter: Clone>,
    {
        let points = points.into_iter().filter(|point| point.is_finite()).map(Vec3::as_dvec3);
        let low = points.clone().reduce(DVec3::min)?;
        let high = points.clone().fold(low, DVec3::max);

        let mut centre = middle(low, high);
        let (mut farthest, mut distance) = farthest_from(centre, points.clone());
        let mut best = (centre, distance);
        for i in 0..MOVES {
            // Towards the farthest point by a part that becomes smaller (Badoiu and Clarkson, "Smaller
            // Core-Sets for Balls", 2003), which ends in the smallest sphere.
            let part = 1.0 / f64::from(i + 8);
            centre = rounded(centre.lerp(farthest, part));
            (farthest, distance) = farthest_from(centre, points.clone());
            if distance < best.1 {
                best = (centre, distance);
            }
        }
        // A millionth more, so that distances in `f32` are not found to be longer.
        let (centre, radius) = best;
        Some(Self { centre: centre.as_vec3(), radius: (radius * (1.0 + 1e-6)) as f32 })
    }
}

fn middle(low: DVec3, high: DVec3) -> DVec3 {
    rounded((low + high) / 2.0)
}

/// A place that `f32` has.
fn rounded(place: DVec3) -> DVec3 {
    place.as_vec3().as_dvec3()
}

/// The farthest of the points, and how far it is; the place itself if there are none.
fn farthest_from(place: DVec3, points: impl Iterator<Item = DVec3>) -> (DVec3, f64) {
    let (farthest, squared) = points.fold((place, 0.0), |(farthest, squared), point| {
        let other = point.distance_squared(place);
        if other > squared { (point, other) } else { (farthest, squared) }
    });
    (farthest, squared.sqrt())
}

/// A camera that looks at the middle of a sphere and sees all of it.
///
/// Unless it is [`turned`](Self::turned) it stands on the z axis and looks in the direction -z, with y
/// up. The sphere fills the shorter side of the picture, but for a hundredth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Camera {
    sphere: Sphere,
    /// Width by height of the picture.
    aspect: f32,
    /// In radians, as are the others.
    yaw: f32,
    pitch: f32,
    field_of_view: f32,
}

impl Camera {
    /// The vertical angle of view unless [`with_field_of_view`](Self::with_field_of_view) sets another,
    /// in radians: 34 degrees, that of a lens for portraits.
    pub const FIELD_OF_VIEW: f32 = 0.6;

    /// How much larger than the sphere that which is seen is: rounding must not cut it.
    const MARGIN: f32 = 1.01;

    /// A camera for pictures whose width is `aspect` times their height.
    ///
    /// An aspect that is not positive and finite counts as 1. A radius of 0 becomes a very small one.
    pub fn around(sphere: Sphere, aspect: f32) -> Self {
        let aspect = if aspect > 0.0 && aspect.is_finite() { aspect } else { 1.0 };
        // Nothing divides by zero, and no square is too small for `f32`.
        let radius = sphere.radius.max(f32::MIN_POSITIVE.sqrt());
        let sphere = Sphere { radius, ..sphere };
        Self { sphere, aspect, yaw: 0.0, pitch: 0.0, field_of_view: Self::FIELD_OF_VIEW }
    }

    /// The same camera elsewhere around the sphere, by angles in radians.
    ///
    /// It goes to the right by `yaw`, around the y axis, and then up by `pitch`: half pi is straight
    /// above, whence it looks down with the top of the picture away from where it stood.
    pub fn turned(self, yaw: f32, pitch: f32) -> Self {
        Self { yaw, pitch, ..self }
    }

    /// The same camera with another angle of view, from the picture's lower to its upper side, in
    /// radians; it goes nearer or farther accordingly.
    ///
    /// It is clamped to 0.01 to 3; NaN counts as 0.01.
    pub fn with_field_of_view(self, radians: f32) -> Self {
        let field_of_view = if radians > 0.01 { radians.min(3.0) } else { 0.01 };
        Self { field_of_view, ..self }
    }

    /// The matrix from object space to clip space, in which x and y are visible from -w to w, and z
    /// from 0 to w ([`ClipSpace::ZeroToOne`](crate::ClipSpace::ZeroToOne)).
    #[must_use]
    pub fn clip_from_object(&self) -> Mat4 {
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

    /// The directions to the right, to the top of the picture, and from the object to the camera, each
    /// of length 1, in object space: for lights that go with the camera.
    #[must_use]
    pub fn axes(&self) -> Mat3 {
        Mat3::from_rotation_y(self.yaw) * Mat3::from_rotation_x(-self.pitch)
    }

    /// How far from the sphere's centre its sides just touch those of the picture.
    fn distance(&self) -> f32 {
        let narrow = ((self.field_of_view / 2.0).tan() * self.aspect.min(1.0)).atan();
        Self::MARGIN * self.sphere.radius / narrow.sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: &mut u32) -> f32 {
        // A linear congruential generator (Numerical Recipes, 1992); the upper bits are good.
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / 8_388_608.0 - 1.0
    }

    fn random_points(seed: &mut u32, count: usize, scale: f32) -> Vec<Vec3> {
        let middle = Vec3::from_array([0; 3].map(|_| random(seed))) * scale * 3.0;
        let size = Vec3::from_array([0; 3].map(|_| random(seed))) * scale;
        let mut point = || middle + size * Vec3::from_array([0; 3].map(|_| random(seed)));
        (0..count).map(|_| point()).collect()
    }

    #[test]
    fn a_sphere_holds_its_points() {
        let seed = &mut 1;
        for round in 0..400 {
            let scale = [1.0, 1e-18, 1e-6, 1e6, 1e18][round % 5];
            let points = random_points(seed, 1 + round, scale);
            let Sphere { centre, radius } = Sphere::around(points.clone()).expect("points");
            let (low, high) = (
                points.iter().copied().reduce(Vec3::min).expect("points"),
                points.iter().copied().reduce(Vec3::max).expect("points"),
            );
            let box_radius = farthest_from(
                middle(low.as_dvec3(), high.as_dvec3()),
                points.iter().map(|point| point.as_dvec3()),
            );
            assert!(f64::from(radius) <= box_radius.1 * 1.000_002);
            for point in points {
                assert!(point.distance(centre) <= radius, "{point} from {centre}, {radius}");
            }
        }
    }

    #[test]
    fn a_sphere_is_nearly_the_smallest() {
        // Points on a sphere with the box's middle far from its centre: a cap and one pole.
        let angle = |i: u8| f32::from(i) * std::f32::consts::TAU / 40.0;
        let circle = |i| Vec3::new(angle(i).cos(), 0.5, angle(i).sin()) * 0.75_f32.sqrt();
        let circle = (0..40).map(circle).map(|p| Vec3 { y: 0.5, ..p });
        let sphere = Sphere::around(circle.chain([Vec3::NEG_Y]).collect::<Vec<_>>());
        let Sphere { centre, radius } = sphere.expect("points");
        assert!(radius < 1.02, "{centre} {radius}");
    }

    #[test]
    fn spheres_of_odd_points() {
        assert_eq!(Sphere::around([]), None);
        assert_eq!(Sphere::around([Vec3::NAN]), None);
        let point = Vec3::new(1.0, -2.0, 3e20);
        assert_eq!(Sphere::around([point]), Some(Sphere { centre: point, radius: 0.0 }));
        assert_eq!(Sphere::around([Vec3::INFINITY, point]), Sphere::around([point]));
        // In `f32` the sum of the two would be infinite.
        let ends = [Vec3::X * 3e38, Vec3::X * 2e38];
        let sphere = Sphere::around(ends).expect("points");
        assert!((sphere.centre.x - 2.5e38).abs() < 1e33 && sphere.radius < 0.6e38, "{sphere:?}");
    }

    fn is_visible(camera: &Camera, point: Vec3) -> bool {
        let clip = camera.clip_from_object() * point.extend(1.0);
        clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && clip.z >= 0.0 && clip.z <= clip.w
    }

    #[test]
    fn a_camera_sees_the_whole_sphere() {
        let seed = &mut 2;
        for round in 0..300 {
            let scale = [1.0, 1e-6, 1e6][round % 3];
            let centre = Vec3::from_array([0; 3].map(|_| random(seed))) * scale * 3.0;
            let sphere = Sphere { centre, radius: scale * (random(seed) + 1.1) };
            let field_of_view = [Camera::FIELD_OF_VIEW, 0.1, 1.5, 2.9][round % 4];
            let camera = Camera::around(sphere, (random(seed) * 3.0).exp())
                .turned(random(seed) * 7.0, random(seed) * 7.0)
                .with_field_of_view(field_of_view);
            for _ in 0..50 {
                let direction = Vec3::from_array([0; 3].map(|_| random(seed)));
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
