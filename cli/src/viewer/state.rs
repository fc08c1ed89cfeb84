//! How a model is seen, and what keys and the pointer change of it.

use polyscan::glam::{Mat4, Vec2, Vec4, vec4};
use polyscan::texture::{Filter, MipFilter};

use crate::draw::{Lines, Method};
use crate::view::View;

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Nothing,
    Draw,
    /// The textures are to be filtered in another way, and drawn.
    Filter,
    Save,
    Quit,
}

/// How textures are filtered.
pub(super) struct TextureFilter {
    name: &'static str,
    pub(super) magnified: Filter,
    pub(super) minified: MipFilter,
}

const FILTERS: [TextureFilter; 5] = [
    TextureFilter {
        name: "anisotropic",
        magnified: Filter::Bilinear,
        minified: MipFilter::Anisotropic { probes: 16 },
    },
    TextureFilter {
        name: "EWA",
        magnified: Filter::Bilinear,
        minified: MipFilter::Ewa { eccentricity: 16 },
    },
    TextureFilter { name: "nearest", magnified: Filter::Nearest, minified: MipFilter::Off },
    TextureFilter { name: "bilinear", magnified: Filter::Bilinear, minified: MipFilter::Off },
    TextureFilter { name: "trilinear", magnified: Filter::Bilinear, minified: MipFilter::Linear },
];

const METHODS: [(Method, &str); 3] = [
    (Method::ZBuffer, "z-buffer"),
    (Method::Scanline, "scanline"),
    (Method::Painter, "painter's by a tree"),
];

/// Degrees that a key turns by.
const STEP: f32 = 5.0;

/// Degrees that dragging over the height of the window turns by.
const DRAG: f32 = 270.0;

/// Degrees a picture, of a model that turns by itself.
const TURN: f32 = 1.0;

/// The most samples a pixel in x, and in y.
const MOST_SAMPLES: u32 = 4;

/// How a model is seen.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    /// Degrees to the right and up, from where the eye stood at first.
    turn: (f32, f32),
    /// How much larger the model is than at first.
    zoom: f32,
    /// Where its middle is on the screen, in halves of the height, up.
    shift: Vec2,
    method: usize,
    filter: usize,
    samples: u32,
    wireframe: bool,
    edges: bool,
    is_turning: bool,
    /// How many pictures are left of how many, if it ends by itself.
    left: Option<(u32, u32)>,
}

impl State {
    /// As at first; with `frames` it makes one full turn in so many pictures.
    pub(super) fn new(method: Method, samples: u32, frames: Option<u32>) -> Self {
        Self {
            turn: (0.0, 0.0),
            zoom: 1.0,
            shift: Vec2::ZERO,
            method: METHODS.iter().position(|&(it, _)| it == method).unwrap_or(0),
            filter: 0,
            samples,
            wireframe: false,
            edges: false,
            is_turning: frames.is_some(),
            left: frames.map(|frames| (frames, frames)),
        }
    }

    pub(super) fn turn(&self) -> (f32, f32) {
        self.turn
    }

    pub(super) fn method(&self) -> Method {
        METHODS[self.method].0
    }

    pub(super) fn filter(&self) -> &'static TextureFilter {
        &FILTERS[self.filter]
    }

    pub(super) fn samples(&self) -> u32 {
        self.samples
    }

    pub(super) fn lines(&self) -> Lines {
        Lines { wireframe: self.wireframe, edges: self.edges }
    }

    /// The view, nearer and moved on the screen.
    pub(super) fn moved(&self, view: View) -> View {
        let Self { zoom, shift, .. } = *self;
        let columns = [
            vec4(zoom, 0.0, 0.0, 0.0),
            vec4(0.0, zoom, 0.0, 0.0),
            Vec4::Z,
            vec4(shift.x, shift.y, 0.0, 1.0),
        ];
        let [x, y, z, w] = columns;
        let moved = Mat4::from_cols(x, y, z, w) * view.clip_from_object;
        View { clip_from_object: moved, ..view }
    }

    /// In words.
    pub(super) fn describe(&self, has_textures: bool) -> String {
        let filter = if has_textures { FILTERS[self.filter].name } else { "no textures" };
        let samples = self.samples * self.samples;
        let (method, s) = (METHODS[self.method].1, if samples == 1 { "" } else { "s" });
        format!("{method}, {filter}, {samples} sample{s} a pixel")
    }

    /// A key is pressed, given by its character or its name.
    pub(super) fn key(&mut self, key: &str) -> Action {
        match key.to_lowercase().as_str() {
            "r" => self.method = (self.method + 1) % METHODS.len(),
            "f" => {
                self.filter = (self.filter + 1) % FILTERS.len();
                return Action::Filter;
            }
            "a" => self.samples = self.samples % MOST_SAMPLES + 1,
            "w" => self.wireframe = !self.wireframe,
            "e" => self.edges = !self.edges,
            "t" => self.is_turning = !self.is_turning,
            "left" => self.turn.0 -= STEP,
            "right" => self.turn.0 += STEP,
            "up" => self.turn.1 += STEP,
            "down" => self.turn.1 -= STEP,
            "+" | "=" => return self.scroll(1.0),
            "-" => return self.scroll(-1.0),
            "0" => (self.turn, self.zoom, self.shift) = ((0.0, 0.0), 1.0, Vec2::ZERO),
            "p" => return Action::Save,
            "q" => return Action::Quit,
            _ => return Action::Nothing,
        }
        Action::Draw
    }

    /// The pointer drags the model, by parts of the window's height to the right and down.
    pub(super) fn drag(&mut self, by: Vec2) -> Action {
        self.turn.0 -= by.x * DRAG;
        self.turn.1 += by.y * DRAG;
        Action::Draw
    }

    /// The pointer moves the model on the screen.
    pub(super) fn shift(&mut self, by: Vec2) -> Action {
        self.shift += Vec2::new(2.0 * by.x, -2.0 * by.y);
        Action::Draw
    }

    /// The wheel is turned, by so many lines up.
    pub(super) fn scroll(&mut self, lines: f32) -> Action {
        let zoom = self.zoom * 1.1_f32.powf(lines.clamp(-10.0, 10.0));
        self.zoom = zoom.clamp(0.01, 1000.0);
        Action::Draw
    }

    /// A picture is shown; what comes next.
    pub(super) fn drawn(&mut self) -> Action {
        if let Some((left, all)) = &mut self.left {
            *left = left.saturating_sub(1);
            self.turn.0 += 360.0 / *all as f32;
            return if *left == 0 { Action::Quit } else { Action::Draw };
        }
        if !self.is_turning {
            return Action::Nothing;
        }
        self.turn.0 = (self.turn.0 + TURN) % 360.0;
        Action::Draw
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> State {
        State::new(Method::ZBuffer, 1, None)
    }

    #[test]
    fn keys_that_are_pressed_often_enough_bring_everything_back() {
        for (key, times) in [("r", 3), ("f", 5), ("A", 4), ("w", 2), ("e", 2), ("t", 2)] {
            let mut changed = state();
            for i in 0..times {
                assert!(i == 0 || changed != state(), "{key} {i}");
                assert_ne!(changed.key(key), Action::Nothing, "{key}");
            }
            assert_eq!(changed, state(), "{key}");
        }
        let mut changed = state();
        changed.drag(Vec2::new(0.5, -0.25));
        changed.shift(Vec2::new(0.1, 0.2));
        changed.scroll(3.0);
        assert_eq!(changed.turn, (-135.0, -67.5));
        changed.key("0");
        assert_eq!(changed, state());
    }

    /// The middle of the model follows the pointer.
    #[test]
    fn the_model_moves_with_the_pointer() {
        let mut moved = state();
        // To the right by a quarter of the height, and up by an eighth of it.
        moved.shift(Vec2::new(0.25, -0.125));
        let view = View { clip_from_object: Mat4::IDENTITY, axes: Default::default() };
        let at = moved.moved(view).clip_from_object * vec4(0.0, 0.0, 1.0, 2.0);
        assert_eq!((at / at.w).truncate().truncate(), Vec2::new(0.5, 0.25));
    }

    #[test]
    fn a_turn_ends_after_its_pictures() {
        let mut turning = State::new(Method::ZBuffer, 1, Some(3));
        assert_eq!(turning.drawn(), Action::Draw);
        assert_eq!(turning.drawn(), Action::Draw);
        assert_eq!(turning.turn.0, 240.0);
        assert_eq!(turning.drawn(), Action::Quit);
        assert_eq!(state().drawn(), Action::Nothing);
    }
}
