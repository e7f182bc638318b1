"""Tables as CSV, plots as SVG, sections of RESULTS.md."""
from __future__ import annotations

import argparse
import csv
import pathlib
import sys
from collections.abc import Iterable, Sequence

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from results_page import put_section  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]


def arguments(doc: str) -> argparse.ArgumentParser:
    """The flags of every experiment."""
    parser = argparse.ArgumentParser(description=doc.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="only small inputs; writes no page")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin",
                        help="where dynmesh is")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/experiments",
                        help="where tables and plots go")
    parser.add_argument("--page", type=pathlib.Path, default=ROOT / "RESULTS.md")
    return parser


def write_csv(path: pathlib.Path, head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)
    print(path)


def markdown(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    def line(cells: Sequence[object]) -> str:
        return "| " + " | ".join(str(cell) for cell in cells) + " |"

    return "\n".join([line(head), line(["---"] * len(head)), *map(line, rows)]) + "\n"


def plot(path: pathlib.Path, series: dict[str, tuple[Sequence[float], Sequence[float]]], x: str,
         y: str, logarithmic: bool) -> None:
    """Needs python3-matplotlib; says so without."""
    try:
        import matplotlib
    except ImportError:
        print(f"{path}: not drawn, python3-matplotlib is not installed", file=sys.stderr)
        return
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "dynmesh"  # the same bytes for the same figures
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 4.2))
    for name, (xs, ys) in series.items():
        axes.plot(xs, ys, marker="o", markersize=3.5, linewidth=1.2, label=name)
    if logarithmic:
        axes.set_xscale("log")
        axes.set_yscale("log")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(True, which="both", linewidth=0.3)
    axes.legend(frameon=False)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)
    print(path)


def show(page: pathlib.Path, picture: pathlib.Path) -> None:
    """Copies a picture, if it was drawn, to where the page shows it."""
    if picture.exists():
        target = page.parent / "deploy/pictures" / picture.name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(picture.read_bytes())


def section(page: pathlib.Path, name: str, text: str) -> None:
    put_section(page, f"experiments/{name}", text)
    print(page)
