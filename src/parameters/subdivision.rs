//! Subdivision: triangles so small that linear interpolation will do.

use glam::Vec2;

use crate::clip::{ClipVertex, Clipped, Clipper};
use crate::parameters::error::ParameterError;
use crate::settings::Settings;
use crate::vertex::Vertex;

/// How polygons are cut into triangles on which parameters are then interpolated
/// [linearly on the screen](crate::Interpolation::Linear): what was done where a division at each pixel was too dear
/// (Heckbert and Moreton 1991, section 2.1). polyscan needs none of it; it is here to compare, and for the looks.
///
/// For the looks of the first consoles do not subdivide at all: set
/// [`Interpolation::Linear`](crate::Interpolation::Linear), and the pictures on the walls swim.
///
/// ```
/// use polyscan::glam::{Vec2, vec2, vec4};
/// use polyscan::parameters::Subdivision;
/// use polyscan::{Framebuffer, Interpolation, Mesh, Vertex, ZBufferRenderer};
///
/// // A wall that is ten times as far away on its right.
/// let wall = [(-1.0, -1.0, 1.0), (9.0, -9.0, 10.0), (9.0, 9.0, 10.0), (-1.0, 1.0, 1.0)]
///     .map(|(x, y, w)| Vertex::new(vec4(x, y, 0.5 * w, w), vec2(x + 1.0, w * (y / w + 1.0))));
/// let mut frame = Framebuffer::new(100, 100, 0.0)?;
/// let mut renderer = ZBufferRenderer::new(frame.viewport());
/// renderer.settings.interpolation = [Interpolation::Linear; 2];
///
/// // No more than half a texel of a picture of 64 x 64 texels is it off.
/// let fine = Subdivision::Within { error: 0.5, params: [0, 1], size: Vec2::splat(64.0) };
/// let triangles = fine.triangles(&wall, &renderer.settings)?;
/// for triangle in &triangles {
///     renderer.draw(&mut frame, triangle, |fragment| fragment.params[0]);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Subdivision {
    /// Each triangle into four, so many times.
    Times(u32),
    /// Until linear interpolation is off by no more than a bound.
    Within {
        /// The bound, in texels.
        error: f32,
        /// The parameters u and v.
        params: [usize; 2],
        /// How many texels the texture has where u, and where v, changes by 1.
        size: Vec2,
    },
}

/// The most triangles that a polygon is cut into.
const MOST_TRIANGLES: usize = 1 << 20;

/// The most times that a triangle is cut. Where the error falls to a quarter each time, this is far beyond what
/// f32 can tell apart.
const MOST_TIMES: u32 = 40;

impl Subdivision {
    /// Cuts a convex polygon into triangles, after it was clipped as `settings` say: what is behind the eye has no linear
    /// continuation.
    ///
    /// Which edges are cut depends on the edges alone, so that triangles meet, within a polygon and between polygons
    /// that share an edge.
    ///
    /// With [`Within`](Self::Within) it is off at no point of a triangle by more than the bound. At an edge from
    /// w_0 to w_1 and of length l in texels, linear interpolation is off by no more than
    ///
    /// ```text
    /// e = l (√k - 1) / (√k + 1)        k = max(w_0, w_1) / min(w_0, w_1)
    /// ```
    ///
    /// and inside a triangle by no more than twice the greatest e of its edges, so edges are cut in two until e is
    /// at most half the bound. (The error at barycentric coordinates b, where b' are those in perspective, is the
    /// sum of b_i b_j (1/w_i - 1/w_j) (u_i - u_j) / Σ b/w over the edges, each of which is at most
    /// e (b_i + b_j) (b'_i + b'_j); and these factors add up to 1 + Σ b b' at the most, which is at most 2.)
    ///
    /// # Errors
    /// When there would be more than a million triangles. A parameter that is not there counts as 0.
    pub fn triangles<const N: usize>(
        &self,
        polygon: &[Vertex<N>],
        settings: &Settings<N>,
    ) -> Result<Vec<[Vertex<N>; 3]>, ParameterError> {
        let mut clipper = Clipper::new();
        let clipped: Vec<Vertex<N>> = match clipper.clip(polygon, &settings.all_planes()) {
            Clipped::Outside => Vec::new(),
            Clipped::Inside => polygon.to_vec(),
            Clipped::Polygon(vertices) => vertices.iter().map(ClipVertex::rounded).collect(),
        };
        let mut triangles = Vec::new();
        if let [first, rest @ ..] = clipped.as_slice() {
            for pair in rest.windows(2) {
                self.cut([*first, pair[0], pair[1]], 0, &mut triangles)?;
            }
        }
        Ok(triangles)
    }

    /// Cuts a triangle that has been cut so many times.
    fn cut<const N: usize>(
        &self,
        triangle: [Vertex<N>; 3],
        times: u32,
        triangles: &mut Vec<[Vertex<N>; 3]>,
    ) -> Result<(), ParameterError> {
        let [a, b, c] = triangle;
        let [ab, bc, ca] = [(&a, &b), (&b, &c), (&c, &a)]
            .map(|(a, b)| self.is_too_long(a, b, times).then(|| halfway(a, b)));
        let is_whole = ab.is_none() && bc.is_none() && ca.is_none();
        if triangles.len() >= MOST_TRIANGLES || (times >= MOST_TIMES && !is_whole) {
            return Err(ParameterError::TooManyTriangles { most: MOST_TRIANGLES });
        }
        // Turned so that edges that are cut come first.
        let (parts, count) = match (ab, bc, ca) {
            (None, None, None) => {
                triangles.push(triangle);
                return Ok(());
            }
            (Some(m), None, None) => halves(triangle, m),
            (None, Some(m), None) => halves([b, c, a], m),
            (None, None, Some(m)) => halves([c, a, b], m),
            (Some(m), Some(n), None) => thirds(triangle, m, n),
            (None, Some(m), Some(n)) => thirds([b, c, a], m, n),
            (Some(n), None, Some(m)) => thirds([c, a, b], m, n),
            (Some(m), Some(n), Some(o)) => ([[a, m, o], [m, b, n], [o, n, c], [m, n, o]], 4),
        };
        parts[..count].iter().try_for_each(|&part| self.cut(part, times + 1, triangles))
    }

    /// Whether an edge is to be cut.
    fn is_too_long<const N: usize>(&self, a: &Vertex<N>, b: &Vertex<N>, times: u32) -> bool {
        match self {
            Self::Times(most) => times < *most,
            Self::Within { error, params, size } => {
                let change = |i: usize| {
                    let value = |v: &Vertex<N>| v.params.get(i).map_or(0.0, |&r| f64::from(r));
                    value(b) - value(a)
                };
                let [u, v] =
                    [change(params[0]) * f64::from(size.x), change(params[1]) * f64::from(size.y)];
                let [a, b] = [a, b].map(|v| f64::from(v.position.w).sqrt());
                let off = (u * u + v * v).sqrt() * ((a - b) / (a + b)).abs();
                off > f64::from(*error) / 2.0
            }
        }
    }
}

/// The middle of an edge, in clip space: the same from either end.
fn halfway<const N: usize>(a: &Vertex<N>, b: &Vertex<N>) -> Vertex<N> {
    let mean = |a: f32, b: f32| ((f64::from(a) + f64::from(b)) / 2.0) as f32;
    let position = std::array::from_fn(|i| mean(a.position[i], b.position[i]));
    Vertex {
        position: glam::Vec4::from_array(position),
        params: std::array::from_fn(|i| mean(a.params[i], b.params[i])),
    }
}

/// Up to four triangles, and how many.
type Parts<const N: usize> = ([[Vertex<N>; 3]; 4], usize);

/// The parts of a triangle whose first edge has a middle.
fn halves<const N: usize>([a, b, c]: [Vertex<N>; 3], m: Vertex<N>) -> Parts<N> {
    ([[a, m, c], [m, b, c], [a, b, c], [a, b, c]], 2)
}

/// The parts of a triangle whose first two edges have middles.
fn thirds<const N: usize>([a, b, c]: [Vertex<N>; 3], m: Vertex<N>, n: Vertex<N>) -> Parts<N> {
    ([[m, b, n], [a, m, n], [a, n, c], [a, b, c]], 3)
}
