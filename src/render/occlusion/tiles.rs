//! Tiles of pixels with bounds for what is seen in them.

use std::ops::Range;

use crate::coverage::run::{ROWS, RunGroup};
use crate::render::shader::{
    BandDepths, PartBlocks, Patch, ShadeBlocks, ShadeOnThreads, WholeBlocks,
};
use crate::surface::mixed::Component;
use crate::surface::rows::SurfaceView;

/// Columns of a tile: the bits of a number.
pub(super) const TILE_WIDTH: usize = 32;

/// Rows of a tile. The bands that threads draw have whole tiles.
pub(super) const TILE_HEIGHT: usize = 8;

/// A bit for each pixel of a tile, row by row, from the left.
type Mask = [u32; TILE_HEIGHT];

/// A part of a polygon's depths that rounding may have added to them in `f32`, and may take off here: sixteen
/// units in the last place.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// The tiles of a picture.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    tiles: Vec<Tile>,
    /// Tiles in a row.
    columns: usize,
    /// In pixels.
    size: (usize, usize),
}

#[derive(Clone, Copy, Debug)]
struct Tile {
    /// The pixels where nothing is farther than `near`.
    mask: Mask,
    near: f32,
    /// Nothing is farther at any pixel. It is not less than `near`.
    far: f32,
}

impl Tile {
    const EMPTY: Self =
        Self { mask: [0; TILE_HEIGHT], near: f32::NEG_INFINITY, far: f32::INFINITY };

    /// Takes pixels at which nothing is farther than `farthest`. `outside` are those that the picture does not
    /// have.
    #[inline(always)]
    fn cover(&mut self, covered: &Mask, farthest: f32, outside: impl Fn() -> Mask) {
        // What has been gathered is given up for what is nearer by more than it has gained over the tile's far
        // bound: else a single far pixel would spoil the bound of all that come after it (section 3.2).
        if self.near - farthest > self.far - self.near {
            (self.mask, self.near) = (outside(), f32::NEG_INFINITY);
        }
        self.near = self.near.max(farthest);
        let mut all = u32::MAX;
        for (row, covered) in self.mask.iter_mut().zip(covered) {
            *row |= covered;
            all &= *row;
        }
        if all == u32::MAX {
            (self.far, self.near, self.mask) = (self.near, f32::NEG_INFINITY, outside());
        }
    }

    /// Takes all pixels, at which nothing is farther than `farthest`.
    #[inline(always)]
    fn cover_all(&mut self, farthest: f32, outside: impl Fn() -> Mask) {
        self.far = farthest;
        if self.near >= farthest {
            (self.mask, self.near) = (outside(), f32::NEG_INFINITY);
        }
    }

    /// Whether nothing from `nearest` on is seen at some pixels.
    #[inline(always)]
    fn hides(&self, pixels: &Mask, nearest: f64) -> bool {
        if f64::from(self.far) < nearest {
            return true;
        }
        let is_beside = pixels.iter().zip(&self.mask).any(|(pixels, mask)| pixels & !mask != 0);
        !is_beside && f64::from(self.near) < nearest
    }
}

/// The bits of some columns of a tile in each row.
#[inline(always)]
fn bits(start: i32, end: i32) -> u32 {
    let ones = |count: i32| (1u64 << count.clamp(0, TILE_WIDTH as i32)) - 1;
    (ones(end) & !ones(start)) as u32
}

impl Tiles {
    /// Tiles in which nothing hides anything, if there is memory for them.
    pub(super) fn new(width: usize, height: usize) -> Option<Self> {
        let columns = width.div_ceil(TILE_WIDTH);
        let mut tiles = Vec::new();
        tiles.try_reserve_exact(columns * height.div_ceil(TILE_HEIGHT)).ok()?;
        let mut empty = Self { tiles, columns, size: (width, height) };
        empty.clear();
        Some(empty)
    }

    pub(super) fn clear(&mut self) {
        let (_, height) = self.size;
        let rows = height.div_ceil(TILE_HEIGHT);
        self.tiles.clear();
        for y in 0..rows {
            let tile = |x| Tile { mask: outside(self.size, x, y), ..Tile::EMPTY };
            self.tiles.extend((0..self.columns).map(tile));
        }
    }

    /// Columns and rows, in pixels.
    pub(super) fn size(&self) -> (usize, usize) {
        self.size
    }

    /// What covers tiles. `is_reversed` says whether greater depth is nearer.
    pub(super) fn painter(&mut self, is_reversed: bool) -> TilePainter<'_> {
        let Self { tiles, columns, size } = self;
        TilePainter { tiles, columns: *columns, size: *size, first_row: 0, is_reversed }
    }

    /// Whether nothing from `nearest` on is seen at the pixels of some columns and rows, as far as the picture
    /// has them.
    pub(super) fn hides(&self, columns: [f64; 2], rows: [f64; 2], nearest: f64) -> bool {
        let within = |[first, end]: [f64; 2], size: usize| {
            let inside = |pixel: f64| pixel.clamp(0.0, size as f64) as usize;
            inside(first)..inside(end)
        };
        let (columns, rows) = (within(columns, self.size.0), within(rows, self.size.1));
        if columns.is_empty() || rows.is_empty() {
            return true;
        }
        let tiles = |range: &Range<usize>, size| range.start / size..range.end.div_ceil(size);
        tiles(&rows, TILE_HEIGHT).all(|y| {
            tiles(&columns, TILE_WIDTH).all(|x| {
                let Some(tile) = self.tiles.get(y * self.columns + x) else { return false };
                let left = (x * TILE_WIDTH) as i32;
                let row = bits(columns.start as i32 - left, columns.end as i32 - left);
                let top = y * TILE_HEIGHT;
                let mask = std::array::from_fn(|i| if rows.contains(&(top + i)) { row } else { 0 });
                tile.hides(&mask, nearest)
            })
        })
    }
}

/// The pixels of a tile that a picture of a size does not have.
fn outside((width, height): (usize, usize), x: usize, y: usize) -> Mask {
    let inside = bits(0, (width - (x * TILE_WIDTH).min(width)).min(TILE_WIDTH) as i32);
    std::array::from_fn(|row| if y * TILE_HEIGHT + row < height { !inside } else { u32::MAX })
}

/// Covers tiles, all of a picture's or those of some rows.
pub(super) struct TilePainter<'a> {
    tiles: &'a mut [Tile],
    columns: usize,
    size: (usize, usize),
    /// The row of pixels that the tiles begin with.
    first_row: usize,
    is_reversed: bool,
}

impl TilePainter<'_> {
    /// Covers the pixels of some runs in a row of tiles: `runs` in each row of the tiles, empty where there
    /// are none.
    #[inline(always)]
    fn cover_row(&mut self, y: usize, runs: &[[i32; 2]; TILE_HEIGHT], depth: &RowDepths) {
        let (mut left, mut right) = (i32::MAX, i32::MIN);
        // The columns that all rows have.
        let (mut inner_left, mut inner_right) = (i32::MIN, i32::MAX);
        for [start, end] in runs {
            if start < end {
                (left, right) = (left.min(*start), right.max(*end));
            }
            (inner_left, inner_right) = (inner_left.max(*start), inner_right.min(*end));
        }
        if left >= right {
            return;
        }
        let first = y.wrapping_sub(self.first_row / TILE_HEIGHT).wrapping_mul(self.columns);
        let columns = left as usize / TILE_WIDTH..(right as usize).div_ceil(TILE_WIDTH);
        let range = first.wrapping_add(columns.start)..first.wrapping_add(columns.end);
        let Some(tiles) = self.tiles.get_mut(range) else { return };
        for (tile, x) in tiles.iter_mut().zip(columns) {
            let tile_left = (x * TILE_WIDTH) as i32;
            let tile_right = tile_left + TILE_WIDTH as i32;
            let farthest = depth.farthest(left.max(tile_left), right.min(tile_right));
            if farthest >= tile.far {
                continue;
            }
            let outside = || outside(self.size, x, y);
            if inner_left <= tile_left && tile_right <= inner_right {
                tile.cover_all(farthest, outside);
                continue;
            }
            let mut covered = [0; TILE_HEIGHT];
            for (covered, [start, end]) in covered.iter_mut().zip(runs) {
                *covered = bits(start - tile_left, end - tile_left);
            }
            if covered != [0; TILE_HEIGHT] {
                tile.cover(&covered, farthest, outside);
            }
        }
    }
}

/// The depths of a polygon in a row of tiles, as what grows with the distance.
struct RowDepths {
    /// The most at the column 0 of the framebuffer, and the change per column.
    at: f64,
    change: f64,
    least: f32,
    most: f32,
}

impl RowDepths {
    fn new(surface: &SurfaceView<'_>, is_reversed: bool, tile_row: usize) -> Self {
        let base = surface.base;
        let sign = if is_reversed { -1.0 } else { 1.0 };
        let (least, most) =
            if is_reversed { (-base.z_range.1, -base.z_range.0) } else { base.z_range };
        let [value, change, down] = [base.z.value, base.z.dx, base.z.dy].map(|z| sign * z);
        let is_by_edges = surface.mixed.is_some_and(|mixed| mixed.is_by_edges(Component::Z));
        if is_by_edges || !(value + change + down).is_finite() {
            return Self { at: f64::INFINITY, change: 0.0, least, most };
        }
        let (corner_x, corner_y) = base.corner;
        let centre =
            |pixel: i32, corner: i32, origin: f64| f64::from(pixel - corner) + 0.5 - origin;
        let top = (tile_row * TILE_HEIGHT) as i32;
        let rows =
            [top, top + TILE_HEIGHT as i32 - 1].map(|y| centre(y, corner_y, base.origin[1]) * down);
        // A centre may lie outside of the polygon, where a steep plane is far from its range.
        let size = f64::from(least.abs() + most.abs()) + change.abs() + down.abs();
        let rounding = size * ROUNDING;
        let at = value + change * centre(0, corner_x, base.origin[0]) + rows[0].max(rows[1]);
        Self { at: at + rounding, change, least, most }
    }

    /// What no pixel of some columns of the framebuffer is farther than.
    #[inline(always)]
    fn farthest(&self, left: i32, right: i32) -> f32 {
        let column = if self.change > 0.0 { right - 1 } else { left };
        ((self.at + self.change * f64::from(column)) as f32).max(self.least).min(self.most)
    }
}

impl ShadeBlocks for TilePainter<'_> {
    fn draw_whole(&mut self, _: &Patch<'_>, _: WholeBlocks, _: &mut [f32]) -> usize {
        0
    }

    fn draw_parts(&mut self, _: &Patch<'_>, _: PartBlocks<'_>, _: u32, _: BandDepths<'_>) -> u32 {
        0
    }

    fn prefetch(&self, _: Range<usize>) {}

    fn cover(&mut self, surface: &SurfaceView<'_>, runs: &RunGroup, columns: &Range<i32>) {
        let (corner_x, corner_y) = surface.base.corner;
        let first = runs.y + corner_y;
        // Rows of a group lie in two rows of tiles at most.
        let mut y = first as usize / TILE_HEIGHT;
        let mut row = 0;
        while row < runs.len.min(ROWS) {
            let mut of_tiles = [[0; 2]; TILE_HEIGHT];
            let top = (y * TILE_HEIGHT) as i32;
            while row < runs.len.min(ROWS) && first + (row as i32) < top + TILE_HEIGHT as i32 {
                let start = runs.start[row].max(columns.start) + corner_x;
                let end = runs.end[row].min(columns.end) + corner_x;
                of_tiles[(first + row as i32 - top) as usize % TILE_HEIGHT] =
                    [start, end.max(start)];
                row += 1;
            }
            let depth = RowDepths::new(surface, self.is_reversed, y);
            self.cover_row(y, &of_tiles, &depth);
            y += 1;
        }
    }
}

impl ShadeOnThreads for TilePainter<'_> {
    fn split(
        &mut self,
        row: usize,
        f: &mut dyn FnMut(&mut dyn ShadeOnThreads, &mut dyn ShadeOnThreads),
    ) {
        let &mut Self { columns, size, first_row, is_reversed, .. } = self;
        let middle = (row.saturating_sub(first_row) / TILE_HEIGHT * columns).min(self.tiles.len());
        let (before, after) = self.tiles.split_at_mut(middle);
        f(
            &mut TilePainter { tiles: before, columns, size, first_row, is_reversed },
            &mut TilePainter { tiles: after, columns, size, first_row: row, is_reversed },
        );
    }
}
