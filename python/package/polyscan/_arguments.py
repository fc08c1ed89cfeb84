"""Arguments, brought to the form that the compiled half takes. What is wrong is a `ValueError` that names it."""

from __future__ import annotations

import operator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

#: The greatest width and height of a picture.
MAX_SIZE = 65536


class Polygons(NamedTuple):
    """Faces that differ in their numbers of corners.

    Face `i` has the corners `indices[offsets[i]:offsets[i + 1]]`.
    """

    #: The corners of all faces, end to end: vertex numbers, integers (k,).
    indices: npt.ArrayLike
    #: Where each face begins, and where the last one ends: integers (m + 1,), from 0, growing by 3 and more.
    offsets: npt.ArrayLike


class Faces(NamedTuple):
    """Faces that were checked."""

    indices: np.ndarray
    ends: np.ndarray | None

    @property
    def total(self) -> int:
        return len(self.indices) if self.ends is None else len(self.ends)

    @property
    def are_triangles(self) -> bool:
        return self.ends is None and self.indices.shape[1] == 3


def array(name: str, value: Any) -> np.ndarray:
    """An array of numbers."""
    try:
        made = np.asarray(value)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{name} is no array of numbers: {error}") from None
    if made.dtype.kind not in "fiu":
        raise ValueError(f"{name} must be an array of numbers, not of {made.dtype}")
    return made


def floats(name: str, value: Any) -> np.ndarray:
    """A contiguous array of f32 or f64: as it is, or a copy if it is neither, or has gaps."""
    made = array(name, value)
    if made.dtype != np.float32 and made.dtype != np.float64:
        made = made.astype(np.float32 if made.dtype == np.float16 else np.float64)
    return np.ascontiguousarray(made)


def floats32(name: str, value: Any) -> np.ndarray:
    """A contiguous array of f32: as it is, or a copy."""
    return np.ascontiguousarray(array(name, value), dtype=np.float32)


def finite(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    """A small array of finite f64 of a shape."""
    made = array(name, value).astype(np.float64)
    if made.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, not {made.shape}")
    if not np.isfinite(made).all():
        raise ValueError(f"{name} must be finite, but is {made.tolist()}")
    return made


def any_number(name: str, value: Any) -> float:
    """A number, which may be infinite or NaN."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be a number, not {value!r}") from None


def number(name: str, value: Any, least: float = -np.inf, most: float = np.inf) -> float:
    """A number that is finite and within bounds, which may not be met themselves if they are infinite."""
    made = any_number(name, value)
    if not (np.isfinite(made) and least <= made <= most):
        raise ValueError(f"{name} must be finite and from {least} to {most}, not {made}")
    return made


def whole(name: str, value: Any, least: int, most: int) -> int:
    """A whole number within bounds."""
    try:
        made = operator.index(value)
    except TypeError:
        raise ValueError(f"{name} must be a whole number, not {value!r}") from None
    if not least <= made <= most:
        raise ValueError(f"{name} must be from {least} to {most}, not {made}")
    return made


def one_of(name: str, value: Any, choices: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, choices))}, not {value!r}")
    return value


def size(value: Any) -> tuple[int, int]:
    """Width and height in pixels."""
    try:
        width, height = value
    except (TypeError, ValueError):
        raise ValueError(f"size must be (width, height) in pixels, not {value!r}") from None
    return whole("size[0]", width, 1, MAX_SIZE), whole("size[1]", height, 1, MAX_SIZE)


def tile(value: Any, width: int, height: int) -> tuple[int, int, int, int]:
    """The left column, top row, width and height of a part of a picture."""
    if value is None:
        return 0, 0, width, height
    try:
        left, top, wide, high = value
    except (TypeError, ValueError):
        raise ValueError(f"tile must be (left, top, width, height) in pixels, not {value!r}") from None
    left, top = whole("tile[0]", left, 0, width - 1), whole("tile[1]", top, 0, height - 1)
    return left, top, whole("tile[2]", wide, 1, width - left), whole("tile[3]", high, 1, height - top)


def samples(value: Any) -> int:
    """How many samples a pixel has."""
    made = whole("samples", value, 1, 16)
    if made not in (1, 4, 8, 16):
        raise ValueError(f"samples must be 1, 4, 8 or 16, not {made}")
    return made


def threads(value: Any) -> int | None:
    return None if value is None else whole("threads", value, 1, 1024)


def vertices(value: Any, name: str = "vertices") -> np.ndarray:
    """Positions (n, 3) or (n, 4), or batches of them. The compiled half finds those that are not finite."""
    made = floats(name, value)
    if made.ndim not in (2, 3) or made.shape[-1] not in (3, 4):
        raise ValueError(
            f"{name} must have the shape (n, 3), in object space, or (n, 4), homogeneous, "
            f"with one more axis in front for a batch; not {made.shape}"
        )
    return made


def faces(value: Any, count: int, name: str = "faces") -> Faces:
    """Faces whose corners are all below `count`: without a copy if they are contiguous and of 32 bits."""
    if isinstance(value, Faces):
        checked(value.indices, count, name)
        return value
    if isinstance(value, Polygons):
        return polygons(value, count, name)
    try:
        made = np.asarray(value)
    except ValueError:
        return ragged(value, count, name)
    if made.dtype == object:
        return ragged(value, count, name)
    if made.size == 0 and made.ndim < 2:
        made = np.empty((0, 3), np.uint32)
    if made.dtype.kind not in "iu":
        raise ValueError(f"{name} must be an array of whole numbers, not of {made.dtype}")
    if made.ndim != 2 or made.shape[1] < 3:
        raise ValueError(
            f"{name} must have the shape (m, 3) for triangles, or (m, k) for polygons of k corners, not {made.shape}"
        )
    return Faces(checked(made, count, name), None)


def checked(indices: np.ndarray, count: int, name: str) -> np.ndarray:
    """The indices as contiguous u32, all of them below `count`."""
    if indices.size:
        wrong = None
        if indices.dtype.kind == "i" and indices.min() < 0:
            wrong = np.argmax(indices < 0)
        elif indices.max() >= count:
            wrong = np.argmax(indices >= count)
        if wrong is not None:
            place = ", ".join(str(i) for i in np.unravel_index(wrong, indices.shape))
            raise ValueError(
                f"{name}[{place}] is {indices.flat[wrong]}, but the vertices are numbered from 0 to {count - 1}"
                if count
                else f"{name}[{place}] is {indices.flat[wrong]}, but there are no vertices"
            )
    if len(indices) > np.iinfo(np.int32).max:
        raise ValueError(f"{name} are {len(indices)}, and at most 2147483647 can be told apart")
    if indices.dtype == np.int32:
        return np.ascontiguousarray(indices).view(np.uint32)
    return np.ascontiguousarray(indices, dtype=np.uint32)


def ragged(value: Any, count: int, name: str) -> Faces:
    """Faces as a list of lists of different lengths."""
    try:
        rows = [np.asarray(row) for row in value]
        bad = [row.ndim != 1 or row.dtype.kind not in "iu" for row in rows]
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be an array of whole numbers, or lists of them") from None
    if any(bad):
        raise ValueError(f"{name}[{bad.index(True)}] must be a list of whole numbers")
    if not rows:
        raise ValueError(f"{name} must be an array of whole numbers, or lists of them")
    offsets = np.cumsum([0] + [len(row) for row in rows])
    return polygons(Polygons(np.concatenate(rows), offsets), count, name)


def polygons(value: Polygons, count: int, name: str) -> Faces:
    indices, offsets = array(f"{name}.indices", value.indices), array(f"{name}.offsets", value.offsets)
    for part, numbers in (("indices", indices), ("offsets", offsets)):
        if numbers.ndim != 1 or numbers.dtype.kind not in "iu":
            raise ValueError(f"{name}.{part} must be whole numbers in one row, not {numbers.dtype} {numbers.shape}")
    offsets = offsets.astype(np.int64)
    if len(offsets) == 0 or offsets[0] != 0 or offsets[-1] != len(indices):
        raise ValueError(f"{name}.offsets must begin with 0 and end with the number of indices, {len(indices)}")
    sides = np.diff(offsets)
    if len(sides) and sides.min() < 3:
        face = int(np.argmax(sides < 3))
        raise ValueError(f"{name}[{face}] has {sides[face]} corners, and a face has 3 at least")
    return Faces(checked(indices, count, name), offsets[1:].astype(np.uint64))
