"""What a motion of an assembly's parts did, and the transfer of fields across it."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from dynmesh._band import Band, Frame
from dynmesh._diff import Diff
from dynmesh._part import Part
from dynmesh._types import Array
from dynmesh.errors import StaleDiff

if TYPE_CHECKING:
    from dynmesh._assembly import Assembly
    from dynmesh._mesh import Mesh
    from dynmesh._pieces import State


@dataclass(frozen=True)
class BandState:
    """A band's mesh in an order that does not depend on how it came about.

    Vertices of curves are first, then those of rings, then the rest by coordinates.
    """

    at: Array  # of the vertices, in the band's coordinates
    own: Array  # those of curves without a part, and what follows the curves
    cells: Array
    cell_slots: Array  # in the band's mesh
    slots: int  # of cells, free ones included

    def cells_among(self, numbers: Array) -> Array:
        """The cells in the numbers of the assembly, given those of the band's vertices."""
        cells: Array = numbers[self.cells]
        return cells

    def border(self, numbers: Array, band: Band) -> Array:
        """The edges of curves without a part, the band on their left."""
        edges = [np.zeros((0, 2), np.int64)]
        for k, side in enumerate(band.sides):
            if not side.part:
                ring = numbers[band.starts[k] - 1:band.starts[k + 1] - 1]
                pair = np.column_stack([ring, np.roll(ring, -1)])
                edges.append(pair[:, ::-1] if k else pair)
        return np.concatenate(edges)

    def by_slot(self) -> Array:
        """The number of the cell in each slot; -1 where it is none of the band's."""
        numbers = np.full(self.slots, -1)
        numbers[self.cell_slots] = np.arange(len(self.cell_slots))
        return numbers


def band_state(band: Band, mesh: Mesh, part: Part) -> BandState:
    """Of the band's mesh as it is now. O(band log band)."""
    slots = part.vertex_slots
    is_given = (mesh.containing_dimensions[slots] == 0) & (mesh.owners[slots] != 0)
    owners = mesh.owners[slots].astype(np.int64)
    place = part.points
    # Input points have ids from 1 in the order of the curves and rings.
    order = np.lexsort((place[:, 1], place[:, 0], np.where(is_given, owners, 2**62)))
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(len(order))
    cells = number[part.cells]
    first = cells.argmin(axis=1)
    cells = np.take_along_axis(cells, (first[:, None] + np.arange(3)) % 3, axis=1)
    rows = np.lexsort(cells.T[::-1])
    at = place[order]
    ends = band.starts - 1
    own = [at[ends[k]:ends[k + 1]] for k, side in enumerate(band.sides) if not side.part]
    return BandState(at, np.vstack([*own, at[ends[-1]:]]), cells[rows], part.cell_slots[rows], mesh.cell_slots)


class Motion:
    """The change of an assembly by `turn`, `move` or `place`. It carries fields until the next one."""

    def __init__(self, assembly: Assembly, former: State, present: State,
                 diffs: dict[str, Optional[Diff]]) -> None:
        self._assembly, self._former, self._present = assembly, former, present
        self._diffs = diffs

    def __repr__(self) -> str:
        moved = [name for name, frame in self._present.frames.items()
                 if frame != self._former.frames.get(name)]
        return f"<Motion of {', '.join(moved) or 'nothing'}>"

    def transfer(self, u: Array, kind: str = "P1", *, vectors: bool = False) -> Array:
        """A field on the assembly after the motion.

        Values of parts go with their parts: their rows stay to the bit. In a band values stay where they are
        in space: cells and vertices that are there before and after keep theirs. The band of two circles has
        the same vertices always, so that its P1 values stay, too.

        Args:
            u: a row for each vertex ("P1") or cell of the assembly before. A row is a number, or has an axis of
                components.
            kind: "P1": new vertices of a band get the value of the P1 function before, at their
                place. "P0": new cells get the mean over what they cover, corrected such that the band's
                integral stays. "overlap": new cells get the row, of any dtype, of the cell
                that they have the most in common with.
            vectors: rows are vectors of two components in the world's axes, which turn with
                their part.

        Returns:
            A new array, with a row for each vertex or cell now.

        Raises:
            StaleDiff: another motion has followed.
            ValueError: wrong kind, length or shape.

        Time: O(assembly), for the copy, and that of the band's new cells.
        """
        if kind not in ("P1", "P0", "overlap"):
            raise ValueError(f"kind: an assembly carries 'P1', 'P0' and 'overlap', and got {kind!r}")
        values = np.asarray(u) if kind == "overlap" else np.asarray(u, dtype=np.float64)
        former, present = self._former, self._present
        count = len(former.points if kind == "P1" else former.cells)
        if values.ndim == 0 or len(values) != count:
            raise ValueError(f"u: kind {kind!r} needs a row for each {'vertex' if kind == 'P1' else 'cell'} of the "
                             f"assembly before the motion, {count} rows, and got the shape {values.shape}")
        if vectors and values.shape[1:] != (2,):
            raise ValueError(f"u: vectors have two components, the shape ({count}, 2), and got {values.shape}")
        with self._assembly._lock:
            if self._assembly._motion is not self:
                raise StaleDiff("another motion of the assembly has followed: carry fields before it")
            rows = len(present.points if kind == "P1" else present.cells)
            result = np.zeros((rows, *values.shape[1:]), values.dtype)
            for k, name in enumerate(present.pieces):
                old, new = (_range(state, kind, k) for state in (former, present))
                result[new] = values[old]
                by = present.frames[name].angle - former.frames[name].angle
                if vectors and by != 0:
                    result[new] = Frame(by).turn(result[new])
            for k, (name, band) in enumerate(present.bands.items(), len(present.pieces)):
                old, new = (_range(state, kind, k) for state in (former, present))
                if kind == "P1":
                    self._at_vertices(name, band, values, result[new])
                else:
                    result[new] = self._in_cells(name, values[old], kind)
        return result

    def _at_vertices(self, name: str, band: Band, u: Array, own: Array) -> None:
        """Sets the rows of a band's own vertices."""
        was, now = self._former.meshed[name], self._present.meshed[name]
        before = u[self._former._numbers_of(band)]
        known = {place: row for row, place in enumerate(map(tuple, was.at.tolist()))}
        number = np.array([known.get(place, -1) for place in map(tuple, now.own.tolist())], np.int64)
        own[number >= 0] = before[number[number >= 0]]
        new = np.flatnonzero(number < 0)
        if not new.size:
            return
        # Where a new vertex is, among the former cells that its new ones meet.
        local = np.full(len(now.at), -1)
        local[len(now.at) - len(now.own):][new] = np.arange(len(new))
        rows, cells = self._meeting(name)[:2]
        corners = local[now.cells[rows]]
        which, cell = corners[corners >= 0], np.repeat(cells, (corners >= 0).sum(axis=1))
        a, b, c = np.moveaxis(was.at[was.cells[cell]], 1, 0)
        p = now.own[new[which]] - a
        e, f = b - a, c - a
        area = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
        s = (p[:, 0] * f[:, 1] - p[:, 1] * f[:, 0]) / area
        t = (e[:, 0] * p[:, 1] - e[:, 1] * p[:, 0]) / area
        weights = np.column_stack([1 - s - t, s, t])
        order = np.lexsort((-weights.min(axis=1), which))
        found, first = np.unique(which[order], return_index=True)
        best = order[first]
        inside = np.clip(weights[best], 0, 1)
        inside /= inside.sum(axis=1, keepdims=True)
        own[new[found]] = np.einsum("ni,ni...->n...", inside, before[was.cells[cell[best]]])
        for row in np.setdiff1d(np.arange(len(new)), found):  # where a part was before
            near = np.linalg.norm(was.at - now.own[new[row]], axis=1).argmin()
            own[new[row]] = before[near]

    def _in_cells(self, name: str, u: Array, kind: str) -> Array:
        """The rows of a band's cells."""
        was, now = self._former.meshed[name], self._present.meshed[name]
        result = np.zeros((len(now.cells), *u.shape[1:]), u.dtype)
        old = was.by_slot()  # no slot that an edit frees is filled by the same edit
        kept = np.full(len(now.cells), -1)
        there = now.cell_slots < was.slots
        kept[there] = old[now.cell_slots[there]]
        result[kept >= 0] = u[kept[kept >= 0]]
        new = np.flatnonzero(kept < 0)
        if not new.size:
            return result
        rows, cells, measure = self._meeting(name)
        gone = np.ones(len(was.cells), bool)
        gone[kept[kept >= 0]] = False
        if kind == "overlap":
            order = np.lexsort((-measure, rows))
            found, first = np.unique(rows[order], return_index=True)
            result[found] = u[cells[order[first]]]
            rest = np.setdiff1d(new, found)
        else:
            shape = (-1, *(1,) * (u.ndim - 1))
            # Differences to one of the values, so that constants stay to the bit.
            base = u[np.flatnonzero(gone)[0]] if gone.any() else 0
            total = np.bincount(rows, measure, len(now.cells))
            sums = np.zeros(result.shape)
            np.add.at(sums, rows, measure.reshape(shape) * (u[cells] - base))
            found = np.flatnonzero(total > 0)
            result[found] = base + sums[found] / total[found].reshape(shape)
            rest = np.setdiff1d(new, found)
        for row in rest:  # where a part was before
            middle = now.at[now.cells[row]].mean(axis=0)
            near = np.linalg.norm(was.at[was.cells].mean(axis=1) - middle, axis=1).argmin()
            result[row] = u[near]
        if kind == "P0" and gone.any():
            areas, before = _areas(now.at[now.cells[new]]), _areas(was.at[was.cells[gone]])
            lost = np.tensordot(before, u[gone] - base, 1) - np.tensordot(areas, result[new] - base, 1)
            result[new] += lost / areas.sum()
        return result

    def _meeting(self, name: str) -> tuple[Array, Array, Array]:
        """Cells of the band now, and before, that have an area in common, and that area."""
        diff = self._diffs[name]
        if diff is None:
            return np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0)
        pieces = diff.pieces()
        now, was = self._present.meshed[name].by_slot(), self._former.meshed[name].by_slot()
        rows, cells = now[pieces.new], was[pieces.old]
        both = (rows >= 0) & (cells >= 0)
        return rows[both], cells[both], np.asarray(pieces.measure)[both]


def _areas(corners: Array) -> Array:
    e, f = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas: Array = (e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]) / 2
    return areas


def _range(state: Any, kind: str, k: int) -> slice:
    starts = state.vertex_starts if kind == "P1" else state.cell_starts
    return slice(int(starts[k]), int(starts[k + 1]))
