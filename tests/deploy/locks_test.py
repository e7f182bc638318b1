"""Scripts side by side: each waits for what another process holds, says so, and goes on."""

import fcntl
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DEADLINE = 120  # seconds until a wait is a failure


class Script:
    """A script that runs with other programs first in its PATH, its standard error in a file."""

    def __init__(self, folder, *command, **variables):
        self.errors = folder / f"errors-{time.monotonic_ns()}"
        environment = {**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}
        with open(self.errors, "wb") as errors:
            self.process = subprocess.Popen(
                [str(word) for word in command],
                env={**environment, **{k: str(v) for k, v in variables.items()}},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
            )

    def said(self):
        return self.errors.read_text()

    def wait_for(self, words):
        until = time.monotonic() + DEADLINE
        while words not in self.said():
            if self.process.poll() is not None or time.monotonic() > until:
                raise AssertionError(f"{self.process.args} did not say {words}: {self.said()}")
            time.sleep(0.05)

    def ends(self):
        return self.process.wait(DEADLINE)


class Folder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "bin").mkdir()

    def program(self, name, text):
        path = self.folder / "bin" / name
        path.write_text(f"#!/bin/bash\n{text}\n")
        path.chmod(0o755)

    def script(self, *command, **variables):
        script = Script(self.folder, *command, **variables)
        self.addCleanup(script.process.wait)
        self.addCleanup(script.process.kill)
        return script

    def lines(self, name):
        path = self.folder / name
        return path.read_text().splitlines() if path.exists() else []


class InstallPackages(Folder):
    """With the machine's apt-get, which has lists of packages of its own here and installs nothing."""

    def setUp(self):
        super().setUp()
        lists = self.folder / "lists"
        (lists / "partial").mkdir(parents=True)
        (self.folder / "apt.conf").write_text(
            f'Dir::State "{self.folder}"; Dir::State::Lists "{lists}"; Dir::Cache "{self.folder}";'
            ' Dir::Etc::SourceList "/dev/null"; Dir::Etc::SourceParts "/dev/null";'
        )
        self.lock = lists / "lock"
        real = shutil.which("apt-get")
        self.program("sudo", 'exec "$@"')
        self.program("dpkg-query", "exit 1")  # nothing is installed
        self.program("apt-cache", "exit 1")  # the lists know nothing
        self.program(
            "apt-get",
            f'echo "$*" >>{self.folder}/calls\n'
            f'if [[ $* == *update* ]]; then exec {real} "$@"; fi\n'
            f"if [[ -e {self.folder}/broken ]]; then echo 'E: Broken packages' >&2; exit 100; fi",
        )

    def run_script(self, **variables):
        return self.script(
            SOURCE / "deploy" / "install-packages",
            "faults",
            APT_CONFIG=self.folder / "apt.conf",
            **variables,
        )

    def test_waits_for_the_lists_and_says_so_once(self):
        with open(self.lock, "w", encoding="ascii") as lock:
            fcntl.lockf(lock, fcntl.LOCK_EX)
            script = self.run_script()
            script.wait_for("waits for another process that uses apt")
            until = time.monotonic() + DEADLINE
            while len(self.lines("calls")) < 3:  # goes on asking
                self.assertLess(time.monotonic(), until)
                time.sleep(0.05)
            self.assertIsNone(script.process.poll())
        self.assertEqual(script.ends(), 0, script.said())
        self.assertEqual(script.said().count("waits for"), 1)
        self.assertIn(str(self.lock), script.said())
        self.assertIn("install -y", self.lines("calls")[-1])

    def test_waits_no_longer_than_asked(self):
        with open(self.lock, "w", encoding="ascii") as lock:
            fcntl.lockf(lock, fcntl.LOCK_EX)
            script = self.run_script(DYNMESH_APT_WAIT=0)
            self.assertNotEqual(script.ends(), 0)
        self.assertIn("E: Could not get lock", script.said())
        self.assertNotIn("waits", script.said())

    def test_other_errors_are_told_and_end_it(self):
        (self.folder / "broken").touch()
        script = self.run_script()
        self.assertEqual(script.ends(), 100)
        self.assertIn("E: Broken packages", script.said())
        self.assertNotIn("waits", script.said())
        installs = [call for call in self.lines("calls") if "install" in call]
        self.assertEqual(len(installs), 2)  # again with new lists, and no more


class Build(Folder):
    """A copy of deploy/build, with a cmake that begins, waits until it may end, and ends."""

    def setUp(self):
        super().setUp()
        (self.folder / "deploy").mkdir()
        shutil.copy(SOURCE / "deploy" / "build", self.folder / "deploy" / "build")
        packages = self.folder / "deploy" / "install-packages"
        packages.write_text("#!/bin/bash\n")
        packages.chmod(0o755)
        self.program(
            "cmake",
            f"echo begin $BUILD >>{self.folder}/log\n"
            f"until [[ -e {self.folder}/go || ! -e {self.folder} ]]; do sleep 0.05; done\n"
            f"echo end $BUILD >>{self.folder}/log",
        )

    def build(self, preset, name):
        return self.script(self.folder / "deploy" / "build", preset, BUILD=name)

    def wait_for_line(self, line):
        until = time.monotonic() + DEADLINE
        while line not in self.lines("log"):
            self.assertLess(time.monotonic(), until, self.lines("log"))
            time.sleep(0.05)

    def test_of_one_folder_take_turns(self):
        first = self.build("release", "first")
        self.wait_for_line("begin first")
        second = self.build("release", "second")
        second.wait_for("another process builds in build/release")
        self.assertEqual(self.lines("log"), ["begin first"])
        (self.folder / "go").touch()
        self.assertEqual([first.ends(), second.ends()], [0, 0])
        turns = [f"{step} {name}" for name in ("first", "second") for step in ("begin", "end") * 2]
        self.assertEqual(self.lines("log"), turns)  # configured, built; the other one after it
        self.assertEqual(first.said(), "")

    def test_of_two_folders_do_not_wait(self):
        first = self.build("release", "first")
        self.wait_for_line("begin first")
        second = self.build("dev", "second")
        self.wait_for_line("begin second")
        (self.folder / "go").touch()
        self.assertEqual([first.ends(), second.ends()], [0, 0])


class MainJob(Folder):
    """A copy of deploy/run, with a build that makes no programs."""

    def test_waits_for_the_folder_that_another_run_writes_to(self):
        (self.folder / "deploy").mkdir()
        shutil.copy(SOURCE / "deploy" / "run", self.folder / "deploy" / "run")
        build = self.folder / "deploy" / "build"
        build.write_text("#!/bin/bash\n")
        build.chmod(0o755)
        out = self.folder / "out"
        out.mkdir()
        (out / "port").write_text("of the other run\n")
        with open(out / "lock", "w", encoding="ascii") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            script = self.script(self.folder / "deploy" / "run")
            script.wait_for(f"another run writes to {out}")
            self.assertTrue((out / "port").exists())
        self.assertNotEqual(script.ends(), 0)  # there is no dynmeshd
        self.assertFalse((out / "port").exists())  # but it went on


if __name__ == "__main__":
    if shutil.which("apt-get") is None:
        print("skipped: there is no apt-get")
        sys.exit(77)
    unittest.main()
