//! The vertices of a mesh on the screen, projected once each, whatever their faces are.

use fearless_simd::Level;
use glam::{DVec4, Mat4, Vec4};

use crate::render::parallel::for_each_part;
use crate::settings::DrawCall;
use crate::simd::for_level;
use crate::subpixel::SubpixelPoint;
use crate::vertices::Vertices;
use crate::view_volume::{Outcode, Outcome, ViewVolume};

/// Vertices projected by one thread at a time.
const PART: usize = if cfg!(test) { 16 } else { 4096 };

/// Positions that are copied at a time.
const COPIED: usize = 64;

/// The places of vertices on the screen, and where they are as seen from the planes.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProjectedVertices {
    pub(crate) points: Vec<SubpixelPoint>,
    /// If a position is not finite, one that is not inside, so that the clipper sees it.
    pub(crate) outcodes: Vec<Outcode>,
    /// Whether all are inside.
    pub(crate) all_inside: bool,
}

impl ProjectedVertices {
    /// Replaces the vertices.
    pub(crate) fn project(&mut self, call: &DrawCall<'_>, level: Level, vertices: &dyn Vertices) {
        let volume = ViewVolume::new(call.clip_space, &call.viewport, call.planes);
        let Self { points, outcodes, all_inside } = self;
        points.resize(vertices.len(), SubpixelPoint::default());
        outcodes.resize(vertices.len(), Outcode::default());
        let any_outside = std::sync::atomic::AtomicBool::new(false);
        for_each_part((points, PART), (outcodes, PART), |part, points, outcodes| {
            let mut inside = true;
            for_level!(level, _simd => {
                inside = project_some(call, &volume, vertices, part * PART, points, outcodes);
            });
            if !inside {
                any_outside.store(true, std::sync::atomic::Ordering::Relaxed);
            }
        });
        *all_inside = !any_outside.into_inner();
    }

    /// What clipping makes of a face; outside if it has fewer than three corners or an index is too
    /// large.
    pub(crate) fn outcome(&self, indices: &[u32]) -> Outcome {
        if indices.len() < 3 || indices.iter().any(|&i| i as usize >= self.points.len()) {
            return Outcome::Outside;
        }
        Outcode::outcome(indices.iter().map(|&i| self.outcodes[i as usize])).0
    }

    /// The places of a face's corners, whose indices must be in range.
    #[inline(always)]
    pub(crate) fn points_of(&self, indices: &[u32]) -> impl Iterator<Item = SubpixelPoint> + Clone {
        indices.iter().map(|&i| self.points[i as usize])
    }
}

/// Projects some of the vertices; whether all are inside.
#[inline(always)]
fn project_some(
    call: &DrawCall<'_>,
    volume: &ViewVolume<'_>,
    vertices: &dyn Vertices,
    first: usize,
    points: &mut [SubpixelPoint],
    outcodes: &mut [Outcode],
) -> bool {
    let mut inside = true;
    let mut positions = [Vec4::ZERO; COPIED];
    let parts = points.chunks_mut(COPIED).zip(outcodes.chunks_mut(COPIED));
    for (part, (points, outcodes)) in parts.enumerate() {
        vertices.copy_positions(first + part * COPIED, &mut positions[..points.len()]);
        let axes = side_by_side(&positions);
        let position = |i: usize| {
            let [x, y, z, w] = [axes[0][i], axes[1][i], axes[2][i], axes[3][i]].map(f64::from);
            DVec4::new(x, y, z, w)
        };
        // Plain loops without branches, which become SIMD.
        let (mut projected, mut are_inside) = ([SubpixelPoint::default(); COPIED], [true; COPIED]);
        for (i, point) in projected.iter_mut().enumerate() {
            *point = SubpixelPoint::project(position(i), &call.viewport);
        }
        for (i, is_inside) in are_inside.iter_mut().enumerate() {
            *is_inside = volume.holds(position(i));
        }
        points.copy_from_slice(&projected[..points.len()]);
        outcodes.fill(Outcode::default());
        for (i, outcode) in outcodes.iter_mut().enumerate().filter(|(i, _)| !are_inside[*i]) {
            *outcode = volume.outcode(position(i));
            inside &= outcode.is_inside();
        }
    }
    inside
}

/// The coordinates of positions, axis by axis.
#[inline(always)]
fn side_by_side(positions: &[Vec4; COPIED]) -> [[f32; COPIED]; 4] {
    let mut axes = [[0.0; COPIED]; 4];
    for (first, four) in (0..).step_by(4).zip(positions.as_chunks().0) {
        let &[a, b, c, d] = four;
        let transposed = Mat4::from_cols(a, b, c, d).transpose();
        for (axis, lanes) in axes.iter_mut().enumerate() {
            lanes[first..first + 4].copy_from_slice(&transposed.col(axis).to_array());
        }
    }
    axes
}
