"""Borders that stay whole, in process and on a server."""
import numpy as np
import pytest

import dynmesh

BOX = [[0, 0], [1, 1]]


def circle(n, radius=0.3):
    t = 2 * np.pi * np.arange(n) / n
    return 0.5 + radius * np.stack([np.cos(t), np.sin(t)], axis=1)


def on_border(mesh, polygon, radius=0.3):
    points = mesh.part(polygons=polygon).points
    return points[np.abs(np.linalg.norm(points - 0.5, axis=1) - radius) < 1e-6]


def load(mesh, n, **more):
    ids = np.arange(1, n + 1)
    mesh.apply(add_points=(ids, circle(n)), add_polygons={1000: ids.tolist()}, **more)


def finer(target):
    return {2000: dict(target=target, at=(0.5, 0.5), radius=0.45)}


def test_a_polygon_stays_whole_beside_small_targets():
    split, whole = dynmesh.open(box=BOX), dynmesh.open(box=BOX)
    load(split, 24, add_sizes=finer(0.02))
    load(whole, 24, add_sizes=finer(0.02), unsplit=True)
    assert len(on_border(split, 1000)) == 24  # vertices on chords are nearer to the centre
    inside = split.part(polygons=1000), whole.part(polygons=1000)
    assert len(inside[0].facets) > 24
    assert len(inside[1].facets) == 24


def test_marks_are_features_and_can_be_taken_away():
    mesh = dynmesh.open(box=BOX)
    load(mesh, 12, unsplit=[1000])
    assert [f["id"] for f in mesh.features() if f.get("unsplit")] == [1000]
    ids = list(range(1, 13))
    mesh.apply(set_polygons={1000: ids}, add_sizes=finer(0.02))
    assert not any(f.get("unsplit") for f in mesh.features())
    assert len(mesh.part(polygons=1000).facets) > 12
    mesh.apply(set_polygons={1000: ids}, unsplit=np.array([1000]))
    assert len(mesh.part(polygons=1000).facets) == 12


def test_what_is_in_the_way_is_refused_with_a_spacing():
    mesh = dynmesh.open(box=BOX)
    mesh.apply(add_points={1: (0.2, 0.5), 2: (0.8, 0.5)}, add_segments={3: (1, 2)}, unsplit=True)
    with pytest.raises(dynmesh.FailedPrecondition, match="spacing of at most 0.199") as refusal:
        mesh.apply(add_points={4: (0.5, 0.6)})
    assert refusal.value.reason == "ENCROACHED"
    assert list(refusal.value.features) == [4, 3]
    ids = np.arange(10, 14)
    points = dynmesh.points_along([(0.2, 0.5), (0.8, 0.5)], 0.199)
    assert len(points) == 5
    chain = [1, 10, 11, 12, 2]
    mesh.apply(remove=[3], add_points=(ids[:3], points[1:-1]),
               add_segments={20 + i: (chain[i], chain[i + 1]) for i in range(4)}, unsplit=True)
    mesh.apply(add_points={4: (0.5, 0.6)})


@pytest.mark.parametrize("value, error", [
    ([3], ValueError), ([1], ValueError), ("all", TypeError), (1.5, TypeError)])
def test_marks_name_what_the_edits_add(value, error):
    mesh = dynmesh.open(box=BOX)
    with pytest.raises(error, match="expected is unsplit=True"):
        mesh.apply(add_points={1: (0.2, 0.5), 2: (0.8, 0.5)}, add_segments={10: (1, 2)},
                   unsplit=value)
    mesh.apply(add_points={1: (0.2, 0.5), 2: (0.8, 0.5)}, add_segments={10: (1, 2)}, unsplit=False)
    assert not any(f.get("unsplit") for f in mesh.features())


def test_in_space_it_is_refused():
    mesh = dynmesh.open(box=[[0, 0, 0], [1, 1, 1]])
    with pytest.raises(dynmesh.InvalidArgument, match="three dimensions") as refusal:
        mesh.apply(add_points={1: (0.2, 0.5, 0.5), 2: (0.8, 0.5, 0.5)}, add_segments={3: (1, 2)},
                   unsplit=True)
    assert refusal.value.reason == "BAD_UNSPLIT"


def test_a_server_keeps_marks_in_its_journal(daemon):
    with dynmesh.connect(daemon.address) as server:
        mesh = server.create("kept", box=BOX)
        load(mesh, 24, unsplit=[1000])
        mesh.apply(add_sizes=finer(0.02))
        before = mesh.hash
        local = dynmesh.open(box=BOX)
        load(local, 24, unsplit=[1000], add_sizes=finer(0.02))
        assert local.hash == before
    daemon.stop()
    daemon.start()
    with dynmesh.connect(daemon.address) as server:
        mesh = server.mesh("kept")
        assert mesh.hash == before
        assert [f["id"] for f in mesh.features() if f.get("unsplit")] == [1000]
        mesh.revert(1)
        assert [f["id"] for f in mesh.features() if f.get("unsplit")] == [1000]


def test_joined_corners_keep_a_polygon_whole():
    mesh = dynmesh.open(box=BOX)
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2), 3: (0.8, 0.8), 4: (0.2, 0.8)},
               add_polygons={7: (1, 2, 3, 4)}, unsplit=True)
    mesh.apply(add_points={5: (0.5, 0.2)}, join=True)
    found = {f["id"]: f for f in mesh.features()}
    assert found[7]["rings"] == [[1, 5, 2, 3, 4]]
    assert found[7]["unsplit"]
    assert len(mesh.part(polygons=7).facets) == 5


def test_points_along_a_polyline_keep_its_corners():
    points = dynmesh.points_along([(0, 0), (1, 0), (1, 0.3)], 0.25)
    assert np.allclose(points[:5], np.stack([np.arange(5) / 4, np.zeros(5)], axis=1))
    assert np.allclose(points[5:], [(1, 0.15), (1, 0.3)])
    closed = dynmesh.points_along([(0, 0), (1, 0), (1, 1), (0, 1)], 0.5, closed=True)
    assert len(closed) == 8
    assert np.array_equal(closed, dynmesh.points_along(
        [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)], 0.5, closed=True))
    # Opposite borders of a periodic box, though rounding makes one of them longer.
    low = dynmesh.points_along([(0.1, 0.1), (0.4, 0.1)], 0.1)
    high = dynmesh.points_along([(0.1, 0.7), (0.4 + 5e-17, 0.7)], 0.1)
    assert len(low) == len(high) == 4
    assert np.allclose(high - low, (0, 0.6), atol=1e-15)


def test_points_along_a_function_are_equally_far_apart():
    def spiral(t):
        return (t * np.cos(6 * t), t * np.sin(6 * t))

    points = dynmesh.points_along(spiral, 0.05)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() <= 0.05 and steps.min() > 0.04
    with pytest.raises(ValueError, match="spacing"):
        dynmesh.points_along(spiral, 0)
    with pytest.raises(ValueError, match="curve"):
        dynmesh.points_along([(0, 0)], 0.1)


def box_of(left, right):
    """A square with names for its left and right side, which have these points."""
    mesh = dynmesh.open(box=BOX)
    ring = [*right, *left[::-1]]
    ids, n = list(range(1, len(ring) + 1)), len(right)
    chain = {100 + i: (i, i + 1) for i in ids[:-1] if i != n}
    mesh.apply(add_points=(ids, np.array(ring)), add_polygons={1000: ids}, add_segments=chain, unsplit=True,
               add_sizes={2000: dict(target=0.05, at=(0.3, 0.4), radius=0.2)},
               set_labels={id_: dict(name="right" if id_ < 100 + n else "left") for id_ in chain})
    return mesh.part(polygons=1000)


def test_periodic_borders_have_partners():
    left, right = (dynmesh.points_along([(x, 0.1), (x, 0.9)], 0.09) for x in (0.1, 0.9))
    part = box_of(left, right)
    pairs = dynmesh.periodic_pairs(part, "left", "right")
    assert len(pairs) == len(left)
    assert np.allclose(part.points[pairs[:, 1]] - part.points[pairs[:, 0]], [0.8, 0], atol=1e-15)
    assert len(np.unique(pairs)) == 2 * len(left)
    turn = dynmesh.Frame(np.pi, pivot=(0.5, 0.5))
    turned = dynmesh.periodic_pairs(part, "left", "right", turn)
    assert np.allclose(part.points[turned].sum(axis=1), 1, atol=1e-14)
    with pytest.raises(dynmesh.NotFound, match="no facet of 'top'; names are: 'left', 'right'"):
        dynmesh.periodic_pairs(part, "left", "top")
    part = box_of(left, dynmesh.points_along([(0.9, 0.1), (0.9, 0.9)], 0.07))
    with pytest.raises(dynmesh.InvalidArgument, match="not alike: the vertex of 'left'.*points_along"):
        dynmesh.periodic_pairs(part, "left", "right")
    with pytest.raises(dynmesh.InvalidArgument, match="not alike: the vertex of 'right'"):
        dynmesh.periodic_pairs(part, "right", "left")
