//! The colour of a picture at a point between its texels.

use glam::{Vec2, Vec4};

use crate::texture::texels::Texels;
use crate::texture::wrap::{Neighbours, Wrap, nearest_index};

/// How the texels around a point become its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Filter {
    /// The texel that the point lies in.
    Nearest,
    /// The four texels whose centres surround the point, weighted by nearness along each axis.
    #[default]
    Bilinear,
}

/// The texel that `uv` lies in. On the line between two texels it is the right or lower one.
#[inline]
pub(super) fn nearest(texels: &Texels, (wrap_u, wrap_v): (Wrap, Wrap), uv: Vec2) -> Vec4 {
    let x = nearest_index(uv.x, texels.width(), wrap_u);
    let y = nearest_index(uv.y, texels.height(), wrap_v);
    texels.get(x, y)
}

/// The mean of the four texels around `uv`, weighted by nearness along each axis.
#[inline]
pub(super) fn bilinear(texels: &Texels, (wrap_u, wrap_v): (Wrap, Wrap), uv: Vec2) -> Vec4 {
    let x = Neighbours::around(uv.x, texels.width(), wrap_u);
    let y = Neighbours::around(uv.y, texels.height(), wrap_v);
    let upper = mix(texels.get(x.low, y.low), texels.get(x.high, y.low), x.fraction);
    let lower = mix(texels.get(x.low, y.high), texels.get(x.high, y.high), x.fraction);
    mix(upper, lower, y.fraction)
}

/// From `a` at 0 to `b` at 1; two equal texels give exactly their colour.
#[inline]
fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a + (b - a) * t
}
