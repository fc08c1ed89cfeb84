//! The lines, words and numbers that OBJ and MTL files have in common.

use std::borrow::Cow;

use crate::obj::error::LineError;

/// The lines that are neither empty nor comments, trimmed, each with its number from 1. Those that
/// begin with `#MRGB` are kept: ZBrush writes colours so.
///
/// A line of numbers that ends in a backslash is joined with the next one. A comment or a line of names
/// is not: some of them end in the name of a folder.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.split('\n').map(str::trim).zip(1..);
    let joined = std::iter::from_fn(move || {
        let (mut part, line) = lines.next()?;
        if !part.ends_with('\\') || !is_continued(part) {
            return Some((line, Cow::Borrowed(part)));
        }
        let mut joined = String::new();
        while let Some(head) = part.strip_suffix('\\') {
            joined.extend([head, " "]);
            part = lines.next().map_or("", |(next, _)| next);
        }
        joined.push_str(part);
        Some((line, Cow::Owned(joined)))
    });
    joined.filter(|(_, statement)| {
        !statement.is_empty() && (!statement.starts_with('#') || statement.starts_with("#MRGB"))
    })
}

/// Whether a backslash at the end of a line means that the next one belongs to it.
fn is_continued(line: &str) -> bool {
    let (word, _) = split_word(line);
    let is_name = ["o", "g", "s", "usemtl", "mtllib", "usemap", "maplib", "newmtl"].contains(&word);
    !(line.starts_with('#') || is_name || is_map(word))
}

/// Whether the word begins a line of an MTL file that names a picture.
pub(super) fn is_map(word: &str) -> bool {
    const OTHERS: [&str; 5] = ["bump", "disp", "decal", "refl", "norm"];
    word.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("map_"))
        || OTHERS.iter().any(|other| word.eq_ignore_ascii_case(other))
}

/// The first word, and what follows it.
pub(super) fn split_word(text: &str) -> (&str, &str) {
    let text = text.trim_ascii();
    let end = text.bytes().position(|byte| byte.is_ascii_whitespace()).unwrap_or(text.len());
    let (word, rest) = text.split_at(end);
    (word, rest.trim_ascii_start())
}

/// The words of a line of numbers, up to a comment.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split_ascii_whitespace().take_while(|word| !word.starts_with('#'))
}

/// A name without the comment behind it, which begins with a blank and `#`; `None` if there is none.
pub(super) fn without_comment(name: &str) -> Option<&str> {
    let start = name.find(" #").or_else(|| name.find("\t#"))?;
    Some(name[..start].trim()).filter(|name| !name.is_empty())
}

/// The number that a word stands for, which fits `f32`.
pub(super) fn finite(what: &'static str, word: &str) -> Result<f64, LineError> {
    match word.parse::<f64>() {
        Ok(number) if (number as f32).is_finite() => Ok(number),
        Ok(_) => Err(LineError::NotFinite { what, word: excerpt(word) }),
        Err(_) => Err(LineError::NotANumber { what, word: excerpt(word) }),
    }
}

/// A word as a message can show it: at most 40 characters, none that would upset a terminal.
pub(super) fn excerpt(word: &str) -> String {
    let mut start: String = word.chars().filter(|c| !c.is_control()).take(40).collect();
    if start.len() < word.len() {
        start.push_str("...");
    }
    start
}
