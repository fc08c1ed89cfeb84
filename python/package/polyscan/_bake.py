"""Baking: a mesh laid out by its texture coordinates, so that each texel knows its place on the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _polyscan
from ._arguments import Faces


@dataclass(frozen=True, eq=False)
class Baked:
    """What each texel of a texture shows. `interpolate` takes it as it takes what is `Seen`."""

    #: (height, width) i32: the number of the face, or -1. In the margin that of the nearest texel that a face touches.
    face: npt.NDArray[np.int32]
    #: (height, width, 3) f32: the weights of the face's corners, at the texel's centre if the face covers it, else at the
    #: nearest point of the face. 0 where there is no face.
    barycentrics: npt.NDArray[np.float32]
    #: (height, width): whether a face covers or touches the texel, so that it is not of the margin.
    is_covered: npt.NDArray[np.bool_]
    #: (k, 3) u32: pairs of faces that cover the centres of the same texels, and of how many: the atlas overlaps itself
    #: there, and the texels are those of the first face.
    overlaps: npt.NDArray[np.uint32]
    #: The faces, as they were checked.
    faces: Faces
    #: Baked faces are triangles, and nothing is differentiated.
    corners: None = None
    derivatives: None = None
    is_batch: bool = False


def bake(
    uv: npt.ArrayLike,
    faces: npt.ArrayLike,
    size: tuple[int, int],
    *,
    margin: int = 4,
    threads: int | None = None,
) -> Baked:
    """Finds the face and the place on it for each texel of a texture.

    Every texel that a face as much as touches is found: a filter reads it, too. Attributes of the mesh's vertices at the
    texels are `interpolate(attributes, baked)`, or with the mesh's own faces, `interpolate(attributes, baked, faces)`, if
    texture coordinates are counted apart.

    uv: (n, 2) texture coordinates, u to the right, v DOWN, from 0 to 1; what is outside is cut off.
    faces: (m, 3) triangles, as in `rasterize`, by numbers of texture coordinates.
    size: width and height of the texture in texels, from 1 to 65536.
    margin: by how many texels the border of each chart is continued.
    threads: how many take part; as many as there are processors if left out.

    Raises `ValueError`, which names the argument.
    """
    width, height = arguments.size(size)
    places = arguments.floats("uv", uv)
    if places.ndim != 2 or places.shape[1] != 2:
        raise ValueError(f"uv must have the shape (n, 2), not {places.shape}")
    checked = arguments.faces(faces, len(places))
    if not checked.are_triangles:
        raise ValueError("faces must be triangles, (m, 3), to be baked")
    points = np.concatenate([places, np.zeros((len(places), 1), places.dtype)], axis=1)
    face, weights, is_covered, overlaps = _polyscan.bake_weights(
        points, checked.indices, (width, height), arguments.whole("margin", margin, 0, 65536), arguments.threads(threads)
    )
    return Baked(
        face.reshape(height, width),
        weights.reshape(height, width, 3),
        is_covered.reshape(height, width),
        np.array(overlaps, np.uint32).reshape(-1, 3),
        checked,
    )
