//! The paper's equation (1): parameters from screen positions by one matrix.
//!
//! The scan converter keeps each value as a plane over the screen. [`ParameterMatrix`] is the same
//! function found by another route, from homogeneous coordinates without any division by w (Heckbert
//! and Moreton 1991, sections 2 and 3): it evaluates parameters anywhere on the screen, without
//! stepping, for polygons that reach behind the eye as well.

use glam::DVec3;

use crate::vertex::Vertex;
use crate::viewport::Viewport;

/// The paper's equation (1): the 3 x (n + 1) matrix from screen positions (x, y, 1) to homogeneous
/// parameters (r_1 / w, .. r_n / w, 1 / w).
///
/// ```
/// use glam::vec4;
/// use polyscan::{ParameterMatrix, Vertex, Viewport};
///
/// let viewport = Viewport::new(100, 100)?;
/// // Half as far on the left as on the right.
/// let triangle = [
///     Vertex::new(vec4(-1.0, -1.0, 0.0, 1.0), [0.0]),
///     Vertex::new(vec4(2.0, -2.0, 0.0, 2.0), [1.0]),
///     Vertex::new(vec4(-1.0, 1.0, 0.0, 1.0), [0.0]),
/// ];
/// let matrix = ParameterMatrix::new(&triangle, &viewport).expect("it is not edge-on");
/// let ([u], w) = matrix.at(50.0, 100.0);
/// // The middle of the picture is a third of the way, not half.
/// assert!((u - 1.0 / 3.0).abs() < 1e-12 && (w - 4.0 / 3.0).abs() < 1e-12);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterMatrix<const N: usize> {
    s: [DVec3; N],
    inv_w: DVec3,
}

impl<const N: usize> ParameterMatrix<N> {
    /// The matrix of the plane through three vertices in clip space; `None` when that plane is seen
    /// edge-on or the vertices lie on a line. Positions behind the eye are as good as any.
    #[must_use]
    pub fn new(triangle: &[Vertex<N>; 3], viewport: &Viewport) -> Option<Self> {
        let rect = viewport.rect();
        let (half_width, half_height) = (f64::from(rect.width) / 2.0, f64::from(rect.height) / 2.0);
        // Screen positions times w: vertex k is at p[k] / p[k].z.
        let p = triangle.map(|v| {
            let v = v.position.as_dvec4();
            DVec3::new((v.x + v.w) * half_width, (v.w - v.y) * half_height, v.w)
        });
        // The rows of the adjugate of (p0, p1, p2): row k vanishes at the other two vertices.
        let rows = [p[1].cross(p[2]), p[2].cross(p[0]), p[0].cross(p[1])];
        let determinant = p[0].dot(rows[0]);
        let weights = rows.map(|row| row / determinant);
        let plane = |value: [f64; 3]| (0..3).map(|k| weights[k] * value[k]).sum::<DVec3>();
        let inv_w = plane([1.0; 3]);
        let s = std::array::from_fn(|i| plane(triangle.map(|v| f64::from(v.params[i]))));
        inv_w.is_finite().then_some(Self { s, inv_w })
    }

    /// The column of parameter `i`: s_i = a x + b y + c as (a, b, c).
    #[must_use]
    pub fn column(&self, i: usize) -> Option<[f64; 3]> {
        self.s.get(i).map(DVec3::to_array)
    }

    /// The last column: 1/w = a x + b y + c as (a, b, c).
    #[must_use]
    pub fn inv_w(&self) -> [f64; 3] {
        self.inv_w.to_array()
    }

    /// The parameters and w at a point of the screen, in pixels from the viewport's top left corner.
    /// On the polygon's horizon, where 1/w is zero, they are not finite.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> ([f64; N], f64) {
        let point = DVec3::new(x, y, 1.0);
        let w = 1.0 / self.inv_w.dot(point);
        (self.s.map(|s| s.dot(point) * w), w)
    }

    /// The derivatives of the parameters with respect to screen x and y at a point, per pixel, by
    /// the quotient rule.
    #[must_use]
    pub fn derivatives_at(&self, x: f64, y: f64) -> ([f64; N], [f64; N]) {
        let (params, w) = self.at(x, y);
        let quotient = |axis: fn(&DVec3) -> f64| {
            std::array::from_fn(|i| (axis(&self.s[i]) - params[i] * axis(&self.inv_w)) * w)
        };
        (quotient(|v| v.x), quotient(|v| v.y))
    }
}
