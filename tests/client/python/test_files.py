"""Features from files."""
import pytest

import dynmesh

FRAME = ("8 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n5 .4 .4\n6 .6 .4\n7 .6 .6\n8 .4 .6\n"
         "8 1\n1 1 2 5\n2 2 3 0\n3 3 4 0\n4 4 1 0\n5 5 6 0\n6 6 7 0\n7 7 8 0\n8 8 5 0\n1\n1 .5 .5\n")
MAP = '{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [0, 1], [0, 0]]]}'
SIZES = ("mesh dim=3 box=0,0,0,4,4,4 rho=2.5\nadd point 1 1 1 1\nadd point 2 3 1 1\n"
         "add point 3 1 3 1\nadd polygon 4 1 2 3\nadd size 5 disc 2 2 2 1 .5\nname 4 wall\n")


def test_a_file_becomes_a_mesh(tmp_path):
    (tmp_path / "f.poly").write_text(FRAME)
    frame = dynmesh.read_input(tmp_path / "f.poly")
    assert frame.options["dimension"] == 2 and frame.holes == [(0.5, 0.5)]
    assert frame.edits["add_segments"][9] == (1, 2) and frame.edits["set_labels"][9].marker == 5
    assert frame.places[9].endswith("f.poly:11") and frame.warnings == []
    mesh = dynmesh.open(**frame.options)
    mesh.apply(**frame.edits)
    assert len(mesh.features()) == 16 and mesh.labels[9].marker == 5


def test_each_kind_of_feature_is_an_edit(tmp_path):
    (tmp_path / "s.dynmesh").write_text(SIZES)
    script = dynmesh.read_input(str(tmp_path / "s.dynmesh"))
    assert script.options["rho"] == 2.5
    mesh = dynmesh.open(**script.options)
    mesh.apply(**script.edits)
    assert {f["kind"] for f in mesh.features()} == {"point", "polygon", "size"}
    assert mesh.labels[4].name == "wall"


def test_a_map_has_polygons_on_request(tmp_path):
    (tmp_path / "m.geojson").write_text(MAP)
    assert "add_polygons" not in dynmesh.read_input(tmp_path / "m.geojson").edits
    assert len(dynmesh.read_input(tmp_path / "m.geojson", polygons=True).edits["add_polygons"]) == 1


def test_flat_faces_are_one_unless_they_are_kept(tmp_path):
    (tmp_path / "s.off").write_text("OFF\n5 3 0\n0 0 1.10000\n2 0 1.1\n2 3 1.2\n0 3 1.20001\n1 1 3\n"
                                    "3 0 1 2\n3 0 2 3\n3 0 1 4\n")
    joined = dynmesh.read_input(tmp_path / "s.off")
    assert len(joined.edits["add_polygons"]) == 2
    assert "2 faces joined into 1 polygon(s)" in joined.warnings[0]
    kept = dynmesh.read_input(tmp_path / "s.off", keep_facets=True)
    assert len(kept.edits["add_polygons"]) == 3 and kept.warnings == []
    mesh = dynmesh.open(**joined.options)
    mesh.apply(**joined.edits)


def test_errors_name_line_and_formats(tmp_path):
    (tmp_path / "bad.node").write_text("1 2 0 0\n1 0 zero\n")
    with pytest.raises(dynmesh.InvalidArgument, match=r"bad\.node:2: "):
        dynmesh.read_input(tmp_path / "bad.node")
    with pytest.raises(dynmesh.InvalidArgument, match=r"\.node, \.poly.* or \.dynmesh"):
        dynmesh.read_input(tmp_path / "a.xyz")
    with pytest.raises(dynmesh.NotFound):
        dynmesh.read_input(tmp_path / "none.off")


def test_a_surface_that_a_mesh_refuses_is_mended(tmp_path):
    """Two boxes that cross; a crack of a millionth; and a box that needs nothing."""
    def box(lo, hi, top=None):
        corners = [[hi if i >> k & 1 else lo for k in range(3)] for i in range(8)]
        faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        if top is not None:
            faces[1] = [8, 9, 11, 10]
            corners += [[x, y, top] for x, y, _ in corners[4:]]
        return corners, faces

    def write(name, *boxes):
        points = [point for corners, _ in boxes for point in corners]
        lines, first = [], 0
        for corners, faces in boxes:
            lines += ["4 " + " ".join(str(first + c) for c in face) for face in faces]
            first += len(corners)
        (tmp_path / name).write_text(
            f"OFF\n{len(points)} {len(lines)} 0\n"
            + "\n".join(" ".join(map(repr, point)) for point in points) + "\n"
            + "\n".join(lines) + "\n")
        return tmp_path / name

    sound = write("sound.off", box(0.0, 1.0))
    read = dynmesh.read_surface(sound)
    assert not read.preparation["mended"]
    assert read.edits == dynmesh.read_input(sound).edits
    crossing = write("crossing.off", box(0.0, 1.0), box(0.5, 1.5))
    with pytest.raises(dynmesh.DynmeshError):
        plain = dynmesh.read_input(crossing)
        dynmesh.open(**plain.options).apply(**plain.edits)
    assert read.facets == []
    facets = dynmesh.read_surface(sound, facets=True).facets
    assert sorted(facets) == sorted(read.edits["add_polygons"])
    mended = dynmesh.read_surface(crossing)
    assert mended.preparation["mended"] and mended.preparation["found"]
    assert mended.preparation["farthest"] <= mended.preparation["within"]
    dynmesh.open(**mended.options).apply(**mended.edits)
    crack = dynmesh.read_surface(write("crack.off", box(0.0, 1.0, 1.000001)))
    assert (crack.preparation["open_edges_read"], crack.preparation["open_edges"]) == (8, 0)
    points, lines = box(0.0, 1.0)
    open_box = write("open.off", (points, lines[:-1]))
    assert [loop["length"] for loop in dynmesh.read_surface(open_box).preparation["open_loops"]] == [4]
    filled = dynmesh.read_surface(open_box, fill_holes=4)
    assert filled.preparation["open_loops"] == [] and filled.preparation["open_edges"] == 0
    assert filled.preparation["changes"]["hole filled"] == 1
    with pytest.raises(dynmesh.InvalidArgument):
        dynmesh.read_surface(crossing, within=-1.0)
    # What is accepted is mended with a tolerance that is asked for: here corners 1e-5 apart become one.
    points, lines = box(0.0, 1.0)
    near = write("near.off", (points, lines), box(1.00001, 2.0))
    larger = dynmesh.read_surface(near).preparation["larger_tolerance"]
    assert larger == pytest.approx(0.1 * dynmesh.read_surface(near).preparation["within"])
    merged = dynmesh.read_surface(near, mending_tolerance=larger).preparation
    assert merged["mended"] and merged["tolerance"] >= larger
    most = dynmesh.read_surface(near, mending_tolerance=merged["within"]).preparation
    assert most["tolerance"] == most["within"] and most["larger_tolerance"] is None
    with pytest.raises(dynmesh.InvalidArgument):
        dynmesh.read_surface(near, mending_tolerance=0.0)
    tried = dynmesh.read_surface(crossing, try_mesh=True)
    assert tried.edits == mended.edits and tried.preparation["attempts"] == []
    assert tried.preparation["least_tolerance"] is None


def test_a_surface_whose_mesh_is_too_fine_is_mended_more(tmp_path):
    path = tmp_path / "needle.off"
    path.write_text("""OFF
6 8 0
0.05685775 0.0002748734 -2.727833e-05
-0.06876524 0.02404099 4.281872e-05
-0.07475285 0.0003367258 -2.022409e-06
-0.04555911 -0.01938796 -3.444687e-05
-0.138661 -0.008725009 2.689457e-05
-0.079188 -0.005978653 1
3 0 1 4
3 1 0 5
3 1 2 4
3 2 1 5
3 2 3 4
3 3 2 5
3 3 0 4
3 0 3 5
""")
    tried = dynmesh.read_surface(path, try_mesh=True)
    assert "; tried again with --mending-tolerance " in tried.preparation["attempts"][0]
    mesh = dynmesh.open(**{**tried.options, "max_vertices": 100_000})
    mesh.load(**tried.edits)
    least = tried.preparation["least_tolerance"]
    assert dynmesh.read_surface(path, mending_tolerance=least).edits == tried.edits
