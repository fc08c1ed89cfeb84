//! A polygon ready for its rows: what it covers, and how its parameters run.
//!
//! This is the one place where a polygon is prepared: loaded, clipped, projected, culled; its
//! coverage found, its planes laid. There are two entries, for anything and for vertices that are known
//! to be inside of all planes; triangles of meshes have the second in a form for eight at once
//! (`surface::batch`).

use std::ops::Range;

use glam::{DVec4, Vec4};

use crate::clip::polygon::PolygonClipper;
use crate::clip::records::Records;
use crate::coverage::area::signed_area_of;
use crate::coverage::shape::Coverage;
use crate::coverage::{EdgeTable, Runs};
use crate::outline::Chain;
use crate::settings::DrawCall;
use crate::subpixel::SubpixelPoint;
use crate::surface::polygon::PolygonSurface;
use crate::surface::rows::SurfaceView;
use crate::view_volume::Outcome;

/// A polygon as clipping has left it, with its outline on the screen.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClippedPolygon {
    clipper: PolygonClipper,
    points: Vec<SubpixelPoint>,
    pub(crate) is_front: bool,
    /// Whether all values are known to be affine on it.
    pub(crate) is_affine: bool,
    /// Whether nothing of it was cut.
    is_whole: bool,
}

impl ClippedPolygon {
    /// Clips and projects a polygon of one or more contours; whether there may be something to see.
    pub(crate) fn clip<'v, C>(
        &mut self,
        call: &DrawCall<'_>,
        contours: impl Iterator<Item = C>,
    ) -> bool
    where
        C: Iterator<Item = (Vec4, &'v [f32])> + Clone,
    {
        self.clipper.start(call.params());
        for contour in contours {
            self.clipper.add_contour(contour, call.interpolation);
        }
        let sides = self.clipper.sides();
        let outcome = self.clipper.clip_to_view(call.planes, call.interpolation);
        if outcome == Outcome::Outside {
            return false;
        }
        self.is_whole = outcome == Outcome::Inside;
        self.is_affine = call.is_affine(sides, !self.is_whole);
        self.points.clear();
        let positions = self.clipper.vertices().positions().iter();
        self.points.extend(positions.map(|&p| SubpixelPoint::project(p, &call.viewport)));
        let area = signed_area_of(&self.points, self.clipper.chains());
        self.is_front = call.front_face.is_front(area > 0);
        !call.culled.leaves_out(area)
    }

    /// Whether nothing of it was cut.
    pub(crate) fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Lays planes through the parameters.
    pub(crate) fn fit(&self, call: &DrawCall<'_>, face: u32, surface: &mut PolygonSurface) {
        let (vertices, face) = (self.clipper.vertices(), (face, self.is_front));
        let is_plain =
            self.is_whole && self.is_affine && set_up_triangle(surface, call, face, vertices);
        if !is_plain {
            let (positions, params) = (vertices.positions(), vertices.all_params());
            surface.set_up(call, face, positions, params, self.is_affine);
        }
    }

    pub(crate) fn vertices(&self) -> &Records {
        self.clipper.vertices()
    }

    pub(crate) fn points(&self) -> &[SubpixelPoint] {
        &self.points
    }

    /// The chains of the points; none if they are one contour.
    pub(crate) fn chains(&self) -> &[Chain] {
        self.clipper.chains()
    }
}

/// A face ready for its rows, with the memory that it takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Primitive {
    clipped: ClippedPolygon,
    records: Records,
    points: Vec<SubpixelPoint>,
    edges: EdgeTable,
    surface: PolygonSurface,
}

impl Primitive {
    /// Prepares any polygon, in the given rows. Returns whether any pixel may be covered.
    pub(crate) fn prepare<'v, C>(
        &mut self,
        call: &DrawCall<'_>,
        face: u32,
        contours: impl Iterator<Item = C>,
        rows: &Range<i32>,
    ) -> bool
    where
        C: Iterator<Item = (Vec4, &'v [f32])> + Clone,
    {
        let Self { clipped, edges, surface, .. } = self;
        if !clipped.clip(call, contours) {
            return false;
        }
        edges.fill_rule = call.fill_rule;
        edges.set_rule(call.coverage_rule, &call.window.columns);
        edges.fill_chains(clipped.points(), clipped.chains(), rows.clone());
        if edges.is_empty() {
            return false;
        }
        clipped.fit(call, face, surface);
        true
    }

    /// Prepares a face of vertices that are inside of all planes, whose places on the screen are known.
    #[inline(never)]
    pub(crate) fn prepare_inside<'v>(
        &mut self,
        call: &DrawCall<'_>,
        face: u32,
        corners: impl Iterator<Item = (Vec4, &'v [f32], SubpixelPoint)>,
        rows: &Range<i32>,
    ) {
        let Self { records, points, edges, surface, .. } = self;
        records.clear(call.params());
        points.clear();
        for (position, params, point) in corners {
            records.push(position, params, call.interpolation);
            points.push(point);
        }
        edges.fill_rule = call.fill_rule;
        edges.set_rule(call.coverage_rule, &call.window.columns);
        edges.fill(points, rows.clone());
        let is_front = call.front_face.is_front(signed_area_of(points, &[]) > 0);
        if !set_up_triangle(surface, call, (face, is_front), records) {
            let is_affine = call.is_affine(records.len(), false);
            let (positions, params) = (records.positions(), records.all_params());
            surface.set_up(call, (face, is_front), positions, params, is_affine);
        }
    }

    /// Prepares a polygon that was clipped before.
    pub(crate) fn prepare_clipped(
        &mut self,
        call: &DrawCall<'_>,
        face: u32,
        polygon: &StoredPolygon<'_>,
        rows: &Range<i32>,
    ) {
        let Self { edges, surface, .. } = self;
        let (positions, params) = polygon.vertices;
        edges.fill_rule = call.fill_rule;
        edges.set_rule(call.coverage_rule, &call.window.columns);
        edges.fill_chains(polygon.points, polygon.chains, rows.clone());
        let face = (face, polygon.is_front);
        surface.set_up(call, face, positions, params, polygon.is_affine);
    }

    /// How the parameters run, and what is covered.
    #[inline(always)]
    pub(crate) fn parts(&mut self) -> (SurfaceView<'_>, Coverage<'_>) {
        (self.surface.view(), self.edges.coverage())
    }

    /// The places of the corners, after [`prepare_inside`](Self::prepare_inside).
    pub(crate) fn points(&self) -> &[SubpixelPoint] {
        &self.points
    }

    /// The polygon as clipping has left it, after [`prepare`](Self::prepare).
    pub(crate) fn clipped(&self) -> &ClippedPolygon {
        &self.clipped
    }

    /// How the parameters run, and the runs of what is covered.
    pub(crate) fn surface_and_runs(&mut self) -> (SurfaceView<'_>, Runs<'_>) {
        (self.surface.view(), self.edges.runs())
    }
}

/// A clipped polygon in a list of them.
#[derive(Clone, Debug)]
pub(crate) struct StoredPolygon<'a> {
    /// The positions of its vertices, and their parameters, end to end.
    pub(crate) vertices: (&'a [DVec4], &'a [f64]),
    pub(crate) points: &'a [SubpixelPoint],
    pub(crate) chains: &'a [Chain],
    pub(crate) is_front: bool,
    pub(crate) is_affine: bool,
}

/// Sets a polygon up as a triangle, if it is one and its planes suffice: whether they do.
fn set_up_triangle(
    surface: &mut PolygonSurface,
    call: &DrawCall<'_>,
    face: (u32, bool),
    vertices: &Records,
) -> bool {
    match vertices.positions().first_chunk() {
        // Where pixels' centres lie outside, its edges have to be known.
        _ if call.coverage_rule.is_outer() => false,
        Some(positions) if vertices.len() == 3 => {
            surface.set_up_triangle(call, face, positions, vertices.all_params())
        }
        _ => false,
    }
}
