"""Against all faces at all pixels."""

from __future__ import annotations

import numpy as np
import pytest

import oracle
import polyscan
from scenes import check, check_depths, scene


def test_a_thousand_scenes_are_as_all_faces_at_all_pixels_say(rng: np.random.Generator) -> None:
    pixels = 0
    for _ in range(1000):
        vertices, faces, camera, size = scene(rng)
        seen = polyscan.rasterize(vertices, faces, camera, size, threads=1)
        view = camera.view(*size)
        clip = oracle.to_clip(vertices, view.clip_from_object)
        want = oracle.answer(clip, faces, *size)
        pixels += check(seen, want, faces, clip, view.is_reversed)
        check_depths(seen, vertices, faces, view.depth_row)
    assert pixels > 200_000, "the scenes show too little"


def test_faces_that_reach_behind_the_eye_are_cut_where_they_should_be(rng: np.random.Generator) -> None:
    """Sure pixels only: those whose centre is farther than 1/64 pixel from all edges."""
    pixels = 0
    for _ in range(300):
        vertices, faces, _, size = scene(rng)
        vertices = vertices * [4, 4, 12]
        camera = polyscan.Camera.perspective(rng.uniform(30, 100), near=0.5)
        seen = polyscan.rasterize(vertices, faces, camera, size)
        clip = oracle.to_clip(vertices, camera.matrix(*size))
        z, w, weights = oracle.planes(clip, faces, *size)
        is_inside = (weights >= 0).all(axis=-1) & (w >= 0.5)
        # How far edges are, by how fast weights change from pixel to pixel.
        slopes = [np.abs(np.gradient(part, axis=axis)) for part in (weights, w[..., None] / 0.5) for axis in (1, 2)]
        near = [np.abs(weights) < (slopes[0] + slopes[1]) / 16, np.abs(w[..., None] / 0.5 - 1) < (slopes[2] + slopes[3]) / 16]
        unsure = (near[0].any(axis=-1) | near[1][..., 0]).any(axis=0)
        nearest = np.where(is_inside, z, -np.inf).max(axis=0)
        sure = ~unsure
        assert np.array_equal((seen.face >= 0)[sure], is_inside.any(axis=0)[sure])
        y, x = np.nonzero(sure & (seen.face >= 0))
        assert (z[seen.face[y, x], y, x] >= nearest[y, x] * (1 - 1e-5)).all()
        assert np.allclose(seen.depth[y, x], w[seen.face[y, x], y, x], rtol=1e-5, atol=0)
        pixels += len(y)
    assert pixels > 20_000, "the scenes show too little"


@pytest.mark.parametrize("layers", [2, 4])
def test_layers_are_all_faces_in_their_order(rng: np.random.Generator, layers: int) -> None:
    for _ in range(60):
        vertices, faces, camera, size = scene(rng)
        seen = polyscan.rasterize(vertices, faces, camera, size, layers=layers)
        assert seen.face.shape == (size[1], size[0], layers)
        first = polyscan.rasterize(vertices, faces, camera, size)
        assert np.array_equal(seen.face[..., 0], first.face)
        assert np.array_equal(seen.depth[..., 0], first.depth)
        view = camera.view(*size)
        want = oracle.answer(oracle.to_clip(vertices, view.clip_from_object), faces, *size)
        assert np.array_equal((seen.face >= 0).sum(axis=-1), np.minimum(want.covers.sum(axis=0), layers))
        for y, x in zip(*np.nonzero(seen.face[..., 1] >= 0), strict=True):
            shown = [face for face in seen.face[y, x] if face >= 0]
            assert len(set(shown)) == len(shown) and want.covers[shown, y, x].all()
            depth = seen.depth[y, x, : len(shown)]
            assert (np.diff(depth) >= -1e-5 * np.abs(depth).max()).all()


def test_derivatives_are_those_of_the_planes(rng: np.random.Generator) -> None:
    for _ in range(60):
        vertices, faces, camera, size = scene(rng)
        seen = polyscan.rasterize(vertices, faces, camera, size, derivatives=True)
        clip = oracle.to_clip(vertices, camera.matrix(*size))
        # Differences of the same plane across a thousandth of a pixel, in a picture that is so much finer.
        x, y = oracle.centres(*size)
        face = np.maximum(seen.face, 0)
        corners = clip[faces[face]]

        def weights(dx: float, dy: float) -> np.ndarray:
            at = np.stack([x + dx * 2 / size[0], y - dy * 2 / size[1], np.ones_like(x)], axis=-1)
            columns = corners[..., [0, 1, 3]]
            areas = np.stack(
                [(np.cross(columns[..., j, :], columns[..., k, :]) * at).sum(-1) for j, k in ((1, 2), (2, 0), (0, 1))], -1
            )
            return areas / areas.sum(axis=-1, keepdims=True)

        step = 1e-3
        along_x = (weights(step, 0) - weights(-step, 0)) / (2 * step)
        along_y = (weights(0, step) - weights(0, -step)) / (2 * step)
        want = np.stack([along_x, along_y], axis=-1)
        shown = seen.face >= 0
        scale = np.abs(want[shown]).max(axis=(-1, -2), keepdims=True, initial=0)
        # Where a face is seen nearly edge on, differences say little.
        flat = scale[:, 0, 0] < 10
        error = np.abs(seen.derivatives[shown] - want[shown]) / np.maximum(scale, 1e-9)
        assert error[flat].max(initial=0) < 1e-4
        assert (seen.derivatives[~shown] == 0).all()
