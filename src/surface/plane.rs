//! Planes over the screen: what is affine on a flat polygon, z, s_1 .. s_n and s_{n+1} = 1/w, is an
//! affine function of the screen position (Heckbert and Moreton 1991, section 3.5).

use crate::scalar::{BATCH, PerTriangle, Scalar};

/// The height in pixels below which a triangle is too thin to have planes. Vertices on a line in
/// exact arithmetic are found up to 2^-36 pixel away from it at the end of the guard band, and a
/// pixel centre may lie 2^-8 pixel outside; this is half way between, on the scale of powers.
const MIN_HEIGHT: f64 = 1.0 / (1 << 20) as f64;

/// One value as a plane over the screen: what it is at an origin, and its change per pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ScreenPlane<T = f64> {
    pub(crate) value: T,
    /// The change per pixel to the right.
    pub(crate) dx: T,
    /// The change per pixel downwards.
    pub(crate) dy: T,
}

/// The planes of one value for a batch of triangles. The lanes of each number fill a cache line: a vector
/// that lies in two takes long to store, and longer to load again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub(crate) struct BatchPlane(pub(crate) ScreenPlane<PerTriangle>);

impl BatchPlane {
    /// The plane of one of the triangles.
    #[inline(always)]
    pub(crate) fn of(&self, lane: usize) -> ScreenPlane {
        self.0.map(
            #[inline(always)]
            |lanes| lanes[lane % BATCH],
        )
    }
}

impl ScreenPlane {
    /// The value at a point of the screen, relative to the origin.
    #[inline(always)]
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        self.value + self.dx * x + self.dy * y
    }
}

impl<T> ScreenPlane<T> {
    /// `f` of each number.
    #[inline(always)]
    pub(crate) fn map<U>(&self, f: impl Fn(&T) -> U) -> ScreenPlane<U> {
        ScreenPlane { value: f(&self.value), dx: f(&self.dx), dy: f(&self.dy) }
    }
}

/// A triangle on the screen through whose vertices planes are laid. The first is the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneBasis<T: Scalar> {
    ab: [T; 2],
    ac: [T; 2],
    per_area: T,
    /// Whether the vertices do not lie on a line or within 2^-20 pixel of one, where rounding errors
    /// across the line would be taken for slopes.
    pub(crate) is_wide: T::Mask,
}

impl<T: Scalar> PlaneBasis<T> {
    #[inline(always)]
    pub(crate) fn new([a, b, c]: [[T; 2]; 3]) -> Self {
        let (abx, aby) = (b[0] - a[0], b[1] - a[1]);
        let (acx, acy) = (c[0] - a[0], c[1] - a[1]);
        let area = abx * acy - acx * aby;
        // Twice the area by a length that is at least the longest side: at most the height.
        let length = abx.abs() + aby.abs() + acx.abs() + acy.abs();
        let is_wide = (length * MIN_HEIGHT).is_less(area.abs());
        let per_area = area.splat(1.0) / area;
        let is_wide = is_wide & per_area.is_finite();
        Self { ab: [abx, aby], ac: [acx, acy], per_area, is_wide }
    }

    /// The plane through three values at the vertices.
    #[inline(always)]
    pub(crate) fn plane(&self, [a, b, c]: [T; 3]) -> ScreenPlane<T> {
        let (ab, ac) = (b - a, c - a);
        let ([abx, aby], [acx, acy]) = (self.ab, self.ac);
        ScreenPlane {
            value: a,
            dx: (ab * acy - ac * aby) * self.per_area,
            dy: (ac * abx - ab * acx) * self.per_area,
        }
    }
}
