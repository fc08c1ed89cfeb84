//! What a file has that is left out, each kind once: with the first line that has it, and how often.

use crate::obj::error::LineError;

/// A thing that is left out.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Note {
    /// The reader has no use for it.
    Unused(&'static str),
    /// Nobody knows what it is: the first word of the line.
    Unknown(String),
    /// A position is wrong; perhaps no face uses it.
    Position(LineError),
    /// A texture coordinate is wrong.
    Uv(LineError),
    /// A normal is wrong.
    Normal(LineError),
    /// The colour of a position is wrong.
    Color(LineError),
    /// A face has so few corners.
    ShortFace(usize),
    /// A corner refers to what is not there.
    Reference(&'static str),
}

impl Note {
    /// Whether both are of one kind.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Unused(a), Self::Unused(b)) | (Self::Reference(a), Self::Reference(b)) => a == b,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
}

/// What is left out of a file.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// The first of each kind with its line, and how many there are.
    list: Vec<(Note, usize, u64)>,
}

impl Notes {
    pub(super) fn add(&mut self, note: Note, line: usize) {
        // There are no more kinds than this module and its users name.
        match self.list.iter_mut().find(|(other, _, _)| other.is_like(&note)) {
            Some((_, _, count)) => *count += 1,
            None => self.list.push((note, line, 1)),
        }
    }

    /// The kinds in the order of their first lines, each with that line and how many there are.
    pub(super) fn into_list(mut self) -> Vec<(Note, usize, u64)> {
        self.list.sort_by_key(|&(_, line, _)| line);
        self.list
    }
}
