//! Renderers on top of the scan converter, and the memory that they draw to.
//!
//! Each renderer draws any [`Geometry`], a polygon, a [`Mesh`], a sorted mesh, a [tree](BspTree), [`Lines`],
//! [`Points`], on any [`RenderTarget`], in each of three ways: `draw` calls a shader for each fragment, `draw_blocks` for 16
//! at a time, `draw_depth` draws depth alone.
//!
//! # Which renderer, when
//!
//! | | [`ZBufferRenderer`] | [`ScanlineRenderer`] | [`PainterRenderer`], by tree | [`PainterRenderer`], by depth |
//! |---|---|---|---|---|
//! | for | meshes of many small faces, polygons that come one by one | costly shaders, faces behind each other, glass, pictures larger than memory | glass seen from many sides | sets known not to overlap in depth |
//! | opaque picture | exact | the same bits | the same bits, but where surfaces meet at a pixel's centre | wrong where faces cross or overlap in depth |
//! | transparent faces | as they are drawn: the caller sorts them, and faces that cross have no order | exact at each pixel, also where they cross | exact, but where surfaces meet at a pixel's centre | in the order of their depths |
//! | shaded at a pixel | each face nearer than those before it: about ln k of k in random order | the visible face, and the glass before it | all faces | all faces |
//! | time, besides shading | each fragment of each face | the faces' spans in each row: n log k for n spans, k deep | each fragment, spans of each piece | each fragment, a sort of the faces |
//! | lines and points | compared like faces | compared with what the target holds, one after the other | over what is there, in their order | the same |
//! | [conservative coverage](crate::CoverageRule) | yes | no: by centres | yes | yes |
//! | before the first picture | nothing | a sort of the faces by row | the tree: n log n for surfaces, up to n^3 for n planes that all cross | nothing |
//! | memory | the framebuffer | some rows, the faces that cross them, 24 bytes for each face | the framebuffer, some 80 bytes for each piece | the framebuffer |
//! | several [`Buffers`] in one pass | yes | yes, but for `stream` | yes | yes |
//! | [`Statistics`] | yes | yes, of pixels that are seen; not of `stream` | yes | yes |
//! | [`Stencil`] | yes | no: faces have no order | yes, without depth | yes, without depth |
//! | occlusion queries | yes | no | no: no depth is compared | no |
//! | drawing in steps | yes: depth stays in the framebuffer | a scene at once; over what a framebuffer holds | a tree at once, over what a framebuffer shows | as by tree |
//!
//! Several samples a pixel are drawn by a [`MultisampleRenderer`], a z-buffer of its own, into one buffer and without
//! stencil and statistics; the others draw large and take [`Framebuffer::downsampled`]. What is seen as numbers, faces
//! and barycentrics, a [`VisibilityRenderer`] finds: by the z-buffer, by the scanline renderer where several layers are
//! wanted, and by the renderer of samples where those are; it counts nothing. Which boxes are hidden behind occluders, before anything is
//! drawn, an [`OcclusionRenderer`] says. Pixels covered in part are drawn by their exact areas, in painter's order,
//! by an [`AreaRenderer`].
//!
//! The z-buffer's order of drawing matters to its time only: from front to back each pixel is shaded
//! once. Times are in the project's PERFORMANCE.md.
//!
//! # How a renderer works
//!
//! All that depends on a shader is in one private module, `render::shader`: loops over visible blocks. The
//! rest, from vertices to the depths that blocks are tested against, is compiled once, in this library.
//! So a shader costs its author little time to compile, and a program that is not optimised still draws
//! with a library that is.

pub(crate) mod coarse_depth;
mod counters;
mod stencil;
mod depth;
pub(crate) mod band;
mod pixel;
mod paint;
pub(crate) mod shader;
mod raster;
pub(crate) mod parallel;
mod canvas;
mod target;
mod framebuffer;
mod supersample;
mod faces;
mod corners;
mod bsp;
mod stroke_style;
mod geometry;
mod lines;
mod by_depth;
mod statistics;
mod front;

mod mesh;
mod strokes;
mod z_buffer;
mod query;
mod painter;
mod scanline;
mod samples;
mod occlusion;
mod visibility;
mod area;
#[cfg(feature = "png")]
mod png_file;

pub use self::area::{AreaOrder, AreaRenderer};
pub use self::bsp::BspTree;
pub use self::depth::DepthTest;
pub use self::faces::FaceIndices;
pub use self::framebuffer::Framebuffer;
pub use self::front::OneThread;
pub use self::geometry::{Geometry, Mesh, PosedTree};
pub use self::lines::{Contours, Lines, Points, Polyline, Strips};
pub use self::occlusion::OcclusionRenderer;
pub use self::paint::{Additive, Over, Paint};
pub use self::painter::PainterRenderer;
pub use self::pixel::{Buffers, Pixel};
#[cfg(feature = "png")]
pub use self::png_file::{PngError, PngFile};
pub use self::samples::{
    Average, MultisampleFramebuffer, MultisampleRenderer, Samples, ShadingPlace,
};
pub use self::scanline::ScanlineRenderer;
pub use self::statistics::Statistics;
pub use self::stencil::{Stencil, StencilFace, StencilOp, StencilTest};
pub use self::stroke_style::{Cap, Join};
pub use self::target::{RenderTarget, Target, TargetError};
pub use self::visibility::{Product, Visibility, VisibilityRenderer};
pub use self::z_buffer::ZBufferRenderer;
