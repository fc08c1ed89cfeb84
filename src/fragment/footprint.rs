//! Footprints: the part of a texture that a pixel sees, to first order.

use glam::Vec2;

use crate::fragment::block::Lanes;

/// A texture coordinate with its derivatives: to first order, a pixel sees the parallelogram around `uv`
/// with the sides `dx` and `dy`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// The texture coordinate at the pixel's centre.
    pub uv: Vec2,
    /// Its change per pixel to the right.
    pub dx: Vec2,
    /// Its change per pixel downwards.
    pub dy: Vec2,
}

impl From<Vec2> for Footprint {
    /// A point, of no extent.
    fn from(uv: Vec2) -> Self {
        Self { uv, ..Self::default() }
    }
}

impl From<[f32; 2]> for Footprint {
    /// A point, of no extent.
    fn from(uv: [f32; 2]) -> Self {
        Vec2::from(uv).into()
    }
}

/// The footprints of a block's pixels: each value first for u, then for v.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FootprintBlock {
    /// The texture coordinates at the pixels' centres.
    pub uv: [Lanes; 2],
    /// Their changes per pixel to the right.
    pub dx: [Lanes; 2],
    /// Their changes per pixel downwards.
    pub dy: [Lanes; 2],
}

impl FootprintBlock {
    /// One of the footprints. Lanes beyond the last count as the last.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, lane: usize) -> Footprint {
        let of = |[u, v]: &[Lanes; 2]| {
            let lane = lane.min(u.len() - 1);
            Vec2::new(u[lane], v[lane])
        };
        Footprint { uv: of(&self.uv), dx: of(&self.dx), dy: of(&self.dy) }
    }

    /// Replaces the texture coordinate of one of the footprints. Lanes beyond the last count as the last.
    #[inline(always)]
    pub(crate) fn set_uv(&mut self, lane: usize, uv: Vec2) {
        set(&mut self.uv, lane, uv);
    }

    /// Replaces the changes per pixel of one of the footprints. Lanes beyond the last count as the last.
    #[inline(always)]
    pub(crate) fn set_sides(&mut self, lane: usize, footprint: &Footprint) {
        set(&mut self.dx, lane, footprint.dx);
        set(&mut self.dy, lane, footprint.dy);
    }
}

#[inline(always)]
fn set([u, v]: &mut [Lanes; 2], lane: usize, value: Vec2) {
    let lane = lane.min(u.len() - 1);
    [u[lane], v[lane]] = value.to_array();
}
