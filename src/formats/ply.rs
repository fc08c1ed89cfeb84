//! PLY files, text or binary, by the crate `ply-rs-bw`.

use std::io::BufReader;

use glam::{DVec3, Vec2, Vec3, Vec4};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use crate::color::decode;
use crate::formats::found::{Corner, Found, MAX_CORNERS};

pub(super) fn read(bytes: &[u8]) -> Result<Found, String> {
    let wrong = |error: ply_rs_bw::parser::ParseError| {
        let mut sentence: String = error.to_string().chars().filter(|c| !c.is_control()).collect();
        if sentence.len() > 300 {
            sentence = sentence.chars().take(300).chain("...".chars()).collect();
        }
        format!("it is no PLY file that can be read: {sentence}")
    };
    let mut reader = Reader::new(BufReader::new(bytes));
    let header = Parser::<Ignored>::new().read_header(&mut reader).map_err(wrong)?;
    let mut vertices: Vec<PlyVertex> = Vec::new();
    let mut found = Found::new();
    let mut others = Vec::new();
    let mut has_faces = false;
    for (name, element) in &header.elements {
        // Each takes a byte at least, or the file announces more than it has.
        if element.count > bytes.len() || element.count as u64 > MAX_CORNERS {
            let count = element.count;
            return Err(format!(
                "it announces {count} elements `{}`, which is too many",
                excerpt(name)
            ));
        }
        match name.as_str() {
            "vertex" => {
                let parser = Parser::<PlyVertex>::new();
                vertices = parser
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(wrong)?;
            }
            "face" => {
                has_faces = true;
                let parser = Parser::<PlyFace>::new();
                let faces = parser
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(wrong)?;
                add(&mut found, &vertices, faces)?;
            }
            _ => {
                let parser = Parser::<Ignored>::new();
                parser.read_payload_for_element(&mut reader, element, &header).map_err(wrong)?;
                if element.count > 0 {
                    others.push(excerpt(name));
                }
            }
        }
    }
    for name in others {
        found.warnings.push(format!("elements `{name}` are not used"));
    }
    if !has_faces && !vertices.is_empty() {
        return Err("it is a cloud of points without faces, which are not drawn".into());
    }
    Ok(found.finish())
}

fn excerpt(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(40).collect()
}

/// Adds the faces, which come after their vertices.
fn add(found: &mut Found, vertices: &[PlyVertex], faces: Vec<PlyFace>) -> Result<(), String> {
    for face in faces {
        let count = face.indices.len();
        let mut corners = Vec::with_capacity(count.min(1 << 16));
        for (i, &index) in face.indices.iter().enumerate() {
            let vertex = usize::try_from(index).ok().and_then(|index| vertices.get(index));
            let count = vertices.len();
            let vertex = vertex.ok_or_else(|| {
                format!(
                    "a face refers to vertex {index}, counted from 0, but there are only {count}"
                )
            })?;
            let mut corner = vertex.corner();
            // Two numbers for each corner, beside the face.
            if let Some(&[u, v]) = face.uvs.get(2 * i..2 * i + 2) {
                corner.uv = Vec2::new(u, v);
            }
            if let Some(color) = face.color() {
                corner.color = color;
            }
            corners.push(corner);
        }
        found.face(corners, 0)?;
    }
    Ok(())
}

/// A vertex: what is not given is NaN.
#[derive(Clone, Copy)]
struct PlyVertex {
    position: DVec3,
    normal: Vec3,
    uv: Vec2,
    /// sRGB codes, and alpha from 0 to 1.
    color: Vec4,
}

impl PlyVertex {
    fn corner(&self) -> Corner {
        let normal = if self.normal.is_nan() { Vec3::ZERO } else { self.normal };
        Corner { uv: self.uv, normal, color: light(self.color), ..Corner::at(self.position) }
    }
}

/// The linear light of sRGB codes; white if there are none.
fn light(codes: Vec4) -> Vec4 {
    if codes.truncate().is_nan() {
        return Vec4::ONE;
    }
    let [r, g, b, a] = codes.to_array();
    let [r, g, b] = [r, g, b].map(|code| decode(code.round() as u8));
    Vec4::new(r, g, b, if a.is_nan() { 1.0 } else { a.clamp(0.0, 1.0) })
}

/// The number of a property, and what 1 is in its type: 255 in bytes.
fn number(property: &Property) -> Option<(f64, f64)> {
    Some(match *property {
        Property::Char(n) => (n.into(), 255.0),
        Property::UChar(n) => (n.into(), 255.0),
        Property::Short(n) => (n.into(), 65_535.0),
        Property::UShort(n) => (n.into(), 65_535.0),
        Property::Int(n) => (n.into(), 255.0),
        Property::UInt(n) => (n.into(), 255.0),
        Property::Float(n) => (n.into(), 1.0),
        Property::Double(n) => (n, 1.0),
        _ => return None,
    })
}

/// Sets a channel of a colour by its name.
fn set_color(color: &mut Vec4, name: &str, (number, one): (f64, f64)) -> bool {
    let fraction = (number / one) as f32;
    match name {
        "red" | "diffuse_red" | "r" => color.x = fraction * 255.0,
        "green" | "diffuse_green" | "g" => color.y = fraction * 255.0,
        "blue" | "diffuse_blue" | "b" => color.z = fraction * 255.0,
        "alpha" => color.w = fraction,
        _ => return false,
    }
    true
}

impl PropertyAccess for PlyVertex {
    fn new() -> Self {
        Self { position: DVec3::NAN, normal: Vec3::NAN, uv: Vec2::NAN, color: Vec4::NAN }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(number) = number(&property) else { return PropertyAccessResult::Ignored };
        let n = number.0;
        match name {
            "x" => self.position.x = n,
            "y" => self.position.y = n,
            "z" => self.position.z = n,
            "nx" => self.normal.x = n as f32,
            "ny" => self.normal.y = n as f32,
            "nz" => self.normal.z = n as f32,
            "u" | "s" | "texture_u" => self.uv.x = n as f32,
            "v" | "t" | "texture_v" => self.uv.y = n as f32,
            _ if set_color(&mut self.color, name, number) => {}
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A face.
struct PlyFace {
    indices: Vec<i64>,
    uvs: Vec<f32>,
    color: Vec4,
}

impl PlyFace {
    fn color(&self) -> Option<Vec4> {
        (!self.color.truncate().is_nan()).then(|| light(self.color))
    }
}

/// The whole numbers of a list.
fn integers(list: Property) -> Option<Vec<i64>> {
    Some(match list {
        Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
        _ => return None,
    })
}

impl PropertyAccess for PlyFace {
    fn new() -> Self {
        Self { indices: Vec::new(), uvs: Vec::new(), color: Vec4::NAN }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match (name, property) {
            ("vertex_index" | "vertex_indices", list) => match integers(list) {
                Some(indices) => self.indices = indices,
                None => return PropertyAccessResult::UnsupportedType,
            },
            ("texcoord", Property::ListFloat(list)) => self.uvs = list,
            (name, property) => {
                let number = number(&property);
                if !number.is_some_and(|number| set_color(&mut self.color, name, number)) {
                    return PropertyAccessResult::Ignored;
                }
            }
        }
        PropertyAccessResult::Set
    }
}

/// An element that is not used.
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}
