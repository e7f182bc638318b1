"""Parts of meshes in the shapes that packages of finite elements take."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from dynmesh._types import Array
from dynmesh.errors import FailedPrecondition

if TYPE_CHECKING:
    from dynmesh._assembly import Assembly
    from dynmesh._part import Part


@dataclass(frozen=True)
class SkfemArrays:
    """A part for scikit-fem."""

    p: Array  #: Coordinates: (dimension, vertices), in the order of `Part.points`.
    t: Array  #: Corners: (dimension + 1, cells), in the order of `Part.cells`.
    #: By name of features: numbers of their facets. Those are scikit-fem's own, of all facets in
    #: the order of their ascending vertices.
    boundaries: dict[str, Array]
    subdomains: dict[str, Array]  #: By name of polygons: numbers of the cells in their own region.


@dataclass(frozen=True)
class DolfinxMesh:
    """A part for DOLFINx, which has its own numbers."""

    mesh: Any  #: A `dolfinx.mesh.Mesh`, of this process alone.
    cell_tags: Any  #: Of all cells: the marker of the polygon whose own region it is; else 0.
    facet_tags: Any  #: Of the part's facets: the marker of their feature; 0 without one.
    vertices: Array  #: For each node of the mesh's geometry the number of the part's vertex.
    cells: Array  #: For each cell of the mesh the number of the part's.


@dataclass(frozen=True)
class DmplexMesh:
    """A part for PETSc: points of the mesh are cells first, then vertices, then edges and faces."""

    #: A `petsc4py.PETSc.DMPlex` of this process alone. Its cell `i` is the part's. Its labels "Cell
    #: Sets" and "Face Sets" are the markers of cells and facets other than 0, as PETSc reads files.
    dm: Any
    vertices: range  #: The points of the part's vertices, in their order.
    facets: Array  #: For each facet of the part its point.


def to_skfem(part: Union[Part, Assembly]) -> SkfemArrays:
    """The part as arrays for scikit-fem, which is not needed for that. O(part).

    A mesh of it is `skfem.MeshTri(arrays.p, arrays.t)`, in 3D `MeshTet`, then
    `.with_boundaries(arrays.boundaries).with_subdomains(arrays.subdomains)`. A boundary is all facets
    of the features with that name, within the part, too. Of a part that is opened, it is both sides:
    `part.facet_sides` tells them apart. Values at vertices are in the order of the part's.

    Own regions are as in files: of a plate with an inclusion the plate's is what is beside it.
    """
    d = part.points.shape[1]
    cells = part.cells
    faces = np.sort(np.concatenate([np.delete(cells, k, axis=1) for k in range(d + 1)]), axis=1)
    numbers = _rows_in(np.unique(faces, axis=0), np.sort(part.facets, axis=1))
    names = part.facet_names.astype(str)
    regions = part._region_labels()
    inside = np.array([regions[int(id_)][1].name for id_ in part.cell_regions], dtype=str)
    return SkfemArrays(
        np.ascontiguousarray(part.points.T), np.ascontiguousarray(cells.T).astype(np.int64),
        {str(name): np.unique(numbers[names == name]) for name in np.unique(names) if name},
        {str(name): np.flatnonzero(inside == name) for name in np.unique(inside) if name})


def to_dolfinx(part: Union[Part, Assembly]) -> DolfinxMesh:
    """The part as a mesh of DOLFINx, with tags of cells and facets. O(part).

    For version 0.5, Debian's `python3-dolfinx`. With `found = dynmesh.to_dolfinx(part)` integrals are
    over `ufl.Measure("dx", found.mesh, subdomain_data=found.cell_tags)` and "ds" or "dS" with
    `found.facet_tags`. Values at vertices are `u[found.vertices]` in the order of its geometry, and
    brought back by `u[found.vertices] = values`. The faces of what is opened are at the border, "ds",
    both with the feature's marker. Raises `ModuleNotFoundError` where DOLFINx is not installed, and
    `FailedPrecondition` for a part without cells.
    """
    import dolfinx
    import ufl
    from mpi4py import MPI

    d = part.points.shape[1]
    if not len(part.cells):
        raise FailedPrecondition("the part has no cells, and a mesh of DOLFINx needs some")
    shape = "triangle" if d == 2 else "tetrahedron"
    mesh = dolfinx.mesh.create_mesh(MPI.COMM_SELF, part.cells.astype(np.int64), part.points,
                                    ufl.Mesh(ufl.VectorElement("Lagrange", shape, 1)))
    mesh.topology.create_connectivity(d - 1, 0)
    mesh.topology.create_connectivity(d - 1, d)
    # It renumbers cells and vertices for locality; these arrays have the numbers of the part.
    nodes = np.array(mesh.geometry.input_global_indices)
    cells = np.array(mesh.topology.original_cell_index)
    regions = part._region_labels()
    markers = np.array([regions[int(id_)][1].marker for id_ in part.cell_regions[cells]], np.int32)
    cell_tags = dolfinx.mesh.meshtags(mesh, d, np.arange(len(cells), dtype=np.int32), markers)
    # Vertices of the topology have numbers of their own again.
    vertices = np.zeros(len(nodes), np.int64)
    vertices[mesh.topology.connectivity(d, 0).array] = nodes[mesh.geometry.dofmap.array]
    facets = np.sort(vertices[mesh.topology.connectivity(d - 1, 0).array].reshape(-1, d), axis=1)
    # A facet of the part is there once, but of a crack without a vertex between its tips.
    mine, first = np.unique(np.sort(part.facets, axis=1), axis=0, return_index=True)
    order = np.lexsort(facets.T[::-1])
    marked = order[_rows_in(facets[order], mine)]
    rank = np.argsort(marked)
    facet_tags = dolfinx.mesh.meshtags(mesh, d - 1, marked[rank].astype(np.int32),
                                       part.facet_markers[first[rank]].astype(np.int32))
    return DolfinxMesh(mesh, cell_tags, facet_tags, nodes, cells)


def to_dmplex(part: Union[Part, Assembly]) -> DmplexMesh:
    """The part as a `DMPlex` of PETSc, with its edges and faces, and markers as labels. O(part).

    For petsc4py 3.18, Debian's. `found.dm.getStratumIS("Face Sets", 7)` are the facets of features
    with marker 7. The two sides of what is opened are different facets, both with the feature's
    marker. Raises `ModuleNotFoundError` where petsc4py is not installed, and `FailedPrecondition`
    for a part without cells.
    """
    from petsc4py import PETSc

    if not len(part.cells):
        raise FailedPrecondition("the part has no cells, and a DMPlex needs some")
    dm = PETSc.DMPlex().createFromCellList(
        part.points.shape[1], part.cells.astype(PETSc.IntType), part.points, interpolate=True,
        comm=PETSc.COMM_SELF)
    count = len(part.cells)
    joined = part.facets + count
    if part.points.shape[1] == 3:  # a face is where its edges meet
        joined = np.array([[dm.getJoin([a, b])[0], dm.getJoin([b, c])[0]]
                           for a, b, c in joined.tolist()], np.int64)
    facets = np.array([dm.getJoin(pair)[0] for pair in joined.tolist()], np.int64)
    regions = part._region_labels()
    dm.createLabel("Cell Sets")
    for cell, region in enumerate(part.cell_regions.tolist()):
        if regions[region][1].marker:
            dm.setLabelValue("Cell Sets", cell, regions[region][1].marker)
    dm.createLabel("Face Sets")
    for facet, marker in zip(facets.tolist(), part.facet_markers.tolist()):
        if marker:
            dm.setLabelValue("Face Sets", facet, marker)
    return DmplexMesh(dm, range(count, count + len(part.points)), facets)


def _rows_in(table: Array, rows: Array) -> Array:
    """Where each of the rows is in a table of all of them in ascending order, none twice."""
    if not len(rows):
        return np.empty(0, np.int64)
    _, where = np.unique(np.concatenate([table, rows]), axis=0, return_inverse=True)
    found: Array = where.reshape(-1)[len(table):]
    return found
