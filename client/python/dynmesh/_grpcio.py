"""The client of a server over grpcio: what a wheel has in place of `_service`.

Names and results are those of the extension module `_service`. Several servers are asked in turn; one
that has not the mesh names the one that has it.
"""
from __future__ import annotations

import functools
import queue
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Dict, List, Optional

import grpc
import numpy as np

from dynmesh import _core
from dynmesh._messages import DiffParts, SnapshotParts, edit_messages, error_of, error_of_status, \
    feature_message, feature_of, info_of, options_message
from dynmesh.errors import Cancelled, Conflict, DataLoss, DynmeshError, OutOfRange, Unavailable
from dynmesh.v1 import mesh_pb2, mesh_service_pb2 as service, status_details_pb2

Rows = List[Dict[str, Any]]
_MOST_ATTEMPTS = 60  # of one call at several servers
_PAUSE = 0.05  # between these, in seconds
_PART = 512 * 1024  # bytes of a message of a load or a stream of edits, about
_LOCATED = 30_000  # places of a request
_POLL_ENDS = 1.0  # in seconds: that long at most until gRPC no longer asks, five times its period
_SLICE = 0.1  # in seconds: as often a wait looks for Ctrl-C
# Codes after which a watch is opened again, as IsPassing in C++; empty: it ended without an error.
_PASSING = ("", "UNAVAILABLE", "UNKNOWN", "INTERNAL", "RESOURCE_EXHAUSTED", "DEADLINE_EXCEEDED")
_STAGES = ("send", "send", "wait", "validate", "refine", "diff", "write")


def _error(error: grpc.RpcError) -> DynmeshError:
    details: Any = []
    for key, value in error.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            details = status_details_pb2.Status.FromString(value).details
    code, message = error.code().name, error.details() or ""
    if code == "CANCELLED" and not details:  # a server that shuts down
        code = "UNAVAILABLE"
        message = "the server ended the call: it shuts down, or the token lost the right to it"
    return error_of(code, message, details)


def _name(mesh: str) -> str:
    return f"meshes/{mesh}"


def _parts(messages: Sequence[Any]) -> Iterator[list[Any]]:
    """The messages in lists of bounded size; at least one list."""
    part: list[Any] = []
    size = 0
    for message in messages:
        size += message.ByteSize() + 8
        if part and size > _PART:
            yield part
            part, size = [], message.ByteSize()
        part.append(message)
    yield part


def _is_polled(channel: Any) -> bool:
    """True while a thread of gRPC asks for the channel's state: it fails if that is closed meanwhile."""
    state = getattr(channel, "_connectivity_state", None)
    return bool(getattr(state, "polling", False))


class _Servers:
    """Connections, and which server has which mesh. Thread-safe."""

    def __init__(self, addresses: str, credentials: Any, several: bool) -> None:
        self.addresses = [address.strip() for address in addresses.split(",")]
        self._credentials = credentials
        self._options = [
            ("grpc.use_local_subchannel_pool", 1), ("grpc.max_receive_message_length", 64 << 20),
            ("grpc.keepalive_time_ms", 5_000 if several else 60_000),
            ("grpc.http2.max_pings_without_data", 0), ("grpc.initial_reconnect_backoff_ms", 100),
            ("grpc.min_reconnect_backoff_ms", 1_000), ("grpc.max_reconnect_backoff_ms", 500)]
        # Where it is held, Python may free a client, which ends in close().
        self._lock = threading.RLock()
        self._channels: dict[str, tuple[Any, Callable[[Any], None]]] = {}  # each with its watch
        self._where: dict[str, str] = {}
        self._failed: set[str] = set()
        self._returned = 0

    def address_of(self, mesh: str) -> str:
        with self._lock:
            return self._where.get(mesh, self.addresses[0])

    def channel(self, address: str) -> Any:
        with self._lock:
            if address not in self._channels:
                made = grpc.insecure_channel(address, self._options) \
                    if self._credentials is None else \
                    grpc.secure_channel(address, self._credentials, self._options)
                watch = functools.partial(self._changed, address)
                self._channels[address] = made, watch
                made.subscribe(watch)
            return self._channels[address][0]

    def returned(self) -> int:
        """How often a server could be reached again."""
        with self._lock:
            return self._returned

    def _changed(self, address: str, state: Any) -> None:
        with self._lock:
            if state == grpc.ChannelConnectivity.TRANSIENT_FAILURE:
                self._failed.add(address)
            elif state == grpc.ChannelConnectivity.READY and address in self._failed:
                self._failed.discard(address)
                self._returned += 1

    def learn(self, mesh: str, asked: str, error: DynmeshError) -> bool:
        """Where to ask for the mesh next. False if there is no reason to ask again."""
        owner = error.__dict__.get("owner", "")
        others = [address for address in self.addresses if address != asked]
        if error.reason == "NOT_OWNER" and owner:
            following = owner
        elif isinstance(error, Unavailable) and others:
            place = self.addresses.index(asked) if asked in self.addresses else -1
            following = self.addresses[(place + 1) % len(self.addresses)]
        else:
            return False
        with self._lock:
            self._where[mesh] = following
        return True

    def close(self) -> None:
        with self._lock:
            channels, self._channels = self._channels, {}
        for channel, watch in channels.values():
            channel.unsubscribe(watch)
        until = time.monotonic() + _POLL_ENDS
        for channel, _ in channels.values():
            while _is_polled(channel) and time.monotonic() < until:
                time.sleep(0.005)
            channel.close()


class Client:
    """Calls to a server; thread-safe."""

    def __init__(self, address: str, token: str, tls_ca: str, tls_certificate: str, tls_key: str,
                 timeout: float, from_followers: bool) -> None:
        credentials = None
        if tls_ca:
            credentials = grpc.ssl_channel_credentials(
                tls_ca.encode(), tls_key.encode() or None, tls_certificate.encode() or None)
        self._servers = _Servers(address, credentials, "," in address)
        self._token = token
        self.timeout = timeout or None
        self._from_followers = from_followers
        self._lock = threading.Lock()
        self._seen: dict[str, int] = {}  # of each mesh the latest revision
        # At the end of the program, too: then before threads of grpcio are gone.
        self._close = weakref.finalize(self, self._servers.close)

    def servers_returned(self) -> int:
        """How often a server could be reached again."""
        return self._servers.returned()

    # ---- calls

    def metadata(self, redirects: int = 0) -> list[tuple[str, str]]:
        """That of each call."""
        rights = [("authorization", f"Bearer {self._token}")] if self._token else []
        return [*rights, ("dynmesh-redirects", str(redirects))]

    def at(self, mesh: str, method: str, response: Any, kind: str) -> tuple[str, Any]:
        """The address of the mesh's server, and the method there."""
        address = self._servers.address_of(mesh)
        made = getattr(self._servers.channel(address), kind)(
            f"/dynmesh.v1.MeshService/{method}", request_serializer=lambda m: m.SerializeToString(),
            response_deserializer=response.FromString)
        return address, made

    def learn(self, mesh: str, address: str, error: DynmeshError) -> bool:
        """As _Servers.learn."""
        return self._servers.learn(mesh, address, error)

    def _follow(self, mesh: str, repeatable: bool, run: Callable[[int], tuple[str, Any]]) -> Any:
        """The result of run(redirects), at the mesh's server."""
        until = time.monotonic() + self.timeout if self.timeout else float("inf")
        asked = set()
        for attempt in range(_MOST_ATTEMPTS):
            address = self._servers.address_of(mesh)
            try:
                return run(attempt)
            except grpc.RpcError as caught:
                error = _error(caught)
            again = self.learn(mesh, address, error)
            if not again or not (repeatable or error.reason == "NOT_OWNER"):
                raise error
            if error.reason != "NOT_OWNER":
                asked.add(address)
                if len(asked) >= len(self._servers.addresses):
                    raise error  # none can be reached
            if time.monotonic() + _PAUSE > until:
                raise error
            time.sleep(_PAUSE if attempt else 0)
        raise error

    def _unary(self, mesh: str, method: str, request: Any, response: Any,
               repeatable: bool = True) -> Any:
        def run(redirects: int) -> Any:
            _, call = self.at(mesh, method, response, "unary_unary")
            return call(request, timeout=self.timeout, metadata=self.metadata(redirects))

        return self._follow(mesh, repeatable, run)

    def _whole(self, mesh: str, method: str, request: Any, response: Any, add: Callable[[], Any],
               repeatable: bool = True) -> Any:
        """What the parts of a streamed answer make; add() makes a function of a part."""
        def run(redirects: int) -> Any:
            _, call = self.at(mesh, method, response, "unary_stream")
            joined = add()
            whole = None
            for part in call(request, timeout=self.timeout, metadata=self.metadata(redirects)):
                made = joined(part)
                whole = made if made is not None else whole
            if whole is None:
                raise DataLoss("the server sent no whole answer")
            return whole

        return self._follow(mesh, repeatable, run)

    def read_request(self, request: Any, revision: int = 0) -> str:
        """Says that a follower may answer, if so; returns the key of the server to ask."""
        mesh: str = request.mesh
        if not self._from_followers:
            return mesh
        with self._lock:
            request.min_revision = max(revision, self._seen.get(mesh, 0))
        return f"read of {mesh}"

    def _saw(self, mesh: str, revision: int) -> None:
        if not self._from_followers:
            return
        with self._lock:
            self._seen[mesh] = max(revision, self._seen.get(mesh, 0))

    def create(self, name: str, options: dict[str, Any], request_id: str) -> dict[str, Any]:
        request = service.CreateMeshRequest(mesh_id=name, options=options_message(options),
                                            request_id=request_id)
        key = f"creation of {_name(name)}" if name else f"request {request_id}"
        return info_of(self._unary(key, "CreateMesh", request, mesh_pb2.Mesh, bool(request_id)))

    def get(self, mesh: str) -> dict[str, Any]:
        request = service.GetMeshRequest(mesh=_name(mesh))
        return info_of(self._unary(request.mesh, "GetMesh", request, mesh_pb2.Mesh))

    def list(self) -> Rows:
        infos: Rows = []
        request = service.ListMeshesRequest(page_size=1000)
        while True:
            page = self._unary("", "ListMeshes", request, service.ListMeshesResponse)
            infos += [info_of(mesh) for mesh in page.meshes]
            if not page.next_page_token:
                return infos
            request.page_token = page.next_page_token

    def delete(self, mesh: str) -> None:
        request = service.DeleteMeshRequest(mesh=_name(mesh))
        self._unary(request.mesh, "DeleteMesh", request, service.DeleteMeshResponse, False)

    def stats(self, mesh: str) -> dict[str, Any]:
        request = service.GetStatsRequest(mesh=_name(mesh) if mesh else "")
        got = self._unary(request.mesh, "GetStats", request, service.GetStatsResponse)
        result = {"version": got.server_version, "meshes": got.meshes, "watchers": got.watchers,
                  "uptime": got.uptime.seconds + got.uptime.nanos * 1e-9}
        if got.HasField("mesh"):
            result["mesh"] = {name: getattr(got.mesh, name) for name in (
                "revision", "features", "vertices", "simplices", "oldest_revision", "hash")}
        return result

    def _edit(self, method: str, request: Any, repeatable: bool) -> Any:
        diff = self._whole(request.mesh, method, request, mesh_pb2.MeshDiff, lambda: DiffParts().add,
                           repeatable)
        self._saw(request.mesh, diff.to_revision)
        return diff

    def apply(self, mesh: str, batch: Any, request_id: str, expected_revision: Optional[int],
              validate_only: bool) -> Any:
        edits = edit_messages(batch)
        parts = list(_parts(edits))
        if len(parts) > 1:
            session = EditSession(self, mesh, True, self.timeout)
            try:
                session.send_edits(parts, request_id, expected_revision, validate_only)
                diff = session.receive()
                if diff is None:
                    session.finish()
                    raise DataLoss("the server sent no answer")
                return diff
            finally:
                session.cancel()
        request = service.ApplyEditsRequest(
            mesh=_name(mesh), edits=edits, request_id=request_id,
            expected_revision=expected_revision, validate_only=validate_only)
        return self._edit("ApplyEdits", request, bool(request_id) or validate_only)

    def revert(self, mesh: str, revision: int, request_id: str) -> Any:
        request = service.RevertToRequest(mesh=_name(mesh), revision=revision,
                                          request_id=request_id)
        return self._edit("RevertTo", request, bool(request_id))

    def features(self, mesh: str, dimension: int, revision: Optional[int]) -> Rows:
        request = service.GetFeaturesRequest(mesh=_name(mesh), revision=revision)
        key = self.read_request(request)

        def joined() -> Callable[[Any], Any]:
            found: Rows = []

            def add(chunk: Any) -> Any:
                found.extend(feature_of(feature, dimension) for feature in chunk.features)
                return (found, chunk.revision) if chunk.hash else None
            return add

        found, at = self._whole(key, "GetFeatures", request, service.FeaturesChunk, joined)
        self._saw(request.mesh, at)
        features: Rows = found
        return features

    def snapshot(self, mesh: str) -> Any:
        request = service.GetSnapshotRequest(mesh=_name(mesh))
        key = self.read_request(request)
        found = self._whole(key, "GetSnapshot", request, mesh_pb2.SnapshotChunk,
                            lambda: SnapshotParts().add)
        self._saw(request.mesh, found.revision)
        return found

    def locate(self, mesh: str, dimension: int, points: Any) -> tuple[int, Any]:
        places = np.ascontiguousarray(points, np.float64).reshape(-1, dimension)
        revisions, ids = set(), []
        for begin in range(0, max(len(places), 1), _LOCATED):
            request = service.LocatePointsRequest(
                mesh=_name(mesh), coordinates=places[begin:begin + _LOCATED].ravel())
            key = self.read_request(request)
            found = self._unary(key, "LocatePoints", request, service.LocatePointsResponse)
            self._saw(request.mesh, found.revision)
            revisions.add(found.revision)
            column = found.simplices.vertex_ids
            ids.append(np.fromiter(column, np.uint64, len(column)))
        if len(revisions) > 1:
            raise Conflict("the mesh changed between two parts of the question: ask again")
        return revisions.pop(), np.concatenate(ids).reshape(-1, dimension + 1)

    def load(self, mesh: str, batch: Any, request_id: str, progress: Any) -> dict[str, Any]:
        self._unary(_name(mesh), "GetMesh", service.GetMeshRequest(mesh=_name(mesh)), mesh_pb2.Mesh)
        parts = list(_parts([feature_message(f) for f in _features_of(batch)]))

        def requests() -> Iterator[Any]:
            for number, part in enumerate(parts):
                first = number == 0
                yield service.LoadFeaturesRequest(
                    mesh=_name(mesh) if first else "", request_id=request_id if first else "",
                    features=part, last=number == len(parts) - 1)

        address, call = self.at(_name(mesh), "LoadFeatures", service.LoadFeaturesResponse,
                                "stream_stream")
        stream = call(requests(), timeout=self.timeout, metadata=self.metadata())
        result = None
        try:
            for answer in stream:
                if answer.HasField("result"):
                    result = answer.result
                elif progress is not None:
                    progress(_STAGES[min(answer.stage, len(_STAGES) - 1)], answer.done,
                             answer.total)
        except grpc.RpcError as caught:
            error = _error(caught)
            self.learn(_name(mesh), address, error)
            raise error from None
        finally:
            stream.cancel()
        if result is None:
            raise DataLoss("the server sent no result")
        return {"from_revision": result.from_revision, "to_revision": result.to_revision,
                "hash": result.hash, "replayed": result.replayed}

    def open_edits(self, mesh: str, stop_on_error: bool) -> EditSession:
        return EditSession(self, mesh, stop_on_error)

    def stream(self, mesh: str, revision: int, hash: str, takes_snapshots: bool,
               patience: float) -> DiffStream:
        return DiffStream(self, mesh, revision, hash, takes_snapshots, patience)


def _features_of(batch: Any) -> Rows:
    """Those that the batch adds, with the labels that it sets then."""
    features: dict[int, dict[str, Any]] = {}
    for action, feature in _core.edits_of(batch):
        if action != "label":
            features[feature["id"]] = feature
        elif feature["id"] in features:
            features[feature["id"]].update(marker=feature.get("marker", 0),
                                           name=feature.get("name", ""))
        else:
            raise ValueError("a load labels what it has added: there is no feature "
                             f"{feature['id']}")
    return list(features.values())


class EditSession:
    """A stream of batches and their answers, in order; of `timeout` seconds at most, if given."""

    def __init__(self, client: Client, mesh: str, stop_on_error: bool,
                 timeout: Optional[float] = None) -> None:
        self._client, self._mesh = client, _name(mesh)
        self._stop_on_error = stop_on_error
        client.get(mesh)  # finds its server: a stream cannot be sent on
        self._address, call = client.at(self._mesh, "EditStream", mesh_pb2.MeshDiff,
                                        "stream_stream")
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._named = False
        self._diff = DiffParts()
        self._answers = call(iter(self._queue.get, None), timeout=timeout,
                             metadata=client.metadata())

    def send(self, batch: Any, request_id: str) -> None:
        self.send_edits(list(_parts(edit_messages(batch))), request_id, None, False)

    def send_edits(self, parts: List[List[Any]], request_id: str, expected_revision: Optional[int],
                   validate_only: bool) -> None:
        """Sends one batch in parts."""
        if not self._answers.is_active():
            raise Unavailable("the stream has ended: receive what is left, then finish")
        for number, part in enumerate(parts):
            message = service.EditBatch(edits=part, more=number < len(parts) - 1)
            if number == 0:
                message.request_id, message.validate_only = request_id, validate_only
                if expected_revision is not None:
                    message.expected_revision = expected_revision
                if not self._named:
                    message.mesh, message.stop_on_error = self._mesh, self._stop_on_error
                    self._named = True
            self._queue.put(message)

    def receive(self) -> Any:
        """The diff of the next batch; None if the stream has ended. Raises its error if refused."""
        try:
            for answer in self._answers:
                if answer.status.code:
                    self._diff = DiffParts()
                    raise error_of_status(answer.status)
                diff = self._diff.add(answer)
                if diff is not None:
                    return diff
        except grpc.RpcError:
            return None
        return None

    def finish(self) -> None:
        """Raises the reason if the stream ended with an error."""
        self._queue.put(None)
        if self._answers.code() is not grpc.StatusCode.OK:  # waits
            error = _error(self._answers)
            self._client.learn(self._mesh, self._address, error)
            raise error

    def cancel(self) -> None:
        self._queue.put(None)
        self._answers.cancel()


class DiffStream:
    """The revisions of a mesh, in order, from a thread that reads them; reconnects."""

    def __init__(self, client: Client, mesh: str, revision: int, hash: str, takes_snapshots: bool,
                 patience: float) -> None:
        self._client, self._mesh = client, _name(mesh)
        self._revision, self._hash = revision, hash
        self._takes_snapshots, self._patience = takes_snapshots, patience
        self._from_snapshot = False
        self._heard = False
        self._call: Any = None
        self._cancelled = threading.Event()
        self._events: queue.Queue[Any] = queue.Queue(16)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def next(self, seconds: float) -> Any:
        """The next diff or snapshot; None after that time."""
        until = time.monotonic() + seconds
        while True:
            if self._cancelled.is_set():
                raise Cancelled("the stream was cancelled")
            left = until - time.monotonic()
            try:
                event = self._events.get(timeout=max(min(left, _SLICE), 0.001))
            except queue.Empty:
                if left <= 0:
                    return None
                continue
            if isinstance(event, DynmeshError):
                self._hand(event)  # the next call ends as well
                raise event
            return event

    def cancel(self) -> None:
        self._cancelled.set()
        call = self._call
        if call is not None:
            call.cancel()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _hand(self, event: Any) -> None:
        while not self._cancelled.is_set():
            try:
                self._events.put(event, timeout=_SLICE)
                return
            except queue.Full:
                pass

    def _run(self) -> None:
        last_sign, pause = time.monotonic(), 0.05
        while not self._cancelled.is_set():
            self._heard = False
            try:
                self._read()
                error: DynmeshError = Unavailable("the stream ended again and again")
            except DynmeshError as caught:
                error = caught
            except Exception as caught:  # as that of a closed channel: `next` must not wait for ever
                self._hand(DynmeshError(f"the stream ended: {caught}"))
                return
            if self._cancelled.is_set():
                return
            if self._heard:
                last_sign, pause = time.monotonic(), 0.05
            if isinstance(error, OutOfRange) and self._takes_snapshots and \
                    not self._from_snapshot:
                self._from_snapshot = True
                continue
            if error.code not in _PASSING or time.monotonic() - last_sign > self._patience:
                self._hand(error)
                return
            self._wait(pause)
            pause = min(2 * pause, 2.0)

    def _wait(self, pause: float) -> None:
        returned = self._client.servers_returned()
        until = time.monotonic() + pause
        while time.monotonic() < until and self._client.servers_returned() == returned:
            if self._cancelled.wait(0.05):
                return

    def _read(self) -> None:
        """One Watch call, until it ends."""
        request = service.WatchRequest(mesh=self._mesh)
        if not self._from_snapshot:
            request.start_revision, request.start_hash = self._revision, self._hash
        key = self._client.read_request(request, self._revision)
        address, call = self._client.at(key, "Watch", service.WatchEvent, "unary_stream")
        snapshot, diff = SnapshotParts(), DiffParts()
        self._call = call(request, metadata=self._client.metadata())
        if self._cancelled.is_set():
            self._call.cancel()
        try:
            for event in self._call:
                self._heard = True
                kind = event.WhichOneof("event")
                whole = snapshot.add(event.snapshot) if kind == "snapshot" else \
                    diff.add(event.diff) if kind == "diff" else None
                if whole is None:
                    continue
                if kind == "diff" and whole.from_revision != self._revision:
                    raise DynmeshError("a revision is missing in the stream")
                self._from_snapshot = False
                self._revision = whole.to_revision if kind == "diff" else whole.revision
                self._hash = whole.hash
                self._hand(whole)
        except grpc.RpcError as caught:
            error = _error(caught)
            self._client.learn(key, address, error)
            raise error from None
        finally:
            self._call.cancel()
