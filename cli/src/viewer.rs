//! A model in a window.
//!
//! What people do (`viewer::state`) changes how the model is seen; each picture is drawn as pictures for files
//! are, and shown as it is. Nothing is drawn while nothing changes.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Instant;

use polyscan::Texture;
use polyscan::camera::Sphere;
use polyscan::formats::Loaded;
use polyscan::glam::{DVec2, Vec4};
use softbuffer::{Context, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, OwnedDisplayHandle};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

use crate::draw::{Renderers, Scene, Shot, Style, Vertices};
use crate::options::ViewOptions;
use crate::output::{Picture, Pixels, write};
use crate::pixels::{encode, encode_to};
use crate::view::{View, sphere_of};

mod state;
mod clock;

use self::clock::Clock;
use self::state::{Action, State};

/// Shows a model until its window is closed.
pub(crate) fn show(options: &ViewOptions) -> Result<(), String> {
    let loaded = options.files.loader().load(&options.model).map_err(|error| error.to_string())?;
    for warning in &loaded.warnings {
        eprintln!("warning: {warning}");
    }
    let no_window = |error: &dyn std::fmt::Display| {
        format!(
            "cannot open a window: {error}; a window needs a display, on Linux one that speaks X11"
        )
    };
    let events = EventLoop::new().map_err(|error| no_window(&error))?;
    let context = Context::new(events.owned_display_handle()).map_err(|error| no_window(&error))?;
    let mut viewer = Viewer::new(options, &loaded, context);
    events.run_app(&mut viewer).map_err(|error| no_window(&error))?;
    if let (Some(_), None) = (options.frames, &viewer.error) {
        println!("{}", viewer.clock.summary(viewer.size));
    }
    viewer.error.map_or(Ok(()), Err)
}

/// A window, and the memory that it shows.
struct Shown {
    window: Rc<Window>,
    surface: Surface<OwnedDisplayHandle, Rc<Window>>,
}

struct Viewer<'m> {
    options: &'m ViewOptions,
    loaded: &'m Loaded,
    sphere: Sphere,
    scene: Scene<'m>,
    /// The model's textures, filtered as the state says.
    textures: Vec<Texture>,
    state: State,
    renderers: Renderers,
    vertices: Vertices,
    context: Context<OwnedDisplayHandle>,
    shown: Option<Shown>,
    size: (u32, u32),
    /// Where the pointer was last, and the button that is held.
    pointer: (DVec2, Option<MouseButton>),
    clock: Clock,
    /// Why it ends, if something went wrong.
    error: Option<String>,
}

impl<'m> Viewer<'m> {
    fn new(
        options: &'m ViewOptions,
        loaded: &'m Loaded,
        context: Context<OwnedDisplayHandle>,
    ) -> Self {
        let scene = Scene::new(&loaded.model);
        let state = State::new(scene.method(), options.samples, options.frames);
        let mut viewer = Self {
            options,
            loaded,
            sphere: sphere_of(&loaded.model),
            scene,
            textures: Vec::new(),
            state,
            renderers: Renderers::default(),
            vertices: Vertices::default(),
            context,
            shown: None,
            size: options.size,
            pointer: (DVec2::ZERO, None),
            clock: Clock::default(),
            error: None,
        };
        viewer.filter();
        viewer
    }

    /// Filters the textures as the state says.
    fn filter(&mut self) {
        let filter = self.state.filter();
        let filtered = |texture: &Texture| {
            let texture = texture.clone().with_filter(filter.magnified);
            Ok(texture.with_mipmaps()?.with_mip_filter(filter.minified))
        };
        let textures: Result<Vec<_>, polyscan::texture::TextureError> =
            self.loaded.model.textures.iter().map(filtered).collect();
        match textures {
            Ok(textures) => self.textures = textures,
            Err(error) => self.error = Some(error.to_string()),
        }
    }

    /// Draws a picture of the window's size and hands over its rows.
    fn draw(&mut self, sink: impl FnMut(&[Vec4]) -> Result<(), String>) -> Result<(), String> {
        let Self { options, loaded, state, .. } = self;
        let aspect = self.size.0 as f32 / self.size.1 as f32;
        let view = View::around(self.sphere, loaded.format, &options.eye, aspect, state.turn());
        let style = Style {
            method: state.method(),
            samples: state.samples(),
            background: options.background.0,
            lines: state.lines(),
        };
        let memory = std::mem::take(&mut self.vertices);
        let shot = Shot::new(&self.scene, &self.textures, state.moved(view), memory);
        shot.pixels(&mut self.renderers, (self.size, 0..self.size.1), style, sink)?;
        self.vertices = shot.into_memory();
        Ok(())
    }

    /// Draws a picture and shows it.
    fn redraw(&mut self) -> Result<(), String> {
        let Some(Shown { window, mut surface }) = self.shown.take() else { return Ok(()) };
        let wrong = |error: softbuffer::SoftBufferError| format!("cannot show a picture: {error}");
        let start = Instant::now();
        let size = [self.size.0, self.size.1].map(|side| NonZeroU32::new(side.max(1)));
        if let [Some(width), Some(height)] = size {
            surface.resize(width, height).map_err(wrong)?;
        }
        let mut buffer = surface.buffer_mut().map_err(wrong)?;
        let mut done = 0;
        self.draw(|pixels| {
            let codes = &mut buffer[done..done + pixels.len()];
            encode_to(pixels, codes, |[r, g, b, _]| u32::from_be_bytes([0, r, g, b]));
            done += pixels.len();
            Ok(())
        })?;
        let drawn = start.elapsed();
        buffer.present().map_err(wrong)?;
        self.clock.add(drawn);
        window.set_title(&self.title());
        self.shown = Some(Shown { window, surface });
        Ok(())
    }

    fn title(&self) -> String {
        let (model, name) = (&self.loaded.model, self.options.model.file_name());
        let name = name.unwrap_or_default().to_string_lossy();
        format!(
            "{name} - {} faces, {} vertices - {} - {}",
            model.face_count(),
            model.vertices.len(),
            self.state.describe(!model.textures.is_empty()),
            self.clock.describe(),
        )
    }

    /// Writes the picture that is shown to a file beside no other of its name.
    fn save(&mut self) -> Result<(), String> {
        let mut bytes = Vec::new();
        self.draw(|pixels| {
            encode(pixels, &mut bytes);
            Ok(())
        })?;
        let (width, height) = self.size;
        let stem = self.options.model.file_stem().unwrap_or_default().to_string_lossy();
        let names = (1..).map(|i| match i {
            1 => PathBuf::from(format!("{stem}.png")),
            i => PathBuf::from(format!("{stem}-{i}.png")),
        });
        let path = names.into_iter().find(|path| !path.exists()).unwrap_or_default();
        write(&Picture { width, height, pixels: Pixels::Colors(vec![bytes]) }, &path)?;
        println!("wrote {}", path.display());
        Ok(())
    }

    /// Does what a key, the pointer or a picture that is due asks for.
    fn act(&mut self, action: Action, events: &ActiveEventLoop) {
        let done = match action {
            Action::Nothing => return,
            Action::Quit => {
                events.exit();
                Ok(())
            }
            Action::Save => self.save(),
            Action::Filter => {
                self.filter();
                Ok(())
            }
            Action::Draw => Ok(()),
        };
        if let Err(sentence) = done {
            // What cannot be saved is no reason to close the window.
            eprintln!("error: {sentence}");
        }
        if let Some(shown) = &self.shown {
            shown.window.request_redraw();
        }
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), String> {
        let (width, height) = self.options.size;
        let attributes = Window::default_attributes()
            .with_title("polyscan")
            .with_inner_size(PhysicalSize::new(width, height));
        let wrong = |error: &dyn std::fmt::Display| format!("cannot open a window: {error}");
        let window = Rc::new(events.create_window(attributes).map_err(|error| wrong(&error))?);
        let surface = Surface::new(&self.context, window.clone()).map_err(|error| wrong(&error))?;
        let size = window.inner_size();
        self.size = (size.width.max(1), size.height.max(1));
        window.request_redraw();
        self.shown = Some(Shown { window, surface });
        Ok(())
    }

    /// Ends with an error.
    fn fail(&mut self, result: Result<(), String>, events: &ActiveEventLoop) {
        if let Err(sentence) = result {
            self.error = Some(sentence);
            events.exit();
        }
    }

    /// The pointer is somewhere.
    fn point(&mut self, at: DVec2) -> Action {
        let (before, button) = self.pointer;
        self.pointer.0 = at;
        let by = (at - before).as_vec2() / self.size.1 as f32;
        match button {
            Some(MouseButton::Left) => self.state.drag(by),
            Some(_) => self.state.shift(by),
            None => Action::Nothing,
        }
    }
}

impl ApplicationHandler for Viewer<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.shown.is_none() {
            let opened = self.open(events);
            self.fail(opened, events);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let action = match event {
            WindowEvent::CloseRequested => Action::Quit,
            WindowEvent::Resized(size) => {
                self.size = (size.width.max(1), size.height.max(1));
                Action::Draw
            }
            WindowEvent::RedrawRequested => {
                let drawn = self.redraw();
                self.fail(drawn, events);
                self.state.drawn()
            }
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed => {
                match event.logical_key.as_ref() {
                    Key::Character(text) => self.state.key(text),
                    Key::Named(key) => self.state.key(name_of(key)),
                    _ => Action::Nothing,
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                self.pointer.1 = (state == ElementState::Pressed).then_some(button);
                Action::Nothing
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.point(DVec2::new(position.x, position.y))
            }
            WindowEvent::MouseWheel { delta, .. } => self.state.scroll(match delta {
                MouseScrollDelta::LineDelta(_, lines) => lines,
                MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
            }),
            _ => Action::Nothing,
        };
        self.act(action, events);
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        events.set_control_flow(ControlFlow::Wait);
    }
}

/// The names by which the state knows keys that are no characters.
fn name_of(key: NamedKey) -> &'static str {
    match key {
        NamedKey::ArrowLeft => "left",
        NamedKey::ArrowRight => "right",
        NamedKey::ArrowUp => "up",
        NamedKey::ArrowDown => "down",
        NamedKey::Escape => "q",
        NamedKey::Home => "0",
        _ => "",
    }
}
