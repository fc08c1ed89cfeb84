//! Heights: where points are moved to, and how that bends normals.

use glam::{Vec2, Vec3};

use crate::fragment::{Footprint, FootprintBlock, LANES, Lanes};
use crate::model::dice::net::{Corner, Net, Point};
use crate::model::dice::sight::Sight;
use crate::model::material::Material;
use crate::model::vertex::ModelVertex;
use crate::render::parallel::for_each;
use crate::texture::Texture;

/// So many corners are one thread's at a time.
const PART: usize = 1024;

/// Slopes are taken over so many texels at least: from the middle of one to that of the next but one, as
/// [`Texture::normals_of_heights`] takes them.
const LEAST_TEXELS: f32 = 2.0;

/// The displacement maps of a model.
pub(super) struct Heights<'a> {
    materials: &'a [Material],
    textures: &'a [Texture],
}

/// What is seen of the surface around a corner.
#[derive(Clone, Copy, Default)]
struct Around {
    seen: Footprint,
    /// Along the footprint's first side, of length 1, and across it.
    axes: [Vec3; 2],
    normal: Vec3,
    /// How long its sides are.
    step: f32,
    /// Over how many times as much slopes are taken.
    wider: [f32; 2],
}

impl<'a> Heights<'a> {
    pub(super) fn of(materials: &'a [Material], textures: &'a [Texture]) -> Self {
        Self { materials, textures }
    }

    fn texture(&self, material: usize) -> Option<(&'a Material, &'a Texture)> {
        let material = self.materials.get(material)?;
        Some((material, self.textures.get(material.displacement_texture?)?))
    }

    /// Whether a material has heights.
    pub(super) fn has(&self, material: usize) -> bool {
        self.texture(material).is_some()
    }

    /// How far anything is moved at the most.
    pub(super) fn most(&self) -> f32 {
        let all = self.materials.iter().map(|material| material.most_displacement(self.textures));
        all.fold(0.0, f32::max)
    }

    /// Moves the points from a number on, by the corners from a number on, which are all of theirs.
    pub(super) fn place(
        &self,
        net: &mut Net,
        (first_point, first_corner): (usize, usize),
        sight: &Sight,
    ) {
        let corners = &net.corners[first_corner..];
        let mut heights = vec![0.0; corners.len()];
        let points = &net.points;
        let mut parts: Vec<_> = heights.chunks_mut(PART).collect();
        for_each(&mut parts, |part, heights| {
            let corners = corners[part * PART..].chunks(LANES);
            for (heights, corners) in heights.chunks_mut(LANES).zip(corners) {
                let around = |corner: &Corner| self.around(points, corner, sight);
                let seen = block_of(corners.iter().map(|corner| around(corner).seen));
                heights.copy_from_slice(&self.sampled(corners, &seen)[..heights.len()]);
            }
        });
        for (corner, height) in corners.iter().zip(heights) {
            if self.has(corner.material as usize) {
                let (sum, count) = &mut net.points[corner.point as usize].heights;
                (*sum, *count) = (*sum + height, *count + 1);
            }
        }
        for point in &mut net.points[first_point..] {
            let (sum, count) = point.heights;
            if count > 0 && !point.is_fixed {
                let by = point.direction.normalize_or_zero() * (sum / count as f32);
                let moved = point.base + by;
                point.moved = if moved.is_finite() { moved } else { point.base };
            }
        }
    }

    /// The heights at a block of corners, each by its own material; 0 without one.
    fn sampled(&self, corners: &[Corner], seen: &FootprintBlock) -> Lanes {
        let mut heights = [0.0; LANES];
        let mut left = u32::MAX >> (u32::BITS as usize - corners.len().clamp(1, LANES));
        while left != 0 {
            let first = corners[left.trailing_zeros() as usize].material;
            let alike = corners.iter().enumerate().filter(|(_, corner)| corner.material == first);
            let mask = left & alike.fold(0, |mask, (lane, _)| mask | 1 << lane);
            if let Some((material, _)) = self.texture(first as usize) {
                let own = material.displacements_at(self.textures, seen, mask);
                for lane in (0..LANES).filter(|lane| mask >> lane & 1 != 0) {
                    heights[lane] = own[lane];
                }
            }
            left &= !mask;
        }
        heights
    }

    /// The vertices of a net, one for each of its corners, with their numbers.
    pub(super) fn vertices(&self, net: &Net, sight: &Sight) -> Vec<ModelVertex> {
        let mut vertices: Vec<_> = net.corners.iter().map(|corner| corner.vertex).collect();
        let mut parts: Vec<_> = vertices.chunks_mut(PART).collect();
        for_each(&mut parts, |part, vertices| {
            let corners = net.corners[part * PART..].chunks(LANES);
            for (vertices, corners) in vertices.chunks_mut(LANES).zip(corners) {
                let mut all = [Around::default(); LANES];
                for (around, corner) in all.iter_mut().zip(corners) {
                    *around = self.around(&net.points, corner, sight);
                }
                let slopes = self.slopes(corners, &all);
                for (lane, (vertex, corner)) in vertices.iter_mut().zip(corners).enumerate() {
                    vertex.position = net.points[corner.point as usize].moved;
                    vertex.normal = all[lane].bent(slopes[lane]);
                    let along = vertex.tangent.truncate().normalize_or_zero();
                    vertex.tangent = along.extend(vertex.tangent.w);
                }
            }
        });
        share_normals(net, &mut vertices);
        vertices
    }

    /// The slopes along both axes around a block of corners; zero where normals stay as they are.
    fn slopes(&self, corners: &[Corner], all: &[Around; LANES]) -> [Vec2; LANES] {
        let seen = block_of(all.iter().map(|around| around.seen));
        let mut slopes = [Vec2::ZERO; LANES];
        for axis in 0..2 {
            let at = |sign: f32| {
                let moved = all.iter().map(|around| {
                    let by = [around.seen.dx, around.seen.dy][axis] * around.wider[axis];
                    around.seen.uv + by * (0.5 * sign)
                });
                let mut seen = seen;
                for (lane, uv) in moved.enumerate() {
                    [seen.uv[0][lane], seen.uv[1][lane]] = uv.to_array();
                }
                self.sampled(corners, &seen)
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            for (lane, (around, corner)) in all.iter().zip(corners).enumerate() {
                let slope = (ahead[lane] - behind[lane]) / (around.wider[axis] * around.step);
                let material = self.texture(corner.material as usize);
                let is_bent = material.is_some_and(|(it, _)| it.normal_texture.is_none());
                slopes[lane][axis] = if is_bent && slope.is_finite() { slope } else { 0.0 };
            }
        }
        slopes
    }

    fn around(&self, points: &[Point], corner: &Corner, sight: &Sight) -> Around {
        let step = sight.edge / sight.scale_at(points[corner.point as usize].base);
        let mut around = Around::of(corner, step);
        if let Some((material, texture)) = self.texture(corner.material as usize) {
            let size = Vec2::new(texture.width() as f32, texture.height() as f32);
            let mapped = material.displacement_mapping.footprint(&around.seen);
            let texels = [mapped.dx, mapped.dy].map(|side| (side * size).length());
            around.wider = texels.map(|texels| (LEAST_TEXELS / texels).max(1.0));
        }
        around
    }
}

/// Footprints as a block.
fn block_of(footprints: impl Iterator<Item = Footprint>) -> FootprintBlock {
    let mut block = FootprintBlock::default();
    for (lane, Footprint { uv, dx, dy }) in footprints.enumerate().take(LANES) {
        for (lanes, value) in [(&mut block.uv, uv), (&mut block.dx, dx), (&mut block.dy, dy)] {
            [lanes[0][lane], lanes[1][lane]] = value.to_array();
        }
    }
    block
}

impl Around {
    /// What is seen within a square of some size that lies across the normal.
    fn of(corner: &Corner, step: f32) -> Self {
        let (uv, normal) = (corner.vertex.uv, corner.vertex.normal.normalize_or_zero());
        let [u, v] = corner.axes.map(|axis| axis - normal * normal.dot(axis));
        let length = u.length();
        let x = u / length;
        let y = normal.cross(x);
        // The derivatives of u and v along x and y: the inverse of those of the place.
        let area = y.dot(v);
        let (dx, dy) = (Vec2::new(step / length, 0.0), Vec2::new(-x.dot(v) / length, 1.0));
        let dy = dy * (step / area);
        let wider = [1.0; 2];
        if dx.is_finite() && dy.is_finite() && step > 0.0 {
            return Self { seen: Footprint { uv, dx, dy }, axes: [x, y], normal, step, wider };
        }
        Self { seen: uv.into(), axes: [Vec3::ZERO; 2], normal, step: 1.0, wider }
    }

    /// The normal of the surface after it was moved, by its slopes.
    fn bent(&self, slopes: Vec2) -> Vec3 {
        let [x, y] = self.axes;
        let bent = self.normal - x * slopes.x - y * slopes.y;
        bent.try_normalize().unwrap_or(self.normal)
    }
}

/// Gives corners of a point that had one normal one normal again: the mean.
fn share_normals(net: &Net, vertices: &mut [ModelVertex]) {
    let mut counts = vec![0_u32; net.points.len()];
    for corner in &net.corners {
        counts[corner.point as usize] += 1;
    }
    let key = |&corner: &usize| {
        let Corner { vertex, point, .. } = &net.corners[corner];
        (*point, (vertex.normal + 0.0).to_array().map(f32::to_bits))
    };
    let is_shared = |&corner: &usize| counts[net.corners[corner].point as usize] > 1;
    let mut shared: Vec<_> = (0..net.corners.len()).filter(is_shared).collect();
    shared.sort_by_key(key);
    for alike in shared.chunk_by(|a, b| key(a) == key(b)) {
        let sum: Vec3 = alike.iter().map(|&corner| vertices[corner].normal).sum();
        let Some(mean) = sum.try_normalize().filter(|_| alike.len() > 1) else { continue };
        for &corner in alike {
            vertices[corner].normal = mean;
        }
    }
}
