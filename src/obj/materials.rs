//! MTL text, checked and rewritten as OBJ text is, and the textures it names.
//!
//! `tobj` drops a whole MTL file for one bad line, panics on a `Kd` of one number, and takes the
//! options of `map_Kd` for part of the file name. The plain text has only `newmtl`, `Kd` with three
//! numbers, and `map_Kd` with the name of a file below the OBJ file's folder.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::plain::{finite, split_word, statements, words};
use super::{
    LineError, MAX_FILE_TEXELS, MAX_LIBRARIES, MAX_MATERIALS, MAX_MTL_BYTES, MAX_TEXTURES,
    Material, Texture, TextureError, Warning, Warnings, check_regular, read_text,
};

/// The plain text of all the MTL files that `mtllib` lines of the OBJ file `obj` name.
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

/// What an `mtllib` line names: one file with spaces in its name if there is such a file, else one
/// file a word.
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
    /// How many materials there are so far.
    count: usize,
    /// Whether there is a material for the lines to come.
    open: bool,
}

impl Rewriter {
    /// Adds the text of a file whose path from the OBJ file's folder is `file`.
    fn file(&mut self, path: &Path, file: &str, text: &str, warnings: &mut Warnings) {
        let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
        self.open = false;
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
        } else if self.open && keyword.eq_ignore_ascii_case("Kd") {
            self.diffuse(rest)
        } else if self.open && keyword.eq_ignore_ascii_case("map_Kd") {
            self.texture(folder, rest)
        } else {
            Ok(())
        }
    }

    fn material(&mut self, name: &str) -> Result<(), LineError> {
        self.open = false;
        if name.is_empty() {
            return Err(LineError::NoName { keyword: "newmtl" });
        }
        if self.count == MAX_MATERIALS {
            return Err(LineError::TooMany { what: "materials", limit: MAX_MATERIALS as u64 });
        }
        self.open = true;
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

/// A name from a file as a path below the folder, parted by `/`; empty if it names nothing.
///
/// Backslashes part folders, as on Windows where many files come from. Of a name that leads out of
/// the folder only the last part remains, since the file has often been copied beside the model.
///
/// The path neither begins nor ends with blanks. `tobj` would cut them off, and what was left might
/// be nothing, or lead out of the folder: as ` /etc` or ` ../wood.png` would.
fn inside(name: &str) -> String {
    let name = unquoted(name).replace('\\', "/");
    let mut outside = is_rooted(&name);
    let mut parts = Vec::new();
    for part in name.split('/') {
        match part.trim() {
            "" | "." => {}
            ".." => outside |= parts.pop().is_none(),
            _ => parts.push(part),
        }
    }
    // `./C:/wood.png` is on a drive as well.
    outside |= parts.first().is_some_and(|first| is_rooted(first.trim()));
    if outside {
        // `C:wood.png` is in the current folder of a drive.
        let last = parts.pop().and_then(|part| part.rsplit(':').next());
        parts = last.into_iter().filter(|last| !matches!(last.trim(), "." | "..")).collect();
    }
    parts.join("/").trim().to_owned()
}

/// A name without the quotes and blanks around it.
fn unquoted(name: &str) -> &str {
    name.trim_matches(|c: char| c == '"' || c.is_whitespace())
}

/// Whether a name, without quotes, begins at a root or on a drive.
fn is_rooted(name: &str) -> bool {
    name.starts_with(['/', '\\']) || name.as_bytes().get(1) == Some(&b':')
}

/// The path of a file named from the folder of the OBJ file.
fn beside(obj: &Path, file: &str) -> PathBuf {
    obj.with_file_name("").join(file)
}

/// The default material and those that `tobj` found, with the textures that can be opened.
pub(super) fn open(
    obj: &Path,
    named: Vec<tobj::Material>,
    warnings: &mut Warnings,
) -> (Vec<Material>, Vec<Texture>) {
    let mut shelf = Shelf::default();
    let mut materials = vec![Material::default()];
    for tobj::Material { name, diffuse, diffuse_texture, .. } in named {
        let texture = diffuse_texture.and_then(|file| shelf.get(obj, &file, &name, warnings));
        let diffuse = match (diffuse, texture) {
            (Some(diffuse), _) => Vec3::from_array(diffuse),
            (None, Some(_)) => Vec3::ONE,
            (None, None) => Material::default().diffuse,
        };
        materials.push(Material { name, diffuse, texture });
    }
    (materials, shelf.textures)
}

/// Textures, each file once.
#[derive(Default)]
struct Shelf {
    textures: Vec<Texture>,
    texels: u64,
    /// The place of each file in `textures`; `None` for those that cannot be opened.
    places: HashMap<String, Option<usize>>,
}

impl Shelf {
    fn get(
        &mut self,
        obj: &Path,
        file: &str,
        material: &str,
        warnings: &mut Warnings,
    ) -> Option<usize> {
        if let Some(place) = self.places.get(file) {
            return *place;
        }
        let material = material.to_owned();
        if self.places.len() == MAX_TEXTURES {
            warnings.add(Warning::TooManyTextures { material });
            return None;
        }
        let place = match self.open(&beside(obj, file)) {
            Ok(place) => Some(place),
            Err(source) => {
                warnings.add(Warning::Texture { material, source });
                None
            }
        };
        self.places.insert(file.to_owned(), place);
        place
    }

    fn open(&mut self, path: &Path) -> Result<usize, TextureError> {
        check_regular(path)
            .map_err(|source| TextureError::Read { path: path.to_owned(), source })?;
        let texture = Texture::open_within(path, MAX_FILE_TEXELS - self.texels)?;
        self.texels += texture.texels().len() as u64;
        self.textures.push(texture);
        Ok(self.textures.len() - 1)
    }
}
