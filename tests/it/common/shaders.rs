//! Shaders whose types tell what they return, but not which they are.
//!
//! The loops around a shader are compiled for its type, once for each SIMD level, and that takes most of the
//! time that the tests take to compile. Here they are the same for all shaders with so many parameters and such a
//! result. What comes out is the same to the bit; the loops that shaders are inlined in have the tests that pass
//! them as they are, `same_everywhere`, `many_faces`, `tests/same_bits` and some of `z_buffer` among them.

use polyscan::fragment::LANES;
use polyscan::{Fragment, FragmentBlock};

type Shader<'s, R, const N: usize> = Box<dyn Fn(&Fragment<'_, N>) -> R + Sync + 's>;
type ShaderMut<'s, R, const N: usize> = Box<dyn FnMut(&Fragment<'_, N>) -> R + 's>;
type BlockShader<'s, C, const N: usize> =
    Box<dyn Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync + 's>;
type BlockShaderMut<'s, C, const N: usize> =
    Box<dyn FnMut(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + 's>;

/// A shader of fragments.
pub(crate) fn dynamic<'s, R, const N: usize>(
    shader: impl Fn(&Fragment<'_, N>) -> R + Sync + 's,
) -> Shader<'s, R, N> {
    Box::new(shader)
}

/// A shader of fragments on one thread, which changes what it captures.
pub(crate) fn dynamic_mut<'s, R, const N: usize>(
    shader: impl FnMut(&Fragment<'_, N>) -> R + 's,
) -> ShaderMut<'s, R, N> {
    Box::new(shader)
}

/// A shader of blocks.
pub(crate) fn dynamic_blocks<'s, C, const N: usize>(
    shader: impl Fn(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + Sync + 's,
) -> BlockShader<'s, C, N> {
    Box::new(shader)
}

/// A shader of blocks on one thread, which changes what it captures.
pub(crate) fn dynamic_blocks_mut<'s, C, const N: usize>(
    shader: impl FnMut(&mut FragmentBlock<'_, N>, &mut [C; LANES]) + 's,
) -> BlockShaderMut<'s, C, N> {
    Box::new(shader)
}
