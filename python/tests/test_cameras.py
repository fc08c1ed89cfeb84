"""Cameras, against what they are by definition, and against OpenCV."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import polyscan
from conftest import rotation
from polyscan import Camera

WIDTH, HEIGHT = 640, 480
K = np.array([[600.0, 0, 322.4], [0, 590, 236.1], [0, 0, 1]])


def pixels(camera: Camera, points: np.ndarray, size: tuple[int, int] = (WIDTH, HEIGHT)) -> np.ndarray:
    """Where points are seen, in pixels from the picture's outer edges, by the camera's matrix."""
    clip = np.concatenate([points, np.ones((len(points), 1))], axis=1) @ camera.matrix(*size).T
    x, y = (clip[:, :2] / clip[:, 3:]).T
    return np.stack([(x + 1) / 2 * size[0], (1 - y) / 2 * size[1]], axis=-1)


def test_points_are_where_opencv_projects_them(rng: np.random.Generator) -> None:
    cv2 = pytest.importorskip("cv2")
    for _ in range(50):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation(rng), [*rng.uniform(-1, 1, 2), 6]
        points = rng.uniform(-1, 1, (100, 3))
        want, _ = cv2.projectPoints(points, cv2.Rodrigues(pose[:3, :3])[0], pose[:3, 3], K, None)
        # OpenCV counts from the centre of the first pixel, which is half a pixel from the picture's edge.
        assert np.abs(pixels(Camera.opencv(K, pose), points) - 0.5 - want[:, 0]).max() < 1e-9


def test_a_rectangle_covers_the_pixels_whose_centres_opencv_puts_in_it() -> None:
    left, right, top, bottom, z = 100, 139, 50, 79, 2.0
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], float)
    corners += np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * 0.9
    vertices = np.concatenate([corners, np.ones((4, 1))], axis=1) @ np.linalg.inv(K).T * z
    seen = polyscan.rasterize(vertices, [[0, 1, 2, 3]], Camera.opencv(K), (WIDTH, HEIGHT))
    want = np.full((HEIGHT, WIDTH), -1)
    want[top : bottom + 1, left : right + 1] = 0
    assert np.array_equal(seen.face, want)
    # Counted from edges, the same numbers are half a pixel to the left and above.
    colmap = Camera.opencv(K, pixel_center=0.5)
    shifted = polyscan.rasterize(vertices, [[0, 1, 2, 3]], colmap, (WIDTH, HEIGHT))
    assert np.abs(pixels(colmap, vertices) - corners).max() < 1e-9
    assert np.nonzero((shifted.face == 0).any(axis=0))[0][[0, -1]].tolist() == [left, right - 1]


def test_depth_is_that_of_the_plane_in_metres(rng: np.random.Generator) -> None:
    for _ in range(10):
        normal = rotation(rng)[0]
        normal[2] = np.sign(normal[2]) * max(abs(normal[2]), 0.4)
        distance = 3 * abs(normal[2])
        # A plane of 6 m around the point where the camera's axis meets it.
        right = np.cross(normal, [0, 1, 0])
        right /= np.linalg.norm(right)
        down = np.cross(normal, right)
        centre = np.array([0, 0, distance / abs(normal[2])])
        corners = [centre + 6 * (a * right + b * down) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        seen = polyscan.rasterize(np.array(corners), [[0, 1, 2, 3]], Camera.opencv(K), (WIDTH, HEIGHT))
        u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
        rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(K).T
        want = (normal @ centre) / (rays @ normal)
        shown = seen.face >= 0
        assert shown.mean() > 0.3
        # At the rim the centre of a pixel may be 1/256 pixel outside, where the depth is that of the rim.
        inner = shown[1:-1, 1:-1] & shown[2:, 1:-1] & shown[:-2, 1:-1] & shown[1:-1, 2:] & shown[1:-1, :-2]
        error = np.abs(seen.depth / want - 1)
        assert error[1:-1, 1:-1][inner].max() < 1e-6
        assert error[shown].max() < 1e-4


def test_depth_is_in_the_unit_of_the_vertices(rng: np.random.Generator) -> None:
    pose = polyscan.look_at([1, 2, 5], [0, 0, 0])
    vertices, faces = rng.uniform(-1, 1, (30, 3)), rng.integers(0, 30, (20, 3))
    metres = polyscan.rasterize(vertices, faces, Camera.perspective(40, pose), (200, 150))
    scaled = pose.copy()
    scaled[:3, 3] *= 1000
    millimetres = polyscan.rasterize(1000 * vertices, faces, Camera.perspective(40, scaled), (200, 150))
    assert np.array_equal(metres.face, millimetres.face)
    assert np.allclose(1000 * metres.depth, millimetres.depth, rtol=1e-6)


def frustum(near: float, far: float, half: float, kind: str) -> np.ndarray:
    """Projections as they are written down for each convention: the camera looks along -z, y up."""
    projection = np.zeros((4, 4))
    projection[0, 0] = projection[1, 1] = 1 / half
    projection[3, 2] = -1
    a, b = {
        "zero_to_one": (-far / (far - near), -far * near / (far - near)),
        "minus_one_to_one": (-(far + near) / (far - near), -2 * far * near / (far - near)),
        "reversed": (near / (far - near), far * near / (far - near)),
    }[kind]
    projection[2, 2:] = a, b
    return projection


def test_projection_matrices_of_all_conventions_see_the_same(rng: np.random.Generator) -> None:
    vertices, faces = rng.uniform(-1, 1, (60, 3)) - [0, 0, 4], rng.integers(0, 60, (40, 3))
    want = polyscan.rasterize(
        vertices, faces, Camera.perspective(2 * np.degrees(np.arctan(0.5)), np.diag([1.0, -1, -1, 1])), (160, 160)
    )
    assert (want.face >= 0).mean() > 0.1
    for kind in ("zero_to_one", "minus_one_to_one", "reversed"):
        matrix = frustum(0.5, 20, 0.5, kind)
        is_reversed = kind == "reversed"
        camera = Camera.projection(matrix, depth_range="zero_to_one" if is_reversed else kind, reversed_depth=is_reversed)
        seen = polyscan.rasterize(vertices, faces, camera, (160, 160))
        # Other roundings of the same depths may turn over what ties.
        assert (seen.face != want.face).mean() < 1e-3, kind
        same = seen.face == want.face
        assert np.allclose(seen.depth[same], want.depth[same], rtol=1e-5), kind
        # The same vertices in clip space.
        clip = np.concatenate([vertices, np.ones((60, 1))], axis=1) @ matrix.T
        camera = Camera.clip_space(depth_range="zero_to_one" if is_reversed else kind, reversed_depth=is_reversed)
        assert np.array_equal(polyscan.rasterize(clip, faces, camera, (160, 160)).face, seen.face)


@pytest.mark.parametrize("is_reversed", [False, True])
@pytest.mark.parametrize("depth_range", ["zero_to_one", "minus_one_to_one"])
def test_a_parallel_projection_has_the_distance_from_its_near_plane(depth_range: str, is_reversed: bool) -> None:
    near, far, half = 2.0, 10.0, 4.0
    floor = 0.0 if depth_range == "zero_to_one" else -1.0
    start, end = (1.0, floor) if is_reversed else (floor, 1.0)
    matrix = np.diag([1 / half, 1 / half, (end - start) / (far - near), 1])
    matrix[2, 3] = start - near * (end - start) / (far - near)
    camera = Camera.projection(matrix, depth_range=depth_range, reversed_depth=is_reversed)
    vertices = np.array([[-4.0, -4, 3], [4, -4, 3], [4, 4, 9], [-4, 4, 9]])
    behind = vertices + [0, 0, 0.5]
    seen = polyscan.rasterize(np.concatenate([behind, vertices]), [[0, 1, 2, 3], [4, 5, 6, 7]], camera, (32, 48))
    rows = (np.arange(48) + 0.5) / 48
    assert (seen.face == 1).all()
    assert np.abs(seen.depth - (9 - 6 * rows - near)[:, None]).max() < 1e-5
    own = polyscan.rasterize(
        vertices, [[0, 1, 2, 3]], Camera.orthographic(8, 8, np.diag([1.0, -1, 1, 1]), near=2, far=10), (32, 48)
    )
    assert np.abs(own.depth - (9 - 6 * rows)[:, None]).max() < 1e-5


def test_near_and_far_cut() -> None:
    vertices = np.array([[-50.0, -50, 1], [50, -50, 1], [0, 50, 100]])
    u = polyscan.rasterize(vertices, [[0, 1, 2]], Camera.perspective(90, near=5, far=40), (64, 64))
    shown = u.depth[u.face >= 0]
    assert shown.min() >= 5 * (1 - 1e-6) and shown.max() <= 40 * (1 + 1e-6) and shown.max() > 30


def test_a_camera_around_a_model_sees_all_of_it(rng: np.random.Generator) -> None:
    for up in ([0, 1, 0], [0, 0, 1], [0, -1, 0], [1, 2, 3]):
        points = rng.normal(size=(200, 3)) * [1, 3, 0.5] + [10, 0, -4]
        for size in ((100, 300), (300, 100)):
            camera = Camera.around(points, yaw=rng.uniform(0, 360), pitch=rng.uniform(-90, 90), up=up)
            place = pixels(camera, points, size)
            assert (place >= 0).all() and (place <= size).all()
            centre = (points.min(axis=0) + points.max(axis=0)) / 2
            ends = pixels(camera, np.array([centre, centre + 0.1 * np.array(up) / np.linalg.norm(up)]), size)
            assert np.abs(ends[0] - np.array(size) / 2).max() < 1e-6
            assert ends[1, 1] <= ends[0, 1] + 1e-9, "what is up is not up in the picture"


def test_opengl_poses(rng: np.random.Generator) -> None:
    world = np.eye(4)
    world[:3, :3], world[:3, 3] = rotation(rng), [1, 2, 3]
    pose = polyscan.opengl_pose(world)
    # What lies along the camera's -z is ahead, what lies along y is up.
    ahead = world[:3, 3] - 2 * world[:3, 2] + 0.1 * world[:3, 1]
    assert np.allclose(pose @ [*ahead, 1], [0, -0.1, 2, 1])


def test_cameras_go_to_other_processes() -> None:
    cameras = [
        Camera.opencv(K),
        Camera.perspective(30),
        Camera.orthographic(1, 1, near=0, far=1),
        Camera.projection(np.eye(4)),
        Camera.around(np.eye(3)),
    ]
    for camera in cameras:
        again = pickle.loads(pickle.dumps(camera))
        assert np.array_equal(again.matrix(30, 20), camera.matrix(30, 20))


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("K", lambda: Camera.opencv(np.eye(4))),
        ("K", lambda: Camera.opencv([[0, 0, 0], [0, 1, 0], [0, 0, 1]])),
        ("K", lambda: Camera.opencv(np.full((3, 3), np.nan))),
        ("pose", lambda: Camera.opencv(K, np.eye(3))),
        ("pose", lambda: Camera.opencv(K, np.ones((4, 4)))),
        ("near", lambda: Camera.opencv(K, near=0)),
        ("near", lambda: Camera.opencv(K, near=2, far=1)),
        ("far", lambda: Camera.opencv(K, far=np.nan)),
        ("field_of_view", lambda: Camera.perspective(180)),
        ("width", lambda: Camera.orthographic(0, 1, near=0, far=1)),
        ("near", lambda: Camera.orthographic(1, 1, near=1, far=1)),
        ("matrix", lambda: Camera.projection(np.zeros((4, 4)))),
        ("matrix", lambda: Camera.projection(np.eye(3))),
        ("depth_range", lambda: Camera.projection(np.eye(4), depth_range="opengl")),
        ("up", lambda: polyscan.look_at([0, 0, 0], [0, 1, 0])),
        ("eye", lambda: polyscan.look_at([0, 0], [0, 1, 0])),
        ("vertices", lambda: Camera.around(np.empty((0, 3)))),
        ("camera_to_world", lambda: polyscan.opengl_pose(np.zeros((4, 4)))),
    ],
)
def test_what_is_wrong_is_named(name: str, make) -> None:
    with pytest.raises(ValueError, match=f"^{name} "):
        make()
