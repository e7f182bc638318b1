"""Builds the stages of a Dockerfile as folders, with debootstrap in place of a container engine.

A stage's root is Debian's smallest system, its COPY and RUN lines are done in order. What a COPY
takes from the sources is what git knows of and .dockerignore allows. What Debian's packages come
from is the machine's own apt's business; see apt_settings.py.
"""

import os
import pathlib
import shutil
import subprocess
import time

import apt_settings
import dockerfile
from container import Container

# So many seconds may one RUN take; those compile.
_RUN_TIMEOUT = 5400


class BuildError(Exception):
    pass


class Builder:
    """Stages go to folders in `work`, bare systems to `cache`, where the next run finds them.
    Delete what is in `cache` to have newer ones."""

    def __init__(self, source, cache, work):
        self._source = source
        self._cache = cache
        self._work = work
        self.log = cache / "build.log"
        self.stages = dockerfile.parse((source / "Dockerfile").read_text())
        self.roots = {}  # by name or, of a stage without, number
        self.bare_size = 0  # of what the last stage began with

    def build(self):
        """Builds all stages; the last one's root."""
        self.log.write_text("")
        for number, stage in enumerate(self.stages):
            root = self._work / f"stage-{number}"
            self._bare_root(stage.base, root)
            self.roots[stage.name or str(number)] = root
            self.bare_size = mebibytes(root)
            self._build_stage(stage, root)
        return root

    def _bare_root(self, image, root):
        suite = apt_settings.suite_of(image)
        architecture = subprocess.run(
            ["dpkg", "--print-architecture"], capture_output=True, text=True, check=True
        ).stdout.strip()
        tar = self._cache / f"{suite}-minbase-{architecture}.tar"
        if not tar.exists():
            with Timed(f"debootstrap of {suite}"):
                self._debootstrap(suite, tar)
        root.mkdir()
        _command("tar", "--extract", "--numeric-owner", "-pf", tar, "-C", root)
        (root / "etc/apt/sources.list").write_text("\n".join(apt_settings.sources(suite)) + "\n")

    def _debootstrap(self, suite, tar):
        mirror = apt_settings.sources(suite)[0].split()[1]
        root = self._work / "bare"
        proxy = apt_settings.proxy()
        environment = {**os.environ, **({"http_proxy": proxy} if proxy else {})}
        # What it mounts does not outlive it.
        command = ["unshare", "--mount", "--propagation", "private"]
        command += ["debootstrap", "--variant=minbase", suite, root, mirror]
        with self.log.open("a") as log:
            done = subprocess.run(command, stdout=log, stderr=log, env=environment, check=False,
                                  timeout=3600)
        if done.returncode != 0:
            raise BuildError(f"debootstrap from {mirror} failed:\n{self._end_of_log()}")
        shutil.rmtree(root / "var/cache/apt/archives")
        (root / "var/cache/apt/archives/partial").mkdir(parents=True)
        unfinished = tar.with_suffix(".part")
        _command("tar", "--create", "--numeric-owner", "-f", unfinished, "-C", root, ".")
        shutil.rmtree(root)
        unfinished.rename(tar)

    def _build_stage(self, stage, root):
        work_dir = "/"
        # For the time of the build only.
        reach = root / "etc/apt/apt.conf.d/99build-machine"
        reach.write_text("\n".join(apt_settings.settings()) + "\n")
        for step in stage.steps:
            if isinstance(step, dockerfile.WorkDir):
                work_dir = step.path
                _inside(root, work_dir).mkdir(parents=True, exist_ok=True)
            elif isinstance(step, dockerfile.Copy):
                self._copy(step, root, work_dir)
            elif isinstance(step, dockerfile.Run):
                with Timed(f"RUN {' '.join(step.command)}"):
                    self._run(step, root, work_dir)
            else:
                raise BuildError(f"no way to do {step}")
        reach.unlink()

    def _run(self, step, root, work_dir):
        environment = {
            name: value for name, value in os.environ.items() if name.lower().endswith("_proxy")
        }
        if jobs := os.environ.get("DYNMESH_JOBS"):  # as an engine may be given fewer cores
            environment["CMAKE_BUILD_PARALLEL_LEVEL"] = jobs
        resolver = pathlib.Path("/etc/resolv.conf").resolve()
        mounts = {}
        if resolver.exists():
            (root / "etc/resolv.conf").touch()
            mounts[resolver] = ("/etc/resolv.conf", False)
        inside = Container(root, work_dir=work_dir, mounts=mounts, environment=environment)
        with self.log.open("a") as log:
            code, _ = inside.run(step.command, _RUN_TIMEOUT, log)
        if code != 0:
            raise BuildError(f"{step} ended with {code}:\n{self._end_of_log()}")

    def _end_of_log(self):
        return "\n".join(self.log.read_text(errors="replace").splitlines()[-40:])

    def _copy(self, step, root, work_dir):
        destination = os.path.join(work_dir, step.destination)
        for source in step.sources:
            if step.stage is None:
                files = self._of_sources(source)
                origin = self._source
            else:
                origin = self.roots[step.stage]
                files = [_inside(origin, source).relative_to(origin)]
                if (origin / files[0]).is_dir():
                    raise BuildError(f"no way to copy the folder {source} of a stage")
            prefix = pathlib.PurePath(source.strip("/"))
            for file in files:
                # What is in a folder is copied, not the folder; a file keeps its name.
                name = file.relative_to(prefix) if file != prefix else pathlib.Path(file.name)
                to = _inside(root, destination)
                if file != prefix or step.destination.endswith("/") or to.is_dir():
                    to = to / name
                _copy_file(origin / file, to)

    def _of_sources(self, source):
        """The files that `source`, a file or a folder, stands for."""
        # Regardless of the owner: this runs as root.
        command = ["git", "-c", "safe.directory=*", "-C", self._source, "ls-files", "-z"]
        known = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        ignored = dockerfile.read_ignore((self._source / ".dockerignore").read_text())
        prefix = pathlib.PurePath(source.strip("/"))
        files = [
            pathlib.PurePath(name)
            for name in known.split("\0")
            if name and not ignored(name) and pathlib.PurePath(name).is_relative_to(prefix)
        ]
        if not files:
            raise BuildError(f"COPY {source}: git knows no such file, or .dockerignore hides it")
        return files


def mebibytes(root):
    """What the files of a tree take, each once."""
    sizes = {}
    for folder, _, names in os.walk(root):
        for name in names:
            status = os.lstat(os.path.join(folder, name))
            sizes[status.st_ino] = status.st_size
    return sum(sizes.values()) / 2**20


class Timed:
    """Says what is done and, when it is, how long it took."""

    def __init__(self, what):
        self._what = what

    def __enter__(self):
        self._start = time.monotonic()

    def __exit__(self, error, *_):
        end = "failed after " if error else ""
        print(f"{self._what}: {end}{time.monotonic() - self._start:.1f} s", flush=True)


def _inside(root, path):
    """Where `path` of the image lies; no link may lead out of it."""
    found = root / path.strip("/")
    if not found.resolve().is_relative_to(root.resolve()):
        raise BuildError(f"{path} leads out of the image")
    return found


def _copy_file(source, to):
    """Everything of an image is root's, unless RUN says otherwise."""
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(source, to, follow_symlinks=False)
    os.chown(to, 0, 0, follow_symlinks=False)


def _command(*words):
    subprocess.run(words, check=True)
