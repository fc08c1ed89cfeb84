//! Exact polygon scan conversion on the CPU, with perspective-correct parameters.
//!
//! `polyscan` turns polygons given in homogeneous clip space into pixels. It follows Paul Heckbert:
//! a generic clipper in homogeneous space, an active edge table, and rational linear interpolation
//! of any number of parameters a vertex, with one reciprocal a pixel, and none when all w are equal.
//!
//! # A picture in a few lines
//!
//! ```
//! use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
//! use glam::{Vec2, Vec3};
//! use polyscan::{Framebuffer, Vertex, ZBuffer};
//!
//! // A square floor, seen in perspective, with a parameter (u, v) at each corner.
//! let camera = perspective(1.0, 4.0 / 3.0, 0.1, 100.0)
//!     * look_at_mat4(Vec3::new(0.0, 1.0, 2.0), Vec3::ZERO, Vec3::Y);
//! let floor = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
//!     .map(|(x, z)| Vertex::new(camera * Vec3::new(x, 0.0, z).extend(1.0), Vec2::new(x, z)));
//!
//! let mut frame = Framebuffer::new(320, 240, [255u8; 4])?;
//! let mut renderer = ZBuffer::new(frame.viewport());
//! renderer.draw(&mut frame, &floor, |fragment| {
//!     let [u, v] = fragment.params.map(|r| (r * 4.0).floor() as i32);
//!     if (u + v) % 2 == 0 { [200, 40, 40, 255] } else { [40, 40, 60, 255] }
//! });
//! # #[cfg(feature = "png")]
//! frame.save_png(std::env::temp_dir().join("floor.png"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The flow
//!
//! Each stage is a module, in this order, and can be used on its own:
//!
//! | module | what it does |
//! |---|---|
//! | [`vertex`] | [`Vertex<N>`](Vertex): a position (xw, yw, zw, w) in clip space and N parameters |
//! | [`outline`] | the contours of a polygon: one, or several with holes among them |
//! | [`clip`] | clips by planes in homogeneous space, before any division |
//! | [`project`] | divides by w, keeps 1/w, maps to the [`Viewport`] |
//! | [`gradient`] | parameters as planes over the screen; the paper's equation (1) |
//! | [`edge_table`] | edges sorted by first scanline, the active ones stepped from row to row; fill rules |
//! | [`span`] | a row's run of pixels: start values and changes per pixel |
//! | [`fragment`] | a pixel: depth, w, parameters, derivatives; one reciprocal each |
//! | [`scan`] | the stages joined: [`ScanConverter`], polygon in, spans out |
//! | [`render`] | the [`ZBuffer`] renderer, polygon by polygon or a mesh at once; the [`Painter`], from back to front by a [`BspTree`]; their [`Framebuffer`]; the [`Scanline`] renderer, row by row |
//! | [`color`], [`texture`] | linear light and sRGB; pictures to sample |
//! | `obj` | OBJ and MTL files to polygons |
//!
//! A polygon keeps its sides; nothing is triangulated on the way.
//!
//! # Conventions
//!
//! - Clip space has x right and y up; positions are column vectors. A point is visible where
//!   -w <= x <= w, -w <= y <= w and 0 <= z <= w, as in wgpu, Direct3D, Metal and
//!   [`glam::camera::rh::proj::directx`]. OpenGL's -w <= z <= w is [`ClipSpace::MinusOneToOne`].
//! - The screen has x right and y *down*; pixel (0, 0) is at the top left, as in the `image` crate;
//!   pixel (i, j) is sampled at its centre (i + 0.5, j + 0.5).
//! - Screen positions are rounded to 1/256 pixel, half to even. From there on coverage is exact
//!   arithmetic with the top-left rule: polygons that share an edge touch each pixel along it
//!   exactly once.
//! - A polygon may be concave, have holes and cross itself. What its contours wind around is inside
//!   ([`FillRule::NonZero`]), or what they wind around an odd number of times
//!   ([`FillRule::EvenOdd`]).
//! - Depth is z/w in the viewport's depth range, f32, smaller is nearer by default.
//! - Colours that are blended, filtered or averaged are linear light; 8-bit pictures are sRGB.
//!
//! # Parameters that are not affine on the polygon
//!
//! On a triangle every parameter is affine, and so are texture coordinates and positions on flat
//! polygons; they are planes over the screen. A polygon of four or more sides may carry any values
//! at its vertices, colours for example. Those are interpolated along the polygon's edges and then
//! across each span, and the result depends on how the polygon is rotated on the screen (Heckbert
//! and Moreton 1991, section 3.4). Cut the polygon into triangles where that matters, or compute
//! the colour in the shader from parameters that are affine.
//!
//! # Shaders, and speed
//!
//! A shader is a closure from a [`Fragment`] to a colour ([`ZBuffer::draw`]), or from a
//! [`FragmentBlock`] of 16 fragments to theirs ([`ZBuffer::draw_blocks`]). The second is for speed:
//! its loop over the lanes becomes SIMD instructions, for the best level that the machine has. For
//! that a shader must be inlined: a closure is, and what it calls if that is small or marked
//! `#[inline(always)]`; a function that is given by its name is not. What no SIMD instruction does
//! everywhere, such as a look-up in a table, is best left to a second loop. Meshes are best drawn as
//! such, by [`ZBuffer::draw_mesh`] and [`ZBuffer::draw_mesh_blocks`]: vertices are projected once,
//! and all processors take part. None of this changes a bit of the picture.
//!
//! # Pictures too large for memory
//!
//! [`Scanline`] draws the same pictures from top to bottom and hands each row over when it is
//! finished, to a [`render::PngFile`] for example. It shades each visible pixel once, and it has
//! transparent faces in their order where they cross.
//!
//! # Any input is safe
//!
//! Positions may be anything that fits an f32: a polygon with one that is not finite is not drawn,
//! one that reaches through the eye is clipped. Nothing panics, and the work for a polygon is
//! bounded by its vertices and the scanlines and pixels inside the viewport.
//!
//! # Features
//!
//! - `image` (default): textures from files and pictures, framebuffers to pictures, PNG files row
//!   by row.
//! - `obj` (default): OBJ and MTL files. Needs `image`.
//! - `parallel` (default): meshes are drawn by all processors, through `rayon`. The picture is the
//!   same without.
//! - `fallback`: the code without SIMD is compiled for machines that have some as well, to test and to
//!   time it. Where there is no SIMD it is in use without the feature.
//!
//! # Sources
//!
//! - P. Heckbert and H. Moreton, "Interpolation for Polygon Texture Mapping and Shading", in State
//!   of the Art in Computer Graphics, Springer 1991.
//! - P. Heckbert, "Generic Convex Polygon Scan Conversion and Clipping", Graphics Gems, 1990.
//! - K.-L. Low, "Perspective-Correct Interpolation", 2002.
//! - H. Fuchs, Z. Kedem and B. Naylor, "On Visible Surface Generation by A Priori Tree Structures",
//!   SIGGRAPH 1980; M. Newell, R. Newell and T. Sancha, "A Solution to the Hidden Surface Problem",
//!   ACM 1972: the painter's renderer.

pub mod vertex;
pub mod outline;
pub mod clip;
pub mod project;
pub mod gradient;
pub mod edge_table;
mod number;
mod polygon;
pub mod span;
pub mod fragment;
pub mod scan;
pub mod render;
pub mod color;
pub mod texture;
pub mod camera;
#[cfg(feature = "obj")]
pub mod obj;

pub use camera::Camera;
pub use clip::{ClipPlane, ClipSpace};
pub use edge_table::FillRule;
pub use fragment::{Fragment, FragmentBlock};
pub use gradient::ParameterMatrix;
pub use outline::Outline;
pub use project::{Rect, SizeError, Viewport};
pub use render::{BspTree, DepthSource, DepthTest, Framebuffer, Painter, Scanline, ZBuffer};
pub use scan::{Cull, ScanConverter};
pub use span::Span;
pub use texture::Texture;
pub use vertex::{Interpolation, Parameter, Vertex};

#[cfg(feature = "image")]
pub use image;

/// The README's code, compiled and run.
#[cfg(all(doctest, feature = "image"))]
#[doc = include_str!("../README.md")]
struct Readme;
