"""Runs faults one after the other, judges after each, and prints what they cost."""
from __future__ import annotations

import argparse
import json
import math
import pathlib
import random
import shutil
import sys
import time
import traceback
from typing import Any

from judge import Judge
from kind import Kind
from kinds import KINDS, LIMITS, WITHOUT_ERRORS
from network import run
from nodes import Cluster
from workload import Workload


# What readers and watchers count, beside what is judged.
OTHERS = ("read_errors", "watch_errors", "follower_reads", "follower_read_errors")


def quantile(values: list[float], part: float) -> float:
    ordered = sorted(values)
    return ordered[max(math.ceil(part * len(ordered)), 1) - 1] if ordered else 0.0


def tell(line: dict[str, Any]) -> None:
    print(json.dumps(line), flush=True)


class Campaign:
    """A cluster under load, and the faults of one run."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.folder = pathlib.Path(arguments.folder)
        self.lasts = arguments.lasts
        self.chance = random.Random(arguments.seed)
        # Snapshots come often, so that faults meet them.
        self.cluster = Cluster(self.folder, pathlib.Path(arguments.program),
                               ("--compact-bytes", 4000))
        self.work = Workload([node.address for node in self.cluster.nodes], arguments.meshes,
                             arguments.pause)
        self.judge = Judge(self.cluster, self.work)
        self.summary: list[dict[str, Any]] = []
        self.wrong: list[str] = []

    def run_kind(self, name: str, count: int) -> None:
        kind = KINDS[name](self.cluster, self.work, self.chance, self.folder, self.lasts)
        seconds: list[float] = []
        figures: dict[str, list[float]] = {}
        acknowledged = self.work.acknowledged()
        reads = self.work.count.of("reads") + self.work.count.of("probes")
        errors = len(self.work.errors())
        others = {what: self.work.count.of(what) for what in OTHERS}
        faults = 0
        before = self._judged()
        try:
            self.cluster.wait_until_steady()
            kind.set_up()
            for number in range(1, count + 1):
                seconds += self._one(name, number, kind)
                faults += 1
                for figure, value in kind.figures.items():
                    if value is None or isinstance(value, (int, float)):
                        figures.setdefault(figure, []).extend([] if value is None else [value])
            kind.take_down()
            self.judge.judge(f"after {name}")
        except (RuntimeError, OSError) as error:
            traceback.print_exc()
            self.wrong.append(f"{name} {faults + 1}: {error}")
        reached = self.work.errors()[errors:]
        line: dict[str, Any] = {
            "kind": name, "faults": faults, "pauses": len(seconds),
            "p50": round(quantile(seconds, 0.5), 3), "p99": round(quantile(seconds, 0.99), 3),
            "max": round(quantile(seconds, 1), 3),
            "acknowledged": self.work.acknowledged() - acknowledged,
            "reads": self.work.count.of("reads") + self.work.count.of("probes") - reads}
        for what, now, then in zip(("lost", "double", "stale", "wrong_hashes"),
                                   self._judged(), before):
            line[what] = now - then
        line["errors"] = len(reached)
        for what in OTHERS:
            line[what] = self.work.count.of(what) - others[what]
        for figure, values in figures.items():
            line[figure] = {"count": len(values), "p50": quantile(values, 0.5),
                            "p99": quantile(values, 0.99), "max": quantile(values, 1),
                            "sum": round(sum(values), 3)}
        self.summary.append(line)
        tell(line)
        for told in reached[:5]:
            print(f"  an error reached a client: {told}", flush=True)
        if name in LIMITS and line["p99"] > LIMITS[name]:
            self.wrong.append(f"{name}: p99 is {line['p99']} s, asked were {LIMITS[name]}")
        if name in WITHOUT_ERRORS and reached:
            self.wrong.append(f"{name}: {len(reached)} errors reached a client of the library")

    def _judged(self) -> tuple[int, int, int, int]:
        return (self.judge.lost, self.judge.double, self.work.count.of("stale"),
                self.work.count.of("wrong_hashes"))

    def _one(self, name: str, number: int, kind: Kind) -> list[float]:
        self.cluster.wait_until_steady()
        time.sleep(1 + self.chance.random())  # at any moment between two renewals
        kind.figures = {}
        wrong = len(self.judge.wrong)
        begin = time.monotonic()
        kind.fault()
        end = time.monotonic()
        self.work.wait_for_batches("after the fault", 120)
        pauses = {writer.mesh: round(writer.longest_pause(begin, end), 3)
                  for writer in self.work.of(kind.meshes)}
        kind.figures.update(self.work.read_pauses(kind.meshes, begin, end))
        self.judge.judge(f"{name} {number}")
        tell({"fault": name, "number": number, "pauses": pauses, **kind.figures,
              "wrong": self.judge.wrong[wrong:]})
        return list(pauses.values())

    def table(self) -> None:
        columns = ("kind", "faults", "pauses", "p50", "p99", "max", "acknowledged", "reads", "lost",
                   "double", "stale", "errors")
        rows = [columns, *([str(line[column]) for column in columns] for line in self.summary)]
        widths = [max(len(row[i]) for row in rows) for i in range(len(columns))]
        for row in rows:
            print("  ".join([row[0].ljust(widths[0])]
                            + [cell.rjust(width) for cell, width in zip(row[1:], widths[1:])]))


def main(arguments: argparse.Namespace) -> int:
    """In namespaces of its own; `arguments.folder` is hidden by one in memory."""
    run(["mount", "-t", "tmpfs", "-o", "size=4g,mode=755", "none", arguments.folder])
    print(f"seed {arguments.seed}", flush=True)
    wrong = ["the campaign did not start"]
    try:
        campaign = Campaign(arguments)
        for name in arguments.kind:
            campaign.run_kind(name, arguments.count or KINDS[name].count)
            if campaign.wrong and not arguments.go_on:
                break
        campaign.table()
        wrong = campaign.wrong + campaign.judge.wrong
        for note in campaign.work.count.notes[:20]:
            print(f"noted: {note}")
    except Exception:  # the logs are wanted
        traceback.print_exc()
    for what in wrong:
        print(f"WRONG: {what}")
    if wrong or arguments.keep_logs:
        logs = pathlib.Path(arguments.logs)
        logs.mkdir(parents=True, exist_ok=True)
        for log in logs_in(pathlib.Path(arguments.folder)):
            shutil.copyfile(log, logs / "-".join(log.relative_to(arguments.folder).parts))
        print(f"logs of nodes and databases: {logs}; seed {arguments.seed}")
    sys.stdout.flush()
    return 1 if wrong else 0


def logs_in(folder: pathlib.Path) -> list[pathlib.Path]:
    return [*folder.glob("node-*.log"), *folder.glob("database-*/log")]
