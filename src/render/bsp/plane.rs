//! Planes that divide polygons, and on which side of them a polygon is.
//!
//! # Tolerance
//!
//! Positions are f32, so the product of a plane q and a position p is not known better than to
//! 2^-24 (|q_1 p_1| + .. + |q_4 p_4|), the unit roundoff of f32 in each coordinate. A vertex nearer
//! to the plane than that is on it: no polygon is split for the rounding of its vertices, and those
//! that share an edge with the plane's polygon lie on one side. The price is that what reaches
//! through a plane by less than that is not split; the sum, in f64, adds 2^-51 of the same.
//!
//! A polygon of four or more sides need not be flat. Its plane is Newell's, the best fit by area
//! (formula in Sutherland, Sproull and Schumacker, "A Characterization of Ten Hidden-Surface
//! Algorithms", 1974, who have it from M. Newell), and is as thick as the polygon is bent: vertices
//! that are no farther off than the polygon's own are on it, so that its neighbours are not split.
//! The quads of a model then make less than 2 pieces each instead of 5, and the picture is nearer to
//! the z-buffer's. Where other polygons come as near to a bent one as it is bent, their order is a
//! matter of definition.

use glam::{DVec3, DVec4, Vec4Swizzles};

/// The relative error of a coordinate that was rounded to f32.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// The plane of a face, or one to divide by.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plane {
    /// The linear form, with a normal of length 1.
    pub(crate) form: DVec4,
    /// How far from it vertices count as on it, where w = 1, besides the rounding.
    thickness: f64,
    /// Twice the face's area; 0 if it has no plane.
    pub(crate) area: f64,
}

impl Plane {
    /// Newell's plane of a polygon, all of it at w > 0.
    ///
    /// Seen from the centroid c, each vertex a is a.xyz - c a.w; the sum of the cross products of
    /// neighbours is the normal, twice as long as the polygon's area is large, and c is on the
    /// plane.
    pub(crate) fn of(polygon: &[DVec4]) -> Self {
        let sum: DVec4 = polygon.iter().sum();
        let centre = sum.xyz() / sum.w;
        let from_centre = |p: &DVec4| p.xyz() - centre * p.w;
        let next = polygon.iter().cycle().skip(1);
        let normal: DVec3 =
            polygon.iter().zip(next).map(|(a, b)| from_centre(a).cross(from_centre(b))).sum();
        let area = normal.length();
        let normal = normal / area;
        let form = normal.extend(-normal.dot(centre));
        if !form.is_finite() || !area.is_finite() {
            return Self::default();
        }
        let mut plane = Self { form, thickness: 0.0, area };
        // Vertices at the eye are infinitely far away, where every bend is infinite.
        let least = polygon.iter().fold(0.0, |w, p| p.w.max(w)) / f64::from(1 << 20);
        let off = polygon.iter().filter(|p| p.w >= least).map(|&p| plane.distance(p).abs() / p.w);
        plane.thickness = off.fold(0.0, f64::max);
        plane
    }

    /// The plane across an axis where the coordinate is `at`.
    pub(crate) fn across(axis: usize, at: f64) -> Self {
        let mut form = DVec4::ZERO;
        form[axis] = 1.0;
        form.w = -at;
        Self { form, thickness: 0.0, area: 0.0 }
    }

    /// w times the distance from the plane, positive on the front; 0 if the position is on it.
    pub(crate) fn distance(&self, p: DVec4) -> f64 {
        let (distance, rounding) = (self.form.dot(p), self.rounding(p));
        if distance.abs() <= self.thickness * p.w + rounding { 0.0 } else { distance }
    }

    fn rounding(&self, p: DVec4) -> f64 {
        ROUNDING * self.form.abs().dot(p.abs())
    }

    /// Where a polygon is.
    pub(crate) fn side(&self, polygon: &[DVec4]) -> Side {
        let (mut front, mut back) = (false, false);
        for &p in polygon {
            let distance = self.distance(p);
            front |= distance > 0.0;
            back |= distance < 0.0;
        }
        match (front, back) {
            (true, true) => Side::Both,
            (true, false) => Side::Front,
            (false, true) => Side::Back,
            (false, false) => self.side_within(polygon),
        }
    }

    /// Where a polygon is whose vertices are all within the thickness.
    fn side_within(&self, polygon: &[DVec4]) -> Side {
        let sum: f64 = polygon.iter().map(|&p| self.form.dot(p)).sum();
        let rounding: f64 = polygon.iter().map(|&p| self.rounding(p)).sum();
        match sum {
            _ if sum > rounding => Side::Front,
            _ if sum < -rounding => Side::Back,
            _ => Side::On,
        }
    }
}

/// Where a polygon is, as seen from a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    On,
    Front,
    Back,
    Both,
}
