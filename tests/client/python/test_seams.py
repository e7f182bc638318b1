"""Parts that are opened along cracks, and values that jump across these."""
import numpy as np
import pytest

import dynmesh

LEFT, RIGHT = 6, 3  # points in the middle of the plate's sides


def plate(make_mesh, **more):
    """The unit square, polygon 7, with points in the middle of its sides."""
    mesh = make_mesh(box=[[0, 0], [1, 1]], max_edge=0.1)
    mesh.apply(add_points={1: (0, 0), 2: (1, 0), RIGHT: (1, 0.5), 4: (1, 1), 5: (0, 1),
                           LEFT: (0, 0.5), **more.pop("points", {})},
               add_polygons={7: (1, 2, RIGHT, 4, 5, LEFT)}, **more)
    return mesh


def box(make_mesh):
    """The unit cube in two storeys; the floor between them is polygon 40."""
    mesh = make_mesh(box=[[0] * 3, [1] * 3], max_edge=0.3)
    corners = {1 + 4 * level + i: (x, y, z) for level, z in enumerate((0, 0.5, 1))
               for i, (x, y) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1)))}
    walls = {20 + 4 * level + i: (a, 4 * level + 1 + (i + 1) % 4, 4 * level + 5 + (i + 1) % 4, a + 4)
             for level in range(2) for i, a in enumerate(range(4 * level + 1, 4 * level + 5))}
    mesh.apply(add_points=corners,
               add_polygons={30: (1, 2, 3, 4), 31: (9, 10, 11, 12), 40: (5, 6, 7, 8), **walls},
               set_labels={40: dict(name="floor")})
    return mesh


def measures(part):
    corners = part.points[part.cells]
    edges = corners[:, 1:] - corners[:, :1]
    return np.linalg.det(edges) / {2: 2, 3: 6}[part.mesh.dimension]


def integral(part, u):
    share = measures(part) / part.cells.shape[1]
    return np.einsum("n,nk...->...", share, u[part.cells])


def is_above(part, height=0.5):
    """Of each vertex, whether one of its cells lies above: of copies on a crack one has."""
    top = part.points[:, -1] > height
    above = part.points[part.cells].mean(axis=1)[:, -1] > height
    np.logical_or.at(top, part.cells, above[:, None])
    return top


def content(part):
    """Copies as sets of cells, and facets, by slots of the mesh."""
    cells_of = [[] for _ in part.origin]
    for corners, slot in zip(part.cells.tolist(), part.cell_slots.tolist()):
        for corner in corners:
            cells_of[corner].append(slot)
    copies = sorted((slot, sorted(cells)) for slot, cells in
                    zip(part.vertex_slots.tolist(), cells_of))
    facets = np.column_stack([np.sort(part.vertex_slots[part.facets], axis=1), part.facet_owners,
                              np.sort(part._part.facet_cells, axis=1), part.facet_twins >= 0])
    return copies, sorted(map(tuple, facets.tolist()))


def test_a_crack_has_two_sides(make_mesh):
    mesh = plate(make_mesh, points={10: (0.3, 0.5), 11: (0.7, 0.5)}, add_segments={20: (10, 11)},
                 set_labels={20: dict(marker=9, name="crack")})
    closed, part = mesh.part(polygons=7), mesh.part(polygons=7, open=[20])
    doubled = np.flatnonzero(part.origin != np.arange(len(part.origin)))
    assert len(part.points) == len(closed.points) + len(doubled) and len(doubled) >= 3
    x, y = part.points[doubled].T
    assert (y == 0.5).all() and (x > 0.3).all() and (x < 0.7).all()
    np.testing.assert_array_equal(part.points[part.origin], part.points)
    np.testing.assert_array_equal(part.vertex_slots[part.origin], part.vertex_slots)
    np.testing.assert_allclose(measures(part).sum(), 1)
    # Facets: each side has its own, with the feature's marker and name.
    upper, lower = part.facet_sides == 1, part.facet_sides == -1
    assert upper.sum() == lower.sum() == len(doubled) + 1
    assert (part.facet_markers[upper] == 9).all() and (part.facet_names[lower] == "crack").all()
    assert part.is_border[upper | lower].all()
    np.testing.assert_array_equal(np.sort(part.facet_twins[upper]), np.flatnonzero(lower))
    above = part.points[part.cells[part.facet_cells[:, 0]]].mean(axis=1)[:, 1] > 0.5
    assert above[upper].all() and not above[lower].any()
    np.testing.assert_array_equal(part.origin[part.facets[upper]],
                                  part.origin[part.facets[part.facet_twins[upper]][:, ::-1]])
    some = np.append(doubled[:2], 0)
    np.testing.assert_array_equal(part.cells_around(some),
                                  np.flatnonzero(np.isin(part.cells, some).any(axis=1)))
    with pytest.raises(dynmesh.OutOfRange, match="none with number -1"):
        part.cells_around(-1)
    assert part.to_meshio().points.shape == part.points.shape
    with pytest.raises(dynmesh.NotFound, match="no feature has the name 'creck'"):
        mesh.part(open="creck")
    with pytest.raises(dynmesh.InvalidArgument, match="open=.7, 9."):
        mesh.part(open=[1.5])


def test_a_crack_that_grows_is_followed(make_mesh):
    """By name: it kinks, branches, reaches the border, and goes."""
    mesh = plate(make_mesh, points={10: (0.3, 0.5), 11: (0.5, 0.5)}, add_segments={20: (10, 11)},
                 set_labels={20: dict(name="crack")})
    part = mesh.part(polygons=7, open="crack")
    name = dict(name="crack")
    for edits in (dict(add_points={12: (0.6, 0.6)}, add_segments={21: (11, 12)}),
                  dict(add_points={13: (0.6, 0.4)}, add_segments={22: (11, 13)}),
                  dict(add_segments={23: (13, RIGHT)}),
                  dict(move_points={11: (0.52, 0.51)}),
                  dict(remove=[20]),
                  dict(set_labels={21: None}),
                  dict(set_labels={21: name})):
        if "add_segments" in edits:
            edits["set_labels"] = {id_: name for id_ in edits["add_segments"]}
        diff = mesh.apply(**edits)
        part.update(diff)
        assert content(part) == content(mesh.part(polygons=7, open="crack"))
        assert len(part.changed_cells) < len(part.cells)
    assert (part.points[part.origin != np.arange(len(part.origin))] == [1, 0.5]).all(axis=1).any()


@pytest.mark.parametrize("dimension", [2, 3])
def test_jumps_stay_where_a_crack_cuts(make_mesh, dimension, random):
    """Linear functions on both sides of it, carried over many edits, are still that."""
    if dimension == 2:
        mesh = plate(make_mesh, add_segments={20: (LEFT, RIGHT)})
        part = mesh.part(polygons=7, open=20)
    else:
        mesh = box(make_mesh)
        part = mesh.part(open="floor")
        assert (part.facet_twins >= 0).sum() >= 4
    assert (part.origin != np.arange(len(part.origin))).sum() >= 4

    def exact():
        x, y = part.points[:, 0], part.points[:, -1]
        return np.column_stack([np.where(is_above(part), 1 + 2 * x + 3 * y, -5 + x - 4 * y),
                                is_above(part)])

    u = exact()
    before = integral(part, u)
    for i in range(20 if dimension == 2 else 6):
        edits = dict(add_points={100 + 3 * i + k: random.random(dimension) for k in range(3)})
        if i > 3:
            edits["remove"] = [100 + 3 * (i - 3) + k for k in range(3)]
        diff = mesh.apply(**edits)
        one = part.transfer(diff, u[:, 0])
        assert part.revision == mesh.revision
        u = part.transfer(diff, u)  # the same diff, another field
        np.testing.assert_array_equal(one, u[:, 0])
        np.testing.assert_allclose(u, exact(), rtol=0, atol=1e-12)
        np.testing.assert_allclose(integral(part, u), before, rtol=1e-12)


def test_a_jump_stays_while_a_crack_grows(make_mesh):
    """It opens linearly from x = 0.4 to the mouth; beyond, where it grows, there is no jump."""
    mesh = plate(make_mesh, points={10: (0.5, 0.5)}, add_segments={20: (LEFT, 10)},
                 set_labels={20: dict(name="crack")})
    part = mesh.part(polygons=7, open="crack")

    def exact():
        return np.where(is_above(part), 1, -1) * np.maximum(0, 0.4 - part.points[:, 0])

    u = exact()
    means = np.arange(len(part.cells)) % 5 + 0.0
    corners = u[part.cells]
    totals = integral(part, u), measures(part) @ means
    for i in range(5):
        diff = mesh.apply(add_points={11 + i: (0.58 + 0.08 * i, 0.5 + 0.01 * i),
                                      50 + i: (0.05 + 0.03 * i, 0.51)},
                          add_segments={21 + i: (10 + i, 11 + i)},
                          set_labels={21 + i: dict(name="crack")})
        u = part.transfer(diff, u)
        means = part.transfer(diff, means, "P0")
        corners = part.transfer(diff, corners, "DG1")
        share = measures(part)
        np.testing.assert_allclose(integral(part, u), totals[0], rtol=0, atol=1e-13)
        np.testing.assert_allclose(share @ means, totals[1], rtol=1e-12)
        np.testing.assert_allclose(share @ corners.mean(axis=1), totals[0], rtol=0, atol=1e-13)
        far = part.points[:, 0] < 0.25
        np.testing.assert_allclose(u[far], exact()[far], rtol=0, atol=1e-12)
        whole = far[part.cells].all(axis=1)
        np.testing.assert_allclose(corners[whole], exact()[part.cells][whole], rtol=0, atol=1e-12)
    mouth = (part.points == [0, 0.5]).all(axis=1)
    np.testing.assert_allclose(sorted(u[mouth]), [-0.4, 0.4], atol=1e-12)


def test_bounded_values_stay_within_their_range(make_mesh):
    mesh = plate(make_mesh, points={10: (0.3, 0.5)}, add_segments={20: (10, RIGHT)})
    part = mesh.part(polygons=7, open=20)
    random = np.random.default_rng(5)
    u = 5 + random.random(len(part.points))
    total = integral(part, u)
    for i in range(10):
        place = random.random(2) * [1, 0.05]  # near the lower side
        diff = mesh.apply(add_points={100 + i: place})
        corners = part.transfer(diff, u[part.cells] if i == 0 else corners, "DG1", bounded=True)
        u = part.transfer(diff, u, bounded=True)
        assert 5 <= u.min() and u.max() <= 6
        assert 5 <= corners.min() and corners.max() <= 6
    np.testing.assert_allclose(integral(part, u), total, rtol=1e-12)
    # What comes into the part has a value in this range, too.
    for corner in ((0.9, 0.9), (1, 1)):
        u = part.transfer(mesh.apply(move_points={4: corner}), u, bounded=True)
        assert 5 <= u.min() and u.max() <= 6


def test_what_cannot_be_transferred_is_refused(make_mesh):
    mesh = plate(make_mesh, points={10: (0.3, 0.5)}, add_segments={20: (10, RIGHT)})
    part = mesh.part(polygons=7, open=20)
    u = np.zeros(len(part.points))
    diff = mesh.apply(add_points={30: (0.6, 0.51)})
    with pytest.raises(ValueError, match="'P1', 'dual', 'P0' and 'DG1'"):
        part.transfer(diff, u, "P2")
    with pytest.raises(ValueError, match="the part had .* vertices"):
        part.transfer(diff, u[:-1])
    with pytest.raises(TypeError, match="real numbers"):
        part.transfer(diff, u.astype(complex))
    assert len(part.transfer(diff, u)) == len(part.points)
    later = mesh.apply(add_points={31: (0.6, 0.49)})
    with pytest.raises(dynmesh.StaleDiff):
        part.transfer(diff, u)
    part.update(later)
    with pytest.raises(dynmesh.StaleDiff, match="instead of an update"):
        part.transfer(later, np.zeros(len(part.points)))


@pytest.mark.parametrize("slope", [0, 1 / 3])
def test_a_crack_joins_the_border_that_it_reaches(make_mesh, slope):
    """The polygon gets a corner at the mouth, on slanted edges, too, and loses it with the crack."""
    mesh = make_mesh(box=[[0, 0], [3, 3]])
    a, b = np.array((0.1, 0.2)), np.array((2.9, 0.2 + 2.8 * slope))
    mesh.apply(add_points={1: a, 2: b, 3: (1, 3), 10: (1, 2), 11: (1.2, 1.6)},
               add_polygons={7: (1, 2, 3)}, add_segments={20: (10, 11)},
               set_labels={7: dict(name="plate")})
    before = mesh.hash
    mouth = dict(add_points={12: a + 0.37 * (b - a)}, add_segments={21: (11, 12)})
    with pytest.raises(dynmesh.FailedPrecondition):
        mesh.apply(**mouth)
    assert mesh.hash == before
    part = mesh.part(names="plate", open=[20, 21])
    diff = mesh.apply(join=True, **mouth)
    part.update(diff)
    rings = {f["id"]: f["rings"] for f in mesh.features() if f["kind"] == "polygon"}
    assert rings[7] == [[1, 12, 2, 3]] and mesh.labels[7].name == "plate"
    assert (part.points == mesh.points[part.vertex_slots]).all()
    assert (part.points == a + 0.37 * (b - a)).all(axis=1).sum() == 2  # open at the mouth
    with pytest.raises(dynmesh.FailedPrecondition, match="used by"):
        mesh.apply(remove=[21, 12])
    mesh.apply(remove=[21, 12], join=True)
    assert mesh.hash == before
    # A corner that is one stays, and what is no polygon is refused as before.
    with pytest.raises(dynmesh.FailedPrecondition, match="used by"):
        mesh.apply(remove=[3], join=True)
    with pytest.raises(dynmesh.FailedPrecondition, match="segment 20"):
        mesh.apply(add_points={30: (1.1, 1.8)}, join=True)
    # A polygon that comes in the same batch.
    mesh.apply(add_points={40: (2, 2.5), 41: (2.5, 2.5), 42: (2.5, 2.9), 43: (2.25, 2.5)},
               add_polygons={45: (40, 41, 42)}, join=True)
    rings = {f["id"]: f["rings"] for f in mesh.features() if f["kind"] == "polygon"}
    assert rings[45] == [[40, 43, 41, 42]]
