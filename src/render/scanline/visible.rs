//! Visible surfaces along one row, and the order of the transparent ones over them.
//!
//! The runs of all faces that cross the row go in, each with its depth as a line over the columns.
//! Out come visible_runs: parts of runs, in the order in which they are to be painted.
//!
//! The opaque runs are put into layers, none of which has two runs at one column, and the layers
//! are merged in pairs until one is left: the lower envelope of the depths. Where two layers meet,
//! lines that are clearly apart at both ends of an interval are apart within it; lines that cross
//! are compared pixel by pixel near the crossing only. With n runs in k layers that is O(n log k)
//! steps, however many pixels the runs have (an envelope of n lines over intervals has hardly more
//! than n pieces: Hershberger, "Finding the upper envelope of n line segments in O(n log n) time",
//! Information Processing Letters 33, 1989), and one for each pixel and pair of faces that rounding
//! cannot tell apart there. Only of k faces in one plane are there k such steps a pixel, as many as
//! a z-buffer always takes.
//!
//! Transparent runs are sorted by depth wherever one begins, ends or crosses another. That is at
//! most once for each of the pixels, so it takes O(log k) for each transparent fragment at most.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

/// Depth along a run, before it is brought into the range of the polygon's vertices; the less, the
/// nearer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthLine {
    /// The column where it is `at`, relative to the viewport.
    pub(crate) x: i32,
    pub(crate) at: f32,
    /// The change per column.
    pub(crate) delta: f32,
}

impl DepthLine {
    /// The depth at a column: the same two operations as [`Block::depth`], so the same bits.
    ///
    /// [`Block::depth`]: crate::fragment::block::Block::depth
    #[inline]
    fn depth(self, x: i32) -> f32 {
        (x - self.x) as f32 * self.delta + self.at
    }

    /// The depth in f64, and the sum of the sizes of its product and itself. The product of 24 and
    /// 19 bits is exact.
    #[inline]
    fn exact(self, x: i32) -> (f64, f64) {
        let product = f64::from(x - self.x) * f64::from(self.delta);
        let depth = product + f64::from(self.at);
        (depth, product.abs() + depth.abs())
    }
}

/// [`DepthLine::depth`] rounds the product and the sum, each by at most 2^-24 of itself; so it is
/// off by 2^-24 (|product| + |depth|) and what is left of the second order. This is twice that, to
/// hold the second order and the rounding of the f64 arithmetic that compares.
const ROUNDING: f64 = 1.0 / (1 << 23) as f64;

/// More than both roundings of two depths where they are subnormal, 2^-150 each.
const UNDERFLOW: f64 = f32::MIN_POSITIVE as f64;

/// A part of a run along which depth is a line, limits included.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    start: i32,
    end: i32,
    depth: DepthLine,
    /// The face; of equal depths the lower one's is nearer.
    face: u32,
    run: u32,
}

impl Candidate {
    #[inline]
    fn is_nearer(&self, other: &Self, x: i32) -> bool {
        let depths = (self.depth.depth(x), other.depth.depth(x));
        depths.0 < depths.1 || depths.0 == depths.1 && self.face < other.face
    }

    /// Compares two candidates at all of some columns; there must be one.
    fn compare(&self, other: &Self, columns: &Range<i32>) -> Comparison {
        if self.depth == other.depth {
            let nearer = self.face < other.face;
            return Comparison { unclear: columns.end..columns.end, nearer: [nearer; 2] };
        }
        let ends = [columns.start, columns.end - 1].map(|x| {
            let (a, b) = (self.depth.exact(x), other.depth.exact(x));
            (a.0 - b.0, a.1 + b.1)
        });
        // Sizes are convex along a row, so they are greatest at an end.
        let margin = ROUNDING * ends[0].1.max(ends[1].1) + UNDERFLOW;
        let farther = ends.map(|(farther, _)| farther);
        let nearer = farther.map(|farther| farther < 0.0);
        let is_clear = farther.map(|farther| farther.abs() > margin);
        if is_clear == [true; 2] && nearer[0] == nearer[1] {
            return Comparison { unclear: columns.end..columns.end, nearer };
        }
        Comparison { unclear: crossing(columns, farther, margin), nearer }
    }
}

/// The columns where a function that is linear between its values at the first and at the last
/// column comes within `margin` of zero, and one more on each side for rounding.
fn crossing(columns: &Range<i32>, [first, last]: [f64; 2], margin: f64) -> Range<i32> {
    let slope = (last - first) / f64::from(columns.end - 1 - columns.start);
    if slope == 0.0 || !slope.is_finite() {
        return columns.clone();
    }
    let [a, b] = [-margin, margin].map(|value| (value - first) / slope);
    // The casts keep what is too large at the limits of i64, far beyond those of the columns.
    let column = |offset: f64| i64::from(columns.start).saturating_add(offset as i64);
    let (low, high) = (column(a.min(b).floor() - 1.0), column(a.max(b).ceil() + 2.0));
    let inside = |x: i64| x.clamp(columns.start.into(), columns.end.into()) as i32;
    inside(low)..inside(high)
}

/// Which of two candidates is nearer: the first to the left of the unclear columns if `nearer[0]`,
/// to the right of them if `nearer[1]`. If no column is unclear, both say the same of all.
struct Comparison {
    unclear: Range<i32>,
    nearer: [bool; 2],
}

/// Columns at which a candidate is the nearest of its layer.
#[derive(Clone, Copy, Debug)]
struct Piece {
    start: i32,
    end: i32,
    candidate: u32,
}

/// A part of a run to be painted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct VisibleRun {
    pub(crate) columns: Range<i32>,
    /// The number that the run was added with.
    pub(crate) run: u32,
    pub(crate) transparent: bool,
}

/// The runs of one row, with memory that is kept.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    opaque: Vec<Candidate>,
    transparent: Vec<Candidate>,
    layers: Vec<Vec<Piece>>,
    /// The ends of the layers, the leftmost on top.
    ends: BinaryHeap<Reverse<(i32, usize)>>,
    merged: Vec<Piece>,
    /// The transparent candidates at a column.
    set: Vec<u32>,
    visible_runs: Vec<VisibleRun>,
}

impl Row {
    /// Forgets the runs.
    pub(crate) fn clear(&mut self) {
        self.opaque.clear();
        self.transparent.clear();
    }

    /// Adds a run of a face at columns of which there is at least one, with its depth and the limits
    /// that this is brought into. Layers are fewest if runs come from left to right.
    pub(crate) fn add(
        &mut self,
        (run, face, transparent): (u32, u32, bool),
        columns: Range<i32>,
        depth: DepthLine,
        (min, max): (f32, f32),
    ) {
        // From left to right depth is at one limit, within them, at the other: all that it takes to
        // have lines is to cut the run in three.
        let rises = depth.delta >= 0.0;
        let (left, right) = if rises { (min, max) } else { (max, min) };
        let is_before = |d: f32| if rises { d < min } else { d > max };
        let is_within = |d: f32| if rises { d <= max } else { d >= min };
        let a = end_of(columns.clone(), |x| is_before(depth.depth(x)));
        let b = end_of(a..columns.end, |x| is_within(depth.depth(x)));
        let level = |at: f32| DepthLine { x: 0, at, delta: 0.0 };
        let parts =
            [(columns.start..a, level(left)), (a..b, depth), (b..columns.end, level(right))];
        let list = if transparent { &mut self.transparent } else { &mut self.opaque };
        for (Range { start, end }, depth) in parts {
            if start < end {
                list.push(Candidate { start, end, depth, face, run });
            }
        }
    }

    /// What is to be painted: the visible parts of the opaque runs, each column once, and then
    /// transparent runs from back to front at each column, whether hidden by opaque ones or not.
    pub(crate) fn visible_runs(&mut self) -> &[VisibleRun] {
        self.visible_runs.clear();
        let layers = self.fill_layers();
        self.merge_layers(layers);
        if let Some(envelope) = self.layers.first().filter(|_| layers > 0) {
            let visible_run = |piece: &Piece| VisibleRun {
                columns: piece.start..piece.end,
                run: self.opaque[piece.candidate as usize].run,
                transparent: false,
            };
            self.visible_runs.extend(envelope.iter().map(visible_run));
        }
        self.sort_transparent();
        &self.visible_runs
    }

    /// Puts each opaque candidate into a layer that ends before it; how many layers there are.
    fn fill_layers(&mut self) -> usize {
        self.ends.clear();
        let mut layers = 0;
        for (candidate, &Candidate { start, end, .. }) in (0..).zip(&self.opaque) {
            let free = self.ends.peek().filter(|Reverse((layer_end, _))| *layer_end <= start);
            let layer = match free.map(|Reverse((_, layer))| *layer) {
                Some(layer) => {
                    self.ends.pop();
                    layer
                }
                None => {
                    layers += 1;
                    if self.layers.len() < layers {
                        self.layers.push(Vec::new());
                    }
                    self.layers[layers - 1].clear();
                    layers - 1
                }
            };
            self.ends.push(Reverse((end, layer)));
            self.layers[layer].push(Piece { start, end, candidate });
        }
        layers
    }

    /// Merges neighbouring layers until the first has all.
    fn merge_layers(&mut self, layers: usize) {
        let mut distance = 1;
        while distance < layers {
            for first in (0..layers - distance).step_by(2 * distance) {
                self.merged.clear();
                let [a, b] = [first, first + distance].map(|i| &self.layers[i]);
                merge(&self.opaque, a, b, &mut self.merged);
                std::mem::swap(&mut self.layers[first], &mut self.merged);
            }
            distance *= 2;
        }
    }

    /// Appends the visible_runs of the transparent candidates.
    fn sort_transparent(&mut self) {
        self.transparent.sort_unstable_by_key(|candidate| (candidate.start, candidate.face));
        self.set.clear();
        let end = |&i: &u32| self.transparent[i as usize].end;
        let mut rest = (0..).zip(&self.transparent).peekable();
        let mut x = i32::MIN;
        loop {
            self.set.retain(|i| end(i) > x);
            if self.set.is_empty() {
                let Some((_, candidate)) = rest.peek() else { return };
                x = candidate.start;
            }
            while let Some((i, _)) = rest.next_if(|(_, candidate)| candidate.start <= x) {
                self.set.push(i);
            }
            let next = rest.peek().map_or(i32::MAX, |(_, candidate)| candidate.start);
            let columns = x..self.set.iter().map(end).fold(next, i32::min);
            x = columns.end;
            paint_back_to_front(&self.transparent, &mut self.set, columns, |visible_run| {
                self.visible_runs.push(visible_run);
            });
        }
    }
}

/// Paints a set of transparent candidates at columns that all of them have. Sorted at a column, they
/// stay so up to the first column where the order of two neighbours is not clear.
fn paint_back_to_front(
    candidates: &[Candidate],
    set: &mut [u32],
    columns: Range<i32>,
    mut paint: impl FnMut(VisibleRun),
) {
    let mut x = columns.start;
    while x < columns.end {
        let candidate = |i: u32| &candidates[i as usize];
        set.sort_unstable_by(|&a, &b| {
            let (a, b) = (candidate(a), candidate(b));
            // Adding 0 leaves one zero only.
            let depths = [a, b].map(|candidate| candidate.depth.depth(x) + 0.0);
            depths[0].total_cmp(&depths[1]).then(a.face.cmp(&b.face))
        });
        let mut end = columns.end;
        for pair in set.windows(2) {
            let unclear = candidate(pair[0]).compare(candidate(pair[1]), &(x..end)).unclear;
            end = end.min(unclear.start.max(x + 1));
        }
        for &i in set.iter().rev() {
            paint(VisibleRun { columns: x..end, run: candidate(i).run, transparent: true });
        }
        x = end;
    }
}

/// The end of the columns, from the first one on, for which `holds` is true; it must not become true
/// again.
#[inline]
fn end_of(columns: Range<i32>, holds: impl Fn(i32) -> bool) -> i32 {
    let Range { start: mut low, end: mut high } = columns;
    if low >= high || holds(high - 1) {
        return high;
    }
    // Mostly it is none or all of them.
    if !holds(low) {
        return low;
    }
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// The nearest of two layers at each column.
fn merge(candidates: &[Candidate], a: &[Piece], b: &[Piece], out: &mut Vec<Piece>) {
    let (mut a, mut b) = (a.iter().copied(), b.iter().copied());
    let (mut left, mut right) = (a.next(), b.next());
    while let (Some(p), Some(q)) = (&mut left, &mut right) {
        if p.start < q.start {
            let end = p.end.min(q.start);
            push(out, Piece { end, ..*p });
            p.start = end;
        } else if q.start < p.start {
            let end = q.end.min(p.start);
            push(out, Piece { end, ..*q });
            q.start = end;
        } else {
            let end = p.end.min(q.end);
            push_nearest(candidates, [p.candidate, q.candidate], p.start..end, out);
            (p.start, q.start) = (end, end);
        }
        if p.start == p.end {
            left = a.next();
        }
        if q.start == q.end {
            right = b.next();
        }
    }
    left.into_iter().chain(a).chain(right).chain(b).for_each(|piece| push(out, piece));
}

/// The nearest of two candidates at columns that both have.
fn push_nearest(
    candidates: &[Candidate],
    pair: [u32; 2],
    columns: Range<i32>,
    out: &mut Vec<Piece>,
) {
    let [a, b] = pair.map(|i| &candidates[i as usize]);
    let Comparison { unclear, nearer } = a.compare(b, &columns);
    let mut push = |start: i32, end: i32, first_is_nearer: bool| {
        if start < end {
            push(out, Piece { start, end, candidate: pair[usize::from(!first_is_nearer)] });
        }
    };
    push(columns.start, unclear.start, nearer[0]);
    for x in unclear.clone() {
        push(x, x + 1, a.is_nearer(b, x));
    }
    push(unclear.end, columns.end, nearer[1]);
}

/// Appends a piece, or makes the last one longer.
fn push(pieces: &mut Vec<Piece>, piece: Piece) {
    match pieces.last_mut() {
        Some(last) if last.candidate == piece.candidate && last.end == piece.start => {
            last.end = piece.end;
        }
        _ => pieces.push(piece),
    }
}
