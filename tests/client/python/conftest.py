"""A dynmeshd of its own, on a free port, for each test module that asks for one."""
import os
import pathlib
import signal
import subprocess
import time

import numpy as np
import pytest

import dynmesh

if os.environ.get("DYNMESH_TEST_CLIENT") == "grpcio":  # that of a wheel
    import dynmesh._grpcio
    import dynmesh._server

    dynmesh._server._client_class = lambda: dynmesh._grpcio.Client


class Daemon:
    """A server that can be ended, killed and started again with its journal."""

    def __init__(self, folder, *arguments, journal=None):
        self.folder = pathlib.Path(folder)
        kept_in = ["--journal", journal] if journal else ["--data-dir", self.folder / "journal"]
        self.arguments = [*kept_in, *arguments]
        self.address = ""
        self._process = None

    def start(self, listen="127.0.0.1:0"):
        port_file = self.folder / "port"
        port_file.unlink(missing_ok=True)
        with open(self.folder / "log", "ab") as log:
            self._process = subprocess.Popen(
                [os.environ["DYNMESHD"], "--listen", self.address or listen, "--port-file",
                 port_file, *self.arguments],
                stdout=subprocess.DEVNULL, stderr=log)
        until = time.monotonic() + 30
        while not port_file.exists() or not port_file.read_text():
            assert self._process.poll() is None, (self.folder / "log").read_text()
            assert time.monotonic() < until, "no server after 30 s"
            time.sleep(0.02)
        self.address = f"127.0.0.1:{int(port_file.read_text())}"

    def stop(self, how=signal.SIGTERM):
        if self._process is not None:
            self._process.send_signal(how)
            self._process.wait(30)
            self._process = None


@pytest.fixture(scope="module")
def daemon(tmp_path_factory):
    daemon = Daemon(tmp_path_factory.mktemp("dynmeshd"))
    daemon.start()
    yield daemon
    daemon.stop()


@pytest.fixture
def server(daemon):
    with dynmesh.connect(daemon.address) as server:
        yield server


@pytest.fixture(params=["local", "remote"])
def make_mesh(request):
    """Makes meshes in process, and the same at a server."""
    def make(box=((0, 0), (1, 1)), **options):
        if request.param == "local":
            return dynmesh.open(box, **options)
        return request.getfixturevalue("server").create(box=box, **options)
    return make


@pytest.fixture
def random():
    seed = int(os.environ.get("DYNMESH_TEST_SEED", np.random.SeedSequence().entropy % 2**32))
    print("seed", seed)
    return np.random.default_rng(seed)
