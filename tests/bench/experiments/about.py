#!/usr/bin/python3
"""Writes what all experiments have in common: how to run them, on what machine they ran, and what
does not match the thesis.

    tests/bench/experiments/about.py
"""
from __future__ import annotations

import datetime
import os
import pathlib
import platform
import re
import subprocess

from output import arguments, markdown, section

EXPERIMENTS = {
    "point_clouds.py": "points in 3D beside TetGen: time, size, memory (Fig. 3.4)",
    "scaling.py": "growth to a million points (Fig. 3.5)",
    "stability.py": "one point less: what moves (Fig. 4.1)",
    "locations.py": "four point locations, the sweep of k (Fig. 3.2), 4D",
    "intermediate.py": "large triangulations on the way (Figs. 2.2, 2.3)",
    "plcs.py": "points, segments and polygons by SVR (Fig. 3.3)",
    "bounds.py": "edits beside m_f lg(L/s); static and dynamic; memory of the trace",
    "chains.py": "chains of dependence (Fig. 4.8)",
    "latency.py": "a million edits, to the 99.99th percentile",
    "everyday.py": "the everyday commands beside Triangle, TetGen and Gmsh",
    "criteria.py": "the criterion of edges beside the thesis's",
}

TEXT = """\
# Experiments of the thesis, and of this project

Each is a command of its own, in `tests/bench/experiments/`, which writes its table as CSV, its plots as SVG
and its section of this page; `--quick` tries it on small inputs, and `--help` says what it takes. They need
the release build (`deploy/build release`), and TetGen for comparison.

"""

DIFFERENCES = """
What does not match the thesis, and why:

* **Times** are of another machine, 19 years later. SVR is 11 (grids) to 16 times as fast as in 2007.
* **Sizes** of SVR's meshes are within 3 % of the thesis's. The bunny's points are from another sampling.
* **Crowded vertices of the input** split the largest simplex that has the crowding point in its circumscribed
  ball; the thesis splits the largest of all simplices at the vertex. That saves up to a sixth of the vertices.
* **Shells** of the point location grow by 2^(1/4), not by √2: a sixth fewer looks on surfaces.
* **Facets** have no mesh of their own: no Voronoi cell of another vertex may meet them (docs/refinement.md).
* **The dynamic mesher** has no colours: priorities by a hash cut chains of dependence as well, but not those of
  an adversary that chooses coordinates by the hash ("Chains of dependence").
* **The criterion of edges** makes meshes with about half of the vertices of the thesis's criterion.
"""


def cpu() -> str:
    text = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
    model = re.search(r"model name\s*: (.*)", text)
    return f"{model[1] if model else platform.machine()}, {os.cpu_count()} cores, shared"


def main() -> None:
    flags = arguments(__doc__).parse_args()
    compiler = subprocess.run(["c++", "--version"], capture_output=True, encoding="utf-8",
                              check=True).stdout.splitlines()[0]
    machine = (f"Machine of all sections: {cpu()}; {platform.system()} {platform.release()}; "
               f"{compiler}; {datetime.date.today():%B %Y}. Others use it at the same time: trust "
               "ratios of one table, not digits.\n\n")
    table = markdown(["command", "what"],
                     [[f"`{name}`", what] for name, what in EXPERIMENTS.items()])
    if not flags.quick:
        section(flags.page, "about.py", TEXT + machine + table + DIFFERENCES)


if __name__ == "__main__":
    main()
