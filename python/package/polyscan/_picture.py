"""Pictures of whole models, as the command line tool draws them."""

from __future__ import annotations

import os
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _polyscan
from ._camera import Camera
from ._rasterize import FacesLike


def render(
    model: Any,
    faces: FacesLike | None = None,
    *,
    size: tuple[int, int] = (800, 600),
    samples: int = 3,
    colors: npt.ArrayLike | None = None,
    background: npt.ArrayLike | None = None,
    camera: Camera | None = None,
    yaw: float = 30.0,
    pitch: float = 20.0,
    field_of_view: float = 34.0,
    up: npt.ArrayLike | None = None,
    crease: float = 60.0,
    tile: tuple[int, int, int, int] | None = None,
    threads: int | None = None,
) -> npt.NDArray[np.uint8]:
    """A picture of a model: framed, lit from both sides, antialiased, on a transparent background.

    model: the path of a glTF, GLB, OBJ, PLY or STL file; an object with `vertices` and `faces`, such as those of `trimesh`;
        or vertices (n, 3), with `faces`.
    faces: as in `rasterize`, if the model is an array of vertices.
    size: width and height in pixels.
    samples: samples a pixel in x and in y, from 1 to 8.
    colors: (n, 3) or (n, 4) u8, sRGB, of the vertices; those of a `trimesh` are taken by themselves.
    background: (r, g, b), sRGB from 0 to 255; transparent if left out.
    camera: instead of one that sees the whole model. Its z must be as in `Camera`.
    yaw, pitch: how far the camera has gone around the model to the right, and above it, in degrees.
    field_of_view: the vertical angle of view, in degrees.
    up: the axis that is up: z for STL files, else y.
    crease: computed normals are smooth where faces meet at less, in degrees.
    tile: left column, top row, width and height of a part of the picture, which is the same to the bit as there.
    threads: how many take part; as many as there are processors if left out.

    Returns (height, width, 4) u8: sRGB with straight alpha. What a file lacks is a `UserWarning`.
    """
    width, height = arguments.size(size)
    samples = arguments.whole("samples", samples, 1, 8)
    if max(width, height) * samples > arguments.MAX_SIZE:
        raise ValueError(f"size times samples may be {arguments.MAX_SIZE} at most on each side: choose fewer samples")
    window = arguments.tile(tile, width, height)
    view = None
    if camera is not None:
        if not isinstance(camera, Camera):
            raise ValueError(f"camera must be a Camera, not {type(camera).__name__}")
        seen = camera.view(width, height)
        if seen.bend is not None:
            raise ValueError("camera must have no distortion here: rasterize with it")
        view = (seen.clip_from_object.tolist(), seen.is_opengl, seen.is_reversed)
    how = {
        "size": [width, height],
        "tile": list(window),
        "samples": samples,
        "background": _background(background),
        "crease": float(np.radians(arguments.number("crease", crease, 0, 180))),
        "yaw": float(np.radians(arguments.number("yaw", yaw))),
        "pitch": float(np.radians(arguments.number("pitch", pitch))),
        "field_of_view": float(np.radians(arguments.number("field_of_view", field_of_view, 1, 170))),
        "up": None if up is None else arguments.finite("up", up, (3,)).tolist(),
        "camera": view,
        "threads": arguments.threads(threads),
    }
    if isinstance(model, (str, os.PathLike)):
        if faces is not None or colors is not None:
            raise ValueError(f"{'faces' if faces is not None else 'colors'} belong to arrays, and model is a path")
        pixels, notes = _polyscan.render_file(os.fspath(model), how)
    else:
        if faces is None:
            model, faces, colors = _parts(model, colors)
        points = arguments.vertices(model, "model")
        if points.shape[1:] != (3,):
            raise ValueError(f"model must be vertices of the shape (n, 3), not {points.shape}")
        checked = arguments.faces(faces, len(points))
        codes = None if colors is None else _codes(colors, len(points))
        pixels, notes = _polyscan.render_mesh(points, (checked.indices, checked.ends), codes, how)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return pixels.reshape(window[3], window[2], 4)


def _parts(model: Any, colors: Any) -> tuple[Any, Any, Any]:
    """The arrays of an object that has them."""
    if not (hasattr(model, "vertices") and hasattr(model, "faces")):
        raise ValueError("model must be a path, an object with vertices and faces, or vertices with `faces` beside them")
    visual = getattr(model, "visual", None)
    if colors is None and visual is not None and getattr(visual, "kind", None) == "vertex":
        colors = visual.vertex_colors
    return model.vertices, model.faces, colors


def _codes(colors: Any, count: int) -> bytes:
    codes = arguments.array("colors", colors)
    if codes.dtype != np.uint8 or codes.shape not in ((count, 3), (count, 4)):
        raise ValueError(f"colors must be u8 of the shape ({count}, 3) or ({count}, 4), not {codes.dtype} {codes.shape}")
    if codes.shape[1] == 3:
        codes = np.concatenate([codes, np.full((count, 1), 255, np.uint8)], axis=1)
    return codes.tobytes()


def _background(background: Any) -> list[float]:
    """Linear light, premultiplied, of sRGB codes."""
    if background is None:
        return [0.0, 0.0, 0.0, 0.0]
    codes = arguments.finite("background", background, (3,)) / 255
    if codes.min() < 0 or codes.max() > 1:
        raise ValueError(f"background must be from 0 to 255, not {background}")
    light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    return [*light.tolist(), 1.0]
