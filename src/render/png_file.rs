//! A PNG file that is written row by row, so that pictures of any size go through little memory.

use std::fs::File;
use std::io::{Error as IoError, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, StreamWriter};
use tempfile::NamedTempFile;
use thiserror::Error;

use crate::color::Color;

/// What can go wrong with a [`PngFile`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PngError {
    /// The file cannot be made, written or given its name.
    #[error(
        "cannot write {}: {source}; check that its folder is there, may be written to and has room",
        path.display()
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: IoError,
    },
    /// A PNG file cannot have that size.
    #[error("cannot write {}: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What the encoder says.
        source: EncodingError,
    },
    /// A row has not as many pixels as the picture has columns.
    #[error("cannot write {}: row {row} has {found} pixels instead of {expected}", path.display())]
    RowLength {
        /// The file.
        path: PathBuf,
        /// The number of the row, from 0.
        row: u32,
        /// The picture's width.
        expected: u32,
        /// The pixels given.
        found: usize,
    },
    /// There were too few rows, or there is one too many.
    #[error("cannot write {}: {found} rows instead of {expected}", path.display())]
    RowCount {
        /// The file.
        path: PathBuf,
        /// The picture's height.
        expected: u32,
        /// The rows given.
        found: u32,
    },
}

/// A PNG file of 8 bits a channel, sRGB, being written from top to bottom.
///
/// Until it is [finished](Self::finish) it has a temporary name, in the same folder. If it is
/// dropped before that, it is removed; a file that had its name before is left as it was. Where the
/// process is killed, the temporary file stays.
///
/// ```
/// use glam::{Vec3, vec4};
/// use polyscan::{Mesh, ScanlineRenderer, Vertex, Viewport, render::PngFile};
///
/// let vertices = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), [x, y, 0.0]));
/// let path = std::env::temp_dir().join("triangle.png");
/// let mut file = PngFile::opaque(&path, 300, 200)?;
/// let mut renderer = ScanlineRenderer::new(Viewport::new(300, 200)?);
/// let mesh = Mesh::new(&vertices, [[0, 1, 2]]);
/// renderer.stream(mesh, Vec3::ZERO, |f| Vec3::from(f.params), |_, row| file.write_row(row))?;
/// file.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[must_use = "without `finish` there is no file"]
pub struct PngFile {
    path: PathBuf,
    file: NamedTempFile,
    /// `None` after an error.
    encoder: Option<Stream>,
    width: u32,
    height: u32,
    rows: u32,
    has_alpha: bool,
    bytes: Vec<u8>,
}

/// The encoder, which has no `Debug` of its own.
struct Stream(StreamWriter<'static, File>);

/// Bytes of the compressed picture that are written at a time.
const BUFFER: usize = 1 << 18;

/// The chunk that ends each PNG file: it has no data (PNG specification, section 11.2.5).
const END: [u8; 12] = *b"\0\0\0\0IEND\xae\x42\x60\x82";

impl std::fmt::Debug for Stream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Stream")
    }
}

impl PngFile {
    /// Begins a file with alpha.
    ///
    /// # Errors
    /// When there is no file to be made in the folder, or a side is 0 or longer than 2^31 - 1.
    pub fn new(path: impl AsRef<Path>, width: u32, height: u32) -> Result<Self, PngError> {
        Self::begin(path.as_ref(), (width, height), true)
    }

    /// Begins a file without alpha; that of the colours is left out.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn opaque(path: impl AsRef<Path>, width: u32, height: u32) -> Result<Self, PngError> {
        Self::begin(path.as_ref(), (width, height), false)
    }

    fn begin(path: &Path, (width, height): (u32, u32), has_alpha: bool) -> Result<Self, PngError> {
        let write = |source| PngError::Write { path: path.into(), source };
        let file = temporary(path).map_err(write)?;
        let mut encoder = Encoder::new(file.as_file().try_clone().map_err(write)?, width, height);
        encoder.set_color(if has_alpha { ColorType::Rgba } else { ColorType::Rgb });
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(Compression::Fast);
        // Large pictures are alike from row to row.
        encoder.set_filter(Filter::Up);
        let stream =
            encoder.write_header().and_then(|writer| writer.into_stream_writer_with_size(BUFFER));
        let encoder = Some(Stream(stream.map_err(|error| encoding(path, error))?));
        let (path, bytes) = (path.to_owned(), Vec::new());
        Ok(Self { path, file, encoder, width, height, rows: 0, has_alpha, bytes })
    }

    /// Writes the next row.
    ///
    /// # Errors
    /// When the row has a wrong number of pixels, the picture has all its rows, or the disk is full.
    /// After that the file can only be dropped.
    pub fn write_row<C: Color>(&mut self, row: &[C]) -> Result<(), PngError> {
        // Whatever goes wrong, the encoder is not put back.
        let Some(Stream(mut encoder)) = self.encoder.take() else { return Err(self.row_count()) };
        if self.rows == self.height {
            self.rows = self.rows.saturating_add(1);
            return Err(self.row_count());
        }
        if row.len() != self.width as usize {
            let (path, row, found) = (self.path.clone(), self.rows, row.len());
            return Err(PngError::RowLength { path, row, expected: self.width, found });
        }
        self.bytes.clear();
        let channels = if self.has_alpha { 4 } else { 3 };
        self.bytes.extend(row.iter().flat_map(|color| color.to_srgb8().into_iter().take(channels)));
        encoder.write_all(&self.bytes).map_err(|source| self.write_error(source))?;
        self.rows += 1;
        self.encoder = Some(Stream(encoder));
        Ok(())
    }

    /// Ends the file and gives it its name; a file of that name is replaced.
    ///
    /// # Errors
    /// When rows are missing, there was an error before, or the system refuses. Then there is no
    /// such file, or the one that was there before.
    pub fn finish(mut self) -> Result<(), PngError> {
        let encoder = self.encoder.take().filter(|_| self.rows == self.height);
        let Some(Stream(encoder)) = encoder else { return Err(self.row_count()) };
        encoder.finish().map_err(|error| encoding(&self.path, error))?;
        // The encoder does not tell whether it could write the end.
        let mut end = [0; END.len()];
        let file = self.file.as_file_mut();
        let read =
            file.seek(SeekFrom::End(-(END.len() as i64))).and_then(|_| file.read_exact(&mut end));
        read.map_err(|source| self.write_error(source))?;
        if end != END {
            return Err(self.write_error(ErrorKind::WriteZero.into()));
        }
        let Self { path, file, .. } = self;
        file.persist(&path).map_err(|error| PngError::Write { path, source: error.error })?;
        Ok(())
    }

    fn row_count(&self) -> PngError {
        PngError::RowCount { path: self.path.clone(), expected: self.height, found: self.rows }
    }

    fn write_error(&self, source: IoError) -> PngError {
        PngError::Write { path: self.path.clone(), source }
    }
}

fn encoding(path: &Path, error: EncodingError) -> PngError {
    let path = path.to_owned();
    match error {
        EncodingError::IoError(source) => PngError::Write { path, source },
        source => PngError::Format { path, source },
    }
}

/// A file beside `path` that is removed when dropped.
fn temporary(path: &Path) -> Result<NamedTempFile, IoError> {
    let name = path.file_name().ok_or(ErrorKind::InvalidFilename)?;
    if path.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    builder.prefix(name).suffix(".part");
    // By `std`, so that it has the permissions of any new file, where temporary ones are their owner's
    // alone, and so that errors do not speak of its temporary name.
    let create = |path: &Path| File::options().read(true).write(true).create_new(true).open(path);
    builder.make_in(folder.unwrap_or(Path::new(".")), create)
}
