//! What a model may be loaded without, and the list of what was missing.

use std::io;
use std::path::PathBuf;

use crate::obj::error::LineError;
use crate::obj::limits::{MAX_TEXTURES, MAX_WARNINGS};
use crate::texture::TextureError;

/// What a model's files lack. The model is there without it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// An MTL file cannot be read, or the MTL files are over [`MAX_MTL_BYTES`](crate::obj::MAX_MTL_BYTES).
    #[error("cannot read the material file {}: {source}; its materials become the default", path.display())]
    MaterialFile {
        /// The MTL file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
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
    /// Faces name a material that no MTL file defines, and got the default one.
    #[error("{}:{line}: no material file defines `{name}`; its faces get the default", path.display())]
    UnknownMaterial {
        /// The OBJ file.
        path: PathBuf,
        /// The first line that names it, counted from 1.
        line: usize,
        /// The name.
        name: String,
    },
    /// A texture is missing, broken or too large, and the material keeps its plain colour.
    #[error("the material `{material}` stays without its texture: {source}")]
    Texture {
        /// The first material that names it.
        material: String,
        /// The file and the cause.
        source: TextureError,
    },
    /// More than [`MAX_TEXTURES`] texture files are named, and the material keeps its plain colour.
    #[error(
        "the material `{material}` stays without its texture: at most {MAX_TEXTURES} are opened"
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

    pub(super) fn into_list(mut self) -> Vec<Warning> {
        if self.unlisted > 0 {
            self.list.push(Warning::More { count: self.unlisted });
        }
        self.list
    }
}
