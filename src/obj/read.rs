//! The steps from an OBJ file to a model.

use std::collections::HashMap;
use std::path::Path;

use glam::{Vec2, Vec3};

use crate::model::corners::{Corners, origin};
use crate::model::{Material, Model};
use crate::obj::error::ObjError;
use crate::obj::file::{decode, read_text};
use crate::obj::geometry::{self, Geometry, NONE};
use crate::obj::limits::MAX_OBJ_BYTES;
use crate::obj::lines::without_comment;
use crate::obj::paths::Finder;
use crate::obj::warning::{Warning, Warnings};
use crate::obj::{materials, mtl};

/// Reads an OBJ file and the files that it refers to, which lie below its folder or below `root`. The crease
/// angle is in radians, from 0 to pi.
pub(super) fn read(
    path: &Path,
    crease_angle: f32,
    root: Option<&Path>,
) -> Result<(Model, Vec<Warning>), ObjError> {
    let unreadable = |source| ObjError::Read { path: path.to_owned(), source };
    from_text(path, read_text(path, MAX_OBJ_BYTES).map_err(unreadable)?, crease_angle, root)
}

/// Reads the bytes of an OBJ file, and the files that it refers to beside `path`.
pub(super) fn read_bytes(
    bytes: Vec<u8>,
    path: &Path,
    crease_angle: f32,
    root: Option<&Path>,
) -> Result<(Model, Vec<Warning>), ObjError> {
    from_text(path, decode(bytes), crease_angle, root)
}

fn from_text(
    path: &Path,
    text: String,
    crease_angle: f32,
    root: Option<&Path>,
) -> Result<(Model, Vec<Warning>), ObjError> {
    let mut warnings = Warnings::default();
    let mut geometry = geometry::parse(&text).map_err(|(line, cause)| ObjError::Line {
        path: path.to_owned(),
        line,
        cause,
    })?;
    drop(text);
    warnings.add_notes(path, std::mem::take(&mut geometry.notes));
    if geometry.faces.is_empty() {
        let warnings = warnings.into_list().iter().map(ToString::to_string).collect();
        return Err(ObjError::NoFaces { path: path.to_owned(), warnings });
    }

    let mut finder = Finder::new(path, root);
    let is_plain = geometry.materials.len() == 1 && geometry.libraries.is_empty();
    let entries = if is_plain {
        Vec::new()
    } else {
        mtl::read(path, &geometry.libraries, &mut finder, &mut warnings)
    };
    let has_colors = !geometry.colors.is_empty();
    let (materials, textures) = materials::open(entries, has_colors, &mut finder, &mut warnings);
    let material_of = link(path, &geometry, &materials, &mut warnings);
    let corners = collect(&geometry, &material_of, materials.len());
    drop(geometry);
    let model = Model::from_corners(corners, crease_angle, materials, textures);
    Ok((model, warnings.into_list()))
}

/// The index of the material that each name in the OBJ file stands for; 0, the default one, for those that
/// no MTL file defines.
fn link(
    path: &Path,
    geometry: &Geometry,
    materials: &[Material],
    warnings: &mut Warnings,
) -> Vec<usize> {
    let named = || materials.iter().enumerate().skip(1);
    let by_name: HashMap<&str, usize> = named().map(|(i, m)| (m.name.as_str(), i)).collect();
    // What follows ` #` is a comment where the whole is no name.
    let plain = named().filter_map(|(i, m)| Some((without_comment(&m.name)?, i)));
    let by_plain_name: HashMap<&str, usize> = plain.collect();

    let mut is_used = vec![false; geometry.materials.len()];
    for face in &geometry.faces {
        is_used[face.material as usize] = true;
    }
    let mut linked = Vec::with_capacity(geometry.materials.len());
    for ((line, name), is_used) in geometry.materials.iter().zip(is_used) {
        let plain = without_comment(name).unwrap_or(name);
        let tables = [by_name.get(name.as_str()), by_name.get(plain), by_plain_name.get(plain)];
        let index = tables.into_iter().flatten().next().copied();
        if index.is_none() && is_used && !name.is_empty() {
            let (path, name) = (path.to_owned(), plain.to_owned());
            warnings.add(Warning::UnknownMaterial { path, line: *line, name });
        }
        linked.push(index.unwrap_or(0));
    }
    linked
}

/// The face corners, material by material.
fn collect(geometry: &Geometry, material_of: &[usize], material_count: usize) -> Corners {
    let Geometry { positions, colors, uvs, normals, corners: all, faces, .. } = geometry;
    let used = all.iter().map(|corner| positions[corner[0] as usize]);
    let mut corners = Corners::around(origin(used));
    corners.reserve(all.len(), faces.len());
    let mut point_of = vec![NONE; positions.len()];
    let has_colors = !colors.is_empty();

    let mut add = |corners: &mut Corners, face: usize| {
        let start = if face == 0 { 0 } else { faces[face - 1].end as usize };
        for &[position, uv, normal] in &all[start..faces[face].end as usize] {
            let point = &mut point_of[position as usize];
            if *point == NONE {
                *point = corners.point_at(positions[position as usize]);
            }
            // Where there is none, `NONE` is beyond the end of the list.
            let uv = uvs.get(uv as usize).copied().unwrap_or(Vec2::NAN);
            let normal = normals.get(normal as usize).copied().unwrap_or(Vec3::ZERO);
            corners.push(*point, uv, normal);
            if has_colors {
                corners.color(colors.of(position));
            }
        }
        corners.end_face(faces[face].smoothing);
    };
    // Sorted by counting, which keeps the order of the file.
    let mut starts = vec![0; material_count + 1];
    for face in faces {
        starts[material_of[face.material as usize] + 1] += 1;
    }
    for i in 0..material_count {
        starts[i + 1] += starts[i];
    }
    let mut places = starts.clone();
    let mut order = vec![0; faces.len()];
    for (i, face) in (0_u32..).zip(faces) {
        let place = &mut places[material_of[face.material as usize]];
        order[*place] = i;
        *place += 1;
    }
    for material in 0..material_count {
        for &face in &order[starts[material]..starts[material + 1]] {
            add(&mut corners, face as usize);
        }
        corners.end_material();
    }
    corners
}
