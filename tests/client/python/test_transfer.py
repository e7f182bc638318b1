"""Fields across edits, from numpy."""
import numpy as np
import pytest

import dynmesh
from helpers import mass, sample

KINDS = ["P1", "P0", "DG1"]


def wave(x):
    return 2 + np.sin(5 * x[..., 0]) * np.cos(4 * x[..., 1])


def linear(x):
    return 1 + 3 * x[..., 0] - 2 * x[..., 1]


def random_edit(random, live, dimension, counter):
    choice = random.integers(3) if len(live) > 10 else 0
    if choice == 0:
        live.append(counter)
        return dict(add_points={counter: random.random(dimension)})
    if choice == 1:
        return dict(remove=[live.pop(random.integers(len(live)))])
    return dict(move_points={live[random.integers(len(live))]: random.random(dimension)})


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("bounded", [False, True])
def test_mass_and_linear_fields_stay(make_mesh, random, dimension, bounded):
    mesh = make_mesh(box=[[0] * dimension, [1] * dimension])
    count = 100 if dimension == 2 else 40
    mesh.apply(add_points=(np.arange(1, count + 1), random.random((count, dimension))))
    fields = {(kind, f): sample(mesh, f, kind) for kind in KINDS for f in (wave, linear)}
    begin = {key: mass(mesh, u, key[0]) for key, u in fields.items()}
    live = list(range(1, count + 1))
    for step in range(40 if dimension == 2 else 10):
        try:
            diff = mesh.apply(**random_edit(random, live, dimension, 1000 + step))
        except dynmesh.DynmeshError:
            continue
        for key, u in fields.items():
            fields[key] = diff.transfer(u, kind=key[0], bounded=bounded)
    for (kind, f), u in fields.items():
        before, size = begin[kind, f]
        assert abs(mass(mesh, u, kind)[0] - before) <= 1e-12 * size, kind
        if f is linear and not bounded:
            live_rows = mesh.live_vertices if kind == "P1" else mesh.live_cells
            assert np.abs(u - sample(mesh, f, kind))[live_rows].max() < 1e-11, kind


def test_bounded_values_keep_the_integral_in_each_region(make_mesh, random):
    """A front beside the plate's border: there is room within the bounds on either side."""
    mesh = make_mesh(box=[[0, 0], [1, 1]], max_edge=0.1)
    mesh.apply(add_points={1: (0, 0), 2: (1, 0), 3: (1, 1), 4: (0, 1)},
               add_polygons={10: (1, 2, 3, 4)})
    x = mesh.points
    u = np.where(np.hypot(x[:, 0] - 0.9, x[:, 1] - 0.5) < 0.2, 1.0, 0.0)

    def masses():
        corners = mesh.points[mesh.cells] * mesh.live_cells[:, None, None]
        area = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 2
        each = area * u[mesh.cells].mean(axis=1)
        return each[mesh.regions == 10].sum(), each[mesh.regions == 0].sum()

    overshoots = 0
    for step in range(40):
        before, low, high = masses(), u[mesh.live_vertices].min(), u[mesh.live_vertices].max()
        try:
            diff = mesh.apply(add_points={100 + step: (0.7 + 0.29 * random.random(), random.random())})
        except dynmesh.DynmeshError:
            continue
        overshoots += diff.transfer(u)[mesh.live_vertices].max() > high
        u = diff.transfer(u, bounded=True)
        assert low <= u[mesh.live_vertices].min() and u[mesh.live_vertices].max() <= high
        told = sum(f.amounts[0] * ((f.old == 10) - (f.new == 10)) for f in diff.flows)
        assert masses() == pytest.approx((before[0] - told, before[1] + told), abs=1e-14)
    assert overshoots > 0


def test_components_and_places(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 51), random.random((50, 2))))
    v = np.stack([wave(mesh.points), linear(mesh.points)], axis=1)
    d = np.stack([sample(mesh, wave, "DG1"), sample(mesh, linear, "DG1")], axis=2)
    diff = mesh.apply(remove=[3])
    both = diff.transfer(v)
    assert (both[:, 0] == diff.transfer(np.ascontiguousarray(v[:, 0]))).all()
    assert (both[:, 1] == diff.transfer(v[:, 1].copy())).all()
    assert diff.transfer(d, kind="DG1").shape == (mesh.cell_slots, 3, 2)
    # In place it is the same, and more rows than slots are left alone.
    room = np.full(mesh.vertex_slots + 10, 7.0)
    room[:len(v)] = v[:, 0]
    assert diff.transfer(room, inplace=True) is room
    assert (room[:mesh.vertex_slots] == both[:mesh.vertex_slots, 0]).all()
    assert (room[mesh.vertex_slots:] == 7).all()


def test_tags_and_functions(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 51), random.random((50, 2))))
    tags = np.array([f"cell {i}" for i in range(mesh.cell_slots)])
    u = wave(mesh.points[mesh.cells].mean(axis=1))
    diff = mesh.apply(remove=[3])
    carried = diff.transfer(tags, kind="overlap")
    assert (carried[diff.patch.added_cells] == tags[diff.donors]).all()

    def first_order(old, pieces):
        # What "P0" of order 1 does, by hand.
        cells = diff.patch.added_cells
        row = np.searchsorted(np.sort(cells), pieces.new)
        order = np.argsort(np.argsort(cells))
        mass = np.bincount(row, old[pieces.old] * pieces.measure, len(cells))
        whole = np.bincount(row, pieces.measure, len(cells))
        return (mass / whole)[order]

    by_hand = diff.transfer(u, kind=first_order)
    assert np.allclose(by_hand, diff.transfer(u, kind="P0", order=1), rtol=1e-12)


def test_momentum(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 51), random.random((50, 2))))
    rho, v = wave(mesh.points), np.stack([linear(mesh.points), np.full(mesh.vertex_slots, 0.5)], 1)
    before = mass(mesh, rho * v[:, 0], "P1")
    diff = mesh.apply(remove=[3, 4])
    rho2, v2 = diff.transfer_momentum(rho, v)
    after = mass(mesh, rho2 * v2[:, 0], "P1")
    assert abs(after[0] - before[0]) <= 1e-13 * before[1]
    assert np.allclose(v2[mesh.live_vertices, 1], 0.5, rtol=1e-12)


def test_flows_between_regions(make_mesh):
    mesh = make_mesh()
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2), 3: (0.8, 0.8), 4: (0.2, 0.8)},
               add_polygons={7: [1, 2, 3, 4]})
    u = wave(mesh.points[mesh.cells].mean(axis=1))
    inside = mesh.regions == 7
    before = mass(mesh, np.where(inside, u, 0), "P0")[0]
    diff = mesh.apply(move_points={3: (0.85, 0.85)})
    u = diff.transfer(u, kind="P0", order=1)
    after = mass(mesh, np.where(mesh.regions == 7, u, 0), "P0")[0]
    gained = sum(f.amounts[0] for f in diff.flows if f.new == 7)
    lost = sum(f.amounts[0] for f in diff.flows if f.old == 7)
    assert gained > 0 and np.isclose(after - before, gained - lost, atol=1e-13)


def test_fields_follow_their_mesh(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 51), random.random((50, 2))))
    mesh.fields.add("u", linear(mesh.points))
    mesh.fields.add("p", sample(mesh, wave, "P0"), kind="P0", bounded=True)
    mesh.fields.add("tag", np.arange(mesh.cell_slots), kind="overlap")
    begin = mass(mesh, mesh.fields["p"], "P0")
    for step in range(30):
        mesh.apply(add_points={100 + step: random.random(2)})
    assert len(mesh.fields["u"]) == mesh.vertex_slots
    live = mesh.live_vertices
    assert np.abs(mesh.fields["u"] - linear(mesh.points))[live].max() < 1e-11
    assert abs(mass(mesh, mesh.fields["p"], "P0")[0] - begin[0]) < 1e-12 * begin[1]
    assert mesh.fields["tag"].dtype.kind == "i"
    # One that cannot be carried is dropped, and said; the others go on.
    mesh.fields["u"][:] = np.nan
    with pytest.raises(dynmesh.InvalidArgument, match="u: .*finite"):
        mesh.apply(remove=[1])
    assert set(mesh.fields) == {"p", "tag"} and len(mesh.fields["p"]) == mesh.cell_slots
    mesh.apply(remove=[2])


def test_bad_fields_change_nothing(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 51), random.random((50, 2))))
    u = wave(mesh.points)
    diff = mesh.apply(remove=[3])
    nan = u.copy()
    nan[diff.patch.removed_corners[0, 0]] = np.nan
    cases = [
        (dict(u=u[:-1]), ValueError, "a row for each vertex slot"),
        (dict(u=np.float64(1)), ValueError, "a row for each slot"),
        (dict(u=np.zeros((mesh.vertex_slots, 2, 2))), ValueError, "axis of components"),
        (dict(u=u.astype(complex)), TypeError, "complex"),
        (dict(u=np.array(["a"] * len(u))), TypeError, "cannot be carried"),
        (dict(u=nan), ValueError, "finite"),
        (dict(u=u, kind="P2"), ValueError, "no kind 'P2'"),
        (dict(u=u, rings=-1), ValueError, "rings"),
        (dict(u=np.zeros(mesh.cell_slots), kind="P0", order=3), ValueError, "order"),
        (dict(u=np.zeros((mesh.cell_slots, 2)), kind="DG1"), ValueError, "slots, 3"),
        (dict(u=np.ones(mesh.vertex_slots, np.float32), inplace=True), TypeError, "float64"),
        (dict(u=mesh.points[:, 0], inplace=True), TypeError, "C-contiguous"),
    ]
    for arguments, error, words in cases:
        before = np.array(arguments["u"])
        with pytest.raises(error, match=words):
            diff.transfer(**arguments)
        assert np.array_equal(arguments["u"], before, equal_nan=before.dtype.kind == "f")
    diff.transfer(u)
    mesh.apply(remove=[4])
    with pytest.raises(dynmesh.StaleDiff, match="before the next edit"):
        diff.transfer(u)
