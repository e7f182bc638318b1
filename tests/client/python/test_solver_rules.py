"""What docs/solvers.md tells authors of solvers, in its order."""
import numpy as np
import pytest

import dynmesh
from helpers import mass, measures


def plate(make_mesh, **more):
    """Polygons 7, on the right, and 8 beside each other."""
    mesh = make_mesh(box=[[0, 0], [2, 1]], max_edge=0.15)
    mesh.apply(add_points={1: (0, 0), 2: (1, 0), 3: (2, 0), 4: (2, 1), 5: (1, 1), 6: (0, 1)},
               add_polygons={7: (2, 3, 4, 5), 8: (1, 2, 5, 6)}, **more)
    return mesh


def inner_point(random):
    return random.uniform((0.05, 0.05), (1.95, 0.95))


def dual_volumes(part):
    corners = part.points[part.cells]
    measure = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2
    return np.bincount(part.cells.ravel(), np.repeat(measure / 3, 3), len(part.points))


def dye(points):
    return np.where(np.hypot(points[:, 0] - 0.6, points[:, 1] - 0.5) < 0.3, 1.0, 0.0)


@pytest.mark.parametrize("bounded", [False, True])
def test_means_over_median_dual_cells_are_carried_as_p1(make_mesh, random, bounded):
    mesh = plate(make_mesh)
    part = mesh.part()
    u = dye(mesh.points)
    for step in range(20):
        before = (dual_volumes(part) * u[part.vertex_slots]).sum()
        diff = mesh.apply(add_points={100 + step: inner_point(random)})
        u = diff.transfer(u, bounded=bounded)
        part.update(diff)
        assert (dual_volumes(part) * u[part.vertex_slots]).sum() == pytest.approx(before, abs=1e-14)
        if bounded:
            inside = u[part.vertex_slots]
            assert 0 <= inside.min() and inside.max() <= 1


def test_means_over_median_dual_cells_are_carried_as_dual_within_their_range(make_mesh, random):
    """On a part, its border and a crack in it end the cells: nothing goes through."""
    mesh = plate(make_mesh)
    mesh.apply(add_points={11: (1.2, 0.5), 12: (1.8, 0.5)}, add_segments={9: (11, 12)})
    part = mesh.part(polygons=7, open=9)
    u = np.where(part.points[:, 0] + part.points[:, 1] < 1.9, 1.0, 0.0)
    one, whole = np.full(len(u), 0.1), dye(mesh.points)
    for step in range(20):
        before, all_before = (dual_volumes(part) * u).sum(), mass(mesh, whole, "P1")[0]
        diff = mesh.apply(add_points={100 + step: inner_point(random)})
        former = {int(slot): u[part.origin == number]
                  for number, slot in enumerate(part.vertex_slots) if part.origin[number] == number}
        whole = diff.transfer(whole, kind="dual")
        u, one = part.transfer(diff, u, "dual"), part.transfer(diff, one, "dual")
        assert (dual_volumes(part) * u).sum() == pytest.approx(before, abs=1e-14)
        assert mass(mesh, whole, "P1")[0] == pytest.approx(all_before, abs=1e-14)
        assert 0 <= u.min() and u.max() <= 1 and (one == 0.1).all()
        changed = set(diff.patch.vertices.tolist())  # local: others stay to the bit
        for number, slot in enumerate(part.vertex_slots.tolist()):
            if slot not in changed and part.origin[number] == number:
                assert u[number] in former[slot]


def test_a_jump_between_regions_stays_as_dg1(make_mesh, random):
    mesh = plate(make_mesh)
    u = np.where(mesh.regions == 7, 2.0, 1.0)[:, None] * np.ones(3)
    for step in range(20):
        u = mesh.apply(add_points={100 + step: inner_point(random)}).transfer(u, kind="DG1")
    live = mesh.live_cells
    np.testing.assert_allclose(u[live], np.where(mesh.regions == 7, 2.0, 1.0)[live, None] * np.ones(3),
                               rtol=1e-14)


def test_free_rows_have_id_0_and_corners_below_0(make_mesh):
    mesh = plate(make_mesh)
    mesh.apply(add_points={100: (0.51, 0.52)})
    mesh.apply(remove=[100])
    assert not mesh.live_vertices.all() and not mesh.live_cells.all()
    np.testing.assert_array_equal(mesh.ids != 0, mesh.live_vertices)
    np.testing.assert_array_equal((mesh.cells >= 0).all(axis=1), mesh.live_cells)
    assert (mesh.cells[~mesh.live_cells] == -1).all()
    part = mesh.part()
    assert len(part.points) == len(np.unique(part.cells)) and (part.cells >= 0).all()
    inside = part.points
    assert (inside >= 0).all() and (inside <= [2, 1]).all()


def test_a_diff_changes_the_rows_of_its_patch(make_mesh, random):
    mesh = plate(make_mesh)
    part = mesh.part()
    for step in range(10):
        points, cells, ids = mesh.points.copy(), mesh.cells.copy(), mesh.ids.copy()
        measure, u = measures(mesh), random.random(mesh.vertex_slots)
        means = random.random(mesh.cell_slots)
        diff = mesh.apply(add_points={100 + step: inner_point(random)})
        patch = diff.patch
        gone, came = patch.removed_cells, patch.added_cells
        assert not np.isin(came, gone).any()
        assert measures(mesh)[came].sum() == pytest.approx(measure[gone].sum(), rel=1e-12)
        kept = diff.kept_cells
        np.testing.assert_array_equal(mesh.cells[kept], cells[kept])
        stays = np.flatnonzero(diff.old_to_new >= 0)
        np.testing.assert_array_equal(mesh.points[stays], points[stays])
        np.testing.assert_array_equal(mesh.ids[stays], ids[stays])
        # Rows of a matrix that change: of vertices with another set of cells around.
        def around(rows, slots):
            corners = rows[slots]
            return np.bincount(corners.ravel(), np.repeat(slots + 1.0, 3), len(mesh.ids))
        before = around(cells, np.flatnonzero((cells >= 0).all(axis=1)))
        after = around(mesh.cells, np.flatnonzero(mesh.live_cells))
        changed = np.flatnonzero((before != after) & mesh.live_vertices)
        assert np.isin(changed, patch.vertices).all()
        # Values: at the cavity and a ring around it, for P0 in new cells.
        v = diff.transfer(u)
        near = mesh.live_cells & np.isin(mesh.cells, patch.vertices).any(axis=1)
        far = np.setdiff1d(stays, mesh.cells[near])
        np.testing.assert_array_equal(v[far], u[far])
        np.testing.assert_array_equal(diff.transfer(means, kind="P0")[kept], means[kept])
        # The same of a part.
        was = part.cells.copy(), part.points.copy()
        part.update(diff)
        rows = np.setdiff1d(np.arange(min(len(was[0]), len(part.cells))), part.changed_cells)
        np.testing.assert_array_equal(part.cells[rows], was[0][rows])
        rows = np.setdiff1d(np.arange(min(len(was[1]), len(part.points))), part.changed_vertices)
        np.testing.assert_array_equal(part.points[rows], was[1][rows])


def test_the_inverse_edit_gives_back_the_mesh_and_the_integral(make_mesh, random):
    mesh = plate(make_mesh)
    u, hash_ = dye(mesh.points), mesh.hash
    before = mass(mesh, u, "P1")[0]
    there = mesh.apply(add_points={100: (0.6, 0.79)}).transfer(u)
    diff = mesh.apply(remove=[100])
    back = diff.transfer(there)
    assert mesh.hash == hash_
    assert mass(mesh, back, "P1")[0] == pytest.approx(before, abs=1e-13)


def test_a_segment_owns_an_edge_before_polygons(make_mesh):
    mesh = plate(make_mesh, set_labels={7: dict(marker=1), 8: dict(marker=2)})
    part = mesh.part()

    def owners():
        middle = part.points[part.facets].mean(axis=1)
        return set(part.facet_owners[middle[:, 0] == 1].tolist())

    assert owners() == {7}
    part.update(mesh.apply(add_segments={9: (2, 5)}, set_labels={9: dict(marker=3)}))
    assert owners() == {9}
    assert set(part.facet_markers.tolist()) == {1, 2, 3}
    with pytest.raises(dynmesh.DynmeshError, match="DUPLICATE_SEGMENT"):
        mesh.apply(add_segments={10: (5, 2)})
    part.update(mesh.apply(remove=[9]))
    assert owners() == {7}
    # The part is on the left of an edge of its border.
    a, b = part.points[part.facets[part.is_border]].transpose(1, 0, 2)
    third = part.points[part.cells[part.facet_cells[part.is_border, 0]]].mean(axis=1)
    left = (b - a)[:, 0] * (third - a)[:, 1] - (b - a)[:, 1] * (third - a)[:, 0]
    assert (left > 0).all()


def test_copies_of_a_seam_and_its_pairs(make_mesh):
    mesh = plate(make_mesh, add_segments={9: (2, 5)})
    tip = (1.5, 0.5)
    mesh.apply(add_points={20: tip, 21: (1.9, 0.5)}, add_segments={22: (20, 21)})
    part = mesh.part(open=[22])
    each = np.ones(len(part.points))
    summed = np.zeros(len(part.points))
    np.add.at(summed, part.origin, each)
    copies = np.bincount(part.origin, minlength=len(part.points))
    np.testing.assert_array_equal(summed, copies)
    assert copies.max() == 2
    continuous = np.arange(len(part.points))[part.origin]
    assert (continuous == continuous[part.origin]).all()
    assert copies[(part.points == tip).all(axis=1)].tolist() == [1]
    one = np.flatnonzero(part.facet_sides > 0)
    other = part.facet_twins[one]
    assert len(one) > 1 and (part.facet_sides[other] == -1).all()
    np.testing.assert_array_equal(part.points[part.facets[one]].mean(axis=1),
                                  part.points[part.facets[other]].mean(axis=1))
