//! Reading files of a limited size, and bytes of any encoding as text.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// The text of a regular file of at most `limit` bytes, by [`decode`].
pub(super) fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    check_regular(path)?;
    let file = File::open(path)?;
    // Room for all at once; what is longer than the system says grows.
    let length = file.metadata()?.len().min(limit);
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(length).unwrap_or(0).saturating_add(1))?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it has more than the {limit} bytes that are allowed"),
        ));
    }
    Ok(decode(bytes))
}

/// Refuses devices and pipes, which might never end, before they are opened.
pub(super) fn check_regular(path: &Path) -> io::Result<()> {
    if fs::metadata(path)?.is_file() {
        Ok(())
    } else {
        Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"))
    }
}

/// The characters that stand for bytes which are not UTF-8 begin here: byte 0x80 is U+F780, 0xFF is
/// U+F7FF, in an area that Unicode leaves to private use.
const STRAY: u32 = 0xf700;

/// Text from bytes, with `\n` at the end of lines.
///
/// UTF-16 is recognised by its byte order mark, or by the zero that is half of its first character.
/// In other text each byte that is not UTF-8 becomes a character of its own, so that names in an old
/// 8-bit encoding stay apart, are the same in all files, and lead back to their bytes by
/// [`stray_byte`].
pub(super) fn decode(mut bytes: Vec<u8>) -> String {
    let utf16 = match bytes[..] {
        [0xff, 0xfe, ..] => Some(u16::from_le_bytes as fn([u8; 2]) -> u16),
        [0xfe, 0xff, ..] => Some(u16::from_be_bytes as fn([u8; 2]) -> u16),
        [a, 0, b, 0, ..] if a.min(b) > 0 => Some(u16::from_le_bytes as fn([u8; 2]) -> u16),
        [0, a, 0, b, ..] if a.min(b) > 0 => Some(u16::from_be_bytes as fn([u8; 2]) -> u16),
        _ => None,
    };
    if let Some(unit) = utf16 {
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let text = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        bytes = text.collect::<String>().into_bytes();
    }
    end_lines(&mut bytes);
    String::from_utf8(bytes).unwrap_or_else(|error| {
        let bytes = error.as_bytes();
        let mut text = String::with_capacity(bytes.len());
        for chunk in bytes.utf8_chunks() {
            text.push_str(chunk.valid());
            text.extend(chunk.invalid().iter().filter_map(|&byte| stray(byte)));
        }
        text
    })
}

/// Brings the ends of lines, `\r\n` and the `\r` of old Macintoshes among them, to `\n`.
fn end_lines(bytes: &mut Vec<u8>) {
    let Some(first) = bytes.iter().position(|&byte| byte == b'\r') else { return };
    let mut end = first;
    for i in first..bytes.len() {
        let byte = bytes[i];
        if byte == b'\r' && bytes.get(i + 1) == Some(&b'\n') {
            continue;
        }
        bytes[end] = if byte == b'\r' { b'\n' } else { byte };
        end += 1;
    }
    bytes.truncate(end);
}

fn stray(byte: u8) -> Option<char> {
    char::from_u32(STRAY + u32::from(byte))
}

/// The byte that a character of decoded text stands for, unless it is itself.
pub(super) fn stray_byte(c: char) -> Option<u8> {
    let byte = u8::try_from(u32::from(c).checked_sub(STRAY)?).ok()?;
    (byte >= 0x80).then_some(byte)
}

/// A name as a message can show it.
pub(super) fn shown(name: &str) -> String {
    if name.chars().any(|c| stray_byte(c).is_some()) {
        let plain = name.chars().map(|c| match stray_byte(c) {
            Some(_) => char::REPLACEMENT_CHARACTER,
            None => c,
        });
        let plain: String = plain.collect();
        return format!("{plain} (a name in an encoding that is not known; save it as UTF-8)");
    }
    name.to_owned()
}
