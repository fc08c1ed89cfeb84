//! Whatever parameters are made of: projective mappings, quads, values of polygons, subdivision. Nothing panics, and
//! what comes out is what its documentation says, or an error.
//!
//! ```text
//! cargo install cargo-fuzz
//! mkdir -p fuzz/corpus/parameters
//! cargo +nightly fuzz run -s none parameters fuzz/corpus/parameters -- \
//!     -max_len=400 -timeout=5 -rss_limit_mb=1024
//! ```
//!
//! For `-s none` see the target `scan`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use polyscan::glam::{DVec2, Vec2, Vec3};
use polyscan::parameters::{self, PolygonValues, Projective, Subdivision};
use polyscan::{Settings, Viewport};
use polyscan_fuzz::{Bytes, N};

fn vec2(bytes: &mut Bytes<'_>) -> Vec2 {
    Vec2::new(bytes.number(), bytes.number())
}

fn vec3(bytes: &mut Bytes<'_>) -> Vec3 {
    vec2(bytes).extend(bytes.number())
}

fn mapping(bytes: &mut Bytes<'_>) {
    let point = |bytes: &mut Bytes<'_>| vec2(bytes).as_dvec2();
    let pairs: Vec<(DVec2, DVec2)> =
        (0..3 + bytes.below(6)).map(|_| (point(bytes), point(bytes))).collect();
    let Ok(mapping) = Projective::from_pairs(&pairs) else { return };
    for &(from, _) in &pairs {
        let q = (mapping.matrix() * from.extend(1.0)).z;
        assert!(q > 0.0, "{q} at {from}");
    }
    let [width, height] = bytes.size();
    let viewport = Viewport::new(width, height).expect("at most 65536");
    let picture = mapping.picture(&viewport);
    assert!(picture.iter().all(|vertex| !vertex.position.is_nan()), "{picture:?}");
    let _ = mapping.at(point(bytes)).map(|place| mapping.inverse().at(place));
}

fn quad(bytes: &mut Bytes<'_>) {
    let corners = std::array::from_fn(|_| vec3(bytes));
    let values = std::array::from_fn(|_| vec2(bytes));
    let Ok(found) = parameters::quad(corners, values) else { return };
    for (found, value) in found.into_iter().zip(values) {
        assert!(found.is_finite() && found.z > 0.0 && found.z <= 1.0, "{found}");
        let off = (found.truncate() / found.z - value).abs();
        assert!(
            off.max_element() <= 1e-5 * value.abs().max_element() + 1e-30,
            "{found} for {value}"
        );
    }
}

fn values(bytes: &mut Bytes<'_>) {
    let corners: Vec<_> =
        (0..bytes.below(9)).map(|_| (vec3(bytes), [bytes.number(), bytes.number()])).collect();
    let Ok(values) = PolygonValues::new(&corners) else { return };
    for (&place, (_, wanted)) in values.places().iter().zip(&corners) {
        assert!(place.is_finite() && place.length() < 1.001, "{place}");
        let is_alone = values.places().iter().filter(|&&other| other == place).count() == 1;
        assert!(!is_alone || values.at(place) == *wanted, "{place}");
    }
    for _ in 0..4 {
        let place = vec2(bytes);
        let found = values.at(place);
        assert!(found.iter().all(|value| value.is_finite()), "{found:?} at {place}");
    }
}

fn subdivision(bytes: &mut Bytes<'_>) {
    let viewport = Viewport::new(64, 64).expect("small");
    let polygon = bytes.polygon(&viewport);
    let params = [bytes.below(N + 1), bytes.below(N + 1)];
    // Not so fine that a million triangles come of every input.
    let (error, size) = (bytes.number().abs().max(1e-3), vec2(bytes));
    let how = Subdivision::Within { error, params, size };
    let mut settings = Settings::<N>::new(viewport);
    settings.planes = bytes.settings(viewport).planes;
    let Ok(triangles) = how.triangles(&polygon[..polygon.len().min(8)], &settings) else { return };
    assert!(triangles.iter().flatten().all(|vertex| vertex.position.w > 0.0));
}

fuzz_target!(|data: &[u8]| {
    let bytes = &mut Bytes(data);
    match bytes.byte() % 4 {
        0 => mapping(bytes),
        1 => quad(bytes),
        2 => values(bytes),
        _ => subdivision(bytes),
    }
});
