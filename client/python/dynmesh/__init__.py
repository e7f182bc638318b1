"""Dynamic meshes for simulation programs::

    import dynmesh
    with dynmesh.connect("localhost:7878") as server:   # or dynmesh.open(box=...) without a server
        mesh = server.mesh("plate", create=dict(box=[[0, 0], [10, 10]]))
        u = temperature(mesh.points)
        diff = mesh.apply(add_points={1: (1, 2)}, move_points={7: (4, 4)})
        u = diff.transfer(u)                            # kind="P1"; "P0", "DG1", "overlap"

A mesh is a set of numpy arrays with *stable slots*: a vertex or cell keeps its row while it exists,
so a program's arrays need no renumbering. Free rows have id 0 (vertices) or corners -1 (cells).
**The mesh reaches far beyond its features**: about six times as far as the box, in 3D eight times.
`Mesh.part()` is the part in polygons, without gaps, and follows edits; with `open=` it has two sides
along cracks. `Mesh.compact()` numbers the whole mesh without gaps. `Assembly` puts parts together
that move against each other.
"""
from __future__ import annotations

from dynmesh import _core
from dynmesh._assembly import Assembly
from dynmesh._band import Frame
from dynmesh._curves import periodic_pairs, points_along
from dynmesh._diff import Diff, Patch, Pieces, RegionFlow
from dynmesh._fields import Fields
from dynmesh._files import FileInput, read_input, read_surface
from dynmesh._mesh import CompactMesh, Mesh
from dynmesh._motion import Motion
from dynmesh._part import Part
from dynmesh._server import Server, connect, open  # noqa: A004: as io.open
from dynmesh._series import Series
from dynmesh._solvers import DmplexMesh, DolfinxMesh, SkfemArrays, to_dmplex, to_dolfinx, to_skfem
from dynmesh._types import Label
from dynmesh._write import Writable
from dynmesh.errors import (
    AlreadyExists,
    Cancelled,
    Conflict,
    DataLoss,
    DeadlineExceeded,
    DynmeshError,
    FailedPrecondition,
    InvalidArgument,
    LimitExceeded,
    NotFound,
    OutOfRange,
    PermissionDenied,
    StaleDiff,
    Unavailable,
    VersionMismatch,
)

__version__: str = _core.version

__all__ = [
    "AlreadyExists",
    "Assembly",
    "Cancelled",
    "CompactMesh",
    "Conflict",
    "DataLoss",
    "DeadlineExceeded",
    "Diff",
    "DmplexMesh",
    "DolfinxMesh",
    "DynmeshError",
    "FailedPrecondition",
    "Fields",
    "FileInput",
    "Frame",
    "InvalidArgument",
    "Label",
    "LimitExceeded",
    "Mesh",
    "Motion",
    "NotFound",
    "OutOfRange",
    "Part",
    "Patch",
    "PermissionDenied",
    "Pieces",
    "RegionFlow",
    "Series",
    "Server",
    "SkfemArrays",
    "StaleDiff",
    "Unavailable",
    "VersionMismatch",
    "Writable",
    "connect",
    "open",
    "periodic_pairs",
    "points_along",
    "read_input",
    "read_surface",
    "to_dmplex",
    "to_dolfinx",
    "to_skfem",
]
