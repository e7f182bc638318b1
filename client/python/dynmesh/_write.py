"""Files of meshes and of their parts."""
from __future__ import annotations

import os
from typing import Any, Union

from dynmesh.errors import InvalidArgument


class Writable:
    """What is written to files: a `Mesh`, or a `Part` of one."""

    def _write(self, path: str, choices: dict[str, Any]) -> None:
        raise NotImplementedError

    def write(self, path: Union[str, os.PathLike[str]], *, markers: str = "ids", order: int = 1,
              msh_version: float = 4.1, binary: bool = False, from_zero: bool = False,
              neighbours: bool = False, voronoi: bool = False) -> None:
        """Writes the whole mesh, or the part as a mesh of its own, as the command does. O(mesh).

        Formats: .msh (Gmsh), .vtu, .mesh (Medit), .node (Triangle, TetGen, with .ele, .edge and
        .face beside it), .inp (Abaqus, CalculiX), .su2, in 2D .2dm (SMS, QGIS), .14 or .grd
        (ADCIRC), .svg (a picture); of a quadtree .csv, .vtu and .svg. Names of features are
        groups. Either the files are complete, or the former ones stay. Raises `InvalidArgument` for
        another extension, `Unavailable` if a file cannot be written. Of a part it raises
        `FailedPrecondition` if that is not at the mesh's revision. Of what is opened a file has all
        copies of vertices, and the facets of both sides.

        Args:
            path: the file; its extension says which format it has.
            markers: "ids": edges and faces have the ids of their features, cells the numbers of
                regions. "input": they have the markers of labels, cells those of the polygon whose
                own region it is. A .vtu has both in any case.
            order: of the elements: 1, or 2 with a node in the middle of each edge.
            msh_version: of a .msh: 4.1, or 2.2 for programs that read no other.
            binary: a .msh has its numbers as bytes, which are read faster.
            from_zero: a .node and the files beside it are numbered from 0, not 1.
            neighbours: with a .node, the neighbours of cells as .neigh.
            voronoi: with a .node, the Voronoi diagram.
        """
        if markers not in ("ids", "input"):
            raise InvalidArgument(f"markers: they are 'ids' or 'input', and got {markers!r}")
        self._write(os.fspath(path), dict(
            input_markers=markers == "input", order=order, msh_version=msh_version,
            binary=binary, from_zero=from_zero, neighbours=neighbours, voronoi=voronoi))
