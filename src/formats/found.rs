//! What a loader finds in a file: faces in any order, each with a material.

use glam::{DVec3, Vec2, Vec3, Vec4};

use crate::formats::limits::{MAX_CORNERS, lost_faces, too_many_corners};
use crate::model::corners::{BY_ANGLE, Corners};
use crate::model::{Material, Model};
use crate::texture::Texture;

/// A corner of a face.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: DVec3,
    /// With v up; NaN for none.
    pub(super) uv: Vec2,
    /// Zero for none.
    pub(super) normal: Vec3,
    /// Linear light, not multiplied by alpha.
    pub(super) color: Vec4,
    /// As a vertex of a model has it; zero for none.
    pub(super) tangent: Vec4,
}

impl Corner {
    /// A corner that has nothing but its place.
    pub(super) fn at(position: DVec3) -> Self {
        let (normal, color, tangent) = (Vec3::ZERO, Vec4::ONE, Vec4::ZERO);
        Self { position, uv: Vec2::NAN, normal, color, tangent }
    }

    fn is_finite(&self) -> bool {
        self.position.as_vec3().is_finite()
    }
}

/// What is found in a file.
pub(super) struct Found {
    /// Of all corners, face by face.
    positions: Vec<DVec3>,
    /// Of these lists what is beyond the end is missing: most files have none of them.
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    colors: Vec<Vec4>,
    tangents: Vec<Vec4>,
    /// Where the corners of each face end, and its material.
    faces: Vec<(u32, u32)>,
    /// The default material first.
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    pub(super) warnings: Vec<String>,
    /// How many faces were left out because a corner is not finite.
    lost: u64,
}

impl Found {
    pub(super) fn new() -> Self {
        Self {
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            colors: Vec::new(),
            tangents: Vec::new(),
            faces: Vec::new(),
            materials: vec![Material::default()],
            textures: Vec::new(),
            warnings: Vec::new(),
            lost: 0,
        }
    }

    /// Adds a face. One of fewer than three corners is left out, and so is one with a corner that is not
    /// finite.
    pub(super) fn face(
        &mut self,
        corners: impl IntoIterator<Item = Corner>,
        material: usize,
    ) -> Result<(), String> {
        let start = self.positions.len();
        let mut is_finite = true;
        for corner in corners {
            is_finite &= corner.is_finite();
            self.corner(&corner);
        }
        if self.positions.len() as u64 > MAX_CORNERS {
            return Err(too_many_corners());
        }
        if self.positions.len() < start + 3 || !is_finite {
            self.positions.truncate(start);
            self.uvs.truncate(start);
            self.normals.truncate(start);
            self.colors.truncate(start);
            self.tangents.truncate(start);
            self.lost += 1;
            return Ok(());
        }
        self.faces.push((self.positions.len() as u32, material as u32));
        Ok(())
    }

    fn corner(&mut self, corner: &Corner) {
        let Corner { position, uv, normal, color, tangent } = *corner;
        let place = self.positions.len();
        self.positions.push(position);
        if uv.is_finite() {
            self.uvs.resize(place, Vec2::NAN);
            self.uvs.push(uv);
        }
        if normal.is_finite() && normal != Vec3::ZERO {
            self.normals.resize(place, Vec3::ZERO);
            self.normals.push(normal);
        }
        if color.is_finite() && color != Vec4::ONE {
            self.colors.resize(place, Vec4::ONE);
            self.colors.push(color);
        }
        if tangent.is_finite() && tangent != Vec4::ZERO {
            self.tangents.resize(place, Vec4::ZERO);
            self.tangents.push(tangent);
        }
    }

    /// Whether there are no faces.
    #[cfg(feature = "ply")]
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Adds to the warnings what became of the faces; to be called when all are there.
    pub(super) fn finish(mut self) -> Self {
        self.warnings.extend(lost_faces(self.lost));
        self
    }

    /// The model, unless there are no faces, and the warnings.
    pub(super) fn into_model(mut self, crease_angle: f32) -> (Option<Model>, Vec<String>) {
        let warnings = std::mem::take(&mut self.warnings);
        if self.faces.is_empty() {
            return (None, warnings);
        }
        let origin = crate::model::corners::origin(self.positions.iter().copied());
        let mut corners = Corners::around(origin);
        corners.reserve(self.positions.len(), self.faces.len());
        let mut order: Vec<u32> = (0..self.faces.len() as u32).collect();
        // Stable, so that the faces of a material stay in the order of the file.
        order.sort_by_key(|&face| self.faces[face as usize].1);
        let mut order = order.into_iter().peekable();
        for material in 0..self.materials.len() as u32 {
            while let Some(face) = order.next_if(|&f| self.faces[f as usize].1 == material) {
                let face = face as usize;
                let start = if face == 0 { 0 } else { self.faces[face - 1].0 };
                self.add_face(start as usize..self.faces[face].0 as usize, &mut corners);
            }
            corners.end_material();
        }
        let model = Model::from_corners(corners, crease_angle, self.materials, self.textures);
        (Some(model), warnings)
    }

    fn add_face(&self, places: std::ops::Range<usize>, corners: &mut Corners) {
        for place in places {
            let uv = self.uvs.get(place).copied().unwrap_or(Vec2::NAN);
            let normal = self.normals.get(place).copied().unwrap_or(Vec3::ZERO);
            let point = corners.point_at(self.positions[place]);
            corners.push(point, uv, normal);
            #[cfg(feature = "gltf")]
            if let Some(&tangent) = self.tangents.get(place) {
                corners.tangent(tangent);
            }
            if !self.colors.is_empty() {
                corners.color(self.colors.get(place).copied().unwrap_or(Vec4::ONE));
            }
        }
        corners.end_face(BY_ANGLE);
    }
}
