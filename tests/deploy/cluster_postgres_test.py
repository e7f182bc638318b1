"""The scripts of deploy/cluster/postgres, run with Debian's PostgreSQL 15: three servers, of which a
primary is confirmed by one of two standbys; the loss of the standbys; the loss of the primary, as
deploy/RUNBOOK.md describes it; and two dynmeshd through all that. The image's entrypoint is a few
lines of this test. Ends with 77 where there is no PostgreSQL 15, or where it is not root.

    cluster_postgres_test.py [DYNMESHD DYNMESH]
"""

import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "deploy/cluster/postgres"
PROGRAMS = pathlib.Path("/usr/lib/postgresql/15/bin")
NAMES = ("database-a", "database-b", "database-c")
PATIENCE = 60  # seconds
# Without these the test is of the database only.
DAEMON, COMMAND = (sys.argv[1:3] + [None, None])[:2]

# What the scripts rely on of the image's: docker-entrypoint.sh of postgres:15.
ENTRYPOINT = """#!/usr/bin/env bash
set -euo pipefail
shift
set -- -c listen_addresses=127.0.0.1 -c "unix_socket_directories=$PGHOST" "$@"
mkdir -p "$PGDATA"
chmod 700 "$PGDATA"
if [[ ! -s $PGDATA/PG_VERSION ]]; then
  initdb -U postgres --auth-host=scram-sha-256 --pwfile=<(echo "$POSTGRES_PASSWORD") --no-sync
  echo "host all all all scram-sha-256" >>"$PGDATA/pg_hba.conf"
  printf -v options '%q ' "$@" -c listen_addresses=
  pg_ctl -w -t 60 -o "$options" -l "$PGHOST/init.log" start
  bash INIT
  pg_ctl -w -m fast stop
fi
exec postgres "$@"
"""


def missing():
    if os.geteuid() != 0:
        return "not root"
    if not (PROGRAMS / "postgres").exists():
        return "no PostgreSQL 15 (Debian: postgresql)"
    if shutil.which("setpriv") is None:
        return "no setpriv"
    return None


def free_port():
    with socket.socket() as any_port:
        any_port.bind(("127.0.0.1", 0))
        return any_port.getsockname()[1]


class Server:
    """One of the three: a folder, a port, and a process while it runs."""

    def __init__(self, folder, name, entry):
        self.name = name
        self.folder = folder / name
        self.entry = entry
        self.port = free_port()
        self.process = None
        self.run = self.folder / "run"
        self.run.mkdir(parents=True)
        user = pwd.getpwnam("postgres")
        for path in (self.folder, self.run):
            os.chown(path, user.pw_uid, user.pw_gid)

    @property
    def data(self):
        return self.folder / "data"

    def environment(self, primary):
        return {
            "PATH": f"{self.entry}:{PROGRAMS}:/usr/bin:/bin",
            "LC_ALL": "C.UTF-8",
            "TMPDIR": str(self.run),
            "NODE_NAME": self.name,
            "NODES": " ".join(NAMES),
            "PRIMARY": primary.name,
            "PRIMARY_ADDRESS": f"host=127.0.0.1 port={primary.port}",
            "PGDATA": str(self.data),
            "PGHOST": str(self.run),
            "PGPORT": str(self.port),
            "POSTGRES_PASSWORD": "adminsecret",
            "DATABASE_PASSWORD": "meshsecret",
            "REPLICATION_PASSWORD": "copysecret",
        }

    def start(self, primary):
        command = ["setpriv", "--reuid=postgres", "--regid=postgres", "--clear-groups"]
        command += ["--pdeathsig", "KILL", "bash", str(self.entry / "start.sh")]
        with (self.folder / "log").open("a", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                command,
                env=self.environment(primary),
                cwd="/",
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def end(self, how):
        if self.process is not None:
            self.process.send_signal(how)
            self.process.wait(PATIENCE)
            self.process = None

    def log(self):
        return (self.folder / "log").read_text()

    def sql(self, statement, user="postgres"):
        """Run by psql: as the administrator over the socket, or as `user` with its password."""
        there = [f"--host={self.run}"] if user == "postgres" else ["--host=127.0.0.1"]
        done = subprocess.run(
            ["psql", "-XAtq", "-v", "ON_ERROR_STOP=1", *there, f"--port={self.port}",
             f"--username={user}", "--dbname=dynmesh", "--command", statement],
            env={"PATH": f"{PROGRAMS}:/usr/bin:/bin", "PGPASSWORD": "meshsecret"},
            capture_output=True, text=True, timeout=PATIENCE, check=False,
        )
        return done.stdout.strip() if done.returncode == 0 else f"error: {done.stderr.strip()}"


class Node:
    """A dynmeshd that shares the meshes of the database."""

    def __init__(self, folder, name, databases):
        hosts = ",".join(f"127.0.0.1:{server.port}" for server in databases)
        self.log_file = folder / f"{name}.log"
        self.port, self.metrics = free_port(), free_port()
        self.address = f"127.0.0.1:{self.port}"
        with self.log_file.open("w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [
                    *(DAEMON, "--listen", self.address, "--node-address", "127.0.0.1"),
                    *("--journal", f"postgresql://dynmesh@{hosts}/dynmesh", "--lease", "2"),
                    *("--metrics", f"127.0.0.1:{self.metrics}"),
                ],
                env={"PATH": "/usr/bin:/bin", "PGPASSWORD": "meshsecret"},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=log,
            )

    def log(self):
        return self.log_file.read_text(encoding="utf-8")

    def metric(self, name):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.metrics}/metrics", timeout=60) as page:
            lines = page.read().decode().splitlines()
        return float(next(line.split()[-1] for line in lines if line.startswith(f"{name} ")))

    def ready(self):
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{self.metrics}/readyz", timeout=60) as page:
                return page.status
        except OSError:
            return 0


class Cluster(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="dynmesh-pg-", dir="/tmp"))
        self.folder.chmod(0o755)
        entry = self.folder / "bin"
        entry.mkdir()
        stub = entry / "docker-entrypoint.sh"
        # The database's user may not read the folder of this clone.
        for script in SCRIPTS.glob("*.sh"):
            shutil.copy(script, entry)
        stub.write_text(ENTRYPOINT.replace("INIT", f"{entry}/init.sh"))
        stub.chmod(0o755)
        self.a, self.b, self.c = self.servers = [Server(self.folder, n, entry) for n in NAMES]

    def tearDown(self):
        for server in self.servers:
            if server.process is not None and server.process.poll() is None:
                os.killpg(server.process.pid, signal.SIGKILL)  # bash would ignore SIGQUIT
                server.process.wait(PATIENCE)
        # PostgreSQL's children end a moment later.
        shutil.rmtree(self.folder, ignore_errors=True)

    def wait_for(self, what, expected, ask):
        end = time.monotonic() + PATIENCE
        while (found := ask()) != expected:
            if time.monotonic() > end:
                files = sorted([*self.folder.glob("*.log"), *self.folder.glob("*/log")])
                logs = "\n".join(f"{file}:\n{file.read_text()[-2000:]}" for file in files)
                self.fail(f"waited in vain for {what}: {found!r}\n{logs}")
            time.sleep(0.05)

    def standbys_of(self, primary):
        return primary.sql(
            "SELECT application_name || ' ' || sync_state FROM pg_stat_replication "
            "WHERE state = 'streaming' ORDER BY 1"
        )

    def promote(self, *standbys):
        """Makes the standby that is ahead the primary; the other follows it. Returns both."""
        received = "SELECT pg_last_wal_receive_lsn() - '0/0'"
        new, other = sorted(standbys, key=lambda server: -int(server.sql(received)))
        self.assertEqual(new.sql("SELECT pg_promote()"), "t")
        other.end(signal.SIGINT)
        other.start(new)
        self.wait_for("a standby", f"{other.name} quorum", lambda: self.standbys_of(new))
        return new, other

    def test_an_edit_is_on_two_machines_and_outlives_the_primary(self):
        a, b, c = self.servers
        for server in self.servers:
            server.start(a)
        both = "database-b quorum\ndatabase-c quorum"
        self.wait_for("two standbys", both, lambda: self.standbys_of(a))
        self.assertEqual(
            a.sql("SHOW synchronous_standby_names"),
            'ANY 1 ("database-a", "database-b", "database-c")',
        )
        # What dynmeshd does, as its user: it makes its schema, and writes.
        self.assertEqual(a.sql("CREATE SCHEMA dynmesh; CREATE TABLE dynmesh.t(n int)", "dynmesh"), "")
        self.assertEqual(a.sql("INSERT INTO dynmesh.t VALUES(1)", "dynmesh"), "")
        self.assertEqual(a.sql("SELECT rolsuper FROM pg_roles WHERE rolname = 'dynmesh'"), "f")
        self.assertIn("read-only", b.sql("INSERT INTO dynmesh.t VALUES(0)", "dynmesh"))

        # Without a standby a commit waits, and goes on with the first one that is back.
        b.end(signal.SIGQUIT)
        c.end(signal.SIGQUIT)
        self.wait_for("no standby", "", lambda: self.standbys_of(a))
        writer = subprocess.Popen(
            ["psql", "-Xq", f"--host={a.run}", f"--port={a.port}", "-U", "postgres", "-d", "dynmesh",
             "-c", "INSERT INTO dynmesh.t VALUES(2)"],
            env={"PATH": f"{PROGRAMS}:/usr/bin:/bin"},
        )
        waiting = "SELECT count(*) FROM pg_stat_activity WHERE wait_event = 'SyncRep'"
        self.wait_for("a commit that waits", "1", lambda: a.sql(waiting))
        self.assertIsNone(writer.poll())
        b.start(a)
        self.assertEqual(writer.wait(PATIENCE), 0)
        c.start(a)
        self.wait_for("two standbys again", both, lambda: self.standbys_of(a))

        # The primary is lost.
        a.end(signal.SIGQUIT)
        new, other = self.promote(b, c)
        self.assertEqual(new.sql("INSERT INTO dynmesh.t VALUES(3)", "dynmesh"), "")
        self.assertEqual(new.sql("SELECT string_agg(n::text, ' ' ORDER BY n) FROM dynmesh.t"), "1 2 3")

        # The former primary does not come back by itself, and then as a standby.
        a.start(new)
        self.assertEqual(a.process.wait(PATIENCE), 1)
        self.assertIn("database-a has been the primary", a.log())
        shutil.rmtree(a.data)
        a.start(new)
        names = "\n".join(f"{name} quorum" for name in sorted((a.name, other.name)))
        self.wait_for("both standbys", names, lambda: self.standbys_of(new))
        # The new one starts again as what it is.
        new.end(signal.SIGINT)
        new.start(new)
        self.wait_for("both standbys again", names, lambda: self.standbys_of(new))
        self.assertEqual(new.sql("SELECT pg_is_in_recovery()"), "f")

    def command(self, nodes, *words, check=True):
        """What `dynmesh` prints, against any of the nodes."""
        where = ",".join(node.address for node in nodes)
        done = subprocess.run([COMMAND, *words, "--server", where], capture_output=True, text=True,
                              timeout=PATIENCE, check=False)
        if check:
            self.assertEqual(done.returncode, 0, done.stderr + "\n".join(n.log() for n in nodes))
        return done.stdout

    def test_servers_go_on_at_the_new_primary(self):
        if DAEMON is None:
            self.skipTest("no dynmeshd was given")
        a, b, c = self.servers
        for server in self.servers:
            server.start(a)
        both = "database-b quorum\ndatabase-c quorum"
        self.wait_for("two standbys", both, lambda: self.standbys_of(a))
        nodes = [Node(self.folder, name, self.servers) for name in ("node-1", "node-2")]
        self.addCleanup(lambda: [node.process.kill() or node.process.wait() for node in nodes])
        for node in nodes:
            self.wait_for("a server", 200, node.ready)
        script = self.folder / "edits.dynmesh"

        def edit(number):
            script.write_text(f"add point {number} 0.{number} 0.5\ncommit\n", encoding="utf-8")
            return ["apply", "m", str(script), "--request-prefix", f"e{number}"]

        self.command(nodes, "create", "m", "--box", "0,0,1,1")
        self.command(nodes, *edit(1))

        # Without a standby edits wait, and renewals, so that reads end: only the metric tells.
        b.end(signal.SIGQUIT)
        c.end(signal.SIGQUIT)
        self.wait_for("no standby", "", lambda: self.standbys_of(a))
        where = ",".join(node.address for node in nodes)
        writer = subprocess.Popen([COMMAND, *edit(2), "--server", where],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(writer.kill)
        late = "dynmesh_lease_age_seconds"
        self.wait_for("leases that end", True, lambda: min(n.metric(late) for n in nodes) > 2)
        self.assertIsNone(writer.poll())
        b.start(a)
        self.assertEqual(writer.wait(PATIENCE), 0, writer.stderr.read())
        writer.stderr.close()
        self.wait_for("leases again", True, lambda: max(n.metric(late) for n in nodes) < 2)
        c.start(a)
        self.wait_for("two standbys again", both, lambda: self.standbys_of(a))

        a.end(signal.SIGQUIT)
        for node in nodes:
            self.wait_for("the log", True, lambda n=node: "event=leases_not_renewed" in n.log())
        new, other = self.promote(b, c)
        for node in nodes:
            self.wait_for("the log", True, lambda n=node: "event=leases_renewed_again" in n.log())
        self.command(nodes, *edit(3))
        features = self.command(nodes, "features", "m")
        for number in (1, 2, 3):
            self.assertIn(f"add point {number} 0.{number} 0.5", features)

    def test_a_copy_that_was_interrupted_is_made_anew(self):
        a, b, _ = self.servers
        a.start(a)
        self.wait_for("the primary", "1", lambda: a.sql("SELECT 1"))
        b.data.mkdir()
        for name in ("PG_VERSION", "backup_label", "half"):
            (b.data / name).write_text("15\n")
        user = pwd.getpwnam("postgres")
        for path in (b.data, *b.data.iterdir()):
            os.chown(path, user.pw_uid, user.pw_gid)
        b.start(a)
        self.wait_for("the standby", "database-b quorum", lambda: self.standbys_of(a))
        self.assertFalse((b.data / "half").exists())


if __name__ == "__main__":
    why = missing()
    if why:
        print(f"skipped: {why}")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
