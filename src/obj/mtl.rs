//! MTL text, checked and rewritten as OBJ text is.
//!
//! `tobj` drops a whole MTL file for one bad line, panics on a `Kd` of one number, and takes the
//! options of `map_Kd` for part of the file name. The plain text has only `newmtl`, `Kd` with three
//! numbers, and `map_Kd` with the name of a file below the OBJ file's folder.

use std::collections::HashSet;
use std::path::Path;

use crate::obj::error::LineError;
use crate::obj::file::read_text;
use crate::obj::limits::{MAX_LIBRARIES, MAX_MATERIALS, MAX_MTL_BYTES};
use crate::obj::lines::{finite, split_word, statements, words};
use crate::obj::paths::{beside, inside, is_rooted, unquoted};
use crate::obj::warning::{Warning, Warnings};

/// The plain text of all MTL files that the OBJ file `obj` names in its `mtllib` lines.
pub(super) fn rewrite(obj: &Path, libraries: &[String], warnings: &mut Warnings) -> String {
    let mut seen = HashSet::new();
    let names = libraries.iter().flat_map(|line| library_names(obj, line));
    let files = names.filter(|file| seen.insert(file.clone())).take(MAX_LIBRARIES);

    let mut rewriter = Rewriter::default();
    let mut bytes_left = MAX_MTL_BYTES;
    for file in files {
        let path = beside(obj, &file);
        match read_text(&path, bytes_left) {
            Ok(text) => {
                bytes_left = bytes_left.saturating_sub(text.len() as u64);
                rewriter.file(&path, &file, &text, warnings);
            }
            Err(source) => warnings.add(Warning::MaterialFile { path, source }),
        }
    }
    rewriter.text
}

/// The files that an `mtllib` line names: one file with spaces in its name if there is such a file,
/// else one for each word.
fn library_names(obj: &Path, line: &str) -> Vec<String> {
    let whole = inside(line);
    if beside(obj, &whole).is_file() {
        vec![whole]
    } else {
        line.split_whitespace().map(inside).collect()
    }
}

#[derive(Default)]
struct Rewriter {
    text: String,
    /// How many materials there are so far, in all files.
    count: usize,
    /// Whether the lines to come belong to a material.
    in_material: bool,
}

impl Rewriter {
    /// Adds the text of a file whose path from the OBJ file's folder is `file`.
    fn file(&mut self, path: &Path, file: &str, text: &str, warnings: &mut Warnings) {
        let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
        self.in_material = false;
        for (line, statement) in statements(text) {
            let (keyword, rest) = split_word(&statement);
            if let Err(cause) = self.statement(folder, keyword, rest) {
                warnings.add(Warning::MaterialLine { path: path.to_owned(), line, cause });
            }
        }
    }

    fn statement(&mut self, folder: &str, keyword: &str, rest: &str) -> Result<(), LineError> {
        if keyword.eq_ignore_ascii_case("newmtl") {
            self.material(rest)
        } else if self.in_material && keyword.eq_ignore_ascii_case("Kd") {
            self.diffuse(rest)
        } else if self.in_material && keyword.eq_ignore_ascii_case("map_Kd") {
            self.texture(folder, rest)
        } else {
            Ok(())
        }
    }

    fn material(&mut self, name: &str) -> Result<(), LineError> {
        self.in_material = false;
        if name.is_empty() {
            return Err(LineError::NoName { keyword: "newmtl" });
        }
        if self.count == MAX_MATERIALS {
            return Err(LineError::TooMany { what: "materials", limit: MAX_MATERIALS as u64 });
        }
        self.in_material = true;
        self.count += 1;
        self.text.extend(["newmtl ", name, "\n"]);
        Ok(())
    }

    fn diffuse(&mut self, rest: &str) -> Result<(), LineError> {
        let what = "colour";
        for word in words(rest).take(3) {
            finite(what, word)?;
        }
        let mut words = words(rest);
        let [r, g, b] = match [words.next(), words.next(), words.next()] {
            [Some(r), Some(g), Some(b)] => [r, g, b],
            // The format says that one number stands for all three.
            [Some(grey), None, None] => [grey, grey, grey],
            given => {
                let found = given.iter().flatten().count();
                return Err(LineError::TooFewNumbers { what, needed: 3, found });
            }
        };
        self.text.extend(["Kd ", r, " ", g, " ", b, "\n"]);
        Ok(())
    }

    fn texture(&mut self, folder: &str, rest: &str) -> Result<(), LineError> {
        let name = unquoted(without_options(rest));
        let file = if folder.is_empty() || is_rooted(name) {
            inside(name)
        } else {
            inside(&format!("{folder}/{name}"))
        };
        if name.is_empty() || file.is_empty() {
            return Err(LineError::NoName { keyword: "map_Kd" });
        }
        self.text.extend(["map_Kd ", &file, "\n"]);
        Ok(())
    }
}

/// The file name, spaces and all, after the options of a texture map.
fn without_options(mut text: &str) -> &str {
    loop {
        let (option, mut rest) = split_word(text);
        let (least, most) = match option {
            "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-clamp" | "-imfchan"
            | "-texres" | "-type" => (1, 1),
            "-mm" => (2, 2),
            // One number for each direction that matters.
            "-o" | "-s" | "-t" => (1, 3),
            _ => return text,
        };
        for i in 0..most {
            let (argument, after) = split_word(rest);
            let goes_on = i < least || argument.parse::<f32>().is_ok() && !after.is_empty();
            if !goes_on {
                break;
            }
            rest = after;
        }
        text = rest;
    }
}
