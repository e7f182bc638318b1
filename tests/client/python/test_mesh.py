"""Meshes as arrays: the same in process and at a server."""
import subprocess
import sys

import numpy as np
import pytest

import dynmesh
from helpers import measures


def test_a_new_mesh_is_its_box(make_mesh):
    mesh = make_mesh()
    assert mesh.dimension == 2 and mesh.revision == 0
    assert mesh.points.shape == (mesh.vertex_slots, 2) and mesh.points.dtype == np.float64
    assert mesh.cells.shape == (mesh.cell_slots, 3) and mesh.cells.dtype == np.int32
    assert mesh.ids.dtype == np.uint64 and len(mesh.hash) == 32
    box = mesh.points.max(axis=0) - mesh.points.min(axis=0)
    assert np.isclose(measures(mesh).sum(), box.prod())


@pytest.mark.parametrize("dimension", [2, 3])
def test_edits_of_all_kinds(make_mesh, dimension):
    z = (0.5,) * (dimension - 2)
    mesh = make_mesh(box=[[0] * dimension, [1] * dimension])
    diff = mesh.apply(
        add_points={1: (0.2, 0.2, *z), 2: (0.8, 0.2, *z), 3: (0.5, 0.8, *z), 4: (0.4, 0.3, *z)},
        add_segments={10: (1, 2), 11: (2, 3)},
    )
    assert (diff.from_revision, diff.to_revision) == (0, 1) and mesh.revision == 1
    assert set(mesh.owners[mesh.live_vertices]) >= {1, 2, 3, 4}
    assert set(mesh.subsegment_owners[mesh.subsegments[:, 0] >= 0]) >= {10, 11}
    mesh.apply(add_points=(np.array([20, 21]), [[0.1, 0.9, *z], [0.9, 0.9, *z]]),
               add_sizes={30: dict(at=(0.7, 0.7, *z), radius=0.1, target=0.05),
                          31: dict(low=(0.1,) * dimension, high=(0.2,) * dimension, target=0.1)})
    mesh.apply(move_points={20: (0.15, 0.85, *z)}, remove=[10, 31])
    kinds = {f["id"]: f for f in mesh.features()}
    assert kinds[20]["at"][:2] == (0.15, 0.85)
    assert kinds[11]["ends"] == (2, 3) and 10 not in kinds
    assert kinds[30]["radius"] == 0.1 and kinds[30]["kind"] == "size"
    # From scratch the mesh is the same.
    again = dynmesh.open([[0] * dimension, [1] * dimension])
    again.apply(add_points={i: f["at"] for i, f in kinds.items() if f["kind"] == "point"},
                add_segments={i: f["ends"] for i, f in kinds.items() if f["kind"] == "segment"},
                add_sizes={i: {k: f[k] for k in ("at", "radius", "target")}
                           for i, f in kinds.items() if f["kind"] == "size"})
    assert again.hash == mesh.hash


@pytest.mark.parametrize("dimension", [2, 3])
def test_capsules(make_mesh, dimension):
    mesh = make_mesh(box=[[0] * dimension, [1] * dimension])
    path = np.full((3, dimension), 0.3)
    path[1, 0] = path[2] = 0.7
    mesh.apply(add_sizes={30: dict(path=path, radius=0.05, target=0.1)})
    (capsule,) = mesh.features()
    assert capsule == dict(id=30, kind="size", target=0.1, radius=0.05,
                           path=[tuple(place) for place in path])
    cells = mesh.points[mesh.cells[mesh.cells[:, 0] >= 0]]
    edges = np.linalg.norm(cells - np.roll(cells, 1, axis=1), axis=2).max(axis=1)
    near = (np.abs(cells - path[0]).sum(axis=2) < 0.1).any(axis=1)
    assert near.any() and edges[near].max() <= 0.1 * 2**0.5 * (1 + 1e-9) < edges.max()
    mesh.apply(set_sizes={30: dict(path=capsule["path"][:2], radius=0.05, target=0.1)})
    assert len(mesh.features()[0]["path"]) == 2
    mesh.apply(remove=[30])
    for size, error, words in [
        (dict(path=path[:1], radius=0.1, target=0.1), dynmesh.DynmeshError, "BAD_SIZE"),
        (dict(path=path + 1, radius=0.1, target=0.1), dynmesh.DynmeshError, "OUTSIDE_BOX"),
        (dict(path=path, target=0.1), ValueError, "radius"),
        (dict(path=[(0.5,)], radius=0.1, target=0.1), ValueError, "coordinates"),
    ]:
        with pytest.raises(error, match=words):
            mesh.apply(add_sizes={30: size})


def test_polygons_are_regions(make_mesh):
    mesh = make_mesh()
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2), 3: (0.8, 0.8), 4: (0.2, 0.8)},
               add_polygons={7: [1, 2, 3, 4]})
    inside = mesh.regions == 7
    assert np.isclose(measures(mesh)[inside].sum(), 0.36)
    diff = mesh.apply(remove=[7])
    assert not (mesh.regions == 7).any()
    assert len(diff.patch.relabelled_cells) > 0 and set(diff.patch.former_regions) == {7}


def test_slots_stay(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 101), random.random((100, 2))))
    for step in range(30):
        before = {i: s for s, i in enumerate(mesh.ids) if i != 0}
        cells = {tuple(mesh.ids[c]): s for s, c in enumerate(mesh.cells) if c[0] >= 0}
        diff = mesh.apply(remove=[step + 1], add_points={1000 + step: random.random(2)})
        after = {i: s for s, i in enumerate(mesh.ids) if i != 0}
        cells_after = {tuple(mesh.ids[c]): s for s, c in enumerate(mesh.cells) if c[0] >= 0}
        assert all(after[i] == s for i, s in before.items() if i in after)
        assert all(cells_after[c] == s for c, s in cells.items() if c in cells_after)
        patch = diff.patch
        assert sorted(patch.removed_vertices) == sorted(before[i] for i in before.keys() - after)
        assert sorted(patch.added_vertices) == sorted(after[i] for i in after.keys() - before)
        assert sorted(patch.added_cells) == sorted(
            cells_after[c] for c in cells_after.keys() - cells)
        assert sorted(diff.kept_cells) == sorted(cells[c] for c in cells.keys() & cells_after)
        kept = diff.old_to_new[diff.old_to_new >= 0]
        assert sorted(kept) == sorted(before[i] for i in before.keys() & after)
        assert (diff.new_to_old[patch.added_vertices] == -1).all()


def test_neighbours_and_boundary_faces(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 51), random.random((50, 2))))
    diff = mesh.apply(remove=[7])
    faces = {}
    for slot in np.flatnonzero(mesh.live_cells):
        for k in range(3):
            faces.setdefault(frozenset(np.delete(mesh.cells[slot], k)), []).append((slot, k))
    for sharing in faces.values():
        for slot, k in sharing:
            other = [s for s, _ in sharing if s != slot]
            assert mesh.neighbours[slot, k] == (other[0] if other else -1)
    added = set(diff.patch.added_cells)
    for cell, corner, beyond in diff.patch.boundary_faces:
        assert cell in added and beyond not in added
        assert mesh.neighbours[cell, corner] == beyond
    assert set(diff.patch.neighbours).isdisjoint(added)


def test_views_outlive_growth(random):
    mesh = dynmesh.open([[0, 0], [1, 1]])
    points, cells = mesh.points, mesh.cells
    copy = points.copy()
    mesh.apply(add_points=(np.arange(1, 5001), random.random((5000, 2))))
    assert (points == copy).all() and cells.shape[1] == 3
    with pytest.raises(ValueError, match="read-only"):
        mesh.points[0] = 1


def test_labels(make_mesh):
    mesh = make_mesh()
    diff = mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2)}, add_segments={5: (1, 2)},
                      set_labels={5: dict(marker=-7, name="Wände"), 1: dynmesh.Label(name="a")})
    wall = dynmesh.Label(-7, "Wände")
    assert diff.labels == mesh.labels == {1: dynmesh.Label(0, "a"), 5: wall}
    features = {f["id"]: f for f in mesh.features()}
    assert (features[5]["marker"], features[5]["name"]) == (-7, "Wände")
    assert "marker" not in features[2]
    before = mesh.hash
    diff = mesh.apply(set_labels={1: None, 2: dict(marker=2**63 - 1)})
    assert diff.labels == {1: dynmesh.Label(), 2: dynmesh.Label(2**63 - 1)}
    assert mesh.hash == before and mesh.revision == 2
    assert not len(diff.patch.added_cells) and not len(diff.patch.removed_cells)
    assert mesh.apply(move_points={2: (0.7, 0.3)}).labels == {}
    assert mesh.apply(remove=[5]).labels == {5: dynmesh.Label()}
    assert mesh.labels == {2: dynmesh.Label(2**63 - 1)}
    for bad, error, words in (({1: dict(name="x" * 256)}, dynmesh.DynmeshError, "BAD_LABEL"),
                              ({1: dict(name="a\nb")}, dynmesh.DynmeshError, "BAD_LABEL"),
                              ({77: dict(marker=1)}, dynmesh.DynmeshError, "UNKNOWN_FEATURE"),
                              ({1: dict(mark=1)}, TypeError, "mark"),
                              ([1], TypeError, "set_labels")):
        with pytest.raises(error, match=words):
            mesh.apply(set_labels=bad)
    loaded = make_mesh()
    loaded.load(add_points={1: (0.2, 0.2), 2: (0.8, 0.2)}, set_labels={2: dict(name="b")})
    assert loaded.labels == {2: dynmesh.Label(0, "b")} and loaded.revision == 1
    with pytest.raises((ValueError, dynmesh.DynmeshError)):
        loaded.load(add_points={3: (0.5, 0.5)}, set_labels={4: dict(name="b")})


def test_compact(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 41), random.random((40, 2))))
    mesh.apply(remove=np.arange(1, 21))
    mesh.apply(add_points={99: (0.5, 0.5)})
    compact = mesh.compact()
    assert len(compact.points) == mesh.vertex_count and len(compact.cells) == mesh.cell_count
    assert (compact.points == mesh.points[compact.vertex_slots]).all()
    assert (compact.vertex_slots[compact.cells] == mesh.cells[compact.cell_slots]).all()
    assert (compact.vertex_numbers[compact.vertex_slots] == np.arange(mesh.vertex_count)).all()
    assert (compact.cell_numbers[compact.cell_slots] == np.arange(mesh.cell_count)).all()


def test_locate(make_mesh, random):
    mesh = make_mesh()
    mesh.apply(add_points=(np.arange(1, 41), random.random((40, 2))))
    places = random.random((200, 2))
    slots = mesh.locate(places)
    corners = mesh.points[mesh.cells[slots]]
    for place, (a, b, c) in zip(places, corners):
        lambdas = np.linalg.solve(np.stack([b - a, c - a], axis=1), place - a)
        assert lambdas.min() >= -1e-12 and lambdas.sum() <= 1 + 1e-12
    assert mesh.locate([[1e6, 0]]) == [-1]
    for bad in ([[0, 0, 0]], [[np.nan, 0]]):
        with pytest.raises(ValueError):
            mesh.locate(bad)


def test_meshio(make_mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh = make_mesh()
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2), 3: (0.8, 0.8)},
               add_polygons={7: [1, 2, 3]})
    mesh.to_meshio(point_data={"x": mesh.points[:, 0]}).write(tmp_path / "m.vtu")
    read = meshio.read(tmp_path / "m.vtu")
    assert len(read.cells_dict["triangle"]) == mesh.cell_count
    assert (read.point_data["x"] == read.points[:, 0]).all()
    assert set(read.cell_data["region"][0]) == {0, 7}
    series = dynmesh.Series(tmp_path / "s" / "t.pvd")
    series.add(0.0, mesh)
    series.add(0.5, mesh)
    assert (tmp_path / "s" / "t.pvd").read_text().count("DataSet") == 2
    assert (tmp_path / "s" / "t_00001.vtu").exists()


def test_bad_input_says_what_to_do_and_changes_nothing(make_mesh):
    mesh = make_mesh()
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.8), 3: (0.2, 0.8), 4: (0.8, 0.2)},
               add_segments={10: (1, 2)})
    before = mesh.hash, mesh.revision
    cases = [
        (dict(add_segments={11: (3, 4)}), dynmesh.DynmeshError, "SEGMENTS_CROSS"),
        (dict(add_points={1: (0.3, 0.3)}), dynmesh.DynmeshError, "ID_IN_USE"),
        (dict(remove=[77]), dynmesh.DynmeshError, "UNKNOWN_FEATURE"),
        (dict(add_points={5: (7, 7)}), dynmesh.DynmeshError, "OUTSIDE_BOX"),
        (dict(add_points={5: (np.nan, 0.5)}), dynmesh.DynmeshError, "NOT_FINITE"),
        (dict(add_points={5: (0.5, 0.5, 0.5)}), ValueError, "2 coordinates"),
        (dict(add_points={-5: (0.5, 0.5)}), ValueError, "from 1 to"),
        (dict(add_points={5.5: (0.5, 0.5)}), TypeError, "whole numbers"),
        (dict(add_point={5: (0.5, 0.5)}), TypeError, "there is no edit add_point"),
        (dict(add_points=7), TypeError, "add_points"),
        (dict(add_segments={11: (3,)}), ValueError, "two ends"),
        (dict(add_polygons={12: [1, 2]}), dynmesh.DynmeshError, "BAD_POLYGON"),
        (dict(add_sizes={12: dict(at=(0.5, 0.5))}), ValueError, "target"),
        (dict(add_sizes={12: dict(target=0.1, at=(0.5, 0.5), r=2)}), ValueError, "no r of a size"),
    ]
    for edits, error, words in cases:
        with pytest.raises(error, match=words):
            mesh.apply(**edits)
        assert (mesh.hash, mesh.revision) == before, edits
    with pytest.raises(dynmesh.DynmeshError) as caught:
        mesh.apply(add_points={5: (0.5, 0.9)}, add_segments={11: (3, 4)})
    assert caught.value.reason == "SEGMENTS_CROSS"
    assert set(caught.value.features) == {10, 11} and caught.value.edit == 1
    mesh.apply(validate_only=True, add_points={5: (0.5, 0.9)})
    with pytest.raises(dynmesh.DynmeshError):
        mesh.apply(validate_only=True, add_points={1: (0.5, 0.9)})
    assert (mesh.hash, mesh.revision) == before


def test_bad_options():
    for bad in (dict(rho=0.1), dict(box=[[0, 0], [1]]), dict(box=[[0, 0], [-1, 1]]),
                dict(quality=2), dict(criterion="best"), dict(dimension=4)):
        with pytest.raises((ValueError, dynmesh.DynmeshError)):
            dynmesh.open(**bad)


_MEMORY = """
import resource
import dynmesh

def leave(bytes):
    with open("/proc/self/statm") as sizes:
        space = int(sizes.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (space + bytes, resource.RLIM_INFINITY))

def refused(target):
    try:
        mesh.apply(add_sizes={2: dict(low=(0, 0), high=(1, 1), target=target)})
    except dynmesh.LimitExceeded as error:
        assert mesh.hash == before
        return str(error)
    raise AssertionError("it fits")

mesh = dynmesh.open([[0, 0], [1, 1]], max_vertices=50_000_000)
mesh.apply(add_points={1: (0.5, 0.5)})
before = mesh.hash
leave(700_000_000)
reason = refused(0.001)
if "memory ran out" in reason:  # by an array that doubles; the mesh can be read
    try:
        mesh.apply(add_points={3: (0.25, 0.5)})
    except dynmesh.DataLoss:
        raise SystemExit
    raise AssertionError("the mesh goes on")
assert " GB of memory while it is made" in reason, reason
mesh.apply(add_points={3: (0.25, 0.5)})
"""


def test_a_batch_that_does_not_fit_into_the_memory_is_an_error():
    subprocess.run([sys.executable, "-B", "-c", _MEMORY], check=True)


def part_content(part):
    """Cells and facets of a part by slots, in an order of their own."""
    slots = part.vertex_slots
    cells = np.column_stack([np.sort(slots[part.cells], axis=1), part.cell_slots])
    facets = np.column_stack([np.sort(slots[part.facets], axis=1), part.facet_owners])
    return sorted(map(tuple, cells)), sorted(map(tuple, facets)), sorted(slots)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_part_follows_its_mesh(make_mesh, dimension):
    """A square, in 3D a box, with a hole; points come and go in and around it."""
    mesh = make_mesh(box=[[0] * dimension, [1] * dimension])

    def box(first, lo, hi):
        corners = {first + i: [hi if i >> k & 1 else lo for k in range(dimension)]
                   for i in range(2**dimension)}
        rings = ([[0, 1, 3, 2]] if dimension == 2 else
                 [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]])
        faces = {first + 10 + i: [first + c for c in ring] for i, ring in enumerate(rings)}
        return dict(add_points=corners, add_polygons=faces)

    mesh.apply(**box(100, 0.1, 0.9), set_labels={110: dynmesh.Label(7, "plate")})
    mesh.apply(**box(200, 0.4, 0.6), set_labels={210: dynmesh.Label(8, "hole")})
    with pytest.raises(dynmesh.NotFound, match="no feature has the name 'plat'; names are: hole, plate"):
        mesh.part(names="plat")
    with pytest.raises(dynmesh.InvalidArgument, match="ids of polygons are integers"):
        mesh.part(polygons="plate")
    whole, plate, named = mesh.part(), mesh.part(polygons=110, without=[210]), mesh.part(names="hole")
    random = np.random.default_rng(3)
    old = plate.points
    kept = old.copy()
    for i in range(24):
        if i % 2 == 0:
            diff = mesh.apply(add_points={1000 + i + k: random.random(dimension) for k in range(2)})
        else:
            diff = mesh.apply(move_points={999 + i: random.random(dimension)})
        for part in (whole, plate, named):
            part.update(diff)
            assert part.revision == mesh.revision
        assert part_content(plate) == part_content(mesh.part(polygons=[110], without=210))
    assert part_content(whole) == part_content(mesh.part(inside=True))
    np.testing.assert_array_equal(old, kept)
    corners = plate.points[plate.cells]
    edges = corners[:, 1:] - corners[:, :1]
    factor = {2: 2, 3: 6}[dimension]
    volumes = np.linalg.det(edges) / factor
    assert volumes.min() > 0
    np.testing.assert_allclose(volumes.sum(), 0.8**dimension - 0.2**dimension)
    np.testing.assert_array_equal(plate.vertex_numbers[plate.vertex_slots],
                                  np.arange(len(plate.points)))
    np.testing.assert_array_equal(plate.cell_numbers[plate.cell_slots], np.arange(len(plate.cells)))
    np.testing.assert_array_equal(mesh.points[plate.vertex_slots], plate.points)
    # The border is closed: outward normals times areas add up to zero, and enclose the volume.
    border = plate.points[plate.facets[plate.is_border]]
    if dimension == 2:
        along = border[:, 1] - border[:, 0]
        normals = np.column_stack([along[:, 1], -along[:, 0]])
    else:
        normals = np.cross(border[:, 1] - border[:, 0], border[:, 2] - border[:, 0]) / 2
    np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-12)
    enclosed = np.einsum("ij,ij->", normals, border.mean(axis=1)) / dimension
    np.testing.assert_allclose(enclosed, volumes.sum())
    assert set(plate.facet_markers[plate.is_border]) >= ({7, 8} if dimension == 2 else {0, 7, 8})
    assert set(named.facet_names[named.is_border]) >= {"hole"}
    beside = plate.facet_cells
    assert beside.shape == (len(plate.facets), 2) and beside[:, 0].min() >= 0
    assert ((beside[:, 1] < 0) == plate.is_border).all()
    # One that is behind is made anew; a diff that is over is refused.
    behind = mesh.part()
    mesh.apply(add_points={5000: random.random(dimension)})
    late = mesh.apply(add_points={5001: random.random(dimension)})
    behind.update(late)
    assert part_content(behind) == part_content(mesh.part())
    stale = mesh.apply(add_points={5002: random.random(dimension)})
    mesh.apply(add_points={5003: random.random(dimension)})
    with pytest.raises(dynmesh.StaleDiff):
        behind.update(stale)
    behind.update()
    assert part_content(behind) == part_content(mesh.part())
    assert "vertices" in repr(behind)


def test_a_mesh_and_a_part_are_written(make_mesh, tmp_path):
    """As the command writes: what it reads again is the same; the part is what the outline encloses."""
    meshio = pytest.importorskip("meshio")
    mesh = make_mesh()
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2), 3: (0.8, 0.8), 4: (0.5, 0.3), 5: (0.7, 0.5)},
               add_polygons={7: [1, 2, 3]}, add_segments={8: (4, 5)},
               set_labels={7: dynmesh.Label(3, "plate"), 8: dynmesh.Label(5, "crack")})
    part = mesh.part(names="plate")
    mesh.write(tmp_path / "whole.node")
    part.write(tmp_path / "part.node", from_zero=True)
    part.write(tmp_path / "part.msh")
    part.write(tmp_path / "part2.msh", order=2)
    part.write(tmp_path / "part.vtu")
    assert (tmp_path / "whole.ele").read_text().split()[0] == str(mesh.cell_count)
    assert (tmp_path / "part.ele").read_text().split()[0] == str(len(part.cells))
    assert "part" in (tmp_path / "part.node").read_text()
    gmsh = meshio.read(tmp_path / "part.msh")
    assert len(gmsh.cells_dict["triangle"]) == len(part.cells)
    assert {"plate", "crack"} <= set(gmsh.field_data)
    part.write(tmp_path / "old.msh", msh_version=2.2)
    assert (tmp_path / "old.msh").read_text().startswith("$MeshFormat\n2.2 0 8\n")
    old = meshio.read(tmp_path / "old.msh")
    assert set(old.field_data) == set(gmsh.field_data)
    assert len(old.cells_dict["line"]) == len(gmsh.cells_dict["line"])
    with pytest.raises(dynmesh.InvalidArgument, match="msh_version is 4.1 or 2.2, found 3"):
        part.write(tmp_path / "old.msh", msh_version=3)
    assert "triangle6" in meshio.read(tmp_path / "part2.msh").cells_dict
    with pytest.raises(dynmesh.InvalidArgument, match="part.xyz"):
        part.write(tmp_path / "part.xyz")
    # For meshio, with values of the part.
    out = part.to_meshio({"x": part.points[:, 0]}, {"cell": np.arange(len(part.cells))})
    assert out.points.shape[1] == 2
    assert [block.type for block in out.cells] == ["triangle", "line"]
    assert set(out.cell_sets) == {"plate", "plate edges", "crack"}
    crack = part.facets[out.cell_sets["crack"][1]]
    np.testing.assert_allclose(np.linalg.norm(
        part.points[crack[:, 1]] - part.points[crack[:, 0]], axis=1).sum(), np.hypot(0.2, 0.2))
    assert set(out.cell_data["marker"][1]) == {3, 5}
    with pytest.raises(dynmesh.InvalidArgument, match="part.vertex_slots"):
        part.to_meshio({"x": mesh.points[:, 0]})
    mesh.apply(add_points={50: (0.6, 0.45)})
    with pytest.raises(dynmesh.FailedPrecondition, match="update the part first"):
        part.write(tmp_path / "part.vtu")


def test_a_part_is_written_for_solvers(make_mesh, tmp_path):
    """meshio reads the cells, and the sets by the names of features."""
    meshio = pytest.importorskip("meshio")
    mesh = make_mesh()
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2), 3: (0.8, 0.8)}, add_polygons={7: [1, 2, 3]},
               set_labels={7: dynmesh.Label(3, "thin plate")})
    part = mesh.part(polygons=7)
    border = {frozenset(edge) for edge in part.facets.tolist()}
    for name in ("part.inp", "part.su2"):
        part.write(tmp_path / name)
        read = meshio.read(tmp_path / name)
        assert len(read.cells_dict["triangle"]) == len(part.cells)
        assert len(read.points) == len(part.points)
    abaqus, su2 = meshio.read(tmp_path / "part.inp"), meshio.read(tmp_path / "part.su2")
    assert set(abaqus.cell_sets) == {"thin_plate"}
    assert set(abaqus.point_sets) == {"thin_plate_edges"}
    assert len(abaqus.point_sets["thin_plate_edges"]) == len({v for edge in border for v in edge})
    assert len(su2.cells_dict["line"]) == len(border)
    with pytest.raises(dynmesh.InvalidArgument, match="order 2 is for"):
        part.write(tmp_path / "part.su2", order=2)
