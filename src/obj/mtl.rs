//! MTL text to what it says of each material.
//!
//! A wrong line costs that line, with a warning; what is not read is warned of once for each kind.

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::obj::error::LineError;
use crate::obj::file::read_text;
use crate::obj::limits::{MAX_LIBRARIES, MAX_MATERIALS, MAX_MTL_BYTES};
use crate::obj::lines::{finite, is_map, split_word, statements, without_comment, words};
use crate::obj::map_options::readings;
use crate::obj::notes::{Note, Notes};
use crate::obj::paths::{Finder, is_name};
use crate::obj::warning::{Warning, Warnings};

/// What an MTL file says of a material.
#[derive(Default)]
pub(super) struct Entry {
    pub(super) name: String,
    /// `Kd`.
    pub(super) diffuse: Option<Vec3>,
    /// `d`.
    pub(super) dissolve: Option<f32>,
    /// `Tr`.
    pub(super) transparency: Option<f32>,
    /// `Ke`.
    pub(super) emission: Option<Vec3>,
    /// `Ks`.
    pub(super) specular: Option<Vec3>,
    /// `Ns`.
    pub(super) shininess: Option<f32>,
    /// What follows the keywords of [`MAPS`]: options and a name.
    pub(super) maps: [Option<String>; MAPS.len()],
    /// The folder of the file, from that of the OBJ file.
    pub(super) folder: String,
}

/// The maps that are read, in the order of [`Entry::maps`].
pub(super) const MAPS: [&str; 8] =
    ["map_Kd", "map_Ka", "map_d", "map_Ke", "map_Ks", "map_Bump", "norm", "disp"];

/// Other words for some of them.
const SYNONYMS: [(&str, &str); 3] =
    [("bump", "map_Bump"), ("map_Kn", "norm"), ("map_disp", "disp")];

/// Reads all MTL files that the OBJ file `obj` names in `mtllib` lines, or the one of its own name.
pub(super) fn read(
    obj: &Path,
    libraries: &[(usize, String)],
    finder: &mut Finder,
    warnings: &mut Warnings,
) -> Vec<Entry> {
    let mut reader = Reader::default();
    let mut seen = HashSet::new();
    let mut missing = Vec::new();
    for (_, line) in libraries {
        let found = files_of(line, finder);
        missing.extend(found.1);
        for (path, folder) in found.0 {
            if seen.len() < MAX_LIBRARIES && seen.insert(path.clone()) {
                reader.file(&path, folder, warnings);
            }
        }
    }
    // Beside a model that was renamed lies a material file that was renamed with it.
    let own = obj.with_extension("mtl").file_name().and_then(|name| name.to_str().map(own_name));
    let mut instead = None;
    if seen.is_empty()
        && let Some(Ok(path)) = own.and_then(|name| finder.find("", &name))
    {
        reader.file(&path, String::new(), warnings);
        instead = Some(path);
    }
    for path in missing {
        let source = io::ErrorKind::NotFound;
        let source = match std::fs::metadata(&path) {
            Err(source) => source,
            Ok(_) => io::Error::new(source, "it is not a regular file"),
        };
        warnings.add(Warning::MaterialFile { path, source, instead: instead.clone() });
    }
    reader.entries
}

/// The name of a file that is to be taken as it stands.
fn own_name(name: &str) -> String {
    name.replace('%', "%25")
}

/// The files of an `mtllib` line with their folders, and one path that was looked for in vain: one file
/// with spaces in its name if there is such a file, else one for each word.
fn files_of(line: &str, finder: &mut Finder) -> (Vec<(PathBuf, String)>, Option<PathBuf>) {
    let folder_of = |name: &str| {
        let name = name.replace('\\', "/");
        name.rsplit_once('/').map_or(String::new(), |(folder, _)| folder.to_owned())
    };
    let missing = match finder.find("", line) {
        Some(Ok(path)) => return (vec![(path, folder_of(line))], None),
        Some(Err(missing)) => Some(missing),
        None => None,
    };
    let plain = without_comment(line).unwrap_or(line);
    let mut first_missing = None;
    let mut files = Vec::new();
    // Several names may have blanks, if each ends as such names do.
    let mut names = by_ending(plain);
    if !names.iter().all(|name| matches!(finder.find("", name), Some(Ok(_)))) {
        names = plain.split_ascii_whitespace().collect();
    }
    let count = names.len();
    for name in names {
        match finder.find("", name) {
            Some(Ok(path)) => files.push((path, folder_of(name))),
            Some(Err(path)) => first_missing = first_missing.or(Some(path)),
            None => {}
        }
    }
    // Of a name with spaces the whole is missing, not each word.
    let missing = if files.is_empty() && count > 1 { missing } else { first_missing };
    (files, missing)
}

/// The names in a line, each of which ends in `.mtl`.
fn by_ending(line: &str) -> Vec<&str> {
    let lower = line.to_ascii_lowercase();
    let mut names = Vec::new();
    let mut start = 0;
    for (end, _) in lower.match_indices(".mtl ") {
        names.push(line[start..end + 4].trim());
        start = end + 4;
    }
    names.push(line[start..].trim());
    names
}

#[derive(Default)]
struct Reader {
    entries: Vec<Entry>,
    /// How many bytes of all files were read.
    bytes: u64,
    /// Whether the lines to come belong to a material.
    in_material: bool,
    notes: Notes,
}

impl Reader {
    /// Adds the materials of a file.
    fn file(&mut self, path: &Path, folder: String, warnings: &mut Warnings) {
        let text = match read_text(path, MAX_MTL_BYTES.saturating_sub(self.bytes)) {
            Ok(text) => text,
            Err(source) => {
                let path = path.to_owned();
                return warnings.add(Warning::MaterialFile { path, source, instead: None });
            }
        };
        self.bytes = self.bytes.saturating_add(text.len() as u64);
        self.in_material = false;
        for (line, statement) in statements(&text) {
            let (keyword, rest) = split_word(&statement);
            if let Err(cause) = self.statement(&folder, line, keyword, rest) {
                warnings.add(Warning::MaterialLine { path: path.to_owned(), line, cause });
            }
        }
        warnings.add_notes(path, std::mem::take(&mut self.notes));
    }

    fn statement(
        &mut self,
        folder: &str,
        line: usize,
        keyword: &str,
        rest: &str,
    ) -> Result<(), LineError> {
        if keyword.eq_ignore_ascii_case("newmtl") {
            return self.material(folder, rest);
        }
        let Some(entry) = self.entries.last_mut().filter(|_| self.in_material) else {
            return Ok(());
        };
        let synonym = SYNONYMS.iter().find(|(word, _)| keyword.eq_ignore_ascii_case(word));
        let keyword = synonym.map_or(keyword, |(_, word)| *word);
        let is = |word: &str| keyword.eq_ignore_ascii_case(word);
        if is("Kd") {
            entry.diffuse = Some(colour(rest)?);
        } else if is("Ke") {
            entry.emission = Some(colour(rest)?);
        } else if is("Ks") {
            entry.specular = Some(colour(rest)?);
        } else if is("Ns") {
            let number = words(rest).next().map(|word| finite("exponent", word)).transpose()?;
            entry.shininess = number.map(|number| (number as f32).max(0.0));
        } else if is("d") {
            entry.dissolve = fraction(rest)?;
        } else if is("Tr") {
            entry.transparency = fraction(rest)?;
        } else if let Some(map) = MAPS.iter().position(|map| is(map)) {
            if !readings(rest).iter().any(|(name, _)| is_name(name)) {
                return Err(LineError::NoName { keyword: MAPS[map] });
            }
            entry.maps[map] = Some(rest.to_owned());
        } else if let Some(what) = unused(keyword) {
            self.notes.add(Note::Unused(what), line);
        }
        Ok(())
    }

    fn material(&mut self, folder: &str, name: &str) -> Result<(), LineError> {
        self.in_material = false;
        if name.is_empty() {
            return Err(LineError::NoName { keyword: "newmtl" });
        }
        if self.entries.len() == MAX_MATERIALS {
            return Err(LineError::TooMany { what: "materials", limit: MAX_MATERIALS as u64 });
        }
        self.in_material = true;
        let (name, folder) = (name.to_owned(), folder.to_owned());
        self.entries.push(Entry { name, folder, ..Entry::default() });
        Ok(())
    }
}

/// What a statement is about that is not read, if it can make a difference to the picture.
///
/// The numbers of the lighting model, such as `Ka` and `illum`, are in every file, and count for nothing, which
/// the module's documentation says.
fn unused(keyword: &str) -> Option<&'static str> {
    let is = |word: &str| keyword.eq_ignore_ascii_case(word);
    Some(match keyword {
        _ if is("map_Ns") => "pictures of exponents of highlights (map_Ns)",
        _ if is("decal") || is("map_decal") => "pictures of decals (decal)",
        _ if is("refl") || is("map_refl") => "pictures of reflections (refl)",
        _ if is("map_Tr") || is("map_aat") => "statements map_Tr and map_aat",
        _ if is_map(keyword) => "pictures of other properties (map_Pr, map_Pm and others)",
        _ => return None,
    })
}

fn colour(rest: &str) -> Result<Vec3, LineError> {
    let what = "colour";
    let mut numbers = [0.0; 3];
    let mut found = 0;
    for word in words(rest).take(3) {
        numbers[found] = finite(what, word)? as f32;
        found += 1;
    }
    match found {
        3 => Ok(Vec3::from_array(numbers)),
        // The format says that one number stands for all three.
        1 => Ok(Vec3::splat(numbers[0])),
        _ => Err(LineError::TooFewNumbers { what, needed: 3, found }),
    }
}

/// A number from 0 to 1, perhaps after `-halo`; `None` if there is none.
fn fraction(rest: &str) -> Result<Option<f32>, LineError> {
    let word = words(rest).find(|word| !word.eq_ignore_ascii_case("-halo"));
    let number = word.map(|word| finite("transparency", word)).transpose()?;
    Ok(number.map(|number| (number as f32).clamp(0.0, 1.0)))
}
