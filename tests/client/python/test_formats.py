"""Markers and names in files: what docs/fields.md's table says survives, for readers of others."""
import os
import pathlib
import shutil
import subprocess

import numpy as np
import pytest

import dynmesh


def plate():
    """With an inclusion, a side of its own, and a crack."""
    mesh = dynmesh.open(box=[[0, 0], [2, 1]], max_edge=0.2)
    mesh.apply(add_points={1: (0, 0), 2: (2, 0), 4: (2, 1), 5: (0, 1), 11: (0.4, 0.4),
                           12: (0.6, 0.4), 13: (0.6, 0.6), 14: (0.4, 0.6), 15: (1, 0.5),
                           16: (1.5, 0.5)},
               add_polygons={7: (1, 2, 4, 5), 8: (11, 12, 13, 14)},
               add_segments={9: (5, 1), 20: (15, 16)},
               set_labels={7: dict(marker=11, name="plate"), 8: dict(marker=12, name="inclusion"),
                           9: dict(marker=13, name="left"), 20: dict(marker=14, name="crack")})
    return mesh.part()


def room():
    """With a door, around a ball that is a box."""
    mesh = dynmesh.open(box=[[0] * 3, [1] * 3])
    corners = {1 + i: [i >> k & 1 for k in range(3)] for i in range(8)}
    corners |= {11 + i: [0.4 + 0.2 * (i >> k & 1) for k in range(3)] for i in range(8)}
    faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    mesh.apply(add_points=corners,
               add_polygons={first + i: [corner + c for c in face] for first, corner in
                             ((20, 1), (30, 11)) for i, face in enumerate(faces)},
               set_labels={**{20 + i: dict(marker=11, name="walls") for i in range(5)},
                           25: dict(marker=12, name="door"),
                           **{30 + i: dict(marker=13, name="ball") for i in range(6)}})
    return mesh.part()


# By marker: sizes of cells, and of facets. By name, where files have names.
MARKERS = {plate: ({11: 1.96, 12: 0.04}, {11: 5, 12: 0.8, 13: 1, 14: 0.5}),
           room: ({11: 0.992, 13: 0.008}, {11: 5, 12: 1, 13: 0.24})}
NAMES = {plate: {"plate": 1.96, "inclusion": 0.04, "plate edges": 5, "inclusion edges": 0.8,
                 "left": 1, "crack": 0.5},
         room: {"ball": 0.008, "ball faces": 0.24, "walls": 5, "door": 1}}
FACETS, CELLS = {plate: "line", room: "triangle"}, {plate: "triangle", room: "tetra"}


def sizes(points, corners):
    edges = points[corners[:, 1:]] - points[corners[:, :1]]
    squares = np.linalg.det(edges @ edges.transpose(0, 2, 1))
    return np.sqrt(squares) / {1: 1, 2: 2, 3: 6}[edges.shape[1]]


def by_marker(read, kind, key):
    found = {}
    for block, markers in zip(read.cells, read.cell_data[key]):
        if block.type == kind:
            each = sizes(read.points, block.data)
            for marker in np.unique(markers).tolist():
                found[marker] = found.get(marker, 0) + each[markers == marker].sum()
    return found


def check_markers(make, read, key):
    for kind, expected in zip((CELLS[make], FACETS[make]), MARKERS[make]):
        assert by_marker(read, kind, key) == pytest.approx(expected), kind


def check_names(make, found):
    """Sizes by name; there may be more names, of points, edges in 3D and what has none."""
    assert {name: found.get(name) for name in NAMES[make]} == pytest.approx(NAMES[make])


def check_integrals(make, mesh, cells, facets):
    """By DOLFINx: what has a marker is as large as it should be."""
    import dolfinx
    import ufl
    one = dolfinx.fem.Constant(mesh, 1.0)

    def integral(measure, tags, marker):
        form = dolfinx.fem.form(one * ufl.Measure(measure, mesh, subdomain_data=tags)(marker))
        return dolfinx.fem.assemble_scalar(form)

    for marker, expected in MARKERS[make][0].items():
        assert integral("dx", cells, marker) == pytest.approx(expected)
    for marker, expected in MARKERS[make][1].items():
        assert integral("ds", facets, marker) + integral("dS", facets, marker) == pytest.approx(
            expected)


@pytest.mark.parametrize("make", [plate, room])
@pytest.mark.parametrize("name,version,key,binary", [
    ("m.msh", 4.1, "gmsh:physical", False), ("m.msh", 2.2, "gmsh:physical", False),
    ("m.msh", 4.1, "gmsh:physical", True), ("m.msh", 2.2, "gmsh:physical", True),
    ("m.mesh", 4.1, "medit:ref", False), ("m.vtu", 4.1, "marker", False)])
def test_a_written_file_has_markers_and_names(make, name, version, key, binary, tmp_path):
    meshio = pytest.importorskip("meshio", reason="python3-meshio is not installed")
    part = make()
    part.write(tmp_path / name, markers="input", msh_version=version, binary=binary)
    read = meshio.read(tmp_path / name)
    check_markers(make, read, key)
    if name == "m.msh":
        # Names by marker and dimension; a name stands for one dimension.
        d = part.mesh.dimension
        kinds = {d: CELLS[make], d - 1: FACETS[make]}
        check_names(make, {group: by_marker(read, kinds[of], key)[marker]
                           for group, (marker, of) in read.field_data.items() if of in kinds})
    if name == "m.vtu":
        labels = part.mesh.labels
        for group in {label.name for label in labels.values()}:
            assert set(read.field_data[group].tolist()) == {
                id_ for id_, label in labels.items() if label.name == group}
    if name == "m.mesh":
        comments = [line for line in (tmp_path / name).read_text().splitlines() if line[:1] == "#"]
        for label in part.mesh.labels.values():
            assert f"# marker {label.marker}: {label.name}" in comments


@pytest.mark.parametrize("make", [plate, room])
@pytest.mark.parametrize("version", [4.1, 2.2])
def test_a_binary_msh_is_the_text_to_the_bit(make, version, tmp_path):
    meshio = pytest.importorskip("meshio", reason="python3-meshio is not installed")
    part = make()
    read, inputs = [], []
    for binary in (False, True):
        part.write(tmp_path / "m.msh", markers="input", msh_version=version, binary=binary)
        read.append(meshio.read(tmp_path / "m.msh"))
        inputs.append(dynmesh.read_input(tmp_path / "m.msh"))
    text, same = read
    np.testing.assert_array_equal(text.points, same.points)
    assert {name: rows.tolist() for name, rows in text.field_data.items()} == {
        name: rows.tolist() for name, rows in same.field_data.items()}
    for kind, rows in text.cells_dict.items():
        np.testing.assert_array_equal(rows, same.cells_dict[kind])
        np.testing.assert_array_equal(text.cell_data_dict["gmsh:physical"][kind],
                                      same.cell_data_dict["gmsh:physical"][kind])
    features, same = inputs  # as input
    assert features.edits == same.edits
    assert ({"left", "crack"} if make is plate else {"walls", "door"}) <= {
        label.name for label in same.edits["set_labels"].values()}


@pytest.mark.parametrize("make", [plate, room])
@pytest.mark.parametrize("name,version,key", [
    ("m.msh", 4.1, "gmsh:physical"), ("m.msh", 2.2, "gmsh:physical"), ("m.mesh", 4.1, "medit:ref"),
    ("m.vtu", 4.1, "marker")])
def test_what_is_opened_has_both_sides_in_a_file(make, name, version, key, tmp_path):
    meshio = pytest.importorskip("meshio", reason="python3-meshio is not installed")
    closed = make()
    features = 20 if make is plate else [30 + i for i in range(6)]
    part = closed.mesh.part(open=features)
    part.write(tmp_path / name, markers="input", msh_version=version)
    read = meshio.read(tmp_path / name)
    assert len(read.points) == len(part.points) > len(closed.points)
    cells, facets = (dict(each) for each in MARKERS[make])
    opened = 14 if make is plate else 13
    facets[opened] *= 2
    assert by_marker(read, CELLS[make], key) == pytest.approx(cells)
    assert by_marker(read, FACETS[make], key) == pytest.approx(facets)
    # The two sides have no vertex in common, but for the tips of the crack.
    rows = np.concatenate([block.data[markers == opened] for block, markers in
                           zip(read.cells, read.cell_data[key]) if block.type == FACETS[make]])
    places, which = np.unique(read.points[np.unique(rows)], axis=0, return_counts=True)
    assert sorted(set(which.tolist())) == ([1, 2] if make is plate else [2])
    assert (which == 1).sum() == (2 if make is plate else 0)


@pytest.mark.parametrize("is_open", [False, True])
@pytest.mark.parametrize("binary", [False, True])
def test_the_command_writes_the_same_files(is_open, binary, tmp_path):
    command = pathlib.Path(os.environ["DYNMESHD"]).with_name("dynmesh")
    script = tmp_path / "plate.dynmesh"
    script.write_text("""mesh dim=2 box=0,0,2,1 hmax=0.2
add point 1 0 0
add point 2 2 0
add point 3 2 1
add point 4 0 1
add point 5 0.5 0.5
add point 6 1 0.5
add point 7 1.5 0.6
add polygon 10 1 2 3 4
add segment 20 5 6
add segment 21 6 7
commit
""")
    read = dynmesh.read_input(script)
    mesh = dynmesh.open(**read.options)
    mesh.apply(**read.edits)
    part = mesh.part(polygons=10, open=[20, 21] if is_open else ())
    flags = ["--open", "20,21"] if is_open else []
    for name in ("a.msh", "a.node"):
        part.write(tmp_path / name, binary=binary)
    subprocess.run([command, "mesh", script, "--region", "10", *flags,
                    *(["--binary"] if binary else []), "-o", tmp_path / "b.msh",
                    "-o", tmp_path / "b.node"], check=True, timeout=100)
    for kind in ("msh", "node", "ele", "edge"):
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes(), kind


@pytest.mark.parametrize("make", [plate, room])
@pytest.mark.parametrize("name,key", [
    ("m.xdmf", "marker"), ("m.vtu", "marker"), ("m.vtk", "marker"), ("m.mesh", "medit:ref"),
    ("m.med", "marker"), ("m.inp", None)])
@pytest.mark.filterwarnings("ignore")
def test_meshio_writes_markers_or_names(make, name, key, tmp_path):
    meshio = pytest.importorskip("meshio", reason="python3-meshio is not installed")
    if name in ("m.xdmf", "m.med"):
        pytest.importorskip("h5py", reason="python3-h5py is not installed")
    part = make()
    mesh = part.to_meshio()
    check_markers(make, mesh, "marker")
    kinds = CELLS[make], FACETS[make]
    check_names(make, {group: sum(sizes(part.points, block.data[rows]).sum()
                                  for block, rows in zip(mesh.cells, of_blocks))
                       for group, of_blocks in mesh.cell_sets.items()})
    mesh.write(tmp_path / name)
    read = meshio.read(tmp_path / name)
    if key:
        check_markers(make, read, key)
    else:
        found = {group: sum(sizes(read.points, block.data[rows]).sum()
                            for block, rows in zip(read.cells, of_blocks) if len(rows))
                 for group, of_blocks in read.cell_sets.items()}
        check_names(make, found)
        assert [block.type for block in read.cells] == list(kinds)


@pytest.mark.parametrize("make", [plate, room])
@pytest.mark.parametrize("version", [4.1, 2.2])
@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.filterwarnings("ignore")
def test_gmsh_and_dolfinx_read_msh(make, version, binary, tmp_path):
    gmsh = pytest.importorskip("gmsh", reason="python3-gmsh is not installed")
    part = make()
    part.write(tmp_path / "m.msh", markers="input", msh_version=version, binary=binary)
    d = part.mesh.dimension
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / "m.msh"))
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        points = np.zeros((int(tags.max()) + 1, 3))
        points[tags.astype(int)] = coordinates.reshape(-1, 3)
        found = {}
        for of, marker in gmsh.model.getPhysicalGroups():
            if of < d - 1:
                continue
            name = gmsh.model.getPhysicalName(of, marker)
            for entity in gmsh.model.getEntitiesForPhysicalGroup(of, marker):
                for nodes in gmsh.model.mesh.getElements(of, entity)[2]:
                    each = sizes(points, nodes.reshape(-1, of + 1).astype(int))
                    found[of, marker, name] = found.get((of, marker, name), 0) + each.sum()
        for of, expected in zip((d, d - 1), MARKERS[make]):
            assert {marker: size for (dim, marker, _), size in found.items()
                    if dim == of} == pytest.approx(expected)
        check_names(make, {name: size for (_, _, name), size in found.items()})
        dolfinx = pytest.importorskip("dolfinx", reason="python3-dolfinx is not installed")
        import dolfinx.io.gmshio
        from mpi4py import MPI
        mesh, cells, facets = dolfinx.io.gmshio.model_to_mesh(gmsh.model, MPI.COMM_SELF, 0, gdim=d)
    finally:
        gmsh.finalize()
    check_integrals(make, mesh, cells, facets)


@pytest.mark.parametrize("make", [plate, room])
@pytest.mark.filterwarnings("ignore")
def test_meshio_writes_only_cells_as_su2(make, tmp_path):
    """meshio 5.0 fails on borders: an error of its own. It then has the cells, and no markers."""
    meshio = pytest.importorskip("meshio", reason="python3-meshio is not installed")
    mesh = make().to_meshio()
    if meshio.__version__.startswith("5.0"):
        with pytest.raises(TypeError):
            mesh.write(tmp_path / "m.su2")
    meshio.Mesh(mesh.points, mesh.cells[:1]).write(tmp_path / "m.su2")
    read = meshio.read(tmp_path / "m.su2")
    np.testing.assert_array_equal(read.points, mesh.points)
    np.testing.assert_array_equal(read.cells[0].data, mesh.cells[0].data)


@pytest.mark.parametrize("make", [plate, room])
@pytest.mark.filterwarnings("ignore")
def test_dolfinx_reads_xdmf_of_cells_and_of_facets(make, tmp_path):
    meshio = pytest.importorskip("meshio", reason="python3-meshio is not installed")
    pytest.importorskip("h5py", reason="python3-h5py is not installed")
    dolfinx = pytest.importorskip("dolfinx", reason="python3-dolfinx is not installed")
    import dolfinx.io
    from mpi4py import MPI
    written = make().to_meshio()
    for which, name in enumerate(("cells", "facets")):  # DOLFINx reads cells of one kind
        meshio.Mesh(written.points, [written.cells[which]],
                    cell_data={"marker": [written.cell_data["marker"][which]]}).write(
                        tmp_path / f"{name}.xdmf")
    with dolfinx.io.XDMFFile(MPI.COMM_SELF, str(tmp_path / "cells.xdmf"), "r") as file:
        mesh = file.read_mesh(name="Grid")
        cells = file.read_meshtags(mesh, name="Grid")
    d = mesh.topology.dim
    mesh.topology.create_entities(d - 1)
    mesh.topology.create_connectivity(d - 1, d)
    with dolfinx.io.XDMFFile(MPI.COMM_SELF, str(tmp_path / "facets.xdmf"), "r") as file:
        facets = file.read_meshtags(mesh, name="Grid")
    check_integrals(make, mesh, cells, facets)


@pytest.mark.parametrize("make", [plate, room])
def test_freefem_reads_mesh(make, tmp_path):
    if not shutil.which("FreeFem++"):
        pytest.skip("freefem++ is not installed")
    make().write(tmp_path / "m.mesh", markers="input")
    cells, facets = MARKERS[make]
    space = make is room
    of_cells, of_facets = ("int3d", "int2d") if space else ("int2d", "int1d")
    lines = ['mesh3 Th("m.mesh");' if space else 'mesh Th = readmesh("m.mesh");',
             "cout.precision(12);"]
    lines += [f'cout << "cells {m} " << {of_cells}(Th, {m})(1.) << endl;' for m in cells]
    lines += [f'cout << "facets {m} " << {of_facets}(Th, {m})(1.) << endl;' for m in facets]
    (tmp_path / "m.edp").write_text("\n".join(lines) + "\n")
    run = subprocess.run(["FreeFem++", "-nw", "-v", "0", "m.edp"], cwd=tmp_path, text=True,
                         capture_output=True, timeout=100)
    found = {tuple(words[:2]): float(words[2]) for words in map(str.split, run.stdout.splitlines())
             if len(words) == 3 and words[0] in ("cells", "facets")}
    assert found == pytest.approx({
        **{("cells", str(m)): size for m, size in cells.items()},
        **{("facets", str(m)): size for m, size in facets.items()}}), run.stdout + run.stderr
