//! Models: vertices, faces that keep their sides, materials and textures.
//!
//! What flows in are the face corners, materials and textures that a loader found in its files; what
//! flows out is a [`Model`] whose vertices are transformed once each. Nothing here depends on the
//! format of the files: every loader, such as that of [`obj`](crate::obj), ends here.
//!
//! - `model::corners` collects face corners, and lets equal ones share a `model::vertex`;
//! - `model::normals` finds the normals that the files do not give;
//! - `model::faces` keeps polygons by their `model::material`s.

use glam::{Mat4, Vec3};

use crate::camera::{Camera, Sphere};
use crate::texture::Texture;
use crate::vertex::Vertex;

mod vertex;
mod material;
mod faces;
pub(crate) mod corners;
mod normals;

pub use self::faces::Face;
pub use self::material::Material;
pub use self::vertex::ModelVertex;

use self::corners::Corners;
use self::faces::FacesByMaterial;

/// A model from a file.
///
/// The indices of its faces refer to `vertices` as they were loaded: change a vertex, but leave it
/// in its place.
#[derive(Clone, Debug)]
pub struct Model {
    /// Each combination of position, normal and texture coordinate that a face has at a corner, once.
    pub vertices: Vec<ModelVertex>,
    /// The default material, then those of the files in their order.
    pub materials: Vec<Material>,
    /// The pictures that materials refer to, each file once. They repeat and are filtered.
    pub textures: Vec<Texture>,
    faces: FacesByMaterial,
}

impl Model {
    /// The model of all that a loader found. Normals that the corners lack are computed, smooth where
    /// faces meet at less than the crease angle, in radians from 0 to pi.
    pub(crate) fn from_corners(
        mut corners: Corners,
        crease_angle: f32,
        materials: Vec<Material>,
        textures: Vec<Texture>,
    ) -> Self {
        normals::complete(&mut corners, crease_angle);
        let (vertices, faces) = corners.into_shared();
        Self { vertices, materials, textures, faces }
    }

    /// Number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// All faces, material by material. Those of one material are in the order of the file.
    pub fn faces(&self) -> impl Iterator<Item = Face<'_>> + Clone {
        self.faces.iter()
    }

    /// The faces of one material, in the order of the file; none for an index that no material has.
    pub fn faces_of(&self, material: usize) -> impl Iterator<Item = Face<'_>> + Clone {
        self.faces.of_material(material)
    }

    /// The least and the greatest coordinates of the vertices; `None` if there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let positions = self.positions();
        positions.clone().reduce(Vec3::min).zip(positions.reduce(Vec3::max))
    }

    /// A small sphere that holds all vertices; `None` if there are none.
    ///
    /// It is computed at each call, from all vertices.
    #[must_use]
    pub fn bounding_sphere(&self) -> Option<Sphere> {
        Sphere::around(self.positions())
    }

    /// A camera that sees the whole model, for pictures whose width is `aspect` times their height.
    ///
    /// It looks in the direction -z, with y up, until it is [`turned`](Camera::turned).
    pub fn camera(&self, aspect: f32) -> Camera {
        let nothing = Sphere { centre: Vec3::ZERO, radius: 1.0 };
        Camera::around(self.bounding_sphere().unwrap_or(nothing), aspect)
    }

    /// The vertices as renderers take them: with their positions in clip space, to which the matrix
    /// transforms them, and with the parameters that the shader needs.
    ///
    /// They are in the order of [`vertices`](Self::vertices), so that the indices of faces fit.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("triangle.obj");
    /// # std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
    /// use glam::{Vec2, Vec3};
    /// use polyscan::{Model, record};
    ///
    /// record! {
    ///     struct Surface {
    ///         uv: Vec2,
    ///         normal: Vec3,
    ///     }
    /// }
    ///
    /// let model = Model::load(&path)?.model;
    /// let clip_from_object = model.camera(4.0 / 3.0).clip_from_object();
    /// let vertices =
    ///     model.vertices_with(clip_from_object, |v| Surface { uv: v.uv, normal: v.normal });
    /// assert_eq!(vertices[0].params, [0.0, 0.0, 0.0, 0.0, 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn vertices_with<P, const N: usize>(
        &self,
        clip_from_object: Mat4,
        params: impl FnMut(&ModelVertex) -> P,
    ) -> Vec<Vertex<N>>
    where
        P: Into<[f32; N]>,
    {
        let positions = self.positions().map(|position| clip_from_object * position.extend(1.0));
        let params = self.vertices.iter().map(params);
        positions.zip(params).map(|(position, params)| Vertex::new(position, params)).collect()
    }

    fn positions(&self) -> impl Iterator<Item = Vec3> + Clone {
        self.vertices.iter().map(|vertex| vertex.position)
    }
}
