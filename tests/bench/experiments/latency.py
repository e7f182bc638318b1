#!/usr/bin/python3
"""The latency of a million single edits, to the 99.99th percentile.

    tests/bench/experiments/latency.py [--quick] [--edits N]

Runs dynmesh_latency_tables: points of a uniform mesh in 2D and 3D are removed, added and moved.
"""
from __future__ import annotations

import programs
from output import arguments, markdown, section, write_csv

TEXT = """\
# Latency of a million edits

`tests/bench/experiments/latency.py` writes this section: a third each of removals, additions and moves of
random points among 10,000 uniform ones, in the library; microseconds. "wall" has what a shared machine did
meanwhile, "processor" is this thread's time.
"""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--edits", type=int, default=1_000_000)
    flags = parser.parse_args()
    points, edits = (1_000, 1_000) if flags.quick else (10_000, flags.edits)
    rows = []
    for dimension, count in ((2, edits), (3, edits // 10)):
        head, some = programs.table(flags.bin / "dynmesh_latency_tables", points, count, dimension)
        rows += [[dimension, count, *row] for row in some]
    write_csv(flags.out / "latency.csv", ["dimension", "edits", *head], rows)
    if not flags.quick:
        table = [[f"{row[0]}D", f"{row[1]:,}", *row[2:]] for row in rows]
        section(flags.page, "latency.py", TEXT + "\n" + markdown(
            ["", "edits", "kind", "clock", "50 %", "90 %", "99 %", "99.9 %", "99.99 %", "greatest"],
            table))


if __name__ == "__main__":
    main()
