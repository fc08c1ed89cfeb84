//! Renderers on top of the scan converter, and the framebuffer that they draw to.

mod framebuffer;
mod coarse_depth;
mod shader;
mod raster;
mod mesh;
#[cfg(not(feature = "parallel"))]
mod sequential;
mod z_buffer;
mod bsp;
mod painter;
mod visible;
mod scanline;
#[cfg(feature = "image")]
mod png_file;

pub use bsp::BspTree;
pub use framebuffer::Framebuffer;
pub use painter::Painter;
#[cfg(feature = "image")]
pub use png_file::{PngError, PngFile};
pub use scanline::{Scanline, Scene};
pub use shader::{Over, Paint, Plus};
pub use z_buffer::{DepthSource, DepthTest, ZBuffer};
