# The compiled half. Arguments are checked before they come here.

from typing import Any

import numpy as np
import numpy.typing as npt

_Faces = tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint64] | None]
_Floats = npt.NDArray[np.float32]

def rasterize(
    vertices: npt.NDArray[np.float32] | npt.NDArray[np.float64], faces: _Faces, how: dict[str, Any]
) -> tuple[npt.NDArray[np.int32], _Floats, _Floats, _Floats, npt.NDArray[np.uint32]]: ...
def sample_places(count: int) -> list[list[float]]: ...
def bake_weights(
    uv: npt.NDArray[np.float32] | npt.NDArray[np.float64],
    faces: npt.NDArray[np.uint32],
    size: tuple[int, int],
    margin: int,
    threads: int | None,
) -> tuple[npt.NDArray[np.int32], _Floats, npt.NDArray[np.bool_], list[list[int]]]: ...
def interpolate(
    attributes: _Floats,
    corners: tuple[npt.NDArray[np.uint32], bool],
    face: npt.NDArray[np.int32],
    weights: tuple[_Floats, bool],
    out: _Floats,
    threads: int | None,
) -> None: ...
def render_file(path: str, how: dict[str, Any]) -> tuple[npt.NDArray[np.uint8], list[str]]: ...
def render_mesh(
    vertices: npt.NDArray[np.float32] | npt.NDArray[np.float64],
    faces: _Faces,
    look: dict[str, Any],
    how: dict[str, Any],
) -> tuple[npt.NDArray[np.uint8], list[str]]: ...

class Texture:
    def __new__(cls, picture: npt.NDArray[Any], format: str, how: dict[str, Any]) -> Texture: ...
    @property
    def channels(self) -> int: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def sample(self, uv: _Floats, derivatives: _Floats | None, out: _Floats, threads: int | None) -> None: ...
