"""The compiler through ccache: a precompiled header that is made anew is not taken for a former one."""

import os
import pathlib
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]


class CompilerCacheTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "bin").mkdir()
        # Tells its arguments, whether the output of the former compilation is there, and the folder
        # below which paths are relative.
        ccache = self.folder / "bin/ccache"
        ccache.write_text('#!/bin/sh\n[ -e out ] && echo there || echo gone\necho "$@"\n'
                          'echo "$CCACHE_BASEDIR"\nexit 3\n')
        ccache.chmod(0o755)
        (self.folder / "out").write_text("former")

    def run_with(self, *arguments):
        return subprocess.run(
            [SOURCE / "deploy/compiler-cache", *arguments],
            cwd=self.folder,
            env={**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}"},
            capture_output=True,
            text=True,
        )

    def test_a_former_precompiled_header_is_removed(self):
        arguments = ["c++", "-O2", "-x", "c++-header", "-include", "a b.hxx", "-o", "out", "-c", "a.cxx"]
        done = self.run_with(*arguments)
        self.assertEqual(done.stdout.splitlines()[:2], ["gone", " ".join(arguments)])
        self.assertEqual(done.returncode, 3)

    def test_a_former_object_stays(self):
        done = self.run_with("c++", "-x", "c++", "-o", "out", "-c", "a.cxx")
        self.assertEqual(done.stdout.splitlines()[0], "there")

    def test_clones_share_results(self):
        done = self.run_with("c++", "-o", "out", "-c", "a.cxx")
        self.assertEqual(done.stdout.splitlines()[-1], str(SOURCE))


if __name__ == "__main__":
    unittest.main()
