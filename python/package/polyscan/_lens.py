"""Lens distortion: triangles are cut until the straight edges of the parts lie where the lens bends them to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments

#: A fisheye sees what is less than so many degrees off its axis: its picture is made by a division by z.
MOST_DEGREES = 89.0
#: An edge is cut in halves at most so often.
MOST_CUTS = 20


class Parts(NamedTuple):
    """Parts of triangles, as the lens shows them."""

    #: (n, 3) f64, in the camera's space, moved to where a pinhole sees them as the lens does.
    vertices: np.ndarray
    #: (m, 3) the parts' corners.
    faces: np.ndarray
    #: (m,) the triangle that each is a part of.
    parent: np.ndarray
    #: (m, 3, 3) for each corner of a part the weights of the triangle's corners.
    weights: np.ndarray


@dataclass(frozen=True, eq=False)
class Lens:
    """A lens by OpenCV's coefficients."""

    coefficients: np.ndarray
    is_fisheye: bool
    #: In pixels.
    max_error: float
    #: The greatest tangent of the angle off the axis up to which farther out is farther out in the picture.
    reach: float

    @classmethod
    def of(cls, distortion: npt.ArrayLike, fisheye: bool, max_error: float) -> Lens:
        coefficients = arguments.array("distortion", distortion).astype(np.float64).reshape(-1)
        counts = (4,) if fisheye else (4, 5, 8)
        if len(coefficients) not in counts or not np.isfinite(coefficients).all():
            choices = " or ".join(str(count) for count in counts)
            raise ValueError(f"distortion must be {choices} finite coefficients, not {coefficients.tolist()}")
        error = arguments.number("lens_error", max_error, 1e-3)
        lens = cls(np.pad(coefficients, (0, 8 - len(coefficients))), fisheye, error, np.inf)
        # Angles in steps of 1/5000 of a right angle.
        tangents = np.tan(np.linspace(0, np.radians(MOST_DEGREES), 5000))
        with np.errstate(all="ignore"):
            falls = ~(np.diff(lens._radius(tangents)) > 0)
        reach = float(tangents[np.argmax(falls)]) if falls.any() else float(tangents[-1])
        if reach == 0:
            raise ValueError(f"distortion turns the picture around at its middle: {coefficients.tolist()}")
        return cls(lens.coefficients, fisheye, error, reach)

    def _radius(self, r: np.ndarray) -> np.ndarray:
        """How far from the middle the lens shows what a pinhole shows at `r`."""
        k = self.coefficients
        if self.is_fisheye:
            angle = np.arctan(r)
            square = angle * angle
            return angle * (1 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))))
        square = r * r
        above = 1 + square * (k[0] + square * (k[1] + square * k[4]))
        return r * above / (1 + square * (k[5] + square * (k[6] + square * k[7])))

    def distort(self, points: np.ndarray) -> np.ndarray:
        """Where the lens shows what a pinhole shows at points (n, 2), both in units of the focal length. Beyond its reach
        the lens goes on straight, so that nothing folds back into the picture."""
        length = np.maximum(np.linalg.norm(points, axis=1), 1e-300)
        near = np.minimum(length, self.reach)
        radius = self._radius(near) + (length - near) * self._radius(np.array(self.reach)) / self.reach
        shown = points * (radius / length)[:, None]
        if self.is_fisheye:
            return shown
        p1, p2 = self.coefficients[2:4]
        x, y = (points * (near / length)[:, None]).T
        square = x * x + y * y
        shift = np.stack([2 * p1 * x * y + p2 * (square + 2 * x * x), p1 * (square + 2 * y * y) + 2 * p2 * x * y], axis=1)
        return shown + shift

    def undistort(self, points: np.ndarray) -> np.ndarray:
        """The inverse, of points that the lens shows, by Newton's method along the radius; others come to lie at its
        reach or beyond."""
        length = np.maximum(np.linalg.norm(points, axis=1), 1e-300)
        # A table is near enough: what is found bounds what is seen.
        table = np.concatenate([np.tan(np.linspace(0, np.arctan(self.reach), 4000))])
        found = np.interp(length, self._radius(table), table)
        return points * (found / length)[:, None]

    def shows(self, points: np.ndarray) -> np.ndarray:
        """Whether the lens shows anything at points (..., 2)."""
        return np.linalg.norm(points, axis=-1) <= self._radius(np.array(self.reach))

    def parts(self, points: np.ndarray, faces: np.ndarray, inner: np.ndarray, near: float, size: tuple[int, int]) -> Parts:
        """Parts of triangles whose points are less than the error from where the lens shows them.

        points: (n, 3) f64 in the camera's space; faces: (m, 3); inner: (2, 3), from points of `distort` to pixels.
        """
        mesh = Mesh(points, faces.astype(np.int64), np.arange(len(faces)), np.tile(np.eye(3), (len(faces), 1, 1)))
        for plane in self._planes(inner, near, size):
            mesh = mesh.inside(plane)
        for _ in range(MOST_CUTS):
            edges, of_faces = mesh.edges()
            ends = mesh.points[edges]
            error = np.zeros(len(edges))
            for t in (0.25, 0.5, 0.75):
                error = np.maximum(error, self._error(ends, np.array([1 - t, t]), inner))
            # Half of it, for within a triangle the errors of its edges add up in part.
            is_cut = error > self.max_error / 2
            middle = self._error(mesh.points[mesh.faces], np.full(3, 1 / 3), inner) > self.max_error / 2
            is_uncut = middle & ~is_cut[of_faces].any(axis=1)
            longest = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)[of_faces].argmax(axis=1)
            is_cut[of_faces[is_uncut, longest[is_uncut]]] = True
            if not is_cut.any():
                break
            mesh = mesh.cut(edges, of_faces, is_cut, np.full(len(edges), 0.5))
        return Parts(self._moved(mesh.points), mesh.faces, mesh.parent, mesh.weights)

    def _moved(self, points: np.ndarray) -> np.ndarray:
        """Points to where a pinhole sees them as the lens does, as far ahead as they were."""
        z = np.where(points[:, 2:] > 0, points[:, 2:], 1.0)
        return np.concatenate([self.distort(points[:, :2] / z) * z, points[:, 2:]], axis=1)

    def _error(self, corners: np.ndarray, weights: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """How far, in pixels, a point of each edge or triangle is from where the lens shows it."""
        count, size, _ = corners.shape
        moved = self._moved(corners.reshape(-1, 3)).reshape(count, size, 3)
        flat = np.einsum("i,nij->nj", weights, moved)
        true = self._moved(np.einsum("i,nij->nj", weights, corners))
        apart = flat[:, :2] / flat[:, 2:] - true[:, :2] / true[:, 2:]
        return np.linalg.norm(apart @ inner[:, :2].T, axis=1)

    def _planes(self, inner: np.ndarray, near: float, size: tuple[int, int]) -> list[np.ndarray]:
        """Planes through the eye around all that the picture shows, and the near plane: normals and a shift."""
        width, height = size
        across, down = np.linspace(-2, width + 2, 200), np.linspace(-2, height + 2, 200)
        rim = np.concatenate(
            [
                np.stack([across, np.full(200, -2.0)], 1),
                np.stack([across, np.full(200, height + 2.0)], 1),
                np.stack([np.full(200, -2.0), down], 1),
                np.stack([np.full(200, width + 2.0), down], 1),
            ]
        )
        seen = self.undistort((rim - inner[:, 2]) @ np.linalg.inv(inner[:, :2]).T)
        # Tangential distortion moves the rim as well, by little.
        low, high = seen.min(axis=0), seen.max(axis=0)
        margin = 0.05 * (high - low) + 1e-3
        low, high = np.minimum(low - margin, -margin), np.maximum(high + margin, margin)
        return [
            np.array([0.0, 0.0, 1.0, -near]),
            np.array([1.0, 0.0, -low[0], 0.0]),
            np.array([-1.0, 0.0, high[0], 0.0]),
            np.array([0.0, 1.0, -low[1], 0.0]),
            np.array([0.0, -1.0, high[1], 0.0]),
        ]


class Mesh(NamedTuple):
    """Triangles that are cut along edges, so that neighbours always share the new vertices."""

    points: np.ndarray
    faces: np.ndarray
    parent: np.ndarray
    weights: np.ndarray

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """All edges (k, 2), the lower vertex first, and which of them each face has (m, 3): from its first corner to its
        second, and so on."""
        pairs = np.stack([self.faces, np.roll(self.faces, -1, axis=1)], axis=-1)
        low, high = pairs.min(axis=-1), pairs.max(axis=-1)
        keys, places = np.unique(low * len(self.points) + high, return_inverse=True)
        count = max(len(self.points), 1)
        return np.stack([keys // count, keys % count], axis=1), places.reshape(self.faces.shape)

    def inside(self, plane: np.ndarray) -> Mesh:
        """What is on the inner side of a plane."""
        distance = self.points @ plane[:3] + plane[3]
        edges, of_faces = self.edges()
        ends = distance[edges]
        is_cut = (ends.min(axis=1, initial=np.inf) < 0) & (ends.max(axis=1, initial=-np.inf) > 0)
        with np.errstate(all="ignore"):
            place = np.where(is_cut, ends[:, 0] / (ends[:, 0] - ends[:, 1]), 0.5)
        mesh = self.cut(edges, of_faces, is_cut, place)
        middle = mesh.points[mesh.faces].mean(axis=1) @ plane[:3] + plane[3]
        kept = middle > 0
        return Mesh(mesh.points, mesh.faces[kept], mesh.parent[kept], mesh.weights[kept])

    def cut(self, edges: np.ndarray, of_faces: np.ndarray, is_cut: np.ndarray, place: np.ndarray) -> Mesh:
        """All faces, cut at the places of edges that are to be cut."""
        number = len(self.points) + np.cumsum(is_cut) - 1
        low, high = self.points[edges[is_cut, 0]], self.points[edges[is_cut, 1]]
        points = np.concatenate([self.points, low + (high - low) * place[is_cut, None]])
        cuts = is_cut[of_faces]
        count = cuts.sum(axis=1)
        faces, parents, weights = [self.faces[count == 0]], [self.parent[count == 0]], [self.weights[count == 0]]
        for cases, first, parts in _CASES:
            chosen = np.flatnonzero(count == cases)
            # Turned so that the cut edges are where the table has them.
            turn = (np.argmax(cuts[chosen] if first else ~cuts[chosen], axis=1)) if cases < 3 else np.zeros(len(chosen), int)
            order = (turn[:, None] + np.arange(3)) % 3
            corners = np.take_along_axis(self.faces[chosen], order, axis=1)
            own = np.take_along_axis(self.weights[chosen], order[..., None], axis=1)
            edge = np.take_along_axis(of_faces[chosen], order, axis=1)
            # From the corner towards the next one.
            t = np.where(corners < np.roll(corners, -1, axis=1), place[edge], 1 - place[edge])[..., None]
            between = own * (1 - t) + np.roll(own, -1, axis=1) * t
            all_corners = np.concatenate([corners, number[edge]], axis=1)
            all_weights = np.concatenate([own, between], axis=1)
            for part in parts:
                faces.append(all_corners[:, part])
                weights.append(all_weights[:, part])
                parents.append(self.parent[chosen])
        return Mesh(points, np.concatenate(faces), np.concatenate(parents), np.concatenate(weights))


#: How many edges are cut; whether a face is turned so that its first edge is cut, or so that it is not; and the parts. 0 to
#: 2 are the corners, 3 to 5 are on the edges from 0 to 1, from 1 to 2 and from 2 to 0.
_CASES = (
    (1, True, ([0, 3, 2], [3, 1, 2])),
    (2, False, ([2, 5, 4], [0, 1, 4], [0, 4, 5])),
    (3, True, ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5])),
)
