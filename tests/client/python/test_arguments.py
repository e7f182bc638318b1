"""What is of the wrong form is refused, and the message says what is expected and what came."""
import re

import numpy as np
import pytest

import dynmesh


@pytest.fixture
def mesh():
    mesh = dynmesh.open(((0, 0), (1, 1)))
    mesh.apply(add_points={1: (0.2, 0.2), 2: (0.8, 0.2), 3: (0.8, 0.8), 4: (0.2, 0.8),
                           5: (0.5, 0.62)},
               add_segments={10: (1, 3)}, add_polygons={11: (1, 2, 3)})
    return mesh


POINTS = r"expected is add_points=\{1: \(0.2, 0.3\)"
SEGMENTS = r"expected is add_segments=\{10: \(1, 2\)"
POLYGONS = r"expected is add_polygons=\{20: \(1, 2, 3\)\}"
SIZES = r"expected is add_sizes=\{30: dict\(target="
LABELS = r"expected is set_labels=\{10: dict\(marker="


@pytest.mark.parametrize("edits, error, words", [
    (dict(add_points=np.full((4, 2), 0.5)), TypeError, f"there are no ids in array.*{POINTS}"),
    (dict(add_points=[(0.1, 0.1), (0.3, 0.3)]), TypeError, f"there are none in .*0.3.*{POINTS}"),
    (dict(add_points=[(0.1, 0.1), (0.3, 0.3), (1, 1)]), TypeError, f"there are no ids.*{POINTS}"),
    (dict(add_points=[(0, 0), (1, 1)]), ValueError, rf"a pair is \(ids, values\).*2 coordinates.*\[0, 0\] and the values \(1, 1\); {POINTS}"),
    (dict(add_points=([20, 21, 22], np.ones((2, 2)))), ValueError,
     rf"3 ids: shape \(3, 2\), and got of shape \(2, 2\); {POINTS}"),
    (dict(add_points=([20, 21, 22], np.ones((2, 3)))), ValueError, f"its transpose; {POINTS}"),
    (dict(add_points={20: 0.5}), ValueError, f"20 has 2 coordinates, and got 0.5; {POINTS}"),
    (dict(add_points={20: (0.5, 0.5, 0.5)}), ValueError, f"20 has 2 coordinates.*{POINTS}"),
    (dict(add_points={20: (0.1, 0.1), 21: (0.5,)}), ValueError, r"21 has 2 coordin.*\(0.5,\)"),
    (dict(add_points={20: ("x", 0.1)}), ValueError, "20 has 2 coordinates, and got .'x'"),
    (dict(add_points={"a": (0.1, 0.1)}), TypeError, f"ids are whole numbers, and got 'a'; {POINTS}"),
    (dict(add_points={20.5: (0.1, 0.1)}), TypeError, "ids are whole numbers, and got 20.5"),
    (dict(add_points={-3: (0.1, 0.1)}), ValueError, "from 1 to 18446744073709486079, and got -3"),
    (dict(add_points={2**64: (0.1, 0.1)}), ValueError, f"486079, and got {2**64}"),
    (dict(add_points={0: (0.1, 0.1)}), dynmesh.InvalidArgument, "BAD_ID.*18446744073709486079"),
    (dict(add_points=7), TypeError, f"no ids in 7; {POINTS}"),
    (dict(move_points=[(0.1, 0.1), (0.3, 0.3)]), TypeError, "expected is move_points="),
    (dict(add_segments=[(1, 2), (2, 3)]), ValueError, f"two ends, ids of points.*{SEGMENTS}"),
    (dict(add_segments=[[1, 2], [2, 3], [3, 4]]), TypeError, f"there are no ids.*{SEGMENTS}"),
    (dict(add_segments={20: (1, 2, 4)}), ValueError, rf"two ends.*\(1, 2, 4\); {SEGMENTS}"),
    (dict(add_segments={20: (0.2, 0.4)}), TypeError, f"ends are whole numbers, .*{SEGMENTS}"),
    (dict(add_polygons={20: [(0.1, 0.1), (0.9, 0.1), (0.5, 0.9)]}), TypeError,
     f"20 has corners that are ids of points, whole numbers, and got 0.1: add its.*{POLYGONS}"),
    (dict(add_polygons={20: 7}), TypeError, f"20 has a ring, and got 7; {POLYGONS}"),
    (dict(add_polygons={20: [(1, 2, 3), 4]}), TypeError, f"side by side.*{POLYGONS}"),
    (dict(add_polygons=[(1, 2, 3)]), TypeError, rf"got \[\(1, 2, 3\)\]; {POLYGONS}"),
    (dict(add_polygons={20: (1, 2, 3, 1)}), dynmesh.InvalidArgument,
     "BAD_POLYGON.*begins and ends with point 1; a ring closes itself: leave its last point out"),
    (dict(add_polygons={20: (1, 2, 3, 2, 4)}), dynmesh.InvalidArgument, "point 2 twice"),
    (dict(add_points={20: (0.5, 0.2)}), dynmesh.FailedPrecondition,
     "POINT_ON_SEGMENT.*give polygon 11 a ring with point 20 as a corner between points 1 and 2"),
    (dict(add_points={20: (0.4, 0.4)}), dynmesh.FailedPrecondition,
     "POINT_ON_SEGMENT.*replace the segment by two"),
    (dict(add_sizes={20: (0.5, 0.5, 0.1, 0.01)}), TypeError,
     rf"20 is a dict with a target and a place, and got \(0.5, .*{SIZES}"),
    (dict(add_sizes={20: dict(at=(0.5, 0.5), radius=0.1)}), ValueError, f"no target; {SIZES}"),
    (dict(add_sizes={20: dict(target=0.1)}), ValueError, f"20 has no place.*{SIZES}"),
    (dict(add_sizes={20: dict(target=0.1, low=(0, 0))}), ValueError, f"no high; {SIZES}"),
    (dict(add_sizes={20: dict(target=0.1, at=0.5)}), ValueError, "20: at has 2 coord.*got 0.5"),
    (dict(add_sizes={20: dict(target="x", at=(0.5, 0.5))}), ValueError, "target is a number"),
    (dict(add_sizes={20: dict(target=0.1, rings=[(0.1, 0.2), (0.3, 0.4)])}), TypeError, "ids of"),
    (dict(add_sizes=0.1), TypeError, f"got 0.1; {SIZES}"),
    (dict(remove=[1.5]), TypeError, r"got 1.5; expected is remove=\[1, 2, 10\]"),
    (dict(set_labels={10: "wall"}), TypeError, f"10 has a marker and a name.*'wall'; {LABELS}"),
    (dict(set_labels={10: dict(marke=3)}), TypeError, f"there is no marke of a label.*{LABELS}"),
    (dict(set_labels={10: dict(marker=1.5)}), TypeError, "whole number as marker.*1.5"),
    (dict(set_labels={10: dict(marker=2**63)}), TypeError, "whole number as marker"),
    (dict(set_labels={10: dict(name=7)}), TypeError, "a text as name, and got 7"),
])
def test_edits(mesh, edits, error, words):
    before = mesh.hash, mesh.revision, mesh.labels
    with pytest.raises(error) as caught:
        mesh.apply(**edits)
    assert re.search(words, str(caught.value)), str(caught.value)
    assert str(caught.value).split(":")[0] in (*edits, getattr(caught.value, "reason", ""))
    assert (mesh.hash, mesh.revision, mesh.labels) == before


def test_forms_that_are_accepted(mesh):
    mesh.apply(add_points=([20, 21], [[0.1, 0.5], [0.15, 0.55]]), remove=np.array([10]))
    mesh.apply(add_points={np.int64(22): np.array([0.9, 0.5])})
    mesh.apply(add_segments=(np.array([23]), np.array([[20, 21]])), remove=11)
    mesh.apply(add_polygons={24: np.array([1, 2, 3])}, add_points={}, add_segments=([], []))
    mesh.apply(set_polygons={24: [np.array([1, 2, 3])]}, add_sizes={
        25: dict(target=np.float32(0.1), at=np.array([0.5, 0.5]), radius=1)})
    assert mesh.revision == 6


@pytest.mark.parametrize("options, words", [
    (dict(box=(0, 0, 1, 1)), r"two corners.*got \(0, 0, 1, 1\): box=\(\(0.0, 0.0\), \(1.0, 1.0\)\)"),
    (dict(box=7), "box: it is two corners"),
    (dict(box=[[0, 0], [1]]), "box: it is two corners"),
    (dict(box=((0, 1), (0, 1))), r"in x: it is empty.*not a range for each axis.*\(\(0.0, 0.0\), "
     r"\(1.0, 1.0\)\)"),
    (dict(box=((0, 4), (0, 2))), r"x is from 0 to 4 and y from 0 to 2, it is box=\(\(0.0, 0.0\), "
     r"\(4.0, 2.0\)\)"),
    (dict(box=((0, 1), (0, 3))), r"empty.*box=\(\(0.0, 0.0\), \(1.0, 3.0\)\)"),
    (dict(box=((0, 1), (0, 1), (0, 1))), r"box=\(\(0.0, 0.0, 0.0\), \(1.0, 1.0, 1.0\)\)\?"),
    (dict(box=((0, 0), (0, 0))), "empty"),
    (dict(box=((1, 1), (0, 0))), r"box=\(\(0.0, 0.0\), \(1.0, 1.0\)\)\?"),
    (dict(rho=0.5), "BAD_OPTION: rho: 0.5 is not in 1 to 100; rho is the largest circumradius"),
    (dict(rho="big"), "rho: it is a number, and got 'big'"),
    (dict(maxedge=0.1), "maxedge: there is no such option.*max_edge"),
    (dict(dimension=2.0), "dimension: it is a whole number, 2 or 3"),
    (dict(kind=7), "kind: it is 'delaunay', 'quadtree' or 'triangulation'"),
    (dict(max_vertices=1e6), "max_vertices: it is a whole number"),
])
def test_options(server, options, words):
    for make in (dynmesh.open, server.create, lambda **o: server.mesh("none", create=o)):
        with pytest.raises((ValueError, TypeError, dynmesh.DynmeshError)) as caught:
            make(**options)
        assert re.search(words, str(caught.value)), str(caught.value)


@pytest.mark.parametrize("values, kind, error, words", [
    (lambda m: np.zeros(3), "P1", ValueError, "vertex slot, .*rows at revision 1, and got 3; mesh"),
    (lambda m: np.zeros(m.cell_slots), "P1", ValueError, "the number of cell slots.*kind='P0'"),
    (lambda m: np.zeros(m.vertex_slots), "P0", ValueError, "the number of vertex slots.*kind='P1'"),
    (lambda m: np.zeros((m.vertex_slots, 3)), "DG1", ValueError, "number of vertex slots"),
    (lambda m: np.zeros((m.cell_slots, 2)), "DG1", ValueError, r"\(slots, 3\), and got"),
    (lambda m: np.zeros(m.vertex_slots), "overlap", ValueError, "number of vertex slots"),
    (lambda m: np.zeros(m.vertex_slots + 1), "P1", ValueError, "vertex_slots is that number"),
    (lambda m: np.float64(1), "P1", ValueError, "not a single number"),
    (lambda m: np.zeros((m.vertex_slots, 2, 2)), "P1", ValueError, "axis of components"),
    (lambda m: np.zeros(m.vertex_slots, complex), "P1", TypeError, "real numbers.*complex128"),
    (lambda m: np.zeros(m.vertex_slots, bool), "P1", TypeError, "real numbers.*bool"),
    (lambda m: np.full(m.vertex_slots, "1"), "P1", TypeError, "real numbers.*<U1"),
    (lambda m: np.zeros(m.vertex_slots), "p1", ValueError, "no kind 'p1': 'P1' is meant"),
    (lambda m: np.zeros(m.vertex_slots), None, ValueError, "no kind None; there are 'P1'"),
])
def test_fields(mesh, values, kind, error, words):
    def says(call):
        with pytest.raises(error) as caught:
            call()
        assert re.search(words.replace("revision 1", r"revision \d"), str(caught.value)), \
            str(caught.value)

    assert mesh.vertex_slots != mesh.cell_slots
    u = values(mesh)
    says(lambda: mesh.fields.add("u", u, kind=kind))
    assert len(mesh.fields) == 0
    diff = mesh.apply(move_points={5: (0.3, 0.7)})
    says(lambda: diff.transfer(u, kind=kind))
    if kind in ("P1", "P0", "DG1"):
        says(lambda: diff.transfer_momentum(u, u, kind=kind))


def test_values_that_are_not_finite(mesh):
    for bad in (np.nan, np.inf):
        u = np.ones((mesh.vertex_slots, 2))
        row = np.flatnonzero(mesh.live_vertices)[7]
        u[row, 1] = bad
        with pytest.raises(ValueError, match=rf"fields\['u'\].*finite, and row {row} is"):
            mesh.fields.add("u", u)
    u = np.ones(mesh.vertex_slots)
    u[mesh.ids == 0] = np.nan  # free rows have no value
    mesh.fields.add("u", u)
    with pytest.raises(TypeError, match="no option ring; there are bounded"):
        mesh.fields.add("v", u, ring=2)
    with pytest.raises(ValueError, match=r"fields\['u'\].*shape.*\(3,\)"):
        mesh.fields["u"] = np.zeros(3)
    mesh.fields["u"] = 2
    assert (mesh.fields["u"] == 2).all()


def test_room_for_later_slots_is_given_in_place_only(mesh):
    room = np.zeros(5 * mesh.vertex_slots)
    diff = mesh.apply(move_points={5: (0.3, 0.7)})
    assert diff.transfer(room, inplace=True) is room
    with pytest.raises(ValueError, match="needs a row for each vertex slot"):
        diff.transfer(room)
    with pytest.raises(ValueError, match="the number of cell slots"):
        diff.transfer(np.zeros(mesh.cell_slots), inplace=True)
    with pytest.raises(ValueError, match="at least"):
        diff.transfer(np.zeros(3), inplace=True)


def test_data_for_files(mesh):
    pytest.importorskip("meshio")
    mesh.apply(remove=[5])
    for what, count, of in (("point_data", mesh.vertex_slots, "vertex"),
                            ("cell_data", mesh.cell_slots, "cell")):
        with pytest.raises(ValueError, match=rf"{what}\['u'\].*{of} slot, {count} rows .*got 3"):
            mesh.to_meshio(**{what: {"u": np.zeros(3)}})
        with pytest.raises(ValueError, match="a single number"):
            mesh.to_meshio(**{what: {"u": 3}})
    with pytest.raises(ValueError, match="rows of mesh.compact"):
        mesh.to_meshio({"u": np.zeros(mesh.vertex_count)})


def test_places(mesh):
    for bad, words in (((0.5, 0.5, 0.5), r"2 coordinates.*\(3,\)"), ([(np.nan, 0.5)], "row 0"),
                       (np.zeros((1, 2, 2)), "2 coordinates")):
        with pytest.raises(ValueError, match="points: .*" + words):
            mesh.locate(bad)
