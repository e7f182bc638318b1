"""What must be true of the meshes, by the database and by the service."""
from __future__ import annotations

import dynmesh
from databases import PATIENCE, wait_until
from nodes import Cluster
from workload import Workload, Writer

# By mesh: head, newest and oldest request, requests that are not of their batch, requests that are
# missing in between, entries that are missing in between, entries of an older epoch than the entry
# before, newest entry.
ROWS = """
SELECT m.id, m.head,
  coalesce((SELECT max(number) FROM dynmesh.requests WHERE mesh = m.key), 0),
  coalesce((SELECT min(number) FROM dynmesh.requests WHERE mesh = m.key), 0),
  (SELECT count(*) FROM dynmesh.requests WHERE mesh = m.key
    AND convert_from(id, 'UTF8') <> 'w-' || number),
  (SELECT coalesce(max(number) - min(number) + 1, 0) - count(*) FROM dynmesh.requests
    WHERE mesh = m.key),
  (SELECT coalesce(max(revision) - min(revision) + 1, 0) - count(*) FROM dynmesh.entries
    WHERE mesh = m.key),
  (SELECT count(*) FROM (SELECT epoch < lag(epoch) OVER (ORDER BY revision) AS is_older
    FROM dynmesh.entries WHERE mesh = m.key) AS e WHERE is_older),
  coalesce((SELECT max(revision) FROM dynmesh.entries WHERE mesh = m.key), 0)
FROM dynmesh.meshes AS m"""


class Judge:
    """Judges again and again, and says what is wrong. Stops the writers meanwhile."""

    def __init__(self, cluster: Cluster, work: Workload) -> None:
        self._cluster = cluster
        self._work = work
        self._seen = {writer.mesh: 0 for writer in work.writers}  # the newest request
        self.lost = 0  # acknowledged batches that are not there
        self.double = 0  # batches that are there twice, or in another order
        self.wrong: list[str] = []
        self._told: set[str] = set()  # troubles of writers
        self._counted = {"stale": 0, "wrong_hashes": 0}

    def judge(self, when: str) -> None:
        writers = self._work.writers
        for writer in writers:
            writer.hold()
        wait_until("all writers' answers", lambda: all(w.is_held() for w in writers), 2 * PATIENCE)
        before = len(self.wrong)
        self.wrong += [trouble for trouble in self._work.trouble() if trouble not in self._told]
        self._told.update(self._work.trouble())
        rows = {}
        for row in self._cluster.databases.sql(ROWS).splitlines():
            mesh, *numbers = row.split("|")
            rows[mesh] = [int(number) for number in numbers]
        with dynmesh.connect(self._cluster.addresses, retry_for=PATIENCE) as server:
            for writer in writers:
                self._journal(writer, rows[writer.mesh])
                self._meshes(writer, server)
        for name in ("stale", "wrong_hashes"):
            if self._work.count.of(name) > self._counted[name]:
                self.wrong.append(f"{name}: {self._work.count.of(name) - self._counted[name]}")
                self._counted[name] = self._work.count.of(name)
        self.wrong[before:] = [f"{when}: {what}" for what in self.wrong[before:]]
        for writer in writers:
            writer.go_on()

    def _journal(self, writer: Writer, row: list[int]) -> None:
        mesh, known = writer.mesh, writer.acknowledged
        head, newest, oldest, others, missing, gaps, older, last = row
        # All answers are there: the last acknowledged batch is the last one of all.
        if min(head, newest, last) < known:
            self.lost += known - min(head, newest, last)
            self.wrong.append(f"{mesh}: revision {known} was acknowledged; the head is {head}, the "
                              f"newest request {newest}, the newest entry {last}")
        if max(head, newest, last) > known:
            self.double += max(head, newest, last) - known
            self.wrong.append(f"{mesh}: of {known} batches came revision {head}, request {newest}, "
                              f"entry {last}")
        if others or missing or gaps:
            self.double += others
            self.lost += missing + gaps
            self.wrong.append(f"{mesh}: {others} requests are not of their batch, {missing} and "
                              f"{gaps} entries are missing")
        if oldest > self._seen[mesh] + 1:
            self.wrong.append(f"{mesh}: requests {self._seen[mesh] + 1} to {oldest - 1} were "
                              "forgotten before they were judged")
        self._seen[mesh] = newest
        if older:
            self.wrong.append(f"{mesh}: {older} entries are of an older epoch than the one before")

    def _meshes(self, writer: Writer, server: dynmesh.Server) -> None:
        mesh, known = writer.mesh, writer.acknowledged
        scratch = dynmesh.open([[0] * writer.dimension, [1] * writer.dimension],
                               dimension=writer.dimension)
        scratch.apply(**writer.features_after(known))
        told = server.call(lambda client: client.get(mesh))
        if (told["revision"], told["hash"]) != (known, scratch.hash):
            self.wrong.append(f"{mesh}: the service has {told['revision']} {told['hash']}, from "
                              f"scratch it is {known} {scratch.hash}")
        copy = server.mesh(mesh)
        if (copy.revision, copy.hash) != (known, scratch.hash):
            self.wrong.append(f"{mesh}: a snapshot has {copy.revision} {copy.hash}, from scratch "
                              f"it is {known} {scratch.hash}")
        for number, watcher in enumerate(self._work.watchers[mesh]):
            expected = (known, scratch.hash)
            try:
                wait_until("a watcher", lambda: watcher.at[0] >= known)
            except RuntimeError:
                pass
            if watcher.at != expected:
                self.wrong.append(f"{mesh}: watcher {number} has {watcher.at}, from scratch it is "
                                  f"{expected}")
