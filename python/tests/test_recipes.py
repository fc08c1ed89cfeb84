"""The code of the README and of the recipes, run as it stands; and the script for many machines."""

from __future__ import annotations

import os
import pathlib
import re
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


def run(model: pathlib.Path, out: pathlib.Path, workers: int, poses: int = 24) -> subprocess.Popen:
    script = HERE / "examples" / "dataset_on_ray.py"
    command = [sys.executable, script, model, out, "--poses", str(poses), "--shard", "3", "--workers", str(workers)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)


def children(pid: int) -> list[int]:
    tasks = pathlib.Path(f"/proc/{pid}/task")
    found = [int(child) for task in tasks.iterdir() for child in (task / "children").read_text().split()]
    return found + [child for one in found for child in children(one)]


@pytest.mark.skipif(not os.environ.get("POLYSCAN_TEST_RAY"), reason="POLYSCAN_TEST_RAY is not set")
def test_a_cluster_makes_the_same_whatever_happens(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("ray")
    vertices, faces = sphere(150)
    model = tmp_path / "model.npz"
    np.savez(model, vertices=vertices.astype(np.float32), faces=faces.astype(np.int32))
    said = []
    for workers, is_disturbed in ((1, False), (3, True)):
        out = tmp_path / f"out{workers}"
        process = run(model, out, workers)
        killed = 0
        while is_disturbed and process.poll() is None and killed < 2:
            # Two workers are killed in the middle of their work.
            time.sleep(0.02)
            if len(list(out.glob("pose_*.npz"))) < 4 * (killed + 1):
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
        assert [path.name for path in sorted(out.glob("pose_*"))] == [f"pose_{i:06}.npz" for i in range(24)]
    assert said[0] == said[1] and "sha256" in said[0]
