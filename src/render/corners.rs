//! The vertices of a mesh on the screen, projected once each, whatever their faces are.

use fearless_simd::Level;
use glam::Vec4;

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
        let positions = &mut positions[..points.len()];
        vertices.copy_positions(first + part * COPIED, positions);
        for ((point, outcode), position) in points.iter_mut().zip(outcodes).zip(positions) {
            let position = position.as_dvec4();
            *point = SubpixelPoint::project(position, &call.viewport);
            *outcode = volume.outcode(position);
            inside &= outcode.is_inside();
        }
    }
    inside
}
