"""Runs the table programs of tests/bench, which print CSV."""
from __future__ import annotations

import csv
import pathlib
import subprocess


def table(program: pathlib.Path, *arguments: object) -> list[dict[str, str]]:
    """The rows that the program prints, by column; what it prints is shown meanwhile."""
    command = [str(program), *map(str, arguments)]
    lines = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, encoding="utf-8") as process:
        for line in process.stdout:
            print(line, end="", flush=True)
            lines.append(line)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: failed")
    return list(csv.DictReader(lines))
