//! The edge table and the active edges: which pixels a polygon covers.
//!
//! An outline in subpixels goes in, runs of covered pixels come out, scanline by scanline. All
//! arithmetic is exact, on integers and for triangles on f64 that hold them without loss, so coverage
//! is: a pixel is covered when its centre lies inside the outline, and a centre exactly on an edge
//! belongs to the polygon on its right or, for a horizontal edge, below (the top-left rule):
//!
//! ```text
//!      0   1   2   3
//!    0 .   .   .   .      A rectangle with corners in the centres of pixels (1, 1) and (3, 3)
//!    1 .   #   #   .      covers its top and left sides, not its bottom and right ones.
//!    2 .   #   #   .
//!    3 .   .   .   .
//! ```
//!
//! Coverage is a value of one of three kinds (`coverage::shape`). Any outline has its edges kept in a
//! table sorted by first row (`coverage::edge_table`); those that cross the current row are active
//! (`coverage::active`), each stepped by `coverage::edge`; what is inside there, a [`FillRule`] says.
//! A convex outline has at most two active edges and needs no table (`coverage::convex`). A triangle's
//! three edges are lines in f64, of which eight rows are found at once (`coverage::triangle`).
//!
//! Other rules than that of centres, all pixels that a polygon touches or those that it covers wholly,
//! take the pixels through which edges pass to those or from them (`coverage::conservative`).
//!
//! How much of each pixel an outline covers, its area there, is no run: [`AreaTable`] has it (`coverage::pixel_area`).
//!
//! Lines of width 1 are no polygons: they have the pixels that the diamond-exit rule gives
//! (`coverage::line`).

mod fill_rule;
mod rule;
mod edge;
pub(crate) mod area;
pub(crate) mod run;
mod convex;
pub(crate) mod triangle;
pub(crate) mod line;
mod active;
mod conservative;
pub(crate) mod shape;
mod edge_table;
mod pixel_area;

pub use self::edge_table::{EdgeTable, Runs};
pub use self::fill_rule::FillRule;
pub use self::pixel_area::AreaTable;
pub use self::rule::{CoverageRule, OutsidePolygon};
pub use self::run::Run;
