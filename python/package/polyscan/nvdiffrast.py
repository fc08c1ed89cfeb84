"""nvdiffrast's forward calls, with its layout, on numpy arrays:

    import polyscan.nvdiffrast as dr
    glctx = dr.RasterizeCudaContext()
    rast, rast_db = dr.rasterize(glctx, pos, tri, resolution=[height, width])
    uv, uv_da = dr.interpolate(attr, rast, tri, rast_db=rast_db, diff_attrs="all")
    color = dr.texture(tex, uv, uv_da, filter_mode="linear-mipmap-linear")

Rows run upwards, as in OpenGL and there: turn pictures around with `[:, ::-1]` to look at them. Nothing is
differentiated, and there is no `antialias`, which is there for gradients: take the mean of samples instead
(`polyscan.rasterize(samples=8)`). Tensors of PyTorch on the CPU are taken as arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _polyscan
from ._camera import Camera
from ._rasterize import rasterize as _rasterize
from ._texture import Texture

Floats = npt.NDArray[np.float32]


class RasterizeCudaContext:
    """Nothing: it is made where nvdiffrast's is, and takes its arguments."""

    def __init__(self, *args: Any, **options: Any) -> None:
        pass


class RasterizeGLContext(RasterizeCudaContext):
    """The same."""


def rasterize(
    glctx: Any,
    pos: npt.ArrayLike,
    tri: npt.ArrayLike,
    resolution: Sequence[int],
    ranges: Any = None,
    grad_db: bool = True,
) -> tuple[Floats, Floats]:
    """The triangle that is seen at each pixel.

    glctx: anything: a context here is nothing.
    pos: (b, n, 4) f32, clip space, -w <= z <= w; or (n, 4) with `ranges`.
    tri: (m, 3) i32.
    resolution: height and width in pixels.
    ranges: (b, 2): where the triangles of each picture begin, and how many they are, if pos is (n, 4).
    grad_db: whether the second array is wanted; its last axis is empty if not.

    Returns (b, height, width, 4) f32: u, v, z/w, triangle number + 1, with 0 for none; u and v are the weights of the first
    and the second corner. And (b, height, width, 4) f32: du/dX, du/dY, dv/dX, dv/dY per pixel, Y upwards.
    """
    return _layer(0, pos, tri, resolution, ranges, grad_db)


class DepthPeeler:
    """The layers of a picture, one after the other, the nearest first:

    with dr.DepthPeeler(glctx, pos, tri, resolution) as peeler:
        for i in range(3):
            rast, rast_db = peeler.rasterize_next_layer()

    At most 64. Arguments and results are those of `rasterize`.
    """

    def __init__(
        self,
        glctx: Any,
        pos: npt.ArrayLike,
        tri: npt.ArrayLike,
        resolution: Sequence[int],
        ranges: Any = None,
        grad_db: bool = True,
    ) -> None:
        self._scene = (pos, tri, resolution, ranges, grad_db)
        self._next = 0

    def __enter__(self) -> DepthPeeler:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def rasterize_next_layer(self) -> tuple[Floats, Floats]:
        self._next += 1
        return _layer(self._next - 1, *self._scene)


def _layer(
    layer: int, pos: npt.ArrayLike, tri: npt.ArrayLike, resolution: Sequence[int], ranges: Any, grad_db: bool
) -> tuple[Floats, Floats]:
    points = arguments.floats32("pos", pos)
    try:
        height, width = (int(side) for side in resolution)
    except (TypeError, ValueError):
        raise ValueError(f"resolution must be [height, width], not {resolution!r}") from None
    faces = arguments.faces(tri, points.shape[-2] if points.ndim > 1 else 0, "tri")
    if not faces.are_triangles:
        raise ValueError(f"tri must have the shape (m, 3), not {faces.indices.shape}")
    if ranges is None:
        if points.ndim != 3 or points.shape[2] != 4:
            raise ValueError(f"pos must have the shape (b, n, 4), or (n, 4) with ranges, not {points.shape}")
        parts = [(shape, 0, faces.total) for shape in points]
    else:
        bounds = arguments.array("ranges", ranges)
        if bounds.dtype.kind == "f":
            raise ValueError(f"ranges must be whole numbers, not of {bounds.dtype}")
        bounds = bounds.astype(np.int64)
        if points.ndim != 2 or points.shape[1] != 4 or bounds.ndim != 2 or bounds.shape[1] != 2:
            raise ValueError("ranges must have the shape (b, 2), and pos (n, 4)")
        if bounds.size and (bounds.min() < 0 or bounds.sum(axis=1).max() > faces.total):
            raise ValueError(f"ranges must lie within the {faces.total} triangles")
        parts = [(points, int(start), int(start + count)) for start, count in bounds]
    rast = np.zeros((len(parts), height, width, 4), np.float32)
    rast_db = np.zeros((len(parts), height, width, 4 if grad_db else 0), np.float32)
    camera = Camera.clip_space(depth_range="minus_one_to_one")
    for i, (shape, start, end) in enumerate(parts):
        triangles = faces.indices[start:end]
        try:
            seen = _rasterize(shape, triangles, camera, (width, height), derivatives=bool(grad_db), layers=layer + 1)
        except ValueError as error:
            raise ValueError(str(error).replace("vertices", "pos").replace("size", "resolution")) from None
        assert seen.barycentrics is not None
        face, weights, slopes = seen.face, seen.barycentrics, seen.derivatives
        if layer > 0:
            face, weights = face[..., layer], weights[..., layer, :]
            slopes = None if slopes is None else slopes[..., layer, :, :]
        # Our rows run downwards.
        out = rast[i, ::-1]
        out[..., :2] = weights[..., :2]
        out[..., 2] = _z_over_w(shape, triangles, face, weights)
        out[..., 3] = np.where(face >= 0, face + start + 1, 0)
        if slopes is not None:
            down = slopes[..., :2, :]
            rast_db[i, ::-1] = (down * np.array([1, -1], np.float32)).reshape(height, width, 4)
    return rast, rast_db


def _z_over_w(points: np.ndarray, triangles: np.ndarray, face: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """z/w of the points that are seen; 0 where there are none."""
    z_and_w = np.zeros((*face.shape, 2), np.float32)
    if len(triangles):
        _interpolate(points[:, 2:], triangles, face, (weights, False), z_and_w)
    z, w = z_and_w[..., 0], z_and_w[..., 1]
    return np.divide(z, w, out=np.zeros_like(z), where=w > 0)


def _interpolate(
    values: np.ndarray, triangles: np.ndarray, face: np.ndarray, weights: tuple[np.ndarray, bool], out: np.ndarray
) -> None:
    numbers, are_pairs = weights
    _polyscan.interpolate(
        np.ascontiguousarray(values),
        (np.ascontiguousarray(triangles), False),
        np.ascontiguousarray(face).reshape(-1),
        (np.ascontiguousarray(numbers).reshape(-1), are_pairs),
        out.reshape(-1),
        None,
    )


def interpolate(
    attr: npt.ArrayLike,
    rast: npt.ArrayLike,
    tri: npt.ArrayLike,
    rast_db: npt.ArrayLike | None = None,
    diff_attrs: str | Sequence[int] | None = None,
) -> tuple[Floats, Floats]:
    """Attributes at pixels.

    attr: (b, n, c), (1, n, c) or (n, c) f32.
    rast: from `rasterize`; tri: (m, 3) i32.
    rast_db, diff_attrs: the derivatives from `rasterize`, and of which attributes they are wanted: numbers, or "all".

    Returns (b, height, width, c) f32, and (b, height, width, 2 k) f32: dA/dX and dA/dY of each of k attributes.
    """
    seen = arguments.floats32("rast", rast)
    if seen.ndim != 4 or seen.shape[3] != 4:
        raise ValueError(f"rast must have the shape (b, height, width, 4), not {seen.shape}")
    values = arguments.floats32("attr", attr)
    values = values[None] if values.ndim == 2 else values
    if values.ndim != 3 or len(values) not in (1, len(seen)):
        raise ValueError(f"attr must have the shape (b, n, c), (1, n, c) or (n, c), not {values.shape}")
    triangles = arguments.faces(tri, values.shape[1], "tri").indices
    numbers = seen[..., 3]
    if not ((numbers >= 0) & (numbers < 2.0**31)).all():
        raise ValueError("rast must have numbers of triangles, from 1 on, or 0 in its last channel")
    face = numbers.astype(np.int64).astype(np.int32) - 1
    if face.size and face.max() >= len(triangles):
        raise ValueError(f"tri has {len(triangles)} triangles, and rast refers to {face.max()}")
    channels = values.shape[2]
    out = np.zeros((*face.shape, channels), np.float32)
    chosen = _chosen(diff_attrs, channels)
    slopes = np.zeros((*face.shape, len(chosen), 2), np.float32)
    if chosen:
        if rast_db is None:
            raise ValueError("rast_db is needed for diff_attrs")
        sides = arguments.floats32("rast_db", rast_db)
        if sides.shape != seen.shape:
            raise ValueError(f"rast_db must have the shape {seen.shape}, not {sides.shape}")
        sides = sides.reshape(*face.shape, 2, 2)
        sides = np.concatenate([sides, -sides.sum(axis=-2, keepdims=True)], axis=-2)
    third = np.where(face >= 0, 1 - seen[..., 0] - seen[..., 1], 0).astype(np.float32)
    weights = np.concatenate([seen[..., :2], third[..., None]], axis=-1)
    for i in range(len(seen)):
        value = values[i if len(values) > 1 else 0]
        _interpolate(value, triangles, face[i], (weights[i], False), out[i])
        if chosen:
            _interpolate(value[:, chosen], triangles, face[i], (sides[i], True), slopes[i])
    return out, slopes.reshape(*face.shape, 2 * len(chosen))


def _chosen(diff_attrs: Any, channels: int) -> list[int]:
    """The numbers of the attributes whose derivatives are wanted."""
    if isinstance(diff_attrs, str) and diff_attrs == "all":
        return list(range(channels))
    try:
        return [arguments.whole("diff_attrs", i, 0, channels - 1) for i in (() if diff_attrs is None else diff_attrs)]
    except TypeError:
        raise ValueError(f'diff_attrs must be whole numbers or "all", not {diff_attrs!r}') from None


_FILTERS = {
    "nearest": ("nearest", "off"),
    "linear": ("bilinear", "off"),
    "linear-mipmap-nearest": ("bilinear", "nearest"),
    "linear-mipmap-linear": ("bilinear", "linear"),
}
_BOUNDARIES = {"wrap": "repeat", "clamp": "clamp", "zero": "border"}


def texture(
    tex: npt.ArrayLike,
    uv: npt.ArrayLike,
    uv_da: npt.ArrayLike | None = None,
    mip_level_bias: float = 0.0,
    filter_mode: str = "auto",
    boundary_mode: str = "wrap",
) -> Floats:
    """Colours of textures.

    tex: (b, height, width, c) or (1, height, width, c) f32, of any number of channels; its first row is at v = 0.
    uv: (b, height, width, 2); uv_da: (b, height, width, 4): du/dX, du/dY, dv/dX, dv/dY.
    filter_mode: "nearest", "linear", "linear-mipmap-nearest", "linear-mipmap-linear", or "auto": the last with uv_da, else
        "linear". The level of detail goes by the longer side of what a pixel sees, where nvdiffrast's goes by the longer axis
        of its ellipse.
    boundary_mode: "wrap", "clamp" or "zero".

    Returns (b, height, width, c) f32.
    """
    pictures, points = arguments.floats32("tex", tex), arguments.floats32("uv", uv)
    if points.ndim != 4 or points.shape[3] != 2:
        raise ValueError(f"uv must have the shape (b, height, width, 2), not {points.shape}")
    if pictures.ndim != 4 or len(pictures) not in (1, len(points)):
        raise ValueError(f"tex must have the shape (b, height, width, c) or (1, height, width, c), not {pictures.shape}")
    if isinstance(filter_mode, str) and filter_mode == "auto":
        filter_mode = "linear" if uv_da is None else "linear-mipmap-linear"
    chosen, mip_filter = _FILTERS[arguments.one_of("filter_mode", filter_mode, tuple(_FILTERS))]
    wrap = _BOUNDARIES[arguments.one_of("boundary_mode", boundary_mode, tuple(_BOUNDARIES))]
    sides = None
    if mip_filter != "off":
        if uv_da is None:
            raise ValueError(f"uv_da is needed for {filter_mode}")
        sides = arguments.floats32("uv_da", uv_da)
        if sides.shape != (*points.shape[:3], 4):
            raise ValueError(f"uv_da must have the shape {(*points.shape[:3], 4)}, not {sides.shape}")
        sides = sides.reshape(*points.shape[:3], 2, 2)
    bias = arguments.number("mip_level_bias", mip_level_bias)
    channels = pictures.shape[3]
    out = np.empty((*points.shape[:3], channels), np.float32)
    for i in range(len(points)):
        picture = pictures[i if len(pictures) > 1 else 0]
        for first in range(0, channels, 3):
            part = Texture(
                picture[..., first : first + 3],
                filter=chosen,
                mip_filter=mip_filter,
                wrap=wrap,
                level_bias=bias,
            )
            colors = part.sample(points[i], None if sides is None else sides[i])
            out[i, ..., first : first + 3] = colors
    return out
