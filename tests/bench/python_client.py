#!/usr/bin/env python3
"""How fast the Python client is, against a dynmeshd of its own on loopback.

    DYNMESHD=build/release/bin/dynmeshd tests/bench/python_client.py [--edits 100000]
        [--vertices 1000000]

Single edits with replica and one carried field, streamed and one at a time; then a snapshot of a
large mesh into arrays, and what it takes in memory.
"""
from __future__ import annotations

import argparse
import os
import pathlib
import resource
import subprocess
import tempfile
import time

import numpy as np

import dynmesh


def resident() -> int:
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edits", type=int, default=100_000)
    parser.add_argument("--vertices", type=int, default=1_000_000)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        port = pathlib.Path(folder) / "port"
        with subprocess.Popen([os.environ["DYNMESHD"], "--listen", "127.0.0.1:0", "--port-file",
                               port], stderr=subprocess.DEVNULL) as daemon:
            try:
                while not port.exists() or not port.read_text():
                    time.sleep(0.05)
                run(f"127.0.0.1:{port.read_text().strip()}", arguments)
            finally:
                daemon.terminate()


def run(address: str, arguments: argparse.Namespace) -> None:
    random = np.random.default_rng(5)
    with dynmesh.connect(address) as server:
        mesh = server.create(box=[[0, 0], [1, 1]])
        mesh.load(add_points=(np.arange(1, 10_001), random.random((10_000, 2))))
        mesh.fields.add("u", np.sin(5 * mesh.points[:, 0]))
        places = random.random((arguments.edits, 2))
        ids = random.integers(1, 10_001, arguments.edits)
        start = time.perf_counter()
        for _ in mesh.stream({"move_points": {int(i): p}} for i, p in zip(ids, places)):
            pass
        seconds = time.perf_counter() - start
        print(f"{arguments.edits} moves of points, streamed, with replica and one P1 field: "
              f"{arguments.edits / seconds:.0f} a second")
        start = time.perf_counter()
        for i, p in zip(ids[:2000], random.random((2000, 2))):
            mesh.apply(move_points={int(i): p})
        print(f"one at a time: {2000 / (time.perf_counter() - start):.0f} a second")
        assert mesh.hash == server.mesh(mesh.name).hash

        large = server.create("large", box=[[0, 0], [1, 1]])
        count = int(arguments.vertices / 1.55)
        large.load(add_points=(np.arange(1, count + 1), random.random((count, 2))))
        del large, mesh
        before = resident()
        start = time.perf_counter()
        large = server.mesh("large")
        seconds = time.perf_counter() - start
        grown = resident() - before  # without the copies that reading arrays makes
        replica = large._replica
        arrays = sum(getattr(replica, name).nbytes for name in (
            "points", "ids", "owners", "containing_dimensions", "cells", "neighbours", "regions"))
        beside = grown - arrays
        print(f"snapshot of {large.vertex_count} vertices into arrays: {seconds:.2f} s; "
              f"{arrays / large.vertex_count:.0f} B a vertex in arrays, "
              f"{beside / large.vertex_count:.0f} B beside them")


if __name__ == "__main__":
    main()
