"""Edits that come and go leave nothing behind: no memory, no open file, no object."""
import ctypes
import gc
import os
import pathlib
import tracemalloc

import numpy as np

import dynmesh

# Of the process: 2 kB an edit. Measured are 0.3 MB at most, mostly 0.
MOST_GROWTH = 1 << 20


def resident():
    """What is in use: garbage and what the allocator keeps for later are given back."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def open_files():
    return len(os.listdir("/proc/self/fd"))


def prepare(mesh, random):
    """Some hundred vertices, and a field of each kind on them."""
    mesh.apply(add_points=(np.arange(1, 101), random.random((100, 2))))
    mesh.fields.add("u", np.sin(mesh.points[:, 0]))
    mesh.fields.add("q", np.ones(mesh.cell_slots), kind="P0")


def edit(mesh, places, step):
    """What one of these does the next one takes back: the mesh does not grow."""
    place = places[step // 4 % len(places)]
    change = step % 4
    if change == 0:
        diff = mesh.apply(add_points={1000: place, 1001: place + 0.01},
                          add_segments={1002: (1000, 1001)})
    elif change == 1:
        diff = mesh.apply(move_points={1000: place - 0.01}, add_sizes={
            1003: dict(at=place, radius=0.02, target=0.02)})
    elif change == 2:
        diff = mesh.apply(remove=[1003, 1002])
    else:
        diff = mesh.apply(remove=[1000, 1001])
    v = diff.transfer(np.ones(mesh.vertex_slots))
    assert v.min() > 0.99
    # What is made on demand, too.
    diff.patch.vertices, diff.donors, diff.old_to_new, diff.pieces(), mesh.compact()
    if step % 50 == 0:
        try:  # an error holds no frame or batch
            mesh.apply(add_segments={5000: (1, 999)})
        except dynmesh.DynmeshError as error:
            assert error.reason == "UNKNOWN_END"
        else:
            raise AssertionError("accepted")


def test_a_thousand_edits_leave_nothing(make_mesh, random):
    files = open_files()
    mesh = make_mesh()
    prepare(mesh, random)
    # Few places, which come again: all arrays have their final size early.
    places = 0.1 + 0.8 * random.random((5, 2))
    # The server's connection opens some, once.
    edit(mesh, places, 0)
    connected = open_files()
    for step in range(1, 500):
        edit(mesh, places, step)
    before, hash_before = resident(), mesh.hash
    for step in range(500, 1000):
        edit(mesh, places, step)
    grown = resident() - before
    assert grown < MOST_GROWTH, f"{grown} bytes in 500 edits"
    assert mesh.hash == hash_before  # it is the mesh of then
    assert open_files() == connected and connected - files < 20


def test_python_objects_go_with_their_edits(make_mesh, random):
    mesh = make_mesh()
    prepare(mesh, random)
    places = 0.1 + 0.8 * random.random((5, 2))
    for step in range(100):
        edit(mesh, places, step)
    gc.collect()
    tracemalloc.start()
    try:
        # Those that the first of them leaves, such as the last diff, are no growth.
        for step in range(100, 120):
            edit(mesh, places, step)
        gc.collect()
        before = tracemalloc.take_snapshot()
        for step in range(120, 220):
            edit(mesh, places, step)
        gc.collect()
        after = tracemalloc.take_snapshot()
    finally:
        tracemalloc.stop()
    lines = [line for line in after.compare_to(before, "lineno")
             if "tracemalloc" not in line.traceback[0].filename and line.count_diff > 50]
    assert not lines, "\n".join(map(str, lines))


def test_meshes_and_connections_go_when_they_are_dropped(make_mesh, daemon):
    def one():
        mesh = make_mesh()
        prepare(mesh, np.random.default_rng(1))
        with dynmesh.connect(daemon.address) as server:
            server.stats()

    for _ in range(20):
        one()
    before, files = resident(), open_files()
    for _ in range(100):  # of which the replica alone takes 40 kB
        one()
    grown = resident() - before
    assert grown < MOST_GROWTH, f"{grown} bytes in 100 meshes"
    assert open_files() - files < 5
