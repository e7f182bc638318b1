"""Makes wheels and the source distribution (PEP 517, 427, 625).

    python3 backend.py wheel OUT [TREE]     # TREE: a build that has the target dynmesh_wheel
    python3 backend.py sdist OUT

A wheel has the extension module, the command `dynmesh` without what uses a server, the package's
sources and the licences of what is linked. Its tag says which C library it needs, by the symbols.
`pip install` of a clone makes another one: with the client of a server, linked with the libraries
of this machine.
"""
from __future__ import annotations

import base64
import gzip
import hashlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile
from typing import Any, Iterator, Optional, Union

_PACKAGE = pathlib.Path(__file__).resolve().parent.parent
_SOURCE = _PACKAGE.parent.parent
_SOURCES = ("*.py", "*.pyi", "py.typed")
# What a source distribution has, from the root: folders and files.
_SHIPPED = ("CMakeLists.txt", "LICENSE", "README.md", "CHANGELOG.md", "cmake", "core",
            "client/CMakeLists.txt", "client/cleaning", "client/cli", "client/preparation",
            "client/python", "client/verify")
_PROTOCOL = ("geometry", "mesh", "mesh_service", "status_details")
_NOT_SHIPPED = ("client/cli/remote",)
# Debian's packages with what is inside the binaries: their file `copyright` is the licence. Of the
# compiler's own library: COMPILER is the first number of its version.
_LINKED = ("libabsl-dev", "libboost-dev", "libcgal-dev", "libcli11-dev", "libgmp-dev",
           "libstdc++-COMPILER-dev", "nlohmann-json3-dev", "pybind11-dev", "zlib1g-dev")
_TEXTS = ("GPL-3", "LGPL-3")  # which these name, in /usr/share/common-licenses
# Libraries that every system has on which a `manylinux` wheel may be installed (PEP 600). The C++
# library is one of them, too, but of which version is not looked at here; so it has to be inside.
_OF_THE_SYSTEM = re.compile(r"(lib(c|m|dl|rt|pthread|z|gcc_s)|ld-linux-x86-64)\.so\.\d+")
_RELATIVE = "GLIBC_ABI_DT_RELR"  # packed relocations: glibc has them
_SINCE = 36  # from this minor version on
_EPOCH = 315532800  # 1980, where zip begins

Files = dict[str, Union[bytes, pathlib.Path]]


def version() -> str:
    """That of version.h."""
    text = (_SOURCE / "core/include/dynmesh/version.h").read_text()
    parts = dict(re.findall(r"DYNMESH_VERSION_(MAJOR|MINOR|PATCH)\s+(\d+)", text))
    return f"{parts['MAJOR']}.{parts['MINOR']}.{parts['PATCH']}"


def _said(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def platform_of(binaries: list[pathlib.Path]) -> str:
    """manylinux_2_N_MACHINE with the least N that has all symbols; else linux_MACHINE."""
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    newest = 17  # the first one with that name
    for binary in binaries:
        dynamic = _said("readelf", "-dW", str(binary))
        for library in re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic):
            if not _OF_THE_SYSTEM.fullmatch(library):
                return platform
        symbols = _said("readelf", "-VW", str(binary))
        if _RELATIVE in symbols:
            newest = max(newest, _SINCE)
        for minor in re.findall(r"\bGLIBC_2\.(\d+)\b", symbols):
            newest = max(newest, int(minor))
    return platform.replace("linux", f"manylinux_2_{newest}", 1)


def _metadata() -> str:
    return (_PACKAGE / "METADATA.in").read_text().replace("@PROJECT_VERSION@", version())


def _compiler() -> str:
    return _said(os.environ.get("CXX", "c++"), "-dumpversion").split(".")[0].strip()


def _licences() -> Files:
    """By name; of libraries that are not Debian's, there is none to be found."""
    files: Files = {"dynmesh/LICENSE": _SOURCE / "LICENSE"}
    for package in _LINKED:
        package = package.replace("COMPILER", _compiler())
        text = pathlib.Path("/usr/share/doc") / package / "copyright"
        if text.exists():
            files[f"{package}/copyright"] = text
    for name in _TEXTS:
        text = pathlib.Path("/usr/share/common-licenses") / name
        if text.exists():
            files[name] = text
    return files


def _has_service() -> bool:
    """A clone has the protocol, a source distribution has not."""
    return (_SOURCE / "proto/CMakeLists.txt").exists()


def _configure_and_build(service: bool) -> pathlib.Path:
    tree = _SOURCE / "build" / ("wheel-service" if service else "wheel")
    jobs = os.environ.get("DYNMESH_JOBS", str(os.cpu_count() or 1))
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    subprocess.run(
        ["cmake", "-S", str(_SOURCE), "-B", str(tree), *generator, "-DCMAKE_BUILD_TYPE=Release",
         "-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=16", "-DDYNMESH_WERROR=OFF",
         f"-DDYNMESH_SERVICE={'ON' if service else 'OFF'}", "-DDYNMESH_FILES=ON",
         "-DDYNMESH_SURFACES=OFF", "-DDYNMESH_PYTHON=ON", "-DDYNMESH_C=OFF", "-DDYNMESH_TESTS=OFF",
         "-DDYNMESH_BENCHMARKS=OFF", "-DDYNMESH_INSTALL=OFF",
         f"-DPython3_EXECUTABLE={sys.executable}"], check=True)
    subprocess.run(["cmake", "--build", str(tree), "-j", jobs, "--target",
                    "dynmesh_python" if service else "dynmesh_wheel"], check=True)
    return tree


def _sources() -> Iterator[pathlib.Path]:
    for pattern in _SOURCES:
        yield from (_PACKAGE / "dynmesh").rglob(pattern)


def _messages() -> Files:
    """The protocol in Python, by names below the package. A source distribution has it already."""
    if not _has_service():
        return {}
    with tempfile.TemporaryDirectory() as out:
        subprocess.run(
            ["protoc", f"--python_out={out}", "-I", str(_SOURCE / "proto"),
             *(f"dynmesh/v1/{name}.proto" for name in _PROTOCOL)], check=True)
        return {f"v1/{path.name}": path.read_bytes()
                for path in sorted((pathlib.Path(out) / "dynmesh/v1").glob("*.py"))}


def _written(folder: pathlib.Path, name: str, files: Files, programs: list[str]) -> None:
    """A wheel `name` of files by their names in it, with its RECORD."""
    info = f"dynmesh-{version()}.dist-info"
    lines = []
    contents = {}
    for path, source in files.items():
        data = source if isinstance(source, bytes) else source.read_bytes()
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{path},sha256={digest},{len(data)}")
        contents[path] = data
    contents[f"{info}/RECORD"] = "\n".join([*lines, f"{info}/RECORD,,", ""]).encode()
    with zipfile.ZipFile(folder / name, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
        for path, data in contents.items():
            entry = zipfile.ZipInfo(path)  # of 1980: the same files are the same wheel
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if path in programs else 0o100644) << 16
            out.writestr(entry, data)


def _wheel(folder: pathlib.Path, tree: pathlib.Path, service: bool) -> str:
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    modules = [tree / "wheel/dynmesh" / f"_core{suffix}"]
    if service or not modules[0].exists():  # with the libraries of this machine
        modules = [tree / "python/dynmesh" / f"_core{suffix}"]
    if service:
        modules.append(tree / "python/dynmesh" / f"_service{suffix}")
    command = tree / "wheel/bin/dynmesh"
    binaries = [*modules, *([command] if command.exists() else [])]
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{platform_of(binaries)}"
    info = f"dynmesh-{version()}.dist-info"
    package = _PACKAGE / "dynmesh"
    files: Files = {f"dynmesh/{path.relative_to(package).as_posix()}": path
                    for path in sorted(_sources())}
    files.update({f"dynmesh/{module.name}": module for module in modules})
    files.update({f"dynmesh/{name}": text for name, text in _messages().items()})
    script = f"dynmesh-{version()}.data/scripts/dynmesh"
    if command.exists():
        files[script] = command
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = "\n".join([
        "Wheel-Version: 1.0", f"Generator: dynmesh ({version()})", "Root-Is-Purelib: false",
        f"Tag: {tag}", ""]).encode()
    files.update({f"{info}/licenses/{name}": text for name, text in _licences().items()})
    name = f"dynmesh-{version()}-{tag}.whl"
    _written(folder, name, files, [script, *(f"dynmesh/{module.name}" for module in modules)])
    return name


def build_wheel(wheel_directory: str, config_settings: Any = None,
                metadata_directory: Optional[str] = None) -> str:
    """PEP 517. The build is in build/wheel...; what was built before stays."""
    service = _has_service()
    return _wheel(pathlib.Path(wheel_directory), _configure_and_build(service), service)


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: Any = None) -> str:
    """PEP 517."""
    info = pathlib.Path(metadata_directory) / f"dynmesh-{version()}.dist-info"
    info.mkdir(exist_ok=True)
    (info / "METADATA").write_text(_metadata())
    return info.name


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    """PEP 517: nothing that pip would have to fetch."""
    return []


def _shipped() -> Iterator[str]:
    for name in _SHIPPED:
        path = _SOURCE / name
        for file in [path] if path.is_file() else sorted(path.rglob("*")):
            where = file.relative_to(_SOURCE).as_posix()
            if file.is_file() and "__pycache__" not in where and \
                    not where.startswith(tuple(f"{folder}/" for folder in _NOT_SHIPPED)):
                yield where


def build_sdist(sdist_directory: str, config_settings: Any = None) -> str:
    """PEP 517. Its pyproject.toml is at its root, so it names the backend from there."""
    root = f"dynmesh-{version()}"
    project = (_PACKAGE / "pyproject.toml").read_text()
    project = project.replace('["build_backend"]', '["client/python/build_backend"]')
    project = project[:project.index("[tool.")].rstrip() + "\n"
    contents = {name: (_SOURCE / name).read_bytes() for name in _shipped()}
    contents.update({f"client/python/dynmesh/{name}": text if isinstance(text, bytes) else
                     text.read_bytes() for name, text in _messages().items()})
    contents.update({"pyproject.toml": project.encode(), "PKG-INFO": _metadata().encode()})
    name = f"{root}.tar.gz"
    unpacked = io.BytesIO()
    with tarfile.open(mode="w", fileobj=unpacked, format=tarfile.PAX_FORMAT) as out:
        for path, data in sorted(contents.items()):
            entry = tarfile.TarInfo(f"{root}/{path}")
            entry.size, entry.mtime = len(data), _EPOCH
            is_program = os.access(_SOURCE / path, os.X_OK)
            entry.mode = 0o755 if is_program else 0o644
            out.addfile(entry, io.BytesIO(data))
    packed = gzip.compress(unpacked.getvalue(), mtime=_EPOCH)
    (pathlib.Path(sdist_directory) / name).write_bytes(packed)
    return name


def main(arguments: list[str]) -> int:
    """Prints the path of what was made."""
    if len(arguments) < 2 or arguments[0] not in ("wheel", "sdist"):
        print(__doc__, file=sys.stderr)
        return 2
    out = pathlib.Path(arguments[1])
    out.mkdir(parents=True, exist_ok=True)
    if arguments[0] == "sdist":
        print(out / build_sdist(str(out)))
    else:
        tree = pathlib.Path(arguments[2]) if len(arguments) > 2 else _configure_and_build(False)
        print(out / _wheel(out, tree, False))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
