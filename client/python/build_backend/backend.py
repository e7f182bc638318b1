"""Makes a wheel: the extension module by CMake, and the package's sources (PEP 517, PEP 427)."""
from __future__ import annotations

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import zipfile

_PACKAGE = pathlib.Path(__file__).resolve().parent.parent
_SOURCE = _PACKAGE.parent.parent


def _version() -> str:
    text = (_SOURCE / "core/include/dynmesh/version.h").read_text()
    parts = dict(re.findall(r"DYNMESH_VERSION_(MAJOR|MINOR|PATCH)\s+(\d+)", text))
    return f"{parts['MAJOR']}.{parts['MINOR']}.{parts['PATCH']}"


def _tag() -> str:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"{python}-{python}-{platform}"


def _metadata() -> dict[str, str]:
    folder = f"dynmesh-{_version()}.dist-info"
    return {
        f"{folder}/METADATA":
            (_PACKAGE / "METADATA.in").read_text().replace("@PROJECT_VERSION@", _version()),
        f"{folder}/WHEEL": "\n".join([
            "Wheel-Version: 1.0", "Generator: dynmesh", "Root-Is-Purelib: false",
            f"Tag: {_tag()}", ""]),
    }


def _build() -> pathlib.Path:
    """The folder with the built package."""
    tree = _SOURCE / "build" / f"wheel-{_tag()}"
    jobs = os.environ.get("DYNMESH_JOBS", str(os.cpu_count() or 1))
    subprocess.run(
        ["cmake", "-S", _SOURCE, "-B", tree, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
         "-DDYNMESH_TESTS=OFF", "-DDYNMESH_BENCHMARKS=OFF", "-DDYNMESH_INSTALL=OFF",
         f"-DPython3_EXECUTABLE={sys.executable}"], check=True)
    subprocess.run(["cmake", "--build", tree, "-j", jobs, "--target", "dynmesh_python"], check=True)
    return tree / "python" / "dynmesh"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    package = _build()
    files = {f"dynmesh/{path.relative_to(package).as_posix()}": path.read_bytes()
             for path in sorted(package.rglob("*"))
             if path.is_file() and "__pycache__" not in path.parts}
    files.update({name: text.encode() for name, text in _metadata().items()})
    record = f"dynmesh-{_version()}.dist-info/RECORD"
    lines = []
    for name, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{name},sha256={digest},{len(data)}")
    files[record] = "\n".join([*lines, f"{record},,", ""]).encode()
    wheel = f"dynmesh-{_version()}-{_tag()}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as out:
        for name, data in files.items():
            out.writestr(name, data)
    return wheel


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    for name, text in _metadata().items():
        path = pathlib.Path(metadata_directory) / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return f"dynmesh-{_version()}.dist-info"


def get_requires_for_build_wheel(config_settings=None):
    return []
