"""Random scenes, and the check of what is seen of them against the oracle."""

from __future__ import annotations

import numpy as np

import oracle
import polyscan
from conftest import rotation


def scene(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, polyscan.Camera, tuple[int, int]]:
    """A heap of triangles, some of which share vertices, before a camera."""
    count = int(rng.integers(3, 24))
    vertices = rng.uniform(-1, 1, (count, 3)) * rng.uniform(0.2, 1.5)
    faces = np.array([rng.choice(count, 3, replace=False) for _ in range(int(rng.integers(1, 16)))])
    size = int(rng.integers(8, 64)), int(rng.integers(8, 64))
    pose = np.eye(4)
    pose[:3, :3] = rotation(rng)
    pose[:3, 3] = *rng.uniform(-0.3, 0.3, 2), rng.uniform(3, 8)
    focal = size[0] * rng.uniform(0.8, 4, 2)
    K = [[focal[0], rng.uniform(-3, 3), size[0] / 2], [0, focal[1], size[1] / 2], [0, 0, 1]]
    if rng.integers(4) == 0:
        extent = rng.uniform(0.5, 3, 2)
        camera = polyscan.Camera.orthographic(*extent, pose, near=0.1, far=20)
    else:
        far = np.inf if rng.integers(2) else 30.0
        camera = polyscan.Camera.opencv(K, pose, near=0.1, far=far)
    if rng.integers(2):
        vertices = vertices.astype(np.float32)
    return vertices, faces, camera, size


def check(seen: polyscan.Seen, want: oracle.Answer, faces: np.ndarray, clip: np.ndarray, is_reversed: bool) -> int:
    """Compares all pixels; how many show a face."""
    nearness = want.z if is_reversed else -want.z
    hidden = np.where(want.covers, nearness, -np.inf)
    nearest = hidden.max(axis=0)
    shown = seen.face >= 0
    assert np.array_equal(shown, want.covers.any(axis=0)), "a pixel is covered that should not be, or the reverse"
    y, x = np.nonzero(shown)
    face = seen.face[y, x]
    assert want.covers[face, y, x].all(), "a face is shown where it is not"
    # Depths are f32: of the order of 1e-7 apart they tie. Just outside of a steep face its plane is still steeper.
    weights = want.weights[face, y, x]
    inside = np.maximum(weights, 0)
    inside /= inside.sum(axis=-1, keepdims=True)
    corners = clip[faces[face]]
    clamped_z = (inside * corners[..., 2]).sum(-1) / (inside * corners[..., 3]).sum(-1)
    is_inside = (weights >= 0).all(axis=-1)
    everyone_inside = (want.weights[:, y, x] >= 0).all(axis=-1) | ~want.covers[:, y, x]
    sure = is_inside & everyone_inside.all(axis=0)
    nearness = np.where(is_inside, want.z[face, y, x], clamped_z) * (1 if is_reversed else -1)
    assert (nearness[sure] >= nearest[y, x][sure] - 1e-6 * np.abs(want.z[face, y, x][sure]) - 2e-7).all()
    assert np.abs(seen.barycentrics[y, x] - inside).max(initial=0) <= 1e-5
    assert np.abs(seen.barycentrics[y, x].sum(axis=-1) - 1).max(initial=0) <= 1e-6
    return len(y)


def check_depths(seen: polyscan.Seen, vertices: np.ndarray, faces: np.ndarray, depth_row: np.ndarray) -> None:
    """Depths are those of the points that are seen."""
    y, x = np.nonzero(seen.face >= 0)
    points = vertices.astype(np.float64)[faces[seen.face[y, x]]]
    points = (points * seen.barycentrics[y, x][..., None]).sum(axis=1)
    depth = points @ depth_row[:3] + depth_row[3]
    assert np.abs(seen.depth[y, x] - depth).max(initial=0) <= 1e-5 * np.abs(depth).max(initial=1)
    assert (seen.depth[seen.face < 0] == 0).all()
    assert (seen.barycentrics[seen.face < 0] == 0).all()
