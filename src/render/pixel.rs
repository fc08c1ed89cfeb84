//! What a target holds for each pixel: one value, or several in buffers of their own.

use fearless_simd::{Simd, SimdMask, mask32x8};

use crate::fragment::LANES;
use crate::fragment::block::HALF_BLOCK;
use crate::simd::has_mask_registers;

/// The bits of half a block's lanes.
const HALF: u32 = (1 << HALF_BLOCK) - 1;

/// What a target holds for each pixel: a value of any type that is `Copy`, or several values in separate
/// [`Buffers`].
///
/// | pixels of | in memory | 16 of them, as a shader of blocks has them |
/// |---|---|---|
/// | `C: Copy` | `&mut [C]` | `[C; 16]` |
/// | `Buffers<(A, B)>`, up to six, all `Copy + Send` | `(&mut [A], &mut [B])` | `([A; 16], [B; 16])` |
pub trait Pixel: Sized {
    /// The values of [`LANES`] pixels.
    type Block;

    /// The borrowed values of a target's pixels, row by row from the top.
    type Memory<'a>
    where
        Self: 'a;

    /// The same memory, for a shorter time.
    fn reborrow<'m>(memory: &'m mut Self::Memory<'_>) -> Self::Memory<'m>;

    /// Gives all pixels one value.
    fn fill(memory: &mut Self::Memory<'_>, value: Self);
}

impl<C: Copy> Pixel for C {
    type Block = [C; LANES];
    type Memory<'a>
        = &'a mut [C]
    where
        C: 'a;

    fn reborrow<'m>(memory: &'m mut &mut [C]) -> &'m mut [C] {
        memory
    }

    fn fill(memory: &mut &mut [C], value: C) {
        memory.fill(value);
    }
}

/// The values of a pixel whose target has a buffer for each of them, such as colour, normal and id: what
/// Saito and Takahashi ("Comprehensible Rendering of 3-D Shapes", SIGGRAPH 1990) call G-buffers, all drawn
/// in one pass. Such a target is made by [`Target::of_buffers`](crate::Target::of_buffers).
///
/// A shader returns a tuple with something to [`Paint`](crate::render::Paint) for each buffer: a value, an
/// `Option` of one, where `None` leaves the buffer as it is there, or a colour to be blended. An `Option` of
/// the tuple may be `None` to discard the fragment as a whole. A shader of blocks is given a tuple of arrays.
///
/// ```
/// use glam::{Vec3, vec3, vec4};
/// use polyscan::{Mesh, Target, Vertex, ZBufferRenderer};
///
/// let (mut heights, mut normals, mut ids) = ([0.0; 12], [Vec3::ZERO; 12], [u32::MAX; 12]);
/// let mut depths = [1.0; 12];
/// let mut target =
///     Target::of_buffers(4, (&mut heights[..], &mut normals[..], &mut ids[..]), &mut depths)?;
/// let vertices = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [y]));
/// let mesh = Mesh::new(&vertices, [[0, 1, 2]]);
///
/// let mut renderer = ZBufferRenderer::new(target.viewport());
/// renderer.draw(&mut target, mesh, |fragment| {
///     let [height] = fragment.params;
///     (height, (height < 0.0).then_some(Vec3::Z), fragment.face)
/// });
/// // The same, 16 pixels at a time, and every normal.
/// renderer.depth_test = polyscan::DepthTest::NearerOrEqual;
/// renderer.draw_blocks(&mut target, mesh, |block, (heights, normals, ids)| {
///     *heights = block.params[0];
///     *normals = [Vec3::Y; 16];
///     *ids = [block.face; 16];
/// });
/// assert_eq!(ids[4..8], [0, 0, u32::MAX, u32::MAX]);
/// assert_eq!(normals[4..8], [Vec3::Y, Vec3::Y, Vec3::ZERO, Vec3::ZERO]);
/// # Ok::<(), polyscan::TargetError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Buffers<B>(pub B);

impl<B: BufferSet> Pixel for Buffers<B> {
    type Block = B::Block;
    type Memory<'a>
        = B::Slices<'a>
    where
        B: 'a;

    fn reborrow<'m>(memory: &'m mut B::Slices<'_>) -> B::Slices<'m> {
        B::split(memory, usize::MAX).0
    }

    fn fill(memory: &mut B::Slices<'_>, value: Self) {
        B::fill(memory, value.0);
    }
}

/// The values of a pixel in several buffers: a tuple of up to six, `Copy + Send` each. Not named outside of
/// this crate.
pub trait BufferSet: Sized {
    /// [`LANES`] values of each buffer.
    type Block;

    /// The buffers.
    type Slices<'a>: Send
    where
        Self: 'a;

    /// The values of two halves of a block. Those of pixels that are not there mean nothing.
    fn load(slices: &Self::Slices<'_>, at: [usize; 2]) -> Self::Block;

    /// Stores the values of some lanes.
    fn store<S: Simd>(
        simd: S,
        slices: &mut Self::Slices<'_>,
        at: [usize; 2],
        block: &Self::Block,
        lanes: u32,
    );

    /// The values of a lane.
    fn get(block: &Self::Block, lane: usize) -> Self;

    /// Replaces the values of a lane.
    fn set(block: &mut Self::Block, lane: usize, values: Self);

    /// The pixels before one, and those from it on; all and none if there are not so many.
    fn split<'m>(
        slices: &'m mut Self::Slices<'_>,
        pixel: usize,
    ) -> (Self::Slices<'m>, Self::Slices<'m>);

    /// Gives all pixels the same values.
    fn fill(slices: &mut Self::Slices<'_>, values: Self);
}

/// Memory that can be one of several buffers. Not named outside of this crate.
pub trait Buffer<'a> {
    /// The type of one value.
    type Value: Copy + Send;

    /// The values.
    fn slice(self) -> &'a mut [Self::Value];
}

impl<'a, A: Copy + Send> Buffer<'a> for &'a mut [A] {
    type Value = A;

    fn slice(self) -> &'a mut [A] {
        self
    }
}

impl<'a, A: Copy + Send> Buffer<'a> for &'a mut Vec<A> {
    type Value = A;

    fn slice(self) -> &'a mut [A] {
        self
    }
}

/// A tuple of memory. Not named outside of this crate.
pub trait BufferList<'a> {
    /// The values of a pixel.
    type Set: BufferSet + 'a;

    /// The lengths of the buffers, to be checked.
    type Lengths: AsRef<[usize]>;

    /// The lengths, and the buffers.
    fn slices(self) -> (Self::Lengths, <Self::Set as BufferSet>::Slices<'a>);
}

macro_rules! buffers {
    ($count:literal: $($value:ident $buffer:ident $i:tt),+) => {
        impl<$($value: Copy + Send),+> BufferSet for ($($value,)+) {
            type Block = ($([$value; LANES],)+);
            type Slices<'a>
                = ($(&'a mut [$value],)+)
            where
                Self: 'a;

            #[inline(always)]
            fn load(slices: &Self::Slices<'_>, at: [usize; 2]) -> Self::Block {
                ($(load(slices.$i, at),)+)
            }

            #[inline(always)]
            fn store<S: Simd>(
                simd: S,
                slices: &mut Self::Slices<'_>,
                at: [usize; 2],
                block: &Self::Block,
                lanes: u32,
            ) {
                $(store(simd, slices.$i, at, &block.$i, lanes);)+
            }

            #[inline(always)]
            fn get(block: &Self::Block, lane: usize) -> Self {
                ($(block.$i[lane % LANES],)+)
            }

            #[inline(always)]
            fn set(block: &mut Self::Block, lane: usize, values: Self) {
                $(block.$i[lane % LANES] = values.$i;)+
            }

            fn split<'m>(
                slices: &'m mut Self::Slices<'_>,
                pixel: usize,
            ) -> (Self::Slices<'m>, Self::Slices<'m>) {
                let parts = ($({
                    let middle = pixel.min(slices.$i.len());
                    slices.$i.split_at_mut(middle)
                },)+);
                (($(parts.$i.0,)+), ($(parts.$i.1,)+))
            }

            fn fill(slices: &mut Self::Slices<'_>, values: Self) {
                $(slices.$i.fill(values.$i);)+
            }
        }

        impl<'a, $($buffer: Buffer<'a, Value: 'a>),+> BufferList<'a> for ($($buffer,)+) {
            type Set = ($($buffer::Value,)+);
            type Lengths = [usize; $count];

            fn slices(self) -> ([usize; $count], <Self::Set as BufferSet>::Slices<'a>) {
                let slices = ($(self.$i.slice(),)+);
                ([$(slices.$i.len()),+], slices)
            }
        }
    };
}

buffers!(1: A X 0);
buffers!(2: A X 0, B Y 1);
buffers!(3: A X 0, B Y 1, C Z 2);
buffers!(4: A X 0, B Y 1, C Z 2, D V 3);
buffers!(5: A X 0, B Y 1, C Z 2, D V 3, E W 4);
buffers!(6: A X 0, B Y 1, C Z 2, D V 3, E W 4, F U 5);

/// The values of a block's pixels.
#[inline(always)]
fn load<A: Copy>(values: &[A], at: [usize; 2]) -> [A; LANES] {
    let half = |at: usize| values.get(at..).and_then(<[A]>::first_chunk::<HALF_BLOCK>);
    if let (Some(lower), Some(upper)) = (half(at[0]), half(at[1])) {
        return std::array::from_fn(
            #[inline(always)]
            |lane| if lane < HALF_BLOCK { lower[lane] } else { upper[lane - HALF_BLOCK] },
        );
    }
    load_at_end(values, at)
}

/// The same one by one, where a half reaches over the ends. There is a first pixel, or nothing is drawn.
#[cold]
fn load_at_end<A: Copy>(values: &[A], at: [usize; 2]) -> [A; LANES] {
    std::array::from_fn(|lane| {
        let pixel = at[lane / HALF_BLOCK].wrapping_add(lane % HALF_BLOCK);
        values.get(pixel).copied().unwrap_or(values[0])
    })
}

/// Stores the values of some lanes. The halves may overlap, but not in pixels that both have.
#[inline(always)]
fn store<S: Simd, A: Copy>(
    simd: S,
    values: &mut [A],
    at: [usize; 2],
    block: &[A; LANES],
    lanes: u32,
) {
    for (half, new) in block.as_chunks::<HALF_BLOCK>().0.iter().enumerate() {
        let lanes = lanes >> (half * HALF_BLOCK) & HALF;
        match values.get_mut(at[half]..).and_then(<[A]>::first_chunk_mut::<HALF_BLOCK>) {
            Some(old) if lanes == HALF => *old = *new,
            Some(old) => choose(simd, lanes, new, old),
            None => store_at_end(values, at[half], new, lanes),
        }
    }
}

/// Replaces the values of the lanes that were drawn, in half a block.
#[inline(always)]
pub(crate) fn choose<S: Simd, C: Copy>(
    simd: S,
    drawn: u32,
    new: &[C],
    colors: &mut [C; HALF_BLOCK],
) {
    // A loop over three arrays becomes one vector instruction that chooses.
    let mask = mask32x8::from_bitmask(simd, (drawn & HALF).into());
    let mask = <[i32; HALF_BLOCK]>::from(mask);
    let old = *colors;
    // Of a choice between what is there and what is stored there, the compiler makes a masked store. Those of
    // AVX2 take some processors twenty cycles; of a place that it cannot know to be the same it makes none.
    let has_masks = has_mask_registers(simd.level());
    let colors = if has_masks { colors } else { std::hint::black_box(colors) };
    for lane in 0..HALF_BLOCK {
        colors[lane] = if mask[lane] != 0 { new[lane] } else { old[lane] };
    }
}

#[cold]
fn store_at_end<A: Copy>(values: &mut [A], at: usize, new: &[A; HALF_BLOCK], lanes: u32) {
    for (lane, new) in new.iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 != 0) {
        if let Some(value) = values.get_mut(at.wrapping_add(lane)) {
            *value = *new;
        }
    }
}
