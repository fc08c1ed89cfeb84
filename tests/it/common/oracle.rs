//! An oracle for coverage and parameters: polygons in clip space in, covered pixels and parameter
//! values out.
//!
//! Written from the conventions and the contracts alone, and the slow way on purpose. Coverage
//! clips and projects in rational numbers, rounds once, and asks pixel by pixel whether the centre
//! lies in the outline: no edge is stepped, no span is built. Parameters come from meeting the ray
//! of a pixel centre with the plane of the polygon in clip space: no screen-space plane, nothing
//! divided by w beforehand, nothing carried from pixel to pixel.
//!
//! Clip space has x right and y up, screen space x right and y down with pixel (0, 0) top left.
//! Positions are finite; the oracle panics on others, as exact arithmetic has no word for them.

pub(crate) mod diamonds;
mod clipping;
mod parts;
mod projection;
mod coverage;
mod parameters;
mod distances;

use num_rational::BigRational;

pub(crate) use clipping::{clip, clip_to_view, depth_planes, exact, plane, rational};
pub(crate) use coverage::{
    Mask, centre, coverage, coverage_counts, covers, covers_convex, doubled_area, fill,
    fill_border, is_convex, winding,
};
pub(crate) use distances::{distance_outside, distance_to_edges, nearest_point};
pub(crate) use parameters::{Sample, best_triple, sample, sample_exact, window_depth};
pub(crate) use parts::{Edge, border, planar_border};
pub(crate) use projection::{outline, round_half_even, snap, unrounded_outline};

/// A vertex in clip space: x right, y up, z, w.
pub(crate) type Position = [f32; 4];
/// A vertex in clip space, exactly.
pub(crate) type Exact = [BigRational; 4];
/// The half space a x + b y + c z + d w >= 0.
pub(crate) type Plane = [BigRational; 4];
/// A point of the screen in steps of 1/256 pixel, y down.
pub(crate) type Snapped = (i64, i64);

/// Steps per pixel: positions are rounded to 8 fractional bits.
const STEPS: i64 = 256;

/// A viewport in pixels whose top left pixel is (0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Which depths the view volume holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// 0 <= z <= w.
    ZeroToOne,
    /// -w <= z <= w.
    MinusOneToOne,
}

/// Which winding numbers are inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FillRule {
    /// All but 0.
    NonZero,
    /// The odd ones.
    EvenOdd,
}
