"""Threads, forks, the interpreter's lock, memory."""

from __future__ import annotations

import gc
import os
import pathlib
import re
import resource
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import polyscan
from conftest import sphere
from polyscan import Camera

VERTICES, FACES = sphere(40)
CAMERA = Camera.around(VERTICES)


def draw_seen(size: tuple[int, int], threads: int | None = None) -> polyscan.Seen:
    return polyscan.rasterize(VERTICES, FACES, CAMERA, size, derivatives=True, threads=threads)


def draw(threads: int | None = None, size: tuple[int, int] = (160, 120)) -> bytes:
    seen = draw_seen(size, threads)
    parts = (seen.face, seen.depth, seen.barycentrics, seen.derivatives)
    return b"".join(part.tobytes() for part in parts)


def test_any_number_of_threads_gives_the_same_bits() -> None:
    want = draw(1)
    assert all(draw(threads) == want for threads in (2, 3, 8, None, 1))


def test_threads_are_as_many_as_are_asked_for() -> None:
    def count() -> int:
        tasks = pathlib.Path("/proc/self/task")
        return sum((task / "comm").read_text().startswith("polyscan") for task in tasks.iterdir())

    if not os.path.isdir("/proc/self/task"):
        pytest.skip("only where threads can be listed")

    def settled(want: int) -> bool:
        deadline = time.monotonic() + 10
        while count() != want and time.monotonic() < deadline:
            time.sleep(0.01)
        return count() == want

    draw(3)
    assert settled(3)
    draw(1)
    assert settled(1)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_it_works_after_a_fork() -> None:
    want = draw()
    for _ in range(3):
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                os.write(write, b"y" if draw() == want and draw(2) == want else b"n")
            finally:
                os._exit(0)
        os.close(write)
        assert os.read(read, 1) == b"y"
        os.close(read)
        os.waitpid(child, 0)
    assert draw() == want


def test_it_works_on_several_threads_of_the_interpreter() -> None:
    want = draw()
    with ThreadPoolExecutor(4) as pool:
        assert all(got == want for got in pool.map(lambda _: draw(2), range(40)))


def test_the_interpreter_goes_on_meanwhile() -> None:
    """While one large picture is drawn, another thread counts: with the lock held it could not."""
    vertices, faces = sphere(400)
    done, counted = threading.Event(), [0]

    def count() -> None:
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    begin = time.monotonic()
    before = counted[0]
    polyscan.rasterize(vertices, faces, Camera.around(vertices), (4000, 3000), derivatives=True)
    seconds, ticks = time.monotonic() - begin, counted[0] - before
    done.set()
    counter.join()
    assert seconds > 0.1, "too short to tell"
    assert ticks > 10 * seconds, f"{ticks} ticks in {seconds:.2f} s"


def test_memory_does_not_grow_over_ten_thousand_calls() -> None:
    vertices, faces = sphere(6)
    camera = Camera.around(vertices)
    picture = np.random.default_rng(1).random((8, 8, 3))
    colors = np.full((len(vertices), 3), 200, np.uint8)

    def call() -> None:
        seen = polyscan.rasterize(vertices, faces, camera, (32, 24), derivatives=True, threads=1)
        uv = polyscan.interpolate(vertices[:, :2], seen, threads=1)
        polyscan.texture(picture, uv, threads=1)
        polyscan.rasterize(vertices, faces, camera, (8, 6), samples=4, threads=1)
        polyscan.bake(vertices[:, :2].clip(0, 1), faces, (8, 8), threads=1)
        polyscan.render(vertices, faces, colors=colors, size=(8, 8), samples=1, threads=1)
        try:
            polyscan.rasterize(vertices, [[0, 1, 10**6]], camera, (32, 24))
        except ValueError:
            pass

    def resident() -> int:
        gc.collect()
        with open("/proc/self/statm") as numbers:
            return int(numbers.read().split()[1]) * resource.getpagesize()

    if not os.path.exists("/proc/self/statm"):
        pytest.skip("only where memory can be read")
    for _ in range(1000):
        call()
    before = resident()
    for _ in range(10_000):
        call()
    # A leak of one pixel's depth a call would be 40 kB; what the allocator keeps comes and goes by more.
    assert resident() - before < 4_000_000


def peak(call) -> int:
    """The most memory that a call takes beyond what there is, in bytes."""

    def kilobytes(name: str) -> int:
        status = pathlib.Path("/proc/self/status").read_text()
        return int(re.search(rf"^{name}:\s+(\d+) kB$", status, re.MULTILINE)[1])

    if not os.access("/proc/self/clear_refs", os.W_OK):
        pytest.skip("only where the peak can be reset")
    gc.collect()
    pathlib.Path("/proc/self/clear_refs").write_text("5")
    before = kilobytes("VmRSS")
    call()
    return 1024 * (kilobytes("VmHWM") - before)


@pytest.mark.parametrize("kind", ["i4", "u4"])
def test_faces_are_not_copied(kind: str) -> None:
    few, megabyte = np.zeros((1000, 3), np.float32), 1 << 20
    # 192 MB; a part of them at a time is looked up.
    faces = np.ones((16 * megabyte, 3), kind)
    taken = peak(lambda: polyscan.rasterize(few, faces, CAMERA, (32, 24), threads=1))
    assert taken < 96 * megabyte, f"{taken / megabyte:.0f} MB"
    # As it is asked for, a copy is seen.
    assert peak(lambda: polyscan.rasterize(few, faces.astype("i8"), CAMERA, (32, 24), threads=1)) > 192 * megabyte
    faces.flags.writeable = False
    assert peak(lambda: polyscan.rasterize(few, faces, CAMERA, (32, 24), threads=1)) < 96 * megabyte


def test_vertices_are_not_copied() -> None:
    nothing, megabyte = np.zeros((1, 3), np.int32), 1 << 20
    # 192 MB, which are 128 MB in clip space.
    vertices = np.ones((8 * megabyte, 3), np.float64)
    taken = peak(lambda: polyscan.rasterize(vertices, nothing, CAMERA, (32, 24), threads=1))
    assert taken < 160 * megabyte, f"{taken / megabyte:.0f} MB"


def test_results_are_handed_over_as_they_were_made() -> None:
    seen = draw_seen((640, 480))
    # Arrays that own nothing are views of what the compiled half made; no other memory is in between.
    for array in (seen.face, seen.depth, seen.barycentrics, seen.derivatives):
        assert array.base is not None and array.flags.c_contiguous and array.flags.writeable
