//! Fragments: one pixel of one polygon, with depth, w and parameters.
//!
//! A [span](crate::span) goes in. It is evaluated in blocks of [`LANES`] pixels (`fragment::block`): each
//! of (z, s_1 .. s_n, s_{n+1}) is its value at one end of the run plus a multiple of its change per
//! pixel, so error does not build up along the run. Then comes the one reciprocal a pixel,
//! w = 1 / s_{n+1}, and r_i = s_i w (Heckbert and Moreton 1991, section 3.5); if all w are equal, there
//! is nothing to divide. What a shader sees of this is in `fragment::pixel`, and what it sees of parameters
//! with a denominator of their own in `fragment::cluster`.
//!
//! ```text
//!     a block in the row of a long run:    [0 1 2 3 4 5 6 7 8 9 . . . . . 15]
//!
//!     in two rows of short runs:           [0 1 2 3 4 5 6 7]
//!                                          [8 9 . . . .  15]
//! ```
//!
//! The end is that of the polygon, visible or not. So a fragment is a function of the polygon and
//! the pixel alone, and a picture is the same to the bit however it is cut into tiles.

pub(crate) mod block;
mod footprint;
mod pixel;
mod cluster;

pub use self::block::{LANES, Lanes};
pub use self::footprint::{Footprint, FootprintBlock};
pub use self::pixel::{Fragment, FragmentBlock};
