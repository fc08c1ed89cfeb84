//! How the parameters of a polygon run over the screen.
//!
//! Clipped vertices come in; for every run of pixels that the [edge table](crate::coverage) finds, the
//! surface gives the values of (z, s_1 .. s_n, s_{n+1}) at one pixel and the change per pixel.
//!
//! What is affine on the polygon (always so on triangles) is one plane over the screen
//! (`surface::plane`). What is not, such as arbitrary colours at the corners of a quad, is interpolated
//! along the two edges that bound the run and then across it (`surface::mixed`). `surface::triangle`
//! finds the planes of a triangle, or of eight at once in a `surface::batch`; `surface::polygon` those of
//! any polygon; those of lines and points are in
//! `surface::line`. What all parameters have in common is the `surface::base`, and `surface::rows` has
//! the values along runs.

pub(crate) mod plane;
pub(crate) mod base;
pub(crate) mod mixed;
pub(crate) mod rows;
pub(crate) mod triangle;
pub(crate) mod batch;
pub(crate) mod polygon;
pub(crate) mod line;
