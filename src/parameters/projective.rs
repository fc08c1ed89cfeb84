//! Projective mappings of the plane: from four pairs of points, or as near as may be to more.

use glam::{DMat3, DVec2, DVec3, Vec4};

use crate::parameters::error::ParameterError;
use crate::vertex::Vertex;
use crate::viewport::Viewport;

/// A projective mapping of the plane, as by a camera that sees a flat picture at an angle.
///
/// With it pictures are warped without any 3-D (the exception in section 3 of Heckbert and Moreton 1991): the mapping
/// follows from points and where they go, and the scan converter takes the picture there, through any filter.
///
/// ```
/// use polyscan::glam::{Vec4, dvec2, vec4};
/// use polyscan::parameters::Projective;
/// use polyscan::texture::Texture;
/// use polyscan::{Framebuffer, ZBufferRenderer};
///
/// let picture = Texture::from_fn(64, 64, |x, y| vec4(x as f32 / 64.0, y as f32 / 64.0, 0.0, 1.0))?;
/// let mut frame = Framebuffer::new(320, 240, Vec4::W)?;
/// // The picture's corners, from the top left one on clockwise, and the pixels of the billboard.
/// let billboard = Projective::from_pairs(&[
///     (dvec2(0.0, 0.0), dvec2(60.0, 40.0)),
///     (dvec2(1.0, 0.0), dvec2(250.0, 80.0)),
///     (dvec2(1.0, 1.0), dvec2(240.0, 190.0)),
///     (dvec2(0.0, 1.0), dvec2(70.0, 200.0)),
/// ])?;
/// let viewport = frame.viewport();
/// ZBufferRenderer::new(viewport).draw(&mut frame, &billboard.picture(&viewport), |fragment| {
///     picture.sample_footprint(&fragment.footprint(0, 1))
/// });
/// // And back: what is at the billboard's middle?
/// let middle = billboard.inverse().at(dvec2(155.0, 127.0)).expect("it is not on the horizon");
/// assert!((middle - 0.5).length() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projective {
    matrix: DMat3,
}

/// Twice the area of a triangle that counts as none, of points whose mean distance from their middle is 1.
const FLAT: f64 = 1e-9;

/// The most steps towards the least squares: three or four are enough where points are near to their places, and more
/// where they are far.
const STEPS: usize = 200;

impl Projective {
    /// The mapping by a matrix: (x, y, 1) goes to (x' q, y' q, q), where q is positive on the side that is to be
    /// seen.
    ///
    /// # Errors
    /// When the matrix has no inverse.
    pub fn new(matrix: DMat3) -> Result<Self, ParameterError> {
        let is_regular = matrix.is_finite() && matrix.inverse().is_finite();
        if is_regular { Ok(Self { matrix }) } else { Err(ParameterError::Degenerate) }
    }

    /// The mapping of the first point of each pair to the second: exactly for four pairs; for more, that which
    /// makes the sum of the squares of the distances to the second points least.
    ///
    /// q is positive at all the points.
    ///
    /// # Errors
    /// When there are fewer than four pairs, when a coordinate is not finite, when three of four points lie on
    /// a line (or, of more, so many that the mapping is free), and when no mapping has all points on one side of
    /// its horizon.
    pub fn from_pairs(pairs: &[(DVec2, DVec2)]) -> Result<Self, ParameterError> {
        if pairs.len() < 4 {
            return Err(ParameterError::TooFewPairs { count: pairs.len() });
        }
        if let Some(index) = pairs.iter().position(|(a, b)| !a.is_finite() || !b.is_finite()) {
            return Err(ParameterError::NotFinite { index });
        }
        let points = pairs.iter().map(|pair| pair.0);
        let [from, to] =
            [Frame::of(pairs.iter().map(|p| p.0))?, Frame::of(pairs.iter().map(|p| p.1))?];
        let pairs: Vec<_> = pairs.iter().map(|&(a, b)| (from.inward(a), to.inward(b))).collect();
        let mapping = match pairs.as_slice() {
            &[a, b, c, d] => four([a.0, b.0, c.0, d.0], [a.1, b.1, c.1, d.1])?,
            _ => least_squares(&pairs)?,
        };
        let mapping = in_front(mapping, pairs.iter().map(|pair| pair.0))?;
        // Numbers of too different sizes may have left nothing of what was found.
        let mapping = to.outward() * mapping * from.inward_matrix();
        in_front(mapping, points).and_then(Self::new).map_err(|_| ParameterError::Degenerate)
    }

    /// The matrix: (x, y, 1) goes to (x' q, y' q, q).
    #[must_use]
    pub fn matrix(&self) -> DMat3 {
        self.matrix
    }

    /// Where a point goes; `None` where q is not positive, at and beyond the horizon.
    #[must_use]
    pub fn at(&self, point: DVec2) -> Option<DVec2> {
        let place = self.matrix * point.extend(1.0);
        let point = place.truncate() / place.z;
        (place.z > 0.0 && point.is_finite()).then_some(point)
    }

    /// The mapping back. Its q is positive at the places of points whose q is.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { matrix: self.matrix.inverse() }
    }

    /// First this mapping, and then another.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self { matrix: next.matrix * self.matrix }
    }

    /// A picture as a polygon, where the mapping takes its texture coordinates to pixels of the framebuffer. The
    /// parameters are (u, v), from (0, 0) at the top left to (1, 1). What is beyond the horizon is clipped
    /// away. Everything has depth 1/2.
    #[must_use]
    pub fn picture(&self, viewport: &Viewport) -> [Vertex<2>; 4] {
        let rect = viewport.rect();
        let size = DVec2::new(rect.width.into(), rect.height.into()).max(DVec2::ONE);
        let corner = DVec2::new(rect.x.into(), rect.y.into());
        let corners =
            [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(u, v)| DVec2::new(u, v));
        let places = corners.map(|uv| self.matrix * uv.extend(1.0));
        // A scale that f32 can bear.
        let unit = places.iter().fold(f64::MIN_POSITIVE, |unit, place| unit.max(place.z.abs()));
        std::array::from_fn(|i| {
            let [x, y, w] = (places[i] / unit).to_array();
            let (x, y) = (x - corner.x * w, y - corner.y * w);
            let position = [2.0 * x / size.x - w, w - 2.0 * y / size.y, w / 2.0, w];
            Vertex::new(Vec4::from_array(position.map(|c| c as f32)), corners[i].as_vec2())
        })
    }
}

/// Points moved to their middle, and scaled to a mean distance of 1 from it: only then is what is small beside 1
/// as good as nothing (Hartley, "In Defense of the Eight-Point Algorithm", 1997).
struct Frame {
    middle: DVec2,
    scale: f64,
}

impl Frame {
    fn of(points: impl ExactSizeIterator<Item = DVec2> + Clone) -> Result<Self, ParameterError> {
        let count = points.len() as f64;
        let middle = points.clone().map(|point| point / count).sum::<DVec2>();
        let scale = points.map(|point| (point - middle).length() / count).sum::<f64>();
        let is_extended = scale.is_normal() && (1.0 / scale).is_normal() && middle.is_finite();
        if is_extended { Ok(Self { middle, scale }) } else { Err(ParameterError::Degenerate) }
    }

    fn inward(&self, point: DVec2) -> DVec2 {
        (point - self.middle) / self.scale
    }

    fn inward_matrix(&self) -> DMat3 {
        DMat3::from_scale(DVec2::splat(1.0 / self.scale)) * DMat3::from_translation(-self.middle)
    }

    fn outward(&self) -> DMat3 {
        DMat3::from_translation(self.middle) * DMat3::from_scale(DVec2::splat(self.scale))
    }
}

/// A matrix with the sign that makes q positive at all points.
fn in_front(
    matrix: DMat3,
    points: impl Iterator<Item = DVec2> + Clone,
) -> Result<DMat3, ParameterError> {
    let q = |point: DVec2| (matrix * point.extend(1.0)).z;
    if points.clone().all(|point| q(point) > 0.0) {
        Ok(matrix)
    } else if points.clone().all(|point| q(point) < 0.0) {
        Ok(matrix * -1.0)
    } else {
        Err(ParameterError::Folded)
    }
}

/// The mapping of four points to four points: by way of the mapping of the points at infinity of both axes, the origin
/// and (1, 1), of which a matrix's columns are the images.
fn four(from: [DVec2; 4], to: [DVec2; 4]) -> Result<DMat3, ParameterError> {
    let mapping = basis(to)? * basis(from)?.inverse();
    if mapping.is_finite() { Ok(mapping) } else { Err(ParameterError::Degenerate) }
}

fn basis(points: [DVec2; 4]) -> Result<DMat3, ParameterError> {
    let [a, b, c, d] = points.map(|point| point.extend(1.0));
    // Twice the areas of the triangles without one of the points: the weights of the others.
    let weights = DVec3::new(b.cross(c).dot(d), c.cross(a).dot(d), a.cross(b).dot(d));
    let all = weights.to_array().into_iter().chain([a.cross(b).dot(c)]);
    if all.into_iter().any(|area| area.abs() <= FLAT) {
        return Err(ParameterError::Degenerate);
    }
    Ok(DMat3::from_cols(a * weights.x, b * weights.y, c * weights.z))
}

// --------------------------------------------------------------------------------- least squares

/// The elements of a matrix but the last, which is 1: q at the middle of the points, which is in front.
type Elements = [f64; 8];

/// The matrix of the equations for the elements, and their right sides: those of the least squares.
#[derive(Default)]
struct NormalEquations {
    matrix: [Elements; 8],
    right: Elements,
}

impl NormalEquations {
    /// Adds an equation: the sum of the elements times `row` is to be `right`.
    fn add(&mut self, row: Elements, right: f64) {
        for i in 0..8 {
            for j in 0..8 {
                self.matrix[i][j] += row[i] * row[j];
            }
            self.right[i] += row[i] * right;
        }
    }

    /// Gauss's elimination, by the largest pivot of each column; `None` if one is as good as zero.
    fn solve(mut self) -> Option<Elements> {
        for column in 0..8 {
            let size = |row: usize, of: &Self| of.matrix[row][column].abs();
            let pivot = (column..8).max_by(|&i, &j| size(i, &self).total_cmp(&size(j, &self)))?;
            self.matrix.swap(column, pivot);
            self.right.swap(column, pivot);
            let least = 1e-13 * self.matrix[column].iter().fold(1.0, |most, c| c.abs().max(most));
            let pivot_row = self.matrix[column];
            // Written so that NaN is as good as zero.
            let is_pivot = pivot_row[column].abs() > least;
            if !is_pivot {
                return None;
            }
            for row in column + 1..8 {
                let factor = self.matrix[row][column] / pivot_row[column];
                for (element, above) in self.matrix[row].iter_mut().zip(pivot_row) {
                    *element -= factor * above;
                }
                self.right[row] -= factor * self.right[column];
            }
        }
        let mut solution = [0.0; 8];
        for row in (0..8).rev() {
            let known: f64 = (row + 1..8).map(|j| self.matrix[row][j] * solution[j]).sum();
            solution[row] = (self.right[row] - known) / self.matrix[row][row];
        }
        Some(solution)
    }
}

fn matrix_of([a, b, c, d, e, f, g, h]: Elements) -> DMat3 {
    DMat3::from_cols_array(&[a, d, g, b, e, h, c, f, 1.0])
}

/// The mapping that makes the sum of the squared distances least: from the solution of the linear equations
/// by the steps of Gauss and Newton, each halved until it is one downwards.
fn least_squares(pairs: &[(DVec2, DVec2)]) -> Result<DMat3, ParameterError> {
    // x' (g x + h y + 1) = a x + b y + c, and the same for y'.
    let mut linear = NormalEquations::default();
    for (DVec2 { x, y }, to) in pairs {
        linear.add([*x, *y, 1.0, 0.0, 0.0, 0.0, -x * to.x, -y * to.x], to.x);
        linear.add([0.0, 0.0, 0.0, *x, *y, 1.0, -x * to.y, -y * to.y], to.y);
    }
    let mut elements = linear.solve().ok_or(ParameterError::Degenerate)?;
    let mut error = squares(pairs, &elements).ok_or(ParameterError::Folded)?;
    for _ in 0..STEPS {
        let Some(step) = tangent(pairs, &elements).solve() else { break };
        let longest = step.iter().fold(0.0f64, |longest, step| longest.max(step.abs()));
        let better = (0..20).find_map(|halvings| {
            let part = 1.0 / f64::from(1 << halvings);
            let moved = std::array::from_fn(|i| elements[i] + step[i] * part);
            squares(pairs, &moved).filter(|&found| found < error).map(|found| (moved, found))
        });
        let Some(better) = better else { break };
        (elements, error) = better;
        if longest < 1e-14 {
            break;
        }
    }
    Ok(matrix_of(elements))
}

/// The equations of a step: what the distances would be if all were linear.
fn tangent(pairs: &[(DVec2, DVec2)], elements: &Elements) -> NormalEquations {
    let (mut equations, matrix) = (NormalEquations::default(), matrix_of(*elements));
    for (from, to) in pairs {
        let place = matrix * from.extend(1.0);
        let at = place.truncate() / place.z;
        let [x, y, one] = (from.extend(1.0) / place.z).to_array();
        equations.add([x, y, one, 0.0, 0.0, 0.0, -x * at.x, -y * at.x], to.x - at.x);
        equations.add([0.0, 0.0, 0.0, x, y, one, -x * at.y, -y * at.y], to.y - at.y);
    }
    equations
}

/// The sum of the squared distances; `None` if a point is not in front of the horizon.
fn squares(pairs: &[(DVec2, DVec2)], elements: &Elements) -> Option<f64> {
    let mapping = Projective { matrix: matrix_of(*elements) };
    pairs.iter().map(|(from, to)| mapping.at(*from).map(|at| at.distance_squared(*to))).sum()
}
