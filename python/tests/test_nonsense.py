"""Anything in the place of any argument is taken as it stands, or refused with a `ValueError` that begins with its name."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import polyscan
import polyscan.nvdiffrast as dr
from polyscan import Camera

SQUARE = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
CAMERA = Camera.perspective(60, polyscan.look_at([0, 0, 3], [0, 0, 0]))
SEEN = polyscan.rasterize(SQUARE, FACES, CAMERA, (8, 8), derivatives=True)
K = np.array([[600.0, 0, 4], [0, 600, 4], [0, 0, 1]])
POS, GREY = np.ones((1, 3, 4), np.float32), np.full((4, 3), 128, np.uint8)
RAST, RAST_DB = dr.rasterize(None, POS, [[0, 1, 2]], [4, 4])
UV = np.zeros((1, 4, 4, 2), np.float32)

#: What is called, and with what: all of it is right.
CALLS: list[tuple[Any, dict[str, Any]]] = [
    (polyscan.interpolate, {"attributes": SQUARE, "seen": SEEN, "faces": FACES, "background": 0.0, "threads": 1}),
    (polyscan.bake, {"uv": SQUARE[:, :2], "faces": FACES, "size": (4, 4), "margin": 1, "threads": 1}),
    (polyscan.render, {"model": SQUARE, "faces": FACES, "size": (4, 4), "samples": 1, "colors": GREY, "background": (1, 2, 3)}),
    (
        polyscan.render,
        {"model": SQUARE, "faces": FACES, "yaw": 1, "pitch": 2, "field_of_view": 30, "up": (0, 1, 0), "crease": 9},
    ),
    (polyscan.render, {"model": SQUARE, "faces": FACES, "size": (4, 4), "tile": (0, 0, 1, 1), "camera": CAMERA, "threads": 1}),
    (polyscan.render, {"model": SQUARE, "faces": FACES, "size": (4, 4), "uv": SQUARE[:, :2], "texture": np.zeros((2, 2))}),
    (polyscan.render, {"model": SQUARE, "faces": FACES, "size": (4, 4), "face_colors": GREY[:2]}),
    (polyscan.texture, {"picture": np.zeros((2, 2)), "uv": UV[0, 0], "derivatives": np.zeros((4, 2, 2)), "threads": 1}),
    (polyscan.Texture, {"picture": np.zeros((2, 2)), "colors": "auto", "filter": "mitchell", "mip_filter": "ewa", "most": 3}),
    (polyscan.Texture, {"picture": np.zeros((2, 2)), "wrap": "clamp", "border": (0, 0, 0, 0), "level_range": (0, 3)}),
    (polyscan.Texture, {"picture": np.zeros((2, 2)), "level_bias": 0.5}),
    (Camera.opencv, {"K": K, "pose": np.eye(4), "distortion": [0, 0, 0, 0], "lens_error": 0.1, "pixel_center": 0}),
    (Camera.opencv, {"K": K, "near": 0.1, "far": 3.0}),
    (Camera.perspective, {"field_of_view": 30, "pose": np.eye(4), "near": 0.1, "far": 3.0}),
    (Camera.orthographic, {"width": 1, "height": 2, "pose": np.eye(4), "near": 0.1, "far": 3.0}),
    (Camera.projection, {"matrix": np.eye(4), "depth_range": "zero_to_one"}),
    (Camera.clip_space, {"depth_range": "zero_to_one"}),
    (Camera.around, {"vertices": SQUARE, "yaw": 1, "pitch": 1, "up": (0, 1, 0), "field_of_view": 30}),
    (CAMERA.matrix, {"width": 4, "height": 3}),
    (polyscan.look_at, {"eye": [0, 0, 3], "target": [0, 0, 0], "up": [0, 1, 0]}),
    (polyscan.opengl_pose, {"camera_to_world": np.eye(4)}),
    (polyscan.sample_places, {"samples": 4}),
    (dr.rasterize, {"glctx": None, "pos": POS, "tri": [[0, 1, 2]], "resolution": [4, 4]}),
    (dr.rasterize, {"glctx": None, "pos": POS[0], "tri": [[0, 1, 2]], "resolution": [4, 4], "ranges": [[0, 1]]}),
    (dr.interpolate, {"attr": POS, "rast": RAST, "tri": [[0, 1, 2]], "rast_db": RAST_DB, "diff_attrs": [0]}),
    (dr.texture, {"tex": np.ones((1, 2, 2, 3)), "uv": UV, "mip_level_bias": 0.0, "filter_mode": "linear"}),
    (dr.texture, {"tex": np.ones((1, 2, 2, 3)), "uv": UV, "uv_da": np.zeros((1, 4, 4, 4)), "boundary_mode": "zero"}),
]

#: What another argument may rightly be said to be wrong with, where one is changed.
OTHERS = {
    "attributes": ("faces",),
    "model": ("faces", "vertices", "colors", "uv"),
    "faces": ("model", "face_colors"),
    "uv": ("texture", "derivatives", "uv_da", "tex"),
    "texture": ("uv",),
    "far": ("near",),
    "width": ("size",),
    "height": ("size",),
    "target": ("up",),
    "eye": ("up",),
    "pos": ("tri", "ranges"),
    "attr": ("tri", "diff_attrs"),
    "rast": ("rast_db", "tri", "attr"),
    "rast_db": ("diff_attrs",),
    "tri": ("rast", "ranges"),
    "ranges": ("pos",),
    "tex": ("picture",),
}

NONSENSE: list[Any] = [
    *(None, True, 3, -1, 10**30, 2.5, float("nan"), float("inf"), 1j, "x", "", b"q", object(), len),
    *([], [[]], [1, 2], [1, [2]], [1j, 2], ["a", "b"], (1, 2, 3), {}, {"a": 1}, [10**400], [[10**30, 0, 1]], [None]),
    *(np.zeros(0), np.zeros((2, 3)), np.zeros((2, 2, 2, 2)), np.array(5), np.array("x"), np.array([None])),
    *(np.full((4, 3), np.nan), np.full((4, 4), -np.inf), np.zeros((0, 3)), np.zeros((4, 0)), np.ones((1, 4, 4, 4))),
]


@pytest.mark.parametrize(("call", "given"), CALLS)
def test_nonsense_is_taken_or_refused_by_name(call: Any, given: dict[str, Any]) -> None:
    call(**given)
    refused = 0
    for name in given:
        names = (name, *OTHERS.get(name, ()))
        for value in NONSENSE:
            try:
                call(**{**given, name: value})
            except ValueError as error:
                refused += 1
                assert str(error).startswith(names), f"{name} = {value!r}: {error}"
    assert refused > 10 * (len(given) - 1), "much that is wrong was taken"
