"""Against the rays of Embree."""

from __future__ import annotations

import numpy as np
import pytest

import polyscan
from conftest import sphere
from polyscan import Camera

SIZE = (320, 240)


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


@pytest.mark.parametrize("rings", [12, 60, 250])
def test_masks_and_faces_are_those_of_rays(rng: np.random.Generator, rings: int) -> None:
    rtcore_scene = pytest.importorskip("embreex.rtcore_scene")
    from embreex.mesh_construction import TriangleMesh

    vertices, faces = bumpy(rings, rng)
    # As rays have them.
    vertices = vertices.astype(np.float32)
    for yaw in (10, 100, 250):
        camera = Camera.around(vertices, yaw=yaw, pitch=25)
        seen = polyscan.rasterize(vertices, faces, camera, SIZE)
        eye, ways = rays(camera, SIZE)
        scene = rtcore_scene.EmbreeScene(robust=True)
        TriangleMesh(scene, vertices, faces.astype(np.int32))
        origins = np.broadcast_to(eye, (SIZE[0] * SIZE[1], 3)).astype(np.float32)
        directions = ways.reshape(-1, 3).astype(np.float32)
        hit = scene.run(origins, directions, output=True)
        face = hit["primID"].reshape(seen.face.shape)
        depth = hit["tfar"].reshape(seen.face.shape)
        # Rays and edges are rounded differently, to about 1/256 pixel: so near the rim one may see what the other does
        # not, and at an edge the neighbour.
        mask = (seen.face >= 0) != (face >= 0)
        assert mask.mean() <= 2e-4, f"{mask.sum()} pixels of the mask differ"
        both = (seen.face >= 0) & (face >= 0)
        apart = both & (seen.face != face)
        same = both & ~apart
        assert np.abs(seen.depth[same] / depth[same] - 1).max() < 2e-4
        shares = (faces[seen.face[apart]][:, :, None] == faces[face[apart]][:, None, :]).any(axis=(1, 2))
        close = np.abs(seen.depth[apart] / depth[apart] - 1) < 1e-3
        assert (shares | close).mean() > 0.9 if apart.any() else True
        assert apart.mean() < 0.02, f"{apart.mean():.4f} of the pixels show other faces"
