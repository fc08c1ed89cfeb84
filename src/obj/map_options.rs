//! The options of a line that names a picture, before the name and, in some files, behind it.

use glam::Vec2;

use crate::model::TextureMapping;
use crate::obj::lines::split_word;

/// What the options of a line say.
#[derive(Clone, Copy)]
pub(super) struct MapOptions {
    pub(super) mapping: TextureMapping,
    /// `-bm`: what multiplies bumps and heights.
    pub(super) bump: f32,
}

/// What an option takes.
#[derive(Clone, Copy)]
enum Takes {
    /// One word.
    Word,
    /// So many numbers at least and at most.
    Numbers(usize, usize),
}

/// What the options of the format take (Wavefront, "MTL material format", texture map options).
fn takes(option: &str) -> Option<Takes> {
    Some(match option {
        "-blendu" | "-blendv" | "-boost" | "-cc" | "-clamp" | "-imfchan" | "-texres" | "-type"
        | "-halo" => Takes::Word,
        "-bm" => Takes::Numbers(1, 1),
        "-mm" => Takes::Numbers(2, 2),
        // One number for each direction that matters.
        "-o" | "-s" | "-t" => Takes::Numbers(1, 3),
        _ => return None,
    })
}

/// Names that a line may mean, the likeliest first, each with what the options say if it is that one.
///
/// An option that the format does not have is taken for one of a word, unless the whole is the name.
pub(super) fn readings(text: &str) -> Vec<(String, MapOptions)> {
    let mut options = MapOptions { mapping: TextureMapping::default(), bump: 1.0 };
    let mut rest = text.trim();
    let mut readings = Vec::new();
    loop {
        let (option, after) = split_word(rest);
        if !option.starts_with('-') {
            break;
        }
        match takes(&option.to_ascii_lowercase()) {
            Some(takes) => rest = apply(option, takes, after, &mut options),
            None => {
                // `-8.png` may be a file.
                readings.push((rest.to_owned(), options));
                let (_, after) = split_word(after);
                rest = after;
            }
        }
    }
    readings.push((rest.to_owned(), options));
    // Options behind the name, as in `wood.png -clamp on`.
    if let Some(start) = rest.find(" -") {
        let (name, mut behind) = rest.split_at(start);
        loop {
            let (option, after) = split_word(behind);
            match takes(&option.to_ascii_lowercase()) {
                Some(takes) => behind = apply(option, takes, after, &mut options),
                None if option.starts_with('-') => behind = split_word(after).1,
                None => break,
            }
        }
        readings.push((name.trim().to_owned(), options));
    }
    readings.retain(|(name, _)| !name.is_empty());
    readings
}

/// Applies an option; what follows its arguments.
fn apply<'a>(option: &str, takes: Takes, text: &'a str, options: &mut MapOptions) -> &'a str {
    let mapping = &mut options.mapping;
    let (least, most) = match takes {
        Takes::Word => {
            let (word, rest) = split_word(text);
            if option.eq_ignore_ascii_case("-clamp") {
                mapping.clamp = word.eq_ignore_ascii_case("on");
            }
            return rest;
        }
        Takes::Numbers(least, most) => (least, most),
    };
    let mut numbers = [None; 3];
    let mut rest = text;
    for (i, number) in numbers.iter_mut().enumerate().take(most) {
        let (word, after) = split_word(rest);
        let value = word.parse::<f32>().ok();
        if i >= least && value.is_none() {
            break;
        }
        *number = value.filter(|value| value.is_finite());
        rest = after;
    }
    // What is left out is as it was: the scale of a direction is 1, its offset 0.
    let pair =
        |default: f32| Vec2::new(numbers[0].unwrap_or(default), numbers[1].unwrap_or(default));
    match option.to_ascii_lowercase().as_str() {
        "-s" => mapping.scale = pair(1.0),
        "-o" => mapping.offset = pair(0.0),
        "-mm" => {
            mapping.base = numbers[0].unwrap_or(0.0);
            mapping.gain = numbers[1].unwrap_or(1.0);
        }
        "-bm" => options.bump = numbers[0].unwrap_or(1.0),
        _ => {}
    }
    rest
}
