//! Files as other programs write them: faults and oddities that cost no other reader the model.
//!
//! Each kind was met in public bug reports. The files here are written for the tests; the right values
//! are those of the format, or of what most readers do where it says nothing.

use std::fs;
use std::path::PathBuf;

use crate::common::dynamic;
use glam::{Vec2, Vec3, Vec4, vec2, vec3, vec4};
use polyscan::model::{AlphaMode, Model};
use polyscan::obj::{Loaded, Loader, ObjError, Warning};
use polyscan::render::Over;
use polyscan::tangent::TangentFrame;
use polyscan::{Framebuffer, Mesh, ScanlineRenderer, color, record};
use tempfile::TempDir;

/// A folder of files that vanishes with the test.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: impl AsRef<std::path::Path>) -> PathBuf {
        self.0.path().join(name)
    }

    fn with(self, name: impl AsRef<std::path::Path>, content: impl AsRef<[u8]>) -> Self {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("inside the folder")).expect("a folder");
        fs::write(path, content).expect("a file");
        self
    }

    /// A red picture of one texel, of the given alpha.
    fn with_picture(self, name: impl AsRef<std::path::Path>, alpha: u8) -> Self {
        let files = self.with(&name, "");
        let picture = Framebuffer::new(1, 1, [255_u8, 0, 0, alpha]).expect("a pixel");
        // The name may not end in what the writer wants.
        let plain = files.path("a picture to copy.png");
        picture.save_png(&plain).expect("a picture");
        fs::rename(plain, files.path(name)).expect("a picture");
        files
    }

    fn load(&self, name: &str) -> (Model, Vec<String>) {
        let Loaded { model, warnings } = Model::load(self.path(name)).expect("a model");
        (model, warnings.iter().map(ToString::to_string).collect())
    }
}

fn load(text: impl AsRef<[u8]>) -> (Model, Vec<String>) {
    Files::new().with("m.obj", text).load("m.obj")
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// A square with texture coordinates, of the material `a`.
const PICTURE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                       usemtl a\nf 1/1 2/2 3/3 4/4\n";

// What only the looks need never costs the model.

#[test]
fn references_to_nothing_are_computed_or_missing() {
    for (faces, kind) in [
        ("f 1//1 2//2 3//3", "normal"),
        ("f 1/7 2/8 3/9", "texture coordinate"),
        ("f 1/-1 2/-1 3/-1", "texture coordinate"),
        ("f 1//0 2//0 3//0", "normal"),
        ("f 1/x 2/y 3/z", "texture coordinate"),
    ] {
        let (model, warnings) = load(format!("{TRIANGLE}\n{faces}\nf 1 2 3\n"));
        assert_eq!(model.face_count(), 2);
        assert!(model.vertices.iter().all(|v| v.normal == Vec3::Z && v.uv == Vec2::ZERO));
        assert!(model.faces().all(|face| !face.has_uv));
        let said = format!(
            "m.obj:5: a face refers to a {kind} that is not in the file; the corner goes without (3 in the file)"
        );
        assert!(warnings.len() == 1 && warnings[0].ends_with(&said), "{faces}: {warnings:?}");
    }
}

/// As Cinema 4D writes them: some corners of a face have a normal.
#[test]
fn a_normal_that_is_there_is_kept() {
    let (model, warnings) = load(format!("{TRIANGLE}vn 1 0 0\nf 1//0 2//1 3//1\n"));
    let normals: Vec<Vec3> = model.vertices.iter().map(|v| v.normal).collect();
    assert_eq!(normals, [Vec3::Z, Vec3::X, Vec3::X]);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}

#[test]
fn numbers_that_are_none_cost_only_themselves() {
    for bad in ["nan nan", "-1.#IND00 0", "inf 0", "x y", "", "1,5 0", "1e99 0"] {
        let text = format!("{TRIANGLE}vt 0.25 0.5\nvt {bad}\nf 1/1 2/2 3/1\n");
        let (model, warnings) = load(text);
        let uvs: Vec<Vec2> = model.vertices.iter().map(|v| v.uv).collect();
        assert_eq!(uvs, [vec2(0.25, 0.5), Vec2::ZERO, vec2(0.25, 0.5)], "{bad}");
        assert!(warnings.len() == 1 && warnings[0].contains("m.obj:5: "), "{warnings:?}");
    }
    for bad in ["nan nan nan", "1 0", "0 1.#QNAN 0", "0 0 -inf"] {
        let (model, warnings) = load(format!("{TRIANGLE}vn {bad}\nf 1//1 2//1 3//1\n"));
        assert!(model.vertices.iter().all(|v| v.normal == Vec3::Z), "{bad}");
        assert!(warnings.len() == 1 && warnings[0].contains("it is computed"), "{warnings:?}");
    }
}

#[test]
fn a_wrong_position_matters_where_a_face_uses_it() {
    let (model, warnings) = load(format!("{TRIANGLE}v nan nan nan\nf 1 2 3\n"));
    assert_eq!(model.bounds(), Some((Vec3::ZERO, vec3(1.0, 1.0, 0.0))));
    assert!(warnings.len() == 1 && warnings[0].ends_with("no face uses the position"));
    let files = Files::new().with("m.obj", format!("{TRIANGLE}v 1 nan 2\nf 1 2 3\nf 1 2 4\n"));
    let error = Model::load(files.path("m.obj")).expect_err("a face needs it");
    assert!(matches!(error, ObjError::Line { line: 4, .. }), "{error}");
}

#[test]
fn faces_of_fewer_than_three_corners_are_left_out() {
    for short in ["f", "f 1", "f 1 7", "f 2/2 # 3"] {
        let (model, warnings) = load(format!("{TRIANGLE}f 1 2 3\n{short}\n{short}\n"));
        assert_eq!(model.face_count(), 1);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].contains("m.obj:5: a face needs at least 3 corners"), "{warnings:?}");
        assert!(warnings[0].ends_with("is skipped (2 in the file)"), "{warnings:?}");
    }
}

// Texts.

#[test]
fn utf_16_is_read_with_and_without_its_mark() {
    let text = format!("# ü\n{TRIANGLE}f 1 2 3\n");
    for mark in ["\u{feff}", ""] {
        let units: Vec<u16> = format!("{mark}{text}").encode_utf16().collect();
        let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        for bytes in [little, big] {
            let (model, warnings) = load(bytes);
            assert_eq!((model.face_count(), warnings.len()), (1, 0));
        }
    }
}

/// Two names of equal length in GBK, and in code page 1251.
#[test]
fn names_in_old_encodings_stay_apart() {
    for [first, second] in
        [[b"\xc7\xbd\xc3\xe6", b"\xb5\xd8\xb0\xe5"], [b"\xf1\xf2\xe5\xed", b"\xef\xee\xeb\xfb"]]
    {
        let mtl =
            [b"newmtl ", &first[..], b"\nKd 1 0 0\nnewmtl ", second, b"\nKd 0 0 1\n"].concat();
        let faces =
            [b"usemtl ", &first[..], b"\nf 1 2 3\nusemtl ", second, b"\nf 1 2 3\n"].concat();
        let obj = [b"mtllib m.mtl\n", TRIANGLE.as_bytes(), &faces].concat();
        let (model, warnings) = Files::new().with("m.obj", obj).with("m.mtl", mtl).load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        let colors: Vec<_> = model.faces().map(|f| model.materials[f.material].diffuse).collect();
        assert_eq!(colors, [Vec3::X, Vec3::Z]);
    }
}

/// The bytes lead to the file that has them for its name, and else to the one file whose ASCII
/// characters are the same.
#[cfg(unix)]
#[test]
fn names_in_old_encodings_lead_to_files() {
    use std::os::unix::ffi::OsStrExt as _;

    let name = b"\xc7\xbd\x95\x5c.png";
    let mtl = [b"newmtl a\nmap_Kd ", &name[..], b"\n"].concat();
    let obj = format!("mtllib m.mtl\n{PICTURE}");
    for file in [std::ffi::OsStr::from_bytes(name), "m\u{fc}\\.png".as_ref()] {
        let files = Files::new().with("m.obj", &obj).with("m.mtl", &mtl);
        let (model, warnings) = files.with_picture(file, 255).load("m.obj");
        let is_bytes = file.as_bytes() == name;
        assert_eq!(model.textures.len(), usize::from(is_bytes), "{warnings:?}");
    }
    let latin = b"newmtl a\nmap_Kd mosaic_gr\xf8nn.png\n";
    let files = Files::new().with("m.obj", obj).with("m.mtl", latin);
    let (model, warnings) = files.with_picture("mosaic_gr\u{f8}nn.png", 255).load("m.obj");
    assert_eq!((model.textures.len(), warnings.len()), (1, 0), "{warnings:?}");
}

#[test]
fn a_name_in_an_unknown_encoding_is_said_to_be_one() {
    let obj = [TRIANGLE.as_bytes(), b"usemtl \xb5\xd8\nf 1 2 3\n"].concat();
    let (_, warnings) = load(obj);
    assert!(warnings[0].contains("in an encoding that is not known"), "{warnings:?}");
}

#[test]
fn what_follows_a_name_may_be_a_comment() {
    for (obj, mtl) in [
        ("mtllib m.mtl # looks\nusemtl a # wall\n", "newmtl a\n"),
        ("mtllib m.mtl\nusemtl a\n", "newmtl a # wall\n"),
        ("mtllib m.mtl\t# looks\nusemtl a #1\n", "newmtl a\nKd 1 0 0\nnewmtl a #1\n"),
    ] {
        let files = Files::new().with("m.mtl", format!("{mtl}Kd 0 1 0\n"));
        let (model, warnings) =
            files.with("m.obj", format!("{obj}{TRIANGLE}f 1 2 3\n")).load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        let material = model.faces().next().expect("a face").material;
        assert_eq!(model.materials[material].diffuse, Vec3::Y, "{obj}");
    }
}

// Files that are found.

#[test]
fn materials_are_found_as_other_machines_name_them() {
    for (line, file, warned) in [
        ("mtllib Chair.MTL", "chair.mtl", 0),
        ("mtllib my\\ chair.mtl", "my chair.mtl", 0),
        ("mtllib my%20chair.mtl", "my chair.mtl", 0),
        ("mtllib \"my chair.mtl\"", "my chair.mtl", 0),
        ("mtllib my chair.mtl # x", "my chair.mtl", 0),
        ("mtllib C:\\art\\chair.mtl", "chair.mtl", 0),
        ("mtllib looks/chair.mtl", "chair.mtl", 0),
        ("mtllib my chair.mtl my chair.mtl", "my chair.mtl", 0),
        ("mtllib old.mtl", "m.mtl", 1),
        ("# none", "m.mtl", 0),
    ] {
        let files = Files::new().with(file, "newmtl a\nKd 0 1 0\n");
        let files = files.with("m.obj", format!("{line}\n{TRIANGLE}usemtl a\nf 1 2 3\n"));
        let (model, warnings) = files.load("m.obj");
        assert_eq!(model.materials[1..].len(), 1, "{line}: {warnings:?}");
        assert_eq!(model.faces_of(1).count(), 1, "{line}");
        assert_eq!(warnings.len(), warned, "{line}: {warnings:?}");
    }
}

#[test]
fn textures_are_found_as_other_machines_name_them() {
    for (line, file) in [
        ("map_Kd Textures\\Wood.PNG", "textures/wood.png"),
        ("map_Kd tex/wood.png", "wood.png"),
        ("map_Kd ../../tex/wood.png", "wood.png"),
        ("map_Ka wood.png", "wood.png"),
        ("map_Kd my%20wood.png", "my wood.png"),
        ("map_Kd wood.png # oak", "wood.png"),
        ("map_Kd -colorspace sRGB wood.png", "wood.png"),
        ("map_Kd wood.png -clamp on", "wood.png"),
        ("map_Kd -8.png", "-8.png"),
        ("map_Kd a -s 2.png", "a -s 2.png"),
    ] {
        let files = Files::new().with("m.mtl", format!("newmtl a\n{line}\n"));
        let files = files.with_picture(file, 255).with("m.obj", format!("mtllib m.mtl\n{PICTURE}"));
        let (model, warnings) = files.load("m.obj");
        assert!(warnings.is_empty(), "{line}: {warnings:?}");
        assert_eq!(model.materials[1].texture, Some(0), "{line}");
    }
}

/// Sketchfab's layout: the picture lies beside the model's folder.
#[test]
fn a_root_lets_names_lead_up_to_it() {
    let files = Files::new()
        .with("in/source/m.obj", format!("mtllib m.mtl\n{PICTURE}"))
        .with(
            "in/source/m.mtl",
            "newmtl a\nmap_Kd ../textures/wood.png\nnewmtl b\nmap_Kd ../../secret.png\n",
        )
        .with_picture("in/textures/wood.png", 255)
        .with_picture("secret.png", 255);
    let path = files.path("in/source/m.obj");
    let without = Model::load(&path).expect("a model");
    assert_eq!((without.model.textures.len(), without.warnings.len()), (0, 2));
    let with = Loader::new().with_root(files.path("in")).load(&path).expect("a model");
    assert_eq!(with.model.materials[1].texture, Some(0), "{:?}", with.warnings);
    assert_eq!((with.model.textures.len(), with.warnings.len()), (1, 1));
}

// Looks.

#[test]
fn a_black_colour_does_not_hide_its_picture() {
    let files = Files::new().with("m.mtl", "newmtl a\nKd 0 0 0\nmap_Kd t.png\n");
    let files = files.with_picture("t.png", 255).with("m.obj", format!("mtllib m.mtl\n{PICTURE}"));
    let Loaded { model, warnings } = Model::load(files.path("m.obj")).expect("a model");
    assert_eq!(model.color_at(1, &vec2(0.5, 0.5).into(), Vec4::ONE), vec4(1.0, 0.0, 0.0, 1.0));
    assert!(matches!(&warnings[..], [Warning::BlackTexture { .. }]), "{warnings:?}");
}

/// The picture that was to give the colour is missing: not black, but as without a colour.
#[test]
fn a_black_colour_without_its_picture_is_grey() {
    let files = Files::new().with("m.mtl", "newmtl a\nKd 0 0 0\nmap_Kd t.png\n");
    let (model, warnings) = files.with("m.obj", format!("mtllib m.mtl\n{PICTURE}")).load("m.obj");
    assert_eq!(model.materials[1].diffuse, model.materials[0].diffuse);
    assert!(warnings.len() == 1 && warnings[0].contains("without its texture"), "{warnings:?}");
}

/// As MeshLab writes materials that are opaque.
#[test]
fn a_transparency_of_one_alone_is_opaque() {
    let files = Files::new().with("m.mtl", "newmtl a\nKd 1 1 1\nTr 1.000000\n");
    let (model, warnings) =
        files.with("m.obj", format!("mtllib m.mtl\nusemtl a\n{TRIANGLE}f 1 2 3\n")).load("m.obj");
    assert_eq!((model.materials[1].alpha, model.has_transparency()), (1.0, false));
    assert!(warnings.len() == 1 && warnings[0].contains("Tr 1"), "{warnings:?}");
    let files = Files::new().with("m.mtl", "newmtl a\nd 0\n");
    let (model, warnings) =
        files.with("m.obj", format!("mtllib m.mtl\nusemtl a\n{TRIANGLE}f 1 2 3\n")).load("m.obj");
    assert_eq!(model.materials[1].alpha, 0.0);
    assert!(warnings.len() == 1 && warnings[0].contains("altogether"), "{warnings:?}");
}

#[test]
fn emitted_light_is_that_of_its_picture() {
    for (lines, expected) in [
        ("Ke 0.5 0.25 2\n", vec3(0.5, 0.25, 2.0)),
        ("Ke 0.5 0.25 2\nmap_Ke t.png\n", vec3(0.5, 0.0, 0.0)),
        ("map_Ke t.png\n", Vec3::X),
        // To the letter.
        ("Ke 0 0 0\nmap_Ke t.png\n", Vec3::ZERO),
        ("Kd 1 1 1\n", Vec3::ZERO),
    ] {
        let files = Files::new().with("m.mtl", format!("newmtl a\n{lines}"));
        let files = files.with_picture("t.png", 255);
        let (model, warnings) =
            files.with("m.obj", format!("mtllib m.mtl\n{PICTURE}")).load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        let material = &model.materials[1];
        assert_eq!(material.is_emissive(), expected != Vec3::ZERO, "{lines}");
        let light = material.emission_at(&model.textures, &vec2(0.5, 0.5).into());
        assert_eq!(light, expected, "{lines}");
    }
}

/// Saves a picture whose pixel (x, y) is given.
fn save(path: PathBuf, size: (u32, u32), pixel: impl Fn(u32, u32) -> [u8; 4]) {
    let mut picture = Framebuffer::new(size.0, size.1, [0_u8; 4]).expect("pixels");
    for (i, color) in (0..).zip(picture.color_mut()) {
        *color = pixel(i % size.0, i / size.0);
    }
    picture.save_png(path).expect("a picture");
}

/// The normal of the square of `PICTURE` at a point of its picture.
fn normal(model: &Model, uv: Vec2) -> Vec3 {
    let vertex = model.vertices[0];
    let frame = TangentFrame::new(vertex.normal, vertex.tangent);
    model.materials[1].normal_at(&model.textures, &uv.into(), &frame)
}

/// Normal maps are numbers, not sRGB; bumps are heights, or normals where they look like that.
#[test]
fn normals_are_bent_by_normal_maps_and_by_bumps() {
    // To the right, by 30 degrees; as sRGB it would be 0.51 and 0.87 for 0.75 and 0.93.
    let leaning = |_, _| [191, 128, 238, 255];
    let right = vec3(0.5, 0.0, 0.866);
    // A ramp of one code for each of 32 texels, in picture widths; white is as high as a 64th is wide.
    let ramp = |x: u32, _| [4 * x.min(31) as u8, 4 * x.min(31) as u8, 4 * x.min(31) as u8, 255];
    let slope = 4.0 / 255.0 * 32.0 / 64.0;
    for (lines, expected) in [
        ("norm n.png\n", right),
        ("map_Kn n.png\n", right),
        ("map_bump n.png\n", right),
        ("bump -bm 0.5 n.png\n", vec3(0.25, 0.0, 0.866).normalize()),
        // Turned over along u.
        ("norm -s -1 1 1 n.png\n", vec3(-0.5, 0.0, 0.866)),
        ("bump h.png\n", vec3(-slope, 0.0, 1.0).normalize()),
        ("map_Bump -bm 10 h.png\n", vec3(-10.0 * slope, 0.0, 1.0).normalize()),
        ("map_Bump -bm -3 -mm 0 2 h.png\n", vec3(6.0 * slope, 0.0, 1.0).normalize()),
        // That of normals comes first.
        ("bump h.png\nnorm n.png\n", right),
    ] {
        let files = Files::new().with("m.mtl", format!("newmtl a\n{lines}"));
        save(files.path("n.png"), (2, 2), leaning);
        save(files.path("h.png"), (32, 2), ramp);
        let (model, warnings) =
            files.with("m.obj", format!("mtllib m.mtl\n{PICTURE}")).load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(model.vertices[0].tangent, vec4(1.0, 0.0, 0.0, 1.0));
        let found = normal(&model, vec2(0.5, 0.5));
        assert!((found - expected).length() < 0.006, "{lines}: {found} {expected}");
    }
    // Without one there are no tangents, and the normal is the face's own.
    let (model, _) = Files::new().with("m.obj", PICTURE).load("m.obj");
    assert_eq!(model.vertices[0].tangent, Vec4::ZERO);
}

/// A face and its mirror image share an edge, but not its vertices.
#[test]
fn vertices_between_a_picture_and_its_mirror_image_are_doubled() {
    let sheet = "v -1 0 0\nv 0 0 0\nv 1 0 0\nv -1 1 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
                 vt 1 1\nvn 0 0 1\nusemtl a\nf 1/2/1 2/1/1 5/3/1 4/4/1\nf 2/1/1 3/2/1 6/4/1 5/3/1\n";
    for (lines, count) in [("norm n.png\n", 8), ("", 6)] {
        let files = Files::new().with("m.mtl", format!("newmtl a\n{lines}"));
        save(files.path("n.png"), (1, 1), |_, _| [191, 128, 238, 255]);
        let (model, _) = files.with("m.obj", format!("mtllib m.mtl\n{sheet}")).load("m.obj");
        assert_eq!(model.vertices.len(), count, "{lines}");
        if lines.is_empty() {
            continue;
        }
        for (face, sign) in model.faces().zip([-1.0, 1.0]) {
            for &index in face.indices {
                assert_eq!(model.vertices[index as usize].tangent, vec4(sign, 0.0, 0.0, sign));
            }
        }
    }
}

#[test]
fn highlights_and_heights_have_pictures() {
    let mtl = "newmtl a\nKs 0.5 0.5 0.5\nNs 20\nmap_Ks t.png\ndisp -mm 0.25 2 h.png\n";
    let files = Files::new().with("m.mtl", mtl).with_picture("t.png", 255);
    save(files.path("h.png"), (1, 1), |_, _| [51; 4]);
    let (model, warnings) = files.with("m.obj", format!("mtllib m.mtl\n{PICTURE}")).load("m.obj");
    assert!(warnings.is_empty(), "{warnings:?}");
    let (material, seen) = (&model.materials[1], vec2(0.5, 0.5).into());
    assert_eq!(material.specular_at(&model.textures, &seen), vec3(0.5, 0.0, 0.0));
    assert_eq!(material.shininess, 20.0);
    let height = material.displacement_at(&model.textures, &seen);
    assert!((height - 0.65).abs() < 1e-6, "{height}");
    // `-bm` multiplies the whole, and the other options say where the picture lies.
    let files = Files::new()
        .with("m.mtl", "newmtl a\ndisp -bm 2 -mm 0.25 2 -s 2 4 -o 0.5 0 -clamp on h.png\n");
    save(files.path("h.png"), (1, 1), |_, _| [51; 4]);
    let (model, _) = files.with("m.obj", format!("mtllib m.mtl\n{PICTURE}")).load("m.obj");
    let material = &model.materials[1];
    let height = material.displacement_at(&model.textures, &seen);
    assert!((height - 1.3).abs() < 1e-6, "{height}");
    let mapping = &material.displacement_mapping;
    assert_eq!((mapping.scale, mapping.offset), (vec2(2.0, 4.0), vec2(0.5, 0.0)));
    assert!(mapping.clamp);
    // The numbers alone are in every file, whether it means them or not.
    let files = Files::new().with("m.mtl", "newmtl a\nKs 0.5 0.5 0.5\nNs 20\n");
    let (model, _) = files.with("m.obj", format!("mtllib m.mtl\n{PICTURE}")).load("m.obj");
    assert_eq!(model.materials[1].specular, Vec3::ZERO);
}

#[test]
fn alpha_is_that_of_d_or_of_tr() {
    for (lines, alpha, mode) in [
        ("d 0.25\n", 0.25, AlphaMode::Blend),
        ("Tr 0.75\n", 0.25, AlphaMode::Blend),
        ("d -halo 0.25\n", 0.25, AlphaMode::Blend),
        ("d 1\nTr 0\n", 1.0, AlphaMode::Opaque),
        ("d 0.25\nTr 0.75\n", 0.25, AlphaMode::Blend),
        // Some programs write both alike.
        ("Tr 1\nd 1\n", 1.0, AlphaMode::Opaque),
        ("", 1.0, AlphaMode::Opaque),
    ] {
        let files = Files::new().with("m.mtl", format!("newmtl a\nKd 1 1 1\n{lines}"));
        let files = files.with("m.obj", format!("mtllib m.mtl\nusemtl a\n{TRIANGLE}f 1 2 3\n"));
        let (model, warnings) = files.load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        let material = &model.materials[1];
        assert_eq!((material.alpha, material.alpha_mode), (alpha, mode), "{lines}");
        assert_eq!(
            model.color_at(1, &Vec2::ZERO.into(), Vec4::ONE),
            Vec4::splat(alpha).with_w(alpha)
        );
    }
}

#[test]
fn pictures_cut_out_or_are_glass() {
    let half = color::decode(255);
    for (lines, alpha, mode) in [
        ("map_Kd t.png\n", 128, AlphaMode::Blend),
        ("map_Kd t.png\n", 255, AlphaMode::Opaque),
        ("map_Kd t.png\n", 0, AlphaMode::Cutout { threshold: 0.5 }),
        // Red of one texel, as a number: 255.
        ("map_d t.png\n", 255, AlphaMode::Opaque),
        ("map_d t.png\n", 128, AlphaMode::Blend),
    ] {
        let files = Files::new().with("m.mtl", format!("newmtl a\nKd 1 1 1\n{lines}"));
        let files =
            files.with_picture("t.png", alpha).with("m.obj", format!("mtllib m.mtl\n{PICTURE}"));
        let (model, warnings) = files.load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(model.materials[1].alpha_mode, mode, "{lines} {alpha}");
        let found = model.color_at(1, &vec2(0.5, 0.5).into(), Vec4::ONE);
        let expected = f32::from(alpha) / 255.0;
        assert!((found.w - expected).abs() < 1e-6, "{lines}: {found}");
        assert!((found.x - expected * half).abs() < 1e-6, "{lines}: {found}");
    }
}

/// 32 bits a texel, whose last 8 are zero: by the format there is no alpha if the descriptor says 0, and old
/// programs say 8 and mean the same.
#[cfg(feature = "image")]
#[test]
fn tga_files_without_any_alpha_are_opaque() {
    for descriptor in [0, 8] {
        let tga = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 32, descriptor, 0, 255, 0, 0];
        let files = Files::new().with("m.mtl", "newmtl a\nmap_Kd t.tga\n").with("t.tga", tga);
        let (model, warnings) =
            files.with("m.obj", format!("mtllib m.mtl\n{PICTURE}")).load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(model.materials[1].alpha_mode, AlphaMode::Opaque);
        let green = vec4(0.0, 1.0, 0.0, 1.0);
        assert_eq!(model.color_at(1, &vec2(0.5, 0.5).into(), Vec4::ONE), green, "{descriptor}");
    }
}

record! {
    struct Uv {
        uv: Vec2,
    }
}

/// A pane of glass in front of a red wall, whichever comes first in the file.
#[test]
fn glass_is_drawn_over_what_is_behind_it() {
    let mtl = "newmtl wall\nKd 1 0 0\nnewmtl glass\nKd 0 0 1\nd 0.25\n";
    let wall = "usemtl wall\nf 1 2 3 4\n";
    let glass = "usemtl glass\nf 5 6 7 8\n";
    let points = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    for faces in [[wall, glass].concat(), [glass, wall].concat()] {
        let files = Files::new().with("m.mtl", mtl);
        let (model, _) =
            files.with("m.obj", format!("mtllib m.mtl\n{points}{faces}")).load("m.obj");
        assert!(model.has_transparency());
        let list: Vec<_> = model.faces().collect();
        let camera = model.camera(1.0);
        let vertices = model.vertices_with(camera.clip_from_object(), |v| Uv { uv: v.uv });
        let is_transparent = |face| model.materials[list[face as usize].material].is_transparent();
        let mesh = Mesh::new(&vertices, &list).with_transparent(&is_transparent);
        let mut frame = Framebuffer::new(9, 9, Vec3::ZERO).expect("a frame");
        ScanlineRenderer::new(frame.viewport()).draw(&mut frame, mesh, |fragment| {
            let Uv { uv } = fragment.params.into();
            Over(model.color_at(list[fragment.face as usize].material, &uv.into(), Vec4::ONE))
        });
        assert_eq!(frame.color()[4 * 9 + 4], vec3(0.75, 0.0, 0.25));
    }
}

#[test]
fn options_of_maps_move_the_picture() {
    // A texel is red if u of its centre, in the picture, is below one half.
    for (options, uv, expected) in [
        ("", vec2(0.25, 0.25), vec2(0.25, 0.25)),
        ("-s 4 2 1", vec2(0.25, 0.75), vec2(1.0, 0.5)),
        ("-s 4", vec2(0.25, 0.75), vec2(1.0, 0.75)),
        // With v up: 1 - 0.75 + 0.5, and then down again.
        ("-o 0.5 0.5 0", vec2(0.25, 0.75), vec2(0.75, 0.25)),
        ("-s 2 2 -o 0.25", vec2(0.5, 0.5), vec2(1.25, 0.0)),
        ("-bm 0.3 -mm 0 1 -s 2 2 2", vec2(0.5, 1.0), vec2(1.0, 1.0)),
    ] {
        let files = Files::new().with("m.mtl", format!("newmtl a\nmap_Kd {options} t.png\n"));
        let files =
            files.with_picture("t.png", 255).with("m.obj", format!("mtllib m.mtl\n{PICTURE}"));
        let (model, warnings) = files.load("m.obj");
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(model.materials[1].mapping.uv(uv), expected, "{options}");
    }
    let files = Files::new().with("m.mtl", "newmtl a\nmap_Kd -clamp on -mm 0.25 0.5 t.png\n");
    let files = files.with_picture("t.png", 255).with("m.obj", format!("mtllib m.mtl\n{PICTURE}"));
    let (model, _) = files.load("m.obj");
    assert_eq!(model.textures[0].wraps().0, polyscan::texture::Wrap::Clamp);
    let color = model.color_at(1, &vec2(0.5, 0.5).into(), Vec4::ONE);
    assert_eq!(color, vec4(0.75, 0.25, 0.25, 1.0));
}

#[test]
fn vertices_have_colours() {
    for text in [
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n",
        "v 0 0 0 255 0 0\nv 1 0 0 0 255 0\nv 0 1 0 0 0 255\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB ffff0000ff00ff00ff0000ff\nf 1 2 3\n",
    ] {
        let (model, warnings) = load(text);
        assert!(warnings.is_empty(), "{warnings:?}");
        let colors: Vec<_> = model.vertices.iter().map(|v| v.color.truncate()).collect();
        assert_eq!(colors, [Vec3::X, Vec3::Y, Vec3::Z]);
        // White, so that the colours are seen as they are.
        assert_eq!(model.materials[0].diffuse, Vec3::ONE);
    }
    let (model, _) = load("v 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    // By the sRGB curve: ((0.5 + 0.055) / 1.055)^2.4.
    assert!((model.vertices[0].color.x - 0.214_041).abs() < 1e-4);
    assert_eq!(model.vertices[1].color, Vec4::ONE);
}

#[test]
fn the_file_says_what_is_smooth() {
    let bent = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 2\nv 2 1 2\n";
    let faces = "f 1 2 3 4\nf 2 5 6 3\n";
    // At 63 degrees, by angle, they are apart: 8 vertices; smooth they share two.
    for (before, count) in
        [("", 8), ("s 1\n", 6), ("s off\n", 8), ("s 0\n", 8), ("s 7\n", 6), ("s on\n", 6)]
    {
        let (model, warnings) = load(format!("{bent}{before}{faces}"));
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(model.vertices.len(), count, "{before}");
    }
    let flat = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0.1\nv 2 1 0.1\n";
    for (smoothing, count) in [(["", ""], 6), (["s off\n", ""], 8), (["s 1\n", "s 2\n"], 8)] {
        let text = format!("{flat}{}f 1 2 3 4\n{}f 2 5 6 3\n", smoothing[0], smoothing[1]);
        assert_eq!(load(text).0.vertices.len(), count, "{smoothing:?}");
    }
}

/// Some faces are turned over: the normals of the others are what they would be without.
#[test]
fn faces_turned_over_do_not_make_creases() {
    let points = "v 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\n";
    let right = ["f 1 2 3\n", "f 1 3 4\n", "f 1 4 5\n", "f 1 5 2\n"];
    let (model, _) = load(format!("{points}s 1\n{}", right.concat()));
    let top = |model: &Model, face: usize| {
        let face = model.faces().nth(face).expect("a face");
        let tip = |&&i: &&u32| model.vertices[i as usize].position == Vec3::Z;
        model.vertices[*face.indices.iter().find(tip).expect("the tip") as usize].normal
    };
    assert!((top(&model, 0) - Vec3::Z).length() < 1e-6);
    let turned = ["f 1 2 3\n", "f 1 4 3\n", "f 1 4 5\n", "f 1 2 5\n"];
    let (model, _) = load(format!("{points}s 1\n{}", turned.concat()));
    for (face, sign) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
        let normal = top(&model, face);
        assert!((normal - Vec3::Z * sign).length() < 1e-6, "{face}: {normal}");
    }
}

// Coordinates.

#[test]
fn a_model_far_away_keeps_its_shape() {
    let near = "v 0 0 0\nv 0.25 0 0\nv 0.25 4 0\nv 0 4 0\nv 10 4 8.5\nf 1 2 3 4\nf 3 4 5\n";
    let shift = glam::dvec3(12_958_095.125, 43.25, -4_865_499.5);
    let far: String = near
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            ["v", x, y, z] => {
                let [x, y, z] = [x, y, z].map(|n| n.parse::<f64>().expect("a number"));
                format!("v {} {} {}\n", x + shift.x, y + shift.y, z + shift.z)
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let ((near, _), (far, warnings)) = (load(near), load(far));
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(near.origin, glam::DVec3::ZERO);
    assert!(far.origin != glam::DVec3::ZERO);
    for (a, b) in near.vertices.iter().zip(&far.vertices) {
        assert_eq!(a.position.as_dvec3() + shift, b.position.as_dvec3() + far.origin);
        assert_eq!(a.normal, b.normal);
    }
}

#[test]
fn huge_and_tiny_models_are_seen() {
    for scale in ["e30", "e37", "e-30", "e-37"] {
        let text =
            format!("v 0 0 0\nv 1{scale} 0 0\nv 1{scale} 1{scale} 0\nv 0 1{scale} 0\nf 1 2 3 4\n");
        let (model, _) = load(text);
        let camera = model.camera(1.0);
        let vertices = model.vertices_with(camera.clip_from_object(), |v| Uv { uv: v.uv });
        let mut frame = Framebuffer::new(20, 20, 0_u8).expect("a frame");
        let faces: Vec<_> = model.faces().collect();
        polyscan::ZBufferRenderer::new(frame.viewport()).draw(
            &mut frame,
            Mesh::new(&vertices, &faces),
            dynamic(|_| 1),
        );
        // A square inside the circle that fills the picture: 2 / pi of the circle.
        let seen = frame.color().iter().filter(|&&seen| seen == 1).count();
        assert!((185..=215).contains(&seen), "{scale}: {seen}");
    }
}

/// One warning for each kind of thing, with the first line and the number.
#[test]
fn what_is_not_used_is_said_once() {
    let mtl = "newmtl a\nmap_Ns s.png\nrefl b.png\nKe 0 0 0\nnewmtl b\nrefl n.png\nKe 1 0 0\n";
    let files = Files::new().with("m.mtl", mtl);
    let obj =
        format!("mtllib m.mtl\n{TRIANGLE}usemtl a\nl 1 2\nf 1 2 3\np 1\nl 2 3\nvp 1\nfoo\nbar\n");
    let (_, warnings) = files.with("m.obj", obj).load("m.obj");
    let ends: Vec<_> = warnings.iter().map(|text| text.rsplit('/').next().expect("text")).collect();
    assert_eq!(
        ends,
        [
            "m.obj:6: lines (l) are not used (2 in the file)",
            "m.obj:8: points (p) are not used",
            "m.obj:10: curves and curved surfaces are not used",
            "m.obj:11: statements that no OBJ file has, such as `foo`, are not used (2 in the file)",
            "m.mtl:2: pictures of exponents of highlights (map_Ns) are not used",
            "m.mtl:3: pictures of reflections (refl) are not used (2 in the file)",
        ]
    );
}
