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


def square(side: float = 1.0) -> tuple[np.ndarray, list[list[int]], np.ndarray, polyscan.Camera]:
    """A square that fills the picture of its camera, and its texture coordinates, with v down."""
    vertices = np.array([[-side, -side, 0], [side, -side, 0], [side, side, 0], [-side, side, 0]])
    uv = np.array([[0.0, 1], [1, 1], [1, 0], [0, 0]])
    pose = polyscan.look_at([0, 0, 4], [0, 0, 0])
    return vertices, [[0, 1, 2], [0, 2, 3]], uv, polyscan.Camera.orthographic(2, 2, pose, near=1, far=9)


def light_of(codes: np.ndarray) -> np.ndarray:
    """The linear light of sRGB codes (IEC 61966-2-1)."""
    codes = codes / 255
    return np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)


def lit(codes: np.ndarray, reflected: float) -> np.ndarray:
    """sRGB codes of a flat surface towards the camera, in the light of the lamp above its right shoulder."""
    light = light_of(codes) * reflected * (0.2 + 0.8 / np.sqrt(0.6**2 + 0.7**2 + 1))
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def test_a_texture_is_seen_as_it_is_but_for_the_light(rng: np.random.Generator) -> None:
    vertices, faces, uv, camera = square()
    picture = rng.integers(0, 256, (16, 24, 3), np.uint8)
    how = {"size": (24, 16), "camera": camera}
    texture = polyscan.Texture(picture, filter="nearest", mip_filter="off")
    got = polyscan.render(vertices, faces, uv=uv, texture=texture, **how)
    assert (got[..., 3] == 255).all()
    assert np.abs(got[..., :3] - lit(picture.astype(float), 1.0)).max() <= 1
    # Colours multiply it: red leaves red alone.
    red = polyscan.render(vertices, faces, uv=uv, texture=texture, colors=np.array([255, 0, 0], np.uint8), **how)
    assert np.array_equal(red[..., 0], got[..., 0]) and red[..., 1:3].max() == 0
    # An array is filtered; its light stays the same on the whole.
    plain = polyscan.render(vertices, faces, uv=uv, texture=picture, **how)
    ratio = light_of(plain[..., :3]).mean(axis=(0, 1)) / light_of(got[..., :3]).mean(axis=(0, 1))
    assert np.abs(ratio - 1).max() < 0.02 and light_of(plain[..., :3]).std() < 0.95 * light_of(got[..., :3]).std()
    # With alpha it is glass: half of what is behind shows.
    clear = np.dstack([picture, np.full((16, 24), 128, np.uint8)])
    seen = polyscan.render(vertices, faces, uv=uv, texture=clear, **how)
    assert np.abs(seen[..., 3].astype(int) - 128).max() <= 1


def test_colors_of_vertices_of_faces_and_glass() -> None:
    vertices, faces, _, camera = square()
    how = {"size": (32, 32), "camera": camera}
    two = np.array([[200, 40, 40], [40, 80, 200]], np.uint8)
    got = polyscan.render(vertices, faces, face_colors=two, samples=1, **how).astype(float)
    y, x = np.indices((32, 32))
    # The first triangle is below the diagonal from the lower left to the upper right.
    for side, color in ((x + y > 32, two[0]), (x + y < 31, two[1])):
        assert np.abs(got[side][:, :3] - lit(color.astype(float), 0.8)).max() <= 1
    half = polyscan.render(vertices, faces, face_colors=np.hstack([two, [[64], [255]]]).astype(np.uint8), samples=1, **how)
    assert np.abs(half[x + y > 32][:, 3].astype(int) - 64).max() <= 1 and (half[x + y < 31][:, 3] == 255).all()
    corners = np.array([[255, 0, 0], [255, 0, 0], [0, 0, 255], [0, 0, 255]], np.uint8)
    mixed = polyscan.render(vertices, faces, colors=corners, **how).astype(int)
    assert (np.diff(mixed[:, 16, 0]) >= 0).all() and (np.diff(mixed[:, 16, 2]) <= 0).all() and mixed[31, 16, 0] > 180


def test_a_seam_leaves_the_surface_smooth() -> None:
    vertices, faces = sphere(20)
    plain = polyscan.render(vertices, faces, size=(80, 80))
    # Every face with corners of its own.
    apart, own = vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    white = np.full((2, 2, 3), 255, np.uint8)
    grey = polyscan.render(apart, own, size=(80, 80), uv=apart[:, :2], texture=white, colors=np.full(3, 231, np.uint8))
    # 231 is the code of 0.8.
    assert np.abs(grey.astype(int) - plain).max() <= 2


def test_a_trimesh_is_drawn_with_its_visuals(rng: np.random.Generator) -> None:
    trimesh, pil = pytest.importorskip("trimesh"), pytest.importorskip("PIL.Image")
    vertices, faces, uv, camera = square()
    how = {"size": (32, 24), "camera": camera}
    ball = trimesh.Trimesh(*sphere(20), process=False)
    assert np.array_equal(polyscan.render(ball, size=(60, 60)), polyscan.render(*sphere(20), size=(60, 60)))
    picture = rng.integers(0, 256, (12, 16, 3), np.uint8)
    # It has v up.
    up = uv * [1, -1] + [0, 1]
    for material in (
        trimesh.visual.material.SimpleMaterial(image=pil.fromarray(picture)),
        trimesh.visual.material.PBRMaterial(baseColorTexture=pil.fromarray(picture)),
    ):
        visual = trimesh.visual.TextureVisuals(uv=up, material=material)
        mesh = trimesh.Trimesh(vertices, faces, visual=visual, process=False)
        want = polyscan.render(vertices, faces, uv=uv, texture=picture, **how)
        assert want[..., :3].std() > 20
        assert np.array_equal(polyscan.render(mesh, **how), want)
        assert np.array_equal(polyscan.render(trimesh.Scene(mesh), **how), want)
    two = np.array([[200, 40, 40, 255], [40, 80, 200, 255]], np.uint8)
    mesh = trimesh.Trimesh(vertices, faces, face_colors=two, process=False)
    assert np.array_equal(polyscan.render(mesh, **how), polyscan.render(vertices, faces, face_colors=two, **how))
    four = rng.integers(0, 256, (4, 4), np.uint8)
    mesh = trimesh.Trimesh(vertices, faces, vertex_colors=four, process=False)
    assert np.array_equal(polyscan.render(mesh, **how), polyscan.render(vertices, faces, colors=four, **how))
    visual = trimesh.visual.TextureVisuals(material=trimesh.visual.material.SimpleMaterial(diffuse=[10, 200, 30, 255]))
    mesh = trimesh.Trimesh(vertices, faces, visual=visual, process=False)
    green = np.array([10, 200, 30], np.uint8)
    assert np.array_equal(polyscan.render(mesh, **how), polyscan.render(vertices, faces, face_colors=green, **how))


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


_GREY = np.array([128, 128, 128], np.uint8)


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
        ("colors", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], colors=np.zeros((2, 3), np.uint8))),
        ("colors", lambda: polyscan.render("a.obj", colors=np.zeros((3, 3), np.uint8))),
        ("face_colors", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], face_colors=np.zeros((3, 3), np.uint8))),
        ("face_colors", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], colors=_GREY, face_colors=_GREY)),
        ("uv", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], texture=np.zeros((2, 2)))),
        ("uv", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], uv=np.zeros((2, 2)), texture=np.zeros((2, 2)))),
        ("uv", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], uv=np.full((3, 2), np.inf), texture=np.zeros((2, 2)))),
        ("uv", lambda: polyscan.render("a.obj", uv=np.zeros((2, 2)))),
        ("texture", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], uv=np.zeros((3, 2)))),
        ("texture", lambda: polyscan.render(np.eye(3), [[0, 1, 2]], uv=np.zeros((3, 2)), texture=np.zeros(2))),
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
