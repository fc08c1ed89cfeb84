//! A small sphere around points.

use glam::{DVec3, Vec3};

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
    /// It is not the smallest one. But it is no larger than the one around the middle of the points'
    /// bounds, and seldom more than a few hundredths larger than the smallest. Points with a coordinate
    /// that is NaN or infinite are ignored.
    ///
    /// The iterator is cloned and run some twenty times.
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
            // Each move goes towards the farthest point by a part that becomes smaller (Badoiu and
            // Clarkson, "Smaller Core-Sets for Balls", 2003); this converges to the smallest sphere.
            let part = 1.0 / f64::from(i + 8);
            centre = rounded(centre.lerp(farthest, part));
            (farthest, distance) = farthest_from(centre, points.clone());
            if distance < best.1 {
                best = (centre, distance);
            }
        }
        // A millionth more, so that no distance computed in `f32` is found to be longer.
        let (centre, radius) = best;
        Some(Self { centre: centre.as_vec3(), radius: (radius * (1.0 + 1e-6)) as f32 })
    }
}

fn middle(low: DVec3, high: DVec3) -> DVec3 {
    rounded((low + high) / 2.0)
}

/// The nearest place that `f32` can express.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_rng::Rng;

    fn random_points(rng: &mut Rng, count: usize, scale: f32) -> Vec<Vec3> {
        let middle = Vec3::from_array([0; 3].map(|_| rng.float(1.0))) * scale * 3.0;
        let size = Vec3::from_array([0; 3].map(|_| rng.float(1.0))) * scale;
        let mut point = || middle + size * Vec3::from_array([0; 3].map(|_| rng.float(1.0)));
        (0..count).map(|_| point()).collect()
    }

    #[test]
    fn a_sphere_holds_its_points() {
        let rng = &mut Rng(1);
        for round in 0..400 {
            let scale = [1.0, 1e-18, 1e-6, 1e6, 1e18][round % 5];
            let points = random_points(rng, 1 + round, scale);
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
}
