"""The interface of `meshpy`: what its documents promise, by independent checks."""
import math
import pickle

import numpy as np
import pytest

import compat_checks as checks
import dynmesh
from dynmesh.compat import Unsupported
from dynmesh.compat.meshpy import triangle


def round_trip(first, last):
    return [(i, i + 1) for i in range(first, last)] + [(last, first)]


def letter():
    """An outline with a re-entrant corner in a circle, as in meshpy's example of refinement."""
    points = [(1, 0), (1, 1), (-1, 1), (-1, -1), (1, -1), (1.2, 0)]
    facets = round_trip(0, len(points) - 1)
    first = len(points)
    points += [(3 * np.cos(t), 3 * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 30, endpoint=False)]
    facets += round_trip(first, len(points) - 1)
    return points, facets


def info_of(points, facets, **more):
    info = triangle.MeshInfo()
    info.set_points(points)
    info.set_facets(facets, **more)
    return info


SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]


def areas(mesh):
    return checks.measures(mesh.points, mesh.elements)


def test_triangles_are_as_small_as_a_function_wants():
    points, facets = letter()
    info = info_of(points, facets)
    info.set_holes([(0, 0)])

    def largest(x, y):
        return 0.01 + 0.1 * max(0.0, max(abs(x), abs(y)) - 1)

    def needs_refinement(vertices, area):
        assert len(vertices) == 3 and len(vertices[0]) == 2 and area > 0
        return area > largest(*np.sum(np.array(vertices), axis=0) / 3)

    mesh = triangle.build(info, refinement_func=needs_refinement)
    checks.check_follows(np.array(mesh.points), np.array(mesh.elements), points, facets)
    sizes = areas(mesh)
    assert (sizes > 0).all()
    for size, (x, y) in zip(sizes, np.array(mesh.points)[np.array(mesh.elements)].mean(axis=1)):
        assert size <= largest(x, y)
    ring = 0.5 * 30 * 9 * math.sin(2 * math.pi / 30)
    assert math.isclose(sizes.sum(), ring - 4.1, rel_tol=1e-9)
    # It is not finer everywhere.
    assert sizes.max() > 0.05


@pytest.mark.parametrize("kwargs, least, largest", [
    (dict(), 20, np.inf), (dict(min_angle=30), 30, np.inf), (dict(min_angle=27.5), 27.5, np.inf),
    (dict(max_volume=0.01), 20, 0.01), (dict(max_volume=1e-3, min_angle=25), 25, 1e-3),
    (dict(quality_meshing=False, max_volume=0.02), 0, 0.02), (dict(verbose=True), 20, np.inf)])
def test_angles_and_areas(kwargs, least, largest):
    mesh = triangle.build(info_of(SQUARE, round_trip(0, 3)), **kwargs)
    assert math.isclose(areas(mesh).sum(), 1, rel_tol=1e-9)
    assert areas(mesh).max() <= largest * (1 + 1e-9)
    assert checks.angles(mesh.points, mesh.elements).min() > least - 0.01
    assert np.array(mesh.points)[:4].tolist() == np.array(SQUARE, float).tolist()


def test_without_quality_there_are_no_new_vertices():
    mesh = triangle.build(info_of(SQUARE, round_trip(0, 3)), quality_meshing=False)
    assert len(mesh.points) == 4 and len(mesh.elements) == 2


def test_regions_markers_faces_and_neighbours():
    points = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
    info = info_of(points, [*round_trip(0, 5), (1, 4)], facet_markers=[1, 2, 3, 4, 5, 6, 9])
    info.regions.resize(2)
    info.regions[0] = [0.5, 0.5, 11, 0.01]
    info.regions[1] = [1.5, 0.5] + [12, 0.1]
    mesh = triangle.build(info, volume_constraints=True, attributes=True, max_volume=0.05,
                          generate_faces=True, generate_neighbor_lists=True)
    cells = np.array(mesh.elements)
    left = np.array(mesh.points)[cells].mean(axis=1)[:, 0] < 1
    assert (np.array(mesh.element_attributes) == np.where(left, 11, 12)).all()
    assert areas(mesh)[left].max() <= 0.01 and areas(mesh)[~left].max() <= 0.05
    assert (np.array(mesh.neighbors) == checks.neighbours(cells)).all()
    assert {frozenset(row) for row in mesh.faces} == checks.edges(cells)
    on, _ = checks.parts_of(np.array(mesh.points), mesh.facets, (1, 0), (1, 1))
    markers = dict(zip(map(tuple, mesh.facets), mesh.facet_markers))
    assert on and all(markers[tuple(pair)] == 9 for pair in on)
    edge_markers = {frozenset(pair): m for pair, m in zip(mesh.faces, mesh.face_markers)}
    assert all(edge_markers[frozenset(pair)] == marker for pair, marker in markers.items())
    on_border = {v for face in checks.border(cells) for v in face}
    for vertex, marker in enumerate(mesh.point_markers):
        assert (marker != 0) == (vertex in on_border or math.isclose(mesh.points[vertex][0], 1))


def test_values_of_points_are_interpolated():
    info = info_of(SQUARE, round_trip(0, 3))
    info.number_of_point_attributes = 2
    info.point_attributes.setup()
    for i, (x, y) in enumerate(SQUARE):
        info.point_attributes[i] = [x + 2 * y, 3]
    mesh = triangle.build(info, max_volume=0.01)
    points = np.array(mesh.points)
    assert np.allclose(np.array(mesh.point_attributes)[:, 0], points @ (1, 2), atol=1e-9)
    assert np.allclose(np.array(mesh.point_attributes)[:, 1], 3)


def test_a_border_stays_whole():
    points, facets, markers = triangle.subdivide_facets(10, SQUARE, round_trip(0, 3), [1, 2, 3, 4])
    assert len(points) == len(facets) == len(markers) == 40
    assert markers == [1] * 10 + [2] * 10 + [3] * 10 + [4] * 10
    mesh = triangle.build(info_of(points, facets, facet_markers=markers), allow_boundary_steiner=False,
                          max_volume=0.01)
    assert checks.border(mesh.elements) == {frozenset(pair) for pair in facets}
    assert areas(mesh).max() <= 0.01


def test_facets_are_subdivided_each_by_its_number():
    points, facets = triangle.subdivide_facets([1, 2, 3, 4], SQUARE, round_trip(0, 3))
    assert len(facets) == 10 and points[:4] == SQUARE
    assert points[4] == (1, 0.5)
    for count in (0, [1, 2]):
        with pytest.raises(ValueError, match="subdivisions"):
            triangle.subdivide_facets(count, SQUARE, round_trip(0, 3))


def test_a_mesh_is_refined():
    coarse = triangle.build(info_of(SQUARE, round_trip(0, 3), facet_markers=[1, 2, 3, 4]), max_volume=0.1)
    coarse.element_volumes.setup()
    for i in range(len(coarse.elements)):
        coarse.element_volumes[i] = 0.002
    fine = triangle.refine(coarse)
    assert areas(fine).max() <= 0.002 * (1 + 1e-9) and math.isclose(areas(fine).sum(), 1)
    assert np.array(fine.points)[:len(coarse.points)].tolist() == np.array(coarse.points).tolist()
    assert set(fine.facet_markers) == {1, 2, 3, 4}
    fine = triangle.refine(coarse, refinement_func=lambda vertices, area: area > 0.01,
                           generate_neighbor_lists=True)
    assert areas(fine).max() <= 0.01
    assert (np.array(fine.neighbors) == checks.neighbours(fine.elements)).all()


def test_triangles_of_six_nodes():
    mesh = triangle.build(info_of(SQUARE, round_trip(0, 3)), mesh_order=2)
    points, cells = np.array(mesh.points), np.array(mesh.elements)
    assert cells.shape[1] == 6
    assert (points[cells[:, 3]] == points[cells[:, 1:3]].mean(axis=1)).all()


def test_arrays_are_those_of_meshpy():
    info = triangle.MeshInfo()
    assert len(info.points) == 0 and not info.point_markers.allocated
    info.points.resize(3)
    info.points[1] = (2, 1)
    info.points[2, 0] = 5
    assert info.points.unit == 2 and list(info.points) == [[0, 0], [2, 1], [5, 0]]
    assert info.points[1, 1] == 1 and info.points[1:] == [[2, 1], [5, 0]]
    info.point_markers.setup()
    info.point_markers[2] = 7
    assert info.point_markers.allocated and list(info.point_markers) == [0, 0, 7]
    info.points.resize(4)
    assert list(info.point_markers) == [0, 0, 7, 0]
    with pytest.raises(RuntimeError, match="setup"):
        info.point_markers.resize(2)
    with pytest.raises(ValueError, match="2 numbers"):
        info.points[0] = (1, 2, 3)
    info.point_markers.deallocate()
    assert len(info.point_markers) == 0
    copied = pickle.loads(pickle.dumps(info.copy()))
    copied.points[0] = (9, 9)
    assert info.points[0] == [0, 0] and copied.points[2] == [5, 0]


def test_outlines_are_written_for_gnuplot(tmp_path):
    mesh = triangle.build(info_of(SQUARE, round_trip(0, 3)))
    triangle.write_gnuplot_mesh(tmp_path / "mesh", mesh)
    blocks = (tmp_path / "mesh").read_text().strip().split("\n\n")
    assert len(blocks) == len(mesh.elements) and all(len(b.splitlines()) == 4 for b in blocks)
    triangle.write_gnuplot_mesh(tmp_path / "mesh", mesh, facets=True)
    assert len((tmp_path / "mesh").read_text().strip().split("\n\n")) == len(mesh.facets)


@pytest.mark.parametrize("kwargs, error, text", [
    (dict(allow_volume_steiner=False), Unsupported, "allow_volume_steiner"),
    (dict(min_angle=33), Unsupported, "min_angle: the least angle is 33"),
    (dict(max_volume=0), ValueError, "max_volume"), (dict(mesh_order=3), ValueError, "mesh_order"),
    (dict(allow_boundary_steiner=False, max_volume=1e-3), dynmesh.LimitExceeded, "may not be split")])
def test_what_is_refused_is_named(kwargs, error, text):
    with pytest.raises(error, match=text):
        triangle.build(info_of(SQUARE, round_trip(0, 3)), **kwargs)


@pytest.mark.parametrize("act, text", [
    (lambda info: info.set_points([(0, 0, 0)]), "2 coordinates"),
    (lambda info: info.set_points([(0, 0)], point_markers=[1, 2]), "point_markers: 1 numbers"),
    (lambda info: info.set_facets([(0, 1, 2)]), "pair of vertices"),
    (lambda info: info.set_facets([(0, 1)], facet_markers=[]), "facet_markers"),
    (triangle.refine, "no elements")])
def test_rows_that_cannot_be_meant(act, text):
    with pytest.raises(ValueError, match=text):
        act(triangle.MeshInfo())
