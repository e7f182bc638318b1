#!/usr/bin/python3
"""What the opening of a mesh costs its server, by features: a constant of scale.py.

    tests/bench/experiments/openings.py [--quick]

Loads uniform points in 2D into meshes of a dynmeshd with a folder, starts it again, and takes its
processor time when all are there, less that of a start without meshes.
"""
from __future__ import annotations

import os
import pathlib
import subprocess
import tempfile
import time

import numpy as np

import inputs
from output import arguments, write_csv

PATIENCE = 600  # seconds
CASES = {100: 300, 1_000: 100, 10_000: 10, 100_000: 2, 1_000_000: 1}  # features: meshes


class Server:
    def __init__(self, programs: pathlib.Path, folder: pathlib.Path) -> None:
        self.log = folder / "log"
        port = folder / "port"
        port.unlink(missing_ok=True)
        with self.log.open("w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [programs / "dynmeshd", "--listen", "127.0.0.1:0", "--port-file", port,
                 "--data-dir", folder / "data"], stderr=log, stdout=subprocess.DEVNULL)
        end = time.monotonic() + PATIENCE
        while "event=journal_open" not in self.log.read_text(encoding="utf-8"):
            if self.process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(self.log.read_text(encoding="utf-8"))
            time.sleep(0.01)
        self.address = f"127.0.0.1:{port.read_text().strip()}"

    def seconds(self) -> float:
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self) -> None:
        self.process.terminate()
        self.process.wait(PATIENCE)


def measure(programs: pathlib.Path, features: int, meshes: int) -> tuple[float, float]:
    """Processor seconds of a start, and bytes of the folder."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        server = Server(programs, folder)
        if meshes:
            inputs.write_node(folder / "p.node", np.random.default_rng(1).random((features, 2)))
        for i in range(meshes):
            for words in (["create", f"m{i}", "--box", "0,0,1,1"], ["load", f"m{i}", folder / "p.node"]):
                subprocess.run([programs / "dynmesh", *words, "--server", server.address], check=True,
                               stdout=subprocess.DEVNULL, timeout=PATIENCE)
        server.end()
        server = Server(programs, folder)
        seconds = server.seconds()
        server.end()
        return seconds, sum(file.stat().st_size for file in (folder / "data").iterdir())


def main() -> None:
    flags = arguments(__doc__).parse_args()
    empty, _ = measure(flags.bin, 0, 0)
    rows = []
    for features, meshes in CASES.items():
        if flags.quick and features > 1_000:
            continue
        seconds, size = measure(flags.bin, features, meshes)
        rows.append([features, round(1e3 * (seconds - empty) / meshes, 2), round(size / meshes)])
        print(*rows[-1], sep="  ", flush=True)
    write_csv(flags.out / "openings.csv", ["features", "ms", "bytes"], rows)


if __name__ == "__main__":
    main()
