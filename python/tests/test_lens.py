"""Lenses, against OpenCV's projection of the points that are seen."""

from __future__ import annotations

import numpy as np
import pytest

import polyscan
from conftest import sphere
from polyscan import Camera

SIZE = (320, 240)
K = np.array([[260.0, 0, 161.5], [0, 255, 118.2], [0, 0, 1]])
LENSES = [
    pytest.param([-0.28, 0.07, 0.001, -0.0005], False, id="barrel"),
    pytest.param([0.15, 0.05, -0.002, 0.001, 0.01], False, id="pincushion"),
    pytest.param([0.4, -0.1, 0.0005, 0.0002, 0.02, 0.6, 0.05, 0.01], False, id="rational"),
    pytest.param([0.02, -0.01, 0.003, -0.0005], True, id="fisheye"),
    pytest.param([0.0, 0, 0, 0], True, id="equidistant"),
]


def opencv(points: np.ndarray, coefficients: list[float], is_fisheye: bool) -> np.ndarray:
    cv2 = pytest.importorskip("cv2")
    zero = np.zeros(3)
    points = points.reshape(-1, 1, 3)
    if is_fisheye:
        return cv2.fisheye.projectPoints(points, zero, zero, K, np.array(coefficients))[0].reshape(-1, 2)
    return cv2.projectPoints(points, zero, zero, K, np.array(coefficients))[0].reshape(-1, 2)


def room() -> tuple[np.ndarray, np.ndarray]:
    """The inside of a box of 12 large triangles, around the camera and before it."""
    vertices = np.array([[x, y, z] for x in (-3, 3) for y in (-2, 2) for z in (-1.0, 5)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [1, 5, 7, 3], [0, 2, 6, 4]]
    faces = [[q[0], q[1], q[2]] for q in quads] + [[q[0], q[2], q[3]] for q in quads]
    return vertices, np.array(faces)


@pytest.mark.parametrize("bound", [0.5, 0.05])
@pytest.mark.parametrize(("coefficients", "is_fisheye"), LENSES)
def test_what_is_seen_is_where_opencv_projects_it(coefficients: list[float], is_fisheye: bool, bound: float) -> None:
    vertices, faces = room()
    camera = Camera.opencv(K, distortion=coefficients, fisheye=is_fisheye, lens_error=bound)
    seen = polyscan.rasterize(vertices, faces, camera, SIZE, derivatives=True)
    shown = seen.face >= 0
    assert shown.mean() > 0.97, "the room is all around"
    place = polyscan.interpolate(vertices, seen)
    assert np.abs(place[shown][:, 2] - seen.depth[shown]).max() < 1e-4
    y, x = np.nonzero(shown)
    error = np.linalg.norm(opencv(place[shown].astype(float), coefficients, is_fisheye) - np.stack([x, y], -1), axis=1)
    # Corners are rounded to 1/256 pixel as well.
    assert 1e-5 < error.max() < bound
    assert np.abs(seen.barycentrics[shown].sum(axis=-1) - 1).max() < 1e-5
    assert (seen.barycentrics[~shown] == 0).all() and (seen.depth[~shown] == 0).all()
    # Derivatives go with the neighbours.
    slope = polyscan.interpolate(vertices, seen, derivatives=True)
    same = shown[:, :-2] & (seen.face[:, 2:] == seen.face[:, :-2]) & (seen.face[:, 1:-1] == seen.face[:, 2:])
    centred = (place[:, 2:] - place[:, :-2]) / 2
    relative = np.linalg.norm(slope[:, 1:-1, :, 0] - centred, axis=-1) / np.linalg.norm(centred, axis=-1).clip(1e-6)
    assert np.median(relative[same]) < 0.02


@pytest.mark.parametrize(("coefficients", "is_fisheye"), LENSES)
def test_there_is_no_gap_between_parts(coefficients: list[float], is_fisheye: bool) -> None:
    vertices, faces = sphere(12)
    vertices = vertices + [0, 0, 2.2]
    camera = Camera.opencv(K, distortion=coefficients, fisheye=is_fisheye)
    seen = polyscan.rasterize(vertices, faces, camera, SIZE, cull="back", layers=2)
    inside = seen.face[..., 0] >= 0
    assert 0.1 < inside.mean() < 0.9
    # A convex body: no pixel shows two faces of its front, and none within the outline shows nothing.
    assert (seen.face[..., 1] == -1).all()
    for row in inside:
        x = np.nonzero(row)[0]
        assert len(x) == 0 or len(x) == x[-1] - x[0] + 1
    # The same pixels see the back.
    behind = polyscan.rasterize(vertices, faces, camera, SIZE, cull="front")
    assert np.array_equal(behind.face >= 0, inside)


def test_what_would_fold_back_is_not_shown() -> None:
    """A strong barrel: beyond some angle the polynomial turns back, and OpenCV's formula has far points in the picture."""
    coefficients = [-0.45, 0.0, 0, 0]
    # r (1 - 0.45 r^2) is greatest at r^2 = 1 / 1.35.
    reach = np.sqrt(1 / 1.35)
    far = np.array([[1.15, -0.3, 1], [1.4, -0.3, 1], [1.4, 0.3, 1], [1.15, 0.3, 1]]) * 2
    x, _ = opencv(far, coefficients, False).T
    assert x.min() < SIZE[0], "they would be seen"
    camera = Camera.opencv(K, distortion=coefficients)
    seen = polyscan.rasterize(far, [[0, 1, 2], [0, 2, 3]], camera, SIZE)
    assert (seen.face == -1).all()
    near = far * [0.5 * reach / 1.4, 1, 1]
    assert (polyscan.rasterize(near, [[0, 1, 2], [0, 2, 3]], camera, SIZE).face >= 0).any()


def test_without_coefficients_a_lens_is_a_pinhole() -> None:
    vertices, faces = room()
    plain = polyscan.rasterize(vertices, faces, Camera.opencv(K), SIZE)
    lens = polyscan.rasterize(vertices, faces, Camera.opencv(K, distortion=np.zeros(5)), SIZE)
    # The camera is within the room: what is cut at the picture's rim has corners that are rounded.
    assert (plain.face != lens.face).mean() < 2e-3
    same = plain.face == lens.face
    assert np.abs(lens.depth[same] / plain.depth[same] - 1).max() < 1e-3


def test_tiles_layers_and_batches_through_a_lens() -> None:
    vertices, faces = room()
    camera = Camera.opencv(K, distortion=[-0.2, 0.05, 0, 0])
    whole = polyscan.rasterize(vertices, faces, camera, SIZE, derivatives=True)
    part = polyscan.rasterize(vertices, faces, camera, SIZE, derivatives=True, tile=(37, 11, 100, 90))
    for name in ("face", "depth", "barycentrics", "derivatives"):
        assert np.array_equal(getattr(part, name), getattr(whole, name)[11:101, 37:137])
    two = polyscan.rasterize(vertices, faces, [camera, Camera.opencv(K)], SIZE)
    assert np.array_equal(two.face[0], whole.face) and not np.array_equal(two.face[1], whole.face)
    nothing = polyscan.rasterize(vertices - [0, 0, 100], faces, camera, SIZE)
    assert (nothing.face == -1).all() and (nothing.depth == 0).all()


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("distortion", lambda: Camera.opencv(K, distortion=[1, 2, 3])),
        ("distortion", lambda: Camera.opencv(K, distortion=[np.nan] * 4)),
        ("distortion", lambda: Camera.opencv(K, fisheye=True)),
        ("distortion", lambda: Camera.opencv(K, distortion=np.zeros(5), fisheye=True)),
        ("lens_error", lambda: Camera.opencv(K, distortion=np.zeros(4), lens_error=0)),
        (
            "faces",
            lambda: polyscan.rasterize(np.eye(4, 3), [[0, 1, 2, 3]], Camera.opencv(K, distortion=np.zeros(4)), SIZE),
        ),
        (
            "vertices",
            lambda: polyscan.rasterize(np.full((3, 3), np.inf), [[0, 1, 2]], Camera.opencv(K, distortion=np.zeros(4)), SIZE),
        ),
        ("camera", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], camera=Camera.opencv(K, distortion=np.zeros(4)))),
    ],
)
def test_what_is_wrong_is_named(name: str, call) -> None:
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        call()
