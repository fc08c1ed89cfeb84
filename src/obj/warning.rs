//! What a model may be loaded without, and the list of what was missing.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use crate::obj::error::LineError;
use crate::obj::file::shown;
use crate::obj::limits::{MAX_TEXTURES, MAX_WARNINGS};
use crate::obj::notes::{Note, Notes};
use crate::texture::TextureError;

/// What a model's files lack, or have in vain. The model is there without it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// An MTL file cannot be read, or the MTL files are over [`MAX_MTL_BYTES`](crate::obj::MAX_MTL_BYTES).
    #[error("cannot read the material file {}: {source}; {}", path.display(), instead_of(instead.as_deref()))]
    MaterialFile {
        /// The MTL file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
        /// The MTL file that is read instead: the one that has the OBJ file's own name.
        instead: Option<PathBuf>,
    },
    /// A line of an MTL file is wrong and was skipped.
    #[error("{}:{line}: {cause}; the line is skipped", path.display())]
    MaterialLine {
        /// The MTL file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        #[source]
        cause: LineError,
    },
    /// Lines of the OBJ file are wrong in a way that only the looks suffer from. There is one warning
    /// for each kind of fault.
    #[error("{}:{line}: {cause}; {remedy}{}", path.display(), in_all(*count))]
    Line {
        /// The OBJ file.
        path: PathBuf,
        /// The first line with the fault, counted from 1.
        line: usize,
        /// What is wrong with it.
        #[source]
        cause: LineError,
        /// What the model has instead.
        remedy: &'static str,
        /// How often the file has faults of the kind.
        count: u64,
    },
    /// A file has things that are not drawn. There is one warning for each kind of them.
    #[error("{}:{line}: {what} are not used{}", path.display(), in_all(*count))]
    Unused {
        /// The OBJ or MTL file.
        path: PathBuf,
        /// The first line with one, counted from 1.
        line: usize,
        /// What they are, in the plural.
        what: String,
        /// How many there are.
        count: u64,
    },
    /// Faces name a material that no MTL file defines, and got the default one.
    #[error("{}:{line}: no material file defines `{}`; its faces get the default", path.display(), shown(name))]
    UnknownMaterial {
        /// The OBJ file.
        path: PathBuf,
        /// The first line that names it, counted from 1.
        line: usize,
        /// The name.
        name: String,
    },
    /// The colour 0 0 0 would hide the picture that it multiplies, and is taken for white: some programs
    /// write it where they mean the picture alone.
    #[error(
        "the material `{}` has Kd 0 0 0, which would hide its map_Kd; the picture is shown as it is",
        shown(material)
    )]
    BlackTexture {
        /// The material.
        material: String,
    },
    /// A material is altogether transparent.
    #[error(
        "the material `{}` is altogether transparent (d 0), so that its faces are not seen",
        shown(material)
    )]
    Invisible {
        /// The material.
        material: String,
    },
    /// A transparency of 1 without a `d` would hide all faces, and is taken for none: MeshLab writes it where
    /// it means opaque.
    #[error(
        "the material `{}` has Tr 1, which would hide its faces; they are opaque",
        shown(material)
    )]
    Opaque {
        /// The material.
        material: String,
    },
    /// A texture is missing, broken or too large, and the material keeps its plain colour.
    #[error("the material `{}` stays without its texture: {source}", shown(material))]
    Texture {
        /// The first material that names it.
        material: String,
        /// The file and the cause.
        source: TextureError,
    },
    /// More than [`MAX_TEXTURES`] texture files are named, and the material keeps its plain colour.
    #[error(
        "the material `{}` stays without its texture: at most {MAX_TEXTURES} are opened",
        shown(material)
    )]
    TooManyTextures {
        /// The material.
        material: String,
    },
    /// There are more than [`MAX_WARNINGS`] of them.
    #[error("{count} more warnings")]
    More {
        /// How many are not listed.
        count: usize,
    },
}

fn instead_of(path: Option<&Path>) -> String {
    path.map_or_else(
        || "its materials become the default".to_owned(),
        |path| format!("{} is read instead", path.display()),
    )
}

fn in_all(count: u64) -> impl Display {
    if count > 1 { format!(" ({count} in the file)") } else { String::new() }
}

/// Collects warnings, up to a number that a person might read.
#[derive(Default)]
pub(super) struct Warnings {
    list: Vec<Warning>,
    unlisted: usize,
}

impl Warnings {
    pub(super) fn add(&mut self, warning: Warning) {
        if self.list.len() < MAX_WARNINGS {
            self.list.push(warning);
        } else {
            self.unlisted += 1;
        }
    }

    /// Adds a warning for each kind of thing that is left out of a file.
    pub(super) fn add_notes(&mut self, path: &Path, notes: Notes) {
        for (note, line, count) in notes.into_list() {
            self.add(warning_of(path.to_owned(), note, line, count));
        }
    }

    pub(super) fn into_list(mut self) -> Vec<Warning> {
        if self.unlisted > 0 {
            self.list.push(Warning::More { count: self.unlisted });
        }
        self.list
    }
}

fn warning_of(path: PathBuf, note: Note, line: usize, count: u64) -> Warning {
    let (cause, remedy) = match note {
        Note::Unused(what) => return Warning::Unused { path, line, what: what.into(), count },
        Note::Unknown(word) => {
            let what = format!("statements that no OBJ file has, such as `{word}`,");
            return Warning::Unused { path, line, what, count };
        }
        Note::Position(cause) => (cause, "no face uses the position"),
        Note::Uv(cause) => (cause, "it counts as missing"),
        Note::Normal(cause) => (cause, "it is computed instead"),
        Note::Color(cause) => (cause, "the position is white"),
        Note::ShortFace(found) => {
            (LineError::TooFewCorners { found }, "it covers nothing and is skipped")
        }
        Note::Reference(what) => (LineError::NoSuch { what }, "the corner goes without"),
    };
    Warning::Line { path, line, cause, remedy, count }
}
