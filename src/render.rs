//! Renderers on top of the scan converter, and the framebuffer that they draw to.
//!
//! # Which renderer, when
//!
//! | | [`ZBuffer`] | [`Scanline`] | [`Painter`], by tree | [`Painter`], by depth |
//! |---|---|---|---|---|
//! | for | meshes of many small faces, polygons that come one by one | costly shaders, faces behind each other, glass, pictures larger than memory | glass seen from many sides | sets known not to overlap in depth |
//! | opaque picture | exact | the same bits | the same bits, but where surfaces meet at a pixel's centre | wrong where faces cross or overlap in depth |
//! | transparent faces | as they are drawn: the caller sorts them, and faces that cross have no order | exact at each pixel, also where they cross | exact, but where surfaces meet at a pixel's centre | in the order of their depths |
//! | shaded at a pixel | each face nearer than those before it: about ln k of k in random order | the visible face, and the glass before it | all faces | all faces |
//! | time, besides shading | each fragment of each face | the faces' spans in each row: n log k for n spans, k deep | each fragment, spans of each piece | each fragment, a sort of the faces |
//! | before the first picture | nothing | a sort of the faces by row | the tree: n log n for surfaces, up to n^3 for n planes that all cross | nothing |
//! | memory | the framebuffer | some rows, the faces that cross them, 24 bytes for each face | the framebuffer, some 80 bytes for each piece | the framebuffer |
//! | drawing in steps | yes: depth stays in the framebuffer | a scene at once; over what a framebuffer holds | a tree at once, over what a framebuffer shows | as by tree |
//!
//! The z-buffer's order of drawing matters to its time only: from front to back each pixel is shaded
//! once. Milliseconds for 1920 x 1080 pixels on one thread, the medians that `cargo bench --bench
//! renderers` found on a machine with other work to do, so that only ratios mean something; the
//! layers are quads over the whole view, tilted, in random order, and more of them cross the more
//! there are:
//!
//! | | z-buffer | scanline | painter, by tree | painter, by depth |
//! |---|---|---|---|---|
//! | 1, 4, 16, 64 layers, cheap shader | 7.8, 21, 38, 62 | 7.6, 9.5, 9.8, 18 | 7.4, 32, 121, 1281 | 7.4, 30, 105, 402 |
//! | the same, costly shader | 50, 120, 268, 443 | 54, 47, 50, 107 | 49, 189, 818, 6723 | 48, 187, 887, 4578 |
//! | the same as glass | 10, 26, 93, 390 | 8.6, 28, 321, 10480 | 9.6, 25, 101, 1614 | 8.2, 24, 81, 319 |
//! | ring of 69,696 triangles, cheap shader | 28 | 93 | 107 | 57 |
//! | the same, costly shader | 140 | 196 | 300 | 224 |
//! | the same as glass | 38 | 102 | 106 | 59 |
//!
//! By depth the layers are not right, nor is glass by the z-buffer, which drew it as it came. What the
//! painter draws grows with the pieces that crossings make: 12 of 4 layers, 170 of 16, 6,242 of
//! 64, 136,488 of the ring, whose tree was built once, in 502 ms. The scanline renderer sorts glass
//! again wherever two panes cross in a row, which is why many that do are better painted.

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
#[cfg(feature = "png")]
mod png_file;

pub use bsp::BspTree;
pub use framebuffer::Framebuffer;
pub use painter::Painter;
#[cfg(feature = "png")]
pub use png_file::{PngError, PngFile};
pub use scanline::{Scanline, Scene};
pub use shader::{Over, Paint, Plus};
pub use z_buffer::{DepthSource, DepthTest, ZBuffer};
