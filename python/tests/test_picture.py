"""Pictures of whole models."""

from __future__ import annotations

import os
import pathlib
import subprocess

import numpy as np
import pytest

import polyscan
from conftest import sphere

OBJ = """mtllib m.mtl
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
usemtl red
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
usemtl blue
f 3 4 8 7
f 2 3 7 6
f 4 1 5 8
"""


@pytest.fixture
def cube(tmp_path: pathlib.Path) -> pathlib.Path:
    (tmp_path / "m.mtl").write_text("newmtl red\nKd 0.8 0.1 0.1\nKe 0.1 0.3 0.0\nnewmtl blue\nKd 0.1 0.2 0.9\n")
    (tmp_path / "cube.obj").write_text(OBJ)
    return tmp_path / "cube.obj"


def test_a_file_is_drawn_as_the_tool_draws_it(cube: pathlib.Path) -> None:
    tool = os.environ.get("POLYSCAN_TOOL")
    if not tool:
        pytest.skip("POLYSCAN_TOOL is not the tool")
    cv2 = pytest.importorskip("cv2")
    for options, how in (
        ([], {}),
        (["--yaw", "200", "--pitch", "-10", "--fov", "50"], {"yaw": 200, "pitch": -10, "field_of_view": 50}),
        (["--background", "336699", "--samples", "2"], {"background": (0x33, 0x66, 0x99), "samples": 2}),
        (["--up", "z"], {"up": (0, 0, 1)}),
    ):
        out = cube.parent / "out.png"
        subprocess.run([tool, cube, "-o", out, "--size", "160x120", "--quiet", *options], check=True)
        want = cv2.imread(str(out), cv2.IMREAD_UNCHANGED)[..., [2, 1, 0, 3]].astype(int)
        got = polyscan.render(cube, size=(160, 120), **how).astype(int)
        shown = (want[..., 3] > 0) & (got[..., 3] > 0)
        assert np.array_equal(want[..., 3], got[..., 3])
        assert np.abs(want - got)[shown].max() <= 1


def test_a_sphere_is_round_lit_and_where_its_camera_sees_it() -> None:
    vertices, faces = sphere(60)
    picture = polyscan.render(vertices, faces, size=(200, 100), pitch=0, yaw=0)
    assert picture.shape == (100, 200, 4) and picture.dtype == np.uint8
    alpha = picture[..., 3] / 255
    # The silhouette is as large as the angle under which it is seen: 1.01 times it fits into the height.
    radius = 50 * np.tan(np.arcsin(np.sin(np.radians(17)) / 1.01)) / np.tan(np.radians(17))
    assert abs(alpha.sum() / (np.pi * radius**2) - 1) < 0.01
    assert ((alpha > 0) & (alpha < 1)).sum() > 50, "the edge is not smooth"
    light = picture[..., 0].astype(int)
    # The lamp is to the upper right.
    assert light[30, 120] > light[70, 80] + 20
    camera = polyscan.Camera.around(vertices, pitch=0, yaw=0)
    own = polyscan.render(vertices, faces, size=(200, 100), camera=camera)
    assert np.abs(own.astype(int) - picture).max() <= 24 and (own != picture).mean() < 0.05


@pytest.mark.parametrize("kind", ["zero_to_one", "minus_one_to_one", "reversed"])
def test_cameras_of_all_conventions_draw_the_same(kind: str, cube: pathlib.Path) -> None:
    pose = polyscan.look_at([3, 2, 5], [0, 0, 0])
    want = polyscan.render(cube, size=(90, 80), camera=polyscan.Camera.perspective(40, pose, near=1, far=20))
    near, far, focal = 1.0, 20.0, 1 / np.tan(np.radians(20))
    a, b = {
        "zero_to_one": (far / (far - near), -far * near / (far - near)),
        "minus_one_to_one": ((far + near) / (far - near), -2 * far * near / (far - near)),
        "reversed": (-near / (far - near), far * near / (far - near)),
    }[kind]
    projection = np.array([[focal * 80 / 90, 0, 0, 0], [0, -focal, 0, 0], [0, 0, a, b], [0, 0, 1, 0]])
    is_reversed = kind == "reversed"
    camera = polyscan.Camera.projection(
        projection @ pose, depth_range="zero_to_one" if is_reversed else kind, reversed_depth=is_reversed
    )
    got = polyscan.render(cube, size=(90, 80), camera=camera)
    assert want[..., 3].mean() > 30
    assert np.abs(got.astype(int) - want).max() <= 2


def test_arrays_objects_and_colors() -> None:
    vertices, faces = sphere(20)

    class Mesh:
        pass

    mesh = Mesh()
    mesh.vertices, mesh.faces = vertices, faces
    plain = polyscan.render(vertices, faces, size=(60, 60))
    assert np.array_equal(polyscan.render(mesh, size=(60, 60)), plain)
    red = np.tile(np.array([255, 0, 0], np.uint8), (len(vertices), 1))
    colored = polyscan.render(vertices, faces, size=(60, 60), colors=red)
    assert np.array_equal(colored[..., 0], plain[..., 0]) and colored[..., 1:3].max() == 0
    assert np.array_equal(colored[..., 3], plain[..., 3])
    blue = polyscan.render(vertices, faces, size=(60, 60), background=(0, 0, 255))
    assert (blue[..., 3] == 255).all() and blue[0, 0].tolist() == [0, 0, 255, 255]
    assert np.array_equal(plain, polyscan.render(vertices, faces, size=(60, 60), threads=1))
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.Trimesh(vertices, faces, process=False)
    assert np.array_equal(polyscan.render(ball, size=(60, 60)), plain)


def test_tiles_join_to_the_bit(cube: pathlib.Path) -> None:
    whole = polyscan.render(cube, size=(61, 47))
    for left, top, width, height in ((0, 0, 30, 47), (30, 0, 31, 47), (7, 13, 1, 1), (0, 46, 61, 1)):
        part = polyscan.render(cube, size=(61, 47), tile=(left, top, width, height))
        assert np.array_equal(part, whole[top : top + height, left : left + width])


def test_polygons_of_arrays(cube: pathlib.Path) -> None:
    vertices = np.array([[float(n) for n in line.split()[1:]] for line in OBJ.splitlines() if line.startswith("v ")])
    quads = [[int(n) - 1 for n in line.split()[1:]] for line in OBJ.splitlines() if line.startswith("f ")]
    two = polyscan.render(vertices, quads, size=(50, 50))
    ragged = polyscan.render(vertices, [*quads[1:], quads[0][:3], [quads[0][0], *quads[0][2:]]], size=(50, 50))
    assert np.array_equal(two, ragged)
    assert np.array_equal(polyscan.render(cube, size=(50, 50))[..., 3], two[..., 3])


def test_what_a_file_lacks_is_a_warning(cube: pathlib.Path) -> None:
    (cube.parent / "m.mtl").unlink()
    with pytest.warns(UserWarning) as noted:
        polyscan.render(cube, size=(20, 20))
    assert any("m.mtl" in str(note.message) for note in noted)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("model", lambda: polyscan.render("no/such/file.obj")),
        ("model", lambda: polyscan.render(3)),
        ("model", lambda: polyscan.render(np.zeros((4, 2)), [[0, 1, 2]])),
        ("faces", lambda: polyscan.render(np.zeros((3, 3)), [[0, 1, 3]])),
        ("faces", lambda: polyscan.render("a.obj", [[0, 1, 2]])),
        ("faces", lambda: polyscan.render(np.zeros((3, 3)), np.zeros((0, 3), int))),
        ("vertices", lambda: polyscan.render(np.full((3, 3), np.nan), [[0, 1, 2]])),
        ("colors", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], colors=[[1, 2, 3]])),
        ("samples", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], samples=9)),
        ("size", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], size=(65536, 1), samples=2)),
        ("background", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], background="white")),
        ("background", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], background=(256, 0, 0))),
        ("camera", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], camera=np.eye(4))),
        ("up", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], up="z")),
    ],
)
def test_what_is_wrong_is_named(name: str, call) -> None:
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        call()
