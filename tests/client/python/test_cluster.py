"""Servers that share their meshes: writes at any of them, reads of a follower, the end of an owner."""
import os
import pathlib
import pwd
import shutil
import subprocess
import tempfile
import time

import numpy as np
import pytest

import dynmesh
from conftest import Daemon

PROGRAMS = max(pathlib.Path("/usr/lib/postgresql").glob("*/bin"), default=None)
PATIENCE = 60  # seconds


@pytest.fixture(scope="module")
def database():
    """A PostgreSQL of its own, on a socket; its connection string."""
    if PROGRAMS is None or not (PROGRAMS / "initdb").exists():
        pytest.skip("no PostgreSQL")
    user = {"user": "postgres", "group": "postgres"} if os.geteuid() == 0 else {}
    folder = pathlib.Path(tempfile.mkdtemp(prefix="dynmesh-pg-", dir="/tmp"))  # a socket's path is short
    if user:
        account = pwd.getpwnam("postgres")
        os.chown(folder, account.pw_uid, account.pw_gid)
    subprocess.run([PROGRAMS / "initdb", "-D", folder / "data", "-U", "postgres", "-A", "trust",
                    "-E", "UTF8", "--locale=C", "--no-sync", "--no-instructions"],
                   check=True, stdout=subprocess.DEVNULL, cwd="/", **user)
    with open(folder / "log", "wb") as log:
        process = subprocess.Popen(
            [PROGRAMS / "postgres", "-D", folder / "data", "-k", folder, "-c", "listen_addresses=",
             "-c", "fsync=off", "-c", "unix_socket_permissions=0777"],
            stdout=log, stderr=log, cwd="/", **user)
    try:
        ready = [PROGRAMS / "pg_isready", "-q", "-h", folder, "-U", "postgres"]
        until = time.monotonic() + PATIENCE
        while subprocess.run(ready).returncode != 0:
            assert process.poll() is None and time.monotonic() < until, (folder / "log").read_text()
            time.sleep(0.05)
        yield f"postgresql:///postgres?host={folder}&user=postgres"
    finally:
        process.kill()
        process.wait(PATIENCE)
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def servers(database, tmp_path):
    daemons = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        daemons.append(Daemon(tmp_path / name, "--node-address", "127.0.0.1", journal=database))
        daemons[-1].start()
    yield daemons
    for daemon in daemons:
        daemon.stop()


def points(random, count, first=1):
    return np.arange(first, first + count), 0.1 + 0.8 * random.random((count, 2))


def test_edits_at_any_server_and_reads_of_a_follower(servers, random):
    owner, other = servers
    with dynmesh.connect(owner.address) as first, \
            dynmesh.connect(f"{other.address},{owner.address}", from_followers=True) as second:
        mesh = first.create(box=[[0, 0], [1, 1]])
        seen = second.mesh(mesh.name)
        follow = seen.follow(timeout=PATIENCE)
        for i in range(10):
            mesh.apply(add_points=points(random, 5, 1 + 5 * i))
            while seen.revision < mesh.revision:
                next(follow)
        assert (seen.revision, seen.hash) == (10, mesh.hash)
        follow.close()
        # The edit goes to the owner, and what follows is not older than it.
        seen.apply(remove=[3])
        assert second.mesh(mesh.name).revision >= 11
        mesh.sync()
        assert mesh.hash == seen.hash


def test_edits_go_on_when_the_owner_ends(servers, random):
    owner, other = servers
    alone = dynmesh.open([[0, 0], [1, 1]])
    with dynmesh.connect(f"{owner.address},{other.address}") as server:
        mesh = server.create(box=[[0, 0], [1, 1]])
        for i in range(20):
            if i == 10:
                owner.stop()
            added = points(random, 5, 1 + 5 * i)
            mesh.apply(add_points=added)
            alone.apply(add_points=added)
        assert (mesh.revision, mesh.hash) == (20, alone.hash)
        assert server.mesh(mesh.name).hash == alone.hash
