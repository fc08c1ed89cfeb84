//! Any values at the corners of a polygon, interpolated alike however it is turned: mean value coordinates.

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::parameters::error::ParameterError;

/// A flat polygon with any values at its corners, which are interpolated in the polygon's own plane.
///
/// Values that are not affine on a polygon are interpolated along its edges and across its spans, by default, and
/// depend on how it lies on the screen. Mean value coordinates do not (Hormann and Floater, "Mean Value Coordinates
/// for Arbitrary Planar Polygons", ACM Transactions on Graphics 25(4), 2006): they know the polygon alone. They
/// give each corner its value, are linear along the edges, reproduce what is affine, and are the barycentric
/// coordinates on a triangle. They are smooth inside. On convex polygons they are means of the corners' values;
/// on others they may leave the range of these.
///
/// The vertices carry a place in the polygon's plane, which is affine and so right in perspective; the shader
/// asks for the values there. It takes some 10 operations and a square root for each corner, at each pixel.
///
/// ```
/// use polyscan::glam::{Vec3, camera::rh::proj::directx::perspective, vec3};
/// use polyscan::parameters::PolygonValues;
/// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
///
/// let camera = perspective(1.0, 1.0, 0.1, 10.0);
/// let corners = [
///     (vec3(-1.0, -1.0, -2.0), [1.0, 0.0, 0.0]),
///     (vec3(1.0, -1.0, -3.0), [0.0, 1.0, 0.0]),
///     (vec3(1.0, 1.0, -3.0), [0.0, 0.0, 1.0]),
///     (vec3(-1.0, 1.0, -2.0), [1.0, 1.0, 0.0]),
/// ];
/// let values = PolygonValues::new(&corners)?;
/// let vertices: Vec<_> = corners
///     .iter()
///     .zip(values.places())
///     .map(|((corner, _), &place)| Vertex::new(camera * corner.extend(1.0), place))
///     .collect();
/// let mut frame = Framebuffer::new(100, 100, Vec3::ZERO)?;
/// ZBufferRenderer::new(frame.viewport())
///     .draw(&mut frame, &vertices, |fragment| Vec3::from(values.at(fragment.params.into())));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonValues<const K: usize> {
    places: Vec<Vec2>,
    values: Vec<[f32; K]>,
}

/// Twice the area of the triangle of an edge and a point that is on that edge, as good as. The polygon's corners
/// are at most 1 from its middle.
const ON_EDGE: f64 = 1e-30;

/// Twice the area that counts as none, of a polygon whose coordinates reach from -1 to 1.
const LEAST_AREA: f64 = 1e-9;

impl<const K: usize> PolygonValues<K> {
    /// A polygon of corners, each with its values, in order around it.
    ///
    /// It may be convex or not, as long as its edges do not cross; if they do, what is inside has some values, of
    /// which no more is promised than that they are finite. If it is not flat, its places are those on the plane
    /// that fits it best by Newell's normal.
    ///
    /// # Errors
    /// When there are fewer than three corners, when a coordinate or a value is not finite, and when the corners lie
    /// on a line.
    pub fn new(corners: &[(Vec3, [f32; K])]) -> Result<Self, ParameterError> {
        if corners.len() < 3 {
            return Err(ParameterError::TooFewCorners { count: corners.len() });
        }
        let is_finite = |(corner, values): &(Vec3, [f32; K])| {
            corner.is_finite() && values.iter().all(|value| value.is_finite())
        };
        if let Some(index) = corners.iter().position(|corner| !is_finite(corner)) {
            return Err(ParameterError::NotFinite { index });
        }
        let points: Vec<_> = corners.iter().map(|(corner, _)| corner.as_dvec3()).collect();
        let places = places(&points).ok_or(ParameterError::Degenerate)?;
        Ok(Self { places, values: corners.iter().map(|(_, values)| *values).collect() })
    }

    /// The corners' places in the polygon's plane: two parameters for the vertices. The middle of the polygon is at
    /// (0, 0), and no corner is farther than 1 from it.
    #[must_use]
    pub fn places(&self) -> &[Vec2] {
        &self.places
    }

    /// The values at a place in the polygon's plane. They are finite, wherever it is.
    #[must_use]
    pub fn at(&self, place: Vec2) -> [f32; K] {
        if let Some(corner) = self.places.iter().position(|&corner| corner == place) {
            return self.values[corner];
        }
        if !place.is_finite() {
            return self.nearest(DVec2::ZERO);
        }
        let place = place.as_dvec2();
        let (mut sums, mut weights) = ([0.0; K], 0.0);
        for (i, values) in self.values.iter().enumerate() {
            let next = if i + 1 == self.places.len() { 0 } else { i + 1 };
            let [a, b] = [i, next].map(|corner| self.places[corner].as_dvec2() - place);
            let ends = [a.length(), b.length()];
            let Some(tangent) = tangent_of_half_angle(a, b, ends) else {
                let part = ends[0] / (ends[0] + ends[1]);
                let mix = |a: f32, b: f32| f64::from(a) * (1.0 - part) + f64::from(b) * part;
                return std::array::from_fn(|k| mix(values[k], self.values[next][k]) as f32);
            };
            // The edge's share of the weights of both its ends.
            let [first, second] = ends.map(|end| tangent / end);
            weights += first + second;
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += f64::from(values[k]) * first + f64::from(self.values[next][k]) * second;
            }
        }
        let mean = sums.map(|sum| (sum / weights) as f32);
        if mean.iter().all(|value| value.is_finite()) { mean } else { self.nearest(place) }
    }

    /// The values of the nearest corner.
    #[cold]
    fn nearest(&self, place: DVec2) -> [f32; K] {
        let distance = |corner: &Vec2| corner.as_dvec2().distance_squared(place);
        let each = self.places.iter().zip(&self.values);
        let nearest = each.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
        nearest.map_or([0.0; K], |(_, values)| *values)
    }
}

/// The tangent of half the angle at which an edge is seen from a point, where the edge runs from `a` to `b` as seen
/// from there; `None` if the point is on the edge.
fn tangent_of_half_angle(a: DVec2, b: DVec2, [a_len, b_len]: [f64; 2]) -> Option<f64> {
    let (cross, dot) = (a.perp_dot(b), a.dot(b));
    // Two forms of the same, neither of which subtracts what is nearly equal.
    if dot >= 0.0 {
        Some(cross / (a_len * b_len + dot))
    } else if cross.abs() > ON_EDGE {
        Some((a_len * b_len - dot) / cross)
    } else {
        None
    }
}

/// The corners' places in their plane; `None` if they have none.
fn places(points: &[DVec3]) -> Option<Vec<Vec2>> {
    let count = points.len() as f64;
    let middle = points.iter().map(|&point| point / count).sum::<DVec3>();
    let largest = points.iter().map(|&p| (p - middle).abs().max_element()).fold(0.0, f64::max);
    let scaled = |i: usize| (points[i % points.len()] - middle) / largest;
    let radius = (0..points.len()).map(|i| scaled(i).length()).fold(0.0, f64::max);
    // Newell's normal: twice the area, and the direction.
    let normal: DVec3 = (0..points.len()).map(|i| scaled(i).cross(scaled(i + 1))).sum();
    let has_area = normal.length() > LEAST_AREA;
    if !has_area {
        return None;
    }
    let normal = normal.normalize();
    // The first axis is along the plane's projection of the axis of space that the plane is least across to.
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let flattest =
        axes.into_iter().min_by(|a, b| a.dot(normal).abs().total_cmp(&b.dot(normal).abs()))?;
    let right = (flattest - normal * flattest.dot(normal)).normalize();
    let up = normal.cross(right);
    let place = |i: usize| (DVec2::new(scaled(i).dot(right), scaled(i).dot(up)) / radius).as_vec2();
    Some((0..points.len()).map(place).collect())
}
