//! The bytes of glTF buffers, and the numbers that accessors find in them. Every range is checked.

use std::path::{Component, Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Source, View};

use crate::formats::limits::MAX_CORNERS;

/// The most bytes of all buffers: 1 GiB.
const MAX_BYTES: u64 = 1 << 30;

/// All buffers of a document.
pub(super) struct Data {
    buffers: Vec<Vec<u8>>,
}

impl Data {
    /// Opens the buffers of a file at `path`, which lie in the file or beside it.
    pub(super) fn open(
        document: &gltf::Document,
        blob: Option<Vec<u8>>,
        path: &Path,
    ) -> Result<Self, String> {
        let mut blob = blob;
        let mut left = MAX_BYTES;
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let bytes = match buffer.source() {
                Source::Bin => blob.take().ok_or("it has a buffer without data")?,
                Source::Uri(uri) => resource(uri, path, left)?,
            };
            left = left.saturating_sub(bytes.len() as u64);
            buffers.push(bytes);
        }
        Ok(Self { buffers })
    }

    /// The bytes of a view.
    pub(super) fn view(&self, view: &View<'_>) -> Result<&[u8], String> {
        let bytes = self.buffers.get(view.buffer().index());
        let end = view.offset().checked_add(view.length());
        bytes
            .zip(end)
            .and_then(|(bytes, end)| bytes.get(view.offset()..end))
            .ok_or_else(|| "a buffer is shorter than the file says; was it cut off?".into())
    }

    /// The numbers of an accessor, one item after the other, and how many an item has. Integers that are
    /// normalised go from -1 or 0 to 1. An accessor of fewer than `least` numbers an item is refused.
    pub(super) fn numbers(
        &self,
        accessor: &Accessor<'_>,
        least: usize,
    ) -> Result<(Vec<f64>, usize), String> {
        let size = match accessor.dimensions() {
            Dimensions::Scalar => 1,
            Dimensions::Vec2 => 2,
            Dimensions::Vec3 => 3,
            Dimensions::Vec4 => 4,
            _ => return Err("an accessor has matrices where vectors should be".into()),
        };
        let count = accessor.count();
        if size < least {
            return Err(format!("an accessor has items of {size} numbers, not of {least}"));
        }
        if count as u64 > MAX_CORNERS {
            return Err(format!("an accessor has {count} items, which is too many"));
        }
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        let mut numbers = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(size * width(kind));
                let bytes = self.view(&view)?;
                items(bytes, accessor.offset(), stride, (count, size), (kind, normalized))?
            }
            // Zeros, for others to be put among them. Without a bound they would cost nothing to ask for.
            None if accessor.sparse().is_some() => vec![0.0; count * size],
            None => return Err("an accessor has no data".into()),
        };
        if let Some(sparse) = accessor.sparse() {
            let (of_index, of_value) = (sparse.indices(), sparse.values());
            let index_type = match of_index.index_type() {
                IndexType::U8 => DataType::U8,
                IndexType::U16 => DataType::U16,
                IndexType::U32 => DataType::U32,
            };
            let bytes = self.view(&of_index.view())?;
            let form = ((sparse.count(), 1), (index_type, false));
            let indices = items(bytes, of_index.offset(), width(index_type), form.0, form.1)?;
            let bytes = self.view(&of_value.view())?;
            let form = ((sparse.count(), size), (kind, normalized));
            let values = items(bytes, of_value.offset(), size * width(kind), form.0, form.1)?;
            for (index, value) in indices.into_iter().zip(values.chunks_exact(size)) {
                let start = index as usize * size;
                let place = numbers.get_mut(start..start + size);
                place.ok_or("a sparse accessor leads beyond its items")?.copy_from_slice(value);
            }
        }
        Ok((numbers, size))
    }
}

/// The bytes of a number.
fn width(kind: DataType) -> usize {
    match kind {
        DataType::I8 | DataType::U8 => 1,
        DataType::I16 | DataType::U16 => 2,
        DataType::U32 | DataType::F32 => 4,
    }
}

/// So many items of so many numbers each, from an offset on, at even distances.
fn items(
    bytes: &[u8],
    offset: usize,
    stride: usize,
    (count, size): (usize, usize),
    (kind, normalized): (DataType, bool),
) -> Result<Vec<f64>, String> {
    let width = width(kind);
    let item = size * width;
    let end = count
        .checked_sub(1)
        .and_then(|last| last.checked_mul(stride)?.checked_add(offset)?.checked_add(item));
    if count > 0 && end.is_none_or(|end| end > bytes.len()) || stride < item {
        return Err("an accessor leads beyond its buffer; was the file cut off?".into());
    }
    let mut numbers = Vec::with_capacity(count * size);
    for i in 0..count {
        let item = &bytes[offset + i * stride..][..item];
        numbers.extend(item.chunks_exact(width).map(|bytes| number(bytes, kind, normalized)));
    }
    Ok(numbers)
}

/// The number of some bytes (glTF 2.0, section 3.6.2.2 on normalised integers).
fn number(bytes: &[u8], kind: DataType, normalized: bool) -> f64 {
    let (number, most) = match *bytes {
        [a] if kind == DataType::I8 => (f64::from(a as i8), 127.0),
        [a] => (f64::from(a), 255.0),
        [a, b] if kind == DataType::I16 => (f64::from(i16::from_le_bytes([a, b])), 32_767.0),
        [a, b] => (f64::from(u16::from_le_bytes([a, b])), 65_535.0),
        [a, b, c, d] if kind == DataType::F32 => {
            return f64::from(f32::from_le_bytes([a, b, c, d]));
        }
        [a, b, c, d] => (f64::from(u32::from_le_bytes([a, b, c, d])), 4_294_967_295.0),
        _ => (0.0, 1.0),
    };
    if normalized { (number / most).max(-1.0) } else { number }
}

/// The bytes that a URI stands for: within it, or in a file below the folder of `path`.
pub(super) fn resource(uri: &str, path: &Path, most: u64) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, data) = data.split_once(";base64,").ok_or("it has data in no encoding known")?;
        return STANDARD.decode(data.trim()).map_err(|_| "it has data that is no base64".into());
    }
    let file = beside(uri, path).ok_or_else(|| {
        format!("it refers to `{}`, which is not in its folder or below", excerpt(uri))
    })?;
    let wrong = |error: &dyn std::fmt::Display| format!("cannot read {}: {error}", file.display());
    let metadata = std::fs::metadata(&file).map_err(|error| wrong(&error))?;
    if !metadata.is_file() {
        return Err(wrong(&"it is not a regular file"));
    }
    if metadata.len() > most {
        return Err(wrong(&format!("it has more than the {most} bytes that are allowed")));
    }
    std::fs::read(&file).map_err(|error| wrong(&error))
}

fn excerpt(uri: &str) -> String {
    uri.chars().filter(|c| !c.is_control()).take(60).collect()
}

/// The file that a relative URI stands for; `None` if it leads elsewhere.
fn beside(uri: &str, path: &Path) -> Option<PathBuf> {
    let folder = path.with_file_name("");
    [uri.to_owned(), unescaped(uri)].into_iter().map(|name| name.replace('\\', "/")).find_map(
        |name| {
            let relative = Path::new(&name);
            let is_below = relative
                .components()
                .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
            let file = folder.join(relative);
            (is_below && !name.contains(':') && (file.exists() || name == unescaped(uri)))
                .then_some(file)
        },
    )
}

/// The name with `%20` and its like undone.
fn unescaped(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after
            .get(..2)
            .filter(|_| *first == b'%')
            .and_then(|digits| u8::from_str_radix(str::from_utf8(digits).ok()?, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(bytes).unwrap_or_else(|_| name.to_owned())
}
