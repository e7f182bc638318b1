"""The kinds of faults, and what they may cost at most."""
from __future__ import annotations

import pathlib
import signal
import time

from databases import PATIENCE
from disk_full import DiskFull
from kind import Kind
from network import Pair, both_ways
from nodes import Node
from relayed import Latency, LostCommit

FAKETIME = pathlib.Path("/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1")


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
        self.figures["sessions"] = int(self.cluster.databases.sql(
            "SELECT count(*) FROM pg_stat_activity WHERE application_name = 'dynmeshd'"))


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
        written = self.work.wait_for_batches("at the new primary", PATIENCE)
        self.figures["promotion"] = round(promoted - decided, 3)
        self.figures["after_promotion"] = round(written - promoted, 3)
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


class Calm(Kind):
    """Nothing: how long a batch waits on this machine without a fault."""

    count = 5

    def fault(self) -> None:
        time.sleep(self.lasts)


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


KINDS: dict[str, type[Kind]] = {
    "stop": Stop, "partition": Partition, "partition-out": PartitionOut,
    "partition-in": PartitionIn, "flap": Flap, "partition-clients": PartitionClients,
    "partition-nodes": PartitionNodes, "primary": Primary, "standby": Standby,
    "standbys": Standbys, "cancel": Cancel, "lost-commit": LostCommit, "disk-full": DiskFull,
    "clock": Clock, "latency": Latency, "drain": Drain, "upgrade": Upgrade, "calm": Calm}
# What a kind allows at most: seconds without a batch of an affected mesh, 99 of 100.
LIMITS = {"drain": 0.3, "upgrade": 0.3}
# Kinds in which no error may reach a client of the library.
WITHOUT_ERRORS = ("drain", "upgrade")
