"""The same bits as in Rust: `tests/same_bits/in_python.rs` makes the same scene and has the same hashes."""

from __future__ import annotations

import pathlib
import re

import numpy as np
import pytest

import polyscan

RUST = pathlib.Path(__file__).parents[2] / "tests" / "same_bits" / "in_python.rs"


class Numbers:
    """Numbers from 0 to 1 in steps of 2^-24, by a linear congruential generator (Knuth's MMIX)."""

    state = 1

    def __call__(self) -> np.float32:
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return np.float32(self.state >> 40) / np.float32(2**24)


def fnv(data: bytes) -> int:
    total = 0xCBF29CE484222325
    for byte in data:
        total = (total ^ byte) * 0x100000001B3 % 2**64
    return total


@pytest.mark.parametrize(("name", "how"), [("HASH", {"layers": 2}), ("HASH_OF_SAMPLES", {"samples": 8})])
def test_what_is_seen_has_the_hash_that_rust_expects(name: str, how: dict) -> None:
    if not RUST.exists():
        pytest.skip("only beside the Rust library's tests")
    want = int(re.search(rf"const {name}: u64 = (0x[0-9a-f_]+);", RUST.read_text())[1].replace("_", ""), 16)
    number = Numbers()
    one, two, half = np.float32(1), np.float32(2), np.float32(0.5)
    vertices = []
    for _ in range(60):
        x, y, z, w = (number() for _ in range(4))
        w = w + half
        vertices.append([(two * x - one) * w, (two * y - one) * w, z * w, w])
    faces = [[int(number() * np.float32(60)) for _ in range(3)] for _ in range(80)]
    vertices = np.array(vertices)
    assert vertices.dtype == np.float32
    for threads in (1, 2, 5):
        seen = polyscan.rasterize(vertices, faces, None, (101, 77), derivatives=True, threads=threads, **how)
        parts = (seen.face, seen.depth, seen.barycentrics, seen.derivatives)
        assert fnv(b"".join(part.tobytes() for part in parts)) == want
