"""What all kinds of faults have in common."""
from __future__ import annotations

import pathlib
import random
import time
from typing import Any, Optional

from nodes import Cluster, Node
from workload import Workload


class Kind:
    """A fault of a random owner of meshes; `fault` returns when it is over. `meshes`: those whose
    pauses count; None: all."""

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
