//! Where the samples of a pixel are: the standard patterns of Direct3D 11 and Vulkan. Of 4:
//!
//! ```text
//!     +-------------------+     in 16ths of a pixel from its centre, to the right and downwards:
//!     |      0            |
//!     |               1   |     0 (-2, -6)    1 (6, -2)
//!     |         .         |     2 (-6, 2)     3 (2, 6)
//!     |   2               |
//!     |            3      |
//!     +-------------------+
//! ```

use crate::render::shader::MOST_SAMPLES;

/// How many samples a pixel has, at the places of Direct3D's and Vulkan's standard patterns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Samples {
    /// 4.
    #[default]
    Four,
    /// 8.
    Eight,
    /// 16.
    Sixteen,
}

/// In 16ths of a pixel from the centre, to the right and downwards (Direct3D 11.3 Functional
/// Specification, section 19.2.4.1).
const FOUR: [[i8; 2]; 4] = [[-2, -6], [6, -2], [-6, 2], [2, 6]];
const EIGHT: [[i8; 2]; 8] =
    [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];
const SIXTEEN: [[i8; 2]; MOST_SAMPLES] = [
    [1, 1],
    [-1, -3],
    [-3, 2],
    [4, -1],
    [-5, -2],
    [2, 5],
    [5, 3],
    [3, -5],
    [-2, 6],
    [0, -7],
    [-4, -6],
    [-6, 4],
    [-8, 0],
    [7, -4],
    [6, 7],
    [-7, -8],
];

/// Subpixels in the unit of the patterns.
const UNIT: i32 = 16;

/// How far from a pixel's centre samples are at most, in subpixels.
pub(crate) const REACH: i32 = 8 * UNIT;

impl Samples {
    /// How many there are.
    #[must_use]
    pub fn count(self) -> usize {
        self.pattern().len()
    }

    /// Where they are, in 1/256 pixel from the pixel's centre: to the right and downwards.
    #[must_use]
    pub fn places(self) -> &'static [[i32; 2]] {
        match self {
            Self::Four => const { &in_subpixels(FOUR) },
            Self::Eight => const { &in_subpixels(EIGHT) },
            Self::Sixteen => const { &in_subpixels(SIXTEEN) },
        }
    }

    /// The same in pixels.
    pub(crate) fn in_pixels(self) -> &'static [[f32; 2]] {
        match self {
            Self::Four => const { &in_pixels(FOUR) },
            Self::Eight => const { &in_pixels(EIGHT) },
            Self::Sixteen => const { &in_pixels(SIXTEEN) },
        }
    }

    fn pattern(self) -> &'static [[i8; 2]] {
        match self {
            Self::Four => &FOUR,
            Self::Eight => &EIGHT,
            Self::Sixteen => &SIXTEEN,
        }
    }
}

const fn in_subpixels<const K: usize>(pattern: [[i8; 2]; K]) -> [[i32; 2]; K] {
    let mut places = [[0; 2]; K];
    let mut sample = 0;
    while sample < K {
        let [x, y] = pattern[sample];
        places[sample] = [x as i32 * UNIT, y as i32 * UNIT];
        sample += 1;
    }
    places
}

const fn in_pixels<const K: usize>(pattern: [[i8; 2]; K]) -> [[f32; 2]; K] {
    let mut places = [[0.0; 2]; K];
    let mut sample = 0;
    while sample < K {
        let [x, y] = pattern[sample];
        places[sample] = [x as f32 / 16.0, y as f32 / 16.0];
        sample += 1;
    }
    places
}
