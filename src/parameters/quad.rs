//! Texture coordinates on any quad: the projective mapping through its four corners.

use glam::{DVec3, Vec2, Vec3};

use crate::parameters::error::ParameterError;

/// The least ratio of two weights, and of the areas of two triangles of corners: below, three corners are as good as on
/// a line.
const LEAST: f64 = 1e-6;

/// The homogeneous texture coordinates (u q, v q, q) of a flat quad's corners, which make one projective mapping of
/// the quad to any four texture coordinates.
///
/// A quad's texture coordinates are affine on it only if they are a parallelogram as the quad is one. If they are not,
/// two triangles show a seam along the diagonal, and interpolation along edges depends on how the quad lies on the
/// screen. As a [cluster](crate::Fragment::divided) with these weights they do neither: straight lines stay
/// straight, all over the quad.
///
/// The weights follow from where the diagonals cross (Heckbert and Moreton 1991, section 3.4: the quad's cluster has a
/// homogeneous variable of its own). If they do so at the parts t and s of the quad's diagonals from corners 0
/// and 1, and at t' and s' of those between the texture coordinates, the mapping takes the one crossing to the
/// other, and
///
/// ```text
/// q_0 = (1 - t') / (1 - t)    q_1 = (1 - s') / (1 - s)    q_2 = t' / t    q_3 = s' / s
/// ```
///
/// Here they are scaled so that the largest is 1.
///
/// ```
/// use polyscan::glam::{Vec4, vec2, vec3};
/// use polyscan::{Framebuffer, Vertex, ZBufferRenderer, parameters};
///
/// // A trapezoid that shows all of a texture.
/// let corners = [vec3(-0.9, -0.9, 0.0), vec3(0.9, -0.9, 0.0), vec3(0.3, 0.9, 0.0), vec3(-0.3, 0.9, 0.0)];
/// let values = [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)];
/// let homogeneous = parameters::quad(corners, values)?;
/// let quad: [_; 4] = std::array::from_fn(|i| Vertex::new(corners[i].extend(1.0), homogeneous[i]));
///
/// let mut frame = Framebuffer::new(100, 100, 0.0)?;
/// ZBufferRenderer::new(frame.viewport()).draw(&mut frame, &quad, |fragment| {
///     let [u, v] = fragment.divided([0, 1], 2).unwrap_or_default();
///     u * v
/// });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// If a quad is not flat, it counts as seen along the normal of the largest triangle of three corners; the corners have
/// their values all the same, but the mapping is projective only as far as the quad is flat.
///
/// # Errors
/// When a coordinate is not finite; when three corners, or three texture coordinates, lie on a line; when the mapping
/// folds over, since one of both quads is convex and the other is not, or is crossed. Then the texture coordinates may
/// be given with q = 1: they are interpolated along the edges.
pub fn quad(corners: [Vec3; 4], values: [Vec2; 4]) -> Result<[Vec3; 4], ParameterError> {
    for index in 0..4 {
        if !corners[index].is_finite() || !values[index].is_finite() {
            return Err(ParameterError::NotFinite { index });
        }
    }
    let corner_parts = parts(corners.map(Vec3::as_dvec3))?;
    let value_parts = parts(values.map(|value| value.as_dvec2().extend(0.0)))?;
    let q: [f64; 4] = std::array::from_fn(|i| value_parts[i] / corner_parts[i]);
    let most = q.iter().fold(0.0f64, |most, q| most.max(q.abs()));
    if q.iter().any(|q| q.abs() < most * LEAST) {
        return Err(ParameterError::Degenerate);
    }
    if q.iter().any(|&other| (other > 0.0) != (q[0] > 0.0)) {
        return Err(ParameterError::Folded);
    }
    Ok(std::array::from_fn(|i| {
        let q = q[i].abs() / most;
        (values[i].as_dvec2() * q).extend(q).as_vec3()
    }))
}

/// Numbers in proportion to 1 - t, s - 1, t and -s, where the diagonals cross at t and s. With them the four points add
/// up to nothing; and they are the areas of the triangles of the three others, with signs, which are there even where
/// the diagonals do not cross.
fn parts(points: [DVec3; 4]) -> Result<[f64; 4], ParameterError> {
    // From the first point, and scaled, so that no product leaves the range of f64.
    let sides = points.map(|point| point - points[0]);
    let unit = sides.iter().fold(0.0f64, |unit, side| unit.max(side.abs().max_element()));
    if unit == 0.0 {
        return Err(ParameterError::Degenerate);
    }
    let [_, b, c, d] = sides.map(|side| side / unit);
    let areas = [(c - b).cross(d - b), -c.cross(d), b.cross(d), -b.cross(c)];
    let sizes = areas.map(DVec3::length_squared);
    let largest = (1..4).fold(0, |most, i| if sizes[i] > sizes[most] { i } else { most });
    let parts = areas.map(|area| area.dot(areas[largest]) / sizes[largest]);
    // NaN, where there is no area at all, is as good as zero.
    let is_spread = sizes[largest] > LEAST * LEAST && parts.iter().all(|part| part.abs() > LEAST);
    if is_spread { Ok(parts) } else { Err(ParameterError::Degenerate) }
}
