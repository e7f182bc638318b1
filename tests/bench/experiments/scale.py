#!/usr/bin/python3
"""A thousand servers and a million meshes on paper: balance, take-overs, the database's load.

    tests/bench/experiments/scale.py [--quick] [--seed S]

Simulates what server/cluster, server/meshes/mesh_opener and the journal in PostgreSQL do, with the
costs of COSTS, which were measured (database_costs.py; openings: docs/scale.md). Needs numpy only.
Writes its sections of docs/scale.md.
"""
from __future__ import annotations

import dataclasses
import heapq
import math
import pathlib
import shutil

import numpy as np

from output import ROOT, arguments, markdown, plot, section, write_csv

NODES, MESHES, RACK = 1_000, 1_000_000, 40
LEASE = 3.0  # seconds; renewed twice in it, polled ten times in it while it runs out
MEAN_FEATURES, MOST_FEATURES = 1_000, 1_000_000  # of a mesh
EDITS = 10_000  # a second, of all meshes
USE = 0.5  # the part of a database's cores that is to be used


@dataclasses.dataclass(frozen=True)
class Costs:
    """Seconds of processor time, or bytes. Of the database unless it says otherwise."""

    open_mesh: float = 0.9e-3  # the server's, of an opening
    open_feature: float = 7.5e-6  # the server's, of each feature
    scan_row: float = 0.165e-6  # of a renewal, each row of the table, without an index by owner
    renew_row: float = 5e-6  # of a renewal, each mesh that is renewed
    renew_row_log: float = 135
    renew_node: float = 0.45e-3  # a renewal of one row of the table of nodes
    renew_node_log: float = 330
    claim: float = 0.46e-3
    locate: float = 0.06e-3
    live_node: float = 0.75e-6  # of a list of live nodes, each
    read: float = 0.36e-3  # of a mesh without features
    read_feature: float = 0.05e-6
    append: float = 0.58e-3  # of 150 bytes, one batch
    append_log: float = 754
    connection: float = 9e6  # bytes of memory
    commit: float = 1.3e-3  # seconds that a commit with a standby takes
    connections_of_node: int = 25


COSTS = Costs()

# ------------------------------------------------------------------ placement


def absorb(hashes: np.ndarray, column: np.ndarray) -> None:
    hashes ^= column
    hashes *= np.uint64(0x100000001B3)


def prefix_of(node: str) -> int:
    state = 0xCBF29CE484222325
    for byte in node.encode() + b"\0":
        state = ((state ^ byte) * 0x100000001B3) % 2**64
    return state


def weights(prefix: int, names: np.ndarray) -> np.ndarray:
    """server/cluster/placement.cc: PlacementWeight of one node on meshes; `names` is of bytes."""
    hashes = np.full(len(names), prefix, dtype=np.uint64)
    for column in names.T:
        absorb(hashes, column)
    hashes ^= hashes >> np.uint64(30)
    hashes *= np.uint64(0xBF58476D1CE4E5B9)
    hashes ^= hashes >> np.uint64(27)
    hashes *= np.uint64(0x94D049BB133111EB)
    hashes ^= hashes >> np.uint64(31)
    return hashes


def names_of(meshes: int) -> np.ndarray:
    text = "".join(f"mesh-{i:07}" for i in range(meshes)).encode()
    return np.frombuffer(text, dtype=np.uint8).reshape(meshes, -1).astype(np.uint64)


def place(names: np.ndarray, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each mesh the two of `nodes`, numbers, with the largest weights."""
    best, second = (np.zeros(len(names), dtype=np.int32) for _ in range(2))
    prefixes = [prefix_of(f"node-{node}.example:7878") for node in nodes]
    for begin in range(0, len(names), 1 << 15):
        part = names[begin:begin + (1 << 15)]
        first_weight, second_weight = (np.zeros(len(part), dtype=np.uint64) for _ in range(2))
        a, b = (np.zeros(len(part), dtype=np.int32) for _ in range(2))
        for node, prefix in zip(nodes, prefixes):
            weight = weights(prefix, part)
            wins = weight > first_weight
            places = ~wins & (weight > second_weight)
            b[wins], second_weight[wins] = a[wins], first_weight[wins]
            a[wins], first_weight[wins] = node, weight[wins]
            b[places], second_weight[places] = node, weight[places]
        best[begin:begin + len(part)], second[begin:begin + len(part)] = a, b
    return best, second


def zipf(count: int, exponent: float, mean: float, most: float,
         random: np.random.Generator) -> np.ndarray:
    """Values in random order, the r-th largest proportional to r^-exponent up to `most`."""
    shape = np.arange(1, count + 1, dtype=float) ** -exponent
    low, high = mean, mean * count * 1.0
    for _ in range(80):
        middle = math.sqrt(low * high)
        if np.minimum(middle * shape, most).mean() < mean:
            low = middle
        else:
            high = middle
    return random.permutation(np.minimum(low * shape, most))


def max_to_mean(owner: np.ndarray, value: np.ndarray, nodes: int) -> float:
    sums = np.bincount(owner, weights=value, minlength=nodes)
    return float(sums.max() / sums.mean())


def bennett(value: np.ndarray, nodes: int) -> float:
    """What max_to_mean exceeds with a probability of at most a tenth, for independent choices:
    P(sum > mean + t) <= exp(-v / b^2 h(b t / v)), h(u) = (1 + u) ln(1 + u) - u."""
    mean, largest = float(value.sum()) / nodes, float(value.max())
    variance = float((value**2).sum()) / nodes
    wanted = math.log(10 * nodes) * largest**2 / variance
    low, high = 0.0, 1e9
    for _ in range(100):
        middle = (low + high) / 2
        if (1 + middle) * math.log1p(middle) - middle < wanted:
            low = middle
        else:
            high = middle
    return 1 + high * variance / largest / mean


def less_loaded(best: np.ndarray, second: np.ndarray, value: np.ndarray, nodes: int) -> np.ndarray:
    """Of the two first choices the one that has less, the heaviest mesh first."""
    load = [0.0] * nodes
    owner = best.copy()
    for mesh in np.argsort(-value, kind="stable"):
        a, b = best[mesh], second[mesh]
        chosen = a if load[a] <= load[b] else b
        owner[mesh] = chosen
        load[chosen] += value[mesh]
    return owner


def balance(best: np.ndarray, second: np.ndarray, nodes: int,
            random: np.random.Generator) -> list[list[object]]:
    meshes = len(best)
    ones = np.ones(meshes)
    rows = [["meshes", f"{max_to_mean(best, ones, nodes):.2f}", f"{bennett(ones, nodes):.2f}",
             f"{max_to_mean(less_loaded(best, second, ones, nodes), ones, nodes):.2f}", "1.00"]]
    for what, most in (("features", MOST_FEATURES / MEAN_FEATURES), ("edits", math.inf)):
        for exponent in (0.8, 1.0, 1.2):
            value = zipf(meshes, exponent, 1.0, most, random)
            rows.append([f"{what}, Zipf {exponent}", f"{max_to_mean(best, value, nodes):.2f}",
                         f"{bennett(value, nodes):.2f}",
                         f"{max_to_mean(less_loaded(best, second, value, nodes), value, nodes):.2f}",
                         f"{value.max() * nodes / value.sum():.2f}"])
    return rows


# ------------------------------------------------------------------ take-overs


@dataclasses.dataclass(frozen=True)
class Storm:
    name: str
    databases: int = 1
    cores: int = 16  # of each database
    openers: int = 4  # threads of a node that open meshes
    lease_of_node: bool = False
    lists_live: bool = True  # a list of live nodes at each first look
    polls: bool = True  # each mesh that waits is looked at ten times in a lease
    small_first: bool = False
    asked: float = 1.0  # the part of the lost meshes that clients wait for


def background(storm: Storm, nodes: int, meshes: int) -> float:
    """Cores of each database that renewals and appends use; renewals use the index."""
    renewals = 2 * nodes / LEASE / storm.databases
    one = COSTS.renew_node
    if not storm.lease_of_node:
        one += COSTS.renew_row * meshes / nodes
    return renewals * one + EDITS * COSTS.append / storm.databases


class Database:
    """Cores that take work in the order in which it comes."""

    def __init__(self, cores: int, used: float) -> None:
        self.free = [0.0] * cores
        self.slower = 1 / max(1 - used / cores, 1e-3)
        self.busy = 0.0

    def work(self, now: float, seconds: float) -> float:
        begun = max(now, heapq.heappop(self.free))
        end = begun + seconds * self.slower
        heapq.heappush(self.free, end)
        self.busy += seconds
        return end


def take_over(storm: Storm, lost: np.ndarray, owner: np.ndarray, left: np.ndarray,
              features: np.ndarray, database: np.ndarray, nodes: int, meshes: int,
              random: np.random.Generator) -> tuple[np.ndarray, float]:
    """When each lost mesh that is asked for can be written again, and the use of the databases'
    cores until half of them can. `owner`, `left`, `features` and `database` are by lost mesh."""
    used = background(storm, nodes, meshes)
    databases = [Database(storm.cores, used) for _ in range(storm.databases)]
    chosen = np.flatnonzero(random.random(len(lost)) < storm.asked)
    # Jobs by time: (time, order, kind, mesh). Looks while the lease runs out, then openings.
    events: list[tuple[float, int, str, int]] = []
    order = 0

    def add(time: float, kind: str, mesh: int) -> None:
        nonlocal order
        order += 1
        heapq.heappush(events, (time, order, kind, mesh))

    first_look = COSTS.locate + (COSTS.live_node * nodes if storm.lists_live else 0.0)
    for mesh in chosen:
        asked = random.random() * LEASE / 10
        add(asked, "first", int(mesh))
        if storm.polls:
            for time in np.arange(asked + LEASE / 10, left[mesh], LEASE / 10):
                add(float(time), "look", int(mesh))
        add(float(left[mesh]), "open", int(mesh))
    idle = np.full(nodes, storm.openers)
    waiting: list[list[tuple[float, int, int]]] = [[] for _ in range(nodes)]
    done = np.full(len(lost), np.nan)
    opening = COSTS.locate + COSTS.claim + COSTS.read

    def begin(now: float, mesh: int) -> None:
        seconds = opening + COSTS.read_feature * float(features[mesh])
        add(databases[database[mesh]].work(now, seconds), "make", mesh)

    while events:
        now, number, kind, mesh = heapq.heappop(events)
        node = owner[mesh]
        if kind == "first":
            databases[database[mesh]].work(now, first_look)
        elif kind == "look":
            databases[database[mesh]].work(now, COSTS.locate)
        elif kind == "open":
            if idle[node] > 0:
                idle[node] -= 1
                begin(now, mesh)
            else:
                key = float(features[mesh]) if storm.small_first else now
                heapq.heappush(waiting[node], (key, number, mesh))
        elif kind == "make":
            seconds = COSTS.open_mesh + COSTS.open_feature * float(features[mesh])
            add(now + seconds, "done", mesh)
        else:
            done[mesh] = now
            if waiting[node]:
                begin(now, heapq.heappop(waiting[node])[2])
            else:
                idle[node] += 1
    times = np.sort(done[chosen])
    return times, sum(d.busy for d in databases)


# ------------------------------------------------------------------ the steady load


def steady(nodes: int, meshes: int) -> list[list[object]]:
    """Cores, log and connections of one database, by kind of lease."""
    per_second = 2 * nodes / LEASE
    rows = []
    for name, seconds, log in (
            ("a row a mesh, without an index (before)",
             COSTS.scan_row * meshes + COSTS.renew_row * meshes / nodes,
             COSTS.renew_row_log * meshes / nodes),
            ("a row a mesh (today)", COSTS.renew_node + COSTS.renew_row * meshes / nodes,
             COSTS.renew_row_log * meshes / nodes),
            ("a row a node", COSTS.renew_node, COSTS.renew_node_log)):
        rows.append([name, f"{per_second:,.0f}", f"{per_second * seconds:,.2f}",
                     f"{per_second * log / 1e6:,.2f}"])
    rows.append([f"appends, {EDITS:,} a second", f"{EDITS:,}", f"{EDITS * COSTS.append:,.2f}",
                 f"{EDITS * COSTS.append_log / 1e6:,.2f}"])
    return rows


def most_meshes(nodes: int, cores: int, index: bool) -> float:
    """With half of the cores for renewals."""
    row = COSTS.renew_row + (0 if index else COSTS.scan_row * nodes)
    return USE * cores * LEASE / 2 / row


LIMITS = """\
| nodes | meshes at most, without an index | today | connections | their memory |
| --- | --- | --- | --- | --- |
"""


def limits() -> str:
    rows = ""
    for nodes in (3, 10, 30, 100, 300, 1_000):
        connections = nodes * COSTS.connections_of_node
        rows += (f"| {nodes:,} | {most_meshes(nodes, 16, False):,.0f} | "
                 f"{most_meshes(nodes, 16, True):,.0f} | {connections:,} | "
                 f"{connections * COSTS.connection / 1e9:,.1f} GB |\n")
    return LIMITS + rows


STORMS = (
    Storm("A: today"),
    Storm("B: leases of nodes", lease_of_node=True),
    Storm("C: B, live nodes remembered", lease_of_node=True, lists_live=False),
    Storm("D: C, no looks while a lease runs out", lease_of_node=True, lists_live=False,
          polls=False),
    Storm("E: D, small meshes first", lease_of_node=True, lists_live=False, polls=False,
          small_first=True),
    Storm("F: D, 16 openers", lease_of_node=True, lists_live=False, polls=False, openers=16),
    Storm("G: D, 25 databases of 4 cores", databases=25, cores=4, lease_of_node=True,
          lists_live=False, polls=False),
    Storm("A, a tenth of the meshes is asked for", asked=0.1),
)


def main() -> None:
    parser = arguments(__doc__)
    parser.set_defaults(page=ROOT / "docs/scale.md")
    parser.add_argument("--seed", type=int, default=1)
    flags = parser.parse_args()
    nodes, meshes, rack = (100, 20_000, 4) if flags.quick else (NODES, MESHES, RACK)
    print(f"seed {flags.seed}, {nodes:,} nodes, {meshes:,} meshes")
    random = np.random.default_rng(flags.seed)
    names = names_of(meshes)
    best, second = place(names, np.arange(nodes))
    balanced = balance(best, second, nodes, random)
    head = ["of a node", "most / mean", "9 of 10 below", "less loaded of two", "largest mesh / mean"]
    write_csv(flags.out / "scale_balance.csv", head, balanced)
    for row in balanced:
        print(*row, sep="  ")

    # A rack: every 25th node.
    dead = np.arange(0, nodes, nodes // rack)
    alive = np.setdiff1d(np.arange(nodes), dead)
    lost = np.flatnonzero(np.isin(best, dead))
    owner, _ = place(names[lost], alive)
    left = (LEASE / 2 * (1 + random.random(nodes)))[best[lost]]
    features = zipf(meshes, 1.0, MEAN_FEATURES, MOST_FEATURES, random)[lost]
    print(f"{len(lost):,} meshes lost, the largest of {features.max():,.0f} features")
    storms, series = [], {}
    for storm in STORMS:
        database = lost % storm.databases
        times, busy = take_over(storm, lost, owner, left, features, database, nodes, meshes,
                                np.random.default_rng(flags.seed + 1))
        free = storm.databases * storm.cores - storm.databases * background(storm, nodes, meshes)
        at = [float(np.quantile(times, q)) for q in (0.5, 0.9, 0.99, 1.0)]
        storms.append([storm.name, *(f"{t:.1f}" for t in at), f"{busy:.0f}", f"{busy / free:.1f}"])
        print(*storms[-1], sep="  ", flush=True)
        if "tenth" not in storm.name and storm.name[0] != "F":
            shares = np.linspace(0, 1, 101)
            series[storm.name] = (np.quantile(times, shares), 100 * shares)
    head_storms = ["", "half, s", "90 %, s", "99 %, s", "all, s", "work of the database, core s",
                   "at full use, s"]
    write_csv(flags.out / "scale_storms.csv", head_storms, storms)
    picture = flags.out / "scale_takeover.svg"
    plot(picture, series, "seconds after the loss of the rack", "% of its meshes written again",
         logarithmic=False)
    loads = steady(nodes, meshes)
    head_loads = ["", "statements / s", "cores", "log, MB/s"]
    write_csv(flags.out / "scale_load.csv", head_loads, loads)
    if flags.quick:
        return
    if picture.exists():
        shutil.copy(picture, ROOT / "deploy/pictures" / picture.name)
    note = f"Seed {flags.seed}.\n\n"
    section(flags.page, "scale.py/balance", note + markdown(head, balanced))
    section(flags.page, "scale.py/storms", note + markdown(head_storms, storms))
    section(flags.page, "scale.py/load", markdown(head_loads, loads))
    section(flags.page, "scale.py/limits", limits())


if __name__ == "__main__":
    main()
