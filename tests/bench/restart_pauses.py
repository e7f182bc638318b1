#!/usr/bin/python3
"""How long clients rest after their server's restart.

    tests/bench/restart_pauses.py [--outages 0.5,1,2,4] [--calls 100] [--build DIR]

A dynmeshd with a journal is killed and started again at the same address. Told are, for each outage,
the seconds from the moment that the server serves to the first success after it: of one caller and of
many at once in Python, each with a mesh's edits; of a follower in Python; of `dynmesh watch`; and of
`dynmesh apply --request-prefix`. The bar: a second, or half of the outage, if that is longer. Build
dynmeshd, dynmesh_cli and dynmesh_python first.
"""
from __future__ import annotations

import argparse
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
from typing import Any, Callable

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Daemon:
    """A server that is killed and comes back."""

    def __init__(self, program: pathlib.Path, folder: pathlib.Path) -> None:
        self._command = [str(program), "--data-dir", str(folder / "data")]
        self._listen = "127.0.0.1:0"
        self._folder = folder
        self.start()

    def start(self) -> None:
        """Returns when it serves."""
        log = self._folder / "log"
        served = log.read_text().count("event=serving ") if log.exists() else 0
        with open(log, "ab") as out:
            self._process = subprocess.Popen([*self._command, "--listen", self._listen,
                                              "--port-file", str(self._folder / "port")],
                                             stdout=out, stderr=out)
        while log.read_text().count("event=serving ") == served:
            if self._process.poll() is not None:
                raise RuntimeError(log.read_text())
            time.sleep(0.002)
        self._listen = self.address = f"127.0.0.1:{(self._folder / 'port').read_text().strip()}"

    def kill(self) -> None:
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()


class Successes:
    """Moments at which a client got on. The clients of one kind share it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: dict[Any, float] = {}
        self._first_after: dict[Any, float] = {}
        self._since = float("inf")

    def add(self, client: Any) -> None:
        now = time.monotonic()
        with self._lock:
            self._last[client] = now
            if now > self._since:
                self._first_after.setdefault(client, now)

    def begin(self, moment: float) -> None:
        """From now on the first success after that moment counts, which has just been."""
        with self._lock:
            self._since = moment
            self._first_after = {client: at for client, at in self._last.items() if at > moment}

    def pauses(self, count: int, limit: float) -> list[float]:
        """The seconds from the moment to the first success of each."""
        until = self._since + limit
        while time.monotonic() < until:
            with self._lock:
                if len(self._first_after) >= count:
                    break
            time.sleep(0.005)
        with self._lock:
            found = [at - self._since for at in self._first_after.values()]
        return found + [limit] * (count - len(found))


class Clients:
    """All clients of one server, until the script ends."""

    def __init__(self, dynmesh: Any, address: str, program: pathlib.Path, calls: int) -> None:
        self.kinds = {"1 call": (Successes(), 1), f"{calls} calls": (Successes(), calls),
                      "follow": (Successes(), 1), "dynmesh watch": (Successes(), 1),
                      "dynmesh apply": (Successes(), 1)}
        names = list(self.kinds)
        self._dynmesh, self._address, self._program = dynmesh, address, program
        for name in ("one", "many", "script"):
            dynmesh.connect(address).create(name, box=[[0, 0], [1, 1]])
        alone, together = dynmesh.connect(address), dynmesh.connect(address)
        self._thread(self._edit, alone, "one", 1, self.kinds[names[0]][0])
        for number in range(calls):
            self._thread(self._edit, together, "many", number + 1, self.kinds[names[1]][0])
        self._thread(self._follow, self.kinds["follow"][0])
        self._thread(self._command, ["watch", "one", "--json"], self.kinds["dynmesh watch"][0])
        self._thread(self._apply, self.kinds["dynmesh apply"][0])

    def _thread(self, run: Callable[..., None], *arguments: Any) -> None:
        threading.Thread(target=run, args=arguments, daemon=True).start()

    def _edit(self, server: Any, name: str, number: int, successes: Successes) -> None:
        """Moves a point of its own by next to nothing, again and again."""
        batch = self._dynmesh._batch
        x = 0.005 + 0.0099 * number
        added = batch.make(2, {"add_points": {number: (x, x)}})
        server.call(lambda c: c.apply(name, added, f"{name}-{number}", None, False))
        for k in range(10**9):
            move = batch.make(2, {"move_points": {number: (x, x + 1e-6 * (k % 100))}})
            server.call(lambda c: c.apply(name, move, f"{name}-{number}-{k}", None, False))
            successes.add(number)
            time.sleep(0.02 if number == 1 else 0.2)

    def _follow(self, successes: Successes) -> None:
        for _ in self._dynmesh.connect(self._address).mesh("one").follow():
            successes.add(0)

    def _command(self, arguments: list[str], successes: Successes) -> None:
        command = [str(self._program), *arguments, "--server", self._address]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as run:
            assert run.stdout is not None
            for _ in run.stdout:
                successes.add(0)

    def _apply(self, successes: Successes) -> None:
        with tempfile.NamedTemporaryFile("w", suffix=".dynmesh") as script:
            script.write("add point 1 0.5 0.5\ncommit\n")
            for k in range(200_000):
                script.write(f"move point 1 0.5 {0.5 + 1e-6 * (k % 100):.6f}\ncommit\n")
            script.flush()
            self._command(["apply", "script", script.name, "--request-prefix", "s",
                           "--one-by-one"], successes)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--outages", default="0.5,1,2,4", help="seconds, with commas between")
    parser.add_argument("--calls", type=int, default=100, help="at once; default: %(default)s")
    parser.add_argument("--limit", type=float, default=30, help="for a success, in seconds")
    parser.add_argument("--build", default=ROOT / "build/release", type=pathlib.Path)
    return parser.parse_args()


def main() -> int:
    arguments = parse()
    sys.path.insert(0, str(arguments.build / "python"))
    import dynmesh
    import dynmesh._batch
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        daemon = Daemon(arguments.build / "bin/dynmeshd", pathlib.Path(folder))
        clients = Clients(dynmesh, daemon.address, arguments.build / "bin/dynmesh",
                          arguments.calls)
        for successes, count in clients.kinds.values():
            successes.begin(time.monotonic())
            successes.pauses(count, arguments.limit)
        print("outage, s | " + " | ".join(clients.kinds) + " | bar")
        for outage in map(float, arguments.outages.split(",")):
            daemon.kill()
            killed = time.monotonic()
            time.sleep(outage)
            daemon.start()
            serves = time.monotonic()
            for successes, _ in clients.kinds.values():
                successes.begin(serves)
            pauses = [max(successes.pauses(count, arguments.limit))
                      for successes, count in clients.kinds.values()]
            bar = max(1.0, (serves - killed) / 2)
            worst = max(worst, max(pauses) / bar)
            print(f"{serves - killed:.2f} | " + " | ".join(f"{p:.2f}" for p in pauses)
                  + f" | {bar:.2f}", flush=True)
            time.sleep(1)
        daemon.kill()
    return 0 if worst <= 1 else 1


if __name__ == "__main__":
    result = main()
    sys.stdout.flush()
    os._exit(result)  # threads that wait for the server are not waited for
