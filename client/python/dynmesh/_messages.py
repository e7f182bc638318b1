"""Between the protocol's messages and what the extension module takes: as proto/codec in C++."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Optional

import numpy as np

from dynmesh import _core
from dynmesh.errors import DataLoss, DynmeshError, make
from dynmesh.v1 import geometry_pb2, mesh_pb2, status_details_pb2

_KINDS = {"delaunay": 1, "quadtree": 2, "triangulation": 3}
_CRITERIA = {"edge": 1, "thesis": 2}
_DOMAIN = "type.googleapis.com/google.rpc."
_CODES = ("OK", "CANCELLED", "UNKNOWN", "INVALID_ARGUMENT", "DEADLINE_EXCEEDED", "NOT_FOUND",
          "ALREADY_EXISTS", "PERMISSION_DENIED", "RESOURCE_EXHAUSTED", "FAILED_PRECONDITION",
          "ABORTED", "OUT_OF_RANGE", "UNIMPLEMENTED", "INTERNAL", "UNAVAILABLE", "DATA_LOSS",
          "UNAUTHENTICATED")


# ---- what is sent

def point(place: Sequence[float]) -> Any:
    """A place of 2 or 3 coordinates."""
    return geometry_pb2.Point(x=place[0], y=place[1], z=place[2] if len(place) == 3 else None)


def _polygon(rings: Iterable[Iterable[int]]) -> Any:
    return geometry_pb2.Polygon(rings=[geometry_pb2.Polygon.Ring(points=ring) for ring in rings])


def _size(feature: dict[str, Any]) -> Any:
    size = geometry_pb2.Sizing(target=feature["target"])
    if "rings" in feature:
        size.polygon.CopyFrom(_polygon(feature["rings"]))
    elif "path" in feature:
        size.capsule.vertices.extend(point(vertex) for vertex in feature["path"])
        size.capsule.radius = feature["radius"]
    elif "low" in feature:
        size.box.lo.CopyFrom(point(feature["low"]))
        size.box.hi.CopyFrom(point(feature["high"]))
    elif "radius" in feature:
        size.disc.centre.CopyFrom(point(feature["at"]))
        size.disc.radius = feature["radius"]
    else:
        size.point.CopyFrom(point(feature["at"]))
    return size


def _label(feature: dict[str, Any]) -> Any:
    return geometry_pb2.FeatureLabel(marker=feature.get("marker", 0), name=feature.get("name", ""))


def feature_message(feature: dict[str, Any]) -> Any:
    """A feature, from the dict that the extension module makes of it."""
    message = geometry_pb2.Feature(id=feature["id"], unsplit=feature.get("unsplit", False))
    if "marker" in feature:
        message.label.CopyFrom(_label(feature))
    if feature["kind"] == "point":
        message.point.CopyFrom(point(feature["at"]))
    elif feature["kind"] == "segment":
        message.segment.p, message.segment.q = feature["ends"]
    elif feature["kind"] == "polygon":
        message.polygon.CopyFrom(_polygon(feature["rings"]))
    else:
        message.size.CopyFrom(_size(feature))
    return message


def edit_messages(batch: Any) -> list[Any]:
    """The edits of the extension module's batch."""
    messages = []
    for action, feature in _core.edits_of(batch):
        edit = geometry_pb2.Edit()
        if action == "add":
            edit.add.CopyFrom(feature_message(feature))
        elif action == "set":
            edit.set.CopyFrom(feature_message(feature))
        elif action == "remove":
            edit.remove = feature["id"]
        elif action == "move":
            edit.move.id = feature["id"]
            edit.move.to.CopyFrom(point(feature["at"]))
        else:
            edit.set_label.id = feature["id"]
            edit.set_label.label.CopyFrom(_label(feature))
        messages.append(edit)
    return messages


def options_message(options: dict[str, Any]) -> Any:
    """The options of a new mesh."""
    every = _core.all_options(options)
    message = mesh_pb2.MeshOptions(
        dimension=every["dimension"], quality=every["rho"],
        criterion=_CRITERIA[every["criterion"]], max_vertices=options.get("max_vertices", 0),
        max_edge=every["max_edge"], min_dihedral=every["min_dihedral"], kind=_KINDS[every["kind"]])
    message.box.lo.CopyFrom(point(every["box"][0]))
    message.box.hi.CopyFrom(point(every["box"][1]))
    return message


# ---- what is received

def _place(message: Any, dimension: int) -> tuple[float, ...]:
    place = (message.x, message.y, message.z)
    return place[:dimension]


def options_of(message: Any) -> dict[str, Any]:
    """The options of a mesh, as those of the extension module's."""
    dimension = message.dimension or 2
    given: dict[str, Any] = {
        "dimension": dimension, "rho": message.quality, "max_edge": message.max_edge,
        "max_vertices": message.max_vertices,
        "criterion": "thesis" if message.criterion == _CRITERIA["thesis"] else "edge",
        "kind": next((name for name, kind in _KINDS.items() if kind == message.kind), "delaunay"),
        "box": [list(_place(message.box.lo, dimension)), list(_place(message.box.hi, dimension))]}
    if message.HasField("min_dihedral"):
        given["min_dihedral"] = message.min_dihedral
    every: dict[str, Any] = _core.all_options(given)
    return every


def info_of(message: Any) -> dict[str, Any]:
    """What the server tells of a mesh."""
    has_options = message.HasField("options")
    return {"id": message.name.split("/", 1)[-1], "revision": message.revision,
            "hash": message.hash or "0" * 32,
            "options": options_of(message.options) if has_options else _core.all_options({}),
            "damage": message.damage, "owner": message.owner,
            "read_only": has_options and message.damage != ""}


def feature_of(message: Any, dimension: int) -> dict[str, Any]:
    """A feature as the dict that the extension module makes of it."""
    kind = message.WhichOneof("geometry")
    feature: dict[str, Any] = {"id": message.id, "kind": kind}
    if kind == "point":
        feature["at"] = _place(message.point, dimension)
    elif kind == "segment":
        feature["ends"] = (message.segment.p, message.segment.q)
    elif kind == "polygon":
        feature["rings"] = [list(ring.points) for ring in message.polygon.rings]
    elif kind == "size":
        size = message.size
        feature["target"] = size.target
        region = size.WhichOneof("region")
        if region == "polygon":
            feature["rings"] = [list(ring.points) for ring in size.polygon.rings]
        elif region == "capsule":
            feature["path"] = [_place(vertex, dimension) for vertex in size.capsule.vertices]
            feature["radius"] = size.capsule.radius
        elif region == "box":
            feature["low"] = _place(size.box.lo, dimension)
            feature["high"] = _place(size.box.hi, dimension)
        elif region == "disc":
            feature["at"] = _place(size.disc.centre, dimension)
            feature["radius"] = size.disc.radius
        else:
            feature["at"] = _place(size.point, dimension)
    else:
        raise DataLoss("the server sent a feature of a kind that is not known here")
    if message.unsplit:
        feature["unsplit"] = True
    if message.HasField("label"):
        feature["marker"], feature["name"] = message.label.marker, message.label.name
    return feature


class _Columns:
    """Columns in parts."""

    def __init__(self) -> None:
        self._parts: dict[str, list[Any]] = {}
        self._regions: dict[str, int] = {}
        self.sets: dict[int, list[int]] = {}
        self.labels: list[tuple[int, int, str]] = []

    def _add(self, name: str, values: Any, dtype: Any) -> None:
        self._parts.setdefault(name, []).append(np.fromiter(values, dtype, len(values)))

    def ids(self, name: str, values: Any) -> None:
        self._add(name, values, np.uint64)

    def vertices(self, message: Any) -> None:
        self._add("vertices", message.ids, np.uint64)
        self._add("coordinates", message.coordinates, np.float64)
        self._add("containing_dimensions", message.containing_dimensions, np.uint8)
        self._add("owners", message.owners, np.uint64)

    def simplices(self, name: str, regions: str, message: Any, dimension: int) -> None:
        """Regions are a column for all, if one part has them."""
        self._add(name, message.vertex_ids, np.uint64)
        rows = len(message.vertex_ids) // (dimension + 1)
        if message.regions:
            self._add(regions, message.regions, np.uint64)
            self._regions[regions] = 1
        else:
            self._parts.setdefault(regions, []).append(np.zeros(rows, np.uint64))
        for region in message.region_sets:
            self.sets[region.id] = list(region.polygons)

    def constraints(self, name: str, corners: Any, owners: Any) -> None:
        self._add(name, corners, np.uint64)
        self._add(f"{name}_owners", owners, np.uint64)

    def label(self, message: Any) -> None:
        rows = len(message.features)
        markers = message.markers or [0] * rows
        names = message.names or [""] * rows
        self.labels.extend(zip(message.features, markers, names))

    def all(self, **others: Any) -> dict[str, Any]:
        """All columns as arrays."""
        arrays = {name: np.concatenate(parts) for name, parts in self._parts.items()}
        for name in arrays:
            if name.endswith("regions") and name not in self._regions:
                arrays[name] = np.zeros(0, np.uint64)
        return {**arrays, "region_sets": sorted(self.sets.items()), "labels": self.labels, **others}


class SnapshotParts:
    """Joins the chunks of a snapshot."""

    def __init__(self) -> None:
        self._columns: Optional[_Columns] = None
        self._next = 0

    def add(self, chunk: Any) -> Any:
        """The snapshot, after its last chunk; else None."""
        if chunk.index == 0:
            self._columns, self._next = _Columns(), 0
        if self._columns is None or chunk.index != self._next:
            raise DataLoss("a snapshot's chunk is lost")
        self._next += 1
        columns = self._columns
        columns.vertices(chunk.vertices)
        columns.simplices("simplices", "regions", chunk.simplices, chunk.dimension)
        columns.constraints("subsegments", chunk.subsegments.ends, chunk.subsegments.owners)
        columns.constraints("subfacets", chunk.subfacets.corners, chunk.subfacets.owners)
        columns.label(chunk.labels)
        if chunk.more:
            return None
        self._columns = None
        return _core.snapshot_of(columns.all(dimension=chunk.dimension, revision=chunk.revision,
                                             hash=chunk.hash))


class DiffParts:
    """Joins the fragments of a diff."""

    def __init__(self) -> None:
        self._columns: Optional[_Columns] = None

    def add(self, part: Any) -> Any:
        """The diff, after its last fragment; else None."""
        columns = self._columns = self._columns or _Columns()
        columns.ids("removed_vertices", part.removed_vertices)
        columns.simplices("removed_simplices", "removed_regions", part.removed_simplices,
                          part.dimension)
        columns.constraints("removed_subsegments", part.removed_subsegments.ends,
                            part.removed_subsegments.owners)
        columns.constraints("removed_subfacets", part.removed_subfacets.corners,
                            part.removed_subfacets.owners)
        columns.vertices(part.added_vertices)
        columns.simplices("simplices", "regions", part.added_simplices, part.dimension)
        columns.constraints("subsegments", part.added_subsegments.ends,
                            part.added_subsegments.owners)
        columns.constraints("subfacets", part.added_subfacets.corners, part.added_subfacets.owners)
        columns.label(part.labels)
        if part.more:
            return None
        self._columns = None
        work = {field.name: getattr(part.work, field.name) for field in part.work.DESCRIPTOR.fields}
        return _core.diff_of(columns.all(
            dimension=part.dimension, from_revision=part.from_revision,
            to_revision=part.to_revision, hash=part.hash, replayed=part.replayed, work=work))


def error_of(code: str, message: str, details: Iterable[Any]) -> DynmeshError:
    """The exception for a status, with the details of status_details.proto."""
    reason, field, features, edit, retry_after, owner = "", "", [], None, None, ""
    for detail in details:
        if detail.type_url == f"{_DOMAIN}ErrorInfo":
            info = status_details_pb2.ErrorInfo.FromString(detail.value)
            reason, owner = info.reason, info.metadata.get("owner", "")
            features = [int(i) for i in info.metadata.get("features", "").split(",") if i]
        elif detail.type_url == f"{_DOMAIN}BadRequest":
            bad = status_details_pb2.BadRequest.FromString(detail.value)
            field = bad.field_violations[0].field if bad.field_violations else ""
        elif detail.type_url == f"{_DOMAIN}RetryInfo":
            delay = status_details_pb2.RetryInfo.FromString(detail.value).retry_delay
            retry_after = delay.seconds + delay.nanos * 1e-9
    if "edits[" in field:
        edit = int(field.split("edits[", 1)[1].split("]", 1)[0])
    error = make(code, message, reason, features, edit, field, retry_after)
    error.__dict__["owner"] = owner
    return error


def error_of_status(status: Any) -> DynmeshError:
    """The exception for a status in a message."""
    code = _CODES[status.code] if 0 <= status.code < len(_CODES) else "UNKNOWN"
    return error_of(code, status.message, status.details)
