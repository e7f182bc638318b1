"""The Python package as a wheel: what is in it, and that it runs where there is nothing else.

    wheel_test.py BUILD Wheel | Sdist

`Wheel` makes it of the build's modules and installs it in an environment of its own, which has
Debian's numpy (and for an example SciPy and meshio) beside it, no compiler and no library path.
`Sdist` compiles the source distribution for such an environment.
Exit codes: 0 good, 1 not.
"""

import base64
import hashlib
import importlib.metadata
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
import unittest
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
CONSUMER = SOURCE / "tests/package/consumer"
BUILD = pathlib.Path(sys.argv[1]).resolve()
BACKEND = SOURCE / "client/python/build_backend/backend.py"
DEBIAN = pathlib.Path("/usr/lib/python3/dist-packages")
BESIDE = ("numpy", "scipy", "meshio", "rich")  # numpy, and what the example needs
LARGEST = 15_000_000  # bytes of a wheel
LONGEST = 0.15  # seconds of processor time to import it after numpy; looked at by night
IMPORTS = ((r"^import triangle as tr$", "import dynmesh.compat.triangle as tr"),
           (r"^from meshpy([. ])", r"from dynmesh.compat.meshpy\1"),
           (r"^import tetgen$", "from dynmesh.compat import tetgen"))
COMPILERS = ("cc", "c++", "gcc", "g++", "clang", "cmake", "ninja", "make")


def run(*command, timeout=7000, **options):
    said = subprocess.run(
        [str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, check=False, timeout=timeout, **options)
    if said.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}\n{said.stdout}")
    return said.stdout


def made(kind, out, *arguments):
    """The path of the wheel or the source distribution that the backend makes."""
    return pathlib.Path(run(sys.executable, "-B", BACKEND, kind, out, *arguments).split()[-1])


class Environment:
    """An environment with some modules of Debian, and no other ones."""

    def __init__(self, folder):
        self.folder = folder
        run(sys.executable, "-m", "venv", "--without-pip", folder)
        (self.packages,) = (folder / "lib").glob("python3*/site-packages")
        for name in BESIDE:
            for path in DEBIAN.glob(f"{name}*"):
                (self.packages / path.name).symlink_to(path)
        # Compilers that fail, and nothing else to be found.
        self.path = folder / "masked"
        self.path.mkdir()
        for name in COMPILERS:
            (self.path / name).write_text("#!/bin/sh\necho no compiler here >&2\nexit 1\n")
            (self.path / name).chmod(0o755)

    def install(self, package, *arguments):
        run(sys.executable, "-m", "pip", "--python", self.folder / "bin/python", "install",
            "--quiet", "--no-index", "--disable-pip-version-check", "--no-cache-dir", *arguments,
            package)

    def run(self, *arguments, program="python"):
        return run(self.folder / "bin" / program, *arguments, cwd=self.folder,
                   env={"PATH": str(self.path), "HOME": str(self.folder)})


class Made(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        (BUILD / "install").mkdir(exist_ok=True)
        holder = tempfile.TemporaryDirectory(dir=BUILD / "install")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        cls.environment = Environment(cls.folder / "environment")

    def expected_hash(self):
        said = run(BUILD / "bin/dynmesh", "replay", CONSUMER / "plate.dynmesh")
        return re.search(r"^hash ([0-9a-f]{32})$", said, re.M)[1]

    def version(self):
        header = (SOURCE / "core/include/dynmesh/version.h").read_text()
        return ".".join(re.findall(r"^#define DYNMESH_VERSION_[A-Z]+ (\d+)$", header, re.M))

    def check_program(self):
        said = self.environment.run("-B", "-W", "error", CONSUMER / "program.py").split()
        self.assertEqual(said, [self.version(), self.version(), self.expected_hash(),
                                f"{self.environment.packages}/dynmesh/__init__.py"])


class Wheel(Made):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.wheel = made("wheel", cls.folder, BUILD)
        cls.environment.install(cls.wheel)
        cls.archive = zipfile.ZipFile(cls.wheel)
        cls.addClassCleanup(cls.archive.close)
        cls.names = cls.archive.namelist()
        cls.info = next(name for name in cls.names if name.endswith("/METADATA")).split("/")[0]

    def unpacked(self, ending):
        (name,) = [name for name in self.names if name.endswith(ending)]
        return pathlib.Path(self.archive.extract(name, self.folder / "unpacked"))

    def test_it_has_what_it_says(self):
        self.assertEqual(self.info, f"dynmesh-{self.version()}.dist-info")
        package = SOURCE / "client/python/dynmesh"
        sources = {f"dynmesh/{path.relative_to(package).as_posix()}" for path in package.rglob("*")
                   if path.suffix in (".py", ".pyi", ".typed")}
        self.assertLessEqual(sources, set(self.names))
        recorded = {}
        for line in self.archive.read(f"{self.info}/RECORD").decode().split():
            name, digest, size = line.rsplit(",", 2)
            recorded[name] = (digest, size)
        self.assertEqual(list(recorded), self.names)
        for name, (digest, size) in recorded.items():
            if name.endswith("/RECORD"):
                continue
            data = self.archive.read(name)
            found = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            self.assertEqual((digest, size), (f"sha256={found}", str(len(data))), name)
        headers = importlib.metadata.PathDistribution(
            zipfile.Path(self.wheel, f"{self.info}/")).metadata
        self.assertEqual((headers["Name"], headers["Version"]), ("dynmesh", self.version()))

    def test_its_tag_is_that_of_what_it_needs(self):
        tag = re.search(r"^Tag: (.*)$", self.archive.read(f"{self.info}/WHEEL").decode(), re.M)[1]
        self.assertEqual(self.wheel.name, f"dynmesh-{self.version()}-{tag}.whl")
        newest = 0
        for ending in (".so", "scripts/dynmesh"):
            binary = self.unpacked(ending)
            needed = set(re.findall(r"\(NEEDED\).*\[(.*?)\.so", run("readelf", "-dW", binary)))
            self.assertLessEqual(needed, {"libc", "libm", "ld-linux-x86-64"}, binary)
            symbols = run("readelf", "-VW", binary)
            self.assertNotIn("GLIBCXX", symbols)
            newest = max(newest, *map(int, re.findall(r"GLIBC_2\.(\d+)", symbols)))
        self.assertIn(f"-manylinux_2_{newest}_", self.wheel.name)

    def test_the_readme_has_its_name_and_a_program_that_runs(self):
        text = (SOURCE / "README.md").read_text()
        # That of another system has another tag.
        self.assertIn(f"pip install dynmesh-{self.version()}-", text)
        program, count, corners = re.search(
            r"(?s)```python\n(.*?)  +# (\d+) x (\d+)\n```", text).groups()
        said = self.environment.run("-B", "-W", "error", "-c",
                                    program.replace("tr.triangulate", "found = tr.triangulate")
                                    + "\nprint(*found.shape)")
        self.assertEqual(said, f"{count} {corners}\n")

    def test_its_module_exports_what_python_calls(self):
        said = run("nm", "-D", "--defined-only", self.unpacked(".so")).split()
        self.assertEqual(said[1:], ["T", "PyInit__core"])

    def test_tags_of_other_libraries(self):
        module = importlib.util.spec_from_file_location("backend", BACKEND)
        backend = importlib.util.module_from_spec(module)
        module.loader.exec_module(backend)
        machine = sysconfig.get_platform().split("-")[-1]
        for name, text, flags, tag in (
                ("plain.c", "int f(int i) { return i; }", (), f"manylinux_2_17_{machine}"),
                # Packed relocations: glibc has them since 2.36.
                ("packed.c", '#include <stdio.h>\nconst char *const t[] = {"a", "b"};\n'
                 "int f(void) { return puts(t[0]); }", ("-Wl,-z,pack-relative-relocs",),
                 f"manylinux_2_36_{machine}"),
                ("standard.cc", "#include <string>\nstd::string f(std::string s) { return s + s; }",
                 (), f"linux_{machine}")):
            with self.subTest(name):
                (self.folder / name).write_text(text)
                library = self.folder / f"{name}.so"
                run("c++", "-x", "c++" if name.endswith("cc") else "c", "-shared", "-fPIC",
                    self.folder / name, "-o", library, "-Wl,--as-needed", *flags)
                self.assertEqual(backend.platform_of([library]), tag)

    def test_it_is_small(self):
        self.assertLess(self.wheel.stat().st_size, LARGEST)

    def test_licences_of_all_that_is_linked_are_in_it(self):
        have = {name.split("/licenses/")[1] for name in self.names if "/licenses/" in name}
        packages = {"libabsl-dev", "libboost-dev", "libcgal-dev", "libcli11-dev", "libgmp-dev",
                    "nlohmann-json3-dev", "pybind11-dev", "zlib1g-dev"}
        self.assertLessEqual({f"{name}/copyright" for name in packages}, have)
        self.assertTrue([name for name in have if name.startswith("libstdc++-")])
        self.assertLessEqual({"dynmesh/LICENSE", "GPL-3", "LGPL-3"}, have)

    def test_programs_run(self):
        self.check_program()
        # An example, which judges itself.
        self.environment.run("-B", SOURCE / "examples/heat_crack.py", "--edge", "0.1",
                             "--steps", "3", "--out", self.folder / "heat")

    def test_programs_for_other_packages_run_with_one_import_changed(self):
        programs = sorted((SOURCE / "tests/package/programs").glob("*.py"))
        self.assertEqual(len(programs), 5)
        for program in programs:
            with self.subTest(program.name):
                text = program.read_text()
                self.assertNotIn("dynmesh", text)
                changed = [re.sub(pattern, there, text, flags=re.M) for pattern, there in IMPORTS
                           if re.search(pattern, text, re.M)]
                self.assertEqual(len(changed), 1)
                lines = list(zip(text.split("\n"), changed[0].split("\n"), strict=True))
                self.assertEqual(sum(old != new for old, new in lines), 1)
                here = self.folder / program.name
                here.write_text(changed[0])
                self.environment.run("-B", "-W", "error", here)

    def test_the_command_runs(self):
        script = self.folder / "plate.dynmesh"
        shutil.copy(CONSUMER / "plate.dynmesh", script)
        said = self.environment.run("replay", script, program="dynmesh")
        self.assertIn(self.expected_hash(), said)
        self.assertNotIn("--server", self.environment.run("mesh", "--help", program="dynmesh"))

    def test_a_connection_without_grpcio_says_what_is_missing(self):
        said = self.environment.run("-c", """
import dynmesh
try: dynmesh.connect("localhost:1")
except ImportError as error: print(error)""")
        self.assertIn("dynmesh[service]", said)

    def test_a_mesh_of_a_server(self):
        beside = self.folder / "beside"
        beside.mkdir()
        for name in ("grpc", "google", "six.py"):
            (beside / name).symlink_to(DEBIAN / name)
        port = self.folder / "port"
        with subprocess.Popen([BUILD / "bin/dynmeshd", "--listen", "127.0.0.1:0", "--port-file",
                               port], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
            try:
                until = time.monotonic() + 60
                while not (port.exists() and port.read_text()) and time.monotonic() < until:
                    time.sleep(0.02)
                said = self.environment.run("-c", f"""
import sys
sys.path.append({str(beside)!r})
import dynmesh
with dynmesh.connect("127.0.0.1:{port.read_text().strip()}") as server:
    mesh = server.create(box=[[0, 0], [10, 10]])
    mesh.apply(add_points={{1: (2, 2), 2: (7, 4), 3: (2.1, 2.3)}})
    mesh.apply(add_segments={{4: (1, 2)}})
    print(mesh.hash)""")
            finally:
                server.terminate()
        self.assertEqual(said.strip(), self.expected_hash())

    def test_it_is_imported(self):
        said = [float(self.environment.run("-I", "-c", """
import time, numpy
began = time.process_time()
import dynmesh
print(time.process_time() - began)""")) for _ in range(5)]
        print(f"imported in {min(said):.3f} s, {self.wheel.stat().st_size} bytes", file=sys.stderr)
        if os.environ.get("DYNMESH_NIGHTLY"):
            self.assertLess(min(said), LONGEST)


class Sdist(Made):
    def test_it_compiles_and_runs(self):
        archive = made("sdist", self.folder)
        self.environment.install(archive, "--no-build-isolation")
        self.check_program()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], sys.argv[2]], verbosity=2)
