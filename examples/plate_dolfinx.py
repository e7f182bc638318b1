#!/usr/bin/env python3
"""Heat conduction with DOLFINx (0.5, Debian's python3-dolfinx) on a mesh that changes.

    examples/plate_dolfinx.py [--edge 0.03] [--out out/plate_dolfinx] [--server HOST:PORT]

A disc moves and a wire grows in a plate. After each edit DOLFINx gets the present mesh from arrays,
regions as cell tags and features as facet tags, with the transferred temperature. Writes a series
for ParaView; plate.py, shared by all packages, describes the checks.
"""
from __future__ import annotations

import logging

import numpy as np

import plate

try:
    import dolfinx
    import ufl
    from dolfinx import fem
    from dolfinx.fem.petsc import LinearProblem
    from mpi4py import MPI
except ModuleNotFoundError:
    plate.missing("python3-dolfinx")


def read(part: plate.Part) -> tuple[dolfinx.mesh.Mesh, dolfinx.mesh.MeshTags, dolfinx.mesh.MeshTags,
                                    np.ndarray]:
    """The mesh, tags of cells and facets, and the part's vertex of each of its nodes."""
    triangle = ufl.Mesh(ufl.VectorElement("Lagrange", "triangle", 1))
    mesh = dolfinx.mesh.create_mesh(MPI.COMM_SELF, part.cells.astype(np.int64), part.points,
                                    triangle)
    mesh.topology.create_connectivity(1, 0)
    mesh.topology.create_connectivity(1, 2)
    # DOLFINx renumbers cells and vertices for locality; these arrays have the original numbers.
    nodes = np.array(mesh.geometry.input_global_indices)
    cells = mesh.topology.original_cell_index
    cell_tags = dolfinx.mesh.meshtags(mesh, 2, np.arange(len(cells), dtype=np.int32),
                                      part.cell_markers[cells].astype(np.int32))

    vertices = np.zeros(len(nodes), np.int64)  # of the topology: again a numbering of its own
    vertices[mesh.topology.connectivity(2, 0).array] = nodes[mesh.geometry.dofmap.array]
    facets = np.sort(vertices[mesh.topology.connectivity(1, 0).array].reshape(-1, 2), axis=1)
    name = np.array([len(nodes), 1])  # a number for each pair of vertices
    _, marked, rows = np.intersect1d(facets @ name, np.sort(part.facets, axis=1) @ name,
                                     return_indices=True)
    order = np.argsort(marked)
    facet_tags = dolfinx.mesh.meshtags(mesh, 1, marked[order].astype(np.int32),
                                       part.facet_markers[rows[order]])
    return mesh, cell_tags, facet_tags, nodes


def solve(part: plate.Part) -> plate.Answer:
    mesh, cell_tags, facet_tags, nodes = read(part)
    dx = ufl.Measure("dx", mesh, subdomain_data=cell_tags)
    ds = ufl.Measure("ds", mesh, subdomain_data=facet_tags)  # at the border
    dS = ufl.Measure("dS", mesh, subdomain_data=facet_tags)  # within
    space = fem.FunctionSpace(mesh, ("Lagrange", 1))
    row = np.zeros(len(nodes), np.int64)  # of the part, for each number in the space
    row[space.dofmap.list.array] = nodes[mesh.geometry.dofmap.array]

    # Constants instead of literals in the form, so that it is compiled once and not in each step.
    def constant(value: float) -> fem.Constant:
        return fem.Constant(mesh, value)

    def integral(form: ufl.Form) -> float:
        return fem.assemble_scalar(fem.form(form))

    one = constant(1.0)
    old = fem.Function(space)
    old.x.array[:] = part.u[row]
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    dt = constant(plate.TIME_STEP)
    left = u * v * dx + sum(dt * constant(k) * ufl.inner(ufl.grad(u), ufl.grad(v)) * dx(marker)
                            for marker, k in plate.CONDUCTIVITY.items())
    right = (old * v * dx + dt * constant(plate.HEATING[plate.DISC]) * v * dx(plate.IN_DISC)
             + dt * constant(plate.HEATING[plate.WIRE]) * ufl.avg(v) * dS(plate.WIRE)
             + dt * constant(plate.HEATING[plate.LEFT]) * v * ds(plate.LEFT))
    new = LinearProblem(left, right,
                        petsc_options={"ksp_type": "preonly", "pc_type": "lu"}).solve()
    result = np.zeros(len(row))
    result[row] = new.x.array
    return plate.Answer(
        areas={marker: integral(one * dx(marker)) for marker in (plate.IN_PLATE, plate.IN_DISC)},
        lengths={**{marker: integral(one * ds(marker)) for marker in (plate.LEFT, plate.PLATE)},
                 **{marker: integral(one * dS(marker)) for marker in (plate.DISC, plate.WIRE)}},
        heat=integral(old * dx), u=result, heat_after=integral(new * dx))


if __name__ == "__main__":
    logging.disable(logging.INFO)  # compilers that DOLFINx runs would show their command lines
    plate.run("dolfinx", solve)
