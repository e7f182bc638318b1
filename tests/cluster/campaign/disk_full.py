"""The disk of the primary database is full for a while."""
from __future__ import annotations

import os
import re
import shutil
import time
from typing import Any, Optional

import dynmesh
from databases import PATIENCE, Database, wait_until
from kind import Kind
from network import run

SIZE = 400 << 20  # bytes
# Little log is kept, and none of it is used again: so it needs space all the time.
SETTINGS = {"wal_keep_size": "48MB", "max_wal_size": "64MB", "min_wal_size": "32MB",
            "wal_recycle": "off"}
PROBE = "probe"  # a mesh whose edits are not repeated, so that their errors are seen


class SmallDisk:
    """A file system in memory that takes the place of a database's data while it is stopped."""

    def __init__(self, database: Database) -> None:
        self._data = database.folder / "data"
        self._root = database.folder / "small"
        self._filler = self._root / "filler"
        self._root.mkdir()
        run(["mount", "-t", "tmpfs", "-o", f"size={SIZE},mode=755", "none", str(self._root)])
        run(["cp", "-a", str(self._data), str(self._root)])
        run(["mount", "--bind", str(self._root / "data"), str(self._data)])

    def fill(self) -> None:
        """Until no byte is left."""
        with open(self._filler, "ab") as filler:
            while True:
                left = os.statvfs(self._root)
                free = left.f_bavail * left.f_frsize
                try:
                    os.posix_fallocate(filler.fileno(), filler.seek(0, os.SEEK_END), max(free, 1))
                except OSError:
                    if free == 0:
                        return

    def free(self) -> None:
        self._filler.unlink(missing_ok=True)

    def put_back(self) -> None:
        """The data, where it was before."""
        run(["umount", str(self._data)])
        shutil.rmtree(self._data)
        run(["cp", "-a", str(self._root / "data"), str(self._data)])
        run(["umount", str(self._root)])
        self._root.rmdir()


class DiskFull(Kind):
    """The disk of the primary is full. Every other time it is short of space for its log, too:
    then the database ends, and is started again and again, as by systemd."""

    count = 10
    _disk: Optional[SmallDisk] = None
    _database: Database
    _faults = 0
    _point = 0

    def set_up(self) -> None:
        self._database = database = self.cluster.databases.primary
        database.stop()
        database.more = SETTINGS
        database.start()
        wait_until("the primary", database.answers)
        self.cluster.databases.wait_for_standbys()
        for _ in range(2):
            database.sql("SELECT pg_switch_wal(); CHECKPOINT")
        database.stop()
        self._disk = SmallDisk(database)
        database.start()
        wait_until("the primary", database.answers)
        with dynmesh.connect(self.cluster.addresses, retry_for=PATIENCE) as server:
            server.create(PROBE, dimension=2, box=[[0, 0], [1, 1]])
        self._probe({})
        self.cluster.wait_until_steady()

    def fault(self) -> None:
        assert self._disk is not None
        logged = self._database.log_size()
        known = [writer.acknowledged for writer in self.work.writers]
        needs_log = self._faults % 2 == 1
        self._faults += 1
        refusals: dict[str, int] = {}
        restarts = 0
        self._disk.fill()
        try:
            until = time.monotonic() + self.lasts
            while time.monotonic() < until:
                if needs_log:
                    self._switch()
                restarts += self._start_again()
                self._probe(refusals)
                time.sleep(0.5)
            self.figures["written_meanwhile"] = sum(
                writer.acknowledged - before for writer, before in zip(self.work.writers, known))
        finally:
            self._disk.free()
        freed = time.monotonic()
        until = freed + PATIENCE
        while not self._database.answers():
            restarts += self._start_again()
            if time.monotonic() > until:
                raise RuntimeError("the primary does not come back")
            time.sleep(0.1)
        written = self.work.wait_for_batches("after the disk has space", PATIENCE)
        self.figures.update({
            "after_space": round(written - freed, 3),
            "restarts": restarts, "panics": self._database.count("PANIC: ", logged),
            "refused": self._database.count("No space left on device", logged),
            "refusals": refusals})

    def _switch(self) -> None:
        """To the next file of the log."""
        try:
            self._database.sql("SELECT txid_current(); SELECT pg_switch_wal()")
        except RuntimeError:
            pass  # it has no space for one, or does not run

    def _start_again(self) -> bool:
        if not self._database.has_ended():
            return False
        self._database.start()
        return True

    def _probe(self, refusals: dict[str, int]) -> None:
        """An edit that is not repeated; adds its error to `refusals`."""
        self._point += 1
        number = self._point
        add: dict[int, Any] = {number: [0.1 + 0.8 * (number * 0.7548776662466927 % 1),
                                        0.1 + 0.8 * (number * 0.5698402909980532 % 1)]}
        try:
            with dynmesh.connect(self.cluster.addresses, retry_for=0, timeout=2) as server:
                batch = dynmesh._batch.make(2, {"add_points": add})
                server.call(lambda client: client.apply(PROBE, batch, "", None, False))
        except dynmesh.errors.DynmeshError as error:
            told = f"{error.code} {error.reason}: " + re.sub("[0-9]+", "N", str(error))[:200]
            refusals[told] = refusals.get(told, 0) + 1

    def take_down(self) -> None:
        assert self._disk is not None
        with dynmesh.connect(self.cluster.addresses, retry_for=PATIENCE) as server:
            server.delete(PROBE)
        self._database.stop()
        self._database.more = {}
        self._disk.put_back()
        self._database.start()
        wait_until("the primary", self._database.answers)
        self.cluster.databases.wait_for_standbys()
