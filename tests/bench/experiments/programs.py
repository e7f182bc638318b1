"""Runs the table programs of tests/bench, which print CSV."""
from __future__ import annotations

import csv
import pathlib
import subprocess


def table(program: pathlib.Path, *arguments: object) -> tuple[list[str], list[list[str]]]:
    """The head and the rows that the program prints; they are shown meanwhile."""
    command = [str(program), *map(str, arguments)]
    lines = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, encoding="utf-8") as process:
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: failed")
    head, *rows = csv.reader(lines)
    return head, rows
