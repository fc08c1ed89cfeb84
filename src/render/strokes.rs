//! Lines and points being drawn.
//!
//! 1. Lines are taken in chunks. Each segment is clipped and projected (`render::strokes::segment`);
//!    what it covers is a line of width 1 by the diamond-exit rule (`coverage::line`), or a polygon on the
//!    screen (`render::strokes::wide`).
//! 2. The target is cut into bands of rows, each drawn by one thread, its segments in the order in which
//!    they were given. From here on they are runs of pixels like those of polygons.
//!
//! The memory that this takes is kept: some 250 + 16 N bytes a segment that is in view.

mod segment;
mod wide;

use std::ops::Range;

use fearless_simd::{Level, Simd};
use glam::{DVec2, DVec4, Vec4};

use crate::coverage::line::LinePixels;
use crate::coverage::run::{ROWS, RunGroup};
use crate::coverage::{EdgeTable, FillRule, Run};
use crate::project::ScreenPoint;
use crate::render::band::Band;
use crate::render::faces::FaceList;
use crate::render::geometry::Batch;
use crate::render::mesh::bins::BAND;
use crate::render::parallel::{Bands, Shading, first, for_each, for_each_band};
use crate::render::raster::plan::Plan;
use crate::render::raster::{self, RasterMemory};
use crate::render::shader::ShadeBlocks;
use crate::render::stroke_style::{Figure, LineStyle, PointStyle};
use crate::render::strokes::segment::{Segment, screen_point};
use crate::render::strokes::wide::{Corner, End, push_cap, push_end};
use crate::round::{ROUND, integer};
use crate::settings::DrawCall;
use crate::simd::for_level;
use crate::subpixel::{HALF_PIXEL, SUBPIXELS, SubpixelPoint, first_centre};
use crate::surface::line::{LineSurface, LineValues, Slope};
use crate::vertices::Vertices;
use crate::view_volume::ViewVolume;

/// Lists of indices in a chunk, or points.
const CHUNK: usize = if cfg!(test) { 4 } else { 1024 };

/// The largest width of a line and size of a point, in pixels.
const MAX_WIDTH: f64 = 4096.0;

/// How far, in subpixels, a corner may lie from the origin.
const FARTHEST: f64 = (1 << 26) as f64;

/// Lines and points that are ready to be drawn, with the memory that this takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Strokes {
    chunks: Vec<Chunk>,
    used: usize,
    workers: Vec<Worker>,
}

/// Some neighbouring lines or points.
#[derive(Clone, Debug, Default)]
struct Chunk {
    pieces: Vec<Piece>,
    /// The parameters at both ends of each piece.
    params: Vec<f64>,
    /// The outlines of wide segments.
    points: Vec<SubpixelPoint>,
    /// The rows that the pieces extend over.
    rows: Range<i32>,
    segment: Segment,
    wide: Vec<WideSegment>,
    outline: Vec<DVec2>,
}

/// What is drawn of one segment or point.
#[derive(Clone, Debug)]
struct Piece {
    number: u32,
    shape: Shape,
    rows: Range<i32>,
    slope: Slope,
    ends: [(ScreenPoint, f64); 2],
}

/// What a piece covers.
#[derive(Clone, Debug)]
enum Shape {
    Line(LinePixels),
    /// Some of the chunk's points.
    Outline(Range<usize>),
    /// The middle of a round point and its diameter in subpixels.
    Disk(SubpixelPoint, i64),
}

/// A segment of a wide line on the screen.
#[derive(Clone, Copy, Debug)]
struct WideSegment {
    ends: [DVec2; 2],
    direction: DVec2,
    length: f64,
    /// Whether the ends are the line's own vertices, where it may go on.
    is_own: [bool; 2],
    piece: usize,
}

/// The memory for drawing one band.
#[derive(Clone, Debug, Default)]
struct Worker {
    surface: LineSurface,
    edges: EdgeTable,
    raster: RasterMemory,
}

impl Strokes {
    /// Makes lines and points ready; whether that is what the batch has.
    pub(crate) fn prepare(&mut self, call: &DrawCall<'_>, batch: &Batch<'_>) -> bool {
        self.used = 0;
        let (vertices, lists) = (batch.vertices, batch.faces);
        let figure = batch.figure;
        let count = match figure {
            Figure::Faces => return false,
            Figure::Lines(_) => lists.len(),
            Figure::Points(_) => vertices.len(),
        };
        self.used = count.div_ceil(CHUNK);
        for_each(first(&mut self.chunks, self.used), |i, chunk| {
            chunk.clear();
            for number in i * CHUNK..count.min((i + 1) * CHUNK) {
                match &figure {
                    Figure::Faces => {}
                    Figure::Lines(style) => chunk.add_line(call, vertices, (lists, number), style),
                    Figure::Points(style) => chunk.add_point(call, vertices, number as u32, *style),
                }
            }
        });
        true
    }

    /// Draws what was made ready.
    pub(crate) fn draw(
        &mut self,
        call: &DrawCall<'_>,
        (level, plan): (Level, Plan),
        target: &mut Band<'_>,
        shading: Shading<'_>,
    ) {
        let Self { chunks, used, workers } = self;
        if *used == 0 {
            return;
        }
        let chunks = &chunks[..*used];
        let workers = first(workers, target.rows().len().div_ceil(BAND as usize));
        let bands = Bands::of(target, BAND as usize);
        for_each_band(target, bands, workers, shading, &|_, band, worker, shader| {
            let rows = call.window.rows_within(&band.rows());
            let touches = |of: &Range<i32>| of.start < rows.end && rows.start < of.end;
            for_level!(level, simd => {
                for chunk in chunks.iter().filter(|chunk| touches(&chunk.rows)) {
                    for (i, piece) in chunk.pieces.iter().enumerate() {
                        if touches(&piece.rows) {
                            worker.draw(simd, (call, plan), (chunk, i), &rows, band, shader);
                        }
                    }
                }
            });
        });
    }
}

impl Chunk {
    fn clear(&mut self) {
        self.pieces.clear();
        self.params.clear();
        self.points.clear();
        self.rows = 0..0;
    }

    /// Adds the segments of a line.
    fn add_line(
        &mut self,
        call: &DrawCall<'_>,
        vertices: &dyn Vertices,
        (lists, line): (&FaceList, usize),
        style: &LineStyle,
    ) {
        let (indices, number) = (lists.get(line), lists.number(line as u32));
        if indices.iter().any(|&i| i as usize >= vertices.len()) {
            return;
        }
        self.wide.clear();
        let last = indices.last().filter(|_| style.is_closed && indices.len() > 1);
        let ends = indices.iter().skip(1);
        let back = indices.first().filter(|_| last.is_some());
        for (a, b) in indices.iter().zip(ends.chain(back)) {
            let (Some(a), Some(b)) = (vertices.get(*a), vertices.get(*b)) else { continue };
            if self.segment.clip(call, [a, b]) {
                match style.width {
                    None => self.add_thin(call, number),
                    Some(width) => self.add_wide(call, number, width),
                }
            }
        }
        self.outline_wide(call, style);
    }

    /// Adds a piece of the segment, of a shape that is yet to be found, with the values of two of its ends.
    fn push(&mut self, call: &DrawCall<'_>, number: u32, ends: [usize; 2], slope: Slope) {
        let values = self.segment.values(call);
        let values = ends.map(|end| values[end]);
        for end in values {
            self.params.extend_from_slice(end.params);
        }
        let ends = values.map(|end| (end.point, end.w));
        let shape = Shape::Outline(0..0);
        self.pieces.push(Piece { number, shape, rows: 0..0, slope, ends });
    }

    /// Adds a piece with the values that another has at one of its ends.
    fn push_again(&mut self, call: &DrawCall<'_>, piece: usize, end: usize) {
        let n = call.params();
        let first = (2 * piece + end) * n;
        for _ in 0..2 {
            self.params.extend_from_within(first..first + n);
        }
        let Piece { number, ends, .. } = &self.pieces[piece];
        let (number, ends) = (*number, [ends[end]; 2]);
        let (shape, slope) = (Shape::Outline(0..0), Slope::Nowhere);
        self.pieces.push(Piece { number, shape, rows: 0..0, slope, ends });
    }

    /// Gives a piece its shape.
    fn take_shape(&mut self, piece: usize, shape: Shape, rows: Range<i32>) {
        if !rows.is_empty() {
            let all = if self.rows.is_empty() { rows.clone() } else { self.rows.clone() };
            self.rows = all.start.min(rows.start)..all.end.max(rows.end);
        }
        let piece = &mut self.pieces[piece];
        (piece.shape, piece.rows) = (shape, rows);
    }

    /// Adds the segment as a line of width 1.
    fn add_thin(&mut self, call: &DrawCall<'_>, number: u32) {
        let [a, b] = self.segment.points(call);
        let Some(line) = LinePixels::new(a, b, self.segment.line_ends(call)) else { return };
        // Beyond its ends, as they are before they are rounded, there is one pixel at most. It has the
        // end's values.
        let slope = if line.is_wide() { Slope::Columns } else { Slope::Rows };
        let values = self.segment.values(call);
        let along = |end: usize| {
            let point = values[end].point;
            if line.is_wide() { point.x } else { point.y }
        };
        let ends = if along(0) <= along(1) { [0, 1] } else { [1, 0] };
        let [before, body, after] = line.parts(ends.map(along));
        for (part, ends, slope) in [
            (before, [ends[0]; 2], Slope::Nowhere),
            (body, [0, 1], slope),
            (after, [ends[1]; 2], Slope::Nowhere),
        ] {
            let Some(part) = part else { continue };
            let (window, columns) = (&call.window, part.columns());
            let is_seen = columns.start < window.columns.end && window.columns.start < columns.end;
            let rows = part.rows(&window.rows);
            if is_seen && !rows.is_empty() {
                self.push(call, number, ends, slope);
                self.take_shape(self.pieces.len() - 1, Shape::Line(part), rows);
            }
        }
    }

    /// Adds the segment as one of a wide line, if it has a length; its outline follows.
    fn add_wide(&mut self, call: &DrawCall<'_>, number: u32, width: f32) {
        if width.is_nan() || width <= 0.0 {
            return;
        }
        let ends = self.segment.values(call).map(|end| DVec2::new(end.point.x, end.point.y));
        let along = ends[1] - ends[0];
        let length = along.length();
        if length.is_nan() || length < 1e-9 {
            return;
        }
        let (is_own, piece) = (self.segment.has_own_ends(), self.pieces.len());
        self.wide.push(WideSegment { ends, direction: along / length, length, is_own, piece });
        self.push(call, number, [0, 1], Slope::Along);
    }

    /// Finds the outlines of a wide line: of its segments, its joins and its caps.
    fn outline_wide(&mut self, call: &DrawCall<'_>, style: &LineStyle) {
        let half = f64::from(style.width.unwrap_or(0.0)).min(MAX_WIDTH) * 0.5;
        let wide = std::mem::take(&mut self.wide);
        let Some(last) = wide.len().checked_sub(1) else { return };
        let corner_before = |i: usize| {
            let before = i.checked_sub(1).or(style.is_closed.then_some(last))?;
            corner(&wide[before], &wide[i], half)
        };
        for (i, segment) in wide.iter().enumerate() {
            let start = corner_before(i);
            let end = if i < last { Some(i + 1) } else { style.is_closed.then_some(0) };
            let end = end.and_then(corner_before);
            let WideSegment { ends, direction, piece, is_own, .. } = *segment;
            let [backward, forward] = [start.map(Corner::reversed), end]
                .map(|corner| corner.map_or(End::Last, End::Corner));
            self.outline.clear();
            push_end(&mut self.outline, ends[0], -direction, half, &backward);
            push_end(&mut self.outline, ends[1], direction, half, &forward);
            self.take_outline(call, piece);
            if let Some(corner) = start {
                self.outline.clear();
                corner.push_join(&mut self.outline, half, style.join);
                self.add_outline(call, piece, 0);
            }
            // Where a plane has cut it, a line does not end.
            let is_end = [is_own[0] && start.is_none(), is_own[1] && end.is_none()];
            for (end, direction) in [(0, -direction), (1, direction)] {
                if is_end[end] {
                    self.outline.clear();
                    push_cap(&mut self.outline, ends[end], direction, half, style.cap);
                    self.add_outline(call, piece, end);
                }
            }
        }
        self.wide = wide;
    }

    /// Adds the outline as a piece with the values that another has at one of its ends.
    fn add_outline(&mut self, call: &DrawCall<'_>, piece: usize, end: usize) {
        if self.outline.len() > 2 {
            self.push_again(call, piece, end);
            self.take_outline(call, self.pieces.len() - 1);
        }
    }

    /// Rounds the outline of a piece.
    fn take_outline(&mut self, call: &DrawCall<'_>, piece: usize) {
        let first = self.points.len();
        let subpixels = |c: f64| {
            let c = (c * f64::from(SUBPIXELS)).clamp(-FARTHEST, FARTHEST);
            integer(c + ROUND)
        };
        let point = |p: &DVec2| SubpixelPoint { x: subpixels(p.x), y: subpixels(p.y) };
        self.points.extend(self.outline.iter().map(point));
        let range = first..self.points.len();
        let extent = call.window.extent(self.points[range.clone()].iter().copied());
        let rows = extent.map_or(0..0, |(_, rows)| rows);
        self.take_shape(piece, Shape::Outline(range), rows);
    }

    /// Adds a point.
    fn add_point(
        &mut self,
        call: &DrawCall<'_>,
        vertices: &dyn Vertices,
        number: u32,
        style: PointStyle,
    ) {
        let Some((position, params)) = vertices.get(number) else { return };
        let Some(position) = inside(call, position) else { return };
        if style.size.is_nan() || style.size <= 0.0 {
            return;
        }
        let SubpixelPoint { x, y } = SubpixelPoint::project(position, &call.viewport);
        let size = f64::from(style.size).min(MAX_WIDTH) * f64::from(SUBPIXELS);
        let size = integer(size + ROUND).max(1);
        let corner = |c: i32| [c - size / 2, c - size / 2 + size];
        let ([left, right], [top, bottom]) = (corner(x), corner(y));
        let square = [(left, top), (right, top), (right, bottom), (left, bottom)]
            .map(|(x, y)| SubpixelPoint { x, y });
        // A round point has its own pixel at least.
        let (margin, is_disk) = (SUBPIXELS / 2, style.is_round && size > SUBPIXELS);
        let own = [(x - margin, y - margin), (x + margin, y + margin)];
        let own = own.map(|(x, y)| SubpixelPoint { x, y });
        let extent =
            call.window.extent(square.into_iter().chain(own.into_iter().filter(|_| is_disk)));
        let Some((_, rows)) = extent else { return };
        let shape = if is_disk {
            Shape::Disk(SubpixelPoint { x, y }, size.into())
        } else {
            let first = self.points.len();
            self.points.extend(square);
            Shape::Outline(first..self.points.len())
        };
        let end = (screen_point(call, position), position.w);
        for _ in 0..2 {
            self.params.extend(params.iter().map(|&param| f64::from(param)));
        }
        let (slope, piece) = (Slope::Nowhere, self.pieces.len());
        self.pieces.push(Piece { number, shape: shape.clone(), rows: 0..0, slope, ends: [end; 2] });
        self.take_shape(piece, shape, rows);
    }

    /// The values at the ends of a piece.
    fn values(&self, piece: usize, params: usize) -> [LineValues<'_>; 2] {
        let first = 2 * piece * params;
        let [a, b] = self.pieces[piece].ends;
        let both = &self.params[first..first + 2 * params];
        let (of_a, of_b) = both.split_at(params);
        [
            LineValues { point: a.0, w: a.1, params: of_a },
            LineValues { point: b.0, w: b.1, params: of_b },
        ]
    }
}

impl Worker {
    /// Draws a piece in some rows.
    #[inline(always)]
    fn draw<S: Simd>(
        &mut self,
        simd: S,
        (call, plan): (&DrawCall<'_>, Plan),
        (chunk, number): (&Chunk, usize),
        rows: &Range<i32>,
        band: &mut Band<'_>,
        shader: &mut dyn ShadeBlocks,
    ) {
        let Self { surface, edges, raster } = self;
        let piece = &chunk.pieces[number];
        let values = chunk.values(number, call.params());
        surface.set_up(call, piece.number, values, piece.slope);
        let (view, columns) = (surface.view(), &call.window.columns);
        let mut draw = |group: &RunGroup| {
            raster::draw_runs(simd, plan, (&view, group), columns, band, raster, shader);
        };
        let mut rows = piece.rows.start.max(rows.start)..piece.rows.end.min(rows.end);
        match &piece.shape {
            Shape::Line(line) => {
                while !rows.is_empty() {
                    draw(&line.group(&rows));
                    rows.start += ROWS as i32;
                }
            }
            Shape::Outline(points) => {
                edges.fill_rule = FillRule::NonZero;
                edges.fill(&chunk.points[points.clone()], rows);
                edges.coverage().for_each_group(false, draw);
            }
            Shape::Disk(centre, diameter) => {
                for y in rows {
                    let x = disk_run(*centre, *diameter, y);
                    draw(&RunGroup::of(&Run { y, x, edges: [0; 2] }));
                }
            }
        }
    }
}

/// The corner between two segments, if the second goes on where the first ends.
fn corner(a: &WideSegment, b: &WideSegment, half: f64) -> Option<Corner> {
    let is_one_place = a.ends[1].distance(b.ends[0]) < 1e-6;
    let is_corner = a.is_own[1] && b.is_own[0] && is_one_place && a.piece != b.piece;
    let (directions, lengths) = ([a.direction, b.direction], [a.length, b.length]);
    is_corner.then(|| Corner::new(b.ends[0], directions, lengths, half))
}

/// A position, if it is inside of all planes.
fn inside(call: &DrawCall<'_>, position: Vec4) -> Option<DVec4> {
    let position = position.as_dvec4();
    let volume = ViewVolume::new(call.clip_space, &call.viewport, call.planes);
    volume.outcode(position).is_inside().then_some(position)
}

/// The columns of a row whose centres are nearer than half a diameter to a point, and that of the
/// pixel in which the point lies.
fn disk_run(centre: SubpixelPoint, diameter: i64, y: i32) -> Range<i32> {
    let pixel = |c: i32| first_centre(c - SUBPIXELS / 2);
    let own = if y == pixel(centre.y) { pixel(centre.x)..pixel(centre.x) + 1 } else { 0..0 };
    let dy = i64::from(y) * i64::from(SUBPIXELS) + HALF_PIXEL - i64::from(centre.y);
    // 4 dx^2 is less than this.
    let bound = diameter * diameter - 4 * dy * dy;
    if bound <= 0 {
        return own;
    }
    let reach = ((bound - 1) / 4).isqrt() as i32;
    let columns = first_centre(centre.x - reach)..first_centre(centre.x + reach + 1);
    if own.is_empty() {
        return columns;
    }
    columns.start.min(own.start)..columns.end.max(own.end)
}
