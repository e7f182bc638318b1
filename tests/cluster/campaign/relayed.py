"""Faults of the connections between nodes and databases, which lead through a relay."""
from __future__ import annotations

import json
import pathlib
import select
import subprocess
import sys
import time
from typing import Optional

from databases import PATIENCE
from kind import Kind


class Relayed(Kind):
    """Nodes reach the databases by a relay, the program `script`."""

    script = ""

    relay: Optional[subprocess.Popen[bytes]] = None

    def set_up(self) -> None:
        box = self.cluster.network.box()
        databases = self.cluster.databases
        words = [f"{port}:{address}:5432" for port, address in enumerate(databases.addresses, 5001)]
        self.relay = subprocess.Popen(
            box.command([sys.executable, pathlib.Path(__file__).with_name(self.script), box.address,
                         self.chance.randrange(2**32), *words]),
            stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        hosts = ",".join(f"{box.address}:{port}" for port in (5001, 5002, 5003))
        time.sleep(1)
        self.restart_all(f"postgresql://postgres@{hosts}/postgres")

    def take_down(self) -> None:
        self.restart_all(self.cluster.databases.url)
        assert self.relay is not None
        self.relay.kill()


class Latency(Relayed):
    """50 ms each way, and now and then 200 ms more."""

    script = "relay.py"

    def fault(self) -> None:
        before = self.cluster.owners()
        time.sleep(self.lasts)
        self.note_moved(before)


class LostCommit(Relayed):
    """A hundred appends that are committed, and whose answers are lost."""

    count = 10
    script = "losing_relay.py"
    answers = 100  # of a fault

    def fault(self) -> None:
        logged = {node.name: node.log_size() for node in self.cluster.nodes}
        before = self.cluster.owners()
        begin = time.monotonic()
        self.figures.update(self._lose())
        self.figures["seconds"] = round(time.monotonic() - begin, 3)
        self.figures["moved"] = sum(
            owner != before[mesh][0] for mesh, (owner, _) in self.cluster.owners().items())
        for event in ("append_unknown", "append_resolved", "mesh_disowned"):
            self.figures[event] = sum(
                node.count(event, logged[node.name]) for node in self.cluster.nodes)

    def _lose(self) -> dict[str, int]:
        assert self.relay is not None and self.relay.stdin and self.relay.stdout
        self.relay.stdin.write(f"{self.answers}\n".encode())
        self.relay.stdin.flush()
        if not select.select([self.relay.stdout], [], [], 2 * PATIENCE)[0]:
            raise RuntimeError(f"not {self.answers} answers were lost in {2 * PATIENCE} s")
        done: dict[str, int] = json.loads(self.relay.stdout.readline())
        return done
