"""Baking: each texel that a face touches, by separating axes in f64."""

from __future__ import annotations

import numpy as np
import pytest

import polyscan
from conftest import sphere


def touched(uv: np.ndarray, faces: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """By how much, in texels, the axis that parts each face (m) and texel (height, width) best parts them: below 0 they
    overlap. In two dimensions those are the normals of the sides of both (the theorem of the separating axis)."""
    width, height = size
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    gap = np.empty((len(faces), height, width))
    for i, corners in enumerate(uv[faces] * size):
        best = np.full((height, width), -np.inf)
        sides = np.roll(corners, -1, axis=0) - corners
        for normal in [[1.0, 0.0], [0.0, 1.0], *np.stack([-sides[:, 1], sides[:, 0]], axis=1)]:
            normal = np.asarray(normal)
            length = np.linalg.norm(normal)
            if length < 1e-9:
                continue
            along = corners @ normal / length
            centre = (x * normal[0] + y * normal[1]) / length
            reach = np.abs(normal).sum() / length / 2
            best = np.maximum(best, np.maximum(along.min() - centre, centre - along.max()) - reach)
        gap[i] = best
    return gap


def test_no_texel_that_a_face_touches_is_missed(rng: np.random.Generator) -> None:
    texels = 0
    for _ in range(100):
        size = int(rng.integers(4, 40)), int(rng.integers(4, 40))
        uv = rng.uniform(-0.1, 1.1, (12, 2))
        faces = np.array([rng.choice(12, 3, replace=False) for _ in range(int(rng.integers(1, 6)))])
        baked = polyscan.bake(uv, faces, size, margin=0)
        gap = touched(uv, faces, size)
        # Corners are rounded to 1/256 texel.
        sure = gap.min(axis=0) < -1 / 64
        assert baked.is_covered[sure].all()
        assert not baked.is_covered[gap.min(axis=0) > 1 / 64].any()
        assert np.array_equal(baked.face >= 0, baked.is_covered)
        y, x = np.nonzero(baked.is_covered)
        assert (gap[baked.face[y, x], y, x] < 1 / 64).all()
        # The place on the face is the nearest to the texel's centre: no farther than the texel's corners.
        place = polyscan.interpolate(uv, baked)[y, x] * size - np.stack([x, y], axis=-1)
        weights = baked.barycentrics[y, x]
        assert (weights >= 0).all() and np.abs(weights.sum(axis=-1) - 1).max() < 1e-5
        assert np.linalg.norm(place - 0.5, axis=-1).max() < np.sqrt(0.5) + 1 / 32
        texels += len(y)
    assert texels > 10_000


def test_attributes_are_at_the_texels_that_filters_read() -> None:
    """A ball is baked with its places; sampled where the camera sees it, the texture has the places that are seen."""
    rings = 16
    u, v = np.meshgrid(np.linspace(0.02, 0.98, 2 * rings + 1), np.linspace(0.02, 0.98, rings + 1))
    longitude, latitude = 2 * np.pi * (u - 0.02) / 0.96, np.pi * (v - 0.02) / 0.96
    points = np.stack(
        [np.sin(latitude) * np.cos(longitude), np.cos(latitude), -np.sin(latitude) * np.sin(longitude)], axis=-1
    ).reshape(-1, 3)
    uv = np.stack([u, v], axis=-1).reshape(-1, 2)
    corner = np.arange(u.size).reshape(u.shape)
    quads = np.stack([corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    baked = polyscan.bake(uv, faces, (256, 128))
    assert len(baked.overlaps) == 0
    assert baked.is_covered.mean() > 0.9 and (baked.face >= 0).sum() > baked.is_covered.sum()
    texture = polyscan.interpolate(points, baked)
    seen = polyscan.rasterize(points, faces, polyscan.Camera.around(points), (200, 200))
    got = polyscan.texture(texture, polyscan.interpolate(uv, seen), wrap="clamp")
    shown = seen.face >= 0
    error = np.linalg.norm(got - polyscan.interpolate(points, seen), axis=-1)[shown]
    # A texel is 1/40 wide; creases of the ball are rounded by the filter.
    assert error.max() < 0.02 and np.median(error) < 2e-3
    # With corners of its own, counted apart.
    own = faces[:, ::-1]
    other = polyscan.bake(uv[::-1], len(uv) - 1 - faces, (256, 128))
    assert np.array_equal(other.face, baked.face)
    assert np.allclose(polyscan.interpolate(points, other, faces), texture, atol=1e-6)
    assert own.shape == faces.shape


def test_overlaps_are_reported() -> None:
    uv = np.array([[0.1, 0.1], [0.6, 0.1], [0.1, 0.6], [0.3, 0.3], [0.9, 0.3], [0.3, 0.9]])
    baked = polyscan.bake(uv, [[0, 1, 2], [3, 4, 5]], (100, 100))
    # The first covers all with u + v below 0.7, the second from 0.3 on: a triangle with sides of 10 texels.
    ((first, second, texels),) = baked.overlaps.tolist()
    assert (first, second) == (0, 1) and 30 <= texels <= 60
    assert baked.face[31, 31] == 0


def test_the_margin_is_as_wide_as_asked_for() -> None:
    uv = np.array([[0.41, 0.41], [0.59, 0.41], [0.59, 0.59], [0.41, 0.59]])
    for margin in (0, 1, 5):
        baked = polyscan.bake(uv, [[0, 1, 2], [0, 2, 3]], (50, 50), margin=margin)
        assert (baked.face >= 0).any(axis=0).sum() == 10 + 2 * margin
        values = polyscan.interpolate(uv[:, 0], baked, background=-1)
        assert (values[baked.face >= 0] > 0.39).all() and (values[baked.face < 0] == -1).all()


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("uv", lambda: polyscan.bake(np.zeros((3, 3)), [[0, 1, 2]], (4, 4))),
        ("uv", lambda: polyscan.bake(np.full((3, 2), np.nan), [[0, 1, 2]], (4, 4))),
        ("faces", lambda: polyscan.bake(np.zeros((3, 2)), [[0, 1, 3]], (4, 4))),
        ("faces", lambda: polyscan.bake(np.zeros((4, 2)), [[0, 1, 2, 3]], (4, 4))),
        ("size", lambda: polyscan.bake(np.zeros((3, 2)), [[0, 1, 2]], (0, 4))),
        ("margin", lambda: polyscan.bake(np.zeros((3, 2)), [[0, 1, 2]], (4, 4), margin=-1)),
        ("seen", lambda: polyscan.interpolate(np.eye(3), polyscan.bake(*_SMALL), derivatives=True)),
    ],
)
def test_what_is_wrong_is_named(name: str, call) -> None:
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        call()


_SMALL = (np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2]]), (8, 8))


def test_nothing_and_a_ball_in_a_small_texture() -> None:
    assert (polyscan.bake(np.zeros((0, 2)), np.zeros((0, 3), int), (4, 4)).face == -1).all()
    vertices, faces = sphere(40)
    # All charts in 16 x 16 texels: each is smaller than a texel, none is missed.
    baked = polyscan.bake(0.5 + 0.4 * vertices[:, :2], faces, (16, 16), margin=0)
    x, y = np.meshgrid(np.arange(16) + 0.5, np.arange(16) + 0.5)
    # The texel's nearest point to the middle of the disc.
    near = np.hypot(np.maximum(np.abs(x - 8) - 0.5, 0), np.maximum(np.abs(y - 8) - 0.5, 0))
    assert baked.is_covered[near < 6.38].all() and not baked.is_covered[near > 6.42].any()
