"""Against the rays of Embree."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

import polyscan
from conftest import sphere
from polyscan import Camera

SIZE = (320, 240)
COTTAGE = pathlib.Path(__file__).parents[2] / "examples" / "assets" / "cottage.obj"


def bumpy(rings: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A sphere with bumps, whose parts hide each other."""
    points, faces = sphere(rings)
    x, y, z = points.T
    radius = 1 + 0.25 * np.sin(7 * x + 1) * np.cos(6 * y) * np.sin(5 * z) + 0.1 * np.sin(23 * x * y)
    return points * radius[:, None], faces


def rays(camera: Camera, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """The eye, and the directions through all pixels' centres, with 1 along the view: from the inverse matrix."""
    width, height = size
    x, y = np.meshgrid((np.arange(width) + 0.5) * 2 / width - 1, 1 - (np.arange(height) + 0.5) * 2 / height)
    back = np.linalg.inv(camera.matrix(width, height))

    def at(z: float) -> np.ndarray:
        points = np.stack([x, y, np.full_like(x, z), np.ones_like(x)], axis=-1) @ back.T
        return points[..., :3] / points[..., 3:]

    eye = back @ [0, 0, 1, 0]
    eye = eye[:3] / eye[3]
    ways = at(0.5) - eye
    ahead = camera.matrix(width, height)[3, :3]
    return eye, ways / (ways @ ahead)[..., None]


def cottage() -> tuple[np.ndarray, np.ndarray]:
    """The model that comes with the examples, in triangles."""
    lines = [line.split() for line in COTTAGE.read_text().splitlines()]
    vertices = np.array([[float(number) for number in line[1:4]] for line in lines if line[:1] == ["v"]])
    polygons = [[int(corner.split("/")[0]) - 1 for corner in line[1:]] for line in lines if line[:1] == ["f"]]
    faces = [[p[0], p[i], p[i + 1]] for p in polygons for i in range(1, len(p) - 1)]
    return vertices, np.array(faces)


class View:
    """A mesh on the screen, in f64."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, camera: Camera) -> None:
        clip = np.concatenate([vertices.astype(np.float64), np.ones((len(vertices), 1))], axis=1) @ camera.matrix(*SIZE).T
        x, y = (clip[:, :2] / clip[:, 3:]).T
        #: (m, 3, 2) in pixels, and (m, 3) distances ahead.
        self.corners = np.stack([(x + 1) * SIZE[0] / 2, (1 - y) * SIZE[1] / 2], axis=-1)[faces]
        self.ahead = clip[:, 3][faces]

    def depth(self, face: np.ndarray, pixel: np.ndarray) -> np.ndarray:
        """The distances ahead of the planes of faces (k,) at points (k, 2): 1 / w is linear on the screen."""
        a, b, c = np.moveaxis(self.corners[face], 1, 0)
        inverse = 1 / self.ahead[face]
        p, q, r = b - a, c - a, pixel - a
        cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
        with np.errstate(all="ignore"):
            s = (r[:, 0] * q[:, 1] - r[:, 1] * q[:, 0]) / cross
            t = (p[:, 0] * r[:, 1] - p[:, 1] * r[:, 0]) / cross
            return 1 / (inverse[:, 0] * (1 - s - t) + inverse[:, 1] * s + inverse[:, 2] * t)

    def change(self, face: np.ndarray, pixel: np.ndarray, bound: float) -> np.ndarray:
        """By how much these change over so many pixels to the right and down."""
        steps = np.diag([bound, bound])
        return sum(np.abs(self.depth(face, pixel + step) - self.depth(face, pixel)) for step in steps)

    def distance(self, face: np.ndarray, pixel: np.ndarray) -> np.ndarray:
        """How far points (k, 2) are from the nearest edge of faces (k,), in pixels; infinitely if there is no face."""
        corners = self.corners[face]
        along = np.roll(corners, -1, axis=1) - corners
        t = ((pixel[:, None] - corners) * along).sum(-1) / np.maximum((along**2).sum(-1), 1e-300)
        nearest = corners + along * t.clip(0, 1)[..., None]
        return np.where(face >= 0, np.linalg.norm(nearest - pixel[:, None], axis=-1).min(axis=1), np.inf)


def on_the_grid(vertices: np.ndarray, camera: Camera) -> np.ndarray:
    """The vertices, moved in the picture to where polyscan rounds them: to 1/256 pixel."""
    matrix = camera.matrix(*SIZE)
    clip = np.concatenate([vertices, np.ones((len(vertices), 1))], axis=1) @ matrix.T
    half = np.array(SIZE) / 2
    clip[:, :2] = np.rint(clip[:, :2] / clip[:, 3:] * half * 256) / 256 / half * clip[:, 3:]
    back = clip @ np.linalg.inv(matrix).T
    return back[:, :3] / back[:, 3:]


def both(vertices: np.ndarray, faces: np.ndarray, camera: Camera) -> tuple[polyscan.Seen, np.ndarray, np.ndarray]:
    """What polyscan sees, and the faces and depths of Embree's rays."""
    rtcore_scene = pytest.importorskip("embreex.rtcore_scene")
    from embreex.mesh_construction import TriangleMesh

    seen = polyscan.rasterize(vertices, faces, camera, SIZE)
    eye, ways = rays(camera, SIZE)
    scene = rtcore_scene.EmbreeScene(robust=True)
    TriangleMesh(scene, vertices.astype(np.float32), faces.astype(np.int32))
    origins = np.broadcast_to(eye, (SIZE[0] * SIZE[1], 3)).astype(np.float32)
    hit = scene.run(origins, ways.reshape(-1, 3).astype(np.float32), output=True)
    return seen, hit["primID"].reshape(seen.face.shape), hit["tfar"].reshape(seen.face.shape)


MESHES = [
    pytest.param(lambda rng: bumpy(12, rng), id="coarse"),
    pytest.param(lambda rng: bumpy(60, rng), id="fine"),
    pytest.param(lambda rng: bumpy(250, rng), id="finer than pixels"),
    pytest.param(lambda _: cottage(), id="cottage"),
]


def cameras(vertices: np.ndarray) -> list[Camera]:
    return [Camera.around(vertices, yaw=yaw, pitch=25) for yaw in (10, 100, 250)]


@pytest.mark.parametrize("mesh", MESHES)
def test_faces_are_those_of_rays_but_where_depths_tie(rng: np.random.Generator, mesh) -> None:
    """Of meshes whose vertices lie where polyscan rounds them, both see the same edges, but for the rounding of f32: vertices
    and rays are known to 2^-24 of their size, which is less than 1e-4 pixel here. So masks are equal; and where faces are
    not, both planes are at the same depth, but for what they change over that."""
    bound = 1e-4
    vertices, faces = mesh(rng)
    shown, apart = 0, 0
    for camera in cameras(vertices):
        vertices = on_the_grid(vertices, camera)
        seen, face, depth = both(vertices, faces, camera)
        assert np.array_equal(seen.face >= 0, face >= 0)
        view = View(vertices, faces, camera)
        y, x = np.nonzero(face >= 0)
        pixel, ours, theirs = np.stack([x, y], axis=-1) + 0.5, seen.face[y, x], face[y, x]
        slack = view.change(theirs, pixel, bound) + 1e-6 * depth[y, x]
        same = ours == theirs
        assert (np.abs(seen.depth[y, x] - depth[y, x]) <= slack)[same].all()
        slack += view.change(ours, pixel, bound)
        assert (np.abs(view.depth(ours, pixel) - view.depth(theirs, pixel)) <= slack)[~same].all()
        shown, apart = shown + len(x), apart + int((~same).sum())
    assert shown > 50_000 and apart < shown / 2000, f"{apart} of {shown} pixels show other faces"


@pytest.mark.parametrize("mesh", MESHES)
def test_other_faces_are_seen_at_edges_alone(rng: np.random.Generator, mesh) -> None:
    """Of any mesh, polyscan rounds vertices by up to 1/512 pixel in x and in y. So where it sees other faces than a ray does,
    or where one of the two sees none, the pixel's centre is no farther than that from an edge of one of them; or both are
    at one depth."""
    bound = np.sqrt(2) / 512 + 1e-4
    vertices, faces = mesh(rng)
    for camera in cameras(vertices):
        seen, face, _ = both(vertices, faces, camera)
        view = View(vertices, faces, camera)
        y, x = np.nonzero(seen.face != face)
        pixel = np.stack([x, y], axis=-1) + 0.5
        near = np.minimum(view.distance(seen.face[y, x], pixel), view.distance(face[y, x], pixel))
        tie = np.abs(view.depth(seen.face[y, x], pixel) / view.depth(face[y, x], pixel) - 1) < 1e-6
        assert ((near <= bound) | tie).all(), f"{near.max():.4f} pixel from an edge"
        assert 0 < len(x) < 0.005 * (face >= 0).sum()
