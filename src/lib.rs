//! Exact polygon scan conversion on the CPU, with perspective-correct parameters.
//!
//! ![Checkered quads: bent like rubber above, where texture coordinates are interpolated linearly on the
//! screen; right in perspective below](https://raw.githubusercontent.com/polyscan/polyscan/main/examples/assets/pictures/quads.png)
//!
//! `polyscan` turns polygons given in homogeneous clip space into pixels. It follows Paul Heckbert:
//! a generic clipper in homogeneous space, an active edge table, and rational linear interpolation
//! of any number of parameters a vertex, with one reciprocal a pixel, and none when all w are equal.
//!
//! # A picture in a few lines
//!
//! ```
//! use polyscan::glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
//! use polyscan::glam::{Vec2, Vec3};
//! use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
//!
//! // A square floor, seen in perspective, with a parameter (u, v) at each corner.
//! let camera = perspective(1.0, 4.0 / 3.0, 0.1, 100.0)
//!     * look_at_mat4(Vec3::new(0.0, 1.0, 2.0), Vec3::ZERO, Vec3::Y);
//! let floor = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
//!     .map(|(x, z)| Vertex::new(camera * Vec3::new(x, 0.0, z).extend(1.0), Vec2::new(x, z)));
//!
//! let mut frame = Framebuffer::new(320, 240, [255u8; 4])?;
//! let mut renderer = ZBufferRenderer::new(frame.viewport());
//! renderer.draw(&mut frame, &floor, |fragment| {
//!     let [u, v] = fragment.params.map(|r| (r * 4.0).floor() as i32);
//!     if (u + v) % 2 == 0 { [200, 40, 40, 255] } else { [40, 40, 60, 255] }
//! });
//! # #[cfg(feature = "png")]
//! frame.save_png(std::env::temp_dir().join("floor.png"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The tour
//!
//! A polygon's data pass through these modules in this order, and no module imports one that comes
//! later. Those that are links are public and can be used on their own: [`Surface`] shows how they join
//! by hand.
//!
//! **A polygon in clip space**
//!
//! | module | what it does |
//! |---|---|
//! | `round`, `simd`, `scalar`, `angle` | rounding by one addition; which SIMD levels code is compiled for; one polygon or eight at once; angles by the same arithmetic everywhere |
//! | [`vertex`] | [`Vertex<N>`](Vertex): a position (xw, yw, zw, w) in clip space and N parameters |
//! | `vertices` | vertices whose number of parameters is known at run time only |
//! | [`outline`] | the contours of a polygon: one, or several with holes among them |
//! | [`viewport`] | the pixels that the view volume is mapped to |
//! | [`view_volume`] | planes and outcodes: what is inside, said in bits |
//! | [`clip`] | clips by planes in homogeneous space, before any division: `clip::polygon` takes the step of Sutherland and Hodgman over `clip::records`; `clip::chains` closes outlines that fall apart |
//!
//! **On the screen**
//!
//! | module | what it does |
//! |---|---|
//! | [`subpixel`] | positions rounded to 1/256 pixel: the joint between clipping and coverage |
//! | [`project`] | divides by w, keeps 1/w |
//! | [`coverage`] | which pixels: `coverage::fill_rule`, the `coverage::rule`, `coverage::edge`, `coverage::area`, `coverage::run`, `coverage::convex` outlines, `coverage::triangle`s eight rows at once, the pixels of a `coverage::line`, `coverage::active` edges, `coverage::conservative` coverage, the `coverage::shape` as a value, the `coverage::edge_table`; how much of a pixel, `coverage::pixel_area` |
//! | `window` | the columns and rows that are visited |
//! | `settings` | [`Settings`]: how polygons are brought to the screen |
//! | `surface` | how parameters run over the screen: `surface::plane`s, the `surface::base` of depth and 1/w, what is `surface::mixed`, the values along `surface::rows`, `surface::triangle`s, a `surface::batch` of eight, any `surface::polygon`, a `surface::line` |
//! | `primitive` | a polygon ready for its rows: the one place where one is prepared |
//! | [`parameter_matrix`] | the paper's equation (1) |
//! | [`fragment`] | a pixel: depth, w, parameters, derivatives; one reciprocal each. `fragment::block`s of 16; the `fragment::footprint` of a pixel in a texture; what a shader sees, `fragment::pixel`, and parameters with a denominator of their own, `fragment::cluster`s |
//! | [`span`] | a row's run of pixels: start values and changes per pixel |
//! | [`scan`] | the stages joined: [`ScanConverter`], polygon in, spans out |
//! | [`parameters`] | which can be interpolated, and how: `parameters::projective` mappings, any `parameters::quad`, any values on a `parameters::polygon`, `parameters::subdivision`; what can be wrong with them, `parameters::error` |
//!
//! **Renderers**
//!
//! | module | what it does |
//! |---|---|
//! | [`color`] | linear light and sRGB |
//! | [`render`] | `render::depth` tests and `render::coarse_depth`; `render::counters` and the `render::stencil`; `render::band`s of rows; what targets hold for a `render::pixel`, and what shaders return, `render::paint`; the loops around a `render::shader`: `render::shader::blocks` to shade, each `render::shader::form`, how they `render::shader::draw`, several `render::shader::buffers` at once |
//! | `render::raster` | which loops a polygon takes, `render::raster::plan`; blocks against depths, `render::raster::test`; its runs, `render::raster::rows` |
//! | `render::parallel` | work on all processors |
//! | `render::canvas`, `render::target`, `render::framebuffer`, `render::supersample` | how shaders paint pixels; memory to draw to, borrowed or owned; pictures whose pixels are means of many samples |
//! | `render::faces`, `render::corners` | index lists; vertices projected once each |
//! | `render::bsp` | [`BspTree`]: `render::bsp::plane`s, the `render::bsp::partition`, how to `render::bsp::build` it |
//! | `render::stroke_style`, `render::geometry`, `render::lines` | what is drawn: polygons and meshes, lines and points, and how these look |
//! | `render::by_depth`, `render::statistics`, `render::front` | in which order, what is counted, by which methods |
//! | `render::mesh` | many faces at once, in `render::mesh::bins` |
//! | `render::strokes` | lines and points: each `render::strokes::segment` clipped, the polygons of `render::strokes::wide` ones |
//! | `render::z_buffer`, `render::query` | [`ZBufferRenderer`], and how much of what is not drawn would be seen |
//! | `render::painter` | [`PainterRenderer`], with each `render::painter::cut_line` |
//! | `render::scanline` | [`ScanlineRenderer`]: what is `render::scanline::visible`, the `render::scanline::active` faces, how rows are found and `render::scanline::draw`n |
//! | [`bake`] | textures baked from meshes in their (u, v) plane; `bake::dilate` continues the borders |
//! | `render::samples` | [`MultisampleRenderer`](render::MultisampleRenderer): several samples a pixel, at the places of the `render::samples::pattern`, in a `render::samples::frame`; the `render::samples::raster` says which are covered, of a `render::samples::small` triangle by its edges' functions, `render::samples::shade` tests them and stores what a `render::samples::shader` makes of them, for the `render::samples::renderer` |
//! | `render::occlusion` | [`OcclusionRenderer`](render::OcclusionRenderer): what is hidden, before it is drawn, by `render::occlusion::tiles` of pixels |
//! | `render::visibility` | [`VisibilityRenderer`](render::VisibilityRenderer): which face is seen at each pixel, at each of a pixel's samples, or in `render::visibility::layers` if several are wanted, and where on it, by the `render::visibility::weights` of its corners |
//! | `render::area` | [`AreaRenderer`](render::AreaRenderer): pixels covered in part, by exact area, in painter's order |
//! | `render::png_file` | PNG files, whole or row by row |
//!
//! **Pictures and models**
//!
//! | module | what it does |
//! |---|---|
//! | [`texture`] | pictures to sample: their `texture::limits`, `texture::error`s, and `texture::format`s, decoded by `texture::light`; the `texture::texels` of `texture::picture`s and `texture::file`s; `texture::wrap` finds those at a point, `texture::sample` the colour, by a `texture::cubic` too; the `texture::chain` of smaller pictures, in which each `texture::cutout` keeps what it covers, the `texture::level` that a pixel needs, `texture::ewa`, and `texture::minify`, which filters what it sees, `texture::block`s at once; textures are made by `texture::build`, of heights by `texture::bumps`, asked by `texture::look_up`, and returned by shaders as `texture::paint`; the `texture::environment` in all directions |
//! | [`tangent`] | which way the texels of a normal map point: tangents of meshes, and the frames that they are interpolated as |
//! | [`camera`] | a camera that sees the whole of an object, by the `camera::sphere` around it |
//! | `model` | models of any format: faces that share a `model::vertex`, each of a `model::material` with its `model::maps`, in lists of `model::faces`; `model::corners` as files have them, by points in `model::fans`, alike by `model::join`; `model::normals` that they lack; on which `model::hands` pictures are mirrored; faces with heights `model::dice`d, as large as a `model::dice::sight` sees them: polygons are `model::dice::cut` into triangles, which share the edges of a `model::dice::net` that begins with the `model::dice::base`, and are moved by `model::dice::heights`; `model::also`, warnings where there is no model |
//! | `obj` | OBJ and MTL files to models: `obj::limits`, `obj::error`s; `obj::lines`, `obj::notes` of what is left out, `obj::vertex_color`s and the `obj::geometry` of the text; bytes from `obj::file`s, `obj::warning`s, files for names by `obj::paths`; `obj::map_options` and `obj::mtl` files, `obj::materials`; and `obj::read`, which joins them |
//! | `formats` | models from files of any format within the `formats::limits`: `formats::stl`; what is `formats::found` in `formats::ply` and `formats::gltf` files, the last by their `formats::gltf::data` and `formats::gltf::looks` |
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
//!   arithmetic with the top-left rule: polygons that share an edge, and lie on opposite sides of it
//!   after rounding, touch each pixel along it exactly once.
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
//! and Moreton 1991, section 3.4).
//!
//! Where that matters there are other ways: parameters with a denominator of their own, as a slide projector's picture
//! has, projective texture coordinates for any quad, mean value coordinates for any values. The module [`parameters`]
//! leads from the question to the tool.
//!
//! # Shaders, and speed
//!
//! A shader is a closure from a [`Fragment`] to a colour ([`draw`](ZBufferRenderer::draw)), or from a
//! [`FragmentBlock`] of 16 fragments to theirs ([`draw_blocks`](ZBufferRenderer::draw_blocks)). The
//! second is for speed: its loop over the lanes becomes SIMD instructions, for the best level that the
//! machine has. For that a shader must be inlined: a closure is, and what it calls if that is small or
//! marked `#[inline(always)]`; a function that is given by its name is not. Keep table look-ups out of
//! that loop, in a second one: they stop the compiler from vectorising it. Meshes are best drawn as
//! such, as a [`Mesh`]: vertices are projected once, and all processors take part. None of this changes
//! a bit of the picture.
//!
//! The shader and the loop around it are all that a program compiles of a renderer; the rest is compiled
//! in this library, once. So it pays to let this library be optimised in programs that are not
//! themselves:
//!
//! ```toml
//! [profile.dev.package."*"]
//! opt-level = 3
//! ```
//!
//! # Pictures too large for memory
//!
//! [`ScanlineRenderer::stream`] draws the same pictures from top to bottom and hands each row over when
//! it is finished, to a `render::PngFile` for example. It shades each visible pixel once, and it has
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
//! - `parallel` (default): meshes are drawn by all processors, through `rayon`. The picture is the
//!   same without.
//! - `png` (default): PNG files, from framebuffers or row by row, and textures from them.
//! - `obj` (default): OBJ and MTL files. Needs `png`.
//! - `stl`, `ply`, `gltf`: models in these formats, by the module `formats`. `ply` needs `png`, and `gltf` needs
//!   `image`, for the pictures of their files.
//! - `model`: what the formats share; it comes with any of them.
//! - `image`: textures in the other formats of the `image` crate, and framebuffers to its pictures. It
//!   takes longer to compile than all the rest.
//! - `tiff`, `webp`: textures in these formats as well.
//! - `fallback`: the code without SIMD is compiled for machines that have some as well, to test and to
//!   time it. Where there is no SIMD it is in use without the feature.
//!
//! # Sources
//!
//! - P. Heckbert and H. Moreton, "Interpolation for Polygon Texture Mapping and Shading", in State
//!   of the Art in Computer Graphics, Springer 1991.
//! - P. Heckbert, "Generic Convex Polygon Scan Conversion and Clipping", Graphics Gems, 1990.
//! - K.-L. Low, "Perspective-Correct Interpolation", 2002.
//! - K. Hormann and M. Floater, "Mean Value Coordinates for Arbitrary Planar Polygons", ACM Transactions on
//!   Graphics 25(4), 2006.
//! - H. Fuchs, Z. Kedem and B. Naylor, "On Visible Surface Generation by A Priori Tree Structures",
//!   SIGGRAPH 1980; M. Newell, R. Newell and T. Sancha, "A Solution to the Hidden Surface Problem",
//!   ACM 1972: the painter's renderer.

#![cfg_attr(docsrs, feature(doc_cfg))]

mod round;
mod simd;
mod scalar;
mod angle;
pub mod vertex;
mod vertices;
pub mod outline;
pub mod viewport;
pub mod view_volume;
pub mod clip;
pub mod subpixel;
pub mod project;
pub mod coverage;
mod window;
mod settings;
mod surface;
mod primitive;
pub mod parameter_matrix;
pub mod fragment;
pub mod span;
pub mod scan;
pub mod parameters;
pub mod color;
pub mod render;
pub mod bake;
pub mod texture;
pub mod tangent;
pub mod camera;
#[cfg(feature = "model")]
pub mod model;
#[cfg(feature = "obj")]
pub mod obj;
#[cfg(any(feature = "stl", feature = "ply", feature = "gltf"))]
pub mod formats;
#[cfg(test)]
mod test_rng;

#[doc(no_inline)]
pub use fearless_simd::Level;
pub use glam;

pub use self::camera::Camera;
pub use self::coverage::{CoverageRule, FillRule, OutsidePolygon};
pub use self::fragment::{Footprint, FootprintBlock, Fragment, FragmentBlock};
#[cfg(feature = "model")]
pub use self::model::Model;
pub use self::outline::Outline;
pub use self::parameter_matrix::ParameterMatrix;
pub use self::render::{
    BspTree, DepthTest, Framebuffer, Lines, Mesh, PainterRenderer, Points, ScanlineRenderer,
    Target, TargetError, ZBufferRenderer,
};
pub use self::scan::{ScanConverter, Surface};
pub use self::settings::{Cull, DepthBias, DepthMode, FrontFace, Settings};
pub use self::span::Span;
pub use self::texture::Texture;
pub use self::vertex::{Interpolation, Parameter, Vertex};
pub use self::view_volume::{ClipPlane, ClipSpace};
pub use self::viewport::{Rect, SizeError, Viewport};

#[cfg(feature = "image")]
pub use image;

/// The README's code, compiled and run.
#[cfg(all(doctest, feature = "png"))]
#[doc = include_str!("../README.md")]
struct Readme;
