//! The examples as people run them: what is wrong is said in a sentence, with an exit code, and nothing is left
//! behind.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The folder of the examples, which are built first.
fn built() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let test = std::env::current_exe().expect("this test");
        // target/debug/deps/it-...
        let profile = test.ancestors().nth(2).expect("a folder of the profile").to_owned();
        let target = profile.parent().expect("the target folder");
        let mut cargo = Command::new(env!("CARGO"));
        cargo
            .args(["build", "--locked", "--examples", "-p", "polyscan", "--target-dir"])
            .arg(target);
        cargo.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
        // By the profile that `cargo test` has built them with already, if it builds all.
        let is_release = profile.ends_with("release");
        cargo.args(["--profile", if is_release { "release" } else { "test" }]);
        assert!(cargo.status().expect("cargo runs").success());
        profile.join("examples")
    })
}

fn run(example: &str, folder: &Path, args: &[&str]) -> Output {
    let path = built().join(example);
    Command::new(path).current_dir(folder).args(args).output().expect("the example runs")
}

#[test]
fn errors_of_examples_are_sentences() {
    let folder = tempfile::tempdir().expect("a folder");
    let bad = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
    std::fs::write(folder.path().join("bad.obj"), bad).expect("a file");
    let good = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(folder.path().join("good.obj"), good).expect("a file");
    let sentence =
        "error: bad.obj:4: a face refers to position 9, but there are only 3 in the file";
    for (example, args, says) in [
        ("obj", &["bad.obj"][..], sentence),
        ("poster", &["bad.obj"], sentence),
        ("renderers", &["bad.obj"], sentence),
        ("datasets", &["bad.obj"], sentence),
        ("datasets", &["good.obj", "--poses", "0"], "give a whole number from 1 to 9999"),
        (
            "datasets",
            &["good.obj", "--output", "good.obj"],
            "error: cannot make the folder good.obj: ",
        ),
        ("datasets", &["good.obj", "--metres", "-1"], "give a length in metres"),
        ("datasets", &["good.obj", "--metres", "1000"], "choose another --metres, such as "),
        ("obj", &["no.obj"], "error: cannot read the model no.obj: No such file"),
        ("obj", &["good.obj", "--output", "a.webp"], "choose a name that ends in .png"),
        ("obj", &["good.obj", "--output", "a"], "choose a name that ends in .png"),
        ("poster", &["good.obj", "--output", "a.jpg"], "choose a name that ends in .png"),
        ("obj", &["good.obj", "--yaw", "nan"], "give a number of degrees"),
        ("obj", &["good.obj", "--up", "w"], "name an axis"),
        ("quads", &["--output", "a.tif"], "choose a name that ends in .png"),
        ("projector", &["--filter", "0"], "give a whole number from 1 to 15"),
        ("warp", &["--picture", "no.png"], "no.png"),
        ("warp", &["--output", "a.svg"], "choose a name that ends in .png"),
        ("figures", &["--output", "a"], "choose a name that ends in .png"),
        ("custom_renderer", &["--nonsense"], "error: invalid option '--nonsense'"),
        ("stages", &["--nonsense"], "error: invalid option '--nonsense'"),
    ] {
        let output = run(example, folder.path(), args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{example} {args:?}: {said}");
        assert!(said.starts_with("error: ") && said.contains(says), "{example} {args:?}: {said}");
        assert!(!said.contains("Error: ") && !said.contains(" { "), "{said}");
        let left: Vec<_> = std::fs::read_dir(folder.path()).expect("a folder").flatten().collect();
        let is_picture =
            |name: &std::ffi::OsStr| Path::new(name).extension().is_some_and(|e| e != "obj");
        assert!(!left.iter().any(|entry| is_picture(&entry.file_name())), "{example}: {left:?}");
    }
}

/// Glass lets what is behind it through, in the picture that the example draws.
#[test]
fn an_example_draws_glass() {
    let folder = tempfile::tempdir().expect("a folder");
    let obj = "mtllib m.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 0.1\nv 1 -1 0.1\nv 1 1 0.1\n\
               v -1 1 0.1\nusemtl glass\nf 5 6 7 8\nusemtl wall\nf 1 2 3 4\n";
    std::fs::write(folder.path().join("m.obj"), obj).expect("a file");
    let mtl = "newmtl wall\nKd 1 0 0\nnewmtl glass\nKd 0 0 1\nd 0.5\n";
    std::fs::write(folder.path().join("m.mtl"), mtl).expect("a file");
    let output = run(
        "obj",
        folder.path(),
        &["m.obj", "--yaw", "0", "--pitch", "0", "--size", "9x9", "--output", "a.png"],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let texture = polyscan::Texture::open(folder.path().join("a.png")).expect("a picture");
    let middle = texture.texel(4, 4);
    // Half of each, in the same light, by what 8 bits can say.
    assert!(middle.x > 0.2 && middle.y == 0.0 && (middle.x - middle.z).abs() < 0.01, "{middle}");
}

/// What a data set says of its pixels: pictures of numbers, as whole numbers of up to 16 bits.
struct Shot {
    /// The three axes of the camera as columns, and where it is.
    axes: [[f64; 3]; 3],
    eye: [f64; 3],
    depth: Vec<[f64; 3]>,
    ids: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    uv: Vec<[f64; 3]>,
}

const SIZE: [usize; 2] = [72, 48];

impl Shot {
    fn read(folder: &Path, pose: usize) -> Self {
        let json = std::fs::read_to_string(folder.join("cameras.json")).expect("the cameras");
        let (_, matrix) = json
            .lines()
            .find(|line| line.contains(&format!("\"{pose:04}\"")))
            .and_then(|line| line.split_once("object_from_camera"))
            .expect("the pose");
        let numbers: Vec<f64> =
            matrix.split(['[', ']', ',', ' ']).filter_map(|text| text.parse().ok()).collect();
        let row = |i: usize| &numbers[4 * i..4 * i + 4];
        let picture = |what: &str, most: f32| -> Vec<[f64; 3]> {
            let path = folder.join(format!("{pose:04}_{what}.png"));
            let texture = polyscan::Texture::open_data(path).expect("a picture");
            assert_eq!([texture.width(), texture.height()].map(|side| side as usize), SIZE);
            let number = |value: f32| f64::from((value * most).round());
            texture.texels().map(|t| t.truncate().to_array().map(number)).collect()
        };
        Self {
            axes: [0, 1, 2].map(|axis| [0, 1, 2].map(|i| row(i)[axis])),
            eye: [0, 1, 2].map(|i| row(i)[3]),
            depth: picture("depth", 65535.0),
            ids: picture("ids", 255.0),
            normals: picture("normals", 65535.0),
            uv: picture("uv", 65535.0),
        }
    }

    /// A vector in camera space as one in object space.
    fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [right, above, back] = self.axes;
        [0, 1, 2].map(|i| right[i] * x + above[i] * y + back[i] * z)
    }

    /// Where a pixel's centre lies in object space, and how far from the eye for each metre of depth.
    fn place(&self, pixel: usize, focal: f64) -> ([f64; 3], f64) {
        let [x, y] = [pixel % SIZE[0], pixel / SIZE[0]].map(|i| i as f64 + 0.5);
        let [x, y] = [(x - SIZE[0] as f64 / 2.0) / focal, (SIZE[1] as f64 / 2.0 - y) / focal];
        let metres = self.depth[pixel][0] / 1000.0;
        let along = self.turned([x, y, -1.0].map(|c| c * metres));
        ([0, 1, 2].map(|i| self.eye[i] + along[i]), (x * x + y * y + 1.0).sqrt())
    }
}

/// Depths, ids, normals and texture coordinates belong to the same face at every pixel, and the cameras' matrices
/// and lens lead back to it.
#[test]
fn data_sets_lead_back_to_their_model() {
    let folder = tempfile::tempdir().expect("a folder");
    // In the plane where z is 0, with u = x and v = 1 - y; v is upwards in OBJ files.
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    std::fs::write(folder.path().join("a.obj"), obj).expect("a file");
    let args = ["a.obj", "--poses", "5", "--size", "72x48", "--output", "set"];
    let output = run("datasets", folder.path(), &args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // A vertical angle of view of 0.6 radians.
    let focal = 24.0 / 0.3f64.tan();
    let mut pixels = [0; 3];
    for pose in 0..5 {
        let shot = Shot::read(&folder.path().join("set"), pose);
        for i in 0..SIZE[0] * SIZE[1] {
            let id = shot.ids[i][0] as usize;
            pixels[id] += 1;
            assert_eq!(shot.ids[i][1..], [0.0; 2]);
            assert_eq!(shot.depth[i][0] == 0.0, id == 0);
            assert_eq!(shot.normals[i] == [0.0; 3], id == 0);
            assert_eq!(shot.uv[i][2], if id == 0 { 0.0 } else { 65535.0 });
            if id == 0 {
                continue;
            }
            let ([x, y, z], length) = shot.place(i, focal);
            // Depth is rounded to half a millimetre; at borders, corners to 1/256 pixel, which is less.
            let near = 0.001 * length;
            let normal = shot.turned(shot.normals[i].map(|n| n / 65535.0 * 2.0 - 1.0));
            // The triangle, and the floor that it stands on.
            let (off, axis) = if id == 1 { (z, 2) } else { (y, 1) };
            assert!(off.abs() < near, "pose {pose}, pixel {i}: {x} {y} {z}");
            assert!((normal[axis] - 1.0).abs() < 1e-4, "pose {pose}, pixel {i}: {normal:?}");
            if id == 1 {
                let [u, v, _] = shot.uv[i].map(|t| t / 65535.0);
                assert!((u - x).abs().max((1.0 - v - y).abs()) < near, "pose {pose}, pixel {i}");
            }
        }
    }
    assert!(pixels.iter().all(|&count| count > 100), "{pixels:?}");
}
