//! The exact inputs of faults that were found and fixed, most of them by the fuzz targets.

use crate::common::generators::Rng;
use glam::{Vec4, vec4};
use polyscan::{
    ClipPlane, DepthTest, Fragment, Framebuffer, ScanConverter, Vertex, Viewport, ZBufferRenderer,
};

/// A pixel centre outside the unrounded triangle got w from its range, but s from its plane.
#[test]
fn a_constant_parameter_stays_so_outside_the_unrounded_polygon() {
    let triangle = [
        vec4(10.875, -189.0, 0.37254903, 1.0),
        vec4(-1.0, 1.0004883, 0.3764706, 1.0),
        vec4(1.78125, -1.5, -0.0, -1.5),
    ]
    .map(|position| Vertex::new(position, [1.46875]));
    let mut scan = ScanConverter::new(Viewport::new(16, 1).expect("small"));
    let mut seen = 0;
    for span in scan.spans(&triangle) {
        for fragment in span.fragments() {
            let error = (fragment.params[0] / 1.46875 - 1.0).abs();
            assert!(error < 1e-6, "{fragment:?}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}

/// The same where 1/w changes many times its size over a subpixel, so that its plane is no good.
#[test]
fn parameters_of_a_steep_sliver_stay_between_those_of_the_vertices() {
    // Just right of the pixel centres in column 31, and 1/5000 pixel wide.
    let sliver = [
        (vec4(6.03e-5, -0.9, 0.5, 1.0), [1.0, 0.25]),
        (vec4(6.03e-2, 900.0, 500.0, 1000.0), [1.0, 0.5]),
        (vec4(6.67e-5, 0.0, 0.5, 1.0), [1.0, 0.75]),
    ]
    .map(|(position, params)| Vertex::new(position, params));
    let mut scan = ScanConverter::new(Viewport::new(63, 63).expect("small"));
    let mut seen = 0;
    for span in scan.spans(&sliver) {
        for fragment in span.fragments() {
            let [one, other] = fragment.params;
            assert!((one - 1.0).abs() < 1e-6, "{fragment:?}");
            assert!((0.25..=0.75).contains(&other), "{fragment:?}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}

/// The contour runs along the near plane and then leaves through it: the vertex in between is no corner
/// of what is left, as exact arithmetic has it.
#[test]
fn a_vertex_along_a_clip_plane_is_no_corner() {
    let spike = [
        vec4(-0.14907095, 0.3582974, 0.0, 0.5),
        vec4(-0.1340794, 0.1646013, -0.125, 0.25),
        vec4(4.5236487, 4.262931, 1.75, 4.0),
        vec4(-7.0675673, 1.4310344, 1.75, 4.0),
        vec4(-1.0422298, 0.1400862, 0.0, 0.5),
    ]
    .map(|position| Vertex::new(position, []));
    let mut scan = ScanConverter::new(Viewport::new(37, 29).expect("small"));
    let covered: Vec<_> = scan.spans(&spike).map(|span| (span.row(), span.columns())).collect();
    assert_eq!(covered, [(6, 0..1)]);
}

/// Two corners are one on the screen. Rounding errors once gave it pixels, and made up the slopes of
/// its plane.
#[test]
fn a_triangle_seen_exactly_edge_on_is_not_drawn() {
    let edge_on = [
        vec4(0.9, 0.25490195, 0.039215688, 1.0),
        vec4(0.9, 0.25490195, 0.37254903, 1.0),
        vec4(-1.5, -1.5, -1.5, -1.5),
    ]
    .map(|position| Vertex::new(position, [-1.5]));
    let mut scan = ScanConverter::new(Viewport::new(100, 255).expect("small"));
    assert_eq!(scan.spans(&edge_on).count(), 0);
}

/// A side leads through the eye, so that w begins at the smallest normal number.
#[test]
fn parameters_stay_finite_at_w_ratios_over_2_to_the_126() {
    let through_eye = [
        (vec4(-1.0, -6.1764708, 0.4509804, 1.0), 0.53125),
        (vec4(1.46875, 1.46875, 1.46875, 1.46875), -1.5),
        (vec4(-1.5, -1.5, -1.5, -1.5), 1.9043541e15),
        (vec4(-15.363281, 15.529411, 11.105883, 16.0), -1.5),
    ]
    .map(|(position, param)| Vertex::new(position, [param]));
    let mut scan = ScanConverter::new(Viewport::new(65_535, 16).expect("small"));
    let mut seen = 0;
    for span in scan.spans(&through_eye) {
        for fragment in span.fragments().take(1000) {
            assert!((-1.5..=1.9043541e15).contains(&fragment.params[0]), "{fragment:?}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}

/// Where w ratios are over 2^47, 1/w at the far end is a sum of numbers that cancel each other.
#[test]
fn a_constant_parameter_stays_so_at_any_w_ratio() {
    let triangle = [
        vec4(-0.99710083, 1.0, 0.03529412, 1.0),
        vec4(1.46875, -1.5, 1.46875, 0.34375),
        vec4(-3.5424138e-15, 3.5527137e-15, 1.32356e-15, 3.5527137e-15),
    ]
    .map(|position| Vertex::new(position, [1.46875]));
    let mut scan = ScanConverter::new(Viewport::new(65_536, 64).expect("small"));
    let mut seen = 0;
    for span in scan.spans(&triangle) {
        for fragment in span.fragments() {
            assert!((fragment.params[0] / 1.46875 - 1.0).abs() < 1e-6, "{fragment:?}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}

/// A vertex so far away that f64 no longer knows the plane at the near end. The parameters are not
/// right there, but sane: the fuzz target asks no more of w ratios over 2^28.
#[test]
fn a_vertex_at_a_w_ratio_of_2_to_the_52_keeps_w_and_depth_in_their_ranges() {
    let far = 4_503_599_600_000_000.0;
    let triangle = [
        (vec4(-1.5, -1.5, -1.5, -1.5), [7_652_601_000_000_000.0]),
        (vec4(-11.25, -18.105_469, 7.897_059, 11.25), [-1.5]),
        (vec4(1.699_219 * far, 1.699_219 * far, 1.699_219 * far, far), [-1.5]),
    ]
    .map(|(position, params)| Vertex::new(position, params));
    let mut scan = ScanConverter::new(Viewport::new(65536, 64).expect("the largest width"));
    scan.settings.clip_space = polyscan::ClipSpace::MinusOneToOne;
    let mut seen = 0;
    for span in scan.spans(&triangle) {
        for fragment in span.fragments().take(100) {
            assert!(fragment.w > 0.0 && fragment.w <= far, "{fragment:?}");
            assert!((0.0..=1.0).contains(&fragment.depth), "{fragment:?}");
            assert!(fragment.params[0].is_finite(), "{fragment:?}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}

/// Distances were infinite on both sides of the plane, and their ratio NaN.
#[test]
fn a_plane_that_is_not_finite_cuts_nothing() {
    let triangle = [
        vec4(141.0, -0.03999996, 0.29411766, 1.0),
        vec4(-1.0, -0.5, 0.2784314, 1.0),
        vec4(-1.5, -1.5, -1.5, -1.5),
    ]
    .map(|position| Vertex::new(position, [-1.5]));
    let mut scan = ScanConverter::new(Viewport::new(1, 100).expect("small"));
    scan.settings.planes.push(ClipPlane::new(vec4(f32::INFINITY, -0.375, 0.125, 0.84375)));
    let mut seen = 0;
    for span in scan.spans(&triangle) {
        for fragment in span.fragments() {
            assert!((fragment.params[0] / -1.5 - 1.0).abs() < 1e-6, "{fragment:?}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}

/// OBJ files: an MTL file and the pictures it names.
#[cfg(feature = "obj")]
mod obj {
    use std::fs;

    use polyscan::Model;
    use polyscan::obj::{LineError, Loaded, Warning};

    /// A triangle of the material `a`, with this MTL file, in a folder beside a picture.
    fn load(mtl: &str) -> Loaded {
        let folder = tempfile::tempdir().expect("a folder");
        let inside = folder.path().join("in");
        fs::create_dir(&inside).expect("a folder");
        let picture = polyscan::Framebuffer::new(1, 1, [0_u8; 3]).expect("a pixel");
        picture.save_png(folder.path().join("t.png")).expect("a picture");
        let obj = "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        fs::write(inside.join("m.obj"), obj).expect("a file");
        // The absolute name of the picture where the text has `@`.
        let absolute = folder.path().display().to_string();
        let mtl = mtl.replace('@', &absolute);
        fs::write(inside.join("m.mtl"), mtl).expect("a file");
        Model::load(inside.join("m.obj")).expect("a model")
    }

    /// The parser cuts blanks off the name, found none, and refused the whole file.
    #[test]
    fn a_texture_name_of_blanks_does_not_cost_the_materials() {
        for line in ["map_Kd \" \"", "map_Kd /\u{a0}/", "map_Kd C:\u{a0}\"", "map_Kd ./ /."] {
            let Loaded { model, warnings } = load(&format!("newmtl a\n{line}\n"));
            assert_eq!(model.faces_of(1).count(), 1, "{line}: {warnings:?}");
            let no_name = |warning: &Warning| {
                let cause = LineError::NoName { keyword: "map_Kd" };
                matches!(warning, Warning::MaterialLine { line: 2, cause: c, .. } if *c == cause)
            };
            assert!(warnings.len() == 1 && no_name(&warnings[0]), "{line}: {warnings:?}");
        }
    }

    /// The parser cuts blanks off the name, and the rest led out of the folder.
    #[test]
    fn blanks_before_a_texture_name_do_not_lead_out_of_the_folder() {
        for name in ["\" ../t.png\"", "./ ../t.png", "\" @/t.png\"", "./ @/t.png", ".\\\t..\\t.png"]
        {
            let Loaded { model, warnings } = load(&format!("newmtl a\nmap_Kd {name}\n"));
            assert!(model.textures.is_empty(), "{name}");
            assert_eq!(warnings.len(), 1, "{name}: {warnings:?}");
        }
    }
}

/// Limits that 1/w is brought back to were left out for a polygon without parameters.
#[test]
fn w_does_not_hang_on_the_number_of_parameters() {
    fn w_of<const N: usize>(params: [f32; N], positions: &[Vec4; 3]) -> Vec<u32> {
        let triangle = positions.map(|position| Vertex::new(position, params));
        let mut scan = ScanConverter::new(Viewport::new(63, 63).expect("small"));
        let spans = scan.spans(&triangle);
        spans.flat_map(|span| span.fragments().map(|f| f.w.to_bits()).collect::<Vec<_>>()).collect()
    }
    let mut rng = Rng::new(5);
    let (mut seen, mut outside) = (0, 0);
    for _ in 0..2000 {
        // Slivers beside the pixel centres of a column, 1/w many times its size over a subpixel.
        let column = (rng.range(0.0, 63.0).floor() + 0.5) / 31.5 - 1.0;
        let w = [0; 3].map(|_| 10f64.powf(rng.range(-3.0, 3.0)));
        let positions = w.map(|w| {
            let (x, y) = (column + rng.range(-1e-4, 1e-4), rng.range(-1.0, 1.0));
            vec4((x * w) as f32, (y * w) as f32, (w / 2.0) as f32, w as f32)
        });
        let without = w_of([], &positions);
        assert_eq!(without, w_of([1.5], &positions), "{positions:?}");
        seen += without.len();
        // Pixel centres where the plane of 1/w is so far off that w is brought back.
        let least = positions.iter().fold(f32::INFINITY, |least, p| least.min(p.w));
        outside += without.iter().filter(|w| f32::from_bits(**w) == least).count();
    }
    assert!(seen > 10_000 && outside > 100, "{seen} fragments, {outside} of them outside");
}

/// A panic in a shader left blocks behind that the next polygon drew.
#[test]
fn a_shader_that_panics_leaves_nothing_behind() {
    let quad = |size: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vertex::new(vec4(x * size, y * size, 0.5, 1.0), [x]))
    };
    for depth_test in [DepthTest::Nearer, DepthTest::NearerOrEqual, DepthTest::Always] {
        for pixels_before in [0, 1, 20, 21, 40, 60, 100] {
            let frame = || Framebuffer::new(37, 29, 0.0f32).expect("small");
            let (mut broken, mut untouched) = (frame(), frame());
            let mut renderer = ZBufferRenderer::new(broken.viewport());
            renderer.depth_test = depth_test;
            let mut fresh = renderer.clone();
            let mut left = pixels_before;
            let drawn = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                renderer.on_one_thread().draw(&mut broken, &quad(1.0), |_| {
                    if left == 0 {
                        // As a panic, but without a word on the standard error.
                        std::panic::resume_unwind(Box::new(()));
                    }
                    left -= 1;
                    1.0
                });
            }));
            assert!(drawn.is_err());
            let (mut after, shader) = (frame(), |f: &Fragment<'_, 1>| f.params[0]);
            renderer.draw(&mut after, &quad(0.2), shader);
            fresh.draw(&mut untouched, &quad(0.2), shader);
            assert!(after == untouched, "{depth_test:?}, {pixels_before} pixels");
        }
    }
}
