"""Fields are used with their locks held: clang's `-Wthread-safety`, over all sources with locks.

    locks_test.py SOURCE BUILD

The locks are those of core/base/mutex.h, the annotations Abseil's. A source is checked with the
options that BUILD/compile_commands.json has for it; no code is made. The sources with the same
options are read as one, so that their headers are read once. If clang has something against them,
the sources of each target are read as one: a unity build does so, and names are unique there. All
sources of server, client and core that include that header, themselves or through others, have to be
in the build, and there may be no lock that the check does not see.

The check is checked first: clang has to refuse a field that is read without its lock. Ends with 77,
skipped, where there is no clang.
"""

import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

CLANG = ("clang++-14", "clang++")
ROOTS = ("server", "client", "core")
HEADER = "core/base/mutex.h"
INCLUDE = re.compile(r'^ *# *include [<"]([^">]+)[">]', re.MULTILINE)
UNSEEN = re.compile(
    r"\bstd::((recursive_|shared_|timed_)*mutex|condition_variable|lock_guard|unique_lock"
    r"|scoped_lock|shared_lock)\b|\babsl::Mutex\b"
)
# Options of a compile command that name its outputs or are g++'s; those with an argument first.
WITH_ARGUMENT = ("-include", "-o", "-c")
CHECK = (
    "-fsyntax-only",
    "-Wno-everything",
    "-Wthread-safety",
    "-Wthread-safety-beta",  # the order of locks
    "-Werror",
)
# Parts that a build may lack, with the libraries that they need.
OPTIONAL = ("server/journal/postgres", "server/journal/open_postgres", "client/python/")
Options = tuple[str, ...]
FAULT = """
#include "core/base/mutex.h"
struct Counter {
  int Read() { return count; }
  dynmesh::Mutex mutex;
  int count ABSL_GUARDED_BY(mutex) = 0;
};
int main() { return Counter().Read(); }
"""


def options_of(command: str) -> tuple[str, ...]:
    """What decides how a source is read: macros, folders of headers, the language."""
    kept = []
    words = iter(shlex.split(command)[1:])
    for word in words:
        if word in WITH_ARGUMENT:
            next(words)
        elif word in ("-isystem", "-I", "-D"):
            kept += [word, next(words)]
        elif word.startswith(("-I", "-D", "-std=", "-pthread")):
            kept.append(word)
    return tuple(kept)


def target_of(command: str) -> str:
    """The CMake target that a compile command belongs to."""
    found = re.search(r" -o (?:\S*/)?CMakeFiles/([^/ ]+)\.dir/", command)
    return found[1] if found else ""


def sources_of(file: pathlib.Path) -> list[pathlib.Path]:
    """The project's sources in a file that is compiled: itself, or what a unity build joins."""
    if "Unity" not in file.parts:
        return [file]
    return [pathlib.Path(name) for name in INCLUDE.findall(file.read_text(encoding="utf-8"))]


class Sources:
    """Which sources include the header of the locks."""

    def __init__(self, root: pathlib.Path) -> None:
        self._root = root
        self._sees: dict[str, bool] = {HEADER: True}

    def see_a_lock(self, name: str) -> bool:
        """True if the file, from the root, includes the header, also through others."""
        if name not in self._sees:
            self._sees[name] = False  # while its own includes are looked at
            path = self._root / name
            includes = INCLUDE.findall(path.read_text(encoding="utf-8")) if path.is_file() else []
            self._sees[name] = any(self.see_a_lock(include) for include in includes)
        return self._sees[name]


def units(
    root: pathlib.Path, build: pathlib.Path, seen: Sources
) -> dict[Options, dict[str, list[str]]]:
    """The sources that see a lock, by options and target."""
    found: dict[Options, dict[str, list[str]]] = {}
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    for entry in commands:
        file = pathlib.Path(entry["directory"], entry["file"])
        if "cmake_pch" in file.name or not file.is_file():
            continue
        targets = found.setdefault(options_of(entry["command"]), {})
        for source in sources_of(file):
            name = os.path.relpath(source, root)
            if name.startswith(ROOTS) and seen.see_a_lock(name):
                targets.setdefault(target_of(entry["command"]), []).append(name)
    return {options: targets for options, targets in found.items() if targets}


def refused(clang: str, options: tuple[str, ...], text: str, root: pathlib.Path) -> str:
    """What clang has against the text; empty: nothing."""
    with tempfile.NamedTemporaryFile("w", suffix=".cc", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        command = [clang, *CHECK, *options, file.name]
        done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    return done.stderr or ("clang failed" if done.returncode else "")


def check_the_check(clang: str, root: pathlib.Path) -> None:
    """A field that is read without its lock is noticed, with the lock it is fine."""
    options = (f"-I{root}", "-std=c++20")
    assert "requires holding mutex" in refused(clang, options, FAULT, root)
    locked = FAULT.replace("{ return count", "{ dynmesh::MutexLock lock(mutex); return count")
    assert not refused(clang, options, locked, root)
    assert unseen_locks({"a.cc": "std::mutex mutex_;  // std::mutex"}) == [
        f"a.cc:1: std::mutex mutex_;  // std::mutex (use {HEADER})"
    ]


def unseen_locks(texts: dict[str, str]) -> list[str]:
    """Lines with a lock that has no annotations."""
    return [
        f"{name}:{number}: {line.strip()} (use {HEADER})"
        for name, text in texts.items()
        if name != HEADER
        for number, line in enumerate(text.splitlines(), 1)
        if UNSEEN.search(line.split("//")[0])
    ]


def faults(clang: str, root: pathlib.Path, build: pathlib.Path, names: list[str]) -> list[str]:
    """What clang has against the sources, and those that are not in the build."""
    seen = Sources(root)
    groups = units(root, build, seen)
    checked = {name for targets in groups.values() for group in targets.values() for name in group}
    found = [
        f"{name} is in no target of {build}"
        for name in names
        if name.endswith(".cc") and seen.see_a_lock(name) and name not in checked
        if not name.startswith(OPTIONAL)
    ]

    def read(options: Options, group: list[str]) -> str:
        return refused(clang, options, "".join(f'#include "{root / n}"\n' for n in group), root)

    def check(item: tuple[Options, dict[str, list[str]]]) -> str:
        options, targets = item
        said = read(options, sum(targets.values(), []))
        if not said or len(targets) == 1:
            return said
        alone = "".join(read(options, group) for group in targets.values())
        if not alone:
            print(f"{len(targets)} targets are read one by one, which takes longer:\n{said[:400]}")
        return alone

    def size(item: tuple[Options, dict[str, list[str]]]) -> int:
        return sum(map(len, item[1].values()))

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        largest_first = sorted(groups.items(), key=size, reverse=True)
        found += [said for said in pool.map(check, largest_first) if said]
    print(f"{len(checked)} sources with {len(groups)} sets of options")
    return found


def main() -> int:
    """1 if a lock is missing somewhere, 77 without clang."""
    root, build = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    names = sorted(
        str(path.relative_to(root))
        for top in ROOTS
        for path in (root / top).rglob("*")
        if path.suffix in (".h", ".cc")
    )
    found = unseen_locks({name: (root / name).read_text(encoding="utf-8") for name in names})
    clang = next((path for name in CLANG if (path := shutil.which(name))), None)
    if clang is None and not found:
        print("no clang: deploy/install-packages locks")
        return 77
    if clang is not None:
        check_the_check(clang, root)
        found += faults(clang, root, build, names)
    print("\n".join(found) or "every field is used with its lock held")
    return min(len(found), 1)


if __name__ == "__main__":
    sys.exit(main())
