"""Random tests can be repeated: only tests/support/seed.h draws a seed, so all obey
DYNMESH_TEST_SEED.
"""

import pathlib
import sys

HOME = "tests/support/seed.h"


def problems(name: str, text: str) -> list[str]:
    """The lines of the text that draw a seed of their own, with their places."""
    return [
        f"{name}:{number}: {line.strip()} (use NewSeed of {HOME})"
        for number, line in enumerate(text.splitlines(), 1)
        if "random_device" in line and name != HOME
    ]


def main() -> int:
    """1 if a test draws a seed of its own."""
    root = pathlib.Path(sys.argv[1])
    assert problems("tests/a_test.cc", "\nstd::random_device r;\n")[0].startswith("tests/a_test.cc:2")
    assert "random_device" in (root / HOME).read_text(encoding="utf-8")
    found = []
    for path in sorted((root / "tests").rglob("*")):
        if path.suffix in (".cc", ".h"):
            name = str(path.relative_to(root))
            found += problems(name, path.read_text(encoding="utf-8"))
    print("\n".join(found) or "no test draws a seed of its own")
    return min(len(found), 1)


if __name__ == "__main__":
    sys.exit(main())
