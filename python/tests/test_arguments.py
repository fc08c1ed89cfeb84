"""Arguments of any shape, type and value: either the right picture, or a `ValueError` that names what is wrong."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_np

import polyscan
from conftest import sphere
from polyscan import Camera, Polygons

SIZE = (24, 16)
CAMERA = Camera.perspective(60, polyscan.look_at([0, 0, 3], [0, 0, 0]))
SQUARE = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def picture(vertices=SQUARE, faces=TRIANGLES, camera=CAMERA, size=SIZE, **options) -> polyscan.Seen:
    return polyscan.rasterize(vertices, faces, camera, size, **options)


@pytest.mark.parametrize("kind", ["f2", "f4", "f8", ">f4", ">f8", "i4", "u1", "i8"])
def test_vertices_of_all_kinds_of_numbers(kind: str) -> None:
    if kind != "u1":
        assert np.array_equal(picture(SQUARE.astype(kind)).face, picture().face)
    else:
        assert np.array_equal(picture(SQUARE.clip(0).astype(kind)).face, picture(SQUARE.clip(0)).face)


@pytest.mark.parametrize("kind", ["i4", "u4", "i8", "u8", "i2", "u1", ">i4", "i1"])
def test_faces_of_all_kinds_of_numbers(kind: str) -> None:
    assert np.array_equal(picture(faces=TRIANGLES.astype(kind)).face, picture().face)


def test_arrays_with_gaps_and_in_other_orders() -> None:
    wide = np.zeros((8, 6))
    wide[::2, ::2] = SQUARE
    want = picture().face
    assert np.array_equal(picture(wide[::2, ::2]).face, want)
    assert np.array_equal(picture(np.asfortranarray(SQUARE)).face, want)
    assert np.array_equal(picture(faces=np.asfortranarray(TRIANGLES.astype(np.int32))).face, want)
    assert np.array_equal(picture(SQUARE[::-1][::-1], faces=TRIANGLES.tolist()).face, want)
    fixed = SQUARE.copy()
    fixed.flags.writeable = False
    assert np.array_equal(picture(fixed).face, want)


def test_polygons_are_the_same_in_all_forms() -> None:
    hexagon = [[np.cos(a), np.sin(a), 0] for a in np.linspace(0, 2 * np.pi, 6, endpoint=False)]
    vertices = np.concatenate([SQUARE - [0.8, 0, 1], hexagon])
    one = picture(vertices, [[0, 1, 2, 3], [4, 5, 6, 7, 8, 9]])
    two = picture(vertices, Polygons(np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9]), [0, 4, 10]))
    for a, b in ((one.face, two.face), (one.depth, two.depth), (one.corners, two.corners)):
        assert np.array_equal(a, b)
    assert set(np.unique(one.face)) == {-1, 0, 1}
    quads = picture(faces=[[0, 1, 2, 3]])
    assert np.array_equal(quads.face >= 0, picture().face >= 0)
    assert np.allclose(quads.depth, picture().depth, rtol=1e-6)


def test_weights_of_polygons_are_of_corners_around_the_pixel(rng: np.random.Generator) -> None:
    """A star, which is concave: what is linear on it is at each pixel what its corners' weights say."""
    angles = np.arange(10) * np.pi / 5
    radius = np.where(np.arange(10) % 2 == 0, 1.0, 0.4)
    star = np.stack([radius * np.cos(angles), radius * np.sin(angles), 0.3 * radius * np.cos(angles)], axis=-1)
    seen = picture(star, [list(range(10))], size=(200, 150), derivatives=True)
    shown = seen.face == 0
    assert 0.05 < shown.mean() < 0.6
    assert np.abs(seen.barycentrics[shown].sum(axis=-1) - 1).max() < 1e-6
    place = polyscan.interpolate(star, seen)
    depth = 3 - place[..., 2]
    assert np.abs(depth - seen.depth)[shown].max() < 1e-5
    y, x = np.nonzero(shown)
    focal = 75 / np.tan(np.radians(30))
    assert np.abs(100 + focal * place[y, x, 0] / depth[y, x] - (x + 0.5)).max() < 0.02
    assert np.abs(75 - focal * place[y, x, 1] / depth[y, x] - (y + 0.5)).max() < 0.02


def test_a_batch_is_its_parts() -> None:
    vertices, faces = sphere(8)
    cameras = [Camera.around(vertices, yaw=yaw) for yaw in (0, 40, 80)]
    many = polyscan.rasterize(vertices, faces, cameras, SIZE, derivatives=True)
    assert many.face.shape == (3, 16, 24) and many.derivatives.shape == (3, 16, 24, 3, 2)
    shapes = np.stack([vertices, 0.5 * vertices, vertices[:, ::-1]])
    moved = polyscan.rasterize(shapes, faces, cameras, SIZE)
    fixed = polyscan.rasterize(shapes, faces, cameras[0], SIZE)
    values = polyscan.interpolate(shapes, moved)
    for i, camera in enumerate(cameras):
        one = polyscan.rasterize(vertices, faces, camera, SIZE, derivatives=True)
        for name in ("face", "depth", "barycentrics", "derivatives"):
            assert np.array_equal(getattr(many, name)[i], getattr(one, name))
        assert np.array_equal(moved.face[i], polyscan.rasterize(shapes[i], faces, camera, SIZE).face)
        assert np.array_equal(fixed.face[i], polyscan.rasterize(shapes[i], faces, cameras[0], SIZE).face)
        alone = polyscan.rasterize(shapes[i], faces, camera, SIZE)
        assert np.array_equal(values[i], polyscan.interpolate(shapes[i], alone))


def test_tiles_join_to_the_bit() -> None:
    vertices, faces = sphere(20)
    camera = Camera.around(vertices)
    whole = polyscan.rasterize(vertices, faces, camera, (70, 50), derivatives=True)
    for left, top, width, height in ((0, 0, 70, 50), (3, 7, 20, 11), (69, 49, 1, 1), (35, 0, 35, 50)):
        part = polyscan.rasterize(vertices, faces, camera, (70, 50), derivatives=True, tile=(left, top, width, height))
        for name in ("face", "depth", "barycentrics", "derivatives"):
            want = getattr(whole, name)[top : top + height, left : left + width]
            assert np.array_equal(getattr(part, name), want), name


def test_culling_goes_by_the_side_that_is_seen() -> None:
    vertices, faces = sphere(12)
    camera = Camera.around(vertices)
    outside = picture(vertices, faces, camera, cull="back")
    assert np.array_equal(outside.face, picture(vertices, faces, camera).face)
    inside = picture(vertices, faces, camera, cull="front")
    shown = inside.face >= 0
    assert np.array_equal(shown, outside.face >= 0)
    assert (inside.depth > outside.depth)[shown].all()


def test_nothing_at_all() -> None:
    for vertices, faces in ((np.empty((0, 3)), np.empty((0, 3), int)), (SQUARE, []), (SQUARE, np.empty((0, 5), int))):
        seen = picture(vertices, faces)
        assert (seen.face == -1).all() and (seen.depth == 0).all()
        assert polyscan.interpolate(np.ones((len(vertices), 2)), seen, background=7).max() == 7


WRONG = [
    ("vertices", {"vertices": np.zeros((4, 2))}),
    ("vertices", {"vertices": np.zeros(3)}),
    ("vertices", {"vertices": np.zeros((1, 1, 4, 3))}),
    ("vertices", {"vertices": "abc"}),
    ("vertices", {"vertices": None}),
    ("vertices", {"vertices": SQUARE.astype(complex)}),
    ("vertices", {"vertices": [[1, 2, 3], [4, 5]]}),
    ("vertices", {"vertices": np.where(np.arange(12).reshape(4, 3) == 5, np.nan, SQUARE)}),
    ("vertices", {"vertices": np.where(np.arange(12).reshape(4, 3) == 5, -np.inf, SQUARE).astype("f4")}),
    ("vertices", {"vertices": np.zeros((0, 4, 3))}),
    ("faces", {"faces": [[0, 1, 4]]}),
    ("faces", {"faces": [[0, -1, 2]]}),
    ("faces", {"faces": [[0, 1]]}),
    ("faces", {"faces": [0, 1, 2]}),
    ("faces", {"faces": [[0.0, 1, 2]]}),
    ("faces", {"faces": [[True, False, True]]}),
    ("faces", {"faces": None}),
    ("faces", {"faces": "faces"}),
    ("faces", {"faces": np.array([[0, 1, 2**40]])}),
    ("faces", {"faces": np.array([[0, 1, 2**32]])}),
    ("faces", {"faces": [[0, 1, 2], [0, 1]]}),
    ("faces", {"faces": [[0, 1, 2, 3], [0, 1, 9]]}),
    ("faces", {"faces": [[0, 1, 2, 3], ["a", "b", "c"]]}),
    ("faces", {"faces": Polygons([0, 1, 2], [0, 2])}),
    ("faces", {"faces": Polygons([0, 1, 2], [0, 3, 2, 3])}),
    ("faces", {"faces": Polygons([0, 1, 2], [1, 3])}),
    ("faces", {"faces": Polygons([0, 1, 2], [])}),
    ("faces", {"faces": Polygons([0, 1, 7], [0, 3])}),
    ("faces", {"faces": Polygons([0.5, 1, 7], [0, 3])}),
    ("faces", {"vertices": np.empty((0, 3))}),
    ("camera", {"camera": None}),
    ("camera", {"camera": np.eye(4)}),
    ("camera", {"camera": 3}),
    ("camera", {"camera": []}),
    ("camera", {"camera": [CAMERA, 2]}),
    ("camera", {"camera": [CAMERA] * 3, "vertices": np.stack([SQUARE] * 2)}),
    ("size", {"size": 5}),
    ("size", {"size": (5,)}),
    ("size", {"size": (0, 5)}),
    ("size", {"size": (5, 65537)}),
    ("size", {"size": (5.5, 5)}),
    ("size", {"size": (-1, 5)}),
    ("tile", {"tile": (0, 0, 25, 1)}),
    ("tile", {"tile": (24, 0, 1, 1)}),
    ("tile", {"tile": (0, 0, 1)}),
    ("samples", {"samples": 0}),
    ("samples", {"samples": 2}),
    ("samples", {"samples": "8"}),
    ("layers", {"layers": 2, "samples": 4}),
    ("layers", {"layers": 0}),
    ("layers", {"layers": 1.5}),
    ("cull", {"cull": "both"}),
    ("threads", {"threads": 0}),
    ("threads", {"threads": "all"}),
]


@pytest.mark.parametrize(("name", "options"), WRONG)
def test_what_is_wrong_is_named(name: str, options: dict) -> None:
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        picture(**options)


def test_what_is_wrong_is_said_where() -> None:
    with pytest.raises(ValueError, match=r"faces\[1, 2\] is 9, but the vertices are numbered from 0 to 3"):
        picture(faces=[[0, 1, 2], [0, 2, 9]])
    broken = np.ones((9000, 3))
    broken[[4321, 7777]] = np.nan
    with pytest.raises(ValueError, match=r"vertices\[4321\] is not finite"):
        picture(broken, np.zeros((1, 3), int))


NUMBERS = st.one_of(
    st.floats(width=32),
    st.sampled_from([0.0, -0.0, 1e38, -1e38, 1e-45, np.inf, -np.inf, np.nan, 1.0, 2.0**-24]),
)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    vertices=st_np.arrays(
        st.sampled_from(["f4", "f8"]), st.tuples(st.integers(0, 9), st.sampled_from([3, 4])), elements=NUMBERS
    ),
    faces=st.one_of(
        st_np.arrays(
            st.sampled_from(["i4", "u4", "i8"]), st.tuples(st.integers(0, 6), st.integers(2, 5)), elements=st.integers(0, 9)
        ),
        st.lists(st.lists(st.integers(-1, 9), min_size=2, max_size=6), max_size=5),
    ),
    size=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    behind=st.sampled_from([{}, {"layers": 2}, {"layers": 3}, {"samples": 4}, {"samples": 16}]),
    clip=st.sampled_from(["zero_to_one", "minus_one_to_one"]),
)
def test_anything_is_drawn_or_refused(vertices, faces, size, behind, clip) -> None:
    camera = CAMERA if vertices.shape[1] == 3 else Camera.clip_space(depth_range=clip)
    try:
        seen = polyscan.rasterize(vertices, faces, camera, size, **behind, derivatives=True, threads=1)
    except ValueError as error:
        assert str(error).startswith(("vertices", "faces")), error
        assert not (
            np.isfinite(vertices).all()
            and all(len(face) >= 3 and all(0 <= i < len(vertices) for i in face) for face in faces)
            and (isinstance(faces, list) or faces.shape[1] >= 3)
        ), error
        return
    assert np.isfinite(vertices).all()
    assert seen.face.shape[:2] == (size[1], size[0])
    assert (seen.face >= -1).all() and (seen.face < max(len(faces), 1)).all()
    assert np.isfinite(seen.depth).all()
    weights = seen.barycentrics[seen.face >= 0]
    assert (weights >= 0).all() and np.allclose(weights.sum(axis=-1), 1, atol=1e-5)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(max_size=3) | st.integers(),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=2), inner, max_size=2),
    )
)
def test_nonsense_is_a_value_error(nonsense) -> None:
    for name in ("vertices", "faces", "size", "tile", "samples", "layers", "threads", "cull"):
        try:
            picture(**{name: nonsense})
        except ValueError as error:
            # With other vertices the faces may refer to what is not there.
            assert str(error).startswith((name, "faces") if name == "vertices" else name), error
