//! The window, on a display of its own (`Xvfb`): what it shows is what is drawn to files.
//!
//! Where there is no `Xvfb` the tests say so and check nothing.

#![cfg(all(feature = "view", target_os = "linux"))]

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    AtomEnum, ConnectionExt as _, ImageFormat, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

const SIZE: (u16, u16) = (320, 240);

/// A display without a screen. It ends with the test.
struct Display {
    server: Child,
    number: String,
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Display {
    /// `None` if there is no server to be had.
    fn open() -> Option<Self> {
        // The server chooses a number that is free, and writes it.
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "640x480x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut server) = server else {
            println!("skipped: there is no Xvfb here; install the package xvfb");
            return None;
        };
        let mut number = String::new();
        let mut out = BufReader::new(server.stdout.take().expect("a pipe"));
        out.read_line(&mut number).expect("the number of the display");
        Some(Self { server, number: format!(":{}", number.trim()) })
    }
}

/// The tool with its window.
struct Viewer {
    tool: Child,
    x: RustConnection,
    window: Window,
    folder: TempDir,
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.tool.kill();
        let _ = self.tool.wait();
    }
}

fn command(display: &Display, folder: &TempDir, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_polyscan"));
    command.args(args).current_dir(folder.path()).env("DISPLAY", &display.number);
    command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    // A cube whose sides differ in colour, one of them of glass.
    let mut text = String::from("mtllib cube.mtl\n");
    text += "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
    for (i, face) in
        ["4 3 2 1", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"].into_iter().enumerate()
    {
        text += &format!("usemtl m{i}\nf {face}\n");
    }
    let material =
        |i: i32| format!("newmtl m{i}\nKd 0.{i} 0.5 0.8\nd {}\n", 1.0 - f64::from(i % 2) * 0.4);
    fs::write(folder.path().join("cube.obj"), text).expect("a file");
    fs::write(folder.path().join("cube.mtl"), (0..6).map(material).collect::<String>())
        .expect("a file");
    folder
}

/// Tries again and again, for some seconds.
fn eventually<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(it) = attempt() {
            return it;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{what} did not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

impl Viewer {
    fn open(display: &Display) -> Self {
        let folder = folder();
        let (width, height) = SIZE;
        let size = format!("{width}x{height}");
        let tool = command(display, &folder, &["view", "cube.obj", "--size", &size])
            .stdout(Stdio::piped())
            .spawn()
            .expect("the tool runs");
        let (x, screen) = x11rb::connect(Some(&display.number)).expect("a connection");
        let root = x.setup().roots[screen].root;
        let window = eventually("the window", || {
            let children = x.query_tree(root).ok()?.reply().ok()?.children;
            children.into_iter().find(|&window| {
                let size = x.get_geometry(window).ok().and_then(|it| it.reply().ok());
                size.is_some_and(|it| (it.width, it.height) == SIZE)
            })
        });
        // Nobody else gives a window the keyboard here.
        let focus = x11rb::protocol::xproto::InputFocus::PARENT;
        eventually("the focus", || {
            x.set_input_focus(focus, window, x11rb::CURRENT_TIME).ok()?.check().ok()
        });
        Self { tool, x, window, folder }
    }

    /// Red, green and blue of what the window shows.
    fn shown(&self) -> Option<Vec<[u8; 3]>> {
        let (width, height) = SIZE;
        let (form, all) = (ImageFormat::Z_PIXMAP, !0);
        let image =
            self.x.get_image(form, self.window, 0, 0, width, height, all).ok()?.reply().ok()?;
        Some(image.data.chunks_exact(4).map(|bgr| [bgr[2], bgr[1], bgr[0]]).collect())
    }

    fn title(&self) -> Option<String> {
        let name = self.x.intern_atom(false, b"_NET_WM_NAME").ok()?.reply().ok()?.atom;
        let all = self.x.get_property(false, self.window, name, AtomEnum::ANY, 0, 1000).ok()?;
        String::from_utf8(all.reply().ok()?.value).ok()
    }

    /// Presses a key, given by the character on it.
    fn press(&self, key: char) {
        let setup = self.x.setup();
        let (low, high) = (setup.min_keycode, setup.max_keycode);
        let map = self.x.get_keyboard_mapping(low, high - low + 1).expect("asked");
        let map = map.reply().expect("a keyboard");
        let symbols = map.keysyms.chunks(map.keysyms_per_keycode.into());
        let place = symbols.into_iter().position(|it| it.first() == Some(&u32::from(key)));
        let code = low + u8::try_from(place.expect("a key")).expect("a code");
        for kind in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            let sent = self.x.xtest_fake_input(kind, code, 0, x11rb::NONE, 0, 0, 0);
            sent.expect("asked").check().expect("pressed");
        }
    }

    /// The picture that the tool draws to a file by the same options and more.
    fn drawn(&self, more: &[&str]) -> Vec<[u8; 3]> {
        let (width, height) = SIZE;
        let size = format!("{width}x{height}");
        let args = ["cube.obj", "-o", "drawn.png", "-q", "-b", "d8e2ea", "--size", &size];
        let args = [&args[..], more].concat();
        let done = Command::new(env!("CARGO_BIN_EXE_polyscan"))
            .args(args)
            .current_dir(self.folder.path())
            .status();
        assert!(done.expect("the tool runs").success());
        self.file("drawn.png").expect("a picture")
    }

    fn file(&self, name: &str) -> Option<Vec<[u8; 3]>> {
        let path: PathBuf = self.folder.path().join(name);
        let bytes = fs::read(path).ok()?;
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().ok()?;
        let mut pixels = vec![0; reader.output_buffer_size()?];
        reader.next_frame(&mut pixels).ok()?;
        Some(pixels.chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect())
    }

    /// Waits until the window shows a picture.
    fn wait_for(&self, what: &str, picture: &[[u8; 3]]) {
        eventually(what, || (self.shown()? == picture).then_some(()));
    }
}

/// Every picture of the window is the one that goes to a file, to the bit.
#[test]
fn the_window_shows_what_is_drawn_to_files() {
    let Some(display) = Display::open() else { return };
    let mut viewer = Viewer::open(&display);
    let plain = viewer.drawn(&["--samples", "1"]);
    viewer.wait_for("the first picture", &plain);
    let title = viewer.title().expect("a title");
    assert!(
        title.starts_with("cube.obj - 6 faces, 24 vertices - scanline, no textures, 1 sample"),
        "{title}"
    );

    viewer.press('a');
    viewer.wait_for("four samples a pixel", &viewer.drawn(&["--samples", "2"]));
    viewer.press('p');
    let saved = eventually("the saved picture", || viewer.file("cube.png"));
    assert_eq!(Some(saved), viewer.shown());
    for _ in 0..3 {
        viewer.press('a');
    }
    viewer.wait_for("one sample a pixel", &plain);
    viewer.press('w');
    viewer.wait_for("the wireframe", &viewer.drawn(&["--samples", "1", "--wireframe"]));
    viewer.press('w');
    viewer.wait_for("the picture without", &plain);
    // The painter's renderer has glass in the same order.
    viewer.press('r');
    eventually("the painter's renderer", || viewer.title()?.contains("painter's").then_some(()));
    let shown = viewer.shown().expect("a picture");
    let differ = shown.iter().zip(&plain).filter(|(a, b)| a != b).count();
    assert!(differ < shown.len() / 500, "{differ} pixels differ");

    viewer.press('q');
    let status = eventually("the end", || viewer.tool.try_wait().expect("a status"));
    assert!(status.success());
}

#[test]
fn a_turn_is_timed_and_ends() {
    let Some(display) = Display::open() else { return };
    let folder = folder();
    let args = ["view", "cube.obj", "--size", "200x100", "--frames", "12"];
    let output = command(&display, &folder, &args).output().expect("the tool runs");
    let said = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.starts_with("12 pictures of 200 x 100 pixels: "), "{said}");
}

#[test]
fn without_a_display_it_says_so() {
    let folder = folder();
    let output = Command::new(env!("CARGO_BIN_EXE_polyscan"))
        .args(["view", "cube.obj"])
        .current_dir(folder.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .expect("the tool runs");
    let said = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: cannot open a window: "), "{said}");
    assert!(said.contains("needs a display"), "{said}");
}
