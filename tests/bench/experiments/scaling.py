#!/usr/bin/python3
"""How time, memory and size grow with the number of points (the thesis's Fig. 3.5).

    tests/bench/experiments/scaling.py [--quick] [--most N] [--limit SECONDS]

Uniform points in a cube, 1,000 to N (a million), by SVR, the dynamic mesher and TetGen.
"""
from __future__ import annotations

import inputs
import meshers
from output import arguments, markdown, plot, section, show, write_csv

TEXT = """\
# Scaling to a million points

`tests/bench/experiments/scaling.py` writes this section (the thesis's Fig. 3.5): uniform points in a cube,
circumradius / shortest edge at most 2. Microseconds are of processor time, per vertex of the result. They
would be level if time were linear: what grows is lg n, by sorting, and misses of caches.

![Seconds by points](deploy/pictures/scaling.svg)
"""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--most", type=int, default=1_000_000)
    parser.add_argument("--limit", type=float, default=500, help="seconds of a run")
    flags = parser.parse_args()
    most = 10_000 if flags.quick else flags.most
    methods = ["svr", "dynamic"] + (["TetGen"] if meshers.has_tetgen() else [])
    head = ["points", "method", "seconds", "vertices", "peak MB", "us a vertex"]
    rows, series = [], {method: ([], []) for method in methods}
    for n in [n for n in (1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000) if n <= most]:
        points = inputs.uniform(n)
        for method in list(methods):
            run = (meshers.tetgen(points, flags.limit) if method == "TetGen" else
                   meshers.dynmesh(flags.bin / "dynmesh", method, points, flags.limit))
            if run is None:
                methods.remove(method)
                continue
            rows.append([n, method, round(run.seconds, 3), run.vertices, round(run.megabytes),
                         round(1e6 * run.seconds / run.vertices, 2)])
            series[method][0].append(n)
            series[method][1].append(max(run.seconds, 1e-3))
            print(*rows[-1], sep="  ", flush=True)
    write_csv(flags.out / "scaling.csv", head, rows)
    picture = flags.out / "scaling.svg"
    plot(picture, series, "points", "seconds", logarithmic=True)
    if not flags.quick:
        show(flags.page, picture)
        table = [[f"{row[0]:,}", row[1], row[2], f"{row[3]:,}", row[4], row[5]] for row in rows]
        section(flags.page, "scaling.py", TEXT + "\n" + markdown(head, table))


if __name__ == "__main__":
    main()
