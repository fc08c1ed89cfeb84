"""Several samples a pixel: each is to the oracle what a pixel's centre is."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import oracle
import polyscan
from conftest import sphere
from polyscan import Camera
from scenes import check, check_depths, scene

#: In 16ths of a pixel: the standard multisample patterns of the Direct3D 11.3 functional specification, 19.2.4.1.
STANDARD = {
    1: [(0, 0)],
    4: [(-2, -6), (6, -2), (-6, 2), (2, 6)],
    8: [(1, -3), (-1, 3), (5, 1), (-3, -5), (-5, 5), (-7, -1), (3, 7), (7, -7)],
    16: [
        *((1, 1), (-1, -3), (-3, 2), (4, -1), (-5, -2), (2, 5), (5, 3), (3, -5)),
        *((-2, 6), (0, -7), (-4, -6), (-6, 4), (-8, 0), (7, -4), (6, 7), (-7, -8)),
    ],
}
NAMES = ("face", "depth", "barycentrics", "derivatives")


def at(seen: polyscan.Seen, sample: int) -> polyscan.Seen:
    """What one sample of each pixel sees."""
    arrays = {name: getattr(seen, name) for name in NAMES}
    return dataclasses.replace(seen, **{name: array[:, :, sample] for name, array in arrays.items() if array is not None})


@pytest.mark.parametrize("samples", [1, 4, 8, 16])
def test_places_are_the_standard_ones(samples: int) -> None:
    assert np.array_equal(polyscan.sample_places(samples), np.array(STANDARD[samples]) / 16)


@pytest.mark.parametrize("samples", [4, 8, 16])
def test_each_sample_is_as_all_faces_at_its_place_say(rng: np.random.Generator, samples: int) -> None:
    seen_samples, at_edges = 0, 0
    for _ in range(1000 // samples):
        vertices, faces, camera, size = scene(rng)
        seen = polyscan.rasterize(vertices, faces, camera, size, samples=samples)
        assert seen.face.shape == (size[1], size[0], samples) and seen.barycentrics.shape == (*seen.face.shape, 3)
        view = camera.view(*size)
        clip = oracle.to_clip(vertices, view.clip_from_object)
        for sample, (right, below) in enumerate(STANDARD[samples]):
            want = oracle.answer(clip, faces, *size, (right / 16, below / 16))
            one = at(seen, sample)
            seen_samples += check(one, want, faces, clip, view.is_reversed)
            check_depths(one, vertices, faces, view.depth_row)
        at_edges += int((seen.face != seen.face[..., :1]).any(axis=-1).sum())
    assert seen_samples > 80_000 and at_edges > 3_000, "the scenes show too little"


@pytest.mark.parametrize("samples", [4, 8, 16])
def test_derivatives_are_those_of_the_planes_at_samples(rng: np.random.Generator, samples: int) -> None:
    for _ in range(6):
        vertices, faces, camera, size = scene(rng)
        seen = polyscan.rasterize(vertices, faces, camera, size, derivatives=True, samples=samples)
        clip = oracle.to_clip(vertices, camera.matrix(*size))
        for sample, (right, below) in enumerate(STANDARD[samples]):
            one = at(seen, sample)
            step = 1e-3
            moved = [(step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)]
            weights = [oracle.planes(clip, faces, *size, (right / 16 + dx, below / 16 + dy))[2] for dx, dy in moved]
            y, x = np.nonzero(one.face >= 0)
            face = one.face[y, x]
            slopes = [(weights[i][face, y, x] - weights[i + 1][face, y, x]) / (2 * step) for i in (0, 2)]
            want = np.stack(slopes, axis=-1)
            scale = np.abs(want).max(axis=(-1, -2), initial=0)
            error = np.abs(one.derivatives[y, x] - want).max(axis=(-1, -2)) / np.maximum(scale, 1e-9)
            # Where a face is seen nearly edge on, differences say little.
            assert error[scale < 10].max(initial=0) < 1e-4


def area(polygon: np.ndarray, left: float, top: float) -> float:
    """The area of a convex polygon within a pixel, cut side by side (Sutherland and Hodgman)."""
    points = [tuple(point) for point in polygon]
    for axis, sign, bound in ((0, 1, left), (0, -1, left + 1), (1, 1, top), (1, -1, top + 1)):
        kept = []
        for a, b in zip(points, points[1:] + points[:1], strict=True):
            da, db = sign * (a[axis] - bound), sign * (b[axis] - bound)
            if da >= 0:
                kept.append(a)
            if (da < 0) != (db < 0):
                t = da / (da - db)
                kept.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))
        points = kept
    x, y = np.array(points).reshape(-1, 2).T
    return abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))) / 2


@pytest.mark.parametrize(("samples", "spread"), [(1, 0.35), (4, 0.11), (8, 0.075), (16, 0.06)])
def test_the_share_of_samples_is_near_to_the_area(rng: np.random.Generator, samples: int, spread: float) -> None:
    errors = []
    for _ in range(30):
        corners = rng.uniform(1, 23, (3, 2))
        clip = np.concatenate([corners / 12 * [1, -1] + [-1, 1], np.tile([0.5, 1.0], (3, 1))], axis=1)
        seen = polyscan.rasterize(clip, [[0, 1, 2]], None, (24, 24), samples=samples)
        share = (seen.face >= 0).reshape(24, 24, samples).mean(axis=-1)
        true = np.array([[area(corners, x, y) for x in range(24)] for y in range(24)])
        errors.extend((share - true)[(true > 0.01) & (true < 0.99)])
    # A centre alone errs by 0.29 at edges (evenly from -0.5 to 0.5); samples by about 1 / (3 sqrt(samples)) of that square.
    assert len(errors) > 500 and np.std(errors) < spread and abs(np.mean(errors)) < spread / 5


def test_what_is_interpolated_at_samples_has_edges_without_steps() -> None:
    vertices, faces = sphere(10)
    camera = Camera.around(vertices)
    seen = polyscan.rasterize(vertices, faces, camera, (60, 50), samples=16)
    place = polyscan.interpolate(vertices, seen)
    assert place.shape == (50, 60, 16, 3)
    shown = seen.face >= 0
    # Each sample is where its own ray meets the ball.
    pixel = np.stack(np.meshgrid(np.arange(60), np.arange(50)), axis=-1)[:, :, None] + 0.5 + polyscan.sample_places(16)
    clip = np.concatenate([place, np.ones_like(place[..., :1])], axis=-1) @ camera.matrix(60, 50).T
    at = np.stack([(clip[..., 0] / clip[..., 3] + 1) * 30, (1 - clip[..., 1] / clip[..., 3]) * 25], axis=-1)
    error = np.abs(at - pixel)[shown].max(axis=-1)
    assert np.quantile(error, 0.99) < 1e-4 and error.max() < 0.05
    light = polyscan.interpolate(np.ones(len(vertices)), seen).mean(axis=-1)
    assert np.abs(light - shown.mean(axis=-1)).max() < 1e-6
    assert ((light > 0) & (light < 1)).sum() > 50


@pytest.mark.parametrize("samples", [1, 4, 8, 16])
def test_tiles_threads_batches_and_polygons(samples: int) -> None:
    vertices, faces = sphere(20)
    camera = Camera.around(vertices)
    how = {"samples": samples, "derivatives": True}
    whole = polyscan.rasterize(vertices, faces, camera, (70, 50), **how)
    part = polyscan.rasterize(vertices, faces, camera, (70, 50), tile=(31, 7, 20, 11), **how)
    alone = polyscan.rasterize(vertices, faces, camera, (70, 50), threads=1, **how)
    many = polyscan.rasterize(np.stack([vertices, vertices / 2]), faces, camera, (70, 50), **how)
    for name in NAMES:
        assert np.array_equal(getattr(part, name), getattr(whole, name)[7:18, 31:51]), name
        assert np.array_equal(getattr(alone, name), getattr(whole, name)), name
        assert np.array_equal(getattr(many, name)[0], getattr(whole, name)), name
    square = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    seen = polyscan.rasterize(square, [[0, 1, 2, 3]], Camera.around(square, yaw=0, pitch=0), (9, 7), samples=samples)
    shown = seen.face == 0
    assert shown.any() and np.array_equal(seen.corners.shape[:-1], seen.face.shape)
    assert np.abs(polyscan.interpolate(square, seen)[shown][:, 2]).max() == 0
    with pytest.raises(ValueError, match="^attributes"):
        polyscan.interpolate(np.zeros((len(seen.face), 4, 2)), seen)


def test_a_lens_bends_samples_as_well(rng: np.random.Generator) -> None:
    cv2 = pytest.importorskip("cv2")
    vertices = np.array([[-3.0, -2, 4], [3, -2, 4], [3, 2, 5], [-3, 2, 5]])
    faces = [[0, 1, 2], [0, 2, 3]]
    K = np.array([[130.0, 0, 80.5], [0, 128, 60.2], [0, 0, 1]])
    coefficients = np.array([-0.28, 0.07, 0.001, -0.0005])
    camera = Camera.opencv(K, distortion=coefficients, lens_error=0.05)
    seen = polyscan.rasterize(vertices, faces, camera, (160, 120), samples=4)
    y, x, sample = np.nonzero(seen.face >= 0)
    place = polyscan.interpolate(vertices, seen)[y, x, sample].astype(float)
    want = np.stack([x, y], axis=-1) + polyscan.sample_places(4)[sample]
    got = cv2.projectPoints(place.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), K, coefficients)[0].reshape(-1, 2)
    error = np.linalg.norm(got - want, axis=1)
    assert len(error) > 20_000 and error.max() < 0.05


@pytest.mark.parametrize("samples", [0, 2, 3, 5, 17, -4, 4.5, "4", None])
def test_other_numbers_of_samples_are_refused(samples) -> None:
    for call in (
        lambda: polyscan.rasterize(np.eye(3), [[0, 1, 2]], Camera.perspective(40), (4, 4), samples=samples),
        lambda: polyscan.sample_places(samples),
    ):
        with pytest.raises(ValueError, match=r"^samples\b"):
            call()
    with pytest.raises(ValueError, match=r"^layers\b"):
        polyscan.rasterize(np.eye(3), [[0, 1, 2]], Camera.perspective(40), (4, 4), samples=4, layers=2)


@pytest.mark.parametrize("how", [{}, {"samples": 4}, {"layers": 2}])
def test_many_faces_are_drawn_in_parts(how: dict) -> None:
    """Faces are drawn a million at a time: two balls that cross, with a million faces without area between them, look as they
    do without these."""
    vertices, faces = sphere(30)
    both = np.concatenate([vertices, vertices * [0.8, 1.2, 0.8]])
    behind = faces + len(vertices)
    nothing = np.zeros((1_100_000, 3), int)
    camera = Camera.around(both)
    want = polyscan.rasterize(both, np.concatenate([faces, behind]), camera, (90, 70), derivatives=True, **how)
    many = np.concatenate([faces, nothing, behind]).astype(np.int32)
    got = polyscan.rasterize(both, many, camera, (90, 70), derivatives=True, **how)
    assert np.array_equal(np.where(want.face >= len(faces), want.face + len(nothing), want.face), got.face)
    assert (got.face >= len(faces)).mean() > 0.05 and ((got.face >= 0) & (got.face < len(faces))).mean() > 0.05
    for name in ("depth", "barycentrics", "derivatives"):
        assert np.array_equal(getattr(got, name), getattr(want, name)), name
