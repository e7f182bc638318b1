"""The band of an assembly: a mesh of its own between curves, whose edges stay whole."""
from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from dynmesh._diff import Diff
from dynmesh._part import Part
from dynmesh._types import Array, Label
from dynmesh.errors import DynmeshError, FailedPrecondition, InvalidArgument

if TYPE_CHECKING:
    from dynmesh._mesh import Mesh

_HAIR = 1e-9  # of a radius: two circles with centres that near have one centre
_LAYER = math.sqrt(3) / 2  # height of a layer of equal triangles, in edges
_OFF_BEAT = 7  # by how many vertices rings that pass each other differ, at least


@dataclass(frozen=True)
class Frame:
    """Where a part is: turned about a pivot, then shifted. A part with another pivot is elsewhere."""

    angle: float = 0.0  #: Radians, counter-clockwise.
    shift: tuple[float, float] = (0.0, 0.0)  #: Added after the turn, in the world's axes.
    pivot: tuple[float, float] = (0.0, 0.0)  #: What the turn leaves in its place, in the part's coordinates.

    def place(self, points: Array) -> Array:
        """The `points` of the part, of the shape (n, 2), in the world; without a turn or shift the same bits."""
        at = np.array(points, dtype=np.float64)
        if self.angle != 0:
            at = self.turn(at - np.array(self.pivot)) + np.array(self.pivot)
        return at + np.array(self.shift) if any(self.shift) else at

    def turn(self, vectors: Array) -> Array:
        """The `vectors` of the part, of the shape (n, 2), in the world's axes."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        turned: Array = np.asarray(vectors) @ np.array([[c, s], [-s, c]])
        return turned


@dataclass(frozen=True)
class Side:
    """A curve of a band: of a part, with its vertices there, or fixed in the world."""

    part: str  #: Empty: of none.
    curve: Array  #: In the part's coordinates, counter-clockwise: (n, 2).
    vertices: Array  #: Their numbers in the part: int32; empty without a part.

    @cached_property
    def circle(self) -> Optional[tuple[Array, float]]:
        """Centre and radius, if the curve's vertices are on a circle."""
        middle = self.curve.mean(axis=0)
        at = self.curve - middle
        found = np.linalg.lstsq(np.column_stack([2 * at, np.ones(len(at))]), (at**2).sum(axis=1), rcond=None)[0]
        radius = math.sqrt(max(0.0, float(found[2] + found[:2] @ found[:2])))
        off = np.abs(np.linalg.norm(at - found[:2], axis=1) - radius).max()
        return (middle + found[:2], radius) if off <= _HAIR * radius else None

    def __str__(self) -> str:
        return f"the curve of part {self.part!r}" if self.part else "a curve without a part"


def area_of(curve: Array) -> float:
    """Above 0 if the curve is counter-clockwise."""
    after = np.roll(curve, -1, axis=0)
    return float((curve[:, 0] * after[:, 1] - curve[:, 1] * after[:, 0]).sum() / 2)


def are_inside(places: Array, curve: Array) -> Array:
    """Which of the places are inside the closed curve? O(places x curve)."""
    x, y = places[:, :1], places[:, 1:]
    a, b = curve, np.roll(curve, -1, axis=0)
    across = (a[:, 1] > y) != (b[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    inside: Array = (across & (at > x)).sum(axis=1) % 2 == 1
    return inside


def ring_counts(inner: tuple[float, int], outer: tuple[float, int],
                spacing: Optional[float]) -> list[tuple[float, int]]:
    """Radii and numbers of vertices of the rings between two circles of (radius, vertices).

    Triangles between them are about as high as wide. Neighbours that pass each other have numbers
    that differ by one that is odd and no multiple of 3 or 5: what the band's mesh does to a solution as one vertex
    passes another then differs from place to place, and adds up to next to nothing.
    """
    width = outer[0] - inner[0]
    first, last = (2 * math.pi * radius / count for radius, count in (inner, outer))
    heights = _layers(width, first, last, spacing)
    rings = []
    for layer, part in enumerate(np.cumsum(heights)[:-1] / sum(heights), 1):
        radius = inner[0] + width * float(part)
        edge = spacing if spacing is not None else first + (last - first) * float(part)
        count = max(3, round(2 * math.pi * radius / edge))
        beside = ([inner[1]] if layer == 1 else []) + (
            [outer[1]] if layer == len(heights) - 1 else [])
        rings.append((radius, _off_beat(count, beside)))
    return rings


def _layers(width: float, first: float, last: float, spacing: Optional[float]) -> list[float]:
    """Heights, as parts of a sum, of layers between curves with edges of the lengths `first` and `last`."""
    if spacing is not None:
        # No ring comes into the circles over edges of the curves, however fine it is.
        ends = [_LAYER * max((edge + spacing) / 2, 0.75 * edge) for edge in (first, last)]
        for between in range(round((width - sum(ends)) / (_LAYER * spacing)), -1, -1):
            heights = [ends[0], *[_LAYER * spacing] * between, ends[1]]
            if width / sum(heights) * min(ends[0] / first, ends[1] / last) > 0.57:
                return heights
        return [width]
    ratio = last / first
    mean = first if abs(ratio - 1) < 1e-6 else (last - first) / math.log(ratio)
    layers = max(1, round(width / (_LAYER * mean)))
    return [ratio**(layer / layers) for layer in range(layers)]


def _off_beat(count: int, beside: list[int]) -> int:
    """The number nearest to `count` that is out of step with those beside it."""
    def is_out(number: int) -> bool:
        return all(math.gcd(number - other, 30) == 1
                   and abs(number - other) >= min(_OFF_BEAT, other // 12) for other in beside)

    for off in range(count):
        for number in (count + off, count - off):
            if number >= 3 and is_out(number):
                return number
    return count


class Band:
    """The mesh between an outer curve and one or more inner ones.

    Its axes are the world's. Its origin goes with the shift of the outer curve's part.
    """

    def __init__(self, name: str, outer: Side, inner: list[Side], spacing: Optional[float], label: Label,
                 border: Label) -> None:
        self.name, self.outer, self.inner, self.spacing = name, outer, inner, spacing
        self.label, self.border = label, border
        self.sides = [outer, *inner]
        self.starts = np.cumsum([1] + [len(side.curve) for side in self.sides])
        self.polygon = 2**62  # beyond the ids of points, of which there are fewer
        self._mesh: Optional[Mesh] = None
        self._part: Optional[Part] = None
        self._at, self._rings = np.zeros((0, 2)), np.zeros((0, 2))

    def meshed(self, frames: dict[str, Frame]) -> tuple[Mesh, Part, Optional[Diff]]:
        """The mesh with its sides in these frames, and the diff that led there."""
        curves, rings = self._features(frames)
        self._check_nesting(curves)
        first, end = int(self.starts[0]), int(self.starts[-1])
        ids, at = np.arange(first, end), np.vstack(curves)
        try:
            if self._mesh is None or self._part is None:
                return self._opened(frames, curves, rings)
            edits: dict[str, Any] = {}
            if not np.array_equal(rings, self._rings):
                if len(self._rings):
                    edits["remove"] = list(range(end, end + len(self._rings)))
                if len(rings):
                    edits["add_points"] = (np.arange(end, end + len(rings)), rings)
            moved = (at != self._at).any(axis=1)
            if moved.any():
                edits["move_points"] = (ids[moved], at[moved])
            had, has = len(self._sizes(self._rings)), len(self._sizes(rings))
            if has > had:
                edits["add_sizes"] = self._sizes(rings)
            elif had > has:
                edits["remove"] = [*edits.get("remove", []), self.polygon + 1]
            if not edits:
                return self._mesh, self._part, None
            diff = self._mesh.apply(**edits)
        except DynmeshError as error:
            raise self._named(error, np.vstack([at, rings])) from error
        self._part.update(diff)
        self._rings, self._at = rings, at
        return self._mesh, self._part, diff

    def _opened(self, frames: dict[str, Frame], curves: list[Array],
                rings: Array) -> tuple[Mesh, Part, None]:
        from dynmesh._server import open as open_mesh

        frame = frames.get(self.outer.part, Frame())
        pivot = np.array(frame.pivot)
        reach = 1.01 * np.linalg.norm(self.outer.curve - pivot, axis=1).max()
        if not self.outer.part:  # it does not turn
            low, high = self.outer.curve.min(axis=0), self.outer.curve.max(axis=0)
        else:
            low, high = pivot - reach, pivot + reach
        mesh = open_mesh([low.tolist(), high.tolist()])
        at = np.vstack([*curves, rings])
        edits: dict[str, Any] = dict(add_points=(np.arange(1, len(at) + 1), at),
                                     add_polygons={self.polygon: self._loops()}, unsplit=[self.polygon])
        if self._sizes(rings):
            edits["add_sizes"] = self._sizes(rings)
        mesh.apply(**edits)
        self._mesh, self._part = mesh, mesh.part(polygons=self.polygon)
        self._rings, self._at = rings, np.vstack(curves)
        return mesh, self._part, None

    def _loops(self) -> list[list[int]]:
        """The ids of the points of each curve."""
        starts = self.starts.tolist()
        return [list(range(a, b)) for a, b in zip(starts[:-1], starts[1:])]

    def _sizes(self, rings: Array) -> dict[int, Any]:
        """The target length in the band. Between rings there is nothing to refine."""
        if self.spacing is None or len(rings):
            return {}
        return {self.polygon + 1: dict(target=self.spacing, rings=self._loops()[:1])}

    def origin(self, frames: dict[str, Frame]) -> Array:
        """Of the band's coordinates, in the world."""
        return np.array(frames.get(self.outer.part, Frame()).shift)

    def _features(self, frames: dict[str, Frame]) -> tuple[list[Array], Array]:
        """The curves in the band's coordinates, and the vertices of the rings between circles."""
        origin = self.origin(frames)
        curves, centres = [], []
        for side in self.sides:
            frame = frames.get(side.part, Frame())
            shift = (frame.shift[0] - origin[0], frame.shift[1] - origin[1])
            frame = Frame(frame.angle, shift, frame.pivot)
            curves.append(frame.place(side.curve))
            if side.circle is not None:
                middle, radius = side.circle
                if np.abs(middle - frame.pivot).max() <= _HAIR * radius:
                    middle = np.array(frame.pivot)  # it does not tremble as the part turns
                centres.append((frame.place(middle[None])[0], radius))
        rings: list[Array] = []
        if len(self.sides) == 2 and len(centres) == 2:
            (middle, reach), (other, radius) = centres
            if np.abs(middle - other).max() <= _HAIR * reach and radius < reach:
                for r, count in ring_counts((radius, len(self.inner[0].curve)),
                                            (reach, len(self.outer.curve)), self.spacing):
                    angle = 2 * np.pi * np.arange(count) / count
                    rings.append(middle + r * np.column_stack([np.cos(angle), np.sin(angle)]))
        return curves, np.vstack(rings) if rings else np.zeros((0, 2))

    def _check_nesting(self, curves: list[Array]) -> None:
        """Raises unless the inner curves are in the outer one, and beside each other."""
        for k, (side, curve) in enumerate(zip(self.inner, curves[1:]), 1):
            inside = are_inside(curve, curves[0])
            if not inside.any():
                raise InvalidArgument(f"band {self.name!r}: {side} is not inside {self.outer}: it is at "
                                      f"{_place(curve[0])} in the frames of now")
            if not inside.all():
                raise self._touching(curve[~inside][0])
            for other in curves[1:k]:
                for one, another in ((curve, other), (other, curve)):
                    inside = are_inside(one, another)
                    if inside.all():
                        raise InvalidArgument(
                            f"band {self.name!r}: two inner curves are one inside the other, at {_place(one[0])}; a "
                            "band has inner curves beside each other: make it two bands")
                    if inside.any():
                        raise self._touching(one[inside][0])

    def _touching(self, place: Array) -> FailedPrecondition:
        return FailedPrecondition(f"band {self.name!r}: its curves touch or cross near {_place(place)}; between "
                                  "them there has to be a gap in each position of the parts")

    def _named(self, error: DynmeshError, at: Array) -> DynmeshError:
        """The error in terms of the curves."""
        points: list[int] = []
        for id_ in error.features:
            if 0 < id_ <= len(at):
                points.append(int(id_) - 1)
        where = f" near {_place(at[points[0]])}" if points else ""
        reason = error.reason
        if reason == "ENCROACHED":
            text = (f"band {self.name!r}: its curves are nearer to each other than half of an edge{where}, too "
                    "near for their spacing, or an edge of one is too long beside an edge of the same: give "
                    f"the curves points at a smaller spacing (dynmesh.points_along), or a wider gap: {error}")
        elif reason in ("SEGMENTS_CROSS", "SEGMENTS_OVERLAP", "POINT_ON_SEGMENT", "TOO_CLOSE",
                        "DUPLICATE_POINT", "DUPLICATE_SEGMENT", "OUTSIDE_BOX"):
            text = f"{self._touching(at[points[0]] if points else at[0])}: {error}"
        else:
            text = f"band {self.name!r}: {error}"
        named = type(error)(text)
        named.code, named.reason = error.code, reason
        return named


def match(name: str, part: Part, curve: Any, is_inner: bool, what: str) -> Side:
    """The curve as a border of the part. Raises what is wrong with it."""
    at = closed_curve(curve, what)
    border = part.facets[part.is_border]
    numbers = np.unique(border)
    places = part.points[numbers]
    known = {place: number for place, number in zip(map(tuple, places.tolist()), numbers.tolist())}
    vertices = []
    reach = float(np.abs(places).max()) if len(places) else 0.0
    for place in at:
        number = known.get(tuple(place.tolist()))
        if number is None:
            apart = np.linalg.norm(places - place, axis=1)
            if not len(apart) or apart.min() > _HAIR * reach:
                far = f"the nearest is {apart.min():.3g} away" if len(apart) else "it has no border"
                raise InvalidArgument(
                    f"{what}: part {name!r} has no vertex at {_place(place)} on its border; {far}. A curve is given "
                    "in the part's own coordinates, by the points that its border has there")
            number = int(numbers[apart.argmin()])
        vertices.append(number)
    edges = {(a, b) for a, b in border.tolist()}
    chain = list(zip(vertices, vertices[1:] + vertices[:1]))
    forward = [pair in edges for pair in chain]
    backward = [(b, a) in edges for a, b in chain]
    if not any(forward + backward):
        raise InvalidArgument(f"{what}: no edge of the curve is an edge of the border of part {name!r}: a part is "
                              "bounded by its curve, with the same points in the same order")
    for k, (ahead, behind) in enumerate(zip(forward, backward)):
        if ahead or behind:
            continue
        a, b = part.points[vertices[k]], part.points[chain[k][1]]
        if k == len(at) - 1:
            raise InvalidArgument(f"{what}: the curve does not close: its last point {_place(a)} and its first "
                                  f"{_place(b)} are not joined by an edge of the border of part {name!r}")
        between = is_between(places, a, b)
        more = ("; the mesh has put vertices between them: mark the curve unsplit there (unsplit= of "
                "Mesh.apply)" if between else "; the part is not bounded by its curve there")
        raise InvalidArgument(f"{what}: {_place(a)} and {_place(b)} are not joined by an edge of the "
                              f"border of part {name!r}{more}")
    # The part is on the left of its border.
    is_ahead = area_of(at) > 0
    if any(ahead != (is_ahead == is_inner) for ahead in forward):
        raise InvalidArgument(f"{what}: part {name!r} is on the side of its curve where the band would be: the part of "
                              "an inner curve is inside it, that of the outer curve outside of it")
    found = np.array(vertices, np.int32)
    own = part.points[found]
    return Side(name, *((own, found) if is_ahead else (own[::-1], found[::-1])))


def closed_curve(curve: Any, what: str) -> Array:
    """Its places, the first one not repeated."""
    try:
        at = np.array(curve, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidArgument(f"{what}: a curve is an array of places, of the shape (n, 2), and got "
                              f"{type(curve).__name__}; of a part it is (name of the part, curve)") from None
    if at.ndim == 2 and at.shape[1] == 3:
        raise InvalidArgument(f"{what}: assemblies are of two dimensions: in space no border stays whole")
    if at.ndim != 2 or at.shape[1] != 2 or not np.isfinite(at).all():
        raise InvalidArgument(f"{what}: a curve is an array of finite places, of the shape (n, 2), and got one of "
                              f"the shape {at.shape}")
    if len(at) > 1 and np.array_equal(at[0], at[-1]):
        at = at[:-1]
    if len(at) < 3:
        raise InvalidArgument(f"{what}: a closed curve has three points or more, and got {len(at)}")
    places, counts = np.unique(at, axis=0, return_counts=True)
    if len(places) < len(at):
        raise InvalidArgument(f"{what}: the curve is at {_place(places[counts > 1][0])} more than once; it may not "
                              "touch itself")
    return at


def is_between(places: Array, a: Array, b: Array) -> bool:
    """Is one of the places on the segment, beside its ends?"""
    along = b - a
    part = (places - a) @ along / (along @ along)
    off = np.abs((places - a) @ np.array([-along[1], along[0]])) / (along @ along)
    return bool(((part > _HAIR) & (part < 1 - _HAIR) & (off < _HAIR)).any())


def check_free(what: str, is_used: bool) -> None:
    """Raises if edges of a curve are those of another band."""
    if is_used:
        raise FailedPrecondition(f"{what}: another band has edges of this curve; a border of a part is that of one band")


def _place(at: Array) -> str:
    return f"({at[0]:.6g}, {at[1]:.6g})"
