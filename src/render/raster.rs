//! From coverage to visible blocks: the rasterizing loops of the renderers.
//!
//! A polygon passes four steps:
//!
//! 1. `raster::plan` decides which loops the polygon takes: the only place that knows what is common;
//! 2. `raster::rows` takes its runs in groups of rows, and the columns of long runs that the coarse
//!    depth leaves;
//! 3. `raster::test` compares blocks with the stored depths: of short runs two rows at a time, of long
//!    ones whole blocks that begin at cache lines;
//! 4. the visible blocks are shaded by [`ShadeBlocks`](crate::render::shader::ShadeBlocks), and the
//!    depths of what was drawn are stored.
//!
//! Nothing here depends on the shader, the colours or the number of parameters.

pub(crate) mod plan;
mod test;
mod rows;

pub(crate) use self::rows::{RasterMemory, draw, draw_runs};
