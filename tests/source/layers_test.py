"""The layers that ARCHITECTURE.md draws are those of the includes.

A row `folder -> folders` of the figure below the heading "Layers" lists all folders of which the
sources of the first include headers. A name without a slash is of the row's own top folder, or
else of core. A row `folder/*` is for all folders below. The test fails if a source includes a
header of another one, if a listed one is not included, if a folder has no row, if a row lists a
folder of the same or a later row, or if folders include each other in a circle.
"""

import graphlib
import pathlib
import re
import sys

ROW = re.compile(r"^ *(\S+) +->((?: \S+)*)$")
INCLUDE = re.compile(r'^ *# *include [<"]([^">]+)[">]', re.MULTILINE)
ROOTS = ("core", "proto", "server", "client")
# By the prefix of an include that is no path from the root.
PUBLIC = (
    ("dynmesh/v1/", "proto/dynmesh/v1"),
    ("dynmesh/client/", "client/include"),
    ("dynmesh/codec/", "proto/codec/include"),
    ("dynmesh/", "core/include"),
)


def folder_of(path: str) -> str:
    """The folder that a source, or the header of an include from the root, belongs to."""
    for _, public in PUBLIC:
        if path.startswith(public + "/"):
            return public
    return path.rsplit("/", 1)[0]


def folder_of_include(name: str) -> str | None:
    """The project's folder that has the header; None for a library's."""
    if name.startswith(tuple(root + "/" for root in ROOTS)):
        return folder_of(name)
    for prefix, public in PUBLIC:
        if name.startswith(prefix):
            return public
    return None


def documented(text: str) -> dict[str, list[str]]:
    """The rows of the figure, from the lowest layer up, by folder or `folder/*`."""
    figure = text.split("## Layers", 1)[1].split("```")[1]
    rows = [match for line in figure.splitlines() if (match := ROW.match(line))]
    folders = {row[1].removesuffix("/*") for row in rows}
    return {
        row[1]: [whole(name, row[1], folders) for name in row[2].split()] for row in reversed(rows)
    }


def whole(name: str, row: str, folders: set[str]) -> str:
    """The folder that the row means by a name."""
    own = f"{row.split('/', 1)[0]}/{name}"
    return name if "/" in name else own if own in folders else f"core/{name}"


def included(root: pathlib.Path) -> dict[str, set[str]]:
    """Of each folder with sources, those of which it includes headers."""
    edges: dict[str, set[str]] = {}
    for top in ROOTS:
        for path in sorted((root / top).rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            folder = folder_of(str(path.relative_to(root)))
            mine = edges.setdefault(folder, set())
            for name in INCLUDE.findall(path.read_text(encoding="utf-8")):
                other = folder_of_include(name)
                if other is not None and other != folder:
                    mine.add(other)
    return edges


def boxed(edges: dict[str, set[str]], rows: dict[str, list[str]]) -> dict[str, set[str]]:
    """The edges between rows: those of all folders that a row `folder/*` is for are its own."""
    tops = [row.removesuffix("/*") for row in rows if row.endswith("/*")]

    def box(folder: str) -> str:
        return next((top for top in tops if folder.startswith(top + "/")), folder)

    merged: dict[str, set[str]] = {}
    for folder, others in edges.items():
        merged.setdefault(box(folder), set()).update({box(o) for o in others} - {box(folder)})
    return merged


def circles(edges: dict[str, set[str]]) -> list[str]:
    """A circle of folders, if there is one."""
    try:
        graphlib.TopologicalSorter(edges).prepare()
    except graphlib.CycleError as error:
        return ["a circle: " + " ".join(error.args[1])]
    return []


def problems(rows: dict[str, list[str]], edges: dict[str, set[str]]) -> list[str]:
    """What the figure and the includes disagree on, one line each."""
    found = []
    for folder, others in edges.items():
        if folder not in rows:
            found.append(f"{folder} has no row")
            continue
        drawn = set(rows[folder])
        found += [f"{folder} includes {o}, against the figure" for o in sorted(others - drawn)]
        found += [f"{folder} does not include {o} any more" for o in sorted(drawn - others)]
    below = {"proto/dynmesh/v1"}  # generated
    for folder, others in rows.items():
        if folder not in edges:
            found.append(f"{folder} is drawn and has no sources")
        found += [f"{folder} is drawn below {o}" for o in others if o not in below]
        below.add(folder)
    return found


def check_the_check() -> None:
    """A broken figure is noticed."""
    edges = {"a": set(), "b": {"a"}}
    assert not problems({"a": [], "b": ["a"]}, edges)
    assert problems({"a": [], "b": []}, edges) == ["b includes a, against the figure"]
    assert problems({"b": ["a"], "a": []}, edges) == ["b is drawn below a"]
    assert problems({"a": []}, edges) == ["b has no row"]
    stale = problems({"a": [], "b": ["a"]}, {"a": set(), "b": set()})
    assert stale == ["b does not include a any more"]
    deep = {"a/x": {"a/y"}, "a/y": {"b"}, "b": set()}
    assert boxed(deep, {"b": [], "a/*": ["b"]}) == {"a": {"b"}, "b": set()}
    assert not circles(deep)
    assert circles(deep | {"b": {"a/x"}})


def main() -> int:
    """The number of problems, as an exit code."""
    root = pathlib.Path(sys.argv[1])
    check_the_check()
    rows = documented((root / "ARCHITECTURE.md").read_text(encoding="utf-8"))
    edges = included(root)
    found = circles(edges)
    drawn = {row.removesuffix("/*"): others for row, others in rows.items()}
    found += problems(drawn, boxed(edges, rows))
    print("\n".join(found) or f"{len(rows)} folders are as ARCHITECTURE.md draws them")
    return min(len(found), 1)


if __name__ == "__main__":
    sys.exit(main())
