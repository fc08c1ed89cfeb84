"""nvdiffrast's layout, by what its documentation says of it."""

from __future__ import annotations

import numpy as np
import pytest

import polyscan.nvdiffrast as dr

HEIGHT, WIDTH = 40, 56


@pytest.fixture
def scene(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Triangles in OpenGL's clip space, two pictures of them."""
    pos = rng.uniform(-1, 1, (2, 12, 4)).astype(np.float32)
    pos[..., 3] = rng.uniform(1, 3, (2, 12))
    pos[..., :3] *= pos[..., 3:]
    tri = np.array([rng.choice(12, 3, replace=False) for _ in range(9)], np.int32)
    return pos, tri


def test_what_is_stored_leads_back_to_the_pixel(scene: tuple[np.ndarray, np.ndarray]) -> None:
    pos, tri = scene
    rast, rast_db = dr.rasterize(None, pos, tri, resolution=[HEIGHT, WIDTH])
    assert rast.shape == rast_db.shape == (2, HEIGHT, WIDTH, 4) and rast.dtype == np.float32
    # Row 0 is at the bottom, Y = -1.
    x, y = np.meshgrid((np.arange(WIDTH) + 0.5) * 2 / WIDTH - 1, (np.arange(HEIGHT) + 0.5) * 2 / HEIGHT - 1)
    shown = 0
    for picture, points in zip(rast, pos.astype(np.float64), strict=True):
        u, v, z, number = np.moveaxis(picture.astype(np.float64), -1, 0)
        seen = number > 0
        corners = points[tri[number[seen].astype(int) - 1]]
        u, v = u[seen][:, None], v[seen][:, None]
        place = u * corners[:, 0] + v * corners[:, 1] + (1 - u - v) * corners[:, 2]
        inside = (u > 1e-3) & (v > 1e-3) & (u + v < 0.999)
        error = np.abs(place[:, :2] / place[:, 3:] - np.stack([x[seen], y[seen]], -1))
        assert error[inside[:, 0]].max() < 2e-5
        assert np.abs(place[:, 2] / place[:, 3] - z[seen]).max() < 1e-5
        assert (picture[~seen] == 0).all()
        shown += seen.sum()
    assert shown > 500


def test_derivatives_run_upwards(scene: tuple[np.ndarray, np.ndarray]) -> None:
    pos, tri = scene
    rast, rast_db = dr.rasterize(None, pos, tri, resolution=[HEIGHT, WIDTH])
    same_x = (rast[:, :, 2:, 3] == rast[:, :, :-2, 3]) & (rast[:, :, 1:-1, 3] == rast[:, :, 2:, 3]) & (rast[:, :, 2:, 3] > 0)
    same_y = (rast[:, 2:, :, 3] == rast[:, :-2, :, 3]) & (rast[:, 1:-1, :, 3] == rast[:, 2:, :, 3]) & (rast[:, 2:, :, 3] > 0)
    along_x = (rast[:, :, 2:, :2] - rast[:, :, :-2, :2]) / 2
    along_y = (rast[:, 2:, :, :2] - rast[:, :-2, :, :2]) / 2
    # Centred differences are right to second order; half of all pixels see small changes.
    for got, want, same in (
        (rast_db[:, :, 1:-1, ::2], along_x, same_x),
        (rast_db[:, 1:-1, :, 1::2], along_y, same_y),
    ):
        assert same.sum() > 200
        error = np.abs(got - want)[same] / (1e-3 + np.abs(want)[same])
        assert np.median(error) < 0.01 and np.quantile(error, 0.9) < 0.1


def test_layers_are_peeled_from_the_nearest_on(scene: tuple[np.ndarray, np.ndarray]) -> None:
    pos, tri = scene
    glctx = dr.RasterizeGLContext(output_db=True)
    first, first_db = dr.rasterize(glctx, pos, tri, [HEIGHT, WIDTH])
    with dr.DepthPeeler(dr.RasterizeCudaContext(device="cuda"), pos, tri, [HEIGHT, WIDTH]) as peeler:
        layers = [peeler.rasterize_next_layer() for _ in range(4)]
    assert np.array_equal(layers[0][0], first) and np.array_equal(layers[0][1], first_db)
    seen = np.stack([rast for rast, _ in layers])
    behind = seen[1:, ..., 3] > 0
    assert behind[0].sum() > 200 and not (behind & (seen[:-1, ..., 3] == 0)).any()
    assert (seen[1:, ..., 2] >= seen[:-1, ..., 2] - 1e-5)[behind].all()
    assert (seen[1:, ..., 3] != seen[:-1, ..., 3])[behind].all()
    # Each layer leads back to its own pixel.
    y, x = np.nonzero(behind[0, 0])
    corners = pos[0].astype(np.float64)[tri[seen[1, 0, y, x, 3].astype(int) - 1]]
    u, v = seen[1, 0, y, x, :2].astype(np.float64).T[..., None]
    place = u * corners[:, 0] + v * corners[:, 1] + (1 - u - v) * corners[:, 2]
    inside = ((u > 1e-3) & (v > 1e-3) & (u + v < 0.999))[:, 0]
    error = np.abs((place[:, 0] / place[:, 3] + 1) / 2 * WIDTH - x - 0.5)
    assert inside.sum() > 100 and error[inside].max() < 1e-3


def test_ranges_are_parts_of_the_triangles(scene: tuple[np.ndarray, np.ndarray]) -> None:
    pos, tri = scene
    ranges = np.array([[0, 4], [4, 5], [2, 0]])
    rast, rast_db = dr.rasterize(None, pos[0], tri, [HEIGHT, WIDTH], ranges=ranges, grad_db=False)
    assert rast_db.shape == (3, HEIGHT, WIDTH, 0)
    for (start, count), picture in zip(ranges, rast, strict=True):
        numbers = set(np.unique(picture[..., 3])) - {0}
        assert numbers <= set(range(start + 1, start + count + 1))
        alone, _ = dr.rasterize(None, pos[:1], tri[start : start + count], [HEIGHT, WIDTH])
        assert np.array_equal(alone[0, ..., :3], picture[..., :3])


def test_attributes_and_textures(scene: tuple[np.ndarray, np.ndarray], rng: np.random.Generator) -> None:
    pos, tri = scene
    rast, rast_db = dr.rasterize(None, pos, tri, [HEIGHT, WIDTH])
    attr = rng.random((1, 12, 5), np.float32)
    out, da = dr.interpolate(attr, rast, tri, rast_db=rast_db, diff_attrs=[0, 3])
    assert out.shape == (2, HEIGHT, WIDTH, 5) and da.shape == (2, HEIGHT, WIDTH, 4)
    number = rast[..., 3].astype(int) - 1
    corners = attr[0][tri[np.maximum(number, 0)]].astype(np.float64)
    u, v = rast[..., 0, None], rast[..., 1, None]
    want = u * corners[..., 0, :] + v * corners[..., 1, :] + (1 - u - v) * corners[..., 2, :]
    assert np.abs(out - want)[number >= 0].max() < 1e-6
    assert (out[number < 0] == 0).all()
    slope = (corners[..., 0, :] - corners[..., 2, :]), (corners[..., 1, :] - corners[..., 2, :])
    for i, channel in enumerate((0, 3)):
        for axis in (0, 1):
            want = rast_db[..., axis] * slope[0][..., channel] + rast_db[..., 2 + axis] * slope[1][..., channel]
            error = np.abs(da[..., 2 * i + axis] - want)[number >= 0]
            assert (error <= 1e-5 * (1 + np.abs(want[number >= 0]))).all()
    uv, uv_da = dr.interpolate(attr[..., :2], rast, tri, rast_db=rast_db, diff_attrs="all")
    tex = rng.random((1, 16, 16, 5), np.float32)
    for mode in ("linear", "nearest", "linear-mipmap-nearest", "linear-mipmap-linear"):
        color = dr.texture(tex, uv, uv_da, filter_mode=mode)
        assert color.shape == (2, HEIGHT, WIDTH, 5)
        assert (color >= tex.min() - 1e-6).all() and (color <= tex.max() + 1e-6).all()
    assert np.array_equal(dr.texture(tex, uv), dr.texture(tex, uv, filter_mode="linear"))
    # A texel's centre is its colour.
    place = np.broadcast_to(np.array([3.5 / 16, 7.5 / 16], np.float32), (1, 1, 1, 2))
    assert np.allclose(dr.texture(tex, place), tex[:, 7:8, 3:4])
    assert (dr.texture(tex, place + 1, boundary_mode="zero") == 0).all()


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("pos", lambda pos, tri: dr.rasterize(None, pos[0], tri, [4, 4])),
        ("pos", lambda pos, tri: dr.rasterize(None, pos[..., :3], tri, [4, 4])),
        ("tri", lambda pos, tri: dr.rasterize(None, pos, tri + 9, [4, 4])),
        ("tri", lambda pos, tri: dr.rasterize(None, pos, np.ones((1, 4), int), [4, 4])),
        ("resolution", lambda pos, tri: dr.rasterize(None, pos, tri, 4)),
        ("ranges", lambda pos, tri: dr.rasterize(None, pos[0], tri, [4, 4], ranges=[[0, 99]])),
        ("rast", lambda pos, tri: dr.interpolate(pos, pos, tri)),
        ("tex", lambda pos, tri: dr.texture(pos, np.zeros((1, 2, 2, 2)))),
        ("filter_mode", lambda pos, tri: dr.texture(np.zeros((1, 2, 2, 1)), np.zeros((1, 2, 2, 2)), filter_mode="ewa")),
    ],
)
def test_what_is_wrong_is_named(name: str, call, scene: tuple[np.ndarray, np.ndarray]) -> None:
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        call(*scene)
