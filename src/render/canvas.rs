//! How shaders paint pixels: those of one value, and those of several [`Buffers`].

use fearless_simd::Simd;

use crate::render::paint::Paint;
use crate::render::pixel::{BufferSet, Buffers, Pixel};
use crate::render::shader::{
    BlockFunction, FragmentFunction, OnBuffers, Painter, PerBlock, PerFragment, ShadeBlocks,
    ShadeOnThreads,
};

/// Pixels that shaders paint. Each function calls `draw` with what paints some by a shader that is called for
/// each fragment, or for blocks; on threads that share it, or on one alone. `width` is that of a row.
pub(crate) trait Canvas: Pixel {
    fn fragments_on_threads<S, R, F, const N: usize>(
        simd: S,
        memory: (Self::Memory<'_>, usize),
        shader: F,
        draw: &mut dyn FnMut(&mut dyn ShadeOnThreads),
    ) where
        Self: Send,
        S: Simd + Send,
        R: Paint<Self>,
        F: FragmentFunction<R, N> + Copy + Send;

    fn blocks_on_threads<S, F, const N: usize>(
        simd: S,
        memory: (Self::Memory<'_>, usize),
        shader: F,
        draw: &mut dyn FnMut(&mut dyn ShadeOnThreads),
    ) where
        Self: Send,
        S: Simd + Send,
        F: BlockFunction<Self::Block, N> + Copy + Send;

    fn fragments_on_one_thread<S, R, F, const N: usize>(
        simd: S,
        memory: (Self::Memory<'_>, usize),
        shader: F,
        draw: &mut dyn FnMut(&mut dyn ShadeBlocks),
    ) where
        S: Simd,
        R: Paint<Self>,
        F: FragmentFunction<R, N>;

    fn blocks_on_one_thread<S, F, const N: usize>(
        simd: S,
        memory: (Self::Memory<'_>, usize),
        shader: F,
        draw: &mut dyn FnMut(&mut dyn ShadeBlocks),
    ) where
        S: Simd,
        F: BlockFunction<Self::Block, N>;
}

macro_rules! canvas {
    ($simd:ident, $memory:ident, $shader:ident => $painter:expr) => {
        fn fragments_on_threads<S, R, F, const N: usize>(
            $simd: S,
            $memory: (Self::Memory<'_>, usize),
            shader: F,
            draw: &mut dyn FnMut(&mut dyn ShadeOnThreads),
        ) where
            Self: Send,
            S: Simd + Send,
            R: Paint<Self>,
            F: FragmentFunction<R, N> + Copy + Send,
        {
            let $shader = PerFragment::new(shader);
            draw(&mut $painter);
        }

        fn blocks_on_threads<S, F, const N: usize>(
            $simd: S,
            $memory: (Self::Memory<'_>, usize),
            shader: F,
            draw: &mut dyn FnMut(&mut dyn ShadeOnThreads),
        ) where
            Self: Send,
            S: Simd + Send,
            F: BlockFunction<Self::Block, N> + Copy + Send,
        {
            let $shader = PerBlock(shader);
            draw(&mut $painter);
        }

        fn fragments_on_one_thread<S, R, F, const N: usize>(
            $simd: S,
            $memory: (Self::Memory<'_>, usize),
            shader: F,
            draw: &mut dyn FnMut(&mut dyn ShadeBlocks),
        ) where
            S: Simd,
            R: Paint<Self>,
            F: FragmentFunction<R, N>,
        {
            let $shader = PerFragment::new(shader);
            draw(&mut $painter);
        }

        fn blocks_on_one_thread<S, F, const N: usize>(
            $simd: S,
            $memory: (Self::Memory<'_>, usize),
            shader: F,
            draw: &mut dyn FnMut(&mut dyn ShadeBlocks),
        ) where
            S: Simd,
            F: BlockFunction<Self::Block, N>,
        {
            let $shader = PerBlock(shader);
            draw(&mut $painter);
        }
    };
}

impl<C: Copy> Canvas for C {
    canvas!(simd, memory, shader => Painter::<_, C, _, N> {
        simd,
        colors: memory.0,
        pixels_before: 0,
        shader,
    });
}

impl<B: BufferSet> Canvas for Buffers<B> {
    canvas!(simd, memory, shader => Painter::<_, (), _, N> {
        simd,
        colors: &mut [(); usize::MAX],
        pixels_before: 0,
        shader: OnBuffers::<S, B, _> {
            simd,
            slices: memory.0,
            width: memory.1,
            pixels_before: 0,
            shader,
        },
    });
}
