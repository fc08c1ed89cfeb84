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
        if profile.ends_with("release") {
            cargo.arg("--release");
        }
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
