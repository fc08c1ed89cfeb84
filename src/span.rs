//! Spans: the pixels of one row that a polygon covers between two of its edges.
//!
//! A span carries the values of (z, s_1 .. s_n, s_{n+1}) at its start and their change per pixel.
//! A renderer may step them itself, or go on to [fragments](crate::fragment), one by one or in blocks.
//! Those do not step: each is found from the polygon's far end alone, visible or not, where 1/w is
//! smallest. So errors do not add up, and a picture is the same however it is cut into tiles.
//!
//! ```text
//!       near end                          far end: the values are given here
//!         |<------------ l pixels ----------->|
//!         [][][][][][][][][][][][][][][][][][][]     v = a + d l, for each pixel alone
//!             |                   |
//!             the columns that are visible: a part of the run
//! ```

use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};

use crate::coverage::Run;
use crate::coverage::run::RunGroup;
use crate::fragment::block::{ALL, Block, HALF_BLOCK, SpanLine};
use crate::fragment::{Fragment, FragmentBlock, LANES};
use crate::project::ScreenParams;
use crate::simd::for_level;
use crate::surface::mixed::Component;
use crate::surface::rows::{RowValues, SurfaceView};

/// A run of covered pixels with what is interpolated along it.
#[derive(Clone, Debug)]
pub struct Span<'a, const N: usize> {
    surface: SurfaceView<'a>,
    runs: RunGroup,
    /// The columns that are visible, relative to the viewport.
    columns: Range<i32>,
    lines: SpanLines<N>,
}

/// The values along a span.
#[derive(Clone, Debug)]
struct SpanLines<const N: usize> {
    /// Depth.
    values: RowValues,
    inv_w: SpanLine,
    s: [SpanLine; N],
}

impl<'a, const N: usize> Span<'a, N> {
    /// The part of a run within the given columns, if any. `values` is memory to work in.
    pub(crate) fn new(
        surface: SurfaceView<'a>,
        run: &Run,
        columns: &Range<i32>,
        values: &mut RowValues,
    ) -> Option<Self> {
        let visible = run.x.start.max(columns.start)..run.x.end.min(columns.end);
        if visible.is_empty() {
            return None;
        }
        let runs = RunGroup::of(run);
        surface.start_rows(&runs, &visible, values);
        surface.find_params(values);
        let mut s = [SpanLine::default(); N];
        for (line, value) in s.iter_mut().zip(&values.s) {
            *line = SpanLine::of(value, 0);
        }
        let inv_w = SpanLine::of(&values.inv_w, 0);
        let lines = SpanLines { values: values.without_params(), inv_w, s };
        Some(Self { surface, runs, columns: visible, lines })
    }

    /// The row on the framebuffer.
    #[inline(always)]
    #[must_use]
    pub fn row(&self) -> i32 {
        self.surface.base.corner.1 + self.runs.y
    }

    /// The columns on the framebuffer; never empty.
    #[must_use]
    pub fn columns(&self) -> Range<i32> {
        let corner = self.surface.base.corner.0;
        corner + self.columns.start..corner + self.columns.end
    }

    /// z, s_1 .. s_n and s_{n+1} = 1/w at the centre of the first pixel.
    #[must_use]
    pub fn start(&self) -> ScreenParams<N> {
        let run = self.surface.in_run(&self.runs.run(0));
        self.per_w(|component| run.at(component, self.columns.start))
    }

    /// The change of [`start`](Self::start) from one pixel to the next.
    #[must_use]
    pub fn delta(&self) -> ScreenParams<N> {
        let run = self.surface.in_run(&self.runs.run(0));
        self.per_w(|component| run.along(component).1)
    }

    /// All values, from the polygon's unit of w to w itself; the unit is a power of two, so this is
    /// exact.
    fn per_w(&self, value: impl Fn(Component) -> f64) -> ScreenParams<N> {
        let unit = self.surface.base.w_unit;
        ScreenParams {
            z: value(Component::Z),
            inv_w: value(Component::InvW) / unit,
            s: std::array::from_fn(|i| {
                let s = value(Component::S(i));
                if self.surface.times_w(i) { s / unit } else { s }
            }),
        }
    }

    /// The fragments, from left to right: depth, w and parameters of each pixel.
    ///
    /// [`for_each_block`](Self::for_each_block) is several times as fast.
    #[must_use]
    pub fn fragments(&self) -> Fragments<'_, N> {
        Fragments { span: self, next: self.columns.start, block: None }
    }

    /// Calls `f` for each block of [`LANES`] fragments, from left to right, compiled for the SIMD
    /// instructions of `level`: a loop over the lanes in `f` may become SIMD, if `f` is inlined. A large
    /// closure is not, unless it is marked, as in `for_each_block(level, #[inline(always)] |block| ..)`;
    /// that can make it several times as fast.
    ///
    /// All lanes of a block are in the span's row, those that are visible first: in the last block the
    /// lanes beyond the end are not.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::{Level, ScanConverter, Vertex, Viewport};
    ///
    /// let triangle = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x]));
    /// let mut scan = ScanConverter::new(Viewport::new(100, 100)?);
    /// let mut picture = vec![0.0; 100 * 100];
    /// for span in scan.spans(&triangle) {
    ///     span.for_each_block(Level::new(), |block| {
    ///         let (x, y) = block.position(0);
    ///         let pixels = &mut picture[y as usize * 100 + x as usize..];
    ///         let count = block.visible.count_ones() as usize;
    ///         for (pixel, r) in pixels.iter_mut().zip(&block.params[0]).take(count) {
    ///             *pixel = r * r;
    ///         }
    ///     });
    /// }
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    pub fn for_each_block(&self, level: Level, mut f: impl FnMut(&FragmentBlock<'_, N>)) {
        for_level!(level, simd => self.blocks(simd, &mut f));
    }

    #[inline(always)]
    fn blocks<S: Simd>(&self, simd: S, f: &mut impl FnMut(&FragmentBlock<'_, N>)) {
        for x in self.columns.clone().step_by(LANES) {
            f(&self.block(simd, x));
        }
    }

    /// The block whose first lane is at a column relative to the viewport.
    #[inline(always)]
    fn block<S: Simd>(&self, simd: S, x: i32) -> FragmentBlock<'_, N> {
        let left = (self.columns.end - x).clamp(0, LANES as i32);
        let halves = [(x, 0), (x + HALF_BLOCK as i32, 0)];
        let visible = ALL >> (LANES as i32 - left);
        let mut fragments = FragmentBlock::new(&self.surface, &self.runs, halves, visible);
        let SpanLines { values, inv_w, s } = &self.lines;
        let block = Block::in_row(simd, 0, (x - values.x[0]) as f32);
        fragments.depth = block.depth(&self.surface, values).into();
        block.any(&self.surface, inv_w, s, fragments.found());
        fragments
    }
}

/// Iterator over the fragments of a span.
#[derive(Clone, Debug)]
pub struct Fragments<'a, const N: usize> {
    span: &'a Span<'a, N>,
    /// The first column, relative to the viewport, that `block` does not have.
    next: i32,
    block: Option<FragmentBlock<'a, N>>,
}

impl<'a, const N: usize> Iterator for Fragments<'a, N> {
    type Item = Fragment<'a, N>;

    fn next(&mut self) -> Option<Fragment<'a, N>> {
        loop {
            if let Some(block) = &mut self.block
                && block.visible != 0
            {
                let lane = block.visible.trailing_zeros() as usize;
                block.visible &= block.visible - 1;
                return Some(block.fragment(lane));
            }
            if self.next >= self.span.columns.end {
                return None;
            }
            let x = self.next;
            self.next += LANES as i32;
            self.block = Some(dispatch!(Level::baseline(), simd => self.span.block(simd, x)));
        }
    }
}
