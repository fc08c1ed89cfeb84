"""Renders depth and face ids of a model from many poses, on all workers of a Ray cluster.

    python dataset_on_ray.py model.npz out --poses 1000                  # on this machine
    python dataset_on_ray.py model.npz out --poses 1000 --address auto   # on the cluster that this machine belongs to

The model is a file of `numpy.savez` with `vertices` and `faces`. Each pose becomes `out/pose_000000.npz`; `out` has to be a
folder that all workers see. What is there already is left as it is, so a run that was ended goes on where it was.
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
def draw(vertices: np.ndarray, faces: np.ndarray, numbers: list[int], out: str) -> list[tuple[int, str]]:
    """Draws a shard; the numbers of its poses, with a hash of what is seen. Ray calls it again if its worker dies."""
    radius = float(np.linalg.norm(vertices, axis=1).max())
    done = []
    for number in numbers:
        path = pathlib.Path(out) / f"pose_{number:06}.npz"
        if not path.exists():
            pose = pose_of(number, radius)
            # A worker has one processor.
            seen = polyscan.rasterize(vertices, faces, polyscan.Camera.opencv(K, pose), SIZE, barycentrics=False, threads=1)
            write(path, pose=pose, face=seen.face, depth=seen.depth)
        with np.load(path) as file:
            done.append((number, hashlib.sha256(file["face"].tobytes() + file["depth"].tobytes()).hexdigest()))
    return done


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("model", type=pathlib.Path)
    options.add_argument("out", type=pathlib.Path)
    options.add_argument("--poses", type=int, default=100)
    options.add_argument("--shard", type=int, default=10, help="poses that a worker draws at a time")
    options.add_argument("--address", help="of a cluster; this machine alone if left out")
    options.add_argument("--workers", type=int, help="processors of this machine; all if left out")
    asked = options.parse_args()

    asked.out.mkdir(parents=True, exist_ok=True)
    with np.load(asked.model) as file:
        vertices, faces = file["vertices"], file["faces"]
    ray.init(address=asked.address, num_cpus=asked.workers, include_dashboard=False, log_to_driver=False)
    # The mesh goes to each machine once.
    mesh = ray.put(vertices), ray.put(faces)
    numbers = list(range(asked.poses))
    shards = [numbers[first : first + asked.shard] for first in range(0, asked.poses, asked.shard)]
    waiting = [draw.remote(*mesh, shard, str(asked.out.resolve())) for shard in shards]
    hashes: dict[int, str] = {}
    while waiting:
        finished, waiting = ray.wait(waiting)
        hashes.update(pair for one in finished for pair in ray.get(one))
        print(f"\r{len(hashes)} of {asked.poses} poses", end="", flush=True)
    print()
    ray.shutdown()
    if sorted(hashes) != numbers:
        raise SystemExit("error: poses are missing")
    whole = hashlib.sha256("".join(hashes[number] for number in numbers).encode()).hexdigest()
    print(f"all {asked.poses} poses: sha256 {whole}")


if __name__ == "__main__":
    main()
