"""Boxes with a network of their own, and a router between them that can lose packets.

A box is a network namespace without a name. It goes when its processes end, so nothing is left
behind. The program itself is in a box, too: that of the clients.
"""
from __future__ import annotations

import os
import subprocess
import time
from typing import Iterable

Pair = tuple[str, str]  # addresses: from, to


def run(words: list[str], text: str = "") -> None:
    done = subprocess.run(words, input=text, capture_output=True, text=True, timeout=30)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip()}\n{text}")


class Box:
    """A network namespace, and its address behind the router."""

    def __init__(self, address: str) -> None:
        self.address = address
        self._holder = subprocess.Popen(["unshare", "--net", "sleep", "infinity"])
        self.pid = self._holder.pid
        until = time.monotonic() + 10
        while os.readlink(f"/proc/{self.pid}/ns/net") == os.readlink("/proc/self/ns/net"):
            if time.monotonic() > until:
                raise RuntimeError("unshare makes no network")
            time.sleep(0.01)

    def command(self, words: Iterable[object]) -> list[str]:
        """The command that runs `words` in the box, with the same process id."""
        return ["nsenter", f"--net=/proc/{self.pid}/ns/net", *map(str, words)]


class Network:
    """The router and its boxes. This process's own box has the address `clients`."""

    clients = "10.77.0.2"

    def __init__(self) -> None:
        self._router = Box("")
        self._boxes = 0
        self._cuts: list[Pair] = []
        run(["ip", "link", "set", "lo", "up"])
        run(self._router.command(["ip", "link", "set", "lo", "up"]))
        run(self._router.command(["sh", "-c", "echo 1 >/proc/sys/net/ipv4/ip_forward"]))
        self._connect(0, os.getpid())
        self._configure(["ip"], 0)

    def box(self) -> Box:
        """A new box."""
        self._boxes += 1
        box = Box(f"10.77.{self._boxes}.2")
        self._connect(self._boxes, box.pid)
        self._configure(box.command(["ip"]), self._boxes)
        return box

    def _connect(self, number: int, pid: int) -> None:
        run(self._router.command(["ip", "-batch", "-"]), f"""\
link add v{number} type veth peer name eth0 netns {pid}
address add 10.77.{number}.1/24 dev v{number}
link set v{number} up
""")

    @staticmethod
    def _configure(ip: list[str], number: int) -> None:
        run([*ip, "-batch", "-"], f"""\
link set lo up
address add 10.77.{number}.2/24 dev eth0
link set eth0 up
route add default via 10.77.{number}.1
""")

    def _rules(self, action: str, pairs: list[Pair]) -> None:
        lines = [f"rule {action} from {a} to {b} pref 100 blackhole\n" for a, b in pairs]
        run(self._router.command(["ip", "-batch", "-"]), "".join(lines))

    def cut(self, pairs: list[Pair]) -> None:
        """Loses all packets from the first to the second address of each pair, without a word."""
        self._rules("add", pairs)
        self._cuts += pairs

    def heal(self) -> None:
        """Loses none any more."""
        cuts, self._cuts = self._cuts, []
        if cuts:
            self._rules("del", cuts)


def both_ways(one: str, others: Iterable[str]) -> list[Pair]:
    """Between `one` and each of the others."""
    return [pair for other in others for pair in ((one, other), (other, one))]
