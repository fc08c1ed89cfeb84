//! Where the files lie that OBJ and MTL files name: always in the OBJ file's folder or below.

use std::path::{Path, PathBuf};

/// A name from a file as a path below the folder, with `/` between its parts; empty if it names
/// nothing.
///
/// A backslash counts as `/`, as on Windows where many files come from. Of a name that leads out of
/// the folder only the last part remains, since the file has often been copied beside the model.
///
/// The path neither begins nor ends with blanks. `tobj` would cut them off, and the rest might be
/// empty, or lead out of the folder, as ` /etc` or ` ../wood.png` would.
pub(super) fn inside(name: &str) -> String {
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
pub(super) fn unquoted(name: &str) -> &str {
    name.trim_matches(|c: char| c == '"' || c.is_whitespace())
}

/// Whether a name, without quotes, begins at a root or on a drive.
pub(super) fn is_rooted(name: &str) -> bool {
    name.starts_with(['/', '\\']) || name.as_bytes().get(1) == Some(&b':')
}

/// The path of a file named from the folder of the OBJ file.
pub(super) fn beside(obj: &Path, file: &str) -> PathBuf {
    obj.with_file_name("").join(file)
}
