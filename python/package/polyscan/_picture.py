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
from ._texture import Texture


def render(
    model: Any,
    faces: FacesLike | None = None,
    *,
    size: tuple[int, int] = (800, 600),
    samples: int = 3,
    colors: npt.ArrayLike | None = None,
    face_colors: npt.ArrayLike | None = None,
    uv: npt.ArrayLike | None = None,
    texture: Texture | npt.ArrayLike | None = None,
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

    model: the path of a glTF, GLB, OBJ, PLY or STL file; an object with `vertices` and `faces`, such as those of `trimesh`,
        whose colours and textures are drawn; or vertices (n, 3), with `faces`.
    faces: as in `rasterize`, if the model is an array of vertices.
    size: width and height in pixels.
    samples: samples a pixel in x and in y, from 1 to 8.
    colors, face_colors: (n, 3) or (n, 4) u8 of the vertices, or (m, 3) or (m, 4) of the faces, or (3,) or (4,) for all: sRGB,
        and alpha, below 255 for glass.
    uv: (n, 2) texture coordinates of the vertices, u to the right, v DOWN. Where they part, at a seam, vertices are given once
        for each side: surfaces stay smooth across all the same.
    texture: the picture there, as in `Texture`, or a `Texture`; colours multiply it.
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
        given = {"faces": faces, "colors": colors, "face_colors": face_colors, "uv": uv, "texture": texture}
        for name, value in given.items():
            if value is not None:
                raise ValueError(f"{name} may be given with arrays, but model is a path")
        pixels, notes = _polyscan.render_file(os.fspath(model), how)
    else:
        look = {"colors": colors, "face_colors": face_colors, "uv": uv, "texture": texture}
        if faces is None:
            model, faces, own = _parts(model)
            if all(value is None for value in look.values()):
                look |= own
        points = arguments.vertices(model, "model")
        if points.shape[1:] != (3,):
            raise ValueError(f"model must be vertices of the shape (n, 3), not {points.shape}")
        checked = arguments.faces(faces, len(points))
        pixels, notes = _polyscan.render_mesh(
            points, (checked.indices, checked.ends), _look(look, len(points), checked.total), how
        )
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return pixels.reshape(window[3], window[2], 4)


def _parts(model: Any) -> tuple[Any, Any, dict[str, Any]]:
    """The vertices and faces of an object that has them, and how it looks."""
    if hasattr(model, "geometry") and hasattr(model, "to_mesh"):
        # A scene of trimesh.
        model = model.to_mesh()
    if not (hasattr(model, "vertices") and hasattr(model, "faces")):
        raise ValueError("model must be a path, an object with vertices and faces, or vertices with `faces` beside them")
    return model.vertices, model.faces, _visual(getattr(model, "visual", None))


def _visual(visual: Any) -> dict[str, Any]:
    """The looks of a `trimesh`."""
    kind = getattr(visual, "kind", None)
    if kind == "vertex":
        return {"colors": visual.vertex_colors}
    if kind == "face":
        return {"face_colors": visual.face_colors}
    if kind != "texture":
        return {}
    material, uv = visual.material, visual.uv
    picture = getattr(material, "image", None)
    if picture is None:
        picture = getattr(material, "baseColorTexture", None)
    if picture is None or uv is None:
        color = getattr(material, "main_color", None)
        return {} if color is None else {"face_colors": color}
    # Its v is up.
    pixels = np.asarray(picture.convert("RGBA"))
    opaque = (pixels[..., 3] == 255).all()
    return {"uv": np.asarray(uv) * [1, -1] + [0, 1], "texture": pixels[..., :3] if opaque else pixels}


def _look(look: dict[str, Any], count: int, total: int) -> dict[str, Any]:
    """Looks, checked, of so many vertices and faces."""
    colors, face_colors = (
        None if look[name] is None else _codes(name, look[name], number)
        for name, number in (("colors", count), ("face_colors", total))
    )
    if colors is not None and face_colors is not None:
        raise ValueError("face_colors must be left out where colors are given")
    uv, picture = look["uv"], look["texture"]
    if (uv is None) != (picture is None):
        raise ValueError("texture must be given with uv" if picture is None else "uv must be given with texture")
    if uv is not None:
        uv = arguments.floats32("uv", uv)
        if uv.shape != (count, 2):
            raise ValueError(f"uv must have the shape ({count}, 2), not {uv.shape}")
        if not np.isfinite(uv).all():
            raise ValueError(f"uv[{np.argmax(~np.isfinite(uv).all(axis=1))}] is not finite")
    made = None if picture is None else _texture(picture)
    alphas = [codes[:, 3].min(initial=255) for codes in (colors, face_colors) if codes is not None]
    has_alpha = made is not None and made.channels in (2, 4)
    return {
        "colors": colors,
        "face_colors": face_colors,
        "uv": uv,
        "texture": None if made is None else made._texture,
        "is_glass": has_alpha or any(alpha < 255 for alpha in alphas),
    }


def _texture(picture: Any) -> Texture:
    if isinstance(picture, Texture):
        return picture
    try:
        return Texture(picture)
    except ValueError as error:
        raise ValueError(f"texture: {error}") from None


def _codes(name: str, value: Any, count: int) -> np.ndarray:
    codes = arguments.array(name, value)
    if codes.ndim == 1 and codes.dtype == np.uint8 and len(codes) in (3, 4):
        # One for all.
        codes = np.broadcast_to(codes, (count, len(codes)))
    if codes.dtype != np.uint8 or codes.shape not in ((count, 3), (count, 4)):
        raise ValueError(f"{name} must be u8 of the shape ({count}, 3) or ({count}, 4), not {codes.dtype} {codes.shape}")
    if codes.shape[1] == 3:
        codes = np.concatenate([codes, np.full((count, 1), 255, np.uint8)], axis=1)
    return np.ascontiguousarray(codes)


def _background(background: Any) -> list[float]:
    """Linear light, premultiplied, of sRGB codes."""
    if background is None:
        return [0.0, 0.0, 0.0, 0.0]
    codes = arguments.finite("background", background, (3,)) / 255
    if codes.min() < 0 or codes.max() > 1:
        raise ValueError(f"background must be from 0 to 255, not {background}")
    light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    return [*light.tolist(), 1.0]
