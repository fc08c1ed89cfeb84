//! What can be wrong with an OBJ file, or with a line of one or of an MTL file.

use std::io;
use std::path::PathBuf;

use crate::model::also::Also;

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjError {
    /// The file cannot be read, or is over [`MAX_OBJ_BYTES`](crate::obj::MAX_OBJ_BYTES).
    #[error("cannot read the model {}: {source}; check its name, permissions and size", path.display())]
    Read {
        /// The OBJ file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A line is wrong.
    #[error("{}:{line}: {cause}", path.display())]
    Line {
        /// The OBJ file.
        path: PathBuf,
        /// The line, counted from 1; where it is continued, the first.
        line: usize,
        /// What is wrong with it.
        #[source]
        cause: LineError,
    },
    /// No line is a face.
    #[error(
        "{} has no faces (lines that begin with `f`): is it an OBJ file of polygons?{}",
        path.display(),
        Also(warnings)
    )]
    NoFaces {
        /// The OBJ file.
        path: PathBuf,
        /// What else is wrong with it, or not used: sentences that name file and line.
        warnings: Vec<String>,
    },
}

/// What is wrong with a line of an OBJ or MTL file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// A word stands where a number should.
    #[error("`{word}` in a {what} is not a number: write it like 0.5 or 1e-3")]
    NotANumber {
        /// What the number belongs to.
        what: &'static str,
        /// The word, shortened if long.
        word: String,
    },
    /// A number is NaN, infinite, or too large for `f32`.
    #[error("`{word}` in a {what} is not finite: use numbers up to 3.4e38")]
    NotFinite {
        /// What the number belongs to.
        what: &'static str,
        /// The number as written.
        word: String,
    },
    /// The line ends too early.
    #[error("a {what} needs {needed} numbers, and here are {found}")]
    TooFewNumbers {
        /// What the numbers belong to.
        what: &'static str,
        /// How many it needs.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// A face has fewer than three corners.
    #[error(
        "a face needs at least 3 corners, and here are {found}: use `l` for lines, `p` for points"
    )]
    TooFewCorners {
        /// How many there are.
        found: usize,
    },
    /// A corner cannot be read.
    #[error("`{word}` is no face corner: write v, v/vt, v//vn or v/vt/vn with whole numbers")]
    Corner {
        /// The corner, shortened if long.
        word: String,
    },
    /// An index is 0.
    #[error(
        "`{word}` has the index 0: the first {what} is 1, and the one just above the line is -1"
    )]
    ZeroIndex {
        /// What the index refers to.
        what: &'static str,
        /// The corner.
        word: String,
    },
    /// An index refers to nothing.
    #[error("a face refers to {what} {index}, but there are only {count} {}", range_of(*index))]
    IndexOutOfRange {
        /// What the index refers to.
        what: &'static str,
        /// The index as written: from 1 on, or back from -1.
        index: i64,
        /// How many there are: in the file, or above the line for a negative index.
        count: u64,
    },
    /// A corner's texture coordinate or normal is not there.
    #[error("a face refers to a {what} that is not in the file")]
    NoSuch {
        /// What the index refers to.
        what: &'static str,
    },
    /// A name is missing.
    #[error("`{keyword}` needs a name after it")]
    NoName {
        /// The first word of the line.
        keyword: &'static str,
    },
    /// The file goes over a limit.
    #[error("more than {limit} {what}: split the model")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many are allowed.
        limit: u64,
    },
}

fn range_of(index: i64) -> &'static str {
    if index < 0 { "above the line" } else { "in the file" }
}
