//! OBJ text to positions, texture coordinates, normals, colours and faces, in one pass.
//!
//! Each line is read where its number is known, so that an error can name it. Indices are resolved to
//! count from 0 as they are read, but compared with the counts at the end only, because a face may stand
//! above what it refers to.
//!
//! A position that a face uses must be right. A texture coordinate or a normal that is wrong or missing is
//! [`NONE`] at the corners that refer to it; a face of fewer than three corners, which covers no pixel,
//! is left out; and the [`Notes`] count all of them.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};

use crate::obj::error::LineError;
use crate::obj::limits::{MAX_CORNERS, MAX_LIBRARIES, MAX_MATERIALS};
use crate::obj::lines::{excerpt, finite, split_word, statements, words};
use crate::obj::notes::{Note, Notes};
use crate::obj::vertex_color::VertexColors;

/// The index that stands for no texture coordinate, or no normal.
pub(super) const NONE: u32 = u32::MAX;

/// How computed normals go across the edges of a face: the number of its smoothing group, and
/// otherwise these two.
pub(super) use crate::model::corners::{BY_ANGLE, FLAT};

/// What an OBJ file says.
#[derive(Default)]
pub(super) struct Geometry {
    /// In the precision of the file.
    pub(super) positions: Vec<DVec3>,
    /// The colours of positions, if the file has any.
    pub(super) colors: VertexColors,
    /// With v up; NaN where the line is wrong.
    pub(super) uvs: Vec<Vec2>,
    /// Of any length; zero where the line is wrong.
    pub(super) normals: Vec<Vec3>,
    /// The position, texture coordinate and normal of each face corner.
    pub(super) corners: Vec<[u32; 3]>,
    /// The faces, in the order of the file.
    pub(super) faces: Vec<FaceLine>,
    /// The names that `usemtl` gives, each with the first line that has it. The first one is of faces
    /// that name none: empty, with line 0.
    pub(super) materials: Vec<(usize, String)>,
    /// The names in `mtllib` lines, with their lines.
    pub(super) libraries: Vec<(usize, String)>,
    /// What is left out.
    pub(super) notes: Notes,
}

/// A face.
#[derive(Clone, Copy)]
pub(super) struct FaceLine {
    /// Where its corners end in the list of all; they begin where those of the face before end.
    pub(super) end: u32,
    /// Index into [`Geometry::materials`].
    pub(super) material: u32,
    /// Its smoothing group, [`FLAT`] or [`BY_ANGLE`].
    pub(super) smoothing: u32,
}

/// Reads an OBJ file; an error comes with its line, counted from 1.
pub(super) fn parse(text: &str) -> Result<Geometry, (usize, LineError)> {
    let mut parser = Parser::new();
    for (line, statement) in statements(text) {
        parser.line = line;
        let (keyword, rest) = split_word(&statement);
        parser.statement(keyword, rest).map_err(|cause| (line, cause))?;
    }
    parser.finish()
}

/// The names of positions, texture coordinates and normals in messages.
const WHAT: [&str; 3] = ["position", "texture coordinate", "normal"];

/// The state between two lines.
struct Parser {
    geometry: Geometry,
    /// The index of each material by its name.
    material_of: HashMap<String, u32>,
    /// The material that faces get.
    material: u32,
    /// The smoothing of faces.
    smoothing: u32,
    /// The line that is read, counted from 1.
    line: usize,
    /// The positions that are wrong, with line and cause.
    wrong_positions: HashMap<u32, (usize, LineError)>,
    /// For each of [`WHAT`], references to what was not yet there, each higher than the one before,
    /// and their lines.
    ahead: [Vec<(u32, usize)>; 3],
}

impl Parser {
    fn new() -> Self {
        let materials = vec![(0, String::new())];
        Self {
            geometry: Geometry { materials, ..Geometry::default() },
            material_of: HashMap::new(),
            material: 0,
            smoothing: BY_ANGLE,
            line: 0,
            wrong_positions: HashMap::new(),
            ahead: [const { Vec::new() }; 3],
        }
    }

    fn statement(&mut self, keyword: &str, rest: &str) -> Result<(), LineError> {
        match keyword {
            "v" => self.position(rest)?,
            "vt" => self.uv(rest)?,
            "vn" => self.normal(rest)?,
            "f" | "fo" => self.face(rest)?,
            "usemtl" => self.use_material(rest)?,
            "mtllib" => self.library(rest),
            "s" => self.smooth(rest),
            "o" | "g" | "mg" => {}
            "#MRGB" => self.geometry.colors.add_mrgb(rest),
            other => self.unused(other),
        }
        Ok(())
    }

    fn unused(&mut self, keyword: &str) {
        let note = match keyword {
            "p" => Note::Unused("points (p)"),
            "l" => Note::Unused("lines (l)"),
            "vp" | "cstype" | "deg" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole"
            | "scrv" | "sp" | "end" | "con" | "bmat" | "step" | "ctech" | "stech" => {
                Note::Unused("curves and curved surfaces")
            }
            "usemap" | "maplib" => Note::Unused("texture map libraries (usemap, maplib)"),
            "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj" => {
                Note::Unused("render attributes")
            }
            "call" | "csh" => Note::Unused("calls of other files"),
            _ if keyword.starts_with('#') => return,
            _ => Note::Unknown(excerpt(keyword)),
        };
        self.geometry.notes.add(note, self.line);
    }

    fn position(&mut self, rest: &str) -> Result<(), LineError> {
        let index = self.count(0)?;
        let mut words = words(rest);
        let position = three(WHAT[0], &mut words).map(DVec3::from_array);
        self.geometry.positions.push(position.clone().unwrap_or(DVec3::NAN));
        match position {
            Ok(_) => {
                if let Some(word) = words.next()
                    && let Err(note) = self.geometry.colors.add(index, word, &mut words)
                {
                    self.geometry.notes.add(note, self.line);
                }
            }
            Err(cause) => {
                self.geometry.notes.add(Note::Position(cause.clone()), self.line);
                self.wrong_positions.insert(index, (self.line, cause));
            }
        }
        Ok(())
    }

    fn uv(&mut self, rest: &str) -> Result<(), LineError> {
        self.count(1)?;
        let mut words = words(rest);
        let mut number = || words.next().map(|word| finite(WHAT[1], word));
        let uv = match (number(), number()) {
            (None, _) => Err(LineError::TooFewNumbers { what: WHAT[1], needed: 1, found: 0 }),
            (Some(Err(cause)), _) | (_, Some(Err(cause))) => Err(cause),
            // One number is a texture coordinate along a line, which has no v.
            (Some(Ok(u)), None) => Ok(Vec2::new(u as f32, 0.0)),
            (Some(Ok(u)), Some(Ok(v))) => Ok(Vec2::new(u as f32, v as f32)),
        };
        let uv = uv.unwrap_or_else(|cause| {
            self.geometry.notes.add(Note::Uv(cause), self.line);
            Vec2::NAN
        });
        self.geometry.uvs.push(uv);
        Ok(())
    }

    fn normal(&mut self, rest: &str) -> Result<(), LineError> {
        self.count(2)?;
        let normal = three(WHAT[2], &mut words(rest)).unwrap_or_else(|cause| {
            self.geometry.notes.add(Note::Normal(cause), self.line);
            [0.0; 3]
        });
        self.geometry.normals.push(Vec3::from_array(normal.map(|n| n as f32)));
        Ok(())
    }

    /// How many positions, texture coordinates or normals there are so far, unless they are too many.
    fn count(&self, kind: usize) -> Result<u32, LineError> {
        let Geometry { positions, uvs, normals, .. } = &self.geometry;
        let count = [positions.len(), uvs.len(), normals.len()][kind];
        if count as u64 >= MAX_CORNERS {
            const MANY: [&str; 3] = ["positions", "texture coordinates", "normals"];
            return Err(LineError::TooMany { what: MANY[kind], limit: MAX_CORNERS });
        }
        Ok(count as u32)
    }

    fn face(&mut self, rest: &str) -> Result<(), LineError> {
        let start = self.geometry.corners.len();
        let Geometry { positions, uvs, normals, .. } = &self.geometry;
        let counts = [positions.len(), uvs.len(), normals.len()].map(|count| count as i64);
        if words(rest).nth(2).is_none() {
            let found = words(rest).count();
            self.geometry.notes.add(Note::ShortFace(found), self.line);
            return Ok(());
        }
        for word in words(rest) {
            if self.geometry.corners.len() as u64 == MAX_CORNERS {
                return Err(LineError::TooMany { what: "face corners", limit: MAX_CORNERS });
            }
            let corner = match plain_corner(word.as_bytes()) {
                Some(corner) => [0, 1, 2].map(|kind| self.zero_based(kind, corner[kind], &counts)),
                None => self.odd_corner(word, &counts)?,
            };
            self.geometry.corners.push(corner);
        }
        debug_assert!(self.geometry.corners.len() >= start + 3, "the words were counted");
        let (material, smoothing) = (self.material, self.smoothing);
        let end = self.geometry.corners.len() as u32;
        self.geometry.faces.push(FaceLine { end, material, smoothing });
        Ok(())
    }

    /// An index from 1, or 0 for none, as one from 0. It is noted if nothing has it so far.
    #[inline]
    fn zero_based(&mut self, kind: usize, from_one: u32, counts: &[i64; 3]) -> u32 {
        let index = from_one.wrapping_sub(1);
        if i64::from(from_one) > counts[kind] {
            self.refer_ahead(kind, index);
        }
        index
    }

    #[cold]
    fn refer_ahead(&mut self, kind: usize, index: u32) {
        let ahead = &mut self.ahead[kind];
        if ahead.last().is_none_or(|&(highest, _)| index > highest) {
            ahead.push((index, self.line));
        }
    }

    /// A corner that is not simply of whole numbers from 1 on.
    #[cold]
    fn odd_corner(&mut self, word: &str, counts: &[i64; 3]) -> Result<[u32; 3], LineError> {
        let mut parts = word.split('/');
        let what = WHAT[0];
        let index = parts.next().and_then(|part| part.parse::<i64>().ok());
        let index = index.ok_or_else(|| LineError::Corner { word: excerpt(word) })?;
        if index == 0 {
            return Err(LineError::ZeroIndex { what, word: excerpt(word) });
        }
        let out = || LineError::IndexOutOfRange { what, index, count: counts[0] as u64 };
        let position = resolve(index, counts[0]).ok_or_else(out)?;
        let mut corner = [self.zero_based(0, position, counts), NONE, NONE];
        for kind in [1, 2] {
            let part = parts.next().unwrap_or("");
            if part.is_empty() {
                continue;
            }
            let from_one = part.parse().ok().and_then(|index| resolve(index, counts[kind]));
            match from_one {
                Some(from_one) => corner[kind] = self.zero_based(kind, from_one, counts),
                None => self.geometry.notes.add(Note::Reference(WHAT[kind]), self.line),
            }
        }
        if parts.next().is_some() {
            self.geometry.notes.add(Note::Unused("parts of corners after v/vt/vn"), self.line);
        }
        Ok(corner)
    }

    fn use_material(&mut self, name: &str) -> Result<(), LineError> {
        if name.is_empty() {
            self.material = 0;
            return Ok(());
        }
        if let Some(&material) = self.material_of.get(name) {
            self.material = material;
            return Ok(());
        }
        let materials = &mut self.geometry.materials;
        if materials.len() > MAX_MATERIALS {
            return Err(LineError::TooMany { what: "materials", limit: MAX_MATERIALS as u64 });
        }
        self.material = materials.len() as u32;
        self.material_of.insert(name.to_owned(), self.material);
        materials.push((self.line, name.to_owned()));
        Ok(())
    }

    fn library(&mut self, names: &str) {
        let libraries = &mut self.geometry.libraries;
        // Some programs repeat the line for every object.
        if libraries.last().is_none_or(|(_, last)| last != names) && libraries.len() < MAX_LIBRARIES
        {
            libraries.push((self.line, names.to_owned()));
        }
    }

    fn smooth(&mut self, rest: &str) {
        let group = words(rest).next().unwrap_or("1");
        self.smoothing = match group.parse::<u32>() {
            Ok(group) => group.min(BY_ANGLE - 1),
            Err(_) if group.eq_ignore_ascii_case("on") => 1,
            // `off`, and what nobody knows.
            Err(_) => FLAT,
        };
    }

    fn finish(mut self) -> Result<Geometry, (usize, LineError)> {
        let Geometry { positions, uvs, normals, corners, notes, .. } = &mut self.geometry;
        let counts = [positions.len(), uvs.len(), normals.len()].map(|count| count as u32);
        let beyond = |kind: usize| {
            let highest = self.ahead[kind].iter().find(|&&(index, _)| index >= counts[kind]);
            highest.copied()
        };
        if let Some((index, line)) = beyond(0) {
            let (index, count) = (i64::from(index) + 1, u64::from(counts[0]));
            return Err((line, LineError::IndexOutOfRange { what: WHAT[0], index, count }));
        }
        for kind in [1, 2] {
            let Some((_, line)) = beyond(kind) else { continue };
            for corner in corners.iter_mut().filter(|corner| corner[kind] != NONE) {
                if corner[kind] >= counts[kind] {
                    corner[kind] = NONE;
                    notes.add(Note::Reference(WHAT[kind]), line);
                }
            }
        }
        if !self.wrong_positions.is_empty() {
            let used = corners.iter().filter_map(|corner| self.wrong_positions.get(&corner[0]));
            if let Some(error) = used.min_by_key(|(line, _)| *line) {
                return Err(error.clone());
            }
        }
        Ok(self.geometry)
    }
}

/// Three numbers.
fn three<'a>(
    what: &'static str,
    words: &mut impl Iterator<Item = &'a str>,
) -> Result<[f64; 3], LineError> {
    let mut numbers = [0.0; 3];
    for (found, number) in numbers.iter_mut().enumerate() {
        let word = words.next().ok_or(LineError::TooFewNumbers { what, needed: 3, found })?;
        *number = finite(what, word)?;
    }
    Ok(numbers)
}

/// A corner of whole numbers from 1 on, with 0 for what it leaves out; `None` for any other.
#[inline]
fn plain_corner(word: &[u8]) -> Option<[u32; 3]> {
    let mut corner = [0; 3];
    let (mut kind, mut digits) = (0, 0);
    for &byte in word {
        if byte == b'/' {
            kind += 1;
            // `0` is left to the other function, and so are empty parts but that of `1//2`.
            if kind > 2 || corner[0] == 0 || (digits > 0 && corner[kind - 1] == 0) {
                return None;
            }
            digits = 0;
        } else {
            digits += 1;
            // Nine digits fit.
            if !byte.is_ascii_digit() || digits > 9 {
                return None;
            }
            corner[kind] = corner[kind] * 10 + u32::from(byte - b'0');
        }
    }
    (corner[0] > 0 && (digits == 0 || corner[kind] > 0)).then_some(corner)
}

/// An index from 1 that stands for one from 1 on, or for one that goes back from -1; `None` for one that
/// leads nowhere, or farther ahead than there can be anything.
fn resolve(index: i64, count: i64) -> Option<u32> {
    let from_one = if index < 0 { (count + 1).checked_add(index)? } else { index };
    let from_one = u32::try_from(from_one).ok()?;
    (from_one > 0 && u64::from(from_one) <= MAX_CORNERS.max(1 << 31)).then_some(from_one)
}
