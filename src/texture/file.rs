//! Texels from picture files: of PNG files by the `png` crate alone, of other formats by `image`.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use png::{BitDepth, Transformations};

use crate::texture::error::TextureError;
use crate::texture::format::Samples;
use crate::texture::limits::{MAX_DECODE_BYTES, MAX_SIDE};
#[cfg(feature = "image")]
use crate::texture::picture;
use crate::texture::texels::{Texels, copied};

/// What the channels of a picture are.
#[derive(Clone, Copy)]
pub(super) enum Meaning {
    /// Colours for the eye, in sRGB.
    Colours,
    /// Numbers that are taken as they stand.
    Numbers,
}

/// What every PNG file begins with (PNG specification, section 5.2).
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Reads a picture, unless it has more than `limit` texels, a side above [`MAX_SIDE`], or takes more
/// than [`MAX_DECODE_BYTES`] to decode.
pub(super) fn read(path: &Path, limit: u64, meaning: Meaning) -> Result<Texels, TextureError> {
    let unreadable = |source| TextureError::Read { path: path.to_owned(), source };
    let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
    let mut head = Vec::new();
    let length = PNG_SIGNATURE.len() as u64;
    file.by_ref().take(length).read_to_end(&mut head).map_err(unreadable)?;
    file.rewind().map_err(unreadable)?;
    if head == PNG_SIGNATURE {
        read_png(path, file, limit, meaning)
    } else {
        read_other(path, &head, file, limit, meaning)
    }
}

fn read_png(
    path: &Path,
    file: impl BufRead + Seek,
    limit: u64,
    meaning: Meaning,
) -> Result<Texels, TextureError> {
    let undecodable = |source: Box<dyn std::error::Error + Send + Sync>| TextureError::Decode {
        path: path.to_owned(),
        source,
    };

    let bytes = usize::try_from(MAX_DECODE_BYTES).unwrap_or(usize::MAX);
    let mut decoder = png::Decoder::new_with_limits(file, png::Limits { bytes });
    // Palettes become colours, clear colours become an alpha channel, and fewer bits become 8.
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let (width, height) =
        decoder.read_header_info().map_err(|error| undecodable(error.into()))?.size();
    check_limits(path, width, height, limit)?;

    let mut reader = decoder.read_info().map_err(|error| undecodable(error.into()))?;
    let bytes = reader.output_buffer_size().filter(|&bytes| bytes as u64 <= MAX_DECODE_BYTES);
    let bytes = bytes.ok_or_else(|| undecodable(OVER_THE_LIMIT.into()))?;
    let bytes_per_texel = reader.info().bytes_per_pixel();
    let mut samples = Vec::new();
    samples.try_reserve_exact(bytes).map_err(|_| TextureError::Memory {
        width,
        height,
        bytes_per_texel,
    })?;
    samples.resize(bytes, 0);
    let frame = reader.next_frame(&mut samples).map_err(|error| undecodable(error.into()))?;
    if (frame.width, frame.height) != (width, height) {
        return Err(undecodable("its first frame is smaller than the picture".into()));
    }

    let channels = frame.color_type.samples();
    let samples = if frame.bit_depth == BitDepth::Sixteen {
        // The most significant byte comes first (PNG specification, section 7.1).
        let words: Vec<u16> =
            samples.as_chunks().0.iter().map(|&bytes| u16::from_be_bytes(bytes)).collect();
        let words = copied((width, height), &words, channels, u16::MAX)?;
        match meaning {
            Meaning::Colours => Samples::Srgb16(words),
            Meaning::Numbers => Samples::Unorm16(words),
        }
    } else {
        let bytes = copied((width, height), &samples, channels, u8::MAX)?;
        match meaning {
            Meaning::Colours => Samples::Srgb8(bytes),
            Meaning::Numbers => Samples::Unorm8(bytes),
        }
    };
    Texels::new(width, height, if channels == 3 { 4 } else { channels }, samples)
}

const OVER_THE_LIMIT: &str = "it takes more memory to decode than is allowed, which is 1 GiB";

fn check_limits(path: &Path, width: u32, height: u32, limit: u64) -> Result<(), TextureError> {
    let texels = u64::from(width) * u64::from(height);
    if width.max(height) > MAX_SIDE || texels > limit {
        return Err(TextureError::TooLarge { path: path.to_owned(), width, height, limit });
    }
    Ok(())
}

#[cfg(feature = "image")]
fn read_other(
    path: &Path,
    _head: &[u8],
    file: impl BufRead + Seek,
    limit: u64,
    meaning: Meaning,
) -> Result<Texels, TextureError> {
    use image::ImageDecoder as _;
    let undecodable = |source: image::ImageError| TextureError::Decode {
        path: path.to_owned(),
        source: source.into(),
    };

    let mut reader = image::ImageReader::new(file);
    // The content tells more than the name, but that of TGA files tells nothing.
    if let Ok(format) = image::ImageFormat::from_path(path) {
        reader.set_format(format);
    }
    let mut reader = reader
        .with_guessed_format()
        .map_err(|source| TextureError::Read { path: path.to_owned(), source })?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_DECODE_BYTES);
    reader.limits(limits.clone());

    let decoder = reader.into_decoder().map_err(undecodable)?;
    let (width, height) = decoder.dimensions();
    check_limits(path, width, height, limit)?;
    // The decoder counts what it allocates for itself; the picture it fills is counted here.
    if limits.reserve(decoder.total_bytes()).is_err() {
        let (path, source) = (path.to_owned(), OVER_THE_LIMIT.into());
        return Err(TextureError::Decode { path, source });
    }
    let image = image::DynamicImage::from_decoder(decoder).map_err(undecodable)?;
    match meaning {
        Meaning::Colours => picture::colours(&image),
        Meaning::Numbers => picture::numbers(&image),
    }
}

#[cfg(not(feature = "image"))]
fn read_other(
    path: &Path,
    head: &[u8],
    _file: impl BufRead + Seek,
    _limit: u64,
    _meaning: Meaning,
) -> Result<Texels, TextureError> {
    let path = path.to_owned();
    Err(match format_of(&path, head) {
        Some(format) => TextureError::FeatureNeeded { path, format },
        None => TextureError::Decode { path, source: "it is no PNG file".into() },
    })
}

/// Which of the formats that the feature `image` is for a file has: by its first bytes, or by its
/// name's ending where they do not tell.
#[cfg(not(feature = "image"))]
fn format_of(path: &Path, head: &[u8]) -> Option<&'static str> {
    match head {
        [0xFF, 0xD8, 0xFF, ..] => return Some("JPEG"),
        [b'B', b'M', ..] => return Some("BMP"),
        [b'P', b'1'..=b'7', ..] => return Some("PNM"),
        _ => {}
    }
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    match ending.as_str() {
        "jpg" | "jpeg" => Some("JPEG"),
        "bmp" => Some("BMP"),
        "tga" => Some("TGA"),
        "pbm" | "pgm" | "ppm" | "pnm" | "pam" => Some("PNM"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use png::ColorType;
    use tempfile::TempDir;

    use super::*;
    use crate::texture::Texture;

    const TYPES: [(ColorType, &[u8]); 5] = [
        (ColorType::Grayscale, &[1, 2, 4, 8, 16]),
        (ColorType::GrayscaleAlpha, &[8, 16]),
        (ColorType::Indexed, &[1, 2, 4, 8]),
        (ColorType::Rgb, &[8, 16]),
        (ColorType::Rgba, &[8, 16]),
    ];

    /// A sequence of bytes that looks random.
    fn bytes(seed: u32) -> impl Iterator<Item = u8> {
        let mut state = seed.wrapping_mul(0x9E37_79B9) | 1;
        std::iter::repeat_with(move || {
            // A linear congruential generator (Numerical Recipes, 1992); the upper bits are good.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
    }

    /// A picture file: its samples, and what the `tRNS` chunk has, if it is there.
    struct Picture {
        size: (u32, u32),
        color: ColorType,
        depth: u8,
        trns: Option<Vec<u8>>,
        palette: Vec<u8>,
        rows: Vec<u8>,
    }

    impl Picture {
        fn random(
            size: (u32, u32),
            color: ColorType,
            depth: u8,
            has_trns: bool,
            seed: u32,
        ) -> Self {
            let mut random = bytes(seed);
            let bits = size.0 as usize * color.samples() * usize::from(depth);
            let rows = random.by_ref().take(bits.div_ceil(8) * size.1 as usize).collect();
            let palette = random.by_ref().take(3 << depth.min(8)).collect();
            let trns = match color {
                ColorType::Indexed => random.take((1 << depth) - 1).collect(),
                ColorType::Grayscale if depth < 8 => vec![0, 1],
                // The first pixel is to be clear.
                ColorType::Grayscale if depth == 8 => vec![0, 0x55],
                ColorType::Grayscale => vec![0x55, 0x66],
                _ if depth == 8 => vec![0, 0x55, 0, 0x66, 0, 0x77],
                _ => vec![0x55, 0x66, 0x77, 0x88, 0x99, 0xAA],
            };
            let mut picture =
                Self { size, color, depth, trns: has_trns.then_some(trns), palette, rows };
            if let Some(trns) = &picture.trns
                && color != ColorType::Indexed
                && depth >= 8
            {
                let step = if depth == 8 { 2 } else { 1 };
                let skip = usize::from(depth == 8);
                for (sample, &clear) in
                    picture.rows.iter_mut().zip(trns.iter().skip(skip).step_by(step))
                {
                    *sample = clear;
                }
            }
            picture
        }

        fn save(&self, folder: &TempDir) -> PathBuf {
            let path = folder.path().join(format!("{:?}{}.png", self.color, self.depth));
            let file = File::create(&path).expect("a file");
            let mut encoder = png::Encoder::new(file, self.size.0, self.size.1);
            encoder.set_color(self.color);
            encoder.set_depth(BitDepth::from_u8(self.depth).expect("a depth"));
            if self.color == ColorType::Indexed {
                encoder.set_palette(self.palette.clone());
            }
            if let Some(trns) = &self.trns {
                encoder.set_trns(trns.clone());
            }
            let mut writer = encoder.write_header().expect("a header");
            writer.write_image_data(&self.rows).expect("the samples");
            writer.finish().expect("an end");
            path
        }

        /// The sample with a number in a row, counted in samples.
        fn sample(&self, row: u32, i: usize) -> u16 {
            let bits = usize::from(self.depth);
            let width = self.size.0 as usize * self.color.samples() * bits;
            let start = width.div_ceil(8) * row as usize;
            let byte = |at: usize| u16::from(self.rows[start + at]);
            match bits {
                16 => byte(2 * i) << 8 | byte(2 * i + 1),
                8 => byte(i),
                _ => byte(i * bits / 8) >> (8 - bits - i * bits % 8) & ((1 << bits) - 1),
            }
        }

        /// The texel by the PNG specification (sections 11.2 and 11.3.2): sRGB and alpha, 0 to 1.
        fn rgba(&self, x: u32, y: u32) -> [f64; 4] {
            let count = self.color.samples();
            let samples: Vec<u16> =
                (0..count).map(|i| self.sample(y, x as usize * count + i)).collect();
            let most = f64::from((1_u32 << self.depth) - 1);
            let scaled = |i: usize| f64::from(samples[i]) / most;
            let clear = self.trns.as_ref().is_some_and(|trns| {
                let keys = trns.chunks(2).map(|key| u16::from(key[0]) << 8 | u16::from(key[1]));
                self.color != ColorType::Indexed && keys.eq(samples.iter().copied())
            });
            let alpha = if clear { 0.0 } else { 1.0 };
            match self.color {
                ColorType::Grayscale => [scaled(0), scaled(0), scaled(0), alpha],
                ColorType::GrayscaleAlpha => [scaled(0), scaled(0), scaled(0), scaled(1)],
                ColorType::Rgb => [scaled(0), scaled(1), scaled(2), alpha],
                ColorType::Rgba => [scaled(0), scaled(1), scaled(2), scaled(3)],
                ColorType::Indexed => {
                    let index = usize::from(samples[0]);
                    let [r, g, b] =
                        [0, 1, 2].map(|i| f64::from(self.palette[3 * index + i]) / 255.0);
                    let alpha = self.trns.as_ref().and_then(|trns| trns.get(index));
                    [r, g, b, alpha.map_or(1.0, |&alpha| f64::from(alpha) / 255.0)]
                }
            }
        }
    }

    fn pictures(mut check: impl FnMut(&Picture, &Path)) {
        let folder = tempfile::tempdir().expect("a folder");
        let mut seed = 0;
        for (color, depths) in TYPES {
            let trns = match color {
                ColorType::GrayscaleAlpha | ColorType::Rgba => &[false][..],
                _ => &[false, true],
            };
            for ((&depth, &has_trns), size) in depths
                .iter()
                .flat_map(|depth| trns.iter().map(move |trns| (depth, trns)))
                .flat_map(|both| [(1, 1), (7, 5), (32, 3), (33, 9)].map(|size| (both, size)))
            {
                seed += 1;
                let picture = Picture::random(size, color, depth, has_trns, seed);
                check(&picture, &picture.save(&folder));
            }
        }
    }

    #[test]
    fn png_files_of_every_type_are_what_the_specification_says() {
        let mut clear = 0;
        pictures(|picture, path| {
            let colours = Texture::open(path).expect("a picture");
            let numbers = Texture::open_data(path).expect("a picture");
            assert_eq!((colours.width(), colours.height()), picture.size);
            for (y, x) in (0..picture.size.1).flat_map(|y| (0..picture.size.0).map(move |x| (y, x)))
            {
                let [r, g, b, alpha] = picture.rgba(x, y);
                clear += u32::from(alpha == 0.0);
                let light = [r, g, b].map(|code| crate::color::linear(code) * alpha);
                let place = format!("{} at {x}, {y}", path.display());
                for (texel, exact) in [
                    (numbers.texel(x, y), [r, g, b, alpha]),
                    (colours.texel(x, y), [light[0], light[1], light[2], alpha]),
                ] {
                    for (ours, exact) in texel.to_array().into_iter().zip(exact) {
                        assert!((f64::from(ours) - exact).abs() < 1e-7, "{place}: {ours}, {exact}");
                    }
                }
            }
        });
        assert!(clear > 20, "the clear colours were met {clear} times");
    }

    #[cfg(feature = "image")]
    #[test]
    fn png_files_are_what_the_image_crate_makes_of_them() {
        pictures(|_, path| {
            let image = image::open(path).expect("a picture");
            let colours = Texture::from_image(&image).expect("a small picture");
            assert!(Texture::open(path).expect("a picture").texels().eq(colours.texels()));
            let theirs = Texture::from_data(&image).expect("a small picture");
            let ours = Texture::open_data(path).expect("a picture");
            assert!(ours.texels().eq(theirs.texels()), "{}", path.display());
        });
    }

    /// A file that ends after its header.
    fn header_only(folder: &TempDir, (width, height): (u32, u32), color: ColorType) -> PathBuf {
        let path = folder.path().join("huge.png");
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(color);
        encoder.set_depth(BitDepth::Sixteen);
        let writer = encoder.write_header().expect("a header");
        drop(writer);
        // The end that the writer gives it, and instead the beginning of the picture.
        file.truncate(file.len() - 12);
        file.extend(b"\0\0\0\x08IDAT\x78\x01");
        std::fs::write(&path, file).expect("a file");
        path
    }

    #[test]
    fn a_small_png_file_cannot_ask_for_much_memory() {
        let folder = tempfile::tempdir().expect("a folder");
        for (size, color, cause) in [
            ((70_000, 1), ColorType::Grayscale, "70000 x 1"),
            ((16_385, 16_384), ColorType::Grayscale, "16385 x 16384"),
            ((16_384, 16_384), ColorType::Rgb, "more memory"),
            ((8, 8), ColorType::Rgb, "cannot decode"),
        ] {
            let error = Texture::open(header_only(&folder, size, color)).expect_err("no picture");
            assert!(error.to_string().contains(cause), "{error}");
            assert!(error.to_string().contains("huge.png"), "{error}");
        }
        let path = header_only(&folder, (8, 8), ColorType::Rgb);
        let error = Texture::open_within(&path, 63).expect_err("too large");
        assert!(matches!(error, TextureError::TooLarge { limit: 63, .. }), "{error}");
    }

    #[test]
    fn png_files_that_are_cut_or_changed_are_errors_or_pictures() {
        let folder = tempfile::tempdir().expect("a folder");
        let picture = Picture::random((33, 9), ColorType::Indexed, 4, true, 7);
        let whole = std::fs::read(picture.save(&folder)).expect("a file");
        let path = folder.path().join("changed.png");
        let mut random = bytes(9);
        for i in 0..whole.len() {
            std::fs::write(&path, &whole[..i]).expect("a file");
            if let Err(error) = Texture::open(&path) {
                assert!(error.to_string().contains("changed.png"), "{error}");
            }
            let mut changed = whole.clone();
            changed[i] ^= random.next().unwrap_or(0) | 1;
            std::fs::write(&path, &changed).expect("a file");
            if let Err(error) = Texture::open(&path) {
                assert!(error.to_string().contains("changed.png"), "{error}");
            }
        }
    }

    #[cfg(not(feature = "image"))]
    #[test]
    fn other_formats_tell_what_to_enable() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, content, format) in [
            ("a.bin", &b"\xFF\xD8\xFF\xE0"[..], "JPEG"),
            ("a.bin", b"BM....", "BMP"),
            ("a.bin", b"P6 1 1 255\n...", "PNM"),
            ("a.TGA", b"\0\0\x02", "TGA"),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, content).expect("a file");
            let error = Texture::open(&path).expect_err("no PNG file");
            assert_eq!(
                error.to_string(),
                format!(
                    "the picture {} is a {format} file: enable polyscan's feature `image` to read \
                     it, or save it again as PNG",
                    path.display()
                )
            );
        }
        let path = folder.path().join("a.png");
        for content in [&b""[..], b"\x89PN", b"not a picture"] {
            std::fs::write(&path, content).expect("a file");
            let error = Texture::open(&path).expect_err("no picture");
            let sentence = "it is no PNG file; save it again as PNG";
            assert!(error.to_string().ends_with(sentence), "{error}");
        }
    }
}
