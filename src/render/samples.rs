//! Several samples a pixel: edges without steps, each polygon shaded once a pixel.
//!
//! Sample k of a pixel is covered by a polygon if the pixel's centre is covered by the polygon moved by
//! the sample's place, in whole subpixels. So coverage is as exact at the samples as it is at the
//! centres, and polygons that share an edge cover each sample along it exactly once. Depth is compared at
//! each sample. A polygon's colour is found once for all samples of a pixel that show it (K. Akeley,
//! "RealityEngine Graphics", SIGGRAPH 1993).
//!
//! Time and memory against the number of samples are in the project's PERFORMANCE.md.
//!
//! `samples::pattern` has the places, `samples::frame` the memory; `samples::raster` finds what is covered,
//! of `samples::small` triangles by whole blocks, and `samples::shade` tests and stores it, coloured by a
//! `samples::shader`; `samples::renderer` is what is drawn with.

pub(crate) mod pattern;
pub(crate) mod frame;
mod shader;
mod shade;
mod small;
mod raster;
pub(crate) mod renderer;

pub use self::frame::{Average, MultisampleFramebuffer};
pub use self::pattern::Samples;
pub use self::renderer::{MultisampleRenderer, ShadingPlace};
