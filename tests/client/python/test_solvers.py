"""Parts for packages of finite elements."""
import numpy as np
import pytest

import dynmesh


def plate(make_mesh):
    """A plate with an inclusion, the name of a side, and a crack to the right side."""
    mesh = make_mesh(box=[[0, 0], [2, 1]], max_edge=0.2)
    mesh.apply(add_points={1: (0, 0), 2: (2, 0), 3: (2, 0.5), 4: (2, 1), 5: (0, 1), 11: (0.4, 0.4),
                           12: (0.6, 0.4), 13: (0.6, 0.6), 14: (0.4, 0.6), 15: (1, 0.5)},
               add_polygons={7: (1, 2, 3, 4, 5), 8: (11, 12, 13, 14)},
               add_segments={9: (5, 1), 20: (15, 3)},
               set_labels={7: dict(marker=1, name="plate"), 8: dict(marker=2, name="inclusion"),
                           9: dict(marker=3, name="left"), 20: dict(marker=4, name="crack")})
    return mesh.part(open="crack")


def room(make_mesh):
    """A room in two storeys; the floor between them is opened. All walls upstairs are "attic"."""
    mesh = make_mesh(box=[[0] * 3, [1] * 3])
    corners = {1 + 4 * level + i: (x, y, z) for level, z in enumerate((0, 0.5, 1))
               for i, (x, y) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1)))}
    walls = {20 + 4 * level + i: (a, 4 * level + 1 + (i + 1) % 4, 4 * level + 5 + (i + 1) % 4, a + 4)
             for level in range(2) for i, a in enumerate(range(4 * level + 1, 4 * level + 5))}
    floors = {30: (1, 2, 3, 4), 31: (9, 10, 11, 12), 40: (5, 6, 7, 8)}
    mesh.apply(add_points=corners, add_polygons={**floors, **walls},
               set_labels={**{id_: dict(marker=5, name="attic") for id_ in (31, 24, 25, 26, 27)},
                           40: dict(marker=6, name="floor"), 30: dict(marker=7, name="ground")})
    return mesh.part(open="floor")


def facets_as_in_skfem(t):
    """The columns of scikit-fem's `mesh.facets`."""
    rows = [np.delete(t, k, axis=0) for k in range(len(t))]
    return np.unique(np.sort(np.hstack(rows), axis=0), axis=1)


def measures(p, t):
    corners = p.T[t.T]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / {3: 2, 4: 6}[len(t)]


def test_a_plate_for_skfem(make_mesh):
    part = plate(make_mesh)
    arrays = dynmesh.to_skfem(part)
    assert arrays.p.shape == (2, len(part.points)) and arrays.t.shape == (3, len(part.cells))
    assert arrays.p.flags.c_contiguous and arrays.t.flags.c_contiguous
    area = measures(arrays.p, arrays.t)
    assert arrays.subdomains.keys() == {"plate", "inclusion"}
    np.testing.assert_allclose(area[arrays.subdomains["inclusion"]].sum(), 0.04)
    np.testing.assert_allclose(area[arrays.subdomains["plate"]].sum(), 1.96)
    facets = facets_as_in_skfem(arrays.t)
    assert arrays.boundaries.keys() == {"plate", "inclusion", "left", "crack"}
    ends = arrays.p.T[facets]
    length = np.linalg.norm(ends[1] - ends[0], axis=1)
    for name, expected in dict(plate=5, inclusion=0.8, left=1, crack=2).items():
        np.testing.assert_allclose(length[arrays.boundaries[name]].sum(), expected, err_msg=name)
    np.testing.assert_array_equal(ends[:, arrays.boundaries["crack"], 1], 0.5)


def test_a_room_for_skfem(make_mesh):
    arrays = dynmesh.to_skfem(room(make_mesh))
    volume = measures(arrays.p, arrays.t)
    # Of the lower storey not all walls have a name, so it has none; nor has the upper one, whose
    # floor has another.
    assert arrays.subdomains == {}
    facets = facets_as_in_skfem(arrays.t)
    corners = arrays.p.T[facets]
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]), axis=1) / 2
    for name, expected in dict(attic=3, floor=2, ground=1).items():
        np.testing.assert_allclose(area[arrays.boundaries[name]].sum(), expected, err_msg=name)
    np.testing.assert_allclose(volume.sum(), 1)


def test_a_closed_surface_with_one_name_is_a_subdomain(make_mesh):
    mesh = make_mesh(box=[[0] * 3, [1] * 3])
    corners = {1 + i: [i >> k & 1 for k in range(3)] for i in range(8)}
    faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    mesh.apply(add_points=corners,
               add_polygons={20 + i: [1 + c for c in f] for i, f in enumerate(faces)},
               set_labels={20 + i: dict(name="cube") for i in range(6)})
    arrays = dynmesh.to_skfem(mesh.part())
    assert len(arrays.subdomains["cube"]) == arrays.t.shape[1]
    assert dynmesh.to_skfem(mesh.part(polygons=12345)).t.shape == (4, 0)


@pytest.mark.filterwarnings("ignore")  # of its compiler, which leaves files open
@pytest.mark.parametrize("make_part", [plate, room])
def test_dolfinx_integrates_over_names(make_mesh, make_part):
    dolfinx = pytest.importorskip("dolfinx", reason="python3-dolfinx is not installed")
    import ufl
    part = make_part(make_mesh)
    found = dynmesh.to_dolfinx(part)
    np.testing.assert_array_equal(found.mesh.geometry.x[:, :part.mesh.dimension],
                                  part.points[found.vertices])
    one = dolfinx.fem.Constant(found.mesh, 1.0)
    measures = {"dx": found.cell_tags, "ds": found.facet_tags, "dS": found.facet_tags}

    def integral(name, marker):
        over = ufl.Measure(name, found.mesh, subdomain_data=measures[name])
        return dolfinx.fem.assemble_scalar(dolfinx.fem.form(one * over(marker)))

    # The crack has two sides at the border.
    expected = ({("dx", 1): 1.96, ("dx", 2): 0.04, ("ds", 3): 1, ("ds", 4): 2, ("dS", 4): 0,
                 ("dS", 2): 0.8, ("ds", 1): 5} if make_part is plate else
                {("ds", 5): 3, ("ds", 6): 2, ("dS", 6): 0, ("ds", 7): 1})
    for (name, marker), value in expected.items():
        np.testing.assert_allclose(integral(name, marker), value, atol=1e-12,
                                   err_msg=f"{name} {marker}")
    with pytest.raises(dynmesh.FailedPrecondition, match="no cells"):
        dynmesh.to_dolfinx(part.mesh.part(polygons=12345))


@pytest.mark.parametrize("make_part", [plate, room])
def test_a_dmplex_has_markers_as_labels(make_mesh, make_part):
    pytest.importorskip("petsc4py", reason="python3-petsc4py is not installed")
    part = make_part(make_mesh)
    found = dynmesh.to_dmplex(part)
    dm, d = found.dm, part.mesh.dimension
    first, last = dm.getHeightStratum(0)
    assert (first, last) == (0, len(part.cells))
    assert (found.vertices.start, found.vertices.stop) == dm.getDepthStratum(0)
    np.testing.assert_array_equal(dm.getCoordinatesLocal().array.reshape(-1, d), part.points)

    def size(label, marker):
        points = dm.getStratumIS(label, marker)
        assert points, f"{label} {marker}"
        return sum(dm.computeCellGeometryFVM(p)[0] for p in points.indices)

    expected = ({("Cell Sets", 1): 1.96, ("Cell Sets", 2): 0.04, ("Face Sets", 3): 1,
                 ("Face Sets", 4): 2, ("Face Sets", 2): 0.8} if make_part is plate else
                {("Face Sets", 5): 3, ("Face Sets", 6): 2, ("Face Sets", 7): 1})
    for (label, marker), value in expected.items():
        np.testing.assert_allclose(size(label, marker), value, err_msg=f"{label} {marker}")
    # Facets of the border have one cell beside them, those within have two.
    beside = np.array([dm.getSupportSize(p) for p in found.facets])
    np.testing.assert_array_equal(beside == 1, part.is_border)
    with pytest.raises(dynmesh.FailedPrecondition, match="no cells"):
        dynmesh.to_dmplex(part.mesh.part(polygons=12345))
