//! PLY files, text or binary, by the crate `ply-rs-bw`.

use std::io::BufReader;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3, Vec4};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult,
};

use crate::color::decode;
use crate::formats::found::{Corner, Found};
use crate::formats::limits::MAX_CORNERS;
use crate::model::Material;
use crate::texture::Texture;

/// The most bytes of a header.
const MAX_HEADER: usize = 1 << 20;

pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Found, String> {
    let (text, body) = parted(bytes).ok_or("it is no PLY file: its header has no end")?;
    let mut found = Found::new();
    let textured = open_texture(&text, path, &mut found);
    let header = header(&text)?;
    let mut elements = Elements::new(header.encoding, body);
    let mut vertices: Vec<PlyVertex> = Vec::new();
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
                elements.each(element, |vertex| {
                    vertices.push(vertex);
                    Ok(())
                })?;
            }
            "face" => {
                let mut count = 0;
                let read = elements.each(element, |face: PlyFace| {
                    count += 1;
                    add(&mut found, &vertices, &face, textured)
                });
                match read {
                    Err(Wrong::Syntax(cause)) if count > 0 => {
                        let all = element.count;
                        let warning = format!("it ends after {count} of its {all} faces: {cause}");
                        found.warnings.push(warning);
                        // Where the next element begins is not known.
                        break;
                    }
                    read => read?,
                }
            }
            _ => {
                elements.each(element, |Ignored| Ok(()))?;
                if element.count > 0 {
                    found.warnings.push(format!("elements `{}` are not used", excerpt(name)));
                }
            }
        }
    }
    if found.is_empty() && !vertices.is_empty() {
        return Err("it is a cloud of points without faces, which are not drawn".into());
    }
    Ok(found.finish())
}

/// The text of the header, and the bytes that follow it.
fn parted(bytes: &[u8]) -> Option<(String, &[u8])> {
    let most = &bytes[..bytes.len().min(MAX_HEADER)];
    let mark = b"end_header";
    let is_line = |at: &usize| *at == 0 || matches!(bytes[at - 1], b'\n' | b'\r');
    let ends = most.windows(mark.len()).enumerate().filter(|(_, word)| word == mark);
    let end = ends.map(|(at, _)| at).find(is_line)? + mark.len();
    let text = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let blanks = bytes[end..].iter().take_while(|&&byte| matches!(byte, b' ' | b'\t')).count();
    let rest = &bytes[end + blanks..];
    let body = match rest {
        [b'\r', b'\n', body @ ..] | [b'\n' | b'\r', body @ ..] => body,
        body => body,
    };
    Some((text, body))
}

/// What the header says. Comments are left out, and so are lines that programs write where comments should
/// be.
fn header(text: &str) -> Result<Header, String> {
    let words = ["ply", "format", "element", "property", "end_header"];
    let lines = text.split(['\n', '\r']).map(str::trim);
    let lines = lines.filter(|line| words.iter().any(|&word| line.split(' ').next() == Some(word)));
    let plain: String = lines.flat_map(|line| [line, "\n"]).collect();
    let mut reader = Reader::new(BufReader::new(plain.as_bytes()));
    let read = Parser::<Ignored>::new().read_header(&mut reader);
    read.map_err(|error| format!("it is no PLY file that can be read: {}", sentence(&error)))
}

/// Opens the picture that MeshLab and its like name in a comment. Returns whether there is one.
fn open_texture(header: &str, path: &Path, found: &mut Found) -> bool {
    let names = header.split(['\n', '\r']).filter_map(|line| {
        line.trim().strip_prefix("comment")?.trim().strip_prefix("TextureFile").map(str::trim)
    });
    let mut names = names.filter(|name| !name.is_empty());
    let Some(name) = names.next() else { return false };
    if names.next().is_some() {
        found.warnings.push("of its pictures only the first is used".into());
    }
    // The last part of the name, in the model's folder.
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let opened = check_regular(&path.with_file_name(name))
        .map_err(|error| format!("cannot read {}: {error}", excerpt(name)))
        .and_then(|file| Texture::open(file).map_err(|error| error.to_string()));
    match opened {
        Ok(texture) => {
            let mut material = Material::new("picture", Vec3::ONE);
            material.texture = Some(found.textures.len());
            found.textures.push(texture);
            found.materials.push(material);
            true
        }
        Err(cause) => {
            found.warnings.push(format!("the model stays without its picture: {cause}"));
            false
        }
    }
}

fn check_regular(file: &Path) -> std::io::Result<&Path> {
    let sentence = "it is not a regular file";
    if std::fs::metadata(file)?.is_file() { Ok(file) } else { Err(std::io::Error::other(sentence)) }
}

/// What is wrong with a file.
enum Wrong {
    /// What cannot be parsed.
    Syntax(String),
    /// What leads nowhere.
    Sense(String),
}

impl From<Wrong> for String {
    fn from(wrong: Wrong) -> Self {
        match wrong {
            Wrong::Syntax(cause) => format!("it is no PLY file that can be read: {cause}"),
            Wrong::Sense(cause) => cause,
        }
    }
}

/// The elements of a file, one after the other.
struct Elements<'a> {
    encoding: Encoding,
    rest: &'a [u8],
    line: String,
}

impl<'a> Elements<'a> {
    fn new(encoding: Encoding, rest: &'a [u8]) -> Self {
        Self { encoding, rest, line: String::new() }
    }

    /// Hands over all elements of a kind.
    fn each<E: PropertyAccess>(
        &mut self,
        element: &ElementDef,
        mut take: impl FnMut(E) -> Result<(), String>,
    ) -> Result<(), Wrong> {
        let parser = Parser::<E>::new();
        for _ in 0..element.count {
            let read = match self.encoding {
                Encoding::Ascii => {
                    self.next_line()?;
                    parser.read_ascii_element(&self.line, element)
                }
                Encoding::BinaryLittleEndian => {
                    parser.read_little_endian_element(&mut self.rest, element)
                }
                Encoding::BinaryBigEndian => {
                    parser.read_big_endian_element(&mut self.rest, element)
                }
            };
            take(read.map_err(|error| Wrong::Syntax(sentence(&error)))?).map_err(Wrong::Sense)?;
        }
        Ok(())
    }

    /// Goes on to the next line of text that is neither blank nor a comment.
    fn next_line(&mut self) -> Result<(), Wrong> {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let end = end.unwrap_or(self.rest.len());
            let line = self.rest[..end].trim_ascii();
            self.rest = self.rest.get(end + 1..).unwrap_or_default();
            if !line.is_empty() && !line.starts_with(b"comment") {
                self.line.clear();
                self.line.push_str(&String::from_utf8_lossy(line));
                self.line.push('\n');
                return Ok(());
            }
        }
        Err(Wrong::Syntax("the file ends before its elements; was it cut off?".into()))
    }
}

/// A message of another crate, on one line of moderate length.
fn sentence(error: &ParseError) -> String {
    let text = error.to_string();
    let plain = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    let mut sentence: String = plain.take(300).collect();
    if sentence.len() < text.len() {
        sentence += "...";
    }
    sentence
}

fn excerpt(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(40).collect()
}

/// Adds a face, which comes after its vertices.
fn add(
    found: &mut Found,
    vertices: &[PlyVertex],
    face: &PlyFace,
    textured: bool,
) -> Result<(), String> {
    let mut corners = Vec::with_capacity(face.indices.len().min(1 << 16));
    let mut has_uv = true;
    for (i, &index) in face.indices.iter().enumerate() {
        let vertex = usize::try_from(index).ok().and_then(|index| vertices.get(index));
        let count = vertices.len();
        let vertex = vertex.ok_or_else(|| {
            format!("a face refers to vertex {index}, counted from 0, but there are only {count}")
        })?;
        let mut corner = vertex.corner();
        // Two numbers for each corner, beside the face.
        if let Some(&[u, v]) = face.uvs.get(2 * i..2 * i + 2) {
            corner.uv = Vec2::new(u, v);
        }
        if let Some(color) = face.color() {
            corner.color = color;
        }
        has_uv &= !corner.uv.is_nan();
        corners.push(corner);
    }
    let material = usize::from(textured && has_uv);
    if material > 0 {
        // The picture has all colours there are.
        corners.iter_mut().for_each(|corner| corner.color = Vec4::ONE);
    }
    found.face(corners, material)
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
