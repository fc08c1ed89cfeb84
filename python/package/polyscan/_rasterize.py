"""What is seen at each pixel, and attributes there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _polyscan
from ._arguments import Faces, Polygons
from ._bake import Baked
from ._camera import Bend, Camera, View

#: Faces as arrays (m, 3) or (m, k), as lists of lists, or as `Polygons`.
FacesLike = npt.ArrayLike | Polygons | Sequence[Sequence[int]]


@dataclass(frozen=True, eq=False)
class Seen:
    """What is seen at each pixel. All of it comes from one test, so faces and depths agree everywhere.

    The shape of a picture is (height, width); in front of it is the axis of a batch, if there is one, and behind it that
    of the layers or samples, if there are several: layers from the nearest on, samples as in `sample_places`.
    """

    #: (..., height, width[, layers or samples]) i32: the number of the face, from 0; -1 where there is none.
    face: npt.NDArray[np.int32]
    #: The same shape, f32: the distance ahead of the camera, in the unit of object space; 0 where there is no face.
    depth: npt.NDArray[np.float32]
    #: The same shape and 3, f32: the weights of the face's corners in their order, right in perspective. None is
    #: negative, and they sum to 1; 0 where there is no face. `None` if they were not asked for.
    barycentrics: npt.NDArray[np.float32] | None
    #: The same shape and (3, 2), f32: the changes of these weights per pixel to the right, and per pixel downwards.
    #: `None` if they were not asked for.
    derivatives: npt.NDArray[np.float32] | None
    #: The same shape and 3, u32: the vertices that the weights are of, where faces have more than three corners: the
    #: first corner and two neighbours, in whose triangle the pixel lies. `None` if all are triangles.
    corners: npt.NDArray[np.uint32] | None
    #: The faces, as they were checked.
    faces: Faces
    #: Whether the first axis is that of a batch.
    is_batch: bool = False


def rasterize(
    vertices: npt.ArrayLike,
    faces: FacesLike,
    camera: Camera | Sequence[Camera] | None,
    size: tuple[int, int],
    *,
    barycentrics: bool = True,
    derivatives: bool = False,
    samples: int = 1,
    layers: int = 1,
    cull: str = "none",
    tile: tuple[int, int, int, int] | None = None,
    threads: int | None = None,
) -> Seen:
    """Finds the face, the depth and the place on the face that is seen at each pixel's centre, or at several samples of it.

    With samples all has one more axis. What share of a pixel is covered is `(seen.face >= 0).mean(axis=-1)`; a mask of some
    faces has soft edges the same way; and attributes without steps at edges are `interpolate(..).mean(axis=-2)`. Depths and
    faces of different things must not be averaged.

    The result is the same to the bit on every machine and with any number of threads.

    vertices: (n, 3) in object space, or (n, 4) homogeneous, f32 or f64; (b, n, 3) or (b, n, 4) for a batch of b shapes.
        Contiguous arrays are not copied.
    faces: (m, 3) for triangles, (m, k) for polygons of k corners, a list of lists, or `Polygons`: whole numbers. Arrays of
        32 bits are not copied. Polygons may be concave.
    camera: a camera, or a list of b cameras for a batch. `None` is for vertices in clip space, 0 <= z <= w.
    size: width and height in pixels, from 1 to 65536.
    barycentrics, derivatives: whether these are wanted.
    samples: 4, 8 or 16 places in each pixel, those of `sample_places`; or 1, its centre. At each of them a face is seen by
        the same rule as at a centre: edges are exact there, and depths, weights and derivatives are those of that place.
    layers: how many faces are kept of each pixel: the nearest, the one behind it, and so on. Of several samples only the
        nearest is.
    cull: "back" leaves out faces that show their backs, whose corners run clockwise in the picture; "front" those that show
        their fronts.
    tile: left column, top row, width and height of a part of the picture, which is the same to the bit as there.
    threads: how many take part; as many as there are processors if left out.

    Raises `ValueError`, which names the argument.
    """
    width, height = arguments.size(size)
    window = arguments.tile(tile, width, height)
    points = arguments.vertices(vertices)
    checked = arguments.faces(faces, points.shape[-2])
    views, is_batch = _views(camera, points, width, height)
    shapes = list(points) if points.ndim == 3 else [points]
    how: dict[str, Any] = {
        "cull": {"back": -1, "none": 0, "front": 1}[arguments.one_of("cull", cull, ("none", "back", "front"))],
        "size": [width, height],
        "tile": list(window),
        "layers": arguments.whole("layers", layers, 1, 64),
        "samples": arguments.samples(samples),
        "products": [bool(barycentrics), bool(derivatives), not checked.are_triangles],
        "threads": arguments.threads(threads),
    }
    if how["layers"] > 1 and how["samples"] > 1:
        raise ValueError("layers must be 1 where there are several samples a pixel")
    count = max(len(views), len(shapes)) if is_batch else 1
    seen = []
    for i in range(count):
        view = views[i if len(views) > 1 else 0]
        shape = shapes[i if len(shapes) > 1 else 0]
        if view.bend is None:
            seen.append(_one(shape, checked, view, how))
        else:
            seen.append(_bent(shape, checked, view.bend, how))
    behind = max(how["layers"], how["samples"])
    picture = (window[3], window[2]) + ((behind,) if behind > 1 else ())
    return _joined(seen, picture, how["products"], checked, is_batch)


def sample_places(samples: int) -> npt.NDArray[np.float64]:
    """Where the samples of a pixel are: (samples, 2), in pixels to the right of the pixel's centre, and below it. They are the
    standard places of Direct3D and Vulkan for 4, 8 and 16 samples, and the centre for 1.

    Pixel (i, j) is seen at `(i, j) + 0.5 + sample_places(samples)`, counted from the picture's top left corner.
    """
    return np.array(_polyscan.sample_places(arguments.samples(samples)))


def _one(points: np.ndarray, faces: Faces, view: View, how: dict[str, Any]) -> tuple[np.ndarray, ...]:
    """One picture: flat arrays of faces, depths, barycentrics, derivatives and corners."""
    of_view = {
        "clip_from_object": view.clip_from_object.tolist(),
        "depth_row": view.depth_row.tolist(),
        "depth_per_w": view.depth_per_w,
        "is_opengl": view.is_opengl,
        "is_reversed": view.is_reversed,
    }
    return _polyscan.rasterize(points, (faces.indices, faces.ends), how | of_view)


def _bent(points: np.ndarray, faces: Faces, bend: Bend, how: dict[str, Any]) -> tuple[np.ndarray, ...]:
    """One picture through a lens: of parts of triangles, said of the triangles."""
    if not faces.are_triangles:
        raise ValueError("faces must be triangles for a camera with distortion")
    if points.shape[1] != 3:
        raise ValueError("vertices must have the shape (n, 3) for a camera with distortion")
    wrong = ~np.isfinite(points).all(axis=1)
    if wrong.any():
        raise ValueError(f"vertices[{np.argmax(wrong)}] is not finite")
    width, height = how["size"]
    in_camera = points @ bend.pose[:3, :3].T + bend.pose[:3, 3]
    parts = bend.lens.parts(in_camera, faces.indices, bend.inner, bend.near, (width, height))
    view = View(bend.projection, np.array([0.0, 0.0, 1.0, 0.0]), 1.0, False, True)
    cut = Faces(np.ascontiguousarray(parts.faces, np.uint32), None)
    part, depth, weights, slopes, corners = _one(np.ascontiguousarray(parts.vertices), cut, view, how)
    left, top, wide, high = how["tile"]
    x, y = np.meshgrid(np.arange(wide) + left + 0.5, np.arange(high) + top + 0.5)
    pixel = np.stack([x, y], axis=-1)[:, :, None] + sample_places(how["samples"])
    place = (pixel - bend.inner[:, 2]) @ np.linalg.inv(bend.inner[:, :2]).T
    shown = np.repeat(bend.lens.shows(place).reshape(-1), how["layers"]) & (part >= 0)
    number = np.where(shown, part, 0)
    if len(parts.parent) == 0:
        return part, depth, weights, slopes, corners
    face = np.where(shown, parts.parent[number], -1).astype(np.int32)
    of_corners = parts.weights[number].astype(np.float32) * shown[:, None, None]
    if weights.size:
        weights = np.einsum("ni,nij->nj", weights.reshape(-1, 3), of_corners).reshape(-1)
    if slopes.size:
        slopes = np.einsum("nik,nij->njk", slopes.reshape(-1, 3, 2), of_corners).reshape(-1)
    return face, np.where(shown, depth, 0).astype(np.float32), weights, slopes, corners


def _joined(
    seen: list[tuple[np.ndarray, ...]], picture: tuple[int, ...], products: list[bool], faces: Faces, is_batch: bool
) -> Seen:
    def array(place: int, tail: tuple[int, ...]) -> np.ndarray:
        if is_batch:
            joined = [one[place].reshape(picture + tail) for one in seen]
            return np.stack(joined) if joined else np.empty((0, *picture, *tail), np.float32)
        return seen[0][place].reshape(picture + tail)

    has_barycentrics, has_derivatives, has_corners = products
    return Seen(
        array(0, ()),
        array(1, ()),
        array(2, (3,)) if has_barycentrics else None,
        array(3, (3, 2)) if has_derivatives else None,
        array(4, (3,)) if has_corners else None,
        faces,
        is_batch,
    )


def _views(camera: Any, points: np.ndarray, width: int, height: int) -> tuple[list[Any], bool]:
    """The views of all cameras, and whether there is a batch."""
    if camera is None:
        if points.shape[-1] != 4:
            raise ValueError("camera may be None only for vertices (n, 4), which are in clip space")
        camera = Camera.clip_space()
    are_many = not isinstance(camera, Camera)
    try:
        cameras = list(camera) if are_many else [camera]
    except TypeError:
        cameras = [None]
    if not all(isinstance(one, Camera) for one in cameras):
        raise ValueError(f"camera must be a Camera or a list of them, not {type(camera).__name__}")
    if are_many and points.ndim == 3 and len(cameras) != len(points):
        raise ValueError(f"camera has {len(cameras)} cameras, and vertices are {len(points)} shapes")
    if len(cameras) == 0 or points.ndim == 3 and len(points) == 0:
        raise ValueError(f"{'camera' if len(cameras) == 0 else 'vertices'} must have at least one in the batch")
    return [one.view(width, height) for one in cameras], are_many or points.ndim == 3


def interpolate(
    attributes: npt.ArrayLike,
    seen: Seen | Baked,
    faces: FacesLike | None = None,
    *,
    derivatives: bool = False,
    background: float = 0.0,
    threads: int | None = None,
) -> npt.NDArray[np.float32]:
    """Attributes of the vertices at each pixel, right in perspective.

    attributes: (n, c) or (n,): numbers of each vertex, of any kind; (b, n, c) for each shape of a batch.
    seen: from `rasterize`, with barycentrics or, for `derivatives`, with derivatives; or from `bake`.
    faces: other numbers for the corners of the same triangles (m, 3), such as those of texture coordinates in a file that
        counts them apart.
    derivatives: whether to return not the attributes, but their changes per pixel to the right, and per pixel downwards.
    background: what is returned where there is no face; derivatives are 0 there.

    Returns the shape of `seen.face` and (c,), f32, without it if attributes are (n,); and (2,) for derivatives.
    """
    if not isinstance(seen, (Seen, Baked)):
        raise ValueError(f"seen must be what `rasterize` or `bake` returned, not {type(seen).__name__}")
    background = arguments.any_number("background", background)
    weights = seen.derivatives if derivatives else seen.barycentrics
    if weights is None:
        name = "derivatives" if derivatives else "barycentrics"
        raise ValueError(f"seen has no {name}: rasterize with {name}=True")
    values = arguments.floats32("attributes", attributes)
    is_flat = values.ndim == 1
    values = values[:, None] if is_flat else values
    if values.ndim not in (2, 3) or values.ndim == 3 and not (seen.is_batch and len(values) == len(seen.face)):
        raise ValueError(f"attributes must have the shape (n, c) or (n,), or (b, n, c) for a batch of b, not {values.shape}")
    if faces is not None and seen.corners is not None:
        raise ValueError("faces may be given only where all are triangles")
    if faces is not None:
        own = arguments.faces(faces, values.shape[-2])
        if not own.are_triangles or own.total != seen.faces.total:
            raise ValueError(f"faces must be as many triangles as were drawn, ({seen.faces.total}, 3)")
        corners = own.indices
    elif seen.corners is not None:
        corners = seen.corners.reshape(-1, 3)
    else:
        corners = seen.faces.indices
    if corners.size and corners.max() >= values.shape[-2]:
        raise ValueError(f"attributes are of {values.shape[-2]} vertices, and faces refer to {corners.max()}")
    out = _filled(seen.face.shape + values.shape[-1:] + ((2,) if derivatives else ()), 0 if derivatives else background)
    parts = zip(values, seen.face, weights, out, strict=True) if values.ndim == 3 else [(values, seen.face, weights, out)]
    of_pixels = seen.corners is not None
    for i, (value, face, weight, result) in enumerate(parts):
        own_corners = corners.reshape(len(values), -1, 3)[i] if of_pixels and values.ndim == 3 else corners
        _polyscan.interpolate(
            value,
            (np.ascontiguousarray(own_corners), of_pixels),
            np.ascontiguousarray(face).reshape(-1),
            (np.ascontiguousarray(weight).reshape(-1), derivatives),
            result.reshape(-1),
            arguments.threads(threads),
        )
    if is_flat:
        return out[..., 0, :] if derivatives else out[..., 0]
    return out


def _filled(shape: tuple[int, ...], value: float) -> np.ndarray:
    if value == 0:
        return np.zeros(shape, np.float32)
    return np.full(shape, value, np.float32)
