"""What is seen of triangles, by testing all of them at each pixel: slow, and nothing is shared with the library."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Answer(NamedTuple):
    #: (m, height, width): whether each face covers each pixel.
    covers: np.ndarray
    #: (m, height, width): z/w, w and barycentrics of each face's plane at each pixel.
    z: np.ndarray
    w: np.ndarray
    weights: np.ndarray


def to_clip(vertices: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Vertices in clip space in f32, from products in f64 that are summed from the left."""
    points = np.concatenate([vertices.astype(np.float64), np.ones((len(vertices), 1))], axis=1)
    total = points[:, 0, None] * matrix[:, 0]
    for i in (1, 2, 3):
        total = total + points[:, i, None] * matrix[:, i]
    return total.astype(np.float32).astype(np.float64)


#: Right of a pixel's centre, and below it, in pixels.
Place = tuple[float, float]
CENTRE: Place = (0.0, 0.0)


def centres(width: int, height: int, place: Place = CENTRE) -> tuple[np.ndarray, np.ndarray]:
    """Normalized device coordinates (X, Y) of all pixels' centres, or of other places in them."""
    x = (np.arange(width) + 0.5 + place[0]) * 2 / width - 1
    y = 1 - (np.arange(height) + 0.5 + place[1]) * 2 / height
    return np.meshgrid(x, y)


def planes(
    clip: np.ndarray, faces: np.ndarray, width: int, height: int, place: Place = CENTRE
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """z/w, w and barycentrics (m, height, width, 3) of each face's plane, whether a pixel is inside or not: by Cramer's
    rule for the point of the plane that is seen at (X, Y)."""
    x, y = centres(width, height, place)
    pixel = np.stack([x, y, np.ones_like(x)], axis=-1)
    corners = clip[faces]
    # b (x, y, w) = s (X, Y, 1), and the sum of b is 1.
    columns = corners[:, :, [0, 1, 3]].transpose(0, 2, 1)
    adjugate = np.stack([np.cross(columns[:, :, j], columns[:, :, k]) for j, k in ((1, 2), (2, 0), (0, 1))], axis=1)
    areas = np.einsum("mij,hwj->mhwi", adjugate, pixel)
    with np.errstate(all="ignore"):
        weights = areas / areas.sum(axis=-1, keepdims=True)
    w = np.einsum("mhwi,mi->mhw", weights, corners[:, :, 3])
    z = np.einsum("mhwi,mi->mhw", weights, corners[:, :, 2]) / w
    return z, w, weights


def coverage(clip: np.ndarray, faces: np.ndarray, width: int, height: int, place: Place = CENTRE) -> np.ndarray:
    """Which pixels (m, height, width) faces cover that lie before the eye: corners rounded to 1/256 pixel, half to even,
    then whole numbers with the top-left rule."""
    inverse = 1.0 / clip[:, 3]
    x = np.rint(((clip[:, 0] * inverse) * 0.5 + 0.5) * width * 256).astype(np.int64)
    y = np.rint(((clip[:, 1] * inverse) * -0.5 + 0.5) * height * 256).astype(np.int64)
    px = np.arange(width, dtype=np.int64)[None, :] * 256 + 128 + int(place[0] * 256)
    py = np.arange(height, dtype=np.int64)[:, None] * 256 + 128 + int(place[1] * 256)
    covered = np.zeros((len(faces), height, width), bool)
    for i, (a, b, c) in enumerate(faces):
        area = (x[b] - x[a]) * (y[c] - y[a]) - (x[c] - x[a]) * (y[b] - y[a])
        if area == 0:
            continue
        if area < 0:
            b, c = c, b
        inside = np.ones((height, width), bool)
        for p, q in ((a, b), (b, c), (c, a)):
            dx, dy = x[q] - x[p], y[q] - y[p]
            side = dx * (py - y[p]) - dy * (px - x[p])
            # The inner normal is (-dy, dx): on a left edge it points to the right, on a top edge down.
            is_top_left = dy < 0 or (dy == 0 and dx > 0)
            inside &= (side > 0) | ((side == 0) & is_top_left)
        covered[i] = inside
    return covered


def answer(clip: np.ndarray, faces: np.ndarray, width: int, height: int, place: Place = CENTRE) -> Answer:
    z, w, weights = planes(clip, faces, width, height, place)
    return Answer(coverage(clip, faces, width, height, place), z, w, weights)
