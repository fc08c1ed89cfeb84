//! Colours that positions have: numbers behind the coordinates, or ZBrush's `#MRGB` lines.

use glam::Vec4;

use crate::color::decode;
use crate::obj::lines::finite;
use crate::obj::notes::Note;

/// The colours of positions, sRGB as written, from 0 to 1 or from 0 to 255.
#[derive(Default)]
pub(super) struct VertexColors {
    /// For each position, up to the last that has one; NaN where there is none.
    written: Vec<[f32; 3]>,
    /// Those of `#MRGB` lines, one after the other.
    mrgb: Vec<[u8; 3]>,
    /// Whether a channel is above 1.
    has_bytes: bool,
}

impl VertexColors {
    /// Adds what stands behind the three coordinates of a position: one number is a weight, three are
    /// red, green and blue.
    pub(super) fn add<'a>(
        &mut self,
        index: u32,
        first: &'a str,
        words: &mut impl Iterator<Item = &'a str>,
    ) -> Result<(), Note> {
        let (Some(second), Some(third)) = (words.next(), words.next()) else {
            // A weight of 1 changes nothing.
            let is_one = first.parse::<f64>() == Ok(1.0);
            return if is_one { Ok(()) } else { Err(Note::Unused("weights of positions")) };
        };
        let mut color = [0.0; 3];
        for (channel, word) in color.iter_mut().zip([first, second, third]) {
            *channel = finite("colour", word).map_err(Note::Color)? as f32;
            self.has_bytes |= *channel > 1.0;
        }
        self.written.resize(index as usize, [f32::NAN; 3]);
        self.written.push(color);
        Ok(())
    }

    /// Adds the colours of a `#MRGB` line: MMRRGGBB in hexadecimal for each position, M for a mask.
    pub(super) fn add_mrgb(&mut self, digits: &str) {
        for color in digits.trim().as_bytes().chunks_exact(8) {
            let number = str::from_utf8(color).ok().and_then(|c| u32::from_str_radix(c, 16).ok());
            let Some(number) = number else { return };
            let [_, r, g, b] = number.to_be_bytes();
            self.mrgb.push([r, g, b]);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.written.is_empty() && self.mrgb.is_empty()
    }

    /// The colour of a position in linear light, with an alpha of 1; white if it has none.
    pub(super) fn of(&self, position: u32) -> Vec4 {
        let position = position as usize;
        let scale = if self.has_bytes { 1.0 } else { 255.0 };
        let [r, g, b] = match (self.written.get(position), self.mrgb.get(position)) {
            (Some(color), _) if !color[0].is_nan() => color.map(|c| light(c * scale)),
            (_, Some(color)) => color.map(decode),
            _ => [1.0; 3],
        };
        Vec4::new(r, g, b, 1.0)
    }
}

/// The linear light of an sRGB code with a fraction, from 0 to 255: on the line between two codes.
fn light(code: f32) -> f32 {
    let low = code.clamp(0.0, 254.0) as u8;
    let (from, to) = (decode(low), decode(low + 1));
    from + (to - from) * (code.clamp(0.0, 255.0) - f32::from(low))
}
