//! Which parameters can be interpolated, and how: from the question to the tool.
//!
//! A parameter is a number that a polygon has at each vertex, and wants at each pixel. How it is to be interpolated
//! depends on one question: of what is it an affine function? (The paper is Heckbert and Moreton, "Interpolation for
//! Polygon Texture Mapping and Shading", 1991.)
//!
//! | what the parameter is | the tool | the paper |
//! |---|---|---|
//! | anything on a triangle; on a flat polygon, what is affine on it: texture coordinates, positions, depth along the line of sight | nothing to do: [`Interpolation::Perspective`] is the default, exact to 1e-5 | 3.5 |
//! | affine after another projection: a slide projector's picture, the place in a map of shadows | a cluster with its own w: [`Fragment::divided`], [`FragmentBlock::divided`] | 3.4 |
//! | affine on the object before a perspective transformation that models it, or after it | the same, for one of the two | 3.4 |
//! | texture coordinates of a quad that are no parallelogram | [`quad`], and a cluster | 3.4 |
//! | any values at the corners of a flat polygon: colours, weights | [`PolygonValues`]; by default, along edges and rows | 3.4 |
//! | a picture to be moved on the plane, without any 3-D | [`Projective`] | 3 |
//! | z/w, and whatever else is affine on the screen | [`Interpolation::Linear`] | 2.1 |
//! | the same all over the polygon | [`Interpolation::Flat`] | |
//! | none of these: a unit normal, a reflection, a light's strength | interpolate what it is made of, and compute it in the shader | |
//! | affine, but for the looks of the machines of 1995 | [`Interpolation::Linear`], with [`Subdivision`] or without | 2.1 |
//!
//! # Affine on the object
//!
//! Then it is rational linear on the screen, and the quotient of r/w and 1/w, which are linear there. It costs a
//! reciprocal a pixel for all parameters, and none if all w are equal. Whether values at four vertices or more are
//! affine is found out when the polygon is set up.
//!
//! # Affine on something else: clusters
//!
//! A homogeneous vector (r_1 q, r_2 q, q) is affine on the object wherever a projection makes r of it. So it is given as
//! ordinary parameters, which are clipped and interpolated as all others, and the shader asks for the quotients:
//! [`Fragment::divided`] and its like take the numbers of the numerators, as many as share a denominator, and of the
//! denominator. They divide what is linear on the screen, in f64, so 1/w is not divided by first; the cost is a
//! reciprocal for each call. Where q is not positive there is nothing: behind a projector is no light.
//!
//! A slide projector, whose clip space is the cluster:
//!
//! ```
//! use polyscan::glam::{Mat4, Vec3, Vec4, vec2};
//! use polyscan::texture::Texture;
//! use polyscan::{Framebuffer, Mesh, Vertex, ZBufferRenderer};
//!
//! fn draw(
//!     frame: &mut Framebuffer<Vec4>,
//!     (world, faces): (&[Vec3], &[[u32; 4]]),
//!     (camera, projector): (Mat4, Mat4),
//!     slide: &Texture,
//! ) {
//!     let vertices: Vec<Vertex<4>> = world
//!         .iter()
//!         .map(|place| Vertex::new(camera * place.extend(1.0), projector * place.extend(1.0)))
//!         .collect();
//!     let mut renderer = ZBufferRenderer::new(frame.viewport());
//!     renderer.draw(frame, Mesh::new(&vertices, faces), |fragment| {
//!         // x and y over w, from -1 to 1 and upwards, with their derivatives.
//!         let Some(mut at) = fragment.divided_footprint([0, 1], 3) else { return Vec4::W };
//!         let half = vec2(0.5, -0.5);
//!         at.uv = at.uv * half + 0.5;
//!         (at.dx, at.dy) = (at.dx * half, at.dy * half);
//!         slide.sample_footprint(&at)
//!     });
//! }
//! ```
//!
//! A map of shadows is a depth pass as the light sees it, whose depths are compared with z/w of the same cluster. The
//! map's polygons are moved away by a [`DepthBias`](crate::DepthBias), so that no surface throws a shadow on itself; a
//! filter averages several comparisons, not depths (Reeves, Salesin and Cook, "Rendering Antialiased Shadows with Depth
//! Maps", 1987). The example `projector` has one.
//!
//! ```
//! use polyscan::glam::Vec2;
//! use polyscan::{DepthBias, Fragment, Framebuffer, Mesh, Vertex, ZBufferRenderer};
//!
//! /// What a light sees, as depth alone.
//! fn seen_from_light(map: &mut Framebuffer<()>, in_light_space: &[Vertex<0>], faces: &[[u32; 4]]) {
//!     let mut renderer = ZBufferRenderer::new(map.viewport());
//!     renderer.settings.depth_bias = DepthBias { constant: 2e-5, slope: 2.5 };
//!     renderer.draw_depth(map, Mesh::new(in_light_space, faces));
//! }
//!
//! /// The part of 3 x 3 comparisons that find nothing nearer to the light. Parameters 0 to 3 are its clip space.
//! fn lit(fragment: &Fragment<'_, 4>, map: &Framebuffer<()>) -> f32 {
//!     let Some([x, y, z]) = fragment.divided([0, 1, 2], 3) else { return 0.0 };
//!     let size = Vec2::new(map.width() as f32, map.height() as f32);
//!     let texel = (Vec2::new(x, -y) * 0.5 + 0.5) * size;
//!     let one = |i: i32| {
//!         let at = (texel + Vec2::new((i % 3 - 1) as f32, (i / 3 - 1) as f32)).floor();
//!         // A texel that is not in the map is one where no light falls.
//!         let seen = if at.min_element() < 0.0 { None } else { map.pixel(at.x as u32, at.y as u32) };
//!         seen.is_some_and(|(_, depth)| z <= depth)
//!     };
//!     (0..9).filter(|&i| one(i)).count() as f32 / 9.0
//! }
//! ```
//!
//! A perspective transformation may model, too: a box that narrows towards its end, as matrix `taper`. The texture is
//! affine on the box before it, positions in the world are affine after it. The clip-space position takes the homogeneous
//! point as it is; one of both kinds of parameters has to be a cluster.
//!
//! ```
//! use polyscan::glam::{Mat4, Vec2, Vec3, Vec4};
//! use polyscan::{Fragment, Vertex, record};
//!
//! record! {
//!     struct Surface {
//!         world: Vec4,
//!         uv: Vec2,
//!     }
//! }
//!
//! fn vertex(camera: Mat4, taper: Mat4, place: Vec3, uv: Vec2) -> Vertex<{ Surface::LEN }> {
//!     let world = taper * place.extend(1.0);
//!     Vertex::new(camera * world, Surface { world, uv })
//! }
//!
//! fn world(fragment: &Fragment<'_, { Surface::LEN }>) -> Option<Vec3> {
//!     fragment.divided([0, 1, 2], 3).map(Vec3::from)
//! }
//! ```
//!
//! # Four texture coordinates of a quad
//!
//! If they are not a parallelogram where the quad is one, no plane has them. Two triangles show a seam along the diagonal.
//! [`quad`] finds the one projective mapping that takes the corners to them, as homogeneous coordinates for a cluster:
//! straight lines stay straight, and nothing depends on how the quad is turned. Where the quad folds over it is an error.
//!
//! # Any values at corners
//!
//! By default values that are not affine are interpolated along the polygon's edges, and across the rows between them, as
//! in Heckbert's scan converter. That is as fast as all else, and stays between the corners' values; it depends on how
//! the polygon is turned on the screen, which shows when it moves. Triangles do not depend on that, but have seams.
//! [`PolygonValues`] has neither: mean value coordinates, computed in the shader from two parameters.
//!
//! # Pictures
//!
//! A [`Projective`] mapping follows from four points and where they go, or from more, by least squares; it makes a polygon
//! of a picture, to be drawn by any filter. The example `warp` straightens a photographed page.
//!
//! # Not affine at all
//!
//! A unit normal is not affine: the mean of two is shorter. Interpolate the normal, and normalize it in the shader; the
//! same holds for light and reflections, which are computed from positions, normals and texture coordinates.
//!
//! [`Fragment::divided`]: crate::Fragment::divided
//! [`FragmentBlock::divided`]: crate::FragmentBlock::divided
//! [`Interpolation::Perspective`]: crate::Interpolation::Perspective
//! [`Interpolation::Linear`]: crate::Interpolation::Linear
//! [`Interpolation::Flat`]: crate::Interpolation::Flat

mod error;
mod projective;
mod quad;
mod polygon;
mod subdivision;

pub use self::error::ParameterError;
pub use self::polygon::PolygonValues;
pub use self::projective::Projective;
pub use self::quad::quad;
pub use self::subdivision::Subdivision;
