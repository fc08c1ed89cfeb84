//! A coarse depth buffer: for each tile of a band a depth that no pixel of it is farther than, so
//! that what lies behind is left out without a look at the pixels (Greene, Kass and Miller,
//! "Hierarchical Z-Buffer Visibility", 1993, with two levels).
//!
//! Drawing only brings pixels nearer, so a bound that was true once stays true; but it grows loose.
//!
//! ```text
//!     |<- 64 pixels ->|
//!     +---------------+---------------+---
//!     | farthest 0.71 | farthest 0.94 |       8 rows: a polygon at depth 0.8 is hidden in the left
//!     +---------------+---------------+---    tile whatever its pixels are, in the right one it may
//!     |               |               |       be seen
//! ```
//!
//! Long runs of eight neighbouring rows are looked at together: a tile is left out in all of them or in none.
//!
//! The bound is found again from the tile's pixels when as many pixels were tested in the tile as it has:
//! then looking at all of them costs a small part of what was spent there already.

use std::ops::Range;

use crate::fragment::{LANES, Lanes};
use crate::render::depth::Comparison;

/// The width of a tile: a few blocks, since looking up a tile takes about as long as testing one.
pub(crate) const TILE_WIDTH: usize = 64;

/// The height of a tile. Low tiles lie less often across the outline of what hides.
const TILE_HEIGHT: usize = 8;

/// The pixels tested in a tile after which its bound is found again.
const TILE_WORK: u32 = (TILE_WIDTH * TILE_HEIGHT) as u32;

/// After so many polygons of which none was hidden, only one in [`PROBE`] is asked for until one is.
const MISSES: u32 = 64;
const PROBE: u32 = 16;

/// A polygon that touches more tiles than this is looked at span by span.
pub(crate) const FEW_TILES: usize = 4;

/// The coarse depths of a band of rows, and the memory for them.
#[derive(Clone, Debug, Default)]
pub(crate) struct CoarseDepth {
    tiles: Vec<Tile>,
    /// Tiles in a row.
    columns: usize,
    /// Pixels in a row.
    width: usize,
    order: Order,
    /// How many polygons were asked for since one was hidden.
    misses: u32,
}

/// Which tiles in neighbouring columns are hidden in some rows: nothing is seen of them there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HiddenTiles {
    /// The column of the first.
    first: usize,
    /// A bit for each that is hidden, from there on.
    bits: u64,
}

impl HiddenTiles {
    /// The next of the columns `x` that are not hidden, as far as they follow one another.
    #[inline(always)]
    pub(crate) fn next_visible(self, x: Range<usize>) -> Range<usize> {
        let start = self.end_of(x.start / TILE_WIDTH, self.bits).max(x.start).min(x.end);
        start..self.end_of(start / TILE_WIDTH, !self.bits).max(start).min(x.end)
    }

    /// The first column of pixels of the next tile, from one on, that has no bit. The last of the bits says
    /// the same of all tiles beyond.
    #[inline(always)]
    fn end_of(self, tile: usize, bits: u64) -> usize {
        let before = tile - self.first;
        let count = ((bits as i64) >> before.min(63)).trailing_ones() as usize;
        if before + count < u64::BITS as usize { (tile + count) * TILE_WIDTH } else { usize::MAX }
    }
}

#[derive(Clone, Copy, Debug)]
struct Tile {
    /// No pixel of the tile is farther.
    farthest: f32,
    /// How many pixels were tested since `farthest` was found.
    work: u32,
}

/// What hides what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Order {
    /// The test is no comparison of nearer and farther.
    #[default]
    None,
    /// Less depth is nearer. `equal` tells whether what is as near as the pixel is drawn.
    Less { equal: bool },
    /// Greater depth is nearer.
    Greater { equal: bool },
}

impl CoarseDepth {
    /// Begins anew with pixels of any depth; whether there is anything to gain.
    pub(crate) fn restart(&mut self, test: Comparison, width: usize, rows: usize) -> bool {
        self.order = match test {
            Comparison::Less => Order::Less { equal: false },
            Comparison::LessEqual => Order::Less { equal: true },
            Comparison::Greater => Order::Greater { equal: false },
            Comparison::GreaterEqual => Order::Greater { equal: true },
            _ => Order::None,
        };
        self.misses = 0;
        self.width = width;
        self.columns = width.div_ceil(TILE_WIDTH);
        let farthest = match self.order {
            Order::Greater { .. } => f32::NEG_INFINITY,
            _ => f32::INFINITY,
        };
        self.tiles.clear();
        self.tiles.resize(self.columns * rows.div_ceil(TILE_HEIGHT), Tile { farthest, work: 0 });
        self.order != Order::None
    }

    /// Whether the next polygon had better be drawn without asking, since none is hidden here.
    #[inline(always)]
    pub(crate) fn is_idle(&mut self) -> bool {
        self.misses = self.misses.wrapping_add(1);
        self.misses > MISSES && !self.misses.is_multiple_of(PROBE)
    }

    /// Whether a polygon is hidden that has its pixels within these columns and rows of the band,
    /// none of them with a depth outside of `depths`. If it is not, it is taken to be drawn.
    pub(crate) fn hides_polygon(
        &mut self,
        pixels: &[f32],
        columns: Range<usize>,
        rows: Range<usize>,
        depths: (f32, f32),
    ) -> bool {
        let tiles = |range: &Range<usize>, size| range.start / size..range.end.div_ceil(size);
        let (across, down) = (tiles(&columns, TILE_WIDTH), tiles(&rows, TILE_HEIGHT));
        let count = across.len() * down.len();
        if count > FEW_TILES {
            return false;
        }
        let tiles = || down.clone().flat_map(|y| across.clone().map(move |x| (x, y)));
        if tiles().all(|(x, y)| self.hides(pixels, x, y, || depths)) {
            self.misses = 0;
            return true;
        }
        // Polygons fill about half of their bounding boxes.
        let work = (columns.len() * rows.len() / 2) as u32;
        for (x, y) in tiles() {
            self.add_work(x, y, work);
        }
        false
    }

    /// Which tiles in some columns are hidden in all of some rows of the band; the others are taken to be drawn.
    /// `depths` gives the least and the most depths at columns, of all the rows; in each row they must grow or
    /// fall. `None` if there are more than are known at a time.
    #[inline(always)]
    pub(crate) fn hidden_tiles(
        &mut self,
        pixels: &[f32],
        columns: &Range<usize>,
        rows: &Range<usize>,
        depths: impl Fn([usize; LANES]) -> (Lanes, Lanes),
    ) -> Option<HiddenTiles> {
        let tiles = columns.start / TILE_WIDTH..columns.end.div_ceil(TILE_WIDTH);
        // The last bit is that of tiles beyond, of which there are none.
        if tiles.len() >= u64::BITS as usize {
            return None;
        }
        let mut bits = 0;
        let down = rows.start / TILE_HEIGHT..rows.end.div_ceil(TILE_HEIGHT);
        let work = (rows.len() * TILE_WIDTH / down.len().max(1)) as u32;
        // Tiles between sides that are found at once.
        for start in tiles.clone().step_by(LANES - 1) {
            let sides = std::array::from_fn(|i| (start + i) * TILE_WIDTH);
            let (least, most) = depths(sides);
            for i in 0..(tiles.end - start).min(LANES - 1) {
                let depths = || (least[i].min(least[i + 1]), most[i].max(most[i + 1]));
                if down.clone().all(|y| self.hides(pixels, start + i, y, depths)) {
                    bits |= 1 << (start + i - tiles.start);
                } else {
                    down.clone().for_each(|y| self.add_work(start + i, y, work));
                }
            }
        }
        Some(HiddenTiles { first: tiles.start, bits })
    }

    /// The next of the columns `x` of a row of the band that are not hidden, as far as they follow
    /// one another; they are taken to be drawn. `depth` gives the depth at a column; it must grow or
    /// fall along the row.
    pub(crate) fn next_visible(
        &mut self,
        pixels: &[f32],
        row: usize,
        mut x: Range<usize>,
        depth: impl Fn(usize) -> f32,
    ) -> Range<usize> {
        let y = row / TILE_HEIGHT;
        let mut start = None;
        while x.start < x.end {
            let tile = x.start / TILE_WIDTH;
            let end = x.end.min((tile + 1) * TILE_WIDTH);
            let depths = || {
                let (a, b) = (depth(x.start), depth(end - 1));
                (a.min(b), a.max(b))
            };
            if self.hides(pixels, tile, y, depths) {
                if start.is_some() {
                    break;
                }
            } else {
                start.get_or_insert(x.start);
                self.add_work(tile, y, (end - x.start) as u32);
            }
            x.start = end;
        }
        start.unwrap_or(x.start)..x.start
    }

    /// Whether nothing with a depth within `depths`, the least and the most, is seen in a tile.
    #[inline(always)]
    fn hides(
        &mut self,
        pixels: &[f32],
        x: usize,
        y: usize,
        depths: impl FnOnce() -> (f32, f32),
    ) -> bool {
        let Some(tile) = self.tiles.get(y * self.columns + x) else { return false };
        let mut farthest = tile.farthest;
        if tile.work >= TILE_WORK {
            farthest = self.farthest(pixels, x, y);
            self.tiles[y * self.columns + x] = Tile { farthest, work: 0 };
        } else if farthest.is_infinite() {
            // Most likely nothing is known yet.
            return false;
        }
        let (least, most) = depths();
        match self.order {
            Order::None => false,
            Order::Less { equal: false } => least >= farthest,
            Order::Less { equal: true } => least > farthest,
            Order::Greater { equal: false } => most <= farthest,
            Order::Greater { equal: true } => most < farthest,
        }
    }

    fn add_work(&mut self, x: usize, y: usize, work: u32) {
        if let Some(tile) = self.tiles.get_mut(y * self.columns + x) {
            tile.work = tile.work.saturating_add(work);
        }
    }

    /// The farthest depth in a tile. Depths that are not a number are passed over: they let nothing
    /// be drawn.
    #[inline(never)]
    fn farthest(&self, pixels: &[f32], x: usize, y: usize) -> f32 {
        let rows = pixels.chunks(self.width).skip(y * TILE_HEIGHT).take(TILE_HEIGHT);
        let columns = x * TILE_WIDTH..self.width.min((x + 1) * TILE_WIDTH);
        let rows = rows.filter_map(|row| row.get(columns.clone()));
        match self.order {
            Order::Greater { .. } => extreme(rows, f32::INFINITY, |a, b| if b < a { b } else { a }),
            _ => extreme(rows, f32::NEG_INFINITY, |a, b| if b > a { b } else { a }),
        }
    }
}

/// The extreme of all values, found in lanes.
#[inline(always)]
fn extreme<'a>(
    rows: impl Iterator<Item = &'a [f32]>,
    start: f32,
    choose: impl Fn(f32, f32) -> f32,
) -> f32 {
    let mut lanes = [start; LANES];
    for row in rows {
        let (blocks, rest) = row.as_chunks::<LANES>();
        for block in blocks {
            for (lane, depth) in lanes.iter_mut().zip(block) {
                *lane = choose(*lane, *depth);
            }
        }
        for (lane, depth) in lanes.iter_mut().zip(rest) {
            *lane = choose(*lane, *depth);
        }
    }
    lanes.into_iter().fold(start, choose)
}
