//! Parameters as planes over the screen.
//!
//! On a flat polygon each of z, s_1 .. s_n and s_{n+1} = 1/w is an affine function of the screen
//! position (Heckbert and Moreton 1991, section 3.5). [`Gradient`] is that function for the scan
//! converter: a value at one vertex and the change per pixel in x and in y. [`ParameterMatrix`] is
//! the same function as the paper's equation (1), found by another route, from homogeneous
//! coordinates without any division by w: it evaluates parameters anywhere on the screen, without
//! stepping, for polygons that reach behind the eye as well.

use glam::DVec3;

use crate::number::Number;
use crate::project::{ScreenParams, ScreenVertex, Viewport};
use crate::vertex::Vertex;

/// The height in pixels below which a triangle is too thin to have planes. Vertices on a line in
/// exact arithmetic are found up to 2^-36 pixel away from it at the end of the guard band, and a
/// pixel centre may lie 2^-8 pixel outside; this is half way between, on the scale of powers.
const MIN_HEIGHT: f64 = 1.0 / (1 << 20) as f64;

/// The planes of z, s_1 .. s_n and s_{n+1} over the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient<const N: usize, T = f64> {
    /// A point of the planes.
    origin: ScreenVertex<N, T>,
    /// Change per pixel to the right.
    pub dx: ScreenParams<N, T>,
    /// Change per pixel downwards.
    pub dy: ScreenParams<N, T>,
}

impl<const N: usize, T: Copy + Default> Default for Gradient<N, T> {
    fn default() -> Self {
        let flat = ScreenParams::default();
        Self { origin: ScreenVertex::default(), dx: flat, dy: flat }
    }
}

impl<const N: usize, T: Copy> Gradient<N, T> {
    /// The planes through three vertices, and whether there are any: see
    /// [`through`](Gradient::through).
    #[inline(always)]
    pub(crate) fn fit([a, b, c]: [&ScreenVertex<N, T>; 3]) -> (Self, T::Mask)
    where
        T: Number,
    {
        let (abx, aby) = (b.x - a.x, b.y - a.y);
        let (acx, acy) = (c.x - a.x, c.y - a.y);
        let area = abx * acy - acx * aby;
        // Twice the area by a length that is at least the longest side: at most the height.
        let length = abx.abs() + aby.abs() + acx.abs() + acy.abs();
        let is_wide = (length * MIN_HEIGHT).is_less(area.abs());
        let (ab, ac) =
            (b.values.zip(&a.values, |b, a| b - a), c.values.zip(&a.values, |c, a| c - a));
        let per_area = area.all(1.0) / area;
        let dx = ab.zip(&ac, |ab, ac| (ab * acy - ac * aby) * per_area);
        let dy = ab.zip(&ac, |ab, ac| (ac * abx - ab * acx) * per_area);
        let sum = |p: &ScreenParams<N, T>| p.z + p.inv_w;
        let is_finite = per_area.is_finite() & (sum(&dx) + sum(&dy)).is_finite();
        (Self { origin: *a, dx, dy }, is_wide & is_finite)
    }

    /// `f` of each number.
    #[inline(always)]
    pub(crate) fn map<U: Copy>(&self, f: impl Fn(&T) -> U + Copy) -> Gradient<N, U> {
        let Self { origin: ScreenVertex { x, y, values }, dx, dy } = self;
        let origin = ScreenVertex { x: f(x), y: f(y), values: values.map(f) };
        Gradient { origin, dx: dx.map(f), dy: dy.map(f) }
    }
}

impl<const N: usize> Gradient<N> {
    /// The planes through three vertices; `None` when these lie on a line or within 2^-20 pixel of
    /// one, where rounding errors across the line would be taken for slopes.
    #[inline(always)]
    pub fn through(triangle: [&ScreenVertex<N>; 3]) -> Option<Self> {
        let (gradient, is_fit) = Self::fit(triangle);
        is_fit.then_some(gradient)
    }

    /// The values at a point of the screen, in pixels.
    #[inline(always)]
    pub fn at(&self, x: f64, y: f64) -> ScreenParams<N> {
        self.origin.values.step(&self.dx, x - self.origin.x).step(&self.dy, y - self.origin.y)
    }

    /// The values at several points, rounded to f32.
    #[inline(always)]
    pub(crate) fn at_each<const M: usize>(
        &self,
        mut x: [f64; M],
        mut y: [f64; M],
    ) -> ScreenParams<N, [f32; M]> {
        for (x, y) in x.iter_mut().zip(&mut y) {
            *x -= self.origin.x;
            *y -= self.origin.y;
        }
        let plane = |origin: f64, dx: f64, dy: f64| {
            let mut values = [0.0; M];
            for (i, value) in values.iter_mut().enumerate() {
                *value = (origin + dx * x[i] + dy * y[i]) as f32;
            }
            values
        };
        let Self { origin: ScreenVertex { values: v, .. }, dx, dy } = self;
        let mut s = [[0.0; M]; N];
        for (i, s) in s.iter_mut().enumerate() {
            *s = plane(v.s[i], dx.s[i], dy.s[i]);
        }
        ScreenParams { z: plane(v.z, dx.z, dy.z), inv_w: plane(v.inv_w, dx.inv_w, dy.inv_w), s }
    }
}

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
    pub fn column(&self, i: usize) -> Option<[f64; 3]> {
        self.s.get(i).map(DVec3::to_array)
    }

    /// The last column: 1/w = a x + b y + c as (a, b, c).
    pub fn inv_w(&self) -> [f64; 3] {
        self.inv_w.to_array()
    }

    /// The parameters and w at a point of the screen, in pixels from the viewport's top left corner.
    /// On the polygon's horizon, where 1/w is zero, they are not finite.
    pub fn at(&self, x: f64, y: f64) -> ([f64; N], f64) {
        let point = DVec3::new(x, y, 1.0);
        let w = 1.0 / self.inv_w.dot(point);
        (self.s.map(|s| s.dot(point) * w), w)
    }

    /// The derivatives of the parameters with respect to screen x and y at a point, per pixel, by
    /// the quotient rule.
    pub fn derivatives_at(&self, x: f64, y: f64) -> ([f64; N], [f64; N]) {
        let (params, w) = self.at(x, y);
        let quotient = |axis: fn(&DVec3) -> f64| {
            std::array::from_fn(|i| (axis(&self.s[i]) - params[i] * axis(&self.inv_w)) * w)
        };
        (quotient(|v| v.x), quotient(|v| v.y))
    }
}
