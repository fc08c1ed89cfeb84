"""Renders depth and face ids of models from many poses, on all workers of a Ray cluster.

    python dataset_on_ray.py out cup.npz chair.npz --poses 1000                  # on this machine
    python dataset_on_ray.py out cup.npz chair.npz --poses 1000 --address auto   # on the cluster that it belongs to

A model is a file of `numpy.savez` with `vertices` and `faces`. Each of its poses becomes `out/cup/pose_000000.npz`; `out` has
to be a folder that all workers see. What is there already is left as it is, so a run that was ended goes on where it was.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import pathlib
import tempfile

import numpy as np
import ray

import polyscan

SIZE = (640, 480)
K = np.array([[600.0, 0, 319.5], [0, 600, 239.5], [0, 0, 1]])


def pose_of(number: int, radius: float) -> np.ndarray:
    """The pose with a number: it depends on nothing else, whoever asks."""
    way = np.random.default_rng(number).normal(size=3)
    return polyscan.look_at(4 * radius * way / np.linalg.norm(way), [0, 0, 0], up=[0.1, 0.9, 0.4])


def write(path: pathlib.Path, **arrays: np.ndarray) -> None:
    """A file that gets its name when it is whole."""
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".", suffix=".npz", delete=False) as file:
        np.savez(file, **arrays)
    os.replace(file.name, path)


@ray.remote(num_cpus=1, max_retries=5)
def draw(vertices: np.ndarray, faces: np.ndarray, folder: str, numbers: list[int]) -> list[tuple[str, str]]:
    """Draws a shard: some poses of a model; their files, with a hash of what is seen. Ray calls it again if its worker dies."""
    radius = float(np.linalg.norm(vertices, axis=1).max())
    done = []
    for number in numbers:
        path = pathlib.Path(folder) / f"pose_{number:06}.npz"
        if not path.exists():
            pose = pose_of(number, radius)
            # A worker has one processor.
            seen = polyscan.rasterize(vertices, faces, polyscan.Camera.opencv(K, pose), SIZE, barycentrics=False, threads=1)
            write(path, pose=pose, face=seen.face, depth=seen.depth)
        with np.load(path) as file:
            seen_hash = hashlib.sha256(file["face"].tobytes() + file["depth"].tobytes()).hexdigest()
        done.append((f"{path.parent.name}/{path.name}", seen_hash))
    return done


def submit(model: pathlib.Path, out: pathlib.Path, poses: int, shard: int) -> list[ray.ObjectRef]:
    """Hands over all shards of a model."""
    folder = out.resolve() / model.stem
    folder.mkdir(parents=True, exist_ok=True)
    with np.load(model) as file:
        # The mesh goes to each machine once.
        mesh = ray.put(file["vertices"]), ray.put(file["faces"])
    shards = [list(range(first, min(first + shard, poses))) for first in range(0, poses, shard)]
    return [draw.remote(*mesh, str(folder), numbers) for numbers in shards]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("out", type=pathlib.Path)
    options.add_argument("models", type=pathlib.Path, nargs="+")
    options.add_argument("--poses", type=int, default=100, help="of each model")
    options.add_argument("--shard", type=int, default=10, help="poses that a worker draws at a time")
    options.add_argument("--address", help="of a cluster; this machine alone if left out")
    options.add_argument("--workers", type=int, help="processors of this machine; all if left out")
    asked = options.parse_args()
    if len({model.stem for model in asked.models}) < len(asked.models):
        raise SystemExit("error: two models have one name, and would be drawn into one folder")

    ray.init(address=asked.address, num_cpus=asked.workers, include_dashboard=False, log_to_driver=False)
    waiting = [shard for model in asked.models for shard in submit(model, asked.out, asked.poses, asked.shard)]
    wanted = {f"{model.stem}/pose_{number:06}.npz" for model in asked.models for number in range(asked.poses)}
    hashes: dict[str, str] = {}
    while waiting:
        finished, waiting = ray.wait(waiting)
        hashes.update(pair for one in finished for pair in ray.get(one))
        print(f"\r{len(hashes)} of {len(wanted)} pictures", end="", flush=True)
    print()
    ray.shutdown()
    if set(hashes) != wanted:
        raise SystemExit("error: pictures are missing")
    whole = hashlib.sha256("".join(name + hashes[name] for name in sorted(wanted)).encode()).hexdigest()
    print(f"all {len(wanted)} pictures: sha256 {whole}")


if __name__ == "__main__":
    main()
