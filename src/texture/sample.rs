//! The colour of a picture at a point between its texels.

use glam::{Vec2, Vec4};

use crate::texture::cubic::Cubic;
use crate::texture::texels::{Fetch, LevelTexels};
use crate::texture::wrap::{Neighbours, Place, Wrap, nearest_index, wrapped_index};

/// How the texels around a point become its colour, where a picture is magnified.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Filter {
    /// The texel that the point lies in.
    Nearest,
    /// The four texels whose centres surround the point, weighted by nearness along each axis.
    #[default]
    Bilinear,
    /// Four by four texels, weighted by a cubic along each axis: smoother, without the bilinear mean's
    /// creases.
    Bicubic(Cubic),
}

/// What is shown outside of a picture.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Surroundings {
    pub(super) u: Wrap,
    pub(super) v: Wrap,
    /// The colour of [`Wrap::Border`].
    pub(super) border: Vec4,
}

impl Surroundings {
    /// Whether there is a border along an axis.
    #[inline(always)]
    pub(super) fn has_border(&self) -> bool {
        self.u == Wrap::Border || self.v == Wrap::Border
    }
}

/// The colour at `uv` by a filter.
#[inline(always)]
pub(super) fn by_filter(
    filter: Filter,
    texels: &LevelTexels<impl Fetch>,
    around: &Surroundings,
    uv: Vec2,
) -> Vec4 {
    match filter {
        Filter::Nearest => nearest(texels, around, uv),
        Filter::Bilinear => bilinear(texels, around, uv),
        Filter::Bicubic(cubic) => bicubic(cubic, texels, around, uv),
    }
}

/// The texel that `uv` lies in. On the line between two texels it is the right or lower one.
#[inline(always)]
pub(super) fn nearest(texels: &LevelTexels<impl Fetch>, around: &Surroundings, uv: Vec2) -> Vec4 {
    let x = nearest_index(uv.x, texels.size.width, around.u);
    let y = nearest_index(uv.y, texels.size.height, around.v);
    texels.get(x, y).unwrap_or(around.border)
}

/// The mean of the four texels around `uv`, weighted by nearness along each axis.
#[inline(always)]
pub(super) fn bilinear(texels: &LevelTexels<impl Fetch>, around: &Surroundings, uv: Vec2) -> Vec4 {
    let size = (texels.size.width, texels.size.height);
    let (x, y) = Neighbours::of_point(uv, size, (around.u, around.v));
    let has_border = around.has_border();
    let start = |row: u32| texels.size.start + row as usize * size.0 as usize;
    let mixed = |row: u32, start: usize| {
        let texel = |column: u32| {
            // Without a border all are inside.
            let texel = if has_border {
                texels.get(column, row)
            } else {
                texels.numbered(start + column as usize)
            };
            texel.unwrap_or(around.border)
        };
        mix(texel(x.low), texel(x.high), x.fraction)
    };
    let (upper, lower) = (mixed(y.low, start(y.low)), mixed(y.high, start(y.high)));
    mix(upper, lower, y.fraction)
}

/// The mean of the four by four texels around `uv`, weighted by a cubic along each axis.
#[inline(never)]
pub(super) fn bicubic(
    cubic: Cubic,
    texels: &LevelTexels<impl Fetch>,
    around: &Surroundings,
    uv: Vec2,
) -> Vec4 {
    let x = Place::of(uv.x, texels.size.width, around.u);
    let y = Place::of(uv.y, texels.size.height, around.v);
    let (across, down) = (cubic.weights(x.fraction), cubic.weights(y.fraction));
    let mut sum = Vec4::ZERO;
    for (row, weight) in (-1..).zip(down) {
        let j = wrapped_index(y.texel + row, texels.size.height, around.v);
        let mut line = Vec4::ZERO;
        for (column, weight) in (-1..).zip(across) {
            let i = wrapped_index(x.texel + column, texels.size.width, around.u);
            line += texels.get(i, j).unwrap_or(around.border) * weight;
        }
        sum += line * weight;
    }
    sum
}

/// From `a` at 0 to `b` at 1; two equal texels give exactly their colour.
#[inline(always)]
pub(super) fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}
