"""The code of the README and of the recipes, run as it stands; and the script for many machines."""

from __future__ import annotations

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from conftest import sphere

HERE = pathlib.Path(__file__).parent.parent


def blocks(name: str) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", (HERE / name).read_text(), re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize(
    ("name", "files"),
    [
        ("README.md", ["cube.png"]),
        (
            "RECIPES.md",
            ["pose_002.npz", "depth.png", "mattes.png", "board.png", "render.png", "height.png", "views.png", "ball.png"],
        ),
    ],
)
def test_code_runs_as_it_stands(
    name: str, files: list[str], tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    pytest.importorskip("PIL")
    monkeypatch.chdir(tmp_path)
    vertices, faces = sphere(8)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    (tmp_path / "ball.obj").write_text("\n".join(lines))
    (tmp_path / "broken.stl").write_text("no model")
    found = blocks(name)
    assert found
    names: dict = {}
    for block in found:
        exec(compile(block, name, "exec"), names)
    for file in files:
        assert (tmp_path / file).stat().st_size > 100, file
    if name == "RECIPES.md":
        assert "broken.stl" in capsys.readouterr().out
        from PIL import Image

        board = np.asarray(Image.open("board.png"))
        assert board[:5].max() == 0 and board[240, 320].max() > 50


@pytest.mark.parametrize("jobs", ["GNU parallel", "Slurm"])
def test_array_jobs_join_to_the_bit(jobs: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The tool's shards, by GNU parallel, or with the variables that Slurm gives the jobs of an array."""
    tool, image = os.environ.get("POLYSCAN_TOOL"), pytest.importorskip("PIL.Image")
    if not tool or jobs == "GNU parallel" and not shutil.which("parallel"):
        pytest.skip(f"POLYSCAN_TOOL is not the tool, or there is no {jobs}")
    vertices, faces = sphere(12)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    for name in ("ball", "egg", "disc"):
        (tmp_path / f"{name}.obj").write_text("\n".join(lines))
    monkeypatch.chdir(tmp_path)
    how = "--quiet --size 130x97"
    subprocess.run(f"{tool} ball.obj -o whole.png {how}", shell=True, check=True)
    if jobs == "GNU parallel":
        for of in (f"ball.obj -o part-{{}}.png {how}", f"ball.obj egg.obj disc.obj -o pictures/ {how}"):
            subprocess.run(f"parallel --will-cite '{tool} {of} --shard {{}}/4' ::: 1 2 3 4", shell=True, check=True)
    else:
        shard = "--shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
        for of in (f"ball.obj -o part-$SLURM_ARRAY_TASK_ID.png {how}", f"ball.obj egg.obj disc.obj -o pictures/ {how}"):
            # In any order, as a queue has it.
            for task in (3, 1, 4, 2):
                variables = {**os.environ, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": "4"}
                subprocess.run(f"{tool} {of} {shard}", shell=True, check=True, env=variables)
    parts = [np.asarray(image.open(f"part-{k}.png")) for k in range(1, 5)]
    assert np.array_equal(np.vstack(parts), np.asarray(image.open("whole.png")))
    assert sorted(path.name for path in pathlib.Path("pictures").iterdir()) == ["ball.png", "disc.png", "egg.png"]


def run(models: list[pathlib.Path], out: pathlib.Path, workers: int) -> subprocess.Popen:
    script = HERE / "examples" / "dataset_on_ray.py"
    command = [sys.executable, script, out, *models, "--poses", "12", "--shard", "3", "--workers", str(workers)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)


def children(pid: int) -> list[int]:
    tasks = pathlib.Path(f"/proc/{pid}/task")
    found = [int(child) for task in tasks.iterdir() for child in (task / "children").read_text().split()]
    return found + [child for one in found for child in children(one)]


@pytest.mark.skipif(not os.environ.get("POLYSCAN_TEST_RAY"), reason="POLYSCAN_TEST_RAY is not set")
def test_a_cluster_makes_the_same_whatever_happens(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("ray")
    models = [tmp_path / "ball.npz", tmp_path / "egg.npz"]
    for model, shape in zip(models, ([1, 1, 1], [1, 1.4, 1]), strict=True):
        vertices, faces = sphere(150)
        np.savez(model, vertices=(vertices * shape).astype(np.float32), faces=faces.astype(np.int32))
    wanted = [f"{model.stem}/pose_{i:06}.npz" for model in models for i in range(12)]
    said = []
    for workers, is_disturbed in ((1, False), (3, True)):
        out = tmp_path / f"out{workers}"
        process = run(models, out, workers)
        killed = 0
        while is_disturbed and process.poll() is None and killed < 2:
            # Two workers are killed in the middle of their work.
            time.sleep(0.02)
            if len(list(out.glob("*/pose_*.npz"))) < 4 * (killed + 1):
                continue
            for child in children(process.pid):
                try:
                    name = pathlib.Path(f"/proc/{child}/cmdline").read_bytes()
                except OSError:
                    continue
                if name.startswith(b"ray::draw"):
                    os.kill(child, signal.SIGKILL)
                    killed += 1
                    break
        text, _ = process.communicate(timeout=120)
        assert process.returncode == 0, text
        assert killed == (2 if is_disturbed else 0)
        said.append(text.strip().splitlines()[-1])
        # Whole files alone: nothing is half written, lost or double.
        assert [path.relative_to(out).as_posix() for path in sorted(out.glob("*/pose_*"))] == wanted
        for name in wanted:
            with np.load(out / name) as file:
                assert file["face"].shape == file["depth"].shape == (480, 640)
    assert said[0] == said[1] and "sha256" in said[0]
