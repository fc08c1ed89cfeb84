//! The tool as people run it: exit codes, what it says, what it writes, and what it leaves behind.

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        folder.write("cube.obj", cube().as_bytes());
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).expect("a file");
    }

    fn run(&self, args: &[&str]) -> Output {
        let tool = env!("CARGO_BIN_EXE_polyscan");
        Command::new(tool).current_dir(self.0.path()).args(args).output().expect("the tool runs")
    }

    /// Runs it; it succeeds and says nothing but what is expected.
    fn draw(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let said = String::from_utf8(output.stderr).expect("text");
        assert!(output.status.success() && said.is_empty(), "{args:?}: {said}");
        String::from_utf8(output.stdout).expect("text")
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("a folder");
        let name = |entry: fs::DirEntry| entry.file_name().into_string().expect("text");
        let mut names: Vec<String> = entries.flatten().map(name).collect();
        names.sort();
        names
    }

    fn picture(&self, name: &str) -> Picture {
        decode(&fs::read(self.path(name)).expect("a picture"))
    }
}

struct Picture {
    size: (u32, u32),
    channels: usize,
    bytes: Vec<u8>,
    frames: u32,
}

impl Picture {
    fn at(&self, x: u32, y: u32) -> &[u8] {
        let start = (y * self.size.0 + x) as usize * self.channels;
        &self.bytes[start..start + self.channels]
    }
}

fn decode(bytes: &[u8]) -> Picture {
    let mut reader =
        png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG file");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let frame = reader.next_frame(&mut pixels).expect("pixels");
    let frames = reader.info().animation_control().map_or(1, |control| control.num_frames);
    let channels = frame.line_size / frame.width as usize;
    Picture { size: (frame.width, frame.height), channels, bytes: pixels, frames }
}

/// The unit cube: faces 1 to 6 are back, front, below, right, above, left.
fn cube() -> String {
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
     f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
        .into()
}

#[test]
fn a_model_becomes_a_picture() {
    let folder = Folder::new();
    let said = folder.draw(&["cube.obj", "-o", "a.png", "-s", "64x48"]);
    assert!(said.starts_with("wrote a.png: 6 faces, 64 x 48 pixels"), "{said}");
    assert_eq!(folder.names(), ["a.png", "cube.obj"]);
    let picture = folder.picture("a.png");
    assert_eq!((picture.size, picture.channels), ((64, 48), 4));
    // Transparent at the corner, opaque grey in the middle.
    assert_eq!(picture.at(0, 0)[3], 0);
    let middle = picture.at(32, 24);
    assert!(middle[3] == 255 && middle[0] == middle[1] && middle[0] > 60, "{middle:?}");
    folder.draw(&["cube.obj", "-o", "b.png", "-s", "64x48", "-b", "ffcc00"]);
    assert_eq!(folder.picture("b.png").at(0, 0), [255, 204, 0, 255]);
}

#[test]
fn ids_depth_and_normals_are_numbers() {
    let folder = Folder::new();
    let front = ["cube.obj", "-s", "33", "--yaw", "0", "--pitch", "0", "-o", "a.png"];
    let args = |more: &[&'static str]| [&front[..], more].concat();
    folder.draw(&args(&["--ids"]));
    let picture = folder.picture("a.png");
    assert_eq!((picture.at(16, 16), picture.at(0, 0)), (&[2, 0, 0][..], &[0, 0, 0][..]));
    // Seen from the right, and from above with z up.
    folder.draw(&["cube.obj", "-s", "33", "--yaw", "90", "--pitch", "0", "-o", "a.png", "--ids"]);
    assert_eq!(folder.picture("a.png").at(16, 16), [4, 0, 0]);
    folder.draw(&args(&["--ids", "--up", "z"]));
    assert_eq!(folder.picture("a.png").at(16, 16), [3, 0, 0]);
    folder.draw(&args(&["--normals"]));
    assert_eq!(folder.picture("a.png").at(16, 16), [128, 128, 255]);

    // The front is 1 nearer than the back; both are flat.
    let said = folder.draw(&args(&["--depth", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    let picture = folder.picture("a.png");
    assert_eq!((picture.at(16, 16), picture.at(0, 0)), (&[0, 1][..], &[0, 0][..]));
    assert_eq!(json["faces"], 6);
    assert_eq!(json["bounds"], serde_json::json!([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]));
}

/// The camera of OpenCV at (0.5, 0.5, 3), looking at the front of the cube: a corner of the front, at
/// distance 2 and 0.5 to the side, is at cx + fx / 4 = 32 + 16 pixels.
#[test]
fn opencv_cameras_see_what_opencv_says() {
    let folder = Folder::new();
    let pose = "1,0,0,-0.5, 0,-1,0,0.5, 0,0,-1,3";
    let args = ["cube.obj", "-s", "64", "--ids", "-o", "a.png", "--intrinsics", "64,64,31.5,31.5"];
    folder.draw(&[&args[..], &["--pose", pose]].concat());
    let picture = folder.picture("a.png");
    let row: Vec<u8> = (0..64).map(|x| picture.at(x, 32)[0]).collect();
    let first = row.iter().position(|&id| id == 2).expect("the front");
    let count = row.iter().filter(|&&id| id == 2).count();
    assert_eq!((first, count), (16, 32));
    // The same by a matrix: w = 3 - z, x and y so that 0.5 at distance 2 is half of the way.
    let matrix = "2 0 0 -1  0 2 0 -1  0 0 -1.1 2.2  0 0 -1 3";
    folder.draw(&["cube.obj", "-s", "64", "--ids", "-o", "b.png", "--matrix", matrix]);
    let other = folder.picture("b.png");
    assert_eq!(other.bytes, picture.bytes);
}

#[test]
fn sheets_and_turntables_are_made() {
    let folder = Folder::new();
    folder.draw(&["cube.obj", "-o", "a.png", "-s", "32", "--views", "6", "--ids"]);
    let sheet = folder.picture("a.png");
    assert_eq!(sheet.size, (96, 64));
    let middles: Vec<u8> = (0..6).map(|i| sheet.at(i % 3 * 32 + 16, i / 3 * 32 + 16)[0]).collect();
    // Front, right, back, left, above, below.
    assert_eq!(middles, [2, 4, 1, 6, 5, 3]);
    folder.draw(&["cube.obj", "-o", "b.png", "-s", "32", "--turntable", "5"]);
    assert_eq!(folder.picture("b.png").frames, 5);
}

/// The front of the cube, head-on: it has lines where it ends, and none across it.
#[test]
fn lines_are_dark() {
    let folder = Folder::new();
    let front = ["cube.obj", "-s", "65", "--yaw", "0", "--pitch", "0", "-o", "a.png"];
    folder.draw(&[&front[..], &["--ids"]].concat());
    let ids = folder.picture("a.png");
    let is_front = |x: &u32| ids.at(*x, 32)[0] == 2;
    let ends = [(0..65).find(is_front), (0..65).rev().find(is_front)].map(|x| x.expect("a face"));
    folder.draw(&front);
    let plain = folder.picture("a.png");
    for options in [&["--wireframe"][..], &["--edges"], &["--wireframe", "--edges"]] {
        folder.draw(&[&front[..], options].concat());
        let lines = folder.picture("a.png");
        for x in 0..65_u32 {
            let distance = ends.map(|end| x.abs_diff(end)).into_iter().min().expect("two");
            let (line, without) = (lines.at(x, 32), plain.at(x, 32));
            match distance {
                // Half of the line is on the face, or nearly.
                0 => assert!(line[3] == 255 && line[0] < without[0] / 2 + 40, "{options:?} {x}"),
                1 | 2 => {}
                _ => assert_eq!(line, without, "{options:?} {x}"),
            }
        }
    }
}

/// A drum of glass and a hole cut into a wall: what is behind glass is hidden as behind a wall, what is behind the
/// hole is not.
#[test]
fn lines_are_seen_through_holes() {
    let folder = Folder::new();
    let wall = "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 0.4 0.2 0\nv 0.6 0.2 0\nv 0.6 0.8 0\nv 0.4 0.8 0\n\
                vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 5 6 7 8\nusemtl wall\nf 1/1 2/2 3/3 4/4\n";
    folder.write("wall.obj", format!("mtllib m.mtl\n{wall}").as_bytes());
    let args =
        ["wall.obj", "-s", "65", "--yaw", "0", "--pitch", "0", "--edges", "-q", "-o", "a.png"];
    let dark = |mtl: &str| {
        folder.write("m.mtl", format!("newmtl wall\nKd 1 1 1\n{mtl}\n").as_bytes());
        folder.draw(&args);
        let picture = folder.picture("a.png");
        // The row through the middle, without the wall's own edges.
        (20..45).filter(|&x| picture.at(x, 32)[3] == 255 && picture.at(x, 32)[0] < 120).count()
    };
    let hole = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 255, 255, 0]));
    hole.save(folder.path("hole.png")).expect("a picture");
    assert_eq!((dark("d 1"), dark("d 0.5")), (0, 0));
    assert!(dark("map_Kd hole.png") >= 2);
}

/// A ball of which every third face is turned over looks as one of which none is.
#[test]
fn faces_turned_over_are_lit_alike() {
    let folder = Folder::new();
    let (rows, columns) = (9, 14);
    let mut points = String::new();
    for row in 0..=rows {
        for column in 0..columns {
            let (polar, around) = (
                std::f64::consts::PI * (0.04 + 0.92 * f64::from(row) / f64::from(rows)),
                std::f64::consts::TAU * f64::from(column) / f64::from(columns),
            );
            let (x, z) = (polar.sin() * around.cos(), polar.sin() * around.sin());
            points += &format!("v {x:.5} {:.5} {z:.5}\n", polar.cos());
        }
    }
    let ball = |turned: i32| {
        let mut text = points.clone();
        for face in 0..rows * columns {
            let (row, column) = (face / columns, face % columns);
            let at = |row: i32, column: i32| 1 + row * columns + column % columns;
            let corners = [
                at(row, column),
                at(row, column + 1),
                at(row + 1, column + 1),
                at(row + 1, column),
            ];
            let [a, b, c, d] = corners;
            text += &match face % 3 {
                0 if turned > 0 => format!("f {d} {c} {b} {a}\n"),
                _ => format!("f {a} {b} {c} {d}\n"),
            };
        }
        text
    };
    folder.write("right.obj", ball(0).as_bytes());
    folder.write("turned.obj", ball(1).as_bytes());
    folder.draw(&["right.obj", "turned.obj", "-s", "90", "-q", "-o", "out"]);
    let [right, turned] = ["out/right.png", "out/turned.png"].map(|name| folder.picture(name));
    let lit = right.bytes.chunks_exact(4).filter(|pixel| pixel[3] == 255 && pixel[0] > 40).count();
    assert!(lit > 3000, "{lit}");
    for (place, (a, b)) in right.bytes.iter().zip(&turned.bytes).enumerate() {
        assert!(a.abs_diff(*b) <= 2, "{place}: {a} {b}");
    }
}

/// Four squares: red, green, blue and yellow.
#[test]
fn textures_come_in_many_formats() {
    let folder = Folder::new();
    let colors = [[200, 0, 0], [0, 200, 0], [0, 0, 200], [200, 200, 0]];
    let picture =
        image::RgbImage::from_fn(32, 32, |x, y| image::Rgb(colors[(y / 16 * 2 + x / 16) as usize]));
    folder.write(
        "square.obj",
        b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\n\
          f 1/1 2/2 3/3 4/4\n",
    );
    for ending in ["png", "jpg", "tga", "bmp", "ppm", "tif", "webp"] {
        picture.save(folder.path(&format!("t.{ending}"))).expect("a picture");
        folder.write("m.mtl", format!("newmtl a\nmap_Kd t.{ending}\n").as_bytes());
        folder.draw(&["square.obj", "-s", "64", "--yaw", "0", "--pitch", "0", "-q", "-o", "a.png"]);
        let drawn = folder.picture("a.png");
        for (color, (x, y)) in colors.iter().zip([(26, 26), (37, 26), (26, 37), (37, 37)]) {
            let lit = drawn.at(x, y);
            // Lit, and by JPEG not quite the same.
            let is_seen = |i: usize| (color[i] > 0) == (lit[i] > 100);
            assert!(lit[3] == 255 && (0..3).all(is_seen), "{ending}: {color:?} {lit:?}");
        }
    }
}

/// A picture drawn row by row is that drawn at once.
#[test]
fn large_pictures_are_streamed() {
    let folder = Folder::new();
    folder.draw(&["cube.obj", "-s", "9000x1000", "--samples", "3", "-o", "a.png"]);
    folder.draw(&["cube.obj", "-s", "9000x800", "--samples", "3", "-o", "b.png"]);
    let (streamed, whole) = (folder.picture("a.png"), folder.picture("b.png"));
    assert_eq!((streamed.size, whole.size), ((9000, 1000), (9000, 800)));
    let covered = |picture: &Picture| {
        let count = picture.bytes.chunks_exact(4).filter(|pixel| pixel[3] > 127).count();
        count as f64 / f64::from(picture.size.1).powi(2)
    };
    assert!((covered(&streamed) - covered(&whole)).abs() < 2e-3);
}

/// The rows of all shards, one below the other, are those of the whole.
#[test]
fn shards_join_to_the_whole_picture() {
    let folder = Folder::new();
    let glass = format!("mtllib m.mtl\n{}", cube().replace("f 1 2 6 5", "usemtl g\nf 1 2 6 5"));
    folder.write("glass.obj", glass.as_bytes());
    folder.write("m.mtl", b"newmtl g\nKd 1 0 0\nd 0.5\n");
    for args in [
        &["cube.obj", "-s", "60x41"][..],
        &["glass.obj", "-s", "60x41", "--samples", "2", "-b", "ffcc00"],
        &["cube.obj", "-s", "60x41", "--ids"],
        &["glass.obj", "-s", "60x41", "--normals", "--yaw", "70"],
        &["glass.obj", "-s", "60x41", "--wireframe"],
        // Larger than what is drawn at once.
        &["glass.obj", "-s", "9000x940", "--samples", "3"],
        &["cube.obj", "-s", "9000x940", "--samples", "3", "--edges"],
    ] {
        folder.draw(&[args, &["-q", "-o", "whole.png"]].concat());
        let whole = folder.picture("whole.png");
        let (mut joined, mut height) = (Vec::new(), 0);
        for shard in ["1/3", "2/3", "3/3"] {
            folder.draw(&[args, &["-q", "-o", "part.png", "--shard", shard]].concat());
            let part = folder.picture("part.png");
            assert_eq!(part.size.0, whole.size.0);
            height += part.size.1;
            joined.extend(part.bytes);
        }
        assert_eq!(height, whole.size.1, "{args:?}");
        assert!(joined == whole.bytes, "{args:?}");
    }
}

#[test]
fn shards_of_many_models_have_each_once() {
    let folder = Folder::new();
    for name in ["a.obj", "b.obj", "c.obj", "d.obj"] {
        folder.write(name, cube().as_bytes());
    }
    let args = ["a.obj", "b.obj", "c.obj", "d.obj", "cube.obj", "-s", "8", "-q", "-o"];
    let count = |name: &str| fs::read_dir(folder.path(name)).expect("a folder").count();
    folder.draw(&[&args[..], &["one", "--shard", "1/2"]].concat());
    folder.draw(&[&args[..], &["two", "--shard", "2/2"]].concat());
    assert_eq!((count("one"), count("two")), (3, 2));
    // Both in one folder: no name is taken twice.
    folder.draw(&[&args[..], &["one", "--shard", "2/2"]].concat());
    assert_eq!(count("one"), 5);
    // More shards than models: nothing to do is no fault.
    folder.draw(&[&args[..], &["none", "--shard", "8/9"]].concat());
    assert_eq!(count("none"), 0);
}

#[test]
fn turntables_are_gif_files_by_their_names() {
    let folder = Folder::new();
    folder.draw(&["cube.obj", "-o", "a.gif", "-s", "32", "--turntable", "5", "-b", "ff0000"]);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let file = fs::File::open(folder.path("a.gif")).expect("a picture");
    let mut decoder = options.read_info(file).expect("a GIF file");
    let mut frames = 0;
    while let Some(frame) = decoder.read_next_frame().expect("a picture") {
        assert_eq!((frame.width, frame.height, frame.delay), (32, 32, 80));
        // The background nearly as it is.
        let [r, g, b, a] = [0, 1, 2, 3].map(|i| frame.buffer[i]);
        assert!(r > 245 && g < 10 && b < 10 && a == 255, "{r} {g} {b} {a}");
        frames += 1;
    }
    assert_eq!(frames, 5);
}

#[test]
fn streams_go_in_and_out() {
    let folder = Folder::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_polyscan"))
        .args(["-", "-o", "-", "-s", "20"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the tool runs");
    child.stdin.take().expect("a pipe").write_all(cube().as_bytes()).expect("written");
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success());
    folder.draw(&["cube.obj", "-o", "a.png", "-s", "20"]);
    assert_eq!(output.stdout, fs::read(folder.path("a.png")).expect("a picture"));
}

#[test]
fn many_models_become_pictures_in_a_folder() {
    let folder = Folder::new();
    fs::create_dir(folder.path("in")).expect("a folder");
    for name in ["in/a.obj", "in/b.OBJ"] {
        folder.write(name, cube().as_bytes());
    }
    folder.write("in/c.obj", b"v 0 0 0\nf 1 2 9\n");
    folder.write("in/notes.txt", b"no model");
    let output = folder.run(&["in", "-o", "out", "-s", "16"]);
    // One bad file does not stop the rest, and the exit code says so.
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).expect("text");
    assert_eq!(
        said.trim_end(),
        "error: in/c.obj:2: a face refers to position 2, but there are only 1 in the file"
    );
    let lines = String::from_utf8(output.stdout).expect("text");
    assert_eq!(lines.lines().filter(|line| line.starts_with("wrote out/")).count(), 2, "{lines}");
    let mut names: Vec<_> = fs::read_dir(folder.path("out"))
        .expect("a folder")
        .flatten()
        .map(|e| e.file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["a.png", "b.png"]);
}

#[test]
fn errors_are_sentences_and_leave_nothing() {
    let folder = Folder::new();
    folder.write("bad.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    folder.write("empty.stl", b"");
    folder.write("what.bin", b"\0\x01\x02");
    fs::create_dir(folder.path("nothing")).expect("a folder");
    folder.write("lines.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n");
    let before = folder.names();
    for (args, code, says) in [
        (
            &["bad.obj", "-o", "a.png"][..],
            1,
            "bad.obj:4: a face refers to position 9, but there are only 3 in the file",
        ),
        (&["no.obj", "-o", "a.png"], 1, "cannot read the model no.obj"),
        (&["empty.stl", "-o", "a.png"], 1, "empty.stl: it is neither STL text"),
        (
            &["lines.obj", "-o", "a.png"],
            1,
            "is it an OBJ file of polygons? Also: lines.obj:3: lines (l) are not used",
        ),
        (&["what.bin", "-o", "a.png"], 1, "what.bin is in no format that is known"),
        (&["cube.obj", "-o", "a.webp"], 2, "cannot write a.webp: choose a name that ends in .png"),
        (&["cube.obj", "-o", "a.gif"], 2, "GIF files are for --turntable"),
        (
            &["cube.obj", "-o", "a.gif", "-s", "65536x1", "--samples", "1", "--turntable", "2"],
            2,
            "at most 65535 pixels a side",
        ),
        (&["nothing", "-o", "out"], 2, "there are no models in the folder"),
        (&["cube.obj", "cube.obj", "cube.obj", "-o", "out"], 2, "two models would become one"),
        (&["cube.obj", "-o", "a.png", "--shard", "3/2"], 2, "write it as 1/8, up to 8/8"),
        (&["cube.obj", "-o", "a.png", "--shard", "0/2"], 2, "write it as 1/8, up to 8/8"),
        (&["cube.obj", "-o", "a.png", "-s", "4", "--shard", "1/9"], 2, "at most so many shards"),
        (&["cube.obj", "-o", "a.png", "--depth", "--shard", "1/2"], 2, "without --shard"),
        (&["cube.obj", "-o", "a"], 2, "choose a name that ends in .png"),
        (&["cube.obj", "-o", "no/a.png"], 2, "there is no folder no"),
        (&["cube.obj"], 2, "say where the picture goes"),
        (&["cube.obj", "-o", "a.png", "-s", "0"], 2, "write it as 800x600 or 256"),
        (&["cube.obj", "-o", "a.png", "-s", "70000"], 2, "from 1 to 65536"),
        (&["cube.obj", "-o", "a.png", "-s", "65536"], 2, "choose fewer --samples"),
        (&["cube.obj", "-o", "a.png", "--yaw", "nan"], 2, "give a number of degrees"),
        (&["cube.obj", "-o", "a.png", "-b", "red"], 2, "six digits such as ffcc00"),
        (&["cube.obj", "-o", "a.png", "--up", "w"], 2, "name an axis"),
        (
            &["cube.obj", "-o", "a.png", "--matrix", "1 2 3"],
            2,
            "it needs 16 numbers, and here are 3",
        ),
        (&["cube.obj", "-o", "a.png", "--ids", "--depth"], 2, "cannot be used with"),
    ] {
        let output = folder.run(args);
        let said = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
        assert!(said.starts_with("error: ") && said.contains(says), "{args:?}: {said}");
        assert!(!said.contains("{ ") && output.stdout.is_empty(), "{said}");
        assert_eq!(folder.names(), before, "{args:?}");
    }
}

/// File managers ask for names without an ending.
#[cfg(unix)]
#[test]
fn file_managers_get_thumbnails() {
    let folder = Folder::new();
    let entry = include_str!("../data/polyscan.thumbnailer");
    let line = entry.lines().find_map(|line| line.strip_prefix("Exec=")).expect("a command");
    let line = line.replace("%i", "'cube.obj'").replace("%s", "32").replace("%o", "'.thumb'");
    let tool = PathBuf::from(env!("CARGO_BIN_EXE_polyscan"));
    let tools = tool.parent().expect("a folder").to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([tools].into_iter().chain(std::env::split_paths(&path)));
    let done = Command::new("sh")
        .args(["-c", &line])
        .current_dir(folder.0.path())
        .env("PATH", path.expect("paths"))
        .status();
    assert!(done.expect("a shell").success());
    assert_eq!(folder.picture(".thumb").size, (32, 32));
}

#[test]
fn it_says_what_it_can_do() {
    let folder = Folder::new();
    assert!(folder.draw(&["--help"]).contains("polyscan model.glb -o picture.png"));
    let page = folder.draw(&["--man"]);
    assert!(page.contains(".TH polyscan") && page.contains(".SH \"POLYSCAN VIEW\""), "{page}");
    assert!(page.contains("\\-\\-frames") && !page.contains("polyscan\\-view(1)"), "{page}");
    assert!(folder.draw(&["--completions", "bash"]).contains("_polyscan()"));
    for shell in ["zsh", "fish", "powershell", "elvish"] {
        assert!(folder.draw(&["--completions", shell]).contains("turntable"), "{shell}");
    }
    assert!(folder.draw(&["view", "--help"]).contains("Keys: R next renderer"));
}

/// Without the feature the command is there, and says what it needs.
#[cfg(not(feature = "view"))]
#[test]
fn a_build_without_windows_says_so() {
    let folder = Folder::new();
    let output = folder.run(&["view", "cube.obj"]);
    let said = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(2));
    assert!(said.starts_with("error: ") && said.contains("--features view"), "{said}");
}
