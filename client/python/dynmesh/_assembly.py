"""Parts that move, each with a mesh of its own, and the bands between them."""
from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from dynmesh import _core
from dynmesh._band import Band, Frame, Side, area_of, check_free, closed_curve, match
from dynmesh._meshio import to_meshio
from dynmesh._motion import Motion, band_state
from dynmesh._part import Part
from dynmesh._pieces import Piece, State, piece_of
from dynmesh._types import Array, Label
from dynmesh._write import Writable
from dynmesh.errors import AlreadyExists, FailedPrecondition, InvalidArgument, NotFound

if TYPE_CHECKING:
    import meshio

#: A curve of a band: places, or the name of a part and places in its coordinates.
Curve = Union[Array, tuple[str, Any]]
LabelLike = Union[Label, Mapping[str, Any]]


class Assembly(Writable):
    """Parts that move against each other, with a band between them, as one mesh (2D)::

        assembly = dynmesh.Assembly()
        assembly.add("stator", stator)                  # a Part of a mesh
        assembly.add("rotor", rotor)
        assembly.band("gap", outer=("stator", bore), inner=("rotor", circle))
        for step in range(360):
            motion = assembly.turn("rotor", np.radians(step))
            u = motion.transfer(u)
            solve(assembly.points, assembly.cells, assembly.facets, u)

    A part has its own mesh, which does not change when the part moves, and a `Frame`. A band is meshed
    anew between curves, which are borders of parts or fixed, and stay whole. The vertices on a curve are
    those of the part: the whole fits together, without hanging vertices.

    Rows are those of parts, in the order in which they were added, then those of bands. A part's are
    in its own order and stay as it moves: `vertices(name)` and `cells_of(name)` are where. A band's come
    after them: the vertices of curves without a part, then of the rings between circles, then of the rest.

    All arrays are a function of the parts' meshes and of the frames: to the bit the same, whichever way
    led there. They are read-only and never change: get them again after a motion, at O(assembly).
    Thread-safe: motions are made one after another.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._pieces: dict[str, Piece] = {}
        self._frames: dict[str, Frame] = {}
        self._bands: dict[str, Band] = {}
        self._motion: Optional[Motion] = None
        self._state = State({}, {}, {}, {})

    def __repr__(self) -> str:
        state = self._state
        return (f"<Assembly of {', '.join(state.names) or 'nothing'}: {len(state.points)} vertices, "
                f"{len(state.cells)} cells>")

    def add(self, name: str, part: Part, frame: Frame = Frame()) -> None:
        """Adds a part. O(assembly).

        Args:
            name: of the part, for the other calls.
            part: a part of a mesh of two dimensions, closed. Its borders that are to be curves of bands are
                unsplit in its mesh (`unsplit=` of `Mesh.apply`), so that the mesh has no further
                vertices there. Several parts may be of one mesh.
            frame: where it is.

        Raises:
            AlreadyExists: the name is in use.
            InvalidArgument: a part of three dimensions, where no border stays whole.
            FailedPrecondition: the part is not at its mesh's revision.
        """
        with self._lock:
            self._check_new(name)
            if part.mesh.dimension != 2:
                raise InvalidArgument(f"part {name!r}: assemblies are of two dimensions: in space no border stays "
                                      "whole, so that the meshes of two parts do not fit")
            self._set({**self._pieces, name: piece_of(part)}, self._bands, {**self._frames, name: frame})

    def band(self, name: str, outer: Curve, inner: Union[Curve, list[Curve]], *,
             spacing: Optional[float] = None, label: LabelLike = Label(),
             border: LabelLike = Label()) -> None:
        """Adds the band between an outer curve and inner ones: a mesh that follows the parts.

        A curve is closed, and either `(name of a part, places)` in the part's own coordinates, where the
        part has its border with the same vertices in the same order, or places alone, fixed in the world.
        `points_along` gives a curve its points. No vertex comes onto curves, so their spacing is that of
        the mesh beside them. It is less than twice the width of the gap, in all positions.

        Between two circles around one centre the band has rings of vertices that do not move. So edges
        flip only where four vertices are on a circle, and an energy of P1 is a continuous
        function of the angle. Give both circles the same spacing rather than the same number of vertices.
        Between other curves vertices come and go as the mesh needs them: energies have noise, ten
        times as much; a `spacing` keeps it low.

        Args:
            name: of the band; also of its cells, unless `label` has another.
            outer: the curve around the band.
            inner: the curve within it, or a list of such curves, of parts beside each other.
            spacing: target length of the edges within the band. Without: as long as those of the circles, else
                what triangles need to be well-shaped.
            label: marker and name of the band's cells: `Label` or dict(marker=, name=).
            border: marker and name of the edges of curves without a part.

        Raises:
            InvalidArgument: a curve does not close, is not the border of its part, or is not in the outer one.
            FailedPrecondition: curves touch or cross, or are too near for their spacing.
            NotFound, AlreadyExists: a part that is not there; a name in use.

        Time: that of a mesh of the band's vertices.
        """
        with self._lock:
            self._check_new(name)
            if spacing is not None and not spacing > 0:
                raise InvalidArgument(f"band {name!r}: spacing is a length above 0, and got {spacing!r}")
            sides = [self._side(f"band {name!r}, outer", outer, False)]
            given: Any = inner
            sides += [self._side(f"band {name!r}, inner", curve, True)
                      for curve in (given if _is_several(given) else [given])]
            used = {(side.part, vertex) for band in self._bands.values() for side in band.sides
                    for vertex in side.vertices.tolist()}
            for side in sides:
                mine = {(side.part, vertex) for vertex in side.vertices.tolist()}
                check_free(f"band {name!r}: {side}", bool(mine & used))
                used |= mine
            of_cells = _label_of(f"band {name!r}, label", label)
            band = Band(name, sides[0], sides[1:], spacing,
                        of_cells if of_cells.name else Label(of_cells.marker, name),
                        _label_of(f"band {name!r}, border", border))
            self._set(self._pieces, {**self._bands, name: band}, self._frames)

    def turn(self, name: str, angle: float) -> Motion:
        """Turns the part `name` to an `angle`, in radians, about its frame's pivot; see `place`."""
        return self._place_one(name, angle=float(angle))

    def move(self, name: str, shift: Any) -> Motion:
        """Puts the part `name` at a `shift`, an (x, y) from where its mesh has it; see `place`."""
        x, y = np.asarray(shift, dtype=np.float64)
        return self._place_one(name, shift=(float(x), float(y)))

    def place(self, frames: Mapping[str, Frame]) -> Motion:
        """Puts parts in their frames, all at once; meshes the bands that this changes.

        Frames are where parts are to be, not by how much they move. Either all are placed, or nothing changes.

        Args:
            frames: by name of the parts; the others stay.

        Returns:
            What carries fields to the new position.

        Raises:
            NotFound: there is no such part.
            InvalidArgument, FailedPrecondition: curves touch, cross, or are too near for their spacing.
            FailedPrecondition: a part was updated; call `update`.

        Time: an edit of the bands' meshes, as long as their curves, and copies of all arrays.
        """
        with self._lock:
            for name, frame in frames.items():
                self.frame(name)
                if not np.isfinite([frame.angle, *frame.shift, *frame.pivot]).all():
                    raise InvalidArgument(f"part {name!r}: a frame has finite numbers, and got {frame}")
            for name, piece in self._pieces.items():
                if piece.part.revision != piece.revision:
                    raise FailedPrecondition(f"part {name!r} was updated to revision {piece.part.revision} "
                                             "of its mesh: call Assembly.update")
            return self._set(self._pieces, self._bands, {**self._frames, **frames})

    def update(self) -> None:
        """Takes the parts as they are now, after edits of their meshes. O(assembly).

        Their rows have changed then, and those of others may be elsewhere. Fields are carried part by part, by
        `Part.transfer` on `u[assembly.vertices(name)]`; those of bands stay, as the curves do.

        Raises:
            InvalidArgument: a part has lost its border with a band.
            FailedPrecondition: a part is not at its mesh's revision.
        """
        with self._lock:
            pieces = {name: piece_of(piece.part) for name, piece in self._pieces.items()}
            bands = {}
            for name, band in self._bands.items():
                sides = [match(side.part, pieces[side.part].part, side.curve, k > 0,
                               f"band {name!r}, {'inner' if k else 'outer'}") if side.part else side
                         for k, side in enumerate(band.sides)]
                bands[name] = Band(name, sides[0], sides[1:], band.spacing, band.label, band.border)
            self._set(pieces, bands, self._frames)

    @property
    def names(self) -> tuple[str, ...]:
        """The parts, in the order in which they were added, then the bands."""
        return self._state.names

    def part(self, name: str) -> Part:
        """The part `name`. Raises `NotFound` if there is no such part."""
        self.frame(name)
        return self._pieces[name].part

    def frame(self, name: str) -> Frame:
        """Where the part `name` is. Raises `NotFound` if there is no such part."""
        if name not in self._frames:
            there = ", ".join(self._frames) or "none"
            raise NotFound(f"there is no part {name!r}; parts are: {there}")
        return self._frames[name]

    @property
    def points(self) -> Array:
        """Coordinates in the world: (vertices, 2), float64."""
        return self._state.points

    @property
    def cells(self) -> Array:
        """Numbers of the corners, counter-clockwise: (cells, 3), int32."""
        return self._state.cells

    def vertices(self, name: str) -> slice:
        """The rows of the vertices of the part `name`, in the order of `Part.points`; of a band its own ones."""
        return self._rows(self._state.vertex_starts, name)

    def cells_of(self, name: str) -> slice:
        """The rows of the cells of the part `name`, in the order of `Part.cells`, or of a band's."""
        return self._rows(self._state.cell_starts, name)

    @property
    def cell_parts(self) -> Array:
        """The part or band of each cell, a number in `names`: int32. O(cells)."""
        starts = self._state.cell_starts
        return np.repeat(np.arange(len(starts) - 1, dtype=np.int32), np.diff(starts))

    @property
    def cell_markers(self) -> Array:
        """The marker of each cell: of the polygon whose own region it is in, or of the band: int64."""
        regions = self._region_labels()
        return np.array([regions[k][1].marker for k in range(len(regions))],
                        np.int64)[self.cell_regions]

    @property
    def cell_names(self) -> Array:
        """The name of each cell, as `cell_markers`: str, empty without one."""
        regions = self._region_labels()
        return np.array([regions[k][1].name for k in range(len(regions))], object)[self.cell_regions]

    @property
    def cell_regions(self) -> Array:
        """The region of each cell, numbered over the parts and bands from 0: int32. O(cells)."""
        state, first, blocks = self._state, 0, [np.empty(0, np.int32)]
        for piece in state.pieces.values():
            blocks.append(piece.regions + first)
            first += len(piece.labels)
        for k, name in enumerate(state.bands):
            blocks.append(np.full(len(state.meshed[name].cells), first + k))
        return np.concatenate(blocks).astype(np.int32)

    @property
    def facets(self) -> Array:
        """Numbers of the ends of each facet: (facets, 2), int32: those of parts, curves included, and
        the edges of curves without a part. What is in the assembly is on the left at the border."""
        return self._state.facets[0]

    @property
    def facet_cells(self) -> Array:
        """Numbers of the cells at each facet: (facets, 2), int32; the second is -1 at the border."""
        return self._state.facets[1]

    @property
    def is_border(self) -> Array:
        """Mask of the facets at the border of the whole."""
        return self._state.facets[1][:, 1] < 0

    @property
    def facet_parts(self) -> Array:
        """The part or band of each facet, a number in `names`: int32."""
        return self._state.facets[2]

    @property
    def facet_owners(self) -> Array:
        """The feature of each facet in the mesh of its part: uint64; 0 for none, as in bands."""
        return self._state.facets[3]

    @property
    def facet_markers(self) -> Array:
        """The marker of each facet: int64, 0 without one."""
        return self._state.facets[4]

    @property
    def facet_names(self) -> Array:
        """The name of each facet: str, empty without one."""
        return self._state.facets[5]

    def to_meshio(self, point_data: Optional[Mapping[str, Array]] = None,
                  cell_data: Optional[Mapping[str, Array]] = None) -> meshio.Mesh:
        """The assembly for meshio, as `Part.to_meshio`; `region` is `cell_regions` + 1.

        Args:
            point_data: arrays with one row per vertex, by name.
            cell_data: arrays with one row per cell, by name; of facets they are 0.
        """
        return to_meshio(self, point_data, cell_data, "the assembly")

    # How `_solvers` and `_meshio` read it.
    def _region_labels(self) -> dict[int, tuple[int, Label]]:
        state = self._state
        labels = [label for piece in state.pieces.values() for label in piece.labels]
        labels += [band.label for band in state.bands.values()]
        return {k: (k + 1, label) for k, label in enumerate(labels)}

    def _write(self, path: str, choices: dict[str, Any]) -> None:
        rows = self._region_labels()
        facets, _, parts, owners, markers, names = self._state.facets
        # Features of several meshes have the same ids: they are numbered after the regions.
        _, found, which = np.unique(np.column_stack([parts.astype(np.uint64), owners]), axis=0,
                                    return_index=True, return_inverse=True)
        first = len(rows) + 1
        labels = [(k + 1, label.marker, label.name) for k, (_, label) in rows.items()]
        labels += [(first + number, int(markers[at]), str(names[at]))
                   for number, at in enumerate(found.tolist())]
        _core.write_rows(self.points, self.cells, self.cell_regions.astype(np.uint64) + 1, facets,
                         which.reshape(-1).astype(np.uint64) + first,
                         [row for row in labels if row[1] or row[2]], path, choices)

    def _check_new(self, name: str) -> None:
        if not isinstance(name, str) or not name:
            raise InvalidArgument(f"name: the name of a part or band is a string, not empty, and got {name!r}")
        if name in self._state.names:
            raise AlreadyExists(f"the assembly has {name!r} already")

    def _side(self, what: str, curve: Any, is_inner: bool) -> Side:
        if _is_of_part(curve):
            self.frame(curve[0])
            return match(curve[0], self._pieces[curve[0]].part, curve[1], is_inner, what)
        at = closed_curve(curve, what)
        return Side("", at if area_of(at) > 0 else at[::-1], np.empty(0, np.int32))

    def _place_one(self, name: str, **change: Any) -> Motion:
        with self._lock:
            return self.place({name: replace(self.frame(name), **change)})

    def _rows(self, starts: Array, name: str) -> slice:
        if name not in self._state.names:
            there = ", ".join(self._state.names) or "none"
            raise NotFound(f"there is no part or band {name!r}; there are: {there}")
        k = self._state.names.index(name)
        return slice(int(starts[k]), int(starts[k + 1]))

    def _set(self, pieces: dict[str, Piece], bands: dict[str, Band], frames: dict[str, Frame]) -> Motion:
        """Makes the state of these; nothing changes if a band cannot be meshed."""
        former, meshed, diffs = self._state, {}, {}
        done: list[Band] = []
        try:
            for name, band in bands.items():
                mesh, part, diffs[name] = band.meshed(frames)
                done.append(band)
                unchanged = diffs[name] is None and former.bands.get(name) is band
                meshed[name] = former.meshed[name] if unchanged else band_state(band, mesh, part)
            state = State(pieces, bands, frames, meshed)
        except Exception:
            for band in done:
                if self._bands.get(band.name) is band:  # back again, in other slots
                    mesh, part, _ = band.meshed(self._frames)
                    former.meshed[band.name] = band_state(band, mesh, part)
                    self._motion = None
            raise
        self._pieces, self._bands, self._frames, self._state = pieces, bands, frames, state
        self._motion = Motion(self, former, state, diffs)
        return self._motion


def _label_of(what: str, label: LabelLike) -> Label:
    if isinstance(label, Label):
        return label
    if not isinstance(label, Mapping) or set(label) - {"marker", "name"}:
        raise InvalidArgument(f"{what}: a label is dict(marker=, name=) or dynmesh.Label, and got {label!r}")
    return Label(**label)


def _is_of_part(curve: Any) -> bool:
    return isinstance(curve, (tuple, list)) and len(curve) == 2 and isinstance(curve[0], str)


def _is_several(curves: Any) -> bool:
    """A list of curves, rather than one?"""
    if _is_of_part(curves) or not isinstance(curves, (list, tuple)) or not curves:
        return False
    return _is_of_part(curves[0]) or np.ndim(curves[0]) == 2
