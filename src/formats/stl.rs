//! STL files, text or binary, by the crate `stl_io`.
//!
//! That crate is strict; what other programs write is brought to the form that it reads. The normals in the
//! files are those of the faces, where they are right at all, and are computed instead.

use std::io::{Cursor, Read, Seek};

use glam::{DVec3, Vec2, Vec3};

use crate::formats::limits::{MAX_CORNERS, begins_solid, lost_faces, too_many_corners};
use crate::model::corners::{BY_ANGLE, Corners};
use crate::model::{Material, Model};

/// The bytes of a binary file before its triangles, and those of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The model, unless there are no triangles, and warnings.
pub(super) fn read(
    mut bytes: Vec<u8>,
    crease_angle: f32,
) -> Result<(Option<Model>, Vec<String>), String> {
    let count = bytes
        .get(80..HEADER)
        .map_or(0, |count| u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])));
    let length = HEADER as u64 + TRIANGLE as u64 * count;
    let is_text = begins_solid(&bytes);
    // Some binary files begin with that word as well, but their length gives them away.
    if is_text && (length != bytes.len() as u64 || count == 0) {
        return collect(&mut Cursor::new(plain(&bytes)), 0, crease_angle);
    }
    if bytes.len() < HEADER {
        return Err(
            "it is neither STL text, which begins with `solid`, nor long enough for a binary \
                    STL file"
                .into(),
        );
    }
    let there = (bytes.len() - HEADER) as u64 / TRIANGLE as u64;
    // A head that is not taken for text, and that announces what is there.
    bytes[..80].fill(0);
    bytes[80..HEADER].copy_from_slice(&(count.min(there) as u32).to_le_bytes());
    let (model, mut warnings) = collect(&mut Cursor::new(bytes), there as usize, crease_angle)?;
    if there < count {
        warnings.push(format!(
            "it ends after {there} of the {count} triangles that it announces; was it cut off?"
        ));
    }
    Ok((model, warnings))
}

/// Reads a file that has so many triangles at the least, if that is known.
fn collect(
    file: &mut (impl Read + Seek),
    count: usize,
    crease_angle: f32,
) -> Result<(Option<Model>, Vec<String>), String> {
    let (mut corners, mut warnings, mut lost) = (Corners::around(DVec3::ZERO), Vec::new(), 0);
    corners.reserve(3 * count, count);
    let triangles = stl_io::create_stl_reader(file).map_err(|error| error.to_string())?;
    for (number, triangle) in triangles.enumerate() {
        let triangle = match triangle {
            Ok(triangle) => triangle.vertices.map(|vertex| Vec3::from_array(vertex.0)),
            Err(error) if number == 0 => return Err(format!("it cannot be read: {error}")),
            Err(error) => {
                warnings.push(format!("it cannot be read to its end: {error}"));
                break;
            }
        };
        if !triangle.iter().all(|position| position.is_finite()) {
            lost += 1;
            continue;
        }
        if 3 * (number as u64 + 1) > MAX_CORNERS {
            return Err(too_many_corners());
        }
        for position in triangle {
            let point = corners.point_near(position);
            corners.push(point, Vec2::NAN, Vec3::ZERO);
        }
        corners.end_face(BY_ANGLE);
    }
    warnings.extend(lost_faces(lost));
    if corners.is_empty() {
        return Ok((None, warnings));
    }
    corners.end_material();
    corners.recentre();
    let materials = vec![Material::default()];
    Ok((Some(Model::from_corners(corners, crease_angle, materials, Vec::new())), warnings))
}

/// The text of all solids as one, in small letters, without comments, and without normals, which may be NaN.
fn plain(bytes: &[u8]) -> Vec<u8> {
    let mut text = b"solid all\n".to_vec();
    for line in bytes.split(|&byte| byte == b'\n' || byte == b'\r') {
        let end = line.iter().position(|&byte| byte == b'#').unwrap_or(line.len());
        let line = line[..end].trim_ascii().to_ascii_lowercase();
        if line.starts_with(b"facet") {
            text.extend_from_slice(b"facet normal 0 0 0");
        } else if !line.is_empty() && !line.starts_with(b"solid") && !line.starts_with(b"endsolid")
        {
            // Names in other encodings are on the lines left out; what else is no UTF-8 is no STL.
            text.extend(line.into_iter().map(|byte| if byte.is_ascii() { byte } else { b'?' }));
        } else {
            continue;
        }
        text.push(b'\n');
    }
    text.extend_from_slice(b"endsolid\n");
    text
}
