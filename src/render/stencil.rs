//! The stencil: eight bits a pixel that say where fragments are drawn, and that drawing changes.

use crate::fragment::LANES;
use crate::fragment::block::HALF_BLOCK;

/// What the stencil, a byte for each pixel of a [target that has one](crate::Target::with_stencil), does with
/// fragments, and they with it. As in OpenGL, Vulkan and wgpu.
///
/// A fragment passes if `reference & read_mask`, on the left, compares with `stored & read_mask`, on the right,
/// as the side's [`test`](StencilFace::test) says. Then it is compared by depth. What becomes of the stored
/// byte depends on both: `fail` if it does not pass here, else `depth_fail` or `pass`. Only the bits of
/// `write_mask` are changed. All this is before the shader is called: if that discards a fragment, which must
/// have passed, its byte stays as it was.
///
/// ```
/// use glam::vec4;
/// use polyscan::render::{RenderTarget, Stencil};
/// use polyscan::{Framebuffer, Vertex, ZBufferRenderer};
///
/// let square = |size: f32| [(-size, -size), (size, -size), (size, size), (-size, size)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// let mut frame = Framebuffer::new(4, 4, '.')?;
/// let mut stencil = [0; 16];
/// let mut target = frame.target().with_stencil(&mut stencil)?;
/// let mut renderer = ZBufferRenderer::new(target.viewport());
/// renderer.depth_test = polyscan::DepthTest::Always;
/// // A window is marked, and a picture drawn where it is not.
/// renderer.stencil = Some(Stencil::mark(1));
/// renderer.draw(&mut target, &square(0.5), |_| 'o');
/// renderer.stencil = Some(Stencil::unless(1));
/// renderer.draw(&mut target, &square(1.0), |_| '#');
/// let rows: Vec<String> = frame.color().chunks(4).map(|row| row.iter().collect()).collect();
/// assert_eq!(rows, ["####", "#oo#", "#oo#", "####"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stencil {
    /// What is compared with the stored bytes, and stored by [`StencilOp::Replace`].
    pub reference: u8,
    /// The bits that are compared.
    pub read_mask: u8,
    /// The bits that may change.
    pub write_mask: u8,
    /// What happens where a polygon's front is seen, by [`Settings::front_face`](crate::Settings::front_face),
    /// and for lines and points.
    pub front: StencilFace,
    /// What happens where its back is seen.
    pub back: StencilFace,
}

/// What the stencil does with the fragments of one side of polygons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StencilFace {
    /// Which fragments pass.
    pub test: StencilTest,
    /// What becomes of the stored byte where one does not pass.
    pub fail: StencilOp,
    /// Where one passes here, but not the depth test.
    pub depth_fail: StencilOp,
    /// Where one passes both.
    pub pass: StencilOp,
}

/// How the reference compares with what is stored, both under the read mask, if a fragment passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StencilTest {
    /// Never.
    Never,
    /// If the reference is less.
    Less,
    /// If they are equal.
    Equal,
    /// If the reference is less, or equal.
    LessOrEqual,
    /// If the reference is greater.
    Greater,
    /// If they are different.
    NotEqual,
    /// If the reference is greater, or equal.
    GreaterOrEqual,
    /// Always.
    #[default]
    Always,
}

/// What becomes of a stored byte, in the bits of the write mask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StencilOp {
    /// It is kept.
    #[default]
    Keep,
    /// It becomes 0.
    Zero,
    /// It becomes the reference.
    Replace,
    /// All its bits are inverted.
    Invert,
    /// One is added, up to 255.
    IncrementClamp,
    /// One is taken off, down to 0.
    DecrementClamp,
    /// One is added; after 255 comes 0.
    IncrementWrap,
    /// One is taken off; before 0 comes 255.
    DecrementWrap,
}

impl Stencil {
    /// Fragments are drawn as without a stencil; the byte of each becomes `value`.
    #[must_use]
    pub fn mark(value: u8) -> Self {
        let face = StencilFace { pass: StencilOp::Replace, ..StencilFace::default() };
        Self { reference: value, front: face, back: face, ..Self::default() }
    }

    /// Fragments are drawn where the byte is `value`, which is not changed.
    #[must_use]
    pub fn only(value: u8) -> Self {
        let face = StencilFace { test: StencilTest::Equal, ..StencilFace::default() };
        Self { reference: value, front: face, back: face, ..Self::default() }
    }

    /// Fragments are drawn where the byte is not `value`, which is not changed.
    #[must_use]
    pub fn unless(value: u8) -> Self {
        let face = StencilFace { test: StencilTest::NotEqual, ..StencilFace::default() };
        Self { reference: value, front: face, back: face, ..Self::default() }
    }

    /// Tests the pixels of a block, and changes their bytes. `passes` are those that pass by depth. Returns
    /// those that pass both; their bytes from before go to `before`.
    pub(crate) fn update(
        &self,
        face: &StencilFace,
        stored: &mut [u8],
        (at, covered, passes): ([usize; 2], u32, u32),
        before: &mut [u8; LANES],
    ) -> u32 {
        let (mut drawn, mut left) = (0, covered);
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let Some(stored) = stored.get_mut(lane_at(at, lane)) else { continue };
            before[lane] = *stored;
            let passes_depth = passes >> lane & 1 != 0;
            let op = if !face.test.passes(self.reference & self.read_mask, *stored & self.read_mask)
            {
                face.fail
            } else if !passes_depth {
                face.depth_fail
            } else {
                drawn |= 1 << lane;
                face.pass
            };
            let new = op.apply(*stored, self.reference);
            *stored = new & self.write_mask | *stored & !self.write_mask;
        }
        drawn
    }

    /// What is done with a side.
    pub(crate) fn face(&self, is_front: bool) -> &StencilFace {
        if is_front { &self.front } else { &self.back }
    }
}

/// Where a lane's pixel is, if its halves begin at `at`.
fn lane_at(at: [usize; 2], lane: usize) -> usize {
    at[lane / HALF_BLOCK].wrapping_add(lane % HALF_BLOCK)
}

/// Puts the bytes of some lanes back.
#[cold]
pub(crate) fn put_back(stored: &mut [u8], at: [usize; 2], lanes: u32, before: &[u8; LANES]) {
    for (lane, before) in before.iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 != 0) {
        if let Some(stored) = stored.get_mut(lane_at(at, lane)) {
            *stored = *before;
        }
    }
}

impl Default for Stencil {
    /// All pass, nothing changes, all bits count.
    fn default() -> Self {
        let face = StencilFace::default();
        Self { reference: 0, read_mask: u8::MAX, write_mask: u8::MAX, front: face, back: face }
    }
}

impl Default for StencilFace {
    /// All pass, nothing changes.
    fn default() -> Self {
        let keep = StencilOp::Keep;
        Self { test: StencilTest::Always, fail: keep, depth_fail: keep, pass: keep }
    }
}

impl StencilTest {
    fn passes(self, reference: u8, stored: u8) -> bool {
        match self {
            Self::Never => false,
            Self::Less => reference < stored,
            Self::Equal => reference == stored,
            Self::LessOrEqual => reference <= stored,
            Self::Greater => reference > stored,
            Self::NotEqual => reference != stored,
            Self::GreaterOrEqual => reference >= stored,
            Self::Always => true,
        }
    }
}

impl StencilOp {
    fn apply(self, stored: u8, reference: u8) -> u8 {
        match self {
            Self::Keep => stored,
            Self::Zero => 0,
            Self::Replace => reference,
            Self::Invert => !stored,
            Self::IncrementClamp => stored.saturating_add(1),
            Self::DecrementClamp => stored.saturating_sub(1),
            Self::IncrementWrap => stored.wrapping_add(1),
            Self::DecrementWrap => stored.wrapping_sub(1),
        }
    }
}
