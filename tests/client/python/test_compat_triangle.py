"""The interface of the package `triangle`: what its documents promise, by independent checks."""
import math

import numpy as np
import pytest

import compat_checks as checks
import dynmesh
import dynmesh.compat.triangle as tr
from compat_inputs import AREAS, BOX, ELL, HALVES, SQUARE, area_of, ring_of
from dynmesh.compat import Unsupported


def check(tri, mesh, opts=""):
    """What holds of every mesh of a graph."""
    points, triangles = mesh["vertices"], mesh["triangles"]
    given = np.asarray(tri["vertices"], float)
    assert points.dtype == np.float64 and triangles.dtype == np.int32
    assert (points[:len(given)] == given).all()
    assert (checks.measures(points, triangles) > 0).all()
    assert set(np.unique(triangles)) >= set(range(len(given), len(points)))
    if "p" in opts:
        checks.check_follows(points, triangles, given, tri["segments"])
        checks.check_delaunay(points, triangles)
    assert mesh["vertex_markers"].shape == (len(points), 1)


@pytest.mark.parametrize("name", AREAS)
@pytest.mark.parametrize("opts, least, largest", [
    ("pq", 20, None), ("pq10", 10, None), ("pq25", 25, None), ("pq30", 30, None), ("pq0", 0, None),
    ("pqa0.05", 20, 0.05), ("pq30a0.01", 30, 0.01), ("pa0.02", 20.7, 0.02), ("pqD", 20, None),
    ("pD", 20.7, None), ("ps", 20.7, None), ("zpqQVXiFlCI", 20, None)])
def test_angles_areas_and_segments(name, opts, least, largest):
    tri, area = AREAS[name]
    mesh = tr.triangulate(tri, opts)
    check(tri, mesh, opts)
    points, triangles = mesh["vertices"], mesh["triangles"]
    areas = checks.measures(points, triangles)
    assert math.isclose(areas.sum(), area, rel_tol=1e-9)
    if largest is not None:
        assert areas.max() <= largest * (1 + 1e-9)
    angles = checks.angles(points, triangles)
    if name == "face":  # the mouth's corners are sharper than the bound
        ends = np.isin(triangles, [28, 29, 30, 31]).any(axis=1)
        assert angles[~ends].min() > least - 0.01
    else:
        assert angles.min() > least - 0.01


def test_opts_of_the_documents_count_nothing_twice():
    one, two = tr.triangulate(BOX, "pqa0.1"), tr.triangulate(BOX, "-qpa0.1")
    for key, value in one.items():
        assert (value == two[key]).all()


@pytest.mark.parametrize("opts", ["qa0.02", "q", "a0.1", "qe", "cqn"])
def test_points_alone_have_the_convex_hull(opts):
    random = np.random.default_rng(3)
    points = np.concatenate([random.random((30, 2)), [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0)]])
    tri = dict(vertices=points, segments=[(0, 1)], holes=[(0.5, 0.5)])  # only p reads these
    mesh = tr.triangulate(tri, opts)
    check(tri, mesh)
    assert math.isclose(checks.measures(mesh["vertices"], mesh["triangles"]).sum(), 1, rel_tol=1e-9)
    assert checks.angles(mesh["vertices"], mesh["triangles"]).min() > 19.99
    assert ("segments" in mesh) == ("c" in opts)


def test_the_hull_of_an_open_graph_is_enclosed():
    tri = dict(vertices=[*ELL["vertices"]], segments=ELL["segments"])
    mesh = tr.triangulate(tri, "pcqa0.1")
    check(tri, mesh, "p")
    assert math.isclose(checks.measures(mesh["vertices"], mesh["triangles"]).sum(), 3.5, rel_tol=1e-9)
    _, covered = checks.parts_of(mesh["vertices"], mesh["segments"].tolist(), (2, 1), (1, 2))
    assert math.isclose(covered, math.sqrt(2), rel_tol=1e-9)
    with pytest.raises(ValueError, match="enclose nothing"):
        tr.triangulate(dict(vertices=tri["vertices"], segments=[(0, 1), (1, 2)]), "pq")


def test_markers_are_those_of_segments_and_of_the_border():
    mesh = tr.triangulate(BOX, "pqea0.1")
    points = mesh["vertices"]
    for (a, b), marker in zip(BOX["segments"], BOX["segment_markers"]):
        begin, end = np.take(BOX["vertices"], (a, b), axis=0)
        for what in ("segment", "edge"):
            pairs = mesh[what + "s"].tolist()
            on, covered = checks.parts_of(points, pairs, begin, end)
            assert math.isclose(covered, np.linalg.norm(end - begin), rel_tol=1e-9)
            rows = [pairs.index(pair) for pair in on]
            assert (mesh[what + "_markers"][rows, 0] == marker).all()
            inner = np.setdiff1d(np.unique(on), [a, b])
            assert (mesh["vertex_markers"][inner, 0] == marker).all()
    assert mesh["vertex_markers"][:8, 0].tolist() == BOX["vertex_markers"]
    border = checks.border(mesh["triangles"])
    assert border == {frozenset(row) for row in mesh["segments"].tolist()}
    for pair, marker in zip(mesh["edges"].tolist(), mesh["edge_markers"][:, 0]):
        assert (marker != 0) == (frozenset(pair) in border)


def test_without_markers_the_border_has_one():
    mesh = tr.triangulate(ELL, "pqe")
    border = checks.border(mesh["triangles"])
    crack = {frozenset(p) for p in checks.parts_of(mesh["vertices"], mesh["edges"].tolist(),
                                                   (0.4, 0.5), (0.8, 0.5))[0]}
    assert not border & crack
    for pair, marker in zip(mesh["edges"].tolist(), mesh["edge_markers"][:, 0]):
        assert marker == (frozenset(pair) in border)
    on_border = set().union(*border)
    for vertex, marker in enumerate(mesh["vertex_markers"][:, 0]):
        assert marker == (vertex in on_border)
    segments = {frozenset(p) for p in mesh["segments"].tolist()}
    assert segments == border | crack
    assert mesh["segment_markers"].sum() == len(border)


@pytest.mark.parametrize("name", ["box", "ell", "face"])
def test_edges_and_neighbours(name):
    mesh = tr.triangulate(AREAS[name][0], "pq28en")
    assert {frozenset(row) for row in mesh["edges"].tolist()} == checks.edges(mesh["triangles"])
    assert len(mesh["edges"]) == len(checks.edges(mesh["triangles"]))
    assert (mesh["neighbors"] == checks.neighbours(mesh["triangles"])).all()


@pytest.mark.parametrize("opts", ["pqaA", "pqAa0.01a", "pqAa", "pAa"])
def test_regions_have_attributes_and_areas(opts):
    mesh = tr.triangulate(HALVES, opts)
    check(HALVES, mesh, opts)
    centres = mesh["vertices"][mesh["triangles"]].mean(axis=1)
    left = centres[:, 0] < 1
    assert (mesh["triangle_attributes"][left] == 7).all()
    assert (mesh["triangle_attributes"][~left] == -2.5).all()
    areas = checks.measures(mesh["vertices"], mesh["triangles"])
    assert areas[left].max() <= (0.01 if "0.01" in opts else 0.02) * (1 + 1e-9)
    assert areas[~left].max() <= 0.002 * (1 + 1e-9)
    # The left half is not as fine as the right one.
    assert np.count_nonzero(~left) > 2 * np.count_nonzero(left)


def test_regions_are_bounded_by_segments_and_may_lack_an_area():
    """A ring in a box, the hole inside a region; no region has the attribute 0."""
    tri = dict(BOX, holes=None, regions=[(0.5, 0.5, 3, -1), (1.5, 1.5, 4, 0.01)])
    del tri["holes"]
    mesh = tr.triangulate(tri, "pqaA")
    centres = mesh["vertices"][mesh["triangles"]].mean(axis=1)
    inner = checks.is_inside([(1, 1), (2, 1), (2, 2), (1, 2)], centres)
    assert (mesh["triangle_attributes"][:, 0] == np.where(inner, 4, 3)).all()
    areas = checks.measures(mesh["vertices"], mesh["triangles"])
    assert areas[inner].max() <= 0.01 and areas[~inner].max() > 0.02
    tri["regions"] = [(1.5, 1.5, 4)]
    mesh = tr.triangulate(tri, "pqA")
    inner = checks.is_inside([(1, 1), (2, 1), (2, 2), (1, 2)],
                             mesh["vertices"][mesh["triangles"]].mean(axis=1))
    assert (mesh["triangle_attributes"][:, 0] == np.where(inner, 4, 0)).all()


def test_a_region_around_a_hole_that_touches_the_border_keeps_its_area():
    """The border of the region meets itself at a vertex."""
    diamond = dict(vertices=[(0, 0), (4, 0), (4, 4), (0, 4), (2, 1), (3, 2), (2, 3)],
                   segments=[*ring_of(4), (0, 4), (4, 5), (5, 6), (6, 0)], holes=[(2, 2)],
                   regions=[(3.5, 0.5, 1, 0.02)])
    mesh = tr.triangulate(diamond, "pqaA")
    areas = checks.measures(mesh["vertices"], mesh["triangles"])
    assert areas.max() <= 0.02 * (1 + 1e-9)
    assert math.isclose(areas.sum(), 16 - area_of([(0, 0), (2, 1), (3, 2), (2, 3)]), rel_tol=1e-9)


def test_holes_do_not_count_with_o_and_crossing_of_regions_is_their_own():
    mesh = tr.triangulate(BOX, "pqO")
    assert math.isclose(checks.measures(mesh["vertices"], mesh["triangles"]).sum(), 9, rel_tol=1e-9)


def test_attributes_are_linear_between_the_given_vertices():
    vertices = np.array(BOX["vertices"], float)
    values = np.stack([2 + 3 * vertices[:, 0] - vertices[:, 1], np.ones(8)], axis=1)
    mesh = tr.triangulate(dict(BOX, vertex_attributes=values), "pqa0.05")
    points = mesh["vertices"]
    assert mesh["vertex_attributes"].shape == (len(points), 2)
    assert np.allclose(mesh["vertex_attributes"][:, 0], 2 + 3 * points[:, 0] - points[:, 1], atol=1e-9)
    assert np.allclose(mesh["vertex_attributes"][:, 1], 1, atol=1e-12)
    values = np.random.default_rng(5).random(8)
    mesh = tr.triangulate(dict(BOX, vertex_attributes=values), "pqa0.05")
    new = mesh["vertex_attributes"][:, 0]
    assert (new[:8] == values).all()
    assert new.min() >= values.min() - 1e-9 and new.max() <= values.max() + 1e-9


@pytest.mark.parametrize("opts, whole", [("pqa0.02Y", "border"), ("pqa0.02YY", "all")])
def test_borders_stay_whole(opts, whole):
    t = 2 * np.pi * np.arange(40) / 40
    circle = np.stack([np.cos(t), np.sin(t)], axis=1)
    tri = dict(vertices=[*circle.tolist(), (-0.5, 0), (0.5, 0)],
               segments=[*ring_of(40), (40, 41)])
    if whole == "all":
        with pytest.raises(dynmesh.DynmeshError):  # the long segment has no room for small triangles
            tr.triangulate(tri, opts)
        inner = [(x, 0.0) for x in np.linspace(-0.5, 0.5, 8)]
        tri = dict(vertices=[*circle.tolist(), *inner],
                   segments=[*ring_of(40), *[(40 + i, 41 + i) for i in range(7)]])
    mesh = tr.triangulate(tri, opts)
    check(tri, mesh, "p")
    assert checks.border(mesh["triangles"]) == {frozenset(pair) for pair in ring_of(40)}
    if whole == "all":
        assert ({frozenset(row) for row in mesh["segments"].tolist()}
                == {frozenset(row) for row in tri["segments"]})
    else:
        assert len(mesh["segments"]) > 41
    assert checks.measures(mesh["vertices"], mesh["triangles"]).max() <= 0.02 * (1 + 1e-9)


def test_triangles_are_not_much_smaller_than_they_may_be():
    """Triangles of less than half of the area would be twice as many."""
    for name in ("square", "ell", "box"):
        tri, area = AREAS[name]
        mesh = tr.triangulate(tri, f"pqa{area / 2000:.9f}")
        assert 0.6 < 2000 / len(mesh["triangles"]) <= 1


def test_a_vertex_too_near_to_a_border_that_stays_whole_is_refused():
    tri = dict(SQUARE, vertices=[*SQUARE["vertices"], (0.5, 0.1)])
    with pytest.raises(dynmesh.FailedPrecondition, match="ENCROACHED"):
        tr.triangulate(tri, "pqY")


def test_a_border_that_stays_whole_beside_too_small_areas_is_refused():
    with pytest.raises(dynmesh.LimitExceeded, match="leave out the switch Y"):
        tr.triangulate(SQUARE, "pqa0.01Y")


def test_steiner_points_are_counted():
    needed = len(tr.triangulate(BOX, "pqa0.1")["vertices"]) - 8
    assert len(tr.triangulate(BOX, f"pqa0.1S{needed}")["vertices"]) == needed + 8
    with pytest.raises(Unsupported, match=f"S: the mesh needs {needed} new vertices"):
        tr.triangulate(BOX, f"pqa0.1S{needed - 1}")


def test_a_mesh_is_refined_where_its_areas_are_too_large():
    coarse = tr.triangulate(BOX, "pq30")
    wanted = np.where(coarse["vertices"][coarse["triangles"]].mean(axis=1)[:, 0] < 1.2, 0.01, -1)
    tri = dict(coarse, triangle_max_area=wanted,
               triangle_attributes=np.arange(len(wanted)).reshape(-1, 1))
    del tri["segments"], tri["segment_markers"]
    fine = tr.triangulate(tri, "rqa")
    check(coarse, fine)
    areas = checks.measures(fine["vertices"], fine["triangles"])
    assert math.isclose(areas.sum(), 8, rel_tol=1e-9)
    corners = coarse["vertices"][coarse["triangles"]]
    centres = fine["vertices"][fine["triangles"]].mean(axis=1)
    for number, (area, centre, of) in enumerate(zip(areas, centres, fine["triangle_attributes"][:, 0])):
        assert checks.is_inside(corners[int(of)], centre[None])[0], number
        assert wanted[int(of)] < 0 or area <= 0.01 * (1 + 1e-9)
    assert areas.max() > 0.02
    both = tr.triangulate(dict(tri, segments=coarse["segments"], regions=[(0.1, 0.1, 77, 0)]), "prqA")
    assert both["triangle_attributes"].shape == (len(both["triangles"]), 2)
    assert (both["triangle_attributes"][:, 1] == 77).all()
    finer = tr.triangulate(coarse, "prqa0.005")
    check(coarse, finer, "")
    assert checks.measures(finer["vertices"], finer["triangles"]).max() <= 0.005 * (1 + 1e-9)
    assert set(finer["segment_markers"][:, 0]) == {1, 2, 3, 4, 10}


def test_r_alone_tells_of_a_given_mesh():
    tri = dict(vertices=SQUARE["vertices"], triangles=[(0, 1, 2), (0, 3, 2)])
    mesh = tr.triangulate(tri, "ren")
    assert (mesh["vertices"] == np.array(SQUARE["vertices"])).all()
    assert mesh["triangles"].tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh["neighbors"].tolist() == [[-1, 1, -1], [-1, -1, 0]]
    assert len(mesh["edges"]) == 5 and mesh["edge_markers"].sum() == 4


@pytest.mark.parametrize("opts", ["pqo2e", "pqa0.2o2", "pqo1"])
def test_triangles_of_six_nodes(opts):
    mesh = tr.triangulate(BOX, opts)
    triangles, points = mesh["triangles"], mesh["vertices"]
    if "o1" in opts:
        assert triangles.shape[1] == 3
        return
    assert triangles.shape[1] == 6
    for i in range(3):
        middle = (points[triangles[:, (i + 1) % 3]] + points[triangles[:, (i + 2) % 3]]) / 2
        assert (points[triangles[:, 3 + i]] == middle).all()
    edges = checks.edges(triangles[:, :3])
    assert len(points) == len(np.unique(triangles[:, :3])) + len(edges)
    assert len(mesh["vertex_markers"]) == len(points)


@pytest.mark.parametrize("switch, left", [
    ("B", {"vertices", "triangles", "segments"}),
    ("P", {"vertices", "vertex_markers", "triangles"}),
    ("N", {"triangles", "segments", "segment_markers"}),
    ("E", {"vertices", "vertex_markers", "segments", "segment_markers"}),
    ("", {"vertices", "vertex_markers", "triangles", "segments", "segment_markers"})])
def test_arrays_that_are_not_wanted(switch, left):
    assert set(tr.triangulate(BOX, "pq" + switch)) == left


def test_vertices_without_a_triangle_stay_but_with_j():
    """One in the hole, one twice, one outside; vertices on segments cut them."""
    tri = dict(vertices=[*BOX["vertices"], (1.5, 1.6), (0, 0), (3.5, 1), (1.5, 0), (1, 1.3)],
               segments=BOX["segments"], holes=BOX["holes"])
    mesh = tr.triangulate(tri, "pq")
    check(tri, mesh, "p")
    assert np.setdiff1d(np.arange(13), mesh["triangles"]).tolist() == [8, 9, 10]
    left = tr.triangulate(tri, "pqj")
    assert len(left["vertices"]) == len(mesh["vertices"]) - 3
    assert (left["vertices"][left["triangles"]] == mesh["vertices"][mesh["triangles"]]).all()
    assert (left["vertices"][left["segments"]] == mesh["vertices"][mesh["segments"]]).all()


def test_segments_may_be_given_twice_and_overlap():
    tri = dict(vertices=[*SQUARE["vertices"], (0.3, 0), (0.1, 0.5), (0.2, 0.5), (0.3, 0.5)],
               segments=[*SQUARE["segments"], (1, 0), (0, 0), (5, 7), (5, 6), (4, 1)])
    mesh = tr.triangulate(tri, "pq")
    check(dict(tri, segments=[s for s in tri["segments"] if s[0] != s[1]]), mesh, "p")


def test_a_vertex_beside_a_segment_by_rounding_cuts_it():
    a, b = np.array([0.1, 0.1]), np.array([0.7, 0.4])
    on = a + (b - a) / 3
    tri = dict(vertices=[(0, 0), (1, 0), (1, 1), (0, 1), a, b, on], segments=[*ring_of(4), (4, 5)])
    mesh = tr.triangulate(tri, "pq")
    assert {frozenset(p) for p in checks.parts_of(
        mesh["vertices"], mesh["segments"].tolist(), a, b)[0]} >= {frozenset((4, 6))} or len(
            mesh["segments"]) > 6
    check(tri, mesh, "p")


def test_convex_hull_has_all_points_on_it():
    hull = tr.convex_hull([[0, 0], [0, 1], [1, 1], [1, 0], [0.5, 0.5], [0.5, 0]])
    assert {tuple(row) for row in hull.tolist()} == {(0, 5), (5, 3), (3, 2), (2, 1), (1, 0)}
    points = np.random.default_rng(1).random((200, 2))
    hull = tr.convex_hull(points)
    a, b = points[hull].transpose(1, 0, 2)
    for place in points:
        assert ((b - a)[:, 0] * (place - a)[:, 1] - (b - a)[:, 1] * (place - a)[:, 0] > -1e-12).all()
    with pytest.raises(ValueError, match="on one line"):
        tr.convex_hull([(0, 0), (1, 1), (2, 2)])


def test_the_dual_of_a_delaunay_mesh():
    mesh = tr.triangulate(SQUARE, "pqa0.05n")
    points, triangles = mesh["vertices"], mesh["triangles"]
    centres, edges, origins, directions = tr.dual_of(points, triangles)
    distances = np.linalg.norm(points[triangles] - centres[:, None], axis=2)
    assert np.allclose(distances, distances[:, :1])
    assert {frozenset(e) for e in edges.tolist()} == {
        frozenset((i, j)) for i, row in enumerate(mesh["neighbors"].tolist()) for j in row if j >= 0}
    assert len(origins) == np.count_nonzero(mesh["neighbors"] < 0)
    far = centres[origins] + directions
    middle = np.array([0.5, 0.5])
    assert (np.linalg.norm(far - middle, axis=1) > np.linalg.norm(centres[origins] - middle, axis=1)).all()


@pytest.mark.parametrize("opts, error, text", [
    ("pqu", Unsupported, "the switch u: .*refinement_func"),
    ("pqv", Unsupported, r"the switch v: .*voronoi\(points\)"),
    ("pqg", Unsupported, "the switch g"),
    ("pq31", Unsupported, "q: the least angle is 31 degrees, and dynmesh keeps up to 30"),
    ("pqa1e-5", ValueError, "exponent"), ("pqa0", ValueError, "above 0"),
    ("pqw", ValueError, "no switch 'w'"), ("pqo3", ValueError, "o2"), ("pq!", ValueError, "no switch"),
    ("rq", ValueError, "r refines a mesh")])
def test_switches_that_are_refused_are_named(opts, error, text):
    with pytest.raises(error, match=text):
        tr.triangulate(SQUARE, opts)


@pytest.mark.parametrize("tri, error, text", [
    (dict(), ValueError, "vertices are missing"),
    (dict(vertices=[(0, 0, 0)]), ValueError, r"vertices: an array of shape \(n, 2\)"),
    (dict(vertices=[(0, 0), (1, np.nan), (1, 1)]), ValueError, "row 1 is not finite"),
    (dict(vertices=[(0, 0), (1, 0), (1, 1)], segments=[(0, 3)]), ValueError, "vertices are 0 to 2"),
    (dict(vertices=[(0, 0), (1, 0), (1, 1)], points=[]), ValueError, "no key 'points'"),
    (dict(vertices=[(0, 0), (1, 0)]), ValueError, "a mesh needs 3"),
    (dict(SQUARE, segment_markers=[1, 2]), ValueError, "segment_markers: one for each row"),
    (dict(SQUARE, vertex_attributes=[1, 2]), ValueError, "vertex_attributes: a row"),
    (dict(SQUARE, holes=[(0.5, 0.5)]), ValueError, "nothing is left"),
    (dict(SQUARE, segments=[*SQUARE["segments"], (0, 2), (1, 3)]), dynmesh.FailedPrecondition,
     "cross at")])
def test_input_that_is_refused_is_named(tri, error, text):
    with pytest.raises(error, match=text):
        tr.triangulate(tri, "pq")


def test_what_is_given_stays_as_it_is():
    tri = {key: np.array(value, float if key in ("vertices", "holes") else int)
           for key, value in BOX.items()}
    before = {key: value.copy() for key, value in tri.items()}
    mesh = tr.triangulate(tri, "pqa0.1")
    mesh["vertices"][:] = 0
    assert all((before[key] == tri[key]).all() for key in before)


@pytest.mark.parametrize("scale, place", [(1e-6, 0), (1e6, 0), (1, 1e5), (1e-3, 10)])
def test_units_and_places_do_not_matter(scale, place):
    tri = dict(BOX, vertices=np.array(BOX["vertices"]) * scale + place,
               holes=np.array(BOX["holes"]) * scale + place)
    mesh = tr.triangulate(tri, f"pq30a{0.05 * scale**2:.20f}")
    areas = checks.measures(mesh["vertices"], mesh["triangles"])
    assert math.isclose(areas.sum(), 8 * scale**2, rel_tol=1e-6)
    assert areas.max() <= 0.05 * scale**2 * (1 + 1e-6)


def test_opts_are_a_string():
    with pytest.raises(TypeError, match="as 'pq30a0.1'"):
        tr.triangulate(SQUARE, 30)


def check_constrained_delaunay(points, triangles, segments):
    """Of each edge that is no segment, the vertices beside it are not in each other's circles."""
    walls = {frozenset(pair) for pair in np.asarray(segments).tolist()}
    for face, rows in checks.faces(triangles).items():
        if len(rows) == 2 and face not in walls:
            checks.check_delaunay(points, triangles[[rows[0][0], rows[1][0]]])


@pytest.mark.parametrize("name", AREAS)
@pytest.mark.parametrize("opts", ["p", "pAen", "pO", "pc", ""])
def test_triangulations_have_no_new_vertices(name, opts):
    tri, area = AREAS[name]
    mesh = tr.triangulate(tri, opts)
    points, triangles = mesh["vertices"], mesh["triangles"]
    assert (points == np.array(tri["vertices"], float)).all()
    if opts in ("p", "pAen"):
        assert math.isclose(checks.measures(points, triangles).sum(), area, rel_tol=1e-9)
    if "p" in opts:
        edges = checks.edges(triangles)
        assert all(frozenset(pair) in edges for pair in tri["segments"])
    assert (checks.measures(points, triangles) > 0).all()
    check_constrained_delaunay(points, triangles, mesh.get("segments", np.zeros((0, 2), int)))


def test_values_are_linear_in_the_triangulation():
    values = np.random.default_rng(7).random(8)
    coarse = tr.triangulate(BOX, "p")
    fine = tr.triangulate(dict(BOX, vertex_attributes=values), "pqa0.05")
    points, triangles = coarse["vertices"], coarse["triangles"]
    for place, value in zip(fine["vertices"][8:], fine["vertex_attributes"][8:, 0]):
        corners = points[triangles]
        system = np.concatenate([corners, np.ones((len(triangles), 3, 1))], axis=2).transpose(0, 2, 1)
        weights = np.linalg.solve(system, np.tile([*place, 1], (len(triangles), 1))[:, :, None])[:, :, 0]
        best = weights.min(axis=1).argmax()
        assert math.isclose(weights[best] @ values[triangles[best]], value, abs_tol=1e-9)


def test_a_hexagon_without_new_vertices():
    t = np.arange(6) * math.pi / 3
    ring = np.stack([np.cos(t), np.sin(t)], axis=1)
    points = [*ring.tolist(), (0, 0)]
    assert {frozenset(row) for row in tr.delaunay(points).tolist()} == {
        frozenset((i, (i + 1) % 6, 6)) for i in range(6)}
    centres, edges, origins, directions = tr.voronoi(points)
    assert np.allclose(np.linalg.norm(centres, axis=1), 1 / math.sqrt(3))
    assert len(edges) == len(origins) == len(directions) == 6
    mesh = tr.triangulate(dict(vertices=points, segments=[*ring_of(6), (0, 6), (6, 2), (6, 4)],
                               holes=[(0.5, 0.5)], regions=[(0.5, -0.5, 4, 0)],
                               vertex_attributes=np.arange(7)), "pAn")
    assert len(mesh["vertices"]) == 7 and len(mesh["triangles"]) == 4
    assert sorted(mesh["triangle_attributes"][:, 0]) == [0, 0, 4, 4]
    assert mesh["vertex_attributes"][:, 0].tolist() == list(range(7))
    assert (mesh["neighbors"] == checks.neighbours(mesh["triangles"])).all()
    assert len(mesh["segments"]) == 7 and set(mesh["segment_markers"][:, 0]) == {0, 1}


class Axes:
    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        return lambda *a, **k: self.calls.append((name, a)) or self


def test_plots_need_axes_only():
    axes = Axes()
    mesh = tr.triangulate(BOX, "pq")
    tr.plot(axes, **BOX)
    tr.plot(axes, **mesh)
    names = [name for name, _ in axes.calls]
    assert names == ["plot", "scatter", "scatter", "set_aspect", "plot", "plot", "scatter", "set_aspect"]
    drawn = axes.calls[4][1][0]
    assert len(drawn) == 3 * len(checks.edges(mesh["triangles"]))
    plt = Axes()
    tr.compare(plt, BOX, mesh)
    assert [name for name, _ in plt.calls][0] == "figure"
