#!/usr/bin/python3 -B
"""Builds the image that ./Dockerfile describes, without a container engine, and uses it.

    image_test.py [--cache FOLDER]      as root

FOLDER, or DYNMESH_IMAGE_CACHE, by default build/image, keeps Debian's bare system for the next run.
DYNMESH_JOBS is the number of compilations at a time, as for deploy/build.

Every stage is built in a root of its own (image_builder.py). The last one's ENTRYPOINT and CMD run
as its USER, read-only but for its VOLUME, as `docker run --read-only` would have it, nothing
replaced: the network is one of the test's own, in which every port is free. Then its HEALTHCHECK
has to succeed, clients of the same image load and watch a mesh, and a second run has to find it in
the volume.

Exit codes: 0 passed, 1 failed, 77 not run, because this system lacks something.
"""

import argparse
import contextlib
import fcntl
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import apt_settings
import container
import dockerfile
import image_builder
from container import Container

SOURCE = pathlib.Path(__file__).resolve().parents[2]
NOT_RUN = 77
# Mebibytes that the image may have more than Debian's bare system.
MORE_THAN_BARE = 100
# Seconds that a client may take.
CLIENT = 60


class Failure(Exception):
    pass


def expect(good, what):
    if not good:
        raise Failure(what)


def say(what):
    print(what, flush=True)


def tools_to_build(root):
    """Compilers and their like that can be called, and headers, in a root."""
    programs = "cc c++ gcc g++ cpp clang clang++ ld as make ninja cmake".split()
    found = [
        str(path)
        for folder in container.PATH.split(":")
        for program in programs
        if os.path.lexists(path := root / folder.strip("/") / program)
    ]
    for folder, _, names in os.walk(root):
        found += [os.path.join(folder, n) for n in names if n.endswith((".h", ".hh", ".hpp", ".a"))]
    return found


def check_tree(builder, root):
    bare, size = builder.bare_size, image_builder.mebibytes(root)
    say(f"the image: {size:.1f} MiB, of which Debian's bare system {bare:.1f}")
    expect(size - bare < MORE_THAN_BARE, f"more than {MORE_THAN_BARE} MiB above the bare system")
    expect(tools_to_build(next(iter(builder.roots.values()))), "the first stage cannot build")
    found = tools_to_build(root)
    expect(not found, f"{len(found)} tools and headers, such as {', '.join(found[:5])}")


class Image:
    """The last stage, to be run with folders as volumes."""

    def __init__(self, stage, root, work):
        self.stage = stage
        self._root = root
        self._work_dir = "/"
        for step in stage.steps:
            if isinstance(step, dockerfile.WorkDir):
                self._work_dir = step.path
        # A new volume has what the image has there, and its owner.
        self.ids = container.identity(root, stage.user)
        self._volumes = {}
        for number, path in enumerate(stage.volumes):
            volume = work / f"volume-{number}"
            subprocess.run(["cp", "-a", root / path.strip("/"), volume], check=True)
            self._volumes[volume] = (path, True)

    def server(self):
        return self._container(self._volumes)

    def client(self, mounts):
        return self._container(mounts)

    def _container(self, mounts):
        return Container(self._root, self.stage.user, self._work_dir, True, mounts)


@contextlib.contextmanager
def running(image, log):
    """The image's process, healthy."""
    began = time.monotonic()
    server = image.server()
    process = server.start(
        (*image.stage.entrypoint, *image.stage.command), stdout=log, stderr=subprocess.STDOUT
    )
    with container.finally_ended(process):
        while not healthy(image, server, process):
            code, waited = process.poll(), time.monotonic() - began
            expect(code is None, f"it ended with {code}; its log:\n{read(log)}")
            expect(waited < image.stage.health.start_period, f"not healthy after {waited:.0f} s")
            time.sleep(0.1)
        say(f"healthy after {time.monotonic() - began:.1f} s")
        yield process


def healthy(image, server, process):
    """The result of the health check beside the process."""
    health = image.stage.health
    return server.run_beside(process, health.command, health.timeout)[0] == 0


def read(log):
    log.flush()
    return pathlib.Path(log.name).read_text(errors="replace")


def check_rights(image, process):
    """The process's user, write access, and listening address."""
    folder = pathlib.Path(f"/proc/{container.pid_of(process)}")
    lines = (folder / "status").read_text().splitlines()
    status = dict(line.split(":\t", 1) for line in lines if ":\t" in line)
    # No shell in between, which would keep signals to itself.
    expect(status["Name"] == image.stage.entrypoint[0], f"process 1 is {status['Name']}")
    uid, gid = (str(number) for number in image.ids[:2])
    expect(status["Uid"].split() == [uid] * 4, f"its user is {status['Uid']}")
    # The manifests' user and group have the same number; see kubernetes_test.py.
    expect(uid == gid and status["Gid"].split() == [gid] * 4, f"its group is {status['Gid']}")
    expect(int(status["CapEff"], 16) == 0, f"it has capabilities {status['CapEff']}")
    mounts = [line.split() for line in (folder / "mountinfo").read_text().splitlines()]
    writable = {m[4] for m in mounts if "rw" in m[5].split(",")}
    expect(writable == {"/proc", *image.stage.volumes}, f"it may write to {writable}")
    ports = set()
    for file in ("tcp", "tcp6"):
        for line in pathlib.Path("/proc/self/net", file).read_text().splitlines()[1:]:
            words = line.split()
            if words[3] == "0A":  # listens
                ports.add(int(words[1].rsplit(":")[-1], 16))
    expect(ports == set(image.stage.ports), f"it listens on {ports}, not on what EXPOSE says")


class Client:
    """`dynmesh` of the image, in containers of their own: data come to /mnt, files go to /srv."""

    def __init__(self, image, work):
        self.out = work / "out"
        self.out.mkdir()
        shutil.chown(self.out, image.ids[0])
        self.container = image.client(
            {SOURCE / "deploy/data": ("/mnt", False), self.out: ("/srv", True)}
        )

    def __call__(self, *words):
        code, output = self.container.run(("dynmesh", *words), CLIENT)
        expect(code == 0, f"dynmesh {' '.join(words)} ended with {code}:\n{output}")
        return output

    def wait_for_server(self):
        """A live process is healthy, even during recovery."""
        deadline = time.monotonic() + CLIENT
        while self.container.run(("dynmesh", "stats"), CLIENT)[0] != 0:
            expect(time.monotonic() < deadline, "the server is healthy, but does not answer")
            time.sleep(0.1)

    def start(self, *words):
        return self.container.start(
            ("dynmesh", *words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def state(self):
        """The data that must outlive the server."""
        known = json.loads(self("stats", "coast", "--json"))
        return {key: known[key] for key in ("hash", "revision", "features", "vertices")}


def main_job(client):
    """The coastline and a storm, watched; the state at the end."""
    client("import", "/mnt/coastline-110m.poly", "-o", "/srv/load.dynmesh")
    say(client("apply", "coast", "/srv/load.dynmesh", "--create").splitlines()[0])
    loaded = client.state()
    expect(loaded["revision"] == 1, f"after loading: {loaded}")
    storm = (SOURCE / "deploy/data/storm.dynmesh").read_text()
    last = 1 + storm.split().count("commit")
    watch = client.start("watch", "coast", "--until", str(last), "-o", "/srv/watched.node")
    say(client("apply", "coast", "/mnt/storm.dynmesh").splitlines()[-1])
    with container.finally_ended(watch):
        output, _ = watch.communicate(timeout=CLIENT)
    expect(watch.returncode == 0, f"the watch ended with {watch.returncode}:\n{output}")
    client("export", "coast", "-o", "/srv/exported.node")
    client("diff", "/srv/exported.node", "/srv/watched.node")
    (client.out / "all.dynmesh").write_text((client.out / "load.dynmesh").read_text() + storm)
    say(client("verify", "/srv/exported.node", "--input", "/srv/all.dynmesh").splitlines()[0])
    state = client.state()
    expect(state["revision"] == last and state["hash"] != loaded["hash"], f"at the end: {state}")
    return state


def end(process, log):
    began = time.monotonic()
    os.kill(container.pid_of(process), signal.SIGTERM)
    try:
        code = process.wait(60)
    except subprocess.TimeoutExpired:
        code = None
    expect(code == 0, f"after SIGTERM it ended with {code}; its log:\n{read(log)}")
    say(f"ended in order, in {time.monotonic() - began:.1f} s")


def check_health_is_told(image, process):
    """The health check of a stopped process fails, and succeeds again when it continues."""
    pid = container.pid_of(process)
    os.kill(pid, signal.SIGSTOP)
    stopped = healthy(image, image.server(), process)
    os.kill(pid, signal.SIGCONT)
    expect(not stopped, "the health check calls a stopped server healthy")
    expect(healthy(image, image.server(), process), "not healthy when it goes on")


def use(image, work):
    client = Client(image, work)
    check = image.stage.health

    def health_from_beside():
        return client.container.run(check.command, check.timeout)[0] == 0

    with (work / "server.log").open("a") as log:
        with running(image, log) as process:
            check_rights(image, process)
            expect(health_from_beside(), "the health check fails in another container")
            client.wait_for_server()
            with image_builder.Timed("the main job"):
                state = main_job(client)
            say(f"revision {state['revision']}, hash {state['hash']}")
            check_health_is_told(image, process)
            end(process, log)
        expect(not health_from_beside(), "the health check succeeds without a server")
        with running(image, log) as process:
            client.wait_for_server()
            after = client.state()
            expect(after == state, f"after a restart: {after}, before: {state}")
            client("export", "coast", "-o", "/srv/after.node")
            client("diff", "/srv/exported.node", "/srv/after.node")
            say("after a restart, from the volume: the same revision, hash and mesh")
            end(process, log)


def test(cache, work):
    builder = image_builder.Builder(SOURCE, cache, work)
    with image_builder.Timed("all stages"):
        root = builder.build()
    check_tree(builder, root)
    container.take_own_network()
    use(Image(builder.stages[-1], root, work), work)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = os.environ.get("DYNMESH_IMAGE_CACHE", SOURCE / "build/image")
    parser.add_argument("--cache", type=pathlib.Path, default=default)
    cache = parser.parse_args().cache.resolve()
    if reason := container.missing(cache):
        say(f"image_test: not run: {reason}")
        return NOT_RUN
    work = cache / "work"
    errors = (
        *(Failure, image_builder.BuildError, container.ContainerError),
        *(apt_settings.AptError, dockerfile.DockerfileError, subprocess.CalledProcessError),
    )
    with (cache / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        # What a run that was killed left behind.
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        try:
            test(cache, work)
        except errors as error:
            say(f"image_test: failed: {error}")
            return 1
        finally:
            shutil.rmtree(work)
    say("image_test: good")
    return 0


if __name__ == "__main__":
    sys.exit(main())
