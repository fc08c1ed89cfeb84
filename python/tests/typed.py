"""What a checker of types has to accept, and to infer. It is checked, not run."""

from __future__ import annotations

from typing import assert_type

import numpy as np
import numpy.typing as npt

import polyscan
import polyscan.nvdiffrast as dr

vertices = np.zeros((4, 3), np.float32)
seen = polyscan.rasterize(vertices, [[0, 1, 2, 3]], polyscan.Camera.perspective(40), (4, 3), derivatives=True)
assert_type(seen, polyscan.Seen)
assert_type(seen.face, npt.NDArray[np.int32])
assert_type(seen.depth, npt.NDArray[np.float32])
ragged = polyscan.Polygons([0, 1, 2], [0, 3])
polyscan.rasterize(np.zeros((2, 4, 3)), ragged, [polyscan.Camera.perspective(40)] * 2, (4, 3), tile=(0, 0, 1, 1))
assert_type(polyscan.interpolate(vertices, seen), npt.NDArray[np.float32])
assert_type(polyscan.texture(polyscan.Texture(np.zeros((2, 2))), vertices[:, :2]), npt.NDArray[np.float32])
assert_type(polyscan.render("model.glb", size=(4, 3)), npt.NDArray[np.uint8])
assert_type(polyscan.rasterize(vertices, [[0, 1, 2]], None, (4, 3), samples=8).face, npt.NDArray[np.int32])
assert_type(polyscan.sample_places(8), npt.NDArray[np.float64])
picture = polyscan.render(
    vertices, [[0, 1, 2]], uv=vertices[:, :2], texture=np.zeros((2, 2)), colors=np.zeros((4, 3), np.uint8)
)
assert_type(picture, npt.NDArray[np.uint8])
with dr.DepthPeeler(dr.RasterizeCudaContext(), np.zeros((1, 3, 4)), [[0, 1, 2]], [3, 4]) as peeler:
    assert_type(peeler.rasterize_next_layer()[0], npt.NDArray[np.float32])
assert_type(polyscan.look_at([0, 0, 1], [0, 0, 0]), np.ndarray)
rast, rast_db = dr.rasterize(None, np.zeros((1, 3, 4)), [[0, 1, 2]], [3, 4])
assert_type(rast, npt.NDArray[np.float32])
