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
    /// While it is computed, 12 bytes a point are in memory.
    #[must_use]
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Option<Self> {
        let (points, (low, high)) = Columns::of(points.into_iter())?;
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let mut centre = middle(low, high);
        let (mut farthest, mut distance) = points.farthest_from(centre);
        let mut best = (centre, distance);
        for i in 0..MOVES {
            // Each move goes towards the farthest point by a part that becomes smaller (Badoiu and
            // Clarkson, "Smaller Core-Sets for Balls", 2003); this converges to the smallest sphere.
            let part = 1.0 / f64::from(i + 8);
            centre = rounded(centre.lerp(farthest, part));
            (farthest, distance) = points.farthest_from(centre);
            if distance < best.1 {
                best = (centre, distance);
            }
        }
        // A millionth more, so that no distance computed in `f32` is found to be longer.
        let (centre, radius) = best;
        Some(Self { centre: centre.as_vec3(), radius: (radius * (1.0 + 1e-6)) as f32 })
    }
}

/// So many points are compared at a time.
const LANES: usize = 16;

/// Room is made for so many points at the most before they are seen.
const MAX_ROOM: usize = 1 << 24;

/// The coordinates of points, by columns of [`LANES`] points; the last one is filled up with its last point.
struct Columns(Vec<[[f32; LANES]; 3]>);

impl Columns {
    /// The finite ones of points, and their bounds; `None` if there are none.
    fn of(points: impl Iterator<Item = Vec3>) -> Option<(Self, (Vec3, Vec3))> {
        let most = points.size_hint().1.unwrap_or(0).min(MAX_ROOM);
        let mut columns = Vec::with_capacity(most.div_ceil(LANES));
        let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (mut column, mut len) = ([[0.0; LANES]; 3], 0);
        for point in points.filter(|point| point.is_finite()) {
            bounds = (bounds.0.min(point), bounds.1.max(point));
            for (axis, coordinate) in column.iter_mut().zip(point.to_array()) {
                axis[len] = coordinate;
            }
            len += 1;
            if len == LANES {
                columns.push(column);
                len = 0;
            }
        }
        if len > 0 {
            for axis in &mut column {
                let last = axis[len - 1];
                axis[len..].fill(last);
            }
            columns.push(column);
        }
        (!columns.is_empty()).then_some((Self(columns), bounds))
    }

    /// The farthest of the points from a place, the first of several, and how far it is.
    fn farthest_from(&self, place: DVec3) -> (DVec3, f64) {
        let mut most = [0.0; LANES];
        for column in &self.0 {
            for (most, squared) in most.iter_mut().zip(squares(column, place)) {
                *most = if squared > *most { squared } else { *most };
            }
        }
        let most = most.into_iter().fold(0.0, f64::max);
        let mut all = self.0.iter().map(|column| (column, squares(column, place)));
        let at = all.find_map(|(column, squares)| {
            let lane = squares.iter().position(|&squared| squared == most)?;
            Some(DVec3::from_array(column.map(|axis| f64::from(axis[lane]))))
        });
        (at.unwrap_or(place), most.sqrt())
    }
}

/// The squared distances of a column's points from a place.
#[inline(always)]
fn squares([xs, ys, zs]: &[[f32; LANES]; 3], place: DVec3) -> [f64; LANES] {
    let mut squares = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y, z] = [xs, ys, zs].map(|axis| f64::from(axis[lane]));
        let (x, y, z) = (x - place.x, y - place.y, z - place.z);
        squares[lane] = x * x + y * y + z * z;
    }
    squares
}

fn middle(low: DVec3, high: DVec3) -> DVec3 {
    rounded((low + high) / 2.0)
}

/// The nearest place that `f32` can express.
fn rounded(place: DVec3) -> DVec3 {
    place.as_vec3().as_dvec3()
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
            let middle = middle(low.as_dvec3(), high.as_dvec3());
            let distances = points.iter().map(|point| point.as_dvec3().distance(middle));
            let box_radius = distances.fold(0.0, f64::max);
            assert!(f64::from(radius) <= box_radius * 1.000_002);
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
