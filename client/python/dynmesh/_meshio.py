"""Parts and assemblies for meshio."""
from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from dynmesh._types import Array
from dynmesh.errors import InvalidArgument

if TYPE_CHECKING:
    import meshio


def to_meshio(part: Any, point_data: Optional[Mapping[str, Array]],
              cell_data: Optional[Mapping[str, Array]], what: str) -> meshio.Mesh:
    """A `Part` or an `Assembly` for meshio, with data by its rows. `what` names it in errors."""
    import meshio

    plane = part.points.shape[1] == 2
    count, facets = len(part.cells), len(part.facets)
    labels = part._region_labels()
    regions, which = np.unique(part.cell_regions, return_inverse=True)
    rows = [labels[region] for region in regions.tolist()]
    markers = np.array([row[1].marker for row in rows], np.int64)[which]
    # The first array is what formats take that have only one.
    data = {"marker": [markers, part.facet_markers],
            "region": [np.array([row[0] for row in rows], np.int64)[which],
                       np.zeros(facets, np.int64)]}
    for kind, given, wanted in (("point_data", point_data, len(part.points)),
                                ("cell_data", cell_data, count)):
        for key, values in (given or {}).items():
            if np.ndim(values) == 0 or len(values) != wanted:
                raise InvalidArgument(f"{kind}[{key!r}]: {what} has {wanted} rows" + (
                    "; values by slot are brought to it by values[part."
                    f"{'vertex' if kind == 'point_data' else 'cell'}_slots]"
                    if what == "the part" else f", and got {np.shape(values)}"))
    for key, values in (cell_data or {}).items():
        array = np.asarray(values)
        data[key] = [array, np.zeros((facets, *array.shape[1:]), array.dtype)]
    none = np.empty(0, np.int64)
    inside = np.array([row[1].name for row in rows], object)[which]
    sets = {name: [np.flatnonzero(inside == name), none]
            for name in sorted({row[1].name for row in rows}) if name}
    names = part.facet_names
    behind = " edges" if plane else " faces"
    for name in sorted(set(names.tolist())):
        if name:
            sets[name + behind if name in sets else name] = [none, np.flatnonzero(names == name)]
    blocks = ("triangle", "line") if plane else ("tetra", "triangle")
    return meshio.Mesh(part.points, [(blocks[0], part.cells), (blocks[1], part.facets)],
                       point_data=dict(point_data or {}), cell_data=data, cell_sets=sets)
