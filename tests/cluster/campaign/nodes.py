"""Three dynmeshd that share the meshes of one database, each in a box of its own."""
from __future__ import annotations

import datetime
import os
import pathlib
import signal
import subprocess
from typing import Iterable, Mapping, Optional

from databases import PATIENCE, Databases, wait_until
from network import Box, Network

LEASE = 3  # seconds
PORT = 7878


class Node:
    """A dynmeshd whose address outlives its process."""

    def __init__(self, name: str, box: Box, folder: pathlib.Path, program: pathlib.Path,
                 options: Iterable[object]) -> None:
        self.name = name
        self.host = box.address
        self.address = f"{box.address}:{PORT}"
        self._box = box
        self._log = folder / f"node-{name}.log"
        self._port_file = folder / f"node-{name}.port"
        self._program = program
        self._options = tuple(options)
        self._process: Optional[subprocess.Popen[bytes]] = None

    def start(self, journal: str, environment: Optional[Mapping[str, str]] = None) -> None:
        """Returns when it serves."""
        self._port_file.unlink(missing_ok=True)
        with open(self._log, "ab") as log:
            self._process = process = subprocess.Popen(
                self._box.command([
                    self._program, "--listen", self.address, "--insecure-listen",
                    "--node-address", self.host, "--journal", journal, "--lease", LEASE,
                    "--port-file", self._port_file, *self._options]),
                stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                env={**os.environ, **(environment or {})})

        def serves() -> bool:
            if process.poll() is not None:
                raise RuntimeError(f"node {self.name} ended with {process.returncode}")
            return self._port_file.exists() and self._port_file.read_text() != ""
        wait_until(f"node {self.name}", serves)

    def send(self, how: signal.Signals) -> None:
        assert self._process is not None
        self._process.send_signal(how)

    def drain(self) -> None:
        """SIGTERM, until it has ended."""
        assert self._process is not None
        self._process.terminate()
        if self._process.wait(PATIENCE) != 0:
            raise RuntimeError(f"node {self.name} drained with {self._process.returncode}")

    def check(self) -> None:
        """It must not have ended by itself."""
        assert self._process is not None
        if self._process.poll() is not None:
            raise RuntimeError(f"node {self.name} ended with {self._process.returncode}")

    def clock(self) -> float:
        """Its time, as it is in the last line of its log."""
        last = self._log.read_text(encoding="utf-8").rsplit("time=", 1)[1].split()[0]
        return datetime.datetime.fromisoformat(last).timestamp()

    def log_size(self) -> int:
        return self._log.stat().st_size

    def count(self, event: str, since: int = 0) -> int:
        """How often the log has the event, after the first `since` bytes."""
        with open(self._log, "rb") as log:
            log.seek(since)
            return log.read().count(f"event={event} ".encode())


class Cluster:
    """The network with databases and nodes, whose command line has the options."""

    def __init__(self, folder: pathlib.Path, program: pathlib.Path,
                 options: Iterable[object] = ()) -> None:
        self.network = Network()
        self.databases = Databases(self.network, folder)
        self.nodes = [Node(str(number), self.network.box(), folder, program, options)
                      for number in (1, 2, 3)]
        for node in self.nodes:
            node.start(self.databases.url)

    @property
    def addresses(self) -> str:
        return ",".join(node.address for node in self.nodes)

    def owners(self) -> dict[str, tuple[str, int]]:
        """Address of the owner and epoch, by mesh."""
        rows = self.databases.sql(
            "SELECT m.id, coalesce(n.address, ''), m.epoch FROM dynmesh.meshes AS m LEFT JOIN "
            "dynmesh.nodes AS n ON n.id = m.owner")
        found = {}
        for row in rows.splitlines():
            mesh, address, epoch = row.split("|")
            found[mesh] = (address, int(epoch))
        return found

    def at(self, address: str) -> Node:
        return next(node for node in self.nodes if node.address == address)

    def is_steady(self) -> bool:
        """All nodes renew their leases, each mesh has one, and another node that follows it."""
        return self.databases.sql(
            "WITH live AS (SELECT id, address FROM dynmesh.nodes WHERE seen > "
            f"clock_timestamp() - interval '{LEASE} s') "
            f"SELECT (SELECT count(DISTINCT address) FROM live) = {len(self.nodes)} "
            "AND NOT EXISTS (SELECT FROM dynmesh.meshes AS m WHERE m.lease_until < "
            "clock_timestamp() OR NOT EXISTS (SELECT FROM dynmesh.followers AS f JOIN live ON "
            "live.id = f.node WHERE f.mesh = m.key AND f.is_warm AND f.node <> m.owner))"
        ) == "t"

    def wait_until_steady(self) -> None:
        for node in self.nodes:
            node.check()
        self.databases.wait_for_standbys()
        wait_until("nodes with leases and followers", self.is_steady)
