//! Models: vertices, faces that keep their sides, materials and textures.
//!
//! What flows in are the face corners, materials and textures that a loader found in its files; what
//! flows out is a [`Model`] whose vertices are transformed once each. Nothing here depends on the
//! format of the files: every loader, such as that of [`obj`](crate::obj), ends here.
//!
//! - `model::corners` collects face corners, and `model::fans` sorts them by points;
//! - `model::normals` finds the normals that the files do not give;
//! - `model::join` lets equal corners share a `model::vertex`, unless their `model::hands` differ;
//! - `model::faces` keeps polygons by their `model::material`s, whose colours that module has, and `model::maps` what other
//!   pictures say;
//! - `model::dice` makes geometry of displacement maps;
//! - `model::also` shows what a loader warned of where there is no model.

use glam::{DVec3, Mat4, Vec3, Vec4};

use crate::camera::{Camera, Sphere};
use crate::fragment::Footprint;
use crate::tangent::{TangentVertex, tangents};
use crate::texture::{MipFilter, Texture, TextureError};
use crate::vertex::Vertex;

pub(crate) mod also;
mod vertex;
mod material;
mod maps;
mod faces;
pub(crate) mod corners;
mod fans;
mod normals;
mod hands;
mod join;
mod dice;

pub use self::faces::Face;
pub use self::material::{AlphaMode, Material, TextureMapping};
pub use self::vertex::ModelVertex;

use self::corners::Corners;
use self::faces::FacesByMaterial;

/// A model from a file.
///
/// The indices of its faces refer to `vertices` as they were loaded: change a vertex, but leave it
/// in its place.
#[derive(Clone, Debug)]
pub struct Model {
    /// Each combination of position, normal, texture coordinate and colour that a face has at a corner,
    /// once.
    pub vertices: Vec<ModelVertex>,
    /// The default material, then those of the files in their order.
    pub materials: Vec<Material>,
    /// The pictures that materials refer to. They are filtered, and repeat unless their materials say
    /// otherwise.
    pub textures: Vec<Texture>,
    /// What has been taken off the positions of the file, in its units; mostly zero.
    ///
    /// A model that is far from the file's origin, such as one in map coordinates, would lose its shape in
    /// `f32`: at 13 million, neighbours are 1 apart. So it is brought near.
    pub origin: DVec3,
    faces: FacesByMaterial,
}

impl Model {
    /// The model of all that a loader found. Normals that the corners lack are computed, smooth where
    /// faces meet at less than the crease angle, in radians from 0 to pi.
    pub(crate) fn from_corners(
        corners: Corners,
        crease_angle: f32,
        materials: Vec<Material>,
        textures: Vec<Texture>,
    ) -> Self {
        let origin = corners.origin;
        let has_tangents = materials.iter().any(|material| material.normal_texture.is_some());
        let (vertices, faces) = join::join(corners, crease_angle, has_tangents);
        let mut model = Self { vertices, materials, textures, origin, faces };
        if has_tangents {
            model.find_tangents();
        }
        model
    }

    /// Gives those vertices tangents that have none from the file.
    fn find_tangents(&mut self) {
        let of = |vertex: &ModelVertex| TangentVertex {
            position: vertex.position,
            normal: vertex.normal,
            uv: vertex.uv,
        };
        let vertices: Vec<_> = self.vertices.iter().map(of).collect();
        let tangents = tangents(&vertices, self.faces().filter(|face| face.has_uv));
        for (vertex, tangent) in self.vertices.iter_mut().zip(tangents) {
            if vertex.tangent.truncate() == Vec3::ZERO {
                vertex.tangent = tangent;
            }
        }
    }

    /// The same model, whose textures have mip chains and are filtered so where they are made smaller. Those
    /// that cut out have chains [of their own](Texture::with_cutout_mipmaps), unless they are glass elsewhere.
    ///
    /// # Errors
    /// [`TextureError::Memory`] if the machine has no room for the chains.
    pub fn with_mip_filter(mut self, mip_filter: MipFilter) -> Result<Self, TextureError> {
        let textures = std::mem::take(&mut self.textures);
        let filtered = textures.into_iter().enumerate().map(|(index, texture)| {
            let chained = match self.cutout_of(index) {
                Some((threshold, false)) => texture.with_cutout_mipmaps(threshold),
                Some((threshold, true)) => texture.with_red_cutout_mipmaps(threshold),
                None => texture.with_mipmaps(),
            };
            Ok(chained?.with_mip_filter(mip_filter))
        });
        self.textures = filtered.collect::<Result<_, _>>()?;
        Ok(self)
    }

    /// The threshold by which a texture cuts out, and whether it does so by its red channel; `None` if it
    /// does not, or not for all materials that have it.
    fn cutout_of(&self, index: usize) -> Option<(f32, bool)> {
        let uses = self.materials.iter().flat_map(|material| {
            let in_red = (material.alpha_texture == Some(index)).then_some((material, true));
            let own = (material.texture == Some(index)).then_some((material, false));
            own.into_iter().chain(in_red)
        });
        let cutouts =
            uses.filter(|(material, _)| material.is_transparent()).map(|(material, in_red)| {
                match material.alpha_mode {
                    // The alpha of the material multiplies that of the picture.
                    AlphaMode::Cutout { threshold } if material.alpha > 0.0 => {
                        Some((threshold / material.alpha, in_red))
                    }
                    _ => None,
                }
            });
        cutouts.reduce(|first, other| first.filter(|_| first == other)).flatten()
    }

    /// Whether any of the materials is transparent, so that the order of faces matters.
    #[must_use]
    pub fn has_transparency(&self) -> bool {
        self.materials.iter().any(Material::is_transparent)
    }

    /// The colour of a face at a point, by [`Material::color_at`]: linear light, premultiplied by alpha.
    ///
    /// `seen` is the fragment's [footprint](crate::Fragment::footprint) in texture coordinates, `color` the
    /// colour of the vertices, interpolated. A material that does not exist is white.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("square.obj");
    /// use glam::{Vec2, Vec4};
    /// use polyscan::render::Over;
    /// use polyscan::{Framebuffer, Mesh, Model, ScanlineRenderer, record};
    ///
    /// record! {
    ///     struct Surface {
    ///         uv: Vec2,
    ///         color: Vec4,
    ///     }
    /// }
    ///
    /// # std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
    /// let model = Model::load(&path)?.model;
    /// let faces: Vec<_> = model.faces().collect();
    /// let clip_from_object = model.camera(4.0 / 3.0).clip_from_object();
    /// let vertices = model.vertices_with(clip_from_object, |v| Surface { uv: v.uv, color: v.color });
    ///
    /// // Glass and leaves in their true order, whatever the file's.
    /// let is_transparent =
    ///     |face| model.materials[faces[face as usize].material].is_transparent();
    /// let mesh = Mesh::new(&vertices, &faces).with_transparent(&is_transparent);
    /// let mut frame = Framebuffer::new(320, 240, Vec4::ONE)?;
    /// ScanlineRenderer::new(frame.viewport()).draw(&mut frame, mesh, |fragment| {
    ///     let Surface { color, .. } = fragment.params.into();
    ///     let material = faces[fragment.face as usize].material;
    ///     Over(model.color_at(material, &fragment.footprint(0, 1), color))
    /// });
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline]
    #[must_use]
    pub fn color_at(&self, material: usize, seen: &Footprint, color: Vec4) -> Vec4 {
        match self.materials.get(material) {
            Some(material) => material.color_at(&self.textures, seen, color),
            None => Vec4::ONE,
        }
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

    /// The least and the greatest coordinates of the vertices, relative to
    /// [`origin`](Self::origin); `None` if there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let positions = self.positions();
        positions.clone().reduce(Vec3::min).zip(positions.reduce(Vec3::max))
    }

    /// A small sphere that holds all vertices, as far as displacement maps may move them; `None` if there are none.
    ///
    /// It is computed at each call, from all vertices and all texels of displacement maps.
    #[must_use]
    pub fn bounding_sphere(&self) -> Option<Sphere> {
        let Sphere { centre, radius } = Sphere::around(self.positions())?;
        let most = self.materials.iter().map(|m| m.most_displacement(&self.textures));
        Some(Sphere { centre, radius: radius + most.fold(0.0, f32::max) })
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
