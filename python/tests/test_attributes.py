"""Attributes and textures at pixels, against f64."""

from __future__ import annotations

import numpy as np
import pytest

import polyscan
from conftest import rotation, sphere
from polyscan import Camera, Texture


def floor() -> tuple[np.ndarray, np.ndarray, Camera]:
    """A floor that goes to the horizon: vertices, faces, camera."""
    grid = np.stack(np.meshgrid(np.linspace(-20, 20, 9), np.linspace(0.4, 24, 7), indexing="ij"), -1).reshape(-1, 2)
    vertices = np.stack([grid[:, 0], np.full(63, 0.8), grid[:, 1]], axis=1)
    index = np.arange(63).reshape(9, 7)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return vertices, faces, Camera.perspective(60)


def test_what_is_linear_in_space_is_so_at_pixels(rng: np.random.Generator) -> None:
    vertices, faces, camera = floor()
    seen = polyscan.rasterize(vertices, faces, camera, (320, 240), derivatives=True)
    matrix = rng.normal(size=(3, 5))
    values = vertices @ matrix + rng.normal(size=5)
    place = polyscan.interpolate(vertices, seen)
    got = polyscan.interpolate(values, seen, background=-7)
    shown = seen.face >= 0
    assert shown.mean() > 0.4
    assert np.abs(got - (place @ matrix + values[0] - vertices[0] @ matrix))[shown].max() < 1e-5 * np.abs(values).max()
    assert (got[~shown] == -7).all()
    # Places are where the pixels' centres see them.
    clip = np.concatenate([place, np.ones_like(place[..., :1])], axis=-1)[shown] @ camera.matrix(320, 240).T
    x, y = (clip[:, 0] / clip[:, 3] + 1) * 160, (1 - clip[:, 1] / clip[:, 3]) * 120
    v, u = np.nonzero(shown)
    error = np.maximum(np.abs(x - u - 0.5), np.abs(y - v - 0.5))
    # Weights within the face, where its rounded edge passes by a centre on the other side: the flatter, the farther.
    assert np.quantile(error, 0.98) < 1e-4 and error.max() < 0.05
    # Derivatives against those of the plane of depth: differences of neighbours on one and the same plane.
    slope = polyscan.interpolate(vertices[:, 0], seen, derivatives=True)
    assert slope.shape == (240, 320, 2)
    inner = shown[:, :-2] & shown[:, 1:-1] & shown[:, 2:]
    centred = (place[:, 2:, 0] - place[:, :-2, 0]) / 2
    error = np.abs(slope[:, 1:-1, 0] - centred)[inner] / np.abs(centred[inner])
    assert np.quantile(error, 0.98) < 1e-4 and error.max() < 0.05


def test_attributes_may_have_corners_of_their_own() -> None:
    vertices, faces = sphere(6)
    seen = polyscan.rasterize(vertices, faces, Camera.around(vertices), (64, 64))
    apart = vertices[faces].reshape(-1, 3)
    own = np.arange(len(apart)).reshape(-1, 3)
    assert np.array_equal(polyscan.interpolate(apart, seen, own), polyscan.interpolate(vertices, seen))
    flat = polyscan.interpolate(vertices[:, 1], seen)
    assert np.array_equal(flat, polyscan.interpolate(vertices, seen)[..., 1])


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("attributes", lambda v, seen: polyscan.interpolate(v[:5], seen)),
        ("attributes", lambda v, seen: polyscan.interpolate(v[None], seen)),
        ("attributes", lambda v, seen: polyscan.interpolate("v", seen)),
        ("seen", lambda v, seen: polyscan.interpolate(v, seen, derivatives=True)),
        ("faces", lambda v, seen: polyscan.interpolate(v, seen, [[0, 1, 2]])),
        ("uv", lambda v, seen: polyscan.texture(np.zeros((2, 2)), v)),
        ("derivatives", lambda v, seen: polyscan.texture(np.zeros((2, 2)), v[:, :2], v[:, :2])),
        ("picture", lambda v, seen: Texture(np.zeros((2, 2, 5)))),
        ("picture", lambda v, seen: Texture(np.zeros((0, 2)))),
        ("picture", lambda v, seen: Texture(np.zeros((2, 2), np.int64))),
        ("colors", lambda v, seen: Texture(np.zeros((2, 2)), colors="srgb")),
        ("filter", lambda v, seen: Texture(np.zeros((2, 2)), filter="cubic")),
        ("mip_filter", lambda v, seen: Texture(np.zeros((2, 2)), mip_filter="all")),
        ("most", lambda v, seen: Texture(np.zeros((2, 2)), most=65)),
        ("wrap", lambda v, seen: Texture(np.zeros((2, 2)), wrap="tile")),
        ("border", lambda v, seen: Texture(np.zeros((2, 2)), border=(1, 2))),
        ("level_range", lambda v, seen: Texture(np.zeros((2, 2)), level_range=3)),
    ],
)
def test_what_is_wrong_is_named(name: str, call) -> None:
    vertices, faces = sphere(6)
    seen = polyscan.rasterize(vertices, faces, Camera.around(vertices), (8, 8))
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        call(vertices, seen)


def light(codes: np.ndarray) -> np.ndarray:
    """Linear light of sRGB codes from 0 to 1 (IEC 61966-2-1)."""
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def wrapped(index: np.ndarray, size: int, wrap: str) -> np.ndarray:
    if wrap == "repeat":
        return index % size
    if wrap == "clamp":
        return index.clip(0, size - 1)
    phase = index % (2 * size)
    return np.minimum(phase, 2 * size - 1 - phase)


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_bilinear_and_nearest_by_their_definitions(rng: np.random.Generator, channels: int, wrap: str) -> None:
    picture = rng.random((5, 7, channels), np.float32)
    uv = rng.uniform(-2, 3, (1000, 2)).astype(np.float32)
    x, y = uv[:, 0].astype(float) * 7 - 0.5, uv[:, 1].astype(float) * 5 - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - left)[:, None], (y - top)[:, None]

    def texel(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return picture[wrapped(j, 5, wrap), wrapped(i, 7, wrap)]

    above = texel(left, top) * (1 - fx) + texel(left + 1, top) * fx
    below = texel(left, top + 1) * (1 - fx) + texel(left + 1, top + 1) * fx
    got = polyscan.texture(picture, uv, wrap=wrap)
    assert got.shape == (1000, channels)
    assert np.abs(got - (above * (1 - fy) + below * fy)).max() < 1e-5
    near = polyscan.texture(picture, uv, filter="nearest", wrap=wrap)
    sure = (np.abs(x - np.rint(x)) < 0.49) & (np.abs(y - np.rint(y)) < 0.49)
    want = texel(np.floor(x + 0.5).astype(int), np.floor(y + 0.5).astype(int))
    assert np.array_equal(near[sure], want[sure])


def test_pictures_are_srgb_unless_told_otherwise() -> None:
    codes = np.arange(256, dtype=np.uint8).reshape(16, 16)
    u, v = np.meshgrid((np.arange(16) + 0.5) / 16, (np.arange(16) + 0.5) / 16)
    uv = np.stack([u, v], axis=-1)
    got = polyscan.texture(codes, uv, filter="nearest")[..., 0]
    assert np.abs(got - light(codes / 255)).max() < 1e-6
    numbers = polyscan.texture(codes, uv, filter="nearest", colors="linear")[..., 0]
    assert np.abs(numbers - codes / 255).max() < 1e-6
    halves = polyscan.texture((codes / 255).astype(np.float16), uv, filter="nearest")[..., 0]
    assert np.array_equal(halves, (codes / 255).astype(np.float16).astype(np.float32))
    words = polyscan.texture(codes.astype(np.uint16) * 257, uv, filter="nearest", colors="linear")[..., 0]
    assert np.abs(words - codes / 255).max() < 1e-6
    assert (polyscan.texture(codes, uv + 1, wrap="border", border=(0.5, 0, 0, 1)) == 0.5).all()


@pytest.mark.parametrize("mip_filter", ["nearest", "linear", "anisotropic", "ewa"])
def test_a_fine_checkerboard_far_away_is_grey(mip_filter: str) -> None:
    vertices, faces, camera = floor()
    seen = polyscan.rasterize(vertices, faces, camera, (160, 120), derivatives=True)
    uv = vertices[:, [0, 2]]
    board = (np.add.outer(np.arange(64), np.arange(64)) % 2).astype(np.float32)
    at, sides = polyscan.interpolate(uv, seen), polyscan.interpolate(uv, seen, derivatives=True)
    texture = Texture(board, mip_filter=mip_filter)
    got = texture.sample(at, sides)[..., 0]
    far = (seen.face >= 0) & (np.abs(sides).max(axis=(-1, -2)) * 64 > 40)
    assert far.mean() > 0.05
    assert np.abs(got[far] - 0.5).max() < 0.02
    assert np.array_equal(polyscan.texture(texture, at, sides, threads=1), texture.sample(at, sides, threads=2))
    aliased = polyscan.texture(board, at, sides, mip_filter="off")[..., 0]
    assert aliased[far].std() > 0.1


def test_rotations_are_rotations(rng: np.random.Generator) -> None:
    turn = rotation(rng)
    assert np.allclose(turn @ turn.T, np.eye(3)) and np.isclose(np.linalg.det(turn), 1)
