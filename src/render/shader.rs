//! From visible blocks to colours: the loops around a shader.
//!
//! - `render::shader::blocks` says what there is to shade;
//! - a shader has one of several `render::shader::form`s;
//! - `render::shader::draw` is the loops;
//! - `render::shader::buffers` is for shaders of several buffers, which take the same loops.
//!
//! This is all of a renderer that knows the shader's type, the colours' type and the number of
//! parameters, so it is all that is compiled with a user's program, once for each SIMD level. Everything
//! before it is compiled once, in the library. The two meet at [`ShadeBlocks`], behind `dyn`: a call for
//! the blocks of some rows, not for each, so that its cost is small beside the pixels'.

mod blocks;
mod form;
mod draw;
mod buffers;

pub(crate) use self::blocks::{
    BandDepths, MOST_SAMPLES, PARTS, PartBlock, PartBlocks, Patch, SampleBlock, SampleBlocks,
    ShadeBlocks, ShadeOnThreads, ShortRuns, WholeBlocks,
};
pub(crate) use self::buffers::OnBuffers;
pub(crate) use self::draw::{DepthOnly, NEST, Painter, halves_at, rarely};
pub(crate) use crate::render::pixel::choose;

pub(crate) use self::form::{
    Aligned, Alone, BlockFunction, FragmentFunction, PerBlock, PerFragment, Shader, Shared,
};
