"""Processes in a root folder of their own, as a container engine runs them, without the engine.

Each has its own mount and process namespaces, in which it is process 1, and the network of the
starting program. Its mounts, including /proc, are private and are removed when it ends; it ends
together with the program that started it. Needs root and the features checked by `missing`.
"""

import contextlib
import ctypes
import dataclasses
import fcntl
import json
import os
import pathlib
import shutil
import signal
import socket
import stat
import struct
import subprocess
import sys
import tempfile
import time

# Exactly the variables that an engine sets.
PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
_TOOLS = ("unshare", "nsenter", "setpriv", "mount", "debootstrap", "tar", "git")


class ContainerError(Exception):
    pass


def missing(where):
    """Why containers cannot be made in the folder `where`, which is made; None if they can."""
    if os.geteuid() != 0:
        return "not root"
    absent = [tool for tool in _TOOLS if shutil.which(tool, path=PATH) is None]
    if absent:
        return f"not installed: {', '.join(absent)}"
    where.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=where) as folder:
        # A small test of all kernel features in use.
        asked = (
            'mount --bind "$1" "$1" && mount -o remount,bind,ro "$1" &&'
            ' ! touch "$1/a" 2>/dev/null && mount -t proc proc /proc && [ $$ = 1 ]'
        )
        command = ["unshare", "--net", *_NAMESPACES, "sh", "-c", asked, "sh", folder]
        said = subprocess.run(command, capture_output=True, text=True, check=False)
        if said.returncode != 0:
            return f"no namespaces with mounts of their own here: {said.stderr.strip()}"
        device = pathlib.Path(folder) / "null"
        try:
            os.mknod(device, 0o666 | stat.S_IFCHR, os.makedev(1, 3))
            device.write_text("a")
        except OSError as error:
            return f"devices cannot be made or used in {where}: {error}"
    return None


# The first process dies with its parent, and its children with it.
_NAMESPACES = (
    *("setpriv", "--pdeathsig", "KILL"),
    *("unshare", "--mount", "--propagation", "private", "--pid", "--fork", "--kill-child"),
)


@dataclasses.dataclass
class Container:
    """How processes are to run in `root`."""

    root: pathlib.Path
    user: str = "0"
    work_dir: str = "/"
    read_only: bool = False
    # Folder or file there, to (folder or file that `root` has, may it be written).
    mounts: dict = dataclasses.field(default_factory=dict)
    environment: dict = dataclasses.field(default_factory=dict)

    def start(self, command, **popen):
        """Process 1 of a new container; `pid_of` returns its number here."""
        uid, gid, groups, home = identity(self.root, self.user)
        with tempfile.NamedTemporaryFile("r", suffix=".pid", delete=False) as file:
            pid_file = file.name
        what = {
            "root": str(self.root),
            "work_dir": self.work_dir,
            "read_only": self.read_only,
            "mounts": [[str(a), b, writable] for a, (b, writable) in self.mounts.items()],
            "environment": {"PATH": PATH, "HOME": home, **self.environment},
            "ids": [uid, gid, groups],
            "pid_file": pid_file,
            "command": list(command),
        }
        process = subprocess.Popen(
            [*_NAMESPACES, sys.executable, "-B", __file__, json.dumps(what)],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            **popen,
        )
        process.pid_file = pathlib.Path(pid_file)
        return process

    def run(self, command, timeout, log=subprocess.PIPE):
        """Exit code and output, both streams of it, of a process in a container of its own."""
        process = self.start(command, stdout=log, stderr=subprocess.STDOUT, text=True)
        with finally_ended(process):
            return _finish(process, timeout)

    def run_beside(self, process, command, timeout):
        """The same in the container that `process` began, as `docker exec` does."""
        uid, gid, _, home = identity(self.root, self.user)
        inside = subprocess.Popen(
            [
                *("nsenter", "--target", str(pid_of(process)), "--mount", "--pid", "--root"),
                *("--wd", "--setuid", str(uid), "--setgid", str(gid)),
                *("env", "-i", f"PATH={PATH}", f"HOME={home}"),
                *(f"{name}={value}" for name, value in self.environment.items()),
                *command,
            ],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        return _finish(inside, timeout)


TIMED_OUT = -1  # in place of an exit code


def _finish(process, timeout):
    try:
        output, _ = process.communicate(timeout=timeout)
        return process.returncode, output
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)  # nsenter's child, too
        output, _ = process.communicate(timeout=60)
        return TIMED_OUT, output


def take_own_network():
    """Gives this program and its children a network of their own from here on: a private loopback
    with all ports free."""
    if ctypes.CDLL(None).unshare(0x40000000) != 0:  # CLONE_NEWNET
        raise OSError("no network of its own")
    with socket.socket() as any_socket:
        # Interface lo, with the flag IFF_UP.
        fcntl.ioctl(any_socket, 0x8914, struct.pack("16sH14x", b"lo", 1))  # SIOCSIFFLAGS


def pid_of(process, timeout=20):
    """The number, here, of the process that `Container.start` began."""
    deadline = time.monotonic() + timeout
    while not (text := process.pid_file.read_text()).endswith("\n"):
        if process.poll() is not None or time.monotonic() > deadline:
            raise ContainerError("the container did not start")
        time.sleep(0.01)
    return int(text)


@contextlib.contextmanager
def finally_ended(process):
    """Removes the container in any case."""
    try:
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait(60)
        process.pid_file.unlink()


def identity(root, user):
    """User id, group id, further groups and home of a user, by number or name, as `root` has it."""
    for line in (root / "etc/passwd").read_text().splitlines():
        name, _, uid, gid, _, home, _ = line.split(":")
        if user in (name, uid):
            groups = []
            for group in (root / "etc/group").read_text().splitlines():
                _, _, number, members = group.split(":")
                if name in members.split(","):
                    groups.append(int(number))
            return int(uid), int(gid), groups, home
    raise ContainerError(f"no user {user!r} in {root}/etc/passwd")


def _enter(what):
    """In the new namespaces: mounts, gives up rights, becomes the command."""
    root = what["root"]
    # The number there: this /proc is still that of outside.
    pid = os.readlink("/proc/self")

    def mount(*arguments):
        subprocess.run(["mount", *arguments], check=True)

    mount("--bind", root, root)
    mount("-t", "proc", "-o", "nosuid,nodev,noexec", "proc", root + "/proc")
    if what["read_only"]:
        mount("-o", "remount,bind,ro", root)
    for source, target, writable in what["mounts"]:
        mount("--bind", source, root + target)
        mount("-o", f"remount,bind,nosuid,nodev,{'rw' if writable else 'ro'}", root + target)
    pid_file = open(what["pid_file"], "w")
    os.chroot(root)
    os.chdir(what["work_dir"])
    uid, gid, groups = what["ids"]
    os.setgroups(groups)
    os.setgid(gid)
    os.setuid(uid)
    if uid != 0 and ctypes.CDLL(None).prctl(38, 1, 0, 0, 0) != 0:  # PR_SET_NO_NEW_PRIVS
        raise OSError("no_new_privs")
    os.umask(0o022)
    # From now on `exec` may enter: root and mounts are ready.
    pid_file.write(pid + "\n")
    pid_file.close()
    os.execvpe(what["command"][0], what["command"], what["environment"])


if __name__ == "__main__":
    _enter(json.loads(sys.argv[1]))
