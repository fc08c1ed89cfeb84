//! STL, PLY and glTF files: the same square in each, what other programs write, and bytes of all sorts.

use std::path::Path;

use glam::{Vec3, vec3};
use polyscan::formats::{Format, LoadError, Loaded, Loader};

use crate::common::generators::Rng;

fn read(bytes: impl AsRef<[u8]>, name: &str) -> Result<Loaded, LoadError> {
    Loader::new().read(bytes.as_ref(), name)
}

/// The positions of each face's corners.
fn positions(loaded: &Loaded) -> Vec<Vec<Vec3>> {
    let model = &loaded.model;
    let position = |&i: &u32| model.vertices[i as usize].position;
    model.faces().map(|face| face.indices.iter().map(position).collect()).collect()
}

/// The halves of a square.
const HALVES: [[Vec3; 3]; 2] =
    [[Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0)], [Vec3::ZERO, vec3(1.0, 1.0, 0.0), Vec3::Y]];

fn binary_stl(header: &[u8], triangles: &[[Vec3; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        let vectors = [&[Vec3::NAN][..], triangle].concat();
        bytes.extend(vectors.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl(triangles: &[[Vec3; 3]]) -> String {
    let mut text = String::from("solid square\n");
    for triangle in triangles {
        text += "facet normal 0 0 1\n outer loop\n";
        for v in triangle {
            text += &format!("  vertex {} {} {}\n", v.x, v.y, v.z);
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid square\n"
}

/// A glTF file of a square with texture coordinates, its buffer within.
fn gltf(material: &str, node: &str) -> String {
    let floats = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0_f32];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|n| n.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3_u8]);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{node}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
        "materials":[{material}],
        "buffers":[{{"byteLength":54,"uri":"data:application/octet-stream;base64,{}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":6}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"}}]}}"#,
        base64(&bytes)
    )
}

/// Base64 (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |three: &[u8]| {
        let all = three.iter().fold(0_u32, |all, &byte| all << 8 | u32::from(byte));
        let all = all << (8 * (3 - three.len()));
        let digit = |i: usize| match i <= three.len() {
            true => char::from(DIGITS[(all >> (18 - 6 * i) & 63) as usize]),
            false => '=',
        };
        [0, 1, 2, 3].map(digit)
    };
    bytes.chunks(3).flat_map(group).collect()
}

#[test]
fn formats_are_known_by_content_first() {
    for (content, name, format) in [
        ("ply\nformat", "a.obj", Some(Format::Ply)),
        ("glTF\u{2}", "a", Some(Format::Gltf)),
        (" {\"asset\"", "a", Some(Format::Gltf)),
        ("SOLID x\nfacet", "a", Some(Format::Stl)),
        ("# made by\nv 0 0 0\n", "-", Some(Format::Obj)),
        ("solid", "a.obj", Some(Format::Obj)),
        ("anything", "a.STL", Some(Format::Stl)),
        ("anything", "a.txt", None),
    ] {
        assert_eq!(Format::of(content.as_bytes(), Path::new(name)), format, "{content}");
    }
    assert_eq!(Format::of(&binary_stl(b"solid", &HALVES), Path::new("a")), Some(Format::Stl));
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a"), binary_stl(b"", &HALVES)).expect("a file");
    let loaded = polyscan::Model::open(folder.path().join("a")).expect("a model");
    assert_eq!((loaded.format, loaded.model.face_count()), (Format::Stl, 2));
    let error = read("anything", "a.txt").expect_err("no format");
    assert!(error.to_string().starts_with("a.txt is in no format that is known"), "{error}");
}

#[test]
fn stl_is_read_as_other_programs_write_it() {
    let text = text_stl(&HALVES);
    let halves = HALVES.map(|half| half.to_vec());
    for bytes in [
        text.clone().into_bytes(),
        text.to_uppercase().into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        text.replace('\n', "\r").into_bytes(),
        text.replace("solid square", "solid").into_bytes(),
        text.replace("0 0 1\n outer", "nan nan nan\n outer").into_bytes(),
        [b"solid gr\xfcn\n", text.replacen("solid square\n", "", 1).as_bytes()].concat(),
        text_stl(&HALVES[..1])
            .into_bytes()
            .into_iter()
            .chain(text_stl(&HALVES[1..]).into_bytes())
            .collect(),
        binary_stl(b"made by", &HALVES),
        binary_stl(b"solid by", &HALVES),
    ] {
        let loaded = read(&bytes, "a.stl").expect("a model");
        assert_eq!(positions(&loaded), halves, "{}", String::from_utf8_lossy(&bytes));
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!(loaded.model.vertices.len(), 4, "corners are joined");
        assert!(loaded.model.vertices.iter().all(|v| v.normal == Vec3::Z));
    }
    let said = format!("# a comment\n\n # solid\n{}", text.replace('\n', " # said\n # vertex\n"));
    for name in ["a.stl", "-"] {
        let loaded = read(&said, name).expect("a model");
        assert_eq!(positions(&loaded), halves, "{name}");
    }
    let mut cut = binary_stl(b"", &HALVES);
    cut.truncate(84 + 50 + 20);
    let loaded = read(&cut, "a.stl").expect("what is there");
    assert_eq!(loaded.model.face_count(), 1);
    assert!(loaded.warnings[0].contains("after 1 of the 2 triangles"), "{:?}", loaded.warnings);
    let bad = [HALVES[0], [Vec3::NAN; 3]];
    let loaded = read(binary_stl(b"", &bad), "a.stl").expect("what is there");
    assert_eq!((loaded.model.face_count(), loaded.warnings.len()), (1, 1));
    assert!(matches!(read(binary_stl(b"", &[]), "a.stl"), Err(LoadError::NoFaces { .. })));
    let lost = binary_stl(b"", &[[Vec3::NAN, Vec3::X, Vec3::Y]]);
    let said = read(lost, "a.stl").expect_err("no face").to_string();
    assert!(said.contains("of polygons? Also: a.stl: faces of fewer than 3 corners"), "{said}");
}

#[test]
fn ply_is_read_in_all_three_encodings() {
    let head = |encoding: &str| {
        format!(
            "ply\nformat {encoding} 1.0\ncomment x\nelement vertex 4\nproperty float x\n\
             property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
             property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let square = [Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0), Vec3::Y];
    let mut text = head("ascii");
    let (mut little, mut big) =
        (head("binary_little_endian").into_bytes(), head("binary_big_endian").into_bytes());
    for v in square {
        text += &format!("{} {} {} 255 0 0\n", v.x, v.y, v.z);
        little.extend(v.to_array().into_iter().flat_map(f32::to_le_bytes));
        big.extend(v.to_array().into_iter().flat_map(f32::to_be_bytes));
        little.extend([255, 0, 0]);
        big.extend([255, 0, 0]);
    }
    text += "4 0 1 2 3\n";
    little.push(4);
    little.extend([0, 1, 2, 3_i32].into_iter().flat_map(i32::to_le_bytes));
    big.push(4);
    big.extend([0, 1, 2, 3_i32].into_iter().flat_map(i32::to_be_bytes));
    for bytes in [text.clone().into_bytes(), little, big] {
        let loaded = read(&bytes, "a.ply").expect("a model");
        // It keeps its four sides.
        assert_eq!(positions(&loaded), [square.to_vec()]);
        assert!(loaded.model.vertices.iter().all(|v| v.color.truncate() == Vec3::X));
    }
    let error = read(text.replace("4 0 1 2 3", "4 0 1 2 9"), "a.ply").expect_err("no vertex 9");
    assert!(error.to_string().contains("refers to vertex 9"), "{error}");
    let error = read(text.replace("element vertex 4", "element vertex 999999999"), "a.ply");
    assert!(error.expect_err("cut off").to_string().contains("too many"));
}

/// A square of vertices with positions alone.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                   property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

#[test]
fn ply_is_read_as_other_programs_write_it() {
    let halves = HALVES.map(|half| half.to_vec());
    for text in [
        PLY.to_owned(),
        PLY.replace('\n', "\r\n"),
        // Comments and blank lines among the numbers, and a line that should have been a comment.
        PLY.replace("end_header\n", "end_header\n\n").replace("1 1 0\n", "comment x\n\n1 1 0 \n"),
        PLY.replace("element vertex", "Created by some program, from: x\nelement vertex"),
        PLY.replace("element vertex", "obj_info end_header x\ncomment end_header\nelement vertex"),
    ] {
        let loaded = read(&text, "a.ply").expect("a model");
        assert_eq!(positions(&loaded), halves, "{text}");
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }
    // Cut off: what is there, and a warning.
    let loaded = read(PLY.trim_end_matches("3 0 2 3\n"), "a.ply").expect("what is there");
    assert_eq!(loaded.model.face_count(), 1);
    assert!(loaded.warnings[0].contains("after 1 of its 2 faces"), "{:?}", loaded.warnings);
    let error = read(PLY.split("1 1 0").next().expect("text"), "a.ply").expect_err("no vertices");
    assert!(error.to_string().contains("was it cut off?"), "{error}");
    for cloud in [PLY.replace("face 2", "face 0"), PLY.replace("element face 2", "element x 2")] {
        let error = read(&cloud, "a.ply").expect_err("no faces").to_string();
        assert!(error.contains("a cloud of points"), "{error}");
    }
}

/// The picture that MeshLab names in a comment, with texture coordinates of the corners.
#[test]
fn ply_has_the_picture_that_it_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = polyscan::Framebuffer::new(1, 1, [255_u8, 0, 0, 255]).expect("a pixel");
    picture.save_png(folder.path().join("my picture.png")).expect("a picture");
    let text = PLY
        .replace("element vertex", "comment TextureFile C:\\scans\\my picture.png\nelement vertex")
        .replace("vertex_indices\n", "vertex_indices\nproperty list uchar float texcoord\n")
        .replace("3 0 1 2\n", "3 0 1 2 6 0 0 1 0 1 1\n")
        .replace("3 0 2 3\n", "3 0 2 3 0\n");
    let model = folder.path().join("a.ply");
    std::fs::write(&model, &text).expect("a file");
    let Loaded { model, warnings, .. } = Loader::new().load(model).expect("a model");
    assert!(warnings.is_empty(), "{warnings:?}");
    // The face without coordinates comes first: it has the default material.
    let textures: Vec<_> = model.faces().map(|f| model.materials[f.material].texture).collect();
    assert_eq!(textures, [None, Some(0)]);
    let loaded = read(&text, "no/such/folder/a.ply").expect("a model");
    assert!(loaded.warnings[0].contains("without its picture"), "{:?}", loaded.warnings);
}

/// Files that other readers draw.
#[test]
fn gltf_is_read_as_other_programs_write_it() {
    let text = gltf("{}", r#"{"mesh":0}"#);
    let halves = HALVES.map(|half| half.to_vec());
    for (changed, warned) in [
        (text.replace(r#""POSITION":0"#, r#""POSITION":0,"_FEATURE_ID_0":0"#), None),
        (text.replace(r#""scene":0"#, r#""scene":7"#), None),
        (text.replacen('{', r#"{"extensionsRequired":["X_looks"],"#, 1), Some("extension X_looks")),
    ] {
        let loaded = read(&changed, "a.gltf").expect("a model");
        assert_eq!(positions(&loaded), halves, "{changed}");
        let said = loaded.warnings.join("\n");
        assert!(warned.map_or(said.is_empty(), |what| said.contains(what)), "{said}");
    }
    // The last index is 3; of only three vertices, the second triangle leads nowhere.
    let short = text.replace("\"count\":4", "\"count\":3");
    let loaded = read(&short, "a.gltf").expect("what is there");
    assert_eq!(positions(&loaded), halves[..1]);
    assert!(loaded.warnings[0].contains("refers to vertex 3"), "{:?}", loaded.warnings);

    let old = r#"{"asset":{"version": "1.0"},"accessors":{"a":{}},"meshes":{}}"#;
    for old in [old.as_bytes(), b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0"] {
        let error = read(old, "a.gltf").expect_err("the first version").to_string();
        assert!(error.contains("glTF 1.0"), "{error}");
    }
    // Found by fuzzing: a length that does not reach to the end of the head.
    let glb = |length: u32| [b"glTF\x02\0\0\0", &length.to_le_bytes()[..], &[0; 8]].concat();
    for (length, says) in [(6, "has 6 bytes"), (99, "after 20 of its 99 bytes"), (20, "no glTF")] {
        let error = read(glb(length), "a").expect_err("no model").to_string();
        assert!(error.contains(says), "{error}");
    }
    for word in ["extensionsRequired", "extensionsUsed"] {
        let packed = format!(r#"{{"{word}":["KHR_draco_mesh_compression"],"#);
        let packed = text.replacen('{', &packed, 1).replace("\"bufferView\":0,", "");
        let error = read(packed, "a.gltf").expect_err("packed").to_string();
        assert!(error.contains("packed by KHR_draco_mesh_compression"), "{error}");
    }
}

/// The example in the text of KHR_texture_transform: the lower left quadrant, turned clockwise.
#[test]
fn gltf_turns_textures_and_emits_light() {
    use glam::vec2;

    let folder = tempfile::tempdir().expect("a folder");
    let picture = polyscan::Framebuffer::new(1, 1, [0_u8, 255, 0, 255]).expect("a pixel");
    picture.save_png(folder.path().join("a.png")).expect("a picture");
    let png = base64(&std::fs::read(folder.path().join("a.png")).expect("a file"));
    let transform = r#"{"offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]}"#;
    let material = format!(
        r#"{{"emissiveFactor":[1,1,0.5],"emissiveTexture":{{"index":0,
        "extensions":{{"KHR_texture_transform":{transform}}}}},
        "extensions":{{"KHR_materials_emissive_strength":{{"emissiveStrength":2}}}}}}"#
    );
    let images = format!(
        r#"{{"textures":[{{"source":0}}],"images":[{{"uri":"data:image/png;base64,{png}"}}],"#
    );
    let text = gltf(&material, r#"{"mesh":0}"#).replacen('{', &images, 1);
    let Loaded { model, warnings, .. } = read(&text, "a.gltf").expect("a model");
    assert!(warnings.is_empty(), "{warnings:?}");
    let material = &model.materials[1];
    let light = material.emission_at(&model.textures, &vec2(0.3, 0.3).into());
    assert_eq!(light, vec3(0.0, 2.0, 0.0));
    for (uv, expected) in [
        // What is shown at the top left is the quadrant's lower left, and so on around.
        (vec2(0.0, 0.0), vec2(0.0, 1.0)),
        (vec2(1.0, 0.0), vec2(0.0, 0.5)),
        (vec2(1.0, 1.0), vec2(0.5, 0.5)),
        (vec2(0.0, 1.0), vec2(0.5, 1.0)),
    ] {
        let found = material.emission_mapping.uv(uv);
        assert!((found - expected).length() < 1e-6, "{uv}: {found}");
    }
}

/// Normals and occlusion are numbers, not sRGB, each with its own transform.
#[test]
fn gltf_has_normals_and_occlusion() {
    use glam::{Vec4, vec2};
    use polyscan::tangent::TangentFrame;

    let folder = tempfile::tempdir().expect("a folder");
    let picture = polyscan::Framebuffer::new(1, 1, [191_u8, 128, 238, 255]).expect("a pixel");
    picture.save_png(folder.path().join("a.png")).expect("a picture");
    let png = base64(&std::fs::read(folder.path().join("a.png")).expect("a file"));
    let images = format!(
        r#"{{"textures":[{{"source":0}}],"images":[{{"uri":"data:image/png;base64,{png}"}}],"#
    );
    // Turned by a quarter: what is right in the picture points down where the picture is seen.
    let turned = r#","extensions":{"KHR_texture_transform":{"rotation":1.57079632679}}"#;
    let [x, y] = [0.5, 0.866];
    for (scale, transform, expected) in [
        (1.0, "", vec3(x, 0.0, y)),
        (0.5, "", vec3(0.5 * x, 0.0, y).normalize()),
        (1.0, turned, vec3(0.0, -x, y)),
        (1.0, r#","texCoord":1"#, Vec3::Z),
    ] {
        let material = format!(
            r#"{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}},
            "normalTexture":{{"index":0,"scale":{scale}{transform}}},
            "occlusionTexture":{{"index":0,"strength":0.5}}}}"#
        );
        let text = gltf(&material, r#"{"mesh":0}"#).replacen('{', &images, 1);
        let Loaded { model, warnings, .. } = read(&text, "a.gltf").expect("a model");
        let material = &model.materials[1];
        assert_eq!(warnings.len(), usize::from(expected == Vec3::Z), "{warnings:?}");
        let frame = TangentFrame::new(Vec3::Z, Vec4::new(1.0, 0.0, 0.0, 1.0));
        let seen = vec2(0.3, 0.3).into();
        let found = material.normal_at(&model.textures, &seen, &frame);
        assert!((found - expected).length() < 0.006, "{transform}: {found} {expected}");
        let occlusion = material.occlusion_at(&model.textures, &seen);
        assert!((occlusion - (1.0 - 0.5 * (1.0 - 191.0 / 255.0))).abs() < 1e-6, "{occlusion}");
        // The same picture as colours is decoded.
        let color = material.color_at(&model.textures, &seen, Vec4::ONE);
        assert!((color.x - polyscan::color::decode(191)).abs() < 1e-6, "{color}");
    }
}

/// A glTF file of a square with normals and tangents, one tangent for all corners, and a normal map.
fn gltf_with_tangents(tangent: [f32; 4], node: &str) -> String {
    let picture = polyscan::Framebuffer::new(1, 1, [128_u8, 128, 255, 255]).expect("a pixel");
    let folder = tempfile::tempdir().expect("a folder");
    picture.save_png(folder.path().join("a.png")).expect("a picture");
    let png = base64(&std::fs::read(folder.path().join("a.png")).expect("a file"));
    let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0_f32];
    let (normals, tangents) = ([[0.0, 0.0, 1.0]; 4].concat(), [tangent; 4].concat());
    let floats = [&positions[..], &normals, &tangents].concat();
    let mut bytes: Vec<u8> = floats.iter().flat_map(|n| n.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3_u8]);
    let view = |start: usize, len: usize| {
        format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{len}}}"#)
    };
    let accessor = |view: usize, kind: &str| {
        format!(r#"{{"bufferView":{view},"componentType":5126,"count":4,"type":"{kind}"}}"#)
    };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{node}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TANGENT":2}},"indices":3,"material":0}}]}}],
        "materials":[{{"normalTexture":{{"index":0}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"data:image/png;base64,{png}"}}],
        "buffers":[{{"byteLength":166,"uri":"data:application/octet-stream;base64,{}"}}],
        "bufferViews":[{},{},{},{}],
        "accessors":[{},{},{},{{"bufferView":3,"componentType":5121,"count":6,"type":"SCALAR"}}]}}"#,
        base64(&bytes),
        view(0, 48),
        view(48, 48),
        view(96, 64),
        view(160, 6),
        accessor(0, "VEC3"),
        accessor(1, "VEC3"),
        accessor(2, "VEC4"),
    )
}

/// A file's own tangents are taken where it has normals as well, with the meshes' places; computed ones would not lie
/// askew.
#[test]
fn gltf_has_tangents_of_its_own() {
    use glam::{Vec4, vec4};

    let (still, mirrored) = (r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[-3,1,1]}"#);
    let turned = r#"{"mesh":0,"rotation":[0,0,0.70710678,0.70710678]}"#;
    for (given, node, expected) in [
        ([0.6, 0.8, 0.0, 1.0], still, vec4(0.6, 0.8, 0.0, 1.0)),
        ([0.6, 0.8, 0.0, -1.0], still, vec4(0.6, 0.8, 0.0, -1.0)),
        ([1.2, 1.6, 0.0, -0.5], still, vec4(0.6, 0.8, 0.0, -1.0)),
        ([0.6, 0.8, 0.0, -1.0], turned, vec4(-0.8, 0.6, 0.0, -1.0)),
        // Seen as in a mirror, and three times as wide.
        ([0.6, 0.8, 0.0, 1.0], mirrored, vec4(-1.8, 0.8, 0.0, 1.0)),
    ] {
        let Loaded { model, warnings, .. } =
            read(gltf_with_tangents(given, node), "a.gltf").expect("a model");
        assert!(warnings.is_empty(), "{warnings:?}");
        let sign = if node == mirrored { -1.0 } else { 1.0 };
        let expected = expected.truncate().normalize().extend(sign * expected.w);
        assert_eq!(model.vertices.len(), 4);
        for vertex in &model.vertices {
            assert!((vertex.tangent - expected).length() < 1e-6, "{vertex:?} {expected}");
            assert!((vertex.normal - Vec3::Z).length() < 1e-6, "{vertex:?}");
        }
    }
    let of = |text: &str| read(text, "a.gltf").expect("a model").model.vertices[0].tangent;
    let text = gltf_with_tangents([0.6, 0.8, 0.0, 1.0], still);
    // Without normals they are not to be used, and without a normal map nothing is.
    let computed = of(&text.replace(r#""NORMAL":1,"#, ""));
    assert!((computed.truncate().length() - 1.0).abs() < 1e-6 && computed.z.abs() < 1e-6);
    assert_ne!(computed, vec4(0.6, 0.8, 0.0, 1.0));
    assert_eq!(of(&text.replace("normalTexture", "occlusionTexture")), Vec4::ZERO);
    for bad in [[0.0, 0.0, 0.0, 1.0], [f32::NAN, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, f32::NAN]] {
        let tangent = of(&gltf_with_tangents(bad, still));
        assert!((tangent.truncate().length() - 1.0).abs() < 1e-6, "{bad:?}: {tangent}");
    }
}

#[test]
fn gltf_is_placed_and_has_its_looks() {
    use glam::Vec2;
    use polyscan::model::AlphaMode;

    let text = gltf(
        r#"{"name":"glass","alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,0.25]}}"#,
        r#"{"mesh":0,"translation":[0,0,3],"scale":[2,2,2]}"#,
    );
    let loaded = read(&text, "a.gltf").expect("a model");
    let expected = HALVES.map(|half| half.map(|v| v * 2.0 + Vec3::Z * 3.0).to_vec());
    assert_eq!(positions(&loaded), expected);
    let material = &loaded.model.materials[1];
    assert_eq!((material.name.as_str(), material.alpha_mode), ("glass", AlphaMode::Blend));
    let color = material.color_at(&[], &Vec2::ZERO.into(), glam::Vec4::ONE);
    assert_eq!(color, glam::vec4(0.25, 0.125, 0.0, 0.25));

    // Mirrored: still counter-clockwise seen from outside.
    let text = gltf("{}", r#"{"mesh":0,"scale":[-1,1,1]}"#);
    let model = read(&text, "a.gltf").expect("a model").model;
    assert!(model.vertices.iter().all(|v| v.normal == Vec3::Z));
    let circle = gltf("{}", r#"{"mesh":0,"children":[0]}"#);
    assert_eq!(read(&circle, "a.gltf").expect("a model").model.face_count(), 2);
    let cut = text.replace("\"byteLength\":48", "\"byteLength\":40");
    assert!(read(&cut, "a.gltf").expect_err("cut off").to_string().contains("beyond its buffer"));
    let needs = text.replacen('{', r#"{"extensionsRequired":["KHR_draco_mesh_compression"],"#, 1);
    let error = read(&needs, "a.gltf").expect_err("an extension").to_string();
    assert!(error.contains("KHR_draco_mesh_compression"), "{error}");
}

/// Bytes changed, cut off and put in at random: a model or an error, never a panic.
#[test]
fn broken_files_never_panic() {
    let rng = &mut Rng::new(16);
    let mut seeds: Vec<(Vec<u8>, &str)> =
        vec![(b"v 0 0 0 1 1 1\nvt 0 0\nf 1/1 1//2 1\ns 1\n#MRGB ff\n".to_vec(), "a.obj")];
    seeds.push((text_stl(&HALVES).into_bytes(), "a.stl"));
    seeds.push((binary_stl(b"", &HALVES), "a.stl"));
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty float y\n\
               property int z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_index\n\
               end_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n";
    seeds.push((ply.into(), "a.ply"));
    seeds.push((ply.replace("ascii", "binary_little_endian").into(), "a.ply"));
    {
        let text = gltf(r#"{"alphaMode":"MASK"}"#, r#"{"mesh":0,"rotation":[0,0,0,1]}"#);
        seeds.push((text.into_bytes(), "a.gltf"));
    }
    for (seed, name) in seeds {
        for _ in 0..1500 {
            let mut bytes = seed.clone();
            for _ in 0..1 + rng.below(4) {
                let place = rng.below(bytes.len());
                match rng.below(4) {
                    0 => bytes.truncate(place.max(1)),
                    1 => bytes[place] = rng.below(256) as u8,
                    2 => bytes[place] = b"0123456789-/.e \n{}[],\"\xff"[rng.below(23)],
                    _ => bytes.insert(place, b'9'),
                }
            }
            if let Ok(loaded) = read(&bytes, name) {
                let model = &loaded.model;
                let count = model.vertices.len();
                assert!(model.faces().all(|f| f.indices.iter().all(|&i| (i as usize) < count)));
                assert!(
                    model.vertices.iter().all(|v| v.position.is_finite() && v.normal.is_finite())
                );
            }
        }
    }
}
