"""Runs a program in namespaces of its own, so that nothing of it is left behind."""
from __future__ import annotations

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import types
from typing import Iterable, Optional


def lacking(programs: Iterable[pathlib.Path]) -> Optional[str]:
    """Why a cluster of the programs cannot run here."""
    if os.geteuid() != 0:
        return "it needs root, for networks of its own"
    for program in ("ip", "unshare", "nsenter", "setpriv", "mount"):
        if shutil.which(program) is None:
            return f"there is no {program} (Debian: iproute2, util-linux, mount)"
    if not list(pathlib.Path("/usr/lib/postgresql").glob("*/bin/initdb")):
        return "there is no PostgreSQL (Debian: postgresql)"
    for path in programs:
        if not path.exists():
            return f"there is no {path}: build it, or set DYNMESH_BUILD"
    return None


def in_namespaces(words: list[str], limit: float) -> int:
    """Runs `words` by this Python, with `--folder` and an empty folder that is removed at the end.

    The program is process 1 of namespaces of mounts, networks and processes: if it ends, or this
    process does, all that it has started ends. Returns its exit code, 124 after `limit` seconds.
    """
    def end(number: int, _: Optional[types.FrameType]) -> None:
        raise SystemExit(128 + number)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, end)
    folder = tempfile.mkdtemp(prefix="dynmesh-cluster-", dir="/tmp")
    # If this process ends, unshare does, and with it all in its namespaces.
    inner = subprocess.Popen(
        ["setpriv", "--pdeathsig", "KILL", "unshare", "--mount", "--net", "--pid", "--fork",
         "--kill-child", "--mount-proc", sys.executable, *words, "--folder", folder],
        start_new_session=True)
    try:
        return inner.wait(limit)
    except subprocess.TimeoutExpired:
        print("the time is over", file=sys.stderr)
        return 124
    finally:
        inner.kill()
        inner.wait()
        shutil.rmtree(folder, ignore_errors=True)
