//! Elliptical weighted averages (Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989,
//! section 3.5.9): the mean of the texels in an ellipse, weighted by a Gaussian.

use glam::{Vec2, Vec4};

use crate::texture::level::Sides;
use crate::texture::sample::{Surroundings, bilinear};
use crate::texture::texels::{Fetch, LevelTexels};
use crate::texture::wrap::{Place, wrapped_index};

/// The ellipse A x^2 + B x y + C y^2 < F around a point of a level, in its texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadratic {
    a: f32,
    b: f32,
    c: f32,
    f: f32,
}

impl Quadratic {
    /// The ellipse of a footprint, of at least a texel, made no longer than `eccentricity` times its
    /// width.
    pub(super) fn of(sides: &Sides, eccentricity: f32) -> Self {
        let Sides { dx, dy } = *sides;
        let ellipse = sides.ellipse();
        let least = ellipse.major / eccentricity;
        let missing =
            if ellipse.minor < least { least * least - ellipse.minor * ellipse.minor } else { 0.0 };
        let across = ellipse.direction.perp();
        // The matrix (uu uv; uv vv) = J J^T, widened across the longer axis, and by a texel all around.
        let uu = dx.x * dx.x + dy.x * dy.x + missing * across.x * across.x + 1.0;
        let uv = dx.x * dx.y + dy.x * dy.y + missing * across.x * across.y;
        let vv = dx.y * dx.y + dy.y * dy.y + missing * across.y * across.y + 1.0;
        Self { a: vv, b: -2.0 * uv, c: uu, f: uu * vv - uv * uv }
    }
}

/// The mean of the texels in an ellipse around `uv`.
#[inline(never)]
pub(super) fn mean(
    texels: &LevelTexels<impl Fetch>,
    around: &Surroundings,
    uv: Vec2,
    ellipse: &Quadratic,
) -> Vec4 {
    let Quadratic { a, b, c, f } = *ellipse;
    let x = Place::of(uv.x, texels.size.width, around.u);
    let y = Place::of(uv.y, texels.size.height, around.v);
    // The farthest points of the ellipse along the axes. Footprints beyond all sense are cut.
    let reach = |square: f32| (square.sqrt().min(MOST_REACH) + 1.0) as i32;
    let (across, down) = (reach(c), reach(a));
    let (mut sum, mut weights) = (Vec4::ZERO, 0.0);
    let steps_per_unit = TABLE as f32 / f;
    for j in -down..=down + 1 {
        let (dy, row) =
            (j as f32 - y.fraction, wrapped_index(y.texel + j, texels.size.height, around.v));
        for i in -across..=across + 1 {
            let dx = i as f32 - x.fraction;
            let q = (a * dx + b * dy) * dx + c * dy * dy;
            let Some(weight) = GAUSSIAN.get((q * steps_per_unit) as usize) else { continue };
            let column = wrapped_index(x.texel + i, texels.size.width, around.u);
            sum += texels.get(column, row).unwrap_or(around.border) * *weight;
            weights += weight;
        }
    }
    if weights > 0.0 { sum / weights } else { bilinear(texels, around, uv) }
}

/// The most texels from the middle of an ellipse to its end.
const MOST_REACH: f32 = 256.0;

/// How many steps the Gaussian has.
const TABLE: usize = 1024;

/// exp(-2 q) - exp(-2) for q from 0 to 1: it ends at 0, so that no texel comes or goes at once.
static GAUSSIAN: [f32; TABLE] = {
    let mut table = [0.0; TABLE];
    let mut i = 0;
    while i < TABLE {
        let q = (i as f64 + 0.5) / TABLE as f64;
        table[i] = (exponential(-2.0 * q) - exponential(-2.0)) as f32;
        i += 1;
    }
    table
};

/// The exponential's series, by Horner's rule, for numbers from -2 to 0.
const fn exponential(x: f64) -> f64 {
    let (mut sum, mut n) = (1.0, 24.0);
    while n > 0.0 {
        sum = 1.0 + sum * x / n;
        n -= 1.0;
    }
    sum
}
