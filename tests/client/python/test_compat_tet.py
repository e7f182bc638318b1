"""The interfaces of `meshpy.tet` and of PyVista's `tetgen`: what their documents promise."""
import math
import types

import numpy as np
import pytest

import compat_checks as checks
import dynmesh
from compat_inputs import NESTED, TOWER
from dynmesh.compat import Unsupported, tetgen
from dynmesh.compat.meshpy.tet import MeshInfo, Options, build


def info_of(body, markers=None):
    info = MeshInfo()
    info.set_points(body[0])
    info.set_facets(body[1], markers)
    return info


def check(given, mesh_points, cells, volume):
    points = np.array(mesh_points)
    assert (points[:len(given)] == np.asarray(given, float)).all()
    sizes = checks.measures(points, cells)
    assert (sizes > 0).all()
    assert math.isclose(sizes.sum(), volume, rel_tol=1e-9)
    return sizes


def is_in_box(places, low, high):
    return ((places > low) & (places < high)).all(axis=1)


@pytest.mark.parametrize("switches, kwargs, ratio, largest, angle", [
    ("pq", {}, 2, np.inf, 10), ("pq1.4", {}, 1.4, np.inf, 10), ("pq1.5/15", {}, 1.5, np.inf, 15),
    ("pq2a0.5", {}, 2, 0.5, 10), ("pq", dict(max_volume=0.5), 2, 0.5, 10),
    ("pqa0.1QVCzO2/3T1e-6", {}, 2, 0.1, 10), ("-pq", dict(verbose=True), 2, np.inf, 10)])
def test_the_tower_of_the_documents(switches, kwargs, ratio, largest, angle):
    mesh = build(info_of(TOWER), Options(switches), **kwargs)
    sizes = check(TOWER[0], mesh.points, mesh.elements, 48)
    assert sizes.max() <= largest * (1 + 1e-9)
    assert checks.radius_edge(mesh.points, mesh.elements).max() <= ratio * (1 + 1e-9)
    assert checks.dihedral_angles(mesh.points, mesh.elements).min() > angle - 1e-6
    assert all(len(row) == 3 for row in checks.border(mesh.elements))


def test_tetrahedra_are_not_much_smaller_than_they_may_be():
    mesh = build(info_of(TOWER), max_volume=0.02)
    assert 0.33 < 48 / 0.02 / len(mesh.elements) <= 1


def test_options_are_members_too():
    options = Options("pq", maxvolume=0.5, minratio=1.8)
    mesh = build(info_of(TOWER), options)
    assert check(TOWER[0], mesh.points, mesh.elements, 48).max() <= 0.5
    options.maxvolume = 2.0
    assert len(build(info_of(TOWER), options).elements) < len(mesh.elements)


def test_faces_have_the_markers_of_facets():
    mesh = build(info_of(TOWER, markers=[1, 2, 3, 4, 5, 6]), max_volume=2)
    points = np.array(mesh.points)
    faces = mesh.face_vertex_indices_to_face_marker
    assert set(faces) == checks.border(mesh.elements)
    for face, marker in faces.items():
        ring = np.array(TOWER[0], float)[list(TOWER[1][marker - 1])]
        normal = np.cross(ring[1] - ring[0], ring[2] - ring[0])
        assert np.abs((points[list(face)] - ring[0]) @ normal).max() < 1e-9
    on_border = {vertex for face in faces for vertex in face}
    for vertex, marker in enumerate(mesh.point_markers):
        assert (marker != 0) == (vertex in on_border)
    assert set(build(info_of(NESTED)).face_markers) == {1}
    assert set(build(info_of(NESTED, markers=[0] * 6 + [4] * 6)).face_markers) == {0, 4}


@pytest.mark.parametrize("switches", ["pqA", "pqAa", "pqAa0.2"])
def test_holes_and_regions(switches):
    info = info_of(NESTED)
    info.regions.resize(1)
    info.regions[0] = [1.5, 1.5, 1.5, 7, 0.05]
    mesh = build(info, Options(switches))
    sizes = check(NESTED[0], mesh.points, mesh.elements, 27)
    inner = is_in_box(np.array(mesh.points)[np.array(mesh.elements)].mean(axis=1), 1, 2)
    assert math.isclose(sizes[inner].sum(), 1, rel_tol=1e-9)
    assert (np.array(mesh.element_attributes) == np.where(inner, 7, 8)).all()
    if "a" in switches:
        assert "a0.2" in switches or sizes[inner].max() <= 0.05 * (1 + 1e-9)
        assert "a0.2" not in switches or sizes.max() <= 0.2 * (1 + 1e-9)
    info.set_holes([(1.5, 1.5, 1.5)])
    mesh = build(info, attributes=True)
    check(NESTED[0], mesh.points, mesh.elements, 26)
    assert set(mesh.element_attributes) == {8}
    assert len(checks.border(mesh.elements)) == len(mesh.faces)


def test_volumes_of_regions_count_on_request():
    info = info_of(NESTED)
    info.regions.resize(1)
    info.regions[0] = [1.5, 1.5, 1.5, 7, 0.01]
    fine = build(info, volume_constraints=True, max_volume=1)
    sizes = check(NESTED[0], fine.points, fine.elements, 27)
    inner = is_in_box(np.array(fine.points)[np.array(fine.elements)].mean(axis=1), 1, 2)
    assert sizes[inner].max() <= 0.01 * (1 + 1e-9) and 0.05 < sizes[~inner].max() <= 1


def test_facets_have_holes():
    """A frame: a box with a square channel from the bottom to the top."""
    outer, faces = checks.box_of((0, 0, 0), (3, 3, 1))
    inner, walls = checks.box_of((1, 1, 0), (2, 2, 1), 8)
    info = MeshInfo()
    info.set_points([*outer, *inner])
    facets = [[faces[0], walls[0]], [faces[1], walls[1]]] + [[f] for f in faces[2:] + walls[2:]]
    places = [[(1.5, 1.5, 0)], [(1.5, 1.5, 1)]] + [[]] * 8
    info.set_facets_ex(facets, places)
    info.set_holes([(1.5, 1.5, 0.5)])
    mesh = build(info)
    check([*outer, *inner], mesh.points, mesh.elements, 8)
    info.set_facets_ex(facets)
    with pytest.raises(Unsupported, match="2 polygons and 0 holes"):
        build(info)
    info.set_facets_ex([*facets[:2], [faces[2], (0, 5)], *facets[3:]], places)
    with pytest.raises(Unsupported, match="facet 2 has a polygon of two vertices"):
        build(info)


def cube_of(n):
    """The surface of a cube, of 12 n² triangles."""
    points, faces = {}, []
    for axis in range(3):
        for side in (0, 1):
            for i in range(n):
                for j in range(n):
                    ring = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        place = [0.0] * 3
                        place[axis] = float(side)
                        place[(axis + 1) % 3], place[(axis + 2) % 3] = (i + di) / n, (j + dj) / n
                        ring.append(points.setdefault(tuple(place), len(points)))
                    ring = ring if side else ring[::-1]
                    faces += [(ring[0], ring[1], ring[2]), (ring[0], ring[2], ring[3])]
    return np.array(list(points)), np.array(faces)


@pytest.mark.parametrize("n", [1, 3])
def test_faces_in_one_plane_are_joined(n):
    points, faces = cube_of(n)
    joined, kept = build(info_of((points, faces))), build(info_of((points, faces)), Options("pqM"))
    for mesh in (joined, kept):
        check(points, mesh.points, mesh.elements, 1)
        assert np.setdiff1d(np.arange(len(points)), np.array(mesh.faces)).size == 0
    assert len(joined.points) < len(kept.points)
    # Faces of different markers stay apart.
    marked = build(info_of((points, faces), markers=np.arange(1, len(faces) + 1)))
    assert set(marked.face_markers) == set(range(1, len(faces) + 1))
    assert len(marked.points) == len(kept.points)


def test_points_edges_neighbours_and_ten_nodes():
    more = MeshInfo()
    more.set_points([(1, 1, 6), (1, 1, 3)])
    mesh = build(info_of(TOWER), Options("pqeni"), insert_points=more)
    assert mesh.points[8] == [1, 1, 6] and {8, 9} <= set(np.array(mesh.elements).ravel().tolist())
    assert {frozenset(row) for row in mesh.edges} == checks.edges(mesh.elements)
    assert (np.array(mesh.neighbors) == checks.neighbours(mesh.elements)).all()
    mesh = build(info_of(TOWER), Options("pqo2"))
    points, cells = np.array(mesh.points), np.array(mesh.elements)
    assert cells.shape[1] == 10
    for node, pair in enumerate(((2, 3), (0, 3), (0, 1), (1, 2), (1, 3), (0, 2)), 4):
        assert np.allclose(points[cells[:, node]], points[cells[:, pair]].mean(axis=1))


def test_a_vtk_is_written(tmp_path):
    mesh = build(info_of(TOWER))
    ten = build(info_of(TOWER), Options("pqo2"))
    ten.write_vtk(tmp_path / "ten.vtk")
    lines = (tmp_path / "ten.vtk").read_text().splitlines()
    nodes = np.array(lines[-2 - len(ten.elements)].split()[1:], int)
    places = np.array(ten.points)[nodes]
    assert np.allclose(places[4], places[:2].mean(axis=0)) and np.allclose(
        places[9], places[2:4].mean(axis=0))
    mesh.write_vtk(tmp_path / "mesh.vtk")
    lines = (tmp_path / "mesh.vtk").read_text().splitlines()
    at = lines.index(f"POINTS {len(mesh.points)} double")
    assert np.loadtxt(lines[at + 1:at + 1 + len(mesh.points)]).tolist() == list(mesh.points)
    at += 2 + len(mesh.points)
    assert np.loadtxt(lines[at:at + len(mesh.elements)], dtype=int)[:, 1:].tolist() == list(mesh.elements)


@pytest.mark.parametrize("switches, error, text", [
    ("p", Unsupported, "use the switches pq"), ("q", Unsupported, "use the switches pq"),
    ("pq1.2/10", Unsupported, "minratio: .* is 1.2, and dynmesh keeps 1.4"),
    ("pq1.5/25", Unsupported, "mindihedral: .* is 25"), ("pqY", Unsupported, "the switch Y"),
    ("pqr", Unsupported, "the switch r"), ("pqd", Unsupported, "the switch d.*read_surface"),
    ("pqc", Unsupported, "the switch c"), ("pqv", Unsupported, "the switch v"),
    ("pqa0", ValueError, "above 0"), ("pqo3", ValueError, "o2"), ("pqU", ValueError, "no switch 'U'"),
    ("pqS2a0.5", Unsupported, "S: the mesh needs .* new vertices")])
def test_switches_that_are_refused_are_named(switches, error, text):
    with pytest.raises(error, match=text):
        build(info_of(TOWER), Options(switches))
    with pytest.raises(error, match=text):
        tetgen.TetGen(*TOWER).tetrahedralize(switches=switches)


@pytest.mark.parametrize("act, error, text", [
    (lambda: build(info_of((TOWER[0], TOWER[1][:5]))), ValueError, "nothing is left"),
    (lambda: build(info_of((TOWER[0], [(0, 1, 8)]))), ValueError, "facet 0 has vertex 8"),
    (lambda: build(info_of((TOWER[0], [(0, 1)]))), ValueError, "facet 0 has no polygon"),
    (lambda: build(info_of((TOWER[0], []))), ValueError, "a mesh is between facets"),
    (lambda: build(info_of(([*TOWER[0], (1, 1, 0)], TOWER[1]))), dynmesh.FailedPrecondition,
     "POINT_ON_POLYGON.*make it a corner"),
    (lambda: build(info_of(TOWER), diagnose=True), Unsupported, "diagnose"),
    (lambda: build(info_of(TOWER), max_volume=-1), ValueError, "max_volume"),
    (lambda: build(info_of((TOWER[0], [*TOWER[1], (0, 1, 6)]))), dynmesh.DynmeshError, "read_surface"),
    (lambda: Options("pq", nobisect=True), Unsupported, "nobisect"),
    (lambda: Options("pq", size=1), AttributeError, "no member 'size'"),
    (lambda: Options(5), TypeError, "switches")])
def test_what_is_refused_is_named(act, error, text):
    with pytest.raises(error, match=text):
        act()


def test_values_of_points_are_refused():
    info = info_of(TOWER)
    info.point_attributes.setup()
    with pytest.raises(Unsupported, match="point_attributes"):
        build(info)


def ball(n):
    """A surface of triangles: that of a cube, put on a sphere."""
    points, faces = cube_of(n)
    points = points - 0.5
    return points / np.linalg.norm(points, axis=1, keepdims=True), faces


def volume_of(points, faces):
    return np.linalg.det(points[faces]).sum() / 6


def test_a_sphere_as_in_the_documents():
    points, faces = ball(3)
    tet = tetgen.TetGen(points, faces)
    assert (tet.v == points).all() and (tet.f == faces).all() and tet.node is None
    nodes, elements = tet.tetrahedralize(order=1, mindihedral=12, minratio=1.5)
    assert nodes is tet.node and elements is tet.elem and elements.dtype == np.int32
    check(points, nodes, elements, volume_of(points, faces))
    assert {frozenset(row) for row in tet.trifaces.tolist()} == checks.border(elements)
    assert (tet.triface_markers == 1).all()


def test_surfaces_of_pyvista_have_points_and_faces():
    points, faces = cube_of(2)
    flat = np.concatenate([np.full((len(faces), 1), 3), faces], axis=1).reshape(-1)
    tet = tetgen.TetGen(types.SimpleNamespace(points=points.astype(np.float32), faces=flat))
    nodes, elements = tet.tetrahedralize(maxvolume=0.01, quiet=True, nomergefacet=True)
    assert check(points, nodes, elements, 1).max() <= 0.01 * (1 + 1e-9)
    assert (tet.f == faces).all()
    corners, rings = checks.box_of((0, 0, 0), (1, 2, 3))
    flat = np.concatenate([[4, *ring] for ring in rings])
    tet = tetgen.TetGen(types.SimpleNamespace(points=np.array(corners), faces=flat))
    check(corners, *tet.tetrahedralize(), 6)
    assert tet.f is None
    with pytest.raises(ValueError, match="number of corners before"):
        tetgen.TetGen(types.SimpleNamespace(points=np.array(corners), faces=flat[:-1]))


@pytest.mark.parametrize("kwargs", [dict(), dict(switches="pq1.5/10Aa")])
def test_regions_and_holes_of_tetgen(kwargs):
    tet = tetgen.TetGen(*NESTED)
    tet.add_region(3, (1.5, 1.5, 1.5), 0.05)
    tet.add_region(2, (0.5, 0.5, 0.5))
    nodes, elements, attributes = tet.tetrahedralize(**(kwargs or dict(regionattrib=True)))
    sizes = check(NESTED[0], nodes, elements, 27)
    inner = is_in_box(nodes[elements].mean(axis=1), 1, 2)
    assert attributes is tet.attributes and attributes.shape == (len(elements), 1)
    assert (attributes[:, 0] == np.where(inner, 3, 2)).all()
    assert sizes[inner].max() <= 0.05 * (1 + 1e-9)
    tet = tetgen.TetGen(*NESTED)
    tet.add_hole([1.5, 1.5, 1.5])
    check(NESTED[0], *tet.tetrahedralize(), 26)


def test_faces_have_the_numbers_that_they_are_given():
    tet = tetgen.TetGen(TOWER[0], TOWER[1], [1, 2, 3, 4, 5, 6])
    tet.tetrahedralize()
    assert set(tet.triface_markers) == {1, 2, 3, 4, 5, 6}
    bottom = tet.trifaces[tet.triface_markers == 1]
    assert (tet.node[bottom][:, :, 2] == 0).all()


def test_ten_nodes_and_files_of_tetgen(tmp_path):
    tet = tetgen.TetGen(*TOWER)
    for act in (lambda: tet.grid, lambda: tet.write(tmp_path / "t.vtk")):
        with pytest.raises(RuntimeError, match="tetrahedralize"):
            act()
    nodes, elements = tet.tetrahedralize(order=2)
    assert elements.shape[1] == 10
    assert np.allclose(nodes[elements[:, 8]], nodes[elements[:, [1, 3]]].mean(axis=1))
    tet.write(tmp_path / "t.vtk")
    assert f"CELL_TYPES {len(elements)}\n24\n" in (tmp_path / "t.vtk").read_text()
    with pytest.raises(Unsupported, match="binary"):
        tet.write(tmp_path / "t.vtk", binary=True)


def test_the_grid_is_made_by_pyvista(monkeypatch):
    made = []
    fake = types.ModuleType("pyvista")
    fake.UnstructuredGrid = lambda *arrays: made.append(arrays) or "grid"
    monkeypatch.setitem(__import__("sys").modules, "pyvista", fake)
    tet = tetgen.TetGen(*TOWER)
    nodes, elements = tet.tetrahedralize()
    assert tet.grid == "grid"
    fake.UnstructuredGrid = lambda *arrays: types.SimpleNamespace(plot=lambda **kwargs: kwargs)
    assert tet.plot(show_edges=True) == {"show_edges": True}
    cells, kinds, points = made[0]
    assert (cells.reshape(-1, 5)[:, 1:] == elements).all() and (cells[::5] == 4).all()
    assert (kinds == 10).all() and points is nodes


def test_files_are_mended_as_they_are_read(tmp_path):
    points, faces = cube_of(2)
    path = tmp_path / "cube.off"
    path.write_text("\n".join(["OFF", f"{len(points)} {len(faces)} 0",
                               *[" ".join(map(repr, p)) for p in points.tolist()],
                               *["3 " + " ".join(map(str, f)) for f in faces.tolist()]]) + "\n")
    tet = tetgen.TetGen(str(path))
    nodes, elements = tet.tetrahedralize()
    assert math.isclose(checks.measures(nodes, elements).sum(), 1, rel_tol=1e-9)


@pytest.mark.parametrize("kwargs, error, text", [
    (dict(nobisect=True), Unsupported, "nobisect"), (dict(refine=True), Unsupported, "refine"),
    (dict(convex=True), Unsupported, "convex"), (dict(plc=False), Unsupported, "plc, quality"),
    (dict(quality=False), Unsupported, "plc, quality"), (dict(minratio=1.1), Unsupported, "minratio"),
    (dict(mindihedral=30), Unsupported, "mindihedral"), (dict(order=3), ValueError, "order"),
    (dict(steinerleft=0, maxvolume=0.1), Unsupported, "the switch S"),
    (dict(cubes=1), TypeError, "no argument 'cubes'")])
def test_arguments_that_are_refused_are_named(kwargs, error, text):
    with pytest.raises(error, match=text):
        tetgen.TetGen(*TOWER).tetrahedralize(**kwargs)


@pytest.mark.parametrize("args, error, text", [
    ((), TypeError, "got nothing"), ((5,), TypeError, "got int"),
    (([(0, 0, 0)], [(0, 1, 2)]), ValueError, "vertices are 0 to 0"),
    (([(0, 0)], [(0, 1, 2)]), ValueError, r"shape \(n, 3\)"),
    ((*TOWER, [1, 2]), ValueError, "face markers"),
    ((TOWER[0], [(0, 1)]), ValueError, "face 0 has fewer")])
def test_surfaces_that_cannot_be_meant(args, error, text):
    with pytest.raises(error, match=text):
        tetgen.TetGen(*args)


def test_a_surface_that_needs_mending_says_where():
    with pytest.raises(Unsupported, match="read_surface"):
        tetgen.TetGen(*TOWER).make_manifold()
    points, faces = cube_of(1)
    with pytest.raises(dynmesh.DynmeshError, match="read_surface"):
        tetgen.TetGen([*points, (0.5, 0.5, 2)], [*faces, (0, 3, 8)]).tetrahedralize()
