//! PNG and GIF files, whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Encoder, SrgbRenderingIntent};
use tempfile::NamedTempFile;

/// A picture to write.
pub(crate) struct Picture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixels: Pixels,
}

/// The pixels of a picture, row by row from the top.
pub(crate) enum Pixels {
    /// Colours in sRGB with alpha, of one picture, or of several that follow each other.
    Colors(Vec<Vec<u8>>),
    /// Numbers in three channels of 8 bits.
    Numbers(Vec<u8>),
    /// Numbers in one channel of 16 bits.
    Depths(Vec<u16>),
}

/// Writes a picture to a file, or to the standard output if the name is `-`.
pub(crate) fn write(picture: &Picture, path: &Path) -> Result<(), String> {
    if is_stdout(path) {
        let mut bytes = Vec::new();
        encode(picture, &mut bytes).map_err(|error| format!("cannot make the picture: {error}"))?;
        let mut out = io::stdout().lock();
        let written = out.write_all(&bytes).and_then(|()| out.flush());
        return written.map_err(|error| format!("cannot write to the standard output: {error}"));
    }
    let is_gif = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif"));
    match &picture.pixels {
        Pixels::Colors(frames) if is_gif => save(path, |file| {
            let size = (picture.width, picture.height);
            encode_gif(size, frames, file).map_err(io::Error::other)
        }),
        _ => save(path, |file| encode(picture, file).map_err(io::Error::other)),
    }
}

pub(crate) fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Writes a file that gets its name when it is whole.
fn save(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let saved = || {
        let mut file = NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
        let mut buffer = BufWriter::new(file.as_file_mut());
        write(&mut buffer)?;
        buffer.flush()?;
        drop(buffer);
        readable(&file)?;
        file.persist(path).map_err(|error| error.error)?;
        Ok(())
    };
    saved().map_err(|error: io::Error| format!("cannot write {}: {error}", path.display()))
}

/// Temporary files are for their owner alone; pictures are like other files.
#[cfg(unix)]
fn readable(file: &NamedTempFile) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;

    file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable(_: &NamedTempFile) -> io::Result<()> {
    Ok(())
}

fn encode(picture: &Picture, out: impl Write) -> Result<(), png::EncodingError> {
    let mut encoder = Encoder::new(out, picture.width, picture.height);
    // Drawing takes less time than packing well would.
    encoder.set_compression(Compression::Fast);
    match &picture.pixels {
        Pixels::Colors(frames) => {
            encoder.set_color(ColorType::Rgba);
            encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
            if frames.len() > 1 {
                let count = frames.len() as u32;
                // Again and again; the whole turn in four seconds.
                encoder.set_animated(count, 0)?;
                encoder.set_frame_delay(4, count as u16)?;
            }
            let mut writer = encoder.write_header()?;
            for frame in frames {
                writer.write_image_data(frame)?;
            }
            writer.finish()
        }
        Pixels::Numbers(bytes) => {
            encoder.set_color(ColorType::Rgb);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(bytes)?;
            writer.finish()
        }
        Pixels::Depths(depths) => {
            encoder.set_color(ColorType::Grayscale);
            encoder.set_depth(BitDepth::Sixteen);
            let mut writer = encoder.write_header()?;
            let bytes: Vec<u8> = depths.iter().flat_map(|depth| depth.to_be_bytes()).collect();
            writer.write_image_data(&bytes)?;
            writer.finish()
        }
    }
}

/// Each picture has 256 colours of its own, one of which is transparent.
fn encode_gif(
    (width, height): (u32, u32),
    frames: &[Vec<u8>],
    out: impl Write,
) -> Result<(), gif::EncodingError> {
    // From 1, the best colours, to 30.
    const SPEED: i32 = 10;
    // In hundredths of a second; the whole turn in four seconds. Programs that show less than 2 take it for 10.
    let delay = (400 / frames.len().max(1)).clamp(2, 400) as u16;
    let mut encoder = gif::Encoder::new(out, width as u16, height as u16, &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    for pixels in frames {
        let mut pixels = pixels.clone();
        for pixel in pixels.chunks_exact_mut(4) {
            // There is no glass in these files.
            pixel[3] = if pixel[3] < 128 { 0 } else { 255 };
        }
        let mut frame =
            gif::Frame::from_rgba_speed(width as u16, height as u16, &mut pixels, SPEED);
        frame.delay = delay;
        frame.dispose = gif::DisposalMethod::Background;
        encoder.write_frame(&frame)?;
    }
    Ok(())
}
