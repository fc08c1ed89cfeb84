//! Tangent space: which way the texels of a normal map point on a surface.
//!
//! What flows in are positions, normals and texture coordinates of a mesh; what flows out is a tangent for
//! each vertex, to be interpolated beside the normal, and from these and a texel of a normal map the
//! direction of the bent normal.
//!
//! A frame has three axes: the tangent points where the picture's u grows, the bitangent UP in the picture,
//! against v, and the normal out of the surface. The bitangent is not stored: it is the cross product of
//! normal and tangent times the tangent's w, which is 1, or -1 where the picture lies on the surface as in a
//! mirror. So glTF and MikkTSpace have it, and so normal maps are painted whose green is up ("OpenGL").
//!
//! Tangents are those of MikkTSpace (M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", master's
//! thesis, Copenhagen 2008, section 3 and appendix A): that of a face is laid into the plane across the
//! vertex's normal, normalised, and weighted by the face's angle there. Where MikkTSpace cuts a polygon into
//! triangles, the tangent of the whole polygon is taken, which is the mean of dP/du over its part of the
//! picture: by Green's theorem the integral of P dv around it, divided by its area there. A vertex has one
//! tangent. Where faces that share one are mirrored against each other, that of the larger angles is taken:
//! such vertices are better doubled, as a [`Model`](crate::Model)'s are.
//!
//! ```
//! use polyscan::glam::{Vec2, Vec3, Vec4, vec2, vec3};
//! use polyscan::tangent::{TangentFrame, TangentVertex, tangents};
//!
//! // A square seen from above, with the picture upright: v runs down.
//! let vertices = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| TangentVertex {
//!     position: vec3(x, y, 0.0),
//!     normal: Vec3::Z,
//!     uv: vec2(x / 2.0, 1.0 - y / 2.0),
//! });
//! let tangents = tangents(&vertices, [[0, 1, 2, 3]]);
//! assert_eq!(tangents[0], Vec4::new(1.0, 0.0, 0.0, 1.0));
//!
//! // A texel that leans to the right by 45 degrees.
//! let frame = TangentFrame::new(Vec3::Z, tangents[0]);
//! let half = 0.5 * std::f32::consts::FRAC_1_SQRT_2;
//! let normal = frame.bent(Vec3::new(0.5 + half, 0.5, 0.5 + half), 1.0);
//! assert!((normal - vec3(1.0, 0.0, 1.0).normalize()).length() < 1e-6);
//! ```

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};

use crate::angle::arc_cosine;
use crate::render::FaceIndices;

/// What the tangent of a vertex is found from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TangentVertex {
    /// In object space.
    pub position: Vec3,
    /// In object space, of length 1.
    pub normal: Vec3,
    /// With u to the right and v down, as a [`Texture`](crate::Texture) has it.
    pub uv: Vec2,
}

/// The tangents of vertices, in their order: directions of length 1 in object space, across the normals, and
/// in `w` 1, or -1 where the picture is mirrored.
///
/// The faces are lists of three or more indices into the vertices. A face that refers to a vertex which is not
/// there, whose texture coordinates enclose no area, or that has a number which is not finite, has no
/// part in it. Vertices without a face that has get any direction across the normal.
///
/// The numbers are the same on every machine.
#[must_use]
pub fn tangents<F: FaceIndices>(
    vertices: &[TangentVertex],
    faces: impl IntoIterator<Item = F>,
) -> Vec<Vec4> {
    // Of upright faces, and of mirrored ones.
    let mut sums = vec![[Sum::default(); 2]; vertices.len()];
    let mut corners = Vec::new();
    for face in faces {
        let indices = face.indices();
        corners.clear();
        corners.extend(indices.iter().filter_map(|&index| vertices.get(index as usize).copied()));
        let Some(along) = PictureAxes::of(&corners).filter(|_| corners.len() == indices.len())
        else {
            continue;
        };
        for (i, &index) in indices.iter().enumerate() {
            let normal = corners[i].normal.as_dvec3();
            let across = |v: DVec3| (v - normal * normal.dot(v)).try_normalize();
            let Some(tangent) = across(along.u) else { continue };
            let to = |other: usize| {
                let side = corners[other].position.as_dvec3() - corners[i].position.as_dvec3();
                across(side).unwrap_or_default()
            };
            let (after, before) =
                ((i + 1) % corners.len(), (i + corners.len() - 1) % corners.len());
            let angle = arc_cosine(to(after).dot(to(before)));
            let sum = &mut sums[index as usize][usize::from(along.is_mirrored(normal))];
            sum.tangent += tangent * angle;
            sum.angle += angle;
        }
    }
    let all = vertices.iter().zip(sums);
    all.map(|(vertex, [upright, mirrored])| {
        let is_mirrored = mirrored.angle > upright.angle;
        let sum = if is_mirrored { mirrored } else { upright };
        let tangent = sum.tangent.as_vec3().try_normalize();
        let any = || vertex.normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_vector();
        tangent.unwrap_or_else(any).extend(if is_mirrored { -1.0 } else { 1.0 })
    })
    .collect()
}

/// What the faces of one handedness add to a vertex's tangent.
#[derive(Clone, Copy, Default)]
struct Sum {
    tangent: DVec3,
    /// In radians.
    angle: f64,
}

/// How the axes of a picture run on a face, of any length.
pub(crate) struct PictureAxes {
    /// Where u grows: the derivative of the place, integrated over the picture.
    pub(crate) u: DVec3,
    /// Up in the picture, likewise.
    pub(crate) up: DVec3,
    /// The part of the picture.
    #[cfg_attr(not(feature = "model"), expect(dead_code, reason = "dicing alone asks for it"))]
    pub(crate) area: f64,
}

impl PictureAxes {
    /// The axes on a face of these corners; `None` if its part of the picture has no area, or not even
    /// finite numbers.
    pub(crate) fn of(corners: &[TangentVertex]) -> Option<Self> {
        let first = corners.first()?;
        let at = |corner: &TangentVertex| {
            let uv = (corner.uv - first.uv).as_dvec2() * DVec2::new(1.0, -1.0);
            ((corner.position - first.position).as_dvec3(), uv)
        };
        let (mut u, mut up, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for (i, corner) in corners.iter().enumerate() {
            let (from, to) = (at(corner), at(&corners[(i + 1) % corners.len()]));
            // The integrals of P dv, P du and u dv along the side, v up.
            let (middle, step) = ((from.0 + to.0) * 0.5, to.1 - from.1);
            u += middle * step.y;
            up -= middle * step.x;
            area += 0.5 * (from.1.x + to.1.x) * step.y;
        }
        let sign = if area < 0.0 { -1.0 } else { 1.0 };
        let is_flat = area.abs() > 0.0 && u.is_finite() && up.is_finite();
        is_flat.then_some(Self { u: u * sign, up: up * sign, area: area.abs() })
    }

    /// Whether the picture is seen as in a mirror, from where the normal points to.
    pub(crate) fn is_mirrored(&self, normal: DVec3) -> bool {
        normal.cross(self.u).dot(self.up) < 0.0
    }
}

/// Normal and tangent at a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentFrame {
    /// The interpolated normal. It need not have length 1.
    pub normal: Vec3,
    /// The interpolated tangent, with the sign of the bitangent in `w`.
    pub tangent: Vec4,
}

impl TangentFrame {
    /// The frame of an interpolated normal and an interpolated tangent, neither of which is normalised:
    /// MikkTSpace wants them as they are, for programs that bake normal maps have them so.
    #[inline]
    #[must_use]
    pub fn new(normal: Vec3, tangent: Vec4) -> Self {
        Self { normal, tangent }
    }

    /// The axis that points up in the picture.
    #[inline]
    #[must_use]
    pub fn bitangent(&self) -> Vec3 {
        let sign = if self.tangent.w < 0.0 { -1.0 } else { 1.0 };
        self.normal.cross(self.tangent.truncate()) * sign
    }

    /// A direction of tangent space (x along the tangent, y up in the picture, z out of the surface) in object
    /// space, of length 1; zero for none.
    #[inline]
    #[must_use]
    pub fn direction(&self, [x, y, z]: [f32; 3]) -> Vec3 {
        let sum = self.tangent.truncate() * x + self.bitangent() * y + self.normal * z;
        sum.normalize_or_zero()
    }

    /// The normal that a texel of a normal map stands for, in object space, of length 1.
    ///
    /// The texel's red, green and blue go from 0 to 1, as [`Texture::open_data`](crate::Texture::open_data)
    /// and the filters give them, and stand for x, y and z from -1 to 1. The strength multiplies x
    /// and y: 1 for the normal as it is, 0 for the surface's own, less for one between.
    #[inline]
    #[must_use]
    pub fn bent(&self, texel: Vec3, strength: f32) -> Vec3 {
        let [x, y, z] = (texel * 2.0 - 1.0).to_array();
        self.direction([x * strength, y * strength, z])
    }
}
