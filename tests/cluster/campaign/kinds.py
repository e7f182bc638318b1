"""The kinds of faults. Each is a class whose `fault` returns when the fault is over."""
from __future__ import annotations

import pathlib
import random
import signal
import subprocess
import sys
import time
from typing import Any, Optional

from databases import PATIENCE
from network import Pair, both_ways
from nodes import Cluster, Node
from workload import Workload

FAKETIME = pathlib.Path("/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1")


class Kind:
    """A fault of a random owner of meshes. `meshes`: those whose pauses count; None: all."""

    count = 5  # by default

    def __init__(self, cluster: Cluster, work: Workload, chance: random.Random,
                 folder: pathlib.Path, lasts: float) -> None:
        self.cluster = cluster
        self.lasts = lasts  # seconds, of a stop or of a network without packets
        self.work = work
        self.chance = chance
        self.folder = folder
        self.meshes: Optional[set[str]] = None
        self.figures: dict[str, Any] = {}  # of the last fault, beside its pauses

    def set_up(self) -> None:
        """Before the first one."""

    def fault(self) -> None:
        raise NotImplementedError

    def take_down(self) -> None:
        """After the last one."""

    def owner(self) -> Node:
        """The owner of a random mesh; its meshes are those whose pauses count."""
        owners = self.cluster.owners()
        address = owners[self.chance.choice(self.work.writers).mesh][0]
        self.meshes = {mesh for mesh, (owner, _) in owners.items() if owner == address}
        return self.cluster.at(address)

    def wait_and_see(self, seconds: float) -> None:
        """Until then; notes after how many seconds another node has had all of `meshes`."""
        begin = time.monotonic()
        before = self.cluster.owners()
        taken = None
        while (now := time.monotonic() - begin) < seconds:
            if taken is None:
                owners = self.cluster.owners()
                if all(owners[mesh][0] != before[mesh][0] for mesh in self.meshes or owners):
                    taken = round(time.monotonic() - begin, 3)
            time.sleep(min(0.2, seconds - now))
        self.figures["taken_over_after"] = taken

    def note_moved(self, before: dict[str, tuple[str, int]]) -> None:
        """How many meshes have another owner or epoch than then."""
        self.figures["moved"] = sum(
            owner != before[mesh] for mesh, owner in self.cluster.owners().items())

    def restart_all(self, journal: str) -> None:
        """One node after the other, with that journal."""
        for node in self.cluster.nodes:
            node.drain()
            node.start(journal)
            self.cluster.wait_until_steady()


class Stop(Kind):
    """SIGSTOP of an owner, longer than its lease, then SIGCONT."""

    count = 30

    def fault(self) -> None:
        node = self.owner()
        logged = node.log_size()
        node.send(signal.SIGSTOP)
        try:
            self.wait_and_see(self.lasts)
        finally:
            node.send(signal.SIGCONT)
        time.sleep(1)
        self.figures["disowned"] = node.count("mesh_disowned", logged)


class Partition(Kind):
    """An owner and the database cannot reach each other."""

    count = 10

    def pairs(self, node: Node) -> list[Pair]:
        return both_ways(node.host, self.cluster.databases.addresses)

    def fault(self) -> None:
        pairs = self.pairs(self.owner())
        self.cluster.network.cut(pairs)
        try:
            self.wait_and_see(self.lasts)
        finally:
            self.cluster.network.heal()


class PartitionOut(Partition):
    """What an owner sends to the database is lost."""

    def pairs(self, node: Node) -> list[Pair]:
        return super().pairs(node)[0::2]


class PartitionIn(Partition):
    """What the database sends to an owner is lost."""

    def pairs(self, node: Node) -> list[Pair]:
        return super().pairs(node)[1::2]


class Flap(Partition):
    """An owner and the database reach each other every other second."""

    def fault(self) -> None:
        pairs = self.pairs(self.owner())
        for _ in range(int(self.lasts / 2)):
            self.cluster.network.cut(pairs)
            time.sleep(1)
            self.cluster.network.heal()
            time.sleep(1)


class PartitionClients(Partition):
    """An owner and the clients cannot reach each other; it keeps its meshes."""

    def pairs(self, node: Node) -> list[Pair]:
        return both_ways(node.host, [self.cluster.network.clients])


class PartitionNodes(Partition):
    """An owner and the other nodes cannot reach each other; all reach database and clients."""

    def pairs(self, node: Node) -> list[Pair]:
        return both_ways(node.host, [n.host for n in self.cluster.nodes if n is not node])


class Primary(Kind):
    """kill -9 of the primary; the standby that is ahead is promoted a second later."""

    count = 10

    def fault(self) -> None:
        databases = self.cluster.databases
        databases.primary.kill()
        time.sleep(1)
        decided = time.monotonic()
        former = databases.promote()
        promoted = time.monotonic()
        known = self.work.wait_for_batches("at the new primary", PATIENCE)
        self.figures["promotion"] = round(promoted - decided, 3)
        self.figures["after_promotion"] = round(
            max(writer.times[before + 1] for writer, before in zip(self.work.writers, known))
            - promoted, 3)
        databases.rejoin(former)


class Standby(Kind):
    """kill -9 of one standby, which is back after five seconds."""

    how_many = 1

    def fault(self) -> None:
        databases = self.cluster.databases
        lost = self.chance.sample(databases.standbys, self.how_many)
        for standby in lost:
            standby.kill()
        time.sleep(5)
        for standby in lost:
            standby.start(databases.primary)
        databases.wait_for_standbys()


class Standbys(Standby):
    """kill -9 of both standbys, which are back after five seconds: batches wait meanwhile."""

    how_many = 2


class Cancel(Kind):
    """Commits that wait for a standby are cancelled: they are made here and confirmed nowhere."""

    def fault(self) -> None:
        databases = self.cluster.databases
        for standby in databases.standbys:
            standby.send(signal.SIGSTOP)
        try:
            cancelled = 0
            for _ in range(4):
                time.sleep(0.5)
                cancelled += int(databases.sql(
                    "SELECT count(pg_cancel_backend(pid)) FROM pg_stat_activity WHERE wait_event = "
                    "'SyncRep'"))
            self.figures["cancelled"] = cancelled
        finally:
            for standby in databases.standbys:
                standby.send(signal.SIGCONT)


class Drain(Kind):
    """SIGTERM of an owner, which is started again when it has ended."""

    count = 20

    def restart(self, node: Node) -> None:
        began = time.monotonic()
        node.drain()
        self.figures["drained_after"] = round(time.monotonic() - began, 3)
        node.start(self.cluster.databases.url)

    def fault(self) -> None:
        self.restart(self.owner())


class Upgrade(Drain):
    """SIGTERM of one node after the other, each started again before the next."""

    count = 5

    def fault(self) -> None:
        for node in self.cluster.nodes:
            self.restart(node)
            self.cluster.wait_until_steady()


class Clock(Kind):
    """Nodes an hour ahead and behind, and one whose clock jumps: it must not matter at all."""

    def set_up(self) -> None:
        for node, offset in zip(self.cluster.nodes, ("+3600", "-3600", "+0")):
            self._set(node, offset)
            node.drain()
            node.start(self.cluster.databases.url, {
                "LD_PRELOAD": str(FAKETIME), "FAKETIME_TIMESTAMP_FILE": str(self._file(node)),
                "FAKETIME_CACHE_DURATION": "1", "FAKETIME_DONT_FAKE_MONOTONIC": "1"})
            self.cluster.wait_until_steady()
            ahead = node.clock() - time.time()
            if abs(ahead - float(offset)) > 60:
                raise RuntimeError(
                    f"the clock of node {node.name} is {ahead} s ahead, not {offset}")

    def _file(self, node: Node) -> pathlib.Path:
        return self.folder / f"clock-{node.name}"

    def _set(self, node: Node, offset: str) -> None:
        self._file(node).write_text(offset + "\n", encoding="ascii")

    def fault(self) -> None:
        before = self.cluster.owners()
        for offset in ("+3600", "-1800", "+86400", "+0"):
            self._set(self.cluster.nodes[2], offset)
            time.sleep(2)
        self.note_moved(before)

    def take_down(self) -> None:
        self.restart_all(self.cluster.databases.url)


class Latency(Kind):
    """Nodes reach the database by a relay: 50 ms each way, and now and then 200 ms more."""

    _relay: Optional[subprocess.Popen[bytes]] = None

    def set_up(self) -> None:
        box = self.cluster.network.box()
        databases = self.cluster.databases
        words = [f"{port}:{address}:5432" for port, address in enumerate(databases.addresses, 5001)]
        self._relay = subprocess.Popen(box.command(
            [sys.executable, pathlib.Path(__file__).with_name("relay.py"), box.address,
             self.chance.randrange(2**32), *words]))
        hosts = ",".join(f"{box.address}:{port}" for port in (5001, 5002, 5003))
        time.sleep(1)
        self.restart_all(f"postgresql://postgres@{hosts}/postgres")

    def fault(self) -> None:
        before = self.cluster.owners()
        time.sleep(self.lasts)
        self.note_moved(before)

    def take_down(self) -> None:
        self.restart_all(self.cluster.databases.url)
        assert self._relay is not None
        self._relay.kill()


KINDS: dict[str, type[Kind]] = {
    "stop": Stop, "partition": Partition, "partition-out": PartitionOut,
    "partition-in": PartitionIn, "flap": Flap, "partition-clients": PartitionClients,
    "partition-nodes": PartitionNodes, "primary": Primary, "standby": Standby,
    "standbys": Standbys, "cancel": Cancel, "clock": Clock, "latency": Latency, "drain": Drain,
    "upgrade": Upgrade}
# What a kind allows at most: seconds without a batch of an affected mesh, 99 of 100.
LIMITS = {"drain": 0.3, "upgrade": 0.3}
# Kinds in which no error may reach a client of the library.
WITHOUT_ERRORS = ("drain", "upgrade")
