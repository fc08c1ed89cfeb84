//! glTF 2.0, as JSON or GLB, by the crate `gltf`.
//!
//! Read are the triangles of all meshes, where the nodes of the scene put them, with their normals, first
//! colours and the texture coordinates of the base colour; and of materials the base colour, what its
//! alpha means, emitted light, normal maps and occlusion. Tangents of materials with normal maps are those of the
//! file where it has normals as well, as the specification wants it, and else are computed, by MikkTSpace's method.
//! `formats::gltf::data` gets at the bytes, `formats::gltf::looks` at materials and textures.
//! Skins are drawn as they are modelled, and nothing moves.

use std::path::Path;

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};
use gltf::json::validation::Checked;
use gltf::mesh::{Mode, Primitive, Semantic};

use crate::formats::found::{Corner, Found};
use crate::formats::limits::MAX_CORNERS;

mod data;
mod looks;

use self::data::Data;

/// The most nodes that are placed.
const MAX_NODES: usize = 1 << 20;

pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Found, String> {
    let mut found = Found::new();
    let (document, blob) = parse(bytes, &mut found)?;
    let data = Data::open(&document, blob, path)?;
    looks::open(&document, &data, path, &mut found);
    place_all(&document, &data, &mut found)?;
    let unused = [
        ("animations", document.animations().len()),
        ("skins, beyond their rest pose,", document.skins().len()),
        ("cameras", document.cameras().len()),
    ];
    for (what, count) in unused.into_iter().filter(|&(_, count)| count > 0) {
        found.warnings.push(format!("{what} are not used ({count} in the file)"));
    }
    Ok(found.finish())
}

/// The document, whose indices all refer to something, and the bytes that come with it.
fn parse(bytes: &[u8], found: &mut Found) -> Result<(gltf::Document, Option<Vec<u8>>), String> {
    if let Some([_, _, _, _, a, b, c, d, ..]) = bytes.strip_prefix(b"glTF") {
        // The crate trusts it.
        let (length, there) = (u32::from_le_bytes([*a, *b, *c, *d]) as usize, bytes.len());
        if length > there {
            return Err(format!("it ends after {there} of its {length} bytes; was it cut off?"));
        }
        if length < MIN_GLB {
            return Err(format!("its head says that it has {length} bytes, which is too few"));
        }
    }
    let wrong = |error: gltf::Error| match is_version_1(bytes) {
        true => "it is glTF 1.0, which is not read: convert it to glTF 2.0".into(),
        false => format!("it is no glTF file that can be read: {}", sentence(&error)),
    };
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(bytes).map_err(wrong)?;
    let mut root = document.into_json();
    for extension in std::mem::take(&mut root.extensions_required) {
        if COMPRESSIONS.contains(&extension.as_str()) {
            return Err(format!(
                "its meshes are packed by {extension}, which is not read: unpack them"
            ));
        }
        if !is_read(&extension) {
            let name = sentence(&extension);
            found.warnings.push(format!("it needs the extension {name}, which is not used"));
        }
    }
    let scenes = root.scenes.len();
    root.scene = root.scene.filter(|scene| scene.value() < scenes);
    // Attributes of applications' own are none of ours.
    for primitive in root.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.attributes.retain(|semantic, _| matches!(semantic, Checked::Valid(_)));
    }
    // The checks that follow trust this index, and miss the bounds, which are not used.
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let positions = primitives
        .filter_map(|primitive| primitive.attributes.get(&Checked::Valid(Semantic::Positions)));
    for index in positions {
        let accessor = root.accessors.get_mut(index.value());
        let accessor = accessor.ok_or("a mesh refers to positions that are not in the file")?;
        let nothing = || gltf::json::serialize::to_value([0.0_f32; 3]).ok();
        accessor.min = accessor.min.take().or_else(nothing);
        accessor.max = accessor.max.take().or_else(nothing);
    }
    let packing = root.extensions_used.iter().find(|name| COMPRESSIONS.contains(&name.as_str()));
    let packing = packing.cloned();
    let document = gltf::Document::from_json(root).map_err(|error| match packing {
        Some(packing) => {
            format!("its meshes are packed by {packing}, which is not read: unpack them")
        }
        None => wrong(error),
    })?;
    Ok((document, blob))
}

/// The bytes of a GLB file's head, and of the head of its first chunk.
const MIN_GLB: usize = 20;

/// Extensions without which there is no geometry.
const COMPRESSIONS: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Whether a file that cannot be read is in the first version of the format.
fn is_version_1(bytes: &[u8]) -> bool {
    if let Some(rest) = bytes.strip_prefix(b"glTF") {
        return rest.starts_with(&1_u32.to_le_bytes());
    }
    // Lists of that version are maps from names.
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 20)]);
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    plain.contains("\"version\":\"1.") || plain.contains("\"accessors\":{")
}

/// What a file may require: what is read, and what only changes how light is reflected.
fn is_read(extension: &str) -> bool {
    extension == "KHR_mesh_quantization"
        || extension == "KHR_texture_transform"
        || extension.starts_with("KHR_materials_")
        || extension == "KHR_lights_punctual"
}

/// A message of another crate, on one line of moderate length.
fn sentence(error: &impl ToString) -> String {
    error.to_string().chars().filter(|c| !c.is_control()).take(200).collect()
}

/// Adds the meshes of all nodes of the scene, each where its node is.
fn place_all(document: &gltf::Document, data: &Data, found: &mut Found) -> Result<(), String> {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let mut nodes: Vec<_> = match scene {
        Some(scene) => scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect(),
        None => document.nodes().map(|node| (node, DMat4::IDENTITY)).collect(),
    };
    nodes.reverse();
    // A node has one parent. A file that says otherwise might have a circle.
    let mut is_placed = vec![false; document.nodes().len()];
    let mut unused = 0_u64;
    while let Some((node, parent)) = nodes.pop() {
        if std::mem::replace(&mut is_placed[node.index()], true) || nodes.len() > MAX_NODES {
            continue;
        }
        let [x, y, z, w] = node.transform().matrix().map(|column| column.map(f64::from));
        let place = parent * DMat4::from_cols_array_2d(&[x, y, z, w]);
        if let Some(mesh) = node.mesh() {
            // A skin says where its mesh is, by its bones.
            let place = if node.skin().is_some() { DMat4::IDENTITY } else { place };
            for primitive in mesh.primitives() {
                match primitive.mode() {
                    Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => {
                        add(&primitive, place, data, found)?;
                    }
                    _ => unused += 1,
                }
            }
        }
        let start = nodes.len();
        nodes.extend(node.children().map(|child| (child, place)));
        nodes[start..].reverse();
    }
    if unused > 0 {
        found.warnings.push(format!("points and lines are not used ({unused} in the file)"));
    }
    Ok(())
}

/// Adds the triangles of a primitive.
fn add(
    primitive: &Primitive<'_>,
    place: DMat4,
    data: &Data,
    found: &mut Found,
) -> Result<(), String> {
    let vertices = Vertices::of(primitive, place, data)?;
    let count = vertices.positions.len() / 3;
    let indices = match primitive.indices() {
        Some(accessor) => data.numbers(&accessor, 1)?.0.into_iter().map(|n| n as u32).collect(),
        None => (0..count as u32).collect::<Vec<_>>(),
    };
    let is_mirrored = DMat3::from_mat4(place).determinant() < 0.0;
    let material = primitive.material().index().map_or(0, |index| index + 1);
    let (mut wrong, mut lost) = (None, 0_u64);
    for mut triangle in triangles(&indices, primitive.mode()) {
        if is_mirrored {
            triangle.swap(1, 2);
        }
        let [Some(a), Some(b), Some(c)] = triangle.map(|index| vertices.corner(index)) else {
            wrong = wrong.or_else(|| triangle.into_iter().find(|&index| index as usize >= count));
            lost += 1;
            continue;
        };
        found.face([a, b, c], material)?;
    }
    if let Some(index) = wrong {
        found.warnings.push(format!(
            "a mesh refers to vertex {index}, counted from 0, but there are only {count}; {lost} \
             triangles are skipped"
        ));
    }
    Ok(())
}

/// The vertices of a primitive, as the file has them.
struct Vertices {
    positions: Vec<f64>,
    normals: Vec<f64>,
    /// Of four numbers each; nothing without normals, or without a normal map.
    tangents: Vec<f64>,
    uvs: Vec<f64>,
    colors: Vec<f64>,
    /// 3 or 4.
    color_size: usize,
    place: DMat4,
    /// Takes normals to the scene: the inverse transpose, times the determinant's amount, which may be zero.
    normal_turn: DMat3,
    /// -1 where the scene has it as in a mirror, or else 1.
    hand: f64,
}

impl Vertices {
    fn of(primitive: &Primitive<'_>, place: DMat4, data: &Data) -> Result<Self, String> {
        let numbers = |semantic: &Semantic, least: usize| match primitive.get(semantic) {
            Some(accessor) => data.numbers(&accessor, least),
            None => Ok((Vec::new(), least)),
        };
        let (positions, 3) = numbers(&Semantic::Positions, 3)? else {
            return Err("a mesh has positions of four numbers".into());
        };
        let list = |(list, size), wanted| if size == wanted { list } else { Vec::new() };
        let normals = list(numbers(&Semantic::Normals, 3)?, 3);
        let has_frames = !normals.is_empty() && primitive.material().normal_texture().is_some();
        let tangents =
            if has_frames { list(numbers(&Semantic::Tangents, 4)?, 4) } else { Vec::new() };
        let uv_set = looks::uv_set(&primitive.material());
        let uvs = list(numbers(&Semantic::TexCoords(uv_set), 2)?, 2);
        let (colors, color_size) = numbers(&Semantic::Colors(0), 3)?;
        let turn = DMat3::from_mat4(place);
        let [x, y, z] = [turn.x_axis, turn.y_axis, turn.z_axis];
        let hand = if turn.determinant() < 0.0 { -1.0 } else { 1.0 };
        let normal_turn = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * hand;
        Ok(Self { positions, normals, tangents, uvs, colors, color_size, place, normal_turn, hand })
    }

    /// A vertex in the scene; `None` if there is none of the index.
    fn corner(&self, index: u32) -> Option<Corner> {
        let i = index as usize;
        let triple = |list: &[f64]| list.get(3 * i..3 * i + 3).map(DVec3::from_slice);
        let mut corner = Corner::at(self.place.transform_point3(triple(&self.positions)?));
        if let Some(normal) = triple(&self.normals) {
            corner.normal = (self.normal_turn * normal).normalize_or_zero().as_vec3();
        }
        if let Some(&[x, y, z, w]) = self.tangents.get(4 * i..4 * i + 4) {
            let turned = self.place.transform_vector3(DVec3::new(x, y, z)).normalize_or_zero();
            if turned != DVec3::ZERO && !w.is_nan() {
                corner.tangent = turned.as_vec3().extend((self.hand * w).signum() as f32);
            }
        }
        if let Some(&[u, v]) = self.uvs.get(2 * i..2 * i + 2) {
            // With v up, as other files have it.
            corner.uv = Vec2::new(u as f32, (1.0 - v) as f32);
        }
        if let Some(color) = self.colors.get(self.color_size * i..self.color_size * (i + 1)) {
            let alpha = color.get(3).map_or(1.0, |&alpha| alpha as f32);
            let [r, g, b] = [color[0], color[1], color[2]].map(|channel| channel as f32);
            corner.color = Vec3::new(r, g, b).extend(alpha);
        }
        Some(corner)
    }
}

/// The triangles of a list, a strip or a fan.
fn triangles(indices: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    debug_assert!(indices.len() as u64 <= 4 * MAX_CORNERS, "bounded where they are read");
    match mode {
        Mode::TriangleStrip => (indices.windows(3).enumerate())
            // Every second one runs the other way round.
            .map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })
            .collect(),
        Mode::TriangleFan => {
            let Some((&first, rest)) = indices.split_first() else { return Vec::new() };
            rest.windows(2).map(|t| [first, t[0], t[1]]).collect()
        }
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
