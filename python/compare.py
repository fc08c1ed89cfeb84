"""Compares polyscan with what else gives depth or face ids without a GPU: CPU time, memory, and what each gets wrong.

    python compare.py            # the table, for README.md
    python compare.py --quick    # the small mesh and picture alone

Each measurement is a process of its own. `embreex` and `pyrender` take part if they can be imported; pyrender draws by
Mesa's llvmpipe through EGL, unless `PYOPENGL_PLATFORM` says `osmesa`. Where `PYRENDER_PYTHON` names another interpreter,
pyrender is asked there: it needs an environment of its own, by `pip install pyrender 'numpy<2'` and then
`pip install --upgrade pyopengl`.
"""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy as np

#: Rings of the ball: 4 n^2 faces.
MESHES = {"70 thousand": 132, "10 million": 1581}
SIZES = [(640, 480), (4096, 4096)]
EYE, NEAR, FAR, ANGLE = np.array([1.2, 0.9, 3.2]), 0.5, 10.0, 40.0


def ball(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """A ball with bumps, whose parts hide each other."""
    theta, phi = np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    x, y, z = np.sin(t) * np.cos(p), np.cos(t), -np.sin(t) * np.sin(p)
    radius = 1 + 0.25 * np.sin(7 * x + 1) * np.cos(6 * y) * np.sin(5 * z) + 0.05 * np.sin(23 * x * y)
    points = (radius[..., None] * np.stack([x, y, z], axis=-1)).reshape(-1, 3)
    index = np.arange(t.size, dtype=np.int32).reshape(t.shape)
    a, b = index[:-1], index[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return points.astype(np.float32), faces


def pose() -> np.ndarray:
    """From object space to OpenCV's camera, which looks at the middle."""
    ahead = -EYE / np.linalg.norm(EYE)
    right = np.cross([0, -1, 0], ahead)
    right /= np.linalg.norm(right)
    turn = np.stack([right, np.cross(ahead, right), ahead])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, -turn @ EYE
    return matrix


def ways(size: tuple[int, int]) -> np.ndarray:
    """The directions through all pixels' centres, with 1 along the view, in f64."""
    width, height = size
    half = np.tan(np.radians(ANGLE) / 2)
    x = ((np.arange(width) + 0.5) * 2 / width - 1) * half * width / height
    y = ((np.arange(height) + 0.5) * 2 / height - 1) * half
    x, y = np.meshgrid(x, y)
    return np.stack([x, y, np.ones_like(x)], axis=-1) @ pose()[:3, :3]


class Polyscan:
    def __init__(self, vertices: np.ndarray, faces: np.ndarray, size: tuple[int, int]) -> None:
        import polyscan

        self.call = polyscan.rasterize
        self.mesh, self.size = (vertices, faces), size
        self.camera = polyscan.Camera.perspective(ANGLE, pose(), near=NEAR)

    def draw(self) -> tuple[np.ndarray | None, np.ndarray]:
        seen = self.call(*self.mesh, self.camera, self.size, barycentrics=False)
        return seen.face, seen.depth


class PolyscanWeights(Polyscan):
    def draw(self) -> tuple[np.ndarray | None, np.ndarray]:
        seen = self.call(*self.mesh, self.camera, self.size, derivatives=True)
        return seen.face, seen.depth


class Embree:
    def __init__(self, vertices: np.ndarray, faces: np.ndarray, size: tuple[int, int]) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self.scene = EmbreeScene(robust=True)
        TriangleMesh(self.scene, vertices, faces)
        self.ways, self.size = ways(size).reshape(-1, 3).astype(np.float32), size
        self.eye = np.broadcast_to(EYE.astype(np.float32), self.ways.shape)

    def draw(self) -> tuple[np.ndarray | None, np.ndarray]:
        hit = self.scene.run(np.ascontiguousarray(self.eye), self.ways, output=True)
        face = hit["primID"].reshape(self.size[::-1])
        return face, np.where(face >= 0, hit["tfar"].reshape(self.size[::-1]), 0)


class Pyrender:
    def __init__(self, vertices: np.ndarray, faces: np.ndarray, size: tuple[int, int]) -> None:
        import pyrender

        mesh = pyrender.Mesh([pyrender.Primitive(positions=vertices, indices=faces, mode=4)])
        self.scene = pyrender.Scene()
        self.scene.add(mesh)
        camera = pyrender.PerspectiveCamera(np.radians(ANGLE), znear=NEAR, zfar=FAR, aspectRatio=size[0] / size[1])
        self.scene.add(camera, pose=np.linalg.inv(np.diag([1, -1, -1, 1]) @ pose()))
        self.renderer = pyrender.OffscreenRenderer(*size)
        self.flags = pyrender.RenderFlags.DEPTH_ONLY
        self.draw()

    def draw(self) -> tuple[np.ndarray | None, np.ndarray]:
        return None, self.renderer.render(self.scene, flags=self.flags)


TOOLS = {
    "polyscan, ids and depth": Polyscan,
    "polyscan, barycentrics and derivatives as well": PolyscanWeights,
    "embreex, ids and depth": Embree,
    "pyrender, depth": Pyrender,
}


def resident(name: str) -> int:
    """Memory in kB, by its name in Linux's status of a process."""
    status = pathlib.Path("/proc/self/status").read_text()
    return int(re.search(rf"^{name}:\s+(\d+) kB$", status, re.MULTILINE)[1])


def measure(tool: str, mesh: str, size: tuple[int, int], out: str) -> None:
    """In a process of its own: prints what it took, and keeps what was seen."""
    vertices, faces = ball(MESHES[mesh])
    # From now on the peak counts, not that of making the mesh.
    pathlib.Path("/proc/self/clear_refs").write_text("5")
    before = resident("VmRSS")
    start = time.process_time()
    made = TOOLS[tool](vertices, faces, size)
    prepared = time.process_time() - start
    times, clocks = [], []
    while len(times) < 3 or sum(clocks) < 3 and len(times) < 20:
        clock, start = time.monotonic(), time.process_time()
        face, depth = made.draw()
        times.append(time.process_time() - start)
        clocks.append(time.monotonic() - clock)
    memory = resident("VmHWM") - before
    np.savez(out, depth=depth, **({} if face is None else {"face": face}))
    print(json.dumps({"prepare": prepared, "cpu": min(times), "clock": min(clocks), "memory": memory / 1024}))


def exact(faces_seen: np.ndarray, mesh: str, size: tuple[int, int]) -> np.ndarray:
    """The depth of the plane of each pixel's face, in f64."""
    vertices, faces = ball(MESHES[mesh])
    y, x = np.nonzero(faces_seen >= 0)
    corners = vertices.astype(np.float64)[faces[faces_seen[y, x]]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    depth = np.zeros(faces_seen.shape)
    with np.errstate(all="ignore"):
        depth[y, x] = ((corners[:, 0] - EYE) * normal).sum(1) / (ways(size)[y, x] * normal).sum(1)
    return depth


def row(tool: str, mesh: str, size: tuple[int, int], took: dict, got: dict, rays: dict | None) -> str:
    cells = [tool, f"{1000 * took['prepare']:,.0f}", f"{1000 * took['cpu']:,.0f}", f"{1000 * took['clock']:,.0f}"]
    cells.append(f"{took['memory']:,.0f}")
    if rays is None:
        cells += ["", ""]
    else:
        shown, hit = got["depth"] > 0, rays["face"] >= 0
        cells.append(f"{int((shown != hit).sum()):,}" if tool.split(",")[0] != "embreex" else "-")
        same = hit & shown & (got["face"] == rays["face"] if "face" in got else True)
        truth = exact(rays["face"], mesh, size)
        error = np.abs(got["depth"][same] / truth[same] - 1)
        cells.append(f"{np.quantile(error, 0.99):.0e}")
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--quick", action="store_true")
    options.add_argument("--measure", nargs=4, help=argparse.SUPPRESS)
    asked = options.parse_args()
    if asked.measure:
        tool, mesh, size, out = asked.measure
        width, height = size.split("x")
        return measure(tool, mesh, (int(width), int(height)), out)
    cases = [(mesh, size) for mesh in MESHES for size in SIZES][: 1 if asked.quick else None]
    print("CPU time in ms, all threads together, the fastest frame; peak memory in MB beyond the mesh.", end=" ")
    print("Of pixels: how many are in or out where Embree's rays are not; the error of depth that 99 % keep.\n")
    for mesh, size in cases:
        print(f"\n{mesh} faces, {size[0]} x {size[1]}:\n")
        print("| | to prepare | a frame | on the clock | memory | mask | depth |\n|---|---|---|---|---|---|---|")
        with tempfile.TemporaryDirectory() as folder:
            taken, seen = {}, {}
            for tool in TOOLS:
                out = str(pathlib.Path(folder) / "out.npz")
                python = os.environ.get("PYRENDER_PYTHON", sys.executable) if tool.startswith("pyrender") else sys.executable
                command = [python, __file__, "--measure", tool, mesh, f"{size[0]}x{size[1]}", out]
                done = subprocess.run(command, capture_output=True, text=True, env={"PYOPENGL_PLATFORM": "egl", **os.environ})
                if done.returncode != 0:
                    print(f"{tool}: {done.stderr.strip().splitlines()[-1:]}", file=sys.stderr)
                    continue
                taken[tool] = json.loads(done.stdout.splitlines()[-1])
                with np.load(out) as file:
                    seen[tool] = dict(file)
            rays = seen.get("embreex, ids and depth")
            for tool, took in taken.items():
                print(row(tool, mesh, size, took, seen[tool], rays), flush=True)


if __name__ == "__main__":
    main()
