"""A PostgreSQL primary and two standbys, one of which confirms each commit."""
from __future__ import annotations

import os
import pathlib
import pwd
import shutil
import signal
import subprocess
import time
from typing import Callable, Optional

from network import Box, Network

PROGRAMS = max(pathlib.Path("/usr/lib/postgresql").glob("*/bin"), default=None)
PATIENCE = 60.0  # seconds
NAMES = ("a", "b", "c")
SETTINGS = {
    "max_connections": "200",
    "shared_buffers": "32MB",
    "wal_keep_size": "1GB",
    "listen_addresses": "*",
    "unix_socket_directories": "",
    "log_line_prefix": "%m [%p] ",
}


def wait_until(what: str, holds: Callable[[], object], patience: float = PATIENCE) -> None:
    until = time.monotonic() + patience
    while not holds():
        if time.monotonic() > until:
            raise RuntimeError(f"waited in vain for {what}")
        time.sleep(0.05)


def family_of(pid: int) -> list[int]:
    """The process and all that it has started, as far as they are its children's children."""
    parents: dict[int, int] = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                stat = pathlib.Path(f"/proc/{entry}/stat").read_text(encoding="ascii")
            except OSError:
                continue
            parents[int(entry)] = int(stat.rsplit(")", 1)[1].split()[1])
    family = [pid]
    for member in family:
        family += [child for child, parent in parents.items() if parent == member]
    return family


class Database:
    """One of the three, in a box of its own."""

    def __init__(self, name: str, box: Box, folder: pathlib.Path) -> None:
        self.name = name
        self.address = box.address
        self.more: dict[str, str] = {}  # settings, from the next start on
        self._box = box
        self.folder = folder / f"database-{name}"
        self._process: Optional[subprocess.Popen[bytes]] = None
        self.folder.mkdir(mode=0o700)
        user = pwd.getpwnam("postgres")
        os.chown(self.folder, user.pw_uid, user.pw_gid)

    def _command(self, program: str, *words: object) -> list[str]:
        assert PROGRAMS is not None
        return self._box.command(["setpriv", "--reuid=postgres", "--regid=postgres",
                                  "--clear-groups", PROGRAMS / program, *words])

    def _run(self, program: str, *words: object) -> None:
        with open(self.folder / "log", "ab") as log:
            subprocess.run(self._command(program, *words), check=True, stdout=log, stderr=log,
                           cwd="/", timeout=PATIENCE)

    def make(self) -> None:
        """Makes an empty database."""
        self._run("initdb", "-D", self.folder / "data", "-U", "postgres", "-A", "trust",
                  "-E", "UTF8", "--locale=C", "--no-sync", "--no-instructions")
        with open(self.folder / "data/pg_hba.conf", "a", encoding="ascii") as hba:
            hba.write("host all all 10.77.0.0/16 trust\nhost replication all 10.77.0.0/16 trust\n")

    def copy(self, primary: Database) -> None:
        """Makes it a copy of the primary, which follows it when it starts."""
        shutil.rmtree(self.folder / "data", ignore_errors=True)
        self._run("pg_basebackup", "-D", self.folder / "data", "-h", primary.address,
                  "-U", "postgres", "--no-sync", "-c", "fast")
        (self.folder / "data/standby.signal").touch()

    def start(self, primary: Optional[Database] = None) -> None:
        settings = {**SETTINGS, **self.more}
        if primary is not None:
            settings["primary_conninfo"] = (f"host={primary.address} user=postgres "
                                            f"application_name={self.name}")
        words = [word for key, value in settings.items() for word in ("-c", f"{key}={value}")]
        with open(self.folder / "log", "ab") as log:
            self._process = subprocess.Popen(
                self._command("postgres", "-D", self.folder / "data", *words),
                stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd="/")

    def send(self, how: signal.Signals) -> None:
        """To all its processes."""
        assert self._process is not None
        for pid in family_of(self._process.pid):
            try:
                os.kill(pid, how)
            except ProcessLookupError:
                pass

    def kill(self) -> None:
        """As a machine that is lost: no process has the time to say a word."""
        assert self._process is not None
        family = family_of(self._process.pid)
        for how in (signal.SIGSTOP, signal.SIGKILL):
            for pid in family:
                try:
                    os.kill(pid, how)
                except ProcessLookupError:
                    pass
        self._process.wait(PATIENCE)

    def has_ended(self) -> bool:
        assert self._process is not None
        return self._process.poll() is not None

    def log_size(self) -> int:
        return (self.folder / "log").stat().st_size

    def count(self, text: str, since: int) -> int:
        """How often the log has the text, after the first `since` bytes."""
        with open(self.folder / "log", "rb") as log:
            log.seek(since)
            return log.read().count(text.encode())

    def stop(self) -> None:
        assert self._process is not None
        self._process.send_signal(signal.SIGINT)
        self._process.wait(PATIENCE)

    def sql(self, statement: str) -> str:
        """Its answer; an error raises."""
        assert PROGRAMS is not None
        done = subprocess.run(
            [PROGRAMS / "psql", "-XAtq", "-v", "ON_ERROR_STOP=1", "-h", self.address,
             "-U", "postgres", "-c", statement],
            capture_output=True, text=True, timeout=PATIENCE, env={"PGCONNECT_TIMEOUT": "5"})
        if done.returncode != 0:
            raise RuntimeError(f"{statement}: {done.stderr.strip()}")
        return done.stdout.strip()

    def answers(self) -> bool:
        try:
            return self.sql("SELECT 1") == "1"
        except RuntimeError:
            return False


class Databases:
    """All three. The primary changes with each promotion."""

    def __init__(self, network: Network, folder: pathlib.Path) -> None:
        self.all = [Database(name, network.box(), folder) for name in NAMES]
        self.primary = self.all[0]
        self.primary.make()
        self.primary.start()
        wait_until("the primary", self.primary.answers)
        # All are named, so that the list is right after a promotion. It is copied, and in force
        # when there are standbys.
        self.primary.sql(
            f"ALTER SYSTEM SET synchronous_standby_names = 'ANY 1 ({', '.join(NAMES)})'")
        for standby in self.standbys:
            standby.copy(self.primary)
            standby.start(self.primary)
            wait_until("a standby", standby.answers)
        self.primary.sql("SELECT pg_reload_conf()")
        self.wait_for_standbys()

    @property
    def standbys(self) -> list[Database]:
        return [database for database in self.all if database is not self.primary]

    @property
    def addresses(self) -> list[str]:
        return [database.address for database in self.all]

    @property
    def url(self) -> str:
        hosts = ",".join(f"{address}:5432" for address in self.addresses)
        return f"postgresql://postgres@{hosts}/postgres"

    def sql(self, statement: str) -> str:
        return self.primary.sql(statement)

    def wait_for_standbys(self) -> None:
        wait_until("both standbys", lambda: self.sql(
            "SELECT count(*) FROM pg_stat_replication WHERE state = 'streaming' AND sync_state = "
            "'quorum'") == "2")

    def promote(self) -> Database:
        """Makes the standby that is ahead the primary, and the other one follow it.

        Returns the former primary, which must not run, and which is to be given to `rejoin`.
        """
        received = "SELECT pg_last_wal_receive_lsn() - '0/0'"
        former = self.primary
        new, other = sorted(self.standbys, key=lambda standby: -int(standby.sql(received)))
        if new.sql("SELECT pg_promote()") != "t":
            raise RuntimeError(f"{new.name} is not promoted")
        self.primary = new
        other.stop()
        other.start(new)
        return former

    def rejoin(self, former: Database) -> None:
        """A copy of the primary takes the place of the former one."""
        former.copy(self.primary)
        former.start(self.primary)
        self.wait_for_standbys()
