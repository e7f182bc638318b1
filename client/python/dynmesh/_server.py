"""Meshes at a server, and meshes in this process."""
from __future__ import annotations

import importlib.util
import logging
import os
import pathlib
import time
import uuid
from collections import deque
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any, Callable, Optional, TypeVar, Union

import numpy as np

from dynmesh import _core
from dynmesh._types import Array
from dynmesh._diff import Diff
from dynmesh._mesh import Mesh, Progress
from dynmesh._options import check_options, named_options
from dynmesh.errors import AlreadyExists, DynmeshError, FailedPrecondition, NotFound, Unavailable, \
    VersionMismatch

T = TypeVar("T")
_log = logging.getLogger("dynmesh")
_LONGEST_PAUSE = 0.5  # in seconds; a call to a server that cannot be reached costs nothing
_SILENT = 2.0  # the same: after that a call that waits for the server says so
_GLANCE = 0.05  # the same: how often a pause looks whether the server is back
Pem = Union[str, bytes, "os.PathLike[str]", None]


def connect(address: str, *, token: str = "", tls_ca: Pem = None, tls_certificate: Pem = None,
            tls_key: Pem = None, timeout: float = 0.0, retry_for: float = 30.0,
            any_version: bool = False, from_followers: bool = False) -> Server:
    """The server at `address`. Does not connect yet: the first call fails if it is unreachable.

    Args:
        address: "host:port"; of servers that share their meshes, some of them with commas between.
        token: sent with every call.
        tls_ca: certificates that sign the server's, as PEM text or a path. If given, the connection
            is encrypted.
        tls_certificate: the client's certificate, for a server that requires one; PEM text or a
            path.
        tls_key: the key of the client's certificate; PEM text or a path.
        timeout: limit of a call, in seconds; 0: none.
        retry_for: for how many seconds a call is retried while the server is unavailable. Edits
            have ids, so none is applied twice. A call that waits for more than two seconds says
            so, as a warning of the logger "dynmesh".
        any_version: accepts a server of another version. Otherwise the first call raises
            `VersionMismatch` if the first two numbers of the versions differ.
        from_followers: reads ask the first server of `address` that can be reached, which may
            follow the mesh of another one. They may be some ten milliseconds old, but are never
            older than what this connection has seen.
    """
    return Server(address, token=token, tls_ca=tls_ca, tls_certificate=tls_certificate,
                  tls_key=tls_key, timeout=timeout, retry_for=retry_for, any_version=any_version,
                  from_followers=from_followers)


def open(box: Any = None, **options: Any) -> Mesh:  # noqa: A001
    """A mesh in this process, without a server.

    **The mesh reaches far beyond the box**, about six times as far, in 3D eight times, so that nothing
    but the features shapes it. `Mesh.part` is what polygons enclose.

    Args:
        box: the box of the features: two corners ((x, y), (x, y)), in 3D with z, the second above
            the first in each axis. Default: from 0 to 1.
        options: `dimension`: 2 or 3. `kind`: "delaunay"; "quadtree" for a size-conforming
            quadtree (octree), which has one vertex for each leaf, at its centre; or in 2D
            "triangulation" for the constrained Delaunay triangulation of points and segments,
            without Steiner points. Only "delaunay" has the next four options. `rho`: the largest
            circumradius / shortest edge. `criterion`: "edge" or "thesis". `max_edge`: no edge in the box is longer than sqrt 2 times this.
            `min_dihedral`: in 3D, tetrahedra with a dihedral angle below it, in degrees, are
            removed where Steiner points can do so; 0 leaves slivers. Default: 10, in 2D 0.
            `max_vertices`: an edit that would exceed it raises `LimitExceeded`.
    """
    if box is not None:
        options["box"] = box
    with named_options():
        mesh = _core.open_mesh(check_options(options))
    return Mesh(_Local(), mesh, mesh.options())


def _pem(text: Pem) -> str:
    if text is None:
        return ""
    if isinstance(text, bytes):
        text = text.decode()
    if isinstance(text, str) and "-----BEGIN" in text:
        return text
    return pathlib.Path(text).read_text(encoding="ascii")


def _client_class() -> Any:
    """The client: of the extension module `_service`, which links gRPC, or else over grpcio.

    Imported by the first `connect`.
    """
    if importlib.util.find_spec("dynmesh._service") is not None:
        from dynmesh import _service

        return _service.Client
    try:
        import google.protobuf
        import grpc
    except ImportError as error:
        raise ImportError("the client of a server needs the packages grpcio and protobuf: "
                          "pip install 'dynmesh[service]'") from error
    from dynmesh import _grpcio

    return _grpcio.Client


class Server:
    """A server's meshes. A context manager; thread-safe."""

    def __init__(self, address: str, *, token: str, tls_ca: Pem, tls_certificate: Pem, tls_key: Pem,
                 timeout: float, retry_for: float, any_version: bool,
                 from_followers: bool) -> None:
        #: The given "host:port".
        self.address: str = address
        self._client = _client_class()(address, token, _pem(tls_ca), _pem(tls_certificate),
                                       _pem(tls_key), timeout, from_followers)
        self._retry_for = retry_for
        self._version_fits = any_version

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the connection: later calls fail. Meshes stay readable."""
        self._client = None

    def __repr__(self) -> str:
        return f"<Server at {self.address}>"

    def mesh(self, name: str, create: Optional[dict[str, Any]] = None) -> Mesh:
        """The mesh `name`, made with the options `create` if it does not exist.

        Options are those of `open`, with `box`. If the mesh exists with other options, raises
        `FailedPrecondition`.
        """
        try:
            info = self.call(lambda client: client.get(name))
        except NotFound:
            if create is None:
                raise
            return self.create(name, **create)
        if create is not None:
            create = check_options(create)
            for key, value in create.items():
                have = info["options"][key]
                if not np.array_equal(np.asarray(have), np.asarray(value)):
                    raise FailedPrecondition(f"the mesh {name} has {key} {have}, not {value}")
        return self._open(info)

    def create(self, name: str = "", **options: Any) -> Mesh:
        """Makes a mesh `name`; if empty, the server chooses it. `options` are those of `open`."""
        options = check_options(options)
        request = uuid.uuid4().hex
        try:
            with named_options():
                info = self.call(lambda client: client.create(name, options, request))
        except AlreadyExists as error:
            error.args = (f"{error}: open it with Server.mesh",)
            raise
        return self._open(info)

    def meshes(self) -> list[dict[str, Any]]:
        """All meshes: id, revision, hash, options, damage, owner.

        Of servers that share their meshes, `owner` is the "host:port" of another server that has
        the mesh, or "none"; hash and options are then not set.
        """
        return self.call(lambda client: client.list())

    def delete(self, name: str) -> None:
        """Deletes the mesh `name`, with all its revisions."""
        self.call(lambda client: client.delete(name))

    def stats(self, mesh: str = "") -> dict[str, Any]:
        """Figures of the server, and of `mesh` if given."""
        return self.call(lambda client: client.stats(mesh))

    def _check_version(self, client: Any) -> None:
        theirs: str = client.stats("")["version"]
        if theirs and theirs.split(".")[:2] != _core.version.split(".")[:2]:
            raise VersionMismatch(
                f"the server at {self.address} is dynmesh {theirs}, this package is dynmesh "
                f"{_core.version}: install the same version of both, or connect with "
                "any_version=True")
        self._version_fits = True

    def call(self, function: Callable[[Any], T]) -> T:
        """Calls `function`, retried while the server is unavailable; returns its result.

        Its argument is the extension module's client.
        """
        start = time.monotonic()
        until = start + self._retry_for
        pause = 0.05
        told = False
        while True:
            client = self._client
            if client is None:
                raise Unavailable("the connection was closed")
            returned = client.servers_returned()
            try:
                if not self._version_fits:
                    self._check_version(client)
                return function(client)
            except Unavailable as error:
                wait = error.retry_after or pause
                now = time.monotonic()
                if now + wait > until:
                    raise
                if not told and now - start > _SILENT:
                    told = True
                    _log.warning("%s: %s; trying again for up to %.0f s (retry_for)",
                                 self.address, error, until - now)
                while wait > 0 and client.servers_returned() == returned:
                    time.sleep(min(wait, _GLANCE))
                    wait -= _GLANCE
                pause = min(2 * pause, _LONGEST_PAUSE)

    def _open(self, info: dict[str, Any]) -> Mesh:
        name = info["id"]
        snapshot = self.call(lambda client: client.snapshot(name))
        return Mesh(_Remote(self, name, info["options"]["dimension"]), _core.Mesh(snapshot),
                    info["options"])


class _Remote:
    """A mesh at a server."""

    is_local = False

    def __init__(self, server: Server, name: str, dimension: int) -> None:
        self.server = server
        self.name = name
        self._dimension = dimension

    def apply(self, mesh: Mesh, batch: Any, *, validate_only: bool, progress: Optional[Progress],
              request_id: Optional[str], expected_revision: Optional[int]) -> list[Any]:
        request = request_id or uuid.uuid4().hex
        diff = self.server.call(lambda client: client.apply(
            self.name, batch, request, expected_revision, validate_only))
        if validate_only:
            return []
        return self._path(mesh, diff)

    def load(self, mesh: Mesh, batch: Any, progress: Optional[Progress]) -> list[Any]:
        request = uuid.uuid4().hex
        loaded = self.server.call(
            lambda client: client.load(self.name, batch, request, progress))
        return self._catch_up(mesh, loaded["to_revision"])

    def revert(self, mesh: Mesh, revision: int) -> list[Any]:
        request = uuid.uuid4().hex
        return self._path(mesh, self.server.call(
            lambda client: client.revert(self.name, revision, request)))

    def features(self, mesh: Mesh, revision: Optional[int]) -> list[dict[str, Any]]:
        return self.server.call(
            lambda client: client.features(self.name, self._dimension, revision))

    def locate(self, mesh: Mesh, points: Array) -> Array:
        revision, ids = self.server.call(
            lambda client: client.locate(self.name, self._dimension, points))
        if revision != mesh.revision:
            raise FailedPrecondition(f"the server's mesh is at revision {revision}, the one here at "
                                     f"{mesh.revision}: call sync() first")
        slots: Array = mesh._replica.find_cells(ids)
        return slots

    def stream(self, mesh: Mesh, batches: Iterable[Any], window: int) -> Iterator[Diff]:
        waiting: deque[tuple[str, Any]] = deque()
        source = iter(batches)
        session: Any = None
        exhausted = False
        last = mesh.revision
        try:
            while True:
                try:
                    if session is None:  # at first, or after the connection broke: resend all
                        session = self.server.call(
                            lambda client: client.open_edits(self.name, True))
                        for request, batch in waiting:
                            session.send(batch, request)
                    while not exhausted and len(waiting) < window:
                        batch = next(source, None)
                        if batch is None:
                            exhausted = True
                            break
                        waiting.append((uuid.uuid4().hex, batch))
                        session.send(batch, waiting[-1][0])
                    if not waiting:
                        return
                    diff = session.receive()
                    if diff is None:
                        session.finish()  # raises the reason
                        raise Unavailable("the stream of edits ended")
                except Unavailable:
                    session = None
                    self.server.call(lambda client: client.get(self.name))  # waits for the server
                    continue
                waiting.popleft()
                before, last = last, diff.to_revision
                yield mesh._edit(partial(self._path_beside, mesh, diff, before))
        finally:
            if session is not None:
                session.cancel()

    def follow(self, mesh: Mesh, timeout: Optional[float]) -> Iterator[Any]:
        stream = self._open_stream(mesh)
        try:
            while True:
                event = stream.next(timeout if timeout is not None else 1e9)
                if event is None:
                    return
                yield event
        finally:
            stream.cancel()

    def continue_with(self, mesh: Mesh, event: Any) -> list[Any]:
        if isinstance(event, _core.Snapshot):
            return [self._as_diff(mesh, event)]
        # An edit of another thread may have brought it, or a part of it.
        return self._path(mesh, event) if event.to_revision > mesh.revision else []

    def sync(self, mesh: Mesh) -> list[Any]:
        info = self.server.call(lambda client: client.get(self.name))
        if info["revision"] == mesh.revision and info["hash"] == mesh.hash:
            return []
        return self._catch_up(mesh, info["revision"])

    def _path(self, mesh: Mesh, diff: Any) -> list[Any]:
        """The diffs from the mesh's revision to `diff.to_revision`."""
        if diff.from_revision == mesh.revision or diff.from_revision == diff.to_revision:
            return [diff]
        return self._catch_up(mesh, diff.to_revision)

    def _path_beside(self, mesh: Mesh, diff: Any, last: int) -> list[Any]:
        """`_path`, of a stream that had come to the revision `last`.

        If the mesh is beyond the diff, another thread has advanced it; if the diff is not beyond
        `last`, another server has taken the place of the one before.
        """
        return [] if last < diff.to_revision <= mesh.revision else self._path(mesh, diff)

    def _catch_up(self, mesh: Mesh, revision: int) -> list[Any]:
        if revision == mesh.revision:
            return []
        parts: list[Any] = []
        stream = self._open_stream(mesh)
        try:
            while not parts or parts[-1].to_revision < revision:
                event = stream.next(1e9)
                parts.append(self._as_diff(mesh, event))
        finally:
            stream.cancel()
        return parts

    def _open_stream(self, mesh: Mesh) -> Any:
        return self.server.call(lambda client: client.stream(
            self.name, mesh.revision, mesh.hash, True, self.server._retry_for))

    @staticmethod
    def _as_diff(mesh: Mesh, event: Any) -> Any:
        if isinstance(event, _core.Snapshot):
            return mesh._replica.diff_to(event)
        return event


class _Local:
    """A mesh in this process."""

    name = ""
    is_local = True

    def apply(self, mesh: Mesh, batch: Any, *, validate_only: bool, progress: Optional[Progress],
              request_id: Optional[str], expected_revision: Optional[int]) -> list[Any]:
        if expected_revision is not None and expected_revision != mesh.revision:
            raise FailedPrecondition(f"the mesh is at revision {mesh.revision}, not "
                                     f"{expected_revision}")
        if validate_only:
            mesh._replica.validate(batch)
            return []
        return [mesh._replica.edit(batch, progress)]

    def load(self, mesh: Mesh, batch: Any, progress: Optional[Progress]) -> list[Any]:
        return [mesh._replica.edit(batch, progress)]

    def revert(self, mesh: Mesh, revision: int) -> list[Any]:
        raise DynmeshError("a mesh in process keeps no history: apply the inverse edits")

    def features(self, mesh: Mesh, revision: Optional[int]) -> list[dict[str, Any]]:
        if revision is not None:
            raise DynmeshError("a mesh in process keeps no history")
        with mesh._edits:
            features: list[dict[str, Any]] = mesh._replica.features()
        return features

    def locate(self, mesh: Mesh, points: Array) -> Array:
        slots: Array = mesh._replica.locate(points)
        return slots

    def stream(self, mesh: Mesh, batches: Iterable[Any], window: int) -> Iterator[Diff]:
        for batch in batches:
            yield mesh._edit(partial(self.load, mesh, batch, None))

    def follow(self, mesh: Mesh, timeout: Optional[float]) -> Iterator[Any]:
        raise DynmeshError("a mesh in process changes by its own edits only")
        yield  # a generator, as the others

    def continue_with(self, mesh: Mesh, event: Any) -> list[Any]:
        return []

    def sync(self, mesh: Mesh) -> list[Any]:
        return []
