"""The part of a mesh in chosen polygons: the domain of a simulation."""
from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from dynmesh import _core
from dynmesh._types import Array, Label
from dynmesh.errors import InvalidArgument, NotFound, StaleDiff

if TYPE_CHECKING:
    from dynmesh._diff import Diff
    from dynmesh._mesh import Mesh

Ids = Union[int, Iterable[int]]


def _ids(what: str, ids: Ids) -> list[int]:
    if isinstance(ids, (int, np.integer)):
        return [int(ids)]
    if isinstance(ids, (str, bytes)) or not isinstance(ids, Iterable):
        raise InvalidArgument(f"{what}: ids of polygons are integers, as {what}=[7, 9]; got {ids!r}")
    return [int(id_) for id_ in ids]


class Part:
    """The part of a mesh that lies in chosen polygons. Made by `Mesh.part`.

    Vertices, cells and facets have numbers without gaps. Arrays are read-only and never change: get
    them again after `update`, which takes time for the rows that have changed. An update keeps
    the numbers of what stays, except that the last ones fill the gaps.

    Facets are edges, in 3D triangles: the part's border, and segments (in 3D polygons) in it.
    Values by slot, as those of `mesh.fields`, are brought to the part by `values[part.vertex_slots]`
    or `values[part.cell_slots]`.

    Thread-safe. What has to be of one revision is read under `with mesh.locked():`.
    """

    def __init__(self, mesh: Mesh, polygons: Ids, names: Union[str, Iterable[str]], inside: bool,
                 without: Ids) -> None:
        #: The whole mesh.
        self.mesh: Mesh = mesh
        self._choice = (_ids("polygons", polygons),
                        [names] if isinstance(names, str) else list(names), inside,
                        _ids("without", without))
        self._labels: Optional[tuple[int, dict[int, Label]]] = None
        present = {label.name for label in mesh.labels.values() if label.name}
        for name in self._choice[1]:
            if name not in present:
                there = ", ".join(sorted(present)) or "none"
                raise NotFound(f"no feature has the name {name!r}; names are: {there}")
        self._part = _core.Part(mesh._replica, *self._choice)

    def __repr__(self) -> str:
        return (f"<Part of {self.mesh.dimension} dimensions at revision {self.revision}: "
                f"{len(self.vertex_slots)} vertices, {len(self.cell_slots)} cells, "
                f"{len(self.facet_owners)} facets>")

    def update(self, diff: Optional[Diff] = None) -> None:
        """Follows the mesh. Expected time: that of the diff.

        Without a `diff`, or if the part is not at the revision that it begins at, the part is made
        anew, with other numbers: O(mesh). Raises `StaleDiff` if the mesh has left the revision that
        the diff leads to. If other threads edit the mesh, hold `Mesh.locked` from the edit on.
        """
        if diff is None or diff.from_revision != self.revision:
            if diff is not None and diff.to_revision == self.revision:
                return
            self._part = _core.Part(self.mesh._replica, *self._choice)
            return
        if not diff._parts:
            return
        if diff._mesh is not self.mesh:
            raise InvalidArgument("the diff is of another mesh")
        if diff.to_revision != self.mesh.revision:
            raise StaleDiff(f"the mesh has left revision {diff.to_revision}: update the part before "
                            "the next edit is applied, or without a diff")
        self._part.update(self.mesh._replica, diff._parts)

    @property
    def revision(self) -> int:
        """The revision of the mesh that the part is of."""
        return int(self._part.revision)

    @property
    def points(self) -> Array:
        """Coordinates: (vertices, dimension), float64."""
        return self._part.points

    @property
    def cells(self) -> Array:
        """Numbers of the corners, positively oriented: (cells, dimension + 1), int32."""
        return self._part.cells

    @property
    def facets(self) -> Array:
        """Numbers of the corners of each facet: (facets, dimension), int32.

        At the border the part is on the left of an edge; corners of a triangle are counter-clockwise
        as seen from outside.
        """
        return self._part.facets

    @property
    def facet_cells(self) -> Array:
        """Numbers of the cells at each facet: (facets, 2), int32. The second is -1 at the border."""
        slots = self._part.facet_cells
        if len(slots) == 0:
            return slots
        return np.where(slots >= 0, self._part.cell_numbers[slots], -1).astype(np.int32)

    @property
    def is_border(self) -> Array:
        """Mask of the facets at the border."""
        return self._part.facet_cells[:, 1] < 0

    @property
    def facet_owners(self) -> Array:
        """The feature of each facet: uint64, 0 for none."""
        return self._part.facet_owners

    @property
    def facet_markers(self) -> Array:
        """The marker of each facet's feature: int64, 0 without one."""
        return self._by_owner(lambda label: label.marker, np.int64)

    @property
    def facet_names(self) -> Array:
        """The name of each facet's feature: str, empty without one."""
        return self._by_owner(lambda label: label.name, object)

    @property
    def cell_regions(self) -> Array:
        """The polygon around each cell, as `Mesh.regions`: uint64."""
        return self._part.cell_regions

    @property
    def vertex_slots(self) -> Array:
        """The slot of each vertex in the mesh: int32."""
        return self._part.vertex_slots

    @property
    def cell_slots(self) -> Array:
        """The slot of each cell in the mesh: int32."""
        return self._part.cell_slots

    @property
    def vertex_numbers(self) -> Array:
        """By vertex slot of the mesh, the number in the part: int32, -1 where it is not in it."""
        return self._part.vertex_numbers

    @property
    def cell_numbers(self) -> Array:
        """By cell slot of the mesh, the number in the part: int32, -1 where it is not in it."""
        return self._part.cell_numbers

    def _by_owner(self, of: Any, dtype: Any) -> Array:
        owners, which = np.unique(self.facet_owners, return_inverse=True)
        labels = self.mesh.labels
        none = Label()
        return np.array([of(labels.get(int(id_), none)) for id_ in owners], dtype=dtype)[which]
