//! The compiled half of polyscan for Python.
//!
//! What flows in are numpy arrays whose shapes and types the package's Python half has checked; what flows out are
//! numpy arrays. `threads` runs work beside the interpreter; `positions` brings vertices to clip space, `polygons`
//! has the faces; `visibility` finds what is seen at each pixel, `baking` what is at each texel, `interpolate` the
//! attributes there; `texture` samples pictures, and `picture` draws whole models.

use pyo3::prelude::*;

mod threads;
mod positions;
mod polygons;
mod visibility;
mod baking;
mod interpolate;
mod texture;
mod picture;

/// See the package's documentation: nothing of this is for its users.
#[pymodule]
mod _polyscan {
    #[pymodule_export]
    use crate::baking::bake_weights;
    #[pymodule_export]
    use crate::interpolate::interpolate;
    #[pymodule_export]
    use crate::picture::{render_file, render_mesh};
    #[pymodule_export]
    use crate::texture::Texture;
    #[pymodule_export]
    use crate::visibility::{rasterize, sample_places};
}
