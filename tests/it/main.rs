//! The tests of the library through its public interface: one crate with a module for each subject,
//! so that what the tests share is compiled once.
//!
//! `cargo test --test it coverage::` runs the tests of one module.

mod common;

mod oracle;

mod coverage;
mod contours;
mod meshes;
mod same_everywhere;
mod clipping;
mod parting;
mod parameters;
mod clusters;
mod projective;
mod polygon_values;
mod subdivision;
mod far_outside;
mod stages;
mod sides;
mod depth_bias;
mod lines;
mod conservative;
mod bake;
mod any_input;
mod regressions;
mod mesa;
#[cfg(feature = "image")]
mod golden;

mod z_buffer;
mod buffers;
mod many_faces;
mod scanline;
mod painter;
mod three_renderers;
mod front;
mod statistics;
mod visibility;
mod occlusion;
mod samples;
mod area;
mod blending;

mod texture;
mod texture_filters;
mod tangents;
#[cfg(feature = "obj")]
mod displacement;
mod cutouts;
mod supersampling;
mod environments;

mod house;
mod api;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "obj")]
mod looks;
#[cfg(feature = "obj")]
mod other_files;
#[cfg(all(feature = "obj", feature = "stl", feature = "ply", feature = "gltf"))]
mod formats;
#[cfg(feature = "obj")]
mod examples;
