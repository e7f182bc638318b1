"""One mesh, many threads: edits are serialised, readers see one revision."""
import os
import threading

import numpy as np
import pytest

import dynmesh

THREADS = 8
# Under a sanitizer the same takes many times as long.
NIGHTLY = os.environ.get("DYNMESH_NIGHTLY", "0") not in ("", "0")
EDITS = int(os.environ.get("DYNMESH_TEST_EDITS", 1000 if NIGHTLY else 300))


def run(*functions):
    """Runs each in a thread of its own; raises the first error."""
    errors = []

    def guarded(function):
        try:
            function()
        except BaseException as error:  # noqa: B902: raised below
            errors.append(error)

    threads = [threading.Thread(target=guarded, args=(function,)) for function in functions]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]


def while_editing(edits, readers):
    """Runs the edits, and each reader again and again until these are over, once at least."""
    over = threading.Event()

    def read(reader):
        reader()
        while not over.is_set():
            reader()

    def edit():
        try:
            run(*edits)
        finally:
            over.set()

    run(edit, *(lambda reader=reader: read(reader) for reader in readers))


def change(thread, step):
    """An edit of the thread's own point."""
    place = (0.1 + 0.1 * thread + 1e-4 * (step % 37), 0.1 + 0.8 * (step % 11) / 11)
    return {"add_points" if step == 0 else "move_points": {thread + 1: place}}


def area(points, cells):
    """Of the live cells together."""
    corners = points[cells[cells[:, 0] >= 0]]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]).sum()


def test_edits_of_threads_are_those_of_a_series():
    mesh = dynmesh.open(((0, 0), (1, 1)))
    mesh.fields.add("one", np.ones(mesh.vertex_slots))
    mesh.fields.add("mean", np.ones(mesh.cell_slots), kind="P0", bounded=True)
    whole = area(mesh.points, mesh.cells)
    edit_of = {}

    def edit(thread):
        for step in range(EDITS):
            diff = mesh.apply(**change(thread, step))
            assert diff.to_revision == diff.from_revision + 1
            edit_of[diff.to_revision] = thread, step

    def read_arrays():
        taken = [mesh.points, mesh.cells, mesh.ids, mesh.neighbours, mesh.regions]
        copies = [array.copy() for array in taken]
        assert np.isclose(area(mesh.compact().points, mesh.compact().cells[:0]), 0)
        assert all((array == copy).all() for array, copy in zip(taken, copies))

    def read_one_revision():
        with mesh.locked():
            before = mesh.revision, mesh.hash
            assert np.isclose(area(mesh.points, mesh.cells), whole)
            assert len(mesh.fields["one"]) == len(mesh.points) == mesh.vertex_slots
            assert np.allclose(mesh.fields["one"][mesh.live_vertices], 1)
            assert np.allclose(mesh.fields["mean"][mesh.live_cells], 1)
            assert (mesh.revision, mesh.hash) == before

    def read_the_rest():
        compact = mesh.compact()
        assert np.isclose(area(compact.points, compact.cells), whole)
        slots = mesh.locate([(0.31, 0.47), (100, 0)])
        assert slots[0] >= 0 and slots[1] == -1
        assert len(mesh.features()) <= THREADS and mesh.labels == {} and mesh.region_sets == {}
        assert (mesh.find(mesh.ids[:1]) >= -1).all()
        assert set(mesh.fields) == {"one", "mean"} and "Mesh of 2" in repr(mesh)

    while_editing([lambda t=t: edit(t) for t in range(THREADS)],
                  [read_arrays, read_one_revision, read_the_rest])
    assert mesh.revision == THREADS * EDITS == len(edit_of) and mesh._replica.audit() == []
    series = dynmesh.open(((0, 0), (1, 1)))
    for revision in sorted(edit_of):
        series.apply(**change(*edit_of[revision]))
    assert series.hash == mesh.hash and series.revision == mesh.revision


def test_an_array_stays_as_it_was(random):
    mesh = dynmesh.open(((0, 0), (1, 1)))
    mesh.apply(add_points=(np.arange(1, 101), random.random((100, 2))))
    held = []
    for step in range(60):
        arrays = (mesh.points, mesh.ids, mesh.cells, mesh.neighbours, mesh.regions, mesh.owners,
                  mesh.subsegments, mesh.containing_dimensions)
        held.append([(array, array.copy()) for array in arrays])
        mesh.apply(move_points={step + 1: random.random(2)})
        if step % 3:
            del held[random.integers(len(held))]
        assert all((array == copy).all() for row in held for array, copy in row)
    field = mesh.fields.add("x", mesh.points[:, 0])
    copy = field.copy()
    mesh.apply(move_points={7: random.random(2)})
    assert (field == copy).all() and field is not mesh.fields["x"]
    with pytest.raises(ValueError, match="read-only"):
        field[0] = 1
    with pytest.raises(ValueError, match="earlier revision"):
        mesh.fields["x"] = field
    mesh.fields["x"] += 1
    assert np.allclose(mesh.fields["x"][mesh.live_vertices],
                       mesh.points[mesh.live_vertices, 0] + 1)


def test_a_field_that_is_not_in_use_is_carried_in_place(random):
    mesh = dynmesh.open(((0, 0), (1, 1)))
    mesh.apply(add_points=(np.arange(1, 101), random.random((100, 2))))
    mesh.fields.add("x", mesh.points[:, 0])
    mesh.apply(add_points=(np.arange(201, 301), random.random((100, 2))))  # makes room
    where = mesh.fields["x"].__array_interface__["data"]
    mesh.apply(move_points={7: (0.7, 0.2)})
    assert mesh.fields["x"].__array_interface__["data"] == where


def test_transfers_beside_edits_are_right_or_refused():
    mesh = dynmesh.open(((0, 0), (1, 1)))
    mesh.apply(add_points={i + 1: (0.15 + 0.1 * i, 0.5) for i in range(THREADS)})
    outcomes = {True: 0, False: 0}

    def edit(thread):
        for step in range(1, max(EDITS // 10, 20)):
            diff = mesh.apply(**change(thread, step))
            try:
                u = diff.transfer(np.full(diff._old_slots[0], 2.5))
                kept = diff.old_to_new
                pieces = diff.pieces()
                assert (u[kept[kept >= 0]] == 2.5).all() and (pieces.measure > 0).all()
                assert len(diff.donors) == len(diff.patch.added_cells)
                outcomes[True] += 1
            except dynmesh.StaleDiff as error:
                assert "locked" in str(error)
                outcomes[False] += 1
            with mesh.locked():
                diff = mesh.apply(**change(thread, step + 1))
                u = diff.transfer(np.full(diff._old_slots[0], 2.5))
                assert (u[mesh.live_vertices] == 2.5).all()

    run(*(lambda t=t: edit(t) for t in range(3)))
    assert sum(outcomes.values()) == 3 * (max(EDITS // 10, 20) - 1)


def test_callbacks_may_read_and_not_edit():
    mesh = dynmesh.open(((0, 0), (1, 1)))
    mesh.fields.add("one", np.ones(mesh.vertex_slots))
    seen = []

    def progress(stage, done, total):
        assert mesh.revision == 0 and len(mesh.points) == len(mesh.fields["one"])
        for call in (lambda: mesh.apply(add_points={9: (0.1, 0.1)}), mesh.sync, mesh.features,
                     lambda: next(mesh.stream([{}])), lambda: mesh.load(add_points={9: (0.1, 0.1)}),
                     lambda: mesh.locate([(0.5, 0.5)])):
            with pytest.raises(dynmesh.FailedPrecondition, match="callback"):
                call()
        with mesh.locked():
            seen.append(stage)

    mesh.apply(progress=progress, add_points={1: (0.5, 0.5)})
    assert "refine" in seen and mesh.revision == 1

    def kind(old, pieces):
        with pytest.raises(dynmesh.FailedPrecondition, match="callback"):
            mesh.apply(add_points={9: (0.1, 0.1)})
        assert len(mesh.features()) == 1 and mesh.locate([(0.5, 0.5)]) >= 0
        seen.append("carried")
        return np.zeros(len(np.unique(pieces.new)))

    mesh.fields.add("own", np.zeros(mesh.cell_slots), kind=kind)
    mesh.apply(move_points={1: (0.4, 0.5)})
    assert seen[-1] == "carried" and set(mesh.fields) == {"one", "own"}

    # Another thread waits for the edit, and a callback that raises ends it.
    entered, asked = threading.Event(), threading.Event()

    def fail(stage, done, total):
        entered.set()
        asked.wait(30)
        raise KeyError("stop")

    def edit():
        with pytest.raises(KeyError):
            mesh.apply(progress=fail, move_points={1: (0.6, 0.5)})

    def other():
        entered.wait(30)
        assert mesh.revision == 2 and len(mesh.compact().points) == mesh.vertex_count
        asked.set()
        assert mesh.apply(move_points={1: (0.7, 0.5)}).to_revision == 3

    run(edit, other)
    assert mesh.features()[0]["at"] == (0.7, 0.5)


def test_streams_of_threads(make_mesh):
    mesh = make_mesh()
    mesh.fields.add("one", np.ones(mesh.vertex_slots))
    steps = min(EDITS, 100)

    def stream(thread):
        for diff in mesh.stream([change(thread, step) for step in range(steps)]):
            assert diff.to_revision <= mesh.revision

    def apply(thread):
        for step in range(steps):
            mesh.apply(**change(thread, step))

    run(lambda: stream(0), lambda: stream(1), lambda: apply(2), lambda: apply(3))
    mesh.sync()
    assert mesh.revision == 4 * steps
    again = dynmesh.open(((0, 0), (1, 1)))
    again.apply(add_points={f["id"]: f["at"] for f in mesh.features()})
    assert again.hash == mesh.hash
    assert np.allclose(mesh.fields["one"][mesh.live_vertices], 1)


def test_a_follower_beside_edits_of_the_same_mesh(server):
    mesh = server.create(box=[[0, 0], [1, 1]])
    mesh.apply(add_points={1: (0.5, 0.5)})
    over = threading.Event()

    def edit():
        for step in range(1, 200):
            mesh.apply(**change(0, step))
        over.set()

    def follow():
        while not over.is_set():
            for diff in mesh.follow(timeout=0.2):
                assert diff.to_revision <= mesh.revision

    run(edit, follow)
    assert mesh.revision == 200 and mesh.hash == server.mesh(mesh.name).hash
