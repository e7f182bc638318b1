"""What only a server's mesh does: followers, streams, other clients, ends and restarts."""
import asyncio
import concurrent.futures
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import grpc
import numpy as np
import pytest

import dynmesh
from conftest import Daemon
from helpers import mass


def test_meshes_by_name(server):
    mesh = server.mesh("plate", create=dict(box=[[0, 0], [2, 1]], rho=1.5))
    assert mesh.options["rho"] == 1.5 and mesh.options["box"] == ((0, 0), (2, 1))
    assert server.mesh("plate").hash == mesh.hash
    assert "plate" in [m["id"] for m in server.meshes()]
    with pytest.raises(dynmesh.FailedPrecondition, match="rho"):
        server.mesh("plate", create=dict(rho=2))
    with pytest.raises(dynmesh.AlreadyExists) as caught:
        server.create("plate", box=[[0, 0], [1, 1]])
    assert caught.value.reason == "MESH_EXISTS"
    assert server.stats("plate")["mesh"]["revision"] == 0
    server.delete("plate")
    with pytest.raises(dynmesh.NotFound):
        server.mesh("plate")
    with pytest.raises(dynmesh.NotFound):
        mesh.apply(add_points={1: (0.5, 0.5)})


def test_a_name_that_the_server_chose(server):
    mesh = server.create(box=[[0, 0], [1, 1]])
    assert mesh.name and server.mesh(mesh.name).hash == mesh.hash
    assert dynmesh.open().name == ""
    server.delete(mesh.name)


def test_examples_leave_no_mesh_at_a_server(daemon, server, tmp_path):
    before = [mesh["id"] for mesh in server.meshes()]
    script = pathlib.Path(__file__).parents[3] / "examples" / "heat_crack.py"
    subprocess.run([sys.executable, "-B", script, "--edge", "0.1", "--steps", "2",
                    "--out", tmp_path, "--server", daemon.address], check=True, timeout=300)
    assert [mesh["id"] for mesh in server.meshes()] == before


def test_others_edits_are_in_the_diff(server, random):
    mine = server.create(box=[[0, 0], [1, 1]])
    mine.apply(add_points=(np.arange(1, 31), random.random((30, 2))))
    name = mine.name
    theirs = server.mesh(name)
    u = np.sin(mine.points[:, 0])
    begin = mass(mine, u, "P1")
    for i in range(5):
        theirs.apply(add_points={100 + i: random.random(2)})
    diff = mine.apply(remove=[1])
    assert diff.to_revision - diff.from_revision == 6
    assert mine.hash == server.mesh(name).hash
    u = diff.transfer(u)
    assert abs(mass(mine, u, "P1")[0] - begin[0]) < 1e-13 * begin[1]
    theirs.apply(remove=[2])
    diff = mine.sync()
    assert (mine.revision, mine.hash) == (theirs.revision, server.mesh(name).hash)
    assert mine.sync().from_revision == mine.revision


def test_follow(server, random):
    mesh = server.create(box=[[0, 0], [1, 1]])
    writer = server.mesh(mesh.name)

    def write():
        for i in range(20):
            writer.apply(add_points={1 + i: random.random(2)})

    thread = threading.Thread(target=write)
    thread.start()
    u = mesh.points[:, 0].copy()
    revisions = []
    for diff in mesh.follow(since=0, timeout=5):
        u = diff.transfer(u)
        revisions.append(diff.to_revision)
        assert mesh.revision == diff.to_revision
        if diff.to_revision == 20:
            break
    thread.join(60)
    assert not thread.is_alive(), "the writer does not end"
    assert revisions == list(range(1, 21)) and mesh.hash == writer.hash
    assert np.abs(u - mesh.points[:, 0])[mesh.live_vertices].max() < 1e-12
    assert list(mesh.follow(timeout=0.2)) == []

    async def read():
        writer.apply(remove=[1])
        async for diff in mesh.follow_async(timeout=5):
            return diff.to_revision

    assert asyncio.run(read()) == 21


def test_stream(server, random):
    mesh = server.create(box=[[0, 0], [1, 1]])
    mesh.fields.add("x", mesh.points[:, 0])
    batches = ({"add_points": {i: random.random(2)}} for i in range(1, 301))
    assert [d.to_revision for d in mesh.stream(batches)] == list(range(1, 301))
    assert np.abs(mesh.fields["x"] - mesh.points[:, 0])[mesh.live_vertices].max() < 1e-11
    assert mesh.hash == server.mesh(mesh.name).hash
    with pytest.raises(dynmesh.DynmeshError, match="ID_IN_USE"):
        for _ in mesh.stream([{"add_points": {1: (0.5, 0.5)}}, {"remove": [2]}]):
            pass
    mesh.sync()
    assert mesh.hash == server.mesh(mesh.name).hash


def test_load_and_revert(server, random):
    mesh = server.create(box=[[0, 0], [1, 1]])
    told = []
    mesh.load(add_points=(np.arange(1, 3001), random.random((3000, 2))),
              progress=lambda *p: told.append(p))
    assert mesh.revision == 1 and mesh.hash == server.mesh(mesh.name).hash
    first = mesh.hash
    mesh.apply(remove=np.arange(1, 100))
    mesh.revert(1)
    assert mesh.revision == 3 and mesh.hash == first
    assert len(mesh.features(revision=2)) == 2901
    assert all(stage in ("send", "wait", "validate", "refine", "diff", "write")
               for stage, _, _ in told)


def test_request_ids_and_revisions(server):
    mesh = server.create(box=[[0, 0], [1, 1]])
    mesh.apply(request_id="once", add_points={1: (0.5, 0.5)})
    again = server.mesh(mesh.name)
    assert again.apply(request_id="once", add_points={1: (0.5, 0.5)}).to_revision == 1
    assert again.revision == 1
    with pytest.raises(dynmesh.FailedPrecondition) as caught:
        mesh.apply(expected_revision=7, remove=[1])
    assert caught.value.reason == "REVISION_MISMATCH"


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_server_that_comes_back(tmp_path, random, how):
    daemon = Daemon(tmp_path)
    daemon.start()
    with dynmesh.connect(daemon.address) as server:
        mesh = server.mesh("m", create=dict(box=[[0, 0], [1, 1]]))
        follower = server.mesh("m")
        mesh.fields.add("x", mesh.points[:, 0])
        follow = follower.follow(timeout=20)
        for i in range(10):
            mesh.apply(add_points={1 + i: random.random(2)})
            next(follow)
        daemon.stop(how)
        later = threading.Thread(target=lambda: (time.sleep(0.5), daemon.start()))
        later.start()
        mesh.apply(add_points={100: (0.5, 0.25)})  # waits for the server
        later.join(60)
        assert not later.is_alive(), "the server does not start"
        next(follow)
        assert mesh.revision == follower.revision == 11
        assert mesh.hash == follower.hash == server.mesh("m").hash
        assert np.abs(mesh.fields["x"] - mesh.points[:, 0])[mesh.live_vertices].max() < 1e-12
        follow.close()
    daemon.stop()


def test_another_mesh_of_the_same_name(server, random):
    mesh = server.mesh("twice", create=dict(box=[[0, 0], [1, 1]]))
    mesh.apply(add_points=(np.arange(1, 31), random.random((30, 2))))
    server.delete("twice")
    other = server.mesh("twice", create=dict(box=[[0, 0], [1, 1]]))
    for i in range(3):
        other.apply(add_points={i + 1: random.random(2)})
    mesh.sync()
    assert mesh.hash == other.hash and mesh.revision == other.revision


def test_no_server():
    begin = time.monotonic()
    with dynmesh.connect("127.0.0.1:1", retry_for=0.3) as server:
        with pytest.raises(dynmesh.Unavailable):
            server.meshes()
    assert time.monotonic() - begin < 10
    with pytest.raises(dynmesh.Unavailable, match="closed"):
        server.meshes()


def test_a_call_that_waits_says_so(caplog):
    # Far longer than the time until the note: one try takes long on a busy machine.
    with dynmesh.connect("127.0.0.1:1", retry_for=6) as server:
        with pytest.raises(dynmesh.Unavailable):
            server.meshes()
    told = [r for r in caplog.records if r.name == "dynmesh"]
    assert len(told) == 1 and told[0].levelname == "WARNING"
    assert "127.0.0.1:1" in told[0].getMessage() and "retry_for" in told[0].getMessage()


class OtherServer(grpc.GenericRpcHandler):
    """Tells a version, and knows no other call."""

    def __init__(self, version):
        self.version = version.encode()

    def service(self, details):
        if not details.method.endswith("/GetStats"):
            return None
        return grpc.unary_unary_rpc_method_handler(
            lambda request, context: b"\x0a" + bytes([len(self.version)]) + self.version)


@pytest.fixture
def start_other_server():
    servers = []

    def start(version):
        servers.append(grpc.server(concurrent.futures.ThreadPoolExecutor(2)))
        servers[-1].add_generic_rpc_handlers([OtherServer(version)])
        port = servers[-1].add_insecure_port("127.0.0.1:0")
        servers[-1].start()
        return f"127.0.0.1:{port}"
    yield start
    for server in servers:
        assert server.stop(None).wait(60), "a server does not end"


def test_a_server_of_another_version_is_refused_by_name(start_other_server):
    address = start_other_server("9.3.1")
    with dynmesh.connect(address) as server:
        for _ in range(2):  # the second time, too
            with pytest.raises(dynmesh.VersionMismatch) as caught:
                server.mesh("plate")
            for part in ("9.3.1", dynmesh.__version__, address, "any_version=True"):
                assert part in str(caught.value)
    with dynmesh.connect(address, any_version=True) as server:
        with pytest.raises(dynmesh.DynmeshError) as caught:
            server.mesh("plate")
        assert caught.value.code == "UNIMPLEMENTED"
        assert server.stats()["version"] == "9.3.1"


def test_the_last_number_of_a_version_may_differ(start_other_server):
    numbers = dynmesh.__version__.split(".")
    with dynmesh.connect(start_other_server(".".join([*numbers[:2], "99"]))) as server:
        assert server.stats()["version"].endswith(".99")


GOES_ON = """
import sys, dynmesh
with dynmesh.connect(sys.argv[1], retry_for=60) as server:
    mesh = server.create(box=[[0, 0], [1, 1]])
    print("made", flush=True)
    sys.stdin.readline()  # the server is gone
    for _ in range(3):
        try:
            server._client.get(mesh.name)
            sys.exit("there is a server")
        except dynmesh.errors.Unavailable:
            pass
    print("down", flush=True)
    mesh.apply(add_points={1: (0.5, 0.5)})
    print(mesh.revision, flush=True)
"""


def test_a_call_goes_on_after_a_restart(tmp_path):
    """Without gRPC's own look at connections, every five seconds."""
    daemon = Daemon(tmp_path)
    daemon.start()
    child = subprocess.Popen(
        [sys.executable, "-B", "-c", GOES_ON, daemon.address], text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        env={**os.environ, "GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS": "0"})
    try:
        assert child.stdout.readline() == "made\n"
        daemon.stop(signal.SIGKILL)
        child.stdin.write("\n")
        child.stdin.flush()
        assert child.stdout.readline() == "down\n"
        daemon.start()
        assert child.stdout.readline() == "1\n"
        assert child.wait(60) == 0
    finally:
        child.kill()
        child.communicate()
        daemon.stop()
