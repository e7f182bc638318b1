"""dynmesh as other projects get it: installed, as sources in a project of theirs, in packages.

    package_test.py BUILD CXX Installed | Subdirectory | Packages

The programs in consumer/ have to build with warnings as errors and to print the hash that the
`dynmesh` command has; the one in Python as well. Exit codes: 0 good, 1 not, 77 not run, because a tool is not installed.
"""

import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

NOT_RUN = 77
SOURCE = pathlib.Path(__file__).resolve().parents[2]
CONSUMER = SOURCE / "tests/package/consumer"
BUILD = pathlib.Path(sys.argv[1]).resolve()
CXX = sys.argv[2]
FOLDERS = ("core/include", "client/include", "proto/codec/include")  # of public headers
PYTHON_FOLDER = "lib/python3/dist-packages"
HAS_PYTHON = any((BUILD / "python/dynmesh").glob("_core*.so"))  # not with -DDYNMESH_PYTHON=OFF
WARNINGS = ["-Werror", "-Wunused", "-Wall", "-Wextra"]
ENGINE_SAYS = "the trace is that of a run from scratch\n"  # examples/maximum.cc
CRACK_SAYS = "8 0 within\n"
PLATE = """8 2 0 0
1 0 0\n2 1 0\n3 1 1\n4 0 1\n5 .4 .4\n6 .6 .4\n7 .6 .6\n8 .4 .6
8 0
1 1 2\n2 2 3\n3 3 4\n4 4 1\n5 5 6\n6 6 7\n7 7 8\n8 8 5
1
1 .5 .5
"""
TOOLS = {
    "Installed": ["cmake", "ninja", "pkg-config"],
    "Subdirectory": ["cmake", "ninja"],
    "Packages": ["cpack", "dpkg-deb", "dpkg-shlibdeps"],
}


def run(*command, **options):
    said = subprocess.run(
        [str(word) for word in command],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=800,
        **options
    )
    if said.returncode != 0:
        raise AssertionError(f"{shlex.join(map(str, command))}\n{said.stdout}")
    return said.stdout


def configure(where, *arguments):
    run("cmake", "-G", "Ninja", "-S", CONSUMER, "-B", where, f"-DCMAKE_CXX_COMPILER={CXX}",
        "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", *arguments)


def expected_hash():
    said = run(BUILD / "bin/dynmesh", "replay", CONSUMER / "plate.dynmesh")
    return re.search(r"^hash ([0-9a-f]{32})$", said, re.M)[1]


def version():
    header = (SOURCE / "core/include/dynmesh/version.h").read_text()
    return ".".join(re.findall(r"^#define DYNMESH_VERSION_[A-Z]+ (\d+)$", header, re.M))


def run_python(folder):
    """The Python package in `folder`: what consumer/program.py prints, in words."""
    # No folder but that one and Debian's; -B leaves nothing compiled there.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return run(sys.executable, "-B", "-W", "error", CONSUMER / "program.py",
               env={**environment, "PYTHONPATH": str(folder)}).split()


def compile_lines(where):
    """Words of the compilations, by source, without what every one has: compiler, in and out."""
    lines = {}
    for entry in json.loads((where / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])[1:]
        words = words[: words.index("-o")]
        lines[pathlib.Path(entry["file"])] = words
    return lines


class Folder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # In the build tree: /tmp may be small, or forbid to run programs.
        (BUILD / "install").mkdir(exist_ok=True)
        cls._folder = tempfile.TemporaryDirectory(dir=BUILD / "install")
        cls.addClassCleanup(cls._folder.cleanup)
        cls.folder = pathlib.Path(cls._folder.name)


class Installed(Folder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.prefix = cls.folder / "prefix"
        run("cmake", "--install", BUILD, "--prefix", cls.prefix)
        cls.built = cls.folder / "cmake"
        configure(cls.built, f"-DCMAKE_PREFIX_PATH={cls.prefix}")
        run("cmake", "--build", cls.built)

    def pkg_config(self, *arguments):
        path = next(self.prefix.rglob("dynmesh.pc")).parent
        environment = {**os.environ, "PKG_CONFIG_PATH": str(path)}
        return run("pkg-config", *arguments, env=environment).split()

    def test_a_program_finds_it_with_cmake(self):
        where = self.built
        for source, words in compile_lines(where).items():
            mine = [word for word in words if not word.startswith("-D")]
            self.assertEqual(
                mine, ["-isystem", f"{self.prefix}/include", *WARNINGS, "-std=gnu++20"], source
            )
        self.assertEqual(run(where / "consumer").split(), [version(), expected_hash()])
        self.assertIn(ENGINE_SAYS, run(where / "consumer_engine"))
        self.assertEqual(run(where / "consumer_surfaces", self.crack()), CRACK_SAYS)
        with Server(self.folder / "port") as address:
            self.assertEqual(run(where / "consumer_client", address).split(), [expected_hash()])

    def crack(self):
        """A surface file: a box whose lid is a little above it."""
        path = self.folder / "crack.off"
        ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
        points = [(x, y, z) for z in ("0", "1", "1.000001") for x, y in ring]
        sides = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
        faces = [(3, 2, 1, 0), (8, 9, 10, 11), *sides]
        rows = ["OFF", f"{len(points)} {len(faces)} 0",
                *(" ".join(map(str, point)) for point in points),
                *(" ".join(map(str, (4, *face))) for face in faces)]
        path.write_text("\n".join(rows) + "\n")
        return path

    def build_by_pkg_config(self, package, target, source):
        """A program of consumer/ by that package's flags. Its object is CMake's, as reading the
        headers takes long: here they are found, and it is linked."""
        program = self.folder / f"{target}_by_pkg_config"
        run(CXX, "-std=c++20", "-E", *self.pkg_config("--cflags", package), source, "-o", os.devnull)
        (compiled,) = (self.built / f"CMakeFiles/{target}.dir").rglob(f"{source.name}.o")
        run(CXX, compiled, "-o", program, *self.pkg_config("--libs", package))
        return program

    def test_programs_of_documents_build_and_run(self):
        programs = [
            block
            for name in ("README.md", "docs/embedding.md")
            for block in re.findall(r"(?s)```cpp\n(.*?)```", (SOURCE / name).read_text())
            if "int main(" in block
        ]
        self.assertGreaterEqual(len(programs), 2)
        said = []
        for number, program in enumerate(programs):
            where = self.folder / f"document{number}"
            where.mkdir()
            (where / "main.cc").write_text(program)
            (where / "plate.poly").write_text(PLATE)
            run("cmake", "-G", "Ninja", "-S", SOURCE / "tests/package/documents", "-B", where,
                f"-DCMAKE_CXX_COMPILER={CXX}", f"-DCMAKE_PREFIX_PATH={self.prefix}",
                f"-DDOCUMENT={where}/main.cc")
            run("cmake", "--build", where)
            said.append(run(where / "document", cwd=where))
        self.assertRegex(said[0], r"^triangles \+\d+ -\d+, hash [0-9a-f]{32}\n$")
        self.assertIn("$PhysicalNames", (self.folder / "document1/plate.msh").read_text())

    def test_commands_of_the_readme_print_what_it_shows(self):
        text = (SOURCE / "README.md").read_text().split("\n## Mesh my polygon\n")[1]
        block = re.search(r"(?m)^(    \$ (?:.+\n)+)", text).group(1)
        lines = [line[4:] for line in block.splitlines()]
        commands, said = [], []
        for line in lines:
            if line.startswith("$ "):
                commands.append(line[2:])
            elif line.startswith(" "):
                commands[-1] += "\n" + line
            else:
                said.append(line)
        self.assertEqual(len(commands), 2)
        folder = self.folder / "readme"
        folder.mkdir()
        path = f"{self.prefix}/bin:{os.environ['PATH']}"
        printed = run("bash", "-ec", "\n".join(commands), cwd=folder,
                      env={**os.environ, "PATH": path}).splitlines()

        def untimed(rows):
            return [row for row in rows if not row.startswith("built in")]

        self.assertEqual(untimed(printed), untimed(said))
        self.assertTrue((folder / "plate.msh").exists() and (folder / "plate.svg").exists())

    def test_readers_and_writers_are_found_with_pkg_config(self):
        program = self.folder / "files.cc"
        program.write_text('#include "dynmesh/files.h"\n'
                           'int main() { return dynmesh::ReadInput("x.xyz").ok() ? 1 : 0; }\n')
        run(CXX, "-std=c++20", *WARNINGS, *self.pkg_config("--cflags", "dynmesh-files"), program,
            "-o", self.folder / "files", *self.pkg_config("--libs", "dynmesh-files"))
        run(self.folder / "files")

    def test_surfaces_are_mended_with_pkg_config(self):
        program = self.build_by_pkg_config("dynmesh-surfaces", "consumer_surfaces",
                                           CONSUMER / "surfaces.cc")
        self.assertEqual(run(program, self.crack()), CRACK_SAYS)

    def test_help_is_installed(self):
        self.assertIn(".SS \"dynmesh mesh\"",
                      (self.prefix / "share/man/man1/dynmesh.1").read_text())
        run("bash", "-n", self.prefix / "share/bash-completion/completions/dynmesh")

    def test_a_program_finds_it_with_pkg_config(self):
        self.assertEqual(self.pkg_config("--modversion", "dynmesh"), [version()])
        flags = self.pkg_config("--cflags", "dynmesh")
        self.assertFalse([word for word in flags if word[:2] not in ("-I", "-D")], flags)
        program = self.build_by_pkg_config("dynmesh", "consumer", CONSUMER / "main.cc")
        self.assertEqual(run(program).split(), [version(), expected_hash()])

    def test_a_program_in_c_is_built_with_pkg_config(self):
        path = next(self.prefix.rglob("dynmesh-c.pc")).parent
        flags = self.pkg_config("--cflags", "--libs", "dynmesh-c")
        program = self.folder / "crack"
        run("cc", "-std=c11", *WARNINGS, SOURCE / "tests/client/c/crack.c", "-o", program, *flags)
        said = run(program, env={**os.environ, "LD_LIBRARY_PATH": str(path.parent)})
        self.assertRegex(said, "^[0-9a-f]{32} ")

    def test_a_program_on_the_engine_is_built_with_pkg_config(self):
        program = self.build_by_pkg_config("dynmesh", "consumer_engine",
                                           SOURCE / "examples/maximum.cc")
        self.assertIn(ENGINE_SAYS, run(program))

    def test_a_client_finds_its_libraries_with_pkg_config(self):
        program = self.build_by_pkg_config("dynmesh-client", "consumer_client",
                                           CONSUMER / "client.cc")
        with Server(self.folder / "port2") as address:
            self.assertEqual(run(program, address).split(), [expected_hash()])

    @unittest.skipUnless(HAS_PYTHON, "built without the Python package")
    def test_the_python_package_works_from_any_prefix(self):
        prefix = self.folder / "python"
        run("cmake", "--install", BUILD, "--prefix", prefix, "--component", "python")
        folder = prefix / PYTHON_FOLDER
        self.assertEqual(run_python(folder),
                         [version(), version(), expected_hash(), f"{folder}/dynmesh/__init__.py"])

    def test_headers_include_what_is_installed(self):
        include = self.prefix / "include"
        headers = sorted(str(path.relative_to(include)) for path in include.rglob("*.h"))
        self.assertIn("dynmesh/client/mesh_client.h", headers)
        self.assertIn("dynmesh/version.h", headers)
        self.assertIn("dynmesh/sac/engine.h", headers)
        all_of_them = self.folder / "all.cc"
        all_of_them.write_text("".join(f'#include "{header}"\n' for header in headers))
        run(CXX, "-std=c++20", "-fsyntax-only", *WARNINGS, f"-I{include}", all_of_them)

    def configure_with(self, statements):
        """A project that does no more than `statements`."""
        project = self.folder / "statements"
        project.mkdir(exist_ok=True)
        (project / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.24)\nproject(statements LANGUAGES CXX)\n" + statements)
        run("cmake", "-G", "Ninja", "-S", project, "-B", project / "build",
            f"-DCMAKE_CXX_COMPILER={CXX}", f"-DCMAKE_PREFIX_PATH={self.prefix}")

    def test_a_wrong_version_is_refused(self):
        # The wrong ones first: what was found once stays.
        self.configure_with("".join(
            f"find_package(dynmesh {wanted} QUIET)\n"
            f'if(NOT "${{dynmesh_FOUND}}" STREQUAL {int(found)})\n'
            f'message(FATAL_ERROR "{wanted} found: ${{dynmesh_FOUND}}")\nendif()\n'
            for wanted, found in (("0.1", False), ("1.0", False), ("99", False),
                                  (version().rpartition(".")[0], True), (version(), True))
        ))

    def test_an_error_says_which_version_there_is(self):
        with self.assertRaises(AssertionError) as raised:
            self.configure_with("find_package(dynmesh 99 REQUIRED)\n")
        said = " ".join(str(raised.exception).split())
        self.assertIn('compatible with requested version "99"', said)
        self.assertRegex(said, rf"dynmesh-config\.cmake, version: {re.escape(version())}\b")

    def test_an_error_names_the_component_that_there_is_not(self):
        with self.assertRaisesRegex(AssertionError, r"without\s+the\s+component\s+surprise"):
            self.configure_with("find_package(dynmesh REQUIRED COMPONENTS surprise)\n")

    def test_the_unit_names_what_is_installed(self):
        unit = (self.prefix / "lib/systemd/system/dynmeshd.service").read_text()
        (command,) = re.findall(r"^ExecStart=(.*)$", unit, re.M)
        words = command.split()
        self.assertEqual(pathlib.Path(words[0]), self.prefix / "bin/dynmeshd")
        configuration = pathlib.Path(words[words.index("--config") + 1])
        self.assertEqual(configuration.read_text(), (SOURCE / "deploy/dynmeshd.conf").read_text())
        (document,) = re.findall(r"^Documentation=file:(.*)$", unit, re.M)
        self.assertTrue(pathlib.Path(document).exists(), document)

    def test_a_configuration_that_is_there_stays(self):
        prefix = self.folder / "again"
        for text in (None, "mine"):
            run("cmake", "--install", BUILD, "--prefix", prefix, "--component", "service")
            configuration = prefix / "etc/dynmesh/dynmeshd.conf"
            if text is None:
                configuration.write_text("mine")
        self.assertEqual(configuration.read_text(), "mine")


class Server:
    """A dynmeshd that keeps nothing, while the block lasts. Its value is the address."""

    def __init__(self, port_file):
        self.port_file = port_file

    def __enter__(self):
        self.process = subprocess.Popen(
            [BUILD / "bin/dynmeshd", "--listen", "127.0.0.1:0", "--port-file", self.port_file],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        until = time.monotonic() + 60
        while not self.port_file.exists():
            if self.process.poll() is not None:
                raise AssertionError("dynmeshd ended")
            if time.monotonic() > until:
                raise AssertionError("no server after 60 s")
            time.sleep(0.02)
        return f"127.0.0.1:{self.port_file.read_text().strip()}"

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(60)


class Subdirectory(Folder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.where = cls.folder / "build"
        configure(cls.where, f"-DDYNMESH_FOLDER={SOURCE}")
        cls.lines = compile_lines(cls.where)

    def test_flags_are_the_programs_own(self):
        words = self.lines[CONSUMER / "main.cc"]
        mine = [word for word in words if not word.startswith("-D")]
        self.assertEqual(mine, [f"-I{SOURCE}/core/include", *WARNINGS, "-std=gnu++20"])

    def test_the_programs_source_compiles(self):
        run("ninja", "-C", self.where, "CMakeFiles/consumer.dir/main.cc.o")

    def test_the_library_keeps_its_flags(self):
        for source, words in self.lines.items():
            if source.is_relative_to(SOURCE / "core"):
                self.assertLessEqual({"-ffp-contract=off", "-std=c++20"}, set(words))
                self.assertNotIn("-Werror", words)

    def test_it_is_not_compiled_with_fast_math(self):
        source = SOURCE / "core/geometry/predicates.cc"
        with self.assertRaisesRegex(AssertionError, "cannot be compiled with -ffast-math"):
            run(CXX, "-ffast-math", *self.lines[source], "-fsyntax-only", source)
        run(CXX, *self.lines[source], "-fsyntax-only", source)

    def test_there_is_the_library_and_no_more(self):
        precompiled = "cmake_pch.hxx.cxx"  # its headers are the system's
        parts = {
            source.relative_to(SOURCE).parts[:2] for source in self.lines
            if not source.is_relative_to(CONSUMER) and source.name != precompiled
        }
        self.assertEqual({part[0] for part in parts}, {"core"})
        self.assertNotIn(("core", "io"), parts)

    def test_it_installs_nothing(self):
        rules = (self.where / "dynmesh/cmake_install.cmake").read_text()
        self.assertNotIn("file(INSTALL", rules)
        self.assertFalse((self.where / "CPackConfig.cmake").exists())

    def test_no_variable_of_the_project_changes(self):
        def variables(file):
            text = (self.where / file).read_text()
            found = dict(re.findall(r"(?m)^(\w+)=(.*)$", text))
            return {name: found[name] for name in found if not re.match("ARG|file$", name)}

        before, after = variables("before.txt"), variables("after.txt")
        for name, value in before.items():
            self.assertEqual(after.get(name), value, name)
        # Options, and what find_package remembers.
        expected = r"DYNMESH_\w+|dynmesh_\w+|absl_DIR|CMAKE_HAVE_LIBC_PTHREAD|FIND_PACKAGE_\w+"
        new = [name for name in after.keys() - before if not re.fullmatch(expected, name)]
        self.assertEqual(new, [])


class Packages(Folder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # gzip: the packages are not kept, and xz takes half a minute.
        run("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", cls.folder,
            "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip", umask=0o022)
        cls.debs = {path.name.split("_")[0]: path for path in cls.folder.glob("*.deb")}

    def listing(self, package):
        """Modes and owners by name, folders left out."""
        rows = [line.split(maxsplit=5) for line in
                run("dpkg-deb", "-c", self.debs[package]).splitlines()]
        return {row[5].removeprefix("."): row[:2] for row in rows if row[0][0] != "d"}

    def field(self, package, name):
        return run("dpkg-deb", "-f", self.debs[package], name).strip()

    def test_there_is_one_for_each_purpose(self):
        self.assertEqual(set(self.debs), {"dynmesh", "libdynmesh-dev", "libdynmesh0",
                                          *(["python3-dynmesh"] if HAS_PYTHON else [])})
        for package in self.debs:
            self.assertEqual(self.field(package, "Version"), f"{version()}-1")

    def test_the_service_is_whole(self):
        files = self.listing("dynmesh")
        self.assertEqual(set(files), {
            "/etc/dynmesh/dynmeshd.conf",
            "/usr/share/man/man1/dynmesh.1", "/usr/share/bash-completion/completions/dynmesh",
            "/usr/bin/dynmesh",
            "/usr/bin/dynmeshd",
            "/usr/lib/systemd/system/dynmeshd.service",
            "/usr/share/doc/dynmesh/CHANGELOG.md",
            "/usr/share/doc/dynmesh/LICENSE",
            "/usr/share/doc/dynmesh/RUNBOOK.md",
            "/usr/share/doc/dynmesh/copyright",
            *(f"/usr/share/doc/dynmesh/copyright.lib{name}-dev"
              for name in ("absl", "c-ares", "grpc", "protobuf", "re2",
                           "stdc++-" + run(CXX, "-dumpversion").split(".")[0].strip())),
        })
        for name, (mode, owner) in files.items():
            self.assertEqual(mode, "-rwxr-xr-x" if "/bin/" in name else "-rw-r--r--", name)
            self.assertEqual(owner, "root/root", name)

    def test_its_libraries_are_named(self):
        depends = self.field("dynmesh", "Depends")
        for package in ("libc6", "libgrpc++1.51", "libsqlite3-0", "libabsl20220623", "passwd"):
            self.assertIn(package, re.findall(r"[^\s,(]+", depends))

    @unittest.skipUnless(HAS_PYTHON, "built without the Python package")
    def test_the_python_package_is_whole(self):
        files = self.listing("python3-dynmesh")
        folder = f"/usr/{PYTHON_FOLDER}"
        package = SOURCE / "client/python/dynmesh"
        sources = {path.relative_to(package).as_posix() for path in package.rglob("*.py*")
                   if path.is_file() and "__pycache__" not in path.parts} | {"py.typed"}
        modules = sorted(name for name in files if name.endswith(".so"))
        self.assertEqual(len(modules), 2)
        for module, name in zip(modules, ("_core", "_service")):
            self.assertRegex(module, rf"^{folder}/dynmesh/{name}\.cpython-\d+-[a-z0-9_-]+\.so$")
        self.assertEqual(set(files), {
            *modules,
            *(f"{folder}/dynmesh/{name}" for name in sources),
            f"{folder}/dynmesh-{version()}.dist-info/METADATA",
            "/usr/share/doc/python3-dynmesh/CHANGELOG.md",
            "/usr/share/doc/python3-dynmesh/LICENSE",
            "/usr/share/doc/python3-dynmesh/copyright",
        })
        for name, (mode, owner) in files.items():
            self.assertEqual((mode, owner), ("-rw-r--r--", "root/root"), name)
        depends = self.field("python3-dynmesh", "Depends")
        for package in ("libc6", "libgrpc++1.51", "libprotobuf32", "libabsl20220623",
                        "python3-numpy"):
            self.assertIn(package, re.findall(r"[^\s,(]+", depends))
        python = f"{sys.version_info.major}.{sys.version_info.minor}"
        next_python = f"{sys.version_info.major}.{sys.version_info.minor + 1}"
        self.assertIn(f"python3 (>= {python})", depends)
        self.assertIn(f"python3 (<< {next_python})", depends)
        self.assertEqual(self.field("python3-dynmesh", "Recommends"), "python3-meshio")

    @unittest.skipUnless(HAS_PYTHON, "built without the Python package")
    def test_the_python_package_works(self):
        root = self.folder / "python"
        run("dpkg-deb", "-x", self.debs["python3-dynmesh"], root)
        folder = root / "usr" / PYTHON_FOLDER
        self.assertEqual(run_python(folder),
                         [version(), version(), expected_hash(), f"{folder}/dynmesh/__init__.py"])

    @unittest.skipUnless(HAS_PYTHON, "built without the Python package")
    def test_the_python_packages_scripts_are_there(self):
        control = self.folder / "python_control"
        run("dpkg-deb", "-e", self.debs["python3-dynmesh"], control)
        for script in ("postinst", "prerm"):
            self.assertTrue(os.access(control / script, os.X_OK), script)

    def test_the_unit_names_files_of_the_package(self):
        unit = run("sh", "-c", 'dpkg-deb --fsys-tarfile "$1" | tar -xO "$2"', "sh",
                   self.debs["dynmesh"], "./usr/lib/systemd/system/dynmeshd.service")
        self.assertIn("ExecStart=/usr/bin/dynmeshd --config /etc/dynmesh/dynmeshd.conf ", unit)
        self.assertIn("Documentation=file:/usr/share/doc/dynmesh/RUNBOOK.md", unit)
        self.assertNotIn("/usr/local", unit)

    def test_its_scripts_are_there(self):
        control = self.folder / "control"
        run("dpkg-deb", "-e", self.debs["dynmesh"], control)
        for script in ("postinst", "prerm", "postrm"):
            self.assertTrue(os.access(control / script, os.X_OK), script)
        self.assertEqual((control / "conffiles").read_text(), "/etc/dynmesh/dynmeshd.conf\n")

    def test_the_library_is_whole(self):
        files = set(self.listing("libdynmesh-dev"))
        include = {str(path.relative_to(root)) for root in
                   (SOURCE / folder for folder in FOLDERS)
                   for path in root.rglob("*.h")}
        engine = [path for folder in ("core/sac", "core/base") for path in
                  (SOURCE / folder).glob("*.h")
                  if folder == "core/sac" or path.name in ("huge_pages.h", "large_vector.h")]
        include |= {f"dynmesh/sac/{path.name}" for path in engine}
        self.assertEqual(
            {name for name in files if name.endswith(".h")},
            {f"/usr/include/{name}" for name in {*include, "dynmesh.h"}},
        )
        tails = {re.sub(r"^/usr/lib(/[^/]+-linux-gnu)?/", "", name) for name in files}
        self.assertLessEqual({
            "libdynmesh.a", "libdynmesh_client.a", "libdynmesh_files.a", "libdynmesh_surfaces.a",
            "cmake/dynmesh/dynmesh-config.cmake",
            "cmake/dynmesh/dynmesh-config-version.cmake", "cmake/dynmesh/dynmesh-targets.cmake",
            "pkgconfig/dynmesh.pc", "pkgconfig/dynmesh-client.pc", "pkgconfig/dynmesh-files.pc",
            "pkgconfig/dynmesh-surfaces.pc",
            "pkgconfig/dynmesh-c.pc",
        }, tails)
        self.assertFalse([name for name in files if "/bin/" in name or "journal" in name])
        depends = self.field("libdynmesh-dev", "Depends")
        self.assertIn("libabsl-dev", depends)
        self.assertIn(f"libdynmesh0 (= {version()}-1)", depends)

    def test_the_library_for_c_needs_the_c_library(self):
        files = self.listing("libdynmesh0")
        (link,) = [name for name in files if "/libdynmesh.so.0 -> " in name]
        library, _, target = link.partition(" -> ")
        self.assertEqual(files[library.rsplit("/", 1)[0] + "/" + target][0], "-rw-r--r--")
        self.assertIn("/usr/share/doc/libdynmesh0/copyright.libabsl-dev", files)
        self.assertTrue([name for name in files if "/copyright.libstdc++-" in name])
        self.assertRegex(self.field("libdynmesh0", "Depends"), r"^libc6 \(>= [0-9.]+\)$")


if __name__ == "__main__":
    absent = [tool for tool in TOOLS[sys.argv[3]] if shutil.which(tool) is None]
    if absent:
        print(f"package_test: not run: not installed: {', '.join(absent)}")
        sys.exit(NOT_RUN)
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
