//! Where the files lie that OBJ and MTL files name: in the OBJ file's folder or below, or below another
//! folder that the user allows.
//!
//! Names come from other machines. So a name is tried as it stands, without a comment behind it, with its
//! escapes undone, in its bytes; then in another case, in other characters where it has some that are not
//! ASCII; and then its last part alone, beside the file that names it and beside the OBJ file.

use std::collections::HashMap;
use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};

use crate::obj::file::stray_byte;
use crate::obj::lines::without_comment;

/// The most entries of a folder that are looked through.
const MAX_ENTRIES: usize = 16_384;

/// Finds files for names.
pub(super) struct Finder {
    /// The OBJ file's folder.
    folder: PathBuf,
    /// The parts that lead from the root that may be read to the folder: how far `..` may go up.
    depth: Vec<OsString>,
    /// Whether a root is set, which has `depth` below it.
    root: Option<PathBuf>,
    /// What is in the folders that were looked through.
    entries: HashMap<PathBuf, Vec<OsString>>,
}

impl Finder {
    /// A finder for the OBJ file `obj`, that stays below `root`, or below the file's folder if that is not
    /// below `root`.
    pub(super) fn new(obj: &Path, root: Option<&Path>) -> Self {
        let folder = obj.with_file_name("");
        let mut finder = Self { folder, depth: Vec::new(), root: None, entries: HashMap::new() };
        let place =
            if finder.folder.as_os_str().is_empty() { Path::new(".") } else { &finder.folder };
        if let Some(root) = root.and_then(|root| root.canonicalize().ok())
            && let Ok(place) = place.canonicalize()
            && let Ok(below) = place.strip_prefix(&root)
        {
            let parts = below.components().map(|part| part.as_os_str().to_owned());
            finder.depth = parts.collect();
            finder.root = Some(root);
        }
        finder
    }

    /// The regular file that a name stands for, or the path of the first place where it was looked for.
    /// `None` if it is no name at all.
    ///
    /// `beside` is the folder of the file that has the name, relative to that of the OBJ file.
    pub(super) fn find(&mut self, beside: &str, name: &str) -> Option<Result<PathBuf, PathBuf>> {
        let names = variants(name);
        let whole: Vec<Vec<String>> =
            names.iter().map(|name| self.parts(beside, name)).filter(|p| !p.is_empty()).collect();
        let first = whole.first()?;
        let missing = self.path_of(first);
        let last = |folder: &str, parts: &Vec<String>| {
            let folder = folder.split('/').filter(|part| !part.is_empty()).map(str::to_owned);
            folder.chain(parts.last().cloned()).collect::<Vec<_>>()
        };
        let mut places = whole.clone();
        places.extend(whole.iter().map(|parts| last(beside, parts)));
        places.extend(whole.iter().map(|parts| last("", parts)));

        let exact = places[..whole.len()].iter().map(|parts| self.path_of(parts));
        if let Some(path) = exact.into_iter().find(|path| path.is_file()) {
            return Some(Ok(path));
        }
        let bytes = in_bytes(name).map(|file| self.folder.join(beside).join(file));
        if let Some(path) = bytes.filter(|path| path.is_file()) {
            return Some(Ok(path));
        }
        for parts in places {
            if let Some(path) = self.look_for(&parts) {
                return Some(Ok(path));
            }
        }
        Some(Err(missing))
    }

    /// The parts of a name as a path from the OBJ file's folder. If it leads out of what may be read only
    /// its last part remains, since the file has often been copied beside the model.
    fn parts(&self, beside: &str, name: &str) -> Vec<String> {
        let name = unquoted(name).replace('\\', "/");
        let mut outside = is_rooted(&name);
        let mut parts: Vec<String> = Vec::new();
        // How many of the leading parts are `..`.
        let mut ups = 0;
        let from_folder = if outside { "" } else { beside };
        for part in from_folder.split('/').chain(name.split('/')) {
            match part.trim() {
                "" | "." => {}
                ".." if parts.len() > ups => drop(parts.pop()),
                ".." if ups < self.depth.len() => {
                    parts.push("..".to_owned());
                    ups += 1;
                }
                ".." => outside = true,
                part => parts.push(part.to_owned()),
            }
        }
        // `./C:/wood.png` is on a drive as well.
        outside |= parts.iter().any(|part| is_rooted(part));
        if outside {
            // `C:wood.png` is in the current folder of a drive.
            let last = parts.last().and_then(|part| part.rsplit(':').next()).map(str::trim);
            parts = last.into_iter().map(str::to_owned).collect();
        }
        if matches!(parts.last().map(|last| last.trim()), None | Some("" | "." | "..")) {
            parts.clear();
        }
        parts
    }

    /// The path of parts from the OBJ file's folder.
    fn path_of(&self, parts: &[String]) -> PathBuf {
        let ups = parts.iter().take_while(|part| *part == "..").count();
        let mut path = self.folder.clone();
        if let Some(root) = self.root.as_ref().filter(|_| ups > 0) {
            path.clone_from(root);
            path.extend(&self.depth[..self.depth.len().saturating_sub(ups)]);
        }
        path.extend(parts[ups..].iter().map(|part| system_name(part)));
        path
    }

    /// The file at these parts from the OBJ file's folder, in whatever case they are written.
    fn look_for(&mut self, parts: &[String]) -> Option<PathBuf> {
        let ups = parts.iter().take_while(|part| *part == "..").count();
        let mut path = self.path_of(&parts[..ups]);
        for part in &parts[ups..] {
            let next = path.join(system_name(part));
            path = if next.exists() { next } else { path.join(self.entry_like(&path, part)?) };
        }
        path.is_file().then_some(path)
    }

    /// The entry of a folder that is called so but for the case of letters or for the characters that are
    /// not ASCII. There must be one only.
    fn entry_like(&mut self, folder: &Path, part: &str) -> Option<OsString> {
        let entries = self.entries.entry(folder.to_owned()).or_insert_with(|| {
            let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let entries = std::fs::read_dir(place).into_iter().flatten().take(MAX_ENTRIES);
            let mut names: Vec<_> = entries.flatten().map(|entry| entry.file_name()).collect();
            names.sort();
            names
        });
        let lower = part.to_lowercase();
        let by_case = entries.iter().find(|entry| entry.to_string_lossy().to_lowercase() == lower);
        if let Some(entry) = by_case {
            return Some(entry.clone());
        }
        if part.is_ascii() {
            return None;
        }
        let outline = outline(part);
        let mut alike =
            entries.iter().filter(|entry| self::outline(&entry.to_string_lossy()) == outline);
        let entry = alike.next()?;
        alike.next().is_none().then(|| entry.clone())
    }
}

/// Whether a name can be that of a file: not `..`, not `C:`, not blanks in quotes.
pub(super) fn is_name(name: &str) -> bool {
    let last = unquoted(name).rsplit(['/', '\\', ':']).next();
    !matches!(last.map(str::trim), None | Some("" | "." | ".."))
}

/// The names that one may stand for, the likeliest first.
fn variants(name: &str) -> Vec<String> {
    let mut names = vec![name.to_owned()];
    let mut add = |name: String| {
        if !names.contains(&name) {
            names.push(name);
        }
    };
    let plain = without_comment(name);
    plain.into_iter().for_each(|name| add(name.to_owned()));
    for name in [Some(name), plain].into_iter().flatten() {
        add(name.replace("\\ ", " "));
        add(unescaped(name));
        add(unescaped(&name.replace("\\ ", " ")));
    }
    names
}

/// The name with `%20` and its like undone.
fn unescaped(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).filter(|_| *first == b'%').and_then(|digits| {
            let digits = str::from_utf8(digits).ok()?;
            u8::from_str_radix(digits, 16).ok()
        });
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(bytes).unwrap_or_else(|_| name.to_owned())
}

/// What a name shows in every encoding that has ASCII in it: its ASCII characters, and one mark for each
/// run of others.
fn outline(name: &str) -> String {
    let mut outline = String::new();
    for c in name.chars() {
        if c.is_ascii() {
            outline.push(c.to_ascii_lowercase());
        } else if !outline.ends_with('\u{fffd}') {
            outline.push('\u{fffd}');
        }
    }
    outline
}

/// The bytes of a name that is no UTF-8, as one part of a path: in some encodings a character may end in
/// the byte of a backslash.
fn in_bytes(name: &str) -> Option<OsString> {
    let has_bytes = name.chars().any(|c| stray_byte(c).is_some());
    let file = system_name(unquoted(name));
    let is_one_part = matches!(
        Path::new(&file).components().collect::<Vec<_>>()[..],
        [Component::Normal(part)] if part == file
    );
    (has_bytes && is_one_part).then_some(file)
}

/// A part of a name as the system has it: with the bytes that are no UTF-8.
#[cfg(unix)]
fn system_name(part: &str) -> OsString {
    use std::os::unix::ffi::OsStringExt as _;

    let mut bytes = Vec::new();
    for c in part.chars() {
        match stray_byte(c) {
            Some(byte) => bytes.push(byte),
            None => bytes.extend(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
    OsString::from_vec(bytes)
}

/// A part of a name as the system has it.
#[cfg(not(unix))]
fn system_name(part: &str) -> OsString {
    part.into()
}

/// A name without the quotes and blanks around it.
fn unquoted(name: &str) -> &str {
    name.trim_matches(|c: char| c == '"' || c.is_whitespace())
}

/// Whether a name, without quotes, begins at a root or on a drive.
fn is_rooted(name: &str) -> bool {
    name.starts_with(['/', '\\']) || name.as_bytes().get(1) == Some(&b':')
}
