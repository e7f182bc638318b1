#!/usr/bin/python3
"""What an edit costs beside its bound, m_f lg(L/s), by kind of feature and size of the mesh.

    tests/bench/experiments/bounds.py [--quick] [--most N]

Runs dynmesh_kind_tables: Delaunay meshes and quadtrees of up to N features (100,000; in 3D a tenth).
"""
from __future__ import annotations

import programs
from output import arguments, markdown, section, write_csv

TEXT = """\
# Edits beside their bound

`tests/bench/experiments/bounds.py` writes this section. By the thesis (Theorem 6.4.1) an edit of a feature
that carries m_f vertices costs O(m_f lg(L/s)), however many features there are. Of a Delaunay mesh m_f is
the number of vertices on the feature, L the domain's side, s the shortest edge; of a quadtree, the number of
leaves that meet it, the root's side, the finest leaf's. A feature without users is removed and added again;
means of 200 such edits. `bound` is operations over m_f lg(L/s), the mean and the worst edit; `changed` is
vertices (leaves) that come and go. The bound holds where the columns `bound` are level in n. Not among these
scenes, and above the bound: target lengths along some walls, points on a border of large cells of the vertex
tree, points with many nearest neighbours (docs/engine.md, "Some edits cost more than the bound").
"""

COSTS = """\
## Static and dynamic

The same runs. "static" is a mesh from scratch without a trace, "dynamic" one with it, in milliseconds of
processor time; `edit` is the median of an edit, in microseconds; bytes are per vertex.
"""


def number(text: str) -> str:
    value = float(text)
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--most", type=int, default=100_000)
    flags = parser.parse_args()
    head, rows = programs.table(flags.bin / "dynmesh_kind_tables",
                                1_000 if flags.quick else flags.most)
    write_csv(flags.out / "bounds.csv", head, rows)
    bounds, costs = [], []
    for row in (dict(zip(head, cells)) for cells in rows):
        label = [row["scene"], number(row["features"]), row["kind"]]
        bounds.append([*label, *(number(row[key]) for key in (
            "operations", "changed", "carried", "spread")), row["operations_bound"],
            row["worst_bound"], row["changed_bound"]])
        costs.append([*label, *(number(row[key]) for key in (
            "vertices", "build_ms", "load_ms", "edit_us", "trace_bytes", "bytes"))])
    if not flags.quick:
        section(flags.page, "bounds.py", TEXT + "\n" + markdown(
            ["edited", "features", "kind", "operations", "changed", "m_f", "lg(L/s)", "bound: mean",
             "worst", "changed / bound"], bounds) + "\n" + COSTS + "\n" + markdown(
            ["edited", "features", "kind", "vertices", "static, ms", "dynamic, ms", "edit, us",
             "trace, bytes", "all, bytes"], costs))


if __name__ == "__main__":
    main()
