//! The package for Python finds the same bits: `python/tests/test_same_bits.py` makes the same scene of whole numbers,
//! and expects the same hash.

use polyscan::render::{Product, Samples, Visibility, VisibilityRenderer};
use polyscan::{Mesh, Vertex};

/// Of all that is seen in the scene, here and in Python. What is right is for other tests to say.
const HASH: u64 = 0x1baf_3be8_f2c7_e3a4;

/// The same at 8 samples a pixel.
const HASH_OF_SAMPLES: u64 = 0xcd4f_9abd_0e35_99d3;

const PRODUCTS: [Product; 3] = [Product::W, Product::Barycentrics, Product::Derivatives];

/// Numbers from 0 to 1 in steps of 2^-24, by a linear congruential generator (Knuth's MMIX).
fn number(state: &mut u64) -> f32 {
    const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
    const INCREMENT: u64 = 1_442_695_040_888_963_407;
    *state = state.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
    (*state >> 40) as f32 / 16_777_216.0
}

/// The hash of bytes by Fowler, Noll and Vo (FNV-1a, 64 bits).
fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    const PRIME: u64 = 0x100_0000_01b3;
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

/// The hash of all that a buffer shows of the scene.
fn hash_of(seen: &mut Visibility) -> u64 {
    let mut state = 1;
    let vertices: Vec<_> = (0..60)
        .map(|_| {
            let [x, y, z, w] = [(); 4].map(|()| number(&mut state));
            let w = w + 0.5;
            Vertex::new([(2.0 * x - 1.0) * w, (2.0 * y - 1.0) * w, z * w, w].into(), [])
        })
        .collect();
    let faces: Vec<[u32; 3]> =
        (0..80).map(|_| [(); 3].map(|()| (number(&mut state) * 60.0) as u32)).collect();
    VisibilityRenderer::new(seen.viewport()).draw(seen, Mesh::new(&vertices, &faces));
    let faces = seen.face.iter().map(|face| face.to_le_bytes());
    let floats = seen.w.iter().chain(seen.barycentrics.as_flattened());
    let floats = floats.chain(seen.derivatives.as_flattened().as_flattened());
    hash(faces.chain(floats.map(|float| float.to_le_bytes())).flatten())
}

#[test]
fn what_is_seen_has_the_hash_that_python_expects() {
    let mut seen = Visibility::with_layers(101, 77, 2, &PRODUCTS).expect("a small picture");
    let found = hash_of(&mut seen);
    assert_eq!(found, HASH, "{found:#x}");
}

#[test]
fn what_is_seen_at_samples_has_the_hash_that_python_expects() {
    let seen = Visibility::with_samples(101, 77, Samples::Eight, &PRODUCTS);
    let found = hash_of(&mut seen.expect("a small picture"));
    assert_eq!(found, HASH_OF_SAMPLES, "{found:#x}");
}
