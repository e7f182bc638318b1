"""The change of a mesh by an edit, and the transfer of fields across it."""
from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Callable, Optional, Union

import numpy as np

from dynmesh import _core
from dynmesh._rows import check_kind, check_rows, check_values, is_any_dtype, is_at_vertices
from dynmesh._state import MeshState
from dynmesh._types import Array, Label
from dynmesh.errors import FailedPrecondition, StaleDiff

Kind = Union[str, Callable[[Array, "Pieces"], Array]]


@dataclass(frozen=True)
class Patch:
    """The changed slots. Rows are in the order of ids: a function of the two meshes."""

    from_revision: int  #: The revision before.
    to_revision: int  #: The revision after.
    removed_vertices: Array  #: Slots of the removed vertices.
    added_vertices: Array  #: Slots of the added vertices.
    removed_cells: Array  #: Slots of the removed cells.
    removed_corners: Array  #: Vertex slots, one row per removed cell.
    removed_regions: Array  #: Regions of the removed cells.
    added_cells: Array  #: Slots of the added cells.
    added_corners: Array  #: Vertex slots, one row per added cell.
    relabelled_cells: Array  #: Slots of kept cells with a changed region.
    former_regions: Array  #: Former regions of the relabelled cells.
    #: The cavity's boundary, one row per face: cell, its opposite corner, cell beyond or -1.
    boundary_faces: Array

    @cached_property
    def vertices(self) -> Array:
        """Slots of the vertices of the added cells: their rows of a matrix change."""
        return np.unique(self.added_corners)

    @cached_property
    def neighbours(self) -> Array:
        """Slots of the kept cells beside the added ones."""
        beyond = self.boundary_faces[:, 2]
        return np.unique(beyond[beyond >= 0])


@dataclass(frozen=True)
class Pieces:
    """The intersections of old and new cells, sorted by new cell."""

    old: Array  #: Slots of removed cells.
    new: Array  #: Slots of added cells.
    measure: Array  #: Area or volume of each intersection.


@dataclass(frozen=True)
class RegionFlow:
    """Mass that changed its region: the edit changed their shapes, or `bounded` left no room."""

    old: int  #: The old region.
    new: int  #: The new region.
    amounts: tuple[float, ...]  #: By component, in the field's unit times area or volume.


class Diff:
    """The change from one revision of a mesh to a later one.

    Transfer fields while the mesh is at `to_revision`: before the next edit is applied. If other
    threads edit the mesh, hold `Mesh.locked` from the edit to the transfers; otherwise these may
    raise `StaleDiff`. Any thread may transfer, several fields at a time.
    """

    def __init__(self, mesh: MeshState, parts: list[Any], old_slots: tuple[int, int]) -> None:
        self._mesh = mesh
        self._parts = parts
        self._old_slots = old_slots
        self._new_slots = (mesh.vertex_slots, mesh.cell_slots)
        self._transfer: Optional[Any] = None
        #: Mass that changed its region in the last transfer.
        self.flows: list[RegionFlow] = []
        #: The changed slots.
        self.patch: Patch = Patch(**mesh._replica.patch()) if parts else _empty_patch(mesh)
        #: The hash of the mesh after the edit: 32 hexadecimal digits.
        self.hash: str = mesh.hash
        #: The revision before.
        self.from_revision: int = self.patch.from_revision
        #: The revision after.
        self.to_revision: int = self.patch.to_revision

    def __repr__(self) -> str:
        p = self.patch
        return (f"<Diff of revisions {self.from_revision} to {self.to_revision}: "
                f"vertices -{len(p.removed_vertices)} +{len(p.added_vertices)}, "
                f"cells -{len(p.removed_cells)} +{len(p.added_cells)}>")

    @property
    def work(self) -> dict[str, float]:
        """The mesher's work: operations executed, created, dropped and notified; microseconds."""
        total = {"executed": 0, "created": 0, "dropped": 0, "microseconds": 0.0, "notified": 0}
        for part in self._parts:
            for key, value in part.work.items():
                total[key] += value
        return total

    @property
    def labels(self) -> dict[int, Label]:
        """The labels that features have got, by id; an empty one where a feature has none any more.

        A diff of several revisions may also have labels that are as before.
        """
        return {id_: Label(marker, name)
                for part in self._parts for id_, marker, name in part.labels}

    @property
    def replayed(self) -> bool:
        """True if this was a retry of a batch that had been applied before."""
        return any(part.replayed for part in self._parts)

    def _check(self) -> None:
        if self._mesh._current is not self or self._mesh.revision != self.to_revision:
            raise self._stale()

    def _stale(self) -> StaleDiff:
        return StaleDiff(f"the mesh has left revision {self.to_revision}: carry fields before the "
                         "next edit is applied, beside other threads under `with mesh.locked():`")

    @contextmanager
    def _core_transfer(self) -> Iterator[Any]:
        """The transfer of the extension module. Another thread may edit the mesh meanwhile."""
        self._check()
        try:
            if self._transfer is None:
                self._transfer = _core.Transfer(self._mesh._replica, self.from_revision,
                                                self.to_revision)
            yield self._transfer
        except FailedPrecondition:
            self._check()  # the replica has left the revision
            raise

    def transfer(
        self,
        u: Array,
        kind: Kind = "P1",
        *,
        bounded: bool = False,
        order: int = 2,
        rings: int = 1,
        inplace: bool = False,
    ) -> Array:
        """The field on the new mesh.

        Args:
            u: the field on the old mesh, exactly one row per slot of the old mesh (or of the new
                one: its further rows are not read). P1, dual: vertex slots; else cells. Rows are
                finite numbers or have a further axis of components; DG1 has an axis of corners
                before that, in the order of `Mesh.cells`.
            kind: "P1": values at vertices. "dual": means over the median-dual cells of vertices, of
                first order and within the range of the old ones. "P0": means of cells. "DG1": a linear function in each
                cell. "overlap": each new cell gets the row, of any dtype, of the old cell with the
                largest intersection. A function: called with `u` and `Pieces`, returns the rows of
                `patch.added_cells`.
            bounded: keeps all values in the range of the old ones in the patch. With P1 each region
                keeps its integral if values in that range can; `flows` has what changed sides where
                they cannot. Without it, P1 overshoots at fronts, by 18 % of a jump in one edit.
            order: of P0: 1, or 2 with limited gradients.
            rings: of P1: number of rings of vertices around the patch that may change.
            inplace: writes the result to `u`, a C-contiguous float64 array with a row for every
                new slot. Here it may have more rows, which are not changed: room for later slots.

        Returns:
            A new array, or `u`. Its rows of free slots are undefined.

        Raises:
            StaleDiff: the mesh has a later revision.
            ValueError, TypeError: wrong kind, length, shape or dtype, or a value in the patch that
                is not finite. Nothing changes.
        """
        self._check()
        self._check_options(kind, order)
        values = self._prepare("u", np.asarray(u), inplace, kind)
        self._carry(values, kind, bounded=bounded, order=order, rings=rings)
        return values

    def _carry(self, values: Array, kind: Kind, *, bounded: bool = False, order: int = 2,
               rings: int = 1) -> None:
        """Transfers in place an array of the right shape, with a row for every new slot."""
        self._check_options(kind, order)
        if is_any_dtype(kind):
            rows = self._by_cells(values, kind)
            if len(rows) != len(self.patch.added_cells):
                raise ValueError(f"the function gave {len(rows)} rows for "
                                 f"{len(self.patch.added_cells)} added cells")
            values[self.patch.added_cells] = rows
            self.flows = []
            return
        width, components = self._shape_of(values, kind)
        slots = self._new_slots[0 if is_at_vertices(kind) else 1]
        if not self.patch.added_cells.size and not self.patch.relabelled_cells.size:
            self.flows = []
            return
        with self._core_transfer() as transfer:
            self._note(transfer.carry(values, slots * width * components,
                                      self._name_of(kind, order), components, rings, bounded))

    def transfer_momentum(
        self,
        density: Array,
        velocity: Array,
        kind: str = "P1",
        *,
        bounded: bool = False,
        order: int = 2,
        rings: int = 1,
    ) -> tuple[Array, Array]:
        """Density and velocity on the new mesh, such that density and momentum are conserved.

        Transfers their product, then divides by the new density. If that is 0, the velocity is 0.

        Args:
            density: a number for each vertex slot (P1, dual) or cell slot.
            velocity: any number of components for each slot.
            kind: "P1", "dual", "P0" or "DG1", as in `transfer`; so are `bounded`, `order` and `rings`.

        Returns:
            New arrays of density and velocity.

        Raises:
            StaleDiff, ValueError: as in `transfer`.
        """
        self._check()
        self._check_options(kind, order)
        if is_any_dtype(kind):
            raise ValueError(f"kind: momentum is carried as 'P1', 'dual', 'P0' or 'DG1', not as {kind!r}")
        rho = self._prepare("density", np.asarray(density), False, kind)
        v = self._prepare("velocity", np.asarray(velocity), False, kind)
        width, components = self._shape_of(v, kind)
        rho_width, rho_components = self._shape_of(rho, kind)
        if rho_components != 1 or rho_width != width:
            raise ValueError("density: it has one number for each place of the velocity, of the "
                             f"shape {v.shape}, and got {rho.shape}")
        slots = self._new_slots[0 if is_at_vertices(kind) else 1]
        if self.patch.added_cells.size:
            with self._core_transfer() as transfer:
                self._note(transfer.carry_momentum(
                    rho, slots * width, v, slots * width * components, self._name_of(kind, order),
                    components, rings, bounded))
        return rho, v

    def pieces(self) -> Pieces:
        """The intersections of old and new cells. O(patch)."""
        with self._core_transfer() as transfer:
            return Pieces(*transfer.pieces())

    @property
    def donors(self) -> Array:
        """For each added cell of the patch the removed cell with the largest intersection."""
        with self._core_transfer() as transfer:
            donors: Array = transfer.donors()
        return donors

    @property
    def old_to_new(self) -> Array:
        """For each old vertex slot the new one, which is the same; -1 if it was removed."""
        return _map(self._kept_vertices(), self._old_slots[0])

    @property
    def new_to_old(self) -> Array:
        """For each new vertex slot the old one, which is the same; -1 if it was added."""
        return _map(self._kept_vertices(), self._new_slots[0])

    @property
    def cells_old_to_new(self) -> Array:
        """`old_to_new` for cells."""
        return _map(self._kept_cells(), self._old_slots[1])

    @property
    def cells_new_to_old(self) -> Array:
        """`new_to_old` for cells."""
        return _map(self._kept_cells(), self._new_slots[1])

    @property
    def kept_cells(self) -> Array:
        """Slots of the cells that both meshes have. O(mesh)."""
        return np.flatnonzero(self._kept_cells()).astype(np.int32)

    def _kept_vertices(self) -> Array:
        kept = self._mesh.live_vertices
        self._check()  # after it was read: it is of this revision then
        kept[self.patch.added_vertices] = False
        return kept

    def _kept_cells(self) -> Array:
        kept = self._mesh.live_cells
        self._check()
        kept[self.patch.added_cells] = False
        return kept

    def _prepare(self, what: str, u: Array, inplace: bool, kind: Kind) -> Array:
        """A copy with a row for each new slot, or `u` itself. Raises if `u` is not of the kind."""
        which = 0 if is_at_vertices(kind) else 1
        if inplace:
            check_rows(what, u, kind, self._new_slots, self.to_revision, at_least=True)
            check_values(what, u, kind, self._mesh.dimension)
            if not is_any_dtype(kind) and (u.dtype != np.float64 or not u.flags.c_contiguous):
                raise TypeError(f"{what}: a field that is carried in place is a C-contiguous "
                                f"float64 array, and got {u.dtype}, "
                                f"{'' if u.flags.c_contiguous else 'not '}C-contiguous; without "
                                "inplace=True it is converted")
            if not u.flags.writeable:
                raise ValueError(f"{what}: the field is read-only: carry a copy of it, or without "
                                 "inplace=True")
            return u
        check_rows(what, u, kind, self._old_slots, self.from_revision, later=self._new_slots)
        check_values(what, u, kind, self._mesh.dimension)
        values = np.zeros((max(self._new_slots[which], len(u)), *u.shape[1:]),
                          u.dtype if is_any_dtype(kind) else np.float64)
        values[:len(u)] = u
        return values

    def _shape_of(self, values: Array, kind: Kind) -> tuple[int, int]:
        axes = values.shape[1:]
        width = 1
        if kind in ("DG1", "dual-corners"):
            width, axes = axes[0], axes[1:]
        return width, (axes[0] if axes else 1)

    @staticmethod
    def _check_options(kind: Kind, order: int) -> None:
        if kind != "dual-corners":  # of a part, which carries them itself
            check_kind(kind)
        if order not in (1, 2):
            raise ValueError(f"order: the order is 1 or 2, and got {order!r}")

    @staticmethod
    def _name_of(kind: Kind, order: int) -> str:
        return "P0-linear" if kind == "P0" and order == 2 else str(kind)

    def _by_cells(self, values: Array, kind: Kind) -> Array:
        if not self.patch.added_cells.size:
            return values[:0]
        if kind == "overlap":
            return values[self.donors]
        assert callable(kind)
        return np.asarray(kind(values, self.pieces()))

    def _note(self, flows: list[tuple[int, int, list[float]]]) -> None:
        self.flows = [RegionFlow(old, new, tuple(amounts)) for old, new, amounts in flows]


def _map(kept: Array, slots: int) -> Array:
    """Maps each kept slot to itself, others to -1."""
    return np.where(kept, np.arange(len(kept), dtype=np.int32), np.int32(-1))[:slots]


def _empty_patch(mesh: MeshState) -> Patch:
    slots, ids = np.zeros(0, np.int32), np.zeros(0, np.uint64)
    rows = np.zeros((0, mesh.dimension + 1), np.int32)
    return Patch(mesh.revision, mesh.revision, slots, slots, slots, rows, ids, slots, rows, slots,
                 ids, np.zeros((0, 3), np.int32))
