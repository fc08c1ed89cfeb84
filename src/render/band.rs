//! Bands: neighbouring rows of the depth buffer that one thread draws to.
//!
//! ```text
//!     +---------------------+
//!     | band 0: 32 rows     |   each drawn by one thread, its faces in their order
//!     +---------------------+
//!     | band 1              |
//!     +---------------------+
//!     | the last, with what |
//!     | rows are left       |
//!     +---------------------+
//! ```
//!
//! Pixels are counted over the whole target, row by row, so that whoever holds the colours needs to
//! know nothing of bands.

use std::ops::Range;

use crate::fragment::LANES;
use crate::fragment::block::HALF_BLOCK;
use crate::render::coarse_depth::CoarseDepth;
use crate::render::counters::Counters;
use crate::render::stencil::Stencil;

/// Some neighbouring rows of a target's depths.
#[derive(Debug)]
pub(crate) struct Band<'a> {
    /// The first row on the framebuffer.
    pub(crate) first: i32,
    /// The column of the framebuffer that is the target's first.
    column: i32,
    pub(crate) width: usize,
    /// The depths of whole rows.
    pub(crate) depth: &'a mut [f32],
    /// How many pixels of the target come before these.
    pub(crate) pixels_before: usize,
    /// Pixels from the beginning of a cache line to the first depth. Memory is faster in whole
    /// lines.
    pub(crate) line_offset: usize,
    /// The coarse depths, where there are any.
    pub(crate) coarse: Option<&'a mut CoarseDepth>,
    /// What else is done with pixels, if anything is.
    pub(crate) extras: Extras<'a>,
}

/// What is done with pixels besides the depth test.
#[derive(Debug, Default)]
pub(crate) struct Extras<'a> {
    /// The stencil of the same pixels, with what is done.
    pub(crate) stencil: Option<(Stencil, &'a mut [u8])>,
    /// Where they are counted.
    pub(crate) counters: Option<&'a Counters>,
}

impl Extras<'_> {
    /// The same, borrowed.
    fn reborrow(&mut self) -> Extras<'_> {
        let stencil = self.stencil.as_mut().map(|(stencil, bytes)| (*stencil, &mut **bytes));
        Extras { stencil, counters: self.counters }
    }

    /// Those of the pixels before one, and those of the others.
    fn split(&mut self, pixel: usize) -> (Extras<'_>, Extras<'_>) {
        let counters = self.counters;
        let (mut first, mut second) = (None, None);
        if let Some((stencil, bytes)) = &mut self.stencil {
            let (before, after) = bytes.split_at_mut(pixel);
            (first, second) = (Some((*stencil, before)), Some((*stencil, after)));
        }
        (Extras { stencil: first, counters }, Extras { stencil: second, counters })
    }
}

impl<'a> Band<'a> {
    /// All rows of a target whose top left pixel is at `corner` of the framebuffer. `width` is not 0.
    pub(crate) fn new((column, first): (i32, i32), width: usize, depth: &'a mut [f32]) -> Self {
        let line_offset = line_offset(depth);
        let extras = Extras::default();
        Self { first, column, width, depth, pixels_before: 0, line_offset, coarse: None, extras }
    }

    /// The same band with a coarse depth.
    pub(crate) fn with_coarse<'b>(&'b mut self, coarse: Option<&'b mut CoarseDepth>) -> Band<'b> {
        let Self { first, column, width, pixels_before, line_offset, .. } = *self;
        let extras = self.extras.reborrow();
        Band { first, column, width, depth: self.depth, pixels_before, line_offset, coarse, extras }
    }

    /// The same band, whose pixels are counted.
    pub(crate) fn with_counters<'b>(&'b mut self, counters: Option<&'b Counters>) -> Band<'b> {
        let mut band = self.with_coarse(None);
        band.extras.counters = counters;
        band
    }

    /// Cuts the band in two before a row, counted from its first.
    pub(crate) fn split(&mut self, rows: usize) -> (Band<'_>, Band<'_>) {
        let Self { first, column, width, pixels_before, line_offset: offset, .. } = *self;
        let (upper, lower) = self.depth.split_at_mut(rows * width);
        let (upper_extras, lower_extras) = self.extras.split(rows * width);
        let before = pixels_before + upper.len();
        let band = |first, depth, pixels_before, line_offset, extras| Band {
            first,
            column,
            width,
            depth,
            pixels_before,
            line_offset,
            coarse: None,
            extras,
        };
        let lower_offset = line_offset(lower);
        (
            band(first, upper, pixels_before, offset, upper_extras),
            band(first + rows as i32, lower, before, lower_offset, lower_extras),
        )
    }

    /// The rows of the framebuffer that it holds.
    #[inline(always)]
    pub(crate) fn rows(&self) -> Range<i32> {
        self.first..self.first + (self.depth.len() / self.width) as i32
    }

    /// Where pixel (x, y) of the framebuffer is in the band's depths. Outside the band the result is
    /// meaningful only modulo 2^64, as part of a sum.
    #[inline(always)]
    pub(crate) fn index(&self, x: i32, y: i32) -> usize {
        let row = (y - self.first) as usize;
        row.wrapping_mul(self.width).wrapping_add((x - self.column) as usize)
    }

    /// How far a column of the framebuffer is from the left of the band.
    #[inline(always)]
    pub(crate) fn column(&self, x: i32) -> usize {
        (x - self.column) as usize
    }

    /// The depths of half a block that begins at `at`; of pixels outside of the band, 0.
    #[inline(always)]
    pub(crate) fn half(&self, at: usize) -> [f32; HALF_BLOCK] {
        match self.depth.get(at..).and_then(<[f32]>::first_chunk) {
            Some(half) => *half,
            None => self.half_at_end(at),
        }
    }

    #[cold]
    fn half_at_end(&self, at: usize) -> [f32; HALF_BLOCK] {
        let depth = |lane| self.depth.get(at.wrapping_add(lane)).copied().unwrap_or(0.0);
        std::array::from_fn(depth)
    }

    /// Calls `touch` with the target's pixels of each row in some columns, and reads their depths: this
    /// brings them into the cache in their order, which is faster than from all over the band.
    pub(crate) fn prefetch(&self, columns: &Range<usize>, mut touch: impl FnMut(Range<usize>)) {
        /// Depths in a cache line.
        const LINE: usize = 16;
        if columns.is_empty() {
            return;
        }
        for row in 0..self.rows().len() {
            let pixels = row * self.width + columns.start..row * self.width + columns.end;
            let depths = self.depth.get(pixels.clone()).unwrap_or_default();
            for depth in depths.iter().step_by(LINE) {
                std::hint::black_box(*depth);
            }
            touch(pixels.start + self.pixels_before..pixels.end + self.pixels_before);
        }
    }
}

fn line_offset(depth: &[f32]) -> usize {
    depth.as_ptr().addr() / size_of::<f32>() % LANES
}
