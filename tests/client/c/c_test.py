"""The C interface: programs in C, Fortran, Rust and Python print what the Python package has.

    c_test.py LIBRARY PACKAGES CC CXX ALONE Programs | Fortran | Rust | Ctypes | Symbols

LIBRARY is libdynmesh.so.0, PACKAGES a folder with the Python package, ALONE 1 if the library has
inside what it is linked with. Exit codes: 0 good, 1 not, 77 not run, because a compiler is not installed.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

NOT_RUN = 77
HERE = pathlib.Path(__file__).resolve().parent
HEADERS = HERE.parents[2] / "client/c"
LIBRARY = pathlib.Path(sys.argv[1]).resolve()
PACKAGES, CC, CXX, ALONE, PART = sys.argv[2:7]
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
LINKED = (f"-L{LIBRARY.parent}", "-ldynmesh", f"-Wl,-rpath,{LIBRARY.parent}")
TOOLS = {"Fortran": "gfortran", "Rust": "rustc"}


def run(*command, **options):
    said = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False, timeout=300, **options)
    if said.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}\n{said.stdout}")
    return said.stdout


class Built(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(dir=LIBRARY.parent)
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)

    def check_crack(self, *command):
        expected = run(sys.executable, "-B", HERE / "crack_package.py",
                       env={**os.environ, "PYTHONPATH": PACKAGES})
        self.assertRegex(expected, r"^[0-9a-f]{32} [0-9a-f]{16} [0-9]+\n$")
        self.assertEqual(run(*command).lower().split(), expected.split())


class Programs(Built):
    def compiled(self, name):
        program = self.folder / name
        run(CC, "-std=c11", "-O1", *WARNINGS, f"-I{HEADERS}", HERE / f"{name}.c", "-o", program,
            *LINKED)
        return program

    def test_a_crack(self):
        self.check_crack(self.compiled("crack"))

    def test_errors_strides_files(self):
        run(self.compiled("errors"), self.folder)

    def test_memory_that_runs_out(self):
        run(self.compiled("memory"))

    def test_the_header_is_cpp_as_well(self):
        source = self.folder / "header.cc"
        source.write_text('#include "dynmesh.h"\n#include "dynmesh.h"\n')
        for standard in ("c++11", "c++20"):
            run(CXX, f"-std={standard}", *WARNINGS, f"-I{HEADERS}", "-fsyntax-only", source)

    def test_the_program_of_the_document(self):
        text = (HERE.parents[2] / "docs/c.md").read_text()
        (program,) = re.findall(r"(?s)```c\n(.*?)```", text)
        (self.folder / "document.c").write_text(program)
        run(CC, "-std=c11", *WARNINGS, f"-I{HEADERS}", self.folder / "document.c", "-o",
            self.folder / "document", *LINKED)
        self.assertRegex(run(self.folder / "document"), r"^\d+ cells, hash [0-9a-f]{32}\n$")


class Fortran(Built):
    def test_a_crack(self):
        run("gfortran", "-std=f2018", "-O1", "-Wall", "-Werror", f"-J{self.folder}",
            HERE / "crack.f90", "-o", self.folder / "crack", *LINKED)
        self.check_crack(self.folder / "crack")


class Rust(Built):
    def test_a_crack(self):
        run("rustc", "-O", "-L", LIBRARY.parent, "-C", f"link-arg=-Wl,-rpath,{LIBRARY.parent}",
            "-o", self.folder / "crack", HERE / "crack.rs")
        self.check_crack(self.folder / "crack")


class Ctypes(Built):
    def test_a_crack(self):
        self.check_crack(sys.executable, "-B", HERE / "crack.py", LIBRARY)


class Symbols(unittest.TestCase):
    def test_they_are_those_of_the_header(self):
        header = re.sub(r"(?s)/\*.*?\*/", "", (HEADERS / "dynmesh.h").read_text())
        header = re.sub(r"(?m)^static inline [^{]*", "", header)
        declared = set(re.findall(r"\b(dynmesh_\w+)\(", header))
        rows = [line.split() for line in run("nm", "-D", "--defined-only", LIBRARY).splitlines()]
        shown = {row[2].split("@")[0] for row in rows if row[1] == "T"}
        self.assertEqual(shown, declared)
        self.assertEqual({row[2] for row in rows if row[1] != "T"}, {"DYNMESH_0"})
        self.assertTrue(all(row[2].endswith("@@DYNMESH_0") for row in rows if row[1] == "T"))

    def test_its_name_and_needs(self):
        dynamic = run("readelf", "-dW", LIBRARY)
        self.assertIn("[libdynmesh.so.0]", dynamic)
        if ALONE == "1":
            needed = set(re.findall(r"\(NEEDED\).*\[(.*?)\.so", dynamic))
            self.assertLessEqual(needed, {"libc", "libm", "ld-linux-x86-64"})


if __name__ == "__main__":
    if PART in TOOLS and shutil.which(TOOLS[PART]) is None:
        print(f"c_test: not run: not installed: {TOOLS[PART]}")
        sys.exit(NOT_RUN)
    unittest.main(argv=[sys.argv[0], PART], verbosity=2)
