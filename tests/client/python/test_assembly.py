"""Parts that move, and the bands between them."""
import concurrent.futures
import math

import meshio
import numpy as np
import pytest

import dynmesh

BOX = [[-1, -1], [1, 1]]
DISC, HOLE, PLATE, BORE = 10_001, 10_002, 10_003, 10_004


def circle(radius, n, at=(0, 0)):
    t = 2 * np.pi * np.arange(n) / n
    return np.array(at) + radius * np.column_stack([np.cos(t), np.sin(t)])


def square(half, at=(0, 0)):
    return np.array(at) + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])


def loops(mesh, polygons, **more):
    first = np.cumsum([1] + [len(at) for at in polygons.values()])
    mesh.apply(add_points=(np.arange(1, first[-1]), np.vstack(list(polygons.values()))),
               add_polygons={id_: list(range(a, b)) for id_, a, b in zip(polygons, first, first[1:])},
               **more)


def rotor_in(curve, marker=1, name="bar"):
    mesh = dynmesh.open(BOX)
    loops(mesh, {DISC: curve, HOLE: square(0.15, curve.mean(axis=0))}, unsplit=[DISC],
          set_labels={HOLE: dict(marker=marker, name=name), DISC: dict(name="disc")})
    return mesh.part(polygons=DISC, without=HOLE)


def stator_around(curve):
    mesh = dynmesh.open(BOX)
    loops(mesh, {PLATE: square(0.9), BORE: curve}, unsplit=[BORE],
          set_labels={PLATE: dict(marker=2, name="plate")})
    return mesh.part(polygons=PLATE, without=BORE)


def machine(spacing=None):
    inner, outer = circle(0.4, 40), circle(0.6, 60)
    assembly = dynmesh.Assembly()
    assembly.add("rotor", rotor_in(inner))
    assembly.add("stator", stator_around(outer))
    assembly.band("gap", outer=("stator", outer), inner=("rotor", inner),
                  spacing=spacing, label=dict(marker=3, name="air"))
    return assembly


def areas(assembly):
    corners = assembly.points[assembly.cells]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2


def polygon_area(curve):
    after = np.roll(curve, -1, axis=0)
    return abs((curve[:, 0] * after[:, 1] - curve[:, 1] * after[:, 0]).sum()) / 2


def arrays(assembly):
    return (assembly.points, assembly.cells, assembly.facets, assembly.facet_cells,
            assembly.cell_regions, assembly.facet_markers)


def check_conforming(assembly, whole):
    """Edges are those of two cells, or at the border; cells cover the whole once."""
    size = areas(assembly)
    assert size.min() > 0
    assert abs(math.fsum(size) - whole) < 1e-13
    edges = np.concatenate([assembly.cells[:, [i, (i + 1) % 3]] for i in range(3)])
    directed = set(map(tuple, edges.tolist()))
    assert len(directed) == len(edges)
    border = {(a, b) for a, b in directed if (b, a) not in directed}
    assert border == set(map(tuple, assembly.facets[assembly.is_border].tolist()))
    assert len(np.unique(assembly.cells)) == len(assembly.points)
    assert len(np.unique(assembly.points, axis=0)) == len(assembly.points)
    for column in (0, 1):
        at = assembly.facet_cells[:, column] >= 0
        ends, corners = assembly.facets[at], assembly.cells[assembly.facet_cells[at, column]]
        assert (ends[:, :, None] == corners[:, None]).any(axis=2).all()
    assert (assembly.facet_cells[:, 0] >= 0).all()


def test_a_part_stays_to_the_bit_while_it_turns():
    assembly = machine()
    rotor = assembly.part("rotor")
    before = [array.copy() for array in (rotor.points, rotor.cells, rotor.facets)]
    hash_, cells = rotor.mesh.hash, assembly.cells[assembly.cells_of("rotor")]
    stands = assembly.points[assembly.vertices("stator")]
    whole = 1.8**2 - 0.3**2
    for step in range(360):
        angle = np.radians(step)
        assembly.turn("rotor", angle)
        assert np.array_equal(assembly.cells[assembly.cells_of("rotor")], cells)
        if step % 12 == 0:
            check_conforming(assembly, whole)
        turned = assembly.points[assembly.vertices("rotor")]
        c, s = np.cos(angle), np.sin(angle)
        assert np.abs(turned @ np.array([[c, -s], [s, c]]) - before[0]).max() < 1e-15
        assert np.array_equal(assembly.points[assembly.vertices("stator")], stands)
    assert rotor.mesh.hash == hash_
    for was, now in zip(before, (rotor.points, rotor.cells, rotor.facets)):
        assert np.array_equal(was, now)


@pytest.mark.parametrize("spacing", [None, 0.03])
def test_the_mesh_is_a_function_of_the_frames(spacing):
    straight, around = machine(spacing), machine(spacing)
    straight.turn("rotor", 0.7)
    for angle in (0.2, 3.0, -1.0):
        around.turn("rotor", angle)
    around.move("rotor", (0.02, -0.01))  # the circles have two centres then
    check_conforming(around, 1.8**2 - 0.3**2)
    around.place({"rotor": dynmesh.Frame(angle=0.7)})
    for a, b in zip(arrays(straight), arrays(around)):
        assert np.array_equal(a, b)
    around.turn("rotor", 0)
    for a, b in zip(arrays(around), arrays(machine(spacing))):
        assert np.array_equal(a, b)
    assert np.array_equal(around.points[around.vertices("rotor")], around.part("rotor").points)


def test_rings_between_circles_need_no_further_vertices():
    assembly = machine()
    own = assembly.points[assembly.vertices("gap")]
    radii = np.unique(np.linalg.norm(own, axis=1).round(12))
    assert 1 < len(radii) < 5
    u = np.random.default_rng(1).random(len(assembly.points))
    for step in range(1, 30):
        motion = assembly.turn("rotor", 0.1 * step)
        assert np.array_equal(assembly.points[assembly.vertices("gap")], own)
        assert np.array_equal(motion.transfer(u), u)
    # Next to a circle their number is out of step with it.
    for radius, n in dynmesh._band.ring_counts((0.4, 40), (0.6, 60), None)[:1]:
        assert math.gcd(n - 40, 30) == 1
    assert dynmesh._band.ring_counts((0.5, 144), (0.52, 150), None) == []


def test_fields_turn_with_their_part():
    assembly = machine()
    rotor, stator, gap = (assembly.vertices(name) for name in ("rotor", "stator", "gap"))
    at = assembly.points
    u = 1 + at[:, 0] + 2 * at[:, 1]
    v = np.tile([1.0, 0.0], (len(at), 1))
    motion = assembly.turn("rotor", np.pi / 2)
    turned, arrows = motion.transfer(u), motion.transfer(v, vectors=True)
    x, y = assembly.points[rotor].T
    assert np.allclose(turned[rotor], 1 + y - 2 * x, atol=1e-14)
    assert np.array_equal(turned[rotor], u[rotor])
    assert np.allclose(arrows[rotor], [0, 1], atol=1e-15)
    assert np.array_equal(arrows[stator], v[stator]) and np.array_equal(arrows[gap], v[gap])
    assert np.array_equal(motion.transfer(np.ones(len(at))), np.ones(len(at)))


def test_values_in_cells_keep_the_integral_of_the_band():
    assembly = machine()
    random = np.random.default_rng(2)
    u, tags = random.random((len(assembly.cells), 3)), np.arange(len(assembly.cells))
    gap = assembly.cells_of("gap")
    total = areas(assembly)[gap] @ u[gap]
    for step in range(1, 20):
        before, was = u, gap
        motion = assembly.turn("rotor", 0.13 * step)
        u = motion.transfer(u, "P0")
        gap = assembly.cells_of("gap")
        assert np.abs(areas(assembly)[gap] @ u[gap] - total).max() < 1e-15
        assert np.array_equal(u[assembly.cells_of("rotor")], before[assembly.cells_of("rotor")])
        ones = motion.transfer(np.full(len(before), 0.1), "P0")
        assert np.array_equal(ones, np.full(len(u), 0.1))
        new = motion.transfer(tags, "overlap")
        assert new.dtype == tags.dtype
        assert set(new[gap]) <= set(tags[was])
        tags = new
    with pytest.raises(dynmesh.StaleDiff, match="another motion"):
        old = motion
        assembly.turn("rotor", 0)
        old.transfer(u, "P0")


def test_a_body_moves_through_a_channel():
    body, walls = square(0.1), dynmesh.points_along([(0, 0), (2, 0), (2, 1), (0, 1)], 0.2, closed=True)
    curve = dynmesh.points_along(body, 0.1, closed=True)
    mesh = dynmesh.open(BOX)
    loops(mesh, {DISC: curve}, unsplit=True, set_labels={DISC: dict(marker=4, name="body")})
    assembly = dynmesh.Assembly()
    assembly.add("body", mesh.part(polygons=DISC), dynmesh.Frame(shift=(0.4, 0.5)))
    assembly.band("water", outer=walls, inner=("body", curve), spacing=0.08,
                  border=dict(marker=9, name="walls"))
    check_conforming(assembly, 2)
    assert (assembly.facet_markers == 9).sum() == len(walls)
    first = arrays(assembly)
    tags = np.arange(len(assembly.cells))
    for step in range(1, 6):
        former = assembly.frame("body")
        u = 1 + assembly.points @ [2, 3]
        motion = assembly.place({"body": dynmesh.Frame(0.3 * step, (0.4 + 0.2 * step, 0.5))})
        check_conforming(assembly, 2)
        carried = motion.transfer(u)
        tags = motion.transfer(tags, "overlap")
        own = assembly.points[assembly.vertices("water")]
        away = (own - former.shift) @ [[np.cos(former.angle), -np.sin(former.angle)],
                                       [np.sin(former.angle), np.cos(former.angle)]]
        free = np.abs(away).max(axis=1) > 0.1
        assert np.allclose(carried[assembly.vertices("water")][free], 1 + own[free] @ [2, 3], atol=1e-12)
        assert np.isfinite(carried).all() and carried.min() >= u.min() and carried.max() <= u.max()
        assert len(tags) == len(assembly.cells)
    assert np.median(np.sqrt(areas(assembly)[assembly.cells_of("water")])) < 0.08
    # There and back.
    assembly.place({"body": dynmesh.Frame(shift=(0.4, 0.5))})
    for a, b in zip(first, arrays(assembly)):
        assert np.array_equal(a, b)
    # Into the wall: nothing changes.
    with pytest.raises(dynmesh.DynmeshError, match="band 'water': .*touch or cross|not inside"):
        assembly.move("body", (0.05, 0.5))
    with pytest.raises(dynmesh.InvalidArgument, match="is not inside"):
        assembly.move("body", (5, 0.5))
    assert assembly.frame("body").shift == (0.4, 0.5)
    for a, b in zip(first, arrays(assembly)):
        assert np.array_equal(a, b)


def test_a_band_around_two_rotors_and_bands_in_a_row():
    left, right = circle(0.2, 24, (-0.4, 0)), circle(0.2, 24, (0.4, 0))
    outer = circle(0.8, 48)
    assembly = dynmesh.Assembly()
    for name, curve in (("left", left), ("right", right)):
        mesh = dynmesh.open(BOX)
        loops(mesh, {DISC: curve}, unsplit=True)
        assembly.add(name, mesh.part(polygons=DISC))
    assembly.add("stator", stator_around(outer))
    assembly.band("gap", outer=("stator", outer), inner=[("left", left), ("right", right)])
    check_conforming(assembly, 1.8**2)
    assembly.place({"left": dynmesh.Frame(0.3, pivot=(-0.4, 0)), "right": dynmesh.Frame(-0.3, pivot=(0.4, 0))})
    check_conforming(assembly, 1.8**2)
    with pytest.raises(dynmesh.FailedPrecondition, match="touch or cross|too near"):
        assembly.place({"left": dynmesh.Frame(shift=(0.3, 0)), "right": dynmesh.Frame(shift=(-0.3, 0))})
    assert assembly.frame("left").angle == 0.3
    with pytest.raises(dynmesh.FailedPrecondition, match="another band"):
        assembly.band("again", outer=outer * 1.05, inner=("left", left))
    assert assembly.names == ("left", "right", "stator", "gap")


def two_machines():
    assembly = dynmesh.Assembly()
    for name, x in (("first", -0.5), ("second", 0.5)):
        curve = circle(0.2, 24, (x, 0))
        mesh = dynmesh.open(BOX)
        loops(mesh, {DISC: curve}, unsplit=True)
        assembly.add(name, mesh.part(polygons=DISC))
        assembly.band(f"around {name}", circle(0.4, 48, (x, 0)), (name, curve))
    return assembly


def test_either_all_parts_are_placed_or_none():
    assembly, twin = two_machines(), two_machines()
    u = np.random.default_rng(4).random(len(assembly.cells))
    with pytest.raises(dynmesh.FailedPrecondition, match="band 'around second': its curves touch or cross"):
        assembly.place({"first": dynmesh.Frame(shift=(0.1, 0)), "second": dynmesh.Frame(shift=(0.3, 0))})
    assert assembly.frame("first") == assembly.frame("second") == dynmesh.Frame()
    for a, b in zip(arrays(assembly), arrays(twin)):
        assert np.array_equal(a, b)
    turn = {"first": dynmesh.Frame(0.1, pivot=(-0.5, 0))}
    found, expected = (each.place(turn).transfer(u, "P0") for each in (assembly, twin))
    assert np.allclose(found, expected, rtol=1e-12)


def test_an_outer_part_may_move_as_well():
    assembly, other = machine(), machine()
    assembly.place({name: dynmesh.Frame(0.5, (0.1, 0.2)) for name in ("rotor", "stator")})
    check_conforming(assembly, 1.8**2 - 0.3**2)
    assembly.place({name: dynmesh.Frame(shift=(0.5, 0)) for name in ("rotor", "stator")})
    assert np.array_equal(assembly.cells, other.cells)
    assert np.allclose(assembly.points, other.points + [0.5, 0], atol=1e-15)
    u = np.random.default_rng(3).random(len(assembly.points))
    motion = assembly.place({"stator": dynmesh.Frame(1.0, (0.5, 0))})
    check_conforming(assembly, 1.8**2 - 0.3**2)
    assert np.array_equal(motion.transfer(u), u)


def test_threads_move_one_after_another():
    assembly, expected = machine(), machine()

    def turn(seed):
        for angle in np.random.default_rng(seed).random(15):
            assembly.turn("rotor", float(angle))
            assert len(assembly.facets) == len(expected.facets)

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        list(pool.map(turn, range(4)))
    expected.turn("rotor", assembly.frame("rotor").angle)
    for a, b in zip(arrays(assembly), arrays(expected)):
        assert np.array_equal(a, b)


def test_arrays_for_files_and_solvers(tmp_path):
    assembly = machine()
    assembly.turn("rotor", 0.2)
    size = areas(assembly)
    expected = {"disc": polygon_area(circle(0.4, 40)) - 0.09, "plate": 1.8**2 - polygon_area(circle(0.6, 60)),
                "air": polygon_area(circle(0.6, 60)) - polygon_area(circle(0.4, 40))}
    for name, area in expected.items():
        assert abs(size[assembly.cell_names == name].sum() - area) < 1e-13
    assert set(assembly.cell_markers[assembly.cells_of("gap")]) == {3}
    assert np.array_equal(np.bincount(assembly.cell_parts),
                          [len(size[assembly.cells_of(name)]) for name in assembly.names])
    names = np.array(assembly.names)[assembly.facet_parts]
    assert set(names[assembly.facet_names == "bar"]) == {"rotor"}
    found = dynmesh.to_skfem(assembly)
    assert found.p.shape == (2, len(assembly.points))
    assert len(found.boundaries["bar"]) == (assembly.facet_markers == 1).sum()
    assert np.array_equal(found.subdomains["air"], np.flatnonzero(assembly.cell_names == "air"))
    out = assembly.to_meshio({"u": assembly.points[:, 0]}, {"size": size})
    assert np.array_equal(out.cells_dict["triangle"], assembly.cells)
    assert set(out.cell_sets) == {"disc", "disc edges", "plate", "plate edges", "air", "bar"}
    assembly.write(tmp_path / "a.msh", markers="input")
    read = meshio.read(tmp_path / "a.msh")
    assert {"air", "bar", "plate edges"} <= set(read.field_data)
    corners = read.points[read.cells_dict["triangle"], :2]
    marked = read.cell_data_dict["gmsh:physical"]["triangle"]
    for name, area in expected.items():
        rows = marked == read.field_data[name][0]
        assert abs((np.linalg.det(corners[rows, 1:] - corners[rows, :1]) / 2).sum() - area) < 1e-13
    dynmesh.Series(tmp_path / "s.pvd").add(0, assembly, point_data={"u": assembly.points[:, 0]})
    assert (tmp_path / "s_00000.vtu").exists()
    with pytest.raises(dynmesh.InvalidArgument, match="the assembly has"):
        assembly.to_meshio({"u": np.zeros(3)})


def test_edits_of_a_part_are_taken_by_an_update():
    assembly = machine()
    rotor = assembly.part("rotor")
    u = assembly.points[assembly.vertices("rotor"), 0]
    diff = rotor.mesh.apply(add_sizes={20_000: dict(target=0.03, at=(0.2, 0.2), radius=0.1)})
    u = rotor.transfer(diff, u)
    with pytest.raises(dynmesh.FailedPrecondition, match="call Assembly.update"):
        assembly.turn("rotor", 0.1)
    assembly.update()
    check_conforming(assembly, 1.8**2 - 0.3**2)
    assert len(assembly.points[assembly.vertices("rotor")]) == len(u)
    assembly.turn("rotor", 0.1)
    check_conforming(assembly, 1.8**2 - 0.3**2)


INNER, OUTER = circle(0.4, 40), circle(0.6, 60)


@pytest.mark.parametrize("outer, inner, error, text", [
    (("stator", OUTER), ("rotor", INNER[:30]), dynmesh.InvalidArgument, "does not close"),
    (("stator", OUTER), ("rotor", INNER[::2]), dynmesh.InvalidArgument, "no edge of the curve"),
    (("stator", OUTER), ("rotor", np.delete(INNER, 7, axis=0)), dynmesh.InvalidArgument,
     "not joined by an edge"),
    (("stator", OUTER), ("rotor", 0.9 * INNER), dynmesh.InvalidArgument, "no vertex at .* nearest is"),
    (("rotor", INNER), ("stator", OUTER), dynmesh.InvalidArgument, "on the side of its curve"),
    (("stator", OUTER), circle(0.2, 20, (0.9, 0)), dynmesh.InvalidArgument, "not inside"),
    (("stator", OUTER), circle(0.3, 20, (0.4, 0.1)), dynmesh.FailedPrecondition, "touch or cross"),
    (("stator", OUTER), circle(0.59, 10), dynmesh.FailedPrecondition, "smaller spacing|touch or cross"),
    (("stator", OUTER), [circle(0.3, 20), circle(0.1, 20)], dynmesh.InvalidArgument, "one inside the other"),
    (("stator", OUTER), INNER[:2], dynmesh.InvalidArgument, "three points"),
    (("stator", OUTER), np.vstack([INNER, INNER]), dynmesh.InvalidArgument, "more than once"),
    (("stator", OUTER), np.ones((4, 3)), dynmesh.InvalidArgument, "two dimensions"),
    (("stator", OUTER), "rotor", dynmesh.InvalidArgument, r"\(name of the part, curve\)"),
    (("motor", OUTER), INNER, dynmesh.NotFound, "no part 'motor'; parts are: rotor, stator"),
])
def test_what_is_wrong_with_a_band(outer, inner, error, text):
    assembly = dynmesh.Assembly()
    assembly.add("rotor", rotor_in(INNER))
    assembly.add("stator", stator_around(OUTER))
    with pytest.raises(error, match=text) as refusal:
        assembly.band("gap", outer, inner)
    assert "gap" in str(refusal.value) or error is dynmesh.NotFound
    assert assembly.names == ("rotor", "stator")
    assembly.band("gap", ("stator", OUTER[::-1]), ("rotor", np.vstack([INNER, INNER[:1]])))
    check_conforming(assembly, 1.8**2 - 0.3**2)


def test_a_curve_that_is_split_is_named():
    mesh = dynmesh.open(BOX)
    loops(mesh, {DISC: INNER}, add_sizes={20_000: dict(target=0.02, at=(0.4, 0), radius=0.2)})
    assembly = dynmesh.Assembly()
    assembly.add("rotor", mesh.part(polygons=DISC))
    with pytest.raises(dynmesh.InvalidArgument, match="mark the curve unsplit"):
        assembly.band("gap", OUTER, ("rotor", INNER))


def test_other_arguments():
    assembly = machine()
    with pytest.raises(dynmesh.AlreadyExists, match="'gap' already"):
        assembly.add("gap", assembly.part("rotor"))
    with pytest.raises(dynmesh.NotFound, match="no part 'gap'"):
        assembly.turn("gap", 1)
    with pytest.raises(dynmesh.NotFound, match="no part or band 'none'"):
        assembly.vertices("none")
    with pytest.raises(dynmesh.InvalidArgument, match="finite"):
        assembly.turn("rotor", np.nan)
    with pytest.raises(dynmesh.InvalidArgument, match="spacing"):
        assembly.band("b", OUTER, INNER, spacing=0)
    with pytest.raises(dynmesh.InvalidArgument, match="a label is"):
        assembly.band("b", OUTER, INNER, label=dict(colour=3))
    motion = assembly.turn("rotor", 0.1)
    for u, kind, text in ((np.zeros(3), "P1", "a row for each vertex"), (np.zeros(3), "P0", "for each cell"),
                          (np.zeros(3), "DG1", "carries 'P1'")):
        with pytest.raises(ValueError, match=text):
            motion.transfer(u, kind)
    with pytest.raises(ValueError, match="two components"):
        motion.transfer(np.zeros(len(assembly.points)), vectors=True)
    space = dynmesh.open(box=[[0, 0, 0], [1, 1, 1]])
    with pytest.raises(dynmesh.InvalidArgument, match="two dimensions"):
        assembly.add("ball", space.part())
    assert "gap" in repr(assembly) and "rotor" in repr(motion)
