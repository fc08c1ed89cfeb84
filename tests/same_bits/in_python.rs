//! The package for Python finds the same bits: `python/tests/test_same_bits.py` makes the same scene of whole numbers,
//! and expects the same hash.

use polyscan::render::{Product, Visibility, VisibilityRenderer};
use polyscan::{Mesh, Vertex};

/// Of all that is seen in the scene, here and in Python. What is right is for other tests to say.
const HASH: u64 = 0x1baf_3be8_f2c7_e3a4;

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

#[test]
fn what_is_seen_has_the_hash_that_python_expects() {
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
    let products = [Product::W, Product::Barycentrics, Product::Derivatives];
    let mut seen = Visibility::with_layers(101, 77, 2, &products).expect("a small picture");
    VisibilityRenderer::new(seen.viewport()).draw(&mut seen, Mesh::new(&vertices, &faces));
    let faces = seen.face.iter().map(|face| face.to_le_bytes());
    let floats = seen.w.iter().chain(seen.barycentrics.as_flattened());
    let floats = floats.chain(seen.derivatives.as_flattened().as_flattened());
    let found = hash(faces.chain(floats.map(|float| float.to_le_bytes())).flatten());
    assert_eq!(found, HASH, "{found:#x}");
}
