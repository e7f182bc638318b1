"""Meshes that are written to without end, and clients that read and watch them meanwhile."""
from __future__ import annotations

import functools
import random
import threading
import time
from typing import Any, Iterable, Optional, Union

import dynmesh
import grpc
from databases import wait_until
from dynmesh import _batch

# The steps of golden sequences in two and three dimensions: no two points that are kept are close.
STEPS = {2: (0.7548776662466927, 0.5698402909980532),
         3: (0.8191725133961645, 0.6710436067037893, 0.5497004779019703)}
KEPT = {2: 60, 3: 25}  # points
# Errors after which a batch is sent again, with its request id.
REPEATED = ("UNAVAILABLE", "DEADLINE_EXCEEDED", "UNKNOWN", "CANCELLED")


def longest_pause(times: list[float], begin: float, end: float) -> float:
    """The longest time between two of the moments, of those that overlap; until `end`."""
    times = list(times)  # they grow
    longest = 0.0
    for before, after in zip(times, [*times[1:], max(end, times[-1])]):
        if after >= begin and before <= end:
            longest = max(longest, after - before)
    return longest


class Writer(threading.Thread):
    """Writes batch after batch to a mesh of its own, each with a request id, and again until it is
    acknowledged. Batch k makes revision k."""

    def __init__(self, name: str, dimension: int, phase: int, addresses: str, pause: float) -> None:
        super().__init__(daemon=True)
        self.mesh = name
        self._phase = phase  # of its points in the sequence
        self.dimension = dimension
        self.acknowledged = 0
        # Of batch k + 1: from its first call to its answer.
        self.waits: list[tuple[float, float]] = []
        self._chance = random.Random(phase)
        self.errors: list[str] = []  # that reached this client of the library
        self.trouble = ""
        self._pause = pause
        self._server = dynmesh.connect(addresses, retry_for=1e9)
        self._server.create(name, dimension=dimension, box=[[0] * dimension, [1] * dimension])
        self._may_write = threading.Event()
        self._may_write.set()
        self._is_idle = threading.Event()

    def point(self, number: int) -> list[float]:
        number += self._phase
        return [0.05 + 0.9 * (number * step % 1.0) for step in STEPS[self.dimension]]

    def features_after(self, batches: int) -> dict[str, Any]:
        first = max(1, batches - KEPT[self.dimension] + 1)
        return {"add_points": {k: self.point(k) for k in range(first, batches + 1)}}

    def _edits(self, number: int) -> dict[str, Any]:
        edits: dict[str, Any] = {"add_points": {number: self.point(number)}}
        if number > KEPT[self.dimension]:
            edits["remove"] = [number - KEPT[self.dimension]]
        return edits

    def run(self) -> None:
        while not self.trouble:
            if not self._may_write.is_set():
                self._is_idle.set()
                self._may_write.wait()
                self._is_idle.clear()
            self._write(self.acknowledged + 1)
            # Not in step with the others: snapshots would all be made at the same time.
            time.sleep(self._pause * self._chance.uniform(0.5, 1.5))

    def _write(self, number: int) -> None:
        batch = _batch.make(self.dimension, self._edits(number))
        begin = time.monotonic()
        while True:
            try:
                diff = self._server.call(
                    lambda client: client.apply(self.mesh, batch, f"w-{number}", None, False))
                break
            except dynmesh.errors.DynmeshError as error:
                self.errors.append(f"{self.mesh} batch {number}: {error.code}: {error}")
                if error.code not in REPEATED:
                    self.trouble = self.errors[-1]
                    return
                time.sleep(0.1)
        if diff.to_revision != number:
            self.trouble = f"{self.mesh}: batch {number} made revision {diff.to_revision}"
        self.waits.append((begin, time.monotonic()))
        self.acknowledged = number

    def hold(self) -> None:
        """Waits for the batch under way, and writes none after it until `go_on`."""
        self._is_idle.clear()
        self._may_write.clear()

    def is_held(self) -> bool:
        return self._is_idle.is_set() or self.trouble != ""

    def go_on(self) -> None:
        self._may_write.set()

    def longest_pause(self, begin: float, end: float) -> float:
        """The longest time that a batch waited for its answer, of those that did meanwhile."""
        return max((after - before for before, after in list(self.waits)
                    if after >= begin and before <= end), default=0.0)


class Count:
    """Numbers that several threads add to."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._numbers: dict[str, int] = {}
        self.notes: list[str] = []

    def add(self, name: str, note: str = "") -> None:
        with self._lock:
            self._numbers[name] = self._numbers.get(name, 0) + 1
            if note and len(self.notes) < 100:
                self.notes.append(f"{name}: {note}")

    def of(self, name: str) -> int:
        with self._lock:
            return self._numbers.get(name, 0)


class FollowerReader(threading.Thread):
    """Takes the snapshot that some node has of a mesh, again and again; it never grows older."""

    def __init__(self, mesh: str, addresses: str, pause: float, count: Count) -> None:
        super().__init__(daemon=True)
        self._pause = pause
        self.times = [time.monotonic()]  # of answers
        self.mesh = mesh
        self._count = count
        self._server = dynmesh.connect(addresses, retry_for=1e9, from_followers=True)

    def run(self) -> None:
        last = 0
        while True:
            try:
                revision = self._server.call(lambda client: client.snapshot(self.mesh)).revision
            except dynmesh.errors.DynmeshError as error:
                self._count.add("follower_read_errors", f"{error.code}: {error}")
            else:
                self._count.add("follower_reads")
                self.times.append(time.monotonic())
                if revision < last:
                    self._count.add("stale", f"{self.mesh}: a follower's {revision} after {last}")
                last = revision
            time.sleep(self._pause)


class Reader(threading.Thread):
    """Reads a mesh by the library. A read that begins after a batch was acknowledged has it."""

    def __init__(self, writer: Writer, addresses: str, pause: float, count: Count) -> None:
        super().__init__(daemon=True)
        self._pause = pause
        self.times = [time.monotonic()]  # of answers
        self.mesh = writer.mesh
        self._writer = writer
        self._count = count
        self._server = dynmesh.connect(addresses, retry_for=1e9)

    def run(self) -> None:
        while True:
            known = self._writer.acknowledged
            try:
                found = self._server.call(lambda client: client.get(self._writer.mesh))["revision"]
            except dynmesh.errors.DynmeshError as error:
                self._count.add("read_errors", f"{error.code}: {error}")
            else:
                self._count.add("reads")
                self.times.append(time.monotonic())
                if found < known:
                    self._count.add("stale", f"{self._writer.mesh}: {found} after {known}")
            time.sleep(self._pause)


def _varint(data: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        value |= (data[at] & 0x7f) << shift
        at, shift = at + 1, shift + 7
        if data[at - 1] < 0x80:
            return value, at


def _revision(data: bytes) -> int:
    """Field 4 of the message Mesh."""
    at = 0
    while at < len(data):
        tag, at = _varint(data, at)
        value, at = _varint(data, at)
        if tag == 4 << 3:
            return value
        if tag & 7 == 2:
            at += value
    return 0


class Prober(threading.Thread):
    """Asks one node for all meshes, whether it has them or not, and does not wait for answers.

    So some reads arrive at a node just before and while it is stopped or cut off. It may refuse
    them; what it answers must not be old.
    """

    def __init__(self, writers: list[Writer], address: str, pause: float, count: Count) -> None:
        super().__init__(daemon=True)
        self._pause = pause
        self._writers = writers
        self._count = count
        self._channel = grpc.insecure_channel(address, options=[
            ("grpc.use_local_subchannel_pool", 1), ("grpc.initial_reconnect_backoff_ms", 200),
            ("grpc.max_reconnect_backoff_ms", 500)])
        self._get = self._channel.unary_unary("/dynmesh.v1.MeshService/GetMesh",
                                              response_deserializer=_revision)

    def run(self) -> None:
        while True:
            for writer in self._writers:
                name = f"meshes/{writer.mesh}".encode()
                known = writer.acknowledged  # before the call begins
                call = self._get.future(bytes([10, len(name)]) + name, timeout=15,
                                        metadata=(("dynmesh-redirects", "0"),))
                call.add_done_callback(functools.partial(self._judge, writer.mesh, known))
            time.sleep(self._pause)

    def _judge(self, mesh: str, known: int, call: Any) -> None:
        if call.code() != grpc.StatusCode.OK:
            self._count.add("probes_refused")
            return
        self._count.add("probes")
        if call.result() < known:
            self._count.add("stale", f"{mesh}, by one node: {call.result()} after {known}")


class Watcher(threading.Thread):
    """A replica of the mesh. The library compares its hash with that of each revision."""

    def __init__(self, mesh: str, addresses: str, from_followers: bool, count: Count) -> None:
        super().__init__(daemon=True)
        self._count = count
        server = dynmesh.connect(addresses, retry_for=1e9, from_followers=from_followers)
        self.mesh = server.mesh(mesh)
        self.at: tuple[int, str] = (0, "")  # revision and hash

    def run(self) -> None:
        while True:
            try:
                for _ in self.mesh.follow():
                    self.at = (self.mesh.revision, self.mesh.hash)
            except dynmesh.errors.DataLoss as error:
                self._count.add("wrong_hashes", str(error))
                self.mesh.sync()
            except dynmesh.errors.DynmeshError as error:
                self._count.add("watch_errors", f"{error.code}: {error}")
                time.sleep(0.1)


class Workload:
    """Meshes with a writer, a reader and two watchers each, and readers of single nodes.

    Every fourth of the `meshes` is in 3D. No two have the same points: what takes long would take
    long in all at the same time. With more than 16 of them each is read less often: the
    clients are one process, which would be what is measured.
    """

    def __init__(self, nodes: list[str], meshes: int, pause: float) -> None:
        self.count = Count()
        scale = max(1.0, meshes / 16)
        # A mesh belongs to the node that is asked to make it: each node has some.
        turned = [",".join(nodes[i:] + nodes[:i]) for i in range(len(nodes))]
        self.writers = [Writer(f"m{i + 1}", 3 if i % 4 == 3 else 2, 97 * i, turned[i % len(nodes)],
                               pause)
                        for i in range(meshes)]
        self.watchers: dict[str, list[Watcher]] = {}
        threads: list[threading.Thread] = list(self.writers)
        self.readers = [Reader(writer, ",".join(nodes), 0.1 * scale, self.count) for writer in self.writers]
        self.follower_readers = [
            FollowerReader(writer.mesh, turned[(i + 2) % len(nodes)], 0.1 * scale, self.count)
            for i, writer in enumerate(self.writers)]
        threads += [*self.readers, *self.follower_readers]
        for index, writer in enumerate(self.writers):
            self.watchers[writer.mesh] = [
                Watcher(writer.mesh, turned[(index + 1) % len(nodes)], from_followers, self.count)
                for from_followers in (False, True)]
            threads += self.watchers[writer.mesh]
        threads += [Prober(self.writers, node, 0.25 * scale, self.count) for node in nodes]
        for thread in threads:
            thread.start()

    def of(self, meshes: Optional[set[str]]) -> list[Writer]:
        """The writers of these meshes; None: all."""
        return [writer for writer in self.writers if meshes is None or writer.mesh in meshes]

    def wait_for_batches(self, where: str, patience: float) -> float:
        """Until each writer has begun a batch and got its answer. Returns when the last writer got
        its first answer of this time."""
        known = [writer.acknowledged for writer in self.writers]
        wait_until(f"a batch of each writer {where}", lambda: all(
            writer.acknowledged > before + 1 or writer.trouble
            for writer, before in zip(self.writers, known)), patience)
        return max((writer.waits[before][1] for writer, before in zip(self.writers, known)
                    if not writer.trouble), default=time.monotonic())

    def errors(self) -> list[str]:
        return [error for writer in self.writers for error in list(writer.errors)]

    def read_pauses(self, meshes: Optional[set[str]], begin: float, end: float
                    ) -> dict[str, float]:
        """The longest time without an answer to a reader of these meshes."""
        def longest(readers: Iterable[Union[Reader, FollowerReader]]) -> float:
            return round(max(longest_pause(reader.times, begin, end) for reader in readers
                             if meshes is None or reader.mesh in meshes), 3)
        return {"read_pause": longest(self.readers),
                "follower_read_pause": longest(self.follower_readers)}

    def trouble(self) -> list[str]:
        return [writer.trouble for writer in self.writers if writer.trouble]

    def acknowledged(self) -> int:
        return sum(writer.acknowledged for writer in self.writers)
