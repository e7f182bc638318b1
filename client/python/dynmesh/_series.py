"""A time series for ParaView: one .vtu per step, and the .pvd that lists them."""
from __future__ import annotations

import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Optional, Union

import numpy as np

from dynmesh._types import Array

if TYPE_CHECKING:
    from dynmesh._assembly import Assembly
    from dynmesh._mesh import Mesh
    from dynmesh._part import Part


class Series:
    """Files of a time series at `path`, such as "out/heat.pvd"; `add` writes one for each step."""

    def __init__(self, path: Union[str, pathlib.Path]) -> None:
        #: The list of steps, a .pvd.
        self.path: pathlib.Path = pathlib.Path(path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._steps: list[tuple[float, str]] = []

    def add(self, time: float, mesh: Union[Mesh, Part, Assembly],
            point_data: Optional[Mapping[str, Array]] = None,
            cell_data: Optional[Mapping[str, Array]] = None) -> None:
        """Writes `mesh`, a part of one, or an assembly at `time`, and updates the list.

        `point_data` and `cell_data` are as in `Mesh.to_meshio`, `Part.to_meshio` or
        `Assembly.to_meshio`.
        """
        name = f"{self.path.stem}_{len(self._steps):05d}.vtu"
        out = mesh.to_meshio(point_data, cell_data)
        out.points = np.pad(out.points, ((0, 0), (0, 3 - out.points.shape[1])))
        out.cell_sets = {}  # which the format has not
        out.write(str(self.path.parent / name), binary=True)
        self._steps.append((time, name))
        from xml.sax.saxutils import quoteattr  # a quarter of the time of an import of the package

        lines = [f"    <DataSet timestep={quoteattr(repr(float(t)))} file={quoteattr(file)}/>"
                 for t, file in self._steps]
        self.path.write_text("\n".join(
            ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "  <Collection>",
             *lines, "  </Collection>", "</VTKFile>", ""]), encoding="ascii")
