"""An assembly in one position, as arrays."""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dynmesh._band import Band, Frame
from dynmesh._motion import BandState
from dynmesh._part import Part
from dynmesh._types import Array, Label
from dynmesh.errors import FailedPrecondition


@dataclass(frozen=True)
class Piece:
    """A part at a revision, in numbers of its own."""

    part: Part
    revision: int
    points: Array
    cells: Array
    regions: Array  # of cells, from 0 in the order of `labels`
    labels: list[Label]  # of regions
    facets: Array
    facet_cells: Array
    owners: Array
    markers: Array
    names: Array


def piece_of(part: Part) -> Piece:
    with part.mesh.locked():
        if part.revision != part.mesh.revision:
            raise FailedPrecondition("the part is not at the mesh's revision: update the part first")
        rows = part._region_labels()
        order = sorted(rows, key=lambda region: rows[region][0])
        number_of = {region: number for number, region in enumerate(order)}
        found, which = np.unique(part.cell_regions, return_inverse=True)
        regions = np.array([number_of[region] for region in found.tolist()], np.int32)[which]
        return Piece(part, part.revision, part.points, part.cells, regions,
                      [rows[region][1] for region in order], part.facets, part.facet_cells,
                      part.facet_owners, part.facet_markers, part.facet_names)


class State:
    """An assembly in one position: nothing of it changes."""

    def __init__(self, pieces: dict[str, Piece], bands: dict[str, Band], frames: dict[str, Frame],
                 meshed: dict[str, BandState]) -> None:
        self.frames, self.meshed, self.pieces, self.bands = frames, meshed, pieces, bands
        self.names = (*pieces, *bands)
        own = [meshed[name].own for name in bands]
        self.vertex_starts = _starts([*(piece.points for piece in pieces.values()), *own])
        self.points = _frozen(np.vstack([
            np.zeros((0, 2)), *(frames[name].place(piece.points) for name, piece in pieces.items()),
            *(at + band.origin(frames) for at, band in zip(own, bands.values()))]))
        blocks = [piece.cells + start
                  for piece, start in zip(pieces.values(), self.vertex_starts.tolist())]
        for name, band in bands.items():
            blocks.append(meshed[name].cells_among(self._numbers_of(band)))
        self.cell_starts = _starts(blocks)
        self.cells = _frozen(np.vstack([np.zeros((0, 3), np.int32), *blocks]).astype(np.int32))

    @cached_property
    def facets(self) -> tuple[Array, ...]:
        """Ends, cells, parts, owners, markers and names of facets."""
        blocks: list[tuple[Array, ...]] = [(np.zeros((0, 2), np.int32), np.zeros((0, 2), np.int32),
                                            np.empty(0, np.int32), np.empty(0, np.uint64),
                                            np.empty(0, np.int64), np.empty(0, object))]
        for k, (name, piece) in enumerate(self.pieces.items()):
            cells = piece.facet_cells + np.where(piece.facet_cells < 0, 0, self.cell_starts[k])
            blocks.append((piece.facets + self.vertex_starts[k], cells, np.full(len(cells), k),
                           piece.owners, piece.markers, piece.names))
        for k, (name, band) in enumerate(self.bands.items(), len(self.pieces)):
            edges = self.meshed[name].border(self._numbers_of(band), band)
            if len(edges):
                cells = np.column_stack([np.full(len(edges), -1)] * 2)
                blocks.append((edges, cells, np.full(len(edges), k),
                               np.zeros(len(edges), np.uint64), np.full(len(edges), band.border.marker),
                               np.full(len(edges), band.border.name, object)))
        facets, cells, parts, owners, markers, names = (np.concatenate(c) for c in zip(*blocks))
        # The cells of bands beside facets, which are on the left of each edge of theirs.
        first = self.cell_starts[len(self.pieces)]
        band_cells = self.cells[first:].astype(np.int64)
        count = len(self.points)
        keys = np.concatenate([band_cells[:, i] * count + band_cells[:, (i + 1) % 3] for i in range(3)])
        order = np.argsort(keys)
        for column, pair in ((0, facets), (1, facets[:, ::-1])) if len(keys) else ():
            wanted = pair[:, 0].astype(np.int64) * count + pair[:, 1]
            at = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
            found = (keys[at] == wanted) & (cells[:, column] < 0)
            cells[found, column] = first + at[found] % len(band_cells)
        return tuple(_frozen(column) for column in (
            facets.astype(np.int32), cells.astype(np.int32), parts.astype(np.int32), owners,
            markers.astype(np.int64), names))

    def _numbers_of(self, band: Band) -> Array:
        """Of the vertices of a band, those of its curves first, in the assembly."""
        starts = dict(zip(self.names, self.vertex_starts.tolist()))
        numbers, own = [], starts[band.name]
        for side in band.sides:
            if side.part:
                numbers.append(starts[side.part] + side.vertices)
            else:
                numbers.append(np.arange(own, own + len(side.curve)))
                own += len(side.curve)
        end = self.vertex_starts[self.names.index(band.name) + 1]
        return np.concatenate([*numbers, np.arange(own, end)])


def _starts(blocks: Iterable[Array]) -> Array:
    return np.cumsum([0, *(len(block) for block in blocks)])


def _frozen(array: Array) -> Array:
    array.flags.writeable = False
    return array
