//! The steps from an OBJ file to a model.

use std::path::Path;

use glam::{Vec2, Vec3};

use crate::model::Model;
use crate::model::corners::Corners;
use crate::obj::error::ObjError;
use crate::obj::file::read_text;
use crate::obj::limits::MAX_OBJ_BYTES;
use crate::obj::plain::{self, Plain};
use crate::obj::warning::{Warning, Warnings};
use crate::obj::{materials, mtl};

/// Reads an OBJ file and the files that it refers to. The crease angle is in radians, from 0 to pi.
pub(super) fn read(path: &Path, crease_angle: f32) -> Result<(Model, Vec<Warning>), ObjError> {
    let mut warnings = Warnings::default();
    let plain = read_plain(path)?;
    let library = mtl::rewrite(path, &plain.libraries, &mut warnings);
    // Should `tobj` refuse the materials after all, the model is loaded without: each that a face
    // names is then unknown, with a warning.
    let (named, ids) = tobj::load_mtl_buf(&mut library.as_bytes()).unwrap_or_default();
    for (line, name) in plain.materials() {
        if !ids.contains_key(name) {
            let (path, name) = (path.to_owned(), name.to_owned());
            warnings.add(Warning::UnknownMaterial { path, line, name });
        }
    }
    let options = tobj::LoadOptions::default();
    // For the faces `tobj` needs no more of the materials than their ids.
    let (meshes, _) = tobj::load_obj_buf(&mut plain.into_text().as_bytes(), &options, |_| {
        Ok((Vec::new(), ids.clone()))
    })
    .map_err(|source| ObjError::Parser { path: path.to_owned(), source })?;

    let (materials, textures) = materials::open(path, named, &mut warnings);
    let corners = collect(meshes, materials.len());
    let model = Model::from_corners(corners, crease_angle, materials, textures);
    Ok((model, warnings.into_list()))
}

/// The text of the OBJ file in plain form, which has faces.
fn read_plain(path: &Path) -> Result<Plain, ObjError> {
    let text = read_text(path, MAX_OBJ_BYTES)
        .map_err(|source| ObjError::Read { path: path.to_owned(), source })?;
    let plain = plain::rewrite(&text).map_err(|(line, cause)| ObjError::Line {
        path: path.to_owned(),
        line,
        cause,
    })?;
    if plain.has_faces() { Ok(plain) } else { Err(ObjError::NoFaces { path: path.to_owned() }) }
}

/// The face corners of all meshes, material by material.
fn collect(models: Vec<tobj::Model>, material_count: usize) -> Corners {
    let mut meshes: Vec<tobj::Mesh> = models.into_iter().map(|model| model.mesh).collect();
    meshes.sort_by_key(material_of);

    let mut corners = Corners::default();
    let mut meshes = meshes.into_iter().peekable();
    for material in 0..material_count {
        while let Some(mesh) = meshes.next_if(|mesh| material_of(mesh) == material) {
            append(&mut corners, &mesh);
        }
        corners.end_material();
    }
    debug_assert!(meshes.next().is_none(), "a mesh of a material that does not exist");
    corners
}

/// The index of a mesh's material in [`Model::materials`], where the default comes first.
fn material_of(mesh: &tobj::Mesh) -> usize {
    mesh.material_id.map_or(0, |id| id + 1)
}

/// Adds the faces of a mesh in plain form, in which every corner has all three indices.
fn append(corners: &mut Corners, mesh: &tobj::Mesh) {
    let points: Vec<u32> = triples(&mesh.positions).map(|p| corners.point_at(p)).collect();
    let normals: Vec<Vec3> = triples(&mesh.normals).collect();
    let uvs: Vec<Vec2> = mesh.texcoords.chunks_exact(2).map(Vec2::from_slice).collect();

    // `tobj` leaves the numbers of sides out where all faces are triangles.
    let sides = &mesh.face_arities;
    let face_count = if sides.is_empty() { mesh.indices.len() / 3 } else { sides.len() };
    corners.reserve(mesh.indices.len(), face_count);
    let mut indices = mesh.indices.iter().zip(&mesh.texcoord_indices).zip(&mesh.normal_indices);
    for face in 0..face_count {
        let sides = sides.get(face).map_or(3, |&sides| sides as usize);
        for ((&point, &uv), &normal) in indices.by_ref().take(sides) {
            corners.push(points[point as usize], uvs[uv as usize], normals[normal as usize]);
        }
        corners.end_face();
    }
}

fn triples(numbers: &[f32]) -> impl Iterator<Item = Vec3> {
    numbers.chunks_exact(3).map(Vec3::from_slice)
}
