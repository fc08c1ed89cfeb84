//! OBJ text, checked and rewritten in the plain form that `tobj` reads without surprise.
//!
//! `tobj` counts no lines, takes `l` for a face, fails on tabs, and trusts indices. At a corner without
//! a texture coordinate or normal it quietly repeats the one of the corner before. So each line is
//! checked here, where its number is known, and written again. The plain text has:
//!
//! - `v` and `vn` with three numbers, `vt` with two;
//! - every corner as `v/vt/vn`, counted from the beginning of the file. The first `vt` is NaN and the
//!   first `vn` is zero, which stand for "none". A checked file cannot have that NaN itself, and a
//!   zero normal says no more than none;
//! - faces gathered by material, after all `v`, `vt` and `vn`, because a face may stand above what it
//!   refers to, and because `tobj` makes one mesh per material.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::obj::error::LineError;
use crate::obj::limits::{MAX_CORNERS, MAX_LIBRARIES, MAX_MATERIALS};
use crate::obj::lines::{excerpt, finite, split_word, statements, words};

/// An OBJ file in plain form.
pub(super) struct Plain {
    /// The lines `v`, `vt` and `vn`.
    attributes: String,
    /// The faces of each material. The first group is of faces that name none.
    groups: Vec<Group>,
    /// The names in `mtllib` lines, one string a line.
    pub(super) libraries: Vec<String>,
}

/// The faces of one material.
struct Group {
    /// The name that `usemtl` gives; empty in the first group.
    material: String,
    /// The first line with that name, counted from 1; 0 in the first group.
    line: usize,
    /// The lines `f`.
    faces: String,
}

impl Plain {
    pub(super) fn has_faces(&self) -> bool {
        self.groups.iter().any(|group| !group.faces.is_empty())
    }

    /// The materials that faces name, each with the line that first names it.
    pub(super) fn materials(&self) -> impl Iterator<Item = (usize, &str)> {
        let used = self.groups.iter().skip(1).filter(|group| !group.faces.is_empty());
        used.map(|group| (group.line, group.material.as_str()))
    }

    pub(super) fn into_text(self) -> String {
        let mut text = self.attributes;
        for group in self.groups.into_iter().filter(|group| !group.faces.is_empty()) {
            if !group.material.is_empty() {
                text.extend(["usemtl ", &group.material, "\n"]);
            }
            text.push_str(&group.faces);
        }
        text
    }
}

/// Checks and rewrites an OBJ file; an error comes with its line, counted from 1.
pub(super) fn rewrite(text: &str) -> Result<Plain, (usize, LineError)> {
    let mut rewriter = Rewriter::new();
    for (line, statement) in statements(text) {
        rewriter.line = line;
        let (keyword, rest) = split_word(&statement);
        rewriter.statement(keyword, rest).map_err(|cause| (line, cause))?;
    }
    rewriter.finish()
}

/// A kind of value that corners refer to.
struct Attribute {
    /// Its name in messages.
    what: &'static str,
    /// The first word of its lines.
    keyword: &'static str,
    /// How many numbers it has in the plain text.
    size: usize,
    /// How many of them the file must give.
    needed: usize,
    /// How many values the plain text has before those of the file.
    shift: u64,
}

/// In the order of `v/vt/vn`.
const ATTRIBUTES: [Attribute; 3] = [
    Attribute { what: "position", keyword: "v", size: 3, needed: 3, shift: 0 },
    Attribute { what: "texture coordinate", keyword: "vt", size: 2, needed: 1, shift: 1 },
    Attribute { what: "normal", keyword: "vn", size: 3, needed: 3, shift: 1 },
];

/// The state between two lines.
struct Rewriter {
    plain: Plain,
    /// The group of each material by its name.
    group_of: HashMap<String, usize>,
    /// The group that faces go to.
    group: usize,
    /// The line that is read, counted from 1.
    line: usize,
    /// How many face corners there are so far.
    corners: u64,
    /// How many of each of [`ATTRIBUTES`] there are so far.
    counts: [u64; 3],
    /// The highest index to each of them, and the line that has it. At the end they are compared with
    /// the counts.
    highest: [(u64, usize); 3],
}

impl Rewriter {
    fn new() -> Self {
        let attributes = "mtllib -\nvt nan nan\nvn 0 0 0\n".to_owned();
        let groups = vec![Group { material: String::new(), line: 0, faces: String::new() }];
        Self {
            plain: Plain { attributes, groups, libraries: Vec::new() },
            group_of: HashMap::new(),
            group: 0,
            line: 0,
            corners: 0,
            counts: [0; 3],
            highest: [(0, 0); 3],
        }
    }

    fn statement(&mut self, keyword: &str, rest: &str) -> Result<(), LineError> {
        match keyword {
            "v" => self.attribute(0, rest)?,
            "vt" => self.attribute(1, rest)?,
            "vn" => self.attribute(2, rest)?,
            "f" => self.face(rest)?,
            "usemtl" => self.use_material(rest)?,
            "mtllib" => self.library(rest),
            _ => {}
        }
        Ok(())
    }

    fn attribute(&mut self, kind: usize, rest: &str) -> Result<(), LineError> {
        let Attribute { what, keyword, size, needed, .. } = ATTRIBUTES[kind];
        let out = &mut self.plain.attributes;
        out.push_str(keyword);
        let mut found = 0;
        for word in words(rest).take(size) {
            finite(what, word)?;
            out.extend([" ", word]);
            found += 1;
        }
        if found < needed {
            return Err(LineError::TooFewNumbers { what, needed, found });
        }
        // One number is a texture coordinate along a line, which has no v.
        out.extend((found..size).map(|_| " 0"));
        out.push('\n');
        self.counts[kind] += 1;
        Ok(())
    }

    fn face(&mut self, rest: &str) -> Result<(), LineError> {
        let found = words(rest).count();
        if found < 3 {
            return Err(LineError::TooFewCorners { found });
        }
        self.corners += found as u64;
        if self.corners > MAX_CORNERS {
            return Err(LineError::TooMany { what: "face corners", limit: MAX_CORNERS });
        }
        self.plain.groups[self.group].faces.push('f');
        for word in words(rest) {
            let [v, vt, vn] = self.corner(word)?;
            // Writing to a string cannot fail.
            let _ = write!(self.plain.groups[self.group].faces, " {v}/{vt}/{vn}");
        }
        self.plain.groups[self.group].faces.push('\n');
        Ok(())
    }

    /// What a corner refers to, counted from 1 in the plain text.
    fn corner(&mut self, word: &str) -> Result<[u64; 3], LineError> {
        let mut parts = word.split('/');
        let parts = [parts.next(), parts.next(), parts.next(), parts.next()];
        let [Some(v), vt, vn, None] = parts else {
            return Err(LineError::Corner { word: excerpt(word) });
        };
        let position = self.resolve(0, v, word)?;
        let mut optional = |kind, part: Option<&str>| match part {
            None | Some("") => Ok(1),
            Some(part) => self.resolve(kind, part, word),
        };
        Ok([position, optional(1, vt)?, optional(2, vn)?])
    }

    /// An index of a corner, counted from 1 in the plain text.
    fn resolve(&mut self, kind: usize, part: &str, word: &str) -> Result<u64, LineError> {
        let Attribute { what, shift, .. } = ATTRIBUTES[kind];
        let count = self.counts[kind];
        let index: i64 = part.parse().map_err(|_| LineError::Corner { word: excerpt(word) })?;
        let from_one = match index {
            0 => return Err(LineError::ZeroIndex { what, word: excerpt(word) }),
            1.. => index.unsigned_abs(),
            // -1 is the one just above.
            _ => (count + 1)
                .checked_sub(index.unsigned_abs())
                .filter(|&from_one| from_one > 0)
                .ok_or(LineError::IndexOutOfRange { what, index, count })?,
        };
        self.highest[kind] = self.highest[kind].max((from_one, self.line));
        Ok(from_one + shift)
    }

    fn use_material(&mut self, name: &str) -> Result<(), LineError> {
        if name.is_empty() {
            self.group = 0;
            return Ok(());
        }
        if let Some(&group) = self.group_of.get(name) {
            self.group = group;
            return Ok(());
        }
        self.group = self.plain.groups.len();
        if self.group > MAX_MATERIALS {
            return Err(LineError::TooMany { what: "materials", limit: MAX_MATERIALS as u64 });
        }
        self.group_of.insert(name.to_owned(), self.group);
        self.plain.groups.push(Group {
            material: name.to_owned(),
            line: self.line,
            faces: String::new(),
        });
        Ok(())
    }

    fn library(&mut self, names: &str) {
        let libraries = &mut self.plain.libraries;
        // Some programs repeat the line for every object.
        if libraries.last().is_none_or(|last| last != names) && libraries.len() < MAX_LIBRARIES {
            libraries.push(names.to_owned());
        }
    }

    fn finish(self) -> Result<Plain, (usize, LineError)> {
        for ((attribute, count), (index, line)) in
            ATTRIBUTES.iter().zip(self.counts).zip(self.highest)
        {
            if index > count {
                // It was read as an `i64`, so it fits.
                let index = index as i64;
                let what = attribute.what;
                return Err((line, LineError::IndexOutOfRange { what, index, count }));
            }
        }
        Ok(self.plain)
    }
}
