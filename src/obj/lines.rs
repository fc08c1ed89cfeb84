//! The lines, words and numbers that OBJ and MTL files have in common.

use std::borrow::Cow;

use crate::obj::error::LineError;

/// The lines that are neither empty nor comments, trimmed, each with its number from 1.
///
/// A line that ends in a backslash is joined with the next one, unless it is a comment: some comments
/// end in the name of a folder.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().map(str::trim).zip(1..);
    let joined = std::iter::from_fn(move || {
        let (mut part, line) = lines.next()?;
        let mut joined = String::new();
        while let Some(head) = part.strip_suffix('\\')
            && !part.starts_with('#')
        {
            joined.extend([head, " "]);
            part = lines.next().map_or("", |(next, _)| next);
        }
        if joined.is_empty() {
            return Some((line, Cow::Borrowed(part)));
        }
        joined.push_str(part);
        Some((line, Cow::Owned(joined)))
    });
    joined.filter(|(_, statement)| !statement.is_empty() && !statement.starts_with('#'))
}

/// The first word, and what follows it.
pub(super) fn split_word(text: &str) -> (&str, &str) {
    let text = text.trim();
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

/// The words of a line of numbers, up to a comment.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split_whitespace().take_while(|word| !word.starts_with('#'))
}

/// The number that a word stands for.
pub(super) fn finite(what: &'static str, word: &str) -> Result<f32, LineError> {
    let number: f32 =
        word.parse().map_err(|_| LineError::NotANumber { what, word: excerpt(word) })?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(LineError::NotFinite { what, word: excerpt(word) })
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
