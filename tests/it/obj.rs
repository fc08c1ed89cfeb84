//! OBJ and MTL files: what is read, what is passed over, and what is said about files that are
//! wrong.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_3, PI};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3, vec2, vec3};
use polyscan::Framebuffer;
use polyscan::model::{Material, Model};
use polyscan::obj::{LineError, Loaded, Loader, ObjError, Warning};
use tempfile::TempDir;

/// A folder of files that vanishes with the test.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("inside the folder")).expect("a folder");
        fs::write(path, content).expect("a file");
        self
    }

    /// A picture of one texel.
    fn with_picture(self, name: &str) -> Self {
        let files = self.with(name, "");
        let picture = Framebuffer::new(1, 1, [255_u8, 0, 0]).expect("a pixel");
        picture.save_png(files.path(name)).expect("a picture");
        files
    }

    fn load(&self, name: &str) -> Result<Loaded, ObjError> {
        Model::load(self.path(name))
    }
}

fn try_load(text: impl AsRef<[u8]>) -> Result<Loaded, ObjError> {
    Files::new().with("model.obj", text).load("model.obj")
}

fn load(text: impl AsRef<[u8]>) -> Model {
    let loaded = try_load(text).expect("a model");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.model
}

/// The model of a text, and its warnings as text.
fn load_with_warnings(text: impl AsRef<[u8]>) -> (Model, Vec<String>) {
    let Loaded { model, warnings } = try_load(text).expect("a model");
    (model, warnings.iter().map(ToString::to_string).collect())
}

/// The model of a text with an MTL file beside it, and its warnings as text.
fn load_with_mtl(mtl: &str) -> (Model, Vec<String>) {
    let files = Files::new()
        .with("model.obj", format!("mtllib model.mtl\nusemtl red\n{TRIANGLE}f 1 2 3\n"))
        .with("model.mtl", mtl)
        .with_picture("a picture.png")
        .with_picture("maps/b.png");
    let Loaded { model, warnings } = files.load("model.obj").expect("a model");
    (model, warnings.iter().map(ToString::to_string).collect())
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The corners of each face: positions.
fn positions(model: &Model) -> Vec<Vec<Vec3>> {
    let position = |&i: &u32| model.vertices[i as usize].position;
    model.faces().map(|face| face.indices.iter().map(position).collect()).collect()
}

/// What is wrong with the text, and on which line.
fn line_error(text: impl AsRef<[u8]>) -> (usize, LineError) {
    match try_load(text) {
        Err(ObjError::Line { line, cause, .. }) => (line, cause),
        other => panic!("no line is named: {other:?}"),
    }
}

// What is read.

#[test]
fn faces_keep_their_sides() {
    let model = load(format!("{SQUARE}v 0.5 2 0\nf 1 2 3\nf 1 2 3 4\nf 1 2 3 5 4\n"));
    let sides: Vec<_> = model.faces().map(|face| face.indices.len()).collect();
    assert_eq!(sides, [3, 4, 5]);
    assert_eq!(model.face_count(), 3);
    assert_eq!(model.bounds(), Some((Vec3::ZERO, vec3(1.0, 2.0, 0.0))));
    assert_eq!(model.vertices.len(), 5);
}

#[test]
fn triangles_alone_are_faces_too() {
    let model = load(format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
    assert_eq!(model.faces().map(|face| face.indices.len()).collect::<Vec<_>>(), [3, 3]);
    assert_eq!(model.vertices.len(), 4);
}

#[test]
fn indices_count_from_the_end_as_well() {
    let absolute = load(format!("{SQUARE}f 1 2 3 4\n"));
    let relative = load(format!("{SQUARE}f -4 -3 -2 -1\n"));
    let midway = load("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1 4\nv 0 1 0\nf 1 2 -1\n");
    assert_eq!(positions(&relative), positions(&absolute));
    assert_eq!(positions(&midway)[0], positions(&absolute)[0]);
    assert_eq!(positions(&midway)[1][2], vec3(0.0, 1.0, 0.0));
}

#[test]
fn v_is_turned_down() {
    let model = load(format!("{TRIANGLE}vt 0 0\nvt 1 0.25\nvt 0 1\nf 1/1 2/2 3/3\n"));
    let uvs: Vec<Vec2> = model.vertices.iter().map(|vertex| vertex.uv).collect();
    assert_eq!(uvs, [vec2(0.0, 1.0), vec2(1.0, 0.75), vec2(0.0, 0.0)]);
    assert!(model.faces().all(|face| face.has_uv));
}

#[test]
fn texture_coordinates_of_one_or_three_numbers_are_read() {
    let model = load(format!("{TRIANGLE}vt 0.5\nvt 0.25 0.75 9\nf 1/1 2/2 3/2\n"));
    assert_eq!(model.vertices[0].uv, vec2(0.5, 1.0));
    assert_eq!(model.vertices[1].uv, vec2(0.25, 0.25));
}

#[test]
fn normals_are_normalised_and_zero_ones_computed() {
    let model = load(format!("{TRIANGLE}vn 3 0 4\nvn 0 0 0\nvn 1e38 0 0\nf 1//1 2//2 3//3\n"));
    let normals: Vec<Vec3> = model.vertices.iter().map(|vertex| vertex.normal).collect();
    assert_eq!(normals, [vec3(0.6, 0.0, 0.8), Vec3::Z, Vec3::X]);
    assert!(model.faces().all(|face| !face.has_uv));
    assert_eq!(model.vertices[0].uv, Vec2::ZERO);
}

#[test]
fn faces_with_and_without_texture_coordinates_mix() {
    let text = format!(
        "{SQUARE}vt 0.5 0.25\nvn 1 0 0\n\
         f 1 2 3\nf 1/1 2/1 3/1\nf 1 2 4\nf 1/1/1 2/1/1 4/1/1\nf 1//1 3//1 4//1\nf 1/1 2 3\n"
    );
    let model = load(text);
    let has_uv: Vec<bool> = model.faces().map(|face| face.has_uv).collect();
    assert_eq!(has_uv, [false, true, false, true, false, false]);
    for (number, face) in model.faces().enumerate() {
        for (corner, &index) in face.indices.iter().enumerate() {
            let vertex = model.vertices[index as usize];
            let given = face.has_uv || (number, corner) == (5, 0);
            assert_eq!(vertex.uv, if given { vec2(0.5, 0.75) } else { Vec2::ZERO });
            let normal = if [3, 4].contains(&number) { Vec3::X } else { Vec3::Z };
            assert_eq!(vertex.normal, normal, "face {number}");
        }
    }
}

#[test]
fn corners_that_differ_are_different_vertices() {
    let model =
        load(format!("{SQUARE}vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1\nf 1/2 3/2 4/2\n"));
    // Four with the first texture coordinate, three with the second.
    assert_eq!(model.vertices.len(), 7);
}

#[test]
fn repeated_positions_are_one_vertex() {
    let model = load("v 0 0 0\nv 1 0 0\nv 1 1 0\nv -0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n");
    assert_eq!(model.vertices.len(), 4);
}

#[test]
fn a_face_may_stand_above_its_vertices() {
    assert_eq!(load(format!("f 1 2 3\n{TRIANGLE}")).face_count(), 1);
}

#[test]
fn points_and_lines_are_no_faces() {
    let text = format!("{TRIANGLE}l 1 2 3\nl 1 2\np 1 2 3\nf 1 2 3\nl 1 2 3 1\n");
    let (model, warnings) = load_with_warnings(text);
    assert_eq!(model.face_count(), 1);
    // One warning a kind.
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].ends_with("model.obj:4: lines (l) are not used (3 in the file)"));
    assert!(warnings[1].ends_with("model.obj:6: points (p) are not used"), "{warnings:?}");
}

#[test]
fn the_text_may_be_laid_out_in_many_ways() {
    let expected = positions(&load(format!("{SQUARE}f 1 2 3 4\n")));
    for text in [
        format!("{SQUARE}f 1 2 3 4"),
        format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r\n"),
        format!("{SQUARE}f 1 2 3 4\n").replace(' ', "\t"),
        format!("\u{feff}{SQUARE}f 1 2 3 4\n"),
        format!("# folder C:\\models\\\n{SQUARE}\n   f  1  2 3 4  # the floor\n"),
        format!("{SQUARE}f 1 2 \\\n3 \\\r\n  4\n"),
        format!("{SQUARE}f 1 2 3 4\\"),
        format!("o box\ns off\ng a b\n{SQUARE}f 1 2 3 4\n"),
        format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r"),
        format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r\r\n"),
        format!("g C:\\models\\\n{SQUARE}o a\\\ns 1\\\nf 1 2 3 4\n"),
    ] {
        assert_eq!(positions(&load(&text)), expected, "{text:?}");
    }
}

#[test]
fn names_in_old_encodings_are_read() {
    let model = load([b"# caf\xe9\no \xfc\n", format!("{TRIANGLE}f 1 2 3\n").as_bytes()].concat());
    assert_eq!(model.face_count(), 1);
}

// Materials and textures.

#[test]
fn faces_are_gathered_by_material() {
    let files = Files::new()
        .with(
            "model.obj",
            format!(
                "mtllib model.mtl\n{SQUARE}f 1 2 3\nusemtl blue\nf 2 3 4\nusemtl red sand\nf 1 2 4\n\
                 usemtl blue\nf 1 3 4\nf 1 2 3 4\n"
            ),
        )
        .with("model.mtl", "newmtl red sand\nKd 1 0 0\nnewmtl green\nnewmtl blue\nKd 0 0 1\n");
    let Loaded { model, warnings } = files.load("model.obj").expect("a model");
    assert!(warnings.is_empty(), "{warnings:?}");

    let names: Vec<_> = model.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["default", "red sand", "green", "blue"]);
    assert_eq!(model.materials[1].diffuse, Vec3::X);
    assert_eq!(model.materials[2].diffuse, Material::default().diffuse);
    let counts: Vec<_> = (0..6).map(|material| model.faces_of(material).count()).collect();
    assert_eq!(counts, [1, 1, 0, 3, 0, 0]);
    assert!(model.faces_of(3).all(|face| face.material == 3));
    assert_eq!(model.faces_of(3).last().map(|face| face.indices.len()), Some(4));
    let order: Vec<_> = model.faces().map(|face| face.material).collect();
    assert_eq!(order, [0, 1, 3, 3, 3]);
}

#[test]
fn smoothing_goes_on_across_materials() {
    let files = Files::new().with("a.mtl", "newmtl a\nnewmtl b\n").with(
        "model.obj",
        format!(
            "mtllib a.mtl\n{SQUARE}v 2 0 1\nv 2 1 1\nusemtl a\nf 1 2 3 4\nusemtl b\nf 2 5 6 3\n"
        ),
    );
    let model = files.load("model.obj").expect("a model").model;
    // The two share the edge from (1, 0, 0) to (1, 1, 0), at 45 degrees.
    assert_eq!(model.vertices.len(), 6);
}

#[test]
fn a_grey_kd_has_one_number() {
    let (model, warnings) = load_with_mtl("newmtl red\nKd 0.25\nNs 1\nKa 1\nillum x\nd\n");
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(model.materials[1].diffuse, Vec3::splat(0.25));
}

#[test]
fn texture_names_have_spaces_options_and_backslashes() {
    for (line, count) in [
        ("map_Kd a picture.png", 1),
        ("map_Kd   a picture.png  ", 1),
        ("map_Kd\ta picture.png", 1),
        ("map_Kd \"a picture.png\"", 1),
        ("map_Kd \" a picture.png \"", 1),
        ("map_Kd ./ a picture.png", 1),
        ("map_Kd -s 1 1 1 a picture.png", 1),
        ("map_Kd -s 2 a picture.png", 1),
        ("map_Kd -bm 0.3 -o 0.5 0.5 -clamp on a picture.png", 1),
        ("map_Kd -mm 0 1 -blendu off -imfchan r a picture.png", 1),
        ("map_Kd maps\\b.png", 1),
        ("map_Kd .\\maps\\b.png", 1),
        ("map_Kd maps/../maps//b.png", 1),
        ("map_kd maps/b.png", 1),
        // A name that leads out of the folder is looked for in it.
        ("map_Kd C:\\Users\\me\\a picture.png", 1),
        ("map_Kd /usr/share/a picture.png", 1),
        ("map_Kd ../../elsewhere/a picture.png", 1),
    ] {
        let (model, warnings) = load_with_mtl(&format!("newmtl red\n{line}\n"));
        assert!(warnings.is_empty(), "{line}: {warnings:?}");
        assert_eq!(model.textures.len(), count, "{line}");
        assert_eq!(model.materials[1].texture, Some(0), "{line}");
        assert_eq!(model.materials[1].diffuse, Vec3::ONE, "{line}");
        assert_eq!(model.textures[0].texel(0, 0).truncate(), Vec3::X, "{line}");
    }
}

#[test]
fn materials_share_a_texture_of_the_same_file() {
    let (model, warnings) = load_with_mtl(
        "newmtl red\nKd 0.5 0.5 0.5\nmap_Kd maps/b.png\nnewmtl x\nmap_Kd a picture.png\n\
         newmtl y\nmap_Kd maps\\b.png\n",
    );
    assert!(warnings.is_empty(), "{warnings:?}");
    let textures: Vec<_> = model.materials.iter().map(|material| material.texture).collect();
    assert_eq!(textures, [None, Some(0), Some(1), Some(0)]);
    assert_eq!(model.textures.len(), 2);
    assert_eq!(model.materials[1].diffuse, Vec3::splat(0.5));
}

#[test]
fn textures_lie_beside_their_material_file() {
    let files = Files::new()
        .with("model.obj", format!("mtllib looks/my mats.mtl\nusemtl a\n{TRIANGLE}f 1 2 3\n"))
        .with_picture("looks/a.png");
    let path = files.path("looks/my mats.mtl");
    for name in ["a.png", "\"a.png\"", "..\\looks\\a.png", "/looks/../a.png"] {
        fs::write(&path, format!("newmtl a\nmap_Kd {name}\n")).expect("a file");
        let loaded = files.load("model.obj").expect("a model");
        assert_eq!(loaded.model.textures.len(), 1, "{name}: {:?}", loaded.warnings);
        assert_eq!(loaded.warnings.len(), 0, "{name}: {:?}", loaded.warnings);
    }
}

#[test]
fn one_line_may_name_many_material_files() {
    let files = Files::new()
        .with("model.obj", format!("mtllib a.mtl b.mtl\n{TRIANGLE}usemtl b\nf 1 2 3\n"))
        .with("a.mtl", "newmtl a\n")
        .with("b.mtl", "newmtl b\n");
    let loaded = files.load("model.obj").expect("a model");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(loaded.model.faces_of(2).count(), 1);
}

#[test]
fn looks_that_are_missing_are_warned_of() {
    let says = |mtl: &str, parts: &[&str]| {
        let (model, warnings) = load_with_mtl(mtl);
        assert_eq!(model.face_count(), 1);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        for part in parts {
            assert!(warnings[0].contains(part), "`{part}` is not in: {}", warnings[0]);
        }
        model
    };
    says("newmtl red\nKd 1 0\n", &["model.mtl:2", "a colour needs 3 numbers", "here are 2"]);
    says("newmtl red\n\nKd 1 x 0\n", &["model.mtl:3", "`x`", "not a number"]);
    says("newmtl red\nKd 1 inf 0\n", &["model.mtl:2", "`inf`", "not finite"]);
    says("newmtl red\nKd spectral file.rfl 1\n", &["model.mtl:2", "`spectral`"]);
    says("newmtl red\nKd\n", &["model.mtl:2", "here are 0"]);
    says("newmtl red\nmap_Kd -clamp on\n", &["model.mtl:2", "`map_Kd` needs a name"]);
    says("newmtl red\nmap_Kd ..\n", &["model.mtl:2", "`map_Kd` needs a name"]);
    for nothing in ["\"", "\"\"", "/", "C:", "C:..", "C:\\..", "..\\..", "./."] {
        let line = format!("newmtl red\nmap_Kd {nothing}\n");
        says(&line, &["model.mtl:2", "`map_Kd` needs a name"]);
    }
    says("newmtl\nnewmtl red\n", &["model.mtl:1", "`newmtl` needs a name"]);
    says("newmtl green\n", &["model.obj:2", "no material file defines `red`"]);

    let model = says("newmtl red\nmap_Kd no.png\n", &["`red`", "no.png", "No such file"]);
    assert_eq!(model.materials[1].texture, None);
    assert_eq!(model.materials[1].diffuse, Material::default().diffuse);
    says("newmtl red\nmap_Kd model.mtl\nnewmtl b\nmap_Kd model.mtl\n", &["model.mtl", "decode"]);
    says("newmtl red\nmap_Kd maps\n", &["maps", "not a regular file"]);
}

#[test]
fn a_missing_material_file_is_warned_of() {
    let files = Files::new()
        .with("model.obj", format!("mtllib no such.mtl\nusemtl a\n{TRIANGLE}f 1 2 3\n"));
    let Loaded { model, warnings } = files.load("model.obj").expect("a model");
    assert_eq!(model.faces_of(0).count(), 1);
    assert!(matches!(warnings[0], Warning::MaterialFile { .. }), "{warnings:?}");
    assert!(matches!(&warnings[1], Warning::UnknownMaterial { line: 2, .. }), "{warnings:?}");
    // Once for the line, not for each of its words.
    assert!(warnings[0].to_string().contains("no such.mtl"), "{warnings:?}");
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}

#[test]
fn nothing_outside_the_folder_is_opened() {
    let files = Files::new()
        .with_picture("secret.png")
        .with("secret.mtl", "newmtl a\n")
        .with("in/model.obj", format!("mtllib ../secret.mtl m.mtl\nusemtl a\n{TRIANGLE}f 1 2 3\n"));
    let absolute = files.path("secret.png");
    let mtl = format!("newmtl a\nmap_Kd {}\nnewmtl b\nmap_Kd ../secret.png\n", absolute.display());
    let loaded = files.with("in/m.mtl", mtl).load("in/model.obj").expect("a model");
    assert!(loaded.model.textures.is_empty());
    // The library, and the picture once, for both names lead to the same place in the folder.
    assert_eq!(loaded.warnings.len(), 2, "{:?}", loaded.warnings);
    assert!(loaded.warnings.iter().all(|warning| {
        let text = warning.to_string();
        text.contains(&Path::new("in").join("secret").display().to_string())
    }));
}

#[test]
fn too_many_warnings_are_counted() {
    let (_, warnings) = load_with_mtl(&format!("newmtl red\n{}", "Kd x\n".repeat(250)));
    assert_eq!(warnings.len(), 101);
    assert_eq!(warnings[100], "150 more warnings");
}

// Errors.

#[test]
fn a_missing_file_is_named() {
    let error = Files::new().load("nowhere.obj").expect_err("no file");
    assert!(matches!(error, ObjError::Read { .. }));
    let text = error.to_string();
    assert!(text.contains("nowhere.obj") && text.contains("No such file"), "{text}");
}

#[test]
fn a_folder_is_no_file() {
    let error = Model::load(Files::new().0.path()).expect_err("a folder");
    assert!(error.to_string().contains("not a regular file"), "{error}");
}

#[test]
fn a_file_without_faces_is_named() {
    for text in ["", "# nothing\n", TRIANGLE, "\0\u{1}\u{2}", "<html>\n<body>\n", "l 1 2\n"] {
        let error = try_load(text).expect_err("nothing to draw");
        assert!(matches!(error, ObjError::NoFaces { .. }), "{error}");
        assert!(error.to_string().contains("model.obj has no faces"), "{error}");
    }
}

/// What explains the lack of faces is said with it.
#[test]
fn a_file_without_faces_keeps_its_warnings() {
    let error = try_load(format!("{TRIANGLE}l 1 2\nf 1 2\nl 2 3\n")).expect_err("no face");
    let text = error.to_string();
    assert!(text.contains("is it an OBJ file of polygons? Also: "), "{text}");
    assert!(text.contains("model.obj:4: lines (l) are not used (2 in the file); "), "{text}");
    assert!(
        text.contains("model.obj:5: a face needs at least 3 corners, and here are 2"),
        "{text}"
    );
    let ObjError::NoFaces { warnings, .. } = error else { panic!("{error}") };
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}

#[test]
fn errors_name_file_line_and_cause() {
    for (text, expected) in [
        (
            format!("{TRIANGLE}f 1 2 9\n"),
            "model.obj:4: a face refers to position 9, but there are only 3 in the file",
        ),
        (
            format!("{TRIANGLE}\n# x\nf 1 2 -4\n"),
            "model.obj:6: a face refers to position -4, but there are only 3 above the line",
        ),
        (
            format!("{TRIANGLE}f 1 2 0\n"),
            "model.obj:4: `0` has the index 0: the first position is 1, and the one just above the line is -1",
        ),
        (
            "v 0 0 0\nv 0 nan 0\nf 1 2 1\n".to_owned(),
            "model.obj:2: `nan` in a position is not finite: use numbers up to 3.4e38",
        ),
        (
            "v 0 0 1e39\nf 1 1 1\n".to_owned(),
            "model.obj:1: `1e39` in a position is not finite: use numbers up to 3.4e38",
        ),
        (
            "v 0 0,5 0\nf 1 1 1\n".to_owned(),
            "model.obj:1: `0,5` in a position is not a number: write it like 0.5 or 1e-3",
        ),
        ("v 0 0\nf 1 1 1\n".to_owned(), "model.obj:1: a position needs 3 numbers, and here are 2"),
        (
            format!("{TRIANGLE}f 1 2 3.0\n"),
            "model.obj:4: `3.0` is no face corner: write v, v/vt, v//vn or v/vt/vn with whole numbers",
        ),
    ] {
        let error = try_load(&text).expect_err(expected).to_string();
        assert!(error.ends_with(expected), "{error}\ninstead of\n{expected}");
    }
}

#[test]
fn no_index_overflows() {
    for corner in [
        "9223372036854775807",
        "-9223372036854775808",
        "18446744073709551615",
        "18446744073709551616",
        "4294967297",
        "-4294967295",
        "/1",
        "//",
        "-",
    ] {
        let (line, _) = line_error(format!("{TRIANGLE}f 1 2 {corner}\n"));
        assert_eq!(line, 4, "{corner}");
    }
    for corner in ["3/9223372036854775807", "3//-9223372036854775808", "3/-", "3/4294967297"] {
        let (model, warnings) = load_with_warnings(format!("{TRIANGLE}f 1 2 {corner}\n"));
        assert_eq!((model.face_count(), warnings.len()), (1, 1), "{corner}: {warnings:?}");
    }
}

#[test]
fn long_words_are_shortened_in_messages() {
    let (_, cause) = line_error(format!("v {}\u{1b}[31m 0 0\nf 1 1 1\n", "x".repeat(100_000)));
    assert!(cause.to_string().len() < 200 && !cause.to_string().contains('\u{1b}'), "{cause}");
}

#[test]
fn broken_text_never_panics() {
    // Every piece of a file that uses everything, cut off anywhere, and with a byte changed.
    let whole = format!(
        "mtllib model.mtl\n{SQUARE}vt 0 0\nvt 1 1\nvn 0 0 1\nusemtl red\nf 1/1/1 2/2/1 -1/-1/-1\n\
         f 1//1 \\\n 2//1 3//1 4//1\nl 1 2\n"
    );
    let mtl = "newmtl red\nKd 1 0.5 0\nmap_Kd -s 1 1 1 a\\b.png\n";
    let files = Files::new().with("model.mtl", mtl);
    let path = files.path("model.obj");
    for cut in 0..whole.len() {
        for byte in [None, Some(b'-'), Some(b'/'), Some(b'9'), Some(b'\n'), Some(0xff)] {
            let mut text = whole.clone().into_bytes();
            match byte {
                Some(byte) => text[cut] = byte,
                None => text.truncate(cut),
            }
            fs::write(&path, text).expect("a file");
            if let Ok(loaded) = Model::load(&path) {
                let count = loaded.model.vertices.len();
                assert!(
                    loaded.model.faces().flat_map(|f| f.indices).all(|&i| (i as usize) < count)
                );
            }
        }
    }
    fs::write(&path, &whole).expect("a file");
    for cut in 0..mtl.len() {
        for end in [&b""[..], b"\\", b"\n-", b"\0", b"\xff\n"] {
            let text = [&mtl.as_bytes()[..cut], end].concat();
            fs::write(files.path("model.mtl"), text).expect("a file");
            assert_eq!(Model::load(&path).expect("a model").model.face_count(), 2);
        }
    }
}

// Normals.

/// The eight corners of the unit cube, and six squares, counter-clockwise seen from outside.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn cube(crease_angle: f32) -> Model {
    let files = Files::new().with("cube.obj", CUBE);
    let loader = Loader::new().with_crease_angle(crease_angle);
    loader.load(files.path("cube.obj")).expect("a cube").model
}

#[test]
fn below_its_angle_an_edge_is_sharp() {
    for angle in [0.0, FRAC_PI_3, FRAC_PI_2 - 0.01, -1.0, f32::NAN] {
        let model = cube(angle);
        assert_eq!(model.vertices.len(), 24);
        for face in model.faces() {
            let corners = || face.indices.iter().map(|&i| model.vertices[i as usize]);
            let centre = corners().map(|corner| corner.position).sum::<Vec3>() / 4.0;
            // Exactly along an axis, and outwards.
            assert!(corners().all(|corner| corner.normal == (centre - 0.5) * 2.0));
        }
    }
}

#[test]
fn from_its_angle_on_an_edge_is_smooth() {
    for angle in [FRAC_PI_2, FRAC_PI_2 + 0.01, PI, f32::INFINITY] {
        let model = cube(angle);
        assert_eq!(model.vertices.len(), 8);
        for vertex in &model.vertices {
            let outwards = (vertex.position - 0.5).normalize();
            assert!((vertex.normal - outwards).length() < 1e-6, "{vertex:?}");
        }
    }
}

/// A sphere of quads with triangles at the poles, in `f32` text.
fn sphere(columns: usize, rows: usize) -> String {
    let mut text = "v 0 0 1\nv 0 0 -1\n".to_owned();
    for row in 1..rows {
        let polar = std::f64::consts::PI * row as f64 / rows as f64;
        for column in 0..columns {
            let turn = std::f64::consts::TAU * column as f64 / columns as f64;
            let (ring, z) = (polar.sin(), polar.cos());
            writeln!(text, "v {} {} {z}", ring * turn.cos(), ring * turn.sin()).expect("a string");
        }
    }
    let at = |row: usize, column: usize| 3 + (row - 1) * columns + column % columns;
    for c in 0..columns {
        writeln!(text, "f 1 {} {}", at(1, c), at(1, c + 1)).expect("a string");
        writeln!(text, "f 2 {} {}", at(rows - 1, c + 1), at(rows - 1, c)).expect("a string");
        for r in 1..rows - 1 {
            let (here, next) = ((at(r, c), at(r, c + 1)), (at(r + 1, c), at(r + 1, c + 1)));
            writeln!(text, "f {} {} {} {}", here.0, next.0, next.1, here.1).expect("a string");
        }
    }
    text
}

#[test]
fn a_sphere_is_smooth() {
    // The second has so many faces at its poles that they are gathered by direction.
    for (columns, rows) in [(48, 24), (200, 40)] {
        let model = load(sphere(columns, rows));
        assert_eq!(model.vertices.len(), 2 + columns * (rows - 1));
        for vertex in &model.vertices {
            let angle = vertex.normal.angle_between(vertex.position.normalize());
            assert!(angle < 0.003, "{} degrees at {vertex:?}", angle.to_degrees());
        }
    }
}

#[test]
fn cutting_faces_into_triangles_does_not_move_normals() {
    let triangles = CUBE
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            ["f", a, b, c, d] => format!("f {a} {b} {c}\nf {a} {c} {d}\n"),
            _ => format!("{line}\n"),
        })
        .collect::<String>();
    let files = Files::new().with("cube.obj", triangles);
    let loaded = Loader::new().with_crease_angle(PI).load(files.path("cube.obj"));
    let model = loaded.expect("a cube").model;
    assert_eq!(model.vertices.len(), 8);
    for vertex in &model.vertices {
        let outwards = (vertex.position - 0.5).normalize();
        assert!((vertex.normal - outwards).length() < 1e-4, "{vertex:?}");
    }
}

#[test]
fn scale_and_place_do_not_matter() {
    for (scale, place) in [(1e-20, 0.0), (1e30, 0.0), (1.0, 4e6), (1e-38, 0.0)] {
        let v = |x: f32, y: f32| format!("v {} {} {place}\n", place + x * scale, place + y * scale);
        let text = [v(0.0, 0.0), v(1.0, 0.0), v(1.0, 1.0), v(0.0, 1.0)].concat();
        let model = load(format!("{text}f 1 2 3 4\n"));
        assert!(model.vertices.iter().all(|vertex| vertex.normal == Vec3::Z), "{scale} {place}");
    }
}

#[test]
fn faces_without_area_get_some_normal() {
    let model = load(format!("{TRIANGLE}f 1 1 1\nf 1 2 2\nf 1 2 1 2\n"));
    assert!(model.vertices.iter().all(|vertex| vertex.normal == Vec3::Z));
    // Beside a face that has one, that one.
    let model = load("v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 1 2\nf 1 2 3\n");
    assert!(model.vertices.iter().all(|vertex| vertex.normal == Vec3::X), "{model:?}");
}

#[test]
fn a_point_of_very_many_faces_takes_little_time() {
    let count = 100_000;
    let mut text = String::from("v 0 0 0.5\n");
    for i in 0..count {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        writeln!(text, "v {} {} 0", turn.cos(), turn.sin()).expect("a string");
    }
    for i in 0..count {
        writeln!(text, "f 1 {} {}", 2 + i, 2 + (i + 1) % count).expect("a string");
    }
    // One face that is at its only point 100,000 times.
    writeln!(text, "f{}", " 1".repeat(100_000)).expect("a string");
    let start = Instant::now();
    let model = load(&text);
    // Pair by pair it would be 10^10 steps: minutes.
    assert!(start.elapsed() < Duration::from_secs(30), "{:?}", start.elapsed());
    assert_eq!(model.face_count(), 100_001);
    // The cone's sides are 63 degrees from its axis: those at the tip within 60 degrees of a side
    // are around it, so that its own normal leads.
    assert!(model.vertices.iter().all(|vertex| vertex.normal.z > 0.0));
}

#[test]
fn a_cylinder_of_six_sides_is_smooth_by_default() {
    let mut text = String::new();
    for i in 0..6 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 6.0).sin_cos();
        writeln!(text, "v {cos} {sin} 0\nv {cos} {sin} 1").expect("a string");
    }
    for i in 0..6 {
        let (here, next) = (2 * i, 2 * ((i + 1) % 6));
        writeln!(text, "f {} {} {} {}", here + 1, next + 1, next + 2, here + 2).expect("a string");
    }
    let model = load(text + "f 2 4 6 8 10 12\nf 11 9 7 5 3 1\n");
    // 12 around, and 12 on the lids, which are at 90 degrees.
    assert_eq!(model.vertices.len(), 24);
    let around = model.vertices.iter().filter(|vertex| vertex.normal.z == 0.0);
    for vertex in around {
        let outwards = vec3(vertex.position.x, vertex.position.y, 0.0);
        assert!((vertex.normal - outwards).length() < 1e-6, "{vertex:?}");
    }
}
