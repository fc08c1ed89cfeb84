"""Exact polygon rasterization on the CPU.

`rasterize` finds the face, the depth and the barycentrics that are seen at each pixel, `bake` those at each texel of a
texture; `interpolate` and `texture` make pictures of them; `render` draws whole models. Cameras are `Camera`s: OpenCV's,
perspective, orthographic, or any projection matrix.

Pictures have their first row at the top, and pixel (i, j) is sampled at its centre, (i + 0.5, j + 0.5), or at several
`sample_places` around it. Nothing is global: threads are set by each call, and a process may fork.
"""

from ._arguments import Polygons
from ._bake import Baked, bake
from ._camera import Camera, look_at, opengl_pose
from ._picture import render
from ._rasterize import Seen, interpolate, rasterize, sample_places
from ._texture import Texture, texture

__version__ = "0.1.0"

__all__ = [
    "Baked",
    "Camera",
    "Polygons",
    "Seen",
    "Texture",
    "bake",
    "interpolate",
    "look_at",
    "opengl_pose",
    "rasterize",
    "render",
    "sample_places",
    "texture",
]
