#!/usr/bin/python3
"""How far an edit is felt where each vertex could depend on the next (the thesis's Fig. 4.8).

    tests/bench/experiments/chains.py [--quick] [--most N]

Runs dynmesh_chain_tables: up to N (10,000) points, evenly spaced on a line.
"""
from __future__ import annotations

import programs
from output import arguments, markdown, section, write_csv

TEXT = """\
# Chains of dependence

`tests/bench/experiments/chains.py` writes this section. Of evenly spaced points on a line each one's work
could depend on its neighbour's (the thesis's Fig. 4.8), so an edit could be felt along all of it. The thesis
colours a grid to cut such chains. Here work of equal length runs in the order of a hash of coordinates: a
chain goes on only while hashes ascend. `random`: points as they come. `ascending`: the last bits of the
coordinates were chosen so that hashes ascend along the line, which is the order of coordinates, or the work
of an adversary that knows the hash. 200 points are removed and added again; `reach` is the distance in
spacings from the point to the farthest vertex that comes or goes, of those within 3 spacings of
the line.
"""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--most", type=int, default=10_000)
    flags = parser.parse_args()
    head, rows = programs.table(flags.bin / "dynmesh_chain_tables",
                                300 if flags.quick else flags.most)
    write_csv(flags.out / "chains.csv", head, rows)
    if not flags.quick:
        section(flags.page, "chains.py", TEXT + "\n" + markdown(
            ["points", "order of hashes", "operations", "most", "reach", "farthest"],
            [[f"{int(row[0]):,}", *row[1:]] for row in rows]))


if __name__ == "__main__":
    main()
